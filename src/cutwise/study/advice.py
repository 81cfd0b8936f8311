"""Advice: which setting brings a run within its requirements, or how much room is left in each, by running again."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from cutwise import units
from cutwise.process.recipes import quick_measures, quick_outcome
from cutwise.results import SOUNDNESS, Finding, SolverFailure
from cutwise.spec import fields
from cutwise.spec.faults import Fault, ScenarioFault, dotted
from cutwise.spec.fields import placed
from cutwise.spec.scenario import Scenario
from cutwise.study.sensitivity import changed

_SCAN = 13
_PAIR_SCAN = 7
_HALVINGS = 6
_MOST_HALVINGS = 20  # where the edge is near to what there is


class Lever(NamedTuple):
    """A setting that may be turned, in SI; several numbers are turned together, by a factor."""

    key: str
    name: str  # with what stands there
    dimension: str
    now: float
    low: float
    high: float
    given: tuple[float, ...] = ()  # the numbers that a factor turns

    def shown(self, value: float, figures: int = 3) -> str:
        """A value of the setting as people read it."""
        return f"{value:.{figures}g} times" if self.given else units.show(value, self.dimension, figures)

    def written(self, value: float) -> str:
        """A value of the setting as a scenario has it."""
        if self.given:
            return f"[{', '.join(units.text(value * entry, self.dimension) for entry in self.given)}]"
        return units.text(value, self.dimension)


class Proposal(NamedTuple):
    """Settings that meet all requirements, nearest to the present ones, and what a run with them gives."""

    settings: Mapping[str, float]  # dotted key: value [SI]
    measures: Mapping[str, float]
    text: str


def advise(
    scenario: Scenario, limits: Mapping[str, tuple[str, str]] | None = None, *, pairs: bool = True
) -> tuple[str, ...]:
    """What to change, or how much room there is.

    Parameters
    ----------
    scenario : Scenario
        The scenario, with requirements.
    limits : mapping, optional
        Dotted key: lowest and highest value that may be set, as text; the levers of the process by default.
    pairs : bool
        Look for two levers together where none helps alone: hundreds of runs.

    Returns
    -------
    tuple of str
        One sentence for each lever that helps (or each pair, if none helps alone); for a scenario that meets its
        requirements, the room in each lever. Nothing without requirements.
    """
    if not scenario.requirements:
        return ()
    levers = list(_levers(scenario, limits or scenario.turned()))
    margin = _margins(scenario, levers)
    if margin(()) >= 0.0:
        return tuple(_room(lever, margin) for lever in levers)
    proposals = propose(scenario, limits, pairs=pairs)
    if not proposals:
        tried = ", ".join(f"{lever.name} {lever.shown(lever.low)} to {lever.shown(lever.high)}" for lever in levers)
        beyond = "and no pair of them " if pairs else ""
        hint = "" if pairs else "; cutwise advise looks for two together"
        return (f"no single lever {beyond}meets the requirements within its limits ({tried}){hint}",)
    return tuple(p.text for p in proposals)


def propose(
    scenario: Scenario, limits: Mapping[str, tuple[str, str]] | None = None, *, pairs: bool = True
) -> list[Proposal]:
    """Settings that bring a failing scenario within its requirements: one lever, or two where one is not enough."""
    levers = list(_levers(scenario, limits or scenario.turned()))
    margin = _margins(scenario, levers)
    found = [settings for lever in levers if (settings := _nearest(lever, margin)) is not None]
    if not found and pairs:
        found = [s for pair in combinations(levers, 2) if (s := _nearest_pair(pair, margin)) is not None]
    return [_proposal(scenario, levers, settings) for settings in found]


def read_limits(scenario: Scenario, texts: Sequence[str]) -> dict[str, tuple[str, str]]:
    """``key=low..high`` as limits of levers; none given, the levers of the process.

    Raises
    ------
    ScenarioFault
        Everything that is wrong with the texts.
    """
    given = {dotted(path): (info, value) for path, info, value in fields.leaves(scenario)}
    limits: dict[str, tuple[str, str]] = {}
    faults = []
    for text in texts:
        key, _, span = text.partition("=")
        low, dots, high = (part.strip() for part in span.partition(".."))
        place = f"--limit {key}"
        dimension = fields.dimension(given[key][0]) if key in given else None
        if key in given and dimension is not None and isinstance(given[key][1], tuple):
            dimension = "dimensionless"  # a factor on all of its numbers
        if dimension is None:
            faults.append(Fault((), _no_lever(key, given), file=place))
        elif not dots:
            faults.append(Fault((), "is not of the form dotted.key=low..high", file=place))
        else:
            faults += _limit_faults(low, high, dimension, place)
            limits[key] = (low, high)
    if faults:
        raise ScenarioFault(faults)
    return limits or dict(scenario.turned())


def _no_lever(key: str, given: Mapping[str, Any]) -> str:
    whole = key.rpartition("[")[0]
    if whole in given:
        return f"is one number of {whole}; write --limit {whole}=low..high with factors, which turn all of them"
    return "is not a quantity of this scenario"


def _limit_faults(low: str, high: str, dimension: str, place: str) -> Iterator[Fault]:
    ends = []
    for end in (low, high):
        try:
            ends.append(units.parse(end, dimension))
        except units.UnitFault as fault:
            yield Fault((), str(fault), file=place)
    if len(ends) == 2 and ends[0] >= ends[1]:
        yield Fault((), f"{low} is not below {high}", file=place)


def _levers(scenario: Scenario, limits: Mapping[str, tuple[str, str]]) -> Iterator[Lever]:
    given = {dotted(path): (info, value) for path, info, value in fields.leaves(scenario)}
    for key, (low, high) in limits.items():
        if key not in given:
            continue
        info, now = given[key]
        dimension, name = fields.dimension(info) or "dimensionless", placed(scenario, key)
        if isinstance(now, float):  # not a word, such as a posture to be searched for
            yield Lever(key, name, dimension, now, units.parse(low, dimension), units.parse(high, dimension))
        elif isinstance(now, tuple) and now and all(isinstance(entry, float) for entry in now):
            ends = (units.parse(end, "dimensionless") for end in (low, high))
            yield Lever(key, name, dimension, 1.0, *ends, given=now)


Settings = tuple[tuple[str, float], ...]


def with_settings(scenario: Scenario, levers: list[Lever], settings: Settings) -> Scenario:
    """The scenario with levers turned; a longer lead-in lengthens the run, so that the steady part stays.

    Raises
    ------
    ScenarioFault
        The settings do not fit the other values.
    """
    by_key = {lever.key: lever for lever in levers}
    values = {key: by_key[key].written(value) for key, value in settings}
    now = {lever.key: lever.now for lever in levers}
    turned = dict(settings)
    lead_in = turned.get("operation.lead_in_time")
    if lead_in is not None:
        run = scenario.operation.run_time + lead_in - now["operation.lead_in_time"]  # type: ignore[attr-defined]
        feed = turned.get("operation.feed", scenario.operation.feed)  # type: ignore[attr-defined]
        given = scenario.operation.duration is not None  # type: ignore[attr-defined]
        values["operation.duration" if given else "operation.length"] = (
            units.text(run, "time") if given else units.text(run * feed, "length")
        )
    return changed(scenario, values)


def _margins(scenario: Scenario, levers: list[Lever]) -> Callable[[Settings], float]:
    @cache
    def margin(settings: Settings) -> float:
        """Smallest slack over all requirements, relative to the limit; below zero one is missed."""
        try:
            outcome = quick_outcome(with_settings(scenario, levers, settings) if settings else scenario)
        except (ScenarioFault, SolverFailure):
            return -np.inf
        return slack(scenario, *outcome)

    return margin


def slack(scenario: Scenario, measures: Mapping[str, float], findings: Sequence[Finding] = ()) -> float:
    """Smallest distance of a measure from its limit, relative to the limit (to 1 where the limit is zero).

    Minus infinity where a measure is lacking, or where the run is not sound: a tool at its stop meets no requirement
    that an engineer would trust.
    """
    if any(finding.code in SOUNDNESS and finding.code not in scenario.set_aside for finding in findings):
        return -np.inf
    if any(name in measures and measures[name] <= least for name, least in scenario.sound.items()):
        return -np.inf
    least = np.inf
    for name, limit in scenario.requirements.items():
        value = measures.get(name)
        if value is None:
            return -np.inf
        for bound, sign in ((limit.max, 1.0), (limit.min, -1.0)):
            if bound is not None:
                least = min(least, sign * (bound - value) / (abs(bound) or 1.0))
    return float(least)


def _nearest(lever: Lever, margin: Callable[[Settings], float]) -> Settings | None:
    """The value nearest to the present one that meets the requirements, a little inside."""
    grid = [v for v in np.linspace(lever.low, lever.high, _SCAN) if margin(((lever.key, float(v)),)) >= 0.0]
    if not grid:
        return None
    good = float(min(grid, key=lambda v: abs(v - lever.now)))
    edge = _edge(lever, margin, good, lever.now)
    inside = edge + 0.1 * (good - edge)  # a little more than the least that passes
    chosen = inside if margin(((lever.key, inside),)) >= 0.0 else good
    return ((lever.key, _rounded(lever, chosen, margin)),)


def _rounded(lever: Lever, value: float, margin: Callable[[Settings], float]) -> float:
    """The value to two figures where it still passes, else to three, else as it is."""
    for digits in (2, 3):
        if lever.given:
            short = float(f"{value:.{digits}g}")
        else:
            number, _ = units.displayed(value, lever.dimension)
            text = f"{number:.{digits}g} {units.DIMENSIONS[lever.dimension].display}"
            short = units.parse(text, lever.dimension)
        if lever.low <= short <= lever.high and margin(((lever.key, short),)) >= 0.0:
            return short
    return value


def _edge(lever: Lever, margin: Callable[[Settings], float], good: float, bad: float) -> float:
    """Last passing value between a good and a bad one, also where it is much nearer to the good one."""
    start = good
    for number in range(_MOST_HALVINGS):
        if number >= _HALVINGS and abs(bad - good) < 0.1 * abs(good - start):
            break
        middle = 0.5 * (good + bad)
        if margin(((lever.key, middle),)) >= 0.0:
            good = middle
        else:
            bad = middle
    return good


def _nearest_pair(pair: tuple[Lever, ...], margin: Callable[[Settings], float]) -> Settings | None:
    grids = [np.linspace(lever.low, lever.high, _PAIR_SCAN) for lever in pair]
    best: tuple[float, Settings] | None = None
    for a in grids[0]:
        for b in grids[1]:
            settings = ((pair[0].key, float(a)), (pair[1].key, float(b)))
            if margin(settings) < 0.0:
                continue
            far = sum(abs(v - lever.now) / (lever.high - lever.low) for v, lever in zip((a, b), pair, strict=True))
            if best is None or far < best[0]:
                best = (far, settings)
    return best[1] if best else None


def _proposal(scenario: Scenario, levers: list[Lever], settings: Settings) -> Proposal:
    measures = quick_measures(with_settings(scenario, levers, settings))
    by_key = {lever.key: lever for lever in levers}
    turns = " and ".join(f"{by_key[key].name} {_turn(by_key[key], value)}" for key, value in settings)
    outcome = ", ".join(
        f"{name} {units.show(measures[name], scenario.measures[name].dimension, 3)}"
        for name in scenario.requirements
        if name in measures
    )
    return Proposal(dict(settings), measures, f"change {turns}: a run with it gives {outcome}")


def _turn(lever: Lever, value: float) -> str:
    """From what to what."""
    return f"to {lever.shown(value)} what it is" if lever.given else f"{lever.shown(lever.now)} -> {lever.shown(value)}"


def _room(lever: Lever, margin: Callable[[Settings], float]) -> str:
    """How far a lever may be turned each way before a requirement is missed."""
    ends: list[tuple[float, str]] = []
    for limit in (lever.low, lever.high):
        steps = np.linspace(lever.now, limit, 4)[1:]
        good = lever.now
        for value in steps:
            if margin(((lever.key, float(value)),)) < 0.0:
                good = _edge(lever, margin, good, float(value))
                ends.append((good, ""))
                break
            good = float(value)
        else:
            ends.append((limit, " (limit)"))
    values = {end for end, _ in ends} | {lever.now}
    figures = next((f for f in range(3, 7) if len({lever.shown(v, f) for v in values}) == len(values)), 3)
    low, high = (lever.shown(end, figures) + said for end, said in ends)
    return f"room in {lever.name} (now {lever.shown(lever.now, figures)}): from {low} to {high}"
