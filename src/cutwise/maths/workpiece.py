r"""What is left of a stock that was cut in several set-ups: inside every map, each seen along its own tool axis.

A point p of the frame that is looked along is :math:`T_j p + t_j` in that of map j, and material where it lies below the surface
of each of them. Maps along the same axis give one height together; maps across it leave intervals of a column.
"""

import math
from collections.abc import Callable
from typing import NamedTuple, cast

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, inlined_stepping, stepping
from cutwise.maths.height_map import RINGS, SIDE, HeightMap, Held
from cutwise.maths.map_surface import surface, surface_above
from cutwise.maths.other_maps import OtherMaps, end_to_end, other_map
from cutwise.maths.solid import Solid, nearest

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

_FAR = 1.0  # [m] that stands for an infinite height
_ALONG = 1e-9  # of the axes: two that are one
_FINE = 1e-9  # [m] to which the ends of an interval are found
_HALVINGS = 40


class Workpiece(NamedTuple):
    """Material under several maps; the first is the one that is cut, in whose frame points are told."""

    solid: Solid  # the map that is cut
    others: OtherMaps
    count: int  # type: ignore[assignment]  # of all maps
    turn: FloatArray  # T of each map, shape (m, 3, 3)
    shift: FloatArray  # t of each map [m], shape (m, 3)
    parallel: BoolArray  # whether a map is seen along the same axis, shape (m,)
    crossing: bool  # whether one is not


def alone(solid: Solid) -> Workpiece:
    """A stock of one set-up."""
    return Workpiece(solid, end_to_end(()), 1, np.eye(3)[None].copy(), np.zeros((1, 3)), np.ones(1, bool), False)


class Frame(NamedTuple):
    """How a set-up looks at the part: its axes as columns, and its zero [m], in part coordinates."""

    axes: FloatArray  # shape (3, 3)
    zero: FloatArray  # shape (3,)


def frame_of(axis: FloatArray, zero: FloatArray, rotation: float) -> Frame:
    """The frame whose z is the axis to the spindle; x is x of the part across it (y where that is the axis), turned about it [rad].

    Examples
    --------
    Along y of the part: x stays, and y of the program points down.

    >>> frame_of(np.array([0.0, 2.0, 0.0]), np.zeros(3), 0.0).axes.round(9).tolist()
    [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
    """
    z = np.asarray(axis, float) / np.linalg.norm(axis)
    start = np.array([0.0, 1.0, 0.0]) if abs(abs(z[0]) - 1.0) <= _ALONG else np.array([1.0, 0.0, 0.0])
    x = start - (start @ z) * z
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    c, s = math.cos(rotation), math.sin(rotation)
    return Frame(np.column_stack([c * x + s * y, c * y - s * x, z]), np.asarray(zero, float))


def under(solids: list[Solid], frames: list[Frame], seen: Frame) -> Workpiece:
    """Material under all solids, each in its frame, told in a frame; the first is the one that is cut there."""
    turn = np.array([frame.axes.T @ seen.axes for frame in frames])
    turn = np.where(np.abs(turn) < 1e-15, 0.0, turn)  # rounding of quarter turns
    shift = np.array([frame.axes.T @ (seen.zero - frame.zero) for frame in frames])
    parallel = np.abs(turn[:, 2, 2] - 1.0) <= _ALONG
    return Workpiece(solids[0], end_to_end(solids[1:]), len(solids), turn, shift, parallel, bool((~parallel).any()))


@stepping
def map_of(piece: Workpiece, j: int) -> Solid:
    """One of all maps.

    Parameters
    ----------
    piece : Workpiece
        The material.
    j : int
        Which; 0 is the one that is cut.

    Returns
    -------
    Solid
        The map, or a view of it.

    Notes
    -----
    Valid for 0 <= j < ``count``, where :func:`cutwise.maths.other_maps.other_map` is; Python takes :func:`maps_of`.

    Examples
    --------
    >>> from cutwise.maths.envelopes import segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.solid import Outline, RECTANGLE
    >>> from cutwise.maths.profiles import cutters, flat
    >>> stock = height_map(layout((0.0, 8e-3), (0.0, 4e-3), 1e-3), np.ones((4, 8)), -5e-3, 0.0)
    >>> solid = Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), segments([], []), cutters([flat(1e-3)]))
    >>> both = under([solid, solid], [Frame(np.eye(3), np.zeros(3))] * 2, Frame(np.eye(3), np.zeros(3)))
    >>> map_of(both, 0).map.layout == map_of(both, 1).map.layout
    True

    References
    ----------
    Derived here.
    """
    return piece.solid if j == 0 else other_map(piece.others, j - 1)


def maps_of(piece: Workpiece) -> list[Solid]:
    """All maps, views of them."""
    read = cast(Callable[[OtherMaps, int], Solid], other_map.py_func)  # type: ignore[attr-defined]
    return [piece.solid, *(read(piece.others, j) for j in range(piece.count - 1))]


@stepping
def in_frame(piece: Workpiece, j: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    r"""A point in the frame of a map, :math:`T_j p + t_j` [m].

    Parameters
    ----------
    piece : Workpiece
        The material.
    j : int
        Which map.
    x, y, z : float
        The point [m].

    Returns
    -------
    tuple
        Its coordinates [m].

    Notes
    -----
    Valid for any point.

    Examples
    --------
    >>> from cutwise.maths.envelopes import segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.solid import Outline, RECTANGLE
    >>> from cutwise.maths.profiles import cutters, flat
    >>> stock = height_map(layout((0.0, 8e-3), (0.0, 4e-3), 1e-3), np.ones((4, 8)), -5e-3, 0.0)
    >>> block = alone(Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), segments([], []), cutters([flat(1e-3)])))
    >>> in_frame(block, 0, 1e-3, 2e-3, -3e-3)
    (0.001, 0.002, -0.003)

    References
    ----------
    Derived here.
    """
    t, s = piece.turn[j], piece.shift[j]
    return (
        t[0, 0] * x + t[0, 1] * y + t[0, 2] * z + s[0],
        t[1, 0] * x + t[1, 1] * y + t[1, 2] * z + s[1],
        t[2, 0] * x + t[2, 1] * y + t[2, 2] * z + s[2],
    )


@inlined_stepping
def height_under(piece: Workpiece, done: int, x: float, y: float, level: float, found: IntArray) -> float:
    """Height of what is left at a point of the plan [m], under all maps along the axis of the first, as far down as a level.

    Parameters
    ----------
    piece : Workpiece
        The material.
    done : int
        How many moves of the first map have been run.
    x, y : float
        The point [m].
    level : float
        Where material that stands no higher may be told too high [m].
    found : array (16,)
        Room for ids, integers.

    Returns
    -------
    float
        Height [m]; minus infinity outside of the stock.

    Notes
    -----
    Valid as :func:`cutwise.maths.map_surface.surface_above`.

    Examples
    --------
    >>> from cutwise.maths.envelopes import segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.solid import Outline, RECTANGLE
    >>> from cutwise.maths.profiles import cutters, flat
    >>> stock = height_map(layout((0.0, 8e-3), (0.0, 4e-3), 1e-3), np.ones((4, 8)), -5e-3, 0.0)
    >>> block = alone(Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), segments([], []), cutters([flat(1e-3)])))
    >>> height_under(block, 0, 1e-3, 2e-3, -math.inf, np.empty(16, np.int64))
    0.0

    References
    ----------
    Derived here.
    """
    height = surface_above(piece.solid, done, x, y, level, found)
    for j in range(1, piece.count):
        if piece.parallel[j]:
            u, v, w = in_frame(piece, j, x, y, 0.0)
            other = other_map(piece.others, j - 1)
            height = min(height, surface(other, other.path.first.size - 1, u, v, found)[0] - w)
    return height


@stepping
def depth_under(piece: Workpiece, x: float, y: float, z: float, found: IntArray) -> float:
    """How deep a point lies below the surfaces of the maps across the axis that is looked along, at least [m]; negative: above one.

    Parameters
    ----------
    piece : Workpiece
        The material.
    x, y, z : float
        The point [m].
    found : array (16,)
        Room for ids, integers.

    Returns
    -------
    float
        Depth, each along its own axis, no more than 1 m [m].

    Notes
    -----
    Valid as :func:`cutwise.maths.map_surface.surface`; the underside of a stock from a file counts too.

    Examples
    --------
    No map goes across a block that was cut in one set-up.

    >>> from cutwise.maths.envelopes import segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.solid import Outline, RECTANGLE
    >>> from cutwise.maths.profiles import cutters, flat
    >>> stock = height_map(layout((0.0, 8e-3), (0.0, 4e-3), 1e-3), np.ones((4, 8)), -5e-3, 0.0)
    >>> block = alone(Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), segments([], []), cutters([flat(1e-3)])))
    >>> depth_under(block, 1e-3, 2e-3, -1e-3, np.empty(16, np.int64))
    1.0

    References
    ----------
    Derived here.
    """
    depth = _FAR
    for j in range(1, piece.count):
        if not piece.parallel[j]:
            u, v, w = in_frame(piece, j, x, y, z)
            other = other_map(piece.others, j - 1)
            depth = min(depth, max(surface(other, other.path.first.size - 1, u, v, found)[0] - w, -_FAR))
    return depth


@stepping
def _inside(piece: Workpiece, x: float, y: float, z: float, found: IntArray) -> bool:
    """Whether a point is inside all maps but the first."""
    for j in range(1, piece.count):
        u, v, w = in_frame(piece, j, x, y, z)
        other = other_map(piece.others, j - 1)
        if not surface(other, other.path.first.size - 1, u, v, found)[0] > w:
            return False
    return True


@stepping
def _probably(
    piece: Workpiece, x: float, y: float, bottom: float, width: float, steps: int, inside: BoolArray
) -> None:  # fmt: skip
    """The same by the cells in which they are, of the middles of all steps of a column: a map at a time."""
    for i in range(steps):
        inside[i] = True
    for j in range(1, piece.count):
        other = other_map(piece.others, j - 1)
        for i in range(steps):
            if inside[i]:
                u, v, w = in_frame(piece, j, x, y, bottom + width * (i + 0.5))
                at = nearest(other, u, v)
                inside[i] = at >= 0 and other.map.height[at] > w


@stepping
def _crossing(piece: Workpiece, x: float, y: float, low: float, high: float, step: float, found: IntArray) -> float:
    """Where a column enters or leaves the material between two heights, or within a step of them [m]."""
    a, b = low - step, high + step
    inside = _inside(piece, x, y, a, found)
    if inside == _inside(piece, x, y, b, found):
        return 0.5 * (low + high)
    for _ in range(_HALVINGS):
        if b - a <= _FINE:
            break
        middle = 0.5 * (a + b)
        if _inside(piece, x, y, middle, found) == inside:
            a = middle
        else:
            b = middle
    return 0.5 * (a + b)


@compiled
def _columns(
    piece: Workpiece, x: FloatArray, y: FloatArray, bottom: FloatArray, top: FloatArray, step: float, first: IntArray
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Intervals of material in columns one behind the other; where those of each begin goes into ``first``."""
    found, most = np.empty(16, np.int64), 1
    for k in range(x.size):
        most = max(most, math.ceil((top[k] - bottom[k]) / step))
    inside, count = np.empty(most, np.bool_), 0
    low, high = np.empty(2 * x.size + most), np.empty(2 * x.size + most)
    for k in range(x.size):
        if count + most > low.size:  # a column has fewer intervals than steps
            low, high = np.concatenate((low, np.empty_like(low))), np.concatenate((high, np.empty_like(high)))
        if top[k] > bottom[k]:
            steps = max(1, math.ceil((top[k] - bottom[k]) / step))
            width = (top[k] - bottom[k]) / steps
            before, begin = False, bottom[k]
            _probably(piece, x[k], y[k], bottom[k], width, steps, inside)
            for i in range(steps + 1):
                now = i < steps and inside[i]
                if now == before:
                    continue
                at = bottom[k] if i == 0 else top[k]
                if 0 < i < steps:
                    z = bottom[k] + width * (i + 0.5)
                    at = _crossing(piece, x[k], y[k], z - width, z, width, found)
                    at = min(max(at, bottom[k]), top[k])
                if now:
                    begin = at
                elif at > begin:
                    low[count], high[count] = begin, at
                    count += 1
                before = now
        first[k + 1] = count
    return low[:count].copy(), high[:count].copy()


def held_columns(
    piece: Workpiece, x: FloatArray, y: FloatArray, bottom: FloatArray, top: FloatArray, step: float
) -> Held:
    """Intervals of material under all maps but the first in columns (n,) of its frame, by steps of ``step`` [m]."""
    first = np.zeros(x.size + 1, np.int64)
    low, high = _columns(piece, x, y, bottom, top, step, first)
    return Held(first, low, high)


def with_held(stock: HeightMap, piece: Workpiece) -> HeightMap:
    """A map before its first move that knows what other set-ups have left of each of its columns."""
    grid = stock.layout
    count = stock.height.size
    block, cell = np.divmod(np.arange(count), SIDE * SIDE)
    i = (block % grid.columns) * SIDE + cell % SIDE - RINGS
    j = (block // grid.columns) * SIDE + cell // SIDE - RINGS
    x, y = grid.x + grid.dx * (i + 0.5), grid.y + grid.dy * (j + 0.5)
    bottom = np.broadcast_to(stock.bottom, count).astype(float)
    top = np.where(stock.height > -1e29, stock.height.astype(float), bottom)
    held = held_columns(piece, x, y, bottom, top, 0.5 * min(grid.dx, grid.dy))
    height, last = stock.height.copy(), held.first[1:] - 1
    there = np.diff(held.first) > 0
    height[there] = held.high[last[there]].astype(np.float32)
    inner = stock.share > 0.0
    height[~there & inner] = np.minimum(height, bottom.astype(np.float32))[~there & inner]
    return stock._replace(height=height, highest=height.reshape(-1, SIDE * SIDE).max(axis=1), held=held)
