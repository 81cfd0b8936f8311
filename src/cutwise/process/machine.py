"""What a pass on a machine amounts to: budget by body, wall, probability, map of the working space."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise.later import later
from cutwise.maths import chains
from cutwise.maths.frames import FloatArray
from cutwise.physics.motion import volumetric
from cutwise.physics.structure.bodies import least_convexity
from cutwise.physics.surface import budget, probability
from cutwise.physics.surface.probability import Quantiles
from cutwise.process import carried, machine_assemble, machine_wall
from cutwise.process.machine_pass import MachineCell, MachineRun, energy_balance, run_pass
from cutwise.process.machine_path import ToolPath, joints_of
from cutwise.process.machine_wall import WallMap, wall_map
from cutwise.results import Finding
from cutwise.spec.geometry_errors import COMPONENTS, LINEAR_AXES
from cutwise.spec.machine_scenario import MachineScenario

if TYPE_CHECKING:
    from scipy import interpolate
else:
    interpolate = later("scipy.interpolate")

MONTE_CARLO = frozenset({
    "deviation_p95", "deviation_random_p95", "probability_within",
    *(f"deviation_std_{axis}" for axis in "xyz"),
})  # fmt: skip
"""Measures that need samples, or the covariance beside them."""


class Chances(NamedTuple):
    """Random errors at one place of the pass."""

    place: int  # row of the pass
    deviation: FloatArray  # [m] standard deviations, shape (3,)
    shares: FloatArray  # of each body in the variance, shape (n + 1,)
    quantiles: Quantiles
    within: float | None  # probability that the length of the error stays within the tolerance, if one is given


_REPEATED = 2  # looks at the error where a table leads the tool: it changes by a ten-thousandth of the way


class VolumeMap(NamedTuple):
    """Geometric error over the working space."""

    at: tuple[FloatArray, FloatArray, FloatArray]  # commands of X, Y, Z [m], shapes (k,)
    position: FloatArray  # ideal tool point in the part [m], shape (k, k, k, 3)
    error: FloatArray  # [m], shape (k, k, k, 3)
    along: FloatArray  # [m] error along the body diagonals, shape (4, d)
    distance: FloatArray  # [m] along each diagonal, shape (4, d)
    tables_miss: float  # [m]


class MachinePass(NamedTuple):
    """A finished pass with everything that is read off it."""

    run: MachineRun
    balance: float | None
    convexity: float | None
    gain: FloatArray  # [m] change of the largest |Delta| if an element were 10 % stiffer, shape (e,)
    wall: WallMap | None
    chances: Chances | None


class MachineDone(NamedTuple):
    """Pass and map of the working space, each where it is asked for."""

    one_pass: MachinePass | None
    volume: VolumeMap | None
    infeasible: tuple[Finding, ...] = ()  # why there is no pass

    @property
    def way(self) -> ToolPath | None:
        """The pass as a robot follows it; None without one."""
        cell = None if self.one_pass is None else self.one_pass.run.cell
        return None if cell is None or cell.arm is None else cell.way


def prepare(scenario: MachineScenario) -> None:
    """Build what a run stands on, without running it.

    Raises
    ------
    ScenarioFault
        The program cannot be run on this machine, or its cut is not covered.
    """
    if scenario.has_pass:
        machine_assemble.machine_cell(scenario)


def evaluate_pass(scenario: MachineScenario) -> MachinePass:
    """Ideal and loaded pass, budget, wall and probability."""
    run = run_pass(machine_assemble.machine_cell(scenario))
    counted = run.counted
    return MachinePass(
        run,
        energy_balance(run),
        work_convexity(run.cell),
        budget.stiffening_gain(run.contributions[counted], run.deviation[counted]),
        wall_map(scenario, run),
        chances(scenario, run),
    )


def work_convexity(cell: MachineCell) -> float | None:
    """Least second difference of the cutting force's work along the pass, weights and geometric errors left out.

    None where convexity is not implied: a force that changes, a path that is not straight, rotary axes, contact laws,
    options that are not physical, a pass of which the part itself bends differently from place to place.
    """
    commands, force = cell.way.commands, cell.cut.force
    straight = np.linalg.matrix_rank(np.diff(commands, axis=0), tol=1e-9) <= 1
    onward = np.diff(cell.way.travel).min() > 0.0
    turning = np.ptp(commands[:, cell.axes.chain.kinds == chains.REVOLUTE], axis=0).any()
    constant = not np.ptp(force, axis=0).any() and force.any()
    contact = any(element.contact is not None for element in cell.elements)
    if not straight or not onward or turning or not constant or contact or cell.literal or not cell.feed_moment:
        return None
    bare = run_pass(cell._replace(weights=(), axes=cell.axes._replace(errors=(None,) * len(cell.axes.errors))))
    if cell.part is not None and np.ptp(bare.ideal[:, 2]) > 1e-12:
        return None
    work = np.einsum("mi,mi->m", force, bare.deviation)
    return least_convexity(cell.way.travel, work) if work.any() else None


def chances(scenario: MachineScenario, run: MachineRun) -> Chances | None:
    """Covariance, variance shares and quantiles in the middle of a path, or at the worst place of a program."""
    given = scenario.uncertainty
    if given is None:
        return None
    place = run.cell.way.marks[1] if scenario.program is None else run.worst
    jacobian = chains.error_jacobian(run.at, run.cell.tip)[place]
    deviation, laws = machine_assemble.scatter(scenario)
    spread = np.sqrt(np.diag(probability.covariance(jacobian, deviation)))
    random = probability.random_errors(jacobian, deviation, laws, samples=given.samples, seed=given.seed)
    together = np.linalg.norm(random + run.deviation[place], axis=1)
    within = None if given.tolerance is None else float((together <= given.tolerance).mean())
    drawn = probability.quantiles(run.deviation[place], random, 0.95)
    return Chances(place, spread, probability.variance_shares(jacobian, deviation), drawn, within)


class _Working(NamedTuple):
    """A machine over the travels of X, Y and Z, its other axes where the map has them."""

    axes: volumetric.Axes
    tables: volumetric.ErrorTables
    tip: FloatArray
    places: list[int]  # of X, Y, Z among the joints
    stand: FloatArray  # commands of all joints, shape (n,)

    @property
    def travels(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest commands of X, Y, Z [m]."""
        return self.axes.low[self.places], self.axes.high[self.places]

    def given(self, points: FloatArray) -> FloatArray:
        """Commands of all joints for those of X, Y, Z."""
        found = np.broadcast_to(self.stand, (*points.shape[:-1], len(self.stand))).copy()
        found[..., self.places] = points
        return found

    def ideal(self, points: FloatArray) -> FloatArray:
        """The tool point in the part without errors [m]."""
        frames = chains.frames(self.axes.chain, self.given(points) * self.axes.sense)
        return np.asarray(chains.tool_point(frames, self.tip))

    def error(self, points: FloatArray, added: FloatArray | None = None) -> FloatArray:
        """How far the tool is off in the part [m], where something is added to the commands [m]."""
        told = points if added is None else points + added
        found = volumetric.volumetric_error(self.axes, self.tables, self.given(np.clip(told, *self.travels)), self.tip)
        return found if added is None else found + self.ideal(told) - self.ideal(points)

    def grid(self, count: int) -> tuple[FloatArray, ...]:
        low, high = self.travels
        return tuple(np.linspace(low[k], high[k], count) for k in range(3))

    def table(self, count: int) -> tuple[tuple[FloatArray, ...], FloatArray]:
        """What is to be added to the commands at the nodes of a table [m], so that the tool is not off there.

        A table whose commands count its own motion goes the other way than the tool in the part, and axes may be askew: what
        is added are the commands that move the tool by minus its error.
        """
        nodes = self.grid(count)
        at = np.stack(np.meshgrid(*nodes, indexing="ij"), axis=-1)
        low, high = self.travels
        corners = low + np.diag(high - low)
        moved = (self.ideal(corners) - self.ideal(low)).T / (high - low)  # of the tool a metre of each command
        back = np.linalg.inv(moved)
        added = np.zeros_like(at)
        for _ in range(_REPEATED):
            added = added - self.error(at, added) @ back.T
        return nodes, added


def _working(scenario: MachineScenario) -> _Working:
    assert scenario.volume is not None
    axes, tip = machine_assemble.machine_axes(scenario), np.array(scenario.tool.tip)
    joints = joints_of(scenario.carrying)
    stand, others = np.zeros(len(axes.errors)), scenario.volume.at.given()
    for letter in COMPONENTS[3:]:
        if letter in others:
            stand[joints[letter]] = others[letter]
    return _Working(axes, volumetric.tabulate(axes), tip, [joints[letter] for letter in LINEAR_AXES], stand)


def error_table(scenario: MachineScenario, count: int) -> tuple[tuple[FloatArray, ...], FloatArray]:
    """A table against the geometric errors: commands of X, Y, Z [m], shapes (count,), and what to add to them [m],
    shape (count, count, count, 3)."""
    return _working(scenario).table(count)


def evaluate_volume(scenario: MachineScenario) -> VolumeMap | None:
    """Geometric error on a grid over the travels of X, Y and Z, and along the body diagonals."""
    if scenario.volume is None:
        return None
    work, count = _working(scenario), scenario.volume.table_points
    at = work.grid(scenario.volume.points)
    grid = np.stack(np.meshgrid(*at, indexing="ij"), axis=-1)
    lines = volumetric.diagonals(*work.travels, scenario.volume.diagonal_points)
    points = work.ideal(lines)
    table = None if count is None else interpolate.RegularGridInterpolator(*work.table(count))

    def error(given: FloatArray) -> FloatArray:
        """How far the tool is off, where the control adds a table to the commands."""
        return work.error(given, None if table is None else np.asarray(table(given)))

    return VolumeMap(
        at,  # type: ignore[arg-type]
        work.ideal(grid),
        error(grid),
        volumetric.along(points, error(lines)),
        np.linalg.norm(points - points[:, :1], axis=-1),
        volumetric.interpolation_error(work.axes, work.tables, work.tip),
    )


def measures(scenario: MachineScenario, done: MachineDone) -> dict[str, float]:
    """All measures in SI: of the pass, of the robot that runs it, of the map."""
    found = {} if done.one_pass is None else pass_measures(done.one_pass)
    arm = None if done.one_pass is None else done.one_pass.run.cell.arm
    if arm is not None and done.way is not None and scenario.robot is not None:
        found |= carried.measures(arm, scenario.robot, float(done.way.feed.max()))
    return found | ({} if done.volume is None else volume_measures(done.volume))


def pass_measures(found: MachinePass) -> dict[str, float]:
    """All measures of a pass in SI; one that does not apply is left out."""
    run, worst = found.run, found.run.worst
    measures: dict[str, float | None] = {}
    start = run.cell.way.marks[0]
    for row, where in zip(run.cell.way.marks, ("start", "middle", "end"), strict=True):
        for k, axis in enumerate("xyz"):
            measures[f"deviation_{axis}_{where}"] = run.deviation[row, k]
    measures["deviation_norm_max"] = run.size[worst]
    measures["deviation_norm_max_at"] = run.ideal[worst, 0]
    shares = budget.signed_shares(run.body[worst], run.deviation[worst])
    measures |= {f"share_{name}": share for name, share in zip(run.cell.names, shares, strict=True)}
    for k, axis in enumerate("xyz"):
        measures[f"position_start_{axis}"] = run.ideal[start, k]
    measures["linear_residual_max"] = np.linalg.norm(run.exact - run.deviation, axis=1).max()
    measures["energy_balance"] = found.balance
    measures["work_convexity"] = found.convexity
    measures["stiffening_gain_best"] = found.gain.min() if found.gain.size else None
    if found.wall is not None:
        measures |= machine_wall.measures(found.wall)
    if found.chances is not None:
        measures["probability_within"] = found.chances.within
        measures["deviation_p95"] = found.chances.quantiles.together
        measures["deviation_random_p95"] = found.chances.quantiles.random
        measures |= {f"deviation_std_{axis}": found.chances.deviation[k] for k, axis in enumerate("xyz")}
    return {name: float(value) for name, value in measures.items() if value is not None}


def volume_measures(found: VolumeMap) -> dict[str, float]:
    """All measures of a map in SI."""
    ranges = np.ptp(found.along, axis=1)
    return {
        "volumetric_error_max": float(np.linalg.norm(found.error, axis=-1).max()),
        "diagonal_range_max": float(ranges.max()),
        **{f"diagonal_range_{k + 1}": float(value) for k, value in enumerate(ranges)},
        "map_interpolation_error": found.tables_miss,
    }


def refined(scenario: MachineScenario, found: MachinePass | None, volume: VolumeMap | None) -> Mapping[str, float]:
    """The measures that depend on where pass and working space are looked at, from a spacing of a third or a half."""
    measures: dict[str, float] = {}
    given = scenario.program or scenario.path
    if found is not None and given is not None:
        finer = run_pass(machine_assemble.machine_cell(scenario, samples=3 * given.samples - 2))
        measures["deviation_norm_max"] = float(finer.size[finer.worst])
        surface = wall_map(scenario, finer)
        measures |= machine_wall.measures(surface) if surface is not None else {}
    if volume is not None and scenario.volume is not None:
        twice = scenario.volume.model_copy(update={"points": 2 * scenario.volume.points - 1})
        again = evaluate_volume(scenario.model_copy(update={"volume": twice}))
        assert again is not None
        measures["volumetric_error_max"] = volume_measures(again)["volumetric_error_max"]
    return measures
