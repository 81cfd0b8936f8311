"""Forces along a chamfer path, and the compliant spindle that yields to them."""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import lengths
from cutwise.paths.chamfer import ChamferPath
from cutwise.physics.cutting.ball import disc_force
from cutwise.physics.cutting.flute import FluteForce
from cutwise.physics.cutting.uneven import Edges
from cutwise.physics.engagement.ball import (
    SIDE,
    PassFrames,
    arc_room,
    burr_sides,
    disc_arcs,
    height_limits,
    leading_side,
    leans,
    wedge_sides,
)
from cutwise.physics.engagement.feed import feed_direction, feed_per_tooth
from cutwise.physics.structure.pistons import SWEEPS, PistonRing, RingState, at_rest
from cutwise.physics.structure.pistons import step as piston_step

SLICES = 48  # discs over the height of the contact, and as many over that of the burr
_RUN_IN = 0.5  # of a path, before the part that is reported: round a closed one, in place at the start of an open one
_LEAD_IN = 0.5  # of the run-in, in which the ball comes into the work


class BallEnd(NamedTuple):
    """A turning ball cutter in a material."""

    ball_radius: float  # [m]
    flutes: int
    spindle_speed: float  # [rad/s]
    edges: Edges


class Section(NamedTuple):
    """The material at each sample of a path, in the frame of the pass, and the feed."""

    edge: FloatArray  # [m] from the ball centre, shape (n, 3)
    wedge: FloatArray  # planes of the two faces, shape (n, 2, 4)
    burr: FloatArray  # planes of the burr, shape (n, 4, 4), or (n, 0, 4) without one
    proud: float  # [m] how far the burr reaches from the edge at most
    speed: FloatArray  # [m/s] along the edge, across the rod, shape (n,)
    rise: FloatArray  # [m/s] along the edge, along the rod, shape (n,)


class Course(NamedTuple):
    """A path as a yielding spindle runs it, along two unit vectors across the rod."""

    place: FloatArray  # [m] of the ball centre along those two and along the rod, shape (n, 3)
    frame: FloatArray  # the feed, then the direction off the work, shape (n, 4)
    lead: FloatArray  # [m] from there to where the ball is led, into the work, shape (n, 2)
    velocity: FloatArray  # [m/s] with which it is led, shape (n, 2)
    climb: FloatArray  # [m/s] of the ball along the rod, shape (n,)
    contact: FloatArray  # speed of the contact over that of the ball centre, shape (n,)
    spans: FloatArray  # [s] from each sample to the next, shape (n,)
    closed: bool


class EdgeBurr(NamedTuple):
    """A burr along an edge."""

    height: FloatArray  # [m] at each sample of a path, shape (n,)
    width: FloatArray
    side: int  # which face of the edge carries it, 0 or 1: the one along the rod is 1


class PassForces(NamedTuple):
    """Forces on the tool along a path, in the frame of the pass."""

    force: FloatArray  # [N] x feed, y off the work, z along the rod, of work and burr together, shape (n, 3)
    burr_force: FloatArray  # [N] that of the burr alone, shape (n, 3)
    power: FloatArray  # [W], shape (n,)
    chip_area: FloatArray  # [m^2] at right angles to the edge, with the burr, shape (n,)


def sections(
    path: ChamferPath, local: PassFrames, axis: FloatArray, contact_speed: FloatArray, burr: EdgeBurr | None = None
) -> Section:
    """The material that a path meets; the chip follows from the speed of the contact, so that the removal rate is right.

    Faces are taken as planes through the edge.
    """
    frames = path.frames

    def seen(vector: FloatArray) -> FloatArray:
        return np.column_stack(
            [np.einsum("ij,ij->i", vector, local.feed), np.einsum("ij,ij->i", vector, local.off), vector @ axis]
        )

    edge = seen(frames.point - path.centre)
    wedge = wedge_sides(edge, np.stack([seen(frames.normal[:, 0]), seen(frames.normal[:, 1])], axis=1))
    strip, proud = np.zeros((len(edge), 0, SIDE)), 0.0
    if burr is not None:
        into, normal = seen(frames.into[:, burr.side]), seen(frames.normal[:, burr.side])
        strip = burr_sides(edge, into, normal, burr.height, burr.width)
        proud = float(np.hypot(burr.height, burr.width).max())
    across = np.sqrt(np.maximum(0.0, 1.0 - local.plunge**2))
    return Section(edge, wedge, strip, proud, contact_speed * across, contact_speed * local.plunge)


class BallCut(NamedTuple):
    """What a ball does in some material."""

    force: FluteForce
    power: float  # [W]
    area: float  # [m^2] that is taken off, at right angles to the velocity


@compiled
def ball_cut(
    material: FloatArray, ball: BallEnd, speed_x: float, speed_y: float, speed_z: float, slices: int
) -> BallCut:
    r"""Force of all discs of a ball averaged over a tooth period, cutting power, and cross-section.

    Without edge forces the power is :math:`K_{tc} A |v|`.

    Parameters
    ----------
    material : array
        Planes that bound the material, shape (m, 4).
    ball : BallEnd
        The cutter.
    speed_x, speed_y, speed_z : float
        Velocity of the ball in the frame of the pass [m/s].
    slices : int
        Discs over the height of the contact.
    """
    theta = feed_direction(speed_x, speed_y)
    chip = feed_per_tooth(speed_x, speed_y, ball.spindle_speed, ball.flutes)
    rise = math.copysign(feed_per_tooth(speed_z, 0.0, ball.spindle_speed, ball.flutes), speed_z)
    radius = ball.ball_radius
    m = material.shape[0]
    sides = np.empty((m + 1, SIDE))
    for j in range(m):  # planes between two samples are not quite unit vectors
        sides[j] = material[j] / math.sqrt(material[j, 0] ** 2 + material[j, 1] ** 2 + material[j, 2] ** 2)
    nx, ny, nz = leading_side(speed_x, speed_y, speed_z)
    sides[m, 0], sides[m, 1], sides[m, 2], sides[m, 3] = nx, ny, nz, 0.0
    low, high = height_limits(sides, radius)
    dz = (high - low) / slices
    arcs, lean = np.empty((arc_room(m + 1), 2)), leans(sides)
    fx = fy = fz = tangential = power = area = 0.0
    for k in range(slices if dz > 0.0 else 0):
        z = low + (k + 0.5) * dz
        rho = math.sqrt(max(0.0, radius * radius - z * z))
        for i in range(disc_arcs(sides, lean, rho, z, arcs)):
            lo, hi = arcs[i, 0], arcs[i, 1]
            f = disc_force(lo, hi, z, dz, radius, chip, theta, rise, ball.flutes, ball.edges)
            fx, fy, fz, tangential = fx + f.x, fy + f.y, fz + f.z, tangential + f.tangential
            power += f.tangential * rho * ball.spindle_speed
            ahead = nx * (math.cos(hi) - math.cos(lo)) - ny * (math.sin(hi) - math.sin(lo))
            area += (rho * ahead - nz * z * (hi - lo)) * dz
    return BallCut(FluteForce(fx, fy, fz, tangential), power, area)


def pass_forces(section: Section, ball: BallEnd, slices: int = SLICES) -> PassForces:
    """Forces along a path with a rigid tool."""
    out = np.empty((len(section.speed), 8))
    _forces(section.wedge, section.burr, section.speed, section.rise, ball, slices, out)
    return PassForces(out[:, :3], out[:, 3:6], out[:, 6], out[:, 7])


@compiled
def _forces(
    wedge: FloatArray, burr: FloatArray, speed: FloatArray, rise: FloatArray, ball: BallEnd, slices: int,
    out: FloatArray,
) -> None:  # fmt: skip
    out[:] = 0.0
    for i in range(speed.size):
        for part in range(2 if burr.shape[1] > 0 else 1):
            cut = ball_cut(wedge[i] if part == 0 else burr[i], ball, speed[i], 0.0, rise[i], slices)
            f = cut.force
            out[i, 0], out[i, 1], out[i, 2] = out[i, 0] + f.x, out[i, 1] + f.y, out[i, 2] + f.z
            if part == 1:
                out[i, 3], out[i, 4], out[i, 5] = f.x, f.y, f.z
            out[i, 6], out[i, 7] = out[i, 6] + cut.power, out[i, 7] + cut.area


class Yielding(NamedTuple):
    """A pass with a compliant spindle, at the samples of the path."""

    tip: FloatArray  # [m] displacement of the tool tip in the frame of the pass, x and y, shape (n, 2)
    offset: FloatArray  # [m] displacement of the ball from the nominal path, shape (n, 3)
    tilt: FloatArray  # [rad] of the motor across the rod, along the two unit vectors of the spindle, shape (n, 2)
    force: FloatArray  # [N] in the frame of the pass where the ball is, shape (n, 3)
    unsolved: int  # time steps whose piston forces were not found


class Pass(NamedTuple):
    """How a path is run with a compliant spindle."""

    centre_speed: (
        FloatArray  # [m/s] from each sample to the next, shape (n,) for a closed path, (n - 1,) for an open one
    )
    approach: float  # [m] how much the ball is led into the work beyond the nominal path: preset and part error
    time_step: float  # [s]


def across_rod(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors across the rod, in which the motor tilts; piston azimuths count from the first."""
    across = np.eye(3)[int(np.argmin(np.abs(axis)))]
    ex = across - (across @ axis) * axis
    ex /= np.linalg.norm(ex)
    return ex, np.cross(axis, ex)


def course_of(section: Section, path: ChamferPath, local: PassFrames, axis: FloatArray, run: Pass) -> Course:
    """A path in the plane across the rod."""
    plane, closed = np.column_stack(across_rod(axis)), path.frames.closed
    spans = lengths(path.centre, closed=closed) / run.centre_speed
    speed = run.centre_speed
    if not closed:
        spans, speed = np.append(spans, spans[-1]), np.append(speed, speed[-1])
    speed = speed * np.sqrt(np.maximum(0.0, 1.0 - local.plunge**2))
    feed, off = local.feed @ plane, local.off @ plane
    height = path.centre @ axis
    climb = np.diff(height, append=height[0] if closed else 2.0 * height[-1] - height[-2]) / spans
    if closed:
        before = np.roll(spans, 1)
        turn = (np.roll(off, -1, axis=0) - np.roll(off, 1, axis=0)) / (before + spans)[:, None]
    else:
        turn = np.gradient(off, np.concatenate([[0.0], np.cumsum(spans[:-1])]), axis=0)
    return Course(
        np.column_stack([path.centre @ plane, height]), np.hstack([feed, off]), -run.approach * off,
        speed[:, None] * feed - run.approach * turn, climb, section.speed / np.maximum(speed, 1e-12), spans, closed,
    )  # fmt: skip


def yielding_pass(
    section: Section, path: ChamferPath, local: PassFrames, axis: FloatArray, ball: BallEnd, ring: PistonRing,
    reach: float, run: Pass, slices: int = SLICES,
) -> Yielding:  # fmt: skip
    """Time stepping of a compliant spindle along a chamfer path.

    The spindle yields across the rod only; preset and part error lead the ball along -y of the pass. It comes into the
    work gradually: thrown in at full depth, a soft spindle can be carried away by the cut that it would bear otherwise.
    A ball that is dragged along the feed meets the material of the place where it is, not of the one where it should
    be: round a small hole that carries it into the wall.

    Parameters
    ----------
    section, path, local : Section, ChamferPath, PassFrames
        Material, path and frames along it.
    axis : array
        Unit vector of the rod, toward the motor, shape (3,).
    ball, ring : BallEnd, PistonRing
        Cutter and compliance device.
    reach : float
        Distance from the joint to the tool tip [m].
    run : Pass
        How the path is run.
    slices : int
        Discs.
    """
    n, closed = len(section.speed), path.frames.closed
    course = course_of(section, path, local, axis, run)
    before = int(_RUN_IN * n)
    order = np.arange(-before, n) % n if closed else np.maximum(0, np.arange(-before, n))
    off = _clear(section, ball) + run.approach
    pull = off * np.clip(1.0 - np.arange(before + n) / max(1.0, _LEAD_IN * before), 0.0, 1.0)
    out = np.zeros((n, 5))
    unsolved = _yield(section, course, order, pull, ball, ring, at_rest(ring), reach, run.time_step, slices, out)
    tilt = out[:, :2]
    arm = reach - ball.ball_radius
    ex, ey = across_rod(axis)
    moved = np.outer(tilt[:, 0], ex) + np.outer(tilt[:, 1], ey)
    tip = reach * np.column_stack(
        [np.einsum("ij,ij->i", moved, local.feed), np.einsum("ij,ij->i", moved, local.off)]
    )  # fmt: skip
    return Yielding(tip, arm * moved - run.approach * local.off, tilt, out[:, 2:], unsolved)


def _clear(section: Section, ball: BallEnd) -> float:
    """How far off the work the ball has to stand to meet neither it nor the burr [m]."""
    x, y, z = section.edge.T
    reached = np.sqrt(np.maximum(0.0, ball.ball_radius**2 - x**2 - z**2)) + y
    return max(0.0, float(reached.max())) + section.proud


@compiled
def _foot(course: Course, x: float, y: float, start: int) -> tuple[int, int, float, float]:
    """Where a ball at a place across the rod is along the path.

    Two samples, how far it is from one to the other, and how much faster than it the foot goes along the path.
    """
    place, frame = course.place, course.frame
    n = len(place)
    j = start
    for _ in range(n):
        behind = (x - place[j, 0]) * frame[j, 0] + (y - place[j, 1]) * frame[j, 1]
        if behind < 0.0:
            if not course.closed and j == 0:
                return 0, 1, 0.0, 1.0
            j = (j - 1) % n
            continue
        if not course.closed and j == n - 1:
            return n - 2, n - 1, 1.0, 1.0
        k = (j + 1) % n
        ahead = (x - place[k, 0]) * frame[k, 0] + (y - place[k, 1]) * frame[k, 1]
        if ahead < 0.0:
            way = math.hypot(place[k, 0] - place[j, 0], place[k, 1] - place[j, 1])
            return j, k, behind / (behind - ahead), way / (behind - ahead)
        j = k
    return start, start, 0.0, 1.0  # no place of its own: a ball carried away farther than the path bends


@compiled
def _yield(
    section: Section, course: Course, order: FloatArray, pull: FloatArray, ball: BallEnd, ring: PistonRing,
    pistons: RingState, reach: float, dt: float, slices: int, out: FloatArray,
) -> int:  # fmt: skip
    """Time steps of one length along the whole way, the tool led on between the samples; how many were not solved."""
    qx = qy = vx = vy = 0.0
    fx = fy = fz = 0.0
    arm = reach - ball.ball_radius
    ahead = 0.0  # time from a sample to the next step
    unsolved = 0
    place, frame, lead, velocity = course.place, course.frame, course.lead, course.velocity
    f = np.empty(4)
    j = order[0]
    for number in range(order.size):
        i = order[number]
        onward = order[number + 1] if number + 1 < order.size else i
        pull_on = pull[number + 1] if number + 1 < order.size else pull[number]
        out[i, 0], out[i, 1] = qx, qy
        out[i, 2], out[i, 3], out[i, 4] = fx, fy, fz
        span = course.spans[i]
        while ahead < span:
            part_way = ahead / span
            ahead += dt
            stay = 1.0 - part_way
            pulled = stay * pull[number] + part_way * pull_on
            home_x = stay * (place[i, 0] + lead[i, 0]) + part_way * (place[onward, 0] + lead[onward, 0])
            home_y = stay * (place[i, 1] + lead[i, 1]) + part_way * (place[onward, 1] + lead[onward, 1])
            home_z = stay * place[i, 2] + part_way * place[onward, 2]
            home_x += pulled * (stay * frame[i, 2] + part_way * frame[onward, 2])
            home_y += pulled * (stay * frame[i, 3] + part_way * frame[onward, 3])
            x, y = home_x + arm * qx, home_y + arm * qy
            j, k, share, faster = _foot(course, x, y, j)
            for m in range(4):
                f[m] = frame[j, m] + share * (frame[k, m] - frame[j, m])
            near = (x - place[j, 0]) * frame[j, 2] + (y - place[j, 1]) * frame[j, 3]
            far = (x - place[k, 0]) * frame[k, 2] + (y - place[k, 1]) * frame[k, 3]
            dy = near + share * (far - near)
            dz = home_z - (place[j, 2] + share * (place[k, 2] - place[j, 2]))
            ux = stay * velocity[i, 0] + part_way * velocity[onward, 0] + arm * vx
            uy = stay * velocity[i, 1] + part_way * velocity[onward, 1] + arm * vy
            foot_speed = (ux * f[0] + uy * f[1]) * faster
            speed_x = foot_speed * (course.contact[j] + share * (course.contact[k] - course.contact[j]))
            speed_y = ux * f[2] + uy * f[3]
            speed_z = course.climb[i]  # what of it does not follow the path there goes into the work or off it
            way = math.hypot(place[k, 0] - place[j, 0], place[k, 1] - place[j, 1])
            if section.speed[j] > 0.0 and way > 0.0:
                speed_z += section.rise[j] * speed_x / section.speed[j] - (place[k, 2] - place[j, 2]) / way * foot_speed
            fx = fy = fz = 0.0
            for part in range(2 if section.burr.shape[1] > 0 else 1):
                table = section.wedge if part == 0 else section.burr
                sides = table[j] + share * (table[k] - table[j])
                sides[:, 3] -= sides[:, 1] * dy + sides[:, 2] * dz
                force = ball_cut(sides, ball, speed_x, speed_y, speed_z, slices).force
                fx, fy, fz = fx + force.x, fy + force.y, fz + force.z
            mx = arm * (fx * f[0] + fy * f[2])
            my = arm * (fx * f[1] + fy * f[3])
            qx, qy, vx, vy, sweeps = piston_step(ring, pistons, qx, qy, vx, vy, mx, my, dt)
            unsolved += sweeps >= SWEEPS
        ahead -= span
    return unsolved
