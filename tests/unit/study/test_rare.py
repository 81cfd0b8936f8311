"""Subset simulation on problems whose probability is known, over many seeds: mean, scatter, and what it tells of itself."""

import math

import numpy as np
import pytest
from scipy import integrate, special

from cutwise.study.many.draws import LEVELS_FROM, generator
from cutwise.study.rare import Flat, subset_simulation


def over_seeds(margins, dimensions, seeds=20, count=2000):
    return [
        subset_simulation(margins, dimensions, count=count, rng=lambda level, s=seed: generator(s, LEVELS_FROM + level))
        for seed in range(seeds)
    ]


def mean_is(found, truth, scatter):
    mean = np.mean([one.probability for one in found])
    assert mean == pytest.approx(truth, abs=3.0 * scatter * truth / math.sqrt(len(found)))


@pytest.mark.parametrize(("beta", "d", "scatter"), [(3.2, 4, 0.17), (4.5, 10, 0.27), (4.0, 50, 0.25)])
def test_a_plane_in_many_dimensions(beta, d, scatter):
    """P = Phi(-beta), whatever the dimension."""
    found = over_seeds(lambda z: z.sum(axis=1) / math.sqrt(d) - beta, d)
    truth = special.ndtr(-beta)
    mean_is(found, truth, scatter)
    told = np.mean([one.cov for one in found])
    spread = np.std([one.probability for one in found]) / truth
    assert 0.5 < told / spread < 1.6
    assert np.mean([one.low <= truth <= one.high for one in found]) >= 0.7


@pytest.mark.parametrize(("k", "truth"), [(7.0, 2.222795e-3), (6.0, 4.457331e-3), (8.5, None)])
def test_four_branches(k, truth):
    """Failures in four directions, against quadrature along one of them."""

    def margins(z):
        s, t = (z[:, 0] + z[:, 1]) / math.sqrt(2), (z[:, 0] - z[:, 1]) / math.sqrt(2)
        g = [
            3 + 0.2 * t**2 - s,
            3 + 0.2 * t**2 + s,
            k / math.sqrt(2) + math.sqrt(2) * t,
            k / math.sqrt(2) - math.sqrt(2) * t,
        ]
        return -np.min(g, axis=0)

    inside = integrate.quad(
        lambda t: math.exp(-t * t / 2) / math.sqrt(2 * math.pi) * (2 * special.ndtr(3 + 0.2 * t * t) - 1), -k / 2, k / 2
    )[0]
    if truth is not None:
        assert 1 - inside == pytest.approx(truth, rel=1e-6)
    mean_is(over_seeds(margins, 2), 1 - inside, 0.17)


@pytest.mark.parametrize(
    "margins",
    [
        lambda z: np.floor(4.0 * z[:, 0]) / 4.0 - 2.9,  # a measure that is counted, or read in steps
        lambda z: np.maximum(z[:, 0] - 3.0, -2.0),  # the same for most cases, as a burr that is gone
    ],
)
def test_margins_that_many_cases_share(margins):
    """A case on a threshold is not beyond it, and begins no chain: P = Phi(-3) (0.57 of it before)."""
    found = over_seeds(margins, 1, seeds=30, count=1000)
    mean_is(found, special.ndtr(-3.0), 0.26)
    assert np.mean([one.low <= special.ndtr(-3.0) <= one.high for one in found]) >= 0.8


def test_a_frequent_failure_needs_one_level():
    found = over_seeds(lambda z: z[:, 0] - 0.5, 1, seeds=1)[0]
    assert len(found.levels) == 1
    assert found.runs == 2000
    assert found.probability == pytest.approx(special.ndtr(-0.5), abs=4 * found.cov * 0.31)


def test_a_margin_that_does_not_rise_is_told():
    with pytest.raises(Flat):
        over_seeds(lambda z: np.full(len(z), -0.2), 2, seeds=1)
