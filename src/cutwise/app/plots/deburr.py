"""Plots of a deburring pass: forces, edge error, spindle (Berselli et al. 2016, Figs. 15 and 16, and beyond)."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cutwise.app.plots.figures import (
    BAD,
    GOOD,
    INK,
    SERIES,
    SHADE,
    SOFT,
    ZONE,
    Plot,
    curve,
    figure,
    holds,
    legend_above,
    line_note,
    note,
    scale,
)
from cutwise.app.plots.spindle import PLOT as SPINDLE

if TYPE_CHECKING:
    from cutwise.results import Result

_AXES = {"x": "along the feed, x", "y": "off the work, y", "z": "along the spindle, z"}
_STILL = 1e-6  # [m/s] below this a piston counts as stuck
_PLATEAUS = (("loaded", SERIES[1]), ("frictionless", SOFT), ("unloaded", SERIES[3]))
_STATES = {"at rest, extended": SHADE, "stuck": SERIES[4], "sliding": SERIES[0], "at the stop": BAD}
_STATE_CELLS = 240


def burr_forces(result: "Result") -> Figure:
    """Components of the burr force over time (the paper's Fig. 15)."""
    force = result["cutting"]["burr_force"]
    factor, unit = scale("force")
    drawn = figure(3.1)
    axes = drawn.subplots()
    _lead_in(axes, result)
    for axis, colour in zip("xyz", SERIES, strict=False):
        curve(axes, force["time"].values, factor * force.sel(axis=axis).values, color=colour, label=_AXES[axis])
    axes.set(xlabel="time [s]", ylabel=f"force of the burr on the tool [{unit}]")
    axes.margins(x=0)
    legend_above(axes, 3)
    return drawn


def error_over_time(result: "Result") -> Figure:
    """Edge error at the tool over time, with the plateaus between which friction can hold it (Fig. 16)."""
    error = result["surface"]["error_at_tool"]
    factor, unit = scale("length")
    tolerance = factor * result.scenario.operation.tolerance  # type: ignore[attr-defined]
    drawn = figure(3.3)
    axes = drawn.subplots()
    _lead_in(axes, result)
    _tolerance(axes, result)
    curve(axes, error["time"].values, factor * error.values, color=INK)
    for name, colour in _PLATEAUS:
        measure = result.measures.get(f"surface_error_{name}")
        if measure is not None:
            value, below = factor * measure.value, name == "loaded"
            clear = min(value, -tolerance) if below else value
            line_note(axes, value, f"{name} {value:.3g} {unit}", colour, above=not below, text_at=clear)
    axes.set(xlabel="time [s]", ylabel=f"edge error e [{unit}]")
    axes.margins(x=0, y=0.12)
    return drawn


def error_along_edge(result: "Result") -> Figure:
    """Edge error that stays on the part, where the pass has settled, in the scale of the tolerance."""
    surface = result["surface"]
    w, error, burr = (surface[name].values for name in ("w", "error", "burr_height"))
    factor, unit = scale("length")
    tolerance, start = result.scenario.operation.tolerance, _lead_in_way(result)  # type: ignore[attr-defined]
    drawn = figure(3.1)
    axes = drawn.subplots()
    axes.axvspan(factor * w[0], factor * start, color=SHADE, linewidth=0)
    _tolerance(axes, result)
    curve(axes, factor * w, factor * error, color=INK, label="edge error after the pass")
    settled = error[w >= start] if (w >= start).any() else error
    low, high = min(settled.min(), -1.3 * tolerance), max(settled.max(), 1.3 * tolerance)
    room = 0.15 * (high - low)
    if burr.min() < high + room:
        curve(axes, factor * w, factor * burr, color=SOFT, linestyle=":", linewidth=1.2, label="burr before the pass")
    axes.set(xlabel=f"way along the edge w [{unit}]", ylabel=f"edge error e [{unit}]")
    axes.set_xlim(factor * w[0], factor * w[-1])
    axes.set_ylim(factor * (low - room), factor * (high + room))
    if start > w[0]:
        _name_lead_in(axes, factor * w[0])
    legend_above(axes, 3)
    return drawn


def band(result: "Result") -> Figure:
    """Where between the plateaus the run ended."""
    factor, unit = scale("length")
    value = {name: factor * result.measures[f"surface_error_{name}"].value for name in ("loaded", "unloaded", "mean")}
    drawn = figure(1.5)
    axes = drawn.subplots()
    tolerance = factor * result.scenario.operation.tolerance  # type: ignore[attr-defined]
    axes.axvspan(-tolerance, tolerance, color=ZONE, linewidth=0)
    axes.plot(
        [value["loaded"], value["unloaded"]], [0, 0], color=SERIES[0], linewidth=7, solid_capstyle="butt", alpha=0.35
    )
    for name, text, side in (("loaded", "loading plateau", "right"), ("unloaded", "unloading plateau", "left")):
        axes.plot(value[name], 0, "|", color=SERIES[0], markersize=16, markeredgewidth=2)
        offset = (-8, 0) if side == "right" else (8, 0)
        note(axes, f"{text}\n{value[name]:.3g} {unit}", (value[name], 0), offset, ha=side, va="center")
    frictionless = result.measures.get("surface_error_frictionless")
    if frictionless is not None:
        place = (factor * frictionless.value, 0)
        axes.plot(*place, "d", color=SOFT, markersize=6)
        note(axes, f"frictionless {place[0]:.3g} {unit}", place, (0, -9), ha="center", va="top", color=SOFT)
    axes.plot(value["mean"], 0, "o", color=INK, markersize=8)
    text = f"this run {value['mean']:.3g} {unit}"
    note(axes, text, (value["mean"], 0), (0, 15), ha="center", va="bottom", fontsize=8.5, weight="bold")
    axes.set(xlabel=f"edge error e [{unit}]; shaded: within the tolerance", yticks=[], ylim=(-1, 1))
    axes.margins(x=0.22)
    axes.grid(visible=False)
    axes.spines["left"].set_visible(False)
    return drawn


def spindle_motion(result: "Result") -> Figure:
    """Deflection of the tip, travel of the pistons and what each piston does."""
    structure = result["structure"]
    time, travel = structure["time"].values, structure["piston_travel"].values
    factor, unit = scale("length")
    drawn = figure(6.0)
    top, middle, bottom = drawn.subplots(3, 1, sharex=True, height_ratios=(1.0, 1.0, 0.8))
    _lead_in(top, result)
    _lead_in(middle, result, named=False)
    for axis, colour in zip("xy", SERIES, strict=False):
        curve(top, time, factor * structure["tip_deflection"].sel(axis2=axis).values, color=colour, label=_AXES[axis])
    top.set(ylabel=f"tip deflection [{unit}]")
    legend_above(top, 2)
    for piston in range(travel.shape[1]):
        curve(middle, time, factor * travel[:, piston], color=SERIES[piston % len(SERIES)], label=str(piston))
    middle.set(ylabel=f"piston travel [{unit}]")
    stroke = _stroke(result)
    if stroke is not None:
        line_note(middle, factor * stroke, f"stroke {factor * stroke:.3g} {unit}", BAD, above=False)
    legend_above(middle, travel.shape[1])
    _piston_states(bottom, time, travel, stroke)
    bottom.set(xlabel="time [s]", ylabel="piston", yticks=range(travel.shape[1]))
    bottom.set_xlim(time[0], time[-1])
    bottom.grid(visible=False)
    legend_above(bottom, len(_STATES))
    return drawn


def static_characteristic(result: "Result") -> Figure:
    """Static force at the tip over its displacement at this pressure, and the way that this run took."""
    structure = result["structure"].dataset
    length, length_unit = scale("length")
    force, force_unit = scale("force")
    levels = {
        name: force * structure.attrs[f"{name}_force"] for name in ("breakaway", "loading", "unloading", "return")
    }
    stop = length * structure.attrs["stop"]
    drawn = figure(3.6)
    axes = drawn.subplots()
    ceiling = 1.15 * max(1.1 * max(levels.values()), _run_on_characteristic(axes, result))
    at = length * structure["displacement"].values
    loading, unloading = (force * structure[f"characteristic_{branch}"].values for branch in ("loading", "unloading"))
    axes.plot([0, 0, *at[1:], stop], [0, levels["breakaway"], *loading[1:], ceiling], color=SERIES[1], linewidth=2,
              label="loading branch")  # fmt: skip
    axes.plot(
        [stop, *at[::-1]], [loading[-1], *unloading[::-1]], color=SERIES[3], linewidth=2, label="unloading branch"
    )
    if "characteristic_frictionless" in structure:
        axes.plot(at[1:], force * structure["characteristic_frictionless"].values[1:], color=SOFT, linestyle="--",
                  linewidth=1.2, label="frictionless")  # fmt: skip
    for name, text, colour, rise in (
        ("breakaway", "breakaway", SERIES[1], 6),
        ("return", "re-centres", SERIES[3], -10),
    ):
        axes.plot(0, levels[name], "o", color=colour, markersize=6, clip_on=False, zorder=5)
        note(axes, f"{text} {levels[name]:.3g} {force_unit}", (0, levels[name]), (8, rise), color=colour)
    for name, colour in (("loading", SERIES[1]), ("unloading", SERIES[3])):
        note(axes, f"{levels[name]:.3g} {force_unit}", (0.93 * stop, levels[name]), (0, 4), ha="right", color=colour)
    note(axes, "stop", (stop, ceiling), (-4, -2), ha="right", va="top", color=SOFT)
    axes.set(xlabel=f"displacement of the tip [{length_unit}]", ylabel=f"lateral force at the tip [{force_unit}]")
    axes.set_xlim(-0.02 * stop, 1.03 * stop)
    axes.set_ylim(0, ceiling)
    legend_above(axes, 4)
    return drawn


def tooth_forces(result: "Result") -> Figure:
    """Burr force tooth by tooth over a few tooth periods, with its means."""
    force = result["tooth"]["burr_force"]
    factor, unit = scale("force")
    after = 1e6 * (force["tooth_time"].values - float(force["tooth_time"][0]))
    drawn = figure(2.9)
    axes = drawn.subplots()
    for axis, colour in zip("xyz", SERIES, strict=False):
        values = factor * force.sel(axis=axis).values
        curve(axes, after, values, color=colour, label=_AXES[axis])
        axes.axhline(values.mean(), color=colour, linewidth=0.9, linestyle="--")
    axes.set(xlabel=f"time after {float(force['tooth_time'][0]):.6g} s [µs]", ylabel=f"force of the burr [{unit}]")
    axes.margins(x=0)
    legend_above(axes, 3)
    return drawn


def _lead_in(axes: Axes, result: "Result", *, named: bool = True) -> None:
    end = result.scenario.operation.lead_in_time  # type: ignore[attr-defined]
    if end > 0.0:
        axes.axvspan(0.0, end, color=SHADE, linewidth=0)
        if named:
            _name_lead_in(axes, 0.0)


def _name_lead_in(axes: Axes, start: float) -> None:
    place = axes.get_xaxis_transform()
    note(axes, "lead-in", (start, 1.0), (4, -4), xycoords=place, va="top", color=SOFT)


def _lead_in_way(result: "Result") -> float:
    if "error_at_tool" not in result["surface"]:
        return 0.0  # at rest nothing is led in
    operation = result.scenario.operation  # type: ignore[attr-defined]
    return float(operation.lead_in_time * operation.feed)


def _tolerance(axes: Axes, result: "Result") -> None:
    factor, unit = scale("length")
    tolerance = factor * result.scenario.operation.tolerance  # type: ignore[attr-defined]
    axes.axhspan(-tolerance, tolerance, color=ZONE, linewidth=0, label=f"tolerance ±{tolerance:.3g} {unit}")
    for side in (-tolerance, tolerance):
        axes.axhline(side, color=GOOD, linewidth=0.7)


def _stroke(result: "Result") -> float | None:
    margin = result.measures.get("stroke_margin")
    return None if margin is None else float(result["structure"]["piston_travel"].max()) + margin.value


def _run_on_characteristic(axes: Axes, result: "Result") -> float:
    """Lateral cutting force over the deflection of the tip, and where both are at the end; the largest force drawn."""
    if not holds(result, "cutting/burr_force") or not holds(result, "cutting/work_force"):
        return 0.0
    cutting = result["cutting"].dataset
    total = (cutting["burr_force"] + cutting["work_force"]).sel(axis=["x", "y"]).values
    way = np.hypot(*result["structure"]["tip_deflection"].values.T) * scale("length")[0]
    lateral = np.hypot(*total.T) * scale("force")[0]
    rows = np.unique(np.linspace(0, way.size - 1, 1500).astype(int))
    axes.plot(way[rows], lateral[rows], color=INK, linewidth=0.9, alpha=0.6, label="cutting force in this run")
    axes.plot(way[-1], lateral[-1], "o", color=INK, markersize=5)
    return float(lateral[rows].max())


def _piston_states(axes: Axes, time: np.ndarray, travel: np.ndarray, stroke: float | None) -> None:
    """A strip per piston, coloured by what it does; a cell that holds any motion counts as sliding."""
    edges = np.unique(np.linspace(0, time.size - 1, _STATE_CELLS + 1).astype(int))
    first, last = edges[:-1], edges[1:]
    steps = np.abs(np.diff(travel, axis=0)) > _STILL * np.diff(time)[:, None]
    moving = np.add.reduceat(steps, first, axis=0) > 0
    largest = 1e-6 * (stroke or float(travel.max()))
    extended = np.maximum(travel[first], travel[last]) <= largest
    stopped = (travel[last] >= stroke - largest) if stroke is not None else np.zeros_like(extended)
    conditions = {"at rest, extended": extended, "at the stop": stopped & ~moving, "sliding": moving & ~extended}
    state = np.select(list(conditions.values()), range(3), 3)
    for code, name in enumerate((*conditions, "stuck")):
        label: str | None = name
        for piston in range(travel.shape[1]):
            spans = _spans(state[:, piston] == code)
            if spans.size:
                begin = time[first[spans[:, 0]]]
                axes.broken_barh(list(zip(begin, time[last[spans[:, 1]]] - begin, strict=True)), (piston - 0.4, 0.8),
                                 color=_STATES[name], linewidth=0, label=label)  # fmt: skip
                label = None


def _spans(present: np.ndarray) -> np.ndarray:
    """First and last index of each run of true values, shape (n, 2)."""
    turns = np.diff(np.concatenate([[0], present.astype(int), [0]]))
    return np.column_stack([np.flatnonzero(turns == 1), np.flatnonzero(turns == -1) - 1])


PLOTS = [
    Plot(
        "Burr force over time",
        "Force of the burr on the tool, mean over a tooth: x along the feed, y from the work to the tool, z along the "
        "spindle toward the motor. The shaded part is the lead-in.",
        burr_forces, ("cutting/burr_force", "surface/error_at_tool"),
    ),
    Plot(
        "Edge error over time",
        "e at the lowest point of the mill: positive where burr is left, negative where the part is cut. The dashed "
        "lines are the equilibria with the spindle pushed out, without friction, and returning.",
        error_over_time, ("surface/error_at_tool",),
    ),
    Plot(
        "Edge error along the edge",
        "What stays on the part, in the scale of the tolerance (green).",
        error_along_edge, ("surface/error", "surface/burr_height"),
    ),
    Plot(
        "The band of equilibria",
        "Seal friction can hold the tool anywhere between the plateaus; the history of the pass decides where.",
        band, ("measures/surface_error_loaded", "measures/surface_error_unloaded", "measures/surface_error_mean"),
    ),
    Plot(
        "Spindle during the pass",
        "Deflection of the tool tip, travel of each piston, and whether it rests, sticks, slides or is at its stop.",
        spindle_motion, ("structure/tip_deflection", "structure/piston_travel"),
    ),
    Plot(
        "Static characteristic of the spindle at this pressure",
        "No motion below breakaway, then nearly constant force up to the stop; less on the way back. The thin line is "
        "the lateral cutting force of this run over the deflection, without weight and inertia; the dot is its end.",
        static_characteristic, ("structure/characteristic_loading", "structure/characteristic_unloading"),
    ),
    Plot(
        "Burr force tooth by tooth",
        "A few tooth periods at the end of the steady part, reconstructed from the trajectory; dashed: means.",
        tooth_forces, ("tooth/burr_force",),
    ),
    SPINDLE,
]  # fmt: skip
