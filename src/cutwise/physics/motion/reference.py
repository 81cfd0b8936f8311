"""Set points of the axes, sampled from the planned motion at the controller's sample time."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.linearc import LineArc, sample
from cutwise.physics.motion.profile import Profile, at

FloatArray = npt.NDArray[np.float64]


class Reference(NamedTuple):
    """Commanded motion at the servo instants, ``n`` of them."""

    time: FloatArray  # [s], shape (n,)
    travelled: FloatArray  # arc length s along the path [m], shape (n,)
    point: FloatArray  # [m], shape (n, 3)
    direction: FloatArray  # unit tangent [-], shape (n, 3)
    block: npt.NDArray[np.int64]  # block number, shape (n,)
    speed: FloatArray  # planned speed along the path [m/s], shape (n,)
    end: float  # time at which the last point is reached [s]


def sampled(curve: LineArc, profiles: list[Profile], sample_time: float, tail: float) -> Reference:
    r"""Exact set points at :math:`t = k T_s`, :math:`k = 0 \ldots n-1`, :math:`n = \lceil T/T_s\rceil + 1 + tail/T_s`.

    Parameters
    ----------
    curve : LineArc
        The path [m].
    profiles : list
        Runs from rest to rest, one after the other; together they cover the path.
    sample_time : float
        :math:`T_s` [s].
    tail : float
        Time at the end point appended to see the axes settle [s].

    References
    ----------
    Derived here; the sampling is that of Ozcan et al. 2017, Fig. 2.
    """
    starts = np.concatenate(([0.0], np.cumsum([run.duration for run in profiles])))
    total = float(starts[-1])
    n = math.ceil(total / sample_time - 1e-9) + 1 + round(tail / sample_time)
    time = np.arange(n) * sample_time
    travelled, speed = np.empty(n), np.empty(n)
    base = 0.0
    for number, run in enumerate(profiles):
        last = number == len(profiles) - 1
        here = (time >= starts[number]) & ((time < starts[number + 1]) | last)
        position, rate, _ = at(run, time[here] - starts[number])
        travelled[here], speed[here] = base + position, rate
        base += float(run.position[-1])
    point, direction, block = sample(curve, curve.knots, travelled)
    return Reference(time, travelled, point, direction, block, speed, total)  # type: ignore[arg-type]


def central_difference(values: FloatArray, sample_time: float) -> FloatArray:
    """Rate of change along the first axis: central inside, one-sided at the ends.

    References
    ----------
    Second order inside, first at the ends.
    """
    return np.gradient(values, sample_time, axis=0)
