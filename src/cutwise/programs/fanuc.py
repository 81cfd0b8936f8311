"""Fanuc programs with custom macro B, run into canonical commands.

The words of motion are those of RS274/NGC (:mod:`.fanuc_words` tells the differences); variables, expressions, GOTO, IF,
WHILE and macro calls are those of macro B as the operator's manuals of the series 0i, 16i and 30i document them.
"""

import re

from cutwise.programs import execution
from cutwise.programs.block import Block, computed_block
from cutwise.programs.canon import Comment, Message, Stop
from cutwise.programs.expressions import BlockFault, FlowFault
from cutwise.programs.fanuc_words import Given, adapted
from cutwise.programs.macro_flow import MacroFlow, arguments_of
from cutwise.programs.macro_memory import MacroMemory
from cutwise.programs.macro_source import MacroSource
from cutwise.programs.macro_values import computed, index_of
from cutwise.programs.macro_words import Assignment, MacroLine
from cutwise.programs.rs274 import Rs274
from cutwise.programs.setup import Setup
from cutwise.programs.words import Notice, Word

_SIGNS = re.compile(
    r"^[ \t]*(?:/\d?[ \t]*)?(?:N\d+[ \t]*)?(?:(?P<if>IF[ \t]*\[[^\n]*\][ \t]*(?:GOTO|THEN))|(?P<goto>GOTO[ \t]*[\d#\[])"
    r"|(?P<while>WHILE[ \t]*\[[^\n]*\][ \t]*DO[ \t]*\d)|(?P<end>END[ \t]*[123][ \t]*;?[ \t]*\r?$)"
    r"|(?P<alarm>#[ \t]*300[06][ \t]*=)|(?:G\d+[ \t]*)*(?P<call>G6[56][ \t]*P))",
    re.IGNORECASE | re.MULTILINE,
)
_ASSIGNED = re.compile(
    r"^[ \t]*(?:/\d?[ \t]*)?(?:N\d+[ \t]*)?#[ \t]*[\d\[#][^=\n(;]*=(?P<value>[^\n(;]*)", re.IGNORECASE | re.MULTILINE
)
_NAMES = {
    "if": "IF [...] GOTO",
    "goto": "GOTO",
    "while": "WHILE [...] DO",
    "end": "END",
    "alarm": "#3000",
    "call": "G65",
}
_NO_POINT = re.compile(r"[XYZIJRUVWQ][ \t]*[-+]?0*[1-9]\d*(?![\d.])", re.IGNORECASE)
_COMMENTS = re.compile(r"\([^()\n]*\)")
_LONG_NUMBER = 10_000  # M98 P51234: O1234, five times


def macro_sign(text: str) -> tuple[int, str] | None:
    """Where a program shows that it is Fanuc macro B, and by what: a line and its statement; None if it does not."""
    match = _SIGNS.search(text)
    if match is not None:
        kind = next(name for name, found in match.groupdict().items() if found is not None)
        return text.count("\n", 0, match.start(kind)) + 1, _NAMES[kind]
    for found in _ASSIGNED.finditer(text):
        if _has_open_operator(found["value"]):
            return text.count("\n", 0, found.start("value")) + 1, "arithmetic without brackets (#1=#1+1)"
    return None


def _has_open_operator(text: str) -> bool:
    """Whether an operator stands between two values outside of all brackets: RS274/NGC wants brackets round it."""
    depth, last = 0, ""
    for at, letter in enumerate(text):
        if letter in "[]":
            depth += 1 if letter == "[" else -1
        elif depth == 0 and letter in "+-*/" and (last.isdigit() or last in ".]"):
            atan = letter == "/" and last == "]" and text[at + 1 :].lstrip().startswith("[")  # ATAN[y]/[x]
            if last and not atan:
                return True
        last = last if letter in " \t" else letter
    return False


class Fanuc(Rs274):
    """A run through a Fanuc program.

    :meth:`commands` gives its commands; when they are used up, :meth:`notices` tells what was assumed.
    """

    branches = True

    def __init__(self, text: str, name: str, setup: Setup = Setup()) -> None:  # noqa: B008
        super().__init__(text, name, setup)
        main = MacroSource(name, text)
        c = self.controller
        c.stores_cycles = True
        self.macros = MacroMemory(c)
        self.calls = MacroFlow(c, self.macros, main, main, main.first)
        self.flow = self.calls  # type: ignore[assignment]
        self.begun = False
        self._say_decimals(text)

    def _say_decimals(self, text: str) -> None:
        for number, line in enumerate(text.split("\n"), start=1):
            if _NO_POINT.search(line) and "#" not in line and "G65" not in line.upper():
                match = _NO_POINT.search(_COMMENTS.sub("", line))
                if match is not None:
                    self.controller.notices[
                        f'"{match.group()}" has no decimal point; such numbers are taken as whole units, as a calculator '
                        "does (parameter 3401.0 = 1), not as least increments"
                    ] = number
                    return

    def _run_line(self, source: MacroSource, at: int) -> None:  # type: ignore[override]
        line = source.line(at)
        c, m = self.controller, self.macros
        c.number = line.number
        if line.number:
            m.words["n"] = float(line.number[-9:])
        if line.program:
            self._header(line)
            return
        self.begun = self.begun or bool(line.words or line.assignments or line.control)
        if line.notice is not None and not line.assignments:
            c.out.append(Comment(line.notice.text, c.line, c.number))
        if line.output:
            c.notice(f"{line.output} writes to another device; it is left out")
        elif line.control is not None:
            self.calls.follow(line.control)
            if line.control.then and computed(line.control.condition or 1.0, m):
                self._assign(line.control.then, line.notice)
        elif line.assignments:
            self._assign(line.assignments, line.notice)
        elif line.words:
            self._macro_block(line)

    def _header(self, line: MacroLine) -> None:
        if self.calls.frames:
            raise FlowFault(f"the program ends before O{line.program} without M99", 0)
        if self.begun:
            self._end_of_file()
            return
        self.macros.words["o"] = float(line.program[-9:])

    def _assign(self, assignments: tuple[Assignment, ...], notice: Notice | None) -> None:
        m = self.macros
        for key, value, place in assignments:
            index, number = index_of(key, m, place), computed(value, m)
            if index in (3000, 3006):
                self._speak(index, number or 0.0, "" if notice is None else notice.text, place)
            else:
                m.assign(index, number, place)

    def _speak(self, index: int, number: float, text: str, place: int) -> None:
        """#3000: an alarm; #3006: a stop with a message."""
        c = self.controller
        if index == 3000:
            raise FlowFault(f"the program raises alarm {3000 + number:g}: {text or 'no message'}", place)
        c.out.append(Message(text, c.line, c.number))
        c.out.append(Stop("stop", c.line, c.number))

    def _macro_block(self, line: MacroLine) -> None:
        m = self.macros
        given: list[Given] = [
            (letter, number, place) for letter, value, place in line.words if (number := computed(value, m)) is not None
        ]
        self.blocks += 1
        for letter, number, _ in given:
            if letter in "dhmt":
                m.words[letter] = number
        if any(letter == "g" and number == 65.0 for letter, number, _ in given):
            self._call_macro(given)
            return
        stop = next((g for g in given if g[0] == "m" and g[1] in (98.0, 99.0)), None)
        if stop is None:
            self._run_words(given)
            return
        rest = [g for g in given if g is not stop and g[0] not in ("p", "l")]
        if rest:
            self._run_words(rest)
        numbers = {letter: (number, place) for letter, number, place in given if letter in ("p", "l")}
        if stop[1] == 98.0:
            self._call_subprogram(numbers, stop[2])
        else:
            self._return(numbers, stop[2])

    def _run_words(self, given: list[Given]) -> None:
        words = [Word(letter, number, place) for letter, number, place in adapted(self.controller, given)]
        if words:
            self._execute(computed_block(words, self.memory))

    def _call_macro(self, given: list[Given]) -> None:
        """G65 P L and its arguments."""
        at = next(i for i, (letter, number, _) in enumerate(given) if letter == "g" and number == 65.0)
        place = given[at][2]
        if any(letter in "pl" or letter not in "gm" for letter, _, _ in given[:at]):
            raise BlockFault("arguments stand behind G65", given[0][2])
        if at:
            self._run_words(given[:at])
        numbers = {letter: (number, where) for letter, number, where in given if letter in ("p", "l")}
        words = [g for g in given[at + 1 :] if g[0] not in ("p", "l")]
        if "p" not in numbers:
            raise BlockFault("G65 needs the number of a program P", place)
        runs = _whole(numbers["l"], "L") if "l" in numbers else 1
        self.calls.call(str(_whole(numbers["p"], "P")), runs, place, arguments_of(words))

    def _call_subprogram(self, numbers: dict[str, tuple[float, int]], place: int) -> None:
        if "p" not in numbers:
            raise BlockFault("M98 needs the number of a program P", place)
        label = _whole(numbers["p"], "P")
        runs = _whole(numbers["l"], "L") if "l" in numbers else 1
        if "l" not in numbers and label >= _LONG_NUMBER:
            runs, label = divmod(label, _LONG_NUMBER)
        self.calls.call(str(label), runs, place)

    def _return(self, numbers: dict[str, tuple[float, int]], place: int) -> None:
        if self.calls.leave(numbers["p"][0] if "p" in numbers else None, place):
            self.controller.notice("M99 in the main program begins it anew; it is run once")
            execution.end(self.controller, shuttle=False)
            self.ended = True

    def _execute(self, block: Block) -> None:
        super()._execute(block)
        if self.ended:  # M2 and M30 leave local variables vacant
            self.macros.local.clear()


def _whole(given: tuple[float, int], letter: str) -> int:
    value, place = given
    if abs(value - round(value)) > 1e-6 or value < 0.0:
        raise BlockFault(f"{letter} must be a whole number, not {value:g}", place)
    return round(value)
