import numpy as np
import pytest

from cutwise.maths import chains, frames


@pytest.fixture
def mixed():
    rng = np.random.default_rng(5)
    rotations = frames.exp_twists(rng.normal(size=(5, 6)))[0]
    kinds = [chains.REVOLUTE, chains.PRISMATIC, chains.FIXED, chains.REVOLUTE, chains.REVOLUTE]
    return chains.chain(kinds, rng.normal(size=(5, 3)), rng.normal(size=(5, 3)), rotations=rotations)


TIP = np.array([0.05, -0.02, 0.3])


def test_frames_are_products_of_joint_motions(mixed):
    q = np.array([0.4, -0.2, 9.0, 1.1, -2.0])
    rotation, origin = np.eye(3), np.zeros(3)
    at = chains.frames(mixed, q)
    for i in range(5):
        motion, slide = np.eye(3), np.zeros(3)
        if mixed.kinds[i] == chains.REVOLUTE:
            motion = frames.rotation_about(mixed.axes[i], q[i])
        elif mixed.kinds[i] == chains.PRISMATIC:
            slide = mixed.axes[i] * q[i]
        origin = origin + rotation @ (mixed.origins[i] + mixed.rotations[i] @ slide)
        rotation = rotation @ mixed.rotations[i] @ motion
        assert at.rotations[i + 1] == pytest.approx(rotation, abs=1e-14)
        assert at.origins[i + 1] == pytest.approx(origin, abs=1e-14)
    assert chains.tool_point(at, TIP) == pytest.approx(rotation @ TIP + origin, abs=1e-14)


def test_jacobian_is_the_derivative_of_the_tool_frame(mixed):
    q, step = np.array([[0.4, -0.2, 0.0, 1.1, -2.0], [0.1, 0.6, 0.0, -0.3, 0.7]]), 1e-6
    jacobians = chains.jacobian(mixed, q, TIP)
    for joint in range(5):
        shift = np.zeros(5)
        shift[joint] = step
        ahead, behind = chains.frames(mixed, q + shift), chains.frames(mixed, q - shift)
        speed = (chains.tool_point(ahead, TIP) - chains.tool_point(behind, TIP)) / (2 * step)
        spin = (ahead.rotations[:, -1] - behind.rotations[:, -1]) / (2 * step)
        turning = spin @ np.swapaxes(chains.frames(mixed, q).rotations[:, -1], -1, -2)
        assert jacobians[:, :3, joint] == pytest.approx(speed, abs=1e-8)
        assert frames.skew(jacobians[:, 3:, joint]) == pytest.approx(turning, abs=1e-8)


def test_one_posture_and_a_batch_agree(mixed):
    q = np.random.default_rng(0).normal(size=(2, 3, 5))
    at = chains.frames(mixed, q)
    one = chains.frames(mixed, q[1, 2])
    assert at.rotations.shape == (2, 3, 6, 3, 3)
    assert (at.rotations[1, 2] == one.rotations).all()
    assert (chains.jacobian(mixed, q, TIP)[1, 2] == chains.jacobian(mixed, q[1, 2], TIP)).all()
    twists = np.random.default_rng(1).normal(size=(2, 3, 6, 6)) * 1e-4
    assert chains.exact_error(at, twists, TIP)[1, 2] == pytest.approx(chains.exact_error(one, twists[1, 2], TIP))


def test_error_jacobian_adds_up_to_the_linear_error(mixed):
    at = chains.frames(mixed, np.random.default_rng(0).normal(size=(4, 5)))
    twists = np.random.default_rng(1).normal(size=(4, 6, 6)) * 1e-4
    by_jacobian = np.einsum("kxib,kib->kx", chains.error_jacobian(at, TIP), twists)
    assert by_jacobian == pytest.approx(chains.linear_error(at, twists, TIP), rel=1e-12)


def test_exact_error_is_the_composed_chain(mixed):
    q = np.random.default_rng(0).normal(size=5)
    twists = np.random.default_rng(1).normal(size=(6, 6)) * 0.1
    at = chains.frames(mixed, q)
    rotation, origin = frames.exp_twists(twists[0])
    for i in range(5):
        step = at.rotations[i].T @ (at.origins[i + 1] - at.origins[i])
        turn = at.rotations[i].T @ at.rotations[i + 1]
        error_turn, error_step = frames.exp_twists(twists[i + 1])
        origin = rotation @ step + origin
        rotation = rotation @ turn
        origin = rotation @ error_step + origin
        rotation = rotation @ error_turn
    expected = rotation @ TIP + origin - chains.tool_point(at, TIP)
    assert chains.exact_error(at, twists, TIP) == pytest.approx(expected, abs=1e-13)


def test_plain_and_compiled_frames_agree(mixed):
    q = np.array([[0.4, -0.2, 0.0, 1.1, -2.0]])
    rotations, origins = np.empty((1, 6, 3, 3)), np.empty((1, 6, 3))
    chains.fill_frames.py_func(*mixed.arrays, q, rotations, origins)
    at = chains.frames(mixed, q)
    assert rotations == pytest.approx(at.rotations, abs=1e-15)
    assert origins == pytest.approx(at.origins, abs=1e-15)


def test_an_axis_of_zero_length_is_refused():
    with pytest.raises(ValueError, match="joint 2 moves along or about an axis of zero length"):
        chains.chain([0, 1], [[0, 0, 0], [0, 0, 0]], np.zeros((2, 3)))
    with pytest.raises(ValueError, match="kind 7"):
        chains.chain([7], [[1, 0, 0]], np.zeros((1, 3)))
