"""Step (5): the new program is read again and simulated with all of the scenario; where a limit is exceeded, feeds come down."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise import units
from cutwise.physics.cutting.affine_limits import PEAK
from cutwise.process.recipes import quick_outcome
from cutwise.programs.block_text import block_named
from cutwise.results import Result
from cutwise.spec.correct import LIMITED
from cutwise.spec.milling import MillingScenario
from cutwise.study.band import simulate
from cutwise.study.correct import ends
from cutwise.study.correct.cells import FloatArray
from cutwise.study.correct.limits import EQUAL, SAME, Asked, exceeded, is_least
from cutwise.study.correct.loads import COLUMN, NAMES, Allowed, greatest, values_at
from cutwise.study.correct.objective import Aim, late, nothing, worth
from cutwise.study.correct.outcome import Task
from cutwise.study.correct.schedule import Schedule

if TYPE_CHECKING:
    from cutwise.study.correct.feed import Ready

_ROUNDS = 3  # of lowering
_SHY = 0.995  # of the limit that a lowered place aims at
_SHIER = 0.005  # by which it aims lower in every further round
_LOWEST = 0.2  # of a feed in one round
_LESS = 0.98  # of a feed, at which it is looked how forces grow with it
_SLACK = 2e-3  # of a limit, by which cells of shorter blocks may differ from those that were scheduled
_POWERS = (0.2, 3.0)  # within which measures are taken to grow with the feed
_OVERSHOT = 1.03  # times the peak at the feeds of the program, from which the drives' part of a peak is told
_GAINS = 1e-3  # of the time: less is nothing
HISTORIES: Mapping[str, tuple[str, str]] = {
    "force_xy_peak": ("cutting", "force_xy_peak"),
    "wall_error_min": ("structure", "wall_error_min"),
    "wall_error_max": ("structure", "wall_error_max"),
    "contour_error_max": ("surface", "contour_error"),
    "tip_deflection_max": ("structure", "tip_peak"),
}
"""Measures whose course along the path a run keeps: stage and array."""

STATIONS: Mapping[str, tuple[str, str]] = {
    "force_xy_peak": ("motion", "force_xy_peak"),
    "cutting_power_max": ("motion", "power"),
    "spindle_torque_max": ("motion", "torque"),
    "chip_thickness_max": ("motion", "chip_thickness"),
    "removal_rate_max": ("motion", "removal_rate"),
}
"""The same of a run in a stock in 3D, at its stations."""


class Proof(NamedTuple):
    """A program that was simulated."""

    schedule: Schedule
    scenario: MillingScenario
    after: Result
    values: FloatArray  # what every cell comes to at its new feed, the tip at rest, shape (n, 9)
    ceiling: FloatArray  # highest feeds that simulations have left to the cells [m/s], infinite where they left all, shape (n,)
    measures: Mapping[str, tuple[float, str]]
    told: tuple[str, ...]
    missed: tuple[str, ...]
    unchanged: bool  # it is the program as it was


class Pair(NamedTuple):
    """Measures of the run before and of the one after, as they are compared."""

    before: Mapping[str, float]
    after: Mapping[str, float]


def proved(ready: Ready, task: Task, aim: Aim) -> Proof:
    """Schedule, write, read, simulate; lower what is exceeded, three times at most."""
    from cutwise.study.correct.feed import driven, proposed

    wanted, room = aim.wanted, aim.room
    ceiling = aim.ceiling
    bends: dict[str, tuple[FloatArray, FloatArray]] = {}
    at_rest = chatters(task.before)
    first = _at_rest(task.before.scenario) if at_rest else _values(task.before)
    for turn in range(_ROUNDS + 1):
        done, scenario = proposed(ready, room, ceiling, task.said)
        after = simulate(scenario, None)
        if task.progress is not None:
            task.progress(0.2 + 0.8 * (turn + 1) / (_ROUNDS + 1))
        pair = Pair(first, _at_rest(scenario) if at_rest else _values(after))
        over = dict(_over(after, pair, wanted))
        lowers = {
            name: pair for name, pair in over.items() if name not in aim.targets and not _hopeless(name, room, wanted)
        }
        if not lowers or turn == _ROUNDS:
            break
        seen = _seen(ready, after, lowers, scaled=not at_rest)
        lowered = np.minimum(ceiling, _lowered(ready, done.feed, lowers, seen, bends, _SHY - _SHIER * turn))
        bends = {name: (done.feed, most) for name, most in seen.items()}
        if np.array_equal(lowered, ceiling):
            break
        ceiling = lowered
    moving = driven(ready, done.feed)
    values = values_at(ready.cells, ready.cutting, moving)
    before, now = (run.measures["cycle_time"].value for run in (task.before, after))
    kept = {name: pair for name, pair in over.items() if name not in aim.targets}
    missed = (
        *_missed(kept, after),
        *_beyond(ready, values, {name: limit for name, limit in aim.limits.items() if name not in aim.targets}),
        *ends.missed(ready, moving, aim.limits),
        *late(aim, now, _GAINS),
    )
    lowered = np.where(ceiling < aim.ceiling, ceiling, np.inf)
    told = (*_told(task, after, pair, at_rest, lowered), *_overshot(ready, after, values))
    if not missed and not _gains(task, aim, after, greatest(ready.cells, values)) and _was_good(task.before, aim):
        why = (nothing(aim.objective),)
        same = _times(before, before)
        return Proof(done, ready.scenario, task.before, values, ceiling, same, told, why, unchanged=True)
    return Proof(done, scenario, after, values, ceiling, _times(before, now), told, missed, unchanged=False)


def _gains(task: Task, aim: Aim, after: Result, static: Mapping[str, float]) -> bool:
    """Whether a run has less of what is to be least."""
    old, new = worth(aim.objective, task.before, aim.static), worth(aim.objective, after, static)
    return old is not None and new is not None and new <= old * (1.0 - _GAINS)


def _hopeless(name: str, room: Allowed, wanted: Asked) -> bool:
    """Whether no feed at all keeps a limit: then no further run is made for it."""
    places = {k for k in np.unique(room.helpless).tolist() if k >= 0}
    return name in wanted.limits and any(name.startswith(NAMES[k]) for k in places)


def swings(scenario: MillingScenario) -> bool:
    """Whether the tip of a run vibrates; in 3D modes count by their stiffness."""
    return not scenario.in_3d and bool(scenario.tool.modes)


def chatters(run: Result) -> bool:
    """Whether the tool of a run vibrates so that nothing can be compared with it."""
    return any(finding.code in ("unstable", "tip_lost") for finding in run.findings)


def _values(run: Result) -> dict[str, float]:
    return {name: one.value for name, one in run.measures.items()}


def _at_rest(scenario: object) -> Mapping[str, float]:
    """A run whose tip stands still."""
    assert isinstance(scenario, MillingScenario)
    tool = scenario.tool.model_copy(update={"modes": (), "stiffness": None})
    return quick_outcome(scenario.model_copy(update={"tool": tool}), coarse=True).measures


def _times(before: float, after: float) -> dict[str, tuple[float, str]]:
    return {
        "time_before": (before, "time"), "time_after": (after, "time"),
        "time_saved": (1.0 - after / before, "dimensionless"),
    }  # fmt: skip


def _over(after: Result, pair: Pair, wanted: Asked) -> Iterator[tuple[str, tuple[float, float]]]:
    """Measures of the runs that are beyond their limits: value and limit."""
    for name, limit in wanted.limits.items():
        measure = after.measures.get(name)
        if measure is not None and exceeded(name, measure.value, limit):
            yield name, (measure.value, limit)
    for name in wanted.equal & pair.before.keys() & pair.after.keys():
        if exceeded(name, pair.after[name], pair.before[name], SAME):
            yield name, (pair.after[name], pair.before[name])


def _seen(
    ready: Ready, after: Result, over: Mapping[str, tuple[float, float]], *, scaled: bool
) -> dict[str, FloatArray]:
    """What every cell came to in a run: the largest of each measure that is beyond its limit, with the sign of its side.

    ``scaled``: the measure is taken between the samples of the run too, and its course is brought up to it.
    """
    found = {}
    for name, (value, _) in over.items():
        most = course_of(ready, after, name, value if scaled else None)
        if np.isfinite(most).any():
            found[name] = most
    return found


def course_of(ready: Ready, run: Result, name: str, greatest_of_all: float | None = None) -> FloatArray:
    """Largest of a measure in every cell of a run, with the sign of its side; minus infinity where the run does not tell it."""
    ends = ready.cells.way + 0.5 * ready.cells.length
    most = np.full(ends.size, -np.inf)
    stage, array = (STATIONS if ready.scenario.in_3d else HISTORIES).get(name, ("", ""))
    if stage not in run.stages.children or array not in run[stage]:
        return most
    cell = np.minimum(np.searchsorted(ends, np.asarray(run["motion"]["travelled"].values)), ends.size - 1)
    course = np.asarray(run[stage][array].values, dtype=float)
    course = np.abs(course) if name == "contour_error_max" else _side(name) * course
    top = float(np.nanmax(course))
    if np.isfinite(top) and top > 0.0:
        if greatest_of_all is not None:
            course = course * (_side(name) * greatest_of_all / top)
        np.maximum.at(most, cell, np.where(np.isfinite(course), course, -np.inf))
    return most


def _side(name: str) -> float:
    return -1.0 if is_least(name) else 1.0


def _lowered(
    ready: Ready, feed: FloatArray, over: Mapping[str, tuple[float, float]], seen: Mapping[str, FloatArray],
    last: Mapping[str, tuple[FloatArray, FloatArray]], aim: float,
) -> FloatArray:  # fmt: skip
    r"""Highest feeds of the cells that were beyond a limit, :math:`F (0.995\,L/e)^{1/p}`, e growing as :math:`F^p`.

    The exponent is that of the cell at rest for forces and walls, of the last two runs otherwise, and 1 at first. What is
    aimed at is a little less in each round, and cells beyond that come down too: new blocks have new ramps.
    """
    out = np.full(feed.size, np.inf)
    for name, most in seen.items():
        limit = _side(name) * over[name][1]
        reach = limit if aim >= _SHY else aim * limit
        high = (most > reach) & (most > 0.0) & np.isfinite(feed)
        share = np.where(high, aim * max(limit, 0.0) / np.where(high, most, 1.0), 1.0)
        power = _powers(ready, name, feed)
        if power is None:
            power = _secant(feed, most, *last[name]) if name in last else np.ones(feed.size)
        ratio = np.clip(share ** (1.0 / power), _LOWEST, 1.0)
        out = np.where(high, np.minimum(out, feed * ratio), out)
    spread = out.copy()
    spread[1:] = np.minimum(spread[1:], out[:-1])
    spread[:-1] = np.minimum(spread[:-1], out[1:])
    return spread


def _powers(ready: Ready, name: str, feed: FloatArray) -> FloatArray | None:
    """How a measure grows with the feed of each cell, the tip at rest; None where it does not tell."""
    from cutwise.study.correct.feed import driven

    if name not in COLUMN or swings(ready.scenario):
        return None
    moving = driven(ready, feed)
    now, less = (np.abs(values_at(ready.cells, ready.cutting, moving * k)[:, COLUMN[name]]) for k in (1.0, _LESS))
    known = np.isfinite(now) & np.isfinite(less) & (less > 0.0) & (now > less)
    found = np.log(np.where(known, now / np.where(known, less, 1.0), 1.0)) / -math.log(_LESS)
    return np.where(known, np.clip(found, *_POWERS), 1.0)


def _secant(feed: FloatArray, most: FloatArray, feed_before: FloatArray, most_before: FloatArray) -> FloatArray:
    """Exponents from two runs, cell by cell; 1 where the feed has hardly changed."""
    moving = np.isfinite(feed) & np.isfinite(feed_before)
    feed, feed_before = np.where(moving, feed, 1.0), np.where(moving, feed_before, 1.0)
    known = (most > 0.0) & (most_before > 0.0) & (np.abs(feed_before / feed - 1.0) > 1e-3)
    rise = np.log(np.where(known, most_before / np.where(known, most, 1.0), 1.0))
    run = np.log(np.where(known, feed_before / np.where(known, feed, 1.0), math.e))
    return np.where(known, np.clip(rise / run, *_POWERS), 1.0)


def _missed(over: Mapping[str, tuple[float, float]], after: Result) -> Iterator[str]:
    """Limits that are still exceeded; requirements are told by their own checks."""
    failed = {check.measure for check in after.checks if not check.passed}
    for name, (value, limit) in over.items():
        if name not in failed:
            shown = [units.show(number, LIMITED[name], 4) for number in (value, limit)]
            yield f"{name} is {shown[0]} in the simulation, beyond its limit of {shown[1]}"


def _beyond(ready: Ready, values: FloatArray, limits: Mapping[str, float]) -> Iterator[str]:
    """Lines that are beyond a limit with the tip at rest, because they keep their feed or no feed helps them."""
    for name, limit in limits.items():
        if name not in COLUMN or (name.startswith("wall") and swings(ready.scenario)):
            continue  # walls of a tool that swings are those of the simulation
        value = _side(name) * values[:, COLUMN[name]]
        over = np.flatnonzero(ready.cells.cuts & (value > _side(name) * limit + _SLACK * abs(limit) + 1e-12))
        if over.size:
            worst = int(over[np.argmax(value[over])])
            shown = [units.show(one, LIMITED[name], 4) for one in (_side(name) * float(value[worst]), limit)]
            line = block_named(ready.program.text, int(ready.bed.line[worst]))
            yield f"{name} is {shown[0]} at {line}, beyond its limit of {shown[1]}{_because(ready, worst)}"


def _because(ready: Ready, cell: int) -> str:
    known = ready.known.get(int(ready.bed.line[cell]))
    return f": the line keeps its feed ({known.why})" if known is not None and not known.change else ""


def _was_good(before: Result, aim: Aim) -> bool:
    """Whether the program as it was keeps all limits."""
    values = {**aim.static, **_values(before)}
    asked_for = aim.limits.keys() - aim.targets - aim.wanted.equal
    beyond = [n for n in asked_for if n in values and exceeded(n, values[n], aim.limits[n])]
    return not beyond and not before.unsound and not before.infeasible and all(check.passed for check in before.checks)


def _told(task: Task, after: Result, pair: Pair, at_rest: bool, ceiling: FloatArray) -> Iterator[str]:
    if at_rest:
        names = [n for n in EQUAL if n in task.before.measures and n in after.measures]
        beside = ", ".join(
            f"{n} {units.show(task.before.measures[n].value, LIMITED[n], 4)} → {units.show(after.measures[n].value, LIMITED[n], 4)}"
            for n in names
        )
        peak = " → ".join(units.show(one["force_xy_peak"], "force", 4) for one in pair if "force_xy_peak" in one)
        yield (
            f"the run before chatters: both runs are compared with the tip at rest (force_xy_peak {peak}); vibrating: "
            f"{beside or 'not known'}"
        )
    lowered = int(np.isfinite(ceiling).sum())
    if lowered:
        yield f"the simulation of the new program was beyond a limit at {lowered} places, whose feeds were lowered"
    name = "contour_error_max"
    old, new = task.before.measures.get(name), after.measures.get(name)
    written = name in task.scenario.requirements or name in task.said.limits
    if old is not None and new is not None and new.value > old.value * 1.01 and not written:
        shown = [units.show(one.value, "small_length", 4) for one in (old, new)]
        yield f"{name} rises from {shown[0]} to {shown[1]}; write a requirement to have it limited"


def _overshot(ready: Ready, after: Result, values: FloatArray) -> Iterator[str]:
    """Where a peak is that of the drives: after a start they run quicker than they are told, and chips are thicker."""
    if ready.scenario.in_3d or not ready.cells.cuts.any():
        return  # in 3D loads are those of the planned path
    if ready.scenario.tool.modes or ready.scenario.tool.runout:
        return
    static, found = float(values[ready.cells.cuts, PEAK].max()), after.measures["force_xy_peak"].value
    row = int(np.nanargmax(after["cutting"]["force_xy_peak"].values))
    told, run = (float(after["motion"][name].values[row]) for name in ("speed_planned", "speed_actual"))
    if found > _OVERSHOT * static and run > told * _OVERSHOT:
        line = block_named(after.scenario.program.text, int(after["scene"]["line"].values[row]))  # type: ignore[attr-defined]
        shown = [units.show(one, "force", 4) for one in (found, static)]
        speeds = [units.show(one, "speed", 3) for one in (run, told)]
        yield (
            f"force_xy_peak is {shown[0]} in the simulation and {shown[1]} at the feeds of the program: at {line} the drives run "
            f"{speeds[0]} where {speeds[1]} are told (they overshoot after a start)"
        )
