"""Geometric errors of axes: the functions of ISO 230-1 and ISO 230-7, given as tables, polynomials, sines or drawn.

An axis has six functions of its command u, three displacements [m] and three rotations [rad] of the moving body
against the one that carries it, at the origin of the moving body's frame: EXA, EYA, EZA, EAA, EBA, ECA for axis A.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cutwise.maths.frames import FloatArray

COMPONENTS = ("X", "Y", "Z", "A", "B", "C")  # second letter of an ISO 230-1 name, in the order of a twist


class OutsideTableError(ValueError):
    """An axis is commanded beyond the table of its errors."""


class Table(NamedTuple):
    """Measured values, straight between them."""

    at: FloatArray  # commands, rising [m or rad], shape (k,)
    value: FloatArray  # [m or rad], shape (k,)

    def __call__(self, u: FloatArray) -> FloatArray:
        """Value at u.

        Raises
        ------
        OutsideTableError
            u leaves the table.
        """
        low, high = self.at[0], self.at[-1]
        if u.size and (u.min() < low or u.max() > high):
            raise OutsideTableError(
                f"commanded {u.min():g} to {u.max():g}, but the error table covers {low:g} to {high:g} (SI)"
            )
        return np.interp(u, self.at, self.value)


class Polynomial(NamedTuple):
    """:math:`\\sum_k c_k u^k`."""

    coefficient: FloatArray  # rising powers [m/m^k, rad/m^k ...], shape (d + 1,)

    def __call__(self, u: FloatArray) -> FloatArray:
        """Value at u."""
        return np.polynomial.polynomial.polyval(u, self.coefficient)  # type: ignore[return-value]


class Sines(NamedTuple):
    """:math:`\\sum_m a_m \\sin(2\\pi m u / \\lambda + p_m)`, m = 1, 2, ..."""

    amplitude: FloatArray  # a_m [m or rad], shape (k,)
    phase: FloatArray  # p_m [rad], shape (k,)
    wavelength: float  # of the first [m or rad]

    def __call__(self, u: FloatArray) -> FloatArray:
        """Value at u."""
        orders = np.arange(1, len(self.amplitude) + 1)
        angle = 2.0 * math.pi / self.wavelength * np.multiply.outer(u, orders) + self.phase
        return np.sin(angle) @ self.amplitude


ErrorFunction = Callable[[FloatArray], FloatArray] | Table | Polynomial | Sines


def random_sines(deviation: float, *, wavelength: float, orders: int, generator: np.random.Generator) -> Sines:
    r"""A smooth random error with given standard deviation over command and draws.

    Amplitudes are normal with :math:`\sigma\sqrt{2/k}`, phases uniform, for k orders.

    Parameters
    ----------
    deviation : float
        :math:`\sigma` [m or rad].
    wavelength : float
        Of the first order [m or rad]; of the order of the travel.
    orders : int
        k, number of sines.
    generator : numpy Generator
        Seeded by the caller.

    References
    ----------
    Derived here: each sine has half the square of its amplitude as its mean square.
    """
    amplitude = generator.normal(0.0, deviation * math.sqrt(2.0 / orders), orders)
    return Sines(amplitude, generator.uniform(0.0, 2.0 * math.pi, orders), wavelength)


class AxisErrors(NamedTuple):
    """All errors of one axis."""

    motion: Sequence[ErrorFunction | None]  # six functions of the command, None for no error
    direction: FloatArray  # unit vector that the moving body goes along or turns about, shape (3,)
    squareness: FloatArray  # [rad] turns the direction of a linear motion, adds no rotation, shape (3,)
    location: FloatArray  # constant twist before the motion (ISO 230-7 location errors) [m, rad], shape (6,)
    linear: bool  # command is a length
    before: bool = False  # the six functions act before the motion, in the frame that stands, instead of after it


def motion_twist(errors: AxisErrors, command: ArrayLike) -> FloatArray:
    r"""Error twist of the moving body after its motion (or before it, see :class:`AxisErrors`), shape (..., 6).

    .. math:: e(u) = (E_{XA}, E_{YA}, E_{ZA}) + s \times a\,u, \qquad \varepsilon(u) = (E_{AA}, E_{BA}, E_{CA})

    with the squareness :math:`s` of the axis: it turns the direction of motion a and adds no rotation (B0Z and A0Z of a
    Z axis give (B0Z z, -A0Z z, 0), C0Y of a Y axis (-C0Y y, 0, 0)).

    References
    ----------
    ISO 230-1:2012, sec. 3; ISO 230-7.
    """
    u = np.asarray(command, dtype=float)
    twist = np.zeros((*u.shape, 6))
    for component, function in enumerate(errors.motion):
        if function is not None:
            twist[..., component] = function(u)
    if errors.linear:
        twist[..., :3] += u[..., None] * np.cross(errors.squareness, errors.direction)
    return twist
