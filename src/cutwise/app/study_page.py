"""The page of a study: shares, distributions with their limits, what decides, the worst cases; no outside requests."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

import cutwise
from cutwise.app.pages import template
from cutwise.app.plots import figures
from cutwise.study.many.answers import dimension_of
from cutwise.study.many.cases import BAD, GOOD
from cutwise.study.many.statements import Indices

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from cutwise.study.many.answers import Answers
    from cutwise.study.many.definition import Study

_BINS = 400  # of a distribution: as fine as is seen
_POINTS = 3000  # of a scatter
_MOST = 6  # measures that are drawn


def page(found: "Answers", lines: Sequence[str]) -> str:
    """The page as HTML."""
    drawings = [("Distributions, with their limits", _distributions, "cdf")]
    if len(found.study.random) >= 2 and found.study.scenario.requirements:
        drawings.append(("Good and bad cases over the two leading inputs", _scatter, "scatter"))
    if found.indices:
        drawings.append(("What decides", _tornado, "tornado"))
    if len(found.shares) > 1:
        drawings.append(("Share of good cases over the design levers", _over_design, "design"))
    return page_of(found, lines, f"{found.done} of {found.study.cases} cases", drawings)


def page_of(
    found: Any, lines: Sequence[str], done: str, drawings: Sequence[tuple[str, Callable[[Any], "Figure"], str]]
) -> str:
    """The page of anything that has a study: lines, how much is done, and drawings with title and name."""
    plots = [(title, figures.svg(draw, found, name, title)) for title, draw, name in drawings]
    return template("study").render(
        found=found, lines=lines, done=done, plots=plots, version=cutwise.__version__, colours=figures.COLOURS
    )


def _drawn(found: "Answers") -> list[str]:
    """Measures that have numbers, those of the requirements first."""
    return [name for name in found.study.measures if np.isfinite(found.table[f"measure {name}"]).any()][:_MOST]


def _distributions(found: "Answers") -> "Figure":
    names = _drawn(found)
    fig = figures.figure(2.4 * -(-len(names) // 2) if names else 1.0)
    for ax, name in zip(
        np.atleast_1d(fig.subplots(-(-len(names) // 2), min(2, len(names)))).ravel(), names, strict=False
    ):
        scale, unit = figures.scale(found.study.scenario.measures[name].dimension)
        value = np.sort(found.table[f"measure {name}"])
        value = value[np.isfinite(value)] * scale
        share = (np.arange(value.size) + 0.5) / value.size
        some = np.unique(np.linspace(0, value.size - 1, min(_BINS, value.size)).astype(int))
        ax.plot(value[some], share[some], color=figures.SERIES[0])
        limit = found.study.scenario.requirements.get(name)
        for bound in (limit.min, limit.max) if limit is not None else ():
            if bound is not None:
                ax.axvline(bound * scale, color=figures.BAD, linewidth=1.0, linestyle="--")
        ax.set(xlabel=f"{name} [{unit}]", ylabel="share of cases below", ylim=(0.0, 1.0))
    return fig


def _leading(found: "Answers") -> tuple[str, str]:
    """The two inputs that decide most: by their indices, else by rank correlation with being good."""
    keys = [key for key, lever in found.study.random.items() if not lever.curve]
    one = found.indices.get("good")
    if one is not None:
        of_factor = one.total if isinstance(one, Indices) else one.strength
        names = found.study.factor_names
        weight = np.array(
            [next(w for w, name in zip(of_factor, names, strict=True) if key in name.split("+")) for key in keys]
        )
    else:
        good = (found.table["state"] == GOOD).astype(float)
        weight = np.array([_apart(found.table[f"lever {key}"], good) for key in keys])
    order = np.argsort(-np.nan_to_num(weight))
    return keys[int(order[0])], keys[int(order[1])]


def _apart(values: np.ndarray, good: np.ndarray) -> float:
    """How far the good cases lie from the bad ones, in deviations."""
    if values.dtype.kind not in "fi" or good.min() == good.max():
        return 0.0
    return float(abs(values[good > 0.5].mean() - values[good < 0.5].mean()) / (values.std() or 1.0))


def axis_of(study: "Study", key: str) -> tuple[float, str]:
    """Factor from SI to the unit that is drawn, and the label of an axis of a lever."""
    dimension = dimension_of(study, key)
    if dimension is None:
        return 1.0, key
    factor, unit = figures.scale(dimension)
    return factor, f"{key} [{unit}]" if unit else key


def _scatter(found: "Answers") -> "Figure":
    first, second = _leading(found)
    fig = figures.figure(3.6)
    ax = fig.subplots()
    some = slice(0, min(_POINTS, found.done))
    x, y, state = (found.table[name][some] for name in (f"lever {first}", f"lever {second}", "state"))
    for value, label, colour in ((GOOD, "good", figures.SERIES[0]), (BAD, "bad", figures.BAD)):
        ax.plot(x[state == value], y[state == value], ".", markersize=2.5, label=label, color=colour)
    ax.set(xlabel=f"{first} (SI)", ylabel=f"{second} (SI)")
    figures.legend_above(ax, 2)
    return fig


def _tornado(found: "Answers") -> "Figure":
    names = list(found.indices)[:_MOST]
    fig = figures.figure(0.5 * len(found.study.factors) * len(names) + 1.0)
    for ax, name in zip(np.atleast_1d(fig.subplots(len(names), 1)), names, strict=True):
        one = found.indices[name]
        total, alone = (one.total, one.first) if isinstance(one, Indices) else (one.strength, np.abs(one.mean))
        order = np.argsort(total)
        keys = [found.study.factor_names[i] for i in order]
        ax.barh(keys, total[order], color=figures.SOFT, label="with others")
        ax.barh(keys, alone[order], height=0.4, color=figures.BAD, label="alone")
        ax.set(title=name)
    return fig


def _over_design(found: "Answers") -> "Figure":
    fig = figures.figure(3.0)
    ax = fig.subplots()
    shares = [share for _, share in found.shares]
    value = np.array([share.value for share in shares])
    room = np.array([[share.value - share.low, share.high - share.value] for share in shares]).T
    ax.errorbar(np.arange(len(value)), value, yerr=np.abs(room), fmt="o", markersize=4, capsize=2)
    ax.set(xlabel="combination of design levers, in their order", ylabel="share of good cases", ylim=(-0.02, 1.02))
    return fig
