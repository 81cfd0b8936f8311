"""Contact that is known beforehand: patches of the mill's surface along a commanded path, at the servo instants.

What a program meets in its corner or its stock follows from the commanded positions; the chip follows from how the tool
really moves. The patches are those of :func:`cutwise.physics.cutting.wall.wall_force`.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.curves import FloatArray
from cutwise.stages import left, met, probed, spatial

SEEN = 3  # columns shown: commanded direction of feed, place of the tool


class Patches(NamedTuple):
    """A mill whose contact is told at ``n`` servo instants, in the axes of the machine."""

    patch: FloatArray  # arc from, to from the wall side [rad], heights over the tip from, to [m]; shape (n, p, 4)
    heading: FloatArray  # commanded direction of feed in the xy plane [rad], shape (n,)
    clock: npt.NDArray[np.int64]  # servo step of now, shape (2,): that of the drives, which change it
    pitch_time: float  # [s] from tooth to tooth; 0: nothing cuts
    ahead: bool  # the chip is that of the speed, taken along the commanded direction
    standstill: float  # [m/s] slower feed cuts nothing


@spatial.of(Patches)
def _(engagement):
    return False


@probed.of(Patches)
def _(engagement, pose):
    return 0.0, 0.0


@met.of(Patches)
def _(engagement, stock, pose, structure, flexed, contact):
    """Patches of the servo instant, with the displacement of the tool per tooth."""
    rows, seen = contact.rows, contact.seen
    k = engagement.clock[0]
    heading = engagement.heading[k]
    seen[0], seen[1], seen[2] = heading, pose.x, pose.y
    rate = math.hypot(pose.vx, pose.vy)
    if engagement.pitch_time == 0.0 or rate < engagement.standstill:
        return 0
    feed_x, feed_y = pose.vx * engagement.pitch_time, pose.vy * engagement.pitch_time
    if engagement.ahead:
        feed_x, feed_y = (
            rate * engagement.pitch_time * math.cos(heading),
            rate * engagement.pitch_time * math.sin(heading),
        )
    count = 0
    for p in range(engagement.patch.shape[1]):
        low, high = engagement.patch[k, p, 0], engagement.patch[k, p, 1]
        if high <= low:
            continue
        rows[count, 0] = 0
        rows[count, 1] = engagement.patch[k, p, 2]
        rows[count, 2] = engagement.patch[k, p, 3]
        rows[count, 3], rows[count, 4] = low, high
        rows[count, 5], rows[count, 6], rows[count, 7] = feed_x, feed_y, heading
        count += 1
    return count


@left.of(Patches)
def _(engagement, stock, contact, count):
    return 0
