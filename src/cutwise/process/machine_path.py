"""The way of a pass on a machine: where the tool point is to go in the part, and what the axes are told for it."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise import units
from cutwise.maths import chains
from cutwise.maths.frames import FloatArray
from cutwise.maths.linearc import LineArc, join, line
from cutwise.physics.motion.setpoints import beyond
from cutwise.physics.motion.volumetric import Axes
from cutwise.process.stock_moves import StockMoves
from cutwise.spec.geometry_errors import LINEAR_AXES
from cutwise.spec.machine import Machine
from cutwise.spec.machine_pass import CutSurface, FromCutting, MachinePath
from cutwise.spec.machine_scenario import MachineScenario

IntArray = npt.NDArray[np.int64]


class ToolPath(NamedTuple):
    """A pass, ``m`` places along it; rapid moves of a program are left out."""

    time: FloatArray  # [s] of feed, shape (m,)
    travel: FloatArray  # [m] of feed, shape (m,)
    commands: FloatArray  # of each joint [m or rad], shape (m, n)
    point: FloatArray  # ideal tool point in the part [m], shape (m, 3)
    direction: FloatArray  # of the feed in the part, unit, shape (m, 3)
    feed: FloatArray  # speed of the tool point in the part [m/s], shape (m,)
    cuts: npt.NDArray[np.bool_]  # whether the tool is taken to cut there, shape (m,)
    line: IntArray  # of the program, 0 for a path, shape (m,)
    curve: LineArc | None  # path of the tool point in the part, where the tool keeps its direction
    curve_cuts: npt.NDArray[np.bool_]  # of its blocks
    block: IntArray  # block of the curve, shape (m,)
    along: FloatArray  # arc length of the curve [m], rapid moves counted, shape (m,)
    spindle: float | None  # [rad/s], if the cut needs it
    still: tuple[int, ...] = ()  # program lines of moves that would cut if the spindle turned
    into: StockMoves = StockMoves()  # program lines that run into the stock as they should not

    @property
    def marks(self) -> tuple[int, int, int]:
        """Places at the start, in the middle and at the end of what is cut, or of all if nothing is."""
        rows = np.flatnonzero(self.cuts) if self.cuts.any() else np.arange(len(self.travel))
        first, last = self.travel[rows[0]], self.travel[rows[-1]]
        middle = rows[int(np.argmin(np.abs(self.travel[rows] - 0.5 * (first + last))))]
        return int(rows[0]), int(middle), int(rows[-1])


class Places(NamedTuple):
    """Where blocks are looked at, their ends included, ``m`` places."""

    block: IntArray  # shape (m,)
    along: FloatArray  # from the start of the block [m], shape (m,)
    travel: FloatArray  # from the start of the first block [m], shape (m,)


def places(length: FloatArray, samples: int, least: IntArray) -> Places:
    """Both ends of each block, and what of an equal spacing lies inside it; the middle of the whole counts too.

    Parameters
    ----------
    length : ndarray
        Of the blocks [m], shape (n,).
    samples : int
        Places of the equal spacing, both ends included.
    least : ndarray
        Parts that a block has at least, shape (n,).
    """
    ends = np.concatenate([[0.0], np.cumsum(length)])
    even = np.unique(np.concatenate([np.linspace(0.0, ends[-1], samples), [0.5 * ends[-1]]]))
    found = []
    for i, size in enumerate(length):
        slack = 1e-9 * size
        inside = even[(even > ends[i] + slack) & (even < ends[i + 1] - slack)] - ends[i]
        if len(inside) + 1 < least[i]:
            inside = np.linspace(0.0, size, least[i] + 1)[1:-1]
        found.append(np.concatenate([[0.0], inside, [size]]))
    block = np.repeat(np.arange(len(length)), [len(part) for part in found])
    along = np.concatenate(found)
    return Places(block, along, ends[block] + along)


def joints_of(machine: Machine) -> dict[str, int]:
    """Place of each axis letter among the joints of the chain."""
    return {body.joint.command: i for i, body in enumerate(machine.ordered[1:]) if body.joint and body.joint.command}


def beyond_travel(
    machine: Machine, axes: Axes, commands: FloatArray, remedy: str
) -> Iterator[tuple[int, str]]:  # fmt: skip
    """Axes that are led beyond their travel, each once: at which command it is worst, and what to say of it."""
    letters = {joint: letter for letter, joint in joints_of(machine).items()}
    for joint, place, command in beyond(axes, commands):
        letter = letters[joint]
        dimension = "length" if letter in LINEAR_AXES else "angle"
        there, low, high = (
            units.show(float(value), dimension) for value in (command, axes.low[joint], axes.high[joint])
        )
        yield (
            place,
            f"leads axis {letter} to {there}, beyond its travel of {low} to {high}; {remedy}, or take another machine",
        )


def points_tool_path(
    scenario: MachineScenario, path: MachinePath, axes: Axes, *, samples: int | None = None
) -> ToolPath:
    """The way of straight moves of the axes, each axis moving evenly along its leg.

    Parameters
    ----------
    scenario : MachineScenario
        What the path belongs to.
    path : MachinePath
        Its corners.
    axes : Axes
        The machine.
    samples : int, optional
        Replaces the number of places.
    """
    joints, corners = joints_of(scenario.carrying), path.corners()
    tip = np.array(scenario.tool.tip)
    turns = np.zeros((len(corners), len(axes.errors)))
    for letter, joint in joints.items():
        turns[:, joint] = [corner[letter] for corner in corners]
    linear = [joint for letter, joint in joints.items() if letter in LINEAR_AXES]
    length = np.linalg.norm(np.diff(turns[:, linear], axis=0), axis=1)
    legs = np.flatnonzero(length > 0.0)  # a leg of rotary axes alone has no feed
    at = places(length[legs], samples or path.samples, np.ones(len(legs), np.int64))
    leg = legs[at.block]
    rates = (turns[leg + 1] - turns[leg]) / length[leg, None]
    commands = turns[leg] + rates * at.along[:, None]
    point = chains.tool_point(chains.frames(axes.chain, commands * axes.sense), tip)
    direction, ratio = along_rates(axes, commands, tip, rates)
    curve = None
    if not np.ptp(turns[:, axes.chain.kinds == chains.REVOLUTE], axis=0).any():
        ends = chains.tool_point(chains.frames(axes.chain, turns * axes.sense), tip)
        curve = join([line(ends[i], ends[i + 1]) for i in legs])
    feed = path.feed * ratio
    return ToolPath(
        at.travel / path.feed, at.travel, commands, point, direction, feed, np.ones(len(feed), bool),
        np.zeros(len(feed), np.int64), curve, np.ones(len(legs), bool), at.block,
        at.travel if curve is None else curve.knots[at.block] + at.along * ratio, given_speed(scenario),
    )  # fmt: skip


def along_rates(axes: Axes, commands: FloatArray, tip: FloatArray, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where the tool point goes in the part while the joints move.

    Parameters
    ----------
    axes : Axes
        The machine.
    commands : ndarray
        Of the joints [m or rad], shape (m, n).
    tip : ndarray
        Tool point in the last frame [m], shape (3,).
    rates : ndarray
        Change of the commands per travel, shape (m, n).

    Returns
    -------
    direction, ratio : ndarray
        Unit vectors (m, 3), zero where the tool point stands still, and way of the tool point per travel (m,).
    """
    lever = chains.jacobian(axes.chain, commands * axes.sense, tip)[:, :3] * axes.sense
    moved = np.einsum("mij,mj->mi", lever, rates)
    ratio = np.linalg.norm(moved, axis=1)
    return moved / np.maximum(ratio, 1e-300)[:, None], ratio


def given_speed(scenario: MachineScenario) -> float | None:
    """Spindle speed of the cut [rad/s], if the scenario gives one."""
    return scenario.load.force.spindle_speed if isinstance(scenario.load.force, FromCutting) else None


def wall_normal(surface: CutSurface, direction: FloatArray, axis: FloatArray) -> FloatArray:
    """Unit normal of the wall from the part to the tool at places of a pass, shape (m, 3).

    Parameters
    ----------
    direction, axis : array (m, 3)
        Of the feed, and of the tool toward its motor, in the part.
    """
    if surface.normal is not None:
        return np.tile(np.array(surface.normal) / np.linalg.norm(surface.normal), (len(axis), 1))
    left = np.cross(axis, direction)
    left /= np.maximum(np.linalg.norm(left, axis=1, keepdims=True), 1e-300)
    return left if surface.side == "right" else -left
