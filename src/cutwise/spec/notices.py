"""Warnings about values that are possible but unusual, with what is usual."""

from collections.abc import Iterator
from typing import Any, NamedTuple

from pydantic.fields import FieldInfo

from cutwise import units
from cutwise.spec import fields
from cutwise.spec.base import Spec, Usual
from cutwise.spec.faults import Path, dotted, split_dotted
from cutwise.spec.scenario import Scenario

NOT_USED = "is not used: "
"""How what is said of a key that changes nothing begins."""


class Noticed(NamedTuple):
    """Something about a value of a scenario that an engineer should know."""

    code: str  # unusual, not_used, beyond_data, or noticed: a sentence of the section
    path: Path
    message: str
    value: float | None = None  # SI
    limit: float | None = None  # the end of the usual range that is passed
    dimension: str = "dimensionless"

    @property
    def words(self) -> str:
        """One line: the key, and what there is to say."""
        return f"{dotted(self.path)}: {self.message}"


def noticed(scenario: Scenario) -> Iterator[Noticed]:
    """What is unusual about a scenario, and keys that are not used, as records."""
    yield from _unusual_values(scenario)
    yield from (Noticed("noticed", *one) for one in _notices(scenario))
    yield from (Noticed("not_used", *one) for one in _unused(scenario))
    yield from _beyond(scenario)


def notices(scenario: Scenario) -> tuple[str, ...]:
    """What is unusual about a scenario, one line each: the key, the value, what is usual; and keys that are not used."""
    return tuple(one.words for one in noticed(scenario))


def _unusual_values(scenario: Scenario) -> Iterator[Noticed]:
    for before, spec in fields.specs(scenario):
        for name, info in type(spec).model_fields.items():
            usual, dimension, value = fields.usual(info), fields.dimension(info), getattr(spec, name)
            if usual is None or not isinstance(value, int | float) or _from_library(scenario, (*before, name)):
                continue
            low, high = (_bound(end, dimension) for end in (usual.low, usual.high))
            under = low is not None and value < low * (1 - 1e-9)
            if under or (high is not None and value > high * (1 + 1e-9)):
                said = f"{_shown(value, info)} is unusual; usual is {range_text(usual)}"
                limit = low if under else high
                yield Noticed("unusual", (*before, name), said, float(value), limit, dimension or "dimensionless")


def _from_library(scenario: Scenario, path: Path) -> bool:
    """Whether a value stands in the library that comes with cutwise: it has its source, and is no slip of the pen."""
    origin = scenario.origins.get(dotted(path))
    return origin is not None and bool(origin.library) and not origin.library.endswith((".yaml", ".yml"))


def range_text(usual: Usual) -> str:
    """A usual range in words."""
    if usual.low is None:
        return f"up to {usual.high}"
    if usual.high is None:
        return f"{usual.low} or more"
    return f"{usual.low} to {usual.high}"


def _bound(end: str | float | None, dimension: str | None) -> float | None:
    return end if dimension is None or end is None else units.parse(end, dimension)  # type: ignore[return-value]


def _shown(value: float, info: FieldInfo) -> str:
    dimension = fields.dimension(info)
    return units.show(value, dimension) if dimension else str(value)


def _notices(scenario: Scenario) -> Iterator[tuple[Path, str]]:
    for before, spec in fields.specs(scenario):
        for path, message in spec.notices():
            yield (*before, *path), message


_MEASURED_AT = {("spindle-seals", "pressure"): "pressure"}  # kind and column of a calibration: key of its section


def _beyond(scenario: Scenario) -> Iterator[Noticed]:
    """Values outside of the range in which those of their entry were measured."""
    for section, said in scenario.measured.items():
        for (kind, column), key in _MEASURED_AT.items():
            owner: Any = scenario
            for step in split_dotted(section):
                owner = owner[step] if isinstance(step, int) else getattr(owner, step, None)
            value = getattr(owner, key, None)
            if said.kind != kind or not isinstance(value, float):
                continue
            dimension = fields.dimension(type(owner).model_fields[key]) or "dimensionless"
            ends = said.ends(column, dimension)
            if ends is not None and not ends[0] * (1 - 1e-9) <= value <= ends[1] * (1 + 1e-9):
                shown = [units.show(end, dimension) for end in (value, *ends)]
                message = (
                    f"{shown[0]} is outside of what {said.library} was measured at, {shown[1]} to {shown[2]}: its values, and "
                    "their band, are carried on beyond their data"
                )
                limit = ends[0] if value < ends[0] else ends[1]
                yield Noticed("beyond_data", (*split_dotted(section), key), message, value, limit, dimension)


def _unused(scenario: Scenario) -> Iterator[tuple[Path, str]]:
    """Keys that the engineer wrote and that change nothing."""
    for before, spec in fields.specs(scenario):
        for path, reason in spec.unused():
            if _written(scenario, spec, before, path):
                yield (*before, *path), f"{NOT_USED}{reason}"


def _written(scenario: Scenario, spec: Spec, before: Path, path: Path) -> bool:
    """Whether a key was written by choice: it may be left out, and its value is not that of a library entry."""
    owner: Any = spec
    for step in path[:-1]:
        owner = owner[step] if isinstance(step, int) else getattr(owner, str(step))
        if owner is None:
            return False
    name = str(path[-1])
    if (
        type(owner).model_fields[name].is_required()
        or name not in owner.model_fields_set
        or getattr(owner, name) is None
    ):
        return False
    if not before and isinstance(getattr(owner, name), Spec) and len(path) == 1:
        return True  # no entry brings a section of the scenario
    key = dotted((*before, *path))
    origins = [origin for at, origin in scenario.origins.items() if at == key or at.startswith((f"{key}.", f"{key}["))]
    return not origins or any(not origin.library for origin in origins)
