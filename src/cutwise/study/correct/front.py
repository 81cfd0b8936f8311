"""What more of a limit buys: a program for each of several budgets, every one of them simulated."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from cutwise import units
from cutwise.spec.correct import BUDGETS, Bound, Correction
from cutwise.spec.faults import Fault
from cutwise.study.correct import objective, prove, told
from cutwise.study.correct.limits import asked, is_least
from cutwise.study.correct.loads import greatest, tip_compliance
from cutwise.study.correct.outcome import Task

if TYPE_CHECKING:
    from cutwise.study.correct.feed import Ready

BUDGET, KEPT = "budget", "keeps_all"
"""What a row of a front has beside its measures: what it may have of the limit [SI], and 1 where it keeps all of them."""


def refusals(said: Correction) -> Iterator[Fault]:
    """Budgets that nothing is made of."""
    if "cycle_time" in said.front and said.objective != "error":
        yield Fault(
            ("correct", "front", "cycle_time"), "is what the least error is looked for in; write objective: error"
        )


def rows(ready: Ready, task: Task, static: Mapping[str, float]) -> Iterator[Mapping[str, float]]:
    """The simulated program of each budget, by its measures and those of its cells at rest, and whether it keeps all limits."""
    from cutwise.study.correct.feed import limits_of

    walls = bool(tip_compliance(ready.scenario).any())
    for name, budgets in task.said.front.items():
        for budget in budgets:
            here = task if name == "cycle_time" else replace(task, said=_limited(task.said, name, budget))
            wanted = asked(here.scenario, here.said, walls=walls)
            limits = limits_of(ready, wanted, static)
            aim = objective.aimed(ready, here, wanted, limits, static, budget=budget if name == "cycle_time" else None)
            proof = prove.proved(ready, here, aim)
            feed = proof.schedule.feed
            missed = [] if proof.unchanged else [
                *proof.missed, *told.helpless(ready, aim.wanted, aim.room, aim.limits),
                *told.thin(ready, aim.room, feed, aim.limits), *proof.after.infeasible, *(one.code for one in proof.after.unsound),
                *(one.measure for one in proof.after.checks if not one.passed and one.measure != name),
            ]  # fmt: skip
            at_rest = static if proof.unchanged else greatest(ready.cells, proof.values)
            found = {measure: one.value for measure, one in proof.after.measures.items()}
            yield {BUDGET: budget, **at_rest, **found, KEPT: 0.0 if missed else 1.0}


def _limited(said: Correction, name: str, budget: float) -> Correction:
    """The section with a budget as its limit of a measure."""
    bound = Bound(**{"min" if is_least(name) else "max": budget})
    return said.model_copy(update={"limits": {**said.limits, name: bound}})


def dominated(front: list[Mapping[str, float]], name: str) -> list[bool]:
    """Rows that another one is no worse than, in time and in what the budget is of, and better in one of them.

    Examples
    --------
    More force and no less time:

    >>> dominated([{"cycle_time": 2.0, "force_xy_peak": 500.0}, {"cycle_time": 2.0, "force_xy_peak": 600.0}], "force_xy_peak")
    [False, True]
    """

    def pair(row: Mapping[str, float]) -> tuple[float, float]:
        value = objective.error_of(row, {})[0] if name == "cycle_time" else row.get(name, row.get(BUDGET))
        return row["cycle_time"], abs(value or 0.0)

    found = []
    for row in front:
        time, value = pair(row)
        others = [pair(one) for one in front if one is not row]
        found.append(any(t <= time and v <= value and (t < time or v < value) for t, v in others))
    return found


def shown(front: list[Mapping[str, float]], name: str, measures: tuple[str, ...]) -> list[tuple[str, ...]]:
    """A front in words: head, and one row a budget."""
    known = [one for one in measures if all(one in row for row in front)]
    head = (f"{name} of", *known, "")
    lines = [head]
    for row, beaten in zip(front, dominated(front, name), strict=True):
        values = [units.show(row[one], BUDGETS.get(one, "small_length"), 4) for one in known]
        note = "" if row[KEPT] else "misses a limit"
        lines.append(
            (
                units.show(row[BUDGET], BUDGETS[name], 4),
                *values,
                "; ".join(filter(None, (note, "buys nothing" * beaten))),
            )
        )
    return lines
