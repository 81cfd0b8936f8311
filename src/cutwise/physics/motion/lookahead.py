"""Look-ahead: how fast each block of a path may be run, and the jerk-limited profile over all of them."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.maths.linearc import LineArc, curvature_jumps, turn_angles
from cutwise.physics.motion.levels import profile_over
from cutwise.physics.motion.profile import Limits, Profile
from cutwise.physics.motion.ramps import Stretches

FloatArray = npt.NDArray[np.float64]

TANGENT = 1e-4  # [rad] joints that turn less are run through without a stop
REVERSAL = 1e-3  # [rad] short of half a turn: the path turns back, and every motion stops
_ALIKE = 1e-9  # relative difference of limits that is rounding
_NO_AXES = np.full(3, math.inf)


class AxisLimits(NamedTuple):
    """Limits of each machine axis x, y, z."""

    speed: FloatArray  # [m/s], shape (3,)
    acceleration: FloatArray  # [m/s^2], shape (3,)
    jerk: FloatArray  # [m/s^3], shape (3,)


class Plan(NamedTuple):
    """The motion along a path and what bounded it."""

    profile: Profile
    joint_speed: FloatArray  # [m/s] at the block boundaries, shape (blocks + 1,)
    block_time: FloatArray  # [s] when each block starts, and the end, shape (blocks + 1,)
    stops: int  # full stops between the first and the last point
    curvature_steps: FloatArray  # [m/s^2] jump of the normal acceleration at each inner joint, shape (blocks - 1,)


@compiled
def arc_speed(feed: float, radius: float, acceleration: float, jerk: float) -> float:
    r"""Highest constant speed on an arc, :math:`\min(F, \sqrt{a r}, (j r^2)^{1/3})` [m/s].

    Parameters
    ----------
    feed, acceleration, jerk : float
        Limits along the path [m/s], [m/s^2], [m/s^3].
    radius : float
        Radius of curvature [m], infinite on a line.

    Returns
    -------
    float
        Speed [m/s].

    Notes
    -----
    Valid inside an arc: at its ends the normal acceleration jumps, which no finite jerk allows (:class:`Plan` tells it).

    Examples
    --------
    10 mm at 1 m/s^2: 0.1 m/s. A jerk of 1 m/s^3 leaves the third root of 1e-4.

    >>> [round(arc_speed(1.0, 0.01, 1.0, jerk), 6) for jerk in (1000.0, 1.0)]
    [0.1, 0.046416]

    References
    ----------
    Derived here: :math:`v^2/r` and :math:`v^3/r^2` are the acceleration and jerk of even circular motion.
    """
    if math.isinf(radius):
        return feed
    return min(feed, math.sqrt(acceleration * radius), (jerk * radius * radius) ** (1.0 / 3.0))


@compiled
def clothoid_speed(feed: float, curvature: float, sharpness: float, acceleration: float, jerk: float) -> float:
    r"""Highest constant speed on a curve of changing curvature [m/s].

    .. math:: v \le \min\Bigl(F, \sqrt{a/\kappa}, \bigl(j / \sqrt{\kappa'^2 + \kappa^4}\bigr)^{1/3}\Bigr)

    with the jerk :math:`v^3 \kappa'` across and :math:`v^3 \kappa^2` along the path at the largest curvature.

    Parameters
    ----------
    feed, acceleration, jerk : float
        Limits along the path [m/s], [m/s^2], [m/s^3].
    curvature, sharpness : float
        Largest curvature [1/m], and the size of its change per length [1/m^2], positive.

    Returns
    -------
    float
        Speed [m/s].

    Notes
    -----
    Valid for the whole curve, whose largest curvature it takes: a curve run faster where it is straighter gains time.

    Examples
    --------
    :math:`\kappa' = 3` and :math:`\kappa^2 = 4` make 5, which a jerk of 5 runs at 1 m/s.

    >>> round(clothoid_speed(9.0, 2.0, 3.0, 99.0, 5.0), 9)
    1.0

    References
    ----------
    Derived here: the third derivative of the place by time at constant speed.
    """
    return min(feed, math.sqrt(acceleration / curvature), (jerk / math.hypot(sharpness, curvature**2)) ** (1.0 / 3.0))


@compiled
def _unbent_limits(curve: LineArc, feed: FloatArray, limits: Limits, axes: AxisLimits) -> FloatArray:
    """Speed, acceleration and jerk along each block, were it not for its curvature; shape (blocks, 3)."""
    out = np.empty((feed.shape[0], 3))
    for i in range(feed.shape[0]):
        straight = math.isinf(curve.radius[i]) and curve.sharpness[i] == 0.0
        out[i, 0], out[i, 1], out[i, 2] = min(feed[i], limits.speed), limits.acceleration, limits.jerk
        for axis in range(3):
            along = abs(curve.along[i, axis])
            if straight:
                share = along
            else:  # the largest share that the axis has anywhere on the block
                swings = math.hypot(along, curve.inward[i, axis]) > 1e-12
                share = min((1.0 if swings else 0.0) + abs(curve.climb[i, axis]), 1.0)
            share = max(share, 1e-300)
            out[i, 0] = min(out[i, 0], axes.speed[axis] / share)
            out[i, 1] = min(out[i, 1], axes.acceleration[axis] / share)
            out[i, 2] = min(out[i, 2], axes.jerk[axis] / share)
    return out


@compiled
def _largest_bend(curve: LineArc, i: int) -> float:
    """Largest curvature of a block [1/m]."""
    start = curve.share[i] ** 2 / curve.radius[i]
    return max(start, start + curve.sharpness[i] * curve.length[i])


@compiled
def _block_limits(curve: LineArc, feed: FloatArray, limits: Limits, axes: AxisLimits) -> FloatArray:
    """Speed, acceleration and jerk along each block; shape (blocks, 3)."""
    out = _unbent_limits(curve, feed, limits, axes)
    for i in range(out.shape[0]):
        bend = _largest_bend(curve, i)
        if curve.sharpness[i] != 0.0:
            out[i, 0] = clothoid_speed(out[i, 0], bend, abs(curve.sharpness[i]), out[i, 1], out[i, 2])
        elif bend > 0.0:
            out[i, 0] = arc_speed(out[i, 0], 1.0 / bend, out[i, 1], out[i, 2])
    return out


@compiled
def _alike(a: float, b: float) -> bool:
    return a == b or abs(a - b) <= _ALIKE * max(abs(a), abs(b))


@compiled
def _stretches(
    curve: LineArc, allowed: FloatArray, through: npt.NDArray[np.bool_], rest: FloatArray, count_normal: bool
) -> tuple[Stretches, FloatArray]:
    """Tangent blocks of equal limits as one, and how long the motion rests behind each (negative: it does not)."""
    n = curve.length.shape[0]
    at, speed, acceleration, jerk = np.zeros(n + 1), np.empty(n), np.empty(n), np.empty(n)
    bend, even, pause = np.empty(n), np.zeros(n, np.bool_), np.empty(n)
    k, place = -1, 0.0
    for i in range(n):
        turning = curve.sharpness[i] != 0.0
        own = _largest_bend(curve, i) if count_normal or turning else 0.0
        same = (
            i > 0
            and through[i - 1]
            and turning == even[k]
            and (turning or _alike(own, bend[k]))
            and (turning or _alike(allowed[i, 0], speed[k]))
            and _alike(allowed[i, 1], acceleration[k])
            and _alike(allowed[i, 2], jerk[k])
        )
        if same:
            speed[k] = min(speed[k], allowed[i, 0])
        else:
            k += 1
            speed[k], acceleration[k], jerk[k] = allowed[i, 0], allowed[i, 1], allowed[i, 2]
            bend[k], even[k] = own, turning
        place += curve.length[i]
        at[k + 1] = place
        pause[k] = -1.0 if i < n - 1 and through[i] else rest[i]
    k += 1
    return Stretches(at[: k + 1], speed[:k], acceleration[:k], jerk[:k], bend[:k], even[:k]), pause[:k]


def highest_feeds(curve: LineArc, feed: FloatArray, limits: Limits, axes: AxisLimits | None = None) -> FloatArray:
    """The programmed speed of each block, or less where path or axes cannot be as quick [m/s], shape (blocks,).

    References
    ----------
    Derived here: each axis takes its share of the tangent.
    """
    return np.ascontiguousarray(_unbent_limits(curve, feed, limits, _axes(axes))[:, 0])


def _axes(axes: AxisLimits | None) -> AxisLimits:
    return AxisLimits(_NO_AXES, _NO_AXES, _NO_AXES) if axes is None else axes


def plan(
    curve: LineArc,
    feed: FloatArray,
    limits: Limits,
    stop_at: npt.NDArray[np.bool_] | None = None,
    pause: FloatArray | None = None,
    *,
    axes: AxisLimits | None = None,
    count_normal: bool = True,
    stop_at_corners: bool = True,
) -> Plan:
    """Quickest motion, from rest to rest, that keeps the limits of every block.

    Each block is run at its own feed; changes of speed begin and end without acceleration and run over as many tangent
    blocks as they need, so that cutting a block into short ones changes nothing. The motion stops at corners. The normal
    acceleration jumps at joints of unequal curvature; these steps are reported.

    Parameters
    ----------
    curve : LineArc
        The path [m].
    feed : ndarray
        Programmed speed of each block [m/s], shape (blocks,).
    limits : Limits
        Along the path; infinite ones do not bind.
    stop_at : ndarray, optional
        Inner joints at which the motion stops in any case (G61.1), shape (blocks - 1,); left out: at corners only
        (G61). A blended path (G64) has its blends in the curve already.
    pause : ndarray, optional
        Time at rest at the end of each block (G4) [s], shape (blocks,); a pause makes the motion stop there.
    axes : AxisLimits, optional
        Limits of each machine axis, on top of those of the path.
    count_normal : bool
        Whether the normal acceleration on an arc takes its share of the limit. Without it the limit is exceeded
        wherever the speed changes on an arc; kept for comparison with programs that leave it out.
    stop_at_corners : bool
        Whether the motion stops at corners; without it only where the path turns back. No machine could follow then: it
        tells what the stops cost.

    Raises
    ------
    ValueError
        A limit or a feed is not positive, or nothing bounds the speed, the acceleration or the jerk of a block.

    References
    ----------
    Derived here; ramps as in Biagiotti & Melchiorri 2008, sec. 3.4. Ozcan et al. 2017, sec. 1, name the limits that bind.
    """
    worst = min(*limits, *(float(np.min(values)) for values in axes or ()))
    if worst <= 0.0 or float(np.min(feed)) <= 0.0:
        raise ValueError("feed and the limits of speed, acceleration and jerk must be positive")
    allowed = _block_limits(curve, feed, limits, _axes(axes))
    if not np.isfinite(allowed).all():
        raise ValueError("nothing bounds the speed, the acceleration or the jerk of a block")
    through = turn_angles(curve) < (TANGENT if stop_at_corners else math.pi - REVERSAL)
    if stop_at is not None:
        through &= ~stop_at
    rest = np.zeros(curve.count) if pause is None else pause
    through &= rest[:-1] <= 0.0
    stretches, rests = _stretches(curve, allowed, through, rest, count_normal)
    del allowed
    profile = profile_over(stretches, rests)
    del stretches, rests
    times = time_at(profile, curve.knots)
    speeds = _speed_at(profile, times)
    speeds[0] = speeds[-1] = 0.0
    speeds[1:-1][~through] = 0.0
    steps = curvature_jumps(curve) * speeds[1:-1] ** 2
    return Plan(profile, speeds, times, int(np.sum(~through)), steps)


def time_at(profile: Profile, positions: FloatArray) -> FloatArray:
    """Times [s] at which ascending positions [m] are passed (first passage), by bisection within the phase.

    References
    ----------
    Derived here.
    """
    return _time_at(*profile, np.asarray(positions, dtype=np.float64))


@compiled
def _time_at(
    time: FloatArray,
    position: FloatArray,
    speed: FloatArray,
    acceleration: FloatArray,
    jerk: FloatArray,
    at: FloatArray,
) -> FloatArray:
    out = np.empty(at.shape[0])
    i, last = 0, jerk.shape[0] - 1
    for k in range(at.shape[0]):
        while i < last and position[i + 1] < at[k]:
            i += 1
        p, v, a, j = position[i], speed[i], acceleration[i], jerk[i]
        low, high = 0.0, time[i + 1] - time[i]
        for _ in range(80):
            t = 0.5 * (low + high)
            if t <= low or t >= high:
                break
            if p + t * (v + t * (a / 2.0 + t * j / 6.0)) < at[k]:
                low = t
            else:
                high = t
        out[k] = time[i] + high
    return out


def _speed_at(profile: Profile, times: FloatArray) -> FloatArray:
    i = np.clip(np.searchsorted(profile.time, times, side="left") - 1, 0, profile.jerk.shape[0] - 1)
    dt = times - profile.time[i]
    speeds = profile.speed[i] + dt * (profile.acceleration[i] + dt * profile.jerk[i] / 2.0)
    return np.where(np.abs(speeds) < 1e-9, 0.0, speeds)


def time_without_limits(curve: LineArc, feed: FloatArray) -> float:
    """Time [s] if every block ran at its programmed speed from end to end."""
    return float(np.sum(curve.length / feed))
