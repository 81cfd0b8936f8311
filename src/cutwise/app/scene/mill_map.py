"""A program in a stock in 3D: the height map with its deviation from the part, tools, load along the program."""

from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene.scene import CUT, FEED, RAPID, FloatArray, History, IntArray, Map, Scene, Tool, limits
from cutwise.app.scene.shapes import cylinder

if TYPE_CHECKING:
    from cutwise.results import Result

_ENDS = ("cut into the part", "material left")
_FLUTES = 2.5  # length of a tool whose flute length is not said, in diameters
_ARC = 13  # points of a rounded end


def scene(result: "Result") -> Scene:
    """Places along the program over time, and the stock after it."""
    motion, lines = result["motion"].dataset, result["lines"].dataset
    time, place = motion["time"].values, motion["tip"].values
    move = np.clip(np.searchsorted(lines["time"].values, time, side="right") - 1, 0, lines.sizes["move"] - 1)
    cutting = motion["force_xy_peak"].values
    histories = {
        "force": History("largest force in the plane", cutting, "force", *limits(result, "force_xy_peak"),
                         measures=("force_xy_peak",)),
        "power": History("cutting power", motion["power"].values, "power", *limits(result, "cutting_power_max"),
                         measures=("cutting_power_max",)),
        "immersion": History("contact angle", motion["immersion"].values, "angle", drawn=False),
        "chip": History("thickest chip", motion["chip_thickness"].values, "small_length", drawn=False),
    }  # fmt: skip
    line = motion["line"].values.astype(np.int64)
    judged, said = "force", []
    if "surface" in result.stages.children:
        judged = "deviation"
        tolerance = float(result["surface"].dataset.attrs.get("tolerance", 0.0)) or None
        made = _made(result, line)
        histories = {
            "deviation": History(
                "deviation made",
                made,
                "small_length",
                None if tolerance is None else -tolerance,
                tolerance,
                ends=_ENDS,
                measures=("deviation_max", "deviation_min"),
            ),
            **histories,
        }
    else:
        said.append("no part to compare with: the scenario has none")
    tools, tool_of = _tools(result, lines["tool"].values[move])
    rapid = lines["rapid"].values[move] > 0
    cuts = motion["immersion"].values > 0.0
    return Scene(
        clock=time, clock_is="time", place=place, histories=histories, line=line,
        kind=np.where(rapid, RAPID, np.where(cuts, CUT, FEED)).astype(np.uint8), tools=tools, tool_of=tool_of,
        map=_map(result, place, line, judged), judged=judged, said=tuple(said),
    )  # fmt: skip


def _made(result: "Result", line: IntArray) -> FloatArray:
    """The deviation of largest magnitude of the surface that the line of each place made; missing where it made none."""
    surface = result["surface"].dataset
    of, value = surface["line"].values.astype(np.int64), surface["deviation"].values.astype(float)
    worst: dict[int, float] = {}
    order = np.argsort(np.abs(value))
    for number, one in zip(of[order].tolist(), value[order].tolist(), strict=True):
        worst[number] = one  # the last one is the largest
    return np.array([worst.get(number, np.nan) if number > 0 else np.nan for number in line.tolist()])


def _tools(result: "Result", called: IntArray) -> tuple[tuple[Tool, ...], IntArray]:
    scenario = result.scenario
    given = list(getattr(scenario, "tools", None) or ()) or [scenario.tool]  # type: ignore[attr-defined]
    numbers = [getattr(tool, "number", 0) for tool in given]
    which = np.array([numbers.index(n) if n in numbers else 0 for n in called.tolist()], np.int64)
    return tuple(_turned(tool) for tool in given), which


def _turned(tool: object) -> Tool:
    """The profile of a tool by its shape, its shank and its holder."""
    radius = 0.5 * tool.diameter  # type: ignore[attr-defined]
    shape = getattr(tool, "shape", "flat")
    length = getattr(tool, "flute_length", None) or 2.0 * _FLUTES * radius
    plain = cylinder(radius, length)
    corner = {"ball": radius, "bull_nose": getattr(tool, "corner_radius", None) or 0.0}.get(shape, 0.0)
    cutter = plain.cutter
    if corner > 0.0:
        angle = np.linspace(-0.5 * np.pi, 0.0, _ARC)
        end = np.column_stack([corner + corner * np.sin(angle), radius - corner + corner * np.cos(angle)])
        cutter = np.concatenate([[[0.0, 0.0]], end, plain.cutter[2:]])
    elif shape in ("drill", "chamfer", "taper", "ball_taper"):
        half = getattr(tool, "half_angle", None) or 0.5 * (getattr(tool, "point_angle", None) or np.pi)
        tip = 0.5 * (getattr(tool, "tip_diameter", None) or 0.0)
        rise = min((radius - tip) / np.tan(half), length)
        cutter = np.concatenate([[[0.0, 0.0], [0.0, tip], [rise, radius]], plain.cutter[2:]])
    holder = [(height, 0.5 * wide) for height, wide in getattr(tool, "holder", ())]
    shank = getattr(tool, "shank_diameter", None)
    if not holder:
        return Tool(cutter, plain.holder)
    rows = [[length, 0.0], [length, 0.5 * (shank or tool.diameter)], [holder[0][0], 0.5 * (shank or tool.diameter)]]  # type: ignore[attr-defined]
    for (height, wide), following in zip(
        holder, [*holder[1:], (holder[-1][0] + 2.0 * holder[-1][1], 0.0)], strict=True
    ):
        rows += [[height, wide], [following[0], wide]]
    return Tool(cutter, np.array([*rows, [rows[-1][0], 0.0]], float))


def _map(result: "Result", place: FloatArray, line: IntArray, judged: str) -> Map:
    stock = result["stock"].dataset
    x, y, height = stock["x"].values, stock["y"].values, stock["height"].values.astype(float)
    dx = float(np.diff(x).mean()) if x.size > 1 else 1e-3
    dy = float(np.diff(y).mean()) if y.size > 1 else 1e-3
    top = float(np.nanmax(height))
    bottom = float(np.nanmin(stock["bottom"].values))
    values = None
    if judged == "deviation":
        surface = result["surface"].dataset
        point, off = surface["point"].values.astype(float), surface["deviation"].values.astype(float)
        column = np.clip(((point[:, 0] - x[0]) / dx + 0.5).astype(int), 0, x.size - 1)
        row = np.clip(((point[:, 1] - y[0]) / dy + 0.5).astype(int), 0, y.size - 1)
        values = np.full(height.shape, np.nan)
        order = np.argsort(np.abs(off))
        values[row[order], column[order]] = off[order]  # the last one of a cell is the largest
    return Map(
        x[0] - 0.5 * dx, y[0] - 0.5 * dy, dx, dy, height, top, bottom, values, judged if values is not None else "",
        _owners(stock["line"].values.astype(np.int64), np.stack(np.meshgrid(x, y), axis=2), place, line),
    )  # fmt: skip


def _owners(cut_by: IntArray, middle: FloatArray, place: FloatArray, line: IntArray) -> IntArray:
    """Of each cell the place on the line that cut it last which is nearest to it; -1: the stock."""
    from scipy.spatial import cKDTree

    found, cells = np.full(cut_by.size, -1, np.int64), cut_by.ravel()
    by_line, by_cell = np.argsort(line, kind="stable"), np.argsort(cells, kind="stable")
    middles, lines, numbers = middle.reshape(-1, 2), line[by_line], np.unique(cells[cells > 0])
    ends = [np.searchsorted(of, [numbers, numbers + 1]) for of in (lines, cells[by_cell])]
    for (first, last), (low, high) in zip(ends[0].T, ends[1].T, strict=True):
        if last > first:
            samples, here = by_line[first:last], by_cell[low:high]
            found[here] = samples[cKDTree(place[samples, :2]).query(middles[here])[1]]
    return found.reshape(cut_by.shape)
