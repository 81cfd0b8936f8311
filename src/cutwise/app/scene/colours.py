"""Colours of values: two tables, and the range of a table that grows with the tolerance."""

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

_DIVERGING = "053061 2166ac 4393c3 92c5de d1e5f0 f7f7f7 fddbc7 f4a582 d6604d b2182b 67001f"
_SEQUENTIAL = "00224e 123570 3b496c 575d6d 707173 8a8678 a59c74 c3b369 e1cc55 fee838"
MISSING = (0x80, 0x80, 0x80)
ENTRIES = 256
_ROOM = 1.5  # of the range beyond the limits


def _table(stops: str) -> npt.NDArray[np.uint8]:
    corners = np.array([[int(stop[k : k + 2], 16) for k in (0, 2, 4)] for stop in stops.split()], float)
    at = np.linspace(0.0, len(corners) - 1.0, ENTRIES)
    between = [np.interp(at, np.arange(len(corners)), corners[:, k]) for k in range(3)]
    return np.floor(np.column_stack(between) + 0.5).astype(np.uint8)  # rounded half up


TABLES = {"diverging": _table(_DIVERGING), "sequential": _table(_SEQUENTIAL)}


class Range(NamedTuple):
    """Between which values a table is laid out."""

    table: str
    low: float
    high: float
    ticks: tuple[float, ...]

    def colour(self, value: float) -> int:
        """Which colour a value has: floor(256 (x - low) / (high - low)), 0 to 255."""
        if self.high <= self.low:
            return ENTRIES // 2
        return min(ENTRIES - 1, max(0, math.floor(ENTRIES * (value - self.low) / (self.high - self.low))))


def spread(
    values: npt.NDArray[np.float64], low: float | None, high: float | None, nominal: float | None = None
) -> Range:
    """The range of values with limits, which stand two thirds of the way to the ends; least to greatest without.

    Parameters
    ----------
    values : array
        What is coloured; NaN is missing.
    low, high : float, optional
        Limits in the unit of the values.
    nominal : float, optional
        What the values should be.

    Examples
    --------
    46.82 µm where at most 60 µm are allowed:

    >>> spread(np.array([0.0]), None, 60.0).colour(46.82)
    194
    """
    known = values[np.isfinite(values)]
    if low is None and high is None:
        if not known.size:
            return Range("sequential", 0.0, 1.0, ())
        return Range("sequential", float(known.min()), float(known.max()), ())
    ends = [end for end in (low, high) if end is not None]
    centre = nominal if nominal is not None else sum(ends) / 2.0 if len(ends) == 2 else 0.0
    half = max(abs(end - centre) for end in ends)
    if half == 0.0:
        half = float(np.abs(known - centre).max()) if known.size else 0.0
    return Range("diverging", centre - _ROOM * half, centre + _ROOM * half, tuple(ends))


def as_header() -> dict[str, Any]:
    """The tables as they stand in the header of a view file: three bytes an entry, in hexadecimal."""
    return {name: table.tobytes().hex() for name, table in TABLES.items()} | {"missing": list(MISSING)}
