"""Plots of a program in a stock in 3D: deviation of the part, the machined stock, load along the program."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from cutwise.app.plots.figures import INK, SERIES, SOFT, Plot, curve, figure, legend_above, scale

if TYPE_CHECKING:
    from cutwise.results import Result

_POINTS = 30_000  # samples that are drawn
_CELLS = 300  # of a map that is drawn, along its longer side
_DEVIATION = LinearSegmentedColormap.from_list("deviation", ["#2166ac", "#f7f7f7", "#b2182b"])


def deviation(result: "Result") -> Figure:
    """Deviation of the machined surface from the part, seen from above."""
    return _deviation(result, "surface")


def ideal_deviation(result: "Result") -> Figure:
    """The same of the surface that the planned path would leave."""
    return _deviation(result, "surface_ideal")


def offset(result: "Result") -> Figure:
    """How far drives, bending and carrier move the tool beside its path."""
    data = result["offset"]
    factor, unit = scale("length")
    small, small_unit = scale("small_length")
    drawn = figure(3.4)
    axes = drawn.subplots()
    for k, axis in enumerate("xyz"):
        values = small * data["offset"].sel(axis=axis).values
        curve(axes, factor * data["along"].values, values, color=SERIES[k], linewidth=0.8, label=axis)
    axes.set(xlabel=f"way along the path [{unit}]", ylabel=f"tool less its planned place [{small_unit}]")
    axes.margins(x=0)
    legend_above(axes, 3)
    return drawn


def _deviation(result: "Result", group: str) -> Figure:
    data = result[group]
    step = max(1, data.sizes["sample"] // _POINTS)
    point, value = data["point"].values[::step], data["deviation"].values[::step]
    order = np.argsort(np.abs(value))  # the worst on top
    factor, unit = scale("length")
    small, small_unit = scale("small_length")
    limit = float(data.attrs.get("tolerance", 0.0)) or max(float(np.abs(value).max()), 1e-9)
    drawn = figure(4.8)
    axes = drawn.subplots()
    dots = axes.scatter(
        factor * point[order, 0], factor * point[order, 1], c=small * value[order], s=3.0, cmap=_DEVIATION,
        vmin=-small * limit, vmax=small * limit, linewidths=0.0, rasterized=True,
    )  # fmt: skip
    bar = drawn.colorbar(dots, ax=axes, extend="both")
    bar.set_label(f"deviation [{small_unit}]: blue cut into the part, red material left")
    axes.set(xlabel=f"x [{unit}]", ylabel=f"y [{unit}]", aspect="equal")
    return drawn


def machined(result: "Result") -> Figure:
    """Height of the machined stock, seen from above."""
    stock = result["stock"]
    step = max(1, max(stock.sizes["x"], stock.sizes["y"]) // _CELLS)
    factor, unit = scale("length")
    x, y, height = stock["x"].values[::step], stock["y"].values[::step], stock["height"].values[::step, ::step]
    drawn = figure(4.4)
    axes = drawn.subplots()
    picture = axes.imshow(
        factor * height, origin="lower", cmap="viridis", interpolation="nearest",
        extent=(factor * x[0], factor * x[-1], factor * y[0], factor * y[-1]),
    )  # fmt: skip
    drawn.colorbar(picture, ax=axes).set_label(f"height [{unit}]")
    axes.set(xlabel=f"x [{unit}]", ylabel=f"y [{unit}]")
    return drawn


def load(result: "Result") -> Figure:
    """Removal rate, torque and force along the program."""
    motion = result["motion"]
    time = motion["time"].values
    forced = bool((motion["torque"].values > 0.0).any())
    drawn = figure(4.6 if forced else 2.6)
    parts = drawn.subplots(2 if forced else 1, sharex=True, squeeze=False)[:, 0]
    factor, unit = scale("angle")
    curve(parts[0], time, factor * motion["immersion"].values, color=SERIES[3], linewidth=0.8)
    parts[0].set(ylabel=f"contact angle [{unit}]")
    if forced:
        factor, unit = scale("force")
        curve(parts[1], time, factor * motion["force_xy_peak"].values, color=SOFT, linewidth=0.8, label="xy, peak")
        curve(parts[1], time, factor * motion["force"].sel(axis="z").values, color=INK, linewidth=0.8, label="up, mean")
        parts[1].set(ylabel=f"force on the tool [{unit}]")
        legend_above(parts[1], 2)
    parts[-1].set(xlabel="time [s]")
    parts[-1].margins(x=0)
    return drawn


PLOTS: list[Plot] = [
    Plot("Deviation from the part", "Machined surface against the nominal part, seen along the tool axis; positive (red) is "
         "material left, negative (blue) is cut into the part; the limits of the colours are the tolerance.", deviation,
         ("surface/deviation", "surface/point")),
    Plot("Deviation of the planned path", "The same for the surface that the tool would leave if nothing moved it beside its path.",
         ideal_deviation, ("surface_ideal/deviation", "surface_ideal/point")),
    Plot("Tool beside its path", "Offset of the tool by drives, its bending and what carries it, in program axes, with the lag "
         "along the path.", offset, ("offset/offset", "offset/along")),
    Plot("Machined stock", "Height of what is left, seen along the tool axis.", machined, ("stock/height",)),
    Plot("Load along the program", "Contact angle of the flutes and force on the tool at the stations of feed moves.", load,
         ("motion/immersion", "lines/removed_volume")),
]  # fmt: skip
