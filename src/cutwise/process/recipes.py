"""How every process is run: one course from scenario to result, and one for the cases of studies.

What a process does itself stands in its :class:`Method`, beside its recipe (:mod:`cutwise.process.presets`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

from cutwise.later import later
from cutwise.process import convergence as converged
from cutwise.process.convergence import change_on_halved_step
from cutwise.process.labels import Groups, tree
from cutwise.results import (
    Finding,
    Histories,
    Infeasible,
    Measure,
    Place,
    Result,
    Said,
    SolverFailure,
    in_words,
    judge,
    unreached,
    warned,
)
from cutwise.spec.faults import dotted
from cutwise.spec.kinds import Registered
from cutwise.spec.notices import noticed
from cutwise.spec.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")

Progress = Callable[[float], None]
Found = Mapping[str, float]
"""Measures in SI."""

Asked = TypeVar("Asked", bound=Scenario)
Done = TypeVar("Done")

_MOOT = frozenset({"unstable", "tip_lost"})  # whose numbers no finer step settles
STUDY_STEP = 100e-6  # [s] moves the edge error of the reference case by 0.07 µm


class Outcome(NamedTuple):
    """What studies need of a run: the measures in SI, and what there is to say about them."""

    measures: Found
    findings: tuple[Finding, ...] = ()
    warnings: tuple[Said, ...] = ()  # those of the run, but for what takes a second run with half the step
    infeasible: tuple[Said, ...] = ()


class Wanted(NamedTuple):
    """What somebody will read of a run."""

    names: frozenset[str] = frozenset()  # measures that are required or asked for
    whole: bool = True  # a whole run: every measure, and what helps where something is wrong
    coarse: bool = False  # one of hundreds of variants: a larger step where that is known to do

    def any(self, names: Iterable[str]) -> bool:
        """Whether one of these measures is read."""
        return self.whole or not self.names.isdisjoint(names)


EVERYTHING = Wanted()


def _nothing(scenario: Any, done: Any, found: Found) -> tuple[()]:
    """What most processes have to say of most things."""
    del scenario, done, found
    return ()


def _none(scenario: Any, done: Any, found: Found) -> dict[str, Any]:
    del scenario, done, found
    return {}


@dataclass(frozen=True, slots=True)
class Method(Generic[Asked, Done]):
    """How one kind of run is done, and how it is read; every reading has scenario, run and measures."""

    run: Callable[[Asked, Wanted, Progress | None], Done]
    measures: Callable[[Asked, Done], Found]
    stages: Callable[[Asked, Done, Found], Groups | xr.DataTree]
    findings: Callable[[Asked, Done, Found], Iterable[Finding]]
    limits: Callable[[Asked, Done], tuple[str, ...]]
    references: Callable[[Asked, Done], tuple[str, ...]]
    warnings: Callable[[Asked, Done, Found], Iterable[Said]] = _nothing
    infeasible: Callable[[Asked, Done, Found], Iterable[Said]] = _nothing
    notes: Callable[[Asked, Done, Found], Mapping[str, str]] = _none
    bands: Callable[[Asked, Done, Found], Mapping[str, Histories]] = _none
    advice: Callable[[Asked, Done, Found], tuple[str, ...]] = _nothing
    change: Callable[[Asked, Done, Found, Progress | None], Found] | None = None  # of measures, when the step is halved
    share: float = 1.0 / 3.0  # of the time that the run itself takes


def halved(
    finer: Callable[[Asked, Done, Progress | None], Found], *, shares: bool = True
) -> Callable[[Asked, Done, Found, Progress | None], Found]:
    """The change of measures against those of a run with half the step; ``shares``: of the terms too."""

    def change(scenario: Asked, done: Done, found: Found, progress: Progress | None) -> Found:
        return change_on_halved_step(found, finer(scenario, done, progress), shares=shares)

    return change


class Recipe(NamedTuple):
    """How a process is run: by which method, and how far faults are looked for; its row in ``spec.kinds`` names it."""

    method: Callable[[Any], Method[Any, Any]]
    prepare: Callable[[Any], object]
    read: Callable[[Any], Any] = lambda scenario: scenario  # the scenario with what stands in its files


RECIPES: Mapping[str, Recipe] = Registered("recipe")


def simulate(scenario: Scenario, progress: Progress | None = None) -> Result:
    """Run a scenario.

    Parameters
    ----------
    scenario : Scenario
        What to simulate, from :func:`cutwise.load` or built in Python.
    progress : callable, optional
        Called with the finished share, 0 to 1, now and then.

    Returns
    -------
    Result
        Histories of all stages, measures, verdict and warnings.
    """
    try:
        return _whole(RECIPES[scenario.process], scenario, progress)
    except Infeasible as why:
        return collect(scenario, {}, stages=xr.DataTree(), warnings=_of_scenario(scenario), infeasible=(why.finding,))


def _whole(recipe: Recipe, scenario: Scenario, progress: Progress | None) -> Result:
    scenario = recipe.read(scenario)
    how = recipe.method(scenario)
    done = how.run(scenario, EVERYTHING, _part(progress, 0.0, how.share))
    found = how.measures(scenario, done)
    change = how.change(scenario, done, found, _part(progress, how.share, 1.0)) if how.change else {}
    if progress is not None:
        progress(1.0)
    return collect(
        scenario,
        found,
        stages=tree(done, how.stages(scenario, done, found)),
        findings=how.findings(scenario, done, found),
        bands=how.bands(scenario, done, found),
        warnings=_said(how, scenario, done, found),
        infeasible=how.infeasible(scenario, done, found),
        limits=how.limits(scenario, done),
        convergence=change,
        notes=how.notes(scenario, done, found),
        advice=how.advice(scenario, done, found),
        references=how.references(scenario, done),
    )


def _of_scenario(scenario: Scenario) -> Iterator[Finding]:
    """What is unusual about the scenario, as records of a run."""
    for one in noticed(scenario):
        place = Place(dotted(one.path))
        yield warned(one.code, one.words, one.value, one.limit, one.dimension, where=place)


def _said(how: Method[Any, Any], scenario: Scenario, done: object, found: Found) -> Iterable[Finding]:
    """What is unusual about the scenario, then what the run warns of, each once; a bare sentence (of a file) too."""
    said: dict[str, Finding] = {}
    for one in (*_of_scenario(scenario), *how.warnings(scenario, done, found)):
        record = warned("noticed", one) if isinstance(one, str) else one
        said.setdefault(record.words, record)
    return said.values()


def prepare(scenario: Scenario) -> None:
    """Find the faults that show only when a run is built, without running it.

    Raises
    ------
    ScenarioFault
        All of them.
    """
    RECIPES[scenario.process].prepare(scenario)


def coarser(scenario: Scenario) -> bool:
    """Whether a coarse outcome takes another step than the run: with averaged forces over arcs."""
    return (
        scenario.process == "deburr"
        and scenario.numerics.mode == "step"  # type: ignore[attr-defined]
        and scenario.numerics.force == "averaged"  # type: ignore[attr-defined]
        and scenario.tool.runout == 0.0  # type: ignore[attr-defined]
        and scenario.numerics.time_step < STUDY_STEP  # type: ignore[attr-defined]
    )


def quick_outcome(scenario: Scenario, wanted: Collection[str] = (), *, coarse: bool = False) -> Outcome:
    """What a run comes to, without histories and convergence: its measures in SI and its warnings.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    wanted : collection of str
        Measures that take long, which are left out unless a requirement or this names them.
    coarse : bool
        For hundreds of variants: a larger step where that is known to do, and no warnings. Otherwise every measure is
        that of the run to the last bit.
    """
    recipe, asked = RECIPES[scenario.process], Wanted(frozenset((*scenario.requirements, *wanted)), False, coarse)
    try:
        scenario = recipe.read(scenario)
        how = recipe.method(scenario)
        done = how.run(scenario, asked, None)
        found = how.measures(scenario, done)
        return Outcome(
            found,
            tuple(how.findings(scenario, done, found)),
            () if coarse else in_words(_said(how, scenario, done, found)),
            in_words(how.infeasible(scenario, done, found)),
        )
    except Infeasible as why:
        return Outcome({}, infeasible=(str(why),))


def quick_measures(scenario: Scenario, wanted: Collection[str] = ()) -> Found:
    """The measures of a coarse :func:`quick_outcome`."""
    return quick_outcome(scenario, wanted, coarse=True).measures


def collect(
    scenario: Scenario,
    found: Found,
    *,
    findings: Iterable[Finding] = (),
    warnings: Iterable[Said] = (),
    infeasible: Iterable[Said] = (),
    bands: Mapping[str, Histories] | None = None,
    convergence: Mapping[str, float] | None = None,
    **parts: object,
) -> Result:
    """A result: measures with their dimension and meaning, held against the requirements; findings, the worst first.

    What rows say as records is among the findings, and in words among what cannot be done or the warnings.
    """
    known = type(scenario).measures
    wild = [name for name, value in found.items() if not math.isfinite(value)]
    if wild:
        raise SolverFailure(
            f"no finite number came out for {', '.join(wild)}: a load, a size or a stiffness is out of scale"
        )
    measures = {name: Measure(value, *known[name]) for name, value in found.items()}
    checks, change = tuple(judge(scenario, measures, bands)), convergence or {}
    sound = tuple(findings)
    moved = () if any(f.code in _MOOT for f in sound) else converged.findings(scenario, found, change)
    cannot, told = tuple(infeasible), tuple(warnings)
    said = (*sound, *unreached(checks), *moved, *(one for one in (*cannot, *told) if isinstance(one, Finding)))
    return Result(
        scenario=scenario, measures=measures, checks=checks, convergence=change,
        findings=tuple(sorted(said, key=lambda finding: finding.rank)), warnings=in_words(told),
        infeasible=in_words(cannot), **parts,  # type: ignore[arg-type]
    )  # fmt: skip


def _part(progress: Progress | None, start: float, end: float) -> Progress | None:
    if progress is None:
        return None
    return lambda share: progress(start + (end - start) * share)
