"""The chamfer recipe from scenario to result and program."""

import re
from pathlib import Path

import numpy as np
import pytest

import cutwise
from cutwise.io.programs import post
from cutwise.maths.edges import lengths
from cutwise.paths.pipe import PipeHole, pipe_edge
from cutwise.physics.surface.sweep import swept_chamfer
from cutwise.process.chamfer_program import program_of

EXAMPLE = Path(__file__).parents[2] / "examples" / "chamfer_pipe_hole.yaml"
COARSE = ("path.points=360",)


def run(*overrides):
    return cutwise.simulate(cutwise.load(EXAMPLE, (*COARSE, *overrides)))


@pytest.mark.parametrize(
    ("overrides", "code"),
    [
        (("chamfer.width=0.5 mm", "chamfer.tilt=0 deg"), "rod_clears_wall"),
        (("tool.knife_limit_angle=45 deg", "chamfer.tilt=0 deg"), "knife_covers_contact"),
        (("tool.ball_radius=4.2 mm", "tool.rod_radius=2 mm"), "ball_enters_hole"),
        (("part.edges=outer", "chamfer.tier=surface", "tool.ball_radius=6 mm", "tool.rod_radius=2 mm"), "no_gouge"),
        (("part.pipe.eccentricity=10 mm",), "no_edge"),
    ],
)
def test_infeasible_for_the_right_reason(overrides, code):
    result = run(*overrides)
    assert result.verdict == "fail"
    assert any(line.startswith(code) for line in result.infeasible)
    assert result.advice
    assert result.notes["remedies"].startswith("1. ")


def test_tilt_cures_what_it_can():
    result = run("tool.knife_limit_angle=45 deg")
    assert not result.infeasible
    assert np.degrees(result.measures["tilt"].value) == pytest.approx(4.301222, abs=1e-5)
    assert result.verdict == "pass"


def test_gcode_read_back_leaves_the_width():
    """Parsed from its text alone, the program sweeps the chamfer that was wanted, within rounding and chords."""
    program = program_of(run())
    text = post.gcode(program, decimals=5)
    tips = np.array([[float(v) for v in re.findall(r"[XYZ](-?[\d.]+)", line)]
                     for line in text.splitlines() if line.startswith("G1")])  # fmt: skip
    centre = tips * 1e-3 + np.array([0.0, 0.0, 2e-3])
    at = pipe_edge(PipeHole(0.015, 0.002, 0.004), 2 * np.pi * (np.arange(40) + 0.37) / 40, inner=True)
    width = swept_chamfer(at, centre, 0.002, 0.5e-3, closed=False).width
    assert width == pytest.approx(0.3e-3, abs=0.4e-6)
    feeds = [float(f) for f in re.findall(r"F([\d.]+)", text)]
    assert 109 < min(feeds) < max(feeds) < 140
    assert tips[:, 2].max() < 14.0 < float(re.findall(r"G0 .* Z([\d.]+)", text)[0])


def test_poses_are_rotations_against_the_tool():
    program = program_of(run())
    frames = post.pose_frames(program)
    np.testing.assert_allclose(np.linalg.det(frames), 1.0, atol=1e-12)
    np.testing.assert_allclose(frames[:, :, 2], -program.axis, atol=1e-12)
    assert post.poses_csv(program).count("\n") == len(program.position) + 1
    assert post.apt(program).count("GOTO/") == len(program.position)


def test_a_spindle_that_is_not_pushed_past_breakaway_does_not_move():
    spindle = ("operation.contact_feed=20 mm/s", "spindle.library=berselli2016", "spindle.pressure=5 bar")
    result = run(*spindle)
    assert result.measures["tip_deflection_max"].value < 1e-9
    for end in ("min", "max"):
        rigid, yielding = (result.measures[f"width{k}_{end}"].value for k in ("", "_deflected"))
        assert yielding == pytest.approx(rigid, abs=1e-12)
    path = result["motion"].dataset["centre"].values
    assert lengths(path, closed=True).sum() == pytest.approx(result.measures["path_length"].value)


def test_at_two_bar_a_wide_chamfer_moves_the_spindle():
    """Force above the 6.35 N breakaway: the tip gives way, and the chamfer is narrower than the rigid tool's."""
    compliant = EXAMPLE.with_name("chamfer_compliant_spindle.yaml")
    result = cutwise.simulate(cutwise.load(compliant, ("operation.preset=0 mm", "operation.part_error=0 mm")))
    assert result.measures["breakaway_force"].value == pytest.approx(6.35, abs=0.01)
    assert result.measures["lateral_force_max"].value > result.measures["breakaway_force"].value
    assert result.measures["tip_deflection_max"].value > 0.3e-3
    assert result.measures["width_deflected_min"].value < 0.8e-3
