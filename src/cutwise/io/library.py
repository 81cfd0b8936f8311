"""The library: parameter values with their sources, one YAML file per source, on shelves by kind."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import lru_cache
from pathlib import Path

from cutwise.io.covariances import covariance_faults
from cutwise.io.files import as_text, read_bytes
from cutwise.io.tree import Node, compose, origins, unwrapped
from cutwise.spec.faults import Fault, ScenarioFault, dotted
from cutwise.spec.scenario import Origin

FOLDER = Path(__file__).parent.parent / "library"
SHELVES = (
    "tools", "materials", "spindles", "path_errors", "machines", "lathes", "robots", "drills", "drilled_materials",
)  # fmt: skip

_KEYS = ("name", "describes", "values", "covariances", "measured")  # the last two: of a calibration


@dataclass(frozen=True)
class Entry:
    """A library entry: what it describes, and its values, each with its origin."""

    shelf: str
    name: str
    describes: str
    file: Path
    values: Node
    covariances: Node | None = None
    measured: Node | None = None  # what the calibration says about itself

    def origins(self) -> Iterator[tuple[str, str, Origin]]:
        """Dotted key, text and origin of each value."""
        for path, origin in origins(self.values):
            yield dotted(path), origin.text, origin


def shelf(kind: str) -> dict[str, Entry]:
    """All entries of a shelf by name."""
    if kind not in SHELVES:
        near = get_close_matches(kind, SHELVES, n=1)
        hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(SHELVES)}"
        raise ScenarioFault([Fault((), f"no library shelf {kind}; {hint}")])
    return {name: entry(kind, name) for name in names(kind)}


@lru_cache(maxsize=16)
def names(kind: str) -> tuple[str, ...]:
    """Names of the entries of a shelf, the default first."""
    found = sorted(path.stem for path in (FOLDER / kind).glob("*.yaml"))
    return tuple(sorted(found, key=lambda name: (name != "default", name)))


@lru_cache(maxsize=256)
def entry(kind: str, name: str) -> Entry:
    """One entry of a shelf.

    Raises
    ------
    ScenarioFault
        There is no such entry; the message lists what there is.
    """
    there = names(kind)
    if name not in there:
        raise ScenarioFault([Fault((), missing_entry(kind, name))])
    path = FOLDER / kind / f"{name}.yaml"
    return read_entry(path, f"library/{kind}/{name}.yaml", kind)


def is_file(label: str) -> bool:
    """Whether an entry is named as a file of the engineer, and not one of the library."""
    return "/" in label or "\\" in label or label.endswith((".yaml", ".yml"))


def labelled(kind: str, label: str) -> Entry:
    """The entry of a ``library`` key: of the library, or a file from where the engineer stands."""
    return read_entry(Path(label), label, kind) if is_file(label) else entry(kind, label)


def missing_entry(kind: str, name: str) -> str:
    """That there is no such entry, and what there is."""
    there = names(kind)
    near = get_close_matches(name, there, n=1)
    hint = f"did you mean {near[0]}? " if near else ""
    return f'no entry "{name}" on the library shelf {kind}; {hint}there are: {", ".join(there) or "none"}'


def read_entry(path: Path, shown: str, kind: str) -> Entry:
    """An entry from a file; the engineer's own files have the same form as those of the library.

    Raises
    ------
    ScenarioFault
        The file cannot be read, or is no library entry.
    """
    tree, faults = compose(as_text(read_bytes(path, shown), shown), shown, layer=0)
    if tree is None or not isinstance(tree.value, dict):
        raise ScenarioFault(
            faults or [Fault((), "is no library entry; it needs name, describes and values", file=shown)]
        )
    for key, node in tree.value.items():
        if key not in _KEYS:
            faults.append(node.fault((key,), f"unknown key; a library entry has {', '.join(_KEYS)}", at_key=True))
    values = tree.value.get("values")
    if values is None or not isinstance(values.value, dict) or not values.value:
        faults.append(
            tree.fault(("values",), "missing; write values: and below it the keys, each {value, status, source}")
        )
    if values is not None and isinstance(values.value, dict) and "covariances" in tree.value:
        faults += covariance_faults(tree.value["covariances"], values)
    if faults:
        raise ScenarioFault(faults)
    assert values is not None
    name = tree.value["name"].text if "name" in tree.value else path.stem
    describes = tree.value["describes"].text if "describes" in tree.value else ""
    entry_values = unwrapped(values, (), faults)
    if faults:
        raise ScenarioFault(faults)
    return Entry(kind, name, describes, path, entry_values, tree.value.get("covariances"), tree.value.get("measured"))


def marked(node: Node, label: str, inherited: Origin | None = None) -> Node:
    """The values of an entry, each knowing the entry that gave it; what says nothing has the origin of its section."""
    origin = node.origin or inherited
    if isinstance(node.value, dict) and "columns" not in node.value:
        return replace(node, value={key: marked(item, label, origin) for key, item in node.value.items()}, origin=None)
    if isinstance(node.value, list) and any(isinstance(item.value, dict) for item in node.value):
        return replace(node, value=[marked(item, label, origin) for item in node.value], origin=None)
    origin = origin or Origin("user", source=node.file)
    return replace(node, origin=replace(origin, library=label))
