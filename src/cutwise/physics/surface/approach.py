"""How near a moving tool comes to a part, proved on its true surfaces by branch and bound.

A piece of mesh whose middle is at the distance d from the path and whose farthest point is r away from its middle
cannot come closer than d - r. Pieces that cannot matter are dropped, the others are halved, down to pieces so small
that the rest is below the tolerance. What is found is the distance at a point of the surface; what remains is a bound
on how much worse any point may be. Nothing here knows how the path was made.

One search serves both questions: how deep the ball cuts outside of the zones where it is meant to cut, and how near
the rod comes. Both count what is bad upwards: depth of the cut, and minus the distance of the rod's axis.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled, internal
from cutwise.maths.curves import FloatArray
from cutwise.maths.lines import BLOCK, GROUP, Line, distance_within, far_from, foot_on, line
from cutwise.maths.nurbs import workspace
from cutwise.maths.surface_mesh import PIECE, Boxes, Faces, SurfaceMesh, halve, middle_of, outside_limits, picked
from cutwise.maths.surfaces import CYLINDER, PLANE, IntArray
from cutwise.physics.surface.zones import Zones, no_zones, outside_zones

_DEPTH = 200  # pieces that wait at most
_KEPT = 16  # pieces that are followed to the end
_ROUNDS = 60  # in which they are halved
_SHARE = 0.02  # of the deepest cut found: others may be deeper by this
_ROUNDING = 1e-13  # [m]
_SMALLEST = 1e-7  # [m] pieces of this size are not halved any more


class MovingTool(NamedTuple):
    """What moves along a path without turning: a ball, or the rod above it."""

    path: Line  # centres of the ball; of a rod its two coordinates across the rod, and zero [m]
    height: FloatArray  # [m] of the path points along the rod, shape (n,)
    lowest: float  # [m] of them
    highest: float
    frame: FloatArray  # unit vectors: two across the rod, and from the ball along it; zero: the ball is meant; (3, 3)
    ball_radius: float  # [m]
    length: float  # [m] of the rod above the ball centre


class Approach(NamedTuple):
    """What was found, and what may remain."""

    value: float  # [m] depth of the cut, or distance of the rod's axis; infinite (minus, plus): nothing there
    bound: float  # [m] no point of the part is cut deeper, or is nearer, than this
    place: FloatArray  # [m] on the part, shape (3,)
    face: int  # -1 if nothing is there


class Wanted(NamedTuple):
    """How exact a search has to be."""

    slack: float  # [m] other places may be worse than the one found by this
    share: float = 0.0  # or by this share of how far the worst is from the limit, if that is more
    limit: float = 0.0  # [m] distance that a rod must keep: its radius
    enough: float = -math.inf  # [m] a rod nearer than this ends the search; of a cut: minus such a depth
    exact: bool = True  # whether the place found is followed to the end, and nothing left to the slack in closed form
    effort: int = 400_000  # pieces looked at before the rest is left to the bound


def moving_ball(centre: FloatArray, ball_radius: float, *, closed: bool) -> MovingTool:
    """A ball of a radius [m] along centres [m] of shape (n, 3)."""
    loop = np.vstack([centre, centre[:1]]) if closed else centre
    return MovingTool(line([loop]), np.zeros(len(loop)), 0.0, 0.0, np.zeros((3, 3)), ball_radius, 0.0)


def moving_rod(centre: FloatArray, axis: FloatArray, ball_radius: float, length: float, *, closed: bool) -> MovingTool:
    """A rod of a length [m] above a ball along centres [m], shape (n, 3), from the height of the ball centre on."""
    across = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = across - (across @ axis) * axis
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    loop = np.vstack([centre, centre[:1]]) if closed else centre
    flat = np.column_stack([loop @ first, loop @ second, np.zeros(len(loop))])
    height = np.ascontiguousarray(loop @ axis)
    frame = np.ascontiguousarray(np.stack([first, second, axis]))
    return MovingTool(line([flat]), height, float(height.min()), float(height.max()), frame, ball_radius, length)


def deepest_cut(
    mesh: SurfaceMesh, ball: MovingTool, zones: Zones, *, floor: float = 2e-7, enough: float = math.inf, effort: int = 400_000
) -> Approach:  # fmt: skip
    r"""Deepest cut of a ball into a part outside of the zones where it is meant to cut, :math:`R_B - d` [m]; derived here.

    Parameters
    ----------
    mesh, ball : SurfaceMesh, MovingTool
        Part, and ball on its path.
    zones : Zones
        Where it is meant to cut.
    floor : float
        A cut that is less deep counts as none; the bound of a path that cuts nothing is this [m].
    enough : float
        A cut that is deeper than this ends the search [m].
    effort : int
        Number of pieces looked at before the rest is left to the bound.
    """
    kept, out = np.zeros((2 * _KEPT, PIECE)), np.empty(6)
    most = ball.ball_radius - face_gaps(mesh, ball)
    wanted = Wanted(floor, _SHARE, 0.0, -enough, True, effort)
    _search(mesh, ball, zones, np.full(len(mesh.face), math.inf), most, floor, wanted, kept, out)
    value = float(out[0]) if out[0] > floor else -math.inf
    return Approach(value, float(out[1]), out[2:5].copy(), int(out[5]))


def rod_distance(mesh: SurfaceMesh, around: Boxes, rod: MovingTool, wanted: Wanted) -> Approach:
    """Smallest distance of a part from the axis of a rod [m]; infinite where nothing stands beside the rod.

    Points inside the ball belong to the cut and are left out. Derived here.

    Parameters
    ----------
    mesh, around, rod : SurfaceMesh, Boxes, MovingTool
        Part, boxes round its triangles, and rod on its path.
    wanted : Wanted
        How exact.
    """
    least = _least_distances(around, rod)
    order = np.argsort(least)
    order = order[: int(np.isfinite(least).sum())]
    kept, out = np.zeros((2 * _KEPT, PIECE)), np.empty(6)
    part, most = picked(mesh, order), -least[order]
    _search(part, rod, no_zones(), most, -face_gaps(mesh, rod), -math.inf, wanted, kept, out)
    return Approach(float(-out[0]), float(-out[1]), out[2:5].copy(), int(out[5]))


def face_gaps(mesh: SurfaceMesh, mover: MovingTool) -> FloatArray:
    """How near a ball's centre, or the axis of a rod, comes to each untrimmed surface at least [m]; 0 if unknown.

    In closed form for planes and, across their axis, for cylinders: faces that run along with the tool at one
    distance need no halving then. Derived here.
    """
    table, path, axis = mesh.faces.surfaces, mover.path.point, mover.frame[2]
    gap = np.zeros(len(table.kind))
    if mover.length > 0.0:
        path = path[:, :1] * mover.frame[0] + path[:, 1:2] * mover.frame[1] + mover.height[:, None] * axis
        ends = np.vstack([path, path + mover.length * axis])
    else:
        ends = path
    there = np.bincount(mesh.face, minlength=len(gap)) > 0
    flat = np.flatnonzero(there & (table.kind == PLANE))
    above = ends @ table.axis[flat].T - np.einsum("ij,ij->i", table.origin[flat], table.axis[flat])
    gap[flat] = np.maximum(0.0, np.maximum(above.min(axis=0), -above.max(axis=0)))
    for i in np.flatnonzero(there & (table.kind == CYLINDER)):
        if mover.length > 0.0 and abs(table.axis[i] @ axis) < 1.0 - 1e-12:
            continue
        arm = path - table.origin[i]
        arm = arm - (arm @ table.axis[i])[:, None] * table.axis[i]
        step = np.diff(arm, axis=0)
        square = np.maximum(np.einsum("ij,ij->i", step, step), 1e-300)
        foot = arm[:-1] - np.clip(np.einsum("ij,ij->i", arm[:-1], step) / square, -1.0, 0.0)[:, None] * step
        radius = table.size[i, 0]
        nearest, farthest = np.linalg.norm(foot, axis=1).min(), np.linalg.norm(arm, axis=1).max()
        gap[i] = max(0.0, nearest - radius, radius - farthest)
    return gap


def _least_distances(around: Boxes, rod: MovingTool) -> FloatArray:
    """How near each triangle may come to the axis of the rod at least, infinite where it is not beside it [m]."""
    path = rod.path.point[:, :2]
    centre = 0.5 * (path.min(axis=0) + path.max(axis=0))
    round_it = np.linalg.norm(path - centre, axis=1).max()
    axis = rod.frame[2]
    down, up = np.maximum(axis, 0.0), np.minimum(axis, 0.0)
    beside = (around.high @ down + around.low @ up > rod.lowest) & (
        around.low @ down + around.high @ up <= rod.highest + rod.length
    )
    off = np.hypot(around.middle @ rod.frame[0] - centre[0], around.middle @ rod.frame[1] - centre[1])
    return np.where(beside, off - round_it - around.size, np.inf)


@internal
def _cut_at(
    faces: Faces, ball: MovingTool, zones: Zones, face: int, piece: FloatArray, least: float, work: FloatArray
) -> tuple[float, float, float, float]:
    """Depth at the middle of a piece (minus infinity where it does not count), bound, size, and 0."""
    m = middle_of(faces, face, piece, work)
    far = max(0.0, ball.ball_radius - least + m.reach)
    d = distance_within(ball.path, m.x, m.y, m.z, far)
    if d >= far:
        return -math.inf, -math.inf, m.reach, 0.0
    out = outside_limits(faces, face, m.x, m.y, m.z)
    if out > m.reach:
        return -math.inf, -math.inf, m.reach, 0.0
    off = outside_zones(zones, face, m.x, m.y, m.z, m.reach)
    if off <= -m.reach:
        return -math.inf, -math.inf, m.reach, 0.0
    bound = ball.ball_radius - d + m.reach
    if off < 0.0 or out > 0.0:
        return -math.inf, bound, m.reach, 0.0
    return ball.ball_radius - d, bound, m.reach, 0.0


@internal
def _rod_at(
    faces: Faces, rod: MovingTool, face: int, piece: FloatArray, least: float, work: FloatArray
) -> tuple[float, float, float, float]:
    """Minus the distance of the rod's axis at the middle of a piece, bound, size, and how far lengths along the rod
    do not count when the piece is halved: 0 or 1."""
    m = middle_of(faces, face, piece, work)
    f = rod.frame
    u = m.x * f[0, 0] + m.y * f[0, 1] + m.z * f[0, 2]
    v = m.x * f[1, 0] + m.y * f[1, 1] + m.z * f[1, 2]
    h = m.x * f[2, 0] + m.y * f[2, 1] + m.z * f[2, 2]
    across = low = high = 0.0
    for k in range(3):
        dx, dy, dz = piece[3 * k] - m.x, piece[3 * k + 1] - m.y, piece[3 * k + 2] - m.z
        along = dx * f[2, 0] + dy * f[2, 1] + dz * f[2, 2]
        across = max(across, dx * dx + dy * dy + dz * dz - along * along)
        low, high = min(low, along), max(high, along)
    low, high = low - 1.5 * m.bulge, high + 1.5 * m.bulge  # of the piece along the rod, from its middle
    if h + high <= rod.lowest or h + low > rod.highest + rod.length:
        return -math.inf, -math.inf, m.reach, 0.0
    reach = math.sqrt(max(0.0, across)) + 1.5 * m.bulge
    out = outside_limits(faces, face, m.x, m.y, m.z)
    if out > m.reach:
        return -math.inf, -math.inf, reach, 0.0
    path = rod.path
    exact = math.inf
    beside = 0.0
    loose = far = reach - least
    node, ball, blocks = path.node, path.ball, path.blocks
    for g in range(ball.shape[0] - blocks):
        if far_from(ball, blocks + g, u, v, 0.0, loose):
            continue
        for b in range(g * GROUP, min(g * GROUP + GROUP, blocks)):
            if far_from(ball, b, u, v, 0.0, loose):
                continue
            for j in range(b * BLOCK, min(b * BLOCK + BLOCK, node.shape[0] - 1)):
                square, s = foot_on(node, j, u, v, 0.0)
                up = h - (rod.height[j] + s * (rod.height[j + 1] - rod.height[j]))
                away = math.sqrt(square + up * up)
                if up + high <= 0.0 or up + low > rod.length or away <= rod.ball_radius - m.reach:
                    continue
                d = math.sqrt(square)
                if d < loose:
                    loose = d
                    whole = up + low > 0.0 and up + high <= rod.length and away >= rod.ball_radius + m.reach
                    beside = 1.0 if whole else 0.0
                if out <= 0.0 and 0.0 < up <= rod.length and away >= rod.ball_radius:
                    exact = min(exact, d)
    if loose >= far:
        return -math.inf, -math.inf, reach, 0.0
    return -exact, reach - loose, reach, beside


@internal
def _at(
    faces: Faces, mover: MovingTool, zones: Zones, face: int, piece: FloatArray, least: float, work: FloatArray
) -> tuple[float, float, float, float]:
    if mover.length > 0.0:
        return _rod_at(faces, mover, face, piece, least, work)
    return _cut_at(faces, mover, zones, face, piece, least, work)


@internal
def _copy(source: FloatArray, i: int, target: FloatArray, j: int) -> None:
    for k in range(PIECE):
        target[j, k] = source[i, k]


@internal
def _threshold(best: float, floor: float, wanted: Wanted) -> float:
    """What the bound of a piece must exceed for the piece to matter."""
    return floor if best <= floor else best + max(wanted.slack, wanted.share * abs(best + wanted.limit))


@compiled
def _search(
    mesh: SurfaceMesh, mover: MovingTool, zones: Zones, most: FloatArray, most_of_face: FloatArray, floor: float, wanted: Wanted,
    kept: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    faces = mesh.faces
    work = workspace(faces.splines)
    stack = np.empty((_DEPTH, PIECE))
    best, left = floor, -math.inf
    effort = wanted.effort
    out[1] = out[2] = out[3] = out[4] = math.nan
    out[5] = -1.0
    for sweep in range(2):  # the first only looks at the middles, so that the second knows how bad it is already
        for start in range(mesh.face.size):
            face = mesh.face[start]
            worst = most_of_face[face]  # attained to the last digit where a face runs along with the tool
            least = _threshold(best, floor, wanted)
            if most[start] <= least or worst <= (best + _ROUNDING if wanted.exact else least):
                continue
            _copy(mesh.piece, start, stack, 0)
            waiting = 1
            while waiting > 0 and worst > best + _ROUNDING:
                waiting -= 1
                least = _threshold(best, floor, wanted)
                value, bound, size, stretch = _at(faces, mover, zones, face, stack[waiting], least, work)
                if bound <= least:
                    continue
                if value > best:
                    best = value
                    _copy(stack, waiting, kept, 0)
                    out[5] = face
                    if best > -wanted.enough:
                        m = middle_of(faces, face, kept[0], work)
                        out[0], out[2], out[3], out[4] = best, m.x, m.y, m.z
                        return
                if sweep == 0:
                    continue
                effort -= 1
                if effort < 0 or size < max(_SMALLEST, 0.3 * wanted.slack) or waiting > _DEPTH - 3:
                    left = max(left, min(bound, worst))
                    continue
                halve(faces, face, stack, waiting, mover.frame[2], stretch, stack, waiting, waiting + 1, work)
                waiting += 2
    out[1] = max(left, _threshold(best, floor, wanted))
    if out[5] >= 0.0 and wanted.exact:
        best = _follow(faces, mover, zones, int(out[5]), kept, best, out, work)
    out[0] = best
    out[1] = max(out[1], best)


@internal
def _follow(
    faces: Faces, mover: MovingTool, zones: Zones, face: int, kept: FloatArray, best: float, out: FloatArray,
    work: FloatArray,
) -> float:  # fmt: skip
    """Halve the worst piece again and again, the worst few each time, until its value is exact."""
    count = 1
    m = middle_of(faces, face, kept[0], work)
    out[2], out[3], out[4] = m.x, m.y, m.z
    halves = np.empty((2 * _KEPT, PIECE))
    score = np.empty(2 * _KEPT)
    stretch, stretched = np.zeros(_KEPT), np.zeros(2 * _KEPT)
    for _ in range(_ROUNDS):
        for i in range(count):
            halve(faces, face, kept, i, mover.frame[2], stretch[i], halves, 2 * i, 2 * i + 1, work)
        for i in range(2 * count):
            value, score[i], _, stretched[i] = _at(faces, mover, zones, face, halves[i], best - 1.0, work)
            if value > best:
                best = value
                m = middle_of(faces, face, halves[i], work)
                out[2], out[3], out[4] = m.x, m.y, m.z
        total = 2 * count
        count = min(_KEPT, total)
        for i in range(count):  # the highest scores first
            worst = 0
            for j in range(1, total):
                if score[j] > score[worst]:
                    worst = j
            _copy(halves, worst, kept, i)
            stretch[i] = stretched[worst]
            score[worst] = -math.inf
    return best


def cut_places(
    mesh: SurfaceMesh, ball: MovingTool, zones: Zones, limit: float, spacing: float
) -> tuple[FloatArray, IntArray]:
    """Points of a part, about a spacing apart, that a ball cuts deeper than a limit outside of the zones.

    Returns
    -------
    tuple of array
        Points [m], shape (k, 3), and their faces, shape (k,).
    """
    return _collect(mesh, ball, zones, limit, spacing)


@compiled
def _collect(
    mesh: SurfaceMesh, ball: MovingTool, zones: Zones, limit: float, spacing: float
) -> tuple[FloatArray, IntArray]:
    point, owner = np.empty((1024, 3)), np.empty(1024, np.int64)
    faces = mesh.faces
    work = workspace(faces.splines)
    stack = np.empty((_DEPTH, PIECE))
    count = 0
    for start in range(mesh.face.size):
        face = mesh.face[start]
        _copy(mesh.piece, start, stack, 0)
        waiting = 1
        while waiting > 0:
            waiting -= 1
            depth, bound, size, stretch = _cut_at(faces, ball, zones, face, stack[waiting], limit, work)
            if bound <= limit:
                continue
            if depth > limit and size < spacing:
                if count == point.shape[0]:  # as many as there are
                    point, owner = np.concatenate((point, point)), np.concatenate((owner, owner))
                m = middle_of(faces, face, stack[waiting], work)
                point[count, 0], point[count, 1], point[count, 2] = m.x, m.y, m.z
                owner[count] = face
                count += 1
                continue
            if size < 0.1 * spacing or waiting > _DEPTH - 3:
                continue
            halve(faces, face, stack, waiting, ball.frame[2], stretch, stack, waiting, waiting + 1, work)
            waiting += 2
    return point[:count].copy(), owner[:count].copy()
