"""Polylines and distances from them."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import inlined, internal
from cutwise.maths.curves import FloatArray
from cutwise.maths.surfaces import IntArray

BLOCK = 8  # segments
GROUP = 8  # blocks


class Line(NamedTuple):
    """A polyline, or several one after another, in blocks that are left out whole when they are far.

    Few arrays: a kernel pays for every one that it hands on.
    """

    node: FloatArray  # points [m], and 1 where the segment that starts at a point is none, shape (n, 4)
    ball: FloatArray  # centre and radius [m] of balls round each block of segments, then round groups; shape (b + g, 4)
    blocks: int

    @property
    def point(self) -> FloatArray:
        """Points [m], shape (n, 3)."""
        return self.node[:, :3]


def line(pieces: Sequence[FloatArray]) -> Line:
    """Polylines as one; a closed one has its first point again at its end."""
    point = np.concatenate(pieces)
    node = np.ascontiguousarray(np.column_stack([point, np.zeros(len(point))]))
    node[np.cumsum([len(p) for p in pieces])[:-1] - 1, 3] = 1.0
    if len(point) < 2:
        return Line(node, np.zeros((0, 4)), 0)
    blocks = _balls(point, BLOCK)
    return Line(node, np.concatenate([blocks, _balls(point, BLOCK * GROUP)]), len(blocks))


def _balls(point: FloatArray, size: int) -> FloatArray:
    """Centre and radius of balls round so many segments each."""
    starts = np.arange(0, len(point) - 1, size)
    ends = np.minimum(starts + size, len(point) - 1)
    low = np.minimum(np.minimum.reduceat(point[:-1], starts), point[ends])
    high = np.maximum(np.maximum.reduceat(point[:-1], starts), point[ends])
    return np.column_stack([0.5 * (low + high), 0.5 * np.linalg.norm(high - low, axis=1)])


@inlined
def far_from(ball: FloatArray, b: int, x: float, y: float, z: float, within: float) -> bool:
    """Whether a ball of a table is farther than a distance from a point.

    .. math:: |q - c| > w + r

    Parameters
    ----------
    ball : array (m, 4)
        Centres c and radii r [m].
    b : int
        Row of the ball.
    x, y, z : float
        The point q [m].
    within : float
        w [m]; a negative one is the depth at which a ball has to be reached into.

    Returns
    -------
    bool
        True: nothing in the ball is within the distance. Valid for what the ball holds; False says nothing.

    Examples
    --------
    3 m off a ball of 1 m:

    >>> ball = np.array([[0.0, 0.0, 0.0, 1.0]])
    >>> far_from(ball, 0, 3.0, 0.0, 0.0, 1.5), far_from(ball, 0, 3.0, 0.0, 0.0, 2.5)
    (True, False)
    """
    cx, cy, cz = x - ball[b, 0], y - ball[b, 1], z - ball[b, 2]
    bound = within + ball[b, 3]
    return bound < 0.0 or cx * cx + cy * cy + cz * cz > bound * bound


def thinned_line(point: FloatArray, sag: float) -> IntArray:
    """Points of a fine polyline to keep so that it moves by no more than about a sag; the ends stay.

    Chords of length :math:`\\sqrt{8 s / \\kappa}` have the sag s where the curvature is :math:`\\kappa`.
    """
    if len(point) < 4:
        return np.arange(len(point))
    step = np.diff(point, axis=0)
    length = np.linalg.norm(step, axis=1)
    along = step / np.maximum(length, 1e-300)[:, None]
    turn = np.linalg.norm(np.diff(along, axis=0), axis=1)
    kappa = turn / np.maximum(0.5 * (length[1:] + length[:-1]), 1e-300)
    density = np.sqrt(np.concatenate([kappa[:1], np.maximum(kappa[1:], kappa[:-1]), kappa[-1:]]) / (8.0 * sag))
    count = np.concatenate([[0.0], np.cumsum(density * length)])
    keep = np.searchsorted(count, np.arange(0.0, count[-1]), side="right") - 1
    return np.unique(np.concatenate([[0], np.maximum(keep, 0), [len(point) - 1]]))


@inlined
def foot_on(p: FloatArray, j: int, x: float, y: float, z: float) -> tuple[float, float]:
    r"""Squared distance of a point from segment j of points of shape (n, 3), and where its foot is on it, 0 to 1.

    .. math:: s = \min(1, \max(0, (q - a) \cdot (b - a) / |b - a|^2)), \qquad d^2 = |q - a - s (b - a)|^2

    Parameters
    ----------
    p : array (n, 3) or wider
        Points [m]; the segment runs from a, row j, to b, row j + 1.
    j : int
        Row.
    x, y, z : float
        The point q [m].

    Returns
    -------
    tuple
        :math:`d^2` [m^2] and s. Valid for a segment of no length too: its foot is its start.

    Examples
    --------
    >>> foot_on(np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), 0, 0.5, 3.0, 0.0)
    (9.0, 0.25)
    """
    ax, ay, az = p[j, 0], p[j, 1], p[j, 2]
    dx, dy, dz = p[j + 1, 0] - ax, p[j + 1, 1] - ay, p[j + 1, 2] - az
    px, py, pz = x - ax, y - ay, z - az
    length = dx * dx + dy * dy + dz * dz
    s = 0.0
    if length > 0.0:
        s = min(1.0, max(0.0, (px * dx + py * dy + pz * dz) / length))
    px, py, pz = px - s * dx, py - s * dy, pz - s * dz
    return px * px + py * py + pz * pz, s


@internal
def distance_within(line: Line, x: float, y: float, z: float, cutoff: float) -> float:
    r"""Distance of a point from a line [m]; the cutoff if it is farther.

    Parameters
    ----------
    line : Line
        Polylines with their balls, from :func:`line`.
    x, y, z : float
        The point [m].
    cutoff : float
        [m], not negative; the smaller it is, the more is left out.

    Returns
    -------
    float
        :math:`\min_j |q - f_j|` over the feet of :func:`foot_on` [m], or the cutoff.

    Notes
    -----
    Valid for chords, not for the curve that they stand for. Only other kernels call it; ``py_func`` is the same in Python.

    Examples
    --------
    >>> straight = line([np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]])])
    >>> [float(distance_within.py_func(straight, 0.5, 3.0, 0.0, cutoff)) for cutoff in (10.0, 1.0)]
    [3.0, 1.0]
    """
    best = cutoff * cutoff
    within = cutoff
    node, ball, blocks = line.node, line.ball, line.blocks
    for g in range(ball.shape[0] - blocks):
        if far_from(ball, blocks + g, x, y, z, within):
            continue
        for b in range(g * GROUP, min(g * GROUP + GROUP, blocks)):
            if far_from(ball, b, x, y, z, within):
                continue
            for j in range(b * BLOCK, min(b * BLOCK + BLOCK, node.shape[0] - 1)):
                if node[j, 3] == 0.0:
                    d, _ = foot_on(node, j, x, y, z)
                    if d < best:
                        best = d
                        within = math.sqrt(d)
    return within
