"""Which body costs how much: signed shares of the error, and what stiffening one of them would bring."""

import numpy as np
from numpy.typing import ArrayLike

from cutwise.maths.frames import FloatArray


def signed_shares(contributions: ArrayLike, total: ArrayLike) -> FloatArray:
    r"""Share of each contribution along the total error, :math:`v_b \cdot \Delta/|\Delta|` [m]; they sum to |Δ|.

    Parameters
    ----------
    contributions : array (..., b, 3)
        :math:`v_b` [m], summing to the total.
    total : array (..., 3)
        Δ [m].

    Returns
    -------
    array (..., b)
        [m]; zero where there is no error. Valid for contributions that add up, as small errors do.

    Examples
    --------
    3 µm along x and 4 µm along y make 5 µm:

    >>> (1e6 * signed_shares([[3e-6, 0.0, 0.0], [0.0, 4e-6, 0.0]], [3e-6, 4e-6, 0.0])).round(9).tolist()
    [1.8, 3.2]

    References
    ----------
    Derived here; the contributions are Demeč and Madáč, Eq. (5).
    """
    error = np.asarray(total, dtype=float)
    size = np.linalg.norm(error, axis=-1, keepdims=True)
    direction = np.divide(error, size, out=np.zeros_like(error), where=size > 0.0)
    return np.einsum("...bi,...i->...b", np.asarray(contributions, dtype=float), direction)


def stiffening_gain(contributions: ArrayLike, total: ArrayLike, *, stiffer: float = 0.1) -> FloatArray:
    r"""Change of the largest |Δ| of the pass [m] when one contribution's element gets stiffer.

    .. math:: \max_m |\Delta_m - v_{bm} + v_{bm}/(1+s)| - \max_m |\Delta_m|

    Exact for linear elements under given forces: the others keep their load.

    Parameters
    ----------
    contributions : array (m, b, 3)
        :math:`v_b` [m] at places along the pass.
    total : array (m, 3)
        Δ [m].
    stiffer : float
        s, 0.1 for 10 %.

    Returns
    -------
    array (b,)

    Examples
    --------
    An element that makes the whole error of 1.1 µm:

    >>> (1e6 * stiffening_gain([[[1.1e-6, 0.0, 0.0]]], [[1.1e-6, 0.0, 0.0]])).round(9).tolist()
    [-0.1]

    References
    ----------
    Derived here from the sum of Demeč and Madáč, Eq. (2).
    """
    error, parts = np.asarray(total, dtype=float), np.asarray(contributions, dtype=float)
    changed = error[:, None, :] - parts * (stiffer / (1.0 + stiffer))
    return np.asarray(np.linalg.norm(changed, axis=-1).max(axis=0) - np.linalg.norm(error, axis=-1).max())


def stiffness_for(contributions: ArrayLike, total: ArrayLike, limit: float) -> FloatArray:
    r"""Stiffness that each element alone needs for :math:`|\Delta|` to keep a limit, as a multiple of what it has.

    .. math:: |\Delta_m - (1 - x)\,v_{bm}| \le \text{limit} \;\text{for all } m, \qquad k = 1/x

    the smallest k > 0, from a quadratic in the flexibility x of each place m; x = 1 is the element as it is, 0 a rigid
    one. Exact for linear elements under given forces.

    Parameters
    ----------
    contributions : array (m, b, 3)
        :math:`v_b` [m] at places along the pass.
    total : array (m, 3)
        Δ [m].
    limit : float
        Largest length allowed [m].

    Returns
    -------
    array (b,)
        Infinite where no stiffness is enough; zero where the element may be as soft as it likes.

    Examples
    --------
    An element that makes the whole error of 2 µm, where 1 µm is allowed:

    >>> stiffness_for([[[2e-6, 0.0, 0.0]]], [[2e-6, 0.0, 0.0]], 1e-6).round(9).tolist()
    [2.0]

    References
    ----------
    Derived here from the sum of Demeč and Madáč, Eq. (2).
    """
    error, parts = np.asarray(total, dtype=float), np.asarray(contributions, dtype=float)
    rest = error[:, None, :] - parts  # with a rigid element
    a = np.einsum("mbi,mbi->mb", parts, parts)
    b = np.einsum("mbi,mbi->mb", rest, parts)
    c = np.einsum("mbi,mbi->mb", rest, rest) - limit**2
    root = b * b - a * c
    with np.errstate(divide="ignore", invalid="ignore"):
        low, high = (-b - np.sqrt(root)) / a, (-b + np.sqrt(root)) / a
    flat = a <= 1e-30 * limit**2
    low, high = np.where(flat, np.where(c <= 0.0, -np.inf, np.inf), low), np.where(flat, np.inf, high)
    low, high = np.where(root < 0.0, np.inf, low), np.where(root < 0.0, -np.inf, high)
    least, most = np.maximum(low.max(axis=0), 0.0), high.min(axis=0)
    with np.errstate(divide="ignore"):
        return np.where(most < least, np.inf, np.where(most > 0.0, 1.0 / np.maximum(most, 0.0), np.inf))
