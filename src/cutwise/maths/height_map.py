r"""A block of material seen along the tool axis: heights at the middles of cells, and which move cut each of them last.

Heights are float32, in blocks of 16 x 16 cells that lie one after another in memory, each with its highest value, so that
a move passes over what is lower than itself. All cells of a block are computed without asking which of them the move
reaches: vector lanes are cheaper than questions. What a move takes off a row of a block is summed in double and rounded
to a whole number, so that sums do not depend on their order: heights, ids and volumes are the same to the last bit for
any bands of blocks, in any threads.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, inlined_stepping, stepping, unlocked
from cutwise.maths.envelopes import LINE, Segments
from cutwise.maths.profiles import CONE, DISC, Cutters, profile_height

FloatArray = npt.NDArray[np.float64]
Float32Array = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]
Int32Array = npt.NDArray[np.int32]

SIDE = 16  # cells along the side of a block
_CELLS = SIDE * SIDE
RINGS = 2  # of cells round the stock that are cut as if it reached there
STOCK = -1  # id of a cell that nothing has cut
NOTHING = np.float32(-1e30)  # height of a cell outside of the stock
_UNTOUCHED = np.float32(1e30)
UNIT = 2.0**-40  # [m] of the whole numbers in which heights that are taken off are summed
_GRAIN = 2.0**40
_HALF_DIAGONAL = 0.5 * math.sqrt(2.0) * (SIDE - 1)
_NEWTON = 40
_STILL = np.float32(2e-5)  # of the sine: the height is stationary in it, so this leaves 1e-10 of the tube radius


class Layout(NamedTuple):
    """Where the cells stand."""

    x: float  # least x of the stock [m]
    y: float
    dx: float  # width of a cell [m]
    dy: float
    across: int  # cells of the stock along x
    along: int  # cells of the stock along y
    columns: int  # blocks along x
    rows: int  # blocks along y


class Held(NamedTuple):
    """Intervals of material in columns of cells, where other set-ups have cut too; none: a column is whole."""

    first: IntArray  # first interval of each cell, and their number at the end, shape (cells + 1,); or shape (1,)
    low: FloatArray  # [m], rising within a column
    high: FloatArray


def whole_columns() -> Held:
    """No other set-up has cut."""
    return Held(np.zeros(1, np.int64), np.zeros(0), np.zeros(0))


class HeightMap(NamedTuple):
    """Material left; b blocks, row by row."""

    layout: Layout
    height: Float32Array  # [m], shape (b * 256,)
    cutter: Int32Array  # the move that lowered the cell last, -1 the stock, shape (b * 256,)
    highest: Float32Array  # of each block [m], shape (b,)
    share: Float32Array  # part of the cell that is stock, shape (b * 256,); rings have none
    whole: npt.NDArray[np.bool_]  # blocks that are stock all over, shape (b,)
    bottom: FloatArray  # underside of the stock [m], of each cell shape (b * 256,) or of all shape (1,)
    top: Float32Array  # upper side of the stock [m], of each cell shape (b * 256,) or of all shape (1,)
    held: Held  # of cells


def layout(x: tuple[float, float], y: tuple[float, float], grid: float) -> Layout:
    """Cells no larger than the grid that fill a rectangle, and rings of cells round it."""
    across = max(1, math.ceil((x[1] - x[0]) / grid - 1e-9))
    along = max(1, math.ceil((y[1] - y[0]) / grid - 1e-9))
    blocks = [math.ceil((n + 2 * RINGS) / SIDE) for n in (across, along)]
    return Layout(
        x[0], y[0], (x[1] - x[0]) / across, (y[1] - y[0]) / along, across, along, blocks[0], blocks[1]
    )  # fmt: skip


def in_blocks(cells: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
    """Rows of cells of whole blocks, shape (rows * 16, columns * 16), in the order of the blocks; flat."""
    rows, columns = cells.shape[0] // SIDE, cells.shape[1] // SIDE
    return np.ascontiguousarray(cells.reshape(rows, SIDE, columns, SIDE).swapaxes(1, 2)).reshape(-1)


def in_rows(grid: Layout, blocks: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
    """Values of all blocks as rows of the stock's own cells, shape (along, across)."""
    cells = blocks.reshape(grid.rows, grid.columns, SIDE, SIDE).swapaxes(1, 2).reshape(grid.rows * SIDE, -1)
    return cells[RINGS : RINGS + grid.along, RINGS : RINGS + grid.across]


def cell_middles(grid: Layout) -> tuple[FloatArray, FloatArray]:
    """x and y of all cells, rings and what fills the blocks up included [m]."""
    return (  # type: ignore[return-value]
        grid.x + grid.dx * (np.arange(grid.columns * SIDE) - RINGS + 0.5),
        grid.y + grid.dy * (np.arange(grid.rows * SIDE) - RINGS + 0.5),
    )


def height_map(grid: Layout, share: FloatArray, bottom: float | FloatArray, top: float | FloatArray) -> HeightMap:
    """Stock before the first move.

    Parameters
    ----------
    grid : Layout
        Its cells.
    share : array (along, across)
        Part of each cell of the stock that is material.
    bottom, top : float or array (along, across)
        Its lower and upper side [m].
    """
    shape = grid.rows * SIDE, grid.columns * SIDE
    inner = np.s_[RINGS : RINGS + grid.along, RINGS : RINGS + grid.across]
    part = np.zeros(shape, np.float32)
    part[inner] = share
    filled = np.zeros(shape, bool)
    filled[inner] = share > 0.0
    near = _grown(filled, RINGS)
    lids = np.full(shape, NOTHING)
    uppers, lowers = np.zeros(shape), np.zeros(shape)
    uppers[inner], lowers[inner] = top, bottom
    if np.ndim(top):
        uppers, lowers = _spread(uppers, filled, near), _spread(lowers, filled, near)
        lids[near] = uppers[near]
    else:
        lids[near] = top
    height = np.asarray(in_blocks(lids))
    part = np.asarray(in_blocks(part))
    blocks = part.reshape(-1, _CELLS)
    upper = (
        in_blocks(np.where(near, uppers, NOTHING).astype(np.float32)) if np.ndim(top) else np.array([top], np.float32)
    )
    lower = in_blocks(lowers) if np.ndim(bottom) else np.array([bottom], float)
    return HeightMap(
        grid, height, np.full(height.size, STOCK, np.int32), height.reshape(-1, _CELLS).max(axis=1), part,
        (blocks == 1.0).all(axis=1), np.asarray(lower), np.asarray(upper), whole_columns(),
    )  # fmt: skip


def _grown(filled: npt.NDArray[np.bool_], rings: int) -> npt.NDArray[np.bool_]:
    """A region and the rings of cells round it."""
    for _ in range(rings):
        out = filled.copy()
        out[1:] |= filled[:-1]
        out[:-1] |= filled[1:]
        out[:, 1:] |= out[:, :-1].copy()
        out[:, :-1] |= out[:, 1:].copy()
        filled = out
    return filled


def _spread(values: FloatArray, filled: npt.NDArray[np.bool_], near: npt.NDArray[np.bool_]) -> FloatArray:
    """Values of a region carried on into the rings round it, from the nearest cell beside."""
    out, known = values.copy(), filled.copy()
    for _ in range(RINGS + 1):
        for shift, axis in ((1, 0), (-1, 0), (1, 1), (-1, 1)):
            source, there = np.roll(out, shift, axis), np.roll(known, shift, axis)
            take = near & ~known & there
            out[take] = source[take]
            known |= take
    return out


class _Near(NamedTuple):
    """A line seen from the first cell of a block: along and beside it, and the way left before and behind [m]."""

    q: np.float32
    p: np.float32
    ux: np.float32
    uy: np.float32
    low: np.float32
    high: np.float32
    z: np.float32
    k: np.float32


@inlined_stepping
def _level_disc(near: _Near, outer: np.float32, step: Float32Array, rise: Float32Array, out: Float32Array) -> None:
    """Cells of a block under a level line of a flat tool."""
    r2 = outer * outer
    for j in range(_CELLS):
        q = near.q + near.uy * rise[j] + near.ux * step[j]
        p = near.p + near.ux * rise[j] - near.uy * step[j]
        s = q if q > near.low else near.low
        s = s if s < near.high else near.high
        d = q - s
        out[j] = near.z if d * d + p * p <= r2 else _UNTOUCHED


@inlined_stepping
def _sloped_disc(near: _Near, outer: np.float32, step: Float32Array, rise: Float32Array, out: Float32Array) -> None:
    """Cells under a sloped line of a flat tool: the first that the tool reaches going up, the last going down."""
    zero = np.float32(0.0)
    r2 = outer * outer
    up = near.k > zero
    for j in range(_CELLS):
        q = near.q + near.uy * rise[j] + near.ux * step[j]
        p = near.p + near.ux * rise[j] - near.uy * step[j]
        h2 = r2 - p * p
        h = np.sqrt(h2 if h2 > zero else zero)
        low = q - h
        low = low if low > near.low else near.low
        high = q + h
        high = high if high < near.high else near.high
        s = low if up else high
        out[j] = near.z + near.k * s if (h2 >= zero) & (low <= high) else _UNTOUCHED


@inlined_stepping
def _ball(
    near: _Near, outer: np.float32, tube: np.float32, step: Float32Array, rise: Float32Array, out: Float32Array
) -> None:
    """Cells under a line of a ball, or of the part of one within the outer radius."""
    zero, one = np.float32(0.0), np.float32(1.0)
    r2, t2 = outer * outer, tube * tube
    lean = near.k / np.sqrt(one + near.k * near.k)
    for j in range(_CELLS):
        q = near.q + near.uy * rise[j] + near.ux * step[j]
        p = near.p + near.ux * rise[j] - near.uy * step[j]
        pp = p * p
        h2 = r2 - pp
        h = np.sqrt(h2 if h2 > zero else zero)
        low = q - h
        low = low if low > near.low else near.low
        high = q + h
        high = high if high < near.high else near.high
        w2 = t2 - pp
        s = q - lean * np.sqrt(w2 if w2 > zero else zero)
        s = s if s > low else low
        s = s if s < high else high
        d = q - s
        f2 = t2 - d * d - pp
        f = tube - np.sqrt(f2 if f2 > zero else zero)
        out[j] = near.z + near.k * s + f if (h2 >= zero) & (low <= high) else _UNTOUCHED


@inlined_stepping
def _cone(
    near: _Near, inner: np.float32, outer: np.float32, slope: np.float32, step: Float32Array, rise: Float32Array,
    out: Float32Array,
) -> None:  # fmt: skip
    """Cells under a line of a cone with a flat tip."""
    zero, one = np.float32(0.0), np.float32(1.0)
    r2 = outer * outer
    ratio = abs(near.k) / slope
    steep = ratio >= one
    stretch = zero if steep else one / np.sqrt(one - ratio * ratio)
    sign = zero if near.k == zero else (one if near.k > zero else -one)
    for j in range(_CELLS):
        q = near.q + near.uy * rise[j] + near.ux * step[j]
        p = near.p + near.ux * rise[j] - near.uy * step[j]
        pp = p * p
        h2 = r2 - pp
        h = np.sqrt(h2 if h2 > zero else zero)
        low = q - h
        low = low if low > near.low else near.low
        high = q + h
        high = high if high < near.high else near.high
        r = abs(p) * stretch
        r = r if r > inner else inner
        r = r if r < outer else outer
        r = outer if steep else r
        w2 = r * r - pp
        s = q - sign * np.sqrt(w2 if w2 > zero else zero)
        s = s if s > low else low
        s = s if s < high else high
        d = np.sqrt((q - s) * (q - s) + pp) - inner
        f = slope * (d if d > zero else zero)
        out[j] = near.z + near.k * s + f if (h2 >= zero) & (low <= high) else _UNTOUCHED


@inlined_stepping
def _tube(
    near: _Near, inner: np.float32, outer: np.float32, tube: np.float32, step: Float32Array, rise: Float32Array,
    out: Float32Array, sine: Float32Array,
) -> None:  # fmt: skip
    """Cells under a line of a torus with a flat tip; row by row Newton's rule until it stands still."""
    zero, one = np.float32(0.0), np.float32(1.0)
    r2, t2 = outer * outer, tube * tube
    sign = one if near.k > zero else -one
    most = (outer - inner) / tube
    level = near.k == zero
    if not level:
        _newton(near, inner, tube, step, rise, sine)
    for j in range(_CELLS):
        q = near.q + near.uy * rise[j] + near.ux * step[j]
        p = near.p + near.ux * rise[j] - near.uy * step[j]
        pp = p * p
        h2 = r2 - pp
        h = np.sqrt(h2 if h2 > zero else zero)
        low = q - h
        low = low if low > near.low else near.low
        high = q + h
        high = high if high < near.high else near.high
        t = sine[j] if sine[j] < most else most
        r = inner + tube * t
        w2 = r * r - pp
        w = zero if level else sign * np.sqrt(w2 if w2 > zero else zero)
        s = q - w
        s = s if s > low else low
        s = s if s < high else high
        d = np.sqrt((q - s) * (q - s) + pp) - inner
        d = d if d > zero else zero
        f2 = t2 - d * d
        f = tube - np.sqrt(f2 if f2 > zero else zero)
        out[j] = near.z + near.k * s + f if (h2 >= zero) & (low <= high) else _UNTOUCHED


@inlined_stepping
def _newton(
    near: _Near, inner: np.float32, tube: np.float32, step: Float32Array, rise: Float32Array, sine: Float32Array
) -> None:
    """Sines of the cells; see :func:`cutwise.maths.envelopes.tube_sine`. In units of the whole radius, for float32."""
    zero, one, two, small = np.float32(0.0), np.float32(1.0), np.float32(2.0), np.float32(1e-20)
    scale = one / (inner + tube)
    a, c = inner * scale, tube * scale
    k2 = near.k * near.k
    slant = one + k2
    last = sine[_CELLS:]
    for j in range(_CELLS):
        p = (near.p + near.ux * rise[j] - near.uy * step[j]) / inner
        under = slant - p * p
        start = np.sqrt(k2 / (under if under > small else small))
        sine[j] = start if (p * p < one) & (start < one) else one
    for _ in range(_NEWTON):
        for j in range(_CELLS):
            p = (near.p + near.ux * rise[j] - near.uy * step[j]) * scale
            p = p if p < one else one
            p = p if p > -one else -one
            t = sine[j]
            r = a + c * t
            value = slant * t * t * r * r - p * p * t * t - k2 * r * r
            slope = two * (slant * t * r * (r + c * t) - p * p * t - k2 * r * c)
            down = value / slope if slope > small else zero
            down = down if down > zero else zero
            sine[j] = t - down
            last[j] = down
        if _largest(last) <= _STILL:
            break


@inlined_stepping
def _largest(values: Float32Array) -> np.float32:
    """Largest of 256 numbers, which are overwritten: halves are compared, as whole vectors."""
    for k in range(128):
        values[k] = values[k] if values[k] > values[k + 128] else values[k + 128]
    for k in range(64):
        values[k] = values[k] if values[k] > values[k + 64] else values[k + 64]
    for k in range(32):
        values[k] = values[k] if values[k] > values[k + 32] else values[k + 32]
    for k in range(16):
        values[k] = values[k] if values[k] > values[k + 16] else values[k + 16]
    top = values[0]
    for k in range(1, 16):
        top = values[k] if values[k] > top else top
    return top


@inlined_stepping
def _arc(
    row: FloatArray, piece: FloatArray, x: float, y: float, step: Float32Array, rise: Float32Array, out: Float32Array
) -> None:
    """Cells under a level arc; ``x`` and ``y`` are those of the block's first cell [m]."""
    zero = np.float32(0.0)
    cx, cy = np.float32(x - row[2]), np.float32(y - row[3])
    ax, ay, bx, by = np.float32(x - row[9]), np.float32(y - row[10]), np.float32(x - row[11]), np.float32(y - row[12])
    mx, my, radius, within = np.float32(row[5]), np.float32(row[6]), np.float32(row[7]), np.float32(row[8])
    kind, inner, outer = piece[0], np.float32(piece[1]), np.float32(piece[2])
    shape, z = np.float32(piece[4]), np.float32(row[4] + piece[3])
    disc, cone = kind == DISC, kind == CONE
    for j in range(_CELLS):
        dx, ex, fx = cx + step[j], ax + step[j], bx + step[j]
        dy, ey, fy = cy + rise[j], ay + rise[j], by + rise[j]
        away = np.sqrt(dx * dx + dy * dy)
        beside = abs(away - radius)
        first, last = ex * ex + ey * ey, fx * fx + fy * fy
        end = np.sqrt(first if first < last else last)
        d = beside if dx * mx + dy * my >= away * within else end
        r = d - inner
        r = r if r > zero else zero
        f2 = shape * shape - r * r
        f = shape * r if cone else shape - np.sqrt(f2 if f2 > zero else zero)
        f = zero if disc else f
        out[j] = z + f if d <= outer else _UNTOUCHED


@inlined_stepping
def _line(
    row: FloatArray, piece: FloatArray, x: float, y: float, reach: float, step: Float32Array, rise: Float32Array,
    out: Float32Array, sine: Float32Array,
) -> None:  # fmt: skip
    """Cells under a line; it is seen from the place on it that is nearest to the block, so that float32 is enough."""
    ux, uy, k = row[5], row[6], row[8]
    q = (x - row[2]) * ux + (y - row[3]) * uy
    p = (y - row[3]) * ux - (x - row[2]) * uy
    at = min(max(q, 0.0), row[7])
    near = _Near(
        np.float32(q - at), np.float32(p), np.float32(ux), np.float32(uy), np.float32(max(-at, -reach)),
        np.float32(min(row[7] - at, reach)), np.float32(row[4] + piece[3] + k * at), np.float32(k),
    )  # fmt: skip
    kind, inner, outer, shape = piece[0], np.float32(piece[1]), np.float32(piece[2]), np.float32(piece[4])
    if kind == DISC:
        if k == 0.0:
            _level_disc(near, outer, step, rise, out)
        else:
            _sloped_disc(near, outer, step, rise, out)
    elif kind == CONE:
        _cone(near, inner, outer, shape, step, rise, out)
    elif piece[1] == 0.0:
        _ball(near, outer, shape, step, rise, out)
    else:
        _tube(near, inner, outer, shape, step, rise, out, sine)


@stepping
def _held_off(stock: HeightMap, cell: int, height: Float32Array, level: Float32Array) -> float:
    """What a row of cells loses of the intervals that other set-ups have left [m]."""
    held, off = stock.held, 0.0
    for j in range(SIDE):
        if not level[j] < height[j]:
            continue
        share = np.float64(stock.share[cell + j])
        for n in range(held.first[cell + j], held.first[cell + j + 1]):
            gone = min(held.high[n], np.float64(height[j])) - max(held.low[n], np.float64(level[j]))
            off += max(gone, 0.0) * share
    return off


@stepping
def _lowered(stock: HeightMap, block: int, move: int, level: Float32Array, spare: Float32Array) -> int:
    """Take a block down to the heights of a move; returns what was taken off, in units of 2**-40 m."""
    base = block * _CELLS  # views, because an index that may be negative keeps loops out of vector lanes
    height, cutter = stock.height[base : base + _CELLS], stock.cutter[base : base + _CELLS]
    whole, one_bottom = stock.whole[block], stock.bottom.size == 1
    for k in range(_CELLS):
        spare[k] = height[k] - level[k]
    if not _largest(spare) > np.float32(0.0):
        return 0
    taken = 0
    name = np.int32(move)
    for i in range(SIDE):
        off, floor = 0.0, stock.bottom[0]
        for j in range(SIDE):
            k = SIDE * i + j
            if not one_bottom:
                floor = stock.bottom[base + k]
            old, new = np.float64(height[k]), np.float64(level[k])
            new = new if new < old else old
            new = new if new > floor else floor
            old = old if old > floor else floor
            off += (old - new) * (1.0 if whole else np.float64(stock.share[base + k]))
        if stock.held.first.size > 1:
            off = _held_off(
                stock, base + SIDE * i, height[SIDE * i : SIDE * i + SIDE], level[SIDE * i : SIDE * i + SIDE]
            )
        taken += np.int64(math.floor(off * _GRAIN + 0.5))  # type: ignore[assignment]
    for k in range(_CELLS):
        less = level[k] < height[k]
        cutter[k] = name if less else cutter[k]
        height[k] = level[k] if less else height[k]
        spare[k] = height[k]
    stock.highest[block] = _largest(spare)
    return taken


class Room(NamedTuple):
    """Room to work in."""

    level: Float32Array  # heights of a move at the cells of a block, shape (256,)
    other: Float32Array  # the same of a further piece
    sine: Float32Array  # shape (512,)
    step: Float32Array  # x of the cells from the block's first [m], shape (256,)
    rise: Float32Array  # y likewise


@compiled
def room(grid: Layout) -> Room:
    """Room for the cells of a layout.

    Parameters
    ----------
    grid : Layout
        The cells.

    Returns
    -------
    Room
        Arrays to work in, and where the 256 cells of a block stand from its first [m].

    Notes
    -----
    Valid for maps of this layout, one thread at a time.

    Examples
    --------
    Cell 35 of a block is the fourth of its third row: with cells of 0.5 x 0.25 mm 1.5 mm along x and 0.5 mm along y.

    >>> work = room(Layout(0.0, 0.0, 0.5e-3, 0.25e-3, 20, 20, 2, 2))
    >>> round(1e3 * float(work.step[35]), 6), round(1e3 * float(work.rise[35]), 6), work.sine.size
    (1.5, 0.5, 512)
    """
    step, rise = np.empty(_CELLS, np.float32), np.empty(_CELLS, np.float32)
    for i in range(_CELLS):
        step[i], rise[i] = grid.dx * (i % SIDE), grid.dy * (i // SIDE)
    return Room(
        np.empty(_CELLS, np.float32), np.empty(_CELLS, np.float32), np.empty(2 * _CELLS, np.float32), step, rise
    )


@inlined_stepping
def _extent(row: FloatArray) -> tuple[float, float, float, float, float]:
    """Least and greatest x and y of the tip on a segment, and its lowest z [m]."""
    if row[0] == LINE:
        ex, ey = row[2] + row[7] * row[5], row[3] + row[7] * row[6]
        return min(row[2], ex), max(row[2], ex), min(row[3], ey), max(row[3], ey), row[4] + min(0.0, row[7] * row[8])
    return row[2] - row[7], row[2] + row[7], row[3] - row[7], row[3] + row[7], row[4]


@inlined_stepping
def _apart(row: FloatArray, x: float, y: float) -> float:
    """Distance of a point from the path of the tip, at least [m]."""
    dx, dy = x - row[2], y - row[3]
    if row[0] == LINE:
        q = min(max(dx * row[5] + dy * row[6], 0.0), row[7])
        return math.hypot(dx - q * row[5], dy - q * row[6])
    return abs(math.hypot(dx, dy) - row[7])


@inlined_stepping
def _reach_in_row(
    row: FloatArray, radius: float, low: float, high: float, ends: tuple[float, float]
) -> tuple[float, float]:
    """Least and greatest x that a segment reaches between two y [m]; ends of the whole where it is an arc or level in y."""
    left, right = ends[0] - radius, ends[1] + radius
    if row[0] == LINE and abs(row[6]) * row[7] > radius:
        a = (low - radius - row[3]) / row[6]
        b = (high + radius - row[3]) / row[6]
        first, last = max(0.0, min(a, b)), min(row[7], max(a, b))
        xa, xb = row[2] + first * row[5], row[2] + last * row[5]
        left, right = min(xa, xb) - radius, max(xa, xb) + radius
    return left, right


@stepping
def lower_by(
    stock: HeightMap, path: Segments, tools: Cutters, segment: int, move: int, bands: tuple[int, int], work: Room
) -> int:
    r"""Sweep one segment over the rows of blocks of a band; returns what was taken off, summed, in units of 2**-40 m.

    .. math:: \sum_\text{rows} \left\lfloor 2^{40} \sum_\text{cells} a \,(h - \max(z, b))_+ + \tfrac12 \right\rfloor

    with the share a of a cell that is stock, its height h before, the height z that the segment leaves, and its underside b.

    Parameters
    ----------
    stock : HeightMap
        The material; heights, ids and highest values are changed in place.
    path, tools : Segments, Cutters
        The path of the tips, and the profiles of the tools.
    segment, move : int
        Which segment, and the id that cells lowered by it are given.
    bands : tuple of int
        First row of blocks, and the one after the last.
    work : Room
        Room, from :func:`room`.

    Returns
    -------
    int
        Heights taken off, summed [2**-40 m]; :func:`volume_of` makes a volume of it.

    Notes
    -----
    Valid for cells by their middles: a wall stands to half a cell. Heights are float32, to 1e-8 of a metre in a stock 0.1 m high.
    A cell of equal height keeps its id.

    Examples
    --------
    A slot of 2 mm, 1 mm deep, through cells of 1 mm: 2 rows of 8 cells are lowered by 1 mm.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.profiles import cutters, flat
    >>> grid = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3)
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> path = segments([line_row(0, np.array([-2e-3, 2e-3, -1e-3]), np.array([10e-3, 2e-3, -1e-3]))], [1])
    >>> taken = lower_by(stock, path, cutters([flat(1e-3)]), 0, 0, (0, grid.rows), room(grid))
    >>> round(taken * UNIT, 8), in_rows(grid, stock.cutter)[:, 0].tolist()
    (0.016, [-1, 0, 0, -1])

    References
    ----------
    Derived here: the closed forms of :mod:`cutwise.maths.envelopes` at the middles of cells.
    """
    grid, row = stock.layout, path.row[segment]
    tool = int(row[1])
    radius = tools.radius[tool]
    x0, x1, y0, y1, lowest = _extent(row)
    first_x, first_y = grid.x + grid.dx * (0.5 - RINGS), grid.y + grid.dy * (0.5 - RINGS)
    wide, tall = grid.dx * SIDE, grid.dy * SIDE
    first = max(bands[0], math.floor((y0 - radius - first_y - grid.dy * (SIDE - 1)) / tall))
    last = min(bands[1] - 1, math.floor((y1 + radius - first_y) / tall))
    far = radius + _HALF_DIAGONAL * max(grid.dx, grid.dy)
    reach = 2.0 * (radius + max(wide, tall) * 2.0)
    taken = 0
    for r in range(first, last + 1):
        y = first_y + r * tall
        left, right = _reach_in_row(row, radius, y, y + grid.dy * (SIDE - 1), (x0, x1))
        begin = max(0, math.floor((left - first_x - grid.dx * (SIDE - 1)) / wide))
        end = min(grid.columns - 1, math.floor((right - first_x) / wide))
        for c in range(begin, end + 1):
            block = r * grid.columns + c
            if stock.highest[block] <= lowest:
                continue
            x = first_x + c * wide
            away = _apart(row, x + 0.5 * grid.dx * (SIDE - 1), y + 0.5 * grid.dy * (SIDE - 1))
            if away > far:
                continue
            rises = away > far - radius and stock.highest[block] <= lowest + profile_height(
                tools, tool, away + radius - far
            )
            if rises:  # the tool is higher than the block there
                continue
            _level_of(row, tools, tool, x, y, reach, work)
            taken += _lowered(stock, block, move, work.level, work.other)
    return taken


@stepping
def _level_of(row: FloatArray, tools: Cutters, tool: int, x: float, y: float, reach: float, work: Room) -> None:
    """Heights of a segment at the cells of a block: the least of those of the tool's pieces."""
    start = tools.first[tool]
    for i in range(start, tools.first[tool + 1]):
        out = work.level if i == start else work.other
        if row[0] == LINE:
            _line(row, tools.piece[i], x, y, reach, work.step, work.rise, out, work.sine)
        else:
            _arc(row, tools.piece[i], x, y, work.step, work.rise, out)
        if i > start:
            for j in range(_CELLS):
                work.level[j] = out[j] if out[j] < work.level[j] else work.level[j]


@compiled
def cut_by(stock: HeightMap, path: Segments, tools: Cutters, move: int, work: Room) -> int:
    """Sweep all segments of one move over the whole map; what was taken off as :func:`lower_by`.

    Parameters
    ----------
    stock : HeightMap
        The material, changed in place.
    path, tools : Segments, Cutters
        The path of the tips, and the profiles of the tools.
    move : int
        Which move.
    work : Room
        Room, from :func:`room`.

    Returns
    -------
    int
        Heights taken off, summed [2**-40 m].

    Notes
    -----
    Valid as :func:`lower_by`.

    Examples
    --------
    The slot of :func:`lower_by` takes 8 x 2 x 1 mm^3; run again it takes nothing.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.profiles import cutters, flat
    >>> grid = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3)
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> path = segments([line_row(0, np.array([-2e-3, 2e-3, -1e-3]), np.array([10e-3, 2e-3, -1e-3]))], [1])
    >>> taken = [cut_by(stock, path, cutters([flat(1e-3)]), 0, room(grid)) for _ in range(2)]
    >>> (1e9 * volume_of(stock, taken)).round(5).tolist()
    [16.0, 0.0]

    References
    ----------
    As :func:`lower_by`.
    """
    taken = 0
    for segment in range(path.first[move], path.first[move + 1]):
        taken += lower_by(stock, path, tools, segment, move, (0, stock.layout.rows), work)
    return taken


@unlocked
def swept_band(stock: HeightMap, path: Segments, tools: Cutters, bands: tuple[int, int], taken: IntArray) -> None:
    """Sweep all moves over a band of rows of blocks; what each takes off is added to ``taken``, shape (moves,).

    Parameters
    ----------
    stock : HeightMap
        The material, changed in place within the band alone.
    path, tools : Segments, Cutters
        The path of the tips, and the profiles of the tools.
    bands : tuple of int
        First row of blocks, and the one after the last.
    taken : array (moves,)
        Heights taken off, summed [2**-40 m], integers.

    Notes
    -----
    Valid as :func:`lower_by`. Bands that do not overlap may be swept side by side, each with a ``taken`` of its own.

    Examples
    --------
    Along a slot 8 mm long and 2 mm wide, first 1 mm deep and then 3 mm.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.profiles import cutters, flat
    >>> grid = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3)
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> rows = [line_row(0, np.array([-2e-3, 2e-3, z]), np.array([10e-3, 2e-3, z])) for z in (-1e-3, -3e-3)]
    >>> taken = np.zeros(2, np.int64)
    >>> swept_band(stock, segments(rows, [1, 1]), cutters([flat(1e-3)]), (0, grid.rows), taken)
    >>> (1e9 * volume_of(stock, taken)).round(5).tolist()
    [16.0, 32.0]

    References
    ----------
    As :func:`lower_by`.
    """
    work = room(stock.layout)
    for move in range(path.first.size - 1):
        for segment in range(path.first[move], path.first[move + 1]):
            taken[move] += lower_by(stock, path, tools, segment, move, bands, work)


def volume_of(stock: HeightMap, taken: IntArray | int) -> FloatArray:
    """Volume of heights taken off, given in units of 2**-40 m [m^3]."""
    return np.asarray(taken, float) * (UNIT * stock.layout.dx * stock.layout.dy)


def material(stock: HeightMap) -> float:
    """Volume of what is left [m^3]."""
    depth = np.maximum(stock.height.astype(float) - stock.bottom, 0.0)
    if stock.held.first.size > 1:
        cell = np.repeat(np.arange(stock.height.size), np.diff(stock.held.first))
        depth = np.zeros(stock.height.size)
        np.add.at(depth, cell, np.maximum(np.minimum(stock.held.high, stock.height[cell]) - stock.held.low, 0.0))
    return float((depth * stock.share).sum() * stock.layout.dx * stock.layout.dy)


@stepping
def overlap_by(stock: HeightMap, path: Segments, tools: Cutters, segment: int, found: FloatArray, work: Room) -> None:
    """What a segment would take off, without taking it: volume [m^3], depth [m] and its place are added to a row of five.

    Parameters
    ----------
    stock : HeightMap
        The material, left as it is.
    path, tools : Segments, Cutters
        The path of the tips, and the profiles of the tools.
    segment : int
        Which segment.
    found : array (5,)
        Volume, to which is added [m^3]; largest depth so far, and x, y of its cell and the height of the tool there [m].
    work : Room
        Room, from :func:`room`.

    Notes
    -----
    Valid as :func:`lower_by`: a wall counts by the middles of cells. Of several segments the volume counts twice where they
    overlap.

    Examples
    --------
    The slot of :func:`lower_by`: 16 mm^3, 1 mm deep, first met in the middle of the cell at (0.5, 1.5) mm.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.profiles import cutters, flat
    >>> grid = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3)
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> path = segments([line_row(0, np.array([-2e-3, 2e-3, -1e-3]), np.array([10e-3, 2e-3, -1e-3]))], [1])
    >>> found = np.zeros(5)
    >>> overlap_by(stock, path, cutters([flat(1e-3)]), 0, found, room(grid))
    >>> round(float(1e9 * found[0]), 5), (1e3 * found[1:]).round(6).tolist()
    (16.0, [1.0, 0.5, 1.5, -1.0])

    References
    ----------
    As :func:`lower_by`.
    """
    grid, row = stock.layout, path.row[segment]
    tool = int(row[1])
    lift = 1e30
    for i in range(tools.first[tool], tools.first[tool + 1]):
        lift = min(lift, tools.piece[i, 3])
    radius = tools.radius[tool]
    x0, x1, y0, y1, lowest = _extent(row)
    first_x, first_y = grid.x + grid.dx * (0.5 - RINGS), grid.y + grid.dy * (0.5 - RINGS)
    wide, tall = grid.dx * SIDE, grid.dy * SIDE
    first = max(0, math.floor((y0 - radius - first_y - grid.dy * (SIDE - 1)) / tall))
    last = min(grid.rows - 1, math.floor((y1 + radius - first_y) / tall))
    far = radius + _HALF_DIAGONAL * max(grid.dx, grid.dy)
    reach = 2.0 * (radius + max(wide, tall) * 2.0)
    one_bottom = stock.bottom.size == 1
    for r in range(first, last + 1):
        y = first_y + r * tall
        left, right = _reach_in_row(row, radius, y, y + grid.dy * (SIDE - 1), (x0, x1))
        begin = max(0, math.floor((left - first_x - grid.dx * (SIDE - 1)) / wide))
        end = min(grid.columns - 1, math.floor((right - first_x) / wide))
        for c in range(begin, end + 1):
            block = r * grid.columns + c
            if stock.highest[block] <= lowest + lift:
                continue
            x = first_x + c * wide
            if _apart(row, x + 0.5 * grid.dx * (SIDE - 1), y + 0.5 * grid.dy * (SIDE - 1)) > far:
                continue
            _level_of(row, tools, tool, x, y, reach, work)
            for k in range(_CELLS):
                at = block * _CELLS + k
                share = np.float64(stock.share[at])
                if share <= 0.0 or not work.level[k] < stock.height[at]:
                    continue
                floor = stock.bottom[0] if one_bottom else stock.bottom[at]
                depth = max(np.float64(stock.height[at]), floor) - max(np.float64(work.level[k]), floor)
                found[0] += depth * share * grid.dx * grid.dy
                if depth > found[1]:
                    found[1] = depth
                    found[2], found[3] = x + grid.dx * (k % SIDE), y + grid.dy * (k // SIDE)
                    found[4] = max(np.float64(work.level[k]), floor)
