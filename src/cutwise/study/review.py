"""What a finished run is told about itself: sensitivities to assumed values, and advice."""

import time
from dataclasses import replace

from cutwise.process.recipes import MEASURES, quick_measures
from cutwise.results import Result
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
        note saying so.
    """
    if result.scenario.process not in MEASURES:
        return result
    start = time.process_time()
    quick_measures(result.scenario)
    if (time.process_time() - start) * _RUNS > patience:
        note = (
            "advice and sensitivities need many further runs of this slow scenario; ask for them with: cutwise advise"
        )
        return replace(result, notes={**result.notes, "advice": note})
    found = advise(result.scenario, pairs=False)
    return replace(result, advice=(*result.advice, *found), sensitivity=assumed_sensitivity(result.scenario))
