"""What moves a tool beside its planned path in a stock in 3D: its feed drives, its own bending, a robot or a machine's bodies."""

from typing import NamedTuple

import numpy as np

from cutwise.loop import Cell, march
from cutwise.maths.curves import FloatArray
from cutwise.maths.frames import rotation_from_rpy
from cutwise.maths.linearc import sample
from cutwise.paths.carried import CarriedPath
from cutwise.physics.cutting.prescribed import Prescribed
from cutwise.physics.engagement.patches import SEEN, Patches
from cutwise.physics.motion.driven import driven_plane
from cutwise.physics.motion.drives import axes_of
from cutwise.physics.motion.lookahead import Plan
from cutwise.physics.motion.reference import Reference, sampled
from cutwise.physics.structure.series_compliance import translation_at
from cutwise.physics.structure.terms import Rigid
from cutwise.process import carried
from cutwise.process.assemble_mill import divided_by, feed_drives
from cutwise.process.chain_compliance import bodies_along
from cutwise.process.loops_drives import STANDSTILL
from cutwise.process.milling import MOST_SAMPLES, set_points, too_many_samples
from cutwise.process.program_path import ProgramPath
from cutwise.process.stock_loop import Progress
from cutwise.process.stock_pieces import Known
from cutwise.process.stock_plan import cutters_of
from cutwise.process.yielding import tip_of
from cutwise.spec.carrier import Standing
from cutwise.spec.milling import MillingScenario
from cutwise.spec.milling_machine import MillingMachine, drives_of

_PLACES = 200  # of the program at which robot or machine are looked at
TERMS = 10  # of a quadratic in x, y and z


class Carrier(NamedTuple):
    """How robot or machine yield, and an arm sags, over the places that the program reaches: quadratics of the place."""

    centre: FloatArray  # [m], shape (3,)
    size: FloatArray  # of the reach to each side [m], shape (3,)
    matrix: FloatArray  # compliance at the tip [m/N], shape (10, 3, 3)
    sag: FloatArray  # [m], shape (10, 3)
    missed: float  # largest error of the quadratics against the places looked at, of the largest value [-]
    names: tuple[str, ...]


def terms_at(carrier: Carrier, point: FloatArray) -> FloatArray:
    """Terms of the quadratics at points (n, 3) [m], shape (n, 10)."""
    x, y, z = ((point - carrier.centre) / carrier.size).T
    return np.column_stack([np.ones(x.size), x, y, z, x * x, y * y, z * z, x * y, x * z, y * z])


def carrier_of(scenario: MillingScenario, path: ProgramPath, force: FloatArray) -> Carrier | None:
    """Robot or bodies of a machine where the program leads them; None where nothing of the kind is there.

    ``force``: largest mean force of the cut [N], shape (3,), for which a robot chooses the angle of its tool.

    Raises
    ------
    ScenarioFault, Infeasible
        An axis is led beyond its travel, or the path is out of reach.
    """
    machine, robot = scenario.machine, scenario.robot
    if robot is None and not isinstance(machine, MillingMachine):
        return None
    places, standing = _places(path), scenario.placement or Standing()
    turn = rotation_from_rpy(*standing.rotation)
    stations = CarriedPath(
        places.at, places.point @ turn.T + np.array(standing.origin), np.repeat(turn[None], len(places.at), axis=0)
    )
    if isinstance(machine, MillingMachine):
        key = ("placement",) if scenario.placement is not None else ("program",)
        given = bodies_along(machine, None, np.array(machine.tip), stations, key, ("machine", "chain"))
        return _fitted(places.point, translation_at(given.total, 0.0), np.zeros_like(places.point), ("bodies",))
    assert robot is not None  # who else carries
    still = robot.model_copy(update={"dynamics": "static"})
    wrench = np.concatenate([force, np.zeros(3)])
    arm = carried.arm_along(still, stations, wrench, 0.0, _fastest(path))
    matrix = translation_at(arm.joints + arm.base, 0.0)
    return _fitted(places.point, matrix, arm.sag[:, :3], ("arm",))


class _Places(NamedTuple):
    at: FloatArray
    point: FloatArray


def _places(path: ProgramPath) -> _Places:
    """Places all along the path, those farthest out among them."""
    curve = path.curve
    ends = curve.knots[:: max(1, curve.count // (25 * _PLACES))]
    fine = np.unique(np.concatenate([np.linspace(0.0, curve.knots[-1], 20 * _PLACES), ends]))
    point, _, _ = sample(curve, curve.knots, fine)
    far = np.concatenate([point.argmin(axis=0), point.argmax(axis=0)])
    chosen = np.unique(np.concatenate([np.linspace(0, fine.size - 1, _PLACES).round().astype(int), far]))
    return _Places(fine[chosen], point[chosen])


def _fastest(path: ProgramPath) -> float:
    feeds = path.feed[np.isfinite(path.feed)]
    return float(feeds.max()) if feeds.size else 1e-3


def _fitted(point: FloatArray, matrix: FloatArray, sag: FloatArray, names: tuple[str, ...]) -> Carrier:
    """Least squares over the places."""
    low, high = point.min(axis=0), point.max(axis=0)
    bare = Carrier(0.5 * (low + high), np.maximum(0.5 * (high - low), 1e-3), matrix, sag, 0.0, names)
    terms, values = terms_at(bare, point), np.hstack([matrix.reshape(-1, 9), sag])
    found: FloatArray = np.asarray(np.linalg.lstsq(terms, values, rcond=1e-9)[0], dtype=np.float64)
    off = np.abs(terms @ found - values)
    error = 0.0
    for part in (slice(0, 9), slice(9, 12)):
        most = float(np.abs(values[:, part]).max())
        error = max(error, float(off[:, part].max()) / most if most > 0.0 else 0.0)
    return bare._replace(matrix=found[:, :9].reshape(TERMS, 3, 3), sag=found[:, 9:], missed=error)


def tips_of(scenario: MillingScenario) -> FloatArray:
    """Compliance of each tool at its tip, at rest, along x and y of the program [m/N], shape (tools, 3, 3)."""
    tools = cutters_of(scenario)
    found = np.zeros((len(tools), 3, 3))
    for row, tool in enumerate(tools):
        if (tip := tip_of(tool)) is not None:
            found[row] = tip.matrix[0, :3, :3]
    return found


class Driven(NamedTuple):
    """What feed drives did along a program, at the servo instants."""

    known: Known  # where they have the tool less where it should be
    force: FloatArray  # that acted on them [N], shape (n, 3)
    time: FloatArray  # [s], shape (n,)


def reference_of(scenario: MillingScenario, path: ProgramPath, plan: Plan) -> Reference:
    """Set points of the drives.

    Raises
    ------
    ScenarioFault
        There are too many of them.
    """
    drives = drives_of(scenario.machine)
    assert drives is not None
    step = drives.control.sample_time
    if not plan.profile.duration <= MOST_SAMPLES * step:
        raise too_many_samples(scenario, step, plan.profile.duration)
    return sampled(path.curve, [plan.profile], step, 0.0)


def driven(
    scenario: MillingScenario, path: ProgramPath, plan: Plan, along: FloatArray, force: FloatArray,
    progress: Progress | None = None,
) -> Driven:  # fmt: skip
    """Step the feed drives along a program, pushed by the mean force of the cut.

    Parameters
    ----------
    along : array (m,)
        Places of the path in their order [m].
    force : array (m, 3)
        Mean force on the tool there, at the speed that is planned, in program axes [N].
    """
    reference = reference_of(scenario, path, plan)
    machine = scenario.drives
    drives = feed_drives(machine, scenario.drives_key)
    step = machine.control.sample_time
    substeps = scenario.numerics.substeps
    substeps *= divided_by(step, substeps, scenario.time_step)
    pushed = np.column_stack([np.interp(reference.travelled, along, one) for one in force.T])
    pushed[reference.speed <= STANDSTILL] = 0.0
    order = set_points(reference, step, len(drives))
    motion = driven_plane(axes_of(drives, substeps), order, substeps)
    n = len(reference.time)
    engagement = Patches(np.zeros((n, 1, 4)), order.heading, motion.clock, 0.0, False, STANDSTILL)
    march(
        Cell(motion, engagement, (), Prescribed(pushed, motion.clock), Rigid(0.0)), (),
        duration=n * step, time_step=step / substeps, seen=SEEN, state=0, layers=0, contacts=1,
        starts=np.array([0, n * substeps]), progress=progress,
    )  # fmt: skip
    off = np.zeros((n, 3))
    off[:, : order.point.shape[1]] = motion.log.position - order.point
    return Driven(Known(reference.travelled, off), pushed, reference.time)
