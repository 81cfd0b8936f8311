r"""Closed-form inverse kinematics of six-axis arms whose last three axes meet in one point.

The arm is reduced to a canonical one: z along axis 1, y along axis 2 (either way, so that the shoulder lies at positive
x), origin on axis 1 level with axis 2; wrist frame x along axis 4, y along axis 5. Signs and zero positions of the
joints then vanish into a handful of constants, and any arm of this family (KUKA, ABB, Fanuc, Stäubli; upper arm lying
or standing at zero) is the same arm.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.chains import REVOLUTE, Chain, frames
from cutwise.maths.compiled import compiled
from cutwise.maths.frames import FloatArray

BRANCHES = 8  # front or back, elbow up or down, wrist flipped or not
REACHED, TOO_FAR, TOO_NEAR, ON_COLUMN = 0, 1, 2, 3

_ROUNDING = 1e-12  # relative: an arm at full stretch still reaches
_AT_LIMIT = 1e-11  # rad
_MEETS = 1e-6  # m or rad: deviation from a spherical wrist that is still called one; the rest is an error of position


class WristArm(NamedTuple):
    """Constants of a spherical-wrist arm, from :func:`spherical_wrist`."""

    base: FloatArray  # axes of the arm frame in frame 0, as columns, shape (3, 3)
    foot: FloatArray  # [m] origin of the arm frame in frame 0, shape (3,)
    plane: FloatArray  # a1, upper arm L2, forearm L3 [m], their angles at zero [rad], side offset [m], shape (6,)
    signs: FloatArray  # +1 or -1: axes 2 and 3 point along or against y of the arm frame, shape (2,)
    wrist_in: FloatArray  # axes of the wrist frame in the arm frame at zero, as columns, shape (3, 3)
    wrist_out: FloatArray  # flange rotation at zero seen from the tilted wrist frame, shape (3, 3)
    bend: float  # [rad] angle from axis 4 to axis 6 about axis 5 at zero
    centre: FloatArray  # [m] wrist centre in the last frame, shape (3,)


class NotSphericalError(ValueError):
    """The chain has no spherical wrist, or its first axes do not form the usual arm; the message says which."""


def _nearest_point(point: FloatArray, axis: FloatArray, other: FloatArray, other_axis: FloatArray) -> FloatArray:
    """Middle of the shortest segment between two lines that are not parallel [m]."""
    normal = np.cross(axis, other_axis)
    s, t, _ = np.linalg.solve(np.stack([axis, -other_axis, normal], axis=1), other - point)
    return np.asarray(0.5 * (point + s * axis + other + t * other_axis))


def _unsuitable(axes: FloatArray, points: FloatArray) -> str:
    """Why six axes at zero are no spherical-wrist arm; empty if they are."""
    if abs(axes[0] @ axes[1]) > _MEETS:
        return "axis 2 is not at a right angle to axis 1"
    if np.linalg.norm(np.cross(axes[1], axes[2])) > _MEETS:
        return "axis 3 is not parallel to axis 2"
    if abs(axes[3] @ axes[4]) > _MEETS or abs(axes[4] @ axes[5]) > _MEETS:
        return "axis 5 is not at a right angle to axes 4 and 6"
    centre = _nearest_point(points[3], axes[3], points[4], axes[4])
    for k in (3, 4, 5):
        gap = float(np.linalg.norm(np.cross(centre - points[k], axes[k])))
        if gap > _MEETS:
            return f"axis {k + 1} misses the wrist centre by {gap * 1e3:.3g} mm"
    return ""


def spherical_wrist(chain: Chain) -> WristArm:
    """Reduce a chain of six turning joints to the canonical arm.

    Raises
    ------
    NotSphericalError
        Not six turning joints, axes 2 and 3 not parallel or not square to axis 1, or no common wrist centre.

    References
    ----------
    Pieper 1968; the reduction to one arm is derived here.
    """
    if len(chain.kinds) != 6 or not np.all(chain.kinds == REVOLUTE):
        raise NotSphericalError("the closed form needs six turning joints")
    at = frames(chain, np.zeros(6))
    axes = np.einsum("kij,kj->ki", at.rotations[1:], chain.axes)
    points = at.origins[1:]
    reason = _unsuitable(axes, points)
    if reason:
        raise NotSphericalError(reason)
    z = axes[0]
    foot = points[0] + ((points[1] - points[0]) @ z) * z
    offset = np.cross(axes[1], z) @ (points[1] - foot)
    y = -axes[1] if offset < 0.0 else axes[1]
    base = np.stack([np.cross(y, z), y, z], axis=1)
    shoulder, elbow = base.T @ (points[1] - foot), base.T @ (points[2] - foot)
    centre = _nearest_point(points[3], axes[3], points[4], axes[4])
    wrist = base.T @ (centre - foot)
    upper, fore = elbow - shoulder, wrist - elbow
    plane = np.array([
        shoulder[0], math.hypot(upper[0], upper[2]), math.hypot(fore[0], fore[2]),
        math.atan2(-upper[2], upper[0]), math.atan2(-fore[2], fore[0]), wrist[1],
    ])  # fmt: skip
    x4, y5, x6 = (base.T @ axes[k] for k in (3, 4, 5))
    wrist_in = np.stack([x4, y5, np.cross(x4, y5)], axis=1)
    turned = wrist_in.T @ x6
    bend = math.atan2(-turned[2], turned[0])
    tilt = np.array([[math.cos(bend), 0, math.sin(bend)], [0, 1, 0], [-math.sin(bend), 0, math.cos(bend)]])
    # R_06 R_06(0)^T base wrist_in tilt = base Rz Ry wrist_in Rx Ry Rx
    wrist_out = at.rotations[6].T @ base @ wrist_in @ tilt
    return WristArm(
        np.ascontiguousarray(base), foot, plane, np.sign(axes[1:3] @ y), np.ascontiguousarray(wrist_in),
        np.ascontiguousarray(wrist_out), bend, at.rotations[6].T @ (centre - at.origins[6]),
    )  # fmt: skip


@compiled
def wrapped(angle: float, low: float, high: float) -> float:
    r"""The angle [rad] within half a turn of zero, or as many turns further as bring it within the limits.

    An angle beyond a limit by no more than rounding is the limit.

    Parameters
    ----------
    angle : float
        [rad]
    low, high : float
        Limits of the joint [rad].

    Returns
    -------
    float
        Angle [rad], :math:`\alpha + 2\pi k`; within half a turn of zero, and out of the limits, where no turn brings it in.

    Notes
    -----
    Valid for joints whose limits lie any number of turns apart; the solution nearest to zero is taken, not the one
    nearest to a posture.

    Examples
    --------
    Three quarters of a turn are a quarter back, unless the joint only turns forward.

    >>> [round(wrapped(1.5 * math.pi, low, high) / math.pi, 9) for low, high in ((-3.2, 3.2), (0.0, 6.0))]
    [-0.5, 1.5]

    References
    ----------
    Derived here.
    """
    turn = 2.0 * math.pi
    value = angle - turn * math.floor((angle + math.pi) / turn)
    if value > high + _AT_LIMIT:
        further = value - turn * math.ceil((value - high - _AT_LIMIT) / turn)
    elif value < low - _AT_LIMIT:
        further = value + turn * math.ceil((low - value - _AT_LIMIT) / turn)
    else:
        further = value
    if low - _AT_LIMIT <= further <= high + _AT_LIMIT:
        return min(max(further, low), high)
    return value


@compiled
def _fill_wrist_angles(n: FloatArray, bend: float, flip: float, q: FloatArray) -> None:
    r"""Angles 4 to 6 from :math:`N = R_x(q_4) R_y(q_5 + \eta) R_x(q_6)`; ``flip`` +1 or -1 is the sign of the sine."""
    sine = math.hypot(n[0, 1], n[0, 2])
    if sine > 1e-9:
        q[4] = math.atan2(flip * sine, n[0, 0]) - bend
        q[3] = math.atan2(flip * n[1, 0], -flip * n[2, 0])
        q[5] = math.atan2(flip * n[0, 1], flip * n[0, 2])
    else:  # axes 4 and 6 in line: only their sum is defined, axis 4 stays at zero
        q[4] = (0.0 if n[0, 0] > 0.0 else math.pi) - bend
        q[3] = 0.0
        q[5] = math.atan2(n[2, 1] if n[0, 0] > 0.0 else -n[2, 1], n[1, 1])


@compiled
def _fill_wrist_matrix(
    arm: WristArm, rotation: FloatArray, q1: float, q23: float, n: FloatArray, work: FloatArray
) -> None:
    r""":math:`N = W^T (R_z R_y)^T B^T R_{06} W_\mathrm{out}`: what is left for the wrist to turn."""
    c1, s1, c, s = math.cos(q1), math.sin(q1), math.cos(q23), math.sin(q23)
    for column in range(3):
        x, y, z = 0.0, 0.0, 0.0
        for k in range(3):  # B^T R_06 W_out, one column
            entry = 0.0
            for inner in range(3):
                entry += rotation[k, inner] * arm.wrist_out[inner, column]
            x += arm.base[k, 0] * entry
            y += arm.base[k, 1] * entry
            z += arm.base[k, 2] * entry
        forward, side = c1 * x + s1 * y, -s1 * x + c1 * y
        work[0, column], work[1, column], work[2, column] = c * forward - s * z, side, s * forward + c * z
    for row in range(3):
        for column in range(3):
            n[row, column] = (
                arm.wrist_in[0, row] * work[0, column]
                + arm.wrist_in[1, row] * work[1, column]
                + arm.wrist_in[2, row] * work[2, column]
            )


@compiled
def fill_branches(
    arm: WristArm,
    rotation: FloatArray,
    position: FloatArray,
    solutions: FloatArray,
    n: FloatArray,
    work: FloatArray,
) -> int:
    r"""All joint angles that bring the last frame to a pose; limits are not looked at.

    Branch :math:`4 b + 2 e + f`: base turned front (0) or back (1), elbow, wrist flip. Angles are not wrapped. Rows
    that no posture fits are NaN.

    .. math:: q_1 = \operatorname{atan2}(w_y, w_x) - \operatorname{atan2}(d, \pm\sqrt{w_x^2 + w_y^2 - d^2}), \qquad
              \cos\delta = \frac{x^2 + w_z^2 - L_2^2 - L_3^2}{2 L_2 L_3}

    for the wrist centre w in the arm frame, the side offset d, and x from axis 2 in the plane of the arm; the wrist turns
    what is left, :math:`N = R_x(q_4) R_y(q_5 + \eta) R_x(q_6)`.

    Parameters
    ----------
    arm : WristArm
        Constants of the arm.
    rotation, position : arrays (3, 3) and (3,)
        Wanted pose of the last frame in frame 0 [1, m].
    solutions : array (8, 6)
        Overwritten [rad].
    n, work : arrays (3, 3)
        Scratch.

    Returns
    -------
    int
        ``REACHED`` if at least one branch exists; else ``TOO_FAR``, ``TOO_NEAR`` (the elbow cannot fold so far) or
        ``ON_COLUMN`` (inside the cylinder that a side offset leaves free).

    Notes
    -----
    Valid for arms that :func:`spherical_wrist` accepts. Where axes 4 and 6 are in line (sine below 1e-9) axis 4 stays at
    zero; a wrist centre on axis 1 gives one of many base angles.

    Examples
    --------
    An arm of 0.6 and 0.5 m, 0.4 m high; its own posture is among the eight.

    >>> from cutwise.maths.chains import chain
    >>> z, y, x = (0, 0, 1), (0, 1, 0), (1, 0, 0)
    >>> links = [(0, 0, 0), (0, 0, 0.4), (0.6, 0, 0), (0.5, 0, 0), (0, 0, 0), (0, 0, 0)]
    >>> serial = chain([REVOLUTE] * 6, [z, y, y, x, y, x], links)
    >>> q = np.array([0.3, -0.7, 0.9, 0.4, 0.6, -0.2])
    >>> at, found = frames(serial, q), np.empty((8, 6))
    >>> arm, scratch = spherical_wrist(serial), np.empty((2, 3, 3))
    >>> fill_branches(arm, at.rotations[6], at.origins[6], found, scratch[0], scratch[1]) == REACHED
    True
    >>> int(np.isfinite(found).all(axis=1).sum()), round(float(np.abs(found - q).max(axis=1).min()), 9)
    (8, 0.0)

    References
    ----------
    Pieper 1968 (arms with three axes through one point); the reduction to one arm is derived here.
    """
    w0, w1, w2 = 0.0, 0.0, 0.0
    for k in range(3):
        gap = position[k] - arm.foot[k]
        for inner in range(3):
            gap += rotation[k, inner] * arm.centre[inner]
        w0 += arm.base[k, 0] * gap
        w1 += arm.base[k, 1] * gap
        w2 += arm.base[k, 2] * gap
    solutions[:, :] = math.nan
    a1, upper, fore, upper0, fore0, side = arm.plane
    square = w0 * w0 + w1 * w1 - side * side
    if square < -_ROUNDING * (a1 + upper + fore) ** 2:
        return ON_COLUMN
    square = max(square, 0.0)
    outcome = TOO_FAR
    for back in range(2):
        across = math.sqrt(square) * (1.0 - 2.0 * back)
        q1 = math.atan2(w1, w0) - math.atan2(side, across)
        x = across - a1
        cosine = (x * x + w2 * w2 - upper * upper - fore * fore) / (2.0 * upper * fore)
        if cosine > 1.0 + _ROUNDING or cosine < -1.0 - _ROUNDING:
            if outcome != REACHED and cosine < -1.0:
                outcome = TOO_NEAR
            continue
        outcome = REACHED
        for elbow in range(2):
            delta = math.acos(min(1.0, max(-1.0, cosine))) * (1.0 - 2.0 * elbow)
            psi2 = math.atan2(-w2, x) - math.atan2(fore * math.sin(delta), upper + fore * math.cos(delta))
            q2, q23 = psi2 - upper0, psi2 + delta - fore0
            _fill_wrist_matrix(arm, rotation, q1, q23, n, work)
            for flip in range(2):
                row = solutions[4 * back + 2 * elbow + flip]
                row[0], row[1], row[2] = q1, arm.signs[0] * q2, arm.signs[1] * (q23 - q2)
                _fill_wrist_angles(n, arm.bend, 1.0 - 2.0 * flip, row)
    return outcome


def reach_margin(arm: WristArm, rotation: FloatArray, position: FloatArray) -> tuple[float, float]:
    r"""How far the wrist centre is inside the outer and the inner reach, best of front and back [m].

    Outer: :math:`L_2 + L_3 - d`; inner: :math:`d - |L_2 - L_3|`, with :math:`d` from axis 2 to the wrist centre in the
    plane of the arm. A negative value is how much is missing.

    References
    ----------
    Derived here: triangle inequality.
    """
    wrist = arm.base.T @ (position + rotation @ arm.centre - arm.foot)
    a1, upper, fore, _, _, side = arm.plane
    across = math.sqrt(max(wrist[0] ** 2 + wrist[1] ** 2 - side**2, 0.0))
    distances = [math.hypot(sign * across - a1, wrist[2]) for sign in (1.0, -1.0)]
    margins = [(upper + fore - d, d - abs(upper - fore)) for d in distances]
    return max(margins, key=min)


def wrist_sine(arm: WristArm, q5: FloatArray | float) -> FloatArray:
    """|sin| of the angle between axes 4 and 6: zero where the wrist is singular.

    References
    ----------
    Derived here from the wrist of Pieper 1968.
    """
    return np.asarray(np.abs(np.sin(np.asarray(q5) + arm.bend)))
