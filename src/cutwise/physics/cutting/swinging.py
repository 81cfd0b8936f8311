"""A mill whose tip swings on its modes while it cuts: chips from where the tool axis really was at earlier teeth.

The modes are far quicker than the drives: they are stepped exactly, many times within a step of the loop, under the
force of the same micro step extrapolated to its middle (second order in the step). What the loop then sees is the mean
force of its step.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.delayed import delayed_disc_forces
from cutwise.physics.cutting.discs import Discs, first_disc
from cutwise.physics.cutting.uneven import Edges
from cutwise.physics.cutting.wall import disc_range, runout_offset
from cutwise.stages import cut

_AT_WALL = 1e-6  # [rad] from either side: an arc of contact that ends nearer leaves a wall
_SUMS = 7  # largest |x|, |y|, |z|, xy squared, tip squared; sums of the tip displacements x and y


class Tip(NamedTuple):
    """The tool tip on its modes, stepped ``micro`` times in a step of the loop; no modes for a rigid tool."""

    steps: FloatArray  # exact step of each mode under a constant force, shape (m, 2, 3)
    along: FloatArray  # directions, shape (m, 2)
    micro: int
    delay: FloatArray  # micro steps of 1, 2, ... tooth periods, shape (k,)
    limit: float  # [m] displacement beyond which the arc of contact has lost its meaning


class TipMemory(NamedTuple):
    """What the tip carries from step to step; changes in place."""

    state: FloatArray  # displacement [m] and velocity [m/s] of each mode, shape (m, 2)
    past: FloatArray  # positions of the tool axis at the last micro steps [m], a ring, shape (l, 2)
    force: FloatArray  # [N] of the last micro step, shape (2,)
    before: FloatArray  # place of the load one step of the loop ago [m], shape (2,)
    moved: FloatArray  # scratch: how far the axis has come since each earlier tooth [m], shape (k, 2)
    sums: FloatArray  # scratch of a servo step
    count: npt.NDArray[np.int64]  # type: ignore[assignment] # micro steps, and steps of the loop so far, shape (2,)


class TipLog(NamedTuple):
    """What the tip did, over each of ``n`` servo steps."""

    swing: FloatArray  # displacement by its modes: mean x, y, and largest length in the step [m], shape (n, 3)
    wall: FloatArray  # least and greatest displacement into the wall on the right, on the left, NaN: none [m], shape (n, 4)
    peak: FloatArray  # largest magnitude in the step of x, y, z and of the xy vector [N], shape (n, 4)


class SwingingFlutes(NamedTuple):
    """A turning mill on a tip that swings, disc by disc, with run-out and any force law."""

    discs: Discs
    edges: Edges
    spindle: float  # [rad/s]
    step: float  # [s] of the loop
    substeps: int  # steps of the loop in a servo step
    tip: Tip
    memory: TipMemory
    log: TipLog


def tip_at_rest(tip: Tip, point: FloatArray) -> TipMemory:
    """A tip that has stood at a point [m], shape (2,), for long."""
    length = math.ceil(float(tip.delay[-1])) + 3
    return TipMemory(
        np.zeros((tip.along.shape[0], 2)), np.tile(point, (length, 1)), np.zeros(2), np.array(point, float),
        np.empty((tip.delay.shape[0], 2)), np.zeros(_SUMS), np.zeros(2, dtype=np.int64),
    )  # fmt: skip


def tip_log(instants: int) -> TipLog:
    """Room for what the tip does at some servo instants."""
    return TipLog(np.empty((instants, 3)), np.empty((instants, 4)), np.empty((instants, 4)))


@compiled
def _tip_place(memory: TipMemory, tip: Tip) -> tuple[float, float]:
    """Present displacement of the tip by its modes [m]."""
    x, y = 0.0, 0.0
    for m in range(tip.along.shape[0]):
        x += memory.state[m, 0] * tip.along[m, 0]
        y += memory.state[m, 0] * tip.along[m, 1]
    return x, y


@compiled
def _came_from(memory: TipMemory, tip: Tip, x: float, y: float) -> None:
    """Store the present position of the tool axis, and how far it has come since each earlier tooth [m]."""
    length, moved = memory.past.shape[0], memory.moved
    now = memory.count[0]
    memory.past[now % length, 0], memory.past[now % length, 1] = x, y
    for k in range(tip.delay.shape[0]):
        whole = int(tip.delay[k])
        part = tip.delay[k] - whole
        near, far = (now - whole) % length, (now - whole - 1) % length
        moved[k, 0] = x - (1.0 - part) * memory.past[near, 0] - part * memory.past[far, 0]
        moved[k, 1] = y - (1.0 - part) * memory.past[near, 1] - part * memory.past[far, 1]
    memory.count[0] = now + 1


@compiled
def _leaves_wall(angle: float, wall: float, sweep: float, lowest: int, highest: int, mill: Discs) -> bool:
    """Whether some disc passes the wall while the mill turns on by ``sweep`` [rad]: there the surface is left."""
    turn = 2.0 * math.pi
    for tooth in range(mill.teeth):
        past = (angle - turn * tooth / mill.teeth - wall) % turn
        for start in (-past, turn - past):
            if first_disc(start + sweep, mill.step, lowest, highest) > first_disc(start, mill.step, lowest, highest):
                return True
    return False


@compiled
def _swung(
    cutting: SwingingFlutes, rows: FloatArray, count: int, heading: float, angle: float, x: float, y: float,
    speed_x: float, speed_y: float, left: FloatArray, k: int,
) -> tuple[float, float, float]:  # fmt: skip
    """Mean force over a step of the loop while the tip swings [N]; peaks, and the wall that is left, are kept."""
    tip, memory, top = cutting.tip, cutting.memory, cutting.memory.sums
    dt = cutting.step / tip.micro
    sum_x, sum_y, sum_z = 0.0, 0.0, 0.0
    wall_x, wall_y = math.sin(heading), -math.cos(heading)
    for i in range(tip.micro):
        ux, uy = _tip_place(memory, tip)
        now = angle - cutting.spindle * i * dt
        off_x, off_y = runout_offset(now, cutting.edges)
        _came_from(memory, tip, x + speed_x * i * dt + ux + off_x, y + speed_y * i * dt + uy + off_y)
        fx, fy, fz = 0.0, 0.0, 0.0
        for p in range(count):
            low, high = rows[p, 3], rows[p, 4]
            lowest, highest = disc_range(rows[p, 1], rows[p, 2], cutting.discs)
            wall = heading - 0.5 * math.pi + low
            gx, gy, gz = delayed_disc_forces(
                now, wall, high - low, lowest, highest, memory.moved, cutting.discs, cutting.edges
            )
            fx, fy, fz = fx + gx, fy + gy, fz + gz
            if low < _AT_WALL and _leaves_wall(now, wall, cutting.spindle * dt, lowest, highest, cutting.discs):
                into = ux * wall_x + uy * wall_y
                left[k, 0], left[k, 1] = min(left[k, 0], into), max(left[k, 1], into)
            far = wall + high - low
            if high > math.pi - _AT_WALL and _leaves_wall(
                now, far, cutting.spindle * dt, lowest, highest, cutting.discs
            ):
                into = -ux * wall_x - uy * wall_y
                left[k, 2], left[k, 3] = min(left[k, 2], into), max(left[k, 3], into)
        ahead_x, ahead_y = 1.5 * fx - 0.5 * memory.force[0], 1.5 * fy - 0.5 * memory.force[1]  # at the step's middle
        memory.force[0], memory.force[1] = fx, fy
        for m in range(tip.along.shape[0]):
            f = ahead_x * tip.along[m, 0] + ahead_y * tip.along[m, 1]
            z, v = memory.state[m, 0], memory.state[m, 1]
            memory.state[m, 0] = tip.steps[m, 0, 0] * z + tip.steps[m, 0, 1] * v + tip.steps[m, 0, 2] * f
            memory.state[m, 1] = tip.steps[m, 1, 0] * z + tip.steps[m, 1, 1] * v + tip.steps[m, 1, 2] * f
        sum_x, sum_y, sum_z = sum_x + fx, sum_y + fy, sum_z + fz
        top[0], top[1], top[2] = max(top[0], abs(fx)), max(top[1], abs(fy)), max(top[2], abs(fz))
        top[3], top[4] = max(top[3], fx * fx + fy * fy), max(top[4], ux * ux + uy * uy)
        top[5], top[6] = top[5] + ux, top[6] + uy
    return sum_x / tip.micro, sum_y / tip.micro, sum_z / tip.micro


@cut.of(SwingingFlutes)
def _(cutting, contact, count, time, pivot, load):
    """One step of the loop; the tip swings on where nothing cuts, until it is farther than its limit."""
    memory, log, rows = cutting.memory, cutting.log, contact.rows
    heading, x, y = contact.seen[0], contact.seen[1], contact.seen[2]
    number = memory.count[1]
    k, part = number // cutting.substeps, number % cutting.substeps
    if k > 0 and not log.swing[k - 1, 2] <= cutting.tip.limit:  # lost: nothing is known from here on
        if part == 0:
            log.swing[k, 2] = math.inf
        memory.count[1] = number + 1
        return
    if part == 0:
        memory.sums[:] = 0.0
        for side in range(2):
            log.wall[k, 2 * side], log.wall[k, 2 * side + 1] = math.inf, -math.inf
    speed_x, speed_y = (x - memory.before[0]) / cutting.step, (y - memory.before[1]) / cutting.step
    memory.before[0], memory.before[1] = x, y
    fx, fy, fz = _swung(
        cutting, rows, count, heading, -cutting.spindle * time, x, y, speed_x, speed_y, log.wall, k
    )  # fmt: skip
    load.total[0] += fx
    load.total[1] += fy
    load.total[2] += fz
    if part == cutting.substeps - 1:
        top, swings = memory.sums, cutting.substeps * cutting.tip.micro
        log.swing[k, 0], log.swing[k, 1], log.swing[k, 2] = top[5] / swings, top[6] / swings, math.sqrt(top[4])
        log.peak[k, 0], log.peak[k, 1], log.peak[k, 2], log.peak[k, 3] = top[0], top[1], top[2], math.sqrt(top[3])
        for side in range(2):
            if log.wall[k, 2 * side] > log.wall[k, 2 * side + 1]:
                log.wall[k, 2 * side], log.wall[k, 2 * side + 1] = math.nan, math.nan
    memory.count[1] = number + 1
