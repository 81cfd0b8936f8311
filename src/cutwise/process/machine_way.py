"""The way of a pass on a machine: where the tool point is to go in the part, and what the axes are told for it."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise import units
from cutwise.io.programs.given import setup_of
from cutwise.io.programs.interpreter import interpret
from cutwise.maths import chains
from cutwise.maths.frames import FloatArray
from cutwise.maths.linearc import LineArc, at_blocks, join, line
from cutwise.physics.motion.setpoints import DependentAxesError, beyond, setpoints
from cutwise.physics.motion.volumetric import Axes
from cutwise.process.program_path import ProgramPath, moves_path, program_speed
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.geometry_errors import LINEAR_AXES
from cutwise.spec.machine import Machine
from cutwise.spec.machine_pass import FromCutting, MachinePath, ProgramPass
from cutwise.spec.machine_scenario import MachineScenario

IntArray = npt.NDArray[np.int64]


class Way(NamedTuple):
    """A pass, ``m`` places along it; rapid moves of a program are left out."""

    time: FloatArray  # [s] of feed, shape (m,)
    travel: FloatArray  # [m] of feed, shape (m,)
    commands: FloatArray  # of each joint [m or rad], shape (m, n)
    point: FloatArray  # ideal tool point in the part [m], shape (m, 3)
    direction: FloatArray  # of the feed in the part, unit, shape (m, 3)
    feed: FloatArray  # [m/s], shape (m,)
    cuts: npt.NDArray[np.bool_]  # whether the tool is taken to cut there, shape (m,)
    line: IntArray  # of the program, 0 for a path, shape (m,)
    curve: LineArc | None  # path of the tool point in the part, where the tool keeps its direction
    curve_cuts: npt.NDArray[np.bool_]  # of its blocks
    block: IntArray  # block of the curve, shape (m,)
    along: FloatArray  # arc length of the curve [m], rapid moves counted, shape (m,)
    spindle: float | None  # [rad/s], if the cut needs it


def machine_way(scenario: MachineScenario, axes: Axes, *, samples: int | None = None) -> Way:
    """The way of the scenario's path or program.

    Parameters
    ----------
    scenario : MachineScenario
        With a path or a program.
    axes : Axes
        Its machine.
    samples : int, optional
        Replaces the number of places; 3 are the start, the middle and the end.

    Raises
    ------
    ScenarioFault
        The program leads an axis beyond its travel; every such axis is named.
    """
    if scenario.program is not None:
        return _program_way(scenario, scenario.program, axes, samples)
    assert scenario.path is not None
    return _path_way(scenario, scenario.path, axes, samples)


def joints_of(machine: Machine) -> dict[str, int]:
    """Place of each axis letter among the joints of the chain."""
    return {body.joint.command: i for i, body in enumerate(machine.ordered[1:]) if body.joint and body.joint.command}


def _path_way(scenario: MachineScenario, path: MachinePath, axes: Axes, samples: int | None) -> Way:
    joints, corners = joints_of(scenario.machine), path.corners()
    tip = np.array(scenario.tool.tip)
    lengths = [math.dist(*([c[axis] for axis in LINEAR_AXES] for c in pair)) for pair in pairwise(corners)]
    at = np.concatenate([[0.0], np.cumsum(lengths)])
    travel = np.linspace(0.0, at[-1], samples or path.samples)
    commands = np.zeros((len(travel), len(axes.errors)))
    turns = np.zeros((len(corners), len(axes.errors)))
    for letter, joint in joints.items():
        turns[:, joint] = [corner[letter] for corner in corners]
        commands[:, joint] = np.interp(travel, at, turns[:, joint])
    block = np.clip(np.searchsorted(at, travel, side="right") - 1, 0, len(lengths) - 1)
    ends = chains.tool_point(chains.frames(axes.chain, turns * axes.sense), tip)
    point = chains.tool_point(chains.frames(axes.chain, commands * axes.sense), tip)
    direction = np.gradient(point, axis=0)
    curve, turning = None, axes.chain.kinds == chains.REVOLUTE
    if not np.ptp(turns[:, turning], axis=0).any():
        moved = [i for i, length in enumerate(lengths) if length > 0.0]
        curve = join([line(ends[i], ends[i + 1]) for i in moved])
        block = np.searchsorted(moved, block)
        direction = curve.along[block]
    feed, spindle = path.feed, _spindle(scenario)
    return Way(
        travel / feed, travel, commands, point, _unit(direction), np.full(len(travel), feed), np.ones(len(travel), bool),
        np.zeros(len(travel), np.int64), curve, np.ones(0 if curve is None else curve.count, bool), block, travel, spindle,
    )  # fmt: skip


def _program_way(scenario: MachineScenario, program: ProgramPass, axes: Axes, samples: int | None) -> Way:
    cut = scenario.load.force
    turning = isinstance(cut, FromCutting) and cut.spindle_speed is not None
    moves = interpret(program.text, program.file, setup_of(program))
    path = moves_path(moves, feed=None, turning=turning or not isinstance(cut, FromCutting), mode=None)
    block, along, travel = _feed_places(path, samples, program.samples)
    point, direction = at_blocks(path.curve, block, along)
    rotary = np.zeros((len(block), len(axes.errors)))
    tip, zero = np.array(scenario.tool.tip), np.array(program.zero)
    curve: LineArc | None = None
    if program.words == "part":
        point = point + zero
        try:
            commands = setpoints(axes, tip, point, rotary)
        except DependentAxesError as error:
            raise ScenarioFault([Fault(("program",), f"cannot be run: {error}")]) from None
        if not rotary.any():
            curve = path.curve._replace(start=path.curve.start + zero)
    else:
        commands = rotary
        joints = joints_of(scenario.machine)
        commands[:, [joints[letter] for letter in LINEAR_AXES]] = point + zero
        point = chains.tool_point(chains.frames(axes.chain, commands * axes.sense), tip)
        direction = _through(axes, commands, tip, direction, [joints[letter] for letter in LINEAR_AXES])
    faults = list(_travel_faults(scenario, axes, commands, path.source[block]))
    if faults:
        raise ScenarioFault(faults)
    feed = path.feed[block]
    step = np.diff(travel, prepend=0.0)
    spindle = _spindle(scenario)
    if spindle is None and isinstance(cut, FromCutting):
        spindle = program_speed(moves, ("load", "force", "spindle_speed"))
    return Way(
        np.cumsum(step / feed), travel, commands, point, _unit(direction), feed, path.cuts[block], path.source[block],
        curve, path.cuts, block, path.curve.knots[block] + along, spindle,
    )  # fmt: skip


def _feed_places(path: ProgramPath, samples: int | None, usual: int) -> tuple[IntArray, FloatArray, FloatArray]:
    """Blocks, arc lengths in them and feed travelled, at places spread over the feed moves, ends of blocks included."""
    feeding = np.flatnonzero(np.isfinite(path.feed))
    length = path.curve.length[feeding]
    before = np.concatenate([[0.0], np.cumsum(length)])
    if samples == 3:
        travel = before[-1] * np.array([0.0, 0.5, 1.0])
        place = np.clip(np.searchsorted(before, travel, side="right") - 1, 0, len(feeding) - 1)
        return feeding[place], travel - before[place], travel
    parts = np.maximum(1, np.rint((samples or usual) * length / before[-1]).astype(int))
    block = np.repeat(np.arange(len(feeding)), parts + 1)
    along = np.concatenate([np.linspace(0.0, size, count + 1) for size, count in zip(length, parts, strict=True)])
    return feeding[block], along, before[block] + along


def _through(axes: Axes, commands: FloatArray, tip: FloatArray, direction: FloatArray, joints: list[int]) -> FloatArray:
    """Direction of the tool point in the part while the linear axes move along a direction of commands."""
    q = commands * axes.sense
    lever = chains.jacobian(axes.chain, q, tip)[:, :3, joints] * axes.sense[joints]
    return np.einsum("mij,mj->mi", lever, direction)


def _travel_faults(scenario: MachineScenario, axes: Axes, commands: FloatArray, line: IntArray) -> list[Fault]:
    letters = {joint: letter for letter, joint in joints_of(scenario.machine).items()}
    found = []
    for joint, place, command in beyond(axes, commands):
        letter = letters[joint]
        dimension = "length" if letter in LINEAR_AXES else "angle"
        there, low, high = (units.show(v, dimension) for v in (command, axes.low[joint], axes.high[joint]))
        message = (
            f"line {line[place]} leads axis {letter} to {there}, beyond its travel of {low} to {high}; shift "
            "program.zero, or take another machine"
        )
        found.append(Fault(("program",), message))
    return found


def _spindle(scenario: MachineScenario) -> float | None:
    return scenario.load.force.spindle_speed if isinstance(scenario.load.force, FromCutting) else None


def _unit(vector: FloatArray) -> FloatArray:
    return vector / np.maximum(np.linalg.norm(vector, axis=1, keepdims=True), 1e-300)
