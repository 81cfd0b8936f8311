"""Chamfer of constant width: path, proof by sweep, forces along it, and a spindle that yields to them."""

from cutwise.process import carried, chamfer, chamfer_findings, chamfer_measures, chamfer_stages
from cutwise.process.recipes import Method, Progress, Recipe, Wanted
from cutwise.spec.chamfer import ChamferScenario


def _run(scenario: ChamferScenario, wanted: Wanted, progress: Progress | None) -> chamfer.ChamferRun:
    """All of it; for a study the band of set-up errors only where a measure of it is read, and no program for a coarse one."""
    if wanted.whole:
        return chamfer.run(scenario, progress=progress)
    band = any(name.startswith("setup_width") for name in wanted.names)
    parts = {"band": band, "program": not wanted.coarse}
    return chamfer.run(scenario, wanted=frozenset(name for name, asked in parts.items() if asked))


PATHS = Method(
    run=_run,
    measures=chamfer_measures.measures,
    stages=lambda scenario, done, _: chamfer_stages.stages(scenario, done),
    findings=lambda scenario, done, found: (
        *chamfer_findings.unsound(done, found), *chamfer_findings.weight(scenario, done)
    ),
    limits=lambda *_: chamfer.LIMITS,
    references=lambda _, done: ("sato2016", "altintas2012") if done.forces else ("sato2016",),
    warnings=chamfer_measures.warnings,
    infeasible=lambda scenario, done, found: (
        *done.infeasible,
        *carried.too_fast(found, scenario.operation.contact_feed or scenario.operation.centre_feed, "the feed"),
    ),
    notes=lambda _, done, __: chamfer_measures.notes(done),
    bands=lambda _, done, found: chamfer_measures.histories(done, found),
    advice=lambda _, done, __: done.remedies,
    change=lambda scenario, done, *_: chamfer_measures.convergence(scenario, done),
    share=0.6,
)  # fmt: skip

RECIPE = Recipe(lambda _: PATHS, chamfer.prepare)
