"""A scenario as it was written: a tree of nodes that know their place, before it is checked against a specification."""

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, get_args

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, ScalarNode, SequenceNode

from cutwise.spec.base import Status
from cutwise.spec.faults import Fault, Path
from cutwise.spec.scenario import Origin
from cutwise.spec.texts import hidden_fault

STATUSES = get_args(Status)
_TAG = "tag:yaml.org,2002:"
_WRAPPER = ("value", "status", "source", "library")
_SCATTER = ("standard_error", "covariance")  # beside a measured value
_SECTION_WITH_VALUE = "motion"  # key of a section that has a key of its own called value
_MOST_NODES = 500_000
_LONGEST_TEXT, _MOST_MARKS = 5_000_000, 200_000  # letters, and signs between values: about 8 CPU s of reading
LONGEST = 18  # digits of an integer; longer ones are read as floating point numbers


@dataclass(slots=True)
class Node:
    """A value as written: a scalar, a dict or a list of nodes; with its place and, where it said so, its origin."""

    value: Any
    text: str = ""
    file: str = ""
    line: int | None = None
    column: int | None = None
    key_line: int | None = None
    key_column: int | None = None
    layer: int = 1  # 0 library entry, 1 scenario, 2 --set: the higher one wins
    origin: Origin | None = None
    scatter: "Node | None" = None  # standard errors, in the form of the value

    def fault(self, path: Path, message: str, *, at_key: bool = False) -> Fault:
        """A fault at this node, or at the key that names it."""
        if at_key and self.key_line is not None:
            return Fault(path, message, self.key_line, self.key_column, self.file)
        return Fault(path, message, self.line, self.column, self.file)

    def at(self, path: Path) -> "Node | None":
        """The node at a path below this one."""
        node = self
        for step in path:
            try:
                node = node.value[step]
            except (KeyError, IndexError, TypeError):
                return None
        return node

    def nearest(self, path: Path) -> "Node":
        """The node at a path, or the deepest one on the way to it."""
        return next(node for end in range(len(path), -1, -1) if (node := self.at(path[:end])) is not None)

    def plain(self) -> Any:
        """The bare values."""
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, list):
            return [node.plain() for node in self.value]
        return self.value

    def walk(self, before: Path = ()) -> Iterator[tuple[Path, "Node"]]:
        """This node and all below it."""
        yield before, self
        if isinstance(self.value, dict | list):
            for step, node in self.value.items() if isinstance(self.value, dict) else enumerate(self.value):
                yield from node.walk((*before, step))


def from_data(data: Any, file: str, layer: int = 1) -> Node:
    """Nodes of plain values that have no place in a text."""
    if isinstance(data, dict):
        return Node({str(k): from_data(v, file, layer) for k, v in data.items()}, file=file, layer=layer)
    if isinstance(data, list | tuple):
        return Node([from_data(v, file, layer) for v in data], file=file, layer=layer)
    if isinstance(data, int) and not -(10**LONGEST) < data < 10**LONGEST:
        return Node(math.inf if data > 0 else -math.inf, f"an integer of {data.bit_length()} bits", file, layer=layer)
    return Node(data, _written(data), file, layer=layer)


def _written(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value) if value is not None else ""


class _Reader:
    """Turns composed YAML nodes into ours; collects what is wrong instead of stopping at it."""

    def __init__(self, file: str, layer: int) -> None:
        self.file, self.layer = file, layer
        self.faults: list[Fault] = []
        self.open: set[int] = set()
        self.count = 0

    def read(self, node: Any, path: Path) -> Node:
        line, column = node.start_mark.line + 1, node.start_mark.column + 1
        ours = Node(None, "", self.file, line, column, layer=self.layer)
        self.count += 1
        if id(node) in self.open:
            self.faults.append(ours.fault(path, "this alias (*) stands inside of what it names, which has no end"))
            return ours
        if self.count > _MOST_NODES:
            raise OverflowError
        self.open.add(id(node))
        self._fill(ours, node, path)
        self.open.discard(id(node))
        return ours

    def _fill(self, ours: Node, node: Any, path: Path) -> None:
        if isinstance(node, ScalarNode):
            folded = node.style in ("|", ">") and not _has_lines(path)  # its line ends are layout
            ours.text = " ".join(node.value.split()) if folded else node.value
            try:
                ours.value = _scalar(str(node.tag), ours.text)
            except ValueError:
                tag = str(node.tag).replace(_TAG, "!!")
                self.faults.append(
                    ours.fault(
                        path,
                        f'the tag {tag} is not understood; leave it out, or quote a text that begins so: "{tag} ..."',
                    )
                )
        elif isinstance(node, SequenceNode):
            ours.value = [self.read(item, (*path, place)) for place, item in enumerate(node.value)]
        elif isinstance(node, MappingNode):
            ours.value = self._mapping(node, path)

    def _mapping(self, node: MappingNode, path: Path) -> dict[str, Node]:
        mapping: dict[str, Node] = {}
        for key, item in node.value:
            line, column = key.start_mark.line + 1, key.start_mark.column + 1
            if not isinstance(key, ScalarNode) or str(key.tag) == _TAG + "merge":
                message = (
                    "a key must be a plain word" if not isinstance(key, ScalarNode) else "<< is not understood here"
                )
                self.faults.append(Fault(path, message, line, column, self.file))
                continue
            here = (*path, key.value)
            value = self.read(item, here)
            value.key_line, value.key_column = line, column
            if key.value in mapping:
                first = mapping[key.value]
                self.faults.append(
                    Fault(here, f"written twice, first in line {first.key_line}; keep one", line, column, self.file)
                )
                continue
            mapping[key.value] = value
        return mapping


def _scalar(tag: str, text: str) -> Any:
    """Value of a YAML 1.2 scalar."""
    kind = tag.removeprefix(_TAG)
    if kind == "int":
        digits = text.replace("_", "")
        if len(digits) > LONGEST:
            return float(digits) if digits.lstrip("+-").isdecimal() else math.inf
        return int(digits, 0) if digits.lstrip("+-")[:2].lower() in ("0x", "0o", "0b") else int(digits, 10)
    if kind == "float":
        return float(text.replace("_", "").replace(".inf", "inf").replace(".nan", "nan").replace(".Inf", "inf"))
    if kind == "bool":
        return text.lower() == "true"
    if kind == "null":
        return None
    if kind in ("str", "timestamp"):
        return text
    raise ValueError(tag)


def compose(text: str, file: str, layer: int = 1) -> tuple[Node | None, list[Fault]]:
    """The tree of a YAML 1.2 (or JSON) text and what is wrong with it; None for an empty or unreadable text."""
    marks = sum(map(text.count, ",:[{\n"))
    if len(text) > _LONGEST_TEXT or marks > _MOST_MARKS:
        message = (
            f"is too large for a scenario ({len(text) / 1e6:.1f} MB, about {marks:,} values): write tables (CSV) and "
            "programs into files of their own and name them"
        )
        return None, [Fault((), message, file=file)]
    yaml = YAML(typ="safe", pure=True)
    try:
        composed = yaml.compose(text)
        if composed is None:
            return None, []
        reader = _Reader(file, layer)
        return reader.read(composed, ()), reader.faults
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark is not None else (None, None)
        return None, [Fault((), _in_words(error), line, column, file)]
    except YAMLError as error:
        return None, [Fault((), f"not readable as YAML: {str(error).splitlines()[0]}", file=file)]
    except RecursionError:
        return None, [Fault((), "nested too deeply to be a scenario", file=file)]
    except OverflowError:
        return None, [Fault((), f"too large: more than {_MOST_NODES:,} values; aliases (*) that multiply?", file=file)]
    except ValueError as error:  # digits beyond Python's limit for integers
        return None, [Fault((), f"not readable as YAML: {error}", file=file)]


def _in_words(error: MarkedYAMLError) -> str:
    problem = str(error.problem or error.context or error).strip()
    if "\\t" in problem or "'\t'" in problem:
        return "not YAML: a tab; indent with blanks"
    if "mapping values are not allowed" in problem:
        return "not YAML: a colon where none can be; is the indentation right, or does a text need quotes?"
    if "expected a single document" in str(error.context or "") + problem:
        return "not one YAML document: a second one begins here (---); keep one scenario in a file"
    if "could not find expected ':'" in problem:
        return "not YAML: a key without a colon; write key: value"
    if "undefined alias" in problem:
        return f"not YAML: {problem}; an alias (*) needs its anchor (&) above it, a text with a star needs quotes"
    if "quoted scalar" in str(error.context):
        return "not YAML: a quote that is opened before here is not closed"
    if "flow" in str(error.context):
        return f"not YAML: a bracket that is opened before here is not closed ({problem})"
    return f"not YAML: {problem}"


_WITH_LINES = ("text", "subroutines")  # of a program


def _has_lines(path: Path) -> bool:
    return any(step in _WITH_LINES for step in path)


def hidden_letters(node: Node, before: Path = ()) -> list[Fault]:
    """Texts and keys that hold control characters: names, sources and titles stand in programs, tables and reports."""
    faults = []
    for path, one in node.walk(before):
        key = hidden_fault(path[-1]) if path and isinstance(path[-1], str) else None
        if key is not None:
            faults.append(one.fault(path[:-1], f"a key {key}", at_key=True))
        text = one.value if isinstance(one.value, str) else ""
        fault = hidden_fault(text, lines=_has_lines(path))
        if fault is not None:
            faults.append(one.fault(path, fault))
    return faults


def unwrapped(node: Node, path: Path, faults: list[Fault]) -> Node:
    """The tree with every ``{value, status, source}`` replaced by its value, which remembers its origin."""
    if isinstance(node.value, list):
        return replace(node, value=[unwrapped(item, (*path, i), faults) for i, item in enumerate(node.value)])
    if not isinstance(node.value, dict):
        return node
    if "value" not in node.value or _SECTION_WITH_VALUE in node.value:
        return replace(node, value={key: unwrapped(item, (*path, key), faults) for key, item in node.value.items()})
    for key in node.value:
        if key not in (*_WRAPPER, *_SCATTER):
            message = "unknown key beside value; known are value, status, source, standard_error and covariance"
            message += " (a unit stands in the value)"
            faults.append(node.value[key].fault((*path, key), message, at_key=True))
    inner = unwrapped(node.value["value"], path, faults)
    said = {key: node.value[key].text for key in _WRAPPER[1:] if key in node.value}
    status = said.get("status", "user")
    if status not in STATUSES:
        faults.append(node.value["status"].fault((*path, "status"), f'"{status}" is not one of {", ".join(STATUSES)}'))
        status = "user"
    origin = Origin(status, said.get("source", ""), library=said.get("library", ""))
    scatter = node.value.get("standard_error")
    return replace(inner, key_line=node.key_line, key_column=node.key_column, origin=origin, scatter=scatter)


def merged(weak: Node, strong: Node) -> Node:
    """Both trees in one; where both say something, the strong one wins. Tables are taken whole.

    Entries of a list are replaced one by one where the strong tree names them by number (``chain[2].weight``).
    """
    if isinstance(weak.value, list) and isinstance(strong.value, dict) and strong.value:
        numbers = [int(key) if key.isdigit() else -1 for key in strong.value]
        if all(0 <= number < len(weak.value) for number in numbers):
            items = list(weak.value)
            for number, node in zip(numbers, strong.value.values(), strict=True):
                items[number] = merged(items[number], node)
            return replace(weak, value=items)
    if not (isinstance(weak.value, dict) and isinstance(strong.value, dict)):
        return strong
    if any(key in node.value for node in (weak, strong) for key in ("columns", "table")):
        return strong
    both = dict(weak.value)
    for key, node in strong.value.items():
        both[key] = merged(both[key], node) if key in both else node
    return replace(strong, value=both)


def placed(root: Node, path: Path, value: Node) -> Node:
    """The tree with ``value`` at a path; scalars on the way become mappings."""
    if not path:
        return value
    step = path[0]
    if isinstance(step, int) and isinstance(root.value, list) and step < len(root.value):
        items = list(root.value)
        items[step] = placed(items[step], path[1:], value)
        return replace(root, value=items)
    mapping = dict(root.value) if isinstance(root.value, dict) else {}
    below = mapping.get(str(step), Node({}, file=value.file, layer=value.layer))
    mapping[str(step)] = placed(below, path[1:], value)
    return replace(root, value=mapping)


def too_short(root: Node, path: Path) -> tuple[Path, int] | None:
    """The list on the way that has no entry of the number that the path names, and how many it has."""
    for place, step in enumerate(path):
        node = root.at(path[:place])
        if node is not None and isinstance(step, int) and isinstance(node.value, list) and step >= len(node.value):
            return path[:place], len(node.value)
    return None


def origins(node: Node, path: Path = (), inherited: Origin | None = None) -> Iterator[tuple[Path, Origin]]:
    """Where every value of the tree came from; what says nothing about it came from the user."""
    origin = node.origin or inherited
    if isinstance(node.value, dict) and "columns" not in node.value:
        for key, item in node.value.items():
            yield from origins(item, (*path, key), origin)
    elif isinstance(node.value, list) and any(isinstance(item.value, dict) for item in node.value):
        for place, item in enumerate(node.value):
            yield from origins(item, (*path, place), origin)
    else:
        yield path, replace(origin or Origin("user"), text=as_one_line(node))


def as_one_line(node: Node) -> str:
    """A value as one would write it in one line."""
    if isinstance(node.value, list):
        return "[" + ", ".join(as_one_line(item) for item in node.value) + "]"
    return node.text
