"""Canonical commands as text, one call a line, as the reference interpreter for RS274/NGC prints them.

Numbers are in the program's current units and work coordinates, offsets appear as calls of their own.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from cutwise.programs import canon

_NUMBER_WIDTH = 6
_ZERO = "0.0000"


def _f(value: float) -> str:
    text = f"{value:.4f}"
    return _ZERO if text == "-0.0000" else text


def _list(values: Sequence[float]) -> str:
    return ", ".join(map(_f, values))


def _straight(name: str) -> Callable[[Any], str]:
    def text(command: Any) -> str:
        return f"{name}({_list((command.x, command.y, command.z, *command.rotary))})"

    return text


def _tap_stroke(command: canon.TapStroke) -> str:
    """In G18 and G19 the reference names the axes of this cycle out of order; the moves made from it here are right."""
    x, y, z = command.x, command.y, command.z
    named = {"XY": (x, y, z), "XZ": (y, z, x), "YZ": (z, x, y)}[command.plane]
    return f"STRAIGHT_FEED({_list((*named, *command.rotary))})"


def _arc(command: canon.Arc) -> str:
    plane = _list((command.first, command.second, command.first_centre, command.second_centre))
    return f"ARC_FEED({plane}, {command.turns}, {_list((command.axial, *command.rotary))})"


def _tool_length(command: canon.ToolLength) -> str:
    groups = (" ".join(map(_f, command.offset[i : i + 3])) for i in (0, 3, 6))
    return f"USE_TOOL_LENGTH_OFFSET({', '.join(groups)})"


def _path_control(command: canon.PathControl) -> str:
    tolerance = f", {command.tolerance:.6f}" if command.mode == "continuous" else ""
    return f"SET_MOTION_CONTROL_MODE(CANON_{command.mode.upper()}{tolerance})"


def _sync(command: canon.SpindleSync) -> str:
    return f"START_SPEED_FEED_SYNC({command.pitch:.6f},0)" if command.pitch else "STOP_SPEED_FEED_SYNCH()"


def _turn(command: canon.SpindleTurn) -> str:
    return {1: "START_SPINDLE_CLOCKWISE", -1: "START_SPINDLE_COUNTERCLOCKWISE", 0: "STOP_SPINDLE_TURNING"}[
        command.turning
    ] + "(0)"


_STOPS = {"stop": "PROGRAM_STOP", "optional": "OPTIONAL_PROGRAM_STOP", "shuttle": "PALLET_SHUTTLE",
          "end": "PROGRAM_END"}  # fmt: skip

_TEXT: dict[type[Any], Callable[[Any], str]] = {
    canon.Traverse: _straight("STRAIGHT_TRAVERSE"),
    canon.Feed: _straight("STRAIGHT_FEED"),
    canon.Probe: _straight("STRAIGHT_PROBE"),
    canon.TapStroke: _tap_stroke,
    canon.Arc: _arc,
    canon.Spline: lambda c: f"NURBS_G5_FEED({len(c.points)}, ...)",
    canon.RigidTap: lambda c: f"RIGID_TAP({_list((c.x, c.y, c.z))})",
    canon.SpindleSync: _sync,
    canon.Dwell: lambda c: f"DWELL({_f(c.seconds)})",
    canon.LengthUnits: lambda c: f"USE_LENGTH_UNITS(CANON_UNITS_{'INCHES' if c.inch else 'MM'})",
    canon.Plane: lambda c: f"SELECT_PLANE(CANON_PLANE_{c.plane})",
    canon.FeedRate: lambda c: f"SET_FEED_RATE({_f(c.rate)})",
    canon.FeedMode: lambda c: f"SET_FEED_MODE(0, {int(c.per_revolution)})",
    canon.PathControl: _path_control,
    canon.NaiveTolerance: lambda c: f"SET_NAIVECAM_TOLERANCE({_f(c.tolerance)})",
    canon.WorkOffset: lambda c: f"SET_G5X_OFFSET({c.system}, {_list(c.offset[:6])})",
    canon.AxisOffset: lambda c: f"SET_G92_OFFSET({_list(c.offset[:6])})",
    canon.Rotation: lambda c: f"SET_XY_ROTATION({_f(c.angle)})",
    canon.ToolLength: _tool_length,
    canon.SelectTool: lambda c: f"SELECT_TOOL({c.tool})",
    canon.ChangeTool: lambda c: f"CHANGE_TOOL_NUMBER({c.tool})" if c.named else "CHANGE_TOOL()",
    canon.SpindleMode: lambda c: f"SET_SPINDLE_MODE(0 {_f(c.limit)})",
    canon.SpindleSpeed: lambda c: f"SET_SPINDLE_SPEED(0, {_f(c.speed)})",
    canon.SpindleTurn: _turn,
    canon.Coolant: lambda c: f"{c.kind.upper()}_{'ON' if c.on else 'OFF'}()",
    canon.Stop: lambda c: f"{_STOPS[c.kind]}()",
    canon.Comment: lambda c: f'COMMENT("{c.text}")',
    canon.Message: lambda c: f'MESSAGE("{c.text}")',
    canon.Signal: lambda c: f"{c.name}({c.arguments})",
}

BEFORE = (
    "USE_LENGTH_UNITS(CANON_UNITS_MM)",
    "SET_G5X_OFFSET(1, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)",
    "SET_G92_OFFSET(0.0000, 0.0000, 0.0000, 0.0000, 0.0000, 0.0000)",
    "SET_XY_ROTATION(0.0000)",
    "SET_FEED_REFERENCE(CANON_XYZ)",
    "ON_RESET()",
)
"""What is said of the controller before a program runs."""


def call(command: canon.Command) -> str:
    """One command as a call; what PRINT says as it is."""
    if isinstance(command, canon.Printed):
        return f'LOG("{command.text}")' if command.logged else command.text
    return _TEXT[type(command)](command)


def lines(commands: Iterable[canon.Command]) -> Iterator[str]:
    """Numbered lines of a whole program, with what is said before and after it."""
    count, ended = 0, False
    for count, words in enumerate(BEFORE, start=1):
        yield _line(count, "", words)
    for command in commands:
        if isinstance(command, canon.DrawnOut):
            continue
        words = call(command)
        if isinstance(command, canon.Printed) and not command.logged:
            yield words
            continue
        count += 1
        ended = isinstance(command, canon.Stop) and command.kind == "end"
        yield _line(count, command.number, words)
    for words in (() if ended else ("FINISH()",)) + ("ON_RESET()", "ON_RESET()"):
        count += 1
        yield _line(count, "", words)


def _line(count: int, number: str, words: str) -> str:
    block = f"N{number}".ljust(_NUMBER_WIDTH) if number else "N....."
    return f"{count:5d} {block} {words}"
