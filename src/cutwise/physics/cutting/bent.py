r"""Walls that a bent mill leaves: the force of the cut holds its tip off while the discs of a tooth pass the wall.

What cuts less pushes less: an arc of contact ends where the tool really stands. So the bend u and the place x of the tool
have to agree, :math:`x = \delta + u(x)`, with what the tool is led beside its path :math:`\delta`.
"""

import math

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.feed_limits import Teeth, wall_terms
from cutwise.physics.cutting.wall import AVERAGED, FLUTES, wall_force

_OWN = 1e-6  # [rad] from the wall sides: an arc that ends nearer ends at the wall that the tool leaves itself
_LEAST = 1e-12  # [m] of bend whose change tells nothing
_STEEPEST = 0.9  # change of a bend with itself that still has a balance


@compiled
def moved_arcs(patches: FloatArray, shift: float, radius: float, out: FloatArray) -> None:
    r"""Contact arcs of a mill that stands beside its path.

    .. math:: \cos\varphi' = \cos\varphi - x / R

    Parameters
    ----------
    patches : array (p, 4)
        Arcs from, to, in angles from the right side of the feed [rad], and heights [m].
    shift : float
        How far the mill stands to the right of its path, x [m].
    radius : float
        R [m].
    out : array (p, 4)
        Filled with the patches of the mill there.

    Notes
    -----
    Valid where the surfaces that the arcs end at run along the feed: exact for a straight wall behind a parallel pass, and
    to the first order of :math:`a_e/\rho` on arcs of radius :math:`\rho`. Ends at 0 and 180 degrees are at walls that the mill
    leaves itself: they go with it.

    Examples
    --------
    A quarter of the diameter deep is 60 degrees; moved out of the cut by a tenth of the radius it is 53.13 degrees.

    >>> out = np.zeros((1, 4))
    >>> moved_arcs(np.array([[0.0, math.pi / 3, 0.0, 1e-3]]), -1e-3, 1e-2, out)
    >>> round(math.degrees(out[0, 1]), 2)
    53.13

    References
    ----------
    Derived here.
    """
    for p in range(patches.shape[0]):
        for k in range(4):
            out[p, k] = patches[p, k]
        if patches[p, 1] <= patches[p, 0]:
            continue
        for k in range(2):
            if _OWN < patches[p, k] < math.pi - _OWN:
                out[p, k] = math.acos(min(1.0, max(-1.0, math.cos(patches[p, k]) - shift / radius)))


@compiled
def _bend(
    patches: FloatArray, left: bool, heading: float, feed: float, compliance: FloatArray, teeth: Teeth, averaged: bool,
    terms: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Least and greatest displacement to the right of the feed while a wall is left [m]; NaN where none is there."""
    least, most = math.nan, math.nan
    if not averaged:
        normal = heading + (0.5 * math.pi if left else -0.5 * math.pi)
        for e in range(wall_terms(FLUTES, patches, left, normal, compliance, teeth, terms)):
            into = terms[e, 0] + feed * terms[e, 1]
            right = -into if left else into
            least = right if math.isnan(least) else min(least, right)
            most = right if math.isnan(most) else max(most, right)
        return least, most
    x, y, there, c, s = 0.0, 0.0, False, math.cos(heading), math.sin(heading)
    for p in range(patches.shape[0]):
        low, high, bottom, top = patches[p, 0], patches[p, 1], patches[p, 2], patches[p, 3]
        if high <= low:
            continue
        there = there or (high > math.pi - _OWN if left else low < _OWN)
        arc = (low, high, bottom, top)
        ex, ey, _ = wall_force(AVERAGED, 0.0, heading, *arc, c, s, teeth.mill, teeth.discs, teeth.edge)
        sx, sy, _ = wall_force(AVERAGED, 0.0, heading, *arc, c, s, teeth.mill, teeth.discs, teeth.shear)
        x, y = x + ex + feed * sx, y + ey + feed * sy
    if there:
        ux, uy = compliance[0, 0] * x + compliance[0, 1] * y, compliance[1, 0] * x + compliance[1, 1] * y
        least = most = ux * s - uy * c
    return least, most


@compiled
def bent_walls(
    patches: FloatArray, walls: FloatArray, heading: FloatArray, feed: FloatArray, shift: FloatArray, teeth: Teeth,
    compliance: FloatArray, averaged: bool,
) -> FloatArray:  # fmt: skip
    r"""How far a bent mill is pushed to the right of its feed while it leaves its walls, place by place [m].

    .. math:: x = \delta + u(x), \qquad u(x) = n^T C F(\varphi'(x)), \qquad
              \frac{d x}{d \delta} = \frac{1}{1 + k_c/k}, \quad k_c = \frac{\partial F_n}{\partial a_e}

    The arc follows the tool: of :math:`u_0 = u(\delta)` and :math:`u_1 = u(\delta + u_0)` one secant makes
    :math:`u = u_0 / (1 - (u_1 - u_0) / u_0)`. F is the force of the rest of the edge while a height of it passes the wall, or
    the mean over a turn.

    Parameters
    ----------
    patches : array (n, p, 4)
        Contact on the wanted path: arcs from the right side of the feed [rad] and heights [m].
    walls : array (n, 2)
        1 where the wall on the right, and on the left, is looked at.
    heading : array (n,)
        Direction of feed in the axes of the compliance [rad].
    feed : array (n,)
        Feed per tooth [m].
    shift : array (n,)
        How far the tool is led to the right of the wanted path, :math:`\delta` [m].
    teeth : Teeth
        Mill and material.
    compliance : array (2, 2)
        C of the tip [m/N].
    averaged : bool
        Under the mean force, the same at all heights.

    Returns
    -------
    array (n, 2, 2)
        Of the wall on the right, and on the left: u over its height, least and greatest; NaN where none is left.

    Notes
    -----
    Valid at rest, for linear edges without run-out, and shifts small against the radial depth. Of a wall whose heights are
    pushed differently the arc follows the middle between least and greatest.

    Examples
    --------
    Two straight flutes in half of their diameter, 1 mm deep, tangential edge forces of 50 N/mm alone, the mean over a turn:
    N K b / (2 pi) = 15.915 N push the mill off the wall; at 1 N/µm the arc becomes shorter by as much, and pushes less.

    >>> from cutwise.physics.cutting.discs import discs
    >>> from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
    >>> from cutwise.physics.cutting.uneven import NO_LINEAR, even_edges
    >>> edge = even_edges(EdgeCoefficients(0.0, 0.0, 0.0, 5e4, 0.0, 0.0))
    >>> teeth = Teeth(FLUTES, Mill(5e-3, 2, 0.0), discs(5e-3, 0.0, 1e-3, 2, 1), even_edges(NO_LINEAR), edge)
    >>> half, one = np.array([[[0.0, 0.5 * math.pi, 0.0, 1e-3]]]), np.zeros(1)
    >>> found = bent_walls(half, np.array([[1.0, 0.0]]), one, one, one, teeth, np.eye(2) / 1e6, True)
    >>> (1e6 * found[0, 0]).round(3).tolist(), bool(np.isnan(found[0, 1]).all())
    ([-15.865, -15.865], True)

    References
    ----------
    Derived here; surface left by a helical mill as in Altintas 2012, sec. 2.7.
    """
    out = np.full((patches.shape[0], 2, 2), math.nan)
    moved, terms = np.empty(patches.shape[1:]), np.empty((teeth.discs.count, 2))
    for k in range(patches.shape[0]):
        for side in range(2):
            if walls[k, side] <= 0.0:
                continue
            left, place = side == 1, shift[k]
            first = 0.0
            for turn in range(3):
                moved_arcs(patches[k], place, teeth.mill.radius, moved)
                low, high = _bend(moved, left, heading[k], feed[k], compliance, teeth, averaged, terms)
                if math.isnan(low):
                    break
                middle = 0.5 * (low + high)
                if turn == 0:
                    first, place = middle, shift[k] + middle
                elif turn == 1:
                    slope = (middle - first) / first if abs(first) > _LEAST else 0.0
                    place = shift[k] + first / (1.0 - min(slope, _STEEPEST))
            out[k, side, 0], out[k, side, 1] = low, high
    return out
