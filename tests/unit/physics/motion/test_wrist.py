"""Closed-form and numeric inverse kinematics against the chain itself."""

import math

import numpy as np
import pytest

from cutwise.maths.chains import chain, frames
from cutwise.physics.motion.inverse import polished
from cutwise.physics.motion.wrist import (
    ON_COLUMN,
    REACHED,
    TOO_FAR,
    TOO_NEAR,
    NotSphericalError,
    fill_branches,
    reach_margin,
    spherical_wrist,
    wrapped,
    wrist_sine,
)
from peers.robots import ABB_AXES, KUKA_AXES, KUKA_LIMITS, KUKA_ORIGINS, abb, kuka


def standing():
    """An arm that stands straight up at zero, axes 4 and 6 along z, with an elbow offset."""
    axes = [(0, 0, 1), (0, 1, 0), (0, 1, 0), (0, 0, 1), (0, 1, 0), (0, 0, 1)]
    return chain([2] * 6, axes, [(0, 0, 0.642), (0.25, 0, 0), (0, 0, 0.95), (0.03, 0, 0.8), (0, 0, 0), (0, 0, 0.194)])


def beside():
    """A wrist beside the plane of the arm, axis 3 against axis 2, axis 6 bent at zero."""
    axes = [(0, 0, 1), (0, -1, 0), (0, 1, 0), (1, 0, 0), (0, 1, 0), (0, 0, -1)]
    return chain([2] * 6, axes, [(0, 0, 0.478), (0.05, 0, 0), (0, 0.05, 0.425), (0.425, 0, 0), (0, 0, 0), (0, 0, -0.1)])


def branches(arm, rotation, position):
    solutions, n, work = np.empty((8, 6)), np.empty((3, 3)), np.empty((3, 3))
    return fill_branches(arm, rotation, position, solutions, n, work), solutions


@pytest.mark.parametrize("make", [kuka, abb, standing, beside])
def test_every_branch_reaches_the_pose_and_one_is_the_posture_itself(make):
    serial = make()
    arm, random = spherical_wrist(serial), np.random.default_rng(3)
    for q in random.uniform(-3, 3, (200, 6)):
        at = frames(serial, q)
        outcome, solutions = branches(arm, at.rotations[-1], at.origins[-1])
        found = solutions[~np.isnan(solutions[:, 0])]
        back = frames(serial, found)
        assert outcome == REACHED
        assert back.origins[:, -1] == pytest.approx(np.tile(at.origins[-1], (len(found), 1)), abs=1e-12)
        assert np.abs(back.rotations[:, -1] - at.rotations[-1]).max() < 1e-12
        apart = np.abs((found - q + math.pi) % (2 * math.pi) - math.pi).max(axis=1)
        assert apart.min() < 1e-7


def test_front_branches_come_first():
    at = frames(kuka(), np.radians([20, -60, 80, 20, -50, 30]))
    _, solutions = branches(spherical_wrist(kuka()), at.rotations[-1], at.origins[-1])
    assert np.all(np.abs(np.array([wrapped(a, -4, 4) for a in solutions[:4, 0]])) < math.pi / 2)


def test_what_is_missing_to_the_reach():
    arm, turn = spherical_wrist(kuka()), np.eye(3)
    outer = 0.35 + 1.15 + math.hypot(1.2, 0.041)
    assert branches(arm, turn, np.array([outer + 0.24 + 0.1, 0, 0.675]))[0] == TOO_FAR
    assert min(reach_margin(arm, turn, np.array([outer + 0.24 + 0.1, 0, 0.675]))) == pytest.approx(-0.1)
    assert branches(arm, turn, np.array([0.35 + 0.24, 0, 0.675]))[0] in (REACHED, TOO_NEAR)  # back branch may reach
    short = chain([2] * 6, KUKA_AXES, [*KUKA_ORIGINS[:3], (0.5, 0, 0), (0, 0, 0), (0.24, 0, 0)])
    near = np.array([0.24, 0.0, 0.675 + 0.1])
    assert branches(spherical_wrist(short), turn, near)[0] == TOO_NEAR
    side = spherical_wrist(beside())
    wrist = side.foot + np.array([0.0, 0.02, 0.3]) - side.centre
    assert branches(side, turn, wrist)[0] == ON_COLUMN


def test_the_singular_wrist_still_reaches_its_pose():
    at = frames(kuka(), np.radians([10, -60, 80, 20, 0, 30]))
    _, solutions = branches(spherical_wrist(kuka()), at.rotations[-1], at.origins[-1])
    back = frames(kuka(), solutions[~np.isnan(solutions[:, 0])])
    assert np.abs(back.rotations[:, -1] - at.rotations[-1]).max() < 1e-8
    assert wrist_sine(spherical_wrist(kuka()), 0.0) == pytest.approx(0.0, abs=1e-15)


def test_a_limit_reached_to_rounding_is_within():
    assert wrapped(math.pi + 1e-15, -math.pi, 0.0) == pytest.approx(-math.pi, abs=1e-14)
    assert wrapped(-math.pi - 1e-15, -math.pi, 0.0) == pytest.approx(-math.pi, abs=1e-14)
    assert wrapped(1.0 + 1e-14, -1.0, 1.0) == 1.0
    assert wrapped(1.0 + 1e-14 - 2 * math.pi, -1.0, 1.0) == pytest.approx(1.0, abs=1e-14)
    assert wrapped(1.0 + 1e-9, -1.0, 1.0) > 1.0


def test_an_arm_at_full_stretch_still_reaches():
    """Rounding puts about half of such poses out of reach by 1e-16 of the arm."""
    straight = math.atan2(-0.041, 1.2)
    for q1, q2, q4, q5, q6 in np.random.default_rng(9).uniform(-1.5, 1.5, (60, 5)):
        q = np.array([q1, q2, straight, q4, q5, q6])
        at = frames(kuka(), q)
        outcome, solutions = branches(spherical_wrist(kuka()), at.rotations[-1], at.origins[-1])
        found = solutions[~np.isnan(solutions[:, 0])]
        assert outcome == REACHED
        assert np.abs(frames(kuka(), found).origins[:, -1] - at.origins[-1]).max() < 1e-9
        assert np.abs(found - q)[:, [1, 2]].max(axis=1).min() < 1e-5


@pytest.mark.parametrize(
    ("angle", "limits", "expected"),
    [(190, (-170, 170), -170), (170, (-195, 40), -190), (-190, (-195, 40), -190), (100, (-195, 40), 100),
     (400, (-350, 350), 40), (-250, (-350, 350), 110),
     (-170, (500, 600), 550), (10, (-800, -700), -710), (10, (100, 200), 10)],
)  # fmt: skip
def test_angles_are_wrapped_to_half_a_turn_unless_only_a_turn_further_fits(angle, limits, expected):
    got = wrapped(math.radians(angle), *np.radians(limits))
    assert math.degrees(got) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("joint", "origin", "axis", "words"),
    [(1, (0.35, 0, 0), (0, 0, 1), "axis 2"), (2, (1.15, 0, 0), (0, 0.6, 0.8), "axis 3"),
     (5, (0.24, 0.01, 0), (-1, 0, 0), "axis 6 misses the wrist centre by 10 mm"), (4, (0, 0, 0), (1, 0, 0), "axis 5")],
)  # fmt: skip
def test_other_arms_are_told_apart(joint, origin, axis, words):
    axes, origins = list(KUKA_AXES), list(KUKA_ORIGINS)
    axes[joint], origins[joint] = axis, origin
    with pytest.raises(NotSphericalError, match=words):
        spherical_wrist(chain([2] * 6, axes, origins))


def test_damped_least_squares_finds_an_arm_without_spherical_wrist():
    origins = list(KUKA_ORIGINS)
    origins[5] = (0.24, 0.05, 0)
    serial = chain([2] * 6, ABB_AXES, origins)
    random = np.random.default_rng(5)
    reached = 0
    for q in random.uniform(-1.2, 1.2, (40, 6)):
        at = frames(serial, q)
        starts = random.uniform(-2, 2, (12, 6))
        found, errors = polished(serial, at.rotations[-1], at.origins[-1], starts, tolerance=1e-11, iterations=200)
        if errors.min() < 1e-10:
            reached += 1
            back = frames(serial, found[errors.argmin()])
            assert back.origins[-1] == pytest.approx(at.origins[-1], abs=1e-9)
            assert np.abs(back.rotations[-1] - at.rotations[-1]).max() < 1e-9
    assert reached >= 39


def test_damped_least_squares_says_when_it_did_not_arrive():
    _, errors = polished(kuka(), np.eye(3), np.array([5.0, 0, 0]), np.zeros((1, 6)) + 0.1)
    assert errors[0] > 1.0


def test_reference_limits_hold_the_zero_posture():
    assert np.all(KUKA_LIMITS[:, 0] < 0)
