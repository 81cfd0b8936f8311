"""One line of a program into its words: read once, computed whenever the line is run."""

import re
from collections.abc import Iterator
from typing import Literal, NamedTuple

from cutwise.programs.expressions import BlockFault, CommentFault, Value, in_scale, read_key, read_value
from cutwise.programs.functions import FUNCTIONS

KEYWORDS = (
    "sub", "endsub", "call", "return", "if", "elseif", "else", "endif", "while", "endwhile", "do", "repeat",
    "endrepeat", "break", "continue",
)  # fmt: skip
LETTERS = "abcdefghijklmpqrstuvwxyz@^"

_BLANKS = re.compile(r"[ \t\r\f\v\xa0\ufeff]+")
_KEYWORD = re.compile("|".join(sorted(KEYWORDS, key=len, reverse=True)))
_SEQUENCE = re.compile(r"n(\d*)(?:\.\d*)?")
_DIGITS = re.compile(r"\d+")
_NUMBER_WORD = re.compile(r"([a-mp-z@^])([+-]?(?:\d{1,30}(?:\.\d*)?|\.\d{1,30}))(?![\d.])")
_BEGINS_VALUE = re.compile(rf"[+-]*(?:\d|\.\d|\[|#|{'|'.join([*FUNCTIONS, 'atan', 'exists'])})")

Active = Literal["msg", "abort", "debug", "print", "log", "logopen", "logappend", "logclose"]
_ACTIVE = re.compile(r"\s*(?:(msg|abort|debug|print|log|logopen|logappend),|(logclose)$)", re.IGNORECASE)


class Notice(NamedTuple):
    """The comment of a line, if one counts: its last."""

    text: str
    active: Active | None  # what it does, if anything


class Word(NamedTuple):
    """A letter and its value."""

    letter: str
    value: Value
    place: int  # in the compact text


class Assignment(NamedTuple):
    """``#key = value``."""

    key: Value | str
    value: Value
    place: int


class OWord(NamedTuple):
    """A flow control word: its label, what it does, and the values behind it."""

    label: Value | str
    keyword: str  # empty: the number of a program
    values: tuple[Value, ...]
    place: int


class Line(NamedTuple):
    """A line as read."""

    words: tuple[Word, ...]
    assignments: tuple[Assignment, ...]
    o_word: OWord | None
    notice: Notice | None
    number: str  # digits of the N word


class Compact(NamedTuple):
    """A line without white space, comments and capital letters."""

    text: str
    notice: Notice | None


def compact(raw: str) -> Compact:
    """The text of a line that the machine reads, and its comment: the last one in brackets, or an active one behind ``;``.

    Raises
    ------
    CommentFault
        A comment is not closed, or opened within another.
    """
    if "(" not in raw and ";" not in raw:
        return Compact(_BLANKS.sub("", raw).lower(), None)
    kept: list[str] = []
    bracketed: str | None = None
    behind, at, rest = "", 0, raw.find(";")
    while at < len(raw):
        opened = raw.find("(", at)
        rest = raw.find(";", at) if 0 <= rest < at else rest
        if rest >= 0 and not 0 <= opened < rest:
            kept.append(raw[at:rest])
            behind = raw[rest + 1 :].rstrip("\r\n")
            break
        if opened < 0:
            kept.append(raw[at:])
            break
        closed, again = raw.find(")", opened), raw.find("(", opened + 1)
        if closed < 0:
            raise CommentFault("comment without its closing bracket", opened)
        if 0 <= again < closed:
            raise CommentFault("comment within a comment; close the first one before", again)
        kept.append(raw[at:opened])
        bracketed = raw[opened + 1 : closed]
        at = closed + 1
    return Compact(_BLANKS.sub("", "".join(kept)).lower(), _notice(bracketed, behind))


def _notice(bracketed: str | None, behind: str) -> Notice | None:
    text = behind if bracketed is None else bracketed
    match = _ACTIVE.match(text)
    if match is not None:
        return Notice(text[match.end() :], (match[1] or match[2]).lower())  # type: ignore[arg-type]
    return Notice(bracketed.lstrip(), None) if bracketed else None


def column(raw: str, place: int) -> int:
    """The column (from 1) of the line as written that a place in its compact text comes from; its end if beyond."""
    code = []
    within = False
    for at, letter in enumerate(raw):
        if within:
            within = letter != ")"
        elif letter == "(":
            within = True
        elif letter == ";":
            break
        elif not _BLANKS.match(letter):
            code.append(at)
    if not code:
        return len(raw) - len(raw.lstrip()) + 1
    return code[min(place, len(code) - 1)] + 1


def read_line(text: str, notice: Notice | None) -> Line:
    """The words of a compact text.

    Raises
    ------
    BlockFault
        Something in it cannot be read.
    """
    at, number = int(text[:1] == "/"), ""
    match = _SEQUENCE.match(text, at)
    if match is not None:
        if not match[1]:
            raise BlockFault("N without a number", at)
        number, at = match[1], match.end()
    if text[at : at + 1] == "o":
        return Line((), (), _o_word(text, at), notice, number)
    words: list[Word] = []
    assignments: list[Assignment] = []
    end = at
    while end < len(text):
        match = _NUMBER_WORD.match(text, end)  # most words of most programs
        if match is not None:
            words.append(Word(match[1], in_scale(float(match[2]), end), end))
            end = match.end()
            continue
        start, letter = end, text[end]
        if letter == "#":
            key, end = read_key(text, end + 1)
            if text[end : end + 1] != "=":
                raise BlockFault("a variable that no word uses; write #... = value to assign one", start)
            value, end = read_value(text, end + 1)
            assignments.append(Assignment(key, value, start))
        elif letter in LETTERS:
            value, end = _value(text, end)
            words.append(Word(letter, value, start))
        else:
            raise BlockFault(_unknown(letter), start)
    return Line(tuple(words), tuple(assignments), None, notice, number)


def _value(text: str, at: int) -> tuple[Value, int]:
    if not _BEGINS_VALUE.match(text, at + 1):
        raise BlockFault(f"word {text[at].upper()} has no number", at)
    return read_value(text, at + 1)


def _unknown(letter: str) -> str:
    hints = {
        "o": "O words (flow control) stand alone in their line",
        "n": "N stands at the beginning of its line",
        "/": "block delete (/) stands at the beginning of its line",
        "$": "several spindles ($) are not supported",
        "%": "% stands alone in its line",
        "=": "only variables (#) are assigned",
    }
    return hints.get(letter, f'"{letter}" is not G-code')


def _o_word(text: str, at: int) -> OWord:
    label, end = _label(text, at + 1)
    if end == len(text):
        return OWord(label, "", (), at)
    match = _KEYWORD.match(text, end)
    if match is None:
        raise BlockFault(f"unknown flow control; behind an O word stands one of {', '.join(KEYWORDS)}", end)
    return OWord(label, match.group(), tuple(_arguments(text, match.end())), at)


def _label(text: str, at: int) -> tuple[Value | str, int]:
    digits = _DIGITS.match(text, at)
    if digits is not None:
        return digits.group().lstrip("0") or "0", digits.end()
    if text[at : at + 1] == "<":
        end = text.find(">", at)
        if end < 0:
            raise BlockFault("label of an O word without its closing >", at)
        return text[at + 1 : end], end + 1
    return read_value(text, at)


def _arguments(text: str, at: int) -> Iterator[Value]:
    while at < len(text):
        if text[at] != "[":
            raise BlockFault("behind a flow control word stand only values in brackets [...]", at)
        value, at = read_value(text, at)
        yield value
