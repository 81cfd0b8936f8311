"""A tree of what a scenario says, completed from outside of it: library entries, tables, programs, models of arms."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic.fields import FieldInfo

from cutwise import units
from cutwise.io import library
from cutwise.io.fault_text import unknown_key
from cutwise.io.scatter import Source
from cutwise.io.tables import read_table
from cutwise.io.tree import Node, from_data, merged, placed
from cutwise.later import later
from cutwise.spec import faults as spec_faults
from cutwise.spec import fields
from cutwise.spec.base import LibrarySpec, Spec
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.kinds import KINDS
from cutwise.spec.program import Program
from cutwise.spec.scenario import Origin
from cutwise.spec.tables import Table

if TYPE_CHECKING:
    from cutwise.io import program_files, program_setup, spindle_nodes, urdf
else:  # readers of what few scenarios hold
    program_setup = later("cutwise.io.program_setup")
    program_files = later("cutwise.io.program_files")
    spindle_nodes = later("cutwise.io.spindle_nodes")
    urdf = later("cutwise.io.urdf")

OVERRIDE = 2  # layer of values that are given beside the file; null takes away what the others say


def _fitting(sections: Sequence[type[Spec]], written: set[str]) -> type[Spec]:
    """The alternative of a key that knows most of what is written there; the first among equals."""
    return max(sections, key=lambda section: len(written & {*section.model_fields, *section.stands_for}))


def _moved_inside(node: Node, section: type[Spec], faults: list[Fault], path: spec_faults.Path) -> Node:
    """The section with each key that names one of a section inside of it put there (``Spec.stands_for``)."""
    if not isinstance(node.value, dict):
        return node
    for key, inside in section.stands_for.items():
        if key not in node.value:
            continue
        item = node.value[key]
        kept = replace(node, value={name: one for name, one in node.value.items() if name != key})
        below = kept.value.get(inside)
        if below is not None and isinstance(below.value, dict) and key in below.value:
            if below.value[key].layer == item.layer:
                faults.append(
                    item.fault((*path, key), f"is written as {inside}.{key} too; write one of them", at_key=True)
                )
            if below.value[key].layer >= item.layer:
                node = kept
                continue
        node = placed(kept, (inside, key), item)
    return node


def _may_be_empty(info: FieldInfo) -> bool:
    """Whether a section must be there though it asks for no key by itself: what it lacks, it says when it is empty."""
    kinds = [kind for kind, _ in fields.of_field(info)]
    return info.is_required() and all(
        isinstance(kind, type)
        and issubclass(kind, Spec)
        and not issubclass(kind, LibrarySpec)
        and not any(key.is_required() for key in kind.model_fields.values())
        for kind in kinds
    )


class Assembly:
    """Completes a tree from outside of it: library entries and CSV tables."""

    def __init__(self, model: type[Spec], folder: Path, faults: list[Fault]) -> None:
        self.model, self.folder, self.faults = model, folder, faults
        self.incomplete: set[spec_faults.Path] = set()  # sections that lack their library entry
        self.files: list[str] = []  # what was read
        self.sources: list[Source] = []  # library entries that have given values
        self.meant: set[spec_faults.Path] = set()  # keys that are missing because they are misspelled in an entry

    def explains(self, path: spec_faults.Path) -> bool:
        """A key is missing because of a fault that has been reported."""
        return path[:-1] in self.incomplete or path in self.meant

    def complete(self, node: Node, section: type[Spec], path: spec_faults.Path) -> Node:
        """The section with its library entry merged in and its tables read."""
        node = _moved_inside(node, section, self.faults, path)
        if issubclass(section, LibrarySpec) and isinstance(node.value, dict):
            node = self._with_library(node, section, path)
        if "urdf" in section.model_fields and isinstance(node.value, dict):
            node = self._with_urdf(node, path)
        for key in section.beside or (("step",) if "step" in section.model_fields else ()):
            if isinstance(node.value, dict):
                node = self._with_file_beside(node, key, path)
        if not isinstance(node.value, dict):
            return node
        value = dict(node.value)
        for name, info in section.model_fields.items():
            if name not in value and _may_be_empty(info):
                value[name] = Node({}, file=node.file, line=node.line, column=node.column, layer=node.layer)
            if name not in value:
                continue
            here = (*path, name)
            tables = [kind for kind in fields.sections(info) if issubclass(kind, Table)]
            sections = [kind for kind in fields.sections(info) if not issubclass(kind, Table)]
            if tables and (file := _table_file(value[name])) is not None:
                value[name] = self._table(value[name], file, tables[0], here)
            elif (
                any(issubclass(k, Program) for k in sections)
                and (file := program_files.named_file(value[name])) is not None
            ):
                value[name] = self._program(value[name], file, here)
            elif value[name].value is None and sections and not tables and value[name].layer < OVERRIDE:
                value[name] = replace(value[name], value={})  # "part:" with nothing below it
                value[name] = self.complete(value[name], sections[0], here)
            elif sections:
                value[name] = self.complete(value[name], _fitting(sections, self._written(value[name], sections)), here)
            elif isinstance(value[name].value, list) and any(
                kind.beside or "program" in kind.model_fields for kind in fields.inner(info)
            ):
                value[name] = self._entries_with_files(value[name], info, here)
            elif value[name].value is None and value[name].layer == OVERRIDE:
                del value[name]
            elif value[name].value is None:
                message = "has no value; write one or leave the line out"
                self.faults.append(value[name].fault(here, message, at_key=True))
        node = replace(node, value=value)
        return self._with_solid(node, path) if "solid" in section.model_fields and "solid" in value else node

    def _written(self, node: Node, sections: Sequence[type[Spec]]) -> set[str]:
        """The keys of a section; where it may be one of several, those of its library entry too."""
        keys = set(node.value) if isinstance(node.value, dict) else set()
        label = node.value.get("library") if keys else None
        shelves = {section.library_shelf for section in sections if issubclass(section, LibrarySpec)}
        if len(sections) < 2 or label is None or not label.text or len(shelves) != 1:
            return keys
        with suppress(ScenarioFault):  # told when the entry is read
            keys |= set(self._entry(label, *shelves).values.value)
        return keys

    def _with_library(self, node: Node, section: type[LibrarySpec], path: spec_faults.Path) -> Node:
        label_node = node.value.get("library")
        if label_node is None or not label_node.text:
            return node
        label = label_node.text
        given = {
            key: item
            for key, item in node.value.items()
            if item.origin is None or item.origin.library in ("", label)  # not those of an entry that was replaced
        }
        node = replace(node, value={**given, "library": replace(label_node, value=label)})
        if any(item.origin is not None and item.origin.library == label for item in given.values()):
            return node  # a document: the entry has been written out
        try:
            entry = self._entry(label_node, section.library_shelf)
        except ScenarioFault as fault:
            self.incomplete.add(path)
            for one in fault.faults:
                message = f"{one.file}: {one.message}" if one.file else one.message
                here = label_node.fault((*path, "library"), message)
                self.faults.append(one if one.line is not None else here)
            return node
        values = library.marked(entry.values, label)
        known = self._known_to_section(values, section, path)
        self.sources.append(Source(path, label, entry))
        return merged(known, node)

    def _with_urdf(self, node: Node, path: spec_faults.Path) -> Node:
        """The section with the joints of its URDF file; a document has them written out already."""
        file = node.value.get("urdf")
        if file is None or not file.text or ("joints" in node.value and node.value["joints"].layer >= file.layer):
            return node
        place = self._file(file.text, file)
        tip = node.value.get("tip_link")
        try:
            arm = urdf.read_urdf(place, str(place), tip.text if tip is not None and tip.text else None, _held(node))
        except ScenarioFault as fault:
            self.incomplete.add(path)
            here = (*path, "urdf")
            self.faults += [
                one if one.line is not None else file.fault(here, f"{one.file}: {one.message}") for one in fault.faults
            ]
            return node
        read = {
            "joints": [dict(joint) for joint in arm.joints],
            "flange_origin": arm.flange["origin"],
            "flange_rotation": arm.flange["rotation"],
            "urdf_remarks": list(arm.notices),
        }
        layer = max(node.value[key].layer for key in ("urdf", "tip_link", "held_joints") if key in node.value)
        inlined = {key: from_data(value, file.file, layer) for key, value in read.items()}
        origin = Origin("user", source=f"URDF {file.text}")
        inlined = {key: replace(item, origin=origin) for key, item in inlined.items()}
        return replace(node, value={**node.value, **inlined})

    def _entries_with_files(self, node: Node, info: FieldInfo, path: spec_faults.Path) -> Node:
        """A list of sections, the files that its entries name found beside the scenario."""
        entries = []
        for place, entry in enumerate(node.value):
            whole = [kind for kind in fields.inner(info) if "program" in kind.model_fields]
            if isinstance(entry.value, dict) and whole:  # a set-up has files within
                entry = self.complete(entry, whole[0], (*path, place))
            elif isinstance(entry.value, dict):
                for key in _fitting(list(fields.inner(info)), set(entry.value)).beside:
                    entry = self._with_file_beside(entry, key, (*path, place))
            entries.append(entry)
        return replace(node, value=entries)

    def _with_file_beside(self, node: Node, key: str, path: spec_faults.Path) -> Node:
        """The section with a file found beside the scenario."""
        file = node.value.get(key)
        if file is None or not isinstance(file.value, str):
            return node
        place = self._file(file.value, file)
        try:
            there = place.exists()
        except (OSError, ValueError):  # no name of a file
            there = False
        if not there:
            self.faults.append(file.fault((*path, key), f"{place!s:.200}: no such file"))
            return node
        return replace(node, value={**node.value, key: replace(file, value=str(place))})

    def _with_solid(self, node: Node, path: spec_faults.Path) -> Node:
        node, faults, known = spindle_nodes.with_solid(node, path)
        self.faults += faults
        if not known:
            self.incomplete.add(path)
        return node

    def _entry(self, label: Node, shelf: str) -> library.Entry:
        name = label.text
        if not library.is_file(name):
            return library.entry(shelf, name)
        path = self._file(name, label)
        return library.read_entry(path, str(path), shelf)

    def _known_to_section(self, values: Node, section: type[LibrarySpec], path: spec_faults.Path) -> Node:
        """Only what this process asks for; what no process knows is a fault of the entry."""
        known = {}
        for key, item in values.value.items():
            if key in section.model_fields:
                known[key] = item
            elif key not in shelf_keys(section.library_shelf):
                message, meant = unknown_key(self.model, (*path, key))
                self.meant.add(meant)
                self.faults.append(item.fault((*path, key), message, at_key=True))
        return replace(values, value=known)

    def _file(self, name: str, node: Node) -> Path:
        """A file named in the scenario, beside the scenario; one named by ``--set``, where the engineer stands."""
        try:
            here = node.layer == OVERRIDE and Path(name).exists()
        except (OSError, ValueError):  # no name of a file
            here = False
        place = Path(name) if here else self.folder / name
        self.files.append(str(place))
        return place

    def _program(self, node: Node, file: Node, path: spec_faults.Path) -> Node:
        """The section of a program with the texts of its files."""
        section, faults = program_files.ProgramFiles(lambda named: self._file(named.text, named)).read_in(
            node, file, path
        )
        self.faults += faults
        place = self._file(file.text, file)
        if "subroutines" in section.value:
            beside = (program_setup.subroutine_file(place.parent, name) for name in section.value["subroutines"].value)
            self.files += [str(one) for one in beside if one is not None]
        return section

    def _table(self, node: Node, file: Node, kind: type[Table], path: spec_faults.Path) -> Node:
        place = self._file(file.text, file)
        try:
            columns = read_table(place, str(place), path, kind.over, kind.ordinate)
        except ScenarioFault as fault:
            missing = [
                replace(file.fault(path, f"{one.file}: {one.message}")) for one in fault.faults if one.line is None
            ]
            self.faults += [*missing, *(one for one in fault.faults if one.line is not None)]
            return node
        inlined = from_data({"columns": columns, "file": file.text}, node.file, node.layer)
        return replace(node, value=inlined.value)


def _held(robot: Node) -> dict[str, float | None]:
    """Joints that stand still: where a sliding one does [m], None for a turning one; what is wrong is told later."""
    entries = robot.value["held_joints"].value if "held_joints" in robot.value else None
    held: dict[str, float | None] = {}
    for entry in entries if isinstance(entries, list) else []:
        if not isinstance(entry.value, dict) or "joint" not in entry.value:
            continue
        position = entry.value.get("position")
        try:
            held[entry.value["joint"].text] = None if position is None else units.parse(position.value, "length")
        except units.UnitFault:
            continue
    return held


def _table_file(node: Node) -> Node | None:
    """The node that names the CSV file of a table."""
    if isinstance(node.value, str) and node.value.strip().lower().endswith(".csv"):
        return node
    if isinstance(node.value, dict) and set(node.value) == {"table"}:
        return node.value["table"]  # type: ignore[no-any-return]
    return None


def shelf_sections(shelf: str) -> list[type[LibrarySpec]]:
    """Every section, of any process and at any depth, that takes values from a shelf."""
    infos = (info for model in KINDS.values() for _, info in fields.keys(model))
    found = (section for info in infos for section in fields.sections(info))
    return list(dict.fromkeys(s for s in found if issubclass(s, LibrarySpec) and s.library_shelf == shelf))


def shelf_keys(shelf: str) -> set[str]:
    """Every key that some process takes from a shelf."""
    return {key for section in shelf_sections(shelf) for key in section.model_fields}
