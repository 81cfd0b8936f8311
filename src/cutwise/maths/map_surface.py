r"""The surface that a height map stands for, exact between its cells.

The height at a point is the least of what the moves leave there whose ids stand at the four cells around it, in double and in
closed form; where these differ, of the sixteen cells around. It is never below the truth, and equal to it unless a move that
shaped the point owns no cell near it: walls, corners and cusps are exact on a coarse grid.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, stepping
from cutwise.maths.envelopes import LINE, Segments, move_height, segment_height
from cutwise.maths.height_map import NOTHING, RINGS, SIDE, STOCK, HeightMap, Layout, in_rows
from cutwise.maths.profiles import Cutters, profile_height

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_ASK = np.float32(-1e29)  # heights below it are no material


class Outline(NamedTuple):
    """Where stock stands in plan."""

    kind: int  # RECTANGLE, CIRCLE or CELLS
    x: float  # middle of a circle [m]
    y: float
    radius: float


RECTANGLE, CIRCLE, CELLS = 0, 1, 2


class Solid(NamedTuple):
    """What is left of a stock, seen along one tool axis."""

    map: HeightMap
    outline: Outline
    path: Segments
    tools: Cutters


@stepping
def within(solid: Solid, x: float, y: float) -> bool:
    """Whether a point is inside the outline of the stock."""
    grid, outline = solid.map.layout, solid.outline
    u, v = (x - grid.x) / grid.dx, (y - grid.y) / grid.dy
    if not (0.0 <= u <= grid.across and 0.0 <= v <= grid.along):
        return False
    if outline.kind == RECTANGLE:
        return True
    if outline.kind == CIRCLE:
        return (x - outline.x) ** 2 + (y - outline.y) ** 2 <= outline.radius**2
    return solid.map.share[cell(grid, int(min(u, grid.across - 1)), int(min(v, grid.along - 1)))] > 0.0


@stepping
def cell(grid: Layout, i: int, j: int) -> int:
    """Number of a cell of the stock, counted along x and y; rings have negative numbers or those beyond."""
    a, b = i + RINGS, j + RINGS
    block = (b // SIDE) * grid.columns + a // SIDE
    return (block * SIDE + b % SIDE) * SIDE + a % SIDE


@stepping
def nearest(solid: Solid, x: float, y: float) -> int:
    """Number of the cell in which a point is; -1 beyond the rings."""
    grid = solid.map.layout
    i, j = math.floor((x - grid.x) / grid.dx), math.floor((y - grid.y) / grid.dy)
    if not (-RINGS <= i < grid.across + RINGS and -RINGS <= j < grid.along + RINGS):
        return -1
    return cell(grid, i, j)


@stepping
def top_at(solid: Solid, x: float, y: float) -> float:
    """Upper side of the uncut stock, bilinear between the middles of its cells [m]."""
    top, grid = solid.map.top, solid.map.layout
    if top.size == 1:
        return float(top[0])
    u, v = (x - grid.x) / grid.dx - 0.5, (y - grid.y) / grid.dy - 0.5
    i, j = math.floor(u), math.floor(v)
    height = weight = 0.0
    for b in range(2):
        for a in range(2):
            if -RINGS <= i + a < grid.across + RINGS and -RINGS <= j + b < grid.along + RINGS:
                value = top[cell(grid, i + a, j + b)]
                if value > _ASK:
                    share = (u - i if a else 1.0 - (u - i)) * (v - j if b else 1.0 - (v - j))
                    height += share * value
                    weight += share
    return height / weight if weight > 1e-12 else -math.inf


@stepping
def bottom_at(solid: Solid, x: float, y: float) -> float:
    """Underside of the stock at a point [m]; of one with an underside per cell that of the cell."""
    bottom = solid.map.bottom
    if bottom.size == 1:
        return bottom[0]
    at = nearest(solid, x, y)
    return bottom[at] if at >= 0 else math.inf


@stepping
def _gathered(solid: Solid, i: int, j: int, low: int, high: int, found: IntArray) -> int:
    """Ids of the cells from ``low`` to ``high`` beside cell (i, j), each once; their number."""
    grid, count = solid.map.layout, 0
    for b in range(low, high):
        for a in range(low, high):
            u, v = i + a, j + b
            if not (-RINGS <= u < grid.across + RINGS and -RINGS <= v < grid.along + RINGS):
                continue
            at = cell(grid, u, v)
            if solid.map.height[at] == NOTHING:
                continue
            name = solid.map.cutter[at]
            known = False
            for k in range(count):
                known = known or found[k] == name
            if not known:
                found[count] = name
                count += 1
    return count


@stepping
def surface(solid: Solid, done: int, x: float, y: float, found: IntArray) -> tuple[float, int]:
    """Height of what is left at a point [m], and the move that made it (-1: the stock itself).

    Outside of the stock the height is minus infinity. ``done``: how many moves have been run; ``found``: room for 16 ids.
    """
    if not within(solid, x, y):
        return -math.inf, STOCK
    return surface_within(solid, done, x, y, found)


@stepping
def surface_within(solid: Solid, done: int, x: float, y: float, found: IntArray) -> tuple[float, int]:
    """As :func:`surface`, of the stock carried on beyond its outline."""
    grid = solid.map.layout
    i = math.floor((x - grid.x) / grid.dx - 0.5)
    j = math.floor((y - grid.y) / grid.dy - 0.5)
    count = _gathered(solid, i, j, 0, 2, found)
    if count > 1:
        count = _gathered(solid, i, j, -1, 3, found)
    height, owner = top_at(solid, x, y), STOCK
    several = count > 1
    for k in range(1, count):  # in their order, so that none is looked at twice
        name, n = found[k], k
        while n > 0 and found[n - 1] > name:
            found[n] = found[n - 1]
            n -= 1
        found[n] = name
    looked = -1
    for k in range(count):
        if found[k] == STOCK:
            continue
        low, high = found[k], found[k]
        if several:  # a strip that is narrower than the grid is most often that of the move before or behind
            low, high = max(low - 1, looked + 1), min(high + 1, done - 1)
        for name in range(low, high + 1):
            left = move_height(solid.path, solid.tools, name, x, y)
            if left < height:
                height, owner = left, name
        looked = high
    return height, owner


@compiled
def surfaces(solid: Solid, x: float, y: float, height: FloatArray, owner: IntArray) -> None:
    """:func:`surface` at many points [m]: arrays of shape (n,)."""
    found = np.empty(16, np.int64)
    for i in range(x.shape[0]):
        height[i], owner[i] = surface(solid, solid.path.first.size - 1, x[i], y[i], found)


@compiled
def corner_heights(solid: Solid, x: FloatArray, y: FloatArray, top: FloatArray, bottom: FloatArray) -> None:
    """Upper and lower side of what is left at points on the outline or within it [m]: arrays of shape (n,)."""
    found = np.empty(16, np.int64)
    for i in range(x.shape[0]):
        floor = bottom_at(solid, x[i], y[i])
        height, _ = surface_within(solid, solid.path.first.size - 1, x[i], y[i], found)
        lid = top_at(solid, x[i], y[i])
        bottom[i] = floor if floor < math.inf else lid
        top[i] = max(height, bottom[i])


class Index(NamedTuple):
    """Which segments may reach into each square of a coarse grid."""

    x: float
    y: float
    size: float  # [m]
    across: int
    along: int
    first: IntArray  # of each square, shape (squares + 1,)
    segment: IntArray


@compiled
def _box(path: Segments, tools: Cutters, segment: int) -> tuple[float, float, float, float]:
    """Least and greatest x, then y, that a segment reaches [m]."""
    row = path.row[segment]
    radius = tools.radius[int(row[1])]
    if row[0] == LINE:
        ex, ey = row[2] + row[7] * row[5], row[3] + row[7] * row[6]
        return (
            min(row[2], ex) - radius, max(row[2], ex) + radius, min(row[3], ey) - radius, max(row[3], ey) + radius
        )  # fmt: skip
    far = row[7] + radius
    return row[2] - far, row[2] + far, row[3] - far, row[3] + far


@stepping
def _least_in_square(path: Segments, tools: Cutters, segment: int, x: float, y: float, half: float) -> float:
    """A height that a segment does not go below in a square of a half diagonal round a point [m]; infinite: not reached."""
    row = path.row[segment]
    tool = int(row[1])
    dx, dy = x - row[2], y - row[3]
    low = row[4]
    if row[0] == LINE:
        q = dx * row[5] + dy * row[6]
        s = min(max(q, 0.0), row[7])
        away = math.hypot(dx - s * row[5], dy - s * row[6])
        far = tools.radius[tool] + half
        if away > far:
            return math.inf
        begin, end = min(max(q - far, 0.0), row[7]), min(max(q + far, 0.0), row[7])
        low += min(row[8] * begin, row[8] * end)
    else:
        away = abs(math.hypot(dx, dy) - row[7])
        if away > tools.radius[tool] + half:
            return math.inf
    return low + profile_height(tools, tool, max(away - half, 0.0))


@compiled
def _squares(
    path: Segments, tools: Cutters, x: float, y: float, size: float, across: int, along: int, most: FloatArray,
    first: IntArray, segment: IntArray, fill: bool,
) -> None:  # fmt: skip
    """Count, or fill in, the segments of each square that may come as low there as the square's ``most`` [m]."""
    half = 0.7072 * size
    for s in range(path.row.shape[0]):
        x0, x1, y0, y1 = _box(path, tools, s)
        a, b = max(0, math.floor((x0 - x) / size)), min(across - 1, math.floor((x1 - x) / size))
        c, d = max(0, math.floor((y0 - y) / size)), min(along - 1, math.floor((y1 - y) / size))
        for j in range(c, d + 1):
            for i in range(a, b + 1):
                k = j * across + i
                if _least_in_square(path, tools, s, x + (i + 0.5) * size, y + (j + 0.5) * size, half) > most[k]:
                    continue
                if fill:
                    segment[first[k]] = s
                first[k] += 1


def index_of(solid: Solid, squares: int = 64) -> Index:
    """Index over the plan of the stock, with about so many squares along its longer side."""
    grid = solid.map.layout
    size = max(grid.across * grid.dx, grid.along * grid.dy) / squares
    return _index(solid, size, None)


def shaping_index(solid: Solid) -> Index:
    """Index of the segments that may shape what is left: those that stay above it all over a square are left out.

    Squares are four cells wide. What stands between cells may be higher than the cells: two cells round a square and half a
    cell of height are allowed for.
    """
    grid = solid.map.layout
    cell = max(grid.dx, grid.dy)
    return _index(solid, 4.0 * cell, in_rows(grid, solid.map.height).astype(float) + 0.5 * cell)


def _index(solid: Solid, size: float, height: FloatArray | None) -> Index:
    grid = solid.map.layout
    across = max(1, math.ceil(grid.across * grid.dx / size - 1e-9))
    along = max(1, math.ceil(grid.along * grid.dy / size - 1e-9))
    most = np.full(across * along, np.inf)
    if height is not None:
        most = _highest_of(height, grid, size, across, along)
    given = (solid.path, solid.tools, grid.x, grid.y, size, across, along, most)
    count = np.zeros(across * along + 1, np.int64)
    _squares(*given, count, np.empty(0, np.int64), False)
    first = np.concatenate(([0], np.cumsum(count[:-1]))).astype(np.int64)
    segment = np.empty(int(first[-1]), np.int64)
    _squares(*given, first.copy(), segment, True)
    return Index(grid.x, grid.y, size, across, along, first, segment)


def _highest_of(height: FloatArray, grid: Layout, size: float, across: int, along: int) -> FloatArray:
    """Highest cell of each square and two cells round it; outside of the stock nothing stands."""
    out = np.full((along, across), -np.inf)
    for j in range(along):
        low, high = int(j * size / grid.dy) - 2, math.ceil((j + 1) * size / grid.dy) + 2
        strip = height[max(low, 0) : high].max(axis=0)
        for i in range(across):
            a, b = int(i * size / grid.dx) - 2, math.ceil((i + 1) * size / grid.dx) + 2
            out[j, i] = strip[max(a, 0) : b].max()
    return out.reshape(-1)


@stepping
def shaped(solid: Solid, index: Index, x: float, y: float) -> tuple[float, int]:
    """Height of what is left at a point [m] and the segment that made it, -1 the stock; minus infinity outside of the stock."""
    if not within(solid, x, y):
        return -math.inf, STOCK
    i = min(max(math.floor((x - index.x) / index.size), 0), index.across - 1)
    j = min(max(math.floor((y - index.y) / index.size), 0), index.along - 1)
    height, owner = top_at(solid, x, y), STOCK
    k = j * index.across + i
    for n in range(index.first[k], index.first[k + 1]):
        left = segment_height(solid.path, solid.tools, index.segment[n], x, y)
        if left < height:
            height, owner = left, index.segment[n]
    return height, owner


@stepping
def least_height(solid: Solid, index: Index, x: float, y: float) -> float:
    """Height that all moves together leave at a point, and the stock [m]: the truth, by the index of all segments."""
    i = min(max(math.floor((x - index.x) / index.size), 0), index.across - 1)
    j = min(max(math.floor((y - index.y) / index.size), 0), index.along - 1)
    height = top_at(solid, x, y)
    k = j * index.across + i
    for n in range(index.first[k], index.first[k + 1]):
        height = min(height, segment_height(solid.path, solid.tools, index.segment[n], x, y))
    return height


@compiled
def _differences(solid: Solid, index: Index, x: FloatArray, y: FloatArray, out: FloatArray) -> int:
    """Surface minus truth at points of the cut surface, 0 elsewhere; how many points were cut."""
    found, cut = np.empty(16, np.int64), 0
    for i in range(x.shape[0]):
        out[i] = 0.0
        height, owner = surface(solid, solid.path.first.size - 1, x[i], y[i], found)
        if owner == STOCK:
            continue
        cut += 1
        bottom = bottom_at(solid, x[i], y[i])
        out[i] = max(height, bottom) - max(least_height(solid, index, x[i], y[i]), bottom)
    return cut


class SurfaceCheck(NamedTuple):
    """How far the looked-up surface stands above the truth at random points."""

    largest: float  # [m]
    points: int  # on the cut surface
    x: float  # where the largest is [m]
    y: float


def surface_check(solid: Solid, points: int, seed: int = 0) -> SurfaceCheck:
    """The looked-up surface against the least of all moves, at random points that were cut."""
    grid = solid.map.layout
    index = index_of(solid)
    draw = np.random.default_rng(seed)
    x = grid.x + grid.across * grid.dx * draw.random(points)
    y = grid.y + grid.along * grid.dy * draw.random(points)
    out = np.empty(points)
    cut = _differences(solid, index, x, y, out)
    worst = int(np.argmax(out))
    return SurfaceCheck(float(out[worst]), int(cut), float(x[worst]), float(y[worst]))
