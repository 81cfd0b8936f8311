"""Contour error: how far the actual position lies from the commanded path."""

import math

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.maths.linearc import LineArc, block_bend, block_point, block_tangent

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_STEPS = 12  # of Newton's method
_LOOKS = 24  # places of a block in space that are looked at, and halvings between two of them


@compiled
def _from_line(curve: LineArc, i: int, x: float, y: float, open_start: bool, open_end: bool) -> tuple[float, float]:
    """Distance to a line and offset to its right [m], in the xy plane."""
    dx, dy = x - curve.start[i, 0], y - curve.start[i, 1]
    tx, ty = curve.along[i, 0], curve.along[i, 1]
    flat = math.hypot(tx, ty)
    if flat < 1e-12:  # along z: a point in the plane
        return math.hypot(dx, dy), 0.0
    tx, ty = tx / flat, ty / flat
    q, right = dx * tx + dy * ty, dx * ty - dy * tx
    if q < 0.0 and not open_start:
        return math.hypot(q, right), right
    over = q - curve.length[i] * flat
    if over > 0.0 and not open_end:
        return math.hypot(over, right), right
    return abs(right), right


@compiled
def _from_arc(curve: LineArc, i: int, x: float, y: float) -> tuple[float, float]:
    """Distance to an arc in the xy plane and offset to its right [m]; infinite outside its sweep."""
    radius = curve.radius[i]
    cx, cy = curve.start[i, 0] + radius * curve.inward[i, 0], curve.start[i, 1] + radius * curve.inward[i, 1]
    left = curve.along[i, 0] * curve.inward[i, 1] - curve.along[i, 1] * curve.inward[i, 0]  # 1: turns left
    ux, uy = x - cx, y - cy
    sx, sy = -curve.inward[i, 0], -curve.inward[i, 1]
    angle = math.copysign(1.0, left) * math.atan2(sx * uy - sy * ux, sx * ux + sy * uy)
    sweep = curve.length[i] * curve.share[i] / radius
    if sweep < 2.0 * math.pi and angle % (2.0 * math.pi) > sweep:
        return math.inf, 0.0
    off = math.hypot(ux, uy) - radius
    return abs(off), math.copysign(1.0, left) * off


@compiled
def _from_clothoid(curve: LineArc, i: int, x: float, y: float) -> tuple[float, float]:
    """Distance to a clothoid in the xy plane and offset to its right [m]; to its nearer end where it is beyond them."""
    length = curve.length[i]
    px, py, _ = block_point(curve, i, 0.0)
    qx, qy, _ = block_point(curve, i, length)
    s = length * min(max(((x - px) * (qx - px) + (y - py) * (qy - py)) / ((qx - px) ** 2 + (qy - py) ** 2), 0.0), 1.0)
    for _ in range(_STEPS):
        px, py, _ = block_point(curve, i, s)
        tx, ty, _ = block_tangent(curve, i, s)
        bx, by, _ = block_bend(curve, i, s)
        dx, dy = x - px, y - py
        step = (dx * tx + dy * ty) / max(1.0 - dx * bx - dy * by, 0.1)
        s = min(max(s + step, 0.0), length)
        if abs(step) < 1e-12:
            break
    px, py, _ = block_point(curve, i, s)
    tx, ty, _ = block_tangent(curve, i, s)
    dx, dy = x - px, y - py
    return math.hypot(dx, dy), dx * ty - dy * tx


@compiled
def _from_space(curve: LineArc, i: int, x: float, y: float) -> tuple[float, float]:
    """Distance in plan to an arc or clothoid that leaves the plane, and offset to its right [m]."""
    length = curve.length[i]
    nearest, least = 0, math.inf
    for j in range(_LOOKS + 1):
        px, py, _ = block_point(curve, i, length * j / _LOOKS)
        away = (x - px) ** 2 + (y - py) ** 2
        if away < least:
            nearest, least = j, away
    low, high = length * max(nearest - 1, 0) / _LOOKS, length * min(nearest + 1, _LOOKS) / _LOOKS
    for _ in range(2 * _LOOKS):  # where the way there turns back: the distance falls before it and rises behind
        s = 0.5 * (low + high)
        px, py, _ = block_point(curve, i, s)
        tx, ty, _ = block_tangent(curve, i, s)
        if (x - px) * tx + (y - py) * ty > 0.0:
            low = s
        else:
            high = s
    s = 0.5 * (low + high)
    px, py, _ = block_point(curve, i, s)
    tx, ty, _ = block_tangent(curve, i, s)
    dx, dy, flat = x - px, y - py, math.hypot(tx, ty)
    return math.hypot(dx, dy), (dx * ty - dy * tx) / flat if flat > 1e-12 else 0.0


@compiled
def _from_block(curve: LineArc, i: int, x: float, y: float, open_start: bool, open_end: bool) -> tuple[float, float]:
    """Distance to a block and offset to its right [m]; infinite where the nearest point is another block's."""
    if math.isinf(curve.radius[i]) and curve.sharpness[i] == 0.0:
        return _from_line(curve, i, x, y, open_start, open_end)
    if abs(curve.along[i, 0] * curve.inward[i, 1] - curve.along[i, 1] * curve.inward[i, 0]) < 0.999:
        return _from_space(curve, i, x, y)
    return _from_arc(curve, i, x, y) if curve.sharpness[i] == 0.0 else _from_clothoid(curve, i, x, y)


@compiled
def contour_errors(curve: LineArc, block: IntArray, points: FloatArray, prolong: bool) -> FloatArray:
    r"""Signed distance of actual positions from a path in the xy plane, positive to the right of travel.

    .. math:: |\epsilon_k| = \min_s |p_k - c(s)|, \qquad \operatorname{sgn} \epsilon_k = \operatorname{sgn}\,((p_k - c) \times t)_z

    Seen along z. The nearest of the blocks around the commanded one is taken: its
    neighbours, and as many more as can hold a nearer point, which lies within twice the distance from the commanded
    block; the way along the path may be half as long again as that, but not longer. So a lag over many short blocks is no
    error, and a later pass beside this one is not mistaken for it. With ``prolong`` the first and last line go on
    beyond their ends, so that running over the end point does not count. At a corner between lines the error is
    positive if the point is to the right of either (left turn).

    Parameters
    ----------
    curve : LineArc
        The path c(s) [m], with its unit tangent t.
    block : ndarray
        Commanded block at each instant, shape (n,).
    points : ndarray
        Actual positions p [m], shape (n, 2) or (n, 3); z does not count.
    prolong : bool
        Whether the ends go on.

    Returns
    -------
    ndarray
        Error [m], shape (n,).

    Notes
    -----
    Valid for errors that are small beside radii of curvature and beside the distance between passes.

    Examples
    --------
    2 mm to the right of a line along x; 3 mm past its end and 4 mm to the left, it is 5 mm, or 4 mm if the line goes on.

    >>> from cutwise.maths.linearc import lines
    >>> edge = lines(np.zeros((1, 3)), np.array([[0.1, 0.0, 0.0]]))
    >>> at, block = np.array([[0.05, -0.002], [0.103, 0.004]]), np.zeros(2, np.int64)
    >>> [[round(1e3 * e, 9) for e in contour_errors(edge, block, at, on).tolist()] for on in (False, True)]
    [[2.0, -5.0], [2.0, -4.0]]

    References
    ----------
    Derived here; contour error as in Altintas 2012, Manufacturing Automation, ch. 6.
    """
    out = np.empty(points.shape[0])
    last = curve.length.shape[0] - 1
    for k in range(points.shape[0]):
        x, y, own = points[k, 0], points[k, 1], block[k]
        best, side = _from_block(curve, own, x, y, prolong and own == 0, prolong and own == last)
        ex, ey, _ = block_point(curve, own, curve.length[own])
        to_start, to_end = math.hypot(x - curve.start[own, 0], y - curve.start[own, 1]), math.hypot(x - ex, y - ey)
        lag = min(best, to_start, to_end)
        reach = 3.0 * lag
        for ahead in (-1, 1):
            way, i = (to_start if ahead < 0 else to_end) - lag, own + ahead
            while 0 <= i <= last and way <= reach:
                distance, right = _from_block(curve, i, x, y, prolong and i == 0, prolong and i == last)
                if distance < best * (1.0 - 1e-12):
                    best, side = distance, right
                elif distance <= best * (1.0 + 1e-12) and right > 0.0:
                    side = max(side, right)
                way += curve.length[i]
                i += ahead
        out[k] = math.copysign(best, side) if best < math.inf else math.nan
    return out
