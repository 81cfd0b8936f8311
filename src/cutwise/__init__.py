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
    from types import ModuleType

    from cutwise.io.scenario import load as load
    from cutwise.results import Result as Result
    from cutwise.spec.faults import ScenarioFault as ScenarioFault
    from cutwise.study.advice import advise as advise
    from cutwise.study.band import simulate as simulate
    from cutwise.study.correct.entry import correct as correct
    from cutwise.study.many.face import grid as grid
    from cutwise.study.many.face import lognormal as lognormal
    from cutwise.study.many.face import normal as normal
    from cutwise.study.many.face import run_study as run_study
    from cutwise.study.many.face import uniform as uniform
    from cutwise.study.sweep import sweep as sweep

    plots: ModuleType  # figures; not imported here, where lower layers would reach it

_HOMES = {
    "Result": "cutwise.results",
    "ScenarioFault": "cutwise.spec.faults",
    "load": "cutwise.io.scenario",
    "advise": "cutwise.study.advice",
    "correct": "cutwise.study.correct.entry",
    "grid": "cutwise.study.many.face",
    "lognormal": "cutwise.study.many.face",
    "normal": "cutwise.study.many.face",
    "run_study": "cutwise.study.many.face",
    "uniform": "cutwise.study.many.face",
    "simulate": "cutwise.study.band",
    "sweep": "cutwise.study.sweep",
}

_MODULES = {"plots": "cutwise.app.plots"}

__all__ = [
    "Result",
    "ScenarioFault",
    "__version__",
    "advise",
    "correct",
    "grid",
    "load",
    "lognormal",
    "normal",
    "plots",
    "run_study",
    "simulate",
    "sweep",
    "uniform",
]


def __getattr__(name: str) -> Any:
    """Import a public name at its first use (PEP 562), so that ``import cutwise`` costs nothing."""
    if name in _MODULES:
        value: Any = importlib.import_module(_MODULES[name])
    elif name in _HOMES:
        value = getattr(importlib.import_module(_HOMES[name]), name)
    else:
        from difflib import get_close_matches  # only for who is told

        near = get_close_matches(name, __all__, n=1)
        raise AttributeError(
            f"module 'cutwise' has no attribute {name!r}{f'; did you mean {near[0]}?' if near else ''}"
        )
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
