"""What makes an unstable position loop stable: changes that were tried, with the keys that they belong to."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from cutwise import units
from cutwise.physics.motion.drives import Controller, Plant
from cutwise.physics.motion.loop import loop_figures

_LESS = (0.8, 0.5, 0.3, 0.2, 0.1, 0.05, 0.02, 0.01, 5e-3, 2e-3, 1e-3)
_MORE = (1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0)
_SAMPLES = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0)  # derivative time over the sample time, where there is no derivative gain
_ENOUGH = 0.35  # [rad] phase margin that a remedy should bring


class GainKeys(NamedTuple):
    """Where the gains of a loop are written; a reading of the table may have exchanged them."""

    proportional: str
    integral: str
    derivative: str


def remedies(plant: Plant, law: Controller, keys: GainKeys) -> list[str]:
    """Changes, one at a time, with which the sampled loop of an axis is stable; the least one of each kind."""
    kinds: dict[str, dict[str, Controller]] = {}
    for kind, words, tried in _trials(law, keys):
        kinds.setdefault(kind, {})[words] = tried
    found = [_first(plant, trials) for trials in kinds.values()]
    return [words for words in found if words]


def _first(plant: Plant, trials: Mapping[str, Controller]) -> str:
    """The first trial with a margin worth having, else the first that is stable at all."""
    figures = {words: loop_figures(plant, law) for words, law in trials.items()}
    stable = [words for words, f in figures.items() if f.stable]
    good = [words for words in stable if figures[words].sampled_phase_margin >= _ENOUGH]
    return next(iter([*good, *stable]), "")


def _trials(law: Controller, keys: GainKeys) -> Iterator[tuple[str, str, Controller]]:
    """Kind of change, the change in words, and the controller with it."""
    for gain in ("proportional", "integral", "derivative"):
        value, key = getattr(law, gain), getattr(keys, gain)
        for factor in _LESS if value > 0.0 else ():
            yield f"less {gain}", f"{key} times {factor:g}", law._replace(**{gain: factor * value})
    for factor in _MORE if law.derivative > 0.0 else ():
        yield "more derivative", f"{keys.derivative} times {factor:g}", law._replace(derivative=factor * law.derivative)
    for count in _SAMPLES if law.derivative == 0.0 else ():
        value = count * law.sample_time * (law.proportional or law.integral * law.sample_time)
        shown = units.show(value, "derivative_gain", 3)
        yield "more derivative", f"{keys.derivative} of {shown}", law._replace(derivative=value)
    for factor in _LESS:
        step = factor * law.sample_time
        yield "sampling", f"sample_time of {1e3 * step:.3g} ms", law._replace(sample_time=step)
    if law.delay:
        yield "delay", "no delay", law._replace(delay=0.0)
