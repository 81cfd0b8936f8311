"""Numbers at given places of an ascending order, of more numbers than memory should hold: exact, in bounded room."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Places = Sequence[int] | NDArray[np.integer[Any]]
Pieces = Callable[[], Iterable[FloatArray]]
"""All numbers, piece by piece, from the first on at each call."""

ROOM = 2**20
"""Numbers that are held at a time (8 MB); counts, too."""

_SIGN = np.uint64(1 << 63)
_LEAST_BINS = 16


def in_order(pieces: Pieces, places: Callable[[int], Places], room: int | None = None) -> tuple[FloatArray, int]:
    """The finite numbers at some places of their ascending order, and how many there are.

    Parameters
    ----------
    pieces : callable
        Gives all numbers, piece by piece.
    places : callable
        From how many are finite to the places asked for, from 0 on.
    room : int, optional
        Numbers that are held at a time, :data:`ROOM` if left out; what is told does not depend on it.

    Notes
    -----
    Up to ``room`` numbers are sorted. Of more, their places on the line of all floating-point numbers are counted in
    bins; the bins that hold a place asked for are divided again, until what they hold can be sorted.

    Examples
    --------
    >>> values, count = in_order(lambda: iter([np.array([3.0, 1.0]), np.array([2.0, np.nan])]), lambda n: [0, n - 1], 2)
    >>> values.tolist(), count
    ([1.0, 3.0], 3)
    """
    room = ROOM if room is None else room
    kept, ends, count = _looked(pieces, room)
    asked = np.asarray(places(count) if count else [], dtype=np.int64)
    if kept is not None:
        return np.sort(kept)[asked], count
    known = _Divided(*ends).found(pieces, np.unique(asked), room)
    return np.array([known[int(place)] for place in asked]), count


def percentiles(pieces: Pieces, percents: Sequence[float], room: int | None = None) -> FloatArray | None:
    """Percentiles of the finite numbers, linear between two of them, as ``numpy.percentile`` has them; None of none."""
    share = np.asarray(percents) / 100.0

    def both(count: int) -> Sequence[int]:
        low = np.floor(share * (count - 1)).astype(int)
        return np.concatenate([low, np.minimum(low + 1, count - 1)]).tolist()

    values, count = in_order(pieces, both, room)
    if not count:
        return None
    low, high = values[: share.size], values[share.size :]
    part = share * (count - 1) - np.floor(share * (count - 1))
    step = high - low
    return np.where(part >= 0.5, high - step * (1.0 - part), low + step * part)


def finite(values: np.ndarray) -> FloatArray:
    """The finite numbers among some."""
    return values[np.isfinite(values)]


def _looked(pieces: Pieces, room: int) -> tuple[FloatArray | None, tuple[float, float], int]:
    """All finite numbers if there is room for them, their ends, how many."""
    kept: list[FloatArray] | None = []
    count, low, high = 0, np.inf, -np.inf
    for piece in pieces():
        values = finite(piece)
        if not values.size:
            continue
        count += values.size
        low, high = min(low, float(values.min())), max(high, float(values.max()))
        if kept is not None:
            kept.append(values)
            kept = kept if count <= room else None
    return (None if kept is None else np.concatenate([np.empty(0), *kept])), (low, high), count


def _keys(values: FloatArray) -> NDArray[np.uint64]:
    """Whole numbers in the order of floating-point ones."""
    bits = np.ascontiguousarray(values).view(np.uint64)
    return np.where(bits & _SIGN, ~bits, bits | _SIGN)


def _value(key: int) -> float:
    bits = np.uint64(key)
    plain = bits & ~_SIGN if bits & _SIGN else ~bits
    return float(np.array([plain], dtype=np.uint64).view(np.float64)[0])


class _Divided:
    """Stretches of the line of all numbers that hold places asked for; more finely at every pass."""

    def __init__(self, low: float, high: float) -> None:
        first, last = (int(_keys(np.array([end]))[0]) for end in (low, high))
        self._stretches = {first: (last, 0)}  # first key: last key, numbers below

    def found(self, pieces: Pieces, places: NDArray[np.int64], room: int) -> dict[int, float]:
        """The number at each place."""
        known: dict[int, float] = {}
        rest = [int(place) for place in places]
        while rest:
            rest, inside = self._pass(pieces, rest, known, room)
            if rest and inside <= room:
                self._sorted(pieces, rest, known)
                break
        return known

    def _pass(self, pieces: Pieces, rest: list[int], known: dict[int, float], room: int) -> tuple[list[int], int]:
        """Divide all stretches; the places that are not known yet, and how many numbers lie in theirs."""
        firsts = sorted(self._stretches)
        first = np.array(firsts, dtype=np.uint64)
        last = np.array([self._stretches[one][0] for one in firsts], dtype=np.uint64)
        below = np.array([self._stretches[one][1] for one in firsts])
        bins = max(_LEAST_BINS, room // len(firsts))
        width = (last - first) // np.uint64(bins) + np.uint64(1)
        counts = np.zeros(len(firsts) * bins, dtype=np.int64)
        for keys, at in self._within(pieces, first, last):
            slots = at * bins + ((keys - first[at]) // width[at]).astype(np.int64)
            counts += np.bincount(slots, minlength=counts.size)
        summed = counts.reshape(-1, bins).cumsum(axis=1)
        finer: dict[int, tuple[int, int]] = {}
        left, inside = [], 0
        for place in rest:
            i = int(np.searchsorted(below, place, "right")) - 1
            b = int(np.searchsorted(summed[i], place - below[i], "right"))
            start = firsts[i] + b * int(width[i])
            end = min(int(last[i]), start + int(width[i]) - 1)
            if start == end:
                known[place] = _value(start)
                continue
            if start not in finer:
                before = int(summed[i][b - 1]) if b else 0
                finer[start] = (end, int(below[i]) + before)
                inside += int(summed[i][b]) - before
            left.append(place)
        self._stretches = finer
        return left, inside

    @staticmethod
    def _within(
        pieces: Pieces, first: NDArray[np.uint64], last: NDArray[np.uint64]
    ) -> Iterable[tuple[NDArray[np.uint64], NDArray[np.int64]]]:
        """Keys that lie in a stretch, and in which."""
        for piece in pieces():
            keys = _keys(finite(piece))
            at = np.searchsorted(first, keys, "right") - 1
            inside = (at >= 0) & (keys <= last[np.maximum(at, 0)])
            yield keys[inside], at[inside]

    def _sorted(self, pieces: Pieces, rest: list[int], known: dict[int, float]) -> None:
        """The numbers of all stretches, sorted: they are few now."""
        firsts = sorted(self._stretches)
        first = np.array(firsts, dtype=np.uint64)
        last = np.array([self._stretches[one][0] for one in firsts], dtype=np.uint64)
        keys = np.sort(np.concatenate([some for some, _ in self._within(pieces, first, last)]))
        below = [self._stretches[one][1] for one in firsts]
        for place in rest:
            i = int(np.searchsorted(below, place, "right")) - 1
            known[place] = _value(int(keys[np.searchsorted(keys, first[i]) + place - below[i]]))
