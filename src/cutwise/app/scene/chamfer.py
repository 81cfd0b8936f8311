"""A ball along the edges of a part: the part with its faces, the chamfer left, the rod, the ways between the paths."""

from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene.pipe import pipe
from cutwise.app.scene.scene import CUT, DWELL, FloatArray, History, IntArray, Scene, Surface, limits
from cutwise.app.scene.shapes import ball_ended, band, welded
from cutwise.app.scene.spindle import in_spindle

if TYPE_CHECKING:
    from cutwise.results import Result

_HIDDEN = 0.3  # upward part of the normals off the chamfer, below which the part hides it from above
_ROD = 10.0  # length of the rod that is drawn, in radii of the ball


def scene(result: "Result") -> Scene:
    """The paths one after another, over the way along the edges."""
    motion, engagement, scenario = result["motion"].dataset, result["engagement"].dataset, result.scenario
    way, number = motion["s"].values, motion["path"].values.astype(np.int64)
    width = _width(result, way, number)
    left = "width_deflected" if "width_deflected" in result["surface"].dataset else "width"
    low, high = limits(result, f"{left}_min")[0], limits(result, f"{left}_max")[1]
    histories = {
        "width": History("chamfer width", width, "small_length", low, high, nominal=scenario.chamfer.width,  # type: ignore[attr-defined]
                         ends=("too narrow", "too wide"), measures=(f"{left}_min", f"{left}_max")),
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
    if float(engagement["air"].values[:, 2].mean()) < _HIDDEN:  # on the far side of the part, as a bore's edge is
        surfaces = tuple(one._replace(tint="glass") for one in surfaces)
    tool = scenario.tool  # type: ignore[attr-defined]
    rod = ball_ended(tool.ball_radius, _ROD * tool.ball_radius, min(tool.rod_radius, tool.ball_radius))
    return Scene(
        clock=way, clock_is="way", place=motion["centre"].values, axis=motion["tool_axis"].values, histories=histories,
        trace=engagement["contact"].values,
        kind=np.where(np.append(np.diff(number) != 0, True), DWELL, CUT).astype(np.uint8), deflection=deflection,
        tools=(in_spindle(rod, getattr(scenario, "compliant", None)),),
        surfaces=(*surfaces, _chamfer(engagement, width, number)),
        outlines=(*_rapids(result), *([] if surfaces else _lines(result))),
        judged="width",
        focus=_focus(motion["centre"].values, tool.ball_radius),
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
    drilled = result.scenario.part.pipe  # type: ignore[attr-defined]
    if drilled is not None:
        return _pipe(result, drilled.radius, drilled.wall)
    if "scene" not in result.stages.children:
        return (), ("the shape of the part is not in this run file: run it again",)
    seen = result["scene"].dataset
    corner = seen["corner"].values.reshape(-1, 3)
    points, triangles = welded(corner.astype(float), np.arange(len(corner)).reshape(-1, 3))
    names = [str(name) for name in np.atleast_1d(seen.attrs.get("face_names", []))]
    part = Surface(
        "part", points, triangles, "part", face=seen["face"].values.astype(np.int64),
        names=dict(enumerate(names)),
    )  # fmt: skip
    return (part,), ()


def _pipe(result: "Result", radius: float, wall: float) -> tuple[tuple[Surface, ...], tuple[str, ...]]:
    """The pipe by its outline, which begins with the outer and the inner edge of the hole."""
    if "part" not in result.stages.children:
        return (), ("the shape of the pipe is not in this run file",)
    outline = result["part"].dataset
    point, number = outline["outline"].values, outline["outline_line"].values.astype(int)
    outer, inner = point[number == 0], point[number == 1]
    away = [np.hypot(edge[:, 0], edge[:, 2]) for edge in (outer, inner)]
    both = len(outer) == len(inner) and all(
        np.allclose(found, size, rtol=1e-6) for found, size in zip(away, (radius, radius - wall), strict=True)
    )
    if not both:
        return (), ("the pipe is drawn by its outline: not both edges of its hole are closed",)
    return (pipe(outer, inner, radius, wall, (float(point[:, 1].min()), float(point[:, 1].max()))),), ()


def _lines(result: "Result") -> list[FloatArray]:
    """The outline of the part, where its faces are not known."""
    if "part" not in result.stages.children:
        return []
    outline = result["part"].dataset
    number = outline["outline_line"].values
    return [outline["outline"].values[number == one] for one in np.unique(number)]


def _focus(centre: FloatArray, radius: float) -> tuple[FloatArray, FloatArray]:
    """Corners of the paths and the ball on them: a chamfer of tenths of a millimetre is lost in a view of the whole part."""
    return centre.min(axis=0) - radius, centre.max(axis=0) + radius


def _rapids(result: "Result") -> list[FloatArray]:
    """The ways between the paths, leads included."""
    program = result["program"].dataset
    place, feed = program["position"].values, program["feed"].values
    rapid = np.flatnonzero(feed == 0.0)
    runs = np.split(rapid, np.flatnonzero(np.diff(rapid) > 1) + 1) if rapid.size else []
    return [place[max(0, run[0] - 1) : run[-1] + 1] for run in runs if run.size]
