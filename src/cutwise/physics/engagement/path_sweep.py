"""Earlier moves of a flat end mill as pieces of lines and arcs, with a grid that finds those near a place."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.maths.linearc import LineArc, at_blocks

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_CHORD = 0.1e-6  # [m] by which lines may miss a curve that is neither line nor arc
_RAMP = 0.05  # of the mill radius: height steps into which a ramp is cut
_CELLS = 256  # largest number of cells along a side of the search grid


class Swept(NamedTuple):
    """Moves in their order as pieces of lines and arcs, ``n`` of them, and a grid to find those near a place."""

    start: FloatArray  # [m], shape (n, 2)
    along: FloatArray  # unit tangent at the start, shape (n, 2)
    turn: FloatArray  # curvature, positive to the left, 0 on a line [1/m], shape (n,)
    length: FloatArray  # in the plane [m], shape (n,)
    height: FloatArray  # above which the piece clears [m], shape (n,)
    way: FloatArray  # arc length of the whole path at its start [m], shape (n,)
    way_length: FloatArray  # of the piece along the path, rise included [m], shape (n,)
    radius: float  # of the mill [m]
    corner: FloatArray  # lower left corner of the grid [m], shape (2,)
    cell: float  # side of a cell [m]
    shape: IntArray  # cells along x and y, shape (2,)
    first: IntArray  # first entry of each cell in ``near``, shape (cells + 1,)
    near: IntArray  # pieces that may matter to a place in the cell, in their order


def swept_path(curve: LineArc, radius: float) -> Swept:
    """The pieces of a path and their grid; blocks that go along z only sweep their own place.

    Parameters
    ----------
    curve : LineArc
        The path, rapid moves too [m].
    radius : float
        Of the mill [m].
    """
    rows = [row for i in range(curve.count) for row in _pieces(curve, i, float(curve.knots[i]), radius)]
    table = np.array(rows, dtype=np.float64).reshape(-1, 9)
    low, high = _boxes(table, 2.0 * radius)
    corner = low.min(axis=0)
    extent = float((high.max(axis=0) - corner).max())
    cell = max(radius, extent / _CELLS)
    shape = np.maximum(1, np.ceil((high.max(axis=0) - corner) / cell)).astype(np.int64)
    first, near = _cells(((low - corner) / cell).astype(np.int64), ((high - corner) / cell).astype(np.int64), shape)
    columns = (np.ascontiguousarray(table[:, :2]), np.ascontiguousarray(table[:, 2:4]), *table.T[4:].copy())
    return Swept(*columns, radius, corner, cell, shape, first, near)  # type: ignore[arg-type]


def _pieces(curve: LineArc, i: int, way: float, radius: float) -> list[tuple[float, ...]]:
    """Rows (start, along, curvature, flat length, height, way, way length) of one block."""
    length = float(curve.length[i])
    plain = curve.sharpness[i] == 0.0
    upright = abs(curve.along[i, 0] * curve.inward[i, 1] - curve.along[i, 1] * curve.inward[i, 0])
    bent = not curve.straight[i]
    ends = at_blocks(curve, np.array([i, i]), np.array([0.0, length]))[0]
    rise = abs(float(ends[1, 2] - ends[0, 2]))
    if np.hypot(*(ends[1] - ends[0])[:2]) < 1e-12 and not bent:  # along z: the place is clear down to its lowest point
        return [(*ends[0, :2], 1.0, 0.0, 0.0, 0.0, ends[:, 2].min(), way, length)]
    count = max(1, math.ceil(rise / (_RAMP * radius))) if rise > 1e-9 else 1
    if bent and not (plain and upright > 0.999):  # neither line nor arc of the plane
        count = max(count, math.ceil(length * math.sqrt(float(curve.curvature[i]) / (8.0 * _CHORD))))
        bent = False
    at = np.linspace(0.0, length, count + 1)
    point, tangent = at_blocks(curve, np.full(count + 1, i), at)
    rows = []
    for k in range(count):
        height = max(point[k, 2], point[k + 1, 2])
        step = point[k + 1, :2] - point[k, :2]
        if bent:
            flat = float(curve.share[i]) * (at[k + 1] - at[k])
            direction = tangent[k, :2] / max(float(np.hypot(*tangent[k, :2])), 1e-300)
            side = math.copysign(1.0, curve.along[i, 0] * curve.inward[i, 1] - curve.along[i, 1] * curve.inward[i, 0])
            turn = side / float(curve.radius[i])
        else:
            flat, turn = float(np.hypot(*step)), 0.0
            direction = step / flat if flat > 0.0 else np.array([1.0, 0.0])
        rows.append((*point[k, :2], *direction, turn, flat, height, way + at[k], at[k + 1] - at[k]))
    return rows


def _boxes(table: FloatArray, reach: float) -> tuple[FloatArray, FloatArray]:
    """Least and greatest corner of each piece, widened by a reach [m]."""
    start, along, turn, length = table[:, :2], table[:, 2:4], table[:, 4:5], table[:, 5:6]
    bent = turn[:, 0] != 0.0
    end = start + along * length
    low, high = np.minimum(start, end), np.maximum(start, end)
    radius = 1.0 / np.where(bent, turn[:, 0], 1.0)[:, None]
    centre = start + radius * np.column_stack((-along[:, 1], along[:, 0]))
    low[bent], high[bent] = (centre - np.abs(radius))[bent], (centre + np.abs(radius))[bent]
    return low - reach, high + reach


def _cells(low: IntArray, high: IntArray, shape: IntArray) -> tuple[IntArray, IntArray]:
    """Pieces of each cell, as starts and one list."""
    spans = np.clip(high, 0, shape - 1) - low + 1
    counts = np.zeros(int(shape.prod()) + 1, dtype=np.int64)
    near = np.empty(int(spans.prod(axis=1).sum()), dtype=np.int64)
    _fill_cells(low, np.clip(high, 0, shape - 1), shape, counts, near)
    return counts, near


@compiled
def _fill_cells(low: IntArray, high: IntArray, shape: IntArray, counts: IntArray, near: IntArray) -> None:
    for j in range(low.shape[0]):
        for cx in range(low[j, 0], high[j, 0] + 1):
            for cy in range(low[j, 1], high[j, 1] + 1):
                counts[cx * shape[1] + cy + 1] += 1
    for c in range(counts.shape[0] - 1):
        counts[c + 1] += counts[c]
    place = counts[:-1].copy()
    for j in range(low.shape[0]):
        for cx in range(low[j, 0], high[j, 0] + 1):
            for cy in range(low[j, 1], high[j, 1] + 1):
                c = cx * shape[1] + cy
                near[place[c]] = j
                place[c] += 1
