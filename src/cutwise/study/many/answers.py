"""What a study says, of whatever part of it is there: shares with intervals, quantiles, indices, the worst cases."""

import math
import shlex
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from cutwise import units
from cutwise.spec import fields
from cutwise.spec.faults import split_dotted
from cutwise.study.many import folder as at
from cutwise.study.many.cases import GOOD
from cutwise.study.many.columns import Table, collected, pieces, row
from cutwise.study.many.decides import decides
from cutwise.study.many.definition import Study, of_indices
from cutwise.study.many.order import Pieces, finite, percentiles
from cutwise.study.many.statements import Effects, Indices, Share
from cutwise.study.many.tally import counted, farthest

_PERCENTS = (5, 50, 95)


class Answers(NamedTuple):
    """Everything that is said of a study."""

    study: Study
    table: Table  # columns of all finished cases of the prefix
    done: int
    shares: tuple[tuple[dict[str, Any], Share], ...]  # at each combination of design levers
    good: int  # cases
    finer: int  # run again with the step of the scenario
    failed: dict[str, int]  # reasons, with their numbers
    infeasible: dict[str, int]
    wrong: dict[str, int]  # requirement: cases that miss it
    indices: Mapping[str, Indices | Effects]  # by measure, and of "good"
    first: Mapping[str, int]  # case of each reason
    extremes: Mapping[str, float]  # value farthest beyond each requirement [SI]
    if_failed: tuple[tuple[Share, Share], ...] = ()  # shares if all that failed were bad, and if all were good
    unsound: Mapping[str, int] = MappingProxyType(
        {}
    )  # bad cases of which a run would warn: reasons, with their numbers

    @property
    def count_failed(self) -> int:
        """Cases that came to no end."""
        return sum(self.failed.values())


def answers(study: Study, folder: Path, size: int) -> Answers:
    """All answers of what is finished.

    Raises
    ------
    ValueError
        Nothing is.
    """
    table, done = collected(study, folder, size)
    if not done:
        raise ValueError("no case is finished yet")
    found = answers_of(study, table)
    beside = at.identity_in(at.indices_of(folder)) if study.indices else None
    if beside is None:
        return found
    more = of_indices(study)
    rows, runs = collected(more, at.indices_of(folder), int(beside["chunk"]))
    return found._replace(indices=decides(more, rows, runs)) if runs else found


def answers_of(study: Study, table: Table) -> Answers:
    """All answers of a table of cases."""
    found = counted(study, table)
    done = found.tally.done
    return Answers(
        study, table, done, tuple(found.tally.shares()) if study.scenario.asked and study.random else (),
        int(found.tally.states[GOOD]), found.finer,
        {text: one.cases for text, one in found.failed.items()},
        {text: one.cases for text, one in found.infeasible.items()},
        {text: one.cases for text, one in found.wrong.items()}, decides(study, table, done),
        {text: one.first for text, one in (found.infeasible | found.failed | found.unsound).items()},
        {text: one.extreme for text, one in found.wrong.items()},
        tuple(found.tally.if_failed()), {text: one.cases for text, one in found.unsound.items()},
    )  # fmt: skip


def worst(found: Answers, count: int) -> list[int]:
    """Numbers of the cases that are farthest beyond a limit; without limits, with the largest value of the focus."""
    return farthest(found.study, found.table, count)


def values_of(found: Answers, name: str) -> Pieces:
    """All values of a measure, piece by piece."""
    return lambda: (piece[f"measure {name}"] for piece in pieces(found.table, f"measure {name}"))


def command(found: Answers, case: int) -> str:
    """How a case is run again."""
    one = row(found.table, case)
    return rerun(found.study, {key: one[f"lever {key}"] for key in found.study.keys})


def rerun(study: Study, levers: Mapping[str, Any], *, exact: bool = False) -> str:
    """The command of a run with some values of the levers; ``exact``: to the last bit, as an optimum on a limit needs."""
    written = [text.partition("=")[::2] for text in study.given]
    written += [(key, as_written(study, key, value, exact=exact)) for key, value in levers.items()]
    return f"cutwise run {study.source} {' '.join(f'--set {key}={shlex.quote(value)}' for key, value in written)}"


def as_written(study: Study, key: str, value: Any, *, exact: bool = False) -> str:
    """A value of a lever as a scenario has it; a curve with its number."""
    if key in study.random and study.random[key].curve:
        where = study.scenario
        for step in split_dotted(key):
            where = getattr(where, str(step))
        said = where.model_dump(mode="json", exclude_none=True) | {"case": int(value)}
        return f"{{{', '.join(f'{name}: {one}' for name, one in said.items())}}}"
    dimension = dimension_of(study, key)
    if exact and dimension is not None and not isinstance(value, str):
        return units.text(float(value), dimension)
    return shown(study, key, value, 8)


def dimension_of(study: Study, key: str) -> str | None:
    """The dimension of a lever; None if it is no quantity."""
    if key in study.random and study.random[key].curve:
        return None  # a number of a curve
    return fields.dimension_at(type(study.scenario), split_dotted(key))


def shown(study: Study, key: str, value: Any, digits: int = 5) -> str:
    """A value of a lever as people write it."""
    dimension = dimension_of(study, key)
    return str(value) if dimension is None or isinstance(value, str) else units.show(float(value), dimension, digits)


def measures(found: Answers) -> dict[str, float]:
    """The numbers of a study by name, SI."""
    said: dict[str, float] = {"cases_done": float(found.done), "cases_failed": float(found.count_failed)}
    if len(found.shares) == 1:
        share = found.shares[0][1]
        said |= {
            "probability_good": share.value,
            "probability_good_low": share.low,
            "probability_good_high": share.high,
        }
    for name in found.study.measures:
        values = percentiles(values_of(found, name), _PERCENTS)
        if values is None:
            continue
        for percent, value in zip(_PERCENTS, values, strict=True):
            said[f"quantile_{percent:02d}_{name}"] = float(value)
        said |= _beyond(found, name)
    for name, one in found.indices.items():
        for i, key in enumerate(found.study.factor_names):
            if isinstance(one, Indices):
                said[f"index_first_{name}_{key}"] = float(one.first[i])
                said[f"index_total_{name}_{key}"] = float(one.total[i])
            else:
                said[f"effect_{name}_{key}"] = float(one.strength[i])
    return said


def _beyond(found: Answers, name: str) -> dict[str, float]:
    """Shares of the cases that have a measure and lie beyond its limits."""
    limit = found.study.scenario.asked.get(name)
    if limit is None:
        return {}
    count = above = below = 0
    for piece in values_of(found, name)():
        there = finite(piece)
        count += there.size
        above += int((there > limit.max).sum()) if limit.max is not None else 0
        below += int((there < limit.min).sum()) if limit.min is not None else 0
    said = {} if limit.max is None else {f"probability_above_{name}": above / count}
    return said if limit.min is None else said | {f"probability_below_{name}": below / count}


class GoodBand(NamedTuple):
    """Settings of a lever over which the share of good cases is reached, and its ends between two settings [SI]."""

    key: str
    low: float
    high: float
    open_low: bool  # the first setting is good enough itself: the band may go on beyond it
    open_high: bool


def good_bands(found: Answers) -> list[GoodBand]:
    """Where the demanded share is reached over the only design lever, linear between its settings; by the estimates."""
    study = found.study
    if study.demanded is None or len(study.design) != 1 or len(found.shares) < 2:
        return []
    key = next(iter(study.design))
    if any(isinstance(value, str) for value in study.design[key].values):
        return []
    order = sorted((float(values[key]), share.value - study.demanded) for values, share in found.shares)
    x, gap = np.array(order).T
    bands = []
    for first, last in _runs(gap >= 0.0):
        low = x[0] if first == 0 else np.interp(0.0, gap[first - 1 : first + 1], x[first - 1 : first + 1])
        high = x[-1] if last == len(x) - 1 else np.interp(0.0, gap[last : last + 2][::-1], x[last : last + 2][::-1])
        bands.append(GoodBand(key, float(low), float(high), first == 0, last == len(x) - 1))
    return bands


def _runs(reached: np.ndarray) -> list[tuple[int, int]]:
    """First and last place of each stretch that is true."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], reached, [False])).astype(int)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def demanded(found: Answers) -> tuple[bool, str] | None:
    """Whether the demanded share of good cases is reached, and what is said of it; None without a demand."""
    least = found.study.demanded
    if least is None or not found.shares:
        return None
    shares = [one for _, one in found.shares]
    worst_of, best_of = (
        (list(some) for some in zip(*found.if_failed, strict=True)) if found.if_failed else (shares, shares)
    )
    if min(one.low for one in worst_of) >= least:
        return True, f"P(good) of at least {least:g} is met"
    if min(one.high for one in best_of) < least:
        return False, f"P(good) of at least {least:g} is not met"
    share = min(shares, key=lambda one: one.low)
    if found.if_failed and share.low >= least:
        return (
            False,
            f"whether P(good) reaches {least:g} cannot be told: {found.count_failed:,} cases failed, which may be bad",
        )
    gap = abs(share.value - least)
    needed = math.ceil(found.done * (share.half_width / gap) ** 2) if gap > 0.0 else None
    more = f"about {needed:,} would be needed" if needed is not None else "the estimate lies on it"
    return False, f"whether P(good) reaches {least:g} cannot be told with {found.done:,} cases; {more}"
