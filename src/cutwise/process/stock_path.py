"""The path of a program as what sweeps a stock in 3D: lines, level arcs and straight plunges, in moves with ids.

Arcs stay arcs where they are level; helices, arcs of other planes and clothoids become chords, which stay one move. Chords so
short that none of them would own a cell of the map go together as one move too: looked up is the least over all of a move.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.envelopes import COLUMNS, LINE, Segments, arc_row
from cutwise.maths.linearc import LineArc, at_blocks
from cutwise.process.program_path import ProgramPath

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

_LEVEL = 1e-9  # of a direction: less is level
_UPRIGHT = 1e-12  # [m] in the plane
TOGETHER = 24  # chords of one move at the most
_REACH = 3.0  # cells: the length of short chords that go together


class Moves(NamedTuple):
    """Moves in their order, ``m`` of them, of ``n`` segments."""

    path: Segments
    start: FloatArray  # tip at the start of each segment [m], shape (n, 3)
    end: FloatArray  # shape (n, 3)
    way: FloatArray  # length of each segment [m], shape (n,)
    along: FloatArray  # place on the program's path at the start and the end of each segment [m], shape (n, 2)
    block: IntArray  # block of the program's path that each segment comes from, shape (n,)
    tool: IntArray  # row of the tools of each move, shape (m,)
    rapid: BoolArray  # shape (m,)
    feed: FloatArray  # [m/s], infinite for rapid moves, shape (m,)
    spindle: FloatArray  # [rad/s], shape (m,)
    line: IntArray  # first line of the program of each move, shape (m,)
    last_line: IntArray  # shape (m,)

    @property
    def number(self) -> int:
        """How many moves there are."""
        return int(self.path.first.size - 1)


def level_arcs(curve: LineArc) -> BoolArray:
    """Which blocks are level arcs."""
    flat = (np.abs(curve.along[:, 2]) < _LEVEL) & (np.abs(curve.inward[:, 2]) < _LEVEL)
    level = (np.abs(curve.climb) < _LEVEL).all(axis=1)
    return np.asarray(flat & level & np.isfinite(curve.radius) & (curve.sharpness == 0.0))


def moves_of(path: ProgramPath, tool: IntArray, feed: FloatArray, sagitta: float, cell: float) -> Moves:
    """Moves and segments of a path.

    Parameters
    ----------
    path : ProgramPath
        The path of a program, its blends included.
    tool : array (blocks,)
        Row of the tools of each block.
    feed : array (blocks,)
        Speed that each block is run at [m/s]; rapid blocks are those of the path.
    sagitta : float
        Largest distance of chords from the curves that they stand for [m].
    cell : float
        Width of the cells of the map [m].
    """
    curve, rapid = path.curve, np.isinf(path.feed)
    arc = level_arcs(curve)
    curved = ~curve.straight & ~arc
    pieces = np.ones(curve.count, np.int64)
    pieces[curved] = _chords(curve, sagitta)[curved]
    block = np.repeat(np.arange(curve.count), pieces)
    number = np.arange(block.size) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    share = curve.length[block] / pieces[block]
    start, _ = at_blocks(curve, block, share * number)
    end, _ = at_blocks(curve, block, share * (number + 1))
    rows = line_rows(tool[block], start, end)
    for n in np.flatnonzero(arc[block]):
        rows[n] = _arc(curve, int(block[n]), int(tool[block[n]]))
    short = (curve.straight & (curve.length < _REACH * cell)) | (pieces > 1)
    alike = np.flatnonzero(_begins(path, tool, feed, short, pieces, _REACH * cell))
    first = np.append((np.cumsum(pieces) - pieces)[alike], block.size).astype(np.int64)
    last = np.append(alike[1:], curve.count) - 1
    way = np.where(arc[block], curve.length[block], np.linalg.norm(end - start, axis=1))
    along = curve.knots[block][:, None] + np.column_stack([share * number, share * (number + 1)])
    return Moves(
        Segments(rows, first), start, end, way, along, block, tool[alike], rapid[alike], feed[alike],
        np.abs(path.spindle[alike]), path.source[alike], path.source[last],
    )  # fmt: skip


def _begins(
    path: ProgramPath, tool: IntArray, feed: FloatArray, short: BoolArray, pieces: IntArray, reach: float
) -> BoolArray:
    """Which blocks begin a move: all but short ones that go on from short ones of the same tool, feed and spindle."""
    begins = np.ones(path.curve.count, bool)
    same = short[1:] & short[:-1] & (pieces[1:] == 1) & (pieces[:-1] == 1)
    for of in (tool, feed, path.spindle, path.feed):
        same &= of[1:] == of[:-1]
    length, count = 0.0, 1
    lengths, going = path.curve.length, same.tolist()
    for i, goes_on in enumerate(going, start=1):
        if goes_on and count < TOGETHER and length + lengths[i] <= reach:
            begins[i] = False
            length, count = length + lengths[i], count + 1
        else:
            length, count = lengths[i], 1
    return begins


def _chords(curve: LineArc, sagitta: float) -> IntArray:
    """Chords of every block whose distance from it is no more than a sagitta."""
    bend = np.maximum(curve.curvature, curve.share**2 / curve.radius)
    widest = 2.0 * np.arccos(np.maximum(1.0 - sagitta * bend, -0.5))
    count = np.ceil(curve.length * bend / np.where(bend > 0.0, widest, 1.0) - 1e-9)
    return np.asarray(np.maximum(np.where(bend > 0.0, count, 1.0), 1.0).astype(np.int64))


def line_rows(tool: IntArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Rows of lines of the tip from (n, 3) to (n, 3) [m], as :func:`cutwise.maths.envelopes.line_row` makes them."""
    rows = np.zeros((len(start), COLUMNS))
    step = end - start
    flat = np.hypot(step[:, 0], step[:, 1])
    upright = flat <= _UPRIGHT
    rows[:, 0], rows[:, 1], rows[:, 2:5], rows[:, 5] = LINE, tool, start, 1.0
    rows[upright, 4] = np.minimum(start[upright, 2], end[upright, 2])
    lies = ~upright
    rows[lies, 5:7] = step[lies, :2] / flat[lies, None]
    rows[lies, 7], rows[lies, 8] = flat[lies], step[lies, 2] / flat[lies]
    return rows


def _arc(curve: LineArc, i: int, tool: int) -> list[float]:
    """Row of a level arc."""
    centre = curve.start[i] + curve.radius[i] * curve.inward[i]
    along, inward = curve.along[i], curve.inward[i]
    left = along[0] * inward[1] - along[1] * inward[0] > 0.0
    sweep = curve.length[i] / curve.radius[i] * (1.0 if left else -1.0)
    return arc_row(
        tool, centre, float(curve.start[i, 2]), float(curve.radius[i]), math.atan2(-inward[1], -inward[0]), float(sweep)
    )


def tips(moves: Moves, segment: IntArray, share: FloatArray) -> FloatArray:
    """Tip at shares of segments [m], shape (n, 3)."""
    start, end, row = moves.start[segment], moves.end[segment], moves.path.row[segment]
    point = start + share[:, None] * (end - start)
    point[share == 1.0] = end[share == 1.0]
    arc = (row[:, 0] != LINE) & (share != 0.0) & (share != 1.0)
    angle = row[arc, 13] + share[arc] * row[arc, 14]
    point[arc, 0] = row[arc, 2] + row[arc, 7] * np.cos(angle)
    point[arc, 1] = row[arc, 3] + row[arc, 7] * np.sin(angle)
    return np.asarray(point)
