"""Robots of a scenario as arms: joints, couplings, stiffness and tool as SI records."""

import numpy as np

from cutwise.maths.chains import REVOLUTE, Chain, chain, frames
from cutwise.maths.frames import FloatArray, rotation_from_rpy
from cutwise.physics.motion.coupled import Drives, NotSixAxesError
from cutwise.process.posture import arm_compliance
from cutwise.process.postures import NO_SPRINGS, Arm, Springs, arm_with
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.robot import Linkage, Robot

_STIFF = 1e-9  # smallest over largest compliance of the tool, below which it counts as stiff


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
    springs, compliance = body_springs(robot)
    joint_stiffness = np.full(len(robot.yielding), np.inf) if robot.joint_stiffness is None else robot.joint_stiffness
    stiffness = np.concatenate([joint_stiffness, 1.0 / compliance])
    try:
        arm = arm_with(
            serial, np.array([joints[k].limits for k in robot.motors]), stiffness,
            np.ascontiguousarray(flange @ rotation_from_rpy(*robot.tool_rotation)),
            np.array(robot.flange_origin) + flange @ np.array(robot.tool_position), drives=drives(robot, serial),
            base=base_element(robot), springs=springs,
        )  # fmt: skip
    except NotSixAxesError as fault:
        message = f"{fault}; followers must stand on the line of another joint, or make a parallelogram with one"
        raise ScenarioFault([Fault(("robot", "joints"), message)]) from None
    if robot.body_compliance is not None:
        _yields_everywhere(arm)
    return arm, arm.not_spherical


def _yields_everywhere(arm: Arm) -> None:
    """Springs that leave a direction stiff, in a posture like any other, have no stiffness there to swing with."""
    middle = arm.limits.mean(axis=1) + 0.1 * np.arange(1.0, 7.0)
    size = np.linalg.eigvalsh(arm_compliance(arm, middle)[:3, :3])
    if size[0] <= _STIFF * size[-1]:
        message = (
            "the tool cannot yield in every direction: springs that turn or shift it along all three axes are needed, as "
            "cutwise calibrate robot-stiffness with fit.model=bodies gives them"
        )
        raise ScenarioFault([Fault(("robot", "body_compliance"), message)])


def body_springs(robot: Robot) -> tuple[Springs, FloatArray]:
    """Springs of the bodies of an arm, and their compliances [rad/(N m), m/N]; those of 0 are left out."""
    given = [one for one in robot.body_compliance or () if one.value > 0.0]
    if not given:
        return NO_SPRINGS, np.zeros(0)
    count, flange = len(robot.joints), rotation_from_rpy(*robot.flange_rotation)
    frames_of = {"base": 0, "flange": count}
    own = [one.body == "flange" for one in given]
    axes = [np.eye(3)["xyz".index(one.axis)] for one in given]
    return Springs(
        np.array([frames_of.get(str(one.body), one.body) for one in given], dtype=np.int64),
        np.array([one.motion == "rotation" for one in given]),
        np.array([flange @ axis if at else axis for axis, at in zip(axes, own, strict=True)]),
        np.array([robot.flange_origin if at else (0.0, 0.0, 0.0) for at in own]),
        np.array([count if at else max(int(frames_of.get(str(one.body), one.body)) - 1, 0)
                  for one, at in zip(given, own, strict=True)], dtype=np.int64),
    ), np.array([one.value for one in given])  # fmt: skip


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
