"""Bands of a run: digits of an independent reference program, laws, and what cannot be told."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from cutwise import Result, advise, load, simulate
from cutwise.io import library
from cutwise.io.scenario import read_document, revised
from cutwise.process import recipes
from cutwise.process.posture import posture_at, posture_frames
from cutwise.process.postures import tool_axes
from cutwise.process.recipes import Outcome
from cutwise.process.robot_arms import robot_arm
from cutwise.results import Measure, judge
from cutwise.spec.faults import ScenarioFault
from cutwise.study import band, batch
from cutwise.study.calibrate.cutting import integrals
from cutwise.study.calibrate.outcome import calibrated
from cutwise.study.case import Case
from cutwise.study.inputs import overrides, scatter_of

HOLES = {
    "A-2": (-102.550, -23.780, 59.470, -64.550, 60.930, -65.120),
    "C-1": (-63.384, 2.353, 29.203, -179.996, -58.453, 206.614),
}
ARM = {"robot.library": "fanuc_r2000ic", "requirements": "{}", "robot.joint_angles": "null"}


def at_hole(examples, hole, **more):
    """Drilling at a posture of the holes: along +y of the flange, at the point that was loaded."""
    q = np.radians(HOLES[hole])
    arm = robot_arm(load(examples / "drill_robot.yaml", ARM).robot)[0]
    at = posture_frames(arm, q)
    rotation = at.rotations[-1] @ arm.tool_rotation
    tip = at.origins[-1] + at.rotations[-1] @ arm.tool_tip
    zero = tool_axes(rotation[:, 2], 0.0)
    angle = math.atan2(rotation[:, 0] @ zero[:, 1], rotation[:, 0] @ zero[:, 0])
    given = {
        "hole.position": [f"{v!r} m" for v in tip.tolist()], "hole.axis": rotation[:, 2].tolist(),
        "robot.redundancy_angle": f"{angle!r} rad", "robot.joint_angles": [f"{v} deg" for v in HOLES[hole]],
    }  # fmt: skip
    return load(examples / "drill_robot.yaml", {**ARM, **given, **more})


def axial(scenario):
    """Compliance along the drill per compliance of each joint, from the geometry alone."""
    arm = robot_arm(scenario.robot)[0]
    slopes = []
    for k in range(6):
        stiffness = np.full(6, 1e30)
        stiffness[k] = 1.0
        slopes.append(
            posture_at(arm._replace(stiffness=stiffness), 0.0, np.array(scenario.robot.joint_angles)).compliance[2, 2]
        )
    return np.array(slopes)


@pytest.mark.parametrize(
    ("hole", "c_zz", "sd", "uncorrelated", "limit", "probability"),
    [("A-2", 1.574048, 0.089528, 0.107934, 1.7, 0.91900), ("C-1", 3.136492, 0.082831, 0.120332, 3.3, 0.97469)],
)
def test_compliance_along_the_drill(examples, hole, c_zz, sd, uncorrelated, limit, probability):
    """Linear in the compliances: the band by differences is exact."""
    asked = {"compliance_axial": {"max": f"{limit} um/N", "probability": 0.95}}
    scenario = at_hole(examples, hole, requirements=asked)
    result = simulate(scenario)
    found = result.measures["compliance_axial"]
    assert found.value == pytest.approx(c_zz * 1e-6, abs=1e-12)
    assert found.band.sd == pytest.approx(sd * 1e-6, abs=1e-12)
    covariance = scatter_of(scenario).blocks[0].covariance
    alone = axial(scenario) ** 2 @ np.diagonal(covariance)
    assert math.sqrt(alone) == pytest.approx(uncorrelated * 1e-6, abs=1e-12)
    half = float(stats.t(123).ppf(0.95)) * found.band.sd
    assert (found.band.low, found.band.high) == pytest.approx((found.value - half, found.value + half), rel=1e-9)
    check = result.checks[0]
    assert check.probability_reached == pytest.approx(probability, abs=1e-5)
    assert check.passed == (probability >= 0.95)
    assert result.verdict == ("pass" if check.passed else "fail")
    assert result.measures["probability_all"].value == pytest.approx(probability, abs=0.003)
    assert result.band.residuals == {"robot": "0.00022002585155226522 m"}
    assert "tool.web" in result.band.not_in_band
    told = json.loads(json.dumps(result.summary(), allow_nan=False))
    assert told["measures"]["compliance_axial"]["band"].keys() == {"sd", "low", "high"}
    assert told["requirements"][0]["probability"] == 0.95
    assert told["requirements"][0]["probability_reached"] == pytest.approx(probability, abs=1e-5)
    again = Result.from_bytes(result.to_bytes(), scenario)
    assert (again.band, again.checks, dict(again.measures)) == (result.band, result.checks, dict(result.measures))


def made_up(monkeypatch, scenario, formula, names=("compliance_axial",), **settings):
    """A band of a formula of the inputs in place of a run."""
    scatter = scatter_of(scenario)
    given = overrides(scenario, scatter.inputs)
    at = [one.value for one in scatter.inputs]

    def cases(*_arguments, **_more):
        def case(values):
            moved = list(at)
            for k, one in enumerate(scatter.inputs):
                if one.leaf in values:
                    value = values[one.leaf]
                    for step in one.inside:
                        value = value[step]
                    moved[k] = value
            return Case(values, Outcome(dict(zip(names, formula(*moved), strict=True))))

        return case

    assert given({}) == {}
    monkeypatch.setattr(batch, "cases", cases)
    scenario = scenario.model_copy(update={"band": scenario.band.model_copy(update=settings)})
    measures = {
        name: Measure(v, scenario.measures[name].dimension) for name, v in zip(names, formula(*at), strict=True)
    }
    return band.banded(Result(scenario, SimpleNamespace(), measures, tuple(judge(scenario, measures))))


def test_draws_of_the_compliance(examples, monkeypatch):
    """A-2 by draws: joint 6 may be stiff beyond measure, so that one draw in forty is thrown away."""
    scenario = at_hole(examples, "A-2", requirements={"compliance_axial": {"max": "1.7 um/N"}})
    slopes = axial(scenario)
    found = made_up(
        monkeypatch, scenario, lambda *k: (float(slopes @ (1.0 / np.array(k))),), method="sampled", samples=20000
    )
    spread = found.measures["compliance_axial"].band
    assert found.band.thrown_away / 20000 == pytest.approx(0.025, abs=0.004)
    assert spread.sd == pytest.approx(0.0880e-6, rel=0.02)
    assert found.checks[0].probability_reached == pytest.approx(0.931, abs=0.006)
    assert any("draws of the band were thrown away" in text for text in found.warnings)


SLOT = ["tool.flutes=2", "operation.axial_depth=3 mm", "cut.arc=[0 deg, 180 deg]"]


def forces(*k):
    """Mean forces of the slot at 0.08 mm."""
    i_sc, i_ss, i_s, i_c, arc = integrals(0.0, math.pi)
    f, c = 2 * 3e-3 / (2.0 * math.pi), 0.08e-3
    tc, rc, ac, te, re, ae = k
    return (
        -f * (c * (tc * i_sc + rc * i_ss) + te * i_c + re * i_s), f * (c * (tc * i_ss - rc * i_sc) + te * i_s - re * i_c),
        -f * (c * ac * i_s + ae * arc),
    )  # fmt: skip


@pytest.fixture
def slot(examples, tmp_path):
    """An edge cut with the coefficients of the slots of the specification."""
    data = examples / "measured" / "synthetic" / "slots.csv"

    def made(without_block=False):
        text = calibrated("cutting", data, SLOT).entry("mine")
        if without_block:
            start, end = text.index("covariances:"), text.index("measured:")
            text = text[:start] + text[end:]
        file = tmp_path / "mine.yaml"
        file.write_text(text)
        return load(examples / "deburr_compliant_spindle.yaml", {"material.library": str(file), "requirements": "{}"})

    return made


NAMES = ("work_force_mean_x", "work_force_mean_y", "work_force_mean_z")


def test_forces_of_a_slot(slot, monkeypatch):
    found = made_up(monkeypatch, slot(), forces, NAMES)
    values = [found.measures[name].value for name in NAMES]
    assert values == pytest.approx([-68.0360, 126.9136, -37.4180], abs=1e-4)
    assert [found.measures[n].band.sd for n in NAMES] == pytest.approx([0.93767, 1.32314, 0.43023], abs=1e-5)
    middle = found.measures[NAMES[1]]
    assert middle.band.high - middle.value == pytest.approx(3.1138, abs=1e-4)


def test_without_its_covariance_a_band_is_three_times_as_wide_and_says_so(slot, monkeypatch):
    found = made_up(monkeypatch, slot(without_block=True), forces, NAMES)
    assert [found.measures[n].band.sd for n in NAMES] == pytest.approx([3.0256, 4.2694, 1.3882], abs=1e-4)
    assert any("have standard errors but no covariance" in text for text in found.warnings)


def test_a_scenario_read_back_gives_the_same_band(slot, monkeypatch):
    scenario = slot()
    again = read_document(json.loads(json.dumps(scenario.document())), "again")
    one, two = (made_up(monkeypatch, each, forces, NAMES) for each in (scenario, again))
    for name in NAMES:
        assert two.measures[name].band[:3] == pytest.approx(one.measures[name].band[:3], rel=1e-12)


def test_what_is_written_beside_an_entry_leaves_its_covariance(slot):
    scenario = slot()
    replaced = revised(scenario, {"material.K_tc": "800 N/mm^2"})
    (block,) = scatter_of(replaced).blocks
    assert "material.K_tc" not in [one.key for one in scatter_of(replaced).inputs]
    whole = scatter_of(scenario).blocks[0].covariance
    assert block.covariance == pytest.approx(whole[1:, 1:], rel=1e-12)
    assert not scatter_of(revised(scenario, {"material.library": "berselli2016"})).inputs


def test_two_fits_by_welch_and_satterthwaite(examples, monkeypatch):
    scenario = load(examples / "drill_robot.yaml", {
        "requirements": "{}",
        "covariances": {
            "one": {"of": ["tool.web"], "matrix": [[1e-8]], "degrees_of_freedom": 4},
            "two": {"of": ["part.thickness"], "matrix": [[4.0]], "unit": "um", "degrees_of_freedom": 9},
        },
    })  # fmt: skip
    scatter = scatter_of(scenario)
    assert [one.key for one in scatter.inputs] == ["tool.web", "part.thickness"]
    assert scatter.standard_errors == pytest.approx([1e-4, 2e-6])
    found = made_up(monkeypatch, scenario, lambda web, thickness: (2.0 * web + 100.0 * thickness,))
    spread = found.measures["compliance_axial"].band
    v = np.array([4e-8, 4e-8])
    freedom = v.sum() ** 2 / (v[0] ** 2 / 4 + v[1] ** 2 / 9)
    assert spread.sd == pytest.approx(math.sqrt(8e-8))
    assert spread.high - spread.low == pytest.approx(2 * stats.t(freedom).ppf(0.95) * math.sqrt(8e-8))


def test_a_bend_has_no_linear_band(slot, monkeypatch):
    scenario = slot()
    k_tc = scenario.material.K_tc
    bent = lambda *k: (abs(k[0] - k_tc), *forces(*k)[1:])  # noqa: E731
    found = made_up(monkeypatch, scenario, bent, NAMES)
    assert found.measures[NAMES[0]].band is None
    assert found.measures[NAMES[1]].band is not None
    assert found.band.left_out == (NAMES[0],)
    assert any(
        "no linear band for work_force_mean_x" in text and "band.method=sampled" in text for text in found.warnings
    )
    drawn = made_up(monkeypatch, scenario, bent, NAMES, method="sampled", samples=4000)
    assert drawn.measures[NAMES[0]].band.low > 0.0


def test_a_demanded_probability_without_a_band_fails(slot, monkeypatch):
    asked = {"work_force_mean_x": {"max": "1e9 N", "probability": 0.9}}
    scenario = revised(slot(), {f"requirements.{name}": limit for name, limit in asked.items()})
    k_tc = scenario.material.K_tc
    found = made_up(monkeypatch, scenario, lambda *k: (abs(k[0] - k_tc), *forces(*k)[1:]), NAMES)
    assert not found.checks[0].passed
    assert [finding.code for finding in found.findings] == ["unreached"]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"requirements.thrust_max": "{max: 200 N, probability: 0.9}"}, "no probability can be told: it needs a value with"),
        ({"requirements.thrust_max_band_high": "{max: 200 N}"}, "a run of this scenario has no such measure"),
        ({"requirements.thrust_max": "{max: 200 N, probability: 0.3}"}, "0.3 is not between 0.5 and 1"),
        ({"requirements.thrust_max": "{max: 200 N, probability: often}"}, "not a plain number"),
        ({"robot.library": "fanuc_r2000ic", "band.method": "none", "requirements.probability_all": "{min: 0.9}"},
         "band.method linear or sampled"),
        ({"covariances": {"one": {"of": ["tool.wb"], "matrix": [[1e-8]]}}}, "tool.wb is no value of this scenario"),
        ({"covariances": {"one": {"of": ["tool.web"], "matrix": [[-1.0]]}}}, "not positive semi-definite"),
        ({"covariances": {"one": {"of": ["tool.web"], "matrix": [[1.0]], "unit": "N"}}}, '"N" is not a unit of length'),
        ({"tool.web": "{value: 1 mm, standard_error: 10 N}"}, '"N" is not a unit of length'),
        ({"tool.web": "{value: 1 mm, standard_error: -10 um}"}, "-10 um is below zero"),
    ],
)  # fmt: skip
def test_bad_input(examples, given, said):
    with pytest.raises(ScenarioFault) as caught:
        load(examples / "drill_robot.yaml", given)
    assert said in str(caught.value)


def test_a_covariance_in_another_unit_than_its_standard_errors(examples, tmp_path):
    """Wrong by a million, and no way to see it in the result."""
    text = library.entry("robots", "fanuc_r2000ic").file.read_text()
    file = tmp_path / "arm.yaml"
    file.write_text(text.replace("unit: rad/(N m)", "unit: urad/(N m)"))
    with pytest.raises(ScenarioFault, match="is a unit wrong"):
        load(examples / "drill_robot.yaml", {"robot.library": str(file)})


def test_ends_of_a_band_can_be_required(examples):
    scenario = load(examples / "drill_robot.yaml", {
        "robot.library": "fanuc_r2000ic",
        "requirements": {"compliance_axial_band_high": {"max": "2.8 um/N"}, "compliance_axial_band_sd": {"max": "0.1 um/N"}},
    })  # fmt: skip
    result = simulate(scenario)
    assert [check.passed for check in result.checks] == [True, False]
    assert result.verdict == "fail"
    assert not result.unsound
    assert result.measures["compliance_axial_band_sd"].value == result.measures["compliance_axial"].band.sd


def test_no_band_where_nothing_is_known(examples):
    scenario = load(examples / "drill_robot.yaml")
    result = recipes.simulate(scenario)
    assert band.banded(result) is result


def test_what_the_data_do_not_tell_is_said(examples):
    scenario = load(
        examples / "drill_robot.yaml", {"tool.web": "{value: 1 mm, standard_error: inf mm}", "requirements": "{}"}
    )
    found = band.banded(recipes.simulate(scenario))
    assert any("do not tell tool.web" in text for text in found.warnings)


def test_scatter_of_a_machine_adds_to_a_demanded_probability(examples):
    asked = {"deviation_y_middle": {"max": "0.4 mm", "min": "-0.4 mm", "probability": 0.5}}
    base = {"requirements": asked, "uncertainty.samples": 2000}
    result = simulate(load(examples / "machine_error_budget.yaml", base))
    value, sd = (result.measures[name].value for name in ("deviation_y_middle", "deviation_std_y"))
    expected = stats.norm.cdf((4e-4 - value) / sd) - stats.norm.cdf((-4e-4 - value) / sd)
    assert result.checks[0].probability_reached == pytest.approx(expected, rel=1e-9)
    more = {**base, "covariances": {"force": {"of": ["load.force[1]"], "matrix": [[40000.0]]}}}
    both = simulate(load(examples / "machine_error_budget.yaml", more))
    own = both.measures["deviation_y_middle"].band.sd
    assert own > 0.0
    wide = math.hypot(own, both.measures["deviation_std_y"].value)
    expected = stats.norm.cdf((4e-4 - value) / wide) - stats.norm.cdf((-4e-4 - value) / wide)
    assert both.checks[0].probability_reached == pytest.approx(expected, rel=1e-6)


def test_values_that_only_their_sum_is_known_of(examples, monkeypatch):
    """Each by itself is open to a millimetre, their sum to a micrometre: a band along the axes of the covariance."""
    wide, narrow = 1e-3, 1e-6
    plus, minus = narrow**2 / 2.0, wide**2 / 2.0
    matrix = [[0.5 * (plus + minus), 0.5 * (plus - minus)], [0.5 * (plus - minus), 0.5 * (plus + minus)]]
    scenario = load(examples / "drill_robot.yaml", {
        "requirements": "{}",
        "covariances": {"both": {"of": ["tool.web", "part.thickness"], "matrix": matrix, "degrees_of_freedom": 50}},
    })  # fmt: skip
    total = scenario.tool.web + scenario.part.thickness
    found = made_up(monkeypatch, scenario, lambda web, thickness: (((web + thickness) / total) ** 40,))
    spread = found.measures["compliance_axial"].band
    assert spread.sd == pytest.approx(40.0 / total * math.sqrt(2.0 * plus), rel=1e-3)


def test_advice_says_that_it_looks_at_values(examples):
    asked = {"compliance_axial": {"max": "2.7 um/N", "probability": 0.9}}
    scenario = load(examples / "drill_robot.yaml", {"robot.library": "fanuc_r2000ic", "requirements": asked})
    assert any("this looks at values" in text for text in advise(scenario, {}, runs=3))
