"""A tool that feed drives move: their position loops are stepped with the cell, under the force of the cut."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, inlined_stepping
from cutwise.maths.curves import FloatArray
from cutwise.physics.motion.drives import APPLIED, LOAD, SPEED, Axis, at_rest, fed, served
from cutwise.records import Pose
from cutwise.stages import driven, moved


class SetPoints(NamedTuple):
    """What the axes are told at the servo instants, ``n`` of them; axis ``a`` moves along coordinate ``a``."""

    point: FloatArray  # [m], shape (n, a)
    velocity: FloatArray  # [m/s], shape (n, a)
    acceleration: FloatArray  # [m/s^2], shape (n, a)
    heading: FloatArray  # commanded direction of feed in the xy plane [rad], shape (n,)
    along: FloatArray  # commanded place along the path [m], shape (n,)


class DriveLog(NamedTuple):
    """What drives did, written in place at the servo instants and over the step behind each."""

    position: FloatArray  # of the load before the step [m], shape (n, a)
    speed: FloatArray  # of the load side of the motor, r_g w [m/s], shape (n, a)
    voltage: FloatArray  # held over the step [V], shape (n, a)
    clipped: npt.NDArray[np.bool_]  # controller at its limit, shape (n, a)
    force: FloatArray  # mean over the step, on the tool in machine axes [N], shape (n, 3)
    force_peak: FloatArray  # largest magnitude in the step of x, y, z and of the xy vector [N], shape (n, 4)


class Driven(NamedTuple):
    """Feed drives along x, y and so on that follow set points along a wall."""

    axes: tuple[Axis, ...]  # x, y, and z if it has a drive
    order: SetPoints
    substeps: int  # in a servo step
    side: float  # 1.0: the work stands on the right of the feed, -1.0: on the left
    height: float  # [m] of the commanded lowest point of the tool above the uncut surface
    state: FloatArray  # of the axes, shape (a, 8); changes
    clock: npt.NDArray[np.int64]  # servo step of now, and substep in it, shape (2,); changes
    log: DriveLog


class DrivenPlane(NamedTuple):
    """Feed drives whose tool, and the force on it, are told in the axes of the machine: for paths that turn."""

    axes: tuple[Axis, ...]  # x, y, and z if it has a drive
    order: SetPoints
    substeps: int  # in a servo step
    state: FloatArray  # of the axes, shape (a, 8); changes
    clock: npt.NDArray[np.int64]  # servo step of now, and substep in it, shape (2,); changes
    log: DriveLog


def driven_plane(axes: tuple[Axis, ...], order: SetPoints, substeps: int) -> DrivenPlane:
    """The same drives in the axes of the machine."""
    along_wall = driven_tool(axes, order, substeps, 1.0, 0.0)
    return DrivenPlane(axes, order, substeps, along_wall.state, along_wall.clock, along_wall.log)


def driven_tool(axes: tuple[Axis, ...], order: SetPoints, substeps: int, side: float, height: float) -> Driven:
    """Drives at rest on their first set point."""
    n, count = order.point.shape
    log = DriveLog(
        np.empty((n, count)), np.empty((n, count)), np.empty((n, count)), np.zeros((n, count), dtype=bool),
        np.zeros((n, 3)), np.zeros((n, 4)),
    )  # fmt: skip
    return Driven(axes, order, substeps, side, height, at_rest(order.point[0]), np.zeros(2, dtype=np.int64), log)


@compiled
def process_parts(x: float, y: float, heading: float, side: float) -> tuple[float, float]:
    r"""Parts of a vector of the xy plane along the feed and off the work, and the way back.

    .. math:: a = x\cos\vartheta + y\sin\vartheta, \qquad b = \sigma(-x\sin\vartheta + y\cos\vartheta)

    with the work on the right for :math:`\sigma = 1`, on the left for :math:`\sigma = -1`.

    Parameters
    ----------
    x, y : float
        The vector in machine axes, any unit.
    heading : float
        Direction of feed :math:`\vartheta` [rad] from x.
    side : float
        :math:`\sigma`, 1 or -1.

    Returns
    -------
    tuple
        a along the feed, b off the work, in that unit. Valid for any heading.

    Examples
    --------
    Feed along y, work on its right, at larger x:

    >>> [round(part, 9) for part in process_parts(3.0, 4.0, 0.5 * math.pi, 1.0)]
    [4.0, -3.0]

    References
    ----------
    Derived here: a rotation, and a mirror for the work on the left.
    """
    c, s = math.cos(heading), math.sin(heading)
    return x * c + y * s, side * (y * c - x * s)


@compiled
def machine_parts(along: float, off: float, heading: float, side: float) -> tuple[float, float]:
    r"""A vector along the feed and off the work in the xy plane of the machine: the inverse of :func:`process_parts`.

    .. math:: x = a\cos\vartheta - \sigma b\sin\vartheta, \qquad y = a\sin\vartheta + \sigma b\cos\vartheta

    Parameters
    ----------
    along, off : float
        a along the feed and b off the work, any unit.
    heading : float
        Direction of feed :math:`\vartheta` [rad] from x.
    side : float
        :math:`\sigma`, 1: work on the right, -1: on the left.

    Returns
    -------
    tuple
        x and y in that unit. Valid for any heading.

    Examples
    --------
    >>> [round(part, 9) for part in machine_parts(4.0, -3.0, 0.5 * math.pi, 1.0)]
    [3.0, 4.0]

    References
    ----------
    Derived here.
    """
    c, s = math.cos(heading), math.sin(heading)
    return along * c - side * off * s, along * s + side * off * c


@moved.of(Driven)
def _(motion, time):
    """The commanded place, and what the axes deviate from it, in the process axes of the commanded direction."""
    order, state = motion.order, motion.state
    k = motion.clock[0]
    axes = motion.axes
    heading = order.heading[k]
    ahead, off = process_parts(
        state[0, LOAD] - order.point[k, 0], state[1, LOAD] - order.point[k, 1], heading, motion.side
    )
    forward, sideways = process_parts(
        state[0, SPEED] * axes[0].plant.transmission, state[1, SPEED] * axes[1].plant.transmission, heading, motion.side
    )
    up, climb = 0.0, 0.0
    if len(axes) > 2:
        up = state[2, LOAD] - order.point[k, 2]
        climb = state[2, SPEED] * axes[-1].plant.transmission
    along = order.along[k]
    return Pose(time, along, along + ahead, motion.height + off, up, forward, sideways, climb, 0.0)


@moved.of(DrivenPlane)
def _(motion, time):
    """Where the axes have the tool."""
    order, state, axes = motion.order, motion.state, motion.axes
    k = motion.clock[0]
    z, vz = 0.0, 0.0
    if len(axes) > 2:
        z, vz = state[2, LOAD], state[2, SPEED] * axes[-1].plant.transmission
    return Pose(
        time, order.along[k], state[0, LOAD], state[1, LOAD], z, state[0, SPEED] * axes[0].plant.transmission,
        state[1, SPEED] * axes[1].plant.transmission, vz, 0.0,
    )  # fmt: skip


@inlined_stepping
def served_and_fed(motion, fx: float, fy: float, fz: float) -> None:  # type: ignore[no-untyped-def]
    """A servo step measures, computes the voltage and holds it; the axes are stepped exactly under force and friction.

    Parameters
    ----------
    motion : Driven or DrivenPlane
        Drives with their set points; state, clock and log are changed in place.
    fx, fy, fz : float
        Force on the tool in machine axes [N], constant over the substep.

    Notes
    -----
    Valid for axes that share nothing but the tool, and a force that moves little within a substep. The log keeps the mean
    force of a servo step and its peaks; a call beyond the last set point is not allowed.

    Examples
    --------
    1 mm behind at 2000 V/m: 2 V, 1 N m, 100 rad/s^2 on 0.01 kg m^2, 0.005 mm after the first 10 ms at 1 mm/rad.

    >>> from cutwise.physics.motion.drives import Controller, Drive, Plant
    >>> plant = Plant(1.0, 0.5, 0.01, 0.0, 0.001, 0.0, 0.0, 0.0, 0.0, 1.0, -1.0, 1.0, -1.0, 0.0)
    >>> drive = Drive(plant, Controller(2000.0, 0.0, 0.0, 0.0, 0.0, 0.01, 10.0, 0.0, 0.0))
    >>> from cutwise.physics.motion.drives import axes_of
    >>> still, place = np.zeros((2, 2)), np.zeros((2, 2))
    >>> told = driven_plane(axes_of([drive, drive], 1), SetPoints(place, still, still, np.zeros(2), np.zeros(2)), 1)
    >>> told.order.point[0, 0] = 0.001
    >>> served_and_fed(told, 0.0, 0.0, 0.0)
    >>> round(1e3 * float(told.state[0, LOAD]), 9), int(told.clock[0])
    (0.005, 1)

    References
    ----------
    Ozcan et al. 2017, secs. 2.2 and 2.3, Figs. 1 and 2 (the drive and its loop); the exact step is derived here.
    """
    order, state, log, axes = motion.order, motion.state, motion.log, motion.axes
    k, part = motion.clock[0], motion.clock[1]
    if part == 0:
        for a in range(len(axes)):
            log.position[k, a] = state[a, LOAD]
            log.speed[k, a] = state[a, SPEED] * axes[a].plant.transmission
            log.clipped[k, a] = served(
                axes[a], state, a, order.point[k, a], order.velocity[k, a], order.acceleration[k, a]
            )
            log.voltage[k, a] = state[a, APPLIED]
    force = (fx, fy, fz)
    for i in range(3):
        log.force[k, i] += force[i]
        log.force_peak[k, i] = max(log.force_peak[k, i], abs(force[i]))
    log.force_peak[k, 3] = max(log.force_peak[k, 3], fx * fx + fy * fy)
    for a in range(len(axes)):
        fed(axes[a], state, a, force[a])
    part += 1
    if part == motion.substeps:  # sums become means, the square a length
        for i in range(3):
            log.force[k, i] /= motion.substeps
        log.force_peak[k, 3] = math.sqrt(log.force_peak[k, 3])
        motion.clock[0], part = k + 1, 0
    motion.clock[1] = part


@driven.of(DrivenPlane)
def _(motion, pose, load, dt):
    served_and_fed(motion, load.total[0], load.total[1], load.total[2])
    return 0


@driven.of(Driven)
def _(motion, pose, load, dt):
    """The force is told in process axes."""
    k = motion.clock[0]
    fx, fy = machine_parts(load.total[0], load.total[1], motion.order.heading[k], motion.side)
    served_and_fed(motion, fx, fy, load.total[2])
    return 0
