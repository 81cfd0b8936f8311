"""A chamfer run: paths planned and proved, then forces along them, a spindle that yields, and set-up errors."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from cutwise.paths import reach
from cutwise.paths.chamfer import proof
from cutwise.paths.chamfer.ball_path import NoPathError
from cutwise.paths.chamfer.chains import EdgePlan, edge_lengths, plan_chains
from cutwise.paths.chamfer.corners import Link, links
from cutwise.paths.chamfer.plan import EdgePath, plan_pipe
from cutwise.paths.pipe import NoEdgeError, PipeHole, edge_margin
from cutwise.process.chamfer_carrier import Carrier, carrier_on, slowed
from cutwise.process.chamfer_cell import PassForces
from cutwise.process.chamfer_cut import Deflected, ball_end, deflected, mounted, rigid
from cutwise.process.chamfer_led import as_run, programmed
from cutwise.process.chamfer_program import Moves, moves
from cutwise.process.chamfer_remedies import remedies
from cutwise.process.chamfer_setup import SetupBand, setup_band
from cutwise.process.chamfer_task import pipe_hole, task_of
from cutwise.process.chamfer_work import Outline, cad_work, pipe_outline, pipe_work, read_part, surroundings
from cutwise.process.pace import Pace
from cutwise.results import Finding, Place, named
from cutwise.spec.chamfer import ChamferScenario

LIMITS = (
    "cutter run-out, wear and the mechanics of burrs are not modelled; a burr is a strip that is cut like the part",
    "forces take both faces as planes at each place, and the chip from the speed of the contact",
    "gouge and rod are shown on the nominal part; a rod that is carried aside by a yielding spindle is not tilted with it",
    "no controller or robot has run these programs: dry-run them",
)

EVERYTHING = frozenset({"band", "outline", "remedies", "program"})

_SIDES = ("outer", "inner")


class ChamferRun(NamedTuple):
    """Everything that a run found."""

    plans: tuple[EdgePlan, ...]
    programmed: tuple[EdgePath, ...]  # all paths, with the preset
    led: tuple[EdgePath, ...]  # all paths as a rigid tool runs them on the part as it stands
    members: tuple[proof.EdgeZone, ...]  # where the tool is meant to cut
    links: tuple[Link, ...]  # ways round corners, between the paths counted over all edges
    forces: tuple[PassForces, ...]  # one for each path, or none
    carriers: tuple[Carrier, ...]  # one for each path, or none
    deflected: tuple[Deflected, ...]  # one for each path, or none
    band: SetupBand | None
    outline: Outline | None
    infeasible: tuple[Finding, ...]
    remedies: tuple[str, ...]
    notices: tuple[str, ...]
    program: Moves | None = None  # if there are paths, and it is asked for

    @property
    def paths(self) -> tuple[EdgePath, ...]:
        """All paths of all edges as planned."""
        return tuple(path for plan in self.plans for path in plan.paths)


class _Planned(NamedTuple):
    """Paths, and why there are not more of them."""

    plans: tuple[EdgePlan, ...] = ()
    members: tuple[proof.EdgeZone, ...] = ()
    infeasible: tuple[Finding, ...] = ()
    remedies: tuple[str, ...] = ()
    notices: tuple[str, ...] = ()
    outline: Outline | None = None


def prepare(scenario: ChamferScenario) -> None:
    """Read the part and find its edges, without planning paths.

    Raises
    ------
    ScenarioFault, CadFault
        The part cannot be read, or no edge is chosen by ``part.edges``.
    """
    if pipe_hole(scenario) is None:
        cad_work(scenario, read_part(scenario), outline=False)


def run(
    scenario: ChamferScenario, *, wanted: frozenset[str] = EVERYTHING, progress: Callable[[float], None] | None = None
) -> ChamferRun:  # fmt: skip
    """Plan and prove the paths of a scenario, then the forces along them and what a spindle makes of those.

    ``wanted``: what is worked out besides: the band of set-up errors, the outline of the part for pictures, the program,
    and what helps where something is infeasible. ``progress`` is called with the share of the planning done so far.
    """
    part = pipe_hole(scenario)
    found = (
        _pipe(scenario, part, helped="remedies" in wanted)
        if part is not None
        else _cad(scenario, outline="outline" in wanted, progress=progress)
    )
    found = _slowed(scenario, found)
    paths = [path for plan in found.plans for path in plan.paths]
    written = tuple(programmed(scenario, path) for path in paths)
    led = tuple(as_run(scenario, path, found.members) for path in paths)
    forces: list[PassForces] = []
    carriers: list[Carrier] = []
    aside: list[Deflected] = []
    if scenario.has_forces:
        ball = ball_end(scenario)
        forces = [rigid(scenario, path, ball) for path in led]
        if scenario.carried:
            carriers = [carrier_on(scenario, path, force) for path, force in zip(paths, forces, strict=True)]
        if scenario.yields:
            aside = [
                deflected(scenario, path, ball, mounted(path, paths), carriers[k] if carriers else None)
                for k, path in enumerate(paths)
            ]
    band = None
    if "band" in wanted and scenario.setup is not None and paths and not found.infeasible:
        band = setup_band(scenario, part, led)
    task = task_of(scenario)
    joined = links(task, written, found.members)
    program = moves(task, written, joined, found.members) if "program" in wanted and written else None
    return ChamferRun(
        found.plans, written, led, found.members, joined, tuple(forces), tuple(carriers), tuple(aside), band,
        found.outline, found.infeasible, found.remedies, found.notices, program,
    )  # fmt: skip


def _slowed(scenario: ChamferScenario, found: _Planned) -> _Planned:
    """The same paths at feeds that the joints of a robot can follow, where that is asked for."""
    if not scenario.operation.limit_feed or not scenario.has_forces:
        return found
    ball = ball_end(scenario)

    def at_pace(path: EdgePath) -> EdgePath:
        force = rigid(scenario, as_run(scenario, path, found.members), ball)
        return slowed(scenario, path, carrier_on(scenario, path, force))

    plans = tuple(plan._replace(paths=tuple(at_pace(path) for path in plan.paths)) for plan in found.plans)
    return found._replace(plans=plans)


def _pipe(scenario: ChamferScenario, part: PipeHole, *, helped: bool) -> _Planned:
    """One edge of a pipe or both, or why not; ``helped``: what helps is worked out too."""
    wanted = scenario.part.edges
    sides = [side for side in _SIDES if wanted in (side, "all")]
    found = [_pipe_edge(scenario, part, inner=side == "inner") for side in sides]
    infeasible = [
        named(why, f"{side} edge", Place(f"{side} edge")) if len(found) > 1 else why
        for side, one in zip(sides, found, strict=True) for why in one.infeasible
    ]  # fmt: skip
    plans = [plan for one in found for plan in one.plans]
    if len(plans) == 2:
        shared = reach.shared_wall_margin(plans[0].paths[0].path, plans[1].paths[0].path, part)
        plans = [
            plan._replace(paths=tuple(path._replace(margins=(*path.margins, shared)) for path in plan.paths))
            for plan in plans
        ]
        infeasible += [] if shared.met else [_missed(shared)]
    helps: tuple[str, ...] = ()
    if infeasible and helped:
        helps = remedies(scenario, {why.code for why in infeasible}, _feasible)
    return _Planned(
        tuple(plans), sum((one.members for one in found), ()), tuple(infeasible), helps, (),
        pipe_outline(part),
    )  # fmt: skip


def _feasible(scenario: ChamferScenario) -> Sequence[EdgePath] | None:
    """The paths of a pipe, if nothing is wrong with them."""
    part = pipe_hole(scenario)
    assert part is not None
    if edge_margin(part, inner=scenario.part.edges != "outer") <= 0.0:
        return None
    found = _pipe(scenario, part, helped=False)
    return None if found.infeasible else [path for plan in found.plans for path in plan.paths]


def _pipe_edge(scenario: ChamferScenario, part: PipeHole, *, inner: bool) -> _Planned:
    try:
        work = pipe_work(part, scenario, inner=inner)
        path = plan_pipe(task_of(scenario), work, part)
    except NoEdgeError as fault:
        return _Planned(infeasible=(_missed(reach.Margin(reach.EDGE, fault.margin, False, str(fault))),))
    except NoPathError as fault:
        return _Planned(infeasible=(Finding(reach.PATH, words=f"{reach.PATH}: {fault}", cannot=True),))
    member = proof.edge_zone(work, float(path.path.leg.max()), scenario.chamfer.width)
    return _Planned((EdgePlan(work, (path,), ()),), (member,), tuple(_missed(m) for m in path.failed))


def _cad(
    scenario: ChamferScenario, *, outline: bool, progress: Callable[[float], None] | None = None
) -> _Planned:  # fmt: skip
    """The selected edges of a CAD part; edges that cannot be done are refused with the reason, and the rest is done."""
    part = read_part(scenario)
    work = cad_work(scenario, part, outline=outline)
    pace = Pace(
        sum(float(edge_lengths(one.nodes).sum()) for one in work.chosen),
        "Fewer edges (part.edges) or a larger path.chord_tolerance make it shorter.", progress,
    )  # fmt: skip
    plans, members = plan_chains(task_of(scenario), work.chosen, surroundings(work), pace.advance)
    infeasible = tuple(_refused(plan) for plan in plans if not plan.paths)
    remedies: tuple[str, ...] = ()
    if infeasible:
        remedies = (
            "tilt the chamfer (chamfer.tilt: auto)" if scenario.chamfer.tilt != "auto"
            else "a narrower chamfer (chamfer.width)",
            "a thinner rod (tool.rod_radius) or a smaller ball (tool.ball_radius)",
            "another tool axis (tool.axis)" if scenario.tool.axis == "auto"
            else "the best of all tool axes (tool.axis: auto)",
            "leave these edges out (part.edges)",
        )  # fmt: skip
    return _Planned(
        tuple(plans), tuple(members), infeasible, remedies, (*work.model.notices, *work.notices), work.outline
    )


def _refused(plan: EdgePlan) -> Finding:
    words = f"{plan.work.name}: {'; '.join(dict.fromkeys(trim.reason for trim in plan.trims))}"
    return Finding(reach.PATH, Place(plan.work.name), words=words, cannot=True)


def _missed(margin: reach.Margin) -> Finding:
    """An inequality that does not hold."""
    dimension = "angle" if margin.angle else "length"
    return Finding(margin.code, value=margin.value, limit=0.0, dimension=dimension, words=str(margin), cannot=True)
