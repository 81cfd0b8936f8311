"""What is known beforehand: offered where the data say nothing, used as one more measurement, refused where it cannot be."""

import math

import numpy as np
import pytest

from cutwise.spec.faults import ScenarioFault
from cutwise.study.calibrate.fit import fitted
from cutwise.study.calibrate.outcome import calibrated
from cutwise.study.calibrate.posed import Posed, Unknown

SPINDLE = [
    "spindle.piston_arm=80 mm",
    "spindle.tool_reach=150 mm",
    "spindle.pistons=7",
    "spindle.reference_pressure=5 bar",
]


@pytest.fixture
def travel(tmp_path):
    """Slow travel at 4 bar alone, while friction is stated at 5: alpha is open, and with it F_s and F_d in part."""
    g, kappa = 80 / 150 * 7 / math.pi, 0.3 + 0.7 * 4 / 5
    clean = [g * (1.54 * 4 + s * f * kappa) for s, f in ((1, 2.8), (-1, 2.8), (1, 3.9), (-1, 3.9))]
    noise = 0.1 * np.random.default_rng(2).normal(size=(8, 4))
    file = tmp_path / "travel.csv"
    titles = "pressure [bar], loading_plateau [N], unloading_plateau [N], breakaway [N], return_breakaway [N]"
    rows = [", ".join(f"{v:.6f}" for v in (4.0, *(np.array(clean) + e))) for e in noise]
    file.write_text("\n".join([titles, *rows]))
    return file


def test_a_prior_is_offered_and_used(travel):
    without = calibrated("spindle-seals", travel, SPINDLE)
    verdicts = {v.name: v.verdict for v in without.finding.values}
    assert verdicts["alpha"] == "not identified"
    offered = next(text for text in without.finding.cannot_tell if "do not determine" in text)
    assert "known of it beforehand can be given: --set fit.prior=" in offered
    given = calibrated("spindle-seals", travel, [*SPINDLE, 'fit.prior={"alpha": [0.3, 0.05]}'])
    told = {v.name: (v.value, v.standard_error, v.verdict) for v in given.finding.values}
    assert told["alpha"][:2] == pytest.approx((0.3, 0.05), rel=1e-6)
    assert told["F_d"][0] == pytest.approx(2.8, abs=4 * told["F_d"][1])
    assert told["F_d"][2] == "identified"
    assert not given.reasons
    assert any("known beforehand of alpha: 0.3" in text for text in given.finding.cannot_tell)
    assert len(given.finding.fit.residual) == 32


@pytest.mark.parametrize("by_column", [False, True])
def test_a_prior_weighs_as_a_measurement(by_column):
    """The posterior of a straight line with a normal prior on its slope, by hand."""
    rng = np.random.default_rng(3)
    x = np.linspace(1.0, 2.0, 40)
    y = 2.0 + 3.0 * x + 0.1 * rng.normal(size=40)
    matrix = np.column_stack([np.ones(40), x])
    posed = Posed(
        (Unknown("a", "dimensionless"), Unknown("b", "dimensionless")), y, np.arange(40), np.zeros(40, dtype=int), ("y",),
        ("dimensionless",), lambda v: matrix @ v, lambda _: matrix, sigma_by_column=by_column,
        degrees_of_freedom=38 if by_column else None,
    )  # fmt: skip
    plain = fitted(posed)
    found = fitted(posed, prior={"b": (2.9, 0.02)})
    s = plain.scatter[0]
    information = matrix.T @ matrix / s**2 + np.diag([0.0, 1.0 / 0.02**2])
    expected = np.linalg.solve(information, matrix.T @ y / s**2 + np.array([0.0, 2.9 / 0.02**2]))
    assert found.x == pytest.approx(expected, rel=2e-3)
    assert np.sqrt(np.diagonal(found.covariance)) == pytest.approx(
        np.sqrt(np.diagonal(np.linalg.inv(information))), rel=0.08
    )


def test_a_stiffness_is_known_as_a_stiffness(examples):
    """Joint 6 of the load tests is weak; what a maker says of it helps, and the fit is in compliances."""
    loads = examples / "measured" / "fanuc_r2000ic" / "loads.csv"
    prior = 'fit.prior={"joint_stiffness[5]": ["3e5 N m/rad", "3e4 N m/rad"]}'
    found = calibrated("robot-stiffness", loads, ["robot.library=fanuc_r2000ic", prior])
    sixth = found.finding.values[5]
    assert sixth.value == pytest.approx(3e5, rel=0.1)
    assert sixth.standard_error < 4e4


def test_data_against_a_prior_say_so(travel):
    found = calibrated(
        "spindle-seals", travel, [*SPINDLE, 'fit.prior={"A": [1.5e-5 m^2, 1e-8 m^2], "alpha": [0.3, 0.05]}']
    )
    assert any("known beforehand of A" in text and "contradict it" in text for text in found.finding.cannot_tell)


@pytest.mark.parametrize(
    ("kind", "given", "said"),
    [
        ("spindle-seals", 'fit.prior={"beta": [0.3, 0.05]}', "beta: no parameter of this fit; there are A, F_s"),
        ("spindle-seals", 'fit.prior={"F_s": [3 bar, 1 bar]}', '"bar" is not a unit of force'),
        ("spindle-seals", 'fit.prior={"F_s": [3 N, 0 N]}', "the standard deviation is not above zero"),
        ("spindle-seals", 'fit.prior={"F_s": 3 N}', "fit.prior"),
    ],
)
def test_priors_that_are_none(travel, kind, given, said):
    with pytest.raises(ScenarioFault) as caught:
        calibrated(kind, travel, [*SPINDLE, given])
    assert said in str(caught.value)


def test_non_negative_springs_take_none(examples):
    loads = examples / "measured" / "fanuc_r2000ic" / "loads.csv"
    given = [
        "robot.library=fanuc_r2000ic",
        "fit.model=bodies",
        'fit.prior={"joint_stiffness[0]": [1e6 N m/rad, 1e5 N m/rad]}',
    ]
    with pytest.raises(ScenarioFault, match="takes no priors"):
        calibrated("robot-stiffness", loads, given)
