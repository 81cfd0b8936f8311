"""The page of a validation: measured over predicted with bands, or a recording laid over its run."""

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

import cutwise
from cutwise.app.pages import template
from cutwise.app.plots import figures
from cutwise.app.validating import table
from cutwise.study.recording import Recording

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from cutwise.study.validate import Validation


def page(found: "Recording | Validation") -> str:
    """The page as HTML."""
    over_time = isinstance(found, Recording)
    if isinstance(found, Recording):
        title, names, scenario = "Recording and run", list(found.laid), found.result.scenario
        draw: Callable[[str], Figure] = partial(_overlay, found)
    else:
        title, names, scenario = "Measured and predicted", list(found.figures), found.scenario
        draw = partial(_against, found)
    plots = [(f"{title}: {name}", figures.svg(draw, name, f"plot{k}", name)) for k, name in enumerate(names)]
    head, *rows = table(found)
    return template("validation").render(
        found=found, version=cutwise.__version__, colours=figures.COLOURS, head=head, rows=rows, plots=plots,
        over_time=over_time, failed=getattr(found, "failed", ()),
        name=scenario.name,
    )  # fmt: skip


def _overlay(found: "Recording", name: str) -> "Figure":
    """A recorded column over the run, and their difference."""
    one = found.laid[name]
    scale, unit = figures.scale(one.dimension)
    fig = figures.figure(3.4)
    above, below = fig.subplots(2, 1, sharex=True, height_ratios=[2, 1])
    figures.curve(above, found.time, one.measured * scale, label="measured")
    figures.curve(above, found.time, one.predicted * scale, label="run")
    above.legend()
    above.set(ylabel=f"{name} [{unit}]" if unit else name)
    figures.curve(below, found.time, (one.predicted - one.measured) * scale, color=figures.SOFT)
    below.set(xlabel="time of the recording [s]", ylabel="run less measured")
    return fig


def _against(found: "Validation", name: str) -> "Figure":
    """Measured values over predicted ones with the widened band, and the error of each row."""
    one = found.compared[name]
    scale, unit = figures.scale(type(found.scenario).measures[name].dimension)
    there = np.isfinite(one.predicted)
    y, p, half = one.measured[there] * scale, one.predicted[there] * scale, one.half[there] * scale
    fig = figures.figure(3.4)
    left, right = fig.subplots(1, 2)
    both = np.concatenate([y, p])
    ends = [float(both.min()), float(both.max())]
    left.plot(ends, ends, color=figures.SOFT, linewidth=0.8)
    left.errorbar(p, y, xerr=np.where(np.isfinite(half), half, 0.0), fmt=".", markersize=4, linewidth=0.6)
    left.set(xlabel=f"predicted [{unit}]", ylabel=f"measured [{unit}]")
    right.axhline(0.0, color=figures.SOFT, linewidth=0.8)
    rows = np.flatnonzero(there) + 1
    right.errorbar(rows, p - y, yerr=np.where(np.isfinite(half), half, 0.0), fmt=".", markersize=4, linewidth=0.6)
    right.set(xlabel="row", ylabel=f"predicted less measured [{unit}]")
    return fig
