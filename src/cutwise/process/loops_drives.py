"""The coupled loop of feed drives and cutting forces, compiled, run in chunks so that it can be interrupted."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.cutting.discs import Discs
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.wall import AVERAGED, wall_force
from cutwise.physics.motion.drives import Controller, Plant, advance, control, played, response_integrals

FloatArray = npt.NDArray[np.float64]

NO_FORCE = 0  # the laws that cut are those of cutting/wall.py
STANDSTILL = 0.05e-3  # [m/s]
CHUNK = 200_000  # servo steps between two looks at the keyboard
_STATE = 7  # per axis: motor side x, w, integral, last error, held voltage, load side x, force in the last substep


class DrivePair(NamedTuple):
    """The x and y drives."""

    plant_x: Plant
    law_x: Controller
    plant_y: Plant
    law_y: Controller


class Cut(NamedTuple):
    """What cuts while the drives move."""

    law: int  # NO_FORCE, or AVERAGED, FLUTES or DISCS
    mill: Mill
    discs: Discs
    coefficients: EdgeCoefficients
    depth: float  # axial [m]
    spindle: float  # [rad/s]
    standstill: float = STANDSTILL  # [m/s] slower feed cuts nothing


class Commands(NamedTuple):
    """What the drives are told at each servo instant, ``n`` of them."""

    point: FloatArray  # [m], shape (n, 2)
    velocity: FloatArray  # [m/s], shape (n, 2)
    acceleration: FloatArray  # [m/s^2], shape (n, 2)
    heading: FloatArray  # commanded direction of feed [rad], shape (n,)
    immersion: FloatArray  # alpha held over the servo step [rad], shape (n,)


class DriveHistory(NamedTuple):
    """What the drives did, at the servo instants (positions before the step) and as peaks over the step's substeps."""

    position: FloatArray  # of the load [m], shape (n, 2)
    speed: FloatArray  # of the load side of the motor, r_g w [m/s], shape (n, 2)
    voltage: FloatArray  # held over the step [V], shape (n, 2)
    clipped: npt.NDArray[np.bool_]  # controller at its limit, shape (n, 2)
    force: FloatArray  # mean over the step, on the tool [N], shape (n, 3)
    force_peak: FloatArray  # largest magnitude in the step of x, y, z and of the xy vector [N], shape (n, 4)


@compiled
def _run(
    first: int, last: int, state: FloatArray, commands: Commands, drives: DrivePair, cut: Cut, substeps: int,
    position: FloatArray, speed: FloatArray, voltage: FloatArray, clipped: npt.NDArray[np.bool_],
    force: FloatArray, force_peak: FloatArray,
) -> None:  # fmt: skip
    plant_x, law_x, plant_y, law_y = drives.plant_x, drives.law_x, drives.plant_y, drives.law_y
    step = law_x.sample_time / substeps
    gain_x, gain_y = plant_x.current_gain * plant_x.torque_constant, plant_y.current_gain * plant_y.torque_constant
    px1, px2 = response_integrals(plant_x.viscous / plant_x.inertia, step)
    py1, py2 = response_integrals(plant_y.viscous / plant_y.inertia, step)
    pitch_time = 2.0 * math.pi / (cut.spindle * cut.mill.flutes) if cut.law != NO_FORCE else 0.0
    x, wx, ix, ex, ux = state[0, 0], state[0, 1], state[0, 2], state[0, 3], state[0, 4]
    y, wy, iy, ey, uy = state[1, 0], state[1, 1], state[1, 2], state[1, 3], state[1, 4]
    load_x, load_y = state[0, 5], state[1, 5]
    for k in range(first, last):
        position[k, 0], position[k, 1] = load_x, load_y
        speed[k, 0], speed[k, 1] = wx * plant_x.transmission, wy * plant_y.transmission
        new_x, ix, ex, clipped[k, 0] = control(
            commands.point[k, 0], commands.velocity[k, 0], commands.acceleration[k, 0], x, ix, ex, law_x
        )
        new_y, iy, ey, clipped[k, 1] = control(
            commands.point[k, 1], commands.velocity[k, 1], commands.acceleration[k, 1], y, iy, ey, law_y
        )
        applied_x = ux if law_x.delay > 0.5 else new_x
        applied_y = uy if law_y.delay > 0.5 else new_y
        ux, uy = new_x, new_y
        voltage[k, 0], voltage[k, 1] = applied_x, applied_y
        heading, arc = commands.heading[k], commands.immersion[k]
        head_x, head_y = math.cos(heading), math.sin(heading)
        cutting = cut.law != NO_FORCE and arc > 0.0
        fx, fy, fz = 0.0, 0.0, 0.0
        sum_x, sum_y, sum_z = 0.0, 0.0, 0.0
        top_x, top_y, top_z, top = 0.0, 0.0, 0.0, 0.0
        for m in range(substeps):
            if cutting:
                vx, vy = wx * plant_x.transmission, wy * plant_y.transmission
                rate = math.hypot(vx, vy)
                if rate < cut.standstill:
                    fx, fy, fz = 0.0, 0.0, 0.0
                else:
                    feed_x, feed_y = vx * pitch_time, vy * pitch_time
                    if cut.law == AVERAGED:  # at the speed |v|, along the commanded direction
                        feed_x, feed_y = rate * pitch_time * head_x, rate * pitch_time * head_y
                    angle = -cut.spindle * (k * law_x.sample_time + (m + 0.5) * step)
                    fx, fy, fz = wall_force(
                        cut.law, angle, heading, arc, feed_x, feed_y, cut.depth, cut.mill, cut.discs, cut.coefficients
                    )
                sum_x, sum_y, sum_z = sum_x + fx, sum_y + fy, sum_z + fz
                top_x, top_y, top_z = max(top_x, abs(fx)), max(top_y, abs(fy)), max(top_z, abs(fz))
                top = max(top, fx * fx + fy * fy)
            x, wx = advance(x, wx, gain_x * applied_x + fx * plant_x.transmission, step, px1, px2, plant_x)
            y, wy = advance(y, wy, gain_y * applied_y + fy * plant_y.transmission, step, py1, py2, plant_y)
            load_x, load_y = played(load_x, x, plant_x.backlash), played(load_y, y, plant_y.backlash)
        force[k, 0], force[k, 1], force[k, 2] = sum_x / substeps, sum_y / substeps, sum_z / substeps
        force_peak[k, 0], force_peak[k, 1], force_peak[k, 2], force_peak[k, 3] = top_x, top_y, top_z, math.sqrt(top)
    state[0, 0], state[0, 1], state[0, 2], state[0, 3], state[0, 4], state[0, 5] = x, wx, ix, ex, ux, load_x
    state[1, 0], state[1, 1], state[1, 2], state[1, 3], state[1, 4], state[1, 5] = y, wy, iy, ey, uy, load_y


def run_drives(
    commands: Commands, drives: DrivePair, cut: Cut, substeps: int, progress: Callable[[float], None] | None = None
) -> DriveHistory:
    """Two feed drives following their commands under friction and cutting forces.

    Each servo step measures, computes the voltage and holds it; the plant is stepped exactly in ``substeps`` with
    force and friction held over each. The chip load follows from the actual velocity, the immersion from the commanded
    position. The drives start at rest on the first point, integrals and previous error zero.

    Parameters
    ----------
    commands : Commands
        Set points and immersion at the servo instants.
    drives : DrivePair
        The axes; both controllers have the same sample time.
    cut : Cut
        Cutting force law, or none.
    substeps : int
        Steps of the plant per servo step, at least 1.
    progress : callable, optional
        Called with the share done after each chunk.

    Raises
    ------
    ValueError
        Sample times differ, or there are no substeps.
    """
    if drives.law_x.sample_time != drives.law_y.sample_time:
        raise ValueError("both axes need the same sample time")
    if substeps < 1:
        raise ValueError("at least one substep per servo step is needed")
    n = commands.point.shape[0]
    state = np.zeros((2, _STATE))
    state[:, 0] = state[:, 5] = commands.point[0]
    history = DriveHistory(
        np.empty((n, 2)),
        np.empty((n, 2)),
        np.empty((n, 2)),
        np.zeros((n, 2), dtype=bool),
        np.empty((n, 3)),
        np.empty((n, 4)),
    )
    for first in range(0, n, CHUNK):
        last = min(first + CHUNK, n)
        _run(first, last, state, commands, drives, cut, substeps, *history)
        if progress is not None:
            progress(last / n)
    return history
