"""Programs of any kind, G-code or APT, into canonical commands and moves."""

from collections.abc import Iterator
from typing import Literal, NamedTuple, Protocol

import numpy as np

from cutwise.programs.apt import Apt, is_apt
from cutwise.programs.canon import Command, SelectTool
from cutwise.programs.fanuc import Fanuc, macro_sign
from cutwise.programs.move_table import CUTTING, Moves
from cutwise.programs.moves import Point, moves
from cutwise.programs.recognise import foreign_text
from cutwise.programs.rs274 import Rs274
from cutwise.programs.setup import Setup
from cutwise.spec.faults import Fault, ScenarioFault

_NOTHING = Setup()


class Reading(Protocol):
    """A run through a program."""

    language: Literal["G-code", "APT"]
    start: Point  # of the tool tip in the machine [m]
    blocks: int  # that were run so far

    def commands(self) -> Iterator[Command]:
        """Its commands; raises ScenarioFault at the end, with everything that could not be run."""
        ...

    def notices(self) -> list[str]:
        """What was assumed, known when the commands are used up."""
        ...


class Interpreted(NamedTuple):
    """The moves of a program, and what was noticed."""

    moves: Moves
    tools: tuple[int, ...]  # as they are called; the default one if none is
    notices: tuple[str, ...]
    text: str = ""  # as it was read


def reading(text: str, name: str = "program", setup: Setup = _NOTHING) -> Reading:
    """A run through a program, by the suffix of its name (``.apt``, ``.cls``, ``.cl``) or by what it looks like.

    Raises
    ------
    ScenarioFault
        It is something else; one sentence says what.
    """
    apt = is_apt(text, name)
    foreign = foreign_text(text, apt=apt)
    if foreign is not None:
        raise ScenarioFault([Fault((), foreign, file=name)])
    return Apt(text, name, setup) if apt else _in_its_dialect(text, name, setup)


def _in_its_dialect(text: str, name: str, setup: Setup) -> Rs274:
    """G-code of the dialect that is asked for; fanuc where the program shows macro B and none is asked for."""
    if setup.dialect == "fanuc":
        return Fanuc(text, name, setup)
    sign = macro_sign(text)
    if sign is None:
        return Rs274(text, name, setup)
    line, statement = sign
    if setup.dialect == "rs274":
        message = f"{statement} is Fanuc macro B, which the dialect rs274 does not know; choose the dialect fanuc"
        raise ScenarioFault([Fault((), message, line, file=name)])
    run = Fanuc(text, name, setup)
    run.controller.notices[f"{statement} is Fanuc macro B: the program is run in the dialect fanuc"] = line
    return run


def default_tool(setup: Setup) -> int:
    """Number of the tool that is taken where a program calls none: the one given, the table's first, or 1."""
    return setup.default_tool if setup.default_tool is not None else min(setup.tools or (1,))


def default_tool_notice(setup: Setup) -> str:
    """What is said of it."""
    origin = (
        "as given" if setup.default_tool is not None else "the first of the tool table" if setup.tools else "assumed"
    )
    return f"the program calls no tool; tool {default_tool(setup)} is in the spindle ({origin})"


def interpret(text: str, name: str = "program", setup: Setup = _NOTHING) -> Interpreted:
    """The moves of a G-code or APT program.

    Understood is the RS274/NGC dialect as LinuxCNC documents it, with expressions, subroutines, cutter compensation and
    canned cycles; lathe words and anything unknown are faults with line and column, never skipped.

    Raises
    ------
    ScenarioFault
        With everything in the program that cannot be run; or it has no feed move.
    """
    run = reading(text, name, setup)
    tools: list[int] = []

    def watched() -> Iterator[Command]:
        for command in run.commands():
            if isinstance(command, SelectTool):
                tools.append(command.tool)
            yield command

    made = Moves(moves(watched(), start=run.start, tool=default_tool(setup)))
    if not np.isin(made.kinds, CUTTING).any():
        raise ScenarioFault([Fault((), "has no feed move: nothing would be cut", file=name)])
    notices = run.notices()
    if not tools:
        notices.append(default_tool_notice(setup))
    return Interpreted(made, tuple(tools) or (default_tool(setup),), tuple(notices), text)
