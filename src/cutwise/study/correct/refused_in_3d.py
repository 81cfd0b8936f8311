"""What feeds of a program in a stock in 3D cannot be corrected for, by name and with the reason."""

from collections.abc import Iterator

from cutwise.process.stock_plan import cutters_of
from cutwise.spec.correct import Correction
from cutwise.spec.faults import Fault
from cutwise.spec.milling import MillingScenario
from cutwise.spec.milling_machine import drives_of
from cutwise.study.correct.loads import PLUNGE
from cutwise.study.correct.meridians import has_end

_NONE = "no run in a stock in 3D has such a measure"
_ELSE = {
    "wall_error_min": "write requirements deviation_min and deviation_max (with a nominal part), which the run proves",
    "wall_error_max": "write requirements deviation_min and deviation_max (with a nominal part), which the run proves",
    "contour_error_max": "write requirements deviation_min and deviation_max (with a nominal part), which the run proves",
    "tip_deflection_max": "write a requirement tool_offset_max, which the run proves",
    "chatter_growth_corner": "chatter is not looked at in 3D; path.corner with this tool has it",
    "chatter_growth_straight": "chatter is not looked at in 3D; path.corner with this tool has it",
}
"""Limits that stand with exact arcs alone, and what to write instead."""


def refusals_in_3d(scenario: MillingScenario, said: Correction) -> Iterator[Fault]:
    """All of it at once."""
    if scenario.setups:
        yield Fault(("setups",), "have a program each, and one is written: correct a set-up by itself (program, tools, fixtures), "
                    "the one before it as stock: {run: FOLDER}")  # fmt: skip
    if scenario.machine is None or drives_of(scenario.machine) is None:
        why = (
            "a robot has no such limits"
            if scenario.robot is not None
            else "what it can do says how fast moves in air may be"
        )
        yield Fault(
            ("machine",), f"feeds are corrected for a machine with feed drives: machine: {{library: fadal2216}}; {why}"
        )
    if scenario.material is None:
        yield Fault(
            ("material",), "missing: without it no force is known that feeds could be held to, for example al7075t6"
        )
    if scenario.numerics.stock.engagement != "refined":
        yield Fault(("numerics", "stock", "engagement"), f"{scenario.numerics.stock.engagement} does not tell the peak force that "
                    "feeds are held to; leave it out, or write refined")  # fmt: skip
    for name in said.limits:
        if name in _ELSE:
            yield Fault(("correct", "limits", name), f"{_NONE}: {_ELSE[name]}")
    if PLUNGE in said.limits and not any(has_end(tool) for tool in cutters_of(scenario)):
        yield Fault(("correct", "limits", PLUNGE), "the end of no tool has a force here: write its end_core (0 mm: it cuts over "
                    "its centre); plunges keep their feed otherwise")  # fmt: skip
    if said.objective != "time":
        why = {
            "error": "no wall or contour has an error of its own in 3D; hold the part by requirements on its deviation",
            "cost": "shop and wear are not told of a stock in 3D; objective: time",
        }[said.objective]
        yield Fault(("correct", "objective"), f"{said.objective} is not there in a stock in 3D: {why}")
