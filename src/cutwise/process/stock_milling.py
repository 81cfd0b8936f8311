"""A program in a stock in 3D: cut move by move, with contact, force and events along the way."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.curves import FloatArray
from cutwise.maths.envelopes import Segments, line_row, segments
from cutwise.maths.height_map import material, volume_of
from cutwise.maths.map_index import SurfaceCheck, index_of, surface_check
from cutwise.maths.map_levels import room
from cutwise.maths.map_sweep import overlap_by
from cutwise.maths.map_volume import VolumeError, volume_error
from cutwise.maths.profiles import Cutters
from cutwise.maths.solid import Solid
from cutwise.maths.workpiece import Frame, Workpiece, under, with_held
from cutwise.physics.motion.lookahead import Plan
from cutwise.process.edges import edges_alike
from cutwise.process.nominal_part import tolerance_of
from cutwise.process.stock_loop import PIECES, STATION, Progress, Run, Teeth, run_into, run_moves
from cutwise.process.stock_material import Material, automatic_grid, chosen_grid, material_of, raw_of
from cutwise.process.stock_path import Moves, moves_of
from cutwise.process.stock_plan import Planned, planned_speed
from cutwise.process.stock_tools import ToolSet
from cutwise.results import SolverFailure
from cutwise.spec.faults import ScenarioFault, all_faults
from cutwise.spec.milling import MillingScenario

IntArray = npt.NDArray[np.int64]

_CHUNK = 4000  # moves between two words about progress


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
    error: VolumeError | None  # of the volumes of moves
    grids: tuple[float, ...]  # that were tried [m]

    @property
    def volume(self) -> FloatArray:
        """Volume that each move takes [m^3]."""
        return volume_of(self.solid.map, self.run.taken)

    def stations(self, name: str) -> FloatArray:
        """A column of all stations."""
        return self.run.found[:, STATION.index(name)]


def prepare_one(scenario: MillingScenario, ready: Planned) -> None:
    """Whether there is room for a set-up.

    Raises
    ------
    ScenarioFault
        Its map needs more memory than allowed.
    """
    grid_of(scenario, ready)


def check_fixtures(scenario: MillingScenario) -> None:
    """Read the fixtures.

    Raises
    ------
    ScenarioFault
        Files that cannot be used.
    """
    all_faults(*(partial(raw_of, given, ("fixtures", place)) for place, given in enumerate(scenario.fixtures)))


def grid_of(scenario: MillingScenario, ready: Planned, finer: float = 1.0) -> tuple[float, bool]:
    """The grid, and whether it is wider than it should be for memory."""
    numerics = scenario.numerics.stock
    samples = scenario.nominal.samples if scenario.nominal is not None else 0
    radii = [float(r) for r in ready.tools.cutting.radius[np.unique(ready.tool)]]
    asked: float | str = numerics.grid
    if finer != 1.0:
        asked = finer * automatic_grid(ready.raw, radii)
    return chosen_grid(ready.raw, asked, radii, numerics.memory_limit, ready.path.curve.count, samples)


class Earlier(NamedTuple):
    """What an earlier set-up has left, in its frame."""

    solid: Solid
    frame: Frame


def run_one(
    scenario: MillingScenario, ready: Planned, frame: Frame, earlier: Callable[[float], Sequence[Earlier]],
    progress: Progress | None = None,
) -> StockRunDone:  # fmt: skip
    """Cut the stock in one set-up; an automatic grid whose surface is too far from the truth is halved once.

    ``earlier``: what was left before, for a grid [m].
    """
    numerics = scenario.numerics.stock
    grid, coarse = grid_of(scenario, ready)
    done = _cut(scenario, ready, (frame, earlier(grid)), grid, coarse, progress)
    allowed = 0.1 * tolerance_of(scenario)
    if done.check is not None and done.check.largest > allowed and numerics.grid == "auto" and not coarse:
        try:
            finer, _ = grid_of(scenario, ready, 0.5)
        except ScenarioFault:  # memory does not allow it, which the check then says
            return done
        return _cut(scenario, ready, (frame, earlier(finer)), finer, coarse, progress)._replace(grids=(grid, finer))
    return done


def workpiece(left: Material, path: Segments, tools: Cutters, frame: Frame, earlier: Sequence[Earlier]) -> Workpiece:
    """The stock before a set-up: its own map, and those of the set-ups before it."""
    solid = Solid(left.map, left.outline, path, tools)
    solids, frames = [solid, *(one.solid for one in earlier)], [frame, *(one.frame for one in earlier)]
    piece = under(solids, frames, frame)
    if not earlier:
        return piece
    return under([solid._replace(map=with_held(left.map, piece)), *solids[1:]], frames, frame)


def _cut(
    scenario: MillingScenario, ready: Planned, where: tuple[Frame, Sequence[Earlier]], grid: float, coarse: bool,
    progress: Progress | None,
) -> StockRunDone:  # fmt: skip
    """All moves on one grid."""
    numerics = scenario.numerics.stock
    left = material_of(ready.raw, grid)
    sagitta = 0.1 * tolerance_of(scenario)
    moves = moves_of(ready.path, ready.tool, ready.feed, sagitta, max(left.map.layout.dx, left.map.layout.dy))
    piece = workpiece(left, moves.path, ready.tools.cutting, *where)
    solid = piece.solid
    before = material(solid.map)
    look = numerics.engagement != "none"
    run_ = _room(moves, numerics.station if look else None, ready.plan)
    start = _start_overlap(solid, ready.tools, moves, int(moves.tool[0]))
    for first, last in stretches(moves.tool):
        teeth = teeth_of(scenario, ready.tools, int(moves.tool[first]))
        run_moves(piece, ready.tools.shanks, teeth, run_, (first, last), look, numerics.engagement == "refined")
        if progress is not None:
            progress(0.9 * last / moves.number)
    all_contact(run_)
    fixed = fixtures_hit(scenario, solid, ready.tools, moves, grid)
    check = error = None
    if numerics.check:
        index = index_of(solid)
        check, error = surface_check(solid, numerics.check, index=index), volume_error(piece, index)
    return StockRunDone(
        ready, moves, solid, run_, grid, coarse, before, left.filled, fixed, start, check, error, (grid,)
    )  # fmt: skip


def teeth_of(scenario: MillingScenario, tools: ToolSet, tool: int) -> Teeth:
    """One tool in the material."""
    return tools.teeth(tool, edges_alike(scenario.material) if scenario.material is not None else None)


def all_contact(run_: Run) -> None:
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


def stretches(tool: IntArray) -> Iterator[tuple[int, int]]:
    """Moves of one tool after another, no more than some thousand at a time."""
    ends = np.append(np.flatnonzero(np.diff(tool)) + 1, tool.size)
    first = 0
    for end in ends.tolist():
        while first < end:
            last = min(first + _CHUNK, end)
            yield first, last
            first = last


def _room(moves: Moves, station: float | None, plan_: Plan | None) -> Run:
    """Room for what is found; feed moves have stations, evenly along them."""
    count = moves.number
    lengths = np.add.reduceat(moves.way, moves.path.first[:-1])
    stations = np.zeros(count, np.int64)
    if station is not None:
        stations = np.where(moves.rapid, 0, np.maximum(1, np.ceil(lengths / station - 1e-9)).astype(np.int64) + 1)
    first = np.concatenate(([0], np.cumsum(stations))).astype(np.int64)
    begin, end = moves.along[moves.path.first[:-1], 0], moves.along[moves.path.first[1:] - 1, 1]
    number = np.arange(int(first[-1])) - np.repeat(first[:-1], stations)
    share = number / np.maximum(np.repeat(stations, stations) - 1, 1)
    along = np.repeat(begin, stations) + share * np.repeat(end - begin, stations)
    return run_room(moves, first, planned_speed(plan_, along, np.repeat(moves.feed, stations)))


def run_room(moves: Moves, first: IntArray, speed: FloatArray) -> Run:
    """Room for what is found at stations; ``first`` of each move, and their number."""
    count, stations = moves.number, int(first[-1])
    return Run(
        moves.start, moves.end, moves.way, moves.rapid, moves.feed, moves.spindle, speed, first,
        np.zeros((stations, len(STATION))), np.zeros(stations, np.int64), np.zeros(count, np.int64),
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


def fixtures_hit(scenario: MillingScenario, solid: Solid, tools: ToolSet, moves: Moves, grid: float) -> FloatArray:
    """What every move overlaps with fixtures."""
    hit = np.zeros((moves.number, 5))
    for place, given in enumerate(scenario.fixtures):
        fixture: Material = material_of(raw_of(given, ("fixtures", place)), grid)
        for table in (tools.cutting, tools.shanks):
            run_into(fixture.map, solid, table, (0, moves.number), hit)
    return hit
