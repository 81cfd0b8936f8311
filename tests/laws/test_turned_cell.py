"""A cell turned as a whole: a robot does not care which way its part looks."""

import pytest

from cutwise.io.scenario import load
from cutwise.process.recipes import quick_outcome

CASES = {
    "mill_on_robot": (),
    "deburr_on_robot": ("spindle=rigid", "operation.preset=0.05 mm", "numerics={mode: still}"),
}
OWN = {
    "joint_limit_margin",
    "redundancy_angle_min",
    "redundancy_angle_max",
    "energy_balance",
}  # the last: rounding alone


@pytest.mark.parametrize("name", CASES)
def test_a_cell_turned_about_the_base_of_its_robot_has_the_same_measures(name, examples):
    """Path, first axis and the reference of the angle turned by 90 degrees; only the room of the joints may differ."""

    def at(start, end, first, angle):
        joints = f"robot.joint_angles=[{first}, -82 deg, 117 deg, 10 deg, -35 deg, -8 deg]"
        line = (f"path.line.from=[{start}, 800 mm]", f"path.line.to=[{end}, 800 mm]")
        more = (*CASES[name], *line, joints, f"robot.redundancy_angle={angle}", "robot.sag=relative", "requirements={}")
        return quick_outcome(load(examples / f"{name}.yaml", list(more))).measures

    here = at("1900 mm, -150 mm", "1900 mm, 150 mm", "6 deg", "0 deg")
    there = at("150 mm, 1900 mm", "-150 mm, 1900 mm", "-84 deg", "-90 deg")
    told = here.keys() - OWN
    assert len(told) > 15
    assert {key: there[key] for key in told} == pytest.approx({key: here[key] for key in told}, rel=1e-9, abs=1e-15)
