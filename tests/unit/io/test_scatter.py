"""Covariances on their way from an entry into a scenario: units, what is replaced, what is in lists of several dimensions."""

import numpy as np
import pytest

from cutwise.io.scenario import load
from cutwise.spec import fields
from cutwise.spec.drilling import DrillingScenario
from cutwise.spec.faults import ScenarioFault, split_dotted

ENTRY = """
name: mine
describes: for a test
values:
  joint_stiffness:
    value: [1e6 N m/rad, 2e6 N m/rad, 2e6 N m/rad, 3e5 N m/rad, 4e5 N m/rad, 2e5 N m/rad]
    status: measured
    source: loads.csv
  base_compliance: {value: [0.1 um/N, 0.2 um/N, 0.3 um/N], status: measured, source: loads.csv}
  errors:
    value: {bodies: [[0.1 mm, 0 m, 0 m, 1 mrad, 0 rad, 0 rad], [0 m, 0 m, 0 m, 0 rad, 0 rad, 0 rad],
      [0 m, 0 m, 0 m, 0 rad, 0 rad, 0 rad], [0 m, 0 m, 0 m, 0 rad, 0 rad, 0 rad], [0 m, 0 m, 0 m, 0 rad, 0 rad, 0 rad],
      [0 m, 0 m, 0 m, 0 rad, 0 rad, 0 rad]]}
    status: measured
    source: poses.csv
covariances:
  springs:
    of: ['joint_stiffness[0]', 'base_compliance[1]']
    as: [reciprocal, value]
    degrees_of_freedom: 40
    matrix: [[4e-2, 1e-3], [1e-3, 1e-4]]
    unit: [urad/(N m), um/N]
  twist: {of: ['errors.bodies[0][0]', 'errors.bodies[0][3]'], matrix: [[4, 0.5], [0.5, 1]], unit: [um, urad]}
measured: {kind: robot-stiffness, residual: 0.2 mm, range: {joint1: [-1 rad, 1 rad], joint2: odd}}
"""


@pytest.fixture
def loaded(examples, tmp_path):
    file = tmp_path / "mine.yaml"

    def make(text=ENTRY, **more):
        file.write_text(text)
        given = {
            "robot.library": str(file), "robot.joints": JOINTS, "robot.modal_mass": "150 kg", "robot.damping": 0.05,
            "robot.tool_position": "[0.2 m, 0 m, -0.3 m]",
            "robot.tool_rotation": "[180 deg, 0 deg, 0 deg]", "requirements": "{}", **more,
        }  # fmt: skip
        return load(examples / "drill_robot.yaml", given)

    return make


JOINTS = [
    {"origin": origin, "axis": axis, "limits": ["-170 deg", "170 deg"]}
    for origin, axis in (
        (["0 m", "0 m", "0.7 m"], [0, 0, 1]), (["0.3 m", "0 m", "0 m"], [0, 1, 0]), (["0 m", "0 m", "1 m"], [0, 1, 0]),
        (["1 m", "0 m", "0 m"], [1, 0, 0]), (["0.3 m", "0 m", "0 m"], [0, 1, 0]), (["0.2 m", "0 m", "0 m"], [1, 0, 0]),
    )
]  # fmt: skip


def test_units_and_kinds_come_to_si(loaded):
    scenario = loaded()
    springs, twist = scenario.covariances["robot_springs"], scenario.covariances["robot_twist"]
    assert springs.of == ("robot.joint_stiffness[0]", "robot.base_compliance[1]")
    assert springs.kinds == ("reciprocal", "value")
    assert springs.degrees_of_freedom == 40
    assert np.array(springs.matrix) == pytest.approx(np.array([[4e-14, 1e-15], [1e-15, 1e-16]]))
    assert np.array(twist.matrix) == pytest.approx(np.array([[4e-12, 0.5e-12], [0.5e-12, 1e-12]]))
    assert scenario.measured["robot"].residual == "0.2 mm"
    assert scenario.measured["robot"].range == {"joint1": ("-1 rad", "1 rad")}


def test_what_the_scenario_writes_itself_leaves_the_covariance(loaded):
    scenario = loaded(**{"robot.base_compliance": "[0.1 um/N, 0.1 um/N, 0.1 um/N]"})
    assert scenario.covariances["robot_springs"].of == ("robot.joint_stiffness[0]",)
    own = loaded(**{"robot.joint_stiffness": [f"{k} N m/rad" for k in (1e6, 2e6, 2e6, 3e5, 4e5, 2e5)]})
    assert own.covariances["robot_springs"].of == ("robot.base_compliance[1]",)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("unit: [urad/(N m), um/N]", "unit: [urad, um/N]", '"urad" is not a unit of 1/angular stiffness'),
        ("unit: [urad/(N m), um/N]", "unit: [urad/(N m)]", "one for each of the 2 values"),
        ("unit: [um, urad]", "unit: [um, um]", '"um" is not'),
        ("as: [reciprocal, value]", "as: [reciprocal, inverse]", '"inverse" is not one of value, reciprocal, log'),
        ("source: loads.csv}", "source: loads.csv, standard_error: [1 um/N, 1 um/N]}", "is a unit wrong"),
        ("source: loads.csv}", "source: loads.csv, standard_error: {x: 1 um/N}}", "has not the form of its value"),
    ],
)
def test_what_can_be_wrong(loaded, old, new, said):
    assert old in ENTRY
    with pytest.raises(ScenarioFault) as caught:
        loaded(ENTRY.replace(old, new))
    assert said in str(caught.value)


def test_dimensions_inside_of_lists():
    for key, dimension in (
        ("robot.errors.bodies[0][2]", "length"), ("robot.errors.bodies[0][3]", "angle"), ("robot.base_compliance[1]", "compliance"),
        ("robot.base_compliance[4]", "angular_compliance"), ("robot.joint_stiffness[2]", "angular_stiffness"),
        ("operation.feed_per_rev", "feed_per_revolution"), ("robot.errors", None),
    ):  # fmt: skip
        assert fields.dimension_at(DrillingScenario, split_dotted(key)) == dimension, key
