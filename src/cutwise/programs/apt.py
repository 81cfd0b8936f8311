"""APT cutter location data (CL, CLS), as CAM systems write it, into canonical commands.

Positions are those of the tool tip. A tool axis (MULTAX) is carried as rotary angles: B its tilt from z, C the direction
of the tilt in the xy plane, so that the axis is ``(sin B cos C, sin B sin C, cos B)``.
"""

import contextlib
import math
from collections.abc import Callable, Iterator
from typing import Literal

from cutwise.maths.circles import Circle, chords
from cutwise.programs import canon
from cutwise.programs.apt_circles import check_ends, circle_of
from cutwise.programs.apt_cycles import BEGINS, Hole, hole_of, peck_count, peck_depths
from cutwise.programs.apt_frames import Frames, Z
from cutwise.programs.apt_units import INCH_FEEDS, MM_FEEDS, first_unit, is_about_units, says_inch
from cutwise.programs.cldata import Statement, StatementFault, is_apt, statements
from cutwise.programs.controller import INCH, MILLIMETRE, PLANES
from cutwise.programs.moves import Point
from cutwise.programs.scale import MOST, feed_out_of_scale, feed_too_small, out_of_scale
from cutwise.programs.setup import Setup
from cutwise.spec.faults import Fault, ScenarioFault

__all__ = ["Apt", "is_apt"]

_MOST_FAULTS = 100
_CHORD_TOLERANCE = 1e-6  # [m] of the lines that stand for an arc about a tilted axis
_PER_REVOLUTION = ("IPR", "MMPR", "PERREV", "UPR", "REV")
_FEED_WORDS = (*INCH_FEEDS, *MM_FEEDS, "PERREV", "PERMIN", "UPR", "UPM", "REV", "MINUTE")
_SILENT = (
    "CUTTER", "TLDATA", "PAINT", "MACHIN", "INTOL", "OUTTOL", "TOLER", "TOOLNO", "SEQNO", "MODE", "AUXFUN", "HEAD",
    "OPNAME", "END-OF-PATH", "SELECT TOOL", "SELCTL", "SELECT", "CLEARP", "CATPROCESS", "PROGRAM", "DISPLY", "SETUP",
)  # fmt: skip
_PLACED = ("GOTO", "GODLTA", "FROM", "CIRCLE")  # words whose numbers are told apart by their places
_SILENT_KIND = "CSI_SET_"  # sizes of the tool, as SolidWorks CAM writes them


class Apt:
    """A run through CL data.

    :meth:`commands` gives its commands; when they are used up, :meth:`notices` tells what was assumed.
    """

    language: Literal["G-code", "APT"] = "APT"

    def __init__(self, text: str, name: str, setup: Setup = Setup()) -> None:  # noqa: B008
        self.name = name
        self.statements = list(statements(text))
        self.inch, assumed = first_unit(self.statements)
        self.noticed: dict[str, int] = {assumed: 0} if assumed else {}
        self.faults: list[Fault] = []
        self.unknown: dict[str, list[Statement]] = {}  # words that are not known, all their places
        self.blocks = 0
        self.line = 0
        self.steps_left = setup.step_limit
        self.out: list[canon.Command] = []
        self.frames = Frames()
        self.at: Point = self._first_place(setup)
        unit = self._metres()
        self.start: Point = (self.at[0] * unit, self.at[1] * unit, self.at[2] * unit)
        self.frames = Frames()
        self.tool_axis: Point = Z
        self.rapid = False
        # RAPID of SolidWorks CAM holds until a feed is written; elsewhere it is for the next motion
        self.rapid_holds = any(s.word == "TRNTYP" or s.word.startswith(_SILENT_KIND) for s in self.statements)
        self.feed, self.per_revolution = 0.0, False
        self.circle: Circle | None = None
        self.hole: Hole | None = None
        self.last_hole: Hole | None = None  # what CYCLE/ON takes up again
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
            except StatementFault as fault:
                self.faults.append(Fault((), fault.message, statement.line, fault.column, self.name))
            yield from self.out
            self.out.clear()
            if len(self.faults) >= _MOST_FAULTS:
                words = f"here reading ended, after {_MOST_FAULTS} faults; there may be more"
                self.faults.append(Fault((), words, statement.line, 1, self.name))
            if self.ended or len(self.faults) >= _MOST_FAULTS:
                break
        self._close()
        if self.faults:
            raise ScenarioFault(sorted(self.faults, key=lambda fault: fault.line or 0))

    def _close(self) -> None:
        """What is known when all statements are run: unknown words, one fault each; what stands behind the end."""
        for word, found in self.unknown.items():
            times = f" ({len(found)} times, first here)" if len(found) > 1 else ""
            message = f"{word}: unknown or unsupported APT word{times}; let the CAM system write points (GOTO), CIRCLE and CYCLE"
            self.faults.append(Fault((), message, found[0].line, found[0].column, self.name))
        behind = [s for s in self.statements[self.blocks :] if s.word in ("GOTO", "GODLTA")]
        if self.ended and behind:
            self.noticed[
                f"{len(behind)} motions stand behind the end of the program (line {self.line}) and are not run"
            ] = behind[0].line

    def _metres(self) -> float:
        return INCH if self.inch else MILLIMETRE

    def _first_place(self, setup: Setup) -> Point:
        """Where FROM says that the tool stands before the first motion; else the given start, or zero."""
        for statement in self.statements:
            if statement.word in ("CSYS", "MSYS", "TRNTYP"):
                with contextlib.suppress(StatementFault):  # said when it is run
                    self.frames.take(statement)
            if statement.word == "FROM" and len(statement.numbers()) >= 3:
                x, y, z = statement.numbers()[:3]
                return self.frames.point((x, y, z))
            if statement.word in ("GOTO", "GODLTA"):
                break
        if setup.start is None:
            self.noticed["no FROM: the tool is taken to begin at the origin"] = 0
            return 0.0, 0.0, 0.0
        x, y, z = (value / self._metres() for value in setup.start)
        return x, y, z

    def _run(self, s: Statement) -> None:
        step = _STEPS.get(s.word)
        for argument in s.arguments:
            if argument.number is not None and abs(argument.number) > MOST:
                raise StatementFault(out_of_scale(argument.number), argument.column)
        if s.word in _PLACED:
            s.check_numbers()
        if is_about_units(s):
            self.set_units(s)
        elif step is not None:
            step(self, s)
        elif s.word == "MODE" and "INCR" in s.words():
            raise StatementFault("MODE/INCR: incremental points are not supported; let the CAM system write absolute ones",
                                 s.column)  # fmt: skip
        elif s.word not in _SILENT and not s.word.startswith(_SILENT_KIND) and s.word:
            self.unknown.setdefault(s.word, []).append(s)

    def set_units(self, s: Statement) -> None:
        """UNITS: known from the start; another one than before holds from here on."""
        inch = says_inch(s)
        if inch == self.inch:
            return
        factor = MILLIMETRE / INCH if inch else INCH / MILLIMETRE
        self.inch = inch
        self.at = (self.at[0] * factor, self.at[1] * factor, self.at[2] * factor)
        self.feed, self.feed_before = self.feed * factor, self.feed_before * factor
        self.hole = self.last_hole = self.circle = None
        self._say(canon.LengthUnits, inch)
        if self.feed > 0.0:
            self._say(canon.FeedRate, self.feed)

    def system(self, s: Statement) -> None:
        """CSYS, MSYS, TRNTYP."""
        words = self.frames.take(s)
        if words:
            self.noticed.setdefault(words, self.line)
        if s.word != "TRNTYP" and self.frames.base is not None:
            self.tool_axis = self.frames.tool_axis()

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
        n = s.numbers()
        if len(n) == 1:
            by = [n[0] * component for component in self.tool_axis]
        elif len(n) < 3:
            raise StatementFault("GODLTA needs three distances, or one along the tool axis", s.column)
        else:
            by = list(self.frames.vector((n[0], n[1], n[2])))
        end = (self.at[0] + by[0], self.at[1] + by[1], self.at[2] + by[2])
        self._reach(s, end, self.tool_axis)

    def _point(self, s: Statement) -> tuple[Point, Point]:
        n = s.numbers()
        if len(n) not in (3, 6) and len(n) < 6:
            raise StatementFault(
                f"{s.word} needs x,y,z, or x,y,z,i,j,k with the tool axis; found {len(n)} numbers", s.column
            )
        point = self.frames.point((n[0], n[1], n[2]))
        if len(n) == 3:
            return point, self.tool_axis
        size = math.hypot(n[3], n[4], n[5])
        if size < 1e-6:
            raise StatementFault("the tool axis i,j,k has no length", s.arguments[3].column)
        return point, self.frames.vector((n[3] / size, n[4] / size, n[5] / size))

    def _reach(self, s: Statement, end: Point, axis: Point) -> None:
        circle, self.circle = self.circle, None
        self.tool_axis = axis
        rapid, self.rapid = self.rapid, self.rapid and self.rapid_holds
        if self.hole is not None:
            self._drill(s, end)
        elif circle is not None:
            self._arc(s, circle, end)
        else:
            self._straight(s, end, rapid=rapid)

    def _straight(self, s: Statement, end: Point, *, rapid: bool) -> None:
        if not rapid and self.feed <= 0.0:
            raise StatementFault("feed motion without a feed; write FEDRAT or RAPID before", s.column)
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
        """CIRCLE: of the arc that the next GOTO ends."""
        self.circle = circle_of(s, self.frames, self.at)

    def _arc(self, s: Statement, circle: Circle, end: Point) -> None:
        if self.feed <= 0.0:
            raise StatementFault("arc without a feed; write FEDRAT before", s.column)
        check_ends(circle, self.at, end, 0.02 * MILLIMETRE / self._metres(), s.column)
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
        """CYCLE: what is done at each following point; OFF, or ON again."""
        words = s.words()
        if "OFF" in words:
            self.hole = None
            if self.feed_before > 0.0 and self.feed_before != self.feed:
                self._set_feed(self.feed_before, self.per_revolution)
            return
        if len(words) == 1 and words[0] in BEGINS and not s.numbers():
            self.hole = self.last_hole if words[0] == "ON" else self.hole
            return
        rate = next((found for word in _FEED_WORDS if (found := s.after(word)) is not None), 0.0)
        self.hole = self.last_hole = hole_of(s, self._rate(s, rate) if rate else 0.0)
        if "AUTO" in words and "RTRCTO" in words:
            self.noticed.setdefault("RTRCTO,AUTO: between holes the tool is drawn back to the height of RAPTO or CLEAR",
                                    self.line)  # fmt: skip

    def _drill(self, s: Statement, point: Point) -> None:
        hole = self.hole
        assert hole is not None
        self.steps_left -= math.ceil(3.0 * min(peck_count(hole), 1e12))
        if self.steps_left < 0:
            raise StatementFault("this cycle draws back more often than the limit of steps allows; its peck of "
                                 f"{hole.peck:g} is too small (if it is meant, raise program.step_limit, "
                                 "or --step-limit)", s.column)  # fmt: skip
        if hole.feed and hole.feed != self.feed:
            self.feed_before = self.feed
            self._set_feed(hole.feed, self.per_revolution)
        self._straight(s, self._above(point, hole.retract), rapid=True)
        if hole.retract > hole.clearance:
            self._straight(s, self._above(point, hole.clearance), rapid=True)
        for depth in peck_depths(hole):
            self._straight(s, self._above(point, depth), rapid=False)
            self._straight(s, self._above(point, hole.clearance), rapid=True)
            self._straight(s, self._above(point, depth), rapid=True)
        self._straight(s, self._above(point, hole.bottom), rapid=False)
        if hole.seconds:
            self._say(canon.Dwell, hole.seconds)
        self._straight(s, self._above(point, hole.retract), rapid=True)

    def _above(self, point: Point, height: float) -> Point:
        x, y, z = (p + height * a for p, a in zip(point, self.tool_axis, strict=True))
        return x, y, z

    # feeds, spindle, tools

    def rapid_next(self, s: Statement) -> None:  # noqa: ARG002
        """RAPID: the next motion, or all up to the next feed."""
        self.rapid = True
        if self.rapid_holds:
            self.noticed.setdefault("RAPID holds until the next FEDRAT, as SolidWorks CAM writes it", self.line)

    def feed_rate(self, s: Statement) -> None:
        """FEDRAT."""
        numbers = s.numbers()
        if "RAPID" in s.words():
            self.rapid = True
            return
        if len(numbers) != 1 or numbers[0] <= 0.0:
            raise StatementFault("FEDRAT needs one positive feed", s.column)
        if feed_too_small(numbers[0]):
            raise StatementFault(feed_out_of_scale(numbers[0]), s.column)
        self.rapid = self.rapid and not self.rapid_holds
        self._set_feed(self._rate(s, numbers[0]), any(word in _PER_REVOLUTION for word in s.words()))

    def _rate(self, s: Statement, value: float) -> float:
        """A feed in program units."""
        words = s.words()
        if any(word in INCH_FEEDS for word in words):
            return value * INCH / self._metres()
        return value * MILLIMETRE / self._metres() if any(word in MM_FEEDS for word in words) else value

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
            raise StatementFault("SPINDL: surface speeds are not supported; write RPM", s.column)
        if numbers:
            self._say(canon.SpindleSpeed, numbers[0])
        self._say(canon.SpindleTurn, -1 if "CCLW" in words else 1)

    def load(self, s: Statement) -> None:
        """LOADTL/n, LOAD/TOOL,n, TURRET/n."""
        numbers = s.numbers()
        if not numbers or numbers[0] < 0.0 or numbers[0] != round(numbers[0]):
            raise StatementFault(f"{s.word} needs the number of a tool", s.column)
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

    def compensate(self, s: Statement) -> None:
        """CUTCOM: the points are those of the tool centre already."""
        if "OFF" not in s.words():
            self.noticed.setdefault("CUTCOM: points are taken as those of the tool tip; what the control's own cutter "
                                    "compensation adds (the wear of the tool) is left out", self.line)  # fmt: skip

    def wait(self, s: Statement) -> None:
        """DELAY."""
        numbers = s.numbers()
        if len(numbers) != 1 or numbers[0] < 0.0:
            raise StatementFault("DELAY needs a time in seconds", s.column)
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
        """A word that changes nothing here: MULTAX shows in the points."""


_STEPS: dict[str, Callable[[Apt, Statement], None]] = {
    "FROM": Apt.place, "GOTO": Apt.go, "GODLTA": Apt.go_by, "CIRCLE": Apt.circle_next, "CYCLE": Apt.cycle,
    "RAPID": Apt.rapid_next, "FEDRAT": Apt.feed_rate, "SPINDL": Apt.spindle, "LOADTL": Apt.load, "LOAD": Apt.load,
    "TURRET": Apt.load, "COOLNT": Apt.cool, "DELAY": Apt.wait, "PARTNO": Apt.speak, "PPRINT": Apt.speak,
    "REMARK": Apt.speak, "TOOL PATH": Apt.speak, "INSERT": Apt.speak, "OP_NAME": Apt.speak, "TITLE": Apt.speak,
    "LETTER": Apt.speak, "STOP": Apt.stop, "OPSTOP": Apt.stop, "FINI": Apt.finish, "END": Apt.finish,
    "MULTAX": Apt.nothing, "CUTCOM": Apt.compensate, "CSYS": Apt.system, "MSYS": Apt.system, "TRNTYP": Apt.system,
}  # fmt: skip
