"""A robot instead of a machine: its joints, its base and its spindle as the bodies of a pass at rest."""

import numpy as np

from cutwise.maths import chains
from cutwise.maths.chains import FIXED, REVOLUTE, Chain
from cutwise.maths.constants import GRAVITY
from cutwise.maths.frames import FloatArray, rotation_from_rpy
from cutwise.paths.carried import CarriedPath, placed
from cutwise.physics.motion.volumetric import Axes
from cutwise.physics.structure.series_compliance import joint_element
from cutwise.process import carried
from cutwise.process.arm_masses import masses
from cutwise.process.machine_force import CutForce
from cutwise.process.machine_pass import ElasticElement, Weight
from cutwise.process.machine_path import ToolPath
from cutwise.process.postures import Arm
from cutwise.process.robot_arms import base_element
from cutwise.spec.carrier import CarryingRobot, Standing
from cutwise.spec.faults import Fault, ScenarioFault

_UPRIGHT = np.diag([1.0, -1.0, -1.0])  # an arm counts z along the feed of its tool, a spindle towards the motor


def joints_along(
    robot: CarryingRobot, standing: Standing, way: ToolPath, cut: CutForce, up: FloatArray
) -> carried.ArmAlong:  # fmt: skip
    """The postures of a robot at the places of a pass in the part; several at one place count once.

    Parameters
    ----------
    cut : CutForce
        In the part's frame: what the angle of the tool is chosen for.
    up : array (3,)
        From the tip of the tool to its motor, in the part.

    Raises
    ------
    Infeasible
        The pass is out of reach, or a joint would have to turn faster than it can.
    """
    rows = np.flatnonzero(np.diff(way.travel, prepend=-1.0) > 0.0)
    axes = _axes(way.direction[rows], up)
    nominal = CarriedPath(way.travel[rows], way.point[rows], axes)
    path = placed(nominal, rotation_from_rpy(*standing.rotation), np.array(standing.origin))
    force = np.einsum("mji,mj->mi", axes, cut.force[rows]).mean(axis=0)
    wrench = np.concatenate([force if force.any() else [0.0, 1.0, 0.0], np.zeros(3)])
    return carried.arm_along(robot, path, wrench, 0.0, float(way.feed.max()))


def _axes(direction: FloatArray, up: FloatArray) -> FloatArray:
    """Process axes as columns; where the tool goes along its own axis, those of the place before (or after)."""
    across = direction - np.outer(direction @ up, up)
    size = np.linalg.norm(across, axis=1)
    there = np.flatnonzero(size > 1e-6)
    if not len(there):
        side = np.eye(3)[int(np.argmin(np.abs(up)))]
        across, size, there = (
            np.tile(side - (side @ up) * up, (len(direction), 1)),
            np.ones(len(direction)),
            np.arange(1),
        )
    nearest = there[np.clip(np.searchsorted(there, np.arange(len(size)), side="right") - 1, 0, None)]
    x = across[nearest] / np.linalg.norm(across[nearest], axis=1, keepdims=True)
    z = np.tile(up, (len(x), 1))
    return np.stack([x, np.cross(z, x), z], axis=-1)


def commands_of(along: carried.ArmAlong, way: ToolPath) -> FloatArray:
    """Commands of base, joints and spindle at all places of a pass, shape (m, n)."""
    rows = np.searchsorted(along.path.at, way.travel)
    q = along.arm.drives.joints(along.postures.q)[rows]
    still = np.zeros((len(q), 1))
    return np.hstack([still, q, still])


def axes_of(arm: Arm, standing: Standing) -> Axes:
    """The arm as a chain from the part on, its spindle at the tip with z towards the motor."""
    turn = rotation_from_rpy(*standing.rotation).T
    inner: Chain = arm.chain
    count = len(inner.kinds) + 2
    none = np.zeros((1, 3))
    chain = chains.chain(
        [FIXED, *([REVOLUTE] * (count - 2)), FIXED],
        np.vstack([none, inner.axes, none]),
        np.vstack([-turn @ np.array(standing.origin), inner.origins, arm.tool_tip]),
        rotations=np.concatenate([turn[None], inner.rotations, (arm.tool_rotation @ _UPRIGHT)[None]]),
    )
    zero = np.zeros(count)
    return Axes(chain, np.ones(count), np.zeros(count, dtype=bool), (None,) * count, zero, zero)


def elements_of(robot: CarryingRobot, arm: Arm, names: tuple[str, ...]) -> list[ElasticElement]:
    """What the base and each joint yield by, joints by name.

    Raises
    ------
    ScenarioFault
        Joints are coupled, so that one motor yields in two of them.
    """
    elastic = arm.drives.elastic
    if elastic.shape[0] != elastic.shape[1] or (elastic != np.eye(len(elastic))).any():
        raise ScenarioFault([Fault(("robot", "linkages"), "couple joints, so that no joint yields by itself: the budget by "
                             "joints is for arms without linkages and followers; use process: mill or deburr")])  # fmt: skip
    found = []
    if robot.base_compliance is not None:
        found.append(ElasticElement("base", 1, 1, np.zeros(3), base_element(robot), None))
    for k, name in enumerate(names):
        element = joint_element(arm.chain.axes[k], float(arm.stiffness[k]))
        found.append(ElasticElement(name, k + 2, k + 2, np.zeros(3), element, None))
    return found


def weights_of(robot: CarryingRobot, standing: Standing) -> tuple[Weight, ...]:
    """Weights of links and tool, axes of the part."""
    down = rotation_from_rpy(*standing.rotation).T @ np.array(robot.down)
    return tuple(
        Weight(body.joint + 2, body.mass * GRAVITY * down, body.centre) for body in masses(robot)
    )  # fmt: skip
