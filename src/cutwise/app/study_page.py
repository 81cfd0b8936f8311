"""The page of a study: shares, distributions with their limits, what decides, the worst cases; no outside requests."""

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

import cutwise
from cutwise import units
from cutwise.app.pages import template
from cutwise.app.plots import figures
from cutwise.app.plots import study as pictures
from cutwise.study.many.answers import command, dimension_of, shown, worst
from cutwise.study.many.columns import row
from cutwise.study.many.distributions import Truncated

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cutwise.study.many.answers import Answers
    from cutwise.study.many.definition import Study

_WORST = 10  # cases that are listed
_REASONS = 50  # of failures
Drawing = tuple[str, Callable[[Any], "Figure"], str]
"""Title, function that draws, name in the page."""
Table = tuple[str, tuple[str, ...], Sequence[Sequence[str]]]
"""Title, head, rows; a text that begins with ``cutwise run`` is shown as a command."""


def page(found: "Answers", lines: Sequence[str], identity: str = "") -> str:
    """The page as HTML."""
    drawings: list[Drawing] = [("Distributions, with their limits", pictures.cdf, "cdf")]
    if len(pictures.inputs_drawn(found.study)) >= 2 and found.study.scenario.asked:
        drawings.append(("Good and bad cases over the two leading inputs", pictures.scatter, "scatter"))
    if found.indices:
        drawings.append(("What decides", pictures.tornado, "tornado"))
    if len(found.shares) > 1:
        drawings.append(("Share of good cases over the settings", pictures.over_settings, "design"))
    if found.shares:
        drawings.append(("The estimate as it came", pictures.running, "running"))
    return page_of(
        found, lines, f"{found.done:,} of {found.study.cases:,} cases", drawings, list(_tables(found)), identity
    )


def page_of(
    found: Any, lines: Sequence[str], done: str, drawings: Sequence[Drawing], tables: Sequence[Table] = (),
    identity: str = "",
) -> str:  # fmt: skip
    """The page of anything that has a study: lines, how much is done, drawings, tables, and what varies."""
    plots = [(title, figures.svg(draw, found, name, title)) for title, draw, name in drawings]
    return template("study").render(
        found=found, lines=lines, done=done, plots=plots, tables=tables, varies=list(varies(found.study)),
        identity=identity, version=cutwise.__version__, colours=figures.COLOURS,
    )  # fmt: skip


def _tables(found: "Answers") -> Iterator[Table]:
    study = found.study
    rows = [
        (
            text,
            f"{count:,}",
            f"{100 * count / found.done:.2f} %",
            _measure(study, text.split(" ")[0], found.extremes[text]),
        )
        for text, count in found.wrong.items()
        if count
    ]
    if rows:
        yield "What is wrong", ("requirement", "cases", "share", "worst"), rows
    if study.measures:
        order = worst(found, _WORST)
        heads = ("case", *study.keys, *study.measures, "run again with")
        yield "The worst cases", heads, [_row(found, case) for case in order]
    for reasons, title in ((found.failed, "Cases that came to no end"), (found.infeasible, "Infeasible cases")):
        if reasons:
            first = [
                (text, f"{count:,}", command(found, found.first[text]))
                for text, count in list(reasons.items())[:_REASONS]
            ]
            yield title, ("reason", "cases", "the first of them"), first


def _row(found: "Answers", case: int) -> list[str]:
    study, one = found.study, row(found.table, case)
    levers = (shown(study, key, one[f"lever {key}"]) for key in study.keys)
    measures = (_measure(study, name, float(one[f"measure {name}"])) for name in study.measures)
    return [str(case), *levers, *measures, command(found, case)]


def _measure(study: "Study", name: str, value: float) -> str:
    return units.show(float(value), study.scenario.measures[name].dimension, 4) if np.isfinite(value) else "none"


def varies(study: "Study") -> Iterator[tuple[str, str, str]]:
    """Each lever, how it varies in units that people read, and what the scenario says of its own value."""
    searched = study.search.between if study.search is not None else {}
    for key, one in searched.items():
        ends = (
            ", ".join(map(str, one.words))
            if one.words
            else f"{shown(study, key, one.low)} to {shown(study, key, one.high)}"
        )
        yield key, ("one of " if one.words else "between ") + ends, _source(study, key)
    for key, lever in study.design.items():
        yield key, ", ".join(shown(study, key, value) for value in lever.values), _source(study, key)
    for key in study.random:
        yield key, scatters(study, key), _source(study, key)


def scatters(study: "Study", key: str) -> str:
    """How an input scatters: its law, and its quantiles in the unit that people read."""
    lever = study.random[key]
    cut = isinstance(lever.distribution, Truncated)
    law = type(lever.distribution.whole if cut else lever.distribution).__name__ + (", cut off" if cut else "")  # type: ignore[attr-defined]
    if lever.curve:
        return "a random curve along the edge, another in each case"
    if lever.words:
        return "one of " + ", ".join(map(str, lever.words))
    ends = lever.of(np.array([0.05, 0.5, 0.95]))
    dimension = dimension_of(study, key)
    said = [units.show(float(x), dimension, 4) if dimension else f"{x:.4g}" for x in ends]  # type: ignore[arg-type]
    return f"{law}: 5 % below {said[0]}, half below {said[1]}, 95 % below {said[2]}"


def _source(study: "Study", key: str) -> str:
    origin = study.scenario.origins.get(key)
    return "" if origin is None else ", ".join(filter(None, (origin.status, origin.source)))
