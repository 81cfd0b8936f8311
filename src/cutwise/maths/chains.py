"""One generic serial chain: machine tools from part to tool, robots from base to tool.

Frame 0 is the part (machine) or the base (robot); joint i carries frame i on frame i-1:

.. math:: H_{i-1,i}(q_i) = (R_i, K_i)\\, M_i(q_i), \\qquad
          M_i = \\text{Trans}(a_i q_i) \\text{ or } \\text{Rot}(a_i, q_i) \\text{ or } I

with the fixed origin :math:`(R_i, K_i)` and the axis :math:`a_i` written in the joint's own frame, as URDF does. The
tool point :math:`r_n` is given in the last frame. Compiled loops run over postures; they take the chain as bare arrays
(``chain.arrays``) and fill buffers, and are the same for one posture and for 10⁵.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cutwise.maths.compiled import compiled
from cutwise.maths.frames import FloatArray, fill_exp, fill_rotation_about, multiply_onto

FIXED, PRISMATIC, REVOLUTE = 0, 1, 2


class Chain(NamedTuple):
    """A serial chain of n joints; see :func:`chain` for a checked one."""

    kinds: np.ndarray  # FIXED, PRISMATIC or REVOLUTE, int64, shape (n,)
    axes: FloatArray  # unit vectors in the joint's frame, shape (n, 3); anything for a fixed joint
    rotations: FloatArray  # fixed rotation R_i of the joint's frame in frame i-1, shape (n, 3, 3)
    origins: FloatArray  # [m] K_i: origin of the joint's frame in frame i-1, shape (n, 3)
    sides: np.ndarray  # +1 the tool-side body i is the one that moves, -1 the part-side body i-1, int64, shape (n,)

    @property
    def arrays(self) -> tuple[np.ndarray, FloatArray, FloatArray, FloatArray]:
        """What the kernels take: kinds, axes, rotations, origins."""
        return self.kinds, self.axes, self.rotations, self.origins


class Frames(NamedTuple):
    """Frames 0 ... n of a chain seen from frame 0, for each posture."""

    rotations: FloatArray  # R_0i, shape (..., n + 1, 3, 3)
    origins: FloatArray  # [m] o_i in frame 0, shape (..., n + 1, 3)


def chain(
    kinds: ArrayLike,
    axes: ArrayLike,
    origins: ArrayLike,
    *,
    rotations: ArrayLike | None = None,
    sides: ArrayLike | None = None,
) -> Chain:
    """A chain with its axes normalised.

    Parameters
    ----------
    kinds : array of int (n,)
        :data:`FIXED`, :data:`PRISMATIC` or :data:`REVOLUTE`.
    axes : array (n, 3)
        Any length but zero for moving joints.
    origins : array (n, 3)
        Offsets [m].
    rotations : array (n, 3, 3), optional
        Fixed rotations; identity by default.
    sides : array of int (n,), optional
        +1 (default) or -1; matters for errors only, not for where the tool is.

    Raises
    ------
    ValueError
        An axis without length, or an unknown kind of joint.
    """
    kind = np.ascontiguousarray(kinds, dtype=np.int64)
    count = len(kind)
    unit = np.array(axes, dtype=float).reshape(count, 3)
    lengths = np.linalg.norm(unit, axis=1)
    for i in range(count):
        if kind[i] not in (FIXED, PRISMATIC, REVOLUTE):
            raise ValueError(f"joint {i + 1} is of kind {kind[i]}; expected fixed (0), prismatic (1) or revolute (2)")
        if kind[i] != FIXED and not lengths[i] > 0.0:
            raise ValueError(f"joint {i + 1} moves along or about an axis of zero length")
    unit /= np.where(lengths > 0.0, lengths, 1.0)[:, None]
    turned = np.tile(np.eye(3), (count, 1, 1)) if rotations is None else np.array(rotations, dtype=float)
    side = np.ones(count, dtype=np.int64) if sides is None else np.ascontiguousarray(sides, dtype=np.int64)
    return Chain(kind, unit, np.ascontiguousarray(turned), np.array(origins, dtype=float).reshape(count, 3), side)


@compiled
def fill_joint(
    kind: int,
    axis: FloatArray,
    fixed_rotation: FloatArray,
    origin: FloatArray,
    q: float,
    rotation: FloatArray,
    translation: FloatArray,
    scratch: FloatArray,
) -> None:
    r"""Write :math:`H_{i-1,i}(q)` of one joint into ``rotation`` (3, 3) and ``translation`` (3,).

    .. math:: H = (R_i, K_i)\,(I, a q), \quad (R_i, K_i)\,(\operatorname{Rot}(a, q), 0) \quad\text{or}\quad (R_i, K_i)

    Parameters
    ----------
    kind : int
        ``PRISMATIC``, ``REVOLUTE`` or ``FIXED``.
    axis : array (3,)
        Unit vector a in the frame of the joint.
    fixed_rotation, origin : arrays (3, 3) and (3,)
        :math:`R_i` and :math:`K_i` [m] in frame i-1.
    q : float
        Position [m or rad].
    rotation, translation : arrays (3, 3) and (3,)
        Overwritten [1, m].
    scratch : array (3, 3)
        Scratch.

    Notes
    -----
    Valid for any q; the axis is not normalised here.

    Examples
    --------
    A slide that begins 1 m along x, 0.25 m out:

    >>> turn, place, x = np.empty((3, 3)), np.empty(3), np.array([1.0, 0.0, 0.0])
    >>> fill_joint(PRISMATIC, x, np.eye(3), x, 0.25, turn, place, np.empty((3, 3)))
    >>> place.tolist()
    [1.25, 0.0, 0.0]

    References
    ----------
    Demeč and Madáč, Eq. (1): :math:`R_{i,i-1}, T_{i,i-1}, K_{i,i-1}`.
    """
    for row in range(3):
        translation[row] = origin[row]
        if kind == PRISMATIC:
            for column in range(3):
                translation[row] += fixed_rotation[row, column] * axis[column] * q
    if kind == REVOLUTE:
        fill_rotation_about(axis, q, scratch)
        for row in range(3):
            for column in range(3):
                rotation[row, column] = (
                    fixed_rotation[row, 0] * scratch[0, column]
                    + fixed_rotation[row, 1] * scratch[1, column]
                    + fixed_rotation[row, 2] * scratch[2, column]
                )
    else:
        rotation[:, :] = fixed_rotation


@compiled
def fill_frames(
    kinds: np.ndarray,
    axes: FloatArray,
    rotations: FloatArray,
    origins: FloatArray,
    postures: FloatArray,
    frame_rotations: FloatArray,
    frame_origins: FloatArray,
) -> None:
    r"""Frames 0 ... n for each posture: :math:`H_{0i} = \prod_{j \le i} H_{j-1,j}(q_j)`.

    Parameters
    ----------
    kinds, axes, rotations, origins : arrays
        ``chain.arrays``.
    postures : array (m, n)
        Joint positions [m or rad]; the value of a fixed joint is ignored.
    frame_rotations, frame_origins : arrays (m, n + 1, 3, 3) and (m, n + 1, 3)
        Overwritten [1, m].

    Notes
    -----
    Valid for rigid bodies; errors of motion are put on by :func:`linear_error` and :func:`exact_error`.

    Examples
    --------
    Two joints 1 m apart, the first turned by a right angle:

    >>> two = chain([REVOLUTE, REVOLUTE], [(0, 0, 1), (0, 0, 1)], [(0, 0, 0), (1, 0, 0)])
    >>> turns, places = np.empty((1, 3, 3, 3)), np.empty((1, 3, 3))
    >>> fill_frames(*two.arrays, np.array([[0.5 * np.pi, 0.0]]), turns, places)
    >>> places[0, 2].round(9).tolist()
    [0.0, 1.0, 0.0]

    References
    ----------
    Demeč and Madáč, Eq. (1), with the product taken in order.
    """
    step_rotation, scratch, rotation = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    step, origin = np.empty(3), np.empty(3)
    for k in range(postures.shape[0]):
        rotation[:, :] = 0.0
        for row in range(3):
            rotation[row, row] = 1.0
            origin[row] = 0.0
        frame_rotations[k, 0] = rotation
        frame_origins[k, 0] = origin
        for i in range(len(kinds)):
            fill_joint(kinds[i], axes[i], rotations[i], origins[i], postures[k, i], step_rotation, step, scratch)
            multiply_onto(rotation, origin, step_rotation, step)
            frame_rotations[k, i + 1] = rotation
            frame_origins[k, i + 1] = origin


@compiled
def fill_jacobian(
    kinds: np.ndarray,
    axes: FloatArray,
    frame_rotations: FloatArray,
    frame_origins: FloatArray,
    tip: FloatArray,
    jacobian: FloatArray,
) -> None:
    r"""Geometric Jacobian of one posture, velocity of the tool point above angular velocity, in frame 0.

    .. math:: J_i = (a_i \times (p - o_i);\; a_i) \text{ revolute}, \quad (a_i;\; 0) \text{ prismatic}

    and zero for a fixed joint.

    Parameters
    ----------
    kinds, axes : arrays (n,) and (n, 3)
        Of the chain.
    frame_rotations, frame_origins : arrays (n + 1, 3, 3) and (n + 1, 3)
        One posture from :func:`fill_frames` [1, m].
    tip : array (3,)
        Tool point in the last frame [m].
    jacobian : array (6, n)
        Overwritten [m/rad, 1; rad/rad, 0 per m].

    Notes
    -----
    Valid in any posture, a singular one too; the side on which a joint's body moves does not count.

    Examples
    --------
    Two joints 1 m apart, stretched, the tool 1 m farther on: it moves by 2 m and 1 m per radian.

    >>> two = chain([REVOLUTE, REVOLUTE], [(0, 0, 1), (0, 0, 1)], [(0, 0, 0), (1, 0, 0)])
    >>> at, matrix = frames(two, np.zeros(2)), np.empty((6, 2))
    >>> fill_jacobian(two.kinds, two.axes, at.rotations, at.origins, np.array([1.0, 0.0, 0.0]), matrix)
    >>> matrix[1].tolist()
    [2.0, 1.0]

    References
    ----------
    E.g. Siciliano et al. 2009, Robotics, sec. 3.1.
    """
    count = len(kinds)
    p0, p1, p2 = frame_origins[count, 0], frame_origins[count, 1], frame_origins[count, 2]
    for column in range(3):
        p0 += frame_rotations[count, 0, column] * tip[column]
        p1 += frame_rotations[count, 1, column] * tip[column]
        p2 += frame_rotations[count, 2, column] * tip[column]
    for i in range(count):
        # frame i after the motion sees the axis as the joint frame does: the motion leaves it where it is
        x = y = z = 0.0
        for column in range(3):
            x += frame_rotations[i + 1, 0, column] * axes[i, column]
            y += frame_rotations[i + 1, 1, column] * axes[i, column]
            z += frame_rotations[i + 1, 2, column] * axes[i, column]
        jacobian[:, i] = 0.0
        if kinds[i] == PRISMATIC:
            jacobian[0, i], jacobian[1, i], jacobian[2, i] = x, y, z
        elif kinds[i] == REVOLUTE:
            a, b, c = p0 - frame_origins[i + 1, 0], p1 - frame_origins[i + 1, 1], p2 - frame_origins[i + 1, 2]
            jacobian[0, i], jacobian[1, i], jacobian[2, i] = y * c - z * b, z * a - x * c, x * b - y * a
            jacobian[3, i], jacobian[4, i], jacobian[5, i] = x, y, z


@compiled
def _fill_jacobians(
    kinds: np.ndarray,
    axes: FloatArray,
    frame_rotations: FloatArray,
    frame_origins: FloatArray,
    tip: FloatArray,
    jacobians: FloatArray,
) -> None:
    for k in range(len(frame_origins)):
        fill_jacobian(kinds, axes, frame_rotations[k], frame_origins[k], tip, jacobians[k])


@compiled
def _fill_composed(
    frame_rotations: FloatArray,
    frame_origins: FloatArray,
    twists: FloatArray,
    tip: FloatArray,
    deviations: FloatArray,
) -> None:
    # H_err r_n - H r_n with H_{i-1,i} taken from neighbouring frames, so that any chain fits
    error_rotation, error_shift, rotation = np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    origin, step_rotation, step = np.empty(3), np.empty((3, 3)), np.empty(3)
    last, layers = frame_origins.shape[1] - 1, twists.shape[1]
    for k in range(len(frame_origins)):
        rotation[:, :] = 0.0
        rotation[0, 0] = rotation[1, 1] = rotation[2, 2] = 1.0
        origin[:] = 0.0
        for layer in range(layers):
            fill_exp(twists[k, layer, 0], error_rotation, error_shift)
            multiply_onto(rotation, origin, error_rotation, error_shift)
        for i in range(1, last + 1):
            for row in range(3):
                step[row] = 0.0
                for inner in range(3):
                    step[row] += frame_rotations[k, i - 1, inner, row] * (
                        frame_origins[k, i, inner] - frame_origins[k, i - 1, inner]
                    )
                for column in range(3):
                    step_rotation[row, column] = 0.0
                    for inner in range(3):
                        step_rotation[row, column] += (
                            frame_rotations[k, i - 1, inner, row] * frame_rotations[k, i, inner, column]
                        )
            multiply_onto(rotation, origin, step_rotation, step)
            for layer in range(layers):
                fill_exp(twists[k, layer, i], error_rotation, error_shift)
                multiply_onto(rotation, origin, error_rotation, error_shift)
        for row in range(3):
            deviations[k, row] = origin[row] - frame_origins[k, last, row]
            for column in range(3):
                deviations[k, row] += (rotation[row, column] - frame_rotations[k, last, row, column]) * tip[column]


def frames(given: Chain, q: ArrayLike) -> Frames:
    """Frames 0 ... n of postures ``q`` of shape (..., n); see :func:`fill_frames`."""
    postures = np.asarray(q, dtype=float)
    flat = np.ascontiguousarray(postures.reshape(-1, len(given.kinds)))
    rotations, origins = (
        np.empty((len(flat), len(given.kinds) + 1, 3, 3)),
        np.empty((len(flat), len(given.kinds) + 1, 3)),
    )
    fill_frames(*given.arrays, flat, rotations, origins)
    lead = postures.shape[:-1]
    return Frames(rotations.reshape(*lead, *rotations.shape[1:]), origins.reshape(*lead, *origins.shape[1:]))


def tool_point(at: Frames, tip: ArrayLike) -> FloatArray:
    r"""Tool point in frame 0, :math:`r_0 = R_{0n} r_n + o_n` [m], (..., 3): Demeč and Madáč, Eq. (1) corrected."""
    return at.origins[..., -1, :] + np.einsum(
        "...ij,j->...i", at.rotations[..., -1, :, :], np.asarray(tip, dtype=float)
    )


def tool_vectors(at: Frames, tip: ArrayLike) -> FloatArray:
    r"""Tool point in every frame, :math:`r_i = R_{0i}^T (r_0 - o_i)` [m], (..., n + 1, 3): their Eq. (8), and r_n."""
    reach = tool_point(at, tip)[..., None, :] - at.origins
    return np.einsum("...ji,...j->...i", at.rotations, reach)


def jacobian(given: Chain, q: ArrayLike, tip: ArrayLike) -> FloatArray:
    """Geometric Jacobian (..., 6, n) of postures (..., n), in frame 0; see :func:`fill_jacobian`."""
    at = frames(given, q)
    lead, count = at.origins.shape[:-2], len(given.kinds)
    jacobians = np.empty((int(np.prod(lead, dtype=int)), 6, count))
    rotations, origins = at.rotations.reshape(-1, count + 1, 3, 3), at.origins.reshape(-1, count + 1, 3)
    _fill_jacobians(given.kinds, given.axes, rotations, origins, np.asarray(tip, dtype=float), jacobians)
    return jacobians.reshape(*lead, 6, count)


def error_jacobian(at: Frames, tip: ArrayLike) -> FloatArray:
    r"""What a small error of each body moves the tool point by: :math:`J_i = [R_{0i},\; -R_{0i} [r_i]_\times]`.

    Returns
    -------
    array (..., 3, n + 1, 6)
        :math:`\Delta = \sum_i J_i \xi_i` with :math:`\xi_i = (\delta_i, \varepsilon_i)`; one array for budget,
        sensitivities and covariance.
    """
    r = tool_vectors(at, tip)
    result = np.empty((*r.shape[:-2], 3, r.shape[-2], 6))
    result[..., :3] = np.moveaxis(at.rotations, -3, -2)
    for axis in range(3):
        unit = np.eye(3)[axis]
        result[..., 3 + axis] = np.moveaxis(np.einsum("...ij,...j->...i", at.rotations, np.cross(unit, r)), -1, -2)
    return result


def local_errors(at: Frames, twists: ArrayLike, tip: ArrayLike) -> FloatArray:
    r"""Tool-point error of a body in its own frame, :math:`\delta_i + \varepsilon_i \times r_i` [m], (..., n + 1, 3).

    References
    ----------
    Demeč and Madáč, Eqs. (3) and (4): :math:`f_{1i}`.
    """
    xi = np.asarray(twists, dtype=float)
    return xi[..., :3] + np.cross(xi[..., 3:], tool_vectors(at, tip))


def body_errors(at: Frames, twists: ArrayLike, tip: ArrayLike) -> FloatArray:
    r"""The same in frame 0, :math:`R_{0i}(\delta_i + \varepsilon_i \times r_i)` [m], (..., n + 1, 3).

    Their sum is the first-order error of the tool point; what is left out is of second order (about 0.1 % below
    1 mrad).

    References
    ----------
    Demeč and Madáč, Eq. (5) with the product up to i (printed up to n), and Eq. (2).
    """
    return np.einsum("...ij,...j->...i", at.rotations, local_errors(at, twists, tip))


def linear_error(at: Frames, twists: ArrayLike, tip: ArrayLike) -> FloatArray:
    """First-order error of the tool point [m], shape (..., 3): the sum of :func:`body_errors`.

    References
    ----------
    Demeč and Madáč, Eq. (2).
    """
    return body_errors(at, twists, tip).sum(axis=-2)


def exact_error(at: Frames, twists: ArrayLike, tip: ArrayLike, *after: ArrayLike) -> FloatArray:
    r"""Exact error of the tool point [m], shape (..., 3).

    .. math:: \Delta = \Bigl(E_0 \prod_i H_{i-1,i} E_i - \prod_i H_{i-1,i}\Bigr) r_n,
              \qquad E_i = \exp[\xi_i]^\wedge \exp[\xi'_i]^\wedge \dots

    Parameters
    ----------
    at : Frames
        Of the ideal chain.
    twists : array (..., n + 1, 6)
        :math:`\xi_i`, in frame i, after the motion; index 0 is the part.
    tip : array (3,)
        Tool point in the last frame [m].
    *after : arrays (..., n + 1, 6)
        Further errors :math:`\xi'_i`, one after the other; to first order their sum counts.

    References
    ----------
    Demeč and Madáč, Eq. (2), with motions of finite size in place of first-order ones.
    """
    lead, count = at.origins.shape[:-2], at.origins.shape[-2]
    layers = [np.broadcast_to(np.asarray(xi, dtype=float), (*lead, count, 6)) for xi in (twists, *after)]
    xi = np.stack([layer.reshape(-1, count, 6) for layer in layers], axis=1)
    deviations = np.empty((len(xi), 3))
    rotations, origins = at.rotations.reshape(-1, count, 3, 3), at.origins.reshape(-1, count, 3)
    _fill_composed(rotations, origins, xi, np.asarray(tip, dtype=float), deviations)
    return deviations.reshape(*lead, 3)
