"""What a milling run with drives tells over time, and of its position loops over frequency."""

import math

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.physics.motion.loop import open_loop, sampled_response
from cutwise.process.labels import Column, Coordinate, Group, Over
from cutwise.process.milling import MillRun, wall_left


def _axes(done: MillRun) -> list[str]:
    """The axes that have a drive."""
    return list("xyz"[: len(done.drives)])


def _told(done: MillRun) -> FloatArray:
    return np.ascontiguousarray(done.reference.point[:, : len(done.drives)])


def _torque(done: MillRun) -> FloatArray:
    plants = [drive.plant for drive in done.drives]
    return np.asarray(done.history.voltage * np.array([p.current_gain * p.torque_constant for p in plants]))


def _cut_torque(done: MillRun) -> FloatArray:
    travel = np.array([drive.plant.transmission for drive in done.drives])
    return np.asarray(done.history.force[:, : len(travel)] * travel)


def _hertz(done: MillRun) -> FloatArray:
    return np.geomspace(0.5, 0.98 * 0.5 / done.drives[0].law.sample_time, 300)


def _loop_gain(done: MillRun, *, held: bool) -> np.ndarray:
    """Gain of the open position loop of each axis, continuous or sampled, shape (frequencies, axes)."""
    w = 2.0 * math.pi * _hertz(done)
    return np.column_stack([(sampled_response if held else open_loop)(w, *drive) for drive in done.drives])


def _closed(gain: np.ndarray) -> FloatArray:
    return np.asarray(np.abs(gain / (1 + gain)))


def _phase(response: np.ndarray) -> FloatArray:
    """Continuous phase of responses over their first axis, starting between -360° and 0 [rad]."""
    phase = np.unwrap(np.angle(response), axis=0)
    return np.asarray(phase - 2.0 * math.pi * np.ceil(phase[0] / (2.0 * math.pi)))


_TIME = Coordinate(lambda done: done.reference.time, "s", "time")
_OVER: Over = {"time": _TIME, "axis": _axes, "frequency": Coordinate(_hertz, "Hz", "frequency")}
_IN_SPACE: Over = {"time": _TIME, "axis": "xyz"}
_IN_PLANE: Over = {"time": _TIME, "axis": "xy"}
GROUPS = {
    "motion": Group({
        "travelled": Column("time", lambda done: done.reference.travelled, "m", "way along the path"),
        "commanded": Column("time axis", _told, "m", "commanded position of the tool centre"),
        "actual": Column("time axis", lambda done: done.history.position, "m", "actual position of the tool centre"),
        "speed_planned": Column("time", lambda done: done.reference.speed, "m/s", "planned speed along the path"),
        "speed_actual": Column("time", lambda done: np.hypot(done.history.speed[:, 0], done.history.speed[:, 1]), "m/s",
                               "actual speed"),
        "tracking_error": Column("time axis", lambda done: _told(done) - done.history.position, "m",
                                 "set point minus actual position"),
        "voltage": Column("time axis", lambda done: done.history.voltage, "V", "output of the controllers"),
        "motor_torque": Column("time axis", _torque, "N*m", "motor torque"),
        "cutting_torque": Column("time axis", _cut_torque, "N*m", "mean torque of the cut on the motor in a sample"),
        "saturated": Column("time axis", lambda done: done.history.clipped.astype(float), "1", "controller at its limit"),
        "open_loop_gain": Column("frequency axis", lambda done: np.abs(_loop_gain(done, held=False)), "1",
                                 "magnitude of the continuous loop gain"),
        "open_loop_phase": Column("frequency axis", lambda done: _phase(_loop_gain(done, held=False)), "rad",
                                  "phase of the continuous loop gain"),
        "closed_loop_gain": Column("frequency axis", lambda done: _closed(_loop_gain(done, held=False)), "1",
                                   "magnitude of the continuous closed loop"),
        "sampled_closed_loop_gain": Column("frequency axis", lambda done: _closed(_loop_gain(done, held=True)), "1",
                                           "magnitude of the sampled closed loop"),
        "sampled_open_loop_gain": Column("frequency axis", lambda done: np.abs(_loop_gain(done, held=True)), "1",
                                         "magnitude of the sampled loop gain"),
        "sampled_open_loop_phase": Column("frequency axis", lambda done: _phase(_loop_gain(done, held=True)), "rad",
                                          "phase of the sampled loop gain"),
    }, _OVER),
    "engagement": Group({
        "immersion": Column("time", lambda done: done.contact.immersion, "rad", "immersion angle"),
        "block": Column("time", lambda done: done.reference.block.astype(float), "1", "block of the path"),
        "removal": Column("time", lambda done: done.contact.removal, "m**2", "cross-section taken per length of feed"),
    }, _OVER),
    "cutting": Group({
        "force": Column("time axis", lambda done: done.history.force, "N", "mean force on the tool over a sample"),
        "force_peak": Column("time axis", lambda done: done.history.force_peak[:, :3], "N",
                             "largest force on the tool in a sample"),
        "force_xy_peak": Column("time", lambda done: done.history.force_peak[:, 3], "N",
                                "largest force in the xy plane in a sample"),
    }, _IN_SPACE),
    "surface": Group({
        "contour_error": Column("time", lambda done: done.contour_error, "m",
                                "distance from the path, positive to its right (into the wall)"),
    }, _OVER),
    "scene": Group({
        "height": Column("time", lambda done: done.reference.point[:, 2], "m", "height of the tip as programmed"),
        "line": Column("time", lambda done: done.path.source[done.reference.block].astype(np.int32), "1",
                       "line of the program, 0: none"),
        "rapid": Column("time", lambda done: np.isinf(done.path.feed[done.reference.block]).astype(np.int8), "1",
                        "whether it is a rapid move"),
        "cuts": Column("time", lambda done: done.path.cuts[done.reference.block].astype(np.int8), "1", "whether the block cuts"),
    }, _OVER),
    "structure": Group({
        "tip": Column("time axis", lambda done: done.history.tip[:, :2], "m",
                      "mean displacement of the tool tip by its modes in a sample"),
        "tip_peak": Column("time", lambda done: done.history.tip[:, 2], "m", "largest displacement of the tip in a sample"),
        "wall_error_min": Column("time", lambda done: wall_left(done)[:, 0], "m",
                                 "least error of the wall left in a sample, positive into the wall"),
        "wall_error_max": Column("time", lambda done: wall_left(done)[:, 1], "m",
                                 "greatest error of the wall left in a sample, positive into the wall"),
    }, _IN_PLANE, lambda done: done.tip_swings),
}  # fmt: skip
