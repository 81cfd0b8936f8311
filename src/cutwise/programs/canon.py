"""Canonical machining commands: what a program asks of the machine, one thing at a time, in its own units.

An interpreter turns blocks into these; :mod:`.canonical_text` prints them, :mod:`.moves` turns them into moves in SI.
Lengths and feeds are in the program's current units (:class:`LengthUnits`), positions in its current work coordinates
(:class:`WorkOffset`, :class:`AxisOffset`, :class:`Rotation`, :class:`ToolLength` say where those are), angles in degrees.
Each command ends with the ``line`` of its program and the ``number`` (N word) of its block, as written.
"""

from typing import Literal, NamedTuple

Triple = tuple[float, float, float]
Nine = tuple[float, ...]  # X Y Z A B C U V W

NO_TURN: Triple = (0.0, 0.0, 0.0)


class Traverse(NamedTuple):
    """Rapid along a straight line."""

    x: float
    y: float
    z: float
    rotary: Triple  # A B C
    extra: Triple  # U V W
    line: int
    number: str


class Feed(NamedTuple):
    """Straight line at the feed rate."""

    x: float
    y: float
    z: float
    rotary: Triple  # A B C
    extra: Triple  # U V W
    line: int
    number: str


class Arc(NamedTuple):
    """Arc or helix in the selected plane: first and second axis are X Y (G17), Z X (G18) or Y Z (G19)."""

    first: float  # end
    second: float  # end
    first_centre: float
    second_centre: float
    turns: int  # positive counterclockwise; 1 and -1: not more than a full circle
    axial: float  # end along the axis of the plane
    rotary: Triple
    extra: Triple
    line: int
    number: str


class Spline(NamedTuple):
    """Non-uniform rational B-spline in the XY plane; no ``order``: the control points of a cubic or quadratic G5."""

    points: tuple[tuple[float, float], ...]  # control points, the start included
    weights: tuple[float, ...]
    order: int  # degree + 1
    line: int
    number: str


class Probe(NamedTuple):
    """Straight probing move (G38): recorded, not simulated."""

    x: float
    y: float
    z: float
    rotary: Triple
    extra: Triple
    line: int
    number: str


class RigidTap(NamedTuple):
    """Down to a point and back again, in step with the spindle (G33.1)."""

    x: float
    y: float
    z: float
    line: int
    number: str


class TapStroke(NamedTuple):
    """Stroke of a tapping cycle (G74, G84), in step with the spindle."""

    x: float
    y: float
    z: float
    plane: Literal["XY", "XZ", "YZ"]
    rotary: Triple
    extra: Triple
    line: int
    number: str


class DrawnOut(NamedTuple):
    """The operator has drawn the tool out of the hole, to here (G88); no call of its own."""

    x: float
    y: float
    z: float
    line: int
    number: str


class SpindleSync(NamedTuple):
    """Feed in step with the spindle from here on (G33), or no longer."""

    pitch: float  # length per revolution; 0: no longer in step
    line: int
    number: str


class Dwell(NamedTuple):
    """Stand still."""

    seconds: float
    line: int
    number: str


class LengthUnits(NamedTuple):
    """Unit of lengths from here on (G20, G21)."""

    inch: bool
    line: int
    number: str


class Plane(NamedTuple):
    """Plane of arcs (G17, G18, G19)."""

    plane: Literal["XY", "XZ", "YZ"]
    line: int
    number: str


class FeedRate(NamedTuple):
    """Feed: length per minute, or length per revolution under :class:`FeedMode`."""

    rate: float
    line: int
    number: str


class FeedMode(NamedTuple):
    """Whether feeds are per revolution (G95) or per minute."""

    per_revolution: bool
    line: int
    number: str


class PathControl(NamedTuple):
    """How blocks are joined (G61, G61.1, G64 P)."""

    mode: Literal["exact_path", "exact_stop", "continuous"]
    tolerance: float  # of continuous; 0: none given
    line: int
    number: str
    said: bool = True  # by the program; a cycle gives back what was there before it


class NaiveTolerance(NamedTuple):
    """Within which collinear blocks are merged (G64 Q)."""

    tolerance: float
    line: int
    number: str


class WorkOffset(NamedTuple):
    """Origin of the work coordinate system in machine coordinates (G54 to G59.3, G10)."""

    system: int  # 1 to 9
    offset: Nine
    line: int
    number: str


class AxisOffset(NamedTuple):
    """Offset on top of the work coordinate system (G92, G52)."""

    offset: Nine
    line: int
    number: str


class Rotation(NamedTuple):
    """Rotation of the work coordinate system about Z [degree]."""

    angle: float
    line: int
    number: str


class ToolLength(NamedTuple):
    """Tool offset in force (G43, G49)."""

    offset: Nine
    line: int
    number: str


class SelectTool(NamedTuple):
    """Make a tool ready (T)."""

    tool: int
    line: int
    number: str


class ChangeTool(NamedTuple):
    """Put the selected tool into the spindle (M6), or say that it is there (``named``, M61)."""

    tool: int
    named: bool
    line: int
    number: str


class SpindleMode(NamedTuple):
    """Revolutions per minute (G97: limit 0), or constant surface speed up to a limit (G96)."""

    limit: float
    line: int
    number: str


class SpindleSpeed(NamedTuple):
    """Revolutions per minute, or surface speed (S)."""

    speed: float
    line: int
    number: str


class SpindleTurn(NamedTuple):
    """Start or stop the spindle (M3, M4, M5)."""

    turning: Literal[-1, 0, 1]  # 1 clockwise
    line: int
    number: str


class Coolant(NamedTuple):
    """Mist or flood (M7, M8, M9)."""

    kind: Literal["mist", "flood"]
    on: bool
    line: int
    number: str


class Stop(NamedTuple):
    """Program stop (M0), optional stop (M1), pallet shuttle (M30, M60), or end (M2, M30)."""

    kind: Literal["stop", "optional", "shuttle", "end"]
    line: int
    number: str


class Comment(NamedTuple):
    """A comment."""

    text: str
    line: int
    number: str


class Message(NamedTuple):
    """Words to the operator: MSG and DEBUG."""

    text: str
    line: int
    number: str


class Printed(NamedTuple):
    """Words to the console (PRINT) or into a log (LOG)."""

    text: str
    logged: bool
    line: int
    number: str


class Signal(NamedTuple):
    """Anything else that is asked of the machine and leaves the path as it is: switches, outputs, tool table entries."""

    name: str
    arguments: str
    line: int
    number: str


Command = (
    Traverse | Feed | Arc | Spline | Probe | RigidTap | TapStroke | DrawnOut | SpindleSync | Dwell | LengthUnits | Plane
    | FeedRate | FeedMode | PathControl | NaiveTolerance | WorkOffset | AxisOffset | Rotation | ToolLength | SelectTool
    | ChangeTool | SpindleMode | SpindleSpeed | SpindleTurn | Coolant | Stop | Comment | Message | Printed | Signal
)  # fmt: skip
