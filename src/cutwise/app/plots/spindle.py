"""The compliant spindle drawn where it is deflected most: from its solid if there is one, else its axis and pistons."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Rectangle

from cutwise.app.plots.figures import CARD, INK, SERIES, SHADE, SOFT, Plot, figure, note, scale

if TYPE_CHECKING:
    from cutwise.results import Result

_SHOWN = 0.12  # [rad] largest tilt that is drawn
_STEPS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)


def deflected(result: "Result") -> Figure:
    """Side view in the plane of the deflection, and the ring of pistons from below."""
    spindle: Any = result.scenario.spindle  # type: ignore[attr-defined]
    tilt = result["structure"]["tilt"].values
    worst = tilt[int(np.hypot(*tilt.T).argmax())]
    size, unit = scale("length")
    turn = float(np.hypot(*worst))
    tip = spindle.tool_reach * turn
    times = max((t for t in _STEPS if turn * t <= _largest(spindle)), default=1.0) if tip > 0.0 else 1.0
    drawn = figure(4.4)
    left, right = drawn.subplots(1, 2, width_ratios=(1.7, 1.0))
    _side(left, spindle, size, float(np.arctan(times * turn)))
    shown = f"deflection drawn {times:g} times as large" if times > 1.0 else "deflection to scale"
    body = "" if _outline(spindle, size) else "; the axis alone, since no solid is given"
    left.set_title(f"tip {size * tip:.3g} {unit} aside; {shown}{body}", fontsize=8.5, fontweight="normal")
    left.set(xlabel=f"in the direction of the deflection [{unit}]", ylabel=f"from the joint [{unit}]")
    _ring(right, spindle, size, worst, times)
    right.set(xlabel=f"[{unit}]")
    for axes in (left, right):
        axes.set_aspect("equal")
        axes.grid(visible=False)
    return drawn


def _largest(spindle: Any) -> float:
    """Largest tilt that is drawn [rad]: inside of the housing."""
    solid = spindle.solid
    if solid is None or not hasattr(solid, "housing_gap"):
        return _SHOWN
    return float(solid.housing_gap / solid.motor_length)


def _outline(spindle: Any, size: float) -> list[tuple[float, float, float]]:
    """Start, end and radius of the parts of the moving body from the joint down, in display units."""
    solid = spindle.solid
    reach = size * spindle.tool_reach
    if solid is None or not hasattr(solid, "motor_diameter"):
        return []
    motor, collet, mill = size * solid.motor_length, size * solid.collet_length, size * solid.mill_length
    return [
        (0.0, motor, 0.5 * size * solid.motor_diameter), (motor, motor + collet, 0.5 * size * solid.collet_diameter),
        (motor + collet, reach - mill, 0.5 * size * solid.shank_diameter),
        (reach - mill, reach, 0.5 * size * solid.mill_diameter),
    ]  # fmt: skip


def _side(axes: Axes, spindle: Any, size: float, angle: float) -> None:
    reach, arm = size * spindle.tool_reach, size * spindle.piston_arm
    parts = _outline(spindle, size)
    for turn, style in (
        (0.0, {"facecolor": "none", "edgecolor": SOFT, "linestyle": "--", "linewidth": 0.8}),
        (angle, {"facecolor": SHADE, "edgecolor": INK, "linewidth": 1.1}),
    ):  # fmt: skip
        c, s = np.cos(turn), np.sin(turn)
        for start, end, radius in parts:
            corners = np.array([[-radius, -start], [radius, -start], [radius, -end], [-radius, -end]])
            placed = np.column_stack([c * corners[:, 0] - s * corners[:, 1], s * corners[:, 0] + c * corners[:, 1]])
            axes.add_patch(Polygon(placed, closed=True, zorder=2 if turn else 1, **style))
        axes.plot(
            [0.0, reach * s], [0.0, -reach * c], color=style["edgecolor"], linewidth=0.9, linestyle="-.", zorder=3
        )
    radius = parts[0][2] if parts else 0.12 * reach
    gap, wall = _housing(spindle, size, radius)
    for side in (-1.0, 1.0):
        if parts:
            x = side * (radius + gap) if side > 0 else side * (radius + gap + wall)
            axes.add_patch(Rectangle((x, -parts[0][1]), wall, parts[0][1], facecolor=SOFT, alpha=0.35, linewidth=0))
        pushed = side * arm * np.tan(angle)  # how far the motor drives the piston back
        inner = radius + max(0.0, pushed)
        low, high = sorted((side * inner, side * (inner + gap + max(wall, 0.2 * radius))))
        tall = _piston(spindle, size)
        colour = SERIES[0] if pushed > 0.0 else SOFT
        axes.add_patch(Rectangle((low, -arm - 0.5 * tall), high - low, tall, facecolor=colour, linewidth=0, zorder=4))
    axes.plot(0.0, 0.0, "o", color=INK, markersize=6, markerfacecolor=CARD, zorder=6)
    note(axes, "joint O", (0.0, 0.0), (8, 4))
    note(axes, "tip", (reach * np.sin(angle), -reach * np.cos(angle)), (8, -3))
    axes.set_xlim(-1.9 * (radius + gap + wall), 1.9 * (radius + gap + wall))
    axes.set_ylim(-1.06 * reach, 0.12 * reach)


def _housing(spindle: Any, size: float, radius: float) -> tuple[float, float]:
    solid = spindle.solid
    if solid is None or not hasattr(solid, "housing_gap"):
        return 0.3 * radius, 0.0
    return size * solid.housing_gap, size * solid.housing_wall


def _piston(spindle: Any, size: float) -> float:
    solid = spindle.solid
    if solid is None or not hasattr(solid, "piston_diameter"):
        return 0.03 * size * float(spindle.tool_reach)
    return size * float(solid.piston_diameter)


def _ring(axes: Axes, spindle: Any, size: float, worst: np.ndarray, times: float) -> None:
    """Motor and pistons at the height of the ring: those that the motor has left stand back at their dead point."""
    parts = _outline(spindle, size)
    radius = parts[0][2] if parts else 0.12 * size * spindle.tool_reach
    gap, _ = _housing(spindle, size, radius)
    moved = times * size * spindle.piston_arm * worst
    axes.add_patch(Circle((0.0, 0.0), radius, facecolor="none", edgecolor=SOFT, linestyle="--", linewidth=0.8))
    axes.add_patch(Circle((moved[0], moved[1]), radius, facecolor=SHADE, edgecolor=INK, linewidth=1.1))
    thick = max(_piston(spindle, size), 0.12 * radius)
    for i in range(spindle.pistons):
        azimuth = spindle.piston_azimuth + 2.0 * np.pi * i / spindle.pistons
        out = np.array([np.cos(azimuth), np.sin(azimuth)])
        push = max(0.0, float(moved @ out))
        start, end = (radius + push) * out, (radius + gap + max(push, 0.5 * gap)) * out
        colour = SERIES[0] if push > 1e-9 else SOFT
        side = 0.5 * thick * np.array([-out[1], out[0]])
        corners = [start + side, end + side, end - side, start - side]
        axes.add_patch(Polygon(corners, closed=True, facecolor=colour, edgecolor="none"))
        note(axes, str(i), tuple(1.06 * end), (0, 0), ha="center", va="center", fontsize=7.5)
    if float(np.hypot(*moved)) > 1e-9:
        axes.annotate("", tuple(moved), (0.0, 0.0), arrowprops={"arrowstyle": "-|>", "color": SERIES[1]})
    reach = 1.35 * (radius + 2.0 * gap)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_title("ring of pistons, from below; blue: pushed", fontsize=8.5, fontweight="normal")


PLOT = Plot(
    "The spindle where it is deflected most",
    "Left: motor with mill on the joint, in the plane of the deflection; dashed where it stands without load. Right: the "
    "ring of pistons; the motor has left the grey ones.",
    deflected, ("structure/tilt",),
)  # fmt: skip
