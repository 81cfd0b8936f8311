"""What a finished run is told about itself: sensitivities to assumed values, and advice."""

import time
from contextlib import suppress
from dataclasses import replace

from cutwise.process.recipes import MEASURES, quick_measures
from cutwise.results import Result, SolverFailure
from cutwise.study.advice import advise
from cutwise.study.sensitivity import assumed_sensitivity

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
    if result.scenario.process not in MEASURES or (result.infeasible and result.advice):
        return result
    start = time.process_time()
    with suppress(SolverFailure):
        quick_measures(result.scenario)
    needed = (time.process_time() - start) * _RUNS
    if needed > patience:
        note = f"advice and sensitivities need up to {_RUNS} further runs, about {needed:.0f} s; ask for them with: cutwise advise"
        return replace(result, notes={**result.notes, "advice": note})
    found = advise(result.scenario, pairs=False)
    return replace(result, advice=(*result.advice, *found), sensitivity=assumed_sensitivity(result.scenario))
