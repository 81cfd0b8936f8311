"""What is left along the leading half of a mill's rim: arcs with the height that material still has there.

The arcs are a sorted list without overlaps, lowered by every earlier move as it comes. It grows as it must.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, inlined

FloatArray = npt.NDArray[np.float64]

SECTORS = 16  # parts of the half turn by which it is told what may still matter
SLIGHT = 1e-9  # [rad] contact narrower than this is a touch
LEVEL = 1e-9  # [m] heights nearer than this are one
_PLAIN = 16  # arcs of one place that are kept as they are
_STEP = 0.02  # of the mill radius: where there are more arcs, steps lower than this are joined to their mean


@compiled
def lowered(
    rim: FloatArray, count: int, begin: float, end: float, height: float, floor: float
) -> tuple[FloatArray, int, bool]:
    """Lower what is left between two angles [rad] to a height [m]; at the floor and below nothing is left.

    Returns the list, which is a larger one where it was full, its length, and whether it has changed.
    """
    if count + 2 > rim.shape[0]:
        larger = np.empty((2 * rim.shape[0] + 2, 3))
        larger[:count] = rim[:count]
        rim = larger
    changed = False
    i = count - 1
    while i >= 0 and rim[i, 1] > begin:
        low, high, top = rim[i, 0], rim[i, 1], rim[i, 2]
        a, b = max(low, begin), min(high, end)
        if b - a > SLIGHT and top - height > LEVEL:
            left, right, middle = a - low > SLIGHT, high - b > SLIGHT, height > floor + LEVEL
            a, b = a if left else low, b if right else high
            parts = int(left) + int(middle) + int(right)
            if parts > 1:
                for k in range(count - 1, i, -1):
                    for c in range(3):
                        rim[k + parts - 1, c] = rim[k, c]
            elif parts == 0:
                for k in range(i, count - 1):
                    for c in range(3):
                        rim[k, c] = rim[k + 1, c]
            count += parts - 1
            at = i
            if left:
                rim[at, 0], rim[at, 1], rim[at, 2] = low, a, top
                at += 1
            if middle:
                rim[at, 0], rim[at, 1], rim[at, 2] = a, b, height
                at += 1
            if right:
                rim[at, 0], rim[at, 1], rim[at, 2] = b, high, top
            changed = True
        i -= 1
    return rim, _joined(rim, count) if changed else count, changed


@compiled
def _joined(rim: FloatArray, count: int) -> int:
    """Make neighbours of one height one arc; returns how many there are then."""
    n = 0
    for i in range(count):
        if n > 0 and rim[i, 0] - rim[n - 1, 1] <= SLIGHT and abs(rim[i, 2] - rim[n - 1, 2]) <= LEVEL:
            rim[n - 1, 1] = rim[i, 1]
        else:
            if n < i:
                for c in range(3):
                    rim[n, c] = rim[i, c]
            n += 1
    return n


class Ahead(NamedTuple):
    """Where along a rim something is left, by sectors; changes in place."""

    hull: (
        FloatArray  # angles from, to of what is left in each sector [rad], and the same as it was before, shape (s, 4)
    )
    circle: FloatArray  # x, y of a circle about it, the radius of it and of the mill [m], height of what is left, shape (s, 4)
    left: FloatArray  # rows of ``circle`` of the sectors that have something, shape (s, 4)


@compiled
def look_ahead(
    rim: FloatArray, count: int, px: float, py: float, wall: float, radius: float, ahead: Ahead
) -> tuple[int, float, float]:
    """Note by sectors what is left of a rim: in how many, and the point of the rim amid the widest arc [m]."""
    width = math.pi / SECTORS
    hull, circle = ahead.hull, ahead.circle
    for s in range(SECTORS):
        circle[s, 3] = -math.inf
        hull[s, 0], hull[s, 1] = math.inf, -math.inf
    widest, middle = -1.0, 0.0
    for i in range(count):
        low, high = rim[i, 0], rim[i, 1]
        if high - low > widest:
            widest, middle = high - low, 0.5 * (low + high)
        for s in range(int(low / width), min(int(high / width), SECTORS - 1) + 1):
            hull[s, 0] = min(hull[s, 0], max(low, s * width))
            hull[s, 1] = max(hull[s, 1], min(high, (s + 1) * width))
            circle[s, 3] = max(circle[s, 3], rim[i, 2])
    n = 0
    for s in range(SECTORS):
        if circle[s, 3] > -math.inf:
            if hull[s, 0] != hull[s, 2] or hull[s, 1] != hull[s, 3]:
                hull[s, 2], hull[s, 3] = hull[s, 0], hull[s, 1]
                angle = wall + 0.5 * (hull[s, 0] + hull[s, 1])
                circle[s, 0], circle[s, 1] = px + radius * math.cos(angle), py + radius * math.sin(angle)
                circle[s, 2] = radius + 2.0 * radius * math.sin(0.25 * (hull[s, 1] - hull[s, 0]))
            for k in range(4):
                ahead.left[n, k] = circle[s, k]
            n += 1
    return n, px + radius * math.cos(wall + middle), py + radius * math.sin(wall + middle)


@inlined
def may_lower(tree: FloatArray, node: int, left: FloatArray, sectors: int) -> bool:
    """Whether a mill whose centre runs within a box of a tree may lower what is left.

    The row of the box is x, y from, x, y to, and the lowest tip [m].
    """
    for s in range(sectors):
        if left[s, 3] > tree[node, 4] + LEVEL:
            dx = max(tree[node, 0] - left[s, 0], left[s, 0] - tree[node, 2], 0.0)
            dy = max(tree[node, 1] - left[s, 1], left[s, 1] - tree[node, 3], 0.0)
            if dx * dx + dy * dy < left[s, 2] * left[s, 2]:
                return True
    return False


@inlined
def lowers(
    tree: FloatArray, node: int, rim: FloatArray, count: int, px: float, py: float, wall: float, radius: float
) -> bool:
    """The same for a small box, sharper: whether the arc that a circle about it may sweep has something left."""
    dx, dy = 0.5 * (tree[node, 0] + tree[node, 2]) - px, 0.5 * (tree[node, 1] + tree[node, 3]) - py
    reach = radius + 0.5 * math.hypot(tree[node, 2] - tree[node, 0], tree[node, 3] - tree[node, 1])
    d = math.hypot(dx, dy)
    if d >= radius + reach:
        return False
    if reach >= d + radius or d < 1e-9 * radius:
        return True
    half = math.acos(max((d * d + radius * radius - reach * reach) / (2.0 * d * radius), -1.0)) + SLIGHT
    low = (math.atan2(dy, dx) - half - wall) % (2.0 * math.pi)
    high, again = low + 2.0 * half, low + 2.0 * half - 2.0 * math.pi
    for i in range(count):
        if rim[i, 2] > tree[node, 4] + LEVEL and ((rim[i, 0] < high and rim[i, 1] > low) or rim[i, 0] < again):
            return True
    return False


@compiled
def plainer(rim: FloatArray, count: int, radius: float) -> int:
    """Where there are many arcs, join neighbours between which the height hardly steps; what they remove is kept.

    Behind a ramp or a surface of many small heights each point of the rim has a height of its own. Up to 16 arcs stay as they
    are; of more, neighbours within 2 % of the mill radius become one of their mean height, weighted by what a feed
    takes of each, so that the removed volume stays the same.
    """
    if count <= _PLAIN:
        return count
    n = 0
    least, most = 0.0, 0.0
    for i in range(count):
        low, high, top = rim[i, 0], rim[i, 1], rim[i, 2]
        near = max(most, top) - min(least, top) <= _STEP * radius
        if n > 0 and low - rim[n - 1, 1] <= SLIGHT and near:
            have = math.cos(rim[n - 1, 0]) - math.cos(rim[n - 1, 1])
            more = math.cos(low) - math.cos(high)
            rim[n - 1, 1], rim[n - 1, 2] = high, (have * rim[n - 1, 2] + more * top) / (have + more)
            least, most = min(least, top), max(most, top)
        else:
            rim[n, 0], rim[n, 1], rim[n, 2] = low, high, top
            least, most = top, top
            n += 1
    return n
