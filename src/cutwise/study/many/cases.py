"""One chunk of a study: its cases evaluated one after the other, each as a run would give it, and judged."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.io.revision import Value, revisions
from cutwise.process.recipes import Outcome
from cutwise.results import SOUNDNESS
from cutwise.spec.scenario import Scenario
from cutwise.study.case import Case, evaluated
from cutwise.study.many.definition import Study, columns
from cutwise.study.many.reading import takes_coarse_step
from cutwise.study.trials import slack

FloatArray = NDArray[np.float64]

PROBED = 32  # first cases, which tell how far the coarse step is off
_NEAR = 3.0  # step errors from a limit, within which a case is run again with the step of the scenario

GOOD, BAD, INFEASIBLE, FAILED = range(4)
"""What a case is; infeasible is bad, failed is neither."""


class Chunk(NamedTuple):
    """Some cases."""

    first: int
    levers: dict[str, list[Value]]
    measures: dict[str, FloatArray]  # SI, NaN where a case does not have one
    state: NDArray[np.int64]
    finer: NDArray[np.bool_]  # run again with the step of the scenario
    said: list[str]  # why a case is infeasible, unsound or failed

    @property
    def count(self) -> int:
        """Number of cases."""
        return len(self.state)


def step_errors(study: Study) -> dict[str, float]:
    """Largest change of each required measure from the coarse step to the scenario's, over the first cases."""
    if not takes_coarse_step(study) or not study.scenario.requirements:
        return {}
    found = dict.fromkeys(study.scenario.requirements, 0.0)
    coarse, fine = _evaluators(study)
    levers = columns(study, 0, min(PROBED, study.cases))
    for values in _rows(levers):
        a, b = coarse(values).measures, fine(values).measures
        for name in found.keys() & a.keys() & b.keys():
            found[name] = max(found[name], abs(a[name] - b[name]))
    return found


def evaluate(
    study: Study, first: int, count: int, errors: Mapping[str, float], told: Callable[[int], object] | None = None
) -> Chunk:
    """Run some cases of a study.

    Parameters
    ----------
    study : Study
        The study.
    first, count : int
        The cases.
    errors : mapping
        :func:`step_errors`.
    told : callable, optional
        Called with the number of cases done.
    """
    levers = columns(study, first, count)
    coarse, fine = _evaluators(study)
    measures = {name: np.full(count, np.nan) for name in study.measures}
    state, finer, said = np.zeros(count, np.int64), np.zeros(count, bool), [""] * count
    for i, values in enumerate(_rows(levers)):
        case = coarse(values)
        for name in measures.keys() & case.measures.keys():
            measures[name][i] = case.measures[name]
        if errors and _borderline(study.scenario, case.outcome, errors):
            case, finer[i] = fine(values), True
        state[i], said[i] = _judged(study.scenario, case)
        if told is not None:
            told(i + 1)
    return Chunk(first, levers, measures, state, finer, said)


def case_of(study: Study, number: int) -> Scenario:
    """The scenario of one case, with the step of the scenario."""
    levers = columns(study, number, 1)
    return revisions(study.scenario)({key: values[0] for key, values in levers.items()})


Evaluator = Callable[[Mapping[str, Value]], Case]


def _evaluators(study: Study) -> tuple[Evaluator, Evaluator]:
    """Cases with the coarse step, and with the scenario's."""

    def of(scenario: Scenario, *, coarse: bool) -> Evaluator:
        revised = revisions(scenario)
        return lambda values: evaluated(revised(values) if values else scenario, values, study.measures, coarse=coarse)

    exact = of(study.scenario, coarse=False)
    if study.coarse is not None:
        return of(study.coarse, coarse=False), exact
    return (of(study.scenario, coarse=True) if takes_coarse_step(study) else exact), exact


def _rows(levers: Mapping[str, list[Value]]) -> list[dict[str, Value]]:
    return [dict(zip(levers, row, strict=True)) for row in zip(*levers.values(), strict=True)]


def _borderline(scenario: Scenario, outcome: Outcome, errors: Mapping[str, float]) -> bool:
    for name, limit in scenario.requirements.items():
        value = outcome.measures.get(name)
        for bound in (limit.min, limit.max):
            if value is not None and bound is not None and abs(value - bound) <= _NEAR * errors.get(name, 0.0):
                return True
    return False


def _judged(scenario: Scenario, case: Case) -> tuple[int, str]:
    if case.failure is not None:
        return FAILED, str(case.failure).splitlines()[0]
    if case.outcome.infeasible:
        return INFEASIBLE, case.outcome.infeasible[0]
    codes = [one.code for one in case.outcome.findings if one.code in SOUNDNESS and one.code not in scenario.set_aside]
    good = slack(scenario, case.outcome) >= 0.0 if scenario.requirements else not codes
    return (GOOD if good else BAD), ", ".join(dict.fromkeys(codes))
