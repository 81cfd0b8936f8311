"""A height map with its outline, and the moves and tools that its ids name."""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import inlined_stepping, stepping
from cutwise.maths.envelopes import Segments
from cutwise.maths.height_map import RINGS, SIDE, HeightMap, Layout
from cutwise.maths.profiles import Cutters

RECTANGLE, CIRCLE, CELLS = 0, 1, 2
_ASK = np.float32(-1e29)  # heights below it are no material


class Outline(NamedTuple):
    """Where stock stands in plan."""

    kind: int  # RECTANGLE, CIRCLE or CELLS
    x: float  # middle of a circle [m]
    y: float
    radius: float


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
