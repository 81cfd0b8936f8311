"""Flutes along a helix: how far they lag, which of them stand in an arc, and over which heights."""

import math

from cutwise.maths.compiled import compiled, inlined


@inlined
def helix_lag(helix: float, radius: float) -> float:
    r"""Angle that a flute lags behind for each length of the axis.

    .. math:: k_\beta = \tan\beta / R

    Parameters
    ----------
    helix : float
        Angle of the helix :math:`\beta` [rad]; a left-hand one is negative.
    radius : float
        Of the mill R [m].

    Returns
    -------
    float
        Lag [rad/m].

    Notes
    -----
    Valid for less than a right angle.

    Examples
    --------
    >>> round(helix_lag(0.25 * math.pi, 4e-3), 9)
    250.0

    References
    ----------
    Berselli et al. 2016, Eq. (2).
    """
    return math.tan(helix) / radius


@compiled
def flutes_in_cut(
    rotation: float, lo: float, hi: float, z_lo: float, z_hi: float, flutes: int, lag: float
) -> tuple[int, int]:
    r"""First and last flute j that may stand in an arc, counted on through all turns.

    :math:`j_0 = \lfloor (lo + k_\beta z - \phi) / \phi_p \rfloor + 1` at the lowest lag,
    :math:`j_1 = \lfloor (hi + k_\beta z - \phi) / \phi_p \rfloor` at the highest: of an arc :math:`lo < \phi \le hi`, so that
    a straight flute that stands where two arcs meet is in one of them alone.

    Parameters
    ----------
    rotation : float
        Rotation :math:`\phi` of the mill [rad], flute 0 at the tip.
    lo, hi : float
        Immersion arc [rad].
    z_lo, z_hi : float
        Axial limits above the tip [m].
    flutes : int
        How many flutes.
    lag : float
        :func:`helix_lag` [rad/m].

    Returns
    -------
    tuple
        First and last flute; the last is the lower number where none is in the arc.

    Notes
    -----
    Valid for arcs of less than a turn and any helix that is not negative.

    Examples
    --------
    Of two straight flutes, now at 0 and 180 degrees, the second is between 0.5 and 4 rad:

    >>> flutes_in_cut(0.0, 0.5, 4.0, 0.0, 1e-3, 2, 0.0)
    (1, 1)

    References
    ----------
    Derived here; takes the place of the list of cases after Berselli et al. 2016, Eq. (6).
    """
    pitch = 2.0 * math.pi / flutes
    first = math.floor((lo + min(lag * z_lo, lag * z_hi) - rotation) / pitch) + 1
    last = math.floor((hi + max(lag * z_lo, lag * z_hi) - rotation) / pitch)
    return first, last


@compiled
def edge_in_cut(
    rotation: float, flute: int, lo: float, hi: float, z_lo: float, z_hi: float, flutes: int, lag: float
) -> tuple[float, float, float, float]:
    r"""Part of one flute that stands in an arc: its axial limits [m], and middle and width of its angles [rad].

    .. math:: z_{1,2} = \frac{\phi + j\phi_p - (hi, lo)}{k_\beta} \;\text{within}\; [z_{lo}, z_{hi}], \qquad
              \phi_m = \phi + j\phi_p - k_\beta \frac{z_1 + z_2}{2}, \qquad \Delta = k_\beta (z_2 - z_1)

    Parameters
    ----------
    rotation : float
        Rotation :math:`\phi` of the mill [rad], flute 0 at the tip.
    flute : int
        j, one of :func:`flutes_in_cut`.
    lo, hi : float
        Immersion arc [rad].
    z_lo, z_hi : float
        Axial limits of the layer above the tip [m].
    flutes : int
        How many flutes.
    lag : float
        :func:`helix_lag` [rad/m].

    Returns
    -------
    tuple
        :math:`z_1, z_2, \phi_m, \Delta`; nothing is in cut if :math:`z_2 \le z_1`. A straight flute counts whole: valid if
        it is one of :func:`flutes_in_cut`. The width is negative on a left-hand helix.

    Examples
    --------
    A helix that lags by 250 rad/m enters the arc from 0.5 rad at a height of (1 - 0.5)/250 m:

    >>> [round(v, 9) for v in edge_in_cut(1.0, 0, 0.5, 2.0, 0.0, 1e-2, 2, 250.0)]
    [0.0, 0.002, 0.75, 0.5]

    References
    ----------
    Berselli et al. 2016, Eq. (2) and the limits after Eq. (6), of which line 3 is a misprint.
    """
    start = rotation + flute * 2.0 * math.pi / flutes
    z1, z2 = z_lo, z_hi
    if lag != 0.0:
        end_a = (start - hi) / lag
        end_b = (start - lo) / lag
        z1 = max(z_lo, min(end_a, end_b))
        z2 = min(z_hi, max(end_a, end_b))
    return z1, z2, start - lag * 0.5 * (z1 + z2), lag * (z2 - z1)
