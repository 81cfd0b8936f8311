"""A program as it runs, kept together with its text: which line made which move, how often a line ran, and in which modes."""

import re
from bisect import bisect_right
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.programs import canon
from cutwise.programs.canon import (
    Arc,
    AxisOffset,
    Command,
    FeedMode,
    FeedRate,
    LengthUnits,
    Plane,
    Rotation,
    WorkOffset,
)
from cutwise.programs.controller import INCH, MILLIMETRE, PLANES, Controller, PlaneName
from cutwise.programs.interpreter import default_tool, reading
from cutwise.programs.motions import present
from cutwise.programs.moves import Move, moves
from cutwise.programs.rs274 import Rs274
from cutwise.programs.setup import Setup

_FLOW = re.compile(
    r"^[ \t]*/?[ \t]*(?:N[ \t]*\d+[ \t]*)?O|M[ \t]*9[89]|GOTO|WHILE|G[ \t]*6[56]", re.IGNORECASE | re.MULTILINE
)
_POINTS = (
    canon.Traverse, canon.Feed, canon.Probe, canon.TapStroke, canon.DrawnOut,
)  # fmt: skip
_FRAMES = (LengthUnits, WorkOffset, AxisOffset, Rotation)


class State(NamedTuple):
    """The controller behind a line."""

    motion: int  # ten times the G code
    inch: bool
    incremental: bool
    arc_absolute: bool
    plane: str
    feed_mode: int
    beside: tuple[float, int, int] | None  # cutter compensation: radius, positive left, and the axes of its plane
    at: tuple[float, float, float]  # where the program stands, in its units
    inside: bool  # of a subroutine or macro


class Ran(NamedTuple):
    """A move with what it came from."""

    move: Move
    command: Command
    start: tuple[float, float, float] | None  # in the units of the program; None: the coordinates have just changed
    plane: str


class Word(NamedTuple):
    """A feed that came into force: line, and value in program units; None behind a change of the feed mode.

    Behind a change of units the feed stays, and its number is another: by ``factor``.
    """

    line: int
    rate: float | None
    factor: float = 0.0


class Trace(NamedTuple):
    """A run."""

    lines: tuple[str, ...]
    runs: npt.NDArray[np.int64]  # how often each line ran
    states: dict[int, State]  # by line from 1; lines of straight motions alone are not there
    first: State  # before the program
    steps: tuple["Ran | Word", ...]  # moves and feeds in the order of the run
    looked_at: list[int]  # lines of ``states``, rising

    def state(self, line: int) -> State:
        """The controller at a line; at one of straight motions alone, but for its motion and its place."""
        found = self.states.get(line)
        if found is not None:
            return found
        at = bisect_right(self.looked_at, line)
        return self.states[self.looked_at[at - 1]] if at else self.first


def _state(c: Controller, inside: bool) -> State:
    on = c.compensation
    beside = None if on is None or on.radius == 0.0 else (on.side * on.radius, on.u, on.v)
    x, y, z = present(c)[:3]
    return State(c.motion, c.inch, c.incremental, c.arc_absolute, c.plane, c.feed_mode, beside, (x, y, z), inside)


class _Watch:
    """Counts lines and keeps the modes; of every line where lines do not simply follow one another."""

    def __init__(self, run: Rs274, text: str) -> None:
        self.closely = _FLOW.search(text) is not None
        self.run = run
        self.runs = np.zeros(len(run.flow.main.lines), np.int64)
        self.states: dict[int, State] = {}

    def ran_plain(self, first: int, end: int) -> None:
        self.runs[first:end] += 1

    def ran(self, at: int, controller: Controller) -> None:
        self.runs[at] += 1
        self.states[at + 1] = _state(controller, bool(self.run.flow.frames))


def traced(text: str, name: str, setup: Setup) -> Trace | None:
    """Run a program and look on; None for APT, whose statements are no blocks.

    Raises
    ------
    ScenarioFault
        With everything in the program that cannot be run.
    """
    run = reading(text, name, setup)
    if not isinstance(run, Rs274):
        return None
    watch = _Watch(run, text)
    run.watch = watch
    first = _state(run.controller, False)
    steps: list[Ran | Word] = []
    last: list[Command] = []
    at: tuple[float, float, float] | None = None
    before: tuple[float, float, float] | None = None
    inch = run.controller.inch
    plane: PlaneName = run.controller.plane

    def watched() -> Iterator[Command]:
        nonlocal at, before, plane, inch
        for command in run.commands():
            last[:] = [command]
            if isinstance(command, FeedRate):
                steps.append(Word(command.line, command.rate if command.rate > 0.0 else None))
            elif isinstance(command, FeedMode):
                steps.append(Word(command.line, None))
            elif isinstance(command, _FRAMES):
                at = None
                if isinstance(command, LengthUnits):
                    if command.inch != inch and not _said_here(steps, command.line):
                        steps.append(Word(command.line, None, MILLIMETRE / INCH if command.inch else INCH / MILLIMETRE))
                    inch = command.inch
            elif isinstance(command, Plane):
                plane = command.plane
            end = _end(command, plane)
            if end is not None:
                before, at = at, end
            yield command

    for move in moves(watched(), start=run.start, tool=default_tool(setup)):
        steps.append(Ran(move, last[0], before, plane))
    return Trace(tuple(run.flow.main.lines), watch.runs, watch.states, first, tuple(steps), sorted(watch.states))


def _said_here(steps: list[Ran | Word], line: int) -> bool:
    """Whether a feed stands in the very block of a unit word, and is meant in the new unit."""
    last = steps[-1] if steps else None
    return isinstance(last, Word) and last.line == line and last.rate is not None


def _end(command: Command, plane: str) -> tuple[float, float, float] | None:
    """Where a motion leads, in the units of the program."""
    if isinstance(command, Arc):
        u, v, w = PLANES[plane]
        end = [0.0, 0.0, 0.0]
        end[u], end[v], end[w] = command.first, command.second, command.axial
        return end[0], end[1], end[2]
    if isinstance(command, _POINTS):
        return command.x, command.y, command.z
    return None
