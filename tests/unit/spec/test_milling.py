"""Milling scenarios: what is refused, in which words, and what the library entries say."""

import math

import pytest

from cutwise.io.scenario import load, parse, read_document
from cutwise.process.assemble_mill import feed_drives, read_program
from cutwise.process.recipes import simulate
from cutwise.spec.faults import ScenarioFault

BASE = """\
process: mill
path: {corner: 2 mm}
operation: {feed: 40 mm/s, spindle_speed: 8000 rpm, axial_depth: 5 mm, radial_depth: 4 mm}
tool: {diameter: 20 mm, flutes: 3, helix: 30 deg}
material: {library: al7075t6}
machine: {library: fadal2216}
"""


def refused(*changes, text=BASE):
    with pytest.raises(ScenarioFault) as found:
        simulate(parse(text, overrides=changes))
    return str(found.value)


@pytest.mark.parametrize("limit", ["velocity=0 mm/s", "acceleration=0 mm/s^2", "jerk=0 mm/s^3"])
def test_limits_of_zero(limit):
    assert "must be above 0" in refused(f"machine.limits.{limit}")


def test_unstable_gains_with_their_margin():
    said = refused("machine.reading=as_printed", "machine.control.delay=1")
    assert "position loop of x is unstable" in said
    assert "|z| = 1.16" in said
    assert "gain margin" in said
    assert "phase margin -34.3°" in said


def test_depth_larger_than_the_mill():
    assert "is more than the diameter of the mill (20 mm)" in refused("operation.radial_depth=20.1 mm")
    assert "flute length" in refused("tool.flute_length=4 mm")


def test_a_fault_of_one_section_hides_none_of_the_others():
    said = refused("machine.limits.jerk=3 N", "operation.radial_depth=21 mm")
    assert "is more than the diameter of the mill (20 mm)" in said
    assert '"N" is not a unit of jerk' in said


def test_feed_missing():
    assert "operation.feed: missing" in refused(text=BASE.replace("feed: 40 mm/s, ", ""))


def test_path_or_program():
    assert "exactly one of path" in refused(text=BASE.replace("path: {corner: 2 mm}\n", ""))
    assert "whole lead" in refused("path.corner=30 mm")


def test_kienzle_without_an_axial_pair_has_no_axial_force():
    result = simulate(parse(BASE, overrides=["material={library: kienzle_1045}", "path.lead=5 mm"]))
    assert result.measures["force_xy_peak"].value > 500.0
    assert ("force_z_peak" in result.measures) == (result.scenario.material.k_a11 is not None)


def test_run_out_raises_the_peak_and_keeps_the_mean():
    plain, off = (simulate(parse(BASE, overrides=["path.lead=5 mm", f"tool.runout={r} um"])) for r in (0, 20))
    peaks = [r.measures["force_xy_peak"].value for r in (plain, off)]
    assert peaks[1] > 1.05 * peaks[0]
    means = [r.measures["force_xy_mean_straight"].value for r in (plain, off)]
    assert means[0] == means[1]


def test_blends_are_corner_strategies_too():
    result = simulate(
        parse(BASE, overrides=["path.compare=[sharp, 1 mm, {blend: 0.1 mm}, {blend: 0.1 mm, shape: clothoid}]"])
    )
    times = result["comparison"]["cycle_time"]
    assert list(times["strategy"].values) == [
        "sharp, exact stop", "fillet 1 mm", "blend 0.1 mm, arc", "blend 0.1 mm, clothoid",
    ]  # fmt: skip
    assert float(times[3]) > float(times[2]) > float(times[1])  # what keeps the jerk limit takes longer


def test_a_map_of_stability_has_a_range():
    assert "spindle_speed_min: is not below" in refused(
        "lobes={spindle_speed_min: 9000 rpm, spindle_speed_max: 8000 rpm}"
    )


def test_a_program_that_is_not_there_and_one_that_is_wrong(tmp_path):
    text = BASE.replace("path: {corner: 2 mm}", "program: part.nc")
    file = tmp_path / "scenario.yaml"
    file.write_text(text)
    with pytest.raises(ScenarioFault, match="no such file"):
        load(file)
    (tmp_path / "part.nc").write_text("G21 G90 F600 M3\nG1 X10 Z-1\nG12 X20\n")
    with pytest.raises(ScenarioFault, match=r"part\.nc:3:1: G12 is unknown"):
        load(file)
    (tmp_path / "part.nc").write_text("G21 G90 F600 M3\nG1 X10 Z-1\n")
    with pytest.raises(ScenarioFault, match=r"no spindle speed .S with M3."):
        simulate(load(file, ["operation={axial_depth: 5 mm, radial_depth: 4 mm}"]))


PROGRAM = """\
program:
  file: part.nc
  tools: tool.tbl
  offsets: {G55: {x: 30 mm, rotation: 90 deg}}
  start: {x: 0 mm, y: 0 mm, z: 20 mm}
"""


def test_what_a_program_needs_is_read_with_it(tmp_path):
    """Tools, offsets, start and subroutine files; all of it is in the document, so that a run file runs again."""
    (tmp_path / "s.yaml").write_text(BASE.replace("path: {corner: 2 mm}\n", PROGRAM))
    (tmp_path / "part.nc").write_text("G21 S8000 M3 F2400\nT2 M6\no<edge> call [40]\nG55 G1 X0 Y10\nM2\n")
    (tmp_path / "edge.ngc").write_text("o<edge> sub\nG0 X-20\nG1 Z-5\nG41\nG1 X0\nX#1\nG40\nX[#1+5]\no<edge> endsub\n")
    (tmp_path / "tool.tbl").write_text("T2 P1 D10 Z50\n")
    scenario = load(tmp_path / "s.yaml")
    assert scenario.program.tools[0].diameter == pytest.approx(0.01)
    assert "edge" in scenario.program.subroutines
    again = read_document(scenario.document())
    for one in (scenario, again):
        moves = read_program(one).moves
        assert moves[0].start == pytest.approx((0.0, 0.0, 0.02))
        assert any(move.end == pytest.approx((0.04, 0.005, -0.005)) for move in moves)  # compensated by half of 10 mm
        assert moves[-1].end == pytest.approx((0.02, 0.0, -0.005))


def test_what_is_wrong_with_a_program_and_what_stands_beside_it(tmp_path):
    (tmp_path / "s.yaml").write_text(BASE.replace("path: {corner: 2 mm}\n", PROGRAM.replace("G55", "G60")))
    (tmp_path / "part.nc").write_text("G21 S8000 M3 F2400\nG12\nG1 X1\n")
    (tmp_path / "tool.tbl").write_text("T2 P1 D10 Z50\nrubbish\n")
    with pytest.raises(ScenarioFault) as found:
        load(tmp_path / "s.yaml")
    said = str(found.value)
    for words in ('"G60" is not a work coordinate system', "part.nc:2:1: G12 is unknown", "tool.tbl:2:1"):
        assert words in said
    code = "G21 S8000 M3 F2400\nG1 X10 Z-1\nA30\nM4\nX20\n"
    text = BASE.replace("path: {corner: 2 mm}", "program: {file: inline, text: " + repr(code).replace("'", '"') + "}")
    with pytest.raises(
        ScenarioFault,
        match=r"line 5 of the program \(.*\): the spindle turns to the left.*\n.*line 3 of the program.*: a rotary axis moves",
    ):
        simulate(parse(text))


def test_readings_of_the_gain_table():
    def gains(reading):
        pair = feed_drives(parse(BASE, overrides=[f"machine.reading={reading}"]).machine)
        return [(law.proportional, law.integral, law.derivative) for _, law in pair]

    assert gains("as_printed") == [pytest.approx((500e3, 70e3, 300.0)), pytest.approx((462.539e3, 64.75e3, 278.0))]
    assert gains("kp_ki_swapped") == [pytest.approx((70e3, 500e3, 300.0)), pytest.approx((64.75e3, 462.539e3, 278.0))]
    assert gains("matched") == gains("kp_ki_swapped")[::-1]


def test_cjme2023_is_the_cascade_of_its_source():
    """P position and PI velocity loop: poles at 158.7 rad/s with damping 0.48, and at 8.3 rad/s."""
    from cutwise.physics.motion.loop import continuous_poles

    pair = feed_drives(parse(BASE, overrides=["machine={library: cjme2023}"]).machine)
    for plant, law in pair:
        poles = sorted(continuous_poles(plant, law), key=abs)
        assert abs(poles[0]) == pytest.approx(8.3, abs=0.2)
        assert abs(poles[2]) == pytest.approx(158.7, abs=3.0)
        assert -poles[2].real / abs(poles[2]) == pytest.approx(0.48, abs=0.02)
    assert pair[0].plant.stiction_plus == pytest.approx(1.802, abs=1e-3)
    assert pair[1].plant.coulomb_minus == pytest.approx(-2.430, abs=1e-3)


def test_chatter_is_said_and_a_stiff_tool_does_not():
    mode = "tool.modes=[{direction: x, frequency: 922 Hz, damping: 0.011, stiffness: STIFF}]"
    soft = simulate(parse(BASE, overrides=[mode.replace("STIFF", "1.34 N/um")]))
    assert soft.measures["chatter_growth_corner"].value > 1.0
    assert any(finding.code == "unstable" for finding in soft.unsound)
    stiff = simulate(parse(BASE, overrides=[mode.replace("STIFF", "200 N/um")]))
    assert stiff.measures["chatter_growth_corner"].value < 1.0
    assert not any(finding.code == "unstable" for finding in stiff.findings)


def test_program_and_corner_agree():
    """The same corner as G-code gives the same path, time and contour error."""
    corner = simulate(parse(BASE)).measures
    code = "G21 G90 G61 S8000 M3 F2400\nG0 X-30 Y0\nG1 Z-5\nG4 P0.6\nG1 X-2\nG3 X0 Y2 I0 J2\nG1 Y30\nM30\n"
    text = BASE.replace("path: {corner: 2 mm}", "program: {file: inline, text: " + repr(code).replace("'", '"') + "}")
    program = simulate(parse(text, overrides=["numerics.discs=20"])).measures
    assert program["contour_error_max"].value == pytest.approx(corner["contour_error_max"].value, rel=2e-3)
    assert program["engagement_angle_max"].value == pytest.approx(corner["engagement_angle_max"].value, abs=0.02)
    assert program["force_xy_peak"].value == pytest.approx(corner["force_xy_peak"].value, rel=0.01)
    assert math.isclose(program["force_xy_mean_straight"].value, corner["force_xy_mean_straight"].value)


def test_blend_trades_contour_for_time():
    sharp = simulate(parse(BASE, overrides=["path.corner=sharp"])).measures
    blend = simulate(parse(BASE, overrides=["path.corner=sharp", "path_mode={blend: 0.2 mm}"])).measures
    assert blend["cycle_time"].value < sharp["cycle_time"].value
    assert blend["contour_error_max"].value > sharp["contour_error_max"].value
    assert blend["stops"].value == 0


@pytest.mark.parametrize("depth", ["10 mm", "15 mm", "20 mm"])
def test_a_corner_may_be_cut_with_half_the_mill_and_more(depth):
    """The mill has a radius of 10 mm; the contact of such passes is counted point by point in the tests of corners."""
    scenario = parse(BASE, overrides=[f"operation.radial_depth={depth}"])
    assert scenario.operation.radial_depth == pytest.approx(float(depth.split()[0]) * 1e-3)


def test_a_program_with_a_stock_needs_no_operation(tmp_path):
    (tmp_path / "p.nc").write_text("G21 G90 G17 S8000 M3 F600\nG0 X0 Y0 Z5\nG1 Z-1\nG1 X20\nM2\n")
    stock = "stock: {x: [-20 mm, 40 mm], y: [-20 mm, 20 mm], z: [-5 mm, 0 mm]}"
    lines = [line for line in BASE.splitlines() if not line.startswith(("path:", "operation:"))]
    assert parse("\n".join([*lines, "program: p.nc", stock]), folder=tmp_path).operation.feed is None
    with pytest.raises(ScenarioFault) as found:
        parse("\n".join([*lines, "program: p.nc"]), folder=tmp_path)
    assert "operation.axial_depth: missing" in str(found.value)
    assert "operation: missing" not in str(found.value)
