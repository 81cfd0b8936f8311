"""An edge at rest: a rigid spindle on whatever carries it, place by place where the mill, the carrier and the part settle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.maths.curves import FloatArray
from cutwise.paths.carried import stations
from cutwise.process import carriers, yielding
from cutwise.process.assemble import (
    edge_cut,
    path_of,
    surface_height,
    turned_by,
    turned_from_start,
)
from cutwise.process.deburring import fractions
from cutwise.process.edges import known_axes
from cutwise.process.labels import Column, Coordinate, Group, Groups, Over
from cutwise.process.loops import EdgeCut, axis_over_edge, programmed_heights, still_edge
from cutwise.process.passes import structure_of, wrenches
from cutwise.results import Finding
from cutwise.spec.deburring import DeburringScenario
from cutwise.still import Rest

LIMITS = (
    "Every place of the edge is at rest: the mean force of the teeth displaces carrier, tool and part; lead-in, ripple "
    "and vibration are left out.",
    "Chip thickness is feed per tooth times the sine of the immersion angle (no trochoid: below 0.5 % in force).",
    "Coefficients are constant along the edge; no wear, no temperature, no burr that bends away instead of being cut.",
    "Joints and bodies are linear; weights are left out, the zero is taken under them.",
)


class StillEdge(NamedTuple):
    """A finished pass at rest."""

    cut: EdgeCut
    at: FloatArray  # [m] of the edge, shape (n,)
    height: float  # [m] over the tip at which the edge is read
    rest: Rest
    moved: Mapping[
        str, FloatArray
    ]  # displacement by each term along and off the edge where it is read [m], shape (n, 3)
    lowest: FloatArray  # [m] lowest point of the displaced mill above the edge, shape (n,)
    programmed: FloatArray  # [m] lowest point of the undeflected mill above the edge, shape (n,)
    burr: FloatArray  # [m] height of the burr, shape (n,)

    @property
    def error(self) -> FloatArray:
        """Edge error [m], positive where burr is left, shape (n,)."""
        return np.minimum(self.lowest, self.burr)


def run(scenario: DeburringScenario) -> StillEdge:
    """The pass at rest, station by station.

    Raises
    ------
    SolverFailure
        Force and displacement do not meet at a place.
    """
    cut = edge_cut(scenario)
    height = surface_height(cut)
    at = path_of(scenario).at if scenario.path else stations(scenario.operation.run_length, scenario.numerics.station)
    at = at[at <= scenario.operation.run_length * (1 + 1e-9)]
    found = still_edge(cut, structure_of(cut.behind), at)
    free = cut._replace(path=cut.path._replace(lead_in=0.0, lead_out=0.0))
    burr, time = cut.layers.burr_height, at / cut.path.feed
    moved = yielding.by_term(cut.behind, found.state, height)
    total = sum(moved.values(), np.zeros((len(at), 3)))
    lowest = axis_over_edge(free, time, total[:, 0], total[:, 1])[1]
    turn = turned_from_start(cut, at)
    return StillEdge(
        cut, at, height, found, {name: turned_by(turn, one) for name, one in moved.items()}, lowest,
        programmed_heights(free, time), np.interp(at, burr.at, burr.value),
    )  # fmt: skip


def measures(scenario: DeburringScenario, done: StillEdge) -> dict[str, float]:
    """Measures in SI, over the whole edge."""
    error, tolerance, cutter = done.error, scenario.operation.tolerance, done.cut.cutter
    found = {
        **yielding.extremes("surface_error", error, mean=True),
        **fractions(error, tolerance),
        "cutting_power_mean": float(done.rest.total[:, 3].mean()) * cutter.mill.radius * cutter.spindle_speed,
    }
    for k, axis in enumerate(known_axes(scenario.material)):
        found[f"burr_force_mean_{axis}"] = float(done.rest.layer[:, 0, k].mean())
        found[f"work_force_mean_{axis}"] = float(done.rest.layer[:, 1, k].mean())
    if not done.cut.behind:
        return found
    terms = [term for _, term in done.cut.behind]
    worst = int(np.argmax(np.abs(error)))
    found |= yielding.term_measures(done.moved, slice(None), worst)
    found |= yielding.energy_at_rest(terms, done.at, wrenches(done.rest.total), done.rest.state)
    of = scenario.operation
    return found | carriers.measures(scenario, done.cut.carriage, done.cut.behind, of.feed, limited=of.limit_feed)


def _power(done: StillEdge) -> FloatArray:
    cutter = done.cut.cutter
    return np.asarray(done.rest.total[:, 3] * cutter.mill.radius * cutter.spindle_speed)


_OVER: Over = {"w": Coordinate(lambda done: done.at, "m", "position along the edge"), "axis": "xyz"}
GROUPS = {
    "motion": Group({
        "programmed_height": Column("w", lambda done: done.programmed, "m", "lowest point of the undeflected mill above the edge"),
    }, _OVER),
    "engagement": Group({
        "burr_depth": Column("w", lambda done: done.rest.seen[:, 0], "m", "radial depth in the burr, the tool displaced"),
        "work_depth": Column("w", lambda done: done.rest.seen[:, 1], "m", "radial depth in the work, the tool displaced"),
    }, _OVER),
    "cutting": Group({
        "burr_force": Column("w axis", lambda done: done.rest.layer[:, 0], "N", "mean force of the burr on the tool"),
        "work_force": Column("w axis", lambda done: done.rest.layer[:, 1], "N", "mean force of the work on the tool"),
        "power": Column("w", _power, "W", "cutting power"),
    }, _OVER),
    "surface": Group({
        "error": Column("w", lambda done: done.error, "m", "edge error"),
        "burr_height": Column("w", lambda done: done.burr, "m", "burr height before the pass"),
    }, _OVER),
}  # fmt: skip
_COMPLIANCE = Column(
    "w twist wrench", lambda done: yielding.whole([term for _, term in done.cut.behind], done.at), "m/N",
    "compliance at the tip, process axes (rotations 1/N, 1/(N m))",
)  # fmt: skip


def stages(scenario: DeburringScenario, done: StillEdge) -> Groups:
    """Histories along the edge."""
    moved = carriers.deflections(done.moved, "the edge", "w", _OVER)
    structure = moved._replace(columns={**moved.columns, "compliance": _COMPLIANCE})
    carrier = carriers.of_carrier(done.cut.carriage, scenario.robot, done.height, done.at, done.moved)
    return {**GROUPS, "structure": structure, **carrier}


def findings(done: StillEdge) -> tuple[Finding, ...]:
    """A mill that meets nothing."""
    return () if (done.rest.seen[:, :2] > 0.0).any() else (Finding("untouched"),)


def notes(done: StillEdge) -> dict[str, str]:
    """Where the edge comes out worst, and which term has how much of it."""
    worst = int(np.argmax(np.abs(done.error)))
    parts = carriers.shares(done.moved, worst)
    return {
        "worst": f"The worst place is w = {units.show(float(done.at[worst]), 'length')} with "
        f"{units.show(float(done.error[worst]), 'small_length', 4)}"
        + (f"; off the edge: {parts}." if parts else "; nothing yields."),
        **carriers.notes(done.cut.carriage, done.height, float(done.at[worst]), done.moved, worst),
    }
