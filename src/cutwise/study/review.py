"""What a finished run is told about itself: sensitivities to assumed values, and advice."""

from dataclasses import replace

from cutwise.results import Result
from cutwise.spec.kinds import KINDS
from cutwise.study.advice import consult
from cutwise.study.sensitivity import assumed_quantities, changes_of, variants, worst_off
from cutwise.study.trials import Budget

_ROOM = 20  # runs below which the room of a run that passes is not looked for


def reviewed(result: Result, *, runs: int | None = None, jobs: int = 1) -> Result:
    """The result with advice and sensitivities, within a number of further runs that is the same on every machine.

    Parameters
    ----------
    result : Result
        A finished run.
    runs : int, optional
        Further runs for advice, and as many for sensitivities; what the scenario allows
        (:meth:`~cutwise.spec.scenario.Scenario.unasked`) if left out. A run that fails gets advice from however few;
        one that passes is told its room, and sensitivities are found, only if there are enough. What was left out
        stands in a note. An infeasible operation that has its remedies already is left as it is.
    jobs : int
        Processes for the runs of the sensitivities.
    """
    scenario = result.scenario
    if scenario.process not in KINDS or (result.infeasible and result.advice):
        return result
    most = scenario.unasked() if runs is None else runs
    left_out = []
    found: tuple[str, ...] = ()
    if scenario.requirements and (result.verdict == "fail" or most >= _ROOM) and most > 0:
        advice = consult(scenario, pairs=False, budget=Budget(most))
        found = advice.sentences
    elif scenario.requirements:
        left_out.append("the room in each setting")
    weights, checks = result.sensitivity, result.checks
    if 2 * sum(1 for _ in assumed_quantities(scenario)) < most:
        base, off = variants(scenario, jobs=jobs)
        weights = changes_of(scenario.focus, base, off)
        checks = tuple(check if check.implied else replace(check, off=worst_off(check, off)) for check in checks)
    else:
        left_out.append("sensitivities to assumed values")
    notes = dict(result.notes)
    if left_out:
        notes["advice"] = (
            f"left out, for a run of this kind takes long: {' and '.join(left_out)}; cutwise advise finds them"
        )
    return replace(result, checks=checks, advice=(*result.advice, *found), sensitivity=weights, notes=notes)
