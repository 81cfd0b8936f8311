"""Milling runs that are out of the ordinary: blends, chatter, feeds beyond the machine, paths in short blocks."""

import math

import pytest

from cutwise.io.scenario import parse
from cutwise.process import milling_compare
from cutwise.process.assemble_mill import feed_drives
from cutwise.process.recipes import quick_measures, simulate
from cutwise.spec.faults import ScenarioFault

BASE = """\
process: mill
path: {corner: sharp, lead: 15 mm}
operation: {feed: 40 mm/s, spindle_speed: 8000 rpm, axial_depth: 5 mm, radial_depth: 4 mm}
tool: {diameter: 20 mm, flutes: 3, helix: 30 deg}
material: {library: al7075t6}
machine: {library: fadal2216}
numerics: {settling_time: 0.3 s}
"""
PROGRAM = """\
process: mill
program: {file: part.nc, text: "G21 G90 G17 S8000 M3\\nF2400\\nG0 X0 Y0 Z5\\nG0 Z-1\\nMOVES\\nM2\\n"}
operation: {axial_depth: 5 mm, radial_depth: 4 mm}
tool: {diameter: 20 mm, flutes: 3, helix: 30 deg}
material: {library: al7075t6}
machine: {library: fadal2216, reading: kp_ki_swapped}
numerics: {settling_time: 0.1 s, force: none}
"""
SOFT = "tool.modes=[{direction: x, frequency: 922 Hz, damping: 0.011, stiffness: 1.34 N/um}]"


def run(*changes, text=BASE):
    return simulate(parse(text, overrides=changes))


def program(moves):
    return PROGRAM.replace("MOVES", "\\n".join(moves))


def test_an_arc_blend_is_the_fillet_of_its_radius():
    """Within tolerance e an arc blend of a right angle has the radius e / (sqrt(2) - 1); the load is that of the fillet."""
    tolerance = 2.0 * (math.sqrt(2.0) - 1.0)
    text = f"path.compare=[2 mm, {{blend: {tolerance:.12g} mm}}, {{blend: {tolerance:.12g} mm, shape: clothoid}}]"
    fillet, blend, clothoid = milling_compare.compare(parse(BASE, overrides=[text])).values()
    told = {**fillet, "drive_error_max": fillet["contour_error_max"]}
    for name in (
        "cycle_time",
        "engagement_angle_max",
        "force_xy_mean_corner",
        "force_xy_peak_corner",
        "drive_error_max",
    ):
        assert blend[name] == pytest.approx(told[name], rel=1e-6), name
    assert blend["contour_error_max"] > 0.5e-3
    assert clothoid["engagement_angle_max"] < fillet["engagement_angle_max"]


@pytest.mark.parametrize("count", [3, 3000])
def test_a_line_in_short_blocks_has_no_contour_error(count):
    moves = [f"G1 X{30.0 * (i + 1) / count:.4f}" for i in range(count)]
    found = quick_measures(parse(program(moves), overrides=["operation.feed=80 mm/s"]))
    assert found["tracking_error_max_x"] > 40e-6
    assert found["contour_error_max"] < 1e-12


def test_stops_at_many_corners_are_told():
    moves = [f"G1 X{math.sin(0.05 * i):.6f} Y{1.0 - math.cos(0.05 * i):.6f}" for i in range(1, 40)]
    assert any("path_mode" in said for said in run(text=program(moves)).warnings)
    blended = run("path_mode={blend: 0.01 mm}", text=program(moves))
    assert not any("full stops" in said for said in blended.warnings)


def test_a_blend_longer_than_its_blocks_is_told():
    result = run("path_mode={blend: 50 mm}", "numerics.force=none")
    assert "half of a block" in result.notes["blends"]


def test_nothing_is_told_of_a_tip_that_has_left_its_contact():
    result = run(SOFT)
    lost = next(finding for finding in result.unsound if finding.code == "tip_lost")
    assert lost.limit == 4e-3
    assert not any(finding.code in ("moves", "unconverged") for finding in result.findings)
    assert {"cycle_time", "force_xy_mean_corner", "chatter_growth_straight"} <= set(result.measures)
    assert not {"contour_error_max", "force_xy_peak", "tip_deflection_max", "drive_voltage_max"} & set(result.measures)
    assert all(math.isfinite(measure.value) for measure in result.measures.values())


def test_a_radial_depth_beside_a_stock_does_not_count():
    """It is told so; nor does it end a run whose tip swings further than it."""
    moves = ["G1 X-40 Y0", "G1 X-25 Y0"]
    block = ["stock={x: [-60 mm, 60 mm], y: [-30 mm, 30 mm], z: [-20 mm, 0 mm]}", "numerics.force=tooth_resolved",
             SOFT.replace("1.34 N/um", "50 N/um"), "operation.axial_depth=null"]  # fmt: skip
    without = run(*block, "operation.radial_depth=null", text=program(moves))
    beside = run(*block, "operation.radial_depth=0.1 um", text=program(moves))
    assert without.measures["tip_deflection_max"].value > 1e-7
    assert beside.measures["tip_deflection_max"].value == without.measures["tip_deflection_max"].value


def test_a_tip_without_stiffness_has_a_finite_growth():
    growth = run(SOFT.replace("1.34 N/um", "0.001 N/um")).measures["chatter_growth_straight"].value
    assert 1e3 < growth < math.inf


def test_a_feed_beyond_the_machine_is_run_at_its_limit_and_told():
    result = run("operation.feed=300 mm/s")
    at_limit = run("operation.feed=169.333 mm/s")
    for name in ("cycle_time", "force_xy_mean_straight", "force_xy_peak_corner", "force_xy_peak"):
        assert result.measures[name].value == pytest.approx(at_limit.measures[name].value, rel=1e-12), name
    assert any("above machine.limits.velocity" in said for said in result.warnings)


def test_axes_that_may_be_quicker_together():
    """At 45° two axes of 100 mm/s make 141 mm/s along the path; z goes up 5 mm and down 6 mm before."""
    changes = ["machine.limits.act_on=axes", "machine.limits.velocity=100 mm/s", "operation.feed=200 mm/s"]
    moves = ["G1 X30 Y30"]
    found = quick_measures(parse(program(moves), overrides=changes))
    assert found["cycle_time_ideal"] == pytest.approx(0.3 + 0.05 + 0.06, rel=1e-9)


def test_averaged_force_has_no_peak():
    result = run("numerics.force=averaged", "tool.runout=5 um")
    assert "force_xy_peak" not in result.measures
    assert result.measures["force_xy_mean_corner"].value > 400.0


def test_an_axis_that_never_settles_is_told():
    result = run("machine.control.encoder=20 um")
    assert "settling_time" not in result.measures
    assert any("there is no settling_time" in said for said in result.warnings)


@pytest.mark.parametrize("change", [
    "operation.feed=1e-6 mm/s", "machine.control.sample_time=1 ns", "path.lead=1e6 m",
])  # fmt: skip
def test_more_samples_than_a_machine_holds(change):
    with pytest.raises(ScenarioFault, match="samples of the"):
        run(change)


def test_a_reading_belongs_to_a_table_in_doubt():
    with pytest.raises(ScenarioFault, match="gains, but those of this machine are not in doubt: as_printed"):
        parse(BASE, overrides=["machine.library=cjme2023", "machine.reading=kp_ki_swapped"])


@pytest.mark.parametrize(("changes", "remedy", "mended"), [
    (["machine.x.K_i=0 V/(mm s)"], "machine.x.K_d times 10", ["machine.x.K_d=3 V s/mm"]),
    (["machine.reading=matched", "machine.control.sample_time=8 ms"], "machine.x.K_i times 0.05",
     ["machine.x.K_i=3.5 V/(mm s)", "machine.y.K_i=6.4 V/(mm s)"]),
])  # fmt: skip
def test_remedies_of_an_unstable_loop_help(changes, remedy, mended):
    with pytest.raises(ScenarioFault) as found:
        feed_drives(parse(BASE, overrides=changes).machine)
    assert remedy in str(found.value)
    feed_drives(parse(BASE, overrides=[*changes, *mended]).machine)
