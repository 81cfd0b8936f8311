r"""Limits of the feed of a contact whose forces are affine in it: every limit is one interval, whatever shape the tool has.

At a fixed contact every force of a linear law is affine in the feed per tooth f, :math:`F(\theta) = A(\theta) + f B(\theta)`
over the positions of a tooth period. Where A and B come from is another matter: :mod:`cutwise.physics.cutting.feed_limits` has
them of a flat mill in exact arcs, :mod:`cutwise.physics.cutting.meridian_loads` of any tool of revolution.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.cutting.flute import EdgeCoefficients, arc_force
from cutwise.physics.cutting.helix import edge_in_cut, flutes_in_cut

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

PEAK, MEAN, POWER, TORQUE, CHIP, WALL, REMOVAL = range(7)
"""Columns of the highest feeds: peak and mean force, power, torque, chip thickness, wall, removal rate."""
RUBBING, WALL_FROM = range(2)
"""Columns of the lowest feeds: chip thickness, wall."""
VALUES = 9
"""Columns of values: those of the highest feeds, the least wall error in the place of the wall, the greatest behind."""
MOST_ERROR, SLOPE = 7, 8


class Bounds(NamedTuple):
    """What is allowed; infinite where nothing is asked."""

    peak: float  # force in the plane [N]
    mean: float  # mean of it over a tooth [N]
    power: float  # mean [W]
    torque: float  # mean [N m]
    chip: float  # largest thickness [m]
    least_chip: float  # which the thickest chip has at least [m], 0: nothing is asked
    least_error: float  # of the wall, positive into the part [m]
    most_error: float  # [m]
    removal: float  # volume per time [m^3/s]


class Sums(NamedTuple):
    """What a contact comes to over a tooth: what the edges do without feed, and what grows with it."""

    edge_x: float  # mean force along the feed [N]
    edge_y: float  # to its left [N]
    shear_x: float  # the same per feed of a tooth [N/m]
    shear_y: float
    edge_torque: float  # mean [N m]
    shear_torque: float  # [N]
    chip: float  # thickest one over the feed per tooth [-]
    area: float  # volume taken per length of feed [m^2]
    edge_z: float  # mean force up [N]; 0 where it is not known
    shear_z: float  # [N/m]


SUMS = 10
"""Numbers of a row of sums."""


@compiled
def highest_feed(ax: float, ay: float, bx: float, by: float, most: float) -> float:
    r"""Highest f at which a force :math:`A + f B` is no more than F.

    .. math:: f = \frac{-A \cdot B + \sqrt{(A \cdot B)^2 + |B|^2 (F^2 - |A|^2)}}{|B|^2}

    Parameters
    ----------
    ax, ay, bx, by : float
        A [N] and B [N/m].
    most : float
        F [N].

    Returns
    -------
    float
        f [m]; infinite where nothing grows, minus infinity where :math:`|A| > F`: no feed helps.

    Notes
    -----
    Valid for forces that are affine in the feed.

    Examples
    --------
    3 N across and 2 N/m along: 5 N at 2 m.

    >>> highest_feed(0.0, 3.0, 2.0, 0.0, 5.0)
    2.0

    References
    ----------
    Derived here.
    """
    if math.isinf(most):
        return math.inf
    room = most * most - ax * ax - ay * ay
    if room < 0.0:
        return -math.inf
    bb, ab = bx * bx + by * by, ax * bx + ay * by
    if bb <= 0.0:
        return math.inf
    return (-ab + math.sqrt(ab * ab + bb * room)) / bb


@compiled
def flutes_of(
    rotation: float, lo: float, hi: float, bottom: float, top: float, flutes: int, lag: float, edge: EdgeCoefficients,
    shear: EdgeCoefficients,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Forces in the plane of all flutes in a patch of the cylinder, taken apart: A [N] of the edges, B [N/m] of the shearing.

    Parameters
    ----------
    rotation : float
        Angle of flute 0 at the tip [rad].
    lo, hi, bottom, top : float
        Arc [rad] and heights [m] of the patch, as for :func:`cutwise.physics.cutting.flute.tooth_force`.
    flutes, lag : int, float
        How many, and how far they lag, from :func:`cutwise.physics.cutting.helix.helix_lag` [rad/m].
    edge, shear : EdgeCoefficients
        Of the edges alone, and without edge forces.

    Returns
    -------
    tuple
        A along the feed and to its left, B along the feed and to its left.

    Notes
    -----
    Valid as that function, to which A + f B is equal; it looks once for the flutes in cut.

    Examples
    --------
    >>> from cutwise.physics.cutting.flute import Mill, tooth_force
    >>> from cutwise.physics.cutting.helix import helix_lag
    >>> mill, k = Mill(5e-3, 3, 0.5), EdgeCoefficients(7e8, 2e8, 0.0, 2e4, 1e4, 0.0)
    >>> edge, shear = k._replace(K_tc=0.0, K_rc=0.0), k._replace(K_te=0.0, K_re=0.0)
    >>> a, _, b, _ = flutes_of(1.9, 0.4, 2.0, 0.0, 4e-3, 3, helix_lag(0.5, 5e-3), edge, shear)
    >>> abs(a + 1e-4 * b - tooth_force(1.9, 0.4, 2.0, 1e-4, 0.0, 0.0, 4e-3, mill, k).x) < 1e-9 < abs(a)
    True

    References
    ----------
    As :func:`cutwise.physics.cutting.flute.tooth_force`.
    """
    ax, ay, bx, by = 0.0, 0.0, 0.0, 0.0
    first, last = flutes_in_cut(rotation, lo, hi, bottom, top, flutes, lag)
    for flute in range(first, last + 1):
        z1, z2, middle, span = edge_in_cut(rotation, flute, lo, hi, bottom, top, flutes, lag)
        if z2 > z1:
            own = arc_force(1.0, 0.0, middle, span, z2 - z1, edge)
            grows = arc_force(1.0, 0.0, middle, span, z2 - z1, shear)
            ax, ay, bx, by = ax + own.x, ay + own.y, bx + grows.x, by + grows.y
    return ax, ay, bx, by


@compiled
def limits_of(
    loads: FloatArray, rows: int, terms: FloatArray, count: int, sums: Sums, spindle: float, flutes: int, bounds: Bounds,
    high: FloatArray, low: FloatArray,
) -> None:  # fmt: skip
    r"""Highest and lowest feeds per tooth of a contact.

    Parameters
    ----------
    loads, rows : array (m, 4), int
        A [N] and B [N/m] in the plane at positions of a tooth period, and how many there are.
    terms, count : array (m, 2), int
        Errors of walls, :math:`a + f b` [m], [-], and how many there are.
    sums : Sums
        Means over a tooth.
    spindle : float
        Speed [rad/s].
    flutes : int
        Teeth.
    bounds : Bounds
        What is allowed.
    high, low : array (7,), array (2,)
        Filled: highest feeds, infinite where nothing limits, and lowest ones [m].

    Notes
    -----
    Valid for linear edges without run-out.

    Examples
    --------
    10 N of the edges and 1 N per 10 um of feed, held to 15 N; the chip is 0.6 of the feed, held to 60 um.

    >>> high, low = np.zeros(7), np.zeros(2)
    >>> none = Bounds(15.0, math.inf, math.inf, math.inf, 6e-5, 0.0, -math.inf, math.inf, math.inf)
    >>> some = Sums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.6, 0.0, 0.0, 0.0)
    >>> limits_of(np.array([[10.0, 0.0, 1e5, 0.0]]), 1, np.zeros((0, 2)), 0, some, 100.0, 2, none, high, low)
    >>> [round(1e6 * float(high[k]), 6) for k in (PEAK, CHIP)]
    [50.0, 100.0]

    References
    ----------
    Derived here.
    """
    high[:], low[:] = math.inf, 0.0
    for i in range(rows):
        high[PEAK] = min(high[PEAK], highest_feed(loads[i, 0], loads[i, 1], loads[i, 2], loads[i, 3], bounds.peak))
    high[MEAN] = highest_feed(sums.edge_x, sums.edge_y, sums.shear_x, sums.shear_y, bounds.mean)
    if sums.shear_torque > 0.0:
        high[POWER] = (bounds.power / spindle - sums.edge_torque) / sums.shear_torque
        high[TORQUE] = (bounds.torque - sums.edge_torque) / sums.shear_torque
    if sums.chip > 0.0:
        high[CHIP] = bounds.chip / sums.chip
        low[RUBBING] = bounds.least_chip / sums.chip
    if sums.area > 0.0:
        high[REMOVAL] = bounds.removal / sums.area * 2.0 * math.pi / (flutes * spindle)
    for e in range(count):
        a, b = terms[e, 0], terms[e, 1]
        if b < 0.0:
            high[WALL] = min(high[WALL], (bounds.least_error - a) / b)
            low[WALL_FROM] = max(low[WALL_FROM], (bounds.most_error - a) / b)
        elif b > 0.0:
            high[WALL] = min(high[WALL], (bounds.most_error - a) / b)
            low[WALL_FROM] = max(low[WALL_FROM], (bounds.least_error - a) / b)


@compiled
def values_of(
    loads: FloatArray, rows: int, terms: FloatArray, count: int, sums: Sums, spindle: float, flutes: int, feed: float,
    out: FloatArray,
) -> None:  # fmt: skip
    """What a contact comes to at a feed per tooth.

    Parameters
    ----------
    loads, rows, terms, count, sums, spindle, flutes
        As for :func:`limits_of`.
    feed : float
        Feed per tooth [m].
    out : array (9,)
        Filled in SI; the least and the greatest error of walls are NaN where none stays.

    Notes
    -----
    Valid as :func:`limits_of`.

    Examples
    --------
    The contact of :func:`limits_of` at 50 um.

    >>> out, some = np.zeros(VALUES), Sums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.6, 0.0, 0.0, 0.0)
    >>> values_of(np.array([[10.0, 0.0, 1e5, 0.0]]), 1, np.zeros((0, 2)), 0, some, 100.0, 2, 5e-5, out)
    >>> round(float(out[PEAK]), 9), round(1e6 * float(out[CHIP]), 9)
    (15.0, 30.0)

    References
    ----------
    Derived here.
    """
    out[:] = 0.0
    out[WALL] = out[MOST_ERROR] = math.nan
    for i in range(rows):
        x, y = loads[i, 0] + feed * loads[i, 2], loads[i, 1] + feed * loads[i, 3]
        out[PEAK] = max(out[PEAK], math.hypot(x, y))
    out[MEAN] = math.hypot(sums.edge_x + feed * sums.shear_x, sums.edge_y + feed * sums.shear_y)
    out[TORQUE] = sums.edge_torque + feed * sums.shear_torque
    out[POWER] = out[TORQUE] * spindle
    out[CHIP] = feed * sums.chip
    out[REMOVAL] = sums.area * feed * flutes * spindle / (2.0 * math.pi)
    for e in range(count):
        error = terms[e, 0] + feed * terms[e, 1]
        out[WALL] = error if math.isnan(out[WALL]) else min(out[WALL], error)
        out[MOST_ERROR] = error if math.isnan(out[MOST_ERROR]) else max(out[MOST_ERROR], error)
        if abs(terms[e, 1]) > abs(out[SLOPE]):
            out[SLOPE] = terms[e, 1]


@compiled
def intervals_of(
    loads: FloatArray, rows: IntArray, sums: FloatArray, place: IntArray, feed: FloatArray, spindle: float, flutes: IntArray,
    bounds: Bounds,
) -> tuple[FloatArray, FloatArray, FloatArray]:  # fmt: skip
    """Highest and lowest feed per tooth of every limit, place by place, and what each comes to at the feed it has.

    Parameters
    ----------
    loads, rows : array (p, m, 4), array (p,)
        A [N] and B [N/m] of every contact, and how many rows of them there are.
    sums : array (p, 10)
        As :class:`Sums`.
    place : array (n,)
        Which contact it is.
    feed : array (n,)
        Feed per tooth at which values are wanted [m].
    spindle : float
        Speed [rad/s].
    flutes : array (n,)
        Teeth of the tool of each place.
    bounds : Bounds
        What is allowed; walls have no error.

    Returns
    -------
    tuple
        Highest feeds (n, 7), lowest feeds (n, 2) [m], values (n, 9), as those of
        :func:`cutwise.physics.cutting.feed_limits.feed_intervals`.

    Notes
    -----
    Valid as :func:`limits_of`.

    Examples
    --------
    The contact of :func:`limits_of`.

    >>> none = Bounds(15.0, math.inf, math.inf, math.inf, 6e-5, 0.0, -math.inf, math.inf, math.inf)
    >>> loads, sums = np.array([[[10.0, 0.0, 1e5, 0.0]]]), np.array([[0.0, 0, 0, 0, 0, 0, 0.6, 0, 0, 0]])
    >>> high, _, value = intervals_of(loads, np.ones(1, int), sums, np.zeros(1, int), np.full(1, 5e-5), 100.0, np.full(1, 2), none)
    >>> round(1e6 * float(high[0, PEAK]), 6), round(float(value[0, PEAK]), 6)
    (50.0, 15.0)

    References
    ----------
    Derived here.
    """
    n = place.shape[0]
    high, low, value, terms = np.empty((n, 7)), np.empty((n, 2)), np.empty((n, VALUES)), np.zeros((0, 2))
    for k in range(n):
        p = place[k]
        s = sums[p]
        own = Sums(s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], s[8], s[9])
        limits_of(loads[p], rows[p], terms, 0, own, spindle, flutes[k], bounds, high[k], low[k])
        values_of(loads[p], rows[p], terms, 0, own, spindle, flutes[k], feed[k], value[k])
    return high, low, value
