"""Holes that are drilled one after another: plate, holes with their offset, drill, arm."""

from typing import TYPE_CHECKING

import numpy as np

from cutwise.app.scene.scene import CUT, FloatArray, History, Scene, Surface, limits
from cutwise.app.scene.shapes import band, box, drill

if TYPE_CHECKING:
    from cutwise.results import Result

_ROUND = 48  # sides of a hole


def scene(result: "Result") -> Scene:
    """The holes over time, one hole behind the other."""
    scenario, motion = result.scenario, result["motion"].dataset
    feed = np.array(scenario.hole.axis, float)  # type: ignore[attr-defined]
    feed /= np.linalg.norm(feed)
    numbers = [int(number) for number in motion["hole"].values]
    all_numbers = result["holes"]["hole"].values.tolist()
    entry = result["holes"]["position"].values[[all_numbers.index(number) for number in numbers]]
    depth, time = motion["depth"].values, motion["time"].values
    count, each = depth.shape
    step = float(time[-1] - time[0]) + (float(time[1] - time[0]) if time.size > 1 else 0.0)
    hole = np.repeat(np.arange(count), each)
    place = entry[hole] + depth.reshape(-1, 1) * feed
    offset = np.linalg.norm(result["surface"]["hole_position"].values, axis=-1)
    inside = (depth > 0.0) & (depth <= scenario.part.thickness)  # type: ignore[attr-defined]
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
    return Scene(
        clock=(time[None, :] + step * np.arange(count)[:, None]).reshape(-1), clock_is="time", place=place, axis=-feed[None, :],
        histories=histories, kind=np.full(place.shape[0], CUT, np.uint8),
        tools=(drill(radius, max(tool.flute_length, 2.0 * tool.diameter), 0.5 * tool.point_angle),),
        surfaces=(_plate(result, entry, feed, radius), *_holes(result, entry, feed, radius, depth, offset)),
        links=links, link_of=hole if links is not None else None, judged="offset",
        said=(*said, "holes stand where they should; their colour is how far off they are"), path=False,
    )  # fmt: skip


def _arm(result: "Result", entry: FloatArray, count: int) -> tuple[FloatArray | None, tuple[str, ...]]:
    """Joints of the arm over each hole, moved to where the part stands in the scenario."""
    motion = result["motion"].dataset
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


def _plate(result: "Result", entry: FloatArray, feed: FloatArray, radius: float) -> Surface:
    """The plate round the holes, entered at right angles."""
    a, b = _across(feed)
    middle = entry.mean(axis=0)
    room = 8.0 * radius
    wide = [float(np.abs((entry - middle) @ axis).max()) + room for axis in (a, b)]
    flat = box(
        "plate", np.array([-wide[0], -wide[1], 0.0]), np.array([wide[0], wide[1], result.scenario.part.thickness])
    )  # type: ignore[attr-defined]
    return flat._replace(points=middle + flat.points @ np.stack([a, b, feed]), tint="ghost")


def _holes(
    result: "Result", entry: FloatArray, feed: FloatArray, radius: float, depth: FloatArray, offset: FloatArray
) -> list[Surface]:
    """The walls of the holes, coloured by their offset at each depth."""
    a, b = _across(feed)
    thick = result.scenario.part.thickness  # type: ignore[attr-defined]
    angle = np.linspace(0.0, 2.0 * np.pi, _ROUND + 1)
    ring = 1.005 * radius * (np.cos(angle)[:, None] * a + np.sin(angle)[:, None] * b)
    levels = np.linspace(0.0, thick, 21)
    found = []
    for one, off, centre in zip(depth, offset, entry, strict=True):
        first = np.maximum.accumulate(one)
        reached = first[-1] >= thick
        values = np.interp(levels, first, off) if reached else np.interp(levels, first, off, right=np.nan)
        points, corners = band([centre + ring + level * feed for level in levels])
        found.append(Surface("hole", points, corners, "work", np.repeat(values, _ROUND + 1), "offset"))
    return found
