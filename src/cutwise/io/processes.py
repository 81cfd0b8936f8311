"""Which process a scenario is about."""

from dataclasses import replace
from difflib import get_close_matches
from typing import get_args

from cutwise.io.slots import processes_named
from cutwise.io.tree import Node, from_data
from cutwise.spec import fields
from cutwise.spec.faults import Fault
from cutwise.spec.kinds import ALIASES, KINDS
from cutwise.spec.scenario import Scenario


def model_of(tree: Node, faults: list[Fault]) -> type[Scenario] | None:
    """The specification that ``process`` names or means, or the one that the keys fit best."""
    node = tree.value.get("process")
    if node is not None and node.value is not None:
        if node.text in KINDS:
            return KINDS[node.text]
        word = node.text.lower()
        meant = ALIASES.get(word) or next(iter(get_close_matches(word, KINDS, n=1)), None)
        hint = f"did you mean {meant}?" if meant else f"known are: {', '.join(KINDS)}"
        faults.append(node.fault(("process",), f'"{node.text}" is not a process; {hint}'))
        if meant:
            return KINDS[meant]  # to find what else is wrong
    named = processes_named(tree)
    if node is None and len(named) == 1:
        return KINDS[named[0]]
    fit = {name: _fit(tree, model) for name, model in KINDS.items() if name in (named or KINDS)}
    best = [name for name, score in fit.items() if score == max(fit.values()) and score > 0]
    if len(best) == 1:
        return KINDS[best[0]]
    if node is None or node.value is None:
        message = f"missing; write which operation this is: process: {' or '.join(best or KINDS)}"
        faults.append(tree.fault(("process",), message))
    return None


def _fit(tree: Node, model: type[Scenario]) -> int:
    """How many keys of the tree a process knows, sections and what is in them."""
    known = {path for path, _ in fields.keys(model) if len(path) <= 2}
    return sum(path in known for path, _ in tree.walk() if 1 <= len(path) <= 2 and path[0] not in Scenario.model_fields)


def process_named(tree: Node, model: type[Scenario], title: str | None) -> Node:
    """The tree with its process, and with a name from the file if it has none."""
    (kind,) = get_args(model.model_fields["process"].annotation)
    value = {**tree.value, "process": from_data(kind, tree.file)}
    if "name" not in value and title:
        value["name"] = from_data(title, tree.file)
    name = value.get("name")
    if name is not None and name.value is not None and not isinstance(name.value, dict | list):
        value["name"] = replace(name, value=name.text)  # 2024 is a name too
    return replace(tree, value=value)
