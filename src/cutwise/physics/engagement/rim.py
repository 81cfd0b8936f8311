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
    """Lower what is left between two angles to a height; at the floor and below nothing is left.

    Parameters
    ----------
    rim : array (k, 3)
        Arcs from, to [rad], rising and without overlaps, and the height left there [m]; changes in place.
    count : int
        Arcs in it.
    begin, end : float
        Angles [rad].
    height, floor : float
        [m]

    Returns
    -------
    tuple
        The list, which is a larger one where it was full, its length, and whether it has changed.

    Notes
    -----
    Exact but for contact narrower than 1e-9 rad and heights nearer than 1 nm, which are one.

    Examples
    --------
    >>> rim = np.array([[0.0, 3.0, 0.01], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    >>> rim, count, changed = lowered(rim, 1, 1.0, 2.0, 0.005, 0.0)
    >>> rim[:count].tolist(), changed
    ([[0.0, 1.0, 0.01], [1.0, 2.0, 0.005], [2.0, 3.0, 0.01]], True)

    References
    ----------
    Derived here.
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
    r"""Note by sectors what is left of a rim: in how many, and the point of the rim amid the widest arc [m].

    A circle about the middle of an arc :math:`\Delta` of the rim holds every centre that can reach the arc if its radius is
    :math:`R + 2 R \sin(\Delta / 4)`.

    Parameters
    ----------
    rim, count
        Arcs with heights, as for :func:`lowered`, angles within 0 and pi.
    px, py : float
        Centre of the mill [m].
    wall : float
        Direction of the wall side [rad].
    radius : float
        Of the mill [m].
    ahead : Ahead
        Filled.

    Returns
    -------
    tuple
        Sectors that have something left, and x, y of a point of the rim [m].

    Examples
    --------
    An arc of 0.1 rad, its middle along x:

    >>> rim, ahead = np.array([[0.0, 0.1, 0.0]]), Ahead(*np.zeros((3, SECTORS, 4)))
    >>> [round(v, 9) for v in look_ahead(rim, 1, 0.0, 0.0, -0.05, 0.01, ahead)]
    [1, 0.01, 0.0]
    >>> round(1e3 * float(ahead.left[0, 2]), 6)  # 10 + 20 sin(0.025)
    10.499948

    References
    ----------
    Derived here.
    """
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

    Parameters
    ----------
    tree : array (n, 5)
        Boxes: x, y from, x, y to, and the lowest tip [m].
    node : int
        Row of the box.
    left : array (s, 4)
        x, y and radius of circles, and height of what is left [m], see :class:`Ahead`.
    sectors : int
        Rows of ``left``.

    Returns
    -------
    bool
        False only where it cannot; also True for a box that only comes near.

    Notes
    -----
    Valid for flat mills of one radius.

    Examples
    --------
    A circle of 10 mm at the origin, a box that begins 8 mm beside it, and one at 12 mm:

    >>> tree, left = np.array([[8e-3, 0.0, 1.0, 0.0, -1.0], [12e-3, 0.0, 1.0, 0.0, -1.0]]), np.array([[0.0, 0.0, 1e-2, 0.0]])
    >>> may_lower(tree, 0, left, 1), may_lower(tree, 1, left, 1)
    (True, False)

    References
    ----------
    Derived here.
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
    r"""The same for a small box, sharper: whether the arc that a circle about it may sweep has something left.

    .. math:: \cos\psi = \frac{d^2 + R^2 - r^2}{2 d R}, \qquad r = R + \text{half the diagonal of the box}

    Parameters
    ----------
    tree, node
        As for :func:`may_lower`.
    rim, count
        Arcs with heights, as for :func:`lowered`.
    px, py, wall, radius : float
        Centre of the mill [m], direction of the wall side [rad], radius of the mill [m].

    Returns
    -------
    bool
        False only where it cannot.

    Notes
    -----
    Valid for a box within the circle of the mill; sharp where it is small beside the radius.

    Examples
    --------
    A disc half a radius along the wall side sweeps up to arccos(1/4) = 1.318 rad of the rim:

    >>> tree = np.array([[5e-3, 0.0, 5e-3, 0.0, -1.0]])
    >>> [lowers(tree, 0, np.array([[low, 2.0, 0.0]]), 1, 0.0, 0.0, 0.0, 1e-2) for low in (1.31, 1.32)]
    [True, False]

    References
    ----------
    Derived here.
    """
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
    r"""Where there are many arcs, join neighbours between which the height hardly steps; what they remove is kept.

    Behind a ramp or a surface of many small heights each point of the rim has a height of its own. Up to 16 arcs stay as they
    are; of more, neighbours within 2 % of the mill radius become one of their mean height, weighted by what a feed
    takes of each, so that the removed volume stays the same.

    .. math:: \bar z = \frac{\sum z_i (\cos a_i - \cos b_i)}{\sum (\cos a_i - \cos b_i)}

    Parameters
    ----------
    rim, count
        Arcs with heights, as for :func:`lowered`; changes in place.
    radius : float
        Of the mill [m].

    Returns
    -------
    int
        How many arcs there are then.

    Notes
    -----
    Valid where 2 % of the radius do not matter for the force by height; the removed area is exact.

    Examples
    --------
    17 arcs, the middle one 0.1 mm lower than the others, under a mill of 10 mm: one arc, lower by 0.1 mm times sin(pi/34).

    >>> at = np.linspace(0.0, math.pi, 18)
    >>> rim = np.column_stack((at[:-1], at[1:], np.where(np.arange(17) == 8, 9.9e-3, 1e-2)))
    >>> plainer(rim, 17, 1e-2), round(1e3 * float(rim[0, 2]), 6)
    (1, 9.990773)

    References
    ----------
    Derived here.
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
