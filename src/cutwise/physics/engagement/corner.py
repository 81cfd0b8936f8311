"""Immersion angle of a flat end mill along a straight wall and through an inner corner, in closed form."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled

FloatArray = npt.NDArray[np.float64]


class Corner(NamedTuple):
    """An inner corner in its own frame: along +x to the corner point of the centre path (0, 0), then left by a turn."""

    mill_radius: float  # R [m]
    radial_depth: float  # a_e, offset of the previous pass from this one [m]
    turn: float  # angle of the turn [rad], above 0 and below pi
    fillet: float  # rho, radius of the centre path [m], 0 for a sharp corner


@compiled
def straight_immersion(radial_depth: float, mill_radius: float) -> float:
    r"""Immersion angle along a straight wall.

    .. math:: \alpha_0 = \arccos(1 - a_e / R)

    Parameters
    ----------
    radial_depth : float
        :math:`a_e` [m]; not positive: no contact, 0 is returned; a full slot from :math:`2R` on.
    mill_radius : float
        :math:`R` [m].

    Returns
    -------
    float
        :math:`\alpha_0` [rad].
    """
    if radial_depth <= 0.0:
        return 0.0
    return math.acos(max(-1.0, 1.0 - radial_depth / mill_radius))


@compiled
def arc_immersion(radial_depth: float, path_radius: float, mill_radius: float) -> float:
    r"""Steady immersion angle on an inner (concave) arc of the wall.

    .. math:: \cos\alpha = \frac{r_b^2 - \rho^2 - R^2}{2 \rho R}, \qquad r_b = \rho + R - a_e

    Parameters
    ----------
    radial_depth : float
        :math:`a_e` [m], from a previous pass concentric to this one.
    path_radius : float
        Radius :math:`\rho` of the centre path [m], at least :math:`a_e`. A negative one is an outer (convex) arc.
    mill_radius : float
        :math:`R` [m].

    Returns
    -------
    float
        :math:`\alpha` [rad], 0 to pi.
    """
    if radial_depth <= 0.0:
        return 0.0
    if math.isinf(path_radius):
        return straight_immersion(radial_depth, mill_radius)
    bound = path_radius + mill_radius - radial_depth
    cosine = (bound * bound - path_radius * path_radius - mill_radius * mill_radius) / (2.0 * path_radius * mill_radius)
    return math.acos(min(max(cosine, -1.0), 1.0))


@compiled
def _ahead(angle: float) -> float:
    """The angle brought to (0, 2 pi]."""
    turned = angle % (2.0 * math.pi)
    return turned if turned > 1e-12 else 2.0 * math.pi


@compiled
def _nearer(best: float, px: float, py: float, x: float, y: float, wall: float) -> float:
    """The smaller of ``best`` and the angle of rim point (x, y), counted from the wall side of a mill at (px, py)."""
    return min(best, _ahead(math.atan2(y - py, x - px) - wall))


@compiled
def _line_crossings(best: float, px: float, py: float, wall: float, corner: Corner, b: float, second: bool) -> float:
    """Rim against the edge left by the previous pass along the first or second straight wall."""
    radius, gap = corner.mill_radius, corner.mill_radius - corner.radial_depth
    dx, dy = (math.cos(corner.turn), math.sin(corner.turn)) if second else (1.0, 0.0)
    along, off = px * dx + py * dy, -px * dy + py * dx
    reach = radius * radius - (off + gap) * (off + gap)
    if reach < 0.0:
        return best
    reach = math.sqrt(reach)
    foot = b * math.tan(0.5 * corner.turn)
    for q in (along - reach, along + reach):
        if (second and q >= foot) or (not second and q <= -foot):
            best = _nearer(best, px, py, q * dx + gap * dy, q * dy - gap * dx, wall)
    return best


@compiled
def _arc_crossings(best: float, px: float, py: float, wall: float, corner: Corner, b: float) -> float:
    """Rim against the arc left by the previous pass in the corner."""
    radius = corner.mill_radius
    cx, cy = -b * math.tan(0.5 * corner.turn), b
    bound = b - corner.radial_depth + radius
    distance = math.hypot(px - cx, py - cy)
    if distance <= 0.0 or distance > radius + bound or distance < abs(radius - bound):
        return best
    axial = (distance * distance + bound * bound - radius * radius) / (2.0 * distance)
    side = math.sqrt(max(bound * bound - axial * axial, 0.0))
    ux, uy = (px - cx) / distance, (py - cy) / distance
    for sign in (-1.0, 1.0):
        x, y = axial * ux - sign * side * uy, axial * uy + sign * side * ux
        if (math.atan2(y, x) + 0.5 * math.pi) % (2.0 * math.pi) <= corner.turn:
            best = _nearer(best, px, py, cx + x, cy + y, wall)
    return best


@compiled
def corner_immersion(px: float, py: float, heading: float, corner: Corner) -> float:
    r"""Immersion angle of a mill near an inner corner whose previous pass ran :math:`a_e` inside this one.

    The edge of the uncut stock is a line, an arc of radius :math:`r_p + R` with :math:`r_p = \max(\rho - a_e, 0)`
    about :math:`(-b \tan\tfrac{\theta}{2},\, b)`, :math:`b = a_e + r_p`, and a line. The cut runs from the wall side
    of the mill (heading - 90°) to the first crossing of the rim with that edge. For a right angle this gives

    .. math::
        \alpha_0 = \arccos(1 - a_e/R) \;\text{on the straight}, \qquad
        90° + \operatorname{atan2}(a_e, s-a_e) - \arccos\frac{\sqrt{(s-a_e)^2 + a_e^2}}{2R}, \qquad
        90° + \arccos\frac{R - a_e + s}{R}

    at distance :math:`s` before a sharp corner, and :func:`arc_immersion` on a long fillet with :math:`\rho \ge a_e`.

    Parameters
    ----------
    px, py : float
        Mill centre in the corner's frame [m].
    heading : float
        Direction of feed [rad], 0 along the first wall.
    corner : Corner
        Its shape; the fillet must fit (:math:`a_e < R`).

    Returns
    -------
    float
        :math:`\alpha` [rad], 0 to pi.

    References
    ----------
    Derived here; checked against counted rim points in tests/unit and against the removed area.
    """
    if corner.radial_depth <= 0.0:
        return 0.0
    b = max(corner.fillet, corner.radial_depth)
    wall = heading - 0.5 * math.pi
    best = 2.0 * math.pi
    best = _line_crossings(best, px, py, wall, corner, b, False)
    best = _arc_crossings(best, px, py, wall, corner, b)
    best = _line_crossings(best, px, py, wall, corner, b, True)
    if best >= 2.0 * math.pi:  # no crossing ahead: inside the edge all round
        return 0.0
    return min(best, math.pi)


@compiled
def corner_immersions(points: FloatArray, tangents: FloatArray, corner: Corner) -> FloatArray:
    """:func:`corner_immersion` along a sampled path; shapes (n, 3) in the corner's frame [m], result (n,) [rad]."""
    out = np.empty(points.shape[0])
    for k in range(points.shape[0]):
        out[k] = corner_immersion(points[k, 0], points[k, 1], math.atan2(tangents[k, 1], tangents[k, 0]), corner)
    return out


def greatest_immersion(corner: Corner) -> float:
    r"""Largest immersion angle on the way through a right-angled or other inner corner [rad].

    A sharp corner peaks at :math:`\alpha_0 + \theta` (for :math:`\theta` = 90°); on a fillet the largest angle is
    searched along the path, densely and then by golden section, to 1e-12 of a length.
    """
    tangent_length = corner.fillet * math.tan(0.5 * corner.turn)
    reach = tangent_length + 4.0 * corner.mill_radius

    def immersion(s: float) -> float:
        return float(corner_immersion(*_fillet_pose(s, corner), corner))

    arc_length = corner.fillet * corner.turn
    grid = np.unique(np.concatenate((np.linspace(-reach, -tangent_length, 400),
                                     -tangent_length + np.linspace(0.0, arc_length, 400))))  # fmt: skip
    values = [immersion(float(s)) for s in grid]
    best = int(np.argmax(values))
    low, high = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, grid.size - 1)])
    for _ in range(60):
        third = (high - low) / 3.0
        if immersion(low + third) < immersion(high - third):
            low += third
        else:
            high -= third
    return max(immersion(0.5 * (low + high)), values[best])


def _fillet_pose(s: float, corner: Corner) -> tuple[float, float, float]:
    """Centre and heading at path length ``s``, 0 at the corner point if it were sharp, up to the end of the fillet."""
    tangent_length = corner.fillet * math.tan(0.5 * corner.turn)
    if s <= -tangent_length or corner.fillet == 0.0:
        return s, 0.0, 0.0
    angle = (s + tangent_length) / corner.fillet
    return -tangent_length + corner.fillet * math.sin(angle), corner.fillet * (1.0 - math.cos(angle)), angle
