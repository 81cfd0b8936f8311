"""Plots of a pass on a machine: budget, error along the pass, wall, chain, probability, working space."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure

from cutwise.app.plots.figures import BAD, GOOD, GRID, INK, SERIES, SOFT, Plot, curve, figure, legend_above, scale

if TYPE_CHECKING:
    from cutwise.results import Result

_SIDES = (("y", "z", "from the side"), ("x", "z", "from the front"))
_NAMED_APART = 0.06  # share of the drawing below which two bodies share a label


def body_shares(result: "Result") -> Figure:
    """Signed share of each body along the largest error."""
    budget = result["budget"]
    factor, unit = scale("small_length")
    drawn = figure(0.6 + 0.32 * budget.sizes["body"])
    axes = drawn.subplots()
    _bars(axes, [str(name) for name in budget["body"].values], factor * budget["body_share"].values)
    whole = factor * budget["body_share"].values.sum()
    axes.set(xlabel=f"share along the error [{unit}]; the shares sum to {whole:.4g}")
    return drawn


def stiffening(result: "Result") -> Figure:
    """What each element costs by direction, and what 10 % more stiffness would bring."""
    budget = result["budget"]
    factor, unit = scale("small_length")
    drawn = figure(0.9 + 0.36 * budget.sizes["element"])
    left, right = drawn.subplots(1, 2, sharey=True, width_ratios=(1.6, 1.0))
    names = [str(name) for name in budget["element"].values]
    place = np.arange(len(names))[::-1]
    for k, axis in enumerate("xyz"):
        values = factor * budget["contribution"].sel(axis=axis).values
        left.barh(place + 0.25 * (1 - k), values, height=0.22, color=SERIES[k], label=axis)
    left.axvline(0.0, color=SOFT, linewidth=0.8)
    left.set(xlabel=f"error at the worst place [{unit}]", yticks=place, yticklabels=names)
    legend_above(left, 3)
    _bars(right, names, factor * budget["stiffening_gain"].values)
    right.set(xlabel=f"change of the error, 10 % stiffer [{unit}]")
    for axes in (left, right):
        axes.grid(visible=False, axis="y")
    return drawn


def _bars(axes: Axes, names: list[str], values: np.ndarray) -> None:
    place = np.arange(len(names))[::-1]
    axes.barh(place, values, height=0.6, color=[BAD if value > 0 else GOOD for value in values])
    axes.axvline(0.0, color=SOFT, linewidth=0.8)
    for y, value in zip(place, values, strict=True):
        axes.annotate(f"{value:.3g}", (value, y), xytext=(4 if value >= 0 else -4, 0), textcoords="offset points",
                      ha="left" if value >= 0 else "right", va="center", fontsize=8, color=INK)  # fmt: skip
    axes.set(yticks=place, yticklabels=names)
    axes.margins(x=0.15)
    axes.grid(visible=False, axis="y")


def along_the_pass(result: "Result") -> Figure:
    """Error of the tool point over the way."""
    travel, error = result["motion"]["travel"].values, result["surface"]["f4"]
    long, long_unit = scale("length")
    factor, unit = scale("small_length")
    drawn = figure(3.2)
    axes = drawn.subplots()
    for axis, colour in zip("xyz", SERIES, strict=False):
        curve(axes, long * travel, factor * error.sel(axis=axis).values, color=colour, label=axis)
    size, cuts = np.linalg.norm(error.values, axis=1), result["motion"]["cuts"].values > 0.0
    curve(axes, long * travel, factor * size, color=INK, label="length")
    worst = int(np.argmax(np.where(cuts, size, -1.0) if cuts.any() else size))
    axes.plot(long * travel[worst], factor * size[worst], "o", color=BAD, markersize=5)
    axes.set(xlabel=f"way along the pass [{long_unit}]", ylabel=f"error of the tool point [{unit}]")
    axes.margins(x=0.01)
    legend_above(axes, 4)
    return drawn


def wall(result: "Result") -> Figure:
    """The machined wall with its error as colour."""
    error = result["surface"]["wall_error"]
    long, long_unit = scale("length")
    factor, unit = scale("small_length")
    drawn = figure(2.4, colour_bars=True)
    axes = drawn.subplots()
    travel, height = long * result["motion"]["travel"].values, long * error["height"].values
    image = axes.contourf(travel, height, factor * error.values.T, levels=12, cmap="viridis")
    drawn.colorbar(image, ax=axes, label=f"error along the normal [{unit}]")
    axes.set(xlabel=f"way along the pass [{long_unit}]", ylabel=f"height [{long_unit}]")
    axes.grid(visible=False)
    return drawn


def plan(result: "Result") -> Figure:
    """The path in plan with its error as colour, and the worst place."""
    error, position = result["surface"]["error_on_path"], result["motion"]["position"]
    long, long_unit = scale("length")
    factor, unit = scale("small_length")
    x, y = (long * position.sel(axis=name).values for name in "xy")
    values = factor * error.values
    drawn = figure(4.6, colour_bars=True)
    axes = drawn.subplots()
    axes.plot(x, y, "-", color=GRID, linewidth=1.0)
    ends = np.stack([np.column_stack([x[:-1], y[:-1]]), np.column_stack([x[1:], y[1:]])], axis=1)
    # steps of colour: a smooth bar would be a picture, not lines
    levels = BoundaryNorm(np.linspace(np.nanmin(values), max(np.nanmax(values), np.nanmin(values) + 1e-9), 13), 256)
    seen = np.where(np.abs(values[:-1]) > np.abs(values[1:]), values[:-1], values[1:])
    image = axes.add_collection(LineCollection(list(ends), array=seen, norm=levels, linewidths=3.0))
    drawn.colorbar(image, ax=axes, label=f"{error.attrs['long_name']} [{unit}]")
    worst = int(np.nanargmax(np.abs(values)))
    axes.plot(x[worst], y[worst], "o", markerfacecolor="none", markeredgecolor=BAD, markersize=11)
    axes.set(xlabel=f"x in the part [{long_unit}]", ylabel=f"y in the part [{long_unit}]")
    axes.set_aspect("equal", adjustable="datalim")
    axes.grid(visible=False)
    return drawn


def chain(result: "Result") -> Figure:
    """The bodies of the chain at the start of the pass, from the part to the tool."""
    motion = result["motion"]
    factor, unit = scale("length")
    origins = factor * motion["body_origin"].isel(time=0)
    tool = factor * motion["position"].isel(time=0)
    names = [str(name) for name in motion["body"].values]
    drawn = figure(4.4)
    for axes, (across, up, title) in zip(drawn.subplots(1, 2), _SIDES, strict=True):
        x, y = (np.append(origins.sel(axis=name).values, tool.sel(axis=name).item()) for name in (across, up))
        axes.plot(x, y, "-", color=SERIES[0], linewidth=2.5, alpha=0.6)
        axes.plot(x[:-1], y[:-1], "o", color=INK, markersize=5)
        axes.plot(x[-1], y[-1], "v", color=BAD, markersize=7)
        for place, text in _labels(x, y, [*names, "tool point"]):
            axes.annotate(text, place, xytext=(7, 3), textcoords="offset points", fontsize=8)
        axes.set(xlabel=f"{across} [{unit}]", ylabel=f"{up} [{unit}]", title=title)
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.2)
    return drawn


def _labels(x: np.ndarray, y: np.ndarray, names: list[str]) -> list[tuple[tuple[float, float], str]]:
    """Names at their places; those that would hide one another in one label."""
    near = _NAMED_APART * max(np.ptp(x), np.ptp(y), 1e-9)
    found: list[tuple[tuple[float, float], str]] = []
    for place in zip(x.tolist(), y.tolist(), names, strict=True):
        here, name = place[:2], place[2]
        for k, (there, text) in enumerate(found):
            if np.hypot(here[0] - there[0], here[1] - there[1]) < near:
                found[k] = (there, f"{text}, {name}")
                break
        else:
            found.append((here, name))
    return found


def variance(result: "Result") -> Figure:
    """Share of each body in the variance of the random error."""
    uncertainty = result["uncertainty"]
    drawn = figure(0.6 + 0.32 * uncertainty.sizes["body"])
    axes = drawn.subplots()
    place = np.arange(uncertainty.sizes["body"])[::-1]
    axes.barh(place, 100 * uncertainty["variance_share"].values, height=0.6, color=SERIES[3])
    axes.set(yticks=place, yticklabels=[str(name) for name in uncertainty["body"].values],
             xlabel="share in the variance of the error [%]")  # fmt: skip
    axes.grid(visible=False, axis="y")
    return drawn


def slices(result: "Result") -> Figure:
    """Length of the geometric error in the three middle planes of the working space."""
    volume = result["volume"]
    long, long_unit = scale("length")
    factor, unit = scale("small_length")
    size = factor * np.linalg.norm(volume["error"].values, axis=-1)
    at = {name: long * volume[name].values for name in "XYZ"}
    levels = np.linspace(0.0, size.max(), 13)
    drawn = figure(3.1, colour_bars=True)
    panels = drawn.subplots(1, 3)
    for k, (axes, (across, up)) in enumerate(zip(panels, (("Y", "Z"), ("X", "Z"), ("X", "Y")), strict=True)):
        middle = size.shape[k] // 2
        image = axes.contourf(at[across], at[up], np.take(size, middle, axis=k).T, levels=levels, cmap="viridis")
        title = f"{'XYZ'[k]} = {at['XYZ'[k]][middle]:.4g}"
        axes.set(xlabel=f"{across} [{long_unit}]", ylabel=f"{up} [{long_unit}]", title=title)
        axes.grid(visible=False)
    drawn.colorbar(image, ax=panels, label=f"length of the error [{unit}]")
    return drawn


def diagonals(result: "Result") -> Figure:
    """Error along the four body diagonals."""
    volume = result["volume"]
    long, long_unit = scale("length")
    factor, unit = scale("small_length")
    drawn = figure(3.1)
    axes = drawn.subplots()
    for k, name in enumerate(volume["diagonal"].values):
        along, distance = (volume[key].sel(diagonal=name).values for key in ("diagonal_error", "diagonal_distance"))
        label = f"{name}: range {factor * np.ptp(along):.3g} {unit}"
        curve(axes, long * distance, factor * along, color=SERIES[k], label=label)
    axes.set(xlabel=f"distance along the diagonal [{long_unit}]", ylabel=f"error along it [{unit}]")
    axes.margins(x=0.01)
    legend_above(axes, 4)
    return drawn


PLOTS = [
    Plot(
        "Error budget by body",
        "What each body adds to the error at the worst place of the pass, along the error; red adds, green takes off.",
        body_shares,
        ("budget/body_share",),
    ),
    Plot(
        "Elements, and what to stiffen",
        "Left: error by elastic element and direction at the worst place. Right: change of the length of the error if "
        "that element alone were 10 % stiffer.",
        stiffening,
        ("budget/stiffening_gain",),
    ),
    Plot(
        "Error along the pass", "Error of the tool point against the part; the dot is the worst place that is cut.", along_the_pass,
        ("surface/f4",),
    ),
    Plot(
        "Error in plan", "Where along the program the part goes wrong; the ring is where this error is largest.", plan,
        ("surface/error_on_path",),
    ),
    Plot(
        "Machined wall",
        "Error of the finished wall along its normal, over the way and over the cutting length of the tool.",
        wall,
        ("surface/wall_error",),
    ),
    Plot(
        "Random errors", "Which body the variance of the error comes from.", variance, ("uncertainty/variance_share",),
    ),
    Plot(
        "The chain", "Origins of the bodies at the start of the pass, from the part to the tool point.", chain,
        ("motion/body_origin",),
    ),
    Plot(
        "Volumetric error",
        "Length of the geometric error in the middle planes of the working space, over the commands.",
        slices, ("volume/error",),
    ),
    Plot("Body diagonals", "Error along the four body diagonals (ISO 230-6).", diagonals, ("volume/diagonal_error",)),
]  # fmt: skip
