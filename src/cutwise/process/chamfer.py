"""What a chamfer path amounts to: measures, stages, remarks; and the recipe's parts in their order."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from cutwise import units
from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import lengths
from cutwise.paths import reach
from cutwise.paths.chamfer import ENVELOPE, NoPathError, chamfer_path
from cutwise.paths.pipe import NoEdgeError, PipeHole
from cutwise.physics.cutting.flute import EdgeCoefficients
from cutwise.physics.structure.pistons import PistonRing
from cutwise.physics.structure.statics import characteristic
from cutwise.physics.surface.sweep import swept_chamfer
from cutwise.process.assemble import piston_ring
from cutwise.process.chamfer_chains import EdgePlan, plan_chains
from cutwise.process.chamfer_loop import BallEnd, PassForces, Yielding, pass_forces, sections, yielding_pass
from cutwise.process.chamfer_plan import EdgePath, chamfer_of, needed_tilt, plan_pipe
from cutwise.process.chamfer_program import moves
from cutwise.process.chamfer_setup import SetupBand, setup_band
from cutwise.process.chamfer_work import cad_work, cutter, pipe_hole, pipe_work, read_part
from cutwise.process.labels import labelled
from cutwise.spec.chamfer import ChamferScenario
from cutwise.spec.material import LINEAR

_TIME_STEP = 20e-6  # [s] of the compliant pass

LIMITS = (
    "cutter run-out, wear and the mechanics of burrs are not modelled",
    "forces take both faces as planes at each place, and the chip from the speed of the contact",
    "no controller or robot has run these programs: dry-run them",
)


class Deflected(NamedTuple):
    """A path with the spindle yielding."""

    moves: Yielding
    width: FloatArray  # [m] at the measured places


class ChamferRun(NamedTuple):
    """Everything that a run found."""

    plans: tuple[EdgePlan, ...]
    forces: tuple[PassForces, ...]  # one for each path, or none
    deflected: tuple[Deflected, ...]  # one for each path, or none
    band: SetupBand | None
    ring: PistonRing | None
    infeasible: tuple[str, ...]
    remedies: tuple[str, ...]
    remarks: tuple[str, ...]

    @property
    def paths(self) -> tuple[EdgePath, ...]:
        """All paths of all edges."""
        return tuple(path for plan in self.plans for path in plan.paths)


def run(scenario: ChamferScenario) -> ChamferRun:
    """Plan and prove the paths of a scenario, then the forces along them and what a spindle makes of those."""
    part = pipe_hole(scenario)
    plans, infeasible, remedies, remarks = _pipe(scenario, part) if part is not None else _cad(scenario)
    paths = [path for plan in plans for path in plan.paths]
    forces: list[PassForces] = []
    deflected: list[Deflected] = []
    ring = None
    if scenario.has_forces:
        ball = ball_end(scenario)
        forces = [_forces(path, ball) for path in paths]
        if scenario.spindle is not None:
            ring = piston_ring(scenario.spindle)
            deflected = [_deflected(scenario, path, ball, ring, scenario.spindle.tool_reach) for path in paths]
    band = setup_band(scenario, part, paths) if scenario.setup is not None and paths and not infeasible else None
    return ChamferRun(
        tuple(plans), tuple(forces), tuple(deflected), band, ring, tuple(infeasible), tuple(remedies), tuple(remarks)
    )


def ball_end(scenario: ChamferScenario) -> BallEnd:
    """The turning cutter in its material; unknown axial coefficients count as zero."""
    material, tool = scenario.material, scenario.tool
    assert material is not None
    assert tool.flutes is not None
    assert scenario.operation.spindle_speed is not None
    coefficients = EdgeCoefficients(*(getattr(material, key) or 0.0 for key in LINEAR))
    return BallEnd(tool.ball_radius, tool.flutes, scenario.operation.spindle_speed, coefficients)


_Planned = tuple[list[EdgePlan], list[str], list[str], list[str]]


def _pipe(scenario: ChamferScenario, part: PipeHole) -> _Planned:
    """The one edge of a pipe, or why not."""
    inner = scenario.part.edges == "inner"
    tool, clearance = cutter(scenario), scenario.chamfer.clearance
    cut = chamfer_of(scenario)

    def helped(failed: set[str], tilt: float | None = None) -> list[str]:
        return reach.remedies(cut, part, tool, clearance, tilt, failed, inner=inner)

    try:
        work = pipe_work(part, scenario)
    except NoEdgeError as fault:
        margin = reach.Margin(reach.EDGE, fault.margin, False, str(fault))
        return [], [str(margin)], helped({reach.EDGE}), []
    try:
        path = plan_pipe(scenario, work, part)
    except NoPathError as fault:
        return [], [f"{reach.PATH}: {fault}"], helped({reach.PATH}), []
    tilt = None
    if path.failed and not path.tilt and not cut.leg:
        tilt = needed_tilt(
            scenario, work, part,
            lambda tried: chamfer_path(work.nodes, cut._replace(tilt=tried), tool.ball_radius),
        )  # fmt: skip
    plan = EdgePlan(work, (path,), ())
    return [plan], [str(m) for m in path.failed], helped({m.code for m in path.failed}, tilt) if path.failed else [], []


def _cad(scenario: ChamferScenario) -> _Planned:
    """The selected edges of a CAD part; edges that cannot be done are refused with the reason, and the rest is done."""
    part = read_part(scenario)
    plans = plan_chains(scenario, cad_work(scenario, part))
    infeasible = [_refused(plan) for plan in plans if not plan.paths]
    remarks = [*part.remarks, *(str(plan) for plan in plans if plan.paths and plan.trims)]
    remedies = []
    if infeasible:
        remedies = [
            "tilt the chamfer (chamfer.tilt: auto)" if scenario.chamfer.tilt != "auto" else "a narrower chamfer",
            "a thinner rod or a smaller ball",
            "another tool axis (tool.axis), or another side of the part",
            "leave these edges out (part.edges)",
        ]
    return plans, infeasible, remedies, remarks


def _refused(plan: EdgePlan) -> str:
    return f"{plan.work.name}: {'; '.join(dict.fromkeys(trim.reason for trim in plan.trims))}"


def _forces(path: EdgePath, ball: BallEnd) -> PassForces:
    return pass_forces(_sections(path), ball)


def _sections(path: EdgePath) -> "object":
    speed = path.feeds.contact
    at_points = speed if path.path.frames.closed else np.append(speed, speed[-1])
    return sections(path.path, path.local, path.axis, at_points)


def _deflected(
    scenario: ChamferScenario, path: EdgePath, ball: BallEnd, ring: PistonRing, tool_reach: float
) -> Deflected:
    closed = path.path.frames.closed
    durations = lengths(path.path.centre, closed=closed) / path.feeds.centre
    approach = scenario.operation.preset + scenario.operation.part_error
    moves = yielding_pass(
        _sections(path), path.local, path.axis, durations, ball, ring, tool_reach, approach, _TIME_STEP, closed=closed
    )  # type: ignore[arg-type]
    span = 2.0 * float(path.path.leg.max()) + 2.0 * abs(approach)
    width = swept_chamfer(path.at, path.path.centre + moves.offset, ball.ball_radius, span, closed=closed).width
    return Deflected(moves, width)


def measures(scenario: ChamferScenario, done: ChamferRun) -> Mapping[str, float]:
    """All measures in SI; one that does not apply is left out."""
    paths = done.paths
    found: dict[str, float] = {}
    if scenario.part.pipe is None:
        found["edges_chamfered"] = float(sum(bool(plan.paths) for plan in done.plans))
        found["edges_refused"] = float(sum(not plan.paths for plan in done.plans))
        found["length_trimmed"] = float(sum(plan.trimmed for plan in done.plans))
    if not paths:
        return found
    width = np.concatenate([path.found.width for path in paths])
    if np.isfinite(width).all():
        found["width_min"], found["width_max"] = float(width.min()), float(width.max())
    elif np.isfinite(width).any():
        found["width_min"], found["width_max"] = 0.0, float(np.nanmax(width))  # somewhere the edge still stands
    found["gouge_max"] = max(0.0, *(path.gouge.value for path in paths))
    rods = [path.rod.value for path in paths if path.rod is not None]
    if rods:
        found["rod_clearance_min"] = min(rods)
    found["knife_margin_min"] = min(m.value for path in paths for m in path.margins if m.code == reach.KNIFE)
    found["tilt"] = max((path.tilt for path in paths), key=abs)
    found["leg_ratio_max"] = max(_leg_ratio(path) for path in paths)
    found["wedge_angle_min"] = min(float(path.path.frames.wedge.min()) for path in paths)
    found["wedge_angle_max"] = max(float(path.path.frames.wedge.max()) for path in paths)
    found["path_length"] = float(sum(_length(path.path.centre, path) for path in paths))
    found["edge_length"] = float(sum(_length(path.path.frames.point, path) for path in paths))
    found["points"] = float(sum(len(path.path.centre) for path in paths))
    found["cycle_time"] = sum(path.feeds.time for path in paths)
    found["chord_error"] = max(path.chord_error for path in paths)
    slopes = [path.sensitivity for path in paths if math.isfinite(path.sensitivity)]
    if slopes:
        found["setup_sensitivity_z"] = max(slopes, key=abs)
    if done.band is not None:
        found["setup_width_low"], found["setup_width_high"] = done.band.low, done.band.high
    return found | _force_measures(scenario, done)


def _force_measures(scenario: ChamferScenario, done: ChamferRun) -> dict[str, float]:
    if not done.forces:
        return {}
    found = {}
    weight = np.concatenate([_durations(path) for path in done.paths])
    force = np.concatenate([forces.force for forces in done.forces])
    power = np.concatenate([forces.power for forces in done.forces])
    axial = scenario.material is not None and scenario.material.K_ac is not None
    for i, axis in enumerate("xyz" if axial else "xy"):
        found[f"force_mean_{axis}"] = float(np.average(force[:, i], weights=weight))
    found["lateral_force_max"] = float(np.hypot(force[:, 0], force[:, 1]).max())
    found["chip_area"] = max(float(forces.chip_area.max()) for forces in done.forces)
    found["cutting_power_mean"] = float(np.average(power, weights=weight))
    if done.deflected and done.ring is not None and scenario.spindle is not None:
        width = np.concatenate([one.width for one in done.deflected])
        if np.isfinite(width).all():
            found["width_deflected_min"], found["width_deflected_max"] = float(width.min()), float(width.max())
        found["tip_deflection_max"] = max(float(np.hypot(*one.moves.tip.T).max()) for one in done.deflected)
        found["breakaway_force"] = characteristic(done.ring, scenario.spindle.tool_reach).loading.breakaway
    return found


def _durations(path: EdgePath) -> FloatArray:
    time = lengths(path.path.centre, closed=path.path.frames.closed) / path.feeds.centre
    return time if path.path.frames.closed else np.append(time, time[-1])


def _length(point: FloatArray, path: EdgePath) -> float:
    return float(lengths(point, closed=path.path.frames.closed).sum())


def _leg_ratio(path: EdgePath) -> float:
    return float((path.path.leg.max(axis=1) / path.path.leg.min(axis=1)).max())


def warnings(scenario: ChamferScenario, done: ChamferRun, found: Mapping[str, float]) -> tuple[str, ...]:
    """What the user should know about the result."""
    said = [*done.remarks]
    if found.get("leg_ratio_max", 0.0) > reach.LOPSIDED:
        said.append(
            f"the legs differ by a factor of {found['leg_ratio_max']:.2g}: the width is constant, but the chamfer is "
            "lopsided; a thinner rod needs less tilt"
        )
    if scenario.chamfer.tier == "envelope":
        fallen = sum(int((path.path.tier < ENVELOPE).sum()) for path in done.paths)
        if fallen:
            said.append(f"at {fallen} points the envelope was not found: the surface tier stands there")
    if found.get("width_min") == 0.0:
        said.append("somewhere along the edge the sweep left no complete chamfer: the edge still stands there")
    slope = found.get("setup_sensitivity_z")
    if slope is not None and not done.infeasible:
        change = units.show(abs(slope) * 50e-6, "length", 3)
        said.append(
            f"50 µm of set-up error along the tool axis change the width by {change}: probe the part, or use a "
            "compliant spindle"
        )
    for path in done.paths:
        if np.abs(path.local.plunge).max() > 0.5:
            said.append(f"{path.work.name} climbs steeply along the tool axis: forces there are rough")
            break
    return tuple(said)


def notes(done: ChamferRun) -> Mapping[str, str]:
    """Remarks for the report: remedies in their order, margins, set-up."""
    said = {}
    for i, text in enumerate(done.remedies, start=1):
        said[f"remedy {i}"] = text
    for path in done.paths[:20]:
        for margin in path.margins:
            said[f"{path.work.name}, {margin.code}"] = str(margin)
    if done.band is not None:
        said["set-up"] = str(done.band)
    return said


def stages(scenario: ChamferScenario, done: ChamferRun) -> xr.DataTree:
    """Paths, contacts, forces and widths as labelled arrays, all paths one after another."""
    paths = done.paths
    if not paths:
        return xr.DataTree()
    groups = {
        "motion": _motion(paths), "engagement": _engagement(paths, done.forces), "surface": _surface(done),
        "program": moves(paths, scenario.operation.retract),
    }  # fmt: skip
    at = _station(paths)
    if done.forces:
        groups["cutting"] = labelled(at, {
            "force": (np.concatenate([f.force for f in done.forces]), "N", "force on the tool, frame of the pass"),
            "power": (np.concatenate([f.power for f in done.forces]), "W", "cutting power"),
        }, axis=["x", "y", "z"])  # fmt: skip
    if done.deflected:
        groups["structure"] = labelled(at, {
            "tip_deflection": (np.concatenate([d.moves.tip for d in done.deflected]), "m", "deflection of the tip"),
            "tilt": (np.concatenate([d.moves.tilt for d in done.deflected]), "rad", "tilt of the motor"),
            "deflected_force": (np.concatenate([d.moves.force for d in done.deflected]), "N", "force while yielding"),
        }, axis=["x", "y", "z"], axis2=["x", "y"])  # fmt: skip
    return xr.DataTree.from_dict(groups)


def _station(paths: Sequence[EdgePath]) -> tuple[str, FloatArray, str, str]:
    """Arc length along the edges, one after another, at the path points."""
    found, before = [], 0.0
    for path in paths:
        step = lengths(path.path.frames.point, closed=path.path.frames.closed)
        run_length = np.concatenate([[0.0], np.cumsum(step)])
        found.append(before + run_length[: len(path.path.centre)])
        before += float(step.sum())
    return ("s", np.concatenate(found), "m", "position along the edges")


def _motion(paths: Sequence[EdgePath]) -> xr.Dataset:
    def at_points(one: FloatArray, path: EdgePath) -> FloatArray:
        return one if path.path.frames.closed else np.append(one, one[-1])

    return labelled(_station(paths), {
        "centre": (np.concatenate([p.path.centre for p in paths]), "m", "ball centre"),
        "tool_axis": (np.concatenate([np.tile(p.axis, (len(p.path.centre), 1)) for p in paths]), "1", "rod direction"),
        "feed": (np.concatenate([at_points(p.feeds.centre, p) for p in paths]), "m/s", "speed of the ball centre"),
        "contact_feed": (np.concatenate([at_points(p.feeds.contact, p) for p in paths]), "m/s", "contact speed"),
        "path": (np.concatenate([np.full(len(p.path.centre), i) for i, p in enumerate(paths)]), "1", "path number"),
        "closed": (np.concatenate([np.full(len(p.path.centre), float(p.path.frames.closed)) for p in paths]), "1",
                   "1 where the path runs back to its start"),
        "plunge": (np.concatenate([p.local.plunge for p in paths]), "1", "edge tangent along the rod"),
    }, axis=["x", "y", "z"])  # fmt: skip


def _engagement(paths: Sequence[EdgePath], forces: Sequence[PassForces]) -> xr.Dataset:
    columns = {
        "contact": (np.concatenate([p.path.contact.mean(axis=1) for p in paths]), "m", "middle of the chamfer"),
        "edge": (np.concatenate([p.path.frames.point for p in paths]), "m", "edge"),
        "tangent": (np.concatenate([p.path.frames.tangent for p in paths]), "1", "edge tangent"),
        "air": (np.concatenate([p.path.air for p in paths]), "1", "chamfer normal, out of the material"),
        "leg": (np.concatenate([p.path.leg for p in paths]), "m", "leg on each face"),
        "contact_angle": (
            np.concatenate([reach.contact_angles(p.path, p.axis) for p in paths]), "rad", "border from the rod",
        ),
        "wedge_angle": (np.concatenate([p.path.frames.wedge for p in paths]), "rad", "wedge angle of the material"),
    }  # fmt: skip
    if forces:
        columns["chip_area"] = (np.concatenate([f.chip_area for f in forces]), "m**2", "cross-section taken off")
    return labelled(_station(paths), columns, axis=["x", "y", "z"], side=["first", "second"])


def _surface(done: ChamferRun) -> xr.Dataset:
    paths = done.paths
    at, before = [], 0.0
    for path in paths:
        edge = path.path.frames
        run_length = np.concatenate([[0.0], np.cumsum(lengths(edge.point, closed=edge.closed))])
        parameter = np.append(edge.parameter, edge.parameter[0] + edge.period) if edge.closed else edge.parameter
        at.append(before + np.interp(path.at.parameter, parameter, run_length))
        before += float(run_length[-1])
    columns = {
        "width": (np.concatenate([p.found.width for p in paths]), "m", "chamfer width left by the sweep"),
        "swept_leg": (np.concatenate([p.found.leg for p in paths]), "m", "legs left by the sweep"),
    }
    if done.deflected:
        columns["width_deflected"] = (
            np.concatenate([d.width for d in done.deflected]), "m", "chamfer width with the spindle deflected"
        )  # fmt: skip
    if done.band is not None:
        columns["width_low"] = (done.band.low_along, "m", "5 % of set-ups below")
        columns["width_high"] = (done.band.high_along, "m", "5 % of set-ups above")
    place = ("s_measured", np.concatenate(at), "m", "position along the edges")
    return labelled(place, columns, side=["first", "second"])
