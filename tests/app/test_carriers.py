"""Whatever is carried, a run tells the same of what carries it: postures or bodies station by station, and whose fault it is."""

import numpy as np
import pytest

from cutwise.io.scenario import load
from cutwise.process.recipes import simulate

LINE = ("path.line.from=[1900 mm, -10 mm, 800 mm]", "path.line.to=[1900 mm, 10 mm, 800 mm]", "requirements={}")
RIGID = ("spindle=rigid", "operation.preset=0.05 mm")
ON_ARM = {
    "deburr, stepped": ("deburr_on_robot", *LINE, "operation.lead_in_time=0.05 s", "robot.redundancy_angle=best_constant"),
    "deburr, at rest": (
        "deburr_on_robot", *LINE, *RIGID, "numerics={mode: still}", "robot.redundancy_angle=best_constant"
    ),
    "mill, at rest": ("mill_on_robot", *LINE, "robot.redundancy_angle=best_constant"),
    "chamfer": ("chamfer_on_robot", "path.points=48", "requirements={}", "robot.redundancy_angle=best_constant"),
}  # fmt: skip
ON_TABLE = {
    "deburr, stepped": ("deburr_rigid_on_machine", "path.line.from=[-10 mm, -40 mm, 295 mm]", "requirements={}",
                        "path.line.to=[10 mm, -40 mm, 295 mm]", "operation.lead_in_time=0.05 s", "numerics={}"),
    "deburr, at rest": ("deburr_rigid_on_machine", "requirements={}"),
    "mill, drives": ("mill_on_machine", "path.line.length=8 mm", "path.cut_from=2 mm", "requirements={}",
                     "numerics.settling_time=0.05 s", "numerics.substeps=4"),
    "mill, at rest": ("mill_on_machine", "path.line.length=8 mm", "path.cut_from=2 mm", "requirements={}", "tool.modes=[]",
                      "machine={library: demec_mill}", "numerics={mode: still}"),
}  # fmt: skip


@pytest.mark.parametrize("case", ON_ARM)
def test_postures_and_what_turning_the_tool_would_bring(case, examples):
    name, *overrides = ON_ARM[case]
    result = simulate(load(examples / f"{name}.yaml", [text for text in overrides if "joint_angles" not in text]
                           + ["robot.joint_angles=null"]))  # fmt: skip
    carrier = result["carrier"]
    assert carrier["joint_angles"].shape[1] == 6
    assert (carrier["compliance_off_work"].values > 0.0).all()
    if case != "chamfer":  # whose surface leans
        softest = float(carrier["compliance_off_work"].max())
        assert 1.0 / softest == pytest.approx(result.measures["stiffness_normal_min"].value)
    assert "redundancy" not in result.notes or case == "chamfer"  # on so short a line turning the tool brings nothing


@pytest.mark.parametrize("overrides", [RIGID, (*RIGID, "numerics={mode: still}")], ids=["stepped", "at rest"])
def test_a_long_edge_says_what_turning_the_tool_would_bring(overrides, examples):
    long = ("robot.redundancy_angle=best_constant", "robot.joint_angles=null", "numerics.station=50 mm")
    scenario = load(examples / "deburr_on_robot.yaml", [*overrides, *long, "requirements={}"])
    assert "along_path the arm would yield" in simulate(scenario).notes["redundancy"]


@pytest.mark.parametrize("case", ON_TABLE)
def test_bodies_one_by_one_add_up_to_the_term(case, examples):
    name, *overrides = ON_TABLE[case]
    result = simulate(load(examples / f"{name}.yaml", overrides))
    carrier, structure = result["carrier"], result["structure"]
    assert result.notes["bodies"].startswith("Of the bodies there: ")
    total = carrier["deflection"].values.sum(axis=1)
    off = structure["deflection_bodies"].values[:, 1]
    assert total.max() <= off.max() * (1 + 1e-9) + 1e-15
    assert np.ptp(carrier["s_station"].values) > 0.0
    assert abs(off).max() > 1e-9
