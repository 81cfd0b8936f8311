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
    count: int
    time: float  # [s] at the end


@compiled
def put_phase(rows: Rows, duration: float, s: float, v: float, a: float, j: float) -> Rows:
    """One more phase, if it takes time."""
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
    """Phases of a ramp up or down that begins at ``s``."""
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
