"""Canonical commands into moves of the tool tip in SI, in the work coordinates of the program's first motion.

Work offsets, axis offsets, rotations and units that change on the way are worked in, so that all moves stand in one
frame. Tool lengths move nothing: positions are those of the controlled point, and after a change of tool length the next
move begins where the last one ended.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from typing import Any, Literal, NamedTuple

from cutwise import units
from cutwise.maths.splines import pieces
from cutwise.programs import canon
from cutwise.programs.arcs import sweep
from cutwise.programs.controller import INCH, MILLIMETRE, PLANES, turned

Point = tuple[float, float, float]

SPLINE_TOLERANCE = 1e-6  # [m] between a spline and the lines that stand for it
_LEAST_RADIUS = 1e-9  # [m] of an arc
_ORIGIN: Point = (0.0, 0.0, 0.0)
_Z: Point = (0.0, 0.0, 1.0)
_MODES = {"exact_path": "exact_path", "exact_stop": "exact_stop", "continuous": "blend"}

Kind = Literal["rapid", "feed", "arc", "dwell", "probe"]


class Move(NamedTuple):
    """One straight line, arc or helix of the tool, or a dwell."""

    kind: Kind
    start: Point  # [m]
    end: Point  # [m]
    centre: Point  # [m] of an arc
    axis: Point  # of an arc, unit vector
    sweep: float  # of an arc about its axis [rad], right-handed
    feed: float  # [m/s]; infinite for a rapid move; where rotary axes move alone [rad/s]
    spindle: float  # [rad/s], signed: positive clockwise (M3), 0 stopped
    mode: str  # exact_path, exact_stop or blend
    tolerance: float  # of a blend [m]; infinite where none is given (G64 without P)
    dwell: float  # [s]
    line: int  # of the program
    rotary_start: Point = _ORIGIN  # A B C [rad]
    rotary_end: Point = _ORIGIN  # A B C [rad]
    tool: int = 0  # in the spindle; 0: none was called
    coolant: str = ""  # mist, flood, or both: "mist flood"


class Frame(NamedTuple):
    """Work coordinates in the machine: turned about z, then shifted."""

    angle: float = 0.0  # [degree]
    shift: Point = _ORIGIN  # [m]

    def placed(self, point: Point) -> Point:
        """Machine coordinates of a point in work coordinates."""
        x, y = turned(point[0], point[1], self.angle)
        return x + self.shift[0], y + self.shift[1], point[2] + self.shift[2]

    def seen(self, point: Point) -> Point:
        """Work coordinates of a point in machine coordinates."""
        x, y = turned(point[0] - self.shift[0], point[1] - self.shift[1], -self.angle)
        return x, y, point[2] - self.shift[2]


class _Deriving:
    """What has been commanded so far, in SI."""

    def __init__(self, start: Point, tool: int) -> None:
        self.unit = MILLIMETRE
        self.origin, self.axis_offset, self.angle = _ORIGIN, _ORIGIN, 0.0
        self.frame = Frame()
        self.base: Frame | None = None  # frame of the first motion: that of all moves
        self.same = True  # the frame is the base
        self.at = start  # in the machine before the first motion, then in the base
        self.rotary = _ORIGIN
        self.rotary_words = _ORIGIN  # as commanded [degree]
        self.rate, self.rate_unit, self.rate_line = 0.0, MILLIMETRE, 0
        self.per_revolution = False
        self.pitch = 0.0
        self.speed, self.turning, self.surface = 0.0, 0, False
        self.mode, self.tolerance = "exact_path", 0.0
        self.plane = "XY"
        self.tool = tool
        self.coolant = ""
        self.feed = self.spindle = 0.0

    # state

    def units(self, command: canon.LengthUnits) -> None:
        self.unit = INCH if command.inch else MILLIMETRE
        if self.rate_line == command.line:  # F in the block of the unit word is meant in the new unit
            self.rate_unit = self.unit
            self.settle()

    def work_offset(self, command: canon.WorkOffset) -> None:
        self.origin = self._scaled(command.offset)
        self._new_frame()

    def axis(self, command: canon.AxisOffset) -> None:
        self.axis_offset = self._scaled(command.offset)
        self._new_frame()

    def rotation(self, command: canon.Rotation) -> None:
        self.angle = command.angle
        self._new_frame()

    def _scaled(self, offset: canon.Nine) -> Point:
        return offset[0] * self.unit, offset[1] * self.unit, offset[2] * self.unit

    def _new_frame(self) -> None:
        x, y = turned(self.axis_offset[0], self.axis_offset[1], self.angle)
        o = self.origin
        self.frame = Frame(self.angle, (o[0] + x, o[1] + y, o[2] + self.axis_offset[2]))
        self.same = self.base is None or self.base == self.frame

    def feed_rate(self, command: canon.FeedRate) -> None:
        self.rate, self.rate_unit, self.rate_line = command.rate, self.unit, command.line
        self.settle()

    def feed_mode(self, command: canon.FeedMode) -> None:
        self.per_revolution = command.per_revolution
        self.settle()

    def sync(self, command: canon.SpindleSync) -> None:
        self.pitch = command.pitch * self.unit
        self.settle()

    def spindle_speed(self, command: canon.SpindleSpeed) -> None:
        self.speed = command.speed * units.factor("rpm", "angular_speed")
        self.settle()

    def spindle_turn(self, command: canon.SpindleTurn) -> None:
        self.turning = command.turning
        self.settle()

    def spindle_mode(self, command: canon.SpindleMode) -> None:
        self.surface = command.limit > 0.0
        self.settle()

    def settle(self) -> None:
        """Feed and spindle speed in force."""
        self.spindle = 0.0 if self.surface else self.turning * self.speed
        per_second = abs(self.speed) / (2.0 * math.pi)
        if self.pitch:
            self.feed = abs(self.pitch) * per_second
        else:
            self.feed = self.rate * self.rate_unit * (per_second if self.per_revolution else 1.0 / 60.0)

    def path_control(self, command: canon.PathControl) -> None:
        self.mode, self.tolerance = _MODES[command.mode] if command.said else "exact_path", 0.0
        if self.mode == "blend":  # without a tolerance the feed is kept
            self.tolerance = command.tolerance * self.unit if command.tolerance > 0.0 else math.inf

    def select_plane(self, command: canon.Plane) -> None:
        self.plane = command.plane

    def change_tool(self, command: canon.ChangeTool) -> None:
        self.tool = command.tool

    def cool(self, command: canon.Coolant) -> None:
        kept = [kind for kind in self.coolant.split() if kind != command.kind]
        self.coolant = " ".join(sorted([*kept, command.kind] if command.on else kept, reverse=True))

    # moves

    def place(self, x: float, y: float, z: float) -> Point:
        """A point in program units as a point of the moves [m]."""
        unit = self.unit
        if self.same and self.base is not None:
            return x * unit, y * unit, z * unit
        return self._fixed().seen(self.frame.placed((x * unit, y * unit, z * unit)))

    def _fixed(self) -> Frame:
        """The frame of all moves: that of the first motion."""
        if self.base is None:
            self.base = self.frame
            self.at = self.base.seen(self.at)
        return self.base

    def straight(self, kind: Kind, end: Point, rotary: canon.Triple, line: int, feed: float) -> Iterator[Move]:
        """A line, unless it leads nowhere."""
        to = self.rotary if rotary == self.rotary_words else self._turned(rotary)
        if end != self.at:
            yield self._move(kind, end, to, line, feed)
        elif to != self.rotary:
            yield self._move(kind, end, to, line, feed if math.isinf(feed) else math.radians(self.rate) / 60.0)

    def _turned(self, rotary: canon.Triple) -> Point:
        self.rotary_words = rotary
        return math.radians(rotary[0]), math.radians(rotary[1]), math.radians(rotary[2])

    def _move(
        self, kind: Kind, end: Point, rotary: Point, line: int, feed: float, centre: Point = _ORIGIN,
        axis: Point = _Z, angle: float = 0.0, seconds: float = 0.0,
    ) -> Move:  # fmt: skip
        move = Move(
            kind, self.at, end, centre, axis, angle, feed, self.spindle, self.mode, self.tolerance, seconds, line,
            self.rotary, rotary, self.tool, self.coolant,
        )  # fmt: skip
        self.at, self.rotary = end, rotary
        return move

    def traverse(self, command: canon.Traverse) -> Iterator[Move]:
        x, y, z, rotary, _, line, _ = command
        return self.straight("rapid", self.place(x, y, z), rotary, line, math.inf)

    def fed(self, command: canon.Feed) -> Iterator[Move]:
        x, y, z, rotary, _, line, _ = command
        return self.straight("feed", self.place(x, y, z), rotary, line, self.feed)

    def tapped(self, command: canon.TapStroke) -> Iterator[Move]:
        end = self.place(command.x, command.y, command.z)
        return self.straight("feed", end, command.rotary, command.line, self.feed)

    def probed(self, command: canon.Probe) -> Iterator[Move]:
        end = self.place(command.x, command.y, command.z)
        return self.straight("probe", end, command.rotary, command.line, self.feed)

    def drawn_out(self, command: canon.DrawnOut) -> Iterator[Move]:
        end = self.place(command.x, command.y, command.z)
        return self.straight("rapid", end, self.rotary_words, command.line, math.inf)

    def rigid_tap(self, command: canon.RigidTap) -> Iterator[Move]:
        end = self.place(command.x, command.y, command.z)
        start = self.at
        yield from self.straight("feed", end, self.rotary_words, command.line, self.feed)
        yield from self.straight("feed", start, self.rotary_words, command.line, self.feed)

    def dwell(self, command: canon.Dwell) -> Iterator[Move]:
        self._fixed()
        yield self._move("dwell", self.at, self.rotary, command.line, self.feed, seconds=command.seconds)

    def arc(self, command: canon.Arc) -> Iterator[Move]:
        u, v, w = PLANES[self.plane]
        end_raw, centre_raw = [0.0] * 3, [0.0] * 3
        end_raw[u], end_raw[v], end_raw[w] = command.first, command.second, command.axial
        end = self.place(*end_raw)
        centre_raw[u], centre_raw[v] = command.first_centre, command.second_centre
        base = self._fixed()
        seen = self.at if self.same else self.frame.seen(base.placed(self.at))  # start in the coordinates of the arc
        centre_raw[w] = seen[w] / self.unit
        centre = self.place(*centre_raw)
        axis = [0.0, 0.0, 0.0]
        axis[w] = 1.0
        if not self.same:
            axis[0], axis[1] = turned(axis[0], axis[1], self.frame.angle - base.angle)
        c, e = [value * self.unit for value in centre_raw], [value * self.unit for value in end_raw]
        angle = sweep((seen[u] - c[u], seen[v] - c[v]), (e[u] - c[u], e[v] - c[v]), command.turns)
        if math.hypot(seen[u] - c[u], seen[v] - c[v]) < _LEAST_RADIUS:  # of a corner that the tool just fits
            yield from self.straight("feed", end, command.rotary, command.line, self.feed)
            return
        to = self._turned(command.rotary)
        yield self._move("arc", end, to, command.line, self.feed, centre=centre, axis=(axis[0], axis[1], axis[2]),
                         angle=angle)  # fmt: skip

    def spline(self, command: canon.Spline) -> Iterator[Move]:
        z = self.frame.seen(self._fixed().placed(self.at))[2] / self.unit
        for piece in pieces(command.points, command.weights, command.order, SPLINE_TOLERANCE / self.unit):
            end = self.place(*piece.end, z)
            if piece.sweep:
                yield self._move("arc", end, self.rotary, command.line, self.feed, centre=self.place(*piece.centre, z),
                                 angle=piece.sweep)  # fmt: skip
            else:
                yield from self.straight("feed", end, self.rotary_words, command.line, self.feed)


_MAKES: dict[type[Any], Callable[[_Deriving, Any], Iterator[Move]]] = {
    canon.Traverse: _Deriving.traverse, canon.Feed: _Deriving.fed, canon.Arc: _Deriving.arc,
    canon.TapStroke: _Deriving.tapped, canon.Probe: _Deriving.probed, canon.RigidTap: _Deriving.rigid_tap,
    canon.DrawnOut: _Deriving.drawn_out,
    canon.Dwell: _Deriving.dwell, canon.Spline: _Deriving.spline,
}  # fmt: skip
_SETS: dict[type[Any], Callable[[_Deriving, Any], None]] = {
    canon.LengthUnits: _Deriving.units, canon.WorkOffset: _Deriving.work_offset, canon.AxisOffset: _Deriving.axis,
    canon.Rotation: _Deriving.rotation, canon.FeedRate: _Deriving.feed_rate, canon.FeedMode: _Deriving.feed_mode,
    canon.SpindleSync: _Deriving.sync, canon.SpindleSpeed: _Deriving.spindle_speed,
    canon.SpindleTurn: _Deriving.spindle_turn, canon.SpindleMode: _Deriving.spindle_mode,
    canon.PathControl: _Deriving.path_control, canon.Plane: _Deriving.select_plane,
    canon.ChangeTool: _Deriving.change_tool, canon.Coolant: _Deriving.cool,
}  # fmt: skip


def moves(commands: Iterable[canon.Command], *, start: Point = _ORIGIN, tool: int = 0) -> Iterator[Move]:
    """The moves that canonical commands amount to, one after the other, each from where the last one ended.

    Parameters
    ----------
    commands : iterable of Command
        As an interpreter gives them.
    start : tuple
        Where the tool tip stands at first, in machine coordinates [m].
    tool : int
        Number of the tool in the spindle at first.
    """
    deriving = _Deriving(start, tool)
    for command in commands:
        kind = type(command)
        if kind in _MAKES:
            yield from _MAKES[kind](deriving, command)
        elif kind in _SETS:
            _SETS[kind](deriving, command)
