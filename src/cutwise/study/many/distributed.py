"""Parts of a study done by the workers of dask.distributed, on the folder that all of them see.

dask starts the workers and hands out the parts; their cases go to the folder, and a number comes back. Its scheduler
keeps what it knows in memory alone, so the folder is the truth: a worker or a scheduler that is lost costs the parts in
flight, and ``--resume`` does them with the next cluster.
"""

import json
import logging
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.many import folder as at
from cutwise.study.many.beginning import to_work_on
from cutwise.study.many.cases import evaluate
from cutwise.study.many.definition import Study
from cutwise.study.many.engine import Progress, Ran, Watch
from cutwise.study.many.packing import pack, unpack
from cutwise.study.many.pool import Pool, hold

if TYPE_CHECKING:
    from distributed import Client, Future

_RETRIES = 5  # of a part whose worker was lost
_AHEAD = 4  # parts a worker that the scheduler knows of at a time
_LOOKED = 0.2  # [s] between two looks
_SOON = 0.01  # [s] between two looks for a piece that all others wait for
_SEEN = 30.0  # [s] after which a part that was done must be seen here: network file systems take their time
_CONNECTED = 20.0  # [s] for a scheduler to answer
_LOST = "the scheduler is lost; what is in the folder stays, --resume goes on"


def run_on_dask(
    study: Study, folder: Path, size: int, *, jobs: int, address: str | None, progress: Progress | None
) -> Ran:  # fmt: skip
    """Do what is missing of a study that was begun.

    Parameters
    ----------
    study, folder, size
        The study, its folder, the cases of a part.
    jobs : int
        Workers of a cluster that is started on this machine, where no address is given.
    address : str, optional
        Of a scheduler that is there, for example ``tcp://host:8786``.
    progress : callable, optional
        Told what is done.

    Raises
    ------
    ScenarioFault
        dask.distributed is not installed, nobody answers at the address, or workers do not see the folder.
    """
    watch = Watch(study, folder, size, progress)
    with _client(jobs, address) as client:
        stopped = _Handed(client, folder.resolve(), watch).until_done()
    return watch.ended(stopped)


@contextmanager
def _client(jobs: int, address: str | None) -> "Iterator[Client]":
    import dask
    from distributed import Client, LocalCluster

    quiet = {"distributed.comm.timeouts.connect": f"{_CONNECTED} s"}
    with dask.config.set(quiet), _without_logs():
        if address is None:
            with (
                LocalCluster(
                    jobs, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
                ) as here,
                Client(here) as client,
            ):
                yield client
            return
        try:
            client = Client(address, timeout=_CONNECTED)
        except (OSError, ValueError, TimeoutError) as why:
            message = f"no scheduler of dask answers ({str(why).splitlines()[0] if str(why) else type(why).__name__})"
            raise ScenarioFault([Fault((), message, file=f"--address {address}")]) from None
        try:
            yield client
        finally:
            with suppress(OSError, TimeoutError):  # a scheduler that is lost says no goodbye
                client.close(timeout=2)


@contextmanager
def _without_logs() -> Iterator[None]:
    """What is lost is told by the study, in its own words."""
    logger = logging.getLogger("distributed")
    others = [logging.getLogger(f"distributed.{name}") for name in ("client", "utils", "core", "comm", "worker")]
    levels = [(one, one.level) for one in (logger, *others)]
    for one, _ in levels:
        one.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for one, level in levels:
            one.setLevel(level)


@contextmanager
def pooled_on_dask(study: Study, jobs: int, address: str | None) -> Iterator[Pool]:
    """Workers of dask that do pieces of a search; the folder is seen by this process alone.

    Raises
    ------
    ScenarioFault
        Nobody answers at the address, or the scheduler was lost.
    """
    text = json.dumps(pack(study))
    with _client(jobs, address) as client:

        def calls(function: Callable[..., Any], some: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
            flying = [client.submit(called, text, function, one, pure=False, retries=_RETRIES) for one in some]
            return (_result(client, one) for one in flying)

        try:
            yield Pool(max(jobs, len(client.nthreads())), calls)
        except OSError as why:  # of the connection; those of the folder name a file
            if why.filename is not None:
                raise
            raise _lost(address) from None


def _result(client: "Client", future: "Future[Any]") -> Any:
    """What a piece came to, as soon as it is there."""
    while future.status in ("pending", "lost"):
        if client.status != "running":
            raise _lost(None)
        time.sleep(_SOON)
    if future.status == "cancelled":
        raise _lost(None)
    return future.result()


def _lost(address: str | None) -> ScenarioFault:
    return ScenarioFault([Fault((), _LOST, file="--executor dask" if address is None else f"--address {address}")])


def called(text: str, function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
    """One piece of a search, on a worker."""
    hold(_unpacked(text))
    return function(*arguments)


@lru_cache(maxsize=2)
def _unpacked(text: str) -> Study:
    return unpack(json.loads(text))


class _Handed:
    """Parts that are with the scheduler."""

    def __init__(self, client: "Client", folder: Path, watch: Watch) -> None:
        self._client, self._folder, self._watch = client, folder, watch
        self._flying: dict[tuple[int, int], Future[Any]] = {}
        self._done_at: dict[tuple[int, int], float] = {}  # told to be done, and not seen here yet

    def until_done(self) -> str:
        """Hand out parts until none is missing; why before that, or nothing."""
        while missing := self._watch.missing():
            stopped = self._watch.stopped()
            if stopped:
                self._client.cancel(list(self._flying.values()))
                return stopped
            if self._client.status != "running" or any(one.cancelled() for one in self._flying.values()):
                return _LOST
            try:
                self._hand_out(missing)
                self._look()
            except OSError as why:  # of the connection; those of the folder name a file
                if why.filename is not None:
                    raise
                return _LOST
            time.sleep(_LOOKED)
            self._watch.tell()
        return ""

    def _hand_out(self, missing: list[tuple[int, int]]) -> None:
        room = _AHEAD * max(1, len(self._client.nthreads())) - len(self._flying)
        for one in missing:
            if room <= 0:
                break
            if one not in self._flying and one not in self._done_at:
                self._flying[one] = self._client.submit(part, str(self._folder), *one, pure=False, retries=_RETRIES)
                room -= 1

    def _look(self) -> None:
        for one, future in list(self._flying.items()):
            if at.part_file(self._folder, *one).exists():
                del self._flying[one]  # whatever the scheduler knows of it: the number may be lost with its worker
            elif future.status == "error":
                why = future.exception()
                raise ScenarioFault(
                    [Fault((), f"a worker of dask could not do cases {one[0]} on: {why}", file=str(self._folder))]
                )
            elif future.status == "finished":
                said = future.result()
                if isinstance(said, str):
                    raise ScenarioFault([Fault((), f"a worker of dask says: {said}", file=str(self._folder))])
                del self._flying[one]
                self._done_at[one] = time.monotonic()
        for one, since in list(self._done_at.items()):
            if at.part_file(self._folder, *one).exists():
                del self._done_at[one]
            elif time.monotonic() - since > _SEEN:
                message = "workers of dask write to a folder of this name that is not seen here: put it on a shared file system"
                raise ScenarioFault([Fault((), message, file=str(self._folder))])


def part(folder: str, first: int, count: int) -> int | str:
    """Do one part of the study in a folder; the number of its cases, or in words why that cannot be."""
    place = Path(folder)
    try:
        if not at.part_file(place, first, count).exists():
            study, known = _held(folder, at.identity_file(place).stat().st_mtime_ns)
            at.write_part(place, evaluate(study, first, count, known["step_errors"], None, known["scales"]))
    except ScenarioFault as why:
        return str(why)
    except OSError as why:
        return f"{why.filename or folder}: {why.strerror or why}; every worker has to see this folder and write to it"
    return count


@lru_cache(maxsize=2)
def _held(folder: str, _changed: int) -> tuple[Study, dict[str, Any]]:
    return to_work_on(Path(folder))
