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

_FACTORS = (1.03, 0.96, 1.4, 0.6, 3.0)
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
    yield from _keys(scenario, ())


def _keys(spec: Spec, before: Path) -> Iterator[Key]:
    for name, info in type(spec).model_fields.items():
        value, here = getattr(spec, name, None) if name != "from" else spec.__dict__["from"], (*before, name)
        below = list(_below(value, here))
        yield Key(here, info, value)
        for path, section in below:
            yield from _keys(section, path)


def _below(value: Any, here: Path) -> Iterator[tuple[Path, Spec]]:
    """Sections in a value, with their places."""
    if isinstance(value, Spec):
        yield here, value
    elif isinstance(value, tuple | Mapping):
        for step, entry in value.items() if isinstance(value, Mapping) else enumerate(value):
            if isinstance(entry, Spec):
                yield (*here, step), entry


def holds_sections(key: Key) -> bool:
    """Whether the key is turned by those of the sections in it."""
    return any(True for _ in _below(key.said, key.path))


def others(key: Key) -> list[Any]:
    """Other values for a key, as a scenario says them: those that are closest to it first."""
    found = [] if key.said is None or holds_sections(key) else list(_turned(key.said, key.info))
    found += [_read(example) for example in key.info.examples or ()]
    return [value for place, value in enumerate(found) if value != key.said and value not in found[:place]]


def _turned(said: Any, info: FieldInfo) -> Iterator[Any]:
    dimension = fields.dimension(info)
    if isinstance(said, bool):
        yield not said
    elif isinstance(said, str):
        yield from (choice for choice in _choices(info) if choice != said)
        if not list(_choices(info)):
            yield f"{said}x"
    elif dimension is not None and _is_amount(said):
        yield from (_scaled(said, factor, dimension) for factor in _FACTORS)
    elif isinstance(said, int):
        yield from (said + 1, said - 1, 2 * said, said // 2)
    elif isinstance(said, tuple):
        yield list(said[:-1])
        yield from ([choice] for choice in _choices(info) if (choice,) != said)


def _is_amount(said: Any) -> bool:
    return isinstance(said, int | float) or (isinstance(said, tuple) and bool(said) and all(map(_is_amount, said)))


def _scaled(said: Any, factor: float, dimension: str) -> Any:
    """An amount, or several, times a factor; those that are zero are shifted."""
    if isinstance(said, tuple):
        return [_scaled(entry, factor, dimension) for entry in said]
    value = said * factor if said else _SHIFTS.get(dimension, 1e-2 * _example_of(dimension)) * factor
    return value if dimension == "dimensionless" else units.text(value, dimension)


def _example_of(dimension: str) -> float:
    return units.parse(units.DIMENSIONS[dimension].example, dimension)


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
    if isinstance(plain, list):
        copy: Any = list(plain) if len(plain) > step else list(full)  # type: ignore[operator]
    else:
        copy = dict(plain)
    here = copy[step] if isinstance(copy, list) else copy.get(step)
    known = full[step] if isinstance(full, Sequence) or (isinstance(full, Mapping) and step in full) else None
    copy[step] = with_value(here, known, tuple(rest), value)
    return copy
