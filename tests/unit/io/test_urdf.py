"""URDF files: what is read, and what is wrong with them in plain words."""

import math
from pathlib import Path

import numpy as np
import pytest

import cutwise
from cutwise.io.urdf import read_urdf
from cutwise.process.drilling import robot_arm
from cutwise.spec.faults import ScenarioFault
from cutwise.spec.notices import notices

JOINTS = [  # origin, rpy, axis, lower, upper of the KR270 R2700, with a turned base in front and a tool frame behind
    ("0 0 0.675", "0 0 0", "0 0 -1", -2.967, 2.967),
    ("0.35 0 0", "0 0 0", "0 1 0", -3.403, 0.698),
    ("1.15 0 0", "0 0 0", "0 1 0", -2.007, 2.618),
    ("1.2 0 -0.041", "0 0 0", "-1 0 0", -3.229, 3.229),
    ("0 0 0", "0 0 0", "0 1 0", -2.094, 2.094),
    ("0.24 0 0", "0 0 0", "-1 0 0", -6.109, 6.109),
]


def urdf(changes=None, *, mass=None, extra="", effort="0") -> str:
    """A URDF with some joints replaced by other text."""
    parts = ['<robot name="kr270">']
    inertial = f'<inertial><mass value="{mass}"/></inertial>' if mass is not None else ""
    parts += [f'<link name="link_{k}">{inertial}</link>' for k in range(7)]
    for k, (xyz, rpy, axis, low, high) in enumerate(JOINTS, 1):
        text = (
            f'<joint name="joint_a{k}" type="revolute"><parent link="link_{k - 1}"/><child link="link_{k}"/>'
            f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
            f'<limit lower="{low}" upper="{high}" effort="{effort}" velocity="1"/></joint>'
        )
        parts.append((changes or {}).get(k, lambda t: t)(text))
    parts.append(
        '<link name="tool0"/><joint name="joint_a6-tool0" type="fixed"><parent link="link_6"/><child link="tool0"/>'
        '<origin xyz="0 0 0" rpy="0 1.5707963267948966 0"/></joint>'
    )
    return "".join([*parts, extra, "</robot>"])


def write(folder: Path, text: str) -> Path:
    path = folder / "robot.urdf"
    path.write_text(text)
    return path


def faults(folder: Path, text: str, **options) -> str:
    with pytest.raises(ScenarioFault) as caught:
        read_urdf(write(folder, text), "robot.urdf", **options)
    return str(caught.value)


def test_six_joints_and_the_last_moving_link_as_flange(tmp_path):
    arm = read_urdf(write(tmp_path, urdf()), "robot.urdf")
    assert [joint["name"] for joint in arm.joints] == [f"joint_a{k}" for k in range(1, 7)]
    assert arm.joints[3]["origin"] == ["1.2 m", "0.0 m", "-0.041 m"]
    assert arm.joints[1]["limits"] == ["-3.403 rad", "0.698 rad"]
    assert arm.flange["rotation"] == ["0.0 rad", "0.0 rad", "0.0 rad"]  # tool0 is turned by 90 degrees and not taken


def test_a_named_tip_link_is_taken(tmp_path):
    arm = read_urdf(write(tmp_path, urdf()), "robot.urdf", "tool0")
    assert float(arm.flange["rotation"][1].split()[0]) == pytest.approx(math.pi / 2)


def test_fixed_joints_fold_into_the_next_moving_one(tmp_path, examples):
    base = (
        '<link name="world"/><joint name="base" type="fixed"><parent link="world"/><child link="link_0"/>'
        '<origin xyz="1 2 3" rpy="0.3 -0.2 0.7"/></joint>'
    )
    write(tmp_path, urdf(extra=base))
    text = (
        (examples / "drill_robot.yaml")
        .read_text()
        .replace("library: kr270_r2700", "library: kr270_r2700\n  urdf: robot.urdf")
    )
    (tmp_path / "drill.yaml").write_text(text)
    folded, _ = robot_arm(cutwise.load(tmp_path / "drill.yaml").robot)
    assert folded.chain.origins[0] == pytest.approx(
        np.array([1, 2, 3]) + folded.chain.rotations[0] @ np.array([0, 0, 0.675])
    )
    assert np.linalg.det(folded.chain.rotations[0]) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("joint", "change", "words"),
    [
        (4, lambda t: t.replace("revolute", "fixed"), "5 moving joints"),
        (4, lambda t: t.replace("revolute", "fixed"), "fixed: joint_a4"),
        (3, lambda t: t.replace("revolute", "floating"), "joint joint_a3: is floating"),
        (3, lambda t: t.replace("revolute", "prismatic"), "is prismatic"),
        (2, lambda t: t.replace("revolute", "hinge"), '"hinge" is not one of URDF'),
        (2, lambda t: t.replace('lower="-3.403"', 'lower="1"'), "is not below the upper one"),
        (2, lambda t: t.replace('lower="-3.403" upper="0.698" ', ""), "has no limits"),
        (5, lambda t: t.replace('axis xyz="0 1 0"', 'axis xyz="0 0 0"'), "its axis has no length"),
        (5, lambda t: t.replace('origin xyz="0 0 0"', 'origin xyz="0 zero 0"'), "is not 3 finite numbers"),
        (6, lambda t: t.replace("</joint>", '<mimic joint="gear"/></joint>'), "follows gear (mimic), which is not"),
        (6, lambda t: t.replace("</joint>", '<mimic joint="joint_a4"/></joint>'), "5 moving joints"),
        (6, lambda t: t.replace('<parent link="link_5"/>', ""), "no parent"),
        (6, lambda t: t.replace('<parent link="link_5"/>', '<parent link="link_6"/>'), "ring"),
    ],
)
def test_faults_in_plain_words(tmp_path, joint, change, words):
    assert words in faults(tmp_path, urdf({joint: change}))


def test_all_faults_at_once(tmp_path):
    text = faults(
        tmp_path,
        urdf({2: lambda t: t.replace("revolute", "floating"), 5: lambda t: t.replace('xyz="0 1 0"', 'xyz="0 0 0"')}),
    )
    assert "joint_a2: is floating" in text
    assert "joint_a5: its axis has no length" in text


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<robot", "not well-formed"),
        ("<sdf/>", "begins with <sdf>"),
        ('<robot xmlns:xacro="x"><xacro:macro/></robot>', "xacro"),
        ("<robot><xacro:macro/></robot>", "xacro"),
        ('<robot name="${prefix}arm"/>', "xacro"),
        ('<!DOCTYPE r [<!ENTITY a "b">]><robot/>', "entities"),
        ("<robot/>", "0 moving joints"),
    ],
)
def test_files_that_are_no_robot(tmp_path, text, words):
    assert words in faults(tmp_path, text)


def test_an_unknown_tip_link(tmp_path):
    assert "no link flange" in faults(tmp_path, urdf(), tip_link="flange")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (urdf(mass=700), "weigh 4900 kg"),
        (urdf(mass=0), "without or with negative mass"),
        (urdf(), "effort limits are 0"),
        (urdf({1: lambda t: t.replace("revolute", "continuous")}), "is continuous"),
        (urdf({1: lambda t: t.replace("2.967", "170")}), "limits in degrees"),
    ],
)
def test_traps_are_pointed_out(tmp_path, text, words):
    assert any(words in notice for notice in read_urdf(write(tmp_path, text), "robot.urdf").notices)


def test_a_sound_file_is_silent(tmp_path):
    assert read_urdf(write(tmp_path, urdf(mass=180, effort="5000")), "robot.urdf").notices == ()


def scenario_with_urdf(examples, folder: Path) -> Path:
    text = (examples / "drill_robot.yaml").read_text()
    robot = (
        "robot:\n  urdf: robot.urdf\n"
        "  joint_stiffness: [3.8e6 N m/rad, 6.6e6 N m/rad, 3.9e6 N m/rad, 5.6e5 N m/rad, 6.6e5 N m/rad, "
        "4.7e5 N m/rad]\n"
        "  tool_position: [200 mm, 0 mm, -300 mm]\n  tool_rotation: [180 deg, 0 deg, 0 deg]\n  modal_mass: 150 kg\n"
        "  damping: 0.05\n  redundancy_angle: 26 deg\n"
    )
    start, end = text.index("robot:\n"), text.index("requirements:")
    path = folder / "drill.yaml"
    path.write_text(text[:start] + robot + text[end:])
    return path


def test_a_scenario_takes_a_urdf_and_joint_stiffness(tmp_path, examples):
    write(tmp_path, urdf())
    scenario = cutwise.load(scenario_with_urdf(examples, tmp_path))
    reference, _ = robot_arm(cutwise.load(examples / "drill_robot.yaml").robot)
    got, reason = robot_arm(scenario.robot)
    assert reason == ""
    assert got.chain.origins == pytest.approx(reference.chain.origins)
    assert got.limits == pytest.approx(reference.limits, abs=1e-3)
    assert any("effort limits are 0" in notice for notice in notices(scenario))


def test_faults_of_the_urdf_stand_with_the_others(tmp_path, examples):
    write(tmp_path, urdf({4: lambda t: t.replace("revolute", "fixed")}))
    path = scenario_with_urdf(examples, tmp_path)
    path.write_text(path.read_text().replace("feed_per_rev: 0.1 mm/rev", "feed_per_rev: -0.1 mm/rev"))
    with pytest.raises(ScenarioFault) as caught:
        cutwise.load(path)
    text = str(caught.value)
    assert "5 moving joints" in text
    assert "feed_per_rev" in text
    assert "robot.joints" not in text


def test_a_missing_urdf_is_named(tmp_path, examples):
    with pytest.raises(ScenarioFault, match="no such file"):
        cutwise.load(scenario_with_urdf(examples, tmp_path))


DATA = Path(__file__).parents[2] / "data" / "urdf"


def test_limits_of_two_turns_and_macros_in_comments_are_nothing_to_remark():
    assert read_urdf(DATA / "two_pi_limits.urdf", "two_pi_limits.urdf").notices == ()
    assert read_urdf(DATA / "xacro_comment.urdf", "xacro_comment.urdf").notices == ()


def test_an_entity_in_a_comment_is_none(tmp_path):
    text = urdf(effort="50").replace("<link", "<!-- <!ENTITY a 'b'> ${prefix} --><link", 1)
    assert read_urdf(write(tmp_path, text), "robot.urdf").notices == ()


def test_a_gripper_on_the_arm_names_the_remedy_and_the_remedy_works():
    with pytest.raises(ScenarioFault, match=r"robot\.tip_link: l6") as caught:
        read_urdf(DATA / "arm_with_gripper.urdf", "arm_with_gripper.urdf")
    assert len(caught.value.faults) == 1
    arm = read_urdf(DATA / "arm_with_gripper.urdf", "arm_with_gripper.urdf", "l6")
    assert len(arm.joints) == 6


def test_two_arms_on_one_base_ask_which(tmp_path):
    other = "".join(
        f'<link name="o{k}"/><joint name="other_{k}" type="revolute"><parent link="{parent}"/><child link="o{k}"/>'
        '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="0" velocity="1"/></joint>'
        for k, parent in enumerate(["link_0", *(f"o{n}" for n in range(1, 6))], 1)
    )
    text = faults(tmp_path, urdf(extra=other))
    assert "2 tips with 6 moving joints" in text
    assert "robot.tip_link: o6" in text


def rail(then: str) -> str:
    """The arm on a slide along x."""
    return urdf(extra=(
        f'<link name="world"/><joint name="rail" type="prismatic"><parent link="world"/><child link="{then}"/>'
        '<origin xyz="0 0 0.1"/><axis xyz="2 0 0"/><limit lower="0" upper="5" effort="0" velocity="1"/></joint>'
    ))  # fmt: skip


def test_a_rail_is_held_at_a_position(tmp_path):
    text = faults(tmp_path, rail("link_0"))
    assert "robot.held_joints: [{joint: rail, position: 0 mm}]" in text
    arm = read_urdf(write(tmp_path, rail("link_0")), "robot.urdf", held={"rail": 0.5})
    assert [float(x.split()[0]) for x in arm.joints[0]["origin"]] == pytest.approx([0.5, 0, 0.775])
    assert "to hold between base and tip" in faults(tmp_path, rail("link_0"), held={"rial": 0.5, "rail": 0.0})


SEVENTH = (
    '<link name="link_7"/><joint name="joint_a7" type="revolute"><parent link="link_6"/><child link="link_7"/>'
    '<origin xyz="0.1 0 0"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="0" velocity="1"/></joint>'
)


def test_seven_axes_name_the_remedy_and_one_held_is_an_arm(tmp_path, examples):
    assert "robot.held_joints: [{joint: joint_a3, angle: 0 deg}]" in faults(tmp_path, urdf(extra=SEVENTH))
    write(tmp_path, urdf(extra=SEVENTH))
    path = scenario_with_urdf(examples, tmp_path)
    held = "robot.held_joints=[{joint: joint_a7, angle: 30 deg}]"
    with pytest.raises(ScenarioFault, match="6 values for 7 joints"):
        cutwise.load(path, [held])
    stiffness = ", ".join(["1e6 N m/rad"] * 7)
    arm, _ = robot_arm(cutwise.load(path, [held, f"robot.joint_stiffness=[{stiffness}]"]).robot)
    assert arm.drives.rows.shape == (7, 6)
    assert arm.drives.elastic.shape == (7, 7)
    assert arm.drives.offsets[6] == pytest.approx(math.radians(30))


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("robot.held_joints=[{joint: joint_a9, angle: 0 deg}]", "there is no joint joint_a9"),
        ("robot.held_joints=[{joint: joint_a2, angle: 90 deg}]", "beyond the limits of joint joint_a2"),
        ("robot.held_joints=[{joint: joint_a2}]", "needs one place"),
        ("robot.linkages=[{joint: joint_a3, driver: joint_a3}]", "is the joint itself"),
        ("robot.linkages=[{joint: joint_a3, driver: elbow}]", "joint elbow does not exist"),
        ("robot.linkages=[{joint: joint_a3, driver: joint_a2, ratio: 0}]", "0 is no linkage"),
    ],
)
def test_couplings_that_cannot_be(examples, override, words):
    with pytest.raises(ScenarioFault, match=words):
        cutwise.load(examples / "drill_robot.yaml", [override])


def test_a_urdf_whose_tip_is_named_on_the_command_line(examples, tmp_path):
    write(tmp_path, urdf())
    scenario = cutwise.load(scenario_with_urdf(examples, tmp_path), ["robot.tip_link=tool0"])
    assert scenario.robot.flange_rotation[1] == pytest.approx(math.pi / 2)
