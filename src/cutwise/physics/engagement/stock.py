r"""What a flat end mill meets along a whole path: contact arcs with the stock that the path has left so far.

Everything earlier moves have swept is gone: discs of the mill's radius along lines and arcs. A point of the rim is in
contact where it is inside the stock and in none of these. The arcs are found from the crossings of the rim with the borders of the
swept regions, so that they are exact for lines and arcs, with no grid; other curves are cut into short lines. Heights
count by levels: a move clears what is above its own height.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.engagement.path_sweep import Swept

FloatArray = npt.NDArray[np.float64]

_ROOM = 512  # arcs of earlier moves that one place may meet
_SLIGHT = 1e-9  # [rad] contact narrower than this is a touch
_LEVELS = 64  # heights at which earlier moves near one place may have run


class Stock(NamedTuple):
    """A convex block of material."""

    sides: FloatArray  # (n_x, n_y, c): inside where n . q < c [m], shape (k, 3); none: endless in the plane
    top: float  # [m]
    bottom: float  # [m]


def block_stock(x: Sequence[float], y: Sequence[float], top: float, bottom: float) -> Stock:
    """A rectangular block from its least and greatest x and y [m]."""
    sides = [[-1.0, 0.0, -x[0]], [1.0, 0.0, x[1]], [0.0, -1.0, -y[0]], [0.0, 1.0, y[1]]]
    return Stock(np.array(sides), top, bottom)


@compiled
def _add(arcs: FloatArray, count: int, begin: float, end: float, wall: float) -> int:
    """Put the arc from ``begin`` to ``end`` [rad], seen from the wall side and cut to the leading half, into a list."""
    turn = 2.0 * math.pi
    if end - begin >= turn:
        begin, end = wall, wall + turn
    low = (begin - wall) % turn
    high = low + (end - begin)
    if low < math.pi and count < arcs.shape[0]:
        arcs[count, 0], arcs[count, 1] = low, min(high, math.pi)
        count += 1
    if high > turn and count < arcs.shape[0]:
        arcs[count, 0], arcs[count, 1] = 0.0, min(high - turn, math.pi)
        count += 1
    return count


@compiled
def _add_between(
    cuts: FloatArray, n: int, swept: Swept, j: int, length: float, px: float, py: float, wall: float, arcs: FloatArray,
    count: int,
) -> int:  # fmt: skip
    """Sort the crossing angles and add every arc between neighbours whose middle the piece has swept."""
    turn = 2.0 * math.pi
    for a in range(1, n):  # few of them: by insertion
        value = cuts[a]
        b = a - 1
        while b >= 0 and cuts[b] > value:
            cuts[b + 1] = cuts[b]
            b -= 1
        cuts[b + 1] = value
    if n == 0:
        if _is_swept(swept, j, length, px + swept.radius, py):
            count = _add(arcs, count, wall, wall + turn, wall)
        return count
    for a in range(n):
        begin = cuts[a]
        end = cuts[a + 1] if a + 1 < n else cuts[0] + turn
        if end - begin < 1e-14:
            continue
        middle = 0.5 * (begin + end)
        if _is_swept(swept, j, length, px + swept.radius * math.cos(middle), py + swept.radius * math.sin(middle)):
            count = _add(arcs, count, begin, end, wall)
    return count


@compiled
def _is_swept(swept: Swept, j: int, length: float, x: float, y: float) -> bool:
    """Whether the body of a piece of a length has swept a point; its end discs are seen to apart."""
    tx, ty = swept.along[j, 0], swept.along[j, 1]
    dx, dy = x - swept.start[j, 0], y - swept.start[j, 1]
    bend = swept.turn[j]
    if bend == 0.0:
        u, v = dx * tx + dy * ty, dy * tx - dx * ty
        return 0.0 < u < length and abs(v) < swept.radius
    rho = 1.0 / abs(bend)
    side = math.copysign(1.0, bend)
    cx, cy = -side * rho * ty, side * rho * tx  # centre from the start
    qx, qy = dx - cx, dy - cy
    if abs(math.hypot(qx, qy) - rho) >= swept.radius:
        return False
    sweep = length / rho
    spoke = math.atan2(cy * qx - cx * qy, -cx * qx - cy * qy)  # from the spoke of the start, to the left
    return sweep >= 2.0 * math.pi or (side * spoke) % (2.0 * math.pi) < sweep


@compiled
def _cross_circle(cuts: FloatArray, n: int, dx: float, dy: float, radius: float, other: float) -> int:
    """Angles at which the rim meets a circle of radius ``other`` about a point at (dx, dy) from the mill's centre."""
    d = math.hypot(dx, dy)
    if d > 1e-15 and abs(radius - other) < d < radius + other:
        half = math.acos(min(1.0, max(-1.0, (d * d + radius * radius - other * other) / (2.0 * d * radius))))
        middle = math.atan2(dy, dx)
        cuts[n], cuts[n + 1] = (middle - half) % (2.0 * math.pi), (middle + half) % (2.0 * math.pi)
        n += 2
    return n


@compiled
def _cross_line(cuts: FloatArray, n: int, nx: float, ny: float, offset: float, radius: float) -> int:
    """Angles at which the rim meets the line :math:`n \\cdot q = offset`, q from the mill's centre, n a unit vector."""
    if abs(offset) < radius:
        half = math.acos(offset / radius)
        middle = math.atan2(ny, nx)
        cuts[n], cuts[n + 1] = (middle - half) % (2.0 * math.pi), (middle + half) % (2.0 * math.pi)
        n += 2
    return n


@compiled
def _add_piece(
    swept: Swept,
    j: int,
    length: float,
    px: float,
    py: float,
    wall: float,
    cuts: FloatArray,
    arcs: FloatArray,
    count: int,
    closed: bool,
) -> int:
    """Arcs of the rim that one piece, run over a length, has swept."""
    radius, bend = swept.radius, swept.turn[j]
    tx, ty = swept.along[j, 0], swept.along[j, 1]
    sx, sy = swept.start[j, 0] - px, swept.start[j, 1] - py
    n = 0
    if bend == 0.0:
        ex, ey = sx + length * tx, sy + length * ty
        across = sy * tx - sx * ty  # of the line from the mill's centre, to its left
        n = _cross_line(cuts, n, -ty, tx, across + radius, radius)
        n = _cross_line(cuts, n, -ty, tx, across - radius, radius)
        n = _cross_line(cuts, n, tx, ty, sx * tx + sy * ty, radius)
        n = _cross_line(cuts, n, tx, ty, ex * tx + ey * ty, radius)
    else:
        rho, side = 1.0 / abs(bend), math.copysign(1.0, bend)
        cx, cy = sx - side * rho * ty, sy + side * rho * tx
        angle = side * length / rho
        c, s = math.cos(angle), math.sin(angle)
        ox, oy = sx - cx, sy - cy
        fx, fy = c * ox - s * oy, s * ox + c * oy
        ex, ey = cx + fx, cy + fy
        n = _cross_circle(cuts, n, cx, cy, radius, rho + radius)
        if rho > radius:
            n = _cross_circle(cuts, n, cx, cy, radius, rho - radius)
        if abs(angle) < 2.0 * math.pi:
            n = _cross_line(cuts, n, -oy / rho, ox / rho, (-oy * cx + ox * cy) / rho, radius)
            n = _cross_line(cuts, n, -fy / rho, fx / rho, (-fy * cx + fx * cy) / rho, radius)
    count = _add_between(cuts, n, swept, j, length, px, py, wall, arcs, count)
    for end in range(2):  # the discs at both ends
        dx, dy = (sx, sy) if end == 0 else (ex, ey)
        d = math.hypot(dx, dy)
        if 1e-12 < d < 2.0 * radius:
            half, middle = math.acos(d / (2.0 * radius)), math.atan2(dy, dx)
            count = _add(arcs, count, middle - half, middle + half, wall)
        elif closed and d <= 1e-12:
            count = _add(arcs, count, wall, wall + 2.0 * math.pi, wall)
    return count


@compiled
def _add_outside(stock: Stock, px: float, py: float, radius: float, wall: float, arcs: FloatArray, count: int) -> int:
    """Arcs of the rim that are outside the stock."""
    for k in range(stock.sides.shape[0]):
        nx, ny = stock.sides[k, 0], stock.sides[k, 1]
        offset = (stock.sides[k, 2] - nx * px - ny * py) / radius
        if offset <= -1.0:
            return _add(arcs, count, wall, wall + 2.0 * math.pi, wall)
        if offset < 1.0:
            half, middle = math.acos(offset), math.atan2(ny, nx)
            count = _add(arcs, count, middle - half, middle + half, wall)
    return count


@compiled
def _gaps(arcs: FloatArray, count: int, free: FloatArray) -> int:
    """What a list of arcs leaves of the leading half; the list is sorted on the way."""
    for a in range(1, count):
        low, high = arcs[a, 0], arcs[a, 1]
        b = a - 1
        while b >= 0 and arcs[b, 0] > low:
            arcs[b + 1, 0], arcs[b + 1, 1] = arcs[b, 0], arcs[b, 1]
            b -= 1
        arcs[b + 1, 0], arcs[b + 1, 1] = low, high
    n = 0
    reached = 0.0
    for a in range(count):
        if arcs[a, 0] > reached + _SLIGHT and n < free.shape[0]:
            free[n, 0], free[n, 1] = reached, arcs[a, 0]
            n += 1
        reached = max(reached, arcs[a, 1])
    if math.pi > reached + _SLIGHT and n < free.shape[0]:
        free[n, 0], free[n, 1] = reached, math.pi
        n += 1
    return n


@compiled
def _levels(swept: Swept, first: int, last: int, way: float, bottom: float, top: float, levels: FloatArray) -> int:
    """Heights above ``bottom`` and below ``top`` at which earlier pieces near a place ran, rising."""
    n = 0
    for k in range(first, last):
        j = swept.near[k]
        if swept.way[j] >= way:
            break
        z = swept.height[j]
        if not bottom + 1e-9 < z < top - 1e-9:
            continue
        b = n - 1
        while b >= 0 and levels[b] > z + 1e-9:
            b -= 1
        if (b >= 0 and abs(levels[b] - z) <= 1e-9) or n == levels.shape[0]:
            continue
        for c in range(n, b + 1, -1):
            levels[c] = levels[c - 1]
        levels[b + 1] = z
        n += 1
    return n


@compiled
def _contact(
    x: float, y: float, z: float, wall: float, way: float, swept: Swept, stock: Stock, out: FloatArray,
    arcs: FloatArray, free: FloatArray, cuts: FloatArray, levels: FloatArray, closed: bool,
) -> int:  # fmt: skip
    """Contact patches of the mill at one place; their number, which may be more than ``out`` holds."""
    cx, cy = int((x - swept.corner[0]) / swept.cell), int((y - swept.corner[1]) / swept.cell)
    cell = min(max(cx, 0), swept.shape[0] - 1) * swept.shape[1] + min(max(cy, 0), swept.shape[1] - 1)
    first, last = swept.first[cell], swept.first[cell + 1]
    low = max(z, stock.bottom)
    n_levels = _levels(swept, first, last, way, low, stock.top, levels)
    count = _add_outside(stock, x, y, swept.radius, wall, arcs, 0)
    found = 0
    below = -math.inf
    for level in range(n_levels + 1):
        floor = low if level == 0 else levels[level - 1]
        ceiling = levels[level] if level < n_levels else stock.top
        for k in range(first, last):
            j = swept.near[k]
            if swept.way[j] >= way:
                break
            if below + 1e-9 < swept.height[j] <= floor + 1e-9:
                done = min(1.0, (way - swept.way[j]) / swept.way_length[j]) if swept.way_length[j] > 0.0 else 1.0
                count = _add_piece(swept, j, done * swept.length[j], x, y, wall, cuts, arcs, count, closed)
        below = floor
        if ceiling <= floor:
            continue
        n = _gaps(arcs, count, free)
        for a in range(n):
            joined = False
            for b in range(min(found, out.shape[0])):  # the same arc one level higher is one patch
                same = abs(out[b, 0] - free[a, 0]) < _SLIGHT and abs(out[b, 1] - free[a, 1]) < _SLIGHT
                if same and abs(out[b, 3] - (floor - z)) < 1e-12:
                    out[b, 3] = ceiling - z
                    joined = True
            if not joined:
                if found < out.shape[0]:
                    out[found, 0], out[found, 1] = free[a, 0], free[a, 1]
                    out[found, 2], out[found, 3] = floor - z, ceiling - z
                found += 1
    return found


@compiled
def _contacts(
    point: FloatArray, heading: FloatArray, way: FloatArray, swept: Swept, stock: Stock, out: FloatArray, closed: bool
) -> int:
    arcs, free = np.empty((_ROOM, 2)), np.empty((_ROOM, 2))
    cuts, levels = np.empty(16), np.empty(_LEVELS)
    most = 0
    for k in range(point.shape[0]):
        if point[k, 2] < stock.top - 1e-12:
            wall = heading[k] - 0.5 * math.pi
            found = _contact(
                point[k, 0],
                point[k, 1],
                point[k, 2],
                wall,
                way[k],
                swept,
                stock,
                out[k],
                arcs,
                free,
                cuts,
                levels,
                closed,
            )
            most = max(most, found)
    return most


def contact_patches(point: FloatArray, heading: FloatArray, way: FloatArray, swept: Swept, stock: Stock) -> FloatArray:
    """Contact patches of a flat end mill at places of its path, with what the path has left until there.

    Parameters
    ----------
    point : array (n, 3)
        Tool tip [m].
    heading : array (n,)
        Direction of feed in the plane [rad]; the half of the rim ahead of it cuts.
    way : array (n,)
        Arc length of the path at the places [m].
    swept : Swept
        The path.
    stock : Stock
        The material before it.

    Returns
    -------
    array (n, p, 4)
        Arc from, to, in angles from the wall side (heading - 90°) [rad], and heights above the tip from, to [m]; empty
        patches are zero.
    """
    room = 4
    while True:
        out = np.zeros((point.shape[0], room, 4))
        most = _contacts(
            np.ascontiguousarray(point),
            np.ascontiguousarray(heading),
            np.ascontiguousarray(way),
            swept,
            stock,
            out,
            False,
        )
        if most <= room:
            return out[:, : max(most, 1)]
        room = most


def stands_in_material(point: FloatArray, way: FloatArray, swept: Swept, stock: Stock) -> FloatArray:
    """How much of the whole rim is in contact where the mill goes straight down [rad], shape (n,).

    ``point`` (n, 3) is the tip [m], ``way`` (n,) the arc length at which that move began [m]: what was swept before it is
    gone, the very same place too.
    """
    whole = np.zeros(point.shape[0])
    for heading in (0.0, math.pi):
        out = np.zeros((point.shape[0], 8, 4))
        _contacts(np.ascontiguousarray(point), np.full(len(point), heading), way, swept, stock, out, True)
        whole += immersion(out)
    return whole


def removal_area(patches: FloatArray, radius: float) -> FloatArray:
    r"""Cross-section that the mill takes per length of feed, :math:`\sum R (\cos a_1 - \cos a_2)\,\Delta z` [m^2], (n,)."""
    width = np.cos(patches[..., 0]) - np.cos(patches[..., 1])
    return radius * np.sum(width * (patches[..., 3] - patches[..., 2]), axis=-1)


def immersion(patches: FloatArray) -> FloatArray:
    """Largest sum of arcs at one height [rad], shape (n,)."""
    low, high = patches[..., 2], patches[..., 3]
    angle = patches[..., 1] - patches[..., 0]
    at = 0.5 * (low + high)
    inside = (low[:, None, :] <= at[:, :, None]) & (at[:, :, None] < high[:, None, :])
    return np.asarray((inside * angle[:, None, :]).sum(axis=-1).max(axis=-1))
