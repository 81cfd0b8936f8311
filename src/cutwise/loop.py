"""The one time loop: motion, engagement, cutting, structure and surface in every step, and one recorder.

A loop is compiled once for each combination of record classes; the laws of the rows become part of it.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cutwise.balance import TRIALS, balance, look
from cutwise.maths.compiled import inlined_stepping, stepping
from cutwise.records import CONTACT, FIXED, UNSOLVED, Contact, History, Load
from cutwise.stages import (
    driven,
    left,
    moved,
    noted,
    stepped,
    yielding,
)

IntArray = NDArray[np.int64]

CHUNK = 100_000  # steps between two looks at progress and Ctrl-C
ROWS = 40_000  # longest history


class Cell(NamedTuple):
    """What takes part in a run: a record in each slot, or nothing, and what stands in the way of the tool."""

    motion: Any
    engagement: NamedTuple
    stock: Any
    cutting: NamedTuple
    structure: Any


@inlined_stepping
def record(table, row, part, share, pose, contact, load, structure, flexed, effort):
    """Put a step into its row: the state of its first step; mean, mean square and peak of the forces of all."""
    seen, layer, total = contact.seen, load.layer, load.total
    if part == 0:
        table[row, 0] = pose.time
        table[row, 1] = pose.along
        table[row, 2] = pose.y
        for i in range(seen.size):
            table[row, FIXED + i] = seen[i]
        noted(structure, flexed, table, row, FIXED + seen.size)
    count = layer.size
    at = table.shape[1] - 3 * count - 2
    for k in range(layer.shape[0]):
        for axis in range(3):
            value = layer[k, axis]
            i = at + 3 * k + axis
            table[row, i] += value * share
            table[row, i + count] += value * value * share
            table[row, i + 2 * count] = max(table[row, i + 2 * count], abs(value))
    table[row, at + 3 * count] += total[3] * share
    table[row, at + 3 * count + 1] = max(table[row, at + 3 * count + 1], float(effort))


@stepping
def advance(cell, flexed, contact, load, guess, table, starts, row, first, steps, dt):
    """Advance a run by a number of steps; states, stock and table change in place.

    Parameters
    ----------
    cell : Cell
        The records.
    flexed : tuple
        State of the structure.
    contact, load : Contact, Load
        Scratch.
    guess : array
        Slopes of the balance in the last step, shape (9,).
    table : array
        The history.
    starts : array
        First step of each row, and the end of the last, shape (rows + 1,).
    row : int
        In which the first step belongs.
    first, steps : int
        Steps already made, and to be made.
    dt : float
        Time step [s].
    """
    structure = cell.structure
    begun, end = starts[row], starts[row + 1]
    for k in range(first, first + steps):
        time = k * dt
        pose = moved(cell.motion, time)
        if yielding(structure):
            count, trials = balance(cell, flexed, pose, contact, load, guess)
            if trials >= TRIALS:
                trials = UNSOLVED
        else:
            count, trials = look(cell, flexed, pose, contact, load), 0
        left(cell.engagement, cell.stock, contact, count)
        effort = stepped(structure, flexed, pose, load, dt)
        effort = max(effort, trials)
        record(table, row, k - begun, 1.0 / (end - begun), pose, contact, load, structure, flexed, effort)
        driven(cell.motion, pose, load, dt)
        if k + 1 == end and row + 2 < starts.size:
            row += 1
            begun, end = end, starts[row + 1]


def march(
    cell: Cell, flexed: Any, *, duration: float, time_step: float, seen: int, state: int, layers: int,
    contacts: int, stride: int = 0, starts: IntArray | None = None, progress: Callable[[float], None] | None = None,
) -> History:  # fmt: skip
    """A whole run, in portions between which progress is told and Ctrl-C is heard.

    Parameters
    ----------
    cell, flexed : Cell, tuple
        The records, and the state of the structure, which changes.
    duration, time_step : float
        [s]
    seen, state, layers : int
        Columns that the engagement shows, that the structure notes, and layers of the work.
    contacts : int
        Largest number of rows of contact.
    stride : int
        Steps in a row of the history; left out, as many as make no more than ``ROWS`` rows.
    starts : array, optional
        Instead, the first step of each row, and the end of the run, shape (rows + 1,), rising from zero.
    """
    if starts is None:
        steps = max(1, round(duration / time_step))
        stride = stride or max(1, math.ceil(steps / ROWS))
        starts = np.arange(0, math.ceil(steps / stride) * stride + 1, stride)
    steps = int(starts[-1])
    table = np.zeros((len(starts) - 1, FIXED + seen + state + 9 * layers + 2))
    contact = Contact(np.zeros((contacts, CONTACT)), np.zeros(seen))
    load = Load(np.zeros((layers, 3)), np.zeros(6))
    guess = np.eye(3).ravel()
    for first in range(0, steps, CHUNK):
        count = min(CHUNK, steps - first)
        row = int(np.searchsorted(starts, first, side="right")) - 1
        advance(cell, flexed, contact, load, guess, table, starts, row, first, count, time_step)
        if progress is not None:
            progress((first + count) / steps)
    return History(table, seen, state, layers)
