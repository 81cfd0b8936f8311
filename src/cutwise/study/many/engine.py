"""Running a study: chunks until nothing is left, here or in as many processes as are wanted, on one folder."""

import importlib.util
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.many import folder as at
from cutwise.study.many.beginning import begun, done, in_folder, known, made, refused, to_work_on
from cutwise.study.many.cases import evaluate
from cutwise.study.many.definition import SEARCHES, Budget, Study, of_indices
from cutwise.study.many.helpers import Helpers, helpers, orphaned
from cutwise.study.many.tally import Following

__all__ = [
    "DASK",
    "EXECUTORS",
    "LOCAL",
    "Progress",
    "Ran",
    "Watch",
    "begun",
    "checked",
    "in_folder",
    "run_study",
    "work",
]

_LOOKED = 0.2  # [s] between two looks at what is finished
_WAITED = 0.2  # [s] between two looks for a part that others have leased
_NARROW = "the interval is as narrow as the stop rule asks for"
_WITHOUT = "all cases are there, the runs that tell what decides are not: "
_SPENT = "the budget is spent; --resume goes on"

LOCAL, DASK = EXECUTORS = ("local", "dask")
"""What may start the workers of a study: processes of this machine, dask.distributed."""
DASK_MISSING = "needs dask.distributed, which is not installed: pip install 'cutwise[distributed]'"

Progress = Callable[[int, int], object]
"""Called with the cases that are done, and with all."""


class Ran(NamedTuple):
    """How a run of a study ended."""

    folder: Path
    done: int  # cases
    stopped: str  # why before all were done; empty: all are


def run_study(
    study: Study, folder: Path, *, jobs: int = 1, resume: bool = False, progress: Progress | None = None,
    chunk: int | None = None, executor: str = LOCAL, address: str | None = None, accept_version: bool = False,
) -> Ran:  # fmt: skip
    """Run what is missing of a study.

    Parameters
    ----------
    study : Study
        The study.
    folder : Path
        Where its parts are kept.
    jobs : int
        Processes.
    resume : bool
        Go on with the parts that are there.
    progress : callable, optional
        Told what is done.
    chunk : int, optional
        Cases of a part; left out, as many as take some seconds.
    executor : str
        What starts the workers, of :data:`EXECUTORS`.
    address : str, optional
        Of a scheduler of dask that is there; left out, one is started here.
    accept_version : bool
        Go on with parts of another version of cutwise.

    Raises
    ------
    ScenarioFault
        The folder holds another study, or parts of this one without ``resume``; or there is no such executor.
    """
    checked(executor, address)
    start, there = time.monotonic(), at.identity_in(folder)
    before = 0 if there is None else done(study, folder, int(there["chunk"]))
    if study.method in SEARCHES:
        raise ScenarioFault(
            [Fault(("method",), f"{study.method} looks for its cases: it is no list of parts", file=study.name)]
        )
    ran = _run(study, folder, jobs, executor, address, progress, chunk, resume=resume, accept_version=accept_version)
    if not study.indices or ran.done < study.cases:
        return ran
    more = of_indices(study)
    budget = study.budget
    if budget is not None:
        cases = None if budget.cases is None else budget.cases - (ran.done - before)
        seconds = None if budget.seconds is None else budget.seconds - (time.monotonic() - start)
        if (cases is not None and cases <= 0) or (seconds is not None and seconds <= 0.0):
            return ran._replace(stopped=_WITHOUT + _SPENT)
        more = more._replace(budget=Budget(cases, seconds))
    beside = _run(
        more, at.indices_of(folder), jobs, executor, address, progress, None, resume=True, accept_version=accept_version
    )
    return ran._replace(stopped=_WITHOUT + beside.stopped if beside.stopped else "")


def _run(
    study: Study, folder: Path, jobs: int, executor: str, address: str | None, progress: Progress | None,
    chunk: int | None, *, resume: bool, accept_version: bool,
) -> Ran:  # fmt: skip
    """Run what is missing of the cases of one folder."""
    there = known(study, folder, resume=resume, accept_version=accept_version)  # refused before anybody is started
    if executor == DASK:
        from cutwise.study.many.distributed import run_on_dask

        size = int(made(study, folder, there, chunk)["chunk"])
        return run_on_dask(study, folder, size, jobs=jobs, address=address, progress=progress)
    with helpers(folder, jobs - 1) as others:
        there = made(study, folder, there, chunk)
        others.start()
        return _here(study, folder, there, others, progress)


def checked(executor: str, address: str | None) -> None:
    """Whether there is such an executor here, before anything is run.

    Raises
    ------
    ScenarioFault
        There is none.
    """
    if executor not in EXECUTORS:
        raise ScenarioFault([Fault((), f"is not one of {', '.join(EXECUTORS)}", file=f"--executor {executor}")])
    if address is not None and executor != DASK:
        raise ScenarioFault([Fault((), "goes with --executor dask", file="--address")])
    if executor == DASK and importlib.util.find_spec("distributed") is None:
        raise ScenarioFault([Fault((), DASK_MISSING, file="--executor dask")])


def work(folder: Path, *, until: float | None = None, progress: Progress | None = None) -> int:
    """Do parts of the study in a folder until none is left; returns the number of cases done here.

    Parts that another worker has leased are waited for: they come, or their lease grows old and is taken over.

    Parameters
    ----------
    folder : Path
        Of a study that was begun; with the runs of its indices, where they were.
    until : float, optional
        Time (:func:`time.monotonic`) after which no part is begun.

    Raises
    ------
    ScenarioFault
        There is no study in the folder, or a search, whose cases follow from one another.
    """
    study, there = to_work_on(folder)
    if study.method in SEARCHES:
        raise refused(
            folder,
            f"holds a search ({study.method}): its cases follow from one another; cutwise study has --jobs and --executor",
        )

    def ended() -> bool:
        return (until is not None and time.monotonic() > until) or orphaned()

    def told(count: int) -> None:
        if progress is not None and not count:  # a look at the folder after each part, not after each case
            progress(done(study, folder, int(there["chunk"])), study.cases)

    here = _worked(study, folder, there, ended, told)
    beside = at.indices_of(folder)
    return here + (work(beside, until=until, progress=progress) if at.identity_file(beside).exists() else 0)


def _worked(
    study: Study, folder: Path, known: dict[str, Any], ended: Callable[[], bool], told: Callable[[int], object]
) -> int:
    """Do parts until none is missing or it ended; ``told`` the cases done of the part in work, after each of them."""
    size, count = int(known["chunk"]), 0
    while missing := at.missing(folder, study, size):
        if ended():
            break
        mine = next((one for one in missing if at.take_lease(folder, one[0])), None)
        if mine is None:
            time.sleep(_WAITED)
            continue
        lease = at.Lease(folder, mine[0])

        def touched(cases: int, lease: at.Lease = lease) -> None:
            lease.touch()
            told(cases)

        try:
            if not at.part_file(folder, *mine).exists():
                at.write_part(folder, evaluate(study, *mine, known["step_errors"], touched, known["scales"]))
                count += mine[1]
        finally:
            lease.give_back()
        told(0)
    return count


class _Allowance:
    """What the budget of one call leaves."""

    def __init__(self, study: Study, done: int) -> None:
        cases, seconds = study.budget or (None, None)
        self._cases = None if cases is None else done + cases
        self._until = None if seconds is None else time.monotonic() + seconds

    def ended(self, done: int) -> bool:
        """Whether nothing more may be begun."""
        return (self._cases is not None and done >= self._cases) or (
            self._until is not None and time.monotonic() >= self._until
        )


def _here(
    study: Study, folder: Path, known: dict[str, Any], others: Helpers, progress: Progress | None
) -> Ran:  # fmt: skip
    """Do parts in this process, beside helpers of its own and workers of others; it tells what is done."""
    watch = Watch(study, folder, int(known["chunk"]), progress)
    stopped, last = "", 0.0

    def ended() -> bool:
        nonlocal stopped
        others.look()
        stopped = watch.stopped()
        return bool(stopped)

    def told(count: int) -> None:
        nonlocal last
        if not count or time.monotonic() - last > _LOOKED:
            watch.tell(count)
            last = time.monotonic()

    _worked(study, folder, known, ended, told)
    return watch.ended(stopped)


class Watch:
    """What is done of a study that others work on, and whether it should stop."""

    def __init__(self, study: Study, folder: Path, size: int, progress: Progress | None) -> None:
        self._study, self._folder, self._size, self._progress = study, folder, size, progress
        self._allowance = _Allowance(study, self.done)
        self._prefix = Following(study, folder, size)

    @property
    def done(self) -> int:
        """Cases whose parts are there."""
        return done(self._study, self._folder, self._size)

    def missing(self) -> list[tuple[int, int]]:
        """First case and number of cases of the parts that are not there."""
        return at.missing(self._folder, self._study, self._size)

    def tell(self, more: int = 0) -> None:
        """Tell what is done, and so many cases of a part in work."""
        if self._progress is not None:
            self._progress(min(self.done + more, self._study.cases), self._study.cases)

    def stopped(self) -> str:
        """Why it is to stop before all is done; nothing if it is not."""
        if self._prefix.enough() and self.done < self._study.cases:
            return _NARROW
        return _SPENT if self._allowance.ended(self.done) else ""

    def ended(self, stopped: str) -> Ran:
        """How the run ended."""
        there = self.done
        if there < self._study.cases and not stopped:
            stopped = "a worker ended before its time; --resume goes on"
        return Ran(self._folder, there, stopped if there < self._study.cases else "")
