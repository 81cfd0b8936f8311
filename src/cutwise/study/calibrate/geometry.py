"""Geometric errors of an arm from places of a target that a tracker has seen.

The tracker's pose and the target's place in the flange are always unknown. ``nominal``: nothing else. ``rigid``: a twist of
each body. ``rigid+joints``: and periodic errors of each joint, and joints 2 and 3 that yield under the links' weight.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import linalg, stats

from cutwise import units
from cutwise.io.measurements import Channel, Measurement
from cutwise.maths.chains import Chain
from cutwise.maths.frames import exp_twists
from cutwise.physics.motion.arm_errors import Errors, Load, corrected_angles, moments, none, poses, waves
from cutwise.results import SolverFailure
from cutwise.spec.calibration import ArmGeometry
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.calibrate.arm import folds, in_last_frame, joint_angles, joint_channels, joint_ranges, serial
from cutwise.study.calibrate.fit import STANDS_OUT
from cutwise.study.calibrate.normal import Linearised, Solution, gauss_newton
from cutwise.study.calibrate.posed import Finding, FloatArray, Outlier, Value

MODELS = ("nominal", "rigid", "rigid+joints")
SIGMA = 1e-4  # [m] of a component of a place (assumed)
TWIST = (3e-3,) * 3 + (5e-3,) * 3  # [m, rad] prior of a body (assumed)
PLACING = (5e-3,) * 3 + (5e-3,) * 3  # of the tracker and the target (assumed)
WAVE = 150e-6  # [rad] prior of each harmonic (assumed)
SAG = 1e-3  # [rad] prior of what a joint yields by under the rms moment (assumed)
NEAR_AXIS = 5e-3  # [m] a target nearer to the last axis does not see it turn
_PLACING = 9  # unknowns of base and target
YIELDING = (1, 2)  # joints whose compliance under gravity is fitted: the others carry too little
_AXES = "xyz"


def channels(settings: ArmGeometry | None) -> tuple[Channel, ...]:
    """Columns of the poses."""
    count = 6 if settings is None else len(settings.robot.joints)
    hint = "is more than 100 m; millimetres in a column of metres?"
    places = (Channel(f"position_{axis}", "length", True, 100.0, hint, "mm") for axis in _AXES)
    return (*joint_channels(count), *places)


class Seen(NamedTuple):
    """Poses: rows n."""

    angles: FloatArray  # [rad] (n, joints)
    places: FloatArray  # [m] in the tracker's frame (n, 3)


class Arm(NamedTuple):
    """The chain, and its weights if they are known and wanted."""

    links: Chain
    target: FloatArray  # [m] where the target is looked for first, last frame (3,)
    load: Load | None


class Placed(NamedTuple):
    """Pose of the tracker and place of the target."""

    rotation: FloatArray  # of the base in the tracker's frame (3, 3)
    origin: FloatArray  # [m] (3,)
    target: FloatArray  # [m] in the last frame (3,)


class Model(NamedTuple):
    """A model with its fit."""

    name: str
    placed: Placed  # of the nominal chain, about which base and target move
    layout: "Layout"
    solution: Solution


class Layout(NamedTuple):
    """Which unknowns a model has: base 6, target 3, twists, harmonics, gravity."""

    joints: int
    rigid: bool
    waved: int  # joints with periodic errors
    harmonics: int
    gravity: bool

    @property
    def unknowns(self) -> int:
        """How many they are."""
        twists = 6 * self.joints if self.rigid else 0
        return 9 + twists + 2 * self.waved * self.harmonics + (len(YIELDING) if self.gravity else 0)

    def errors(self, x: FloatArray) -> Errors:
        """Errors that the unknowns mean."""
        found, n = none(self.joints, self.harmonics), 9
        if self.rigid:
            found.bodies[:] = x[n : n + 6 * self.joints].reshape(-1, 6)
            n += 6 * self.joints
        if self.waved and self.harmonics:
            waves_of = x[n : n + 2 * self.waved * self.harmonics].reshape(self.waved, 2, self.harmonics)
            found.sine[: self.waved], found.cosine[: self.waved] = waves_of[:, 0], waves_of[:, 1]
            n += waves_of.size
        if self.gravity:
            found.gravity_compliance[list(YIELDING)] = x[n:]
        return found

    def prior(self, moment: FloatArray | None) -> FloatArray:
        """Standard deviations about 0 (unknowns,)."""
        parts: list[Any] = [PLACING, (PLACING[0],) * 3]
        if self.rigid:
            parts.append(np.tile(TWIST, self.joints))
        parts.append(np.full(2 * self.waved * self.harmonics, WAVE))
        if self.gravity:
            assert moment is not None
            rms = np.sqrt(np.mean(moment[:, list(YIELDING)] ** 2, axis=0))
            parts.append(SAG / np.maximum(rms, 1e-9))
        return np.concatenate([np.asarray(part, dtype=float) for part in parts])


def calibrate(data: Measurement, settings: ArmGeometry) -> Finding:
    """Fit the models on the rows that are not held out for their error, and the one that is asked for on all."""
    name = settings.fit.model or MODELS[-1]
    if settings.fit.hold_out == "leave_one_out":
        message = "leave_one_out is too much for so many unknowns; write a share, for example 0.2"
        raise ScenarioFault([Fault(("fit", "hold_out"), message)])
    seen = Seen(joint_angles(data, len(settings.robot.joints)), data.matrix([f"position_{axis}" for axis in _AXES]))
    arm = _arm(settings, name)
    held = folds(0.2 if settings.fit.hold_out is None else settings.fit.hold_out, data.rows)
    out = np.array(held[0] if held else [], dtype=int)
    kept = np.setdiff1d(np.arange(data.rows), out)
    compared: list[tuple[str, ...]] = [("model", "mean", "rms", "95 %", "largest", "90 % cover")]
    errors, cover = {}, float("nan")
    nominal = _nominal(data, arm, seen, np.arange(data.rows))
    for model in MODELS[: MODELS.index(name) + 1] if len(out) else ():
        fit = fitted(arm, seen, kept, model, settings.fit.harmonics, _nominal(data, arm, seen, kept))
        errors[model], cover = held_out(arm, seen, out, fit)
        compared.append(_row(model, errors[model], cover))
    whole = fitted(arm, seen, np.arange(data.rows), name, settings.fit.harmonics, nominal)
    return _found(data, settings, arm, seen, whole, errors, tuple(compared))


def _arm(settings: ArmGeometry, model: str) -> Arm:
    robot = settings.robot
    load = None
    if settings.fit.gravity and robot.link_weights and model == MODELS[-1] and len(robot.joints) > max(YIELDING):
        down = np.array(robot.gravity) / np.linalg.norm(robot.gravity)
        load = Load(
            np.array([w.mass for w in robot.link_weights]), np.array([w.centre for w in robot.link_weights]), down
        )
    return Arm(serial(robot), in_last_frame(robot, robot.tool_position), load)


def _nominal(data: Measurement, arm: Arm, seen: Seen, rows: npt.NDArray[np.integer[Any]]) -> Placed:
    """Tracker and target of the chain without errors."""
    count = seen.angles.shape[1]
    own = Seen(seen.angles[rows], seen.places[rows])
    placed = _superposed(arm, own)
    layout = Layout(count, False, 0, 0, False)
    try:
        for _ in range(3):
            placed = _moved(placed, _gauss_newton(arm, own, placed, layout, np.full(9, 1e6)).x)
    except linalg.LinAlgError:
        raise ScenarioFault([data.fault(
            "the poses do not determine where base and target are: turn every joint, at places that do not lie on a line"
        )]) from None  # fmt: skip
    left = own.places - (poses(arm.links, own.angles, np.zeros((count, 6)), placed.target).place @ placed.rotation.T
                         + placed.origin)  # fmt: skip
    extent = float(np.sqrt(np.mean(np.sum((own.places - own.places.mean(axis=0)) ** 2, axis=1))))
    rms = float(np.sqrt(np.mean(np.sum(left**2, axis=1))))
    if rms > 0.1 * extent:
        raise ScenarioFault([data.fault(
            f"the chain does not explain the places: {units.show(rms, 'length', 3)} rms are left of "
                    f"{units.show(extent, 'length', 3)}; "
            "is a joint's sign or zero another one, are the angles those of this chain, or the places left-handed?"
        )])  # fmt: skip
    return placed


def _superposed(arm: Arm, seen: Seen) -> Placed:
    """Tracker pose that lays the target's places best onto those measured (Kabsch), target where it is looked for first."""
    place = poses(arm.links, seen.angles, np.zeros((seen.angles.shape[1], 6)), arm.target).place
    here, there = place.mean(axis=0), seen.places.mean(axis=0)
    u, _, vt = np.linalg.svd((seen.places - there).T @ (place - here))
    rotation = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    return Placed(rotation, there - rotation @ here, arm.target)


def _moved(placed: Placed, x: FloatArray) -> Placed:
    turned, shifted = exp_twists(x[None, :6])
    return Placed(placed.rotation @ turned[0], placed.origin + placed.rotation @ shifted[0], placed.target + x[6:9])


def fitted(
    arm: Arm, seen: Seen, rows: npt.NDArray[np.integer[Any]], model: str, harmonics: int, placed: Placed
) -> Model:
    """A model fitted to some rows."""
    own = Seen(seen.angles[rows], seen.places[rows])
    count = seen.angles.shape[1]
    off_axis = np.linalg.norm(np.cross(placed.target, arm.links.axes[-1]))
    waved = 0 if model != MODELS[-1] else count if off_axis > NEAR_AXIS else count - 1
    layout = Layout(count, model != MODELS[0], waved, harmonics if waved else 0, arm.load is not None and waved > 0)
    moment = moments(arm.links, own.angles, arm.load) if arm.load is not None else None
    try:
        return Model(model, placed, layout, _gauss_newton(arm, own, placed, layout, layout.prior(moment)))
    except linalg.LinAlgError:
        raise SolverFailure(f"the fit of {model} does not converge; fewer fit.harmonics?") from None


def _gauss_newton(arm: Arm, own: Seen, placed: Placed, layout: Layout, prior: FloatArray) -> Solution:
    moment = moments(arm.links, own.angles, arm.load) if arm.load is not None else np.zeros_like(own.angles)
    basis = waves(own.angles, layout.harmonics)
    return gauss_newton(lambda x: _linearised(arm, own, placed, layout, (moment, basis), x), prior, SIGMA)


def _linearised(
    arm: Arm,
    own: Seen,
    placed: Placed,
    layout: Layout,
    given: tuple[FloatArray, tuple[FloatArray, FloatArray]],
    x: FloatArray,
) -> Linearised:
    """Residual in the axes of the nominal base, and what the unknowns move the place by."""
    moment, (sine, cosine) = given
    errors = layout.errors(x)
    at = poses(arm.links, corrected_angles(own.angles, errors, moment), errors.bodies, placed.target + x[6:9])
    turned, shifted = exp_twists(x[None, :6])
    place = at.place @ turned[0].T + shifted[0]
    rows, n = len(place), 9
    jacobian = np.empty((rows, 3, layout.unknowns))
    jacobian[:, :, :3] = np.eye(3)
    jacobian[:, :, 3:6] = _crossed(np.tile(np.eye(3), (rows, 1, 1)), place)
    jacobian[:, :, 6:9] = at.rotations[:, -1]
    if layout.rigid:
        for k in range(layout.joints):
            jacobian[:, :, n : n + 3] = at.rotations[:, k]
            jacobian[:, :, n + 3 : n + 6] = _crossed(at.rotations[:, k], at.arms[:, k])
            n += 6
    per_turn = np.cross(at.axes, at.reach)  # (rows, joints, 3)
    for k in range(layout.waved):
        for basis in (sine, cosine):
            jacobian[:, :, n : n + layout.harmonics] = per_turn[:, k, :, None] * basis[:, k, None, :]
            n += layout.harmonics
    if layout.gravity:
        for k in YIELDING:
            jacobian[:, :, n] = per_turn[:, k] * moment[:, k, None]
            n += 1
    jacobian[:, :, 6:] = np.einsum("ij,njp->nip", turned[0], jacobian[:, :, 6:], optimize=True)
    residual = (own.places - placed.origin) @ placed.rotation - place
    return Linearised(residual, jacobian)


def _crossed(axes: FloatArray, reach: FloatArray) -> FloatArray:
    """Each column of axes (m, 3, 3) crossed with reach (m, 3): (m, 3, 3)."""
    return np.asarray(np.cross(axes, reach[:, :, None], axisa=1, axisb=1, axisc=1))


def held_out(arm: Arm, seen: Seen, rows: npt.NDArray[np.integer[Any]], fit: Model) -> tuple[FloatArray, float]:
    """Errors at rows that the fit does not know (n, 3), and the share of components inside their 90 % interval."""
    own = Seen(seen.angles[rows], seen.places[rows])
    moment = moments(arm.links, own.angles, arm.load) if arm.load is not None else np.zeros_like(own.angles)
    given = (moment, waves(own.angles, fit.layout.harmonics))
    at = _linearised(arm, own, fit.placed, fit.layout, given, fit.solution.x)
    leverage = fit.solution.leverage(at.jacobian.reshape(-1, fit.layout.unknowns), SIGMA)
    sd = np.sqrt(fit.solution.mean_square * (1.0 + leverage * SIGMA**2 / SIGMA**2))
    return at.residual, float(np.mean(np.abs(at.residual.reshape(-1)) <= 1.645 * sd))


def refitted(arm: Arm, seen: Seen, fit: Model) -> FloatArray:
    """Errors at other poses (n, 3) when base and target alone are fitted again: what corrections are worth elsewhere."""
    errors = fit.layout.errors(fit.solution.x)
    moment = moments(arm.links, seen.angles, arm.load) if arm.load is not None else np.zeros_like(seen.angles)
    angles = corrected_angles(seen.angles, errors, moment)
    start = arm._replace(target=fit.placed.target + fit.solution.x[6:9], load=None)
    at = poses(arm.links, angles, errors.bodies, start.target)
    here, there = at.place.mean(axis=0), seen.places.mean(axis=0)
    u, _, vt = np.linalg.svd((seen.places - there).T @ (at.place - here))
    rotation = u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt
    placed = Placed(rotation, there - rotation @ here, start.target)
    for _ in range(4):
        at = poses(arm.links, angles, errors.bodies, placed.target)
        residual = (seen.places - placed.origin) @ placed.rotation - at.place
        eyes = np.tile(np.eye(3), (len(angles), 1, 1))
        jacobian = np.concatenate([eyes, _crossed(eyes, at.place), at.rotations[:, -1]], axis=2)
        move = np.linalg.lstsq(jacobian.reshape(-1, 9), residual.reshape(-1), rcond=None)[0]
        placed = _moved(placed, move)
    at = poses(arm.links, angles, errors.bodies, placed.target)
    return np.asarray((seen.places - placed.origin) @ placed.rotation - at.place)


def figures_of(errors: FloatArray) -> tuple[float, float, float, float]:
    """Mean, rms, 95 % and largest length of errors (n, 3) [m]."""
    size = np.linalg.norm(errors, axis=1)
    return float(size.mean()), float(np.sqrt(np.mean(size**2))), float(np.percentile(size, 95)), float(size.max())


def _row(model: str, errors: FloatArray, cover: float) -> tuple[str, ...]:
    shown = (units.show(value, "small_length", 4) for value in figures_of(errors))
    return (model, *shown, "-" if model == MODELS[0] else f"{100 * cover:.1f} %")


def _found(
    data: Measurement,
    settings: ArmGeometry,
    arm: Arm,
    seen: Seen,
    fit: Model,
    errors: dict[str, FloatArray],
    compared: tuple[tuple[str, ...], ...],
) -> Finding:
    x, solution = fit.solution.x, fit.solution
    se = np.sqrt(solution.variances(SIGMA))
    mean = {name: figures_of(one)[0] for name, one in errors.items()}
    failed = []
    if fit.name != MODELS[0] and mean and mean[fit.name] >= mean[MODELS[0]]:
        failed.append("the left-out error is not below that of the nominal chain")
    leverage = solution.leverage(solution.jacobian.reshape(-1, len(x)), SIGMA)
    spread = np.sqrt(solution.mean_square * np.maximum(1.0 - leverage, 1e-9))
    studentised = np.abs(solution.residual.reshape(-1)) / np.maximum(spread, 1e-300)
    outliers = tuple(
        Outlier(int(k // 3), f"position_{_AXES[k % 3]}", float(studentised[k]), float(solution.weights[k // 3]))
        for k in sorted(np.flatnonzero(studentised > STANDS_OUT), key=lambda k: -studentised[k])
    )
    left = solution.residual @ fit.placed.rotation.T
    drawn = tuple((f"position_{axis}", "length", seen.places[:, k], seen.places[:, k] - left[:, k])
                  for k, axis in enumerate(_AXES))  # fmt: skip
    cannot = [
        "corrections hold inside the joint ranges of the data, modulo a turn, and nowhere else: see errors.ranges"
    ]
    warnings = []
    if fit.name == MODELS[-1] and arm.load is None:
        why = "robot.link_weights is not given" if settings.fit.gravity else "fit.gravity is off"
        warnings.append(f"what the joints yield by under the links' weight is not fitted: {why}")
    if settings.fit.loss != "linear":
        warnings.append("fit.loss is not used: rows further off than 3 times the median weigh less in any case")
    if fit.layout.waved == len(settings.robot.joints) - 1:
        cannot.append("errors of the last joint: the target lies within 5 mm of its axis")
    if mean:
        cannot.append(
            "the place of the base in the tracker's frame moves with every set-up, and is no part of the entry"
        )
    return Finding(
        fit.name, _values(fit, se, settings.fit.level), _written(fit, seen, data.rows), _covariances(fit),
        np.sqrt(solution.mean_square), "length", mean.get(fit.name), "mean length of the error at rows held out",
        "length", None, drawn,
        compared if len(compared) > 1 else (), tuple(warnings), tuple(cannot),
        _advice(seen), tuple(failed), outliers,
    )  # fmt: skip


def _advice(seen: Seen) -> tuple[str, ...]:
    """Where poses are missing."""
    narrow = [f"joint{k + 1} ({np.degrees(high - low):.0f} deg)" for k, (low, high) in enumerate(joint_ranges(seen.angles))
              if high - low < np.radians(180.0)]  # fmt: skip
    return (f"poses that turn further: {', '.join(narrow)}",) if narrow else ()


def _values(fit: Model, se: FloatArray, level: float) -> tuple[Value, ...]:
    """Target, twists and compliances; the harmonics are listed in the entry alone."""
    x, layout = fit.solution.x, fit.layout
    quantile = float(stats.norm.ppf(0.5 + 0.5 * level))
    listed = [
        (f"target_{axis}", "length", fit.placed.target[k] + x[6 + k], 6 + k, PLACING[0]) for k, axis in enumerate(_AXES)
    ]
    n = 9
    if layout.rigid:
        for k in range(layout.joints):
            listed += [
                (f"errors.bodies[{k}][{c}]", "small_length" if c < 3 else "small_angle", x[n + c], n + c, TWIST[c])
                for c in range(6)
            ]
            n += 6
    n += 2 * layout.waved * layout.harmonics
    if layout.gravity:
        for k in YIELDING:
            name = f"errors.gravity_compliance[{k}]"
            listed.append((name, "angular_compliance", x[n], n, 0.0))
            n += 1
    found = []
    for name, dimension, value, k, scale in listed:
        half = quantile * se[k]
        ratio = half / max(abs(value), scale, 1e-300)
        verdict = "identified" if ratio < 0.5 else "weak" if ratio <= 1.0 else "not identified"
        ends = (float(value - half), float(value + half))
        found.append(Value(name, dimension, float(value), float(se[k]), *ends, verdict, False))  # type: ignore[arg-type]
    return tuple(found)


def _covariances(fit: Model) -> dict[str, Any]:
    """Of twists and compliances, seen from the base and the target where the fit has put them.

    The harmonics, hundreds of them, are in it as what they leave open in these. Base and target are held: a part is
    placed against the arm anew in every set-up, and what they share with the bodies goes with it.
    """
    x, layout = fit.solution.x, fit.layout
    names, units_of, places = [], [], []
    if layout.rigid:
        for k in range(layout.joints):
            for c in range(6):
                names.append(f"errors.bodies[{k}][{c}]")
                units_of.append("m" if c < 3 else "rad")
                places.append(9 + 6 * k + c)
    if layout.gravity:
        first = len(x) - len(YIELDING)
        for n, k in enumerate(YIELDING):
            names.append(f"errors.gravity_compliance[{k}]")
            units_of.append("rad/(N m)")
            places.append(first + n)
    if not names:
        return {}
    matrix = fit.solution.covariance(places, _PLACING, SIGMA)
    free = 3 * len(fit.solution.weights) - len(x)
    return {"geometry": {
        "of": names, "as": "value", "degrees_of_freedom": free, "matrix": matrix.tolist(), "unit": units_of,
    }}  # fmt: skip


def _written(fit: Model, seen: Seen, rows: int) -> dict[str, Any]:
    if fit.name == MODELS[0]:
        return {}
    errors, layout = fit.layout.errors(fit.solution.x), fit.layout
    value: dict[str, Any] = {
        "bodies": [
            [units.text(v, "length" if k < 3 else "angle") for k, v in enumerate(twist)] for twist in errors.bodies
        ]
    }
    if layout.waved:
        value["joints"] = [
            {"sine": [units.text(v, "angle") for v in s], "cosine": [units.text(v, "angle") for v in c]}
            for s, c in zip(errors.sine, errors.cosine, strict=True)
        ]
    if layout.gravity:
        value["gravity_compliance"] = [units.text(v, "angular_compliance") for v in errors.gravity_compliance]
    value["ranges"] = [[units.text(end, "angle") for end in ends] for ends in joint_ranges(seen.angles)]
    return {"errors": {"value": value, "status": "measured", "source": f"{{file}}, {rows} rows"}}
