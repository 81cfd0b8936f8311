"""What a run in a stock in 3D found, place by place and event by event."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.curves import FloatArray
from cutwise.maths.envelopes import LINE
from cutwise.process.stock_milling import StockRunDone
from cutwise.process.stock_path import tips

IntArray = npt.NDArray[np.int64]

_TOUCH = 1e-6  # [m] deep: a shallower overlap is rounding


class Event(NamedTuple):
    """Something that a line of the program does to what it should leave alone."""

    kind: str  # rapid, shank, fixture, core
    line: int
    depth: float  # [m]
    volume: float  # [m^3]
    place: tuple[float, float, float]  # [m]
    time: float  # [s] when the move begins


def events(done: StockRunDone) -> list[Event]:
    """One event for each kind and line, the deepest of its moves."""
    found: dict[tuple[str, int], Event] = {}
    for kind, table in (("rapid", done.run.through), ("shank", done.run.hit), ("fixture", done.fixed)):
        for move in np.flatnonzero(table[:, 1] > _TOUCH).tolist():
            row = table[move]
            new = Event(
                kind, int(done.moves.line[move]), float(row[1]), float(row[0]), (float(row[2]), float(row[3]), float(row[4])),
                float(move_time(done, move)),
            )  # fmt: skip
            old = found.get((kind, new.line))
            deeper = new if old is None or new.depth > old.depth else old
            found[kind, new.line] = deeper._replace(volume=new.volume + (old.volume if old is not None else 0.0))
    over = np.flatnonzero(done.stations("over_centre") > 0.0)
    for move in np.unique(np.searchsorted(done.run.station, over, side="right") - 1).tolist():
        end = done.moves.end[done.moves.path.first[move + 1] - 1]
        line, (x, y, z) = int(done.moves.line[move]), map(float, end)
        found.setdefault(("core", line), Event("core", line, 0.0, 0.0, (x, y, z), float(move_time(done, move))))
    return sorted(found.values(), key=lambda event: (event.line, event.kind))


def move_time(done: StockRunDone, move: int | IntArray) -> FloatArray:
    """Time at which moves begin [s]."""
    return done.planned.block_time[done.moves.block[done.moves.path.first[move]]]


def station_places(done: StockRunDone) -> FloatArray:
    """Tip at every station [m], shape (s, 3)."""
    return tips(done.moves, done.run.segment, done.stations("share"))


def station_along(done: StockRunDone) -> FloatArray:
    """Place of every station on the program's path [m]."""
    ends = done.moves.along[done.run.segment]
    return np.asarray(ends[:, 0] + done.stations("share") * (ends[:, 1] - ends[:, 0]))


def station_headings(done: StockRunDone) -> FloatArray:
    """Horizontal direction of the feed at every station, program x straight up or down; shape (s, 2)."""
    row = done.moves.path.row[done.run.segment]
    angle = row[:, 13] + done.stations("share") * row[:, 14]
    side = np.copysign(1.0, row[:, 14])
    arc = row[:, 0] != LINE
    return np.column_stack([
        np.where(arc, -side * np.sin(angle), row[:, 5]), np.where(arc, side * np.cos(angle), row[:, 6])
    ])  # fmt: skip


def station_moves(done: StockRunDone) -> IntArray:
    """Move of every station."""
    return np.repeat(np.arange(done.moves.number), np.diff(done.run.station))


def station_times(done: StockRunDone) -> FloatArray:
    """Time of every station: blocks are taken to be run evenly [s]."""
    return _times(done, done.run.segment, station_along(done))


def time_beside(done: StockRunDone, segment: int, point: FloatArray) -> float:
    """Time at which the tip is nearest in plan to a point (x, y) on a segment; straight up or down that of its end [s]."""
    row, along = done.moves.path.row[segment], done.moves.along[segment]
    x, y = float(point[0]) - row[2], float(point[1]) - row[3]
    share = 1.0
    if row[0] != LINE:
        turned = np.copysign(1.0, row[14]) * (np.arctan2(y, x) - row[13]) % (2.0 * np.pi)
        span = abs(row[14])
        beyond = 0.5 * (span + 2.0 * np.pi)  # half way round the gap: nearer to the start than to the end
        share = 0.0 if turned > beyond else min(turned / span, 1.0)
    elif row[7] > 1e-12:
        share = min(max((x * row[5] + y * row[6]) / row[7], 0.0), 1.0)
    place = along[0] + share * (along[1] - along[0])
    return float(_times(done, np.array([segment]), np.array([place]))[0])


def _times(done: StockRunDone, segment: IntArray, along: FloatArray) -> FloatArray:
    """Time at places of the program's path on given segments [s]."""
    block = done.moves.block[segment]
    curve = done.planned.path.curve
    share = np.clip((along - curve.knots[block]) / np.maximum(curve.length[block], 1e-30), 0.0, 1.0)
    times, pause = done.planned.block_time, done.planned.path.dwell_after
    return np.asarray(times[block] + share * (times[block + 1] - pause[block] - times[block]))
