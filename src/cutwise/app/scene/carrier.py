"""What carries the tool, the same for every process: the arm in its postures, or the bodies of a machine, along the path."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene.scene import FloatArray, Scene
from cutwise.maths.frames import rotation_from_rpy

if TYPE_CHECKING:
    from cutwise.results import Result

_DRAWN = {"arm": "arm", "body_origin": "bodies"}
_OLD = "what carries the tool is not in this run file: run it again"


def with_carrier(result: "Result", scene: Scene) -> Scene:
    """The scene with what the run's group ``carrier`` knows; one that draws its carrier itself stays as it is.

    At each sample the carrier stands as at the station whose tool point is nearest; the end of an arm is drawn to the tool
    where the sample is, which is off a nominal edge by its radius, or at the height of its ball.
    """
    if scene.links is not None:
        return _held(scene)
    if "carrier" not in result.stages.children:
        silent = getattr(result.scenario, "robot", None) is not None and not any("arm" in one for one in scene.said)
        return (
            replace(scene, said=(*scene.said, "the robot is not drawn: the run does not tell its postures"))
            if silent
            else scene
        )
    told = result["carrier"].dataset
    name = next((one for one in _DRAWN if one in told), None)
    if name is None:
        return replace(scene, said=(*scene.said, _OLD))
    from scipy.spatial import cKDTree

    tip, points = _in_part(result, told["tool_point"].values), _in_part(result, told[name].values)
    station = cKDTree(tip).query(scene.place)[1]
    if name == "arm":
        points[:, -1] = scene.place[cKDTree(scene.place).query(tip)[1]]
    return _held(replace(scene, links=points, link_of=station, links_are=_DRAWN[name]))


def _held(scene: Scene) -> Scene:
    """The scene with an arm that ends where the holder does, or the spindle round it, and not at the tip of the tool."""
    if scene.links is None or scene.links_are != "arm" or not scene.tools:
        return scene
    tool = scene.tools[0]
    top = max(float(profile[:, 0].max(initial=0.0)) for profile in (tool.cutter, tool.holder, tool.fixed))
    assert scene.link_of is not None
    row, sample = np.unique(scene.link_of, return_index=True)
    links = scene.links.copy()
    links[row, -1] += top * np.broadcast_to(scene.axis, scene.place.shape)[sample]
    return replace(scene, links=links)


def _in_part(result: "Result", points: FloatArray) -> FloatArray:
    """Points (..., 3) of the frame of the carrier in that of the part [m]."""
    standing = getattr(result.scenario, "placement", None)
    if standing is None:
        return points.copy()
    return np.asarray((points - np.array(standing.origin)) @ rotation_from_rpy(*standing.rotation))
