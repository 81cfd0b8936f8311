"""Plots of a drilled hole: forces over depth, deflection, posture map, the arm, the table of holes."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cutwise.app.holes import off_place
from cutwise.app.plots.figures import (
    BAD,
    GOOD,
    INK,
    SERIES,
    SHADE,
    SOFT,
    Plot,
    curve,
    figure,
    legend_above,
    line_note,
    scale,
)  # fmt: skip

if TYPE_CHECKING:
    from cutwise.results import Result

_SHARES = (("lips", SERIES[0]), ("chisel", SERIES[1]), ("margin", SERIES[4]))
_MOST_ROWS = 40


def shares_over_depth(result: "Result") -> Figure:
    """Thrust and torque at nominal feed over the depth of the tip, with the shares stacked."""
    cutting = result["cutting"]
    length, length_unit = scale("length")
    depth = length * cutting["depth"].values
    drawn = figure(3.4)
    left, right = drawn.subplots(1, 2)
    for axes, name, dimension in ((left, "thrust", "force"), (right, "torque", "moment")):
        factor, unit = scale(dimension)
        floor = np.zeros(depth.size)
        for share, colour in _SHARES:
            if f"{name}_{share}" not in cutting.dataset:
                continue
            top = floor + factor * cutting[f"{name}_{share}"].values
            axes.fill_between(depth, floor, top, color=colour, alpha=0.4, linewidth=0, label=share)
            floor = top
        curve(axes, depth, factor * cutting[f"{name}_nominal"].values, color=INK)
        _surfaces(axes, result)
        axes.set(xlabel=f"depth of the tip [{length_unit}]", ylabel=f"{name} [{unit}]")
        axes.margins(x=0)
        axes.set_ylim(bottom=0)
        legend_above(axes, 3)
    return drawn


def _surfaces(axes: Axes, result: "Result") -> None:
    """Where the corner has entered, the tip comes out and the corner comes out."""
    scenario, factor = result.scenario, scale("length")[0]
    cone, thickness = scenario.tool.cone_height, scenario.part.thickness  # type: ignore[attr-defined]
    for place, text in ((cone, "corner in"), (thickness, "tip out"), (thickness + cone, "corner out")):
        axes.axvline(factor * place, color=SOFT, linewidth=0.8, linestyle=":")
        axes.annotate(text, (factor * place, 1), xycoords=("data", "axes fraction"), xytext=(-2, -3), rotation=90,
                      textcoords="offset points", ha="right", va="top", color=SOFT, fontsize=7.5)  # fmt: skip


def deflection_over_time(result: "Result") -> Figure:
    """Deflection of the tool tip and actual feed over time, first hole."""
    structure, motion = result["structure"].isel(hole=0), result["motion"].isel(hole=0)
    time = structure["time"].values
    small, small_unit = scale("small_length")
    drawn = figure(4.6)
    top, bottom = drawn.subplots(2, 1, sharex=True)
    for axis, text, colour in zip("xyz", ("across, x", "across, y", "along the feed, z"), SERIES, strict=False):
        curve(top, time, small * structure["tip_deflection"].sel(axis=axis).values, color=colour, label=text)
    top.set(ylabel=f"tip deflection [{small_unit}]")
    legend_above(top, 3)
    feed, feed_unit = scale("feed_per_revolution")
    touched = motion["depth"].values > 0
    curve(bottom, time, np.where(touched, feed * motion["feed_per_rev"].values, np.nan), color=INK)
    given = feed * result.scenario.operation.feed_per_rev  # type: ignore[attr-defined]
    line_note(bottom, given, f"programmed {given:.3g} {feed_unit}", SOFT)
    bottom.set(xlabel="time [s]", ylabel=f"actual feed per turn [{feed_unit}]")
    bottom.margins(x=0)
    return drawn


def hole_path(result: "Result") -> Figure:
    """Lateral position of the hole over depth, every hole."""
    position, depth = result["surface"]["hole_position"], result["motion"]["depth"]
    position = position.copy(data=off_place(result))
    small, small_unit = scale("small_length")
    length, length_unit = scale("length")
    drawn = figure(3.0)
    axes = drawn.subplots()
    for number, hole in enumerate(position["hole"].values):
        z = depth.sel(hole=hole).values
        size = np.hypot(*position.sel(hole=hole).values.T)
        inside = (z > 0) & (z >= np.maximum.accumulate(z))
        label = f"hole {hole}" if position.sizes["hole"] <= 8 else None
        curve(axes, length * z[inside], small * size[inside], color=SERIES[number % len(SERIES)], label=label)
    _surfaces(axes, result)
    axes.set(xlabel=f"depth of the tip [{length_unit}]", ylabel=f"position error of the hole [{small_unit}]")
    axes.margins(x=0)
    if 1 < position.sizes["hole"] <= 8:
        legend_above(axes, 8)
    return drawn


def posture_map(result: "Result") -> Figure:
    """Axial compliance and skating ratio of every branch over the redundancy angle, first hole."""
    mapped = result["map"]
    angle = np.degrees(mapped["redundancy_angle"].values)
    within = mapped["within_limits"].values.astype(bool)
    chosen = result["motion"]["joint_angle"] if "motion" in result.stages.children else None
    drawn = figure(4.8)
    panels = drawn.subplots(2, 1, sharex=True)
    friction = result.scenario.contact.friction  # type: ignore[attr-defined]
    for axes, name, dimension, text in (
        (panels[0], "compliance_axial", "compliance", "axial compliance"),
        (panels[1], "skating_ratio", "dimensionless", "skating ratio"),
    ):
        factor, unit = scale(dimension)
        values = factor * np.where(within, mapped[name].values, np.nan)
        none = ~within.any(axis=1)
        axes.fill_between(
            angle, 0, 1, where=none, transform=axes.get_xaxis_transform(), color=SHADE, linewidth=0, step="mid"
        )
        for number, (label, drawn_values) in enumerate(_branches(values)):
            axes.plot(angle, drawn_values, color=SERIES[number % len(SERIES)], label=label)
        axes.set(ylabel=f"{text} [{unit}]" if unit else text)
        if "redundancy_angle" in result.measures and chosen is not None:
            axes.plot(np.degrees(result.measures["redundancy_angle"].value), factor * result.measures[name].value, "o",
                      color=INK, markersize=7, label="this posture")  # fmt: skip
    line_note(panels[1], friction, f"friction {friction:.3g}: the tip holds below", GOOD)
    panels[1].set(xlabel="redundancy angle [°]; shaded: no posture within the limits")
    panels[1].set_ylim(bottom=0)
    panels[0].margins(x=0)
    if within.any():
        legend_above(panels[0], 5)
    return drawn


def _branches(values: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """What there is to draw: of a spherical wrist the two flips as one, which have the same compliance."""
    if values.shape[1] == 2 * len(_BRANCHES):
        found = [(name, np.fmax(values[:, 2 * k], values[:, 2 * k + 1])) for k, name in enumerate(_BRANCHES)]
    else:
        found = [(f"branch {k + 1}", values[:, k]) for k in range(values.shape[1])]
    return [(name, one) for name, one in found if np.isfinite(one).any()]


_BRANCHES = ("front, elbow one", "front, elbow two", "back, elbow one", "back, elbow two")


def arm_in_posture(result: "Result") -> Figure:
    """The arm in its posture from the side and from above, first hole, joint by joint."""
    points = result["motion"]["arm"].isel(hole=0).values
    names = [str(name) for name in result["motion"]["point"].values]
    drawn = figure(4.4)
    for axes, (across, up), title in zip(
        drawn.subplots(1, 2), ((0, 2), (0, 1)), ("from the side", "from above"), strict=True
    ):
        axes.plot(points[:, across], points[:, up], color=SERIES[0], linewidth=4, alpha=0.45, solid_joinstyle="round")
        axes.plot(points[:-1, across], points[:-1, up], "o", color=INK, markersize=4)
        axes.plot(points[-2:, across], points[-2:, up], color=SERIES[1], linewidth=2.5)
        axes.plot(points[-1, across], points[-1, up], "v", color=BAD, markersize=7)
        placed: list[np.ndarray] = []
        for point, name in zip(points, names, strict=True):
            if all(np.hypot(*(point[[across, up]] - other)) > 0.05 for other in placed):
                placed.append(point[[across, up]])
                axes.annotate(
                    name, point[[across, up]], xytext=(5, 4), textcoords="offset points", fontsize=7.5, color=SOFT
                )
        axes.set_aspect("equal", adjustable="datalim")
        axes.set(title=title, xlabel="x [m]", ylabel=f"{'xyz'[up]} [m]")
        axes.margins(0.12)
    return drawn


_TABLE = (
    ("redundancy_angle", "angle", "angle"), ("skating_ratio", "dimensionless", "skating"),
    ("compliance_axial", "compliance", "compliance"), ("hole_position_error_entry", "small_length", "entry"),
    ("hole_position_error_exit", "small_length", "exit"), ("perpendicularity_error", "small_angle", "perpendicularity"),
    ("feed_per_rev_max", "feed_per_revolution", "feed max"),
)  # fmt: skip


def hole_table(result: "Result") -> Figure:
    """Every hole with its numbers, pass or fail."""
    holes = result["holes"]
    shown_as = tuple(column for column in _TABLE if column[0] in holes)
    count = min(holes.sizes["hole"], _MOST_ROWS)
    head = [
        "hole",
        "x, y, z [mm]",
        *(f"{text} [{scale(dim)[1]}]" if scale(dim)[1] else text for _, dim, text in shown_as),
        "",
    ]
    rows, colours = [], []
    for k in range(count):
        one = holes.isel(hole=k)
        place = ", ".join(f"{1e3 * x:.5g}" for x in one["position"].values)
        values = [scale(dim)[0] * float(one[name]) for name, dim, _ in shown_as]
        drilled, passed = bool(one["drilled"]), bool(one["passed"])
        verdict = "not drilled" if not drilled else "pass" if passed else "fail"
        shown = [f"{value:.4g}" if np.isfinite(value) else "–" for value in values]
        rows.append([str(int(one["hole"])), place, *shown, verdict])
        colours.append(GOOD if drilled and passed else BAD)
    drawn = figure(0.5 + 0.26 * (count + 1))
    axes = drawn.subplots()
    axes.axis("off")
    table = axes.table(cellText=rows, colLabels=head, loc="upper left", cellLoc="right", edges="horizontal")
    table.auto_set_font_size(False)
    table.set_fontsize(8.5)
    table.auto_set_column_width(list(range(len(head))))
    table.scale(1.0, 1.3)
    for (row, column), cell in table.get_celld().items():
        cell.set_edgecolor(SOFT)
        cell.set_text_props(color=SOFT if row == 0 else INK)
        if row > 0 and column == len(head) - 1:
            cell.set_text_props(color=colours[row - 1], weight="bold")
    return drawn


PLOTS = [
    Plot(
        "Holes",
        "Where each hole is, the posture it is drilled in, how it comes out, and whether it meets every requirement.",
        hole_table, ("holes/position",),
    ),
    Plot(
        "Thrust and torque over depth",
        "At nominal feed, by lips, chisel edge and margins: entry, full cut and breakthrough.",
        shares_over_depth, ("cutting/thrust_nominal", "cutting/torque_nominal"),
    ),
    Plot(
        "Deflection of the tool tip and actual feed over time",
        "Tool axes, first hole: pushed back while it drills, springing forward at breakthrough, where the feed surges.",
        deflection_over_time, ("structure/tip_deflection", "motion/feed_per_rev"),
    ),
    Plot(
        "Where the hole goes",
        "Lateral position of the hole while the tip advances. The entry counts where the corner is in, the exit where it "
        "is out.",
        hole_path, ("surface/hole_position", "motion/depth"),
    ),
    Plot(
        "Compliance and skating over the redundancy angle",
        "Every branch of the inverse kinematics of the first hole within its limits; the stiffest posture is not the one "
        "that skates least.",
        posture_map, ("map/compliance_axial", "map/skating_ratio"),
    ),
    Plot(
        "The arm in its posture", "First hole; the spindle in the second colour, the tip as a triangle.",
        arm_in_posture, ("motion/arm",),
    ),
]  # fmt: skip
