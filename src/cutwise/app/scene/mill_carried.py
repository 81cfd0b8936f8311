"""A wall that is milled with a tool on a robot, a machine or pistons, place by place: the wall left, and what yields."""

from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene.part import block_of
from cutwise.app.scene.scene import CUT, History, Scene, limits
from cutwise.app.scene.shapes import cylinder
from cutwise.app.scene.spindle import in_spindle
from cutwise.app.scene.toolpath import toolpath_of
from cutwise.app.scene.wall import ENDS, milled_wall
from cutwise.spec.base import known

if TYPE_CHECKING:
    from cutwise.results import Result

_FLUTES = 2.5


def scene(result: "Result") -> Scene:
    """Over the way along the path, in the part."""
    scenario, surface = result.scenario, result["surface"].dataset
    at, wall = surface["s"].values, surface["wall_error"].values
    toolpath = known(toolpath_of(result))
    radius = 0.5 * scenario.tool.diameter  # type: ignore[attr-defined]
    low, high = limits(result, "wall_error_min")[0], limits(result, "wall_error_max")[1]
    histories = {
        "wall": History("wall error", wall, "small_length", low, high, ends=ENDS, measures=("wall_error_max", "wall_error_min")),
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
    surfaces, said = milled_wall(toolpath, at, wall, depth, radius, "wall", within=block_of(result) is not None)
    cutter = cylinder(radius, max(tool.flute_length or 0.0, 2.0 * _FLUTES * radius, 1.5 * depth))
    return Scene(
        clock=at, clock_is="way", place=toolpath.on(at, 0.0, 0.0), axis=toolpath.up(at), histories=histories,
        kind=np.full(at.size, CUT, np.uint8), deflection=None if deflection is None else toolpath.turned(at, deflection),
        tools=(in_spindle(cutter, scenario.compliant),),  # type: ignore[attr-defined]
        surfaces=surfaces, judged="wall", path=False, front=toolpath.front, said=said,
    )  # fmt: skip
