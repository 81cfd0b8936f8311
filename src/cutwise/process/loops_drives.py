"""The coupled loop of feed drives, cutting forces and tool-tip modes, compiled, run in chunks to be interruptible."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled, inlined
from cutwise.physics.cutting.delayed import delayed_disc_forces
from cutwise.physics.cutting.discs import Discs, first_disc
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.cutting.uneven import Edges
from cutwise.physics.cutting.wall import AVERAGED, DELAYED, disc_range, runout_offset, wall_force
from cutwise.physics.motion.drives import APPLIED, BEFORE, LOAD, SPEED, Axis, Drive, at_rest, axes_of, fed, served
from cutwise.physics.structure.modes import Modes, transition

FloatArray = npt.NDArray[np.float64]

NO_FORCE = 0  # the laws that cut are those of cutting/wall.py
STANDSTILL = 0.05e-3  # [m/s]
CHUNK = 200_000  # servo steps between two looks at the keyboard
STEPS_PER_OSCILLATION = 60  # of the quickest mode, at ten substeps of the drives
STEPS_PER_TOOTH = 200  # of a rigid mill whose chips depend on earlier teeth, at ten substeps
_DELAYS_PER_TURN = 2  # how many turns back a tooth that jumped out of the cut may matter
_AT_WALL = 1e-6  # [rad] from the wall side: an arc of contact that begins nearer leaves a wall


class Cut(NamedTuple):
    """What cuts while the drives move."""

    law: int  # NO_FORCE, or AVERAGED, FLUTES, DISCS or DELAYED
    mill: Mill
    discs: Discs
    edges: Edges
    spindle: float  # [rad/s]
    standstill: float = STANDSTILL  # [m/s] slower feed cuts nothing


class Commands(NamedTuple):
    """What the drives are told at each servo instant, ``n`` of them, and what the tool then meets."""

    point: FloatArray  # [m], shape (n, axes): x, y, and z if it has a drive
    velocity: FloatArray  # [m/s], shape (n, axes)
    acceleration: FloatArray  # [m/s^2], shape (n, axes)
    heading: FloatArray  # commanded direction of feed [rad], shape (n,)
    patches: FloatArray  # contact over the servo step: arc from, to [rad], heights from, to [m]; shape (n, p, 4)


class Tip(NamedTuple):
    """The tool tip on its modes, stepped ``micro`` times in a substep of the drives; none for a rigid tool."""

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
    count: npt.NDArray[np.int64]  # micro steps so far, shape (1,)


class DriveHistory(NamedTuple):
    """What the drives did, at the servo instants (positions before the step) and as peaks over the step's substeps."""

    position: FloatArray  # of the load [m], shape (n, axes)
    speed: FloatArray  # of the load side of the motor, r_g w [m/s], shape (n, axes)
    voltage: FloatArray  # held over the step [V], shape (n, axes)
    clipped: npt.NDArray[np.bool_]  # controller at its limit, shape (n, axes)
    force: FloatArray  # mean over the step, on the tool [N], shape (n, 3)
    force_peak: FloatArray  # largest magnitude in the step of x, y, z and of the xy vector [N], shape (n, 4)
    tip: FloatArray  # displacement of the tip by its modes: mean x, y, and largest length in the step [m], shape (n, 3)
    left: FloatArray  # least and greatest displacement into the wall where a tooth left it [m], NaN: none, shape (n, 2)
    known: int  # instants before the tip swung beyond its limit; everything is NaN from there on


def tip_dynamics(modes: Modes | None, cut: Cut, step: float, substeps: int, limit: float = math.inf) -> Tip:
    """Modes ready for a substep of ``step`` / ``substeps`` [s]; at ten substeps 60 micro steps per oscillation.

    A rigid mill whose teeth cut deeper than they are fed, as under run-out, has 200 of them per tooth instead.
    """
    if modes is not None:
        rate = float(modes.frequency.max()) / (2.0 * math.pi) * STEPS_PER_OSCILLATION
    else:
        rate = STEPS_PER_TOOTH * cut.spindle * cut.mill.flutes / (2.0 * math.pi) if cut.law == DELAYED else 0.0
    nominal = step / 10.0 * rate
    micro = max(1, math.ceil(nominal))
    dt = step / substeps / micro
    count = _DELAYS_PER_TURN * cut.mill.flutes
    period = 2.0 * math.pi / (cut.spindle * cut.mill.flutes) if cut.law != NO_FORCE else dt
    delay = np.arange(1, count + 1) * period / dt
    if modes is None:
        return Tip(np.zeros((0, 2, 3)), np.zeros((0, 2)), micro, delay, limit)
    exact = [transition(float(w), float(z), float(m), dt) for w, z, m, _ in zip(*modes, strict=True)]
    return Tip(np.array(exact), np.ascontiguousarray(modes.direction), micro, delay, limit)


def tip_at_rest(tip: Tip, point: FloatArray) -> TipMemory:
    """A tip that has stood at a point [m], shape (2,), for long."""
    length = math.ceil(float(tip.delay[-1])) + 3
    return TipMemory(
        np.zeros((tip.along.shape[0], 2)), np.tile(point, (length, 1)), np.zeros(2), np.zeros(1, dtype=np.int64)
    )


@compiled
def _tip_place(memory: TipMemory, tip: Tip) -> tuple[float, float]:
    """Present displacement of the tip by its modes [m]."""
    x, y = 0.0, 0.0
    for m in range(tip.along.shape[0]):
        x += memory.state[m, 0] * tip.along[m, 0]
        y += memory.state[m, 0] * tip.along[m, 1]
    return x, y


@compiled
def _came_from(memory: TipMemory, tip: Tip, x: float, y: float, moved: FloatArray) -> None:
    """Store the present position of the tool axis, and how far it has come since each earlier tooth [m]."""
    length = memory.past.shape[0]
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
def _cut_on_modes(
    cut: Cut, tip: Tip, memory: TipMemory, patches: FloatArray, heading: float, angle: float, dt: float, x: float,
    y: float, speed_x: float, speed_y: float, cuts: bool, moved: FloatArray, top: FloatArray, left: FloatArray,
) -> tuple[float, float, float]:  # fmt: skip
    """Mean force over a substep of the drives while the tip swings; peaks and the wall that is left are kept.

    ``top`` holds the largest magnitudes of x, y, z, the squared xy vector and the squared tip displacement, and the sum
    of the tip displacements x and y; ``left`` the least and greatest displacement into the wall.
    """
    sum_x, sum_y, sum_z = 0.0, 0.0, 0.0
    wall_x, wall_y = math.sin(heading), -math.cos(heading)
    for i in range(tip.micro):
        ux, uy = _tip_place(memory, tip)
        now = angle - cut.spindle * i * dt
        off_x, off_y = runout_offset(now, cut.edges)
        _came_from(memory, tip, x + speed_x * i * dt + ux + off_x, y + speed_y * i * dt + uy + off_y, moved)
        fx, fy, fz = 0.0, 0.0, 0.0
        if cuts:
            for p in range(patches.shape[0]):
                low, high = patches[p, 0], patches[p, 1]
                if high <= low:
                    continue
                lowest, highest = disc_range(patches[p, 2], patches[p, 3], cut.discs)
                wall = heading - 0.5 * math.pi + low
                gx, gy, gz = delayed_disc_forces(now, wall, high - low, lowest, highest, moved, cut.discs, cut.edges)
                fx, fy, fz = fx + gx, fy + gy, fz + gz
                if low < _AT_WALL and _leaves_wall(now, wall, cut.spindle * dt, lowest, highest, cut.discs):
                    into = ux * wall_x + uy * wall_y
                    left[0], left[1] = min(left[0], into), max(left[1], into)
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


@inlined
def _cut_rigid(
    cut: Cut, patches: FloatArray, heading: float, angle: float, feed_x: float, feed_y: float, top: FloatArray
) -> tuple[float, float, float]:
    """Force of all patches in the middle of a substep, with a rigid tool; peaks are kept."""
    fx, fy, fz = 0.0, 0.0, 0.0
    for p in range(patches.shape[0]):
        if patches[p, 1] > patches[p, 0]:
            gx, gy, gz = wall_force(
                cut.law, angle, heading, patches[p, 0], patches[p, 1], patches[p, 2], patches[p, 3], feed_x, feed_y,
                cut.mill, cut.discs, cut.edges,
            )  # fmt: skip
            fx, fy, fz = fx + gx, fy + gy, fz + gz
    top[0], top[1], top[2] = max(top[0], abs(fx)), max(top[1], abs(fy)), max(top[2], abs(fz))
    top[3] = max(top[3], fx * fx + fy * fy)
    return fx, fy, fz


@inlined
def _in_contact(patches: FloatArray) -> bool:
    widest = 0.0
    for p in range(patches.shape[0]):
        widest = max(widest, patches[p, 1] - patches[p, 0])
    return widest > 0.0


@compiled
def _run(
    first: int, last: int, state: FloatArray, commands: Commands, axes: tuple[Axis, ...], cut: Cut, substeps: int,
    tip: Tip, memory: TipMemory, history: DriveHistory,
) -> int:  # fmt: skip
    """Steps from ``first`` to ``last``; the number of the step behind the last one that counts."""
    position, speed, voltage, clipped, force, force_peak, swing, wall_left, _ = history
    sample, step = axes[0].law.sample_time, axes[0].step
    travel_x, travel_y = axes[0].plant.transmission, axes[1].plant.transmission
    pitch_time = 2.0 * math.pi / (cut.spindle * cut.mill.flutes) if cut.law != NO_FORCE else 0.0
    top, left, moved = np.zeros(7), np.zeros(2), np.empty((tip.delay.shape[0], 2))
    for k in range(first, last):
        for a in range(len(axes)):
            position[k, a] = state[a, LOAD]
            speed[k, a] = state[a, SPEED] * axes[a].plant.transmission
            clipped[k, a] = served(
                axes[a], state, a, commands.point[k, a], commands.velocity[k, a], commands.acceleration[k, a]
            )
            voltage[k, a] = state[a, APPLIED]
        heading, patches = commands.heading[k], commands.patches[k]
        head_x, head_y = math.cos(heading), math.sin(heading)
        contact = cut.law != NO_FORCE and _in_contact(patches)
        fx, fy, fz = 0.0, 0.0, 0.0
        sum_x, sum_y, sum_z = 0.0, 0.0, 0.0
        top[:] = 0.0
        left[0], left[1] = math.inf, -math.inf
        for m in range(substeps):
            if cut.law == DELAYED:  # the tip swings on where nothing cuts
                rate = math.hypot(state[0, SPEED] * travel_x, state[1, SPEED] * travel_y)
                angle = -cut.spindle * (k * sample + m * step)
                load_x, load_y = state[0, LOAD], state[1, LOAD]
                fx, fy, fz = _cut_on_modes(
                    cut, tip, memory, patches, heading, angle, step / tip.micro, load_x, load_y,
                    (load_x - state[0, BEFORE]) / step, (load_y - state[1, BEFORE]) / step,
                    contact and rate >= cut.standstill, moved, top, left,
                )  # fmt: skip
            elif contact:
                fx, fy, fz = 0.0, 0.0, 0.0
                vx, vy = state[0, SPEED] * travel_x, state[1, SPEED] * travel_y
                rate = math.hypot(vx, vy)
                if rate >= cut.standstill:
                    feed_x, feed_y = vx * pitch_time, vy * pitch_time
                    if cut.law == AVERAGED:  # at the speed |v|, along the commanded direction
                        feed_x, feed_y = rate * pitch_time * head_x, rate * pitch_time * head_y
                    angle = -cut.spindle * (k * sample + (m + 0.5) * step)
                    fx, fy, fz = _cut_rigid(cut, patches, heading, angle, feed_x, feed_y, top)
            sum_x, sum_y, sum_z = sum_x + fx, sum_y + fy, sum_z + fz
            on_axis = (fx, fy, fz)
            for a in range(len(axes)):
                fed(axes[a], state, a, on_axis[a])
        force[k, 0], force[k, 1], force[k, 2] = sum_x / substeps, sum_y / substeps, sum_z / substeps
        force_peak[k, 0], force_peak[k, 1], force_peak[k, 2], force_peak[k, 3] = (
            top[0],
            top[1],
            top[2],
            math.sqrt(top[3]),
        )
        if cut.law == DELAYED:
            swings = substeps * tip.micro
            swing[k, 0], swing[k, 1], swing[k, 2] = top[5] / swings, top[6] / swings, math.sqrt(top[4])
            wall_left[k, 0] = left[0] if left[0] <= left[1] else math.nan
            wall_left[k, 1] = left[1] if left[0] <= left[1] else math.nan
            if not top[4] <= tip.limit**2:
                return k
    return last


def run_drives(
    commands: Commands, drives: tuple[Drive, ...], cut: Cut, substeps: int, progress: Callable[[float], None] | None = None,
    *, modes: Modes | None = None, tip_limit: float = math.inf,
) -> DriveHistory:  # fmt: skip
    """Feed drives following their commands under friction and cutting forces.

    Each servo step measures, computes the voltage and holds it; the plant is stepped exactly in ``substeps`` with
    force and friction held over each. The chip load follows from the actual velocity (with the law ``DELAYED`` from the
    true positions at earlier teeth, vibration and run-out included), the immersion from the commanded position. The
    drives start at rest on the first point, integrals and previous error zero.

    Parameters
    ----------
    commands : Commands
        Set points and contact at the servo instants.
    drives : tuple of Drive
        Those of x and y, and of z if it has one; all controllers have the same sample time.
    cut : Cut
        Cutting force law, or none.
    substeps : int
        Steps of the plant per servo step, at least 1.
    progress : callable, optional
        Called with the share done after each chunk.
    modes : Modes, optional
        Modes of the tool tip; they need the law ``DELAYED``.
    tip_limit : float
        Displacement of the tip at which the run ends [m]: the tool then is not where its arc of contact says.

    Raises
    ------
    ValueError
        Sample times differ, there are no substeps, or modes come with another law.
    """
    axes = axes_of(drives, substeps)
    if modes is not None and cut.law != DELAYED:
        raise ValueError("tool-tip modes need chips from the true positions: the law DELAYED")
    n = commands.point.shape[0]
    state, count = at_rest(commands.point[0]), len(axes)
    swings = n if cut.law == DELAYED else 0
    tip = tip_dynamics(modes, cut, axes[0].law.sample_time, substeps, tip_limit)
    memory = tip_at_rest(tip, commands.point[0, :2])
    history = DriveHistory(
        np.empty((n, count)),
        np.empty((n, count)),
        np.empty((n, count)),
        np.zeros((n, count), dtype=bool),
        np.empty((n, 3)),
        np.empty((n, 4)),
        np.empty((swings, 3)),
        np.empty((swings, 2)),
        n,
    )
    for first in range(0, n, CHUNK):
        last = min(first + CHUNK, n)
        known = _run(first, last, state, commands, axes, cut, substeps, tip, memory, history)
        if known < last:
            return _known_until(history, known)
        if progress is not None:
            progress(last / n)
    return history


def _known_until(history: DriveHistory, known: int) -> DriveHistory:
    for values in history[:-1]:
        assert isinstance(values, np.ndarray)
        values[known:] = False if values.dtype == bool else math.nan
    return history._replace(known=known)
