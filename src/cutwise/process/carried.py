"""A robot along a path: the postures it takes, and what it yields by there in process axes."""

import math
from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise import units
from cutwise.later import later
from cutwise.maths.frames import FloatArray, rotation_from_rpy
from cutwise.paths.carried import CarriedPath, arc, line, placed
from cutwise.physics.motion.along import Blocked, Postures, cheapest_way, followed, joint_rates
from cutwise.physics.structure.joint_compliance import cartesian_compliance
from cutwise.physics.structure.series_compliance import carried_to, in_axes, translation_at
from cutwise.physics.structure.swings import Linked, Swinging, linked, swinging
from cutwise.physics.structure.terms import Compliance
from cutwise.process import arm_geometry
from cutwise.process.arm_geometry import Misplaced, misplaced
from cutwise.process.arm_masses import mass_matrices, masses, sag_along
from cutwise.process.posture import joint_room, posture_frames, posture_jacobian, spring_twists
from cutwise.process.postures import Arm, Candidates, candidates, tool_axes
from cutwise.process.robot_arms import base_element, robot_arm
from cutwise.process.yielding import stiffness_of
from cutwise.results import NOWHERE, Finding, Infeasible, Place, warned
from cutwise.spec.base import known
from cutwise.spec.carrier import CarriedPath as PathSpec
from cutwise.spec.carrier import CarryingRobot, Standing
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.uncertain import Fitted

if TYPE_CHECKING:
    from scipy import interpolate
else:
    interpolate = later("scipy.interpolate")

GRID = math.radians(5.0)  # between two angles of the tool that are tried
ROUNDING = 1e-9  # of a speed
_FINE = 10  # parts of an interval between stations, in each of which the feed is constant
_SLOW = 1e-9  # [m/s] a feed that every joint follows
STATIONS = 201  # of a path at which angles are tried; between them the angle is a smooth curve


class ArmAlong(NamedTuple):
    """A robot along a path."""

    path: CarriedPath  # in the base frame
    arm: Arm
    postures: Postures
    joints: FloatArray  # compliance of the joints at the tip, process axes, shape (n, 6, 6)
    base: FloatArray  # the same of the base
    sag: FloatArray  # twist of the tip without cut, by weights and geometric errors, process axes, shape (n, 6)
    wrist_sine: FloatArray  # |sin| of the wrist angle, shape (n,)
    constant: float  # what the surface yields by with the best single angle [m], or NaN where it was not asked for
    turned: float  # the same with an angle that turns along the path
    wrong: Misplaced  # by geometric errors of the arm


def path_in_base(spec: PathSpec, standing: Standing, pitch: float, *, work_on_left: bool) -> CarriedPath:
    """Stations of the path in the base frame, no farther apart than a pitch [m]."""
    axis = np.array(spec.tool_axis)
    if spec.arc is not None:
        nominal = arc(
            np.array(spec.arc.centre), spec.arc.radius, spec.arc.start, spec.arc.sweep, axis, pitch,
            work_on_left=work_on_left, follow=spec.orientation != "fixed",
        )  # fmt: skip
    else:
        ends = known(spec.line)
        nominal = line(np.array(ends.start), np.array(ends.end), axis, pitch, work_on_left=work_on_left)
    return placed(nominal, rotation_from_rpy(*standing.rotation), np.array(standing.origin))


def arm_along(
    robot: CarryingRobot, path: CarriedPath, wrench: FloatArray, height: float, feed: float, *, limited: bool = False
) -> ArmAlong:
    """The postures of a robot along a path, as the scenario chooses them, and its compliance there.

    Parameters
    ----------
    wrench : array (6,)
        Force and moment about the tip of the rigid cut in process axes [N, N m]: what a choice of the angle is made
        for.
    height : float
        Over the tip, where the surface is read [m].
    feed : float
        [m/s]
    limited : bool
        The feed is lowered where the joints cannot follow it: it rules out no posture.

    Raises
    ------
    Infeasible
        The path is out of reach, or a joint would have to turn faster than it can.
    """
    arm, _ = robot_arm(robot)
    speed = np.array(robot.joint_speed) if robot.joint_speed is not None else np.full(6, math.inf)
    try:
        postures, constant, turned = _chosen(robot, arm, path, wrench, height, speed, _SLOW if limited else feed)
    except Blocked as why:
        place = path.at[why.station]
        raise Infeasible(
            f"the robot cannot follow the path at {place * 1e3:.4g} mm of it: {why}; move the part (placement), choose "
            "another redundancy angle or posture, or take a longer arm",
            "unreachable",
            Place(position=float(place)),
        ) from None
    jacobians = np.array([posture_jacobian(arm, q) for q in postures.q])
    joints = in_axes(cartesian_compliance(jacobians, arm.stiffness), path.axes)
    base = in_axes(base_compliance(robot, path.point), path.axes)
    sine = candidates_of(arm, path, postures.angle).wrist_sine
    q = candidates_of(arm, path, postures.angle).q
    branch = np.array(
        [int(np.nanargmin(np.abs(rows - own).max(axis=1))) for rows, own in zip(q, postures.q, strict=True)]
    )
    wrong = misplaced(robot, arm, postures.q)
    sag = sag_along(robot, arm, path, postures.q, jacobians, wrong.twist)
    wrist = sine[np.arange(len(sine)), branch]
    return ArmAlong(path, arm, postures, joints, base, sag, wrist, constant, turned, wrong)


def terms_of(robot: CarryingRobot, along: ArmAlong, height: float) -> tuple[tuple[str, NamedTuple], ...]:
    """Terms of the structure that a robot adds, by name; a swinging arm takes its base along."""
    if robot.dynamics == "modal":
        return (("arm", swings_of(robot, along, height)),)
    term = linked_arm(robot, along) if robot.dynamics == "links" else Compliance(along.path.at, along.joints)
    terms = (("arm", term),)
    if robot.base_compliance is None:
        return terms
    return (*terms, ("base", Compliance(along.path.at, along.base)))


def linked_arm(robot: CarryingRobot, along: ArmAlong) -> Linked:
    """The joints of a robot with the masses of its links and tool, along its path in process axes."""
    arm, path = along.arm, along.path
    seen = np.swapaxes(jacobians_of(arm, along.postures.q), -1, -2)  # rows: one joint each
    side = np.linalg.det(path.axes)[:, None, None]
    jacobian = np.concatenate([seen[..., :3] @ path.axes, side * (seen[..., 3:] @ path.axes)], axis=-1)
    mass = mass_matrices(robot, arm, along.postures.q)
    try:
        return linked(path.at, mass, arm.stiffness, robot.damping, np.swapaxes(jacobian, -1, -2))
    except (ValueError, np.linalg.LinAlgError):
        raise ScenarioFault([Fault(("robot", "tool_mass"), "with robot.dynamics: links every joint needs something to move: "
                             "the masses given lie on the axis of one; write tool_mass and tool_centre, or "
                             "robot.links[5].inertia")]) from None  # fmt: skip


def swings_of(robot: CarryingRobot, along: ArmAlong, height: float) -> Swinging | Linked:
    """The arm with its mass: its links, or one swinging mass at a height over the tip [m]."""
    if robot.dynamics == "links":
        return linked_arm(robot, along)
    return swinging(
        along.path.at, translation_at(along.joints + along.base, height), robot.modal_mass, robot.damping
    )  # fmt: skip


def base_compliance(robot: CarryingRobot, point: FloatArray) -> FloatArray:
    """Compliance of the base at the tool points, in base axes, shape (n, 6, 6)."""
    return carried_to(base_element(robot), point)


def _zeros(path: CarriedPath) -> list[FloatArray | None]:
    """Where the angle of the tool counts from at each station: x of the base, or the feed where the tool turns with it."""
    return [axes[:, 0] if path.followed else None for axes in path.axes]


def candidates_of(arm: Arm, path: CarriedPath, angles: FloatArray) -> Candidates:
    """All solutions of the stations, with one angle of the tool for each."""
    each = zip(path.tool_axis, angles, _zeros(path), strict=True)
    poses = np.array([tool_axes(axis, angle, zero) for axis, angle, zero in each])
    return candidates(arm, path.point, poses)


def _chosen(
    robot: CarryingRobot, arm: Arm, path: CarriedPath, wrench: FloatArray, height: float, speed: FloatArray, feed: float
) -> tuple[Postures, float, float]:
    """Postures, and what the surface yields by with the best single angle and with one that turns."""
    start = None if robot.joint_angles is None else np.array(robot.joint_angles)
    if not isinstance(robot.redundancy_angle, str):
        angles = np.full(len(path.at), robot.redundancy_angle)
        found = candidates_of(arm, path, angles)
        allowed = found.within & (found.wrist_sine >= robot.singularity_margin)
        q = followed(found.q, allowed, start)
        if start is None:
            q = _stiffest_branch(arm, path, found.q, allowed, wrench, height, q)
        return Postures(q, angles), math.nan, math.nan
    tried = np.unique(np.linspace(0, len(path.at) - 1, min(len(path.at), STATIONS)).round().astype(int))
    few = CarriedPath(path.at[tried], path.point[tried], path.axes[tried], path.followed)
    angles = np.arange(-math.pi, math.pi - 0.5 * GRID, GRID)
    q, cost = _all(robot, arm, few, angles, wrench, height)
    reach = np.diff(few.at)[:, None] * speed / feed
    one = _best_constant(q, cost, reach)
    way = cheapest_way(cost, q, reach)
    picked = np.arange(len(few.at))
    turned = float(cost[picked, way[:, 0], way[:, 1]].mean())
    if robot.redundancy_angle == "best_constant":
        if one is None:
            raise Blocked(0, "no single angle of the tool leads all along; write redundancy_angle: along_path")
        angle, branch, value = one
        turning = np.full(len(path.at), angles[angle])
        first = q[0, angle, branch]
    else:
        value = one[2] if one else math.nan
        turning = interpolate.PchipInterpolator(few.at, np.unwrap(angles[way[:, 0]]))(path.at)
        first = q[0, way[0, 0], way[0, 1]]
    found = candidates_of(arm, path, turning)
    allowed = found.within & (found.wrist_sine >= robot.singularity_margin)
    return Postures(followed(found.q, allowed, first), turning), value, turned


def _stiffest_branch(
    arm: Arm, path: CarriedPath, q: FloatArray, allowed: np.ndarray, wrench: FloatArray, height: float,
    fallback: FloatArray,
) -> FloatArray:  # fmt: skip
    """Of the branches that lead all along, the one that yields least."""
    best, least = fallback, math.inf
    for branch in range(q.shape[1]):
        if not allowed[:, branch].all() or np.abs(np.diff(q[:, branch], axis=0)).max(initial=0.0) > 0.5 * math.pi:
            continue
        value = float(np.abs(_yielding(arm, path, q[:, branch], wrench, height)).mean())
        if value < least * (1.0 - 1e-9):
            best, least = q[:, branch], value
    return best


def _yielding(arm: Arm, path: CarriedPath, q: FloatArray, wrench: FloatArray, height: float) -> FloatArray:
    """Displacement normal to the surface at a height, for one posture at each station [m]."""
    jacobians = np.array([posture_jacobian(arm, row) for row in q])
    whole = cartesian_compliance(jacobians, arm.stiffness) + carried_to(arm.base, path.point)
    twist = in_axes(whole, path.axes) @ wrench
    return twist[:, 1] - twist[:, 3] * height


def _all(
    robot: CarryingRobot, arm: Arm, path: CarriedPath, angles: FloatArray, wrench: FloatArray, height: float
) -> tuple[FloatArray, FloatArray]:
    """Motor angles (n, a, b, 6) and cost (n, a, b) of every station, angle and branch."""
    count, turns = len(path.at), len(angles)
    each = zip(path.tool_axis, _zeros(path), strict=True)
    poses = np.concatenate([tool_axes(axis, angles, zero) for axis, zero in each])
    found = candidates(arm, np.repeat(path.point, turns, axis=0), poses)
    allowed = found.within & (found.wrist_sine >= robot.singularity_margin)
    cost = np.full(allowed.shape, math.inf)
    station, branch = np.nonzero(allowed)
    axes = path.axes[station // turns]
    normal = np.zeros(6)
    normal[1], normal[3] = 1.0, -height
    load = wrench if robot.objective == "wall" else normal
    jacobian = jacobians_of(arm, found.q[station, branch])
    side = np.linalg.det(axes)
    towards = np.concatenate([axes @ normal[:3], side[:, None] * (axes @ normal[3:])], axis=1)
    push = np.concatenate([axes @ load[:3], side[:, None] * (axes @ load[3:])], axis=1)
    moved = (np.einsum("mij,mi->mj", jacobian, towards) * np.einsum("mij,mi->mj", jacobian, push)) @ (
        1.0 / arm.stiffness
    )
    of_base = np.einsum("mi,mij,mj->m", towards, carried_to(arm.base, path.point[station // turns]), push)
    cost[station, branch] = np.abs(moved + of_base)
    return found.q.reshape(count, turns, -1, 6), cost.reshape(count, turns, -1)


def jacobians_of(arm: Arm, q: FloatArray) -> FloatArray:
    """Jacobians at the tip of many postures over everything that yields, in base axes, shape (m, 6, k)."""
    at = posture_frames(arm, q)
    axis = np.einsum("mkij,kj->mki", at.rotations[:, 1:], arm.chain.axes)
    tip = at.origins[:, -1] + at.rotations[:, -1] @ arm.tool_tip
    each = np.concatenate([np.cross(axis, tip[:, None] - at.origins[:, 1:]), axis], axis=2).swapaxes(1, 2)
    springs = spring_twists(arm.springs, at.rotations, at.origins, tip)
    return np.concatenate([each @ arm.drives.elastic, springs], axis=2)


def _best_constant(q: FloatArray, cost: FloatArray, reach: FloatArray) -> tuple[int, int, float] | None:
    """The single angle and branch with the least mean cost that leads all along; None without one."""
    slow = (np.abs(np.diff(q, axis=0)) <= reach[:, None, None]).all(axis=(0, 3))
    mean = np.where(slow, cost.mean(axis=0), math.inf)
    if not np.isfinite(mean).any():
        return None
    angle, branch = np.unravel_index(int(np.argmin(mean)), mean.shape)
    return int(angle), int(branch), float(mean[angle, branch])


class Slowdown(NamedTuple):
    """How a programmed motion is slowed down: instants, and its own time there."""

    at: FloatArray  # [s], shape (m,)
    pace: FloatArray  # [s], shape (m,)


def feeds_along(along: ArmAlong, robot: CarryingRobot, feed: float) -> FloatArray:
    r"""Feed that the joints can follow at the stations, no more than the one asked for [m/s], shape (n,).

    .. math:: v \le \dot q_{max} / |q'|, \quad v \le \sqrt{\ddot q_{max} / |q''|}, \quad
              |v v'| \le \ddot q_{max} / |q'|

    for every joint; the last two where accelerations are given, changes of speed by looking ahead and back.
    """
    at = along.path.at
    speed = np.array(robot.joint_speed)
    rates = np.abs(joint_rates(along.postures.q, at))
    with np.errstate(divide="ignore"):
        possible = (speed / rates).min(axis=1)
        found = np.minimum(np.append(possible, possible[-1]), np.insert(possible, 0, possible[0]))
        found = np.minimum(found, feed)
        if robot.joint_acceleration is None:
            return np.asarray(found)
        most = np.array(robot.joint_acceleration)
        bend = np.abs(np.diff(rates, axis=0)) / (0.5 * (at[2:] - at[:-2]))[:, None]
        found[1:-1] = np.minimum(found[1:-1], np.sqrt((most / bend).min(axis=1)))
        gain = 2.0 * np.diff(at) * (most / rates).min(axis=1)  # of the speed squared
    for k in range(1, len(found)):
        found[k] = min(found[k], math.sqrt(found[k - 1] ** 2 + gain[k - 1]))
    for k in range(len(found) - 2, -1, -1):
        found[k] = min(found[k], math.sqrt(found[k + 1] ** 2 + gain[k]))
    return np.asarray(found)


def pace_of(at: FloatArray, feeds: FloatArray, feed: float) -> Slowdown:
    """The pace at which a motion programmed at a constant feed [m/s] is run with other feeds at some places [m]."""
    fine = np.unique(np.concatenate([np.linspace(a, b, _FINE + 1) for a, b in pairwise(at)]))
    middle = np.interp(0.5 * (fine[1:] + fine[:-1]), at, feeds)
    time = np.concatenate([[0.0], np.cumsum(np.diff(fine) / middle)])
    return Slowdown(time, fine / feed)


def slowed(along: ArmAlong, robot: CarryingRobot, feed: float) -> Slowdown:
    """The pace of a motion programmed at a feed [m/s] where the joints have to follow it."""
    return pace_of(along.path.at, feeds_along(along, robot, feed), feed)


def sag_at(along: ArmAlong, height: float) -> FloatArray:
    """Sag of the tool's axis at a height over the tip, process axes [m], shape (n, 3)."""
    twist = along.sag
    return np.column_stack([twist[:, 0] + twist[:, 4] * height, twist[:, 1] - twist[:, 3] * height, twist[:, 2]])


def too_fast(found: Mapping[str, float], feed: float | None, said: str = "operation.feed") -> tuple[Finding, ...]:
    """That the joints cannot follow the feed [m/s], if they cannot."""
    if feed is None or found.get("joint_speed_margin", 1.0) >= -ROUNDING:
        return ()
    possible = found["feed_possible_min"]
    words = (
        f"the joints follow {units.show(possible, 'speed')} at most, {said} is {units.show(feed, 'speed')}: reduce it, or "
        "move the part (placement)"
    )
    return (Finding("too_fast", NOWHERE, feed, possible, "speed", "joint_speed_margin", words=words, cannot=True),)


def measures(along: ArmAlong, robot: CarryingRobot, feed: float, *, limited: bool = False) -> dict[str, float]:
    """What the postures mean: room of the joints and the wrist, speeds, stiffness normal to the surface.

    ``limited``: the feed [m/s] is lowered where the joints cannot follow it.
    """
    each = np.abs(joint_rates(along.postures.q, along.path.at))
    rates = each.max(axis=0)
    room = joint_room(along.arm, along.postures.q)
    normal = (along.joints + along.base)[:, 1, 1]
    found = {
        "joint_limit_margin": float(room.min()),
        "wrist_margin": float(along.wrist_sine.min()),
        "redundancy_angle_min": float(along.postures.angle.min()),
        "redundancy_angle_max": float(along.postures.angle.max()),
        **stiffness_of(normal),
    }
    if robot.sag != "ignored" and masses(robot):
        found["sag_change_max"] = float(np.linalg.norm(along.sag[:, :3] - along.sag[0, :3], axis=1).max())
    if robot.joint_speed is not None:
        with np.errstate(divide="ignore"):
            possible = np.min(np.array(robot.joint_speed) / rates)
        found["feed_possible_min"] = float(possible) if math.isfinite(possible) else feed
        found["joint_speed_margin"] = float(1.0 - feed / possible)
        if limited:
            feeds = feeds_along(along, robot, feed)
            used = (0.5 * (feeds[1:] + feeds[:-1]))[:, None] * each / np.array(robot.joint_speed)
            found["joint_speed_margin"] = float(1.0 - used.max())
    return found


def warnings(
    robot: CarryingRobot, arms: Iterable[ArmAlong] = (), measured: Fitted | None = None
) -> tuple[Finding, ...]:
    """What a user has to know about a robot along its paths."""
    said = [one for along in arms for one in arm_geometry.warnings(robot, along.wrong, measured)]
    if not robot.joint_speed:
        words = "robot.joint_speed is not given: whether the joints can follow the feed was not looked at"
        said.append(warned("not_looked_at", words, where=Place("robot.joint_speed")))
    if robot.sag != "ignored" and not masses(robot):
        words = "robot.sag: no weight of tool or links is given (robot.tool_mass, robot.links): the sag is left out"
        said.append(warned("left_out", words, where=Place("robot.sag")))
    return tuple(dict.fromkeys(said))
