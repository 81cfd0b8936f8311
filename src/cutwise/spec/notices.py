"""Warnings about values that are possible but unusual, with what is usual."""

from collections.abc import Iterator
from typing import Any

from pydantic.fields import FieldInfo

from cutwise import units
from cutwise.spec import fields
from cutwise.spec.base import Spec, Usual
from cutwise.spec.faults import Path, dotted
from cutwise.spec.scenario import Scenario


def notices(scenario: Scenario) -> tuple[str, ...]:
    """What is unusual about a scenario, one line each: the key, the value, what is usual."""
    unusual = [f"{dotted(path)}: {message}" for path, message in _unusual_values(scenario)]
    return (*unusual, *(f"{dotted(path)}: {message}" for path, message in _remarks(scenario, ())))


def _unusual_values(scenario: Scenario) -> Iterator[tuple[Path, str]]:
    for path, info, value in fields.leaves(scenario):
        usual, dimension = fields.usual(info), fields.dimension(info)
        if usual is None or not isinstance(value, int | float):
            continue
        low, high = (_bound(end, dimension) for end in (usual.low, usual.high))
        if (low is not None and value < low * (1 - 1e-9)) or (high is not None and value > high * (1 + 1e-9)):
            yield path, f"{_shown(value, info)} is unusual; usual is {range_text(usual)}"


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


def _remarks(spec: Spec, before: Path) -> Iterator[tuple[Path, str]]:
    for path, message in spec.remarks():
        yield (*before, *path), message
    for name in type(spec).model_fields:
        value: Any = getattr(spec, name)
        if isinstance(value, Spec):
            yield from _remarks(value, (*before, name))
