"""What milling with CNC drives amounts to: the run, its numbers and its curves."""

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr

from cutwise import units
from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.uneven import even_and_linear
from cutwise.physics.cutting.wall import AVERAGED, DELAYED, FLUTES, tooth_period, wall_force
from cutwise.physics.motion.contour import contour_errors
from cutwise.physics.motion.lookahead import Plan, plan, time_without_limits
from cutwise.physics.motion.loop import LoopFigures, open_loop, sampled_response
from cutwise.physics.motion.reference import Reference, central_difference, sampled
from cutwise.process.assemble_mill import (
    ProgramPath,
    cut,
    drive_pair,
    loops,
    motion_limits,
    program_path,
    read_program,
    spindle_speed,
    tip_modes,
)
from cutwise.process.labels import labelled
from cutwise.process.loops_drives import NO_FORCE, Commands, Cut, DriveHistory, DrivePair, run_drives
from cutwise.process.milling_contact import Contact, SteadyPatch, contact
from cutwise.process.milling_stability import TipStability, tip_stability
from cutwise.spec.faults import all_faults
from cutwise.spec.milling import MillingScenario
from cutwise.spec.program import Blend

Progress = Callable[[float], None]

_NEAR_CORNER = 10e-3  # [m] within which the lowest feed is looked for
_SETTLED = 5e-6  # [m]
_WINDOW = 2  # blocks looked at on either side for the contour error


class MillRun(NamedTuple):
    """A finished run with everything that is read off it."""

    path: ProgramPath
    plan: Plan
    reference: Reference
    contact: Contact
    drives: DrivePair
    loops: tuple[LoopFigures, LoopFigures]
    cut: Cut
    history: DriveHistory
    contour_error: FloatArray  # [m], shape (n,), NaN on rapid moves
    chip: float  # programmed feed per tooth at the fastest cut [m]
    tip_swings: bool  # whether the tool tip moves on modes in the loop


def run(scenario: MillingScenario, substeps: int, progress: Progress | None = None) -> MillRun:
    """Plan, sample, and let the drives follow under the cutting force."""
    program = read_program(scenario)
    path = program_path(scenario, program)
    spindle = spindle_speed(scenario, program)
    limits, axes = motion_limits(scenario.machine)
    motion = plan(path.curve, path.feed, limits, path.stop_at, path.dwell_after, axes=axes)
    sample_time = scenario.machine.control.sample_time
    reference = sampled(path.curve, [motion.profile], sample_time, scenario.numerics.settling_time)
    met = contact(scenario, path, reference)
    cutting = cut(scenario, spindle, met.depth)
    drives = drive_pair(scenario.machine)
    tip = tip_modes(scenario) if cutting.law == DELAYED else None
    history = run_drives(_commands(reference, met.patches, sample_time), drives, cutting, substeps, progress, modes=tip)
    error = contour_errors(path.programmed, path.origin[reference.block], history.position, _WINDOW, True)
    error[np.isinf(path.feed[reference.block])] = np.nan
    feeds = path.feed[path.cuts]
    chip = float(feeds.max()) * 2.0 * math.pi / (spindle * scenario.tool.flutes) if feeds.size else 0.0
    return MillRun(
        path,
        motion,
        reference,
        met,
        drives,
        loops(drives),
        cutting,
        history,
        error,
        chip,
        tip is not None,
    )


def prepare(scenario: MillingScenario) -> None:
    """Build what a run stands on, without running it.

    Raises
    ------
    ScenarioFault
        The program cannot be run, has no spindle speed or feed, or a position loop is unstable.
    """
    program = read_program(scenario)
    all_faults(
        lambda: program_path(scenario, program),
        lambda: spindle_speed(scenario, program),
        lambda: drive_pair(scenario.machine),
    )


def _commands(reference: Reference, patches: FloatArray, sample_time: float) -> Commands:
    point = np.ascontiguousarray(reference.point[:, :2])
    velocity = central_difference(point, sample_time)
    heading = np.arctan2(reference.direction[:, 1], reference.direction[:, 0])
    return Commands(point, velocity, central_difference(velocity, sample_time), heading, patches)


def measures(scenario: MillingScenario, done: MillRun) -> dict[str, float]:
    """All measures of the run in SI; one that does not apply is left out."""
    history, reference = done.history, done.reference
    error = done.contour_error[np.isfinite(done.contour_error)]
    found: dict[str, float] = {}
    if error.size:
        found["contour_error_max"] = float(np.abs(error).max())
        found["contour_error_rms"] = math.sqrt(float(np.mean(error**2)))
    found["cycle_time"] = done.plan.profile.duration
    feed = np.minimum(done.path.feed, scenario.machine.limits.velocity)
    found["cycle_time_ideal"] = time_without_limits(done.path.curve, feed) + float(done.path.dwell_after.sum())
    lag = np.abs(reference.point[:, :2] - history.position).max(axis=0)
    found["tracking_error_max_x"], found["tracking_error_max_y"] = map(float, lag)
    found |= _settling(done)
    found["drive_voltage_max"] = float(np.abs(history.voltage).max())
    found["saturation_time"] = float(history.clipped.any(axis=1).sum()) * scenario.machine.control.sample_time
    lowest = _lowest_feed(scenario, done)
    if lowest is not None:
        found["feed_min"] = lowest
    found |= _forces(scenario, done)
    found |= _contact_measures(done)
    for i, (axis, figures) in enumerate(zip("xy", done.loops, strict=True)):
        plant = done.drives.plant_x if i == 0 else done.drives.plant_y
        torque = plant.current_gain * plant.torque_constant * np.abs(history.voltage[:, i]).max()
        found[f"drive_torque_max_{axis}"] = float(torque)
        found[f"bandwidth_{axis}"] = figures.sampled_bandwidth
        found[f"phase_margin_{axis}"] = figures.sampled_phase_margin
    found |= _tip_measures(done)
    found["path_length"] = float(done.path.curve.knots[-1])
    found["stops"] = float(done.plan.stops)
    return found


def _contact_measures(done: MillRun) -> dict[str, float]:
    """Immersion angles, and what is taken of a stock."""
    met, found = done.contact, {}
    if met.steady:
        found["engagement_angle_max"] = met.greatest
    if "straight" in met.steady:
        found["engagement_angle_straight"] = met.steady["straight"].high
    if met.removal is not None:
        step = np.diff(done.reference.travelled, append=done.reference.travelled[-1])
        found["removed_volume"] = float(met.removal @ step)
        found["removal_rate_max"] = float((met.removal * done.reference.speed).max())
    return found


def _tip_measures(done: MillRun) -> dict[str, float]:
    """How far the tip is pushed, and the wall that it leaves: contour error plus tip, where teeth pass the wall."""
    if done.cut.law != DELAYED or not done.tip_swings:
        return {}
    found = {"tip_deflection_max": float(done.history.tip[:, 2].max())}
    wall = wall_left(done)
    if np.isfinite(wall).any():
        found["wall_error_min"], found["wall_error_max"] = float(np.nanmin(wall)), float(np.nanmax(wall))
    return found


def wall_left(done: MillRun) -> FloatArray:
    """Least and greatest error of the wall left at each servo instant, positive into the wall [m]; shape (n, 2)."""
    return done.contour_error[:, None] + done.history.left


def _settling(done: MillRun) -> dict[str, float]:
    """Overshoot along the last direction, and the time to come within 5 µm of the end point for good."""
    reference, history = done.reference, done.history
    after = reference.time >= reference.end
    end = reference.point[-1, :2]
    direction = reference.direction[-1, :2]
    if not after.any() or math.hypot(*direction) < 0.5:
        return {}
    off = history.position[after] - end
    found = {"settling_overshoot": max(float((off @ direction).max()), 0.0)}
    outside = np.flatnonzero(np.hypot(off[:, 0], off[:, 1]) > _SETTLED)
    if outside.size == 0:
        found["settling_time"] = 0.0
    elif outside[-1] + 1 < off.shape[0]:
        found["settling_time"] = float(reference.time[after][outside[-1] + 1]) - reference.end
    return found


def _lowest_feed(scenario: MillingScenario, done: MillRun) -> float | None:
    speed = np.hypot(done.history.speed[:, 0], done.history.speed[:, 1])
    reference = done.reference
    if scenario.path is not None:
        near = np.hypot(reference.point[:, 0], reference.point[:, 1]) <= _NEAR_CORNER
    else:
        cutting = np.flatnonzero(done.path.cuts)
        if cutting.size == 0 or not done.contact.immersion.any():
            return None
        knots = done.path.curve.knots
        inside = (reference.travelled > knots[cutting[0]] + _NEAR_CORNER) & (
            reference.travelled < knots[cutting[-1] + 1] - _NEAR_CORNER
        )
        near = inside & (done.contact.immersion > 0.0)
    return float(speed[near].min()) if near.any() else None


def _forces(scenario: MillingScenario, done: MillRun) -> dict[str, float]:
    """Peaks over the run, and the static figures of straight and corner at the programmed feed per tooth."""
    if done.cut.law == NO_FORCE or not done.contact.steady:
        return {}
    peak = done.history.force_peak
    axial = scenario.material.K_ac is not None or scenario.material.k_a11 is not None
    found = {"force_xy_peak": float(peak[:, 3].max())}
    for i, axis in enumerate("xyz" if axial else "xy"):
        found[f"force_{axis}_peak"] = float(peak[:, i].max())
    c = done.cut
    law = c.law if c.law != AVERAGED else FLUTES if even_and_linear(c.edges) else DELAYED
    for name, patch in done.contact.steady.items():
        mean = static_force(done, patch)
        found[f"force_xy_mean_{name}"] = math.hypot(mean[0], mean[1])
        tooth = tooth_period(law, patch.low, patch.high, done.chip, patch.depth, c.mill, c.discs, c.edges, 720)
        found[f"force_xy_peak_{name}"] = float(np.hypot(tooth[:, 0], tooth[:, 1]).max())
    return found


def static_force(done: MillRun, patch: SteadyPatch) -> tuple[float, float, float]:
    """Mean force of a steady cut along +x at the programmed feed per tooth, run-out left out [N]."""
    c = done.cut
    even = c.edges._replace(runout=0.0)
    return wall_force(
        AVERAGED, 0.0, 0.0, patch.low, patch.high, 0.0, patch.depth, done.chip, 0.0, c.mill, c.discs, even
    )


def stages(done: MillRun, **more: xr.Dataset | None) -> xr.DataTree:
    """The histories of all stages as labelled arrays, with units; ``more`` are further groups, those that there are."""
    r, h = done.reference, done.history
    time = ("time", r.time, "s", "time")
    plants = (done.drives.plant_x, done.drives.plant_y)
    torque = h.voltage * np.array([p.current_gain * p.torque_constant for p in plants])
    groups = {
        "motion": labelled(time, {
            "travelled": (r.travelled, "m", "way along the path"),
            "commanded": (np.ascontiguousarray(r.point[:, :2]), "m", "commanded position of the tool centre"),
            "actual": (h.position, "m", "actual position of the tool centre"),
            "speed_planned": (r.speed, "m/s", "planned speed along the path"),
            "speed_actual": (np.hypot(h.speed[:, 0], h.speed[:, 1]), "m/s", "actual speed"),
            "tracking_error": (r.point[:, :2] - h.position, "m", "set point minus actual position"),
            "voltage": (h.voltage, "V", "output of the controllers"),
            "motor_torque": (torque, "N*m", "motor torque"),
            "saturated": (h.clipped.astype(float), "1", "controller at its limit"),
        }, axis=["x", "y"]).merge(_frequency_response(done)),
        "engagement": _engagement(done, time),
        "cutting": labelled(time, {
            "force": (h.force, "N", "mean force on the tool over a sample"),
            "force_peak": (h.force_peak[:, :3], "N", "largest force on the tool in a sample"),
        }, axis=["x", "y", "z"]).merge(labelled(time, {
            "force_xy_peak": (h.force_peak[:, 3], "N", "largest force in the xy plane in a sample"),
        })),
        "surface": labelled(time, {
            "contour_error": (done.contour_error, "m", "distance from the path, positive to its right (into the wall)"),
        }),
    }  # fmt: skip
    if done.tip_swings:
        wall = wall_left(done)
        groups["structure"] = labelled(time, {
            "tip": (h.tip[:, :2], "m", "mean displacement of the tool tip by its modes in a sample"),
            "tip_peak": (h.tip[:, 2], "m", "largest displacement of the tip in a sample"),
            "wall_error_min": (wall[:, 0], "m", "least error of the wall left in a sample, positive into the wall"),
            "wall_error_max": (wall[:, 1], "m", "greatest error of the wall left in a sample, positive into the wall"),
        }, axis=["x", "y"])  # fmt: skip
    groups |= {name: group for name, group in more.items() if group is not None}
    return xr.DataTree.from_dict(groups)


def _engagement(done: MillRun, time: tuple[str, FloatArray, str, str]) -> xr.Dataset:
    variables = {
        "immersion": (done.contact.immersion, "rad", "immersion angle"),
        "block": (done.reference.block.astype(float), "1", "block of the path"),
    }
    if done.contact.removal is not None:
        variables["removal"] = (done.contact.removal, "m**2", "cross-section taken per length of feed")
    return labelled(time, variables)


def _frequency_response(done: MillRun) -> xr.Dataset:
    """Open and closed loop of both axes, continuous and sampled."""
    d = done.drives
    nyquist = 0.5 / d.law_x.sample_time
    hertz = np.geomspace(0.5, 0.98 * nyquist, 300)
    w = 2.0 * math.pi * hertz
    pairs = ((d.plant_x, d.law_x), (d.plant_y, d.law_y))
    opened = np.column_stack([open_loop(w, *pair) for pair in pairs])
    held = np.column_stack([sampled_response(w, *pair) for pair in pairs])
    return labelled(("frequency", hertz, "Hz", "frequency"), {
        "open_loop_gain": (np.abs(opened), "1", "magnitude of the continuous loop gain"),
        "open_loop_phase": (_phase(opened), "rad", "phase of the continuous loop gain"),
        "closed_loop_gain": (np.abs(opened / (1 + opened)), "1", "magnitude of the continuous closed loop"),
        "sampled_closed_loop_gain": (np.abs(held / (1 + held)), "1", "magnitude of the sampled closed loop"),
        "sampled_open_loop_gain": (np.abs(held), "1", "magnitude of the sampled loop gain"),
        "sampled_open_loop_phase": (_phase(held), "rad", "phase of the sampled loop gain"),
    }, axis=["x", "y"])  # fmt: skip


def _phase(response: np.ndarray) -> FloatArray:
    """Continuous phase of responses over their first axis, starting between -360° and 0 [rad]."""
    phase = np.unwrap(np.angle(response), axis=0)
    return np.asarray(phase - 2.0 * math.pi * np.ceil(phase[0] / (2.0 * math.pi)))


def stability(scenario: MillingScenario, done: MillRun) -> TipStability | None:
    """Whether the tip chatters in steady cuts; None for a rigid tool."""
    tip = tip_modes(scenario)
    if tip is None or not done.contact.steady:
        return None
    return tip_stability(done.cut, tip, done.chip, done.contact.steady)


COMPARED = (
    "cycle_time", "contour_error_max", "contour_error_rms", "force_xy_peak", "force_xy_mean_corner",
    "engagement_angle_max", "feed_min", "drive_voltage_max", "settling_overshoot",
)  # fmt: skip


def compare(scenario: MillingScenario) -> dict[str, Mapping[str, float]]:
    """Measures of each corner strategy that the scenario asks to compare, by its name."""
    if scenario.path is None:
        return {}
    rows: dict[str, Mapping[str, float]] = {}
    for strategy in scenario.path.compare:
        blend = strategy if isinstance(strategy, Blend) else None
        path = {"corner": "sharp" if blend else strategy, "compare": ()}
        other = scenario.model_copy(update={
            "path": scenario.path.model_copy(update=path), "path_mode": blend or "exact_path",
        })  # fmt: skip
        rows[_named(strategy)] = measures(other, run(other, scenario.numerics.substeps))
    return rows


def _named(strategy: str | float | Blend) -> str:
    if isinstance(strategy, Blend):
        return f"blend {units.show(strategy.blend, 'length', 3)}, {strategy.shape}"
    return "sharp, exact stop" if isinstance(strategy, str) else f"fillet {units.show(strategy, 'length', 3)}"


def comparison_table(
    rows: Mapping[str, Mapping[str, float]], known: Mapping[str, tuple[str, str]]
) -> xr.Dataset | None:
    """The compared measures over the strategies."""
    if not rows:
        return None
    names = [name for name in COMPARED if all(name in row for row in rows.values())]
    data = {
        name: (("strategy",), [row[name] for row in rows.values()],
               {"units": units.DIMENSIONS[known[name][0]].si or "1", "long_name": known[name][1]})
        for name in names
    }  # fmt: skip
    return xr.Dataset(data, coords={"strategy": list(rows)})
