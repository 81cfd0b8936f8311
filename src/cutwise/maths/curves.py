"""Curves given by breakpoints: piecewise linear and piecewise cubic, as flat arrays that a kernel can read."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.later import later
from cutwise.maths.compiled import compiled

if TYPE_CHECKING:
    from scipy import interpolate
else:
    interpolate = later("scipy.interpolate")

FloatArray = NDArray[np.float64]


class Polyline(NamedTuple):
    """Piecewise linear curve, constant beyond its ends."""

    at: FloatArray  # breakpoints, rising, shape (n,)
    value: FloatArray  # value at the breakpoints, shape (n,)


class Cubic(NamedTuple):
    """Piecewise cubic curve, constant beyond its ends."""

    at: FloatArray  # breakpoints, rising, shape (n,)
    coefficient: FloatArray  # highest power first, shape (4, n - 1)


def constant(value: float) -> Polyline:
    """A polyline of one value everywhere."""
    return Polyline(np.array([0.0]), np.array([float(value)]))


def smooth(at: FloatArray, value: FloatArray) -> Cubic:
    """Cubic through all points without overshoot (PCHIP): no new extremes between measured values."""
    curve = interpolate.PchipInterpolator(np.asarray(at, float), np.asarray(value, float))
    return Cubic(np.ascontiguousarray(curve.x), np.ascontiguousarray(curve.c))


def no_cubic() -> Cubic:
    """The curve that is zero everywhere."""
    return Cubic(np.array([0.0, 1.0]), np.zeros((4, 1)))


@compiled
def segment(at: FloatArray, x: float) -> int:
    """Index of the last breakpoint not beyond x, by bisection; 0 before the first."""
    low = 0
    high = at.size - 1
    while high - low > 1:
        middle = (low + high) // 2
        if at[middle] <= x:
            low = middle
        else:
            high = middle
    return low


@compiled
def station(at: FloatArray, along: float) -> tuple[int, float]:
    """Interval of a table and the share of it that lies behind; the end values hold beyond the ends."""
    last = at.size - 1
    if last == 0 or along <= at[0]:
        return 0, 0.0
    if along >= at[last]:
        return last - 1, 1.0
    low = segment(at, along)
    return low, (along - at[low]) / (at[low + 1] - at[low])


@compiled
def polyline_value(curve: Polyline, x: float) -> float:
    """Value of a polyline at x; the end values hold beyond the ends."""
    at = curve.at
    last = at.size - 1
    if last == 0 or x <= at[0]:
        return curve.value[0]
    if x >= at[last]:
        return curve.value[last]
    i = segment(at, x)
    part = (x - at[i]) / (at[i + 1] - at[i])
    return curve.value[i] + part * (curve.value[i + 1] - curve.value[i])


@compiled
def cubic_value_slope(curve: Cubic, x: float) -> tuple[float, float]:
    """Value and slope of a cubic at x; constant beyond the ends."""
    at = curve.at
    last = at.size - 1
    inside = at[0] < x < at[last]
    x = min(max(x, at[0]), at[last])
    i = segment(at, x)
    d = x - at[i]
    c3 = curve.coefficient[0, i]
    c2 = curve.coefficient[1, i]
    c1 = curve.coefficient[2, i]
    value = ((c3 * d + c2) * d + c1) * d + curve.coefficient[3, i]
    slope = (3.0 * c3 * d + 2.0 * c2) * d + c1
    return value, slope if inside else 0.0


def largest_curvature(curve: Cubic) -> float:
    """Largest second derivative in magnitude; a cubic has it at the ends of its pieces."""
    width = np.diff(curve.at)
    start = 2.0 * curve.coefficient[1]
    end = start + 6.0 * curve.coefficient[0] * width
    return float(max(np.abs(start).max(), np.abs(end).max()))
