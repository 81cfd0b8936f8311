"""How much a result moves when its step is halved, and what follows from it."""

from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

from cutwise.results import Finding
from cutwise.spec.scenario import Scenario

NAMED = 0.01  # share of a measure that may move without a word
_ROUNDING = 1e-6  # of the largest measure of the same kind: what moves less is noise
_TWICE = 2.0  # an error that halves with the step is twice the change
_ROUGH = 0.1  # share of a required measure beyond which nothing is judged

Asked = TypeVar("Asked", bound=Scenario)


def divided(scenario: Asked, step: str, by: float = 2.0) -> Asked:
    """The scenario with a step of its numerics (``station``, ``time_step``) that is so many times smaller."""
    numerics: Any = scenario.numerics  # type: ignore[attr-defined]
    finer = numerics.model_copy(update={step: getattr(numerics, step) / by})
    return scenario.model_copy(update={"numerics": finer})


def change_on_halved_step(
    coarse: Mapping[str, float], fine: Mapping[str, float], *, shares: bool = True
) -> dict[str, float]:
    """Change of every measure that both runs have, fine minus coarse, in SI.

    ``shares``: with those of the terms, which jump where the worst place does.
    """
    both = {name: fine[name] - value for name, value in coarse.items() if name in fine}
    return both if shares else {name: change for name, change in both.items() if not name.startswith("share_")}


def findings(scenario: Scenario, found: Mapping[str, float], change: Mapping[str, float]) -> Iterator[Finding]:
    """Verdicts that depend on the step, then every measure that moves by more than 1 % when it is halved.

    A requirement is not converged where its limit lies within the error of the measure, which is taken as twice the
    change (first order), or where it moves by more than a tenth of the larger of itself and its limit. The required
    measures come first.
    """
    named = {name: moved for name, moved in change.items() if name in found and _moves(scenario, name, moved, found)}
    for name, limit in scenario.requirements.items():
        if name not in found or name not in change:
            continue
        value, error = found[name], _TWICE * abs(change[name])
        ends = [end for end in (limit.min, limit.max) if end is not None]
        crossed = any(abs(end - value) < error for end in ends)
        scale = max(abs(value), *(abs(end) for end in ends))
        if error > 0.0 and (crossed or abs(change[name]) > _ROUGH * scale):
            dimension = scenario.measures[name].dimension
            room = min(abs(end - value) for end in ends)
            yield Finding("unconverged", value=change[name], limit=room, dimension=dimension, measure=name)
            named.pop(name, None)
    for name in sorted(named, key=lambda name: name not in scenario.requirements):
        dimension = scenario.measures[name].dimension
        allowed = NAMED * abs(found[name])
        yield Finding("moves", value=named[name], limit=allowed, dimension=dimension, measure=name)


def _moves(scenario: Scenario, name: str, moved: float, found: Mapping[str, float]) -> bool:
    dimension = scenario.measures[name].dimension
    largest = max(abs(value) for other, value in found.items() if scenario.measures[other].dimension == dimension)
    return abs(moved) > max(NAMED * abs(found[name]), _ROUNDING * largest)
