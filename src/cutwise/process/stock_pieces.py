"""The moves of a program as short lines, whose ends a moved tool may stand beside: what is swept where drives and structure yield.

A line of the tip whose ends are off by w stays a line; between them the true w is missed by no more than
:math:`\\max|w''| \\Delta s^2 / 8`. Lines are halved until what is known of w beforehand is followed within a given distance.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.envelopes import LINE, Segments
from cutwise.process.stock_path import TOGETHER, Moves, line_rows, tips

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_HALVINGS = 8
_REACH = 3.0  # cells: the length of pieces that go together as one move


class Known(NamedTuple):
    """What moves the tool beside its path and is known beforehand, at places of the path in their order."""

    along: FloatArray  # [m], not falling, shape (m,)
    off: FloatArray  # [m], shape (m, 3)

    def at(self, along: FloatArray) -> FloatArray:
        """At other places, straight between [m], shape (n, 3)."""
        return np.column_stack([np.interp(along, self.along, one) for one in self.off.T])


class _Cut(NamedTuple):
    """Shares of segments."""

    segment: IntArray
    low: FloatArray
    high: FloatArray


def pieces_of(moves: Moves, station: float, sagitta: float, cell: float, known: Known | None) -> tuple[Moves, float]:
    """Moves as lines no longer than a station, arcs within a sagitta; lines of one move that follow one another go together.

    Besides, how far known offsets are from straight between the ends of a line at the most [m].

    Parameters
    ----------
    moves : Moves
        As they are planned.
    station : float
        Largest length of a line [m].
    sagitta : float
        How far a line may stand off the arc, or off the known offsets between its ends [m].
    cell : float
        Width of the cells of the map [m].
    known : Known, optional
        Offsets of the tool.
    """
    cut, between = _halved(moves, _even(moves, station, sagitta), known, sagitta)
    start, end = tips(moves, cut.segment, cut.low), tips(moves, cut.segment, cut.high)
    of = np.repeat(np.arange(moves.number), np.diff(moves.path.first))[cut.segment]
    way = np.linalg.norm(end - start, axis=1)
    begins = _begins(of, way, _REACH * cell)
    first = np.append(np.flatnonzero(begins), of.size).astype(np.int64)
    move = of[first[:-1]]
    span = np.diff(moves.along, axis=1)[cut.segment, 0]
    from_ = moves.along[cut.segment, 0]
    pieces = Moves(
        Segments(line_rows(moves.tool[of], start, end), first), start, end, way,
        from_[:, None] + span[:, None] * np.column_stack([cut.low, cut.high]), moves.block[cut.segment], moves.tool[move],
        moves.rapid[move], moves.feed[move], moves.spindle[move], moves.line[move], moves.last_line[move],
    )  # fmt: skip
    return pieces, between


def _even(moves: Moves, station: float, sagitta: float) -> _Cut:
    """Even parts of every segment."""
    row = moves.path.row
    parts = np.maximum(1, np.ceil(moves.way / station - 1e-9)).astype(np.int64)
    arc = row[:, 0] != LINE
    widest = 2.0 * np.arccos(np.maximum(1.0 - sagitta / np.maximum(row[arc, 7], 1e-12), -0.5))
    parts[arc] = np.maximum(parts[arc], np.ceil(np.abs(row[arc, 14]) / widest - 1e-9).astype(np.int64))
    segment = np.repeat(np.arange(parts.size), parts)
    number = np.arange(segment.size) - np.repeat(np.cumsum(parts) - parts, parts)
    return _Cut(segment, number / parts[segment], (number + 1) / parts[segment])


def _halved(moves: Moves, cut: _Cut, known: Known | None, allowed: float) -> tuple[_Cut, float]:
    """Halve pieces between whose ends known offsets are farther from straight than allowed [m]."""
    if known is None:
        return cut, 0.0
    begin, span = moves.along[:, 0], np.diff(moves.along, axis=1)[:, 0]
    for halving in range(_HALVINGS + 1):
        low = begin[cut.segment] + cut.low * span[cut.segment]
        high = begin[cut.segment] + cut.high * span[cut.segment]
        piece = np.clip(np.searchsorted(low, known.along, side="right") - 1, 0, low.size - 1)
        share = np.clip((known.along - low[piece]) / np.maximum(high[piece] - low[piece], 1e-30), 0.0, 1.0)
        a, b = known.at(low), known.at(high)
        off = np.linalg.norm(known.off - a[piece] - share[:, None] * (b - a)[piece], axis=1)
        worst = np.zeros(low.size)
        np.maximum.at(worst, piece, np.where((share > 0.0) & (share < 1.0), off, 0.0))
        wide = worst > allowed
        if not wide.any() or halving == _HALVINGS:
            break
        times = np.where(wide, 2, 1)
        second = np.arange(int(times.sum())) - np.repeat(np.cumsum(times) - times, times)
        middle = np.repeat(0.5 * (cut.low + cut.high), times)
        segment, split = np.repeat(cut.segment, times), np.repeat(wide, times)
        cut = _Cut(
            segment, np.where(split & (second == 1), middle, np.repeat(cut.low, times)),
            np.where(split & (second == 0), middle, np.repeat(cut.high, times)),
        )  # fmt: skip
    return cut, float(worst.max(initial=0.0))


def _begins(move: IntArray, way: FloatArray, reach: float) -> npt.NDArray[np.bool_]:
    """Which pieces begin a move of their own: no more than some go together, within a reach."""
    new = np.concatenate(([True], np.diff(move) != 0))
    before = np.cumsum(way) - way
    group = np.cumsum(new) - 1
    within = before - before[new][group]
    number = np.arange(move.size) - np.flatnonzero(new)[group]
    bin_ = np.maximum(np.floor(within / reach), number // TOGETHER)
    return np.asarray(new | np.concatenate(([True], np.diff(bin_) != 0)))
