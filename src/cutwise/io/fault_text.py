"""Faults in plain words: from what pydantic found to what the engineer has to change."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from difflib import get_close_matches
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import TypeAdapter, ValidationError
from pydantic.fields import FieldInfo

from cutwise import units
from cutwise.io import library
from cutwise.io.tree import LONGEST, Node
from cutwise.spec import fields
from cutwise.spec.base import LibrarySpec, Notice, Spec
from cutwise.spec.cell import ONE_CARRIER
from cutwise.spec.faults import Fault, Path, dotted
from cutwise.spec.scenario import Scenario

_BOUNDS = {
    "greater_than": ("gt", "above"),
    "greater_than_equal": ("ge", "at least"),
    "less_than": ("lt", "below"),
    "less_than_equal": ("le", "at most"),
}
_CARRIERS = ("robot", "machine")
_LONG_TEXT = 80  # letters of a value that a message repeats


def faults_of(error: ValidationError, model: type[Spec], root: Node) -> Iterator[Fault]:
    """Every fault of a scenario that did not validate, at its place in the tree as written."""
    suggested: set[Path] = set()
    found: list[tuple[Path, str, bool]] = []
    between: set[tuple[Path, str]] = set()  # faults of values that do not go together
    for item in _nearest_alternatives(error.errors()):
        path = fields.without_tags(item["loc"])
        kind, context = item["type"], item.get("ctx") or {}
        if kind == "contradiction":
            said = [_contradiction(notice, path, model) for notice in context["found"]]
            between |= {(where, message) for where, message, _ in said}
            found += said
        elif kind == "extra_forbidden":
            message, meant = unknown_key(model, path)
            suggested.add(meant)
            found.append((path, message, True))
        elif kind == "missing" and isinstance(path[-1], int):  # a list of a fixed length
            found.append((path[:-1], _too_few(model, path[:-1]), False))
        elif kind == "missing":
            found.append((path, _missing(model, path), True))
        else:
            found.append((path, _wrong_value(item, model, path, root), False))
    for path, message, at_key in dict.fromkeys(found):
        if not (path in suggested and message.startswith("missing")):  # the misspelled key says it already
            if (path, message) in between:
                yield _between(root, path, message, at_key)
            else:
                yield root.nearest(path).fault(path, message, at_key=at_key)


def _nearest_alternatives(items: Sequence[Any]) -> list[Any]:
    """The errors without those of alternatives of another kind, where one is only out of bounds: it was meant."""
    out_of_bounds = {fields.without_tags(item["loc"]) for item in items if item["type"] in _BOUNDS}
    return [
        item
        for item in items
        if item["type"] in _BOUNDS
        or item["type"] != "literal_error"
        or fields.without_tags(item["loc"]) not in out_of_bounds
    ]


def _between(root: Node, path: Path, message: str, at_key: bool) -> Fault:
    """A fault of values that do not go together, where the engineer wrote: an entry of the library is sound by itself."""
    node = root.nearest(path)
    section = root.nearest(path[:-1]) if path else node
    own = isinstance(section.value, dict) and any(
        below.layer > 0 for key, one in section.value.items() if key != "library" for _, below in one.walk()
    )
    if node.layer > 0 or not own:
        return node.fault(path, message, at_key=at_key)
    entry = f" {node.origin.library}" if node.origin is not None and node.origin.library else ""
    written = next((one for key, one in section.value.items() if key != "library" and one.layer > 0), section)
    return written.fault(path, f"{message} ({path[-1]} is that of the library entry{entry})", at_key=True)


def faults_among_sound_sections(
    error: ValidationError, model: type[Spec], root: Node, plain: Mapping[str, Any]
) -> Iterator[Fault]:
    """Contradictions among the sections that did validate: a fault in one section does not hide those of others."""
    failed = {str(place) for item in error.errors() for place in item["loc"][:1]}
    if not failed or not issubclass(model, Scenario):  # the contradictions are what failed
        return
    sections = {}
    for name, field in model.model_fields.items():
        if name not in failed:
            kind = Annotated[field.annotation, field]  # type: ignore[name-defined]
            given = plain[name] if name in plain else field.get_default(call_default_factory=True)
            sections[name] = TypeAdapter(kind).validate_python(given)
    if failed & set(_CARRIERS) and all(plain.get(name) is not None for name in _CARRIERS):
        yield _between(root, (_CARRIERS[0],), ONE_CARRIER, False)  # whatever else is wrong with one of them
    for notice in model.contradictions_among(sections):
        path, message, at_key = _contradiction(notice, (), model)
        yield _between(root, path, message, at_key)


def _contradiction(notice: Notice, before: Path, model: type[Spec]) -> tuple[Path, str, bool]:
    path = (*before, *notice.path)
    if notice.message == "missing":
        return path, _missing(model, path), True
    message = notice.message
    if message.startswith("missing;"):
        there = _entries_with(model, path)
        if there and not any(name in message for name in there):
            message += f"; {', '.join(there)} {'has' if len(there) == 1 else 'have'} it"
    return path, message, message.startswith(("missing", "unknown"))


def unknown_key(model: type[Spec], path: Path) -> tuple[str, Path]:
    """What to say about a key that is not known, and the path that was probably meant."""
    before, name = path[:-1], str(path[-1])
    reason = next((section.refused[name] for section in _holders(model, before) if name in section.refused), None)
    if reason is not None:
        return reason, ()
    siblings = list(_known(model, before))
    if name in siblings:
        return _of_another_kind(model, path), ()
    near = _closest(name, siblings)
    if near:
        return f"unknown key; did you mean {dotted((*before, near))}?", (*before, near)
    everywhere = [key for key, _ in fields.keys(model)]
    elsewhere = _closest(name, [str(key[-1]) for key in everywhere])
    for meant in (next((key for key in everywhere if key[-1] == word), None) for word in (name, elsewhere)):
        if meant is not None:
            return f"unknown key; did you mean {dotted(meant)}?", meant
    return f"unknown key; known here: {', '.join(siblings)}", ()


def _of_another_kind(model: type[Spec], path: Path) -> str:
    """What to say where a section can be written in several ways, and a key is of another one than what it stands beside."""
    before, name = path[:-1], str(path[-1])
    ways = [list(section.model_fields) for section in _holders(model, before)]
    own = [key for way in ways if name in way for key in way]
    others = dict.fromkeys(key for way in ways if name not in way for key in way if key not in own)
    if not others:
        return f"does not go together with the other keys of {dotted(before)}"
    named = [*list(others)[:4], *(["..."] if len(others) > 4 else [])]
    return f"does not go together with {', '.join(named)} of {dotted(before)}: write one or the other"


def _entries_with(model: type[Spec], path: Path) -> list[str]:
    """Entries of the library that have a key which a section of theirs lacks."""
    owner = fields.field_at(model, path[:-1]) if len(path) > 1 else None
    section = next(fields.inner(owner), None) if owner is not None else None
    if section is None or not issubclass(section, LibrarySpec):
        return []
    shelf = library.shelf(section.library_shelf)
    return [name for name, entry in shelf.items() if str(path[-1]) in entry.values.value]


def _closest(name: str, names: list[str]) -> str | None:
    folded = {known.casefold(): known for known in reversed(names)}
    near = get_close_matches(name.casefold(), folded, n=1, cutoff=0.65)
    return folded[near[0]] if near else None


def _known(model: type[Spec], path: Path) -> Iterator[str]:
    """Keys that may stand at a path."""
    for section in _holders(model, path):
        yield from section.model_fields


def _holders(model: type[Spec], path: Path) -> Iterator[type[Spec]]:
    """The sections that may stand at a path."""
    if not path:
        yield model
        return
    info = fields.field_at(model, path)
    yield from fields.inner(info) if info is not None else ()


def _missing(model: type[Spec], path: Path) -> str:
    info = fields.field_at(model, path)
    sections = fields.sections(info) if info is not None else []
    if sections:
        required = [key for section in sections for key, field in section.model_fields.items() if field.is_required()]
        message = f"missing; write the section {path[-1]} with {', '.join(required) or 'its keys'}"
    else:
        message = f"missing; write it, for example {path[-1]}: {example(info)}"
    if not sections:
        there = _entries_with(model, path)
    else:
        there = list(library.shelf(sections[0].library_shelf)) if issubclass(sections[0], LibrarySpec) else []
    if there:
        key = path if sections else path[:-1]
        message += f"; or name a library entry with {dotted((*key, 'library'))}: {', '.join(there)}"
    return message


def _entry_meant(text: str, info: FieldInfo | None, path: Path) -> str | None:
    """What to write where the name of a library entry stands for a section; None if it is no such name."""
    for section in fields.inner(info) if info is not None else ():
        if issubclass(section, LibrarySpec) and text in library.names(section.library_shelf):
            return f'is a section; to take the library entry "{text}", write {path[-1]}: {{library: {text}}}'
    return None


def _too_few(model: type[Spec], path: Path) -> str:
    return f"has too few entries; write for example {path[-1]}: {example(fields.field_at(model, path))}"


def example(info: FieldInfo | None) -> str:
    """An example of the value of a field, as it would be written."""
    if info is None or not info.examples:
        return "..."
    first = info.examples[0]
    return str(first)


def _wrong_value(item: Any, model: type[Spec], path: Path, root: Node) -> str:
    kind, context = item["type"], item.get("ctx") or {}
    node = root.at(path)
    info = fields.field_at(model, path)
    text = _as_written(node, item["input"])
    if node is not None and node.value is None:
        return f"has no value; write it, for example {path[-1]}: {example(info)}"
    if kind in ("quantity", "direction"):
        return str(item["msg"])
    if kind in _BOUNDS:
        name, words = _BOUNDS[kind]
        return f"{text} is impossible; it must be {words} {_bound(context[name], info)}"
    if kind == "literal_error":
        if taken := _entry_meant(text, info, path):
            return taken
        options = _options(info)
        near = get_close_matches(text, options, n=1)
        return f'"{text}" is not one of {", ".join(options)}' + (f"; did you mean {near[0]}?" if near else "")
    if kind.startswith("int"):
        if isinstance(item["input"], float) and abs(item["input"]) >= 10.0**LONGEST:  # as the reader gives long ones
            return f"{text} is too long; a whole number has at most {LONGEST} digits"
        return f"{text} is not a whole number; write for example {path[-1]}: {example(info)}"
    if kind in ("model_type", "dict_type", "model_attributes_type"):
        if taken := _entry_meant(text, info, path):
            return taken
        keys = ", ".join(_known(model, path))
        return f'expected a section{" with " + keys if keys else ""}, found "{text}"'
    if (
        kind in ("tuple_type", "list_type")
        and node is not None
        and isinstance(node.value, dict)
        and _numbers(node.value)
    ):
        return f"has no entry {next(iter(node.value))}; they are counted from 0"
    if kind in ("tuple_type", "list_type"):
        return f'expected a list, found "{text}"; write for example {path[-1]}: {example(info)}'
    if kind == "string_type":
        return f"expected text, for example {path[-1]}: {example(info)}"
    if kind == "string_pattern_mismatch":
        rule = (
            "leave out / and \\ and line ends"
            if "/" in context["pattern"]
            else "use letters, digits and _, a letter first"
        )
        return f'"{text}" is not allowed; {rule}'
    if kind == "too_short":
        return _too_few(model, path)
    if kind == "too_long":
        return f"has too many entries; write for example {path[-1]}: {example(info)}"
    if kind.startswith("bool"):
        return f"{text} is neither true nor false"
    if kind.startswith("float"):
        return f"{text} is not a number; write for example {path[-1]}: {example(info)}"
    return f"{text}: {item['msg']}" if text else str(item["msg"])


def _numbers(keys: Collection[str]) -> bool:
    """Whether keys are those of entries that a list does not have."""
    return bool(keys) and all(key.isdigit() for key in keys)


def _as_written(node: Node | None, value: Any) -> str:
    if node is not None and not isinstance(node.value, dict | list):
        return node.text if len(node.text) <= _LONG_TEXT else f"{node.text[:_LONG_TEXT]}..."
    return str(value) if not isinstance(value, dict | list) else "a section" if isinstance(value, dict) else "a list"


def _bound(bound: float, info: FieldInfo | None) -> str:
    dimension = fields.dimension(info) if info is not None else None
    return units.show(bound, dimension) if dimension else f"{bound:g}"


def _options(info: FieldInfo | None) -> list[str]:
    kinds = [kind for kind, _ in fields.of_field(info)] if info is not None else []
    kinds += [entry for kind in kinds for entry, _ in fields.of_entries(kind)]
    return [str(option) for kind in kinds if get_origin(kind) is Literal for option in get_args(kind)]
