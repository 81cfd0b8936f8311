"""The loop over moves whose tool stands beside its planned path: what is known beforehand, and what the force of the cut gives.

At each end of a piece the force, from the stock that is left so far, and the displacement that it gives are brought to fit one
another; between them the tool is led straight.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, stepping
from cutwise.maths.map_levels import room
from cutwise.maths.map_sweep import cut_by
from cutwise.maths.profiles import Cutters
from cutwise.maths.workpiece import Workpiece
from cutwise.physics.engagement.map_fan import Fan, fan_room
from cutwise.physics.engagement.map_rim import Place
from cutwise.process.stock_loop import AHEAD, PIECES, STATION, Run, Teeth, overlap_along, station_at

FloatArray = npt.NDArray[np.float64]

_UPRIGHT = 1e-12
_TRIALS = 6  # looks at the force at one place
_STILL = 1e-8  # [m] of a displacement that fits its force
_PUSH = STATION.index("push_x")


class Yielding(NamedTuple):
    """What moves the tool beside its path; p segments."""

    known: FloatArray  # beforehand, at the start and the end of each segment [m], shape (p, 2, 3)
    terms: FloatArray  # of the place of the tool, for the quadratics of the carrier [-], shape (p, 10)
    carrier: FloatArray  # compliance by these terms [m/N], shape (10, 3, 3)
    tip: FloatArray  # compliance of the tool itself [m/N], shape (3, 3)
    off: FloatArray  # offset at the start and the end of each segment, which is written [m], shape (p, 2, 3)


@stepping
def _gives(yielding: Yielding, segment: int, force: tuple[float, float, float], out: FloatArray) -> None:
    """Displacement of the tip under a force in program axes [m]."""
    for i in range(3):
        out[i] = 0.0
        for j in range(3):
            value = yielding.tip[i, j]
            for t in range(yielding.terms.shape[1]):
                value += yielding.terms[segment, t] * yielding.carrier[t, i, j]
            out[i] += value * force[j]


@stepping
def _row(row: FloatArray, start: FloatArray, end: FloatArray, off: FloatArray) -> None:
    """Write a line of the tip with offsets (2, 3) of its ends, as :func:`cutwise.maths.envelopes.line_row`, into a row."""
    x, y, z = start[0] + off[0, 0], start[1] + off[0, 1], start[2] + off[0, 2]
    dx, dy, dz = end[0] + off[1, 0] - x, end[1] + off[1, 1] - y, end[2] + off[1, 2] - z
    length = math.hypot(dx, dy)
    row[2], row[3], row[4] = x, y, z
    row[5], row[6], row[7], row[8] = 1.0, 0.0, 0.0, 0.0
    if length > _UPRIGHT:
        row[5], row[6], row[7], row[8] = dx / length, dy / length, length, dz / length
    else:
        row[4] = min(z, z + dz)


@stepping
def _pushed(
    piece: Workpiece, teeth: Teeth, run: Run, at: tuple[int, int, int, int], refine: bool, yielding: Yielding, fan: Fan,
    rows: FloatArray, out: tuple[FloatArray, FloatArray],
) -> None:  # fmt: skip
    """Contact at a station of a move, and the displacement that its force gives [m], until they fit one another.

    ``at``: move, segment, the end of it (0 or 1), and the station. ``out``: displacement, which is taken to begin with, and
    room for another.
    """
    solid = piece.solid
    move, segment, end, n = at
    pushed, new = out
    row, first = solid.path.row[segment], solid.path.first[move]
    low, high = run.start[segment], run.end[segment]
    ux, uy, slope = row[5], row[6], row[8]
    if row[7] <= _UPRIGHT:
        slope = -math.inf if high[2] < low[2] else math.inf
    flat = 0.0 if math.isinf(slope) else 1.0 / math.sqrt(1.0 + slope * slope)
    rise = math.copysign(1.0, slope) if math.isinf(slope) else slope * flat
    ahead = 0.0 if end else AHEAD
    tip = high if end else low
    known = yielding.known[segment, end]
    found = run.found[n]
    run.segment[n] = segment
    for _ in range(_TRIALS if n > run.station[move] else 1):  # a tool that began elsewhere would stand in its own way
        if n > run.station[move]:
            before = segment - 1 + end
            off = yielding.off[before]
            for i in range(3):
                off[1, i] = yielding.known[before, 1, i] + pushed[i]
            _row(solid.path.row[before], run.start[before], run.end[before], off)
        place = Place(
            tip[0] + known[0] + pushed[0] + ahead * flat * ux, tip[1] + known[1] + pushed[1] + ahead * flat * uy,
            tip[2] + known[2] + pushed[2] + ahead * rise, ux, uy, slope, segment, first, float(end), move,
        )  # fmt: skip
        station_at(piece, teeth, run, move, place, refine, False, run.speed[n], fan, rows, found)
        fx, fy = found[_PUSH], found[_PUSH + 1]
        _gives(yielding, segment, (fx * ux - fy * uy, fx * uy + fy * ux, found[_PUSH + 2]), new)
        change = math.sqrt((new[0] - pushed[0]) ** 2 + (new[1] - pushed[1]) ** 2 + (new[2] - pushed[2]) ** 2)
        for i in range(3):
            pushed[i] = new[i]
        if change <= _STILL:
            break


@compiled
def run_yielding(
    piece: Workpiece, shanks: Cutters, teeth: Teeth, run: Run, moves: tuple[int, int], looks: tuple[bool, bool],
    yielding: Yielding, pushed: FloatArray,
) -> None:  # fmt: skip
    """Run moves of lines with one tool that yields: force and displacement at both ends of each line, then the sweep.

    Parameters
    ----------
    piece, shanks, teeth, run, moves
        As for :func:`cutwise.process.stock_loop.run_moves`; the rows of the path, and starts and ends of the run, are those of
        the moved tool when it is done. Feed moves have a station at the start of each line, and one at their end.
    looks : tuple of bool
        Whether contact is looked at, and whether the ends of arcs are refined.
    yielding : Yielding
        What moves the tool; ``off`` is written.
    pushed : array (3,)
        Displacement by the force at the start [m]; changed.
    """
    solid = piece.solid
    fan, rows, work = fan_room(), np.empty((PIECES, 5)), room(solid.map.layout)
    look, refine = looks
    out = (pushed, np.empty(3))
    for move in range(moves[0], moves[1]):
        first, last = solid.path.first[move], solid.path.first[move + 1]
        tool = int(solid.path.row[first, 1])
        cuts, n = look and not run.rapid[move], run.station[move]
        if cuts:
            _pushed(piece, teeth, run, (move, first, 0, n), refine, yielding, fan, rows, out)
        else:
            for i in range(3):
                pushed[i] = 0.0
        for segment in range(first, last):
            off, start, end = yielding.off[segment], run.start[segment], run.end[segment]
            row = solid.path.row[segment]
            for i in range(3):
                off[0, i] = yielding.known[segment, 0, i] + pushed[i]
            if cuts:
                n += 1
                if segment + 1 < last:
                    _pushed(piece, teeth, run, (move, segment + 1, 0, n), refine, yielding, fan, rows, out)
                else:
                    _pushed(piece, teeth, run, (move, segment, 1, n), refine, yielding, fan, rows, out)
            for i in range(3):
                off[1, i] = yielding.known[segment, 1, i] + pushed[i]
            _row(row, start, end, off)
            for i in range(3):
                start[i] += off[0, i]
                end[i] += off[1, i]
        if run.rapid[move]:
            overlap_along(solid.map, solid, solid.tools, move, run.through[move], work)
        run.taken[move] = cut_by(solid.map, solid.path, solid.tools, move, work)
        if shanks.first[tool + 1] > shanks.first[tool]:
            overlap_along(solid.map, solid, shanks, move, run.hit[move], work)
