"""What carries a tool is told the same by every process that it carries one for."""

import numpy as np
import pytest

from cutwise.io.scenario import load
from cutwise.process import carried, carriers, yielding
from cutwise.process.assemble import edge_cut
from cutwise.process.edges import known_axes
from cutwise.process.recipes import quick_outcome

SHORT = ("path.line.from=[1900 mm, -10 mm, 800 mm]", "path.line.to=[1900 mm, 10 mm, 800 mm]", "requirements={}")
CASES = {
    "deburr": ("deburr_on_robot", *SHORT, "operation.lead_in_time=0.05 s"),
    "deburr, at rest": ("deburr_on_robot", *SHORT, "spindle=rigid", "operation.preset=0 mm", "numerics={mode: still}"),
    "mill": ("mill_on_robot", *SHORT),
    "chamfer": ("chamfer_on_robot", "path.points=48", "requirements={}"),
}


@pytest.mark.parametrize("case", CASES)
def test_joints_whose_speed_is_not_known_are_told(case, examples):
    name, *overrides = CASES[case]
    said = quick_outcome(load(examples / f"{name}.yaml", [*overrides, "robot.joint_speed=null"])).warnings
    assert sum("robot.joint_speed is not given" in one for one in said) == 1


def test_stiffness_of_a_robot_is_that_of_the_robot_at_rest_too(examples):
    """A tool and a part that yield are terms of their own, and none of the carrier."""
    name, *overrides = CASES["deburr, at rest"]
    soft = load(examples / f"{name}.yaml", [*overrides, "tool.stiffness=1 N/um", "part.stiffness=1 N/um"])
    cut = edge_cut(soft)
    found = carriers.measures(soft, cut.carriage, cut.behind, 0.08)
    assert [term for term, _ in cut.behind] == ["tip", "arm", "part_stiffness"]
    assert found["stiffness_normal_min"] == pytest.approx(1.0 / 0.404123e-6, rel=0.02)  # specified: C_yy of the arm


def test_sag_is_told_at_a_height_over_the_tip():
    along = carried.ArmAlong(None, None, None, None, None, np.arange(6.0)[None], None, 0.0, 0.0, None)
    assert carried.sag_at(along, 0.5).tolist() == [[2.0, -0.5, 2.0]]


def test_a_force_at_a_height_has_a_moment_about_the_tip():
    assert yielding.wrench_at(np.array([2.0, 3.0, 5.0]), 0.1).tolist() == pytest.approx([2.0, 3.0, 5.0, -0.3, 0.2, 0.0])


def test_points_of_an_arm_end_at_its_tip(examples):
    arm = carried.robot_arm(load(examples / "deburr_on_robot.yaml").robot)[0]
    base, *_, tip = carriers.points_of(arm, np.zeros((1, 6)))[0]
    assert base.tolist() == [0.0, 0.0, 0.0]
    assert np.linalg.norm(tip) > 1.0


@pytest.mark.parametrize(("keys", "axes"), [({}, "xyz"), ({"K_ac": None}, "xy"), ({"K_ac": None, "k_a11": 1e9}, "xyz")])
def test_a_force_along_the_tool_needs_an_axial_coefficient_of_either_law(keys, axes, examples):
    material = load(examples / "mill_on_robot.yaml").material
    assert known_axes(material.model_copy(update=keys)) == axes
