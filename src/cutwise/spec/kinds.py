"""The processes that a scenario can ask for; a new one is a line here."""

from cutwise.spec.chamfer import ChamferScenario
from cutwise.spec.deburring import DeburringScenario
from cutwise.spec.drilling import DrillingScenario
from cutwise.spec.machine_scenario import MachineScenario
from cutwise.spec.milling import MillingScenario
from cutwise.spec.scenario import Scenario

KINDS: dict[str, type[Scenario]] = {
    "deburr": DeburringScenario,
    "drill": DrillingScenario,
    "mill": MillingScenario,
    "machine": MachineScenario,
    "chamfer": ChamferScenario,
}

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
