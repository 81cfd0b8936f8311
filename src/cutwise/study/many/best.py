"""The best setting of a study: every setting that is tried is kept, the best is run in full and held against fresh cases."""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cutwise.results import Result, SolverFailure
from cutwise.spec.faults import ScenarioFault
from cutwise.study.band import simulate
from cutwise.study.limits import bounds, scaled
from cutwise.study.many.cases import scenario_of, takes_coarse_step
from cutwise.study.many.definition import Study, at_setting
from cutwise.study.many.draws import OPTIMISER, generator
from cutwise.study.many.engine import LOCAL, begun, checked
from cutwise.study.many.pool import Pool, Unfinished, pooled
from cutwise.study.many.tried import Setting, Tried, quantile, reasons, share_of_cases
from cutwise.study.optimum import FloatArray, Found, Point, Problem, Range, Seeker, Seen, front

FRESH = 4096
"""Cases, none of which the search has seen, that a robust optimum is held against."""

_REPEATS = 3  # of a robust search whose result the fresh cases do not prove
_ROOM = (
    2.2  # changes on a halved step that an optimum stays off its limits: a run counts twice that change as its error
)
_SLOW = ("deburr", "drill")  # whose runs are long for what their levers do: fewer starts
Progress = Callable[[int, int], object]


class Best(NamedTuple):
    """What an optimisation came to."""

    study: Study
    done: int  # settings that were tried
    optima: tuple[Setting, ...]  # one; of a robust one every attempt, the last is the answer
    front: tuple[Setting, ...]
    tried: tuple[Setting, ...]
    run: Result | None  # of the optimum, in full; of a robust one there is none: fresh cases tell
    failed: Mapping[str, int]  # reasons, with their numbers
    unfinished: bool = False  # the best so far, of a search that was stopped

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
        if not best.met or self.unfinished:
            return False
        if best.asked is None:
            return (
                self.run is not None and self.run.verdict != "fail" and all(one.verdict != "fail" for one in self.front)
            )
        assert self.study.search is not None
        if self.front and best.fresh is None:  # over several shares, which are told as those of its own cases
            return True
        least = self.study.search.probability[-1]
        return all(one.fresh is not None and one.fresh.low >= least for one in self.front or (best,))


def optimised(
    study: Study, folder: Path, *, jobs: int = 1, resume: bool = False, progress: Progress | None = None,
    executor: str = LOCAL, address: str | None = None, accept_version: bool = False,
) -> Best:  # fmt: skip
    """Look for the best setting of a study; with ``resume`` what was tried before is not tried again.

    Parameters
    ----------
    study, folder
        The study, and where its trials are kept.
    jobs, executor, address, accept_version
        As of :func:`cutwise.study.many.engine.run_study`.
    resume : bool
        Go on with the trials that are there.
    progress : callable, optional
        Told how many settings were tried.

    Raises
    ------
    ScenarioFault
        The folder holds another study, or trials of this one without ``resume``.
    """
    checked(executor, address)
    known = begun(study, folder, resume=resume, accept_version=accept_version)
    with pooled(study, jobs, executor, address) as pool:
        return _Searched(study, Tried(study, folder, known["scales"], pool, progress)).best()


def told(study: Study, folder: Path, known: Mapping[str, Any]) -> Best:
    """What the trials in a folder say; nothing further is tried, and of a search that is not finished the best so far.

    Raises
    ------
    ValueError
        There is no trial yet.
    """
    tried = Tried(study, folder, known["scales"], Pool.none(study), None)
    try:
        return _Searched(study, tried).best()
    except Unfinished:
        return so_far(study, folder, known)


def so_far(study: Study, folder: Path, known: Mapping[str, Any]) -> Best:
    """All settings that were tried, and the best of them."""
    found = Tried(study, folder, known["scales"], Pool.none(study), None)
    some = found.so_far()
    if not some:
        raise ValueError("no setting was tried yet")
    assert study.search is not None
    sign = study.search.aims[0].sign

    def rank(one: Setting) -> tuple[float, float]:
        value = sign * one.aims[0]
        return (0.0, value) if one.met and math.isfinite(value) else (max(one.margin, 1e-300), 0.0)

    return Best(study, len(some), (min(some, key=rank),), (), tuple(some), None, found.failed(), unfinished=True)


class _Searched:
    """From trials to the answer."""

    def __init__(self, study: Study, trials: Tried) -> None:
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
            problem = Problem(lambda seen: seen.values[0], partial(_drawn_in, room=off))
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
            seeker = self._seeker(partial(self._off_limits, room=room, fine=fine))
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

    def _off_limits(self, points: Sequence[Point], room: Sequence[float] | FloatArray, *, fine: bool) -> list[Seen]:
        """Each setting as one run, its limits drawn in."""
        return [_shifted(one, room) for one in self.trials.one_by_one(points, fine=fine)]

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
            more = self._seeker(partial(self.trials.over_cases, share=asked))
            one = more.solve(near=[one.at])
        return self._told(seeker, attempts, [])

    def _over_shares(self, seeker: Seeker) -> Best:
        """How good the aim can be for each share of good cases: a front, each point begun at the one before."""
        settings: list[Setting] = []
        near: list[Point] = []
        for share in self.search.probability:
            problem = Problem(lambda seen: seen.values[0], partial(_at_share, share=share))
            found = seeker.solve(problem, near)
            if not found.met:
                settings.append(self._setting(found, share))
                break
            settings.append(self._setting(found, share))
            near = [found.at]
        met = [one for one in settings if one.met]
        return self._told(seeker, [met[-1] if met else settings[0]], met)

    def _setting(self, found: Found, asked: float | None = None) -> Setting:
        return self.trials.as_setting(found, asked)

    def _proven(self, found: Found, asked: float) -> Setting:
        """The setting, with its share of good ones among fresh cases."""
        setting = self._setting(found, asked)
        fresh = at_setting(self.study, setting.levers)._replace(seed=self.study.seed + 1, draws=FRESH)
        said = {"at": list(found.at), "cases": FRESH, "seed": fresh.seed, "proof": True}
        kept = self.trials.fresh([said])
        return setting._replace(fresh=share_of_cases(kept[0]["good"]))

    def _told(
        self, seeker: Seeker, attempts: list[Setting], along: list[Setting], run: Result | None = None
    ) -> Best:  # fmt: skip
        tried = [self._setting(seeker.judged(_AS_SEEN, x), None) for x in seeker.seen]
        return Best(
            self.study,
            len(seeker.seen),
            tuple(attempts),
            tuple(along),
            tuple(tried),
            run,
            reasons(one.more for one in seeker.seen.values()),
        )


_AS_SEEN = Problem(lambda seen: seen.values[0], lambda seen: seen.margins)


def _too_near(run: Result) -> bool:
    """Whether the error of the step reaches across a limit."""
    return any(finding.code == "unconverged" for finding in run.findings)


def _shifted(seen: Seen, room: Sequence[float] | FloatArray) -> Seen:
    """A setting with limits that are drawn in."""
    return seen._replace(margins=tuple(m + off for m, off in zip(seen.margins, room, strict=True)))


def _drawn_in(seen: Seen, room: Sequence[float]) -> tuple[float, ...]:
    """Margins of a setting whose limits are drawn in."""
    return _shifted(seen, room).margins


def _at_share(seen: Seen, share: float) -> tuple[float]:
    """The margin that a share of the cases keeps."""
    return (quantile(seen.more["margins"], share),)


def _good(seen: Seen) -> float:
    """The share of good cases at a setting; those that failed are none."""
    return sum(one == 1 for one in seen.more["good"]) / len(seen.more["good"])
