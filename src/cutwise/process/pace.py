"""How long a long job will take: told once, after its first part was done, so that it can be stopped and made smaller."""

import logging
import math
import time
from collections.abc import Callable

TOLD = logging.getLogger("cutwise")  # what the engineer should hear while a run is going on

_FIRST = 1.0  # [s] of computing after which the rest is estimated
_LONG = 10.0  # [s] of computing still to come that are worth a word


class Pace:
    """A job of many pieces, of which each takes about as long as it is large."""

    def __init__(self, total: float, remedy: str, progress: Callable[[float], None] | None = None) -> None:
        self.total, self.remedy, self.progress = total, remedy, progress
        self.done = 0.0
        self._start = time.process_time()
        self._told = False

    def advance(self, size: float) -> None:
        """Count a piece as done; tells how long the rest will take, and stops where the engineer has asked to."""
        self.done += size
        spent = time.process_time() - self._start
        if not self._told and spent > _FIRST and 0.0 < self.done < self.total:
            self._told = True
            left = spent * (self.total - self.done) / self.done
            if left > _LONG:
                TOLD.info("about %s of computing to come; Ctrl-C stops it. %s", span(left), self.remedy)
        if self.progress is not None:
            self.progress(min(1.0, self.done / self.total))


def span(seconds: float) -> str:
    """A time that is an estimate, in two digits."""
    if seconds < 100.0:
        return f"{_two_digits(seconds):.0f} s"
    if seconds < 6000.0:
        return f"{_two_digits(seconds / 60.0):.2g} min"
    return f"{_two_digits(seconds / 3600.0):.2g} h"


def _two_digits(value: float) -> float:
    digit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return round(value / digit) * digit
