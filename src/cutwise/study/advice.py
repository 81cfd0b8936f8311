"""Advice: which setting brings a run within its requirements, or how much room is left in each, by running again."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from itertools import combinations
from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.spec.scenario import Scenario
from cutwise.study.levers import LIMITS, Lever, levers_of
from cutwise.study.trials import NO_END, Budget, Settings, Spent, Trials

_SCAN = 13
_PAIR_SCAN = 7
_HALVINGS = 6
_MOST_HALVINGS = 20  # where the edge is near to what there is
_STEPS = (1, 3, 6, 2, 4, 9, 5, 7, 8, 10, 11, 12)  # of a scan, to both sides: near and far first, for small budgets


class Proposal(NamedTuple):
    """Settings that meet all requirements, nearest to the present ones, and what a run with them gives."""

    settings: Mapping[str, float]  # dotted key: value [SI]
    measures: Mapping[str, float]
    text: str


class Advice(NamedTuple):
    """What came of looking for advice."""

    met: bool  # whether the scenario meets its requirements as it stands
    sentences: tuple[str, ...]
    proposals: tuple[Proposal, ...]
    runs: int  # that were made
    seconds: float  # of processor time
    complete: bool  # whether all that was to be tried was tried


def advise(
    scenario: Scenario, limits: Mapping[str, tuple[str, str]] | None = None, *, pairs: bool = True,
    runs: int | None = None,
) -> tuple[str, ...]:  # fmt: skip
    """What to change, or how much room there is.

    Parameters
    ----------
    scenario : Scenario
        The scenario, with requirements.
    limits : mapping, optional
        Dotted key: lowest and highest value that may be set, as text; the levers of the process by default.
    pairs : bool
        Look for two levers together where none helps alone: hundreds of runs.
    runs : int, optional
        The most runs that may be made.

    Returns
    -------
    tuple of str
        One sentence for each lever that helps (or each pair, if none helps alone); for a scenario that meets its
        requirements, the room in each lever. Nothing without requirements.

    Raises
    ------
    ScenarioFault
        Limits on what is no quantity of the scenario.
    """
    return consult(scenario, limits, pairs=pairs, budget=Budget(runs)).sentences


def propose(
    scenario: Scenario, limits: Mapping[str, tuple[str, str]] | None = None, *, pairs: bool = True
) -> list[Proposal]:
    """Settings that bring a failing scenario within its requirements: one lever, or two where one is not enough."""
    return list(consult(scenario, limits, pairs=pairs).proposals)


def consult(
    scenario: Scenario, limits: Mapping[str, tuple[str, str]] | None = None, *, pairs: bool = True,
    budget: Budget = NO_END, named: str = LIMITS,
) -> Advice:  # fmt: skip
    """Advice with what it cost; see :func:`advise`. Where the budget ends, what has been found until then.

    Every proposal, and every end of the room in a lever, has been run with the step of the scenario.
    """
    if not scenario.requirements:
        return Advice(True, (), (), 0, 0.0, True)
    levers = tuple(lever for lever in levers_of(scenario, limits, named) if lever.low < lever.high)
    trials = Trials(scenario, levers, budget)
    sentences: list[str] = []
    proposals: list[Proposal] = []
    met, complete = trials.keeps(()), True
    try:
        if met:
            for sentence in _rooms(trials, levers):
                sentences.append(sentence)  # those before the budget ends count
        else:
            _find_ways(trials, levers, proposals, pairs=pairs)
    except Spent:
        complete = False
    sentences += [proposal.text for proposal in proposals]
    if not met and not proposals:
        sentences += _no_way(trials, levers, pairs=pairs, complete=complete)
    chances = [name for name, limit in scenario.requirements.items() if limit.probability is not None]
    if chances:
        sentences.append(
            f"this looks at values: with which probability {', '.join(chances)} keep their limits, cutwise run tells"
        )
    if not complete:
        sentences.append(f"stopped after {trials.runs} runs; cutwise advise with a larger budget looks further")
    return Advice(met, tuple(sentences), tuple(proposals), trials.runs, trials.seconds, complete)


def most_runs(levers: tuple[Lever, ...], *, pairs: bool = True) -> int:
    """No consultation of a failing scenario makes more runs than this."""
    single = len(levers) * (_SCAN + _MOST_HALVINGS + 5)
    both = len(levers) * (len(levers) - 1) // 2 * (_PAIR_SCAN**2 + 1) if pairs else 0
    return 2 + 2 * (single + both)  # a second time with the step of the run, where the coarse one does not do


class _Misled(Exception):
    """The coarse step said that something helps which does not."""


def _find_ways(trials: Trials, levers: tuple[Lever, ...], found: list[Proposal], *, pairs: bool) -> None:
    """Put into ``found`` what helps, one lever after the other; then two together, if none helps alone."""
    try:
        _find_with_this_step(trials, levers, found, pairs=pairs)
    except _Misled:
        found.clear()
        _find_with_this_step(trials, levers, found, pairs=pairs)  # that of the run now


def _find_with_this_step(trials: Trials, levers: tuple[Lever, ...], found: list[Proposal], *, pairs: bool) -> None:
    spent = None
    try:
        for place in range(2 * _SCAN):
            for lever in levers:
                if (order := _order(lever))[place:]:
                    trials.margin(_one(lever, order[place]))
    except Spent as why:
        spent = why
    for lever in levers:
        settings = _nearest(lever, trials)
        if settings is not None:
            found.append(_kept_promise(trials, settings))
    if spent is not None:
        raise spent
    if found or not pairs:
        return
    for pair in combinations(levers, 2):
        settings = _nearest_pair(pair, trials)
        if settings is not None:
            found.append(_kept_promise(trials, settings))


def _order(lever: Lever) -> list[float]:
    """The values of a scan, from the present one to both sides."""
    grid = _grid(lever)
    now = 0.5 * (lever.low + lever.high) if lever.now is None else lever.now
    start = min(range(_SCAN), key=lambda i: abs(grid[i] - now))
    places = [start, *(start + sign * step for step in _STEPS for sign in (-1, 1))]
    return list(dict.fromkeys(grid[i] for i in places if 0 <= i < _SCAN))


def _kept_promise(trials: Trials, settings: Settings) -> Proposal:
    """The proposal, run with the step of the scenario.

    Raises
    ------
    _Misled
        It does not keep what it promised.
    """
    if trials.keeps(settings) or not trials.trusted:
        return _proposal(trials, settings)
    trials.distrust()
    raise _Misled


def _grid(lever: Lever) -> list[float]:
    grid = np.linspace(lever.low, lever.high, _SCAN)
    return [float(round(v)) if lever.whole else float(v) for v in grid]


def _one(lever: Lever, value: float) -> Settings:
    return ((lever.key, value),)


def _scanned(lever: Lever, trials: Trials) -> list[float]:
    """Values of the scan that pass; those that the budget did not reach do not count."""
    good = []
    for value in _grid(lever):
        with suppress(Spent):
            if trials.margin(_one(lever, value)) >= 0.0:
                good.append(value)
    return good


def _nearest(lever: Lever, trials: Trials) -> Settings | None:
    """The value nearest to the present one that meets the requirements, a little inside.

    Of a setting that the scenario does not write, the largest value that does.
    """
    good = _scanned(lever, trials)
    if not good:
        return None
    now = lever.high if lever.now is None else lever.now
    best = min(good, key=lambda v: abs(v - now))
    if best == now:
        return _one(lever, best)
    chosen = best
    with suppress(Spent):  # the value of the scan will do
        edge = _edge(lever, trials, best, now)
        inside = edge + 0.1 * (best - edge)  # a little more than the least that passes
        chosen = inside if trials.margin(_one(lever, inside)) >= 0.0 else best
        chosen = _rounded(lever, chosen, trials)
    return _one(lever, chosen)


def _rounded(lever: Lever, value: float, trials: Trials) -> float:
    """The value to two figures where it still passes, else to three, else as it is."""
    if lever.whole:
        return float(round(value))
    for digits in (2, 3):
        if lever.given:
            short = float(f"{value:.{digits}g}")
        else:
            number, _ = units.displayed(value, lever.dimension)
            text = f"{number:.{digits}g} {units.DIMENSIONS[lever.dimension].display}"
            short = units.parse(text.strip(), lever.dimension)
        if lever.low <= short <= lever.high and trials.margin(_one(lever, short)) >= 0.0:
            return short
    return value


def _edge(lever: Lever, trials: Trials, good: float, bad: float) -> float:
    """Last passing value between a good and a bad one, also where it is much nearer to the good one."""
    start = good
    for number in range(_MOST_HALVINGS):
        if lever.whole and abs(bad - good) <= 1.0:
            break
        if number >= _HALVINGS and abs(bad - good) < 0.1 * abs(good - start):
            break
        middle = float(round(0.5 * (good + bad))) if lever.whole else 0.5 * (good + bad)
        if trials.margin(_one(lever, middle)) >= 0.0:
            good = middle
        else:
            bad = middle
    return good


def _nearest_pair(pair: tuple[Lever, ...], trials: Trials) -> Settings | None:
    grids = [np.linspace(lever.low, lever.high, _PAIR_SCAN) for lever in pair]
    best: tuple[float, Settings] | None = None
    for a in grids[0]:
        for b in grids[1]:
            settings = ((pair[0].key, float(a)), (pair[1].key, float(b)))
            if trials.margin(settings) < 0.0:
                continue
            far = sum(
                abs(v - (lever.high if lever.now is None else lever.now)) / (lever.high - lever.low)
                for v, lever in zip((a, b), pair, strict=True)
            )
            if best is None or far < best[0]:
                best = (far, settings)
    return best[1] if best else None


def _proposal(trials: Trials, settings: Settings) -> Proposal:
    """What to change, and what the run with it gives."""
    measures = trials.exact(settings).measures
    turns = " and ".join(f"{trials.levers[key].name} {_turn(trials.levers[key], value)}" for key, value in settings)
    return Proposal(dict(settings), measures, f"change {turns}: a run with it gives {_outcome(trials, measures)}")


def _outcome(trials: Trials, measures: Mapping[str, float]) -> str:
    scenario = trials.scenario
    return ", ".join(
        f"{name} {units.show(measures[name], scenario.measures[name].dimension, 3)}"
        for name in scenario.requirements
        if name in measures
    )


def _turn(lever: Lever, value: float) -> str:
    """From what to what."""
    if lever.given:
        return f"to {lever.shown(value)} what it is"
    return f"{lever.shown(lever.now)} -> {lever.shown(value)}"


def _no_way(trials: Trials, levers: tuple[Lever, ...], *, pairs: bool, complete: bool) -> Iterator[str]:
    """What to say where nothing helps: what was tried, and what came nearest."""
    if not levers:
        yield "this scenario has none of the settings that advice turns by itself: name some, with limits"
        return
    tried = ", ".join(f"{lever.name} {lever.shown(lever.low)} to {lever.shown(lever.high)}" for lever in levers)
    beyond = "and no pair of them " if pairs and complete and len(levers) > 1 else ""
    hint = "" if pairs or len(levers) < 2 else "; cutwise advise looks for two together"
    if complete:
        yield f"no single lever {beyond}meets the requirements within its limits ({tried}){hint}"
    else:
        yield f"nothing that was tried meets the requirements (levers: {tried})"
    nearest = _came_nearest(trials, levers)
    if nearest is not None:
        lever, value = nearest
        outcome = _outcome(trials, trials.measured(_one(lever, value)))
        yield f"nearest comes {lever.name} {_turn(lever, value)}: a run with it gives {outcome}"


def _came_nearest(trials: Trials, levers: tuple[Lever, ...]) -> tuple[Lever, float] | None:
    """The value of one lever with the least that is missing, if that is less than as it stands."""
    best, where = trials.margin_known(()), None
    for lever in levers:
        for value in _grid(lever):
            found = trials.margin_known(_one(lever, value))
            if found is not None and np.isfinite(found) and (best is None or found > best):
                best, where = found, (lever, value)
    return where


def _rooms(trials: Trials, levers: tuple[Lever, ...]) -> Iterator[str]:
    for lever in levers:
        yield _room(lever, trials) if lever.now is not None else _span(lever, trials)


def _span(lever: Lever, trials: Trials) -> str:
    """What may be written for a setting that the scenario leaves to its program or to a default."""
    good = _scanned(lever, trials)
    tried = sum(trials.margin_known(_one(lever, value)) is not None for value in _grid(lever))
    if not tried:
        raise Spent  # nothing is known of this one
    shown = ", ".join(lever.shown(value) for value in good)
    return f"{lever.name} is not written; of {tried} values these pass: {shown or 'none'}"


def _room(lever: Lever, trials: Trials) -> str:
    """How far a lever may be turned each way before a requirement is missed."""
    assert lever.now is not None
    ends: list[tuple[float, str]] = []
    for limit in (lever.low, lever.high):
        end, said = _end(lever, trials, limit)
        if trials.trusted and end != lever.now and not trials.keeps(_one(lever, end)):
            trials.distrust()  # and look again with the step of the run
            end, said = _end(lever, trials, limit)
        ends.append((end, said))
    values = {end for end, _ in ends} | {lever.now}
    figures = next((f for f in range(3, 7) if len({lever.shown(v, f) for v in values}) == len(values)), 3)
    low, high = (lever.shown(end, figures) + said for end, said in ends)
    return f"room in {lever.name} (now {lever.shown(lever.now, figures)}): from {low} to {high}"


def _end(lever: Lever, trials: Trials, limit: float) -> tuple[float, str]:
    """The last passing value on the way to a limit."""
    assert lever.now is not None
    good = lever.now
    for value in np.linspace(lever.now, limit, 4)[1:]:
        step = float(round(value)) if lever.whole else float(value)
        if trials.margin(_one(lever, step)) < 0.0:
            return _edge(lever, trials, good, step), ""
        good = step
    return limit, " (limit)"
