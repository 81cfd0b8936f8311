"""Seeded random curves: the same seed gives the same curve on every machine."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cutwise.later import later
from cutwise.maths.curves import Cubic, FloatArray

if TYPE_CHECKING:
    from scipy import interpolate
else:
    interpolate = later("scipy.interpolate")

_POINTS_PER_CORRELATION = 8
_POINTS_PER_WAVE = 32


def random_field(
    length: float, mean: float, deviation: float, correlation_length: float, seed: int
) -> tuple[FloatArray, FloatArray]:
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
    noise = np.random.Generator(np.random.PCG64(seed)).standard_normal(position.size + 2 * reach)
    return position, mean + deviation * np.convolve(noise, kernel, mode="valid")


def sum_of_sines(length: float, lines: Sequence[tuple[float, float]], seed: int) -> Cubic:
    """Sines of given amplitude and wavelength with seeded random phases, as one smooth curve over [0, length]."""
    shortest = min(wavelength for _, wavelength in lines)
    at = np.linspace(0.0, length, max(9, int(np.ceil(length / shortest * _POINTS_PER_WAVE)) + 1))
    phases = np.random.Generator(np.random.PCG64(seed)).uniform(0.0, 2.0 * np.pi, len(lines))
    value = sum(a * np.sin(2.0 * np.pi * at / wave + p) for (a, wave), p in zip(lines, phases, strict=True))
    curve = interpolate.CubicSpline(at, value)
    return Cubic(np.ascontiguousarray(curve.x), np.ascontiguousarray(curve.c))
