"""The recipes: one short function for each process, side by side, from scenario to result."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from cutwise.later import later
from cutwise.process import convergence as converged
from cutwise.process.convergence import change_on_halved_step
from cutwise.results import (
    Finding,
    Histories,
    Infeasible,
    Measure,
    Result,
    Said,
    SolverFailure,
    in_words,
    judge,
    unreached,
)
from cutwise.spec.kinds import Registered
from cutwise.spec.notices import notices
from cutwise.spec.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr

    from cutwise.process import (
        assemble,
        assemble_mill,
        carried,
        chamfer,
        chamfer_carrier,
        chamfer_findings,
        chamfer_measures,
        chamfer_program,
        chamfer_stages,
        chamfer_task,
        deburring,
        deburring_part,
        drilling,
        drilling_findings,
        drilling_stages,
        edge_findings,
        machine,
        machine_stages,
        milling,
        milling_compare,
        milling_findings,
        milling_measures,
        milling_stability,
        programmed_milling,
        spindle_load,
        still_deburring,
        stock_deviation,
        stock_findings,
        stock_measures,
        stock_setups,
        stock_stages,
    )
    from cutwise.spec.chamfer import ChamferScenario
    from cutwise.spec.deburring import DeburringScenario
    from cutwise.spec.drilling import DrillingScenario
    from cutwise.spec.machine_scenario import MachineScenario
    from cutwise.spec.milling import MillingScenario
else:  # a run imports its own process, not those of the others
    xr = later("xarray")
    programmed_milling = later("cutwise.process.programmed_milling")
    assemble = later("cutwise.process.assemble")
    assemble_mill = later("cutwise.process.assemble_mill")
    carried = later("cutwise.process.carried")
    chamfer = later("cutwise.process.chamfer")
    chamfer_findings = later("cutwise.process.chamfer_findings")
    chamfer_measures = later("cutwise.process.chamfer_measures")
    chamfer_program = later("cutwise.process.chamfer_program")
    chamfer_carrier = later("cutwise.process.chamfer_carrier")
    chamfer_stages = later("cutwise.process.chamfer_stages")
    chamfer_task = later("cutwise.process.chamfer_task")
    deburring = later("cutwise.process.deburring")
    deburring_part = later("cutwise.process.deburring_part")
    drilling = later("cutwise.process.drilling")
    drilling_findings = later("cutwise.process.drilling_findings")
    drilling_stages = later("cutwise.process.drilling_stages")
    machine = later("cutwise.process.machine")
    machine_stages = later("cutwise.process.machine_stages")
    milling = later("cutwise.process.milling")
    milling_compare = later("cutwise.process.milling_compare")
    milling_measures = later("cutwise.process.milling_measures")
    milling_stability = later("cutwise.process.milling_stability")
    edge_findings = later("cutwise.process.edge_findings")
    milling_findings = later("cutwise.process.milling_findings")
    spindle_load = later("cutwise.process.spindle_load")
    still_deburring = later("cutwise.process.still_deburring")
    stock_deviation = later("cutwise.process.stock_deviation")
    stock_findings = later("cutwise.process.stock_findings")
    stock_measures = later("cutwise.process.stock_measures")
    stock_setups = later("cutwise.process.stock_setups")
    stock_stages = later("cutwise.process.stock_stages")

Progress = Callable[[float], None]


class Outcome(NamedTuple):
    """What studies need of a run: the measures in SI, and what there is to say about them."""

    measures: Mapping[str, float]
    findings: tuple[Finding, ...] = ()
    warnings: tuple[Said, ...] = ()  # those of the run, but for what takes a second run with half the step
    infeasible: tuple[Said, ...] = ()


def deburr(scenario: DeburringScenario, progress: Progress | None = None) -> Result:
    """Compliant-spindle deburring: time stepping over all five stages (Berselli et al. 2016, Fig. 8)."""
    scenario = deburring_part.on_part(scenario)
    if scenario.numerics.mode == "still":
        return deburr_at_rest(scenario, progress)
    step = scenario.numerics.time_step
    finer = _deburring_pass(scenario, 0.5 * step, _part(progress, 0.0, 2.0 / 3.0))[1]
    edge, found = _deburring_pass(scenario, step, _part(progress, 2.0 / 3.0, 1.0))
    change = change_on_halved_step(found, finer)
    return collect(
        scenario,
        found,
        stages=deburring.stages(scenario, edge),
        findings=(*edge_findings.unsound(scenario, edge), *edge_findings.weight(edge)),
        bands=deburring.histories(scenario, edge, found),
        warnings=edge_findings.warnings(scenario, edge, found),
        infeasible=carried.too_fast(found, scenario.operation.feed),
        limits=edge_findings.LIMITS,
        convergence=change,
        notes=edge_findings.notes(scenario, edge, found),
        references=("berselli2016", "altintas2012"),
    )


def deburr_at_rest(scenario: DeburringScenario, progress: Progress | None = None) -> Result:
    """An edge with a rigid spindle: each place at rest, on whatever carries the tool."""
    done = still_deburring.run(scenario)
    found = still_deburring.measures(scenario, done)
    finer = scenario.numerics.model_copy(update={"station": 0.5 * scenario.numerics.station})
    half = scenario.model_copy(update={"numerics": finer})
    again = still_deburring.measures(half, still_deburring.run(half))
    if progress is not None:
        progress(1.0)
    return collect(
        scenario,
        found,
        stages=still_deburring.stages(scenario, done),
        findings=still_deburring.findings(done),
        warnings=still_deburring.warnings(scenario, done),
        infeasible=carried.too_fast(found, scenario.operation.feed),
        limits=still_deburring.LIMITS,
        convergence=change_on_halved_step(found, again),
        notes=still_deburring.notes(done),
        references=("berselli2016", "altintas2012"),
    )


def _deburring_pass(
    scenario: DeburringScenario, time_step: float, progress: Progress | None = None, *, tooth: bool = True,
    plateaus: bool = True,
) -> tuple[deburring.EdgeRun, Mapping[str, float]]:  # fmt: skip
    cell = assemble.deburring_cell(scenario)
    history = deburring.run_for(scenario, cell)(cell, time_step, progress)
    edge = deburring.evaluate(cell, history, plateaus=plateaus)
    return edge, deburring.measures(scenario, edge, tooth=tooth)


def deburring_quick(scenario: DeburringScenario, wanted: Collection[str] = (), *, coarse: bool = False) -> Outcome:
    """What studies need; coarse: at least 100 µs of step with averaged forces over arcs, and no word about the run.

    The plateaus of the band, as much work as half of the pass, are found for a coarse one only where they are wanted.
    """
    scenario = deburring_part.on_part(scenario)
    if scenario.numerics.mode == "still":
        done = still_deburring.run(scenario)
        at_rest = still_deburring.measures(scenario, done)
        return Outcome(
            at_rest, still_deburring.findings(done), still_deburring.warnings(scenario, done),
            carried.too_fast(at_rest, scenario.operation.feed),
        )  # fmt: skip
    step, named = scenario.numerics.time_step, (*scenario.requirements, *wanted)
    tooth = any(name.startswith("tooth_") for name in named)
    plateaus = not coarse or any(name in deburring.PLATEAUS for name in named)
    edge, found = _deburring_pass(
        scenario, max(step, _STUDY_STEP) if coarse and coarser(scenario) else step, tooth=tooth, plateaus=plateaus
    )
    said = () if coarse else tuple(edge_findings.warnings(scenario, edge, found))
    too_fast = carried.too_fast(found, scenario.operation.feed)
    return Outcome(found, tuple(edge_findings.unsound(scenario, edge)), said, too_fast)


def machine_errors(scenario: MachineScenario, progress: Progress | None = None) -> Result:
    """Error budget of a machine: ideal pass, loaded pass (Demeč and Madáč, Eqs. 1-9), map of the working space."""
    one_pass, infeasible = None, ()
    try:
        one_pass = machine.evaluate_pass(scenario) if scenario.has_pass else None
    except Infeasible as why:
        infeasible = (why.finding,)
    volume = machine.evaluate_volume(scenario)
    found = _machine_found(scenario, one_pass, volume)
    infeasible = (*infeasible, *_machine_too_fast(one_pass, found))
    finer = machine.refined(scenario, one_pass, volume)
    if progress is not None:
        progress(1.0)
    return collect(
        scenario,
        found,
        stages=machine_stages.stages(one_pass, volume),
        findings=machine_stages.unsound(one_pass),
        warnings=machine_stages.warnings(scenario, one_pass),
        infeasible=infeasible,
        limits=machine_stages.LIMITS,
        convergence={name: value - found[name] for name, value in finer.items()},
        notes=machine_stages.notes(scenario, one_pass, volume),
        references=("demec",),
    )


def mill(scenario: MillingScenario, progress: Progress | None = None) -> Result:
    """Milling with CNC drives: look-ahead, drives and forces in one loop (Ozcan et al. 2017, sec. 2-3)."""
    if scenario.in_3d:
        return mill_in_3d(scenario, progress)
    if scenario.programmed:
        return mill_programmed(scenario, progress)
    program = assemble_mill.read_program(scenario)
    substeps = scenario.numerics.substeps
    done = milling.run(scenario, substeps, _part(progress, 0.0, 0.3))
    of_run = milling_measures.measures(scenario, done)
    finer = milling_measures.measures(scenario, milling.run(scenario, 2 * substeps, _part(progress, 0.3, 0.9)))
    change = change_on_halved_step(of_run, finer, shares=False)
    rows = milling_compare.compare(scenario)
    steady = milling.stability(scenario, done)
    found = {**of_run, **(milling_stability.measures(steady) if steady is not None else {})}
    return collect(
        scenario,
        found,
        stages=milling.stages(
            done,
            comparison=milling_compare.comparison_table(rows, scenario.measures),
            lobes=milling_stability.lobe_diagram(scenario, steady) if steady is not None else None,
            vibration=milling_stability.vibration(steady) if steady is not None else None,
        ),
        findings=milling_findings.unsound(scenario, done, steady),
        infeasible=tuple(spindle_load.overloads(scenario, done)),
        warnings=tuple(milling_findings.warnings(scenario, done, found)),
        limits=milling_findings.limits(done),
        convergence=change,
        notes=milling_findings.notes(scenario, done, program.notices if program else ()),
        references=("ozcan2017", "altintas2012", "erkorkmaz2001"),
    )


def mill_in_3d(scenario: MillingScenario, progress: Progress | None = None) -> Result:
    """A program in a stock in 3D: contact, force and events move by move, and the surface held against the part."""
    done = stock_setups.run(scenario, _part(progress, 0.0, 0.9))
    off = stock_deviation.judged(scenario, done)
    if progress is not None:
        progress(1.0)
    return collect(
        scenario,
        stock_measures.measures(done, off),
        stages=stock_stages.stages(done, off),
        findings=stock_findings.findings(done),
        warnings=tuple(stock_findings.warnings(scenario, done, off)),
        limits=stock_findings.limits(done),
        notes=stock_findings.notes(done, off),
        references=("altintas2012", "engin2001", "gradisek2004"),
    )


def mill_programmed(scenario: MillingScenario, progress: Progress | None = None) -> Result:
    """A mill that goes as programmed: each place of its path at rest, or stepped, and the depth at which it chatters."""
    done = programmed_milling.run(scenario, progress=_part(progress, 0.0, 1.0 / 3.0))
    found = programmed_milling.measures(scenario, done)
    again = programmed_milling.measures(
        scenario, programmed_milling.run(scenario, limits=False, finer=2, progress=_part(progress, 1.0 / 3.0, 1.0))
    )
    return collect(
        scenario,
        found,
        stages=programmed_milling.stages(scenario, done),
        findings=(*programmed_milling.findings(scenario, done), *programmed_milling.unsound(found)),
        warnings=programmed_milling.warnings(scenario, done),
        infeasible=carried.too_fast(found, scenario.operation.feed),
        limits=programmed_milling.limits_of(scenario),
        convergence=change_on_halved_step(found, again, shares=False),
        notes=programmed_milling.notes(scenario, done),
        references=("altintas2012", "altintas1995"),
    )


def mill_quick(scenario: MillingScenario, wanted: Collection[str] = (), *, coarse: bool = False) -> Outcome:
    """What studies need; whether the tool chatters always belongs to it."""
    del wanted
    if scenario.in_3d:
        cut = stock_setups.run(scenario)
        off = stock_deviation.judged(scenario, cut)
        about = () if coarse else tuple(stock_findings.warnings(scenario, cut, off))
        return Outcome(stock_measures.measures(cut, off), tuple(stock_findings.findings(cut)), about)
    if scenario.programmed:
        fed = programmed_milling.run(scenario)
        of_fed = programmed_milling.measures(scenario, fed)
        said = () if coarse else programmed_milling.warnings(scenario, fed)
        sound = (*programmed_milling.findings(scenario, fed), *programmed_milling.unsound(of_fed))
        return Outcome(of_fed, sound, said, carried.too_fast(of_fed, scenario.operation.feed))
    done = milling.run(scenario, scenario.numerics.substeps)
    steady = milling.stability(scenario, done)
    found = milling_measures.measures(scenario, done)
    found = {**found, **(milling_stability.measures(steady) if steady is not None else {})}
    said = () if coarse else tuple(milling_findings.warnings(scenario, done, found))
    sound = tuple(milling_findings.unsound(scenario, done, steady, helped=False))
    return Outcome(found, sound, said, tuple(spindle_load.overloads(scenario, done)))


def machine_quick(scenario: MachineScenario, wanted: Collection[str] = (), *, coarse: bool = False) -> Outcome:
    """What studies need; the Monte Carlo only if a requirement or ``wanted`` names one of its measures."""
    if not machine.MONTE_CARLO.intersection((*scenario.requirements, *wanted)):
        scenario = scenario.model_copy(update={"uncertainty": None})
    one_pass, infeasible = None, ()
    try:
        one_pass = machine.evaluate_pass(scenario) if scenario.has_pass else None
    except Infeasible as why:
        infeasible = (why.finding,)
    found = _machine_found(scenario, one_pass, machine.evaluate_volume(scenario))
    said = () if coarse else tuple(machine_stages.warnings(scenario, one_pass))
    infeasible = (*infeasible, *_machine_too_fast(one_pass, found))
    return Outcome(found, tuple(machine_stages.unsound(one_pass)), said, infeasible)


def _machine_too_fast(one_pass: machine.MachinePass | None, found: Mapping[str, float]) -> tuple[Finding, ...]:
    """That the joints of a robot cannot follow the pass."""
    if one_pass is None or one_pass.run.cell.arm is None:
        return ()
    return carried.too_fast(found, float(one_pass.run.cell.way.feed.max()), "the feed of the pass")


def _machine_found(
    scenario: MachineScenario, one_pass: machine.MachinePass | None, volume: machine.VolumeMap | None
) -> Mapping[str, float]:  # fmt: skip
    of_pass = machine.pass_measures(one_pass) if one_pass is not None else {}
    if one_pass is not None and one_pass.run.cell.arm is not None and scenario.robot is not None:
        cell = one_pass.run.cell
        of_pass = {**of_pass, **carried.measures(cell.arm, scenario.robot, float(cell.way.feed.max()))}
    return {**of_pass, **(machine.volume_measures(volume) if volume is not None else {})}


_MOOT = frozenset({"unstable", "tip_lost"})  # whose numbers no finer step settles
_ELIMINATION = ("raghavan_roth1993", "manocha_canny1994")  # postures of arms without a spherical wrist
_STUDY_STEP = 100e-6  # [s] moves the edge error of the reference case by 0.07 µm


def drill(scenario: DrillingScenario, progress: Progress | None = None) -> Result:
    """Robotic drilling: postures, thrust and torque over depth, and the coupled cycle of every hole."""
    run = _drilling_run(scenario, progress)
    found = drilling.measures(scenario, run)
    change = change_on_halved_step(found, drilling.convergence(scenario, run))
    each = [drilling.hole_measures(scenario, run.cell, hole) if hole.outcome else None for hole in run.holes]
    return collect(
        scenario,
        found,
        stages=drilling_stages.stages(scenario, run, each),
        findings=drilling_findings.unsound(run, scenario.numerics.time_step),
        warnings=drilling_findings.warnings(scenario, run),
        infeasible=drilling_findings.infeasible(scenario, run),
        limits=drilling_findings.limits(scenario),
        convergence=change,
        notes=drilling_findings.notes(scenario, run),
        references=("garnier2017", "dumas2011", "chen_kao2000", *_ELIMINATION[: 2 * bool(run.cell.not_spherical)]),
    )


def _drilling_run(scenario: DrillingScenario, progress: Progress | None = None) -> drilling.DrillRun:
    cell = drilling.drill_cell(scenario)
    shift, places = drilling.place(scenario, cell)
    holes = []
    targets = drilling.targets(scenario.hole)
    led = drilling.led_to(scenario.hole)
    for count, (target, to) in enumerate(zip(targets, led, strict=True), 1):
        moved = target._replace(position=target.position + shift)
        holes.append(drilling.drill_one(scenario, cell, moved, scenario.numerics.time_step, to))
        if progress is not None:
            progress(count / len(targets))
    return drilling.DrillRun(cell, tuple(holes), shift, places)


def drilling_quick(scenario: DrillingScenario, wanted: Collection[str] = (), *, coarse: bool = False) -> Outcome:
    """What studies need."""
    del wanted
    run = _drilling_run(scenario)
    said = () if coarse else tuple(drilling_findings.warnings(scenario, run))
    sound = tuple(drilling_findings.unsound(run, scenario.numerics.time_step))
    return Outcome(drilling.measures(scenario, run), sound, said, tuple(drilling_findings.infeasible(scenario, run)))


def chamfer_path(scenario: ChamferScenario, progress: Progress | None = None) -> Result:
    """Chamfer of constant width: path, proof by sweep, forces along it, and a spindle that yields to them."""
    done = chamfer.run(scenario, progress=_part(progress, 0.0, 0.6))
    if progress is not None:
        progress(0.6)
    found = chamfer_measures.measures(scenario, done)
    program = (
        chamfer_program.moves(chamfer_task.task_of(scenario), done.programmed, done.links, done.members)
        if done.paths
        else None
    )
    return collect(
        scenario,
        found,
        stages=chamfer_stages.stages(scenario, done, program.table if program else None),
        findings=(*chamfer_findings.unsound(done, found), *chamfer_findings.weight(scenario, done)),
        bands=chamfer_measures.histories(done, found),
        warnings=chamfer_measures.warnings(scenario, done, found, program.unproven if program else ()),
        infeasible=(*done.infeasible, *carried.too_fast(found, _chamfer_feed(scenario), "the feed")),
        advice=done.remedies,
        limits=chamfer.LIMITS,
        convergence=chamfer_measures.convergence(scenario, done),
        notes=chamfer_measures.notes(done),
        references=("sato2016", "altintas2012") if done.forces else ("sato2016",),
    )


def _chamfer_feed(scenario: ChamferScenario) -> float | None:
    return scenario.operation.contact_feed or scenario.operation.centre_feed


def chamfer_quick(scenario: ChamferScenario, wanted: Collection[str] = (), *, coarse: bool = False) -> Outcome:
    """What studies need; the band of set-up errors only if a requirement or ``wanted`` names it."""
    band = any(name.startswith("setup_width") for name in (*scenario.requirements, *wanted))
    done = chamfer.run(scenario, wanted=frozenset({"band"} if band else ()))
    found = chamfer_measures.measures(scenario, done)
    sound = tuple(chamfer_findings.unsound(done, found))
    cannot = (*done.infeasible, *carried.too_fast(found, _chamfer_feed(scenario), "the feed"))
    if coarse:
        return Outcome(found, sound, (), cannot)
    program = (
        chamfer_program.moves(chamfer_task.task_of(scenario), done.paths, done.links, done.members)
        if done.paths
        else None
    )
    said = chamfer_measures.warnings(scenario, done, found, program.unproven if program else ())
    return Outcome(found, sound, tuple(said), cannot)


class Recipe(NamedTuple):
    """How a process is run: whole, for studies, and only as far as faults show; its row in ``spec.kinds`` names it."""

    run: Callable[..., Result]
    quick: Callable[..., Outcome]
    prepare: Callable[..., object]


CHAMFER = Recipe(chamfer_path, chamfer_quick, lambda scenario: chamfer.prepare(scenario))
DEBURR = Recipe(deburr, deburring_quick, lambda scenario: assemble.edge_cut(deburring_part.on_part(scenario)))
DRILL = Recipe(drill, drilling_quick, lambda scenario: drilling.drill_cell(scenario))
MACHINE = Recipe(machine_errors, machine_quick, lambda scenario: machine.prepare(scenario))
MILL = Recipe(
    mill,
    mill_quick,
    lambda scenario: (
        stock_setups if scenario.in_3d else programmed_milling if scenario.programmed else milling
    ).prepare(scenario),
)
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
        return RECIPES[scenario.process].run(scenario, progress)
    except Infeasible as why:
        return collect(scenario, {}, stages=xr.DataTree(), warnings=notices(scenario), infeasible=(why.finding,))


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
        and scenario.numerics.time_step < _STUDY_STEP  # type: ignore[attr-defined]
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
    try:
        told = RECIPES[scenario.process].quick(scenario, wanted, coarse=coarse)
    except Infeasible as why:
        return Outcome({}, infeasible=(str(why),))
    return told._replace(warnings=in_words(told.warnings), infeasible=in_words(told.infeasible))


def quick_measures(scenario: Scenario, wanted: Collection[str] = ()) -> Mapping[str, float]:
    """The measures of a coarse :func:`quick_outcome`."""
    return quick_outcome(scenario, wanted, coarse=True).measures


def collect(
    scenario: Scenario,
    found: Mapping[str, float],
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
