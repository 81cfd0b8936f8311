"""Rare failures of a study: levels of subset simulation, every batch of cases kept in the folder as a part."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import special

from cutwise.io.revision import Value
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.many import folder as at
from cutwise.study.many.cases import FAILED, Chunk, evaluate_levers
from cutwise.study.many.columns import Columns, Table, row
from cutwise.study.many.definition import Study, correlated
from cutwise.study.many.draws import LEVELS_FROM, generator
from cutwise.study.many.engine import LOCAL, begun, checked
from cutwise.study.many.pool import Pool, Unfinished, held, pooled
from cutwise.study.many.statements import Share
from cutwise.study.many.tally import counted, farthest
from cutwise.study.rare import SHARE, Flat, Level, Rare, subset_simulation

FloatArray = np.ndarray
Progress = Callable[[int, int], object]

_LEAST = 2.0**-53
_PIECE = 100  # cases of one call in a process
_REPEATED = 2  # times that a case may be there


class Rarely(NamedTuple):
    """What a study of rare failures came to."""

    study: Study
    done: int  # cases
    found: Rare
    table: Table  # of all cases, in their order
    failed: Mapping[str, int]  # reasons, with their numbers
    unfinished: bool = False  # the levels so far, of a search that was stopped: failures are rarer than its probability

    @property
    def good(self) -> Share:
        """Share of good cases, with the interval of the levels."""
        return Share(1.0 - self.found.probability, 1.0 - self.found.high, 1.0 - self.found.low)

    @property
    def demanded(self) -> bool | None:
        """Whether the demanded share of good cases is reached; None without a demand."""
        return None if self.study.demanded is None or self.unfinished else self.good.low >= self.study.demanded

    @property
    def measures(self) -> dict[str, float]:
        """The numbers of the study by name."""
        rare = self.found
        if self.unfinished:
            return {"cases_done": float(self.done), "cases_failed": float(sum(self.failed.values()))}
        return {
            "failure_probability": rare.probability, "failure_probability_low": rare.low,
            "failure_probability_high": rare.high, "failure_cov": rare.cov if np.isfinite(rare.cov) else 0.0,
            "cases_done": float(self.done), "cases_failed": float(sum(self.failed.values())),
        }  # fmt: skip

    def worst(self, count: int) -> list[dict[str, Any]]:
        """Levers of the cases that are farthest beyond a limit, each once, those that failed left out."""
        found: list[dict[str, Any]] = []
        for case in farthest(self.study, self.table, _REPEATED * count):  # chains stay where they are: cases recur
            told = row(self.table, case)
            one = {key: told[f"lever {key}"] for key in self.study.keys}
            if one not in found and told["state"] != FAILED:
                found.append(one)
        return found[:count]


def size_of_level(cases: int) -> int:
    """Cases of a level: a multiple of the length of its chains."""
    step = round(1.0 / SHARE)
    return max(10 * step, -(-cases // step) * step)


def rarely(
    study: Study, folder: Path, *, jobs: int = 1, resume: bool = False, progress: Progress | None = None,
    executor: str = LOCAL, address: str | None = None, accept_version: bool = False,
) -> Rarely:  # fmt: skip
    """The probability that a study's requirements are missed, however small.

    Parameters
    ----------
    study, folder
        The study, and where its cases are kept.
    jobs, executor, address, accept_version
        As of :func:`cutwise.study.many.engine.run_study`.
    resume : bool
        Go on with the cases that are there.
    progress : callable, optional
        Told how many cases are done.

    Raises
    ------
    ScenarioFault
        The folder holds another study, or cases of this one without ``resume``; or the margin does not rise from level
        to level.
    """
    checked(executor, address)
    known = begun(study, folder, resume=resume, accept_version=accept_version)
    with pooled(study, jobs, executor, address) as pool:
        return _found(study, _Cases(study, folder, known, pool, progress))


def told(study: Study, folder: Path, known: dict[str, Any]) -> Rarely:
    """What the cases in a folder say; nothing further is run.

    Raises
    ------
    ValueError
        There is no case yet.
    """
    found = _found(study, _Cases(study, folder, known, Pool.none(study), None))
    if not found.done:
        raise ValueError("no case is finished yet")
    return found


def _found(study: Study, cases: "_Cases") -> Rarely:
    levels: list[Level] = []
    unfinished = False
    try:
        found = subset_simulation(
            cases.margins, len(study.random), count=size_of_level(study.draws),
            rng=lambda level: generator(study.seed, LEVELS_FROM + level), levels=levels,
        )  # fmt: skip
    except Unfinished:
        share = float(np.prod([level.share for level in levels]))
        found, unfinished = Rare(share, np.inf, tuple(levels), cases.done, np.empty((0, 0)), np.empty(0)), True
    except Flat:
        raise ScenarioFault([Fault(
            (), "rare: the worst cases of all levels are equally far from the limits; what scatters does not lead to "
            "them, so nothing is said of how rare a failure is", file=study.name,
        )]) from None  # fmt: skip
    table = cases.table()
    failed = counted(study, table).failed if cases.done else {}
    return Rarely(study, cases.done, found, table, {text: one.cases for text, one in failed.items()}, unfinished)


class _Cases:
    """Margins of points in standard normal space; batches that are in the folder are not run again."""

    def __init__(
        self, study: Study, folder: Path, known: dict[str, Any], pool: Pool, progress: Progress | None
    ) -> None:  # fmt: skip
        self._study, self._folder, self._known, self._pool, self._progress = study, folder, known, pool, progress
        self.done = 0
        self._parts: list[tuple[int, int]] = []

    def margins(self, z: FloatArray) -> FloatArray:
        """How far each case is beyond its limits."""
        file = at.part_file(self._folder, self.done, len(z))
        if not file.exists():
            pieces = [
                (
                    self.done + first,
                    z[first : first + _PIECE].tolist(),
                    self._known["step_errors"],
                    self._known["scales"],
                )
                for first in range(0, len(z), _PIECE)
            ]
            at.write_part(self._folder, _joined(self._pool.map(_run, pieces)))
        self._parts.append((self.done, len(z)))
        self.done += len(z)
        if self._progress is not None:
            self._progress(self.done, 0)
        return np.asarray(at.read_part(file, ("margin",))["margin"])

    def table(self) -> Columns:
        """Columns of all cases."""
        return Columns(self._folder, self._parts)


def levers_at(study: Study, z: FloatArray) -> dict[str, list[Value]]:
    """The levers of points in standard normal space."""
    u = correlated(study, np.clip(special.ndtr(z), _LEAST, 1.0 - _LEAST))
    return {key: lever.of(u[:, j]) for j, (key, lever) in enumerate(study.random.items())}


def _run(first: int, z: list[list[float]], errors: Mapping[str, float], scales: Mapping[str, float]) -> Chunk:
    study = held()
    return evaluate_levers(study, first, levers_at(study, np.array(z)), errors, scales=scales)


def _joined(parts: list[Chunk]) -> Chunk:
    """Chunks that follow one another as one."""
    return Chunk(
        parts[0].first,
        {key: [v for part in parts for v in part.levers[key]] for key in parts[0].levers},
        {name: np.concatenate([part.measures[name] for part in parts]) for name in parts[0].measures},
        np.concatenate([part.state for part in parts]),
        np.concatenate([part.margin for part in parts]),
        np.concatenate([part.finer for part in parts]),
        [text for part in parts for text in part.said],
    )
