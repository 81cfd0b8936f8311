"""The coupled, compiled loops: one time step calls all stages in the order of the design's circle."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled, inlined
from cutwise.maths.curves import FloatArray, Polyline, polyline_value
from cutwise.physics.cutting.flute import (
    FluteForce,
    Mill,
    mean_force,
    mirrored,
    tooth_force,
)
from cutwise.physics.cutting.uneven import Edges, even_and_linear, turning_mean_force, uneven_tooth_force
from cutwise.physics.engagement.arc import LayerArcs, layer_arcs
from cutwise.physics.engagement.burr import entry_position
from cutwise.physics.engagement.feed import feed_direction, feed_per_tooth
from cutwise.physics.motion.edge import EdgePass, ToolMotion, programmed_motion
from cutwise.physics.structure.pistons import PistonRing, RingState, at_rest
from cutwise.physics.structure.pistons import step as piston_step
from cutwise.records import EdgeHistory, edge_history, empty_rows

AVERAGED = 0
TOOTH_RESOLVED = 1

_CHUNK = 100_000  # steps between two looks at progress and Ctrl-C
_ROWS = 40_000  # longest history


class Strips(NamedTuple):
    """How burr and work stand along the spindle axis."""

    burr_start: float  # [m] of the burr above the tool tip
    work_start: float  # [m] of the work above the tool tip
    work_width: float  # [m] contact length a
    slices: int


class Layers(NamedTuple):
    """What stands along the edge: the work, and a burr on its rim."""

    burr_height: Polyline  # [m] above the nominal edge, over the position along it [m]
    burr_width: Polyline  # [m] along the spindle axis
    strips: Strips


class Cutter(NamedTuple):
    """A turning mill in a material, and how its force is taken."""

    mill: Mill
    edges: Edges  # force law, coefficients and run-out
    spindle_speed: float  # [rad/s]
    up_milling: bool
    force_law: int  # AVERAGED or TOOTH_RESOLVED


class EdgeCell(NamedTuple):
    """Everything that takes part in a pass along an edge.

    Tuples with arrays stay out of the innermost calls: numba counts references of every array that it passes.
    """

    path: EdgePass
    layers: Layers
    cutter: Cutter
    ring: PistonRing
    reach: float  # [m] from the joint to the tool tip


class Immersion(NamedTuple):
    """The mill in the layers at one height above its tip, at one instant."""

    depth: float  # [m] below the top of the burr
    work_depth: float  # [m] below the nominal edge
    theta: float  # [rad]
    chip: float  # [m]
    arcs: LayerArcs


@inlined
def immersion_at(
    cutter: Cutter, burr_height: Polyline, x: float, height: float, speed_x: float, speed_y: float
) -> Immersion:
    """Immersion of the mill from position and velocity of its axis: entry into the burr, arcs, chip load."""
    radius = cutter.mill.radius
    entry = entry_position(x, height, radius, burr_height)
    theta = feed_direction(speed_x, speed_y)
    depth = polyline_value(burr_height, entry) - height
    work_depth = max(0.0, -height)
    arcs = layer_arcs(max(depth, work_depth), work_depth, theta, radius)
    return Immersion(
        depth, work_depth, theta, feed_per_tooth(speed_x, speed_y, cutter.spindle_speed, cutter.mill.flutes), arcs
    )


@inlined
def arc_force_at(
    cutter: Cutter, chip: float, theta: float, lo: float, hi: float, z_lo: float, z_hi: float, time: float
) -> FluteForce:
    """Force of one arc over one strip of the mill, by the force law in use; up milling is the mirror image.

    The closed forms serve where flutes are even and the law is linear, quadrature elsewhere.
    """
    if hi <= lo:
        return FluteForce(0.0, 0.0, 0.0, 0.0)
    if cutter.up_milling:
        lo, hi, theta = math.pi - hi, math.pi - lo, -theta
    mill, edges = cutter.mill, cutter.edges
    even = even_and_linear(edges)
    if even and cutter.force_law != TOOTH_RESOLVED:
        force = mean_force(lo, hi, chip, theta, z_hi - z_lo, mill.flutes, edges.linear)
        return mirrored(force) if cutter.up_milling else force
    rotation = (cutter.spindle_speed * time) % (2.0 * math.pi)
    if cutter.force_law == TOOTH_RESOLVED:
        if even:
            force = tooth_force(rotation, lo, hi, chip, theta, z_lo, z_hi, mill, edges.linear)
        else:
            force = uneven_tooth_force(rotation, lo, hi, chip, theta, z_lo, z_hi, mill, edges)
    else:
        force = turning_mean_force(rotation, lo, hi, chip, theta, z_hi - z_lo, mill, edges)
    return mirrored(force) if cutter.up_milling else force


@inlined
def cutting_forces(
    cutter: Cutter, burr_height: Polyline, burr_width: float, strips: Strips, reach: float, feed: float,
    tool: ToolMotion, tilt: FloatArray, time: float, out: FloatArray,
) -> Immersion:  # fmt: skip
    """Forces of burr and work, and their moment about the joint, for a position and velocity of the tool.

    ``out``: burr force x, y, z, work force x, y, z [N], tangential force [N], moment as force times arm along x and
    y [N m]; shape (9,). Returned is the immersion at the middle of the burr (point A of the paper). With one slice
    the whole mill is immersed as at A; with several each strip as at its own height, tilted with the motor.
    """
    out[:] = 0.0
    burr_lo = strips.burr_start
    arm = reach - burr_lo - 0.5 * burr_width
    at_a = immersion_at(
        cutter, burr_height, tool.position + arm * tilt[0], tool.height + arm * tilt[1],
        feed + arm * tilt[2], tool.climb + arm * tilt[3],
    )  # fmt: skip
    n = strips.slices
    for part in range(2):
        start = burr_lo if part == 0 else strips.work_start
        width = (burr_width if part == 0 else strips.work_width) / n
        for k in range(n):
            z_lo = start + k * width
            arm = reach - z_lo - 0.5 * width
            here = at_a
            if n > 1:
                here = immersion_at(
                    cutter, burr_height, tool.position + arm * tilt[0], tool.height + arm * tilt[1],
                    feed + arm * tilt[2], tool.climb + arm * tilt[3],
                )  # fmt: skip
            arcs = here.arcs
            lo = arcs.front_lo if part == 0 else arcs.work_lo
            hi = arcs.front_hi if part == 0 else arcs.work_hi
            for pieces in range(2 - part):
                if pieces == 1:
                    lo, hi = arcs.back_lo, arcs.back_hi
                f = arc_force_at(cutter, here.chip, here.theta, lo, hi, z_lo, z_lo + width, time)
                out[3 * part] += f.x
                out[3 * part + 1] += f.y
                out[3 * part + 2] += f.z
                out[6] += f.tangential
                out[7] += arm * f.x
                out[8] += arm * f.y
    return at_a


@inlined
def record(
    rows: FloatArray, row: int, part: int, share: float, time: float, tool: ToolMotion, here: Immersion,
    tilt: FloatArray, travel: FloatArray, force: FloatArray, sweeps: int,
) -> None:  # fmt: skip
    """Put a step into its row: the state of its first step; mean, mean square and peak of the forces of all.

    The order of the columns is that of :func:`cutwise.records.edge_history`.
    """
    if part == 0:
        rows[row, 0] = time
        rows[row, 1] = tool.position
        rows[row, 2] = tool.height
        rows[row, 3] = max(0.0, here.depth - here.work_depth)
        rows[row, 4] = here.work_depth
        rows[row, 5] = here.theta
        rows[row, 6] = here.chip
        rows[row, 7] = here.arcs.front_lo
        rows[row, 8] = max(here.arcs.front_hi, max(here.arcs.work_hi, here.arcs.back_hi))
        for i in range(4):
            rows[row, 9 + i] = tilt[i]
        for i in range(travel.size):
            rows[row, 33 + i] = travel[i]
    for i in range(6):
        value = force[i]
        rows[row, 13 + i] += value * share
        rows[row, 19 + i] += value * value * share
        rows[row, 25 + i] = max(rows[row, 25 + i], abs(value))
    rows[row, 31] += force[6] * share
    rows[row, 32] = max(rows[row, 32], float(sweeps))


@compiled
def advance_edge(
    cell: EdgeCell, tilt: FloatArray, pistons: RingState, rows: FloatArray, first: int, steps: int, dt: float,
    stride: int,
) -> None:  # fmt: skip
    """Advance a pass along an edge by a number of steps; tilt (q_x, q_y and rates, shape (4,)) changes in place."""
    force = np.zeros(9)
    path, layers, cutter, ring, reach = cell
    burr_height, burr_width, strips = layers
    travel = pistons.travel
    row = first // stride
    part = 0
    for k in range(first, first + steps):
        time = k * dt
        tool = programmed_motion(path, time)
        width = polyline_value(burr_width, tool.position)
        here = cutting_forces(cutter, burr_height, width, strips, reach, path.feed, tool, tilt, time, force)
        qx, qy, vx, vy, sweeps = piston_step(ring, pistons, tilt[0], tilt[1], tilt[2], tilt[3], force[7], force[8], dt)
        record(rows, row, part, 1.0 / stride, time, tool, here, tilt, travel, force, sweeps)
        tilt[0], tilt[1], tilt[2], tilt[3] = qx, qy, vx, vy
        part += 1
        if part == stride:
            part = 0
            row += 1


def march(
    cell: EdgeCell, time_step: float, advance: Callable[..., None], progress: Callable[[float], None] | None
) -> EdgeHistory:
    """A whole pass from rest, in portions between which progress is told and Ctrl-C is heard."""
    steps = max(1, round(cell.path.duration / time_step))
    stride = max(1, math.ceil(steps / _ROWS))
    steps = math.ceil(steps / stride) * stride
    rows = empty_rows(steps // stride, len(cell.ring.direction))
    pistons = at_rest(cell.ring)
    tilt = np.zeros(4)
    portion = stride * max(1, _CHUNK // stride)
    for first in range(0, steps, portion):
        count = min(portion, steps - first)
        advance(tilt, pistons, rows, first, count, stride)
        if progress is not None:
            progress((first + count) / steps)
    return edge_history(rows)


def run_compliant_edge(
    cell: EdgeCell, time_step: float, progress: Callable[[float], None] | None = None
) -> EdgeHistory:
    """Time stepping of a whole pass (Berselli et al. 2016, Fig. 8)."""

    def advance(tilt: FloatArray, pistons: RingState, rows: FloatArray, first: int, steps: int, stride: int) -> None:
        advance_edge(cell, tilt, pistons, rows, first, steps, time_step, stride)

    return march(cell, time_step, advance, progress)


@compiled
def tooth_resolved_forces(cell: EdgeCell, time: FloatArray, tilt: FloatArray) -> FloatArray:
    """Forces tooth by tooth for given tilts and rates (n, 4) at given times [s]: burr x, y, z, work x, y, z; (n, 6).

    The tilt of an averaged run serves: tooth passing moves the tip by nanometres only.
    """
    path, layers, cutter, _, reach = cell
    burr_height, burr_width, strips = layers
    cutter = Cutter(cutter.mill, cutter.edges, cutter.spindle_speed, cutter.up_milling, TOOTH_RESOLVED)
    forces = np.zeros((time.size, 6))
    out = np.zeros(9)
    for k in range(time.size):
        tool = programmed_motion(path, time[k])
        width = polyline_value(burr_width, tool.position)
        cutting_forces(cutter, burr_height, width, strips, reach, path.feed, tool, tilt[k], time[k], out)
        forces[k] = out[:6]
    return forces
