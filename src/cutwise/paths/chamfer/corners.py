"""Convex corners between chamfers: where one path ends and another begins, the ball is led round the corner.

The ball centre swings about the corner point on a great circle, as far from it as at both path ends, so that the tool
neither leaves the part nor dwells. A link is made only if it cuts nothing but the chamfers, and the rod clears.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.paths.chamfer import proof
from cutwise.paths.chamfer.leads import clear
from cutwise.paths.chamfer.plan import EdgePath
from cutwise.paths.chamfer.task import ChamferTask

_MEET = 2e-5  # [m] path ends closer than this are one corner


class Link(NamedTuple):
    """A way of the ball from the end of one path to the start of another."""

    first: int  # number of the path that ends
    second: int  # number of the one that begins
    centre: FloatArray  # [m] of the ball between both, without the ends, shape (k, 3)


def links(task: ChamferTask, paths: Sequence[EdgePath], members: Sequence[proof.EdgeZone]) -> tuple[Link, ...]:
    """Ways round all corners where that is possible; each path end is used once."""
    found = []
    left, entered = set(), set()
    for _, i, j in sorted(_meetings(paths)):
        if i in left or j in entered:
            continue
        centre = _round_corner(task, paths[i], paths[j])
        if clear(task, paths[i], centre, members):
            found.append(Link(i, j, centre[1:-1]))
            left.add(i)
            entered.add(j)
    return tuple(found)


def _meetings(paths: Sequence[EdgePath]) -> list[tuple[float, int, int]]:
    """Pairs of a path that ends and one that begins at the same corner on the same tool axis, by the turn between."""
    open_ones = [i for i, path in enumerate(paths) if not path.path.frames.closed]
    pairs = []
    for i in open_ones:
        corner = paths[i].path.frames.point[-1]
        for j in open_ones:
            if i == j or np.linalg.norm(paths[j].path.frames.point[0] - corner) > _MEET:
                continue
            if paths[i].axis @ paths[j].axis < 1.0 - 1e-9:
                continue
            turn = float(np.linalg.norm(paths[i].path.centre[-1] - paths[j].path.centre[0]))
            pairs.append((turn, i, j))
    return pairs


def _round_corner(task: ChamferTask, first: EdgePath, second: EdgePath) -> FloatArray:
    """Ball centres from the end of one path to the start of the next, both included [m], shape (k, 3)."""
    corner = 0.5 * (first.path.frames.point[-1] + second.path.frames.point[0])
    a, b = first.path.centre[-1] - corner, second.path.centre[0] - corner
    far_a, far_b = float(np.linalg.norm(a)), float(np.linalg.norm(b))
    angle = math.acos(max(-1.0, min(1.0, float(a @ b) / (far_a * far_b))))
    tolerance = task.chord_tolerance or 2e-6
    steps = max(2, math.ceil(angle / math.sqrt(8.0 * tolerance / far_a)))
    share = np.linspace(0.0, 1.0, steps + 1)[:, None]
    if angle < 1e-6:
        return corner + (1.0 - share) * a + share * b
    turned = (np.sin((1.0 - share) * angle) * a / far_a + np.sin(share * angle) * b / far_b) / math.sin(angle)
    return corner + ((1.0 - share) * far_a + share * far_b) * turned


def tours(count: int, joined: Sequence[Link]) -> list[list[int]]:
    """Path numbers in the order in which they are run, one list for each time that the tool goes to the part."""
    onward = {link.first: link.second for link in joined}
    entered = set(onward.values())
    found = []
    done: set[int] = set()
    for start in [i for i in range(count) if i not in entered] + list(range(count)):  # open tours, then closed ones
        tour = []
        place: int | None = start
        while place is not None and place not in done:
            done.add(place)
            tour.append(place)
            place = onward.get(place)
        if tour:
            found.append(tour)
    return found
