"""How sure a result is, in words: who carries its band, what is not in it."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from cutwise import units
from cutwise.app.verdict_text import chance
from cutwise.spec.fields import placed

if TYPE_CHECKING:
    from cutwise.results import Result

_CARRIERS = 3
_LISTED = 8


class Row(NamedTuple):
    """A measure with its band, as it is listed."""

    name: str
    value: str
    sd: str
    low: str
    high: str
    probability: str
    carried: str


def rows(result: "Result") -> list[Row]:
    """Measures that the scatter of the inputs moves, the required ones and the focus first."""
    checks = {check.measure: check for check in result.checks if not check.implied}
    first = [*checks, result.scenario.focus]
    found = []
    for name in sorted(result.measures, key=lambda name: first.index(name) if name in first else len(first)):
        measure = result.measures[name]
        if measure.band is None or measure.band.sd == 0.0:
            continue
        reached = checks[name].probability_reached if name in checks else None
        value, sd, low, high = (units.show(v, measure.dimension, 4) for v in (measure.value, *measure.band[:3]))
        found.append(
            Row(name, value, sd, low, high, "" if reached is None else chance(reached), carriers(result, name))
        )
    return found


def carriers(result: "Result", name: str) -> str:
    """The inputs that carry most of a band, with their shares of the variance."""
    band = result.measures[name].band
    shares = list(band.carried.items())[:_CARRIERS] if band is not None else []
    return ", ".join(f"{placed(result.scenario, key)} {share:.0%}" for key, share in shares)


def surety(result: "Result", most: int = _LISTED) -> Iterator[str]:
    """What there is to say about the bands of a run, a sentence each."""
    note = result.band
    if note is None:
        return
    draws = f", {note.runs} draws" if note.method == "sampled" else f", {note.runs} further runs"
    yield f"{note.method}{draws}; values with a standard error: {_listed(note.inputs, most)}"
    focus = next((row for row in rows(result)), None)
    if focus is not None:
        yield f"of {focus.name} ({focus.low} … {focus.high}) most is carried by {focus.carried}"
    if note.probability_all is not None:
        yield f"all requirements are kept with probability {chance(note.probability_all)}"
    for section, residual in note.residuals.items():
        yield f"not in it, as an error of the model: what the fit behind {section} left, {_residual(residual)}"
    if note.not_in_band:
        count = len(note.not_in_band)
        yield f"not in it, for want of a standard error: {count} values ({_listed(note.not_in_band, most)})"


def _residual(text: str) -> str:
    """A residual in a unit that people read."""
    for dimension in ("small_length", "force", "moment", "voltage", "compliance"):
        try:
            return units.show(units.parse(text, dimension), dimension, 3)
        except units.UnitFault:
            continue
    return text


def _listed(keys: tuple[str, ...], most: int) -> str:
    more = f" and {len(keys) - most} more" if len(keys) > most else ""
    return ", ".join(keys[:most]) + more
