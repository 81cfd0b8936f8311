"""Immersion in pocket corners: a flat end mill with its wall on the right, the previous pass offset to its left."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.maths.linearc import Block, arc, join, line
from cutwise.physics.engagement.path_sweep import swept_path
from cutwise.physics.engagement.stock import Stock, contact_patches

FloatArray = npt.NDArray[np.float64]

_ENDLESS = Stock(np.zeros((0, 3)), 1.0, 0.0)  # a metre above the tip: only arcs are asked for
_NARROW = 1e-9  # [-] of the mill radius: an arc of the previous pass that is shorter is a point


class Corner(NamedTuple):
    """An inner (left-hand) corner of the centre path with a fillet; the corner point is the origin, the first wall +x."""

    mill_radius: float  # R [m]
    radial_depth: float  # a_e [m]
    turn: float  # theta [rad], above 0 and below pi
    fillet: float  # rho of the centre path [m]


@compiled
def straight_immersion(radial_depth: float, mill_radius: float) -> float:
    r"""Immersion angle of a straight cut.

    .. math:: \alpha_0 = \arccos(1 - a_e/R)

    Parameters
    ----------
    radial_depth, mill_radius : float
        :math:`a_e` and R [m]; not positive: no cut, beyond twice the radius: a slot.

    Returns
    -------
    float
        [rad], 0 to pi.

    Notes
    -----
    Valid for a feed per tooth that is small against the radius and a previous pass parallel to this one.

    Examples
    --------
    >>> round(math.degrees(straight_immersion(5e-3, 1e-2)), 9)
    60.0

    References
    ----------
    Altintas 2012, chapter 2; derived here.
    """
    if radial_depth <= 0.0:
        return 0.0
    return math.acos(max(1.0 - radial_depth / mill_radius, -1.0))


@compiled
def arc_immersion(radial_depth: float, path_radius: float, mill_radius: float) -> float:
    r"""Immersion angle on a long arc of the centre path.

    .. math:: \cos\alpha = \frac{(\rho + R - a_e)^2 - \rho^2 - R^2}{2 \rho R}

    Parameters
    ----------
    radial_depth, mill_radius : float
        :math:`a_e` and R [m].
    path_radius : float
        :math:`\rho` [m]; positive for a concave wall, negative for a convex one, infinite for a straight wall.

    Returns
    -------
    float
        :math:`\alpha` [rad], 0 to pi.

    Notes
    -----
    Valid for a previous pass on the concentric arc, :math:`\rho \ge a_e` or :math:`-\rho > R`, and far from the ends of the
    arc; where the circles do not meet the angle is 0 or pi.

    Examples
    --------
    A fillet of 20 mm, mill of 10 mm, 5 mm wide: arccos(0.3125), where a straight cut has 60 degrees.

    >>> round(math.degrees(arc_immersion(5e-3, 2e-2, 1e-2)), 6)
    71.790043

    References
    ----------
    Derived here.
    """
    if radial_depth <= 0.0:
        return 0.0
    if math.isinf(path_radius):
        return straight_immersion(radial_depth, mill_radius)
    bound = path_radius + mill_radius - radial_depth
    cosine = (bound * bound - path_radius * path_radius - mill_radius * mill_radius) / (2.0 * path_radius * mill_radius)
    return math.acos(min(max(cosine, -1.0), 1.0))


def corner_contact(
    own: Sequence[Block], way: FloatArray, point: FloatArray, heading: FloatArray, corner: Corner
) -> FloatArray:
    r"""Contact arcs of a mill near an inner corner whose previous pass ran :math:`a_e` inside this one.

    The previous pass went along the lines offset by :math:`a_e`, and round the corner on a radius
    :math:`\max(\rho - a_e, 0)` of its centre. What it swept is gone, and what this pass has swept until now: in an acute
    corner the mill meets stock on its left side too, in a second arc. For a right angle and :math:`a_e < R` this gives

    .. math::
        \alpha_0 = \arccos(1 - a_e/R) \;\text{on the straight}, \qquad
        90° + \operatorname{atan2}(a_e, s-a_e) - \arccos\frac{\sqrt{(s-a_e)^2 + a_e^2}}{2R}, \qquad
        90° + \arccos\frac{R - a_e + s}{R}

    at distance :math:`s` before a sharp corner, and :func:`arc_immersion` on a long fillet with :math:`\rho \ge a_e`.

    Parameters
    ----------
    own : sequence of Block
        This pass in the corner's frame [m]: a line that begins at least :func:`reach` before the corner, what rounds
        the corner, and a line.
    way : ndarray
        Arc length of the places along it [m], shape (n,).
    point : ndarray
        Mill centre there [m], shape (n, 3).
    heading : ndarray
        Direction of feed [rad], 0 along the first wall, shape (n,).
    corner : Corner
        Its shape.

    Returns
    -------
    ndarray
        Arc from, to in angles from the wall side of the mill (heading - 90°) [rad], 0 to pi; empty ones are zero.
        Shape (n, p, 2).

    Notes
    -----
    Valid for feeds per tooth small against the radius and walls longer than :func:`reach`.

    Examples
    --------
    Half a radius wide, far before a sharp right angle: 60 degrees from the wall; in the corner 60 + 90.

    >>> shape = Corner(1e-2, 5e-3, 0.5 * math.pi, 0.0)
    >>> own = [line((-0.1, 0.0), (0.0, 0.0)), line((0.0, 0.0), (0.0, 0.1))]
    >>> at = np.array([[-0.05, 0.0, 0.0], [0.0, 0.0, 0.0]])
    >>> np.degrees(summed(corner_contact(own, np.array([0.05, 0.1]), at, np.zeros(2), shape))).round(6).tolist()
    [60.0, 150.0]

    References
    ----------
    Derived here; checked against closed forms, counted rim points, and the removed area.
    """
    if corner.radial_depth <= 0.0:
        return np.zeros((way.shape[0], 1, 2))
    before = _previous_pass(corner, sum(block.length for block in own))
    lift = [line(_end(before[-1]), _end(before[-1], 2.0)), line(_end(before[-1], 2.0), (*own[0].start[:2], 2.0)),
            line((*own[0].start[:2], 2.0), own[0].start)]  # fmt: skip
    prior = sum(block.length for block in (*before, *lift))
    swept = swept_path(join([*before, *lift, *own]), corner.mill_radius)
    return contact_patches(point, heading, prior + way, swept, _ENDLESS)[..., :2]


def reach(corner: Corner) -> float:
    r"""Distance from the corner point beyond which the cut is the straight one [m].

    .. math:: 2R + (\rho + a_e + R) \tan(\theta/2)

    An upper bound, for turns below pi.

    Examples
    --------
    >>> round(1e3 * reach(Corner(1e-2, 5e-3, 0.5 * math.pi, 0.0)), 9)
    35.0

    References
    ----------
    Derived here.
    """
    across = corner.fillet + corner.radial_depth + corner.mill_radius
    return 2.0 * corner.mill_radius + across * math.tan(0.5 * corner.turn)


def _previous_pass(corner: Corner, length: float) -> list[Block]:
    """Centre path of the previous pass, each leg of a length [m] at least."""
    depth, radius = corner.radial_depth, max(corner.fillet - corner.radial_depth, 0.0)
    half = math.tan(0.5 * corner.turn)
    cos, sin = math.cos(corner.turn), math.sin(corner.turn)
    apex_x, apex_y, cut = -depth * half, depth, radius * half
    first_end = (apex_x - cut, apex_y)
    second = (apex_x + cut * cos, apex_y + cut * sin)
    legs = [
        line((first_end[0] - length, apex_y), first_end),
        line(second, (second[0] + length * cos, second[1] + length * sin)),
    ]
    if radius > _NARROW * corner.mill_radius:
        return [legs[0], arc(first_end, (first_end[0], apex_y + radius), corner.turn), legs[1]]
    return legs


def _end(block: Block, height: float = 0.0) -> tuple[float, float, float]:
    """End of a line, at a height [m]."""
    return (block.start[0] + block.length * block.along[0], block.start[1] + block.length * block.along[1], height)


def greatest_immersion(corner: Corner) -> float:
    r"""Largest immersion angle on the way through an inner corner [rad].

    A sharp right angle peaks at :math:`\alpha_0 + 90°`. The largest angle is searched along the path, densely and then
    between the neighbours of the largest, to 1e-12 of a length.

    Examples
    --------
    Half a radius wide: 60 + 90 degrees.

    >>> round(math.degrees(greatest_immersion(Corner(1e-2, 5e-3, 0.5 * math.pi, 0.0))), 6)
    150.0

    References
    ----------
    Derived here.
    """
    leg = 2.0 * reach(corner)
    half = math.tan(0.5 * corner.turn)
    cut, far = corner.fillet * half, leg + corner.fillet * half
    cos, sin = math.cos(corner.turn), math.sin(corner.turn)
    own = [line((-far, 0.0), (-cut, 0.0)), line((cut * cos, cut * sin), (far * cos, far * sin))]
    bend = corner.fillet * corner.turn
    if bend > 0.0:
        own.insert(1, arc((-cut, 0.0), (-cut, corner.fillet), corner.turn))

    def angles(s: FloatArray) -> FloatArray:
        """Immersion at arc lengths from the end of the first line, negative on it, up to the end of the bend."""
        turned = np.clip(s / bend, 0.0, 1.0) * corner.turn if bend > 0.0 else np.zeros(s.shape)
        point = np.zeros((s.shape[0], 3))
        point[:, 0] = np.minimum(s, 0.0) - cut + corner.fillet * np.sin(turned)
        point[:, 1] = corner.fillet * (1.0 - np.cos(turned))
        return summed(corner_contact(own, leg + s, point, turned, corner))

    at = np.unique(np.concatenate((np.linspace(-0.5 * leg, 0.0, 400), np.linspace(0.0, bend, 400))))
    found = angles(at)
    while True:
        best = int(np.argmax(found))
        low, high = at[max(best - 1, 0)], at[min(best + 1, at.size - 1)]
        if high - low < 1e-12 * corner.mill_radius:
            return float(found[best])
        at = np.linspace(low, high, 41)
        found = angles(at)


def summed(arcs: FloatArray) -> FloatArray:
    """Immersion angle: the sum of the contact arcs of a place [rad]; shape (n, p, 2) to (n,).

    Examples
    --------
    >>> summed(np.array([[[0.0, 1.0], [2.0, 2.5]]])).tolist()
    [1.5]
    """
    return np.asarray((arcs[..., 1] - arcs[..., 0]).sum(axis=-1))
