"""Springs of bodies and geometric errors of arms, wherever an arm stands: against the fits that gave them, and by hand."""

import json

import numpy as np
import pytest

from cutwise.io.measurements import read_measurement
from cutwise.io.scenario import load
from cutwise.maths.chains import frames
from cutwise.process.arm_geometry import misplaced
from cutwise.process.assemble import deburring_cell
from cutwise.process.carried import jacobians_of
from cutwise.process.posture import arm_compliance, posture_jacobian
from cutwise.process.postures import candidates, tool_axes
from cutwise.process.recipes import quick_outcome
from cutwise.process.robot_arms import robot_arm
from cutwise.spec.faults import ScenarioFault
from cutwise.study.calibrate import stiffness
from cutwise.study.calibrate.outcome import calibrated

STIFF = ("robot-stiffness", ["robot.library=fanuc_r2000ic", "fit.model=bodies"])
HERE = {"requirements": "{}", "robot.joint_angles": "null"}
LINE = ("path.line.from=[1900 mm, -8 mm, 800 mm]", "path.line.to=[1900 mm, 8 mm, 800 mm]", "requirements={}",
        "operation.lead_in_time=0.05 s", "numerics.station=8 mm")  # fmt: skip


@pytest.fixture(scope="module")
def bodies(examples, tmp_path_factory):
    """The entry of non-negative springs that the load tests give, and the fit."""
    found = calibrated(STIFF[0], examples / "measured" / "fanuc_r2000ic" / "loads.csv", STIFF[1])
    file = tmp_path_factory.mktemp("arm") / "bodies.yaml"
    file.write_text(found.entry("bodies"))
    return file, found


@pytest.fixture(scope="module")
def scenario(examples, bodies):
    return load(examples / "drill_robot.yaml", {**HERE, "robot.library": str(bodies[0])})


def test_a_run_yields_as_the_fit_says(examples, bodies, scenario):
    """Compliance at the measured point times the force: the deflection that the fit models, to rounding."""
    found = bodies[1]
    data = read_measurement(
        examples / "measured" / "fanuc_r2000ic" / "loads.csv", stiffness.channels(found.settings), 3
    )
    q, force = data.matrix([f"joint{k}" for k in range(1, 7)]), data.matrix([f"force_{axis}" for axis in "xyz"])
    columns = stiffness.spring_columns(found.settings, stiffness.Tests(q, force, np.zeros_like(force)))
    given = {v.name: v.value for v in found.finding.values}
    compliance = np.array([given[f"body_compliance.{'.'.join(label)}"] for label in columns.labels])
    arm = robot_arm(scenario.robot)[0]
    for row in range(0, len(q), 7):
        modelled = columns.bodies[row] @ compliance
        assert arm_compliance(arm, q[row])[:3, :3] @ force[row] == pytest.approx(modelled, rel=1e-9, abs=1e-12)


def test_the_search_knows_the_springs(scenario):
    arm = robot_arm(scenario.robot)[0]
    poses = tool_axes(np.array([0.0, 0.0, -1.0]), np.radians([26.0, 140.0]))
    found = candidates(arm, np.tile([1.9, 0.3, 0.8], (2, 1)), poses)
    seen = 0
    for m, b in zip(*np.nonzero(found.within), strict=True):
        c = poses[m].T @ arm_compliance(arm, found.q[m, b])[:3, :3] @ poses[m]
        assert found.compliance[m, b] == pytest.approx(c[2, 2], rel=1e-12)
        seen += 1
    assert seen
    q = found.q[found.within][:2]
    assert jacobians_of(arm, q) == pytest.approx(np.array([posture_jacobian(arm, one) for one in q]), abs=1e-12)


def test_body_springs_about_the_joints_are_joint_springs(examples):
    """Rotations about z of the frames are the joints of this arm: the same holes by either word."""
    given = (1e6, 2e6, 2e6, 3e5, 4e5, 2e5)
    base = {**HERE, "robot.library": "fanuc_r2000ic", "robot.redundancy_angle": "26 deg"}
    joints = {"robot.joint_stiffness": [f"{k} N m/rad" for k in given]}
    body = {"robot.body_compliance": springs_of(given)}
    one, two = (
        quick_outcome(load(examples / "drill_robot.yaml", {**base, **each})).measures for each in (joints, body)
    )
    for name in one:
        assert two[name] == pytest.approx(one[name], rel=1e-6, abs=1e-12), name


def springs_of(stiffness):
    return [
        {"body": n, "motion": "rotation", "axis": "z", "value": f"{1 / k!r} rad/(N m)"}
        for n, k in enumerate(stiffness, 1)
    ]


def test_springs_that_leave_a_direction_stiff_are_refused(examples):
    one = "[{body: 1, motion: rotation, axis: z, value: 1 urad/(N m)}]"
    scenario = load(examples / "drill_robot.yaml", {"robot.body_compliance": one})
    with pytest.raises(ScenarioFault, match="cannot yield in every direction"):
        quick_outcome(scenario)


def test_bodies_carry_a_mill_along_a_path(examples):
    """Compliance and sag of an arm along a path, by springs of joints written in both ways."""
    given = (1e6, 2e6, 2e6, 3e5, 4e5, 2e5)
    common = ["robot.library=fanuc_r2000ic", "robot.redundancy_angle=0 deg", "robot.sag=absolute", "robot.tool_mass=30 kg",
              "robot.tool_centre=[100 mm, 0 mm, -150 mm]", *LINE]  # fmt: skip
    joints = load(
        examples / "deburr_on_robot.yaml",
        [*common, f"robot.joint_stiffness=[{', '.join(f'{k} N m/rad' for k in given)}]"],
    )
    springs = load(
        examples / "deburr_on_robot.yaml",
        [*common, f"robot.body_compliance={json.dumps(springs_of(given))}"],
    )
    assert springs.robot.joint_stiffness is None
    one, two = (deburring_cell(each).carriage.arm for each in (joints, springs))
    assert two.joints == pytest.approx(one.joints, rel=1e-9, abs=1e-15)
    assert two.sag == pytest.approx(one.sag, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            "[{body: 9, motion: rotation, axis: z, value: 1 urad/(N m)}]",
            "there is no body 9; they are base, 1 to 6, flange",
        ),
        ("[{body: 1, motion: rotation, axis: z, value: 1 um/N}]", '"um/N" is not a unit of angular compliance'),
        ("[{body: base, motion: translation, axis: z, value: 1 urad/(N m)}]", "not a unit of compliance"),
        ("[{body: base, motion: translation, axis: w, value: 1 um/N}]", "axis"),
        ("[{body: base, motion: translation, axis: x, value: -1 um/N}]", "value"),
        ("[{body: base, motion: translation, axis: x, value: 0 um/N}]", "nothing yields"),
    ],
)
def test_wrong_springs(examples, given, said):
    with pytest.raises(ScenarioFault) as caught:
        load(examples / "drill_robot.yaml", {"robot.body_compliance": given})
    assert said in str(caught.value)


def test_stiffness_is_written_once(examples):
    with pytest.raises(ScenarioFault, match="is in body_compliance already"):
        load(examples / "drill_robot.yaml", {
            "robot.body_compliance": "[{body: 1, motion: rotation, axis: z, value: 1 urad/(N m)}]",
            "robot.base_compliance": "[0.1 um/N, 0.1 um/N, 0.1 um/N]",
        })  # fmt: skip


def twist(k, values):
    return ["[0 m, 0 m, 0 m, 0 rad, 0 rad, 0 rad]" if n != k else f"[{', '.join(values)}]" for n in range(6)]


def test_a_hole_is_where_the_arm_really_is(examples):
    """A body displaced by 0.3 mm shifts the hole by as much, and a turned one by its lever and its angle."""
    shift = {"robot.errors.bodies": f"[{', '.join(twist(0, ['0.3 mm', '0 m', '0 m', '0 rad', '0 rad', '0 rad']))}]"}
    base = {**HERE, "robot.redundancy_angle": "26 deg"}
    plain = load(examples / "drill_robot.yaml", base)
    arm = robot_arm(plain.robot)[0]
    found = quick_outcome(load(examples / "drill_robot.yaml", {**base, **shift})).measures
    before = quick_outcome(plain).measures
    assert found["hole_position_error_arm"] == pytest.approx(0.3e-3 + plain.robot.accuracy, abs=1e-9)
    assert found["perpendicularity_error"] == pytest.approx(before["perpendicularity_error"], abs=1e-9)
    turn = {"robot.errors.bodies": f"[{', '.join(twist(5, ['0 m', '0 m', '0 m', '1 mrad', '0 rad', '0 rad']))}]"}
    turned = load(examples / "drill_robot.yaml", {**base, **turn})
    q = np.radians([[10.0, 20.0, -30.0, 40.0, 50.0, 60.0]])
    wrong = misplaced(turned.robot, arm, q)
    at = frames(arm.chain, q)
    axis = at.rotations[0, -1][:, 0]
    lever = at.rotations[0, -1] @ arm.tool_tip
    assert wrong.twist[0, 3:] == pytest.approx(1e-3 * axis, abs=1e-9)
    assert wrong.twist[0, :3] == pytest.approx(1e-3 * np.cross(axis, lever), abs=1e-6)
    away = quick_outcome(turned).measures
    assert abs(away["perpendicularity_error"] - before["perpendicularity_error"]) > 1e-4
    gone = quick_outcome(
        load(examples / "drill_robot.yaml", {**base, **turn, "robot.errors.compensated": True})
    ).measures
    assert gone["perpendicularity_error"] == before["perpendicularity_error"]


def test_outside_its_ranges_an_arm_is_nominal_and_says_so(examples):
    given = {
        **HERE, "robot.redundancy_angle": "26 deg",
        "robot.errors.joints": "[{sine: [1 mrad], cosine: [0 rad]}, {}, {}, {}, {}, {}]",
        "robot.errors.ranges": "[[100 deg, 120 deg], [-180 deg, 180 deg], [-180 deg, 180 deg], [-180 deg, 180 deg], "
        "[-180 deg, 180 deg], [-180 deg, 180 deg]]",
    }  # fmt: skip
    scenario = load(examples / "drill_robot.yaml", given)
    found = quick_outcome(scenario)
    assert found.measures["hole_position_error_arm"] == scenario.robot.accuracy
    assert any(
        "leaves the range in which its errors were measured" in text and "nominal" in text for text in found.warnings
    )
    inside = load(examples / "drill_robot.yaml", {**given, "robot.errors.ranges": "[]"})
    assert quick_outcome(inside).measures["hole_position_error_arm"] > scenario.robot.accuracy + 1e-5


def test_an_arm_leads_a_mill_wrong_along_a_path(examples):
    """Periodic errors of joint 1 move the tip across the path; taught at the start, only their change counts."""
    common = ["robot.library=fanuc_r2000ic", "robot.redundancy_angle=0 deg", *LINE]
    wave = "robot.errors.joints=[{sine: [0.5 mrad], cosine: [0 rad]}, {}, {}, {}, {}, {}]"
    along = {}
    for name, more in (("plain", ()), ("relative", (wave,)), ("absolute", (wave, "robot.sag=absolute"))):
        scenario = load(examples / "deburr_on_robot.yaml", [*common, *more])
        along[name] = deburring_cell(scenario).carriage.arm
    q = along["relative"].postures.q
    change = along["relative"].sag - along["plain"].sag
    assert change[0] == pytest.approx(np.zeros(6), abs=1e-15)
    point, up = along["relative"].path.point, np.array([0.0, 0.0, 1.0])
    moved = 0.5e-3 * np.sin(q[:, :1]) * np.cross(up, point)
    assert np.linalg.norm(change[-1, :3]) == pytest.approx(np.linalg.norm(moved[-1] - moved[0]), rel=0.01)
    whole = along["absolute"].sag - along["relative"].sag
    assert np.linalg.norm(whole[0, :3]) > 0.0


def test_faults_of_errors(examples):
    with pytest.raises(ScenarioFault) as caught:
        load(examples / "drill_robot.yaml", {
            "robot.errors.gravity_compliance": "[0 rad/(N m), 1 urad/(N m)]",
        })  # fmt: skip
    for words in ("has 2 entries for 6 joints", "errors.gravity_compliance needs the masses"):
        assert words in str(caught.value)
    with pytest.raises(ScenarioFault, match="has 0 orders, sine has 1"):
        load(examples / "drill_robot.yaml", {"robot.errors.joints": "[{sine: [1 mrad]}]"})


def test_postures_other_than_those_of_the_load_tests_are_told(examples):
    said = quick_outcome(load(examples / "drill_robot.yaml", {"robot.library": "fanuc_r2000ic"})).warnings
    (text,) = (one for one in said if "outside of the postures at which fanuc_r2000ic was measured" in one)
    assert "joint_4" in text
    mixed = load(examples / "drill_robot.yaml", {
        "robot.library": "fanuc_r2000ic", "robot.joint_stiffness": [f"{k} N m/rad" for k in (1e6, 2e6, 2e6, 3e5, 4e5, 2e5)],
    })  # fmt: skip
    assert not any("was measured" in one for one in quick_outcome(mixed).warnings)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("errors", "{bodies: []}"),
        ("body_compliance", "[{body: 1, motion: rotation, axis: z, value: 1 urad/(N m)}]"),
    ],
)
def test_a_budget_of_joints_refuses_what_it_would_ignore(examples, key, value):
    given = {
        "machine": "null", "robot.library": "kr270_r2700", f"robot.{key}": value, "requirements": "{}", "uncertainty": "null",
        "tool.tip": "null",
    }  # fmt: skip
    with pytest.raises(ScenarioFault, match=f"robot.{key}.*a budget at rest goes joint by joint"):
        load(examples / "machine_error_budget.yaml", given)
