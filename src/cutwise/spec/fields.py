"""What the specification says about a key: its field, its dimension, its alternatives."""

from collections.abc import Iterator, Mapping, Sequence
from types import NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import Tag
from pydantic.fields import FieldInfo

from cutwise.spec.base import Quantity, Spec, Usual
from cutwise.spec.faults import Path


def tag(name: str) -> Tag:
    """Name of an alternative of a key; :func:`without_tags` knows it in the location of a pydantic error."""
    return Tag(f"<{name}>")


def without_tags(location: Sequence[str | int]) -> Path:
    """The path in the scenario of a pydantic error location."""
    return tuple(step for step in location if not (isinstance(step, str) and step.startswith("<")))


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
    """Dimension of a quantity field."""
    for _, metadata in of_field(info):
        for item in metadata:
            if isinstance(item, Quantity):
                return item.dimension
    return None


def usual(info: FieldInfo) -> Usual | None:
    """Usual range of a field."""
    for _, metadata in of_field(info):
        for item in metadata:
            if isinstance(item, Usual):
                return item
    return None


def field_at(model: type[Spec], path: Path) -> FieldInfo | None:
    """The field that a path names, looked up through every alternative."""
    if not path or not isinstance(path[0], str):
        return None
    info = model.model_fields.get(path[0])
    if info is None or len(path) == 1:
        return info
    for section in inner(info):
        rest = path[2:] if isinstance(path[1], int) else path[1:]
        found = field_at(section, rest)
        if found is not None:
            return found
    return None


def inner(info: FieldInfo) -> Iterator[type[Spec]]:
    """Specifications inside a field: its sections, or the entries of a list or mapping of sections."""
    for kind, metadata in of_field(info):
        if isinstance(kind, type) and issubclass(kind, Spec):
            yield kind
        elif get_origin(kind) in (tuple, list):
            for member, _ in alternatives(get_args(kind)[0], metadata):
                if isinstance(member, type) and issubclass(member, Spec):
                    yield member


def keys(model: type[Spec], before: Path = ()) -> Iterator[tuple[Path, FieldInfo]]:
    """Every key of a specification with its field, sections before what is in them."""
    for name, info in model.model_fields.items():
        yield (*before, name), info
        for section in sections(info):
            yield from keys(section, (*before, name))


def leaves(spec: Spec, before: Path = ()) -> Iterator[tuple[Path, FieldInfo, Any]]:
    """Every value of a specification that was given or has a default, with its field."""
    for name, info in type(spec).model_fields.items():
        value = getattr(spec, name)
        if isinstance(value, Spec):
            yield from leaves(value, (*before, name))
        elif value is not None and not isinstance(value, Mapping):
            yield (*before, name), info, value
