"""Postures in which an arm can drill: every solution of every pose, with its axial compliance and skating ratio.

The drill may be turned about its axis (redundancy angle), and every pose has up to eight solutions. A candidate is one
of these solutions within the limits, with its axial compliance and skating ratio.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.chains import Chain, fill_frames, fill_jacobian, frames, jacobian
from cutwise.maths.compiled import compiled
from cutwise.maths.frames import FloatArray
from cutwise.physics.motion.inverse import numeric_posture
from cutwise.physics.motion.wrist import (
    BRANCHES,
    REACHED,
    WristArm,
    fill_branches,
    reach_margin,
    wrapped,
    wrist_sine,
)
from cutwise.physics.structure.joint_compliance import axial_and_skating, cartesian_compliance, skating_ratio


class Arm(NamedTuple):
    """A six-axis robot with its drill."""

    chain: Chain
    wrist: WristArm | None  # None: no spherical wrist, solved by numbers
    limits: FloatArray  # [rad], shape (6, 2)
    stiffness: FloatArray  # K_theta [N m/rad] at the output, shape (6,)
    tool_rotation: FloatArray  # tool axes in the last frame, as columns, shape (3, 3)
    tool_tip: FloatArray  # [m] drill tip in the last frame, shape (3,)


class Candidates(NamedTuple):
    """All solutions of m poses; NaN where a branch does not exist or is beyond a limit."""

    q: FloatArray  # [rad], shape (m, 8, 6); given also beyond the limits
    within: np.ndarray  # within the joint limits, bool, shape (m, 8)
    compliance: FloatArray  # C_zz [m/N] along the drill axis, shape (m, 8)
    skating: FloatArray  # skating ratio, shape (m, 8)
    wrist_sine: FloatArray  # |sin| of the wrist angle, shape (m, 8)


def tool_axes(axis: FloatArray, angles: FloatArray | float, zero: FloatArray | None = None) -> FloatArray:
    r"""Tool axes, as columns, of a drill axis and redundancy angles.

    .. math::
        z_t = a, \quad x_0 \propto e_x - (e_x\cdot z_t) z_t, \quad y_0 = z_t \times x_0, \quad
        x_t = \cos\alpha\,x_0 + \sin\alpha\,y_0, \quad y_t = -\sin\alpha\,x_0 + \cos\alpha\,y_0

    Parameters
    ----------
    axis : array (3,)
        Feed direction in the base frame, any length. If it lies along x of the base, y of the base takes its place.
    angles : array (...)
        Redundancy angle :math:`\alpha` [rad].
    zero : array (3,), optional
        Direction from which the angle counts, instead of x of the base.

    Returns
    -------
    array (..., 3, 3)
    """
    z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    world = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.999 else np.array([0.0, 1.0, 0.0])
    world = world if zero is None else zero
    x0 = world - (world @ z) * z
    x0 /= np.linalg.norm(x0)
    y0 = np.cross(z, x0)
    c, s = np.cos(angles)[..., None], np.sin(angles)[..., None]
    return np.stack([c * x0 + s * y0, -s * x0 + c * y0, np.broadcast_to(z, (*np.shape(angles), 3))], axis=-1)


@compiled
def _translation_measures(jac: FloatArray, axes: FloatArray, stiffness: FloatArray, result: FloatArray) -> None:
    """Axial compliance and skating ratio of one posture: the translation block of C alone, in tool axes."""
    xx, xy, yy, xz, yz, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(stiffness)):
        x, y, z = 0.0, 0.0, 0.0
        for k in range(3):
            x += axes[k, 0] * jac[k, i]
            y += axes[k, 1] * jac[k, i]
            z += axes[k, 2] * jac[k, i]
        yielding = 1.0 / stiffness[i]
        xx += x * x * yielding
        xy += x * y * yielding
        yy += y * y * yielding
        xz += x * z * yielding
        yz += y * z * yielding
        zz += z * z * yielding
    result[0] = zz
    result[1] = axial_and_skating(xx, xy, yy, xz, yz)


@compiled
def _fill_candidates(
    arm: WristArm,
    kinds: np.ndarray,
    axes: FloatArray,
    rotations: FloatArray,
    origins: FloatArray,
    limits: FloatArray,
    stiffness: FloatArray,
    tool_rotation: FloatArray,
    tip: FloatArray,
    positions: FloatArray,
    poses: FloatArray,
    q: FloatArray,
    within: np.ndarray,
    measures: FloatArray,
) -> None:
    """Closed-form candidates of every pose. The two wrist flips share one compliance: only axis 5 is reversed."""
    flange, place = np.empty((3, 3)), np.empty(3)
    n, work = np.empty((3, 3)), np.empty((3, 3))
    frame_rotations, frame_origins = np.empty((1, 7, 3, 3)), np.empty((1, 7, 3))
    jac, pair = np.empty((6, 6)), np.empty(2)
    for m in range(len(positions)):
        for row in range(3):
            place[row] = positions[m, row]
            for column in range(3):
                flange[row, column] = 0.0
                for k in range(3):
                    flange[row, column] += poses[m, row, k] * tool_rotation[column, k]
            for column in range(3):
                place[row] -= flange[row, column] * tip[column]
        if fill_branches(arm, flange, place, q[m], n, work) != REACHED:
            continue
        for branch in range(8):
            if math.isnan(q[m, branch, 0]):
                continue
            inside = True
            for joint in range(6):
                angle = wrapped(q[m, branch, joint], limits[joint, 0], limits[joint, 1])
                q[m, branch, joint] = angle
                inside = inside and limits[joint, 0] <= angle <= limits[joint, 1]
            within[m, branch] = inside
            if not inside:
                continue
            if branch % 2 == 0 or not within[m, branch - 1]:
                fill_frames(kinds, axes, rotations, origins, q[m, branch : branch + 1], frame_rotations, frame_origins)
                fill_jacobian(kinds, axes, frame_rotations[0], frame_origins[0], tip, jac)
                _translation_measures(jac, poses[m], stiffness, pair)
            measures[m, branch, 0], measures[m, branch, 1] = pair[0], pair[1]
            measures[m, branch, 2] = abs(math.sin(q[m, branch, 4] + arm.bend))


def candidates(arm: Arm, positions: FloatArray, poses: FloatArray, *, near: FloatArray | None = None) -> Candidates:
    """All solutions of poses of the tool.

    Parameters
    ----------
    positions : array (m, 3)
        Drill tip in the base frame [m].
    poses : array (m, 3, 3)
        Tool axes as columns, from :func:`tool_axes`.
    near : array (6,), optional
        Posture from which an arm without closed form is solved first [rad].
    """
    count = len(positions)
    if arm.wrist is None:
        return _numeric_candidates(arm, positions, poses, near)
    q, measures = np.empty((count, BRANCHES, 6)), np.full((count, BRANCHES, 3), math.nan)
    within = np.zeros((count, BRANCHES), dtype=np.bool_)
    _fill_candidates(
        arm.wrist, *arm.chain.arrays, arm.limits, arm.stiffness, arm.tool_rotation, arm.tool_tip,
        np.ascontiguousarray(positions, dtype=float), np.ascontiguousarray(poses, dtype=float), q, within, measures,
    )  # fmt: skip
    return Candidates(q, within, measures[..., 0], measures[..., 1], measures[..., 2])


class Posture(NamedTuple):
    """One way to stand at a hole."""

    angle: float  # redundancy angle [rad]
    q: FloatArray  # [rad], shape (6,)
    compliance: FloatArray  # in tool axes, shape (6, 6)
    skating: float  # skating ratio
    wrist_sine: float  # |sin| of the wrist angle; 0 is singular


def posture_jacobian(arm: Arm, q: FloatArray) -> FloatArray:
    """Jacobian at the drill tip in base axes, shape (6, 6)."""
    return jacobian(arm.chain, q, arm.tool_tip)


def posture_at(arm: Arm, angle: float, q: FloatArray) -> Posture:
    """The posture of known joint angles, with its whole compliance at the drill tip in tool axes."""
    rotation = frames(arm.chain, q).rotations[-1] @ arm.tool_rotation
    compliance = cartesian_compliance(posture_jacobian(arm, q), arm.stiffness, rotation)
    return Posture(float(angle), np.asarray(q), compliance, skating_ratio(compliance), _singularity(arm, q))


def _singularity(arm: Arm, q: FloatArray) -> float:
    """|sin| of the wrist angle; for other arms the smallest singular value of the Jacobian over its largest."""
    if arm.wrist is not None:
        return float(wrist_sine(arm.wrist, q[4]))
    values = np.linalg.svd(posture_jacobian(arm, q), compute_uv=False)
    return float(values[-1] / values[0])


def flange_pose(arm: Arm, position: FloatArray, pose: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Pose of the last frame, in frame 0, that puts the drill tip at a position with given tool axes."""
    rotation = pose @ arm.tool_rotation.T
    return rotation, position - rotation @ arm.tool_tip


def _numeric_candidates(arm: Arm, positions: FloatArray, poses: FloatArray, near: FloatArray | None) -> Candidates:
    """Candidates of an arm without closed form: poses start from their neighbour's solutions and from fixed seeds."""
    count = len(positions)
    q = np.full((count, BRANCHES, 6), math.nan)
    within = np.zeros((count, BRANCHES), dtype=np.bool_)
    measures = np.full((count, BRANCHES, 3), math.nan)
    low, high = np.maximum(arm.limits[:, 0], -math.pi), np.minimum(arm.limits[:, 1], math.pi)
    seeds = low + (high - low) * np.random.default_rng(6).random((2 * BRANCHES, 6))
    if near is not None:
        seeds = np.concatenate([near[None, :], seeds])
    for m in range(count):
        rotation, place = flange_pose(arm, positions[m], poses[m])
        known = [row for row in q[m - 1] if m and not np.isnan(row[0])]
        found: list[FloatArray] = []
        for start in [*known, *(seeds if m % 16 == 0 or not known else ())]:
            angles, error = numeric_posture(arm.chain, rotation, place, start[None, :], iterations=60)
            angles = np.array([wrapped(a, *limit) for a, limit in zip(angles, arm.limits, strict=True)])
            if error < 1e-10 and all(np.abs(angles - other).max() > 1e-6 for other in found):
                found.append(angles)
        for branch, angles in enumerate(found[:BRANCHES]):
            q[m, branch] = angles
            within[m, branch] = np.all((arm.limits[:, 0] <= angles) & (angles <= arm.limits[:, 1]))
            if within[m, branch]:
                at = posture_at(arm, 0.0, angles)
                measures[m, branch] = at.compliance[2, 2], at.skating, at.wrist_sine
    return Candidates(q, within, measures[..., 0], measures[..., 1], measures[..., 2])


class Reach(NamedTuple):
    """How a pose can be reached, or by how much it cannot; the best branch."""

    reached: bool
    joint: int  # the joint with the least room, 0 to 5; -1: the wrist centre is out of reach
    margin: float  # room to its limit [rad], or to the reach of the arm [m]; negative is what is missing


def reach(arm: Arm, position: FloatArray, pose: FloatArray) -> Reach:
    """Margin of the branch with the most room."""
    rotation, place = flange_pose(arm, position, pose)
    found = candidates(arm, position[None, :], pose[None, :])
    exists = ~np.isnan(found.q[0, :, 0])
    if not np.any(exists):
        margin = min(reach_margin(arm.wrist, rotation, place)) if arm.wrist is not None else math.nan
        return Reach(False, -1, margin)
    q = found.q[0, exists]
    room = np.minimum(q - arm.limits[:, 0], arm.limits[:, 1] - q)
    branch = int(np.argmax(room.min(axis=1)))
    joint = int(np.argmin(room[branch]))
    return Reach(bool(room[branch, joint] >= 0.0), joint, float(room[branch, joint]))
