"""Immersion along a whole path of lines and arcs, every inner corner seen by :mod:`corner`'s closed form."""

import math

import numpy as np
import numpy.typing as npt

from cutwise.maths.linearc import LineArc, block_point, block_tangent, block_turn
from cutwise.physics.engagement.corner import Corner, arc_immersion, corner_immersions, straight_immersion

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

    def immersions(self, points: FloatArray, tangents: FloatArray) -> FloatArray:
        """At mill centres [m] with unit tangents, shapes (n, 3)."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        to_corner = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return np.asarray(corner_immersions((points - self.at) @ to_corner, tangents @ to_corner, self.corner))


def path_immersion(
    curve: LineArc, cuts: npt.NDArray[np.bool_], block: IntArray, point: FloatArray, direction: FloatArray,
    mill_radius: float, radial_depth: float,
) -> FloatArray:  # fmt: skip
    """Immersion angle at samples of a path that has the wall on its right, the previous pass offset to its left.

    Lines before and after an inner (left) corner or fillet, longer than the mill radius, follow
    :func:`corner_immersions`; arcs elsewhere :func:`arc_immersion`; lines elsewhere :func:`straight_immersion`. Only
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
    lines = curve.straight
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
            near = here[distance <= reach]
            out[here] = straight
            out[near] = zone.immersions(point[near], direction[near])
        elif lines[i]:
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
    turn = _turns_left(curve, i)
    if abs(turn) < 0.999:  # not in the xy plane
        return float(straight_immersion(radial_depth, mill_radius))
    radius = 1.0 / float(curve.curvature[i])
    if turn > 0.0:
        return float(arc_immersion(radial_depth, max(radius, radial_depth), mill_radius))
    return float(arc_immersion(radial_depth, -radius, mill_radius)) if radius > mill_radius else 0.0


def _turns_left(curve: LineArc, i: int) -> float:
    """1 for a block that turns left in the xy plane, -1 for one that turns right, less in size out of the plane."""
    return float(curve.along[i, 0] * curve.inward[i, 1] - curve.along[i, 1] * curve.inward[i, 0])


def corner_zones(
    curve: LineArc, cuts: npt.NDArray[np.bool_], mill_radius: float, radial_depth: float
) -> dict[int, _Zone]:
    """Inner corner that each block leads into or is part of; blocks without one are left out."""
    zones: dict[int, _Zone] = {}
    lines = curve.straight
    long = lines & cuts & (curve.length >= mill_radius)
    for i in np.flatnonzero(long[:-1]):
        after = int(i) + 1
        while after < curve.count and cuts[after] and not lines[after]:
            after += 1
        if after == curve.count or not long[after]:
            continue
        corner = _corner_between(curve, int(i), after)
        if corner is None:
            continue
        apex, heading, turn, fillet = corner
        zone = _Zone(apex, heading, Corner(mill_radius, radial_depth, turn, fillet))
        for j in range(int(i), after):
            zones[j] = zone
        zones.setdefault(after, zone)
    return zones


def _corner_between(curve: LineArc, first: int, last: int) -> tuple[FloatArray, float, float, float] | None:
    """Inner corner of two lines with roundings between them: its point [m], heading, turn [rad] and fillet [m].

    Roundings that are not one arc count as the arc that passes the corner at the same distance. None where the lines
    are not joined by a turn to the left alone.
    """
    length = curve.length
    d0, end = (np.asarray(at(curve, first, length[first])) for at in (block_tangent, block_point))
    d1, start = curve.along[last], curve.start[last]
    turn = math.atan2(d0[0] * d1[1] - d0[1] * d1[0], d0[0] * d1[0] + d0[1] * d1[1])
    rounds = range(first + 1, last)
    turned = sum(float(block_turn(curve, j, length[j])) * _turns_left(curve, j) for j in rounds)
    if not _SMOOTH < turn < math.radians(175.0) or (rounds and abs(turned - turn) > _SMOOTH):
        return None
    heading = math.atan2(d0[1], d0[0])
    if not rounds:
        return end, heading, turn, 0.0
    gap = start - end
    reach = float(gap[0] * d1[1] - gap[1] * d1[0]) / math.sin(turn)  # from the end of the line to the corner
    apex = end + reach * d0
    if len(rounds) == 1 and not curve.sharpness[first + 1]:
        return apex, heading, turn, float(curve.radius[first + 1])
    ends = [np.asarray(block_point(curve, j, length[j])) for j in rounds]
    nearest = min(float(np.hypot(*(point - apex)[:2])) for point in ends)
    half = math.cos(0.5 * turn)
    return apex, heading, turn, nearest * half / (1.0 - half)
