"""A tool led along the samples of a path, its attitude kept: straight from one sample to the next."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.maths.curves import FloatArray, segment
from cutwise.records import Pose
from cutwise.stages import driven, moved


class Led(NamedTuple):
    """A path in process axes that do not turn with it, and the order in which its samples are passed.

    A closed path is run in over a part of its last round, an open one in its first place; meanwhile the tool is led
    off the work by ``pull``.
    """

    at: FloatArray  # [s] at which each knot is passed, rising, shape (k,)
    sample: NDArray[np.int64]  # of the path at each knot, shape (k,)
    pull: FloatArray  # [m] off the work, at each knot, shape (k,)
    along: FloatArray  # [m] of the path where each knot begins, shape (k,)
    stretch: FloatArray  # [m] from each knot to the next, shape (k,)
    place: FloatArray  # [m] of the samples in process axes, shape (n, 3)
    off: FloatArray  # direction off the work, x and y, shape (n, 2)
    lead: FloatArray  # [m] from there to where the tool is led, shape (n, 3)
    velocity: FloatArray  # [m/s] with which it is led across the rod, shape (n, 2)
    climb: FloatArray  # [m/s] along the rod, shape (n,)


@moved.of(Led)
def _(motion, time):
    knot = segment(motion.at, time)
    after = min(knot + 1, motion.at.size - 1)
    i, onward = motion.sample[knot], motion.sample[after]
    part = 0.0
    if after > knot:
        part = (time - motion.at[knot]) / (motion.at[after] - motion.at[knot])
    part = min(max(part, 0.0), 1.0)
    stay = 1.0 - part
    place, lead, off, velocity = motion.place, motion.lead, motion.off, motion.velocity
    pulled = stay * motion.pull[knot] + part * motion.pull[after]
    x = stay * (place[i, 0] + lead[i, 0]) + part * (place[onward, 0] + lead[onward, 0])
    y = stay * (place[i, 1] + lead[i, 1]) + part * (place[onward, 1] + lead[onward, 1])
    z = stay * (place[i, 2] + lead[i, 2]) + part * (place[onward, 2] + lead[onward, 2])
    x += pulled * (stay * off[i, 0] + part * off[onward, 0])
    y += pulled * (stay * off[i, 1] + part * off[onward, 1])
    vx = stay * velocity[i, 0] + part * velocity[onward, 0]
    vy = stay * velocity[i, 1] + part * velocity[onward, 1]
    vz = stay * motion.climb[i] + part * motion.climb[onward]
    return Pose(time, motion.along[knot] + part * motion.stretch[knot], x, y, z, vx, vy, vz, 0.0)


@driven.of(Led)
def _(motion, pose, load, dt):
    """The programmed motion knows no load."""
    return 0
