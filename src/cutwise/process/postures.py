"""Which posture an arm should drill in: candidates over redundancy angle and branches, and the search among them.

The drill may be turned about its axis (redundancy angle), and every pose has up to eight solutions. A candidate is one
of these solutions within the limits, with its axial compliance and skating ratio.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from cutwise.maths.chains import Chain, fill_frames, fill_jacobian, jacobian
from cutwise.maths.compiled import compiled
from cutwise.maths.frames import FloatArray
from cutwise.physics.motion.inverse import numeric_posture
from cutwise.physics.motion.wrist import BRANCHES, REACHED, WristArm, fill_branches, wrapped
from cutwise.physics.structure.joint_compliance import axial_and_skating, cartesian_compliance


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


def tool_axes(axis: FloatArray, angles: FloatArray | float) -> FloatArray:
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

    Returns
    -------
    array (..., 3, 3)
    """
    z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    world = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.999 else np.array([0.0, 1.0, 0.0])
    x0 = world - (world @ z) * z
    x0 /= np.linalg.norm(x0)
    y0 = np.cross(z, x0)
    c, s = np.cos(angles)[..., None], np.sin(angles)[..., None]
    return np.stack([c * x0 + s * y0, -s * x0 + c * y0, np.broadcast_to(z, (*np.shape(angles), 3))], axis=-1)


@compiled
def _translation_measures(
    jac: FloatArray, axes: FloatArray, stiffness: FloatArray, result: FloatArray
) -> None:
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


def candidates(arm: Arm, positions: FloatArray, poses: FloatArray) -> Candidates:
    """All solutions of poses of the tool.

    Parameters
    ----------
    positions : array (m, 3)
        Drill tip in the base frame [m].
    poses : array (m, 3, 3)
        Tool axes as columns, from :func:`tool_axes`.
    """
    count = len(positions)
    if arm.wrist is None:
        return _numeric_candidates(arm, positions, poses)
    q, measures = np.empty((count, BRANCHES, 6)), np.full((count, BRANCHES, 3), math.nan)
    within = np.zeros((count, BRANCHES), dtype=np.bool_)
    _fill_candidates(
        arm.wrist, *arm.chain.arrays, arm.limits, arm.stiffness, arm.tool_rotation, arm.tool_tip,
        np.ascontiguousarray(positions, dtype=float), np.ascontiguousarray(poses, dtype=float), q, within, measures,
    )  # fmt: skip
    return Candidates(q, within, measures[..., 0], measures[..., 1], measures[..., 2])
