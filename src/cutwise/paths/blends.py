"""Corners between any blocks rounded within a tolerance: lines, arcs and helices, whatever plane they lie in."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.maths.linearc import LineArc, block_bend, block_point, block_tangent, block_turn, clothoid_point

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_CORNER = 1e-4  # [rad] joints that turn less are smooth
_BACK = 1e-3  # [rad] short of a reversal: the motion stops, there is nothing to round
_KEPT = 1e-9  # [m] what is left of a block counts if it is longer
_BENT = 0.5  # [rad] that an arc may turn within a blend
_LOOKS = 12  # places of half a blend at which its distance from the blocks is looked at
_CLOSE = 1e-4  # of the tolerance: how nearly a blend between curved blocks uses it
_SHARE = 0.25  # of the shorter block: what a corner is rounded by at most where no tolerance is given

ARC, CLOTHOID = 0, 1
SHAPES = {"arc": ARC, "clothoid": CLOTHOID}


class Blended(NamedTuple):
    """A path with its corners rounded."""

    curve: LineArc
    origin: IntArray  # for each block the number of the block that it came from
    cut_short: int  # roundings that are smaller than their tolerance allows, because the blocks are short
    rounded: npt.NDArray[np.bool_]  # which of the inner joints are


@compiled
def feed_tolerance(turn: float, length: float, speed: float, acceleration: float, jerk: float) -> float:
    r"""By how much a corner is rounded so that it is run at a speed [m]: G64 without P.

    .. math:: \epsilon = r (1/\cos(\theta/2) - 1), \qquad r = \max(v^2/a, \sqrt{v^3/j})

    the smallest arc that acceleration and jerk allow at the speed, but no more than a quarter of the shorter block,
    a choice. Derived here.

    Parameters
    ----------
    turn : float
        Angle of the corner [rad], 0 to below pi.
    length : float
        Of the shorter block [m].
    speed, acceleration, jerk : float
        The lower feed of both blocks, and the limits [m/s], [m/s^2], [m/s^3].

    Examples
    --------
    100 mm/s round a right angle at 1 m/s²: an arc of 10 mm, which leaves the corner by 4.14 mm.

    >>> round(1e3 * feed_tolerance(0.5 * math.pi, 1.0, 0.1, 1.0, 1000.0), 6)
    4.142136
    """
    radius = max(speed * speed / acceleration, math.sqrt(speed * speed * speed / jerk))
    return min(radius * (1.0 / max(math.cos(0.5 * turn), 1e-9) - 1.0), _SHARE * length)


@compiled
def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


@compiled
def _dot(a: FloatArray, b: FloatArray) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def _size(a: FloatArray) -> float:
    return math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])


@compiled
def _angle(a: FloatArray, b: FloatArray) -> float:
    """Angle between two directions [rad]."""
    return math.atan2(_size(_cross(a, b)), _dot(a, b))


@compiled
def _point(curve: LineArc, i: int, s: float) -> FloatArray:
    return np.array(block_point(curve, i, s))


@compiled
def _tangent(curve: LineArc, i: int, s: float) -> FloatArray:
    return np.array(block_tangent(curve, i, s))


@compiled
def _straight(curve: LineArc, i: int) -> bool:
    return math.isinf(curve.radius[i]) and curve.sharpness[i] == 0.0


@compiled
def _put_arc(out: LineArc, n: int, start: FloatArray, tangent: FloatArray, end: FloatArray) -> None:
    """Block ``n`` becomes the arc from a point with a tangent to another point, or the line if that is straight on."""
    chord = end - start
    ahead = _dot(chord, tangent)
    side = chord - ahead * tangent
    off = _size(side)
    out.start[n], out.along[n], out.share[n] = start, tangent, 1.0  # climb and sharpness are zero as they are
    if off <= 1e-12 * abs(ahead):
        out.inward[n], out.radius[n], out.length[n] = 0.0, math.inf, _size(chord)
        return
    out.inward[n] = side / off
    out.radius[n] = _dot(chord, chord) / (2.0 * off)
    out.length[n] = out.radius[n] * 2.0 * math.atan2(off, ahead)


@compiled
def _middle(a: FloatArray, ta: FloatArray, b: FloatArray, tb: FloatArray) -> FloatArray:
    r"""Where the two arcs of a blend meet: as far along either tangent,

    .. math:: |b - a - d (t_a + t_b)| = 2 d, \qquad m = \tfrac12 (a + b + d\,(t_a - t_b)) .
    """
    v, t = b - a, ta + tb
    c, q = _dot(v, v), 1.0 - _dot(ta, tb)
    p = _dot(v, t)
    d = c / (p + math.sqrt(p * p + 2.0 * q * c))
    return 0.5 * (a + b + d * (ta - tb))


@compiled
def _put_arcs(out: LineArc, n: int, a: FloatArray, ta: FloatArray, b: FloatArray, tb: FloatArray) -> None:
    """Two arcs from one point and tangent to another, each in its plane."""
    m = _middle(a, ta, b, tb)
    _put_arc(out, n, a, ta, m)
    _put_arc(out, n + 1, m, _tangent(out, n, out.length[n]), b)


@compiled
def _to_arc(curve: LineArc, i: int, point: FloatArray) -> float:
    """Least distance of a point from a plane arc of less than half a turn, or a line [m]."""
    length = curve.length[i]
    out = point - curve.start[i]
    if math.isinf(curve.radius[i]):
        s = min(max(_dot(out, curve.along[i]), 0.0), length)
    else:
        r = curve.radius[i]
        phi = math.atan2(_dot(out, curve.along[i]), r - _dot(out, curve.inward[i]))
        s = min(max(phi * r, 0.0), length)
    return min(_size(point - _point(curve, i, s)), _size(point - _point(curve, i, length)), _size(out))


@compiled
def _off_block(curve: LineArc, i: int, point: FloatArray, low: float, high: float, guess: float) -> float:
    """Distance of a point from a part of a block [m], from the foot nearest to a guess."""
    s = guess
    for _ in range(8):
        off = point - _point(curve, i, s)
        slope = 1.0 - _dot(off, np.array(block_bend(curve, i, s)))
        step = _dot(off, _tangent(curve, i, s)) / max(slope, 0.2)
        s = min(max(s + step, low), high)
        if abs(step) < 1e-12:
            break
    return _size(point - _point(curve, i, s))


@compiled
def _deviation(curve: LineArc, i: int, reach: float, work: LineArc) -> float:
    """Largest distance between a blend of two arcs and the path that it stands for: from the corner, and from the blocks."""
    size = curve.length[i]
    a, ta = _point(curve, i, size - reach), _tangent(curve, i, size - reach)
    b, tb = _point(curve, i + 1, reach), _tangent(curve, i + 1, reach)
    _put_arcs(work, 0, a, ta, b, tb)
    corner = _point(curve, i + 1, 0.0)
    worst = min(_to_arc(work, 0, corner), _to_arc(work, 1, corner))
    for half in range(2):
        for k in range(1, _LOOKS + 1):
            share = k / _LOOKS
            point = _point(work, half, share * work.length[half])
            way = 0.5 * (share + half)  # of the blend, and of what it stands for
            before = _off_block(curve, i, point, size - reach, size, size - reach * max(1.0 - 2.0 * way, 0.0))
            after = _off_block(curve, i + 1, point, 0.0, reach, reach * max(2.0 * way - 1.0, 0.0))
            worst = max(worst, min(before, after))
    return worst


@compiled
def _room(curve: LineArc, i: int) -> float:
    """What a blend may take of a block [m]: half of it, and no more of an arc than a small turn."""
    half = 0.5 * curve.length[i]
    if _straight(curve, i):
        return half
    return min(half, _BENT * curve.radius[i] / max(curve.share[i], 1e-9))


@compiled
def _curved_reach(curve: LineArc, i: int, turn: float, allowed: float, work: LineArc) -> tuple[float, bool]:
    """What a blend takes of either block, one of which is curved [m], and whether there was no room for more."""
    room = min(_room(curve, i), _room(curve, i + 1))
    reach = min(allowed / math.tan(0.25 * turn), room)
    off = _deviation(curve, i, reach, work)
    low, high = 0.0, math.inf
    for _ in range(60):
        if off <= allowed:
            low = reach
            if reach >= room or off >= (1.0 - _CLOSE) * allowed:
                break
        else:
            high = reach
        guess = reach * allowed * (1.0 - 0.3 * _CLOSE) / max(off, 1e-300)
        reach = min(guess, room)
        if not low < reach < high:
            reach = 0.5 * (low + high) if high < math.inf else room
        off = _deviation(curve, i, reach, work)
    return low, low >= room


@compiled
def _clothoid_share(turn: float) -> tuple[float, float, float]:
    r"""A pair of clothoids of unit length: :math:`x, y`, and what it takes of either line."""
    x, y = clothoid_point(0.0, turn, 1.0)
    return x, y, x + y * math.tan(0.5 * turn)


@compiled
def _put_clothoids(out: LineArc, n: int, corner: FloatArray, d0: FloatArray, d1: FloatArray, reach: float) -> None:
    r"""Two equal clothoids, the curvature rising evenly to the middle and falling again, so that it nowhere jumps.

    With :math:`(x, y) = \int_0^1 (\cos, \sin)(\theta u^2/2)\,du` a pair of length L each leaves the corner by
    :math:`\epsilon = L\,y / \cos(\theta/2)` and takes :math:`L\,(x + y \tan(\theta/2))` of either line.
    """
    turn, axis = _angle(d0, d1), _cross(d0, d1)
    axis = axis / _size(axis)
    x, y, taken = _clothoid_share(turn)
    length = reach / taken
    peak, inward, begin = turn / length, _cross(axis, d0), corner - reach * d0
    c, s = math.cos(0.5 * turn), math.sin(0.5 * turn)
    out.start[n], out.along[n], out.inward[n] = begin, d0, inward
    out.start[n + 1] = begin + length * (x * d0 + y * inward)
    out.along[n + 1], out.inward[n + 1] = c * d0 + s * inward, c * inward - s * d0
    out.radius[n], out.radius[n + 1] = math.inf, 1.0 / peak
    out.sharpness[n], out.sharpness[n + 1] = peak / length, -peak / length
    for k in (n, n + 1):
        out.share[k], out.length[k] = 1.0, length


@compiled
def feed_tolerances(
    curve: LineArc, tolerance: FloatArray, speed: FloatArray, acceleration: float, jerk: float
) -> FloatArray:
    """Tolerances [m] in which infinite ones are replaced by what keeps the feed (:func:`feed_tolerance`).

    ``curve``: n blocks; ``tolerance`` [m] of the joints, shape (n - 1,); ``speed`` of the blocks [m/s], shape (n,);
    ``acceleration`` [m/s^2] and ``jerk`` [m/s^3], limits.

    Examples
    --------
    >>> from cutwise.maths.linearc import join, line
    >>> curve, speed = join([line((0, 0, 0), (1, 0, 0)), line((1, 0, 0), (1, 1, 0))]), np.array([0.2, 0.1])
    >>> (1e3 * feed_tolerances(curve, np.array([math.inf]), speed, 1.0, 1000.0)).round(6).tolist()
    [4.142136]
    """
    out = tolerance.copy()
    for i in range(tolerance.shape[0]):
        if math.isinf(tolerance[i]):
            turn = _angle(_tangent(curve, i, curve.length[i]), _tangent(curve, i + 1, 0.0))
            shorter = min(curve.length[i], curve.length[i + 1])
            out[i] = feed_tolerance(turn, shorter, min(speed[i], speed[i + 1]), acceleration, jerk)
    return out


@compiled
def _reaches(curve: LineArc, tolerance: FloatArray, shape: int, work: LineArc) -> tuple[FloatArray, int]:
    """What each rounding takes of the blocks on either side [m], and how many would take more if the blocks were longer."""
    reach = np.zeros(tolerance.shape[0])
    short = 0
    for i in range(tolerance.shape[0]):
        allowed = tolerance[i]
        if allowed <= 0.0:
            continue
        turn = _angle(_tangent(curve, i, curve.length[i]), _tangent(curve, i + 1, 0.0))
        if not _CORNER <= turn <= math.pi - _BACK:
            continue
        if not (_straight(curve, i) and _straight(curve, i + 1)):
            reach[i], full = _curved_reach(curve, i, turn, allowed, work)
            short += full
            continue
        wanted = allowed / math.tan(0.25 * turn)
        if shape == CLOTHOID:
            _, y, taken = _clothoid_share(turn)
            wanted = allowed * math.cos(0.5 * turn) / y * taken
        reach[i] = min(wanted, 0.5 * min(curve.length[i], curve.length[i + 1]))
        short += reach[i] < wanted * (1.0 - 1e-9)
    return reach, short


@compiled
def _put_part(out: LineArc, n: int, curve: LineArc, i: int, low: float, high: float) -> None:
    """Block ``n`` becomes block ``i`` of a curve without its ends."""
    out.start[n], out.along[n], out.inward[n] = curve.start[i], curve.along[i], curve.inward[i]
    out.share[n], out.radius[n], out.length[n] = curve.share[i], curve.radius[i], high - low
    if curve.share[i] != 1.0:  # zeros are there already, and memory that is not written is not taken
        out.climb[n] = curve.climb[i]
    if curve.sharpness[i] != 0.0:
        out.sharpness[n] = curve.sharpness[i]
    if low > 0.0:
        out.start[n] = _point(curve, i, low)
        phi = block_turn(curve, i, low)
        c, s = math.cos(phi), math.sin(phi)
        for k in range(3):
            out.along[n, k] = c * curve.along[i, k] + s * curve.inward[i, k]
            out.inward[n, k] = c * curve.inward[i, k] - s * curve.along[i, k]
        if curve.sharpness[i] != 0.0:
            out.radius[n] = 1.0 / (1.0 / curve.radius[i] + curve.sharpness[i] * low)


@compiled
def _written(
    curve: LineArc, reach: FloatArray, shape: int, parted: npt.NDArray[np.bool_], out: LineArc, origin: IntArray
) -> int:
    """Put what is left of the blocks, and the roundings between them, into ``out``; returns their number."""
    n, count = 0, curve.length.shape[0]
    for i in range(count):
        low = reach[i - 1] if i > 0 else 0.0
        high = curve.length[i] - (reach[i] if i < count - 1 else 0.0)
        if high - low > _KEPT or (low == 0.0 and high == curve.length[i]):
            _put_part(out, n, curve, i, low, high)
            origin[n] = i
            n += 1
        if i == count - 1 or reach[i] <= 0.0:
            continue
        ta, tb = _tangent(curve, i, high), _tangent(curve, i + 1, reach[i])
        a, b = _point(curve, i, high), _point(curve, i + 1, reach[i])
        lines = _straight(curve, i) and _straight(curve, i + 1)
        origin[n] = i
        if lines and shape == CLOTHOID:
            _put_clothoids(out, n, _point(curve, i + 1, 0.0), ta, tb, reach[i])
        elif lines and not parted[i]:
            _put_arc(out, n, a, ta, b)
            n += 1
            continue
        else:
            _put_arcs(out, n, a, ta, b, tb)
        origin[n + 1] = i + 1
        n += 2
    return n


def _blank(count: int) -> LineArc:
    vectors = (np.zeros((count, 3)) for _ in range(4))
    return LineArc(*vectors, *(np.zeros(count) for _ in range(4)))


def blended(
    curve: LineArc, tolerance: FloatArray, shape: str = "arc", parted: npt.NDArray[np.bool_] | None = None
) -> Blended:
    r"""Corners rounded within a tolerance (G64 P): nowhere is the path farther from the programmed one, nor from its corner.

    Between lines a corner becomes one arc, or two clothoids. Where a block is curved, two arcs take its place, in planes
    of their own, that leave either block along its tangent, as far before the corner as behind it. A rounding takes at most
    half of either block. Where the path turns back there is nothing to round.

    Parameters
    ----------
    curve : LineArc
        The path.
    tolerance : ndarray
        For each inner joint [m]; 0 leaves the corner, shape (n - 1,).
    shape : str
        ``arc``, whose curvature jumps at its ends, or ``clothoid``, a pair of them, whose curvature does not; next to
        curved blocks there are arcs.
    parted : ndarray, optional
        Joints whose rounding belongs one half to either block, because they are run or cut differently, shape (n - 1,).
    """
    allowed = np.asarray(tolerance, dtype=np.float64)
    reach, short = _reaches(curve, allowed, SHAPES[shape], _blank(2))
    rounded = reach > 0.0
    if not rounded.any():
        return Blended(curve, np.arange(curve.count), 0, rounded)
    halves = np.zeros(len(allowed), bool) if parted is None else parted
    lines = curve.straight
    one = lines[:-1] & lines[1:] & ~halves & (shape == "arc")
    out = _blank(curve.count + int(rounded @ np.where(one, 1, 2)))
    origin = np.zeros(out.count, np.int64)
    count = _written(curve, reach, SHAPES[shape], halves, out, origin)
    return Blended(LineArc(*(column[:count] for column in out)), origin[:count], int(short), rounded)
