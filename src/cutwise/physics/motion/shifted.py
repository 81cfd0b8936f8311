"""A programmed motion that stands off its path by what changes slowly along it, such as the sag of an arm."""

from typing import NamedTuple

from cutwise.maths.curves import FloatArray, station
from cutwise.records import Pose
from cutwise.stages import driven, moved


class Shifted(NamedTuple):
    """A motion, and what is added to its place; straight between stations."""

    motion: NamedTuple
    at: FloatArray  # [m] of the path, rising, shape (n,)
    by: FloatArray  # [m] along x, y and z, shape (n, 3)


@moved.of(Shifted)
def _(motion, time):
    """The rate of what changes slowly is left out."""
    pose, by = moved(motion.motion, time), motion.by
    low, share = station(motion.at, pose.along)
    after = min(low + 1, motion.at.size - 1)
    x = by[low, 0] + share * (by[after, 0] - by[low, 0])
    y = by[low, 1] + share * (by[after, 1] - by[low, 1])
    z = by[low, 2] + share * (by[after, 2] - by[low, 2])
    return Pose(
        pose.time, pose.along, pose.x + x, pose.y + y, pose.z + z, pose.vx, pose.vy, pose.vz, pose.spin
    )  # fmt: skip


@driven.of(Shifted)
def _(motion, pose, load, dt):
    return driven(motion.motion, pose, load, dt)
