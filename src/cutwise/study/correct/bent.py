"""What a tool that bends does to the walls of a path: the part of the error that no drive makes."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from cutwise import units
from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.bent import bent_walls
from cutwise.physics.cutting.wall import AVERAGED
from cutwise.process.loops_drives import DriveHistory
from cutwise.process.milling import Commanded
from cutwise.spec.milling import MillingScenario
from cutwise.study.correct.cells import Cells, cells_of
from cutwise.study.correct.level import stretches
from cutwise.study.correct.loads import cutting_of

_STATION = 0.25e-3  # [m] between places whose contact is looked at
_HELD = 1e-3  # [m] along a wall that does not stay, beside one that does, on which the path is shifted as at its end
_LED = 4e-3  # [m] beyond, over which the shift fades
_BESIDE = 1e-6  # [rad] of a contact that reaches to the side of the tool: it leaves a wall


class Walls(NamedTuple):
    """The places of a path at which the tool leaves a wall that stays."""

    cells: Cells  # all places of the path
    rows: npt.NDArray[np.int64]  # of those that have such a wall
    knots: FloatArray  # of the path [m]


class Bend(NamedTuple):
    """How far a tool is pushed to the right while it leaves the walls on both sides, at n servo instants."""

    push: FloatArray  # right wall, left wall; least and greatest over its height [m], less beside a wall, NaN far off; (n, 2, 2)
    there: npt.NDArray[np.bool_]  # whether the wall itself is, and not only near, shape (n, 2)


def bends(scenario: MillingScenario) -> bool:
    """Whether the force of the cut pushes the tip off its walls: a stiffness, or modes that swing tooth by tooth."""
    if scenario.in_3d or scenario.programmed:  # not covered by a shift of the path
        return False
    return scenario.numerics.force != "none" and (scenario.tool.stiffness is not None or _swings(scenario))


def _swings(scenario: MillingScenario) -> bool:
    return scenario.numerics.force == "tooth_resolved" and bool(scenario.tool.modes)


def walls_of(scenario: MillingScenario, told: Commanded, like: Walls | None = None) -> Walls | None:
    """The walls of a path, or None: nothing bends, or nothing stays. ``like``: walls of the same cut, perhaps of this path."""
    if not bends(scenario):
        return None
    knots = told.wanted.curve.knots
    if like is not None and np.array_equal(like.knots, knots):
        return like
    cells = cells_of(scenario, told.wanted, _STATION)
    rows = np.flatnonzero(cells.cuts & (_leaves(cells) & (cells.walls > 0.0)).any(axis=1))
    return Walls(cells, rows, knots) if rows.size else None


def _leaves(cells: Cells) -> npt.NDArray[np.bool_]:
    """Whether the contact of places reaches to the right, and to the left side of the tool, shape (n, 2)."""
    low, high = cells.patches[..., 0], cells.patches[..., 1]
    sides = np.stack([low < _BESIDE, high > math.pi - _BESIDE], axis=-1)
    return np.asarray((sides & (high > low)[..., None]).any(axis=1))


def _gone(cells: Cells) -> npt.NDArray[np.bool_]:
    """Places at which the tool leaves a wall that a later pass takes away, and none that stays."""
    leaves = _leaves(cells)
    return np.asarray((leaves & (cells.walls <= 0.0)).any(axis=1) & ~(leaves & (cells.walls > 0.0)).any(axis=1))


def bend_of(
    scenario: MillingScenario, told: Commanded, walls: Walls, history: DriveHistory, off: FloatArray
) -> Bend:  # fmt: skip
    """How a tool was pushed in a run; ``off``: how far to the right of the wanted path the drives had it [m], shape (n,)."""
    if _swings(scenario):
        return _recorded(told, walls, history)
    rows, cells = walls.rows, walls.cells
    some = Cells._make(one[rows] for one in cells)
    cutting = cutting_of(scenario, told.wanted, some, told.cut.spindle)
    at, first = np.unique(told.place.travelled, return_index=True)
    speed = np.nan_to_num(np.hypot(history.speed[:, 0], history.speed[:, 1]))
    feed = np.interp(some.way, at, speed[first]) * cutting.per_speed
    shift = np.interp(some.way, at, np.nan_to_num(off)[first])
    averaged = told.cut.law == AVERAGED
    found = bent_walls(some.patches, some.walls, some.heading, feed, shift, cutting.teeth, cutting.compliance, averaged)
    push = np.full((len(told.place.time), 2, 2), math.nan)
    there = np.zeros((len(told.place.time), 2), np.bool_)
    for side in range(2):
        ok = np.isfinite(found[:, side, 0])
        if ok.any():
            there[:, side], share, row = _near(told, cells, rows[ok])
            for end in range(2):
                own = np.interp(told.place.travelled, some.way[ok], found[ok, side, end])
                value = np.where(there[:, side], own, share * found[ok, side, end][row])
                push[share > 0.0, side, end] = value[share > 0.0]
    return Bend(push, there)


def _recorded(told: Commanded, walls: Walls, history: DriveHistory) -> Bend:
    """What a tip that swings left of its walls in the run, the least and the greatest of a turn."""
    turn = max(1, math.ceil(2.0 * math.pi / told.cut.spindle / told.drives[0].law.sample_time))
    size = 2 * (turn // 2) + 1
    push = np.full((len(told.place.time), 2, 2), math.nan)
    there = np.zeros((len(told.place.time), 2), np.bool_)
    for side, (low, high) in enumerate(
        ((history.left[:, 0], history.left[:, 1]), (-history.left[:, 3], -history.left[:, 2]))
    ):
        rows = walls.rows[walls.cells.walls[walls.rows, side] > 0.0]
        if not rows.size:
            continue
        least = minimum_filter1d(np.where(np.isnan(low), math.inf, low), size)
        most = maximum_filter1d(np.where(np.isnan(high), -math.inf, high), size)
        here, share, _ = _near(told, walls.cells, rows)
        there[:, side] = here & (least <= most)
        known = np.flatnonzero(there[:, side])
        if known.size:
            nearest = known[_nearest(told.place.travelled[known], told.place.travelled)]
            for end, value in enumerate((least, most)):
                push[share > 0.0, side, end] = (share * value[nearest])[share > 0.0]
    return Bend(push, there)


def _near(
    told: Commanded, cells: Cells, rows: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.bool_], FloatArray, npt.NDArray[np.int64]]:
    """Servo instants at places; how much of a shift there is made at each; which of the places is the nearest.

    All of it there, and before and behind in the same cut where nothing is left, or the tool is in air: an axis that stands is
    held by friction, and would come late. Along walls that a later pass takes away the shift fades.
    """
    at = told.place.travelled
    ends = cells.way + 0.5 * cells.length
    marked = np.zeros(ends.size, np.bool_)
    marked[rows] = True
    here = marked[np.minimum(np.searchsorted(ends, at), ends.size - 1)]
    nearest = _nearest(cells.way[rows], at)
    way = np.cumsum(np.where(_gone(cells), cells.length, 0.0))
    beyond = np.abs(np.interp(at, ends, way) - way[rows][nearest])
    share = 1.0 - np.clip((beyond - _HELD) / _LED, 0.0, 1.0)
    begins = np.array([low for low, _ in stretches(told.wanted)])
    same = np.searchsorted(begins, at, side="right") == np.searchsorted(begins, cells.way[rows][nearest], side="right")
    return here, np.where(here, 1.0, np.where(same, share, 0.0)), nearest


def _nearest(places: FloatArray, at: FloatArray) -> npt.NDArray[np.int64]:
    """Which of some places, rising, is the nearest to each of others."""
    after = np.clip(np.searchsorted(places, at), 0, places.size - 1)
    before = np.maximum(after - 1, 0)
    return np.asarray(np.where(np.abs(places[before] - at) <= np.abs(places[after] - at), before, after))


def told_of(scenario: MillingScenario, walls: Walls) -> Iterator[str]:
    """What of a path's walls is left alone, and what the law leaves out."""
    cells = walls.cells
    gone = _gone(cells)
    length = [units.show(float(cells.length[some].sum()), "length", 4) for some in (gone, walls.rows)]
    yield f"walls that stay, on {length[1]} of the path, are moved against the bend of the tool" + (
        f"; on {length[0]} a later pass takes the wall away, and nothing is moved for it" if gone.any() else ""
    )
    if not _swings(scenario) and scenario.tool.runout:
        yield "run-out is left out of the bend of the tool"
    if scenario.material.law != "linear" and not _swings(scenario):
        yield "Kienzle's law bends the tool by its slopes at half the feed per tooth"
