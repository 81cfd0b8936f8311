"""What an engineer gives to a program: tools, offsets, start; and the files that stand beside it."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path

from cutwise.io.files import read_bytes
from cutwise.programs.expressions import BlockFault
from cutwise.programs.macro_flow import file_names
from cutwise.programs.recognise import foreign_bytes
from cutwise.programs.rs274 import first_unit
from cutwise.programs.setup import Setup, Tool, WorkSystem
from cutwise.programs.tools import is_in_inches, read_tool_table
from cutwise.programs.words import compact, read_line
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.program import WORK_SYSTEMS, Program

SUBROUTINE_SUFFIXES = (".ngc", ".nc", ".NC")
_CALLS = re.compile(r"^.*[oO].*[cC]\s*[aA]\s*[lL]\s*[lL].*$", re.MULTILINE)
_NUMBERED = re.compile(r"(?:M98|G65)[^\n(;]*?P[ \t]*(\d{1,8})", re.IGNORECASE)
_FILE_NAME = re.compile(r"[a-z0-9_-]+")


def decoded(content: bytes) -> str:
    """Text of a program: UTF-8, else Latin-1, as older CAM systems write their comments; ``\\n`` between lines."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    return text if "\r" not in text or "\n" in text else text.replace("\r", "\n")


def read_program(path: Path, shown: str) -> str:
    """Text of a program file.

    Raises
    ------
    ScenarioFault
        There is no such file, or it cannot be read, or it is text of an encoding that no control reads.
    """
    content = read_bytes(path, shown)
    wrong = foreign_bytes(content)
    if wrong is not None:
        raise ScenarioFault([Fault((), wrong, file=shown)])
    return decoded(content)


def library_beside(folder: Path) -> Callable[[str], str | None]:
    """The subroutine files of a folder, by their names without suffix."""

    def text_of(name: str) -> str | None:
        path = subroutine_file(folder, name)
        return None if path is None else decoded(path.read_bytes())

    return text_of


def subroutine_file(folder: Path, name: str) -> Path | None:
    """The file of a subroutine in a folder; None if there is none."""
    if not _FILE_NAME.fullmatch(name):
        return None
    files = (folder / f"{stem}{suffix}" for stem in (name, name.upper()) for suffix in SUBROUTINE_SUFFIXES)
    return next((file for file in files if file.is_file()), None)


def subroutine_files(text: str, library: Callable[[str], str | None]) -> dict[str, str]:
    """Texts of the subroutine files that a program calls by written-out labels, and those that they call in turn."""
    found: dict[str, str] = {}
    waiting = [text]
    while waiting:
        for label in _called(waiting.pop()):
            body = library(label) if label not in found else None
            if body is not None:
                found[label] = body
                waiting.append(body)
    return found


def _called(text: str) -> set[str]:
    labels = set()
    for match in _CALLS.finditer(text):
        try:
            word = read_line(compact(match.group()).text, None).o_word
        except BlockFault:
            continue
        if word is not None and word.keyword == "call" and isinstance(word.label, str):
            labels.add(word.label)
    for match in _NUMBERED.finditer(text):  # Fanuc: M98 P9010, G65 P9010, M98 P39010 (three times)
        for label in {str(int(match[1])), str(int(match[1]) % 10_000)}:
            labels.update(file_names(label))
    return labels


def tool_table(table: str, name: str, program: str) -> dict[int, Tool]:
    """The tools of a table, in the unit that its diameters speak for, else that of the program."""
    return read_tool_table(table, name, inch=table_in_inches(table, program))


def table_in_inches(table: str, program: str) -> bool:
    """Whether a tool table is taken to be in inches: a diameter is too small for millimetres, or the program says G20."""
    return is_in_inches(table) or bool(first_unit(program))


def setup_of(program: Program, library: Callable[[str], str | None] | None = None) -> Setup:
    """What a scenario says about its program; subroutines are those that it holds unless a library is given."""
    texts: Mapping[str, str] = program.subroutines or {}
    tools = {
        tool.number: Tool(tool.number, tool.number, (tool.x, tool.y, tool.z, *(0.0,) * 6), tool.diameter or 0.0)
        for tool in program.tools or ()
    }
    systems = {
        WORK_SYSTEMS.index(name) + 1: WorkSystem((offset.x, offset.y, offset.z), offset.rotation)
        for name, offset in (program.offsets or {}).items()
    }
    start = program.start
    return Setup(
        tools or None, systems, None if start is None else (start.x, start.y, start.z), program.default_tool,
        dialect=program.dialect, library=library or texts.get, step_limit=program.step_limit,
    )  # fmt: skip
