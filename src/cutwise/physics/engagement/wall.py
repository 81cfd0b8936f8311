"""Immersion along a whole path of lines and arcs, every inner corner seen by :mod:`corner`'s closed form."""

import math

import numpy as np
import numpy.typing as npt

from cutwise.maths.linearc import LineArc, block_point, block_tangent
from cutwise.physics.engagement.corner import Corner, arc_immersion, corner_immersion, straight_immersion

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
_SMOOTH = 1e-4  # [rad]


def wall_patches(immersion: FloatArray, axial_depth: float) -> FloatArray:
    """Contact patches of a cut along a wall: the arc from the wall side to the immersion angle, over the axial depth.

    Parameters
    ----------
    immersion : ndarray
        Immersion angle [rad], shape (n,); 0 for no contact.
    axial_depth : float
        [m].

    Returns
    -------
    ndarray
        Arc from, to [rad] and height above the tip from, to [m]; shape (n, 1, 4).
    """
    patches = np.zeros((immersion.shape[0], 1, 4))
    patches[:, 0, 1], patches[:, 0, 3] = immersion, axial_depth
    return patches


class _Zone:
    """An inner corner of the path, with its place and direction."""

    def __init__(self, at: FloatArray, heading: float, corner: Corner) -> None:
        self.at, self.heading, self.corner = at, heading, corner

    def immersion(self, x: float, y: float, heading: float) -> float:
        c, s = math.cos(self.heading), math.sin(self.heading)
        dx, dy = x - self.at[0], y - self.at[1]
        return float(corner_immersion(c * dx + s * dy, c * dy - s * dx, heading - self.heading, self.corner))


def path_immersion(
    curve: LineArc, cuts: npt.NDArray[np.bool_], block: IntArray, point: FloatArray, direction: FloatArray,
    mill_radius: float, radial_depth: float,
) -> FloatArray:  # fmt: skip
    """Immersion angle at samples of a path that has the wall on its right, the previous pass offset to its left.

    Lines before and after an inner (left) corner or fillet, longer than the mill radius, follow
    :func:`corner_immersion`; arcs elsewhere :func:`arc_immersion`; lines elsewhere :func:`straight_immersion`. Only
    the xy plane counts; blocks that do not cut give zero.

    Parameters
    ----------
    curve : LineArc
        The path [m].
    cuts : ndarray
        Whether a block cuts, shape (blocks,).
    block : ndarray
        Block of each sample, ascending, shape (n,).
    point, direction : ndarray
        Centre [m] and unit tangent of each sample, shape (n, 3).
    mill_radius, radial_depth : float
        [m].

    Returns
    -------
    ndarray
        Immersion angle [rad], shape (n,).
    """
    zones = corner_zones(curve, cuts, mill_radius, radial_depth)
    out = np.zeros(block.shape[0])
    straight = straight_immersion(radial_depth, mill_radius)
    for i in np.unique(block):
        here = np.arange(np.searchsorted(block, i), np.searchsorted(block, i, side="right"))
        zone = zones.get(int(i))
        if not cuts[i]:
            continue
        if zone is not None:
            reach = _reach(zone.corner)
            distance = np.hypot(point[here, 0] - zone.at[0], point[here, 1] - zone.at[1])
            out[here] = straight
            for k in here[distance <= reach]:
                heading = math.atan2(direction[k, 1], direction[k, 0])
                out[k] = zone.immersion(point[k, 0], point[k, 1], heading)
        elif math.isinf(curve.radius[i]):
            out[here] = straight
        else:
            out[here] = _steady_arc(curve, int(i), mill_radius, radial_depth)
    return out


def _reach(corner: Corner) -> float:
    """Distance from the corner point beyond which the cut is the straight one [m]."""
    return 2.0 * corner.mill_radius + (corner.fillet + corner.radial_depth + corner.mill_radius) * math.tan(
        0.5 * corner.turn
    )


def _steady_arc(curve: LineArc, i: int, mill_radius: float, radial_depth: float) -> float:
    turn = curve.along[i, 0] * curve.inward[i, 1] - curve.along[i, 1] * curve.inward[i, 0]
    if abs(turn) < 0.999:  # not in the xy plane
        return float(straight_immersion(radial_depth, mill_radius))
    radius = float(curve.radius[i])
    if turn > 0.0:
        return float(arc_immersion(radial_depth, max(radius, radial_depth), mill_radius))
    return float(arc_immersion(radial_depth, -radius, mill_radius)) if radius > mill_radius else 0.0


def corner_zones(
    curve: LineArc, cuts: npt.NDArray[np.bool_], mill_radius: float, radial_depth: float
) -> dict[int, _Zone]:
    """Inner corner that each block leads into or is part of; blocks without one are left out."""
    zones: dict[int, _Zone] = {}
    n = curve.count
    long = [math.isinf(curve.radius[i]) and cuts[i] and curve.length[i] >= mill_radius for i in range(n)]
    for i in range(n - 1):
        if not long[i]:
            continue
        d0 = np.asarray(block_tangent(curve, i, curve.length[i]))
        end = np.asarray(block_point(curve, i, curve.length[i]))
        if long[i + 1]:
            fillet, after = 0.0, i + 1
        elif i + 2 < n and cuts[i + 1] and long[i + 2] and not math.isinf(curve.radius[i + 1]):
            fillet, after = float(curve.radius[i + 1]), i + 2
        else:
            continue
        d1 = curve.along[after]
        turn = math.atan2(d0[0] * d1[1] - d0[1] * d1[0], d0[0] * d1[0] + d0[1] * d1[1])
        if not _SMOOTH < turn < math.radians(175.0):
            continue
        at = end + fillet * math.tan(0.5 * turn) * d0
        zone = _Zone(at, math.atan2(d0[1], d0[0]), Corner(mill_radius, radial_depth, turn, fillet))
        for j in range(i, after):
            zones[j] = zone
        zones.setdefault(after, zone)
    return zones
