"""Verdict and requirements in words, the same on the command line and in the report."""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from cutwise import units
from cutwise.app.findings import reasons
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
    if check.keeps(check.value):
        return f" ({'; '.join(_not_enough(check))})"
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
    """The verdict in one line, the reason first, then what failed."""
    if result.infeasible:
        count = len(result.infeasible)
        return f"FAIL: the operation cannot be done ({count} condition{'' if count == 1 else 's'} violated)"
    why, written = reasons(result), [check for check in result.checks if not check.implied]
    failed = [check for check in written if not check.passed]
    missed = f"{len(failed)} of {len(written)} requirements not met: {', '.join(map(_missed, failed))}"
    if why:
        more = f" (and {len(why) - 1} more)" if len(why) > 1 else ""
        return f"FAIL: {why[0]}{more}" + (f"; {missed}" if failed else "")
    if failed:
        return f"FAIL: {missed}"
    if result.scenario.set_aside:
        return "no verdict: stability is set aside (stability: ignore)"
    if not written:
        return "no verdict: the scenario has no requirements"
    doubts = [text for check in written for text in doubted(check, result.scenario)]
    if doubts:
        return f"PASS, but not by every history: {'; '.join(doubts)}"
    chances = [text for check in written for text in improbable(check)]
    if chances:
        return f"PASS, but not for sure: {'; '.join(chances)}"
    count = len(written)
    return f"PASS: {'the requirement is' if count == 1 else f'all {count} requirements are'} met"


def _missed(check: "Check") -> str:
    if check.keeps(check.value):
        return f"{check.measure} ({'; '.join(_not_enough(check))})"
    return check.measure


def _not_enough(check: "Check") -> Iterator[str]:
    """What is missed although the value keeps its limits."""
    histories = check.histories
    whole = histories is not None and check.keeps(histories.low) and check.keeps(histories.high)
    if check.whole_band and not whole:
        yield f"{_band(check)}, and the whole band is asked for"
    if check.probability is not None:
        asked = f"{check.probability:.4g} is asked for"
        if check.probability_reached is None:
            yield f"its probability is not known, {asked}"
        elif check.probability_reached < check.probability:
            yield f"kept with probability {chance(check.probability_reached)}, {asked}"


def chance(probability: float) -> str:
    """A probability with as many digits as tell it from 0 and 1."""
    return f"{probability:.3g}" if probability < 0.99 else f"{probability:.6f}".rstrip("0").rstrip(".")


def improbable(check: "Check") -> Iterator[str]:
    """A limit that is kept, but not by all of the band that the scatter of the inputs makes."""
    if check.band is None or check.probability_reached is None or not check.passed:
        return
    if check.keeps(check.band.low) and check.keeps(check.band.high):
        return
    low, high = (units.show(end, check.dimension, 4) for end in (check.band.low, check.band.high))
    yield (
        f"{check.measure} keeps its limit with probability {chance(check.probability_reached)} (90 % band {low} … {high}, limit "
        f"{requirement(check)})"
    )


def doubted(check: "Check", scenario: "Scenario") -> Iterator[str]:
    """What of friction, set-up and assumed values would give another verdict on a requirement."""
    if check.certainty != "not_every_history":
        return
    limits = [end for end in (check.minimum, check.maximum) if end is not None]
    limit = " to ".join(units.show(end, check.dimension, 3) for end in limits)
    if check.histories is not None and not all(check.keeps(end) for end in check.histories[:2]):
        yield f"{_band(check)}, limit {limit} ({check.measure}; {_holds(check)})"
    if check.off is not None and not check.keeps(check.off[1]):
        value = units.show(check.off[1], check.dimension, 3)
        yield f"{placed(scenario, check.off[0])} off by 10 % makes {check.measure} {value}, limit {limit}"


def _band(check: "Check") -> str:
    if check.histories is None:
        return "its band is not known"
    low, high = (
        "?" if end is None else units.show(end, check.dimension, 3)
        for end in (check.histories.low, check.histories.high)
    )
    return f"{check.histories.cause} leaves {low} … {high}"


def _holds(check: "Check") -> str:
    """The share of the band within the limits."""
    assert check.histories is not None
    low, high, _ = check.histories
    if low is None or high is None:
        return "one end of the band is not known"
    inside = [max(low, -math.inf if check.minimum is None else check.minimum),
              min(high, math.inf if check.maximum is None else check.maximum)]  # fmt: skip
    share = max(0.0, inside[1] - inside[0]) / (high - low) if high > low else 1.0
    return f"met over {share:.0%} of the band"


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
