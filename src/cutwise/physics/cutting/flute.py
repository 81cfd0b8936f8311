r"""The one helical-flute kernel: linear-edge cutting forces of an end mill over any immersion arcs.

Frame and signs: x feed, y normal from the work to the tool, z along the spindle. A tooth sits at
:math:`(R \sin\phi, R \cos\phi)`, the immersion angle :math:`\phi` running clockwise from +y, so the lowest point of
the mill is at :math:`\phi = \pi`. Forces are on the tool. The sign of :math:`F_z` is the paper's: positive for positive
axial coefficients, although a right-hand helix pulls the tool towards the work.

Burr, part, slot and corner differ in their arcs only; the force integrals are these.
"""

import math
from typing import NamedTuple

from cutwise.maths.compiled import compiled, inlined
from cutwise.physics.cutting.helix import edge_in_cut, flutes_in_cut, helix_lag


class EdgeCoefficients(NamedTuple):
    """Linear-edge coefficients of a material and tool pair."""

    K_tc: float  # [Pa] tangential, shearing
    K_rc: float  # [Pa] radial, shearing
    K_ac: float  # [Pa] axial, shearing
    K_te: float  # [N/m] tangential, edge
    K_re: float  # [N/m] radial, edge
    K_ae: float  # [N/m] axial, edge


class Mill(NamedTuple):
    """Cylindrical end mill."""

    radius: float  # [m]
    flutes: int
    helix: float  # [rad]


class FluteForce(NamedTuple):
    """Force of a flute, or of all flutes, on the tool."""

    x: float  # [N] along the feed
    y: float  # [N] off the work
    z: float  # [N] along the spindle, sign as in the paper
    tangential: float  # [N] tangential force, summed over the edges in cut


NO_FORCE = FluteForce(0.0, 0.0, 0.0, 0.0)


@inlined
def sinc(x: float) -> float:
    r"""Unnormalised :math:`\sin x / x`, by its series near zero so that :math:`\beta = 0` is nothing special.

    Valid for any x [rad]; the series is used below 1e-4, where it is right to the last digit.

    Examples
    --------
    >>> round(sinc(0.5 * math.pi), 9), sinc(0.0)  # 2/pi, 1
    (0.636619772, 1.0)

    References
    ----------
    Derived here: its Taylor series.
    """
    if abs(x) < 1e-4:
        return 1.0 - x * x / 6.0
    return math.sin(x) / x


@inlined
def arc_force(
    chip: float, theta: float, middle: float, span: float, length: float, coefficients: EdgeCoefficients
) -> FluteForce:
    r"""Force of edge elements spread evenly over an arc.

    .. math::
        F_x &= -K_{tc} c I_{sc} - K_{rc} c I_{ss} - K_{te} I_c - K_{re} I_s \\
        F_y &= \phantom{-}K_{tc} c I_{ss} - K_{rc} c I_{sc} + K_{te} I_s - K_{re} I_c \\
        F_z &= \phantom{-}K_{ac} c I_h + K_{ae} L

    with the means over the arc, times the edge length L,
    :math:`I_{sc} = \tfrac{L}{2} [\sin(2\phi_m - \vartheta) S - \sin\vartheta]`,
    :math:`I_{ss} = \tfrac{L}{2} [\cos\vartheta - \cos(2\phi_m - \vartheta) S]`,
    :math:`I_h = L \sin(\phi_m - \vartheta) S_1`, :math:`I_c = L \cos\phi_m S_1`, :math:`I_s = L \sin\phi_m S_1`,
    :math:`S = \operatorname{sinc}\Delta`, :math:`S_1 = \operatorname{sinc}(\Delta/2)`.

    A flute of a helical mill between z1 and z2 spans :math:`\Delta = k_\beta (z_2 - z_1)` with
    :math:`L = z_2 - z_1`; the mean over a tooth period spans the whole arc with
    :math:`L = N b \Delta / 2\pi`. The form has no singularity at zero helix.

    Parameters
    ----------
    chip : float
        Feed per tooth c [m].
    theta : float
        Feed direction [rad].
    middle, span : float
        Middle and width of the arc [rad].
    length : float
        Edge length in the arc [m].
    coefficients : EdgeCoefficients
        Cutting coefficients.

    Returns
    -------
    FluteForce
        Force on the tool [N].

    Notes
    -----
    Valid where the chip :math:`c \sin(\phi - \vartheta)` is not negative, :math:`\vartheta \le \phi \le \vartheta + \pi`
    (not asked here: the arcs see to it), and :math:`c \ll R`, so that the path of a tooth is a circle.

    Examples
    --------
    An edge of 1 mm spread over a slot, chip 0.1 mm, tangential force alone: :math:`K_{tc} c L / 2` across the feed,
    :math:`2 K_{tc} c L / \pi` along the edges.

    >>> f = arc_force(1e-4, 0.0, 0.5 * math.pi, math.pi, 1e-3, EdgeCoefficients(1e9, 0.0, 0.0, 0.0, 0.0, 0.0))
    >>> round(f.y, 6), round(f.tangential, 5)
    (50.0, 63.66198)

    References
    ----------
    Berselli et al. 2016, Eqs. (6) and (10), corrected: the printed F_y is wrong in both.
    """
    sin_m, cos_m = math.sin(middle), math.cos(middle)
    sin_t, cos_t = math.sin(theta), math.cos(theta)
    half = sinc(0.5 * span)
    full = half * math.cos(0.5 * span)
    sin_h = sin_m * cos_t - cos_m * sin_t  # of middle - theta
    cos_h = cos_m * cos_t + sin_m * sin_t
    i_sc = 0.5 * length * ((sin_m * cos_h + cos_m * sin_h) * full - sin_t)
    i_ss = 0.5 * length * (cos_t - (cos_m * cos_h - sin_m * sin_h) * full)
    i_h = length * sin_h * half
    i_c = length * cos_m * half
    i_s = length * sin_m * half
    k = coefficients
    return FluteForce(
        -k.K_tc * chip * i_sc - k.K_rc * chip * i_ss - k.K_te * i_c - k.K_re * i_s,
        k.K_tc * chip * i_ss - k.K_rc * chip * i_sc + k.K_te * i_s - k.K_re * i_c,
        k.K_ac * chip * i_h + k.K_ae * length,
        k.K_tc * chip * i_h + k.K_te * length,
    )


@inlined
def mean_force(
    lo: float, hi: float, chip: float, theta: float, width: float, flutes: int, coefficients: EdgeCoefficients
) -> FluteForce:
    r"""Force averaged over a tooth period, from the arc [lo, hi] and the axial width of the layer.

    The helix drops out: :math:`\bar F = \frac{N b}{2\pi} \int_{lo}^{hi} dF(\phi)`.

    Parameters
    ----------
    lo, hi : float
        Entry and exit angle [rad]; nothing cuts if ``hi <= lo``.
    chip, theta : float
        Feed per tooth [m] and feed direction [rad].
    width : float
        Axial width b of the layer [m].
    flutes : int
        Number of flutes N.
    coefficients : EdgeCoefficients
        Cutting coefficients.

    Returns
    -------
    FluteForce
        Mean force on the tool [N].

    Notes
    -----
    Valid as :func:`arc_force` is, for evenly spaced flutes without run-out.

    Examples
    --------
    A slot 1 mm deep with two flutes, chip 0.1 mm, tangential force alone: :math:`N K_{tc} c b / 4` across the feed.

    >>> f = mean_force(0.0, math.pi, 1e-4, 0.0, 1e-3, 2, EdgeCoefficients(1e9, 0.0, 0.0, 0.0, 0.0, 0.0))
    >>> round(f.y, 6), round(f.tangential, 5)
    (50.0, 63.66198)

    References
    ----------
    Derived here from Berselli et al. 2016, Eqs. (3), (4) and (9); at :math:`\vartheta = 0` the average forces of
    Altintas 2012, chapter 2.
    """
    if hi <= lo or width <= 0.0:
        return FluteForce(0.0, 0.0, 0.0, 0.0)
    span = hi - lo
    return arc_force(chip, theta, 0.5 * (lo + hi), span, flutes * width * span / (2.0 * math.pi), coefficients)


@compiled
def tooth_force(
    rotation: float,
    lo: float,
    hi: float,
    chip: float,
    theta: float,
    z_lo: float,
    z_hi: float,
    mill: Mill,
    coefficients: EdgeCoefficients,
) -> FluteForce:
    r"""Instantaneous force of all flutes on a layer, every wrap of the angles included.

    Flute j stands at :math:`\phi_j(z) = \phi + j \phi_p - k_\beta z`, :math:`k_\beta = \tan\beta / R`, and cuts where
    :math:`lo < \phi_j(z) \le hi` and :math:`z_{lo} \le z \le z_{hi}`. All integers j with a non-empty set count,
    which replaces the paper's list of cases.

    Parameters
    ----------
    rotation : float
        Rotation :math:`\phi` of the mill [rad], flute 0 at the tip.
    lo, hi : float
        Immersion arc [rad].
    chip, theta : float
        Feed per tooth [m] and feed direction [rad].
    z_lo, z_hi : float
        Axial limits of the layer above the tip [m].
    mill : Mill
        The mill.
    coefficients : EdgeCoefficients
        Cutting coefficients.

    Returns
    -------
    FluteForce
        Force on the tool [N].

    Notes
    -----
    Valid as :func:`arc_force` is, for evenly spaced flutes without run-out.

    Examples
    --------
    One flute of 45 degrees on R = 5 mm lies over half a turn in a slot: :math:`K_{tc} c / k_\beta \cdot \pi / 2` off the
    work, and nothing more when the slot is as much deeper again.

    >>> mill, k = Mill(5e-3, 1, 0.25 * math.pi), EdgeCoefficients(1e9, 0.0, 0.0, 0.0, 0.0, 0.0)
    >>> [round(tooth_force(math.pi, 0.0, math.pi, 1e-4, 0.0, 0.0, z, mill, k).y, 4) for z in (0.0157079633, 0.03)]
    [785.3982, 785.3982]

    References
    ----------
    Berselli et al. 2016, Eqs. (2)-(7) and (10), corrected; Altintas 2012, sec. 2.6.
    """
    return lagging_force(
        rotation, lo, hi, chip, theta, z_lo, z_hi, mill.flutes, helix_lag(mill.helix, mill.radius), coefficients
    )


@inlined
def lagging_force(
    rotation: float,
    lo: float,
    hi: float,
    chip: float,
    theta: float,
    z_lo: float,
    z_hi: float,
    flutes: int,
    lag: float,
    coefficients: EdgeCoefficients,
) -> FluteForce:
    """:func:`tooth_force` of a mill whose lag is known, for loops over many rotations.

    Parameters
    ----------
    rotation, lo, hi, chip, theta, z_lo, z_hi, coefficients
        As there.
    flutes : int
        How many flutes.
    lag : float
        Of the mill, from :func:`cutwise.physics.cutting.helix.helix_lag` [rad/m].

    Returns
    -------
    FluteForce
        Force on the tool [N].

    Notes
    -----
    Valid as :func:`tooth_force`.

    Examples
    --------
    >>> k = EdgeCoefficients(1e9, 0.0, 0.0, 0.0, 0.0, 0.0)
    >>> round(lagging_force(math.pi, 0.0, math.pi, 1e-4, 0.0, 0.0, 0.03, 1, 200.0, k).y, 4)
    785.3982

    References
    ----------
    As :func:`tooth_force`.
    """
    x = y = z = tangential = 0.0
    if hi <= lo or z_hi <= z_lo:
        return FluteForce(x, y, z, tangential)
    first, last = flutes_in_cut(rotation, lo, hi, z_lo, z_hi, flutes, lag)
    for flute in range(first, last + 1):
        z1, z2, middle, span = edge_in_cut(rotation, flute, lo, hi, z_lo, z_hi, flutes, lag)
        if z2 <= z1:
            continue
        f = arc_force(chip, theta, middle, span, z2 - z1, coefficients)
        x += f.x
        y += f.y
        z += f.z
        tangential += f.tangential
    return FluteForce(x, y, z, tangential)


@inlined
def mirrored(force: FluteForce) -> FluteForce:
    r"""Up milling from the mirror image of down milling: :math:`F_y \to -F_y`.

    The arcs go in mirrored too, :math:`\phi \to \pi - \phi` and :math:`\vartheta \to -\vartheta`.

    Parameters
    ----------
    force : FluteForce
        In down milling [N].

    Notes
    -----
    Valid for work on one side of the feed, to which the tool is mirrored.

    Examples
    --------
    >>> mirrored(FluteForce(1.0, 2.0, 3.0, 4.0))
    FluteForce(x=1.0, y=-2.0, z=3.0, tangential=4.0)

    References
    ----------
    Derived here from the symmetry of Berselli et al. 2016, Eqs. (3), (4) and (9).
    """
    return FluteForce(force.x, -force.y, force.z, force.tangential)
