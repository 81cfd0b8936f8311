"""Rational B-splines in a plane, and the arcs and lines that stand for them."""

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

Point = tuple[float, float]

_ROUND = 1e-9  # share of the radius by which points of a circle may be off it
_LARGEST_RADIUS = 1e4  # of the chord; a flatter arc is a line
_DEEPEST = 24  # halvings of a span


class Piece(NamedTuple):
    """A line to a point, or an arc about a centre."""

    end: Point
    centre: Point = (0.0, 0.0)
    sweep: float = 0.0  # counterclockwise [rad]; 0: a line


def clamped_knots(points: int, order: int) -> tuple[float, ...]:
    """Uniform knots, so often at the ends that the curve begins and ends in its outer control points."""
    inner = points - order + 1
    return (0.0,) * order + tuple(float(i) for i in range(1, inner)) + (float(inner),) * order


def point(points: Sequence[Point], weights: Sequence[float], order: int, knots: Sequence[float], t: float) -> Point:
    """A point of the curve, by de Boor's algorithm on homogeneous coordinates.

    Parameters
    ----------
    points, weights : sequence
        Control points and their positive weights, n of each.
    order : int
        Degree plus one, at most n.
    knots : sequence of float
        Rising, n + order of them.
    t : float
        Parameter, between the knots number ``order - 1`` and ``n`` (from 0).

    References
    ----------
    de Boor 1972, J. Approx. Theory 6.
    """
    n = len(points)
    span = next((i for i in range(order - 1, n) if t < knots[i + 1]), n - 1)
    while knots[span] == knots[span + 1]:
        span -= 1
    rows = [
        (points[i][0] * weights[i], points[i][1] * weights[i], weights[i]) for i in range(span - order + 1, span + 1)
    ]
    for level in range(1, order):
        for j in range(order - 1, level - 1, -1):
            i = span - order + 1 + j
            a = (t - knots[i]) / (knots[i + order - level] - knots[i])
            rows[j] = (
                (1.0 - a) * rows[j - 1][0] + a * rows[j][0],
                (1.0 - a) * rows[j - 1][1] + a * rows[j][1],
                (1.0 - a) * rows[j - 1][2] + a * rows[j][2],
            )
    x, y, w = rows[order - 1]
    return x / w, y / w


def pieces(points: Sequence[Point], weights: Sequence[float], order: int, tolerance: float) -> Iterator[Piece]:
    """Arcs where the curve is one, else lines that stay within a tolerance of it."""
    knots = clamped_knots(len(points), order)
    ends = sorted(set(knots))
    for low, high in itertools.pairwise(ends):
        sampled = [point(points, weights, order, knots, low + (high - low) * i / 8.0) for i in range(9)]
        circle = _circle(sampled)
        if circle is not None:
            yield circle
            continue

        def at(t: float) -> Point:
            return point(points, weights, order, knots, t)

        for a, b in ((low, 0.5 * (low + high)), (0.5 * (low + high), high)):
            yield from (Piece(end) for end in _lines(at, a, at(a), b, at(b), tolerance, 0))


def _lines(at, a: float, start: Point, b: float, end: Point, tolerance: float, depth: int) -> Iterator[Point]:  # type: ignore[no-untyped-def]
    """Ends of chords within a tolerance of the curve."""
    inner = [at(a + (b - a) * share) for share in (0.25, 0.5, 0.75)]
    if depth >= _DEEPEST or all(_off(p, start, end) <= tolerance for p in inner):
        yield end
        return
    middle = 0.5 * (a + b)
    yield from _lines(at, a, start, middle, inner[1], tolerance, depth + 1)
    yield from _lines(at, middle, inner[1], b, end, tolerance, depth + 1)


def _off(p: Point, start: Point, end: Point) -> float:
    """Distance of a point from a chord."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    square = dx * dx + dy * dy
    share = 0.0 if square == 0.0 else ((p[0] - start[0]) * dx + (p[1] - start[1]) * dy) / square
    share = min(1.0, max(0.0, share))
    return math.hypot(p[0] - start[0] - share * dx, p[1] - start[1] - share * dy)


def _circle(sampled: Sequence[Point]) -> Piece | None:
    """The arc through samples of a curve, if it is one."""
    (ax, ay), (bx, by), (cx, cy) = sampled[0], sampled[len(sampled) // 2], sampled[-1]
    twice = 2.0 * ((bx - ax) * (cy - ay) - (by - ay) * (cx - ax))
    chord = max(math.dist(sampled[0], sampled[-1]), math.dist(sampled[0], sampled[len(sampled) // 2]))
    if abs(twice) <= chord * chord / _LARGEST_RADIUS:
        return None
    b2, c2 = (bx - ax) ** 2 + (by - ay) ** 2, (cx - ax) ** 2 + (cy - ay) ** 2
    x = ax + ((cy - ay) * b2 - (by - ay) * c2) / twice
    y = ay + ((bx - ax) * c2 - (cx - ax) * b2) / twice
    radius = math.hypot(ax - x, ay - y)
    if any(abs(math.hypot(px - x, py - y) - radius) > _ROUND * radius for px, py in sampled):
        return None
    angles = [math.atan2(py - y, px - x) for px, py in sampled]
    steps = [math.remainder(q - p, 2.0 * math.pi) for p, q in itertools.pairwise(angles)]
    return Piece(sampled[-1], (x, y), sum(steps))
