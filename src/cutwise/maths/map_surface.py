r"""The surface that a height map stands for, exact between its cells.

The height at a point is the least of what the moves leave there whose ids stand at the four cells around it, in double and in
closed form; where these differ, of the sixteen cells around. It is never below the truth, and equal to it unless a move that
shaped the point owns no cell near it: walls, corners and cusps are exact on a coarse grid.
"""

import math

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, inlined_stepping
from cutwise.maths.envelopes import move_height
from cutwise.maths.height_map import NOTHING, RINGS, SIDE, STOCK
from cutwise.maths.solid import Solid, bottom_at, nearest, top_at, within

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_BITS = 4  # of a cell in a block


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
    >>> [surface_within(slot, 1, 8.5e-3, y, np.empty(16, np.int64)) for y in (2.999e-3, 3.001e-3)]
    [(-0.001, 0), (0.0, -1)]

    References
    ----------
    As :func:`surface`.
    """
    return _down_to(solid, done, x, y, -math.inf, (top_at(solid, x, y), STOCK), found)


@inlined_stepping
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
    return _down_to(solid, done, x, y, level, (height, solid.map.cutter[at] if at >= 0 else STOCK), found)[0]


@inlined_stepping
def _down_to(
    solid: Solid, done: int, x: float, y: float, level: float, known: tuple[float, int], found: IntArray
) -> tuple[float, int]:
    """Height at a point and its move, until it is not above a level [m]; ``known``: the least of stock and of one move."""
    grid = solid.map.layout
    i = math.floor((x - grid.x) / grid.dx - 0.5)
    j = math.floor((y - grid.y) / grid.dy - 0.5)
    height, owner = known
    looked = owner
    count = _gathered(solid, i, j, 0, 2, found)
    if count == 1:
        if found[0] != STOCK and found[0] != looked:
            left = move_height(solid.path, solid.tools, found[0], x, y)
            if left < height:
                height, owner = left, found[0]
        return height, owner
    count = _gathered(solid, i, j, -1, 3, found)
    for k in range(1, count):  # in their order, so that none is looked at twice
        name, n = found[k], k
        while n > 0 and found[n - 1] > name:
            found[n] = found[n - 1]
            n -= 1
        found[n] = name
    last = -1
    for k in range(count):
        if found[k] == STOCK:
            continue
        # a strip that is narrower than the grid is most often that of the move before or behind
        low, high = max(found[k] - 1, last + 1), min(found[k] + 1, done - 1)
        for name in range(low, high + 1):
            if name == looked:
                continue
            left = move_height(solid.path, solid.tools, name, x, y)
            if left < height:
                height, owner = left, name
                if not height > level:
                    return height, owner
        last = high
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
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.map_levels import room
    >>> from cutwise.maths.map_sweep import cut_by
    >>> from cutwise.maths.profiles import ball, cutters
    >>> from cutwise.maths.solid import RECTANGLE, Outline
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
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.map_levels import room
    >>> from cutwise.maths.map_sweep import cut_by
    >>> from cutwise.maths.profiles import cutters, flat
    >>> from cutwise.maths.solid import RECTANGLE, Outline
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
