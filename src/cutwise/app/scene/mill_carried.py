"""A wall that is milled with a tool on a robot, a machine or pistons, place by place: the wall left, and what yields."""

from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene.scene import CUT, FloatArray, History, Scene, Surface, limits
from cutwise.app.scene.shapes import band, box, cylinder

if TYPE_CHECKING:
    from cutwise.results import Result

_ENDS = ("wall left standing", "cut into the wall")
_FLUTES = 2.5


def scene(result: "Result") -> Scene:
    """Over the way along the path: x along it, y from the wall to the tool, z up the tool."""
    scenario, surface = result.scenario, result["surface"].dataset
    way, wall = surface["s"].values, surface["wall_error"].values
    radius = 0.5 * scenario.tool.diameter  # type: ignore[attr-defined]
    low, high = limits(result, "wall_error_min")[0], limits(result, "wall_error_max")[1]
    histories = {
        "wall": History("wall error", wall, "small_length", low, high, ends=_ENDS, measures=("wall_error_max", "wall_error_min")),
        "floor": History(
            "floor error", surface["floor_error"].values, "small_length", *limits(result, "floor_error_max", "floor_error_min"),
            measures=("floor_error_max", "floor_error_min"),
        ),
        "force": History("cutting force", np.linalg.norm(result["cutting"]["force"].values, axis=1), "force"),
        "immersion": History("immersion angle", result["engagement"]["immersion"].values, "angle", drawn=False),
    }  # fmt: skip
    structure = result["structure"].dataset
    terms = [a.values for name, a in structure.data_vars.items() if str(name).startswith("deflection_")]
    deflection = np.sum(terms, axis=0) if terms else None
    if deflection is not None:
        histories["deflection"] = History("tip displacement", np.linalg.norm(deflection, axis=1), "small_length")
    depth = scenario.operation.axial_depth  # type: ignore[attr-defined]
    tool = scenario.tool  # type: ignore[attr-defined]
    return Scene(
        clock=way, clock_is="way", place=np.column_stack([way, np.full(way.size, radius), np.zeros(way.size)]),
        histories=histories, kind=np.full(way.size, CUT, np.uint8), deflection=deflection,
        tools=(cylinder(radius, max(tool.flute_length or 0.0, 2.0 * _FLUTES * radius, 1.5 * depth)),),
        surfaces=_wall(way, wall, depth, radius), judged="wall", path=False,
        said=("the path is drawn straight", "what carries the tool is not drawn"),
    )  # fmt: skip


def _wall(way: FloatArray, wall: FloatArray, depth: float, radius: float) -> tuple[Surface, ...]:
    """The work behind the wall, and the wall coloured."""
    lines = [np.column_stack([way, np.full(way.size, 1e-6), np.full(way.size, z)]) for z in (0.0, depth)]
    face, corners = band(lines)
    low = np.array([way[0], -2.0 * radius, -depth])
    return (
        box("work", low, np.array([way[-1], 0.0, depth])),
        box("floor", np.array([way[0], 0.0, -depth]), np.array([way[-1], 2.0 * radius, 0.0])),
        Surface("wall", face, corners, "work", np.tile(wall, 2), "wall"),
    )
