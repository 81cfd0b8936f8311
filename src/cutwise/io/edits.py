"""Changes written into the text of a scenario: exactly the characters of a value, and nothing that a person has laid out.

Where a value stands is known from the events of the YAML reader. A text that is laid out again by a writer loses line breaks,
quotes and aligned comments; one that is changed by place keeps everything else to the letter.
"""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path as File
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    CollectionEndEvent,
    DocumentStartEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceStartEvent,
)

from cutwise.io.scenario import parse
from cutwise.io.tree import compose
from cutwise.spec import fields
from cutwise.spec.base import Spec
from cutwise.spec.faults import Fault, Path, ScenarioFault, dotted, split_dotted
from cutwise.spec.scenario import Scenario

_WRAPPER = {"value", "status", "source", "library", "standard_error", "covariance"}
_PROPERTIES = re.compile(r"(?:[&!][^\s,\[\]{}]*\s+)*")  # anchor and tag before a value
_PLAIN_KEY = re.compile(r"[A-Za-z_][\w-]*|\d+")  # a number: of an entry of a list that a library gives
_STEP = 2  # blanks of a section inside of another


@dataclass(slots=True)
class _Place:
    """Where a value stands: first character, and the one behind its last."""

    kind: str  # scalar, map, list, alias
    start: int
    end: int
    column: int = 0  # of the first key of a map
    flow: bool = False
    keys: dict[str, tuple[int, int]] = field(default_factory=dict)  # where each key stands, and where it ends
    inside: list["_Place"] = field(default_factory=list)
    names: list[str] = field(default_factory=list)  # keys in the order of ``inside``

    def at(self, step: str | int) -> "_Place | None":
        """The value of a key, or an entry; None if there is none."""
        if self.kind == "map" and step in self.names:
            return self.inside[self.names.index(str(step))]
        if self.kind == "list" and isinstance(step, int) and step < len(self.inside):
            return self.inside[step]
        return None


class _Refused(Exception):
    """A change that cannot be written by place, and why."""


def with_edits(text: str, name: str, edits: Mapping[str, str], *, folder: File, title: str | None = None) -> str:
    """The text of a scenario with some values changed, so that it loads as it would with the same ``--set``.

    Parameters
    ----------
    text : str
        YAML or JSON, as in the file.
    name : str
        The file, for messages.
    edits : mapping
        Dotted keys with their values, as a file takes them: ``{"spindle.pressure": "4 bar"}``.
    folder : Path
        Where files that it names are looked for.
    title : str, optional
        Name of a scenario that says none.

    Raises
    ------
    ScenarioFault
        The values are refused, or cannot be written into this text; nothing is changed then.
    """
    wanted = parse(text, name, edits, folder=folder, title=title, named="{}")
    changed = edited(text, edits, type(wanted), is_json=name.lower().endswith(".json"))
    try:
        found = parse(changed, name, folder=folder, title=title)
    except ScenarioFault as fault:
        raise _not_by_place(edits, f"the file would be refused then ({fault.faults[0]})") from None
    if not _same(found, wanted):
        raise _not_by_place(edits, "the file would say something else then")
    return changed


def _not_by_place(edits: Mapping[str, str], why: str) -> ScenarioFault:
    keys = ", ".join(edits)
    return ScenarioFault([Fault((), f"cannot be changed by itself: {why}; change the file by hand", file=keys)])


def _same(one: Scenario, other: Scenario) -> bool:
    """Whether two scenarios say the same; where a value came from is not part of it."""
    return type(one) is type(other) and one.model_dump(mode="python") == other.model_dump(mode="python")


def edited(text: str, edits: Mapping[str, str], model: type[Spec], *, is_json: bool = False) -> str:
    """The text with some values changed by place; what it then means is not looked at.

    Raises
    ------
    ScenarioFault
        All changes that cannot be written.
    """
    faults = []
    for key, value in edits.items():
        path = split_dotted(key)
        try:
            if not path or dotted(path) != key:
                raise _Refused("is not of the form dotted.key")
            text = _changed(text, path, value.strip(), model, is_json)
        except _Refused as why:
            faults.append(Fault(path, f"{why}; change the file by hand"))
    if faults:
        raise ScenarioFault(faults)
    return text


def _changed(text: str, path: Path, value: str, model: type[Spec], is_json: bool) -> str:
    said, wrong = compose(value, "value")
    if wrong or said is None or said.value is None:
        raise _Refused("a value is needed; a key is taken away by deleting its line" if not wrong else wrong[0].message)
    root, before = _places(text), compose(text, "text")[0]
    if root is None or before is None:
        raise _Refused("the text is empty, or cannot be read as it stands")
    path = _as_written(root, path, model)
    real, place = _way(root, path)
    rest = path[len([step for step in real if step != _WRAPPED]) :]
    if place.kind == "scalar" and place.start < place.end and rest == ("file",):
        path, rest = path[:-1], ()  # ``program: a.nc`` is short for ``program: {file: a.nc}``
    tree_path = tuple("value" if step == _WRAPPED else step for step in real)
    expected = _put(before.plain(), tree_path, rest, said.plain())
    for written in _spellings(value, is_json):
        new = (
            _replaced(text, root, real, place, written)
            if not rest
            else _inserted(text, root, real, place, rest, written)
        )
        after, faults = compose(new, "text")
        if not faults and after is not None and after.plain() == expected:
            return new
    raise _Refused("the value cannot be written there without changing another one")


_WRAPPED = "\0value"  # a step into ``{value: ...}``, which is no key of the path


def _spellings(value: str, is_json: bool) -> Iterator[str]:
    """The value as it may be written: as it is; quoted where YAML would misread it."""
    one_line = " ".join(value.split())
    if not is_json:
        yield value if "\n" not in value else one_line
    said = compose(value, "value")[0]
    plain = said.plain() if said is not None else value
    yield json.dumps(plain, ensure_ascii=False)
    yield json.dumps(one_line, ensure_ascii=False)


def _put(plain: Any, path: Path, rest: Path, value: Any) -> Any:
    """The bare values with one replaced, or put in below what is there."""
    if path:
        step = path[0]
        copy: Any = list(plain) if isinstance(plain, list) else dict(plain)
        copy[step] = _put(plain[step], path[1:], rest, value)
        return copy
    for place, step in reversed(list(enumerate(rest))):
        inner = plain if place == 0 and isinstance(plain, dict) else {}
        value = {**inner, str(step): value}
    return value


# --- where things stand -------------------------------------------------------------------------------------------------
def _places(text: str) -> _Place | None:
    """The places of all values of a text; None if it holds none."""
    try:
        events = iter(list(YAML(typ="safe", pure=True).parse(text)))
    except (YAMLError, RecursionError, ValueError):
        return None
    for event in events:
        if isinstance(event, DocumentStartEvent):
            return _read(next(events), events)
    return None


def _read(event: Any, events: Iterator[Any]) -> _Place:
    start, end = event.start_mark.index, event.end_mark.index
    if isinstance(event, AliasEvent):
        return _Place("alias", start, end)
    if isinstance(event, ScalarEvent):
        return _Place("scalar", start, end)
    place = _Place("map" if isinstance(event, MappingStartEvent) else "list", start, end, flow=bool(event.flow_style))
    named = isinstance(event, MappingStartEvent)
    assert named or isinstance(event, SequenceStartEvent)
    while not isinstance(event := next(events), CollectionEndEvent):
        if named:
            if not place.names:
                place.column = event.start_mark.column
            key = str(event.value) if isinstance(event, ScalarEvent) else f"\0{len(place.names)}"
            if not isinstance(event, ScalarEvent):
                _read(event, events)
            place.keys[key] = (event.start_mark.index, event.end_mark.index)
            place.names.append(key)
            event = next(events)
        place.inside.append(_read(event, events))
    last = max(place.inside[-1].end, place.keys[place.names[-1]][1] + 1 if named else 0) if place.inside else end
    place.end = event.end_mark.index if place.flow else last
    if named and place.inside and place.inside[-1].kind == "scalar" and place.inside[-1].start == place.inside[-1].end:
        place.end = place.keys[place.names[-1]][1] + 1  # "key:" with nothing behind it
    return place


def _way(root: _Place, path: Path) -> tuple[Path, _Place]:
    """As much of a path as the text has, steps into ``{value: ...}`` included, and the place that it leads to."""
    here, real = root, ()  # type: tuple[_Place, Path]
    for step in (*path, None):
        if here.kind == "alias":
            raise _Refused("it stands behind an alias (*)")
        if here.kind == "map" and "value" in here.names and set(here.names) <= _WRAPPER and here.at(step or "") is None:
            inside = here.at("value")
            assert inside is not None
            here, real = inside, (*real, _WRAPPED)
        if step is None:
            break
        found = here.at(step)
        if found is None:
            break
        here, real = found, (*real, step)
    if here.kind == "alias":
        raise _Refused("it stands behind an alias (*)")
    return real, here


def _as_written(root: _Place, path: Path, model: type[Spec]) -> Path:
    """The path as the text says it: a key may stand in the section above the one that it belongs to."""
    if len(path) < 3 or len(_way(root, path)[0]) >= len(path):
        return path
    info = fields.field_at(model, path[:-2])
    above = (*path[:-2], path[-1])
    stands = any(section.stands_for.get(str(path[-1])) == path[-2] for section in (fields.inner(info) if info else ()))
    return above if stands and len(_way(root, above)[0]) >= len(above) else path


# --- what is written ----------------------------------------------------------------------------------------------------
def _replaced(text: str, root: _Place, real: Path, place: _Place, written: str) -> str:
    """The text with the characters of one value replaced."""
    start, end = place.start, place.end
    properties = _PROPERTIES.match(text, start)
    start = properties.end() if properties is not None and properties.end() <= end else start
    in_block = place.kind in ("map", "list") and not place.flow
    if (place.start == place.end or in_block or text[start : start + 1] in ("|", ">")) and real:
        owner = root
        for step in real[:-1]:
            owner = owner.at("value" if step == _WRAPPED else step) or owner
        name = "value" if real[-1] == _WRAPPED else real[-1]
        if isinstance(name, str) and name in owner.keys:
            start = text.index(":", owner.keys[name][1]) + 1
            if place.start == place.end:
                return f"{text[:start]} {written}{text[start:]}"
            tail = "\n" if text[end - 1] == "\n" else ""
            return f"{text[:start]} {written}{tail}{text[end:]}"
    return text[:start] + written + text[end:]


def _inserted(text: str, root: _Place, real: Path, place: _Place, rest: Path, written: str) -> str:
    """The text with a key put in that was not there, below the last section on its way that is."""
    if place.kind == "list":
        raise _Refused("there is no such entry")
    names = [str(step) if _PLAIN_KEY.fullmatch(str(step)) else json.dumps(str(step)) for step in rest]
    if place.kind == "map" and place.flow:
        return _in_braces(text, place, rest, written)
    line = "\r\n" if "\r\n" in text else "\n"
    if place.kind == "map":
        column, end = place.column, place.end
    elif place.kind == "scalar" and place.start == place.end and real:
        owner = root
        for step in real[:-1]:
            owner = owner.at(step) or owner
        if owner.flow:
            raise _Refused("the section stands in braces and is empty")
        column, end = owner.column + _STEP, owner.keys[str(real[-1])][1] + 1
    else:
        raise _Refused(f"{dotted(real) or 'the scenario'} is no section here")
    lines = line.join(f"{' ' * (column + _STEP * k)}{name}:" for k, name in enumerate(names)) + f" {written}"
    at = len(text) if place is root else _end_of_line(text, end)
    begin = "" if at == 0 or text[:at].endswith("\n") else line
    after = line if not begin or at == len(text) else ""
    return f"{text[:at]}{begin}{lines}{after}{text[at:]}"


def _end_of_line(text: str, place: int) -> int:
    """Behind the last character of a line, before its end; the beginning of the next one if it has just begun."""
    if place and text[place - 1] == "\n":
        return place
    end = text.find("\n", place)
    end = len(text) if end < 0 else end
    return end - 1 if end and text[end - 1 : end] == "\r" else end


def _in_braces(text: str, place: _Place, rest: Path, written: str) -> str:
    quoted = bool(place.keys) and text[next(iter(place.keys.values()))[0]] == '"'
    names = [json.dumps(str(s)) if quoted or not _PLAIN_KEY.fullmatch(str(s)) else str(s) for s in rest]
    inner = f"{names[-1]}: {written}"
    for name in reversed(names[:-1]):
        inner = f"{name}: {{{inner}}}"
    if not place.inside:
        return f"{text[: place.end - 1]}{inner}{text[place.end - 1 :]}"
    last = max(place.inside[-1].end, place.keys[place.names[-1]][1])
    return f"{text[:last]}, {inner}{text[last:]}"
