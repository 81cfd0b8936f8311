"""The largest forces of a milling run between the substeps of its drives."""

import math

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray
from cutwise.physics.cutting.wall import AVERAGED, DELAYED, wall_force
from cutwise.process.loops_drives import NO_FORCE, Cut
from cutwise.process.milling import MillRun

_PLACES = 400  # servo steps with the largest sampled forces that are looked at again, for each component
_PER_TOOTH = 720  # angles in a tooth period there


def largest_forces(done: MillRun, sample_time: float) -> FloatArray:
    """Largest magnitude of x, y, z and of the xy vector [N], shape (4,).

    The loop evaluates the force once a substep, so that a peak between two of them is missed by up to some percent. The
    servo steps with the largest forces are gone through again at 720 angles a tooth period, with the contact of the step
    and the speed between its ends. A tip on modes has its own, finer step: its peaks are those of the loop.
    """
    sampled = done.history.force_peak
    found = sampled.max(axis=0)
    cut = done.cut
    if cut.law in (NO_FORCE, AVERAGED, DELAYED):
        return found
    count = max(2, math.ceil(_PER_TOOTH * sample_time * cut.spindle * cut.mill.flutes / (2.0 * math.pi)))
    last = len(sampled) - 1
    heading = np.arctan2(done.reference.direction[:, 1], done.reference.direction[:, 0])
    for column in range(4):
        rows = np.argsort(sampled[:last, column])[-_PLACES:]
        rows = rows[sampled[rows, column] > 0.0]
        finer = _largest(rows, cut, done.contact.patches, heading, done.history.speed, sample_time, count)
        found = np.maximum(found, finer)
    return found


@compiled
def _largest(
    rows: FloatArray, cut: Cut, patches: FloatArray, heading: FloatArray, speed: FloatArray, sample_time: float,
    count: int,
) -> FloatArray:  # fmt: skip
    top = np.zeros(4)
    pitch_time = 2.0 * math.pi / (cut.spindle * cut.mill.flutes)
    for k in rows:
        for m in range(count):
            part = (m + 0.5) / count
            vx = speed[k, 0] + part * (speed[k + 1, 0] - speed[k, 0])
            vy = speed[k, 1] + part * (speed[k + 1, 1] - speed[k, 1])
            if math.hypot(vx, vy) < cut.standstill:
                continue
            angle = -cut.spindle * (k + part) * sample_time
            fx, fy, fz = 0.0, 0.0, 0.0
            for p in range(patches.shape[1]):
                low, high, bottom, upper = patches[k, p, 0], patches[k, p, 1], patches[k, p, 2], patches[k, p, 3]
                if high > low:
                    gx, gy, gz = wall_force(
                        cut.law, angle, heading[k], low, high, bottom, upper, vx * pitch_time, vy * pitch_time,
                        cut.mill, cut.discs, cut.edges,
                    )  # fmt: skip
                    fx, fy, fz = fx + gx, fy + gy, fz + gz
            top[0], top[1], top[2] = max(top[0], abs(fx)), max(top[1], abs(fy)), max(top[2], abs(fz))
            top[3] = max(top[3], math.hypot(fx, fy))
    return top
