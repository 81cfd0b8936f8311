"""G-code text into blocks of words, each word with its place."""

import re
from collections.abc import Iterator
from typing import NamedTuple

from cutwise.spec.faults import Fault

_NUMBER = re.compile(r"[+-]?\s*(?:\d[\d ]*\.?[\d ]*|\.\s*\d[\d ]*)")


class Word(NamedTuple):
    """A letter and its number."""

    letter: str
    value: float
    line: int
    column: int

    def __str__(self) -> str:
        return f"{self.letter}{self.value:g}"


class Line(NamedTuple):
    """A block: the words of one line."""

    number: int
    words: tuple[Word, ...]


def blocks(text: str, name: str, faults: list[Fault]) -> Iterator[Line]:
    """The blocks of a program; empty lines, comments and the ``%`` lines left out.

    A block that begins with ``/`` is run: block delete is taken as off. What cannot be read is added to ``faults``
    with file, line and column, and its block left out.
    """
    for number, raw in enumerate(text.splitlines(), start=1):
        if raw.strip() == "%":
            continue
        words = _words(raw, number, name, faults)
        if words:
            yield Line(number, tuple(words))


def _words(raw: str, number: int, name: str, faults: list[Fault]) -> list[Word] | None:
    at = len(raw) - len(raw.lstrip())
    at += raw[at : at + 1] == "/"
    words: list[Word] = []
    while at < len(raw):
        letter = raw[at]
        if letter.isspace():
            at += 1
        elif letter == ";":
            break
        elif letter == "(":
            end = raw.find(")", at)
            if end < 0:
                faults.append(Fault((), "comment without its closing bracket", number, at + 1, name))
                return None
            at = end + 1
        elif not (letter.isascii() and letter.isalpha()):
            faults.append(Fault((), _unreadable(letter), number, at + 1, name))
            return None
        else:
            match = _NUMBER.match(raw, at + 1 + len(raw[at + 1 :]) - len(raw[at + 1 :].lstrip()))
            if match is None or letter.upper() == "O":
                faults.append(Fault((), _no_number(letter, raw[at + 1 :].lstrip()[:1]), number, at + 1, name))
                return None
            words.append(Word(letter.upper(), float(match.group().replace(" ", "")), number, at + 1))
            at = match.end()
    return words


def _unreadable(letter: str) -> str:
    if letter == "#":
        return "variables (#) are not supported; let the CAM system write plain numbers"
    return f'"{letter}" is not G-code'


def _no_number(letter: str, following: str) -> str:
    if letter.upper() == "O":
        return "subroutines and loops (O words) are not supported; let the CAM system write plain moves"
    if following in ("#", "["):
        return "variables and expressions are not supported; let the CAM system write plain numbers"
    return f"word {letter.upper()} has no number"
