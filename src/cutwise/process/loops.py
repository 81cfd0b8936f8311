"""The coupled, compiled loops: one time step calls all stages in the order of the design's circle."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray, Polyline, polyline_value
from cutwise.physics.cutting.flute import (
    EdgeCoefficients,
    FluteForce,
    Mill,
    feed_direction,
    feed_per_tooth,
    mean_force,
    mirrored,
    tooth_force,
)
from cutwise.physics.engagement.arc import LayerArcs, layer_arcs
from cutwise.physics.engagement.burr import entry_position
from cutwise.physics.motion.edge import EdgePass, ToolMotion, programmed_motion
from cutwise.physics.structure.pistons import PistonRing, RingState, at_rest
from cutwise.physics.structure.pistons import step as piston_step
from cutwise.records import EdgeHistory, empty_history

AVERAGED = 0
TOOTH_RESOLVED = 1

_CHUNK = 100_000  # steps between two looks at progress and Ctrl-C
_ROWS = 200_000  # longest history


class Layers(NamedTuple):
    """What stands along the edge: the work, and a burr on its rim; both as strips over the height of the mill."""

    burr_height: Polyline  # [m] above the nominal edge, over the position along it [m]
    burr_width: Polyline  # [m] along the spindle axis
    burr_start: float  # [m] of the burr above the tool tip
    work_start: float  # [m] of the work above the tool tip
    work_width: float  # [m] contact length a
    slices: int


class EdgeCell(NamedTuple):
    """Everything that takes part in a pass along an edge."""

    path: EdgePass
    layers: Layers
    mill: Mill
    coefficients: EdgeCoefficients
    spindle_speed: float  # [rad/s]
    up_milling: bool
    ring: PistonRing
    reach: float  # [m] from the joint to the tool tip
    force_law: int  # AVERAGED or TOOTH_RESOLVED


class Immersion(NamedTuple):
    """The mill in the layers at one height above its tip, at one instant."""

    depth: float  # [m] below the top of the burr
    work_depth: float  # [m] below the nominal edge
    theta: float  # [rad]
    chip: float  # [m]
    arcs: LayerArcs


@compiled
def immersion_at(cell: EdgeCell, tool: ToolMotion, tilt: FloatArray, arm: float) -> Immersion:
    """Immersion of the mill at a distance from the joint: motion plus deflection, then engagement."""
    height = tool.height + arm * tilt[1]
    radius = cell.mill.radius
    entry = entry_position(tool.position + arm * tilt[0], height, radius, cell.layers.burr_height)
    speed_x = cell.path.feed + arm * tilt[2]
    speed_y = tool.climb + arm * tilt[3]
    theta = feed_direction(speed_x, speed_y)
    depth = polyline_value(cell.layers.burr_height, entry) - height
    work_depth = max(0.0, -height)
    arcs = layer_arcs(max(depth, work_depth), work_depth, theta, radius)
    chip = feed_per_tooth(speed_x, speed_y, cell.spindle_speed, cell.mill.flutes)
    return Immersion(depth, work_depth, theta, chip, arcs)


@compiled
def arc_force_at(
    cell: EdgeCell, state: Immersion, lo: float, hi: float, z_lo: float, z_hi: float, time: float
) -> FluteForce:
    """Force of one arc over one strip of the mill, by the force law of the cell; up milling is the mirror image."""
    theta = state.theta
    if cell.up_milling:
        lo, hi, theta = math.pi - hi, math.pi - lo, -theta
    if cell.force_law == TOOTH_RESOLVED:
        rotation = (cell.spindle_speed * time) % (2.0 * math.pi)
        force = tooth_force(rotation, lo, hi, state.chip, theta, z_lo, z_hi, cell.mill, cell.coefficients)
    else:
        force = mean_force(lo, hi, state.chip, theta, z_hi - z_lo, cell.mill.flutes, cell.coefficients)
    return mirrored(force) if cell.up_milling else force


@compiled
def burr_strip(cell: EdgeCell, position: float) -> tuple[float, float]:
    """Axial limits of the burr above the tool tip where the tool stands [m]."""
    start = cell.layers.burr_start
    return start, start + polyline_value(cell.layers.burr_width, position)


@compiled
def cutting_forces(cell: EdgeCell, tool: ToolMotion, tilt: FloatArray, time: float, out: FloatArray) -> Immersion:
    """Forces of burr and work, and their moment about the joint, for a position and velocity of the tool.

    ``out``: burr force x, y, z, work force x, y, z [N], tangential force [N], moment as force times arm along x and
    y [N m]; shape (9,). Returned is the immersion at the middle of the burr (point A of the paper). With one slice
    the whole mill is immersed as at A; with several each strip as at its own height, tilted with the motor.
    """
    out[:] = 0.0
    burr_lo, burr_hi = burr_strip(cell, tool.position)
    arm_a = cell.reach - 0.5 * (burr_lo + burr_hi)
    at_a = immersion_at(cell, tool, tilt, arm_a)
    n = cell.layers.slices
    for part in range(2):
        start = burr_lo if part == 0 else cell.layers.work_start
        width = (burr_hi - burr_lo if part == 0 else cell.layers.work_width) / n
        for k in range(n):
            z_lo = start + k * width
            arm = cell.reach - z_lo - 0.5 * width
            here = at_a if n == 1 else immersion_at(cell, tool, tilt, arm)
            arcs = here.arcs
            if part == 0:
                front = arc_force_at(cell, here, arcs.front_lo, arcs.front_hi, z_lo, z_lo + width, time)
                back = arc_force_at(cell, here, arcs.back_lo, arcs.back_hi, z_lo, z_lo + width, time)
                fx, fy, fz = front.x + back.x, front.y + back.y, front.z + back.z
                tangential = front.tangential + back.tangential
            else:
                f = arc_force_at(cell, here, arcs.work_lo, arcs.work_hi, z_lo, z_lo + width, time)
                fx, fy, fz, tangential = f.x, f.y, f.z, f.tangential
            out[3 * part] += fx
            out[3 * part + 1] += fy
            out[3 * part + 2] += fz
            out[6] += tangential
            out[7] += arm * fx
            out[8] += arm * fy
    return at_a


@compiled
def _record(
    history: EdgeHistory, row: int, part: int, stride: int, tool: ToolMotion, here: Immersion, time: float,
    tilt: FloatArray, travel: FloatArray, force: FloatArray, sweeps: int,
) -> None:  # fmt: skip
    """Put a step into its row: the state of the first step, mean, mean square and peak of the forces of all."""
    if part == 0:
        history.motion.time[row] = time
        history.motion.position[row] = tool.position
        history.motion.height[row] = tool.height
        history.engagement.burr_depth[row] = max(0.0, here.depth - here.work_depth)
        history.engagement.work_depth[row] = here.work_depth
        history.engagement.feed_direction[row] = here.theta
        history.engagement.chip[row] = here.chip
        history.engagement.entry[row] = here.arcs.front_lo
        history.engagement.exit[row] = max(here.arcs.front_hi, here.arcs.work_hi, here.arcs.back_hi)
        history.response.tilt[row, 0] = tilt[0]
        history.response.tilt[row, 1] = tilt[1]
        history.response.tilt_rate[row, 0] = tilt[2]
        history.response.tilt_rate[row, 1] = tilt[3]
        for i in range(travel.size):
            history.response.travel[row, i] = travel[i]
    for axis in range(3):
        for offset, wrench in ((0, history.burr_force), (3, history.work_force)):
            value = force[offset + axis]
            wrench.mean[row, axis] += value / stride
            wrench.square[row, axis] += value * value / stride
            wrench.peak[row, axis] = max(wrench.peak[row, axis], abs(value))
    history.tangential[row] += force[6] / stride
    history.response.sweeps[row] = max(history.response.sweeps[row], float(sweeps))


@compiled
def advance_edge(
    cell: EdgeCell, tilt: FloatArray, pistons: RingState, history: EdgeHistory, first: int, steps: int, dt: float,
    stride: int,
) -> None:  # fmt: skip
    """Advance a pass along an edge by a number of steps; tilt (q_x, q_y and rates, shape (4,)) changes in place."""
    force = np.zeros(9)
    for k in range(first, first + steps):
        time = k * dt
        tool = programmed_motion(cell.path, time)
        here = cutting_forces(cell, tool, tilt, time, force)
        qx, qy, vx, vy, sweeps = piston_step(
            cell.ring, pistons, tilt[0], tilt[1], tilt[2], tilt[3], force[7], force[8], dt
        )
        _record(history, k // stride, k % stride, stride, tool, here, time, tilt, pistons.travel, force, sweeps)
        tilt[0], tilt[1], tilt[2], tilt[3] = qx, qy, vx, vy


def run_compliant_edge(
    cell: EdgeCell, time_step: float, progress: Callable[[float], None] | None = None
) -> EdgeHistory:
    """Time stepping of a whole pass (Berselli et al. 2016, Fig. 8), in portions between which a user can stop it."""
    steps = max(1, round(cell.path.duration / time_step))
    stride = max(1, math.ceil(steps / _ROWS))
    steps = math.ceil(steps / stride) * stride
    history = empty_history(steps // stride, len(cell.ring.direction))
    pistons = at_rest(cell.ring)
    tilt = np.zeros(4)
    for first in range(0, steps, _CHUNK):
        count = min(_CHUNK, steps - first)
        advance_edge(cell, tilt, pistons, history, first, count, time_step, stride)
        if progress is not None:
            progress((first + count) / steps)
    return history
