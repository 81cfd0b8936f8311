r"""Compliances of a chain at the tool, as sums of element twists, and their turn into process axes.

An element e with the local compliance :math:`C_e` at the point :math:`c_e` gives, under a wrench (F; m) at the tool
point p, the twist there of :math:`X_e^T C_e X_e (F; m)` with :math:`X_e = [I, 0; S(p - c_e), I]`. A joint of stiffness k
about the axis a is the element of rank one :math:`C_e = (0; a)(0; a)^T / k`; the joints of an arm together are
:math:`J K_\theta^{-1} J^T`. :func:`chain_compliance` is the sum for both.
"""

import numpy as np

from cutwise.maths.frames import FloatArray, skew


def carried_to(compliance: FloatArray, lever: FloatArray) -> FloatArray:
    r"""Compliance at a tool point of an element somewhere else: :math:`X^T C X`, :math:`X = [I, 0; S(\ell), I]`.

    Parameters
    ----------
    compliance : array (..., 6, 6)
        Of the element, displacement over rotation, at its own point.
    lever : array (..., 3)
        From the element to the tool point [m].

    References
    ----------
    Murray, Li and Sastry 1994, ch. 2, sec. 5 (wrenches at another point); the sandwich follows from virtual work.
    """
    across = np.zeros((*np.shape(lever)[:-1], 6, 6))
    across[..., range(6), range(6)] = 1.0
    across[..., 3:, :3] = skew(lever)
    return np.swapaxes(across, -1, -2) @ compliance @ across


def joint_element(axis: FloatArray, stiffness: float) -> FloatArray:
    """Compliance of a turning joint at a point on its axis: rotation about the axis alone.

    ``axis`` is a unit vector (3,), ``stiffness`` in N m/rad; displacement over rotation, shape (6, 6).

    References
    ----------
    Derived here: an element of rank one.
    """
    element = np.zeros((6, 6))
    element[3:, 3:] = np.outer(axis, axis) / stiffness
    return element


def chain_compliance(elements: FloatArray, levers: FloatArray) -> FloatArray:
    r"""Compliance at a tool point of everything that yields in a chain: :math:`C = \sum_e X_e^T C_e X_e`.

    The one sum of an arm (joints and base) and of a machine (guides, castings, spindle, the part): tool side and part
    side add, because the table is pushed away by the force that pushes the tool.

    Parameters
    ----------
    elements : array (..., e, 6, 6)
        Compliance of each at its own point.
    levers : array (..., e, 3)
        From each to the tool point [m].

    Returns
    -------
    array (..., 6, 6)
        Blocks [m/N, 1/N; rad/N, rad/(N m)].

    Notes
    -----
    To first order: forces act at the undeformed tool point.

    Examples
    --------
    A hinge of 1e6 N m/rad, 2 m beside the tool:

    >>> hinge = joint_element(np.array([0.0, 0.0, 1.0]), 1e6)
    >>> round(float(chain_compliance(hinge[None], np.array([[2.0, 0.0, 0.0]]))[1, 1]), 12)
    4e-06

    References
    ----------
    Derived here; for joints alone Salisbury 1980, Proc. IEEE CDC, 95-100.
    """
    return np.asarray(carried_to(elements, levers).sum(axis=-3))


def turning_elements(twists: FloatArray, stiffness: FloatArray) -> FloatArray:
    r"""What yields by one angle each, seen at the tool: :math:`C_k = t_k t_k^T / k_k`, shape (..., k, 6, 6).

    Parameters
    ----------
    twists : array (..., 6, k)
        :math:`t_k`, twist of the tool for a unit turn of each: the columns of the Jacobian [m; 1 per rad].
    stiffness : array (k,)
        [N m/rad]; infinite for one that is stiff.

    References
    ----------
    Salisbury 1980, Proc. IEEE CDC, 95-100, joint by joint.
    """
    each = np.swapaxes(np.asarray(twists, dtype=float), -1, -2)
    return np.asarray(each[..., :, None] * each[..., None, :] / np.asarray(stiffness, dtype=float)[:, None, None])


def in_axes(compliance: FloatArray, axes: FloatArray) -> FloatArray:
    r"""Compliance seen from other axes, right-handed or not.

    Forces and displacements turn with R, moments and rotations, which a mirror leaves reversed, with
    :math:`\det(R) R`.

    Parameters
    ----------
    compliance : array (..., 6, 6)
    axes : array (..., 3, 3)
        The other axes as columns.

    References
    ----------
    Derived here: forces are polar, moments are axial vectors.
    """
    turn = np.zeros((*np.shape(axes)[:-2], 6, 6))
    turn[..., :3, :3] = axes
    turn[..., 3:, 3:] = axes * np.linalg.det(axes)[..., None, None]
    return np.asarray(np.swapaxes(turn, -1, -2) @ compliance @ turn)


def translation_at(compliance: FloatArray, height: float) -> FloatArray:
    r"""Translational compliance of the axis at a height over the reference point, for a force there.

    .. math:: C_z = T C T^T, \qquad T = [I,\; -S(z e_z)]

    Parameters
    ----------
    compliance : array (..., 6, 6)
        At the reference point.
    height : float
        z [m].

    Returns
    -------
    array (..., 3, 3)
        [m/N]

    References
    ----------
    Derived here from :func:`carried_to`.
    """
    across = np.concatenate([np.eye(3), -skew(np.array([0.0, 0.0, height]))], axis=1)
    return np.asarray(across @ compliance @ across.T)
