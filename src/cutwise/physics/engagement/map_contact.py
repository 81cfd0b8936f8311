r"""What a tool of revolution meets of a height map at a place of its path: contact arcs of its edges, element by element.

An edge element on the meridian, its outward normal at kappa from down, cuts at the angle psi (from the horizontal feed, to the
left) where it moves into what it looks at, :math:`\cos\psi > k \cot\kappa` with k the slope of the move, and where material
stands higher than its rim. End cutting is just more elements, of kappa = 0. On the cylinder no heights are fixed beforehand:
the heights along its rim make layers, each with its own arcs.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import inlined_stepping, merged, stepping
from cutwise.maths.envelopes import ARC
from cutwise.maths.height_map import RINGS, SIDE, HeightMap
from cutwise.maths.profiles import Meridian
from cutwise.maths.workpiece import Workpiece
from cutwise.physics.engagement.map_arcs import arcs, settled
from cutwise.physics.engagement.map_fan import BITS, FAN, SHAVE, Fan, by_cells, cell_of, exactly, spread
from cutwise.physics.engagement.map_rim import FAR, Place

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

CYLINDER = -1  # element of a row of contact on the cylinder
_LAYERS = 24  # of the cylinder at one place
_EVEN = 16  # layers where the material is hollow
_ROUGH = 1e-7  # [m] of heights that are float32
_SLIVER = 1e-9  # [m] over the foot of the cylinder, or a bottom: rounding of two moves at one depth is no contact
FLAT = 1e-9  # sine of an element that is level
_MERGED = 0.01  # of the depth: heights that are one layer


class Edge(NamedTuple):
    """Where a tool cuts."""

    meridian: Meridian  # below the cylinder
    radius: float  # [m]
    foot: float  # height of the cylinder above the tip [m]
    end: float  # height at which its flutes end [m]


@inlined_stepping
def half_range(slope: float, sine: float, cosine: float) -> float:
    r"""Half of the angles at which an element moves into what it looks at [rad]; pi: all round.

    .. math:: \cos\psi > k \cot\kappa

    Parameters
    ----------
    slope : float
        Rise per horizontal length k [-]; infinite straight up or down.
    sine, cosine : float
        Of the angle kappa of its outward normal from down [-].

    Returns
    -------
    float
        Angle [rad].

    Notes
    -----
    Valid for any element of a tool that is not undercut.

    Examples
    --------
    The flank at 45 degrees of a ball that climbs by 1 in 2, and the bottom of a mill that goes down.

    >>> round(math.degrees(half_range(0.5, math.sqrt(0.5), math.sqrt(0.5))), 9), half_range(-0.1, 0.0, 1.0)
    (60.0, 3.141592653589793)

    References
    ----------
    Derived here.
    """
    if math.isinf(slope):
        return math.pi if slope < 0.0 and cosine > FLAT else 0.0
    if sine <= FLAT:
        return math.pi if slope < 0.0 else 0.0
    ratio = slope * cosine / sine
    return math.acos(min(max(ratio, -1.0), 1.0))


@stepping
def _highest_near(stock: HeightMap, x: float, y: float, radius: float) -> float:
    """Highest of the blocks that a tool at a place may reach [m]."""
    grid = stock.layout
    wide, tall = grid.dx * SIDE, grid.dy * SIDE
    x0, y0 = grid.x - RINGS * grid.dx, grid.y - RINGS * grid.dy
    a, b = max(0, math.floor((x - radius - x0) / wide)), min(grid.columns - 1, math.floor((x + radius - x0) / wide))
    c, d = max(0, math.floor((y - radius - y0) / tall)), min(grid.rows - 1, math.floor((y + radius - y0) / tall))
    top = -math.inf
    for j in range(c, d + 1):
        for i in range(a, b + 1):
            top = max(top, float(stock.highest[j * grid.columns + i]))
    return top


@merged
def _element_rows(
    piece: Workpiece, place: Place, edge: Edge, element: int, fan: Fan, rows: FloatArray, count: int, refine: bool
) -> int:
    """Arcs of one element of the meridian."""
    solid = piece.solid
    mer = edge.meridian
    half = half_range(place.slope, mer.sine[element], mer.cosine[element])
    if half <= 2.0 * SHAVE:
        return count
    level, radius = place.z + mer.height[element], mer.radius[element]
    if mer.sine[element] <= FLAT:
        level += _SLIVER
    if solid.map.bottom.size == 1 and level <= solid.map.bottom[0]:
        return count
    spread(fan, half)
    by_cells(piece, place, radius, level, fan, refine)
    curved = solid.path.row[place.segment, 0] == ARC
    if refine or curved:
        if curved and refine:
            for i in range(FAN + 1):  # cells do not know what of the arc has been run
                fan.asked[i] = fan.above[i] > 0.0 and not fan.exact[i]
            exactly(piece, place, radius, level, fan, False)
        settled(piece, place, radius, level, fan)
    first = count
    count = arcs(piece, place, radius, level, half, fan, rows, count, refine)
    for n in range(first, count):
        rows[n, 0] = element
        rows[n, 3], rows[n, 4] = mer.height[element], mer.height[element]
    return count


@stepping
def _layers(fan: Fan, deepest: float) -> int:
    """Heights along the rim, those that are close to one another as one, from below; how many."""
    order = fan.order
    for i in range(FAN + 1):  # sorted in place: nothing is allocated here
        value, k = fan.above[i], i
        while k > 0 and order[k - 1] > value:
            order[k] = order[k - 1]
            k -= 1
        order[k] = value
    merged = _MERGED
    while True:
        count, total, members, start = 0, 0.0, 0, 0.0
        for i in range(FAN + 1):
            depth = min(order[i], deepest)
            if depth <= _SLIVER:
                continue
            if members > 0 and depth - start > merged * deepest:
                if count < FAN:
                    fan.layer[count] = total / members
                count += 1
                total, members = 0.0, 0
            if members == 0:
                start = depth
            total += depth
            members += 1
        if members > 0:
            fan.layer[min(count, FAN)] = total / members
            count += 1
        if count <= _LAYERS:
            return count
        merged *= 2.0


@stepping
def _any_above(stock: HeightMap, place: Place, radius: float, level: float, fan: Fan) -> bool:
    """Whether a cell that the rim crosses, or one beside it, may stand above a level."""
    grid = stock.layout
    step = fan.angle[1] - fan.angle[0]
    turn_c, turn_s = math.cos(step), math.sin(step)
    c, s = math.cos(fan.angle[0]), math.sin(fan.angle[0])
    out_x, out_y = radius * (place.ux * c - place.uy * s), radius * (place.uy * c + place.ux * s)
    per_x, per_y = 1.0 / grid.dx, 1.0 / grid.dy
    begin_u, begin_v = (place.x - grid.x) * per_x + RINGS, (place.y - grid.y) * per_y + RINGS
    across, along, last = grid.columns * SIDE - 1, grid.rows * SIDE - 1, -1
    for _ in range(FAN + 1):
        i, j = math.floor(begin_u + out_x * per_x), math.floor(begin_v + out_y * per_y)
        out_x, out_y = out_x * turn_c - out_y * turn_s, out_y * turn_c + out_x * turn_s
        if i < 0 or j < 0 or i > across or j > along:
            continue
        block = (j >> BITS) * grid.columns + (i >> BITS)
        inner = 0 < i & (SIDE - 1) < SIDE - 1 and 0 < j & (SIDE - 1) < SIDE - 1
        if inner and (block == last or not stock.highest[block] > level):
            last = block
            continue
        for k in range(5):
            a, b = i + (k == 1) - (k == 2), j + (k == 3) - (k == 4)
            if (
                0 <= a <= across
                and 0 <= b <= along
                and stock.height[cell_of(a - RINGS, b - RINGS, grid.columns)] > level
            ):
                return True
    return False


@merged
def _cylinder_rows(
    piece: Workpiece, place: Place, edge: Edge, fan: Fan, rows: FloatArray, count: int, refine: bool
) -> int:
    """Arcs of the cylinder in layers of what stands along its rim."""
    solid = piece.solid
    if math.isinf(place.slope) or edge.end <= edge.foot:
        return count
    foot = place.z + edge.foot
    spread(fan, 0.5 * math.pi)
    if not _any_above(solid.map, place, edge.radius, foot, fan):
        return count
    bottom, highest = solid.map.bottom, 0.0
    under = max(bottom[0] - foot, 0.0) if bottom.size == 1 else 0.0  # flutes below the stock cut nothing
    hollow = piece.crossing or bottom.size > 1
    if hollow:
        for i in range(FAN + 1):
            fan.above[i], fan.exact[i] = -FAR, False
    else:
        by_cells(piece, place, edge.radius, foot, fan, True)
    asks = True
    while asks:  # exactly where it stands above the foot, and beside
        asks = False
        for i in range(FAN + 1):
            beside = fan.above[max(i - 1, 0)] > 0.0 or fan.above[i] > 0.0 or fan.above[min(i + 1, FAN)] > 0.0
            fan.asked[i] = (hollow or beside) and not fan.exact[i]
            asks = asks or fan.asked[i]
        if asks:
            exactly(piece, place, edge.radius, foot, fan, True)
    for i in range(FAN + 1):
        highest = max(highest, min(fan.above[i], edge.end - edge.foot))
    if highest <= under + _SLIVER:
        return count
    if hollow:
        return _cylinder_steps(piece, place, edge, (under, highest), fan, rows, count, refine)
    layers = _layers(fan, highest)
    held = fan.held
    for i in range(FAN + 1):
        held[i] = fan.above[i]
    low = under
    for n in range(layers):
        high = fan.layer[n]
        if high <= low:
            continue
        level = 0.5 * (low + high)
        for i in range(FAN + 1):
            fan.above[i] = held[i] - level
        first = count
        count = arcs(piece, place, edge.radius, foot + level, 0.5 * math.pi, fan, rows, count, refine)
        for k in range(first, count):
            rows[k, 0], rows[k, 3], rows[k, 4] = CYLINDER, edge.foot + low, edge.foot + high
        low = high
    return count


@stepping
def _cylinder_steps(
    piece: Workpiece,
    place: Place,
    edge: Edge,
    ends: tuple[float, float],
    fan: Fan,
    rows: FloatArray,
    count: int,
    refine: bool,
) -> int:
    """Arcs of the cylinder in even layers between two heights over its foot: what stands along the rim is hollow below."""
    low, high = ends
    width = (high - low) / _EVEN
    for n in range(_EVEN):
        level = place.z + edge.foot + low + (n + 0.5) * width
        fan.asked[:] = True
        exactly(piece, place, edge.radius, level, fan, False)
        first = count
        count = arcs(piece, place, edge.radius, level, 0.5 * math.pi, fan, rows, count, refine)
        for k in range(first, count):
            rows[k, 0], rows[k, 3], rows[k, 4] = (
                CYLINDER,
                edge.foot + low + n * width,
                edge.foot + low + (n + 1) * width,
            )
    return count


@stepping
def contact_rows(piece: Workpiece, place: Place, edge: Edge, fan: Fan, rows: FloatArray, refine: bool) -> int:
    r"""Rows of contact of a tool at a place; their number.

    An element cuts where :math:`\cos\psi > k \cot\kappa` and where the material stands higher than its rim.

    Parameters
    ----------
    piece : Workpiece
        The material before the move on which the place is.
    place, edge : Place, Edge
        Where the tool is, and where it cuts.
    fan : Fan
        Room, from :func:`fan_room`.
    rows : array (m, 5)
        Element (-1: the cylinder), arc from, to [rad], heights above the tip from, to [m].
    refine : bool
        Find the ends of arcs to 1e-7 rad; otherwise to half the distance of the 64 directions.

    Returns
    -------
    int
        How many rows were written.

    Notes
    -----
    Valid for arcs no narrower than a 64th of the cutting range: one between two directions is not seen. Arcs beyond the last row
    are left out. An arc that reaches behind the tool is split at :math:`\pm\pi`.

    Examples
    --------
    A flat mill of 5 mm along x, 3 mm outside of a block and 2 mm deep: the block begins at :math:`\sin\psi = 3/5` to its left.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.solid import RECTANGLE, Outline, Solid
    >>> from cutwise.physics.engagement.map_fan import fan_room
    >>> from cutwise.maths.profiles import cutters, flat, meridian
    >>> from cutwise.maths.workpiece import alone
    >>> stock = height_map(layout((0.0, 40e-3), (0.0, 20e-3), 1e-3), np.ones((20, 40)), -9e-3, 0.0)
    >>> path = segments([line_row(0, np.array([0.0, -3e-3, -2e-3]), np.array([40e-3, -3e-3, -2e-3]))], [1])
    >>> block = alone(Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, cutters([flat(5e-3)])))
    >>> place = Place(20e-3, -3e-3, -2e-3, 1.0, 0.0, 0.0, 0, 0, 0.5, 0)
    >>> edge, rows = Edge(meridian(flat(5e-3), 5e-3, 1), 5e-3, 0.0, 10e-3), np.zeros((8, 5))
    >>> count = contact_rows(block, place, edge, fan_room(), rows, True)
    >>> count, np.degrees(rows[0, 1:3]).round(4).tolist(), (1e3 * rows[0, 3:]).round(6).tolist()
    (1, [36.8699, 90.0], [0.0, 2.0])

    References
    ----------
    Derived here.
    """
    count = 0
    top = _highest_near(piece.solid.map, place.x, place.y, edge.radius) + _ROUGH
    if place.z >= top:
        return 0
    for element in range(edge.meridian.height.shape[0]):
        if place.z + edge.meridian.height[element] < top:
            count = _element_rows(piece, place, edge, element, fan, rows, count, refine)
    if place.z + edge.foot >= top:
        return count
    return _cylinder_rows(piece, place, edge, fan, rows, count, refine)
