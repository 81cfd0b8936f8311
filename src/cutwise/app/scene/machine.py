"""The pass of a machine: where the tool is off, magnified, with the bodies that carry it; or the map of its space."""

from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene.scene import CUT, FEED, FloatArray, History, Scene, limits
from cutwise.app.scene.shapes import cylinder
from cutwise.app.scene.worst import magnification

if TYPE_CHECKING:
    from cutwise.results import Result

_TOOL = 0.006  # [m] radius that stands for a tool whose size the scenario does not say
_OFF = 0.1  # of the extent of the path: how far it is drawn off its place at most
_MOST_LINKS = 2000  # rows of body origins in a view file


def scene(result: "Result") -> Scene:
    """A pass where there is one, else the grid of the working space."""
    return _pass(result) if "motion" in result.stages.children else _volume(result)


def _pass(result: "Result") -> Scene:
    motion, surface = result["motion"].dataset, result["surface"].dataset
    time, place, error = motion["time"].values, motion["position"].values, surface["f4"].values
    count = time.size
    cut = "wall_error_max" in result.measures
    length = np.linalg.norm(error, axis=1)
    histories = {
        "error": History("error of the tool point", length, "small_length", *limits(result, "deviation_norm_max"),
                         measures=("deviation_norm_max",)),
        **_components(error),
    }  # fmt: skip
    if "cutting" in result.stages.children:
        histories["force"] = History(
            "cutting force", np.linalg.norm(result["cutting"]["force"].values, axis=1), "force"
        )
    if cut and "error_on_path" in surface:
        low, high = limits(result, "wall_error_min")[0], limits(result, "wall_error_max")[1]
        histories["wall"] = History(
            "wall error",
            surface["error_on_path"].values,
            "small_length",
            low,
            high,
            measures=("wall_error_max", "wall_error_min"),
        )
    judged = "wall" if "wall" in histories and result.scenario.focus.startswith("wall") else "error"
    line = motion["program_line"].values.astype(np.int64)
    shown = np.unique(np.linspace(0, count - 1, min(count, _MOST_LINKS)).astype(int))
    radius, said = _radius(result)
    times = _times(place, float(length.max(initial=0.0)))
    return Scene(
        clock=time, clock_is="time", place=place, trace=place + times * error, outlines=(place,),
        axis=_axis(result), histories=histories,
        line=line if line.any() else None, kind=np.where(motion["cuts"].values > 0, CUT, FEED).astype(np.uint8),
        deflection=error, tools=(cylinder(radius, 5.0 * radius),), links_are="bodies", links=motion["body_origin"].values[shown],
        link_of=np.clip(np.searchsorted(shown, np.arange(count)), 0, shown.size - 1), judged=judged,
        said=(*said, f"path drawn off its place, the grey line, {times:g} times",
              "bodies are boxes between their joints", "no part: only the path is known"),
    )  # fmt: skip


def _times(place: FloatArray, largest: float) -> float:
    """How often an error is drawn so that a path is seen beside where it should be: a tenth of its extent at most."""
    return magnification(4.0 * _OFF * float(np.linalg.norm(np.ptp(place, axis=0))), largest)


def _axis(result: "Result") -> FloatArray:
    """From the tool point up the tool: to the origin of the body that holds it, as both turn with rotary axes.

    Where that origin is the tool point itself, the direction that the scenario says, which points from the holder down.
    """
    motion = result["motion"].dataset
    away = motion["body_origin"].values[:, -1] - motion["position"].values
    size = np.linalg.norm(away, axis=1, keepdims=True)
    if size.min() > 1e-6:
        return np.asarray(away / size)
    down = np.array(getattr(getattr(result.scenario, "path", None), "tool_axis", None) or (0.0, 0.0, -1.0), float)
    return np.asarray(-(down / np.linalg.norm(down))[None, :])


def _radius(result: "Result") -> tuple[float, tuple[str, ...]]:
    tool = getattr(result.scenario, "tool", None)
    diameter = getattr(tool, "diameter", None)
    return (0.5 * diameter, ()) if diameter else (_TOOL, ("the size of the tool is not said: one of 12 mm is drawn",))


def _components(error: FloatArray) -> dict[str, History]:
    return {
        f"error_{axis}": History(f"error along {axis}", error[:, k], "small_length", drawn=False)
        for k, axis in enumerate("xyz")
    }


def _volume(result: "Result") -> Scene:
    volume = result["volume"].dataset
    place, error = volume["position"].values.copy(), volume["error"].values.copy()
    for array in (place, error):  # to and fro, so that the line through the points has no long ways
        array[:, 1::2] = array[:, 1::2, ::-1]
        array[1::2] = array[1::2, ::-1]
    place, error = place.reshape(-1, 3), error.reshape(-1, 3)
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(place, axis=0), axis=1))])
    histories = {
        "error": History(
            "error of the tool point", np.linalg.norm(error, axis=1), "small_length", *limits(result, "volumetric_error_max"),
            measures=("volumetric_error_max",),
        ),
        **_components(error),
    }  # fmt: skip
    return Scene(
        clock=way, clock_is="way", place=place, histories=histories, kind=np.full(way.size, FEED, np.uint8), judged="error",
        said=("points of the working space one after another; the line through them is no tool path",),
    )  # fmt: skip
