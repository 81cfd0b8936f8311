"""Plots of chamfer paths: part and path, width, legs and angles, feeds, forces, and the spindle that yields."""

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from cutwise.app.plots.figures import (
    BAD,
    CARD,
    GOOD,
    INK,
    SERIES,
    SHADE,
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
from cutwise.app.plots.spindle import PLOT as SPINDLE

if TYPE_CHECKING:
    from cutwise.results import Result

_RIGHT = np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)  # isometric view
_UP = np.array([-1.0, -1.0, 2.0]) / np.sqrt(6.0)
_MOST_NAMED = 30  # edges that are named in the picture


def _flat(point: np.ndarray) -> np.ndarray:
    return np.column_stack([point @ _RIGHT, point @ _UP]) * scale("length")[0]


def picture(result: "Result") -> Figure:
    """Part with its edges and paths, and the tool at the worst place; beside it the section there."""
    drawn = figure(4.6)
    left, right = drawn.subplots(1, 2, width_ratios=(1.25, 1.0))
    part = result["part"].dataset
    points, line = _flat(part["outline"].values), part["outline_line"].values
    for rows in np.split(np.arange(len(line)), np.flatnonzero(np.diff(line)) + 1):
        left.plot(*points[rows].T, color=SOFT, linewidth=0.6, alpha=0.8)
    _paths(left, result)
    size = scale("length")[0]
    tool = result.scenario.tool  # type: ignore[attr-defined]
    centre, axis = np.array(part.attrs["worst_centre"]), np.array(part.attrs["worst_axis"])
    span = float(np.ptp(points, axis=0).max())
    _tool(left, _flat(centre[None])[0], np.array([axis @ _RIGHT, axis @ _UP]), size, tool, 0.25 * span / size)
    left.set_aspect("equal")
    left.set_axis_off()
    left.margins(0.04)
    _across(right, result)
    return drawn


def _paths(axes: Axes, result: "Result") -> None:
    motion, edge = result["motion"].dataset, result["engagement"]["edge"].values
    number, closed = motion["path"].values.astype(int), motion["closed"].values
    name = motion["edge_number"].values.astype(int)
    many = len(np.unique(name)) > 1
    for i in np.unique(number):
        rows = np.flatnonzero(number == i)
        rows = np.append(rows, rows[0]) if closed[rows[0]] else rows
        for line, colour, width, label in (
            (edge, SERIES[1], 1.8, "edge"), (motion["centre"].values, SERIES[0], 1.0, "ball centre"),
        ):  # fmt: skip
            axes.plot(
                *_flat(line[rows]).T, color=colour, linewidth=width, zorder=6, label=label if i == number[0] else None
            )
        if many and len(np.unique(name)) <= _MOST_NAMED:
            place = _flat(edge[rows[[len(rows) // 2]]])[0]
            note(axes, str(name[rows[0]]), (place[0], place[1]), (2, 2), fontsize=7, color=SERIES[1])
    legend_above(axes, 2)


def _tool(axes: Axes, at: np.ndarray, rod: np.ndarray, size: float, tool: object, length: float) -> None:
    """Ball and rod seen from a side: a sphere is a circle from everywhere, a rod is a strip along its direction."""
    ball, thin = size * tool.ball_radius, size * tool.rod_radius  # type: ignore[attr-defined]
    long = float(np.linalg.norm(rod))
    if long > 1e-6:
        along, side = rod / long, np.array([-rod[1], rod[0]]) / long
        start = long * np.sqrt(max(0.0, ball**2 - thin**2))
        end = size * length * long
        corners = [at + start * along + thin * side, at + end * along + thin * side,
                   at + end * along - thin * side, at + start * along - thin * side]  # fmt: skip
        axes.add_patch(
            Polygon(corners, closed=True, facecolor=SHADE, edgecolor=INK, linewidth=0.9, alpha=0.85, zorder=4)
        )
    axes.add_patch(Circle((at[0], at[1]), ball, facecolor=CARD, edgecolor=INK, linewidth=1.1, alpha=0.7, zorder=5))


def _across(axes: Axes, result: "Result") -> None:
    """The edge across its direction, the ball in it, and what of the ball is knife."""
    part = result["part"].dataset
    size, unit = scale("length")
    points = size * part["section"].values
    tool = result.scenario.tool  # type: ignore[attr-defined]
    ball = size * tool.ball_radius
    face1, border1, edge, border2, face2 = points
    beyond = edge + 4.0 * (0.5 * (face1 + face2) - edge)
    axes.add_patch(Polygon([face1, edge, face2, beyond], closed=True, facecolor=SHADE, edgecolor="none"))
    axes.plot(*np.array([face1, edge, face2]).T, color=SOFT, linewidth=1.0, linestyle=":")
    _tool(axes, np.zeros(2), np.array([0.0, 1.0]), size, tool, 2.2 * tool.ball_radius)
    for side in (-1.0, 1.0):
        chi = np.linspace(tool.knife_limit_angle, np.pi - tool.pole_limit_angle, 80)
        label = "knife" if side > 0.0 else None
        axes.plot(side * ball * np.sin(chi), ball * np.cos(chi), color=SERIES[2], linewidth=2.0, zorder=6, label=label)
    axes.plot(*np.array([face1, border1]).T, color=SERIES[1], linewidth=1.6, zorder=7)
    axes.plot(*np.array([face2, border2]).T, color=SERIES[1], linewidth=1.6, zorder=7, label="faces left")
    axes.plot(*np.array([border1, border2]).T, "o", color=SERIES[1], markersize=3.5, zorder=8)
    axes.set_xlim(-1.7 * ball, 1.7 * ball)
    axes.set_ylim(-1.7 * ball, 1.9 * ball)
    axes.set_aspect("equal")
    name, why = part.attrs["worst_name"], part.attrs["worst_reason"]
    axes.set(xlabel=f"across the edge [{unit}]", ylabel=f"[{unit}]")
    axes.set_title(f"{name}, {why}", fontsize=8.5, fontweight="normal", pad=18)
    axes.grid(visible=False)
    legend_above(axes, 2)


def _ends(result: "Result") -> np.ndarray:
    """Where one path ends and the next begins, along all edges [m]."""
    motion = result["motion"].dataset
    number, s = motion["path"].values, motion["s"].values
    return np.asarray(s[1:][np.diff(number) != 0])


def _each(result: "Result", axes: Axes, name: str, x: np.ndarray, y: np.ndarray, **style: object) -> None:
    """A curve along all edges that breaks between one path and the next."""
    del name
    number = result["surface"]["path_measured"].values if x.size == result["surface"].sizes["s_measured"] else None
    if number is None:
        number = result["motion"]["path"].values
    label = style.pop("label", None)
    for i, (a, b) in enumerate(pairwise([0, *(np.flatnonzero(np.diff(number)) + 1), len(number)])):
        order = a + np.argsort(x[a:b], kind="stable")
        curve(axes, x[order], y[order], **style, label=label if i == 0 else None)


def _marked(axes: Axes, result: "Result") -> None:
    """Thin lines where a new path begins, if there are not too many."""
    ends = scale("length")[0] * _ends(result)
    if len(ends) <= 60:
        for end in ends:
            axes.axvline(end, color=SOFT, linewidth=0.5, alpha=0.4)
    axes.margins(x=0.01)


def width(result: "Result") -> Figure:
    """Width that the sweep leaves, with what set-up errors do to it, and how it depends on the height of the tool."""
    surface = result["surface"].dataset
    size, unit = scale("length")
    at = size * surface["s_measured"].values
    drawn = figure(4.6)
    top, bottom = drawn.subplots(2, 1, sharex=True, height_ratios=(1.6, 1.0))
    if "width_low" in surface:
        top.fill_between(at, size * surface["width_low"].values, size * surface["width_high"].values, color=ZONE,
                         linewidth=0, label="90 % of set-ups, place by place")  # fmt: skip
    _each(result, top, "width", at, size * surface["width"].values, color=INK, label="measured")
    if "width_deflected" in surface:
        _each(result, top, "width", at, size * surface["width_deflected"].values, color=SERIES[1],
              label="with the spindle yielding")  # fmt: skip
    low, high = top.get_ylim()
    for name, above in (("width_min", False), ("width_max", True)):
        limit = result.scenario.requirements.get(name)
        for value in (limit.min, limit.max) if limit is not None else ():
            if value is not None and low - 0.5 * (high - low) < size * value < high + 0.5 * (high - low):
                line_note(top, size * value, f"limit {size * value:.4g} {unit}", GOOD, above=above)
    wanted = size * result.scenario.chamfer.width  # type: ignore[attr-defined]
    if high - low < 0.02 * wanted:  # an exact path is a straight line: do not magnify rounding
        top.set_ylim(wanted * 0.985, wanted * 1.015)
    top.set(ylabel=f"chamfer width [{unit}]")
    legend_above(top, 3)
    _each(result, bottom, "slope", at, surface["setup_slope"].values, color=SERIES[3])
    bottom.axhline(0.0, color=SOFT, linewidth=0.8)
    bottom.set(xlabel=f"way along the edges [{unit}]", ylabel="width change per\nheight of the tool")
    _marked(top, result)
    _marked(bottom, result)
    return drawn


def contact(result: "Result") -> Figure:
    """Legs, contact angles between the ends of the knife, wedge angle, and the rod in its hole."""
    engagement = result["engagement"].dataset
    size, unit = scale("length")
    at = size * engagement["s"].values
    rods = "rod_clearance" in engagement
    drawn = figure(6.4 + 1.4 * rods)
    panels = drawn.subplots(3 + rods, 1, sharex=True)
    legs, angles, wedge = panels[:3]
    leg, chi = engagement["leg"].values, np.degrees(engagement["contact_angle"].values)
    for m, (text, colour) in enumerate((("first face", SERIES[0]), ("second face, along the rod", SERIES[1]))):
        _each(result, legs, "leg", at, size * leg[:, m], color=colour, label=text)
        _each(result, angles, "chi", at, chi[:, m], color=colour)
    legs.set(ylabel=f"leg [{unit}]")
    legs.set_ylim(0.0, 1.15 * size * leg.max())
    legend_above(legs, 2)
    tool = result.scenario.tool  # type: ignore[attr-defined]
    low, high = np.degrees(tool.knife_limit_angle), 180.0 - np.degrees(tool.pole_limit_angle)
    angles.axhspan(low, high, color=ZONE, linewidth=0, alpha=0.6)
    line_note(angles, low, f"knife from {low:.4g}°", GOOD, above=False)
    if high < 180.0:
        line_note(angles, high, f"to {high:.4g}°", GOOD)
    angles.set(ylabel="border from\nthe rod [°]")
    angles.set_ylim(min(low, float(chi.min())) - 12.0, max(high, float(chi.max())) + 5.0)
    _each(result, wedge, "wedge", at, np.degrees(engagement["wedge_angle"].values), color=SERIES[3])
    wedge.set(ylabel="angle of the\nmaterial [°]")
    if rods:
        _each(result, panels[3], "rod", at, size * engagement["rod_clearance"].values, color=INK)
        need = size * result.scenario.chamfer.clearance  # type: ignore[attr-defined]
        line_note(panels[3], need, f"needed {need:.3g} {unit}", BAD, above=False)
        panels[3].set(ylabel=f"rod from its\nhole [{unit}]")
        panels[3].margins(y=0.25)
    panels[-1].set(xlabel=f"way along the edges [{unit}]")
    for panel in panels:
        _marked(panel, result)
    return drawn


def feeds(result: "Result") -> Figure:
    """Speed of ball centre and contact."""
    motion = result["motion"].dataset
    size, unit = scale("length")
    factor, speed_unit = scale("speed")
    at = size * motion["s"].values
    drawn = figure(2.7)
    axes = drawn.subplots()
    _each(result, axes, "feed", at, factor * motion["feed"].values, color=SERIES[0], label="ball centre (programmed)")
    _each(result, axes, "feed", at, factor * motion["contact_feed"].values, color=SERIES[1], label="contact")
    axes.set(xlabel=f"way along the edges [{unit}]", ylabel=f"speed [{speed_unit}]")
    axes.set_ylim(bottom=0.0)
    _marked(axes, result)
    legend_above(axes, 2)
    return drawn


def forces(result: "Result") -> Figure:
    """Cutting force and power along the edges, mean over a tooth."""
    cutting = result["cutting"].dataset
    size, unit = scale("length")
    factor, force_unit = scale("force")
    at = size * cutting["s"].values
    drawn = figure(4.2)
    top, bottom = drawn.subplots(2, 1, sharex=True, height_ratios=(1.6, 1.0))
    burr = bool(np.any(cutting["burr_force"].values))
    names = {"x": "along the feed, x", "y": "off the work, y", "z": "along the rod, z"}
    for axis, colour in zip("xyz", SERIES, strict=False):
        _each(
            result, top, "force", at, factor * cutting["force"].sel(axis=axis).values, color=colour, label=names[axis]
        )
        if burr:
            _each(result, top, "burr", at, factor * cutting["burr_force"].sel(axis=axis).values, color=colour,
                  linestyle=":", linewidth=1.1, label="of the burr" if axis == "x" else None)  # fmt: skip
    breakaway = result.measures.get("breakaway_force")
    if breakaway is not None:
        lateral = factor * np.hypot(*cutting["force"].sel(axis=["x", "y"]).values.T)
        _each(result, top, "lateral", at, lateral, color=INK, linewidth=1.0, label="across the rod")
        if factor * breakaway.value < 4.0 * lateral.max():
            line_note(top, factor * breakaway.value, f"breakaway {factor * breakaway.value:.3g} {force_unit}", BAD)
    top.set(ylabel=f"force on the tool [{force_unit}]")
    legend_above(top, 5)
    power, power_unit = scale("power")
    _each(result, bottom, "power", at, power * cutting["power"].values, color=INK)
    bottom.set(xlabel=f"way along the edges [{unit}]", ylabel=f"power [{power_unit}]")
    bottom.set_ylim(bottom=0.0)
    _marked(top, result)
    _marked(bottom, result)
    return drawn


def deflection(result: "Result") -> Figure:
    """What yields along the edges, spindle and robot: deflection of the tip, and the force that it meets."""
    structure = result["structure"].dataset
    size, unit = scale("length")
    factor, force_unit = scale("force")
    at = size * structure["s"].values
    drawn = figure(4.2)
    top, bottom = drawn.subplots(2, 1, sharex=True)
    tip = size * structure["tip_deflection"].values
    for k, (text, colour) in enumerate((("along the feed, x", SERIES[0]), ("off the work, y", SERIES[1]))):
        _each(result, top, "tip", at, tip[:, k], color=colour, label=text)
    operation = result.scenario.operation  # type: ignore[attr-defined]
    approach = size * (operation.preset + operation.part_error)
    if approach and operation.preset_profile is None:
        line_note(top, approach, f"led in by {approach:.3g} {unit}", SOFT)
    top.set(ylabel=f"tip deflection [{unit}]")
    legend_above(top, 2)
    force = factor * np.hypot(*structure["deflected_force"].sel(axis=["x", "y"]).values.T)
    rigid = factor * np.hypot(*result["cutting"]["force"].sel(axis=["x", "y"]).values.T)
    _each(result, bottom, "force", at, rigid, color=SOFT, linestyle="--", label="rigid tool, no preset")
    _each(result, bottom, "force", at, force, color=INK, label="as it yields")
    breakaway = result.measures.get("breakaway_force")
    if breakaway is not None and factor * breakaway.value < 4.0 * max(float(force.max()), float(rigid.max())):
        line_note(bottom, factor * breakaway.value, f"breakaway {factor * breakaway.value:.3g} {force_unit}", BAD)
    bottom.set(xlabel=f"way along the edges [{unit}]", ylabel=f"force across\nthe rod [{force_unit}]")
    legend_above(bottom, 2)
    _marked(top, result)
    _marked(bottom, result)
    return drawn


PLOTS = [
    Plot(
        "Part, path and tool",
        "Left: edges of the part, path of the ball centre, and the tool where it is nearest to trouble. Right: the edge "
        "across its direction at that place; green is what of the ball is knife, the rod stands upright.",
        picture, ("part/outline", "part/section", "motion/centre"),
    ),
    Plot(
        "Width left by the sweep",
        "Measured on the true surfaces after the swept ball has been taken away, between the path points. Below: how "
        "much the width changes if the part stands higher or lower along the tool axis.",
        width, ("surface/width", "surface/setup_slope"),
    ),
    Plot(
        "Legs, contact on the ball, and the edge",
        "Legs on both faces; where the borders of the chamfer lie on the ball, counted from the rod, with the knife in "
        "green; the angle of the material along the edge.",
        contact, ("engagement/leg", "engagement/contact_angle", "engagement/wedge_angle"),
    ),
    Plot("Feed", "What is programmed, and what the contact gets of it.", feeds, ("motion/feed", "motion/contact_feed")),
    Plot(
        "Cutting force",
        "Of a rigid tool, mean over a tooth, in the frame of the pass: x along the feed, y from the work to the tool, z "
        "along the rod to the motor.",
        forces, ("cutting/force", "cutting/power"),
    ),
    Plot(
        "The tool yields",
        "Deflection of the tip and the force across the rod, with preset and part error.",
        deflection, ("structure/tip_deflection", "structure/deflected_force"),
    ),
    SPINDLE,
]  # fmt: skip
