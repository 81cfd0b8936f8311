"""Phases of constant jerk, written one after the other."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.maths.compiled import compiled
from cutwise.physics.motion.profile import ramp_time

FloatArray = npt.NDArray[np.float64]


class Rows(NamedTuple):
    """Phases written so far."""

    table: FloatArray  # time [s], position [m], speed [m/s], acceleration, jerk at the start of each; shape (5, room)
    count: int  # type: ignore[assignment]
    time: float  # [s] at the end


@compiled
def put_phase(rows: Rows, duration: float, s: float, v: float, a: float, j: float) -> Rows:
    """One more phase, if it takes time.

    Parameters
    ----------
    rows : Rows
        What is written so far; its table is changed, or replaced by a larger one if it is full.
    duration : float
        [s]; a phase of none is left out.
    s, v, a, j : float
        Position [m], speed [m/s], acceleration [m/s^2] and jerk [m/s^3] at its start.

    Returns
    -------
    Rows
        With the phase. Valid for tables with room for three phases or more.

    Examples
    --------
    >>> rows = put_phase(Rows(np.zeros((5, 4)), 0, 0.0), 0.5, 0.0, 0.0, 0.0, 2.0)
    >>> rows.count, rows.time, rows.table[:, 0].tolist()
    (1, 0.5, [0.0, 0.0, 0.0, 0.0, 2.0])

    References
    ----------
    Derived here.
    """
    if duration <= 0.0:
        return rows
    table = rows.table
    n = rows.count
    if n >= table.shape[1]:
        table = np.empty((5, 4 * n // 3))
        table[:, :n] = rows.table
    table[0, n], table[1, n], table[2, n], table[3, n], table[4, n] = rows.time, s, v, a, j
    return Rows(table, rows.count + 1, rows.time + duration)


@compiled
def put_ramp(rows: Rows, s: float, v0: float, v1: float, acceleration: float, jerk: float) -> Rows:
    r"""Phases of a ramp up or down that begins at ``s``.

    .. math:: v = v_0 + \tfrac12 j t^2, \quad v_0 + \tfrac12 j t_1^2 + a (t - t_1), \quad v_1 - \tfrac12 j (T - t)^2

    with :math:`t_1 = \min(a/j, T/2)` and T of :func:`~cutwise.physics.motion.profile.ramp_time`.

    Parameters
    ----------
    rows : Rows
        What is written so far.
    s : float
        Position at the start [m].
    v0, v1 : float
        Speeds at both ends [m/s], without acceleration.
    acceleration, jerk : float
        Limits [m/s^2], [m/s^3], positive.

    Returns
    -------
    Rows
        With two or three phases more, or none where the speed does not change. Valid for ramps between states without
        acceleration.

    Examples
    --------
    2 m/s at 2 m/s^2 and 4 m/s^3: three phases of 0.5 s, which begin at 0, 0.5 and 1.5 m/s.

    >>> rows = put_ramp(Rows(np.zeros((5, 4)), 0, 0.0), 0.0, 0.0, 2.0, 2.0, 4.0)
    >>> rows.time, rows.table[2, :3].tolist()
    (1.5, [0.0, 0.5, 1.5])

    References
    ----------
    Biagiotti & Melchiorri 2008, Trajectory Planning for Automatic Machines and Robots, sec. 3.4.
    """
    total = ramp_time(v1 - v0, acceleration, jerk)
    if total <= 0.0:
        return rows
    j = math.copysign(jerk, v1 - v0)
    rise = min(0.5 * total, acceleration / jerk)
    hold = total - 2.0 * rise
    if hold < 1e-14 * total:
        rise, hold = 0.5 * total, 0.0
    a = j * rise
    rows = put_phase(rows, rise, s, v0, 0.0, j)
    s, v = s + rise * (v0 + rise * rise * j / 6.0), v0 + 0.5 * a * rise
    rows = put_phase(rows, hold, s, v, a, 0.0)
    s, v = s + hold * (v + 0.5 * a * hold), v + a * hold
    return put_phase(rows, rise, s, v, a, -j)
