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

from cutwise.maths.compiled import compiled, inlined_stepping, stepping
from cutwise.maths.envelopes import ARC, begun_height, segment_height
from cutwise.maths.map_surface import Solid, bottom_at, nearest, within
from cutwise.maths.profiles import Meridian
from cutwise.maths.workpiece import Workpiece, depth_under, height_under

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

FAN = 64  # directions along a rim
CYLINDER = -1  # element of a row of contact on the cylinder
_SHAVE = 1e-7  # [rad] off the ends of the cutting range, where the rim touches the tool's own flank
_ANGLE = 1e-7  # [rad] to which ends of arcs are found
_LAYERS = 24  # of the cylinder at one place
_EVEN = 16  # layers where the material is hollow
_MERGED = 0.01  # of the depth: heights that are one layer
_STEPS = 60
_OWN = 1e-8  # [m] of a tool's own way, short of where it is
_FAR = 1.0  # [m] that stands for an infinite height


class Edge(NamedTuple):
    """Where a tool cuts."""

    meridian: Meridian  # below the cylinder
    radius: float  # [m]
    foot: float  # height of the cylinder above the tip [m]
    end: float  # height at which its flutes end [m]


class Place(NamedTuple):
    """A tool on its way."""

    x: float  # tip [m]
    y: float
    z: float
    ux: float  # horizontal direction of the feed; program x where it goes straight up or down
    uy: float
    slope: float  # rise per horizontal length [-]; infinite straight up, minus infinity straight down
    segment: int  # of the path, on which it is
    first: int  # first segment of the same move
    share: float  # of the segment that it has run
    move: int  # that it is on


class Fan(NamedTuple):
    """Room to work in."""

    angle: FloatArray  # [rad], shape (65,)
    above: FloatArray  # height of the material over the rim [m], shape (65,)
    exact: npt.NDArray[np.bool_]  # shape (65,)
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
    """
    return Fan(
        np.empty(FAN + 1),
        np.empty(FAN + 1),
        np.empty(FAN + 1, np.bool_),
        np.empty(FAN + 1),
        np.empty(FAN + 1),
        np.empty(FAN + 1),
        np.empty(16, np.int64),
    )


@stepping
def _stands(piece: Workpiece, place: Place, x: float, y: float, found: IntArray) -> float:
    """Height of the material at a point before the move that is run, and cut by what of it has been run [m].

    On a line a tool's own sweep never comes where it cuts.
    """
    solid = piece.maps[0]
    height = height_under(piece, place.move, x, y, found)
    if height > place.z:
        for segment in range(place.first, place.segment - 1):
            height = min(height, segment_height(solid.path, solid.tools, segment, x, y))
        if place.segment > place.first:
            height = min(height, _behind(solid, place.segment - 1, 1.0, x, y))
        if solid.path.row[place.segment, 0] == ARC and place.share > 0.0:
            height = min(height, _behind(solid, place.segment, place.share, x, y))
    return height


@stepping
def _behind(solid: Solid, segment: int, share: float, x: float, y: float) -> float:
    """What has been run of a segment, but for the last of it: its end is the tool itself, whose rim is on its own border."""
    row = solid.path.row[segment]
    length = row[7] * abs(row[14]) if row[0] == ARC else row[7]
    if length > 0.0:
        share = max(share - _OWN / length, 0.0)
    return begun_height(solid.path, solid.tools, segment, share, x, y)


@inlined_stepping
def _bounded(value: float) -> float:
    return min(max(value, -_FAR), _FAR)


@stepping
def _over(piece: Workpiece, place: Place, radius: float, level: float, angle: float, found: IntArray) -> float:
    """Height of the material over a level at a point of the rim [m]; where others cut across, no more than the depth there."""
    c, s = math.cos(angle), math.sin(angle)
    x = place.x + radius * (place.ux * c - place.uy * s)
    y = place.y + radius * (place.uy * c + place.ux * s)
    return _over_at(piece, place, x, y, level, found)


@stepping
def _over_at(piece: Workpiece, place: Place, x: float, y: float, level: float, found: IntArray) -> float:
    """The same at a point in plan."""
    over = _bounded(_stands(piece, place, x, y, found) - level)
    if over > 0.0:
        if piece.maps[0].map.bottom.size > 1:
            over = min(over, _bounded(level - bottom_at(piece.maps[0], x, y)))
        if piece.crossing:
            over = min(over, depth_under(piece, x, y, level, found))
    return over


@stepping
def _change(
    piece: Workpiece,
    place: Place,
    radius: float,
    level: float,
    a: float,
    b: float,
    ga: float,
    gb: float,
    found: IntArray,
) -> float:
    """Angle between two at which contact begins or ends: false position, every third step a halving."""
    side = 0
    for step in range(_STEPS):
        if b - a <= _ANGLE:
            break
        middle = 0.5 * (a + b)
        if step % 3 != 2 and ga != gb:
            middle = min(max(a - ga * (b - a) / (gb - ga), a + 0.01 * (b - a)), b - 0.01 * (b - a))
        g = _over(piece, place, radius, level, middle, found)
        if (g > 0.0) == (ga > 0.0):
            a, ga = middle, g
            if side == 1:
                gb *= 0.5
            side = 1
        else:
            b, gb = middle, g
            if side == -1:
                ga *= 0.5
            side = -1
    return 0.5 * (a + b)


@inlined_stepping
def _range(slope: float, sine: float, cosine: float) -> float:
    """Half of the angles at which an element moves into what it looks at [rad]; pi: all round."""
    if math.isinf(slope):
        return math.pi if slope < 0.0 and cosine > 1e-9 else 0.0
    if sine <= 1e-9:
        return math.pi if slope < 0.0 else 0.0
    ratio = slope * cosine / sine
    return math.acos(min(max(ratio, -1.0), 1.0))


@stepping
def _spread(fan: Fan, half: float) -> int:
    """Directions over the cutting range; how many. All round, the last is the first again."""
    closed = half >= math.pi
    width = 2.0 * (half if closed else half - _SHAVE)
    for i in range(FAN + 1):
        fan.angle[i] = -0.5 * width + width * i / FAN
    return FAN + 1


@stepping
def _by_cells(piece: Workpiece, place: Place, radius: float, level: float, fan: Fan, refine: bool) -> None:
    """The fan by the cells in which its points are; where one is near the level, exactly."""
    solid = piece.maps[0]
    grid = solid.map.layout
    near = max(grid.dx, grid.dy)  # of material that rises by no more than 55 degrees
    step = fan.angle[1] - fan.angle[0]  # points are turned on from one to the next: no sine for each
    turn_c, turn_s = math.cos(step), math.sin(step)
    c, s = math.cos(fan.angle[0]), math.sin(fan.angle[0])
    out_x, out_y = radius * (place.ux * c - place.uy * s), radius * (place.uy * c + place.ux * s)
    own = place.first < place.segment or piece.crossing or solid.map.bottom.size > 1
    for i in range(FAN + 1):
        x, y = place.x + out_x, place.y + out_y
        out_x, out_y = out_x * turn_c - out_y * turn_s, out_y * turn_c + out_x * turn_s
        if not within(solid, x, y):  # the rings of cells round the stock are no material
            fan.above[i], fan.exact[i] = -_FAR, True
            continue
        over = _bounded(float(solid.map.height[nearest(solid, x, y)]) - level)
        fan.exact[i] = False
        if (refine and abs(over) < near) or (over > 0.0 and own):
            over = _over_at(piece, place, x, y, level, fan.found)
            fan.exact[i] = True
        fan.above[i] = over


@stepping
def _settled(piece: Workpiece, place: Place, radius: float, level: float, fan: Fan) -> None:
    """Where the fan changes its sign, both sides are exact: what cells said wrongly moves the change on."""
    changed = True
    while changed:
        changed = False
        for i in range(FAN):
            if (fan.above[i] > 0.0) != (fan.above[i + 1] > 0.0):
                for k in range(i, i + 2):
                    if not fan.exact[k]:
                        fan.above[k] = _over(piece, place, radius, level, fan.angle[k], fan.found)
                        fan.exact[k] = True
                        changed = True


@stepping
def _arcs(
    piece: Workpiece, place: Place, radius: float, level: float, half: float, fan: Fan, rows: FloatArray, count: int,
    refine: bool,
) -> int:  # fmt: skip
    """Arcs of a settled fan into rows, columns 1 and 2; their number with those before."""
    low, inside = 0.0, False
    for i in range(FAN + 1):
        now = fan.above[i] > 0.0
        if now and not inside:
            low = -half
            if i > 0:
                low = 0.5 * (fan.angle[i - 1] + fan.angle[i])
                if refine:
                    low = _change(
                        piece, place, radius, level, fan.angle[i - 1], fan.angle[i], fan.above[i - 1], fan.above[i],
                        fan.found,
                    )  # fmt: skip
        elif inside and not now:
            high = 0.5 * (fan.angle[i - 1] + fan.angle[i])
            if refine:
                high = _change(
                    piece,
                    place,
                    radius,
                    level,
                    fan.angle[i - 1],
                    fan.angle[i],
                    fan.above[i - 1],
                    fan.above[i],
                    fan.found,
                )
            if high > low and count < rows.shape[0]:
                rows[count, 1], rows[count, 2] = low, high
                count += 1
        inside = now
    if inside and count < rows.shape[0]:
        rows[count, 1], rows[count, 2] = low, half
        count += 1
    return count


@stepping
def _element_rows(
    piece: Workpiece, place: Place, edge: Edge, element: int, fan: Fan, rows: FloatArray, count: int, refine: bool
) -> int:
    """Arcs of one element of the meridian."""
    solid = piece.maps[0]
    mer = edge.meridian
    half = _range(place.slope, mer.sine[element], mer.cosine[element])
    if half <= 2.0 * _SHAVE:
        return count
    level, radius = place.z + mer.height[element], mer.radius[element]
    if solid.map.bottom.size == 1 and level <= solid.map.bottom[0]:
        return count
    _spread(fan, half)
    _by_cells(piece, place, radius, level, fan, refine)
    curved = solid.path.row[place.segment, 0] == ARC
    if refine or curved:
        if curved and refine:
            for i in range(FAN + 1):  # cells do not know what of the arc has been run
                if fan.above[i] > 0.0 and not fan.exact[i]:
                    fan.above[i] = _over(piece, place, radius, level, fan.angle[i], fan.found)
                    fan.exact[i] = True
        _settled(piece, place, radius, level, fan)
    first = count
    count = _arcs(piece, place, radius, level, half, fan, rows, count, refine)
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
            if depth <= 0.0:
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
def _any_above(solid: Solid, place: Place, radius: float, level: float, fan: Fan) -> bool:
    """Whether a cell that the rim crosses, or one beside it, may stand above a level."""
    grid = solid.map.layout
    for i in range(FAN + 1):
        c, s = math.cos(fan.angle[i]), math.sin(fan.angle[i])
        x = place.x + radius * (place.ux * c - place.uy * s)
        y = place.y + radius * (place.uy * c + place.ux * s)
        for k in range(5):
            at = nearest(solid, x + grid.dx * ((k == 1) - (k == 2)), y + grid.dy * ((k == 3) - (k == 4)))
            if at >= 0 and solid.map.height[at] > level:
                return True
    return False


@stepping
def _cylinder_rows(
    piece: Workpiece, place: Place, edge: Edge, fan: Fan, rows: FloatArray, count: int, refine: bool
) -> int:
    """Arcs of the cylinder in layers of what stands along its rim."""
    solid = piece.maps[0]
    if math.isinf(place.slope) or edge.end <= edge.foot:
        return count
    foot = place.z + edge.foot
    _spread(fan, 0.5 * math.pi)
    if not _any_above(solid, place, edge.radius, foot, fan):
        return count
    bottom, highest = solid.map.bottom, 0.0
    under = max(bottom[0] - foot, 0.0) if bottom.size == 1 else 0.0  # flutes below the stock cut nothing
    for i in range(FAN + 1):
        fan.above[i] = _rises(piece, place, edge.radius, foot, fan.angle[i], fan.found)
        highest = max(highest, min(fan.above[i], edge.end - edge.foot))
    if highest <= under:
        return count
    if piece.crossing or bottom.size > 1:
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
        count = _arcs(piece, place, edge.radius, foot + level, 0.5 * math.pi, fan, rows, count, refine)
        for k in range(first, count):
            rows[k, 0], rows[k, 3], rows[k, 4] = CYLINDER, edge.foot + low, edge.foot + high
        low = high
    return count


@stepping
def _rises(piece: Workpiece, place: Place, radius: float, level: float, angle: float, found: IntArray) -> float:
    """Height of the upper side of the material over a level at a point of the rim [m], hollow below or not."""
    c, s = math.cos(angle), math.sin(angle)
    x = place.x + radius * (place.ux * c - place.uy * s)
    y = place.y + radius * (place.uy * c + place.ux * s)
    return _bounded(_stands(piece, place, x, y, found) - level)


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
        for i in range(FAN + 1):
            fan.above[i] = _over(piece, place, edge.radius, level, fan.angle[i], fan.found)
        first = count
        count = _arcs(piece, place, edge.radius, level, 0.5 * math.pi, fan, rows, count, refine)
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
    >>> from cutwise.maths.map_surface import RECTANGLE, Outline
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
    for element in range(edge.meridian.height.shape[0]):
        count = _element_rows(piece, place, edge, element, fan, rows, count, refine)
    return _cylinder_rows(piece, place, edge, fan, rows, count, refine)


@stepping
def removal(rows: FloatArray, count: int, edge: Edge, slope: float) -> float:
    r"""Volume that rows of contact take per horizontal length, straight down per depth [m^2].

    .. math:: \sum r\,ds \int (\sin\kappa \cos\psi - k \cos\kappa)\,d\psi

    Parameters
    ----------
    rows, count : array (m, 5), int
        Contact, from :func:`contact_rows`.
    edge : Edge
        Where the tool cuts.
    slope : float
        Rise per horizontal length :math:`k` [-]; infinite: straight down, where the term of :math:`\cos\kappa` alone counts.

    Returns
    -------
    float
        Area [m^2].

    Notes
    -----
    Valid to the width of the elements: one that is partly in contact counts whole or not at all.

    Examples
    --------
    The mill of :func:`contact_rows` takes 2 mm of the block 2 mm deep; straight down the whole of its bottom takes
    :math:`\pi R^2`.

    >>> from cutwise.maths.profiles import flat, meridian
    >>> edge = Edge(meridian(flat(5e-3), 0.0, 1), 5e-3, 0.0, 10e-3)
    >>> side = np.array([[CYLINDER, math.asin(0.6), 0.5 * math.pi, 0.0, 2e-3]])
    >>> bottom = np.array([[0, -math.pi, math.pi, 0.0, 0.0]])
    >>> round(1e6 * removal(side, 1, edge, 0.0), 6), round(1e6 * removal(bottom, 1, edge, -math.inf), 6)
    (4.0, 78.539816)

    References
    ----------
    Derived here: the flow of the feed through the surface in contact.
    """
    mer, area = edge.meridian, 0.0
    for n in range(count):
        element, low, high = int(rows[n, 0]), rows[n, 1], rows[n, 2]
        turn = math.sin(high) - math.sin(low)
        if element == CYLINDER:
            area += edge.radius * (rows[n, 4] - rows[n, 3]) * turn
        elif math.isinf(slope):
            area += mer.radius[element] * mer.length[element] * mer.cosine[element] * (high - low)
        else:
            area += (
                mer.radius[element] * mer.length[element]
                * (mer.sine[element] * turn - slope * mer.cosine[element] * (high - low))
            )  # fmt: skip
    return area


@stepping
def angle_of_contact(rows: FloatArray, count: int, edge: Edge) -> float:
    """Largest sum of arcs at one height, of flute elements with kappa of at least 45 degrees [rad].

    Parameters
    ----------
    rows, count : array (m, 5), int
        Contact, from :func:`contact_rows`: arcs at one height follow one another.
    edge : Edge
        Where the tool cuts.

    Returns
    -------
    float
        Angle [rad]; 0 without contact.

    Notes
    -----
    Valid for any tool; of a flat one the cylinder alone counts, of a ball the upper part.

    Examples
    --------
    Two arcs of 30 and of 40 degrees in one layer, and one of 60 in the layer above; the bottom does not count.

    >>> from cutwise.maths.profiles import flat, meridian
    >>> layers = [[CYLINDER, -90, -60, 0, 1e-3], [CYLINDER, 20, 60, 0, 1e-3], [CYLINDER, 0, 60, 1e-3, 2e-3]]
    >>> rows = np.array([[0, -180, 180, 0, 0], *layers])
    >>> rows[:, 1:3] = np.radians(rows[:, 1:3])
    >>> round(math.degrees(angle_of_contact(rows, 4, Edge(meridian(flat(5e-3), 0.0, 1), 5e-3, 0.0, 10e-3))), 9)
    70.0

    References
    ----------
    Derived here.
    """
    largest = here = 0.0
    for n in range(count):
        element = int(rows[n, 0])
        if element != CYLINDER and edge.meridian.sine[element] < math.sqrt(0.5) * (1.0 - 1e-9):
            here = 0.0
            continue
        same = n > 0 and rows[n, 0] == rows[n - 1, 0] and rows[n, 3] == rows[n - 1, 3]
        here = here + rows[n, 2] - rows[n, 1] if same else rows[n, 2] - rows[n, 1]
        largest = max(largest, here)
    return largest
