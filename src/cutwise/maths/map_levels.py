r"""What one segment of a path leaves at the 256 cells of a block of a height map: closed forms in float32, lane by lane.

All cells of a block are computed without asking which of them the move reaches: vector lanes are cheaper than questions. A line is
seen from the place on it that is nearest to the block, so that float32 is enough.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, inlined_stepping, stepping
from cutwise.maths.envelopes import LINE
from cutwise.maths.height_map import BLOCK, SIDE, Layout
from cutwise.maths.profiles import CONE, DISC, Cutters

FloatArray = npt.NDArray[np.float64]
Float32Array = npt.NDArray[np.float32]

_UNTOUCHED = np.float32(1e30)
_NEWTON = 40
_STILL = np.float32(2e-5)  # of the sine: the height is stationary in it, so this leaves 1e-10 of the tube radius


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
    for j in range(BLOCK):
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
    for j in range(BLOCK):
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
def _ball(near: _Near, radius: np.float32, step: Float32Array, rise: Float32Array, out: Float32Array) -> None:
    """Cells under a line of a whole ball: where it touches lies within its reach, so that the ends of the line alone bound it."""
    zero = np.float32(0.0)
    r2 = radius * radius
    lean = near.k / np.sqrt(np.float32(1.0) + near.k * near.k)
    top = near.z + radius
    for j in range(BLOCK):
        q = near.q + near.uy * rise[j] + near.ux * step[j]
        p = near.p + near.ux * rise[j] - near.uy * step[j]
        w2 = r2 - p * p
        s = q - lean * np.sqrt(w2 if w2 > zero else zero)
        s = s if s > near.low else near.low
        s = s if s < near.high else near.high
        d = q - s
        f2 = w2 - d * d
        out[j] = top + near.k * s - np.sqrt(f2 if f2 > zero else zero) if f2 >= zero else _UNTOUCHED


@inlined_stepping
def _cap(
    near: _Near, outer: np.float32, tube: np.float32, step: Float32Array, rise: Float32Array, out: Float32Array
) -> None:
    """Cells under a line of the part of a ball within the outer radius."""
    zero, one = np.float32(0.0), np.float32(1.0)
    r2, t2 = outer * outer, tube * tube
    lean = near.k / np.sqrt(one + near.k * near.k)
    for j in range(BLOCK):
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
    for j in range(BLOCK):
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
    for j in range(BLOCK):
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
    last = sine[BLOCK:]
    for j in range(BLOCK):
        p = (near.p + near.ux * rise[j] - near.uy * step[j]) / inner
        under = slant - p * p
        start = np.sqrt(k2 / (under if under > small else small))
        sine[j] = start if (p * p < one) & (start < one) else one
    for _ in range(_NEWTON):
        for j in range(BLOCK):
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
        if largest(last) <= _STILL:
            break


@inlined_stepping
def largest(values: Float32Array) -> np.float32:
    """Largest of 256 numbers, which are overwritten: halves are compared, as whole vectors.

    Parameters
    ----------
    values : array (256,)
        The numbers; the first 128 are overwritten.

    Returns
    -------
    float32
        The largest.

    Examples
    --------
    Valid for any numbers but NaN.

    >>> float(largest(np.sin(np.arange(256.0)).astype(np.float32))) == float(np.sin(np.arange(256.0)).astype(np.float32).max())
    True
    """
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
    for j in range(BLOCK):
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
    elif piece[1] == 0.0 and piece[2] == piece[4]:
        _ball(near, outer, step, rise, out)
    elif piece[1] == 0.0:
        _cap(near, outer, shape, step, rise, out)
    else:
        _tube(near, inner, outer, shape, step, rise, out, sine)


class Room(NamedTuple):
    """Room to work in."""

    level: Float32Array  # heights of a move at the cells of a block, shape (256,)
    other: Float32Array  # the same of a further piece
    sine: Float32Array  # shape (512,)
    step: Float32Array  # x of the cells from the block's first [m], shape (256,)
    rise: Float32Array  # y likewise
    lanes: FloatArray  # sums of the columns of a block, shape (16,)


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
    step, rise = np.empty(BLOCK, np.float32), np.empty(BLOCK, np.float32)
    for i in range(BLOCK):
        step[i], rise[i] = grid.dx * (i % SIDE), grid.dy * (i // SIDE)
    return Room(
        np.empty(BLOCK, np.float32), np.empty(BLOCK, np.float32), np.empty(2 * BLOCK, np.float32), step, rise, np.empty(SIDE)
    )  # fmt: skip


@stepping
def level_of(row: FloatArray, tools: Cutters, tool: int, x: float, y: float, reach: float, work: Room) -> None:
    """Heights of a segment at the cells of a block: the least of those of the tool's pieces.

    Parameters
    ----------
    row : array (16,)
        A row of :class:`cutwise.maths.envelopes.Segments`.
    tools, tool : Cutters, int
        The profiles, and which of them.
    x, y : float
        The block's first cell [m].
    reach : float
        How far the line counts before and behind the place on it that is nearest to the block [m].
    work : Room
        Room, from :func:`room`; ``level`` is written [m], 1e30 where the tool does not come.

    Notes
    -----
    Valid to float32, 1e-8 of a metre in a stock 0.1 m high.

    Examples
    --------
    A ball of 5 mm at -2 mm stands 1 mm higher at 3 mm beside its line, which is the fourth row of cells of 1 mm.

    >>> from cutwise.maths.envelopes import line_row
    >>> from cutwise.maths.profiles import ball, cutters
    >>> row = np.array(line_row(0, np.array([-9e-3, 0.0, -2e-3]), np.array([20e-3, 0.0, -2e-3])))
    >>> work = room(Layout(0.0, 0.0, 1e-3, 1e-3, 20, 20, 2, 2))
    >>> level_of(row, cutters([ball(5e-3)]), 0, 0.0, 0.0, 0.1, work)
    >>> round(1e3 * float(work.level[3 * SIDE]), 5)
    -1.0
    """
    start = tools.first[tool]
    for i in range(start, tools.first[tool + 1]):
        out = work.level if i == start else work.other
        if row[0] == LINE:
            _line(row, tools.piece[i], x, y, reach, work.step, work.rise, out, work.sine)
        else:
            _arc(row, tools.piece[i], x, y, work.step, work.rise, out)
        if i > start:
            for j in range(BLOCK):
                work.level[j] = out[j] if out[j] < work.level[j] else work.level[j]
