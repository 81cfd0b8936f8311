r"""Arms whose joints do not each have a motor of their own: held joints, followers, parallel linkages.

The joint angles of a chain are :math:`q = G\theta + g`, with one column of :math:`G` for every motor. A seven-axis arm
with one joint held has a row of zeros; a follower (``mimic`` in a URDF) the row of its leader times a ratio; a forearm
that a parallel linkage drives from the base, with the motor angles :math:`\theta_2, \theta_3`,
:math:`q_3 = \theta_3 - \theta_2`. What the motors yield by moves the tool by :math:`C = J G K^{-1} (J G)^T`.
"""

import math
from typing import NamedTuple

import numpy as np

from cutwise.maths.chains import REVOLUTE, Chain, chain, frames
from cutwise.maths.frames import FloatArray

_SAME = 1e-9  # m or rad: lines and directions that differ by less are one


class Drives(NamedTuple):
    """How motors and held joints turn the n joints of a chain."""

    rows: FloatArray  # G [rad per rad], shape (n, 6): the six motors
    offsets: FloatArray  # g [rad], shape (n,)
    elastic: FloatArray  # [rad per rad], shape (n, k): everything that yields, motors and held joints
    bounded: FloatArray  # angles between links that have limits of their own, per motor, shape (b, 6)
    bounds: FloatArray  # [rad] lower and upper limit of these, shape (b, 2)

    def joints(self, motors: FloatArray) -> FloatArray:
        """Joint angles (..., n) of motor angles (..., 6)."""
        return np.asarray(motors @ self.rows.T + self.offsets)


class SixAxes(NamedTuple):
    """Six turning axes that move the last frame as the motors of an arm do."""

    chain: Chain
    to_motors: FloatArray  # motor angles from angles about these axes, shape (6, 6)
    rotation: FloatArray  # last frame of the arm in the last frame of this chain, shape (3, 3)
    origin: FloatArray  # [m], shape (3,)


class NotSixAxesError(ValueError):
    """The joints do not move the tool as six independent turning axes do; the message says why."""


def direct(count: int = 6) -> Drives:
    """Every joint with a motor of its own."""
    return Drives(np.eye(count), np.zeros(count), np.eye(count), np.zeros((0, count)), np.zeros((0, 2)))


def is_direct(drives: Drives) -> bool:
    """Whether joint angles are motor angles."""
    return drives.rows.shape == (6, 6) and np.array_equal(drives.rows, np.eye(6)) and not drives.offsets.any()


def six_axes(arm: Chain, drives: Drives) -> SixAxes:
    r"""Reduce a chain to six axes.

    Held joints become part of the links. Joints about one line add. A joint and a follower that undoes its turn about a
    parallel axis move what comes behind without turning it, by :math:`(R - I)(o_f - o_d)`: the pair may stand anywhere
    with the same distance, so that the follower is put onto the line of a parallel neighbour and adds to it. This is
    the parallelogram of a linkage.

    Raises
    ------
    NotSixAxesError
        Fewer or more than six axes are left, or they do not move independently.

    References
    ----------
    Derived here from the screws of the joints.
    """
    if is_direct(drives) and len(arm.kinds) == 6:
        return SixAxes(arm, np.eye(6), np.eye(3), np.zeros(3))
    at = frames(arm, drives.offsets)
    axes = np.einsum("kij,kj->ki", at.rotations[1:], arm.axes)
    screws = [
        _Screw(axis, point, row)
        for axis, point, row in zip(axes, at.origins[1:], drives.rows, strict=True)
        if np.any(np.abs(row) > _SAME)
    ]
    while (fewer := _merged(screws)) is not None:
        screws = fewer
    if len(screws) != 6:
        raise NotSixAxesError(f"its joints move the tool about {len(screws)} axes that do not reduce to six")
    to_axes = np.array([screw.row for screw in screws])
    if abs(np.linalg.det(to_axes)) < _SAME:
        raise NotSixAxesError("its six motors do not turn six axes independently")
    points = np.array([screw.point for screw in screws])
    serial = chain([REVOLUTE] * 6, [screw.axis for screw in screws], np.diff(points, axis=0, prepend=np.zeros((1, 3))))
    to_motors = np.ascontiguousarray(np.linalg.inv(to_axes) + 0.0)
    return SixAxes(serial, to_motors, np.ascontiguousarray(at.rotations[-1]), at.origins[-1] - points[-1])


class _Screw(NamedTuple):
    axis: FloatArray
    point: FloatArray
    row: FloatArray  # turn per motor


def _aligned(one: _Screw, other: _Screw) -> float:
    """+1 or -1 if two axes are parallel, else 0."""
    if float(np.linalg.norm(np.cross(one.axis, other.axis))) > _SAME:
        return 0.0
    return math.copysign(1.0, float(one.axis @ other.axis))


def _merged(screws: list[_Screw]) -> list[_Screw] | None:
    """One axis fewer, or None if no two can be joined."""
    for k in range(len(screws) - 1):
        one, other = screws[k], screws[k + 1]
        sense = _aligned(one, other)
        if not sense:
            continue
        if float(np.linalg.norm(np.cross(other.point - one.point, one.axis))) < _SAME:
            row = one.row + sense * other.row
            joined = [one._replace(row=row)] if np.any(np.abs(row) > _SAME) else []
            return [*screws[:k], *joined, *screws[k + 2 :]]
        if np.abs(one.row + sense * other.row).max() > _SAME:
            continue
        shift = other.point - one.point  # the pair only shifts: it may stand anywhere
        if k + 2 < len(screws) and (turn := _aligned(one, screws[k + 2])):
            behind = screws[k + 2]
            moved = one._replace(point=behind.point - shift)
            added = behind._replace(row=behind.row + turn * sense * other.row)
            return [*screws[:k], moved, added, *screws[k + 3 :]]
        if k > 0 and (turn := _aligned(one, screws[k - 1])):
            before = screws[k - 1]
            added = before._replace(row=before.row + turn * one.row)
            moved = other._replace(point=before.point + shift)
            return [*screws[: k - 1], added, moved, *screws[k + 2 :]]
    return None
