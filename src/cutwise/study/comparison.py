"""Cases side by side: what each measures, what a part costs, and which differences the common draws tell."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.revision import revisions
from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.tool_life import part_cost
from cutwise.process.part_cost import Use
from cutwise.results import Result, SolverFailure
from cutwise.spec.comparison import Comparison
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.milling import MillingScenario
from cutwise.spec.scenario import Scenario
from cutwise.study.band import simulate
from cutwise.study.case import evaluated
from cutwise.study.correct.uncertain import drawn_of, random_of
from cutwise.study.many.definition import Random
from cutwise.study.many.distributions import Normal

SURE = 0.95
"""Share of the common draws that has to agree with a difference, else it is told as not distinguishable."""

_CHEAP = 32_768  # draws where money and wear alone vary
_LIFE = "wear.scatter"  # input that stands for the scatter of the tool life
_COST = "cost_per_part"
_SHOWN = (
    "cycle_time", "cutting_time", "force_xy_peak", "cutting_power_max", "spindle_torque_max", "removal_rate_max",
    "chip_thickness_max", "wall_error_min", "wall_error_max", "contour_error_max", "tip_deflection_max", "surface_error_min",
    "surface_error_max", "hole_position_error_entry", "hole_position_error_exit", "tool_life", _COST,
)  # fmt: skip
_HEAD = ("stock", "tool", "tools", "material", "machine", "robot")


class Case(NamedTuple):
    """One of the scenarios."""

    name: str
    scenario: Scenario
    result: Result
    draws: Mapping[str, FloatArray]  # measures in each draw [SI], NaN where it has none


@dataclass(frozen=True)
class Compared:
    """Scenarios side by side."""

    cases: tuple[Case, ...]
    measures: tuple[str, ...]
    unequal: tuple[str, ...]  # sections that are not the same in all
    draws: int

    def value(self, case: Case, measure: str) -> float | None:
        """A measure of the run itself [SI]."""
        found = case.result.measures.get(measure)
        return None if found is None else found.value

    def interval(self, case: Case, measure: str) -> tuple[float, float] | None:
        """5 and 95 % of a measure over the draws [SI]."""
        drawn = case.draws.get(measure)
        if drawn is None or not np.isfinite(drawn).any():
            return None
        low, high = np.nanquantile(drawn, [0.05, 0.95])
        return float(low), float(high)

    def agreement(self, one: Case, other: Case, measure: str) -> float | None:
        """Share of the common draws in which two cases differ the way their runs do; None where nothing was drawn."""
        a, b = one.draws.get(measure), other.draws.get(measure)
        x, y = self.value(one, measure), self.value(other, measure)
        if a is None or b is None or x is None or y is None or x == y:
            return None
        known = np.isfinite(a) & np.isfinite(b)
        return float(np.mean(np.sign(a[known] - b[known]) == np.sign(x - y))) if known.any() else None

    def least(self, measure: str) -> Case | None:
        """The case with the least value."""
        known = [case for case in self.cases if self.value(case, measure) is not None]
        return min(known, key=lambda case: self.value(case, measure) or 0.0) if known else None

    @property
    def verdict(self) -> str:
        """Fail where a case fails, pass where all that require something do, none where nothing is required."""
        found = {case.result.verdict for case in self.cases}
        return next((one for one in ("fail", "pass") if one in found), "none")

    def as_json(self) -> dict[str, Any]:
        """One object in SI."""
        return {
            "process": "compare",
            "verdict": self.verdict,
            "unequal": list(self.unequal),
            "draws": self.draws,
            "cases": [self._case(case) for case in self.cases],
            "agreement": {
                name: {
                    f"{one.name} | {other.name}": share
                    for k, one in enumerate(self.cases)
                    for other in self.cases[k + 1 :]
                    if (share := self.agreement(one, other, name)) is not None
                }
                for name in self.measures
            },
        }

    def _case(self, case: Case) -> dict[str, Any]:
        measures: dict[str, Any] = {}
        for name, one in case.result.measures.items():
            measures[name] = {"value": one.value, "unit": one.unit}
            if (ends := self.interval(case, name)) is not None:
                measures[name] |= {"low": ends[0], "high": ends[1]}
        if (ends := self.interval(case, _COST)) is not None:
            for end, value in zip(("low", "high"), ends, strict=True):
                measures[f"cost_{end}"] = {"value": value, "unit": "EUR"}
        return {"name": case.name, "verdict": case.result.verdict, "measures": measures}


def cases_of(scenario: Scenario) -> dict[str, Scenario]:
    """The cases that a scenario names in ``compare.cases``.

    Raises
    ------
    ScenarioFault
        It names none, or a case is not right.
    """
    said = scenario.compare
    if said is None or not said.cases:
        raise ScenarioFault([Fault(("compare", "cases"), "missing; name cases, for example {one: {}, other: {operation.feed: "
                                   "60 mm/s}}, or give two files or more")])  # fmt: skip
    found: dict[str, Scenario] = {}
    faults: list[Fault] = []
    for name, given in said.cases.items():
        try:
            found[name] = revisions(scenario, f"compare.cases.{name}.{{}}")(dict(given)) if given else scenario
        except ScenarioFault as why:
            faults += why.faults
    if faults:
        raise ScenarioFault(faults)
    return found


def compare(
    scenarios: Mapping[str, Scenario], said: Comparison | None = None, measures: Sequence[str] = (),
    progress: Callable[[float], None] | None = None,
) -> Compared:  # fmt: skip
    """Run scenarios, and all of them in the same draws of what is uncertain.

    Parameters
    ----------
    scenarios : mapping
        By name, two or more.
    said : Comparison, optional
        What varies; left out: that of the first scenario.
    measures : sequence of str
        What is shown, besides what is required; left out: time, load, errors and cost.
    progress : callable, optional
        Called with the share done.

    Raises
    ------
    ScenarioFault
        What varies is no quantity of a scenario.
    """
    first = next(iter(scenarios.values()))
    said = said or first.compare or Comparison()
    random = random_of(first, said.vary, ("compare", "vary"))
    scattering = any(isinstance(one, MillingScenario) and one.wear and one.wear.scatter for one in scenarios.values())
    inputs = {**random, **({_LIFE: Random(Normal(0.0, 1.0))} if scattering else {})}
    simulated = [key for key in random if not key.startswith(("shop.", "wear."))]
    count = 0 if not inputs else said.draws if simulated or "draws" in said.model_fields_set else _CHEAP
    drawn = drawn_of(first, inputs, said.seed, count) if count else []
    found = []
    for k, (name, scenario) in enumerate(scenarios.items()):
        try:
            result = simulate(scenario, None)
        except ScenarioFault as why:
            raise ScenarioFault([replace(fault, file=fault.file or f"case {name}") for fault in why.faults]) from None
        except SolverFailure as why:
            raise SolverFailure(f"case {name}: {why}") from why
        found.append(Case(name, scenario, result, _in_draws(scenario, result, drawn, simulated)))
        if progress is not None:
            progress((k + 1) / len(scenarios))
    required = [name for case in found for name in case.scenario.requirements]
    wanted = dict.fromkeys((*(measures or _SHOWN), *required))
    shown = tuple(name for name in wanted if any(name in case.result.measures for case in found))
    return Compared(tuple(found), shown, _unequal([case.scenario for case in found]), count)


def _unequal(scenarios: Sequence[Scenario]) -> tuple[str, ...]:
    """Sections of what is cut, and with what, that are not the same everywhere."""
    return tuple(
        section
        for section in _HEAD
        if any(getattr(one, section, None) != getattr(scenarios[0], section, None) for one in scenarios[1:])
    )


def _in_draws(
    scenario: Scenario, result: Result, drawn: Sequence[Mapping[str, Any]], simulated: Sequence[str]
) -> dict[str, FloatArray]:  # fmt: skip
    """Measures of a case in each draw."""
    if not drawn:
        return {}
    found: dict[str, list[float]] = {}
    revised = revisions(scenario)
    plain = {name: one.value for name, one in result.measures.items()}
    for k, draw in enumerate(drawn):
        measures = plain
        if simulated:
            try:
                one = revised({key: value for key, value in draw.items() if key in simulated})
                measures = dict(evaluated(one, {}).measures)
            except (ScenarioFault, SolverFailure):
                measures = {}
        for name in (*(measures if simulated else ()), _COST):
            value = _cost(scenario, measures, draw) if name == _COST else measures[name]
            if value is not None:
                found.setdefault(name, [np.nan] * len(drawn))[k] = value
    return {name: np.array(values) for name, values in found.items()}


def _cost(scenario: Scenario, measures: Mapping[str, float], draw: Mapping[str, Any]) -> float | None:
    """Cost of a part in a draw [EUR]."""
    if not isinstance(scenario, MillingScenario) or scenario.shop is None or _COST not in measures:
        return None
    use = Use(measures["cycle_time"], measures["cutting_time"], 0.0, 0.0, 0.0)
    return drawn_cost(scenario, use, measures.get("tool_life"), draw)


def drawn_cost(scenario: MillingScenario, use: Use, life: float | None, draw: Mapping[str, Any]) -> float:
    """Cost of a part with prices, and a tool life [s] whose logarithm scatters, as drawn [EUR]."""
    shop, wear = scenario.shop, scenario.wear
    assert shop is not None
    rate = float(draw.get("shop.machine_rate", shop.machine_rate))
    if wear is None or life is None or shop.tool_price is None:
        return part_cost(rate, use.time)
    price = float(draw.get("shop.tool_price", shop.tool_price))
    life *= float(draw.get("wear.life", wear.life)) / wear.life * float(np.exp(wear.scatter * draw.get(_LIFE, 0.0)))
    return part_cost(rate, use.time, price, use.cutting, life)


def shown(found: Compared) -> list[str]:
    """The comparison as text."""
    lines = []
    if found.unequal:
        lines.append(f"not the same in all: {', '.join(found.unequal)}")
    rows = [("", *(case.name for case in found.cases))]
    for name in found.measures:
        rows.append((name, *(_cell(found, case, name) for case in found.cases)))
    rows.append(("verdict", *(case.result.verdict for case in found.cases)))
    wide = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines += ["  ".join(f"{cell:<{width}}" for cell, width in zip(row, wide, strict=True)).rstrip() for row in rows]
    if found.draws:
        lines.append(
            f"in brackets: 5 and 95 % of {found.draws} draws, the same in all; a difference from the least whose sign fewer than "
            f"{100 * SURE:.0f} % of them share is not distinguishable"
        )
    return lines


def _cell(found: Compared, case: Case, name: str) -> str:
    value, least = found.value(case, name), found.least(name)
    if value is None:
        return "-"
    dimension = case.result.measures[name].dimension
    text = units.show(value, dimension, 4)
    if (ends := found.interval(case, name)) is not None:
        text += f" ({units.show(ends[0], dimension, 4)} to {units.show(ends[1], dimension, 4)})"
    share = None if least is None or least is case else found.agreement(case, least, name)
    return text if share is None or share >= SURE else f"{text}, not distinguishable ({100 * share:.0f} %)"
