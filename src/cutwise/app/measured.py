"""The measures of a run as rows, the same on the command line and in the report."""

import re
from typing import TYPE_CHECKING, NamedTuple

from cutwise.app.numbers import Form, beside, forms, grouped, held
from cutwise.spec.scenario import Limit

if TYPE_CHECKING:
    from collections.abc import Iterator

    from cutwise.results import Check, Result


class Line(NamedTuple):
    """A measure as it is listed."""

    name: str
    number: str
    unit: str
    asked: str  # its limit, if it has one
    check: "Check | None"
    meaning: str
    band: str = ""  # its ends in the unit

    @property
    def text(self) -> str:
        """The number with its unit."""
        return f"{self.number}{'' if self.unit == '°' else ' '}{self.unit}".strip()


def listed(result: "Result") -> dict[str, list[Line]]:
    """Group: its measures. The group without a name comes first: what is required, then what the process is about."""
    scenario = result.scenario
    checks = {check.measure: check for check in result.checks}
    values = {name: measure.value for name, measure in result.measures.items()}
    found: dict[str, list[Line]] = {}
    for group, names in grouped(scenario, values, checks).items():
        limited = {
            name: held(scenario, name, check.value, Limit.model_construct(min=check.minimum, max=check.maximum))
            for name, check in checks.items()
            if name in names
        }
        shapes = forms(scenario, values, [name for name in names if name not in checks], typed=limited)
        found[group] = []
        for name in names:
            meaning = result.measures[name].description if name in values else scenario.measures[name].description
            meaning = "; ".join(filter(None, (meaning, scenario.caveat(name))))
            check = checks.get(name)
            band = _band(result, name, None if check is not None else shapes[name])
            if check is not None:
                shown = limited[name]
                found[group].append(Line(name, shown.number, shown.unit, shown.asked, check, meaning, band))
            else:
                shape = shapes[name]
                found[group].append(Line(name, shape.number(values[name]), shape.unit, "", None, meaning, band))
    return found


def caveats(result: "Result") -> list[tuple[list[str], str]]:
    """What has to be said of measures, each sentence once with their names."""
    found: dict[str, list[str]] = {}
    for name in result.measures:
        if sentence := result.scenario.caveat(name):
            found.setdefault(sentence, []).append(name)
    return [(names, sentence) for sentence, names in found.items()]


def _band(result: "Result", name: str, shape: Form | None) -> str:
    """The 90 % band of a measure; nothing where the scatter of the inputs does not reach it."""
    spread = result.measures[name].band if dict.__contains__(result.measures, name) else None
    if spread is None or spread.sd == 0.0:
        return ""
    return beside(result.scenario, name, (spread.low, spread.high), shape)


def rows(result: "Result") -> list[tuple[str, list[Line]]]:
    """The groups with components of one quantity in one line: ``force_x|y|z``."""
    return [(group, list(_together(lines))) for group, lines in listed(result).items() if lines]


def _together(lines: list[Line]) -> "Iterator[Line]":
    by_name = {line.name: line for line in lines}
    done: set[str] = set()
    for line in lines:
        stem = re.sub(r"_[xyz]$", "", line.name)
        axes = [axis for axis in "xyz" if f"{stem}_{axis}" in by_name] if stem != line.name else []
        parts = [by_name[f"{stem}_{axis}"] for axis in axes]
        if len(axes) < 2 or any(part.check is not None for part in parts):
            yield line
        elif stem not in done:
            done.add(stem)
            meaning = re.sub(r",? [xyz] direction$", "", line.meaning)
            number = " | ".join(part.number for part in parts)
            band = " | ".join(part.band or part.number for part in parts) if any(part.band for part in parts) else ""
            yield line._replace(name=f"{stem}_{'|'.join(axes)}", number=number, meaning=meaning, band=band)
