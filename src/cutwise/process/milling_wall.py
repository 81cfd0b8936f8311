"""A wall milled on a machine: its drives, its bodies and the tool's tip in one loop, and one error of the wall."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr

from cutwise import loop, units
from cutwise.maths.curves import FloatArray
from cutwise.paths.carried import CarriedPath, line
from cutwise.physics.cutting.flutes import MeanFlutes, ToothFlutes
from cutwise.physics.engagement.shoulder import SEEN
from cutwise.physics.motion.driven import DriveLog, SetPoints, driven_tool
from cutwise.physics.motion.drives import Axis
from cutwise.physics.motion.reference import Reference
from cutwise.physics.structure.series_compliance import translation_at
from cutwise.process import carriers, spindles, walls, yielding
from cutwise.process.carriage import Carriage, Terms, off_surface, on_machine
from cutwise.process.carriage import in_series as series
from cutwise.process.chain_compliance import BodiesAlong, tool_point_at_zero
from cutwise.process.edges import edges
from cutwise.process.labels import Column, Coordinate, Group, Over
from cutwise.process.loops_drives import STANDSTILL, DriveHistory
from cutwise.process.passes import on_path, stepped, structure_of, too_soft, unsolved
from cutwise.results import Finding, SolverFailure
from cutwise.spec.base import known
from cutwise.spec.milling import MillingScenario
from cutwise.spec.milling_machine import MillingMachine

_STILL = 1e-12  # [m] that a commanded axis may move and still be at rest

LIMITS = (
    "Bodies, part and tip modes yield without inertia, under the mean force of the cut at half the axial depth; weights and "
    "geometric errors of the axes are left out.",
    "The arc of contact is as wide and as deep as drives, bodies and tip leave it; the wall is read where the tool passes.",
)


class WallRun(NamedTuple):
    """What the wall is left with, at the servo instants, n of them; process axes (x feed, y off the work, z up)."""

    path: CarriedPath  # stations, in the part
    carriage: Carriage
    terms: Terms
    time: FloatArray  # [s], shape (n,)
    state: FloatArray  # columns of the terms, shape (n, k)
    moved: dict[str, FloatArray]  # displacement of the tool by each term where the wall is read [m], shape (n, 3)
    drives: FloatArray  # deviation by the drives [m], shape (n, 3)
    tangential: FloatArray  # mean tangential force [N], shape (n,)
    turned: FloatArray  # tilt of the tool about the feed [rad], shape (n,)
    counted: npt.NDArray[np.bool_]  # where the tool is in the cut, shape (n,)
    slot: bool  # both sides are walls
    height: float  # over the tip, where the wall is read [m]
    travelled: FloatArray  # [m] of the path at these instants, shape (n,)

    @property
    def bodies(self) -> BodiesAlong | None:
        """The bodies of the machine along the wall, if they yield."""
        return self.carriage.bodies

    @property
    def total(self) -> FloatArray:
        """Displacement by drives and all terms [m], shape (n, 3)."""
        return np.asarray(self.drives + sum(self.moved.values()))

    @property
    def wall(self) -> FloatArray:
        """Error of the wall, positive into the part [m], shape (n,)."""
        return np.asarray(-self.total[:, 1])

    @property
    def worst(self) -> int:
        """Instant of the cut at which the wall is off most."""
        return int(np.argmax(np.where(self.counted, np.abs(self.wall), -1.0)))


def on_loop(scenario: MillingScenario) -> bool:
    """Whether the wall follows from a cell of the loop: a straight wall and a force, the tool without modes that swing."""
    swings = scenario.numerics.force == "tooth_resolved" and bool(scenario.tool.modes)
    return scenario.line is not None and scenario.numerics.force != "none" and not swings


def stations_of(scenario: MillingScenario) -> CarriedPath:
    """Stations of the wall in the part; a line of two coordinates lies at the height of the machine's tool point."""
    assert scenario.line is not None
    given = known(scenario.line.line)
    start, end = np.array(given.start), np.array(given.end)
    machine = scenario.machine
    if given.flat and isinstance(machine, MillingMachine):
        start[2] = end[2] = tool_point_at_zero(machine, np.array(machine.tip))[2]
    up = scenario.operation.milling == "up"
    return line(start, end, np.array([0.0, 0.0, -1.0]), scenario.numerics.station, work_on_left=up)


def wall_run(
    scenario: MillingScenario, reference: Reference, order: SetPoints, axes: tuple[Axis, ...], substeps: int,
    progress: Callable[[float], None] | None = None,
) -> tuple[DriveLog, WallRun]:  # fmt: skip
    """Drives, force and yielding terms stepped together along the wall.

    Raises
    ------
    SolverFailure
        No displacement was found that its own force gives.
    """
    operation = scenario.operation
    assert operation.axial_depth is not None
    assert operation.radial_depth is not None
    assert scenario.line is not None
    path = stations_of(scenario)
    carriage = on_machine(scenario, path)
    tool = scenario.tool if scenario.modes_at_rest or scenario.tool.stiffness is not None else None
    terms = (*spindles.pistons_of(scenario.compliant), *series(tool, carriage, off_surface(scenario.part_stiffness)))
    up, averaged = operation.milling == "up", scenario.numerics.force == "averaged"
    begins, ends = scenario.line.cut_from or 0.0, float(path.at[-1])
    engagement, given = walls.engagement_of(scenario, begins, ends, STANDSTILL), edges(scenario.material, scenario.tool)
    flutes = (MeanFlutes if averaged else ToothFlutes)(
        walls.mill_of(scenario), given._replace(runout=0.0) if averaged else given, engagement.mill.spindle_speed, up
    )
    motion = driven_tool(axes, order, substeps, -1.0 if up else 1.0, -operation.radial_depth)
    cell = loop.Cell(motion, engagement, (), flutes, structure_of(terms))
    step = axes[0].law.sample_time

    def soft(place: float) -> SolverFailure:
        return too_soft(on_path(place), "reduce operation.axial_depth", "the machine")

    history = stepped(
        cell, lambda row: soft(float(np.interp(row[0], reference.time, reference.travelled))),
        duration=len(reference.time) * step, time_step=step / substeps, seen=SEEN, layers=1, contacts=1,
        stride=substeps, progress=progress,
    )  # fmt: skip
    table, lost = history.table, unsolved(history, terms)
    if lost.size:
        raise soft(float(reference.travelled[int(lost[0])]))
    height, state = 0.5 * operation.axial_depth, history.columns
    moved, turned = yielding.by_term(terms, state, height), yielding.turned(terms, state)
    counted = (reference.travelled >= begins) & (reference.travelled < ends)
    drives = _deviation(reference, order, motion.log, motion.side)
    return motion.log, WallRun(
        path,
        carriage,
        terms,
        table[:, 0],
        state,
        moved,
        drives,
        history.tangential,
        turned,
        counted,
        walls.is_slot(scenario),
        height,
        reference.travelled,
    )


def findings(scenario: MillingScenario, done: WallRun) -> Iterator[Finding]:
    """What leaves nothing to be judged of a spindle that yields."""
    if scenario.compliant is not None:
        yield from spindles.findings(
            scenario.compliant, done.time, done.state, done.moved["pistons"][:, 1], done.counted
        )


def _deviation(reference: Reference, order: SetPoints, log: DriveLog, side: float) -> FloatArray:
    """Actual position against the commanded one in process axes [m], shape (n, 3)."""
    off = log.position - order.point
    found = np.zeros((len(reference.time), 3))
    c, s = np.cos(order.heading), np.sin(order.heading)
    found[:, 0] = off[:, 0] * c + off[:, 1] * s
    found[:, 1] = side * (off[:, 1] * c - off[:, 0] * s)
    found[:, 2] = off[:, 2] if off.shape[1] > 2 else 0.0
    return found


def measures(done: WallRun) -> dict[str, float]:
    """Wall and floor, what each term gives to them, and how stiff the machine is; SI."""
    if not done.counted.any():
        return {}
    found = walls.measures(done.wall[done.counted], 0.0 - done.total[done.counted, 2], slot=done.slot)
    if not done.terms and not done.drives[:, 2].any():
        found = {name: value for name, value in found.items() if not name.startswith("floor")}
    found |= yielding.term_measures({"drives": done.drives, **done.moved}, done.counted, done.worst)
    if done.bodies is not None:
        found["wall_tilt_max"] = float(np.abs(done.turned[done.counted]).max())
        found |= yielding.stiffness_of(translation_at(done.bodies.total, done.height)[:, 1, 1])
    return found


_OVER: Over = {"time": Coordinate(lambda run: run.reference.time, "s", "time"), "axis": "xyz"}
COLUMNS = {
    "deviation_drives": Column("time axis", lambda run: run.wall.drives, "m",
                               "deviation by the drives: along the feed, off the work, up"),
    "wall_error": Column("time", lambda run: np.where(run.wall.counted, run.wall.wall, np.nan), "m",
                         "error of the wall, positive into the part"),
    "floor_error": Column("time", lambda run: np.where(run.wall.counted, -run.wall.total[:, 2], np.nan), "m",
                          "error of the floor, positive into the part"),
}  # fmt: skip


def stages(done: WallRun) -> dict[str, Group | xr.Dataset]:
    """Histories of the terms, and the bodies one by one along the path."""
    moved = carriers.deflections(done.moved, "the wall", "time", _OVER)
    groups: dict[str, Group | xr.Dataset] = {"structure": moved._replace(columns={**COLUMNS, **moved.columns})}
    if done.bodies is not None:
        rows = np.clip(np.searchsorted(done.travelled, done.path.at), 0, len(done.time) - 1)
        groups["carrier"] = carriers.bodies(done.carriage, done.height, done.moved["bodies"][rows])
    return groups


def notes(
    scenario: MillingScenario, done: WallRun, reference: Reference, history: DriveHistory
) -> dict[str, str]:  # fmt: skip
    """The worst place and what it is made of; axes that stand still and are held there by friction."""
    told = {}
    if done.counted.any():
        row = done.worst
        when = f", t = {units.show(reference.time[row], 'time', 4)}"
        told["wall"] = walls.note(
            reference.travelled[row], done.wall[row], {"drives": done.drives, **done.moved}, row, when
        )
        told |= carriers.notes(done.carriage, done.height, float(reference.travelled[row]), done.moved, row)
    told |= dict(_standing(scenario, reference, history))
    return told


def _standing(
    scenario: MillingScenario, reference: Reference, history: DriveHistory
) -> Iterator[tuple[str, str]]:  # fmt: skip
    """Axes that are not commanded to move, and what holds them."""
    for a, axis in enumerate("xyz"[: history.position.shape[1]]):
        drive = getattr(scenario.drives, axis)
        if float(np.ptp(reference.point[:, a])) > _STILL or float(np.ptp(history.position[:, a])) > _STILL:
            continue
        torque = float(history.force_peak[:, a].max()) * drive.r_g
        pushed = float(history.force[:, a].sum()) >= 0.0
        holds = drive.friction.stiction_plus if pushed else -drive.friction.stiction_minus
        yield (
            f"standing_{axis}",
            (
                f"The {axis} axis is not moved and stays exactly where it is: the cut turns it with "
                f"{units.show(torque, 'moment', 3)}, friction holds {units.show(holds, 'moment', 3)}."
            ),
        )
