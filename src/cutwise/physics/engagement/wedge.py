r"""A ball that turns in the material along an edge: planes at the samples of its path, discs, and arcs of these.

A ball that is displaced cuts the material of the place **where it is**, not of the one where it should be: it is looked
up along the path by its foot, with the depth and height that it has there, and with the speed with which that foot goes
along. The planes stand straight between two samples, and everything is seen in the frame of the pass there
(:mod:`cutwise.physics.engagement.ball`).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.maths.compiled import inlined_stepping
from cutwise.maths.curves import FloatArray
from cutwise.physics.engagement.ball import SIDE, arc_room, disc_arcs, height_limits, leading_side
from cutwise.physics.engagement.burred_edge import Round
from cutwise.physics.engagement.feed import feed_direction, feed_per_tooth
from cutwise.stages import displaced, left, met, probed, spatial

SEEN = 4  # columns shown: sample of the path, share of the way to the next, ball off its path there along y and z [m]
WORK, BURR = 0, 1  # layers
LEVEL = (1.0, 0.0, 0.0, 1.0)  # frame of the pass where process axes are those of the pass


class Wedge(NamedTuple):
    """Material along a path between planes, in process axes whose z is the rod and that do not turn with the path."""

    ball: Round
    slices: int  # discs over the height of the contact, and as many over that of the burr
    place: FloatArray  # [m] of the nominal ball centre in process axes, shape (n, 3)
    frame: FloatArray  # feed x, y, then off the work x, y: axes of the pass seen in process axes, shape (n, 4)
    planes: FloatArray  # of the two faces, frame of the pass, from the ball centre, shape (n, 2, 4)
    burr: FloatArray  # of the burr, shape (n, 4, 4), or (n, 0, 4) without one
    contact: FloatArray  # speed of the contact over that of the ball centre, shape (n,)
    speed: FloatArray  # [m/s] of the contact across the rod, shape (n,)
    rise: FloatArray  # [m/s] of the contact along the rod, shape (n,)
    slope: FloatArray  # of the path of the ball: way along the rod for way across it, shape (n,)
    closed: bool


class Passing(NamedTuple):
    """Where along the path the ball is; and room for the planes of one place and their arcs, which is scratch."""

    at: NDArray[np.int64]  # sample, shape (1,)
    sides: FloatArray  # planes of the work and the one ahead, shape (3, 4)
    burr: FloatArray  # planes of the burr and the one ahead, shape (5, 4)
    lean: FloatArray  # shape (5, 2)
    arcs: FloatArray  # shape (2 * 7, 2)


def passing(start: int = 0) -> Passing:
    """A ball at a sample of its path."""
    room = np.zeros((arc_room(5), 2))
    return Passing(np.array([start]), np.zeros((3, SIDE)), np.zeros((5, SIDE)), np.zeros((5, 2)), room)


def most_discs(engagement: Wedge) -> int:
    """Rows of contact that a ball can have at most: a disc inside of m planes has m + 1 arcs at most.

    Examples
    --------
    Ten slices of a wedge without a burr, three planes with the one ahead:

    >>> table, at = np.zeros((2, 2, 4)), np.zeros(2)
    >>> most_discs(Wedge(Round(1e-3, 2, 100.0), 10, at, at, table, np.zeros((2, 0, 4)), at, at, at, at, False))
    40
    """
    return engagement.slices * (4 + (6 if engagement.burr.shape[1] else 0))


@inlined_stepping
def foot(place, frame, closed, x, y, start):
    """Where a ball at a place across the rod is along the path, looked for from a sample on.

    Parameters
    ----------
    place : array (n, 3)
        Nominal ball centres in process axes [m].
    frame : array (n, 4)
        Feed x, y, then off the work x, y, in process axes.
    closed : bool
        Whether the path comes back to its first sample.
    x, y : float
        Ball across the rod [m].
    start : int
        Sample where the search begins.

    Returns
    -------
    tuple
        Two samples, how far it is from one to the other (0 to 1), and how much faster than it the foot goes along the path.

    Notes
    -----
    Valid for a ball that is nearer to its path than that bends; beyond, ``start`` is given back. The ends of an open path
    hold.

    Examples
    --------
    A quarter of the way between two samples of a straight path:

    >>> place, frame = np.array([[0.0, 0.0, 0.0], [1e-3, 0.0, 0.0]]), np.array([[1.0, 0.0, 0.0, 1.0]] * 2)
    >>> foot(place, frame, False, 2.5e-4, 0.0, 0)
    (0, 1, 0.25, 1.0)

    References
    ----------
    Derived here.
    """
    n = place.shape[0]
    j = start
    for _ in range(n):
        behind = (x - place[j, 0]) * frame[j, 0] + (y - place[j, 1]) * frame[j, 1]
        if behind < 0.0:
            if not closed and j == 0:
                return 0, 1, 0.0, 1.0
            j = (j - 1) % n
            continue
        if not closed and j == n - 1:
            return n - 2, n - 1, 1.0, 1.0
        k = (j + 1) % n
        ahead = (x - place[k, 0]) * frame[k, 0] + (y - place[k, 1]) * frame[k, 1]
        if ahead < 0.0:
            length = math.hypot(place[k, 0] - place[j, 0], place[k, 1] - place[j, 1])
            return j, k, behind / (behind - ahead), length / (behind - ahead)
        j = k
    return start, start, 0.0, 1.0  # no place of its own: a ball carried away farther than the path bends


@inlined_stepping
def discs(sides, lean, arcs, ball, vx, vy, vz, slices, layer, frame, rows, count):
    """Rows of contact of a ball inside of some planes, of which the last is made here: that of what lies ahead.

    A row: layer, foot and width of the disc over the tip [m], its arc [rad], chip across the rod [m], its direction
    [rad], chip along the rod [m], axes of the pass in process axes.

    Parameters
    ----------
    sides : array
        Planes that bound the material, and room for one more, shape (m + 1, 4); made unit vectors.
    lean, arcs : array
        Scratch, shapes (m + 1, 2) and (arc_room(m + 1), 2).
    ball : Round
        The cutter.
    vx, vy, vz : float
        Velocity of the ball in the frame of the pass [m/s].
    slices, layer : int
        Discs over the height of the contact, and the layer that they are of.
    frame : tuple
        Feed x, y, then off the work x, y.
    rows, count : array, int
        Where to, and how many are there.

    Returns
    -------
    int
        How many rows there are then.

    Notes
    -----
    Valid for a convex body and a ball that goes straight on over its own radius; a disc stands for its height, second order
    in it.

    Examples
    --------
    Half space y < 0, feed along x: the quarter of the ball from 90 to 180 degrees, in one disc.

    >>> sides, rows = np.array([[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]]), np.zeros((4, 12))
    >>> lean, arcs, ball = np.zeros((2, 2)), np.zeros((arc_room(2), 2)), Round(1e-3, 2, 200 * math.pi)
    >>> discs(sides, lean, arcs, ball, 0.02, 0.0, 0.0, 1, WORK, LEVEL, rows, 0)
    1
    >>> (1e3 * rows[0, [1, 2, 5]]).round(9).tolist(), np.degrees(rows[0, 3:5]).round(6).tolist()
    ([0.0, 2.0, 0.1], [90.0, 180.0])

    References
    ----------
    Derived here.
    """
    last = sides.shape[0] - 1
    for j in range(last):  # planes between two samples are not quite unit vectors
        size = math.sqrt(sides[j, 0] ** 2 + sides[j, 1] ** 2 + sides[j, 2] ** 2)
        for i in range(SIDE):
            sides[j, i] /= size
    sides[last, 0], sides[last, 1], sides[last, 2] = leading_side(vx, vy, vz)
    sides[last, 3] = 0.0
    radius = ball.radius
    low, high = height_limits(sides, radius)
    dz = (high - low) / slices
    if not dz > 0.0:
        return count
    theta = feed_direction(vx, vy)
    chip = feed_per_tooth(vx, vy, ball.spindle_speed, ball.flutes)
    rise = math.copysign(feed_per_tooth(vz, 0.0, ball.spindle_speed, ball.flutes), vz)
    for j in range(last + 1):
        lean[j, 0], lean[j, 1] = math.hypot(sides[j, 0], sides[j, 1]), math.atan2(sides[j, 0], sides[j, 1])
    for k in range(slices):
        z = low + (k + 0.5) * dz
        rho = math.sqrt(max(0.0, radius * radius - z * z))
        for i in range(disc_arcs(sides, lean, rho, z, arcs)):
            rows[count, 0] = layer
            rows[count, 1] = radius + z - 0.5 * dz
            rows[count, 2] = dz
            rows[count, 3] = arcs[i, 0]
            rows[count, 4] = arcs[i, 1]
            rows[count, 5] = chip
            rows[count, 6] = theta
            rows[count, 7] = rise
            rows[count, 8], rows[count, 9], rows[count, 10], rows[count, 11] = frame
            count += 1
    return count


@spatial.of(Wedge)
def _(engagement):
    return True


@probed.of(Wedge)
def _(engagement, pose):
    """The centre of the ball."""
    return 0.0, engagement.ball.radius


@met.of(Wedge)
def _(engagement, stock, pose, structure, flexed, contact):
    """What of the rise of the ball does not follow the path at its foot goes into the work or off it."""
    ball, place, frame = engagement.ball, engagement.place, engagement.frame
    tip = displaced(structure, flexed, 0.0, ball.radius)
    x, y, z = pose.x + tip.x, pose.y + tip.y, pose.z + tip.z
    j, k, share, faster = foot(place, frame, engagement.closed, x, y, stock.at[0])
    fx = frame[j, 0] + share * (frame[k, 0] - frame[j, 0])
    fy = frame[j, 1] + share * (frame[k, 1] - frame[j, 1])
    ox = frame[j, 2] + share * (frame[k, 2] - frame[j, 2])
    oy = frame[j, 3] + share * (frame[k, 3] - frame[j, 3])
    near = (x - place[j, 0]) * frame[j, 2] + (y - place[j, 1]) * frame[j, 3]
    far = (x - place[k, 0]) * frame[k, 2] + (y - place[k, 1]) * frame[k, 3]
    dy = near + share * (far - near)
    dz = z - (place[j, 2] + share * (place[k, 2] - place[j, 2]))
    ux, uy = pose.vx + tip.vx, pose.vy + tip.vy
    foot_speed = (ux * fx + uy * fy) * faster
    vx = foot_speed * (engagement.contact[j] + share * (engagement.contact[k] - engagement.contact[j]))
    vy = ux * ox + uy * oy
    vz = pose.vz + tip.vz
    speed, rise, slope = engagement.speed, engagement.rise, engagement.slope
    if speed[j] > 0.0 and speed[k] > 0.0:  # straight between samples: a jump of the force there would have no balance
        lifted = rise[j] / speed[j]
        lifted += share * (rise[k] / speed[k] - lifted)
        vz += lifted * vx - (slope[j] + share * (slope[k] - slope[j])) * foot_speed
    seen = contact.seen
    seen[0], seen[1], seen[2], seen[3] = j, share, dy, dz
    count = 0
    for part in range(2 if engagement.burr.shape[1] > 0 else 1):
        table = engagement.planes if part == WORK else engagement.burr
        sides = stock.sides if part == WORK else stock.burr
        for m in range(table.shape[1]):
            for i in range(SIDE):
                sides[m, i] = table[j, m, i] + share * (table[k, m, i] - table[j, m, i])
            sides[m, 3] -= sides[m, 1] * dy + sides[m, 2] * dz
        count = discs(
            sides, stock.lean, stock.arcs, ball, vx, vy, vz, engagement.slices, part, (fx, fy, ox, oy), contact.rows,
            count,
        )  # fmt: skip
    return count


@left.of(Wedge)
def _(engagement, stock, contact, count):
    """Planes know no stock; the ball is looked for from where it is now."""
    stock.at[0] = int(contact.seen[0])
    return 0
