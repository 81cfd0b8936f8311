"""The recipes: one short function for each process, side by side, from scenario to result."""

from collections.abc import Callable, Mapping

from cutwise.process import assemble, chamfer, deburring, remarks
from cutwise.process.convergence import change_on_halved_step
from cutwise.results import Measure, Result, judge
from cutwise.spec.chamfer import ChamferScenario
from cutwise.spec.deburring import DeburringScenario
from cutwise.spec.scenario import Scenario

Progress = Callable[[float], None]


def deburr(scenario: DeburringScenario, progress: Progress | None = None) -> Result:
    """Compliant-spindle deburring: time stepping over all five stages (Berselli et al. 2016, Fig. 8)."""

    step = scenario.numerics.time_step
    finer = _deburring_pass(scenario, 0.5 * step, _part(progress, 0.0, 2.0 / 3.0))[1]
    edge, found = _deburring_pass(scenario, step, _part(progress, 2.0 / 3.0, 1.0))
    change = change_on_halved_step(found, finer)
    return collect(
        scenario,
        found,
        stages=deburring.stages(edge),
        warnings=(*remarks.warnings(scenario, edge, found), *remarks.halved_step(change)),
        limits=remarks.LIMITS,
        convergence=change,
        notes=remarks.notes(scenario, edge, found),
        references=("berselli2016", "altintas2012"),
    )


def _deburring_pass(
    scenario: DeburringScenario, time_step: float, progress: Progress | None = None, *, tooth: bool = True
) -> tuple[deburring.EdgeRun, Mapping[str, float]]:
    cell = assemble.deburring_cell(scenario)
    history = deburring.run_for(scenario, cell)(cell, time_step, progress)
    edge = deburring.evaluate(cell, history)
    return edge, deburring.measures(scenario, edge, tooth=tooth)


def deburring_measures(scenario: DeburringScenario) -> Mapping[str, float]:
    """The measures alone, for studies: at least 100 µs of step with averaged forces over arcs, as given otherwise."""
    step = scenario.numerics.time_step
    coarse = scenario.numerics.force == "averaged" and scenario.tool.runout == 0.0
    tooth = any(name.startswith("tooth_") for name in scenario.requirements)
    return _deburring_pass(scenario, max(step, _STUDY_STEP) if coarse else step, tooth=tooth)[1]


_STUDY_STEP = 100e-6  # [s] moves the edge error of the reference case by 0.07 µm

MEASURES: Mapping[str, Callable[..., Mapping[str, float]]] = {"deburr": deburring_measures}
def chamfer_path(scenario: ChamferScenario, progress: Progress | None = None) -> Result:
    """Chamfer of constant width: path, proof by sweep, forces along it, and a spindle that yields to them."""
    del progress  # over in a second
    done = chamfer.run(scenario)
    found = chamfer.measures(scenario, done)
    return collect(
        scenario,
        found,
        stages=chamfer.stages(scenario, done),
        warnings=chamfer.warnings(scenario, done, found),
        infeasible=done.infeasible,
        limits=chamfer.LIMITS,
        notes=chamfer.notes(done),
        references=("sato2016", "altintas2012") if done.forces else ("sato2016",),
    )


RECIPES: Mapping[str, Callable[..., Result]] = {"deburr": deburr, "chamfer": chamfer_path}


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
    return RECIPES[scenario.process](scenario, progress)


def quick_measures(scenario: Scenario) -> Mapping[str, float]:
    """The measures of a scenario in SI, without histories and convergence: what sweeps and advice run many times."""
    return MEASURES[scenario.process](scenario)


def collect(scenario: Scenario, found: Mapping[str, float], **parts: object) -> Result:
    """A result: measures with their dimension and meaning, held against the requirements."""
    known = type(scenario).measures
    measures = {name: Measure(value, *known[name]) for name, value in found.items()}
    checks = tuple(judge(scenario, measures))
    return Result(scenario=scenario, measures=measures, checks=checks, **parts)  # type: ignore[arg-type]


def _part(progress: Progress | None, start: float, end: float) -> Progress | None:
    if progress is None:
        return None
    return lambda share: progress(start + (end - start) * share)
