import numpy as np
import pytest

from cutwise.physics.surface import budget, probability, wall


@pytest.fixture
def chain():
    rng = np.random.default_rng(0)
    return rng.normal(size=(3, 4, 6)), np.abs(rng.normal(size=(4, 6))) * 1e-6


@pytest.mark.parametrize("law", [probability.NORMAL, probability.UNIFORM, probability.TRIANGULAR])
def test_every_law_has_the_covariance_of_the_linear_model(chain, law):
    random = probability.random_errors(*chain, np.full(4, law), samples=20_000, seed=2)
    found = probability.quantiles(np.zeros(3), random, 0.95)
    assert found.deviation == pytest.approx(np.sqrt(np.diag(probability.covariance(*chain))), rel=0.03)
    assert found.together == found.random


def test_no_uncertainty_leaves_the_systematic_error(chain):
    jacobian, deviation = chain
    random = probability.random_errors(jacobian, 0 * deviation, np.zeros(4), samples=10, seed=1)
    found = probability.quantiles([3e-6, 0, 4e-6], random, 0.95)
    assert found.together == pytest.approx(5e-6)
    assert found.random == 0.0
    assert (probability.variance_shares(jacobian, 0 * deviation) == 0.0).all()


def test_variance_shares_are_of_the_trace(chain):
    shares = probability.variance_shares(*chain)
    jacobian, deviation = chain
    only = np.zeros_like(deviation)
    only[2] = deviation[2]
    whole = np.trace(probability.covariance(jacobian, deviation))
    assert shares.sum() == pytest.approx(1.0)
    assert shares[2] == pytest.approx(np.trace(probability.covariance(jacobian, only)) / whole)


def test_shares_of_no_error_are_zero():
    assert (budget.signed_shares(np.zeros((2, 3)), np.zeros(3)) == 0.0).all()


def test_stiffening_is_the_derivative_for_small_changes():
    parts = np.random.default_rng(1).normal(size=(4, 3))
    total = parts.sum(axis=0)
    gain = budget.stiffening_gain(parts[None], total[None], stiffer=1e-6)
    assert gain == pytest.approx(-1e-6 * budget.signed_shares(parts, total), rel=1e-4)


def test_stiffening_counts_over_the_whole_pass():
    """What helps at the worst place alone makes another one the worst."""
    parts = np.array([[[3.0, 0, 0], [7.0, 0, 0]], [[-0.2, 0, 0], [10.1, 0, 0]]])
    total = parts.sum(axis=1)  # 10 and 9.9
    expected = [np.abs(total[:, 0] - parts[:, e, 0] * 0.1 / 1.1).max() - 10.0 for e in (0, 1)]
    assert budget.stiffening_gain(parts, total) == pytest.approx(expected)
    assert budget.stiffening_gain(parts, total)[0] == pytest.approx(9.9 + 0.2 * 0.1 / 1.1 - 10.0)


def test_stiffness_for_a_limit_brings_the_error_to_it():
    """The factor found, put back into the element, leaves the largest error at the limit."""
    parts = np.random.default_rng(2).normal(size=(9, 4, 3)) * 1e-6 + np.array([3e-6, 1e-6, 0.0])
    total = parts.sum(axis=1)
    largest = np.linalg.norm(total, axis=1).max()
    for limit in (0.9 * largest, 1.1 * largest):
        factors = budget.stiffness_for(parts, total, limit)
        assert np.isfinite(factors).any()
        for element in np.flatnonzero(np.isfinite(factors)):
            changed = total - parts[:, element] * (1.0 - 1.0 / factors[element])
            assert np.linalg.norm(changed, axis=1).max() == pytest.approx(limit, rel=1e-9)
            assert (factors[element] > 1.0) == (limit < largest)
    assert np.isinf(budget.stiffness_for(parts, total, 1e-9)).all()


def test_a_normal_error_of_equal_spread_has_the_length_of_a_maxwell_law():
    """P(|x| <= 2 sigma) = 0.7385 and the 95 % quantile is 2.7955 sigma (chi with three degrees of freedom)."""
    jacobian = np.zeros((3, 2, 6))
    jacobian[:, 0, :3] = jacobian[:, 1, :3] = np.eye(3)
    deviation = np.zeros((2, 6))
    deviation[0, :3], deviation[1, :3] = 3e-6, 4e-6
    random = probability.random_errors(jacobian, deviation, np.zeros(2, int), samples=200_000, seed=5)
    length = np.linalg.norm(random, axis=1)
    assert (length <= 10e-6).mean() == pytest.approx(0.7385, abs=3e-3)
    assert probability.quantiles(np.zeros(3), random, 0.95).random == pytest.approx(2.7955 * 5e-6, rel=5e-3)


def test_wall_follows_the_tilt_of_the_tool():
    error = wall.wall_error(np.zeros((2, 3)), [[1e-4, 0, 0]] * 2, [[0, 0, 0], [0, 0, 0.01]], [0, 1, 0])
    assert error == pytest.approx(np.array([[0, -1e-6], [0, -1e-6]]))


def test_flatness_ignores_a_plane_and_sees_a_bow():
    x, z = np.linspace(0, 1, 11), np.linspace(0, 0.1, 3)
    plane = 3e-6 * x[:, None] + 2e-6 * z + 1e-6
    assert wall.flatness(plane, x, z) == pytest.approx(0.0, abs=1e-18)
    assert wall.flatness(plane + 4e-6 * x[:, None] * (1 - x[:, None]), x, z) == pytest.approx(1e-6, rel=1e-9)
