"""Error budget of a machine: ideal pass, loaded pass (Demeč and Madáč, Eqs. 1-9), map of the working space."""

from cutwise.process import carried, machine, machine_stages
from cutwise.process.recipes import Method, Progress, Recipe, Wanted, halved
from cutwise.results import Finding, Infeasible
from cutwise.spec.machine_scenario import MachineScenario


def _run(scenario: MachineScenario, wanted: Wanted, progress: Progress | None) -> machine.MachineDone:
    """Pass and map; the Monte Carlo only where one of its measures is read."""
    del progress
    if not wanted.any(machine.MONTE_CARLO):
        scenario = scenario.model_copy(update={"uncertainty": None})
    one_pass, infeasible = None, list[Finding]()
    try:
        one_pass = machine.evaluate_pass(scenario) if scenario.has_pass else None
    except Infeasible as why:
        infeasible.append(why.finding)
    return machine.MachineDone(one_pass, machine.evaluate_volume(scenario), tuple(infeasible))


BUDGET = Method(
    run=_run,
    measures=machine.measures,
    stages=lambda *_: machine_stages.GROUPS,
    findings=lambda _, done, __: machine_stages.unsound(done.one_pass),
    limits=lambda *_: machine_stages.LIMITS,
    references=lambda *_: ("demec",),
    warnings=lambda scenario, done, _: machine_stages.warnings(scenario, done.one_pass),
    infeasible=lambda _, done, found: (
        *done.infeasible,
        *(() if done.way is None else carried.too_fast(found, float(done.way.feed.max()), "the feed of the pass")),
    ),
    notes=lambda scenario, done, _: machine_stages.notes(scenario, done.one_pass, done.volume),
    change=halved(lambda scenario, done, _: machine.refined(scenario, done.one_pass, done.volume)),
)  # fmt: skip

RECIPE = Recipe(lambda _: BUDGET, machine.prepare)
