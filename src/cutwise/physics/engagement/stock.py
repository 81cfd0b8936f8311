r"""What a flat end mill meets along a whole path: contact arcs with the stock that the path has left so far.

Everything earlier moves have swept is gone: discs of the mill's radius along lines and arcs, from the height of their tip
up. At a point of the rim the material reaches from there down to the lowest tip that has passed it. Starting from the
whole leading half of the rim at the top of the stock, each move that matters lowers what is left, in the order in which a
tree of their boxes is gone through; what is left is a sorted list of arcs with heights. There is no grid and no fixed room:
arcs are exact for lines, arcs and helices, and lists grow as they must.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, inlined
from cutwise.physics.engagement.path_sweep import Swept
from cutwise.physics.engagement.rim import SECTORS, Ahead, look_ahead, lowered, lowers, may_lower, plainer
from cutwise.physics.engagement.sweep_arcs import Piece, View, swept_off

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_TURN = 2.0 * math.pi
_SMALL = 0.3  # of the mill radius: boxes that are looked at more sharply


class Stock(NamedTuple):
    """A convex block of material."""

    sides: FloatArray  # (n_x, n_y, c): inside where n . q < c [m], shape (k, 3); none: endless in the plane
    top: float  # [m]
    bottom: float  # [m]


class Scratch(NamedTuple):
    """Room to work in, used again from place to place."""

    ahead: Ahead
    stack: IntArray  # nodes of the tree that wait: number, first stretch, how many stretches
    cuts: FloatArray  # angles [rad]


def block_stock(x: Sequence[float], y: Sequence[float], top: float, bottom: float) -> Stock:
    """A rectangular block from its least and greatest x and y [m].

    Examples
    --------
    >>> block_stock((0.0, 0.1), (0.0, 0.05), 0.0, -0.02).sides[1].tolist()  # x < 0.1
    [1.0, 0.0, 0.1]
    """
    sides = [[-1.0, 0.0, -x[0]], [1.0, 0.0, x[1]], [0.0, -1.0, -y[0]], [0.0, 1.0, y[1]]]
    return Stock(np.array(sides), top, bottom)


@compiled
def _outside(
    stock: Stock, px: float, py: float, radius: float, view: View, rim: FloatArray, count: int
) -> tuple[FloatArray, int]:
    """Take away what of the rim is outside the stock."""
    for k in range(stock.sides.shape[0]):
        nx, ny = stock.sides[k, 0], stock.sides[k, 1]
        offset = (stock.sides[k, 2] - nx * px - ny * py) / radius
        if offset <= -1.0:
            return rim, 0
        if offset < 1.0:
            half = math.acos(offset)
            low = (math.atan2(ny, nx) - half - view.wall) % _TURN
            high = low + 2.0 * half
            rim, count, _ = lowered(rim, count, low, min(high, math.pi), -math.inf, view.floor)
            rim, count, _ = lowered(rim, count, 0.0, min(high - _TURN, math.pi), -math.inf, view.floor)
    return rim, count


@inlined
def _score(tree: FloatArray, node: int, x: float, y: float, floor: float) -> float:
    """Which of two boxes to look into first: the one near a point, and low [m]."""
    dx, dy = max(tree[node, 0] - x, x - tree[node, 2], 0.0), max(tree[node, 1] - y, y - tree[node, 3], 0.0)
    return math.sqrt(dx * dx + dy * dy) + 1e3 * max(tree[node, 4] - floor, 0.0)


@compiled
def _left(
    px: float, py: float, view: View, way: float, swept: Swept, stock: Stock, rim: FloatArray, scratch: Scratch
) -> tuple[FloatArray, int]:
    """What all moves before a place have left along its leading half: arcs with heights; their list and number.

    The tree is gone through from the top, the nearer and lower of two children first; what cannot lower anything that is left is
    passed over. Moves that only swept what others swept too are hardly looked at that way, however many they are.
    """
    ahead, stack, cuts = scratch
    radius, tree = swept.radius, swept.tree
    wall, floor = view.wall, view.floor
    rim[0, 0], rim[0, 1], rim[0, 2] = 0.0, math.pi, stock.top
    rim, count = _outside(stock, px, py, radius, view, rim, 1)
    pieces = np.searchsorted(swept.way, way)  # that began before
    last = swept.first[pieces]
    if count == 0 or last == 0:
        return rim, count
    ahead.hull[:] = -1.0
    sectors, x, y = look_ahead(rim, count, px, py, wall, radius, ahead)
    size = swept.tree.shape[0] // 2
    stack[0, 0], stack[0, 1], stack[0, 2] = 1, 0, size
    depth, done = 1, -1
    while depth > 0 and count > 0:
        depth -= 1
        node, first, span = stack[depth, 0], stack[depth, 1], stack[depth, 2]
        if not may_lower(tree, node, ahead.left, sectors):
            continue
        small = max(tree[node, 2] - tree[node, 0], tree[node, 3] - tree[node, 1]) < _SMALL * radius
        if small and not lowers(tree, node, rim, count, px, py, wall, radius):
            continue
        if span == 1:
            j = swept.piece[first]
            if j == done:
                continue
            done = j
            share = min(1.0, (way - swept.way[j]) / swept.way_length[j]) if swept.way_length[j] > 0.0 else 1.0
            flat = swept.length[j]
            piece = Piece(
                swept.start[j, 0] - px, swept.start[j, 1] - py, swept.along[j, 0], swept.along[j, 1], swept.turn[j],
                share * flat, swept.height[j], swept.rise[j] / flat if flat > 0.0 else 0.0, radius, share < 1.0,
            )  # fmt: skip
            rim, count, changed = swept_off(piece, view, cuts, rim, count)
            if changed:
                sectors, x, y = look_ahead(rim, count, px, py, wall, radius, ahead)
            continue
        half = span // 2
        later = first + half < last
        sooner_first = later and _score(tree, 2 * node, x, y, floor) < _score(tree, 2 * node + 1, x, y, floor)
        for k in range(2):
            if (k == 0) == sooner_first:  # what is pushed last is looked at first
                if later:
                    stack[depth, 0], stack[depth, 1], stack[depth, 2] = 2 * node + 1, first + half, half
                    depth += 1
            else:
                stack[depth, 0], stack[depth, 1], stack[depth, 2] = 2 * node, first, half
                depth += 1
    return rim, count


@compiled
def _contacts(
    point: FloatArray, heading: FloatArray, way: FloatArray, swept: Swept, stock: Stock, closed: bool
) -> tuple[FloatArray, IntArray]:
    """Patches of all places one after the other, and the first of each place."""
    rim, out = np.empty((32, 3)), np.empty((2 * point.shape[0] + 16, 4))
    first = np.zeros(point.shape[0] + 1, dtype=np.int64)
    # 64 bits number all nodes, so that no more than 64 wait
    scratch = Scratch(
        Ahead(np.empty((SECTORS, 4)), np.empty((SECTORS, 4)), np.empty((SECTORS, 4))),
        np.empty((66, 3), np.int64), np.empty(16),
    )  # fmt: skip
    filled = 0
    for k in range(point.shape[0]):
        z = point[k, 2]
        if z < stock.top - 1e-12:
            floor = max(z, stock.bottom)
            view = View(heading[k] - 0.5 * math.pi, floor, closed)
            rim, count = _left(point[k, 0], point[k, 1], view, way[k], swept, stock, rim, scratch)
            count = plainer(rim, count, swept.radius)
            if filled + count > out.shape[0]:
                larger = np.empty((2 * (filled + count), 4))
                larger[:filled] = out[:filled]
                out = larger
            for i in range(count):
                out[filled, 0], out[filled, 1] = rim[i, 0], rim[i, 1]
                out[filled, 2], out[filled, 3] = floor - z, rim[i, 2] - z
                filled += 1
        first[k + 1] = filled
    return out[:filled], first


def contact_patches(point: FloatArray, heading: FloatArray, way: FloatArray, swept: Swept, stock: Stock) -> FloatArray:
    """Contact patches of a flat end mill at places of its path, with what the path has left until there.

    Parameters
    ----------
    point : array (n, 3)
        Tool tip [m].
    heading : array (n,)
        Direction of feed in the plane [rad]; the half of the rim ahead of it cuts.
    way : array (n,)
        Arc length of the path at the places [m].
    swept : Swept
        The path.
    stock : Stock
        The material before it.

    Returns
    -------
    array (n, p, 4)
        Arc from, to, in angles from the wall side (heading - 90°) [rad], rising and without overlaps, and heights above
        the tip from, to [m]; empty patches are zero. There are as many as the place with the most has.

    Notes
    -----
    Arcs swept by lines, arcs and helices are exact. Behind a ramp the height of what is left changes along the rim; it
    stands in steps of 2 % of the mill radius at their mean heights, and more than 16 arcs of one place are made fewer
    by :func:`~cutwise.physics.engagement.rim.plainer`.

    Examples
    --------
    Back along a slot, half a radius beside it, in a block 3 mm deep: 60 degrees from the wall side, over all of it.

    >>> from cutwise.maths.linearc import join, line
    >>> from cutwise.physics.engagement.path_sweep import swept_path
    >>> way = [((0, 0, 0), (0.2, 0, 0)), ((0.2, 0, 0), (0.2, 0, 1)), ((0.2, 0, 1), (0.2, 5e-3, 1)),
    ...        ((0.2, 5e-3, 1), (0.2, 5e-3, 0)), ((0.2, 5e-3, 0), (0, 5e-3, 0))]
    >>> swept, block = swept_path(join([line(*ends) for ends in way]), 1e-2), block_stock((-1, 1), (-1, 1), 3e-3, -1e-3)
    >>> at = np.array([[0.1, 5e-3, 0.0]])
    >>> patch = contact_patches(at, np.array([math.pi]), np.array([2.305]), swept, block)[0, 0]
    >>> np.degrees(patch[:2]).round(6).tolist(), patch[2:].round(9).tolist()
    ([0.0, 60.0], [0.0, 0.003])

    References
    ----------
    Derived here.
    """
    return _table(*_contacts(*_plain(point, heading, way), swept, stock, False))  # type: ignore[arg-type, call-arg]


def _plain(*columns: FloatArray) -> list[FloatArray]:
    return [np.ascontiguousarray(column, dtype=np.float64) for column in columns]


def _table(rows: FloatArray, first: IntArray) -> FloatArray:
    """Patches of all places as one table, filled up with zeros."""
    count = np.diff(first)
    out = np.zeros((count.size, max(int(count.max(initial=0)), 1), 4))
    out[np.repeat(np.arange(count.size), count), np.arange(len(rows)) - np.repeat(first[:-1], count)] = rows
    return out


def stands_in_material(point: FloatArray, way: FloatArray, swept: Swept, stock: Stock) -> FloatArray:
    """How much of the whole rim is in contact where the mill goes straight down [rad], shape (n,).

    ``point`` (n, 3) is the tip [m], ``way`` (n,) the arc length at which that move began [m]: what was swept before it is
    gone, the very same place too.

    ``swept``, ``stock``: as for :func:`contact_patches`. Exact as there, but for the step of a ramp.

    References
    ----------
    Derived here.
    """
    halves = [_contacts(*_plain(point, np.full(len(point), turn), way), swept, stock, True) for turn in (0.0, math.pi)]  # type: ignore[arg-type, call-arg]
    return immersion(_table(*halves[0])) + immersion(_table(*halves[1]))


def removal_area(patches: FloatArray, radius: float) -> FloatArray:
    r"""Cross-section that the mill takes per length of feed, :math:`\sum R (\cos a_1 - \cos a_2)\,\Delta z` [m^2], (n,).

    ``patches``: of :func:`contact_patches`, shape (n, p, 4); ``radius`` R [m]. Exact for feeds small against R.

    Examples
    --------
    60 degrees of a mill of 10 mm are 5 mm wide; 2 mm high:

    >>> (1e6 * removal_area(np.array([[[0.0, math.pi / 3, 0.0, 2e-3]]]), 1e-2)).round(9).tolist()
    [10.0]

    References
    ----------
    Derived here.
    """
    width = np.cos(patches[..., 0]) - np.cos(patches[..., 1])
    return radius * np.sum(width * (patches[..., 3] - patches[..., 2]), axis=-1)


def immersion(patches: FloatArray) -> FloatArray:
    """Largest sum of arcs at one height [rad], shape (n,).

    ``patches``: of :func:`contact_patches`, shape (n, p, 4).

    Examples
    --------
    Two arcs at one height, and one above them:

    >>> immersion(np.array([[[0.0, 0.5, 0.0, 1.0], [1.0, 2.0, 0.0, 1.0], [0.0, 1.25, 1.0, 2.0]]])).tolist()
    [1.5]

    References
    ----------
    Derived here.
    """
    low, high = patches[..., 2], patches[..., 3]
    angle = patches[..., 1] - patches[..., 0]
    at = 0.5 * (low + high)
    inside = (low[:, None, :] <= at[:, :, None]) & (at[:, :, None] < high[:, None, :])
    return np.asarray((inside * angle[:, None, :]).sum(axis=-1).max(axis=-1))
