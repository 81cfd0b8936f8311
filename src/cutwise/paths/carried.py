"""A path that a carrier takes its tool along: stations with process axes, in the frame of the carrier's base."""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.frames import FloatArray


class CarriedPath(NamedTuple):
    r"""Stations of a path, with the process axes there.

    Columns of ``axes``: :math:`x_p` along the feed, :math:`z_p` against the tool axis, and :math:`y_p` off the work:
    :math:`z_p \times x_p` with the work on the right of the feed (down milling with a right-hand tool), and
    :math:`x_p \times z_p`, a left-handed frame, with the work on the left (up milling). Every formula of the process
    frame holds in both, as long as moments and rotations are turned with :math:`\det(R) R`.
    """

    at: FloatArray  # [m] of the path, shape (n,)
    point: FloatArray  # [m] of the nominal edge or wall, shape (n, 3)
    axes: FloatArray  # shape (n, 3, 3)
    followed: bool = False  # the tool turns with the path

    @property
    def tool_axis(self) -> FloatArray:
        """Direction from the motor to the tip, shape (n, 3)."""
        return -self.axes[:, :, 2]


def stations(length: float, pitch: float) -> FloatArray:
    """Places along a path, both ends among them, no farther apart than a pitch [m].

    Examples
    --------
    >>> stations(1.0, 0.3).tolist()
    [0.0, 0.25, 0.5, 0.75, 1.0]
    """
    count = max(1, math.ceil(length / pitch - 1e-9))
    return np.linspace(0.0, length, count + 1)


def process_axes(feed: FloatArray, tool_axis: FloatArray, *, work_on_left: bool = False) -> FloatArray:
    """Process axes as columns, shape (n, 3, 3), of feed directions (n, 3) and a tool axis at right angles to them.

    Raises
    ------
    ValueError
        The tool axis is not at a right angle to the feed, to 1e-6.

    Examples
    --------
    Feed along x, tool pointing down: the axes of the base.

    >>> bool((process_axes(np.array([[2.0, 0.0, 0.0]]), np.array([0.0, 0.0, -1.0])) == np.eye(3)).all())
    True
    """
    x = feed / np.linalg.norm(feed, axis=-1, keepdims=True)
    z = -tool_axis / np.linalg.norm(tool_axis, axis=-1, keepdims=True)
    z = np.broadcast_to(z, x.shape)
    lean = np.abs((x * z).sum(axis=-1)).max()
    if lean > 1e-6:
        raise ValueError(f"the tool axis leans {math.degrees(math.asin(min(1.0, lean))):.3g} degrees along the feed")
    y = np.cross(x, z) if work_on_left else np.cross(z, x)
    return np.stack([x, y, z], axis=-1)


def line(
    start: FloatArray, end: FloatArray, tool_axis: FloatArray, pitch: float, *, work_on_left: bool = False
) -> CarriedPath:
    """A straight path between two points [m].

    ``tool_axis``: from the motor to the tip, shape (3,); ``pitch``: between stations at most [m].

    Examples
    --------
    >>> line(np.zeros(3), np.array([0.0, 0.3, 0.4]), np.array([1.0, 0.0, 0.0]), 0.3).at.round(9).tolist()
    [0.0, 0.25, 0.5]
    """
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    way = end - start
    at = stations(float(np.linalg.norm(way)), pitch)
    point = start + np.outer(at / at[-1], way)
    axes = process_axes(np.tile(way, (len(at), 1)), np.asarray(tool_axis, dtype=float), work_on_left=work_on_left)
    return CarriedPath(at, point, axes)


def across(up: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Axes at right angles to a unit vector from which angles of arcs count: x of the part (y where that is the vector
    itself), and a quarter turn to the left of it.

    Examples
    --------
    >>> [axis.tolist() for axis in across(np.array([0.0, 0.0, 1.0]))]
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    """
    world = np.array([1.0, 0.0, 0.0]) if abs(up[0]) < 0.999 else np.array([0.0, 1.0, 0.0])
    right = world - (world @ up) * up
    right /= np.linalg.norm(right)
    return right, np.cross(up, right)


def arc(
    centre: FloatArray, radius: float, first: float, sweep: float, tool_axis: FloatArray, pitch: float, *,
    work_on_left: bool = False, follow: bool = True,
) -> CarriedPath:  # fmt: skip
    """An arc around the work, in the plane at a right angle to the tool axis.

    With the work on the right the tool runs clockwise, seen from the motor.

    Parameters
    ----------
    centre : array (3,)
        [m]
    radius : float
        [m]
    first, sweep : float
        Where it starts, from x of the part (from y where that is the tool axis) towards the left, and how far it goes
        round [rad].
    follow : bool
        Process axes turn with the edge; else they keep those of the start.

    Examples
    --------
    A quarter clockwise round the work from x, seen from the motor:

    >>> path = arc(np.zeros(3), 0.1, 0.0, 0.5 * math.pi, np.array([0.0, 0.0, -1.0]), 0.1)
    >>> (path.point[-1] + 0.0).round(9).tolist()
    [0.0, -0.1, 0.0]
    """
    up = -np.asarray(tool_axis, dtype=float) / np.linalg.norm(tool_axis)
    right, ahead = across(up)
    at = stations(radius * sweep, pitch)
    sense = 1.0 if work_on_left else -1.0
    angle = first + sense * at / radius
    outward = np.outer(np.cos(angle), right) + np.outer(np.sin(angle), ahead)
    feed = sense * np.cross(up, outward)
    axes = process_axes(feed, -up, work_on_left=work_on_left)
    if not follow:
        axes = np.repeat(axes[:1], len(at), axis=0)
    return CarriedPath(at, np.asarray(centre) + radius * outward, axes, follow)


def placed(path: CarriedPath, rotation: FloatArray, origin: FloatArray) -> CarriedPath:
    """The path of a part that stands at an origin [m] with a rotation in the base frame.

    Examples
    --------
    >>> path = line(np.zeros(3), np.array([0.1, 0.0, 0.0]), np.array([0.0, 0.0, -1.0]), 1.0)
    >>> placed(path, np.eye(3), np.array([1.0, 2.0, 3.0])).point.round(9).tolist()
    [[1.0, 2.0, 3.0], [1.1, 2.0, 3.0]]
    """
    return path._replace(point=path.point @ rotation.T + origin, axes=rotation @ path.axes)
