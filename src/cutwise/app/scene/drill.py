"""Holes that are drilled one after another: plate, holes with their offset, drill, arm."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise.app.holes import off_place
from cutwise.app.scene.part import block_of
from cutwise.app.scene.scene import CUT, FloatArray, History, Scene, Surface, limits
from cutwise.app.scene.shapes import band, box, drill
from cutwise.app.scene.worst import magnification
from cutwise.process.postures import tool_axes

if TYPE_CHECKING:
    from cutwise.results import Result

_ROUND = 48  # sides of a hole


def scene(result: "Result") -> Scene:
    """The holes over time, one hole behind the other."""
    scenario, motion = result.scenario, result["motion"].dataset
    feed: FloatArray = np.array(scenario.hole.axis, np.float64)  # type: ignore[attr-defined]
    feed /= np.linalg.norm(feed)
    numbers = [int(number) for number in motion["hole"].values]
    all_numbers = result["holes"]["hole"].values.tolist()
    entry = result["holes"]["position"].values[[all_numbers.index(number) for number in numbers]]
    depth, time = motion["depth"].values, motion["time"].values
    count, each = depth.shape
    step = float(time[-1] - time[0]) + (float(time[1] - time[0]) if time.size > 1 else 0.0)
    hole = np.repeat(np.arange(count), each)
    place = entry[hole] + depth.reshape(-1, 1) * feed
    off = off_place(result)
    offset = np.linalg.norm(off, axis=-1)
    thick = result.scenario.part.thickness  # type: ignore[attr-defined]
    made = depth - scenario.tool.cone_height  # type: ignore[attr-defined]  # of the corners, which make the wall
    inside = (made >= 0.0) & (made <= thick)
    high = limits(result, "hole_position_error_exit", "hole_position_error_entry")[1]
    histories = {
        "offset": History("hole off its place", np.where(inside, offset, np.nan).reshape(-1), "small_length", None, high,
                          measures=("hole_position_error_exit", "hole_position_error_entry")),
        "thrust": History("thrust", result["cutting"]["thrust"].values.reshape(-1), "force", *limits(result, "thrust_max"),
                          measures=("thrust_max",)),
        "feed": History("feed per revolution", motion["feed_per_rev"].values.reshape(-1), "small_length",
                        *limits(result, "feed_per_rev_max"), measures=("feed_per_rev_max",)),
        "torque": History("torque", result["cutting"]["torque"].values.reshape(-1), "moment"),
    }  # fmt: skip
    tool = scenario.tool  # type: ignore[attr-defined]
    radius = 0.5 * tool.diameter
    links, said = _arm(result, entry, count)
    times = magnification(radius, float(offset[inside].max(initial=0.0)))
    shown = Drawn(entry, feed, radius, thick)
    plate = _plate(shown)
    return Scene(
        clock=(time[None, :] + step * np.arange(count)[:, None]).reshape(-1), clock_is="time", place=place, axis=-feed[None, :],
        histories=histories, kind=np.full(place.shape[0], CUT, np.uint8),
        tools=(drill(radius, max(tool.flute_length, 2.0 * tool.diameter), 0.5 * tool.point_angle),),
        surfaces=(*(() if block_of(result) else (plate,)), *_holes(shown, made, off, times * _sideways(result, numbers))),
        outlines=_wanted(shown),
        links=links, links_are="bodies" if "body_origin" in motion else "arm",
        focus=(plate.points.min(axis=0), plate.points.max(axis=0)),
        link_of=hole if links is not None else None, judged="offset",
        said=(*said, f"holes drawn off their places, the grey rings, {times:g} times"), path=False,
    )  # fmt: skip


def _arm(result: "Result", entry: FloatArray, count: int) -> tuple[FloatArray | None, tuple[str, ...]]:
    """Joints of the arm or bodies of the machine over each hole, moved to where the part stands in the scenario."""
    motion = result["motion"].dataset
    if "body_origin" in motion and len(motion["body_origin"]) == count:
        return motion["body_origin"].values, ("bodies are boxes between their joints",)
    if "arm" not in motion:
        return None, ()
    points = motion["arm"].values
    if len(points) != count:
        return None, ("the arm is not drawn: it is not known over every hole",)
    shift = entry - points[:, -1]
    said = ("the arm is moved to the part: the part was placed elsewhere",) if np.abs(shift).max() > 1e-3 else ()
    return points + shift[:, None, :], said


def _across(feed: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two axes at right angles to the feed."""
    world = np.array([1.0, 0.0, 0.0]) if abs(feed[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = world - (world @ feed) * feed
    first /= np.linalg.norm(first)
    return first, np.cross(feed, first)


class Drawn(NamedTuple):
    """Holes as they are wanted."""

    entry: FloatArray  # [m], (hole, 3)
    feed: FloatArray  # unit vector
    radius: float  # [m]
    thick: float  # of the part [m]

    def ring(self, wider: float = 1.0) -> FloatArray:
        """A circle round the axis, at the origin."""
        a, b = _across(self.feed)
        angle = np.linspace(0.0, 2.0 * np.pi, _ROUND + 1)
        return wider * self.radius * (np.cos(angle)[:, None] * a + np.sin(angle)[:, None] * b)


def _plate(shown: Drawn) -> Surface:
    """The plate round the holes, entered at right angles."""
    a, b = _across(shown.feed)
    middle = shown.entry.mean(axis=0)
    room = 8.0 * shown.radius
    wide = [float(np.abs((shown.entry - middle) @ axis).max()) + room for axis in (a, b)]
    flat = box("plate", np.array([-wide[0], -wide[1], 0.0]), np.array([wide[0], wide[1], shown.thick]))
    return flat._replace(points=middle + flat.points @ np.stack([a, b, shown.feed]), tint="ghost")


def _sideways(result: "Result", numbers: list[int]) -> FloatArray:
    """The x and y axis of the tool at each hole, shape (hole, 2, 3): turned about the drill axis as the posture says."""
    axis: FloatArray = np.array(result.scenario.hole.axis, np.float64)  # type: ignore[attr-defined]
    axis /= np.linalg.norm(axis)
    angle = np.zeros(len(numbers))
    if "redundancy_angle" in result["holes"].dataset:
        angle = result["holes"]["redundancy_angle"].sel(hole=numbers).values
    return np.swapaxes(tool_axes(axis, np.nan_to_num(angle)), 1, 2)[:, :2]


def _wanted(shown: Drawn) -> tuple[FloatArray, ...]:
    """Rings where the holes are wanted, at entry and exit."""
    ring = shown.ring(1.01)
    return tuple(centre + ring + level * shown.feed for centre in shown.entry for level in (0.0, shown.thick))


def _holes(shown: Drawn, made: FloatArray, off: FloatArray, sideways: FloatArray) -> list[Surface]:
    """The walls of the holes, which the corners make, coloured by their offset; drawn off by ``sideways`` for each metre."""
    levels = np.linspace(0.0, shown.thick, 21)
    ring = shown.ring(1.005)
    found = []
    for one, away, centre, way in zip(made, off, shown.entry, sideways, strict=True):
        first, new = np.unique(np.maximum.accumulate(one), return_index=True)
        right = None if first[-1] >= shown.thick else np.nan
        at = np.column_stack([np.interp(levels, first, away[new, k], right=right) for k in (0, 1)])
        middle = centre + levels[:, None] * shown.feed + np.nan_to_num(at) @ way
        points, corners = band([place + ring for place in middle])
        found.append(
            Surface("hole", points, corners, "work", np.repeat(np.linalg.norm(at, axis=1), _ROUND + 1), "offset")
        )
    return found
