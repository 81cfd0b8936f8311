"""A chamfer as a cell of the loop: the material along its path, and what a structure that yields makes of it."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from cutwise.loop import Cell
from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray
from cutwise.maths.edges import lengths
from cutwise.paths.chamfer.ball_path import ChamferPath
from cutwise.physics.cutting.ball import BallFlutes
from cutwise.physics.cutting.flute import FluteForce
from cutwise.physics.cutting.uneven import Edges
from cutwise.physics.engagement.ball import SIDE, PassFrames, arc_room, burr_sides, leading_side, wedge_sides
from cutwise.physics.engagement.burred_edge import Round
from cutwise.physics.engagement.wedge import LEVEL, SEEN, Wedge, discs, most_discs, passing
from cutwise.physics.motion.led import Led
from cutwise.physics.structure.terms import Pistons, displacement, width
from cutwise.process.following import Feeding, off_path
from cutwise.process.passes import at_rest, stepped, structure_of
from cutwise.records import CONTACT, UNSOLVED, Contact, Load
from cutwise.stages import cut

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


class EdgeBurr(NamedTuple):
    """A burr along an edge."""

    height: FloatArray  # [m] at each sample of a path, shape (n,)
    width: FloatArray
    side: int  # which face of the edge carries it, 0 or 1: the one along the rod is 1


class PassForces(NamedTuple):
    """Forces on the tool along a path, in the frame of the pass."""

    force: FloatArray  # [N] x feed, y off the work, z along the rod, of work and burr together, shape (n, 3)
    burr_force: FloatArray  # [N] that of the burr alone, shape (n, 3)
    felt: FloatArray  # [N] along the rod on the structure, shape (n,): a right-hand helix pulls out of the holder
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
    felt: float  # [N] along the rod on the structure: what the helix pulls counted as it is
    power: float  # [W]
    area: float  # [m^2] that is taken off, at right angles to the velocity


@compiled
def ball_cut(
    material: FloatArray, ball: BallEnd, speed_x: float, speed_y: float, speed_z: float, slices: int
) -> BallCut:
    r"""Force of all discs of a ball averaged over a tooth period, cutting power, and cross-section.

    Without edge forces the power is :math:`K_{tc} A |v|`. The rows of the loop, at one place with a rigid tool.

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
    m, radius = material.shape[0], ball.ball_radius
    sides = np.empty((m + 1, SIDE))
    sides[:m] = material
    rows = np.empty((slices * (m + 2), CONTACT))
    load = Load(np.zeros((1, 3)), np.zeros(6))
    tool = Round(radius, ball.flutes, ball.spindle_speed)
    count = discs(
        sides, np.empty((m + 1, 2)), np.empty((arc_room(m + 1), 2)), tool, speed_x, speed_y, speed_z, slices, 0, LEVEL,
        rows, 0,
    )  # fmt: skip
    cut(BallFlutes(radius, ball.flutes, ball.edges), Contact(rows, np.empty(0)), count, 0.0, 0.0, load)
    nx, ny, nz = leading_side(speed_x, speed_y, speed_z)
    area = 0.0
    for i in range(count):
        z, lo, hi = rows[i, 1] + 0.5 * rows[i, 2] - radius, rows[i, 3], rows[i, 4]
        rho = math.sqrt(max(0.0, radius * radius - z * z))
        ahead = nx * (math.cos(hi) - math.cos(lo)) - ny * (math.sin(hi) - math.sin(lo))
        area += (rho * ahead - nz * z * (hi - lo)) * rows[i, 2]
    force = FluteForce(load.layer[0, 0], load.layer[0, 1], load.layer[0, 2], load.total[3])
    return BallCut(force, load.total[2], load.total[3] * radius * ball.spindle_speed, area)


def pass_forces(section: Section, ball: BallEnd, slices: int = SLICES) -> PassForces:
    """Forces along a path with a rigid tool."""
    out = np.empty((len(section.speed), 9))
    _forces(section.wedge, section.burr, section.speed, section.rise, ball, slices, out)
    return PassForces(out[:, :3], out[:, 3:6], out[:, 8], out[:, 6], out[:, 7])


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
            out[i, 6], out[i, 7], out[i, 8] = out[i, 6] + cut.power, out[i, 7] + cut.area, out[i, 8] + cut.felt


class Yielding(NamedTuple):
    """A pass with a structure that yields, at the samples of the path."""

    tip: FloatArray  # [m] displacement of the tool tip in the frame of the pass, x and y, shape (n, 2)
    offset: FloatArray  # [m] displacement of the ball from the nominal path, shape (n, 3)
    tilt: FloatArray  # [rad] of the motor across the rod, along the two unit vectors of the spindle, shape (n, 2)
    force: FloatArray  # [N] in the frame of the pass where the ball is, shape (n, 3)
    unsolved: int  # samples at which forces of pistons or a displacement were not found
    terms: tuple[tuple[str, FloatArray], ...]  # [m] displacement of the ball by each term, in the part, shape (n, 3)


class Pass(NamedTuple):
    """How a path is run."""

    centre_speed: (
        FloatArray  # [m/s] from each sample to the next, shape (n,) for a closed path, (n - 1,) for an open one
    )
    approach: FloatArray  # [m] how much the ball is led into the work beyond the nominal path: preset and part error, shape (n,)
    time_step: float  # [s]
    sag: FloatArray  # [m] of the ball under weights, in process axes, shape (n, 3)
    feeding: Callable[[float, float], Feeding] | None = None  # feed drives, from duration and start of the motion [s]


def across_rod(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors across the rod, in which the motor tilts; piston azimuths count from the first."""
    across = np.eye(3)[int(np.argmin(np.abs(axis)))]
    ex = across - (across @ axis) * axis
    ex /= np.linalg.norm(ex)
    return ex, np.cross(axis, ex)


def process_axes(axis: FloatArray) -> FloatArray:
    """Axes in which a tool is led that keeps its attitude, as columns: two across the rod, and the rod; shape (3, 3)."""
    return np.column_stack([*across_rod(axis), axis])


def wedge_of(section: Section, path: ChamferPath, local: PassFrames, axis: FloatArray, ball: BallEnd, run: Pass,
             slices: int) -> Wedge:  # fmt: skip
    """The material along a path as the loop meets it."""
    axes = process_axes(axis)
    frame = np.hstack([local.feed @ axes[:, :2], local.off @ axes[:, :2]])
    faster = section.speed / np.maximum(_speed_across(path, local, run), 1e-12)
    return Wedge(
        Round(ball.ball_radius, ball.flutes, ball.spindle_speed), slices, path.centre @ axes, frame,
        np.ascontiguousarray(section.wedge), np.ascontiguousarray(section.burr), faster,
        np.ascontiguousarray(section.speed), np.ascontiguousarray(section.rise),
        _slopes(path.centre @ axes, closed=path.frames.closed), path.frames.closed,
    )  # fmt: skip


def _speed_across(path: ChamferPath, local: PassFrames, run: Pass) -> FloatArray:
    """Speed of the ball centre across the rod, at the samples [m/s]."""
    speed = run.centre_speed if path.frames.closed else np.append(run.centre_speed, run.centre_speed[-1])
    return np.asarray(speed * np.sqrt(np.maximum(0.0, 1.0 - local.plunge**2)))


def _slopes(place: FloatArray, *, closed: bool) -> FloatArray:
    """Way along the rod for way across it at the samples of a path (n, 3) in process axes, by central differences."""
    ahead, behind = np.roll(place, -1, axis=0), np.roll(place, 1, axis=0)
    if not closed:
        ahead[-1], behind[0] = place[-1], place[0]
    across = np.hypot(*(ahead - place)[:, :2].T) + np.hypot(*(place - behind)[:, :2].T)
    return np.asarray((ahead - behind)[:, 2] / np.maximum(across, 1e-15))


def led_along(path: ChamferPath, local: PassFrames, axis: FloatArray, run: Pass, off_work: float, run_in: int) -> Led:
    """A path as its tool is led along it, from so many samples before its start, off the work there by a way [m]."""
    axes, closed = process_axes(axis), path.frames.closed
    n, step = len(path.centre), lengths(path.centre, closed=path.frames.closed)
    spans = step / run.centre_speed
    if not closed:
        spans = np.append(spans, spans[-1])
    feed, off, place = local.feed @ axes[:, :2], local.off @ axes[:, :2], path.centre @ axes
    climb = _slopes(place, closed=closed) * _speed_across(path, local, run)
    if closed:
        before = np.roll(spans, 1)
        turn = (np.roll(off, -1, axis=0) - np.roll(off, 1, axis=0)) / (before + spans)[:, None]
    else:
        turn = np.gradient(off, np.concatenate([[0.0], np.cumsum(spans[:-1])]), axis=0)
    order = np.arange(-run_in, n) % n if closed else np.maximum(0, np.arange(-run_in, n))
    at = np.concatenate([[0.0], np.cumsum(spans[order[:-1]])])
    pull = off_work * np.clip(1.0 - np.arange(run_in + n) / max(1.0, _LEAD_IN * run_in), 0.0, 1.0)
    along = np.concatenate([[0.0], np.cumsum(step)])
    stretch = np.where(np.diff(order, append=order[-1]) == 0, 0.0, np.append(step, 0.0)[order])
    deep = run.approach[:, None]
    lead = -deep * np.column_stack([off, np.zeros(n)]) + run.sag
    velocity = (
        _speed_across(path, local, run)[:, None] * feed - deep * turn - _deeper(run.approach, spans, closed) * off
    )
    return Led(at, order, pull, along[order], stretch, place, off, lead, velocity, climb)


def _deeper(approach: FloatArray, spans: FloatArray, closed: bool) -> FloatArray:
    """How fast a path goes deeper at its samples [m/s], shape (n, 1); ``spans``: time from each to the next [s]."""
    if closed:
        rate = (np.roll(approach, -1) - np.roll(approach, 1)) / (np.roll(spans, 1) + spans)
    else:
        rate = np.gradient(approach, np.concatenate([[0.0], np.cumsum(spans[:-1])]))
    return np.asarray(rate)[:, None]


def cell_of(wedge: Wedge, led: Led, ball: BallEnd, structure: NamedTuple) -> Cell:
    """The records of the loop."""
    return Cell(
        led, wedge, passing(int(led.sample[0])), BallFlutes(ball.ball_radius, ball.flutes, ball.edges), structure
    )


def yielding_pass(
    section: Section, path: ChamferPath, local: PassFrames, axis: FloatArray, ball: BallEnd,
    terms: tuple[tuple[str, NamedTuple], ...], run: Pass, slices: int = SLICES,
) -> Yielding:  # fmt: skip
    """Time stepping of a structure that yields along a chamfer path.

    Pistons yield across the rod only; preset and part error lead the ball along -y of the pass. It comes into the work
    gradually: thrown in at full depth, a soft spindle can be carried away by the cut that it would bear otherwise.

    Parameters
    ----------
    section, path, local : Section, ChamferPath, PassFrames
        Material, path and frames along it.
    axis : array
        Unit vector of the rod, toward the motor, shape (3,).
    ball : BallEnd
        Cutter.
    terms : tuple
        The structure by name, the first term at the tool; process axes are those of :func:`process_axes`.
    run : Pass
        How the path is run.
    slices : int
        Discs.
    """
    n = len(section.speed)
    run_in = int(_RUN_IN * n)
    wedge = wedge_of(section, path, local, axis, ball, run, slices)
    led = led_along(path, local, axis, run, _clear(section, ball) + float(run.approach[0]), run_in)
    cell, passed, step, fed = cell_of(wedge, led, ball, structure_of(terms)), led.at[run_in:], run.time_step, None
    if run.feeding is not None:
        feeding = run.feeding(float(led.at[-1]), 0.0 if path.frames.closed else float(led.at[run_in]))
        fed, step = feeding.stepped(led, step)
        cell, passed = cell._replace(motion=fed), np.interp(passed, fed.pace, feeding.time)
    steps = np.ceil(passed / step - 1e-9).astype(np.int64)  # made when each sample is passed
    last = np.maximum(steps - 1, 0)  # a row of its own: the force at the place
    starts = np.unique(np.concatenate([[0], last, steps, [steps[-1] + 1]]))
    history = stepped(
        cell, duration=float(passed[-1]), time_step=step, seen=SEEN, layers=2 if section.burr.shape[1] else 1,
        contacts=most_discs(wedge), starts=starts,
    )  # fmt: skip
    columns = history.columns[np.searchsorted(starts, steps)]
    force = history.force[np.searchsorted(starts, last)].sum(axis=1)
    unsolved = int((history.effort >= UNSOLVED).sum())
    off = () if fed is None else (("drives", off_path(fed, passed) @ process_axes(axis).T),)
    return _moved(local, axis, ball, terms, run, columns, force, unsolved, off)


def yielding_at_rest(
    section: Section, path: ChamferPath, local: PassFrames, axis: FloatArray, ball: BallEnd,
    terms: tuple[tuple[str, NamedTuple], ...], run: Pass, slices: int = SLICES,
) -> Yielding:  # fmt: skip
    """As :func:`yielding_pass`, for a structure without mass or memory: place by place, with no time to step."""
    wedge = wedge_of(section, path, local, axis, ball, run, slices)
    led = led_along(path, local, axis, run, 0.0, 0)
    place = led.place + led.lead
    poses = np.column_stack([led.at, led.along, place, led.velocity, led.climb])
    found = at_rest(
        cell_of(wedge, led, ball, structure_of(terms)), poses, seen=SEEN, layers=2 if section.burr.shape[1] else 1,
        contacts=most_discs(wedge),
    )  # fmt: skip
    return _moved(local, axis, ball, terms, run, found.state, found.layer.sum(axis=1), int((~found.found).sum()))


def _moved(
    local: PassFrames, axis: FloatArray, ball: BallEnd, terms: tuple[tuple[str, NamedTuple], ...],
    run: Pass, columns: FloatArray, force: FloatArray, unsolved: int, off: tuple[tuple[str, FloatArray], ...] = (),
) -> Yielding:  # fmt: skip
    """Ball and tip from the columns that the terms of a structure noted, and what else takes the ball off its path."""
    axes, n = process_axes(axis), len(columns)
    tip, tilt, each, at = np.zeros((n, 3)), np.zeros((n, 2)), [], 0
    for name, term in terms:
        here = columns[:, at : at + width(term)]
        each.append((name, displacement(term, here, ball.ball_radius) @ axes.T))
        tip += displacement(term, here, 0.0) @ axes.T
        if isinstance(term, Pistons):
            tilt = here[:, :2]
        at += width(term)
    each += off
    offset = sum((one for _, one in each), np.zeros((n, 3))) - run.approach[:, None] * local.off + run.sag @ axes.T
    seen = np.column_stack([np.einsum("ij,ij->i", tip, local.feed), np.einsum("ij,ij->i", tip, local.off)])
    return Yielding(seen, offset, tilt, force, unsolved, tuple(each))


def _clear(section: Section, ball: BallEnd) -> float:
    """How far off the work the ball has to stand to meet neither it nor the burr [m]."""
    x, y, z = section.edge.T
    reached = np.sqrt(np.maximum(0.0, ball.ball_radius**2 - x**2 - z**2)) + y
    return max(0.0, float(reached.max())) + section.proud
