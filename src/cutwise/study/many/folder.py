"""The folder of a study: what it is, its finished parts, and leases of those in work.

A part is a pure function of the study and its first case, and is written whole or not at all: what is missing is done
again, what is there twice is the same. A lease is a file that a worker makes for the part it works on and touches;
one that nobody has touched for long is taken over.
"""

import hashlib
import io
import json
import os
import platform
import time
from collections.abc import Collection, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from cutwise.disk import write_bytes, write_text
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.many.cases import Chunk
from cutwise.study.many.definition import Study

_STALE = 60.0  # [s] after which a lease that nobody touches is taken over


def identity_of(
    study: Study, version: str, chunk: int, errors: dict[str, float], scales: dict[str, float]
) -> dict[str, Any]:
    """What has to be the same for parts to belong together; the number of cases, stop rule and demand are not in it."""
    digest = hashlib.sha256(json.dumps(list(said_of(study).values()), sort_keys=True, default=str).encode()).hexdigest()
    return {
        "study": digest, "version": version, "chunk": chunk, "step_errors": errors, "scales": scales, "also": [],
    }  # fmt: skip


def said_of(study: Study) -> dict[str, Any]:
    """What the identity of a study is made of, by name."""
    levers = {key: repr(lever) for group in (study.design, study.random) for key, lever in group.items()}
    found: dict[str, Any] = {
        "scenario": study.scenario.document(), "coarse": None if study.coarse is None else study.coarse.document(),
        "vary": levers, "order of vary": list(levers), "method": study.method, "seed": study.seed,
        "measures": list(study.measures), "levels": study.levels,
    }  # fmt: skip
    if study.correlated:
        found["correlated"] = [list(group) for group in study.correlated]
    if study.search is not None:  # a trial is known by its point: numbers of these levers, places among these words
        found["between"] = [[key, one.whole, [*map(str, one.words)]] for key, one in study.search.between.items()]
    if study.method in ("latin_hypercube", "morris", "rare"):
        found["cases"] = study.draws  # their points depend on how many there are
    return found


def versions(identity: dict[str, Any]) -> list[str]:
    """Versions of cutwise whose cases stand beside each other in a folder."""
    return [identity["version"], *identity["also"]]


def indices_of(folder: Path) -> Path:
    """Where the runs stand that tell what decides, of a study that asks for them beside its cases."""
    return folder / "indices"


def started(folder: Path, text: str, identity: dict[str, Any]) -> None:
    """Write what a worker needs to go on with a study."""
    for name in ("parts", "lease"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    write_text(folder / "study.json", text)
    write_text(identity_file(folder), json.dumps(identity, indent=1))


def identity_file(folder: Path) -> Path:
    """Where the identity of a study stands; it is written last."""
    return folder / "identity.json"


def identity_in(folder: Path) -> dict[str, Any] | None:
    """The identity of the study in a folder; None if there is none.

    Raises
    ------
    ScenarioFault
        The file is damaged.
    """
    file = identity_file(folder)
    if not file.exists():
        return None
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
        names = ("study", "version", "chunk", "step_errors", "scales")
        return {**{name: found[name] for name in names}, "also": list(found.get("also", []))}
    except (OSError, ValueError, KeyError, TypeError):
        raise ScenarioFault([Fault((), "is damaged; take another folder (-o)", file=str(file))]) from None


def chunks(study: Study, size: int) -> Iterator[tuple[int, int]]:
    """First case and number of cases of every part."""
    for first in range(0, study.cases, size):
        yield first, min(size, study.cases - first)


def part_file(folder: Path, first: int, count: int) -> Path:
    """Where a part stands."""
    return folder / "parts" / f"part-{first:012d}-{count}.nc"


def write_part(folder: Path, chunk: Chunk) -> Path:
    """Write a part as netCDF-4, whole or not at all."""
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        case = file.create_dataset("case", data=np.arange(chunk.first, chunk.first + chunk.cases))
        case.make_scale("case")
        columns: dict[str, Any] = {f"lever {key}": values for key, values in chunk.levers.items()}
        columns |= {f"measure {name}": values for name, values in chunk.measures.items()}
        columns |= {
            "state": chunk.state,
            "margin": chunk.margin,
            "finer": chunk.finer.astype(np.int8),
            "said": chunk.said,
        }
        for name, values in columns.items():
            numbers = all(isinstance(v, float | int | np.number) and not isinstance(v, bool) for v in values)
            data = np.asarray(values) if numbers else np.array([str(v) for v in values], dtype=h5py.string_dtype())
            file.create_dataset(name, data=data).dims[0].attach_scale(case)
    return write_bytes(part_file(folder, chunk.first, chunk.cases), stream.getvalue())


def read_part(file: Path, only: Collection[str] | None = None) -> dict[str, np.ndarray]:
    """The columns of a part, or some of them."""
    with h5py.File(file, "r") as opened:
        found = {}
        for name in opened if only is None else only:
            values = opened[name]
            found[name] = values.asstr()[:] if h5py.check_string_dtype(values.dtype) else values[:]
        return found


def columns_of(file: Path) -> list[str]:
    """Names of the columns of a part."""
    with h5py.File(file, "r") as opened:
        return list(opened)


def finished(folder: Path, study: Study, size: int) -> list[tuple[int, int]]:
    """The parts that are there."""
    there = names(folder)
    return [one for one in chunks(study, size) if part_file(folder, *one).name in there]


def missing(folder: Path, study: Study, size: int) -> list[tuple[int, int]]:
    """The parts that are not there."""
    there = names(folder)
    return [one for one in chunks(study, size) if part_file(folder, *one).name not in there]


def names(folder: Path) -> set[str]:
    """All files of parts: one look at the folder, however many there are."""
    return set(os.listdir(folder / "parts")) if (folder / "parts").is_dir() else set()


def trials(folder: Path) -> list[dict[str, Any]]:
    """What a search has tried, in its order; a last line that was cut off does not count."""
    file = folder / "trials.jsonl"
    if not file.exists():
        return []
    found = []
    for line in file.read_text(encoding="utf-8").splitlines():
        try:
            found.append(json.loads(line))
        except ValueError:
            continue
    return found


def write_trials(folder: Path, some: list[dict[str, Any]]) -> None:
    """Add what was tried, each on a line of its own; the line before may have been cut off."""
    file = folder / "trials.jsonl"
    with file.open("ab") as stream:
        torn = stream.tell() > 0 and file.read_bytes()[-1:] != b"\n"
        text = "".join(json.dumps(one) + "\n" for one in some)
        stream.write((b"\n" if torn else b"") + text.encode())
        stream.flush()
        os.fsync(stream.fileno())


def take_lease(folder: Path, first: int) -> bool:
    """Whether a part is now ours to do."""
    lease = folder / "lease" / str(first)
    try:
        with lease.open("x", encoding="utf-8") as file:
            file.write(_holder(os.getpid()))
        return True
    except FileExistsError:
        pass
    try:
        mine = folder / "lease" / f"clock-{os.getpid()}"
        mine.touch()  # by the clock of the file system, which every worker sees
        age = mine.stat().st_mtime - lease.stat().st_mtime
        mine.unlink(missing_ok=True)
        if age < _STALE and not _gone(lease.read_text(encoding="utf-8")):
            return False
        lease.write_text(_holder(os.getpid()), encoding="utf-8")
        return True
    except FileNotFoundError:  # given back meanwhile
        return False


def _holder(process: int) -> str:
    return f"{platform.node()} {process}"


def _gone(holder: str) -> bool:
    """Whether the holder of a lease was a process of this machine that has ended."""
    node, _, process = holder.rpartition(" ")
    if os.name == "nt" or node != platform.node() or not process.isdigit():
        return False
    try:
        os.kill(int(process), 0)  # asks, and does nothing
    except ProcessLookupError:
        return True
    except OSError:
        return False
    return False


def give_back_of(folder: Path, process: int | None) -> None:
    """Give back what a process of this machine had leased when it was ended."""
    for lease in (folder / "lease").glob("*"):
        with suppress(FileNotFoundError):
            if process is not None and lease.read_text(encoding="utf-8") == _holder(process):
                lease.unlink()


class Lease:
    """A lease that is touched now and then, and given back."""

    def __init__(self, folder: Path, first: int) -> None:
        self.file = folder / "lease" / str(first)
        self._touched = time.monotonic()

    def touch(self) -> None:
        """Say that the work goes on."""
        if time.monotonic() - self._touched > 0.1 * _STALE:
            self._touched = time.monotonic()
            self.file.touch()

    def give_back(self) -> None:
        """Let others see that it is done."""
        self.file.unlink(missing_ok=True)
