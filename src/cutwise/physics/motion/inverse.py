"""Inverse kinematics by numbers, for arms that no closed form fits: damped least squares from several starts."""

import math

import numpy as np

from cutwise.maths.chains import Chain, fill_frames, fill_jacobian
from cutwise.maths.compiled import compiled
from cutwise.maths.frames import FloatArray


@compiled
def _fill_residual(
    frame_rotations: FloatArray, frame_origins: FloatArray, rotation: FloatArray, position: FloatArray, e: FloatArray
) -> None:
    """Position error [m] above the rotation vector [rad] from the present to the wanted pose, in frame 0."""
    last = len(frame_origins) - 1
    have = frame_rotations[last]
    turn = rotation @ have.T
    e[:3] = position - frame_origins[last]
    e[3] = 0.5 * (turn[2, 1] - turn[1, 2])
    e[4] = 0.5 * (turn[0, 2] - turn[2, 0])
    e[5] = 0.5 * (turn[1, 0] - turn[0, 1])
    sine = math.sqrt(e[3] ** 2 + e[4] ** 2 + e[5] ** 2)
    cosine = 0.5 * (turn[0, 0] + turn[1, 1] + turn[2, 2] - 1.0)
    if sine > 1e-12:
        scale = math.atan2(sine, cosine) / sine
        e[3:] *= scale
    elif cosine < 0.0:
        e[3] = math.pi  # half a turn about an axis that the skew part does not show


@compiled
def _solve_from(
    kinds: np.ndarray,
    axes: FloatArray,
    rotations: FloatArray,
    origins: FloatArray,
    rotation: FloatArray,
    position: FloatArray,
    start: FloatArray,
    length: float,
    tolerance: float,
    iterations: int,
) -> tuple[FloatArray, float]:
    count = len(kinds)
    q, tried = start.copy(), start.copy()
    all_rotations, all_origins = np.empty((1, count + 1, 3, 3)), np.empty((1, count + 1, 3))
    jacobian, e, next_e, tip = np.empty((6, count)), np.empty(6), np.empty(6), np.zeros(3)
    weight = np.array([1.0, 1.0, 1.0, length, length, length])
    damping = 1e-3
    fill_frames(kinds, axes, rotations, origins, q.reshape(1, count), all_rotations, all_origins)
    _fill_residual(all_rotations[0], all_origins[0], rotation, position, e)
    error = math.sqrt(np.sum((weight * e) ** 2))
    for _ in range(iterations):
        if error < tolerance:
            break
        fill_frames(kinds, axes, rotations, origins, q.reshape(1, count), all_rotations, all_origins)
        fill_jacobian(kinds, axes, all_rotations[0], all_origins[0], tip, jacobian)
        for row in range(6):
            jacobian[row] *= weight[row]
        normal = jacobian.T @ jacobian + damping * np.eye(count)
        tried[:] = q + np.linalg.solve(normal, jacobian.T @ (weight * e))
        fill_frames(kinds, axes, rotations, origins, tried.reshape(1, count), all_rotations, all_origins)
        _fill_residual(all_rotations[0], all_origins[0], rotation, position, next_e)
        next_error = math.sqrt(np.sum((weight * next_e) ** 2))
        if next_error < error:
            q[:], e[:], error = tried, next_e, next_error
            damping = max(damping * 0.1, 1e-14)
        else:
            damping = min(damping * 10.0, 1e6)
    return q, error


@compiled
def _solve_each(
    kinds: np.ndarray,
    axes: FloatArray,
    rotations: FloatArray,
    origins: FloatArray,
    rotation: FloatArray,
    position: FloatArray,
    starts: FloatArray,
    length: float,
    tolerance: float,
    iterations: int,
    q: FloatArray,
    errors: FloatArray,
) -> None:
    for k in range(len(starts)):
        q[k], errors[k] = _solve_from(
            kinds, axes, rotations, origins, rotation, position, starts[k], length, tolerance, iterations
        )


def polished(
    chain: Chain,
    rotation: FloatArray,
    position: FloatArray,
    starts: FloatArray,
    *,
    length: float = 1.0,
    tolerance: float = 1e-13,
    iterations: int = 15,
) -> tuple[FloatArray, FloatArray]:
    r"""Joint positions that bring the last frame to a pose, by damped least squares (Levenberg-Marquardt), from every start.

    .. math:: \Delta q = (J^T W^2 J + \lambda I)^{-1} J^T W^2 e

    :math:`\lambda` falls tenfold after a step that helps and rises tenfold after one that does not.

    Parameters
    ----------
    rotation, position : arrays (3, 3) and (3,)
        Wanted pose in frame 0 [1, m].
    starts : array (k, n)
        Joint positions to begin from.
    length : float
        What one radian of rotation counts as [m].
    tolerance : float
        Residual at which a pose is reached, as a share of ``length``.

    Returns
    -------
    tuple
        Joint positions [m or rad], shape (k, n), and their residuals [m], shape (k,): larger than the tolerance means not
        reached. Limits are not looked at, angles are not wrapped.

    References
    ----------
    Marquardt 1963, J. SIAM 11; damped least squares for arms: Wampler 1986, IEEE Trans. Syst. Man Cybern. 16.
    """
    q, errors = np.empty_like(starts), np.empty(len(starts))
    _solve_each(
        *chain.arrays, np.ascontiguousarray(rotation, dtype=float), np.ascontiguousarray(position, dtype=float),
        np.ascontiguousarray(starts), length, tolerance * length, iterations, q, errors,
    )  # fmt: skip
    return q, errors
