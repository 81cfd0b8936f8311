"""RS274/NGC programs run into canonical commands: line by line, with subroutines, loops and branches."""

import math
import re
from collections.abc import Iterator
from typing import Literal, Protocol

from cutwise.programs import execution, offsets
from cutwise.programs.block import Block, computed_block, settle, without_call
from cutwise.programs.canon import Command, Feed, FeedRate, Traverse
from cutwise.programs.controller import INCH, MILLIMETRE, Controller, from_machine, to_machine
from cutwise.programs.expressions import BlockFault, CommentFault, FlowFault, computed
from cutwise.programs.flow import Flow
from cutwise.programs.notices import say
from cutwise.programs.scale import MOST, feed_too_small
from cutwise.programs.setup import Setup
from cutwise.programs.source import Source, motions_between
from cutwise.programs.variables import Memory
from cutwise.programs.words import Line, column
from cutwise.spec.faults import Fault, ScenarioFault

MOST_FAULTS = 100  # after which the rest of a program is not looked at any more

_AXIS = r"(?:[{}][ \t]*([-+.\d]+)[ \t]*)?"
_PLAIN = re.compile(
    r"[ \t]*(?:[nN](\d+)[ \t]*)?(?:[gG]0?([01])(?![\d.])[ \t]*)?"
    + "".join(_AXIS.format(pair) for pair in ("xX", "yY", "zZ", "fF"))
    + r"\r?"
).fullmatch
"""A straight motion and nothing else: most lines of most programs, read without taking them apart."""

_UNIT_WORD = re.compile(r"(?:^|[^A-Za-z0-9#<_])[gG]\s*2\s*([01])(?![\d.])")
_COMMENTS = re.compile(r"\([^()\n]*\)|;[^\n]*")


def first_unit(text: str) -> bool | None:
    """Whether the first unit word of a program is G20 (inch); None if it has none."""
    at = 0
    while (match := _UNIT_WORD.search(text, at)) is not None:  # line by line: long lines are taken apart only once
        begin, end = text.rfind("\n", 0, match.start(1)) + 1, text.find("\n", match.end())
        end = len(text) if end < 0 else end
        found = _UNIT_WORD.search(_COMMENTS.sub("", text[begin:end]))
        if found is not None:
            return found[1] == "0"
        at = end
    return None


class Watch(Protocol):
    """Something that looks on while a program runs; lines are those of the main program, from 0."""

    closely: bool  # whether it wants to be told of every line by itself

    def ran_plain(self, first: int, end: int) -> None:
        """Lines of straight motions were run, from the first up to one before the end."""
        ...

    def ran(self, at: int, controller: Controller) -> None:
        """Any other line was run, and this is the controller behind it."""
        ...


class Rs274:
    """A run through a G-code program.

    :meth:`commands` gives its commands; when they are used up, :meth:`notices` tells what was assumed.
    """

    language: Literal["G-code", "APT"] = "G-code"
    branches = False  # whether lines behind the end of the program may be reached by jumps (GOTO)

    def __init__(self, text: str, name: str, setup: Setup = Setup()) -> None:  # noqa: B008
        main = Source(name, text)
        inch = first_unit(text) if setup.inch is None else setup.inch
        self.name = name
        self.out: list[Command] = []
        self.controller = Controller(setup, bool(inch), self.out)
        if inch is None:
            self.controller.notices["no G20 or G21: lengths are taken as mm"] = 0
        self.memory = Memory(self.controller)
        self.flow = Flow(self.controller, self.memory, main, main, main.first)
        self.faults: dict[Fault, None] = {}
        self.blocks = 0  # lines with something to run
        self.ended = False
        self.watch: Watch | None = None
        self.executed: Block | None = None  # what the last line came to, its numbers computed; None: it only steered
        _prepare(self.controller)
        place = to_machine(self.controller.offsets, self.controller.at)
        self.start = (place[0] * MILLIMETRE, place[1] * MILLIMETRE, place[2] * MILLIMETRE)  # in the machine [m]

    def commands(self) -> Iterator[Command]:
        """The commands of the program, as it runs.

        Raises
        ------
        ScenarioFault
            At the end, with everything that could not be run.
        """
        if self.out:
            yield from self.out
            self.out.clear()
        flow = self.flow
        while not self.ended:
            if flow.index >= flow.source.end:
                self._end_of_file()
                break
            if self._easy():
                yield from self._plain_lines()
            if flow.index < flow.source.end:
                self._line()
            if self.out:
                yield from self.out
                self.out.clear()
        if self.out:
            yield from self.out
            self.out.clear()
        if self.faults:
            raise ScenarioFault(list(self.faults))
        self._say_behind_end()

    def _say_behind_end(self) -> None:
        """Motions that no run of the program reaches: behind its end, and behind the closing ``%``."""
        flow, c = self.flow, self.controller
        source = flow.source
        if flow.frames:
            return
        if flow.index < source.end and not self.branches:
            self._say_unrun(
                *motions_between(source.lines, flow.index, source.end), f"the end of the program (line {c.line})"
            )
        if source.end < len(source.lines):
            behind = motions_between(source.lines, source.end + 1, len(source.lines))
            self._say_unrun(*behind, f"the % that closes the program (line {source.end + 1})")

    def _say_unrun(self, count: int, line: int, what: str) -> None:
        if count:
            lines = "1 line with axis words stands" if count == 1 else f"{count} lines with axis words stand"
            verb = "is" if count == 1 else "are"
            self.controller.notices.setdefault(f"{lines} behind {what} and {verb} not run", line)

    def notices(self) -> list[str]:
        """What was assumed or left out, each with the line that it begins in."""
        noticed = self.controller.notices.items()
        return [f"line {line}: {words}" if line else words for words, line in noticed]

    def _easy(self) -> bool:
        """Whether lines of straight motions may be run without the whole machinery."""
        c = self.controller
        return (
            c.motion in (0, 10) and not c.incremental and c.feed_mode == 94 and c.compensation is None
            and c.spline is None and not c.no_arc_yet and not (self.watch is not None and self.watch.closely)
        )  # fmt: skip

    def _plain_lines(self) -> Iterator[Command]:
        """Lines of straight motions, up to the first other one."""
        c, flow, lines, end = self.controller, self.flow, self.flow.source.lines, self.flow.source.end
        at, rotary, extra = c.at, c.rotary, c.extra
        x, y, z = at[:3]
        rapid, index, begun = c.motion == 0, flow.index, flow.index
        caller = self.caller
        while index < end:
            match = _PLAIN(lines[index])
            if match is None:
                break
            number, code, new_x, new_y, new_z, feed = match.groups("")
            if not (new_x or new_y or new_z):
                break
            try:
                to_x = float(new_x) if new_x else x
                to_y = float(new_y) if new_y else y
                to_z = float(new_z) if new_z else z
                rate = float(feed) if feed else c.feed
            except ValueError:
                break
            to_rapid = code == "0" if code else rapid
            if not -MOST < to_x < MOST or not -MOST < to_y < MOST or not -MOST < to_z < MOST:
                break
            if not 0.0 <= rate < MOST or feed_too_small(rate) or (not to_rapid and rate == 0.0):
                break
            x, y, z, rapid = to_x, to_y, to_z, to_rapid
            index += 1
            line = caller or index
            if feed:
                c.feed = rate
                yield FeedRate(rate, line, number)
            yield (
                Traverse(x, y, z, rotary, extra, line, number) if rapid else Feed(x, y, z, rotary, extra, line, number)
            )
        at[0], at[1], at[2] = x, y, z
        c.motion = 0 if rapid else 10
        self.blocks += index - begun
        flow.index = index
        if self.watch is not None and flow.source is flow.main:
            self.watch.ran_plain(begun, index)

    @property
    def caller(self) -> int:
        """Line of the main program from which a file beside it is being run; 0 while the main program itself is.

        Places of moves and notices are lines of the main program: a line of another file would be looked up in its text.
        """
        flow = self.flow
        if flow.source is flow.main:
            return 0
        return next((frame.line for frame in reversed(flow.frames) if frame.source is flow.main), 0)

    def _line(self) -> None:
        """Any other line."""
        flow, c = self.flow, self.controller
        source, at = flow.source, flow.index
        flow.index += 1
        c.file_line = at + 1
        c.line = self.caller or at + 1
        self.executed = None
        try:
            self._run_line(source, at)
            if self.watch is not None and source is flow.main:
                self.watch.ran(at, c)
        except FlowFault as fault:
            self._fault(source, c.file_line - 1, fault)
            self.ended = True
        except BlockFault as fault:
            self._fault(source, c.file_line - 1, fault)
            if len(self.faults) >= MOST_FAULTS:
                ends = f"here reading ended, after {MOST_FAULTS} faults; there may be more"
                self.faults.setdefault(Fault((), ends, c.file_line, 1, source.name))
                self.ended = True
        except RecursionError:
            self._fault(source, c.file_line - 1, FlowFault("the expression has too many parts to be computed", 0))
            self.ended = True

    def _run_line(self, source: Source, at: int) -> None:
        line = source.line(at)
        self.controller.number = line.number
        if line.o_word is not None:
            self.flow.follow(line.o_word)
        elif line.words or line.assignments or line.notice is not None:
            self._block(line)

    def _block(self, line: Line) -> None:
        c, memory = self.controller, self.memory
        block = computed_block(line.words, memory) if line.words else None
        for key, value, place in [(a.key if isinstance(a.key, str) else computed(a.key, memory),
                                   computed(a.value, memory), a.place) for a in line.assignments]:  # fmt: skip
            memory.assign(key, value, place)
        stop = None if block is None else block.m.get("stop")
        if line.notice is not None and not (stop == 98 or (stop == 99 and self.flow.frames)):
            say(c, memory, line.notice)
        if block is None:
            return
        self.blocks += 1
        rest = without_call(block) if stop in (98, 99) else None
        if rest is not None:  # X10 M98 P5: first the motion
            self._execute(rest)
        if stop == 98:
            self._call_program(block)
        elif stop == 99:
            if self.flow.end_program(block.place("m.stop")):
                execution.end(c, shuttle=False)
                self.ended = True
        else:
            self._execute(block)

    def _execute(self, block: Block) -> None:
        c = self.controller
        self.executed = block
        settle(block, c.motion)
        try:
            self.ended = execution.execute(c, block)
        except BlockFault:
            execution.go_on(c, block)
            raise

    def _call_program(self, block: Block) -> None:
        if "p" not in block.values:
            raise block.fault("M98 needs the number of a program P", "m.stop")
        runs = block.whole("l") if "l" in block.values else 1
        assert runs is not None
        self.flow.call_program(str(block.whole("p")), runs, block.place("m.stop"))

    def _end_of_file(self) -> None:
        c, flow = self.controller, self.flow
        if flow.frames:
            self._fault(flow.source, c.file_line - 1, BlockFault("the file ends within a subroutine", 0))
        elif not flow.source.framed:
            c.line = 0
            c.notice("the program has no end (M2, M30, or % around it)")
        execution.close(c)
        self.ended = True

    def _fault(self, source: Source, at: int, fault: BlockFault) -> None:
        raw = source.lines[at]
        place = fault.place + 1 if isinstance(fault, CommentFault) else column(raw, fault.place)
        self.faults.setdefault(Fault((), fault.message, at + 1, place, source.name))


def _prepare(c: Controller) -> None:
    """Tools, work offsets and the start position into the controller."""
    setup = c.setup
    c.tools = dict(setup.tools or {})
    machine = INCH if c.machine_inch else MILLIMETRE
    for number, system in setup.systems.items():
        for i, value in enumerate(system.origin):
            c.numbers[5201 + 20 * number + i] = value / machine
        c.numbers[5210 + 20 * number] = math.degrees(system.rotation)
    if 1 in setup.systems:
        c.offsets.origin, c.offsets.rotation = offsets.system_of(c, 1)
        offsets.say_system(c)
        c.at[:] = from_machine(c.offsets, [0.0] * 9)
    if setup.start is not None:
        c.at[:3] = [value / MILLIMETRE for value in setup.start]
    c.slot = next(iter(c.tools), 0)
    if setup.default_tool is not None:
        c.slot = setup.default_tool
        c.tool = c.tools.get(setup.default_tool) or c.tool._replace(number=setup.default_tool)
