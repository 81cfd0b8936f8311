"""What a finished run is told about itself: sensitivities to assumed values, and advice."""

import time
from contextlib import suppress
from dataclasses import replace

from cutwise.process.recipes import OUTCOMES, quick_measures
from cutwise.results import Result, SolverFailure
from cutwise.study.advice import advise
from cutwise.study.sensitivity import changes_of, variants, worst_off

_PATIENCE = 3.0  # [CPU s] of further runs that nobody has asked for
_RUNS = 80


def reviewed(result: Result, *, patience: float = _PATIENCE) -> Result:
    """The result with sensitivities and advice, where further runs are quick enough.

    Parameters
    ----------
    result : Result
        A finished run.
    patience : float
        Processor time that the further runs may take [s]; a process whose runs are slower is left as it is, with a
        note saying so. An infeasible operation that has its remedies already is left as it is.
    """
    if result.scenario.process not in OUTCOMES or (result.infeasible and result.advice):
        return result
    start = time.process_time()
    with suppress(SolverFailure):
        quick_measures(result.scenario)
    needed = (time.process_time() - start) * _RUNS
    if needed > patience:
        note = f"advice and sensitivities need up to {_RUNS} further runs, about {needed:.0f} s; ask for them with: cutwise advise"
        return replace(result, notes={**result.notes, "advice": note})
    found, off = advise(result.scenario, pairs=False), variants(result.scenario)
    base = {name: measure.value for name, measure in result.measures.items()}
    return replace(
        result,
        checks=tuple(check if check.implied else replace(check, off=worst_off(check, off)) for check in result.checks),
        advice=(*result.advice, *found),
        sensitivity=changes_of(result.scenario.focus, base, off),
    )
