"""Contact along a whole path of lines and arcs that follows a wall, every inner corner seen as it is cut."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.linearc import Block, LineArc, at_blocks, block_at, block_point, block_tangent, block_turn, line
from cutwise.physics.engagement.corner import Corner, arc_immersion, corner_contact, reach, straight_immersion

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
_SMOOTH = 1e-4  # [rad]
_PLACES = 400  # of a block that are compared for its greatest contact
_ZOOMS = 6  # from a block to the neighbours of the best place, again and again


class _Zone(NamedTuple):
    """An inner corner of the path, and how the path goes through it."""

    at: FloatArray  # corner point [m], shape (3,)
    heading: float  # of the first wall [rad]
    corner: Corner
    own: list[Block]  # the path in the corner's frame
    begins: float  # arc length of the path where its first line ends [m]

    def reaches(self, point: FloatArray) -> FloatArray:
        """Distance of mill centres from the corner over that at which it ends to matter, shape (n,)."""
        return np.hypot(point[:, 0] - self.at[0], point[:, 1] - self.at[1]) / reach(self.corner)

    def contact(self, along: FloatArray, point: FloatArray, direction: FloatArray) -> FloatArray:
        """Contact arcs at arc lengths, mill centres [m] and unit tangents, shape (n, p, 2)."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        to_corner = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 0.0]])
        ahead = direction @ to_corner
        return corner_contact(
            self.own, self.own[0].length + along - self.begins, (point - self.at) @ to_corner,
            np.arctan2(ahead[:, 1], ahead[:, 0]), self.corner,
        )  # fmt: skip


def wall_patches(arcs: FloatArray, axial_depth: float) -> FloatArray:
    """Contact patches of arcs over the axial depth.

    Parameters
    ----------
    arcs : ndarray
        Arc from, to [rad], shape (n, p, 2), or immersion angles from the wall side on, shape (n,); 0 for no contact.
    axial_depth : float
        [m].

    Returns
    -------
    ndarray
        Arc from, to [rad] and height above the tip from, to [m]; shape (n, p, 4).

    Examples
    --------
    >>> wall_patches(np.array([1.0, 0.0]), 2e-3).tolist()
    [[[0.0, 1.0, 0.0, 0.002]], [[0.0, 0.0, 0.0, 0.0]]]
    """
    given = arcs if arcs.ndim == 3 else np.stack([np.zeros(arcs.shape), arcs], axis=-1)[:, None]
    patches = np.zeros((*given.shape[:2], 4))
    patches[..., :2] = given
    patches[..., 3] = np.where(given[..., 1] > given[..., 0], axial_depth, 0.0)
    return patches


def path_contact(
    curve: LineArc, cuts: npt.NDArray[np.bool_], block: IntArray, along: FloatArray, mill_radius: float,
    radial_depth: float,
) -> FloatArray:  # fmt: skip
    """Contact arcs at places of a path that has the wall on its right, the previous pass offset to its left.

    Lines of at least the mill radius before and after an inner (left) corner or fillet follow
    :func:`corner_contact`; arcs elsewhere :func:`arc_immersion`; lines elsewhere :func:`straight_immersion`. Only
    the xy plane counts; blocks that do not cut give zero.

    Parameters
    ----------
    curve : LineArc
        The path [m].
    cuts : ndarray
        Whether a block cuts, shape (blocks,).
    block : ndarray
        Block of each place, ascending, shape (n,).
    along : ndarray
        Arc length of the whole path there [m], shape (n,).
    mill_radius, radial_depth : float
        [m].

    Returns
    -------
    ndarray
        Arc from, to in angles from the wall side [rad]; shape (n, p, 2), empty arcs zero.

    Notes
    -----
    Valid for a wall cut by a parallel pass before; what else of the path crosses a place is not known here (see
    :func:`cutwise.physics.engagement.stock.contact_patches`).

    Examples
    --------
    >>> from cutwise.maths.linearc import join
    >>> path = join([line((0, 0, 0), (0.1, 0, 0))])
    >>> at, block = np.array([0.05]), np.zeros(1, np.int64)
    >>> np.degrees(path_contact(path, np.ones(1, bool), block, at, 1e-2, 5e-3)[0]).round(6).tolist()
    [[0.0, 60.0]]

    References
    ----------
    Derived here.
    """
    zones = _corner_zones(curve, cuts, mill_radius, radial_depth)
    point, direction = at_blocks(curve, block, along - curve.knots[block])
    plain = np.zeros(block.shape[0])
    found: list[tuple[IntArray, FloatArray]] = []
    for i in np.unique(block[cuts[block]]):
        here = np.arange(np.searchsorted(block, i), np.searchsorted(block, i, side="right"))
        near = zones.get(int(i), [])
        if curve.straight[i] or near:
            plain[here] = straight_immersion(radial_depth, mill_radius)
        else:
            plain[here] = _steady_arc(curve, int(i), mill_radius, radial_depth)
        distance = np.array([zone.reaches(point[here]) for zone in near]).reshape(len(near), here.size)
        for k, zone in enumerate(near):
            mine = here[(distance[k] <= 1.0) & (distance.argmin(axis=0) == k)]
            found.append((mine, zone.contact(along[mine], point[mine], direction[mine])))
    out = np.zeros((block.shape[0], max([1, *(arcs.shape[1] for _, arcs in found)]), 2))
    out[:, 0, 1] = plain
    for mine, arcs in found:
        out[mine] = 0.0
        out[mine, : arcs.shape[1]] = arcs
    return out


def greatest_contact(curve: LineArc, mill_radius: float, radial_depth: float) -> float:
    """Largest sum of contact arcs [rad] along a short path that cuts everywhere, see :func:`path_contact`.

    Each block is searched by ever closer places; where closed forms hold it agrees with
    :func:`greatest_immersion` to 1e-11 rad.

    ``curve`` [m], ``mill_radius`` and ``radial_depth`` [m].

    Examples
    --------
    >>> from cutwise.maths.linearc import join
    >>> round(math.degrees(greatest_contact(join([line((0, 0, 0), (0.1, 0, 0))]), 1e-2, 5e-3)), 6)
    60.0

    References
    ----------
    Derived here.
    """
    everywhere, greatest = np.ones(curve.count, dtype=bool), 0.0
    for i in range(curve.count):
        low, high = 0.0, float(curve.length[i])
        for _ in range(_ZOOMS):
            along = np.linspace(low, high, _PLACES)
            block = np.full(_PLACES, i)
            arcs = path_contact(curve, everywhere, block, curve.knots[i] + along, mill_radius, radial_depth)
            sums = (arcs[..., 1] - arcs[..., 0]).sum(axis=1)
            best = int(sums.argmax())
            low, high = float(along[max(best - 1, 0)]), float(along[min(best + 1, _PLACES - 1)])
        greatest = max(greatest, float(sums[best]))
    return greatest


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


def _corner_zones(
    curve: LineArc, cuts: npt.NDArray[np.bool_], mill_radius: float, radial_depth: float
) -> dict[int, list[_Zone]]:
    """Inner corners that each block comes from, leads into, or is part of; blocks without one are left out.

    Lines that go on in one direction count as one line, however many blocks they are written in.
    """
    zones: dict[int, list[_Zone]] = {}
    walls = [
        run for run in _straight_runs(curve, cuts) if float(curve.length[run.start : run.stop].sum()) >= mill_radius
    ]
    for before, after in pairwise(walls):
        rounds = range(before.stop, after.start)
        if curve.straight[rounds.start : rounds.stop].any() or not cuts[rounds.start : rounds.stop].all():
            continue
        found = _corner_between(curve, before[-1], after[0])
        if found is None:
            continue
        apex, heading, turn, fillet = found
        corner = Corner(mill_radius, radial_depth, turn, fillet)
        zone = _Zone(apex, heading, corner, _own_pass(curve, rounds, apex, heading, corner), curve.knots[before.stop])
        for j in (*before, *rounds, *after):
            zones.setdefault(j, []).append(zone)
    return zones


def _own_pass(curve: LineArc, rounds: range, apex: FloatArray, heading: float, corner: Corner) -> list[Block]:
    """The path through a corner in the corner's frame, its lines long enough."""
    c, s = math.cos(heading), math.sin(heading)
    to_corner = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 0.0]])

    def turned(vector: FloatArray) -> tuple[float, float, float]:
        x, y, z = vector @ to_corner
        return float(x), float(y), float(z)

    middle = [
        block_at(curve, j)._replace(
            start=turned(curve.start[j] - apex), along=turned(curve.along[j]), inward=turned(curve.inward[j])
        )
        for j in rounds
    ]
    far = 2.0 * reach(corner)
    begin, end = (turned(curve.start[j] - apex) if rounds else (0.0, 0.0, 0.0) for j in (rounds.start, rounds.stop))
    ahead = (end[0] + far * math.cos(corner.turn), end[1] + far * math.sin(corner.turn), 0.0)
    return [line((begin[0] - far, begin[1], 0.0), begin), *middle, line(end, ahead)]


def _straight_runs(curve: LineArc, cuts: npt.NDArray[np.bool_]) -> list[range]:
    """Cutting lines, joined where the next one goes on in the same direction."""
    runs: list[range] = []
    for i in np.flatnonzero(curve.straight & cuts):
        last = runs[-1] if runs else range(0)
        if last.stop == i and runs and _angle_between(curve.along[i - 1], curve.along[i]) < _SMOOTH:
            runs[-1] = range(last.start, int(i) + 1)
        else:
            runs.append(range(int(i), int(i) + 1))
    return runs


def _angle_between(a: FloatArray, b: FloatArray) -> float:
    return math.atan2(float(np.linalg.norm(np.cross(a, b))), float(a @ b))


def _corner_between(curve: LineArc, first: int, last: int) -> tuple[FloatArray, float, float, float] | None:
    """Inner corner of two lines with roundings between them: its point [m], heading, turn [rad] and fillet [m].

    Roundings that are not one arc count as the arc that passes the corner at the same distance. None where the lines
    are not joined by a turn to the left alone, or a rounding does not touch what it joins.
    """
    length = curve.length
    d0, end = (np.asarray(at(curve, first, length[first])) for at in (block_tangent, block_point))
    d1, start = curve.along[last], curve.start[last]
    turn = math.atan2(d0[0] * d1[1] - d0[1] * d1[0], d0[0] * d1[0] + d0[1] * d1[1])
    if not _SMOOTH < turn < math.radians(175.0):
        return None
    heading = math.atan2(d0[1], d0[0])
    rounds = range(first + 1, last)
    if not rounds:
        return end, heading, turn, 0.0
    touching = all(
        _angle_between(np.asarray(block_tangent(curve, j, length[j])), curve.along[j + 1]) < _SMOOTH
        for j in range(first, last)
    )
    turned = sum(float(block_turn(curve, j, length[j])) for j in rounds)
    if not touching or min(_turns_left(curve, j) for j in rounds) < 1.0 - _SMOOTH or abs(turned - turn) > _SMOOTH:
        return None
    gap = start - end
    reach = float(gap[0] * d1[1] - gap[1] * d1[0]) / math.sin(turn)  # from the end of the line to the corner
    apex = end + reach * d0
    if len(rounds) == 1 and not curve.sharpness[first + 1]:
        return apex, heading, turn, float(curve.radius[first + 1])
    ends = [np.asarray(block_point(curve, j, length[j])) for j in rounds]
    nearest = min(float(np.hypot(*(point - apex)[:2])) for point in ends)
    half = math.cos(0.5 * turn)
    return apex, heading, turn, nearest * half / (1.0 - half)
