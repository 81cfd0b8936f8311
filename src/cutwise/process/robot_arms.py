"""Robots of a scenario as arms: joints, couplings, stiffness and tool as SI records."""

import numpy as np

from cutwise.maths.chains import REVOLUTE, Chain, chain, frames
from cutwise.maths.frames import FloatArray, rotation_from_rpy
from cutwise.physics.motion.coupled import Drives, NotSixAxesError
from cutwise.process.postures import Arm, arm_with
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.robot import Linkage, Robot


def robot_arm(robot: Robot) -> tuple[Arm, str]:
    """The arm with its tool, and why it has no closed-form inverse kinematics (empty if it has).

    Raises
    ------
    ScenarioFault
        Coupled joints that do not reduce to six axes.
    """
    joints = robot.joints
    serial = chain(
        [REVOLUTE] * len(joints),
        [joint.axis for joint in joints],
        [joint.origin for joint in joints],
        rotations=[rotation_from_rpy(*joint.rotation) for joint in joints],
    )
    flange = rotation_from_rpy(*robot.flange_rotation)
    try:
        arm = arm_with(
            serial, np.array([joints[k].limits for k in robot.motors]), np.array(robot.joint_stiffness),
            np.ascontiguousarray(flange @ rotation_from_rpy(*robot.tool_rotation)),
            np.array(robot.flange_origin) + flange @ np.array(robot.tool_position), drives=drives(robot, serial),
            base=base_element(robot),
        )  # fmt: skip
    except NotSixAxesError as fault:
        message = f"{fault}; followers must stand on the line of another joint, or make a parallelogram with one"
        raise ScenarioFault([Fault(("robot", "joints"), message)]) from None
    return arm, arm.not_spherical


def base_element(robot: Robot) -> FloatArray:
    """Compliance of the base at its origin, in base axes, shape (6, 6)."""
    given = robot.base_compliance or ()
    return np.diag([*given, *([0.0] * (6 - len(given)))])


def drives(robot: Robot, serial: Chain) -> Drives:
    """How motors and held joints turn the joints of the scenario.

    Raises
    ------
    ScenarioFault
        A linkage without a ratio between joints that are not parallel.
    """
    names, count = robot.names, len(robot.joints)
    turn, held = np.eye(count), np.zeros(count)  # columns: joints with a motor or a brake
    for entry in robot.held_joints:
        if entry.angle is not None:
            held[names.index(entry.joint)] = entry.angle
    for linkage in robot.linkages:
        ratio = _parallelogram(robot, serial, linkage) if linkage.ratio is None else linkage.ratio
        turn[names.index(linkage.joint), names.index(linkage.driver)] = ratio
    offsets = held.copy()
    for k, joint in enumerate(robot.joints):
        if joint.mimic is not None:
            leader = names.index(joint.mimic.joint)
            turn[k] = joint.mimic.multiplier * turn[leader]
            offsets[k] = joint.mimic.multiplier * held[leader] + joint.mimic.offset
    bounded = [linkage for linkage in robot.linkages if linkage.limits is not None]
    rows = np.ascontiguousarray(turn[:, list(robot.motors)])
    return Drives(
        rows, offsets, np.ascontiguousarray(turn[:, list(robot.yielding)]),
        rows[[names.index(linkage.joint) for linkage in bounded]].reshape(-1, rows.shape[1]),
        np.array([linkage.limits for linkage in bounded], dtype=float).reshape(-1, 2),
    )  # fmt: skip


def _parallelogram(robot: Robot, serial: Chain, linkage: Linkage) -> float:
    """The ratio at which the link behind a joint keeps its direction: -1, or 1 where the axes point against each other."""
    joint, driver = robot.names.index(linkage.joint), robot.names.index(linkage.driver)
    between = frames(serial, np.zeros(len(serial.kinds))).rotations
    cosine = float((between[joint + 1] @ serial.axes[joint]) @ (between[driver + 1] @ serial.axes[driver]))
    if abs(cosine) < 1.0 - 1e-9:
        message = f"joints {linkage.driver} and {linkage.joint} are not parallel: write the ratio of the linkage"
        raise ScenarioFault([Fault(("robot", "linkages", robot.linkages.index(linkage), "ratio"), message)])
    return -1.0 if cosine > 0.0 else 1.0
