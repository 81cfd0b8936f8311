"""Verdict and requirements in words, the same on the command line and in the report."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from cutwise import units
from cutwise.spec.fields import placed

if TYPE_CHECKING:
    from cutwise.results import Check, Result
    from cutwise.spec.scenario import Scenario


def requirement(check: "Check") -> str:
    """The limits of a requirement: ``-0.05 mm to 0.05 mm``, ``at most 340 W``."""
    low, high = (
        units.show(limit, check.dimension) if limit is not None else "" for limit in (check.minimum, check.maximum)
    )
    if low and high:
        return f"{low} to {high}"
    return f"at most {high}" if high else f"at least {low}"


def against(check: "Check") -> str:
    """By how much a failed requirement is missed."""
    if check.passed:
        return ""
    if check.value is None:
        return " (the run has no such measure)"
    return f" by {units.show(-margin(check), check.dimension, 3)}"  # type: ignore[operator]


def margin(check: "Check") -> float | None:
    """Distance from the nearer limit in SI, negative when it is violated; None without a value."""
    if check.value is None:
        return None
    distances = []
    if check.minimum is not None:
        distances.append(check.value - check.minimum)
    if check.maximum is not None:
        distances.append(check.maximum - check.value)
    return min(distances)


def verdict_line(result: "Result") -> str:
    """The verdict in one line, with what failed."""
    if result.infeasible:
        count = len(result.infeasible)
        return f"FAIL: the operation cannot be done ({count} condition{'' if count == 1 else 's'} violated)"
    failed = [check.measure for check in result.checks if not check.passed]
    if failed:
        return f"FAIL: {len(failed)} of {len(result.checks)} requirements not met: {', '.join(failed)}"
    if not result.checks:
        return "no verdict: the scenario has no requirements"
    count = len(result.checks)
    return f"PASS: {'the requirement is' if count == 1 else f'all {count} requirements are'} met"


def sensitivity_line(scenario: "Scenario", sensitivity: Mapping[str, float], count: int = 3) -> str:
    """Which assumed values move the result most when they are off by a tenth."""
    dimension = scenario.measures[scenario.focus].dimension
    most = [
        f"{placed(scenario, key)} by {units.show(change, dimension, 2)}"
        for key, change in list(sensitivity.items())[:count]
    ]
    return f"assumed values that move {scenario.focus} most when they are off by 10 %: {'; '.join(most)}"


def compared(result: "Result") -> tuple[tuple[str, ...], list[tuple[str, ...]]] | None:
    """Variants side by side, as head and rows of a table: a measure in each row, a variant in each column."""
    if "comparison" not in result.stages.children:
        return None
    data, known = result["comparison"].dataset, result.scenario.measures
    rows = [
        (str(name), *(units.show(value, known[str(name)].dimension, 4) for value in array.values))
        for name, array in data.data_vars.items()
    ]
    return ("measure", *map(str, data["strategy"].values)), rows
