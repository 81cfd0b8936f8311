"""Motion along an edge that is an arc: the tool keeps its attitude, or turns with the edge."""

import math
from typing import NamedTuple

from cutwise.physics.motion.edge import EdgePass, programmed_motion
from cutwise.records import Pose
from cutwise.stages import driven, moved


class ArcFixed(NamedTuple):
    """A pass along an arc by a tool that keeps its attitude: process axes are those of the start."""

    edge: EdgePass  # feed, leads and errors along the edge
    radius: float  # [m] of the edge
    mill: float  # [m] radius of the mill


class ArcFollowed(NamedTuple):
    """A pass along an arc by a tool that a robot turns with the edge: process axes turn along."""

    edge: EdgePass
    radius: float  # [m] of the edge
    mill: float  # [m] radius of the mill


@moved.of(ArcFixed)
def _(motion, time):
    r"""Axis of the undeflected mill, seen from the centre of the arc.

    With :math:`\psi = v_f t / \rho` and the distance :math:`D = \rho + R + h` at the programmed height h, the axis is at
    :math:`(D \sin\psi, D \cos\psi)`.
    """
    tool = programmed_motion(motion.edge, time)
    rate = motion.edge.feed / motion.radius
    distance = motion.radius + motion.mill + tool.height
    sine, cosine = math.sin(tool.position / motion.radius), math.cos(tool.position / motion.radius)
    return Pose(
        time, tool.position, distance * sine, distance * cosine, 0.0,
        tool.climb * sine + rate * distance * cosine, tool.climb * cosine - rate * distance * sine, 0.0, 0.0,
    )  # fmt: skip


@moved.of(ArcFollowed)
def _(motion, time):
    """Axis of the undeflected mill, seen from the centre of the arc in axes that turn with the edge."""
    tool = programmed_motion(motion.edge, time)
    rate = motion.edge.feed / motion.radius
    distance = motion.radius + motion.mill + tool.height
    return Pose(time, tool.position, 0.0, distance, 0.0, rate * distance, tool.climb, 0.0, rate)


@driven.of(ArcFixed, ArcFollowed)
def _(motion, pose, load, dt):
    """The programmed motion knows no load."""
    return 0
