"""How fitted unknowns are told: values with intervals, the blocks of the entry, and what is drawn."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cutwise import units
from cutwise.study.calibrate.posed import Fit, FloatArray, Posed, Value


def plain(fit: Fit, k: int, **more: Any) -> Value:
    """An unknown whose errors are normal as it is."""
    x, se = float(fit.x[k]), float(fit.standard_errors[k])
    half = fit.quantile * se
    ends: tuple[float | None, float | None] = (x - half, x + half) if np.isfinite(half) else (None, None)
    unknown = fit.posed.unknowns[k]
    return Value(unknown.name, unknown.dimension, x, se, *ends, fit.verdicts[k], unknown.deciding, **more)


def written(values: Sequence[Value], covariance: str, rows: int) -> dict[str, Any]:
    """Blocks of the entry for values that are keys of their own."""
    return {
        value.name: {
            "value": quantity(value.value, value.dimension),
            "standard_error": quantity(value.standard_error, value.dimension),
            "status": "measured",
            "covariance": covariance,
            "source": f"{{file}}, {rows} rows",
        }
        for value in values
    }


def quantity(value: float, dimension: str) -> str | float:
    """As an entry holds it."""
    return float(value) if dimension == "dimensionless" else units.text(value, dimension)


def covariance_block(
    fit: Fit, names: Sequence[str], dimensions: Sequence[str], scales: Sequence[float] | None = None
) -> dict[str, Any]:
    """Covariance of values that are the unknowns times scales; its units are those of the values, one by one."""
    scale = np.ones(len(names)) if scales is None else np.array(scales)
    matrix = fit.covariance[: len(names), : len(names)] * np.outer(scale, scale)
    return {
        "of": list(names), "as": "value", "degrees_of_freedom": fit.degrees_of_freedom, "matrix": matrix.tolist(),
        "unit": [units.DIMENSIONS[dimension].si for dimension in dimensions],
    }  # fmt: skip


def drawn(posed: Posed, residual: FloatArray) -> tuple[tuple[str, str, FloatArray, FloatArray], ...]:
    """Measured and modelled values by column, in the order of the rows."""
    found = []
    for k, (name, dimension) in enumerate(zip(posed.columns, posed.dimensions, strict=True)):
        own = posed.column == k
        found.append((name, dimension, posed.measured[own], posed.measured[own] - residual[own]))
    return tuple(found)


def rms(values: FloatArray) -> float | None:
    """Of those that are numbers; None if none is."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else None


def unknown_combinations(fit: Fit) -> tuple[dict[str, float], ...]:
    """Directions that the data do not determine, entries above 0.2."""
    return tuple(
        {name: float(v) for name, v in zip(fit.posed.names, vector, strict=True) if abs(v) > 0.2}
        for vector in fit.null.T
    )


def poorly_seen(fit: Fit) -> tuple[str, ...]:
    """What the condition says in words."""
    said = [
        f"the data do not determine {_sum(combination)} (of the scaled parameters); what is known of it beforehand can be "
        f"given: {_offer(fit, combination)}"
        for combination in map(dict, unknown_combinations(fit))
    ]
    said += fit.prior
    if fit.poorly_seen:
        said.append(
            f"{_sum(dict(fit.poorly_seen))} is poorly seen: condition {fit.condition:.3g} of the scaled Jacobian; what is "
            f"known of it beforehand can be given: {_offer(fit, dict(fit.poorly_seen))}"
        )
    return tuple(said)


def _offer(fit: Fit, combination: Mapping[str, float]) -> str:
    """How a prior of the parameter with the largest share would be written: value and standard deviation."""
    name = max(combination, key=lambda one: abs(combination[one]), default=fit.posed.names[0])
    unknown = fit.posed.unknowns[fit.posed.names.index(name)]
    place = fit.posed.names.index(name)
    found = 0.0 if fit.undetermined[place] and unknown.zero_scale else float(fit.x[place])  # a value without basis
    value, dimension = found or unknown.zero_scale or 1.0, unknown.dimension
    if dimension == "angular_compliance" and value > 0.0:  # a spring is known by its stiffness
        value, dimension = 1.0 / value, "angular_stiffness"
    ends = [units.text(float(f"{end:.3g}"), dimension) for end in (value, abs(value) / 3.0)]
    return f"--set fit.prior='{{\"{name}\": [{', '.join(ends)}]}}' (value, standard deviation)"


def _sum(combination: Mapping[str, float]) -> str:
    return " ".join(f"{value:+.2f} {name}" for name, value in combination.items())
