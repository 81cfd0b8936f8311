"""Postures of an arm along a path: which branch, which angle of the tool about its axis, and how fast the joints turn."""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.frames import FloatArray


class Postures(NamedTuple):
    """One posture for each station of a path."""

    q: FloatArray  # joint angles [rad], shape (n, 6)
    angle: FloatArray  # of the tool about its axis [rad], shape (n,)


class Blocked(ValueError):
    """No posture leads along the path: at which station, and what stands in the way."""

    def __init__(self, station: int, why: str) -> None:
        super().__init__(why)
        self.station = station


def followed(q: FloatArray, allowed: np.ndarray, start: FloatArray | None) -> FloatArray:
    """One branch along a path, by continuity.

    Parameters
    ----------
    q : array (n, 8, 6)
        Solutions of each station [rad], each within its limits where ``allowed``.
    allowed : array of bool (n, 8)
        Which of them may be taken.
    start : array (6,) or None
        Posture near which the first station is taken; without it the middle of the joints' range is.

    Raises
    ------
    Blocked
        A station without a solution near that of the station before.

    References
    ----------
    Derived here: continuity.
    """
    last = np.zeros(q.shape[2]) if start is None else np.asarray(start)
    taken = np.empty((len(q), q.shape[2]))
    for k, (rows, good) in enumerate(zip(q, allowed, strict=True)):
        if not good.any():
            raise Blocked(k, "no posture within the limits of the joints")
        gap = np.where(good, np.abs(rows - last).max(axis=1), math.inf)
        if k and gap.min() > 0.5 * math.pi:
            raise Blocked(k, "the arm would have to change its branch")
        last = taken[k] = rows[int(np.argmin(gap))]
    return taken


def joint_rates(q: FloatArray, at: FloatArray) -> FloatArray:
    """How far each joint turns for each length of path, between stations [rad/m], shape (n - 1, 6).

    References
    ----------
    Differences.
    """
    return np.diff(q, axis=0) / np.diff(at)[:, None]


def cheapest_way(cost: FloatArray, q: FloatArray, reach: FloatArray) -> np.ndarray:
    """Angle and branch at each station with the least sum of costs; neighbours at most one angle apart.

    Dynamic programming over stations, angles (cyclic) and branches; a branch is kept.

    Parameters
    ----------
    cost : array (n, a, b)
        Of each station, angle and branch; infinite where it may not be taken.
    q : array (n, a, b, 6)
        Joint angles [rad].
    reach : array (n - 1, 6) or (6,)
        Largest turn of each joint from each station to the next [rad].

    Returns
    -------
    array of int (n, 2)
        Angle and branch.

    Raises
    ------
    Blocked
        The first station that no way reaches.

    References
    ----------
    Bellman 1957, Dynamic Programming.
    """
    count, angles, branches = cost.shape
    reach = np.broadcast_to(reach, (count - 1, np.shape(reach)[-1]))
    total, came = cost[0].copy(), np.zeros((count, angles, branches), dtype=np.int8)
    for k in range(1, count):
        best, step = np.full((angles, branches), math.inf), np.zeros((angles, branches), dtype=np.int8)
        for shift in (-1, 0, 1):
            before = np.roll(total, shift, axis=0)
            turned = np.abs(q[k] - np.roll(q[k - 1], shift, axis=0))
            tried = np.where((turned <= reach[k - 1]).all(axis=-1), before, math.inf)
            better = tried < best
            best, step = np.where(better, tried, best), np.where(better, shift, step)
        total, came[k] = best + cost[k], step
        if not np.isfinite(total).any():
            why = "a joint would have to turn faster than it can" if np.isfinite(cost[k]).any() else "no posture"
            raise Blocked(k, f"{why} within the limits of the joints")
    way = np.empty((count, 2), dtype=np.int64)
    angle, branch = np.unravel_index(int(np.argmin(total)), total.shape)
    for k in range(count - 1, -1, -1):
        way[k] = angle, branch
        angle = (angle - came[k, angle, branch]) % angles
    return way
