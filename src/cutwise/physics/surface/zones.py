"""Zones along edges in which a tool is meant to cut: what it takes off there is no gouge."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import inlined, internal
from cutwise.maths.curves import FloatArray
from cutwise.maths.lines import BLOCK, GROUP, Line, far_from, foot_on, line
from cutwise.maths.surfaces import IntArray


class Zones(NamedTuple):
    """Zones along edges."""

    line: Line  # the edges
    side: FloatArray  # of each segment, shape (n - 1, 5): radius of its zone [m]; radius of the zone on the two faces
    # of that edge, which are looked at elsewhere [m]; these two faces; 1 where it starts an open edge, 2 where it ends
    # one, 3 both
    widest: float  # [m] largest zone


class Zone(NamedTuple):
    """The zone along one edge, for :func:`zones`."""

    point: FloatArray  # [m], shape (n, 3)
    face: IntArray  # of both sides, shape (n, 2)
    closed: bool
    radius: float  # [m]
    near: float  # [m]


def zones(members: Sequence[Zone]) -> Zones:
    """Several zones as one table."""
    pieces, sides = [], []
    for e in members:
        point = np.vstack([e.point, e.point[:1]]) if e.closed else e.point
        count = len(point) - 1
        side = np.empty((count + 1, 5))  # one more for the gap to the next edge
        side[:, 0], side[:, 1], side[:, 4] = e.radius, e.near, 0.0
        side[:count, 2:4], side[count, 2:4] = e.face[:count], e.face[count - 1]
        if not e.closed:
            side[0, 4] += 1.0
            side[count - 1, 4] += 2.0
        pieces.append(point)
        sides.append(side)
    return Zones(line(pieces), np.concatenate(sides)[:-1], max(max(e.radius, e.near) for e in members))


def no_zones() -> Zones:
    """A tool that is not meant to cut anywhere."""
    return Zones(line([np.zeros((1, 3))]), np.zeros((0, 5)), 0.0)


@inlined
def _zone_of(side: FloatArray, j: int, face: int, s: float) -> float:
    """Zone of segment j for a point of a face whose foot is at s on it; beyond the end of an open edge it is less."""
    own = side[j, 2] == face or side[j, 3] == face
    end = side[j, 4]
    past = (s <= 0.0 and end % 2.0 == 1.0) or (s >= 1.0 and end >= 2.0)
    return side[j, 1] if own and not past else side[j, 0]


@internal
def outside_zones(table: Zones, face: int, x: float, y: float, z: float, reach: float) -> float:
    r"""How far a point of a face lies outside of all zones [m], exact while that is less than ``reach``.

    .. math:: \min\bigl(reach,\ \min_j (d_j - r_j)\bigr), \qquad r_j \text{ the near zone on the two faces of edge j}

    Parameters
    ----------
    table : Zones
        Edges and the radii round them.
    face : int
        Of the point.
    x, y, z : float
        Point [m].
    reach : float
        [m]

    Returns
    -------
    float
        Negative within a zone.

    Examples
    --------
    3 mm off an edge whose zone is 1 mm wide, 0.5 mm on its own faces:

    >>> table = zones([Zone(np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0]]), np.array([[0, 1]]), False, 1e-3, 5e-4)])
    >>> [round(1e3 * outside_zones.py_func(table, face, 5e-3, 3e-3, 0.0, 1.0), 9) for face in (7, 1)]
    [2.0, 2.5]

    References
    ----------
    Derived here.
    """
    least = reach
    node, ball, blocks = table.line.node, table.line.ball, table.line.blocks
    for g in range(ball.shape[0] - blocks):
        if far_from(ball, blocks + g, x, y, z, least + table.widest):
            continue
        for b in range(g * GROUP, min(g * GROUP + GROUP, blocks)):
            if far_from(ball, b, x, y, z, least + table.widest):
                continue
            for j in range(b * BLOCK, min(b * BLOCK + BLOCK, node.shape[0] - 1)):
                if node[j, 3] == 0.0:
                    square, s = foot_on(node, j, x, y, z)
                    least = min(least, math.sqrt(square) - _zone_of(table.side, j, face, s))
    return least
