r"""A block of material seen along the tool axis: heights at the middles of cells, and which move cut each of them last.

Heights are float32, in blocks of 16 x 16 cells that lie one after another in memory, each with its highest value, so that
a move passes over what is lower than itself (:mod:`cutwise.maths.map_sweep`).
"""

import math
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
Float32Array = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]
Int32Array = npt.NDArray[np.int32]
Cell = TypeVar("Cell", bound=np.generic)

SIDE = 16  # cells along the side of a block
BLOCK = SIDE * SIDE  # cells of a block
RINGS = 2  # of cells round the stock that are cut as if it reached there
STOCK = -1  # id of a cell that nothing has cut
NOTHING = np.float32(-1e30)  # height of a cell outside of the stock
UNIT = 2.0**-40  # [m] of the whole numbers in which heights that are taken off are summed


class Layout(NamedTuple):
    """Where the cells stand."""

    x: float  # least x of the stock [m]
    y: float
    dx: float  # width of a cell [m]
    dy: float
    across: int  # cells of the stock along x
    along: int  # cells of the stock along y
    columns: int  # blocks along x
    rows: int  # blocks along y


class Held(NamedTuple):
    """Intervals of material in columns of cells, where other set-ups have cut too; none: a column is whole."""

    first: IntArray  # first interval of each cell, and their number at the end, shape (cells + 1,); or shape (1,)
    low: FloatArray  # [m], rising within a column
    high: FloatArray


def whole_columns() -> Held:
    """No other set-up has cut."""
    return Held(np.zeros(1, np.int64), np.zeros(0), np.zeros(0))


class HeightMap(NamedTuple):
    """Material left; b blocks, row by row."""

    layout: Layout
    height: Float32Array  # [m], shape (b * 256,)
    cutter: Int32Array  # the move that lowered the cell last, -1 the stock, shape (b * 256,)
    highest: Float32Array  # of each block [m], shape (b,)
    share: Float32Array  # part of the cell that is stock, shape (b * 256,); rings have none
    bottom: FloatArray  # underside of the stock [m], of each cell shape (b * 256,) or of all shape (1,)
    top: Float32Array  # upper side of the stock [m], of each cell shape (b * 256,) or of all shape (1,)
    held: Held  # of cells


def layout(x: tuple[float, float], y: tuple[float, float], grid: float) -> Layout:
    """Cells no larger than the grid that fill a rectangle, and rings of cells round it."""
    across = max(1, math.ceil((x[1] - x[0]) / grid - 1e-9))
    along = max(1, math.ceil((y[1] - y[0]) / grid - 1e-9))
    blocks = [math.ceil((n + 2 * RINGS) / SIDE) for n in (across, along)]
    return Layout(
        x[0], y[0], (x[1] - x[0]) / across, (y[1] - y[0]) / along, across, along, blocks[0], blocks[1]
    )  # fmt: skip


def in_blocks(cells: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
    """Rows of cells of whole blocks, shape (rows * 16, columns * 16), in the order of the blocks; flat."""
    rows, columns = cells.shape[0] // SIDE, cells.shape[1] // SIDE
    return np.ascontiguousarray(cells.reshape(rows, SIDE, columns, SIDE).swapaxes(1, 2)).reshape(-1)


def in_rows(grid: Layout, blocks: npt.NDArray[Cell]) -> npt.NDArray[Cell]:
    """Values of all blocks as rows of the stock's own cells, shape (along, across)."""
    cells = blocks.reshape(grid.rows, grid.columns, SIDE, SIDE).swapaxes(1, 2).reshape(grid.rows * SIDE, -1)
    return cells[RINGS : RINGS + grid.along, RINGS : RINGS + grid.across]


def cell_middles(grid: Layout) -> tuple[FloatArray, FloatArray]:
    """x and y of all cells, rings and what fills the blocks up included [m]."""
    return (  # type: ignore[return-value]
        grid.x + grid.dx * (np.arange(grid.columns * SIDE) - RINGS + 0.5),
        grid.y + grid.dy * (np.arange(grid.rows * SIDE) - RINGS + 0.5),
    )


def height_map(grid: Layout, share: FloatArray, bottom: float | FloatArray, top: float | FloatArray) -> HeightMap:
    """Stock before the first move.

    Parameters
    ----------
    grid : Layout
        Its cells.
    share : array (along, across)
        Part of each cell of the stock that is material.
    bottom, top : float or array (along, across)
        Its lower and upper side [m].
    """
    shape = grid.rows * SIDE, grid.columns * SIDE
    inner = np.s_[RINGS : RINGS + grid.along, RINGS : RINGS + grid.across]
    part = np.zeros(shape, np.float32)
    part[inner] = share
    filled = np.zeros(shape, bool)
    filled[inner] = share > 0.0
    near = _grown(filled, RINGS)
    lids = np.full(shape, NOTHING)
    uppers, lowers = np.zeros(shape), np.zeros(shape)
    uppers[inner], lowers[inner] = top, bottom
    if np.ndim(top):
        uppers, lowers = _spread(uppers, filled, near), _spread(lowers, filled, near)
        lids[near] = uppers[near]
    else:
        lids[near] = top
    height = np.asarray(in_blocks(lids))
    part = np.asarray(in_blocks(part))
    upper = (
        in_blocks(np.where(near, uppers, NOTHING).astype(np.float32)) if np.ndim(top) else np.array([top], np.float32)
    )
    lower = in_blocks(lowers) if np.ndim(bottom) else np.array([bottom], float)
    return HeightMap(
        grid, height, np.full(height.size, STOCK, np.int32), height.reshape(-1, BLOCK).max(axis=1), part,
        np.asarray(lower), np.asarray(upper), whole_columns(),
    )  # fmt: skip


def _grown(filled: npt.NDArray[np.bool_], rings: int) -> npt.NDArray[np.bool_]:
    """A region and the rings of cells round it."""
    for _ in range(rings):
        out = filled.copy()
        out[1:] |= filled[:-1]
        out[:-1] |= filled[1:]
        out[:, 1:] |= out[:, :-1].copy()
        out[:, :-1] |= out[:, 1:].copy()
        filled = out
    return filled


def _spread(values: FloatArray, filled: npt.NDArray[np.bool_], near: npt.NDArray[np.bool_]) -> FloatArray:
    """Values of a region carried on into the rings round it, from the nearest cell beside."""
    out, known = values.copy(), filled.copy()
    for _ in range(RINGS + 1):
        for shift, axis in ((1, 0), (-1, 0), (1, 1), (-1, 1)):
            source, there = np.roll(out, shift, axis), np.roll(known, shift, axis)
            take = near & ~known & there
            out[take] = source[take]
            known |= take
    return out


def volume_of(stock: HeightMap, taken: IntArray | int) -> FloatArray:
    """Volume of heights taken off, given in units of 2**-40 m [m^3]."""
    return np.asarray(taken, float) * (UNIT * stock.layout.dx * stock.layout.dy)


def material(stock: HeightMap) -> float:
    """Volume of what is left [m^3]."""
    depth = np.maximum(stock.height.astype(float) - stock.bottom, 0.0)
    if stock.held.first.size > 1:
        cell = np.repeat(np.arange(stock.height.size), np.diff(stock.held.first))
        depth = np.zeros(stock.height.size)
        np.add.at(depth, cell, np.maximum(np.minimum(stock.held.high, stock.height[cell]) - stock.held.low, 0.0))
    return float((depth * stock.share).sum() * stock.layout.dx * stock.layout.dy)
