r"""Piston force and seal friction of a compliant spindle from slow travel through its centre.

.. math:: F = g (A p \pm F_d \kappa), \quad g (A p \pm F_s \kappa), \qquad
          g = \frac{l_p}{L_t} \frac{n}{\pi}, \quad \kappa = \alpha + (1 - \alpha) \frac{p}{p_\mathrm{ref}}

Only g A, g F_d and g F_s are measured: the lever :math:`l_p/L_t` comes from the drawing.
"""

import math

import numpy as np

from cutwise import units
from cutwise.io.measurements import Channel, Measurement
from cutwise.spec.calibration import SealTravel
from cutwise.spec.faults import ScenarioFault
from cutwise.study.calibrate.arm import folds
from cutwise.study.calibrate.fit import fitted
from cutwise.study.calibrate.posed import Finding, FloatArray, Posed, Unknown
from cutwise.study.calibrate.told import covariance_block, drawn, plain, poorly_seen, rms, unknown_combinations, written

COLUMNS = ("loading_plateau", "unloading_plateau", "breakaway", "return_breakaway")
_SIGN = np.array([1.0, -1.0, 1.0, -1.0])
_STATIC = np.array([False, False, True, True])


def channels(_settings: SealTravel | None) -> tuple[Channel, ...]:
    """Columns of the forces at the tip."""
    hint = "is more than 100 bar; is the unit right?"
    return (Channel("pressure", "pressure", True, 1e7, hint, "bar"), *(Channel(name, "force") for name in COLUMNS))


def lever(settings: SealTravel) -> float:
    """g: force at the tip per force of a piston."""
    spindle = settings.spindle
    return spindle.piston_arm / spindle.tool_reach * spindle.pistons / math.pi


def calibrate(data: Measurement, settings: SealTravel) -> Finding:
    """Fit A, F_s, F_d and the share of the friction that is there without pressure."""
    pressure, forces = data.columns["pressure"], data.matrix(COLUMNS)
    _checked(data, pressure, forces)
    fit = fitted(_posed(pressure, forces, settings), loss=settings.fit.loss, level=settings.fit.level,
                 folds=folds(settings.fit.hold_out, data.rows))  # fmt: skip
    values = tuple(plain(fit, k) for k in range(4))
    reference = settings.spindle.reference_pressure
    keys = ("piston_force", "friction_static", "friction_dynamic", "friction_preload_fraction")
    dimensions = ("force", "force", "force", "dimensionless")
    scales = (reference, 1.0, 1.0, 1.0)
    block = written(
        [value._replace(name=key, dimension=dimension, value=value.value * scale, standard_error=value.standard_error * scale)
         for value, key, dimension, scale in zip(values, keys, dimensions, scales, strict=True)], "seals", data.rows,
    )  # fmt: skip
    block["reference_pressure"] = {
        "value": units.text(reference, "pressure"), "status": "user", "source": "given with the calibration of {file}",
    }  # fmt: skip
    failed = tuple(f"{value.name} is negative" for value in values[:3] if value.value < 0.0)
    one = len(np.unique(pressure)) < 2
    lever_of = (
        f"{units.show(settings.spindle.piston_arm, 'length')} / {units.show(settings.spindle.tool_reach, 'length')}"
    )
    return Finding(
        "seals", values, block, {"seals": covariance_block(fit, keys, dimensions, scales)}, fit.scale, "force", rms(fit.left_out),
        "rms of the forces", "force", fit, drawn(fit.posed, fit.residual), (),
        tuple(f"{text}; written as it is" for text in failed),
        (f"the lever: only forces at the tip are measured, and piston_arm / tool_reach = {lever_of} comes from the drawing",
         *poorly_seen(fit)),
        ("travel at a second pressure, for the share of the friction that is there without pressure",) if one else (),
        failed, fit.outliers, fit.condition, unknown_combinations(fit),
    )  # fmt: skip


def _checked(data: Measurement, pressure: FloatArray, forces: FloatArray) -> None:
    """Refuse what cannot be: no pressure, a force that is larger on the way back."""
    faults = [data.fault("pressure: must be above zero", int(row)) for row in np.flatnonzero(pressure <= 0.0)]
    for out, back in ((0, 1), (2, 3)):
        turned = np.flatnonzero(forces[:, out] < forces[:, back])
        if len(turned) > 0.5 * len(forces):
            faults.append(data.fault(
                f"{COLUMNS[out]} is below {COLUMNS[back]} in {len(turned)} of {len(forces)} rows: friction adds to the "
                "force on the way out; are the columns exchanged, or a sign turned?"
            ))  # fmt: skip
    if faults:
        raise ScenarioFault(faults)


def _posed(pressure: FloatArray, forces: FloatArray, settings: SealTravel) -> Posed:
    g, ratio, rows = lever(settings), pressure / settings.spindle.reference_pressure, len(pressure)

    def parts(x: FloatArray) -> tuple[FloatArray, FloatArray]:
        kappa = x[3] + (1.0 - x[3]) * ratio
        return kappa, np.where(_STATIC, x[1], x[2])

    def model(x: FloatArray) -> FloatArray:
        kappa, friction = parts(x)
        return np.asarray(g * (x[0] * pressure[:, None] + _SIGN * friction * kappa[:, None])).reshape(-1)

    def jacobian(x: FloatArray) -> FloatArray:
        kappa, friction = parts(x)
        columns = [
            np.tile(pressure[:, None], (1, 4)), _SIGN * _STATIC * kappa[:, None], _SIGN * ~_STATIC * kappa[:, None],
            _SIGN * friction * (1.0 - ratio[:, None]),
        ]  # fmt: skip
        return g * np.stack(columns, axis=2).reshape(-1, 4)

    area = float(np.mean(forces.mean(axis=1) / pressure)) / g
    half = np.mean(0.5 * (forces[:, [2, 0]] - forces[:, [3, 1]]), axis=0) / g
    unknowns = (
        Unknown("A", "area", area, True), Unknown("F_s", "force", float(half[0]), True),
        Unknown("F_d", "force", float(half[1]), True), Unknown("alpha", "dimensionless", 0.3, True, 0.5),
    )  # fmt: skip
    return Posed(
        unknowns, forces.reshape(-1), np.repeat(np.arange(rows), 4), np.tile(np.arange(4), rows), COLUMNS, ("force",) * 4,
        model, jacobian, linear=False,
    )  # fmt: skip
