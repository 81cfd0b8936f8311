"""A mill on an edge with a burr: arcs of burr and work from where the tool is now."""

from typing import NamedTuple

from cutwise.maths.compiled import inlined, inlined_stepping
from cutwise.maths.curves import FloatArray, Polyline, polyline_value
from cutwise.physics.engagement.arc import LayerArcs, layer_arcs
from cutwise.physics.engagement.burr import entry_position
from cutwise.physics.engagement.feed import feed_direction, feed_per_tooth
from cutwise.stages import displaced, left, met, probed, spatial, stage

SEEN = 6  # columns that the edge shows of itself
PIECES = 3  # rows of contact of a slice: burr before and behind the lowest point, work


class Strips(NamedTuple):
    """How burr and work stand along the spindle axis."""

    burr_start: float  # [m] of the burr above the tool tip
    work_start: float  # [m] of the work above the tool tip
    work_width: float  # [m] contact length a
    slices: int


class Layers(NamedTuple):
    """What stands along the edge: the work, and a burr on its rim."""

    burr_height: Polyline  # [m] above the nominal edge, over the position along it [m]
    burr_width: Polyline  # [m] along the spindle axis
    strips: Strips


class Round(NamedTuple):
    """The turning tool as the edge meets it."""

    radius: float  # [m]
    flutes: int
    spindle_speed: float  # [rad/s]


class BurredEdge(NamedTuple):
    """An edge with a burr, met by a mill whose own older surface does not matter."""

    layers: Layers
    mill: Round


class Immersion(NamedTuple):
    """The mill in the layers at one height above its tip, at one instant."""

    depth: float  # [m] below the top of the burr
    work_depth: float  # [m] below the nominal edge
    theta: float  # [rad]
    chip: float  # [m]
    arcs: LayerArcs


class Placed(NamedTuple):
    """An immersion, and how the normal stands that it is seen from."""

    immersion: Immersion
    turn: float  # [rad] of the normal from y of the process axes, clockwise


@stage
def immersed(engagement, pose, tip):
    """Immersion of the mill with its axis displaced, at one height."""


@inlined
def immersion_at(
    mill: Round, burr_height: Polyline, x: float, height: float, speed_x: float, speed_y: float
) -> Immersion:
    r"""Immersion of a mill from position and velocity of its axis: entry into the burr, arcs, chip load.

    .. math:: p_r = h_b(w_e) - y, \qquad p_{rp} = \max(0, -y)

    Parameters
    ----------
    mill : Round
        Radius [m], flutes, spindle speed [rad/s].
    burr_height : Polyline
        :math:`h_b` over the position along the edge [m].
    x : float
        Axis along the edge [m].
    height : float
        Height y of the lowest point of the mill above the nominal edge [m].
    speed_x, speed_y : float
        Velocity of the axis [m/s].

    Returns
    -------
    Immersion
        Depths [m], feed direction [rad], feed per tooth [m], arcs [rad].

    Notes
    -----
    Valid where the burr hardly changes over the arc: its height at the entry stands for all of it.

    Examples
    --------
    1 mm deep in the work under a burr of 1 mm, R = 4 mm, 20 mm/s with 2 flutes at 6000 rpm: arcs from 120 degrees on.

    >>> import math, numpy as np
    >>> mill, burr = Round(4e-3, 2, 200 * math.pi), Polyline(np.zeros(1), np.array([1e-3]))
    >>> here = immersion_at(mill, burr, 0.0, -1e-3, 0.02, 0.0)
    >>> [round(1e3 * v, 9) for v in (here.depth, here.work_depth, here.chip)], round(math.degrees(here.arcs.front_lo), 6)
    ([2.0, 1.0, 0.1], 120.0)

    References
    ----------
    Berselli et al. 2016, sec. 3.1 and Eqs. (8), (9), (11), corrected; the entry into an uneven burr is derived here.
    """
    radius = mill.radius
    entry = entry_position(x, height, radius, burr_height)
    theta = feed_direction(speed_x, speed_y)
    depth = polyline_value(burr_height, entry) - height
    work_depth = max(0.0, -height)
    arcs = layer_arcs(max(depth, work_depth), work_depth, theta, radius)
    return Immersion(depth, work_depth, theta, feed_per_tooth(speed_x, speed_y, mill.spindle_speed, mill.flutes), arcs)


@inlined_stepping
def show(here: Immersion, seen: FloatArray) -> None:
    """Depth in burr and work [m], feed direction [rad], chip [m], first entry and last exit [rad]: for the history.

    ``here``: what the mill meets; ``seen``: filled, shape (6,).

    Valid for arcs as :func:`immersion_at` has them; angles are zero where nothing is met.

    Examples
    --------
    >>> import numpy as np
    >>> seen = np.zeros(6)
    >>> show(Immersion(3e-3, 1e-3, 0.1, 5e-5, LayerArcs(2.0, 2.5, 3.9, 3.2, 2.5, 3.3)), seen)
    >>> seen.round(9).tolist()
    [0.002, 0.001, 0.1, 5e-05, 2.0, 3.3]

    References
    ----------
    Derived here.
    """
    seen[0] = max(0.0, here.depth - here.work_depth)
    seen[1] = here.work_depth
    seen[2] = here.theta
    seen[3] = here.chip
    seen[4] = here.arcs.front_lo
    seen[5] = max(here.arcs.front_hi, max(here.arcs.work_hi, here.arcs.back_hi))


@spatial.of(BurredEdge)
def _(engagement):
    return False


@probed.of(BurredEdge)
def _(engagement, pose):
    """The middle of the burr, point A of the paper."""
    layers = engagement.layers
    return layers.strips.burr_start, 0.5 * polyline_value(layers.burr_width, pose.along)


@immersed.of(BurredEdge)
def _(engagement, pose, tip):
    here = immersion_at(
        engagement.mill,
        engagement.layers.burr_height,
        pose.x + tip.x,
        pose.y + tip.y,
        pose.vx + tip.vx,
        pose.vy + tip.vy,
    )
    return Placed(here, 0.0)


@inlined_stepping
def meet_layers(engagement, pose, structure, flexed, contact):
    """Rows of contact of burr and work: with one slice the whole mill is immersed as at the middle of the burr; with
    several each strip as at its own height, tilted with the motor. A mill is round, so that arcs seen from a normal that
    is turned are arcs of the process axes, turned.

    Parameters
    ----------
    engagement : NamedTuple
        With ``layers``, and a law of :func:`immersed`.
    pose, structure, flexed
        Tool where it is commanded, and what displaces it.
    contact : Contact
        Filled: rows of layer, foot and width [m], arc [rad], feed per tooth [m], its direction [rad]; ``seen`` as by
        :func:`show`. Room for three rows a slice.

    Returns
    -------
    int
        Number of rows; valid as :func:`immersion_at` is.

    Examples
    --------
    The mill of :func:`immersion_at` on a rigid spindle, 1 mm of burr on 5 mm of work: one row each, the burr from 120 to
    138.59 degrees (arccos 3/4 from 180).

    >>> import math, numpy as np
    >>> from cutwise.physics.structure.terms import Rigid
    >>> from cutwise.records import Contact, Pose
    >>> flat, contact = Polyline(np.zeros(1), np.array([1e-3])), Contact(np.zeros((3, 12)), np.zeros(6))
    >>> edge = BurredEdge(Layers(flat, flat, Strips(5e-3, 0.0, 5e-3, 1)), Round(4e-3, 2, 200 * math.pi))
    >>> meet_layers(edge, Pose(0.0, 0.0, 0.0, -1e-3, 0.0, 0.02, 0.0, 0.0, 0.0), Rigid(0.0), (), contact)
    2
    >>> np.degrees(contact.rows[:2, 3:5]).round(2).tolist()
    [[120.0, 138.59], [138.59, 180.0]]

    References
    ----------
    Berselli et al. 2016, Eq. (11), corrected; strips along the axis are derived here.
    """
    strips = engagement.layers.strips
    rows = contact.rows
    width = polyline_value(engagement.layers.burr_width, pose.along)
    at_a = immersed(engagement, pose, displaced(structure, flexed, strips.burr_start, 0.5 * width))
    n = strips.slices
    count = 0
    for layer in range(2):
        start = strips.burr_start if layer == 0 else strips.work_start
        strip = (width if layer == 0 else strips.work_width) / n
        for k in range(n):
            foot = start + k * strip
            here = at_a
            if n > 1:
                here = immersed(engagement, pose, displaced(structure, flexed, foot, 0.5 * strip))
            arcs = here.immersion.arcs
            lo = arcs.front_lo if layer == 0 else arcs.work_lo
            hi = arcs.front_hi if layer == 0 else arcs.work_hi
            for piece in range(2 - layer):
                if piece == 1:
                    lo, hi = arcs.back_lo, arcs.back_hi
                if hi > lo:
                    rows[count, 0] = layer
                    rows[count, 1] = foot
                    rows[count, 2] = strip
                    rows[count, 3] = lo + here.turn
                    rows[count, 4] = hi + here.turn
                    rows[count, 5] = here.immersion.chip
                    rows[count, 6] = here.immersion.theta + here.turn
                    count += 1
    show(at_a.immersion, contact.seen)
    return count


@met.of(BurredEdge)
def _(engagement, stock, pose, structure, flexed, contact):
    return meet_layers(engagement, pose, structure, flexed, contact)


@left.of(BurredEdge)
def _(engagement, stock, contact, count):
    """Arcs know no stock."""
    return 0
