"""A fan of directions along a rim of a tool: where material stands over it, by the cells of a map or exactly."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, inlined_stepping, stepping
from cutwise.maths.height_map import BLOCK, RINGS, SIDE, HeightMap
from cutwise.maths.solid import RECTANGLE, Solid, within
from cutwise.maths.workpiece import Workpiece
from cutwise.physics.engagement.map_rim import FAR, Place, over_at

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

FAN = 64  # directions along a rim
SHAVE = 1e-7  # [rad] off the ends of the cutting range, where the rim touches the tool's own flank
BITS = 4  # of a cell in a block
_RINGS, _SHIFT, _INNER = np.int32(RINGS), np.int32(BITS), np.int32(SIDE - 1)
_ROUND = 0.02  # of a cell: what a surface of six cells radius is off its slope within a cell


class Fan(NamedTuple):
    """Room to work in."""

    angle: FloatArray  # [rad], shape (65,)
    cosine: FloatArray  # of the angles [-]
    sine: FloatArray
    cell: npt.NDArray[
        np.int32
    ]  # in which a point of the rim is, by its place in a map; -1 outside of the stock, shape (65,)
    above: FloatArray  # height of the material over the rim [m], shape (65,)
    exact: npt.NDArray[np.bool_]  # shape (65,)
    asked: npt.NDArray[np.bool_]  # which are to be found exactly, shape (65,)
    layer: FloatArray  # shape (65,)
    order: FloatArray  # shape (65,)
    held: FloatArray  # shape (65,)
    found: IntArray  # shape (16,)


@compiled
def fan_room() -> Fan:
    """Room for one fan.

    Returns
    -------
    Fan
        Arrays to work in, their values not set: 65 directions, of which all round the last is the first again, and 16 ids.

    Notes
    -----
    Valid for one place at a time.

    Examples
    --------
    >>> fan = fan_room()
    >>> fan.angle.size, fan.found.size
    (65, 16)

    References
    ----------
    Derived here.
    """
    n = FAN + 1
    return Fan(
        np.zeros(n), np.empty(n), np.empty(n), np.empty(n, np.int32), np.empty(n), np.empty(n, np.bool_),
        np.empty(n, np.bool_), np.empty(n), np.empty(n), np.empty(n), np.empty(16, np.int64),
    )  # fmt: skip


@stepping
def spread(fan: Fan, half: float) -> None:
    """Directions over a cutting range, its very ends shaved off; all round, the last is the first again.

    Parameters
    ----------
    fan : Fan
        Room; angles, cosines and sines are written.
    half : float
        Half of the range [rad], at most pi.

    Notes
    -----
    Valid to rounding: cosines and sines are turned on, twice as many at a time, six times over.

    Examples
    --------
    >>> fan = fan_room()
    >>> spread(fan, 0.5 * math.pi)
    >>> [round(float(v), 6) for v in (fan.angle[48], fan.cosine[48], fan.sine[0])]
    [0.785398, 0.707107, -1.0]

    References
    ----------
    Derived here.
    """
    width = 2.0 * (half if half >= math.pi else half - SHAVE)
    if fan.angle[0] == -0.5 * width and fan.angle[0] < 0.0:
        return  # the range of the element before
    for i in range(FAN + 1):
        fan.angle[i] = -0.5 * width + width * i / FAN
    c, s = fan.cosine, fan.sine
    c[0], s[0] = math.cos(fan.angle[0]), math.sin(fan.angle[0])
    turn_c, turn_s, n = math.cos(width / FAN), math.sin(width / FAN), 1
    while n < FAN:
        for i in range(n):
            c[n + i], s[n + i] = c[i] * turn_c - s[i] * turn_s, s[i] * turn_c + c[i] * turn_s
        turn_c, turn_s, n = 1.0 - 2.0 * turn_s * turn_s, 2.0 * turn_s * turn_c, 2 * n
    c[FAN], s[FAN] = c[0] * turn_c - s[0] * turn_s, s[0] * turn_c + c[0] * turn_s


@inlined_stepping
def cell_of(i: int, j: int, columns: int) -> int:
    """Number of a cell of the stock, as :func:`cutwise.maths.solid.cell`, by shifts.

    Parameters
    ----------
    i, j : int
        Cell along x and along y, -2 and more.
    columns : int
        Blocks along x.

    Returns
    -------
    int
        Its place in the arrays of a map.

    Notes
    -----
    Valid within the stock and its two rings; nothing is checked.

    Examples
    --------
    >>> cell_of(0, 0, 3), cell_of(20, 0, 3)
    (34, 294)

    References
    ----------
    Derived here.
    """
    a, b = i + RINGS, j + RINGS
    return ((((b >> BITS) * columns + (a >> BITS)) * SIDE + (b & (SIDE - 1))) << BITS) + (a & (SIDE - 1))


@inlined_stepping
def _cells(solid: Solid, place: Place, radius: float, fan: Fan) -> None:
    """Cells in which the points of the rim are, lane by lane."""
    grid = solid.map.layout
    per_x, per_y = 1.0 / grid.dx, 1.0 / grid.dy
    begin_u, begin_v = (place.x - grid.x) * per_x, (place.y - grid.y) * per_y
    ahead_u, ahead_v = radius * place.ux * per_x, radius * place.uy * per_y
    aside_u, aside_v = -radius * place.uy * per_x, radius * place.ux * per_y
    most_u, most_v = float(grid.across), float(grid.along)
    c, s, cell, columns = fan.cosine, fan.sine, fan.cell, np.int32(grid.columns)
    last_u, last_v = np.int32(grid.across - 1), np.int32(grid.along - 1)
    for i in range(FAN + 1):
        u, v = begin_u + ahead_u * c[i] + aside_u * s[i], begin_v + ahead_v * c[i] + aside_v * s[i]
        inside = (u >= 0.0) & (u <= most_u) & (v >= 0.0) & (v <= most_v)
        a, b = np.int32(u if inside else 0.0), np.int32(v if inside else 0.0)
        a = (a if a < last_u else last_u) + _RINGS
        b = (b if b < last_v else last_v) + _RINGS
        at = (((((b >> _SHIFT) * columns + (a >> _SHIFT)) << _SHIFT) + (b & _INNER)) << _SHIFT) + (a & _INNER)
        cell[i] = at if inside else np.int32(-1)


@inlined_stepping
def _near(stock: HeightMap, fan: Fan, i: int, near: float) -> bool:
    """Whether what the cell of a direction says may be wrong: cells beside differ from it by as much as it does from the level.

    On a slope the height within a cell is off its middle by no more than that, and on a round of six cells by 0.02 of a cell more.
    """
    over = abs(fan.above[i])
    if fan.exact[i] or over >= near:
        return False
    columns, height, at = stock.layout.columns, stock.height, np.int64(fan.cell[i])
    here, most = height[at], np.float32(0.0)
    a, b, far = (
        at & (SIDE - 1),
        (at >> BITS) & (SIDE - 1),
        (columns - 1) << (2 * BITS),
    )  # beside in the block, or across its border
    most = max(most, abs(height[at - 1 - (BLOCK - SIDE if a == 0 else 0)] - here))
    most = max(most, abs(height[at + 1 + (BLOCK - SIDE if a == SIDE - 1 else 0)] - here))
    most = max(most, abs(height[at - SIDE - (far if b == 0 else 0)] - here))
    most = max(most, abs(height[at + SIDE + (far if b == SIDE - 1 else 0)] - here))
    return over <= most + _ROUND * near


@inlined_stepping
def by_cells(piece: Workpiece, place: Place, radius: float, level: float, fan: Fan, refine: bool) -> None:
    """Heights of the material over the rim by the cells in which its points are; where one is near the level, exactly.

    Parameters
    ----------
    piece : Workpiece
        The material before the move on which the place is.
    place : Place
        Where the tool is.
    radius, level : float
        Radius of the rim, and its height [m].
    fan : Fan
        Directions, from :func:`spread`; heights are written.
    refine : bool
        Ask exactly at all.

    Notes
    -----
    Valid for arcs no narrower than a direction, or than a cell.

    Examples
    --------
    A rim of 5 mm, 3 mm outside of a block and 2 mm deep: in the block beyond 36.9 degrees, which is the 46th of 64 directions.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.profiles import cutters, flat
    >>> from cutwise.maths.workpiece import alone
    >>> from cutwise.maths.solid import RECTANGLE, Outline
    >>> stock = height_map(layout((0.0, 40e-3), (0.0, 20e-3), 1e-3), np.ones((20, 40)), -9e-3, 0.0)
    >>> path = segments([line_row(0, np.array([0.0, -3e-3, -2e-3]), np.array([40e-3, -3e-3, -2e-3]))], [1])
    >>> block = alone(Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, cutters([flat(5e-3)])))
    >>> place = Place(20e-3, -3e-3, -2e-3, 1.0, 0.0, 0.0, 0, 0, 0.5, 0)
    >>> fan = fan_room()
    >>> spread(fan, 0.5 * math.pi)
    >>> by_cells(block, place, 5e-3, -2e-3, fan, True)
    >>> int(np.argmax(fan.above > 0.0)), float(fan.above[64])
    (46, 0.002)

    References
    ----------
    Derived here.
    """
    solid = piece.solid
    grid, height = solid.map.layout, solid.map.height
    _cells(solid, place, radius, fan)
    odd = solid.outline.kind != RECTANGLE
    above, exact, cell = fan.above, fan.exact, fan.cell
    for i in range(FAN + 1):
        at = cell[i]
        over = float(height[np.uint32(at if at >= 0 else 0)]) - level
        over = over if over > -FAR else -FAR
        over = over if over < FAR else FAR
        above[i] = over if at >= 0 else -FAR  # the rings of cells round the stock are no material
    if odd:
        _trimmed(solid, place, radius, fan)
    for i in range(FAN + 1):
        exact[i] = above[i] <= -FAR
    own = place.first < place.segment or piece.crossing or solid.map.bottom.size > 1
    if not (refine or own):
        return
    near, asks = max(grid.dx, grid.dy), False
    for i in range(FAN + 1):
        fan.asked[i] = (own and above[i] > 0.0 and not exact[i]) or (refine and _near(solid.map, fan, i, near))
        asks = asks or fan.asked[i]
    if asks:
        exactly(piece, place, radius, level, fan, False)


@stepping
def exactly(piece: Workpiece, place: Place, radius: float, level: float, fan: Fan, upper: bool) -> None:
    """Directions that are asked for, exactly.

    Parameters
    ----------
    piece : Workpiece
        The material before the move on which the place is.
    place : Place
        Where the tool is.
    radius, level : float
        Radius of the rim, and its height [m].
    fan : Fan
        Directions, from :func:`spread`, and which of them are asked for; their heights are written.
    upper : bool
        Heights of the upper side alone, hollow below or not.

    Notes
    -----
    Valid as :func:`cutwise.physics.engagement.map_rim.over_at`. All directions of a fan in one call: to hand over the arrays of the
    material takes a seventh of a microsecond, longer than to look a height up.

    Examples
    --------
    A rim of 5 mm, 3 mm outside of a block and 2 mm deep, at its first direction and its last.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.profiles import cutters, flat
    >>> from cutwise.maths.workpiece import alone
    >>> from cutwise.maths.solid import RECTANGLE, Outline
    >>> stock = height_map(layout((0.0, 40e-3), (0.0, 20e-3), 1e-3), np.ones((20, 40)), -9e-3, 0.0)
    >>> path = segments([line_row(0, np.array([0.0, -3e-3, -2e-3]), np.array([40e-3, -3e-3, -2e-3]))], [1])
    >>> block = alone(Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, cutters([flat(5e-3)])))
    >>> place = Place(20e-3, -3e-3, -2e-3, 1.0, 0.0, 0.0, 0, 0, 0.5, 0)
    >>> fan = fan_room()
    >>> spread(fan, 0.5 * math.pi)
    >>> fan.asked[:], fan.asked[[0, 64]] = False, True
    >>> exactly(block, place, 5e-3, -2e-3, fan, False)
    >>> fan.above[[0, 64]].tolist()
    [-1.0, 0.002]

    References
    ----------
    Derived here.
    """
    for i in range(FAN + 1):
        if fan.asked[i]:
            c, s = fan.cosine[i], fan.sine[i]
            x = place.x + radius * (place.ux * c - place.uy * s)
            y = place.y + radius * (place.uy * c + place.ux * s)
            fan.above[i], fan.exact[i] = over_at(piece, place, x, y, level, upper, fan.found), True


@stepping
def _trimmed(solid: Solid, place: Place, radius: float, fan: Fan) -> None:
    """Nothing stands where the rim is outside of an outline that is no rectangle."""
    for i in range(FAN + 1):
        c, s = fan.cosine[i], fan.sine[i]
        x, y = place.x + radius * (place.ux * c - place.uy * s), place.y + radius * (place.uy * c + place.ux * s)
        if fan.above[i] > -FAR and not within(solid, x, y):
            fan.above[i] = -FAR
