"""The feed in force behind each word of a program, as it ran and as it runs without the blocks that may be left out."""

from __future__ import annotations

from collections.abc import Mapping, Set
from typing import NamedTuple

from cutwise.programs.trace import Word


class InForce(NamedTuple):
    """The feed in force in program units, as the program ran and without its blocks with ``/``; None: not known."""

    run: float | None = None
    without: float | None = None

    def told(self, word: Word, rate: float | None, deleted: Set[int]) -> InForce:
        """What is in force behind a word of this rate; ``deleted``: lines with ``/``."""
        run, without = rate, rate
        if word.factor:
            run, without = (None if one is None else one * word.factor for one in self)
        return InForce(run, self.without if word.line in deleted else without)


def rate_of(word: Word, written: Mapping[int, str]) -> float | None:
    """The feed that a word has in a program with other feeds on some of its lines."""
    return float(written[word.line]) if word.line in written and not word.factor else word.rate


def same(new: float | None, wanted: float | None) -> bool:
    """Whether a feed in force is the one that is wanted; units that change on the way round."""
    return new is not None and wanted is not None and abs(new - wanted) <= 1e-9 * wanted
