"""Keys that change nothing are told where they were written by choice, and only there."""

import pytest

from cutwise.io.scenario import load
from cutwise.spec.faults import ScenarioFault
from cutwise.spec.notices import notices

_CASES = [
    ("machine_error_budget", ["material.library=al7075t6"], "material"),
    ("machine_error_budget", ["tool.overhang=30 mm"], "tool.overhang"),
    ("machine_pocket", ["load.force.axial_depth=5 mm"], "load.force.axial_depth"),
    ("machine_pocket", ["program.top=1 mm"], "program.top"),
    ("machine_volumetric_map", ["load.weights=false"], "load.weights"),
    ("mill_pocket_corner", ["lobes.speeds=20"], "lobes"),
    ("mill_pocket_corner", ["numerics.station=2 mm"], "numerics.station"),
    ("mill_pocket_corner", ["tool.runout_angle=10 deg"], "tool.runout_angle"),
    ("mill_on_robot", ["numerics.discs=20"], "numerics.discs"),
    ("mill_on_robot", ["tool.runout=5 um"], "tool.runout"),
    ("deburr_compliant_spindle", ["spindle.breakaway_travel=50 um"], "spindle.breakaway_travel"),
    ("deburr_on_robot", ["robot.payload=270 kg"], "robot.payload"),
    ("deburr_on_robot", ["robot.objective=stiffness"], "robot.objective"),
    ("drill_robot", ["part.slope_direction=10 deg"], "part.slope_direction"),
    ("drill_robot", ["numerics.lip_elements=50"], "numerics.lip_elements"),
    ("chamfer_pipe_hole", ["tool.helix=15 deg"], "tool.helix"),
]


_FREE = ["requirements={contour_error_max: {max: 1 mm}}"]


def _unused(scenario):
    return [text for text in notices(scenario) if "is not used" in text]


@pytest.mark.parametrize(
    ("example", "overrides", "key"), _CASES, ids=lambda value: value if isinstance(value, str) else ""
)
def test_told(example, overrides, key, examples):
    assert [
        text for text in _unused(load(examples / f"{example}.yaml", overrides)) if text.startswith(f"{key}: is not")
    ]


def test_examples_say_nothing_that_does_not_count(examples):
    told = {path.stem: _unused(load(path)) for path in examples.glob("*.yaml")}
    assert not {name: texts for name, texts in told.items() if texts}


def test_averaged_force_says_that_run_out_does_not_count(examples):
    found = notices(load(examples / "mill_pocket_corner.yaml", ["numerics.force=averaged", "tool.runout=5 um", *_FREE]))
    assert "tool.runout: does not count with numerics.force: averaged" in found


def test_a_tool_that_is_heavier_than_the_arm_may_carry_is_told(examples):
    weight = ["robot.sag=absolute", "robot.tool_mass=300 kg", "robot.tool_centre=[0 mm, 0 mm, 0 mm]"]
    found = notices(load(examples / "deburr_on_robot.yaml", weight))
    assert any("robot.tool_mass: is more than the rated payload" in text for text in found)


@pytest.mark.parametrize("override", ["part.height=320 mm", "program.zero=[-50 mm, -30 mm, 280 mm]"])
def test_a_program_beside_the_top_of_its_part_is_told(override, examples):
    found = notices(load(examples / "machine_pocket.yaml", [override]))
    assert any(text.startswith("program.zero: puts the top of the material") for text in found)


@pytest.mark.parametrize(
    ("key", "value"), [("travel", "[0 mm, 1 mm]"), ("turn", "[0 deg, 1 deg]"), ("axis", "[1, 0, 0]")]
)
def test_a_fixed_joint_has_no_axis_and_no_way(key, value, examples):
    with pytest.raises(ScenarioFault, match=f"joint.{key}.*(belongs to a|has no axis)"):
        load(examples / "machine_error_budget.yaml", [f"machine.chain[6].joint.{key}={value}"])


def test_a_size_of_another_section_is_refused(examples):
    with pytest.raises(ScenarioFault, match="is no size of a b"):
        load(examples / "machine_error_budget.yaml", ["machine.chain[4].elements[1].beam.diameter=80 mm"])


def test_path_beside_program_is_refused(examples, tmp_path):
    (tmp_path / "mill_pocket.nc").write_text((examples / "mill_pocket.nc").read_text())
    text = (examples / "mill_pocket.yaml").read_text() + "\npath: {corner: sharp}\n"
    (tmp_path / "both.yaml").write_text(text)
    with pytest.raises(ScenarioFault, match="exactly one of path"):
        load(tmp_path / "both.yaml")
