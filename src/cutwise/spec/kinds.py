"""The processes that a scenario can ask for; a new one is a line here."""

from collections.abc import Iterator, Mapping
from importlib import import_module

from cutwise.spec.scenario import Scenario

_HOMES = {
    "deburr": ("cutwise.spec.deburring", "DeburringScenario"),
    "drill": ("cutwise.spec.drilling", "DrillingScenario"),
    "mill": ("cutwise.spec.milling", "MillingScenario"),
    "machine": ("cutwise.spec.machine_scenario", "MachineScenario"),
    "chamfer": ("cutwise.spec.chamfer", "ChamferScenario"),
}


class _Kinds(Mapping[str, type[Scenario]]):
    """The specification of each process, built when it is asked for: a fifth of the time of a check is spent on five."""

    def __getitem__(self, name: str) -> type[Scenario]:
        module, model = _HOMES[name]
        return getattr(import_module(module), model)  # type: ignore[no-any-return]

    def __iter__(self) -> Iterator[str]:
        return iter(_HOMES)

    def __len__(self) -> int:
        return len(_HOMES)

    def __contains__(self, name: object) -> bool:
        return name in _HOMES


KINDS: Mapping[str, type[Scenario]] = _Kinds()

ALIASES: dict[str, str] = {
    "deburring": "deburr",
    "drilling": "drill",
    "robotic_drilling": "drill",
    "milling": "mill",
    "pocket": "mill",
    "machine_tool": "machine",
    "error_budget": "machine",
    "chamfering": "chamfer",
    "chamfering path": "chamfer",
    "edge_break": "chamfer",
}
"""Other words that people use for a process: named in the suggestion, not accepted."""
