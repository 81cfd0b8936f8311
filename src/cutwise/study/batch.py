"""Independent cases of one scenario, here or in several processes: what bands and sensitivities are made of."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import Any

from cutwise.io.revision import Value
from cutwise.spec.scenario import Scenario
from cutwise.study.case import Case, cases
from cutwise.study.processes import processes

Values = Mapping[str, Value]
Progress = Callable[[float], object]

_PIECES = 8  # of the work of each process: they end together
_held: dict[str, Any] = {}  # how this process evaluates a case


def batch(
    scenario: Scenario, many: Sequence[Values], wanted: Collection[str] = (), *, coarse: bool = False, jobs: int = 1,
    progress: Progress | None = None,
) -> Iterator[Case]:  # fmt: skip
    """The cases of some values each, in their order; none of them depends on the number of processes.

    Parameters
    ----------
    scenario : Scenario
        What all other values are taken from.
    many : sequence of mappings
        Dotted keys and values of each case.
    wanted, coarse
        As of :func:`cutwise.study.case.cases`.
    jobs : int
        Processes; where there are fewer cases, as many as cases.
    progress : callable, optional
        Called with the finished share.
    """
    for done, case in enumerate(_in_order(scenario, many, wanted, coarse=coarse, jobs=min(jobs, len(many))), 1):
        if progress is not None:
            progress(done / len(many))
        yield case


def _in_order(
    scenario: Scenario, many: Sequence[Values], wanted: Collection[str], *, coarse: bool, jobs: int
) -> Iterator[Case]:  # fmt: skip
    if jobs <= 1:
        yield from map(cases(scenario, wanted, coarse=coarse), many)
        return
    size = max(1, len(many) // (_PIECES * jobs))
    pieces = [(list(many[first : first + size]),) for first in range(0, len(many), size)]
    with processes(jobs, _prepared, (scenario, tuple(wanted), coarse)) as some:
        for piece in some.calls(_piece, pieces):
            yield from piece


def _prepared(scenario: Scenario, wanted: tuple[str, ...], coarse: bool) -> None:
    _held["evaluate"] = cases(scenario, wanted, coarse=coarse)


def _piece(many: list[Values]) -> list[Case]:
    return [_held["evaluate"](values) for values in many]
