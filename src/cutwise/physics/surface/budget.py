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
    """
    error = np.asarray(total, dtype=float)
    size = np.linalg.norm(error, axis=-1, keepdims=True)
    direction = np.divide(error, size, out=np.zeros_like(error), where=size > 0.0)
    return np.einsum("...bi,...i->...b", np.asarray(contributions, dtype=float), direction)


def stiffening_gain(contributions: ArrayLike, total: ArrayLike, *, stiffer: float = 0.1) -> FloatArray:
    r"""Change of |Δ| [m] when one contribution's element gets stiffer, :math:`|\Delta - v_b + v_b/(1+s)| - |\Delta|`.

    Exact for linear elements under given forces: the others keep their load.

    Parameters
    ----------
    contributions : array (..., b, 3)
        :math:`v_b` [m].
    total : array (..., 3)
        Δ [m].
    stiffer : float
        s, 0.1 for 10 %.
    """
    error, parts = np.asarray(total, dtype=float), np.asarray(contributions, dtype=float)
    changed = error[..., None, :] - parts * (stiffer / (1.0 + stiffer))
    return np.linalg.norm(changed, axis=-1) - np.linalg.norm(error, axis=-1)[..., None]
