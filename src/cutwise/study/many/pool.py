"""Processes that hold a study and do small pieces of a search; none of their results depends on how many there are."""

import json
import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any

from cutwise.study.many.cases import Evaluator, evaluators
from cutwise.study.many.definition import Study
from cutwise.study.many.packing import pack, unpack

_held: dict[str, Any] = {}  # the study of this process


class Pool:
    """Calls of functions with the study at hand, here or in several processes."""

    def __init__(self, study: Study, jobs: int, executor: ProcessPoolExecutor | None) -> None:
        self.jobs, self._study, self._executor = jobs, study, executor

    def map(
        self, function: Callable[..., Any], some: Sequence[tuple[Any, ...]], told: Callable[[int], object] | None = None
    ) -> list[Any]:
        """The results of calls with some arguments each, in order; ``told`` how many there are."""
        found: list[Any] = []
        for one in self._each(function, some):
            found.append(one)
            if told is not None:
                told(len(found))
        return found

    def _each(self, function: Callable[..., Any], some: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
        if self._executor is None:
            _hold(self._study)
            return (function(*one) for one in some)
        return self._executor.map(function, *zip(*some, strict=True))


@contextmanager
def pooled(study: Study, jobs: int) -> Iterator[Pool]:
    """A pool of so many processes, this one alone if it is one."""
    if jobs <= 1:
        yield Pool(study, 1, None)
        return
    context = multiprocessing.get_context("spawn")  # a fork after compiled threads would hang
    with ProcessPoolExecutor(
        jobs, mp_context=context, initializer=_hold_packed, initargs=(json.dumps(pack(study)),)
    ) as executor:
        yield Pool(study, jobs, executor)


def held() -> Study:
    """The study of this process."""
    found: Study = _held["study"]
    return found


def held_evaluators() -> tuple[Evaluator, Evaluator]:
    """Its cases with the coarse step, and with the scenario's."""
    if "evaluators" not in _held:
        _held["evaluators"] = evaluators(held())
    found: tuple[Evaluator, Evaluator] = _held["evaluators"]
    return found


def _hold(study: Study) -> None:
    if _held.get("study") is not study:
        _held.clear()
        _held["study"] = study


def _hold_packed(text: str) -> None:
    _hold(unpack(json.loads(text)))
