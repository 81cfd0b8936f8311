"""A spindle on pistons, whatever it cuts: the records of its device, what its pistons do, and when nothing can be said."""

import math
from collections.abc import Iterator

import numpy as np

from cutwise import units
from cutwise.maths.constants import GRAVITY
from cutwise.maths.curves import FloatArray
from cutwise.physics.structure.pistons import PistonRing, piston_directions
from cutwise.physics.structure.seals import (
    NO_FRICTION,
    PRESLIDING,
    REGULARISED,
    SET_VALUED,
    Piston,
    friction_at,
)
from cutwise.physics.structure.statics import characteristic
from cutwise.physics.structure.terms import Pistons
from cutwise.process.carriage import Terms
from cutwise.process.passes import at_stop, drifting
from cutwise.results import Finding, Place, warned
from cutwise.spec.carrier import CarryingRobot
from cutwise.spec.spindle import CompliantSpindle

_FRICTION = {"none": NO_FRICTION, "set_valued": SET_VALUED, "presliding": PRESLIDING, "regularised": REGULARISED}
_SLIGHT = 0.1  # of the force at which the spindle yields: a smaller weight is not mentioned
_SOLVER_TOLERANCE = 1e-6  # [N] of the piston forces: tighter costs hundreds of sweeps and changes nothing


def piston_ring(
    spindle: CompliantSpindle, robot: CarryingRobot | None = None, axes: FloatArray | None = None
) -> PistonRing:
    """The compliance device at its pressure: piston force in proportion, seal friction with its preload share.

    On a robot the base says which way is down, unless the spindle does.

    Parameters
    ----------
    robot, axes : CarryingRobot, array (3, 3)
        What carries the spindle, and the process axes in its base, a column each.
    """

    def friction(force: float) -> float:
        return friction_at(force, spindle.pressure, spindle.reference_pressure, spindle.friction_preload_fraction)

    moment = weight(spindle)
    if robot is not None and axes is not None and "gravity" not in spindle.model_fields_set:
        moment = np.linalg.norm(moment) * (np.array(robot.down) @ axes)
    return PistonRing(
        piston_directions(spindle.pistons, spindle.piston_azimuth),
        Piston(
            spindle.stroke,
            spindle.piston_force * spindle.pressure / spindle.reference_pressure,
            friction(spindle.friction_static),
            friction(spindle.friction_dynamic),
            _FRICTION[spindle.friction] if spindle.friction_static > 0.0 else NO_FRICTION,
            spindle.breakaway_travel or math.inf,
            spindle.stribeck_velocity or 0.0,
            spindle.seal_damping or 0.0,
        ),
        spindle.piston_arm,
        spindle.inertia,
        float(moment[0]),
        float(moment[1]),
        _SOLVER_TOLERANCE,
    )


def weight(spindle: CompliantSpindle) -> FloatArray:
    """Weight of the motor times the distance of its centre from the joint, along the direction of gravity [N m]."""
    if spindle.gravity == "off" or spindle.mass is None or spindle.centre_of_mass is None:
        return np.zeros(3)
    return spindle.mass * GRAVITY * spindle.centre_of_mass * np.array(spindle.gravity)


def pistons_of(
    spindle: CompliantSpindle | None, robot: CarryingRobot | None = None, axes: FloatArray | None = None, *,
    ring: PistonRing | None = None,
) -> Terms:  # fmt: skip
    """The compliant spindle as the first term of a structure, if there is one; on a ring made already."""
    if spindle is None:
        return ()
    return (("pistons", Pistons(ring or piston_ring(spindle, robot, axes), spindle.tool_reach)),)


def travel(spindle: CompliantSpindle, columns: FloatArray) -> FloatArray:
    """Travel of the piston that has gone farthest [m], shape (n,), from the columns of a structure with the spindle first."""
    return np.asarray(columns[:, 4 : 4 + spindle.pistons].max(axis=1))


def stroke_left(spindle: CompliantSpindle | None, columns: FloatArray) -> dict[str, float]:
    """The measure of what is left of the stroke, from the columns of a structure with the spindle first, if there is one."""
    return {} if spindle is None else {"stroke_margin": spindle.stroke - float(travel(spindle, columns).max())}


def weight_on(ring: PistonRing, reach: float, where: Place) -> Iterator[Finding]:
    """A weight that alone moves the tip, one that keeps it from coming back, or one that leans on it."""
    force = math.hypot(ring.moment_x, ring.moment_y) / reach
    statics = characteristic(ring, reach)
    out, back = statics.loading.breakaway, statics.unloading.breakaway
    if force > out:
        yield Finding("weight_moves", where, force, out, "force")
    elif force > back:
        yield Finding("weight_stays", where, force, back, "force")
    elif force > _SLIGHT * out:
        yield Finding("weight_leans", where, force, out, "force")


def overload(spindle: CompliantSpindle | None, power: float) -> Iterator[Finding]:
    """A mean cutting power [W] above the rating of the motor, if there is one and that is known."""
    rating = None if spindle is None else spindle.power_rating
    if rating is not None and power > rating:
        yield warned(
            "motor_overloaded", f"cutting takes {units.show(power, 'power')}, more than the motor's {units.show(rating, 'power')}: "
            "it will slow down or stall; reduce feed or depth of cut", power, rating, "power",
        )  # fmt: skip


def findings(
    spindle: CompliantSpindle | None, time: FloatArray, columns: FloatArray, off: FloatArray, cut: np.ndarray
) -> Iterator[Finding]:
    """At the stop, or still moving off the work over the last quarter of the cut.

    Parameters
    ----------
    time, off : array (n,)
        [s], and displacement off the work by the spindle [m].
    columns : array (n, k)
        Of the structure, the spindle first.
    cut : array (n,)
        Where the tool is in the cut.
    """
    if spindle is None:
        return
    yield from at_stop(time, travel(spindle, columns), spindle.stroke)
    rows = np.flatnonzero(cut)
    last = rows[int(0.75 * len(rows)) :]
    if len(last):
        yield from drifting(float(time[last[0]]), off[last])
