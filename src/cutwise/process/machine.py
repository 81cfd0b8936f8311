"""What a pass on a machine amounts to: budget by body, wall, probability, map of the working space."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from cutwise.maths import chains
from cutwise.maths.frames import FloatArray
from cutwise.physics.motion import volumetric
from cutwise.physics.structure.bodies import least_convexity
from cutwise.physics.surface import budget, probability, wall
from cutwise.physics.surface.probability import Quantiles
from cutwise.process import machine_assemble
from cutwise.process.machine_pass import MachineCell, MachineRun, energy_balance, run_pass
from cutwise.spec.geometry_errors import COMPONENTS, LINEAR_AXES
from cutwise.spec.machine_scenario import MachineScenario

_GENERATOR_POINTS = 11


class WallMap(NamedTuple):
    """Error of the finished wall."""

    height: FloatArray  # [m] above the tool point, shape (h,)
    error: FloatArray  # [m] along the normal, shape (m, h)
    flatness: float  # [m]


class Chances(NamedTuple):
    """Random errors in the middle of the pass."""

    deviation: FloatArray  # [m] standard deviations, shape (3,)
    shares: FloatArray  # of each body in the variance, shape (n + 1,)
    quantiles: Quantiles


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
    ends: MachineRun  # start, middle and end only
    balance: float | None
    convexity: float | None
    gain: FloatArray  # [m] change of |Delta| at the worst place if an element were 10 % stiffer, shape (e,)
    wall: WallMap | None
    chances: Chances | None


def evaluate_pass(scenario: MachineScenario) -> MachinePass:
    """Ideal and loaded pass, budget, wall and probability."""
    run = run_pass(machine_assemble.machine_cell(scenario))
    ends = run_pass(machine_assemble.machine_cell(scenario, samples=3))
    worst = run.worst
    return MachinePass(
        run,
        ends,
        energy_balance(run),
        work_convexity(run.cell),
        budget.stiffening_gain(run.contributions[worst], run.deviation[worst]),
        wall_map(scenario, run),
        chances(scenario, ends),
    )


def work_convexity(cell: MachineCell) -> float | None:
    """Least second difference of the cutting force's work along the pass, weights and geometric errors left out.

    None where convexity is not implied: a force that changes, a path that is not straight, rotary axes, contact laws,
    options that are not physical, a pass of which the part itself bends differently from place to place.
    """
    straight = np.linalg.matrix_rank(np.diff(cell.commands, axis=0), tol=1e-9) <= 1
    turning = np.ptp(cell.commands[:, cell.axes.chain.kinds == chains.REVOLUTE], axis=0).any()
    constant = not np.ptp(cell.force, axis=0).any() and cell.force.any()
    contact = any(element.contact is not None for element in cell.elements)
    if not straight or turning or not constant or contact or cell.literal or not cell.feed_moment:
        return None
    bare = run_pass(cell._replace(weights=(), axes=cell.axes._replace(errors=(None,) * len(cell.axes.errors))))
    if cell.part is not None and np.ptp(bare.ideal[:, 2]) > 1e-12:
        return None
    work = np.einsum("mi,mi->m", cell.force, bare.deviation)
    return least_convexity(work) if work.any() else None


def wall_map(scenario: MachineScenario, run: MachineRun) -> WallMap | None:
    """Error of the wall over the pass and over the cutting length of the tool."""
    if scenario.surface is None:
        return None
    height = np.linspace(0.0, scenario.surface.depth, _GENERATOR_POINTS)
    normal = np.array(scenario.surface.normal) / np.linalg.norm(scenario.surface.normal)
    axis = run.at.rotations[0, -1, :, 2]
    error = wall.wall_error(run.deviation, run.rotation, height[:, None] * axis, normal)
    return WallMap(height, error, wall.flatness(error, run.cell.travel, height))


def chances(scenario: MachineScenario, ends: MachineRun) -> Chances | None:
    """Covariance, variance shares and quantiles in the middle of the pass."""
    given = scenario.uncertainty
    if given is None:
        return None
    middle = len(ends.deviation) // 2
    jacobian = chains.error_jacobian(ends.at, ends.cell.tip)[middle]
    deviation, laws = machine_assemble.scatter(scenario)
    spread = np.sqrt(np.diag(probability.covariance(jacobian, deviation)))
    drawn = probability.quantiles(
        ends.deviation[middle], jacobian, deviation, laws, probability=0.95, samples=given.samples, seed=given.seed
    )
    return Chances(spread, probability.variance_shares(jacobian, deviation), drawn)


def evaluate_volume(scenario: MachineScenario) -> VolumeMap | None:
    """Geometric error on a grid over the travels of X, Y and Z, and along the body diagonals."""
    if scenario.volume is None:
        return None
    axes, tip = machine_assemble.machine_axes(scenario), np.array(scenario.tool.tip)
    joints = machine_assemble.joints_of(scenario.machine)
    places = [joints[letter] for letter in LINEAR_AXES]
    low, high = axes.low[places], axes.high[places]
    others = scenario.volume.at.given()

    def commands(points: FloatArray) -> FloatArray:
        given = np.zeros((*points.shape[:-1], len(axes.errors)))
        for letter in COMPONENTS[3:]:
            if letter in others:
                given[..., joints[letter]] = others[letter]
        given[..., places] = points
        return given

    at = tuple(np.linspace(low[k], high[k], scenario.volume.points) for k in range(3))
    grid = commands(np.stack(np.meshgrid(*at, indexing="ij"), axis=-1))
    tables = volumetric.tabulate(axes)
    ideal = chains.tool_point(chains.frames(axes.chain, grid * axes.sense), tip)
    lines = commands(volumetric.diagonals(low, high, scenario.volume.diagonal_points))
    points = chains.tool_point(chains.frames(axes.chain, lines * axes.sense), tip)
    return VolumeMap(
        at,  # type: ignore[arg-type]
        ideal,
        volumetric.volumetric_error(axes, tables, grid, tip),
        volumetric.along(points, volumetric.volumetric_error(axes, tables, lines, tip)),
        np.linalg.norm(points - points[:, :1], axis=-1),
        volumetric.interpolation_error(axes, tables, tip),
    )


def pass_measures(found: MachinePass) -> dict[str, float]:
    """All measures of a pass in SI; one that does not apply is left out."""
    run, worst = found.run, found.run.worst
    measures: dict[str, float | None] = {}
    for row, where in enumerate(("start", "middle", "end")):
        for k, axis in enumerate("xyz"):
            measures[f"deviation_{axis}_{where}"] = found.ends.deviation[row, k]
    measures["deviation_norm_max"] = run.size[worst]
    measures["deviation_norm_max_at"] = run.ideal[worst, 0]
    shares = budget.signed_shares(run.body[worst], run.deviation[worst])
    measures |= {f"share_{name}": share for name, share in zip(run.cell.names, shares, strict=True)}
    for k, axis in enumerate("xyz"):
        measures[f"position_start_{axis}"] = run.ideal[0, k]
    measures["linear_residual_max"] = np.linalg.norm(run.exact - run.deviation, axis=1).max()
    measures["energy_balance"] = found.balance
    measures["work_convexity"] = found.convexity
    measures["stiffening_gain_best"] = found.gain.min() if found.gain.size else None
    if found.wall is not None:
        measures["wall_error_min"], measures["wall_error_max"] = found.wall.error.min(), found.wall.error.max()
        measures["wall_flatness"] = found.wall.flatness
    if found.chances is not None:
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


def halved_spacing(scenario: MachineScenario, found: MachinePass) -> Mapping[str, float]:
    """The measures that depend on where the pass is sampled, with twice as many points."""
    finer = run_pass(machine_assemble.machine_cell(scenario, samples=2 * len(found.run.cell.travel) - 1))
    measures = {"deviation_norm_max": float(finer.size.max())}
    surface = wall_map(scenario, finer)
    if surface is not None:
        measures |= {
            "wall_error_min": float(surface.error.min()),
            "wall_error_max": float(surface.error.max()),
            "wall_flatness": surface.flatness,
        }
    return measures
