"""Plateaus and breakaway of a compliant spindle from raw loops of force over travel, in the order of time.

A loop goes out from the centre and back, on one side. Its plateau is the median force over the middle 60 % of the travel of
each way, its breakaway the extreme force in the first 10 % of it (assumed; the forces of a real spindle have not been tried).
"""

from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.measurements import Measurement
from cutwise.spec.faults import ScenarioFault
from cutwise.study.calibrate.posed import FloatArray

_SAME = 0.1  # share by which pressure may waver within a loop
_TURNS = 0.1  # of the largest travel: smaller turns are noise
_MIDDLE, _FIRST = (0.2, 0.8), 0.1  # of the travel of a way
_LEAST = 10  # samples of a way


class Loops(NamedTuple):
    """Loops: n of them."""

    row: np.ndarray  # of the data, where each begins (n,)
    pressure: FloatArray  # [Pa] (n,)
    forces: FloatArray  # [N] plateau out and back, breakaway out and back (n, 4)


def loops_of(data: Measurement) -> Loops:
    """The loops of a file with pressure, travel and force.

    Raises
    ------
    ScenarioFault
        No whole loop; a force that does not push back.
    """
    pressure, travel, force = (data.columns[name] for name in ("pressure", "travel", "force"))
    if np.sum(force * travel) < 0.0:
        raise ScenarioFault([data.fault(
            "the force points along the travel: it is that which holds the tip against the spindle, positive with the travel; a "
            "sign is turned"
        )])  # fmt: skip
    found = []
    for start, end in _sides(pressure, travel):
        side = 1.0 if np.sum(travel[start:end]) >= 0.0 else -1.0
        away, push = side * travel[start:end], side * force[start:end]
        for out, top, back in _ways(away):
            one = _loop(away, push, (out, top, back))
            if one is not None:
                found.append((start + out, float(np.median(pressure[start + out : start + back])), one))
    if not found:
        largest = units.show(float(np.max(np.abs(travel))), "length", 3)
        raise ScenarioFault([data.fault(
            f"holds no whole loop: from the centre out and back to it, {_LEAST} samples a way (travel reaches {largest}); is the "
            "file in the order of time?"
        )])  # fmt: skip
    rows, pressures, forces = zip(*found, strict=True)
    return Loops(np.array(rows, dtype=np.int64), np.array(pressures), np.array(forces))


def _sides(pressure: FloatArray, travel: FloatArray) -> list[tuple[int, int]]:
    """Stretches of one pressure on one side of the centre, noise about the centre left to the side before."""
    limit = 0.02 * float(np.max(np.abs(travel), initial=0.0))
    sign = np.where(travel > limit, 1, np.where(travel < -limit, -1, 0))
    side, level, begin, found = 0, float(pressure[0]), 0, []
    for k in range(len(travel)):
        other = sign[k] != 0 and side != 0 and sign[k] != side
        changed = abs(pressure[k] - level) > _SAME * abs(level)
        if other or changed:
            found.append((begin, k))
            begin, level = k, float(pressure[k])
            side = 0
        side = int(sign[k]) if sign[k] != 0 else side
    return [*found, (begin, len(travel))]


def _ways(away: FloatArray) -> list[tuple[int, int, int]]:
    """Where a way out begins, where it turns, and where the way back ends: turns smaller than a tenth are noise."""
    if len(away) < 2 * _LEAST:
        return []
    least = _TURNS * float(np.max(away))
    turns, low, high, rising = [0], 0, 0, True
    for k in range(1, len(away)):
        if rising:
            high = k if away[k] > away[high] else high
            if away[high] - away[k] > least:
                turns.append(high)
                rising, low = False, k
        else:
            low = k if away[k] < away[low] else low
            if away[k] - away[low] > least:
                turns.append(low)
                rising, high = True, k
    turns.append(len(away) - 1)
    return [(turns[k], turns[k + 1], turns[k + 2]) for k in range(0, len(turns) - 2, 2)]


def _loop(away: FloatArray, push: FloatArray, ends: tuple[int, int, int]) -> tuple[float, ...] | None:
    """Plateaus and breakaways of a loop; None where a way is too short to have them."""
    out, top, back = ends
    found = []
    for start, end, extreme in ((out, top, np.max), (top, back, np.min)):
        if end - start < _LEAST:
            return None
        here, force = away[start : end + 1], push[start : end + 1]
        gone = np.abs(here - here[0]) / max(float(np.ptp(here)), 1e-300)
        middle, first = (gone >= _MIDDLE[0]) & (gone <= _MIDDLE[1]), gone <= _FIRST
        if middle.sum() < 3 or not first.any():
            return None
        found.append((float(np.median(force[middle])), float(extreme(force[first]))))
    return found[0][0], found[1][0], found[0][1], found[1][1]
