"""The words of a line of G-code as they stand in its text, so that one can be replaced and every other byte stays."""

import re
from collections.abc import Iterable, Mapping
from typing import NamedTuple

_NUMBER = re.compile(r"[+-]?[ \t]*(?:\d[\d \t]*(?:\.[\d \t]*)?|\.[ \t]*\d[\d \t]*)")
_NAME = re.compile(r"[A-Za-z]+[ \t]*(?=\[)")
_VARIABLE = re.compile(r"(?:#[ \t]*)+(?:<[^>]*>|\d+|(?=\[))")
_CALLS = re.compile(r"[ \t]*/?[ \t]*(?:[nN][ \t]*\d*[ \t]*)?[oO]")


class TextWord(NamedTuple):
    """A word with its place in the line."""

    letter: str  # small
    start: int
    end: int
    value: str  # as written, without blanks around it
    plain: bool  # a number, and no expression


class LineWords(NamedTuple):
    """A line taken apart."""

    words: tuple[TextWord, ...]
    end: int  # behind the last word: where another one may stand
    deleted: bool  # it begins with /, and may be left out by the operator
    whole: bool  # everything in it was understood

    def get(self, letter: str) -> TextWord | None:
        """The first word of a letter."""
        return next((word for word in self.words if word.letter == letter), None)

    def codes(self, letter: str) -> list[float]:
        """Numbers of all words of a letter (G or M) that are plain."""
        return [float("".join(word.value.split())) for word in self.words if word.letter == letter and word.plain]


def line_words(raw: str) -> LineWords:
    """The words of a line; comments, and what begins behind a semicolon, are passed over.

    Examples
    --------
    >>> words = line_words("N10 G1 X 70. F#101 (to the corner)")
    >>> [(word.letter, word.value, word.plain) for word in words.words]
    [('n', '10', True), ('g', '1', True), ('x', '70.', True), ('f', '#101', False)]
    >>> words.end, words.whole
    (18, True)
    """
    found: list[TextWord] = []
    at, end, whole = 0, 0, True
    deleted = raw.lstrip(" \t\ufeff").startswith("/")
    if _CALLS.match(raw):
        return LineWords((), len(raw.rstrip()), deleted, False)
    while at < len(raw):
        letter = raw[at]
        if letter == "(":
            closed = raw.find(")", at)
            at = len(raw) if closed < 0 else closed + 1
        elif letter == ";":
            break
        elif letter in " \t\r\f\v\xa0\ufeff" or (letter == "/" and not found):
            at += 1
        elif letter.isalpha() or letter in "@^":
            stop, plain = _value_end(raw, at + 1)
            if stop < 0:
                whole, at = False, at + 1
                continue
            found.append(TextWord(letter.lower(), at, stop, raw[at + 1 : stop].strip(), plain))
            at = end = stop
        else:  # an assignment, a bracket
            whole, at = False, at + 1
            end = at
    return LineWords(tuple(found), end, deleted, whole)


def _value_end(raw: str, at: int) -> tuple[int, bool]:
    """Where the value of a word ends, and whether it is a plain number; -1: there is none."""
    while at < len(raw) and raw[at] in " \t":
        at += 1
    number = _NUMBER.match(raw, at)
    if number is not None:
        return at + len(number.group().rstrip()), True
    while at < len(raw) and raw[at] in "+- \t":
        at += 1
    for begins in (_VARIABLE, _NAME):
        match = begins.match(raw, at)
        if match is not None:
            at = match.end()
            if begins is _VARIABLE and not (at < len(raw) and raw[at] == "["):
                return at, False
            break
    if at >= len(raw) or raw[at] != "[":
        return -1, False
    depth = 0
    while at < len(raw):
        depth += {"[": 1, "]": -1}.get(raw[at], 0)
        at += 1
        if depth == 0:
            return at, False
    return -1, False


def with_words(
    raw: str, values: Mapping[str, str | None], comments: Iterable[str] = (), known: LineWords | None = None
) -> str:
    """A line with some words replaced or added behind the others; None takes a word away.

    Parameters
    ----------
    raw : str
        The line.
    values : mapping
        Letter: number as text.
    comments : iterable of str
        Comments behind the words.
    known : LineWords, optional
        The line taken apart, where it was already.

    Examples
    --------
    >>> with_words("N10 G1 X70 F2400 (wall)", {"f": "1800", "y": "4.5"})
    'N10 G1 X70 F1800 Y4.5 (wall)'
    >>> with_words("G3 X74 Y30 R4", {"r": None, "i": "0", "j": "4"})
    'G3 X74 Y30 I0 J4'
    """
    words = line_words(raw) if known is None else known
    edits: list[tuple[int, int, str]] = []
    added = []
    for letter, value in values.items():
        word = words.get(letter)
        if word is not None and value is not None:
            edits.append((word.start + 1, word.end, value))
        elif word is not None:
            start = word.start
            while start > 0 and raw[start - 1] in " \t":
                start -= 1
            edits.append((start, word.end, ""))
        elif value is not None:
            added.append(letter.upper() + value)
    spaced = any(raw[word.end : word.end + 1] in (" ", "\t") for word in words.words[:-1]) or len(words.words) < 2
    tail = "".join((" " if spaced else "") + word for word in added)
    tail += "".join(f" ({comment})" for comment in comments)
    edits.append((words.end, words.end, tail))
    out = raw
    for start, end, text in sorted(edits, reverse=True):
        out = out[:start] + text + out[end:]
    return out
