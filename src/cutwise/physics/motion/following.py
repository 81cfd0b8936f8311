"""Feed drives that follow a programmed motion of any kind: an edge with its lead-in, a ball along a chamfer."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import inlined_stepping
from cutwise.maths.curves import FloatArray
from cutwise.physics.motion.drives import LOAD, SPEED, Axis, at_rest, fed, served
from cutwise.records import Pose
from cutwise.stages import driven, moved


class Followed(NamedTuple):
    r"""A programmed motion, and the drives of x, y and so on that follow its set points.

    Process axes do not turn. With their columns R in the axes of the machine, the tool is where the axes are,
    :math:`p = R^T m`, along x, y and z of the process; an axis without a drive is where it is told.
    """

    motion: NamedTuple
    pace: FloatArray  # [s] of the programmed motion at the servo instants, shape (n,)
    axes: tuple[Axis, ...]  # x, y, and z if it has a drive
    turn: FloatArray  # R, shape (3, 3)
    point: FloatArray  # set points of the axes [m], shape (n, 3)
    velocity: FloatArray  # [m/s], shape (n, 3)
    acceleration: FloatArray  # [m/s^2], shape (n, 3)
    substeps: int  # in a servo step
    state: FloatArray  # of the axes, shape (a, 8); changes
    clock: npt.NDArray[np.int64]  # substeps so far, shape (1,); changes
    position: FloatArray  # of the axes at the servo instants [m], shape (n, a); written
    clipped: npt.NDArray[np.int64]  # servo steps with a controller at its limit, shape (1,); changes


def followed(
    motion: NamedTuple, pace: FloatArray, axes: tuple[Axis, ...], turn: FloatArray, substeps: int
) -> Followed:  # fmt: skip
    """Drives at rest on the first place of a programmed motion, whose time at the servo instants is given [s]."""
    place = np.array([[*moved(motion, float(time))[2:5]] for time in pace])
    point = np.ascontiguousarray(place @ turn.T)
    step = axes[0].law.sample_time
    velocity = np.gradient(point, step, axis=0)
    return Followed(
        motion, pace, axes, np.ascontiguousarray(turn), point, velocity, np.gradient(velocity, step, axis=0), substeps,
        at_rest(point[0, : len(axes)]), np.zeros(1, dtype=np.int64), point[:, : len(axes)].copy(),
        np.zeros(1, dtype=np.int64),
    )  # fmt: skip


def deviation(motion: Followed) -> FloatArray:
    """Actual against commanded place at the servo instants, process axes [m], shape (n, 3)."""
    off = np.zeros_like(motion.point)
    off[:, : len(motion.axes)] = motion.position - motion.point[:, : len(motion.axes)]
    return np.asarray(off @ motion.turn)


@inlined_stepping
def instant(clock: int, substeps: int, last: int) -> tuple[int, int, float]:
    """Servo steps of now and after it, and the part of the first that is over; the last one goes on.

    Valid for any step from 0 on.

    Examples
    --------
    Three of ten substeps after the second servo instant; and beyond the last:

    >>> instant(23, 10, 5)
    (2, 3, 0.3)
    >>> instant(57, 10, 5)
    (5, 5, 0.0)

    References
    ----------
    Derived here.
    """
    step, part = clock // substeps, clock % substeps
    if step >= last:
        return last, last, 0.0
    return step, step + 1, part / substeps


@moved.of(Followed)
def _(motion, time):
    """Where the axes are, in process axes; the programmed motion says where along the path that is meant to be."""
    k, after, part = instant(motion.clock[0], motion.substeps, motion.pace.size - 1)
    pace = motion.pace[k] + part * (motion.pace[after] - motion.pace[k])
    pose = moved(motion.motion, pace)
    rate = (motion.pace[after] - motion.pace[k]) / motion.axes[0].law.sample_time if after > k else 0.0
    turn, state = motion.turn, motion.state
    x = y = z = vx = vy = vz = 0.0
    for a in range(3):
        told = turn[a, 0] * pose.x + turn[a, 1] * pose.y + turn[a, 2] * pose.z
        speed = rate * (turn[a, 0] * pose.vx + turn[a, 1] * pose.vy + turn[a, 2] * pose.vz)
        if a < len(motion.axes):
            told = state[a, LOAD]
            speed = state[a, SPEED] * motion.axes[a].plant.transmission
        x, y, z = x + turn[a, 0] * told, y + turn[a, 1] * told, z + turn[a, 2] * told
        vx, vy, vz = vx + turn[a, 0] * speed, vy + turn[a, 1] * speed, vz + turn[a, 2] * speed
    return Pose(time, pose.along, x, y, z, vx, vy, vz, 0.0)


@driven.of(Followed)
def _(motion, pose, load, dt):
    """A servo step measures, computes the voltage and holds it; the axes are stepped exactly under force and friction."""
    k, part = motion.clock[0] // motion.substeps, motion.clock[0] % motion.substeps
    k = min(k, motion.pace.size - 1)
    axes, state, turn, total = motion.axes, motion.state, motion.turn, load.total
    if part == 0:
        limited = False
        for a in range(len(axes)):
            motion.position[k, a] = state[a, LOAD]
            if served(axes[a], state, a, motion.point[k, a], motion.velocity[k, a], motion.acceleration[k, a]):
                limited = True
        if limited:
            motion.clipped[0] += 1
    for a in range(len(axes)):
        fed(axes[a], state, a, turn[a, 0] * total[0] + turn[a, 1] * total[1] + turn[a, 2] * total[2])
    motion.clock[0] += 1
    return 0
