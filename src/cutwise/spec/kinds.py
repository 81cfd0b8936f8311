"""The processes that a scenario can ask for; a new one is a line here."""

from cutwise.spec.chamfer import ChamferScenario
from cutwise.spec.deburring import DeburringScenario
from cutwise.spec.scenario import Scenario

KINDS: dict[str, type[Scenario]] = {
    "deburr": DeburringScenario,
    "chamfer": ChamferScenario,
}

ALIASES: dict[str, str] = {
    "deburring": "deburr",
    "chamfering": "chamfer",
    "chamfering path": "chamfer",
    "edge_break": "chamfer",
}
"""Other words that people use for a process: named in the suggestion, not accepted."""
