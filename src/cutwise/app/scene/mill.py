"""A mill along a program, a corner or a wall, with the drives that lead it; the block of stock that it cuts."""

import math
from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene import mill_carried, mill_map
from cutwise.app.scene.milled import block_map
from cutwise.app.scene.part import block_of
from cutwise.app.scene.scene import CUT, FEED, RAPID, FloatArray, History, Map, Scene, Surface, limits, mirrored
from cutwise.app.scene.shapes import cylinder
from cutwise.app.scene.toolpath import Toolpath, toolpath_of
from cutwise.app.scene.wall import ENDS, milled_wall

if TYPE_CHECKING:
    from cutwise.results import Result

_FLUTES = 2.5  # length of a mill whose flute length is not said, in diameters


def scene(result: "Result") -> Scene:
    """What there is of a milling run: with drives, in a stock in 3D, or carried by a robot or machine at rest."""
    if "lines" in result.stages.children:
        return mill_map.scene(result)
    if "actual" not in result["motion"].dataset if "motion" in result.stages.children else True:
        return mill_carried.scene(result)
    return _driven(result)


def _driven(result: "Result") -> Scene:
    motion, scenario = result["motion"].dataset, result.scenario
    time, actual = motion["time"].values, motion["actual"].values
    radius = 0.5 * scenario.tool.diameter  # type: ignore[attr-defined]
    seen = result["scene"].dataset if "scene" in result.stages.children else None
    said = [] if seen is not None else ["heights and lines of the program are not in this run file: run it again"]
    height = seen["height"].values if seen is not None else np.zeros(time.size)
    toolpath = toolpath_of(result)
    if toolpath is not None and actual.shape[1] < 3:  # the wall lies at one height
        height = height + toolpath.point[0, 2]
    place = np.column_stack([actual[:, :2], actual[:, 2] if actual.shape[1] > 2 else height])
    line = seen["line"].values.astype(np.int64) if seen is not None else None
    kind = np.full(time.size, FEED, np.uint8)
    if seen is not None:
        kind[seen["cuts"].values > 0] = CUT
        kind[seen["rapid"].values > 0] = RAPID
    histories = _histories(result, time)
    judged = "wall" if "wall" in histories else "contour"
    structure = result["structure"].dataset if "structure" in result.stages.children else None
    deflection = None
    if structure is not None and "tip" in structure:
        deflection = np.pad(structure["tip"].values, ((0, 0), (0, 1)))
    elif (
        structure is not None and toolpath is not None and "deviation_drives" in structure
    ):  # the drives are in the places
        terms = [a.values for name, a in structure.data_vars.items() if str(name).startswith("deflection_")]
        deflection = toolpath.turned(motion["travelled"].values, np.sum(terms, axis=0)) if terms else None
    shown: Map | None = None
    surfaces: tuple[Surface, ...] = ()
    if scenario.stock is not None:  # type: ignore[attr-defined]
        coloured = "wall_period" if "wall_period" in histories else judged
        shown = block_map(scenario.stock, place, radius, histories[judged].values, coloured)  # type: ignore[attr-defined]
    elif toolpath is not None and "wall" in histories:
        surfaces, larger = _wall_left(result, toolpath, histories["wall"].values)
        said += larger
    else:
        said.append("no stock: the scenario has none")
    tool = scenario.tool  # type: ignore[attr-defined]
    return Scene(
        clock=time, clock_is="time", place=place, histories=histories, line=line, kind=kind, deflection=deflection,
        tools=(cylinder(radius, tool.flute_length or 2.0 * _FLUTES * radius),), map=shown, judged=judged, said=tuple(said),
        surfaces=surfaces, front=None if toolpath is None else toolpath.front,
    )  # fmt: skip


def _wall_left(result: "Result", toolpath: Toolpath, error: FloatArray) -> tuple[tuple[Surface, ...], tuple[str, ...]]:
    """The straight wall along the toolpath that was commanded, where the tool has moved on."""
    scenario, along = result.scenario, result["motion"]["travelled"].values
    on = np.flatnonzero(np.diff(along, prepend=-1.0) > 0.0)
    radius, depth = 0.5 * scenario.tool.diameter, scenario.operation.axial_depth  # type: ignore[attr-defined]
    inside = block_of(result) is not None
    return milled_wall(toolpath, along[on], error[on], depth, radius, "wall", within=inside)


def _histories(result: "Result", time: FloatArray) -> dict[str, History]:
    motion, cutting = result["motion"].dataset, result["cutting"].dataset
    found: dict[str, History] = {}
    structure = result["structure"].dataset if "structure" in result.stages.children else {}
    if "wall_error_max" in structure:
        found["wall"] = _wall(result, structure["wall_error_min"].values, structure["wall_error_max"].values)
        worst = _in_a_period(found["wall"].values, _tooth_samples(result, time))
        found["wall_period"] = found["wall"]._replace(values=worst)  # without the gaps from tooth to tooth
        found["wall"] = found["wall"]._replace(title="wall error, each sample", drawn=False, coloured=False)
    elif "wall_error" in structure:
        wall = structure["wall_error"].values
        found["wall"] = _wall(result, wall, wall)
    found["contour"] = History(
        "contour error", result["surface"]["contour_error"].values, "small_length", *mirrored(result, "contour_error_max"),
        ends=("off the wall", "into the wall"), drawn="wall" not in found, measures=("contour_error_max",),
    )  # fmt: skip
    peak = (
        cutting["force_xy_peak"].values
        if "force_xy_peak" in cutting
        else np.linalg.norm(cutting["force"].values, axis=1)
    )
    found["force"] = History("largest force in the plane", peak, "force", *limits(result, "force_xy_peak"),
                             measures=("force_xy_peak",))  # fmt: skip
    found["speed"] = History("speed along the path", motion["speed_actual"].values, "speed")
    found["immersion"] = History("immersion angle", result["engagement"]["immersion"].values, "angle", drawn=False)
    if "tip_peak" in structure:
        found["tip"] = History(
            "tip displacement",
            structure["tip_peak"].values,
            "small_length",
            *limits(result, "tip_deflection_max"),
            drawn=False,
            measures=("tip_deflection_max",),
        )
    found["time"] = History("time", time, "time", drawn=False)
    return found


def _wall(result: "Result", low: FloatArray, high: FloatArray) -> History:
    """The error of the wall that its limits are about; the larger magnitude where both or neither has one."""
    least, most = limits(result, "wall_error_min")[0], limits(result, "wall_error_max")[1]
    values = np.where(np.abs(low) > np.abs(high), low, high)
    if (least is None) != (most is None):
        values = high if least is None else low
    return History(
        "wall error", values, "small_length", least, most, ends=ENDS, measures=("wall_error_max", "wall_error_min")
    )


def _tooth_samples(result: "Result", time: FloatArray) -> int:
    """Samples in a tooth period, rounded up."""
    scenario = result.scenario
    speed = scenario.operation.spindle_speed  # type: ignore[attr-defined]
    step = float(np.diff(time[:2])[0]) if time.size > 1 else 1.0
    if not speed:
        return 1
    return max(1, math.ceil(float(2.0 * math.pi / (speed * scenario.tool.flutes * step))))  # type: ignore[attr-defined]


def _in_a_period(values: FloatArray, samples: int) -> FloatArray:
    """At each sample the value of largest magnitude within so many samples to either side; missing where all are."""
    best = values.copy()
    for shift in range(1, samples + 1):
        for other in (
            np.concatenate([np.full(shift, np.nan), values[:-shift]]),
            np.concatenate([values[shift:], np.full(shift, np.nan)]),
        ):
            larger = ~np.isnan(other) & ~(np.abs(best) >= np.abs(other))
            best = np.where(larger, other, best)
    return best
