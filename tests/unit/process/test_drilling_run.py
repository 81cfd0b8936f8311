"""Scenarios of process drill from file to result: the reference hole, patterns, faults, what cannot be drilled."""

import math

import numpy as np
import pytest

import cutwise
from cutwise.io import library
from cutwise.io.scenario import read_document
from cutwise.spec.faults import ScenarioFault, dotted
from cutwise.spec.notices import notices

NAMES = (
    "thrust_max", "torque_max", "lateral_force_max", "axial_deflection_max", "lateral_deflection_max",
    "hole_position_error_entry", "hole_position_error_exit", "perpendicularity_error", "circularity_estimate",
    "feed_per_rev_max", "feed_per_rev_min", "depth_error", "skating_ratio", "compliance_axial", "redundancy_angle",
    "thrust_lips", "thrust_chisel", "cycle_time",
)  # fmt: skip


def run(examples, *overrides, example="drill_robot.yaml"):
    return cutwise.simulate(cutwise.load(examples / example, overrides))


@pytest.fixture(scope="module")
def result(examples):
    return run(examples)


def test_reference_hole(result):
    got = {name: result.measures[name].value for name in NAMES}
    assert math.degrees(got["redundancy_angle"]) == pytest.approx(26)
    assert got["compliance_axial"] == pytest.approx(0.768923e-6, rel=1e-6)
    assert got["skating_ratio"] == pytest.approx(0.115890, rel=1e-5)
    assert got["hole_position_error_entry"] == pytest.approx(1.0208e-6, rel=1e-3)
    assert got["hole_position_error_exit"] == pytest.approx(2.8308e-6, rel=1e-3)
    assert got["perpendicularity_error"] == pytest.approx(0.3620e-3, rel=1e-3)
    assert got["feed_per_rev_max"] == pytest.approx(0.12889e-3, rel=1e-3)
    assert got["circularity_estimate"] == pytest.approx(0.20054e-6, rel=1e-4)
    assert got["thrust_lips"] == pytest.approx(87.5726733, rel=1e-8)
    assert got["thrust_chisel"] == pytest.approx(76.3216934, rel=1e-8)
    assert got["cycle_time"] == pytest.approx(2.0605, abs=1e-4)
    assert result.verdict == "pass"


def test_nothing_moves_by_a_thousandth_with_half_the_step(result):
    for name in NAMES:
        value = result.measures[name].value
        tolerance = 4e-3 if name == "depth_error" else 1e-3
        assert abs(result.convergence[name]) <= tolerance * abs(value) + 1e-12, name


def test_the_shares_add_up_at_every_depth(result):
    cutting = result["cutting"]
    assert (cutting["thrust_lips"] + cutting["thrust_chisel"]).values == pytest.approx(cutting["thrust_nominal"].values)
    assert float(cutting["thrust_chisel"].max()) == pytest.approx(76.3216934, rel=1e-6)
    assert float(cutting["thrust_nominal"].max()) == pytest.approx(163.8943667, rel=1e-6)
    assert float(cutting["torque_margin"].max()) == pytest.approx(3.6e-3, rel=1e-6)


def test_stages_hold_map_arm_and_histories(result):
    assert set(result.stages.children) >= {"motion", "engagement", "cutting", "structure", "surface", "map", "holes"}
    within = result["map"]["within_limits"].values
    assert 0 < within.sum() < within.size
    arm = result["motion"]["arm"].sel(hole=1)
    assert arm.sel(point="drill tip").values == pytest.approx([1.9, 0.3, 0.8], abs=1e-12)
    assert result["structure"]["tip_deflection"].sizes["time"] > 1000


def test_plausibility_and_cross_check_are_told(result):
    assert "183.7 N" in result.notes["plausibility"]
    assert "holds" in result.notes["skating"]
    assert "1.038" in result.notes["cross_check"]


def test_assumed_values_are_listed(result):
    for key in (
        "contact.friction",
        "contact.wall_stiffness",
        "contact.wander_length",
        "robot.modal_mass",
        "material.k_c11",
    ):
        assert key in result.assumed


def test_a_run_file_runs_again(result, tmp_path):
    path = result.save(tmp_path / "run.nc")
    again = cutwise.load(path)
    assert again == result.scenario
    assert cutwise.simulate(again).measures["thrust_max"].value == result.measures["thrust_max"].value


@pytest.mark.parametrize(
    ("choice", "angle", "axial", "ratio"),
    [("stiffest", -139.425, 0.711852, 0.7246), ("least_skating", 24.594, 0.770486, 0.112498)],
)
def test_choice_of_posture(examples, choice, angle, axial, ratio):
    got = run(examples, f"robot.redundancy_angle={choice}").measures
    assert math.degrees(got["redundancy_angle"].value) == pytest.approx(angle, abs=1e-3)
    assert got["compliance_axial"].value * 1e6 == pytest.approx(axial, abs=1e-6)
    assert got["skating_ratio"].value == pytest.approx(ratio, abs=5e-5)


def test_best_is_no_worse_than_the_others(examples):
    def error(choice):
        got = run(examples, f"robot.redundancy_angle={choice}").measures
        return max(got[f"hole_position_error_{end}"].value for end in ("entry", "exit"))

    assert error("best") <= min(error("stiffest"), error("least_skating")) * (1 + 1e-9)


def test_a_skating_posture_warns(examples):
    got = run(examples, "robot.redundancy_angle=stiffest")
    assert got.verdict == "fail"
    assert any("skates at entry" in text for text in got.warnings)


def test_pattern_with_a_place_and_a_posture_for_every_hole(examples):
    got = run(examples, example="drill_plate_pattern.yaml")
    assert got.measures["holes_drilled"].value == 6
    assert got["holes"]["passed"].values.all()
    assert "redundancy_angle" not in got.measures
    worst = float(got["holes"]["hole_position_error_exit"].max())
    assert got.measures["hole_position_error_exit"].value == pytest.approx(worst)
    assert "Of 9 places" in got.notes["placement"]
    unplaced = run(
        examples, "part.placement.x=[0 mm, 0 mm]", "part.placement.y=[0 mm, 0 mm]", example="drill_plate_pattern.yaml"
    )
    assert got.measures["skating_ratio"].value <= unplaced.measures["skating_ratio"].value + 1e-9


def test_a_hole_out_of_reach_is_infeasible_with_its_margin(examples):
    got = run(examples, "hole.position=[3900 mm, 300 mm, 800 mm]", "robot.redundancy_angle=best")
    assert got.verdict == "fail"
    assert "out of reach" in got.infeasible[0]
    assert "mm too short" in got.infeasible[0]
    assert got.measures["holes_drilled"].value == 0
    assert "hole_position_error_entry" not in got.measures


def test_a_limit_in_the_way_is_named_with_what_is_missing(examples):
    got = run(examples, "hole.position=[700 mm, 100 mm, 200 mm]")
    assert got.verdict == "fail"
    assert "joint 3 (joint_a3) would have to go" in got.infeasible[0]
    assert "beyond its limits" in got.infeasible[0]


def test_a_singular_posture_is_infeasible(examples):
    """A drill along axis 6 that has to point along the forearm: the wrist is straight."""
    got = run(examples, "robot.singularity_margin=0.99", "robot.redundancy_angle=26 deg")
    assert got.verdict == "fail"
    assert "singular posture" in got.infeasible[0]


def test_one_hole_of_a_pattern_out_of_reach(examples):
    got = run(examples, "hole.others=[[3900 mm, 300 mm, 800 mm]]")
    assert got.verdict == "fail"
    assert got.infeasible[0].startswith("hole 2 at (3900, 300, 800) mm")
    assert got["holes"]["drilled"].values.tolist() == [True, False]
    assert np.isnan(got["holes"]["thrust_max"].values[1])


def test_faults_all_at_once(examples):
    with pytest.raises(ScenarioFault) as caught:
        cutwise.load(
            examples / "drill_robot.yaml",
            ["operation.feed_per_rev=-0.1 mm", "contact.wander_length=0 mm", "robot.redundancy_angle=bestt"],
        )
    text = "\n".join(f"{dotted(fault.path)}: {fault.message}" for fault in caught.value.faults)
    assert "operation.feed_per_rev: -0.1 mm is impossible" in text
    assert "contact.wander_length" in text
    assert "did you mean best?" in text
    assert len(caught.value.faults) == 3


def test_a_drill_shorter_than_the_hole(examples):
    with pytest.raises(ScenarioFault, match="drill is shorter than the hole"):
        cutwise.load(examples / "drill_robot.yaml", ["tool.flute_length=6 mm"])


def test_half_a_point_angle_warns(examples):
    found = notices(cutwise.load(examples / "drill_robot.yaml", ["tool.point_angle=59 deg"]))
    assert any("looks like half the angle" in text for text in found)


def test_the_pairing_of_the_reference_robot_is_pointed_out(examples):
    assert any("kr270_2f" in text for text in notices(cutwise.load(examples / "drill_robot.yaml")))


def test_an_absurd_set_of_joint_stiffnesses_warns(examples):
    got = run(examples, "robot.library=kr240_2")
    assert any("absurd" in text and "sags" in text for text in got.warnings)
    assert not any("sags" in text for text in run(examples).warnings)


def test_every_robot_of_the_library_drills_or_asks_for_its_stiffness(examples):
    for name in library.names("robots"):
        extra = ["robot.joint_stiffness=[3e6 N m/rad, 3e6 N m/rad, 3e6 N m/rad, 5e5 N m/rad, 5e5 N m/rad, 5e5 N m/rad]"]
        given = [] if "joint_stiffness" in library.entry("robots", name).values.value else extra
        got = run(examples, f"robot.library={name}", "robot.redundancy_angle=least_skating", *given)
        assert got.measures["holes_drilled"].value == 1, name
        if given:
            with pytest.raises(ScenarioFault, match="joint_stiffness"):
                cutwise.load(examples / "drill_robot.yaml", [f"robot.library={name}"])


@pytest.mark.parametrize("material", ["ti6al4v", "steel_200hb", "al_iscar_n22", "ti_iscar_s37"])
def test_materials_of_the_library(examples, material):
    got = run(examples, f"material.library={material}")
    assert 100 < got.measures["thrust_max"].value < 700


def test_oblique_lips(examples):
    got = run(examples, "tool.lip_model=oblique").measures
    assert got["thrust_lips"].value + got["thrust_chisel"].value == pytest.approx(94.635, abs=0.01)
    assert got["torque_lips"].value + got["torque_chisel"].value == pytest.approx(0.5868, abs=1e-4)


def test_a_steep_slope_drives_the_drill_aside(examples):
    flat, steep = (run(examples, f"part.inclination={a} deg").measures for a in (0, 10))
    assert steep["hole_position_error_entry"].value > 20 * flat["hole_position_error_entry"].value
    with pytest.raises(ScenarioFault, match="corner of the drill"):
        cutwise.load(examples / "drill_robot.yaml", ["part.inclination=31.5 deg"])


def test_a_robot_without_spherical_wrist_gets_every_posture_without_a_word(examples):
    scenario = cutwise.load(examples / "drill_robot.yaml")
    shifted = [joint.model_dump() for joint in scenario.robot.joints]
    shifted[5]["origin"] = (0.24, 0.03, 0.0)
    document = scenario.document()
    document["robot"]["joints"] = [
        {
            "origin": [f"{x} m" for x in j["origin"]],
            "axis": list(j["axis"]),
            "limits": [f"{x} rad" for x in j["limits"]],
        }
        for j in shifted
    ]
    got = cutwise.simulate(read_document(document, overrides=["robot.redundancy_angle=least_skating"]))
    assert not any("spherical" in text for text in got.warnings)
    assert got.measures["holes_drilled"].value == 1
    assert got.measures["hole_position_error_entry"].value < 20e-6


def test_too_long_a_time_step_warns(examples):
    got = run(examples, "numerics.time_step=2 ms")
    assert any(finding.code == "unsolved" and finding.dimension == "time" for finding in got.unsound)


def test_drill_torque_on_the_arm_is_an_option(examples):
    off, on = (run(examples, f"contact.drill_torque_on_arm={state}").measures for state in ("false", "true"))
    change = on["hole_position_error_entry"].value / off["hole_position_error_entry"].value - 1
    assert -0.05 < change < -0.001
