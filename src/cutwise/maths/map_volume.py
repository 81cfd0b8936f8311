r"""How far the volumes that a map tells are from the true ones: its cells held against random points within them.

A map takes the volume of a move as the sum over cells of what their middles lose. What a point loses is known in closed form, as
the moves come in their order: :math:`\delta_m(p) = (\max(h_{m-1}, b) - \max(h_m, b))_+`. Points p drawn evenly, one in each part of
a cell of area w, give without bias what the sum misses, and how well that is known:

.. math:: E_m = \sum_p w\,(\delta_m(p) - \delta_m(c_p)), \qquad s_m^2 = \sum_p w^2 (\delta_m(p) - \delta_m(c_p))^2

with the middle c of the cell. Draws in different parts do not depend on one another, so that the variance of E is
:math:`\sum w^2 \operatorname{Var} \le \operatorname{E} s^2`. The error that is told is :math:`|E| + 3 s`. Away from walls the
difference is of the size of a cell, at walls of their depth: s falls with the cell to the power of 3/2.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, stepping
from cutwise.maths.envelopes import segment_height
from cutwise.maths.height_map import Held, Layout, cell_middles, in_blocks, in_rows, whole_columns
from cutwise.maths.map_index import Index
from cutwise.maths.solid import Solid, bottom_at, top_at, within
from cutwise.maths.workpiece import Workpiece, held_columns

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_SURE = 3.0  # standard deviations
_WORK = 3e6  # closed forms that are evaluated at the most, or so
_PARTS = 8  # of a cell along x and y, at the most
_LEAST = 4000  # points


class VolumeError(NamedTuple):
    """What the volumes of moves miss; estimates with three standard deviations of them."""

    shift: FloatArray  # true volume less that of the map, by estimate, of each move [m^3]
    spread: FloatArray  # standard deviation of that, no less than it is [m^3]
    whole: tuple[float, float]  # the same of all moves together [m^3]
    points: int

    @property
    def of_moves(self) -> FloatArray:
        """Error of the volume of each move [m^3]."""
        return np.asarray(np.abs(self.shift) + _SURE * self.spread)

    @property
    def of_all(self) -> float:
        """Error of the whole volume [m^3]."""
        return abs(self.whole[0]) + _SURE * self.whole[1]


class _Points(NamedTuple):
    """Points and the middles of their cells, shape (n,)."""

    x: FloatArray
    y: FloatArray
    middle_x: FloatArray
    middle_y: FloatArray
    share: FloatArray  # of the cell that is stock
    area: FloatArray  # for which a point stands [m^2]


@stepping
def _lost(before: float, after: float, bottom: float, held: Held, k: int) -> float:
    """What a column loses from a height to a lower one [m]."""
    if held.first.size == 1:
        return max(before, bottom) - max(after, bottom)
    off = 0.0
    for n in range(held.first[k], held.first[k + 1]):
        off += max(min(held.high[n], before) - max(held.low[n], after), 0.0)
    return off


@stepping
def _square(index: Index, x: float, y: float) -> int:
    """Square of an index in which a point is."""
    i = min(max(int((x - index.x) / index.size), 0), index.across - 1)
    j = min(max(int((y - index.y) / index.size), 0), index.along - 1)
    return j * index.across + i


@compiled
def _walked(
    solid: Solid, index: Index, move: IntArray, points: _Points, held: tuple[Held, Held], shift: FloatArray, square: FloatArray
) -> tuple[float, float]:  # fmt: skip
    """Add differences and their squares by move; returns those of all moves together."""
    whole = whole_square = 0.0
    for k in range(points.x.size):
        x, y, u, v = points.x[k], points.y[k], points.middle_x[k], points.middle_y[k]
        inside = points.area[k] if within(solid, x, y) else 0.0
        part = points.area[k] * points.share[k]
        h_point, h_middle = top_at(solid, x, y), top_at(solid, u, v)
        b_point, b_middle = bottom_at(solid, x, y), bottom_at(solid, u, v)
        p, c = _square(index, x, y), _square(index, u, v)
        a, b, a_end, b_end = index.first[p], index.first[c], index.first[p + 1], index.first[c + 1]
        if p == c:
            b = b_end
        here, difference, total = -1, 0.0, 0.0
        while a < a_end or b < b_end:
            segment = index.segment[a] if a < a_end else index.segment[b]
            if b < b_end and index.segment[b] <= segment:
                segment = index.segment[b]
                b += 1
            if a < a_end and index.segment[a] == segment:
                a += 1
            if move[segment] != here:
                if difference != 0.0:
                    shift[here] += difference
                    square[here] += difference * difference
                here, difference = move[segment], 0.0
            lost = 0.0
            left = segment_height(solid.path, solid.tools, segment, x, y)
            if left < h_point:
                lost += inside * _lost(h_point, left, b_point, held[0], k)
                h_point = left
            left = segment_height(solid.path, solid.tools, segment, u, v)
            if left < h_middle:
                lost -= part * _lost(h_middle, left, b_middle, held[1], k)
                h_middle = left
            difference += lost
            total += lost
        if difference != 0.0:
            shift[here] += difference
            square[here] += difference * difference
        whole += total
        whole_square += total * total
    return whole, whole_square


def _drawn(solid: Solid, index: Index, seed: int) -> _Points:
    """Points in parts of the cells, or in some of the cells, where there are too many for the work that is allowed."""
    grid, draw = solid.map.layout, np.random.default_rng(seed)
    x, y = _middles(grid)
    share = in_rows(grid, solid.map.share).astype(float).ravel()
    cells = np.flatnonzero(share > 0.0)
    wanted = max(_WORK / max(2.0 * index.segment.size / (index.first.size - 1), 1.0), _LEAST)
    parts = int(np.clip(np.sqrt(wanted / cells.size), 1, _PARTS))
    count = min(cells.size, int(wanted))
    chosen = cells[(np.arange(count) * cells.size + draw.integers(0, cells.size, count)) // count % cells.size]
    at = np.repeat(chosen, parts * parts)
    number = np.tile(np.arange(parts * parts), count)
    across, along = (number % parts + draw.random(at.size)) / parts, (number // parts + draw.random(at.size)) / parts
    area = np.full(at.size, cells.size * grid.dx * grid.dy / at.size)
    return _Points(
        x[at] + (across - 0.5) * grid.dx, y[at] + (along - 0.5) * grid.dy, x[at], y[at], share[at], area
    )  # fmt: skip


def _middles(grid: Layout) -> tuple[FloatArray, FloatArray]:
    """x and y of the stock's own cells, row by row [m]."""
    x, y = np.meshgrid(*cell_middles(grid))
    return tuple(in_rows(grid, np.asarray(in_blocks(one))).astype(float).ravel() for one in (x, y))  # type: ignore[return-value]


def volume_error(piece: Workpiece, index: Index, seed: int = 0) -> VolumeError:
    """What the volumes of all moves of the first map miss.

    Parameters
    ----------
    piece : Workpiece
        The material; of its first map the moves have been run, the heights of its cells are not looked at.
    index : Index
        All segments of the first map, from :func:`cutwise.maths.map_index.index_of`.
    seed : int
        Of the points.

    Notes
    -----
    Valid beside what stands for the stock itself: one from a file is taken to be what its cells say, its sides by the size of a
    cell. Heights of cells are float32, which adds 1e-8 of a metre times the area that a move lowers.

    Examples
    --------
    A hole of 4 mm, 1 mm deep, in cells of 1 mm: 16 middles lie in it, where the circle has 12.566 mm^2.

    >>> from cutwise.maths.envelopes import line_row, segments
    >>> from cutwise.maths.height_map import height_map, layout
    >>> from cutwise.maths.map_index import index_of
    >>> from cutwise.maths.profiles import cutters, flat
    >>> from cutwise.maths.solid import RECTANGLE, Outline
    >>> from cutwise.maths.workpiece import alone
    >>> stock = height_map(layout((0.0, 8e-3), (0.0, 8e-3), 1e-3), np.ones((8, 8)), -5e-3, 0.0)
    >>> path = segments([line_row(0, np.array([4e-3, 4e-3, 1e-3]), np.array([4e-3, 4e-3, -1e-3]))], [1])
    >>> hole = Solid(stock, Outline(RECTANGLE, 0.0, 0.0, 0.0), path, cutters([flat(2e-3)]))
    >>> found = volume_error(alone(hole), index_of(hole))
    >>> round(1e9 * float(found.shift[0]), 1), 1e9 * found.of_all < 2.0
    (0.6, True)
    """
    solid = piece.solid
    points = _drawn(solid, index, seed)
    moves = solid.path.first.size - 1
    of = np.repeat(np.arange(moves), np.diff(solid.path.first))
    shift, square = np.zeros(moves), np.zeros(moves)
    held = whole_columns(), whole_columns()
    if solid.map.held.first.size > 1:
        step = 0.5 * min(solid.map.layout.dx, solid.map.layout.dy)
        held = tuple(_columns(piece, x, y, step) for x, y in ((points.x, points.y), (points.middle_x, points.middle_y)))  # type: ignore[assignment]
    whole, whole_square = _walked(solid, index, of, points, held, shift, square)
    return VolumeError(shift, np.sqrt(square), (float(whole), float(np.sqrt(whole_square))), points.x.size)


def _columns(piece: Workpiece, x: FloatArray, y: FloatArray, step: float) -> Held:
    """What other set-ups have left of columns."""
    bottom, top = np.empty(x.size), np.empty(x.size)
    _sides(piece.solid, x, y, bottom, top)
    return held_columns(piece, x, y, bottom, np.maximum(top, bottom), step)


@compiled
def _sides(solid: Solid, x: FloatArray, y: FloatArray, bottom: FloatArray, top: FloatArray) -> None:
    """Under- and upper side of the uncut stock at points [m]."""
    for k in range(x.size):
        bottom[k], top[k] = bottom_at(solid, x[k], y[k]), top_at(solid, x[k], y[k])
