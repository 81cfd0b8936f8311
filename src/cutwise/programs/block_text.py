"""How a place in a program is named to people: the line of the file, the number of the block, and what stands there."""

import itertools
import re
from collections.abc import Sequence

_LISTED = 8  # lines that are named one by one
_NUMBER = re.compile(r"\s*/?\s*[nN]\s*(\d+)")
_LONGEST = 48  # characters of a block that are shown


def block_named(text: str, line: int) -> str:
    """A line of a program file in words: ``line 22 of the program (block N105: N105 G1 X20)``.

    The number of a line counts the lines of the file, as editors do; the number of a block (N) is what the control shows.

    Parameters
    ----------
    text : str
        The program; empty where it is not at hand: then the line alone is named.
    line : int
        Line of the file, from 1.
    """
    shown, number = _shown(text, line)
    if not shown:
        return f"line {line} of the program"
    shown = shown if len(shown) <= _LONGEST else shown[: _LONGEST - 1] + "…"
    return f"line {line} of the program ({f'block {number}: ' if number else ''}{shown})"


def blocks_named(text: str, lines: Sequence[int]) -> str:
    """Lines of a program in words, the first few of many, each with the number of its block."""
    if len(lines) == 1:
        return block_named(text, lines[0])
    named = []
    for line in lines[:_LISTED]:
        number = _shown(text, line)[1]
        named.append(f"{line} ({number})" if number else str(line))
    more = f" and {len(lines) - _LISTED} more" if len(lines) > _LISTED else ""
    return f"lines {', '.join(named)}{more} of the program"


def _shown(text: str, line: int) -> tuple[str, str]:
    """A line without control characters and needless blanks, and the number of its block (``N105``)."""
    raw = next(itertools.islice(text.split("\n"), line - 1, line), "") if line > 0 else ""
    shown = " ".join("".join(letter if letter.isprintable() else " " for letter in raw).split())
    match = _NUMBER.match(shown)
    return shown, f"N{match[1]}" if match is not None else ""
