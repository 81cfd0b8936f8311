"""Verdict and requirements in words, the same on the command line and in the report."""

import math
import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from cutwise import units
from cutwise.app.findings import reasons
from cutwise.app.numbers import amount, form, span
from cutwise.results import PARAMETERS
from cutwise.spec.fields import placed
from cutwise.spec.scenario import Limit

if TYPE_CHECKING:
    from cutwise.results import Check, Result
    from cutwise.spec.scenario import Scenario


def against(check: "Check", scenario: "Scenario") -> str:
    """By how much a failed requirement is missed."""
    if check.passed:
        return ""
    if check.value is None:
        return " (the run has no such measure)"
    if check.keeps(check.value):
        return f" ({'; '.join(_not_enough(check, scenario))})"
    return f" by {amount(scenario, check.measure, -margin(check))}"  # type: ignore[operator]


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
    names = ", ".join(_missed(check, result.scenario) for check in failed)
    missed = f"{len(failed)} of {len(written)} requirements not met: {names}"
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
    count = len(written)
    return f"PASS: {'the requirement is' if count == 1 else f'all {count} requirements are'} met"


def verdict_reason(result: "Result") -> str:
    """What follows the word of the verdict; a doubt about a PASS stays one."""
    return re.sub(r"^(PASS|FAIL|no verdict)[:,] ", "", verdict_line(result))


def _missed(check: "Check", scenario: "Scenario") -> str:
    if check.keeps(check.value):
        return f"{check.measure} ({'; '.join(_not_enough(check, scenario))})"
    return check.measure


def _not_enough(check: "Check", scenario: "Scenario") -> Iterator[str]:
    """What is missed although the value keeps its limits."""
    histories = check.histories
    whole = histories is not None and check.keeps(histories.low) and check.keeps(histories.high)
    if check.whole_band and not whole:
        yield f"{_band(check, scenario)[0]}, and the whole band is asked for"
    if check.probability is not None:
        asked = f"{check.probability:.4g} is asked for"
        if check.probability_reached is None:
            yield f"its probability is not known, {asked}"
        elif check.probability_reached < check.probability:
            yield f"kept with probability {chance(check.probability_reached)}, {asked}"


def chance(probability: float) -> str:
    """A probability with as many digits as tell it from 0 and 1."""
    return f"{probability:.3g}" if probability < 0.99 else f"{probability:.6f}".rstrip("0").rstrip(".")


def doubted(check: "Check", scenario: "Scenario") -> Iterator[str]:
    """What of friction, set-up, scatter of the inputs and assumed values would give another verdict on a requirement."""
    if check.certainty != "not_every_history":
        return
    if check.histories is not None and not all(check.keeps(end) for end in check.histories[:2]):
        left, limit = _band(check, scenario)
        yield f"{left}, limit {limit} ({check.measure}; {_holds(check)})"
    scattered = check.band is not None and not (check.keeps(check.band.low) and check.keeps(check.band.high))
    if scattered and check.probability is None:
        assert check.band is not None
        ends, limit = span(scenario, check.measure, (check.band.low, check.band.high), _limit(check))
        reached = check.probability_reached
        kept = "" if reached is None else f"; kept with probability {chance(reached)}"
        yield f"{PARAMETERS} leave {ends}, limit {limit} ({check.measure}{kept})"
    if check.off is not None and not check.keeps(check.off[1]):
        (value, limit) = span(scenario, check.measure, (check.off[1],), _limit(check))
        yield f"{placed(scenario, check.off[0])} off by 10 % makes {check.measure} {value}, limit {limit}"


def _limit(check: "Check") -> Limit:
    return Limit.model_construct(min=check.minimum, max=check.maximum)


def _band(check: "Check", scenario: "Scenario") -> tuple[str, str]:
    """What the histories leave, in words, and the limit."""
    if check.histories is None:
        return "its band is not known", ""
    ends, limit = span(scenario, check.measure, (check.histories.low, check.histories.high), _limit(check))
    return f"{check.histories.cause} leaves {ends}", limit


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
        (str(name), *map(form(known[str(name)].dimension, array.values.tolist()).text, array.values))
        for name, array in data.data_vars.items()
    ]
    return ("measure", *map(str, data["strategy"].values)), rows
