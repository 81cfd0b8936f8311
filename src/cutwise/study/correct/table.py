"""Which function corrects what: the one table. A new correction is a row here, a module beside this one, and its keys in
:data:`cutwise.spec.correct.KEYS`."""

from collections.abc import Callable, Iterator, Mapping
from importlib import import_module

from cutwise.spec.correct import EDGE, KEYS, Correction
from cutwise.spec.faults import Fault
from cutwise.spec.scenario import Scenario
from cutwise.study.correct.outcome import Proposal, Task

Corrects = Callable[[Task], Proposal]

CORRECTIONS: Mapping[tuple[str, str], str] = {
    **{
        (process, "placement"): "cutwise.study.correct.settings:placed"
        for process in ("mill", "drill", "machine", "deburr", "chamfer")
    },
    ("mill", "depth"): "cutwise.study.correct.settings:deeper",
    ("mill", "speed"): "cutwise.study.correct.speed:corrected",
    ("mill", "feed"): "cutwise.study.correct.feed:corrected",
    ("mill", "path"): "cutwise.study.correct.path:corrected",
    ("deburr", "feed"): "cutwise.study.correct.deburr:corrected",
    ("drill", "offset"): "cutwise.study.correct.drill:corrected",
    ("machine", "offset"): "cutwise.study.correct.error_map:corrected",
    ("chamfer", "offset"): "cutwise.study.correct.chamfer:corrected",
}
"""(process, change): ``module:function``; what is asked for together is done in this order. A module may have a function
``refusals(scenario, said, unroll)`` that yields what it cannot be asked for: it is asked before anything is run."""

_JUDGED = frozenset({"objective", "change", "residual"})
_LEARNED = _JUDGED | {"iterations", "shift_max", "draws", "vary", "seed"}

READ: Mapping[tuple[str, str], frozenset[str]] = {
    ("mill", "feed"): KEYS["feed"] - EDGE,
    ("mill", "path"): _LEARNED | {"limits", "lead", "smoothing", "chord", "decimals"},
    ("deburr", "feed"): EDGE | {"objective", "change", "ranges", "station"},
    ("drill", "offset"): _LEARNED,
    ("chamfer", "offset"): _LEARNED,
    ("machine", "offset"): _JUDGED,
}
"""Keys of the section that a row reads, where they are not all of its change."""

OBJECTIVES: Mapping[tuple[str, str], frozenset[str]] = {
    ("mill", "speed"): frozenset({"time", "error", "cost"}),
    ("mill", "feed"): frozenset({"time", "error", "cost"}),
}
"""What a row can make least, where it is more than the usual: time of feeds, error of what is shifted (which ``time`` is too)."""

FORMATS: Mapping[str, str] = {
    form: f"cutwise.study.correct.formats:{form}"
    for form in ("rs274", "fanuc", "apt", "krl", "rapid", "poses", "table")
}
"""Writers: ``module:function`` from a Corrected to a text."""


WRITTEN: Mapping[str, tuple[str, ...]] = {
    "mill": ("rs274", "fanuc", "apt"),
    "drill": ("poses", "krl", "rapid"),
    "deburr": ("table",),
    "machine": ("table",),
    "chamfer": ("rs274", "apt", "poses"),
}
"""Languages of each process; the first is the usual one."""


def found(process: str, change: str) -> Corrects | None:
    """The function of a row; None if there is none."""
    row = CORRECTIONS.get((process, change))
    if row is None:
        return None
    module, _, name = row.partition(":")
    function: Corrects = getattr(import_module(module), name)
    return function


def refusals_of(process: str, change: str, scenario: Scenario, said: Correction, unroll: bool) -> Iterator[Fault]:
    """What a row cannot be asked for."""
    module, _, _ = CORRECTIONS[process, change].partition(":")
    own = getattr(import_module(module), "refusals", None)
    if own is not None:
        yield from own(scenario, said, unroll)


def changes_of(process: str) -> tuple[str, ...]:
    """What can be changed of a process, in the order in which it is done."""
    return tuple(change for kind, change in CORRECTIONS if kind == process)
