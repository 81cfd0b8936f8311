r"""Twist drill: lips, chisel edge and margin in closed form.

Frame: :math:`z` is the feed direction, into the work; :math:`r` runs outward. Two lips, 180 degrees apart, so the
chisel edge counts as two half edges. The uncut chip thickness is the same everywhere on the drill point,
:math:`h_c = f_z \sin\kappa`, and the swept section of an element is :math:`f_z\,\mathrm{d}r` whatever the web offset.
"""

import math
from typing import NamedTuple

from cutwise.maths.compiled import compiled
from cutwise.physics.cutting.kienzle import specific_cutting_force


class DrillPoint(NamedTuple):
    """Ground geometry of a two-lipped twist drill."""

    radius: float  # R [m]
    chisel_radius: float  # r_a [m], half the chisel edge: indentation inside, cutting outside
    web_offset: float  # w [m], distance of a lip from the parallel plane through the axis
    half_point_angle: float  # kappa [rad], half of the full point angle
    helix: float  # [rad] at the outer diameter
    margin_width: float  # [m] of one margin
    margin_length: float  # [m] behind the corner over which a margin rubs


class ZoneLaw(NamedTuple):
    """Ratios by which the specific cutting force acts in the two zones of the drill point."""

    friction: float  # mu [1] between chip and rake face, lip
    lip_rake: float  # gamma_0 [rad]
    chisel_factor: float  # K_n1 / k_c [1]
    chisel_friction: float  # K_f1 / K_n1 [1]
    chisel_rake: float  # gamma_1 [rad], strongly negative
    margin_stress: float  # shear stress of the rubbing margins [Pa]


class ZoneStress(NamedTuple):
    """Force per uncut chip area on lip (0) and chisel edge (1), at one feed."""

    specific: float  # k_c [Pa]
    normal: float  # K_n0 [Pa], normal to the rake face
    friction: float  # K_f0 [Pa], along the rake face
    tangential_lip: float  # q_t0 [Pa]
    normal_lip: float  # q_n0 [Pa], normal to the lip, against the feed side
    tangential_chisel: float  # q_t1 [Pa]
    normal_chisel: float  # q_n1 [Pa]


class LipForce(NamedTuple):
    """Force of one lip with its half of the chisel edge, on the tool."""

    thrust: float  # [N] against the feed
    torque: float  # [N m] against the rotation
    tangential: float  # F_t [N] against the rotation
    inward: float  # F_r [N] towards the axis


@compiled
def zone_stress(law: ZoneLaw, specific: float) -> ZoneStress:
    r"""Stresses on lip and chisel edge from the specific cutting force.

    .. math::
        K_{n0} = \frac{k_c}{\cos\gamma_0 + \mu\sin\gamma_0}, \quad K_{f0} = \mu K_{n0}, \qquad
        K_{n1} = c_1 k_c, \quad K_{f1} = \mu_1 K_{n1}

        q_t = K_n\cos\gamma + K_f\sin\gamma, \qquad q_n = K_f\cos\gamma - K_n\sin\gamma

    so that :math:`q_{t0} = k_c`.

    Parameters
    ----------
    law : ZoneLaw
        Friction, rake angles and chisel factors.
    specific : float
        :math:`k_c` [Pa] at the present chip thickness.

    Returns
    -------
    ZoneStress
        Forces per uncut chip area [Pa].

    Notes
    -----
    Valid for :math:`\tan\gamma_0 > -1/\mu`, where :math:`K_{n0}` is positive and finite, and for a rake that is the same
    all along a zone.

    Examples
    --------
    Zero rake and a friction of 1/2 on the lip; twice the specific force at -30 degrees, without friction, on the chisel:

    >>> q = zone_stress(ZoneLaw(0.5, 0.0, 2.0, 0.0, -math.pi / 6, 0.0), 1e9)
    >>> [round(value / 1e9, 6) for value in (q.tangential_lip, q.normal_lip, q.tangential_chisel, q.normal_chisel)]
    [1.0, 0.5, 1.732051, 1.0]

    References
    ----------
    Garnier, Subrin, Waiyagan 2017, Eqs. (1)-(3) with the matrix of Eq. (2) read as a rotation; the zone factors are
    calibrated against the half-:math:`k_c` thrust formula of tool makers, not printed.
    """
    g0, g1 = law.lip_rake, law.chisel_rake
    normal = specific / (math.cos(g0) + law.friction * math.sin(g0))
    along = law.friction * normal
    normal1 = law.chisel_factor * specific
    along1 = law.chisel_friction * normal1
    return ZoneStress(
        specific,
        normal,
        along,
        normal * math.cos(g0) + along * math.sin(g0),
        along * math.cos(g0) - normal * math.sin(g0),
        normal1 * math.cos(g1) + along1 * math.sin(g1),
        along1 * math.cos(g1) - normal1 * math.sin(g1),
    )


@compiled
def stress_at_feed(law: ZoneLaw, kc11: float, exponent: float, point: DrillPoint, feed: float) -> ZoneStress:
    r"""Zone stresses at a feed per revolution: chip thickness :math:`h_c = (f/2)\sin\kappa`.

    Parameters
    ----------
    law : ZoneLaw
        Friction, rake angles and chisel factors.
    kc11, exponent : float
        :math:`k_{c1.1}` [Pa] and :math:`m_c` [1] of Kienzle's law.
    point : DrillPoint
        Geometry; its half point angle :math:`\kappa` counts.
    feed : float
        Feed per revolution f [m].

    Returns
    -------
    ZoneStress
        Forces per uncut chip area [Pa].

    Notes
    -----
    Valid where :func:`~cutwise.physics.cutting.kienzle.specific_cutting_force` is; two lips that cut alike.

    Examples
    --------
    0.4 mm per revolution at a half point angle of 30 degrees: a chip of 0.1 mm.

    >>> law, point = ZoneLaw(0.5, 0.0, 2.0, 0.0, 0.0, 0.0), DrillPoint(5e-3, 1e-3, 0.0, math.pi / 6, 0.0, 0.0, 0.0)
    >>> round(stress_at_feed(law, 1e9, 0.25, point, 4e-4).specific / 1e6, 3)
    1778.279

    References
    ----------
    Garnier et al. 2017, Eq. (1), with the coefficient by Kienzle's law.
    """
    thickness = 0.5 * feed * math.sin(point.half_point_angle)
    return zone_stress(law, specific_cutting_force(kc11, exponent, thickness))


@compiled
def lip_force(point: DrillPoint, stress: ZoneStress, feed: float, inner: float, outer: float) -> LipForce:
    r"""Force of one lip that cuts between two radii.

    .. math::
        T = f_z \sin\kappa \int q_n \,\mathrm{d}r, \quad F_r = f_z \cos\kappa \int q_n \,\mathrm{d}r, \quad
        F_t = f_z \int q_t \,\mathrm{d}r, \quad M = f_z \int r\, q_t \,\mathrm{d}r

    with :math:`q` of the chisel edge inside :math:`r_a` and of the lip outside.

    Parameters
    ----------
    point : DrillPoint
        Geometry.
    stress : ZoneStress
        Stresses at this feed [Pa].
    feed : float
        Feed per revolution :math:`f = 2 f_z` [m].
    inner, outer : float
        Radii between which the lip cuts [m], :math:`0 \le` inner; nothing is cut if outer is not larger.

    Returns
    -------
    LipForce
        Thrust, tangential and inward force [N], torque [N m].

    Notes
    -----
    Valid for a rake that is constant along each zone and a lip through the axis.

    Examples
    --------
    Lip from 1 to 5 mm at 60 degrees, 0.1 mm per lip:

    >>> point, stress = DrillPoint(5e-3, 1e-3, 0.0, math.pi / 3, 0.0, 0.0, 0.0), ZoneStress(2e9, 0, 0, 2e9, 1e9, 3e9, 4e9)
    >>> [round(value, 3) for value in lip_force(point, stress, 2e-4, 0.0, 5e-3)]
    [692.82, 2.55, 1100.0, 400.0]

    References
    ----------
    Garnier et al. 2017, Eq. (5) corrected: the section is :math:`(R - r_a) f_z`, not :math:`(R - r_a) f_z/\cos p`.
    The torque is not in the paper.
    """
    if outer <= inner:
        return LipForce(0.0, 0.0, 0.0, 0.0)
    split = min(max(point.chisel_radius, inner), outer)
    lip_per_width = 0.5 * feed
    normal = lip_per_width * (stress.normal_chisel * (split - inner) + stress.normal_lip * (outer - split))
    tangential = lip_per_width * (stress.tangential_chisel * (split - inner) + stress.tangential_lip * (outer - split))
    torque = (
        0.5
        * lip_per_width
        * (
            stress.tangential_chisel * (split * split - inner * inner)
            + stress.tangential_lip * (outer * outer - split * split)
        )
    )
    kappa = point.half_point_angle
    return LipForce(normal * math.sin(kappa), torque, tangential, normal * math.cos(kappa))


@compiled
def cone_height(point: DrillPoint) -> float:
    r"""Height of the drill point :math:`h_t = R\cot\kappa` [m].

    Parameters
    ----------
    point : DrillPoint
        Radius R [m] and half point angle :math:`\kappa` [rad], :math:`0 < \kappa < \pi/2`.

    Notes
    -----
    Valid for a straight cone: the chisel edge, which flattens it, is left out.

    Examples
    --------
    10 mm, 118 degrees:

    >>> round(1e3 * cone_height(DrillPoint(5e-3, 1e-3, 0.0, math.radians(59), 0.0, 0.0, 0.0)), 6)
    3.004303

    References
    ----------
    Derived here; geometry as in Garnier et al. 2017, Eq. (1).
    """
    return point.radius / math.tan(point.half_point_angle)


@compiled
def margin_torque(point: DrillPoint, shear_stress: float, depth: float, thickness: float) -> float:
    r"""Torque of the two rubbing margins.

    .. math:: M = 2\,\tau\, b\, R \,\min(h - h_t,\; l,\; \text{thickness})

    Parameters
    ----------
    point : DrillPoint
        Margin width :math:`b` and length :math:`l`, radius :math:`R` [m].
    shear_stress : float
        :math:`\tau` [Pa]. No source gives it: an assumed input.
    depth : float
        Depth :math:`h` of the tip below the entry surface [m]; no torque before the corner has entered.
    thickness : float
        Thickness of the part [m].

    Returns
    -------
    float
        Torque against the rotation [N m].

    Notes
    -----
    Valid until the corners leave at the exit, :math:`h \le h_t +` thickness: beyond, the torque stays as it is.

    Examples
    --------
    2 mm of two margins 1 mm wide rub at 10 MPa and 5 mm from the axis:

    >>> point = DrillPoint(5e-3, 1e-3, 0.0, math.radians(59), 0.0, 1e-3, 2e-3)
    >>> round(margin_torque(point, 1e7, 2e-2, 5e-2), 9)
    0.2

    References
    ----------
    Derived here; Garnier et al. 2017, sec. 2.1, names the margin without a formula.
    """
    rubbing = min(depth - cone_height(point), point.margin_length, thickness)
    return 2.0 * shear_stress * point.margin_width * point.radius * rubbing if rubbing > 0.0 else 0.0


@compiled
def shares(point: DrillPoint, stress: ZoneStress, feed: float) -> tuple[float, float, float, float]:
    r"""Thrust and torque of lips and of chisel edge in full contact: (T lips, T chisel, M lips, M chisel) [N, N m].

    .. math::
        T = 2 f_z\sin\kappa\,[q_{n0}(R - r_a) + q_{n1} r_a], \qquad
        M = f_z\,[q_{t0}(R^2 - r_a^2) + q_{t1} r_a^2]

    Parameters
    ----------
    point : DrillPoint
        Geometry.
    stress : ZoneStress
        Stresses at this feed [Pa].
    feed : float
        Feed per revolution :math:`f = 2 f_z` [m].

    Returns
    -------
    tuple
        Of both lips together; valid as :func:`lip_force` is.

    Examples
    --------
    The drill of :func:`lip_force`:

    >>> point, stress = DrillPoint(5e-3, 1e-3, 0.0, math.pi / 3, 0.0, 0.0, 0.0), ZoneStress(2e9, 0, 0, 2e9, 1e9, 3e9, 4e9)
    >>> [round(value, 3) for value in shares(point, stress, 2e-4)]
    [692.82, 692.82, 4.8, 0.3]

    References
    ----------
    Garnier et al. 2017, Eq. (5) corrected (see :func:`lip_force`); chisel edge and torque are derived here.
    """
    lip = lip_force(point, stress, feed, point.chisel_radius, point.radius)
    chisel = lip_force(point, stress, feed, 0.0, point.chisel_radius)
    return 2.0 * lip.thrust, 2.0 * chisel.thrust, 2.0 * lip.torque, 2.0 * chisel.torque


def rotating_force(point: DrillPoint, stress: ZoneStress, height_error: float) -> float:
    r"""Radial force that turns with a drill whose lips differ in height.

    .. math:: F_\mathrm{rot} = 2 e \cos\kappa\,[q_{n0}(R - r_a) + q_{n1} r_a]

    Lip one cuts :math:`f_z + e`, lip two :math:`f_z - e`; the stresses are those of the mean chip.

    Parameters
    ----------
    point : DrillPoint
        Geometry.
    stress : ZoneStress
        Stresses at the mean chip [Pa].
    height_error : float
        :math:`e` [m], half of the difference in chip load between the lips.

    Returns
    -------
    float
        [N], towards the axis on the lip that cuts more.

    Notes
    -----
    Valid for :math:`|e| \le f_z`: beyond, one lip cuts nothing.

    Examples
    --------
    10 µm at the drill of :func:`lip_force`: a fifth of twice 400 N for 0.1 mm.

    >>> point, stress = DrillPoint(5e-3, 1e-3, 0.0, math.pi / 3, 0.0, 0.0, 0.0), ZoneStress(2e9, 0, 0, 2e9, 1e9, 3e9, 4e9)
    >>> round(rotating_force(point, stress, 1e-5), 6)
    80.0

    References
    ----------
    Derived here from the inward force of :func:`lip_force`.
    """
    width = stress.normal_lip * (point.radius - point.chisel_radius) + stress.normal_chisel * point.chisel_radius
    return 2.0 * height_error * math.cos(point.half_point_angle) * width
