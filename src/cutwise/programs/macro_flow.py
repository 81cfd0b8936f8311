"""Where a Fanuc program goes on: GOTO, loops, subprograms (M98, M99) and macro calls (G65)."""

from dataclasses import dataclass, field
from typing import NamedTuple

from cutwise.programs.controller import Controller
from cutwise.programs.expressions import BlockFault, FlowFault
from cutwise.programs.flow import DEEPEST, IDLE_PASSES
from cutwise.programs.macro_memory import MacroMemory
from cutwise.programs.macro_source import MacroSource
from cutwise.programs.macro_values import computed, filled
from cutwise.programs.macro_words import Control

MACRO_LEVELS = 5  # of local variables: the main program and four macros within one another

ARGUMENTS = {
    "a": 1, "b": 2, "c": 3, "d": 7, "e": 8, "f": 9, "h": 11, "i": 4, "j": 5, "k": 6, "m": 13, "q": 17, "r": 18, "s": 19,
    "t": 20, "u": 21, "v": 22, "w": 23, "x": 24, "y": 25, "z": 26,
}  # fmt: skip
"""Argument list I: letters of G65 and the local variables that they become."""
_GROUPS = 10  # of I J K in argument list II


class Frame(NamedTuple):
    """A call: where it came from, and what is put back at its end."""

    source: MacroSource
    line: int  # index of the line behind the call
    start: int  # first line of the program that was called
    local: dict[int, float] | None  # local variables of the caller; None: a subprogram, which shares them
    arguments: dict[int, float]


@dataclass(slots=True)
class MacroFlow:
    """Where a program stands."""

    controller: Controller
    memory: MacroMemory
    main: MacroSource
    source: MacroSource
    index: int  # of the next line
    frames: list[Frame] = field(default_factory=list)
    runs_left: list[int] = field(default_factory=list)
    passes: dict[tuple[int, int], tuple[object, int]] = field(default_factory=dict)
    files: dict[str, MacroSource | None] = field(default_factory=dict)

    def follow(self, control: Control) -> None:
        """Go where a statement of the line before ``index`` leads.

        Raises
        ------
        FlowFault
            It does not fit, or its condition cannot be computed.
        """
        at = self.index - 1
        wrong = self.source.layout.wrong.get(at)
        if wrong is not None:
            raise FlowFault(wrong, control.place)
        try:
            holds = control.condition is None or bool(computed(control.condition, self.memory))
            if control.kind == "goto" and holds:
                assert control.target is not None
                self.go_to(filled(control.target, self.memory), control.place)
        except BlockFault as fault:
            raise FlowFault(fault.message, fault.place) from None
        layout = self.source.layout
        if control.kind in ("while", "do"):
            if not holds:
                self.index = layout.end[at] + 1
        elif control.kind == "end":
            self._back(layout.begin[at], control.place)

    def go_to(self, sequence: float, place: int) -> None:
        """GOTO: to a block of the same program, the next one with that number, else the first."""
        if abs(sequence - round(sequence)) > 1e-6 or sequence < 0.0:
            raise FlowFault(f"GOTO needs the number of a block, not {sequence:g}", place)
        at, layout = self.index - 1, self.source.layout
        lines = layout.sequences[layout.program_of(at)].get(str(round(sequence)), [])
        if not lines:
            raise FlowFault(f"there is no block N{round(sequence)} in this program to go to", place)
        to = next((line for line in lines if line > at), lines[0])
        inside = layout.loops_around(to) - layout.loops_around(at) - {at}
        if inside:
            raise FlowFault(
                f"GOTO into the loop that begins in line {min(inside) + 1}; a loop is entered at its DO", place
            )
        if to <= at:
            self._back(to, place)
        else:
            self.index = to

    def _back(self, to: int, place: int) -> None:
        """Go on at a line that was run already; counted, and refused where nothing changes any more."""
        key = (id(self.source), self.index)
        state = (self.memory.changes, tuple(self.controller.at), len(self.frames))
        last, count = self.passes.get(key, (None, 0))
        count = count + 1 if last == state else 0
        self.passes[key] = (state, count)
        if count > IDLE_PASSES:
            raise FlowFault(f"endless loop: in {IDLE_PASSES} passes no variable and no position has changed", place)
        self._again(self.index - to)
        self.index = to

    def _again(self, lines: int) -> None:
        try:
            self.controller.spend(lines, "lines are run again and again", 0)
        except BlockFault as fault:
            raise FlowFault(fault.message, 0) from None

    def call(self, label: str, runs: int, place: int, arguments: dict[int, float] | None = None) -> None:
        """M98, or G65 where there are arguments."""
        source, at = self._program(label, place)
        if runs < 1:
            return
        macros = sum(frame.local is not None for frame in self.frames)
        if len(self.frames) + 1 >= DEEPEST or (arguments is not None and macros + 1 >= MACRO_LEVELS):
            raise FlowFault(
                f"programs are called {len(self.frames) + 1} levels deep; do they call one another for ever?", place
            )
        m = self.memory
        kept = None if arguments is None else m.local
        self.frames.append(Frame(self.source, self.index, at + 1, kept, arguments or {}))
        self.runs_left.append(runs - 1)
        if arguments is not None:
            m.local = dict(arguments)
        m.changes += 1
        self.source, self.index = source, at + 1

    def _program(self, label: str, place: int) -> tuple[MacroSource, int]:
        for source in (self.source, self.main):
            if label in source.layout.programs:
                return source, source.layout.programs[label]
        found = self._file(label)
        if found is None:
            raise FlowFault(f"there is no program O{label} in the file, and no file O{label}.nc beside it", place)
        return found, found.layout.programs.get(label, found.first - 1)

    def _file(self, label: str) -> MacroSource | None:
        if label not in self.files:
            library, text, name = self.controller.setup.library, None, ""
            for name in file_names(label):
                text = library(name) if library is not None else None
                if text is not None:
                    break
            self.files[label] = None if text is None else MacroSource(f"{name}.nc", text)
        return self.files[label]

    def leave(self, sequence: float | None, place: int) -> bool:
        """M99: back to the caller, or once more; whether it was the main program that ended."""
        if not self.frames:
            if sequence is None:
                return True
            self.go_to(sequence, place)
            return False
        frame, m = self.frames[-1], self.memory
        self._again(max(1, self.index - frame.start))  # of a program that is called: it stands in the file once
        if self.runs_left[-1] > 0:
            self.runs_left[-1] -= 1
            if frame.local is not None:
                m.local = dict(frame.arguments)
            self.index = frame.start
            return False
        self.frames.pop()
        self.runs_left.pop()
        if frame.local is not None:
            m.local = frame.local
        self.source, self.index = frame.source, frame.line
        if sequence is not None:
            self.go_to(sequence, place)
        return False


def file_names(label: str) -> tuple[str, ...]:
    """Names without suffix that the file of a program may have."""
    return f"o{label}", f"o{label:0>4}", label, f"{label:0>4}"


def arguments_of(words: list[tuple[str, float, int]]) -> dict[int, float]:
    """Local variables from the arguments of G65, by argument list I (letters) and II (A B C, then I J K over and over).

    I J K stand for #4 #5 #6; when they come again, or out of their order, for the next three. Of two arguments for one
    variable the later one counts.

    Raises
    ------
    BlockFault
        A letter that is no argument, or I J K more than ten times.
    """
    found: dict[int, float] = {}
    group, last = 0, -1
    for letter, value, place in words:
        if letter in "ijk":
            rank = "ijk".index(letter)
            group += rank <= last
            last = rank
            if group >= _GROUPS:
                raise BlockFault(f"I J K stand more than {_GROUPS} times in one macro call", place)
            found[4 + 3 * group + rank] = value
        elif letter in ARGUMENTS:
            found[ARGUMENTS[letter]] = value
        else:
            raise BlockFault(f"{letter.upper()} is no argument of G65", place)
    return found
