"""Seeded random curves: the same seed gives the same curve on every machine."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cutwise.later import later
from cutwise.maths.curves import Cubic, FloatArray

if TYPE_CHECKING:
    from scipy import interpolate, special
else:
    interpolate = later("scipy.interpolate")
    special = later("scipy.special")

_POINTS_PER_CORRELATION = 8
_POINTS_PER_WAVE = 32


_CURVES_FROM = 2**33  # second key of the noise of curves in studies


def shares(words: NDArray[np.uint64]) -> FloatArray:
    r"""Numbers in (0, 1) of random words: :math:`u = (\lfloor w / 2^{11} \rfloor + 1/2)\, 2^{-53}`."""
    return ((words >> np.uint64(11)).astype(float) + 0.5) * 2.0**-53


def curve_noise(seed: int, lever: int, case: int, count: int) -> FloatArray:
    r"""Independent standard normal numbers of one curve of a study, whatever the others are; shape (count,).

    Words of Philox under the key (seed, 2^33 + lever) from counter (0, case, 0, 0) on, as normal scores.

    >>> curve_noise(1, 0, 7, 2).round(15).tolist()
    [-0.617528484108496, -0.375146159424657]
    """
    words = np.random.Philox(key=[seed, _CURVES_FROM + lever], counter=[0, case, 0, 0]).random_raw(count)
    return np.asarray(special.ndtri(shares(words)))


def random_field(
    length: float, mean: float, deviation: float, correlation_length: float, seed: int,
    curve: tuple[int, int] | None = None,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    r"""A stationary normal field with covariance :math:`\sigma^2 e^{-(\Delta / l)^2}`.

    White noise smoothed by a Gaussian of :math:`l/2`, on a grid of l/8, one correlation length beyond both ends.

    Parameters
    ----------
    length : float
        Length of the field [m], from 0.
    mean, deviation : float
        Mean and standard deviation.
    correlation_length : float
        Distance l over which the correlation falls to 1/e [m].
    seed : int
        Seed of the random numbers.
    curve : tuple of int, optional
        Lever and case of a study, whose curve this is (:func:`curve_noise`).

    Returns
    -------
    position, value : array
        Grid [m] and field, shape (n,).

    Notes
    -----
    Valid for lengths from a few l on: a shorter sample has a mean and deviation of its own.

    References
    ----------
    Derived here: a Gaussian folded with itself is one of :math:`\sqrt2` its width.
    """
    pitch = min(correlation_length, length) / _POINTS_PER_CORRELATION
    position = np.arange(-correlation_length, length + correlation_length + pitch, pitch)
    reach = int(np.ceil(2.0 * correlation_length / pitch))
    kernel = np.exp(-2.0 * (np.arange(-reach, reach + 1) * pitch / correlation_length) ** 2)
    kernel /= np.sqrt((kernel**2).sum())
    count = position.size + 2 * reach
    noise = (
        np.random.Generator(np.random.PCG64(seed)).standard_normal(count)
        if curve is None
        else curve_noise(seed, *curve, count)
    )
    return position, mean + deviation * np.convolve(noise, kernel, mode="valid")


def sum_of_sines(length: float, lines: Sequence[tuple[float, float]], seed: int) -> Cubic:
    """Sines of given amplitude and wavelength with seeded random phases, as one smooth curve over [0, length]."""
    shortest = min(wavelength for _, wavelength in lines)
    at = np.linspace(0.0, length, max(9, int(np.ceil(length / shortest * _POINTS_PER_WAVE)) + 1))
    phases = np.random.Generator(np.random.PCG64(seed)).uniform(0.0, 2.0 * np.pi, len(lines))
    value = sum(a * np.sin(2.0 * np.pi * at / wave + p) for (a, wave), p in zip(lines, phases, strict=True))
    curve = interpolate.CubicSpline(at, value)
    return Cubic(np.ascontiguousarray(curve.x), np.ascontiguousarray(curve.c))
