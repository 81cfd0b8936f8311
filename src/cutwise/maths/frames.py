"""Rotations, twists and rigid transforms: compiled kernels for one frame, NumPy where whole batches are natural.

A transform is a rotation matrix :math:`R` and a translation :math:`p`; a twist is
:math:`\\xi = (\\delta, \\varepsilon)`, displacement first [m], rotation vector second [rad]. Kernels write into buffers
that the caller owns, so that loops over postures allocate nothing.
"""

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cutwise.maths.compiled import compiled

FloatArray: TypeAlias = NDArray[np.float64]

_SERIES_BELOW = 1e-2  # rad; the first term left out is below 3e-18 there, closed forms lose digits


def skew(vector: ArrayLike) -> FloatArray:
    r"""Matrix :math:`[v]_\times` with :math:`[v]_\times w = v \times w`, for vectors of shape (..., 3)."""
    v = np.asarray(vector, dtype=float)
    matrix = np.zeros((*v.shape, 3))
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    matrix[..., 1, 0], matrix[..., 2, 0], matrix[..., 2, 1] = v[..., 2], -v[..., 1], v[..., 0]
    return matrix


@compiled
def fill_rotation_about(axis: FloatArray, angle: float, rotation: FloatArray) -> None:
    r"""Write the rotation about a unit axis into ``rotation`` (3, 3).

    .. math:: R = \cos\theta\, I + \sin\theta\, [a]_\times + (1 - \cos\theta)\, a a^T

    Parameters
    ----------
    axis : array (3,)
        Unit vector :math:`a`; not normalised here.
    angle : float
        :math:`\theta` [rad], right-handed about the axis.
    rotation : array (3, 3)
        Overwritten.

    Notes
    -----
    Valid for any angle; :math:`1 - \cos\theta` keeps its digits at small ones.

    Examples
    --------
    A right angle about z takes x to y.

    >>> turn = np.empty((3, 3))
    >>> fill_rotation_about(np.array([0.0, 0.0, 1.0]), 0.5 * math.pi, turn)
    >>> turn[:, 0].round(9).tolist()
    [0.0, 1.0, 0.0]

    References
    ----------
    Rodrigues 1840; Murray, Li and Sastry 1994, Eq. 2.14.
    """
    c, s = math.cos(angle), math.sin(angle)
    h = math.sin(0.5 * angle)
    v = 2.0 * h * h  # 1 - cos without cancellation
    x, y, z = axis[0], axis[1], axis[2]
    rotation[0, 0], rotation[0, 1], rotation[0, 2] = c + v * x * x, v * x * y - s * z, v * x * z + s * y
    rotation[1, 0], rotation[1, 1], rotation[1, 2] = v * y * x + s * z, c + v * y * y, v * y * z - s * x
    rotation[2, 0], rotation[2, 1], rotation[2, 2] = v * z * x - s * y, v * z * y + s * x, c + v * z * z


def rotation_about(axis: ArrayLike, angle: float) -> FloatArray:
    """Rotation matrix (3, 3) about an axis of any length but zero; see :func:`fill_rotation_about`.

    Raises
    ------
    ValueError
        The axis has no length.
    """
    direction = np.asarray(axis, dtype=float)
    length = float(np.linalg.norm(direction))
    if length == 0.0:
        raise ValueError("a rotation axis needs a length, got (0, 0, 0)")
    rotation = np.empty((3, 3))
    # the plain version: once a joint, and the first call of a compiled one costs a third of a second of set-up
    fill_rotation_about.py_func(direction / length, float(angle), rotation)  # type: ignore[attr-defined]
    return rotation


def rotation_from_rpy(roll: float, pitch: float, yaw: float) -> FloatArray:
    r"""Rotation of fixed-axis roll, pitch, yaw [rad]: :math:`R_z(\psi) R_y(\theta) R_x(\varphi)`, as URDF writes it.

    References
    ----------
    URDF specification, origin of a joint.
    """
    rotation = np.eye(3)
    for axis, angle in ((0, roll), (1, pitch), (2, yaw)):
        rotation = rotation_about(np.eye(3)[axis], angle) @ rotation
    return rotation


@compiled
def fill_exp(twist: FloatArray, rotation: FloatArray, translation: FloatArray) -> None:
    r"""Write the rigid motion :math:`\exp[\xi]^\wedge` of a twist into ``rotation`` and ``translation``.

    .. math::
        R = I + a E + b E^2, \quad p = (I + b E + c E^2)\,\delta, \quad E = [\varepsilon]_\times

        a = \frac{\sin\theta}{\theta},\; b = \frac{1-\cos\theta}{\theta^2},\; c = \frac{\theta-\sin\theta}{\theta^3}

    with :math:`\theta = |\varepsilon|`; power series below 0.01 rad.

    Parameters
    ----------
    twist : array (6,)
        :math:`(\delta, \varepsilon)` [m, rad].
    rotation, translation : arrays (3, 3) and (3,)
        Overwritten [1, m].

    Notes
    -----
    Valid for any twist; just above 0.01 rad b and c lose four to five digits to cancellation.

    Examples
    --------
    A quarter of a circle of 1 m, run along x while turning left, ends at (1, 1).

    >>> turn, place = np.empty((3, 3)), np.empty(3)
    >>> fill_exp(np.array([0.5 * math.pi, 0.0, 0.0, 0.0, 0.0, 0.5 * math.pi]), turn, place)
    >>> place.round(9).tolist()
    [1.0, 1.0, 0.0]

    References
    ----------
    Murray, Li and Sastry 1994, A Mathematical Introduction to Robotic Manipulation, Eqs. 2.14 and 2.36.
    """
    dx, dy, dz, x, y, z = twist[0], twist[1], twist[2], twist[3], twist[4], twist[5]
    square = x * x + y * y + z * z
    angle = math.sqrt(square)
    if angle < _SERIES_BELOW:
        a = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0))
        b = 0.5 - square / 24.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0))
        c = (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0))) / 6.0
    else:
        a = math.sin(angle) / angle
        b = (1.0 - math.cos(angle)) / square
        c = (angle - math.sin(angle)) / (square * angle)
    rotation[0, 0], rotation[0, 1], rotation[0, 2] = 1.0 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y
    rotation[1, 0], rotation[1, 1], rotation[1, 2] = b * x * y + a * z, 1.0 - b * (x * x + z * z), b * y * z - a * x
    rotation[2, 0], rotation[2, 1], rotation[2, 2] = b * x * z - a * y, b * y * z + a * x, 1.0 - b * (x * x + y * y)
    # e x d and e x (e x d)
    ux, uy, uz = y * dz - z * dy, z * dx - x * dz, x * dy - y * dx
    wx, wy, wz = y * uz - z * uy, z * ux - x * uz, x * uy - y * ux
    translation[0] = dx + b * ux + c * wx
    translation[1] = dy + b * uy + c * wy
    translation[2] = dz + b * uz + c * wz


@compiled
def multiply_onto(
    rotation: FloatArray, translation: FloatArray, by_rotation: FloatArray, by_translation: FloatArray
) -> None:
    r"""Compose in place: :math:`(R, p) \leftarrow (R, p)\,(R_b, p_b) = (R R_b,\; R p_b + p)`.

    Parameters
    ----------
    rotation, translation : arrays (3, 3) and (3,)
        R and p [m], overwritten.
    by_rotation, by_translation : arrays (3, 3) and (3,)
        :math:`R_b` and :math:`p_b` [m]; not the same arrays.

    Notes
    -----
    Valid for any matrices; rotations drift from orthogonal by rounding alone, 1e-16 a factor.

    Examples
    --------
    1 m along x, a right angle to the left, and 1 m on:

    >>> turn, place = rotation_about([0, 0, 1], 0.5 * math.pi), np.array([1.0, 0.0, 0.0])
    >>> multiply_onto(turn, place, np.eye(3), np.array([1.0, 0.0, 0.0]))
    >>> place.round(9).tolist()
    [1.0, 1.0, 0.0]

    References
    ----------
    Murray, Li and Sastry 1994, ch. 2, sec. 3.1: homogeneous transforms.
    """
    x, y, z = by_translation[0], by_translation[1], by_translation[2]
    for row in range(3):
        first, second, third = rotation[row, 0], rotation[row, 1], rotation[row, 2]
        translation[row] += first * x + second * y + third * z
        for column in range(3):
            rotation[row, column] = (
                first * by_rotation[0, column] + second * by_rotation[1, column] + third * by_rotation[2, column]
            )


@compiled
def _fill_exp_of_each(twists: FloatArray, rotations: FloatArray, translations: FloatArray) -> None:
    for k in range(len(twists)):
        fill_exp(twists[k], rotations[k], translations[k])


def exp_twists(twists: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Rotations (..., 3, 3) and translations (..., 3) of twists (..., 6); see :func:`fill_exp`."""
    given = np.asarray(twists, dtype=float)
    flat = np.ascontiguousarray(given.reshape(-1, 6))
    rotations, translations = np.empty((len(flat), 3, 3)), np.empty((len(flat), 3))
    _fill_exp_of_each(flat, rotations, translations)
    return rotations.reshape(*given.shape[:-1], 3, 3), translations.reshape(*given.shape[:-1], 3)


def inverse(rotation: FloatArray, translation: FloatArray) -> tuple[FloatArray, FloatArray]:
    r"""Inverse motion :math:`(R^T, -R^T p)`, batched over leading axes."""
    turned = np.swapaxes(rotation, -1, -2)
    return turned, -np.einsum("...ij,...j->...i", turned, translation)


def twist_at(twist: ArrayLike, shift: ArrayLike) -> FloatArray:
    r"""The same small motion at a point shifted by ``shift``: :math:`(\delta + \varepsilon \times s, \varepsilon)`.

    Shapes (..., 6) and (..., 3) broadcast.
    """
    xi = np.asarray(twist, dtype=float)
    moved = xi[..., :3] + np.cross(xi[..., 3:], np.asarray(shift, dtype=float))
    return np.concatenate([moved, np.broadcast_to(xi[..., 3:], moved.shape)], axis=-1)


def twist_after_motion(twist: ArrayLike, rotation: ArrayLike, translation: ArrayLike) -> FloatArray:
    r"""Twist in the frame after a motion that equals a given twist before it.

    .. math:: \varepsilon' = R^T \varepsilon, \qquad \delta' = R^T (\delta + \varepsilon \times d)

    so that :math:`\exp[\xi]^\wedge (R, d) = (R, d) \exp[\xi']^\wedge` exactly. Location errors of rotary axes
    (ISO 230-7) are constant twists before the rotation.

    Parameters
    ----------
    twist : array (..., 6)
        :math:`(\delta, \varepsilon)` before the motion [m, rad].
    rotation, translation : arrays (..., 3, 3) and (..., 3)
        The motion :math:`(R, d)`.
    """
    carried = twist_at(twist, translation)
    turned = np.swapaxes(np.asarray(rotation, dtype=float), -1, -2)
    displacement = np.einsum("...ij,...j->...i", turned, carried[..., :3])
    angles = np.einsum("...ij,...j->...i", turned, carried[..., 3:])
    return np.concatenate([displacement, angles], axis=-1)
