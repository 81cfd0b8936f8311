"""The program of a chamfer run: rapids, leads and cuts in their order."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from cutwise.io.programs.post import Program
from cutwise.maths.curves import FloatArray
from cutwise.paths.feed import leads
from cutwise.process.chamfer_plan import EdgePath
from cutwise.process.labels import labelled
from cutwise.results import Result


def moves(paths: Sequence[EdgePath], retract: float) -> xr.Dataset:
    """All moves of all paths; a feed of zero is a rapid."""
    position, feed, axis, travel, press, number = [], [], [], [], [], []
    for i, path in enumerate(paths):
        points, feeds, row = _one(path, retract)
        position.append(points)
        feed.append(feeds)
        axis.append(np.tile(path.axis, (len(points), 1)))
        travel.append(path.local.feed[row])
        press.append(-path.path.air[row])
        number.append(np.full(len(points), i))
    count = sum(map(len, feed))
    return labelled(("move", np.arange(count), "1", "number of the move"), {
        "position": (np.concatenate(position), "m", "ball centre"),
        "tool_axis": (np.concatenate(axis), "1", "rod direction"),
        "feed": (np.concatenate(feed), "m/s", "speed of the ball centre on the way here, 0: rapid"),
        "travel": (np.concatenate(travel), "1", "direction along the edge"),
        "press": (np.concatenate(press), "1", "direction into the chamfer"),
        "path": (np.concatenate(number), "1", "path number"),
    }, axis=["x", "y", "z"])  # fmt: skip


def _one(path: EdgePath, retract: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Positions, feeds and rows of the path they belong to, for one path with its leads.

    A closed path at a hole is entered from the hole axis on a half circle, overlaps its start and leaves the same way;
    other paths are entered and left along the bisector of the edge.
    """
    centre, closed = path.path.centre, path.path.frames.closed
    n = len(centre)
    cut = path.feeds.centre
    if closed and path.work.foot is not None:
        rim = float(
            (path.work.shape.skin.corner.reshape(-1, 3) @ path.axis).max()
        )  # out of the hole, not only off the edge
        above_path = rim - float((centre @ path.axis).max()) + path.ball_radius + retract
        ways = leads(path.path, path.axis, path.work.foot, max(retract, above_path))
        over = len(ways.overlap)
        points = np.vstack([ways.entry, centre[1:], ways.overlap if over else centre[:1], ways.exit[1:]])
        lead_in, lead_out = len(ways.entry) - 1, len(ways.exit) - 1
        overlap = max(over, 1)
        turn = np.concatenate([cut, cut[:overlap]])[: n - 1 + overlap]
        feeds = np.concatenate([[0.0, 0.0], np.full(lead_in - 1, cut[0]), turn, np.full(lead_out, cut[-1])])
        feeds[-1] = 0.0
        row = np.concatenate([np.zeros(lead_in + 1), np.arange(1, n), np.arange(overlap), np.zeros(lead_out)])
        return points, feeds, row.astype(int)
    above = retract * path.path.air
    ends = np.vstack([centre, centre[:1]]) if closed else centre
    last = 0 if closed else n - 1
    clear = [ends[0] + above[0], ends[-1] + above[last]]
    points = np.vstack([clear[0], ends, clear[1]])
    feeds = np.concatenate([[0.0, cut[0]], cut, [0.0]])
    row = np.concatenate([[0], np.arange(len(ends)) % n, [last]])
    return points, feeds, row.astype(int)


def program_of(result: Result) -> Program:
    """The program that a finished chamfer run holds.

    Raises
    ------
    ValueError
        The run has no path.
    """
    if "program" not in result.stages.children:
        raise ValueError("this run holds no tool path, so there is no program to write")
    found = result["program"].dataset
    return Program(
        result.scenario.name, result.scenario.tool.ball_radius,  # type: ignore[attr-defined]
        *(found[name].values for name in ("position", "tool_axis", "feed", "travel", "press")),
        found["path"].values.astype(np.int64),
    )  # fmt: skip
