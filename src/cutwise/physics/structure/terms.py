r"""The terms of a structure in series: the same load passes through all of them, their displacements add.

A term either has mass or memory, and is stepped (pistons, a swinging arm), or answers to the force at once (joints of
an arm, bodies of a machine, a bending tool), and is solved for together with the force. The rate of the latter is
never fed back into the direction of the chip: :math:`u = C F(u, \dot u)` may have no solution that stays near.
"""

from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray, station
from cutwise.physics.structure.pistons import PistonRing, RingState, at_rest
from cutwise.physics.structure.pistons import step as piston_step
from cutwise.physics.structure.swings import Linked, LinkedState, Swinging, SwingState
from cutwise.records import Tip
from cutwise.stages import displaced, held, noted, pivot, settled, stepped, yielded, yielding


class Rigid(NamedTuple):
    """A tool that does not yield."""

    pivot: float  # [m] height of the reference point over the tip


class Pistons(NamedTuple):
    """A motor that tilts about a joint, held by a ring of pistons."""

    ring: PistonRing
    reach: float  # [m] from the joint to the tool tip


class PistonsState(NamedTuple):
    """Tilt of the motor, and its pistons."""

    tilt: FloatArray  # q_x, q_y [rad] and their rates [rad/s], shape (4,)
    before: FloatArray  # the same at the beginning of the last step, shape (4,)
    ring: RingState


class Compliance(NamedTuple):
    r"""A term without inertia, linear between stations of the path: :math:`(\delta;\varepsilon) = C(s)\,(F; m)`.

    Process axes, reference point at the tool tip: an axis at height z is displaced by
    :math:`\delta + \varepsilon \times z e_z`.
    """

    at: FloatArray  # [m] of the path, rising, shape (n,)
    matrix: FloatArray  # C [m/N, 1/N; rad/N, rad/(N m)], shape (n, 6, 6)


class ComplianceState(NamedTuple):
    """Where a term without inertia stands."""

    twist: FloatArray  # delta [m] and epsilon [rad] in the force of now, shape (6,)
    wanted: FloatArray  # the same under the force that was looked at last, shape (6,)
    slope: FloatArray  # how much less the force lets it yield for each displacement, of the last step, shape (1,)


class Series(NamedTuple):
    """Two structures one behind the other; a structure of more terms is a series of a term and a series."""

    near: NamedTuple  # at the tool
    far: NamedTuple


class SeriesState(NamedTuple):
    """The states of both."""

    near: NamedTuple
    far: NamedTuple


# --- a tool that does not yield


@pivot.of(Rigid)
def _(structure):
    return structure.pivot


@displaced.of(Rigid)
def _(structure, flexed, foot, above):
    return Tip(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@stepped.of(Rigid)
def _(structure, flexed, pose, load, dt):
    return 0


@noted.of(Rigid)
def _(structure, flexed, table, row, at):
    return at


# --- pistons


@pivot.of(Pistons)
def _(structure):
    return structure.reach


@displaced.of(Pistons)
def _(structure, flexed, foot, above):
    arm = structure.reach - foot - above
    tilt = flexed.tilt
    return Tip(arm * tilt[0], arm * tilt[1], 0.0, arm * tilt[2], arm * tilt[3], 0.0)


@stepped.of(Pistons)
def _(structure, flexed, pose, load, dt):
    tilt, before, moment = flexed.tilt, flexed.before, load.total
    for i in range(4):
        before[i] = tilt[i]
    qx, qy, vx, vy, sweeps = piston_step(
        structure.ring, flexed.ring, tilt[0], tilt[1], tilt[2], tilt[3], moment[4], moment[5], dt
    )
    tilt[0], tilt[1], tilt[2], tilt[3] = qx, qy, vx, vy
    return sweeps


@noted.of(Pistons)
def _(structure, flexed, table, row, at):
    """The tilt that the step began with, and where the pistons came to."""
    before, travel = flexed.before, flexed.ring.travel
    for i in range(4):
        table[row, at + i] = before[i]
    for i in range(travel.size):
        table[row, at + 4 + i] = travel[i]
    return at + 4 + travel.size


# --- without inertia


@pivot.of(Compliance, Swinging, Linked)
def _(structure):
    return 0.0


@displaced.of(Compliance)
def _(structure, flexed, foot, above):
    twist, height = flexed.twist, foot + above
    return Tip(twist[0] + twist[4] * height, twist[1] - twist[3] * height, twist[2], 0.0, 0.0, 0.0)


@stepped.of(Compliance)
def _(structure, flexed, pose, load, dt):
    return 0


@held.of(Compliance)
def _(structure, flexed, height):
    twist = flexed.twist
    return twist[0] + twist[4] * height, twist[1] - twist[3] * height, twist[2]


@yielded.of(Compliance)
def _(structure, flexed, pose, load, pivot, height):
    r"""Moments about the tip from those about the pivot: a force at z gives :math:`m = z e_z \times F`, and the load
    holds :math:`\sum (z_p - z) F`."""
    total, wanted, matrix = load.total, flexed.wanted, structure.matrix
    fx, fy, fz = total[0], total[1], total[2]
    mx, my = -(pivot * fy - total[5]), pivot * fx - total[4]
    at, share = station(structure.at, pose.along)
    after = min(at + 1, structure.at.size - 1)
    for i in range(6):
        here, there = matrix[at, i], matrix[after, i]
        low = here[0] * fx + here[1] * fy + here[2] * fz + here[3] * mx + here[4] * my
        high = there[0] * fx + there[1] * fy + there[2] * fz + there[3] * mx + there[4] * my
        wanted[i] = low + share * (high - low)
    return wanted[0] + wanted[4] * height, wanted[1] - wanted[3] * height, wanted[2]


@settled.of(Compliance)
def _(structure, flexed, extra_x, extra_y, extra_z):
    twist, wanted = flexed.twist, flexed.wanted
    for i in range(6):
        twist[i] = wanted[i]
    twist[0] += extra_x
    twist[1] += extra_y
    twist[2] += extra_z
    return 0


@noted.of(Compliance)
def _(structure, flexed, table, row, at):
    for i in range(6):
        table[row, at + i] = flexed.twist[i]
    return at + 6


# --- with mass


# --- which terms have to be solved for


@yielding.of(Rigid, Pistons, Swinging, Linked)
def _(structure):
    return False


@yielding.of(Compliance)
def _(structure):
    return True


@held.of(Rigid, Pistons, Swinging, Linked)
def _(structure, flexed, height):
    return 0.0, 0.0, 0.0


@yielded.of(Rigid, Pistons, Swinging, Linked)
def _(structure, flexed, pose, load, pivot, height):
    return 0.0, 0.0, 0.0


@settled.of(Rigid, Pistons, Swinging, Linked)
def _(structure, flexed, extra_x, extra_y, extra_z):
    return 0


# --- in series


@pivot.of(Series)
def _(structure):
    return pivot(structure.near)


@displaced.of(Series)
def _(structure, flexed, foot, above):
    near = displaced(structure.near, flexed.near, foot, above)
    far = displaced(structure.far, flexed.far, foot, above)
    return Tip(near.x + far.x, near.y + far.y, near.z + far.z, near.vx + far.vx, near.vy + far.vy, near.vz + far.vz)


@stepped.of(Series)
def _(structure, flexed, pose, load, dt):
    near = stepped(structure.near, flexed.near, pose, load, dt)
    far = stepped(structure.far, flexed.far, pose, load, dt)
    return max(near, far)


@yielding.of(Series)
def _(structure):
    return yielding(structure.near) or yielding(structure.far)


@held.of(Series)
def _(structure, flexed, height):
    near, far = held(structure.near, flexed.near, height), held(structure.far, flexed.far, height)
    return near[0] + far[0], near[1] + far[1], near[2] + far[2]


@yielded.of(Series)
def _(structure, flexed, pose, load, pivot, height):
    near = yielded(structure.near, flexed.near, pose, load, pivot, height)
    far = yielded(structure.far, flexed.far, pose, load, pivot, height)
    return near[0] + far[0], near[1] + far[1], near[2] + far[2]


@settled.of(Series)
def _(structure, flexed, extra_x, extra_y, extra_z):
    """The displacement besides goes to one term: only the sum counts."""
    if yielding(structure.near):
        settled(structure.near, flexed.near, extra_x, extra_y, extra_z)
        settled(structure.far, flexed.far, 0.0, 0.0, 0.0)
    else:
        settled(structure.far, flexed.far, extra_x, extra_y, extra_z)
    return 0


@noted.of(Series)
def _(structure, flexed, table, row, at):
    return noted(structure.far, flexed.far, table, row, noted(structure.near, flexed.near, table, row, at))


def in_series(terms: list[NamedTuple]) -> NamedTuple:
    """One structure of several terms, the first at the tool; moments are about its pivot."""
    terms = [term._replace(pivot=float(pivot(terms[0]))) if isinstance(term, Linked) else term for term in terms]
    structure = terms[-1]
    for term in reversed(terms[:-1]):
        structure = Series(term, structure)
    return structure


def relaxed(structure: NamedTuple) -> NamedTuple:
    """The state of a structure before anything touches it; states mirror structures."""
    match structure:
        case Series(near, far):
            return SeriesState(relaxed(near), relaxed(far))
        case Pistons(ring, _):
            return PistonsState(np.zeros(4), np.zeros(4), at_rest(ring))
        case Compliance():
            return ComplianceState(np.zeros(6), np.zeros(6), np.zeros(1))
        case Swinging():
            return SwingState(np.zeros(3), np.zeros(3))
        case Linked():
            k = structure.spring.shape[-1]
            return LinkedState(np.zeros(k), np.zeros(k), np.zeros(k), np.zeros(6), np.zeros(6))
    return ()  # type: ignore[return-value]


def displacement(term: NamedTuple, columns: FloatArray, height: float) -> FloatArray:
    """Displacement of the tool's axis at a height over its tip [m], from the columns that a term noted; shape (n, 3).

    References
    ----------
    Derived here: small rotations.
    """
    match term:
        case Compliance() | Linked():
            turned = np.column_stack([columns[:, 4] * height, -columns[:, 3] * height, np.zeros(len(columns))])
            return np.asarray(columns[:, :3] + turned)
        case Pistons(_, reach):
            return np.column_stack([(reach - height) * columns[:, :2], np.zeros(len(columns))])
    return columns[:, :3]


def turning(term: NamedTuple, columns: FloatArray) -> FloatArray:
    """Turn of the tool about the feed [rad], from the columns that a term noted; shape (n,).

    References
    ----------
    Derived here: small rotations.
    """
    match term:
        case Compliance() | Linked():
            return columns[:, 3]
        case Pistons():
            return columns[:, 1]  # a tip that swings off the work leans the tool back
    return np.zeros(len(columns))


def width(structure: NamedTuple) -> int:
    """Columns of the history that a structure notes."""
    match structure:
        case Series(near, far):
            return width(near) + width(far)
        case Pistons(ring, _):
            return 4 + len(ring.direction)
        case Compliance() | Linked():
            return 6
        case Swinging():
            return 3
    return 0
