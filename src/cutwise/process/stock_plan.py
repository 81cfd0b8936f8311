"""The program of a stock in 3D before anything is cut: its path, tools, feeds and times."""

import re
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise import units
from cutwise.io.program_setup import setup_of
from cutwise.maths.curves import FloatArray
from cutwise.physics.motion.lookahead import Plan, highest_feeds, plan
from cutwise.physics.motion.profile import at as profile_at
from cutwise.process.assemble_mill import motion_limits, pace_of
from cutwise.process.program_path import ProgramPath, moves_path
from cutwise.process.stock_material import Raw
from cutwise.process.stock_tools import ToolSet, tool_set
from cutwise.programs.interpreter import Interpreted, interpret
from cutwise.spec.cutter import Cutter
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.milling import MillingScenario
from cutwise.spec.milling_machine import drives_of
from cutwise.spec.program import Program, ProgramTool, StartPosition
from cutwise.spec.tool import EndMill

IntArray = npt.NDArray[np.int64]

_COMPENSATED = re.compile(r"[Gg]\s*0*4[12](?!\d)|CUTCOM|\[", re.IGNORECASE)  # or words that are computed
_INSTANT = 1e-3  # [s] at which the planned speed is read; the ends of its phases besides
_ABOVE = 50e-3  # [m] over the stock, where an unknown start is taken


class Planned(NamedTuple):
    """A program before anything is cut."""

    program: Interpreted
    path: ProgramPath
    tools: ToolSet
    tool: IntArray  # row of the tools of each block
    feed: FloatArray  # [m/s] of each block, infinite for rapid moves of a machine without limits
    block_time: FloatArray  # [s] when each block starts, and the end, shape (blocks + 1,)
    plan: Plan | None  # of a machine
    raw: Raw
    said: tuple[str, ...]  # what was taken for granted
    given: Program  # as it was read: with the diameters of the tools, and a start


def cutters_of(scenario: MillingScenario) -> tuple[Cutter | EndMill, ...]:
    """The tools in their rows."""
    return scenario.tools or ((scenario.tool,) if scenario.tool is not None else ())


def planned(scenario: MillingScenario, raw: Raw) -> Planned:
    """Read the program and plan its motion; the stock is that in its coordinates.

    Raises
    ------
    ScenarioFault
        All that is wrong with stock, tools and program.
    """
    tools = tool_set(cutters_of(scenario), scenario.numerics.stock.elements)
    first = _first_reading(scenario)
    _called(first, tools)
    program, said, given = _read(scenario, raw, first)
    operation, machine = scenario.operation, scenario.machine
    mode = scenario.path_mode if "path_mode" in scenario.model_fields_set else None
    drives = drives_of(machine)
    pace = pace_of(drives) if drives is not None else None
    path = moves_path(
        program, feed=operation.feed, turning=operation.spindle_speed is not None, mode=mode, top=raw.box[2][1], pace=pace,
    )  # fmt: skip
    if operation.spindle_speed is not None:
        path = path._replace(spindle=np.full(path.curve.count, operation.spindle_speed))
    if not path.curve.count:
        raise ScenarioFault([Fault(("program",), "has no motion")])
    rows, told = _tool_rows(path.tool, tools)
    motion, feed = None, path.feed
    if drives is not None:
        limits, axes = motion_limits(drives)
        motion = plan(path.curve, path.feed, limits, path.stop_at, path.dwell_after, axes=axes)
        feed = highest_feeds(path.curve, path.feed, limits, axes)
        times = motion.block_time
    else:
        times = np.concatenate(([0.0], np.cumsum(path.curve.length / path.feed + path.dwell_after)))
        who = "there is no machine" if scenario.robot is None and machine is None else "there are no feed drives"
        said = (*said, f"{who}: feeds are reached at once, and rapid moves take no time")
    return Planned(program, path, tools, rows, feed, times, motion, raw, (*said, *told), given)


def _first_reading(scenario: MillingScenario) -> Interpreted:
    """The program as it is given, to see which tools it calls."""
    assert scenario.program is not None
    return interpret(scenario.program.text, scenario.program.file, setup_of(scenario.program))


def _with_diameters(scenario: MillingScenario, called: tuple[int, ...]) -> Program:
    """The program with a diameter for every tool that cuts: cutter compensation takes that of ``tools`` unless it is given."""
    program = scenario.program
    assert program is not None
    sizes = {tool.number: tool.diameter for tool in scenario.tools}
    if not scenario.tools:
        sizes = dict.fromkeys((number for number in called if number > 0), scenario.tool.diameter)
    given = {tool.number: tool for tool in program.tools or ()}
    entries = []
    for number in sorted({*sizes, *given, *(number for number in called if number > 0)}):
        entry = given.get(number) or ProgramTool(number=number)
        own = entry.diameter is not None or number not in sizes
        entries.append(entry if own else entry.model_copy(update={"diameter": sizes[number]}))
    return program.model_copy(update={"tools": tuple(entries) or None})


def _called(program: Interpreted, tools: ToolSet) -> None:
    """Tools that move and are not there."""
    if not tools.numbers:
        return
    table = program.moves
    moving = np.unique(table.tools[(table.starts != table.ends).any(axis=1)])
    missing = [int(n) for n in moving if n != 0 and int(n) not in tools.numbers]
    if missing:
        names = ", ".join(f"T{n}" for n in missing)
        there = ", ".join(f"T{n}" for n in tools.numbers)
        raise ScenarioFault(
            [Fault(("tools",), f"the program calls {names}, which is not among them ({there}); add it with its shape")]
        )


def _tool_rows(called: IntArray, tools: ToolSet) -> tuple[IntArray, tuple[str, ...]]:
    """Row of the tool of each block."""
    if not tools.numbers:
        return np.zeros(called.size, np.int64), ()
    rows = np.zeros(called.size, np.int64)
    for row, number in enumerate(tools.numbers):
        rows[called == number] = row
    if (called == 0).any():
        return rows, (f"the program moves before it calls a tool: T{tools.numbers[0]}, the first of tools, is taken",)
    return rows, ()


def _read(scenario: MillingScenario, raw: Raw, read: Interpreted) -> tuple[Interpreted, tuple[str, ...], Program]:
    """The program; a start that is not said is taken above the stock, over the first place that the program names."""
    assert scenario.program is not None
    given = _with_diameters(scenario, read.tools)
    beside = any(_COMPENSATED.search(text) for text in (given.text, *(given.subroutines or {}).values()))
    first = interpret(given.text, given.file, setup_of(given)) if beside else read
    if given.start is not None:
        return first, (), given
    table = first.moves
    ends = table.ends
    inside = np.flatnonzero((ends[:, :2] != 0.0).any(axis=1))
    x, y = (float(v) for v in ends[inside[0], :2]) if inside.size else (0.0, 0.0)
    z = max(raw.box[2][1] + _ABOVE, float(ends[:, 2].max(initial=0.0)))
    there = given.model_copy(update={"start": StartPosition.model_construct(x=x, y=y, z=z)})
    program = interpret(given.text, given.file, setup_of(there))
    said = f"program.start is not given: the tool is taken to begin above the stock, at z = {units.show(z, 'length')}"
    return program, (said,), there


def planned_speed(plan_: Plan | None, along: FloatArray, feed: FloatArray) -> FloatArray:
    """Speed at places of the path as a machine plans it, no more than the feed there; without a machine the feed [m/s]."""
    if plan_ is None:
        return feed
    profile = plan_.profile
    instants = np.unique(np.concatenate([profile.time, np.arange(profile.time[0], profile.time[-1], _INSTANT)]))
    position, speed, _ = profile_at(profile, instants)
    return np.minimum(np.interp(along, position, speed), feed)
