"""What the specification says about a key: its field, its dimension, its alternatives."""

import re
from collections.abc import Iterator, Mapping, Sequence
from types import NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import Tag
from pydantic.fields import FieldInfo

from cutwise.spec.base import ByChance, Quantity, Spec, Usual
from cutwise.spec.faults import Path, split_dotted

# how pydantic names the alternatives of a union that has no tags: literal['auto'], tuple[str, str, str], function-after[...]
_ALTERNATIVE = re.compile(r"<|(?:literal|tuple|list|dict|union|nullable|function-[a-z]+)\[")
_PLAIN = ("int", "float", "str", "bool")  # the same, where the alternative is a plain type


def tag(name: str) -> Tag:
    """Name of an alternative of a key; :func:`without_tags` knows it in the location of a pydantic error."""
    return Tag(f"<{name}>")


def without_tags(location: Sequence[str | int]) -> Path:
    """The path in the scenario of a pydantic error location: without the alternative of a union that was tried."""
    steps = tuple(step for step in location if not (isinstance(step, str) and _ALTERNATIVE.match(step)))
    return steps[:-1] if len(steps) > 1 and steps[-1] in _PLAIN else steps


def alternatives(annotation: Any, metadata: Sequence[Any] = ()) -> Iterator[tuple[Any, tuple[Any, ...]]]:
    """The plain types that an annotation admits, each with its metadata; ``None`` is left out."""
    origin = get_origin(annotation)
    if origin is Annotated:
        inner, *more = get_args(annotation)
        yield from alternatives(inner, (*metadata, *more))
    elif origin in (Union, UnionType):
        for member in get_args(annotation):
            yield from alternatives(member, metadata)
    elif annotation is not NoneType:
        yield annotation, tuple(metadata)


def of_field(info: FieldInfo) -> Iterator[tuple[Any, tuple[Any, ...]]]:
    """The types that a field admits, each with its metadata."""
    return alternatives(info.annotation, info.metadata)


def sections(info: FieldInfo) -> list[type[Spec]]:
    """The specifications that a field admits."""
    return [kind for kind, _ in of_field(info) if isinstance(kind, type) and issubclass(kind, Spec)]


def dimension(info: FieldInfo) -> str | None:
    """Dimension of a quantity field, or of the entries of a list of quantities."""
    return next((item.dimension for item in _metadata(info) if isinstance(item, Quantity)), None)


def dimension_at(model: type[Spec], path: Path) -> str | None:
    """Dimension of a number at a path, which may lead into lists of several dimensions: a twist, compliances of a base."""
    named = max((k for k, step in enumerate(path) if isinstance(step, str)), default=-1) + 1
    info = field_at(model, path[:named])
    if info is None:
        return None
    kinds = list(of_field(info))
    for step in path[named:]:
        kinds = [inside for kind, _ in kinds for inside in _element(kind, int(step))]
    metadata = (item for kind, own in kinds for item in (*own, *(m for _, more in of_entries(kind) for m in more)))
    return next((item.dimension for item in metadata if isinstance(item, Quantity)), None)


def _element(kind: Any, number: int) -> Iterator[tuple[Any, tuple[Any, ...]]]:
    """The types of an element of a list type."""
    if get_origin(kind) not in (tuple, list):
        return
    arguments = get_args(kind)
    if len(arguments) == 2 and arguments[1] is Ellipsis:
        yield from alternatives(arguments[0])
    elif number < len(arguments):
        yield from alternatives(arguments[number] if get_origin(kind) is tuple else arguments[0])


def usual(info: FieldInfo) -> Usual | None:
    """Usual range of a field."""
    return next((item for item in _metadata(info) if isinstance(item, Usual)), None)


def by_chance(info: FieldInfo) -> bool:
    """Whether the value of a field is another for each part."""
    return any(isinstance(item, ByChance) for item in _metadata(info))


def _metadata(info: FieldInfo) -> Iterator[Any]:
    for kind, metadata in of_field(info):
        yield from metadata
        for _, inside in of_entries(kind):
            yield from inside


def of_entries(kind: Any) -> Iterator[tuple[Any, tuple[Any, ...]]]:
    """The types of the entries of a list or mapping type."""
    origin, arguments = get_origin(kind), get_args(kind)
    if origin in (tuple, list):
        yield from alternatives(arguments[0])
    elif origin is dict:
        yield from alternatives(arguments[1])


def inner(info: FieldInfo) -> Iterator[type[Spec]]:
    """Specifications inside a field: its sections, or the entries of a list or mapping of sections."""
    for kind, _ in of_field(info):
        for found in (kind, *(entry for entry, _ in of_entries(kind))):
            if isinstance(found, type) and issubclass(found, Spec):
                yield found


def field_at(model: type[Spec], path: Path) -> FieldInfo | None:
    """The field that a path names, through every alternative; an entry of a list has the field of the list."""
    info = model.model_fields.get(str(path[0])) if path else None
    if info is None or len(path) == 1:
        return info
    return next((found for kind, _ in of_field(info) if (found := _below(kind, path[1:], info)) is not None), None)


def _below(kind: Any, path: Path, info: FieldInfo) -> FieldInfo | None:
    """The field at a path inside of a type; ``info`` is the field that the type belongs to."""
    if not path:
        return info
    if isinstance(kind, type) and issubclass(kind, Spec):
        return field_at(kind, path)
    named = str if get_origin(kind) is dict else int  # a word after a list names nothing in it, but a key elsewhere
    entries = (_below(entry, path[1:], info) for entry, _ in of_entries(kind) if isinstance(path[0], named))
    return next((found for found in entries if found is not None), None)


def keys(model: type[Spec], before: Path = ()) -> Iterator[tuple[Path, FieldInfo]]:
    """Every key of a specification with its field, sections before what is in them; lists without their numbers."""
    for name, info in model.model_fields.items():
        yield (*before, name), info
        listed = [] if get_origin(info.annotation) is dict else inner(info)
        for section in listed:
            if section.listed:
                yield from keys(section, (*before, name))


def specs(spec: Spec, before: Path = ()) -> Iterator[tuple[Path, Spec]]:
    """A specification and all those inside of it."""
    yield before, spec
    for name in type(spec).model_fields:
        value = getattr(spec, name)
        if isinstance(value, Spec):
            yield from specs(value, (*before, name))
        elif isinstance(value, tuple | Mapping):
            for step, entry in value.items() if isinstance(value, Mapping) else enumerate(value):
                if isinstance(entry, Spec):
                    yield from specs(entry, (*before, name, step))


def leaves(spec: Spec) -> Iterator[tuple[Path, FieldInfo, Any]]:
    """Every value that was given or has a default, with its path and field, those of sections in lists too."""
    for before, section in specs(spec):
        for name, info in type(section).model_fields.items():
            value = getattr(section, name)
            if value is not None and not isinstance(value, Spec | Mapping) and not _holds_specs(value):
                yield (*before, name), info, value


def _holds_specs(value: Any) -> bool:
    return isinstance(value, tuple) and any(isinstance(entry, Spec) for entry in value)


def placed(spec: Spec, key: str) -> str:
    """A dotted key, with the name of the innermost entry of a list that it leads into: ``machine.chain[2]... (table)``."""
    here: Any = spec
    name = ""
    for step in split_dotted(key)[:-1]:
        here = here[step] if isinstance(step, int) else getattr(here, step, None)
        name = getattr(here, "name", name) if isinstance(step, int) else name
    return f"{key} ({name})" if name else key
