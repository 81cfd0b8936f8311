"""Contour error: how far the actual position lies from the commanded path."""

import math

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.maths.linearc import LineArc

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


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
def contour_errors(curve: LineArc, block: IntArray, points: FloatArray, window: int, prolong: bool) -> FloatArray:
    """Signed distance of actual positions from the path in the xy plane, positive to the right of travel.

    Lines and arcs in the plane count; clothoids are no programmed path, only roundings of one. The nearest of the
    blocks around the commanded one is taken, ``window`` on either side. With ``prolong`` the first and last line go on
    beyond their ends, so that running over the end point does not count. At a corner between lines the error is
    positive if the point is to the right of either (left turn).

    Parameters
    ----------
    curve : LineArc
        The commanded path [m].
    block : ndarray
        Commanded block at each instant, shape (n,).
    points : ndarray
        Actual positions [m], shape (n, 2) or (n, 3).
    window : int
        Blocks looked at on either side of the commanded one.
    prolong : bool
        Whether the ends go on.

    Returns
    -------
    ndarray
        Error [m], shape (n,).
    """
    out = np.empty(points.shape[0])
    last = curve.length.shape[0] - 1
    for k in range(points.shape[0]):
        best, side = math.inf, 0.0
        for i in range(max(block[k] - window, 0), min(block[k] + window, last) + 1):
            if math.isinf(curve.radius[i]):
                distance, right = _from_line(
                    curve, i, points[k, 0], points[k, 1], prolong and i == 0, prolong and i == last
                )
            elif abs(curve.along[i, 0] * curve.inward[i, 1] - curve.along[i, 1] * curve.inward[i, 0]) > 0.999:
                distance, right = _from_arc(curve, i, points[k, 0], points[k, 1])
            else:
                continue
            if distance < best * (1.0 - 1e-12):
                best, side = distance, right
            elif distance <= best * (1.0 + 1e-12) and right > 0.0:
                side = max(side, right)
        out[k] = math.copysign(best, side) if best < math.inf else 0.0
    return out
