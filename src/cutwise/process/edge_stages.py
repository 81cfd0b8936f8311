"""What a pass along an edge tells: over time, along the edge, and tooth by tooth at its end."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.process import carriers
from cutwise.process.deburring import EdgeRun, displacements, on_path, seen_from_edge, tooth_history
from cutwise.process.labels import Column, Coordinate, Group, Groups, Over, labelled
from cutwise.process.loops import programmed_heights
from cutwise.spec.deburring import DeburringScenario

if TYPE_CHECKING:
    import xarray as xr

_AXES = ("x", "y", "z")
_TOOTH_CURVE = 64  # samples of a tooth period in the curve
_TOOTH_PERIODS = 4


_OVER: Over = {
    "time": Coordinate(lambda run: run.history.motion.time, "s", "time"),
    "w": Coordinate(lambda run: run.surface.position, "m", "position along the edge"),
    "displacement": Coordinate(lambda run: np.array([0.0, 0.0, run.statics.stop]), "m", "displacement of the tip"),
    "axis": _AXES,
    "axis2": _AXES[:2],
    "piston": lambda run: list(range(run.history.response.travel.shape[1])),
}


def _power(run: EdgeRun) -> FloatArray:
    cutter = run.cell.cutter
    return np.asarray(run.history.tangential * cutter.mill.radius * cutter.spindle_speed)


def _branch(force: float) -> FloatArray:
    """Static tip force over tip displacement: flat from breakaway to the stop."""
    return np.array([0.0, force, force])


GROUPS = {
    "motion": Group({
        "feed_position": Column("time", lambda run: run.history.motion.position, "m", "programmed position along the edge"),
        "programmed_height": Column("time", lambda run: programmed_heights(run.cell, run.pace), "m",
                                    "lowest point of the undeflected mill above the edge"),
    }, _OVER),
    "engagement": Group({
        "burr_depth": Column("time", lambda run: run.history.engagement.burr_depth, "m", "radial depth in the burr"),
        "work_depth": Column("time", lambda run: run.history.engagement.work_depth, "m", "radial depth in the work"),
        "feed_angle": Column("time", lambda run: run.history.engagement.feed_direction, "rad",
                             "feed direction, positive when plunging"),
        "chip_load": Column("time", lambda run: run.history.engagement.chip, "m", "feed per tooth"),
        "immersion_entry": Column("time", lambda run: run.history.engagement.entry, "rad", "entry angle"),
        "immersion_exit": Column("time", lambda run: run.history.engagement.exit, "rad", "exit angle"),
    }, _OVER),
    "cutting": Group({
        "burr_force": Column("time axis", lambda run: run.history.burr_force.mean, "N", "burr force on the tool"),
        "work_force": Column("time axis", lambda run: run.history.work_force.mean, "N", "work force on the tool"),
        "power": Column("time", _power, "W", "cutting power"),
    }, _OVER),
    "surface": Group({
        "error": Column("w", lambda run: run.surface.error, "m", "edge error"),
        "burr_height": Column("w", lambda run: run.surface.burr_height, "m", "burr height before the pass"),
        "error_at_tool": Column("time", lambda run: run.error_at_tool, "m", "edge error at point C"),
    }, _OVER),
}  # fmt: skip
"""What every pass along an edge tells over time, and along the edge."""

SPINDLE = Group({
    "tilt": Column("time axis2", lambda run: run.history.response.tilt, "rad", "tilt of the motor"),
    "tip_deflection": Column("time axis2", lambda run: run.history.response.tilt * run.cell.reach, "m",
                             "deflection of the tool tip"),
    "piston_travel": Column("time piston", lambda run: run.history.response.travel, "m", "piston travel"),
    "solver_sweeps": Column("time", lambda run: run.history.response.sweeps, "1", "Gauss-Seidel sweeps"),
    "characteristic_loading": Column("displacement", lambda run: _branch(run.statics.loading.plateau), "N", "tip force, loading"),
    "characteristic_unloading": Column("displacement", lambda run: _branch(run.statics.unloading.plateau), "N",
                                       "tip force, unloading"),
    "characteristic_frictionless": Column("displacement", lambda run: _branch(run.statics.frictionless), "N",
                                          "tip force without friction"),
}, _OVER, attrs=lambda run: _static_forces(run))  # fmt: skip
"""What a compliant spindle does."""


def stages(scenario: DeburringScenario, run: EdgeRun) -> Groups:
    """The histories of all stages; without a spindle that yields, the displacement by each term."""
    if run.cell.ring is None:
        moved = {name: seen_from_edge(run, value) for name, value in displacements(run.cell, run.history).items()}
        structure = carriers.deflections(moved, "the edge", "time", _OVER)
    else:
        structure = SPINDLE
    carried_by_it = carriers.of_carrier(run.cell.carriage, scenario.robot, *on_path(run))
    return {**GROUPS, "structure": structure, **carried_by_it, **_teeth(run)}


def _last_rows(run: EdgeRun) -> int:
    """A row of the steady part after which some tooth periods still fit in."""
    cutter, time = run.cell.cutter, run.history.motion.time
    room = _TOOTH_PERIODS * 2.0 * math.pi / (cutter.mill.flutes * cutter.spindle_speed)
    return max(0, int(np.searchsorted(time, time[run.steady.stop - 1] - room)) - 1)


def _teeth(run: EdgeRun) -> dict[str, xr.Dataset]:
    """Forces tooth by tooth at the end of the steady part."""
    if run.cell.ring is None:
        return {}
    time, force = tooth_history(run, np.array([_last_rows(run)]), _TOOTH_CURVE, _TOOTH_PERIODS)
    return {"tooth": labelled(("tooth_time", time[0], "s", "time"), {
        "burr_force": (force[0, :, :3], "N", "burr force on the tool, tooth by tooth"),
        "work_force": (force[0, :, 3:], "N", "work force on the tool, tooth by tooth"),
    }, axis=list(_AXES))}  # fmt: skip


def _static_forces(run: EdgeRun) -> dict[str, float]:
    s = run.statics
    assert s is not None
    return {
        "breakaway_force": s.loading.breakaway,
        "loading_force": s.loading.plateau,
        "frictionless_force": s.frictionless,
        "unloading_force": s.unloading.plateau,
        "return_force": s.unloading.breakaway,
        "stop": s.stop,
    }
