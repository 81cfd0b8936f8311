r"""An end mill along a shoulder or in a slot: one arc, as wide and as deep as the deflected tool leaves it.

The uncut surface is at y = 0, the programmed tool reaches down to :math:`-a_e`; its tip is at z = 0, the floor of the cut
is what it leaves. A tool that yields by u cuts :math:`a_e - u_y` wide and :math:`a_p - u_z` deep.
"""

import math
from typing import NamedTuple

from cutwise.maths.compiled import inlined
from cutwise.physics.engagement.arc import immersion_half_angle
from cutwise.physics.engagement.burred_edge import Round
from cutwise.physics.engagement.feed import feed_per_tooth
from cutwise.stages import displaced, left, met, probed, spatial

SEEN = 3  # columns shown: radial depth, axial depth, immersion angle


class Shoulder(NamedTuple):
    """A wall along the feed, with the work on one side."""

    mill: Round
    axial_depth: float  # a_p [m]
    begins: float = -math.inf  # [m] of the path: where the work begins
    ends: float = math.inf  # [m] of the path: where it ends
    standstill: float = 0.0  # [m/s] slower feed cuts nothing


class Slot(NamedTuple):
    """A slot as wide as the mill or wider than it: the arc is half a turn, wherever the tool is."""

    mill: Round
    axial_depth: float  # a_p [m]
    begins: float = -math.inf  # [m] of the path: where the work begins
    ends: float = math.inf  # [m] of the path: where it ends
    standstill: float = 0.0  # [m/s] slower feed cuts nothing


@inlined
def cuts(engagement: Shoulder, along: float, vx: float, vy: float) -> bool:
    r"""Whether the tool is in the work, and fed.

    .. math:: s_0 \le s < s_1, \qquad |v| \ge v_0

    Parameters
    ----------
    engagement : Shoulder
        Where the work begins and ends [m], and the least feed [m/s].
    along : float
        Path behind the tool [m].
    vx, vy : float
        Velocity of the tool [m/s].

    Notes
    -----
    Valid for a wall that begins and ends across the feed.

    Examples
    --------
    >>> wall = Shoulder(Round(5e-3, 2, 100.0), 1e-3, 0.0, 0.1, 1e-6)
    >>> cuts(wall, 0.05, 0.01, 0.0), cuts(wall, 0.1, 0.01, 0.0), cuts(wall, 0.05, 0.0, 0.0)
    (True, False, False)

    References
    ----------
    Derived here.
    """
    return engagement.begins <= along < engagement.ends and math.hypot(vx, vy) >= engagement.standstill


@spatial.of(Shoulder, Slot)
def _(engagement):
    return True


@probed.of(Shoulder, Slot)
def _(engagement, pose):
    """Half the programmed depth."""
    return 0.0, 0.5 * engagement.axial_depth


@met.of(Shoulder)
def _(engagement, stock, pose, structure, flexed, contact):
    mill, rows, seen = engagement.mill, contact.rows, contact.seen
    if not cuts(engagement, pose.along, pose.vx, pose.vy):
        seen[0], seen[1], seen[2] = 0.0, 0.0, 0.0
        return 0
    tip = displaced(structure, flexed, 0.0, 0.5 * engagement.axial_depth)
    radial, depth = -(pose.y + tip.y), engagement.axial_depth - (pose.z + tip.z)
    angle = immersion_half_angle(radial, mill.radius)
    seen[0], seen[1], seen[2] = max(0.0, radial), max(0.0, depth), angle
    if angle <= 0.0 or depth <= 0.0:
        return 0
    rows[0, 0] = 0
    rows[0, 1] = 0.5 * (engagement.axial_depth - depth)
    rows[0, 2] = depth
    rows[0, 3] = math.pi - angle
    rows[0, 4] = math.pi
    rows[0, 5] = feed_per_tooth(pose.vx, pose.vy, mill.spindle_speed, mill.flutes)
    rows[0, 6] = 0.0
    return 1


@met.of(Slot)
def _(engagement, stock, pose, structure, flexed, contact):
    mill, rows, seen = engagement.mill, contact.rows, contact.seen
    if not cuts(engagement, pose.along, pose.vx, pose.vy):
        seen[0], seen[1], seen[2] = 0.0, 0.0, 0.0
        return 0
    tip = displaced(structure, flexed, 0.0, 0.5 * engagement.axial_depth)
    depth = engagement.axial_depth - (pose.z + tip.z)
    seen[0], seen[1], seen[2] = 2.0 * mill.radius, max(0.0, depth), math.pi
    if depth <= 0.0:
        return 0
    rows[0, 0] = 0
    rows[0, 1] = 0.5 * (engagement.axial_depth - depth)
    rows[0, 2] = depth
    rows[0, 3] = 0.0
    rows[0, 4] = math.pi
    rows[0, 5] = feed_per_tooth(pose.vx, pose.vy, mill.spindle_speed, mill.flutes)
    rows[0, 6] = 0.0
    return 1


@left.of(Shoulder, Slot)
def _(engagement, stock, contact, count):
    return 0
