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
from cutwise.physics.motion.feed_stretches import Pieces, Ramps, merged_feeds
from cutwise.physics.motion.profile import ramp_time

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

PASSES = 1e-6  # relative, by which a level may be above the limit of a cell


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
    Valid for limits that are above the lowest level.
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
