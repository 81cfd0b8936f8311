"""cutwise predicts what a machining operation will do to the part before anything is cut.

>>> import cutwise
>>> scenario = cutwise.load("deburr.yaml")
>>> result = cutwise.simulate(scenario)
>>> result.verdict
'pass'
"""

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from cutwise.io.scenario import load as load
    from cutwise.results import Result as Result
    from cutwise.spec.faults import ScenarioFault as ScenarioFault
    from cutwise.study.advice import advise as advise
    from cutwise.study.band import simulate as simulate
    from cutwise.study.correct.entry import correct as correct
    from cutwise.study.many.face import run_study as run_study
    from cutwise.study.sweep import sweep as sweep

_HOMES = {
    "Result": "cutwise.results",
    "ScenarioFault": "cutwise.spec.faults",
    "load": "cutwise.io.scenario",
    "advise": "cutwise.study.advice",
    "correct": "cutwise.study.correct.entry",
    "run_study": "cutwise.study.many.face",
    "simulate": "cutwise.study.band",
    "sweep": "cutwise.study.sweep",
}

__all__ = ["Result", "ScenarioFault", "__version__", "advise", "correct", "load", "run_study", "simulate", "sweep"]


def __getattr__(name: str) -> Any:
    """Import a public name at its first use (PEP 562), so that ``import cutwise`` costs nothing."""
    if name not in _HOMES:
        raise AttributeError(f"module 'cutwise' has no attribute {name!r}")
    value = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
