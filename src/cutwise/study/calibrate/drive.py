r"""Inertia, damping, friction and gains of a feed drive from a log of its controller.

.. math:: J\,\Delta\omega + B\,\Delta\theta + T_{c\pm}\,\Delta t = \sum_k \tau_k T_s

over windows of 20 samples in which the motor turns one way, faster than Stribeck friction matters; the torque is held over
a sample, the angle is the travel over the transmission, and the speed at the ends is the slope of a cubic over 21 samples.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy import signal

from cutwise import units
from cutwise.io import library
from cutwise.io.measurements import Channel, Measurement
from cutwise.spec.calibration import DriveLog
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.calibrate.arm import folds
from cutwise.study.calibrate.fit import CORRELATED, fitted
from cutwise.study.calibrate.posed import Finding, Fit, FloatArray, Posed, Unknown, Value
from cutwise.study.calibrate.told import covariance_block, drawn, plain, poorly_seen, rms, unknown_combinations, written

WINDOW, HALF = 20, 10  # samples
FAST = 10.0  # [rad/s] below it Stribeck friction is not the sum of Coulomb's and a viscous one
_UNEVEN = 0.01  # of the sample time
NAMES = ("J", "B", "coulomb_plus", "coulomb_minus")
DIMENSIONS = ("inertia", "angular_damping", "moment", "moment")
GAINS = (("K_p", "proportional_gain"), ("K_i", "integral_gain"), ("K_d", "derivative_gain"))


def channels(_settings: DriveLog | None) -> tuple[Channel, ...]:
    """Columns of the log."""
    return (
        Channel("time", "time", unit="s"), Channel("command", "length", unit="mm"), Channel("position", "length", unit="mm"),
        Channel("output", "voltage"), Channel("torque", "moment", False), Channel("current", "current", False),
    )  # fmt: skip


class Log(NamedTuple):
    """Samples (n,)."""

    sample_time: float  # [s]
    command: FloatArray  # [m]
    position: FloatArray  # [m]
    output: FloatArray  # [V]
    torque: FloatArray  # [N m]


def calibrate(data: Measurement, settings: DriveLog) -> Finding:
    """Fit the plant over windows and the gains sample by sample."""
    _gains_read_plainly(settings)
    log = _log(data, settings)
    fits = [_plant(data, log, settings, delay) for delay in (0, 1)]
    delay = 0 if fits[0].scale <= fits[1].scale else 1
    fit = fits[delay]
    gains, doubt, of_gains = _gains(log, settings)
    values = (*(plain(fit, k) for k in range(4)), *gains)
    axis = settings.drive.axis or "x"
    block: dict[str, Any] = written(values[:2], "plant", data.rows) | written(gains, "gains", data.rows)
    block["friction"] = written(values[2:4], "plant", data.rows)
    negative = [f"{value.name} is negative" for value in values[:2] if value.value < 0.0]
    failed = list(negative)
    if fit.lag_1 > CORRELATED:
        failed.append(
            f"neighbouring windows have residuals that correlate by {fit.lag_1:.2f}: the residual is not noise"
        )
    names = [f"{axis}.{name}" for name in ("J", "B", "friction.coulomb_plus", "friction.coulomb_minus")]
    shown = [
        ("delay", "rms of the windows"),
        *((str(k), units.show(one.scale, "moment", 4)) for k, one in enumerate(fits)),
    ]
    covariances = {"plant": covariance_block(fit, names, DIMENSIONS)}
    if gains:
        covariances["gains"] = covariance_block(
            of_gains, [f"{axis}.{value.name}" for value in gains], [value.dimension for value in gains]
        )
    return Finding(
        "coulomb", values, {axis: block}, covariances, fit.scale, "moment",
        rms(fit.left_out),
        "rms of the mean torque of a window", "moment", fit, drawn(fit.posed, fit.residual), tuple(shown),
        (*(f"{text}, which no drive is; written as it is" for text in negative), *doubt,
         *(() if settings.drive.axis else ("drive.axis is not given: written as those of axis x",))),
        ("static friction and the speeds over which it fades: such a log does not hold them; torque is that of the motor's "
         "current, less whatever the cut takes", *poorly_seen(fit)),
        ("slow reversals, for static friction",), tuple(failed), fit.outliers, fit.condition, unknown_combinations(fit),
    )  # fmt: skip


def _gains_read_plainly(settings: DriveLog) -> None:
    """Refuse to put gains into an entry whose gains are not meant as they are printed."""
    label = settings.machine.library
    reading = library.labelled("machines", label).values.at(("reading",)) if label else None
    if reading is not None and reading.value != "as_printed":
        raise ScenarioFault([Fault(
            ("machine", "library"),
            f"the gains of {label} are read as {reading.value}, and fitted ones are meant as they are; leave machine.library out "
            "and put the new values into an entry of your own, with reading: as_printed",
        )])  # fmt: skip


def _log(data: Measurement, settings: DriveLog) -> Log:
    """The log with what is wrong with it."""
    columns, faults = data.columns, []
    time = columns["time"]
    step = np.diff(time)
    usual = float(np.median(step))
    uneven = np.flatnonzero(np.abs(step - usual) > _UNEVEN * abs(usual))
    if usual <= 0.0 or len(uneven):
        row = int(uneven[0]) + 1 if len(uneven) else 1
        faults.append(data.fault(f"time is not uniform: the usual step is {units.show(usual, 'time', 4)}", row))
    if "torque" not in columns and "current" not in columns:
        faults.append(data.fault("needs a column torque [N m], or current [A] and drive.K_t"))
    if "torque" not in columns and "current" in columns and settings.drive.K_t is None:
        faults.append(data.fault("current alone needs the torque per ampere: --set drive.K_t='0.4769 N m/A'"))
    output, limit = columns["output"], settings.drive.saturation
    limit = float(np.max(np.abs(output))) if limit is None else limit  # an output that is cut off stands at its largest
    if limit > 0.0 and np.mean(np.abs(output) >= limit * (1.0 - 1e-9)) > 0.5:
        shown = units.show(limit, "voltage")
        faults.append(data.fault(f"the output is saturated for more than half of the log ({shown}): move slower"))
    if faults:
        raise ScenarioFault(faults)
    torque = columns["torque"] if "torque" in columns else columns["current"] * (settings.drive.K_t or 0.0)
    return Log(usual, columns["command"], columns["position"], output, torque)


def _plant(data: Measurement, log: Log, settings: DriveLog, delay: int) -> Fit:
    """Momentum over windows, the torque as many samples late as the delay says."""
    ts, angle = log.sample_time, log.position / settings.drive.r_g
    torque = np.concatenate([np.full(delay, log.torque[0]), log.torque[: len(log.torque) - delay]])
    speed = signal.savgol_filter(angle, 2 * HALF + 1, 3, deriv=1, delta=ts)
    starts = np.arange(HALF, len(angle) - HALF - WINDOW, WINDOW)
    inside = np.stack([speed[starts + k] for k in range(WINDOW + 1)])
    used = (np.abs(inside).min(axis=0) > FAST) & (np.abs(np.sign(inside).sum(axis=0)) == WINDOW + 1)
    starts = starts[used]
    if len(starts) < 6:
        raise ScenarioFault([data.fault(
            f"only {len(starts)} windows of {WINDOW} samples turn one way at more than {FAST:g} rad/s; at least 6 are needed: move "
            "further or faster"
        )])  # fmt: skip
    span, ends = WINDOW * ts, starts + WINDOW
    forward = speed[starts] > 0.0
    matrix = np.column_stack([
        (speed[ends] - speed[starts]) / span, (angle[ends] - angle[starts]) / span, forward.astype(float), (~forward).astype(float)
    ])  # fmt: skip
    summed = np.concatenate([[0.0], np.cumsum(torque)])
    mean = (summed[ends] - summed[starts]) / WINDOW
    size = float(np.sqrt(np.mean(mean**2)))
    unknowns = tuple(
        Unknown(name, dimension, 0.0, True, size if dimension == "moment" else 0.0)
        for name, dimension in zip(NAMES, DIMENSIONS, strict=True)
    )
    posed = Posed(
        unknowns, mean, starts, np.zeros(len(starts), dtype=np.int64), ("torque",), ("moment",),
        lambda x: np.asarray(matrix @ x), lambda _: matrix, blocks=np.zeros(len(starts), dtype=np.int64),
    )  # fmt: skip
    share = settings.fit.hold_out
    apart = [[int(row)] for row in starts] if share is None else folds(share, data.rows)
    return fitted(posed, loss=settings.fit.loss, level=settings.fit.level, prior=settings.fit.prior, folds=apart)


def _gains(log: Log, settings: DriveLog) -> tuple[tuple[Value, ...], tuple[str, ...], Fit]:
    """PID gains where the output is not saturated, with the delay of the output that fits better."""
    error = log.command - log.position
    ts, limit = log.sample_time, settings.drive.saturation or np.inf
    matrix = np.column_stack([error, np.cumsum(error) * ts, np.diff(error, prepend=error[0]) / ts])
    free = np.abs(log.output) < limit * (1.0 - 1e-9)
    free[0] = False
    used = np.flatnonzero(free)
    unknowns = tuple(Unknown(name, dimension, 0.0, True) for name, dimension in GAINS)
    chosen = matrix[used]
    posed = Posed(
        unknowns, log.output[used], used, np.zeros(len(used), dtype=np.int64), ("output",), ("voltage",),
        lambda x: np.asarray(chosen @ x), lambda _: chosen,
    )  # fmt: skip
    fit = fitted(posed, level=settings.fit.level)
    size = float(np.sqrt(np.mean(posed.measured**2)))
    if fit.scale > 0.05 * size:
        said: tuple[Any, ...] = (
            f"the output is not that of a PID controller on the position error: {fit.scale / size:.0%} of it are left",
        )
        return (), said, fit
    return tuple(plain(fit, k) for k in range(3)), (), fit
