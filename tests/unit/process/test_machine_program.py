"""A G-code program on a machine chain: where the axes go, the force of the cut along it, and the error it leaves."""

import math

import numpy as np
import pytest

from cutwise.io.scenario import load, parse
from cutwise.maths import chains
from cutwise.physics.engagement.corner import Corner, greatest_immersion, straight_immersion
from cutwise.process import machine_assemble, machine_pass, machine_path
from cutwise.process.recipes import prepare, simulate
from cutwise.spec.faults import ScenarioFault
from cutwise.study.advice import advise

STRAIGHT = "G21 G90 S500 M3\nG0 X-130 Y-40 Z10\nZ-5\nG1 X130 F400\nM30\n"
CORNER = "G21 G90 S500 M3\nG0 X-40 Y0 Z-5\nG1 X0 F400\nY40\nM30\n"


def scenario(examples, folder, text, *changes):
    """The mill of the paper with a program whose zero is the middle of the part's upper face."""
    (folder / "part.nc").write_text(text)
    base = (examples / "machine_error_budget.yaml").read_text()
    start, end = base.index("path:"), base.index("load:")
    program = "program: {file: part.nc, zero: [0 mm, 0 mm, 300 mm], samples: 27}\n\n"
    (folder / "machine.yaml").write_text(base[:start] + program + base[end:])
    return load(folder / "machine.yaml", changes)


def cell(found):
    return machine_assemble.machine_cell(found)


def test_a_straight_program_is_the_pass_of_the_paper(examples, tmp_path):
    """The same way as G-code: every number of the loaded pass, time of rapid moves left out."""
    by_program = simulate(scenario(examples, tmp_path, STRAIGHT))
    by_path = simulate(load(examples / "machine_error_budget.yaml"))
    skipped = {"wall_flatness", "deviation_std_x", "deviation_std_y", "deviation_std_z"}  # of a path: in the middle
    for name, measure in by_path.measures.items():
        if name not in skipped and "p95" not in name:
            assert by_program.measures[name].value == pytest.approx(measure.value, rel=1e-9, abs=1e-15), name
    assert by_program["motion"]["time"].values[-1] == pytest.approx(39.0)
    assert by_program["motion"]["program_line"].values[-1] == 4
    assert "line 4 of the program" in by_program.notes["worst"]


def test_words_may_be_positions_of_the_axes(examples, tmp_path):
    """X of this machine is 130 mm further than in the part: program.zero then shifts the axes."""
    plain = cell(scenario(examples, tmp_path, STRAIGHT))
    shifted = STRAIGHT.replace("X-130", "X0").replace("X130", "X260").replace("Z10", "Z310").replace("Z-5", "Z295")
    by_axes = ("program.words=axes", "program.zero=[0 mm, 0 mm, 0 mm]", "program.top=5 mm")
    moved = cell(scenario(examples, tmp_path, shifted.replace("Z310", "Z10").replace("Z295", "Z0").replace("Y-40", "Y0"),
                          *by_axes))  # fmt: skip
    np.testing.assert_allclose(moved.way.commands, plain.way.commands, atol=1e-12)
    np.testing.assert_allclose(moved.way.point, plain.way.point, atol=1e-12)
    np.testing.assert_allclose(moved.way.direction, plain.way.direction, atol=1e-12)


CUT = ("load.force={axial_depth: 5 mm, radial_depth: 2 mm}", "material.library=al7075t6")


def test_force_follows_the_feed_and_the_corner(examples, tmp_path):
    found = cell(scenario(examples, tmp_path, CORNER, *CUT, "program.samples=4000"))
    along_x, along_y = (found.way.direction @ axis > 0.999 for axis in np.eye(3)[:2])
    arc = found.cut.immersion
    assert arc[0] == pytest.approx(straight_immersion(2e-3, 5e-3))
    assert arc.max() == pytest.approx(greatest_immersion(Corner(5e-3, 2e-3, math.pi / 2, 0.0)), abs=1e-6)
    first, last = found.cut.force[along_x][0], found.cut.force[along_y][-1]
    assert [-first[1], first[0], first[2]] == pytest.approx(last.tolist(), rel=1e-12)  # a quarter turn to the left
    assert first[1] > 0.0  # the wall on the right pushes the mill to the left


def test_force_of_a_slot_does_not_know_the_side_of_the_wall(examples, tmp_path):
    slot = ("load.force={axial_depth: 5 mm}", "material.library=al7075t6")
    path = ("load.force={axial_depth: 5 mm, spindle_speed: 500 rpm}", "material.library=al7075t6")
    by_path = cell(load(examples / "machine_error_budget.yaml", path))
    by_program = cell(scenario(examples, tmp_path, STRAIGHT, *slot))
    assert by_program.cut.force[0] == pytest.approx(by_path.cut.force[0], rel=1e-12)
    assert (by_program.cut.immersion == math.pi).all()


def test_no_force_acts_off_the_cut(examples, tmp_path):
    text = "G21 G90 S500 M3\nG0 X-40 Y0 Z5\nG1 Z-5 F100\nX0 F400\nZ5\nM30\n"
    found = cell(scenario(examples, tmp_path, text, *CUT))
    assert sorted(set(found.way.line[found.way.cuts])) == [4]
    assert not found.cut.force[~found.way.cuts].any()
    run = machine_pass.run_pass(found)
    assert found.way.line[run.worst] == 4


def test_result_does_not_move_with_more_places(examples, tmp_path):
    """Few places miss the peak of the corner by little, because its ends are places; the run says by how much."""
    results = [simulate(scenario(examples, tmp_path, CORNER, *CUT, f"program.samples={n}")) for n in (40, 118, 400)]
    few, more, many = (result.measures["deviation_norm_max"].value for result in results)
    assert results[0].convergence["deviation_norm_max"] == pytest.approx(more - few)
    assert abs(many - few) < 2e-3 * many


def test_words_of_axes_meet_the_same_corner(examples, tmp_path):
    """X, Y and Z as positions of the axes, shifted by the zero: the same forces as places in the part."""
    by_part = cell(scenario(examples, tmp_path, CORNER, *CUT))
    axes = CORNER.replace("X-40 Y0 Z-5", "X-10 Y20 Z-5").replace("X0 ", "X30 ").replace("Y40", "Y60")
    zero = "program.zero=[100 mm, 20 mm, 5 mm]"  # X of this machine is 130 mm more, Y 40 mm
    by_axes = cell(scenario(examples, tmp_path, axes, *CUT, "program.words=axes", zero))
    np.testing.assert_allclose(by_axes.way.point, by_part.way.point, atol=1e-12)
    np.testing.assert_allclose(by_axes.cut.force, by_part.cut.force, atol=1e-9)
    assert np.ptp(by_axes.cut.immersion) > 0.5


def test_a_wall_in_many_blocks_is_one_wall(examples, tmp_path):
    """The corner is met however its lines are cut into blocks, in a program and in a path."""
    parts = "".join(f"X{x}\n" for x in range(-36, 1, 4)) + "".join(f"Y{y}\n" for y in range(4, 41, 4))
    text = CORNER.replace("G1 X0 F400\nY40\n", "G1 F400 " + parts)
    whole, cut_up = (cell(scenario(examples, tmp_path, program, *CUT)) for program in (CORNER, text))
    assert cut_up.cut.immersion.max() == pytest.approx(whole.cut.immersion.max(), abs=1e-9)


def test_rapid_moves_and_arcs_keep_to_the_travel(examples, tmp_path):
    """The middle of an arc beyond the travel, though both of its ends are within; a rapid move far up."""
    arc = "G21 G90 S500 M3\nG0 X120 Y-40 Z-5\nG3 X120 Y0 I0 J20 F400\nM30\n"
    with pytest.raises(ScenarioFault) as caught:
        cell(scenario(examples, tmp_path, arc))
    assert "part.nc:3:1: leads axis X to 270 mm" in str(caught.value)
    with pytest.raises(ScenarioFault, match=r"part.nc:2:1: leads axis Z"):
        cell(scenario(examples, tmp_path, STRAIGHT.replace("Z10", "Z500")))


def test_nothing_that_cuts_is_said(examples, tmp_path):
    for text, words in (
        (STRAIGHT.replace("Z-5", "Z5"), "its feed moves go down to z = 5 mm only"),
        (STRAIGHT.replace(" M3", ""), "the spindle does not turn"),
    ):
        with pytest.raises(ScenarioFault, match="cuts nowhere") as caught:
            cell(scenario(examples, tmp_path, text, *CUT))
        assert words in str(caught.value)
    above = cell(scenario(examples, tmp_path, STRAIGHT.replace("Z-5", "Z5"), *CUT, "program.top=7 mm"))
    assert above.way.cuts.all()


def test_a_spindle_that_stops_on_the_way_is_told(examples, tmp_path):
    text = STRAIGHT.replace("G1 X130 F400", "G1 X0 F400\nM5\nX130")
    result = simulate(scenario(examples, tmp_path, text, *CUT))
    assert any("does not turn in moves that would cut, which have no force here: line 6" in w for w in result.warnings)


def test_chips_and_places_out_of_range_are_told(examples, tmp_path):
    slow = simulate(scenario(examples, tmp_path, STRAIGHT.replace("S500", "S50"), *CUT))
    assert any("the feed per tooth is 2000 µm; usual is 5 to 400" in warning for warning in slow.warnings)
    assert any("the coefficients hold for chips of 20" in warning for warning in slow.warnings)
    low = simulate(scenario(examples, tmp_path, STRAIGHT, "part.height=100 mm"))
    assert any("the part stands from 0 to 100 mm" in warning for warning in low.warnings)
    narrow = simulate(scenario(examples, tmp_path, STRAIGHT, "part.width_y=20 mm"))
    assert any("leaves the part by more than the radius" in warning for warning in narrow.warnings)


TRUNNION = """
process: machine
machine: {library: five_axis_trunnion}
tool: {diameter: 16 mm, flutes: 3, tip: [0 mm, 0 mm, -140 mm], flexible: false}
material: {library: al7075t6}
program: {file: part.nc, zero: [0 mm, 0 mm, 60 mm], samples: 200}
load: {force: {axial_depth: 3 mm, radial_depth: 4 mm}, weights: false}
"""


def trunnion(folder, text, *changes):
    (folder / "part.nc").write_text(text)
    (folder / "trunnion.yaml").write_text(TRUNNION)
    return cell(load(folder / "trunnion.yaml", changes))


def test_rotary_words_turn_the_part_under_the_same_place(tmp_path):
    """Tool centre point control: the tool point goes where X, Y and Z say, whatever A and C do."""
    text = "G21 G90 S4000 M3\nG0 X-30 Y-10 Z5 A-20 C0\nG1 Z-2 F500\nX30 Y20 A-40 C30\nM30\n"
    found = trunnion(tmp_path, text)
    at = chains.frames(found.axes.chain, found.way.commands * found.axes.sense)
    np.testing.assert_allclose(chains.tool_point(at, found.tip), found.way.point, atol=1e-14)
    np.testing.assert_allclose(found.way.point[-1], [0.03, 0.02, 0.058], atol=1e-14)
    letters = machine_path.joints_of(load(tmp_path / "trunnion.yaml").machine)
    turned = np.degrees(found.way.commands[[0, -1]][:, [letters["A"], letters["C"]]])
    np.testing.assert_allclose(turned, [[-20, 0], [-40, 30]], atol=1e-12)
    middle = int(np.argmin(np.abs(found.way.point[:, 0])))
    share = (found.way.point[middle, 0] + 0.03) / 0.06
    assert np.degrees(found.way.commands[middle, letters["C"]]) == pytest.approx(30 * share, abs=1e-9)


def test_direction_and_speed_of_moving_axes_are_those_of_the_tool_point(tmp_path):
    """Words of axes: the tool point runs on a curve in the part; difference quotients say how."""
    text = "G21 G90 S4000 M3\nG0 X-30 Y-10 Z100 A-20 C0\nG1 X30 Y20 A-40 C30 F500\nM30\n"
    found = trunnion(tmp_path, text, "program.words=axes", "program.zero=[0 mm, 0 mm, 0 mm]", "program.top=500 mm",
                     "program.samples=4001")  # fmt: skip
    way = found.way
    velocity = np.gradient(way.point, way.time, axis=0)[1:-1]
    np.testing.assert_allclose(np.linalg.norm(velocity, axis=1), way.feed[1:-1], rtol=1e-5)
    np.testing.assert_allclose(velocity / way.feed[1:-1, None], way.direction[1:-1], atol=1e-5)
    assert np.ptp(way.feed) > 0.05 * way.feed.max()
    assert way.curve is None
    assert found.cut.chip[way.cuts].max() < way.feed.max() * 60 / (4000 * 3)


def test_path_of_turning_axes_has_the_direction_of_its_tool_point(examples):
    """The example's path with a force of the cut: direction and speed by difference quotients, at its ends too."""
    change = ("load.force={axial_depth: 2 mm, radial_depth: 3 mm, spindle_speed: 4000 rpm}", "tool.flutes=3",
              "material.library=al7075t6")  # fmt: skip
    fine = cell(load(examples / "machine_five_axis.yaml", (*change, "path.samples=6001"))).way
    coarse = cell(load(examples / "machine_five_axis.yaml", (*change, "path.samples=7"))).way
    velocity = np.gradient(fine.point, fine.time, axis=0, edge_order=2)
    np.testing.assert_allclose(
        velocity[[0, 3000, -1]], (coarse.direction * coarse.feed[:, None])[[0, 3, -1]], rtol=1e-5
    )


def test_a_tilted_tool_meets_corners_in_its_own_plane(tmp_path):
    """A part that is tilted and turned as a whole, with the program, has the same corner."""
    flat = "G21 G90 S4000 M3\nG0 X-30 Y0 Z5\nG1 Z-2 F500\nX0\nY30\nM30\n"
    plain = trunnion(tmp_path, flat)
    angle = math.radians(30)
    lines = ["G21 G90 S4000 M3", "G0 X0 Y0 Z80 A-30"]
    for x, y in ((-30, 0), (0, 0), (0, 30)):  # the plane normal to the tool, tilted about x
        lines.append(f"{'G0' if x < 0 else 'G1'} X{x} Y{y * math.cos(angle):.9f} Z{-2 + y * math.sin(angle):.9f} F500")
    tilted = trunnion(tmp_path, "\n".join([*lines, "M30", ""]))
    tool = chains.frames(tilted.axes.chain, tilted.way.commands * tilted.axes.sense).rotations[0, -1, :, 2]
    np.testing.assert_allclose(tool, [0, -math.sin(angle), math.cos(angle)], atol=1e-12)  # normal to that plane
    assert tilted.cut.immersion.max() == pytest.approx(plain.cut.immersion.max(), abs=1e-9)
    np.testing.assert_allclose(
        np.linalg.norm(tilted.cut.force, axis=1).max(), np.linalg.norm(plain.cut.force, axis=1).max(), rtol=1e-9
    )


def test_faults_of_rotary_programs(tmp_path, examples):
    text = "G21 G90 S500 M3\nG0 X-30 Y-10 Z5\nG1 Z-2 F500\nX30 C30\nM30\n"
    with pytest.raises(
        ScenarioFault, match=r"part.nc:4:1: turns axis C, which the machine does not have; it has X, Y, Z"
    ):
        cell(scenario(examples, tmp_path, text))
    with pytest.raises(ScenarioFault, match="stands upright"):
        trunnion(tmp_path, "G21 G90 S4000 M3\nG0 X-30 Y-10 Z5 A-20\nG1 Z-2 F500\nX30\nM30\n",
                 "stock={x: [-50 mm, 50 mm], y: [-50 mm, 50 mm], z: [-10 mm, 0 mm]}", "load.force={}")  # fmt: skip


def test_check_finds_what_a_run_would(examples, tmp_path):
    """Travel and spindle speed of a program are faults before anything is run, both at once."""
    given = scenario(examples, tmp_path, STRAIGHT.replace("X130", "X150").replace("S500", "S0"), *CUT)
    with pytest.raises(ScenarioFault) as caught:
        prepare(given)
    assert len(caught.value.faults) == 3  # and that it cuts nowhere with a spindle at rest


def test_advice_names_elements_to_stiffen(examples):
    given = load(examples / "machine_error_budget.yaml",
                 ("requirements={deviation_norm_max: {max: 420 um}}", "uncertainty=null", "path.samples=5"))  # fmt: skip
    found = advise(given, {"machine.chain[2].elements[0].pads.stiffness": ("0.5", "5")}, pairs=False)
    assert len(found) == 1
    assert found[0].startswith("change machine.chain[2].elements[0].pads.stiffness (x guide) to ")
    assert "times what it is: a run with it gives deviation_norm_max 4" in found[0]
    assert any("springs.angular_stiffness" in key for key in given.turned())


def test_a_wall_to_the_right_of_the_feed_turns_with_it(examples, tmp_path):
    side = ("surface={side: right, depth: 5 mm}",)
    result = simulate(scenario(examples, tmp_path, CORNER, *CUT, *side))
    error, f4 = result["surface"]["wall_error"].values[:, 0], result["surface"]["f4"].values
    assert error[0] == pytest.approx(f4[0, 1], rel=1e-12)  # feed along x: the wall's normal is +y
    assert error[-1] == pytest.approx(-f4[-1, 0], rel=1e-12)  # feed along y: -x
    assert "wall_flatness" not in result.measures
    assert "error_on_path" in result["surface"]


@pytest.mark.parametrize(
    ("text", "change", "words"),
    [
        (STRAIGHT.replace("X130", "X150"), "", "part.nc:4:1: leads axis X to 280 mm, beyond its travel of 0 mm to 260 mm"),
        (STRAIGHT, "path={points: [{X: 0 mm}, {X: 1 mm}], feed: 1 mm/s}", "no fault"),
        (STRAIGHT.replace("S500 M3", "M3"), CUT, "the program has no spindle speed"),
        (STRAIGHT, ("load.force={axial_depth: 5 mm, radial_depth: 11 mm}", CUT[1]), "more than the diameter"),
        (STRAIGHT, "surface={side: right, normal: [0, 1, 0], depth: 1 mm}", "exactly one of normal"),
        (STRAIGHT.replace("G1", "G77"), "", "G77 is unknown"),
    ],
)  # fmt: skip
def test_faults_of_a_program_are_named(examples, tmp_path, text, change, words):
    changes = change if isinstance(change, tuple) else (change,) if change else ()
    if words == "no fault":  # a path given on the command line stands for the program of the file
        assert scenario(examples, tmp_path, text, *changes).program is None
        return
    with pytest.raises(ScenarioFault, match=words):
        machine_assemble.machine_cell(scenario(examples, tmp_path, text, *changes))


def test_both_in_one_file_are_a_fault(examples, tmp_path):
    base = (examples / "machine_error_budget.yaml").read_text()
    (tmp_path / "part.nc").write_text(STRAIGHT)
    (tmp_path / "both.yaml").write_text(base + "\nprogram: part.nc\n")
    with pytest.raises(ScenarioFault, match="give one of path and program"):
        load(tmp_path / "both.yaml")


def test_five_axis_example_reaches_its_places(examples):
    """The way of the example by its commands; the error of the rotary axes shows where they turn."""
    found = cell(load(examples / "machine_five_axis.yaml"))
    at = chains.frames(found.axes.chain, found.way.commands * found.axes.sense)
    np.testing.assert_allclose(chains.tool_point(at, found.tip), found.way.point, atol=1e-15)
    assert found.way.curve is None


def test_stock_gives_the_depth_that_the_program_has(examples):
    """On the straight of a pass the pocket's own stock is the radial depth of 4 mm; the first slot is a full one."""
    by_stock = cell(load(examples / "machine_pocket.yaml"))
    depths = ["load.force={axial_depth: 5 mm, radial_depth: 4 mm}"]
    text = (examples / "machine_pocket.yaml").read_text()
    bare = "\n".join(line for line in text.splitlines() if not line.startswith("stock:"))
    by_depth = cell(parse(bare, overrides=depths, folder=examples))
    straight = (by_stock.way.line == 39) & (by_stock.way.direction[:, 0] < -0.999)
    middle = np.flatnonzero(straight)[len(np.flatnonzero(straight)) // 2]
    assert by_stock.cut.force[middle] == pytest.approx(by_depth.cut.force[middle], rel=1e-9)
    assert by_stock.cut.immersion.max() == pytest.approx(math.pi)
    assert by_depth.cut.immersion.max() < math.pi


POCKET = "G21 G90 S3000 M3\nG0 X0 Y0 Z5\nG1 Z-2 F200\n{passes}M30\n"
STOCK = ("stock={x: [-60 mm, 60 mm], y: [-40 mm, 40 mm], z: [-20 mm, 0 mm]}", "tool.diameter=10 mm", "tool.flutes=3",
         "load.force={spindle_speed: 3000 rpm}", "material.library=al7075t6")  # fmt: skip


def square(half):
    """Counterclockwise, the wall on the right."""
    return f"G1 X{half} Y-{half} F300\nX{half} Y{half}\nX-{half} Y{half}\nX-{half} Y-{half}\nX{half} Y-{half}\n"


def test_walls_count_that_stand_when_the_program_has_ended(examples, tmp_path):
    """Two rounds, the second 3 mm further out: the wall is that of the second."""
    wall = "surface={side: right, depth: 2 mm}"
    both = simulate(
        scenario(examples, tmp_path, POCKET.format(passes=square(10) + square(13)), *STOCK, wall, "program.samples=201")
    )
    error, line = both["surface"]["wall_error"].values, both["motion"]["program_line"].values
    left, at = np.isfinite(error).any(axis=1), 1e3 * both["motion"]["position"].values
    assert not left[(line > 4) & (line < 9)].any()
    second = (np.abs(np.abs(at[:, :2]).max(axis=1) - 13.0) < 1e-6) & (line > 9)
    assert left[second].mean() > 0.9
    assert both.measures["wall_error_max"].value == np.nanmax(error)


def test_rapid_moves_and_plunges_into_the_stock_are_told(examples, tmp_path):
    text = "G21 G90 S3000 M3\nG0 X0 Y0 Z5\nG1 Z-2 F200\nG0 X20\nG1 X25 F300\nM30\n"
    said = simulate(scenario(examples, tmp_path, text, *STOCK)).warnings
    assert any("rapid moves run through the stock: line 4" in words for words in said)
    assert any("plunges straight into the stock" in words and "line 3" in words for words in said)
