"""Preset and part error move the ball, whatever holds the tool."""

import math

import numpy as np
import pytest

from cutwise.io.scenario import load, read_document
from cutwise.process.recipes import quick_measures, simulate
from cutwise.results import SOUNDNESS

_RADIUS, _WIDTH = 2e-3, 0.3e-3
_BLOCK = {
    "process": "chamfer",
    "part": {"block": {"length": "20 mm", "width": "15 mm", "height": "10 mm"}, "edges": "facing:+z & facing:+x"},
    "chamfer": {"width": "0.3 mm"},
    "tool": {"ball_radius": "2 mm", "rod_radius": "1 mm", "knife_limit_angle": "31 deg", "axis": "+z"},
    "operation": {"contact_feed": "200 mm/min"},
    "path": {"chord_tolerance": "5 um"},
}


def _chord(approach):
    """Chamfer of a ball on a straight edge of 90°, planned for equal legs and led into the work across the rod [m]."""
    leg = _WIDTH / math.sqrt(2.0)
    out = 0.5 * (-leg + math.sqrt(2.0 * _RADIUS**2 - leg**2))  # (out + leg)^2 + out^2 = R^2
    nearer = out - approach
    top, side = math.sqrt(_RADIUS**2 - out**2) - nearer, math.sqrt(_RADIUS**2 - nearer**2) - out
    return math.hypot(top, side)


@pytest.mark.parametrize("said", [{"preset": "0.05 mm"}, {"part_error": "0.05 mm"}, {"part_error": "-0.05 mm"}])
def test_a_rigid_tool_leaves_what_geometry_says(said):
    pytest.importorskip("OCP")
    found = quick_measures(read_document({**_BLOCK, "operation": {**_BLOCK["operation"], **said}}))
    approach = -0.05e-3 if "-" in next(iter(said.values())) else 0.05e-3
    assert found["width_min"] == pytest.approx(_chord(approach), rel=2e-3)
    assert found["width_max"] == pytest.approx(_chord(approach), rel=2e-3)


def test_a_spindle_that_does_not_move_is_a_rigid_tool(examples):
    scenario = load(examples / "chamfer_compliant_spindle.yaml", ["path.points=48", "spindle.pressure=20 bar"])
    found = quick_measures(scenario)
    assert found["tip_deflection_max"] < 1e-12
    for end in ("min", "max"):
        assert found[f"width_{end}"] == pytest.approx(found[f"width_deflected_{end}"], rel=1e-6)
    assert found["width_max"] > 1.1e-3  # planned 0.9 mm: preset and part error are in it


def test_preset_and_part_error_count_alike_in_the_part_and_preset_alone_in_the_program(examples):
    path, short = examples / "chamfer_pipe_hole.yaml", ("path.points=48", "setup=null")
    plain = simulate(load(path, short))
    deeper, nearer = (simulate(load(path, (*short, f"operation.{key}=20 um"))) for key in ("preset", "part_error"))
    assert deeper.measures["width_max"].value == nearer.measures["width_max"].value
    assert deeper.measures["width_max"].value > plain.measures["width_max"].value + 20e-6
    assert deeper.measures["lateral_force_max"].value > 1.05 * plain.measures["lateral_force_max"].value
    moved = deeper["program"]["position"].values - plain["program"]["position"].values
    assert np.abs(moved).max() == pytest.approx(20e-6, rel=0.01)
    assert np.array_equal(nearer["program"]["position"].values, plain["program"]["position"].values)


def test_a_rod_that_the_part_error_takes_into_the_wall_does_not_pass(examples):
    short = ("path.points=48", "setup=null", "operation.part_error=0.1 mm", "requirements={cycle_time: {max: 1 h}}")
    result = simulate(load(examples / "chamfer_pipe_hole.yaml", short))
    assert result.measures["rod_clearance_min"].value == pytest.approx(-46e-6, abs=1e-6)
    assert "rubs" in [finding.code for finding in result.findings if finding.code in SOUNDNESS]
    assert result.verdict == "fail"
    assert any("beside the chamfer" in text for text in result.warnings)
