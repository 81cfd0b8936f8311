"""Circles and helices about any axis in space."""

import math
from collections.abc import Iterator
from typing import NamedTuple

Vector = tuple[float, float, float]

_SMALLEST_STEP = 1e-3  # [rad] below which a chord is not made shorter: a tolerance of nothing asks for no end of chords
_FULL_TURN = 1e-9  # [rad] an angle below which start and end are the same point


class Circle(NamedTuple):
    """A circle, run counter-clockwise about its unit axis; lengths in one unit of the caller's."""

    centre: Vector
    axis: Vector
    radius: float


def distance_from_axis(circle: Circle, point: Vector) -> float:
    """Distance of a point from the axis of a circle."""
    across = _minus(point, circle.centre)
    return math.hypot(*_minus(across, _times(_dot(across, circle.axis), circle.axis)))


def chords(circle: Circle, start: Vector, end: Vector, tolerance: float) -> Iterator[Vector]:
    """Ends of the chords that run from one point of a circle to another within a tolerance; the last is the end itself.

    Rise along the axis is spread evenly over the angle: a helix. A start that is the end too means a full turn.
    """
    across = _minus(start, circle.centre)
    rise0 = _dot(across, circle.axis)
    first = _minus(across, _times(rise0, circle.axis))
    side = _cross(circle.axis, first)
    to = _minus(end, circle.centre)
    rise1 = _dot(to, circle.axis)
    angle = math.atan2(_dot(to, side), _dot(to, first)) % (2.0 * math.pi)
    angle = angle if _FULL_TURN < angle < 2.0 * math.pi - _FULL_TURN else 2.0 * math.pi
    step = 2.0 * math.acos(max(0.0, 1.0 - tolerance / circle.radius))
    count = max(1, math.ceil(angle / max(step, _SMALLEST_STEP)))
    for k in range(1, count):
        along, rise = angle * k / count, rise0 + (rise1 - rise0) * k / count
        turned = _plus(_times(math.cos(along), first), _times(math.sin(along), side))
        yield _plus(_plus(circle.centre, _times(rise, circle.axis)), turned)
    yield end


def _plus(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _minus(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _times(s: float, a: Vector) -> Vector:
    return s * a[0], s * a[1], s * a[2]


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
