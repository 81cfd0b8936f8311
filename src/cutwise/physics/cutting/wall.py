"""Climb milling along a wall whose direction turns: the flute kernel in the frame of the machine."""

import math

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.cutting.discs import Discs, disc_forces
from cutwise.physics.cutting.flute import EdgeCoefficients, FluteForce, Mill, mean_force, tooth_force

FloatArray = npt.NDArray[np.float64]

AVERAGED, FLUTES, DISCS = 1, 2, 3


@compiled
def _to_machine(force: FluteForce, heading: float) -> tuple[float, float, float]:
    """A force of the flute kernel (x along the heading) in machine axes; a right-hand helix pulls down."""
    c, s = math.cos(heading), math.sin(heading)
    return force.x * c - force.y * s, force.x * s + force.y * c, -force.z


@compiled
def wall_force(
    law: int, angle: float, heading: float, arc: float, feed_x: float, feed_y: float, depth: float, mill: Mill,
    discs: Discs, k: EdgeCoefficients,
) -> tuple[float, float, float]:  # fmt: skip
    r"""Force on a mill that turns clockwise and has the wall to the right of its heading.

    The cut is the arc :math:`[\pi - \alpha, \pi]` of the flute kernel, whose frame is turned by the heading; where the
    tool does not move along the heading, the chip follows its true direction and is cut where it is positive.

    Parameters
    ----------
    law : int
        ``AVERAGED`` over a revolution, or tooth by tooth with ``FLUTES`` (closed form) or ``DISCS`` (midpoint rule).
    angle : float
        Angle of flute 0 at the tip in machine axes [rad], falling with time.
    heading : float
        Direction of the commanded path [rad].
    arc : float
        Immersion angle :math:`\alpha` [rad].
    feed_x, feed_y : float
        Displacement of the tool centre per tooth [m].
    depth : float
        Axial depth [m].
    mill, discs, k
        The mill, its discs (``DISCS`` only), and the force coefficients.

    Returns
    -------
    tuple
        Force on the tool x, y, z in machine axes [N].
    """
    if law == DISCS:
        return disc_forces(angle, heading - 0.5 * math.pi, arc, feed_x, feed_y, discs, k)
    chip = math.hypot(feed_x, feed_y)
    theta = (heading - math.atan2(feed_y, feed_x) + math.pi) % (2.0 * math.pi) - math.pi
    lo, hi = max(math.pi - arc, theta), min(math.pi, theta + math.pi)
    if law == AVERAGED:
        return _to_machine(mean_force(lo, hi, chip, theta, depth, mill.flutes, k), heading)
    rotation = 0.5 * math.pi + heading - angle
    return _to_machine(tooth_force(rotation, lo, hi, chip, theta, 0.0, depth, mill, k), heading)


@compiled
def tooth_period(
    law: int, arc: float, chip: float, depth: float, mill: Mill, discs: Discs, k: EdgeCoefficients, positions: int
) -> FloatArray:
    """Forces over a tooth period at a steady feed per tooth along +x; shape (positions, 3) [N]."""
    out = np.empty((positions, 3))
    for i in range(positions):
        angle = -2.0 * math.pi * i / (positions * mill.flutes)
        out[i, 0], out[i, 1], out[i, 2] = wall_force(law, angle, 0.0, arc, chip, 0.0, depth, mill, discs, k)
    return out
