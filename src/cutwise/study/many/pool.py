"""Processes that hold a study and do small pieces of a search; none of their results depends on how many there are."""

import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from cutwise.study.many.cases import Evaluator, evaluators
from cutwise.study.many.definition import Study
from cutwise.study.many.packing import pack, unpack
from cutwise.study.processes import processes

_held: dict[str, Any] = {}  # the study of this process

Calls = Callable[[Callable[..., Any], Sequence[tuple[Any, ...]]], Iterable[Any]]
"""Results of calls of a function with some arguments each, in order."""


class Unfinished(Exception):
    """Something would have to be run, and nothing may be."""


class Pool:
    """Calls of functions with the study at hand, wherever that is."""

    def __init__(self, jobs: int, calls: Calls) -> None:
        self.jobs, self._calls = jobs, calls

    @classmethod
    def here(cls, study: Study) -> "Pool":
        """In this process."""

        def calls(function: Callable[..., Any], some: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
            hold(study)
            return (function(*one) for one in some)

        return cls(1, calls)

    @classmethod
    def none(cls, study: Study) -> "Pool":
        """Nowhere: what would have to be run is :class:`Unfinished`."""
        hold(study)

        def calls(_function: Callable[..., Any], _some: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
            raise Unfinished

        return cls(1, calls)

    def map(
        self, function: Callable[..., Any], some: Sequence[tuple[Any, ...]], told: Callable[[int], object] | None = None
    ) -> list[Any]:
        """The results of calls with some arguments each, in order; ``told`` how many there are."""
        found: list[Any] = []
        for one in self._calls(function, some):
            found.append(one)
            if told is not None:
                told(len(found))
        return found


@contextmanager
def pooled(study: Study, jobs: int, executor: str = "local", address: str | None = None) -> Iterator[Pool]:
    """A pool of so many processes, this one alone if it is one; of workers of dask, if that is to start them."""
    if executor != "local":
        from cutwise.study.many.distributed import pooled_on_dask

        with pooled_on_dask(study, jobs, address) as found:
            yield found
        return
    if jobs <= 1:
        yield Pool.here(study)
        return
    with processes(jobs, hold_packed, (json.dumps(pack(study)),)) as some:
        yield Pool(jobs, some.calls)


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


def hold(study: Study) -> None:
    """Take a study as that of this process."""
    if _held.get("study") is not study:
        _held.clear()
        _held["study"] = study


def hold_packed(text: str) -> None:
    """The same of a study as one document."""
    hold(unpack(json.loads(text)))
