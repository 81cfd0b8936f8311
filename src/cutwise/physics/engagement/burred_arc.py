r"""A mill on a convex edge that is an arc, with a burr: heights are distances of the actual axis from the curve.

:math:`y = |P - O| - \rho - R`, with normal and tangent there; projecting on the programmed normal instead is 23 µm wrong
on a radius of 50 mm. The half angle of a layer whose face has the radius r is

.. math:: \cos\delta = \frac{D^2 + R^2 - r^2}{2 D R}, \qquad D = r + R - p,

:math:`r = \rho + h_b` for the top of the burr and :math:`\rho` for the work; :math:`r \to \infty` gives
:math:`1 - p / R`.
"""

import math
from typing import NamedTuple

from cutwise.maths.compiled import inlined
from cutwise.maths.curves import polyline_value
from cutwise.physics.engagement.arc import LayerArcs
from cutwise.physics.engagement.burred_edge import Immersion, Layers, Placed, Round, immersed, meet_layers
from cutwise.physics.engagement.feed import feed_direction, feed_per_tooth
from cutwise.stages import left, met, probed, spatial


class BurredArc(NamedTuple):
    """A convex edge of constant radius, with a burr; the tool is placed from the centre of the arc."""

    layers: Layers
    mill: Round
    radius: float  # [m] of the nominal edge
    fixed: bool = False  # process axes do not turn with the edge


@inlined
def half_angle(depth: float, face: float, mill: float) -> float:
    r"""Half angle of the arc of a mill a depth inside a convex face.

    .. math:: \cos\delta = \frac{D^2 + R^2 - r^2}{2 D R}, \qquad D = r + R - p

    Parameters
    ----------
    depth : float
        Radial depth p [m]; not positive: 0, a diameter and more: :math:`\pi`.
    face : float
        Radius r of the face [m], positive.
    mill : float
        Mill radius R [m].

    Returns
    -------
    float
        :math:`\delta` [rad], 0 to :math:`\pi`.

    Notes
    -----
    Valid for p < 2 r (the mill does not reach beyond the centre of the face).

    Examples
    --------
    A quarter of the diameter deep in a face of ten radii: 57.61 degrees, for 60 of a straight one.

    >>> round(math.degrees(half_angle(0.001, 0.02, 0.002)), 2)
    57.61

    References
    ----------
    Derived here; :math:`r \to \infty` is Berselli et al. 2016, Eq. (11).
    """
    if depth <= 0.0:
        return 0.0
    if depth >= 2.0 * mill:
        return math.pi
    distance = face + mill - depth
    # 1 - cos, free of the difference of large squares: (r^2 - (D - R)^2) / (2 D R)
    return math.acos(max(-1.0, 1.0 - depth * (2.0 * face - depth) / (2.0 * distance * mill)))


@inlined
def arcs_of(depth: float, work_depth: float, theta: float, radius: float, top: float, edge: float) -> LayerArcs:
    """Arcs of burr and work as on a straight edge (:func:`~cutwise.physics.engagement.arc.layer_arcs`), round faces.

    Parameters
    ----------
    depth, work_depth : float
        Radial depth of the tool below the top of the burr, and below the nominal edge [m].
    theta : float
        Feed direction [rad] against the tangent at the foot, positive when the tool plunges.
    radius : float
        Mill radius [m].
    top, edge : float
        Radius of the top of the burr, and of the nominal edge [m].

    Returns
    -------
    LayerArcs
        Angles [rad] from the normal at the foot of the mill axis; valid as :func:`half_angle` is.

    Examples
    --------
    The face of :func:`half_angle`, burr alone: from 180 - 57.61 degrees on.

    >>> arcs = arcs_of(0.001, 0.0, 0.0, 0.002, 0.02, 0.019)
    >>> round(math.degrees(arcs.front_lo), 2), round(math.degrees(arcs.front_hi), 2)
    (122.39, 180.0)

    References
    ----------
    Derived here; on a straight edge Berselli et al. 2016, Eq. (11), corrected.
    """
    if depth <= 0.0:
        return LayerArcs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    delta = half_angle(depth, top, radius)
    lo, hi = max(math.pi - delta, theta), min(math.pi + theta, math.pi + delta)
    if hi <= lo:
        return LayerArcs(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if work_depth <= 0.0:
        return LayerArcs(lo, hi, 0.0, 0.0, 0.0, 0.0)
    inner = half_angle(work_depth, edge, radius)
    return LayerArcs(
        lo, min(hi, math.pi - inner), max(lo, math.pi + inner), hi, max(lo, math.pi - inner), min(hi, math.pi + inner)
    )


@immersed.of(BurredArc)
def _(engagement, pose, tip):
    """From place and velocity of the axis, seen from the centre of the arc; process axes may turn with the edge."""
    mill = engagement.mill
    x, y = pose.x + tip.x, pose.y + tip.y
    speed_x, speed_y = pose.vx + tip.vx + pose.spin * tip.y, pose.vy + tip.vy - pose.spin * tip.x
    burr = polyline_value(engagement.layers.burr_height, pose.along)
    distance = math.hypot(x, y)
    sine, cosine = x / distance, y / distance
    along, off = speed_x * cosine - speed_y * sine, speed_x * sine + speed_y * cosine
    height = distance - engagement.radius - mill.radius
    theta = feed_direction(along, off)
    depth, work_depth = burr - height, max(0.0, -height)
    arcs = arcs_of(max(depth, work_depth), work_depth, theta, mill.radius, engagement.radius + burr, engagement.radius)
    chip = feed_per_tooth(along, off, mill.spindle_speed, mill.flutes)
    return Placed(Immersion(depth, work_depth, theta, chip, arcs), math.atan2(x, y))


@spatial.of(BurredArc)
def _(engagement):
    """Where the normal turns away from y, a displacement along x is one off the edge."""
    return engagement.fixed


@probed.of(BurredArc)
def _(engagement, pose):
    layers = engagement.layers
    return layers.strips.burr_start, 0.5 * polyline_value(layers.burr_width, pose.along)


@met.of(BurredArc)
def _(engagement, stock, pose, structure, flexed, contact):
    return meet_layers(engagement, pose, structure, flexed, contact)


@left.of(BurredArc)
def _(engagement, stock, contact, count):
    return 0
