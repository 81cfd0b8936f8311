r"""The surface that a height map stands for, exact between its cells.

The height at a point is the least of what the moves leave there whose ids stand at the four cells around it, in double and in
closed form; where these differ, of the sixteen cells around. It is never below the truth, and equal to it unless a move that
shaped the point owns no cell near it: walls, corners and cusps are exact on a coarse grid.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, inlined_stepping, stepping
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
_BITS = 4  # of a cell in a block


class Solid(NamedTuple):
    """What is left of a stock, seen along one tool axis."""

    map: HeightMap
    outline: Outline
    path: Segments
    tools: Cutters


@inlined_stepping
def within(solid: Solid, x: float, y: float) -> bool:
    r"""Whether a point is inside the outline of the stock.

    Parameters
    ----------
    solid : Solid
        The material; its outline is a rectangle, a circle :math:`(x - x_0)^2 + (y - y_0)^2 \le r^2`, or cells.
    x, y : float
        The point [m].

    Returns
    -------
    bool
        True on the outline too.

    Notes
    -----
    Valid for any point. An outline of cells is true to the size of a cell.

    Examples
    --------
    A block of 8 x 4 mm, and a bar of 4 mm radius about its lower edge's middle: (7, 3) mm is 4.24 mm from it.

    >>> from cutwise.maths.envelopes import segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.profiles import cutters, flat
    >>> stock = height_map(layout((0.0, 8e-3), (0.0, 4e-3), 1e-3), np.ones((4, 8)), -5e-3, 0.0)
    >>> block = Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), segments([], []), cutters([flat(1e-3)]))
    >>> bar = block._replace(outline=Outline(CIRCLE, 4e-3, 0.0, 4e-3))
    >>> within(block, 7e-3, 3e-3), within(block, 8.1e-3, 3e-3), within(bar, 7e-3, 3e-3)
    (True, False, False)
    """
    grid, outline = solid.map.layout, solid.outline
    u, v = (x - grid.x) / grid.dx, (y - grid.y) / grid.dy
    if not (0.0 <= u <= grid.across and 0.0 <= v <= grid.along):
        return False
    if outline.kind == RECTANGLE:
        return True
    if outline.kind == CIRCLE:
        return (x - outline.x) ** 2 + (y - outline.y) ** 2 <= outline.radius**2
    return solid.map.share[cell(grid, int(min(u, grid.across - 1)), int(min(v, grid.along - 1)))] > 0.0


@inlined_stepping
def cell(grid: Layout, i: int, j: int) -> int:
    r"""Number of a cell of the stock, counted along x and y; rings have negative numbers or those beyond.

    .. math:: 256 \left(\lfloor b / 16 \rfloor n_b + \lfloor a / 16 \rfloor\right) + 16\,(b \bmod 16) + a \bmod 16

    with :math:`a = i + 2`, :math:`b = j + 2` and :math:`n_b` blocks along x.

    Parameters
    ----------
    grid : Layout
        The cells.
    i, j : int
        Cell along x and along y, -2 and more.

    Returns
    -------
    int
        Its place in the arrays of a map.

    Notes
    -----
    Valid within the stock and its two rings; nothing is checked.

    Examples
    --------
    The first cell stands behind two rings, at 2 * 16 + 2. Cell (20, 0) is the seventh of that row in the second block.

    >>> from cutwise.maths.height_map import layout
    >>> grid = layout((0.0, 30e-3), (0.0, 4e-3), 1e-3)
    >>> cell(grid, 0, 0), cell(grid, 20, 0)
    (34, 294)
    """
    a, b = i + RINGS, j + RINGS
    block = (b // SIDE) * grid.columns + a // SIDE
    return (block * SIDE + b % SIDE) * SIDE + a % SIDE


@inlined_stepping
def nearest(solid: Solid, x: float, y: float) -> int:
    r"""Number of the cell in which a point is; -1 beyond the rings.

    Parameters
    ----------
    solid : Solid
        The material.
    x, y : float
        The point [m].

    Returns
    -------
    int
        :func:`cell` of :math:`\lfloor (x - x_0) / \Delta x \rfloor, \lfloor (y - y_0) / \Delta y \rfloor`.

    Notes
    -----
    Valid for any point; one on the border of two cells is of the upper one.

    Examples
    --------
    In cells of 1 mm: the first, the fourth of the third row (34 + 3 + 2 * 16), and 3 mm outside.

    >>> from cutwise.maths.envelopes import segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.profiles import cutters, flat
    >>> stock = height_map(layout((0.0, 8e-3), (0.0, 4e-3), 1e-3), np.ones((4, 8)), -5e-3, 0.0)
    >>> block = Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), segments([], []), cutters([flat(1e-3)]))
    >>> nearest(block, 0.5e-3, 0.5e-3), nearest(block, 3.5e-3, 2.5e-3), nearest(block, -3e-3, 0.5e-3)
    (34, 69, -1)
    """
    grid = solid.map.layout
    i, j = math.floor((x - grid.x) / grid.dx), math.floor((y - grid.y) / grid.dy)
    if not (-RINGS <= i < grid.across + RINGS and -RINGS <= j < grid.along + RINGS):
        return -1
    return cell(grid, i, j)


@inlined_stepping
def top_at(solid: Solid, x: float, y: float) -> float:
    r"""Upper side of the uncut stock, bilinear between the middles of its cells [m].

    .. math:: z = \frac{\sum w_c z_c}{\sum w_c}, \qquad w_c = (1 - |u - u_c|)(1 - |v - v_c|)

    over those of the four cells around that are stock or a ring round it, u and v counted in cells.

    Parameters
    ----------
    solid : Solid
        The material.
    x, y : float
        The point [m].

    Returns
    -------
    float
        Height [m]; minus infinity where none of them is.

    Notes
    -----
    Valid for tops of one height anywhere; for others within the stock and its rings.

    Examples
    --------
    Two cells of 1 mm, at 0 and at -1 mm: a quarter and half of the way between their middles.

    >>> from cutwise.maths.envelopes import segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.profiles import cutters, flat
    >>> top = np.array([[0.0, -1e-3]])
    >>> stock = height_map(layout((0.0, 2e-3), (0.0, 1e-3), 1e-3), np.ones((1, 2)), -5e-3, top)
    >>> raw = Solid(stock, Outline(CELLS, 0.0, 0.0, 0.0), segments([], []), cutters([flat(1e-3)]))
    >>> [round(1e3 * top_at(raw, x, 0.5e-3), 6) for x in (0.75e-3, 1e-3)]
    [-0.25, -0.5]
    """
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
    """Underside of the stock at a point [m]; of one with an underside per cell that of the cell.

    Parameters
    ----------
    solid : Solid
        The material.
    x, y : float
        The point [m].

    Returns
    -------
    float
        Height [m]; infinite beyond the rings of a stock with an underside per cell.

    Notes
    -----
    Valid to the size of a cell where cells have undersides of their own.

    Examples
    --------
    Two cells of 1 mm with undersides at -5 and -6 mm.

    >>> from cutwise.maths.envelopes import segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.profiles import cutters, flat
    >>> top, under = np.zeros((1, 2)), np.array([[-5e-3, -6e-3]])
    >>> stock = height_map(layout((0.0, 2e-3), (0.0, 1e-3), 1e-3), np.ones((1, 2)), under, top)
    >>> raw = Solid(stock, Outline(CELLS, 0.0, 0.0, 0.0), segments([], []), cutters([flat(1e-3)]))
    >>> [bottom_at(raw, x, 0.5e-3) for x in (0.9e-3, 1.1e-3, 9e-3)]
    [-0.005, -0.006, inf]
    """
    bottom = solid.map.bottom
    if bottom.size == 1:
        return bottom[0]
    at = nearest(solid, x, y)
    return bottom[at] if at >= 0 else math.inf


@inlined_stepping
def _gathered(solid: Solid, i: int, j: int, low: int, high: int, found: IntArray) -> int:
    """Ids of the cells from ``low`` to ``high`` beside cell (i, j), each once; their number."""
    grid, count = solid.map.layout, 0
    begin_u, end_u = max(i + low, -RINGS), min(i + high, grid.across + RINGS)
    begin_v, end_v = max(j + low, -RINGS), min(j + high, grid.along + RINGS)
    for v in range(begin_v, end_v):
        b = v + RINGS
        row = (b >> _BITS) * grid.columns
        inner = (b & (SIDE - 1)) << _BITS
        for u in range(begin_u, end_u):
            a = u + RINGS
            at = ((row + (a >> _BITS)) << (2 * _BITS)) + inner + (a & (SIDE - 1))
            name = solid.map.cutter[at]
            if count > 0 and found[count - 1] == name:
                continue
            if solid.map.height[at] == NOTHING:
                continue
            known = False
            for k in range(count):
                known = known or found[k] == name
            if not known:
                found[count] = name
                count += 1
    return count


@inlined_stepping
def surface(solid: Solid, done: int, x: float, y: float, found: IntArray) -> tuple[float, int]:
    """Height of what is left at a point [m], and the move that made it (-1: the stock itself).

    Outside of the stock the height is minus infinity. ``done``: how many moves have been run; ``found``: room for 16 ids.

    Parameters
    ----------
    solid : Solid
        What is left of a stock.
    done : int
        How many moves have been run.
    x, y : float
        The point [m].
    found : array (16,)
        Room for ids, integers.

    Returns
    -------
    tuple
        Height [m] and move.

    Notes
    -----
    Valid above the underside, which is not looked at. Never below the truth; above it only where a move that shaped the point
    owns none of the four cells around, or, where these differ, none of the sixteen around nor is next in time to one that does.

    Examples
    --------
    A slot 1 mm deep whose wall is at y = 3 mm: exact to the side of it, although cells are 1 mm wide.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import cut_by, height_map, layout, room
    >>> from cutwise.maths.profiles import cutters, flat
    >>> grid, tools = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3), cutters([flat(1e-3)])
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> path = segments([line_row(0, np.array([-2e-3, 2e-3, -1e-3]), np.array([10e-3, 2e-3, -1e-3]))], [1])
    >>> taken = cut_by(stock, path, tools, 0, room(grid))
    >>> slot = Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, tools)
    >>> [surface(slot, 1, x, y, np.empty(16, np.int64)) for x, y in ((4e-3, 2.999e-3), (4e-3, 3.001e-3), (9e-3, 2e-3))]
    [(-0.001, 0), (0.0, -1), (-inf, -1)]

    References
    ----------
    Derived here.
    """
    if not within(solid, x, y):
        return -math.inf, STOCK
    return surface_within(solid, done, x, y, found)


@inlined_stepping
def surface_within(solid: Solid, done: int, x: float, y: float, found: IntArray) -> tuple[float, int]:
    """As :func:`surface`, of the stock carried on beyond its outline.

    Parameters
    ----------
    solid, done, x, y, found
        As there.

    Returns
    -------
    tuple
        Height [m] and move.

    Notes
    -----
    Valid to the two rings of cells round the stock.

    Examples
    --------
    The slot of :func:`surface`, 8 mm long, goes on at x = 8.5 mm.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import cut_by, height_map, layout, room
    >>> from cutwise.maths.profiles import cutters, flat
    >>> grid, tools = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3), cutters([flat(1e-3)])
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> path = segments([line_row(0, np.array([-2e-3, 2e-3, -1e-3]), np.array([10e-3, 2e-3, -1e-3]))], [1])
    >>> taken = cut_by(stock, path, tools, 0, room(grid))
    >>> slot = Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, tools)
    >>> [surface_within(slot, 1, 8.5e-3, y, np.empty(16, np.int64)) for y in (2.999e-3, 3.001e-3)]
    [(-0.001, 0), (0.0, -1)]

    References
    ----------
    As :func:`surface`.
    """
    return _down_to(solid, done, x, y, -math.inf, found)


@stepping
def surface_above(solid: Solid, done: int, x: float, y: float, level: float, found: IntArray) -> float:
    """As the height of :func:`surface`, as far down as a level: one that is not above it may be told too high.

    Parameters
    ----------
    solid, done, x, y, found
        As there.
    level : float
        Whether material stands above it is asked [m].

    Returns
    -------
    float
        Height [m].

    Notes
    -----
    Valid as :func:`surface`: above the level the height is that of it, and not above it where that is not.

    Examples
    --------
    The slot of :func:`surface` at -1 mm.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import cut_by, height_map, layout, room
    >>> from cutwise.maths.profiles import cutters, flat
    >>> grid, tools = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3), cutters([flat(1e-3)])
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> path = segments([line_row(0, np.array([-2e-3, 2e-3, -1e-3]), np.array([10e-3, 2e-3, -1e-3]))], [1])
    >>> taken = cut_by(stock, path, tools, 0, room(grid))
    >>> slot = Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, tools)
    >>> [surface_above(slot, 1, 4e-3, y, -0.5e-3, np.empty(16, np.int64)) for y in (2.999e-3, 3.001e-3)]
    [-0.001, 0.0]

    References
    ----------
    As :func:`surface`.
    """
    if not within(solid, x, y):
        return -math.inf
    at = nearest(solid, x, y)
    height = top_at(solid, x, y)
    if height > level and at >= 0 and solid.map.cutter[at] != STOCK:
        height = min(height, move_height(solid.path, solid.tools, solid.map.cutter[at], x, y))
    if not height > level:
        return height
    return _down_to(solid, done, x, y, level, found)[0]


@inlined_stepping
def _down_to(solid: Solid, done: int, x: float, y: float, level: float, found: IntArray) -> tuple[float, int]:
    """Height at a point and its move, looked for until it is not above a level [m]."""
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
                if not height > level:
                    return height, owner
        looked = high
    return height, owner


@compiled
def surfaces(solid: Solid, x: float, y: float, height: FloatArray, owner: IntArray) -> None:
    """:func:`surface` at many points [m]: arrays of shape (n,).

    Parameters
    ----------
    solid : Solid
        What is left when all moves have been run.
    x, y : array (n,)
        The points [m].
    height, owner : array (n,)
        Heights [m] and moves, which are written.

    Notes
    -----
    Valid as :func:`surface`.

    Examples
    --------
    A ball of 5 mm at -2 mm stands 1 mm higher at 3 mm beside its line.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import cut_by, height_map, layout, room
    >>> from cutwise.maths.profiles import ball, cutters
    >>> grid, tools = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3), cutters([ball(5e-3)])
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> path = segments([line_row(0, np.array([-9e-3, 0.0, -2e-3]), np.array([20e-3, 0.0, -2e-3]))], [1])
    >>> taken = cut_by(stock, path, tools, 0, room(grid))
    >>> height, owner = np.empty(2), np.empty(2, np.int64)
    >>> groove = Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, tools)
    >>> surfaces(groove, np.array([4e-3, 4e-3]), np.array([0.0, 3e-3]), height, owner)
    >>> (1e3 * height).round(9).tolist(), owner.tolist()
    ([-2.0, -1.0], [0, 0])

    References
    ----------
    As :func:`surface`.
    """
    found = np.empty(16, np.int64)
    for i in range(x.shape[0]):  # type: ignore[attr-defined]
        height[i], owner[i] = surface(solid, solid.path.first.size - 1, x[i], y[i], found)  # type: ignore[index]


@compiled
def corner_heights(solid: Solid, x: FloatArray, y: FloatArray, top: FloatArray, bottom: FloatArray) -> None:
    """Upper and lower side of what is left at points on the outline or within it [m]: arrays of shape (n,).

    Parameters
    ----------
    solid : Solid
        What is left when all moves have been run.
    x, y : array (n,)
        The points [m].
    top, bottom : array (n,)
        Heights [m], which are written; the upper one is never below the lower one.

    Notes
    -----
    Valid as :func:`surface_within`.

    Examples
    --------
    A corner of a block from -5 to 0 mm, and the end of a slot in it at -1 mm.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import cut_by, height_map, layout, room
    >>> from cutwise.maths.profiles import cutters, flat
    >>> grid, tools = layout((0.0, 8e-3), (0.0, 4e-3), 1e-3), cutters([flat(1e-3)])
    >>> stock = height_map(grid, np.ones((4, 8)), -5e-3, 0.0)
    >>> path = segments([line_row(0, np.array([-2e-3, 2e-3, -1e-3]), np.array([10e-3, 2e-3, -1e-3]))], [1])
    >>> taken = cut_by(stock, path, tools, 0, room(grid))
    >>> top, bottom = np.empty(2), np.empty(2)
    >>> slot = Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, tools)
    >>> corner_heights(slot, np.array([0.0, 8e-3]), np.array([0.0, 2e-3]), top, bottom)
    >>> top.tolist(), bottom.tolist()
    ([0.0, -0.001], [-0.005, -0.005])

    References
    ----------
    As :func:`surface`.
    """
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
    >>> from cutwise.maths.height_map import cut_by, height_map, layout, room
    >>> from cutwise.maths.profiles import cutters, flat
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
