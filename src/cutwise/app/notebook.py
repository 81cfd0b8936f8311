"""What a notebook shows of a result, a scenario and a study: a short table and one curve, no script, nothing from outside."""

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING, NamedTuple

from cutwise.app.embedded import embedded
from cutwise.app.findings import notices, reasons
from cutwise.app.inputs import Input, inputs
from cutwise.app.measured import listed
from cutwise.app.numbers import titled
from cutwise.app.pages import template
from cutwise.app.plots import paper
from cutwise.app.plots.figures import COLOURS, svg
from cutwise.app.verdict_text import verdict_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cutwise.results import Result
    from cutwise.spec.scenario import Scenario
    from cutwise.study.many.face import StudyResult

_STYLE = ";".join(f"{name}:{colour}" for name, colour in COLOURS.items())
_TONES = {"pass": "var(--good)", "fail": "var(--bad)", "none": "var(--soft)"}
_MOST_DRAWN = 30_000  # letters of a curve; a longer one is left out, said so
_MOST_NOTICES = 5
_MOST_INPUTS = 180
_LOWEST, _HIGHEST = 100, 5000  # pixels


def result_html(result: "Result") -> str:
    """Verdict, what is required, one curve."""
    parts = [f'<p style="color:{_TONES[result.verdict]};font-weight:bold">{escape(verdict_line(result))}</p>']
    rows = []
    for line in listed(result)[""]:
        judged = "" if line.check is None else "pass" if line.check.passed else "FAIL"
        rows.append((titled(line.name), line.name, line.text, line.asked, judged))
    parts.append(_table(("", "measure", "value", "limit", "result"), rows))
    said = [*reasons(result), *notices(result), *result.warnings]
    parts += [f"<p>{escape(sentence)}</p>" for sentence in said[:_MOST_NOTICES]]
    if len(said) > _MOST_NOTICES:
        parts.append(f"<p>and {len(said) - _MOST_NOTICES} more: result.warnings</p>")
    parts.append(_curve(result))
    return _boxed(f"{result.scenario.name} ({result.scenario.process})", parts)


def _curve(result: "Result") -> str:
    name = paper.default(result)
    if name is None:
        return ""

    def draw(one: "Result") -> "Figure":
        return paper.history(one, name)

    drawn = svg(draw, result, "notebook", name)
    if len(drawn) > _MOST_DRAWN:
        return f"<p>result.plot({escape(repr(name))}) draws {escape(name)}</p>"
    return f'<div style="max-width:360px">{drawn}</div><p><code>result.plot({escape(repr(name))})</code></p>'


class View(NamedTuple):
    """The viewer of a run in a cell of a notebook; in a terminal it says how large it is."""

    page: str
    height: int
    name: str

    def __repr__(self) -> str:
        return f"<View of {self.name}: {len(self.page) / 1e6:.1f} MB, shown in a notebook>"

    def _repr_html_(self) -> str:
        size = f"This cell holds the whole view, {len(self.page) / 1e6:.1f} MB; clear its output to leave it out of the file."
        return (
            f'<iframe srcdoc="{escape(self.page)}" sandbox="allow-scripts" title="{escape(self.name)}" '
            f'style="width:100%;height:{self.height}px;border:1px solid #888"></iframe><p><small>{size}</small></p>'
        )


def view(result: "Result", height: int = 600) -> View:
    """The viewer of a run: part, tool and path in 3D, program, plots and worst places, in a frame that reaches nothing else.

    Parameters
    ----------
    result : Result
        A finished run.
    height : int
        Of the frame, in pixels of the page.

    Raises
    ------
    ValueError
        The run has nothing to be seen in 3D, or the height is none.
    """
    if not isinstance(height, int | float) or not _LOWEST <= height <= _HIGHEST:
        raise ValueError(f"height is {height}; expected {_LOWEST} to {_HIGHEST} pixels")
    viewer = embedded(result)
    if not viewer.script:
        raise ValueError(viewer.why)
    page = template("view").render(viewer=viewer, name=result.scenario.name, verdict=verdict_line(result))
    return View(page, int(height), result.scenario.name)


def scenario_html(scenario: "Scenario") -> str:
    """Every value with its source, section by section."""
    rows = list(inputs(scenario))
    sections: dict[str, list[Input]] = {}
    for row in rows[:_MOST_INPUTS]:
        sections.setdefault(row.section, []).append(row)
    parts = [
        f"<details><summary>{escape(section)} ({len(found)})</summary>"
        + _table(("key", "value", "status", "source"), [(r.key, r.shown[:80], r.status, r.source[:120]) for r in found])
        + "</details>"
        for section, found in sections.items()
    ]
    if len(rows) > _MOST_INPUTS:
        parts.append(f"<p>and {len(rows) - _MOST_INPUTS} values more</p>")
    assumed = sum(row.status == "assumed" for row in rows)
    return _boxed(f"{scenario.name} ({scenario.process}): {len(rows)} values, {assumed} assumed", parts)


def study_html(study: "StudyResult") -> str:
    """Shares of good cases and the worst cases."""
    shares = [
        (
            ", ".join(f"{key} = {value}" for key, value in point.items()),
            f"{share.value:.4f}",
            f"{share.low:.4f} … {share.high:.4f}",
        )
        for point, share in study.answers.shares
    ]
    parts = [_table(("levers", "share of good cases", "95 % interval"), shares)] if shares else []
    parts.append(f"<p>worst cases: {', '.join(map(str, study.worst()))}</p>")
    return _boxed(f"study of {study.answers.study.scenario.name}: {study.answers.done:,} cases", parts)


def _table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    left = ' style="text-align:left"'
    top = "".join(f"<th{left}>{escape(cell)}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td{left}>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def _boxed(title: str, parts: list[str]) -> str:
    return f'<div style="{_STYLE}"><h4>{escape(title)}</h4>{"".join(parts)}</div>'
