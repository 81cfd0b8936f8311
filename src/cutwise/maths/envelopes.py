r"""Heights that a tool leaves along a line, a level arc or straight down, in closed form at any point.

A tool of profile f whose tip goes from A along u (horizontal) with the slope k leaves, at a point q along u from A and p
beside it, the height

.. math:: z = \min_s A_z + k s + f\left(\sqrt{(q - s)^2 + p^2}\right), \qquad 0 \le s \le L

For a convex f the least stands where the tool's radius is r*, :math:`p^2 = r_*^2 (1 - k^2 / f'(r_*)^2)`, so that
:math:`s = q - \operatorname{sign}(k) \sqrt{r_*^2 - p^2}`, clipped to where the tool reaches the point.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, inlined_stepping, stepping
from cutwise.maths.profiles import CONE, DISC, TUBE, Cutters, piece_height

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

LINE, ARC = 0.0, 1.0
COLUMNS = 16
_STEPS = 40  # of Newton's rule, which falls monotonically: 28 were needed in a million draws
_WHOLE = -2.0  # cosine of the half sweep of a full circle: every direction is within it
_UPRIGHT = 1e-12  # [m] in the plane: less is straight up or down


class Segments(NamedTuple):
    """Lines and level arcs of a path; the segments of one move stand together.

    Columns of a line: kind, tool, A (3), u (2), L, k. Of an arc: kind, tool, centre (2), z, direction of its middle (2), radius,
    cosine of the half sweep, start (2), end (2), angle of the start, sweep. Lengths in m, angles in rad.
    """

    row: FloatArray  # shape (n, 16)
    first: IntArray  # first segment of each move, and their number at the end, shape (moves + 1,)


def line_row(tool: int, start: FloatArray, end: FloatArray) -> list[float]:
    """A line of the tool tip, straight up or down too: then only its lower end counts."""
    dx, dy = float(end[0] - start[0]), float(end[1] - start[1])
    length = math.hypot(dx, dy)
    row = [LINE, float(tool), float(start[0]), float(start[1]), float(start[2]), 1.0, 0.0, 0.0, 0.0]
    if length > _UPRIGHT:
        row[5:9] = [dx / length, dy / length, length, float(end[2] - start[2]) / length]
    else:
        row[4] = min(float(start[2]), float(end[2]))
    return row + [0.0] * (COLUMNS - len(row))


def arc_row(tool: int, centre: FloatArray, height: float, radius: float, start: float, sweep: float) -> list[float]:
    """A level arc of the tool tip from the angle of its start, positive sweeps to the left [rad]."""
    whole = abs(sweep) >= 2.0 * math.pi * (1.0 - 1e-12)
    middle, half = start + 0.5 * sweep, 0.5 * abs(sweep)
    x, y = float(centre[0]), float(centre[1])
    return [
        ARC, float(tool), x, y, height, math.cos(middle), math.sin(middle), radius,
        _WHOLE if whole else math.cos(half), x + radius * math.cos(start), y + radius * math.sin(start),
        x + radius * math.cos(start + sweep), y + radius * math.sin(start + sweep), start, sweep, 0.0,
    ]  # fmt: skip


def segments(rows: list[list[float]], counts: list[int]) -> Segments:
    """The table of segments, ``counts`` of them for each move."""
    table = np.array(rows, float).reshape(-1, COLUMNS)
    return Segments(table, np.concatenate(([0], np.cumsum(counts))).astype(np.int64))


@inlined_stepping
def tube_sine(k2: float, p: float, flat: float, tube: float, most: float) -> float:
    r"""Sine t of the tube angle at which a torus touches what it leaves on a slope.

    The root of :math:`F(t) = (1 + k^2) t^2 r^2 - p^2 t^2 - k^2 r^2,\ r = R_f + r_c t`. F is convex right of it, so that
    Newton's rule falls onto it from the right: from 1, or where p lies within the flat from
    :math:`|k| / \sqrt{1 + k^2 - p^2 / R_f^2}`.

    Parameters
    ----------
    k2 : float
        Square of the slope :math:`k^2` [-].
    p : float
        Distance :math:`p` beside the line [m], 0 to :math:`R_f + r_c`.
    flat, tube : float
        Radius :math:`R_f` of the flat and :math:`r_c` of the tube [m], both positive.
    most : float
        Sine at the outer radius of the piece, at most 1 [-].

    Returns
    -------
    float
        The sine :math:`t`, 0 to ``most`` [-].

    Notes
    -----
    Valid for a positive flat radius: a ball has a closed form of its own. The root is found to 1e-13.

    Examples
    --------
    A slope of 3/4, a flat of 3 mm and a tube of 4 mm: at t = 3/4 the radius is 6 mm, and p = 6 mm * 3/4 fulfils F = 0.
    Under the axis t is :math:`k / \sqrt{1 + k^2}`.

    >>> [round(tube_sine(0.5625, p, 3e-3, 4e-3, 1.0), 9) for p in (4.5e-3, 0.0)]
    [0.75, 0.6]

    References
    ----------
    Derived here: :math:`p^2 = r^2 (1 - k^2 / f'^2)` with :math:`f' = t / \sqrt{1 - t^2}`.
    """
    t = 1.0
    if p < flat:
        t = min(1.0, math.sqrt(k2 / (1.0 + k2 - (p / flat) ** 2)))
    for _ in range(_STEPS):
        r = flat + tube * t
        value = (1.0 + k2) * t * t * r * r - p * p * t * t - k2 * r * r
        slope = 2.0 * (1.0 + k2) * t * r * (r + tube * t) - 2.0 * p * p * t - 2.0 * k2 * r * tube
        if slope <= 0.0:
            break
        step = value / slope
        t -= step
        if step <= 1e-13:
            break
    return min(max(t, 0.0), most)


@inlined_stepping
def touching(kind: float, inner: float, outer: float, shape: float, k: float, p: float) -> float:
    r"""Radius r* at which a piece of a tool touches what it leaves on a slope k, at p beside the line [m].

    .. math:: p^2 = r_*^2 \left(1 - k^2 / f'(r_*)^2\right)

    so that a cone of slope m touches at :math:`p / \sqrt{1 - k^2 / m^2}`, a ball at :math:`r_*^2 = (p^2 + k^2 R^2) / (1 + k^2)`,
    a torus as :func:`tube_sine` says, and a flat at its rim.

    Parameters
    ----------
    kind : float
        ``DISC``, ``CONE`` or ``TUBE``.
    inner, outer : float
        Radii between which the piece stands [m]; a tube with an inner radius of 0 is a ball.
    shape : float
        Slope :math:`m` of a cone [-], or radius of a tube or ball [m].
    k : float
        Slope of the line [-], not 0.
    p : float
        Distance beside the line [m], 0 to the outer radius.

    Returns
    -------
    float
        The radius :math:`r_*` [m], no larger than the outer one.

    Notes
    -----
    Valid for convex pieces. On a line steeper than a cone, and beyond the end of a ball, the tool touches at the outer radius.

    Examples
    --------
    On a slope of 3/4 a cone of slope 5/4 touches at p / 0.8, and a ball of 5 mm under its axis at k R / 1.25.

    >>> from cutwise.maths.profiles import TUBE
    >>> cases = ((CONE, 1e-3, 1e-2, 1.25, 4e-3), (TUBE, 0.0, 5e-3, 5e-3, 0.0))
    >>> [round(1e3 * touching(kind, inner, outer, shape, 0.75, p), 9) for kind, inner, outer, shape, p in cases]
    [5.0, 3.0]

    References
    ----------
    Derived here: the height :math:`k s + f(\sqrt{(q - s)^2 + p^2})` is stationary in s.
    """
    if kind == DISC:
        return outer
    if kind == CONE:
        ratio = abs(k) / shape
        if ratio >= 1.0:
            return outer
        return min(max(p / math.sqrt(1.0 - ratio * ratio), inner), outer)
    if inner == 0.0:  # a ball
        r = math.sqrt((p * p + k * k * shape * shape) / (1.0 + k * k))
        return min(r, outer)
    return inner + shape * tube_sine(k * k, p, inner, shape, (outer - inner) / shape)


@inlined_stepping
def _ball_height(row: FloatArray, radius: float, foot: float, q: float, p: float, way: float) -> float:
    """Height that a whole ball leaves along a line: it touches within its reach, so that the ends of the line alone bound it."""
    h2, k = radius * radius - p * p, row[8]
    if h2 < 0.0:
        return math.inf
    s = q
    if k != 0.0:
        s = q - k * math.sqrt(h2 / (1.0 + k * k))
    s = min(max(s, 0.0), way)
    f2 = h2 - (q - s) * (q - s)
    if f2 < 0.0:
        return math.inf
    return row[4] + k * s + foot + radius - math.sqrt(f2)


@inlined_stepping
def _line_height(row: FloatArray, piece: FloatArray, q: float, p: float, way: float) -> float:
    """Height that a piece leaves along a line as far as a way [m] along it; infinite where it does not reach."""
    kind, outer = piece[0], piece[2]
    if kind == TUBE and piece[1] == 0.0 and outer == piece[4]:
        return _ball_height(row, outer, piece[3], q, p, way)
    h2 = outer * outer - p * p
    if h2 < 0.0:
        return math.inf
    h, k = math.sqrt(h2), row[8]
    low, high = max(0.0, q - h), min(way, q + h)
    if low > high:
        return math.inf
    if kind == DISC:
        return row[4] + (k * low if k > 0.0 else k * high) + piece[3]
    s = q
    if k != 0.0:
        r = touching(kind, piece[1], outer, piece[4], k, p)
        s = q - math.copysign(math.sqrt(max(r * r - p * p, 0.0)), k)
    s = min(max(s, low), high)
    d = math.sqrt((q - s) ** 2 + p * p)
    return row[4] + k * s + piece_height(kind, piece[1], piece[3], piece[4], d)


@inlined_stepping
def _arc_distance(row: FloatArray, x: float, y: float) -> float:
    """Distance of a point from a level arc [m]."""
    dx, dy = x - row[2], y - row[3]
    away = math.sqrt(dx * dx + dy * dy)
    if dx * row[5] + dy * row[6] >= away * row[8]:
        return abs(away - row[7])
    a = math.sqrt((x - row[9]) ** 2 + (y - row[10]) ** 2)
    b = math.sqrt((x - row[11]) ** 2 + (y - row[12]) ** 2)
    return min(a, b)


@inlined_stepping
def segment_height(path: Segments, tools: Cutters, segment: int, x: float, y: float) -> float:
    r"""Height that a segment leaves at a point [m]; infinite where the tool does not come.

    .. math:: z = \min_s A_z + k s + f(|P - A - s u|), \qquad z = A_z + f(d) \text{ of a level arc at the distance } d

    Parameters
    ----------
    path, tools : Segments, Cutters
        The path of the tips, and the profiles f of the tools.
    segment : int
        Which line or arc of it.
    x, y : float
        The point P [m].

    Returns
    -------
    float
        Height [m].

    Notes
    -----
    Valid for profiles that never fall outward, pieces each convex; arcs are level. Exact to rounding.

    Examples
    --------
    A ball of 5 mm up a slope of 3/4: under its axis at q = 10 mm it leaves :math:`k q + R - R \sqrt{1 + k^2}`, 7.5 - 1.25 mm.

    >>> from cutwise.maths.profiles import ball, cutters
    >>> path = segments([line_row(0, np.zeros(3), np.array([20e-3, 0.0, 15e-3]))], [1])
    >>> round(1e3 * segment_height(path, cutters([ball(5e-3)]), 0, 10e-3, 0.0), 9)
    6.25

    References
    ----------
    Derived here.
    """
    row = path.row[segment]
    tool = int(row[1])
    least = math.inf
    if row[0] == LINE:
        dx, dy = x - row[2], y - row[3]
        q, p = dx * row[5] + dy * row[6], abs(dy * row[5] - dx * row[6])
        if p > tools.radius[tool]:
            return least
        for i in range(tools.first[tool], tools.first[tool + 1]):
            least = min(least, _line_height(row, tools.piece[i], q, p, row[7]))
        return least
    d = _arc_distance(row, x, y)
    for i in range(tools.first[tool], tools.first[tool + 1]):
        piece = tools.piece[i]
        if d <= piece[2]:
            least = min(least, row[4] + piece_height(piece[0], piece[1], piece[3], piece[4], d))
    return least


@stepping
def begun_height(path: Segments, tools: Cutters, segment: int, share: float, x: float, y: float) -> float:
    """As :func:`segment_height`, of a segment that has been run as far as a share of it.

    Parameters
    ----------
    path, tools, segment
        As there.
    share : float
        Part of its length that has been run, 0 to 1 [-].
    x, y : float
        The point [m].

    Returns
    -------
    float
        Height [m]; infinite where the tool has not come yet.

    Notes
    -----
    Valid as :func:`segment_height`.

    Examples
    --------
    A flat mill of 1 mm half way along 10 mm has its front at 6 mm.

    >>> from cutwise.maths.profiles import cutters, flat
    >>> path = segments([line_row(0, np.array([0.0, 0.0, -2e-3]), np.array([10e-3, 0.0, -2e-3]))], [1])
    >>> [begun_height(path, cutters([flat(1e-3)]), 0, 0.5, x, 0.0) for x in (5.9e-3, 6.1e-3)]
    [-0.002, inf]

    References
    ----------
    Derived here.
    """
    row = path.row[segment]
    tool = int(row[1])
    least = math.inf
    if row[0] == LINE:
        dx, dy = x - row[2], y - row[3]
        q, p = dx * row[5] + dy * row[6], abs(dy * row[5] - dx * row[6])
        for i in range(tools.first[tool], tools.first[tool + 1]):
            least = min(least, _line_height(row, tools.piece[i], q, p, share * row[7]))
        return least
    turned = share * row[14]
    middle, half = row[13] + 0.5 * turned, 0.5 * abs(turned)
    dx, dy = x - row[2], y - row[3]
    away = math.sqrt(dx * dx + dy * dy)
    if half >= math.pi or dx * math.cos(middle) + dy * math.sin(middle) >= away * math.cos(half):
        d = abs(away - row[7])
    else:
        end = row[13] + turned
        d = min(
            math.hypot(x - row[9], y - row[10]),
            math.hypot(dx - row[7] * math.cos(end), dy - row[7] * math.sin(end)),
        )
    for i in range(tools.first[tool], tools.first[tool + 1]):
        piece = tools.piece[i]
        if d <= piece[2]:
            least = min(least, row[4] + piece_height(piece[0], piece[1], piece[3], piece[4], d))
    return least


@inlined_stepping
def move_height(path: Segments, tools: Cutters, move: int, x: float, y: float) -> float:
    r"""Height that all segments of a move leave at a point [m].

    Parameters
    ----------
    path, tools : Segments, Cutters
        The path of the tips, and the profiles of the tools.
    move : int
        Which move.
    x, y : float
        The point [m].

    Returns
    -------
    float
        Least of :func:`segment_height` [m]; infinite where the tool does not come.

    Notes
    -----
    Valid as :func:`segment_height`. The time it takes grows with the segments of the move.

    Examples
    --------
    A flat mill of 1 mm along x at -1 mm, then along y down a slope of 1/10: at (10, 5) mm it is lowest as it leaves, at y = 6 mm.

    >>> from cutwise.maths.profiles import cutters, flat
    >>> a, b, c = np.array([[0.0, 0.0, -1e-3], [10e-3, 0.0, -1e-3], [10e-3, 10e-3, -2e-3]])
    >>> path = segments([line_row(0, a, b), line_row(0, b, c)], [2])
    >>> [round(1e3 * move_height(path, cutters([flat(1e-3)]), 0, x, y), 9) for x, y in ((5e-3, 0.0), (10e-3, 5e-3))]
    [-1.0, -1.6]

    References
    ----------
    Derived here.
    """
    least = math.inf
    for segment in range(path.first[move], path.first[move + 1]):
        least = min(least, segment_height(path, tools, segment, x, y))
    return least


@compiled
def heights_left(path: Segments, tools: Cutters, x: FloatArray, y: FloatArray) -> FloatArray:
    r"""Least height that any move leaves at points [m], shape (n,): the plain rule that maps are held against.

    Parameters
    ----------
    path, tools : Segments, Cutters
        The path of the tips, and the profiles of the tools.
    x, y : array (n,)
        The points [m].

    Returns
    -------
    array (n,)
        Least of :func:`segment_height` over all segments [m]; infinite where no tool comes.

    Notes
    -----
    Valid as :func:`segment_height`; the stock and its outline are not looked at.

    Examples
    --------
    A ball of 5 mm stands :math:`R - \sqrt{R^2 - p^2}` = 1 mm high at p = 3 mm. It runs along x at -1 mm and along y at -0.5 mm.

    >>> from cutwise.maths.profiles import ball, cutters
    >>> ends = np.array([[-20.0, 0.0, -1.0], [20.0, 0.0, -1.0], [0.0, -20.0, -0.5], [0.0, 20.0, -0.5]]) * 1e-3
    >>> path = segments([line_row(0, ends[0], ends[1]), line_row(0, ends[2], ends[3])], [1, 1])
    >>> x, y = np.array([8e-3, 0.0, 8e-3]), np.array([3e-3, 3e-3, 6e-3])
    >>> (1e3 * heights_left(path, cutters([ball(5e-3)]), x, y)).round(9).tolist()
    [0.0, -0.5, inf]

    References
    ----------
    Derived here.
    """
    out = np.full(x.shape[0], math.inf)
    for i in range(x.shape[0]):
        for segment in range(path.row.shape[0]):
            out[i] = min(out[i], segment_height(path, tools, segment, x[i], y[i]))
    return out
