"""Units of length in CL data: which statements say them, in which of their many spellings."""

from collections.abc import Sequence
from typing import NamedTuple

from cutwise.programs.cldata import Statement, StatementFault

INCH_FEEDS, MM_FEEDS = ("IPM", "IPR"), ("MMPM", "MMPR")
_INCH = frozenset({"IN", "INCH", "INCHES", "IMPERIAL", "ENGLISH"})
_MM = frozenset({"MM", "MILLIMETER", "MILLIMETERS", "MILLIMETRE", "MILLIMETRES", "MILIMETERS", "METRIC"})
_STATEMENTS = frozenset({"UNITS", "UNIT", "CSI_SET_UNIT", "CSI_SET_UNITS"})
_SHARED = frozenset({"MODE"})  # words that may say a unit, and other things


class Unit(NamedTuple):
    """The unit of length that CL data begins with, and how it is known."""

    inch: bool
    notice: str = ""  # what was assumed, if anything


def is_about_units(s: Statement) -> bool:
    """Whether a statement says the unit of lengths."""
    return s.word in _STATEMENTS or (s.word in _SHARED and any(word in _INCH | _MM for word in s.words()))


def says_inch(s: Statement) -> bool:
    """Whether a statement about units says inches, else millimetres.

    Raises
    ------
    StatementFault
        It says another unit, or both, or none.
    """
    inch, mm = (any(word in known for word in s.words()) for known in (_INCH, _MM))
    if inch == mm:
        raise StatementFault(f"{s.word}/{s.text}: not a unit of length that is known; write UNITS/MM or UNITS/INCH",
                             s.column)  # fmt: skip
    return inch


def first_unit(found: Sequence[Statement]) -> Unit:
    """The unit of the first statement that says one; else that of the first feed; else millimetres, with a notice."""
    for statement in found:
        if is_about_units(statement):
            try:
                return Unit(says_inch(statement))
            except StatementFault:
                return Unit(False)  # said when the statement is run
    for statement in found:
        for word in statement.words():
            if word in INCH_FEEDS or word in MM_FEEDS:
                return Unit(word in INCH_FEEDS)
    return Unit(False, "no UNITS: lengths are taken as mm")
