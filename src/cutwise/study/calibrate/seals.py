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
from cutwise.study.calibrate.loops import Loops, loops_of
from cutwise.study.calibrate.posed import Finding, FloatArray, Posed, Unknown
from cutwise.study.calibrate.told import covariance_block, drawn, plain, poorly_seen, rms, unknown_combinations, written

COLUMNS = ("loading_plateau", "unloading_plateau", "breakaway", "return_breakaway")
_SIGN = np.array([1.0, -1.0, 1.0, -1.0])
_STATIC = np.array([False, False, True, True])


def channels(settings: SealTravel | None) -> tuple[Channel, ...]:
    """Columns of the forces at the tip; without settings, for an empty file: the plateaus are the plainer way."""
    hint = "is more than 100 bar; is the unit right?"
    return (
        Channel("pressure", "pressure", True, 1e7, hint, "bar"), *(Channel(name, "force", settings is None) for name in COLUMNS),
        Channel("travel", "length", False, 0.1, "is more than 100 mm of travel; is the unit right?", "mm"),
        Channel("force", "force", False),
    )  # fmt: skip


def lever(settings: SealTravel) -> float:
    """g: force at the tip per force of a piston."""
    spindle = settings.spindle
    return spindle.piston_arm / spindle.tool_reach * spindle.pistons / math.pi


def calibrate(data: Measurement, settings: SealTravel) -> Finding:
    """Fit A, F_s, F_d and the share of the friction that is there without pressure."""
    loops = _loops(data)
    pressure = loops.pressure
    _checked(data, loops)
    apart = [[int(loops.row[k]) for k in fold] for fold in folds(settings.fit.hold_out, len(pressure))]
    fit = fitted(
        _posed(loops, settings), loss=settings.fit.loss, level=settings.fit.level, prior=settings.fit.prior, folds=apart
    )
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
        (*(("where breakaway and plateau of a raw loop are read is assumed: the first 10 % and the middle 60 % of the travel",)
           if "travel" in data.columns else ()),
         f"the lever: only forces at the tip are measured, and piston_arm / tool_reach = {lever_of} comes from the drawing",
         *poorly_seen(fit)),
        ("travel at a second pressure, for the share of the friction that is there without pressure",) if one else (),
        failed, fit.outliers, fit.condition, unknown_combinations(fit),
    )  # fmt: skip


def _loops(data: Measurement) -> Loops:
    """Plateaus and breakaways, as they are written or from raw loops."""
    there = [name for name in COLUMNS if name in data.columns]
    raw = [name for name in ("travel", "force") if name in data.columns]
    if there and raw:
        raise ScenarioFault([data.fault("has plateaus and raw loops (travel, force); one kind in a file")])
    if len(raw) == 2:
        _above_zero(data)
        return loops_of(data)
    if len(there) < len(COLUMNS):
        lacking = [name for name in COLUMNS if name not in there]
        needed = "travel [mm] and force [N]" if raw else f"{', '.join(f'{name} [N]' for name in lacking)}"
        raise ScenarioFault(
            [data.fault(f"lacks {needed}; write the four plateaus, or raw loops: pressure, travel, force")]
        )
    return Loops(np.arange(data.rows), data.columns["pressure"], data.matrix(COLUMNS))


def _above_zero(data: Measurement) -> None:
    low = np.flatnonzero(data.columns["pressure"] <= 0.0)
    if len(low):
        raise ScenarioFault([data.fault("pressure: must be above zero", int(row)) for row in low[:20]])


def _checked(data: Measurement, loops: Loops) -> None:
    """Refuse what cannot be: no pressure, a force that is larger on the way back, fewer than two loops."""
    _above_zero(data)
    forces, faults = loops.forces, []
    if len(forces) < 2:
        faults.append(data.fault("holds one loop: travel at two pressures or more, several times each"))
    for out, back in ((0, 1), (2, 3)):
        turned = np.flatnonzero(forces[:, out] < forces[:, back])
        if len(turned) > 0.5 * len(forces):
            faults.append(data.fault(
                f"{COLUMNS[out]} is below {COLUMNS[back]} in {len(turned)} of {len(forces)} rows: friction adds to the "
                "force on the way out; are the columns exchanged, or a sign turned?"
            ))  # fmt: skip
    if faults:
        raise ScenarioFault(faults)


def _posed(loops: Loops, settings: SealTravel) -> Posed:
    pressure, forces = loops.pressure, loops.forces
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
        unknowns, forces.reshape(-1), np.repeat(loops.row, 4), np.tile(np.arange(4), rows), COLUMNS, ("force",) * 4,
        model, jacobian, linear=False,
    )  # fmt: skip
