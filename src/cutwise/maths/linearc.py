"""Curves of straight lines and circular or helical arcs, by arc length."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


class LineArc(NamedTuple):
    r"""Blocks run one after the other, ``n`` of them.

    .. math:: p(s) = p_0 + r \sin\varphi\,t + r(1-\cos\varphi)\,n + s\,c, \qquad \varphi = s\,\sigma / r

    with :math:`s` counted from the block's start; a line is the limit :math:`r \to \infty`.
    """

    start: FloatArray  # p_0 [m], shape (n, 3)
    along: FloatArray  # t, unit tangent at the start within the plane of the arc, shape (n, 3)
    inward: FloatArray  # n, unit vector from the start to the centre, zero on a line, shape (n, 3)
    climb: FloatArray  # c, rise along the axis of a helix per length [-], shape (n, 3)
    share: FloatArray  # sigma, in-plane part of the length [-], 1 without rise, shape (n,)
    radius: FloatArray  # r [m], infinite on a line, shape (n,)
    length: FloatArray  # [m], shape (n,)

    @property
    def count(self) -> int:
        """Number of blocks."""
        return self.length.shape[0]

    @property
    def knots(self) -> FloatArray:
        """Arc length at the block boundaries [m], shape (n+1,)."""
        return np.concatenate(([0.0], np.cumsum(self.length)))

    @property
    def curvature(self) -> FloatArray:
        r"""Curvature of each block, :math:`\sigma^2 / r` [1/m], shape (n,)."""
        return self.share**2 / self.radius


class Block(NamedTuple):
    """One line, arc or helix."""

    start: tuple[float, float, float]
    along: tuple[float, float, float]
    inward: tuple[float, float, float]
    climb: tuple[float, float, float]
    share: float
    radius: float
    length: float


def line(start: Sequence[float], end: Sequence[float]) -> Block:
    """Straight block; raises ``ValueError`` if it has no length."""
    p, q = _triple(start), _triple(end)
    length = math.dist(p, q)
    if length <= 0.0:
        raise ValueError("a line block has no length")
    along = ((q[0] - p[0]) / length, (q[1] - p[1]) / length, (q[2] - p[2]) / length)
    return Block(p, along, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1.0, math.inf, length)


def arc(
    start: Sequence[float],
    centre: Sequence[float],
    sweep: float,
    axis: Sequence[float] = (0.0, 0.0, 1.0),
    rise: float = 0.0,
) -> Block:
    """Arc about ``axis`` (right-handed sweep [rad], may exceed a turn), or a helix with ``rise`` [m] along the axis.

    Raises ``ValueError`` if radius or sweep is zero.
    """
    p, axis_unit = np.asarray(_triple(start)), np.asarray(_triple(axis)) / math.hypot(*axis)
    to_centre = np.asarray(_triple(centre)) - p
    to_centre = to_centre - axis_unit * float(axis_unit @ to_centre)
    radius = float(np.linalg.norm(to_centre))
    if radius <= 0.0 or sweep == 0.0:
        raise ValueError("an arc block needs a radius and a sweep")
    inward = to_centre / radius
    along = math.copysign(1.0, sweep) * np.cross(inward, axis_unit)
    flat = radius * abs(sweep)
    length = math.hypot(flat, rise)
    climb = axis_unit * (rise / length)
    return Block(_triple(p), _triple(along), _triple(inward), _triple(climb), flat / length, radius, length)


def join(blocks: Sequence[Block]) -> LineArc:
    """The blocks as one curve."""
    columns = zip(*blocks, strict=True)
    return LineArc(*(np.array(column, dtype=np.float64) for column in columns))


def _triple(values: Sequence[float]) -> tuple[float, float, float]:
    x, y = float(values[0]), float(values[1])
    return x, y, float(values[2]) if len(values) > 2 else 0.0


@compiled
def block_point(curve: LineArc, i: int, s: float) -> tuple[float, float, float]:
    """Point of block ``i`` at arc length ``s`` [m] from its start; beyond its ends it goes on."""
    radius = curve.radius[i]
    if math.isinf(radius):
        a, b = s, 0.0
    else:
        phi = s * curve.share[i] / radius
        half = math.sin(0.5 * phi)
        a, b = radius * math.sin(phi), 2.0 * radius * half * half
    return (
        curve.start[i, 0] + a * curve.along[i, 0] + b * curve.inward[i, 0] + s * curve.climb[i, 0],
        curve.start[i, 1] + a * curve.along[i, 1] + b * curve.inward[i, 1] + s * curve.climb[i, 1],
        curve.start[i, 2] + a * curve.along[i, 2] + b * curve.inward[i, 2] + s * curve.climb[i, 2],
    )


@compiled
def block_tangent(curve: LineArc, i: int, s: float) -> tuple[float, float, float]:
    """Unit tangent of block ``i`` at arc length ``s`` [m] from its start."""
    share, radius = curve.share[i], curve.radius[i]
    if math.isinf(radius):
        a, b = 1.0, 0.0
    else:
        phi = s * share / radius
        a, b = share * math.cos(phi), share * math.sin(phi)
    return (
        a * curve.along[i, 0] + b * curve.inward[i, 0] + curve.climb[i, 0],
        a * curve.along[i, 1] + b * curve.inward[i, 1] + curve.climb[i, 1],
        a * curve.along[i, 2] + b * curve.inward[i, 2] + curve.climb[i, 2],
    )


@compiled
def at_blocks(curve: LineArc, block: IntArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points [m] and unit tangents at arc lengths ``s`` [m] from the starts of given blocks, shapes (len(s), 3)."""
    points, tangents = np.empty((s.shape[0], 3)), np.empty((s.shape[0], 3))
    for k in range(s.shape[0]):
        points[k, 0], points[k, 1], points[k, 2] = block_point(curve, block[k], s[k])
        tangents[k, 0], tangents[k, 1], tangents[k, 2] = block_tangent(curve, block[k], s[k])
    return points, tangents


@compiled
def sample(curve: LineArc, knots: FloatArray, s: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Points, unit tangents and block numbers at ascending arc lengths ``s`` [m].

    At a joint the block that starts there is taken; the last block is taken at the end of the curve.

    Returns
    -------
    tuple
        Points [m], shape (len(s), 3); tangents, same shape; block numbers (integers), shape (len(s),).
    """
    blocks = np.empty(s.shape[0], dtype=np.int64)
    last = curve.length.shape[0] - 1
    i = 0
    for k in range(s.shape[0]):
        while i < last and s[k] >= knots[i + 1]:
            i += 1
        blocks[k] = i
    points, tangents = at_blocks(curve, blocks, s - knots[blocks])
    return points, tangents, blocks


@compiled
def turn_angles(curve: LineArc) -> FloatArray:
    """Angle between the tangents on either side of each inner joint [rad], shape (n-1,)."""
    n = curve.length.shape[0]
    turns = np.empty(n - 1)
    for i in range(n - 1):
        ax, ay, az = block_tangent(curve, i, curve.length[i])
        bx, by, bz = block_tangent(curve, i + 1, 0.0)
        cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        turns[i] = math.atan2(math.sqrt(cx * cx + cy * cy + cz * cz), ax * bx + ay * by + az * bz)
    return turns
