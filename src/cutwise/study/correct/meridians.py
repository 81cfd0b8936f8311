"""Cells of a program in a stock in 3D: contact of tools of any shape, each with its own teeth and spindle speed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from cutwise.maths.linearc import at_blocks
from cutwise.physics.cutting.affine_limits import VALUES, Bounds, intervals_of
from cutwise.physics.cutting.flute import EdgeCoefficients
from cutwise.physics.cutting.uneven import LINEAR, tangent_coefficients
from cutwise.process.assemble_mill import spindle_limits
from cutwise.process.edges import edges_alike
from cutwise.process.stock_contact import Places, contact_at
from cutwise.process.stock_material import Box
from cutwise.process.stock_moves import FLAT
from cutwise.process.stock_plan import Planned, cutters_of
from cutwise.process.stock_setups import jobs_of, planned_of, stock_of
from cutwise.spec.cutter import Cutter
from cutwise.spec.milling import MillingScenario
from cutwise.spec.tool import EndMill
from cutwise.study.correct.cells import BoolArray, Cells, FloatArray, IntArray, cut_into_cells

OF_SPINDLE = 0.995  # of its power and torque, that a schedule takes: shorter blocks have other cells
_CHIP = 0.5  # of the feed per tooth, where Kienzle's law is touched
_THIN = 1e-5  # [m] where no feed says the chip
_INSIDE = 1e-8  # [m] of a move, its ends: at its start a rim lies on what it has swept before


class Turning(NamedTuple):
    """The tools of a program in their material: what is met at the ends of every cell of a feed move, as a run looks at moves."""

    at: IntArray  # cells of feed moves, shape (m,)
    place: IntArray  # the place where each begins; it ends at the next one, shape (m,)
    found: Places  # what is met there
    flutes: IntArray  # of the tool, shape (n,)
    spindle: FloatArray  # [rad/s], shape (n,)
    sinks: BoolArray  # it goes down in the cut, straight or on a ramp, shape (n,)
    endless: BoolArray  # its flat end has no force: it is said nowhere where it cuts (end_core), shape (n,)
    per_speed: (
        FloatArray  # feed per tooth over the speed along the path [s], 0 where the spindle is at rest, shape (n,)
    )
    caps: Mapping[
        float, Mapping[str, float]
    ]  # spindle speed: what the spindle has there, by the measures that it limits

    @property
    def chips(self) -> FloatArray:
        """Thickest chip over the feed per tooth of all cells [-], 0 without contact, shape (n,)."""
        chip = self.found.sums[:, 6]
        return self._of_all(np.maximum(chip[self.place], chip[self.place + 1]), 0.0)

    def plunge_feeds(self, force: float) -> FloatArray:
        """Feed per tooth at which the force up is a force [m], shape (n,); infinite where it does not grow."""
        own, grows = self.found.sums[:, 8], self.found.sums[:, 9]
        high = np.where(grows > 0.0, (force - own) / np.where(grows > 0.0, grows, 1.0), math.inf)
        return self._of_all(np.minimum(high[self.place], high[self.place + 1]), math.inf)

    def plunge_forces(self, speed: FloatArray) -> FloatArray:
        """Force up at speeds along the path [N], shape (n,)."""
        fed, sums = (speed * self.per_speed)[self.at], self.found.sums
        ends = [sums[place, 8] + fed * sums[place, 9] for place in (self.place, self.place + 1)]
        return self._of_all(np.maximum(*ends), 0.0)

    def _of_all(self, values: FloatArray, elsewhere: float) -> FloatArray:
        out = np.full(self.spindle.size, elsewhere)
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
            for place in (self.place[here], self.place[here] + 1):
                most, least, come = intervals_of(
                    found.loads, found.rows, found.sums, place, fed[cells], one, self.flutes[cells], own
                )
                high[cells] = np.minimum(high[cells], most)
                low[cells] = np.maximum(low[cells], least)
                value[cells] = np.fmax(value[cells], come)
        return high, low, value


class InStock(NamedTuple):
    """A program in a stock in 3D, ready to be corrected."""

    planned: Planned
    cells: Cells
    turning: Turning


def in_stock(scenario: MillingScenario, station: float) -> InStock:
    """Read the program of a stock in 3D and look at both ends of all cells of its feed moves, no longer than a station [m]."""
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
    feeds = np.isfinite(path.feed)
    at = np.flatnonzero(feeds[block])
    fed = ready.feed[block[at]] * per_speed[at]
    laws = _laws(scenario, ready, block[at], fed, shape.length[at])
    begins, ends = (np.append(True, block[at][1:] != block[at][:-1]), np.append(block[at][1:] != block[at][:-1], True))
    place = np.arange(at.size) + np.cumsum(begins) - 1  # one more than cells in every block
    along, chip = np.empty(at.size + int(begins.sum())), np.empty(at.size + int(begins.sum()))
    middle, half = shape.way[at], 0.5 * shape.length[at]
    along[place + 1], along[place] = middle + half - ends * _INSIDE, middle - half + begins * _INSIDE
    chip[place + 1], chip[place] = fed, fed
    found = contact_at(job.scenario, ready, job, before, along, chip, laws)
    cuts = np.zeros(block.size, bool)
    cuts[at] = ((found.met[place] > 0) | (found.met[place + 1] > 0)) & turns[at]
    end, direction = at_blocks(curve, block, shape.begin + shape.length)
    down = (shape.flat < FLAT) & (direction[:, 2] < 0.0)
    endless = np.array([not has_end(one) for one in cutters_of(scenario)])[ready.tool[block]]
    radius = ready.tools.cutting.radius[ready.tool[block]]
    unseen = down & feeds[block] & endless & _beside(end, radius, raw.box)
    sinks = cuts & (at_blocks(curve, block, shape.begin + 0.5 * shape.length)[1][:, 2] < -_INSIDE)
    nothing = np.zeros((block.size, 0, 4))
    cells = Cells(*shape, nothing, np.zeros((block.size, 2)), (cuts & down) | unseen, cuts)
    caps = {one: spindle_limits(scenario.drives, one) for one in np.unique(spindle[cuts]).tolist()}
    return InStock(ready, cells, Turning(at, place, found, flutes, spindle, sinks, endless, per_speed, caps))


def _beside(point: FloatArray, radius: FloatArray, box: Box) -> BoolArray:
    """Whether tips of tools of some radii are below the top of a stock and over its outline, shape (n,)."""
    (left, right), (front, back), (_, top) = box
    x, y, z = point.T
    over = (x > left - radius) & (x < right + radius) & (y > front - radius) & (y < back + radius)
    return np.asarray(over & (z < top - _INSIDE))


def has_end(tool: Cutter | EndMill) -> bool:
    """Whether the end of a tool has a force: any but a flat one without end_core."""
    pointed = isinstance(tool, Cutter) and not tool.flat_radius > 0.0
    return pointed or tool.end_core is not None


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
