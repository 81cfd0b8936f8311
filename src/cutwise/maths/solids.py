"""Mass, centre and inertia of cylinders on one axis: what a turned body amounts to, in closed form."""

import math
from collections.abc import Iterable
from typing import NamedTuple


class Cylinder(NamedTuple):
    """A solid or hollow cylinder on the axis."""

    start: float  # [m] along the axis
    length: float  # [m]
    radius: float  # [m]
    density: float  # [kg/m^3]
    bore: float = 0.0  # [m] radius of the hole through it

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.density * math.pi * (self.radius**2 - self.bore**2) * self.length


class BodyMass(NamedTuple):
    """Mass properties of a body about a point of its axis."""

    mass: float  # [kg]
    centre: float  # [m] of mass, along the axis from that point
    inertia: float  # [kg m^2] about that point, across the axis
    axial_inertia: float  # [kg m^2] about the axis


def coaxial(members: Iterable[Cylinder]) -> BodyMass:
    r"""Mass properties of cylinders on one axis, about its origin.

    .. math:: I = \sum_i m_i \left( \frac{r_i^2 + b_i^2}{4} + \frac{l_i^2}{12} + d_i^2 \right), \qquad
              I_a = \sum_i m_i \frac{r_i^2 + b_i^2}{2}

    with radius r, bore b, length l and distance d of the middle from the origin.

    References
    ----------
    Cylinder and theorem of Steiner.
    """
    mass = moment = inertia = axial = 0.0
    for one in members:
        m, d = one.mass, one.start + 0.5 * one.length
        round_it = one.radius**2 + one.bore**2
        mass += m
        moment += m * d
        inertia += m * (round_it / 4.0 + one.length**2 / 12.0 + d * d)
        axial += m * round_it / 2.0
    return BodyMass(mass, moment / mass if mass > 0.0 else 0.0, inertia, axial)
