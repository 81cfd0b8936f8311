"""The chain of a measured arm, its columns of joint angles, and what is common to both calibrations of arms."""

from collections.abc import Sequence

import numpy as np

from cutwise.io.measurements import Channel, Measurement
from cutwise.maths.chains import REVOLUTE, Chain, chain
from cutwise.maths.frames import rotation_from_rpy
from cutwise.spec.calibration import MeasuredArm
from cutwise.study.calibrate.posed import FloatArray

LARGEST_ANGLE = 7.0  # [rad] a little over one turn


def serial(arm: MeasuredArm) -> Chain:
    """The chain of the arm without its flange."""
    return chain(
        [REVOLUTE] * len(arm.joints),
        [joint.axis for joint in arm.joints],
        [joint.origin for joint in arm.joints],
        rotations=[rotation_from_rpy(*joint.rotation) for joint in arm.joints],
    )


def in_last_frame(arm: MeasuredArm, point: Sequence[float]) -> FloatArray:
    """A point of the flange in the frame of the last joint [m]."""
    return np.asarray(np.array(arm.flange_origin) + rotation_from_rpy(*arm.flange_rotation) @ np.array(point))


def joint_channels(count: int) -> tuple[Channel, ...]:
    """Columns of the joint angles."""
    hint = "is more than 7 rad, over a turn; degrees in a column of radians?"
    return tuple(Channel(f"joint{k + 1}", "angle", True, LARGEST_ANGLE, hint, "rad") for k in range(count))


def joint_angles(data: Measurement, count: int) -> FloatArray:
    """Joint angles [rad], shape (rows, count)."""
    return data.matrix([f"joint{k + 1}" for k in range(count)])


def folds(hold_out: str | float | None, rows: int, usual: float = 0.2) -> list[list[int]]:
    """Rows that are left out together: each by itself, or rows k, 2k ... counted from 1, with k = 1/share."""
    if hold_out == "leave_one_out" or (hold_out is None and rows <= 200):
        return [[row] for row in range(rows)]
    share = usual if hold_out is None else float(hold_out)
    if share <= 0.0:
        return []
    step = round(1.0 / share)
    return [list(range(step - 1, rows, step))]


def joint_ranges(angles: FloatArray) -> list[tuple[float, float]]:
    """Smallest arc, modulo a turn, that holds all angles of each joint [rad]: from low, in -pi ... pi, to high."""
    found = []
    for column in angles.T:
        turned = np.sort(np.mod(column + np.pi, 2.0 * np.pi) - np.pi)
        gaps = np.append(turned[1:], turned[0] + 2.0 * np.pi) - turned
        widest = int(np.argmax(gaps))
        low = turned[(widest + 1) % len(turned)]
        found.append((float(low), float(low + 2.0 * np.pi - gaps[widest])))
    return found
