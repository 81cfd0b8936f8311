r"""Immersion of a ball in the wedge of material along an edge, and in a burr on it, by axial discs.

Local frame of the pass: x along the feed across the rod, z along the rod toward the motor, y off the work; down
milling. Material is a prism along the direction of the edge, bounded by planes: :math:`n_j \cdot p \le d_j` from the
ball centre. Where the edge rises or falls along the rod, those planes lean along the feed too, so that no section across
the feed stands for them. A disc at the height z of the ball has the radius :math:`\rho = \sqrt{R_B^2 - z^2}`, a tooth
on it at the immersion angle :math:`\phi` from +y stands at :math:`(\rho \sin\phi, \rho \cos\phi, z)`; a plane keeps
it from cutting on the arc

.. math:: |\phi - \operatorname{atan2}(n_x, n_y)| < \arccos\frac{d - n_z z}{\rho \sqrt{n_x^2 + n_y^2}}.

Chips are cut on the leading side only, :math:`v \cdot p \ge 0`: the velocity of the ball is one more plane.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray

SIDE = 4  # numbers of a plane: outward unit normal x, y, z, and distance from the ball centre [m]
NOWHERE = 1.0  # [m] by which a plane that leaves nothing stands off


class PassFrames(NamedTuple):
    """Local frames along a path."""

    feed: FloatArray  # x: unit, along the edge at right angles to the rod, shape (n, 3)
    off: FloatArray  # y = z cross x: from the work to the tool in down milling, shape (n, 3)
    plunge: FloatArray  # component of the edge tangent along the rod, shape (n,)


def pass_frames(tangent: FloatArray, axis: FloatArray) -> PassFrames:
    r"""Frames of a pass from edge tangents and the rod direction k: :math:`x = t - (t \cdot k) k`, normalised.

    Where the edge runs along the rod there is no feed across it (:math:`|t \cdot k| = 1`, a plunge): x is then that of
    the nearest place that has one, or any direction across the rod if there is none.

    ``tangent``: unit, shape (n, 3); ``axis``: k, unit, shape (3,).

    Examples
    --------
    >>> frames = pass_frames(np.array([[0.6, 0.0, 0.8]]), np.array([0.0, 0.0, 1.0]))
    >>> frames.feed.round(9).tolist(), frames.off.round(9).tolist(), frames.plunge.round(9).tolist()
    ([[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]], [0.8])

    References
    ----------
    Derived here; the tangent is Sato et al. 2016, Eq. (6).
    """
    plunge = tangent @ axis
    x = tangent - plunge[:, None] * axis
    length = np.linalg.norm(x, axis=1)
    known = np.flatnonzero(length > 1e-6)
    if not known.size:
        x = np.tile(np.eye(3)[int(np.argmin(np.abs(axis)))], (len(tangent), 1))
        x -= (x @ axis)[:, None] * axis
    elif known.size < len(x):
        place = np.arange(len(x))
        after = np.clip(np.searchsorted(known, place), 0, known.size - 1)
        before = np.maximum(after - 1, 0)
        nearer = np.abs(known[after] - place) <= np.abs(known[before] - place)
        x = x[np.where(nearer, known[after], known[before])]
    x = x / np.linalg.norm(x, axis=1, keepdims=True)
    return PassFrames(x, np.cross(axis, x), plunge)


def wedge_sides(edge: FloatArray, normal: FloatArray) -> FloatArray:
    """Planes of the wedge between two faces, shape (n, 2, 4).

    Parameters
    ----------
    edge : array
        Edge from the ball centre [m], frame of the pass, shape (n, 3).
    normal : array
        Outward unit normals of both faces, frame of the pass, shape (n, 2, 3).

    Notes
    -----
    Valid for faces that are plane over the radius of the ball.

    Examples
    --------
    An edge 1 mm off a ball's centre along y, one face square to it and one to z:

    >>> wedge_sides(np.array([[0.0, 1e-3, 0.0]]), np.array([[[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]]))[0].tolist()
    [[0.0, 1.0, 0.0, 0.001], [0.0, 0.0, 1.0, 0.0]]

    References
    ----------
    Derived here.
    """
    return np.concatenate([normal, np.einsum("imj,ij->im", normal, edge)[:, :, None]], axis=2)


def burr_sides(
    edge: FloatArray, into: FloatArray, normal: FloatArray, height: FloatArray, width: FloatArray
) -> FloatArray:
    """Planes of a burr, a strip of rectangular section on one face from the edge on, shape (n, 4, 4).

    Parameters
    ----------
    edge : array
        Edge from the ball centre [m], frame of the pass, shape (n, 3).
    into, normal : array
        Unit vectors along the face, away from the edge, and out of it; both across the edge, shape (n, 3).
    height, width : array
        Off the face and along it [m], shape (n,); not positive: no burr there.

    Notes
    -----
    Valid for a face that is plane, and a burr that is even, over the radius of the ball.

    Examples
    --------
    A burr of 1 by 2 mm on a face along x, seen from a ball centre on its edge: between x = 0 and 2, z = 0 and 1 mm.

    >>> x, z = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    >>> (1e3 * burr_sides(np.zeros((1, 3)), x, z, np.array([1e-3]), np.array([2e-3]))[0, [1, 3], 3]).tolist()
    [2.0, 1.0]

    References
    ----------
    Derived here; the section is that of Berselli et al. 2016, Fig. 9.
    """
    along, off = np.einsum("ij,ij->i", into, edge), np.einsum("ij,ij->i", normal, edge)
    there = (height > 0.0) & (width > 0.0)
    beyond = np.where(there, off + height, -NOWHERE)
    planes = [(-into, -along), (into, along + width), (-normal, -off), (normal, beyond)]
    return np.stack([np.column_stack(plane) for plane in planes], axis=1)


@compiled
def leading_side(speed_x: float, speed_y: float, speed_z: float) -> tuple[float, float, float]:
    """Outward normal of the plane through the ball centre ahead of which chips are cut; along x at rest.

    .. math:: n = -v / |v|

    Parameters
    ----------
    speed_x, speed_y, speed_z : float
        Velocity :math:`v` of the ball in the frame of the pass, in one unit.

    Returns
    -------
    tuple
        Unit vector x, y, z.

    Notes
    -----
    Valid for a ball that goes straight on over its own radius.

    Examples
    --------
    >>> [round(n, 6) for n in leading_side(2.0, 1.0, 2.0)]
    [-0.666667, -0.333333, -0.666667]

    References
    ----------
    Derived here: the chip of Berselli et al. 2016, Eq. (9), is positive on that side.
    """
    speed = math.sqrt(speed_x * speed_x + speed_y * speed_y + speed_z * speed_z)
    if speed == 0.0:
        return -1.0, 0.0, 0.0
    return -speed_x / speed, -speed_y / speed, -speed_z / speed


@compiled
def leans(sides: FloatArray) -> FloatArray:
    r"""Of each plane :math:`\sqrt{n_x^2 + n_y^2}` and :math:`\operatorname{atan2}(n_x, n_y)`, shape (m, 2).

    ``sides``: planes, outward unit normal and distance from the ball centre [m], shape (m, 4). The first is the sine of the
    angle between the normal and the rod, the second the immersion angle [rad] at which it points off.

    Valid for any unit normal; a plane across the rod leans nowhere, and its angle is 0.

    Examples
    --------
    >>> leans(np.array([[0.6, 0.8, 0.0, 0.0]])).round(6).tolist()  # arctan(3/4)
    [[1.0, 0.643501]]

    References
    ----------
    Derived here.
    """
    found = np.empty((sides.shape[0], 2))
    for j in range(sides.shape[0]):
        found[j, 0], found[j, 1] = math.hypot(sides[j, 0], sides[j, 1]), math.atan2(sides[j, 0], sides[j, 1])
    return found


@compiled
def arc_room(planes: int) -> int:
    """Rows that the arcs of a disc inside of planes may take, of which half is scratch: each plane adds one arc at most.

    Valid for planes: a curved face could part an arc more than once.

    Examples
    --------
    >>> arc_room(3)
    10

    References
    ----------
    Derived here.
    """
    return 2 * (planes + 2)


@compiled
def disc_arcs(sides: FloatArray, lean: FloatArray, rho: float, z: float, arcs: FloatArray) -> int:
    r"""Arcs of a disc inside of all planes, written to ``arcs`` as rows (lo, hi) [rad]; how many there are.

    .. math:: |\phi - \operatorname{atan2}(n_x, n_y)| > \arccos\frac{d - n_z z}{\rho \sqrt{n_x^2 + n_y^2}}

    Parameters
    ----------
    sides : array (m, 4)
        Planes: outward unit normal :math:`n` and distance :math:`d` from the ball centre [m].
    lean : array (m, 2)
        Their :func:`leans`.
    rho, z : float
        Radius of the disc and its height above the ball centre [m].
    arcs : array
        Filled, :func:`arc_room` rows: a plane takes one arc of the circle away and leaves one piece more at most.

    Returns
    -------
    int
        Number of arcs, within 0 and a turn, rising; an arc through the angle 0 is two.

    Notes
    -----
    Valid for a convex body; a disc stands for the ball between its faces.

    Examples
    --------
    Material at y < 0: the lower half of the circle.

    >>> sides, arcs = np.array([[0.0, 1.0, 0.0, 0.0]]), np.zeros((6, 2))
    >>> disc_arcs(sides, leans(sides), 1e-3, 0.0, arcs), np.degrees(arcs[0]).round(6).tolist()
    (1, [90.0, 270.0])

    References
    ----------
    Derived here.
    """
    half_room = arcs.shape[0] // 2
    turn = 2.0 * math.pi
    arcs[0, 0], arcs[0, 1] = 0.0, turn
    count = 1
    for j in range(sides.shape[0]):
        room = sides[j, 3] - sides[j, 2] * z
        most = rho * lean[j, 0]
        if room >= most:
            continue
        if room <= -most:
            return 0
        half = math.acos(room / most)
        start = (lean[j, 1] + half) % turn
        end = start + turn - 2.0 * half
        kept = 0
        for i in range(count):
            arcs[half_room + i, 0], arcs[half_room + i, 1] = arcs[i, 0], arcs[i, 1]
        for i in range(half_room, half_room + count):
            for turns in range(2):
                lo, hi = max(arcs[i, 0], start - turns * turn), min(arcs[i, 1], end - turns * turn)
                if hi > lo:
                    arcs[kept, 0], arcs[kept, 1] = lo, hi
                    kept += 1
        count = kept
        if count == 0:
            return 0
    return count


@compiled
def _inside(sides: FloatArray, x: float, y: float, z: float, slack: float, i: int, j: int) -> bool:
    """Whether a point is inside of all planes but those two on which it lies."""
    for m in range(sides.shape[0]):
        beyond = sides[m, 0] * x + sides[m, 1] * y + sides[m, 2] * z - sides[m, 3]
        if m != i and m != j and beyond > slack:
            return False
    return True


@compiled
def height_limits(sides: FloatArray, ball_radius: float) -> tuple[float, float]:
    r"""Heights between which the surface of a ball lies inside of all planes [m]; (0, 0) if it does not.

    The highest and the lowest place is a pole, the summit of the circle in which a plane cuts the ball, or a point of
    two such circles.

    Parameters
    ----------
    sides : array (m, 4)
        Planes: outward unit normal and distance from the ball centre [m].
    ball_radius : float
        [m]

    Returns
    -------
    tuple
        Lowest and highest, from the ball centre along the rod [m].

    Notes
    -----
    Valid for a convex body.

    Examples
    --------
    Material below a plane through the centre that falls off at 45 degrees: from the pole to :math:`R_B / \sqrt{2}`.

    >>> plane = np.array([[0.0, math.sqrt(0.5), math.sqrt(0.5), 0.0]])
    >>> [round(1e3 * z, 6) for z in height_limits(plane, 1e-3)]
    [-1.0, 0.707107]

    A plane face square to the rod, into which the ball is pressed by half its radius:

    >>> [round(1e3 * z, 6) for z in height_limits(np.array([[0.0, 0.0, 1.0, -5e-4]]), 1e-3)]
    [-1.0, -0.5]

    References
    ----------
    Derived here.
    """
    low, high = math.inf, -math.inf
    square, slack = ball_radius * ball_radius, 1e-9 * ball_radius
    for pole in (-ball_radius, ball_radius):
        if _inside(sides, 0.0, 0.0, pole, slack, -1, -1):
            low, high = min(low, pole), max(high, pole)
    for i in range(sides.shape[0]):
        ax, ay, az, a = sides[i, 0], sides[i, 1], sides[i, 2], sides[i, 3]
        level = math.hypot(ax, ay)
        if abs(a) < ball_radius and level > 0.0:
            circle = math.sqrt(square - a * a)
            for sign in (-1.0, 1.0):
                x, y = a * ax - sign * circle * az * ax / level, a * ay - sign * circle * az * ay / level
                z = a * az + sign * circle * level
                if _inside(sides, x, y, z, slack, i, i):
                    low, high = min(low, z), max(high, z)
        elif abs(a) < ball_radius:  # square to the rod: one height all round, where no other plane crosses the circle
            z = a * az
            if _inside(sides, math.sqrt(square - a * a), 0.0, z, slack, i, i):
                low, high = min(low, z), max(high, z)
        for j in range(i):
            bx, by, bz, b = sides[j, 0], sides[j, 1], sides[j, 2], sides[j, 3]
            cosine = ax * bx + ay * by + az * bz
            spread = 1.0 - cosine * cosine
            if spread < 1e-12:
                continue
            p, q = (a - cosine * b) / spread, (b - cosine * a) / spread
            mx, my, mz = p * ax + q * bx, p * ay + q * by, p * az + q * bz
            left = (square - mx * mx - my * my - mz * mz) / spread
            if left < 0.0:
                continue
            way = math.sqrt(left)
            ux, uy, uz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            for sign in (-way, way):
                x, y, z = mx + sign * ux, my + sign * uy, mz + sign * uz
                if _inside(sides, x, y, z, slack, i, j):
                    low, high = min(low, z), max(high, z)
    return (low, high) if high > low else (0.0, 0.0)
