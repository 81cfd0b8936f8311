"""Whether a place that a mill leaves is what stays of the part: no later move of the path comes over it."""

import math

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.engagement.path_sweep import Swept

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

_TURN = 2.0 * math.pi
_LEVEL = 1e-9  # [m] a tip that passes no lower than this over a place leaves it alone


@compiled
def _nearest(swept: Swept, j: int, begin: float, x: float, y: float, z: float) -> float:
    """Distance in the plane of a point from the part of a piece behind a length of it where its tip is not above z [m]."""
    length, rise = swept.length[j], swept.rise[j]
    low, high = begin, length
    if rise != 0.0 and length > 0.0:
        at = (z - swept.height[j]) / rise * length
        if rise > 0.0:
            high = min(high, at)
        else:
            low = max(low, at)
    elif swept.height[j] > z:
        return math.inf
    if high < low:
        return math.inf
    dx, dy, tx, ty, turn = (
        x - swept.start[j, 0],
        y - swept.start[j, 1],
        swept.along[j, 0],
        swept.along[j, 1],
        swept.turn[j],
    )
    if turn == 0.0:
        s = min(max(dx * tx + dy * ty, low), high)
        return math.hypot(dx - s * tx, dy - s * ty)
    radius, side = 1.0 / abs(turn), math.copysign(1.0, turn)
    cx, cy = -side * radius * ty, side * radius * tx  # centre from the start
    away = math.atan2(dy - cy, dx - cx) - math.atan2(-cy, -cx)
    s = (side * away) % _TURN * radius
    least = math.inf
    for k in range(3):  # on the arc, or at either of its ends
        at = s if k == 0 else low if k == 1 else high
        if k > 0 or low <= s <= high:
            half = 0.5 * at * turn
            chord = 2.0 * math.sin(half) / turn
            px, py = (
                chord * (math.cos(half) * tx - math.sin(half) * ty),
                chord * (math.cos(half) * ty + math.sin(half) * tx),
            )
            least = min(least, math.hypot(dx - px, dy - py))
    return least


@compiled
def _stays(swept: Swept, x: float, y: float, z: float, way: float, reach: float, stack: npt.NDArray[np.int64]) -> bool:
    """Whether no move behind a way comes over a point nearer than the reach, with its tip no higher than z."""
    tree, size = swept.tree, swept.tree.shape[0] // 2
    now = max(int(np.searchsorted(swept.way, way, side="right")) - 1, 0)
    first_later = swept.first[now]
    stack[0, 0], stack[0, 1], stack[0, 2] = 1, 0, size
    depth = 1
    while depth > 0:
        depth -= 1
        node, first, span = stack[depth, 0], stack[depth, 1], stack[depth, 2]
        if first + span <= first_later or tree[node, 4] > z - _LEVEL:
            continue
        gx = max(tree[node, 0] - x, x - tree[node, 2], 0.0)
        gy = max(tree[node, 1] - y, y - tree[node, 3], 0.0)
        if gx * gx + gy * gy >= reach * reach:
            continue
        if span == 1:
            j = swept.piece[first]
            begin = 0.0
            if j == now and swept.way_length[j] > 0.0:
                begin = min(1.0, (way - swept.way[j]) / swept.way_length[j]) * swept.length[j]
            if _nearest(swept, j, begin, x, y, z - _LEVEL) < reach:
                return False
            continue
        half = span // 2
        stack[depth, 0], stack[depth, 1], stack[depth, 2] = 2 * node, first, half
        stack[depth + 1, 0], stack[depth + 1, 1], stack[depth + 1, 2] = 2 * node + 1, first + half, half
        depth += 2
    return True


@compiled
def surviving(point: FloatArray, way: FloatArray, swept: Swept, margin: float) -> BoolArray:
    """Whether places that a path leaves are not swept by what comes later.

    Parameters
    ----------
    point : array (n, 3)
        Places, and the height of the wall there [m].
    way : array (n,)
        Arc length of the path at which each was left [m].
    swept : Swept
        The path, rapid moves too.
    margin : float
        By which later moves have to reach over a place for it to be gone [m].

    Returns
    -------
    array (n,) of bool

    Notes
    -----
    Exact for lines, arcs and helices; other curves are the lines of :class:`Swept`. A wall is gone where a later tip is not
    above its height.

    Examples
    --------
    The right wall of a slot along x stays, and the left one of its first half is gone after a pass on the left.

    >>> from cutwise.maths.linearc import join, line
    >>> from cutwise.physics.engagement.path_sweep import swept_path
    >>> way = [((0, 0, 0), (0.1, 0, 0)), ((0.1, 0, 0), (0.1, 4e-3, 0)), ((0.1, 4e-3, 0), (0.02, 4e-3, 0))]
    >>> swept = swept_path(join([line(*ends) for ends in way]), 5e-3)
    >>> surviving(np.array([[0.05, -5e-3, 1e-3], [0.05, 5e-3, 1e-3], [0.01, 5e-3, 1e-3]]), np.array([0.05, 0.05, 0.01]),
    ...           swept, 1e-6).tolist()
    [True, False, True]

    References
    ----------
    Derived here.
    """
    out, stack = np.empty(point.shape[0], np.bool_), np.empty((132, 3), np.int64)
    for k in range(point.shape[0]):
        out[k] = _stays(swept, point[k, 0], point[k, 1], point[k, 2], way[k], swept.radius - margin, stack)
    return out
