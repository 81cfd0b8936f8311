"""What a G-code interpreter remembers between blocks, and the moves that it makes."""

import math
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

from cutwise import units
from cutwise.io.programs.blocks import Word
from cutwise.spec.faults import Fault

Point = tuple[float, float, float]


class Move(NamedTuple):
    """One straight line, arc or helix of the tool, or a dwell."""

    kind: Literal["rapid", "feed", "arc", "dwell"]
    start: Point  # [m]
    end: Point  # [m]
    centre: Point  # [m] of an arc
    axis: Point  # of an arc, unit vector
    sweep: float  # of an arc about its axis [rad], right-handed
    feed: float  # [m/s]; infinite for a rapid move
    spindle: float  # [rad/s], signed: positive clockwise (M3), 0 stopped
    mode: str  # exact_path, exact_stop or blend
    tolerance: float  # of a blend [m]
    dwell: float  # [s]
    line: int  # of the program


@dataclass(frozen=True)
class State:
    """Modal state before a block."""

    at: Point = (0.0, 0.0, 0.0)
    motion: float = 1.0
    plane: str = "G17"
    unit: str = "mm"
    absolute: bool = True
    arc_absolute: bool = False
    feed: float = 0.0
    speed: float = 0.0
    turning: int = 0
    mode: str = "exact_path"
    tolerance: float = 0.0
    retract_to_start: bool = True
    cycle_z: float | None = None
    cycle_r: float | None = None
    cycle_q: float = 0.0
    cycle_p: float = 0.0
    ended: bool = False


@dataclass
class Run:
    """What has been read so far."""

    name: str
    faults: list[Fault] = field(default_factory=list)
    moves: list[Move] = field(default_factory=list)
    tools: list[int] = field(default_factory=list)
    notices: list[str] = field(default_factory=list)

    def fault(self, message: str, word: Word) -> None:
        """Something that cannot be run, at its place."""
        self.faults.append(Fault((), message, word.line, word.column, self.name))


def target(values: dict[str, Word], state: State) -> Point:
    """Where the axis words lead [m]."""
    scale = units.factor(state.unit, "length")
    to = list(state.at)
    for i, letter in enumerate("XYZ"):
        if letter in values:
            given = values[letter].value * scale
            to[i] = given if state.absolute else to[i] + given
    return to[0], to[1], to[2]


def new_move(
    state: State, kind: Literal["rapid", "feed", "arc", "dwell"], end: Point, line: int, *,
    centre: Point = (0.0, 0.0, 0.0), axis: Point = (0.0, 0.0, 1.0), sweep: float = 0.0, dwell: float = 0.0,
) -> Move:  # fmt: skip
    """A move from where the state stands, under its feed, speed and path mode."""
    feed = math.inf if kind == "rapid" else state.feed
    spindle = state.turning * state.speed
    return Move(kind, state.at, end, centre, axis, sweep, feed, spindle, state.mode, state.tolerance, dwell, line)


def moved(state: State, kind: Literal["rapid", "feed"], end: Point, line: int, run: Run) -> State:
    """The state after a straight move, which is recorded unless it leads nowhere."""
    if end != state.at:
        run.moves.append(new_move(state, kind, end, line))
    return replace(state, at=end)
