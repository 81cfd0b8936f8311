"""Deburring: time stepping over all five stages (Berselli et al. 2016, Fig. 8), or each place of the edge at rest."""

from cutwise.process import (
    assemble,
    carried,
    carriers,
    deburring,
    deburring_part,
    edge_findings,
    edge_stages,
    still_deburring,
)
from cutwise.process.convergence import divided
from cutwise.process.recipes import STUDY_STEP, Method, Progress, Recipe, Wanted, coarser, halved
from cutwise.spec.deburring import DeburringScenario

_SOURCES = ("berselli2016", "altintas2012")


def _stepped(scenario: DeburringScenario, wanted: Wanted, progress: Progress | None) -> deburring.EdgeRun:
    """The pass; coarse: at least 100 µs of step with averaged forces over arcs.

    The plateaus of the band, as much work as half of the pass, are found for a coarse one only where they are read.
    """
    step = scenario.numerics.time_step
    if wanted.coarse and coarser(scenario):
        step = max(step, STUDY_STEP)
    plateaus = not wanted.coarse or wanted.any(deburring.PLATEAUS)
    teeth = wanted.whole or any(name.startswith("tooth_") for name in wanted.names)
    return deburring.passed(scenario, step, progress, plateaus=plateaus, teeth=teeth)


STEPPED = Method(
    run=_stepped,
    measures=deburring.measures,
    stages=lambda scenario, run, _: edge_stages.stages(scenario, run),
    findings=lambda scenario, run, _: (*edge_findings.unsound(scenario, run), *edge_findings.weight(run)),
    limits=lambda *_: edge_findings.LIMITS,
    references=lambda *_: _SOURCES,
    warnings=edge_findings.warnings,
    infeasible=lambda scenario, _, found: carried.too_fast(found, scenario.operation.feed),
    notes=edge_findings.notes,
    bands=deburring.histories,
    change=halved(lambda scenario, _, progress: deburring.measures(
        scenario, deburring.passed(scenario, 0.5 * scenario.numerics.time_step, progress)
    )),
)  # fmt: skip

STILL = Method(
    run=lambda scenario, *_: still_deburring.run(scenario),
    measures=still_deburring.measures,
    stages=lambda scenario, done, _: still_deburring.stages(scenario, done),
    findings=lambda _, done, __: still_deburring.findings(done),
    limits=lambda *_: still_deburring.LIMITS,
    references=lambda *_: _SOURCES,
    warnings=lambda scenario, done, _: carriers.warnings(scenario, [done.cut.carriage], scenario.part.block),
    infeasible=lambda scenario, _, found: carried.too_fast(found, scenario.operation.feed),
    notes=lambda _, done, __: still_deburring.notes(done),
    change=halved(lambda scenario, *_: still_deburring.measures(
        scenario, still_deburring.run(divided(scenario, "station"))
    )),
)  # fmt: skip

RECIPE = Recipe(
    lambda scenario: STILL if scenario.numerics.mode == "still" else STEPPED,
    lambda scenario: assemble.edge_cut(deburring_part.on_part(scenario)),
    deburring_part.on_part,
)
