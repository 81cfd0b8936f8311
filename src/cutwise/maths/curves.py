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
    """Cubic through all points without overshoot (PCHIP): no new extremes between measured values.

    References
    ----------
    Fritsch and Butland 1984, SIAM J. Sci. Stat. Comput. 5, as SciPy has it.
    """
    curve = interpolate.PchipInterpolator(np.asarray(at, float), np.asarray(value, float))
    return Cubic(np.ascontiguousarray(curve.x), np.ascontiguousarray(curve.c))


def no_cubic() -> Cubic:
    """The curve that is zero everywhere."""
    return Cubic(np.array([0.0, 1.0]), np.zeros((4, 1)))


@compiled
def segment(at: FloatArray, x: float) -> int:
    """Index of the last breakpoint not beyond x, by bisection; 0 before the first.

    Parameters
    ----------
    at : array (n,)
        Breakpoints, rising.
    x : float
        In their unit.

    Returns
    -------
    int
        Of the piece from this breakpoint to the next: n - 2 at the most, also at the last breakpoint and beyond it.

    Notes
    -----
    Valid for any finite x.

    Examples
    --------
    >>> [segment(np.array([0.0, 1.0, 3.0]), x) for x in (-1.0, 1.0, 9.0)]
    [0, 1, 1]
    """
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
    r"""Interval of a table and the share of it that lies behind; the end values hold beyond the ends.

    .. math:: x = x_k + \sigma\,(x_{k+1} - x_k), \qquad 0 \le \sigma \le 1

    Parameters
    ----------
    at : array (n,)
        Stations :math:`x_k`, rising, in a unit of the caller's: of the path [m].
    along : float
        x in that unit.

    Returns
    -------
    tuple
        k and :math:`\sigma`; 0 and 0 where there is one station only.

    Notes
    -----
    Valid for stations so close that what is read between them is as good as straight.

    Examples
    --------
    >>> stations = np.array([0.0, 1.0, 3.0])
    >>> station(stations, 1.5), station(stations, 7.0)
    ((1, 0.25), (1, 1.0))
    """
    last = at.size - 1
    if last == 0 or along <= at[0]:
        return 0, 0.0
    if along >= at[last]:
        return last - 1, 1.0
    low = segment(at, along)
    return low, (along - at[low]) / (at[low + 1] - at[low])


@compiled
def polyline_value(curve: Polyline, x: float) -> float:
    r"""Value of a polyline at x; the end values hold beyond the ends.

    .. math:: y = y_i + \frac{x - x_i}{x_{i+1} - x_i} (y_{i+1} - y_i)

    Parameters
    ----------
    curve : Polyline
        Breakpoints :math:`x_i, y_i`, shape (n,), in units of the caller's.
    x : float
        In the unit of the breakpoints.

    Returns
    -------
    float
        y. Valid for any x: whoever may not go beyond the ends asks before.

    Examples
    --------
    >>> curve = Polyline(np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0, 4.0]))
    >>> polyline_value(curve, 2.0), polyline_value(curve, 9.0)
    (3.0, 4.0)
    """
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
    r"""Value and slope of a cubic at x; constant beyond the ends.

    .. math:: y = ((c_0 d + c_1) d + c_2) d + c_3, \qquad y' = (3 c_0 d + 2 c_1) d + c_2, \qquad d = x - x_i

    Parameters
    ----------
    curve : Cubic
        Breakpoints :math:`x_i`, shape (n,), and coefficients, shape (4, n - 1), in units of the caller's.
    x : float
        In the unit of the breakpoints.

    Returns
    -------
    tuple
        y and :math:`y'`; the slope is 0 at the ends themselves and beyond. Valid for any x.

    Examples
    --------
    :math:`x^3` from 0 to 2:

    >>> cube = Cubic(np.array([0.0, 2.0]), np.array([[1.0], [0.0], [0.0], [0.0]]))
    >>> cubic_value_slope(cube, 1.0), cubic_value_slope(cube, 3.0)
    ((1.0, 3.0), (8.0, 0.0))

    References
    ----------
    Horner's scheme.
    """
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
