"""The band of a measure: what the scatter of the inputs makes of it, and what is known about how it was made."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple


class Spread(NamedTuple):
    """What the scatter of the inputs makes of a measure, SI."""

    sd: float  # standard deviation
    low: float  # 5 % lie below
    high: float  # 5 % lie above
    carried: Mapping[str, float] = {}

    def as_json(self) -> dict[str, float]:
        """``{sd, low, high}``."""
        return {"sd": self.sd, "low": self.low, "high": self.high}


@dataclass(frozen=True, slots=True)
class BandNote:
    """How the bands of a run were made, and what is not in them."""

    method: Literal["linear", "sampled"]
    runs: int  # further runs that were made
    inputs: tuple[str, ...]  # keys of the values that were moved
    probability_all: float | None = None
    left_out: tuple[str, ...] = ()  # measures that bend too much for a linear band
    not_in_band: tuple[str, ...] = ()  # keys of values from the library without standard error
    residuals: Mapping[str, str] = field(default_factory=dict)  # section: scatter that its fit left, as text
    thrown_away: int = 0  # draws
    failed: int = 0  # draws that could not be run
    seed: int | None = None

    def as_json(self) -> dict[str, Any]:
        """The record without what it does not say."""
        told = {name: getattr(self, name) for name in self.__slots__}
        told = {name: list(value) if isinstance(value, tuple) else value for name, value in told.items()}
        return {name: value for name, value in told.items() if value is not None} | {"residuals": dict(self.residuals)}


def number(value: Any) -> float:
    """A finite number, as read from a file."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(f"{value!r:.40} is no number")
    if not math.isfinite(value):
        raise ValueError(f"{value} is not finite")
    return value


def numbers(entries: Mapping[str, Any]) -> dict[str, float]:
    """Finite numbers by name."""
    return {str(name): number(value) for name, value in entries.items()}


def texts(entries: Any) -> tuple[str, ...]:
    """A list of texts."""
    if not isinstance(entries, list) or not all(isinstance(entry, str) for entry in entries):
        raise TypeError("a list of texts is something else")
    return tuple(entries)


def spread_from_json(sd: Any, low: Any, high: Any, carried: Any = None) -> Spread:
    """A spread as a run file holds it."""
    return Spread(number(sd), number(low), number(high), numbers(carried or {}))


def note_from_json(told: Mapping[str, Any] | None) -> BandNote | None:
    """A note as :meth:`BandNote.as_json` wrote it; none if there was none."""
    if told is None:
        return None
    known: dict[str, Any] = {name: told[name] for name in BandNote.__slots__ if name in told}
    said: dict[str, Any] = {name: texts(value) if isinstance(value, list) else value for name, value in known.items()}
    return BandNote(**said)
