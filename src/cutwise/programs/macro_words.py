"""One line of a Fanuc program into its words and macro statements: read once, computed whenever it is run."""

import re
from typing import Literal, NamedTuple

from cutwise.programs.expressions import BlockFault, in_scale
from cutwise.programs.macro_values import Read, Value, read_expression, read_value
from cutwise.programs.words import Notice

LETTERS = "abcdefghijklmpqrstuvwxyz"
LEVELS = 3  # of loops: DO1 to DO3

_SEQUENCE = re.compile(r"(?:/\d?)?(?:n(\d+))?(?:/\d?)?")
_NUMBER_WORD = re.compile(r"([a-mp-z])([+-]?(?:\d{1,30}(?:\.\d*)?|\.\d{1,30}))(?![\d.])")
_BEGINS_VALUE = re.compile(r"[-+.\d#\[]|[a-z]+\[")
_OUTPUT = re.compile(r"popen|pclos|dprnt|bprnt|setvn")
_UNKNOWN = {
    "o": "a program number (O) stands alone in its line",
    "n": "N stands at the beginning of its line",
    "@": "polar words (@ ^) are of another dialect",
    "^": "polar words (@ ^) are of another dialect",
    ",": "chamfers and corners within a block (,C ,R) are not supported; write the contour out",
    "=": "only variables (#) are assigned",
    "<": "variables with names are of another dialect (rs274)",
}

Kind = Literal["goto", "while", "do", "end", "if"]


class MacroWord(NamedTuple):
    """A letter and its value."""

    letter: str
    value: Value
    place: int  # in the compact text


class Assignment(NamedTuple):
    """``#key = value``."""

    key: Value
    value: Value
    place: int


class Control(NamedTuple):
    """A statement that says where the program goes on."""

    kind: Kind
    place: int
    condition: Value | None = None
    target: Value | None = None  # of GOTO: a sequence number
    loop: int = 0  # of DO and END
    then: tuple[Assignment, ...] = ()


class MacroLine(NamedTuple):
    """A line as read."""

    words: tuple[MacroWord, ...] = ()
    assignments: tuple[Assignment, ...] = ()
    control: Control | None = None
    notice: Notice | None = None
    number: str = ""  # digits of the N word
    program: str = ""  # digits of the O word
    output: str = ""  # a statement that writes out: DPRNT and its kind


def read_macro_line(text: str, notice: Notice | None) -> MacroLine:
    """The words or macro statements of a compact text.

    Raises
    ------
    BlockFault
        Something in it cannot be read.
    """
    match = _SEQUENCE.match(text)
    assert match is not None
    number, at = match[1] or "", match.end()
    rest = text[at:]
    if rest[:1] in ("o", ":"):
        label = re.match(r"[o:](\d+)", rest)
        if label is None:
            raise BlockFault("O without the number of a program", at)
        if label.end() < len(rest):
            raise BlockFault(_UNKNOWN["o"], at + label.end())
        return MacroLine(notice=notice, number=number, program=label[1].lstrip("0") or "0")
    output = _OUTPUT.match(rest)
    if output is not None:
        return MacroLine(notice=notice, number=number, output=output.group().upper())
    control = _control(text, at)
    if control is not None:
        return MacroLine(control=control, notice=notice, number=number)
    if rest[:1] == "#":
        return MacroLine(assignments=_assignments(text, at), notice=notice, number=number)
    return MacroLine(_words(text, at), notice=notice, number=number)


def _control(text: str, at: int) -> Control | None:
    for word, kind in (("if", "if"), ("while", "while"), ("wh", "while")):
        if text.startswith(word + "[", at):
            condition = read_value(text, at + len(word))
            if not condition.condition:
                raise BlockFault(f"{kind.upper()} needs a comparison (EQ, NE, GT, GE, LT, LE)", at)
            return _behind_if(text, at, condition) if kind == "if" else _behind_while(text, at, condition)
    for word in ("goto", "go"):
        if text.startswith(word, at):
            target = read_expression(text, at + len(word))
            _ends(text, target.end)
            return Control("goto", at, target=target.value)
    do = re.compile(r"(do|end)(\d*)").match(text, at)
    if do is not None:
        _ends(text, do.end())
        return Control("do" if do[1] == "do" else "end", at, loop=_loop(do[2], at))
    return None


def _behind_if(text: str, at: int, condition: Read) -> Control:
    end = condition.end
    for word in ("goto", "go"):
        if text.startswith(word, end):
            target = read_expression(text, end + len(word))
            _ends(text, target.end)
            return Control("goto", at, condition.value, target.value)
    for word in ("then", "th"):
        if text.startswith(word, end):
            if text[end + len(word) : end + len(word) + 1] != "#":
                raise BlockFault("behind THEN stands an assignment (#... = ...)", end)
            return Control("if", at, condition.value, then=_assignments(text, end + len(word)))
    raise BlockFault("behind IF [...] stands GOTO n or THEN", end)


def _behind_while(text: str, at: int, condition: Read) -> Control:
    do = re.compile(r"do(\d*)").match(text, condition.end)
    if do is None:
        raise BlockFault("behind WHILE [...] stands DO and its number", condition.end)
    _ends(text, do.end())
    return Control("while", at, condition.value, loop=_loop(do[1], at))


def _loop(digits: str, at: int) -> int:
    if digits not in ("1", "2", "3"):
        raise BlockFault(f"loops are numbered DO1 to DO{LEVELS}, END1 to END{LEVELS}; found {digits or 'none'}", at)
    return int(digits)


def _ends(text: str, at: int) -> None:
    if at < len(text):
        raise BlockFault(f'"{text[at : at + 8]}": a macro statement stands alone in its block', at)


def _assignments(text: str, at: int) -> tuple[Assignment, ...]:
    found = []
    while at < len(text):
        start = at
        if text[at] != "#":
            raise BlockFault(f'"{text[at : at + 8]}": words and macro statements stand in blocks of their own', at)
        key = read_value(text, at + 1)
        if text[key.end : key.end + 1] != "=":
            raise BlockFault("a variable that no word uses; write #... = value to assign one", start)
        value = read_expression(text, key.end + 1)
        if value.condition:
            raise BlockFault(
                "a condition (EQ, NE, GT, GE, LT, LE) is no number; it belongs into IF and WHILE", key.end + 1
            )
        found.append(Assignment(key.value, value.value, start))
        at = value.end
    return tuple(found)


def _words(text: str, at: int) -> tuple[MacroWord, ...]:
    words = []
    while at < len(text):
        match = _NUMBER_WORD.match(text, at)
        if match is not None:
            words.append(MacroWord(match[1], in_scale(float(match[2]), at), at))
            at = match.end()
            continue
        letter = text[at]
        if letter == "#":
            raise BlockFault("words and macro statements (#... = ...) stand in blocks of their own", at)
        if letter not in LETTERS:
            raise BlockFault(_UNKNOWN.get(letter, f'"{letter}" is not G-code'), at)
        if not _BEGINS_VALUE.match(text, at + 1):
            raise BlockFault(f"word {letter.upper()} has no number", at)
        value, end, condition = read_value(text, at + 1)
        if condition:
            raise BlockFault("a condition (EQ, NE, GT, GE, LT, LE) is no number; it belongs into IF and WHILE", at + 1)
        words.append(MacroWord(letter, value, at))
        at = end
    return tuple(words)
