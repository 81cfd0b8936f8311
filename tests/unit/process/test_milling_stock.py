"""A program milled out of a block: volume, first slot, rapid moves through the stock, plunges; and faults."""

import math

import numpy as np
import pytest

from cutwise.io.scenario import load
from cutwise.process.recipes import quick_measures, simulate
from cutwise.spec.faults import ScenarioFault

HEAD = """
process: mill
program: part.nc
stock: {x: [0 mm, 60 mm], y: [-20 mm, 20 mm], z: [-10 mm, 0 mm]}
operation: {spindle_speed: 8000 rpm}
tool: {diameter: 10 mm, flutes: 2, helix: 30 deg}
material: {library: al7075t6}
machine: {library: fadal2216, reading: kp_ki_swapped}
numerics: {force: tooth_resolved, settling_time: 0.1 s}
"""
SLOT = "G21 G90 S8000 M3\nG0 X-10 Y0 Z5\nZ-3\nG1 X70 F1200\nG0 Z5\nM30\n"
STEP = "G21 G90 S8000 M3\nG0 X-10 Y0 Z5\nZ-3\nG1 X70 F1200\nY-2\nX-10\nG0 Z5\nM30\n"


def scenario(folder, text, *changes):
    (folder / "part.nc").write_text(text)
    (folder / "part.yaml").write_text(HEAD)
    return load(folder / "part.yaml", changes)


def value(result, name):
    return result.measures[name].value


def test_a_slot_through_the_block(tmp_path):
    result = simulate(scenario(tmp_path, SLOT))
    assert value(result, "engagement_angle_max") == pytest.approx(math.pi)
    assert value(result, "removed_volume") == pytest.approx(60e-3 * 10e-3 * 3e-3, rel=2e-3)
    assert value(result, "removal_rate_max") == pytest.approx(10e-3 * 3e-3 * 20e-3, rel=1e-9)
    immersion = result["engagement"]["immersion"].values
    x = result["motion"]["commanded"].values[:, 0]
    assert not immersion[x < -5.1e-3].any()
    assert immersion[(x > 0.0) & (x < 54e-3)] == pytest.approx(math.pi)
    assert not result["cutting"]["force_xy_peak"].values[x < -5.1e-3].any()
    assert not any("rapid" in warning for warning in result.warnings)


def test_the_way_back_climbs_along_the_wall_it_has_on_its_right(tmp_path):
    """After the slot at y = 0, back at y = -2 with the wall on the left: the cut is 2 mm wide, on the far side."""
    result = simulate(scenario(tmp_path, STEP))
    found = result.stages["engagement"]["immersion"].values
    heading = result["motion"]["commanded"].values
    back = (np.gradient(heading[:, 0]) < -1e-9) & (heading[:, 0] > 10e-3) & (heading[:, 0] < 50e-3)
    assert found[back] == pytest.approx(math.acos(1.0 - 2.0 / 5.0), abs=1e-9)


@pytest.mark.parametrize("mode", ["G61", "G64 P0.001", "G64 P0.05", "G64"])
def test_a_tool_that_leaves_the_cut_upwards_runs_through_nothing(tmp_path, mode):
    """However the corner of the retract is rounded; a rapid move on through the stock stays one."""
    text = f"G21 G90 {mode} S8000 M3\nG0 X-10 Y0 Z5\nZ-3\nG1 X30 F1200\nG0 {{}}\nZ5\nM30\n"
    assert not simulate(scenario(tmp_path, text.format("Z5"))).unsound
    assert "collides" in {f.code for f in simulate(scenario(tmp_path, text.format("X40 Y8"))).unsound}


def test_rapid_moves_through_the_stock_and_plunges_are_named(tmp_path):
    text = "G21 G90 S8000 M3\nG0 X10 Y0 Z5\nG1 Z-3 F200\nX30 F1200\nG0 X50\nZ5\nM30\n"
    result = simulate(scenario(tmp_path, text))
    assert any("rapid moves run through the stock: line 5" in warning for warning in result.warnings)
    assert any("plunges" in warning and "line 3" in warning for warning in result.warnings)
    assert value(result, "removed_volume") < 20e-3 * 10e-3 * 3e-3 * 1.01  # rapid moves take nothing


def test_same_as_the_corner_in_closed_form(tmp_path):
    """Two nested passes through a right angle: the second meets what the closed form of a corner says."""
    text = "G21 G90 S8000 M3\nG0 X-64 Y4 Z5\nZ-5\nG1 X-4 F2400\nY64\nG0 Z5\nX-60 Y0\nZ-5\nG1 X0 F2400\nY60\nM30\n"
    endless = "stock={x: [-200 mm, 200 mm], y: [-200 mm, 200 mm], z: [-20 mm, 0 mm]}"
    program = scenario(
        tmp_path, text, endless, "tool={diameter: 20 mm, flutes: 3, helix: 30 deg}", "path_mode=exact_stop"
    )
    result = simulate(program)
    path, angle = result["motion"]["commanded"].values, result["engagement"]["immersion"].values
    second = result["motion"]["travelled"].values > 0.22
    on_wall = second & (np.abs(path[:, 1]) < 1e-9) & (path[:, 0] > -40e-3) & (path[:, 0] < -25e-3)
    assert angle[on_wall] == pytest.approx(math.acos(1 - 0.4), abs=1e-9)
    at_corner = second & (np.hypot(path[:, 0], path[:, 1]) < 20e-6)
    assert angle[at_corner].max() == pytest.approx(math.pi / 2 + math.acos(0.6), abs=2e-3)


def refused(folder, text, head):
    (folder / "part.nc").write_text(text)
    (folder / "part.yaml").write_text(head)
    with pytest.raises(ScenarioFault) as caught:
        load(folder / "part.yaml")
    return str(caught.value)


def test_faults(tmp_path):
    backwards = HEAD.replace("x: [0 mm, 60 mm]", "x: [60 mm, 0 mm]")
    assert "stock.x: ends before it begins" in refused(tmp_path, SLOT, backwards)
    bare = "\n".join(line for line in HEAD.splitlines() if not line.startswith("stock"))
    assert "operation.axial_depth: missing" in refused(tmp_path, SLOT, bare)
    corner = HEAD.replace("program: part.nc", "path: {corner: 2 mm}").replace("8000 rpm}", "8000 rpm, feed: 40 mm/s}")
    assert "stock: is cut by a program" in refused(tmp_path, SLOT, corner)


def test_the_example_agrees_with_its_lobes(examples):
    """At 9700 rpm the tip stays in hand, at the program's 8000 rpm the first slot chatters: in the loop as in the map."""
    calm = load(examples / "mill_pocket_stock.yaml", ["requirements={stable_depth_corner: {min: 5 mm}}"])
    wild = load(examples / "mill_pocket_stock.yaml", ["operation.spindle_speed=8000 rpm"])
    found = quick_measures(calm)
    assert found["stable_depth_corner"] > 5e-3
    assert found["removed_volume"] == pytest.approx((6000 - (4 - math.pi) * 225 - math.pi * 100) * 5e-9, rel=2e-3)
    assert quick_measures(wild)["tip_deflection_max"] > 2.5 * found["tip_deflection_max"]


def test_a_ramp_is_told_and_a_level_slot_is_not(tmp_path):
    """Exact arcs leave out what the end of the mill takes."""
    ramp = "G21 G90 S8000 M3\nG0 X-10 Y0 Z5\nZ-1\nG1 X30 F1200\nX50 Z-3\nG0 Z5\nM30\n"
    for text, told in ((ramp, True), (SLOT, False)):
        said = simulate(scenario(tmp_path, text, "numerics.force=averaged", "numerics.settling_time=0.02 s")).warnings
        assert any("ramps into the stock" in words and "line 5" in words for words in said) == told
