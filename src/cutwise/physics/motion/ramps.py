"""Changes of speed that run over several stretches of a path: how long they are, and what bounds them."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.motion.profile import ramp_distance, ramp_time

FloatArray = npt.NDArray[np.float64]

SCARCE = 0.7  # of the acceleration: an arc that leaves less than this along the path gets a level of its own


class Stretches(NamedTuple):
    """What each stretch of a path allows, ``n`` of them one after the other."""

    at: FloatArray  # where they begin, and the end [m], shape (n + 1,)
    speed: FloatArray  # highest [m/s], shape (n,)
    acceleration: FloatArray  # without the share of the curvature [m/s^2], shape (n,)
    jerk: FloatArray  # [m/s^3], shape (n,)
    bend: FloatArray  # curvature that takes its share of the acceleration [1/m], 0 on a line, shape (n,)
    even: npt.NDArray[np.bool_]  # run at one speed: all of the jerk is needed to turn, shape (n,)


class Anchor(NamedTuple):
    """A place without acceleration at one end of an interval, whose stretches are all that a ramp from it may see."""

    stretch: int  # next to it within the interval
    farthest: int  # stretch at the other end of the interval
    place: float  # [m]
    speed: float  # [m/s]
    way: int  # 1: a ramp goes up after the anchor; -1: it comes down towards it


@compiled
def tangential_acceleration(speed: float, radius: float, acceleration: float) -> float:
    r"""Tangential acceleration left on an arc that is run at no more than ``speed``.

    .. math:: a_t \le \sqrt{a^2 - (v^2/r)^2}

    Parameters
    ----------
    speed : float
        v [m/s].
    radius : float
        Radius of curvature r [m], infinite on a line.
    acceleration : float
        a [m/s^2].

    Returns
    -------
    float
        :math:`a_t` [m/s^2]; zero where the arc leaves nothing. Valid for a limit on the length of the whole vector.

    Examples
    --------
    3 of 5 m/s^2 are needed to turn:

    >>> round(tangential_acceleration(0.3, 0.03, 5.0), 9)
    4.0

    References
    ----------
    Derived here: Pythagoras.
    """
    if math.isinf(radius):
        return acceleration
    normal = speed * speed / radius
    return math.sqrt(max(acceleration * acceleration - normal * normal, 0.0))


@compiled
def speed_bound(v0: float, way: float, acceleration: float, jerk: float) -> float:
    r"""No ramp from ``v0`` and zero acceleration is quicker than this after a way [m/s].

    It is the lower of :math:`\sqrt{v_0^2 + 2 a s}` and :math:`v_0 + j t^2/2` at the latest time at which
    :math:`v_0 t + j t^3 / 6` can reach the way.

    Parameters
    ----------
    v0 : float
        [m/s], not negative.
    way : float
        s [m].
    acceleration, jerk : float
        a, j [m/s^2], [m/s^3], positive.

    Returns
    -------
    float
        Speed [m/s]: a bound, reached from rest by full jerk. Valid for any motion within both limits.

    Examples
    --------
    From rest over 1 m, :math:`\sqrt{2a}` and :math:`\tfrac12 j (6/j)^{2/3}`:

    >>> [round(speed_bound(0.0, 1.0, a, 6.0), 9) for a in (2.0, 9.0)]
    [2.0, 3.0]

    References
    ----------
    Derived here.
    """
    late = (6.0 * way / jerk) ** (1.0 / 3.0)
    if v0 * late > way:
        late = way / v0
    return min(math.sqrt(v0 * v0 + 2.0 * acceleration * way), v0 + 0.5 * jerk * late * late)


@compiled
def _allowed(st: Stretches, i: int, speed: float) -> float:
    """Acceleration along stretch ``i`` while it is run at no more than a speed [m/s^2]."""
    if st.even[i]:
        return 0.0
    if st.bend[i] == 0.0:
        return st.acceleration[i]
    return tangential_acceleration(speed, 1.0 / st.bend[i], st.acceleration[i])


@compiled
def ramp(st: Stretches, anchor: Anchor, level: float, least: float = 0.0) -> tuple[float, float, float, int]:
    """The change of speed between an anchor and a level, away from the anchor.

    One acceleration and one jerk serve it all: the least of the stretches that it touches, each arc at no more than the
    speed that the ramp can have where it leaves it.

    Parameters
    ----------
    st : Stretches
        The path.
    anchor : Anchor
        Where it begins, or ends.
    level : float
        The speed that it reaches [m/s], not below that of the anchor.
    least : float
        Share of the acceleration that curvature has to leave along the path.

    Returns
    -------
    tuple
        Acceleration [m/s^2], jerk [m/s^3], length [m], and the first stretch whose curvature leaves too little, or -1.

    Notes
    -----
    Valid within the interval of the anchor. Short of the quickest: a ramp could use more acceleration where it begins.

    Examples
    --------
    >>> one, zero = np.ones(1), np.zeros(1)
    >>> st = Stretches(np.array([0.0, 5.0]), 3.0 * one, 2.0 * one, 4.0 * one, zero, np.zeros(1, np.bool_))
    >>> ramp(st, Anchor(0, 0, 0.0, 0.0, 1), 2.0)
    (2.0, 4.0, 1.5, -1)

    References
    ----------
    Derived here from :func:`~cutwise.physics.motion.profile.ramp_distance`.
    """
    k, way, v0 = anchor.stretch, anchor.way, anchor.speed
    a, j = st.acceleration[k], st.jerk[k]
    if level <= v0:
        return a, j, 0.0, -1
    while True:
        length = ramp_distance(v0, level, a, j)
        before_a, before_j = a, j
        i, near = k, 0.0
        while near < length:
            far = st.at[i + 1] - anchor.place if way > 0 else anchor.place - st.at[i]
            fastest = level
            if st.bend[i] != 0.0 and far < length:
                fastest = min(level, st.speed[i], speed_bound(v0, far, before_a, before_j))
            left = _allowed(st, i, fastest)
            if left <= 0.0 or left < least * st.acceleration[i]:
                return left, j, math.inf, i
            a, j = min(a, left), min(j, st.jerk[i])
            if i == anchor.farthest:
                break
            near, i = far, i + way
        if a == before_a and j == before_j:
            return a, j, length, -1


@compiled
def way_to_speed(v0: float, level: float, speed: float, acceleration: float, jerk: float) -> float:
    r"""Way [m] after which a ramp from ``v0`` to a level first has a speed between them [m/s].

    .. math:: s = v_0 t + j t^3/6, \quad t = \sqrt{2 (v - v_0)/j} \text{ in the first phase}

    and by the like in the second, at constant acceleration, and the third.

    Parameters
    ----------
    v0, level : float
        Speeds at both ends of the ramp [m/s].
    speed : float
        v [m/s], between them.
    acceleration, jerk : float
        Limits [m/s^2], [m/s^3], positive.

    Returns
    -------
    float
        Way [m]. Valid for ramps upwards.

    Examples
    --------
    0.5 m/s after 0.5 s of 4 m/s^3 and a twelfth of a metre; the whole ramp is 1.5 m long.

    >>> [round(way_to_speed(0.0, 2.0, v, 2.0, 4.0), 9) for v in (0.5, 2.0)]
    [0.083333333, 1.5]

    References
    ----------
    Derived here from the phases of Biagiotti & Melchiorri 2008, sec. 3.4.
    """
    top = min(acceleration, math.sqrt(jerk * (level - v0)))
    change = top * top / (2.0 * jerk)  # of the speed in the first phase, and in the last
    if speed - v0 <= change:
        t = math.sqrt(2.0 * max(speed - v0, 0.0) / jerk)
        return v0 * t + jerk * t * t * t / 6.0
    if level - speed < change:
        t = math.sqrt(2.0 * max(level - speed, 0.0) / jerk)
        return ramp_distance(v0, level, acceleration, jerk) - (level * t - jerk * t * t * t / 6.0)
    rise = top / jerk
    first = v0 + change
    return v0 * rise + jerk * rise**3 / 6.0 + 0.5 * (first + speed) * (speed - first) / top


@compiled
def highest_level(st: Stretches, anchor: Anchor, ceiling: float, distance: float, limit: float) -> float:
    """Highest level [m/s] of a ramp that keeps a limit [m/s] up to a distance of its anchor [m]; at least the limit.

    Any ramp to a lower level keeps it too: the acceleration is that of the ramp to the limit, which no higher one exceeds.

    Parameters
    ----------
    st, anchor : Stretches, Anchor
        The path, and where the ramp begins.
    ceiling : float
        Highest level asked for [m/s].
    distance : float
        [m]
    limit : float
        [m/s]

    Returns
    -------
    float
        Level [m/s], by bisection. Valid for limits not below the speed of the anchor.

    Examples
    --------
    The ramp to 0.8 m/s is as fast as 0.5 m/s after just that way.

    >>> one, zero = np.ones(1), np.zeros(1)
    >>> st = Stretches(np.array([0.0, 5.0]), 3.0 * one, 2.0 * one, 4.0 * one, zero, np.zeros(1, np.bool_))
    >>> way = way_to_speed(0.0, 0.8, 0.5, 2.0, 4.0)
    >>> round(highest_level(st, Anchor(0, 0, 0.0, 0.0, 1), 3.0, way, 0.5), 9)
    0.8

    References
    ----------
    Derived here.
    """
    a, j, length, _ = ramp(st, anchor, limit)
    if math.isinf(length) or way_to_speed(anchor.speed, ceiling, limit, a, j) >= distance:
        return ceiling
    low, high = limit, ceiling
    for _ in range(100):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        if way_to_speed(anchor.speed, middle, limit, a, j) >= distance:
            low = middle
        else:
            high = middle
    return low


@compiled
def level_within(st: Stretches, anchor: Anchor, ceiling: float, distance: float) -> float:
    """Highest level [m/s] that a ramp reaches within a distance of its anchor [m].

    Parameters
    ----------
    st, anchor : Stretches, Anchor
        The path, and where the ramp begins.
    ceiling : float
        Highest level asked for [m/s].
    distance : float
        [m]

    Returns
    -------
    float
        Level [m/s], by bisection; the speed of the anchor where there is no room. Valid where longer ramps reach higher.

    Examples
    --------
    >>> one, zero = np.ones(1), np.zeros(1)
    >>> st = Stretches(np.array([0.0, 5.0]), 3.0 * one, 2.0 * one, 4.0 * one, zero, np.zeros(1, np.bool_))
    >>> round(level_within(st, Anchor(0, 0, 0.0, 0.0, 1), 3.0, 1.5), 9)
    2.0

    References
    ----------
    Derived here; on one stretch :func:`~cutwise.physics.motion.profile.reachable_speed`.
    """
    if ramp(st, anchor, ceiling)[2] <= distance:
        return ceiling
    low, high = anchor.speed, ceiling
    for _ in range(100):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        if ramp(st, anchor, middle)[2] <= distance:
            low = middle
        else:
            high = middle
    return low


@compiled
def passing_level(st: Stretches, anchor: Anchor, ceiling: float) -> float:
    r"""Highest level [m/s] of a ramp to which curvature leaves its share of the acceleration.

    On one long arc of curvature :math:`\kappa` it is :math:`v^2 \kappa = a \sqrt{1 - \eta^2}` with the share
    :math:`\eta` = ``SCARCE``.

    Parameters
    ----------
    st, anchor : Stretches, Anchor
        The path, and where the ramp begins.
    ceiling : float
        Highest level asked for [m/s].

    Returns
    -------
    float
        Level [m/s], by bisection. Valid for a share that falls as the level rises.

    Examples
    --------
    2 m/s^2 and 2 1/m: :math:`v^4 = 1 - 0.7^2`.

    >>> one = np.ones(1)
    >>> st = Stretches(np.array([0.0, 5.0]), 3.0 * one, 2.0 * one, 4.0 * one, 2.0 * one, np.zeros(1, np.bool_))
    >>> round(passing_level(st, Anchor(0, 0, 0.0, 0.0, 1), 3.0) ** 4, 9)
    0.51

    References
    ----------
    Derived here from :func:`tangential_acceleration`.
    """
    low, high = anchor.speed, ceiling
    for _ in range(100):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        if ramp(st, anchor, middle, SCARCE)[3] < 0:
            low = middle
        else:
            high = middle
    return low


@compiled
def worth(level: float, time: float, way: float, aim: float, acceleration: float, jerk: float) -> float:
    r"""Time [s] by which a motion that gets to a level after a time and a way is behind one that has its aim at once.

    .. math:: t + T - \bigl(s + \tfrac12 (v + V) T\bigr)/V, \qquad T = T(V - v)

    with :func:`~cutwise.physics.motion.profile.ramp_time`; :math:`t - s/V` where the level is not below the aim.

    Parameters
    ----------
    level, aim : float
        v and V [m/s].
    time, way : float
        t [s] and s [m].
    acceleration, jerk : float
        Limits of the ramp from level to aim [m/s^2], [m/s^3].

    Returns
    -------
    float
        Time [s]. Valid as a comparison of motions that go on alike and have room to reach the aim.

    Examples
    --------
    2 s for 1 m are 1 s behind 1 m/s; up to 2 m/s the ramp takes 1 s and 1.5 m: 3 s for 2.5 m.

    >>> worth(1.0, 2.0, 1.0, 1.0, 2.0, 4.0), worth(1.0, 2.0, 1.0, 2.0, 2.0, 4.0)
    (1.0, 1.75)

    References
    ----------
    Derived here.
    """
    if aim <= level:
        return time - way / aim
    more = ramp_time(aim - level, acceleration, jerk)
    return time + more - (way + 0.5 * (level + aim) * more) / aim
