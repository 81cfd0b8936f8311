"""Counts over the cases of a study, piece by piece: shares of good ones, reasons, the cases farthest beyond a limit."""

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cutwise import units
from cutwise.study.many import folder as at
from cutwise.study.many.cases import BAD, FAILED, GOOD, INFEASIBLE
from cutwise.study.many.columns import Table, pieces
from cutwise.study.many.definition import INDICES, MORRIS, SOBOL, Study, combinations
from cutwise.study.many.draws import NETS
from cutwise.study.many.statements import Share, share_of_counts

_REASONS = 1000  # that are told apart
_OTHERS = "for other reasons"
_STATES = 4
_LOOKED = 256  # draws between two looks of the stop rule

Shares = list[tuple[dict[str, Any], Share]]
"""Settings of the design levers, and the share of good cases there."""


class Tally:
    """States of the first cases of a study, counted: at each combination of design levers, net by net."""

    def __init__(self, study: Study) -> None:
        self.study = study
        self.states = np.zeros(_STATES, dtype=np.int64)
        self._nets = NETS if study.method == SOBOL else 1
        self._group = self._nets * study.combinations
        self._rest = np.empty(0, dtype=np.int64)  # of a group that is not whole yet
        self._good = np.zeros((self._nets, study.combinations), dtype=np.int64)
        self._ended = np.zeros_like(self._good)
        self._rows = 0
        self._drawn = 0  # of the rows, those that are draws

    @property
    def done(self) -> int:
        """Number of cases."""
        return int(self.states.sum())

    def add(self, state: np.ndarray) -> None:
        """Count the next cases."""
        self.states += np.bincount(state, minlength=_STATES)
        joined = np.concatenate([self._rest, state])
        whole = joined.size - joined.size % self._group
        self._rest = joined[whole:]
        draws = joined[:whole].reshape(-1, self.study.combinations)
        rows = self._rows + np.arange(len(draws))
        self._rows += len(draws)
        if self.study.method == INDICES:  # rows A and B are draws; those between them repeat their numbers
            mine = rows % (len(self.study.factors) + 2) < 2
            draws, rows = draws[mine], rows[mine]
        self._drawn += len(draws)
        for net in range(self._nets):
            some = draws[rows % self._nets == net]
            self._good[net] += (some == GOOD).sum(axis=0)
            self._ended[net] += (some != FAILED).sum(axis=0)

    def shares(self) -> Shares:
        """The share of good cases at each combination, of whole groups of cases."""
        if self.study.method == MORRIS:
            return []  # its points are levels of a plan, no draws
        level = self.study.stop.level if self.study.stop is not None else 0.95
        each = self._rows // self._nets
        found: Shares = []
        for k, values in enumerate(combinations(self.study)):
            nets = self.study.method == SOBOL and bool((self._ended[:, k] == each).all())
            found.append((values, share_of_counts(self._good[:, k], self._ended[:, k], nets=nets, level=level)))
        return found

    def if_failed(self) -> list[tuple[Share, Share]]:
        """The shares if every case that failed were bad, and if every one were good; none where no case failed."""
        level = self.study.stop.level if self.study.stop is not None else 0.95
        count = np.array([self._drawn // self._nets] * self._nets)
        nets = self.study.method == SOBOL
        if self.study.method == MORRIS or (self._ended == count[:, None]).all():
            return []
        lost = count[:, None] - self._ended
        return [
            (
                share_of_counts(self._good[:, k], count, nets=nets, level=level),
                share_of_counts(self._good[:, k] + lost[:, k], count, nets=nets, level=level),
            )
            for k in range(self.study.combinations)
        ]


class Following(Tally):
    """The tally of the finished prefix of a folder; each part is read once.

    The stop rule is looked at after every 256 draws, with Sobol nets at 8, 16, 32, ... of them, where nets are balanced:
    it depends on the cases alone, not on the parts they came in.
    """

    def __init__(self, study: Study, folder: Path, size: int) -> None:
        super().__init__(study)
        self._folder, self._left = folder, at.chunks(study, size)
        self._next = next(self._left, None)
        self._narrow = False
        self._looks = self._sizes()
        self._look_at = next(self._looks)

    def look(self) -> None:
        """Count the parts that have come."""
        while self._next is not None and (file := at.part_file(self._folder, *self._next)).exists():
            state = at.read_part(file, ("state",))["state"]
            while self.done + len(state) >= self._look_at:
                here = self._look_at - self.done
                self.add(state[:here])
                state = state[here:]
                self._narrow = self._narrow or self._is_narrow()
                self._look_at = next(self._looks)
            self.add(state)
            self._next = next(self._left, None)

    def enough(self) -> bool:
        """Whether the prefix satisfies the stop rule: at every combination of design levers."""
        self.look()
        return self._narrow

    def _sizes(self) -> Iterator[int]:
        """Cases after which the stop rule is looked at."""
        if self.study.stop is None:
            yield sys.maxsize
            return
        draws, least = _LOOKED, self.study.stop.at_least
        if self.study.method == SOBOL:
            draws = NETS
        while True:
            if draws >= least:
                of_indices = self.study.method == INDICES  # two draws in a row of so many cases
                rows = draws // 2 * (len(self.study.factors) + 2) if of_indices else draws
                yield rows * self.study.combinations
            draws += draws if self.study.method == SOBOL else _LOOKED

    def _is_narrow(self) -> bool:
        assert self.study.stop is not None
        width = max((share.half_width for _, share in self.shares()), default=np.inf)
        return bool(np.isfinite(width)) and width <= self.study.stop.half_width


class Reason(NamedTuple):
    """Why cases failed or are infeasible."""

    cases: int
    first: int  # case


class Missed(NamedTuple):
    """Bad cases that miss a limit."""

    cases: int
    extreme: float  # value farthest beyond it [SI]


class Counted(NamedTuple):
    """What one look at all cases tells."""

    tally: Tally
    finer: int
    failed: dict[str, Reason]
    infeasible: dict[str, Reason]
    unsound: dict[str, Reason]
    wrong: dict[str, Missed]


def counted(study: Study, table: Table) -> Counted:
    """Count all cases of a table."""
    tally, finer, first = Tally(study), 0, 0
    failed: dict[str, Reason] = {}
    infeasible: dict[str, Reason] = {}
    unsound: dict[str, Reason] = {}
    wrong: dict[str, Missed] = {}
    names = [f"measure {name}" for name in study.scenario.asked]
    for piece in pieces(table, "state", "finer", "said", *names):
        state = piece["state"]
        tally.add(state)
        finer += int(piece["finer"].sum())
        for kind, reasons in ((FAILED, failed), (INFEASIBLE, infeasible), (BAD, unsound)):
            for i in np.flatnonzero((state == kind) & (piece["said"] != "")):
                _count(reasons, str(piece["said"][i]), first + int(i))
        for text, (mask, value, beyond) in _missed(study, piece).items():
            known = wrong.get(text, Missed(0, np.nan))
            extreme = beyond([known.extreme, *value[mask]]) if mask.any() else known.extreme
            wrong[text] = Missed(known.cases + int(mask.sum()), float(extreme))
        first += len(state)
    return Counted(tally, finer, failed, infeasible, unsound, wrong)


def _count(reasons: dict[str, Reason], text: str, case: int) -> None:
    name = text if text in reasons or len(reasons) < _REASONS else _OTHERS
    known = reasons.get(name, Reason(0, case))
    reasons[name] = known._replace(cases=known.cases + 1)


def missed(study: Study, piece: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Which bad cases miss each requirement, by the words of its limit; a case may miss several."""
    return {text: mask for text, (mask, _, _) in _missed(study, piece).items()}


def _missed(study: Study, piece: Mapping[str, np.ndarray]) -> dict[str, tuple[np.ndarray, np.ndarray, Any]]:
    found = {}
    bad = piece["state"] == BAD
    for name, limit in study.scenario.asked.items():
        dimension = study.scenario.measures[name].dimension
        value = piece[f"measure {name}"]
        for bound, misses, words, most in (
            (limit.max, np.greater, "above", np.nanmax), (limit.min, np.less, "below", np.nanmin),
        ):  # fmt: skip
            if bound is not None:
                found[f"{name} {words} {units.show(bound, dimension, 4)}"] = misses(value, bound) & bad, value, most
    return found


def farthest(study: Study, table: Table, count: int) -> list[int]:
    """Numbers of the cases that are farthest beyond a limit; without limits, with the largest value of the focus."""
    found: list[tuple[float, int]] = []
    first = 0
    for beyond in _distances(study, table):
        near = np.where(np.isfinite(beyond), -beyond, np.inf)
        few = np.argsort(near, kind="stable")[:count]
        found = sorted(found + [(float(near[i]), first + int(i)) for i in few])[:count]
        first += len(beyond)
    return [case for _, case in found]


def _distances(study: Study, table: Table) -> Iterator[np.ndarray]:
    """How far each case is beyond, piece by piece; the failed ones are listed by reason."""
    if study.scenario.asked:
        for piece in pieces(table, "state", "margin"):
            yield np.where(piece["state"] == FAILED, -np.inf, piece["margin"])
    elif study.measures:
        for piece in pieces(table, name := f"measure {study.measures[0]}"):
            yield np.abs(piece[name])
    else:
        for piece in pieces(table, "case"):
            yield np.full(len(piece["case"]), -np.inf)
