"""Curves of straight lines, circular or helical arcs and clothoids, by arc length."""

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

    with :math:`s` counted from the block's start; a line is the limit :math:`r \to \infty`. On a clothoid the curvature
    changes with the length, :math:`\varphi = s / r + \kappa' s^2 / 2`,
    :math:`p(s) = p_0 + t \int \cos\varphi\,ds + n \int \sin\varphi\,ds`.
    """

    start: FloatArray  # p_0 [m], shape (n, 3)
    along: FloatArray  # t, unit tangent at the start within the plane of the arc, shape (n, 3)
    inward: FloatArray  # n, unit vector from the start to the centre, zero on a line, shape (n, 3)
    climb: FloatArray  # c, rise along the axis of a helix per length [-], shape (n, 3)
    share: FloatArray  # sigma, in-plane part of the length [-], 1 without rise, shape (n,)
    radius: FloatArray  # r at the start [m], infinite on a line, shape (n,)
    length: FloatArray  # [m], shape (n,)
    sharpness: FloatArray  # kappa', change of curvature per length [1/m^2], 0 but on clothoids, shape (n,)

    @property
    def count(self) -> int:  # type: ignore[override]
        """Number of blocks."""
        return self.length.shape[0]

    @property
    def knots(self) -> FloatArray:
        """Arc length at the block boundaries [m], shape (n+1,)."""
        return np.concatenate(([0.0], np.cumsum(self.length)))

    @property
    def straight(self) -> npt.NDArray[np.bool_]:
        """Which blocks are lines, shape (n,)."""
        return np.isinf(self.radius) & (self.sharpness == 0.0)

    @property
    def curvature(self) -> FloatArray:
        r"""Largest curvature of each block, :math:`\sigma^2 / r` [1/m], shape (n,)."""
        start = self.share**2 / self.radius
        return np.maximum(start, start + self.sharpness * self.length)


class Block(NamedTuple):
    """One line, arc or helix."""

    start: tuple[float, float, float]
    along: tuple[float, float, float]
    inward: tuple[float, float, float]
    climb: tuple[float, float, float]
    share: float
    radius: float
    length: float
    sharpness: float = 0.0

    @property
    def straight(self) -> bool:
        """Whether it is a line."""
        return math.isinf(self.radius) and self.sharpness == 0.0


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
    one = arcs(  # type: ignore[call-arg]
        *(np.array([_triple(v)]) for v in (start, centre)),
        np.array([sweep]),
        np.array([_triple(axis)]),
        np.array([rise]),
    )
    return block_at(one, 0)


def arcs(start: FloatArray, centre: FloatArray, sweep: FloatArray, axis: FloatArray, rise: FloatArray) -> LineArc:
    """Arcs and helices as :func:`arc` makes them, one a row: vectors of shape (n, 3), numbers of shape (n,)."""
    unit = axis / np.linalg.norm(axis, axis=1)[:, None]
    to_centre = centre - start
    to_centre = to_centre - unit * np.einsum("ij,ij->i", unit, to_centre)[:, None]
    radius = np.linalg.norm(to_centre, axis=1)
    if not ((radius > 0.0) & (sweep != 0.0)).all():
        raise ValueError("an arc block needs a radius and a sweep")
    inward = to_centre / radius[:, None]
    along = np.copysign(1.0, sweep)[:, None] * np.cross(inward, unit)
    flat = radius * np.abs(sweep)
    length = np.hypot(flat, rise)
    return LineArc(
        start, along, inward, unit * (rise / length)[:, None], flat / length, radius, length, np.zeros(len(sweep))
    )


def lines(start: FloatArray, end: FloatArray) -> LineArc:
    """Straight blocks between points, one a row of shape (n, 3); raises ``ValueError`` if one has no length."""
    along = end - start
    length = np.linalg.norm(along, axis=1)
    if not (length > 0.0).all():
        raise ValueError("a line block has no length")
    along /= length[:, None]
    n = len(length)
    return LineArc(
        start, along, np.zeros((n, 3)), np.zeros((n, 3)), np.ones(n), np.full(n, math.inf), length, np.zeros(n)
    )


def clothoid(
    start: Sequence[float], along: Sequence[float], inward: Sequence[float], length: float, first: float, last: float
) -> Block:
    """Plane curve whose curvature goes evenly from ``first`` to ``last`` [1/m] towards ``inward`` over a length [m].

    ``along`` and ``inward`` are unit vectors at right angles. Raises ``ValueError`` if the length is not positive.
    """
    if length <= 0.0:
        raise ValueError("a clothoid needs a length")
    radius = 1.0 / first if first else math.inf
    return Block(
        _triple(start), _triple(along), _triple(inward), (0.0, 0.0, 0.0), 1.0, radius, length, (last - first) / length
    )


def join(blocks: Sequence[Block]) -> LineArc:
    """The blocks as one curve."""
    columns = zip(*blocks, strict=True)
    return LineArc(*(np.array(column, dtype=np.float64) for column in columns))


def block_at(curve: LineArc, i: int) -> Block:
    """Block ``i`` of a curve by itself; the reverse of :func:`join`."""
    vectors = (_triple(column[i]) for column in curve[:4])
    return Block(*vectors, *(float(column[i]) for column in curve[4:]))  # type: ignore[arg-type]


def carried(curve: LineArc, turn: FloatArray, shift: FloatArray) -> LineArc:
    """The curve turned (or mirrored) by an orthogonal matrix (3, 3), then shifted [m]."""
    vectors = (column @ turn.T for column in curve[1:4])
    return LineArc(curve.start @ turn.T + shift, *vectors, *curve[4:])  # type: ignore[call-arg]


def extremes(curve: LineArc, i: int, direction: FloatArray) -> FloatArray:
    r"""Arc lengths inside an arc or helix at which the curve runs farthest along a direction, either way [m].

    There :math:`(\sigma t \cos\varphi + \sigma n \sin\varphi + c) \cdot d = 0`. Lines and clothoids have none.
    """
    if math.isinf(curve.radius[i]) or curve.sharpness[i] != 0.0:
        return np.zeros(0)
    a, b = (curve.share[i] * float(column[i] @ direction) for column in (curve.along, curve.inward))
    rise, size = float(curve.climb[i] @ direction), math.hypot(a, b)
    if size <= abs(rise):
        return np.zeros(0)
    whole = block_turn(curve, i, curve.length[i])
    first = math.atan2(b, a) + math.acos(-rise / size) * np.array([-1.0, 1.0])
    turns = np.arange(math.ceil(whole / (2.0 * math.pi)) + 1)
    phi = (first % (2.0 * math.pi) + 2.0 * math.pi * turns[:, None]).ravel()
    return np.sort(phi[phi < whole]) * curve.length[i] / whole


def _triple(values: Sequence[float]) -> tuple[float, float, float]:
    x, y = float(values[0]), float(values[1])
    return x, y, float(values[2]) if len(values) > 2 else 0.0


_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)  # exact to rounding up to half a turn


@compiled
def clothoid_point(curvature: float, sharpness: float, s: float) -> tuple[float, float]:
    r"""Along and across at length s of a clothoid, :math:`\int_0^s (\cos, \sin)(\kappa u + \kappa' u^2/2)\,du` [m].

    Parameters
    ----------
    curvature : float
        :math:`\kappa` at the start [1/m].
    sharpness : float
        :math:`\kappa'` [1/m^2].
    s : float
        Length [m].

    Returns
    -------
    tuple
        Along the tangent at the start and across it [m].

    Notes
    -----
    Valid to rounding while the tangent turns by no more than half a turn: 12 nodes of Gauss.

    Examples
    --------
    Without sharpness a quarter of a circle of 1 m:

    >>> [round(part, 9) for part in clothoid_point(1.0, 0.0, 0.5 * math.pi)]
    [1.0, 1.0]

    References
    ----------
    Fresnel integrals, Abramowitz and Stegun 1964, Eqs. 7.3.1 and 7.3.2, taken by quadrature.
    """
    a, b = 0.0, 0.0
    for i in range(_NODES.shape[0]):
        u = 0.5 * s * (1.0 + _NODES[i])
        phi = u * (curvature + 0.5 * sharpness * u)
        a += _WEIGHTS[i] * math.cos(phi)
        b += _WEIGHTS[i] * math.sin(phi)
    return 0.5 * s * a, 0.5 * s * b


@compiled
def block_point(curve: LineArc, i: int, s: float) -> tuple[float, float, float]:
    r"""Point of block ``i`` at arc length ``s`` [m] from its start; beyond its ends it goes on.

    .. math:: p(s) = p_0 + r \sin\varphi\,t + r(1-\cos\varphi)\,n + s\,c, \qquad \varphi = s\,\sigma / r

    and by :func:`clothoid_point` on a clothoid.

    Parameters
    ----------
    curve : LineArc
        The blocks.
    i : int
        Which.
    s : float
        Arc length [m].

    Returns
    -------
    tuple
        x, y, z [m]. Valid for any s; :math:`1 - \cos\varphi` keeps its digits on flat arcs.

    Examples
    --------
    A quarter of a circle of 1 m:

    >>> [round(part, 9) for part in block_point(join([arc((0, 0), (0, 1), 0.5 * math.pi)]), 0, 0.5 * math.pi)]
    [1.0, 1.0, 0.0]

    References
    ----------
    Derived here.
    """
    radius, sharpness = curve.radius[i], curve.sharpness[i]
    if sharpness != 0.0:
        a, b = clothoid_point(1.0 / radius, sharpness, s)
    elif math.isinf(radius):
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
def block_turn(curve: LineArc, i: int, s: float) -> float:
    r"""Angle that the tangent of block ``i`` has turned by at arc length ``s`` [m] from its start [rad].

    .. math:: \varphi = s\,\sigma / r + \kappa' s^2 / 2

    Parameters
    ----------
    curve : LineArc
        The blocks.
    i : int
        Which.
    s : float
        Arc length [m].

    Returns
    -------
    float
        Angle [rad], in the plane of the arc: on a helix that of its projection. Valid for any s.

    Examples
    --------
    1 m of an arc of 2 m:

    >>> round(block_turn(join([arc((0, 0), (0, 2), 3.0)]), 0, 1.0), 9)
    0.5

    References
    ----------
    Derived here.
    """
    return s * (curve.share[i] / curve.radius[i] + 0.5 * curve.sharpness[i] * s)


@compiled
def block_tangent(curve: LineArc, i: int, s: float) -> tuple[float, float, float]:
    r"""Unit tangent of block ``i`` at arc length ``s`` [m] from its start.

    .. math:: p'(s) = \sigma (\cos\varphi\,t + \sin\varphi\,n) + c

    Parameters
    ----------
    curve : LineArc
        The blocks.
    i : int
        Which.
    s : float
        Arc length [m].

    Returns
    -------
    tuple
        x, y, z of the unit vector [1]. Valid for any s.

    Examples
    --------
    >>> [round(part, 9) for part in block_tangent(join([arc((0, 0), (0, 1), 3.0)]), 0, 0.5 * math.pi)]
    [0.0, 1.0, 0.0]

    References
    ----------
    Derived here: the derivative of :func:`block_point`.
    """
    phi = block_turn(curve, i, s)
    a, b = curve.share[i] * math.cos(phi), curve.share[i] * math.sin(phi)
    return (
        a * curve.along[i, 0] + b * curve.inward[i, 0] + curve.climb[i, 0],
        a * curve.along[i, 1] + b * curve.inward[i, 1] + curve.climb[i, 1],
        a * curve.along[i, 2] + b * curve.inward[i, 2] + curve.climb[i, 2],
    )


@compiled
def block_bend(curve: LineArc, i: int, s: float) -> tuple[float, float, float]:
    r"""Curvature vector of block ``i`` at arc length ``s`` [m] from its start: towards the centre [1/m].

    .. math:: p''(s) = \kappa\,(-\sin\varphi\,t + \cos\varphi\,n), \qquad \kappa = \sigma^2 / r + \kappa' s

    Parameters
    ----------
    curve : LineArc
        The blocks.
    i : int
        Which.
    s : float
        Arc length [m].

    Returns
    -------
    tuple
        x, y, z [1/m]; zero on a line. Valid for any s.

    Examples
    --------
    Half a metre of radius, after a quarter of the circle:

    >>> [round(part, 9) for part in block_bend(join([arc((0, 0), (0, 0.5), 3.0)]), 0, 0.25 * math.pi)]
    [-2.0, 0.0, 0.0]

    References
    ----------
    Derived here: the derivative of :func:`block_tangent`.
    """
    phi = block_turn(curve, i, s)
    kappa = curve.share[i] ** 2 / curve.radius[i] + curve.sharpness[i] * s
    a, b = -kappa * math.sin(phi), kappa * math.cos(phi)
    return (
        a * curve.along[i, 0] + b * curve.inward[i, 0],
        a * curve.along[i, 1] + b * curve.inward[i, 1],
        a * curve.along[i, 2] + b * curve.inward[i, 2],
    )


@compiled
def curvature_jumps(curve: LineArc) -> FloatArray:
    """Length of the jump of the curvature vector at each inner joint [1/m], shape (n-1,).

    Parameters
    ----------
    curve : LineArc
        The blocks, n of them.

    Returns
    -------
    ndarray
        :math:`|p''_{i+1}(0) - p''_i(L_i)|` [1/m]. Valid for joints without a kink, which is :func:`turn_angles`.

    Examples
    --------
    From a line into an arc of 10 mm:

    >>> way = join([line((0, 0), (1, 0)), arc((1, 0), (1, 0.01), 0.5 * math.pi)])
    >>> curvature_jumps(way).round(6).tolist()
    [100.0]

    References
    ----------
    Derived here.
    """
    n = curve.length.shape[0]
    jumps = np.empty(n - 1)
    for i in range(n - 1):
        ax, ay, az = block_bend(curve, i, curve.length[i])
        bx, by, bz = block_bend(curve, i + 1, 0.0)
        jumps[i] = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2 + (bz - az) ** 2)
    return jumps


@compiled
def at_blocks(curve: LineArc, block: IntArray, s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points [m] and unit tangents at arc lengths ``s`` [m] from the starts of given blocks, shapes (len(s), 3).

    Parameters
    ----------
    curve : LineArc
        The blocks.
    block : ndarray
        Which block at each place, shape (k,).
    s : ndarray
        Arc length from its start [m], shape (k,).

    Returns
    -------
    tuple
        Points [m] and tangents [1], shape (k, 3). Valid for any s.

    Examples
    --------
    >>> way = join([line((0, 0), (1, 0)), line((1, 0), (1, 1))])
    >>> points, tangents = at_blocks(way, np.array([0, 1]), np.array([0.25, 0.5]))
    >>> points.tolist(), tangents[1].tolist()
    ([[0.25, 0.0, 0.0], [1.0, 0.5, 0.0]], [0.0, 1.0, 0.0])
    """
    points, tangents = np.empty((s.shape[0], 3)), np.empty((s.shape[0], 3))
    for k in range(s.shape[0]):
        points[k, 0], points[k, 1], points[k, 2] = block_point(curve, block[k], s[k])
        tangents[k, 0], tangents[k, 1], tangents[k, 2] = block_tangent(curve, block[k], s[k])
    return points, tangents


@compiled
def sample(curve: LineArc, knots: FloatArray, s: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Points, unit tangents and block numbers at ascending arc lengths ``s`` [m].

    At a joint the block that starts there is taken; the last block is taken at the end of the curve.

    Parameters
    ----------
    curve : LineArc
        The blocks, n of them.
    knots : ndarray
        ``curve.knots`` [m], shape (n+1,).
    s : ndarray
        Arc length from the start of the curve [m], rising: a shorter one would be taken in a later block.

    Returns
    -------
    tuple
        Points [m], shape (len(s), 3); tangents, same shape; block numbers (integers), shape (len(s),).

    Examples
    --------
    >>> way = join([line((0, 0), (1, 0)), line((1, 0), (1, 1))])
    >>> points, _, blocks = sample(way, way.knots, np.array([0.25, 1.0, 1.5]))
    >>> points[:, :2].tolist(), blocks.tolist()
    ([[0.25, 0.0], [1.0, 0.0], [1.0, 0.5]], [0, 1, 1])
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
    r"""Angle between the tangents on either side of each inner joint [rad], shape (n-1,).

    .. math:: \operatorname{atan2}(|t_i \times t_{i+1}|,\; t_i \cdot t_{i+1})

    Parameters
    ----------
    curve : LineArc
        The blocks, n of them.

    Returns
    -------
    ndarray
        Angles [rad], 0 to :math:`\pi`; valid to rounding at small ones and near half a turn alike.

    Examples
    --------
    >>> turn_angles(join([line((0, 0), (1, 0)), line((1, 0), (1, 1))])).round(6).tolist()
    [1.570796]
    """
    n = curve.length.shape[0]
    turns = np.empty(n - 1)
    for i in range(n - 1):
        ax, ay, az = block_tangent(curve, i, curve.length[i])
        bx, by, bz = block_tangent(curve, i + 1, 0.0)
        cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        turns[i] = math.atan2(math.sqrt(cx * cx + cy * cy + cz * cz), ax * bx + ay * by + az * bz)
    return turns
