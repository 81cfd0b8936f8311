"""The numbers of a drilling run: of every hole, of the worst one, and of the forces."""

import math

import numpy as np

from cutwise.maths.frames import FloatArray
from cutwise.physics.cutting.drill import margin_torque, rotating_force, shares
from cutwise.physics.structure.joint_compliance import axis_tilt
from cutwise.physics.surface.hole import perpendicularity, whirl_amplitudes
from cutwise.process.arm_geometry import misplaced
from cutwise.process.drilling import DrillCell, DrilledHole, DrillRun, hole_ends, skating_of
from cutwise.process.posture import Posture, joint_room, posture_frames
from cutwise.process.postures import base_at, tool_axes
from cutwise.spec.drilling import DrillingScenario

# How the worst hole of a pattern is told: the smallest of these, the largest magnitude of all others.
_SMALLEST_IS_WORST = (
    "feed_per_rev_min", "wrist_margin", "joint_limit_margin", "skating_margin", "natural_frequency_min",
)  # fmt: skip
_SINGLE_ONLY = ("redundancy_angle",)


def hole_measures(scenario: DrillingScenario, cell: DrillCell, hole: DrilledHole) -> dict[str, float]:
    """Measures of one hole that was drilled."""
    outcome, posture = hole.outcome, hole.posture
    assert outcome is not None
    assert posture is not None
    whirl = whirl_amplitudes(
        posture.compliance[:2, :2], rotating_force(cell.point, cell.stress, scenario.tool.lip_height_error),
        cell.modal_mass, cell.damping, scenario.operation.spindle_speed,
    )  # fmt: skip
    skates = skating_of(cell, posture)
    found = {
        "thrust_max": outcome.thrust_max,
        "thrust_mean": outcome.thrust_mean,
        "torque_max": outcome.torque_max,
        "lateral_force_max": outcome.lateral_force_max,
        "axial_deflection_max": outcome.axial_max,
        "axial_deflection_mean": outcome.axial_mean,
        "lateral_deflection_max": outcome.lateral_max,
        "lateral_deflection_mean": outcome.lateral_mean,
        **_position(scenario, cell, hole, _misplacement(scenario, cell, posture)),
        "drill_tilt": axis_tilt(posture.compliance, outcome.thrust_mean),
        "circularity_estimate": abs(whirl[0] - whirl[1]),
        "oversize_estimate": whirl[0] + whirl[1],
        "feed_per_rev_max": outcome.feed_max,
        "feed_per_rev_min": outcome.feed_min,
        "depth_error": outcome.rest,
        "skating_ratio": skates,
        "skating_margin": scenario.contact.friction - skates,
        "compliance_axial": float(posture.compliance[2, 2]) + 1.0 / cell.part_stiffness,
        "cycle_time": outcome.time,
        **_shares(cell, hole, outcome.thrust_mean),
    }
    if cell.arm is not None:
        found |= {
            "redundancy_angle": posture.angle,
            "wrist_margin": posture.wrist_sine,
            "joint_limit_margin": float(joint_room(cell.arm, posture.q).min()),
            "natural_frequency_min": float(hole.frequencies[0]),
        }
    if outcome.thrust_mean == 0.0:  # no full cut: the plate is thinner than the drill point
        shares = [name for name in found if name.startswith("share_")]
        for name in ("thrust_mean", "axial_deflection_mean", "lateral_deflection_mean", "drill_tilt", *shares):
            del found[name]
    if outcome.feed_max == 0.0:  # it never breaks through
        del found["feed_per_rev_max"]
    return {name: value for name, value in found.items() if math.isfinite(value)}


def _shares(cell: DrillCell, hole: DrilledHole, thrust: float) -> dict[str, float]:
    """Part of each term in the axial deflection under a thrust [m]; together they are minus compliance times thrust."""
    assert hole.posture is not None
    whole = float(hole.posture.compliance[2, 2])
    if cell.arm is None:
        terms = {"bodies": whole}
    else:
        base = float(base_at(cell.arm, hole.target.position[None], tool_axes(hole.target.axis, np.zeros(1)))[0, 5])
        terms = {"arm": whole - base, **({"base": base} if cell.arm.base.any() else {})}
    if math.isfinite(cell.part_stiffness):
        terms["part_stiffness"] = 1.0 / cell.part_stiffness
    return {f"share_{name}": -compliance * thrust for name, compliance in terms.items()}


def _misplacement(scenario: DrillingScenario, cell: DrillCell, posture: Posture) -> FloatArray:
    """Twist of the tip by geometric errors of the arm in tool axes [m, rad], shape (6,)."""
    robot = scenario.robot
    if robot is None or robot.errors is None or cell.arm is None:
        return np.zeros(6)
    axes = posture_frames(cell.arm, posture.q).rotations[-1] @ cell.arm.tool_rotation
    twist = misplaced(robot, cell.arm, posture.q[None]).twist[0]
    return np.concatenate([axes.T @ twist[:3], axes.T @ twist[3:]])


def _position(scenario: DrillingScenario, cell: DrillCell, hole: DrilledHole, wrong: FloatArray) -> dict[str, float]:
    """Where the hole is, as far as there is one: what was not reached is left out.

    ``wrong``: twist of the tip by geometric errors, tool axes. It shifts the hole and tilts it.
    """
    found, robot, outcome = {}, scenario.robot, hole.outcome
    assert outcome is not None
    at_entry, at_exit = hole_ends(cell, hole)
    if outcome.entered:
        found["hole_position_error_entry"] = float(np.hypot(*at_entry))
    if outcome.through:
        found["hole_position_error_exit"] = float(np.hypot(*at_exit))
    if robot is not None and (robot.accuracy is not None or robot.errors is not None):
        found["hole_position_error_arm"] = (robot.accuracy or 0.0) + float(np.hypot(*wrong[:2]))
    thickness = cell.cycle.thickness
    lean = np.array([wrong[4], -wrong[3]]) * thickness  # of the drill over the depth of the hole
    if "hole_position_error_arm" in found and outcome.through:
        ends = (at_entry + wrong[:2], at_exit + wrong[:2] + lean)
        known = max(float(np.hypot(*at_entry)), float(np.hypot(*at_exit))) + found["hole_position_error_arm"]
        if robot is not None and robot.errors is not None:
            known = max(float(np.hypot(*end)) for end in ends) + (robot.accuracy or 0.0)
        found["hole_position_error_total"] = known
    if outcome.through:
        found["perpendicularity_error"] = perpendicularity(at_entry, at_exit + lean, thickness)
    return found


def measures(scenario: DrillingScenario, run: DrillRun) -> dict[str, float]:
    """All measures in SI: of the hole, or of the worst hole of a pattern; forces also of a hole out of reach."""
    cell = run.cell
    lips, chisel, torque_lips, torque_chisel = nominal_shares(scenario, cell)
    found = {"thrust_lips": lips, "thrust_chisel": chisel, "torque_lips": torque_lips, "torque_chisel": torque_chisel}
    found["torque_margin"] = margin_torque(cell.point, cell.law.margin_stress, 1.0, scenario.part.thickness)
    each = [hole_measures(scenario, cell, hole) for hole in run.holes if hole.outcome is not None]
    names = dict.fromkeys(name for one in each for name in one)
    for name in names:
        values = [one[name] for one in each if name in one]
        if name == "cycle_time":
            found[name] = sum(values)
        elif name in _SMALLEST_IS_WORST:
            found[name] = min(values)
        elif name not in _SINGLE_ONLY or len(run.holes) == 1:
            found[name] = max(values, key=abs)
    found["holes_drilled"] = float(len(each))
    return found


def nominal_shares(scenario: DrillingScenario, cell: DrillCell) -> tuple[float, float, float, float]:
    """Thrust of lips and chisel edge, torque of lips and chisel edge, in full contact at nominal feed [N, N m]."""
    feed = scenario.operation.feed_per_rev
    closed = shares(cell.point, cell.stress, feed)
    if not len(cell.elements.thrust):
        return closed
    middle = 0.5 * (cell.elements.edges[1:] + cell.elements.edges[:-1])
    section = feed * np.diff(cell.elements.edges) * (middle > cell.point.chisel_radius)
    lips, torque = float(cell.elements.thrust @ section), float((cell.elements.tangential * middle) @ section)
    return lips, closed[1], torque, closed[3]
