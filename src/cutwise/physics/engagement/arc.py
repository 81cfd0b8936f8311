"""Immersion arcs of a mill that cuts a layer on top of the work: burr in front, work below, burr again behind."""

import math
from typing import NamedTuple

from cutwise.maths.compiled import inlined


class LayerArcs(NamedTuple):
    """Arcs of the two layers, as entry and exit angles [rad]; an arc with exit <= entry is empty."""

    front_lo: float  # burr ahead of the lowest point, or all of it while the work is not reached
    front_hi: float
    back_lo: float  # burr behind the lowest point: cut while the tool plunges
    back_hi: float
    work_lo: float
    work_hi: float


@inlined
def immersion_half_angle(depth: float, radius: float) -> float:
    r"""Half angle of the arc that a mill of given radius has inside a layer.

    .. math:: \delta = \arccos(1 - p_r / R), \qquad \delta = \pi \text{ for } p_r \ge 2R

    Parameters
    ----------
    depth : float
        Radial depth :math:`p_r` of the layer [m]. Not positive: no contact, 0 is returned.
    radius : float
        Mill radius :math:`R` [m], positive.

    Returns
    -------
    float
        Half angle :math:`\delta` [rad], 0 to :math:`\pi`.

    Notes
    -----
    Valid for a layer that is straight over the mill's diameter. On a convex border whose radius is 10 R, half a radius
    deep, the true angle is 57.61 degrees, 4 % less.

    Examples
    --------
    A quarter of the diameter deep: 60 degrees.

    >>> round(math.degrees(immersion_half_angle(0.001, 0.002)), 9)
    60.0

    References
    ----------
    Berselli et al. 2016, Eq. (11); clamped beyond a full slot, which the paper leaves out.
    """
    if depth <= 0.0:
        return 0.0
    return math.acos(max(-1.0, 1.0 - depth / radius))


@inlined
def layer_arcs(depth: float, work_depth: float, theta: float, radius: float) -> LayerArcs:
    r"""Immersion arcs of burr and work in down milling.

    With :math:`\delta`, :math:`\delta_p` the half angles of the whole depth and of the work,
    :math:`lo = \max(\pi - \delta, \vartheta)`, :math:`hi = \min(\pi + \vartheta, \pi + \delta)`, the burr is cut over
    :math:`[lo, \min(hi, \pi - \delta_p)] \cup [\max(lo, \pi + \delta_p), hi]` and the work over
    :math:`[\max(lo, \pi - \delta_p), \min(hi, \pi + \delta_p)]`.

    Parameters
    ----------
    depth : float
        Radial depth :math:`p_r` of the tool below the top of the burr [m].
    work_depth : float
        Radial depth :math:`p_{rp}` of the tool below the nominal edge [m].
    theta : float
        Feed direction [rad], positive when the tool plunges.
    radius : float
        Mill radius [m].

    Returns
    -------
    LayerArcs
        Entry and exit angles [rad]; an arc with exit <= entry is empty.

    Notes
    -----
    Valid for :math:`p_{rp} \le p_r`, :math:`|\vartheta| < \pi` and layers that are straight over the mill's diameter and
    stand as the programmed cut left them: what the mill itself cut earlier is not known here.

    Examples
    --------
    R = 4 mm, a burr of 2 mm and 2 mm of work, straight on: burr from 90 to 120 degrees, work from there to the lowest
    point, nothing behind it (240 is beyond 180).

    >>> [round(math.degrees(angle), 6) for angle in layer_arcs(4e-3, 2e-3, 0.0, 4e-3)]
    [90.0, 120.0, 240.0, 180.0, 120.0, 180.0]

    References
    ----------
    Berselli et al. 2016, Eq. (11), corrected: the printed limits hold for :math:`|\vartheta| \le \delta_p` only, and
    the second burr arc is missing.
    """
    if depth <= 0.0:
        return LayerArcs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    delta = immersion_half_angle(depth, radius)
    lo = max(math.pi - delta, theta)
    hi = min(math.pi + theta, math.pi + delta)
    if hi <= lo:
        return LayerArcs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if work_depth <= 0.0:
        return LayerArcs(lo, hi, 0.0, 0.0, 0.0, 0.0)
    inner = immersion_half_angle(work_depth, radius)
    return LayerArcs(
        lo,
        min(hi, math.pi - inner),
        max(lo, math.pi + inner),
        hi,
        max(lo, math.pi - inner),
        min(hi, math.pi + inner),
    )
