"""Runs of variants of one scenario, each made once and counted, within a budget."""

import time
from collections.abc import Mapping
from typing import NamedTuple

from cutwise import units
from cutwise.io.revision import Value
from cutwise.process.recipes import coarser
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.scenario import Scenario
from cutwise.study.case import Case, cases, faithful
from cutwise.study.levers import Lever
from cutwise.study.limits import slack

Settings = tuple[tuple[str, float], ...]


class Budget(NamedTuple):
    """How much may be spent on variants; None: no end."""

    runs: int | None = None
    seconds: float | None = None  # of processor time


NO_END = Budget()


def read_budget(text: str) -> Budget:
    """``200`` (runs) or ``30 s`` (of processor time).

    Raises
    ------
    ScenarioFault
        Neither.
    """
    try:
        if text.strip().isdigit() and int(text) > 0:
            return Budget(int(text))
        seconds = units.parse(text, "time")
    except (units.UnitFault, ValueError):
        seconds = 0.0
    if seconds > 0.0:
        return Budget(None, seconds)
    raise ScenarioFault(
        [Fault((), f'"{text}" is neither a number of runs nor a time; write 200 or "30 s"', file="--budget")]
    )


class Spent(Exception):
    """The budget is spent."""


class Trials:
    """Evaluates settings of levers, with the coarse step of studies as long as that gives the numbers of the run."""

    def __init__(self, scenario: Scenario, levers: tuple[Lever, ...], budget: Budget) -> None:
        self.scenario, self.levers, self.budget = scenario, {lever.key: lever for lever in levers}, budget
        self.runs, self.started = 0, time.process_time()
        self._reserve = min(len(levers), budget.runs // 3) if budget.runs is not None else 0  # to prove what is said
        self._exact, self._coarse = cases(scenario), cases(scenario, coarse=True)
        self._proving = False
        self._kept: dict[tuple[Settings, bool], Case] = {}
        self.start, self._trusted = self.exact(()), coarser(scenario)
        if self._trusted:
            coarse = self._run((), coarse=True)
            self._trusted = faithful(scenario, coarse.measures, self.start.measures, tuple(scenario.requirements))

    @property
    def seconds(self) -> float:
        """Processor time so far [s]."""
        return time.process_time() - self.started

    def distrust(self) -> None:
        """From here on every run takes the step of the scenario."""
        self._trusted = False

    @property
    def trusted(self) -> bool:
        """Whether the coarse step is taken."""
        return self._trusted

    def exact(self, settings: Settings) -> Case:
        """The case as its run gives it."""
        return self._run(settings, coarse=False)

    def margin(self, settings: Settings) -> float:
        """Smallest slack over all requirements, relative to the limit; below zero one is missed."""
        return slack(self.scenario, self._run(settings, coarse=self._trusted).outcome)

    def margin_known(self, settings: Settings) -> float | None:
        """The margin of settings that have been run already."""
        found = self._known(settings)
        return None if found is None else slack(self.scenario, found.outcome)

    def measured(self, settings: Settings) -> Mapping[str, float]:
        """The measures of settings that have been run already."""
        found = self._known(settings)
        return found.measures if found is not None else {}

    def _known(self, settings: Settings) -> Case | None:
        return self._kept.get((settings, False)) or self._kept.get((settings, True))

    def keeps(self, settings: Settings) -> bool:
        """Whether the run with these settings meets the requirements."""
        self._proving = True
        try:
            return slack(self.scenario, self.exact(settings).outcome) >= 0.0
        finally:
            self._proving = False

    def _run(self, settings: Settings, *, coarse: bool) -> Case:
        known = self._kept.get((settings, coarse))
        if known is not None:
            return known
        if self.runs and self._spent(self._reserve if coarse or not self._proving else 0):
            raise Spent
        self.runs += 1
        evaluate = self._coarse if coarse else self._exact
        found = evaluate(values_of(self.scenario, self.levers, settings))
        self._kept[settings, coarse] = found
        return found

    def _spent(self, reserve: int) -> bool:
        most, seconds = self.budget
        return (most is not None and self.runs >= most - reserve) or (seconds is not None and self.seconds >= seconds)


def values_of(scenario: Scenario, levers: Mapping[str, Lever], settings: Settings) -> dict[str, Value]:
    """Levers turned, as values of the scenario; a longer lead-in lengthens the run, so that the steady part stays."""
    values: dict[str, Value] = {key: levers[key].written(value) for key, value in settings}
    turned = dict(settings)
    lead_in, now = turned.get("operation.lead_in_time"), levers.get("operation.lead_in_time")
    if lead_in is not None and now is not None and now.now is not None:
        run = scenario.operation.run_time + lead_in - now.now  # type: ignore[attr-defined]
        feed = turned.get("operation.feed", scenario.operation.feed)  # type: ignore[attr-defined]
        given = scenario.operation.duration is not None  # type: ignore[attr-defined]
        values["operation.duration" if given else "operation.length"] = (
            units.text(run, "time") if given else units.text(run * feed, "length")
        )
    return values
