"""How a chain of bodies yields: loads on bodies, elements at joints, twists of the chain, and the energy of it all.

Bodies 0 (part) ... n (spindle or tool) are joined by joints 1 ... n; the ground is one of the bodies. Joints between
part and ground are on the *part side*, the others on the *tool side*. Everything here is in frame 0, to first order:
forces act at the undeformed points.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cutwise.maths.chains import Frames
from cutwise.maths.frames import FloatArray, twist_at


class Elements(NamedTuple):
    """Elastic elements at joints, in frame 0 for every posture."""

    joint: np.ndarray  # joint i that the element is in, shape (e,)
    ground: int  # body at rest; joints up to it are on the part side
    point: FloatArray  # [m] where the compliance is given, shape (..., e, 3)
    compliance: FloatArray  # [m, rad per N, N m], shape (..., e, 6, 6)

    @property
    def part_side(self) -> np.ndarray:
        """Which elements carry the part, shape (e,)."""
        return self.joint <= self.ground


class Loads(NamedTuple):
    """Forces on bodies, in frame 0 for every posture."""

    body: np.ndarray  # body that the force acts on, shape (k,)
    force: FloatArray  # [N], shape (..., k, 3)
    point: FloatArray  # [m], shape (..., k, 3)


class PartBlock(NamedTuple):
    """The part as a flexible body: what its own bending moves under the tool."""

    point: FloatArray  # [m] centre of the section at the height of the tool, shape (..., 3)
    compliance: FloatArray  # of the block up to that height, shape (..., 6, 6)


def place(at: Frames, frame: ArrayLike, point: ArrayLike, compliance: ArrayLike) -> tuple[FloatArray, FloatArray]:
    r"""Elements written in body frames, seen from frame 0: points and turned compliances for every posture.

    .. math:: c = o_b + R_{0b}\,c_b, \qquad C = \begin{bmatrix} R & 0 \\ 0 & R\end{bmatrix} C_b
              \begin{bmatrix} R & 0 \\ 0 & R\end{bmatrix}^T

    Parameters
    ----------
    at : Frames
        Of the chain, leading axes (...).
    frame : array of int (e,)
        Body in whose frame an element is written (and with which its point travels).
    point : array (e, 3)
        [m].
    compliance : array (e, 6, 6)
        Or with the leading axes of the frames.

    Returns
    -------
    points, compliances : arrays (..., e, 3) and (..., e, 6, 6)

    Notes
    -----
    Valid to first order: the frames are those of the undeformed machine.

    References
    ----------
    Derived here: change of frame of a compliance; Demeč and Madáč write theirs in body frames, Eq. (4).
    """
    bodies = np.asarray(frame, dtype=np.int64)
    rotation = at.rotations[..., bodies, :, :]
    points = at.origins[..., bodies, :] + np.einsum("...eij,...ej->...ei", rotation, np.asarray(point, dtype=float))
    turn = np.zeros((*rotation.shape[:-2], 6, 6))
    turn[..., :3, :3] = turn[..., 3:, 3:] = rotation
    return points, turn @ np.asarray(compliance, dtype=float) @ np.swapaxes(turn, -1, -2)


def element_wrenches(elements: Elements, loads: Loads, *, feed_moment: bool = True) -> FloatArray:
    r"""Load of each element at its point, :math:`W = (\sum f;\; \sum (q - c) \times f)`, shape (..., e, 6).

    The sum runs over the loads on bodies :math:`< i` for part-side elements of joint i (what the part presses on), and
    on bodies :math:`\ge i` for tool-side elements.

    Parameters
    ----------
    elements, loads
        In frame 0.
    feed_moment : bool
        False leaves out the moment of the x components on part-side elements, as the published curves seem to do;
        not physical.

    Returns
    -------
    array (..., e, 6)
        Force [N] above moment [N m]. Valid for forces that act at the undeformed points.

    References
    ----------
    Derived here: equilibrium of what an element carries; Demeč and Madáč give the loads and no formula.
    """
    joints = np.asarray(elements.joint)[:, None]
    part_side = np.asarray(elements.part_side)[:, None]
    bodies = np.asarray(loads.body)[None, :]
    carried = np.where(part_side, bodies < joints, bodies >= joints).astype(float)
    force = np.einsum("ek,...ki->...ei", carried, loads.force)
    arm = loads.point[..., None, :, :] - elements.point[..., :, None, :]
    turning = np.broadcast_to(
        loads.force[..., None, :, :], np.broadcast_shapes(arm.shape, loads.force[..., None, :, :].shape)
    )
    if not feed_moment:
        turning = turning * np.where(part_side[..., None], np.array([0.0, 1.0, 1.0]), 1.0)
    moment = np.einsum("ek,...eki->...ei", carried, np.cross(arm, turning))
    return np.concatenate([np.broadcast_to(force, moment.shape), moment], axis=-1)


def element_twists(elements: Elements, wrenches: FloatArray) -> FloatArray:
    r"""Twist of each element at its point, :math:`\xi = C W`, shape (..., e, 6).

    Part side: motion of body i-1 against body i; tool side: of body i against body i-1.

    Displacement [m] above rotation [rad]; valid for linear elements.

    References
    ----------
    Hooke's law; Demeč and Madáč, Eqs. (6) and (7), are such twists.
    """
    return np.einsum("...eij,...ej->...ei", elements.compliance, wrenches)


def element_signs(elements: Elements, *, literal: bool = False) -> FloatArray:
    """+1 on the tool side, -1 on the part side: a table that yields takes the part away from the tool.

    ``literal`` gives +1 throughout, as Eq. (2) of Demeč and Madáč reads; not physical.

    References
    ----------
    Demeč and Madáč, Eq. (2), with the sign of the part side derived here.
    """
    return np.where(np.asarray(elements.part_side) & (not literal), -1.0, 1.0)


def contributions(elements: Elements, twists: FloatArray, tool: ArrayLike, *, literal: bool = False) -> FloatArray:
    r"""What each element adds to the error of the tool point against the part, :math:`\pm(\delta + \varepsilon \times
    (p - c))` [m], shape (..., e, 3).

    References
    ----------
    Demeč and Madáč, Eqs. (4) and (5), from the element's point instead of the body's origin.
    """
    moved = twist_at(twists, np.asarray(tool, dtype=float)[..., None, :] - elements.point)[..., :3]
    return moved * element_signs(elements, literal=literal)[:, None]


def chain_twists(elements: Elements, twists: FloatArray, at: Frames, *, literal: bool = False) -> FloatArray:
    r"""Twists of the chain bodies in their frames, after the motion, shape (..., n + 1, 6).

    .. math:: \delta_i = \sigma R_{0i}^T(\delta + \varepsilon \times (o_i - c)), \qquad
              \varepsilon_i = \sigma R_{0i}^T \varepsilon

    summed over the elements of joint i, with :math:`\sigma = -1` on the part side.

    References
    ----------
    Demeč and Madáč, Eqs. (4), (6) and (7); the carrying over to the origin is derived here.
    """
    joints = np.asarray(elements.joint)
    moved = twist_at(twists, at.origins[..., joints, :] - elements.point)
    moved = moved * element_signs(elements, literal=literal)[:, None]
    rotation = at.rotations[..., joints, :, :]
    local = np.concatenate(
        [np.einsum("...eji,...ej->...ei", rotation, part) for part in (moved[..., :3], moved[..., 3:])], axis=-1
    )
    result = np.zeros((*local.shape[:-2], at.origins.shape[-2], 6))
    for e, joint in enumerate(joints):
        result[..., joint, :] += local[..., e, :]
    return result


def part_twist(part: PartBlock, force: ArrayLike, tool: ArrayLike) -> tuple[FloatArray, FloatArray]:
    r"""How the part itself bends under the reaction :math:`-F` at the tool point.

    Returns
    -------
    wrench, twist : arrays (..., 6)
        At the section's centre; the material under the tool moves by :math:`u = \delta + \varepsilon \times (p - c)`,
        and the error of the surface is :math:`\Delta_0 = -u`.

    Parameters
    ----------
    part : PartBlock
        The part up to the height of the tool.
    force : array (..., 3)
        F on the tool [N].
    tool : array (..., 3)
        Tool point p [m].

    References
    ----------
    Demeč and Madáč, Eq. (3), with the sign derived here.
    """
    reaction = -np.asarray(force, dtype=float)
    arm = np.asarray(tool, dtype=float) - part.point
    moment = np.cross(arm, reaction)
    wrench = np.concatenate([np.broadcast_to(reaction, moment.shape), moment], axis=-1)
    return wrench, np.einsum("...ij,...j->...i", part.compliance, wrench)


def point_displacement(point: FloatArray, twist: FloatArray, tool: ArrayLike) -> FloatArray:
    r"""Displacement :math:`\delta + \varepsilon \times (q - c)` [m] of a point q by a twist at c, (..., 3).

    References
    ----------
    Demeč and Madáč, Eqs. (3) and (4).
    """
    return twist_at(twist, np.asarray(tool, dtype=float) - point)[..., :3]


def load_displacements(elements: Elements, twists: FloatArray, loads: Loads) -> FloatArray:
    """Displacement of each load's point relative to the ground [m], shape (..., k, 3), physical signs.

    A tool-side body moves with the elements of tool-side joints up to its own; a part-side body with those of the
    part-side joints above its own.

    References
    ----------
    Derived here, for the balance of :func:`energy_residual`.
    """
    joints, part_side = np.asarray(elements.joint)[:, None], np.asarray(elements.part_side)[:, None]
    bodies = np.asarray(loads.body)[None, :]
    carries = np.where(part_side, (bodies <= elements.ground) & (joints > bodies), joints <= bodies).astype(float)
    moved = twist_at(twists[..., :, None, :], loads.point[..., None, :, :] - elements.point[..., :, None, :])[..., :3]
    return np.einsum("ek,...eki->...ki", carries, moved)


def strain_work(wrenches: FloatArray, twists: FloatArray) -> FloatArray:
    r""":math:`\sum_e W_e^T \xi_e` [J], twice the strain energy of linear elements, shape (...).

    References
    ----------
    Clapeyron's theorem; Love 1927, A Treatise on the Mathematical Theory of Elasticity, art. 120.
    """
    return np.einsum("...ei,...ei->...", wrenches, twists)


def external_work(loads: Loads, displacements: FloatArray) -> FloatArray:
    r""":math:`\sum_k f_k \cdot u_k` [J] over all loads, shape (...).

    References
    ----------
    Clapeyron's theorem; Love 1927, A Treatise on the Mathematical Theory of Elasticity, art. 120.
    """
    return np.einsum("...ki,...ki->...", loads.force, displacements)


def energy_residual(external: ArrayLike, internal: ArrayLike) -> FloatArray:
    r"""Clapeyron's balance :math:`|\sum f_k \cdot u_k - \sum W^T C W| / \sum W^T C W`.

    Holds for linear elements with physical signs and without geometric errors.

    References
    ----------
    Clapeyron's theorem; Love 1927, A Treatise on the Mathematical Theory of Elasticity, art. 120.
    """
    inside = np.asarray(internal, dtype=float)
    return np.abs(np.asarray(external, dtype=float) - inside) / inside


def least_convexity(at: ArrayLike, values: ArrayLike) -> float:
    r"""Smallest second derivative of samples over a travel, :math:`L^2 w''/\max|w|`; not negative for convex ones.

    The work of a constant cutting force on constant compliances is convex along a straight travel. Second divided
    differences stand for the derivative: they have its sign for any spacing, and its value as the spacing shrinks.

    Parameters
    ----------
    at : array (n,)
        Ascending, n at least 3.
    values : array (n,)
        w there.

    Returns
    -------
    float
        [1]

    References
    ----------
    Derived here.
    """
    x, w = np.asarray(at, dtype=float), np.asarray(values, dtype=float)
    slope = np.diff(w) / np.diff(x)
    bend = 2.0 * np.diff(slope) / (x[2:] - x[:-2])
    return float(bend.min() * (x[-1] - x[0]) ** 2 / np.abs(w).max())
