"""The same stages at rest: place by place, no inertia."""

from typing import NamedTuple

import numpy as np

from cutwise.balance import TRIALS, balance, look
from cutwise.loop import Cell
from cutwise.maths.compiled import stepping
from cutwise.maths.curves import FloatArray
from cutwise.records import CONTACT, Contact, Load, Pose
from cutwise.stages import left, noted, yielding


class Rest(NamedTuple):
    """A cell at rest at each of some poses."""

    seen: FloatArray  # columns of the engagement, shape (n, k)
    state: FloatArray  # columns of the structure, shape (n, m)
    layer: FloatArray  # force of each layer as the force law counts it [N], shape (n, layers, 3)
    total: FloatArray  # force, tangential force, moments about the pivot (see records.Load), shape (n, 6)
    looks: FloatArray  # at the force; as many as balance.TRIALS: no equilibrium was found, shape (n,)

    @property
    def found(self) -> np.ndarray:
        """Where an equilibrium was found, shape (n,)."""
        return np.asarray(self.looks < TRIALS)


@stepping
def at_poses(cell, flexed, poses, contact, load, guess, seen, state, layer, total, looks):
    """Fill one row for each pose (n, 8), or (n, 9) with its spin; a rigid structure is taken as it stands."""
    structure = cell.structure
    for k in range(poses.shape[0]):
        row = poses[k]
        spin = row[8] if row.size > 8 else 0.0
        pose = Pose(row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], spin)
        if yielding(structure):
            count, looks[k] = balance(cell, flexed, pose, contact, load, guess)
        else:
            count = look(cell, flexed, pose, contact, load)
        left(cell.engagement, cell.stock, contact, count)
        for i in range(contact.seen.size):
            seen[k, i] = contact.seen[i]
        noted(structure, flexed, state, k, 0)
        for i in range(load.layer.shape[0]):
            for axis in range(3):
                layer[k, i, axis] = load.layer[i, axis]
        for i in range(6):
            total[k, i] = load.total[i]


def rest(
    cell: Cell, flexed: NamedTuple, poses: FloatArray, *, seen: int, state: int, layers: int = 1, contacts: int = 1
) -> Rest:
    """A cell at rest at each pose, from the displacement of the pose before.

    Parameters
    ----------
    poses : array (n, 8) or (n, 9)
        Rows of :class:`cutwise.records.Pose`; without the last column process axes do not turn.
    seen, state, layers, contacts : int
        As in :func:`cutwise.loop.march`.
    """
    count = len(poses)
    out = Rest(
        np.zeros((count, seen)), np.zeros((count, state)), np.zeros((count, layers, 3)), np.zeros((count, 6)),
        np.zeros(count),
    )  # fmt: skip
    contact = Contact(np.zeros((contacts, CONTACT)), np.zeros(seen))
    load = Load(np.zeros((layers, 3)), np.zeros(6))
    at_poses(cell, flexed, poses, contact, load, np.eye(3).ravel(), *out)
    return out
