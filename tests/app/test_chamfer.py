"""Process chamfer on the command line: exit codes, messages, programs, report."""

import json
import re

import pytest

from cutwise.app.plots import PLOTS
from cutwise.io import cad_parts, step

PIPE, BLOCK = "chamfer_pipe_hole.yaml", "chamfer_step_part.yaml"


@pytest.fixture
def run(cutwise, examples):
    """A run of an example with changes: exit code and what is said."""

    def of(example, *changes, more=()):
        return cutwise("run", examples / example, *(word for text in changes for word in ("--set", text)), *more)

    return of


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("part.pipe.hole_radius=16 mm", ("part.pipe.hole_radius", "larger than the pipe: its radius is 15 mm")),
        ("chamfer.width=4.1 mm", ("chamfer.width", "ball")),
        ("part.edges=left", ("part.edges", "write inner, outer or all")),
        ("tool.rod_radius=2 mm", ("tool.rod_radius",)),
    ],
)
def test_what_contradicts_itself_is_bad_input(run, change, words):
    found = run(PIPE, change)
    assert found.code == 2
    for word in words:
        assert word in found.err
    assert "Traceback" not in found.err


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (("chamfer.width=0.5 mm", "chamfer.tilt=0 deg"),
         ("rod_clears_wall", "margin -0.02366 mm", "advice: tilt the chamfer by 0.8808 deg")),
        (("tool.ball_radius=4.2 mm", "tool.rod_radius=2 mm"),
         ("ball_enters_hole", "margin -0.2 mm", "advice: another tool axis (tool.axis: +y or -y)")),
        (("part.pipe.eccentricity=10 mm",), ("no_edge", "margin -1 mm", "advice: a hole of less than 3 mm radius (part.")),
    ],
)  # fmt: skip
def test_infeasible_is_exit_code_one_with_margin_and_remedy(run, changes, words):
    found = run(PIPE, "path.points=360", *changes)
    assert found.code == 1
    for word in words:
        assert word in found.out + found.err


def wireframe(file):
    gp = step.occ("gp")
    edge = step.occ("BRepBuilderAPI").BRepBuilderAPI_MakeEdge(gp.gp_Pnt(0, 0, 0), gp.gp_Pnt(10, 0, 0)).Edge()
    step.write_step(edge, file)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "the file is empty"),
        (b"solid x\n", "not a STEP file"),
        (None, "wireframe"),
        (b"\xff\xfe\x00", "not a STEP file"),
    ],
)
@pytest.mark.parametrize("command", ["run", "part"])
def test_files_that_are_no_part(cutwise, examples, tmp_path, command, content, words):
    file = tmp_path / "part.step"
    if content is None:
        wireframe(file)
    else:
        file.write_bytes(content)
    found = (
        cutwise("run", examples / BLOCK, "--set", f"part.step={file}") if command == "run" else cutwise("part", file)
    )
    assert found.code == 2
    assert f"part.step: {words}" in found.err.replace("a wireframe", "wireframe").replace(": a STEP", ": STEP")


def test_a_strange_selector_is_told_with_all_other_faults(run):
    found = run(BLOCK, "part.edges=xx, !inner", "chamfer.width=-1 mm")
    assert found.code == 2
    assert 'part.edges: "xx" selects nothing: write inner, outer or all; of a CAD part all, outer' in found.err
    assert "2 faults" in found.err
    negated = run(BLOCK, "part.edges=!closed & edge:1-3", "requirements={}", more=("--no-report", "--no-advice"))
    assert negated.code == 0


def test_a_selector_that_finds_nothing_says_what_there_is(run):
    found = run(BLOCK, "part.edges=hole:9")
    assert found.code == 2
    assert "there are edges 1 to 25 and holes 1, 2, 3, 4" in found.err


def test_json_is_one_object_whatever_the_readers_print(run):
    told = json.loads(run(BLOCK, "part.edges=edge:4", more=("--json", "--no-report", "--no-advice")).out)
    assert told["process"] == "chamfer"
    assert told["measures"]["edges_chamfered"]["value"] == 1.0
    assert told["measures"]["width_min"]["unit"] == "m"


def test_part_lists_holes_and_edges_and_draws_them(cutwise, tmp_path):
    file = step.write_step(cad_parts.drilled_pipe(0.015, 0.002, 0.004, 0.06), tmp_path / "pipe.step")
    found = cutwise("part", file, "--svg", "part.svg")
    assert found.code == 0
    assert "1 solid(s)" in found.out
    assert "6 sharp convex edges (6 closed)" in found.out
    assert re.search(r"edge:\d +2\d\.\d+ mm", found.out)
    assert re.search(r"hole:\d +diameter 8 mm, depth [\d.]+ mm, at \(0, 0, 1\d\.\d+\), axis \(0, 0, 1\)", found.out)
    assert re.search(r"edge:\d +81\.68 mm  90° +\(0, 30, 0\) +closed, outer", found.out)
    assert "<svg" in (tmp_path / "part.svg").read_text(encoding="utf-8")


def test_programs_are_written(run, tmp_path):
    found = run(
        PIPE, "path.points=360", more=("--gcode", "a.nc", "--apt", "a.apt", "--poses", "a.csv", "--no-report", "--no-advice"),
    )  # fmt: skip
    assert found.code == 0
    assert (tmp_path / "a.nc").read_text(encoding="utf-8").count("G1") > 360
    assert "GOTO/" in (tmp_path / "a.apt").read_text(encoding="utf-8")
    assert (tmp_path / "a.csv").read_text(encoding="utf-8").count("\n") > 360


def test_programs_with_several_set_ups_have_no_fault(run, cutwise):
    found = run(
        BLOCK,
        "part.edges=outer",
        "operation.spindle_speed=12000 rpm",
        more=("--gcode", "b.nc", "--apt", "b.apt", "--no-report", "--no-advice"),
    )
    assert found.code == 0
    for name in ("b.nc", "b.apt"):
        told = cutwise("program", name)
        assert told.code == 0
        assert "spindle: 12000 rpm" in told.out
        assert "stops for the operator: 5" in told.out


def test_the_report_holds_every_plot(run, tmp_path):
    """Those of a compliant run are all that there are."""
    found = run("chamfer_compliant_spindle.yaml", "path.points=180", "spindle.library=prototype", more=("-o", "out"))
    assert found.code in (0, 1)
    html = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for plot in PLOTS["chamfer"]:
        assert plot.title in html
