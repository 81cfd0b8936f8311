"""From a milling scenario to what the kernels read: path, limits, drives and cut."""

import math

import numpy as np

from cutwise import units
from cutwise.io.program_setup import setup_of
from cutwise.maths.linearc import join, line
from cutwise.paths.pocket import corner
from cutwise.physics.cutting.discs import discs
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.cutting.uneven import even_and_linear
from cutwise.physics.cutting.wall import AVERAGED, DELAYED, DISCS, FLUTES
from cutwise.physics.motion.drives import Controller, Drive, Plant
from cutwise.physics.motion.lookahead import AxisLimits
from cutwise.physics.motion.loop import LoopFigures, largest_pole, loop_figures
from cutwise.physics.motion.profile import Limits
from cutwise.physics.structure.modes import Modes, modes
from cutwise.process.drive_remedies import GainKeys, remedies
from cutwise.process.edges import edges
from cutwise.process.loops_drives import NO_FORCE, Cut
from cutwise.process.program_path import Pace, ProgramPath, blocks_path, moves_path, program_speed
from cutwise.programs.interpreter import Interpreted, interpret
from cutwise.spec.base import known
from cutwise.spec.drives import CncMachine, FeedDrive
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.milling import CornerPath, MillingScenario
from cutwise.spec.program import StockBlock, top_of

_DISCS = 20  # where the scenario names no number


def program_path(scenario: MillingScenario, program: Interpreted | None) -> ProgramPath:
    """The commanded path: that of the program, or the corner."""
    operation = scenario.operation
    if program is not None:
        mode = scenario.path_mode if "path_mode" in scenario.model_fields_set else None
        assert scenario.program is not None
        stock = scenario.stock if isinstance(scenario.stock, StockBlock) else None
        return moves_path(
            program, feed=operation.feed, turning=operation.spindle_speed is not None, mode=mode,
            top=top_of(scenario.program, stock), pace=pace_of(scenario.drives),
        )  # fmt: skip
    assert operation.feed is not None
    if scenario.line is not None:
        ends = known(scenario.line.line)
        return blocks_path(
            join([line(ends.start, ends.end)]), np.full(1, operation.feed), np.ones(1, bool), "exact_path"
        )
    assert isinstance(scenario.path, CornerPath)
    blocks = corner(scenario.path.lead, scenario.path.turn, scenario.path.fillet)
    n = len(blocks)
    return blocks_path(join(blocks), np.full(n, operation.feed), np.ones(n, bool), scenario.path_mode)


def read_program(scenario: MillingScenario) -> Interpreted | None:
    """The moves of the scenario's program; None for a corner."""
    program = scenario.program
    return None if program is None else interpret(program.text, program.file, setup_of(program))


def spindle_speed(scenario: MillingScenario, program: Interpreted | None) -> float:
    """Spindle speed [rad/s]: the operation's, else the program's, which may have one only."""
    if scenario.operation.spindle_speed is not None:
        return scenario.operation.spindle_speed
    assert program is not None
    return program_speed(program, ("operation", "spindle_speed"))


def spindle_limits(machine: CncMachine, speed: float) -> dict[str, float]:
    """Power [W] and torque [N m] that the spindle has at a speed [rad/s], by the measures that they limit.

    Raises
    ------
    ScenarioFault
        A curve does not reach to this speed.
    """
    given = {"cutting_power_max": machine.spindle_power, "spindle_torque_max": machine.spindle_torque}
    found, faults = {}, []
    for name, curve in given.items():
        if curve is None:
            continue
        at, most = curve.points()
        if not at[0] * (1.0 - 1e-9) <= speed <= at[-1] * (1.0 + 1e-9):
            ends = " to ".join(units.show(one, "angular_speed", 5) for one in (at[0], at[-1]))
            key = "spindle_power" if name.startswith("cutting") else "spindle_torque"
            faults.append(Fault(("machine", key), f"reaches from {ends}; the spindle turns with "
                                f"{units.show(speed, 'angular_speed', 5)}"))  # fmt: skip
            continue
        found[name] = float(np.interp(speed, at, most))
    if faults:
        raise ScenarioFault(faults)
    return found


def motion_limits(machine: CncMachine) -> tuple[Limits, AxisLimits | None]:
    """Limits along the path, or of each axis; z is given those of x and y."""
    given = machine.limits
    values = (given.velocity, given.acceleration, given.jerk)
    if given.act_on == "path":
        return Limits(*values), None
    return Limits(math.inf, math.inf, math.inf), AxisLimits(*(np.full(3, value) for value in values))


def divided_by(sample_time: float, substeps: int, longest: float) -> int:
    """The least whole number by which so many steps of a servo step [s] are divided for none to be longer than a time [s]."""
    return max(1, math.ceil(sample_time / substeps / longest - 1e-9))


def pace_of(machine: CncMachine) -> Pace:
    """What the path may do in any direction."""
    given = machine.limits
    return Pace(given.velocity, given.acceleration, given.jerk)


def feed_drives(machine: CncMachine, section: str = "machine") -> tuple[Drive, ...]:
    """The drives of x, y and z, if it has one, under the reading of the gain table; ``section`` is their dotted key.

    Raises
    ------
    ScenarioFault
        A position loop is unstable; the message gives its margin.
    """
    given = {axis: drive for axis in "xyz" if (drive := getattr(machine, axis)) is not None}
    gains = {axis: _gains(drive) for axis, drive in given.items()}
    keys = {axis: GainKeys(*(f"{section}.{axis}.{key}" for key in ("K_p", "K_i", "K_d"))) for axis in given}
    if machine.reading != "as_printed":
        gains = {axis: (g[1], g[0], *g[2:]) for axis, g in gains.items()}
        keys = {axis: GainKeys(k.integral, k.proportional, k.derivative) for axis, k in keys.items()}
    if machine.reading == "matched":
        gains |= {"x": gains["y"], "y": gains["x"]}
        keys |= {"x": keys["y"], "y": keys["x"]}
    c = machine.control
    laws = {axis: Controller(*g, c.sample_time, c.saturation, c.encoder, float(c.delay)) for axis, g in gains.items()}
    drives = tuple(Drive(_plant(drive), laws[axis]) for axis, drive in given.items())
    faults = []
    for axis, drive in zip(given, drives, strict=True):
        if largest_pole(*drive) >= 1.0:
            figures = loop_figures(*drive)  # what the message tells takes a hundred times as long as the poles
            helps = remedies(drive.plant, drive.law, keys[axis])
            faults.append(Fault((*section.split("."), axis), _unstable(axis, figures, machine, helps, section)))
    if faults:
        raise ScenarioFault(faults)
    return drives


def loops(drives: tuple[Drive, ...]) -> tuple[LoopFigures, ...]:
    """Margins, bandwidth and poles of every axis."""
    return tuple(loop_figures(*drive) for drive in drives)


def _unstable(axis: str, figures: LoopFigures, machine: CncMachine, helps: list[str], section: str) -> str:
    margin = 20.0 * math.log10(figures.sampled_gain_margin) if figures.sampled_gain_margin > 0.0 else -math.inf
    margin_text = f"gain margin {margin:.1f} dB" if math.isfinite(margin) else "no smaller gain makes it stable"
    phase = figures.sampled_phase_margin
    phase_text = f"phase margin {math.degrees(phase):.1f}°" if phase < math.pi else "the gain never crosses 1"
    late = f" and a delay of {machine.control.delay} sample" if machine.control.delay else ""
    other = "" if len(machine.readings) == 1 else f"; or take another {section}.reading (now {machine.reading})"
    return (
        f"the position loop of {axis} is unstable at {1e3 * machine.control.sample_time:g} ms{late}: largest pole "
        f"|z| = {figures.largest_pole:.4g} (stable below 1), {margin_text}, {phase_text}; stable is "
        f"{', or '.join(helps) if helps else 'no single change of a gain or the sample time that was tried'}{other}"
    )


def _gains(drive: FeedDrive) -> tuple[float, float, float, float, float]:
    return drive.K_p, drive.K_i, drive.K_d, drive.K_1, drive.K_2


def _plant(drive: FeedDrive) -> Plant:
    f = drive.friction
    return Plant(
        drive.K_a, drive.K_t, drive.J, drive.B, drive.r_g, f.stiction_plus, f.stiction_minus, f.coulomb_plus,
        f.coulomb_minus, f.decay_plus, f.decay_minus, f.rise_plus, f.rise_minus, drive.backlash,
    )  # fmt: skip


def cut(scenario: MillingScenario, spindle: float, depth: float) -> Cut:
    """The cutting force that acts on drives and tool tip; the mill is cut into discs up to the greatest depth [m].

    Tooth by tooth, the quick laws of :mod:`cutwise.physics.cutting.wall` serve where they hold: linear edges, no run-out,
    a rigid tool. Everything else takes its chips from the true positions of the tool.
    """
    tool, numerics = scenario.tool, scenario.numerics
    given = edges(scenario.material, tool)
    law = {"none": NO_FORCE, "averaged": AVERAGED, "tooth_resolved": DISCS if numerics.discs else FLUTES}[
        numerics.force
    ]
    if numerics.force == "averaged":
        given = given._replace(runout=0.0)  # it has no mean over a revolution
    elif numerics.force == "tooth_resolved" and (tool.modes or not even_and_linear(given)):
        law = DELAYED
    radius, depth = 0.5 * tool.diameter, depth or 1e-3  # any height, where nothing is met
    count = numerics.discs or (_DISCS if law == DELAYED else 1)
    return Cut(
        law,
        Mill(radius, tool.flutes, tool.helix),
        discs(radius, tool.helix, depth, tool.flutes, count),
        given,
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
