"""A path that is learned against its own error: smoothing, lead, and whether the repetition converges."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.curves import FloatArray
from cutwise.physics.motion.drives import Drive
from cutwise.physics.motion.loop import sampled_response

_KEPT = 0.96  # of the slowest part of the shift that has to pass the smoothing
_REACH = 4.0  # standard deviations at which the Gaussian is cut off
_FREQUENCIES = 4000  # at which the loop is looked at, up to half of the sample rate
_LONGEST = 40  # samples of lead and of smoothing that are tried


class Rule(NamedTuple):
    r"""How a shift is learned: :math:`\delta \leftarrow Q[\delta - \lambda e(t + \ell)]`."""

    lead: int  # ell, in samples
    smoothing: int  # standard deviation of the Gaussian Q, in samples
    gain: float  # lambda
    convergence: tuple[float, ...]  # c of each axis: below 1 the shift converges


def gaussian(deviation: int) -> FloatArray:
    """Weights of a Gaussian over samples, cut off at four standard deviations, with the sum 1; shape (8 d + 1,).

    >>> gaussian(0).tolist(), len(gaussian(2)), round(float(gaussian(2)[8]), 6)
    ([1.0], 17, 0.199475)
    """
    if deviation == 0:
        return np.ones(1)
    k = np.arange(-round(_REACH * deviation), round(_REACH * deviation) + 1)
    weights = np.exp(-0.5 * (k / deviation) ** 2)
    return np.asarray(weights / weights.sum())


def smoothed(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Values at even instants weighted with their neighbours; the ends are repeated."""
    half = len(weights) // 2
    return np.convolve(np.pad(values, half, mode="edge"), weights, "valid")


def passed(omega: FloatArray, weights: FloatArray, sample_time: float) -> FloatArray:
    """Share of a wave of angular frequency omega [rad/s] that the smoothing lets pass.

    >>> round(float(passed(np.array([40.0 * math.pi]), gaussian(2), 1e-3)[0]), 4)  # 20 Hz, 2 ms
    0.9689
    """
    k = np.arange(len(weights)) - len(weights) // 2
    return np.asarray(np.cos(np.multiply.outer(omega, k * sample_time)) @ weights)


def convergence(drive: Drive, lead: int, smoothing: int, gain: float = 1.0) -> tuple[float, float]:
    r"""Largest factor by which a repetition changes a wave of the error, and at which frequency.

    .. math:: c = \max_\omega |Q (1 - \lambda e^{i\omega\ell} T)|, \qquad T = \frac{L}{1 + L}

    Parameters
    ----------
    drive : Drive
        Plant and controller of an axis, whose sampled loop gain is L.
    lead, smoothing : int
        :math:`\ell` and the standard deviation of Q, in samples.
    gain : float
        :math:`\lambda`.

    Returns
    -------
    tuple
        c [-], below 1 where the repetition converges, and the frequency [Hz].

    Notes
    -----
    Valid for a linear loop: without friction and saturation.

    Examples
    --------
    A loop of 10 rad/s and a damping ratio of 0.5, no lead and no smoothing: the peak of its sensitivity 1/(1 + L).

    >>> from cutwise.physics.motion.drives import Controller, Plant
    >>> plant = Plant(1.0, 1.0, 0.01, 0.1, 0.001, 0.0, 0.0, 0.0, 0.0, 1.0, -1.0, 1.0, -1.0, 0.0)
    >>> law = Controller(1000.0, 0.0, 0.0, 0.0, 0.0, 0.001, 10.0, 0.0, 0.0)
    >>> round(convergence(Drive(plant, law), 0, 0)[0], 2)
    1.47

    References
    ----------
    Bristow et al. 2006, A survey of iterative learning control, IEEE Control Systems 26 (3), the condition of convergence;
    evaluated here on the sampled loop.
    """
    step = drive.law.sample_time
    omega = np.linspace(1.0, math.pi / step * (1.0 - 1e-6), _FREQUENCIES)
    loop = sampled_response(omega, *drive)
    closed = loop / (1.0 + loop)
    factor = passed(omega, gaussian(smoothing), step) * np.abs(1.0 - gain * np.exp(1j * omega * lead * step) * closed)
    worst = int(np.argmax(np.abs(factor)))
    return float(abs(factor[worst])), float(omega[worst] / (2.0 * math.pi))


def rule_for(
    drives: tuple[Drive, ...], frequency: float, *, lead: int | None = None, smoothing: int | None = None,
    gain: float = 1.0,
) -> Rule:  # fmt: skip
    """The rule for axes and the frequency [Hz] at which the shift varies: what is not given is chosen.

    The largest smoothing that keeps 0.96 of that frequency, then the lead whose largest c over the axes is least.
    """
    step = drives[0].law.sample_time
    omega = np.array([2.0 * math.pi * frequency])
    if smoothing is None:
        smoothing = 0
        while smoothing < _LONGEST and float(passed(omega, gaussian(smoothing + 1), step)[0]) >= _KEPT:
            smoothing += 1
    if lead is None:
        worst = [max(convergence(one, n, smoothing, gain)[0] for one in drives) for n in range(_LONGEST + 1)]
        lead = int(np.argmin(worst))
    return Rule(lead, smoothing, gain, tuple(convergence(one, lead, smoothing, gain)[0] for one in drives))


def learned(shift: FloatArray, error: FloatArray, rule: Rule, active: npt.NDArray[np.bool_]) -> FloatArray:
    r"""The next shift, :math:`\delta \leftarrow Q[\delta - \lambda e(t + \ell)]` where it is active; elsewhere it stays.

    Parameters
    ----------
    shift, error : ndarray
        Along the normal, positive to the same side [m], shape (n,); the last error is repeated beyond the end.
    rule : Rule
        Lead, smoothing, gain.
    active : ndarray
        Where the shift may change, shape (n,).

    Examples
    --------
    Without lead and smoothing it is the mirror:

    >>> rule = Rule(0, 0, 1.0, (0.9,))
    >>> learned(np.zeros(2), np.array([1e-5, 2e-5]), rule, np.array([True, False])).tolist()
    [-1e-05, 0.0]
    """
    ahead = np.concatenate([error[rule.lead :], np.repeat(error[-1], rule.lead)])
    return np.where(active, smoothed(shift - rule.gain * ahead, gaussian(rule.smoothing)), shift)
