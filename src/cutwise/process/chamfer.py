"""A chamfer run: paths planned and proved, then forces along them, a spindle that yields, and set-up errors."""

from typing import NamedTuple

from cutwise.paths import reach
from cutwise.paths.chamfer import NoPathError, chamfer_path
from cutwise.paths.pipe import NoEdgeError, PipeHole
from cutwise.process import chamfer_proof as proof
from cutwise.process.chamfer_chains import EdgePlan, plan_chains
from cutwise.process.chamfer_corners import Link, links
from cutwise.process.chamfer_cut import Deflected, ball_end, deflected, rigid
from cutwise.process.chamfer_loop import PassForces
from cutwise.process.chamfer_plan import EdgePath, chamfer_of, needed_tilt, plan_pipe
from cutwise.process.chamfer_setup import SetupBand, setup_band
from cutwise.process.chamfer_work import Outline, cad_work, cutter, pipe_hole, pipe_outline, pipe_work, read_part
from cutwise.spec.chamfer import ChamferScenario

LIMITS = (
    "cutter run-out, wear and the mechanics of burrs are not modelled; a burr is a strip that is cut like the part",
    "forces take both faces as planes at each place, and the chip from the speed of the contact",
    "gouge and rod are shown on the nominal part; a rod that is carried aside by a yielding spindle is not tilted with it",
    "no controller or robot has run these programs: dry-run them",
)

_SIDES = ("outer", "inner")


class ChamferRun(NamedTuple):
    """Everything that a run found."""

    plans: tuple[EdgePlan, ...]
    members: tuple[proof.EdgeZone, ...]  # where the tool is meant to cut
    links: tuple[Link, ...]  # ways round corners, between the paths counted over all edges
    forces: tuple[PassForces, ...]  # one for each path, or none
    deflected: tuple[Deflected, ...]  # one for each path, or none
    band: SetupBand | None
    outline: Outline | None
    infeasible: tuple[str, ...]
    remedies: tuple[str, ...]
    remarks: tuple[str, ...]

    @property
    def paths(self) -> tuple[EdgePath, ...]:
        """All paths of all edges."""
        return tuple(path for plan in self.plans for path in plan.paths)


class _Planned(NamedTuple):
    """Paths, and why there are not more of them."""

    plans: tuple[EdgePlan, ...] = ()
    members: tuple[proof.EdgeZone, ...] = ()
    infeasible: tuple[str, ...] = ()
    remedies: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
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


def run(scenario: ChamferScenario, *, wanted: frozenset[str] = frozenset({"band", "outline"})) -> ChamferRun:
    """Plan and prove the paths of a scenario, then the forces along them and what a spindle makes of those.

    ``wanted``: what is worked out besides: the band of set-up errors, the outline of the part for pictures.
    """
    part = pipe_hole(scenario)
    found = _pipe(scenario, part) if part is not None else _cad(scenario, outline="outline" in wanted)
    paths = [path for plan in found.plans for path in plan.paths]
    forces: list[PassForces] = []
    aside: list[Deflected] = []
    if scenario.has_forces:
        ball = ball_end(scenario)
        forces = [rigid(scenario, path, ball) for path in paths]
        if scenario.spindle is not None:
            aside = [deflected(scenario, path, ball) for path in paths]
    band = None
    if "band" in wanted and scenario.setup is not None and paths and not found.infeasible:
        band = setup_band(scenario, part, paths)
    return ChamferRun(
        found.plans, found.members, links(scenario, paths, found.members), tuple(forces), tuple(aside), band,
        found.outline, found.infeasible, found.remedies, found.remarks,
    )  # fmt: skip


def _pipe(scenario: ChamferScenario, part: PipeHole) -> _Planned:
    """One edge of a pipe or both, or why not."""
    wanted = scenario.part.edges
    found = [_pipe_edge(scenario, part, inner=inner) for inner in (False, True) if wanted in (_SIDES[inner], "all")]
    if len(found) == 1:
        return found[0]._replace(outline=pipe_outline(part))
    infeasible = [f"{side} edge: {text}" for side, one in zip(_SIDES, found, strict=True) for text in one.infeasible]
    paths = [path.path for one in found for plan in one.plans for path in plan.paths]
    if len(paths) == 2:
        shared = reach.shared_wall_margin(paths[0], paths[1], part)
        infeasible += [] if shared.met else [str(shared)]
    remedies = dict.fromkeys(text for one in found for text in one.remedies)
    return _Planned(
        sum((one.plans for one in found), ()), sum((one.members for one in found), ()), tuple(infeasible),
        tuple(remedies) or (("a narrower chamfer on one of the edges",) if infeasible else ()), (), pipe_outline(part),
    )  # fmt: skip


def _pipe_edge(scenario: ChamferScenario, part: PipeHole, *, inner: bool) -> _Planned:
    tool, clearance = cutter(scenario), scenario.chamfer.clearance
    cut = chamfer_of(scenario)

    def helped(failed: set[str], tilt: float | None = None) -> tuple[str, ...]:
        return tuple(reach.remedies(cut, part, tool, clearance, tilt, failed, inner=inner))

    try:
        work = pipe_work(part, scenario, inner=inner)
    except NoEdgeError as fault:
        margin = reach.Margin(reach.EDGE, fault.margin, False, str(fault))
        return _Planned(infeasible=(str(margin),), remedies=helped({reach.EDGE}))
    try:
        path = plan_pipe(scenario, work, part)
    except NoPathError as fault:
        return _Planned(infeasible=(f"{reach.PATH}: {fault}",), remedies=helped({reach.PATH}))
    tilt = None
    if path.failed and not path.tilt and not cut.leg:
        tilt = needed_tilt(
            scenario, work, part,
            lambda tried: chamfer_path(work.nodes, cut._replace(tilt=tried), tool.ball_radius),
        )  # fmt: skip
    member = proof.edge_zone(work, float(path.path.leg.max()), scenario.chamfer.width)
    return _Planned(
        (EdgePlan(work, (path,), ()),), (member,), tuple(str(m) for m in path.failed),
        helped({m.code for m in path.failed}, tilt) if path.failed else (),
    )  # fmt: skip


def _cad(scenario: ChamferScenario, *, outline: bool) -> _Planned:
    """The selected edges of a CAD part; edges that cannot be done are refused with the reason, and the rest is done."""
    part = read_part(scenario)
    work = cad_work(scenario, part, outline=outline)
    plans, members = plan_chains(scenario, work)
    infeasible = tuple(_refused(plan) for plan in plans if not plan.paths)
    remedies: tuple[str, ...] = ()
    if infeasible:
        remedies = (
            "tilt the chamfer (chamfer.tilt: auto)" if scenario.chamfer.tilt != "auto" else "a narrower chamfer",
            "a thinner rod or a smaller ball",
            "another tool axis (tool.axis), or another side of the part",
            "leave these edges out (part.edges)",
        )
    return _Planned(tuple(plans), tuple(members), infeasible, remedies, part.remarks, work.outline)


def _refused(plan: EdgePlan) -> str:
    return f"{plan.work.name}: {'; '.join(dict.fromkeys(trim.reason for trim in plan.trims))}"
