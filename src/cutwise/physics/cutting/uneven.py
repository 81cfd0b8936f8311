r"""Flutes that do not cut alike, or not in proportion to the chip: run-out and Kienzle's power law, by quadrature.

Run-out puts the tool axis :math:`\rho` off the spindle axis; the flute at immersion angle :math:`\phi` then turns with
the radius :math:`R + \rho \cos a`, :math:`a = \phi - \Phi - \lambda` its angle from the direction of the run-out. A
flute removes what the flutes before it have left,

.. math:: h = \max\bigl(0,\ \min_{m = 1 \dots N} [\, m c \sin(\phi - \vartheta)
          + \rho (\cos a - \cos(a + 2\pi m / N)) ]\bigr).

Summed over single flutes this is the tooth-resolved force; with all angles taken alike it is the force averaged over a
tooth but not over a turn, which keeps the once-per-turn force that shakes the spindle.
"""

import math
from typing import NamedTuple

from cutwise.maths.compiled import compiled, inlined
from cutwise.physics.cutting.flute import EdgeCoefficients, FluteForce, Mill
from cutwise.physics.cutting.helix import edge_in_cut, flutes_in_cut, helix_lag
from cutwise.physics.cutting.kienzle import specific_cutting_force

LINEAR = 0
KIENZLE = 1

_POINT = 0.7745966692414834  # three-point Gauss rule on -1 to 1: place and weight of each point, weights of sum one
GAUSS = ((-_POINT, 5.0 / 18.0), (0.0, 8.0 / 18.0), (_POINT, 5.0 / 18.0))
PANEL = 0.12  # [rad] widest panel of the rule
TURN = 60  # rotations in the mean over a turn


class Kienzle(NamedTuple):
    """Power-law coefficients of a material and tool pair, specific forces at 1 mm of chip thickness."""

    k_c11: float  # [Pa] tangential
    m_c: float
    k_r11: float  # [Pa] radial
    m_r: float
    k_a11: float  # [Pa] axial
    m_a: float


NO_KIENZLE = Kienzle(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
NO_LINEAR = EdgeCoefficients(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Edges(NamedTuple):
    """How the edges cut: force law, and the run-out of the tool."""

    law: int  # LINEAR or KIENZLE
    linear: EdgeCoefficients
    kienzle: Kienzle
    runout: float  # [m] offset of the tool axis from the spindle axis
    runout_angle: float  # [rad] its direction, from flute 0 at the tip in the sense of turning


def kienzle_edges(coefficients: Kienzle) -> Edges:
    """Edges by Kienzle's law that all cut alike."""
    return Edges(KIENZLE, NO_LINEAR, coefficients, 0.0, 0.0)


def even_edges(coefficients: EdgeCoefficients) -> Edges:
    """Linear edges that all cut alike."""
    return Edges(LINEAR, coefficients, NO_KIENZLE, 0.0, 0.0)


@inlined
def even_and_linear(edges: Edges) -> bool:
    """Whether the closed forms of :mod:`cutwise.physics.cutting.flute` hold: no run-out, linear force. Exact; derived here.

    Parameters
    ----------
    edges : Edges
        Force law and run-out.

    Examples
    --------
    >>> even_and_linear(even_edges(NO_LINEAR)), even_and_linear(kienzle_edges(NO_KIENZLE))
    (True, False)
    """
    return edges.law == LINEAR and edges.runout == 0.0


@compiled
def chip_thickness(chip: float, swing: float, around: float, runout: float, flutes: int) -> float:
    r"""Chip thickness of a flute under run-out [m].

    .. math:: h = \max\bigl(0,\ \min_{m = 1 \dots N} [\, m c \sin(\phi - \vartheta)
              + \rho (\cos a - \cos(a + 2\pi m / N)) ]\bigr)

    Parameters
    ----------
    chip : float
        Feed per tooth c [m].
    swing : float
        :math:`\sin(\phi - \vartheta)`; not positive: no chip.
    around : float
        Angle a of the flute from the direction of the run-out [rad].
    runout : float
        Run-out :math:`\rho` [m].
    flutes : int
        Number of flutes N, evenly spaced.

    Notes
    -----
    Valid for :math:`\rho, c \ll R`, a steady feed, and the same run-out at every height of the edge.

    Examples
    --------
    0.1 mm per tooth and 20 µm of run-out: the outer of two flutes takes 40 µm more, the other so much less.

    >>> [round(1e6 * chip_thickness(1e-4, 1.0, a, 2e-5, 2), 6) for a in (0.0, math.pi)]
    [140.0, 60.0]

    References
    ----------
    Derived here; the radii of single flutes and the least over earlier ones are those of Kline and DeVor 1983.
    """
    feed = chip * swing
    if feed <= 0.0:
        return 0.0
    least = flutes * feed
    here = math.cos(around)
    for m in range(1, flutes):
        if m * feed - runout * (1.0 - here) > least:
            break  # no later flute can have left less
        left = m * feed + runout * (here - math.cos(around + 2.0 * math.pi * m / flutes))
        least = min(least, left)
    return max(0.0, least)


@compiled
def force_per_length(edges: Edges, h: float) -> tuple[float, float, float]:
    r"""Tangential, radial and axial force of a length of edge at a chip thickness; nothing without a chip [N/m].

    .. math:: f_q = K_{qc} h + K_{qe} \quad\text{or}\quad f_q = k_{q1.1}\, h\, (h / 1\,\mathrm{mm})^{-m_q}

    Parameters
    ----------
    edges : Edges
        Force law.
    h : float
        Chip thickness [m]; not positive: no force.

    Returns
    -------
    tuple
        Tangential, radial and axial [N/m].

    Notes
    -----
    Valid for the chips for which the coefficients were fitted; Kienzle's law is held below 0.1 µm.

    Examples
    --------
    >>> [round(f) for f in force_per_length(even_edges(EdgeCoefficients(2e9, 1e9, 5e8, 1e4, 2e4, 3e3)), 1e-4)]
    [210000, 120000, 53000]

    References
    ----------
    Berselli et al. 2016, Eq. (3); Kienzle 1952.
    """
    if h <= 0.0:
        return 0.0, 0.0, 0.0
    if edges.law == KIENZLE:
        k = edges.kienzle
        return (
            specific_cutting_force(k.k_c11, k.m_c, h) * h,
            specific_cutting_force(k.k_r11, k.m_r, h) * h,
            specific_cutting_force(k.k_a11, k.m_a, h) * h,
        )
    c = edges.linear
    return c.K_tc * h + c.K_te, c.K_rc * h + c.K_re, c.K_ac * h + c.K_ae


def tangent_coefficients(edges: Edges, h: float) -> EdgeCoefficients:
    r"""Linear-edge coefficients that touch the force law at a chip thickness, for small changes of the chip.

    .. math:: K_c = dF/dh, \qquad K_e = F - K_c h

    Parameters
    ----------
    edges : Edges
        Force law; a linear one is given back.
    h : float
        Chip thickness [m], positive: above 0.1 µm, and changes small against it.
        Derived here from the law of Kienzle 1952.

    Examples
    --------
    At 1 mm of chip :math:`K_c = (1 - m)\, k_{1.1}`:

    >>> round(tangent_coefficients(kienzle_edges(Kienzle(1e9, 0.25, 1e9, 0.25, 1e9, 0.25)), 1e-3).K_tc)
    750000000
    """
    if edges.law == LINEAR:
        return edges.linear
    k = edges.kienzle
    force = force_per_length(edges, h)
    slopes = [(1.0 - m) * f / h for f, m in zip(force, (k.m_c, k.m_r, k.m_a), strict=True)]
    return EdgeCoefficients(*slopes, *(f - slope * h for f, slope in zip(force, slopes, strict=True)))


@compiled
def uneven_arc_force(
    chip: float, theta: float, middle: float, span: float, length: float, rotation: float, flutes: int, edges: Edges
) -> FluteForce:
    r"""Force of edge elements spread evenly over an arc: :func:`~cutwise.physics.cutting.flute.arc_force` by quadrature.

    Composite three-point Gauss rule. Without run-out it converges to the closed form at sixth order; the kinks that
    run-out puts into the chip thickness leave an error of about 1e-3 of the force.

    Parameters
    ----------
    chip, theta : float
        Feed per tooth [m] and feed direction [rad].
    middle, span : float
        Middle and width of the arc [rad]; the width may be negative for a left-hand helix.
    length : float
        Edge length in the arc [m].
    rotation : float
        Rotation :math:`\Phi` of the mill [rad].
    flutes : int
        Number of flutes N.
    edges : Edges
        Force law and run-out.

    Returns
    -------
    FluteForce
        Force on the tool [N]; valid for any arc, as there is no force without a chip.

    Examples
    --------
    The slot of :func:`~cutwise.physics.cutting.flute.arc_force`:

    >>> edges = even_edges(EdgeCoefficients(1e9, 0.0, 0.0, 0.0, 0.0, 0.0))
    >>> f = uneven_arc_force(1e-4, 0.0, 0.5 * math.pi, math.pi, 1e-3, 0.0, 2, edges)
    >>> round(f.y, 5), round(f.tangential, 5)
    (50.0, 63.66198)

    References
    ----------
    Berselli et al. 2016, Eqs. (3)-(5) and (9), without their closed form (10).
    """
    x = y = z = tangential = 0.0
    panels = max(1, math.ceil(abs(span) / PANEL))
    width = span / panels
    part = length / panels
    for panel in range(panels):
        centre = middle + (panel - 0.5 * (panels - 1)) * width
        for i in range(3):
            phi = centre + 0.5 * GAUSS[i][0] * width
            around = phi - rotation - edges.runout_angle
            h = chip_thickness(chip, math.sin(phi - theta), around, edges.runout, flutes)
            ft, fr, fa = force_per_length(edges, h)
            weight = part * GAUSS[i][1]
            sin_phi, cos_phi = math.sin(phi), math.cos(phi)
            x += weight * (-ft * cos_phi - fr * sin_phi)
            y += weight * (ft * sin_phi - fr * cos_phi)
            z += weight * fa
            tangential += weight * ft
    return FluteForce(x, y, z, tangential)


@compiled
def turning_mean_force(
    rotation: float, lo: float, hi: float, chip: float, theta: float, width: float, mill: Mill, edges: Edges
) -> FluteForce:
    """Force averaged over a tooth but not over a turn, for any force law and run-out.

    Parameters are those of :func:`cutwise.physics.cutting.flute.mean_force`, with the rotation of the mill [rad]: all
    flutes are taken at one angle from the run-out, which keeps the force that turns with the spindle [N].

    Valid as :func:`uneven_arc_force` is.

    Examples
    --------
    The slot of :func:`~cutwise.physics.cutting.flute.mean_force`, without run-out:

    >>> edges = even_edges(EdgeCoefficients(1e9, 0.0, 0.0, 0.0, 0.0, 0.0))
    >>> round(turning_mean_force(0.0, 0.0, math.pi, 1e-4, 0.0, 1e-3, Mill(5e-3, 2, 0.0), edges).y, 5)
    50.0

    References
    ----------
    Derived here from Berselli et al. 2016, Eqs. (3), (4) and (9).
    """
    if hi <= lo or width <= 0.0:
        return FluteForce(0.0, 0.0, 0.0, 0.0)
    span = hi - lo
    length = mill.flutes * width * span / (2.0 * math.pi)
    return uneven_arc_force(chip, theta, 0.5 * (lo + hi), span, length, rotation, mill.flutes, edges)


@compiled
def whole_turn_force(
    lo: float, hi: float, chip: float, theta: float, width: float, mill: Mill, edges: Edges
) -> FluteForce:
    r"""Force averaged over a whole turn, for any force law and run-out.

    .. math:: \bar F = \frac{1}{2\pi} \int_0^{2\pi} F(\Phi)\, d\Phi

    by equal steps of the rotation :math:`\Phi`; which way the run-out points from flute 0 does not count (for one
    direction the teeth differ from it by 4 % at most with a run-out of a third of the chip). A linear law without a
    tooth that leaves the cut keeps the mean of even flutes: what one tooth cuts less, the next cuts more. Parameters
    are those of :func:`turning_mean_force`.

    Valid as :func:`uneven_arc_force` is [N].

    Examples
    --------
    10 µm of run-out on an arc from 45 to 135 degrees: :math:`N b K_{tc} c \sqrt{2} / 2\pi`, as without it.

    >>> edges = even_edges(EdgeCoefficients(1e9, 0.0, 0.0, 0.0, 0.0, 0.0))._replace(runout=1e-5)
    >>> lo, mill = 0.25 * math.pi, Mill(5e-3, 2, 0.0)
    >>> round(whole_turn_force(lo, 3.0 * lo, 1e-4, 0.0, 1e-3, mill, edges).tangential, 5)
    45.01582

    References
    ----------
    Derived here from Berselli et al. 2016, Eqs. (3), (4) and (9).
    """
    steps = TURN if edges.runout != 0.0 else 1
    x = y = z = tangential = 0.0
    for k in range(steps):
        f = turning_mean_force(2.0 * math.pi * (k + 0.5) / steps, lo, hi, chip, theta, width, mill, edges)
        x += f.x / steps
        y += f.y / steps
        z += f.z / steps
        tangential += f.tangential / steps
    return FluteForce(x, y, z, tangential)


@compiled
def uneven_tooth_force(
    rotation: float,
    lo: float,
    hi: float,
    chip: float,
    theta: float,
    z_lo: float,
    z_hi: float,
    mill: Mill,
    edges: Edges,
) -> FluteForce:
    """Instantaneous force of all flutes, for any force law and run-out.

    Parameters are those of :func:`cutwise.physics.cutting.flute.tooth_force`, with the force law in place of coefficients.

    Valid as :func:`uneven_arc_force` is [N].

    Examples
    --------
    The flute of :func:`~cutwise.physics.cutting.flute.tooth_force`, half a turn of it in a slot:

    >>> edges, mill = even_edges(EdgeCoefficients(1e9, 0.0, 0.0, 0.0, 0.0, 0.0)), Mill(5e-3, 1, 0.25 * math.pi)
    >>> round(uneven_tooth_force(math.pi, 0.0, math.pi, 1e-4, 0.0, 0.0, 0.03, mill, edges).y, 4)
    785.3982

    References
    ----------
    Berselli et al. 2016, Eqs. (2)-(5), (7) and (9), without their closed form (10).
    """
    x = y = z = tangential = 0.0
    if hi <= lo or z_hi <= z_lo:
        return FluteForce(x, y, z, tangential)
    lag = helix_lag(mill.helix, mill.radius)
    first, last = flutes_in_cut(rotation, lo, hi, z_lo, z_hi, mill.flutes, lag)
    for flute in range(first, last + 1):
        z1, z2, middle, span = edge_in_cut(rotation, flute, lo, hi, z_lo, z_hi, mill.flutes, lag)
        if z2 <= z1:
            continue
        f = uneven_arc_force(chip, theta, middle, span, z2 - z1, rotation, mill.flutes, edges)
        x += f.x
        y += f.y
        z += f.z
        tangential += f.tangential
    return FluteForce(x, y, z, tangential)


def largest_radius(runout: float, runout_angle: float, flutes: int) -> float:
    r"""How far the outermost flute stands out, :math:`\max_j \rho \cos(\lambda - 2\pi j / N)` [m].

    The surface is cut by that flute: by so much deeper than without run-out. First order, derived here.

    Parameters
    ----------
    runout : float
        Offset :math:`\rho` of the tool axis from the spindle axis [m], small against the radius.
    runout_angle : float
        Its direction :math:`\lambda` from flute 0 [rad].
    flutes : int
        Number of flutes N, evenly spaced.

    Examples
    --------
    >>> round(1e6 * largest_radius(1e-5, math.pi / 4, 4), 6)  # between two of four flutes: 10 / sqrt(2)
    7.071068
    """
    return max(runout * math.cos(runout_angle - 2.0 * math.pi * j / flutes) for j in range(flutes))
