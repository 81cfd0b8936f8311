"""One chunk of a study: its cases evaluated one after the other, each as a run would give it, and judged."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.io.revision import Value, revisions
from cutwise.process.recipes import Outcome, coarser
from cutwise.results import SOUNDNESS, in_words
from cutwise.spec import fields
from cutwise.spec.faults import Path, dotted, split_dotted
from cutwise.spec.scenario import Scenario
from cutwise.study.case import Case, Evaluate, cases
from cutwise.study.inputs import overrides, scatter_of
from cutwise.study.limits import BEYOND, bounds, margin
from cutwise.study.many.definition import Study, columns

FloatArray = NDArray[np.float64]

PROBED = 32  # first cases, which tell how far the coarse step is off
_NEAR = 3.0  # step errors from a limit, within which a case is run again with the step of the scenario

GOOD, BAD, INFEASIBLE, FAILED = range(4)
"""What a case is; infeasible is bad, failed is neither."""


class Chunk(NamedTuple):
    """Some cases."""

    first: int
    levers: dict[str, list[Value]]
    measures: dict[str, FloatArray]  # SI, NaN where a case does not have one; near a limit with the step that decided
    state: NDArray[np.int64]
    margin: FloatArray  # farthest beyond a limit, above 0 is bad; with the step that decided
    finer: NDArray[np.bool_]  # run again with the step of the scenario
    said: list[str]  # why a case is infeasible, unsound or failed

    @property
    def cases(self) -> int:
        """How many they are."""
        return len(self.state)


def step_errors(study: Study) -> dict[str, float]:
    """Largest change of each required measure from the coarse step to the scenario's, over the first cases."""
    if not takes_coarse_step(study) or not study.scenario.asked:
        return {}
    found = dict.fromkeys(study.scenario.asked, 0.0)
    coarse, fine = evaluators(study)
    for values in rows(columns(study, 0, min(PROBED, study.cases))):
        a, b = coarse(values).measures, fine(values).measures
        for name in found.keys() & a.keys() & b.keys():
            found[name] = max(found[name], abs(a[name] - b[name]))
    return found


def takes_coarse_step(study: Study) -> bool:
    """Whether the bulk of the cases is run with a larger step than the scenario's."""
    return study.coarse is not None or coarser(study.scenario)


def limit_scales(study: Study) -> dict[str, float]:
    """What a distance from a limit of zero is counted in: the largest magnitude over the first cases [SI]."""
    names = {bound.measure for bound in bounds(study.scenario) if bound.value == 0.0}
    if not names:
        return {}
    coarse, found = evaluators(study)[0], dict.fromkeys(names, 0.0)
    for values in rows(columns(study, 0, min(PROBED, study.cases))):
        measures = coarse(values).measures
        for name in names & measures.keys():
            found[name] = max(found[name], abs(measures[name]))
    return found


def evaluate(
    study: Study, first: int, count: int, errors: Mapping[str, float], told: Callable[[int], object] | None = None,
    scales: Mapping[str, float] | None = None,
) -> Chunk:  # fmt: skip
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
    scales : mapping, optional
        :func:`limit_scales`.
    """
    return evaluate_levers(study, first, columns(study, first, count), errors, told, scales)


def evaluate_levers(
    study: Study, first: int, levers: dict[str, list[Value]], errors: Mapping[str, float],
    told: Callable[[int], object] | None = None, scales: Mapping[str, float] | None = None,
) -> Chunk:  # fmt: skip
    """Run cases of given levers, numbered from ``first`` on; see :func:`evaluate`."""
    coarse, fine = evaluators(study)
    each = rows(levers)
    count = len(each)
    measures = {name: np.full(count, np.nan) for name in study.measures}
    state, finer, said = np.zeros(count, np.int64), np.zeros(count, bool), [""] * count
    far = np.zeros(count)
    for i, values in enumerate(each):
        case = coarse(values)
        for name in measures.keys() & case.measures.keys():
            measures[name][i] = case.measures[name]
        near = _borderline(study.scenario, case.outcome, errors) if errors else frozenset()
        if near:
            case, finer[i] = fine(values), True
            for name in near & measures.keys():  # those at a limit, which say why; the others keep to one step
                measures[name][i] = case.measures.get(name, np.nan)
        far[i] = margin(study.scenario, case.outcome, scales) if case.failure is None else BEYOND
        state[i], said[i] = _judged(study.scenario, case, float(far[i]))
        if told is not None:
            told(i + 1)
    return Chunk(first, levers, measures, state, far, finer, said)


def case_of(study: Study, number: int) -> Scenario:
    """The scenario of one case, with the step of the scenario."""
    return scenario_of(study, rows(columns(study, number, 1))[0])


def scenario_of(study: Study, values: Mapping[str, Value]) -> Scenario:
    """The scenario with some values of its levers, with the step of the scenario."""
    return _revised(study, study.scenario)(values)


Evaluator = Evaluate


def evaluators(study: Study) -> tuple[Evaluator, Evaluator]:
    """Cases with the coarse step, and with the scenario's."""

    def of(scenario: Scenario, *, coarse: bool) -> Evaluator:
        return cases(scenario, study.measures, coarse=coarse, revised=_revised(study, scenario))

    exact = of(study.scenario, coarse=False)
    if study.coarse is not None:
        return of(study.coarse, coarse=not coarser(study.coarse)), exact  # no larger step yet, but lean
    return (of(study.scenario, coarse=True) if takes_coarse_step(study) else exact), exact


def _revised(study: Study, scenario: Scenario) -> Callable[[Mapping[str, Value]], Scenario]:
    """A function from levers to the scenario: numbers of curves, and numbers inside of lists, too."""
    revised, leaves = revisions(scenario), {dotted(path) for path, _, _ in fields.leaves(scenario)}
    inside = [one for one in scatter_of(scenario).inputs if one.key in study.random and one.key not in leaves]
    into_lists = overrides(scenario, inside)

    def of(values: Mapping[str, Value]) -> Scenario:
        curves = {
            key: int(_number(values[key])) for key, lever in study.random.items() if lever.curve and key in values
        }
        listed = {place: _number(values[one.key]) for place, one in enumerate(inside) if one.key in values}
        taken = {*curves, *(inside[place].key for place in listed)}
        plain = {key: value for key, value in values.items() if key not in taken} | into_lists(listed)
        found = revised(plain) if plain else scenario
        for key, number in curves.items():
            found = with_curve(found, split_dotted(key), number)
        return found

    return of


def _number(value: Value) -> float:
    """A lever that has one number."""
    if isinstance(value, tuple):
        raise TypeError(f"{value} is a list where a number is meant")
    return float(value)


def with_curve(spec: Any, path: Path, number: int) -> Any:
    """A specification whose random curve at a path is that of another case."""
    if not path:
        return spec.model_copy(update={"case": number})
    below = with_curve(getattr(spec, str(path[0])), path[1:], number)
    return spec.model_copy(update={path[0]: below})


def rows(levers: Mapping[str, list[Value]]) -> list[dict[str, Value]]:
    """Columns of levers, case by case."""
    return [dict(zip(levers, row, strict=True)) for row in zip(*levers.values(), strict=True)]


def _borderline(scenario: Scenario, outcome: Outcome, errors: Mapping[str, float]) -> frozenset[str]:
    """The measures that lie so near to a limit that the coarse step may have them on the wrong side of it."""
    return frozenset(
        bound.measure
        for bound in bounds(scenario)
        if (value := outcome.measures.get(bound.measure)) is not None
        and abs(value - bound.value) <= _NEAR * errors.get(bound.measure, 0.0)
    )


def _judged(scenario: Scenario, case: Case, far: float) -> tuple[int, str]:
    if case.failure is not None:
        return FAILED, str(case.failure).splitlines()[0]
    if case.outcome.infeasible:
        return INFEASIBLE, in_words(case.outcome.infeasible)[0]
    codes = [one.code for one in case.outcome.findings if one.code in SOUNDNESS and one.code not in scenario.set_aside]
    good = far <= 0.0 if scenario.asked else not codes
    return (GOOD if good else BAD), ", ".join(dict.fromkeys(codes))
