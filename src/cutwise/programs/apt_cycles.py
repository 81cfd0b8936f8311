"""Drilling cycles of CL data: what is done at each point, from the words of a CYCLE statement."""

from collections.abc import Iterator
from typing import NamedTuple

from cutwise.programs.cldata import Statement, StatementFault

DRILLED = (
    "DRILL", "DEEP", "DEEP2", "BRKCHP", "BORE", "REAM", "FACE", "CSINK", "CBORE", "TAP", "THRU", "THRUHOLE",
)  # fmt: skip
BEGINS = ("ON", "INIT", "CLEAR")  # alone behind CYCLE: the cycle that is defined, or defined next, begins
_PECKED = frozenset({"DEEP", "DEEP2", "BRKCHP"})
_FIRST, _NEXT = ("1STPECK",), ("SUBPECK", "STEP", "PECK")


class Hole(NamedTuple):
    """What a drilling cycle does at each point: heights along the tool axis, measured from the point."""

    clearance: float  # down to here at rapid
    bottom: float
    retract: float  # up to here behind the hole, not below the clearance
    first_peck: float  # 0: in one go
    peck: float
    seconds: float
    feed: float  # 0: the feed in force


def hole_of(s: Statement, feed: float) -> Hole:
    """The hole that a CYCLE statement describes.

    Parameters
    ----------
    s : Statement
        ``CYCLE/DRILL,RAPTO,3,FEDTO,-12,MMPM,150`` or, as some systems write it, ``CYCLE/DRILL,depth,MMPM,feed,clearance``.
    feed : float
        Feed of its feed word, in program units; 0: none.

    Raises
    ------
    StatementFault
        It is not known, or it has no depth.
    """
    words, numbers = s.words(), s.numbers()
    kind = words[0] if words else ""
    if kind not in DRILLED:
        raise StatementFault(f"CYCLE/{kind}: unknown or unsupported cycle; known are {', '.join(DRILLED)}", s.column)
    clearance = _first(s.after("RAPTO"), s.after("CLEAR"))
    bottom = s.after("FEDTO", "DEPTH")
    if bottom is None and numbers:  # depth, feed word, feed, clearance
        bottom = -abs(numbers[0])
        clearance = numbers[-1] if clearance is None and len(numbers) >= 3 else clearance
    if bottom is None:
        raise StatementFault("CYCLE needs a depth (FEDTO or the first number)", s.column)
    clearance = clearance or 0.0
    retract = _first(s.after("RTRCTO"), s.after("RETURN"), s.after("CLEAR"), clearance)
    first, peck = _pecks(s, kind)
    return Hole(clearance, -abs(bottom), max(retract or 0.0, clearance), first, peck, s.after("DWELL") or 0.0, feed)


def _pecks(s: Statement, kind: str) -> tuple[float, float]:
    first, following = s.after(*_FIRST), s.after(*_NEXT)
    if kind not in _PECKED:
        return 0.0, 0.0
    for value in (first, following):
        if value is not None and value < 0.0:
            raise StatementFault(f"CYCLE/{kind}: a peck must not be negative, found {value:g}", s.column)
    peck = _first(following, first) or 0.0
    return _first(first, following) or 0.0, peck or first or 0.0


def _first(*values: float | None) -> float | None:
    return next((value for value in values if value is not None), None)


def peck_count(hole: Hole) -> float:
    """How often a cycle draws back before it reaches its bottom."""
    if hole.first_peck <= 0.0 or hole.peck <= 0.0:
        return 0.0
    return max(0.0, (hole.clearance - hole.bottom - hole.first_peck) / hole.peck + 1.0)


def peck_depths(hole: Hole) -> Iterator[float]:
    """Heights that the pecks reach before the bottom, the first one counted from the clearance as Q of G83 is."""
    if hole.first_peck <= 0.0 or hole.peck <= 0.0:
        return
    depth = hole.clearance - hole.first_peck
    while depth > hole.bottom:
        yield depth
        depth -= hole.peck
