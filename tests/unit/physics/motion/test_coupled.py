"""Held joints, followers and parallel linkages as six axes."""

import numpy as np
import pytest

from cutwise.maths.chains import chain, frames
from cutwise.physics.motion.coupled import Drives, NotSixAxesError, direct, six_axes
from peers.robots import KUKA_AXES, KUKA_ORIGINS, kuka


def drives(rows, offsets=None):
    rows = np.array(rows, dtype=float)
    offsets = np.zeros(len(rows)) if offsets is None else np.array(offsets)
    return Drives(rows, offsets, rows, np.zeros((0, 6)), np.zeros((0, 2)))


def moves_alike(arm, given):
    """The six axes carry the last frame to where the joints carry it."""
    reduced = six_axes(arm, given)
    motors = np.random.default_rng(4).uniform(-2, 2, (20, 6))
    at = frames(arm, given.joints(motors))
    same = frames(reduced.chain, np.linalg.solve(reduced.to_motors, motors.T).T)
    turned = same.rotations[:, -1] @ reduced.rotation
    assert np.abs(turned - at.rotations[:, -1]).max() < 1e-12
    place = same.origins[:, -1] + same.rotations[:, -1] @ reduced.origin
    assert np.abs(place - at.origins[:, -1]).max() < 1e-12
    return reduced


def test_six_joints_with_six_motors_stay_as_they_are():
    reduced = six_axes(kuka(), direct())
    assert np.array_equal(reduced.to_motors, np.eye(6))
    assert not reduced.origin.any()


def test_a_held_joint_becomes_part_of_the_links():
    arm = chain(
        [2] * 7, [*KUKA_AXES[:3], (0, 0, 1), *KUKA_AXES[3:]], [*KUKA_ORIGINS[:3], (0.1, 0, 0.1), *KUKA_ORIGINS[3:]]
    )
    rows = np.insert(np.eye(6), 3, 0.0, axis=0)
    moves_alike(arm, drives(rows, [0, 0, 0, 0.7, 0, 0, 0]))


@pytest.mark.parametrize("offset", [0.0, 0.3])
@pytest.mark.parametrize("beside", [(0, 0, 0), (-0.2, 0, 0.1)])
def test_a_parallelogram_is_a_serial_arm_driven_from_the_base(offset, beside):
    """Arm, follower that keeps its direction, forearm on it, on its line or beside it."""
    axes = [*KUKA_AXES[:2], (0, -1, 0), *KUKA_AXES[2:]]
    arm = chain([2] * 7, axes, [*KUKA_ORIGINS[:3], beside, *KUKA_ORIGINS[3:]])
    rows = np.insert(np.eye(6), 2, np.eye(6)[1], axis=0)  # against -y: undoes joint 2
    reduced = moves_alike(arm, drives(rows, [0, 0, offset, 0, 0, 0, 0]))
    assert reduced.to_motors[2] == pytest.approx([0, 1, 1, 0, 0, 0])


def test_a_linkage_within_six_joints():
    rows = np.eye(6)
    rows[2, 1] = -1.0
    assert moves_alike(kuka(), drives(rows)).to_motors[2, 1] == 1.0


def test_joints_that_do_not_reduce_are_refused():
    axes = [*KUKA_AXES[:4], (0, 0, 1), *KUKA_AXES[4:]]
    arm = chain([2] * 7, axes, [*KUKA_ORIGINS[:4], (0.1, 0, 0), *KUKA_ORIGINS[4:]])
    with pytest.raises(NotSixAxesError, match="7 axes"):
        six_axes(arm, drives(np.insert(np.eye(6), 4, np.eye(6)[1], axis=0)))
    twice = np.eye(6)
    twice[5] = twice[4]
    with pytest.raises(NotSixAxesError, match="independently"):
        six_axes(kuka(), drives(twice))
