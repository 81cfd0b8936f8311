"""The page of an optimisation: the answer, everything that was tried over the levers, the front."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.plots import figures
from cutwise.app.study_page import axis_of, page_of
from cutwise.study.many import aims as worth

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from cutwise.study.many.best import Best


def page(found: "Best", lines: Sequence[str]) -> str:
    """The page as HTML."""
    drawings = [("What was tried", _tried, "tried")]
    if found.front:
        drawings.append(("What can be had of one aim for how much of the other", _front, "front"))
    return page_of(found, lines, f"{found.done} settings", drawings)


def _tried(found: "Best") -> "Figure":
    """Settings over the first two levers that are numbers, or one lever and the aim; met and missed."""
    search = found.study.search
    assert search is not None
    keys = [key for key, one in search.between.items() if not one.words][:2]
    fig = figures.figure(3.6)
    ax = fig.subplots()
    met = np.array([one.met for one in found.tried])
    columns = [_lever(ax, found, key, k) for k, key in enumerate(keys)]
    while len(columns) < 2:
        columns.append(_aim(ax, found, found.tried, 0, len(columns)))
    x, y = columns[:2]
    for some, label, colour in ((met, "limits kept", figures.SERIES[0]), (~met, "a limit missed", figures.BAD)):
        ax.plot(x[some], y[some], ".", markersize=4, label=label, color=colour)
    best = found.optimum
    at = [i for i, one in enumerate(found.tried) if one.levers == best.levers]
    if at:
        ax.plot(x[at], y[at], "*", markersize=12, label="best", color=figures.GOOD)
    figures.legend_above(ax, 3)
    return fig


def _lever(ax: "Axes", found: "Best", key: str, side: int) -> np.ndarray:
    factor, label = axis_of(found.study, key)
    ax.set(**{"ylabel" if side else "xlabel": label})
    return np.array([float(one.levers[key]) for one in found.tried]) * factor  # type: ignore[arg-type]


def _aim(ax: "Axes", found: "Best", settings: Sequence[object], number: int, side: int) -> np.ndarray:
    search = found.study.search
    assert search is not None
    aim = search.aims[number]
    dimension, unit = worth.unit_of(aim, found.study.scenario)
    factor, unit = figures.scale(dimension) if dimension else (1.0, unit)
    ax.set(**{"ylabel" if side else "xlabel": f"{aim.text.removeprefix('cost: ')} [{unit}]"})
    return np.array([one.aims[number] for one in settings]) * factor  # type: ignore[attr-defined]


def _front(found: "Best") -> "Figure":
    search = found.study.search
    assert search is not None
    fig = figures.figure(3.2)
    ax = fig.subplots()
    y = _aim(ax, found, found.front, 0, 1)
    if len(search.aims) == 2:
        x = _aim(ax, found, found.front, 1, 0)
    else:
        x = np.array([one.asked for one in found.front], float)
        ax.set_xlabel("least share of good cases")
    ax.plot(x, y, "o-", markersize=4)
    return fig
