"""Settings of an optimisation that were tried: each run once, here or elsewhere, and kept in the folder of the study."""

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cutwise.io.revision import Value
from cutwise.study.limits import BEYOND, margins
from cutwise.study.many import aims as worth
from cutwise.study.many import folder as at
from cutwise.study.many.cases import FAILED, GOOD, Chunk, evaluate, step_errors
from cutwise.study.many.definition import Study, at_setting
from cutwise.study.many.draws import NETS
from cutwise.study.many.pool import Pool, held, held_evaluators
from cutwise.study.many.statements import Share, share_of
from cutwise.study.optimum import Found, Point, Seen

_PIECE = 256  # fresh cases at a time
Progress = Callable[[int, int], object]


class Setting(NamedTuple):
    """One setting of the levers, and what came of it."""

    levers: Mapping[str, Value]  # SI, or words
    aims: tuple[float, ...]  # SI, as they are told
    margin: float  # farthest beyond a limit, or its quantile; 0 or below is met
    measures: Mapping[str, float]  # of its run, or their means over all cases that ended
    share: Share | None = None  # of good ones among its own cases
    fresh: Share | None = None  # and among fresh ones
    asked: float | None = None  # least share that its own cases were to have
    verdict: str = ""  # of its run in full

    @property
    def met(self) -> bool:
        """Whether all limits are kept, as often as was asked for."""
        return self.margin <= 0.0


class Tried:
    """Settings of a study, tried once each and kept in its folder."""

    def __init__(
        self, study: Study, folder: Path, scales: dict[str, float], pool: Pool, progress: Progress | None
    ) -> None:  # fmt: skip
        self.study, self.scales = study, scales
        self._folder, self.pool, self._progress = folder, pool, progress
        self._kept = {_key(one): one for one in at.trials(folder)}
        self.made = 0
        assert study.search is not None
        self.between = study.search.between
        self._worth = [worth.value_of(aim) for aim in study.search.aims]

    def setting(self, x: Point) -> dict[str, Value]:
        """The levers at a point."""
        return {key: one.value(v) for (key, one), v in zip(self.between.items(), x, strict=True)}

    def one_by_one(self, points: Sequence[Point], *, fine: bool) -> list[Seen]:
        """Each setting as one run; ``fine``: with the step of the scenario."""
        asked = [{"at": list(x), "fine": fine} for x in points]
        found = self.known_or(asked, lambda some: self.pool.map(_run_one, [(one, self.scales) for one in some]))
        return [self._seen(x, one, tuple(one["margins"])) for x, one in zip(points, found, strict=True)]

    def over_cases(self, points: Sequence[Point], share: float) -> list[Seen]:
        """Each setting over the fixed set of cases, judged by the worst but a share of them."""
        asked = [{"at": list(x), "cases": self.study.draws, "seed": self.study.seed} for x in points]
        found = self.known_or(asked, self._all_cases)
        return [self._seen(x, one, (quantile(one["margins"], share),)) for x, one in zip(points, found, strict=True)]

    def _all_cases(self, asked: list[dict[str, Any]]) -> list[dict[str, Any]]:
        count = self.study.draws
        each = -(-count // self.pool.jobs)
        pieces = [
            (one, self.scales, first, min(each, count - first)) for one in asked for first in range(0, count, each)
        ]
        done = iter(self.pool.map(_run_cases, pieces))
        found = []
        for one in asked:
            parts = [next(done) for _ in range(0, count, each)]
            far = sorted(m for part in parts for m in part["margins"])
            means = {
                name: math.fsum(v for part in parts for v in part["measures"][name]) / max(1, size)
                for name in parts[0]["measures"]
                if (size := sum(len(part["measures"][name]) for part in parts))
            }
            said = [text for part in parts for text in part["said"]]
            good = [g for part in parts for g in part["good"]]
            found.append({**one, "margins": far, "measures": means, "good": good, "said": said})
        return found

    def fresh(self, asked: list[dict[str, Any]]) -> list[dict[str, Any]]:
        """Each setting over cases that the search has not seen."""
        return self.known_or(asked, self._fresh)

    def _fresh(self, asked: list[dict[str, Any]]) -> list[dict[str, Any]]:
        found = []
        for one in asked:
            setting = self.setting(tuple(one["at"]))
            fresh = at_setting(self.study, setting)._replace(seed=one["seed"], draws=one["cases"])
            errors, count = step_errors(fresh), one["cases"]
            pieces = [
                (one, self.scales, first, min(_PIECE, count - first), errors) for first in range(0, count, _PIECE)
            ]
            parts = self.pool.map(_run_cases, pieces)
            found.append({
                **one, "good": [g for part in parts for g in part["good"]],
                "said": [text for part in parts for text in part["said"]], "measures": {}, "margins": [],
            })  # fmt: skip
        return found

    def _seen(self, x: Point, one: Mapping[str, Any], far: tuple[float, ...]) -> Seen:
        values = {**one["measures"], **{k: v for k, v in self.setting(x).items() if not isinstance(v, str)}}
        assert self.study.search is not None
        aims = zip(self.study.search.aims, self._worth, strict=True)
        return Seen(tuple(aim.sign * value(values) for aim, value in aims), far, one)

    def as_setting(self, found: Found, asked: float | None = None) -> Setting:
        """A point as a setting; ``asked``: least share that its cases were to have."""
        one = found.seen.more
        assert self.study.search is not None
        aims = tuple(aim.sign * v for aim, v in zip(self.study.search.aims, found.seen.values, strict=True))
        share = None if asked is None else share_of_cases(one["good"])
        return Setting(self.setting(found.at), aims, found.margin, one["measures"], share, None, asked)

    def failed(self) -> dict[str, int]:
        """Why runs of settings in the folder failed, with their numbers."""
        return reasons(one for one in self._kept.values() if not one.get("proof"))

    def so_far(self) -> list[Setting]:
        """All settings that are in the folder, in the order in which they were tried."""
        assert self.study.search is not None
        asked = self.study.search.probability[0] if self.study.search.probability else None
        found = []
        for one in self._kept.values():
            if not one.get("proof"):
                far = (quantile(one["margins"], asked),) if asked is not None else tuple(one["margins"])
                x = tuple(one["at"])
                seen = self._seen(x, one, far)
                found.append(self.as_setting(Found(x, seen, seen.values[0], max(far, default=-np.inf)), asked))
        return found

    def known_or(
        self, asked: list[dict[str, Any]], make: Callable[[list[dict[str, Any]]], list[dict[str, Any]]]
    ) -> list[dict[str, Any]]:
        new = [one for one in asked if _key(one) not in self._kept]
        step = 2 * self.pool.jobs if new and "cases" in new[0] else 16
        for first in range(0, len(new), step):  # what was tried is kept as soon as a few are there
            some = make(new[first : first + step])
            at.write_trials(self._folder, some)
            self._kept |= {_key(one): one for one in some}
            self.made += len(some)
            if self._progress is not None:
                self._progress(self.made, 0)
        return [self._kept[_key(one)] for one in asked]


def quantile(sorted_margins: Sequence[float], share: float) -> float:
    """The margin that a share of all cases does not exceed (``inverted_cdf``); 0 or below: at least that share is good.

    >>> quantile([-0.3, -0.2, -0.1, 0.4], 0.75)
    -0.1
    """
    return float(np.quantile(np.asarray(sorted_margins), share, method="inverted_cdf"))


def share_of_cases(good: Sequence[int]) -> Share:
    """Share of good ones among all cases; one that failed (-1) is none, as in the margins that the search goes by."""
    return share_of(np.array(good) == 1, nets=len(good) % NETS == 0)


def _key(one: Mapping[str, Any]) -> str:
    return json.dumps([one["at"], one.get("fine"), one.get("cases"), one.get("seed"), one.get("proof")])


def _levers_of(study: Study, x: Sequence[float]) -> dict[str, Value]:
    assert study.search is not None
    return {key: one.value(v) for (key, one), v in zip(study.search.between.items(), x, strict=True)}


def _run_one(one: dict[str, Any], scales: dict[str, float]) -> dict[str, Any]:
    """One run at a setting: its measures, how far beyond each limit, and why it failed."""
    study = held()
    case = held_evaluators()[1 if one["fine"] else 0](_levers_of(study, one["at"]))
    far, sound = margins(study.scenario, case.outcome, scales)
    if case.failure is not None or not sound:
        far = tuple(max(BEYOND, m) for m in far) or (BEYOND,)
    why = str(case.failure).splitlines()[0] if case.failure else next(iter(case.outcome.infeasible), "")
    finite = {name: float(v) for name, v in case.measures.items() if math.isfinite(v)}
    return {**one, "margins": list(far), "measures": finite, "said": [why] if why else []}


def _run_cases(
    one: dict[str, Any], scales: dict[str, float], first: int, count: int, errors: Mapping[str, float] | None = None
) -> dict[str, Any]:  # fmt: skip
    """Some cases at a setting."""
    study = held()
    here = at_setting(study, _levers_of(study, one["at"]))._replace(seed=one["seed"], draws=one["cases"])
    chunk: Chunk = evaluate(here, first, count, errors or {}, scales=scales)
    ended = chunk.state != FAILED
    state = np.where(ended, (chunk.state == GOOD).astype(int), -1)
    measures = {name: values[ended & np.isfinite(values)].tolist() for name, values in chunk.measures.items()}
    said = [text for text, fine in zip(chunk.said, ended, strict=True) if not fine]
    return {"margins": chunk.margin.tolist(), "good": state.tolist(), "measures": measures, "said": said}


def reasons(tried: Iterable[Mapping[str, Any]]) -> dict[str, int]:
    """Why runs of some settings failed, with their numbers."""
    found: dict[str, int] = {}
    for one in tried:
        for text in one["said"]:
            found[text] = found.get(text, 0) + 1
    return found
