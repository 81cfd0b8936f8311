"""The files of a scenario's program: its text, the subroutines that it calls, its tool table."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from cutwise import units
from cutwise.io import program_setup
from cutwise.io.files import as_text, read_bytes
from cutwise.io.tree import Node, from_data
from cutwise.programs.interpreter import interpret
from cutwise.programs.setup import Setup, Tool
from cutwise.spec import faults as spec_faults
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.program import Program

_OFFSET_KEYS = ("x", "y", "z")


def named_file(node: Node) -> Node | None:
    """The node that names a program file, unless its text is there already (a document)."""
    if isinstance(node.value, str):
        return node
    if isinstance(node.value, dict) and "file" in node.value and "text" not in node.value:
        return node.value["file"]  # type: ignore[no-any-return]
    return None


class ProgramFiles(NamedTuple):
    """Reads what a program section names; ``place`` tells where a named file stands."""

    place: Callable[[Node], Path]

    def read_in(self, node: Node, file: Node, path: spec_faults.Path) -> tuple[Node, list[Fault]]:
        """The section with every text written out, the program checked block by block, and what is wrong."""
        place = self.place(file)
        try:
            text = program_setup.read_program(place, str(place))
        except ScenarioFault as fault:
            return node, _at(file, path, fault)
        faults: list[Fault] = []
        library = program_setup.library_beside(place.parent)
        written = dict(node.value) if isinstance(node.value, dict) else {}
        before = named_file(written["wanted"]) if "wanted" in written else None
        if "tools" in written and isinstance(written["tools"].value, str):
            written["tools"], found = self._tool_table(written["tools"], text, (*path, "tools"))
            faults += found
        read: dict[str, Any] = {"file": file.text, "text": text}
        subroutines = program_setup.subroutine_files(text, library)
        read |= {"subroutines": subroutines} if subroutines else {}
        section = replace(node, value={**written, **from_data(read, node.file, node.layer).value})
        try:
            interpret(text, str(place), _setup(section, library))
        except ScenarioFault as fault:
            faults += _at(file, path, fault)
        if before is not None:
            wanted, found = self._wanted(before, _setup(section, library), (*path, "wanted"))
            section.value["wanted"] = wanted
            faults += found
        return section, faults

    def _wanted(self, node: Node, setup: Setup, path: spec_faults.Path) -> tuple[Node, list[Fault]]:
        """The program before its path was corrected, read and checked with what is given to the corrected one."""
        place = self.place(node)
        try:
            text = program_setup.read_program(place, str(place))
            interpret(text, str(place), setup)
        except ScenarioFault as fault:
            return node, _at(node, path, fault)
        return from_data({"file": node.text, "text": text}, node.file, node.layer), []

    def _tool_table(self, node: Node, program: str, path: spec_faults.Path) -> tuple[Node, list[Fault]]:
        """The tools of a tool table file, as they would be written in the scenario."""
        place = self.place(node)
        try:
            tools = program_setup.tool_table(as_text(read_bytes(place, str(place)), str(place)), str(place), program)
        except ScenarioFault as fault:
            return replace(node, value=[]), _at(node, path, fault)
        listed = [_as_written(tool) for tool in tools.values()]
        return replace(node, value=from_data(listed, node.file, node.layer).value), []


def _setup(section: Node, library: Callable[[str], str | None]) -> Setup:
    """What the section gives to its program; what is wrong with it is said with the rest of the scenario."""
    own = {key: value for key, value in section.value.items() if key in Program.model_fields}
    try:
        return program_setup.setup_of(Program.model_validate(replace(section, value=own).plain()), library)
    except ValidationError:
        return Setup(library=library)


def _as_written(tool: Tool) -> dict[str, Any]:
    offsets = {key: units.text(value, "length") for key, value in zip(_OFFSET_KEYS, tool.offset, strict=False)}
    return {"number": tool.number, "diameter": units.text(tool.diameter, "length"), **offsets}


def _at(node: Node, path: spec_faults.Path, fault: ScenarioFault) -> list[Fault]:
    """Faults that have no line of their own stand where the scenario names the file."""
    return [one if one.line else node.fault(path, f"{one.file}: {one.message}") for one in fault.faults]
