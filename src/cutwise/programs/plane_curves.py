"""Lines and arcs in the plane of a program, as the tool centre follows them, and where they meet."""

import math
from typing import NamedTuple

Point = tuple[float, float]

SLACK = 1e-9  # share of the length by which a curve may be cut short beyond its beginning


class Circle(NamedTuple):
    """Centre in the plane, and turns: positive counterclockwise."""

    u: float
    v: float
    turns: int


class Curve(NamedTuple):
    """A motion of the tool centre: a line, or an arc if it has turns."""

    start: Point
    end: Point
    end_tangent: Point  # unit, direction of the programmed contour at its end
    centre: Point = (0.0, 0.0)
    radius: float = 0.0
    turns: int = 0
    full_end: Point = (0.0, 0.0)  # of an arc: its end before it was cut short
    entry: bool = False  # to the contour, not along it
    missed: bool = False  # an arc that begins where it is not


def meetings(a: Curve, b: Curve) -> list[Point]:
    """Where the lines or circles of two curves meet, on the curves or beyond them; none, one or two points."""
    if not a.turns and not b.turns:
        return _lines(a, b)
    if a.turns and b.turns:
        return _circles(a, b)
    if a.turns:
        return _line_and_circle(b.start, b.end_tangent, a)
    return _line_and_circle(a.end, a.end_tangent, b)


def _lines(a: Curve, b: Curve) -> list[Point]:
    cross = a.end_tangent[0] * b.end_tangent[1] - a.end_tangent[1] * b.end_tangent[0]
    to = (b.start[0] - a.end[0], b.start[1] - a.end[1])
    s = (to[0] * b.end_tangent[1] - to[1] * b.end_tangent[0]) / cross
    return [(a.end[0] + s * a.end_tangent[0], a.end[1] + s * a.end_tangent[1])]


def _line_and_circle(point: Point, direction: Point, circle: Curve) -> list[Point]:
    to = (point[0] - circle.centre[0], point[1] - circle.centre[1])
    along = to[0] * direction[0] + to[1] * direction[1]
    left = along**2 - (to[0] ** 2 + to[1] ** 2 - circle.radius**2)
    if left < 0.0:
        return []
    root = math.sqrt(left)
    return [(point[0] + s * direction[0], point[1] + s * direction[1]) for s in (-along - root, -along + root)]


def _circles(a: Curve, b: Curve) -> list[Point]:
    du, dv = b.centre[0] - a.centre[0], b.centre[1] - a.centre[1]
    d2 = du * du + dv * dv
    if d2 == 0.0:
        return []
    share = 0.5 * (d2 + a.radius**2 - b.radius**2) / d2
    left = a.radius**2 / d2 - share**2
    if left < 0.0:
        return []
    h = math.sqrt(left)
    return [(a.centre[0] + share * du - s * dv, a.centre[1] + share * dv + s * du) for s in (h, -h)]


def within(curve: Curve, point: Point) -> bool:
    """Whether a point of its line or circle is on the curve, between its start and its end."""
    if not curve.turns:
        du, dv = curve.end[0] - curve.start[0], curve.end[1] - curve.start[1]
        along = du * (point[0] - curve.start[0]) + dv * (point[1] - curve.start[1])
        square = du * du + dv * dv
        return -SLACK * square <= along <= (1.0 + SLACK) * square
    whole = _angle(curve, curve.end)
    return _angle(curve, point) <= (whole if whole > 0.0 else 2.0 * math.pi) + SLACK


def beyond(curve: Curve, point: Point) -> bool:
    """Whether a point on the circle of an arc is behind its end, rather than on it or before its start."""
    if not curve.turns:
        return False
    whole, angle = _angle(curve, curve.end), _angle(curve, point)
    return whole + SLACK < angle < 0.5 * (whole + 2.0 * math.pi)


def _angle(curve: Curve, point: Point) -> float:
    """How far a point is along the arc [rad], 0 to a full turn."""
    (cu, cv), (su, sv) = curve.centre, curve.start
    angle = math.atan2(point[1] - cv, point[0] - cu) - math.atan2(sv - cv, su - cu)
    return (angle if curve.turns > 0 else -angle) % (2.0 * math.pi)


def tangent(point: Point, centre: Point, turns: int) -> Point:
    radius = math.dist(point, centre)
    s = math.copysign(1.0 / radius, turns)
    return -s * (point[1] - centre[1]), s * (point[0] - centre[0])


def along(centre: Point, point: Point, factor: float) -> Point:
    return centre[0] + factor * (point[0] - centre[0]), centre[1] + factor * (point[1] - centre[1])


def backwards(curve: Curve) -> bool:
    """Whether what is left of a curve between its concave corners would lead back."""
    if curve.entry:
        return False
    if curve.turns:
        return curve.missed or not within(curve._replace(end=curve.full_end), curve.end)
    du, dv = curve.end[0] - curve.start[0], curve.end[1] - curve.start[1]
    return du * curve.end_tangent[0] + dv * curve.end_tangent[1] < 0.0
