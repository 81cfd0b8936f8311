"""Forces along a chamfer path, and the compliant spindle that yields to them."""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray
from cutwise.paths.chamfer import ChamferPath
from cutwise.physics.cutting.ball import disc_force
from cutwise.physics.cutting.flute import EdgeCoefficients, FluteForce, feed_direction, feed_per_tooth
from cutwise.physics.engagement.ball import PassFrames, Wedge, chip_area, disc_arc, height_limits
from cutwise.physics.structure.pistons import PistonRing, RingState, at_rest
from cutwise.physics.structure.pistons import step as piston_step

SLICES = 48  # discs over the height of the contact
_RUN_IN = 0.1  # of a closed path, before the part that is reported


class BallEnd(NamedTuple):
    """A turning ball cutter in a material."""

    ball_radius: float  # [m]
    flutes: int
    spindle_speed: float  # [rad/s]
    coefficients: EdgeCoefficients


class Section(NamedTuple):
    """The wedge of material at each sample of a path, in the (y, z) plane of the pass, and the feed."""

    wedge: FloatArray  # the six numbers of a Wedge, shape (n, 6)
    speed: FloatArray  # [m/s] along the edge, across the rod, shape (n,)


class PassForces(NamedTuple):
    """Forces on the tool along a path, in the frame of the pass."""

    force: FloatArray  # [N] x feed, y off the work, z along the rod, shape (n, 3)
    power: FloatArray  # [W], shape (n,)
    chip_area: FloatArray  # [m^2], shape (n,)


def sections(path: ChamferPath, local: PassFrames, axis: FloatArray, contact_speed: FloatArray) -> Section:
    """The wedges that a path meets; the chip follows from the speed of the contact, so that the removal rate is right."""
    edge = path.frames.point - path.centre
    y, z = np.einsum("ij,ij->i", edge, local.off), edge @ axis
    normals = [
        (np.einsum("ij,ij->i", path.frames.normal[:, m], local.off), path.frames.normal[:, m] @ axis) for m in range(2)
    ]
    wedge = np.column_stack([y, z, *normals[0], *normals[1]])
    return Section(wedge, contact_speed * np.sqrt(1.0 - local.plunge**2))


@compiled
def ball_force(wedge: Wedge, ball: BallEnd, speed_x: float, speed_y: float, slices: int) -> tuple[FluteForce, float]:
    """Force of all discs of a ball averaged over a tooth period, and the cutting power [W]."""
    theta = feed_direction(speed_x, speed_y)
    chip = feed_per_tooth(speed_x, speed_y, ball.spindle_speed, ball.flutes)
    radius = ball.ball_radius
    low, high = height_limits(wedge, radius)
    dz = (high - low) / slices
    fx = fy = fz = tangential = power = 0.0
    if dz > 0.0:
        for k in range(slices):
            z = low + (k + 0.5) * dz
            a1, a2 = disc_arc(wedge, radius, z)
            if a2 <= a1:
                continue
            for side in range(2):  # leading and trailing side of the disc
                lo, hi = (a1, a2) if side == 0 else (2.0 * math.pi - a2, 2.0 * math.pi - a1)
                lo, hi = max(lo, theta), min(hi, math.pi + theta)
                if hi <= lo:
                    continue
                f = disc_force(lo, hi, z, dz, radius, chip, theta, ball.flutes, ball.coefficients)
                fx += f.x
                fy += f.y
                fz += f.z
                tangential += f.tangential
                power += f.tangential * math.sqrt(radius * radius - z * z) * ball.spindle_speed
    return FluteForce(fx, fy, fz, tangential), power


def pass_forces(section: Section, ball: BallEnd) -> PassForces:
    """Forces along a path with a rigid tool."""
    out = np.empty((len(section.speed), 5))
    _forces(section.wedge, section.speed, ball, out)
    return PassForces(out[:, :3], out[:, 3], out[:, 4])


@compiled
def _forces(wedges: FloatArray, speed: FloatArray, ball: BallEnd, out: FloatArray) -> None:
    for i in range(speed.size):
        w = wedges[i]
        wedge = Wedge(w[0], w[1], w[2], w[3], w[4], w[5])
        f, power = ball_force(wedge, ball, speed[i], 0.0, SLICES)
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = f.x, f.y, f.z, power
        out[i, 4] = chip_area(wedge, ball.ball_radius, SLICES)


class Yielding(NamedTuple):
    """A pass with a compliant spindle, at the samples of the path."""

    tip: FloatArray  # [m] displacement of the tool tip in the frame of the pass, x and y, shape (n, 2)
    offset: FloatArray  # [m] displacement of the ball from the nominal path, shape (n, 3)
    tilt: FloatArray  # [rad] of the motor in the machine's x and y, shape (n, 2)
    force: FloatArray  # [N] in the frame of the pass, shape (n, 3)


def yielding_pass(
    section: Section, local: PassFrames, axis: FloatArray, durations: FloatArray, ball: BallEnd, ring: PistonRing,
    reach: float, approach: float, dt: float, *, closed: bool,
) -> Yielding:  # fmt: skip
    """Time stepping of a compliant spindle along a chamfer path.

    The spindle yields across the rod only. ``approach`` is how much the ball is led into the work beyond the nominal
    path, along -y of the pass: preset plus part error [m].

    Parameters
    ----------
    section, local : Section, PassFrames
        Wedges and frames along the path.
    axis : array
        Unit vector of the rod, toward the motor, shape (3,).
    durations : array
        Time from each sample to the next [s], shape (n,) for a closed path, (n - 1,) for an open one.
    ball, ring : BallEnd, PistonRing
        Cutter and compliance device.
    reach : float
        Distance from the joint to the tool tip [m].
    approach, dt : float
        [m], [s].
    closed : bool
        Whether the path is closed; it is then run in over its last tenth.
    """
    n = len(section.speed)
    across = np.eye(3)[int(np.argmin(np.abs(axis)))]
    ex = across - (across @ axis) * axis
    ex /= np.linalg.norm(ex)
    ey = np.cross(axis, ex)
    frame = np.column_stack([local.feed @ ex, local.feed @ ey, local.off @ ex, local.off @ ey])
    order = np.arange(-int(_RUN_IN * n) if closed else 0, n) % n
    spans = durations if closed else np.append(durations, durations[-1])
    out = np.zeros((n, 5))
    _yield(section, frame, order, spans, ball, ring, at_rest(ring), reach, approach, dt, out)
    tilt = out[:, :2]
    arm = reach - ball.ball_radius
    moved = np.outer(tilt[:, 0], ex) + np.outer(tilt[:, 1], ey)
    tip = reach * np.column_stack(
        [np.einsum("ij,ij->i", moved, local.feed), np.einsum("ij,ij->i", moved, local.off)]
    )  # fmt: skip
    return Yielding(tip, arm * moved - approach * local.off, tilt, out[:, 2:])


@compiled
def _yield(
    section: Section, frame: FloatArray, order: FloatArray, spans: FloatArray, ball: BallEnd, ring: PistonRing,
    pistons: RingState, reach: float, approach: float, dt: float, out: FloatArray,
) -> None:  # fmt: skip
    qx = qy = vx = vy = 0.0
    arm = reach - ball.ball_radius
    left = 0.0
    for place in range(order.size):
        i = order[place]
        w = section.wedge[i]
        left += spans[i]
        steps = max(1, int(left / dt))
        left -= steps * dt
        fx = fy = fz = 0.0
        for _ in range(steps):
            dy = arm * (qx * frame[i, 2] + qy * frame[i, 3]) - approach
            speed_x = section.speed[i] + arm * (vx * frame[i, 0] + vy * frame[i, 1])
            speed_y = arm * (vx * frame[i, 2] + vy * frame[i, 3])
            f, _ = ball_force(Wedge(w[0] - dy, w[1], w[2], w[3], w[4], w[5]), ball, speed_x, speed_y, SLICES // 2)
            mx = arm * (f.x * frame[i, 0] + f.y * frame[i, 2])
            my = arm * (f.x * frame[i, 1] + f.y * frame[i, 3])
            qx, qy, vx, vy, _ = piston_step(ring, pistons, qx, qy, vx, vy, mx, my, dt)
            fx, fy, fz = f.x, f.y, f.z
        out[i, 0], out[i, 1] = qx, qy
        out[i, 2], out[i, 3], out[i, 4] = fx, fy, fz
