r"""Springs of an arm from load tests.

.. math:: \Delta = \sum_i v_i (v_i \cdot F)\, c_i, \qquad v_i = z_i \times (p - o_i), \qquad K_i = 1/c_i

``joints``: the joints alone. ``joints+base``: and three translations of the base. ``bodies``: rotations of every joint's
frame about its three axes, translations of base and flange, none below zero (non-negative least squares).
Compliances are fitted, for the deflection is linear in them.
"""

from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy import optimize

from cutwise import units
from cutwise.io.measurements import Channel, Measurement
from cutwise.maths.chains import frames, jacobian
from cutwise.maths.frames import rotation_from_rpy
from cutwise.spec.calibration import ArmStiffness
from cutwise.spec.faults import ScenarioFault
from cutwise.study.calibrate.arm import folds, in_last_frame, joint_angles, joint_channels, serial
from cutwise.study.calibrate.fit import fitted
from cutwise.study.calibrate.posed import Finding, Fit, FloatArray, Posed, Unknown, Value
from cutwise.study.calibrate.told import plain, poorly_seen, unknown_combinations

MODELS = ("joints", "joints+base", "bodies")
_AXES = "xyz"
_RESAMPLED = 1000
_UNLOADED = 1e-12  # of the column of the joint that is loaded most
_ROUNDING = 1e-9  # of a value
_TURNED = 0.25  # of the squares that are left when an axis is turned: beyond chance


def channels(settings: ArmStiffness | None) -> tuple[Channel, ...]:
    """Columns of the load tests."""
    count = 6 if settings is None else len(settings.robot.joints)
    hint = "is more than 20 mm; millimetres in a column of metres?"
    return (
        *joint_channels(count),
        *(Channel(f"force_{axis}", "force") for axis in _AXES),
        *(Channel(f"deflection_{axis}", "length", True, 0.02, hint, "mm") for axis in _AXES),
    )


class Tests(NamedTuple):
    """Load tests: rows n."""

    angles: FloatArray  # [rad] (n, joints)
    forces: FloatArray  # [N] on the tool, base frame (n, 3)
    deflections: FloatArray  # [m] (n, 3)


def calibrate(data: Measurement, settings: ArmStiffness) -> Finding:
    """Fit all models, and write the one that is asked for."""
    model = settings.fit.model or MODELS[0]
    count = len(settings.robot.joints)
    tests = Tests(
        joint_angles(data, count),
        data.matrix([f"force_{axis}" for axis in _AXES]),
        data.matrix([f"deflection_{axis}" for axis in _AXES]),
    )
    arms = spring_columns(settings, tests)
    _loaded(data, tests, arms.joints, settings)
    _signs(data, tests, arms.joints)
    apart = folds(settings.fit.hold_out, len(tests.angles))
    joints = _linear(tests, arms.joints, _joint_names(count), settings, apart)
    base = np.concatenate([arms.joints, arms.base], axis=2)
    names = [*_joint_names(count), *_base_names()]
    with_base = _linear(tests, base, names, settings, apart)
    bodies = _bodies(tests, arms, apart)
    chosen = {"joints": joints, "joints+base": with_base}.get(model)
    compared = _compared(tests, joints, with_base, bodies)
    if chosen is None:
        robust = settings.fit.loss != "linear"
        said = ("fit.loss acts on joints and joints+base; non-negative springs are least squares",) if robust else ()
        return _as_bodies(tests, arms, bodies, joints, compared, said)
    return _as_springs(tests, chosen, (joints, with_base), model, count, compared)


class Columns(NamedTuple):
    """Deflection per unit of each compliance, for each test: (n, 3, springs)."""

    joints: FloatArray
    base: FloatArray
    bodies: FloatArray
    labels: tuple[tuple[str, str, str], ...]  # of the bodies: body, motion, axis


def spring_columns(settings: ArmStiffness, tests: Tests) -> Columns:
    """What every spring that may be fitted adds to the deflection."""
    arm = settings.robot
    links, count = serial(arm), len(arm.joints)
    tip = in_last_frame(arm, settings.data.point or arm.tool_position)
    force = tests.forces
    moved = jacobian(links, tests.angles, tip)[:, :3, :]  # v_i as columns
    joints = moved * np.einsum("nci,nc->ni", moved, force)[:, None, :]
    base = np.einsum("nc,cd->ncd", force, np.eye(3))
    at = frames(links, tests.angles)
    point = at.origins[:, -1] + np.einsum("nij,j->ni", at.rotations[:, -1], tip)
    found, labels = [], []
    for k in range(count):
        for axis in range(3):
            v = np.cross(at.rotations[:, k + 1, :, axis], point - at.origins[:, k + 1])
            found.append(v * np.sum(v * force, axis=1)[:, None])
            labels.append((str(k + 1), "rotation", _AXES[axis]))
    flange = at.rotations[:, -1] @ rotation_from_rpy(*arm.flange_rotation)
    for axis in range(3):
        found.append(base[:, :, axis])
        labels.append(("base", "translation", _AXES[axis]))
    for axis in range(3):
        v = flange[:, :, axis]
        found.append(v * np.sum(v * force, axis=1)[:, None])
        labels.append(("flange", "translation", _AXES[axis]))
    return Columns(joints, base, np.stack(found, axis=2), tuple(labels))


def _joint_names(count: int) -> list[str]:
    return [f"joint_stiffness[{k}]" for k in range(count)]


def _base_names() -> list[str]:
    return [f"base_compliance[{k}]" for k in range(3)]


def _loaded(data: Measurement, tests: Tests, columns: FloatArray, settings: ArmStiffness) -> None:
    """Refuse loads that leave a joint without any moment: of its stiffness nothing could be written, not even a guess."""
    if not np.any(tests.forces):
        raise ScenarioFault([data.fault("the force is 0 in all rows: nothing is known of any stiffness")])
    moved = np.linalg.norm(columns, axis=(0, 1))
    names = _joint_names(columns.shape[2])
    unloaded = np.flatnonzero(moved <= _UNLOADED * moved.max())
    faults = [
        data.fault(
            f"no force has a moment about the axis of joint {k + 1}, so that nothing is known of {names[k]}: load it from "
            f"another side or in another posture, or say what is known of it beforehand: --set "
            f"fit.prior='{{\"{names[k]}\": [1e6 N m/rad, 5e5 N m/rad]}}' (value, standard deviation)"
        )
        for k in map(int, unloaded)
        if names[k] not in settings.fit.prior
    ]
    if faults:
        raise ScenarioFault(faults)


def _signs(data: Measurement, tests: Tests, columns: FloatArray) -> None:
    """Refuse forces and deflections that no arm has: it yields along the force, whatever its springs."""
    work = np.sum(tests.forces * tests.deflections, axis=1)
    if np.sum(work) < 0.0:
        against = int(np.sum(work < 0.0))
        raise ScenarioFault([data.fault(
            f"in {against} of {len(work)} rows the tool moves against the force; a sign is turned: forces are those on the "
            "tool, in the axes of the deflections"
        )])  # fmt: skip
    matrix = columns.reshape(-1, columns.shape[2])
    left: dict[tuple[float, float], float] = {}
    for y, z in product((1.0, -1.0), repeat=2):
        turned = (tests.deflections * np.array([1.0, y, z])).reshape(-1)
        found = np.linalg.lstsq(matrix / 1e-6, turned, rcond=None)[0]
        left[y, z] = float(np.sum((turned - matrix @ found / 1e-6) ** 2))
    best = min(left, key=lambda signs: left[signs])
    if left[best] < _TURNED * left[1.0, 1.0]:
        wrong = {(-1.0, 1.0): "y", (1.0, -1.0): "z", (-1.0, -1.0): "x (or both y and z)"}[best]
        raise ScenarioFault([data.fault(
            f"axis {wrong} of force or deflection seems turned: with its sign changed {left[best] / left[1.0, 1.0]:.0%} of "
            "the squares are left; forces and deflections are in the base frame"
        )])  # fmt: skip


def _linear(tests: Tests, columns: FloatArray, names: list[str], settings: ArmStiffness, apart: list[list[int]]) -> Fit:
    rows, _, count = columns.shape
    matrix = columns.reshape(rows * 3, count)
    unknowns = tuple(
        Unknown(name, "angular_compliance" if name.startswith("joint") else "compliance", 0.0, deciding=True)
        for name in names
    )
    posed = Posed(
        unknowns, tests.deflections.reshape(-1), np.repeat(np.arange(rows), 3), np.tile(np.arange(3), rows),
        tuple(f"deflection_{axis}" for axis in _AXES), ("length",) * 3,
        lambda x: np.asarray(matrix @ x), lambda _: matrix,
    )  # fmt: skip
    return fitted(posed, loss=settings.fit.loss, level=settings.fit.level, prior=settings.fit.prior, folds=apart)


class Bodies(NamedTuple):
    """Non-negative springs and how well they predict."""

    compliance: FloatArray  # (springs,)
    standard_errors: FloatArray  # by resampling rows
    residual: FloatArray  # [m] (n, 3)
    left_out: FloatArray  # [m] (n, 3)


def _bodies(tests: Tests, arms: Columns, apart: list[list[int]]) -> Bodies:
    rows, _, count = arms.bodies.shape
    lengths = np.linalg.norm(arms.bodies.reshape(-1, count), axis=0)
    lengths = np.where(lengths > 0.0, lengths, 1.0)
    scaled = arms.bodies / lengths

    def solved(chosen: Any) -> FloatArray:
        return np.asarray(optimize.nnls(scaled[chosen].reshape(-1, count), tests.deflections[chosen].reshape(-1))[0])

    found = solved(np.arange(rows))
    left_out = np.full((rows, 3), np.nan)
    for fold in apart:
        kept = np.setdiff1d(np.arange(rows), fold)
        left_out[fold] = tests.deflections[fold] - scaled[fold] @ solved(kept)
    drawn = np.random.default_rng(1)
    again = np.array([solved(drawn.integers(0, rows, rows)) for _ in range(_RESAMPLED)])
    return Bodies(found / lengths, again.std(axis=0, ddof=1) / lengths, tests.deflections - scaled @ found, left_out)


def relative(tests: Tests, errors: FloatArray) -> FloatArray:
    """Length of the error of each row over that of its deflection; NaN where it was not left out."""
    return np.asarray(np.linalg.norm(errors.reshape(-1, 3), axis=1) / np.linalg.norm(tests.deflections, axis=1))


def _compared(tests: Tests, joints: Fit, with_base: Fit, bodies: Bodies) -> tuple[tuple[str, ...], ...]:
    rows = [("model", "rms of components", "left-out error, median", "left-out error, mean", "condition", "90 % cover")]
    for name, fit in (("joints", joints), ("joints+base", with_base)):
        errors = relative(tests, fit.left_out)
        rows.append((
            name, units.show(_rms(fit.residual), "small_length"), _percent(np.nanmedian(errors)), _percent(np.nanmean(errors)),
            f"{fit.condition:.4g}", _percent(fit.left_out_cover),
        ))  # fmt: skip
    errors = relative(tests, bodies.left_out)
    rows.append((
        "bodies", units.show(_rms(bodies.residual), "small_length"), _percent(np.nanmedian(errors)),
        _percent(np.nanmean(errors)), "-", "-",
    ))  # fmt: skip
    return tuple(rows)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _percent(value: float | np.floating[Any]) -> str:
    return f"{100 * value:.4g} %"


def _as_springs(
    tests: Tests, fit: Fit, both: tuple[Fit, Fit], model: str, count: int, compared: tuple[tuple[str, ...], ...]
) -> Finding:
    errors = fit.standard_errors
    other = both[1] if fit is both[0] else both[0]
    shift = {
        name: _beyond_rounding(other.x[other.posed.names.index(name)], float(fit.x[k])) / errors[k]
        for k, name in enumerate(fit.posed.names)
        if name in other.posed.names
    }
    values, warnings, failed = [], [], []
    for k, name in enumerate(fit.posed.names):
        value = _spring(fit, k) if k < count else plain(fit, k)
        moved = shift.get(name, 0.0)
        if abs(moved) > 2.0:
            note = f"depends on the model ({moved:+.2f} s.e. in {'joints+base' if fit is both[0] else 'joints'})"
            value = value._replace(note=note, verdict="weak" if value.verdict == "identified" else value.verdict)
        values.append(value)
        if fit.x[k] < 0.0:
            warnings.append(f"{name} came out negative, which no spring is; written as it is")
            failed.append(f"{name} is negative")
    left = relative(tests, fit.left_out)
    median = float(np.nanmedian(left)) if np.any(np.isfinite(left)) else None
    return Finding(
        model, tuple(values), _written(values, count, len(tests.angles)), _covariances(fit, count), fit.scale,
        "length", median, "median of error over deflection", "dimensionless", fit, _drawn(tests, fit.residual),
        compared, tuple(warnings),
        ("how stiff the arm is at other postures than those tested: see the ranges",
         "a spring of the base, the links or the flange is counted to the joints"
         if model == "joints" else "a spring of the links or the flange is counted to joints and base", *poorly_seen(fit)),
        failed=tuple(failed), outliers=fit.outliers, condition=fit.condition, unknown=unknown_combinations(fit),
    )  # fmt: skip


def _beyond_rounding(other: float, value: float) -> float:
    """How far two models are apart; noise-free data leave errors that are rounding, and so is the rest then."""
    return 0.0 if abs(other - value) <= _ROUNDING * abs(value) else other - value


def _spring(fit: Fit, k: int) -> Value:
    """A stiffness of a fitted compliance: its interval is turned over; no upper end if the compliance may be 0."""
    c, se = float(fit.x[k]), float(fit.standard_errors[k])
    half = fit.quantile * se
    low = 1.0 / (c + half) if c + half > 0.0 and np.isfinite(half) else None
    high = 1.0 / (c - half) if c - half > 0.0 else None
    stiffness = 1.0 / c if c != 0.0 else float("inf")
    return Value(
        fit.posed.names[k], "angular_stiffness", stiffness, se * stiffness**2 if c else float("inf"), low, high,
        fit.verdicts[k], True,
    )  # fmt: skip


def _written(values: list[Value], count: int, rows: int) -> dict[str, Any]:
    blocks = {"joint_stiffness": values[:count], "base_compliance": values[count:]}
    return {
        key: {
            "value": [units.text(value.value, value.dimension) for value in block],
            "standard_error": [units.text(value.standard_error, value.dimension) for value in block],
            "status": "measured", "covariance": "springs", "source": f"{{file}}, {rows} rows",
        }
        for key, block in blocks.items() if block
    }  # fmt: skip


def _covariances(fit: Fit, count: int) -> dict[str, Any]:
    mixed = len(fit.x) > count
    kinds = ["reciprocal"] * count + ["value"] * (len(fit.x) - count)
    si = ["rad/(N m)"] * count + ["m/N"] * (len(fit.x) - count)
    return {"springs": {
        "of": list(fit.posed.names), "as": kinds if mixed else "reciprocal", "degrees_of_freedom": fit.degrees_of_freedom,
        "matrix": fit.covariance.tolist(), "unit": si if mixed else "rad/(N m)",
    }}  # fmt: skip


def _drawn(tests: Tests, residual: FloatArray) -> tuple[tuple[str, str, FloatArray, FloatArray], ...]:
    left = residual.reshape(-1, 3)
    return tuple(
        (f"deflection_{axis}", "length", tests.deflections[:, k], tests.deflections[:, k] - left[:, k])
        for k, axis in enumerate(_AXES)
    )


def _as_bodies(
    tests: Tests,
    arms: Columns,
    bodies: Bodies,
    joints: Fit,
    compared: tuple[tuple[str, ...], ...],
    said: tuple[str, ...],
) -> Finding:
    left = relative(tests, bodies.left_out)
    plainer = float(np.nanmedian(relative(tests, joints.left_out)))
    median = float(np.nanmedian(left))
    values, listed = [], []
    for label, c, se in zip(arms.labels, bodies.compliance, bodies.standard_errors, strict=True):
        dimension = "angular_compliance" if label[1] == "rotation" else "compliance"
        half = joints.quantile * float(se)
        verdict = "identified" if half < 0.5 * c else "weak" if half <= c else "not identified"
        values.append(Value(
            f"body_compliance.{'.'.join(label)}", dimension, float(c), float(se), max(0.0, float(c) - half), float(c) + half,
            verdict, False,  # type: ignore[arg-type]
        ))  # fmt: skip
        body = int(label[0]) if label[0].isdigit() else label[0]
        listed.append({"body": body, "motion": label[1], "axis": label[2], "value": units.text(float(c), dimension)})
    written = {"body_compliance": {
        "value": [one for one, c in zip(listed, bodies.compliance, strict=True) if c > 0.0],
        "status": "measured", "source": f"{{file}}, {len(tests.angles)} rows; single values are not unique",
    }}  # fmt: skip
    failed = () if median < plainer else (
        f"the left-out error {_percent(median)} is not below that of joints, {_percent(plainer)}",
    )  # fmt: skip
    free = tests.deflections.size - int(np.sum(bodies.compliance > 0.0))
    return Finding(
        "bodies", tuple(values), written, {}, float(np.sqrt(np.sum(bodies.residual**2) / free)), "length", median,
        "median of error over deflection", "dimensionless", None, _drawn(tests, bodies.residual), compared,
        warnings=said, cannot_tell=("single values: axes that go through a common origin share what they yield by",), failed=failed,
        outliers=joints.outliers,
    )  # fmt: skip
