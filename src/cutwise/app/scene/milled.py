"""The block that a mill with drives cuts: a height map swept along the samples, and the error of its walls."""

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene.scene import FloatArray, IntArray, Map
from cutwise.maths.envelopes import line_row, segments
from cutwise.maths.height_map import height_map, in_rows, layout
from cutwise.maths.map_levels import room
from cutwise.maths.map_sweep import cut_by
from cutwise.maths.profiles import cutters, flat

if TYPE_CHECKING:
    from cutwise.spec.program import StockBlock

CELLS = 500_000  # about so many cells of a map
_FOOT = 400  # samples to either side among which the foot of a wall is looked for


def block_map(stock: "StockBlock", place: FloatArray, radius: float, error: FloatArray, coloured: str) -> Map:
    """The block after the last sample; cells at the foot of a wall have the error of the sample that passed there.

    Parameters
    ----------
    stock : StockBlock
        Sizes of the block [m].
    place : array, shape (n, 3)
        Tip of a flat mill at each sample [m].
    radius : float
        Of the mill [m].
    error : array, shape (n,)
        Error of the wall at each sample [m]; NaN where none is left.
    coloured : str
        The history whose colours the cells take.
    """
    (x0, x1), (y0, y1), (bottom, top) = stock.x, stock.y, stock.z
    grid = layout((x0, x1), (y0, y1), float(np.sqrt((x1 - x0) * (y1 - y0) / CELLS)))
    solid = height_map(grid, np.ones((grid.along, grid.across)), bottom, top)
    steps = _steps(place, 0.5 * grid.dx)
    rows = [line_row(0, place[a], place[b]) for a, b in pairwise(steps)]
    path, tool, work = segments(rows, [1] * len(rows)), cutters([flat(radius)]), room(grid)
    for move in range(len(rows)):
        cut_by(solid, path, tool, move, work)
    height = in_rows(grid, solid.height).astype(float)
    cutter = in_rows(grid, solid.cutter)
    owner = np.where(cutter >= 0, steps[np.maximum(cutter, 0) + 1], -1)
    height = np.where(height <= bottom, np.nan, height)
    x, y = x0 + grid.dx * (np.arange(grid.across) + 0.5), y0 + grid.dy * (np.arange(grid.along) + 0.5)
    values = _walls(height, owner, np.stack(np.meshgrid(x, y), axis=2), place, error, radius, grid.dx)
    return Map(x0, y0, grid.dx, grid.dy, height, top, bottom, values, coloured, owner)


def _steps(place: FloatArray, step: float) -> IntArray:
    """Samples with at least a step of way between them, where the height changes always; the first and the last too."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(place, axis=0), axis=1))])
    number = np.floor(way / step)
    keep = np.flatnonzero(np.diff(number) > 0) + 1
    turned = np.flatnonzero(np.diff(place[:, 2], n=2) != 0.0) + 1  # where a plunge begins or ends
    return np.unique(np.concatenate([[0], keep, turned, [place.shape[0] - 1]])).astype(np.int64)


def _walls(
    height: FloatArray,
    owner: IntArray,
    middle: FloatArray,
    place: FloatArray,
    error: FloatArray,
    radius: float,
    cell: float,
) -> FloatArray:
    """Error of the cells beside a step of the height; NaN everywhere else."""
    solid = np.where(np.isnan(height), -np.inf, height)
    higher = np.full(height.shape, -np.inf)
    for axis in (0, 1):
        for shift in (1, -1):
            beside = np.roll(solid, shift, axis)
            edge = np.s_[0, :] if axis == 0 else np.s_[:, 0]
            if shift < 0:
                edge = np.s_[-1, :] if axis == 0 else np.s_[:, -1]
            beside[edge] = -np.inf
            higher = np.maximum(higher, beside)
    foot = np.argwhere((owner >= 0) & (higher > solid + cell))
    values = np.full(height.shape, np.nan)
    for row, column in foot:
        at = int(owner[row, column])
        near = slice(max(0, at - _FOOT), at + _FOOT + 1)
        away = np.hypot(*(place[near, :2] - middle[row, column]).T)
        away = np.where(np.isnan(error[near]) | (away > radius + cell), np.inf, away)
        best = int(away.argmin())
        if np.isfinite(away[best]):
            values[row, column] = error[near][best]
    return values
