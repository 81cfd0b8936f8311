"""How sure the values of a scenario are: covariances of its library entries, standard errors beside single values.

A covariance speaks of the values that its entry gave. What a stronger layer has replaced (the scenario over an entry,
``--set`` over both) is taken out of it; what is left keeps its covariance.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from cutwise import units
from cutwise.io.covariances import matrix_fault
from cutwise.io.library import Entry
from cutwise.io.tree import Node, from_data
from cutwise.spec import fields
from cutwise.spec.base import Spec
from cutwise.spec.faults import Fault, Path, dotted, split_dotted

_ENTRY = 0  # layer of library values
_AGREES = 0.05  # share by which a standard error may differ from that of the covariance


class Source(NamedTuple):
    """A library entry that has given values to a section."""

    path: Path
    label: str
    entry: Entry


def with_covariances(tree: Node, model: type[Spec], sources: Sequence[Source], faults: list[Fault]) -> Node:
    """The tree with the covariances of all its values, under the keys that they have in the scenario, in SI."""
    if "covariances" not in model.model_fields or not isinstance(tree.value, dict):
        return tree
    blocks: dict[str, Any] = {}
    for name, block in _named(tree.value.get("covariances")):
        found = _of_scenario(tree, model, name, block, faults)
        if found is not None:
            blocks[name] = found
    measured = {name: node.plain() for name, node in _named(tree.value.get("measured"))}
    measured = {name: one for name, one in measured.items() if _still_given(tree, name, one)}
    for source in sources:
        for name, block in _named(source.entry.covariances):
            found = _of_entry(tree, model, source, name, block, faults)
            if found is not None:
                blocks["_".join(map(str, (*source.path, name)))] = found
        if source.entry.measured is not None and _gives(tree, source.path, source.label):
            measured[dotted(source.path)] = _said(source)
    known = {name for block in blocks.values() if isinstance(block, dict) for name in block["of"]}
    for key, node, error in _alone(tree, model):
        if key not in known:
            blocks[key] = _single(key, node, error)
    value = {key: node for key, node in tree.value.items() if key not in ("covariances", "measured")}
    for key, said in (("covariances", blocks), ("measured", measured)):
        if said:
            value[key] = from_data(said, tree.file)
    return Node(
        value, tree.text, tree.file, tree.line, tree.column, tree.key_line, tree.key_column, tree.layer, tree.origin
    )


def _named(node: Node | None) -> Iterator[tuple[str, Node]]:
    if node is not None and isinstance(node.value, dict):
        yield from node.value.items()


def _given(tree: Node, path: Path) -> tuple[Node | None, str]:
    """The value at a path, and the entry that gave it."""
    library, node = "", tree
    for step in path:
        here = node.at((step,))
        if here is None:
            return None, library
        node = here
        library = node.origin.library if node.origin is not None else library
    return node, library


def _of_entry(
    tree: Node, model: type[Spec], source: Source, name: str, block: Node, faults: list[Fault]
) -> dict[str, Any] | None:
    """A block of an entry for the values that are still those of the entry."""
    names = [str(one) for one in block.value["of"].plain()]
    paths = [(*source.path, *split_dotted(one)) for one in names]
    kept = []
    for k, path in enumerate(paths):
        node, library = _given(tree, path)
        if node is not None and node.layer == _ENTRY and library == source.label:
            kept.append(k)
    where = (*source.path, "library")
    return _block(tree, model, block, paths, kept, source.label, _Place(block, where, f"covariances.{name}"), faults)


def _of_scenario(tree: Node, model: type[Spec], name: str, block: Node, faults: list[Fault]) -> Any:
    """A block that stands in the scenario itself, written there or by a document."""
    place = _Place(block, ("covariances", name), "")
    if not isinstance(block.value, dict) or not {"of", "matrix"} <= set(block.value):
        faults.append(block.fault(("covariances", name), "needs of (the values) and matrix (their covariance)"))
        return None
    of = block.value["of"].plain()
    names = [str(one) for one in of] if isinstance(of, list) else []
    label = block.value["library"].text if "library" in block.value else ""
    paths, kept = [split_dotted(one) for one in names], []
    for k, path in enumerate(paths):
        node, library = _given(tree, path)
        if node is None and not label:
            faults.append(
                block.value["of"].fault(("covariances", name, "of"), f"{names[k]} is no value of this scenario")
            )
        elif node is not None and node.layer <= block.layer and label in ("", library):
            kept.append(k)
    return _block(tree, model, block, paths, kept, label, place, faults)


class _Place(NamedTuple):
    """Where a fault of a block is told."""

    node: Node
    path: Path
    before: str

    def fault(self, message: str) -> Fault:
        return self.node.fault(self.path, f"{self.before}: {message}" if self.before else message)


def _block(
    tree: Node, model: type[Spec], block: Node, paths: Sequence[Path], kept: Sequence[int], label: str, place: _Place,
    faults: list[Fault],
) -> dict[str, Any] | None:  # fmt: skip
    """Rows and columns of the values that count, in SI; None if there are none."""
    matrix = _matrix(block.value["matrix"].plain(), len(paths))
    if isinstance(matrix, str):
        faults.append(place.fault(f"matrix {matrix}"))
        return None
    kinds = _each(block.value.get("as"), "value", len(paths))
    written = _each(block.value.get("unit"), "", len(paths))
    if len(kinds) != len(paths) or len(written) != len(paths):
        faults.append(place.fault(f"as and unit are one for all, or one for each of the {len(paths)} values"))
        return None
    scales, used = {}, []
    for k in kept:
        if fields.field_at(model, paths[k]) is None:
            continue  # this process does not ask for it
        dimension = fields.dimension_at(model, paths[k]) or "dimensionless"
        try:
            scales[k] = units.scatter_factor(written[k], dimension, kinds[k])
        except units.UnitFault as fault:
            faults.append(place.fault(f"unit: {fault}"))
            return None
        used.append(k)
    if not used:
        return None
    for k in used:
        wrong = _disagreement(tree, paths[k], kinds[k], scales[k] * math.sqrt(max(matrix[k][k], 0.0)), model)
        if wrong:
            faults.append(place.fault(wrong))
    names = [dotted(paths[k]) for k in used]
    said = block.value["undetermined"].plain() if "undetermined" in block.value else []
    free_of = [name for k, name in zip(used, names, strict=True) if name in said or _unknown(tree, paths[k], model)]
    free = block.value["degrees_of_freedom"].value if "degrees_of_freedom" in block.value else None
    return {
        "of": names,
        "as": [kinds[k] for k in used],
        **({"degrees_of_freedom": free} if free is not None else {}),
        "matrix": [[float(matrix[i][j]) * scales[i] * scales[j] for j in used] for i in used],
        **({"library": label} if label else {}),
        **({"alone": True} if "alone" in block.value and block.value["alone"].value is True else {}),
        **({"undetermined": free_of} if free_of else {}),
    }


def _each(node: Node | None, usual: str, count: int) -> list[str]:
    said = usual if node is None else node.plain()
    return [str(one) for one in said] if isinstance(said, list) else [str(said)] * count


def _matrix(given: Any, count: int) -> list[list[float]] | str:
    return matrix_fault(given, count) or given


def _own_error(tree: Node, path: Path) -> Node | None:
    """The standard error that stands beside a value, or beside the section or list that holds it."""
    for cut in range(len(path), 0, -1):
        node = tree.at(path[:cut])
        if node is not None and node.scatter is not None:
            return node.scatter.at(path[cut:])
    return None


def _unknown(tree: Node, path: Path, model: type[Spec]) -> bool:
    """Whether the fit said that its data do not tell the value: the standard error is infinite."""
    own = _number(_own_error(tree, path), path, model)
    return own is not None and math.isinf(own)


def _disagreement(tree: Node, path: Path, kind: str, error: float, model: type[Spec]) -> str:
    """A standard error that is not that of the matrix: one of them, or a unit, is wrong."""
    value, own_error = _number(tree.at(path), path, model), _number(_own_error(tree, path), path, model)
    if value is None or own_error is None or not math.isfinite(own_error) or value == 0.0:
        return ""
    expected = {"value": own_error, "reciprocal": own_error / value**2, "log": own_error / abs(value)}.get(
        kind, own_error
    )
    if abs(error - expected) <= _AGREES * max(error, expected):
        return ""
    return (
        f"the matrix gives {dotted(path)} a standard error of {error:.4g} (as {kind}, SI), its own standard_error one of "
        f"{expected:.4g}: is a unit wrong?"
    )


def _number(node: Node | None, path: Path, model: type[Spec]) -> float | None:
    """A quantity in SI; infinite standard errors are written by fits that say nothing about a value."""
    if node is None or fields.field_at(model, path) is None:
        return None
    dimension = fields.dimension_at(model, path)
    if isinstance(node.value, str) and node.value.strip().startswith("inf"):
        return math.inf
    try:
        return units.parse(node.value, dimension or "dimensionless")
    except units.UnitFault:
        return None


def _alone(tree: Node, model: type[Spec]) -> Iterator[tuple[str, Node, float]]:
    """Values with a standard error of their own: key, node, standard error in SI."""
    for path, node in tree.walk():
        if node.scatter is None:
            continue
        for below, error in node.scatter.walk():
            value = node.at(below)
            if isinstance(error.value, dict | list) or value is None or isinstance(value.value, dict | list):
                continue
            here = (*path, *below)
            size = _number(error, here, model)
            if size is not None and size != 0.0:
                yield dotted(here), value, size


def scatter_faults(tree: Node, model: type[Spec]) -> Iterator[Fault]:
    """Standard errors that are none: without a unit, below zero, not in the form of their value."""
    for path, node in tree.walk():
        if node.scatter is None or fields.field_at(model, path[:1]) is None:
            continue
        for below, error in node.scatter.walk():
            here = (*path, *below)
            if isinstance(error.value, dict | list):
                continue
            value = node.at(below)
            dimension = fields.dimension_at(model, here)
            if value is None or isinstance(value.value, dict | list):
                yield error.fault((*here, "standard_error"), "has not the form of its value")
            elif dimension and not str(error.value).strip().startswith("inf"):
                try:
                    size = units.parse(error.value, dimension)
                except units.UnitFault as fault:
                    yield error.fault((*here, "standard_error"), str(fault))
                    continue
                if size < 0.0:
                    yield error.fault((*here, "standard_error"), f"{error.text} is below zero")


def _single(key: str, node: Node, error: float) -> dict[str, Any]:
    """A block for one value that has no covariance to others."""
    label = node.origin.library if node.origin is not None else ""
    known = math.isfinite(error)
    return {
        "of": [key], "as": ["value"], "matrix": [[error**2 if known else 0.0]], "alone": True,
        **({"library": label} if label else {}), **({} if known else {"undetermined": [key]}),
    }  # fmt: skip


def _gives(tree: Node, path: Path, label: str) -> bool:
    section = tree.at(path)
    if section is None:
        return False
    return any(
        n.origin is not None and n.origin.library == label and n.origin.status == "measured" for _, n in section.walk()
    )


def _still_given(tree: Node, name: str, said: Any) -> bool:
    label = said.get("library", "") if isinstance(said, Mapping) else ""
    return not label or _gives(tree, split_dotted(name), label)


def _said(source: Source) -> dict[str, Any]:
    """What the calibration of an entry says that a run needs."""
    node = source.entry.measured
    plain = node.plain() if node is not None else {}
    if not isinstance(plain, dict):
        return {"library": source.label}
    ranges = plain.get("range")
    pairs = {k: v for k, v in ranges.items() if isinstance(v, list) and len(v) == 2} if isinstance(ranges, dict) else {}
    return {
        "library": source.label,
        **{key: plain[key] for key in ("kind", "residual") if isinstance(plain.get(key), str | float)},
        **({"range": pairs} if pairs else {}),
    }
