"""What a program amounts to: units, tools, feeds, lengths, extents and time, gathered while it runs."""

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from cutwise import units
from cutwise.programs import canon
from cutwise.programs.interpreter import Reading, default_tool, default_tool_notice
from cutwise.programs.moves import Move, Point, moves
from cutwise.programs.setup import Setup

MOST_MESSAGES = 1000  # that are kept


class Box(NamedTuple):
    """Least and largest coordinates [m] of some moves."""

    low: Point
    high: Point


class Said(NamedTuple):
    """Words of a program to its operator."""

    line: int
    text: str


class Summary(NamedTuple):
    """What a program amounts to."""

    language: Literal["G-code", "APT"]
    units: tuple[str, ...]  # mm, inch, in the order in which they are used
    blocks: int
    moves: dict[str, int]  # how many of each kind
    tools: tuple[int, ...]  # in the order in which they come into the spindle
    default_tool: bool  # whether the program called none
    spindle_speeds: tuple[float, ...]  # [rad/s], rising, negative to the left
    feeds: tuple[float, ...]  # [m/s] of feed moves, rising
    boxes: dict[str, Box]  # of each kind of move, arcs with feed moves
    rotary: bool  # whether rotary axes move
    rapid_length: float  # [m]
    feed_length: float  # [m]
    feed_time: float  # [s], lengths at their feeds
    dwell_time: float  # [s]
    stops: int  # M0, M1
    messages: tuple[Said, ...]
    notices: tuple[str, ...]

    @property
    def cycle_time(self) -> float:
        """Feed moves at their feeds, and dwells [s]; rapid moves and accelerations left out."""
        return self.feed_time + self.dwell_time


def length(move: Move) -> float:
    """Length of a move of the tool tip [m]."""
    if move.kind != "arc":
        return math.dist(move.start, move.end)
    radius, rise = _radius_and_rise(move)
    return math.hypot(radius * move.sweep, rise)


def _radius_and_rise(move: Move) -> tuple[float, float]:
    axis = move.axis
    rise = sum((b - a) * c for a, b, c in zip(move.start, move.end, axis, strict=True))
    out = [a - b for a, b in zip(move.start, move.centre, strict=True)]
    along = sum(a * b for a, b in zip(out, axis, strict=True))
    return math.sqrt(max(0.0, sum(a * a for a in out) - along * along)), rise


def arc_points(move: Move, angles: Iterable[float]) -> Iterator[Point]:
    """Points of an arc or helix at angles from its start [rad], in the sense of its sweep."""
    axis, centre = move.axis, move.centre
    out = [a - b for a, b in zip(move.start, centre, strict=True)]
    along = sum(a * b for a, b in zip(out, axis, strict=True))
    first = [a - along * b for a, b in zip(out, axis, strict=True)]
    side = [
        axis[1] * first[2] - axis[2] * first[1], axis[2] * first[0] - axis[0] * first[2],
        axis[0] * first[1] - axis[1] * first[0],
    ]  # fmt: skip
    _, rise = _radius_and_rise(move)
    for angle in angles:
        c, s, up = math.cos(angle), math.sin(angle), along + rise * angle / move.sweep
        x, y, z = (centre[i] + c * first[i] + s * side[i] + up * axis[i] for i in range(3))
        yield x, y, z


def extremes(move: Move) -> Iterator[Point]:
    """Points of a move between which all of it lies, for boxes along the axes."""
    yield move.start
    yield move.end
    if move.kind != "arc":
        return
    first, quarter = arc_points(move, (0.0, 0.5 * math.pi))
    *_, opposite = arc_points(move, (math.pi,))
    for i in range(3):
        a, b = 0.5 * (first[i] - opposite[i]), quarter[i] - 0.5 * (first[i] + opposite[i])
        if math.hypot(a, b) < 1e-12:
            continue
        turn = math.atan2(b, a)
        low, high = min(0.0, move.sweep), max(0.0, move.sweep)
        k = math.ceil((low - turn) / math.pi)
        angles = []
        while turn + k * math.pi <= high:
            angles.append(turn + k * math.pi)
            k += 1
        yield from arc_points(move, angles)


@dataclass
class _Gathering:
    """What has been seen so far."""

    units: dict[str, None] = field(default_factory=dict)
    tools: dict[int, None] = field(default_factory=dict)
    speeds: dict[float, None] = field(default_factory=dict)
    feeds: dict[float, None] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    low: dict[str, list[float]] = field(default_factory=dict)
    high: dict[str, list[float]] = field(default_factory=dict)
    messages: list[Said] = field(default_factory=list)
    rotary: bool = False
    rapid_length: float = 0.0
    feed_length: float = 0.0
    feed_time: float = 0.0
    dwell_time: float = 0.0
    stops: int = 0

    def watched(self, commands: Iterable[canon.Command]) -> Iterator[canon.Command]:
        """The commands, looked at as they pass."""
        for command in commands:
            look = _LOOKS.get(type(command))
            if look is not None:
                look(self, command)
            yield command

    def unit(self, command: canon.LengthUnits) -> None:
        self.units.setdefault("inch" if command.inch else "mm")

    def tool(self, command: canon.ChangeTool) -> None:
        self.tools.setdefault(command.tool)

    def said(self, command: canon.Message | canon.Printed) -> None:
        if len(self.messages) < MOST_MESSAGES:
            self.messages.append(Said(command.line, command.text.strip()))

    def stop(self, command: canon.Stop) -> None:
        self.stops += command.kind in ("stop", "optional")

    def add(self, move: Move) -> None:
        """Account for a move."""
        kind = move.kind
        self.counts[kind] = self.counts.get(kind, 0) + 1
        if kind == "dwell":
            self.dwell_time += move.dwell
            return
        way = length(move)
        if kind == "rapid":
            self.rapid_length += way
        elif move.feed > 0.0:
            self._feed(move, way)
        if move.rotary_start != move.rotary_end:
            self.rotary = True
        self._extend("feed" if kind == "arc" else kind, extremes(move))

    def _feed(self, move: Move, way: float) -> None:
        self.feed_length += way
        if way > 0.0:
            self.feed_time += way / move.feed
            self.feeds.setdefault(move.feed)
        else:
            turns = zip(move.rotary_start, move.rotary_end, strict=True)
            self.feed_time += max(abs(b - a) for a, b in turns) / move.feed
        if move.spindle:
            self.speeds.setdefault(move.spindle)

    def _extend(self, kind: str, points: Iterable[Point]) -> None:
        low = self.low.setdefault(kind, [math.inf] * 3)
        high = self.high.setdefault(kind, [-math.inf] * 3)
        for point in points:
            for i in range(3):
                value = point[i]
                if value < low[i]:
                    low[i] = value
                if value > high[i]:
                    high[i] = value


_LOOKS: dict[type[Any], Callable[[_Gathering, Any], None]] = {
    canon.LengthUnits: _Gathering.unit, canon.ChangeTool: _Gathering.tool, canon.Message: _Gathering.said,
    canon.Printed: _Gathering.said, canon.Stop: _Gathering.stop,
}  # fmt: skip


def summarise(run: Reading, setup: Setup, look: Callable[[Move], None] | None = None) -> Summary:
    """Run a program and say what it amounts to, without keeping its moves.

    Parameters
    ----------
    run : Reading
        A run through a program, not yet begun.
    setup : Setup
        That of the run.
    look : callable, optional
        Sees every move as well, to draw it for instance.

    Raises
    ------
    ScenarioFault
        With everything in the program that cannot be run.
    """
    seen = _Gathering()
    for move in moves(seen.watched(run.commands()), start=run.start, tool=default_tool(setup)):
        seen.add(move)
        if look is not None:
            look(move)
    notices = run.notices()
    if not seen.units:
        seen.unit(canon.LengthUnits(False, 0, ""))
        notices.append("no unit word (G20, G21): lengths are taken as mm")
    if not seen.tools:
        notices.append(default_tool_notice(setup))
    if setup.start is None and run.language == "G-code":
        notices.append("no start position was given: the tool begins at the machine's zero")
    boxes = {
        kind: Box((low[0], low[1], low[2]), (high[0], high[1], high[2]))
        for kind, low, high in ((kind, seen.low[kind], seen.high[kind]) for kind in seen.low)
    }
    return Summary(
        run.language, tuple(seen.units), run.blocks, seen.counts, tuple(seen.tools) or (default_tool(setup),),
        not seen.tools, tuple(sorted(seen.speeds)), tuple(sorted(seen.feeds)), boxes, seen.rotary, seen.rapid_length,
        seen.feed_length, seen.feed_time, seen.dwell_time, seen.stops, tuple(seen.messages), tuple(notices),
    )  # fmt: skip


def as_json(found: Summary) -> dict[str, Any]:
    """The summary in SI."""
    return {
        "language": found.language, "units": list(found.units), "blocks": found.blocks, "moves": found.moves,
        "tools": list(found.tools), "default_tool": found.default_tool,
        "spindle_speeds": list(found.spindle_speeds), "feeds": list(found.feeds),
        "boxes": {kind: {"low": list(box.low), "high": list(box.high)} for kind, box in found.boxes.items()},
        "rotary_axes": found.rotary, "rapid_length": found.rapid_length, "feed_length": found.feed_length,
        "feed_time": found.feed_time, "dwell_time": found.dwell_time, "cycle_time": found.cycle_time,
        "stops": found.stops, "messages": [{"line": said.line, "text": said.text} for said in found.messages],
        "remarks": list(found.notices),
    }  # fmt: skip


def shown(name: str, found: Summary) -> str:
    """The summary as text."""
    counts = ", ".join(f"{count} {kind}" for kind, count in found.moves.items()) or "none"
    default = " (default: the program calls none)" if found.default_tool else ""
    lines = [
        f"{name}: {found.language} in {' and '.join(found.units)}, {found.blocks} blocks, "
        f"{sum(found.moves.values())} moves ({counts})",
        "tools: " + ", ".join(f"T{tool}" for tool in found.tools) + default,
        "spindle: " + _listed(found.spindle_speeds, "angular_speed", "does not turn while it cuts"),
        "feeds: " + _listed(found.feeds, "speed", "none"),
    ]
    for kind, box in found.boxes.items():
        extent = ", ".join(
            f"{axis} {1e3 * low:.3f} to {1e3 * high:.3f}"
            for axis, low, high in zip("xyz", box.low, box.high, strict=True)
        )
        lines.append(f"{kind}: {extent} mm")
    lines += [
        f"length: {units.show(found.feed_length, 'length', 6)} feed, {units.show(found.rapid_length, 'length', 6)} rapid",
        f"time: {_time(found.cycle_time)} (feed {_time(found.feed_time)}, dwell {_time(found.dwell_time)}); rapid moves, "
        "accelerations and tool changes come on top",
    ]
    if found.rotary:
        lines.append("rotary axes move")
    if found.stops:
        lines.append(f"stops for the operator: {found.stops}")
    lines += [f"message in line {said.line}: {said.text}" for said in found.messages]
    lines += [f"notice: {notice}" for notice in found.notices]
    return "\n".join(lines)


def _listed(values: tuple[float, ...], dimension: str, none: str) -> str:
    if not values:
        return none
    if len(values) <= 6:
        return ", ".join(units.show(value, dimension) for value in values)
    return f"{len(values)} from {units.show(values[0], dimension)} to {units.show(values[-1], dimension)}"


def _time(seconds: float) -> str:
    if seconds < 60.0:
        return f"{seconds:.4g} s"
    minutes, rest = divmod(seconds, 60.0)
    hours, minutes = divmod(int(minutes), 60)
    return f"{hours} h {minutes} min {rest:.0f} s" if hours else f"{minutes} min {rest:.1f} s"
