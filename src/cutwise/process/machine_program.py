"""The way of a program on a machine: tool centre point control or positions of the axes, rotary axes included."""

import math
from collections.abc import Iterator

import numpy as np

from cutwise import units
from cutwise.io.program_setup import setup_of
from cutwise.maths import chains
from cutwise.maths.frames import FloatArray
from cutwise.maths.linearc import at_blocks, carried, extremes
from cutwise.physics.engagement.path_sweep import swept_path
from cutwise.physics.motion.setpoints import DependentAxesError, setpoints
from cutwise.physics.motion.volumetric import Axes
from cutwise.process.machine_path import (
    IntArray,
    ToolPath,
    along_rates,
    beyond_travel,
    given_speed,
    joints_of,
    places,
)
from cutwise.process.program_path import ProgramPath, moves_path, program_speed
from cutwise.process.stock_moves import StockMoves, moves_into_stock, stock_of
from cutwise.programs.interpreter import Interpreted, interpret
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.geometry_errors import LINEAR_AXES, ROTARY_AXES
from cutwise.spec.machine_pass import FromCutting, ProgramPass
from cutwise.spec.machine_scenario import MachineScenario
from cutwise.spec.program import top_of

_ARC_STEP = math.radians(10)  # of an arc or a rotary axis between places
_TURN_STEP = math.radians(1)  # of a rotary axis between places whose travel is checked


class _Follower:
    """What the axes do along the blocks of a program."""

    def __init__(self, scenario: MachineScenario, program: ProgramPass, axes: Axes, path: ProgramPath) -> None:
        self.axes, self.path = axes, path
        self.tip, self.zero = np.array(scenario.tool.tip), np.array(program.zero)
        joints = joints_of(scenario.carrying)
        self.linear = [joints[letter] for letter in LINEAR_AXES]
        self.rotary = {joints[letter]: k for k, letter in enumerate(ROTARY_AXES) if letter in joints}
        self.by_point = program.words == "part"
        self.machine = scenario.carrying

    def rotary_rates(self, block: IntArray) -> FloatArray:
        """Change of each joint's command per way, the linear ones left out, shape (m, n)."""
        rates = np.zeros((len(block), len(self.axes.errors)))
        for joint, k in self.rotary.items():
            change = self.path.rotary[block, 1, k] - self.path.rotary[block, 0, k]
            rates[:, joint] = change / self.path.curve.length[block]
        return rates

    def commands(self, block: IntArray, along: FloatArray, *, end: bool = False) -> FloatArray:
        """Of all joints at places of blocks; ``end`` takes their ends instead."""
        way = self.path.curve.length[block] if end else along
        q = self.rotary_rates(block) * way[:, None]
        for joint, k in self.rotary.items():
            q[:, joint] += self.path.rotary[block, 0, k]
        point = at_blocks(self.path.curve, block, way)[0] + self.zero
        if self.by_point:
            return setpoints(self.axes, self.tip, point, q)
        q[:, self.linear] = point
        return q

    def frame(self) -> tuple[FloatArray, FloatArray] | None:
        """Turn and shift of the program's coordinates into the part, where the tool keeps its direction in all moves.

        None where it turns, and where the linear axes are not at right angles: arcs are no arcs then.
        """
        feeding = np.flatnonzero(np.isfinite(self.path.feed))
        if np.ptp(self.path.rotary[feeding].reshape(-1, 3), axis=0).any():
            return None
        if self.by_point:
            return np.eye(3), self.zero
        block, none = feeding[:1], np.zeros(1)
        q = self.commands(block, none)
        turn = chains.jacobian(self.axes.chain, q * self.axes.sense, self.tip)[0, :3, self.linear].T
        turn = turn * self.axes.sense[self.linear]
        if np.abs(turn.T @ turn - np.eye(3)).max() > 1e-9:
            return None
        at = chains.tool_point(chains.frames(self.axes.chain, q * self.axes.sense), self.tip)[0]
        return turn, at - turn @ at_blocks(self.path.curve, block, none)[0][0]

    def motion(self, block: IntArray, along: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Commands, tool point in the part [m], its direction, and its speed [m/s]."""
        q = self.commands(block, along)
        point, tangent = at_blocks(self.path.curve, block, along)
        feed = self.path.feed[block]
        if self.by_point:
            return q, point + self.zero, tangent, feed
        rates = self.rotary_rates(block)
        rates[:, self.linear] = tangent
        direction, ratio = along_rates(self.axes, q, self.tip, rates)
        reached = chains.tool_point(chains.frames(self.axes.chain, q * self.axes.sense), self.tip)
        return q, reached, direction, feed * ratio

    def travel_faults(self, name: str) -> Iterator[Fault]:
        """Axes that are led beyond their travel, rapid moves too: each once, where it is worst."""
        block, along = self._farthest()
        commands = self.commands(block, along)
        for place, message in beyond_travel(self.machine, self.axes, commands, "shift program.zero"):
            yield Fault((), message, file=name, line=int(self.path.source[block[place]]), column=1)

    def _farthest(self) -> tuple[IntArray, FloatArray]:
        """Places at which axes may be farthest out: ends of blocks, and what of them bends between."""
        path, found = self.path, []
        turned = np.abs(path.rotary[:, 1] - path.rotary[:, 0]).max(axis=1)
        directions = np.eye(3)
        for i in range(path.curve.count):
            size = float(path.curve.length[i])
            inside = np.zeros(0)
            if np.isfinite(path.feed[i]) and turned[i] > 0.0:
                inside = np.linspace(0.0, size, math.ceil(turned[i] / _TURN_STEP) + 1)[:-1]
            elif not path.curve.straight[i]:
                if self.by_point:
                    directions = self._rows(i)
                inside = np.concatenate([extremes(path.curve, i, row) for row in directions])
            found.append(np.append(inside, size))
        block = np.repeat(np.arange(path.curve.count), [len(part) for part in found])
        return block, np.concatenate(found)

    def _rows(self, i: int) -> FloatArray:
        """Change of each linear command per way of the tool point, with the rotary axes of a block, shape (3, 3)."""
        q = self.commands(np.array([i]), np.zeros(1)) * self.axes.sense
        return np.asarray(
            np.linalg.inv(chains.jacobian(self.axes.chain, q, self.tip)[0, :3, self.linear].T), dtype=float
        )


def program_tool_path(
    scenario: MachineScenario, program: ProgramPass, axes: Axes, *, samples: int | None = None
) -> ToolPath:
    """The way of a program; corners are run as they are programmed, without blends.

    Parameters
    ----------
    scenario : MachineScenario
        What the program belongs to.
    program : ProgramPass
        Its text, and how it stands on the machine.
    axes : Axes
        The machine.
    samples : int, optional
        Replaces the number of places.

    Raises
    ------
    ScenarioFault
        The program has no feed move, turns an axis that the machine does not have, leads axes beyond their travel (all
        of them are named), or cuts nowhere though there is something that needs a cut.
    """
    cut = scenario.load.force
    turning = isinstance(cut, FromCutting) and cut.spindle_speed is not None
    moves = interpret(program.text, program.file, setup_of(program))
    faults = list(_missing_axes(scenario, program, moves))
    if faults:
        raise ScenarioFault(faults)
    top = top_of(program, scenario.stock)
    path = moves_path(
        moves, feed=None, turning=turning or not isinstance(cut, FromCutting), mode="exact_path", top=top, rotary=True
    )
    follower = _Follower(scenario, program, axes, path)
    try:
        faults = list(follower.travel_faults(program.file))
    except DependentAxesError as error:
        faults = [Fault(("program",), f"cannot be run: {error}")]
    faults += _no_cut(scenario, path, top)
    spindle = given_speed(scenario)
    if spindle is None and isinstance(cut, FromCutting):
        try:
            spindle = program_speed(moves, ("load", "force", "spindle_speed"))
        except ScenarioFault as fault:
            faults += fault.faults
    if faults:
        raise ScenarioFault(faults)
    feeding = np.flatnonzero(np.isfinite(path.feed))
    at = places(path.curve.length[feeding], samples or program.samples, _least_parts(path)[feeding])
    block = feeding[at.block]
    commands, point, direction, feed = follower.motion(block, at.along)
    frame = follower.frame()
    step = np.diff(at.travel, prepend=0.0)
    into = StockMoves()
    if scenario.stock is not None and frame is not None:
        into = moves_into_stock(path, swept_path(path.curve, 0.5 * scenario.tool.diameter), stock_of(scenario.stock))
    return ToolPath(
        np.cumsum(step / path.feed[block]), at.travel, commands, point, direction, feed, path.cuts[block],
        path.source[block], carried(path.curve, *frame) if frame else None, path.cuts, block,
        path.curve.knots[block] + at.along, spindle, path.still, into,
    )  # fmt: skip


def _least_parts(path: ProgramPath) -> IntArray:
    """Parts that each block has at least, so that no arc and no turn of a rotary axis is stepped over."""
    bent = np.zeros(path.curve.count) + path.curve.share * path.curve.length / path.curve.radius
    turned = np.maximum(bent, np.abs(path.rotary[:, 1] - path.rotary[:, 0]).max(axis=1))
    return np.maximum(1, np.ceil(turned / _ARC_STEP - 1e-9)).astype(np.int64)


def _missing_axes(scenario: MachineScenario, program: ProgramPass, moves: Interpreted) -> Iterator[Fault]:
    """Rotary words for axes that the machine does not have, each axis once."""
    there = scenario.carrying.axes()
    for k, letter in enumerate(ROTARY_AXES):
        line = next((move.line for move in moves.moves.turning() if move.rotary_start[k] != move.rotary_end[k]), None)
        if letter not in there and line is not None:
            message = f"turns axis {letter}, which the machine does not have; it has {', '.join(there)}"
            yield Fault((), message, file=program.file, line=line, column=1)


def _no_cut(scenario: MachineScenario, path: ProgramPath, top: float) -> Iterator[Fault]:
    """A program that never gets to where it cuts, though a force or a wall is asked for."""
    if path.cuts.any() or (scenario.load.force is None and scenario.surface is None):
        return
    feeding = np.flatnonzero(np.isfinite(path.feed))
    ends = at_blocks(path.curve, feeding, path.curve.length[feeding])[0]
    least = units.show(float(min(ends[:, 2].min(), path.curve.start[feeding, 2].min())), "length")
    key = "stock.z" if scenario.stock is not None else "program.top"
    reason = "the spindle does not turn (S with M3)" if path.still else f"its feed moves go down to z = {least} only"
    yield Fault(
        ("program",),
        f"cuts nowhere: feed moves in the plane below z = {units.show(top, 'length')} cut ({key}), and {reason}",
    )
