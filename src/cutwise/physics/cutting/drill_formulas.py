"""Thrust and torque of twist drills by the formulas of handbooks and makers: plausibility, not validation.

They disagree among themselves by a factor of two in thrust (conventional against thinned point), so they bound a
prediction and do not confirm it.
"""

import math
from typing import NamedTuple


class ThrustTorque(NamedTuple):
    """Thrust and torque in full contact."""

    thrust: float  # [N]
    torque: float  # [N m]


def half_specific_force(specific: float, diameter: float, feed: float, half_point_angle: float) -> ThrustTorque:
    r"""Carbide drill with thinned point, from the specific cutting force.

    .. math:: T = 0.5\, k_c \frac{D}{2} f \sin\kappa, \qquad M = k_c \frac{f D^2}{8}

    Parameters
    ----------
    specific : float
        :math:`k_c` [Pa] at the chip thickness :math:`(f/2)\sin\kappa`.
    diameter, feed : float
        :math:`D` and feed per revolution :math:`f` [m].
    half_point_angle : float
        :math:`\kappa` [rad].

    Examples
    --------
    >>> thrust, torque = half_specific_force(2e9, 1e-2, 2e-4, math.pi / 2)
    >>> round(thrust, 6), round(torque, 9)
    (1000.0, 5.0)

    References
    ----------
    Sandvik Coromant, training handbook of metal cutting, drilling.
    """
    thrust = 0.25 * specific * diameter * feed * math.sin(half_point_angle)
    return ThrustTorque(thrust, specific * feed * diameter**2 / 8.0)


def shaw_oxford(brinell: float, diameter: float, feed: float) -> ThrustTorque:
    r"""Conventional HSS drill in steel, chisel edge 0.18 D.

    .. math::
        T = 0.195\,c H f^{0.8} D^{0.8} + 0.0022\,H D^2, \qquad M = 0.087\,c H f^{0.8} D^{1.8}, \qquad c = 25.4^{0.4}

    with :math:`f, D` in mm, :math:`H = 9.81` HB in N/mm², :math:`T` in N, :math:`M` in N mm; :math:`c` belongs to the
    constants, which were fitted in inches: leaving it out is a factor 3.6.

    Parameters
    ----------
    brinell : float
        Brinell hardness [HB].
    diameter, feed : float
        :math:`D` and feed per revolution :math:`f` [m].

    Examples
    --------
    H = 100 N/mm², 1 mm, 1 mm: 19.5 and 8.7 times 25.4^0.4, and 0.22 N of the chisel edge.

    >>> thrust, torque = shaw_oxford(100 / 9.81, 1e-3, 1e-3)
    >>> round((thrust - 0.22) / 19.5, 6), round(1e3 * torque / 8.7, 6)
    (3.646981, 3.646981)

    References
    ----------
    Shaw and Oxford 1957, constants recalled, not read.
    """
    hardness, inches = 9.81 * brinell, 25.4**0.4
    d, f = 1e3 * diameter, 1e3 * feed
    thrust = 0.195 * inches * hardness * f**0.8 * d**0.8 + 0.0022 * hardness * d**2
    return ThrustTorque(thrust, 1e-3 * 0.087 * inches * hardness * f**0.8 * d**1.8)


def tungaloy(material_factor: float, diameter: float, feed: float) -> ThrustTorque:
    r"""Conventional twist drill by the maker's catalogue.

    .. math:: T = 570\, K D f^{0.85}, \qquad M = \tfrac{1}{100} K D^2 (0.630 + 16.84 f)

    with :math:`D, f` in mm, :math:`T` in N, :math:`M` in N m.

    Parameters
    ----------
    material_factor : float
        :math:`K` [1] of the catalogue's table: cast iron 1.0, aluminium 1.01, steels 1.4 to 3.4.
    diameter, feed : float
        :math:`D` and feed per revolution :math:`f` [m].

    Examples
    --------
    >>> thrust, torque = tungaloy(1.0, 1e-2, 1e-3)
    >>> round(thrust, 6), round(torque, 6)
    (5700.0, 17.47)

    References
    ----------
    Tungaloy general catalogue 2020-21, technical reference, p. L068.
    """
    d, f = 1e3 * diameter, 1e3 * feed
    return ThrustTorque(570.0 * material_factor * d * f**0.85, material_factor * d**2 * (0.630 + 16.84 * f) / 100.0)
