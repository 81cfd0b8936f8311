"""The surface that comes off the machine: the program once more, its tool moved by drives, its own bending and its carrier."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise import units
from cutwise.maths.curves import FloatArray
from cutwise.maths.map_index import surface_check
from cutwise.maths.workpiece import Frame
from cutwise.process.assemble_mill import feed_drives
from cutwise.process.nominal_part import tolerance_of
from cutwise.process.stock_carrier import TERMS, Carrier, Driven, carrier_of, driven, reference_of, terms_at, tips_of
from cutwise.process.stock_loop import Progress, Run, part_of
from cutwise.process.stock_material import Raw, material_of, room_for
from cutwise.process.stock_milling import (
    Earlier,
    StockRunDone,
    all_contact,
    fixtures_hit,
    run_room,
    stretches,
    teeth_of,
    workpiece,
)
from cutwise.process.stock_path import Moves
from cutwise.process.stock_pieces import Known, pieces_of
from cutwise.process.stock_plan import Planned, cutters_of, planned_speed
from cutwise.process.stock_stations import station_along, station_headings, station_moves
from cutwise.process.stock_tools import tool_set
from cutwise.process.stock_yielding import Yielding, run_yielding
from cutwise.results import SolverFailure
from cutwise.spec.faults import Fault, ScenarioFault, all_faults
from cutwise.spec.milling import MillingScenario
from cutwise.spec.milling_machine import drives_of

IntArray = npt.NDArray[np.int64]

_PUSH = np.array([0.0, 1.0, 0.0])  # [N] for which a robot chooses its posture before a cut is known
YIELDING = frozenset({"tip", "bodies", "arm"})  # what yields to the force of the cut
_ALIKE = 1e-9  # [m] beside which two places of the path are one


class Real(NamedTuple):
    """A program as the cell runs it."""

    done: StockRunDone  # its moves are those of the moved tool
    off: FloatArray  # of the tool from its path at the start and the end of each segment [m], shape (n, 2, 3)
    known: FloatArray  # the part of it by drives and sag
    driven: Driven | None
    carrier: Carrier | None
    terms: tuple[str, ...]  # what moves the tool
    change: float | None  # of the offset in the cut when pieces are halved [m]; None where no force moves the tool
    missed: float  # of what drives do between the ends of pieces, at the most [m]
    spacing: float  # [m] of the pieces, at the most


def prepare_real(scenario: MillingScenario, ready: Planned) -> None:
    """What a check finds out of what moves the tool.

    Raises
    ------
    ScenarioFault, Infeasible
        A drive is unstable, an axis led beyond its travel, or the path out of reach.
    """
    terms, plan = moves_the_tool(scenario), ready.plan
    jobs: list[Callable[[], object]] = []
    if "drives" in terms and plan is not None:
        jobs.append(lambda: feed_drives(scenario.drives, scenario.drives_key))
        jobs.append(lambda: reference_of(scenario, ready.path, plan))
    if {"bodies", "arm"} & set(terms):
        jobs.append(lambda: carrier_of(scenario, ready.path, _PUSH))
    all_faults(*jobs)


class Cut(NamedTuple):
    """A program as it is planned, and as the cell runs it."""

    ideal: StockRunDone
    real: Real | None  # where something moves the tool beside its path

    @property
    def left(self) -> StockRunDone:
        """What makes the surface."""
        return self.ideal if self.real is None else self.real.done


def moves_the_tool(scenario: MillingScenario) -> tuple[str, ...]:
    """What moves the tool beside its path, by name: nothing where the surface is ideal."""
    if scenario.numerics.stock.sweep == "ideal":
        return ()
    named = {
        "drives": drives_of(scenario.machine) is not None,
        "runout": any(tool.runout for tool in cutters_of(scenario)),
        "tip": bool(tips_of(scenario).any()),
        "bodies": bool(getattr(scenario.machine, "chain", None)),
        "arm": scenario.robot is not None,
    }
    return tuple(name for name, there in named.items() if there)


def real(
    scenario: MillingScenario,
    ideal: StockRunDone,
    where: tuple[Frame, Sequence[Earlier]],
    progress: Progress | None = None,
) -> Real | None:
    """Sweep what the cell makes of a program; None where nothing moves the tool beside its path.

    ``where``: the frame of the set-up, and what the moved tools of those before it have left.

    Drives feel the force of the planned path; structures that of the stock which the moved tool has left.

    Raises
    ------
    SolverFailure
        What carries the tool is too soft for the cut.
    """
    terms = moves_the_tool(scenario)
    if not terms:
        return None
    force = station_forces(ideal)
    along, pushes = _pushes(ideal, force)
    ready = ideal.planned
    drives = None
    if "drives" in terms:
        assert ready.plan is not None
        drives = driven(scenario, ready.path, ready.plan, along, pushes, part_of(progress, 0.0, 0.3))
    most = force[int(np.argmax(np.linalg.norm(force, axis=1)))] if len(force) else np.zeros(3)
    carrier = carrier_of(scenario, ready.path, most)
    station = scenario.numerics.stock.station
    feels = bool(force.any()) and bool(set(terms) & YIELDING)
    once = _swept(
        scenario, ideal, where, (drives, carrier), terms, station, part_of(progress, 0.3, 0.6 if feels else 1.0)
    )
    if not feels:
        return once
    again = _swept(scenario, ideal, where, (drives, carrier), terms, 0.5 * station, part_of(progress, 0.6, 1.0))
    return again._replace(change=_change(once, again))


def station_forces(done: StockRunDone) -> FloatArray:
    """Mean force on the tool at the stations, at the planned speed, in program axes [N], shape (n, 3)."""
    ahead, aside, up = (done.stations(f"push_{axis}") for axis in "xyz")
    ux, uy = station_headings(done).T
    return np.column_stack([ahead * ux - aside * uy, ahead * uy + aside * ux, up])


def _pushes(done: StockRunDone, force: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Force along the path, with none on rapid moves [m], [N]."""
    moves, rapid = done.moves, np.flatnonzero(done.moves.rapid)
    ends = np.column_stack([moves.along[moves.path.first[rapid], 0], moves.along[moves.path.first[rapid + 1] - 1, 1]])
    where = np.concatenate([station_along(done), ends.ravel()])
    move = np.concatenate([station_moves(done), np.repeat(rapid, 2)])
    order = np.lexsort((where, move))
    if not order.size:
        return np.zeros(1), np.zeros((1, 3))
    return where[order], np.concatenate([force, np.zeros((2 * rapid.size, 3))])[order]


def _swept(
    scenario: MillingScenario, ideal: StockRunDone, where: tuple[Frame, Sequence[Earlier]],
    by: tuple[Driven | None, Carrier | None], terms: tuple[str, ...], station: float, progress: Progress | None,
) -> Real:  # fmt: skip
    """One sweep with pieces no longer than a station [m]."""
    ready, (drives, carrier) = ideal.planned, by
    tools = tool_set(cutters_of(scenario), scenario.numerics.stock.elements, real=True)
    left = material_of(ready.raw, ideal.grid)
    cell = max(left.map.layout.dx, left.map.layout.dy)
    sagitta = 0.1 * tolerance_of(scenario)
    moves, between = pieces_of(ideal.moves, station, sagitta, cell, drives.known if drives else None)
    _room_for(scenario, ready.raw, ideal.grid, len(moves.way))
    known = known_at(moves, drives.known if drives else None, carrier)
    piece = workpiece(left, moves.path, tools.cutting, *where)
    solid = piece.solid
    look = scenario.numerics.stock.engagement != "none"
    run_ = _stations(ideal, moves, look)
    off = np.zeros_like(known)
    place = terms_at(carrier, moves.start) if carrier is not None else np.zeros((len(moves.way), TERMS))
    matrix = carrier.matrix if carrier is not None else np.zeros((TERMS, 3, 3))
    tips, pushed = tips_of(scenario), np.zeros(3)
    refined = scenario.numerics.stock.engagement == "refined"
    for first, last in stretches(moves.tool):
        tool = int(moves.tool[first])
        yielding = Yielding(known, place, matrix, tips[tool], off)
        teeth = teeth_of(scenario, tools, tool)
        run_yielding(piece, tools.shanks, teeth, run_, (first, last), (look, refined), yielding, pushed)
        _held(tools.cutting.radius[tool], moves.path.first[[first, last]], off[:, 1] - known[:, 1])
        if progress is not None:
            progress(last / moves.number)
    all_contact(run_)
    numerics = scenario.numerics.stock
    check = surface_check(solid, numerics.check) if numerics.check else None
    made = ideal._replace(
        moves=moves,
        solid=solid,
        run=run_,
        check=check,
        fixed=fixtures_hit(scenario, solid, tools, moves, ideal.grid),
    )
    return Real(made, off, known, drives, carrier, terms, None, between, station)


def known_at(moves: Moves, drives: Known | None, carrier: Carrier | None) -> FloatArray:
    """Offsets by drives and by the sag of an arm at the start and the end of segments [m], shape (n, 2, 3)."""
    off = np.zeros((len(moves.way), 2, 3))
    for k, point in enumerate((moves.start, moves.end)):
        if drives is not None:
            off[:, k] += drives.at(moves.along[:, k])
        if carrier is not None:
            off[:, k] += terms_at(carrier, point) @ carrier.sag
    return off


def _stations(ideal: StockRunDone, moves: Moves, look: bool) -> Run:
    """A station at the start of each piece of a feed move, and one at its end."""
    count = np.where(moves.rapid | (not look), 0, np.diff(moves.path.first) + 1)
    first = np.concatenate(([0], np.cumsum(count))).astype(np.int64)
    number = np.arange(int(first[-1])) - np.repeat(first[:-1], count)
    segment = np.repeat(moves.path.first[:-1], count) + number
    ends = number == np.repeat(count, count) - 1
    along = np.where(ends, moves.along[segment - ends, 1], moves.along[segment - (ends & (number > 0)), 0])
    return run_room(moves, first, planned_speed(ideal.planned.plan, along, np.repeat(moves.feed, count)))


def _room_for(scenario: MillingScenario, raw: Raw, grid: float, pieces: int) -> None:
    numerics = scenario.numerics.stock
    samples = scenario.nominal.samples if scenario.nominal is not None else 0
    needed = room_for(raw, grid, pieces, samples)
    if needed > 1e6 * numerics.memory_limit:
        raise ScenarioFault([Fault(("numerics", "stock", "memory_limit"), (
            f"{numerics.memory_limit} MB do not hold the {pieces} pieces in which the moved tool is swept "
            f"({needed / 1e6:.0f} MB): raise it, write a longer numerics.stock.station, or numerics.stock.sweep: ideal"
        ))])  # fmt: skip


def _held(radius: float, segments: IntArray, pushed: FloatArray) -> None:
    """A tool that is pushed aside by its own radius is nowhere."""
    size = float(np.linalg.norm(pushed[segments[0] : segments[1]], axis=1).max())
    if not size <= radius:
        raise SolverFailure(
            f"the force of the cut pushes the tool aside by {units.show(size, 'length', 3)}, more than its radius: tool or "
            "carrier are too soft for this cut, or numerics.stock.station is too long"
        )


def _change(once: Real, again: Real) -> float:
    """Largest difference of the offsets at the places that both have [m]."""
    a, b = once.done.moves.along[:, 0], again.done.moves.along[:, 0]
    at = np.searchsorted(b, a - _ALIKE)
    there = np.flatnonzero((at < b.size) & (np.abs(b[np.minimum(at, b.size - 1)] - a) <= _ALIKE))
    if not there.size:
        return 0.0
    return float(np.abs(once.off[there, 0] - again.off[at[there], 0]).max())
