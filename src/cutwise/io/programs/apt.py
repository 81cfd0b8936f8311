"""APT cutter location data (CL, CLS), as CAM systems write it, into canonical commands.

Positions are those of the tool tip. A tool axis (MULTAX) is carried as rotary angles: B its tilt from z, C the direction
of the tilt in the xy plane, so that the axis is ``(sin B cos C, sin B sin C, cos B)``.
"""

import math
from collections.abc import Callable, Iterator
from typing import Literal, NamedTuple

from cutwise.io.programs import canon
from cutwise.io.programs.cldata import Statement, is_apt, statements
from cutwise.io.programs.controller import INCH, MILLIMETRE, PLANES
from cutwise.io.programs.moves import Point
from cutwise.io.programs.setup import Setup
from cutwise.maths.circles import Circle, chords, distance_from_axis
from cutwise.spec.faults import Fault, ScenarioFault

__all__ = ["Apt", "is_apt"]

_MOST_FAULTS = 100
_ON_CIRCLE = 1e-3  # share of the radius by which an end may be off its circle
_CHORD_TOLERANCE = 1e-6  # [m] of the lines that stand for an arc about a tilted axis
_INCH_FEEDS, _MM_FEEDS = ("IPM", "IPR"), ("MMPM", "MMPR")
_PER_REVOLUTION = ("IPR", "MMPR", "PERREV", "UPR", "REV")
_FEED_WORDS = (*_INCH_FEEDS, *_MM_FEEDS, "PERREV", "PERMIN", "UPR", "UPM", "REV", "MINUTE")
_SILENT = (
    "CUTTER", "TLDATA", "PAINT", "MACHIN", "INTOL", "OUTTOL", "TOLER", "TOOLNO", "SEQNO", "MODE", "AUXFUN", "HEAD",
    "OPNAME", "END-OF-PATH", "SELECT TOOL", "SELCTL", "CLEARP", "MSYS", "CATPROCESS", "PROGRAM", "DISPLY", "UNIT",
)  # fmt: skip
_DRILLED = ("DRILL", "DEEP", "BRKCHP", "BORE", "REAM", "FACE", "CSINK", "CBORE", "TAP", "THRUHOLE")


class _StatementFault(Exception):
    def __init__(self, message: str, column: int) -> None:
        super().__init__(message)
        self.message, self.column = message, column


class Hole(NamedTuple):
    """What a drilling cycle does at each point: heights along the tool axis, measured from the point."""

    clearance: float
    bottom: float
    peck: float  # 0: none
    seconds: float
    feed: float  # 0: the feed in force


class Apt:
    """A run through CL data.

    :meth:`commands` gives its commands; when they are used up, :meth:`notices` tells what was assumed.
    """

    language: Literal["G-code", "APT"] = "APT"

    def __init__(self, text: str, name: str, setup: Setup = Setup()) -> None:  # noqa: B008
        self.name = name
        self.statements = list(statements(text))
        self.inch, said = _unit(self.statements)
        self.noticed: dict[str, int] = (
            {} if said else {"no UNITS: lengths are taken as " + ("in" if self.inch else "mm"): 0}
        )
        self.faults: list[Fault] = []
        self.blocks = 0
        self.line = 0
        self.out: list[canon.Command] = []
        self.at: Point = self._first_place(setup)
        unit = self._metres()
        self.start: Point = (self.at[0] * unit, self.at[1] * unit, self.at[2] * unit)
        self.tool_axis: Point = (0.0, 0.0, 1.0)
        self.rapid = False
        self.feed, self.per_revolution = 0.0, False
        self.circle: Circle | None = None
        self.hole: Hole | None = None
        self.feed_before = 0.0  # before the feed of a cycle
        self.plane = "XY"
        self.ended = False

    def notices(self) -> list[str]:
        """What was assumed or left out, each with the line that it begins in."""
        return [f"line {line}: {words}" if line else words for words, line in self.noticed.items()]

    def commands(self) -> Iterator[canon.Command]:
        """The commands of the program, as it runs.

        Raises
        ------
        ScenarioFault
            At the end, with everything that could not be run.
        """
        yield canon.LengthUnits(self.inch, 0, "")
        for statement in self.statements:
            self.line = statement.line
            self.blocks += 1
            try:
                self._run(statement)
            except _StatementFault as fault:
                self.faults.append(Fault((), fault.message, statement.line, fault.column, self.name))
            yield from self.out
            self.out.clear()
            if len(self.faults) >= _MOST_FAULTS:
                words = f"here reading ended, after {_MOST_FAULTS} faults; there may be more"
                self.faults.append(Fault((), words, statement.line, 1, self.name))
            if self.ended or len(self.faults) >= _MOST_FAULTS:
                break
        if self.faults:
            raise ScenarioFault(self.faults)

    def _metres(self) -> float:
        return INCH if self.inch else MILLIMETRE

    def _first_place(self, setup: Setup) -> Point:
        """Where FROM says that the tool stands before the first motion; else the given start, or zero."""
        for statement in self.statements:
            if statement.word == "FROM" and len(statement.numbers()) >= 3:
                x, y, z = statement.numbers()[:3]
                return x, y, z
            if statement.word in ("GOTO", "GODLTA"):
                break
        if setup.start is None:
            self.noticed["no FROM: the tool is taken to begin at the origin"] = 0
            return 0.0, 0.0, 0.0
        x, y, z = (value / self._metres() for value in setup.start)
        return x, y, z

    def _run(self, s: Statement) -> None:
        step = _STEPS.get(s.word)
        if step is not None:
            step(self, s)
        elif s.word in _SILENT or not s.word:
            return
        else:
            raise _StatementFault(f"{s.word}: unknown or unsupported APT word; let the CAM system write points (GOTO), "
                                  "CIRCLE and CYCLE", s.column)  # fmt: skip

    def _say(self, command: Callable[..., canon.Command], *arguments: object) -> None:
        self.out.append(command(*arguments, self.line, ""))

    # motion

    def place(self, s: Statement) -> None:
        """FROM."""
        self.at, self.tool_axis = self._point(s)

    def go(self, s: Statement) -> None:
        """GOTO."""
        end, axis = self._point(s)
        self._reach(s, end, axis)

    def go_by(self, s: Statement) -> None:
        """GODLTA: by three distances, or by one along the tool axis."""
        by = s.numbers()
        if len(by) == 1:
            by = [by[0] * component for component in self.tool_axis]
        if len(by) < 3:
            raise _StatementFault("GODLTA needs three distances, or one along the tool axis", s.column)
        end = (self.at[0] + by[0], self.at[1] + by[1], self.at[2] + by[2])
        self._reach(s, end, self.tool_axis)

    def _point(self, s: Statement) -> tuple[Point, Point]:
        n = s.numbers()
        if len(n) not in (3, 6) and len(n) < 6:
            raise _StatementFault(
                f"{s.word} needs x,y,z, or x,y,z,i,j,k with the tool axis; found {len(n)} numbers", s.column
            )
        point = (n[0], n[1], n[2])
        if len(n) == 3:
            return point, self.tool_axis
        size = math.hypot(n[3], n[4], n[5])
        if size < 1e-6:
            raise _StatementFault("the tool axis i,j,k has no length", s.arguments[3].column)
        return point, (n[3] / size, n[4] / size, n[5] / size)

    def _reach(self, s: Statement, end: Point, axis: Point) -> None:
        circle, self.circle = self.circle, None
        self.tool_axis = axis
        rapid, self.rapid = self.rapid, False
        if self.hole is not None:
            self._drill(s, end)
        elif circle is not None:
            self._arc(s, circle, end)
        else:
            self._straight(s, end, rapid=rapid)

    def _straight(self, s: Statement, end: Point, *, rapid: bool) -> None:
        if not rapid and self.feed <= 0.0:
            raise _StatementFault("feed motion without a feed; write FEDRAT or RAPID before", s.column)
        self.at = end
        self._say(canon.Traverse if rapid else canon.Feed, *end, self._rotary(), canon.NO_TURN)

    def _rotary(self) -> canon.Triple:
        i, j, k = self.tool_axis
        tilt = math.degrees(math.atan2(math.hypot(i, j), k))
        if tilt == 0.0:
            return canon.NO_TURN
        self.noticed.setdefault("tool axes are carried as rotary angles: B tilt from z, C its direction", self.line)
        return 0.0, tilt, math.degrees(math.atan2(j, i))

    def circle_next(self, s: Statement) -> None:
        """CIRCLE: centre, axis, radius of the arc that the next GOTO ends."""
        n = s.numbers()
        if len(n) < 7:
            raise _StatementFault("CIRCLE needs centre x,y,z, axis i,j,k and radius", s.column)
        size = math.hypot(*n[3:6])
        if size < 1e-6 or n[6] <= 0.0:
            raise _StatementFault("CIRCLE needs an axis with a length and a positive radius", s.column)
        self.circle = Circle((n[0], n[1], n[2]), (n[3] / size, n[4] / size, n[5] / size), n[6])

    def _arc(self, s: Statement, circle: Circle, end: Point) -> None:
        if self.feed <= 0.0:
            raise _StatementFault("arc without a feed; write FEDRAT before", s.column)
        for name, point in (("start", self.at), ("end", end)):
            far = distance_from_axis(circle, point)
            if abs(far - circle.radius) > max(_ON_CIRCLE * circle.radius, 0.02 * MILLIMETRE / self._metres()):
                message = f"the {name} of the arc is {far:.6g} from its axis, its radius is {circle.radius:.6g}"
                raise _StatementFault(message, s.column)
        w = next((i for i in range(3) if abs(abs(circle.axis[i]) - 1.0) < 1e-9), None)
        if w is None:
            self._tilted_arc(s, circle, end)
            return
        plane: Literal["XY", "XZ", "YZ"] = ("YZ", "XZ", "XY")[w]
        if plane != self.plane:
            self.plane = plane
            self._say(canon.Plane, plane)
        u, v, _ = PLANES[plane]
        turns = 1 if circle.axis[w] > 0.0 else -1
        self.at = end
        c = circle.centre
        self._say(canon.Arc, end[u], end[v], c[u], c[v], turns, end[w], self._rotary(), canon.NO_TURN)

    def _tilted_arc(self, s: Statement, circle: Circle, end: Point) -> None:
        """Lines within a micrometre of an arc about a tilted axis."""
        self.noticed.setdefault("arcs about tilted axes are run as short lines, within 1 µm", self.line)
        for point in chords(circle, self.at, end, _CHORD_TOLERANCE / self._metres()):
            self._straight(s, point, rapid=False)

    # cycles

    def cycle(self, s: Statement) -> None:
        """CYCLE: what is done at each following point, or OFF; or ON again."""
        words, numbers = s.words(), s.numbers()
        if "OFF" in words:
            self.hole = None
            if self.feed_before > 0.0 and self.feed_before != self.feed:
                self._set_feed(self.feed_before, self.per_revolution)
            return
        if not words or words[0] not in _DRILLED:
            raise _StatementFault(f"CYCLE/{words[0] if words else ''}: unknown or unsupported cycle; known are "
                                  f"{', '.join(_DRILLED)}", s.column)  # fmt: skip
        clearance, bottom = s.after("RAPTO", "CLEAR"), s.after("FEDTO", "DEPTH")
        rate = next((found for word in _FEED_WORDS if (found := s.after(word)) is not None), 0.0)
        if bottom is None and numbers:  # depth, feed word, feed, clearance
            bottom = -abs(numbers[0])
            clearance = numbers[-1] if clearance is None and len(numbers) >= 3 else clearance
        if bottom is None:
            raise _StatementFault("CYCLE needs a depth (FEDTO or the first number)", s.column)
        if rate:
            rate = self._rate(s, rate)
        peck = (s.after("STEP", "PECK") or 0.0) if words[0] in ("DEEP", "BRKCHP") else 0.0
        self.hole = Hole(clearance or 0.0, -abs(bottom), peck, s.after("DWELL") or 0.0, rate)

    def _drill(self, s: Statement, point: Point) -> None:
        hole = self.hole
        assert hole is not None
        if hole.feed and hole.feed != self.feed:
            self.feed_before = self.feed
            self._set_feed(hole.feed, self.per_revolution)
        self._straight(s, self._above(point, hole.clearance), rapid=True)
        depth = hole.clearance - hole.peck
        while hole.peck > 0.0 and depth > hole.bottom:
            self._straight(s, self._above(point, depth), rapid=False)
            self._straight(s, self._above(point, hole.clearance), rapid=True)
            self._straight(s, self._above(point, depth), rapid=True)
            depth -= hole.peck
        self._straight(s, self._above(point, hole.bottom), rapid=False)
        if hole.seconds:
            self._say(canon.Dwell, hole.seconds)
        self._straight(s, self._above(point, hole.clearance), rapid=True)

    def _above(self, point: Point, height: float) -> Point:
        x, y, z = (p + height * a for p, a in zip(point, self.tool_axis, strict=True))
        return x, y, z

    # feeds, spindle, tools

    def rapid_next(self, s: Statement) -> None:  # noqa: ARG002
        """RAPID: the next motion."""
        self.rapid = True

    def feed_rate(self, s: Statement) -> None:
        """FEDRAT."""
        numbers = s.numbers()
        if "RAPID" in s.words():
            self.rapid = True
            return
        if len(numbers) != 1 or numbers[0] <= 0.0:
            raise _StatementFault("FEDRAT needs one positive feed", s.column)
        self._set_feed(self._rate(s, numbers[0]), any(word in _PER_REVOLUTION for word in s.words()))

    def _rate(self, s: Statement, value: float) -> float:
        """A feed in program units."""
        words = s.words()
        if any(word in _INCH_FEEDS for word in words):
            return value * INCH / self._metres()
        return value * MILLIMETRE / self._metres() if any(word in _MM_FEEDS for word in words) else value

    def _set_feed(self, rate: float, per_revolution: bool) -> None:
        if per_revolution != self.per_revolution:
            self.per_revolution = per_revolution
            self._say(canon.FeedMode, per_revolution)
        self.feed = rate
        self._say(canon.FeedRate, rate)

    def spindle(self, s: Statement) -> None:
        """SPINDL."""
        words, numbers = s.words(), s.numbers()
        if "OFF" in words:
            self._say(canon.SpindleTurn, 0)
            return
        if any(word in ("SFM", "SMM") for word in words):
            raise _StatementFault("SPINDL: surface speeds are not supported; write RPM", s.column)
        if numbers:
            self._say(canon.SpindleSpeed, numbers[0])
        self._say(canon.SpindleTurn, -1 if "CCLW" in words else 1)

    def load(self, s: Statement) -> None:
        """LOADTL/n, LOAD/TOOL,n, TURRET/n."""
        numbers = s.numbers()
        if not numbers or numbers[0] < 0.0 or numbers[0] != round(numbers[0]):
            raise _StatementFault(f"{s.word} needs the number of a tool", s.column)
        self._say(canon.SelectTool, int(numbers[0]))
        self._say(canon.ChangeTool, int(numbers[0]), False)

    def cool(self, s: Statement) -> None:
        """COOLNT."""
        words = s.words()
        if "OFF" in words:
            for kind in ("mist", "flood"):
                self._say(canon.Coolant, kind, False)
        else:
            self._say(canon.Coolant, "mist" if "MIST" in words else "flood", True)

    def wait(self, s: Statement) -> None:
        """DELAY."""
        numbers = s.numbers()
        if len(numbers) != 1 or numbers[0] < 0.0:
            raise _StatementFault("DELAY needs a time in seconds", s.column)
        self._say(canon.Dwell, numbers[0])

    # words

    def speak(self, s: Statement) -> None:
        """PARTNO, PPRINT, REMARK."""
        if s.text:
            self._say(canon.Comment, s.text)

    def stop(self, s: Statement) -> None:
        """STOP, OPSTOP."""
        self._say(canon.Stop, "optional" if s.word == "OPSTOP" else "stop")

    def finish(self, s: Statement) -> None:  # noqa: ARG002
        """FINI, END."""
        self.ended = True
        self._say(canon.SpindleTurn, 0)
        self._say(canon.Stop, "end")

    def nothing(self, s: Statement) -> None:
        """A word that changes nothing here: UNITS is known from the start, MULTAX shows in the points."""


_STEPS: dict[str, Callable[[Apt, Statement], None]] = {
    "FROM": Apt.place, "GOTO": Apt.go, "GODLTA": Apt.go_by, "CIRCLE": Apt.circle_next, "CYCLE": Apt.cycle,
    "RAPID": Apt.rapid_next, "FEDRAT": Apt.feed_rate, "SPINDL": Apt.spindle, "LOADTL": Apt.load, "LOAD": Apt.load,
    "TURRET": Apt.load, "COOLNT": Apt.cool, "DELAY": Apt.wait, "PARTNO": Apt.speak, "PPRINT": Apt.speak,
    "REMARK": Apt.speak, "TOOL PATH": Apt.speak, "INSERT": Apt.speak, "OP_NAME": Apt.speak, "TITLE": Apt.speak,
    "LETTER": Apt.speak, "STOP": Apt.stop, "OPSTOP": Apt.stop, "FINI": Apt.finish, "END": Apt.finish,
    "UNITS": Apt.nothing, "MULTAX": Apt.nothing,
}  # fmt: skip


def _unit(found: list[Statement]) -> tuple[bool, bool]:
    """Whether lengths are inches, and whether that is said: by UNITS, or by the unit of the first feed."""
    for statement in found:
        if statement.word == "UNITS":
            return any(word in ("INCH", "INCHES", "IN") for word in statement.words()), True
    for statement in found:
        for word in statement.words():
            if word in _INCH_FEEDS or word in _MM_FEEDS:
                return word in _INCH_FEEDS, True
    return False, False
