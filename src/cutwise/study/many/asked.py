"""What a study file asks for: how many cases, measures, probability, indices, when to stop, what may be spent."""

import math
from collections.abc import Sequence
from difflib import get_close_matches
from typing import NamedTuple

from cutwise import units
from cutwise.io.tree import Node
from cutwise.spec.scenario import Scenario
from cutwise.study.many.definition import (
    HYPERCUBE,
    INDICES,
    MONTE_CARLO,
    MORRIS,
    OPTIMISE,
    RARE,
    SEARCHES,
    SOBOL,
    Budget,
    Stop,
)  # fmt: skip
from cutwise.study.many.draws import NETS, next_size
from cutwise.study.many.levers import Faults, Levers

_PLAIN = (SOBOL, MONTE_CARLO, HYPERCUBE)
"""Methods beside which indices may be asked for."""


class Wanted(NamedTuple):
    """What is wanted of the cases."""

    measures: tuple[str, ...]
    demanded: float | None = None  # least share of good cases
    indices: int = 0  # rows of runs that tell what decides, beside the cases


def budget(tree: Node, method: str, faults: Faults) -> Budget | None:
    """What one call may spend."""
    node = tree.value.get("budget")
    if node is None:
        return None
    given = node.plain() if isinstance(node.value, dict) else {}
    cases, seconds = given.get("cases"), None
    try:
        seconds = units.parse(given["time"], "time") if "time" in given else None
    except units.UnitFault as why:
        faults.at(node, ("budget", "time"), str(why))
    counted = cases is None or (isinstance(cases, int) and not isinstance(cases, bool) and cases > 0)
    if not given or given.keys() - {"cases", "time"} or not counted or (seconds is not None and seconds <= 0.0):
        faults.at(node, ("budget",), "expected for example {time: 30 min} or {cases: 20000}")
        return None
    if seconds is not None and method in SEARCHES:
        faults.at(node, ("budget", "time"), f"{method} is limited by cases, so that it ends the same on every machine")
    if cases is not None and method == RARE:
        faults.at(node, ("budget", "cases"), "rare takes cases at each level (cases), as many levels as it needs")
    return Budget(cases, seconds)


def rounded(method: str, wanted: int) -> int:
    """As many draws as the points of a method come in."""
    return (
        next_size(wanted, NETS)
        if method in (SOBOL, OPTIMISE)
        else next_size(wanted, 1)
        if method == INDICES
        else wanted
    )


def count(tree: Node, key: str, usual: int, faults: Faults, *, least: int = 1) -> int:
    """A whole number."""
    node = tree.value.get(key)
    if node is None:
        return usual
    if isinstance(node.value, bool) or not isinstance(node.value, int) or node.value < least:
        faults.at(node, (key,), f"{node.text or node.plain()} is no whole number from {least} on")
        return usual
    return int(node.value)


def word(tree: Node, key: str, known: Sequence[str], usual: str, faults: Faults) -> str:
    """One of some words."""
    node = tree.value.get(key)
    if node is None:
        return usual
    if node.value not in known:
        faults.at(node, (key,), f'"{node.text or node.plain()}" is not one of {", ".join(known)}')
        return usual
    return str(node.value)


def stop(tree: Node, faults: Faults) -> Stop | None:
    """When the study is precise enough."""
    node = tree.value.get("stop")
    if node is None:
        return None
    given = node.plain() if isinstance(node.value, dict) else {}
    unknown = given.keys() - {"half_width", "level", "at_least"}
    asked = (given.get("half_width"), given.get("level", 0.95), given.get("at_least", 1024))
    numbers = [x for x in asked if isinstance(x, int | float) and not isinstance(x, bool)]
    width, level, least = numbers if len(numbers) == len(asked) else (math.nan, math.nan, math.nan)
    if unknown or not (0.0 < width < 0.5 and 0.5 < level < 1.0 and 1 <= least < math.inf):
        faults.at(node, ("stop",), "expected for example {half_width: 0.01, level: 0.95, at_least: 1024}; a study that "
                  "stops when its interval clears a limit would be wrong half of the time")  # fmt: skip
        return None
    return Stop(float(width), float(level), int(least))


def wants(tree: Node, scenario: Scenario, faults: Faults, method: str, levers: Levers) -> Wanted:
    """Measures besides those of the requirements, the share of good cases that is demanded, rows for indices."""
    node = tree.value.get("want")
    asked = list(scenario.asked)
    demanded, indices = None, 0
    if node is not None and not isinstance(node.value, dict):
        faults.at(node, ("want",), "expected for example {measures: [cutting_power_mean], probability: {min: 0.99}}")
        return Wanted(tuple(asked))
    for key, one in node.value.items() if node is not None else ():
        if key == "measures":
            asked += _measures(one, scenario, faults)
        elif key == "probability":
            demanded = _demanded(one, scenario, faults, method, scatters=bool(levers.random))
        elif key == "indices":
            indices = _indices(one, faults, method, levers)
        else:
            near = get_close_matches(key, ("measures", "probability", "indices"), n=1)
            hint = f"; did you mean {near[0]}?" if near else "; write measures, probability or indices"
            faults.at(one, ("want", key), f"unknown{hint}", at_key=True)
    return Wanted(tuple(dict.fromkeys(asked or ([scenario.focus] if scenario.focus else []))), demanded, indices)


def _measures(one: Node, scenario: Scenario, faults: Faults) -> list[str]:
    known = type(scenario).measures
    names = one.plain() if isinstance(one.value, list) else [one.plain()]
    found = []
    for name in known if names == ["all"] else names:
        if not isinstance(name, str) or name not in known:
            near = get_close_matches(str(name), list(known), n=1)
            faults.at(
                one, ("want", "measures"), f"{name}: unknown measure{f'; did you mean {near[0]}?' if near else ''}"
            )
        found.append(str(name))
    return found


def _demanded(one: Node, scenario: Scenario, faults: Faults, method: str, *, scatters: bool) -> float | None:
    given = one.plain()
    demanded = given.get("min") if isinstance(given, dict) else None
    alone = isinstance(given, dict) and given.keys() == {"min"}
    right = alone and isinstance(demanded, float | int) and not isinstance(demanded, bool) and 0.0 < demanded < 1.0
    if not right:
        faults.at(one, ("want", "probability"), "expected a share between 0 and 1, for example {min: 0.99}")
    reasons = (
        (method == OPTIMISE, "of an optimum it is asked for by robust: {probability: 0.99}"),
        (method == MORRIS, "the points of morris are levels of a plan, no draws: take sobol or indices"),
        (not scenario.asked, "there are no requirements, so no case is good or bad"),
        (not scatters, "nothing scatters (vary), so there is no share of anything"),
    )
    for wrong, why in reasons:
        if wrong:
            faults.at(one, ("want", "probability"), why)
            break
    return float(demanded) if right else None  # type: ignore[arg-type]


def _indices(one: Node, faults: Faults, method: str, levers: Levers) -> int:
    """Rows of the runs that tell what decides."""
    if isinstance(one.value, bool) or not isinstance(one.value, int) or one.value < 2:
        faults.at(one, ("want", "indices"), f"{one.text or one.plain()} is no whole number from 2 on, for example 4096")
        return 0
    if method not in _PLAIN:
        why = (
            "method: indices has them anyway"
            if method == INDICES
            else f"goes with {', '.join(_PLAIN)}, not with {method}"
        )
        faults.at(one, ("want", "indices"), why, at_key=True)
    elif not levers.random:
        faults.at(one, ("want", "indices"), "nothing scatters (vary), so nothing decides", at_key=True)
    elif levers.design:
        key = next(iter(levers.design))
        faults.at(
            one,
            ("want", "indices"),
            f"are those of one setting; {key} has several values: set one of them",
            at_key=True,
        )
    return next_size(one.value, 1)
