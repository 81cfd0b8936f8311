"""What the stages hand to one another: inside a time step, and over a whole run. SI, unit and shape on every field.

Process frame: x along the feed, y off the work, z along the spindle to the motor; forces are on the tool. A history
may be thinned: a row then stands for an interval of several steps, of which forces keep mean, mean square and peak,
so that no statistic is lost.
"""

from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray

UNSOLVED = 2000
"""Effort of a step whose state was not found: no solver takes as many trials otherwise."""


class Pose(NamedTuple):
    """The undeflected tool at one instant."""

    time: float  # [s]
    along: float  # [m] of the path behind it
    x: float  # [m] along the feed
    y: float  # [m] lowest point of the tool above the nominal surface
    z: float  # [m] along the spindle
    vx: float  # [m/s]
    vy: float
    vz: float
    spin: float  # [rad/s] at which the process axes turn about z, clockwise: with the edge, where the tool follows it


class Tip(NamedTuple):
    """Displacement of the tool's axis at one height, and its rate."""

    x: float  # [m]
    y: float
    z: float
    vx: float  # [m/s]
    vy: float
    vz: float


class Contact(NamedTuple):
    """Where the edges are in the material, row by row, and what the engagement shows of itself."""

    rows: FloatArray  # layer, foot and width [m] over the tip; the rest between an engagement and its force law
    seen: FloatArray  # columns of the history that the engagement fills, shape (k,)


class Load(NamedTuple):
    """Force of the cut on the tool."""

    layer: FloatArray  # [N] x, y and z as the force law counts it, of each layer of the work, shape (layers, 3)
    total: FloatArray  # [N] x, y, z to the motor; tangential [N]; force times arm about the pivot, x, y [N m]; (6,)


CONTACT = 12  # columns of a row of contact


class Motion(NamedTuple):
    """What the tool is told, n rows."""

    time: FloatArray  # [s], shape (n,)
    position: FloatArray  # [m] along the feed, shape (n,)
    height: FloatArray  # [m] lowest point of the undeflected tool above the nominal edge, shape (n,)


class Engagement(NamedTuple):
    """How the tool is immersed, at the start of each row."""

    burr_depth: FloatArray  # [m] radial depth in the burr, shape (n,)
    work_depth: FloatArray  # [m] radial depth in the work, shape (n,)
    feed_direction: FloatArray  # [rad], shape (n,)
    chip: FloatArray  # [m] feed per tooth, shape (n,)
    entry: FloatArray  # [rad] where the first arc begins, shape (n,)
    exit: FloatArray  # [rad] where the last arc ends, shape (n,)


class Wrench(NamedTuple):
    """Cutting forces on the tool over each row, in the process frame (x feed, y off the work, z along the spindle)."""

    mean: FloatArray  # [N], shape (n, 3)
    square: FloatArray  # [N^2] mean square, shape (n, 3)
    peak: FloatArray  # [N] largest magnitude, shape (n, 3)


class Response(NamedTuple):
    """How the structure yields, at the start of each row."""

    tilt: FloatArray  # [rad] about the joint, as displacement over distance along x and y, shape (n, 2)
    tilt_rate: FloatArray  # [rad/s], shape (n, 2)
    travel: FloatArray  # [m] of the pistons, shape (n, pistons)
    sweeps: FloatArray  # solver sweeps, largest of the row, shape (n,)
    behind: FloatArray  # columns of the terms behind the spindle, shape (n, k)


class EdgeHistory(NamedTuple):
    """A pass along an edge, all stages."""

    motion: Motion
    engagement: Engagement
    burr_force: Wrench
    work_force: Wrench
    tangential: FloatArray  # [N] mean tangential force, shape (n,)
    response: Response
    fed: FloatArray | None = None  # deviation by feed drives in process axes [m], shape (n, 3)


class Surface(NamedTuple):
    """The profile left behind."""

    position: FloatArray  # [m] along the edge, shape (m,)
    height: FloatArray  # [m] of the envelope of the tool above the nominal edge, shape (m,)
    error: FloatArray  # [m] e = min(height, burr height), shape (m,)
    burr_height: FloatArray  # [m] before the pass, shape (m,)


class History(NamedTuple):
    """A run as one table; a row stands for some steps."""

    table: FloatArray  # shape (rows, columns): FIXED, then seen, state, forces, tangential force, effort
    seen: int  # columns of the engagement
    state: int  # columns of the structure
    layers: int  # of the work: mean, mean square and peak of x, y, z of each

    @property
    def shown(self) -> FloatArray:
        """Columns of the engagement, shape (rows, seen)."""
        return self.table[:, FIXED : FIXED + self.seen]

    @property
    def columns(self) -> FloatArray:
        """Columns of the structure, shape (rows, state)."""
        return self.table[:, FIXED + self.seen : FIXED + self.seen + self.state]

    @property
    def force(self) -> FloatArray:
        """Mean force of each layer of the work as the force law counts it [N], shape (rows, layers, 3)."""
        first = FIXED + self.seen + self.state
        return self.table[:, first : first + 3 * self.layers].reshape(len(self.table), self.layers, 3)

    @property
    def tangential(self) -> FloatArray:
        """Mean tangential force [N], shape (rows,): times radius and spindle speed, the power of the cut."""
        return self.table[:, -2]

    @property
    def effort(self) -> FloatArray:
        """Largest effort of the solvers in the steps of each row, shape (rows,)."""
        return self.table[:, -1]


FIXED = 3  # first columns of a history: time, place along the path, programmed height
TILT = 4  # columns of a tilting motor: tilt and its rate


def edge_history(history: History, pistons: int | None) -> EdgeHistory:
    """A pass along an edge by name; of a rigid spindle (None) there is no tilt."""
    table = history.table
    state = FIXED + history.seen
    forces = state + history.state
    layers = 3 * history.layers

    def wrench(column: int) -> Wrench:
        return Wrench(*(table[:, c : c + 3] for c in (column, column + layers, column + 2 * layers)))

    tilt = np.zeros((len(table), TILT)) if pistons is None else table[:, state : state + TILT]
    first = state if pistons is None else state + TILT
    travel = first + (pistons or 0)
    return EdgeHistory(
        Motion(*table[:, :FIXED].T),
        Engagement(*table[:, FIXED:state].T),
        wrench(forces),
        wrench(forces + 3),
        table[:, -2],
        Response(tilt[:, :2], tilt[:, 2:], table[:, first:travel], table[:, -1], table[:, travel:forces]),
    )
