"""The program of a chamfer run: rapids, leads, cuts and ways round corners in their order."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.paths.chamfer.corners import Link, tours
from cutwise.paths.chamfer.leads import way_to, ways_in_hole
from cutwise.paths.chamfer.plan import EdgePath
from cutwise.paths.chamfer.proof import EdgeZone
from cutwise.paths.chamfer.task import ChamferTask
from cutwise.process.labels import labelled
from cutwise.programs.post import Program
from cutwise.results import Result

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")


class _Moves(NamedTuple):
    """Some moves, one row each."""

    position: FloatArray  # [m] of the ball centre, shape (n, 3)
    feed: FloatArray  # [m/s] on the way there, 0: rapid, shape (n,)
    row: FloatArray  # point of the path that they belong to, shape (n,)
    path: int


class Moves(NamedTuple):
    """The moves of a program, and the paths whose leads could not be shown to be clear."""

    table: xr.Dataset
    unproven: tuple[str, ...]


def moves(task: ChamferTask, paths: Sequence[EdgePath], joined: Sequence[Link], members: Sequence[EdgeZone]) -> Moves:
    """All moves of all paths; a feed of zero is a rapid.

    Between tours the tool goes up along its axis, clear of the whole part; tours on the same axis follow one another.
    """
    onward = {link.first: link for link in joined}
    found: list[_Moves] = []
    unproven: list[str] = []
    for tour in _by_axis(paths, tours(len(paths), joined)):
        first = paths[tour[0]]
        if first.path.frames.closed:
            found += _closed(task, first, tour[0], members, unproven)
            continue
        found.append(_lead(task, first, tour[0], 0, members, unproven, inward=True))
        for number in tour:
            path, cut = paths[number], paths[number].feeds.centre
            found.append(
                _Moves(path.path.centre, np.append(cut[0], cut), np.arange(float(len(path.path.centre))), number)
            )
            link = onward.get(number)
            if link is not None:
                last = np.full(len(link.centre), len(path.path.centre) - 1)
                found.append(_Moves(link.centre, np.full(len(link.centre), cut[-1]), last, number))
        final = paths[tour[-1]]
        if tour[-1] in onward:  # round the last corner, to where the tour began
            found.append(_Moves(first.path.centre[:1], final.feeds.centre[-1:], np.zeros(1), tour[0]))
            found.append(_lead(task, first, tour[0], 0, members, unproven, inward=False))
        else:
            end = len(final.path.centre) - 1
            found.append(_lead(task, final, tour[-1], end, members, unproven, inward=False))
    return Moves(_table(paths, found), tuple(dict.fromkeys(unproven)))


def _by_axis(paths: Sequence[EdgePath], found: Sequence[list[int]]) -> list[list[int]]:
    """Tours with those on the same tool axis together, in the order in which the axes come first."""
    axes: list[FloatArray] = []
    groups: list[list[list[int]]] = []
    for tour in found:
        axis = paths[tour[0]].axis
        which = next((i for i, known in enumerate(axes) if np.abs(known - axis).max() < 1e-9), len(axes))
        if which == len(axes):
            axes.append(axis)
            groups.append([])
        groups[which].append(tour)
    return [tour for group in groups for tour in group]


def _lead(
    task: ChamferTask, path: EdgePath, number: int, at: int, members: Sequence[EdgeZone], unproven: list[str],
    *, inward: bool,
) -> _Moves:  # fmt: skip
    way = way_to(task, path, at, members)
    if not way.proven:
        unproven.append(path.work.name)
    points = way.point if inward else way.point[::-1]
    feed = np.zeros(len(points))
    if not inward and len(points) > 1:  # off the edge slantwise: rapids of some machines are not straight
        feed[0] = path.feeds.centre[min(at, len(path.feeds.centre) - 1)]
    return _Moves(points, feed, np.full(len(points), at), number)


def _closed(
    task: ChamferTask, path: EdgePath, number: int, members: Sequence[EdgeZone], unproven: list[str]
) -> list[_Moves]:
    """A closed path with its leads.

    At a hole it is entered from the hole axis on a half circle, overlaps its start and is left the same way; elsewhere
    it is entered and left along the bisector of the edge.
    """
    centre, cut = path.path.centre, path.feeds.centre
    n = len(centre)
    holed = ways_in_hole(task, path, members)
    if holed is None:
        round_it = _Moves(
            np.vstack([centre, centre[:1]]), np.append(cut[0], cut), np.append(np.arange(n), 0), number
        )  # fmt: skip
        return [
            _lead(task, path, number, 0, members, unproven, inward=True), round_it,
            _lead(task, path, number, 0, members, unproven, inward=False),
        ]  # fmt: skip
    ways, fine = holed
    if not fine:
        unproven.append(path.work.name)
    over = max(len(ways.overlap), 1)
    lead_in, lead_out = len(ways.entry) - 1, len(ways.exit) - 1
    points = np.vstack([ways.entry, centre[1:], ways.overlap if len(ways.overlap) else centre[:1], ways.exit[1:]])
    turn = np.concatenate([cut, cut[:over]])[: n - 1 + over]
    feeds = np.concatenate([[0.0, 0.0], np.full(lead_in - 1, cut[0]), turn, np.full(lead_out, cut[-1])])
    feeds[-1] = 0.0
    row = np.concatenate([np.zeros(lead_in + 1), np.arange(1, n), np.arange(over), np.zeros(lead_out)])
    return [_Moves(points, feeds, row, number)]


def _table(paths: Sequence[EdgePath], found: Sequence[_Moves]) -> xr.Dataset:
    count = sum(len(m.feed) for m in found)
    rows = [m.row.astype(int) for m in found]
    number = np.concatenate([np.full(len(m.feed), m.path) for m in found])

    def along(values: list[FloatArray]) -> FloatArray:
        return np.concatenate(values)

    return labelled(("move", np.arange(count), "1", "number of the move"), {
        "position": (along([m.position for m in found]), "m", "ball centre"),
        "tool_axis": (along([np.tile(paths[m.path].axis, (len(m.feed), 1)) for m in found]), "1", "rod direction"),
        "feed": (along([m.feed for m in found]), "m/s", "speed of the ball centre on the way here, 0: rapid"),
        "travel": (along([paths[m.path].local.feed[r] for m, r in zip(found, rows, strict=True)]), "1",
                   "direction along the edge"),
        "press": (along([-paths[m.path].path.air[r] for m, r in zip(found, rows, strict=True)]), "1",
                  "direction into the chamfer"),
        "path": (number, "1", "path number"),
    }, axis=["x", "y", "z"])  # fmt: skip


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
    position, axis, feed, travel, press = (
        found[name].values for name in ("position", "tool_axis", "feed", "travel", "press")
    )
    return Program(
        result.scenario.name, result.scenario.tool.ball_radius,  # type: ignore[attr-defined]
        position, axis, feed, travel, press, found["path"].values.astype(np.int64),
        result.scenario.operation.spindle_speed,  # type: ignore[attr-defined]
    )  # fmt: skip
