"""What an arm cannot follow fails in every process, told as what it is; nothing that a user wrote is passed over."""

import pytest

from cutwise.app.exits import explain
from cutwise.io.scenario import load
from cutwise.process.recipes import prepare, quick_outcome, simulate
from cutwise.results import Infeasible
from cutwise.spec.faults import ScenarioFault
from cutwise.spec.notices import notices
from cutwise.study.levers import levers_of

SHORT = {"path.line.to": "[1900 mm, -100 mm, 800 mm]", "operation.lead_in_time": "0.1 s"}
FILES = {"deburr_on_robot": SHORT, "mill_on_robot": {}}
SLOW = {"robot.joint_speed": "[1 deg/s, 1 deg/s, 1 deg/s, 1 deg/s, 1 deg/s, 1 deg/s]"}
FAR = {"placement.origin": "[1500 mm, 0 mm, 0 mm]"}


def scenario(examples, name, **changes):
    return load(examples / f"{name}.yaml", {**FILES[name], **changes})


@pytest.mark.parametrize("name", FILES)
def test_joints_that_cannot_follow_the_feed_are_no_pass(examples, name):
    slow = scenario(examples, name, **SLOW)
    found = simulate(slow)
    assert found.measures["joint_speed_margin"].value < 0.0
    assert found.verdict == "fail"
    assert found.infeasible[0].startswith("the joints follow 14.")
    assert quick_outcome(slow).infeasible == found.infeasible


@pytest.mark.parametrize("name", FILES)
def test_a_path_out_of_reach_is_a_result_and_not_a_failure_of_the_solver(examples, name):
    far = scenario(examples, name, **FAR)
    found = simulate(far)
    assert found.verdict == "fail"
    assert "cannot follow the path" in found.infeasible[0]
    assert not found.measures
    assert quick_outcome(far).infeasible == found.infeasible
    with pytest.raises(Infeasible) as why:
        prepare(far)
    assert explain(why.value) == 1


@pytest.mark.parametrize("name", FILES)
def test_what_is_unusual_about_a_scenario_is_told(examples, name):
    given = scenario(examples, name, **{"robot.redundancy_angle": "best_constant"})
    assert set(notices(given)) <= set(simulate(given).warnings)


def test_chatter_that_a_scenario_sets_aside_does_not_fail(examples):
    changes = {"operation.spindle_speed": "2000 rpm", "requirements": "{path_length: {max: 1 m}}"}
    assert simulate(scenario(examples, "mill_on_robot", **changes)).verdict == "fail"
    assert simulate(scenario(examples, "mill_on_robot", stability="ignore", **changes)).verdict == "none"


def test_run_out_of_a_mill_on_an_arm_is_a_mean_over_the_turn(examples):
    """Its direction counts for nothing, and the wall is deeper by the outermost flute."""

    def wall(angle):
        given = scenario(examples, "mill_on_robot", **{"tool.runout": "10 um", "tool.runout_angle": angle})
        found = quick_outcome(given).measures
        return found["wall_error_max"], found["force_xy_mean_straight"]

    (straight, force), (turned, same) = wall("0 deg"), wall("120 deg")
    assert (straight, force) == pytest.approx((turned, same), rel=1e-9)
    even = quick_outcome(scenario(examples, "mill_on_robot")).measures
    assert force == pytest.approx(even["force_xy_mean_straight"], rel=0.05)
    assert straight == pytest.approx(even["wall_error_max"] + 10e-6, abs=2e-6)


def test_an_arm_without_mass_and_a_mill_with_run_out_go_together_over_arcs(examples):
    found = simulate(scenario(examples, "deburr_on_robot", **{"tool.runout": "5 um"}))
    assert "surface_error_mean" in found.measures
    assert any("robot.dynamics: modal" in warning for warning in found.warnings)
    with pytest.raises(ScenarioFault, match="needs an arm with mass"):
        scenario(examples, "deburr_on_robot", **{"numerics.engagement": "swept"})


def test_steps_whose_displacement_was_not_found_are_told(examples):
    soft = "[" + ", ".join(["100 N*m/rad"] * 6) + "]"
    found = quick_outcome(scenario(examples, "deburr_on_robot", **{"robot.joint_stiffness": soft}))
    assert "unsolved" in {finding.code for finding in found.findings}


def test_a_robot_mills_no_arc_and_has_no_corner_to_turn(examples):
    arc = "{arc: {centre: [1900 mm, 0 mm, 800 mm], radius: 30 mm, from: 90 deg, sweep: 90 deg}, tool_axis: [0, 0, -1]}"
    with pytest.raises(ScenarioFault, match="a robot mills along a line"):
        scenario(examples, "mill_on_robot", path=arc)
    assert "path.corner" not in {lever.key for lever in levers_of(scenario(examples, "mill_on_robot"))}
