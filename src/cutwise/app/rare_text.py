"""What a study of rare failures says: in a few lines, as JSON, on a page."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.plots import figures
from cutwise.app.study_page import page_of
from cutwise.study.many.answers import rerun
from cutwise.study.many.rarely import size_of_level

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cutwise.study.many.rarely import Rarely

_WORST = 3
_REASONS = 5


def said(found: "Rarely") -> Iterator[str]:
    """The probability, how it was reached, the worst cases."""
    rare = found.found
    if found.unfinished:
        yield (
            f"stopped after {found.done:,} cases in {len(rare.levels)} levels that are whole: failures are rarer than "
            f"{rare.probability:.3g}; --resume goes on"
        )
    elif rare.probability == 0.0:
        yield f"no failure in {found.done:,} cases of {len(rare.levels)} levels"
    else:
        yield (
            f"P(fails) = {rare.probability:.3g} ({rare.low:.2g} to {rare.high:.2g} with 90 %), coefficient of variation "
            f"{rare.cov:.2f}, {found.done:,} cases in {len(rare.levels)} levels"
        )
    yield "this assumes the tails of your distributions: far out, where nothing has been measured"
    for k, level in enumerate(rare.levels):
        beyond = "all cases" if k == 0 else f"margin above {level.threshold:.3g}"
        yield f"  level {k}: {beyond}: {level.share:.3g} go on, {100 * level.accepted:.0f} % of steps taken"
    if found.failed:
        count = sum(found.failed.values())
        yield f"{count:,} cases failed and count as bad"
        for text, number in list(found.failed.items())[:_REASONS]:
            yield f"  {number:,} failed: {text}"
    if found.demanded is not None:
        yield f"P(good) of at least {found.study.demanded:g} is {'met' if found.demanded else _unmet(found)}"
    for one in found.worst(_WORST):
        yield f"  worst: {rerun(found.study, one)}"


def _unmet(found: "Rarely") -> str:
    assert found.study.demanded is not None
    return "not met" if found.good.high < found.study.demanded else f"not told by {found.done:,} cases"


def as_object(found: "Rarely", files: dict[str, str]) -> dict[str, object]:
    """The answer as one JSON object, in the form of a run."""
    rare, asked = found.found, found.demanded
    return {
        "scenario": found.study.name, "process": "study",
        "verdict": "none" if asked is None else "pass" if asked else "fail",
        "measures": {name: {"value": float(value), "unit": ""} for name, value in found.measures.items()},
        "levels": [{"share": one.share, "accepted": one.accepted} for one in rare.levels],
        "stopped": "--resume goes on" if found.unfinished else "",
        "requirements": [], "assumed": [], "warnings": [f"{n} failed: {text}" for text, n in found.failed.items()],
        "files": files,
    }  # fmt: skip


def page(found: "Rarely", lines: Sequence[str]) -> str:
    """The page as HTML."""
    return page_of(
        found,
        lines,
        f"{found.done} cases",
        [("How far the cases of each level lie from the limits", _levels, "levels")],
    )


def _levels(found: "Rarely") -> "Figure":
    """Share of all cases that lie beyond a margin, from level to level."""
    fig = figures.figure(3.2)
    ax = fig.subplots()
    rare = found.found
    size = size_of_level(found.study.draws)
    margin, first, weight = found.table["margin"], 0, 1.0
    for k, level in enumerate(rare.levels):
        count = size if k == 0 else round(0.9 * size)
        some = np.sort(margin[first : first + count])[::-1]
        some = some[some > level.threshold]
        ax.semilogy(
            some,
            weight * (np.arange(some.size) + 1.0) / max(1, some.size),
            color=figures.SERIES[k % len(figures.SERIES)],
        )
        first, weight = first + count, weight * level.share
    ax.axvline(0.0, color=figures.BAD, linestyle="--", linewidth=1.0)
    ax.set(xlabel="margin: share of a limit beyond it", ylabel="share of all cases beyond")
    return fig
