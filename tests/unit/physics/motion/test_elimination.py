"""Every posture of arms without a closed form: known ones are found, all found ones are on their pose."""

import math

import numpy as np
import pytest

from cutwise.maths.chains import chain, frames, jacobian
from cutwise.physics.motion.elimination import all_postures, elimination
from cutwise.physics.motion.inverse import polished
from peers.robots import OTHER_ARMS, kuka


def apart(found, q):
    """Largest difference of any joint, whole turns aside; infinite where there is no posture."""
    gap = np.abs((found - q + math.pi) % (2 * math.pi) - math.pi).max(axis=-1)
    return np.where(np.isnan(gap), np.inf, gap)


@pytest.mark.parametrize("name", OTHER_ARMS)
def test_the_posture_from_which_a_pose_was_made_is_among_its_postures(name):
    serial, count = OTHER_ARMS[name], 120
    arm = elimination(serial)
    q = np.random.default_rng(17).uniform(-math.pi, math.pi, (count, 6))
    at = frames(serial, q)
    got = all_postures(arm, at.rotations[:, -1], at.origins[:, -1])
    assert arm.proven
    assert got.whole.all()
    assert apart(got.q, q[:, None]).min(axis=1).max() < 1e-6
    known = ~np.isnan(got.q[..., 0])
    back = frames(serial, np.nan_to_num(got.q))
    assert np.abs(back.origins[:, :, -1] - at.origins[:, None, -1])[known].max() < 1e-9
    assert np.abs(back.rotations[:, :, -1] - at.rotations[:, None, -1])[known].max() < 1e-9
    assert np.all(known.sum(axis=1) % 2 == 0)
    assert np.abs(got.q[known]).max() <= math.pi


@pytest.mark.parametrize("name", ["UR5", "CRX", "missed wrist"])
@pytest.mark.parametrize("step", [90, 45])
def test_right_angles_lose_nothing(name, step):
    """Postures then share angles, and some ways to eliminate are singular: of these arms up to a quarter was lost."""
    serial = OTHER_ARMS[name]
    q = np.radians(np.random.default_rng(step).integers(-180 // step, 180 // step, (90, 6)) * step)
    values = np.linalg.svd(jacobian(serial, q, np.zeros(3)), compute_uv=False)
    q = q[values[:, -1] > 1e-2 * values[:, 0]]
    at = frames(serial, q)
    got = all_postures(elimination(serial), at.rotations[:, -1], at.origins[:, -1])
    assert len(q) > 20
    assert apart(got.q, q[:, None]).min(axis=1).max() < 1e-6


@pytest.mark.parametrize(("name", "most"), [("UR5", 8), ("CRX", 16), ("skew", 16)])
def test_many_starts_by_numbers_find_nothing_else(name, most):
    serial = OTHER_ARMS[name]
    arm, random = elimination(serial), np.random.default_rng(23)
    at = frames(serial, random.uniform(-math.pi, math.pi, (12, 6)))
    got = all_postures(arm, at.rotations[:, -1], at.origins[:, -1])
    assert (~np.isnan(got.q[..., 0])).sum(axis=1).max() <= most
    for k in range(12):
        starts = random.uniform(-math.pi, math.pi, (150, 6))
        q, error = polished(serial, at.rotations[k, -1], at.origins[k, -1], starts, iterations=60)
        reached = q[error < 1e-11]
        assert len(reached) > 20
        assert max(apart(got.q[k], one).min() for one in reached) < 1e-5


def test_a_spherical_wrist_needs_no_closed_form():
    serial = kuka()
    q = np.random.default_rng(2).uniform(-math.pi, math.pi, (40, 6))
    at = frames(serial, q)
    got = all_postures(elimination(serial), at.rotations[:, -1], at.origins[:, -1])
    assert apart(got.q, q[:, None]).min(axis=1).max() < 1e-6


def test_a_pose_out_of_reach_has_no_posture():
    got = all_postures(elimination(OTHER_ARMS["UR5"]), np.eye(3)[None], np.array([[3.0, 0.0, 0.0]]))
    assert np.isnan(got.q).all()
    assert got.whole.all()


def test_only_six_turning_joints():
    with pytest.raises(ValueError, match="six turning joints"):
        elimination(chain([2] * 5, [(0, 0, 1)] * 5, [(0, 0, 0.1)] * 5))
