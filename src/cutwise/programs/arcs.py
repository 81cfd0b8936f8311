"""Arcs: centre and turns from the words of a block, and whether they fit together."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from cutwise.programs import compensation
from cutwise.programs.block import Block
from cutwise.programs.canon import Arc
from cutwise.programs.controller import PLANES, Controller
from cutwise.programs.expressions import whole
from cutwise.programs.motions import check_feed, inverse_time, present, target
from cutwise.programs.plane_curves import Circle


class Slack(NamedTuple):
    """How far words of an arc may contradict one another, in program units."""

    near: float  # difference of the radii at start and end that is always allowed
    far: float  # that is never allowed
    least: float  # radius that is none; also by how much R may be short of half the chord


MILLIMETRES = Slack(0.02 * math.sqrt(2.0), 2.0 * math.sqrt(2.0), 0.00127)
INCHES = Slack(0.002 * math.sqrt(2.0), 0.2 * math.sqrt(2.0), 0.00005)
SHARE = 1e-3  # of the radius: difference between near and far that is allowed


def arc(c: Controller, block: Block) -> None:
    """G2 and G3, in any plane, with a helix and several turns."""
    if c.no_arc_yet:
        raise block.fault("the first motion after cutter compensation must be straight", "g.motion", *block.axes())
    check_feed(c, block)
    start, end = present(c), target(c, block)
    circle = circle_of(c, block, start, end)
    u, v, w = PLANES[c.plane]
    if c.feed_mode == 93:
        inverse_time(c, block, arc_length(start, end, circle, (u, v, w)))
    if c.compensation is not None and c.compensation.radius > 0.0:
        compensation.arc(c, block, end, circle)
        return
    c.at[:] = end
    c.out.append(Arc(end[u], end[v], circle.u, circle.v, circle.turns, end[w], c.rotary, c.extra, c.line, c.number))


def arc_length(start: Sequence[float], end: Sequence[float], circle: Circle, axes: tuple[int, int, int]) -> float:
    """Length of an arc or helix."""
    u, v, w = axes
    radius = math.hypot(start[u] - circle.u, start[v] - circle.v)
    angle = sweep((start[u] - circle.u, start[v] - circle.v), (end[u] - circle.u, end[v] - circle.v), circle.turns)
    return math.hypot(radius * angle, end[w] - start[w])


def sweep(start: tuple[float, float], end: tuple[float, float], turns: int) -> float:
    """Angle from one radius to another [rad], counterclockwise positive; equal directions are full turns."""
    angle = math.atan2(end[1], end[0]) - math.atan2(start[1], start[0])
    full = 2.0 * math.pi
    angle = angle % full if turns > 0 else -(-angle % full)
    if abs(angle) < 1e-12 or full - abs(angle) < 1e-12:
        angle = math.copysign(full, turns)
    return angle + math.copysign(full * (abs(turns) - 1), turns)


def circle_of(c: Controller, block: Block, start: Sequence[float], end: Sequence[float]) -> Circle:
    """The circle that I, J, K or R of a block mean.

    Raises
    ------
    BlockFault
        Words are missing, of another plane, or of both kinds; start and end are not on the circle.
    """
    u, v, _ = PLANES[c.plane]
    turns = 1
    if "p" in block.values:
        turns = whole(block.values["p"], block.places["p"], "the number of turns P")
        if turns < 1:
            raise block.fault("the number of turns P must be 1 or more", "p")
        c.spend(turns - 1, f"an arc of {turns} turns", block.places["p"])
    sense = turns if block.motion == 30 else -turns
    letters = "ijk"[u], "ijk"[v]
    given = [letter for letter in "ijk" if letter in block.values]
    if "r" in block.values:
        if given:
            raise block.fault("arc with both R and a centre; keep one", "r")
        return _by_radius(c, block, (start[u], start[v]), (end[u], end[v]), sense)
    if not given:
        raise block.fault(f"arc without a centre; write {letters[0].upper()}, {letters[1].upper()} or R", *block.axes(),
                          "g.motion")  # fmt: skip
    for letter in given:
        if letter not in letters:
            raise block.fault(f"{letter.upper()} is not in the plane of the arc ({c.plane})", letter)
    return _by_centre(c, block, (start[u], start[v]), (end[u], end[v]), sense)


def _by_centre(c: Controller, block: Block, start: tuple[float, float], end: tuple[float, float], turns: int) -> Circle:
    u, v, _ = PLANES[c.plane]
    letters = "ijk"[u], "ijk"[v]
    offset = [block.values.get(letter, 0.0) for letter in letters]
    if c.arc_absolute:
        for letter in letters:
            if letter not in block.values:
                raise block.fault(f"with G90.1 an arc needs both {letters[0].upper()} and {letters[1].upper()}",
                                  *letters)  # fmt: skip
        circle = Circle(offset[0], offset[1], turns)
    else:
        circle = Circle(start[0] + offset[0], start[1] + offset[1], turns)
    first = math.hypot(start[0] - circle.u, start[1] - circle.v)
    last = math.hypot(end[0] - circle.u, end[1] - circle.v)
    slack, gap = INCHES if c.inch else MILLIMETRES, abs(first - last)
    if first < slack.least or last < slack.least:
        raise block.fault("arc without a radius: its centre is on its start or end", *letters)
    if gap > slack.far or (gap > slack.near and gap > SHARE * max(first, last)):
        unit = "in" if c.inch else "mm"
        radii = f"radius {first:.6g} {unit} at the start, {last:.6g} {unit} at the end"
        raise block.fault(f"the end of the arc is not on its circle: {radii}", *block.axes(), *letters)
    return circle


def _by_radius(c: Controller, block: Block, start: tuple[float, float], end: tuple[float, float], turns: int) -> Circle:
    radius = block.values["r"]
    du, dv = end[0] - start[0], end[1] - start[1]
    chord = math.hypot(du, dv)
    if not chord:
        raise block.fault("an arc by R needs an end apart from its start; write a full circle with its centre", "r")
    half, slack = 0.5 * chord, INCHES if c.inch else MILLIMETRES
    if half - abs(radius) > slack.least or radius == 0.0:
        unit = "in" if c.inch else "mm"
        reach = f"{chord:.6g} {unit} from the start, more than twice the radius {abs(radius):.6g} {unit}"
        raise block.fault(f"the end is {reach}", "r")
    height = math.sqrt(max(radius * radius - half * half, 0.0))
    side = 1.0 if (turns > 0) == (radius > 0.0) else -1.0  # the short arc for a positive R
    return Circle(
        start[0] + 0.5 * du - side * height * dv / chord, start[1] + 0.5 * dv + side * height * du / chord, turns
    )
