r"""Drill lips by elements: rake laws that vary along the lip, and the oblique element with web offset.

The closed form of :mod:`cutwise.physics.cutting.drill` is the reference for a constant rake; elements serve the laws
that have no closed form. Elements at the boundary of contact count with the fraction of them that cuts: whole elements
would put noise of one element into thrust at entry and exit.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.maths.compiled import compiled
from cutwise.physics.cutting.drill import DrillPoint, LipForce, ZoneLaw, ZoneStress, zone_stress

FloatArray = NDArray[np.float64]


class LipElements(NamedTuple):
    """Stresses of the elements of one lip and its half chisel edge, per swept section f_z dr."""

    edges: FloatArray  # [m], shape (n + 1,), radii from 0 to R
    thrust: FloatArray  # [Pa], shape (n,)
    tangential: FloatArray  # [Pa], shape (n,)
    inward: FloatArray  # [Pa], shape (n,)


def element_edges(point: DrillPoint, lip_count: int) -> FloatArray:
    """Radii of the element edges [m]: ``max(4, lip_count / 8)`` elements on the chisel edge, the rest on the lip.

    Examples
    --------
    Four elements of 0.25 mm on the chisel edge, eight of 0.5 mm on the lip:

    >>> (1e3 * element_edges(DrillPoint(5e-3, 1e-3, 0.0, 1.0, 0.0, 0.0, 0.0), 8)[[0, 1, 4, 5, 12]]).round(9).tolist()
    [0.0, 0.25, 1.0, 1.5, 5.0]
    """
    chisel_count = max(4, lip_count // 8)
    chisel = np.linspace(0.0, point.chisel_radius, chisel_count + 1)
    return np.concatenate([chisel, np.linspace(point.chisel_radius, point.radius, lip_count + 1)[1:]])


def _with_chisel(point: DrillPoint, stress: ZoneStress, edges: FloatArray, lip: FloatArray) -> LipElements:
    """Put the indentation zone inside r_a and the given lip stresses, shape (3, n), outside."""
    middle = 0.5 * (edges[1:] + edges[:-1])
    kappa = point.half_point_angle
    chisel = np.array([stress.normal_chisel * np.sin(kappa), stress.tangential_chisel,
                       stress.normal_chisel * np.cos(kappa)])  # fmt: skip
    values = np.where(middle < point.chisel_radius, chisel[:, None], lip)
    return LipElements(edges, values[0].copy(), values[1].copy(), values[2].copy())


def simple_elements(point: DrillPoint, law: ZoneLaw, specific: float, rake: FloatArray, lip_count: int) -> LipElements:
    r"""Elements of the paper, as corrected: the lip through the axis, one normal rake angle per element.

    Parameters
    ----------
    specific : float
        :math:`k_c` [Pa].
    rake : ndarray
        Rake angle of every element [rad], shape (n,); those on the chisel edge are not used.

    Returns
    -------
    LipElements
        Stresses per swept section [Pa].

    Notes
    -----
    :math:`K_n` and :math:`K_f` stay those of the rake :math:`\gamma_0`. Thrust is ill-conditioned in the rake: one
    degree changes the lips' thrust by 6 %.

    Examples
    --------
    Zero rake, friction 1/2, a half point angle of 30 degrees: thrust 1/4 and tangential once the specific force.

    >>> law, point = ZoneLaw(0.5, 0.0, 2.0, 0.0, 0.0, 0.0), DrillPoint(5e-3, 1e-3, 0.0, np.pi / 6, 0.0, 0.0, 0.0)
    >>> lip = simple_elements(point, law, 1e9, np.zeros(12), 8)
    >>> round(float(lip.thrust[-1]) / 1e9, 9), round(float(lip.tangential[-1]) / 1e9, 9)
    (0.25, 1.0)

    References
    ----------
    Garnier et al. 2017, Eqs. (1)-(5), corrected.
    """
    stress = zone_stress(law, specific)
    kappa = point.half_point_angle
    normal = stress.friction * np.cos(rake) - stress.normal * np.sin(rake)
    tangential = stress.normal * np.cos(rake) + stress.friction * np.sin(rake)
    lip = np.array([normal * np.sin(kappa), tangential, normal * np.cos(kappa)])
    return _with_chisel(point, stress, element_edges(point, lip_count), lip)


def conventional_rake(point: DrillPoint, radius: FloatArray) -> FloatArray:
    r"""Normal rake angle along the lip of a conventional helical flute.

    .. math::
        \gamma_n = \arctan\frac{\tan\beta\cos\omega}{\sin\kappa - \tan\beta\sin\omega\cos\kappa}
        - \arctan(\tan\omega\cos\kappa), \qquad \tan\beta = \tan\beta_R\,\frac rR, \quad \sin\omega = \frac wr

    Parameters
    ----------
    radius : ndarray
        :math:`r \ge w` [m].

    Returns
    -------
    ndarray
        :math:`\gamma_n` [rad]; for 118 degrees, 30 degrees of helix and w = 0.15 R from -44 degrees near the web to
        +31 degrees at the corner.

    Notes
    -----
    Valid for :math:`\sin\kappa > \tan\beta\sin\omega\cos\kappa`, as on every usual drill.

    Examples
    --------
    A lip through the axis at right angles to it has the helix angle as its rake:

    >>> point = DrillPoint(5e-3, 1e-3, 0.0, 0.5 * np.pi, np.pi / 6, 0.0, 0.0)
    >>> np.degrees(conventional_rake(point, np.array([5e-3]))).round(6).tolist()
    [30.0]

    References
    ----------
    Derived here from the helicoid of the flute.
    """
    kappa = point.half_point_angle
    lead = np.tan(point.helix) * radius / point.radius
    omega = np.arcsin(point.web_offset / radius)
    rake = np.arctan(lead * np.cos(omega) / (np.sin(kappa) - lead * np.sin(omega) * np.cos(kappa)))
    return rake - np.arctan(np.tan(omega) * np.cos(kappa))


def oblique_elements(
    point: DrillPoint, law: ZoneLaw, specific: float, lip_count: int, rake: FloatArray | None = None
) -> LipElements:
    r"""Elements as oblique cutting edges off the axis, chip flow by Stabler.

    .. math::
        \mathbf e = (\sin\kappa, 0, -\cos\kappa),\quad \mathbf v = (-w, x, 0)/r,\quad \mathbf e_r = (x, w, 0)/r,\quad
        x = \sqrt{r^2 - w^2}

        \mathbf a = \cos\gamma\,\mathbf c - \sin\gamma\,\mathbf v_n,\quad
        \mathbf n = -\cos\gamma\,\mathbf v_n - \sin\gamma\,\mathbf c

        \boldsymbol\ell = \cos\lambda\,\mathbf a + \sin\lambda\,\mathbf e,\quad
        \lambda = \arcsin(\mathbf e\cdot\mathbf v)

        \mathrm d\mathbf F = (K_n\mathbf n + K_f\boldsymbol\ell) f_z\,\mathrm dr

    :math:`\mathbf v_n` is the cutting direction normal to the edge, :math:`\mathbf c` the normal of edge and
    :math:`\mathbf v_n` that points out of the work.

    Parameters
    ----------
    rake : ndarray, optional
        Normal rake of every element [rad], shape (n,); default :func:`conventional_rake`.

    Notes
    -----
    :math:`K_n, K_f` are those of the rake :math:`\gamma_0` of the law, not of the local one, so a conventional rake
    gives far less thrust than the simple element (94.6 against 163.9 N in the reference case): coefficients have to be
    calibrated for this element. Elements inside the web offset do not cut.

    Examples
    --------
    Without web offset and rake it is the simple element:

    >>> law, point = ZoneLaw(0.5, 0.0, 2.0, 0.0, 0.0, 0.0), DrillPoint(5e-3, 1e-3, 0.0, np.pi / 6, 0.0, 0.0, 0.0)
    >>> round(float(oblique_elements(point, law, 1e9, 8, np.zeros(12)).thrust[-1]) / 1e9, 9)
    0.25

    References
    ----------
    Derived here, with the chip flow law of Stabler 1951; Garnier et al. 2017, Eqs. (1)-(3), for a lip through the axis.
    """
    stress = zone_stress(law, specific)
    edges = element_edges(point, lip_count)
    radius = np.maximum(0.5 * (edges[1:] + edges[:-1]), point.web_offset * (1.0 + 1e-12))
    cutting = 0.5 * (edges[1:] + edges[:-1]) > point.web_offset
    gamma = conventional_rake(point, radius) if rake is None else rake
    x = np.sqrt(radius**2 - point.web_offset**2)
    zero = np.zeros_like(x)
    edge = np.broadcast_to([np.sin(point.half_point_angle), 0.0, -np.cos(point.half_point_angle)], (x.size, 3))
    speed = np.stack([zero - point.web_offset, x, zero], axis=1) / radius[:, None]
    outward = np.stack([x, zero + point.web_offset, zero], axis=1) / radius[:, None]
    obliquity = np.sum(edge * speed, axis=1)[:, None]
    normal_speed = speed - obliquity * edge
    normal_speed /= np.linalg.norm(normal_speed, axis=1)[:, None]
    out = np.cross(edge, normal_speed)
    out *= np.where(out[:, 2] < 0.0, 1.0, -1.0)[:, None]
    cos_rake, sin_rake = np.cos(gamma)[:, None], np.sin(gamma)[:, None]
    along_face = cos_rake * out - sin_rake * normal_speed
    face_normal = -cos_rake * normal_speed - sin_rake * out
    flow = np.sqrt(1.0 - obliquity**2) * along_face + obliquity * edge
    force = np.where(cutting[:, None], stress.normal * face_normal + stress.friction * flow, 0.0)
    lip = -np.array([force[:, 2], np.sum(force * speed, axis=1), np.sum(force * outward, axis=1)])
    return _with_chisel(point, stress, edges, lip)


@compiled
def elements_force(elements: LipElements, feed: float, inner: float, outer: float) -> LipForce:
    r"""Force of one lip that cuts between two radii, with fractional end elements.

    .. math:: T = f_z \sum_k t_k\, \Delta r_k, \qquad M = f_z \sum_k q_k\, r_k\, \Delta r_k

    with :math:`\Delta r_k` the part of element k that cuts and :math:`r_k` the middle of that part.

    Parameters
    ----------
    elements : LipElements
        Stresses :math:`t_k, q_k` per swept section [Pa].
    feed : float
        Feed per revolution :math:`f = 2 f_z` [m].
    inner, outer : float
        Radii between which the lip cuts [m]; what lies beyond the elements cuts nothing.

    Returns
    -------
    LipForce
        Thrust, tangential and inward force [N], torque [N m].

    Notes
    -----
    Valid for :math:`0 \le inner \le outer`; exact for stresses that are constant within an element.

    Examples
    --------
    Half of a first element of 1 mm and half of a second one of 2 mm:

    >>> one, two, none = np.array([1e9, 1e9]), np.array([1e9, 2e9]), np.array([0.0, 0.0])
    >>> [round(v, 6) for v in elements_force(LipElements(np.array([0.0, 1e-3, 3e-3]), two, one, none), 2e-4, 5e-4, 2e-3)]
    [250.0, 0.1875, 150.0, 0.0]

    References
    ----------
    Garnier et al. 2017, abstract (discretised chip section) and Eq. (1); fractional elements are derived here.
    """
    thrust, torque, tangential, inward = 0.0, 0.0, 0.0, 0.0
    lip_feed = 0.5 * feed
    for k in range(elements.thrust.size):
        low = max(elements.edges[k], inner)
        high = min(elements.edges[k + 1], outer)
        if high <= low:
            continue
        section = lip_feed * (high - low)
        thrust += elements.thrust[k] * section
        tangential += elements.tangential[k] * section
        inward += elements.inward[k] * section
        torque += elements.tangential[k] * section * 0.5 * (low + high)
    return LipForce(thrust, torque, tangential, inward)
