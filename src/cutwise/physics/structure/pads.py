"""Guideways, clampings and joints as groups of pads (carriages): linear springs, or the contact law of sliding pads."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cutwise.maths.frames import FloatArray, skew

_STEPS = 60  # Newton steps; six to ten are usual


class PadLostError(ValueError):
    """A pad of an open guide has lost contact under the load."""


class NoEquilibriumError(ArithmeticError):
    """Newton found no equilibrium of a pad group."""


class ContactPads(NamedTuple):
    """Preloaded sliding pads with the contact law :math:`\\delta = c\\,p^m` along their normal.

    Closed guides have an equal, opposed pad (gib) under the same preload behind each pad.
    """

    points: FloatArray  # [m] pads relative to the element's point, shape (k, 3)
    normal: FloatArray  # unit vector from the supporting to the moving body, shape (3,)
    tangential: FloatArray  # [N/m] linear stiffness of each pad across the normal (its part along it is 0), (k, 3)
    area: float  # A [m^2] of a pad
    coefficient: float  # c [m/Pa^m]
    exponent: float  # m, about 0.5
    preload: float  # p_0 [Pa], positive
    closed: bool  # an opposed pad behind each one


def mobility(points: ArrayLike) -> FloatArray:
    r"""Displacement of points per twist of the body, :math:`B_k = [I, -[p_k]_\times]`, shape (k, 3, 6).

    References
    ----------
    Small rotations, Demeč and Madáč, Eqs. (3) and (7).
    """
    p = np.asarray(points, dtype=float)
    return np.concatenate([np.broadcast_to(np.eye(3), (*p.shape[:-1], 3, 3)), -skew(p)], axis=-1)


def stiffness_matrix(points: ArrayLike, stiffness: ArrayLike) -> FloatArray:
    r"""Stiffness of a pad group at its point: :math:`K = \sum_k B_k^T\, \mathrm{diag}(k_x, k_y, k_z)_k\, B_k`.

    Parameters
    ----------
    points : array (k, 3)
        Pads relative to the element's point [m].
    stiffness : array (k, 3) or (3,)
        Springs of each pad along the axes [N/m]. A drive is spread in equal parts over the pads in the direction of
        travel, so that it adds to the yaw stiffness.

    Returns
    -------
    array (6, 6)
        Force [N], moment [N m] per displacement [m], rotation [rad].

    Notes
    -----
    Valid for stiff bodies between linear springs.

    References
    ----------
    Derived here: the sum of springs carried to one point.
    """
    b = mobility(points)
    k = np.broadcast_to(np.asarray(stiffness, dtype=float), (*b.shape[:-2], 3))
    return np.einsum("kai,ka,kaj->ij", b, k, b)


def pad_compliance(points: ArrayLike, stiffness: ArrayLike) -> FloatArray:
    """Compliance (6, 6) of a pad group, the inverse of :func:`stiffness_matrix`.

    Raises
    ------
    ValueError
        The group leaves a motion free (fewer than three pads, pads in one line, a spring of zero).

    References
    ----------
    Derived here.
    """
    stiff = stiffness_matrix(points, stiffness)
    if not is_positive_definite(stiff):
        raise ValueError(
            "the pads leave a motion free: they need three places off one line, and stiffness on each axis"
        )
    return np.linalg.inv(stiff)  # type: ignore[return-value]


def is_positive_definite(matrix: ArrayLike) -> bool:
    """Whether a symmetric matrix is positive definite, in a sense that does not depend on its units.

    References
    ----------
    Derived here; the scaling to a unit diagonal is that of van der Sluis 1969, Numer. Math. 14.
    """
    m = np.asarray(matrix, dtype=float)
    diagonal = np.diagonal(m)
    if not np.isfinite(m).all() or (diagonal <= 0.0).any():
        return False
    scaled = m / np.sqrt(diagonal[:, None] * diagonal[None, :])
    if np.abs(scaled - scaled.T).max() > 1e-9:
        return False
    return bool(np.linalg.eigvalsh(0.5 * (scaled + scaled.T))[0] > 1e-12)


def _one_side(pads: ContactPads, compression: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    # pressure p, its slope dp/ddelta and the work per area of the contact from preload; no pull where contact is lost
    rest = pads.coefficient * pads.preload**pads.exponent
    closeness = np.maximum(compression + rest, 0.0) / pads.coefficient
    pressure = closeness ** (1.0 / pads.exponent)
    slope = closeness ** (1.0 / pads.exponent - 1.0) / (pads.exponent * pads.coefficient)
    power = 1.0 / pads.exponent + 1.0
    work = pads.coefficient / power * (closeness**power - (rest / pads.coefficient) ** power)
    return pressure, slope, work


def contact_force(pads: ContactPads, compression: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
    r"""Force of a pad against compression, its stiffness, and the work stored in the contact.

    .. math::
        N(\delta) = A\left[\left(\frac{\delta + \delta_0}{c}\right)^{1/m} - p_0\right], \quad \delta_0 = c\,p_0^m,
        \quad k = \frac{A}{c\,m}\,p^{1-m}

    minus the same of the opposed pad at :math:`-\delta` for closed guides.

    Parameters
    ----------
    pads : ContactPads
        Law and preload.
    compression : array
        :math:`\delta` [m] from the preloaded state, positive when pressed.

    Returns
    -------
    force, stiffness, work : arrays
        N [N], dN/dδ [N/m], :math:`\int_0^\delta N\,d\delta` [J].

    References
    ----------
    Levina and Reshetov 1971, Contact Stiffness of Machines: δ = c p^m with m about 0.5.
    """
    delta = np.asarray(compression, dtype=float)
    pressure, slope, work = _one_side(pads, delta)
    if pads.closed:
        behind, behind_slope, behind_work = _one_side(pads, -delta)
        return pads.area * (pressure - behind), pads.area * (slope + behind_slope), pads.area * (work + behind_work)
    return pads.area * (pressure - pads.preload), pads.area * slope, pads.area * (work - pads.preload * delta)


def contact_equilibrium(pads: ContactPads, wrench: ArrayLike) -> tuple[FloatArray, float]:
    r"""Twist of a pad group with the contact law under a load, by Newton on its six unknowns.

    Solves :math:`\sum_k B_k^T f_k(B_k \xi) = W`; the tangent is symmetric positive definite while every pad holds.

    Parameters
    ----------
    pads : ContactPads
        The group.
    wrench : array (6,)
        W = (force [N], moment [N m]) on the moving body at the element's point.

    Returns
    -------
    twist : array (6,)
        :math:`\xi` [m, rad].
    work : float
        Work stored [J], contacts and tangential springs.

    Raises
    ------
    PadLostError
        A pad of an open guide carries no pressure any more.
    NoEquilibriumError
        No convergence.

    References
    ----------
    Derived here: Newton with damping on the potential of the contact law of Levina and Reshetov 1971.
    """
    load = np.asarray(wrench, dtype=float)
    b = mobility(pads.points)
    normal = np.asarray(pads.normal, dtype=float)
    along = np.einsum("a,kai->ki", normal, b)
    springs = np.einsum("kai,ka,kaj->ij", b, pads.tangential, b)
    reach = float(np.abs(pads.points).max())
    scale = np.concatenate([np.ones(3), np.full(3, max(reach, 1e-6))])
    size = float(np.abs(load / scale).max()) + pads.area * pads.preload

    def residual(twist: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, float]:
        compression = -along @ twist
        force, stiff, work = contact_force(pads, compression)
        balance = springs @ twist - along.T @ force - load
        tangent = springs + np.einsum("ki,k,kj->ij", along, stiff, along)
        return balance, tangent, compression, float(work.sum() + 0.5 * twist @ springs @ twist)

    twist = np.zeros(6)
    balance, tangent, compression, work = residual(twist)
    rest = pads.coefficient * pads.preload**pads.exponent
    for _ in range(_STEPS):
        if np.abs(balance / scale).max() <= 1e-12 * size:
            break
        potential, missed = work - load @ twist, float(np.abs(balance / scale).max())
        step = np.linalg.lstsq(tangent, -balance, rcond=None)[0]
        shorter = 1.0
        while True:  # the potential is convex: damp until it falls; near its floor the residual shows it better
            trial = residual(twist + shorter * step)
            falls = trial[3] - load @ (twist + shorter * step) < potential
            if falls or float(np.abs(trial[0] / scale).max()) < missed or shorter < 1e-6:
                break
            shorter *= 0.5
        twist = twist + shorter * step
        balance, tangent, compression, work = trial
    if not pads.closed and (compression <= -rest).any():
        lost = [str(k + 1) for k in np.flatnonzero(compression <= -rest)]
        words = f"pad {lost[0]} lifts" if len(lost) == 1 else f"pads {', '.join(lost)} lift"
        raise PadLostError(f"{words} off under the load; raise the preload, or say closed_guide: true")
    if np.abs(balance / scale).max() > 1e-9 * size:
        raise NoEquilibriumError("no equilibrium of a pad group: the load is beyond what its contacts can carry")
    return twist, work
