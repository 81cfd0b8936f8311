"""Which moves may have shaped a place of a stock: an index over its plan, and the looked-up surface held against all moves."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, stepping
from cutwise.maths.envelopes import LINE, Segments, segment_height
from cutwise.maths.height_map import STOCK, Layout, in_rows
from cutwise.maths.map_surface import surface
from cutwise.maths.profiles import Cutters, profile_height
from cutwise.maths.solid import Solid, bottom_at, top_at, within

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


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
    """Height of what is left at a point [m] and the segment that made it, -1 the stock; minus infinity outside of the stock.

    Parameters
    ----------
    solid : Solid
        What is left when all moves have been run.
    index : Index
        The segments that may have shaped it, from :func:`shaping_index`.
    x, y : float
        The point [m].

    Returns
    -------
    tuple
        Height [m] and segment.

    Notes
    -----
    Valid above the underside, which is not looked at. Exact where what stands between cells is no more than half a cell higher than
    the cells around.

    Examples
    --------
    A slot 1 mm deep whose wall is at y = 3 mm.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.map_levels import room
    >>> from cutwise.maths.map_sweep import cut_by
    >>> from cutwise.maths.profiles import cutters, flat
    >>> from cutwise.maths.solid import RECTANGLE, Outline
    >>> grid, tools = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3), cutters([flat(1e-3)])
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> path = segments([line_row(0, np.array([-2e-3, 2e-3, -1e-3]), np.array([10e-3, 2e-3, -1e-3]))], [1])
    >>> taken = cut_by(stock, path, tools, 0, room(grid))
    >>> slot = Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, tools)
    >>> [shaped(slot, shaping_index(slot), 4e-3, y) for y in (2.999e-3, 3.001e-3, 4.001e-3)]
    [(-0.001, 0), (0.0, -1), (-inf, -1)]

    References
    ----------
    Derived here.
    """
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
    r"""Height that all moves together leave at a point, and the stock [m]: the truth, by the index of all segments.

    Parameters
    ----------
    solid : Solid
        The stock, and its moves; the heights of its cells are not looked at.
    index : Index
        All segments, from :func:`index_of`.
    x, y : float
        The point [m].

    Returns
    -------
    float
        Height [m].

    Notes
    -----
    Valid inside of the outline and above the underside, neither of which is looked at.

    Examples
    --------
    Balls of 5 mm at -2 mm, 6 mm apart: midway a ridge of :math:`R - \sqrt{R^2 - p^2}` = 1 mm is left.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.profiles import ball, cutters
    >>> from cutwise.maths.solid import RECTANGLE, Outline
    >>> stock = height_map(layout((0.0, 8e-3), (0.0, 6e-3), 1e-3), np.ones((6, 8)), -5e-3, 0.0)
    >>> rows = [line_row(0, np.array([-9e-3, y, -2e-3]), np.array([20e-3, y, -2e-3])) for y in (0.0, 6e-3)]
    >>> solid = Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), segments(rows, [1, 1]), cutters([ball(5e-3)]))
    >>> [round(1e3 * least_height(solid, index_of(solid), 4e-3, y), 9) for y in (3e-3, 6e-3)]
    [-1.0, -2.0]

    References
    ----------
    Derived here.
    """
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


def surface_check(solid: Solid, points: int, seed: int = 0, index: Index | None = None) -> SurfaceCheck:
    """The looked-up surface against the least of all moves, at random points that were cut; ``index``: of all segments."""
    grid = solid.map.layout
    index = index_of(solid) if index is None else index
    draw = np.random.default_rng(seed)
    x = grid.x + grid.across * grid.dx * draw.random(points)
    y = grid.y + grid.along * grid.dy * draw.random(points)
    out = np.empty(points)
    cut = _differences(solid, index, x, y, out)
    worst = int(np.argmax(out))
    return SurfaceCheck(float(out[worst]), int(cut), float(x[worst]), float(y[worst]))
