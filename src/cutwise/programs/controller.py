"""What a CNC controller remembers between blocks, and its variables.

The state changes in place: a program may have a million blocks, and a new record for each would take longer than all
else. Lengths and feeds are in the program's current units, positions in its work coordinates, angles in degrees, as the
program itself means them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from cutwise.programs.canon import Command, Triple
from cutwise.programs.expressions import BlockFault
from cutwise.programs.plane_curves import Curve, Point
from cutwise.programs.setup import Setup, Tool

PathModeName = Literal["exact_path", "exact_stop", "continuous"]
PlaneName = Literal["XY", "XZ", "YZ"]

AXES = "xyzabcuvw"
LINEAR = (0, 1, 2, 6, 7, 8)  # places of the axes with a length; the others are angles
PLANES: dict[str, tuple[int, int, int]] = {"XY": (0, 1, 2), "XZ": (2, 0, 1), "YZ": (1, 2, 0)}
"""The axes of a plane in the order of its arcs, and the axis across it."""

ZEROS = (0.0,) * 9
NO_TOOL = Tool(0)
INCH, MILLIMETRE = 0.0254, 1e-3  # [m], by definition: no need to load the registry of units for them


@dataclass(slots=True)
class Cycle:
    """Words of a canned cycle that hold until the motion changes."""

    level: float = 0.0  # height at which the series of cycles began
    bottom: float | None = None
    clearance: float | None = None
    peck: float | None = None
    dwell: float | None = None


@dataclass(slots=True)
class Spindle:
    """What the spindle is told."""

    speed: float = 0.0
    turning: Literal[-1, 0, 1] = 0  # 1: clockwise
    surface_limit: float = 0.0  # fastest [1/min] under constant surface speed (G96); 0: revolutions per minute (G97)


@dataclass(slots=True)
class Switches:
    """Coolant and override switches."""

    mist: bool = False
    flood: bool = False
    feed_override: bool = True
    speed_override: bool = True
    adaptive_feed: bool = False
    feed_hold: bool = True


@dataclass(slots=True)
class Offsets:
    """Where the work coordinates stand: machine = rotation (program + axis) + origin + tool."""

    system: int = 1  # 1: G54
    origin: list[float] = field(default_factory=lambda: list(ZEROS))
    rotation: float = 0.0
    axis: list[float] = field(default_factory=lambda: list(ZEROS))  # G92, G52
    tool: list[float] = field(default_factory=lambda: list(ZEROS))  # G43


@dataclass(slots=True)
class Compensation:
    """Cutter compensation in force."""

    left: bool
    radius: float
    u: int  # axes of the plane
    v: int
    out: list[Command]  # where commands go when they are final
    programmed: Point | None = None  # end of the contour so far; None before the entry
    last: Curve | None = None
    pending: list[Command] = field(default_factory=list)

    @property
    def side(self) -> float:
        """1 left, -1 right of the contour."""
        return 1.0 if self.left else -1.0

    def beside(self, point: Point, direction: Point) -> Point:
        """The tool centre beside a point of the contour."""
        s = self.side * self.radius
        return point[0] - s * direction[1], point[1] + s * direction[0]


class Saved(NamedTuple):
    """What M70 and M73 save: not the motion, and not where the machine is."""

    inch: bool
    plane: PlaneName
    feed_mode: int
    feed: float
    speed: float
    turning: Literal[-1, 0, 1]
    surface_limit: float
    mist: bool
    flood: bool
    switches: tuple[tuple[int, bool], ...]  # M code, on
    system: int
    tool_offset: tuple[float, ...]  # in the saved unit
    incremental: bool
    arc_absolute: bool
    retract_to_start: bool
    path_control: tuple[PathModeName, float, float]
    compensated: bool
    axis_offset: bool  # whether that of G92 holds


@dataclass(slots=True)
class Controller:
    """State of the controller."""

    setup: Setup
    machine_inch: bool  # unit of the machine: of tool table and numbered variables
    out: list[Command]  # where commands go
    inch: bool = False
    motion: int = 800
    plane: PlaneName = "XY"
    incremental: bool = False
    arc_absolute: bool = False
    feed_mode: int = 94
    feed: float = 0.0
    feedless: bool = False  # a motion without a feed was a fault
    path_mode: PathModeName = "continuous"
    path_mode_said: bool = False  # by a word of the program
    tolerance: float = 0.0
    naive_tolerance: float = 0.0
    retract_to_start: bool = False  # G98
    at: list[float] = field(default_factory=lambda: list(ZEROS))
    offsets: Offsets = field(default_factory=Offsets)
    spindle: Spindle = field(default_factory=Spindle)
    switches: Switches = field(default_factory=Switches)
    cycle: Cycle = field(default_factory=Cycle)
    tool: Tool = NO_TOOL
    slot: int = 0  # tool that the spindle's place in the tool table stands for: the first one until another is put in
    selected: int = 0
    tools: dict[int, Tool] = field(default_factory=dict)
    numbers: dict[int, float] = field(default_factory=dict)  # numbered variables that were assigned
    saves: list[Saved | None] = field(default_factory=lambda: [None])  # by M70 and M73, of each level of calls
    restores: list[bool] = field(default_factory=lambda: [False])  # whether a level restores at its end (M73)
    compensation: Compensation | None = None
    no_arc_yet: bool = False  # cutter compensation has just ended: the next motion must be straight
    spline: list[tuple[float, float, float]] | None = None  # G5.2: x, y, weight so far
    spline_order: int = 3
    spline_tangent: tuple[float, float] | None = None  # end of the last G5: what a smooth one follows
    line: int = 0  # of the main program; while a file beside it runs, that of its call
    file_line: int = 0  # of the file that is run
    number: str = ""
    notices: dict[str, int] = field(default_factory=dict)  # words: first line they hold for
    stores_cycles: bool = False  # a cycle repeated 0 times keeps its words for the blocks that follow (Fanuc)
    steps: int = 0  # that a line has taken beyond itself: runs again, repeats, pecks, turns

    @property
    def rotary(self) -> Triple:
        """A B C."""
        return self.at[3], self.at[4], self.at[5]

    @property
    def extra(self) -> Triple:
        """U V W."""
        return self.at[6], self.at[7], self.at[8]

    def notice(self, words: str) -> None:
        """Something that was assumed or left out; said once."""
        self.notices.setdefault(words, self.line)

    def spend(self, steps: float, what: str, place: int) -> None:
        """Count work that a program asks for without writing it out.

        Raises
        ------
        BlockFault
            More than the limit of steps: nobody means that, and nobody would see the end of it.
        """
        limit = self.setup.step_limit
        if self.steps + steps > limit:
            raise BlockFault(f"{what}: more than {limit} steps that are not written out; the program does not come to "
                             "an end in reasonable time (if that is meant, raise program.step_limit, or "
                             "--step-limit)", place)  # fmt: skip
        self.steps += math.ceil(steps)

    def unit(self) -> float:
        """A program unit of length [m]."""
        return INCH if self.inch else MILLIMETRE

    def machine_units(self) -> float:
        """How many units of the machine a program unit is."""
        if self.inch == self.machine_inch:
            return 1.0
        return INCH / MILLIMETRE if self.inch else MILLIMETRE / INCH


def turned(x: float, y: float, degrees: float) -> tuple[float, float]:
    """A vector turned counterclockwise."""
    if degrees == 0.0:
        return x, y
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return c * x - s * y, s * x + c * y


def to_machine(offsets: Offsets, at: Sequence[float]) -> list[float]:
    """Machine coordinates of a place in work coordinates."""
    moved = [a + b for a, b in zip(at, offsets.axis, strict=True)]
    moved[0], moved[1] = turned(moved[0], moved[1], offsets.rotation)
    return [a + b + c for a, b, c in zip(moved, offsets.origin, offsets.tool, strict=True)]


def from_machine(offsets: Offsets, at: Sequence[float]) -> list[float]:
    """Work coordinates of a place in machine coordinates."""
    moved = [a - b - c for a, b, c in zip(at, offsets.origin, offsets.tool, strict=True)]
    moved[0], moved[1] = turned(moved[0], moved[1], -offsets.rotation)
    return [a - b for a, b in zip(moved, offsets.axis, strict=True)]


def scaled(values: Sequence[float], factor: float) -> list[float]:
    """Values of the nine axes, lengths times a factor."""
    return [value * factor if i in LINEAR else value for i, value in enumerate(values)]
