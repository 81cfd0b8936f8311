"""How long feeds take: stretches of one feed each, with ramps inside the faster one, and what neighbours gain from their own.

What a schedule of feeds (:mod:`cutwise.physics.motion.schedule`) is held against, and below which none comes.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.motion.profile import peak_speed, ramp_distance, ramp_time, reachable_speed

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


class Ramps(NamedTuple):
    """What a change of speed may use."""

    acceleration: float  # [m/s^2]
    jerk: float  # [m/s^3]


@compiled
def _joints(
    length: FloatArray, speed: FloatArray, acceleration: FloatArray, jerk: float, ends: FloatArray
) -> FloatArray:
    """Speeds at the joints of stretches [m/s]: the lesser of both, as far as each can be braked to and reached."""
    n = length.shape[0]
    out = np.empty(n + 1)
    out[0], out[n] = min(ends[0], speed[0]), min(ends[1], speed[n - 1])
    for i in range(1, n):
        out[i] = min(speed[i - 1], speed[i])
    for i in range(n - 1, 0, -1):
        out[i] = min(out[i], max(out[i + 1], reachable_speed(out[i + 1], length[i], out[i], acceleration[i], jerk)))
    for i in range(1, n):
        out[i] = min(
            out[i], max(out[i - 1], reachable_speed(out[i - 1], length[i - 1], out[i], acceleration[i - 1], jerk))
        )
    return out


@compiled
def stretch_times(
    length: FloatArray, speed: FloatArray, acceleration: FloatArray, jerk: float, ends: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Time of each stretch [s] and the speeds at their joints [m/s], every change of speed inside the faster stretch.

    Parameters
    ----------
    length, speed, acceleration : array (n,)
        Of each stretch [m], highest [m/s], along the path at that speed [m/s^2].
    jerk : float
        [m/s^3]
    ends : array (2,)
        Speeds at both ends [m/s].

    Notes
    -----
    Valid for changes that begin and end without acceleration at the joints; a ramp that a stretch has no room for lowers
    its joints. Backward, then forward.

    Examples
    --------
    3 m from rest to rest with 1.5 m for either ramp, at once or in two stretches with a slower second one:

    >>> one, rest = np.ones(1), np.zeros(2)
    >>> stretch_times(3 * one, 9 * one, 2 * one, 4.0, rest)[0].tolist()
    [3.0]
    >>> times, joints = stretch_times(np.array([3.0, 1.5]), np.array([2.0, 2.0]), 2 * np.ones(2), 4.0, rest)
    >>> joints.tolist(), times.tolist()
    ([0.0, 2.0, 0.0], [2.25, 1.5])

    References
    ----------
    Standard look-ahead; ramps as in Biagiotti & Melchiorri 2008, sec. 3.4.
    """
    joints = _joints(length, speed, acceleration, jerk, ends)
    out = np.empty(length.shape[0])
    for i in range(length.shape[0]):
        v0, v1, a = joints[i], joints[i + 1], acceleration[i]
        top = peak_speed(length[i], v0, v1, speed[i], a, jerk)
        if math.isnan(top):
            top = max(v0, v1)
        run = ramp_distance(v0, top, a, jerk) + ramp_distance(top, v1, a, jerk)
        time = ramp_time(top - v0, a, jerk) + ramp_time(v1 - top, a, jerk)
        out[i] = time + max(length[i] - run, 0.0) / top if top > 0.0 else time
    return out, joints


class Pieces(NamedTuple):
    """Parts of the blocks of a run, each with one feed, ``n`` of them."""

    length: FloatArray  # [m], shape (n,)
    bend: FloatArray  # curvature [1/m], 0 on a line, shape (n,)
    feed: FloatArray  # [m/s], shape (n,)
    stretch: IntArray  # pieces of one number have one feed: 0, 1, 2 ... in their order, shape (n,)


@compiled
def _window_time(pieces: Pieces, feed: FloatArray, first: int, last: int, ends: FloatArray, ramps: Ramps) -> float:
    """Planned time of some pieces at given feeds, like neighbours joined [s]."""
    n = last - first
    length, speed, acceleration = np.empty(n), np.empty(n), np.empty(n)
    count = 0
    for i in range(n):
        v, k = feed[i], pieces.bend[first + i]
        normal = v * v * k
        a = math.sqrt(max(ramps.acceleration * ramps.acceleration - normal * normal, 0.0))
        a = max(a, 1e-3 * ramps.acceleration)
        if count > 0 and speed[count - 1] == v and acceleration[count - 1] == a:
            length[count - 1] += pieces.length[first + i]
        else:
            length[count], speed[count], acceleration[count] = pieces.length[first + i], v, a
            count += 1
    times, _ = stretch_times(length[:count], speed[:count], acceleration[:count], ramps.jerk, ends)
    return float(times.sum())


_SIDE = 3  # stretches on either side of a pair that are planned again with it


@compiled
def _merged_once(pieces: Pieces, gain: float, ramps: Ramps, ends: FloatArray) -> tuple[FloatArray, IntArray, int]:
    """One pass over all neighbours; feeds and stretches behind it, and how many pairs were merged."""
    n = pieces.length.shape[0]
    feed, stretch = pieces.feed.copy(), pieces.stretch.copy()
    starts = np.empty(n + 1, np.int64)
    count = 0
    for i in range(n):
        if i == 0 or stretch[i] != stretch[i - 1]:
            starts[count] = i
            count += 1
    starts[count] = n
    kept = np.empty(count + 1, np.int64)  # first pieces of the stretches that stay
    kept[0] = 0
    done, merged = 1, 0
    for s in range(1, count):
        here, middle, behind = kept[done - 1], starts[s], starts[s + 1]
        first = kept[max(done - 1 - _SIDE, 0)]
        last = starts[min(s + 1 + _SIDE, count)]
        border = np.empty(2)
        border[0] = ends[0] if first == 0 else min(feed[first - 1], feed[first])
        border[1] = ends[1] if last == n else min(feed[last - 1], feed[last])
        now = feed[first:last].copy()
        before = _window_time(pieces, now, first, last, border, ramps)
        slower = min(feed[here], feed[middle])
        now[here - first : behind - first] = slower
        after = _window_time(pieces, now, first, last, border, ramps)
        if after - before <= 0.5 * gain:
            feed[here:behind] = slower
            merged += 1
        else:
            kept[done] = middle
            done += 1
    kept[done] = n
    for k in range(done):
        stretch[kept[k] : kept[k + 1]] = k
    return feed, stretch, merged


@compiled
def merged_feeds(pieces: Pieces, gain: float, ramps: Ramps, ends: FloatArray) -> tuple[FloatArray, IntArray]:
    """Neighbours at the lower feed of both while the planned time grows by no more than half of a gain, again and again.

    Parameters
    ----------
    pieces : Pieces
        A run.
    gain : float
        What a further block has to gain [s].
    ramps : Ramps
        Limits of a change.
    ends : array (2,)
        Speeds at both ends of the run [m/s].

    Returns
    -------
    tuple
        Feeds [m/s] and numbers of the stretches of all pieces.

    Notes
    -----
    Valid for feeds within the limits of their own stretches.
    Local: three stretches on either side of a pair are planned again, from and to the feeds beyond them.

    Examples
    --------
    Half a quick millimetre between two slow ones gains nothing that the ramps do not take.

    >>> three = Pieces(np.full(3, 5e-4), np.zeros(3), np.array([0.04, 0.2, 0.04]), np.arange(3))
    >>> feeds, stretches = merged_feeds(three, 1e-3, Ramps(2.0, 50.0), np.array([0.04, 0.04]))
    >>> feeds.tolist(), stretches.tolist()
    ([0.04, 0.04, 0.04], [0, 0, 0])

    References
    ----------
    Derived here.
    """
    feed, stretch = pieces.feed, pieces.stretch
    for _ in range(50):
        feed, stretch, merged = _merged_once(Pieces(pieces.length, pieces.bend, feed, stretch), gain, ramps, ends)
        if merged == 0:
            break
    return feed, stretch


@compiled
def time_bound(length: FloatArray, cap: FloatArray, bend: FloatArray, acceleration: float, ends: FloatArray) -> float:
    r"""Time below which no schedule comes: each cell at its own limit, acceleration alone, no jerk and no blocks [s].

    .. math:: v \le v_k \text{ in a cell}, \qquad |\Delta v^2| \le 2 \Delta s \sqrt{a^2 - (v^2 \kappa)^2}

    Parameters
    ----------
    length, cap : array (n,)
        Of the cells of a run [m], highest speeds [m/s].
    bend : array (n,)
        Curvature [1/m], 0 on a line.
    acceleration : float
        [m/s^2]
    ends : array (2,)
        Speeds at both ends [m/s].

    Notes
    -----
    Valid for limits that hold for whole cells; at a border the lesser of both counts. Backward, then forward.

    Examples
    --------
    4 m from rest to rest at 1 m/s^2 in many cells: twice two seconds.

    >>> round(time_bound(np.full(4000, 1e-3), np.full(4000, 9.0), np.zeros(4000), 1.0, np.zeros(2)), 6)
    4.0

    References
    ----------
    Derived here; forward-backward pass, as for time-optimal motion along a path (Bobrow et al. 1985).
    """
    n = length.shape[0]
    square = np.empty(n + 1)
    square[0], square[n] = min(ends[0], cap[0]) ** 2, min(ends[1], cap[n - 1]) ** 2
    for k in range(1, n):
        square[k] = min(cap[k - 1], cap[k]) ** 2
    for back in (True, False):
        for step in range(n):
            k = n - 1 - step if back else step
            here, there = (k + 1, k) if back else (k, k + 1)
            q, d = (2.0 * length[k] * bend[k]) ** 2, 2.0 * length[k] * acceleration
            begun = square[here]  # the quicker end keeps the limit: x = begun + 2 ds sqrt(a^2 - (x bend)^2)
            room = begun * begun - (1.0 + q) * (begun * begun - d * d)
            square[there] = min(square[there], (begun + math.sqrt(max(room, 0.0))) / (1.0 + q))
    time = 0.0
    for k in range(n):
        begun, left = square[k], square[k + 1]
        top = max(min(cap[k] ** 2, 0.5 * (begun + left) + acceleration * length[k]), begun, left)
        quick, ramps = math.sqrt(top), (2.0 * top - begun - left) / (2.0 * acceleration)  # way of both changes of speed
        time += (2.0 * quick - math.sqrt(begun) - math.sqrt(left)) / acceleration + max(length[k] - ramps, 0.0) / quick
    return time


@compiled
def anticipated(cap: FloatArray, length: FloatArray, ramps: Ramps) -> FloatArray:
    """Limits of cells for a control that changes its speed behind the border of a block: slow cells begin a ramp earlier.

    Parameters
    ----------
    cap, length : array (n,)
        Highest speeds [m/s], lengths of the cells [m].
    ramps : Ramps
        Limits of a change.

    Notes
    -----
    Valid for ramps that begin at the border and end without acceleration.

    Examples
    --------
    From 1 to 0.5 m/s at 1 m/s^2 takes 0.375 m and a little: four cells of 0.1 m.

    >>> anticipated(np.array([1.0] * 6 + [0.5]), np.full(7, 0.1), Ramps(1.0, 1e6)).tolist()
    [1.0, 1.0, 0.5, 0.5, 0.5, 0.5, 0.5]

    References
    ----------
    Derived here.
    """
    out, n = cap.copy(), cap.shape[0]
    highest = cap.max()
    for m in range(n):
        farthest = ramp_distance(highest, cap[m], ramps.acceleration, ramps.jerk)
        away, k = 0.0, m - 1
        while k >= 0 and away < farthest:
            if cap[k] > cap[m] and away < ramp_distance(cap[k], cap[m], ramps.acceleration, ramps.jerk):
                out[k] = min(out[k], cap[m])
            away += length[k]
            k -= 1
    return out
