r"""Cutting coefficients, run-out and speed from forces over time, on the tool: x feed, y normal, z to the motor.

The model is that of :mod:`cutwise.study.calibrate.teeth`; each channel has an offset and a slope over time besides.
Coefficients, offsets and slopes are linear and solved inside; outside are the angle and speed of the mill, and its run-out.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.measurements import Channel, Measurement
from cutwise.spec.calibration import MINUS, ForceWaves
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.calibrate.fit import CORRELATED, fitted
from cutwise.study.calibrate.posed import Finding, Fit, FloatArray, Posed, Unknown
from cutwise.study.calibrate.teeth import Mill, Shape, chip, columns
from cutwise.study.calibrate.told import (
    covariance_block,
    drawn,
    plain,
    poorly_seen,
    quantity,
    unknown_combinations,
    written,
)

COEFFICIENTS = ("K_tc", "K_rc", "K_ac", "K_te", "K_re", "K_ae")
_FORCES = ("force_x", "force_y", "force_z")
_OFF = 0.01  # share by which the speed may be off the nominal one
_FAR_OFF, _STRONGER = (0.6, 1.7), 1.1  # where else the speed is looked for, and how much more power counts there
_SPEEDS, _ANGLES, _STEPS = 401, 24, 12
_FIRST = 3  # steps from every start, before the best goes on
_SIZES = np.array([0.3, 0.7, 1.1])  # run-outs to start with where the first start ends in a wrong valley, over the feed
_WAYS = np.arange(8) * math.pi / 4.0
_ENOUGH = 4000  # samples to find the starts with
_START = 0.05  # run-out from which the fit starts, over the feed per tooth
_NOT_EXPLAINED = 0.2  # of the signal, beyond which nothing is written
_UNEVEN = 1e-3  # of a sample
_STEEP = 0.02  # [rad] of lag over the depth, below which a tooth enters within a sample or so


def channels(_settings: ForceWaves | None) -> tuple[Channel, ...]:
    """Columns of the forces over time; ``cutting`` 0: the tool was in the air."""
    return (Channel("time", "time"), *(Channel(name, "force") for name in _FORCES), Channel("cutting", "", False))


class Case(NamedTuple):
    """What is fitted."""

    mill: Mill
    time: FloatArray  # [s] (n,)
    cutting: FloatArray  # 1, or 0 in the air (n,)
    forces: FloatArray  # [N] on the tool (n, 3)
    runout: bool = True

    @property
    def bent(self) -> int:
        """Number of unknowns besides the linear ones."""
        return 2 + (min(self.mill.teeth - 1, 2) if self.runout else 0)  # one tooth runs after itself

    def begun(self) -> "Case":
        """The first samples, enough to begin with."""
        kept = slice(0, _ENOUGH)
        if len(self.time) <= _ENOUGH or self.cutting[kept].sum() < 0.5 * _ENOUGH:
            return self
        return self._replace(time=self.time[kept], cutting=self.cutting[kept], forces=self.forces[kept])

    def shape(self, x: FloatArray) -> Shape:
        """Of the last unknowns; one or two teeth show the run-out in the direction of tooth 0 alone."""
        more = np.concatenate([x, np.zeros(4 - len(x))])
        return Shape(*(float(v) for v in more))

    def matrix(self, x: FloatArray) -> FloatArray:
        """Columns of the linear unknowns."""
        return columns(self.mill, self.shape(x), self.time, self.cutting)

    @property
    def steps(self) -> FloatArray:
        """Steps of the differences: angle, speed, run-out, direction."""
        span = float(np.ptp(self.time)) or 1.0
        return np.array([1e-5, 1e-5 / span, 1e-5 * self.mill.feed, 1e-5])[: self.bent]

    def jacobian(self, linear: FloatArray, x: FloatArray) -> FloatArray:
        """Of all unknowns, the linear ones first (3 n, 12 + k)."""
        found = [self.matrix(x)]
        for k, step in enumerate(self.steps):
            moved = np.zeros(len(x))
            moved[k] = step
            found.append(((self.matrix(x + moved) - self.matrix(x - moved)) @ linear / (2.0 * step))[:, None])
        return np.concatenate(found, axis=1)


def calibrate(data: Measurement, settings: ForceWaves) -> Finding:
    """Fit coefficients, offsets, slopes, speed, angle and run-out together."""
    case = _case(data, settings)
    x, linear = _solved(case, data, settings)
    fit = _fitted(case, np.concatenate([linear, x]), settings)
    without = case._replace(runout=False)
    plainer = _refined(without, x[:2])
    return _found(data, case, fit, plainer, without)


def _case(data: Measurement, settings: ForceWaves) -> Case:
    faults = []
    if settings.data.axes == "auto":
        faults.append(Fault(("data", "axes"), "auto finds the channels of mean forces in slots alone; name them"))
    time = data.columns["time"]
    step = np.diff(time)
    usual = float(np.median(step)) if len(step) else 0.0
    if usual <= 0.0:
        faults.append(data.fault("time does not rise"))
    elif np.max(np.abs(step - usual)) > _UNEVEN * usual:
        row = int(np.argmax(np.abs(step - usual))) + 1
        faults.append(data.fault(f"time: the samples are not uniform, {usual:g} s apart as a rule", row))
    cutting = data.columns.get("cutting", np.ones(len(time)))
    odd = np.flatnonzero((cutting != 0.0) & (cutting != 1.0))
    faults += [data.fault("cutting: is neither 0 (in the air) nor 1", int(row)) for row in odd[:3]]
    turn = 2.0 * math.pi / settings.operation.spindle_speed
    if not faults and float(np.sum(cutting)) * usual < 2.0 * turn:
        faults.append(
            data.fault(f"shows {float(np.sum(cutting)) * usual / turn:.2g} turns of the mill; record 2 or more")
        )
    if not faults and settings.tool.flutes / turn > 0.25 / usual:
        faults.append(data.fault(
            f"has {turn / settings.tool.flutes / usual:.2g} samples for each tooth; 4 are the least, sample faster"
        ))  # fmt: skip
    if faults:
        raise ScenarioFault(faults)
    measured = data.matrix(_FORCES)
    sign = -1.0 if settings.data.forces_on == "work" else 1.0
    forces = sign * np.column_stack([turned * measured[:, k] for k, turned in (MINUS[a] for a in settings.data.axes)])
    tool, operation = settings.tool, settings.operation
    lag = 2.0 * math.tan(tool.helix) / tool.diameter
    mill = Mill(tool.flutes, operation.feed_per_tooth, operation.axial_depth, lag, settings.cut.arc)
    return Case(mill, time - time[0], cutting, forces)


def _linear(case: Case, x: FloatArray) -> tuple[FloatArray, float]:
    """The linear unknowns at a shape, with the smallest length where they are free, and the squares that are left."""
    matrix, y = case.matrix(x), case.forces.reshape(-1)
    found = _least_squares(matrix, y)
    return found, float(np.sum((y - matrix @ found) ** 2))


def _least_squares(matrix: FloatArray, y: FloatArray) -> FloatArray:
    """By the normal equations, twice: few unknowns, many samples; the smallest solution where it is free."""
    lengths = np.linalg.norm(matrix, axis=0)
    scaled = matrix / np.where(lengths > 0.0, lengths, 1.0)
    normal = scaled.T @ scaled
    found = np.zeros(len(lengths))
    for _ in range(2):
        found = found + np.linalg.lstsq(normal, scaled.T @ (y - scaled @ found), rcond=1e-13)[0]
    return np.asarray(found / np.where(lengths > 0.0, lengths, 1.0))


def _refined(case: Case, x: FloatArray, steps: int = _STEPS) -> tuple[FloatArray, FloatArray, float]:
    """Gauss-Newton steps, halved while they do not help; shape, linear unknowns, squares that are left."""
    linear, left = _linear(case, x)
    for _ in range(steps):
        jacobian = case.jacobian(linear, x)
        rest = case.forces.reshape(-1) - jacobian[:, : len(linear)] @ linear
        move = _least_squares(jacobian, rest)[len(linear) :]
        for half in (1.0, 0.5, 0.25, 0.1, 0.02):
            tried = x + half * move
            again, squares = _linear(case, tried)
            if squares <= left:
                break
        else:
            break
        done = left - squares <= 1e-13 * left
        x, linear, left = tried, again, squares
        if done:
            break
    return x, linear, left


def _solved(case: Case, data: Measurement, settings: ForceWaves) -> tuple[FloatArray, FloatArray]:
    """Speed by the power at the orders of a turn, angle by trial, run-out from several directions; then all together."""
    speed = _speed(case, data, settings)
    whole, case = case, case.begun()
    straight = case._replace(runout=False)
    pitch = 2.0 * math.pi / case.mill.teeth
    trials = []
    for angle in np.arange(_ANGLES) * pitch / _ANGLES:
        x = np.array([angle, speed])
        linear, left = _linear(straight, x)
        if linear[0] > 0.0:
            trials.append((left, x))
    if not trials:
        raise ScenarioFault([data.fault(
            "at no angle of the mill does K_tc come out above zero: is a channel turned (data.axes), or are the forces those on "
            "the work (data.forces_on: work)?"
        )])  # fmt: skip
    begin = min(trials, key=lambda one: one[0])[1]
    size = _START * case.mill.feed
    if case.bent == 4:
        starts = [np.array([*begin, size, k * math.pi / 2.0]) for k in range(4)]
    else:
        starts = [np.array([*begin, sign * size])[: case.bent] for sign in (1.0, -1.0)[: case.bent - 1]]
    x, linear, left = _best(case, starts)
    if (
        case.bent > 2 and _left_over(case, x, linear) > CORRELATED
    ):  # another valley: look for it over all of the run-outs
        sizes = _SIZES * case.mill.feed
        ways = [(size, way) for size in sizes for way in _WAYS] if case.bent == 4 else [(s,) for s in (*sizes, *-sizes)]
        other = _best(case, [np.array([*begin, *way]) for way in ways])
        x = other[0] if other[2] < left else x
    x = _renumbered(whole, _refined(whole, x)[0] if case is not whole else x)
    return x, _linear(whole, x)[0]


def _best(case: Case, starts: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray, float]:
    """A few steps from every start, the two best of them to the end: the way down has kinks where teeth begin to miss."""
    begun = sorted((_refined(case, start, _FIRST) for start in starts), key=lambda one: one[2])
    return min((_refined(case, one[0]) for one in begun[:2]), key=lambda one: one[2])


def _left_over(case: Case, x: FloatArray, linear: FloatArray) -> float:
    """Correlation of neighbouring residuals, the largest of the three channels."""
    rest = (case.forces.reshape(-1) - case.matrix(x) @ linear).reshape(-1, 3)
    squares = np.maximum(np.sum(rest**2, axis=0), 1e-300)
    signal = 1e-9 * max(float(np.sum(case.forces**2)), 1e-300)
    return float(np.max(np.where(squares > signal, np.sum(rest[1:] * rest[:-1], axis=0) / squares, 0.0)))


def _renumbered(case: Case, x: FloatArray) -> FloatArray:
    """The same teeth counted from the one in the first pitch; a run-out above zero where its direction shows."""
    pitch = 2.0 * math.pi / case.mill.teeth
    turns = math.floor(x[0] / pitch)
    x = x.copy()
    x[0] -= turns * pitch
    if case.bent < 4:
        x[2:] *= math.cos(turns * pitch)
        return x
    x[3] += turns * pitch + (math.pi if x[2] < 0.0 else 0.0)
    x[2] = abs(x[2])
    x[3] = (x[3] + math.pi) % (2.0 * math.pi) - math.pi
    return x


def _speed(case: Case, data: Measurement, settings: ForceWaves) -> float:
    """Where the power at the orders of a turn is largest, up to twice the passing of teeth [rad/s]."""
    case = case.begun()
    cut = case.cutting > 0.0
    time = case.time[cut]
    matrix = np.column_stack([np.ones_like(time), time])
    forces = case.forces[cut] - matrix @ np.linalg.lstsq(matrix, case.forces[cut], rcond=None)[0]
    nominal = settings.operation.spindle_speed
    span = float(np.ptp(time)) or 1.0
    wide = max(_OFF, 0.5 * 2.0 * math.pi / (case.mill.teeth * span * nominal))  # no finer than the record can tell
    speeds = nominal * np.linspace(1.0 - 2.0 * wide, 1.0 + 2.0 * wide, 2 * _SPEEDS - 1)
    power = _power(speeds, case.mill.teeth, time, forces)
    best = float(speeds[int(np.argmax(power))])
    far = nominal * np.linspace(*_FAR_OFF, max(64, math.ceil(3.0 * nominal * span * case.mill.teeth)))
    elsewhere = _power(far, case.mill.teeth, time, forces)
    if np.max(elsewhere) > _STRONGER * np.max(power):
        best = float(far[int(np.argmax(elsewhere))])
    if abs(best / nominal - 1.0) > wide * (1.0 + 1e-9):
        raise ScenarioFault([data.fault(
            f"the teeth pass as at {units.show(best, 'angular_speed', 5)} or further off, more than "
            f"{wide:.1%} from operation.spindle_speed, {units.show(nominal, 'angular_speed', 5)}: is it right, and "
            "tool.flutes?"
        )])  # fmt: skip
    return best


def _power(speeds: FloatArray, teeth: int, time: FloatArray, forces: FloatArray) -> FloatArray:
    """Power of forces at the orders of a turn, up to twice the passing of teeth, for each speed."""
    power, turn = np.zeros(len(speeds)), np.exp(-1j * speeds[:, None] * time)
    wave = np.ones_like(turn)
    for _ in range(2 * teeth):  # run-out shows at every turn, where teeth that overlap leave nothing to see
        wave *= turn
        power += np.sum(np.abs(wave @ forces) ** 2, axis=1)
    return power


def _names(case: Case) -> list[tuple[str, str, float]]:
    """Names, dimensions and scales at zero of the shape."""
    more = [("rho_cos_lambda" if case.bent == 3 else "rho", "length", case.mill.feed), ("lambda", "angle", 1.0)]
    return [("phi_0", "angle", 1.0), ("omega", "angular_speed", 0.0), *more][: case.bent]


def _fitted(case: Case, x: FloatArray, settings: ForceWaves) -> Fit:
    rows = len(case.time)
    size = np.sqrt(np.mean(case.forces**2, axis=0))
    span = float(np.ptp(case.time)) or 1.0
    unknowns = [
        Unknown(name, "stress" if k < 3 else "edge_force", float(x[k]), True, 0.0 if k < 3 else abs(x[k - 3]) * case.mill.feed)
        for k, name in enumerate(COEFFICIENTS)
    ]  # fmt: skip
    unknowns += [Unknown(f"offset_{a}", "force", float(x[6 + k]), False, float(size[k])) for k, a in enumerate("xyz")]
    unknowns += [
        Unknown(f"slope_{a}", "force_rate", float(x[9 + k]), False, float(size[k]) / span) for k, a in enumerate("xyz")
    ]
    unknowns += [
        Unknown(name, dimension, float(x[12 + k]), False, scale)
        for k, (name, dimension, scale) in enumerate(_names(case))
    ]
    turns = np.floor(x[13] * case.time / (2.0 * math.pi)).astype(np.int64)
    posed = Posed(
        tuple(unknowns), case.forces.reshape(-1), np.repeat(np.arange(rows), 3), np.tile(np.arange(3), rows), _FORCES,
        ("force",) * 3, lambda v: np.asarray(case.matrix(v[12:]) @ v[:12]), lambda v: case.jacobian(v[:12], v[12:]),
        linear=False, blocks=np.repeat(turns, 3),
    )  # fmt: skip
    return fitted(posed, loss=settings.fit.loss, level=settings.fit.level, prior=settings.fit.prior, retest=False)


def _found(
    data: Measurement, case: Case, fit: Fit, plainer: tuple[FloatArray, FloatArray, float], without: Case
) -> Finding:
    values = [plain(fit, k) for k in range(len(fit.x))]
    warnings, failed, cannot, advice = [], [], [], []
    for value in values[:3]:
        if value.value < 0.0:
            warnings.append(
                f"{value.name} came out negative, which no cut gives; written as it is: is a channel turned (data.axes), or "
                "are the forces those on the work (data.forces_on)?"
            )
            failed.append(f"{value.name} is negative")
    cut = case.cutting > 0.0
    rms = float(np.sqrt(np.mean(fit.residual**2)))
    signal = float(np.sqrt(np.mean((case.forces[cut] - case.forces[cut].mean(axis=0)) ** 2)))
    entry = rms <= _NOT_EXPLAINED * signal
    if not entry:
        failed.append(
            f"the fit leaves {rms / max(signal, 1e-300):.0%} of the signal, more than {_NOT_EXPLAINED:.0%}: no entry; is a "
            "channel turned (data.axes), are the forces those on the work (data.forces_on: work), is the sensor slow against the "
            "teeth, or does the machine swing?"
        )
    slot = abs(case.mill.arc[0]) < 1e-6 and abs(case.mill.arc[1] - math.pi) < 1e-6
    if not np.any(~cut) and slot:
        cannot.append(
            "K_ac, K_te and K_re apart from the offsets of the channels, in full: in a slot free offsets widen them 1.4 to 3 "
            "times, and with two teeth without run-out K_ae is one of them"
        )
        advice.append(
            "record an air cut first (column cutting: 0 there) which fixes the offsets, or cut with part of the width"
        )
    if case.mill.lag * case.mill.depth < _STEEP:
        warnings.append(
            "flutes as straight as these enter and leave in a jump: where it falls between two samples nobody knows, and the "
            "standard errors are too small by a factor of several"
        )
    block = written(values[:6], "coefficients", data.rows) if entry else {}
    if entry:
        largest = chip(case.mill, case.shape(fit.x[12:]))
        source = f"{{file}}, feed {units.show(case.mill.feed, 'length', 4)} per tooth"
        block["chip_thickness_max"] = {"value": quantity(largest, "length"), "status": "measured", "source": source}
    left = math.sqrt(plainer[2] / (3 * len(without.time)))
    table = (
        ("model", "K_tc", "K_rc", "K_ac", "rms"),
        ("with run-out", *(units.show(float(fit.x[k]), "stress", 5) for k in range(3)), units.show(rms, "force", 4)),
        ("without", *(units.show(float(plainer[1][k]), "stress", 5) for k in range(3)), units.show(left, "force", 4)),
    )  # fmt: skip
    if fit.lag_1 > CORRELATED:
        failed.append(f"neighbouring residuals correlate by {fit.lag_1:.2f}: the residual is not noise")
    names, dimensions = fit.posed.names[:6], [u.dimension for u in fit.posed.unknowns[:6]]
    return Finding(
        "linear", tuple(values), block, {"coefficients": covariance_block(fit, names, dimensions)} if entry else {},
        fit.scale, "force", None, "", "force", fit, drawn(fit.posed, fit.residual), table, tuple(warnings),
        (*cannot, *poorly_seen(fit)), tuple(advice), tuple(failed), fit.outliers, fit.condition, unknown_combinations(fit), entry,
    )  # fmt: skip
