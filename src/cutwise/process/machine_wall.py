"""The wall that a pass on a machine leaves, and its error."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.frames import FloatArray
from cutwise.physics.engagement.path_sweep import swept_path
from cutwise.physics.engagement.stock import contact_patches
from cutwise.physics.surface import wall
from cutwise.process.machine_pass import MachineRun
from cutwise.process.machine_path import wall_normal
from cutwise.process.stock_moves import stock_of
from cutwise.spec.machine_scenario import MachineScenario

BoolArray = npt.NDArray[np.bool_]

_GENERATOR_POINTS = 11
_INTO = 1e-3  # of the mill radius: how far inside a wall it is asked whether the wall still stands at the end
_LEVEL = 0.5  # least horizontal part of a wall's normal for that question


class WallMap(NamedTuple):
    """Error of the finished wall."""

    height: FloatArray  # [m] above the tool point, shape (h,)
    error: FloatArray  # [m] along the normal, NaN where there is no finished wall, shape (m, h)
    flatness: float | None  # [m] of a wall that keeps its direction

    @property
    def ends(self) -> tuple[float, float]:
        """Least and greatest error [m]."""
        return float(np.nanmin(self.error)), float(np.nanmax(self.error))


def wall_map(scenario: MachineScenario, run: MachineRun) -> WallMap | None:
    """Error of the wall over the pass and over the cutting length of the tool.

    Where a program cuts a stock, walls count that are still there when it has ended, and not those that later moves
    mill away.
    """
    surface = scenario.surface
    if surface is None or not run.cell.way.cuts.any():
        return None
    height = np.linspace(0.0, surface.depth, _GENERATOR_POINTS)
    axis = run.at.rotations[:, -1, :, 2]
    normal = wall_normal(surface, run.cell.way.direction, axis)
    stands = run.cell.way.cuts & _stands_at_the_end(scenario, run, normal)
    if not stands.any():
        return None
    error = wall.wall_error(run.deviation, run.rotation, height[None, :, None] * axis[:, None, :], normal)
    flatness = None
    if surface.normal is not None and scenario.program is None:
        flatness = wall.flatness(error, run.cell.way.travel, height)
    return WallMap(height, np.where(stands[:, None], error, np.nan), flatness)


def measures(surface: WallMap) -> dict[str, float]:
    """Extremes of the error, and flatness where it has one [m]."""
    low, high = surface.ends
    found = {"wall_error_min": low, "wall_error_max": high}
    return found if surface.flatness is None else {**found, "wall_flatness": surface.flatness}


def _stands_at_the_end(scenario: MachineScenario, run: MachineRun, normal: FloatArray) -> BoolArray:
    """Whether there is material just inside the wall once all moves are made; taken to be so where it is not known."""
    way, radius = run.cell.way, 0.5 * scenario.tool.diameter
    stands = np.ones(len(normal), dtype=bool)
    flat = np.hypot(normal[:, 0], normal[:, 1])
    asked = np.flatnonzero(way.cuts & (flat > _LEVEL))
    if scenario.stock is None or scenario.program is None or way.curve is None:
        return stands
    inward = -normal[asked, :2] / flat[asked, None]
    point = way.point[asked]
    point[:, :2] += _INTO * radius * inward
    ahead = np.arctan2(inward[:, 1], inward[:, 0])
    done = np.full(len(point), 2.0 * way.curve.knots[-1])
    stock = stock_of(scenario.stock, scenario.program.zero)
    patches = contact_patches(point, ahead, done, swept_path(way.curve, radius), stock)
    straight_in = (patches[..., 0] <= 0.5 * math.pi) & (patches[..., 1] >= 0.5 * math.pi)
    stands[asked] = (straight_in & (patches[..., 2] <= 1e-9) & (patches[..., 3] > patches[..., 2])).any(axis=1)
    return stands
