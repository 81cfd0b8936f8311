"""What a chamfer run amounts to: measures, warnings, notes."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from cutwise import units
from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import arc_lengths, lengths
from cutwise.paths import reach
from cutwise.paths.chamfer.ball_path import ENVELOPE, NoPathError, chamfer_path
from cutwise.paths.chamfer.chains import EdgePlan
from cutwise.paths.chamfer.plan import EdgePath, swept
from cutwise.paths.chamfer.proof import GOUGE_LIMIT
from cutwise.paths.pipe import one_turn
from cutwise.physics.structure.statics import characteristic
from cutwise.physics.surface.approach import Approach
from cutwise.process import carriers, chamfer_carrier, spindles
from cutwise.process.chamfer import ChamferRun
from cutwise.process.chamfer_cell import SLICES
from cutwise.process.chamfer_cut import TIME_STEP, Deflected, ball_end, deflected, mounted, rigid
from cutwise.process.chamfer_task import task_of
from cutwise.process.convergence import change_on_halved_step
from cutwise.process.edges import known_axes
from cutwise.results import Finding, Histories, Place, Remedy, Said, warned
from cutwise.spec.base import known
from cutwise.spec.chamfer import ChamferScenario

_LED = frozenset({"width_deflected_min", "width_deflected_max"})
_SLENDER = 10.0  # rod radii that may stick out without a warning
_SHOWN = 8  # trimmed edges that are warned about one by one


def measures(scenario: ChamferScenario, done: ChamferRun) -> Mapping[str, float]:
    """All measures in SI; one that does not apply is left out."""
    paths = done.paths
    found: dict[str, float] = {}
    if scenario.part.pipe is None:
        found["edges_chamfered"] = float(sum(bool(plan.paths) for plan in done.plans))
        found["edges_refused"] = float(sum(not plan.paths for plan in done.plans))
        found["length_trimmed"] = float(sum(plan.trimmed for plan in done.plans))
        found["corners_joined"] = float(len(done.links))
    if not paths:
        return found
    found |= _widths([path.found.width for path in done.led], "")
    found |= _proof(done.led)
    found["knife_margin_min"] = min(m.value for path in paths for m in path.margins if m.code == reach.KNIFE)
    found["tilt"] = max((path.tilt for path in paths), key=abs)
    found["leg_ratio_max"] = max(_leg_ratio(path) for path in paths)
    found["wedge_angle_min"] = min(float(path.path.frames.wedge.min()) for path in paths)
    found["wedge_angle_max"] = max(float(path.path.frames.wedge.max()) for path in paths)
    found["path_length"] = float(sum(_length(path.path.centre, path) for path in paths))
    edges = [path.path.frames for path in paths]
    found["edge_length"] = float(sum(arc_lengths(e.point, e.tangent, closed=e.closed).sum() for e in edges))
    found["points"] = float(sum(len(path.path.centre) for path in paths))
    found["cycle_time"] = sum(path.feeds.time for path in paths)
    found["chord_error"] = max(path.chord_error for path in paths)
    slopes = [path.sensitivity for path in paths if np.isfinite(path.sensitivity)]
    if slopes:
        found["setup_sensitivity_z"] = max(slopes, key=abs)
    if done.band is not None:
        found["setup_width_low"], found["setup_width_high"] = done.band.low, done.band.high
    return found | force_measures(scenario, done)


def _widths(widths: Sequence[FloatArray], kind: str) -> dict[str, float]:
    """Smallest and largest width; zero where the edge still stands somewhere."""
    width = np.concatenate(widths)
    if not np.isfinite(width).any():
        return {}
    low = float(width.min()) if np.isfinite(width).all() else 0.0
    return {f"width{kind}_min": low, f"width{kind}_max": float(np.nanmax(width))}


def _proof(paths: Sequence[EdgePath]) -> dict[str, float]:
    found = {
        "gouge_max": max(0.0, *(path.gouge.value for path in paths)),
        "gouge_bound": max(0.0, *(path.gouge.bound for path in paths)),
    }
    rods: list[Approach] = [path.rod for path in paths if path.rod is not None]
    if rods:
        found["rod_clearance_min"] = min(rod.value for rod in rods)
        found["rod_clearance_bound"] = min(rod.bound for rod in rods)
    known = [path.stick_out for path in paths if np.isfinite(path.stick_out)]
    if known:
        found["rod_reach"] = max(known)
    return found


def histories(done: ChamferRun, found: Mapping[str, float]) -> Mapping[str, Histories]:
    """Widths that 90 % of the set-ups leave."""
    if done.band is None:
        return {}
    return {
        "width_min": Histories(done.band.low, found["width_min"], "set-up"),
        "width_max": Histories(found["width_max"], done.band.high, "set-up"),
    }


def force_measures(scenario: ChamferScenario, done: ChamferRun) -> dict[str, float]:
    """Forces, and what a compliant spindle makes of them."""
    if not done.forces:
        return {}
    found = {}
    weight = np.concatenate([chamfer_carrier.durations(path) for path in done.paths])
    force = np.concatenate([forces.force for forces in done.forces])
    burr = np.concatenate([forces.burr_force for forces in done.forces])
    power = np.concatenate([forces.power for forces in done.forces])
    for i, axis in enumerate(known_axes(known(scenario.material))):
        found[f"force_mean_{axis}"] = float(np.average(force[:, i], weights=weight))
        if scenario.part.burr is not None:
            found[f"burr_force_mean_{axis}"] = float(np.average(burr[:, i], weights=weight))
    found["lateral_force_max"] = float(np.hypot(force[:, 0], force[:, 1]).max())
    found["chip_area"] = max(float(forces.chip_area.max()) for forces in done.forces)
    found["cutting_power_mean"] = float(np.average(power, weights=weight))
    if done.deflected:
        if all(one.believed for one in done.deflected):
            found |= _widths([one.width for one in done.deflected], "_deflected")
        found["tip_deflection_max"] = max(float(np.hypot(*one.moves.tip.T).max()) for one in done.deflected)
        rods = [one.rod for one in done.deflected if one.rod is not None]
        if rods and all(one.believed for one in done.deflected):
            found["rod_clearance_deflected_min"] = min(rods)
    if done.deflected and scenario.compliant is not None:
        found["stroke_margin"] = scenario.compliant.stroke - max(one.travel for one in done.deflected)
        ring = spindles.piston_ring(scenario.compliant)
        found["breakaway_force"] = characteristic(ring, scenario.compliant.tool_reach).loading.breakaway
    if done.carriers:
        found |= chamfer_carrier.measures(scenario, done.paths, [one.moves for one in done.deflected], done.carriers)
    return found


def convergence(scenario: ChamferScenario, done: ChamferRun) -> dict[str, float]:
    """Change of widths with twice the points (pipe), of forces with twice the discs, of deflection with half the step.

    Of the deflected widths also what the number of points matters, from a run through every second one.
    """
    change = _finer_path(scenario, done)
    if not done.forces:
        return change
    ball = ball_end(scenario)

    def passes(**how: float) -> tuple[Deflected, ...]:
        paths = done.paths if done.deflected else ()
        carriers = done.carriers or (None,) * len(paths)
        return tuple(
            deflected(scenario, path, ball, mounted(path, done.paths), carrier, **how)  # type: ignore[arg-type]
            for path, carrier in zip(paths, carriers, strict=True)
        )

    now = force_measures(scenario, done)
    forces = tuple(rigid(scenario, path, ball, 2 * SLICES) for path in done.led)
    finer = done._replace(forces=forces, deflected=passes(time_step=0.5 * TIME_STEP))
    change |= change_on_halved_step(now, force_measures(scenario, finer))
    coarser = force_measures(scenario, done._replace(deflected=passes(every=2), carriers=())) if done.deflected else {}
    for name in _LED.intersection(now, coarser):  # the error that is left, which falls with the square of the distance
        change[name] = max(change.get(name, 0.0), (now[name] - coarser[name]) / 3.0, key=abs)
    return change


def _finer_path(scenario: ChamferScenario, done: ChamferRun) -> dict[str, float]:
    """Change of the widths with twice the points; the samples of a CAD edge are what they are."""
    frames_at = done.paths[0].work.frames_at if len(done.paths) == 1 else None
    if frames_at is None:
        return {}
    one, task = done.paths[0], task_of(scenario)
    twice = frames_at(one_turn(2 * len(one.path.centre)))
    try:
        path = chamfer_path(twice, task.cut._replace(tilt=one.tilt), one.ball_radius, nodes=one.work.nodes)
    except NoPathError:
        return {}
    finer = swept(task, path, one.at)
    return change_on_halved_step(_widths([one.found.width], ""), _widths([finer.width], ""))


def _length(point: FloatArray, path: EdgePath) -> float:
    return float(lengths(point, closed=path.path.frames.closed).sum())


def _leg_ratio(path: EdgePath) -> float:
    return float((path.path.leg.max(axis=1) / path.path.leg.min(axis=1)).max())


def warnings(scenario: ChamferScenario, done: ChamferRun, found: Mapping[str, float]) -> tuple[Said, ...]:
    """What the user should know about the result."""
    said: list[Said] = [*done.notices, *_trimmed(done)]
    unproven = done.program.unproven if done.program is not None else ()
    if found.get("leg_ratio_max", 0.0) > reach.LOPSIDED:
        words = (
            f"the legs differ by a factor of {found['leg_ratio_max']:.2g}: the width is constant, but the chamfer is "
            "lopsided; a thinner rod needs less tilt"
        )
        said.append(warned("lopsided", words, found["leg_ratio_max"], reach.LOPSIDED))
    if scenario.chamfer.tier == "envelope":
        fallen = sum(int((path.path.tier < ENVELOPE).sum()) for path in done.paths)
        if fallen:
            words = f"at {fallen} points the envelope was not found: the surface tier stands there"
            said.append(warned("no_envelope", words, float(fallen), 0.0))
    wanted = scenario.path.chord_tolerance
    if wanted is not None and found.get("chord_error", 0.0) > wanted * (1.0 + 1e-3):
        words = (
            f"the path bends or jumps too sharply for path.chord_tolerance: {units.show(found['chord_error'], 'length', 3)}"
            f" instead of {units.show(wanted, 'length', 3)}"
        )
        said.append(warned("chord_error", words, found["chord_error"], wanted, "length"))
    if unproven and not done.infeasible:
        more = f" and {len(unproven) - _SHOWN} more" if len(unproven) > _SHOWN else ""
        words = f"the lead to or from {', '.join(unproven[:_SHOWN])}{more} may touch the part: check it in the program"
        said.append(warned("lead_unproven", words, where=Place(unproven[0])))
    far = max(done.paths, key=lambda path: np.nan_to_num(path.stick_out), default=None)
    if far is not None and far.stick_out > _SLENDER * scenario.tool.rod_radius:
        words = (
            f"{far.work.name} needs {units.show(far.stick_out, 'length', 3)} of rod above the ball centre, "
            f"{far.stick_out / scenario.tool.rod_radius:.0f} times its radius: such a rod bends and chatters; come from "
            "another side (tool.axis), or take a thicker rod"
        )
        limit = _SLENDER * scenario.tool.rod_radius
        said.append(warned("slender", words, float(far.stick_out), limit, "length", where=Place(far.work.name)))
    slope = found.get("setup_sensitivity_z")
    if slope is not None and not done.infeasible:
        change = units.show(abs(slope) * 50e-6, "length", 3)
        instead = "probe the part, or use a compliant spindle"
        if scenario.compliant is not None:
            instead = "probe the part; how far the spindle makes up for it, a run with operation.part_error shows"
        words = f"50 µm of set-up error along the tool axis change the width by {change}: {instead}"
        said.append(warned("setup_sensitive", words, abs(slope) * 50e-6, dimension="length"))
    beyond = found.get("gouge_max", 0.0)
    if beyond > GOUGE_LIMIT and all(path.gouge.value < beyond for path in done.paths):
        words = (
            f"preset and part error take the ball {units.show(beyond, 'length', 3)} into the part beside the chamfer: a "
            "rigid tool does not give way (operation.preset, operation.part_error)"
        )
        said.append(warned("gouges", words, beyond, GOUGE_LIMIT, "length", remedy=Remedy("operation.preset", "less")))
    if "cutting_power_mean" in found:
        said += spindles.overload(scenario.compliant, found["cutting_power_mean"])
    return (*said, *_yielding(found), *carriers.warnings(scenario, [one.carriage for one in done.carriers]))


def _trimmed(done: ChamferRun) -> Iterator[Finding]:
    trimmed = [plan for plan in done.plans if plan.paths and plan.trims]
    yield from (warned("left_out", _left_out(plan), where=Place(plan.work.name)) for plan in trimmed[:_SHOWN])
    if len(trimmed) > _SHOWN:
        words = f"{len(trimmed) - _SHOWN} more edges have parts left out; the report lists them"
        yield warned("left_out", words, float(len(trimmed) - _SHOWN), 0.0)


def _left_out(plan: EdgePlan) -> str:
    """The parts of an edge without a path, with their reasons."""
    parts = [f"{units.show(trim.length, 'length', 3)} ({trim.reason})" for trim in plan.trims]
    return f"{plan.work.name}: left out {'; '.join(parts)}"


def _yielding(found: Mapping[str, float]) -> Iterator[Finding]:
    if "breakaway_force" in found and found["tip_deflection_max"] < 1e-7:
        words = (
            f"the spindle does not move: the lateral force stays below breakaway "
            f"({units.show(found['lateral_force_max'], 'force', 3)} of {units.show(found['breakaway_force'], 'force', 3)}"
            ", without preset); the width is that of a rigid tool"
        )
        yield warned("no_breakaway", words, found["lateral_force_max"], found["breakaway_force"], "force")


def notes(done: ChamferRun) -> Mapping[str, str]:
    """Remarks for the report: remedies in their order, margins, what was left out, set-up."""
    said = {}
    if done.remedies:
        said["remedies"] = "\n".join(f"{i}. {text}" for i, text in enumerate(done.remedies, start=1))
    nearest: dict[str, tuple[reach.Margin, str]] = {}
    for path in done.paths:
        for margin in path.margins:
            if margin.code not in nearest or margin.value < nearest[margin.code][0].value:
                nearest[margin.code] = (margin, path.work.name)
    if nearest:
        said["margins"] = "\n".join(f"{margin}, at {name}" for margin, name in nearest.values())
    left_out = [_left_out(plan) for plan in done.plans if plan.trims]
    if left_out:
        said["left_out"] = "\n".join(left_out)
    if done.links:
        paths = done.paths
        said["corners"] = "\n".join(
            f"{paths[link.first].work.name} goes on into {paths[link.second].work.name}" for link in done.links
        )
    said |= carriers.redundancy([one.carriage.arm for one in done.carriers if one.carriage.arm is not None])
    if done.band is not None:
        said["set-up"] = str(done.band)
    return said
