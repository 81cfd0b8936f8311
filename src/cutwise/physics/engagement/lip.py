"""Which part of a drill lip is in the work: flat or inclined entry and exit."""

import math

from cutwise.maths.compiled import compiled


@compiled
def lip_contact(
    depth: float, thickness: float, radius: float, half_point_angle: float, inclination: float, azimuth: float
) -> tuple[float, float]:
    r"""Radii between which a lip cuts, at one azimuth.

    The lip lies at :math:`z(r) = h - r\cot\kappa`, the entry surface at :math:`z_s = r\cos\varphi\tan\alpha`, the exit
    surface one thickness (along the drill axis) further. A point cuts between them:

    .. math::
        D_\varphi = \cot\kappa + \cos\varphi\tan\alpha, \qquad
        r_\mathrm{hi} = \mathrm{clip}(h/D_\varphi, 0, R), \quad
        r_\mathrm{lo} = \mathrm{clip}((h - t)/D_\varphi, 0, R)

    Parameters
    ----------
    depth : float
        Depth :math:`h` of the tip below the entry surface, on the axis [m].
    thickness : float
        Thickness :math:`t` of the part along the drill axis [m].
    radius, half_point_angle : float
        :math:`R` [m] and :math:`\kappa` [rad] of the drill.
    inclination : float
        Slope :math:`\alpha` of the surface against the normal plane of the axis, tilt about y [rad];
        :math:`|\alpha| < 90^\circ - \kappa`, else a corner of the drill touches before its tip.
    azimuth : float
        Angle :math:`\varphi` of the lip from x [rad].

    Returns
    -------
    tuple
        Inner and outer radius [m]; equal when nothing is cut.

    Notes
    -----
    Valid for plane, parallel surfaces.
    Full chip thickness everywhere in contact: no first-turn effects, no bending of the remaining plate.

    Examples
    --------
    A point of 90 degrees 3 mm deep in a plate of 2 mm: it cuts from 1 to 3 mm.

    >>> [round(1e3 * r, 9) for r in lip_contact(3e-3, 2e-3, 5e-3, 0.25 * math.pi, 0.0, 0.0)]
    [1.0, 3.0]

    References
    ----------
    Derived here; Garnier et al. 2017 have full contact only.
    """
    slope = 1.0 / math.tan(half_point_angle) + math.cos(azimuth) * math.tan(inclination)
    outer = min(max(depth / slope, 0.0), radius)
    inner = min(max((depth - thickness) / slope, 0.0), radius)
    return inner, outer
