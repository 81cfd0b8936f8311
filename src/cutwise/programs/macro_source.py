"""A Fanuc program file: its programs (O numbers), its sequence numbers and its loops."""

import bisect
import re
from functools import cached_property
from typing import NamedTuple

from cutwise.programs.expressions import BlockFault
from cutwise.programs.macro_words import LEVELS, MacroLine, read_macro_line
from cutwise.programs.source import ProgramLines

_HEADER = re.compile(r"\s*(?:/\d?\s*)?(?:[nN]\d+\s*)?[oO:]\s*(\d+)")
_SEQUENCE = re.compile(r"\s*(?:/\d?\s*)?[nN]\s*(\d+)")
_LOOP = re.compile(r"(?<![A-Za-z])(?:DO|END|EN|WHILE|WH)", re.IGNORECASE)


class Layout(NamedTuple):
    """Where flow control goes; places are indices of lines."""

    programs: dict[str, int]  # number: its line
    starts: list[int]  # first lines of all programs, ascending
    sequences: list[dict[str, list[int]]]  # of each program: sequence number: its lines
    end: dict[int, int]  # DO, WHILE: its END
    begin: dict[int, int]  # END: its DO or WHILE
    inner: dict[int, int]  # lines within a loop: the innermost one
    outer: dict[int, int]  # loops within a loop: the next outer one
    wrong: dict[int, str]  # lines whose DO or END does not fit

    def program_of(self, line: int) -> int:
        """Which of the programs a line belongs to."""
        return max(0, bisect.bisect_right(self.starts, line) - 1)

    def loops_around(self, line: int) -> frozenset[int]:
        """The loops that a line stands in."""
        found, loop = set(), self.inner.get(line)
        while loop is not None:
            found.add(loop)
            loop = self.outer.get(loop)
        return frozenset(found)


class MacroSource(ProgramLines[MacroLine]):
    """A program file of the dialect fanuc."""

    reader = staticmethod(read_macro_line)

    @cached_property
    def layout(self) -> Layout:
        """Its programs, sequence numbers and loops."""
        return _laid_out(self)


def _laid_out(source: MacroSource) -> Layout:
    layout = Layout({}, [source.first], [{}], {}, {}, {}, {}, {})
    open_loops: list[tuple[int, int]] = []  # number, line
    for at in range(source.first, source.end):
        raw = source.lines[at]
        header = _HEADER.match(raw)
        if header is not None:
            _left_open(layout, open_loops)
            layout.programs.setdefault(header[1].lstrip("0") or "0", at)
            if at > source.first:
                layout.starts.append(at)
                layout.sequences.append({})
            continue
        sequence = _SEQUENCE.match(raw)
        if sequence is not None:
            layout.sequences[-1].setdefault(sequence[1].lstrip("0") or "0", []).append(at)
        if _LOOP.search(raw):
            _loop(source, layout, open_loops, at)
        if open_loops and at != open_loops[-1][1]:
            layout.inner[at] = open_loops[-1][1]
    _left_open(layout, open_loops)
    return layout


def _loop(source: MacroSource, layout: Layout, open_loops: list[tuple[int, int]], at: int) -> None:
    try:
        control = source.line(at).control
    except BlockFault:
        return  # said when the line is run
    if control is None:
        return
    if control.kind in ("do", "while"):
        same = next((line for number, line in open_loops if number == control.loop), None)
        if same is not None:
            layout.wrong[at] = f"DO{control.loop} of line {same + 1} is still open; a loop within it has another number"
            return
        assert len(open_loops) < LEVELS
        if open_loops:
            layout.outer[at] = open_loops[-1][1]
        open_loops.append((control.loop, at))
    elif control.kind == "end":
        if not open_loops or open_loops[-1][0] != control.loop:
            crossed = next((line for number, line in open_loops if number == control.loop), None)
            if crossed is None:
                layout.wrong[at] = f"END{control.loop} without its DO{control.loop}"
            else:
                number, line = open_loops[-1]
                layout.wrong[crossed] = (
                    f"this loop ends in line {at + 1} and crosses DO{number} of line {line + 1}, which is still open there"
                )
            return
        _, begin = open_loops.pop()
        layout.inner[at] = begin
        layout.end[begin], layout.begin[at] = at, begin


def _left_open(layout: Layout, open_loops: list[tuple[int, int]]) -> None:
    for number, line in open_loops:
        layout.wrong.setdefault(line, f"DO{number} without its END{number}")
    open_loops.clear()
