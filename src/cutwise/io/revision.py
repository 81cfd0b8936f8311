"""A scenario with some of its values replaced, many times over: what sweeps, advice and sensitivities stand on.

The text of the scenario is taken apart once. A quantity that is there already is then replaced in the bare values and
the whole is checked again; anything else (a key that is new, a library entry, a file, a word) goes the way of a
``--set``. Both ways give the same scenario.
"""

import json
import re
from collections.abc import Callable, Mapping
from typing import Any

from pydantic import ValidationError

from cutwise import units
from cutwise.io.scenario import OVERRIDES, read_document
from cutwise.io.tree import from_data, unwrapped
from cutwise.spec import fields
from cutwise.spec.base import Spec
from cutwise.spec.faults import Fault, Path, ScenarioFault, dotted, split_dotted
from cutwise.spec.scenario import Origin, Scenario

Value = str | float | int | tuple[float, ...]
"""Text as in a scenario file; or a number in SI, or several."""

_PLAIN = re.compile(
    r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?( [A-Za-zµ°%][A-Za-z0-9µ°%/*^·]*( [A-Za-z][A-Za-z0-9/*^]*)*)?"
)
_DERIVES = ("solid", "urdf", "program", "columns")  # sections in which other values follow from what is written


def revisions(scenario: Scenario, named: str = OVERRIDES) -> Callable[[Mapping[str, Value]], Scenario]:
    """A function that gives the scenario with some values replaced, checked as a whole.

    Parameters
    ----------
    scenario : Scenario
        What all other values are taken from.
    named : str
        How a message names a value that is refused, with ``{}`` for its key.

    Returns
    -------
    callable
        From a mapping of dotted keys to values (text, or SI numbers) to a scenario. It raises ScenarioFault where the
        values do not fit the others.
    """
    document = scenario.document()
    plain = unwrapped(from_data(document, scenario.name), (), []).plain()
    quick = {dotted(path): path for path in _replaceable(scenario, plain)}
    model = type(scenario)

    def revised(values: Mapping[str, Value]) -> Scenario:
        if all(key in quick and _is_plain(value) for key, value in values.items()):
            bare, texts = plain, {}
            for key, value in values.items():
                info = fields.field_at(model, quick[key])
                assert info is not None
                written = _as_said(value, fields.dimension(info) or "dimensionless")
                bare = _with(bare, quick[key], written)
                texts[key] = f"[{', '.join(map(str, written))}]" if isinstance(written, list) else str(written)
            try:
                found = model.model_validate(bare)
            except ValidationError:
                found = None  # what is wrong is said below, at its place
            if found is not None:
                copy = scenario.model_copy(update={name: getattr(found, name) for name in found.model_fields_set})
                return copy.with_origins({**scenario.origins, **{k: Origin("user", text=t) for k, t in texts.items()}})
        return read_document(
            document, scenario.name, _texts(scenario, values, named), named=named, folder=scenario.folder
        )

    return revised


def with_values(scenario: Scenario, values: Mapping[str, Any]) -> Scenario:
    """The scenario with some values replaced by what could stand in its file: a number needs its unit there."""
    if not isinstance(values, Mapping):
        raise TypeError(
            f'expected dotted keys with their values, {{"operation.feed": "60 mm/s"}}; this is {values!r:.60}'
        )
    given = {str(key): value for key, value in values.items()}
    if all(isinstance(value, str) for value in given.values()):
        return revisions(scenario)(given)
    return read_document(scenario.document(), scenario.name, given, folder=scenario.folder)


def _replaceable(scenario: Scenario, plain: Any) -> list[Path]:
    """Quantities that are written, and from which nothing else in the tree follows."""
    sections = dict(fields.specs(scenario))
    derived = [path for path, spec in sections.items() if any(getattr(spec, name, None) for name in _DERIVES)]
    found = []
    for path, info, value in fields.leaves(scenario):
        owner, key = sections[path[:-1]], str(path[-1])
        if (
            _at(plain, path) is not None
            and fields.dimension(info)
            and _is_amount(value)
            and path[0] not in ("name", "process", "requirements")
            and dotted(path) in scenario.origins
            and not any(path[: len(before)] == before for before in derived if before or path[:-1] == before)
            and not _sets_others_aside(owner, key)
        ):
            found.append(path)
    return found


def _at(plain: Any, path: Path) -> Any:
    """What is written at a path; None if nothing is."""
    for step in path:
        try:
            plain = plain[step]
        except (KeyError, IndexError, TypeError):
            return None
    return plain


def _is_amount(value: Any) -> bool:
    return isinstance(value, float) or (isinstance(value, tuple) and all(isinstance(v, float) for v in value))


def _sets_others_aside(owner: Spec, key: str) -> bool:
    """Writing the key takes away another that says the same in different words."""
    for own, others in type(owner).instead.items():
        rivals = others if key == own else (own,) if key in others else ()
        if any(name in owner.model_fields_set and getattr(owner, name) is not None for name in rivals):
            return True
    groups = type(owner).either
    mine = [group for group in groups if key in group]
    return bool(mine) and any(name in owner.model_fields_set for group in groups if group not in mine for name in group)


def _is_plain(value: Value) -> bool:
    return not isinstance(value, str) or _PLAIN.fullmatch(value.strip()) is not None


def _as_said(value: Value, dimension: str) -> Any:
    """A value as a scenario has it: text with a unit; a bare number where there is none."""
    if isinstance(value, tuple):
        return [_as_said(entry, dimension) for entry in value]
    if isinstance(value, str):
        return float(value) if dimension == "dimensionless" and re.fullmatch(r"[-+.\deE]+", value) else value.strip()
    return float(value) if dimension == "dimensionless" else units.text(value, dimension)


def _with(plain: Any, path: Path, value: Any) -> Any:
    """The nested values with one replaced; what is not on the way is shared."""
    if not path:
        return value
    copy: Any = list(plain) if isinstance(plain, list) else dict(plain)
    copy[path[0]] = _with(plain[path[0]], path[1:], value)
    return copy


def _texts(scenario: Scenario, values: Mapping[str, Value], named: str) -> dict[str, str]:
    """Values as text; numbers get the unit of their key.

    Raises
    ------
    ScenarioFault
        A number for a key that is no quantity.
    """
    texts, faults = {}, []
    for key, value in values.items():
        if isinstance(value, str):
            texts[key] = value
            continue
        path = split_dotted(key)
        info = fields.field_at(type(scenario), path)
        dimension = fields.dimension(info) if info is not None else None
        nested = value is None or isinstance(value, bool | Mapping | list)
        if nested or (info is not None and dimension is None):
            texts[key] = json.dumps(value, ensure_ascii=False)  # which is YAML, capitals in units and titles kept
        elif dimension is None:
            faults.append(Fault((), "unknown key, or no quantity of this scenario", file=named.format(key)))
        elif isinstance(value, tuple):
            texts[key] = f"[{', '.join(units.text(entry, dimension) for entry in value)}]"
        else:
            texts[key] = units.text(value, dimension)
    if faults:
        raise ScenarioFault(faults)
    return texts
