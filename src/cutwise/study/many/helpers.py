"""Processes of this machine that help with a study: they load what they need while it is begun, and end with their parent."""

import multiprocessing
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cutwise.study.many import folder as at

_WAITED = 0.2  # [s] between two looks whether the parent lives


class Helpers:
    """Processes that work on the folder of a study as this one does; they load what they need while it is begun."""

    def __init__(self, folder: Path, count: int) -> None:
        context = multiprocessing.get_context("spawn")  # a fork after compiled threads would hang
        self._folder, self._begun = folder, context.Event()
        self._all = [
            context.Process(target=_help, args=(folder, self._begun), daemon=True) for _ in range(max(0, count))
        ]
        for one in self._all:
            one.start()

    def start(self) -> None:
        """The study is in its folder now."""
        self._begun.set()

    def look(self) -> None:
        """Give back what one that was killed had leased."""
        for one in self._all:
            if not one.is_alive():
                at.give_back_of(self._folder, one.pid)

    def end(self) -> None:
        """End all of them; they had no time to give back what they leased."""
        for one in self._all:
            one.terminate()
            one.join()
            at.give_back_of(self._folder, one.pid)


@contextmanager
def helpers(folder: Path, count: int) -> Iterator[Helpers]:
    """So many helpers, ended at last."""
    found = Helpers(folder, count)
    try:
        yield found
    finally:
        found.end()


def _help(folder: Path, begun: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the process that started this one, and that ends this
    while not begun.wait(_WAITED):
        if orphaned():
            return
    from cutwise.study.many.engine import work

    work(folder)


def orphaned() -> bool:
    """Whether whoever started this worker was killed: then nobody would stop it."""
    parent = multiprocessing.parent_process()
    return parent is not None and not parent.is_alive()
