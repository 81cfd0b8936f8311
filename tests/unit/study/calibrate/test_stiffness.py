"""Springs of an arm: 43 load tests of an R-2000iC, held against an independent reference program."""

import math
from pathlib import Path

import numpy as np
import pytest

from cutwise.maths.chains import jacobian
from cutwise.spec.faults import ScenarioFault
from cutwise.study.calibrate.arm import in_last_frame, serial
from cutwise.study.calibrate.outcome import calibrated

LOADS = Path(__file__).parents[4] / "examples" / "measured" / "fanuc_r2000ic" / "loads.csv"
ARM = "robot.library=fanuc_r2000ic"


def outcome(*more, file=LOADS):
    return calibrated("robot-stiffness", file, [ARM, *more])


def by_model(found):
    return {row[0]: row[1:] for row in found.finding.compared[1:]}


def test_joints_of_the_r2000ic():
    found = outcome()
    fit, values = found.finding.fit, found.finding.values
    expected = [860896.0, 2719583, 1959760, 270828.3, 424693.0, 206019.8]
    assert [value.value for value in values] == pytest.approx(expected, rel=1e-6)
    relative = [100 * value.standard_error / value.value for value in values]
    assert relative == pytest.approx([3.537, 16.235, 11.934, 14.119, 17.058, 48.025], abs=1e-3)
    assert fit.scale == pytest.approx(0.220026e-3, rel=1e-5)
    assert fit.degrees_of_freedom == 123
    assert fit.condition == pytest.approx(3.4930, abs=1e-4)
    assert fit.left_out_cover == pytest.approx(0.9147, abs=1e-4)
    c = fit.correlation()
    assert (c[1, 2], c[0, 3], c[4, 5]) == pytest.approx((-0.784, -0.539, -0.531), abs=1e-3)
    assert [(o.row + 1, o.column, round(o.studentised, 3)) for o in fit.outliers] == [(17, "deflection_x", 4.114)]
    assert (fit.next.row + 1, round(fit.next.gain, 5)) == (9, 0.38557)
    assert (fit.next.parameter, fit.next.parameter_row + 1) == ("joint_stiffness[5]", 12)
    assert fit.next.factor == pytest.approx(0.94214, abs=1e-5)


def test_the_interval_of_a_stiffness_is_that_of_its_compliance_turned_over():
    sixth = outcome().finding.values[5]
    assert (sixth.low, sixth.high) == pytest.approx((0.1147e6, 1.010e6), rel=1e-3)
    assert sixth.verdict == "weak"


def test_what_depends_on_the_model_is_weak():
    found = outcome()
    notes = [value.note for value in found.finding.values]
    for k, moved in ((0, "-5.54"), (2, "-2.16"), (3, "-2.60"), (4, "-2.76")):
        assert moved in notes[k]
        assert found.finding.values[k].verdict == "weak"
    assert not notes[1]
    assert found.reasons


def test_joints_and_base():
    found = outcome("fit.model=joints+base")
    values = found.finding.values
    assert [v.value for v in values[6:]] == pytest.approx([1.03738e-6, 0.53223e-6, 0.39617e-6], rel=1e-5)
    assert [v.value for v in values[:3]] == pytest.approx([1.070736e6, 2.742859e6, 2.639529e6], rel=1e-6)
    assert found.finding.condition == pytest.approx(7.1288, abs=1e-4)


def test_bodies_predict_left_out_tests_to_ten_percent():
    found = outcome("fit.model=bodies")
    finding = found.finding
    assert finding.left_out_error == pytest.approx(0.10295, abs=1e-5)
    table = by_model(found)
    assert table["joints"][:3] == ("214.85 µm", "19.47 %", "22.29 %")
    assert table["joints+base"][1] == "16.09 %"
    assert table["bodies"][:3] == ("137.52 µm", "10.3 %", "18.04 %")
    largest = {value.name: value.value for value in finding.values if value.value > 0.0}
    assert largest["body_compliance.1.rotation.z"] == pytest.approx(652.6e-9, abs=1e-10)
    assert largest["body_compliance.base.translation.z"] == pytest.approx(162.4e-9, abs=1e-10)
    assert len(largest) == 12
    assert not found.reasons  # it predicts better than the joints alone


def springs(tmp_path, compliance, noise=0.0, seed=0, sign=(1, 1, 1), rows=60, posture=None, load=(1, 1, 1)):
    """Load tests made up from known springs."""
    rng = np.random.default_rng(seed)
    arm = outcome().settings.robot
    q = rng.uniform(-1.0, 1.0, size=(rows, 6))
    if posture is not None:
        q[:, 1:] = posture
    force = rng.uniform(-800.0, 800.0, size=(rows, 3)) * load
    v = jacobian(serial(arm), q, in_last_frame(arm, arm.tool_position))[:, :3]
    moved = np.einsum("nci,nc,i,ndi->nd", v, force, compliance, v) + noise * rng.normal(size=(rows, 3))
    titles = [f"joint{k} [rad]" for k in range(1, 7)] + [f"force_{a} [N]" for a in "xyz"]
    titles += [f"deflection_{a} [mm]" for a in "xyz"]
    lines = [",".join(repr(float(x)) for x in row) for row in np.hstack([q, force, 1e3 * moved * sign])]
    file = tmp_path / "loads.csv"
    file.write_text("\n".join([",".join(titles), *lines]))
    return file


TRUTH = 1.0 / np.array([3.8e6, 6.6e6, 3.9e6, 5.6e5, 6.6e5, 4.7e5])


def test_springs_come_back(tmp_path):
    found = outcome(file=springs(tmp_path, TRUTH))
    assert [1.0 / v.value for v in found.finding.values] == pytest.approx(TRUTH, rel=1e-8)
    assert not found.reasons  # the models differ by rounding, not by two of errors that are rounding
    noisy = outcome(file=springs(tmp_path, TRUTH, 2e-5))
    assert all(v.low < 1.0 / c < v.high for v, c in zip(noisy.finding.values, TRUTH, strict=True))
    assert not noisy.reasons


@pytest.mark.parametrize(
    ("sign", "said"), [((-1, -1, -1), "against the force"), ((1, -1, 1), "axis y"), ((1, 1, -1), "axis z")]
)
def test_a_turned_axis_is_refused(tmp_path, sign, said):
    with pytest.raises(ScenarioFault, match=said):
        outcome(file=springs(tmp_path, TRUTH, 2e-5, sign=sign))


def test_a_negative_spring_is_written_with_a_warning(tmp_path):
    found = outcome(file=springs(tmp_path, TRUTH * [1, 1, 1, 1, 1, -1]))
    assert found.finding.values[5].value < 0.0
    assert any("negative" in text for text in found.warnings)
    assert found.reasons


def test_all_faults_of_a_file_at_once(tmp_path):
    file = tmp_path / "loads.csv"
    lines = LOADS.read_text().splitlines()[:12]
    lines[1] = lines[1].replace("force_x [N]", "force_x").replace("joint2 [rad]", "joint2 [mm]")
    cells = lines[7].split(",")
    lines[7] = ",".join([*cells[:9], " 0.9", " much", ""])
    lines[8] = "57.3" + lines[8][lines[8].index(",") :]
    file.write_text("\n".join(lines))
    with pytest.raises(ScenarioFault) as caught:
        outcome(file=file)
    text = str(caught.value)
    for said in (
        "loads.csv:2:", "force_x: no unit; write force_x [N]", "joint2: \"mm\" is not a unit of angle", "loads.csv:8:",
        "0.9 m is more than 20 mm; millimetres in a column of metres?", '"much" is not a number', "an empty cell",
        "loads.csv:9:1: joint1: 57.3 rad is more than 7 rad", "6 faults",
    ):  # fmt: skip
        assert said in text


def test_an_unknown_model_is_refused():
    with pytest.raises(ScenarioFault, match="joints, joints\\+base, bodies"):
        outcome("fit.model=springs")


def test_degrees_give_what_radians_give(tmp_path):
    lines = LOADS.read_text().splitlines()
    out = [lines[1].replace("[rad]", "[deg]")]
    for line in lines[2:]:
        cells = line.split(",")
        out.append(",".join([*(repr(math.degrees(float(c))) for c in cells[:6]), *cells[6:]]))
    file = tmp_path / "degrees.csv"
    file.write_text("\n".join(out))
    one, two = outcome(), outcome(file=file)
    assert [v.value for v in two.finding.values] == pytest.approx([v.value for v in one.finding.values], rel=1e-9)


@pytest.mark.parametrize("kind", ["modal", "spindle-seals", "feed-drive"])
def test_a_model_that_a_kind_does_not_have_is_refused(kind, tmp_path):
    with pytest.raises(ScenarioFault) as caught:
        calibrated(kind, tmp_path / "none.csv", ["fit.model=joints", "fit.harmonics=3", "fit.gravity=true"])
    assert "fit.harmonics" in str(caught.value)  # a key of another kind
    assert "none.csv" in str(caught.value)


def test_a_loss_that_does_not_act_is_told():
    assert any("fit.loss acts on joints" in text for text in outcome("fit.model=bodies", "fit.loss=soft_l1").warnings)


UNDER_THE_WEIGHT = {"posture": (0.2, 0.1, 0.0, 0.0, 0.0), "load": (0, 0, 1)}


def test_a_joint_that_no_force_loads_is_refused(tmp_path):
    """Weights hung from the tool say nothing of an upright axis: named, with a prior that then is taken."""
    file = springs(tmp_path, TRUTH, 1e-6, **UNDER_THE_WEIGHT)
    with pytest.raises(ScenarioFault, match="axis of joint 1, so that nothing is known of") as caught:
        outcome(file=file)
    assert len(caught.value.faults) == 1
    known = outcome('fit.prior={"joint_stiffness[0]": [3.8e6 N m/rad, 5e5 N m/rad]}', file=file)
    assert known.finding.values[0].value == pytest.approx(3.8e6)
    with pytest.raises(ScenarioFault, match="the force is 0 in all rows"):
        outcome(file=springs(tmp_path, TRUTH, 1e-6, load=(0, 0, 0)))


def test_what_load_tests_leave_free_is_named(tmp_path):
    """Axes 4 and 6 in line: their combination, and how a prior would be written, as a stiffness."""
    found = outcome(file=springs(tmp_path, TRUTH, 1e-6, posture=(0.2, 0.1, 0.3, 0.0, 0.5)))
    (combination,) = found.finding.unknown
    assert set(combination) == {"joint_stiffness[3]", "joint_stiffness[5]"}
    said = next(text for text in found.finding.cannot_tell if "do not determine" in text)
    assert "fit.prior=" in said
    assert "N*m/rad" in said
