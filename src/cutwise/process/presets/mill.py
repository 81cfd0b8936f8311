"""Milling with CNC drives (Ozcan et al. 2017, sec. 2-3), as programmed along a wall, or in a stock in 3D."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from cutwise.later import later
from cutwise.process.labels import Groups
from cutwise.process.recipes import Method, Progress, Recipe, Wanted, halved

if TYPE_CHECKING:
    from cutwise.process import (
        carried,
        chatter,
        milling,
        milling_compare,
        milling_findings,
        milling_measures,
        milling_stability,
        milling_stages,
        milling_wall,
        programmed_milling,
        spindle_load,
        stock_deviation,
        stock_findings,
        stock_measures,
        stock_setups,
        stock_stages,
    )
    from cutwise.process.milling import MillRun
    from cutwise.process.programmed_milling import Milled
    from cutwise.process.stock_deviation import Judged
    from cutwise.process.stock_setups import Done
    from cutwise.spec.milling import MillingScenario
else:  # a run imports its own kind of milling, not the others
    carried = later("cutwise.process.carried")
    chatter = later("cutwise.process.chatter")
    milling = later("cutwise.process.milling")
    milling_compare = later("cutwise.process.milling_compare")
    milling_findings = later("cutwise.process.milling_findings")
    milling_measures = later("cutwise.process.milling_measures")
    milling_stability = later("cutwise.process.milling_stability")
    milling_stages = later("cutwise.process.milling_stages")
    milling_wall = later("cutwise.process.milling_wall")
    programmed_milling = later("cutwise.process.programmed_milling")
    spindle_load = later("cutwise.process.spindle_load")
    stock_deviation = later("cutwise.process.stock_deviation")
    stock_findings = later("cutwise.process.stock_findings")
    stock_measures = later("cutwise.process.stock_measures")
    stock_setups = later("cutwise.process.stock_setups")
    stock_stages = later("cutwise.process.stock_stages")


class InStock(NamedTuple):
    """A run in a stock in 3D, and how it is off the part."""

    cut: Done
    off: Judged | None


def _driven(scenario: MillingScenario, wanted: Wanted, progress: Progress | None) -> MillRun:
    """The drives; whether the tool chatters always belongs to it."""
    run = milling.run(scenario, scenario.numerics.substeps, progress)
    return run._replace(chatter=milling.stability(scenario, run), helped=wanted.whole)


def _of_driven(scenario: MillingScenario, run: MillRun) -> dict[str, float]:
    found = milling_measures.measures(scenario, run)
    return found | (milling_stability.measures(run.chatter) if run.chatter is not None else {})


def _stages(scenario: MillingScenario, run: MillRun, _: object) -> Groups:
    told: dict[str, Any] = {**milling_stages.GROUPS}
    if run.wall is not None:
        told |= milling_wall.stages(run.wall)
    compared = milling_compare.comparison_table(milling_compare.compare(scenario), scenario.measures)
    told |= {} if compared is None else {"comparison": compared}
    if run.chatter is not None:
        told["lobes"] = milling_stability.lobe_diagram(scenario, run.chatter)
        told["vibration"] = milling_stability.vibration(run.chatter)
    return told


DRIVEN: Method[MillingScenario, MillRun] = Method(
    run=_driven,
    measures=_of_driven,
    stages=_stages,
    findings=lambda scenario, run, _: milling_findings.unsound(scenario, run, run.chatter, helped=run.helped),
    limits=lambda _, run: milling_findings.limits(run),
    references=lambda *_: ("ozcan2017", "altintas2012", "erkorkmaz2001"),
    infeasible=lambda scenario, run, _: spindle_load.overloads(scenario, run),
    warnings=lambda scenario, run, found: milling_findings.warnings(scenario, run, found),
    notes=lambda scenario, run, _: milling_findings.notes(scenario, run),
    change=halved(lambda scenario, _, progress: milling_measures.measures(
        scenario, milling.run(scenario, 2 * scenario.numerics.substeps, progress)
    ), shares=False),
)  # fmt: skip


def _in_stock(scenario: MillingScenario, _: Wanted, progress: Progress | None) -> InStock:
    cut = stock_setups.run(scenario, progress)
    return InStock(cut, stock_deviation.judged(scenario, cut))


IN_STOCK = Method(
    run=_in_stock,
    measures=lambda _, done: stock_measures.measures(*done),
    stages=lambda _, done, __: stock_stages.stages(*done),
    findings=lambda _, done, __: stock_findings.findings(done.cut),
    limits=lambda _, done: stock_findings.limits(done.cut),
    references=lambda *_: ("altintas2012", "engin2001", "gradisek2004"),
    warnings=lambda scenario, done, _: stock_findings.warnings(scenario, *done),
    notes=lambda _, done, __: stock_findings.notes(*done),
    share=0.9,
)

PROGRAMMED: Method[MillingScenario, Milled] = Method(
    run=lambda scenario, _, progress: programmed_milling.run(scenario, progress=progress),
    measures=lambda scenario, done: programmed_milling.measures(scenario, done),
    stages=lambda scenario, done, _: programmed_milling.stages(scenario, done),
    findings=lambda scenario, done, found: (
        *programmed_milling.findings(scenario, done), *chatter.findings(found, "arm")
    ),
    limits=lambda scenario, _: programmed_milling.limits_of(scenario),
    references=lambda *_: ("altintas2012", "altintas1995"),
    warnings=lambda scenario, done, _: programmed_milling.warnings(scenario, done),
    infeasible=lambda scenario, _, found: carried.too_fast(found, scenario.operation.feed),
    notes=lambda scenario, done, _: programmed_milling.notes(scenario, done),
    change=halved(lambda scenario, _, progress: programmed_milling.measures(
        scenario, programmed_milling.run(scenario, limits=False, finer=2, progress=progress)
    ), shares=False),
)  # fmt: skip


def _method(scenario: MillingScenario) -> Method[Any, Any]:
    return IN_STOCK if scenario.in_3d else PROGRAMMED if scenario.programmed else DRIVEN


def _prepare(scenario: MillingScenario) -> object:
    how = stock_setups if scenario.in_3d else programmed_milling if scenario.programmed else milling
    return how.prepare(scenario)


RECIPE = Recipe(_method, _prepare)
