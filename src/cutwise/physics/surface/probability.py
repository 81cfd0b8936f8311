"""With which probability: covariance of the tool-point error, shares of variance, quantiles."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cutwise.maths.frames import FloatArray

NORMAL, UNIFORM, TRIANGULAR = 0, 1, 2


class Quantiles(NamedTuple):
    """Of the length of the error, systematic and random together and random alone."""

    together: float  # quantile of |systematic + random| [m]
    random: float  # quantile of |random| [m]
    deviation: FloatArray  # standard deviation of the samples [m], shape (3,)


def covariance(error_jacobian: ArrayLike, deviation: ArrayLike) -> FloatArray:
    r"""Covariance of the tool-point error, :math:`J \Sigma J^T` [m^2], shape (..., 3, 3).

    Parameters
    ----------
    error_jacobian : array (..., 3, n + 1, 6)
        From ``maths.chains.error_jacobian``.
    deviation : array (n + 1, 6)
        Standard deviations of the independent components of :math:`\xi_i` [m, rad].

    Notes
    -----
    Valid for small independent errors (first order), of any distribution.

    Examples
    --------
    3 µm of a component that acts twice along x:

    >>> jacobian = np.zeros((3, 1, 6))
    >>> jacobian[0, 0, 0] = 2.0
    >>> round(1e12 * float(covariance(jacobian, np.full((1, 6), 3e-6))[0, 0]), 6)
    36.0

    References
    ----------
    Derived here from Demeč and Madáč, Eq. (2).
    """
    scaled = np.asarray(error_jacobian, dtype=float) * np.asarray(deviation, dtype=float)
    return np.einsum("...xbc,...ybc->...xy", scaled, scaled)


def variance_shares(error_jacobian: ArrayLike, deviation: ArrayLike) -> FloatArray:
    """Share of each body in the trace of the covariance, shape (..., n + 1); zero throughout without uncertainty.

    ``error_jacobian``, ``deviation``: as for :func:`covariance`, with its range of validity.

    Examples
    --------
    >>> jacobian, deviation = np.zeros((3, 2, 6)), np.zeros((2, 6))
    >>> jacobian[0, :, 0], deviation[:, 0] = 1.0, [1e-6, 2e-6]
    >>> variance_shares(jacobian, deviation).round(9).tolist()
    [0.2, 0.8]

    References
    ----------
    Derived here.
    """
    scaled = np.asarray(error_jacobian, dtype=float) * np.asarray(deviation, dtype=float)
    parts = np.einsum("...xbc,...xbc->...b", scaled, scaled)
    whole = parts.sum(axis=-1, keepdims=True)
    return np.divide(parts, whole, out=np.zeros_like(parts), where=whole > 0.0)


def draw(size: int, law: int, generator: np.random.Generator) -> FloatArray:
    """Independent samples of zero mean and unit variance of a body's six components, shape (size, 6).

    Parameters
    ----------
    size : int
        Number of samples.
    law : int
        :data:`NORMAL`, :data:`UNIFORM` or :data:`TRIANGULAR` (symmetric).
    generator : numpy Generator
        Seeded by the caller.

    Examples
    --------
    A rectangle of unit variance ends at the root of three:

    >>> bool(abs(draw(1000, UNIFORM, np.random.default_rng(0))).max() < 3.0**0.5)
    True
    """
    if law == NORMAL:
        return generator.standard_normal((size, 6))
    if law == UNIFORM:
        return generator.uniform(-(3.0**0.5), 3.0**0.5, (size, 6))
    return generator.triangular(-(6.0**0.5), 0.0, 6.0**0.5, (size, 6))


def random_errors(
    error_jacobian: ArrayLike, deviation: ArrayLike, laws: ArrayLike, *, samples: int, seed: int
) -> FloatArray:
    r"""Random errors of the tool point by Monte Carlo on the linear model [m], shape (samples, 3).

    The covariance answers every question about one direction when inputs are normal; the length of the error, and
    inputs that are not normal, need samples. All normal bodies together are one normal vector of their covariance;
    the others are drawn one by one. The standard error of a standard deviation is :math:`1/\sqrt{2N}`: 0.5 % for
    20,000 samples.

    Parameters
    ----------
    error_jacobian : array (3, n + 1, 6)
        Of the posture.
    deviation : array (n + 1, 6)
        Standard deviations [m, rad].
    laws : array of int (n + 1,)
        Distribution per body.
    samples : int
        N.
    seed : int
        The same seed gives the same answer.

    Notes
    -----
    Valid for small independent errors (first order).

    Examples
    --------
    One component of 1 µm along x: as much of the samples, within 2 %.

    >>> jacobian, deviation = np.zeros((3, 1, 6)), np.zeros((1, 6))
    >>> jacobian[0, 0, 0], deviation[0, 0] = 1.0, 1e-6
    >>> abs(1e6 * float(random_errors(jacobian, deviation, [NORMAL], samples=20_000, seed=1)[:, 0].std()) - 1.0) < 0.02
    True

    References
    ----------
    Derived here from Demeč and Madáč, Eq. (2).
    """
    jacobian, spread = np.asarray(error_jacobian, dtype=float), np.asarray(deviation, dtype=float)
    law = np.asarray(laws)
    generator = np.random.default_rng(seed)
    normal = law == NORMAL
    size, axes = np.linalg.eigh(covariance(jacobian[:, normal], spread[normal]))
    random = generator.standard_normal((samples, 3)) * np.sqrt(np.maximum(size, 0.0)) @ axes.T
    for body in np.flatnonzero(~normal & spread.any(axis=1)):
        random += draw(samples, int(law[body]), generator) @ (jacobian[:, body] * spread[body]).T
    return random


def quantiles(systematic: ArrayLike, random: ArrayLike, probability: float) -> Quantiles:
    r"""Quantile of the length of the error, :math:`|\Delta + \text{random}|` and :math:`|\text{random}|`.

    Parameters
    ----------
    systematic : array (3,)
        Δ of loads and known errors [m].
    random : array (samples, 3)
        From :func:`random_errors` [m].
    probability : float
        0.95 for the 95 % quantile.

    Examples
    --------
    Half of the samples 1 µm off either way, and 2 µm that are always there:

    >>> found = quantiles([2e-6, 0.0, 0.0], [[1e-6, 0.0, 0.0], [-1e-6, 0.0, 0.0]], 0.5)
    >>> round(1e6 * found.together, 9), round(1e6 * found.random, 9)
    (2.0, 1.0)

    References
    ----------
    Derived here.
    """
    error = np.asarray(random, dtype=float)
    together = np.linalg.norm(error + np.asarray(systematic, dtype=float), axis=1)
    return Quantiles(
        float(np.quantile(together, probability)),
        float(np.quantile(np.linalg.norm(error, axis=1), probability)),
        error.std(axis=0),
    )
