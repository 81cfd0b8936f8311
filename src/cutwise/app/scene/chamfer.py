"""A ball along the edges of a part: the part with its faces, the chamfer left, the rod, the ways between the paths."""

from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene.scene import CUT, DWELL, FloatArray, History, IntArray, Scene, Surface, limits
from cutwise.app.scene.shapes import ball_ended, band

if TYPE_CHECKING:
    from cutwise.results import Result

_ROD = 10.0  # length of the rod that is drawn, in radii of the ball


def scene(result: "Result") -> Scene:
    """The paths one after another, over the way along the edges."""
    motion, engagement, scenario = result["motion"].dataset, result["engagement"].dataset, result.scenario
    way, number = motion["s"].values, motion["path"].values.astype(np.int64)
    width = _width(result, way, number)
    low, high = limits(result, "width_min")[0], limits(result, "width_max")[1]
    histories = {
        "width": History("chamfer width", width, "small_length", low, high, nominal=scenario.chamfer.width,  # type: ignore[attr-defined]
                         ends=("too narrow", "too wide")),
    }  # fmt: skip
    children = result.stages.children
    if "cutting" in children:
        force = np.linalg.norm(result["cutting"]["force"].values, axis=1)
        histories["force"] = History("cutting force", force, "force")
        histories["power"] = History("cutting power", result["cutting"]["power"].values, "power")
    deflection = None
    if "structure" in children and "ball_offset" in result["structure"].dataset:
        deflection = _in_the_part(result["structure"]["ball_offset"].values, engagement)
        histories["offset"] = History("ball off its path", np.linalg.norm(deflection, axis=1), "small_length")
    histories["feed"] = History("feed of the ball centre", motion["feed"].values, "speed")
    surfaces, said = _part(result)
    tool = scenario.tool  # type: ignore[attr-defined]
    return Scene(
        clock=way, clock_is="way", place=motion["centre"].values, axis=motion["tool_axis"].values, histories=histories,
        trace=engagement["contact"].values,
        kind=np.where(np.append(np.diff(number) != 0, True), DWELL, CUT).astype(np.uint8), deflection=deflection,
        tools=(ball_ended(tool.ball_radius, _ROD * tool.ball_radius, min(tool.rod_radius, tool.ball_radius)),),
        surfaces=(*surfaces, _chamfer(engagement, width, number)), outlines=tuple(_rapids(result)), judged="width",
        said=said,
    )  # fmt: skip


def _width(result: "Result", way: FloatArray, number: IntArray) -> FloatArray:
    """Width left at the points of the paths; missing where it was not measured. Deflected where the tool yields."""
    surface = result["surface"].dataset
    at, path = surface["s_measured"].values, surface["path_measured"].values
    left = surface["width_deflected" if "width_deflected" in surface else "width"].values
    found = np.full(way.size, np.nan)
    for one in np.unique(number):
        here, measured = number == one, path == one
        if measured.any():
            found[here] = np.interp(way[here], at[measured], left[measured], left=np.nan, right=np.nan)
    return found


def _in_the_part(offset: FloatArray, engagement: object) -> FloatArray:
    """Offsets of the frame of the pass (feed, off the work, up) in the axes of the part."""
    tangent, air = engagement["tangent"].values, engagement["air"].values  # type: ignore[index]
    across = np.cross(tangent, air)
    return np.asarray(offset[:, :1] * tangent + offset[:, 1:2] * air + offset[:, 2:3] * across)


def _chamfer(engagement: object, width: FloatArray, number: IntArray) -> Surface:
    """The chamfer as a band about its middle, path by path."""
    middle, tangent, air = (engagement[name].values for name in ("contact", "tangent", "air"))  # type: ignore[index]
    leg = engagement["leg"].values  # type: ignore[index]
    wedge = engagement["wedge_angle"].values  # type: ignore[index]
    chord = np.sqrt(np.maximum(leg[:, 0] ** 2 + leg[:, 1] ** 2 - 2.0 * leg[:, 0] * leg[:, 1] * np.cos(wedge), 0.0))
    half = 0.5 * np.where(np.isnan(width), chord, width)[:, None]
    across = np.cross(tangent, air)
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
    lift = 0.02 * half * air
    points, corners, values, before = [], [], [], 0
    for one in np.unique(number):
        here = number == one
        if here.sum() < 2:
            continue
        rows = [(middle + lift + side * half * across)[here] for side in (-1.0, 1.0)]
        found, triangles = band(rows)
        points.append(found)
        corners.append(triangles + before)
        values.append(np.tile(width[here], 2))
        before += len(found)
    return Surface("chamfer", np.concatenate(points), np.concatenate(corners), "work", np.concatenate(values), "width")


def _part(result: "Result") -> tuple[tuple[Surface, ...], tuple[str, ...]]:
    if "scene" not in result.stages.children:
        return (), ("the shape of the part is not in this run file: run it again",)
    seen = result["scene"].dataset
    corner = seen["corner"].values.reshape(-1, 3)
    points, index = np.unique(np.round(corner, 9), axis=0, return_inverse=True)
    names = [str(name) for name in np.atleast_1d(seen.attrs.get("face_names", []))]
    part = Surface(
        "part", points.astype(float), index.reshape(-1, 3).astype(np.int64), "part", face=seen["face"].values.astype(np.int64),
        names=dict(enumerate(names)),
    )  # fmt: skip
    return (part,), ()


def _rapids(result: "Result") -> list[FloatArray]:
    """The ways between the paths, leads included."""
    program = result["program"].dataset
    place, feed = program["position"].values, program["feed"].values
    rapid = np.flatnonzero(feed == 0.0)
    runs = np.split(rapid, np.flatnonzero(np.diff(rapid) > 1) + 1) if rapid.size else []
    return [place[max(0, run[0] - 1) : run[-1] + 1] for run in runs if run.size]
