"""Cutting forces of a ball end through the one flute kernel: an axial disc is a thin mill with turned coefficients."""

import math
from typing import NamedTuple

from cutwise.maths.compiled import compiled
from cutwise.physics.cutting.flute import EdgeCoefficients, mean_force
from cutwise.physics.cutting.uneven import GAUSS, KIENZLE, PANEL, Edges, force_per_length
from cutwise.stages import cut


class BallFlutes(NamedTuple):
    """A turning ball in a material, its force averaged over a tooth period; run-out is left out."""

    radius: float  # [m]
    flutes: int
    edges: Edges


class DiscForce(NamedTuple):
    """Force of a disc of a ball on the tool, in the frame of the pass."""

    x: float  # [N] along the feed
    y: float  # [N] off the work
    z: float  # [N] along the rod, the axial coefficients counted positive, as in the measures
    tangential: float  # [N] summed over the edges in cut
    axial: float  # [N] of z by the axial coefficients: a right-hand helix pulls with it, out of the holder


@compiled
def disc_coefficients(chi: float, k: EdgeCoefficients) -> EdgeCoefficients:
    r"""Coefficients of a disc whose edge stands at the polar angle :math:`\chi` from the rod.

    The radial force acts along the sphere normal :math:`(\sin\chi, \cos\chi)` and the axial one along the meridian
    :math:`(-\cos\chi, \sin\chi)`, in the (radial, axial) plane:

    .. math:: K_r' = K_r \sin\chi + K_a \cos\chi, \qquad K_a' = K_a \sin\chi - K_r \cos\chi

    Equal to the cylinder at :math:`\chi = 90^\circ`.

    Parameters
    ----------
    chi : float
        Polar angle :math:`\chi` [rad], 0 at the side of the rod, :math:`\pi` at the tip.
    k : EdgeCoefficients
        Coefficients of the edge in its own directions [Pa], [N/m].

    Returns
    -------
    EdgeCoefficients
        Coefficients across and along the rod [Pa], [N/m].

    Notes
    -----
    Valid for edges that stand across the meridian: coefficients are those of one edge geometry all over the ball.

    Examples
    --------
    >>> k = disc_coefficients(math.pi / 3, EdgeCoefficients(0.0, 2.0, 1.0, 0.0, 0.0, 0.0))
    >>> round(k.K_rc, 6), round(k.K_ac, 6)  # sqrt(3) + 1/2, sqrt(3)/2 - 1
    (2.232051, -0.133975)

    References
    ----------
    Altintas 2012, sec. 2.10 (ball end mills); there the angle is counted from the pole.
    """
    s, c = math.sin(chi), math.cos(chi)
    return EdgeCoefficients(
        k.K_tc, k.K_rc * s + k.K_ac * c, k.K_ac * s - k.K_rc * c, k.K_te, k.K_re * s + k.K_ae * c,
        k.K_ae * s - k.K_re * c,
    )  # fmt: skip


@compiled
def disc_force(
    lo: float, hi: float, z: float, height: float, ball_radius: float, chip: float, theta: float, rise: float,
    flutes: int, edges: Edges,
) -> DiscForce:  # fmt: skip
    r"""Force of one disc of a ball averaged over a tooth period.

    The chip is :math:`c \sin\chi \sin(\phi - \vartheta) + c_z \cos\chi` thick along the sphere normal and the edge in
    the disc :math:`dz / \sin\chi` long. In the linear law the second term is the same all round, so it counts like an
    edge force, and the mean is in closed form; Kienzle's law takes the chip to a power, and the mean by quadrature.

    Parameters
    ----------
    lo, hi : float
        Immersion arc [rad]; nothing cuts if ``hi <= lo``.
    z, height : float
        Height of the disc above the ball centre, and its thickness [m].
    ball_radius : float
        [m].
    chip, theta : float
        Feed per tooth c across the rod [m] and its direction [rad].
    rise : float
        Feed per tooth :math:`c_z` along the rod, up [m].
    flutes : int
        Number of flutes.
    edges : Edges
        Force law of the edges; run-out is left out.

    Returns
    -------
    DiscForce
        Force on the tool [N].

    Notes
    -----
    Valid for :math:`|z| < R_B` and arcs on which the chip is not negative (those of
    :func:`~cutwise.physics.engagement.ball.disc_arcs` with the plane of the leading side); the linear law does not ask.

    Examples
    --------
    A slot with the widest disc of a ball, two flutes and tangential force alone: :math:`K_{tc} c N b / \pi`, and half
    of :math:`K_{tc} c N b / 2` across the feed.

    >>> from cutwise.physics.cutting.uneven import even_edges
    >>> edges = even_edges(EdgeCoefficients(1e9, 0.0, 0.0, 0.0, 0.0, 0.0))
    >>> f = disc_force(0.0, math.pi, 0.0, 1e-3, 5e-3, 1e-4, 0.0, 0.0, 2, edges)
    >>> round(f.tangential, 5), round(f.y, 6)
    (63.66198, 50.0)

    References
    ----------
    Derived here from the elements of Altintas 2012, sec. 2.10; the flute force is that of Berselli et al. 2016,
    Eqs. (3), (4) and (9).
    """
    if hi <= lo:
        return DiscForce(0.0, 0.0, 0.0, 0.0, 0.0)
    chi = math.acos(z / ball_radius)
    s = math.sin(chi)
    thick = rise * math.cos(chi)
    if edges.law == KIENZLE:
        length = flutes * (height / s) * (hi - lo) / (2.0 * math.pi)
        return _kienzle_arc_force(lo, hi, chi, chip * s, thick, theta, length, edges)
    k = edges.linear
    with_rise = EdgeCoefficients(
        k.K_tc, k.K_rc, k.K_ac, k.K_te + k.K_tc * thick, k.K_re + k.K_rc * thick, k.K_ae + k.K_ac * thick
    )
    f = mean_force(lo, hi, chip * s, theta, height / s, flutes, disc_coefficients(chi, with_rise))
    length = flutes * (height / s) * (hi - lo) / (2.0 * math.pi)
    cut_chip = (f.tangential - with_rise.K_te * length) / k.K_tc if k.K_tc != 0.0 else 0.0  # mean chip times length
    return DiscForce(f.x, f.y, f.z, f.tangential, s * (k.K_ac * cut_chip + with_rise.K_ae * length))


@compiled
def _kienzle_arc_force(
    lo: float, hi: float, chi: float, chip: float, thick: float, theta: float, length: float, edges: Edges
) -> DiscForce:
    r"""Force of an edge spread over the arc of a disc whose chip is :math:`c \sin(\phi - \vartheta) + h_0` thick.

    Composite three-point Gauss rule, against a midpoint rule of 200,000 panels within 3e-5 where the chip begins at nothing, where
    :math:`h^{1-m}` has no slope, and within 2e-8 elsewhere.
    """
    sin_chi, cos_chi = math.sin(chi), math.cos(chi)
    panels = max(1, math.ceil((hi - lo) / PANEL))
    width = (hi - lo) / panels
    x = y = z = tangential = axial = 0.0
    for panel in range(panels):
        centre = lo + (panel + 0.5) * width
        for i in range(3):
            phi = centre + 0.5 * width * GAUSS[i][0]
            ft, fn, fm = force_per_length(edges, chip * math.sin(phi - theta) + thick)
            fr, fa = fn * sin_chi + fm * cos_chi, fm * sin_chi - fn * cos_chi
            weight = length / panels * GAUSS[i][1]
            sin_phi, cos_phi = math.sin(phi), math.cos(phi)
            x += weight * (-ft * cos_phi - fr * sin_phi)
            y += weight * (ft * sin_phi - fr * cos_phi)
            z += weight * fa
            tangential += weight * ft
            axial += weight * fm * sin_chi
    return DiscForce(x, y, z, tangential, axial)


@cut.of(BallFlutes)
def _(cutting, contact, count, time, pivot, load):
    r"""The whole force acts at the centre of the ball; layers are in the frame of the pass, the total in process axes.

    The total holds the tangential force reduced to the radius of the ball, so that its power is that of the cut. What a
    right-hand helix gives along the rod pulls the tool out of its holder, so a structure feels the other sign of it;
    across the rod the axial coefficients count as in the measures.
    """
    rows, radius = contact.rows, cutting.radius
    layer, total = load.layer, load.total
    arm = pivot - radius
    x = y = z = tangential = axial = 0.0
    for i in range(count):
        height = rows[i, 2]
        at = rows[i, 1] + 0.5 * height - radius
        f = disc_force(
            rows[i, 3], rows[i, 4], at, height, radius, rows[i, 5], rows[i, 6], rows[i, 7], cutting.flutes,
            cutting.edges,
        )  # fmt: skip
        x, y, z, axial = x + f.x, y + f.y, z + f.z, axial + f.axial
        tangential += f.tangential * math.sqrt(max(0.0, 1.0 - (at / radius) ** 2))
        if i + 1 == count or rows[i + 1, 0] != rows[i, 0]:
            here = int(rows[i, 0])
            layer[here, 0], layer[here, 1], layer[here, 2] = x, y, z
            along, off = x * rows[i, 8] + y * rows[i, 10], x * rows[i, 9] + y * rows[i, 11]
            total[0] += along
            total[1] += off
            total[2] += z - 2.0 * axial
            total[3] += tangential
            total[4] += arm * along
            total[5] += arm * off
            x = y = z = tangential = axial = 0.0
