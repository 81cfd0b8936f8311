"""``change: depth`` and ``change: placement``: settings that are turned within ranges, each trial simulated.

Depth: the deepest cut that keeps all requirements. Placement: how the arm, and the part before it, stand so that the error of
the part is least. The search is that of studies (:func:`cutwise.study.optimum.optimise`).
"""

import math
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

from cutwise import units
from cutwise.io.revision import revisions
from cutwise.process.recipes import quick_outcome
from cutwise.results import SOUNDNESS, SolverFailure
from cutwise.spec import fields
from cutwise.spec.chamfer import ChamferScenario
from cutwise.spec.correct import Correction
from cutwise.spec.faults import Fault, ScenarioFault, split_dotted
from cutwise.spec.scenario import Scenario
from cutwise.study.band import simulate
from cutwise.study.correct.outcome import Change, Proposal, Task
from cutwise.study.levers import Lever, levers_of
from cutwise.study.optimum import Optimum, optimise

_SOUND = "sound"  # 1 where a run can be believed, a requirement of every trial
_STARTS, _BEST, _CALLS = 16, 2, 80
_GAINS = 0.02  # share of the error that a placement has to take away
_DEEPER = 1e-3  # share by which a cut has to become deeper
_DEPTHS = ("operation.axial_depth", "operation.radial_depth")
_PLACES = ("robot.redundancy_angle", "placement.origin", "placement.rotation", "hole.position")
_ALONE = frozenset({"depth", "placement", "offset", "path"})
"""Changes that turn no other settings."""

_ERRORS: Mapping[str, tuple[str, ...]] = {
    "drill": ("hole_position_error_entry", "hole_position_error_exit"),
    "mill": ("wall_error_min", "wall_error_max"),
    "machine": ("deviation_max",),
    "deburr": ("surface_error_min", "surface_error_max"),
    "chamfer": ("width_deflected_min", "width_deflected_max"),
}
"""What a placement makes small: the largest of these, of a chamfer that of their distance from its width."""


class Search(NamedTuple):
    """What is turned, and how a trial is seen."""

    levers: tuple[Lever, ...]
    limits: Mapping[str, tuple[float | None, float | None]]
    seen: Callable[[Mapping[str, float]], dict[str, float]]


def deeper(task: Task) -> Proposal:
    """The deepest cut within the ranges that keeps the requirements, and is stable."""
    search = _search(task, _DEPTHS)
    now = {lever.key: lever.now for lever in search.levers}
    found = optimise(
        search.seen, {one.key: (one.low, one.high) for one in search.levers}, search.limits,
        lambda settings, _: math.prod(settings.values()), largest=True, starts=_STARTS, best=_BEST, calls=_CALLS,
    )  # fmt: skip
    before = math.prod(value or 0.0 for value in now.values())
    gained = found.value / before - 1.0 if before else math.inf
    kept = (
        []
        if found.met
        else [f"no depth within the ranges keeps all requirements; {_named(search, found)} comes nearest"]
    )
    if found.met and gained < _DEEPER:
        kept.append(
            f"nothing is gained: within the ranges no deeper cut keeps all requirements ({_named(search, found)})"
        )
    why = f"the deepest of {found.calls} trials that keeps all requirements"
    return _proposal(task, search, found, why, kept, {"depth_gained": (gained, "dimensionless")} if before else {})


def placed(task: Task) -> Proposal:
    """How arm and part stand so that the error of the part is least, all requirements kept where that can be."""
    search = _search(task, _PLACES)
    start = _error(task.scenario, {name: one.value for name, one in task.before.measures.items()})
    if math.isnan(start):
        names = " and ".join(_ERRORS[task.scenario.process])
        raise ScenarioFault(
            [Fault(("correct", "change"), f"placement: the run before has no {names}; there is no error to lessen")]
        )
    found = optimise(
        search.seen, {one.key: (one.low, one.high) for one in search.levers}, search.limits,
        lambda _, measures: _error(task.scenario, measures), starts=_STARTS, best=_BEST, calls=_CALLS,
    )  # fmt: skip
    shown = [units.show(one, "small_length", 4) for one in (start, found.value)]
    kept = [] if found.met else ["no placement within the ranges keeps all requirements; this one comes nearest"]
    if not found.value < (1.0 - _GAINS) * start:
        kept.append(f"nothing is gained: the error is {shown[1]} at best, {shown[0]} before")
    values = {
        "placement_error_before": (start, "small_length"), "placement_error_after": (found.value, "small_length"),
    }  # fmt: skip
    return _proposal(
        task, search, found, f"the least error of {found.calls} trials: {shown[0]} to {shown[1]}", kept, values
    )


def refusals(scenario: Scenario, said: Correction, unroll: bool) -> Iterator[Fault]:
    """Levers that are none of depth and placement, or that a program has in its text."""
    for change, keys in (("depth", _DEPTHS), ("placement", _PLACES)):
        if change not in said.change:
            continue
        mine = [key for key in said.ranges if key.startswith(keys)]
        if not mine:
            yield Fault(
                ("correct", "ranges"),
                f"missing: change: {change} turns {' or '.join(keys)} between two values (--range KEY=LO..HI)",
            )
        if change == "depth" and (
            getattr(scenario, "stock", None) is not None or getattr(scenario, "program", None) is not None
        ):
            yield Fault(("correct", "change"), "depth: the program says how deep it cuts; its depths are not changed")
    if set(said.change) <= _ALONE:
        read = (*(_DEPTHS if "depth" in said.change else ()), *(_PLACES if "placement" in said.change else ()))
        for key in said.ranges:
            if not key.startswith(read):
                yield Fault(
                    ("correct", "ranges", key), f"is turned by no change that is asked for; there are {', '.join(read)}"
                )
    if unroll:
        yield Fault((), "is not read by changes of settings", file="--unroll")


def _search(task: Task, keys: tuple[str, ...]) -> Search:
    scenario, said = task.scenario, task.said
    levers = tuple(_lever(scenario, key, ends) for key, ends in said.ranges.items() if key.startswith(keys))
    change = revisions(scenario)
    limits: dict[str, tuple[float | None, float | None]] = {_SOUND: (1.0, None)}
    limits |= {name: (one.min, one.max) for name, one in scenario.requirements.items()}
    for name, bound in said.limits.items():
        here = task.before.measures.get(name)
        if here is None:
            raise ScenarioFault([Fault(("correct", "limits", name), "no run of this scenario has such a measure")])
        if isinstance(bound, str):
            limits[name] = (here.value, None) if name.endswith("_min") else (None, here.value)
        else:
            limits[name] = (bound.min, bound.max)

    def seen(settings: Mapping[str, float]) -> dict[str, float]:
        written = {one.key: one.written(settings[one.key]) for one in levers}
        try:
            outcome = quick_outcome(change(written), tuple(limits))
        except (ScenarioFault, SolverFailure):
            return {}
        sound = not outcome.infeasible and not any(one.code in SOUNDNESS for one in outcome.findings)
        return {**outcome.measures, _SOUND: float(sound)}

    return Search(levers, limits, seen)


def _lever(scenario: Scenario, key: str, ends: tuple[str, str]) -> Lever:
    """A lever, also one number of a list, such as ``placement.origin[0]``.

    Raises
    ------
    ScenarioFault
        It is no quantity of the scenario, or its range is none.
    """
    path = split_dotted(key)
    if not isinstance(path[-1], int):
        return levers_of(scenario, {key: ends}, "correct.ranges")[0]
    info = fields.field_at(type(scenario), path[:-1])
    dimension = fields.dimension(info) if info is not None else None
    if dimension is None:
        raise ScenarioFault([Fault(("correct", "ranges", key), "is no quantity of this scenario")])
    try:
        low, high = (units.parse(end, dimension) for end in ends)
    except units.UnitFault as fault:
        raise ScenarioFault([Fault(("correct", "ranges", key), str(fault))]) from None
    if low >= high:
        raise ScenarioFault([Fault(("correct", "ranges", key), f"{ends[0]} is not below {ends[1]}")])
    whole: object = scenario
    for step in path[:-1]:
        whole = getattr(whole, str(step), None)
    now = whole[path[-1]] if isinstance(whole, tuple) and path[-1] < len(whole) else None
    return Lever(key, key, dimension, now, low, high)


def _error(scenario: Scenario, measures: Mapping[str, float]) -> float:
    """The largest error of the part [m]; NaN where a run has none."""
    names = _ERRORS[scenario.process]
    wanted = scenario.chamfer.width if isinstance(scenario, ChamferScenario) else 0.0
    found = [abs(measures[name] - wanted) for name in names if name in measures]
    return max(found) if found else math.nan


def _proposal(
    task: Task, search: Search, found: Optimum, why: str, kept: list[str], values: dict[str, tuple[float, str]]
) -> Proposal:  # fmt: skip
    """The best setting, run again; where nothing is gained the scenario stays as it was."""
    gained = not any(text.startswith("nothing is gained") for text in kept)
    best = revisions(task.scenario)({one.key: one.written(found.settings[one.key]) for one in search.levers})
    scenario = best if gained else task.scenario
    changes = [
        Change(one.key, one.shown(one.now, 5), one.shown(found.settings[one.key], 5), why) for one in search.levers
    ]
    return Proposal(scenario, tuple(changes) if gained else (), values, (), tuple(kept), after=simulate(scenario, None))


def _named(search: Search, found: Optimum) -> str:
    return ", ".join(f"{one.key} {one.shown(found.settings[one.key], 4)}" for one in search.levers)
