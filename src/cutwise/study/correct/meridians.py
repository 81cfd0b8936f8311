"""Cells of a program in a stock in 3D: contact of tools of any shape, each with its own teeth and spindle speed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from cutwise.physics.cutting.affine_limits import VALUES, Bounds, intervals_of
from cutwise.physics.cutting.flute import EdgeCoefficients
from cutwise.physics.cutting.uneven import LINEAR, tangent_coefficients
from cutwise.process.assemble_mill import spindle_limits
from cutwise.process.edges import edges_alike
from cutwise.process.stock_contact import Places, contact_at
from cutwise.process.stock_moves import FLAT
from cutwise.process.stock_plan import Planned
from cutwise.process.stock_setups import jobs_of, planned_of, stock_of
from cutwise.spec.milling import MillingScenario
from cutwise.study.correct.cells import Cells, FloatArray, IntArray, cut_into_cells

OF_SPINDLE = 0.995  # of its power and torque, that a schedule takes: shorter blocks have other cells
_CHIP = 0.5  # of the feed per tooth, where Kienzle's law is touched
_THIN = 1e-5  # [m] where no feed says the chip
_INSIDE = 1e-8  # [m] of a cell, its end


class Turning(NamedTuple):
    """The tools of a program in their material, cell by cell."""

    at: IntArray  # cells of feed moves: those that were looked at, shape (m,)
    found: Places  # what they meet, ``m`` of them
    flutes: IntArray  # of the tool, shape (n,)
    spindle: FloatArray  # [rad/s], shape (n,)
    per_speed: (
        FloatArray  # feed per tooth over the speed along the path [s], 0 where the spindle is at rest, shape (n,)
    )
    caps: Mapping[
        float, Mapping[str, float]
    ]  # spindle speed: what the spindle has there, by the measures that it limits

    @property
    def chips(self) -> FloatArray:
        """Thickest chip over the feed per tooth of all cells [-], 0 without contact, shape (n,)."""
        return self._of_all(self.found.sums[:, 6])

    def plunge_feeds(self, force: float) -> FloatArray:
        """Feed per tooth at which the force up is a force [m], shape (n,); infinite where it does not grow."""
        own, grows = self.found.sums[:, 8], self.found.sums[:, 9]
        high = np.where(grows > 0.0, (force - own) / np.where(grows > 0.0, grows, 1.0), math.inf)
        out = np.full(self.spindle.size, math.inf)
        out[self.at] = high
        return out

    def plunge_forces(self, speed: FloatArray) -> FloatArray:
        """Force up at speeds along the path [N], shape (n,)."""
        return self._of_all(self.found.sums[:, 8] + (speed * self.per_speed)[self.at] * self.found.sums[:, 9])

    def _of_all(self, values: FloatArray) -> FloatArray:
        out = np.zeros(self.spindle.size)
        out[self.at] = values
        return out

    def intervals(self, speed: FloatArray, bounds: Bounds) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Highest and lowest feeds per tooth of all cells, and what they come to at speeds along the path [m/s]."""
        n = self.spindle.size
        high, low, value = np.full((n, 7), math.inf), np.zeros((n, 2)), np.zeros((n, VALUES))
        found, fed = self.found, speed * self.per_speed
        turning = self.spindle[self.at]
        for one in np.unique(turning[turning > 0.0]).tolist():
            here = np.flatnonzero(turning == one)
            cells, caps = self.at[here], self.caps.get(one, {})
            own = bounds._replace(
                power=min(bounds.power, OF_SPINDLE * caps.get("cutting_power_max", math.inf)),
                torque=min(bounds.torque, OF_SPINDLE * caps.get("spindle_torque_max", math.inf)),
            )
            high[cells], low[cells], value[cells] = intervals_of(
                found.loads[here], found.rows[here], found.sums[here], fed[cells], one, self.flutes[cells], own
            )
        return high, low, value


class InStock(NamedTuple):
    """A program in a stock in 3D, ready to be corrected."""

    planned: Planned
    cells: Cells
    turning: Turning


def in_stock(scenario: MillingScenario, station: float) -> InStock:
    """Read the program of a stock in 3D and look at the middle of all cells of its feed moves, no longer than a station [m]."""
    job = jobs_of(scenario)[0]
    raw, before = stock_of(scenario)
    ready = planned_of(job, raw)
    path, curve = ready.path, ready.path.curve
    shape = cut_into_cells(curve, station)
    block = shape.block
    flutes = np.array([mill.flutes for mill in ready.tools.mills])[ready.tool[block]]
    spindle = np.abs(path.spindle)[block]
    turns = spindle > 0.0
    per_speed = np.where(turns, 2.0 * math.pi / (np.where(turns, spindle, 1.0) * flutes), 0.0)
    at = np.flatnonzero(np.isfinite(path.feed[block]))
    fed = ready.feed[block[at]] * per_speed[at]
    laws = _laws(scenario, ready, block[at], fed, shape.length[at])
    down = (shape.flat < FLAT) & (curve.along[block, 2] < 0.0)
    looked = shape.way + np.where(down, 0.5 * shape.length - _INSIDE, 0.0)  # a plunge where it is deepest
    found = contact_at(job.scenario, ready, job, before, looked[at], fed, laws)
    cuts = np.zeros(block.size, bool)
    cuts[at] = (found.met > 0) & turns[at]
    nothing = np.zeros((block.size, 0, 4))
    cells = Cells(*shape, nothing, np.zeros((block.size, 2)), cuts & down, cuts)
    caps = {one: spindle_limits(scenario.drives, one) for one in np.unique(spindle[cuts]).tolist()}
    return InStock(ready, cells, Turning(at, found, flutes, spindle, per_speed, caps))


def _laws(
    scenario: MillingScenario, ready: Planned, block: IntArray, fed: FloatArray, length: FloatArray
) -> list[EdgeCoefficients]:
    """The linear law of each tool; Kienzle's by its slopes at half of the feed per tooth that the tool mostly has."""
    assert scenario.material is not None
    given = edges_alike(scenario.material)
    laws = []
    for row in range(len(ready.tools.mills)):
        if given.law == LINEAR:
            laws.append(given.linear)
            continue
        mine = (ready.tool[block] == row) & (fed > 0.0)
        mean = float(np.average(fed[mine], weights=length[mine])) if mine.any() else _THIN
        laws.append(tangent_coefficients(given, _CHIP * mean))
    return laws
