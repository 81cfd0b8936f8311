"""Every key of a scenario, and other values that it may take: what the test of dead keys turns one at a time."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, NamedTuple, get_args, get_origin

from pydantic.fields import FieldInfo
from ruamel.yaml import YAML

from cutwise import units
from cutwise.spec import fields
from cutwise.spec.base import Spec
from cutwise.spec.faults import Path
from cutwise.spec.scenario import Scenario

_FACTORS = (1.03, 0.96, 1.4, 0.6, 0.03, 30.0)  # far ones for what is only a limit
_NEAR_BOUND = 0.999
_SHIFTS = {  # [SI] of what is zero
    "length": 1e-4, "small_length": 2e-6, "angle": 0.03, "small_angle": 1e-4, "speed": 1e-3, "dimensionless": 0.05,
}  # fmt: skip


class Key(NamedTuple):
    """A key of a scenario, and what it says there."""

    path: Path
    info: FieldInfo
    said: Any  # None where nothing is said


def keys(scenario: Scenario) -> Iterator[Key]:
    """Every key of every section that the scenario has, with and without a value."""
    for before, spec in fields.specs(scenario):
        for name, info in type(spec).model_fields.items():
            yield Key((*before, name), info, spec.__dict__[name])


def holds_sections(key: Key) -> bool:
    """Whether the key is turned by those of the sections in it."""
    entries = key.said.values() if isinstance(key.said, Mapping) else key.said
    listed = isinstance(key.said, tuple | Mapping) and any(isinstance(entry, Spec) for entry in entries)
    return isinstance(key.said, Spec) or listed


def others(key: Key) -> list[Any]:
    """Other values for a key, as a scenario says them: those that are closest to it first."""
    examples = [_read(example) for example in key.info.examples or ()]
    if holds_sections(key):
        found = []
    elif key.said is None:
        found = [*examples, *_choices(key.info), *(value for example in examples for value in _far(example, key.info))]
    else:
        found = [*_turned(key.said, key.info), *examples]
    if not found or (key.said is not None and not holds_sections(key)):
        found += [_least(kind) for kind in fields.sections(key.info) if not isinstance(key.said, kind)]
    said = list(key.said) if isinstance(key.said, tuple) else key.said
    return [value for place, value in enumerate(found) if value != said and value not in found[:place]]


def _turned(said: Any, info: FieldInfo) -> Iterator[Any]:
    dimension = fields.dimension(info)
    if isinstance(said, bool):
        yield not said
    elif isinstance(said, str):
        yield from (choice for choice in _choices(info) if choice != said)
        if dimension is not None:
            amount = units.parse(units.DIMENSIONS[dimension].example, dimension)
            yield from (_scaled(amount, factor, dimension) for factor in _FACTORS)
        elif not list(_choices(info)):
            yield f"{said}x"
    elif dimension is not None and _is_amount(said):
        yield from (_scaled(said, factor, dimension) for factor in _FACTORS)
        yield from _near_bounds(said, info, dimension)
    elif isinstance(said, int):
        yield from (said + 1, said - 1, 2 * said, said // 2)
    elif isinstance(said, tuple):
        yield list(said[:-1])
        yield from ([choice] for choice in _choices(info) if (choice,) != said)


def _far(example: Any, info: FieldInfo) -> Iterator[Any]:
    """Small and large amounts beside an example: what is only a limit acts at one of them."""
    dimension = fields.dimension(info)
    if dimension is None or isinstance(example, list | dict):
        return
    value = units.parse(example, dimension)
    yield from (_scaled(value, factor, dimension) for factor in _FACTORS)


def _near_bounds(said: Any, info: FieldInfo, dimension: str) -> Iterator[Any]:
    if not isinstance(said, float):
        return
    for bound in info.metadata:
        for end in ("lt", "le"):
            if getattr(bound, end, None) is not None:
                yield _scaled(_NEAR_BOUND * getattr(bound, end), 1.0, dimension)


def _is_amount(said: Any) -> bool:
    if isinstance(said, tuple):
        return bool(said) and all(map(_is_amount, said))
    return isinstance(said, int | float)


def _scaled(said: Any, factor: float, dimension: str) -> Any:
    """An amount, or several, times a factor; those that are zero are shifted, each by another amount."""
    if isinstance(said, tuple):
        return [_scaled(entry, factor + 0.01 * place, dimension) for place, entry in enumerate(said)]
    shift = _SHIFTS.get(dimension, 1e-2 * units.parse(units.DIMENSIONS[dimension].example, dimension))
    value = said * factor if said else shift * factor
    return value if dimension == "dimensionless" else units.text(value, dimension)


def _least(section: type[Spec]) -> dict[str, Any]:
    """A section that says what it has to, by the examples of its keys."""
    found = {}
    for name, info in section.model_fields.items():
        if info.is_required():
            found[name] = _example(info)
    free = [name for name, info in section.model_fields.items() if not info.is_required() and info.examples]
    return found or {name: _example(section.model_fields[name]) for name in free[:1]}


def _example(info: FieldInfo) -> Any:
    """An example of a key; an amount that is not zero."""
    if not info.examples:
        return _least(fields.sections(info)[0])
    said, dimension = _read(info.examples[0]), fields.dimension(info)
    if dimension is None or isinstance(said, dict):
        return said
    try:
        return _scaled(_parsed(said, dimension), 1.0, dimension)
    except units.UnitFault:  # a word among amounts
        return said


def _parsed(said: Any, dimension: str) -> Any:
    return (
        tuple(_parsed(entry, dimension) for entry in said) if isinstance(said, list) else units.parse(said, dimension)
    )


def _choices(info: FieldInfo) -> Iterator[str]:
    """The words that a key admits, those of an entry for a list."""
    for kind, _ in fields.of_field(info):
        for one in (kind, *(get_args(kind)[:1] if get_origin(kind) in (tuple, list) else ())):
            if get_origin(one) is Literal:
                yield from get_args(one)


def _read(example: Any) -> Any:
    return YAML(typ="safe").load(example) if isinstance(example, str) else example


def with_value(plain: Any, full: Any, path: Path, value: Any) -> Any:
    """The bare values of a scenario with one replaced; lists on the way that were not written are written out."""
    if not path:
        return value
    step, *rest = path
    if plain is None:
        plain = [] if isinstance(step, int) else {}
    copy: Any = dict(plain) if isinstance(plain, dict) else list(plain) if len(plain) > step else list(full)
    here = copy[step] if isinstance(copy, list) else copy.get(step)
    known = full[step] if isinstance(full, Sequence) or (isinstance(full, Mapping) and step in full) else None
    copy[step] = with_value(here, known, tuple(rest), value)
    return copy
