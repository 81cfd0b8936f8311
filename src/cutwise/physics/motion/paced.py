"""A programmed motion that is run at another pace: slower where something cannot follow."""

from typing import Any, NamedTuple

from cutwise.maths.curves import FloatArray, segment
from cutwise.records import Pose
from cutwise.stages import driven, moved


class Paced(NamedTuple):
    """A motion, and its own time at some instants; even between them."""

    motion: Any  # nothing, where it is put in later
    at: FloatArray  # [s] rising, shape (n,)
    pace: FloatArray  # [s] of the motion, rising, shape (n,)


@moved.of(Paced)
def _(motion, time):
    """The same places, at velocities that the pace scales; beyond the ends the motion goes on as there."""
    at, pace = motion.at, motion.pace
    low = segment(at, min(max(time, at[0]), at[at.size - 1]))
    rate = (pace[low + 1] - pace[low]) / (at[low + 1] - at[low])
    pose = moved(motion.motion, pace[low] + rate * (time - at[low]))
    return Pose(
        time, pose.along, pose.x, pose.y, pose.z, rate * pose.vx, rate * pose.vy, rate * pose.vz, rate * pose.spin
    )  # fmt: skip


@driven.of(Paced)
def _(motion, pose, load, dt):
    return driven(motion.motion, pose, load, dt)
