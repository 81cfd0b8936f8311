"""What an arm carries: masses of its links and tool, what they weigh on its joints, and how far it sags by them."""

from typing import NamedTuple

import numpy as np

from cutwise.maths.constants import GRAVITY
from cutwise.maths.frames import FloatArray, rotation_from_rpy
from cutwise.paths.carried import CarriedPath
from cutwise.process.posture import posture_frames, spring_twists
from cutwise.process.postures import Arm
from cutwise.spec.carrier import CarryingRobot


def mass_matrices(robot: CarryingRobot, arm: Arm, q: FloatArray) -> FloatArray:
    r"""Inertia of links and tool seen by everything that yields, :math:`M = \sum m J_v^T J_v + J_\omega^T I J_\omega`.

    Parameters
    ----------
    q : array (n, 6)
        Postures.

    Returns
    -------
    array (n, k, k)
        [kg m^2]
    """
    at = posture_frames(arm, q)
    axis = np.einsum("mkij,kj->mki", at.rotations[:, 1:], arm.chain.axes)
    total = np.zeros((len(q), axis.shape[1], axis.shape[1]))
    for body in masses(robot):
        turn = at.rotations[:, body.joint + 1]
        point = at.origins[:, body.joint + 1] + turn @ body.centre
        moves = np.arange(axis.shape[1]) <= body.joint
        speed = np.cross(axis, point[:, None] - at.origins[:, 1:]) * moves[:, None]
        spin = axis * moves[:, None]
        inertia = turn @ body.inertia @ np.swapaxes(turn, -1, -2)
        total += body.mass * np.einsum("mki,mli->mkl", speed, speed) + np.einsum(
            "mki,mij,mlj->mkl", spin, inertia, spin
        )
    return np.asarray(arm.drives.elastic.T @ total @ arm.drives.elastic)


def sag_along(
    robot: CarryingRobot, arm: Arm, path: CarriedPath, q: FloatArray, jacobians: FloatArray, wrong: FloatArray
) -> FloatArray:
    r"""Twist of the tip without cut: under the weights of links and tool, and by geometric errors; process axes, (n, 6).

    .. math:: u_g = J K_\theta^{-1} \tau_g, \qquad \tau_g = \sum_m J_m^T m g

    Unless it is ``absolute``, that of the first station, at which the path was taught, is taken off.

    Parameters
    ----------
    wrong : array (n, 6)
        Twist by the geometric errors of the arm, base axes [m, rad].
    """
    torque = np.zeros((len(q), len(arm.chain.kinds)))
    pushed = np.zeros((len(q), len(arm.springs.frame)))  # what the weights do to the springs of bodies
    at, down = posture_frames(arm, q), np.array(robot.down)
    for first, body in _hanging(robot):
        joint = body.joint
        axis = np.einsum("mkij,kj->mki", at.rotations[:, 1:], arm.chain.axes)
        point = at.origins[:, joint + 1] + at.rotations[:, joint + 1] @ body.centre
        lowered = np.cross(axis, point[:, None] - at.origins[:, 1:])[:, : joint + 1] @ down
        torque[:, : joint + 1] += GRAVITY * body.mass * lowered
        sunk = np.einsum("mjk,j->mk", spring_twists(arm.springs, at.rotations, at.origins, point)[:, :3], down)
        pushed += GRAVITY * body.mass * np.where(arm.springs.carries <= first, sunk, 0.0)
    loads = np.concatenate([torque @ arm.drives.elastic, pushed], axis=1)
    twist = np.einsum("nij,nj->ni", jacobians, loads / arm.stiffness)
    twist = wrong if robot.sag == "ignored" else twist + wrong
    if robot.sag != "absolute":  # before it is turned: the path was taught in the axes of the base
        twist = twist - twist[0]
    side = np.linalg.det(path.axes)[:, None]
    return np.concatenate([
        np.einsum("nji,nj->ni", path.axes, twist[:, :3]), side * np.einsum("nji,nj->ni", path.axes, twist[:, 3:])
    ], axis=1)  # fmt: skip


class Massive(NamedTuple):
    """Something with mass that an arm carries."""

    joint: int  # number of the joint behind which it moves
    mass: float  # [kg]
    centre: FloatArray  # [m] in the frame of that joint, shape (3,)
    inertia: FloatArray  # about the centre, axes of that frame [kg m^2], shape (3, 3)


def masses(robot: CarryingRobot) -> list[Massive]:
    """Links and tool, as far as they are given."""
    found = [
        Massive(k, link.mass, np.array(link.centre), _tensor(link.inertia))
        for k, link in enumerate(robot.links or ())
    ]  # fmt: skip
    if robot.tool_mass is not None:
        flange = rotation_from_rpy(*robot.flange_rotation)
        centre = np.array(robot.flange_origin) + flange @ np.array(robot.tool_centre)
        found.append(Massive(len(robot.joints) - 1, robot.tool_mass, centre, np.zeros((3, 3))))
    return found


def _hanging(robot: CarryingRobot) -> list[tuple[int, Massive]]:
    """What weighs on the springs, each with the number of its link; the tool has one more than the last link.

    Not the links where what the joints yield by under them is a geometric error that was measured.
    """
    found = [(body.joint, body) for body in masses(robot)]
    if robot.tool_mass is not None:
        found[-1] = (len(robot.joints), found[-1][1])
    of_links = robot.errors is None or not robot.errors.of_gravity
    return found if of_links else [one for one in found if one[0] == len(robot.joints)]


def _tensor(given: tuple[float, ...] | None) -> FloatArray:
    """Inertia tensor from xx, yy, zz, and xy, xz, yz where they are written."""
    xx, yy, zz, xy, xz, yz = (*(given or (0.0, 0.0, 0.0)), 0.0, 0.0, 0.0)[:6]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
