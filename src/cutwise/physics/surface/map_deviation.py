r"""How far a machined surface stands off the nominal one, at points of the nominal with their outward normals.

Positive is material left. The sign is that of :math:`h - z` at the point; the size the least of the distance along the normal to
the first crossing of the surface, of the gap along the tool axis, and, where these are above a tolerance, of eight level rays that
start a little off the face: at the foot and at the rim of a wall a normal runs far before it meets anything.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, stepping
from cutwise.maths.height_map import STOCK
from cutwise.maths.map_index import Index, shaped, shaping_index
from cutwise.maths.workpiece import Workpiece, in_frame, map_of, maps_of

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

REACH = 1e-3  # [m] beyond which a distance is not followed
BEHIND = -1e-6  # of a normal along the tool axis: faces below it are seen from behind
_OFF = 2e-6  # [m] off the face, where level rays start
_FIRST = 1e-6  # [m] first step along a ray
_FINE = 1e-11  # [m] to which a crossing is found
_STEPS = 60
_RAYS = 8


class _Crossing(NamedTuple):
    away: float  # [m]; infinite: none within the reach
    owner: int  # the segment that made the surface there


class Indexes(NamedTuple):
    """Which segments may reach into a square, of all maps; their arrays end to end."""

    real: FloatArray  # x, y and size of each :class:`cutwise.maths.map_index.Index` [m], shape (m, 3)
    whole: IntArray  # squares across and along, shape (m, 2)
    end: IntArray  # ends of both arrays, shape (m + 1, 2)
    first: IntArray
    segment: IntArray


class Shaped(NamedTuple):
    """What is left under all maps of a part, with the segments that shaped each."""

    piece: Workpiece
    index: Indexes  # type: ignore[assignment]
    first: IntArray  # number of the first segment of each map among those of all, shape (m,)
    cell: float  # [m] width of the cells


def shaped_by(piece: Workpiece) -> Shaped:
    """Find the segments that shaped each map."""
    solids = maps_of(piece)
    first = np.concatenate(([0], np.cumsum([len(one.path.row) for one in solids])[:-1])).astype(np.int64)
    cell = max(max(one.map.layout.dx, one.map.layout.dy) for one in solids)
    found = [shaping_index(one) for one in solids]
    sizes = np.array([(one.first.size, one.segment.size) for one in found])
    index = Indexes(
        np.array([one[:3] for one in found], float),
        np.array([one[3:5] for one in found], np.int64),
        np.concatenate(([[0, 0]], np.cumsum(sizes, axis=0))).astype(np.int64),
        np.concatenate([one.first for one in found]),
        np.concatenate([one.segment for one in found]),
    )
    return Shaped(piece, index, first, cell)


@stepping
def _index_of(left: Shaped, j: int) -> Index:
    """That of map j, a view."""
    index = left.index
    r, n, a, b = index.real[j], index.whole[j], index.end[j], index.end[j + 1]
    return Index(r[0], r[1], r[2], n[0], n[1], index.first[a[0] : b[0]], index.segment[a[1] : b[1]])


@stepping
def _gap(left: Shaped, x: float, y: float, z: float) -> tuple[float, int]:
    """Height of the material over a point [m], bounded, and its owner; of several maps the least, each along its axis."""
    least, owner = math.inf, STOCK
    for j in range(left.piece.count):
        u, v, w = in_frame(left.piece, j, x, y, z)
        height, made = shaped(map_of(left.piece, j), _index_of(left, j), u, v)
        if height - w < least:
            least = height - w
            owner = made + left.first[j] if made != STOCK else STOCK
    return min(max(least, -1.0), 1.0), owner


@stepping
def _crossing(left: Shaped, p: FloatArray, v: tuple[float, float, float], inside: bool, most: float) -> _Crossing:
    """First place of a ray where it leaves the material (from inside) or enters it."""
    low, high = 0.0, min(_FIRST, most)
    g_low, owner_low = _gap(left, p[0], p[1], p[2])
    if (g_low > 0.0) != inside:  # off the face the point is on the other side already
        return _Crossing(0.0, owner_low)
    if most <= 0.5 * left.cell:
        high = most
    g_high, owner_high = _gap(left, p[0] + high * v[0], p[1] + high * v[1], p[2] + high * v[2])
    while (g_high > 0.0) == inside:
        if high >= most:
            return _Crossing(math.inf, STOCK)
        low, g_low, owner_low = high, g_high, owner_high
        high = min(high + min(max(high, _FIRST), 0.5 * left.cell), most)
        g_high, owner_high = _gap(left, p[0] + high * v[0], p[1] + high * v[1], p[2] + high * v[2])
    side = 0
    for step in range(_STEPS):
        if high - low <= _FINE:
            break
        at = 0.5 * (low + high)
        if step % 3 != 2 and g_high != g_low:
            at = low - g_low * (high - low) / (g_high - g_low)
            at = min(max(at, low + 1e-3 * (high - low)), high - 1e-3 * (high - low))
        g, owner = _gap(left, p[0] + at * v[0], p[1] + at * v[1], p[2] + at * v[2])
        if (g > 0.0) == inside:
            low, g_low, owner_low = at, g, owner
            g_high = 0.5 * g_high if side == 1 else g_high
            side = 1
        else:
            high, g_high, owner_high = at, g, owner
            g_low = 0.5 * g_low if side == -1 else g_low
            side = -1
        if abs(g) <= _FINE:
            low = high = at
    return _Crossing(0.5 * (low + high), owner_high if inside else owner_low)  # of the side in air


@stepping
def _deviation(left: Shaped, p: FloatArray, n: FloatArray, tolerance: float, q: FloatArray) -> tuple[float, int]:
    """Deviation at one point [m], and the segment that made the surface there."""
    over, owner = _gap(left, p[0], p[1], p[2])
    inside = over > 0.0
    best = min(abs(over), REACH)
    if best <= _FINE:
        return 0.0, owner
    sense = 1.0 if inside else -1.0
    maps = left.piece.count
    if maps > 1 and not inside:  # what one map has cut there may have been cut by another as well
        best = REACH
        for j in range(maps):
            t = left.piece.turn[j]
            down = _crossing(left, p, (-t[2, 0], -t[2, 1], -t[2, 2]), inside, best)
            if down.away < best:
                best, owner = down.away, down.owner
    along = _crossing(left, p, (sense * n[0], sense * n[1], sense * n[2]), inside, best)
    if along.away < best:
        best, owner = along.away, along.owner
    if best > tolerance:
        for k in range(3):
            q[k] = p[k] + sense * _OFF * n[k]
        for j in range(maps):
            t = left.piece.turn[j]
            for ray in range(_RAYS):
                turn = 2.0 * math.pi * ray / _RAYS
                c, s = math.cos(turn), math.sin(turn)
                v = (c * t[0, 0] + s * t[1, 0], c * t[0, 1] + s * t[1, 1], c * t[0, 2] + s * t[1, 2])
                level = _crossing(left, q, v, inside, best)
                lean = sense * (n[0] * v[0] + n[1] * v[1] + n[2] * v[2])
                away = math.sqrt(level.away * level.away + _OFF * _OFF + 2.0 * level.away * _OFF * lean)
                if away < best:
                    best, owner = away, level.owner
    return sense * best, owner


@stepping
def _seen(left: Shaped, normal: FloatArray) -> bool:
    """Whether a face is seen along the axis of a map, from above or from the side."""
    for j in range(left.piece.count):
        t = left.piece.turn[j]
        if t[2, 0] * normal[0] + t[2, 1] * normal[1] + t[2, 2] * normal[2] >= BEHIND:
            return True
    return False


@compiled
def deviations(
    left: Shaped,
    point: FloatArray,
    normal: FloatArray,
    tolerance: float,
    out: FloatArray,
    owner: IntArray,
) -> None:
    """Deviation at points of the nominal surface.

    Parameters
    ----------
    left : Shaped
        What is left, and the segments that shaped it, from :func:`shaped_by`.
    point, normal : array (n, 3)
        Points [m] and outward unit normals.
    tolerance : float
        Above it level rays are looked along too [m].
    out, owner : array (n,)
        Deviation [m], positive where material is left, cut at 1 mm; NaN where the face is seen from behind along every axis. The
        segment that
        made the surface there, -1 where it is the stock.

    Notes
    -----
    Valid up to 1 mm, where distances are cut. Crossings of a ray are found to 1e-11 m; a sliver thinner than half a cell may be
    passed over.

    Examples
    --------
    A slot 1 mm deep whose wall is at y = 3 mm. A floor that should be at -1.02 mm has 0.02 mm left, one at -0.97 mm is cut by
    0.03 mm, and a wall that should stand at 2.98 mm is cut by 0.02 mm.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.map_levels import room
    >>> from cutwise.maths.map_sweep import cut_by
    >>> from cutwise.maths.solid import Outline, RECTANGLE, Solid
    >>> from cutwise.maths.profiles import cutters, flat
    >>> from cutwise.maths.workpiece import alone
    >>> grid, tools = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3), cutters([flat(1e-3)])
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> path = segments([line_row(0, np.array([-2e-3, 2e-3, -1e-3]), np.array([10e-3, 2e-3, -1e-3]))], [1])
    >>> taken = cut_by(stock, path, tools, 0, room(grid))
    >>> slot = Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, tools)
    >>> point = 1e-3 * np.array([[4.0, 2.0, -1.02], [4.0, 2.0, -0.97], [4.0, 2.98, -0.5]])
    >>> normal = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    >>> out, owner = np.empty(3), np.empty(3, np.int64)
    >>> deviations(shaped_by(alone(slot)), point, normal, 1e-5, out, owner)
    >>> (1e3 * out).round(6).tolist(), owner.tolist()
    ([0.02, -0.03, -0.02], [0, 0, 0])

    References
    ----------
    Derived here.
    """
    q = np.empty(3)
    for i in range(point.shape[0]):
        if not _seen(left, normal[i]):
            out[i], owner[i] = math.nan, STOCK
        else:
            out[i], owner[i] = _deviation(left, point[i], normal[i], tolerance, q)


class Fit(NamedTuple):
    """Shift and turn of the machined surface off the nominal one, by least squares."""

    shift: FloatArray  # [m], shape (3,)
    turn: FloatArray  # [rad], shape (3,)
    centre: FloatArray  # about which it turns [m], shape (3,)
    before: float  # root mean square of the deviation [m]
    after: float  # of what is left of it


def fitted(point: FloatArray, normal: FloatArray, deviation: FloatArray, weight: FloatArray) -> Fit:
    r"""Least squares of the deviation on :math:`(n, p \times n)`, p from the centroid."""
    whole = weight.sum()
    centre = weight @ point / whole
    arm = point - centre
    size = max(float(np.sqrt((weight @ (arm * arm)).sum() / whole)), 1e-12)
    columns = np.hstack([normal, np.cross(arm, normal) / size])
    scaled = columns * weight[:, None]
    found = np.linalg.lstsq(scaled.T @ columns, scaled.T @ deviation, rcond=1e-9)[0]
    left = deviation - columns @ found
    mean = [math.sqrt(float(weight @ (d * d)) / whole) for d in (deviation, left)]
    return Fit(found[:3], found[3:] / size, centre, *mean)  # type: ignore[arg-type]
