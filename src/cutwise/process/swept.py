"""The averaged edge loop over a surface with memory, for run-out and path errors that the arcs cannot follow."""

import math
from collections.abc import Callable

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray, polyline_value
from cutwise.physics.cutting.uneven import Edges, force_per_length
from cutwise.physics.engagement.swept import Columns, columns_in_reach, stand
from cutwise.physics.motion.edge import programmed_motion
from cutwise.physics.structure.pistons import RingState
from cutwise.physics.structure.pistons import step as piston_step
from cutwise.process.loops import Cutter, EdgeCell, immersion_at, march, record
from cutwise.records import EdgeHistory

_COLUMN = 10e-6  # [m] pitch of the columns


@compiled
def strip_force(
    edges: Edges, cutter: Cutter, columns: Columns, strip: int, x: float, y: float, width: float, dt: float,
    top: float, force: FloatArray,
) -> None:  # fmt: skip
    r"""Cut one strip down to the mill circle and add up the force that the removed material takes.

    A column that loses the area :math:`\Delta A` at the angle :math:`\phi` within a step had the chip thickness
    :math:`h = 2\pi \Delta A / (N \Omega R\, \Delta\phi\, \Delta t)`; its share of the tooth-averaged force is
    :math:`N b \Delta\phi / 2\pi` times the force per length at h. Run-out moves the circle, not its radius.

    Parameters
    ----------
    x, y : float
        Centre of the mill circle along and above the nominal edge [m].
    width : float
        Axial width b of the strip [m].
    dt : float
        Time step [s].
    top : float
        Height above which nothing stands [m].
    force : array
        x, y, z and tangential force [N], added to; shape (4,).
    """
    radius = cutter.mill.radius
    height = columns.height
    floor = columns.floor[strip]
    first, last = columns_in_reach(x, y - radius, radius, top, columns.start, columns.pitch, height.shape[1])
    teeth = cutter.mill.flutes * width / (2.0 * math.pi)
    rate = 2.0 * math.pi / (cutter.mill.flutes * cutter.spindle_speed * radius * dt)
    turn = -1.0 if cutter.up_milling else 1.0
    for i in range(first, last):
        d = columns.start + i * columns.pitch - x
        drop = math.sqrt(max(0.0, radius * radius - d * d))
        left = max(floor, y - drop)
        if left >= height[strip, i]:
            continue
        area = (height[strip, i] - left) * columns.pitch
        height[strip, i] = left
        angle = columns.pitch / max(drop, columns.pitch)
        ft, fr, fa = force_per_length(edges, rate * area / angle)
        share = teeth * angle
        sin_phi, cos_phi = d / radius, -drop / radius
        force[0] += share * (-turn * ft * cos_phi - fr * sin_phi)
        force[1] += share * (turn * ft * sin_phi - fr * cos_phi)
        force[2] += share * fa
        force[3] += share * ft


@compiled
def advance_swept_edge(
    cell: EdgeCell, columns: Columns, tilt: FloatArray, pistons: RingState, rows: FloatArray, first: int, steps: int,
    dt: float, stride: int, top: float,
) -> None:  # fmt: skip
    """Advance a pass over a surface with memory; tilt (q_x, q_y and rates, shape (4,)) changes in place."""
    force = np.zeros(9)
    part_force = np.zeros(4)
    path, layers, cutter, ring, reach = cell
    edges = cutter.edges
    burr_height, burr_width, strips = layers
    row = first // stride
    part = 0
    for k in range(first, first + steps):
        time = k * dt
        tool = programmed_motion(path, time)
        width = polyline_value(burr_width, tool.position)
        around = (cutter.spindle_speed * time) % (2.0 * math.pi) + edges.runout_angle
        off_x, off_y = edges.runout * math.sin(around), edges.runout * math.cos(around)
        if cutter.up_milling:
            off_y = -off_y
        force[:] = 0.0
        for strip in range(2 * strips.slices):
            layer = 0 if strip < strips.slices else 1
            start = strips.burr_start if layer == 0 else strips.work_start
            thickness = (width if layer == 0 else strips.work_width) / strips.slices
            arm = reach - start - (strip - layer * strips.slices + 0.5) * thickness
            at = arm if strips.slices > 1 else reach - strips.burr_start - 0.5 * width
            x = tool.position + at * tilt[0] + off_x
            y = tool.height + at * tilt[1] + cutter.mill.radius + off_y
            part_force[:] = 0.0
            strip_force(edges, cutter, columns, strip, x, y, thickness, dt, top, part_force)
            for axis in range(3):
                force[3 * layer + axis] += part_force[axis]
            force[6] += part_force[3]
            force[7] += arm * part_force[0]
            force[8] += arm * part_force[1]
        arm = reach - strips.burr_start - 0.5 * width
        here = immersion_at(
            cutter, burr_height, tool.position + arm * tilt[0], tool.height + arm * tilt[1],
            path.feed + arm * tilt[2], tool.climb + arm * tilt[3],
        )  # fmt: skip
        qx, qy, vx, vy, sweeps = piston_step(ring, pistons, tilt[0], tilt[1], tilt[2], tilt[3], force[7], force[8], dt)
        record(rows, row, part, 1.0 / stride, time, tool, here, tilt, pistons.travel, force, sweeps)
        tilt[0], tilt[1], tilt[2], tilt[3] = qx, qy, vx, vy
        part += 1
        if part == stride:
            part = 0
            row += 1


def _yield(cell: EdgeCell) -> float:
    """Farthest that the tool tip can be pushed [m]."""
    return cell.ring.piston.stroke * cell.reach / cell.ring.arm


def columns_carry(cell: EdgeCell) -> bool:
    """Whether all that the mill can meet ends below its axis, as columns of height need."""
    top = float(cell.layers.burr_height.value.max())
    return max(0.0, top) + cell.path.preset < cell.cutter.mill.radius + _yield(cell)


def run_swept_edge(
    cell: EdgeCell, time_step: float, progress: Callable[[float], None] | None = None, column: float = _COLUMN
) -> EdgeHistory:
    """Time stepping of a whole pass over a surface with memory.

    Raises
    ------
    ValueError
        The mill is immersed beyond its axis, which columns cannot carry.
    """
    if not columns_carry(cell):
        raise ValueError("a swept surface needs the burr to end below the axis of the mill")
    burr = cell.layers.burr_height
    top = max(0.0, float(burr.value.max()))
    spread = cell.cutter.mill.radius + _yield(cell)
    columns = stand(
        burr, -spread, cell.path.feed * cell.path.duration + spread, column,
        cell.layers.strips.slices, cell.layers.strips.slices,
    )  # fmt: skip

    def advance(tilt: FloatArray, pistons: RingState, rows: FloatArray, first: int, steps: int, stride: int) -> None:
        advance_swept_edge(cell, columns, tilt, pistons, rows, first, steps, time_step, stride, top)

    return march(cell, time_step, advance, progress)
