"""The cells of a path: equal parts of its moves, each with what the mill meets there and whether its walls stay."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.linearc import LineArc, at_blocks
from cutwise.physics.engagement.path_sweep import Swept, swept_path
from cutwise.physics.engagement.stock import contact_patches, stands_in_material
from cutwise.physics.engagement.surviving import surviving
from cutwise.physics.engagement.wall import path_contact, wall_patches
from cutwise.process.program_path import ProgramPath
from cutwise.process.stock_moves import FLAT, stock_of
from cutwise.spec.milling import MillingScenario
from cutwise.spec.program import StockBlock

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

_TOUCH = 8.7e-3  # [rad] of contact of a plunge that counts
_SHAVED = 1e-6  # [m] by which a later move has to reach over a wall for it to be gone
_ABOVE = 1e-6  # [m] above the tip, where it is asked


class Cells(NamedTuple):
    """Parts of the moves of a path in their order, ``n`` of them."""

    block: IntArray  # block of the path, shape (n,)
    begin: FloatArray  # where it begins on its block [m], shape (n,)
    length: FloatArray  # [m], shape (n,)
    way: FloatArray  # arc length of the path in its middle [m], shape (n,)
    heading: FloatArray  # [rad], shape (n,)
    flat: FloatArray  # what of its direction lies in the plane, shape (n,)
    patches: FloatArray  # contact as of ``contact_patches``, shape (n, p, 4)
    walls: FloatArray  # 1 where the wall on the right, on the left stays, shape (n, 2)
    plunges: BoolArray  # straight down into the stock, shape (n,)
    cuts: BoolArray  # which meet material, shape (n,)

    @property
    def size(self) -> int:
        """Number of cells."""
        return self.length.size


class Shape(NamedTuple):
    """The first columns of :class:`Cells`: what of them is the path alone."""

    block: IntArray
    begin: FloatArray
    length: FloatArray
    way: FloatArray
    heading: FloatArray
    flat: FloatArray


def cut_into_cells(curve: LineArc, station: float) -> Shape:
    """Equal parts of every block, no longer than a station [m]."""
    count = np.maximum(1, np.ceil(curve.length / station - 1e-9)).astype(np.int64)
    block = np.repeat(np.arange(curve.count), count)
    number = np.arange(block.size) - np.repeat(np.cumsum(count) - count, count)
    length = curve.length[block] / count[block]
    begin = number * length
    _, direction = at_blocks(curve, block, begin + 0.5 * length)
    way = curve.knots[block] + begin + 0.5 * length
    heading = np.arctan2(direction[:, 1], direction[:, 0])
    return Shape(block, begin, length, way, heading, np.hypot(direction[:, 0], direction[:, 1]))


def cells_of(scenario: MillingScenario, path: ProgramPath, station: float) -> Cells:
    """Cut every block of a path into equal cells no longer than a station [m], and look at the middle of each.

    With a stock, what all earlier moves and this one up to there have left; without one, the previous pass offset by the
    radial depth.
    """
    curve = path.curve
    shape = cut_into_cells(curve, station)
    block, begin, length, way, heading, flat = shape
    point, _ = at_blocks(curve, block, begin + 0.5 * length)
    idle = (flat < FLAT) | np.isinf(path.feed[block])
    radius = 0.5 * scenario.tool.diameter
    if isinstance(scenario.stock, StockBlock):
        swept = swept_path(curve, radius)
        patches = contact_patches(point, heading, way, swept, stock_of(scenario.stock))
        patches[idle] = 0.0
        walls = np.zeros((block.size, 2))
        cuts = _meets(patches)
        met = np.flatnonzero(cuts)
        for side, turn in enumerate((-0.5 * math.pi, 0.5 * math.pi)):
            rim = point[met].copy()
            rim[:, 0] += radius * np.cos(heading[met] + turn)
            rim[:, 1] += radius * np.sin(heading[met] + turn)
            rim[:, 2] += _ABOVE
            walls[met, side] = surviving(rim, way[met], swept, _SHAVED)
        down = _plunges(scenario.stock, path, block, begin + length, flat, swept)
        return Cells(*shape, patches, walls, down, cuts)
    operation = scenario.operation
    assert operation.radial_depth is not None
    assert operation.axial_depth is not None
    arcs = path_contact(curve, path.cuts, block, way, radius, operation.radial_depth)
    patches = wall_patches(arcs, operation.axial_depth)
    patches[idle] = 0.0
    walls = np.zeros((block.size, 2))
    walls[:, 0] = 1.0  # the wall that is climbed along is what is to be left
    return Cells(*shape, patches, walls, np.zeros(block.size, bool), _meets(patches))


def _meets(patches: FloatArray) -> BoolArray:
    return np.asarray((patches[..., 1] > patches[..., 0]).any(axis=1))


def _plunges(
    block_of_stock: StockBlock, path: ProgramPath, block: IntArray, end: FloatArray, flat: FloatArray, swept: Swept
) -> BoolArray:
    """Cells of feed moves straight down whose rim, or middle, is in the stock."""
    curve = path.curve
    down = np.flatnonzero((flat < FLAT) & (curve.along[block, 2] < 0.0) & ~np.isinf(path.feed[block]))
    out = np.zeros(block.size, bool)
    if down.size:
        tip = curve.start[block[down]] + curve.along[block[down]] * end[down, None]
        below = tip[:, 2] < block_of_stock.z[1] - 1e-9
        touched = stands_in_material(tip, curve.knots[block[down]], swept, stock_of(block_of_stock))
        out[down] = below & (touched > _TOUCH)
    return out
