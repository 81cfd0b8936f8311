"""Set-ups one after the other: each cut along its own axis into what those before it, and earlier runs, have left."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np

from cutwise.maths.workpiece import Frame, frame_of
from cutwise.process.nominal_part import nominal_samples
from cutwise.process.stock_earlier import EarlierRun, earlier_run
from cutwise.process.stock_loop import Progress, part_of
from cutwise.process.stock_material import Raw, raw_of, raw_seen
from cutwise.process.stock_milling import Earlier, StockRunDone, check_fixtures, prepare_one, run_one
from cutwise.process.stock_plan import Planned, planned
from cutwise.process.stock_real import Cut, moves_the_tool, prepare_real, real
from cutwise.spec.faults import ScenarioFault, all_faults
from cutwise.spec.milling import MillingScenario
from cutwise.spec.stock import StockRun

Made = TypeVar("Made")


class Job(NamedTuple):
    """A set-up to be run."""

    scenario: MillingScenario  # with its program, tools and fixtures
    frame: Frame
    number: int  # from 1; 0: there is only one


class Done(NamedTuple):
    """All set-ups of a scenario that have been run, in their order."""

    raw: Raw  # in the coordinates of the part
    jobs: tuple[Job, ...]
    cuts: tuple[Cut, ...]
    earlier: EarlierRun | None

    @property
    def moved(self) -> bool:
        """Whether something moves a tool beside its path."""
        return any(cut.real is not None for cut in self.cuts)

    def left(self, ideal: bool) -> tuple[StockRunDone, ...]:
        """The runs that make the surface: as planned, or as the cell runs them."""
        return tuple(cut.ideal if ideal else cut.left for cut in self.cuts)

    def solids(self, grid: float, ideal: bool) -> tuple[Earlier, ...]:
        """What earlier runs, on a grid [m], and these set-ups have left."""
        before = self.earlier.swept(grid) if self.earlier is not None else ()
        return (*before, *(Earlier(run.solid, job.frame) for run, job in zip(self.left(ideal), self.jobs, strict=True)))


def jobs_of(scenario: MillingScenario) -> tuple[Job, ...]:
    """The set-ups of a scenario."""
    if not scenario.setups:
        return (Job(scenario, Frame(np.eye(3), np.zeros(3)), 0),)
    jobs = []
    for number, setup in enumerate(scenario.setups, start=1):
        own = {"program": setup.program, "fixtures": setup.fixtures, "setups": ()}
        if setup.tools:
            own |= {"tools": setup.tools, "tool": None}
        frame = frame_of(np.array(setup.axis), np.array(setup.zero), setup.rotation)
        jobs.append(Job(scenario.model_copy(update=own), frame, number))
    return tuple(jobs)


def stock_of(scenario: MillingScenario) -> tuple[Raw, EarlierRun | None]:
    """The stock in the coordinates of the part, and the run that left it.

    Raises
    ------
    ScenarioFault
        A file cannot be used.
    """
    assert scenario.stock is not None
    if isinstance(scenario.stock, StockRun):
        before = earlier_run(scenario.stock.run)
        return before.raw, before
    return raw_of(scenario.stock, ("stock",)), None


def prepare(scenario: MillingScenario) -> None:
    """Build what a run stands on, without running it.

    Raises
    ------
    ScenarioFault
        All that is wrong with programs, tools, stock, part and fixtures.
    """
    raws: list[Raw] = []
    jobs: list[Callable[[], object]] = [lambda: raws.append(stock_of(scenario)[0])]
    if scenario.nominal is not None:
        jobs.append(lambda: nominal_samples(scenario, 100))
    for job in jobs_of(scenario):
        jobs.append(partial(_placed, job, partial(_prepared, job, raws)))
        jobs.append(partial(_placed, job, partial(check_fixtures, job.scenario)))
    all_faults(*jobs)


def planned_of(job: Job, raw: Raw) -> Planned:
    """The program of a set-up over the stock as that set-up has it."""
    return planned(job.scenario, raw_seen(raw, job.frame))


def _prepared(job: Job, raws: Sequence[Raw]) -> None:
    """What a check finds out of a set-up; without a stock it finds nothing."""
    if not raws:
        return
    ready = planned_of(job, raws[0])
    all_faults(lambda: prepare_one(job.scenario, ready), lambda: prepare_real(job.scenario, ready))


def _placed(job: Job, work: Callable[[], Made]) -> Made:
    """Faults of the program, tools and fixtures of a set-up have the keys of that set-up."""
    try:
        return work()
    except ScenarioFault as found:
        if not job.number:
            raise
        here = ("setups", job.number - 1)
        raise ScenarioFault([
            replace(fault, path=(*here, *fault.path)) if fault.path[:1] in (("program",), ("fixtures",)) else fault
            for fault in found.faults
        ]) from None  # fmt: skip


def run(scenario: MillingScenario, progress: Progress | None = None) -> Done:
    """All set-ups, each as planned and, where something moves the tool, as the cell runs it.

    Raises
    ------
    ScenarioFault
        With everything that is wrong, before anything is cut.
    """
    jobs = jobs_of(scenario)
    try:
        raw, before = stock_of(scenario)
        if scenario.nominal is not None:
            nominal_samples(scenario, 100)
        ready = [_placed(job, partial(planned_of, job, raw)) for job in jobs]
        for job in jobs:
            _placed(job, partial(check_fixtures, job.scenario))
    except ScenarioFault:
        prepare(scenario)
        raise
    done = Done(raw, (), (), before)
    for number, (job, one) in enumerate(zip(jobs, ready, strict=True)):
        part = part_of(progress, number / len(jobs), (number + 1) / len(jobs))
        done = done._replace(cuts=(*done.cuts, _run_one(job, one, done, part)), jobs=(*done.jobs, job))
    return done


def _run_one(job: Job, ready: Planned, done: Done, progress: Progress | None) -> Cut:
    """One set-up into what is left."""
    moved = bool(moves_the_tool(job.scenario))
    part = part_of(progress, 0.0, 0.3 if moved else 1.0)
    as_planned = run_one(job.scenario, ready, job.frame, lambda grid: done.solids(grid, True), part)
    where = (job.frame, done.solids(as_planned.grid, False)) if moved else (job.frame, ())
    return Cut(as_planned, real(job.scenario, as_planned, where, part_of(progress, 0.3, 1.0)))
