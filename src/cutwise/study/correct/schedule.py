"""From highest speeds of cells to the feed of every part of every line."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from cutwise.maths.linearc import turn_angles
from cutwise.physics.motion.feed_stretches import Ramps, anticipated, stretch_times, time_bound
from cutwise.physics.motion.lookahead import TANGENT
from cutwise.physics.motion.schedule import Rules, Runs, feed_levels, scheduled_feeds
from cutwise.process.program_path import ProgramPath
from cutwise.programs.rewrite import Handle, Part, down, feed_step
from cutwise.spec.correct import Correction
from cutwise.spec.drives import CncMachine
from cutwise.study.correct.cells import BoolArray, Cells, FloatArray, IntArray

_HARDLY = 1.005  # of the programmed feed
_BLEND = 2.0  # tangent lengths of a blend that the block beside it keeps, so that the blend stays as it is


class Bed(NamedTuple):
    """The cells of a program with what may be done at each, ``n`` of them."""

    line: IntArray  # of the program, 0 for a rapid move, shape (n,)
    move: IntArray  # number of the move in the run, shape (n,)
    joined: BoolArray  # has the feed of the cell before it, shape (n,)
    fixed: FloatArray  # feed that it keeps [m/s], NaN: it is free, shape (n,)
    rests: BoolArray  # the motion stops in front of it, shape (n,)
    rapid: BoolArray  # shape (n,)
    share: FloatArray  # of its move at which it ends, shape (n,)
    repeated: Mapping[int, str]  # lines that have one feed in all their runs: why


def bed_of(path: ProgramPath, cells: Cells, moves: IntArray, known: Mapping[int, Handle], kept: BoolArray) -> Bed:
    """What may be done at each cell.

    Parameters
    ----------
    path : ProgramPath
        The path as it is driven.
    cells : Cells
        Its cells.
    moves : array
        Number in the run of the program of every block of the programmed path.
    known : mapping
        What may be done with each line.
    kept : array (n,)
        Cells that keep their feed in any case.
    """
    block = cells.block
    line = np.where(np.isinf(path.feed[block]), 0, path.source[block])
    move = moves[path.origin[block]]
    rapid = np.isinf(path.feed[block])
    changes = np.array([known[n].change if n in known else False for n in path.source.tolist()])[block]
    splits = np.array([known[n].split if n in known else False for n in path.source.tolist()])[block]
    fixed = np.where(rapid | (changes & ~kept), np.nan, path.feed[block])
    same_line = np.append(False, (line[1:] == line[:-1]) & (line[1:] > 0))
    joined = same_line & (~splits | _beside_blend(path, cells))
    main = np.array([known[n].main if n in known else -1 for n in path.source.tolist()])[block]
    corner = same_line & np.append(
        False, move[:-1] != main[:-1]
    )  # behind the arc round a corner of a compensated contour
    joined |= corner
    joined &= np.append(False, np.isnan(fixed[1:]) == np.isnan(fixed[:-1]))
    through = turn_angles(path.curve) < TANGENT
    through &= ~path.stop_at & (path.dwell_after[:-1] <= 0.0)
    rests = np.append(True, (block[1:] != block[:-1]) & ~np.append(through, False)[block[:-1]])
    repeated = {n: one.why for n, one in known.items() if one.change and one.why.startswith("it runs")}
    return Bed(line, move, joined, fixed, rests, rapid, _shares(path, cells), repeated)


def _shares(path: ProgramPath, cells: Cells) -> FloatArray:
    """Where each cell ends on its programmed block, as a share of that."""
    block = cells.block
    end = cells.begin + cells.length
    if not path.blended:
        return np.asarray(end / path.curve.length[block])
    told = path.programmed
    origin = path.origin[block]
    offset = np.linalg.norm(path.curve.start[block] - told.start[origin], axis=1)
    straight = told.straight[origin] & path.curve.straight[block]
    return np.asarray(np.where(straight, np.minimum((offset + end) / told.length[origin], 1.0), 1.0))


def _beside_blend(path: ProgramPath, cells: Cells) -> BoolArray:
    """Cells that belong to the one before them, because a blend begins or ends too near."""
    if not path.blended:
        return np.zeros(cells.size, bool)
    told = path.programmed
    origin = path.origin[cells.block]
    straight, plain = path.curve.straight[cells.block], told.straight[origin]
    begins = np.append(True, origin[1:] != origin[:-1])
    first, group = np.flatnonzero(begins), np.cumsum(begins) - 1
    number = np.arange(cells.size)
    low = np.minimum.reduceat(np.where(straight, number, cells.size), first)
    high = np.maximum.reduceat(np.where(straight, number, -1), first)
    whole = plain[first] & (high >= 0)  # lines of which something is left between their blends
    low, high = np.where(whole, low, first), np.where(whole, high, first)
    offset = np.linalg.norm(path.curve.start[cells.block[low]] - told.start[origin[first]], axis=1)
    length = told.length[origin[first]]
    behind = length - (cells.begin[high] + cells.length[high] + offset)
    places = offset[group] + cells.begin
    near = (places < _BLEND * offset[group]) | (places > (length - _BLEND * behind)[group] - 1e-12) | ~straight
    out = np.where(whole[group], near, ~begins)
    out[low[whole]] = (low > first)[whole]
    return np.asarray(out)


class Schedule(NamedTuple):
    """Feeds of a program."""

    feed: FloatArray  # of every cell [m/s], infinite for rapid moves, shape (n,)
    cap: FloatArray  # what every cell may have, its neighbours seen [m/s], shape (n,)
    parts: Mapping[int, tuple[Part, ...]]  # line: its parts; lines that keep their feed are not there
    blocks: int  # of the new program with feed moves
    bound: float  # time below which none comes [s]


def scheduled(
    path: ProgramPath, cells: Cells, bed: Bed, own: FloatArray, machine: CncMachine, said: Correction, inch: bool
) -> Schedule:
    """The quickest feeds that every cell allows."""
    limits = machine.limits
    ramps = Ramps(limits.acceleration, limits.jerk)
    cap = _neighbours_seen(own, bed)
    if machine.control.ramp == "after":
        cap = anticipated(cap, cells.length, ramps)
    cap = _alike_in_all_runs(cap, bed)
    bend = np.maximum(path.curve.curvature, path.curve.share**2 / path.curve.radius)[cells.block]
    fixed = np.where(np.isnan(bed.fixed) & _is_repeated(bed), np.array([down(v, inch) for v in cap]), bed.fixed)
    base = float(np.median(path.feed[np.isfinite(path.feed)]))
    free = np.isnan(fixed) & ~bed.rapid
    gain = said.split_gain
    while True:
        feed = _feeds(cells, bed, cap, fixed, bend, free, base, Rules(
            gain, machine.control.block_time or 0.0, feed_step(inch), ramps), limits.velocity)  # fmt: skip
        feed = _as_programmed(feed, path.feed[cells.block], cap)
        parts, blocks = _parts(path, cells, bed, feed, free | _is_repeated(bed))
        if said.blocks_max is None or blocks <= said.blocks_max or gain > 1e3:
            break
        gain = 2.0 * max(gain, 1e-6)
    whole = np.minimum(np.where(bed.rapid, np.inf, np.where(np.isnan(fixed), own, fixed)), limits.velocity)
    bound = 0.0
    for a, b in _between(bed.rests):
        bound += time_bound(cells.length[a:b], whole[a:b], bend[a:b], limits.acceleration, np.zeros(2))
    return Schedule(feed, cap, parts, blocks, bound + float(path.dwell_after.sum()))


def _as_programmed(feed: FloatArray, told: FloatArray, cap: FloatArray) -> FloatArray:
    """Feeds hardly above the programmed one stay that: a word for less than half a percent is none."""
    hardly = (feed > told) & (feed <= told * _HARDLY) & (told <= cap * (1.0 + 1e-6))
    return np.where(hardly, told, feed)


def _neighbours_seen(own: FloatArray, bed: Bed) -> FloatArray:
    """The least of each cell and its two neighbours: heavier contact is anticipated."""
    cap = own.copy()
    follows = ~(bed.rapid[1:] | bed.rapid[:-1])
    cap[1:] = np.where(follows, np.minimum(cap[1:], own[:-1]), cap[1:])
    cap[:-1] = np.where(follows, np.minimum(cap[:-1], own[1:]), cap[:-1])
    return cap


def _is_repeated(bed: Bed) -> BoolArray:
    return np.isin(bed.line, list(bed.repeated)) & np.isnan(bed.fixed) & ~bed.rapid


def _alike_in_all_runs(cap: FloatArray, bed: Bed) -> FloatArray:
    """Lines that run several times get the least of all runs."""
    out = cap.copy()
    for line in bed.repeated:
        cells = (bed.line == line) & np.isnan(bed.fixed) & ~bed.rapid
        if cells.any():
            out[cells] = cap[cells].min()
    return out


def _between(rests: BoolArray) -> list[tuple[int, int]]:
    first = np.flatnonzero(rests)
    return list(zip(first.tolist(), [*first[1:].tolist(), rests.size], strict=True))


def _feeds(
    cells: Cells, bed: Bed, cap: FloatArray, fixed: FloatArray, bend: FloatArray, free: BoolArray, base: float, rules: Rules,
    most: float,
) -> FloatArray:  # fmt: skip
    """The feed of every cell; what is joined counts as one cell."""
    feed = np.where(bed.rapid, math.inf, fixed)
    at = np.flatnonzero(free)
    if at.size == 0:
        return feed
    begins = np.append(True, np.diff(at) > 1) | bed.rests[at]
    starts = begins | ~bed.joined[at]
    group = np.flatnonzero(starts)
    length = np.add.reduceat(cells.length[at], group)
    caps = np.minimum.reduceat(cap[at], group)
    bends = np.maximum.reduceat(bend[at], group)
    first = np.flatnonzero(begins[group])
    opening = at[group[first]]
    ends = np.zeros((first.size, 2))
    last = at[np.append(group[first][1:], at.size) - 1]
    before, behind = opening - 1, last + 1
    inside = (opening > 0) & ~bed.rests[opening]
    ends[inside, 0] = np.where(bed.rapid[before[inside]], 0.0, feed[before[inside]])
    inner = behind < cap.size
    inner[inner] &= ~bed.rests[behind[inner]]
    ends[inner, 1] = np.where(bed.rapid[behind[inner]], 0.0, feed[behind[inner]])
    levels = feed_levels(base, max(float(caps.min()), 1e-6), most)
    runs = Runs(
        np.append(first, group.size), np.nan_to_num(ends), length, caps, bends, bed.move[at[group]].astype(np.int64)
    )
    found = scheduled_feeds(runs, levels, rules)
    feed[at] = found[np.cumsum(starts) - 1]
    return feed


def _parts(
    path: ProgramPath, cells: Cells, bed: Bed, feed: FloatArray, changed: BoolArray
) -> tuple[dict[int, tuple[Part, ...]], int]:
    """Parts of all lines whose feed is another one, and the feed blocks that there are in all."""
    moving = ~bed.rapid
    new_line = np.append(True, bed.move[1:] != bed.move[:-1])
    other = np.append(True, feed[1:] != feed[:-1]) | new_line
    blocks = int((moving & other).sum())
    told = np.where(moving, path.feed[cells.block], 0.0)
    touched = np.unique(bed.line[changed & (np.abs(np.where(moving, feed, 0.0) - told) > 1e-9)])
    wanted = np.isin(bed.line, touched) & moving
    parts: dict[int, list[Part]] = {}
    ends = np.append(other[1:], True)
    for k in np.flatnonzero(wanted & ends).tolist():
        line = int(bed.line[k])
        share = 1.0 if k + 1 == cells.size or bed.move[k + 1] != bed.move[k] else float(bed.share[k])
        rows = parts.setdefault(line, [])
        if rows and rows[-1].share >= share:  # another run of the line, or the arc round a corner before it
            rows[-1] = Part(rows[-1].share, min(rows[-1].feed, float(feed[k])))
        elif rows and rows[-1].feed == float(feed[k]):
            rows[-1] = Part(share, rows[-1].feed)
        else:
            rows.append(Part(share, float(feed[k])))
    return {line: tuple(rows) for line, rows in parts.items()}, blocks


def planned_time(path: ProgramPath, cells: Cells, bed: Bed, feed: FloatArray, machine: CncMachine) -> float:
    """Time of a schedule by a plain look-ahead, every change inside the faster stretch [s]."""
    limits = machine.limits
    bend = np.maximum(path.curve.curvature, path.curve.share**2 / path.curve.radius)[cells.block]
    speed = np.minimum(np.where(bed.rapid, limits.velocity, feed), limits.velocity)
    normal = speed**2 * bend
    room = np.sqrt(np.maximum(limits.acceleration**2 - normal**2, (1e-3 * limits.acceleration) ** 2))
    total = float(path.dwell_after.sum())
    for a, b in _between(bed.rests):
        starts = np.flatnonzero(np.append(True, (np.diff(speed[a:b]) != 0.0) | (np.diff(room[a:b]) != 0.0)))
        length = np.add.reduceat(cells.length[a:b], starts)
        total += float(stretch_times(length, speed[a:b][starts], room[a:b][starts], limits.jerk, np.zeros(2))[0].sum())
    return total
