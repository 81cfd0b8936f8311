import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from cutwise.maths import frames


def _hat(twist: np.ndarray) -> np.ndarray:
    matrix = np.zeros((4, 4))
    matrix[:3, :3] = frames.skew(twist[3:])
    matrix[:3, 3] = twist[:3]
    return matrix


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 0.0099, 0.0101, 1.0, 3.0])
def test_exponential_of_a_twist_is_the_matrix_exponential(scale):
    twists = np.random.default_rng(3).normal(size=(5, 6)) * scale
    rotations, translations = frames.exp_twists(twists)
    for xi, rotation, translation in zip(twists, rotations, translations, strict=True):
        whole = expm(_hat(xi))
        assert rotation == pytest.approx(whole[:3, :3], abs=1e-13)
        assert translation == pytest.approx(whole[:3, 3], abs=1e-13 * max(1.0, scale))


def test_exponential_of_zero_is_no_motion():
    rotation, translation = frames.exp_twists(np.zeros(6))
    assert (rotation == np.eye(3)).all()
    assert (translation == 0.0).all()


def test_rotation_about_agrees_with_scipy_and_its_plain_version():
    axis = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])
    expected = Rotation.from_rotvec(1.2 * axis).as_matrix()
    plain = np.empty((3, 3))
    frames.fill_rotation_about.py_func(axis, 1.2, plain)
    assert frames.rotation_about(5.0 * axis, 1.2) == pytest.approx(expected, abs=1e-15)
    assert plain == pytest.approx(expected, abs=1e-15)
    with pytest.raises(ValueError, match="needs a length"):
        frames.rotation_about([0, 0, 0], 1.0)


def test_roll_pitch_yaw_are_fixed_axis_angles():
    expected = Rotation.from_euler("xyz", [0.1, -0.7, 2.0]).as_matrix()
    assert frames.rotation_from_rpy(0.1, -0.7, 2.0) == pytest.approx(expected, abs=1e-15)


def test_skew_is_the_cross_product():
    v, w = np.random.default_rng(1).normal(size=(2, 4, 3))
    assert np.einsum("...ij,...j->...i", frames.skew(v), w) == pytest.approx(np.cross(v, w))


def test_inverse_undoes_a_motion():
    rotation, translation = frames.exp_twists([0.1, -0.2, 0.3, 0.4, 0.5, -0.6])
    back, shift = frames.inverse(rotation, translation)
    assert back @ rotation == pytest.approx(np.eye(3), abs=1e-15)
    assert back @ translation + shift == pytest.approx(np.zeros(3), abs=1e-15)


def test_error_before_a_motion_equals_its_image_after_it():
    before = np.array([0.01, -0.02, 0.03, 0.3, -0.1, 0.2])
    rotation, shift = frames.exp_twists([0.5, 0.1, -0.3, 0.9, -0.4, 0.2])
    after = frames.twist_after_motion(before, rotation, shift)
    r_before, p_before = frames.exp_twists(before)
    r_after, p_after = frames.exp_twists(after)
    assert r_before @ rotation == pytest.approx(rotation @ r_after, abs=1e-14)
    assert r_before @ shift + p_before == pytest.approx(rotation @ p_after + shift, abs=1e-14)
    turned_only = np.concatenate([rotation.T @ before[:3], rotation.T @ before[3:]])  # Ad(R^-1) alone: holds for d = 0
    assert np.abs(turned_only - after).max() > 0.01


def test_twist_at_another_point_displaces_every_point_alike():
    xi, shift, point = np.random.default_rng(2).normal(size=6), np.array([0.1, 0.2, -0.3]), np.array([1.0, 2.0, 3.0])
    moved = frames.twist_at(xi, shift)
    direct = xi[:3] + np.cross(xi[3:], point)
    assert moved[:3] + np.cross(moved[3:], point - shift) == pytest.approx(direct, abs=1e-14)
