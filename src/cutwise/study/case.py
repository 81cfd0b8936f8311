"""One case of a study: a scenario with some of its values replaced, and what comes of it.

Sweep, advice and sensitivities all go through :func:`evaluated`, so that a number is the same wherever it is read.
"""

from collections.abc import Callable, Collection, Mapping
from typing import NamedTuple

from cutwise.io.revision import Value, revisions
from cutwise.io.scenario import OVERRIDES
from cutwise.process.recipes import Outcome, quick_outcome
from cutwise.results import SolverFailure
from cutwise.spec.faults import ScenarioFault
from cutwise.spec.scenario import Scenario

TOLERANCE = 0.01
"""Share of a limit (of the value, where nothing limits it) within which the coarse step of a study has to agree with the
run; where it does not, the study takes the step of the run."""

_NOTHING = Outcome({})


class Case(NamedTuple):
    """What came of one case; without an outcome it did not come to an end, for the reason given."""

    values: Mapping[str, Value]
    outcome: Outcome
    failure: ScenarioFault | SolverFailure | None = None

    @property
    def measures(self) -> Mapping[str, float]:
        """The measures in SI; none if the case failed."""
        return self.outcome.measures


Evaluate = Callable[[Mapping[str, Value]], Case]


def cases(
    scenario: Scenario, wanted: Collection[str] = (), *, coarse: bool = False, named: str = OVERRIDES,
    revised: Callable[[Mapping[str, Value]], Scenario] | None = None,
) -> Evaluate:  # fmt: skip
    """A function that evaluates a case of overrides.

    Parameters
    ----------
    scenario : Scenario
        What all other values are taken from; read once.
    wanted : collection of str
        Measures that take long and are computed all the same.
    coarse : bool
        The larger step of studies and no warnings; see :func:`faithful`.
    named : str
        How a message names an override, with ``{}`` for its key.
    revised : callable, optional
        What puts values into the scenario, where they are not overrides alone.

    Returns
    -------
    callable
        From dotted keys and values (text, or SI numbers) to a :class:`Case`; a case that cannot be run says why.
    """
    put = revised or revisions(scenario, named)

    def case(values: Mapping[str, Value]) -> Case:
        try:
            one = put(values) if values else scenario
        except ScenarioFault as why:
            return Case(values, _NOTHING, why)
        return evaluated(one, values, wanted, coarse=coarse)

    return case


def evaluated(
    scenario: Scenario, values: Mapping[str, Value], wanted: Collection[str] = (), *, coarse: bool = False
) -> Case:
    """The case of a scenario in which the values stand already."""
    try:
        return Case(values, quick_outcome(scenario, wanted, coarse=coarse))
    except (ScenarioFault, SolverFailure) as why:
        return Case(values, _NOTHING, why)


def faithful(
    scenario: Scenario, coarse: Mapping[str, float], fine: Mapping[str, float], names: Collection[str]
) -> bool:
    """Whether the coarse step gives the measures of the run, within :data:`TOLERANCE`."""
    for name in names:
        if (name in coarse) != (name in fine):
            return False
        if name in fine:
            limit = scenario.requirements.get(name)
            ends = [abs(end) for end in (limit.min, limit.max) if end] if limit is not None else []
            if abs(coarse[name] - fine[name]) > TOLERANCE * (min(ends) if ends else abs(fine[name])):
                return False
    return True
