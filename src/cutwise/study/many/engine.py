"""Running a study: chunks until nothing is left, here or in as many processes as are wanted, on one folder."""

import importlib.util
import json
import multiprocessing
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from cutwise import __version__
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.many import folder as at
from cutwise.study.many.cases import evaluate, limit_scales, step_errors
from cutwise.study.many.definition import SEARCHES, Study, in_the_middle
from cutwise.study.many.packing import pack, unpack
from cutwise.study.many.tally import Following

_LASTS = 10.0  # [s] that a part should take
_SMALLEST, _LARGEST = 32, 4096
_LOOKED = 0.2  # [s] between two looks at what is finished
_WAITED = 1.0  # [s] between two looks for a part that others have leased
_NARROW = "the interval is as narrow as the stop rule asks for"
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


def chunk_size(study: Study) -> int:
    """Cases of a part, so that it takes some seconds; found from a few of them."""
    start, count = time.process_time(), min(4, study.cases)
    evaluate(study, 0, count, {})  # compiles, too
    start = time.process_time()
    evaluate(study, 0, count, {})
    each = max(1e-4, (time.process_time() - start) / count)
    size = _SMALLEST
    while size < _LARGEST and 2 * size * each < _LASTS:
        size *= 2
    return size


def run_study(
    study: Study, folder: Path, *, jobs: int = 1, resume: bool = False, progress: Progress | None = None,
    chunk: int | None = None, executor: str = LOCAL, address: str | None = None,
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

    Raises
    ------
    ScenarioFault
        The folder holds another study, or parts of this one without ``resume``; or there is no such executor.
    """
    if executor not in EXECUTORS:
        raise ScenarioFault([Fault((), f"is not one of {', '.join(EXECUTORS)}", file=f"--executor {executor}")])
    if address is not None and executor != DASK:
        raise ScenarioFault([Fault((), "goes with --executor dask", file="--address")])
    if study.method in SEARCHES:
        raise ScenarioFault(
            [Fault(("method",), f"{study.method} looks for its cases: it is no list of parts", file=study.name)]
        )
    if executor == DASK and importlib.util.find_spec("distributed") is None:
        raise ScenarioFault([Fault((), DASK_MISSING, file="--executor dask")])  # before anything is run
    known = begun(study, folder, resume=resume, chunk=chunk)
    size = int(known["chunk"])
    if executor == DASK:
        from cutwise.study.many.distributed import run_on_dask

        return run_on_dask(study, folder, size, jobs=jobs, address=address, progress=progress)
    if jobs <= 1:
        return _alone(study, folder, size, known, progress)
    return _together(study, folder, size, jobs, progress)


def begun(study: Study, folder: Path, *, resume: bool, chunk: int | None = None) -> dict[str, Any]:
    """The identity of a study in its folder, which is made where it is not there.

    Raises
    ------
    ScenarioFault
        The folder holds another study, or parts of this one without ``resume``.
    """
    known = at.identity_in(folder)
    if known is None:
        if (folder / "parts").exists() and any((folder / "parts").iterdir()):
            raise _refused(folder, "holds parts of a study without its identity; take another folder (-o)")
        errors = step_errors(in_the_middle(study))
        size = chunk or (1 if study.method in SEARCHES else chunk_size(study))
        known = at.identity_of(study, __version__, size, errors, limit_scales(in_the_middle(study)))
    else:
        _same(study, folder, known, resume=resume)
    at.started(folder, json.dumps(pack(study)), known)
    return known


def _refused(folder: Path, message: str) -> ScenarioFault:
    return ScenarioFault([Fault((), message, file=str(folder))])


def _same(study: Study, folder: Path, known: dict[str, Any], *, resume: bool) -> None:
    """Whether the folder holds this study, and the user means to go on with it."""
    mine = at.identity_of(study, __version__, int(known["chunk"]), known["step_errors"], known["scales"])
    elsewhere = "take another folder (-o)"
    if known["version"] != mine["version"]:
        raise _refused(folder, f"was begun with cutwise {known['version']}, this is {__version__}: {elsewhere}")
    if known["study"] != mine["study"]:
        raise _refused(folder, f"holds another study: scenario, levers, method, seed or measures differ; {elsewhere}")
    if study.method in SEARCHES:
        there = len(at.trials(folder)) + len(list((folder / "parts").glob("*.nc")))
        if there and not resume:
            raise _refused(folder, f"{there:,} trials are there: add --resume, or {elsewhere}")
        return
    done = _done(study, folder, int(known["chunk"]))
    if done and not resume:
        raise _refused(folder, f"{done:,} of {study.cases:,} cases are there: add --resume, or {elsewhere}")


def _done(study: Study, folder: Path, size: int) -> int:
    """Cases whose parts are there."""
    return sum(count for _, count in at.finished(folder, study, size))


def work(folder: Path, *, until: float | None = None, progress: Progress | None = None) -> int:
    """Do parts of the study in a folder until none is left; returns the number of cases done here.

    Parts that another worker has leased are waited for: they come, or their lease grows old and is taken over.

    Parameters
    ----------
    folder : Path
        Of a study that was begun.
    until : float, optional
        Time (:func:`time.monotonic`) after which no part is begun.

    Raises
    ------
    ScenarioFault
        There is no study in the folder.
    """
    study, known = in_folder(folder)
    size, done = int(known["chunk"]), 0
    while missing := at.missing(folder, study, size):
        if (until is not None and time.monotonic() > until) or _orphaned():
            break
        mine = next((one for one in missing if at.take_lease(folder, one[0])), None)
        if mine is None:
            time.sleep(_WAITED)
            continue
        lease = at.Lease(folder, mine[0])
        try:
            if not at.part_file(folder, *mine).exists():
                found = evaluate(
                    study, *mine, known["step_errors"], lambda _, lease=lease: lease.touch(), known["scales"]
                )
                at.write_part(folder, found)
                done += mine[1]
        finally:
            lease.give_back()
        if progress is not None:
            progress(_done(study, folder, size), study.cases)
    return done


def in_folder(folder: Path) -> tuple[Study, dict[str, Any]]:
    """The study that a folder holds, and its identity.

    Raises
    ------
    ScenarioFault
        There is none.
    """
    known = at.identity_in(folder)
    if known is None or not (folder / "study.json").exists():
        raise _refused(folder, "holds no study; cutwise study begins one")
    try:
        return unpack(json.loads((folder / "study.json").read_text(encoding="utf-8"))), known
    except (ValueError, KeyError, TypeError, AttributeError):
        raise _refused(folder / "study.json", "is damaged; take another folder (-o)") from None


def _orphaned() -> bool:
    """Whether whoever started this worker was killed: then nobody would stop it."""
    parent = multiprocessing.parent_process()
    return parent is not None and not parent.is_alive()


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


def _alone(study: Study, folder: Path, size: int, known: dict[str, Any], progress: Progress | None) -> Ran:
    done, allowance, prefix = 0, _Allowance(study, _done(study, folder, size)), Following(study, folder, size)
    for first, count in at.chunks(study, size):
        if allowance.ended(done) and not at.part_file(folder, first, count).exists():
            return Ran(folder, done, _SPENT)
        if not at.part_file(folder, first, count).exists():
            told = None if progress is None else (lambda i, done=done: progress(done + i, study.cases))
            at.write_part(folder, evaluate(study, first, count, known["step_errors"], told, known["scales"]))
        done += count
        if progress is not None:
            progress(done, study.cases)
        if prefix.enough():
            return Ran(folder, done, _NARROW if done < study.cases else "")
    return Ran(folder, done, "")


def _together(study: Study, folder: Path, size: int, jobs: int, progress: Progress | None) -> Ran:
    """Workers of their own on the folder; this process looks on."""
    context = multiprocessing.get_context("spawn")  # a fork after compiled threads would hang
    workers = [context.Process(target=work, args=(folder,), daemon=True) for _ in range(jobs)]
    for worker in workers:
        worker.start()
    stopped, watch = "", Watch(study, folder, size, progress)
    try:
        while any(worker.is_alive() for worker in workers) and not stopped:
            time.sleep(_LOOKED)
            watch.tell()
            stopped = watch.stopped()
    finally:
        for worker in workers:
            worker.terminate()
            worker.join()
            at.give_back_of(folder, worker.pid)  # it had no time to do so itself
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
        return _done(self._study, self._folder, self._size)

    def missing(self) -> list[tuple[int, int]]:
        """First case and number of cases of the parts that are not there."""
        return at.missing(self._folder, self._study, self._size)

    def tell(self) -> None:
        """Tell what is done."""
        if self._progress is not None:
            self._progress(self.done, self._study.cases)

    def stopped(self) -> str:
        """Why it is to stop before all is done; nothing if it is not."""
        if self._prefix.enough():
            return _NARROW
        return _SPENT if self._allowance.ended(self.done) else ""

    def ended(self, stopped: str) -> Ran:
        """How the run ended."""
        done = self.done
        if done < self._study.cases and not stopped:
            stopped = "a worker ended before its time; --resume goes on"
        return Ran(self._folder, done, stopped if done < self._study.cases else "")
