"""Moves of a program that run into its stock as they should not: rapid moves through it, and plunges."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.curves import FloatArray
from cutwise.maths.linearc import LineArc, at_blocks
from cutwise.physics.engagement.path_sweep import Swept
from cutwise.physics.engagement.stock import Stock, block_stock, contact_patches, immersion, stands_in_material
from cutwise.programs.block_text import blocks_named
from cutwise.results import Finding, Place, warned
from cutwise.spec.program import StockBlock

if TYPE_CHECKING:
    from cutwise.process.program_path import ProgramPath

IntArray = npt.NDArray[np.int64]

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
    ramps: tuple[int, ...] = ()  # of feed moves that go down at a slope in it


def moves_into_stock(path: ProgramPath, swept: Swept, stock: Stock) -> StockMoves:
    """Look at all rapid moves and all moves straight down, with what the moves before them have left."""
    curve, rapid, source = path.curve, np.isinf(path.feed), path.source
    upright = curve.straight & (np.hypot(curve.along[:, 0], curve.along[:, 1]) < FLAT)
    down = upright & (curve.along[:, 2] < 0.0)
    into = _goes_down(curve, np.flatnonzero(down), swept, stock)
    through = _goes_through(curve, np.flatnonzero(rapid & ~upright & ~_out_of_the_cut(curve, rapid)), swept, stock)
    hit = np.concatenate((into[rapid[into]], through))
    return StockMoves(_lines(source[hit]), _lines(source[into[~rapid[into]]]))


def _out_of_the_cut(curve: LineArc, rapid: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Rapid blocks that round a corner with a feed move: within its tolerance they take what the feed move left there.

    Rapid moves are straight, so that one that bends belongs to a blend; so do the bends next to it.
    """
    bends = ~curve.straight
    run = np.cumsum(~bends | ~np.append(False, bends[:-1]))
    feeds = np.zeros(int(run[-1]) + 1 if run.size else 1, dtype=bool)
    feeds[run[bends & ~rapid]] = True
    return bends & rapid & feeds[run]


def _places(curve: LineArc, blocks: IntArray, radius: float) -> tuple[IntArray, FloatArray]:
    """Blocks of places close to one another along given blocks, and the way along them [m]."""
    count = np.maximum(1, np.ceil(curve.length[blocks] / (_STEP * radius))).astype(np.int64) + 1
    block, number = np.repeat(blocks, count), np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
    return block, curve.length[block] * number / (np.repeat(count, count) - 1)


def _goes_down(curve: LineArc, blocks: IntArray, swept: Swept, stock: Stock) -> IntArray:
    """Those of the blocks straight down that meet material."""
    block, along = _places(curve, blocks, swept.radius)
    point, _ = at_blocks(curve, block, along)
    near = point[:, 2] < stock.top
    block, point = block[near], point[near]
    met = stands_in_material(point, curve.knots[block], swept, stock)
    return np.unique(block[met > _TOUCH])


def _goes_through(curve: LineArc, blocks: IntArray, swept: Swept, stock: Stock) -> IntArray:
    """Those of the blocks that meet material ahead of the mill."""
    block, along = _places(curve, blocks, swept.radius)
    point, direction = at_blocks(curve, block, along)
    near = point[:, 2] < stock.top
    block, point, direction, way = block[near], point[near], direction[near], (curve.knots[block] + along)[near]
    heading = np.arctan2(direction[:, 1], direction[:, 0])
    return np.unique(block[immersion(contact_patches(point, heading, way, swept, stock)) > _TOUCH])


def _lines(source: IntArray) -> tuple[int, ...]:
    return tuple(int(line) for line in np.unique(source))


def said(moves: StockMoves, text: str, *, bottom: bool = False) -> Iterator[Finding]:
    """The warnings; the text of the program names its blocks; ``bottom``: plunges have a force."""
    if moves.collisions:
        named = blocks_named(text, moves.collisions)
        yield warned(
            "rapids_collide", f"rapid moves run through the stock: {named}", where=Place(line=moves.collisions[0])
        )
    if moves.plunges and not bottom:
        named = blocks_named(text, moves.plunges)
        words = f"plunges straight into the stock have no force here (end cutting is not modelled): {named}"
        yield warned("plunges", words, where=Place(line=moves.plunges[0]))
    if moves.ramps:
        named = blocks_named(text, moves.ramps)
        words = (
            f"ramps into the stock have no force at the end of the mill, and no volume of it, here: {named} (a stock in 3D has "
            "both: write the mill under tools)"
        )
        yield warned("ramps", words, where=Place(line=moves.ramps[0]))


def collisions(lines: tuple[int, ...]) -> Iterator[Finding]:
    """Rapid moves through the stock, by their program lines."""
    if lines:
        yield Finding("collides", Place(line=lines[0]), float(len(lines)), 0.0)
