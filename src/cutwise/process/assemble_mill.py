"""From a milling scenario to what the kernels read: path, limits, drives and cut."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.io.programs.given import setup_of
from cutwise.io.programs.interpreter import Interpreted, interpret
from cutwise.io.programs.moves import Move
from cutwise.maths.curves import FloatArray
from cutwise.maths.linearc import Block, LineArc, arc, join, line
from cutwise.paths.pocket import blended, corner
from cutwise.physics.cutting.discs import discs
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.cutting.wall import AVERAGED, DISCS, FLUTES
from cutwise.physics.motion.drives import Controller, Plant
from cutwise.physics.motion.lookahead import AxisLimits
from cutwise.physics.motion.loop import LoopFigures, loop_figures
from cutwise.physics.motion.profile import Limits
from cutwise.physics.structure.modes import Modes, modes
from cutwise.process.assemble import linear_coefficients
from cutwise.process.loops_drives import NO_FORCE, Cut, DrivePair
from cutwise.spec.drives import CncMachine, FeedDrive
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.milling import MillingScenario
from cutwise.spec.program import Blend


class ProgramPath(NamedTuple):
    """The path of a program or corner, block by block."""

    curve: LineArc
    feed: FloatArray  # programmed speed [m/s], infinite for rapid moves, shape (n,)
    cuts: npt.NDArray[np.bool_]  # whether the block cuts, shape (n,)
    stop_at: npt.NDArray[np.bool_]  # inner joints with a stop (G61.1), shape (n - 1,)
    dwell_after: FloatArray  # [s] at the end of each block, shape (n,)
    source: npt.NDArray[np.int64]  # line of the program, 0 for a corner, shape (n,)
    programmed: LineArc  # the path before its corners were blended: what the contour error is measured from
    origin: npt.NDArray[np.int64]  # block of the programmed path that each block came from, shape (n,)


def program_path(scenario: MillingScenario, program: Interpreted | None) -> ProgramPath:
    """The commanded path with its feeds, corners blended where the path mode asks for it."""
    if program is None:
        assert scenario.path is not None
        feed = scenario.operation.feed
        assert feed is not None
        blocks = corner(scenario.path.lead, scenario.path.turn, scenario.path.fillet)
        n = len(blocks)
        return _with_mode(
            blocks, np.full(n, feed), np.ones(n, bool), np.zeros(n), np.zeros(n, np.int64),
            ["exact_path"] * n, [0.0] * n, scenario,
        )  # fmt: skip
    moves = [move for move in program.moves if move.kind != "dwell"]
    _check_covered(moves)
    dwell = np.zeros(len(moves))
    at = -1
    for move in program.moves:
        at += move.kind != "dwell"
        if move.kind == "dwell" and at >= 0:
            dwell[at] += move.dwell
    own = scenario.operation.feed
    return _with_mode(
        [_block(move) for move in moves],
        np.array([move.feed if math.isinf(move.feed) or own is None else own for move in moves]),
        np.array([_cuts(move, scenario.operation.spindle_speed is not None) for move in moves]),
        dwell,
        np.array([move.line for move in moves]),
        [move.mode for move in moves],
        [move.tolerance for move in moves],
        scenario,
    )


def _check_covered(moves: list[Move]) -> None:
    """Milling with drives is that of three axes, and of a spindle that turns to the right while it cuts."""
    faults = []
    left = next((move for move in moves if move.spindle < 0.0), None)
    if left is not None:
        faults.append(f"line {left.line}: the spindle turns to the left (M4); milling is covered for M3 only")
    rotary = next((move for move in moves if move.rotary_start != move.rotary_end), None)
    if rotary is not None:
        faults.append(f"line {rotary.line}: a rotary axis moves; milling is covered for x, y and z only")
    if faults:
        raise ScenarioFault([Fault(("program",), message) for message in faults])


def _with_mode(
    blocks: list[Block], feed: FloatArray, cuts: npt.NDArray[np.bool_], dwell: FloatArray,
    source: npt.NDArray[np.int64], modes_: list[str], tolerances: list[float], scenario: MillingScenario,
) -> ProgramPath:  # fmt: skip
    """The path in its mode: the program's own (G61, G61.1, G64 P), or that of the scenario if it names one."""
    wanted = scenario.path_mode
    if isinstance(wanted, Blend):
        modes_, tolerances = ["blend"] * len(blocks), [wanted.blend] * len(blocks)
    elif "path_mode" in scenario.model_fields_set:
        modes_ = [wanted] * len(blocks)
    free = np.isfinite(feed[:-1]) & np.isfinite(feed[1:]) & (dwell[:-1] == 0.0)
    allowed = [
        tolerance if mode == "blend" and ok else 0.0
        for mode, tolerance, ok in zip(modes_[:-1], tolerances[:-1], free, strict=True)
    ]
    path, origin = blended(blocks, allowed)
    index = np.array(origin)
    last_of_origin = np.append(index[1:] != index[:-1], True)
    stop = np.array([modes_[i] == "exact_stop" for i in origin[:-1]], dtype=bool) & last_of_origin[:-1]
    pause = np.where(last_of_origin, dwell[index], 0.0)
    stop |= pause[:-1] > 0.0
    return ProgramPath(join(path), feed[index], cuts[index], stop, pause, source[index], join(blocks), index)


def _block(move: Move) -> Block:
    if move.kind == "arc":
        rise = sum((b - a) * c for a, b, c in zip(move.start, move.end, move.axis, strict=True))
        return arc(move.start, move.centre, move.sweep, move.axis, rise)
    return line(move.start, move.end)


def _cuts(move: Move, turning: bool) -> bool:
    """A feed move within the stock: below z = 0, not a plunge, the spindle running (or taken to run)."""
    flat = move.kind == "arc" or math.hypot(move.end[0] - move.start[0], move.end[1] - move.start[1]) > 1e-9
    return (
        move.kind in ("feed", "arc")
        and flat
        and min(move.start[2], move.end[2]) < 0.0
        and (turning or move.spindle > 0.0)
    )


def read_program(scenario: MillingScenario) -> Interpreted | None:
    """The moves of the scenario's program; None for a corner."""
    program = scenario.program
    return None if program is None else interpret(program.text, program.file, setup_of(program))


def spindle_speed(scenario: MillingScenario, program: Interpreted | None) -> float:
    """Spindle speed [rad/s]: the operation's, else the program's, which may have one only."""
    if scenario.operation.spindle_speed is not None:
        return scenario.operation.spindle_speed
    assert program is not None
    speeds = {abs(move.spindle) for move in program.moves if move.kind in ("feed", "arc") and move.spindle}
    if len(speeds) != 1:
        found = "no spindle speed (S with M3)" if not speeds else f"{len(speeds)} spindle speeds"
        message = f"the program has {found}; write operation.spindle_speed"
        raise ScenarioFault([Fault(("operation", "spindle_speed"), message)])
    return speeds.pop()


def motion_limits(machine: CncMachine) -> tuple[Limits, AxisLimits | None]:
    """Limits along the path, or of each axis; z is given those of x and y."""
    given = machine.limits
    values = (given.velocity, given.acceleration, given.jerk)
    if given.act_on == "path":
        return Limits(*values), None
    return Limits(math.inf, math.inf, math.inf), AxisLimits(*(np.full(3, value) for value in values))


def drive_pair(machine: CncMachine) -> DrivePair:
    """Both drives under the reading of the gain table that the scenario chose.

    Raises
    ------
    ScenarioFault
        A position loop is unstable; the message gives its margin.
    """
    gains = {"x": _gains(machine.x), "y": _gains(machine.y)}
    if machine.reading != "as_printed":
        gains = {axis: (g[1], g[0], *g[2:]) for axis, g in gains.items()}
    if machine.reading == "matched":
        gains = {"x": gains["y"], "y": gains["x"]}
    c = machine.control
    laws = {axis: Controller(*g, c.sample_time, c.saturation, c.encoder, float(c.delay)) for axis, g in gains.items()}
    pair = DrivePair(_plant(machine.x), laws["x"], _plant(machine.y), laws["y"])
    faults = []
    for axis, figures in zip("xy", loops(pair), strict=True):
        if not figures.stable:
            faults.append(Fault(("machine", axis), _unstable(axis, figures, machine)))
    if faults:
        raise ScenarioFault(faults)
    return pair


def loops(pair: DrivePair) -> tuple[LoopFigures, LoopFigures]:
    """Margins, bandwidth and poles of both axes."""
    return loop_figures(pair.plant_x, pair.law_x), loop_figures(pair.plant_y, pair.law_y)


def _unstable(axis: str, figures: LoopFigures, machine: CncMachine) -> str:
    margin = 20.0 * math.log10(figures.sampled_gain_margin) if figures.sampled_gain_margin > 0.0 else -math.inf
    margin_text = f"gain margin {margin:.1f} dB" if math.isfinite(margin) else "no gain at which it would be stable"
    late = f" and a delay of {machine.control.delay} sample" if machine.control.delay else ""
    return (
        f"the position loop of {axis} is unstable at {1e3 * machine.control.sample_time:g} ms{late}: largest pole "
        f"|z| = {figures.largest_pole:.4g} (stable below 1), {margin_text}, phase margin "
        f"{math.degrees(figures.sampled_phase_margin):.1f}°; lower K_p, or shorten sample_time, or take another "
        f"reading of the gains (now {machine.reading})"
    )


def _gains(drive: FeedDrive) -> tuple[float, float, float, float, float]:
    return drive.K_p, drive.K_i, drive.K_d, drive.K_1, drive.K_2


def _plant(drive: FeedDrive) -> Plant:
    f = drive.friction
    return Plant(
        drive.K_a, drive.K_t, drive.J, drive.B, drive.r_g, f.stiction_plus, f.stiction_minus, f.coulomb_plus,
        f.coulomb_minus, f.decay_plus, f.decay_minus, f.rise_plus, f.rise_minus, drive.backlash,
    )  # fmt: skip


def cut(scenario: MillingScenario, spindle: float) -> Cut:
    """The cutting force that acts on the drives."""
    tool, numerics = scenario.tool, scenario.numerics
    law = {"none": NO_FORCE, "averaged": AVERAGED, "tooth_resolved": DISCS if numerics.discs else FLUTES}[
        numerics.force
    ]
    radius, depth = 0.5 * tool.diameter, scenario.operation.axial_depth
    return Cut(
        law,
        Mill(radius, tool.flutes, tool.helix),
        discs(radius, tool.helix, depth, tool.flutes, numerics.discs or 1),
        linear_coefficients(scenario.material),
        depth,
        spindle,
    )


def tip_modes(scenario: MillingScenario) -> Modes | None:
    """Modes of the tool tip, if any are given."""
    given = scenario.tool.modes
    if not given:
        return None
    return modes(
        np.array([2.0 * math.pi * mode.frequency for mode in given]),
        np.array([mode.damping for mode in given]),
        np.array([mode.stiffness for mode in given]),
        np.array([[1.0, 0.0] if mode.direction == "x" else [0.0, 1.0] for mode in given]),
    )
