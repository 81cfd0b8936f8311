"""Moves of a program that run into its stock as they should not: rapid moves through it, and plunges."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from cutwise.io.programs.block_text import blocks_named
from cutwise.maths.curves import FloatArray
from cutwise.maths.linearc import LineArc, at_blocks
from cutwise.physics.engagement.path_sweep import Swept
from cutwise.physics.engagement.stock import Stock, block_stock, contact_patches, immersion, stands_in_material
from cutwise.process.program_path import ProgramPath
from cutwise.spec.program import StockBlock

FLAT = 1e-6  # a direction of feed with less than this in the plane goes straight up or down
_TOUCH = math.radians(0.5)  # contact that counts
_STEP = 0.125  # of the mill radius: how close the places are that are looked at


def stock_of(given: StockBlock, zero: Sequence[float] = (0.0, 0.0, 0.0)) -> Stock:
    """The block as a record, its coordinates shifted by ``zero`` [m]."""
    x, y, z = (
        (low + shift, high + shift) for (low, high), shift in zip((given.x, given.y, given.z), zero, strict=True)
    )
    return block_stock(x, y, z[1], z[0])


class StockMoves(NamedTuple):
    """Lines of a program."""

    collisions: tuple[int, ...] = ()  # of rapid moves through the stock
    plunges: tuple[int, ...] = ()  # of feed moves straight down into it


def moves_into_stock(path: ProgramPath, swept: Swept, stock: Stock) -> StockMoves:
    """Look at all rapid moves and all moves straight down, with what the moves before them have left."""
    curve, rapid = path.curve, np.isinf(path.feed)
    hit, plunged = [], []
    for i in np.flatnonzero(rapid | curve.straight):
        upright = bool(curve.straight[i] and np.hypot(*curve.along[i, :2]) < FLAT)
        if upright and curve.along[i, 2] < 0.0:
            if _goes_down(curve, int(i), swept, stock):
                (hit if rapid[i] else plunged).append(path.source[i])
        elif rapid[i] and not upright and _goes_through(curve, int(i), swept, stock):
            hit.append(path.source[i])
    return StockMoves(_lines(hit), _lines(plunged))


def _places(curve: LineArc, i: int, radius: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Way along the block [m], points [m] and directions."""
    count = max(1, math.ceil(float(curve.length[i]) / (_STEP * radius)))
    along = np.linspace(0.0, float(curve.length[i]), count + 1)
    return along, *at_blocks(curve, np.full(count + 1, i), along)


def _goes_down(curve: LineArc, i: int, swept: Swept, stock: Stock) -> bool:
    _, point, _ = _places(curve, i, swept.radius)
    before = np.full(len(point), curve.knots[i])
    return bool((stands_in_material(point, before, swept, stock) > _TOUCH).any())


def _goes_through(curve: LineArc, i: int, swept: Swept, stock: Stock) -> bool:
    along, point, direction = _places(curve, i, swept.radius)
    heading = np.arctan2(direction[:, 1], direction[:, 0])
    return bool((immersion(contact_patches(point, heading, curve.knots[i] + along, swept, stock)) > _TOUCH).any())


def _lines(source: list[np.int64]) -> tuple[int, ...]:
    return tuple(sorted({int(line) for line in source}))


def said(moves: StockMoves, text: str) -> Iterator[str]:
    """The warnings; the text of the program names its blocks."""
    if moves.collisions:
        yield f"rapid moves run through the stock: {blocks_named(text, moves.collisions)}"
    if moves.plunges:
        named = blocks_named(text, moves.plunges)
        yield f"plunges straight into the stock have no force here (end cutting is not modelled): {named}"
