"""Answers of a study held against full runs: the case in the middle and the worst ones are run as ``run`` does."""

from typing import NamedTuple

import numpy as np

from cutwise.results import SolverFailure
from cutwise.spec.faults import ScenarioFault
from cutwise.study.band import simulate
from cutwise.study.many.answers import Answers, values_of, worst
from cutwise.study.many.cases import FAILED, case_of
from cutwise.study.many.columns import row
from cutwise.study.many.order import in_order

WORST = 3
TOO_COARSE = 0.1
"""Share of a tolerance that a measure may change in the full run before the step is called too coarse."""


class Against(NamedTuple):
    """What full runs say of a study."""

    cases: tuple[int, ...]  # that were run
    changes: dict[str, float]  # largest change of each required measure, or of the others [SI]
    share: float  # the largest change over its tolerance; 0 without requirements
    lost: tuple[str, ...]  # cases whose full run came to no end

    @property
    def too_coarse(self) -> bool:
        """Whether the step of the study makes a difference that counts."""
        return self.share > TOO_COARSE


def against_full_runs(found: Answers) -> Against:
    """Run the median case and the worst three in full, and hold the numbers of the study against them."""
    study = found.study
    names = tuple(study.scenario.asked) or study.measures
    changes: dict[str, float] = {}
    lost, chosen = [], []
    for case in dict.fromkeys((*_median(found, names), *worst(found, WORST))):
        told = row(found.table, case)
        if told["state"] == FAILED:
            continue
        chosen.append(case)
        try:
            run = simulate(case_of(study, case))
        except (ScenarioFault, SolverFailure) as why:
            lost.append(f"case {case}: {str(why).splitlines()[0]}")
            continue
        for name in names:
            value = float(told[f"measure {name}"])
            if name in run.measures and np.isfinite(value):
                changes[name] = max(changes.get(name, 0.0), abs(run.measures[name].value - value))
    share = max(
        (change / tolerance(found, name) for name, change in changes.items() if name in study.scenario.asked),
        default=0.0,
    )
    return Against(tuple(chosen), changes, share, tuple(lost))


def tolerance(found: Answers, name: str) -> float:
    """What a change of a required measure is held against: half of the way between two limits, or one limit [SI]."""
    limit = found.study.scenario.asked[name]
    if limit.min is not None and limit.max is not None and limit.max > limit.min:
        return 0.5 * (limit.max - limit.min)
    return max((abs(end) for end in (limit.min, limit.max) if end is not None), default=0.0) or 1.0


def _median(found: Answers, names: tuple[str, ...]) -> list[int]:
    """The case in the middle of the first measure."""
    if not names:
        return []
    middle, count = in_order(values_of(found, names[0]), lambda n: [n // 2])
    first = 0
    for values in values_of(found, names[0])() if count else ():
        at = np.flatnonzero(values == middle[0])
        if at.size:
            return [first + int(at[0])]
        first += len(values)
    return []
