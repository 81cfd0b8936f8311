"""Look-ahead: how fast each block of a path may be run, and the jerk-limited profile over all of them."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.maths.linearc import LineArc, curvature_jumps, turn_angles
from cutwise.physics.motion.profile import Limits, Profile, chain, ramp_distance, ramp_time, reachable_speed, stretch

FloatArray = npt.NDArray[np.float64]

TANGENT = 1e-4  # [rad] joints that turn less are run through without a stop
NEAR_SPEED = 0.8  # short blocks whose speed limits differ by less than this ratio are run as one stretch


class AxisLimits(NamedTuple):
    """Limits of each machine axis x, y, z."""

    speed: FloatArray  # [m/s], shape (3,)
    acceleration: FloatArray  # [m/s^2], shape (3,)
    jerk: FloatArray  # [m/s^3], shape (3,)


class Stretch(NamedTuple):
    """Tangent blocks run as one: zero tangential acceleration at its ends only."""

    length: float  # [m]
    limits: Limits  # along the path, without the share of the curvature
    radius: float  # smallest radius of curvature [m], infinite on lines
    even: bool  # run at one speed: where the curvature changes, all of the jerk is needed to turn


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
    """
    if math.isinf(radius):
        return feed
    return min(feed, math.sqrt(acceleration * radius), (jerk * radius * radius) ** (1.0 / 3.0))


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
    """
    return min(feed, math.sqrt(acceleration / curvature), (jerk / math.hypot(sharpness, curvature**2)) ** (1.0 / 3.0))


@compiled
def tangential_acceleration(speed: float, radius: float, acceleration: float) -> float:
    r"""Tangential acceleration left on an arc that is run at no more than ``speed``.

    .. math:: a_t \le \sqrt{a^2 - (v^2/r)^2}

    ``speed`` [m/s], ``radius`` of curvature [m] (infinite on a line), ``acceleration`` [m/s^2]; zero where the arc
    leaves nothing.
    """
    if math.isinf(radius):
        return acceleration
    normal = speed * speed / radius
    return math.sqrt(max(acceleration * acceleration - normal * normal, 0.0))


@compiled
def _speed_change_length(v0: float, v1: float, radius: float, acceleration: float, jerk: float) -> float:
    """Length [m] that the change of speed takes on an arc or line; infinite if the curvature leaves nothing for it."""
    if v0 == v1:
        return 0.0
    left = tangential_acceleration(max(v0, v1), radius, acceleration)
    return ramp_distance(v0, v1, left, jerk) if left > 0.0 else math.inf


@compiled
def _next_speed(v0: float, length: float, ceiling: float, radius: float, acceleration: float, jerk: float) -> float:
    """Highest speed [m/s], at most ``ceiling``, at the far end of a stretch that is entered at ``v0``."""
    if math.isinf(radius):
        return reachable_speed(v0, length, ceiling, acceleration, jerk)
    if ceiling <= v0 or _speed_change_length(v0, ceiling, radius, acceleration, jerk) <= length:
        return ceiling
    low, high = v0, ceiling
    for _ in range(100):
        middle = 0.5 * (low + high)
        if _speed_change_length(v0, middle, radius, acceleration, jerk) <= length:
            low = middle
        else:
            high = middle
    return low


@compiled
def _time_with_peak(peak: float, length: float, v0: float, v1: float, radius: float, a: float, j: float) -> float:
    """Time [s] over an arc at a given peak speed; infinite if the arc is too short for it."""
    run = _speed_change_length(v0, peak, radius, a, j) + _speed_change_length(peak, v1, radius, a, j)
    if not run <= length:
        return math.inf
    total = (length - run) / peak
    left = tangential_acceleration(peak, radius, a)
    if v0 != peak:
        total += ramp_time(peak - v0, left, j)
    if v1 != peak:
        total += ramp_time(peak - v1, left, j)
    return total


@compiled
def _best_peak(
    low: float, high: float, length: float, v0: float, v1: float, radius: float, a: float, j: float
) -> float:
    """The best of 65 peak speeds between two [m/s]."""
    best, shortest = low, math.inf
    for i in range(65):
        peak = low + (high - low) * i / 64.0 if i < 64 else high
        time = _time_with_peak(peak, length, v0, v1, radius, a, j)
        if time < shortest:
            best, shortest = peak, time
    return best


@compiled
def _arc_peak(length: float, v0: float, v1: float, ceiling: float, radius: float, a: float, j: float) -> float:
    """Peak speed [m/s] on an arc that makes its time shortest (a higher peak leaves less acceleration to reach it)."""
    low = max(v0, v1, 1e-6 * ceiling)
    highest = max(ceiling, low)
    if math.isinf(_time_with_peak(highest, length, v0, v1, radius, a, j)):
        under, over = low, highest
        for _ in range(100):
            middle = 0.5 * (under + over)
            if math.isinf(_time_with_peak(middle, length, v0, v1, radius, a, j)):
                over = middle
            else:
                under = middle
        highest = under
    best = _best_peak(low, highest, length, v0, v1, radius, a, j)
    width = (highest - low) / 64.0
    return _best_peak(max(best - width, low), min(best + width, highest), length, v0, v1, radius, a, j)


def block_limits(curve: LineArc, feed: FloatArray, limits: Limits, axes: AxisLimits | None = None) -> list[Limits]:
    r"""Limits along each block: those of the path, and of the axes :math:`\min_i(\mathrm{lim}_i/|d_i|)` on a line.

    On an arc the weakest of the axes that it moves counts. ``feed`` is the programmed speed of each block [m/s], shape
    (blocks,); infinite for a rapid move.
    """
    out = []
    bends = _bends(curve)
    for i in range(curve.count):
        speed, acceleration, jerk = _unbent_limits(curve, i, float(feed[i]), limits, axes)
        if curve.sharpness[i]:
            bent, sharp = 1.0 / bends[i], abs(float(curve.sharpness[i]))
            speed = clothoid_speed(speed, bent, sharp, acceleration, jerk)
        else:
            speed = arc_speed(speed, bends[i], acceleration, jerk)
        out.append(Limits(speed, acceleration, jerk))
    return out


def _unbent_limits(curve: LineArc, i: int, feed: float, limits: Limits, axes: AxisLimits | None) -> Limits:
    """Limits along a block, were it not for its curvature."""
    speed, acceleration, jerk = min(feed, limits.speed), limits.acceleration, limits.jerk
    if axes is not None:
        use = np.maximum(_axis_use(curve, i), 1e-300)
        speed = min(speed, float(np.min(axes.speed / use)))
        acceleration = min(acceleration, float(np.min(axes.acceleration / use)))
        jerk = min(jerk, float(np.min(axes.jerk / use)))
    return Limits(speed, acceleration, jerk)


def highest_feeds(curve: LineArc, feed: FloatArray, limits: Limits, axes: AxisLimits | None = None) -> FloatArray:
    """The programmed speed of each block, or less where path or axes cannot be as quick [m/s], shape (blocks,)."""
    return np.array([_unbent_limits(curve, i, float(feed[i]), limits, axes).speed for i in range(curve.count)])


def _axis_use(curve: LineArc, i: int) -> FloatArray:
    """Largest share of the path's motion that each axis has on a block."""
    if curve.straight[i]:
        return np.abs(curve.along[i])
    swings = np.hypot(curve.along[i], curve.inward[i]) > 1e-12
    return np.minimum(swings + np.abs(curve.climb[i]), 1.0)


def _bends(curve: LineArc) -> list[float]:
    """Radius of curvature of each block [m]."""
    return [1.0 / bent if bent else math.inf for bent in curve.curvature.tolist()]


def _merged(
    curve: LineArc, limits: list[Limits], tangent: npt.NDArray[np.bool_], count_normal: bool
) -> tuple[list[Stretch], list[int]]:
    """Stretches, and the number of the first block of each."""
    bends = _bends(curve) if count_normal else [math.inf] * curve.count
    parts: list[Stretch] = []
    first: list[int] = []
    for i, own in enumerate(limits):
        radius = bends[i]
        new = Stretch(float(curve.length[i]), own, radius, bool(curve.sharpness[i]))
        if parts and tangent[i - 1] and _run_as_one(parts[-1], new):
            old = parts[-1]
            low = Limits(*(min(a, b) for a, b in zip(old.limits, own, strict=True)))
            parts[-1] = Stretch(old.length + new.length, low, min(old.radius, radius), new.even)
        else:
            parts.append(new)
            first.append(i)
    return parts, first


def _run_as_one(a: Stretch, b: Stretch) -> bool:
    if a.even or b.even:
        return a.even and b.even
    same = all(math.isclose(x, y, rel_tol=1e-9) for x, y in zip(a.limits, b.limits, strict=True))
    if same and abs(1.0 / a.radius - 1.0 / b.radius) <= 1e-9 / b.radius:
        return True
    near = min(a.limits.speed, b.limits.speed) >= NEAR_SPEED * max(a.limits.speed, b.limits.speed)
    return near and _is_short(a) and _is_short(b)


def _is_short(part: Stretch) -> bool:
    """Too short to reach its speed from rest and stop again within it."""
    limits = part.limits
    return part.length < 2.0 * ramp_distance(0.0, limits.speed, limits.acceleration, limits.jerk)


def plan(
    curve: LineArc,
    feed: FloatArray,
    limits: Limits,
    stop_at: npt.NDArray[np.bool_] | None = None,
    pause: FloatArray | None = None,
    *,
    axes: AxisLimits | None = None,
    count_normal: bool = True,
) -> Plan:
    """Quickest motion, from rest to rest, that keeps the limits of every block.

    Tangent blocks of equal limits are merged, so that cutting a line into short blocks changes nothing; a backward and
    a forward pass then bound the speed at the joints. The motion stops at corners. The normal acceleration jumps at
    joints of unequal curvature; these steps are reported.

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
        (G61). A blended path (G64 P) has its blends in the curve already.
    pause : ndarray, optional
        Time at rest at the end of each block (G4) [s], shape (blocks,); a pause makes the motion stop there.
    axes : AxisLimits, optional
        Limits of each machine axis, on top of those of the path.
    count_normal : bool
        Whether the normal acceleration on an arc takes its share of the limit. Without it the limit is exceeded
        wherever the speed changes on an arc; kept for comparison with programs that leave it out.

    Raises
    ------
    ValueError
        A limit or a feed is not positive.
    """
    worst = min(*limits, *(float(np.min(values)) for values in axes or ()))
    if worst <= 0.0 or float(np.min(feed)) <= 0.0:
        raise ValueError("feed and the limits of speed, acceleration and jerk must be positive")
    tangent = turn_angles(curve) < TANGENT
    if stop_at is not None:
        tangent &= ~stop_at
    rest = np.zeros(curve.count) if pause is None else pause
    tangent &= rest[:-1] <= 0.0
    parts, first = _merged(curve, block_limits(curve, feed, limits, axes), tangent, count_normal)
    joint = _joint_speeds(parts, [bool(tangent[i - 1]) for i in first[1:]])
    phases: list[tuple[float, float]] = []
    anchors: list[tuple[int, float, float]] = []
    place = 0.0
    last_blocks = [*(i - 1 for i in first[1:]), curve.count - 1]
    for part, last, v0, v1 in zip(parts, last_blocks, joint[:-1], joint[1:], strict=True):
        phases += stretch(part.length, v0, v1, _stretch_limits(part, v0, v1))
        place += part.length
        anchors.append((len(phases), place, v1))
        if rest[last] > 0.0:
            phases.append((float(rest[last]), 0.0))
            anchors.append((len(phases), place, 0.0))
    profile = chain(phases, 0.0, anchors)
    times = time_at(profile, curve.knots)
    speeds = _speed_at(profile, times)
    steps = curvature_jumps(curve) * speeds[1:-1] ** 2
    stops = int(np.sum(speeds[1:-1] <= 1e-9))
    return Plan(profile, speeds, times, stops, steps)


def _stretch_limits(part: Stretch, v0: float, v1: float) -> Limits:
    if part.even:
        return part.limits._replace(speed=v0)
    if math.isinf(part.radius):
        return part.limits
    own = part.limits
    peak = _arc_peak(part.length, v0, v1, own.speed, part.radius, own.acceleration, own.jerk)
    left = tangential_acceleration(peak, part.radius, part.limits.acceleration)
    if v0 == v1 == peak:
        left = part.limits.acceleration  # unused: the speed stays
    return Limits(peak, left, part.limits.jerk)


def _joint_speeds(parts: list[Stretch], tangent: list[bool]) -> list[float]:
    """Highest speeds at the ends of the stretches that can be kept: a backward pass, then a forward pass."""
    n = len(parts)
    v = [0.0] * (n + 1)
    for i in range(1, n):
        v[i] = min(parts[i - 1].limits.speed, parts[i].limits.speed) if tangent[i - 1] else 0.0
    for i in range(n - 1, -1, -1):
        v[i] = min(v[i], _reached(parts[i], v[i + 1], v[i]))
    for i in range(n):
        v[i + 1] = min(v[i + 1], _reached(parts[i], v[i], v[i + 1]))
    return v


def _reached(part: Stretch, v0: float, ceiling: float) -> float:
    """Highest speed at the far end of a stretch that is entered at ``v0`` [m/s]."""
    if part.even:
        return min(v0, ceiling)
    return float(_next_speed(v0, part.length, ceiling, part.radius, *part.limits[1:]))


def time_at(profile: Profile, positions: FloatArray) -> FloatArray:
    """Times [s] at which ascending positions [m] are passed (first passage), by bisection within the phase."""
    i = np.clip(np.searchsorted(profile.position, positions, side="left") - 1, 0, profile.jerk.shape[0] - 1)
    low, high = np.zeros(positions.shape), profile.time[i + 1] - profile.time[i]
    p, v, a, j = profile.position[i], profile.speed[i], profile.acceleration[i], profile.jerk[i]
    for _ in range(80):
        t = 0.5 * (low + high)
        ahead = p + t * (v + t * (a / 2.0 + t * j / 6.0)) < positions
        low, high = np.where(ahead, t, low), np.where(ahead, high, t)
    return profile.time[i] + high


def _speed_at(profile: Profile, times: FloatArray) -> FloatArray:
    i = np.clip(np.searchsorted(profile.time, times, side="left") - 1, 0, profile.jerk.shape[0] - 1)
    dt = times - profile.time[i]
    speeds = profile.speed[i] + dt * (profile.acceleration[i] + dt * profile.jerk[i] / 2.0)
    speeds[0], speeds[-1] = 0.0, 0.0
    return np.where(np.abs(speeds) < 1e-9, 0.0, speeds)


def time_without_limits(curve: LineArc, feed: FloatArray) -> float:
    """Time [s] if every block ran at its programmed speed from end to end."""
    return float(np.sum(curve.length / feed))
