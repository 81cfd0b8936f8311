"""Tool tables as LinuxCNC writes them: ``T1 P1 D6.0 Z-20 ;notice``, one tool a line, in the units of the machine."""

import math
import re

from cutwise.programs.controller import INCH, LINEAR, MILLIMETRE
from cutwise.programs.scale import MOST, out_of_scale
from cutwise.programs.setup import Tool
from cutwise.spec.faults import Fault, ScenarioFault

_WORD = re.compile(r"\s*([A-Za-z])\s*([+-]?(?:\d+\.?\d*|\.\d+))")
_AXES = "XYZABCUVW"
_LEAST_DIAMETER = 0.1  # [mm]; a smaller one is an inch


def is_in_inches(text: str) -> bool:
    """Whether a tool table has a diameter that no mill in millimetres has."""
    diameters = [float(number) for letter, number in _WORD.findall(_without_notices(text)) if letter in "Dd"]
    return any(0.0 < abs(diameter) < _LEAST_DIAMETER for diameter in diameters)


def read_tool_table(text: str, name: str, *, inch: bool) -> dict[int, Tool]:
    """The tools of a table by their number.

    Parameters
    ----------
    text, name : str
        The table, and the name of its file for messages.
    inch : bool
        Whether its lengths are inches, else millimetres.

    Raises
    ------
    ScenarioFault
        With every line that is not a tool.
    """
    tools: dict[int, Tool] = {}
    faults: list[Fault] = []
    for number, raw in enumerate(text.splitlines(), start=1):
        line, _, notice = raw.partition(";")
        if not line.strip():
            continue
        try:
            tool = _tool(line, notice.strip(), INCH if inch else MILLIMETRE)
        except _LineFault as fault:
            faults.append(Fault((), fault.message, number, fault.column, name))
            continue
        if tool.number in tools:
            faults.append(Fault((), f"tool T{tool.number} is there already; give each tool one line", number, 1, name))
        tools[tool.number] = tool
    if faults:
        raise ScenarioFault(faults)
    return tools


def _without_notices(text: str) -> str:
    return "\n".join(line.partition(";")[0] for line in text.splitlines())


class _LineFault(Exception):
    def __init__(self, message: str, column: int) -> None:
        super().__init__(message)
        self.message, self.column = message, column


def _tool(line: str, notice: str, unit: float) -> Tool:
    values: dict[str, float] = {}
    at = 0
    while line[at:].strip():
        match = _WORD.match(line, at)
        column = at + len(line[at:]) - len(line[at:].lstrip()) + 1
        if match is None:
            raise _LineFault(f'"{line[at:].strip()[:12]}" is not a letter with a number; a tool is a line such as '
                             "T1 P1 D6 Z-20 ; notice", column)  # fmt: skip
        letter = match[1].upper()
        if letter not in "TPDIJQ" + _AXES:
            raise _LineFault(
                f"{letter} has no meaning in a tool table; known are T P D I J Q X Y Z A B C U V W", column
            )
        if letter in values:
            raise _LineFault(f"{letter} twice in one line", column)
        values[letter] = float(match[2])
        if abs(values[letter]) > MOST:
            raise _LineFault(out_of_scale(values[letter]), column)
        at = match.end()
    if "T" not in values or values["T"] < 0 or values["T"] != round(values["T"]):
        raise _LineFault("a tool needs its number T, a whole number", 1)
    offset = tuple(
        values.get(axis, 0.0) * unit if i in LINEAR else math.radians(values.get(axis, 0.0))
        for i, axis in enumerate(_AXES)
    )
    return Tool(
        int(values["T"]), int(values.get("P", 0)), offset, abs(values.get("D", 0.0)) * unit,
        math.radians(values.get("I", 0.0)), math.radians(values.get("J", 0.0)), int(values.get("Q", 0)), notice,
    )  # fmt: skip
