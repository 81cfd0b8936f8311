"""What a run has to say beyond its numbers: situations that do not settle, with the remedy; where it ended, and why."""

from collections.abc import Iterator, Mapping

import numpy as np

from cutwise import units
from cutwise.physics.structure.pistons import SWEEPS
from cutwise.process import carriers, spindles
from cutwise.process.deburring import (
    EdgeRun,
    after_lead_in,
    answers_at_once,
    between,
    memory_needed,
    on_path,
    places_after_lead_in,
    run_for,
)
from cutwise.process.loops import EdgeCell, programmed_heights, run_swept_edge
from cutwise.process.passes import at_stop, drifting
from cutwise.process.spindles import weight_on
from cutwise.results import Finding, Place, Remedy, Said, warned
from cutwise.spec.deburring import DeburringScenario

_GONE = 0.01  # share of the edge along which contact may be lost
_FULL = 0.999  # of the programmed feed
_LATCHED = 0.05  # share of the band above the loading plateau

LIMITS = (
    "The motor is rigid and tilts by small angles about its joint; the mill and the part do not bend.",
    "Chip thickness is feed per tooth times the sine of the immersion angle (no trochoid: below 0.5 % in force).",
    "Coefficients are constant along the edge; no wear, no temperature, no burr that bends away instead of being cut.",
    "The spindle keeps its speed: the droop of an air motor under load is not modelled.",
    "The moment of the axial force about the joint is left out (about 1 µm).",
)


def warnings(scenario: DeburringScenario, run: EdgeRun, found: Mapping[str, float]) -> tuple[Said, ...]:
    """Everything that the engineer should know before he trusts the numbers."""
    of_carrier = carriers.warnings(scenario, [run.cell.carriage], scenario.part.block)
    return (*of_carrier, *_process(scenario, run, found))


def _process(scenario: DeburringScenario, run: EdgeRun, found: Mapping[str, float]) -> Iterator[Finding]:
    steady = run.steady
    if run.cell.ring is None or scenario.spindle == "rigid":
        yield from _beyond_the_steady_part(scenario, run)
        return
    yield from spindles.overload(scenario.spindle, found["cutting_power_mean"])
    depth = run.history.engagement.burr_depth[steady] + run.history.engagement.work_depth[steady]
    if depth.max() > 0.0 and np.abs(run.history.response.tilt[steady]).max() * run.cell.reach < 1e-6:
        yield warned(
            "no_breakaway",
            "the spindle does not break away: the mill cuts like a rigid tool, to the preset; lower the pressure if "
            "compliance is wanted", remedy=Remedy("spindle.pressure", "lower"),
        )  # fmt: skip
    yield from _latched(run, found)
    yield from _beyond_the_steady_part(scenario, run)
    index = found["path_memory_index"]
    if memory_needed(run.cell) and not swept(scenario, run):
        yield warned(
            "memory_left_out", f"the mill meets its own older surface (path-memory index {index:.3g}, run-out "
            f"{units.show(run.cell.cutter.edges.runout, 'small_length')}), which the arcs leave out: trust the mean error, "
            "not the wave; numerics.engagement swept (with averaged force"
            f"{' and robot.dynamics: modal' if answers_at_once(run.cell) else ''}) keeps the surface", index, 1.0,
            remedy=Remedy("numerics.engagement", "swept"),
        )  # fmt: skip


def _latched(run: EdgeRun, found: Mapping[str, float]) -> Iterator[Finding]:
    share = band_share(found)
    if share is None or share <= _LATCHED:
        return
    where = f"friction holds the tool {share:.0%} of the way from the loading to the unloading plateau: "
    if has_path_error(run.cell):
        said = where + (
            "the waves of the path error carry it there and back, and seal friction does not let it follow; a more "
            "accurate path or seals of less friction help, a longer lead-in does not"
        )
        yield warned("latched", said, share, _LATCHED)
    else:
        said = where + "an overshoot of the lead-in has latched; lengthen the lead-in, or start lower"
        yield warned("latched", said, share, _LATCHED, remedy=Remedy("operation.lead_in_time", "longer"))


def has_path_error(cell: EdgeCell) -> bool:
    """Whether the robot is off its path at all."""
    return cell.path.error_amplitude != 0.0 or bool(np.any(cell.path.error_curve.coefficient))


def _beyond_the_steady_part(scenario: DeburringScenario, run: EdgeRun) -> Iterator[Finding]:
    """The measures are those of the last quarter; say so where the rest of the edge breaks what is required there."""
    after = after_lead_in(run)
    steady = between(run, run.steady.start, run.steady.stop - 1)
    for name, worst, there, sign in (
        ("surface_error_max", after.max(), steady.max(), 1.0),
        ("surface_error_min", after.min(), steady.min(), -1.0),
    ):
        limit = scenario.requirements.get(name)
        bound = None if limit is None else (limit.max if sign > 0 else limit.min)
        if bound is not None and sign * (worst - bound) > 0.0 >= sign * (there - bound):
            yield warned(
                "missed_before",
                f"{name} is met in the steady part (the last quarter of the run), but the edge reaches {_error(worst)} "
                "elsewhere after the lead-in; lengthen the run so that the last quarter sees whole waves of burr and path "
                "error, or lengthen the lead-in", float(worst), bound, "small_length",
            )  # fmt: skip


def swept(scenario: DeburringScenario, run: EdgeRun) -> bool:
    """Whether the pass ran over a surface with memory."""
    return run_for(scenario, run.cell) is run_swept_edge


def band_share(found: Mapping[str, float]) -> float | None:
    """Where the run ended between the loading (0) and the unloading plateau (1)."""
    low, high = found.get("surface_error_loaded"), found.get("surface_error_unloaded")
    if low is None or high is None or high - low < 1e-9:
        return None
    return (found["surface_error_mean"] - low) / (high - low)


def notes(scenario: DeburringScenario, run: EdgeRun, found: Mapping[str, float]) -> dict[str, str]:
    """Where in the band the run ended, and where the edge came out worst."""
    told = {
        "engagement": "The engagement was taken from a swept surface with memory, cut down by every position of the mill."
        if swept(scenario, run)
        else "The engagement was taken from immersion arcs of the present position of the mill (no surface memory)."
    }
    share = band_share(found)
    if share is not None:
        told["band"] = (
            "The equilibrium under friction is not a point but a band: from "
            f"{_error(found['surface_error_loaded'])} (loading plateau) to "
            f"{_error(found['surface_error_unloaded'])} (unloading plateau). This run ended at "
            f"{_error(found['surface_error_mean'])}, {share:.1%} of the way; the history decides where."
        )
    inside = places_after_lead_in(run)
    if inside.any():
        w, error = run.surface.position[inside], run.surface.error[inside]
        deep, high = int(error.argmin()), int(error.argmax())
        told["worst"] = (
            f"After the lead-in the deepest place is {_error(error[deep])} at w = {units.show(w[deep], 'length')}, "
            f"the highest {_error(error[high])} at w = {units.show(w[high], 'length')}."
        )
    after = np.flatnonzero(run.pace >= run.cell.path.lead_in)
    row = int(after[np.argmax(np.abs(run.error_at_tool[after]))]) if after.size else 0
    height, at, moved = on_path(run)
    return told | carriers.notes(run.cell.carriage, height, float(at[row]), moved, row)


def _error(value: float) -> str:
    return units.show(value, "small_length", 4)


def unsound(scenario: DeburringScenario, run: EdgeRun) -> Iterator[Finding]:
    """At the stop, never touching, contact lost, still moving, pistons not solved."""
    time = run.history.motion.time
    if run.cell.ring is not None:
        yield from at_stop(time, run.history.response.travel.max(axis=1), run.cell.ring.piston.stroke)
    depth = run.history.engagement.burr_depth + run.history.engagement.work_depth
    if depth[run.steady].max() <= 0.0:
        yield Finding("untouched")
    else:
        yield from _left_standing(scenario, run, depth)
    yield from _drifting(run)
    unsolved = np.flatnonzero(run.history.response.sweeps >= SWEEPS)
    if unsolved.size:
        yield Finding("unsolved", Place(time=float(time[unsolved[0]])), float(unsolved.size), 0.0)


def _left_standing(scenario: DeburringScenario, run: EdgeRun, depth: np.ndarray) -> Iterator[Finding]:
    """A mill that is off the work although it is led into it, and leaves more than the tolerance there."""
    motion, cell = run.history.motion, run.cell
    led = motion.height < np.interp(motion.position, cell.layers.burr_height.at, cell.layers.burr_height.value)
    judged = (run.pace >= cell.path.lead_in) & (np.arange(motion.time.size) < run.steady.stop)
    gone = led & judged & (depth <= 0.0)
    left = gone & (run.error_at_tool > scenario.operation.tolerance)
    share = float(left.sum() / max(1, judged.sum()))
    if share > _GONE:
        first = int(np.flatnonzero(left)[0])
        where = Place(time=float(motion.time[first]), position=float(motion.position[first]))
        yield Finding("contact_lost", where, share, _GONE)


def _drifting(run: EdgeRun) -> Iterator[Finding]:
    """A steady part that begins before the lead-in has ended, or in which the edge still moves though nothing else does."""
    motion, steady, layers = run.history.motion, run.steady, run.cell.layers
    began = float(run.pace[steady.start])
    if run.cell.path.lead_in > began:
        yield Finding("unsettled", Place(time=began), run.cell.path.lead_in, began, "time")
        return
    at = motion.position[steady]
    fed = run.history.fed is not None
    height = programmed_heights(run.cell, run.pace[steady]) if fed else motion.height[steady]
    led = (height, *(np.interp(at, p.at, p.value) for p in (layers.burr_height, layers.burr_width)))
    if any(np.ptp(one) > 1e-9 for one in led):
        return  # waves of path and burr: the edge follows them for good
    error = run.error_at_tool[steady]
    if fed:  # the machine brakes at the end of the edge, which is no drift
        rate = np.gradient(run.pace, motion.time)[steady]
        error = error[rate > _FULL] if (rate > _FULL).any() else error
    yield from drifting(began, error)


def weight(run: EdgeRun) -> Iterator[Finding]:
    """The weight of the motor at the tip, against what the pistons hold."""
    if run.cell.ring is not None:
        yield from weight_on(run.cell.ring, run.cell.reach, Place())
