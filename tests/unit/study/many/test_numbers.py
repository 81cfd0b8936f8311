"""The numbers of studies: the published words of the generator, nets that can be extended, distributions, intervals."""

import math

import numpy as np
import pytest
from scipy import stats

from cutwise.study.many import distributions as scatter
from cutwise.study.many import draws
from cutwise.study.many.definition import mixed, trajectories
from cutwise.study.many.observed import NoTable, observed
from cutwise.study.many.statements import clopper_pearson, elementary_effects, share_of, sobol_indices, wilson


def ishigami(u):
    x = -math.pi + 2 * math.pi * u
    return np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def test_words_of_the_first_cases():
    found = draws.uniforms(1, 5, 0, 2)
    assert found[0, [0, 1, 4]] == pytest.approx([0.303568034306759, 0.848708749685777, 0.075151151095911], abs=1e-15)
    assert found[1, [0, 1, 4]] == pytest.approx([0.900268453112419, 0.052066667550043, 0.858699577291366], abs=1e-15)


def test_points_of_the_first_net():
    found = draws.net_points(1, 3, 0, 0, 2)
    assert found[0] == pytest.approx([0.197059839498252, 0.488053425680846, 0.991465739440173], abs=1e-15)
    assert found[1] == pytest.approx([0.697059839498252, 0.988053425680846, 0.491465739440173], abs=1e-15)


@pytest.mark.parametrize("make", [draws.uniforms, draws.shifted_nets])
def test_a_part_of_a_study_is_what_it_is_in_a_longer_one(make):
    whole = make(7, 6, 0, 64)
    for first, count in ((0, 8), (8, 24), (13, 5), (63, 1)):
        assert np.array_equal(make(7, 6, first, count), whole[first : first + count])


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [
        (scatter.Normal(2.0, 0.3), stats.norm(2.0, 0.3)),
        (scatter.LogNormal(1.5, 0.2), stats.lognorm(0.2, scale=1.5)),
        (scatter.Uniform(-1.0, 3.0), stats.uniform(-1.0, 4.0)),
        (scatter.Triangular(0.0, 0.2, 1.0), stats.triang(0.2)),
        (scatter.Truncated(scatter.Normal(0.0, 1.0), -0.5, math.inf), stats.truncnorm(-0.5, math.inf)),
    ],
)
def test_quantiles_against_scipy(ours, theirs):
    u = np.linspace(1e-4, 1 - 1e-4, 101)
    assert ours.quantile(u) == pytest.approx(theirs.ppf(u), rel=1e-9, abs=1e-12)
    for x in theirs.ppf([0.02, 0.4, 0.97]):
        assert ours.share_below(x) == pytest.approx(theirs.cdf(x), abs=1e-12)


def test_measured_values_come_as_often_as_their_weights_say():
    found = scatter.empirical(np.array([3.0, 1.0, 2.0]), np.array([1.0, 2.0, 1.0]))
    assert found.quantile(np.array([0.1, 0.5, 0.6, 0.8, 0.999])).tolist() == [1.0, 1.0, 2.0, 3.0, 3.0]


def test_a_measured_value_on_an_end_is_within():
    found = scatter.Truncated(scatter.empirical(np.array([1.0, 2.0, 3.0, 4.0])), 2.0, 3.0)
    assert found.quantile(np.array([0.25, 0.75])).tolist() == [2.0, 3.0]
    assert found.share == 0.5
    assert np.isfinite(scatter.Truncated(scatter.Normal(0.0, 1.0), 6.5, np.inf).quantile(np.array([1.0 - 1e-15]))).all()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("height [mm],other [mm]\n0.7,1\n", "expected one column of values"),
        ("height [mm],Weight\n0.7,1\n", "expected one column of values"),
        ("height [mm],weight\n0.7,-1\n0.8,2\n", "none is below 0"),
        ("height [mm],weight\n0.7,0\n", "not all of them 0"),
        ("height [mm],weight\n0.7,1\n0.8\n", "line 3 has 1 cells in place of 2"),
        ("height [mm],weight [kg]\n0.7,1\n", "weight has no unit"),
        ("height [mm];weight\n0,7;1\n", "separated by semicolons"),
        ("height [s]\n0.7\n", "not a unit of length"),
        ("height [mm]\n", "no column of values"),
        ("height [mm]\nnan\nx\n", "line 2: height has a cell that is no number; line 3"),
    ],
)
def test_a_table_is_taken_as_a_whole_or_not_at_all(tmp_path, text, words):
    (tmp_path / "t.csv").write_text(text, encoding="utf-8")
    with pytest.raises(NoTable, match=words):
        observed(tmp_path / "t.csv", "t.csv", "length")


def test_a_deviation_of_nothing_is_the_mean():
    assert scatter.Normal(2.0, 0.0).quantile(np.array([0.01, 0.99])).tolist() == [2.0, 2.0]
    assert scatter.Uniform(2.0, 2.0).share_below(3.0) == 1.0


def test_intervals_of_shares():
    assert clopper_pearson(0, 1000).high == pytest.approx(0.003682, abs=5e-7)
    assert clopper_pearson(990, 1000)[1:] == pytest.approx((0.981687, 0.995194), abs=1e-6)
    assert wilson(990, 1000)[1:] == pytest.approx((0.981691, 0.994559), abs=1e-6)
    few = share_of(np.arange(1024) != 5, nets=True)
    assert few == clopper_pearson(1023, 1024)


def test_the_interval_of_the_nets_covers_the_share():
    """Ishigami above 5, P from 2^20 points: 95 % intervals of 60 seeds hold it about as often as they should."""
    truth = float((ishigami(draws.uniforms(0, 3, 0, 2**18)) > 5.0).mean())
    hits = [share_of(ishigami(draws.shifted_nets(seed, 3, 0, 1024)) > 5.0, nets=True) for seed in range(60)]
    covered = sum(one.low <= truth <= one.high for one in hits)
    assert covered >= 52
    wide = wilson(int((ishigami(draws.uniforms(0, 3, 0, 1024)) > 5.0).sum()), 1024).half_width
    assert np.median([one.half_width for one in hits]) < 0.6 * wide


def test_indices_of_ishigami():
    points = draws.net_points(1, 6, 0, 0, 4096)
    rows = ishigami(mixed(points[:, :3], points[:, 3:])).reshape(4096, 5)
    found = sobol_indices(rows, 1)
    assert found.first == pytest.approx([0.31372, 0.44244, 0.00014], abs=2e-5)
    assert found.total == pytest.approx([0.55690, 0.44245, 0.24400], abs=2e-5)
    scaled = sobol_indices(3.0 * rows + 7.0, 1)
    assert scaled.total == pytest.approx(found.total, abs=1e-12)


def test_additive_functions_have_no_joint_share():
    points = draws.net_points(3, 4, 0, 0, 1024)
    rows = (mixed(points[:, :2], points[:, 2:]) @ np.array([1.0, 3.0])).reshape(1024, 4)
    found = sobol_indices(rows, 0)
    assert found.first == pytest.approx([0.1, 0.9], abs=5e-3)
    assert found.total == pytest.approx([0.1, 0.9], abs=5e-3)


def test_morris_of_a_linear_function_is_its_slopes():
    points, order, moved = trajectories(3, 20, 4, draws.generator(1, draws.MORRIS))
    assert ((points > 0.0) & (points < 1.0)).all()
    value = points @ np.array([1.0, -2.0, 0.0])
    before, after, step = (np.empty((20, 3)) for _ in range(3))
    rows = value.reshape(20, 4)
    for r in range(20):
        for k, i in enumerate(order[r]):
            before[r, i], after[r, i], step[r, i] = rows[r, k], rows[r, k + 1], moved[r, k]
    found = elementary_effects(before, after, step)
    assert found.strength == pytest.approx([1.0, 2.0, 0.0], abs=1e-12)
    assert found.deviation == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)


def test_indices_of_the_g_function():
    """Sobol's g-function: S_i = V_i / V, and of two inputs that move as one factor (V_1 + V_2 + V_1 V_2) / V."""
    a = np.array([0.5, 2.0, 9.0, 30.0])
    alone = 1.0 / (3.0 * (1.0 + a) ** 2)
    variance = np.prod(1.0 + alone) - 1.0
    points = draws.net_points(3, 8, 0, 0, 4096)

    def found(factors):
        x = mixed(points[:, :4], points[:, 4:], factors)
        value = np.prod((np.abs(4.0 * x - 2.0) + a) / (1.0 + a), axis=1)
        return sobol_indices(value.reshape(4096, len(factors) + 2), 3)

    each = found([(0,), (1,), (2,), (3,)])
    assert each.first == pytest.approx(alone / variance, abs=2e-3)
    assert each.total == pytest.approx(alone * (1.0 + variance) / (1.0 + alone) / variance, abs=2e-3)
    pair = found([(0, 1), (2,), (3,)])
    assert pair.first[0] == pytest.approx((alone[0] + alone[1] + alone[0] * alone[1]) / variance, abs=2e-3)


def test_morris_of_ishigami():
    points, order, moved = trajectories(3, 500, 4, draws.generator(1, draws.MORRIS))
    rows = ishigami((4.0 * points - 0.5) / 3.0).reshape(500, 4)
    before, after, step = (np.empty((500, 3)) for _ in range(3))
    for r in range(500):
        for k, i in enumerate(order[r]):
            before[r, i], after[r, i], step[r, i] = rows[r, k], rows[r, k + 1], moved[r, k] * 4.0 / 3.0
    assert elementary_effects(before, after, step).strength == pytest.approx([7.704, 7.875, 6.249], abs=0.6)
