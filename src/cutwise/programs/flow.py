"""Where a program goes on: subroutines, branches and loops of O words, M98 and M99."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from cutwise.programs import modes
from cutwise.programs.controller import Controller
from cutwise.programs.expressions import BlockFault, FlowFault, computed, whole
from cutwise.programs.source import Source
from cutwise.programs.variables import LOCAL, Memory
from cutwise.programs.words import OWord

DEEPEST = 10  # levels of subroutines, the main program counted
IDLE_PASSES = 1000  # of a loop in which nothing changes, after which it counts as endless


class Frame(NamedTuple):
    """A call: where it came from, and what is put back at its end."""

    source: Source
    line: int  # index of the line behind the call
    numbered: bool  # called by M98: no local variables
    start: int  # first line of the subroutine
    numbers: dict[int, float]
    named: dict[str, float]
    repeats: dict[int, int]
    passes: dict[int, tuple[object, int]]


@dataclass(slots=True)
class Flow:
    """Where a program stands."""

    controller: Controller
    memory: Memory
    main: Source
    source: Source
    index: int  # of the next line
    frames: list[Frame] = field(default_factory=list)
    runs_left: list[int] = field(default_factory=list)  # of M98 L, for each call
    repeats: dict[int, int] = field(default_factory=dict)  # passes left of repeat loops
    passes: dict[int, tuple[object, int]] = field(default_factory=dict)  # of loops: last state seen, how often
    files: dict[str, Source | None] = field(default_factory=dict)
    numbered: bool = False  # the main program has begun with an O number

    def follow(self, word: OWord) -> None:
        """Go where a flow control word of the line before ``index`` leads.

        Raises
        ------
        BlockFault
            It does not fit, or its condition cannot be computed.
        """
        at = self.index - 1
        label = self._label(word)
        if word.keyword == "call":
            self._call(word, label)
        elif not word.keyword:
            self.numbered = self.numbered or not self.frames
        else:
            wrong = self.source.structure.wrong.get(at)
            if wrong is not None:
                raise FlowFault(wrong, word.place)
            if not isinstance(word.label, str):
                raise FlowFault(f"the label of {word.keyword} must be written out", word.place)
            _STEPS[word.keyword](self, word, at)

    def jump(self, index: int) -> None:
        """Go on at a line; going back is counted."""
        if index < self.index:
            self._again(self.index - index)
        self.index = index

    def _again(self, lines: int) -> None:
        """Count lines that are run again."""
        try:
            self.controller.spend(lines, "lines are run again and again", 0)
        except BlockFault as fault:
            raise FlowFault(fault.message, 0) from None

    def value(self, word: OWord) -> float:
        """The one value behind a word."""
        if len(word.values) != 1:
            raise FlowFault(f"{word.keyword} needs one value in brackets [...]", word.place)
        try:
            return computed(word.values[0], self.memory)
        except BlockFault as fault:
            raise FlowFault(fault.message, fault.place) from None

    def _label(self, word: OWord) -> str:
        if isinstance(word.label, str):
            return word.label
        return str(whole(computed(word.label, self.memory), word.place, "a label"))

    def idle(self, loop: int, place: int) -> None:
        """Count passes of a loop in which nothing changes.

        Raises
        ------
        FlowFault
            There were too many of them.
        """
        state = (self.memory.changes, tuple(self.controller.at))
        last, count = self.passes.get(loop, (None, 0))
        count = count + 1 if last == state else 0
        self.passes[loop] = (state, count)
        if count > IDLE_PASSES:
            raise FlowFault(f"endless loop: in {IDLE_PASSES} passes no variable and no position has changed", place)

    # calls

    def _call(self, word: OWord, label: str) -> None:
        source, at = self._subroutine(label, word.place)
        wrong = source.structure.wrong.get(at)
        if wrong is not None:
            raise BlockFault(f"subroutine {label} of line {at + 1}: {wrong}", word.place)
        arguments = [computed(value, self.memory) for value in word.values]
        if len(arguments) > LOCAL:
            raise BlockFault(f"{len(arguments)} arguments; a subroutine takes {LOCAL} at most", word.place)
        self._enter(source, at + 1, word.place, numbered=False, arguments=arguments)

    def _subroutine(self, label: str, place: int) -> tuple[Source, int]:
        for source in (self.source, self.main):
            if label in source.structure.subroutines:
                return source, source.structure.subroutines[label]
            if label in source.structure.programs and source is self.main:
                raise BlockFault(f"O{label} is a program that ends with M99; call it with M98 P{label}", place)
        source_of_file = self._file(label)
        if source_of_file is not None and label in source_of_file.structure.subroutines:
            return source_of_file, source_of_file.structure.subroutines[label]
        where = f"and no file {label}.ngc beside the program" if source_of_file is None else f"not even in {label}.ngc"
        raise BlockFault(f"there is no subroutine {label} in the program, {where}", place)

    def _file(self, label: str) -> Source | None:
        if label not in self.files:
            library = self.controller.setup.library
            text = library(label) if library is not None else None
            self.files[label] = None if text is None else Source(f"{label}.ngc", text)
        return self.files[label]

    def call_program(self, label: str, runs: int, place: int) -> None:
        """M98."""
        if runs == 0:
            return
        source = self.source if label in self.source.structure.programs else self.main
        if label in source.structure.subroutines:
            raise BlockFault(f"O{label} is a subroutine (sub, endsub); call it with O{label} call", place)
        at = source.structure.programs.get(label)
        if at is None:
            raise BlockFault(f"there is no program O{label} that ends with M99", place)
        self._enter(source, at + 1, place, numbered=True, arguments=(), runs=runs)

    def _enter(
        self, source: Source, index: int, place: int, *, numbered: bool, arguments: Sequence[float], runs: int = 1
    ) -> None:
        if len(self.frames) + 1 >= DEEPEST:
            raise FlowFault(f"subroutines are called {DEEPEST} levels deep; do they call one another for ever?", place)
        c, m = self.controller, self.memory
        kept = {} if numbered else {i: c.numbers.pop(i) for i in range(1, LOCAL + 1) if i in c.numbers}
        self.frames.append(
            Frame(self.source, self.index, numbered, index, kept, m.named_locals, self.repeats, self.passes)
        )
        self.runs_left.append(runs - 1)
        self.repeats, self.passes = {}, {}
        if not numbered:
            m.named_locals, m.returned = {}, None
            c.numbers.update(enumerate(arguments, start=1))
        m.level, m.changes = m.level + 1, m.changes + 1
        c.saves.append(None)
        c.restores.append(False)
        self.source, self.index = source, index

    def leave(self) -> None:
        """Back to the line behind the call."""
        c, m = self.controller, self.memory
        to, restores = c.saves.pop(), c.restores.pop()
        if to is not None and restores:
            modes.restore(c, to)
        frame = self.frames.pop()
        self.runs_left.pop()
        self._again(max(1, self.index - frame.start))  # of a subroutine: it stands in the file once
        if not frame.numbered:
            for i in range(1, LOCAL + 1):
                c.numbers.pop(i, None)
            c.numbers.update(frame.numbers)
            m.named_locals = frame.named
        m.level -= 1
        self.repeats, self.passes = frame.repeats, frame.passes
        self.source, self.index = frame.source, frame.line

    def end_program(self, place: int) -> bool:
        """M99: back from a program called by M98, or once more; whether it was the main program that ended."""
        if not self.frames:
            return True
        frame = self.frames[-1]
        if not frame.numbered:
            raise BlockFault("M99 in a subroutine (sub); it ends with endsub or return", place)
        if self.runs_left[-1] > 0:
            self.runs_left[-1] -= 1
            self.jump(frame.start)
        else:
            self.leave()
        return False


def _sub(flow: Flow, word: OWord, at: int) -> None:
    if flow.numbered and not flow.frames:
        raise FlowFault("subroutine within a numbered main program; end that with M2 or M30 before", word.place)
    flow.index = flow.source.structure.end[at] + 1


def _return(flow: Flow, word: OWord, at: int) -> None:  # noqa: ARG001
    if not flow.frames or flow.frames[-1].numbered:
        raise BlockFault(f"{word.keyword} outside of a subroutine that was called", word.place)
    if len(word.values) > 1:
        raise BlockFault(f"{word.keyword} takes one value in brackets at most", word.place)
    flow.memory.returned = computed(word.values[0], flow.memory) if word.values else None
    flow.leave()


def _if(flow: Flow, word: OWord, at: int) -> None:
    """To the first branch whose condition holds."""
    last = flow.source.structure.end[at]
    taken = flow.value(word) != 0.0
    while not taken and at != last:
        at = flow.source.structure.following[at]
        branch = flow.source.line(at).o_word
        assert branch is not None
        flow.controller.file_line = at + 1
        if flow.source is flow.main:
            flow.controller.line = at + 1
        taken = branch.keyword == "else" or (branch.keyword == "elseif" and flow.value(branch) != 0.0)
    flow.index = at + 1


def _skip(flow: Flow, word: OWord, at: int) -> None:  # noqa: ARG001
    """The branches behind the one that was run."""
    flow.index = flow.source.structure.end[at] + 1


def _nothing(flow: Flow, word: OWord, at: int) -> None:
    """A line that only marks a place."""


def _while(flow: Flow, word: OWord, at: int) -> None:
    structure = flow.source.structure
    begin = structure.begin.get(at)
    holds = flow.value(word) != 0.0
    if begin is not None:  # the end of a do loop
        if holds:
            flow.idle(at, word.place)
            flow.jump(begin + 1)
        else:
            flow.passes.pop(at, None)
    elif holds:
        flow.idle(at, word.place)
    else:
        flow.passes.pop(at, None)
        flow.index = structure.end[at] + 1


def _again(flow: Flow, word: OWord, at: int) -> None:  # noqa: ARG001
    """endwhile: back to the condition."""
    flow.jump(flow.source.structure.begin[at])


def _repeat(flow: Flow, word: OWord, at: int) -> None:
    times = round(flow.value(word))
    if times < 1:
        flow.index = flow.source.structure.end[at] + 1
    else:
        flow.repeats[at] = times - 1


def _end_repeat(flow: Flow, word: OWord, at: int) -> None:  # noqa: ARG001
    begin = flow.source.structure.begin[at]
    if flow.repeats.get(begin, 0) > 0:
        flow.repeats[begin] -= 1
        flow.jump(begin + 1)


def _break(flow: Flow, word: OWord, at: int) -> None:  # noqa: ARG001
    structure = flow.source.structure
    flow.passes.clear()
    flow.index = structure.end[structure.begin[at]] + 1


def _continue(flow: Flow, word: OWord, at: int) -> None:  # noqa: ARG001
    structure = flow.source.structure
    flow.jump(structure.end[structure.begin[at]])


_STEPS: dict[str, Callable[[Flow, OWord, int], None]] = {
    "sub": _sub, "endsub": _return, "return": _return, "if": _if, "elseif": _skip, "else": _skip, "endif": _nothing,
    "while": _while, "endwhile": _again, "do": _nothing, "repeat": _repeat, "endrepeat": _end_repeat, "break": _break,
    "continue": _continue,
}  # fmt: skip
