"""What the stages hand to one another over a whole run: named tuples of SI arrays, unit and shape on every field.

Inside a time step the stages pass the small tuples that each of them defines (``ToolMotion``, ``LayerArcs``,
``FluteForce`` ...); these are their histories. A history may be thinned: a row then stands for an interval of several
steps, of which forces keep mean, mean square and peak, so that no statistic is lost.
"""

from typing import NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray


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


class EdgeHistory(NamedTuple):
    """A pass along an edge, all stages."""

    motion: Motion
    engagement: Engagement
    burr_force: Wrench
    work_force: Wrench
    tangential: FloatArray  # [N] mean tangential force, shape (n,)
    response: Response


class Surface(NamedTuple):
    """The profile left behind."""

    position: FloatArray  # [m] along the edge, shape (m,)
    height: FloatArray  # [m] of the envelope of the tool above the nominal edge, shape (m,)
    error: FloatArray  # [m] e = min(height, burr height), shape (m,)
    burr_height: FloatArray  # [m] before the pass, shape (m,)


_EDGE_COLUMNS = 33


def empty_rows(rows: int, pistons: int) -> FloatArray:
    """Room for a pass of a number of rows: one table, because a kernel hands one array on for next to nothing."""
    return np.zeros((rows, _EDGE_COLUMNS + pistons))


def edge_history(rows: FloatArray) -> EdgeHistory:
    """The table that the loop filled, by name."""

    def wrench(column: int) -> Wrench:
        return Wrench(*(rows[:, c : c + 3] for c in (column, column + 6, column + 12)))

    return EdgeHistory(
        Motion(*rows[:, 0:3].T),
        Engagement(*rows[:, 3:9].T),
        wrench(13),
        wrench(16),
        rows[:, 31],
        Response(rows[:, 9:11], rows[:, 11:13], rows[:, _EDGE_COLUMNS:], rows[:, 32]),
    )
