"""The base of a robot says which way is down: for links and tool, and for a compliant spindle that it carries."""

import math

import numpy as np
import pytest

import cutwise
from cutwise.process import assemble, programmed_milling, spindles
from cutwise.process.recipes import quick_outcome
from cutwise.spec.faults import ScenarioFault

ACROSS = (
    "path.line.from=[1900 mm, -10 mm, 1200 mm]", "path.line.to=[1900 mm, 10 mm, 1200 mm]", "path.tool_axis=[1, 0, 0]",
    "robot.joint_angles=null", "robot.redundancy_angle=best_constant", "operation.lead_in_time=0.05 s", "requirements={}",
)  # fmt: skip
WEIGHT = 0.6 * 9.80665 * 0.075  # [N m] of the spindle about its joint
ROUND = (
    "robot={library: kr270_r2700, dynamics: static}", "placement={origin: [1900 mm, 0 mm, 800 mm]}", "requirements={}",
)  # fmt: skip


def moments(examples, *overrides):
    ring = assemble.deburring_cell(cutwise.load(examples / "deburr_on_robot.yaml", (*ACROSS, *overrides))).ring
    return [ring.moment_x, ring.moment_y]


@pytest.mark.parametrize(
    ("overrides", "moment"),
    [
        (("spindle.library=default",), (0.0, WEIGHT)),  # off the work is down here
        (("spindle.library=default", "operation.milling=up", "path.work=left"), (0.0, -WEIGHT)),
        (("spindle.library=default", "robot.gravity=[0, -3, 0]"), (-WEIGHT, 0.0)),  # against the feed
        (("spindle.library=default", "robot.gravity=[1, 0, 0]"), (0.0, 0.0)),  # along the spindle
        (("spindle.library=default", "spindle.gravity=-y"), (0.0, -WEIGHT)),  # what is written stays
        (("spindle.library=berselli2016",), (0.0, 0.0)),  # off
    ],
)
def test_weight_of_a_spindle_that_a_robot_holds(examples, overrides, moment):
    assert moments(examples, *overrides) == pytest.approx(moment, abs=1e-15)


def test_the_weight_counts_as_if_it_were_written(examples):
    def error(*overrides):
        scenario = cutwise.load(
            examples / "deburr_on_robot.yaml", (*ACROSS, "spindle.library=default", "robot.dynamics=static", *overrides)
        )
        return quick_outcome(scenario, coarse=True).measures["surface_error_mean"]

    assert error() == error("spindle.gravity=+y")
    assert error() - error("spindle.gravity=off") > 50e-6


def test_a_spindle_that_mills_on_a_robot_hangs_the_same_way(examples):
    scenario = cutwise.load(
        examples / "mill_on_robot.yaml",
        (*(one for one in ACROSS if "lead_in" not in one), "spindle={library: default}", "numerics={force: averaged}"),
    )
    path, _ = programmed_milling.prepare(scenario)
    ((_, term),) = spindles.pistons_of(scenario.compliant, scenario.robot, path.axes[0])
    assert (term.ring.moment_x, term.ring.moment_y) == pytest.approx((0.0, WEIGHT), abs=1e-15)


@pytest.mark.parametrize("down", [(0.0, 0.0, -1.0), (0.0, 0.0, 1.0), (0.3, -0.2, -1.0), (1.0, 0.0, 0.0)])
def test_a_tool_that_weighs_at_its_tip_sinks_by_its_weight_times_the_compliance(examples, down):
    scenario = cutwise.load(
        examples / "deburr_on_robot.yaml",
        (
            "robot.tool_mass=25 kg", "robot.tool_centre=[200 mm, 0 mm, -300 mm]", "robot.sag=absolute",
            f"robot.gravity={list(down)}", "requirements={}",
        ),
    )  # fmt: skip
    along = assemble.edge_cut(scenario).carriage.arm
    force = 25.0 * 9.80665 * np.array(down) / math.hypot(*down)
    for axes, compliance, sag in zip(along.path.axes, along.joints, along.sag, strict=True):
        assert sag[:3] == pytest.approx(compliance[:3, :3] @ (axes.T @ force), rel=1e-10)


def test_a_weight_that_turns_about_the_spindle_is_refused(examples):
    lying = (*ROUND, "spindle={library: default}", "path.tool_axis=[1, 0, 0]", "path.orientation=follow")
    with pytest.raises(ScenarioFault, match=r"spindle\.gravity: the weight across the spindle turns about it"):
        cutwise.load(examples / "deburr_arc.yaml", lying)
    with pytest.raises(ScenarioFault, match="turns about it"):
        cutwise.load(examples / "deburr_arc.yaml", ("spindle={library: default, gravity: -y}",))
    for fine in (
        ("path.orientation=fixed",),
        ("spindle.gravity=off",),
        ("path.tool_axis=[0, 0, -1]",),
        ("robot.gravity=[1, 0, 0]",),
    ):
        cutwise.load(examples / "deburr_arc.yaml", (*lying, *fine))


def test_a_direction_that_nothing_weighs_in_is_told(examples):
    def told(*overrides):
        warnings = quick_outcome(
            cutwise.load(
                examples / "mill_on_robot.yaml", ("requirements={}", "robot.gravity=[0, 0, 1]", *overrides)
            )
        ).warnings  # fmt: skip
        return [one for one in map(str, warnings) if "robot.gravity" in one]

    assert told() == ["robot.gravity: counts for a compliant spindle alone: no weight of links or tool is given"]
    assert not told("robot.library=kr270_r2700_masses", "robot.sag=absolute")
