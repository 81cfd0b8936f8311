"""The numbers of a milling run."""

import math

import numpy as np

from cutwise import units
from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.plunge import plunge_force
from cutwise.physics.cutting.uneven import even_and_linear
from cutwise.physics.cutting.wall import AVERAGED, DELAYED, FLUTES, tooth_period, wall_force
from cutwise.physics.motion.lookahead import time_without_limits
from cutwise.process import milling_wall, part_cost, spindles
from cutwise.process.edges import known_axes
from cutwise.process.loops_drives import NO_FORCE
from cutwise.process.milling import MillRun, wall_left
from cutwise.process.milling_contact import SteadyPatch
from cutwise.process.milling_peaks import largest_forces
from cutwise.results import SolverFailure
from cutwise.spec.milling import CornerPath, MillingScenario
from cutwise.spec.program import StockBlock

NEAR_CORNER = 10e-3  # [m] within which the lowest feed is looked for
SETTLED = 5e-6  # [m]


def measures(scenario: MillingScenario, done: MillRun) -> dict[str, float]:
    """All measures of the run in SI; one that does not apply is left out."""
    found = {} if done.lost is not None else _errors(done)
    found["cycle_time"] = done.plan.profile.duration
    found["cycle_time_ideal"] = time_without_limits(done.path.curve, done.feed) + float(done.path.dwell_after.sum())
    if done.lost is None:
        found |= _drive_measures(scenario, done)
        found |= _peak_forces(scenario, done)
    found |= _steady_forces(done)
    found |= _contact_measures(scenario, done)
    for axis, figures in zip("xyz", done.loops, strict=False):
        found[f"bandwidth_{axis}"] = figures.sampled_bandwidth
        found[f"phase_margin_{axis}"] = figures.sampled_phase_margin
    if done.lost is None:
        found |= _tip_measures(done)
    if done.wall is not None:
        found |= milling_wall.measures(done.wall) | spindles.stroke_left(scenario.compliant, done.wall.state)
    found["path_length"] = float(done.path.curve.knots[-1])
    found["stops"] = float(done.plan.stops)
    return found | part_cost.measures(scenario, done)


def _errors(done: MillRun) -> dict[str, float]:
    """How far the path is left, and by the drives alone where its corners are blended."""
    error = done.contour_error[np.isfinite(done.contour_error)]
    if error.size == 0:
        return {}
    found = {
        "contour_error_max": float(np.abs(error).max()),
        "contour_error_rms": float(np.linalg.norm(error)) / math.sqrt(error.size),
    }
    if done.wanted.blended:
        found["drive_error_max"] = float(np.nanmax(np.abs(done.drive_error)))
    return found


def _drive_measures(scenario: MillingScenario, done: MillRun) -> dict[str, float]:
    """Lag, settling, voltage and torque of the drives."""
    history = done.history
    found: dict[str, float] = {}
    lag = np.abs(done.reference.point[:, : len(done.drives)] - history.position).max(axis=0)
    found |= {f"tracking_error_max_{axis}": float(most) for axis, most in zip("xyz", lag, strict=False)}
    found |= _settling(done)
    found["drive_voltage_max"] = float(np.abs(history.voltage).max())
    found["saturation_time"] = float(history.clipped.any(axis=1).sum()) * scenario.drives.control.sample_time
    lowest = _lowest_feed(scenario, done)
    if lowest is not None:
        found["feed_min"] = lowest
    for i, (axis, (plant, _)) in enumerate(zip("xyz", done.drives, strict=False)):
        torque = plant.current_gain * plant.torque_constant * np.abs(history.voltage[:, i]).max()
        found[f"drive_torque_max_{axis}"] = float(torque)
    return found


def _contact_measures(scenario: MillingScenario, done: MillRun) -> dict[str, float]:
    """Immersion angles, and what is taken of a stock."""
    met, found = done.contact, {}
    if done.steady.width:
        found["engagement_angle_max"] = met.greatest
    if "straight" in done.steady.width:
        straight = done.steady.width["straight"]
        found["engagement_angle_straight"] = straight.high - straight.low
    if met.removal is not None:
        found["removed_volume"] = _removed(scenario, done, met.removal)
        found["removal_rate_max"] = float((met.removal * done.reference.speed).max())
    found |= _plunge(scenario, done)
    return found


def _plunge(scenario: MillingScenario, done: MillRun) -> dict[str, float]:
    """Largest force along the axis of moves straight down into the stock, as if their whole bottom cut."""
    into, core = done.contact.into.plunges, scenario.tool.end_core
    if core is None or not into or done.cut.law == NO_FORCE or not even_and_linear(done.cut.edges):
        return {}
    reference = done.reference
    down = np.isin(done.path.source[reference.block], into) & (reference.direction[:, 2] < 0.0)
    fed = float((-reference.direction[:, 2] * reference.speed)[down].max(initial=0.0))
    chip = fed * 2.0 * math.pi / (done.cut.spindle * done.cut.mill.flutes)
    return {"plunge_force_max": plunge_force(chip, core, done.cut.mill, done.cut.edges.linear)}


def _removed(scenario: MillingScenario, done: MillRun, removal: FloatArray) -> float:
    """Volume that is taken, the sum over the servo steps [m^3].

    Raises
    ------
    SolverFailure
        It is more than the block has: beyond 1 %, and a whole servo step at each place where the mill comes into contact.
    """
    step = np.diff(done.reference.travelled, append=done.reference.travelled[-1])
    removed, stock = float(removal @ step), scenario.stock
    if isinstance(stock, StockBlock):
        block = math.prod(high - low for low, high in (stock.x, stock.y, stock.z))
        entries = int(np.count_nonzero((removal[1:] > 0.0) & (removal[:-1] == 0.0))) + 1
        if removed > 1.01 * block + entries * float(step.max()) * float(removal.max()):
            raise SolverFailure(
                f"the mill takes {units.show(removed, 'volume', 4)} of a block of {units.show(block, 'volume', 4)}: its contact "
                "with the stock is wrong; please report this program"
            )
    return removed


def _tip_measures(done: MillRun) -> dict[str, float]:
    """How far the tip is pushed, and the wall that it leaves: contour error plus tip, where teeth pass the wall."""
    if done.cut.law != DELAYED or not done.tip_swings:
        return {}
    found = {"tip_deflection_max": float(done.history.tip[:, 2].max())}
    wall = wall_left(done)
    if np.isfinite(wall).any():
        found["wall_error_min"], found["wall_error_max"] = float(np.nanmin(wall)), float(np.nanmax(wall))
    return found


def _settling(done: MillRun) -> dict[str, float]:
    """Overshoot along the last direction, and the time to come within 5 µm of the end point for good."""
    reference, history = done.reference, done.history
    after = reference.time >= reference.end
    end = reference.point[-1, :2]
    direction = reference.direction[-1, :2]
    if not after.any() or math.hypot(*direction) < 0.5:
        return {}
    off = history.position[after, :2] - end
    found = {"settling_overshoot": max(float((off @ direction).max()), 0.0)}
    outside = np.flatnonzero(np.hypot(off[:, 0], off[:, 1]) > SETTLED)
    if outside.size == 0:
        found["settling_time"] = 0.0
    elif outside[-1] + 1 < off.shape[0]:
        found["settling_time"] = float(reference.time[after][outside[-1] + 1]) - reference.end
    return found


def _lowest_feed(scenario: MillingScenario, done: MillRun) -> float | None:
    speed = np.hypot(done.history.speed[:, 0], done.history.speed[:, 1])
    reference = done.reference
    if isinstance(scenario.path, CornerPath):
        near = np.hypot(reference.point[:, 0], reference.point[:, 1]) <= NEAR_CORNER
    else:
        cutting = np.flatnonzero(done.path.cuts)
        if cutting.size == 0 or not done.contact.immersion.any():
            return None
        knots = done.path.curve.knots
        inside = (reference.travelled > knots[cutting[0]] + NEAR_CORNER) & (
            reference.travelled < knots[cutting[-1] + 1] - NEAR_CORNER
        )
        near = inside & (done.contact.immersion > 0.0)
    return float(speed[near].min()) if near.any() else None


def _peak_forces(scenario: MillingScenario, done: MillRun) -> dict[str, float]:
    """Peaks over the run; a force averaged over a revolution has none."""
    if done.cut.law in (NO_FORCE, AVERAGED) or not done.steady.width:
        return {}
    sampled = done.history.force_peak.max(axis=0)
    peak = sampled if done.wall is not None else largest_forces(done, scenario.drives.control.sample_time)
    found = {"force_xy_peak": float(peak[3])}
    for i, axis in enumerate(known_axes(scenario.material)):
        found[f"force_{axis}_peak"] = float(peak[i])
    return found


def _steady_forces(done: MillRun) -> dict[str, float]:
    """The static figures of straight and corner, each at the feed per tooth of its own place."""
    if done.cut.law == NO_FORCE:
        return {}
    c, found = done.cut, {}
    law = c.law if c.law != AVERAGED else FLUTES if even_and_linear(c.edges) else DELAYED
    for name, place in done.steady.force.items():
        mean = static_force(done, place)
        found[f"force_xy_mean_{name}"] = math.hypot(mean[0], mean[1])
        tooth = sum(
            tooth_period(law, low, high, place.chip, top - bottom, c.mill, c.discs, c.edges, 720)
            for low, high, bottom, top in place.whole
            if high > low
        )
        assert isinstance(tooth, np.ndarray)
        found[f"force_xy_peak_{name}"] = float(np.hypot(tooth[:, 0], tooth[:, 1]).max())
    return found


def static_force(done: MillRun, place: SteadyPatch) -> FloatArray:
    """Mean force of a steady cut along +x with the contact and feed per tooth of one place, run-out left out [N], (3,)."""
    c = done.cut
    even = c.edges._replace(runout=0.0)
    patches = [
        wall_force(AVERAGED, 0.0, 0.0, low, high, bottom, top, place.chip, 0.0, c.mill, c.discs, even)
        for low, high, bottom, top in place.whole
        if high > low
    ]
    return np.sum(patches, axis=0)
