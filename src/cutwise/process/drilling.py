"""Drilling with a robot or on a machine: from the scenario to postures, forces and holes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise.later import later
from cutwise.maths.frames import FloatArray
from cutwise.physics.cutting.drill import (
    DrillPoint,
    ZoneLaw,
    ZoneStress,
    stress_at_feed,
)
from cutwise.physics.cutting.drill_elements import LipElements, oblique_elements
from cutwise.physics.structure.joint_compliance import worst_skating
from cutwise.process.drill_profile import DepthProfile, depth_profile, no_elements
from cutwise.process.hole_balance import DrillCycle
from cutwise.process.loops_drilling import (
    ArmDynamics,
    HoleOutcome,
    arm_dynamics,
    bodies_at_once,
    cycle_time,
    drill_hole,
    hole_error,
    modes,
    on_part,
)
from cutwise.process.posture import Posture, Reach, least_missing, posture_at, reach, turned_towards
from cutwise.process.posture_search import (
    PoseTarget,
    Score,
    axial_compliance,
    place_part,
    predicted,
    scan,
    search,
    skating_on_slope,
)
from cutwise.process.postures import Arm, candidates, tool_axes
from cutwise.process.robot_arms import robot_arm
from cutwise.spec.drilling import Drill, DrillingScenario, Hole, Placement

if TYPE_CHECKING:
    from cutwise.process import drilling_machine
else:
    drilling_machine = later("cutwise.process.drilling_machine")

_ROWS = 2000  # of the history that is kept
_CHECKED = 8  # redundancy angles at which a hole is looked at once more before it is called out of reach
_COARSE = math.radians(4.0)  # step of the redundancy angle while places of the part are compared


class Led(NamedTuple):
    """Where the tool is led instead of the hole, in tool axes."""

    shift: tuple[float, float]  # [m]
    tilt: tuple[float, float]  # of the drill axis towards x and y [rad]


NOT_LED = Led((0.0, 0.0), (0.0, 0.0))


class DrillCell(NamedTuple):
    """Everything that takes part in drilling, as bare SI records."""

    arm: Arm | None  # None: a machine drills
    point: DrillPoint
    law: ZoneLaw
    stress: ZoneStress
    elements: LipElements
    profile: DepthProfile
    cycle: DrillCycle
    slope_direction: float  # [rad] from redundancy angle zero
    side: FloatArray  # side force over thrust while the point enters, axes of the slope, shape (h, 2); flat: no rows
    modal_mass: float  # [kg]
    damping: float
    with_torque: bool
    not_spherical: str  # why there is no closed-form inverse kinematics; empty if there is
    part_stiffness: float  # [N/m] of the part along the drill axis; infinite: rigid


class DrilledHole(NamedTuple):
    """One hole of the run."""

    target: PoseTarget
    posture: Posture | None  # None: it cannot be drilled
    reach: Reach
    singular: bool  # within the limits, but only too close to a singularity
    outcome: HoleOutcome | None
    history: FloatArray  # shape (rows, 12)
    frequencies: FloatArray  # [Hz] of the arm in this posture, shape (3,)
    led: Led = NOT_LED  # elsewhere than the hole is wanted


class DrillRun(NamedTuple):
    """A finished run."""

    cell: DrillCell
    holes: tuple[DrilledHole, ...]
    shift: FloatArray  # [m] where the part was put, shape (3,)
    places: tuple[tuple[FloatArray, float], ...]  # every place that was tried, with its worst hole


def drill_cell(scenario: DrillingScenario) -> DrillCell:
    """Specifications become records."""
    tool, material, contact, feed = scenario.tool, scenario.material, scenario.contact, scenario.operation.feed_per_rev
    point = drill_point(tool)
    law = ZoneLaw(
        material.rake_friction, tool.rake, material.chisel_factor, material.chisel_friction, tool.chisel_rake,
        material.margin_stress,
    )  # fmt: skip
    stress = stress_at_feed(law, material.k_c11, material.m_c, point, feed)
    elements = no_elements()
    if tool.lip_model == "oblique":
        elements = oblique_elements(point, law, stress.specific, scenario.numerics.lip_elements)
    profile = depth_profile(
        point, stress, elements, margin_stress=material.margin_stress, feed=feed, thickness=scenario.part.thickness,
        inclination=scenario.part.inclination, azimuths=scenario.numerics.azimuths,
    )  # fmt: skip
    cycle = DrillCycle(
        feed, scenario.operation.spindle_speed / (2.0 * math.pi), scenario.part.thickness, tool.cone_height,
        material.m_c, contact.friction, contact.wall_stiffness, contact.wander_length,
    )  # fmt: skip
    robot = scenario.robot
    arm, reason = robot_arm(robot) if robot is not None else (None, "")
    return DrillCell(
        arm, point, law, stress, elements, profile, cycle, scenario.part.slope_direction,
        side_over_thrust(profile, tool.cone_height), robot.modal_mass if robot is not None else 0.0,
        robot.damping if robot is not None else 0.0, contact.drill_torque_on_arm, reason,
        scenario.part.stiffness or math.inf,
    )  # fmt: skip


def drill_point(tool: Drill) -> DrillPoint:
    """Geometry of the drill point."""
    return DrillPoint(
        0.5 * tool.diameter, tool.chisel_radius, tool.web, 0.5 * tool.point_angle, tool.helix, tool.margin_width,
        tool.margin_length,
    )  # fmt: skip


def side_over_thrust(profile: DepthProfile, cone: float) -> FloatArray:
    """Side force over thrust at the depths at which only friction holds the tip, shape (h, 2); flat: no rows."""
    entering = (profile.depth > 0.0) & (profile.depth <= cone) & (profile.thrust > 0.0)
    if not np.any(profile.lateral[entering]):
        return np.zeros((0, 2))
    return np.asarray(profile.lateral[entering] / profile.thrust[entering, None])


def targets(hole: Hole) -> list[PoseTarget]:
    """All holes: the first with its grid, then the others."""
    axes = tool_axes(np.array(hole.axis), 0.0)
    first, axis = np.array(hole.position), axes[:, 2]
    positions = [first]
    if hole.grid is not None:
        positions = [
            first + column * hole.grid.pitch[0] * axes[:, 0] + row * hole.grid.pitch[1] * axes[:, 1]
            for row in range(hole.grid.rows)
            for column in range(hole.grid.columns)
        ]
    return [PoseTarget(np.asarray(p), axis) for p in [*positions, *map(np.array, hole.others)]]


def shifts(placement: Placement | None) -> Iterator[FloatArray]:
    """Places at which the part may be put, as shifts [m]; without a placement only where it is."""
    if placement is None:
        yield np.zeros(3)
        return
    ranges = [(placement.x), (placement.y), (placement.z)]
    grids = [np.linspace(low, high, placement.steps) if high != low else np.array([low]) for low, high in ranges]
    for x in grids[0]:
        for y in grids[1]:
            for z in grids[2]:
                yield np.array([x, y, z])


def dynamics(cell: DrillCell, posture: Posture) -> ArmDynamics:
    """What carries the drill, at its tip in a posture."""
    if cell.arm is None:
        carrier = bodies_at_once(posture.compliance, with_torque=cell.with_torque)
    else:
        carrier = arm_dynamics(posture.compliance, cell.modal_mass, cell.damping, with_torque=cell.with_torque)
    return carrier if math.isinf(cell.part_stiffness) else on_part(carrier, cell.part_stiffness)


def slope_angle(cell: DrillCell, posture: Posture) -> float:
    """Direction of the slope in the axes of the tool, which is turned by the redundancy angle."""
    return cell.slope_direction - posture.angle


def score_of_choice(cell: DrillCell, choice: str, step: float) -> Score:
    """The figure of merit that the scenario names."""

    def error(posture: Posture) -> float:
        outcome, _ = drill_hole(
            cell.cycle, dynamics(cell, posture), cell.profile, slope_angle=slope_angle(cell, posture), step=step,
            dwell=False,
        )  # fmt: skip
        return hole_error(outcome)

    least_skating = skating_on_slope(cell.side, cell.slope_direction)
    return {"stiffest": axial_compliance, "least_skating": least_skating, "best": predicted(error)}[choice]


def skating_of(cell: DrillCell, posture: Posture) -> float:
    """Skating ratio of a posture, with the side force of lips that enter a slope."""
    return float(worst_skating(posture.holding, cell.side, np.asarray(slope_angle(cell, posture))))


def choose(scenario: DrillingScenario, cell: DrillCell, target: PoseTarget) -> tuple[Posture | None, Reach, bool]:
    """Posture for a hole, how well it is reached, and whether only a singularity stands in the way."""
    if scenario.machine is not None:
        return drilling_machine.on_machine(scenario.machine, scenario.part.block, target), Reach(True, -1, 0.0), False
    assert scenario.robot is not None
    assert cell.arm is not None
    robot, choice = scenario.robot, scenario.robot.redundancy_angle
    if isinstance(choice, str):
        step = scenario.numerics.angle_step
        score = score_of_choice(cell, choice, scenario.numerics.time_step)
        posture = search(cell.arm, target, score, margin=robot.singularity_margin, grid=step)
        if posture is None and choice == "best":  # reached, but drilled through in none: show that
            posture = search(cell.arm, target, axial_compliance, margin=robot.singularity_margin, grid=step)
        angles = np.linspace(-math.pi, math.pi, max(round(2.0 * math.pi / step), 8) + 1)
    else:
        posture = fixed(scenario, cell, target, choice)
        angles = np.array([choice])
    few = angles[:: max(1, len(angles) // _CHECKED)]
    if posture is None and cell.arm.general is not None:
        offered = [fixed(scenario, cell, target, angle) for angle in few]
        posture = next((one for one in offered if one is not None), None)
    if posture is not None:
        return posture, reach(cell.arm, target.position, tool_axes(target.axis, posture.angle)), False
    found = scan(cell.arm, target, angles)
    best = least_missing(cell.arm, found)
    if best is None:
        few = few if cell.arm.general is not None else angles
        tried = [reach(cell.arm, target.position, pose) for pose in tool_axes(target.axis, few)]
        best = max(tried, key=lambda r: (r.motor >= 0, r.margin))
    return None, best, bool(np.any(found.within))


def fixed(scenario: DrillingScenario, cell: DrillCell, target: PoseTarget, angle: float) -> Posture | None:
    """The posture at a given redundancy angle: nearest to given joint angles, or the stiffest branch."""
    assert scenario.robot is not None
    assert cell.arm is not None
    pose = tool_axes(target.axis, np.array([angle]))
    given = scenario.robot.joint_angles
    near = None if given is None else np.array(given)
    found = candidates(cell.arm, target.position[None, :], pose, thorough=True)
    allowed = found.within[0] & (found.wrist_sine[0] >= scenario.robot.singularity_margin)
    if not np.any(allowed):
        return None
    q = found.q[0]
    if near is not None:
        order = np.where(allowed, np.abs((q - near + math.pi) % (2.0 * math.pi) - math.pi).max(axis=1), math.inf)
    else:
        order = np.where(allowed, np.round(found.compliance[0] * 1e15), math.inf)
        order = np.where(order <= order.min(), np.abs(q[:, 3]) + np.abs(q[:, 5]), math.inf)
    chosen = q[int(np.argmin(order))]
    return posture_at(cell.arm, angle, chosen if near is None else turned_towards(cell.arm, chosen, near))


def led_to(hole: Hole) -> list[Led]:
    """Where the tool is led at each hole."""
    return [Led(one.shift, one.tilt) for one in hole.corrections] or [NOT_LED] * hole.count


def led_target(target: PoseTarget, axes: FloatArray, led: Led) -> PoseTarget:
    """Target and drill axis that the tool is led to: shifted and tilted in the axes of the tool at the hole, (3, 3)."""
    position = target.position + axes[:, :2] @ np.array(led.shift)
    axis = axes[:, 2] + axes[:, :2] @ np.array(led.tilt)
    return PoseTarget(position, axis / np.linalg.norm(axis))


def led_axes(target: PoseTarget, angle: float, led: Led) -> tuple[PoseTarget, FloatArray]:
    """Where the tool is led, and its axes there as columns: turned about the drill axis as it was at the hole."""
    axes = tool_axes(target.axis, np.array([angle]))[0]
    there = led_target(target, axes, led)
    x = axes[:, 0] - (axes[:, 0] @ there.axis) * there.axis
    x /= np.linalg.norm(x)
    return there, np.column_stack([x, np.cross(there.axis, x), there.axis])


def led(scenario: DrillingScenario, cell: DrillCell, target: PoseTarget, posture: Posture, to: Led) -> Posture | None:
    """The posture next to one at the hole, when the tool is led elsewhere; None if it is out of reach."""
    if scenario.machine is not None:
        axes = tool_axes(target.axis, 0.0)
        return drilling_machine.on_machine(scenario.machine, scenario.part.block, led_target(target, axes, to))
    assert cell.arm is not None
    assert scenario.robot is not None
    there, axes = led_axes(target, posture.angle, to)
    return next_to(cell.arm, there.position, axes, posture, scenario.robot.singularity_margin)


def next_to(arm: Arm, position: FloatArray, axes: FloatArray, posture: Posture, margin: float) -> Posture | None:
    """The posture at a pose (tool axes as columns) that is nearest to another.

    None if that one is beyond a limit of the arm or too near a singularity: another branch of the arm would be a move across
    the cell, and another compliance.
    """
    found = candidates(arm, position[None, :], axes[None], thorough=True)
    turned = np.abs((found.q[0] - posture.q + math.pi) % (2.0 * math.pi) - math.pi).max(axis=1)
    best = int(np.argmin(np.nan_to_num(turned, nan=math.inf)))
    if not (found.within[0][best] and found.wrist_sine[0][best] >= margin):
        return None
    return posture_at(arm, posture.angle, turned_towards(arm, found.q[0][best], posture.q))


def drill_one(
    scenario: DrillingScenario, cell: DrillCell, target: PoseTarget, step: float, to: Led = NOT_LED
) -> DrilledHole:  # fmt: skip
    """Choose a posture and drill, where the tool is led."""
    posture, at, singular = choose(scenario, cell, target)
    if posture is not None and to != NOT_LED:
        posture = led(scenario, cell, target, posture, to)
        singular = singular or posture is None
    if posture is None:
        return DrilledHole(target, None, at, singular, None, np.zeros((0, 12)), np.zeros(3), to)
    return drilled(cell, DrilledHole(target, posture, at, False, None, np.zeros((0, 12)), np.zeros(3), to), step)


def hole_ends(cell: DrillCell, hole: DrilledHole) -> tuple[FloatArray, FloatArray]:
    """Where the hole is at its entry and exit surface, from where it is wanted, in tool axes [m], shape (2,)."""
    assert hole.outcome is not None
    shift, tilt = (np.array(part) for part in hole.led)
    return hole.outcome.entry + shift, hole.outcome.exit + shift + tilt * cell.cycle.thickness


def drilled(cell: DrillCell, hole: DrilledHole, step: float) -> DrilledHole:
    """The hole drilled in its posture."""
    assert hole.posture is not None
    at_tip = dynamics(cell, hole.posture)
    every = max(1, round(cycle_time(cell.cycle) / step / _ROWS))
    outcome, history = drill_hole(
        cell.cycle, at_tip, cell.profile, slope_angle=slope_angle(cell, hole.posture), step=step, every=every
    )
    return hole._replace(outcome=outcome, history=history, frequencies=modes(at_tip))


def place(scenario: DrillingScenario, cell: DrillCell) -> tuple[FloatArray, tuple[tuple[FloatArray, float], ...]]:
    """Where to put the part, and how every place that was tried does [m]."""
    offered = list(shifts(scenario.part.placement))
    if len(offered) == 1:
        return offered[0], ()
    assert scenario.robot is not None
    assert cell.arm is not None
    choice = scenario.robot.redundancy_angle
    score = score_of_choice(cell, choice if isinstance(choice, str) else "stiffest", scenario.numerics.time_step)
    at = targets(scenario.hole)
    rated = place_part(
        cell.arm, [[PoseTarget(t.position + shift, t.axis) for t in at] for shift in offered], score,
        margin=scenario.robot.singularity_margin, grid=max(_COARSE, scenario.numerics.angle_step),
    )  # fmt: skip
    order = [(sum(p is None for p in r.postures), r.worst) for r in rated]
    best = min(range(len(rated)), key=order.__getitem__)
    return offered[best], tuple((shift, r.worst) for shift, r in zip(offered, rated, strict=True))


def run(scenario: DrillingScenario, progress: Callable[[float], None] | None = None) -> DrillRun:
    """Every hole, in the postures that the scenario asks for, the part where it is best put."""
    cell = drill_cell(scenario)
    shift, places = place(scenario, cell)
    holes: list[DrilledHole] = []
    wanted = targets(scenario.hole)
    for target, to in zip(wanted, led_to(scenario.hole), strict=True):
        moved = target._replace(position=target.position + shift)
        holes.append(drill_one(scenario, cell, moved, scenario.numerics.time_step, to))
        if progress is not None:
            progress(len(holes) / len(wanted))
    return DrillRun(cell, tuple(holes), shift, places)


def again(scenario: DrillingScenario, run: DrillRun) -> DrillRun:
    """The run once more, with half the time step and the same postures."""
    step = 0.5 * scenario.numerics.time_step
    holes = (hole if hole.posture is None else drilled(run.cell, hole, step) for hole in run.holes)
    return run._replace(holes=tuple(holes))
