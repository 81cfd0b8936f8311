"""What milling with CNC drives amounts to: the run, its numbers and its curves."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.program_setup import setup_of
from cutwise.later import later
from cutwise.maths.curves import FloatArray
from cutwise.maths.linearc import sample
from cutwise.physics.cutting.wall import DELAYED
from cutwise.physics.motion.contour import contour_errors
from cutwise.physics.motion.driven import SetPoints
from cutwise.physics.motion.drives import Drive, axes_of
from cutwise.physics.motion.lookahead import Plan, highest_feeds, plan
from cutwise.physics.motion.loop import LoopFigures
from cutwise.physics.motion.nearest import nearest_along
from cutwise.physics.motion.reference import Reference, central_difference, sampled
from cutwise.physics.structure.modes import Modes
from cutwise.process.assemble_mill import (
    cut,
    divided_by,
    feed_drives,
    loops,
    motion_limits,
    program_path,
    read_program,
    spindle_limits,
    spindle_speed,
    tip_modes,
)
from cutwise.process.carriage import on_machine
from cutwise.process.loops_drives import Cut, DriveHistory, run_drives
from cutwise.process.milling_contact import Contact, SteadyCuts, contact, steady_cuts
from cutwise.process.milling_stability import TipStability, tip_stability
from cutwise.process.program_path import ProgramPath
from cutwise.programs.interpreter import Interpreted, interpret
from cutwise.spec.faults import Fault, ScenarioFault, all_faults
from cutwise.spec.milling import MillingScenario

if TYPE_CHECKING:
    from cutwise.process import milling_wall
else:
    milling_wall = later("cutwise.process.milling_wall")

Progress = Callable[[float], None]

MOST_APART = 1e-3  # [m] between a corrected path and the wanted one
MOST_SAMPLES = 20_000_000  # of the controllers in a run: some gigabytes of histories


class StopCost(NamedTuple):
    """What full stops cost that need not be; pauses and places where the path turns back are left out."""

    share: float = 0.0  # of the cycle time
    corners: int = 0  # stops at corners between blocks
    asked: int = 0  # stops by exact stop (G61.1), or for a change of tool


class MillRun(NamedTuple):
    """A finished run with everything that is read off it."""

    path: ProgramPath
    plan: Plan
    reference: Reference
    wanted: ProgramPath  # what the part is meant to be: the same path, unless program.wanted names another
    place: Reference  # where on the wanted path the tool is meant to be at the same instants
    contact: Contact
    drives: tuple[Drive, ...]  # of x, y, and z if it has one
    loops: tuple[LoopFigures, ...]
    cut: Cut
    history: DriveHistory
    contour_error: FloatArray  # from the programmed path [m], shape (n,), NaN on rapid moves
    drive_error: FloatArray  # from the path that is driven, its blends included [m], shape (n,), NaN on rapid moves
    feed: FloatArray  # programmed, or the highest that the machine may run [m/s], shape (blocks,)
    steady: SteadyCuts
    tip_swings: bool  # whether the tool tip moves on modes in the loop
    stop_cost: StopCost
    wall: milling_wall.WallRun | None  # of a straight wall that is milled in the loop
    chatter: TipStability | None = None  # whether the tip of a tool that yields chatters
    helped: bool = True  # what would be stable is looked for and run

    @property
    def lost(self) -> float | None:
        """Time at which the tip had swung so far that nothing is known from there on [s]; None if it never did."""
        known = self.history.known
        return float(self.reference.time[known]) if known < self.reference.time.size else None


class Commanded(NamedTuple):
    """What drives are told along a path, and what the tool meets there."""

    path: ProgramPath
    plan: Plan
    reference: Reference
    wanted: ProgramPath
    place: Reference  # on the wanted path
    contact: Contact
    cut: Cut
    drives: tuple[Drive, ...]
    order: SetPoints
    substeps: int  # of a servo step


def commanded(scenario: MillingScenario, substeps: int) -> Commanded:
    """Plan and sample the path of a scenario; find what its tool meets."""
    program = read_program(scenario)
    path, motion = _planned(scenario, program)
    spindle = spindle_speed(scenario, program)
    sample_time = scenario.drives.control.sample_time
    substeps *= divided_by(sample_time, scenario.numerics.substeps, scenario.time_step)
    reference = sampled(path.curve, [motion.profile], sample_time, scenario.numerics.settling_time)
    wanted = wanted_path(scenario)
    place = reference if wanted is None else placed_on(wanted, path, reference)
    wanted = wanted or path
    met = contact(scenario, wanted, place)
    drives = feed_drives(scenario.drives, scenario.drives_key)
    order = set_points(reference, sample_time, len(drives), place)
    return Commanded(
        path, motion, reference, wanted, place, met, cut(scenario, spindle, met.depth), drives, order, substeps
    )


def followed(
    scenario: MillingScenario, told: Commanded, order: SetPoints, progress: Progress | None = None
) -> DriveHistory:
    """What the drives do when they are told ``order``, in the contact of the path that was planned."""
    tip = _swinging(scenario, told)
    return run_drives(
        order, told.contact.patches, told.drives, told.cut, told.substeps, progress, modes=tip,
        tip_limit=tip_limit(scenario),
    )  # fmt: skip


def _swinging(scenario: MillingScenario, told: Commanded) -> Modes | None:
    """Modes of the tip, if it swings on them in the loop."""
    return tip_modes(scenario) if told.cut.law == DELAYED and not milling_wall.on_loop(scenario) else None


def contour_error(told: Commanded, position: FloatArray) -> FloatArray:
    """Distance of actual positions from the wanted path, positive to its right [m]; NaN on rapid moves."""
    wanted, block = told.wanted, told.place.block
    error = contour_errors(wanted.programmed, wanted.origin[block], position, True)
    error[np.isinf(wanted.feed[block])] = np.nan
    return error


def run(scenario: MillingScenario, substeps: int, progress: Progress | None = None) -> MillRun:
    """Plan, sample, and let the drives follow under the cutting force."""
    told = commanded(scenario, substeps)
    path, reference, place, wanted = told.path, told.reference, told.place, told.wanted
    wall = None
    if milling_wall.on_loop(scenario):
        axes = axes_of(told.drives, told.substeps)
        log, wall = milling_wall.wall_run(scenario, reference, told.order, axes, told.substeps, progress)
        history = DriveHistory(*log, np.empty((0, 3)), np.empty((0, 4)), len(reference.time))
    else:
        history = followed(scenario, told, told.order, progress)
    error = contour_error(told, history.position)
    driven = error
    if wanted.blended:
        driven = contour_errors(wanted.curve, place.block, history.position, True)
        driven[np.isinf(wanted.feed[place.block])] = np.nan
    limits, axes_limits = motion_limits(scenario.drives)
    feed = highest_feeds(path.curve, path.feed, limits, axes_limits)
    smooth = told.cut._replace(edges=told.cut.edges._replace(runout=0.0))
    cut_at = feed if wanted is path else highest_feeds(wanted.curve, wanted.feed, limits, axes_limits)
    return MillRun(
        path,
        told.plan,
        reference,
        wanted,
        place,
        told.contact,
        told.drives,
        loops(told.drives),
        told.cut,
        history,
        error,
        driven,
        feed,
        steady_cuts(scenario, wanted, place, told.contact, cut_at, smooth),
        _swinging(scenario, told) is not None,
        stop_cost(path, told.plan, scenario),
        wall,
    )


def wanted_path(scenario: MillingScenario) -> ProgramPath | None:
    """The path that the part is meant to have, where ``program.wanted`` names one."""
    program = scenario.program
    if program is None or program.wanted is None:
        return None
    read = interpret(program.wanted.text, program.wanted.file, setup_of(program))
    return program_path(scenario, read)


def placed_on(wanted: ProgramPath, path: ProgramPath, reference: Reference) -> Reference:
    """Where on the wanted path a tool is meant to be that is told another: the nearest place, going on from the last.

    Raises
    ------
    ScenarioFault
        The path leaves the wanted one by more than a corrected path does.
    """
    travelled, off = nearest_along(wanted.curve, reference.point, reference.travelled)
    travelled = np.where(reference.travelled >= path.curve.knots[-1], wanted.curve.knots[-1], travelled)
    worst = int(np.argmax(off))
    if not off[worst] <= MOST_APART:
        line = int(path.source[reference.block[worst]])
        raise ScenarioFault([Fault(("program", "wanted"), (
            f"the program leaves this path by {units.show(float(off[worst]), 'length', 3)} at its line {line}, which is no "
            f"correction: at most {units.show(MOST_APART, 'length')}; name the program that it corrects"
        ))])  # fmt: skip
    point, direction, block = sample(wanted.curve, wanted.curve.knots, travelled)
    return reference._replace(travelled=travelled, point=point, direction=direction, block=block)


def tip_limit(scenario: MillingScenario) -> float:
    """How far the tip may swing before the tool is elsewhere than its contact: out of the cut, or by its own radius [m]."""
    depth = scenario.operation.radial_depth
    return 0.5 * scenario.tool.diameter if scenario.stock is not None or depth is None else depth


def _planned(scenario: MillingScenario, program: Interpreted | None) -> tuple[ProgramPath, Plan]:
    """The commanded path and its motion, if there are not too many samples in it."""
    path = program_path(scenario, program)
    limits, axes = motion_limits(scenario.drives)
    motion = plan(path.curve, path.feed, limits, path.stop_at, path.dwell_after, axes=axes)
    step, time = scenario.drives.control.sample_time, motion.profile.duration + scenario.numerics.settling_time
    if not time <= MOST_SAMPLES * step:
        raise too_many_samples(scenario, step, time)
    return path, motion


def too_many_samples(scenario: MillingScenario, step: float, time: float) -> ScenarioFault:
    """What is wrong where a motion takes so long [s] that its samples of ``step`` [s] cannot be held."""
    return ScenarioFault([Fault((*scenario.drives_key.split("."), "control", "sample_time"), (
        f"of {1e3 * step:.3g} ms makes {time / step:.2g} samples of the {units.show(time, 'time', 3)} that the "
        f"motion takes, more than {MOST_SAMPLES:.0e}: raise it, or feed and limits of the motion, or shorten the path"
    ))])  # fmt: skip


def stop_cost(path: ProgramPath, motion: Plan, scenario: MillingScenario) -> StopCost:
    """The motion once more, run through all of its corners."""
    if motion.stops == 0:
        return StopCost()
    limits, axes = motion_limits(scenario.drives)
    through = plan(path.curve, path.feed, limits, None, path.dwell_after, axes=axes, stop_at_corners=False)
    asked = int((path.stop_at & (path.dwell_after[:-1] <= 0.0)).sum())
    return StopCost(
        1.0 - through.profile.duration / motion.profile.duration, max(motion.stops - through.stops - asked, 0), asked
    )


def prepare(scenario: MillingScenario) -> None:
    """Build what a run stands on, without running it.

    Raises
    ------
    ScenarioFault
        The program cannot be run, has no spindle speed or feed, takes too long, or a position loop is unstable.
    """
    program = read_program(scenario)
    all_faults(
        lambda: _planned(scenario, program),
        lambda: spindle_limits(scenario.drives, spindle_speed(scenario, program)),
        lambda: feed_drives(scenario.drives, scenario.drives_key),
        lambda: _wall(scenario),
    )


def _wall(scenario: MillingScenario) -> None:
    """The bodies along the wall, if there is one."""
    if scenario.line is not None:
        on_machine(scenario, milling_wall.stations_of(scenario))


def set_points(reference: Reference, sample_time: float, axes: int, place: Reference | None = None) -> SetPoints:
    """What the first ``axes`` of x, y and z are told at the servo instants; heading and way are those of ``place``."""
    place = place or reference
    point = np.ascontiguousarray(reference.point[:, :axes])
    heading = np.arctan2(place.direction[:, 1], place.direction[:, 0])
    return timed(point, heading, place.travelled, sample_time)


def timed(point: FloatArray, heading: FloatArray, along: FloatArray, sample_time: float) -> SetPoints:
    """Set points with the rates that follow from them."""
    velocity = central_difference(point, sample_time)
    return SetPoints(point, velocity, central_difference(velocity, sample_time), heading, along)


def wall_left(done: MillRun) -> FloatArray:
    """Least and greatest error of the wall left on the right at each servo instant, positive into it [m]; shape (n, 2)."""
    return done.contour_error[:, None] + done.history.left[:, :2]


def stability(scenario: MillingScenario, done: MillRun) -> TipStability | None:
    """Whether the tip chatters in steady cuts; None for a rigid tool."""
    tip = tip_modes(scenario)
    if tip is None or not done.steady.width:
        return None
    if scenario.line is not None:  # modes are along x and y of the machine, steady cuts along the feed
        c, s = done.reference.direction[0, :2]
        tip = tip._replace(direction=tip.direction @ np.array([[c, -s], [s, c]]))
    return tip_stability(done.cut, tip, done.steady.width)
