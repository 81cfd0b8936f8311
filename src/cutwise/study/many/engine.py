"""Running a study: chunks until nothing is left, here or in as many processes as are wanted, on one folder."""

import importlib.util
import json
import multiprocessing
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
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
_PARTS = 64  # that there should be, so that workers end together
_LOOKED = 0.2  # [s] between two looks at what is finished
_WAITED = 0.2  # [s] between two looks for a part that others have leased
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
    """Cases of a part, so that it takes some seconds and there are some dozens of parts; found from a few cases."""
    count = min(4, study.cases)
    evaluate(study, 0, count, {})  # compiles, too
    start = time.process_time()
    evaluate(study, 0, count, {})
    each = max(1e-4, (time.process_time() - start) / count)
    size = _SMALLEST
    while size < _LARGEST and 2 * size * each < _LASTS and 2 * size * _PARTS <= study.cases:
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
    checked(executor, address)
    if study.method in SEARCHES:
        raise ScenarioFault(
            [Fault(("method",), f"{study.method} looks for its cases: it is no list of parts", file=study.name)]
        )
    known = _known(study, folder, resume=resume)  # refused before anybody is started
    if executor == DASK:
        from cutwise.study.many.distributed import run_on_dask

        size = int(_begun(study, folder, known, chunk)["chunk"])
        return run_on_dask(study, folder, size, jobs=jobs, address=address, progress=progress)
    with _helpers(folder, jobs - 1) as helpers:
        known = _begun(study, folder, known, chunk)
        helpers.start()
        return _here(study, folder, known, helpers, progress)


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


def begun(study: Study, folder: Path, *, resume: bool, chunk: int | None = None) -> dict[str, Any]:
    """The identity of a study in its folder, which is made where it is not there.

    Raises
    ------
    ScenarioFault
        The folder holds another study, or parts of this one without ``resume``.
    """
    return _begun(study, folder, _known(study, folder, resume=resume), chunk)


def _known(study: Study, folder: Path, *, resume: bool) -> dict[str, Any] | None:
    """The identity of the study that is in its folder already; None if the folder is free."""
    known = at.identity_in(folder)
    if known is not None:
        _same(study, folder, known, resume=resume)
    elif (folder / "parts").exists() and any((folder / "parts").iterdir()):
        raise _refused(folder, "holds parts of a study without its identity; take another folder (-o)")
    return known


def _begun(study: Study, folder: Path, known: dict[str, Any] | None, chunk: int | None) -> dict[str, Any]:
    """The identity, made where there is none, with all that a worker needs in the folder."""
    if known is None:
        errors = step_errors(in_the_middle(study))
        size = chunk or (1 if study.method in SEARCHES else chunk_size(study))
        known = at.identity_of(study, __version__, size, errors, limit_scales(in_the_middle(study)))
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
        There is no study in the folder, or a search, whose cases follow from one another.
    """
    study, known = in_folder(folder)
    if study.method in SEARCHES:
        raise _refused(
            folder,
            f"holds a search ({study.method}): its cases follow from one another; cutwise study has --jobs and --executor",
        )

    def ended() -> bool:
        return (until is not None and time.monotonic() > until) or _orphaned()

    def told(_: int) -> None:
        if progress is not None:
            progress(_done(study, folder, int(known["chunk"])), study.cases)

    return _worked(study, folder, known, ended, told)


def _worked(
    study: Study, folder: Path, known: dict[str, Any], ended: Callable[[], bool], told: Callable[[int], object]
) -> int:
    """Do parts until none is missing or it ended; ``told`` the cases done of the part in work, after each of them."""
    size, done = int(known["chunk"]), 0
    while missing := at.missing(folder, study, size):
        if ended():
            break
        mine = next((one for one in missing if at.take_lease(folder, one[0])), None)
        if mine is None:
            time.sleep(_WAITED)
            continue
        lease = at.Lease(folder, mine[0])

        def touched(count: int, lease: at.Lease = lease) -> None:
            lease.touch()
            told(count)

        try:
            if not at.part_file(folder, *mine).exists():
                at.write_part(folder, evaluate(study, *mine, known["step_errors"], touched, known["scales"]))
                done += mine[1]
        finally:
            lease.give_back()
        told(0)
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


def _here(
    study: Study, folder: Path, known: dict[str, Any], helpers: "_Helpers", progress: Progress | None
) -> Ran:  # fmt: skip
    """Do parts in this process, beside helpers of its own and workers of others; it tells what is done."""
    watch = Watch(study, folder, int(known["chunk"]), progress)
    stopped, last = "", 0.0

    def ended() -> bool:
        nonlocal stopped
        helpers.look()
        stopped = watch.stopped()
        return bool(stopped)

    def told(count: int) -> None:
        nonlocal last
        if not count or time.monotonic() - last > _LOOKED:
            watch.tell(count)
            last = time.monotonic()

    _worked(study, folder, known, ended, told)
    return watch.ended(stopped)


class _Helpers:
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
def _helpers(folder: Path, count: int) -> Iterator[_Helpers]:
    found = _Helpers(folder, count)
    try:
        yield found
    finally:
        found.end()


def _help(folder: Path, begun: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the process that started this one, and that ends this
    while not begun.wait(_WAITED):
        if _orphaned():
            return
    work(folder)


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
        done = self.done
        if done < self._study.cases and not stopped:
            stopped = "a worker ended before its time; --resume goes on"
        return Ran(self._folder, done, stopped if done < self._study.cases else "")
