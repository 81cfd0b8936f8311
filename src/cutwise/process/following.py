"""Feed drives under a programmed motion: their axes, the pace at which a machine starts and stops, and the time steps."""

import math
from typing import Any, NamedTuple

import numpy as np

from cutwise.maths.curves import FloatArray
from cutwise.maths.linearc import join, line
from cutwise.physics.motion.drives import Drive, axes_of
from cutwise.physics.motion.following import Followed, deviation, followed
from cutwise.physics.motion.lookahead import plan
from cutwise.physics.motion.reference import sampled
from cutwise.process.assemble_mill import divided_by, feed_drives, motion_limits
from cutwise.spec.drives import CncMachine


class Feeding(NamedTuple):
    """Feed drives that move a tool along a path."""

    drives: tuple[Drive, ...]
    pace: FloatArray  # [s] of the programmed motion at the servo instants, shape (n,)
    turn: FloatArray  # process axes as columns in those of the machine, shape (3, 3)
    substeps: int  # in a servo step, at least

    @property
    def sample_time(self) -> float:
        """[s]"""
        return self.drives[0].law.sample_time

    @property
    def time(self) -> FloatArray:
        """The servo instants [s], shape (n,)."""
        return np.arange(float(len(self.pace))) * self.sample_time

    @property
    def duration(self) -> float:
        """[s]"""
        return (len(self.pace) - 1) * self.sample_time

    def stepped(self, motion: Any, time_step: float) -> tuple[Followed, float]:
        """The drives at rest on a programmed motion, and their time step: no longer than one that is asked for [s]."""
        substeps = self.substeps * divided_by(self.sample_time, self.substeps, time_step)
        return followed(motion, self.pace, axes_of(self.drives, substeps), self.turn, substeps), (
            self.sample_time / substeps
        )  # fmt: skip


def off_path(motion: Followed, time: FloatArray) -> FloatArray:
    """Deviation by the drives at some times [s], process axes [m], shape (m, 3)."""
    step = motion.axes[0].law.sample_time
    at = np.arange(len(motion.pace)) * step
    return np.column_stack([np.interp(time, at, one) for one in deviation(motion).T])


def along_a_line(
    machine: CncMachine, key: str, start: FloatArray, end: FloatArray, feed: float, turn: FloatArray, substeps: int
) -> Feeding:  # fmt: skip
    """From rest to rest along a line, as quickly as the limits of the machine let it be fed.

    Parameters
    ----------
    key : str
        Dotted key of the drives, for messages.
    start, end : array (3,)
        [m]
    feed : float
        [m/s]
    turn : array (3, 3)
        Process axes as columns.
    """
    drives = feed_drives(machine, key)
    curve = join([line(start.tolist(), end.tolist())])
    limits, axes = motion_limits(machine)
    motion = plan(curve, np.full(1, feed), limits, axes=axes)
    reference = sampled(curve, [motion.profile], drives[0].law.sample_time, 0.0)
    return Feeding(drives, reference.travelled / feed, turn, substeps)


def ramped(
    machine: CncMachine, key: str, speed: float, duration: float, begins: float, turn: FloatArray, substeps: int
) -> Feeding:  # fmt: skip
    r"""At the pace of the program, but for a start from rest: :math:`\dot\tau` rises as half a cosine over a time r.

    .. math:: r = \max(\pi v / 2a,\; \pi \sqrt{v / 2j})

    Parameters
    ----------
    key : str
        Dotted key of the drives, for messages.
    speed, duration : float
        v [m/s], and time of the programmed motion [s]; its path is run at the speeds that it asks for.
    begins : float
        Time of the programmed motion at which it starts to move [s].
    """
    drives = feed_drives(machine, key)
    step, limits = drives[0].law.sample_time, machine.limits
    ramp = max(
        0.5 * math.pi * speed / limits.acceleration, math.pi * math.sqrt(0.5 * speed / limits.jerk), step
    )  # fmt: skip
    time = np.arange(math.ceil((duration + 0.5 * ramp) / step - 1e-9) + 2) * step
    later = time - begins
    share = np.clip(later / ramp, 0.0, 1.0)
    started = 0.5 * ramp * (share - np.sin(math.pi * share) / math.pi)  # the integral of the rising pace
    pace = np.where(later <= 0.0, time, begins + started + np.maximum(0.0, later - ramp))
    return Feeding(drives, np.minimum(pace, duration), turn, substeps)
