"""What a corrected program is held to: the limits of the section and the requirements, and what is equal to the run before."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from cutwise.spec.correct import LIMITED, Bound, Correction
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.scenario import Scenario

EQUAL = ("force_xy_peak", "wall_error_min", "wall_error_max")
"""Measures that stay what they are where nothing is written about them."""
CHIP_GUARD = 1.5  # times the largest chip of the run before, where no other is given
SAME = 0.01  # by which what is to be equal may be more than it was


class Asked(NamedTuple):
    """The limit of each measure that has one [SI]."""

    limits: Mapping[str, float]  # written as a limit or a requirement; the stricter of both
    equal: frozenset[str]  # what the run before has
    guarded: bool  # the chip is not thicker than CHIP_GUARD times that of the run before


def is_least(name: str) -> bool:
    """Whether a measure has to stay above its limit, and not below."""
    return name.endswith("_min")


def asked(scenario: Scenario, said: Correction, *, walls: bool) -> Asked:
    """What is asked of a correction; ``walls``: whether the tool yields, so that walls have an error.

    Raises
    ------
    ScenarioFault
        A limit on a side that its measure does not have, or of a wall that has no error.
    """
    found: dict[str, float] = {}
    equal, faults = set(), []
    for name, bound in said.limits.items():
        if name.startswith("wall_error") and not walls:
            faults.append(Fault(("correct", "limits", name), "the tool is rigid, so that its walls have no error; write "
                                "tool.stiffness or tool.modes"))  # fmt: skip
        if not isinstance(bound, Bound):
            if name == "chip_thickness_min":
                faults.append(Fault(("correct", "limits", name), "cannot be equal: at entries any run has chips of no thickness; "
                                    "write {min: 20 um}"))  # fmt: skip
            equal.add(name)
            continue
        side, other = ("min", "max") if is_least(name) else ("max", "min")
        if getattr(bound, other) is not None:
            faults.append(
                Fault(("correct", "limits", name, other), f"{name} is held to a {side} alone; leave {other} out")
            )
        value = getattr(bound, side)
        if value is not None:
            found[name] = value
    if faults:
        raise ScenarioFault(faults)
    for name, limit in scenario.requirements.items():
        value = limit.min if is_least(name) else limit.max
        if name in LIMITED and value is not None:
            stricter = max if is_least(name) else min
            found[name] = stricter(found.get(name, value), value)
    known = found.keys() | equal
    equal |= {name for name in EQUAL if name not in known and (walls or not name.startswith("wall"))}
    return Asked(found, frozenset(equal), "chip_thickness_max" not in known)


def resolved(wanted: Asked, before: Mapping[str, float]) -> dict[str, float]:
    """All limits in SI, with what the run before has where it is to be equal."""
    out = dict(wanted.limits)
    for name in wanted.equal:
        value = before.get(name)
        if value is not None and math.isfinite(value):
            out[name] = value
    if wanted.guarded and before.get("chip_thickness_max", 0.0) > 0.0:
        thickest = max(
            before["chip_thickness_max"], out.get("chip_thickness_min", 0.0)
        )  # a guard, not against what is asked
        out["chip_thickness_max"] = CHIP_GUARD * thickest
    return out


def exceeded(name: str, value: float, limit: float, slack: float = 0.0) -> bool:
    """Whether a value is beyond its limit, by more than a share of it."""
    room = slack * abs(limit) + 1e-9 * abs(limit)
    return value < limit - room if is_least(name) else value > limit + room
