"""One posture of an arm: where its joints are, what it yields by, how much room it has, and how a pose is reached at all."""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.chains import Frames, frames, jacobian
from cutwise.maths.frames import FloatArray
from cutwise.physics.motion.wrist import reach_margin, wrist_sine
from cutwise.physics.structure.joint_compliance import holding_ratio
from cutwise.physics.structure.series_compliance import chain_compliance, in_axes, turning_elements
from cutwise.process.postures import Arm, Candidates, Springs, bend, by_numbers, candidates


class Posture(NamedTuple):
    """One way to stand at a hole."""

    angle: float  # redundancy angle [rad]
    q: FloatArray  # [rad] of the motors, shape (6,)
    compliance: FloatArray  # in tool axes, shape (6, 6)
    holding: FloatArray  # lateral force over thrust that holds the tip at a flat entry, tool axes, shape (2,)
    wrist_sine: float  # |sin| of the wrist angle; 0 is singular

    @property
    def skating(self) -> float:
        """Skating ratio at a flat entry."""
        return float(np.hypot(*self.holding))


def posture_jacobian(arm: Arm, q: FloatArray) -> FloatArray:
    """Jacobian at the drill tip over everything that yields, in base axes, shape (6, k)."""
    joints = jacobian(arm.chain, arm.drives.joints(q), arm.tool_tip) @ arm.drives.elastic
    at = posture_frames(arm, q)
    tip = at.origins[-1] + at.rotations[-1] @ arm.tool_tip
    return np.concatenate([joints, spring_twists(arm.springs, at.rotations, at.origins, tip)], axis=-1)


def spring_twists(springs: Springs, rotations: FloatArray, origins: FloatArray, at: FloatArray) -> FloatArray:
    """Twist of a body at a point for a unit of each spring that carries it, in base axes.

    Parameters
    ----------
    rotations, origins : arrays (..., n + 1, 3, 3) and (..., n + 1, 3)
        Frames of base and joints [m].
    at : array (..., 3)
        The point [m].

    Returns
    -------
    array (..., 6, k)
        Displacement over rotation [m and 1 per rad; 1 and 0 per m].
    """
    own = rotations[..., springs.frame, :, :]
    axis = np.einsum("...kij,kj->...ki", own, springs.axis)
    place = origins[..., springs.frame, :] + np.einsum("...kij,kj->...ki", own, springs.point)
    turned = np.cross(axis, np.asarray(at)[..., None, :] - place)
    moved = np.where(springs.turns[:, None], turned, axis)
    return np.concatenate([moved, np.where(springs.turns[:, None], axis, 0.0)], axis=-1).swapaxes(-1, -2)


def posture_frames(arm: Arm, q: FloatArray) -> Frames:
    """Frames of all joints in postures (..., 6)."""
    return frames(arm.chain, arm.drives.joints(q))


def arm_compliance(arm: Arm, q: FloatArray) -> FloatArray:
    """Compliance at the drill tip of the joints and of the base, in base axes, shape (6, 6)."""
    joints = turning_elements(posture_jacobian(arm, q), arm.stiffness)
    levers = np.zeros((len(joints) + 1, 3))
    at = posture_frames(arm, q)
    levers[-1] = at.origins[-1] + at.rotations[-1] @ arm.tool_tip
    return chain_compliance(np.concatenate([joints, arm.base[None]]), levers)


def posture_at(arm: Arm, angle: float, q: FloatArray) -> Posture:
    """The posture of known motor angles, with its whole compliance at the drill tip in tool axes."""
    rotation = posture_frames(arm, q).rotations[-1] @ arm.tool_rotation
    compliance = in_axes(arm_compliance(arm, q), rotation)
    axis_angles: FloatArray = np.asarray(np.linalg.solve(arm.axes.to_motors, q), dtype=float)
    if arm.wrist is not None:
        bent = float(wrist_sine(arm.wrist, axis_angles[4]))
    else:
        bent = float(bend(arm, axis_angles[None, None, :])[0, 0])
    return Posture(float(angle), np.asarray(q), compliance, holding_ratio(compliance), bent)


def joint_room(arm: Arm, q: FloatArray) -> FloatArray:
    """How far the motors are from the nearer of their limits [rad], at angles (..., 6) of them, same shape."""
    return np.minimum(q - arm.limits[:, 0], arm.limits[:, 1] - q)


def turned_towards(arm: Arm, q: FloatArray, near: FloatArray) -> FloatArray:
    """The same posture with every motor on the turn next to a given angle, as far as the limits allow."""
    turns = np.round((near - q) / (2.0 * math.pi))
    moved = q + 2.0 * math.pi * turns
    moved = np.where((arm.limits[:, 0] <= moved) & (moved <= arm.limits[:, 1]), moved, q)
    same = np.allclose(np.exp(1j * arm.drives.joints(moved)), np.exp(1j * arm.drives.joints(q)), atol=1e-9)
    return np.asarray(moved if same else q)


class Reach(NamedTuple):
    """How a pose can be reached, or by how much it cannot; the best branch."""

    reached: bool
    motor: int  # the one with the least room, 0 to 5; -1: no posture puts the tool there, whatever the limits
    margin: float  # room to its limit [rad], or to the reach of the arm [m]; negative is what is missing
    between: bool = False  # the limit of an angle between coupled links is the one in the way


def reach(arm: Arm, position: FloatArray, pose: FloatArray) -> Reach:
    """Margin of the branch with the most room."""
    rotation = pose @ (arm.axes.rotation @ arm.tool_rotation).T
    place = position - rotation @ (arm.axes.origin + arm.axes.rotation @ arm.tool_tip)
    found = candidates(arm, position[None, :], pose[None, :], thorough=True)
    best = least_missing(arm, found)
    if best is not None:
        return best
    if arm.wrist is not None:
        return Reach(False, -1, min(reach_margin(arm.wrist, rotation, place)))
    return Reach(False, -1, -by_numbers(arm, rotation, place)[1])


def least_missing(arm: Arm, found: Candidates) -> Reach | None:
    """Margin of the branch with the most room, of all poses; None where no branch exists."""
    exists = ~np.isnan(found.q[..., 0])
    if not np.any(exists):
        return None
    q = found.q[exists]
    room = np.minimum(q - arm.limits[:, 0], arm.limits[:, 1] - q)
    branch = int(np.argmax(room.min(axis=1)))
    motor = int(np.argmin(room[branch]))
    within = bool(found.within[exists].any())
    free = bool(room[branch, motor] >= 0.0)
    return Reach(within, motor, float(room[branch, motor]), between=free and not within)
