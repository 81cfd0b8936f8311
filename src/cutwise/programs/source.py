"""A program file as lines, and the structure that its O words give it."""

import re
from collections.abc import Callable
from functools import cached_property
from typing import Generic, NamedTuple, TypeVar

from cutwise.programs.expressions import BlockFault
from cutwise.programs.words import Line, Notice, OWord, compact, read_line

_O_LINE = re.compile(r"/?(?:n[\d.]*)?o")
_MOTION = re.compile(r"[^(;%]*[XYZABCUVW][ \t]*[-+.\d#\[]", re.IGNORECASE)
_REMEMBERED = 20_000  # lines
_CLOSES = {"endif": "if", "endwhile": "while", "endrepeat": "repeat", "endsub": "sub"}


class Structure(NamedTuple):
    """Where flow control goes; places are indices of lines."""

    subroutines: dict[str, int]  # label: its sub
    programs: dict[str, int]  # label: O number of a program that ends with M99
    following: dict[int, int]  # if, elseif, else: the next branch of the same if, its endif at last
    end: dict[int, int]  # sub, if and its branches, loops, break, continue: the line that closes it
    begin: dict[int, int]  # lines that close, break, continue: what they belong to
    wrong: dict[int, str]  # lines whose O word does not fit


Read = TypeVar("Read")


class ProgramLines(Generic[Read]):
    """A program file of any dialect: its name, its lines as read, and which of them are to be run."""

    reader: Callable[[str, Notice | None], Read]
    """A line without its blanks, and its notice, as the dialect means them."""

    def __init__(self, name: str, text: str) -> None:
        self.name = name
        self.lines = text.split("\n")
        self.first, self.end, self.framed = extent(self.lines)
        self._known: dict[int, Read] = {}

    def line(self, at: int) -> Read:
        """A line as read; remembered, since lines in loops are run again.

        Raises
        ------
        BlockFault
            It cannot be read.
        """
        known = self._known.get(at)
        if known is None:
            text, notice = compact(self.lines[at])
            try:
                known = self.reader(text, notice)
            except RecursionError:
                raise BlockFault("brackets nested too deeply", 0) from None
            if len(self._known) >= _REMEMBERED:
                self._known.clear()
            self._known[at] = known
        return known


class Source(ProgramLines[Line]):
    """A program file of RS274."""

    reader = staticmethod(read_line)

    @cached_property
    def structure(self) -> Structure:
        """The structure of its O words."""
        return _Scan(self).structure


def motions_between(lines: list[str], first: int, end: int) -> tuple[int, int]:
    """How many lines from the first up to one before the end hold axis words, and the first of them (from 1).

    A line with an O word, where a subroutine begins that is called from elsewhere, ends the search.
    """
    count = line = 0
    for at in range(first, end):
        if _O_LINE.match("".join(lines[at].split()).lower()):
            break
        if _MOTION.match(lines[at]):
            count, line = count + 1, line or at + 1
    return count, line


def extent(lines: list[str]) -> tuple[int, int, bool]:
    """First line to run, the one behind the last, and whether ``%`` lines say so."""
    start = next((at for at, line in enumerate(lines) if line.strip(" \t\r\ufeff")), len(lines))
    framed = start < len(lines) and lines[start].lstrip(" \t\ufeff").startswith("%")
    first = start + 1 if framed else 0
    closing = (at for at in range(first, len(lines)) if "%" in lines[at] and lines[at].lstrip().startswith("%"))
    end = next(closing, None)
    return first, len(lines) if end is None else end, framed and end is not None


class _Open(NamedTuple):
    """A structure that has begun and not ended."""

    keyword: str
    label: str
    at: int
    branches: list[int]


class _Scan:
    """Finds what belongs together, innermost first."""

    def __init__(self, source: Source) -> None:
        self.structure = Structure({}, {}, {}, {}, {}, {})
        self.open: list[_Open] = []
        self.known: dict[str, int] = {}
        for at in range(source.first, source.end):
            word = _o_word(source.lines[at])
            if word is not None and isinstance(word.label, str):
                self._place(at, word.keyword, word.label)
        for left in self.open:
            self.structure.wrong.setdefault(left.at, f"{left.keyword} without its {_closing(left.keyword)}")

    def _place(self, at: int, keyword: str, label: str) -> None:
        if keyword == "":
            self.structure.programs.setdefault(label, at)
        elif keyword in ("sub", "if", "do", "repeat") or (keyword == "while" and not self._closes_do(label)):
            self._begin(at, keyword, label)
        elif keyword in ("elseif", "else"):
            self._branch(at, keyword, label)
        elif keyword in ("break", "continue"):
            self._leave(at, keyword, label)
        elif keyword in _CLOSES or keyword == "while":
            self._close(at, keyword, label)

    def _closes_do(self, label: str) -> bool:
        return bool(self.open) and self.open[-1].keyword == "do" and self.open[-1].label == label

    def _begin(self, at: int, keyword: str, label: str) -> None:
        wrong = self.structure.wrong
        if label in self.known:
            wrong[at] = f"label {label} is in use already, in line {self.known[label] + 1}; take another one"
        self.known[label] = at
        if keyword == "sub":
            outer = next((other for other in self.open if other.keyword == "sub"), None)
            if outer is not None:
                wrong[outer.at] = f"holds another subroutine, in line {at + 1}; define that one before or after"
            self.structure.subroutines.setdefault(label, at)
        self.open.append(_Open(keyword, label, at, [at]))

    def _branch(self, at: int, keyword: str, label: str) -> None:
        if not self.open or self.open[-1].keyword != "if" or self.open[-1].label != label:
            self.structure.wrong[at] = f"{keyword} without its if"
            return
        self.structure.following[self.open[-1].branches[-1]] = at
        self.structure.begin[at] = self.open[-1].at
        self.open[-1].branches.append(at)

    def _leave(self, at: int, keyword: str, label: str) -> None:
        loop = next((outer for outer in reversed(self.open) if outer.label == label), None)
        if loop is None or loop.keyword not in ("while", "do"):
            self.structure.wrong[at] = f"{keyword} outside of a while loop with its label"
            return
        self.structure.begin[at] = loop.at

    def _close(self, at: int, keyword: str, label: str) -> None:
        opening = "do" if keyword == "while" else _CLOSES[keyword]
        if not self.open or self.open[-1].keyword != opening or self.open[-1].label != label:
            self.structure.wrong[at] = f"{keyword} without its {opening}" + self._instead()
            return
        opened = self.open.pop()
        self.structure.begin[at] = opened.at
        if opening == "if":
            self.structure.following[opened.branches[-1]] = at
        for branch in opened.branches:
            self.structure.end[branch] = at

    def _instead(self) -> str:
        if not self.open:
            return ""
        last = self.open[-1]
        return f"; {last.keyword} {last.label} of line {last.at + 1} is still open"


def _closing(keyword: str) -> str:
    return "while" if keyword == "do" else f"end{keyword}"


def _o_word(raw: str) -> OWord | None:
    if "o" not in raw and "O" not in raw:
        return None
    try:
        text = compact(raw).text
        return read_line(text, None).o_word if _O_LINE.match(text) else None
    except (BlockFault, RecursionError):
        return None  # said when the line is run
