"""From a scenario file to a checked, frozen scenario that knows where each of its values came from."""

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from cutwise.io.assembly import OVERRIDE, Assembly
from cutwise.io.documents import document_of_report, document_of_run
from cutwise.io.fault_text import faults_among_sound_sections, faults_of
from cutwise.io.files import as_text, read_bytes
from cutwise.io.processes import model_of, process_named
from cutwise.io.python_values import said
from cutwise.io.scatter import scatter_faults, with_covariances
from cutwise.io.slots import with_slots
from cutwise.io.tree import Node, compose, from_data, hidden_letters, origins, placed, too_short, unwrapped
from cutwise.run_file import is_netcdf
from cutwise.spec import fields
from cutwise.spec.base import Spec
from cutwise.spec.faults import Fault, ScenarioFault, dotted, split_dotted
from cutwise.spec.kinds import KINDS
from cutwise.spec.scenario import Origin, Scenario
from cutwise.spec.texts import HALF, visible

Read = TypeVar("Read", bound=Spec)

_UNNAMED = ("name", "process", "covariances", "measured")  # not values with an origin

_DEEPEST = 50  # steps of a dotted key; scenarios have up to 8
OVERRIDES = 'overrides["{}"]'
"""How a message names an override in Python; the command line says ``--set``."""

Overrides = Sequence[str] | Mapping[str, Any]
"""Values that replace those of a file: ``key=value`` texts, or a mapping of dotted keys."""


def load(
    source: str | Path | Mapping[str, Any], overrides: Overrides | None = None, *, named: str = OVERRIDES
) -> Scenario:
    """The scenario of a YAML or JSON file, of a run file (``.nc``), of an HTML report, or of a mapping.

    Parameters
    ----------
    source : str, Path or mapping
        The file; or what would stand in it, files that it names then being looked for where Python runs.
    overrides : mapping or sequence of str
        Values that replace those of the file: dotted keys with their values as in the file, for example
        ``{"operation.feed": "60 mm/s"}``; or texts ``dotted.key=value`` with the value in YAML.
    named : str
        How messages name an override, with ``{}`` for its key.

    Raises
    ------
    ScenarioFault
        With everything that is wrong, each fault with its place.
    TypeError
        The source is nothing of the kind.
    """
    if not isinstance(source, str | os.PathLike | Mapping):
        raise TypeError(f"a scenario is a path, a mapping, or what load gave; this is {_short(source)}")
    given = () if overrides is None else overrides
    if isinstance(source, Mapping):
        return read_document(said(source, "scenario"), "scenario", given, named=named)
    return loaded(read_bytes(Path(source), str(source)), Path(source), given, named=named)


def _short(given: object) -> str:
    """A value as it is told: what it is, where its text is long."""
    text = repr(given)
    return text if len(text) <= 60 and "\n" not in text else f"a {type(given).__name__}"


def loaded(content: bytes, path: Path, overrides: Overrides = (), *, named: str = OVERRIDES) -> Scenario:
    """As :func:`load`, of what the file holds."""
    shown = str(path)
    if is_netcdf(content):
        return read_document(document_of_run(content, shown), shown, overrides, named=named)
    if path.suffix.lower() in (".html", ".htm"):
        return read_document(document_of_report(as_text(content, shown), shown), shown, overrides, named=named)
    return parse(
        as_text(content, shown),
        shown,
        overrides,
        folder=path.parent,
        title=visible(path.stem, lines=False),
        named=named,
    )


def parse(
    text: str,
    name: str = "scenario",
    overrides: Overrides = (),
    *,
    folder: Path | None = None,
    title: str | None = None,
    named: str = OVERRIDES,
) -> Scenario:
    """The scenario that a YAML or JSON text says; ``name`` stands for the file in messages."""
    tree, faults = compose(text, name)
    if tree is None or not isinstance(tree.value, dict):
        if not faults:
            empty = tree is None or tree.value is None
            found = "is empty" if empty else "is a list" if isinstance(tree.value, list) else "is a single value"  # type: ignore[union-attr]
            message = f"{found}; a scenario has sections, start with: cutwise new {'|'.join(KINDS)}"
            faults.append(Fault((), message, file=name))
        raise ScenarioFault(faults)
    return _scenario(tree, faults, overrides, folder or Path(), title, named)


def read_document(
    document: Any, name: str = "scenario", overrides: Overrides = (), *, named: str = OVERRIDES, folder: str = ""
) -> Scenario:
    """The scenario that :meth:`Scenario.document` wrote, with some values replaced."""
    if not isinstance(document, Mapping):
        raise ScenarioFault([Fault((), "holds no scenario", file=name)])
    return _scenario(from_data(dict(document), name), [], overrides, Path(folder), None, named)


def revised(scenario: Scenario, overrides: Overrides) -> Scenario:
    """The scenario with some values replaced, checked again as a whole; many times over: :mod:`cutwise.io.revision`."""
    return read_document(scenario.document(), scenario.name, overrides)


def _scenario(
    tree: Node, faults: list[Fault], overrides: Overrides, folder: Path, title: str | None, named: str
) -> Scenario:
    """Put the layers together (library, file, overrides), check everything, and make the scenario."""
    faults += hidden_letters(tree)
    tree = unwrapped(tree, (), faults)
    for key, value in _pairs(overrides, faults, named):
        tree = _overridden(tree, key, value, faults, named.format(key))
    if any(HALF in fault.message for fault in faults):  # no library takes such a text any further
        raise ScenarioFault(_sorted(faults))
    model = model_of(tree, faults)
    if model is None:
        raise ScenarioFault(_sorted(faults))
    tree = with_slots(process_named(tree, model, title), model)
    scenario, tree, files = _checked(tree, model, folder, faults)
    return scenario.with_files(files, str(folder)).with_origins(
        {dotted(path): origin for path, origin in origins(tree) if path[0] not in _UNNAMED and path[-1] != "library"}
    )


def settings(model: type[Read], overrides: Overrides, *, named: str = OVERRIDES) -> tuple[Read, dict[str, Origin]]:
    """Settings that stand in no file, from dotted keys alone, with library entries read in; and their origins.

    Raises
    ------
    ScenarioFault
        With everything that is wrong.
    """
    faults: list[Fault] = []
    tree = Node({}, layer=OVERRIDE)
    for key, value in _pairs(overrides, faults, named):
        tree = _overridden(tree, key, value, faults, named.format(key))
    read, tree, _ = _checked(tree, model, Path(), faults)
    return read, {dotted(path): origin for path, origin in origins(tree)}


def _checked(tree: Node, model: type[Read], folder: Path, faults: list[Fault]) -> tuple[Read, Node, list[str]]:
    """The tree completed from outside of it and validated: the model, the tree, and the files that were read."""
    tree = _without_displaced(tree, model)
    assembly = Assembly(model, folder, faults)
    tree = assembly.complete(tree, model, ())
    tree = _without_displaced(tree, model)
    faults += scatter_faults(tree, model)
    tree = with_covariances(tree, model, assembly.sources, faults)
    plain = tree.plain()
    try:
        read = model.model_validate(plain)
    except ValidationError as error:
        settled = [fault.path for fault in faults if fault.path]
        faults += [
            fault
            for fault in (*faults_of(error, model, tree), *faults_among_sound_sections(error, model, tree, plain))
            if not any(fault.path[: len(path)] == path for path in settled)
            and not (fault.message.startswith("missing") and assembly.explains(fault.path))
        ]
        raise ScenarioFault(_sorted(faults)) from None
    if faults:
        raise ScenarioFault(_sorted(faults))
    return read, tree, assembly.files


def _sorted(faults: Sequence[Fault]) -> list[Fault]:
    """By file, in the order of its lines; each fault once."""
    files = {fault.file: place for place, fault in reversed(list(enumerate(faults)))}
    return sorted(dict.fromkeys(faults), key=lambda fault: (files[fault.file], fault.line or 0, fault.column or 0))


def _pairs(overrides: Overrides, faults: list[Fault], named: str) -> Iterator[tuple[str, Any]]:
    """Overrides as dotted keys and values; what is not of that form is a fault."""
    if isinstance(overrides, str):
        overrides = [overrides]
    given = overrides.items() if isinstance(overrides, Mapping) else (text.partition("=")[::2] for text in overrides)
    texts = [f"{key}={value}" for key, value in overrides.items()] if isinstance(overrides, Mapping) else overrides
    for (key, value), text in zip(given, texts, strict=True):
        key = str(key).strip()
        path = split_dotted(key)
        if "=" not in text or not path or dotted(path) != key:
            faults.append(Fault((), "is not of the form dotted.key=value", file=named.format(text)))
        elif len(path) > _DEEPEST:
            faults.append(Fault((), "nested too deeply to be a key of a scenario", file=named.format(f"{key[:40]}…")))
        else:
            yield key, value


def _overridden(tree: Node, key: str, given: Any, faults: list[Fault], file: str) -> Node:
    """The tree with the value of one dotted key put in; ``file``: how messages name it."""
    path = split_dotted(key)
    value: Node | None
    if isinstance(given, str):
        # a selector that says not begins as a tag of YAML does
        value, found = compose(json.dumps(given.strip()) if given.lstrip().startswith("!") else given, file, OVERRIDE)
        if found:
            faults += [Fault(path, fault.message, file=file) for fault in found]
            return tree
    else:
        try:
            value, found = from_data(said(given, file), file, OVERRIDE), []
        except ScenarioFault as fault:
            faults += fault.faults
            return tree
    short = too_short(tree, path)
    if short is not None:
        faults.append(
            Fault((), f"there is no such entry: {dotted(short[0])} has {short[1]}, counted from 0", file=file)
        )
        return tree
    value = value or Node(None, file=file, layer=OVERRIDE)
    found += hidden_letters(value, path)
    value = unwrapped(value, path, found)
    faults += found
    for _, node in value.walk():
        node.line = node.column = node.key_line = node.key_column = None
    return placed(tree, path, value)


def _without_displaced(node: Node, model: type[Spec]) -> Node:
    """Leave out the keys that a stronger layer has said in other words (``Spec.either``)."""
    if not isinstance(node.value, dict):
        return node
    value = dict(node.value)
    said = [max((value[key].layer for key in group if key in value), default=-1) for group in model.either]
    for place, group in enumerate(model.either):
        stronger = max(said[:place] + said[place + 1 :])
        for key in group:
            if key in value and value[key].layer < stronger:
                del value[key]
    for key, others in model.instead.items():
        there = [other for other in others if other in value]
        if key in value and there:
            own, strongest = value[key].layer, max(value[other].layer for other in there)
            for other in there if own > strongest else [key] if own < strongest else []:
                del value[other]
    for name, info in model.model_fields.items():
        for section in fields.inner(info):
            if name not in value:
                continue
            below = value[name]
            if isinstance(below.value, list):
                value[name] = replace(below, value=[_without_displaced(item, section) for item in below.value])
            else:
                value[name] = _without_displaced(below, section)
    return replace(node, value=value)
