"""What a study says while it runs: now and then a line with the estimate so far, its interval, and the time that is left."""

import logging
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from cutwise.study.many import folder as at
from cutwise.study.many.cases import FAILED
from cutwise.study.many.definition import Study
from cutwise.study.many.tally import Following

_EVERY = 10.0  # [s] between two lines
_told = logging.getLogger("cutwise.study")


class Live:
    """Told what is done; tells a bar, and every ten seconds a line."""

    def __init__(self, study: Study, folder: Path, show: Callable[[float], object]) -> None:
        self._study, self._folder, self._show = study, folder, show
        self._tally: Following | None = None
        self._began: tuple[float, int] | None = None
        self._last = time.monotonic()

    def __call__(self, done: int, of: int) -> None:
        self._show(done / of)
        now = time.monotonic()
        if self._began is None:
            self._began = now, done
        if now - self._last >= _EVERY:
            self._last = now
            _told.info("%s", self.line(done, of))

    def done(self) -> int:
        """Cases whose parts are there."""
        known = at.identity_in(self._folder)
        return 0 if known is None else sum(n for _, n in at.finished(self._folder, self._study, int(known["chunk"])))

    def line(self, done: int, of: int) -> str:
        """Cases, estimate, failures, time."""
        parts = [f"{done:,} of {of:,}"]
        known = at.identity_in(self._folder)
        if self._tally is None and known is not None:
            self._tally = Following(self._study, self._folder, int(known["chunk"]))
        if self._tally is not None:
            self._tally.look()
        if self._tally is not None and self._tally.done:
            shares = self._tally.shares() if self._study.scenario.asked else []
            known_ones = [share for _, share in shares if np.isfinite(share.value)]
            if known_ones and self._study.random:
                widest = max(known_ones, key=lambda share: share.half_width)
                name = "P(good)" if len(shares) == 1 else "P(good), the least certain,"
                parts.append(f"{name} {widest.value:.3f} ± {widest.half_width:.3f}")
            parts.append(f"{int(self._tally.states[FAILED])} failed")
        if self._began is not None and done > self._began[1]:
            each = (time.monotonic() - self._began[0]) / (done - self._began[1])
            parts.append(f"{_time((of - done) * each)} left")
        return "   ".join(parts)


def _time(seconds: float) -> str:
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"
