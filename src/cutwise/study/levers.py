"""Settings that may be turned: what a process offers, what the user allows, and how they are written down."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from difflib import get_close_matches
from typing import NamedTuple

from cutwise import units
from cutwise.spec import fields
from cutwise.spec.faults import Fault, Path, ScenarioFault, dotted, split_dotted
from cutwise.spec.fields import placed
from cutwise.spec.scenario import Scenario

LIMITS = 'limits["{}"]'
"""How a message names a lever in Python; the command line says ``--limit``."""


class Lever(NamedTuple):
    """A setting that may be turned, in SI; several numbers are turned together, by a factor."""

    key: str
    name: str  # with what stands there
    dimension: str
    now: float | None  # None: not written in the scenario, such as the feed that a program has in its blocks
    low: float
    high: float
    given: tuple[float, ...] = ()  # the numbers that a factor turns
    whole: bool = False  # a number of things

    def shown(self, value: float | None, figures: int = 3) -> str:
        """A value of the setting as people read it."""
        if value is None:
            return "as it is"
        if self.whole:
            return str(round(value))
        return f"{value:.{figures}g} times" if self.given else units.show(value, self.dimension, figures)

    def written(self, value: float) -> float | int | tuple[float, ...]:
        """A value of the setting in SI, as a scenario takes it."""
        if self.whole:
            return round(value)
        return tuple(value * entry for entry in self.given) if self.given else value


def read_limits(scenario: Scenario, texts: Sequence[str]) -> dict[str, tuple[str, str]]:
    """``key=low..high`` as limits of levers; none, if there are no texts.

    Raises
    ------
    ScenarioFault
        Everything that is wrong with the texts.
    """
    limits: dict[str, tuple[str, str]] = {}
    faults = []
    for text in texts:
        key, _, span = text.partition("=")
        low, dots, high = (part.strip() for part in span.partition(".."))
        if not dots:
            faults.append(Fault((), "is not of the form dotted.key=low..high", file=f"--limit {key.strip()}"))
        limits[key.strip()] = (low, high)
    if faults:
        raise ScenarioFault(faults)
    if limits:
        levers_of(scenario, limits, "--limit {}")
    return limits


def levers_of(
    scenario: Scenario, limits: Mapping[str, tuple[str, str]] | None = None, named: str = LIMITS
) -> tuple[Lever, ...]:
    """The levers within their limits; without limits, those of the process that this scenario has.

    A lever may be any quantity that can be set, whether or not the scenario writes it.

    Raises
    ------
    ScenarioFault
        Limits on what is no quantity of this process, or that are none.
    """
    given = {dotted(path): value for path, _, value in fields.leaves(scenario)}
    if not limits:
        idle = {(*before, *path) for before, spec in fields.specs(scenario) for path, _ in spec.unused()}
        offered = (
            (key, given.get(key), ends) for key, ends in scenario.turned().items() if _counts(scenario, key, idle)
        )
        return tuple(lever for key, now, ends in offered if (lever := _lever(scenario, key, now, ends)) is not None)
    levers, faults = [], []
    for key, ends in limits.items():
        wrong = list(_wrong(scenario, key, given.get(key), ends, named.format(key)))
        faults += wrong
        now = given.get(key)
        lever = None if wrong else _lever(scenario, key, None if isinstance(now, str) else now, ends)
        if lever is not None:
            levers.append(lever)
    if faults:
        raise ScenarioFault(faults)
    return tuple(levers)


def _counts(scenario: Scenario, key: str, idle: Collection[Path]) -> bool:
    """Whether a key counts in this scenario: its section is written, and neither of them is told as not used."""
    path = split_dotted(key)
    return getattr(scenario, str(path[0])) is not None and all(
        path[:depth] not in idle for depth in range(1, len(path) + 1)
    )


def _lever(scenario: Scenario, key: str, now: object, ends: tuple[str, str]) -> Lever | None:
    info = fields.field_at(type(scenario), split_dotted(key))
    dimension = fields.dimension(info) if info is not None else None
    name = placed(scenario, key)
    if isinstance(now, int) and not isinstance(now, bool):
        return Lever(key, name, "dimensionless", float(now), float(ends[0]), float(ends[1]), whole=True)
    if dimension is None or isinstance(now, str):  # a word, such as a posture to be searched for
        return None
    if isinstance(now, tuple):
        if not now or not all(isinstance(entry, float) for entry in now):
            return None
        low, high = (units.parse(end, "dimensionless") for end in ends)
        return Lever(key, name, dimension, 1.0, low, high, given=now)
    low, high = (units.parse(end, dimension) for end in ends)
    return Lever(key, name, dimension, now if isinstance(now, float) else None, low, high)


def _wrong(scenario: Scenario, key: str, now: object, ends: tuple[str, str], place: str) -> Iterator[Fault]:
    """What is wrong with the limits of a lever."""
    info = fields.field_at(type(scenario), split_dotted(key))
    dimension = fields.dimension(info) if info is not None else None
    whole = isinstance(now, int) and not isinstance(now, bool)
    if isinstance(now, tuple) or whole:
        dimension = "dimensionless"  # a factor on all of its numbers, or a number of things
    elif isinstance(split_dotted(key)[-1:] and split_dotted(key)[-1], int):
        dimension = None  # one number of a list
    if dimension is None:
        yield Fault((), _no_lever(scenario, key), file=place)
        return
    read = []
    for end in ends:
        try:
            read.append(units.parse(end, dimension))
        except units.UnitFault as fault:
            yield Fault((), str(fault), file=place)
    if len(read) == 2 and read[0] >= read[1]:
        yield Fault((), f"{ends[0]} is not below {ends[1]}", file=place)


def _no_lever(scenario: Scenario, key: str) -> str:
    whole = key.rpartition("[")[0]
    known = {dotted(path): info for path, info in fields.keys(type(scenario)) if fields.dimension(info)}
    if whole in known or whole in {dotted(path) for path, _, _ in fields.leaves(scenario)}:
        return f"is one number of {whole}; set limits on {whole}, with factors, which turn all of them"
    near = get_close_matches(key, known, n=1)
    return "is not a quantity of this scenario" + (f"; did you mean {near[0]}?" if near else "")
