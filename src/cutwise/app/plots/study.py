"""Pictures of a study: distributions with their limits, good and bad cases, what decides, shares over settings, fronts."""

from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from cutwise.app.plots import figures
from cutwise.study.many.answers import dimension_of, values_of
from cutwise.study.many.cases import FAILED, GOOD, INFEASIBLE
from cutwise.study.many.columns import aligned, head, pieces
from cutwise.study.many.order import finite, in_order
from cutwise.study.many.statements import Indices
from cutwise.study.many.tally import missed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from cutwise.study.many.answers import Answers
    from cutwise.study.many.definition import Study

_BINS = 400  # of a distribution: as fine as is seen
_POINTS = 3000  # of a scatter
_LEADING = 65536  # first cases that tell which inputs lead
_MOST = 6  # measures that are drawn
_STEPS = 40  # of the running estimate


def cdf(found: Any) -> "Figure":
    """Share of the cases below each value of a measure, with the limits; of a study or its answers."""
    found = _answers(found)
    names = drawn(found)
    rows, columns = max(1, -(-len(names) // 2)), max(1, min(2, len(names)))
    fig = figures.figure(2.4 * rows)
    panels = np.atleast_1d(fig.subplots(rows, columns)).ravel()
    for ax in panels[len(names) :]:
        ax.set_axis_off()
    for ax, name in zip(panels, names, strict=False):
        scale, unit = figures.scale(found.study.scenario.measures[name].dimension)
        value, count = in_order(values_of(found, name), _spread_over)
        ax.plot(value * scale, (_spread_over(count) + 0.5) / count, color=figures.SERIES[0])
        limit = found.study.scenario.asked.get(name)
        for bound, words in ((limit.min, "at least"), (limit.max, "at most")) if limit is not None else ():
            if bound is not None:
                ax.axvline(bound * scale, color=figures.BAD, linewidth=1.0, linestyle="--")
                figures.note(ax, words, (bound * scale, 0.02), (3, 0), color=figures.BAD)
        ax.set(xlabel=_with_unit(name, unit), ylabel="share of cases below", ylim=(0.0, 1.0))
    return fig


def _spread_over(count: int) -> np.ndarray:
    """Places of so many numbers, as many as are seen."""
    return np.unique(np.linspace(0, count - 1, min(_BINS, count)).astype(int))


def scatter(found: Any) -> "Figure":
    """Good cases, and the bad ones by what they miss, over the two inputs that decide most."""
    found = _answers(found)
    if len(inputs_drawn(found.study)) < 2:
        raise ValueError("a scatter needs two inputs that vary at random")
    first, second = leading(found)
    fig = figures.figure(3.8)
    ax = fig.subplots()
    (fx, label_x), (fy, label_y) = axis_of(found.study, first), axis_of(found.study, second)
    asked = (f"measure {name}" for name in found.study.scenario.asked)
    some = head(found.table, _POINTS, "state", f"lever {first}", f"lever {second}", *asked)
    x, y = (_numbers(some[f"lever {key}"], f) for key, f in ((first, fx), (second, fy)))
    state = some["state"]
    groups = {"good": state == GOOD}
    groups |= {text: mask for text, mask in missed(found.study, some).items() if mask.any()}
    groups |= {"infeasible": state == INFEASIBLE, "failed": state == FAILED}
    rest = ~np.any(list(groups.values()), axis=0)
    groups["bad otherwise"] = rest
    colours = [figures.SERIES[0], figures.BAD, *figures.SERIES[1:]]
    shown = {text: mask for text, mask in groups.items() if mask.any()}
    for k, (text, mask) in enumerate(shown.items()):
        colour = figures.SERIES[0] if text == "good" else colours[1 + k % (len(colours) - 1)]
        ax.plot(x[mask], y[mask], ".", markersize=2.5, label=text, color=colour)
    ax.set(xlabel=label_x, ylabel=label_y)
    figures.legend_above(ax, 2 if len(shown) > 3 else len(shown))
    return fig


def tornado(found: Any) -> "Figure":
    """How much each input decides: with the others, and alone (hatched); the bars of intervals are of 95 %."""
    found = _answers(found)
    if not found.indices:
        raise ValueError("a tornado needs a study of method indices or morris")
    names = list(found.indices)[:_MOST]
    fig = figures.figure(0.42 * len(found.study.factors) * len(names) + 0.9 * len(names) + 0.6)
    for ax, name in zip(np.atleast_1d(fig.subplots(len(names), 1)), names, strict=True):
        one = found.indices[name]
        if isinstance(one, Indices):
            total, alone, width, factor = one.total, one.first, one.total_width, 1.0
            labels = ("with others", "alone")
            ax.set_xlabel("share of the variance")
        else:
            dimension = None if name == "good" else found.study.scenario.measures[name].dimension
            factor, unit = (1.0, "") if dimension is None else figures.scale(dimension)
            total, alone, width = one.strength * factor, np.abs(one.mean) * factor, None
            labels = ("mean of the magnitudes", "magnitude of the mean")
            ax.set_xlabel(_with_unit("effect over the whole range", unit))
        order = np.argsort(total)
        keys = [found.study.factor_names[i] for i in order]
        ax.barh(keys, total[order], xerr=None if width is None else width[order], color=figures.SHADE,
                edgecolor=figures.SOFT, ecolor=figures.SOFT, capsize=2, label=labels[0])  # fmt: skip
        ax.barh(
            keys, alone[order], height=0.4, color="none", edgecolor=figures.SERIES[0], hatch="////", label=labels[1]
        )
        ax.set_title(name, pad=18)
        figures.legend_above(ax, 2)
    return fig


def over_settings(found: Any) -> "Figure":
    """Share of good cases over the settings of a design lever, one curve for each combination of the others."""
    found = _answers(found)
    key = over(found)
    fig = figures.figure(3.2)
    ax = fig.subplots()
    others: dict[tuple[Any, ...], list[tuple[Any, Any]]] = {}
    for values, share in found.shares:
        others.setdefault(tuple(v for k, v in values.items() if k != key), []).append((values[key], share))
    factor, label = axis_of(found.study, key)
    for k, (rest, some) in enumerate(others.items()):
        value = np.array([share.value for _, share in some])
        room = np.array([[share.value - share.low, share.high - share.value] for _, share in some]).T
        words = any(isinstance(x, str) for x, _ in some)
        x: Any = [str(v) for v, _ in some] if words else np.array([v for v, _ in some], float) * factor
        named = ", ".join(
            map(str, (_shown(found.study, k2, v) for k2, v in zip(_others(found, key), rest, strict=True)))
        )
        ax.errorbar(x, value, yerr=np.abs(room), fmt="o" if words else "o-", markersize=4, capsize=2, label=named or None,
                    color=figures.SERIES[k % len(figures.SERIES)])  # fmt: skip
    if found.study.demanded is not None:
        figures.line_note(ax, found.study.demanded, "wanted", figures.BAD)
    ax.set(xlabel=label, ylabel="share of good cases", ylim=(-0.02, 1.02))
    if 1 < len(others) <= len(figures.SERIES):
        figures.legend_above(ax, 3)
    return fig


def over(found: "Answers") -> str:
    """The design lever that shares are drawn over: the one with the most values, of numbers before words."""
    design = found.study.design
    return max(
        design, key=lambda key: (not any(isinstance(v, str) for v in design[key].values), len(design[key].values))
    )


def running(found: Any) -> "Figure":
    """The share of good cases as it was after so many cases."""
    found = _answers(found)
    each = found.study.combinations
    rows = found.done // each
    fig = figures.figure(2.4)
    ax = fig.subplots()
    at = np.unique(np.linspace(max(1, rows // _STEPS), rows, min(rows, _STEPS)).astype(int))
    share = np.empty((at.size, each))
    good, ended, first = np.zeros(each), np.zeros(each), 0
    for piece in aligned(pieces(found.table, "state"), each):
        state = piece["state"].reshape(-1, each)
        goods, ends = good + np.cumsum(state == GOOD, axis=0), ended + np.cumsum(state != FAILED, axis=0)
        here = (at > first) & (at <= first + len(state))
        share[here] = (goods / np.maximum(1, ends))[at[here] - first - 1]
        good, ended, first = goods[-1], ends[-1], first + len(state)
    for k in range(min(each, len(figures.SERIES))):
        ax.plot(at, share[:, k], color=figures.SERIES[k])
    ax.set(xlabel="draws", ylabel="share of good cases")
    return fig


def pareto(found: Any) -> "Figure":
    """The front of an optimisation: what can be had of one aim for how much of the other, or for how likely a good part."""
    search = found.study.search
    if search is None or not found.front:
        raise ValueError("a front needs an optimisation with two aims, or with several probabilities")
    fig = figures.figure(3.2)
    ax = fig.subplots()
    y = aim(ax, found, found.front, 0, 1)
    if len(search.aims) == 2:
        x = aim(ax, found, found.front, 1, 0)
    else:
        x = np.array([one.asked for one in found.front], float)
        ax.set_xlabel("least share of good cases")
    ax.plot(x, y, "o-", markersize=4)
    return fig


def aim(ax: "Axes", found: Any, settings: Any, number: int, side: int) -> np.ndarray:
    """Values of an aim at some settings, and the label of its axis (0: across, 1: up)."""
    from cutwise.study.many import aims as worth

    one = found.study.search.aims[number]
    dimension, unit = worth.unit_of(one, found.study.scenario)
    factor, unit = figures.scale(dimension) if dimension else (1.0, unit)
    ax.set(**{"ylabel" if side else "xlabel": _with_unit(one.text.removeprefix("cost: "), unit)})
    return np.array([setting.aims[number] for setting in settings]) * factor


def drawn(found: "Answers") -> list[str]:
    """Measures that have numbers, those of the requirements first."""
    there = (name for name in found.study.measures if any(finite(some).size for some in values_of(found, name)()))
    return list(islice(there, _MOST))


def leading(found: "Answers") -> tuple[str, str]:
    """The two inputs that decide most: by their indices, else by how far the good cases lie from the bad ones."""
    keys = inputs_drawn(found.study)
    one = found.indices.get("good")
    if one is not None:
        of_factor = one.total if isinstance(one, Indices) else one.strength
        names = found.study.factor_names
        weight = np.array(
            [next(w for w, name in zip(of_factor, names, strict=True) if key in name.split("+")) for key in keys]
        )
    else:
        some = head(found.table, _LEADING, "state", *(f"lever {key}" for key in keys))
        good = (some["state"] == GOOD).astype(float)
        weight = np.array([_apart(some[f"lever {key}"], good) for key in keys])
    order = np.argsort(-np.nan_to_num(weight), kind="stable")
    return keys[int(order[0])], keys[int(order[1])]


def inputs_drawn(study: "Study") -> list[str]:
    """Inputs that scatter and are numbers or words, no curves."""
    return [key for key, lever in study.random.items() if not lever.curve]


def axis_of(study: "Study", key: str) -> tuple[float, str]:
    """Factor from SI to the unit that is drawn, and the label of an axis of a lever."""
    dimension = dimension_of(study, key)
    if dimension is None:
        return 1.0, key
    factor, unit = figures.scale(dimension)
    return factor, _with_unit(key, unit)


def _answers(found: Any) -> "Answers":
    """The answers, of a study as Python has it or as they are."""
    answers: Answers = getattr(found, "answers", found)
    return answers


def _with_unit(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _numbers(values: np.ndarray, factor: float) -> np.ndarray:
    """Values to be drawn; words as they are."""
    return values.astype(float) * factor if values.dtype.kind in "fi" else values.astype(str)


def _others(found: "Answers", key: str) -> list[str]:
    return [other for other in found.study.design if other != key]


def _shown(study: "Study", key: str, value: Any) -> str:
    from cutwise.study.many.answers import shown

    return shown(study, key, value, 4)


def _apart(values: np.ndarray, good: np.ndarray) -> float:
    """How far the good cases lie from the bad ones, in deviations."""
    if values.dtype.kind not in "fi" or good.min() == good.max():
        return 0.0
    return float(abs(values[good > 0.5].mean() - values[good < 0.5].mean()) / (values.std() or 1.0))
