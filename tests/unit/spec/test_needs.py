"""A requirement on a measure that no run of the scenario has is told at once, with the key that would provide it."""

import pytest

from cutwise.io.scenario import load
from cutwise.process.recipes import quick_outcome
from cutwise.spec.faults import ScenarioFault

BY_ITS_WAY = {  # what only the run can tell: no rod beside the part, no straight, no wall that is plane, no settling
    "rod_clearance_min", "rod_clearance_bound", "rod_clearance_deflected_min", "work_convexity", "wall_flatness",
    "drive_error_max", "settling_overshoot", "settling_time",
}  # fmt: skip
QUICK = (
    "chamfer_compliant_spindle", "chamfer_pipe_hole", "deburr_compliant_spindle", "drill_robot", "machine_error_budget",
    "machine_five_axis", "machine_pocket", "machine_volumetric_map", "mill_pocket", "mill_pocket_corner",
)  # fmt: skip


@pytest.mark.parametrize("name", QUICK)
def test_every_measure_is_there_or_says_what_it_needs(examples, name):
    scenario = load(examples / f"{name}.yaml")
    found = quick_outcome(scenario, list(scenario.measures)).measures
    assert [measure for measure in found if scenario.lacking(measure)] == []
    absent = {measure for measure in scenario.measures if measure not in found}
    assert {measure for measure in absent if not scenario.lacking(measure)} <= BY_ITS_WAY


def test_the_key_that_provides_it_is_named(examples):
    """Row 11: the check was silent, and after 34 CPU s the run failed."""
    change = ["requirements.wall_error_max.max=60 um", "requirements.removed_volume.min=1 mm^3"]
    with pytest.raises(ScenarioFault) as caught:
        load(examples / "mill_pocket.yaml", change)
    said = str(caught.value)
    assert "wall_error_max: a run of this scenario has no such measure; it needs tool.modes (" in said
    assert "removed_volume: a run of this scenario has no such measure; it needs stock (" in said
    assert "2 faults" in said
    with pytest.raises(ScenarioFault, match=r"it needs part.step .* or part.block"):
        load(examples / "chamfer_pipe_hole.yaml", ["requirements.edges_refused.max=0"])
    with pytest.raises(ScenarioFault, match=r"it needs numerics.force: tooth_resolved\n"):
        load(examples / "mill_pocket.yaml", ["numerics.force=averaged", "requirements={force_xy_peak: {max: 1 kN}}"])


@pytest.mark.parametrize(
    ("name", "faulty"),
    [
        ("chamfer_compliant_spindle", {"spindle.mass": "1.1 kg"}),
        ("mill_on_robot", {"robot.dynamics": "links"}),
        ("deburr_on_robot", {"robot.sag": "much", "requirements.share_arm": "{max: 1 mm}"}),
    ],
)
def test_a_section_with_a_fault_of_its_own_is_not_called_missing(examples, name, faulty):
    with pytest.raises(ScenarioFault) as told:
        load(examples / f"{name}.yaml", faulty)
    assert not any("no such measure" in str(fault) for fault in told.value.faults)
