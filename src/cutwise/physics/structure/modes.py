"""Tool-tip modes: oscillators along x and y that the cutting force excites."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


class Modes(NamedTuple):
    """Modes of the tool tip, ``m`` of them; the tip moves by the sum of their displacements along their directions."""

    frequency: FloatArray  # undamped natural, [rad/s], shape (m,)
    damping: FloatArray  # ratio zeta [-], shape (m,)
    mass: FloatArray  # modal [kg], shape (m,)
    direction: FloatArray  # unit vectors in the xy plane, shape (m, 2)


def modes(frequency: FloatArray, damping: FloatArray, stiffness: FloatArray, direction: FloatArray) -> Modes:
    r"""Modes from natural frequency [rad/s], damping ratio [-], stiffness [N/m] and direction (m, 2).

    Raises ``ValueError`` for a frequency or stiffness that is not positive, or a damping ratio outside [0, 1).

    Modal mass [kg] is :math:`k/\omega^2`. Valid for modes that do not share their motion.

    References
    ----------
    Altintas 2012, Manufacturing Automation, ch. 3.
    """
    frequency, damping = np.atleast_1d(np.asarray(frequency, float)), np.atleast_1d(np.asarray(damping, float))
    stiffness, direction = np.atleast_1d(np.asarray(stiffness, float)), np.atleast_2d(np.asarray(direction, float))
    if np.any(frequency <= 0.0) or np.any(stiffness <= 0.0):
        raise ValueError("natural frequency and stiffness of a mode must be positive")
    if np.any(damping < 0.0) or np.any(damping >= 1.0):
        raise ValueError("damping ratio of a mode must be at least 0 and below 1")
    length = np.linalg.norm(direction, axis=1, keepdims=True)
    return Modes(frequency, damping, stiffness / frequency**2, direction / length)


def transition(frequency: float, damping: float, mass: float, time: float) -> FloatArray:
    r"""Exact step of one mode under a constant force.

    .. math:: m(\ddot q + 2\zeta\omega\dot q + \omega^2 q) = F

    Returns
    -------
    ndarray
        Rows: new displacement [m], new velocity [m/s]; columns: old displacement, old velocity, force. Shape (2, 3).

    Parameters
    ----------
    frequency, damping, mass : float
        :math:`\omega` [rad/s], :math:`\zeta` [1], m [kg]. Valid for :math:`0 \le \zeta < 1`.
    time : float
        Step [s].

    References
    ----------
    Derived here: the closed form of the damped oscillator.
    """
    decay = damping * frequency
    wd = frequency * math.sqrt(1.0 - damping * damping)
    e, c, s = math.exp(-decay * time), math.cos(wd * time), math.sin(wd * time)
    a11, a12 = e * (c + decay / wd * s), e * s / wd
    a21, a22 = -e * frequency * frequency / wd * s, e * (c - decay / wd * s)
    stiffness = mass * frequency * frequency
    return np.array([[a11, a12, (1.0 - a11) / stiffness], [a21, a22, -a21 / stiffness]])


def free_motion(tip: Modes, time: float) -> FloatArray:
    """Exact free motion of all modes over a time [s]: matrix on (displacements, velocities), shape (2m, 2m).

    References
    ----------
    Derived here: :func:`transition` without a force.
    """
    m = tip.frequency.size
    out = np.zeros((2 * m, 2 * m))
    for i in range(m):
        step = transition(float(tip.frequency[i]), float(tip.damping[i]), float(tip.mass[i]), time)
        out[i, i], out[i, m + i], out[m + i, i], out[m + i, m + i] = step[0, 0], step[0, 1], step[1, 0], step[1, 1]
    return out
