"""The best setting of a study: every setting that is tried is kept, the best is run in full and held against fresh cases."""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cutwise.io.revision import Value
from cutwise.results import Result, SolverFailure
from cutwise.spec.faults import ScenarioFault
from cutwise.study.band import simulate
from cutwise.study.limits import BEYOND, bounds, margins, scaled
from cutwise.study.many import aims as worth
from cutwise.study.many import folder as at
from cutwise.study.many.cases import (
    FAILED,
    GOOD,
    Chunk,
    evaluate,
    scenario_of,
    step_errors,
    takes_coarse_step,
)
from cutwise.study.many.definition import Study, at_setting
from cutwise.study.many.draws import NETS, OPTIMISER, generator
from cutwise.study.many.engine import begun
from cutwise.study.many.pool import Pool, held, held_evaluators, pooled
from cutwise.study.many.statements import Share, share_of
from cutwise.study.optimum import Found, Point, Problem, Range, Seeker, Seen, front

FRESH = 4096
"""Cases, none of which the search has seen, that a robust optimum is held against."""

_PIECE = 256  # of them at a time
_REPEATS = 3  # of a robust search whose result the fresh cases do not prove
_ROOM = (
    2.2  # changes on a halved step that an optimum stays off its limits: a run counts twice that change as its error
)
_SLOW = ("deburr", "drill")  # whose runs are long for what their levers do: fewer starts
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


class Best(NamedTuple):
    """What an optimisation came to."""

    study: Study
    done: int  # settings that were tried
    optima: tuple[Setting, ...]  # one; of a robust one every attempt, the last is the answer
    front: tuple[Setting, ...]
    tried: tuple[Setting, ...]
    run: Result | None  # of the optimum, in full; of a robust one there is none: fresh cases tell
    failed: Mapping[str, int]  # reasons, with their numbers

    @property
    def optimum(self) -> Setting:
        """The answer."""
        return self.optima[-1]

    @property
    def measures(self) -> dict[str, float]:
        """The numbers of the answer by name, SI; levers that are words stand in :attr:`optimum`."""
        best = self.optimum
        told = {"settings_tried": float(self.done)}
        for k, value in enumerate(best.aims):
            if math.isfinite(value):
                told["optimum_value" if k == 0 else f"optimum_value_{k + 1}"] = value
        told |= {f"optimum_{key}": float(v) for key, v in best.levers.items() if isinstance(v, int | float)}
        for name, share in (("probability_good", best.share), ("probability_good_fresh", best.fresh)):
            if share is not None and math.isfinite(share.value):
                told |= {name: share.value, f"{name}_low": share.low, f"{name}_high": share.high}
        return told

    @property
    def proven(self) -> bool:
        """Whether the answer holds: in its own full run, or among fresh cases."""
        best = self.optimum
        if not best.met:
            return False
        if best.asked is None:
            return self.run is not None and self.run.verdict != "fail"
        return len(self.front) > 0 or (best.fresh is not None and best.fresh.low >= self.study.search.probability[-1])  # type: ignore[union-attr]


def optimised(
    study: Study, folder: Path, *, jobs: int = 1, resume: bool = False, progress: Progress | None = None
) -> Best:
    """Look for the best setting of a study; with ``resume`` what was tried before is not tried again.

    Raises
    ------
    ScenarioFault
        The folder holds another study, or trials of this one without ``resume``.
    """
    known = begun(study, folder, resume=resume)
    with pooled(study, jobs) as pool:
        trials = _Trials(study, folder, known["scales"], pool, progress)
        return _Searched(study, trials).best()


class _Trials:
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

    def _seen(self, x: Point, one: Mapping[str, Any], far: tuple[float, ...]) -> Seen:
        values = {**one["measures"], **{k: v for k, v in self.setting(x).items() if not isinstance(v, str)}}
        assert self.study.search is not None
        aims = zip(self.study.search.aims, self._worth, strict=True)
        return Seen(tuple(aim.sign * value(values) for aim, value in aims), far, one)

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


class _Searched:
    """From trials to the answer."""

    def __init__(self, study: Study, trials: _Trials) -> None:
        assert study.search is not None
        self.study, self.trials, self.search = study, trials, study.search

    def best(self) -> Best:
        """The answer of the study."""
        robust = self.search.probability
        if robust:
            return self._robust()
        if len(self.search.aims) == 2:
            return self._front()
        seeker = self._seeker(lambda points: self.trials.one_by_one(points, fine=False))
        one, fine = seeker.solve(), takes_coarse_step(self.study)
        last = self._seeker(lambda points: self.trials.one_by_one(points, fine=fine)) if fine else seeker
        if fine:  # and on with the step of the scenario, from where that led to
            again = last.solve(near=[one.at])
            one = again if again.met or not one.met else one
        return self._in_full(seeker, last, one)

    def _in_full(self, seeker: Seeker, last: Seeker, one: Found) -> Best:
        """The optimum, run in full; moved off its limits where the error of the step reaches across one."""
        attempts, run = [self._setting(one)], self._run(one)
        for _ in range(_REPEATS):
            if not one.met or run is None or not _too_near(run):
                break
            off = self._room(run)
            problem = Problem(lambda seen: seen.values[0], lambda seen, off=off: _shifted(seen, off).margins)
            again = last.solve(problem, [one.at])
            if not again.met:
                break
            one, run = again, self._run(again)
            attempts.append(self._setting(one))
        return self._told(seeker, attempts[-1:], [], run)

    def _front(self) -> Best:
        """What can be had of one aim for how much of the other, each point with the step of the scenario and run in full."""
        fine = takes_coarse_step(self.study)
        room = np.zeros(len(list(bounds(self.study.scenario))))
        for _ in range(_REPEATS):
            seeker = self._seeker(
                lambda points, off=room: [_shifted(one, off) for one in self.trials.one_by_one(points, fine=fine)]
            )
            found = front(seeker, self.search.points)
            if not found[0].met:
                return self._told(seeker, [self._setting(found[0])], [])
            runs = [self._run(one) for one in found]
            off = [self._room(run) for run in runs if run is not None and _too_near(run)]
            if not off:
                break
            room = np.maximum(room, np.max(off, axis=0))
        along = [
            self._setting(one)._replace(verdict="" if run is None else run.verdict)
            for one, run in zip(found, runs, strict=True)
        ]
        return self._told(seeker, along[:1], along, runs[0])

    def _room(self, run: Result) -> list[float]:
        """How far an optimum stays off each limit, so that the error of its step does not reach across it."""
        return [
            _ROOM * abs(run.convergence.get(bound.measure, 0.0)) / scaled(bound, self.trials.scales)
            for bound in bounds(self.study.scenario)
        ]

    def _run(self, one: Found) -> Result | None:
        if not one.met:
            return None
        try:
            return simulate(scenario_of(self.study, self.trials.setting(one.at)))
        except (ScenarioFault, SolverFailure):
            return None

    def _seeker(self, function: Callable[[Sequence[Point]], Sequence[Seen]]) -> Seeker:
        slow = self.study.scenario.process in _SLOW
        return Seeker(
            function, [Range(one.low, one.high, one.whole) for one in self.search.between.values()],
            starts=32 if slow else 64, best=2 if slow else 4, rng=generator(self.study.seed, OPTIMISER),
            calls=self.search.runs,
        )  # fmt: skip

    def _robust(self) -> Best:
        """The best setting that is good often enough; once more, with more asked for, until fresh cases say so."""
        least = self.search.probability
        seeker = self._seeker(lambda points: self.trials.over_cases(points, least[0]))
        if len(least) > 1:
            return self._over_shares(seeker)
        if len(self.search.aims) == 2:
            found = front(seeker, self.search.points)
            settings = [self._proven(one, least[0]) for one in found if one.met] or [self._setting(found[0], least[0])]
            return self._told(seeker, settings[:1], settings if found[0].met else [])
        one, asked, attempts = seeker.solve(), least[0], []
        if not one.met:  # then the likeliest of all that were tried
            one = seeker.judged(
                _AS_SEEN, max(seeker.seen, key=lambda x: (_good(seeker.seen[x]), -seeker.seen[x].margins[0]))
            )
            return self._told(seeker, [self._proven(one, asked)], [])
        for _ in range(1 + _REPEATS):
            attempts.append(self._proven(one, asked) if one.met else self._setting(one, asked))
            fresh = attempts[-1].fresh
            if fresh is None or fresh.low >= least[0]:
                break
            asked = min(asked + max(fresh.half_width, least[0] - fresh.value), 1.0 - 0.5 / self.study.draws)
            more = self._seeker(lambda points, share=asked: self.trials.over_cases(points, share))
            one = more.solve(near=[one.at])
        return self._told(seeker, attempts, [])

    def _over_shares(self, seeker: Seeker) -> Best:
        """How good the aim can be for each share of good cases: a front, each point begun at the one before."""
        settings, near = [], []
        for share in self.search.probability:
            problem = Problem(
                lambda seen: seen.values[0], lambda seen, least=share: (quantile(seen.more["margins"], least),)
            )
            found = seeker.solve(problem, near)
            if not found.met:
                settings.append(self._setting(found, share))
                break
            settings.append(self._setting(found, share))
            near = [found.at]
        met = [one for one in settings if one.met]
        return self._told(seeker, [met[-1] if met else settings[0]], met)

    def _setting(self, found: Found, asked: float | None = None) -> Setting:
        one = found.seen.more
        aims = tuple(aim.sign * v for aim, v in zip(self.search.aims, found.seen.values, strict=True))
        share = None if asked is None else _share(one["good"])
        return Setting(self.trials.setting(found.at), aims, found.margin, one["measures"], share, None, asked)

    def _proven(self, found: Found, asked: float) -> Setting:
        """The setting, with its share of good ones among fresh cases."""
        setting = self._setting(found, asked)
        fresh = at_setting(self.study, setting.levers)._replace(seed=self.study.seed + 1, draws=FRESH)
        said = {"at": list(found.at), "cases": FRESH, "seed": fresh.seed, "proof": True}
        kept = self.trials.known_or([said], self._fresh)
        return setting._replace(fresh=_share(kept[0]["good"]))

    def _fresh(self, asked: list[dict[str, Any]]) -> list[dict[str, Any]]:
        found = []
        for one in asked:
            setting = self.trials.setting(tuple(one["at"]))
            fresh = at_setting(self.study, setting)._replace(seed=one["seed"], draws=one["cases"])
            errors, count = step_errors(fresh), one["cases"]
            pieces = [
                (one, self.trials.scales, first, min(_PIECE, count - first), errors)
                for first in range(0, count, _PIECE)
            ]
            parts = self.trials.pool.map(_run_cases, pieces)
            found.append({
                **one, "good": [g for part in parts for g in part["good"]],
                "said": [text for part in parts for text in part["said"]], "measures": {}, "margins": [],
            })  # fmt: skip
        return found

    def _told(
        self, seeker: Seeker, attempts: list[Setting], along: list[Setting], run: Result | None = None
    ) -> Best:  # fmt: skip
        tried = [self._setting(seeker.judged(_AS_SEEN, x), None) for x in seeker.seen]
        failed: dict[str, int] = {}
        for x in seeker.seen:
            for text in seeker.seen[x].more["said"]:
                failed[text] = failed.get(text, 0) + 1
        return Best(self.study, len(seeker.seen), tuple(attempts), tuple(along), tuple(tried), run, failed)


_AS_SEEN = Problem(lambda seen: seen.values[0], lambda seen: seen.margins)


def _too_near(run: Result) -> bool:
    """Whether the error of the step reaches across a limit."""
    return any(finding.code == "unconverged" for finding in run.findings)


def _shifted(seen: Seen, room: Sequence[float]) -> Seen:
    """A setting with limits that are drawn in."""
    return seen._replace(margins=tuple(m + off for m, off in zip(seen.margins, room, strict=True)))


def _good(seen: Seen) -> float:
    """The share of good cases at a setting; those that failed are none."""
    return sum(one == 1 for one in seen.more["good"]) / len(seen.more["good"])


def quantile(sorted_margins: Sequence[float], share: float) -> float:
    """The margin that a share of all cases does not exceed (``inverted_cdf``); 0 or below: at least that share is good.

    >>> quantile([-0.3, -0.2, -0.1, 0.4], 0.75)
    -0.1
    """
    return float(np.quantile(np.asarray(sorted_margins), share, method="inverted_cdf"))


def _share(good: Sequence[int]) -> Share:
    """Share of good ones among the cases that ended; one that failed is -1."""
    state = np.array(good)
    ended = state >= 0
    return share_of(state[ended] == 1, nets=bool(ended.all()) and len(state) % NETS == 0)


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
