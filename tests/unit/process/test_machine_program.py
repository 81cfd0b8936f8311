"""A G-code program on a machine chain: where the axes go, the force of the cut along it, and the error it leaves."""

import math

import numpy as np
import pytest

from cutwise.io.scenario import load, parse
from cutwise.maths import chains
from cutwise.physics.engagement.corner import Corner, greatest_immersion, straight_immersion
from cutwise.process import machine_assemble, machine_pass
from cutwise.process.recipes import simulate
from cutwise.spec.faults import ScenarioFault

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


def test_result_does_not_move_with_twice_the_places(examples, tmp_path):
    result = simulate(scenario(examples, tmp_path, CORNER, *CUT, "program.samples=400"))
    assert abs(result.convergence["deviation_norm_max"]) < 2e-3 * result.measures["deviation_norm_max"].value


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
