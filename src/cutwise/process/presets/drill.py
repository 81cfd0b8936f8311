"""Robotic drilling: postures, thrust and torque over depth, and the coupled cycle of every hole."""

from cutwise.process import drilling, drilling_findings, drilling_measures, drilling_stages
from cutwise.process.labels import tree
from cutwise.process.recipes import Method, Recipe, halved

_ELIMINATION = ("raghavan_roth1993", "manocha_canny1994")  # postures of arms without a spherical wrist

CYCLES = Method(
    run=lambda scenario, _, progress: drilling.run(scenario, progress),
    measures=drilling_measures.measures,
    stages=lambda scenario, run, _: tree(drilling_stages.told(scenario, run), drilling_stages.GROUPS),
    findings=lambda scenario, run, _: drilling_findings.unsound(run, scenario.numerics.time_step),
    limits=lambda scenario, _: drilling_findings.limits(scenario),
    references=lambda _, run: (
        "garnier2017", "dumas2011", "chen_kao2000", *(_ELIMINATION if run.cell.not_spherical else ())
    ),
    warnings=lambda scenario, run, _: drilling_findings.warnings(scenario, run),
    infeasible=lambda scenario, run, _: drilling_findings.infeasible(scenario, run),
    notes=lambda scenario, run, _: drilling_findings.notes(scenario, run),
    change=halved(lambda scenario, run, _: drilling_measures.measures(scenario, drilling.again(scenario, run))),
    share=1.0,
)  # fmt: skip

RECIPE = Recipe(lambda _: CYCLES, drilling.drill_cell)
