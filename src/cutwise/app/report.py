"""The HTML report of a run: one file that needs nothing else, to be read, printed, sent on and run again."""

import re
from collections.abc import Iterable, Iterator, Mapping
from datetime import datetime
from typing import TYPE_CHECKING, Any, NamedTuple

import cutwise
from cutwise import references, units
from cutwise.app import inputs, surety
from cutwise.app.embedded import Embedded, embedded
from cutwise.app.findings import notices, reasons
from cutwise.app.measured import Line, listed, rows
from cutwise.app.numbers import amount, titled
from cutwise.app.pages import template
from cutwise.app.plots import PLOTS
from cutwise.app.plots.figures import COLOURS, Plot, svg
from cutwise.app.verdict_text import against, compared, doubted, margin, verdict_reason
from cutwise.spec.fields import placed

if TYPE_CHECKING:
    from cutwise.results import Check, Result

_DOI = re.compile(r"\bdoi[ :]+(10\.\d{4,}/\S+?)(?=[,;.]?(?:\s|$))")
_HEADINGS = {
    "worst": "Worst places",
    "band": "Where in the band the run ended",
    "plausibility": "Thrust and torque by other formulas",
    "skating": "Does the tip hold?",
    "cross_check": "Quasi-static cross-check",
    "placement": "Where to put the part",
}


class Gauge(NamedTuple):
    """Where a value stands between its limits, in percent of the width of a bar."""

    allowed_from: float
    allowed_to: float
    value: float


def render(result: "Result", *, written: datetime | None = None, viewer: bool = True) -> str:
    """The report of a result as one HTML document without any outside request.

    ``written`` is the time printed on it; now if left out. ``viewer``: with the part, tool and path in 3D, where the browser
    runs scripts; without, and wherever it runs none, the pictures stand there.
    """
    scenario = result.scenario
    given = list(inputs.inputs(scenario))
    return template("report").render(
        version=cutwise.__version__,
        written=(written or datetime.now().astimezone()).strftime("%Y-%m-%d %H:%M"),
        scenario=scenario,
        process=(type(scenario).__doc__ or scenario.process).strip().splitlines()[0].rstrip("."),
        result=result,
        verdict=verdict_reason(result),
        reasons=reasons(result),
        notices=notices(result),
        checks=[_checked(line, result) for line in listed(result)[""] if line.check is not None],
        headlines=list(_headlines(result)),
        compared=compared(result),
        measures=rows(result),
        titled=titled,
        bands=surety.rows(result),
        surety=list(surety.surety(result, 1000)),
        sensitivity=list(_weighed(result)),
        moved=list(_converged(result)),
        unmoved=[name for name, change in result.convergence.items() if change == 0.0],
        sections=_by_section(given),
        statuses={
            status: sum(row.status == status for row in given) for status in dict.fromkeys(r.status for r in given)
        },
        total=len(given),
        plots=list(_drawn(PLOTS.get(scenario.process, ()), result)),
        notes=[(_HEADINGS.get(name, _titled(name)), _lines(text)) for name, text in _worst_first(result.notes)],
        references=[_cited(references.SOURCES[key]) for key in result.references if key in references.SOURCES],
        scenario_yaml=inputs.as_yaml(scenario),
        scenario_json=inputs.as_json(scenario),
        colours=COLOURS,
        viewer=embedded(result) if viewer else Embedded(),
    )


def _by_section(rows: Iterable[inputs.Input]) -> dict[str, list[inputs.Input]]:
    found: dict[str, list[inputs.Input]] = {}
    for row in rows:
        found.setdefault(row.section, []).append(row)
    return found


def _checked(line: Line, result: "Result") -> dict[str, Any]:
    check = line.check
    assert check is not None
    measure = result.measures.get(check.measure)
    room = margin(check)
    return {
        "measure": check.measure,
        "meaning": measure.description if measure else "",
        "value": line.text,
        "requirement": line.asked,
        "margin": "" if room is None else amount(result.scenario, check.measure, room),
        "passed": check.passed,
        "implied": check.implied,
        "doubts": list(doubted(check, result.scenario)),
        "missed": against(check, result.scenario).strip(),
        "gauge": _gauge(check),
    }


def _gauge(check: "Check") -> Gauge | None:
    """Bar that spans the limits, the value and a margin; open limits run to the end of the bar."""
    if check.value is None:
        return None
    limits = [limit for limit in (check.minimum, check.maximum) if limit is not None]
    marks = [check.value, *limits, *([0.0] if len(limits) == 1 else [])]
    span = max(marks) - min(marks) or max(abs(marks[0]), 1.0)
    low, high = min(marks) - 0.15 * span, max(marks) + 0.15 * span

    def place(value: float) -> float:
        return round(100.0 * (value - low) / (high - low), 2)

    start = 0.0 if check.minimum is None else place(check.minimum)
    return Gauge(start, 100.0 if check.maximum is None else place(check.maximum), place(check.value))


def _headlines(result: "Result") -> Iterator[tuple[str, str, str]]:
    """Name, value and meaning of the measures that say most: those with a requirement, and what the process is about."""
    for line in listed(result)[""]:
        if line.name in result.measures:
            yield line.name, line.text, line.meaning


def _converged(result: "Result") -> Iterator[dict[str, str]]:
    """Rows of the table of changes with the halved step: what moved, the largest relative change first."""
    rows = []
    for name, change in result.convergence.items():
        measure = result.measures.get(name)
        if measure is None or change == 0.0:
            continue
        share = abs(change / measure.value) if measure.value else float("inf")
        rows.append((share, name, measure, change))
    for share, name, measure, change in sorted(rows, key=lambda row: -row[0]):
        yield {
            "name": name,
            "value": units.show(measure.value, measure.dimension, 5),
            "change": units.show(change, measure.dimension, 2),
            "share": "" if share == float("inf") else f"{100.0 * share:.2g} %",
        }


def _drawn(plots: Iterable[Plot], result: "Result") -> Iterator[dict[str, str]]:
    for number, plot in enumerate(plots, start=1):
        if plot.applies(result):
            title = f"{plot.title}. {plot.caption}"
            yield {"title": plot.title, "caption": plot.caption, "svg": svg(plot.draw, result, f"plot{number}", title)}


def _weighed(result: "Result") -> Iterator[tuple[str, str]]:
    """Assumed values that move the measure that matters most at all, and by how much."""
    for key, change in result.sensitivity.items():
        if change != 0.0:
            yield (
                placed(result.scenario, key),
                units.show(change, result.scenario.measures[result.scenario.focus].dimension, 2),
            )


def _worst_first(notes: Mapping[str, Any]) -> list[tuple[str, Any]]:
    return sorted(notes.items(), key=lambda note: (note[0] != "worst", note[0] != "band"))


def _lines(text: Any) -> list[str]:
    """A note is a text or a list of them."""
    return [str(line) for line in text] if isinstance(text, list | tuple) else str(text).splitlines()


def _titled(name: str) -> str:
    return name.replace("_", " ").capitalize()


def _cited(source: references.Source) -> dict[str, Any]:
    doi = _DOI.search(source.citation)
    return {"source": source, "doi": doi.group(1) if doi else ""}
