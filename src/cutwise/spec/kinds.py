"""The processes that a scenario can ask for: the one place where a process is registered."""

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Any, NamedTuple

from cutwise.spec.scenario import Scenario


class Home(NamedTuple):
    """Where a process lives, each as ``module:name``; a new process is a row of :data:`HOMES` and nothing else."""

    spec: str  # what the engineer says: a Scenario
    recipe: str  # how it is run: a cutwise.process.recipes.Recipe
    plots: str  # what the report draws: a list of Plot
    aliases: tuple[str, ...] = ()  # other words that people use: named in the suggestion, not accepted


HOMES: Mapping[str, Home] = {
    "deburr": Home(
        "cutwise.spec.deburring:DeburringScenario", "cutwise.process.presets.deburr:RECIPE",
        "cutwise.app.plots.deburr:PLOTS", ("deburring",),
    ),
    "drill": Home(
        "cutwise.spec.drilling:DrillingScenario", "cutwise.process.presets.drill:RECIPE",
        "cutwise.app.plots.drill:PLOTS", ("drilling", "robotic_drilling"),
    ),
    "mill": Home(
        "cutwise.spec.milling:MillingScenario", "cutwise.process.presets.mill:RECIPE",
        "cutwise.app.plots.mill:PLOTS", ("milling", "pocket"),
    ),
    "machine": Home(
        "cutwise.spec.machine_scenario:MachineScenario", "cutwise.process.presets.machine:RECIPE",
        "cutwise.app.plots.machine:PLOTS", ("machine_tool", "error_budget"),
    ),
    "chamfer": Home(
        "cutwise.spec.chamfer:ChamferScenario", "cutwise.process.presets.chamfer:RECIPE",
        "cutwise.app.plots.chamfer:PLOTS", ("chamfering", "chamfering path", "edge_break"),
    ),
    "turn": Home(
        "cutwise.spec.turning:TurningScenario", "cutwise.process.turning:RECIPE",
        "cutwise.app.plots.turn:PLOTS", ("turning", "lathe"),
    ),
}  # fmt: skip


class Registered(Mapping[str, Any]):
    """One thing of each process, imported when it is asked for: a run pays for its own process alone."""

    def __init__(self, part: str) -> None:
        self._part = part

    def __getitem__(self, kind: str) -> Any:
        module, _, name = getattr(HOMES[kind], self._part).partition(":")
        return getattr(import_module(module), name)

    def __iter__(self) -> Iterator[str]:
        return iter(HOMES)

    def __len__(self) -> int:
        return len(HOMES)

    def __contains__(self, kind: object) -> bool:
        return kind in HOMES


KINDS: Mapping[str, type[Scenario]] = Registered("spec")

ALIASES: dict[str, str] = {alias: kind for kind, home in HOMES.items() for alias in home.aliases}
