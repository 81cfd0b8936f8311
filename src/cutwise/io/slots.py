"""The slots of a cell in a scenario as written: which process they mean, and what they take out of it.

Terms that a ``--set cell.structure=[...]`` does not name are taken out of the file, so that one file is run with and
without pistons, arm or base. Within one file nothing is taken out: what contradicts itself there is a fault.
"""

from collections.abc import Iterator
from dataclasses import replace

from cutwise.io.tree import Node, from_data, placed
from cutwise.spec import fields
from cutwise.spec.base import Spec
from cutwise.spec.cell import PRESETS, ROWS, SLOTS, processes_with
from cutwise.spec.faults import Path
from cutwise.spec.part_block import PartSpring

_WITHOUT: dict[str, tuple[tuple[Path, str | None], ...]] = {
    "pistons": ((("spindle",), "rigid"),),
    "tip": ((("tool", "stiffness"), None),),
    "tip_modes": ((("tool", "modes"), None),),
    "base": ((("robot", "base_compliance"), None),),
    "part": ((("part", "stiffness"), None), (("part", "block"), None)),
}
_SETTINGS = {"edge": "arcs", "edge_memory": "swept"}  # numerics.engagement


def processes_named(tree: Node) -> tuple[str, ...]:
    """The processes that the slots of a scenario leave, none of them if they say nothing about it."""
    named = {slot: word for slot in ("engagement", "cutting", "surface") if (word := _word(tree, slot)) is not None}
    return processes_with(named) if named else ()


def with_slots(tree: Node, model: type[Spec]) -> Node:
    """The tree with what its slots set, and without what they take out of weaker layers."""
    engagement = tree.at(("cell", "engagement"))
    setting = _SETTINGS.get(engagement.text) if engagement is not None else None
    if setting and fields.field_at(model, ("numerics", "engagement")) and engagement is not None:
        there = tree.at(("numerics", "engagement"))
        if there is None or there.layer < engagement.layer:
            tree = placed(tree, ("numerics", "engagement"), from_data(setting, engagement.file, engagement.layer))
    structure = tree.at(("cell", "structure"))
    if structure is not None and isinstance(structure.value, list):
        named = {item.text for item in structure.value}
        for term, keys in _WITHOUT.items():
            for path, value in keys if term not in named else ():
                tree = _taken_out(tree, model, path, value, structure)
    return _moved_by(tree, tree.at(("cell", "motion")))


def _word(tree: Node, slot: str) -> str | None:
    """A row that is named and known; others are told when the scenario is read."""
    node = tree.at(("cell", slot))
    known = {row for preset in PRESETS.values() for row in getattr(preset, slot)} if slot in SLOTS else ()
    return node.text if node is not None and node.text in known else None


def _taken_out(tree: Node, model: type[Spec], path: Path, value: str | None, by: Node) -> Node:
    """The tree without what a stronger layer than its own leaves out."""
    owner, there, info = tree.at(path[:1]), tree.at(path), fields.field_at(model, path)
    if (
        owner is None
        or owner.value is None
        or info is None
        or by.layer <= max(1, there.layer if there is not None else 0)
    ):
        return tree
    if path == ("part", "block") and not any("flexible" in one.model_fields for one in fields.sections(info)):
        return tree  # the part itself, which does not yield
    if path[0] == "part" and PartSpring in fields.inner(model.model_fields["part"]):
        if owner.layer >= by.layer or (there is None and owner.at(("flexible",)) is None):
            return tree
        motion = tree.at(("cell", "motion"))
        stands = motion is None or motion.text in ("machine", "driven_machine")
        if there is None and stands:  # a block still stands on the table
            return placed(tree, ("part", "flexible"), from_data(False, by.file, by.layer))
        path = ("part",)
    return placed(tree, path, from_data(value, by.file, by.layer))


def _moved_by(tree: Node, motion: Node | None) -> Node:
    """The tree without the drives or the carrier that a stronger layer leaves out."""
    if motion is None or motion.text not in ROWS["motion"]:
        return tree
    for key, node in _weaker(tree, motion):
        if (key == "robot" and motion.text != "robot") or (key == "machine" and motion.text in ("robot", "programmed")):
            tree = placed(tree, (key,), from_data(None, motion.file, motion.layer))
        elif key == "machine" and motion.text == "machine" and node.at(("drives",)) is not None:
            tree = placed(tree, (key, "drives"), from_data(None, motion.file, motion.layer))
        elif key == "machine" and motion.text == "drives" and (drives := node.at(("drives",))) is not None:
            tree = replace(tree, value={**tree.value, key: drives})
    return tree


def _weaker(tree: Node, motion: Node) -> Iterator[tuple[str, Node]]:
    for key in ("robot", "machine"):
        node = tree.value.get(key)
        if node is not None and node.layer < motion.layer:
            yield key, node
