"""What every cell of a path allows, and what it comes to: from the limits of a correction to highest speeds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from cutwise.physics.cutting.affine_limits import (
    CHIP,
    MEAN,
    MOST_ERROR,
    PEAK,
    POWER,
    REMOVAL,
    TORQUE,
    WALL,
    Bounds,
)
from cutwise.physics.cutting.discs import discs
from cutwise.physics.cutting.feed_limits import Teeth, feed_intervals
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.plunge import plunge_feed, plunge_force
from cutwise.physics.cutting.uneven import LINEAR, even_edges, tangent_coefficients
from cutwise.physics.cutting.wall import DISCS, FLUTES
from cutwise.physics.motion.lookahead import highest_feeds
from cutwise.process.assemble_mill import motion_limits
from cutwise.process.edges import edges_alike
from cutwise.process.program_path import ProgramPath
from cutwise.spec.milling import MillingScenario
from cutwise.study.correct.cells import Cells, FloatArray
from cutwise.study.correct.meridians import Turning

_DISCS = 20  # heights at which a wall is read, where the scenario names no number of discs
_ON_ARCS = 0.8  # of the acceleration that turning may take: what is left makes the changes of speed

COLUMN: Mapping[str, int] = {
    "force_xy_peak": PEAK, "force_xy_mean_max": MEAN, "cutting_power_max": POWER, "spindle_torque_max": TORQUE,
    "chip_thickness_max": CHIP, "wall_error_min": WALL, "wall_error_max": MOST_ERROR, "removal_rate_max": REMOVAL,
}  # fmt: skip
"""Measures that follow from contact and feed alone, with their columns of values."""
BINDS: tuple[tuple[str, int], ...] = (
    ("force_xy_peak", PEAK), ("force_xy_mean_max", MEAN), ("cutting_power_max", POWER), ("spindle_torque_max", TORQUE),
    ("chip_thickness_max", CHIP), ("wall_error", WALL), ("removal_rate_max", REMOVAL),
)  # fmt: skip
"""What can bind at a place, in the order in which one of several is named, with the columns of highest feeds."""
PLUNGE = "plunge_force_max"
NAMES = (*(name for name, _ in BINDS), PLUNGE, "cost", "arc", "machine")


class Cutting(NamedTuple):
    """The tool in its material, cell by cell."""

    teeth: Teeth
    compliance: FloatArray  # of the tip [m/N], shape (2, 2)
    spindle: FloatArray  # [rad/s], shape (n,)
    per_speed: FloatArray  # feed per tooth in the plane over the speed along the path [s], shape (n,)


class Allowed(NamedTuple):
    """What the cells allow."""

    each: FloatArray  # highest speed by each of NAMES [m/s], shape (n, 11)
    own: FloatArray  # the least of them, shape (n,)
    least: FloatArray  # lowest speed (rubbing, a wall that is to be cut enough), 0: none, shape (n,)
    helpless: FloatArray  # number in NAMES of a limit that no feed keeps, -1: none, shape (n,)


def tip_compliance(scenario: MillingScenario) -> FloatArray:
    """Static compliance of the tip in x and y [m/N]: of its stiffness, or the sum of its modes; in 3D no wall has an error."""
    tool = scenario.tool
    if scenario.in_3d:
        return np.zeros((2, 2))
    if tool.stiffness is not None:
        return np.eye(2) / tool.stiffness
    out = np.zeros((2, 2))
    for mode in tool.modes:
        axis = "xy".index(mode.direction)
        out[axis, axis] += 1.0 / mode.stiffness
    return out


def cutting_of(scenario: MillingScenario, path: ProgramPath, cells: Cells, spindle: float) -> Cutting:
    """Mill, material and tip for all cells; Kienzle's law by its slopes at the chip that the program has."""
    tool = scenario.tool
    given = edges_alike(scenario.material)
    mill = Mill(0.5 * tool.diameter, tool.flutes, tool.helix)
    turning = np.full(cells.size, spindle)
    per_speed = cells.flat * 2.0 * math.pi / (turning * mill.flutes)
    linear = given.linear
    if given.law != LINEAR:
        fed = np.where(np.isfinite(path.feed[cells.block]), path.feed[cells.block], 0.0) * per_speed
        met = cells.cuts & (fed > 0.0)
        linear = tangent_coefficients(given, 0.5 * float(fed[met].mean()) if met.any() else 1e-5)
    shear = even_edges(linear._replace(K_te=0.0, K_re=0.0, K_ae=0.0))
    edge = even_edges(EdgeCoefficients(0.0, 0.0, 0.0, linear.K_te, linear.K_re, linear.K_ae))
    depth = float(cells.patches[..., 3].max(initial=0.0)) or 1e-3
    count = scenario.numerics.discs or _DISCS
    law = DISCS if scenario.numerics.discs else FLUTES
    teeth = Teeth(law, mill, discs(mill.radius, tool.helix, depth, tool.flutes, count), shear, edge)
    return Cutting(teeth, tip_compliance(scenario), turning, per_speed)


def values_at(cells: Cells, cutting: Cutting | Turning, speed: FloatArray) -> FloatArray:
    """What every cell comes to at a speed along the path [m/s], columns of :mod:`feed_limits`, shape (n, 9)."""
    return _intervals(cells, cutting, speed, {})[2]


def greatest(cells: Cells, values: FloatArray) -> dict[str, float]:
    """The measures of :data:`COLUMN` over all cells that cut; walls where one stays and the tool yields."""
    cuts = cells.cuts
    if not cuts.any():
        return {}
    found = {name: float(values[cuts, column].max()) for name, column in COLUMN.items() if not name.startswith("wall")}
    if np.isfinite(values[:, WALL]).any():
        found["wall_error_min"] = float(np.nanmin(values[:, WALL]))
        found["wall_error_max"] = float(np.nanmax(values[:, MOST_ERROR]))
    return found


def allowed(
    scenario: MillingScenario, path: ProgramPath, cells: Cells, cutting: Cutting | Turning, limits: Mapping[str, float],
    cheapest: float = math.inf,
) -> Allowed:  # fmt: skip
    """Highest and lowest speeds of all cells under limits [SI]; ``cheapest``: feed per tooth above which a part is dearer [m]."""
    still = np.zeros(cells.size)
    high, low, _ = _intervals(cells, cutting, still, limits)
    level = cutting.per_speed > 0.0
    per = np.where(level, cutting.per_speed, 1.0)[:, None]
    each = np.full((cells.size, len(NAMES)), math.inf)
    for place, (_, column) in enumerate(BINDS):
        each[:, place] = np.where(level, high[:, column] / per[:, 0], math.inf)
    most = limits.get(PLUNGE)
    if most is not None:
        fed = _plunge_feeds(scenario, cutting, most) / per[:, 0]
        down = cutting.sinks if isinstance(cutting, Turning) else cells.plunges
        each[:, NAMES.index(PLUNGE)] = np.where(down, fed, math.inf)
    each[:, NAMES.index("cost")] = np.where(level & cells.cuts, cheapest / per[:, 0], math.inf)
    each[:, -2] = _arcs(scenario, path)[cells.block]
    each[:, -1] = quickest(scenario, path)[cells.block]
    held = each[:, : len(BINDS) + 1]
    helpless = np.where((held <= 0.0).any(axis=1), np.argmin(held > 0.0, axis=1), -1)
    least = np.where(level, low.max(axis=1) / per[:, 0], 0.0)
    least[~cells.cuts] = 0.0
    return Allowed(each, each.min(axis=1), least, helpless)


def quickest(scenario: MillingScenario, path: ProgramPath) -> FloatArray:
    """How fast the machine can run each block [m/s], shape (blocks,)."""
    limits, axes = motion_limits(scenario.drives)
    return highest_feeds(path.curve, np.full(path.curve.count, 1e9), limits, axes)


def _plunge_feeds(scenario: MillingScenario, cutting: Cutting | Turning, force: float) -> FloatArray:
    """Feed down per tooth at which plunges come to a force, over what :attr:`Cutting.per_speed` has of a speed [m], shape (n,)."""
    if isinstance(cutting, Turning):
        return cutting.plunge_feeds(force)
    core = scenario.tool.end_core
    assert core is not None  # or it is refused
    fed = plunge_feed(force, core, cutting.teeth.mill, _bottom(cutting.teeth))
    down = 2.0 * math.pi / (cutting.spindle * cutting.teeth.mill.flutes)  # of the speed: the plane has nothing of it
    return np.asarray(fed / down * np.where(cutting.per_speed > 0.0, cutting.per_speed, 1.0))


def plunge_forces(
    scenario: MillingScenario, cells: Cells, cutting: Cutting | Turning, speed: FloatArray
) -> float | None:
    """Largest force of plunges at speeds along the path [N]; None without any, or where the bottom has none."""
    if not cells.plunges.any():
        return None
    if isinstance(cutting, Turning):
        return float(cutting.plunge_forces(speed)[cells.plunges].max())
    core = scenario.tool.end_core
    if core is None:
        return None
    fed = (speed * 2.0 * math.pi / (cutting.spindle * cutting.teeth.mill.flutes))[cells.plunges]
    return float(plunge_force(float(fed.max()), core, cutting.teeth.mill, _bottom(cutting.teeth)))


def _bottom(teeth: Teeth) -> EdgeCoefficients:
    """The coefficients of shearing and edges as one."""
    shear, edge = teeth.shear.linear, teeth.edge.linear
    return EdgeCoefficients(shear.K_tc, shear.K_rc, shear.K_ac, edge.K_te, edge.K_re, edge.K_ae)


def chips_of(cells: Cells, cutting: Cutting | Turning) -> FloatArray:
    """Thickest chip of every cell over its feed per tooth [1], shape (n,): 0 without contact."""
    return cutting.chips if isinstance(cutting, Turning) else largest_sines(cells.patches)


def largest_sines(patches: FloatArray) -> FloatArray:
    """Thickest chip of every contact over its feed per tooth [1], shape (n,): 0 without contact."""
    low, high = patches[..., 0], patches[..., 1]
    across = (low <= 0.5 * math.pi) & (high >= 0.5 * math.pi)
    sine = np.where(across, 1.0, np.maximum(np.sin(low), np.sin(high)))
    return np.asarray(np.where(high > low, sine, 0.0).max(axis=1))


def binding(each: FloatArray) -> np.ndarray:
    """Which of NAMES sets the speed of each cell; of those within 1e-4 the first, shape (n,)."""
    return np.argmax(each <= each.min(axis=1)[:, None] * (1.0 + 1e-4), axis=1)


def _arcs(scenario: MillingScenario, path: ProgramPath) -> FloatArray:
    """Speed on each block that leaves acceleration along the path and keeps the jerk [m/s]."""
    limits = scenario.drives.limits
    bend = np.maximum(path.curve.curvature, path.curve.share**2 / path.curve.radius)
    bent = bend > 0.0
    radius = 1.0 / np.where(bent, bend, 1.0)
    quick = np.minimum(np.sqrt(_ON_ARCS * limits.acceleration * radius), np.cbrt(limits.jerk * radius**2))
    blend = bend > bend_of_origin(path) * (
        1.0 + 1e-9
    )  # of a blend the look-ahead takes care: no F is meant for it alone
    return np.where(bent & ~blend, quick, math.inf)


def bend_of_origin(path: ProgramPath) -> FloatArray:
    """Curvature of the programmed block that each driven one came from [1/m], shape (blocks,)."""
    told = path.programmed
    return np.asarray((told.share**2 / told.radius)[path.origin])


def _intervals(
    cells: Cells, cutting: Cutting | Turning, speed: FloatArray, limits: Mapping[str, float]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    def most(name: str) -> float:
        return limits.get(name, math.inf)

    bounds = Bounds(
        most("force_xy_peak"), most("force_xy_mean_max"), most("cutting_power_max"), most("spindle_torque_max"),
        most("chip_thickness_max"), limits.get("chip_thickness_min", 0.0), limits.get("wall_error_min", -math.inf),
        most("wall_error_max"), most("removal_rate_max"),
    )  # fmt: skip
    if isinstance(cutting, Turning):
        high, low, value = cutting.intervals(speed, bounds)
        value[:, [WALL, MOST_ERROR]] = math.nan
        return high, low, value
    walls = cells.walls if cutting.compliance.any() else np.zeros_like(cells.walls)
    return feed_intervals(
        cells.patches, walls, cells.heading, speed * cutting.per_speed, cutting.spindle, cutting.teeth, cutting.compliance,
        bounds,
    )  # fmt: skip
