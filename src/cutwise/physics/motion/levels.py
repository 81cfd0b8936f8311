r"""The quickest jerk-limited motion over stretches of different speeds: ramps between levels, the lowest level first.

The motion consists of ramps that begin and end without acceleration, and of levels between them. A level is the highest
speed of the slowest stretch that binds; ramps run over as many stretches as they need. Nothing depends on how a stretch
is cut up, and a stretch that is quicker or slower than its neighbours costs what its own speed costs. What is left out:
the speed is never lowered ahead of a rise to gain a run-up, which would save a little more time on paper.

An interval between two anchors (speed given, no acceleration) is taken apart at the slowest of its stretches. Three
things may be so: no level is reached in it, and it is one ramp up and one down; the level of the slowest stretch is run
there, and the rest on either side is left; or a ramp passes the stretch below its speed, or leaves it exactly with it,
which bounds how high that ramp may go.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.motion.phases import Rows, put_phase, put_ramp
from cutwise.physics.motion.profile import Profile, ramp_time
from cutwise.physics.motion.ramps import (
    SCARCE,
    Anchor,
    Stretches,
    highest_level,
    level_within,
    passing_level,
    ramp,
    worth,
)
from cutwise.physics.motion.slowest import Search, lowest, rekey, search_of

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

_TRIES = 64  # of levels where more than one is possible, three times over, each around the best of the last


class Interval(NamedTuple):
    """Between two anchors; the stretches within are at least as quick as either."""

    first: int  # stretch behind the first anchor
    start: float  # [m]
    v0: float  # [m/s]
    low_cap: float  # highest level of the first ramp [m/s]
    passed: int  # last stretch that only the first ramp passes
    last: int  # stretch before the last anchor
    end: float  # [m]
    v1: float  # [m/s]
    high_cap: float  # highest level of the last ramp [m/s]
    left: int  # first stretch that only the last ramp passes
    level: float  # run at this speed and be done; 0: to be taken apart


@compiled
def _from(it: Interval) -> Anchor:
    return Anchor(it.first, it.last, it.start, it.v0, 1)


@compiled
def _to(it: Interval) -> Anchor:
    return Anchor(it.last, it.first, it.end, it.v1, -1)


@compiled
def _simple(rows: Rows, st: Stretches, it: Interval, peak: float) -> Rows:
    """Up to a level, on at it, and down."""
    au, ju, up, _ = ramp(st, _from(it), peak)
    ad, jd, down, _ = ramp(st, _to(it), peak)
    rows = put_ramp(rows, it.start, it.v0, peak, au, ju)
    run = it.end - it.start - up - down
    if run > 1e-15:
        rows = put_phase(rows, run / peak, it.start + up, peak, 0.0, 0.0)
    return put_ramp(rows, it.end - down, peak, it.v1, ad, jd)


@compiled
def _taken(st: Stretches, it: Interval, level: float) -> float:
    """Length of both ramps to a level [m]."""
    return ramp(st, _from(it), level)[2] + ramp(st, _to(it), level)[2]


@compiled
def _peak(st: Stretches, it: Interval, ceiling: float) -> float:
    """Highest level for which there is room [m/s]; NaN if there is none for any."""
    room = (it.end - it.start) * (1.0 + 1e-12) + 1e-15
    low, high = max(it.v0, it.v1), ceiling
    if not _taken(st, it, low) <= room * (1.0 + 1e-9):
        return math.nan
    if high <= low or _taken(st, it, high) <= room:
        return max(high, low)
    for _ in range(200):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        if _taken(st, it, middle) <= it.end - it.start:
            low = middle
        else:
            high = middle
    return low


@compiled
def _time_to(st: Stretches, it: Interval, level: float, way: int, room: float, both: bool) -> float:
    """Time [s] to a level within ``room`` of one anchor [m], or over the whole interval; infinite if there is no room."""
    v, over = (it.v0, it.v1) if way > 0 else (it.v1, it.v0)
    a, j, own, _ = ramp(st, _from(it) if way > 0 else _to(it), level)
    if not own <= room:
        return math.inf
    time = ramp_time(level - v, a, j) if level > v else 0.0
    if not both:
        return time + (room - own) / level
    a, j, other, _ = ramp(st, _to(it) if way > 0 else _from(it), level)
    run = it.end - it.start - own - other
    if not run >= 0.0:
        return math.inf
    return time + (ramp_time(level - over, a, j) if level > over else 0.0) + run / level


@compiled
def _arc_level(st: Stretches, it: Interval, q: int, ceiling: float, way: int) -> float:
    """Level on an arc that makes the time to its far end shortest: the higher, the less acceleration is left to reach it."""
    far = min(st.at[q + 1], it.end) - it.start if way > 0 else it.end - max(st.at[q], it.start)
    beyond = it.end - it.start - far
    other = ramp(st, _to(it), ceiling) if way > 0 else ramp(st, _from(it), ceiling)
    both = not other[2] <= beyond
    low, high = max(it.v0, it.v1, 1e-6 * ceiling), ceiling
    if math.isinf(_time_to(st, it, high, way, far, both)):
        under, over = low, high
        for _ in range(100):
            middle = 0.5 * (under + over)
            if math.isinf(_time_to(st, it, middle, way, far, both)):
                over = middle
            else:
                under = middle
        high = under
    best = low
    for _ in range(3):
        shortest, width = math.inf, (high - low) / _TRIES
        for i in range(_TRIES + 1):
            level = low + width * i if i < _TRIES else high
            time = _time_to(st, it, level, way, far, both)
            if time < shortest:
                best, shortest = level, time
        low, high = max(best - width, low), min(best + width, high)
    return best


@compiled
def _own_level(st: Stretches, it: Interval, q: int, ceiling: float, way: int) -> tuple[float, bool]:
    """Level for a ramp to which the curvature of a stretch leaves too little [m/s], and whether it is run on that stretch."""
    if st.even[q]:
        level = level_within(st, _from(it), ceiling, max(st.at[q] - it.start, 0.0))
        return level_within(st, _to(it), level, max(it.end - st.at[q + 1], 0.0)), True
    anchor = _from(it) if way > 0 else _to(it)
    far = min(st.at[q + 1], it.end) - it.start if way > 0 else it.end - max(st.at[q], it.start)
    a, j = st.acceleration[q], st.jerk[q]
    own = _arc_level(st, it, q, ceiling, way)
    time = _time_to(st, it, own, way, far, False)
    passing = passing_level(st, anchor, ceiling)
    if passing < max(it.v0, it.v1):
        return own, True
    used, _, length, _ = ramp(st, anchor, passing)
    if length <= far:
        return own, True
    later = worth(passing, ramp_time(passing - anchor.speed, used, j), length, ceiling, a, j)
    return (passing, False) if later < worth(own, time, far, ceiling, a, j) else (own, True)


@compiled
def _push(stack: list, it: Interval) -> None:  # type: ignore[type-arg]
    if it.end > it.start:
        stack.append(it)


@compiled
def _run_at(it: Interval, level: float) -> Interval:
    """The interval, to be run as one ramp up to a level and one down."""
    return Interval(
        it.first, it.start, it.v0, it.low_cap, it.passed, it.last, it.end, it.v1, it.high_cap, it.left, level
    )


@compiled
def _bounded(it: Interval, low_cap: float, passed: int, high_cap: float, left: int) -> Interval:
    """The interval with the levels of its first and last ramp bounded by the stretches that they pass."""
    return Interval(it.first, it.start, it.v0, low_cap, passed, it.last, it.end, it.v1, high_cap, left, it.level)


@compiled
def _begun(it: Interval, last: int, end: float, v1: float) -> Interval:
    """The first part of an interval."""
    return Interval(it.first, it.start, it.v0, it.low_cap, it.passed, last, end, v1, math.inf, last + 1, 0.0)


@compiled
def _ended(it: Interval, first: int, start: float, v0: float) -> Interval:
    """The last part of an interval."""
    return Interval(first, start, v0, math.inf, first - 1, it.last, it.end, it.v1, it.high_cap, it.left, 0.0)


@compiled
def _split(stack: list, st: Stretches, it: Interval, m: int, level: float) -> None:  # type: ignore[type-arg]
    """Run a stretch at a level, and leave what is before and behind it for later."""
    up = ramp(st, _from(it), level)[2]
    down = ramp(st, _to(it), level)[2]
    begin = min(max(st.at[m], it.start + up), it.end)
    end = max(min(st.at[m + 1], it.end - down), it.start)
    if end < begin:  # one of the ramps passes the whole of an arc on its way to the level
        stack.append(_run_at(it, level))
        return
    if end < st.at[m + 1]:  # the last ramp begins within the stretch
        _push(stack, _run_at(_ended(it, m, end, level), level))
    else:
        _push(stack, _ended(it, m + 1, end, level))
    _push(stack, _run_at(_begun(_ended(it, m, begin, level), m, end, level), level))
    if begin > st.at[m]:
        _push(stack, _run_at(_begun(it, m, begin, level), level))
    else:
        _push(stack, _begun(it, m - 1, begin, level))


@compiled
def _capped(stack: list, st: Stretches, it: Interval) -> None:  # type: ignore[type-arg]
    """Take the ramp whose level is bounded; the rest is an interval of its own."""
    if it.low_cap <= it.high_cap:
        level, k = it.low_cap, it.first
        at = min(it.start + ramp(st, _from(it), level)[2], it.end)
        while k < it.last and st.at[k + 1] <= at:
            k += 1
        _push(stack, _ended(it, k, at, level))
        _push(stack, _run_at(_begun(it, k, at, level), level))
    else:
        level, k = it.high_cap, it.last
        at = max(it.end - ramp(st, _to(it), level)[2], it.start)
        while k > it.first and st.at[k] >= at:
            k -= 1
        _push(stack, _run_at(_ended(it, k, at, level), level))
        _push(stack, _begun(it, k, at, level))


@compiled
def _restore(search: Search, st: Stretches, it: Interval) -> None:
    """Stretches that were put aside count again: a level lower than theirs has turned up."""
    for i in range(it.first, min(it.passed, it.last) + 1):
        if not search.done[i]:
            rekey(search, i, st.speed[i])
    for i in range(max(it.left, it.first), it.last + 1):
        if not search.done[i]:
            rekey(search, i, st.speed[i])


@compiled
def _curved(stack: list, search: Search, st: Stretches, it: Interval, ceiling: float, up: int, down: int) -> None:  # type: ignore[type-arg]
    """Where curvature leaves too little for a ramp, bound it, or run its stretch at a level: first the lower of two."""
    q, level, stays, way = -1, math.inf, True, 1
    if up >= 0:
        q = up
        level, stays = _own_level(st, it, up, ceiling, 1)
    if down >= 0:
        other, other_stays = _own_level(st, it, down, ceiling, -1)
        if other < level:
            q, level, stays, way = down, other, other_stays, -1
    if not stays:
        low, high = (level, it.high_cap) if way > 0 else (it.low_cap, level)
        stack.append(_bounded(it, low, it.passed, high, it.left))
        return
    _restore(search, st, it)
    search.done[q] = True
    rekey(search, q, math.inf)
    _split(stack, st, _bounded(it, math.inf, it.first - 1, math.inf, it.last + 1), q, level)


@compiled
def _best_bound(
    st: Stretches, it: Interval, anchor: Anchor, distance: float, limit: float, cap: float, aim: float
) -> float:
    """Level at which a ramp should end that may leave a stretch with its speed at most: between its end and the bound."""
    low, high = max(level_within(st, anchor, limit, distance), it.v0, it.v1), cap
    best = high
    for _ in range(3):
        least, width = math.inf, (high - low) / _TRIES
        for i in range(_TRIES + 1):
            level = low + width * i if i < _TRIES else high
            a, j, length, _ = ramp(st, anchor, level)
            behind = worth(level, ramp_time(level - anchor.speed, a, j), length, aim, a, j)
            if behind < least:
                best, least = level, behind
        low, high = max(best - width, low), min(best + width, high)
    return best


@compiled
def _passed(stack: list, search: Search, st: Stretches, it: Interval, m: int, up: bool, most: float) -> None:  # type: ignore[type-arg]
    """Put a stretch aside that a ramp passes below its speed, and bound the ramp where it would be quicker there."""
    rekey(search, m, math.inf)
    anchor = _from(it) if up else _to(it)
    way = st.at[m + 1] - it.start if up else it.end - st.at[m]
    now = min(it.low_cap if up else it.high_cap, most)
    cap = highest_level(st, anchor, now, way, st.speed[m])
    if cap < now:
        beyond = min(m + 1, it.last) if up else max(m - 1, it.first)
        aim = min(st.speed[beyond], most)
        if aim > cap:
            cap = _best_bound(st, it, anchor, way, st.speed[m], cap, aim)
    elif now == most:
        cap = math.inf
    if up:
        stack.append(_bounded(it, cap, max(it.passed, m), it.high_cap, it.left))
    else:
        stack.append(_bounded(it, it.low_cap, it.passed, cap, min(it.left, m)))


@compiled
def _take_apart(stack: list, rows: Rows, search: Search, st: Stretches, it: Interval, most: float) -> Rows:  # type: ignore[type-arg]
    """One step of an interval: write it, or put its parts on the stack."""
    m = lowest(search, it.first, it.last)
    slowest, cap = search.key[m], min(it.low_cap, it.high_cap)
    ceiling = min(slowest, cap, most)
    _, _, up, bent_up = ramp(st, _from(it), ceiling, SCARCE)
    _, _, down, bent_down = ramp(st, _to(it), ceiling, SCARCE)
    if bent_up >= 0 or bent_down >= 0:
        _curved(stack, search, st, it, ceiling, bent_up, bent_down)
    elif up + down > it.end - it.start or math.isinf(min(slowest, cap)):
        return _simple(rows, st, it, _peak(st, it, ceiling))
    elif slowest > cap:
        _capped(stack, st, it)
    elif it.start + up <= st.at[m + 1] and it.end - down >= st.at[m]:
        search.done[m] = True
        rekey(search, m, math.inf)
        _split(stack, st, it, m, ceiling)
    else:
        _passed(stack, search, st, it, m, it.start + up > st.at[m + 1], most)
    return rows


@compiled
def _phases(st: Stretches, rest: FloatArray) -> FloatArray:
    """Time, position, speed, acceleration and jerk at the start of each phase; the last column is the end."""
    search, most, count = search_of(st.speed), st.speed.max(), st.speed.shape[0]
    rows = Rows(np.empty((5, 256)), 0, 0.0)
    first = 0
    for last in range(count):
        if rest[last] < 0.0:
            continue
        stack = [
            Interval(first, st.at[first], 0.0, math.inf, first - 1, last, st.at[last + 1], 0.0, math.inf, last + 1, 0.0)
        ]
        while len(stack) > 0:
            it = stack.pop()
            if it.level > 0.0:
                rows = _simple(rows, st, it, it.level)
            else:
                rows = _take_apart(stack, rows, search, st, it, most)
        rows = put_phase(rows, rest[last], st.at[last + 1], 0.0, 0.0, 0.0)
        first = last + 1
    rows = put_phase(rows, 1.0, st.at[count], 0.0, 0.0, 0.0)  # type: ignore[arg-type]
    return rows.table[:, : rows.count]


def profile_over(st: Stretches, rest: FloatArray) -> Profile:
    """The motion over stretches, from rest to rest.

    Parameters
    ----------
    st : Stretches
        What each stretch allows.
    rest : ndarray
        Time at rest at the end of each stretch [s], negative where it is run through; the last is not, shape (n,).

    Raises
    ------
    ArithmeticError
        There is no room for a change of speed, which cannot be.

    References
    ----------
    Derived here; ramps as in Biagiotti & Melchiorri 2008, sec. 3.4.
    """
    table = _phases(st, rest)
    if not np.isfinite(table).all():
        raise ArithmeticError("the look-ahead found no motion along the path")
    time, position, speed, acceleration, jerk = table
    return Profile(time, position, speed, acceleration, jerk[:-1])
