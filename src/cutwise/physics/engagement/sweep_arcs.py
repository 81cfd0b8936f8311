"""Which arcs of a mill's rim one earlier move of the same mill has swept, and down to which height.

A move has swept the points that were within the radius of its centre path: the body beside it, and the discs at its ends. The
arcs are found from the crossings of the rim with the borders of these, so that they are exact for lines, arcs and helices.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.engagement.rim import lowered

FloatArray = npt.NDArray[np.float64]

_TURN = 2.0 * math.pi
_HERE = 1e-11  # [m] off the mill's own centre: a disc that is the mill's own
_NOTHING = 1e-13  # [rad] shorter arcs are rounding
_TOUCH = 1e-9  # of a turn by which a disc must reach beyond a point to have swept it
_ASIDE = 0.4837  # of an arc: where it is asked about; not its middle, where the rim often touches a border
_SLOPE = 0.02  # of the mill radius: height steps of what a ramp leaves
_EVEN = 1e-3  # of the mill radius: a drop that is no step
_WIDEST = math.pi / 8  # [rad] of an arc behind a ramp
_FINEST = 64  # steps of one arc behind a ramp, which takes a drop of more than the mill's radius


class Piece(NamedTuple):
    """One move as far as it has been run, seen from the centre of the mill; a line, arc or helix."""

    x: float  # start [m]
    y: float
    tx: float  # unit tangent there
    ty: float
    turn: float  # curvature, positive to the left, 0 on a line [1/m]
    length: float  # in the plane [m]; 0: the place of a move along z
    height: float  # of the tip at the start [m]
    slope: float  # rise per length in the plane [-]
    radius: float  # of the mill [m]
    running: bool  # whether the mill is on it: the disc at its end is the mill's own


class View(NamedTuple):
    """How a mill looks at what is left."""

    wall: float  # direction of the wall side, 90° to the right of the feed [rad]
    floor: float  # height at which nothing is left to meet [m]
    closed: bool  # whether a disc at the very place of the mill counts too


@compiled
def swept_off(piece: Piece, view: View, cuts: FloatArray, rim: FloatArray, count: int) -> tuple[FloatArray, int, bool]:
    """Lower what is left of a rim by what a piece has swept.

    Parameters
    ----------
    piece : Piece
        A move as far as it has been run, seen from the centre of the mill.
    view : View
        Wall side, floor, and whether the mill's own place counts.
    cuts : array (16,)
        Room for angles.
    rim, count
        Arcs of the leading half with heights, as for :func:`~cutwise.physics.engagement.rim.lowered`.

    Returns
    -------
    tuple
        As of :func:`~cutwise.physics.engagement.rim.lowered`: the list, its length, whether it has changed.

    Notes
    -----
    Exact for lines, arcs and helices of the mill's own radius, but for what a ramp leaves: its height goes in steps.

    Examples
    --------
    A pass 5 mm to the left of a mill of 10 mm leaves it arccos(1 - 5/10) from the wall side, of half a turn:

    >>> piece, view = Piece(-0.05, 0.005, 1.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.01, False), View(-0.5 * math.pi, 0.0, False)
    >>> rim, count, changed = swept_off(piece, view, np.zeros(16), np.array([[0.0, math.pi, 0.003]]), 1)
    >>> np.degrees(rim[:count, :2]).round(6).tolist(), changed
    ([[0.0, 60.0]], True)

    References
    ----------
    Derived here.
    """
    ex, ey = _end(piece)
    changed = False
    if piece.length > 0.0:
        n = _beside_line(piece, cuts) if piece.turn == 0.0 else _beside_arc(piece, ex, ey, cuts)
        for a in range(0, n, 2):
            rim, count, new = _taken(piece, view, cuts[a], cuts[a + 1], rim, count)
            changed = changed or new
    for k in range(2 if piece.length > 0.0 and not piece.running else 1):  # the discs at its ends
        dx, dy = (piece.x, piece.y) if k == 0 else (ex, ey)
        d = math.hypot(dx, dy)
        begin, end = 0.0, 0.0
        if _HERE < d < 2.0 * piece.radius:
            half, middle = math.acos(d / (2.0 * piece.radius)), math.atan2(dy, dx)
            begin, end = middle - half, middle + half
        elif view.closed and d <= _HERE:
            end = _TURN
        rim, count, new = _taken(piece, view, begin, end, rim, count)
        changed = changed or new
    return rim, count, changed


@compiled
def _end(piece: Piece) -> tuple[float, float]:
    """Centre at the end of a piece [m]."""
    a, b = piece.length, 0.0
    if piece.turn != 0.0:
        half = math.sin(0.5 * a * piece.turn)
        a, b = math.sin(a * piece.turn) / piece.turn, 2.0 * half * half / piece.turn
    return piece.x + a * piece.tx - b * piece.ty, piece.y + a * piece.ty + b * piece.tx


@compiled
def _beside_line(piece: Piece, cuts: FloatArray) -> int:
    """Arcs of the rim within the body of a line, as pairs of angles; their number, twice.

    Outside are what is beyond the line's two long sides, which only one can be, behind its start, and ahead of its end.
    """
    radius, tx, ty = piece.radius, piece.tx, piece.ty
    u, v = -(piece.x * tx + piece.y * ty), piece.x * ty - piece.y * tx  # of the mill's centre, along and to the left
    rest = piece.length - u
    if abs(v) >= 2.0 * radius or u <= -radius or rest <= -radius:
        return 0
    psi = math.atan2(ty, tx)
    out = cuts[8:]  # start and width of what is outside
    width = math.acos(1.0 - abs(v) / radius)
    out[0], out[1] = (psi + math.copysign(0.5 * math.pi, v) - width) % _TURN, 2.0 * width
    n = 1
    if u < radius:
        width = math.acos(u / radius)
        out[2 * n], out[2 * n + 1] = (psi + math.pi - width) % _TURN, 2.0 * width
        n += 1
    if rest < radius:
        width = math.acos(rest / radius)
        out[2 * n], out[2 * n + 1] = (psi - width) % _TURN, 2.0 * width
        n += 1
    for a in range(1, n):
        for b in range(a, 0, -1):
            if out[2 * b] < out[2 * b - 2]:
                out[2 * b], out[2 * b - 2] = out[2 * b - 2], out[2 * b]
                out[2 * b + 1], out[2 * b - 1] = out[2 * b - 1], out[2 * b + 1]
    reached = out[0] + out[1]
    for a in range(n):
        reached = max(reached, out[2 * a] + out[2 * a + 1] - _TURN)
    found = 0
    for a in range(1, n + 1):
        begin = out[2 * a] if a < n else out[0] + _TURN
        if begin > reached:
            cuts[found], cuts[found + 1] = reached, begin
            found += 2
        if a < n:
            reached = max(reached, begin + out[2 * a + 1])
    return found


@compiled
def _beside_arc(piece: Piece, ex: float, ey: float, cuts: FloatArray) -> int:
    """Arcs of the rim within the body of an arc or helix, as pairs of angles; their number, twice."""
    radius, rho, side = piece.radius, 1.0 / abs(piece.turn), math.copysign(1.0, piece.turn)
    cx, cy = piece.x - side * rho * piece.ty, piece.y + side * rho * piece.tx
    at = cuts[8:]
    n = _cross_circle(at, 0, cx, cy, radius, rho + radius)
    if rho > radius:
        n = _cross_circle(at, n, cx, cy, radius, rho - radius)
    if piece.length < _TURN * rho:
        for k in range(2):  # the spokes at both ends
            ox, oy = (piece.x - cx, piece.y - cy) if k == 0 else (ex - cx, ey - cy)
            n = _cross_line(at, n, -oy / rho, ox / rho, (-oy * cx + ox * cy) / rho, radius)
    if n == 0:
        asked = math.atan2(cy, cx) + _ASIDE * math.pi
        if not _is_swept(piece, radius * math.cos(asked), radius * math.sin(asked)):
            return 0
        cuts[0], cuts[1] = 0.0, _TURN
        return 2
    for a in range(1, n):  # few of them: by insertion
        value, b = at[a], a - 1
        while b >= 0 and at[b] > value:
            at[b + 1] = at[b]
            b -= 1
        at[b + 1] = value
    found, first, last = 0, at[0], at[n - 1]
    for a in range(n):  # what is found stands before what is still to be looked at, or in its place
        begin, end = last if a == 0 else at[a - 1], first + _TURN if a == 0 else at[a]
        asked = begin + _ASIDE * (end - begin)
        if end - begin > _NOTHING and _is_swept(piece, radius * math.cos(asked), radius * math.sin(asked)):
            cuts[found], cuts[found + 1] = begin, end
            found += 2
    return found


@compiled
def _is_swept(piece: Piece, x: float, y: float) -> bool:
    """Whether the body of an arc has swept a point [m]."""
    rho, side = 1.0 / abs(piece.turn), math.copysign(1.0, piece.turn)
    cx, cy = -side * rho * piece.ty, side * rho * piece.tx
    qx, qy = x - piece.x - cx, y - piece.y - cy
    if abs(math.hypot(qx, qy) - rho) >= piece.radius:
        return False
    return piece.length >= _TURN * rho or _spoke(cx, cy, qx, qy, side) < piece.length / rho


@compiled
def _spoke(cx: float, cy: float, qx: float, qy: float, side: float) -> float:
    """Angle from the spoke of an arc's start to that of a point, the way the arc turns [rad], 0 to a turn."""
    return (side * math.atan2(cy * qx - cx * qy, -cx * qx - cy * qy)) % _TURN


@compiled
def _cross_circle(cuts: FloatArray, n: int, dx: float, dy: float, radius: float, other: float) -> int:
    """Angles at which the rim meets a circle of radius ``other`` about a point at (dx, dy) from the mill's centre."""
    d = math.hypot(dx, dy)
    if d > 1e-15 and abs(radius - other) < d < radius + other:
        half = math.acos(min(1.0, max(-1.0, (d * d + radius * radius - other * other) / (2.0 * d * radius))))
        middle = math.atan2(dy, dx)
        cuts[n], cuts[n + 1] = (middle - half) % _TURN, (middle + half) % _TURN
        n += 2
    return n


@compiled
def _cross_line(cuts: FloatArray, n: int, nx: float, ny: float, offset: float, radius: float) -> int:
    """Angles at which the rim meets the line :math:`n \\cdot q = offset`, q from the mill's centre, n a unit vector."""
    if abs(offset) < radius:
        half = math.acos(offset / radius)
        middle = math.atan2(ny, nx)
        cuts[n], cuts[n + 1] = (middle - half) % _TURN, (middle + half) % _TURN
        n += 2
    return n


@compiled
def _taken(
    piece: Piece, view: View, begin: float, end: float, rim: FloatArray, count: int
) -> tuple[FloatArray, int, bool]:
    """Lower the leading half between two directions [rad] to what a piece has left there."""
    if end - begin <= _NOTHING:
        return rim, count, False
    if end - begin >= _TURN:
        begin, end = view.wall, view.wall + _TURN
    low = (begin - view.wall) % _TURN
    high = low + (end - begin)
    changed = False
    for k in range(2):  # the arc, and what of it comes round again
        a, b = max(low - k * _TURN, 0.0), min(high - k * _TURN, math.pi)
        if b - a <= _NOTHING:
            continue
        if piece.slope == 0.0:
            rim, count, new = lowered(rim, count, a, b, piece.height, view.floor)
            changed = changed or new
            continue
        steps, last = 1, _left_at(piece, view.wall + a)
        if abs(piece.slope) * piece.length > _EVEN * piece.radius:
            middle, there = _left_at(piece, view.wall + 0.5 * (a + b)), _left_at(piece, view.wall + b)
            drop = max(abs(last - middle), abs(there - middle), abs(there - last))
            if drop > _EVEN * piece.radius:
                steps = max(math.ceil((b - a) / _WIDEST), min(math.ceil(drop / (_SLOPE * piece.radius)), _FINEST))
        for i in range(steps):
            p, q = a + (b - a) * i / steps, a + (b - a) * (i + 1) / steps
            amid, there = _left_at(piece, view.wall + 0.5 * (p + q)), _left_at(piece, view.wall + q)
            u, v, w = math.sin(p), 4.0 * math.sin(0.5 * (p + q)), math.sin(q)  # what a feed takes, by Simpson's rule
            mean = (u * last + v * amid + w * there) / (u + v + w)
            rim, count, new = lowered(rim, count, p, q, mean, view.floor)
            last, changed = there, changed or new
    return rim, count, changed


@compiled
def _left_at(piece: Piece, direction: float) -> float:
    """Height that a rising or falling piece has left at a point of the rim that it swept: of its lowest disc there [m]."""
    radius, tx, ty = piece.radius, piece.tx, piece.ty
    dx, dy = radius * math.cos(direction) - piece.x, radius * math.sin(direction) - piece.y
    falls = piece.slope < 0.0
    if piece.turn == 0.0:
        u, v = dx * tx + dy * ty, dy * tx - dx * ty
        half = math.sqrt(max(radius * radius - v * v, 0.0))
        s = u + half if falls else u - half
    else:
        rho, side = 1.0 / abs(piece.turn), math.copysign(1.0, piece.turn)
        cx, cy = -side * rho * ty, side * rho * tx
        qx, qy = dx - cx, dy - cy
        d = math.hypot(qx, qy)
        cosine = (rho * rho + d * d - radius * radius) / (2.0 * rho * d) if d > 0.0 else -1.0
        half, spoke = math.acos(max(min(cosine, 1.0), -1.0)), _spoke(cx, cy, qx, qy, side)
        if half >= math.pi:
            s = piece.length if falls else 0.0
        elif falls:  # when it was last within reach; the disc at its end, where the mill may stand, only touches
            turns = math.floor((piece.length / rho - spoke + half) / _TURN - _TOUCH)
            s = rho * (spoke + half + _TURN * turns)
        else:  # when first
            s = rho * (spoke - half + _TURN * math.ceil((-spoke - half) / _TURN + _TOUCH))
    return piece.height + piece.slope * min(max(s, 0.0), piece.length)
