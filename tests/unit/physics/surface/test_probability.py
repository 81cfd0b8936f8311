import numpy as np
import pytest

from cutwise.physics.surface import budget, probability, wall


@pytest.fixture
def chain():
    rng = np.random.default_rng(0)
    return rng.normal(size=(3, 4, 6)), np.abs(rng.normal(size=(4, 6))) * 1e-6


@pytest.mark.parametrize("law", [probability.NORMAL, probability.UNIFORM, probability.TRIANGULAR])
def test_every_law_has_the_covariance_of_the_linear_model(chain, law):
    found = probability.quantiles(np.zeros(3), *chain, np.full(4, law), probability=0.95, samples=20_000, seed=2)
    assert found.deviation == pytest.approx(np.sqrt(np.diag(probability.covariance(*chain))), rel=0.03)
    assert found.together == found.random


def test_no_uncertainty_leaves_the_systematic_error(chain):
    jacobian, deviation = chain
    found = probability.quantiles(
        [3e-6, 0, 4e-6], jacobian, 0 * deviation, np.zeros(4), probability=0.95, samples=10, seed=1
    )
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
    gain = budget.stiffening_gain(parts, total, stiffer=1e-6)
    assert gain == pytest.approx(-1e-6 * budget.signed_shares(parts, total), rel=1e-4)


def test_wall_follows_the_tilt_of_the_tool():
    error = wall.wall_error(np.zeros((2, 3)), [[1e-4, 0, 0]] * 2, [[0, 0, 0], [0, 0, 0.01]], [0, 1, 0])
    assert error == pytest.approx(np.array([[0, -1e-6], [0, -1e-6]]))


def test_flatness_ignores_a_plane_and_sees_a_bow():
    x, z = np.linspace(0, 1, 11), np.linspace(0, 0.1, 3)
    plane = 3e-6 * x[:, None] + 2e-6 * z + 1e-6
    assert wall.flatness(plane, x, z) == pytest.approx(0.0, abs=1e-18)
    assert wall.flatness(plane + 4e-6 * x[:, None] * (1 - x[:, None]), x, z) == pytest.approx(1e-6, rel=1e-9)
