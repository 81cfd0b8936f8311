"""A scenario to begin with: every key that matters, with its meaning, and comments from the specification."""

import re
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from textwrap import wrap

from pydantic.fields import FieldInfo

from cutwise.io import library
from cutwise.io.tree import Node, as_one_line
from cutwise.spec import fields
from cutwise.spec.base import LibrarySpec, Spec
from cutwise.spec.faults import Fault, Path, ScenarioFault, dotted
from cutwise.spec.kinds import ALIASES, KINDS
from cutwise.spec.notices import range_text
from cutwise.spec.scenario import Scenario

_WIDTH = 110

_LEFT_OUT = ("library", "name", "process")


SCHEMAS = ".cutwise/schema"  # folder beside a scenario


def schema_line(kind: str) -> str:
    """The comment by which editors find the schema of a scenario."""
    return f"# yaml-language-server: $schema={SCHEMAS}/{kind}.json"


def template(kind: str, starts: Mapping[str, str] | None = None, *, name: str = "") -> str:
    """A commented scenario of a kind that loads without a fault.

    Parameters
    ----------
    kind : str
        The process.
    starts : mapping, optional
        Dotted keys with what is written for them; those of the process if left out.
    name : str
        Of the scenario.

    Raises
    ------
    ScenarioFault
        There is no such kind.
    """
    if kind not in KINDS:
        meant = ALIASES.get(kind) or next(iter(get_close_matches(kind, KINDS, n=1)), None)
        hint = f"did you mean {meant}?" if meant else f"known are: {', '.join(KINDS)}"
        raise ScenarioFault([Fault((), f'"{kind}" is not a process; {hint}')])
    model = KINDS[kind]
    begun = model.starts if starts is None else starts
    summary = (model.__doc__ or "").strip().splitlines()[0]
    lines = [
        f"# {summary}",
        "# Every quantity has its unit. A value may also be written {value: 80 mm/s, status: measured, source: ...}.",
        f"name: {name or f'new_{kind}'}",
        f"process: {kind}",
        *_body(model, (), begun),
        *_requirements(model, begun.get("requirements", "")),
    ]
    return "\n".join(lines) + "\n"


def _body(section: type[Spec], path: Path, starts: Mapping[str, str]) -> Iterator[str]:
    indent = "  " * len(path)
    for name, info in section.model_fields.items():
        if name in _LEFT_OUT or (name == "requirements" and not path):
            continue
        here = (*path, name)
        inner = fields.sections(info)
        begun = any(start.startswith(f"{dotted(here)}.") for start in starts)
        if inner and (begun or len(inner) == len(list(fields.of_field(info)))):  # of several kinds of section the first
            if _left_out(info, here, starts) and path and info.examples:
                yield from _value(info, here, starts)
                continue
            if _left_out(info, here, starts):
                yield from ("",) if not path else ()
                yield from comment(f"{name}: {{{', '.join(inner[0].model_fields)}}} ({info.description})", indent)
                continue
            yield "" if not path else f"{indent}# {info.description}"
            if not path:
                yield f"# {info.description}"
            yield f"{indent}{name}:"
            if issubclass(inner[0], LibrarySpec):
                yield from _from_library(inner[0], here, starts)
            else:
                yield from _body(inner[0], here, starts)
            continue
        yield from _value(info, here, starts)


def _left_out(info: FieldInfo, path: Path, starts: Mapping[str, str]) -> bool:
    """Whether a section may be missing and the start says nothing about it."""
    key = dotted(path)
    optional = not info.is_required() and info.default is None and info.default_factory is None
    return optional and not any(start == key or start.startswith(f"{key}.") for start in starts)


def _value(info: FieldInfo, path: Path, starts: Mapping[str, str]) -> Iterator[str]:
    """A line for a key, under a comment; keys that may be left out are commented out."""
    indent = "  " * (len(path) - 1)
    key = dotted(path)
    written = key in starts or info.is_required()
    yield from comment(_meaning(info), indent)
    yield f"{indent}{'' if written else '# '}{path[-1]}: {starts.get(key, _example(info))}"


def _meaning(info: FieldInfo) -> str:
    usual = fields.usual(info)
    return (info.description or "") + (f" (usual: {range_text(usual)})" if usual is not None else "")


def _example(info: FieldInfo) -> str:
    return str(info.examples[0]) if info.examples else "..."


def comment(text: str, indent: str) -> Iterator[str]:
    """Lines of a comment."""
    yield from wrap(text, _WIDTH, initial_indent=f"{indent}# ", subsequent_indent=f"{indent}#   ")


def _from_library(section: type[LibrarySpec], path: Path, starts: Mapping[str, str]) -> Iterator[str]:
    """A section that an entry fills; the keys that one may want to write are shown with the entry's values."""
    indent = "  " * len(path)
    entries = library.shelf(section.library_shelf)
    there = {name: entry for name, entry in entries.items() if _fits(set(entry.values.value), section)}
    name = starts.get(dotted((*path, "library")), next(iter(there), ""))
    yield f"{indent}# values from the library (a key written here wins); see: cutwise library {section.library_shelf}"
    yield from comment(f"there are: {', '.join(there)}", indent)
    if name in there:
        yield from comment(f"{name}: {there[name].describes}", indent)
    yield f"{indent}library: {name}"
    values = there[name].values.value if name in there else {}
    hidden = [key for key, node in values.items() if _has_sections(node)]
    if hidden:
        where = f"their values and the file to copy them from: cutwise library {section.library_shelf} {name}"
        yield from comment(f"of one's own, instead of library: {', '.join(hidden)}; {where}", indent)
    for key, info in section.model_fields.items():
        if key in values and not _has_sections(values[key]):
            brief = re.split(r"[:;(]", info.description or "")[0].strip()
            yield f"{indent}# {f'{key}: {as_one_line(values[key])}':<32} # {brief}"
        elif key not in _LEFT_OUT and dotted((*path, key)) in starts:
            yield from _value(info, (*path, key), starts)


def _fits(keys: set[str], section: type[LibrarySpec]) -> bool:
    """Whether a section knows all that an entry says, or is given all that it needs."""
    needed = {key for key, info in section.model_fields.items() if info.is_required()}
    return keys <= set(section.model_fields) or (bool(needed) and needed <= keys)


def _has_sections(node: Node) -> bool:
    return isinstance(node.value, dict) or (
        isinstance(node.value, list) and any(isinstance(item.value, dict) for item in node.value)
    )


def _requirements(model: type[Scenario], start: str) -> Iterator[str]:
    yield ""
    yield "# limits that the result is held against; measures that can be limited:"
    yield from comment(", ".join(model.measures), "")
    if start:
        yield f"requirements: {start}"
