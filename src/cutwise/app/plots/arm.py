"""Plots of a mill that goes as programmed: what wall and floor come out like, what yields, where it chatters."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from cutwise.app.plots.figures import BAD, SERIES, Plot, curve, figure, legend_above, line_note, scale
from cutwise.spec.milling import MillingScenario

if TYPE_CHECKING:
    from cutwise.results import Result

_TERMS = {
    "deflection_arm": "joints of the arm", "deflection_base": "its base", "deflection_bodies": "bodies of the machine",
    "deflection_tip": "tip of the tool", "deflection_pistons": "compliant spindle", "deflection_part_stiffness": "the part",
}  # fmt: skip


def wall_and_floor(result: "Result") -> Figure:
    """Error of wall and floor along the path, positive into the part."""
    surface = result["surface"]
    along, unit = scale("length")
    small, small_unit = scale("small_length")
    drawn = figure(2.8)
    axes = drawn.subplots()
    for name, said, colour in (("wall_error", "wall", SERIES[0]), ("floor_error", "floor", SERIES[1])):
        curve(axes, along * surface["s"].values, small * surface[name].values, color=colour, label=said)
    axes.axhline(0.0, color=SERIES[6], linewidth=0.8)
    axes.set(xlabel=f"along the path [{unit}]", ylabel=f"into the part [{small_unit}]")
    legend_above(axes, 2)
    return drawn


def yielding(result: "Result") -> Figure:
    """Displacement off the wall by each term of the structure."""
    structure = result["structure"]
    along, unit = scale("length")
    small, small_unit = scale("small_length")
    drawn = figure(2.8)
    axes = drawn.subplots()
    for colour, (name, said) in zip(SERIES, _TERMS.items(), strict=False):
        if name in structure.dataset:
            curve(axes, along * structure["s"].values, small * structure[name].values[:, 1], color=colour, label=said)
    axes.set(xlabel=f"along the path [{unit}]", ylabel=f"off the wall [{small_unit}]")
    legend_above(axes, 3)
    return drawn


def chatter(result: "Result") -> Figure:
    """Axial depth at which it chatters, along the path, and the depth that is cut."""
    stability = result["stability"]
    factor, unit = scale("length")
    depth = stability["stable_depth"].values
    drawn = figure(2.6)
    axes = drawn.subplots()
    finite = np.isfinite(depth)
    axes.plot(factor * stability["s_limit"].values[finite], factor * depth[finite], marker="o", color=SERIES[0])
    assert isinstance(result.scenario, MillingScenario)  # no other process has this stage
    cut = result.scenario.operation.axial_depth
    if cut is not None:
        line_note(axes, factor * cut, "axial depth of the cut", BAD)
    axes.set(xlabel=f"along the path [{unit}]", ylabel=f"depth that chatters [{unit}]", ylim=(0.0, None))
    return drawn


PLOTS = [
    Plot(
        "Wall and floor", "Where the carrier yields, the wall stands off or is cut into, and the pull of the helix digs the "
        "floor.", wall_and_floor, ("surface/floor_error",),
    ),
    Plot(
        "What yields", "Displacement off the wall by each term that carries the tool; they add up.", yielding,
        ("surface/floor_error",),
    ),
    Plot(
        "Chatter", "A cut as deep as the curve or deeper vibrates with growing amplitude.", chatter,
        ("stability/stable_depth", "surface/floor_error"),
    ),
]  # fmt: skip
