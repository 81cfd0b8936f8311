"""What a deburring pass amounts to: the numbers, notices and curves that its result reports."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.maths.curves import FloatArray, largest_curvature
from cutwise.physics.cutting.uneven import largest_radius
from cutwise.physics.motion.edge import path_memory_index
from cutwise.physics.structure.statics import Characteristic, characteristic
from cutwise.physics.structure.terms import Compliance
from cutwise.physics.surface.edge import machined_profile
from cutwise.process import carriers, yielding
from cutwise.process.assemble import deburring_cell, surface_height, turned_by, turned_from_start
from cutwise.process.edges import known_axes
from cutwise.process.loops import (
    TOOTH_RESOLVED,
    EdgeCell,
    axis_over_edge,
    columns_carry,
    programmed_time,
    run_compliant_edge,
    run_swept_edge,
    tooth_resolved_forces,
)
from cutwise.process.plateaus import Band, band
from cutwise.records import EdgeHistory, Surface
from cutwise.results import Histories, SolverFailure
from cutwise.spec.deburring import DeburringScenario

_SETTLED = 5e-6  # [m] band of the settling time
_TOOTH_SAMPLES = 32
_TOOTH_PLACES = 1000
PLATEAUS = ("surface_error_loaded", "surface_error_unloaded", "surface_error_frictionless")
"""Measures of the band within which friction holds the edge."""


class EdgeRun(NamedTuple):
    """A finished pass with everything that is read off it."""

    cell: EdgeCell
    history: EdgeHistory
    surface: Surface
    band: Band
    statics: Characteristic | None  # of a compliant spindle
    centre: FloatArray  # [m] axis of the mill at the burr, along the edge and above it, shape (n, 2)
    error_at_tool: FloatArray  # [m] e at point C over time, shape (n,)
    steady: slice  # rows of the last quarter before any lead-out
    pace: FloatArray  # [s] of the programmed motion over time, shape (n,)
    teeth: bool = True  # with the measures tooth by tooth


def memory_needed(cell: EdgeCell) -> bool:
    """Whether the mill meets what it cut itself: under run-out, or with a path-memory index above 1."""
    return cell.cutter.edges.runout > 0.0 or memory_index(cell) > 1.0


def answers_at_once(cell: EdgeCell) -> bool:
    """Whether a term without inertia stands behind the spindle.

    A kept surface gives a step the chip of that step alone: the force has no displacement that goes with it then.
    """
    return any(isinstance(term, Compliance) for _, term in cell.behind)


def run_for(scenario: DeburringScenario, cell: EdgeCell) -> Callable[..., EdgeHistory]:
    """The loop that carries this pass: arcs of the present position, or a swept surface with memory."""
    wanted = scenario.numerics.engagement
    if cell.cutter.force_law == TOOTH_RESOLVED or wanted == "arcs":
        return run_compliant_edge
    if wanted == "swept":
        return run_swept_edge
    kept = memory_needed(cell) and cell.arc is None and columns_carry(cell) and not answers_at_once(cell)
    return run_swept_edge if kept else run_compliant_edge


def passed(
    scenario: DeburringScenario, time_step: float, progress: Callable[[float], None] | None = None, *,
    plateaus: bool = True, teeth: bool = True,
) -> EdgeRun:  # fmt: skip
    """The whole pass; ``plateaus``, ``teeth``: with those of the band, and with measures tooth by tooth."""
    cell = deburring_cell(scenario)
    history = run_for(scenario, cell)(cell, time_step, progress)
    return evaluate(cell, history, plateaus=plateaus)._replace(teeth=teeth)


def evaluate(cell: EdgeCell, history: EdgeHistory, *, plateaus: bool = True) -> EdgeRun:
    """Surface, band (with its ``plateaus``) and static characteristic of a pass.

    Raises
    ------
    SolverFailure
        The tool went out of all bounds.
    """
    settled = np.isfinite(history.response.tilt)
    if not settled.all():
        first = float(history.motion.time[int(np.argmin(settled.all(axis=-1)))])
        helps = " (robot.dynamics: modal gives the arm its mass)" if cell.behind else ""
        raise SolverFailure(
            f"the step from surface to force to tool did not settle after {first:.4g} s: take a smaller numerics.time_step"
            + helps
        )
    strips, radius = cell.layers.strips, cell.cutter.mill.radius
    width = np.interp(history.motion.position, cell.layers.burr_width.at, cell.layers.burr_width.value)
    arm = cell.reach - strips.burr_start - 0.5 * width  # without pistons there is no tilt
    moved = arm[:, None] * history.response.tilt + sum(
        (of_term[:, :2] for of_term in displacements(cell, history).values()), np.zeros(2)
    )
    time = programmed_time(cell, history)
    along, lowest = axis_over_edge(cell, time, moved[:, 0], moved[:, 1])
    centre = np.column_stack([along, lowest + radius])
    burr = cell.layers.burr_height
    end = cell.path.duration - cell.path.lead_out
    steady = slice(int(np.searchsorted(time, 0.75 * end)), max(1, int(np.searchsorted(time, end))))
    runout = cell.cutter.edges.runout
    outermost = largest_radius(runout, cell.cutter.edges.runout_angle, cell.cutter.mill.flutes) if runout else 0.0
    surface = machined_profile(centre[:, 0], centre[:, 1], radius + outermost, burr, points=_profile_points(centre))
    at_steady = centre[steady, 0]
    typical = float(np.interp(at_steady, burr.at, burr.value).mean())
    return EdgeRun(
        cell, history, surface,
        band(cell, typical, float(width[steady].mean())) if cell.ring is not None and plateaus else Band(None, None, None),
        None if cell.ring is None else characteristic(cell.ring, cell.reach),
        centre,
        np.minimum(lowest, np.interp(centre[:, 0], burr.at, burr.value)),
        steady,
        time,
    )  # fmt: skip


def displacements(cell: EdgeCell, history: EdgeHistory) -> dict[str, FloatArray]:
    """Displacement by each term behind the spindle and by drives, where the edge is read, over time [m]; shape (n, 3)."""
    found = yielding.by_term(cell.behind, history.response.behind, surface_height(cell))
    return found if history.fed is None else {**found, "drives": history.fed}


def carried_measures(scenario: DeburringScenario, run: EdgeRun) -> dict[str, float]:
    """What each term of the structure yields by, and what the postures of the robot mean."""
    history, last = run.history, run.steady.stop
    behind = displacements(run.cell, history)
    if not behind:
        return {}
    first = min(int(np.searchsorted(run.pace, run.cell.path.lead_in)), last - 1)
    arm = run.cell.reach - surface_height(run.cell)
    tilt = np.column_stack([arm * history.response.tilt, np.zeros(len(history.motion.time))])
    terms = behind if run.cell.ring is None else {"pistons": tilt, **behind}
    terms = {name: seen_from_edge(run, of_term) for name, of_term in terms.items()}
    total = sum((of_term[:, 1] for of_term in terms.values()), np.zeros(len(tilt)))
    worst = first + int(np.argmax(np.abs(total[first:last] - run.cell.path.preset)))
    of = scenario.operation
    found = yielding.term_measures(terms, slice(first, last), worst)
    return found | carriers.measures(scenario, run.cell.carriage, run.cell.behind, of.feed, limited=of.limit_feed)


def on_path(run: EdgeRun) -> tuple[float, FloatArray, dict[str, FloatArray]]:
    """Height at which the edge is read [m], places of the rows along it [m], and the displacement by each term there."""
    height = surface_height(run.cell)
    return height, run.history.motion.position, yielding.by_term(run.cell.behind, run.history.response.behind, height)


def seen_from_edge(run: EdgeRun, moved: FloatArray) -> FloatArray:
    """Displacements (n, 3) along and off the edge where the tool is, of process axes that may stay while it turns."""
    return turned_by(turned_from_start(run.cell, run.history.motion.position), moved)


def _profile_points(centre: FloatArray) -> int:
    """About 20 µm between points of the profile, within reason."""
    return int(min(50_000, max(2000, np.ptp(centre[:, 0]) / 20e-6)))


def between(run: EdgeRun, first: int, last: int) -> FloatArray:
    """Edge errors between the places where the tool stood in two rows [m]."""
    w = run.surface.position
    here = (w >= run.centre[first, 0]) & (w <= run.centre[last, 0])
    return run.surface.error[here] if here.any() else run.error_at_tool[[last]]


def places_after_lead_in(run: EdgeRun) -> NDArray[np.bool_]:
    """Which points of the profile lie after the lead-in and before any lead-out."""
    w, last = run.surface.position, run.steady.stop - 1
    first = min(int(np.searchsorted(run.pace, run.cell.path.lead_in)), last)
    return (w >= run.centre[first, 0]) & (w <= run.centre[last, 0])


def after_lead_in(run: EdgeRun) -> FloatArray:
    """Edge errors after the lead-in and before any lead-out [m]."""
    inside = places_after_lead_in(run)
    return run.surface.error[inside] if inside.any() else run.error_at_tool[[run.steady.stop - 1]]


def measures(scenario: DeburringScenario, run: EdgeRun) -> Mapping[str, float]:
    """All measures of the pass in SI; one that does not apply is left out."""
    history, steady = run.history, run.steady
    last = steady.stop - 1
    found: dict[str, float | None] = {}
    error = between(run, steady.start, last)
    found |= yielding.extremes("surface_error", error, mean=True)
    found |= {name: None if one is None else one.error for name, one in zip(PLATEAUS, run.band, strict=True)}
    found |= fractions(after_lead_in(run), scenario.operation.tolerance)
    axes = known_axes(scenario.material)
    for i, axis in enumerate(axes):
        found[f"burr_force_mean_{axis}"] = float(history.burr_force.mean[steady, i].mean())
        found[f"burr_force_rms_{axis}"] = math.sqrt(float(history.burr_force.square[steady, i].mean()))
        found[f"burr_force_peak_{axis}"] = float(history.burr_force.peak[:, i].max())
        found[f"work_force_mean_{axis}"] = float(history.work_force.mean[steady, i].mean())
    if run.teeth and run.cell.ring is not None:
        peaks = _tooth_peaks(run)
        found |= {f"tooth_force_peak_{axis}": peaks[i] for i, axis in enumerate(axes)}
    found["settling_time"] = settling_time(history.motion.time[: last + 1], run.error_at_tool[: last + 1])
    cutter = run.cell.cutter
    found["cutting_power_mean"] = float(history.tangential[steady].mean()) * cutter.mill.radius * cutter.spindle_speed
    found["path_memory_index"] = memory_index(run.cell)
    found |= _spindle_measures(run)
    found |= carried_measures(scenario, run)
    return {name: value for name, value in found.items() if value is not None and math.isfinite(value)}


def _spindle_measures(run: EdgeRun) -> dict[str, float | None]:
    """What the compliant spindle does."""
    cell, history = run.cell, run.history
    if cell.ring is None or run.statics is None:
        return {}
    tilt = history.response.tilt[run.steady].mean(axis=0)
    x, y = (cell.reach * tilt).tolist()
    return {
        "tip_deflection_x": x,
        "tip_deflection_y": y,
        "stroke_margin": cell.ring.piston.stroke - float(history.response.travel.max()),
        "edge_taper": float(tilt[1]) * cell.layers.strips.work_width,
        "breakaway_force": run.statics.loading.breakaway,
        "loading_force": run.statics.loading.plateau,
        "unloading_force": run.statics.unloading.plateau,
    }


def fractions(error: FloatArray, tolerance: float) -> dict[str, float]:
    """Shares of an edge that come out partial, ideal and excessive, by its error [m], shape (n,)."""
    partial, excessive = float((error > tolerance).mean()), float((error < -tolerance).mean())
    return {
        "fraction_partial": partial,
        "fraction_ideal": 1.0 - partial - excessive,
        "fraction_excessive": excessive,
    }


def histories(scenario: DeburringScenario, run: EdgeRun, found: Mapping[str, float]) -> Mapping[str, Histories]:
    """Where friction may leave the edge: the measures with the whole edge shifted to both plateaus of the band.

    An end without an equilibrium is not known. Without friction there is no band.
    """
    if run.cell.ring is None or run.cell.ring.piston.law == 0:
        return {}
    mean = found["surface_error_mean"]
    shifts = [None if end is None else end.error - mean for end in (run.band.loaded, run.band.unloaded)]
    bands: dict[str, Histories] = {}
    for name in ("surface_error_mean", "surface_error_min", "surface_error_max"):
        ends = [None if shift is None else found[name] + shift for shift in shifts]
        bands[name] = _between(ends, found[name])
    error, tolerance = after_lead_in(run), scenario.operation.tolerance
    for name in ("fraction_partial", "fraction_ideal", "fraction_excessive"):
        ends = [None if shift is None else fractions(error + shift, tolerance)[name] for shift in shifts]
        bands[name] = _between(ends, found[name], share=True)
    return bands


def _between(ends: list[float | None], value: float, *, share: bool = False) -> Histories:
    """The span of the ends and the value; an end that is not known bounds nothing, but a share is between 0 and 1."""
    first, last = ends
    known = [value, *(end for end in ends if end is not None)]
    if share and None in ends:
        return Histories(0.0, 1.0, "friction")
    return Histories(None if first is None else min(known), None if last is None else max(known), "friction")


def settling_time(time: FloatArray, error: FloatArray) -> float:
    """Last time at which the error is more than 5 µm away from its end [s]."""
    outside = np.flatnonzero(np.abs(error - error[-1]) > _SETTLED)
    return float(time[min(outside[-1] + 1, time.size - 1)]) if outside.size else 0.0


def memory_index(cell: EdgeCell) -> float:
    """Path-memory index of the path error; 0 without one."""
    path, radius = cell.path, cell.cutter.mill.radius
    sine = path.error_amplitude * (2.0 * math.pi * path.error_frequency / path.feed) ** 2
    return path_memory_index(max(sine, largest_curvature(path.error_curve)), radius)


def tooth_history(run: EdgeRun, rows: FloatArray, samples: int, periods: int) -> tuple[FloatArray, FloatArray]:
    """Times and tooth-by-tooth forces over whole tooth periods from each of some rows; shapes (r, m) and (r, m, 6)."""
    cutter = run.cell.cutter
    period = 2.0 * math.pi / (cutter.mill.flutes * cutter.spindle_speed)
    offset = np.arange(samples * periods) * period / samples
    known = run.pace if run.cell.feeding is not None else run.history.motion.time  # what its motion is asked for
    time = known[rows][:, None] + offset
    state = np.hstack([run.history.response.tilt, run.history.response.tilt_rate])[rows]
    tilt = np.repeat(state, offset.size, axis=0)
    forces = tooth_resolved_forces(run.cell, time.ravel(), np.ascontiguousarray(tilt))
    return run.history.motion.time[rows][:, None] + offset, forces.reshape(*time.shape, 6)


def _tooth_peaks(run: EdgeRun) -> list[float]:
    """Largest burr force tooth by tooth over the whole pass, from one tooth period at each of many places [N]."""
    rows = np.unique(np.linspace(0, run.history.motion.time.size - 1, _TOOTH_PLACES).astype(int))
    peaks = np.abs(tooth_history(run, rows, _TOOTH_SAMPLES, 1)[1][..., :3]).max(axis=(0, 1))
    return [float(peak) for peak in peaks]
