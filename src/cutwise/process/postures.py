"""Postures in which an arm can drill: every solution of every pose, with its axial compliance and skating ratio.

The drill may be turned about its axis (redundancy angle), and every pose has up to 8 solutions with a spherical wrist,
up to 16 otherwise. A candidate is one of these solutions within the limits, with its axial compliance and skating
ratio. Angles are those of the motors, which are the joint angles unless joints are coupled.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.chains import Chain, fill_frames, fill_jacobian, frames, jacobian
from cutwise.maths.compiled import compiled
from cutwise.maths.frames import FloatArray
from cutwise.physics.motion.coupled import Drives, SixAxes, direct, is_direct, six_axes
from cutwise.physics.motion.elimination import MOST, Elimination, all_postures, elimination
from cutwise.physics.motion.inverse import polished
from cutwise.physics.motion.wrist import (
    BRANCHES,
    NotSphericalError,
    WristArm,
    fill_branches,
    spherical_wrist,
    wrapped,
)
from cutwise.physics.structure.joint_compliance import axial_and_holding
from cutwise.physics.structure.series_compliance import (
    carried_to,
)

_CHECKS = 64  # starts by numbers before a pose is called out of reach


class Springs(NamedTuple):
    """Springs of the bodies of an arm besides its joints: rotations and translations of their frames, k of them."""

    frame: np.ndarray  # 0: the base; n: after the turn of joint n
    turns: np.ndarray  # rotation, else translation
    axis: FloatArray  # in that frame (k, 3)
    point: FloatArray  # [m] of a rotation, in that frame (k, 3)
    carries: (
        np.ndarray
    )  # number of the first link that moves with it, from 0; as many as there are joints: the tool alone


NO_SPRINGS = Springs(
    np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.bool_), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0, dtype=np.int64)
)  # fmt: skip


class Arm(NamedTuple):
    """A robot with its drill; :func:`arm_with` finds its inverse kinematics."""

    chain: Chain  # all joints, n
    drives: Drives  # how motors turn them
    axes: SixAxes  # six turning axes that do the same
    wrist: WristArm | None  # of these, in closed form; None: no spherical wrist
    general: Elimination | None  # of these, if there is no closed form
    not_spherical: str  # why there is no closed form; empty if there is one
    limits: FloatArray  # [rad] of the motors, shape (6, 2)
    stiffness: FloatArray  # of everything that yields: joints at their output [N m/rad], then springs [N m/rad, N/m]
    tool_rotation: FloatArray  # tool axes in the last frame, as columns, shape (3, 3)
    tool_tip: FloatArray  # [m] drill tip in the last frame, shape (3,)
    base: FloatArray  # compliance of what the arm stands on, at the origin and in the axes of its base, shape (6, 6)
    springs: Springs


def arm_with(
    chain: Chain,
    limits: FloatArray,
    stiffness: FloatArray,
    tool_rotation: FloatArray,
    tool_tip: FloatArray,
    *,
    drives: Drives | None = None,
    base: FloatArray | None = None,
    springs: Springs = NO_SPRINGS,
) -> Arm:
    """An arm with its inverse kinematics: closed form for a spherical wrist, elimination for every other.

    Raises
    ------
    NotSixAxesError
        Coupled joints that do not reduce to six axes.
    """
    drives = direct(len(chain.kinds)) if drives is None else drives
    axes = six_axes(chain, drives)
    wrist, general, reason = None, None, ""
    try:
        wrist = spherical_wrist(axes.chain)
    except NotSphericalError as fault:
        reason, general = str(fault), elimination(axes.chain)
    base = np.zeros((6, 6)) if base is None else base
    return Arm(chain, drives, axes, wrist, general, reason, limits, stiffness, tool_rotation, tool_tip, base, springs)


class Candidates(NamedTuple):
    """All solutions of m poses, b for each; NaN where a branch does not exist or is beyond a limit."""

    q: FloatArray  # [rad] of the motors, shape (m, b, 6); given also beyond the limits
    within: np.ndarray  # within the joint limits, bool, shape (m, b)
    compliance: FloatArray  # C_zz [m/N] along the drill axis, shape (m, b)
    holding: FloatArray  # lateral force over thrust that holds the tip, tool axes, shape (m, b, 2)
    wrist_sine: FloatArray  # |sin| of the wrist angle, shape (m, b)

    @property
    def skating(self) -> FloatArray:
        """Skating ratio at a flat entry, shape (m, b)."""
        return np.asarray(np.hypot(self.holding[..., 0], self.holding[..., 1]))


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
def _translation_measures(
    jac: FloatArray, elastic: FloatArray, axes: FloatArray, stiffness: FloatArray, base: FloatArray, result: FloatArray
) -> None:
    """Axial compliance and holding force over thrust of one posture: the translation block of C, in tool axes.

    ``base``: what the base adds to xx, xy, yy, xz, yz, zz of that block [m/N].
    """
    xx, xy, yy, xz, yz, zz = base[0], base[1], base[2], base[3], base[4], base[5]
    for i in range(elastic.shape[1]):
        x, y, z = 0.0, 0.0, 0.0
        for k in range(3):
            along = 0.0
            for joint in range(len(elastic)):
                along += jac[k, joint] * elastic[joint, i]
            x += axes[k, 0] * along
            y += axes[k, 1] * along
            z += axes[k, 2] * along
        yielding = 1.0 / stiffness[i]
        xx += x * x * yielding
        xy += x * y * yielding
        yy += y * y * yielding
        xz += x * z * yielding
        yz += y * z * yielding
        zz += z * z * yielding
    result[0] = zz
    result[1], result[2] = axial_and_holding(xx, xy, yy, xz, yz)


@compiled
def _add_springs(
    springs: Springs,
    stiffness: FloatArray,
    rotations: FloatArray,
    origins: FloatArray,
    tip: FloatArray,
    axes: FloatArray,
    result: FloatArray,
) -> None:
    """What springs of bodies add to xx, xy, yy, xz, yz, zz of the compliance at the tip, in tool axes [m/N]."""
    last = len(origins) - 1
    a, p, moved = np.empty(3), np.empty(3), np.empty(3)
    for s in range(len(springs.frame)):
        f = springs.frame[s]
        for i in range(3):
            a[i], p[i] = 0.0, origins[last, i] - origins[f, i]
            for k in range(3):
                a[i] += rotations[f, i, k] * springs.axis[s, k]
                p[i] += rotations[last, i, k] * tip[k] - rotations[f, i, k] * springs.point[s, k]
        if springs.turns[s]:
            moved[0] = a[1] * p[2] - a[2] * p[1]
            moved[1] = a[2] * p[0] - a[0] * p[2]
            moved[2] = a[0] * p[1] - a[1] * p[0]
        else:
            moved[:] = a
        x, y, z = 0.0, 0.0, 0.0
        for k in range(3):
            x += axes[k, 0] * moved[k]
            y += axes[k, 1] * moved[k]
            z += axes[k, 2] * moved[k]
        c = 1.0 / stiffness[s]
        result[0] += c * x * x
        result[1] += c * x * y
        result[2] += c * y * y
        result[3] += c * x * z
        result[4] += c * y * z
        result[5] += c * z * z


@compiled
def _fill_closed(
    wrist: WristArm,
    tool_rotation: FloatArray,
    tip: FloatArray,
    positions: FloatArray,
    poses: FloatArray,
    q: FloatArray,
    bent: FloatArray,
) -> None:
    """Closed-form solutions of every pose of the tool, and the |sin| of their wrists."""
    flange, place = np.empty((3, 3)), np.empty(3)
    n, work = np.empty((3, 3)), np.empty((3, 3))
    for m in range(len(positions)):
        for row in range(3):
            place[row] = positions[m, row]
            for column in range(3):
                flange[row, column] = 0.0
                for k in range(3):
                    flange[row, column] += poses[m, row, k] * tool_rotation[column, k]
            for column in range(3):
                place[row] -= flange[row, column] * tip[column]
        fill_branches(wrist, flange, place, q[m], n, work)
        for branch in range(len(q[m])):
            bent[m, branch] = abs(math.sin(q[m, branch, 4] + wrist.bend))


@compiled
def _rate(
    chain: Chain,
    drives: Drives,
    to_motors: FloatArray,
    limits: FloatArray,
    stiffness: FloatArray,
    tip: FloatArray,
    poses: FloatArray,
    base: FloatArray,
    springs: Springs,
    in_pairs: bool,
    q: FloatArray,
    within: np.ndarray,
    measures: FloatArray,
) -> None:
    """Axis angles become motor angles within the limits where they can; what is within them is measured.

    ``in_pairs``: two wrist flips stand next to one another and share one compliance, only axis 5 is reversed.
    """
    count = len(chain.kinds)
    frame_rotations, frame_origins = np.empty((1, count + 1, 3, 3)), np.empty((1, count + 1, 3))
    jac, found, motors, joints = np.empty((6, count)), np.empty(3), np.empty(6), np.empty((1, count))
    turning, others = drives.elastic.shape[1], np.empty(6)
    for m in range(q.shape[0]):
        for branch in range(q.shape[1]):
            if math.isnan(q[m, branch, 0]):
                continue
            inside = True
            for motor in range(6):
                angle = 0.0
                for axis in range(6):
                    angle += to_motors[motor, axis] * q[m, branch, axis]
                motors[motor] = wrapped(angle, limits[motor, 0], limits[motor, 1])
                inside = inside and limits[motor, 0] <= motors[motor] <= limits[motor, 1]
            for row in range(len(drives.bounded)):
                angle = 0.0
                for motor in range(6):
                    angle += drives.bounded[row, motor] * motors[motor]
                angle = wrapped(angle, drives.bounds[row, 0], drives.bounds[row, 1])
                inside = inside and drives.bounds[row, 0] <= angle <= drives.bounds[row, 1]
            q[m, branch] = motors
            within[m, branch] = inside
            if not inside:
                continue
            if not in_pairs or branch % 2 == 0 or not within[m, branch - 1]:
                for joint in range(count):
                    joints[0, joint] = drives.offsets[joint]
                    for motor in range(6):
                        joints[0, joint] += drives.rows[joint, motor] * motors[motor]
                fill_frames(
                    chain.kinds, chain.axes, chain.rotations, chain.origins, joints, frame_rotations, frame_origins
                )
                fill_jacobian(chain.kinds, chain.axes, frame_rotations[0], frame_origins[0], tip, jac)
                others[:] = base[m]
                _add_springs(springs, stiffness[turning:], frame_rotations[0], frame_origins[0], tip, poses[m], others)
                _translation_measures(jac, drives.elastic, poses[m], stiffness, others, found)
            measures[m, branch] = found


def candidates(arm: Arm, positions: FloatArray, poses: FloatArray, *, thorough: bool = False) -> Candidates:
    """All solutions of poses of the tool.

    Parameters
    ----------
    positions : array (m, 3)
        Drill tip in the base frame [m].
    poses : array (m, 3, 3)
        Tool axes as columns, from :func:`tool_axes`.
    thorough : bool
        Look for a pose that has no solution once more by numbers, from many starts: what was only not found is not
        called out of reach.
    """
    positions, poses = np.ascontiguousarray(positions, dtype=float), np.ascontiguousarray(poses, dtype=float)
    count = len(positions)
    rotation, tip = arm.axes.rotation @ arm.tool_rotation, arm.axes.origin + arm.axes.rotation @ arm.tool_tip
    if arm.wrist is not None:
        q, bent = np.empty((count, BRANCHES, 6)), np.empty((count, BRANCHES))
        _fill_closed(arm.wrist, np.ascontiguousarray(rotation), tip, positions, poses, q, bent)
    else:
        q = _eliminated(arm, positions, poses, rotation, tip, thorough=thorough)
        bent = bend(arm, q)
    within, measures = np.zeros(q.shape[:2], dtype=np.bool_), np.full((*q.shape[:2], 3), math.nan)
    _rate(
        arm.chain, arm.drives, arm.axes.to_motors, arm.limits, arm.stiffness, arm.tool_tip, poses,
        base_at(arm, positions, poses), arm.springs, arm.wrist is not None and is_direct(arm.drives), q, within, measures,
    )  # fmt: skip
    return Candidates(q, within, measures[..., 0], measures[..., 1:], np.where(within, bent, math.nan))


def base_at(arm: Arm, positions: FloatArray, poses: FloatArray) -> FloatArray:
    """What the base adds to xx, xy, yy, xz, yz, zz of the compliance at the tip, in tool axes [m/N], shape (m, 6)."""
    if not arm.base.any():
        return np.zeros((len(positions), 6))
    block = np.swapaxes(poses, -1, -2) @ carried_to(arm.base, positions)[:, :3, :3] @ poses
    return np.stack([block[:, i, k] for i, k in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))], axis=1)


def _eliminated(
    arm: Arm, positions: FloatArray, poses: FloatArray, rotation: FloatArray, tip: FloatArray, *, thorough: bool
) -> FloatArray:
    """Axis angles (m, 16, 6) of an arm without closed form; a branch keeps its place from pose to pose."""
    assert arm.general is not None
    turned = poses @ rotation.T
    places = positions - turned @ tip
    q = all_postures(arm.general, turned, places).q
    for m in np.flatnonzero(np.isnan(q[:, 0, 0])) if thorough else ():
        found, _ = by_numbers(arm, turned[m], places[m])
        q[m, : len(found)] = found[:MOST]
    for k in range(1, len(q)):
        q[k] = _in_the_order_of(q[k - 1], q[k])
    return q


def by_numbers(arm: Arm, rotation: FloatArray, place: FloatArray) -> tuple[FloatArray, float]:
    """Axis angles (k, 6) from many starts, and the residual that stays at the best [m; 1 rad counts as the reach]."""
    assert arm.general is not None
    starts = np.random.default_rng(6).uniform(-math.pi, math.pi, (_CHECKS, 6))
    scale = arm.general.scale
    q, errors = polished(arm.axes.chain, rotation, place, starts, length=scale, iterations=100)
    return q[errors < 1e-10 * scale][:1], float(errors.min())


def _in_the_order_of(before: FloatArray, q: FloatArray) -> FloatArray:
    """The solutions of a pose, each in the place of its nearest neighbour among those of the pose before."""
    ordered = np.full_like(q, math.nan)
    left = [row for row in q if not np.isnan(row[0])]
    if left and not np.isnan(before[:, 0]).all():
        apart = np.abs((np.array(left)[:, None] - before + math.pi) % (2.0 * math.pi) - math.pi).max(axis=2)
        for _ in left:
            if np.isnan(apart).all():
                break
            new, place = np.unravel_index(np.nanargmin(apart), apart.shape)
            ordered[place] = left[int(new)]
            apart[new], apart[:, place] = math.nan, math.nan
        left = [row for row in left if not (ordered == row).all(axis=1).any()]
    free = np.flatnonzero(np.isnan(ordered[:, 0]))
    for place, row in zip(free, left, strict=False):
        ordered[place] = row
    return ordered


def bend(arm: Arm, q: FloatArray) -> FloatArray:
    r"""How far axes 4, 5 and 6 are from one plane, :math:`|a_4\cdot(a_5\times a_6)|` over its largest value.

    For axes at right angles, as all offset wrists have them, this is :math:`|\sin q_5|`. Where 4 and 5, or 5 and 6, are
    parallel it says nothing, and the smallest singular value of the Jacobian over its largest takes its place.
    """
    known = ~np.isnan(q[..., 0])
    result = np.full(known.shape, math.nan)
    rows = q[known]
    chain = arm.axes.chain
    turned = np.einsum("kjab,jb->kja", frames(chain, rows).rotations[:, 1:], chain.axes)
    a4, a5, a6 = turned[:, 3], turned[:, 4], turned[:, 5]
    first, second = np.cross(a4, a5), np.cross(a5, a6)
    largest = np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)
    if len(rows) and largest.max() < 1e-6:
        values = np.linalg.svd(jacobian(chain, rows, np.zeros(3)), compute_uv=False)
        result[known] = values[:, -1] / values[:, 0]
    elif len(rows):
        result[known] = np.abs(np.sum(first * a6, axis=1)) / largest
    return result
