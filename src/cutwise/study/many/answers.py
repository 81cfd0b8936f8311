"""What a study says, of whatever part of it is there: shares with intervals, quantiles, indices, the worst cases."""

import math
import shlex
from collections.abc import Mapping
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise import units
from cutwise.spec import fields
from cutwise.spec.faults import split_dotted
from cutwise.study.many import folder as at
from cutwise.study.many.cases import BAD, FAILED, GOOD, INFEASIBLE
from cutwise.study.many.definition import INDICES, MORRIS, SOBOL, Study, combinations, trajectories
from cutwise.study.many.draws import MORRIS as MORRIS_DRAWS
from cutwise.study.many.draws import NETS, generator
from cutwise.study.many.statements import Effects, Indices, Share, elementary_effects, share_of, sobol_indices

FloatArray = NDArray[np.float64]


class Answers(NamedTuple):
    """Everything that is said of a study."""

    study: Study
    table: Mapping[str, np.ndarray]  # columns of all finished cases of the prefix
    done: int
    shares: tuple[tuple[dict[str, Any], Share], ...]  # at each combination of design levers
    failed: dict[str, int]  # reasons, with their numbers
    infeasible: dict[str, int]
    wrong: dict[str, int]  # requirement: cases that miss it
    indices: Mapping[str, Indices | Effects]  # by measure, and of "good"

    @property
    def count_failed(self) -> int:
        """Cases that came to no end."""
        return sum(self.failed.values())


def collected(study: Study, folder: Path, size: int) -> tuple[dict[str, np.ndarray], int]:
    """The columns of the finished prefix of all cases, and its length."""
    there = prefix(study, folder, size)
    done = sum(count for _, count in there)
    found: dict[str, np.ndarray] = {}
    for first, count in there:
        for name, values in at.read_part(at.part_file(folder, first, count)).items():
            if name not in found:  # once for all: joining parts would take the room twice
                found[name] = np.empty(done, values.dtype)
            found[name][first : first + count] = values
    return found, done


def prefix(study: Study, folder: Path, size: int) -> list[tuple[int, int]]:
    """First case and number of cases of the finished parts, up to the first that is missing."""
    return list(takewhile(lambda one: at.part_file(folder, *one).exists(), at.chunks(study, size)))


def share_of_prefix(study: Study, folder: Path, size: int) -> Share | None:
    """The widest interval over the design levers, as soon as there are enough cases for the stop rule."""
    if study.stop is None:
        return None
    there = prefix(study, folder, size)
    done = sum(count for _, count in there)
    least = study.stop.at_least * study.combinations
    if done < least or (study.method == SOBOL and (done // study.combinations) % NETS):
        return None
    state = np.concatenate([at.read_part(at.part_file(folder, *one), "state")["state"] for one in there])
    return max((share for _, share in shares_of(study, {"state": state}, done)), key=lambda share: share.half_width)


def shares_of(study: Study, table: Mapping[str, np.ndarray], done: int) -> list[tuple[dict[str, Any], Share]]:
    """The share of good cases at each combination of design levers, of columns of the first ``done`` cases."""
    if study.method == MORRIS:
        return []  # its points are levels of a plan, no draws
    level = study.stop.level if study.stop is not None else 0.95
    found: list[tuple[dict[str, Any], Share]] = []
    rows = done // study.combinations
    usable = rows - rows % NETS if study.method == SOBOL else rows
    for k, values in enumerate(combinations(study)):
        state = table["state"][k : usable * study.combinations : study.combinations]
        if study.method == INDICES:  # rows A and B are draws; those between them repeat their numbers
            state = state[np.arange(len(state)) % (len(study.factors) + 2) < 2]
        ended = state != FAILED
        nets = study.method == SOBOL and bool(ended.all())
        found.append((values, share_of(state[ended] == GOOD, nets=nets, level=level)))
    return found


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
    state, said = table["state"], table["said"]
    return Answers(
        study, table, done, tuple(shares_of(study, table, done)) if study.scenario.asked and study.random else (),
        _counted(said[state == FAILED]), _counted(said[state == INFEASIBLE]),
        {text: int(mask.sum()) for text, mask in missed(study, table).items()},
        _decides(study, table, done),
    )  # fmt: skip


def _counted(said: np.ndarray) -> dict[str, int]:
    return {str(text): int((said == text).sum()) for text in dict.fromkeys(said.tolist())}


def missed(study: Study, table: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Which bad cases miss each requirement, by the words of its limit; a case may miss several."""
    found = {}
    bad = table["state"] == BAD
    for name, limit in study.scenario.asked.items():
        dimension = study.scenario.measures[name].dimension
        value = table[f"measure {name}"]
        for bound, misses, words in ((limit.max, np.greater, "above"), (limit.min, np.less, "below")):
            if bound is not None:
                found[f"{name} {words} {units.show(bound, dimension, 4)}"] = misses(value, bound) & bad
    return found


def _decides(study: Study, table: Mapping[str, np.ndarray], done: int) -> dict[str, Indices | Effects]:
    inputs = len(study.factors)
    if study.method not in (INDICES, MORRIS) or study.combinations != 1:
        return {}
    each = inputs + (2 if study.method == INDICES else 1)
    rows = done // each
    if rows < 2:
        return {}
    values = {name: table[f"measure {name}"][: rows * each] for name in study.measures}
    if study.scenario.asked:
        values["good"] = (table["state"][: rows * each] == GOOD).astype(float)
    found: dict[str, Indices | Effects] = {}
    for name, column in values.items():
        some = column.reshape(rows, each)
        if not np.isfinite(some).all():
            continue  # a case has no such number: no index of it
        if study.method == INDICES:
            found[name] = sobol_indices(some, study.seed)
            continue
        _, order, moved = trajectories(inputs, study.draws, study.levels, generator(study.seed, MORRIS_DRAWS))
        before, after, step = (np.empty((rows, inputs)) for _ in range(3))
        for r in range(rows):
            for k, i in enumerate(order[r]):
                before[r, i], after[r, i], step[r, i] = some[r, k], some[r, k + 1], moved[r, k]
        found[name] = elementary_effects(before, after, step)
    return found


def worst(found: Answers, count: int) -> list[int]:
    """Numbers of the cases that are farthest beyond a limit; without limits, with the largest value of the focus."""
    study, table = found.study, found.table
    if study.scenario.asked:
        beyond = np.where(table["state"] == FAILED, -np.inf, table["margin"])  # the failed ones are listed by reason
    elif study.measures:
        beyond = np.abs(table[f"measure {study.measures[0]}"])
    else:
        beyond = np.full(found.done, -np.inf)
    order = np.argsort(-np.where(np.isfinite(beyond), beyond, -np.inf), kind="stable")
    return [int(i) for i in order[:count]]


def command(found: Answers, case: int) -> str:
    """How a case is run again."""
    return rerun(found.study, {key: found.table[f"lever {key}"][case] for key in found.study.keys})


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
        values = found.table[f"measure {name}"]
        values = values[np.isfinite(values)]
        if values.size:
            for percent in (5, 50, 95):
                said[f"quantile_{percent:02d}_{name}"] = float(np.percentile(values, percent))
        limit = found.study.scenario.asked.get(name)
        if limit is not None and values.size:
            if limit.max is not None:
                said[f"probability_above_{name}"] = float((values > limit.max).mean())
            if limit.min is not None:
                said[f"probability_below_{name}"] = float((values < limit.min).mean())
    for name, one in found.indices.items():
        for i, key in enumerate(found.study.factor_names):
            if isinstance(one, Indices):
                said[f"index_first_{name}_{key}"] = float(one.first[i])
                said[f"index_total_{name}_{key}"] = float(one.total[i])
            else:
                said[f"effect_{name}_{key}"] = float(one.strength[i])
    return said


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
    share = min((one for _, one in found.shares), key=lambda one: one.low)
    if share.low >= least:
        return True, f"P(good) of at least {least:g} is met"
    if share.high < least:
        return False, f"P(good) of at least {least:g} is not met"
    gap = abs(share.value - least)
    needed = math.ceil(found.done * (share.half_width / gap) ** 2) if gap > 0.0 else None
    more = f"about {needed:,} would be needed" if needed is not None else "the estimate lies on it"
    return False, f"whether P(good) reaches {least:g} cannot be told with {found.done:,} cases; {more}"
