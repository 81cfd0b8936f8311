"""A swept surface with memory: what stands along the edge as columns of height, cut down by every position of the mill.

The arcs of :mod:`cutwise.physics.engagement.arc` know the present position and direction of the mill only. Where the
mill returns to what it cut half a diameter ago, as under run-out or a fast path error, the surface itself has to be
kept. Removed area is then exact to the column: what a pass removes is what the surface loses.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.compiled import compiled
from cutwise.maths.curves import FloatArray, Polyline


class Columns(NamedTuple):
    """Strips of material along the edge; one row for each strip over the height of the mill."""

    height: FloatArray  # [m] above the nominal edge, shape (strips, columns); cut down in place
    floor: FloatArray  # [m] lowest height that a strip has anything at (0 for burr), shape (strips,)
    start: float  # [m] position of column 0
    pitch: float  # [m] between columns


def stand(burr: Polyline, start: float, end: float, pitch: float, burr_strips: int, work_strips: int) -> Columns:
    """Uncut burr strips, then work strips, over a stretch of the edge."""
    position = np.arange(start, end + pitch, pitch)
    height = np.zeros((burr_strips + work_strips, position.size))
    height[:burr_strips] = np.interp(position, burr.at, burr.value)
    floor = np.where(np.arange(burr_strips + work_strips) < burr_strips, 0.0, -np.inf)
    return Columns(height, floor, start, pitch)


@compiled
def columns_in_reach(
    x: float, bottom: float, radius: float, top: float, start: float, pitch: float, count: int
) -> tuple[int, int]:
    """First and last column (exclusive) below which the mill circle may reach under a height ``top``."""
    depth = top - bottom
    if depth <= 0.0:
        return 0, 0
    reach = radius if depth >= radius else math.sqrt(depth * (2.0 * radius - depth))
    first = max(0, math.ceil((x - reach - start) / pitch))
    last = min(count, math.floor((x + reach - start) / pitch) + 1)
    return first, last
