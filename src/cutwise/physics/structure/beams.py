"""Timoshenko cantilevers: columns, part blocks and round tools as 6x6 compliances at their free end."""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.frames import FloatArray


class Section(NamedTuple):
    """Cross-section of a beam along z."""

    area: float  # A [m^2]
    second_moment_x: float  # I_x [m^4], resists bending about x (deflection in y)
    second_moment_y: float  # I_y [m^4], resists bending about y (deflection in x)
    torsion: float  # J [m^4]
    shear_factor: float  # k_s, share of the area that carries shear, same in x and y


def box_section(width_x: float, width_y: float, wall: float, *, shear_factor: float) -> Section:
    r"""Closed box of outer widths :math:`b_x, b_y` and wall :math:`w` [m]; torsion after Bredt.

    .. math:: J = \frac{4 A_m^2 w}{2[(b_x - w) + (b_y - w)]}, \qquad A_m = (b_x - w)(b_y - w)

    Valid for thin walls; :math:`0 < 2w < b_x, b_y`.

    Raises
    ------
    ValueError
        The wall does not fit.

    References
    ----------
    Bredt 1896; Young and Budynas, Roark's Formulas for Stress and Strain, 7th ed., table 10.1.
    """
    inner_x, inner_y = width_x - 2.0 * wall, width_y - 2.0 * wall
    if wall <= 0.0 or inner_x <= 0.0 or inner_y <= 0.0:
        raise ValueError(f"a box of {width_x:g} m x {width_y:g} m has no wall of {wall:g} m")
    middle_x, middle_y = width_x - wall, width_y - wall
    return Section(
        area=width_x * width_y - inner_x * inner_y,
        second_moment_x=(width_x * width_y**3 - inner_x * inner_y**3) / 12.0,
        second_moment_y=(width_y * width_x**3 - inner_y * inner_x**3) / 12.0,
        torsion=4.0 * (middle_x * middle_y) ** 2 * wall / (2.0 * (middle_x + middle_y)),
        shear_factor=shear_factor,
    )


def block_section(width_x: float, width_y: float, *, shear_factor: float = 5.0 / 6.0) -> Section:
    r"""Solid rectangle of sides [m]; with :math:`a \ge b` its sides,

    .. math:: J = a b^3 \left[\tfrac13 - 0.21 \tfrac{b}{a}\left(1 - \tfrac{b^4}{12 a^4}\right)\right]

    which is within 0.5 % of the series solution.

    Raises
    ------
    ValueError
        A side is not positive.

    References
    ----------
    Young and Budynas, Roark's Formulas for Stress and Strain, 7th ed., table 10.1.
    """
    if width_x <= 0.0 or width_y <= 0.0:
        raise ValueError(f"a block needs positive sides, got {width_x:g} m and {width_y:g} m")
    long, short = max(width_x, width_y), min(width_x, width_y)
    ratio = short / long
    return Section(
        area=width_x * width_y,
        second_moment_x=width_x * width_y**3 / 12.0,
        second_moment_y=width_y * width_x**3 / 12.0,
        torsion=long * short**3 * (1.0 / 3.0 - 0.21 * ratio * (1.0 - ratio**4 / 12.0)),
        shear_factor=shear_factor,
    )


def round_section(diameter: float, *, filling: float = 1.0, shear_factor: float = 0.9) -> Section:
    r"""Round bar of diameter d [m]; a fluted tool keeps the share ``filling`` of area and second moments.

    .. math:: A = \phi \pi d^2/4, \qquad I = \phi \pi d^4/64, \qquad J = 2I

    Raises
    ------
    ValueError
        The diameter or the filling is not positive.

    Valid for one filling for all of them; flutes resist bending a little less than their area says.

    References
    ----------
    Young and Budynas, Roark's Formulas for Stress and Strain, 7th ed., tables A.1 and 10.1; filling as the effective
    diameter of Kops and Vo 1990, CIRP Annals 39.
    """
    if diameter <= 0.0 or filling <= 0.0:
        raise ValueError(f"a round tool needs a positive diameter and filling, got {diameter:g} m and {filling:g}")
    second = filling * math.pi * diameter**4 / 64.0
    return Section(filling * math.pi * diameter**2 / 4.0, second, second, 2.0 * second, shear_factor)


def cantilever(
    section: Section, length: float, youngs_modulus: float, shear_modulus: float, *, downward: bool = False
) -> FloatArray:
    r"""Compliance of a cantilever along +z, load and displacement at its free end.

    .. math::
        C_{xx} = \frac{L^3}{3EI_y} + \frac{L}{k_s G A}, \quad C_{\varphi_y\varphi_y} = \frac{L}{EI_y}, \quad
        C_{x\varphi_y} = \frac{L^2}{2EI_y}, \quad
        C_{yy} = \frac{L^3}{3EI_x} + \frac{L}{k_s G A}, \quad C_{\varphi_x\varphi_x} = \frac{L}{EI_x}

        C_{y\varphi_x} = -\frac{L^2}{2EI_x}, \quad C_{zz} = \frac{L}{EA}, \quad C_{\varphi_z\varphi_z} = \frac{L}{GJ}

    Parameters
    ----------
    section : Section
        Cross-section.
    length : float
        L [m], positive.
    youngs_modulus, shear_modulus : float
        E, G [Pa].
    downward : bool
        The beam hangs along -z: :math:`S C S` with :math:`S = \mathrm{diag}(1,1,-1,-1,-1,1)`.

    Returns
    -------
    array (6, 6)
        Displacement [m], rotation [rad] per force [N], moment [N m].

    Raises
    ------
    ValueError
        A length or modulus that is not positive.

    References
    ----------
    Timoshenko 1921; shear factors after Cowper 1966.
    """
    if length <= 0.0 or youngs_modulus <= 0.0 or shear_modulus <= 0.0:
        raise ValueError("a cantilever needs positive length and moduli")
    bending_x = 1.0 / (youngs_modulus * section.second_moment_x)
    bending_y = 1.0 / (youngs_modulus * section.second_moment_y)
    shear = length / (section.shear_factor * shear_modulus * section.area)
    compliance = np.zeros((6, 6))
    compliance[0, 0] = length**3 / 3.0 * bending_y + shear
    compliance[1, 1] = length**3 / 3.0 * bending_x + shear
    compliance[2, 2] = length / (youngs_modulus * section.area)
    compliance[3, 3], compliance[4, 4] = length * bending_x, length * bending_y
    compliance[5, 5] = length / (shear_modulus * section.torsion)
    compliance[0, 4] = compliance[4, 0] = length**2 / 2.0 * bending_y
    compliance[1, 3] = compliance[3, 1] = -(length**2) / 2.0 * bending_x
    if downward:
        sign = np.array([1.0, 1.0, -1.0, -1.0, -1.0, 1.0])
        compliance *= sign[:, None] * sign[None, :]
    return compliance
