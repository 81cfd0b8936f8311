r"""Which feed to run where: levels over cells of a path, so that ramps and further blocks are worth what they cost.

A control that changes its speed inside the faster block loses, against one that changes it at once,

.. math:: \Delta T = T_r \frac{v_{hi} - v_{lo}}{2 v_{hi}}

with the time :math:`T_r` of a jerk-limited ramp. The quickest way over cells and levels is a shortest path.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.motion.profile import peak_speed, ramp_distance, ramp_time, reachable_speed

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

PASSES = 1e-6  # relative, by which a level may be above the limit of a cell


class Ramps(NamedTuple):
    """What a change of speed may use."""

    acceleration: float  # [m/s^2]
    jerk: float  # [m/s^3]


@compiled
def ramp_loss(slow: float, fast: float, ramps: Ramps) -> float:
    r"""Time that a change between two speeds loses, :math:`T_r (v_{hi} - v_{lo}) / (2 v_{hi})` [s].

    Parameters
    ----------
    slow, fast : float
        Speeds in any order [m/s]; from rest it is half of the ramp.
    ramps : Ramps
        Limits of the change.

    Notes
    -----
    Valid for ramps inside the faster block that have room there.

    Examples
    --------
    From rest to 2 m/s takes 1.5 s; half of the way is lost:

    >>> ramp_loss(0.0, 2.0, Ramps(2.0, 4.0))
    0.75

    References
    ----------
    Derived here from :func:`~cutwise.physics.motion.profile.ramp_time`.
    """
    low, high = min(slow, fast), max(slow, fast)
    if high <= low:
        return 0.0
    return ramp_time(high - low, ramps.acceleration, ramps.jerk) * (high - low) / (2.0 * high)


def feed_levels(base: float, least: float, most: float, step: float = 1.02) -> FloatArray:
    """Speeds :math:`F_0 s^i` from at or below the least up to at most the greatest [m/s].

    ``base`` F_0, ``least``, ``most`` [m/s], positive; ``step`` s, above 1. Where ``most`` is below all of them, it alone.

    Examples
    --------
    >>> feed_levels(1.0, 0.6, 3.0, 2.0).tolist()
    [0.5, 1.0, 2.0]
    """
    first = math.floor(math.log(least / base) / math.log(step) + 1e-9)
    last = math.floor(math.log(most / base) / math.log(step) + 1e-9)
    if last < first:
        return np.array([most])
    return np.asarray(base * step ** np.arange(first, last + 1), dtype=np.float64)


@compiled
def _table(levels: FloatArray, gain: float, ramps: Ramps) -> FloatArray:
    """What a change from one level to another costs [s]: its ramp, and a block."""
    n = levels.shape[0]
    out = np.zeros((n, n))
    for i in range(n):
        for j in range(n):
            if i != j:
                out[i, j] = ramp_loss(levels[i], levels[j], ramps) + gain
    return out


@compiled
def _quickest(
    length: FloatArray, cap: FloatArray, ends: FloatArray, levels: FloatArray, costs: FloatArray, gain: float, ramps: Ramps
) -> IntArray:  # fmt: skip
    """:func:`quickest_levels` with the table of what changes cost."""
    n, m = length.shape[0], levels.shape[0]
    best, new = np.empty(m), np.empty(m)
    came = np.empty((n, m), np.int16)
    order = np.empty(m, np.int64)
    for i in range(m):
        new[i] = ramp_loss(ends[0], levels[i], ramps)
    for k in range(n):
        best[:] = new
        count = 0
        for i in range(m):  # in the order of what they cost: the first that cannot beat staying ends the search
            if best[i] < math.inf:
                order[count] = i
                count += 1
        ranked = order[:count][np.argsort(best[order[:count]])]
        for i in range(m):
            if i > 0 and levels[i] > cap[k] * (1.0 + PASSES):
                new[i] = math.inf
                came[k, i] = i
                continue
            cost, source = best[i], i
            for j in ranked:
                if best[j] + gain >= cost:
                    break
                if best[j] + costs[j, i] < cost:
                    cost, source = best[j] + costs[j, i], j
            new[i] = cost + length[k] / levels[i]
            came[k, i] = source
    out = np.empty(n, np.int64)
    final = 0
    for i in range(m):
        new[i] += ramp_loss(levels[i], ends[1], ramps)
        if new[i] < new[final]:
            final = i
    for k in range(n - 1, -1, -1):
        out[k] = final
        final = came[k, final]
    return out


@compiled
def quickest_levels(
    length: FloatArray, cap: FloatArray, ends: FloatArray, levels: FloatArray, gain: float,
    ramps: Ramps,
) -> IntArray:  # fmt: skip
    r"""The level of each cell on the quickest way over all of them.

    .. math:: \min \sum_k \frac{\Delta s_k}{F_k} + \sum_{\text{changes}} (\Delta T + g)

    Parameters
    ----------
    length : array (n,)
        Of the cells of one run [m].
    cap : array (n,)
        Highest speed of each [m/s]; the lowest level passes everywhere.
    ends : array (2,)
        Speeds at both ends of the run [m/s], 0: rest.
    levels : array (m,)
        Rising [m/s].
    gain : float
        g, what a change of the feed has to gain [s], as it may take a further block.
    ramps : Ramps
        Limits of a change.

    Returns
    -------
    array (n,)
        Number of the level.

    Notes
    -----
    Exact for these costs; a change is looked at only if it beats staying.

    Examples
    --------
    A short slow cell between two quick ones; where a block costs more than it gains, all are slow.

    >>> cells, caps, ends = np.ones(3), np.array([4.0, 1.0, 4.0]), np.zeros(2)
    >>> [quickest_levels(cells, caps, ends, np.array([1.0, 4.0]), g, Ramps(1e3, 1e6)).tolist() for g in (0.1, 9.0)]
    [[1, 0, 1], [0, 0, 0]]

    References
    ----------
    Derived here; shortest path by dynamic programming (Bellman).
    """
    return _quickest(length, cap, ends, levels, _table(levels, gain, ramps), gain, ramps)


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

    .. math:: v^2 \text{ linear in a cell}, \qquad |\Delta v^2| \le 2 \Delta s \sqrt{a^2 - (v^2 \kappa)^2}

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
        both = math.sqrt(square[k]) + math.sqrt(square[k + 1])
        if both > 0.0:
            time += 2.0 * length[k] / both
        else:  # from rest to rest within one cell
            top = min(math.sqrt(acceleration * length[k]), cap[k])
            time += length[k] / top + top / acceleration
    return time


class Runs(NamedTuple):
    """Parts of a path between places where its speed is given, ``r`` of them over ``n`` cells."""

    first: IntArray  # first cell of each, and the number of cells at the end, shape (r + 1,)
    ends: FloatArray  # speeds at both ends [m/s], shape (r, 2)
    length: FloatArray  # of each cell [m], shape (n,)
    cap: FloatArray  # highest speed of each [m/s], shape (n,)
    bend: FloatArray  # curvature [1/m], shape (n,)
    block: IntArray  # block of the program that each belongs to, rising, shape (n,)


class Rules(NamedTuple):
    """How feeds are written and run."""

    gain: float  # what a further block has to gain [s]
    least_time: float  # of a block [s]
    step: float  # feeds are whole multiples of it [m/s]
    ramps: Ramps


@compiled
def _whole(feed: float, step: float) -> float:
    """A feed rounded down to a multiple of a step; one below the step stays."""
    count = math.floor(feed / step * (1.0 + PASSES))
    return count * step if count >= 1.0 else feed


@compiled
def _long_enough(pieces: Pieces, block: IntArray, feed: FloatArray, least: float) -> None:
    """Pieces of a block that is split which take less than a block may are run as slowly as their slower neighbour."""
    n = feed.shape[0]
    for i in range(n):
        before = i > 0 and block[i - 1] == block[i]
        behind = i < n - 1 and block[i + 1] == block[i]
        if pieces.length[i] >= least * feed[i] or not (before or behind):
            continue
        k = i - 1 if before and (not behind or feed[i - 1] <= feed[i + 1]) else i + 1
        slower = min(feed[i], feed[k])
        feed[i] = feed[k] = slower


@compiled
def scheduled_feeds(runs: Runs, levels: FloatArray, rules: Rules) -> FloatArray:
    """The feed of every cell: quickest levels, then the least limit of each stretch, neighbours merged, short blocks joined.

    Parameters
    ----------
    runs : Runs
        Cells and where their speed is given.
    levels : array (m,)
        Speeds that are looked at, rising [m/s].
    rules : Rules
        How feeds are written and run.

    Returns
    -------
    array (n,)
        Feed [m/s], never above the limit of a cell (but by 1e-6).

    Notes
    -----
    The cost is linear in the cells.

    Examples
    --------
    Ten millimetres, the middle cell slower; feeds are whole millimetres a minute.

    >>> caps = np.full(10, 0.06)
    >>> caps[5] = 0.0400001
    >>> runs = Runs(np.array([0, 10]), np.zeros((1, 2)), np.full(10, 1e-3), caps, np.zeros(10), np.zeros(10, np.int64))
    >>> feeds = scheduled_feeds(runs, feed_levels(0.04, 0.04, 0.1), Rules(1e-6, 2e-3, 1e-3 / 60, Ramps(2e3, 5e6)))
    >>> (60e3 * feeds).round(6).tolist()
    [3600.0, 3600.0, 3600.0, 3600.0, 3600.0, 2400.0, 3600.0, 3600.0, 3600.0, 3600.0]

    References
    ----------
    Derived here.
    """
    out = np.empty(runs.cap.shape[0])
    costs = _table(levels, rules.gain, rules.ramps)
    for r in range(runs.first.shape[0] - 1):
        a, b = runs.first[r], runs.first[r + 1]
        if b - a == 1:
            out[a] = _whole(runs.cap[a], rules.step)
            continue
        level = _quickest(runs.length[a:b], runs.cap[a:b], runs.ends[r], levels, costs, rules.gain, rules.ramps)
        n = b - a
        first, stretch = np.empty(n + 1, np.int64), np.empty(n, np.int64)
        feed, size, number = np.empty(n), 0, 0
        least = np.full(n, math.inf)
        for k in range(n):
            if k > 0 and level[k] != level[k - 1]:
                number += 1
            if k == 0 or level[k] != level[k - 1] or runs.block[a + k] != runs.block[a + k - 1]:
                first[size], stretch[size] = k, number
                size += 1
            least[number] = min(least[number], runs.cap[a + k])
        first[size] = n
        length, bend, block = np.zeros(size), np.empty(size), np.empty(size, np.int64)
        for p in range(size):
            length[p] = runs.length[a + first[p] : a + first[p + 1]].sum()
            bend[p], block[p] = runs.bend[a + first[p]], runs.block[a + first[p]]
            feed[p] = _whole(least[stretch[p]], rules.step)
        pieces = Pieces(length, bend, feed[:size].copy(), stretch[:size].copy())
        merged, _ = merged_feeds(pieces, rules.gain, rules.ramps, runs.ends[r])
        _long_enough(pieces, block, merged, rules.least_time)
        for p in range(size):
            out[a + first[p] : a + first[p + 1]] = merged[p]
    return out


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
