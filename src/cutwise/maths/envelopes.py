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
from cutwise.maths.profiles import CONE, DISC, Cutters, piece_height

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
    """Radius r* at which a piece of a tool touches what it leaves on a slope k, at p beside the line [m]."""
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
def _line_height(row: FloatArray, piece: FloatArray, q: float, p: float, way: float) -> float:
    """Height that a piece leaves along a line as far as a way [m] along it; infinite where it does not reach."""
    outer = piece[2]
    h2 = outer * outer - p * p
    if h2 < 0.0:
        return math.inf
    h, k = math.sqrt(h2), row[8]
    low, high = max(0.0, q - h), min(way, q + h)
    if low > high:
        return math.inf
    s = q
    if k != 0.0:
        r = touching(piece[0], piece[1], outer, piece[4], k, p)
        s = q - math.copysign(math.sqrt(max(r * r - p * p, 0.0)), k)
    s = min(max(s, low), high)
    d = math.sqrt((q - s) ** 2 + p * p)
    return row[4] + k * s + piece_height(piece[0], piece[1], piece[3], piece[4], d)


@stepping
def _arc_distance(row: FloatArray, x: float, y: float) -> float:
    """Distance of a point from a level arc [m]."""
    dx, dy = x - row[2], y - row[3]
    away = math.sqrt(dx * dx + dy * dy)
    if dx * row[5] + dy * row[6] >= away * row[8]:
        return abs(away - row[7])
    a = math.sqrt((x - row[9]) ** 2 + (y - row[10]) ** 2)
    b = math.sqrt((x - row[11]) ** 2 + (y - row[12]) ** 2)
    return min(a, b)


@stepping
def segment_height(path: Segments, tools: Cutters, segment: int, x: float, y: float) -> float:
    """Height that a segment leaves at a point [m]; infinite where the tool does not come."""
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
    """As :func:`segment_height`, of a segment that has been run as far as a share of it."""
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


@stepping
def move_height(path: Segments, tools: Cutters, move: int, x: float, y: float) -> float:
    """Height that all segments of a move leave at a point [m]."""
    least = math.inf
    for segment in range(path.first[move], path.first[move + 1]):
        least = min(least, segment_height(path, tools, segment, x, y))
    return least


@compiled
def heights_left(path: Segments, tools: Cutters, x: FloatArray, y: FloatArray) -> FloatArray:
    """Least height that any move leaves at points [m], shape (n,): the plain rule that maps are held against."""
    out = np.full(x.shape[0], math.inf)
    for i in range(x.shape[0]):
        for segment in range(path.row.shape[0]):
            out[i] = min(out[i], segment_height(path, tools, segment, x[i], y[i]))
    return out
