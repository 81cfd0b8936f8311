"""The page of a correction: before and after, the course along the path with what binds, the changed lines."""

import difflib
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

import cutwise
from cutwise.app.pages import template
from cutwise.app.plots import figures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cutwise.study.correct.outcome import Along, Corrected

_POINTS = 4000  # of a course
_LINES = 400  # changed lines that are shown
_COMPARED = 5000  # lines of a program up to which they are compared


def page(found: "Corrected", rows: "list[tuple[str, str, str]]", front: "list[tuple[str, ...]]") -> str:
    """The page as HTML; ``rows``: measure, before, after; ``front``: head and rows of other budgets, or nothing."""
    plots = [
        (one.title, figures.svg(_course, one, f"along{place}", one.title)) for place, one in enumerate(found.along)
    ]
    return template("correct").render(
        found=found,
        rows=rows,
        front=front,
        plots=plots,
        lines=list(_changed(found)),
        version=cutwise.__version__,
        colours=figures.COLOURS,
    )


def _course(along: "Along") -> "Figure":
    """Before and after over what each place allows, coloured by what binds."""
    scale, unit = figures.scale(along.dimension)
    at = np.unique(np.linspace(0, along.at.size - 1, min(_POINTS, along.at.size)).astype(int))
    length, length_unit = figures.scale("length")
    place = along.at[at] * length
    fig = figures.figure(3.4)
    ax = fig.subplots()
    finite = np.isfinite(along.limit[at])
    for number, name in enumerate(along.names):
        here = finite & (along.binds[at] == number)
        if here.any():
            colour = figures.SERIES[(number + 2) % len(figures.SERIES)]
            ax.plot(
                place[here],
                along.limit[at][here] * scale,
                ".",
                markersize=2.5,
                color=colour,
                label=f"allowed by {name}",
            )
    ax.plot(place, along.before[at] * scale, color=figures.SOFT, linewidth=0.8, label="before")
    ax.plot(
        place, along.after[at] * scale, color=figures.SERIES[0], linewidth=1.2, drawstyle="steps-mid", label="after"
    )
    ax.set(xlabel=f"way along the path [{length_unit}]", ylabel=f"{along.title} [{unit}]")
    ax.legend(loc="upper right", ncols=3, fontsize=7)
    return fig


def _changed(found: "Corrected") -> Iterator[tuple[str, str]]:
    """Lines that went and came, each with its class."""
    program = getattr(found.before.scenario, "program", None)
    if program is None or program.text == found.program:
        yield "", "none"
        return
    old, new = program.text.split("\n"), found.program.split("\n")
    if len(old) > _COMPARED:
        yield "", f"{len(old)} lines before, {len(new)} after: too many to be compared here"
        return
    shown = 0
    for line in difflib.unified_diff(old, new, lineterm="", n=1):
        if line.startswith(("---", "+++")):
            continue
        shown += 1
        if shown > _LINES:
            yield "", "and more"
            return
        yield {"-": "bad", "+": "good"}.get(line[:1], ""), line
