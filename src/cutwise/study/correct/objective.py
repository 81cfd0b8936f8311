"""What is made least: time, the cost of a part, or its error in no more time."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise import units
from cutwise.physics.cutting.tool_life import cheapest_feed
from cutwise.process.part_cost import Use, costs, life
from cutwise.results import Result
from cutwise.spec.correct import Correction
from cutwise.spec.faults import Fault
from cutwise.spec.milling import MillingScenario
from cutwise.study.correct.cells import FloatArray
from cutwise.study.correct.limits import Asked
from cutwise.study.correct.loads import Allowed, allowed, cutting_of
from cutwise.study.correct.outcome import Task
from cutwise.study.correct.schedule import Schedule, planned_time

if TYPE_CHECKING:
    from cutwise.study.correct.feed import Ready

_HALVINGS = 14  # of what an error may be, until it is known to a thousandth
_LARGER = 8.0  # times the error before, that may be left where less time is asked for
WALLS = ("wall_error_min", "wall_error_max")
CONTOUR = "contour_error_max"
LEAST: Mapping[str, str] = {"time": "is quicker", "cost": "makes the part cheaper", "error": "makes the error smaller"}
"""What a correction gains, by its objective."""


class Aim(NamedTuple):
    """What a schedule is made for."""

    objective: str
    wanted: Asked
    limits: Mapping[str, float]  # all of them [SI]
    room: Allowed
    ceiling: FloatArray  # highest feeds that are no limit but an aim [m/s], shape (n,)
    targets: frozenset[str]  # of the limits those that are aimed at, and need not be reached
    static: Mapping[str, float]  # measures of the program before, the tip at rest
    budget: float  # time that it may take [s]


def error_of(run: Mapping[str, float], static: Mapping[str, float]) -> tuple[float | None, str]:
    """Error of a part that is made least, and its name: of the wall where one stays and the tool yields, else of the contour."""
    walls = [abs(value) for name in WALLS if (value := run.get(name, static.get(name))) is not None]
    if walls:
        return max(walls), "wall_error"
    return run.get(CONTOUR), CONTOUR


def worth(objective: str, run: Result, static: Mapping[str, float]) -> float | None:
    """The value that is made least of a run."""
    measures = {name: one.value for name, one in run.measures.items()}
    if objective == "error":
        return error_of(measures, static)[0]
    return measures.get("cycle_time" if objective == "time" else "cost_per_part")


def refusals(scenario: MillingScenario, said: Correction) -> Iterator[Fault]:
    """What an objective needs and is not there."""
    if said.objective == "cost" and scenario.shop is None:
        yield Fault(
            ("shop",), "missing: what an hour and a tool cost; cost is made least of shop.machine_rate and tool_price"
        )
    if said.objective == "cost" and "speed" in said.change and "feed" not in said.change:
        yield Fault(("correct", "change"), "the cheapest speed has its own feeds: write change: [speed, feed]")


def aimed(
    ready: Ready, task: Task, wanted: Asked, limits: Mapping[str, float], static: Mapping[str, float], *,
    budget: float | None = None,
) -> Aim:  # fmt: skip
    """What a schedule of the feeds is made for, under all limits; ``budget``: time for the least error, in place of others [s]."""
    said, scenario = task.said, ready.scenario
    free = np.full(ready.cells.size, math.inf)
    room = allowed(scenario, ready.path, ready.cells, ready.cutting, limits, cheapest(ready, said.objective))
    aim = Aim(said.objective, wanted, limits, room, free, frozenset(), static, math.inf)
    return _truest(ready, task, aim, budget) if said.objective == "error" else aim


def cheapest(ready: Ready, objective: str) -> float:
    """Feed per tooth above which a part is dearer, since the tool wears [m]; infinite where none is."""
    scenario = ready.scenario
    shop, wear = scenario.shop, scenario.wear
    if objective != "cost" or shop is None or wear is None or not shop.tool_price or not wear.at.feed_per_tooth:
        return math.inf
    at = wear.at.feed_per_tooth
    lasts = life(wear, _use(ready, 0.0, 0.0, at))
    return at * cheapest_feed(shop.machine_rate, shop.tool_price, lasts, wear.feed_exponent)


def _use(ready: Ready, time: float, cutting: float, feed: float) -> Use:
    """How a schedule uses machine and tool."""
    speed = float(ready.cutting.spindle[0]) * 0.5 * ready.scenario.tool.diameter
    return Use(time, cutting, speed, feed, float(ready.cells.patches[..., 3].max(initial=0.0)))


def planned(ready: Ready, feed: FloatArray) -> float:
    """Time of feeds by a plain look-ahead [s]."""
    return planned_time(ready.path, ready.cells, ready.bed, feed, ready.scenario.drives)


def planned_cost(ready: Ready, done: Schedule) -> float:
    """Cost of a part by a schedule, its ramps in the cut left out [EUR]."""
    cuts = ready.cells.cuts & np.isfinite(done.feed)
    cutting = float((ready.cells.length[cuts] / done.feed[cuts]).sum())
    way = float((ready.cells.length[cuts] * ready.cutting.per_speed[cuts]).sum())
    use = _use(ready, planned(ready, done.feed), cutting, way / cutting if cutting else 0.0)
    return costs(ready.scenario, use)["cost_per_part"]


def _truest(ready: Ready, task: Task, aim: Aim, given: float | None) -> Aim:
    """The least error that feeds reach within the time of the program before, or within that which is required."""
    from cutwise.study.correct.feed import schedule_of
    from cutwise.study.correct.prove import course_of

    before = task.before.measures["cycle_time"].value
    asked = task.scenario.requirements.get("cycle_time")
    budget = given or (before if asked is None or asked.max is None else asked.max)
    spare = budget - before + planned(ready, ready.path.feed[ready.cells.block])
    now, name = error_of({k: one.value for k, one in task.before.measures.items()}, aim.static)
    if now is None or now <= 0.0:
        return aim._replace(budget=budget)
    course = None if name == "wall_error" else course_of(ready, task.before, CONTOUR)

    def reached(one: Aim) -> bool:
        feed = schedule_of(ready, one.room, one.ceiling, task.said).feed
        return bool((one.room.helpless < 0).all()) and planned(ready, feed) <= spare * (1.0 + 1e-9)

    best, low, high = _within(ready, aim, now, course), 0.0, now
    if not reached(best):  # the time that is asked for takes a larger error than there was
        best, low, high = _within(ready, aim, _LARGER * now, course), now, _LARGER * now
        if not reached(best):
            return best._replace(budget=budget)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        one = _within(ready, aim, middle, course)
        if reached(one):
            best, high = one, middle
        else:
            low = middle
    return best._replace(budget=budget)


def _within(ready: Ready, aim: Aim, error: float, course: FloatArray | None) -> Aim:
    """An aim at walls, or with their course at contours, that are off by no more than an error [m]."""
    if course is None:
        limits = dict(aim.limits)
        for name, end in zip(WALLS, (-error, error), strict=True):
            stricter = max if end < 0.0 else min
            limits[name] = stricter(limits.get(name, end), end) if name in aim.wanted.limits else end
        return _aimed_at(ready, aim, limits, WALLS)
    feed = ready.path.feed[ready.cells.block]
    high = np.isfinite(feed) & (course > error)
    ceiling = np.where(high, feed * error / np.where(high, course, 1.0), math.inf)  # it grows about as the feed does
    limits = {**aim.limits, CONTOUR: min(aim.limits.get(CONTOUR, error), error)}
    return _aimed_at(ready, aim, limits, (CONTOUR,))._replace(ceiling=ceiling)


def _aimed_at(ready: Ready, aim: Aim, limits: Mapping[str, float], names: tuple[str, ...]) -> Aim:
    own = {name: limits[name] for name in names}
    wanted = aim.wanted._replace(limits={**aim.wanted.limits, **own}, equal=aim.wanted.equal - set(names))
    room = allowed(ready.scenario, ready.path, ready.cells, ready.cutting, limits)
    targets = frozenset(name for name in names if aim.wanted.limits.get(name) != limits[name])
    return aim._replace(wanted=wanted, limits=limits, room=room, targets=targets)


def nothing(objective: str) -> str:
    """Why a program is left as it was."""
    return f"nothing is gained: within these limits no feed {LEAST[objective]} by more than 0.1 %"


def late(aim: Aim, time: float, slack: float) -> Iterator[str]:
    """A program that takes longer than it may."""
    if time > aim.budget * (1.0 + slack):
        yield (
            f"it takes {units.show(time, 'time', 5)}, longer than the {units.show(aim.budget, 'time', 5)} within which its error "
            "was to be least"
        )


def cost_at(ready: Ready, task: Task, static: Mapping[str, float], wanted: Asked, speed: float) -> float:
    """Cost of a part at a spindle speed [rad/s], scheduled for it [EUR]; infinite where a limit is kept by no feed."""
    from cutwise.study.correct.feed import limits_of, schedule_of

    at = ready._replace(cutting=cutting_of(ready.scenario, ready.path, ready.cells, speed))
    aim = aimed(at, task, wanted, limits_of(at, wanted, static), static)
    if (aim.room.helpless >= 0).any():
        return math.inf
    return planned_cost(at, schedule_of(at, aim.room, aim.ceiling, task.said))
