"""A program in a stock in 3D: cut move by move, with contact, force and events along the way."""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise import units
from cutwise.io.program_setup import setup_of
from cutwise.maths.curves import FloatArray
from cutwise.maths.envelopes import Segments, line_row, segments
from cutwise.maths.height_map import material, overlap_by, room, volume_of
from cutwise.maths.map_surface import Solid, SurfaceCheck, surface_check
from cutwise.physics.motion.lookahead import Plan, highest_feeds, plan
from cutwise.process.assemble_mill import motion_limits, pace_of
from cutwise.process.edges import linear_coefficients
from cutwise.process.nominal_part import nominal_samples, tolerance_of
from cutwise.process.program_path import ProgramPath, moves_path
from cutwise.process.stock_loop import PIECES, STATION, Run, run_into, run_moves
from cutwise.process.stock_material import Material, Raw, automatic_grid, chosen_grid, material_of, raw_of
from cutwise.process.stock_path import Moves, moves_of
from cutwise.process.stock_tools import ToolSet, tool_set
from cutwise.programs.interpreter import Interpreted, interpret
from cutwise.results import SolverFailure
from cutwise.spec.drives import CncMachine
from cutwise.spec.faults import Fault, ScenarioFault, all_faults
from cutwise.spec.milling import MillingScenario
from cutwise.spec.program import Program, ProgramTool, StartPosition
from cutwise.spec.stock import StockRun

IntArray = npt.NDArray[np.int64]
Progress = Callable[[float], None]

_CHUNK = 4000  # moves between two words about progress
_TOUCH = 1e-6  # [m] deep: a shallower overlap is rounding
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


class StockRunDone(NamedTuple):
    """A program that has been run in a stock in 3D."""

    planned: Planned
    moves: Moves
    solid: Solid
    run: Run
    grid: float  # [m] asked for
    coarsened: bool  # wider than it should be, for memory
    before: float  # volume of the stock [m^3]
    filled: float  # volume of hollows that the map fills up [m^3]
    fixed: FloatArray  # of each move: what it overlaps with fixtures, columns as ``Run.hit``
    start: FloatArray  # the same of the tool where the program begins, shape (5,)
    check: SurfaceCheck | None
    grids: tuple[float, ...]  # that were tried [m]

    @property
    def volume(self) -> FloatArray:
        """Volume that each move takes [m^3]."""
        return volume_of(self.solid.map, self.run.taken)

    def stations(self, name: str) -> FloatArray:
        """A column of all stations."""
        return self.run.found[:, STATION.index(name)]


def stock_key(scenario: MillingScenario) -> Raw:
    """The stock as it is said."""
    assert scenario.stock is not None
    if isinstance(scenario.stock, StockRun):
        raise ScenarioFault([Fault(("stock", "run"), "going on from an earlier run is not supported yet; write the stock as a "
                                   "block, a cylinder or a file (cutwise export RUN surface -o left.stl writes one)")])  # fmt: skip
    return raw_of(scenario.stock, ("stock",))


def planned(scenario: MillingScenario) -> Planned:
    """Read the program and plan its motion.

    Raises
    ------
    ScenarioFault
        All that is wrong with stock, tools and program.
    """
    cutters = scenario.tools or ((scenario.tool,) if scenario.tool is not None else ())
    tools = tool_set(cutters, scenario.numerics.stock.elements)
    all_faults(lambda: stock_key(scenario), lambda: _called(_first_reading(scenario), tools))
    raw = stock_key(scenario)
    program, said = _read(scenario, raw)
    operation, machine = scenario.operation, scenario.machine
    mode = scenario.path_mode if "path_mode" in scenario.model_fields_set else None
    pace = pace_of(machine) if isinstance(machine, CncMachine) else None
    path = moves_path(
        program, feed=operation.feed, turning=operation.spindle_speed is not None, mode=mode, top=raw.box[2][1], pace=pace,
    )  # fmt: skip
    if operation.spindle_speed is not None:
        path = path._replace(spindle=np.full(path.curve.count, operation.spindle_speed))
    if not path.curve.count:
        raise ScenarioFault([Fault(("program",), "has no motion")])
    rows, told = _tool_rows(path.tool, tools)
    motion, feed = None, path.feed
    if isinstance(machine, CncMachine):
        limits, axes = motion_limits(machine)
        motion = plan(path.curve, path.feed, limits, path.stop_at, path.dwell_after, axes=axes)
        feed = highest_feeds(path.curve, path.feed, limits, axes)
        times = motion.block_time
    else:
        times = np.concatenate(([0.0], np.cumsum(path.curve.length / path.feed + path.dwell_after)))
        said = (*said, "there is no machine: feeds are reached at once, and rapid moves take no time")
    return Planned(program, path, tools, rows, feed, times, motion, raw, (*said, *told))


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


def _read(scenario: MillingScenario, raw: Raw) -> tuple[Interpreted, tuple[str, ...]]:
    """The program; a start that is not said is taken above the stock, over the first place that the program names."""
    assert scenario.program is not None
    given = _with_diameters(scenario, _first_reading(scenario).tools)
    first = interpret(given.text, given.file, setup_of(given))
    if given.start is not None:
        return first, ()
    table = first.moves
    ends = table.ends
    inside = np.flatnonzero((ends[:, :2] != 0.0).any(axis=1))
    x, y = (float(v) for v in ends[inside[0], :2]) if inside.size else (0.0, 0.0)
    z = max(raw.box[2][1] + _ABOVE, float(ends[:, 2].max(initial=0.0)))
    there = given.model_copy(update={"start": StartPosition.model_construct(x=x, y=y, z=z)})
    program = interpret(given.text, given.file, setup_of(there))
    said = f"program.start is not given: the tool is taken to begin above the stock, at z = {units.show(z, 'length')}"
    return program, (said,)


def prepare(scenario: MillingScenario) -> None:
    """Build what a run stands on, without running it.

    Raises
    ------
    ScenarioFault
        All that is wrong with program, tools, stock, part and fixtures.
    """
    jobs: list[Callable[[], object]] = [lambda: _sized(scenario, planned(scenario))]
    if scenario.nominal is not None:
        jobs.append(lambda: check_part(scenario))
    jobs += [
        lambda place=place, given=given: raw_of(given, ("fixtures", place))
        for place, given in enumerate(scenario.fixtures)
    ]  # type: ignore[misc]
    all_faults(*jobs)


def _sized(scenario: MillingScenario, ready: Planned, finer: float = 1.0) -> tuple[float, bool]:
    """The grid, and whether it is wider than it should be for memory."""
    numerics = scenario.numerics.stock
    samples = scenario.nominal.samples if scenario.nominal is not None else 0
    radii = [float(r) for r in ready.tools.cutting.radius[np.unique(ready.tool)]]
    asked: float | str = numerics.grid
    if finer != 1.0:
        asked = finer * automatic_grid(ready.raw, radii)
    return chosen_grid(ready.raw, asked, radii, numerics.memory_limit, ready.path.curve.count, samples)


def check_part(scenario: MillingScenario) -> None:
    """Read the nominal part."""
    nominal_samples(scenario, 100)


def run(scenario: MillingScenario, progress: Progress | None = None) -> StockRunDone:
    """Cut the stock; an automatic grid whose surface is too far from the truth is halved once."""
    try:
        ready = planned(scenario)
        for place, given in enumerate(scenario.fixtures):  # faults are told before anything is cut
            raw_of(given, ("fixtures", place))
        if scenario.nominal is not None:
            check_part(scenario)
    except ScenarioFault:
        prepare(scenario)
        raise
    numerics = scenario.numerics.stock
    grid, coarse = _sized(scenario, ready)
    done = _cut(scenario, ready, grid, coarse, progress)
    allowed = 0.1 * tolerance_of(scenario)
    if done.check is not None and done.check.largest > allowed and numerics.grid == "auto" and not coarse:
        try:
            finer, _ = _sized(scenario, ready, 0.5)
        except ScenarioFault:  # memory does not allow it, which the check then says
            return done
        return _cut(scenario, ready, finer, coarse, progress)._replace(grids=(grid, finer))
    return done


def _cut(
    scenario: MillingScenario, ready: Planned, grid: float, coarse: bool, progress: Progress | None
) -> StockRunDone:
    """All moves on one grid."""
    numerics = scenario.numerics.stock
    left = material_of(ready.raw, grid)
    sagitta = 0.1 * tolerance_of(scenario)
    moves = moves_of(ready.path, ready.tool, ready.feed, sagitta, max(left.map.layout.dx, left.map.layout.dy))
    solid = Solid(left.map, left.outline, moves.path, ready.tools.cutting)
    before = material(left.map)
    look = numerics.engagement != "none"
    run_ = _room(moves, numerics.station if look else None)
    start = _start_overlap(solid, ready.tools, moves, int(moves.tool[0]))
    coefficients = linear_coefficients(scenario.material) if scenario.material is not None else None
    for first, last in _stretches(moves.tool):
        teeth = ready.tools.teeth(int(moves.tool[first]), coefficients)
        run_moves(solid, ready.tools.shanks, teeth, run_, (first, last), look, numerics.engagement == "refined")
        if progress is not None:
            progress(0.9 * last / moves.count)
    _all_contact(run_)
    fixed = _fixtures(scenario, solid, ready.tools, moves, grid)
    check = surface_check(solid, numerics.check) if numerics.check else None
    return StockRunDone(
        ready, moves, solid, run_, grid, coarse, before, left.filled, fixed, start, check, (grid,)
    )  # fmt: skip


def _all_contact(run_: Run) -> None:
    """Nothing of a contact may be lost for lack of room.

    Raises
    ------
    SolverFailure
        A contact in more pieces than there is room for.
    """
    full = np.flatnonzero(run_.found[:, STATION.index("contact")] >= PIECES)
    if full.size:
        raise SolverFailure(
            f"the contact of {full.size} stations is in more than {PIECES} pieces: fewer numerics.stock.elements, or "
            "numerics.stock.engagement: none"
        )


def _stretches(tool: IntArray) -> Iterator[tuple[int, int]]:
    """Moves of one tool after another, no more than some thousand at a time."""
    ends = np.append(np.flatnonzero(np.diff(tool)) + 1, tool.size)
    first = 0
    for end in ends.tolist():
        while first < end:
            last = min(first + _CHUNK, end)
            yield first, last
            first = last


def _room(moves: Moves, station: float | None) -> Run:
    """Room for what is found; feed moves have stations."""
    count = moves.count
    lengths = np.add.reduceat(moves.way, moves.path.first[:-1])
    stations = np.zeros(count, np.int64)
    if station is not None:
        stations = np.where(moves.rapid, 0, np.maximum(1, np.ceil(lengths / station - 1e-9)).astype(np.int64) + 1)
    first = np.concatenate(([0], np.cumsum(stations))).astype(np.int64)
    return Run(
        moves.start, moves.end, moves.way, moves.rapid, moves.feed, moves.spindle, first,
        np.zeros((int(first[-1]), len(STATION))), np.zeros(int(first[-1]), np.int64), np.zeros(count, np.int64),
        np.zeros((count, 5)), np.zeros((count, 5)),
    )  # fmt: skip


def _start_overlap(solid: Solid, tools: ToolSet, moves: Moves, tool: int) -> FloatArray:
    """What the tool stands in where the program begins."""
    here = moves.start[0]
    spot: Segments = segments([line_row(tool, here, here)], [1])
    found = np.zeros(5)
    for table in (tools.cutting, tools.shanks):
        if table.first[tool + 1] > table.first[tool]:
            overlap_by(solid.map, spot, table, 0, found, room(solid.map.layout))
    return found


def _fixtures(scenario: MillingScenario, solid: Solid, tools: ToolSet, moves: Moves, grid: float) -> FloatArray:
    """What every move overlaps with fixtures."""
    hit = np.zeros((moves.count, 5))
    for place, given in enumerate(scenario.fixtures):
        fixture: Material = material_of(raw_of(given, ("fixtures", place)), grid)
        for table in (tools.cutting, tools.shanks):
            run_into(fixture.map, solid, table, (0, moves.count), hit)
    return hit


class Event(NamedTuple):
    """Something that a line of the program does to what it should leave alone."""

    kind: str  # rapid, shank, fixture, core
    line: int
    depth: float  # [m]
    volume: float  # [m^3]
    place: tuple[float, float, float]  # [m]
    time: float  # [s] when the move begins


def events(done: StockRunDone) -> list[Event]:
    """One event for each kind and line, the deepest of its moves."""
    found: dict[tuple[str, int], Event] = {}
    for kind, table in (("rapid", done.run.through), ("shank", done.run.hit), ("fixture", done.fixed)):
        for move in np.flatnonzero(table[:, 1] > _TOUCH).tolist():
            row = table[move]
            new = Event(
                kind, int(done.moves.line[move]), float(row[1]), float(row[0]), (float(row[2]), float(row[3]), float(row[4])),
                float(move_time(done, move)),
            )  # fmt: skip
            old = found.get((kind, new.line))
            deeper = new if old is None or new.depth > old.depth else old
            found[kind, new.line] = deeper._replace(volume=new.volume + (old.volume if old is not None else 0.0))
    over = np.flatnonzero(done.stations("over_centre") > 0.0)
    for move in np.unique(np.searchsorted(done.run.station, over, side="right") - 1).tolist():
        end = done.moves.end[done.moves.path.first[move + 1] - 1]
        line = int(done.moves.line[move])
        found.setdefault(
            ("core", line), Event("core", line, 0.0, 0.0, tuple(map(float, end)), float(move_time(done, move)))
        )  # type: ignore[arg-type]
    return sorted(found.values(), key=lambda event: (event.line, event.kind))


def move_time(done: StockRunDone, move: int | IntArray) -> FloatArray:
    """Time at which moves begin [s]."""
    return done.planned.block_time[done.moves.block[done.moves.path.first[move]]]


def station_places(done: StockRunDone) -> FloatArray:
    """Tip at every station [m], shape (s, 3)."""
    segment, share = done.run.segment, done.stations("share")[:, None]
    start, end, row = done.moves.start[segment], done.moves.end[segment], done.moves.path.row[segment]
    point = start + share * (end - start)
    arc = row[:, 0] != 0.0
    angle = row[arc, 13] + share[arc, 0] * row[arc, 14]
    point[arc, 0] = row[arc, 2] + row[arc, 7] * np.cos(angle)
    point[arc, 1] = row[arc, 3] + row[arc, 7] * np.sin(angle)
    return point


def station_moves(done: StockRunDone) -> IntArray:
    """Move of every station."""
    return np.repeat(np.arange(done.moves.count), np.diff(done.run.station))


def station_times(done: StockRunDone) -> FloatArray:
    """Time of every station: blocks are taken to be run evenly [s]."""
    moves = done.moves
    segment = done.run.segment
    block = moves.block[segment]
    begin = np.concatenate(([True], np.diff(moves.block) != 0))
    before = np.cumsum(moves.way) - moves.way
    before = before - before[begin][np.cumsum(begin) - 1]
    length = np.maximum(done.planned.path.curve.length[block], 1e-30)
    share = np.clip((before[segment] + done.stations("share") * moves.way[segment]) / length, 0.0, 1.0)
    times, pause = done.planned.block_time, done.planned.path.dwell_after
    return np.asarray(times[block] + share * (times[block + 1] - pause[block] - times[block]))


def finite(value: float) -> float:
    """A number of a table: infinity is none."""
    return value if math.isfinite(value) else math.nan
