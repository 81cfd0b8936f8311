"""Processes of this machine that do pieces of work; where one is lost, others do what is not done yet."""

import multiprocessing
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any

from cutwise.spec.faults import Fault, ScenarioFault

_RETRIES = 5  # with new processes, where one was lost


class Processes:
    """Processes that each begin with a call of ``prepared``."""

    def __init__(self, jobs: int, prepared: Callable[..., object], given: tuple[Any, ...]) -> None:
        self._jobs, self._prepared, self._given = jobs, prepared, given
        self._executor = self._made()

    def _made(self) -> ProcessPoolExecutor:
        context = multiprocessing.get_context("spawn")  # a fork after compiled threads would hang
        return ProcessPoolExecutor(
            self._jobs, mp_context=context, initializer=_begun, initargs=(self._prepared, self._given)
        )

    def calls(self, function: Callable[..., Any], some: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
        """Results of calls of a function with some arguments each, in order.

        Raises
        ------
        ScenarioFault
            Processes end before their time, again and again.
        """
        done = 0
        for _ in range(1 + _RETRIES):
            try:
                for one in self._executor.map(function, *zip(*some[done:], strict=True)):
                    done += 1
                    yield one
                return
            except BrokenProcessPool:
                self._executor.shutdown(wait=False, cancel_futures=True)
                self._executor = self._made()
        raise ScenarioFault(
            [
                Fault(
                    (),
                    "workers end before their time, again and again; what was tried is kept, --resume goes on",
                    file="--jobs",
                )
            ]
        )

    def end(self) -> None:
        """End them."""
        self._executor.shutdown(wait=True, cancel_futures=True)


def _begun(prepared: Callable[..., object], given: tuple[Any, ...]) -> None:
    """Prepare this process, which ends with the one that started it: it would wait for work for ever."""
    parent = multiprocessing.parent_process()

    def watch() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    prepared(*given)


@contextmanager
def processes(jobs: int, prepared: Callable[..., object], given: tuple[Any, ...]) -> Iterator[Processes]:
    """So many processes, ended at last."""
    found = Processes(jobs, prepared, given)
    try:
        yield found
    finally:
        found.end()
