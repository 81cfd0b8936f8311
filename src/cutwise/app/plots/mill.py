"""Plots of milling with CNC drives: corner, contour error, forces, voltages, frequency response."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from cutwise.app.plots import arm, stock
from cutwise.app.plots.figures import (
    BAD,
    GOOD,
    INK,
    SERIES,
    SOFT,
    ZONE,
    Plot,
    curve,
    figure,
    legend_above,
    line_note,
    note,
    scale,
)

if TYPE_CHECKING:
    from cutwise.results import Result

_PICTURE = 8e-3  # [m] half width of the picture of the worst place
_LENGTH_OF_ERROR = 1.5e-3  # [m] how long the largest error is drawn
_POINTS = 4000


def worst_place(result: "Result") -> Figure:
    """Commanded path and actual path where the path is left most, the error magnified."""
    motion, error = result["motion"], result["surface"]["contour_error"].values
    commanded, actual = motion["commanded"].values[:, :2], motion["actual"].values[:, :2]
    largest = float(np.nanmax(np.abs(error)))
    worst = int(np.nanargmax(np.abs(error)))
    times = _round_down(_LENGTH_OF_ERROR / largest) if largest > 0.0 else 1.0
    factor, unit = scale("length")
    centre = commanded[worst]
    near = np.flatnonzero(np.abs(commanded - centre).max(axis=1) <= 1.2 * _PICTURE)
    runs = np.split(near, np.flatnonzero(np.diff(near) > 1) + 1)
    drawn = figure(4.6)
    axes = drawn.subplots()
    for number, run in enumerate(runs):
        step = max(1, run.size // _POINTS)
        told = commanded[run][::step]
        shown = told + times * (actual[run][::step] - told - _along(told, actual[run][::step]))
        names = ("commanded", f"actual, error across the path × {times:g}") if number == 0 else (None, None)
        axes.plot(*(factor * told.T), color=SOFT, linewidth=1.2, label=names[0])
        axes.plot(*(factor * shown.T), color=SERIES[1], label=names[1])
    axes.annotate(
        f"{scale('small_length')[0] * abs(error[worst]):.3g} {scale('small_length')[1]}", tuple(factor * centre),
        xytext=(14, 14), textcoords="offset points", color=INK, weight="bold",
        arrowprops={"arrowstyle": "-", "color": SOFT},
    )  # fmt: skip
    axes.set(xlabel=f"x [{unit}]", ylabel=f"y [{unit}]", aspect="equal")
    axes.set_xlim(*(factor * (centre[0] + np.array([-1.6, 1.6]) * _PICTURE)))
    axes.set_ylim(*(factor * (centre[1] + np.array([-1.0, 1.0]) * _PICTURE)))
    legend_above(axes, 2)
    return drawn


def _along(commanded: np.ndarray, actual: np.ndarray) -> np.ndarray:
    """The part of the deviation along the path, which is lag and no contour error."""
    direction = np.gradient(commanded, axis=0) if commanded.shape[0] > 1 else np.zeros_like(commanded)
    length = np.linalg.norm(direction, axis=1, keepdims=True)
    unit = np.divide(direction, length, out=np.zeros_like(direction), where=length > 1e-12)
    return np.asarray(unit * np.sum((actual - commanded) * unit, axis=1, keepdims=True))


def _round_down(value: float) -> float:
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * max(step for step in (1.0, 2.0, 5.0) if step * power <= value))


def contour_error(result: "Result") -> Figure:
    """Contour error along the path."""
    travelled, error = result["motion"]["travelled"].values, result["surface"]["contour_error"].values
    factor, unit = scale("small_length")
    way, way_unit = scale("length")
    drawn = figure(2.9)
    axes = drawn.subplots()
    axes.axhline(0.0, color=SOFT, linewidth=0.8)
    moving = np.append(np.diff(travelled) > 0.0, False)
    curve(axes, way * travelled[moving], factor * error[moving], color=INK)
    limit = result.scenario.requirements.get("contour_error_max")
    if limit is not None and limit.max is not None:
        line_note(axes, factor * limit.max, "limit", SERIES[2])
        line_note(axes, -factor * limit.max, "limit", SERIES[2], above=False)
    axes.set(xlabel=f"way along the path [{way_unit}]", ylabel=f"contour error [{unit}]")
    axes.margins(x=0)
    return drawn


def speed(result: "Result") -> Figure:
    """Planned and actual speed over time, and the immersion angle."""
    motion, immersion = result["motion"], result["engagement"]["immersion"]
    factor, unit = scale("speed")
    time = motion["time"].values
    drawn = figure(4.0)
    top, bottom = drawn.subplots(2, sharex=True)
    curve(top, time, factor * motion["speed_planned"].values, color=SOFT, linestyle="--", label="planned")
    curve(top, time, factor * motion["speed_actual"].values, color=SERIES[0], label="actual")
    top.set(ylabel=f"speed [{unit}]")
    legend_above(top, 2)
    curve(bottom, time, scale("angle")[0] * immersion.values, color=SERIES[3])
    bottom.set(xlabel="time [s]", ylabel="immersion angle [°]")
    bottom.margins(x=0)
    return drawn


def forces(result: "Result") -> Figure:
    """Mean and peak of the cutting force over each sample of the controller."""
    cutting = result["cutting"]
    factor, unit = scale("force")
    time = cutting["time"].values
    drawn = figure(3.2)
    axes = drawn.subplots()
    curve(axes, time, factor * cutting["force_xy_peak"].values, color=SOFT, alpha=0.4, linewidth=1.0, label="xy, peak")
    for axis, colour in zip("xy", SERIES, strict=False):
        curve(axes, time, factor * cutting["force"].sel(axis=axis).values, color=colour, linewidth=1.0, label=axis)
    axes.set(xlabel="time [s]", ylabel=f"force on the tool [{unit}]")
    axes.margins(x=0)
    legend_above(axes, 3)
    return drawn


def voltages(result: "Result") -> Figure:
    """Output of the controllers with its limit, and the torque of the motors with what cutting takes of it."""
    motion = result["motion"]
    time = motion["time"].values
    torque, torque_unit = scale("moment")
    drawn = figure(4.6)
    top, bottom = drawn.subplots(2, sharex=True)
    for axis, colour in zip(motion["axis"].values, SERIES, strict=False):
        curve(top, time, motion["voltage"].sel(axis=axis).values, color=colour, linewidth=1.0, label=axis)
        motor, load = (torque * motion[name].sel(axis=axis).values for name in ("motor_torque", "cutting_torque"))
        curve(bottom, time, motor, color=colour, linewidth=1.0, label=f"{axis}, motor")
        curve(bottom, time, load, color=colour, linewidth=0.8, linestyle=":", label=f"{axis}, cutting")
    limit = result.scenario.drives.control.saturation  # type: ignore[attr-defined]
    if result.measures["drive_voltage_max"].value > 0.6 * limit:
        line_note(top, limit, "limit", SERIES[5])
        line_note(top, -limit, "limit", SERIES[5], above=False)
    top.set(ylabel="voltage [V]")
    legend_above(top, 2)
    bottom.set(xlabel="time [s]", ylabel=f"torque at the motor [{torque_unit}]")
    bottom.margins(x=0)
    legend_above(bottom, 4)
    return drawn


def frequency_response(result: "Result") -> Figure:
    """Closed loop and loop gain of both axes, continuous and sampled."""
    motion = result["motion"]
    hertz = motion["frequency"].values
    drawn = figure(4.8)
    closed, opened, phase = drawn.subplots(3, sharex=True)
    for axis, colour in zip(motion["axis"].values, SERIES, strict=False):
        for kind, style, name in (("", "--", "continuous"), ("sampled_", "-", "sampled")):
            label = f"{axis}, {name}"
            gain = motion[f"{kind}closed_loop_gain"].sel(axis=axis).values
            closed.plot(hertz, 20.0 * np.log10(gain), style, color=colour, label=label)
            gain = motion[f"{kind}open_loop_gain"].sel(axis=axis).values
            opened.plot(hertz, 20.0 * np.log10(gain), style, color=colour)
            phase.plot(hertz, np.degrees(motion[f"{kind}open_loop_phase"].sel(axis=axis).values), style, color=colour)
    closed.axhline(-3.0, color=SOFT, linewidth=0.8)
    opened.axhline(0.0, color=SOFT, linewidth=0.8)
    phase.axhline(-180.0, color=SOFT, linewidth=0.8)
    closed.set(ylabel="closed loop [dB]", xscale="log")
    opened.set(ylabel="loop gain [dB]")
    phase.set(xlabel="frequency [Hz]", ylabel="phase [°]")
    legend_above(closed, 4)
    return drawn


def comparison(result: "Result") -> Figure:
    """Time, contour error and load of the corner strategies side by side."""
    data = result["comparison"]
    names = [str(name) for name in data["strategy"].values]
    error = "drive_error_max" if "drive_error_max" in data else "contour_error_max"
    shown = [("cycle_time", "time"), (error, "small_length"), ("force_xy_mean_corner", "force")]
    shown = [(name, dimension) for name, dimension in shown if name in data]
    drawn = figure(0.55 * len(names) + 1.0)
    for axes, (name, dimension) in zip(np.atleast_1d(drawn.subplots(1, len(shown))), shown, strict=True):
        factor, unit = scale(dimension)
        values = factor * data[name].values
        bars = axes.barh(names, values, color=SERIES[0], height=0.6)
        axes.bar_label(bars, [f"{value:.4g}" for value in values], padding=3, fontsize=8)
        axes.set(xlabel=f"{name} [{unit}]")
        axes.margins(x=0.2)
        axes.invert_yaxis()
        if axes is not drawn.axes[0]:
            axes.set_yticklabels([])
    return drawn


def tip_and_wall(result: "Result") -> Figure:
    """Displacement of the tool tip over the run, and the error of the wall that its teeth leave."""
    structure = result["structure"]
    factor, unit = scale("small_length")
    time = structure["time"].values
    drawn = figure(4.6)
    top, bottom = drawn.subplots(2, sharex=True)
    curve(top, time, factor * structure["tip_peak"].values, color=SOFT, alpha=0.4, linewidth=1.0, label="largest")
    for axis, colour in zip("xy", SERIES, strict=False):
        curve(top, time, factor * structure["tip"].sel(axis=axis).values, color=colour, linewidth=1.0, label=axis)
    top.set(ylabel=f"tool tip [{unit}]")
    legend_above(top, 3)
    low, high = (factor * structure[f"wall_error_{end}"].values for end in ("min", "max"))
    bottom.fill_between(*_envelope(time, low, high), color=SERIES[1], linewidth=0.4)
    bottom.axhline(0.0, color=SOFT, linewidth=0.8)
    bottom.set(xlabel="time [s]", ylabel=f"wall left [{unit}]")
    bottom.margins(x=0)
    return drawn


def _envelope(time: np.ndarray, low: np.ndarray, high: np.ndarray, bins: int = 1200) -> tuple[np.ndarray, ...]:
    """A long band with few points: the least and the largest value of each bin, at its first instant; NaN where it has none."""
    if time.size <= bins:
        return time, low, high
    first = np.linspace(0, time.size, bins + 1).astype(int)[:-1]
    least, most = np.fmin.reduceat(low, first), np.fmax.reduceat(high, first)
    return time[first], least, most


def wall_made_of(result: "Result") -> Figure:
    """Error of a straight wall along the path, and what drives, bodies and tip give to it."""
    structure, travelled = result["structure"], result["motion"]["travelled"].values
    factor, unit = scale("small_length")
    way, way_unit = scale("length")
    wall = factor * structure["wall_error"].values
    cut = np.isfinite(wall)
    drawn = figure(3.4)
    axes = drawn.subplots()
    axes.axhline(0.0, color=SOFT, linewidth=0.8)
    names = [name for name in structure.data_vars if str(name).startswith(("deviation_", "deflection_"))]
    for name, colour in zip(names, SERIES, strict=False):
        part = -factor * structure[name].sel(axis="y").values
        curve(axes, way * travelled[cut], part[cut], color=colour, linewidth=1.0, label=str(name).split("_", 1)[1])
    curve(axes, way * travelled[cut], wall[cut], color=INK, label="wall")
    axes.set(xlabel=f"way along the path [{way_unit}]", ylabel=f"error of the wall [{unit}]")
    axes.margins(x=0)
    legend_above(axes, 4)
    return drawn


def lobes(result: "Result") -> Figure:
    """Stable and unstable pairs of spindle speed and axial depth, and where the operation is."""
    data = result["lobes"]
    speed, depth = scale("angular_speed"), scale("length")
    x, y = speed[0] * data["spindle_speed"].values, depth[0] * data["depth"].values
    drawn = figure(3.6)
    axes = drawn.subplots()
    growth = {str(name): data["growth"].sel(contact=name).values.T for name in data["contact"].values}
    axes.contourf(x, y, np.maximum.reduce(list(growth.values())), levels=[0.0, 1.0], colors=[ZONE])
    for name, style, colour, words in (("straight", "-", GOOD, "straight"), ("corner", "--", BAD, "heaviest contact")):
        if name in growth:
            axes.contour(x, y, growth[name], levels=[1.0], colors=[colour], linewidths=1.3, linestyles=style)
            axes.plot([], [], style, color=colour, label=f"{words}: stable below")
    here = (speed[0] * float(data["speed_met"]), depth[0] * float(data["depth_met"].max()))
    axes.plot(*here, "o", color=INK, markersize=6)
    note(axes, "this run", here, (7, 5))
    axes.set(xlabel=f"spindle speed [{speed[1]}]", ylabel=f"axial depth of cut [{depth[1]}]")
    legend_above(axes, 2)
    return drawn


def vibration(result: "Result") -> Figure:
    """Vibration of the tool tip in a steady cut at the largest immersion."""
    tip = result["vibration"]["tip_corner"]
    factor, unit = scale("small_length")
    drawn = figure(2.9)
    axes = drawn.subplots()
    for axis, colour in zip("xy", SERIES, strict=False):
        curve(
            axes,
            tip["vibration_time"].values,
            factor * tip.sel(axis=axis).values,
            color=colour,
            linewidth=1.0,
            label=axis,
        )
    axes.set(xlabel="time [s]", ylabel=f"tool tip [{unit}]")
    axes.margins(x=0)
    legend_above(axes, 2)
    return drawn


_ERROR = "surface/contour_error"
PLOTS: list[Plot] = [
    *arm.PLOTS,
    *stock.PLOTS,
    Plot("Where the path is left most", "Commanded and actual path of the tool centre; the error is magnified.",
         worst_place, (_ERROR, "motion/actual", "measures/contour_error_max")),
    Plot("Corner strategies", "The same corner run in other ways. The contour error of a blend is measured from the corner "
         "that it rounds, that of a fillet from the fillet; drive_error_max is what the drives add to either.", comparison,
         ("comparison/cycle_time",)),
    Plot("Contour error", "Positive to the right of the path, into the wall.", contour_error, (_ERROR,)),
    Plot("Speed and immersion", "What the look-ahead planned, what the drives did, and how far the mill is immersed.",
         speed, ("motion/speed_actual", "engagement/immersion")),
    Plot("Cutting force", "On the tool, mean over each sample of the controller, and peak in the plane.",
         forces, ("cutting/force", "measures/force_xy_peak")),
    Plot("Drives", "Output of the position controllers; torque of each motor, and mean torque of the cutting force on it.",
         voltages, ("motion/cutting_torque", "measures/drive_voltage_max")),
    Plot("Frequency response", "Position loops without friction; the sampled ones are those that run.",
         frequency_response, ("motion/closed_loop_gain",)),
    Plot("Tool tip and wall", "Displacement of the tip by its modes, and the wall left: error of the drives plus tip where "
         "a tooth passes the wall; positive into the wall.", tip_and_wall, ("structure/tip_peak",)),
    Plot("Wall and what it is made of", "Error of the wall, and the parts of drives, bodies of the machine and tip modes; "
         "positive into the part.", wall_made_of, ("structure/deviation_drives", "measures/wall_error_min")),
    Plot("Stability", "Pairs of spindle speed and axial depth at which vibration dies out.", lobes, ("lobes/growth",)),
    Plot("Vibration of the tool tip", "Steady cut of the heaviest contact, from rest.", vibration,
         ("vibration/tip_corner",)),
]  # fmt: skip
