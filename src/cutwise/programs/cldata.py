"""APT cutter location data (CL, CLS) as statements: a word, and the numbers and words behind its slash."""

import math
import re
from collections.abc import Iterator
from pathlib import PurePath
from typing import NamedTuple

_SUFFIXES = (".apt", ".cls", ".cl", ".aptsource")
_TYPICAL = re.compile(
    r"^\s*(?:(?:GOTO|GODLTA|FROM|FEDRAT|LOADTL|SPINDL|UNITS?|CUTTER|TLDATA|TOOL PATH|MULTAX|CYCLE|COOLNT|CSYS|TRNTYP"
    r"|CSI_SET_\w+)\s*/"
    r"|(?:PARTNO|PPRINT|REMARK|RAPID|MULTAX|FINI)\b)",
    re.IGNORECASE | re.MULTILINE,
)
_LOOKED_AT = 4000  # characters
_NUMBER = re.compile(
    r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?"
)  # D: exponent of FORTRAN, in which CL writers were written
_SPOKEN = ("PARTNO", "PPRINT", "REMARK", "TOOL PATH", "INSERT", "OP_NAME", "TITLE", "LETTER")  # text behind them
_GAP = re.compile(r"^\s*,|,\s*,")
_BLANKS = re.compile(r"\s+")
_NUMBERS = re.compile(r"[\s\d.,+\-eE]*\$?\s*")


class StatementFault(Exception):
    """A statement that cannot be run, and the column where it stands."""

    def __init__(self, message: str, column: int) -> None:
        super().__init__(message)
        self.message, self.column = message, column


class Argument(NamedTuple):
    """A number or a word behind the slash of a statement."""

    value: float | str
    column: int

    @property
    def number(self) -> float | None:
        """The value, if it is a number."""
        return self.value if isinstance(self.value, float) else None


class Statement(NamedTuple):
    """A statement: its word, its arguments, and where it stands."""

    word: str
    arguments: tuple[Argument, ...]
    text: str  # behind the word, as written
    line: int
    column: int

    def words(self) -> list[str]:
        """The arguments that are words."""
        return [argument.value for argument in self.arguments if isinstance(argument.value, str)]

    def numbers(self) -> list[float]:
        """The arguments that are numbers."""
        return [argument.value for argument in self.arguments if isinstance(argument.value, float)]

    def check_numbers(self) -> None:
        """Refuse words and gaps among numbers of which the place tells the meaning: one less would shift all others.

        Raises
        ------
        StatementFault
            At the first of them.
        """
        for argument in self.arguments:
            if isinstance(argument.value, str):
                wrong = "out of scale" if _NUMBER.fullmatch(argument.value) else "not a number"
                raise StatementFault(f'{self.word}: "{argument.value}" is {wrong}', argument.column)
        if _GAP.search(self.text):
            raise StatementFault(f"{self.word}: a number is missing between two commas", self.column)

    def after(self, *names: str) -> float | None:
        """The number behind the first of some words."""
        for word, following in zip(self.arguments[:-1], self.arguments[1:], strict=True):
            if word.value in names and isinstance(following.value, float):
                return following.value
        return None


def is_apt(text: str, name: str) -> bool:
    """Whether a program is CL data: by the suffix of its file, or by what its first lines look like."""
    return PurePath(name).suffix.lower() in _SUFFIXES or _TYPICAL.search(text[:_LOOKED_AT]) is not None


def statements(text: str) -> Iterator[Statement]:
    """The statements of CL data; ``$`` continues a line, ``$$`` begins a comment, which may be continued by numbers."""
    pending: list[str] = []
    first = 0
    commented = False  # within a comment that goes on: $$-> CSYS / 1.0, 0.0, $
    for number, raw in enumerate(text.splitlines(), start=1):
        if commented and not _NUMBERS.fullmatch(raw):
            commented = False
        if commented:
            commented = raw.rstrip().endswith("$")
            continue
        code, comment, notice = raw.partition("$$")
        line = code.rstrip()
        commented = bool(comment) and not line and notice.rstrip().endswith("$")
        if line.endswith("$"):
            pending.append(line[:-1])
            first = first or number
            continue
        whole, start = "".join((*pending, line)), first or number
        pending, first = [], 0
        if whole.strip():
            yield _statement(whole, start)
    if pending and "".join(pending).strip():
        yield _statement("".join(pending), first)


def _statement(text: str, line: int) -> Statement:
    column = len(text) - len(text.lstrip()) + 1
    upper = text.strip().upper()
    spoken = next((word for word in _SPOKEN if upper.startswith(word)), None)
    if spoken is not None:
        return Statement(spoken, (), text.strip()[len(spoken) :].strip(" /"), line, column)
    word, slash, rest = text.partition("/")
    name = _BLANKS.sub(" ", word.strip().upper())
    return Statement(name, tuple(_arguments(rest, len(word) + len(slash))), rest.strip(), line, column)


def _arguments(text: str, before: int) -> Iterator[Argument]:
    at = 0
    for part in text.split(","):
        bare = part.strip()
        column = before + at + len(part) - len(part.lstrip()) + 1
        at += len(part) + 1
        if not bare:
            continue
        compact = _BLANKS.sub("", bare)
        number = float(compact.upper().replace("D", "E")) if _NUMBER.fullmatch(compact) else math.nan
        yield Argument(number if math.isfinite(number) else bare.upper(), column)  # 1e999 is no number
