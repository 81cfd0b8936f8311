"""What a drilled hole looks like: perpendicularity, and an upper bound of its roundness error."""

import math

import numpy as np

from cutwise.maths.frames import FloatArray


def perpendicularity(entry: FloatArray, exit_point: FloatArray, thickness: float) -> float:
    r"""Tilt of the hole from its lateral positions at both surfaces [rad].

    .. math:: \tau = |a_\text{exit} - a_\text{entry}| / t

    The wall at depth :math:`d` is cut by the lip corner, when the tip is at :math:`d + h_t`: both positions are taken
    there, not where the tip passes.

    ``entry``, ``exit_point``: positions across the drill axis [m], shape (2,); ``thickness`` t [m]. Valid for small tilts.

    Examples
    --------
    >>> round(perpendicularity(np.array([0.0, 0.0]), np.array([3e-6, 4e-6]), 5e-3), 9)
    0.001

    References
    ----------
    Derived here; Garnier et al. 2017, sec. 1, name the error.
    """
    return float(np.linalg.norm(np.asarray(exit_point) - np.asarray(entry)) / thickness)


def whirl_amplitudes(
    lateral_compliance: FloatArray, force: float, mass: float, damping_ratio: float, speed: float
) -> tuple[float, float]:
    r"""Amplitudes along the two lateral modes of a drill pushed by a force that turns with it [m].

    .. math:: A_k = \frac{F_\mathrm{rot}}{|k_k - m\omega^2 + 2 i\zeta\sqrt{k_k m}\,\omega|}

    Parameters
    ----------
    lateral_compliance : array (2, 2)
        :math:`C_l` across the drill axis [m/N]; :math:`k_k` are the eigenvalues of its inverse.
    force : float
        :math:`F_\mathrm{rot}` [N], from a difference of lip heights.
    mass, damping_ratio, speed : float
        :math:`m` [kg], :math:`\zeta` [1], :math:`\omega` [rad/s].

    Returns
    -------
    tuple
        :math:`A_1, A_2` by rising stiffness. Their difference estimates the circularity error (peak to valley), their
        sum the oversize; an upper bound, as if the wall of the hole held nothing.

    Examples
    --------
    At rest the static deflections, 10 N on 1 and 2 N/µm:

    >>> [round(1e6 * a, 6) for a in whirl_amplitudes(np.diag([1e-6, 5e-7]), 10.0, 1.0, 0.01, 0.0)]
    [10.0, 5.0]

    References
    ----------
    Derived here: the forced vibration of a mass on two springs.
    """
    stiffness = np.linalg.eigvalsh(np.linalg.inv(np.asarray(lateral_compliance)))
    found = []
    for k in stiffness:
        dynamic = complex(k - mass * speed**2, 2.0 * damping_ratio * math.sqrt(k * mass) * speed)
        found.append(force / abs(dynamic))
    return found[0], found[1]
