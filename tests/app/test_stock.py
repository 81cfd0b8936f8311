"""The command line on a program in a stock in 3D: run, export of lines and of the machined stock, plain refusals."""

import json

import pytest

from cutwise.io.stl import open_edges, read_stl

COARSE = ("--set", "numerics.stock={grid: 1 mm, station: 5 mm, elements: 4, check: 100}", "--set", "part.samples=2000")


def test_the_example_its_lines_and_its_solid(cutwise, examples, tmp_path):
    folder = tmp_path / "out"
    found = cutwise("run", examples / "mill_part.yaml", *COARSE, "--json", "-o", folder)
    assert found.code == 0, found.err
    told = json.loads(found.out)
    assert told["verdict"] == "pass"
    assert {"deviation_min", "deviation_max"} <= {one["measure"] for one in told["requirements"]}
    assert "line 162" in told["notes"]["deepest gouge"]
    page = (folder / "report.html").read_text(encoding="utf-8")
    for words in ("Deviation from the part", "Machined stock", "Load along the program"):
        assert words in page
    assert cutwise("export", folder, "lines").code == 0
    rows = (folder / "lines.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0].startswith("move, line, last_line, tool, rapid, time [s], feed [m/s], removed_volume [m³]")
    removed = sum(float(row.split(", ")[7]) for row in rows[1:])
    assert removed == pytest.approx(told["measures"]["removed_volume"]["value"], rel=1e-9)
    assert cutwise("export", folder, "surface", "-o", tmp_path / "left.stl").code == 0
    solid = read_stl(tmp_path / "left.stl")
    assert open_edges(1e3 * solid) == 0
    for ending, magic in (("ply", b"ply"), ("vtk", b"# vtk")):
        assert cutwise("export", folder, "surface", "-o", tmp_path / f"left.{ending}").code == 0
        assert (tmp_path / f"left.{ending}").read_bytes().startswith(magic)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(("noise",), "there are lines, surface"), (("surface", "-o", "left.obj"), ".ply, .vtk, .stl")],
)
def test_exports_that_cannot_be(cutwise, examples, tmp_path, arguments, words):
    folder = tmp_path / "out"
    cutwise("run", examples / "mill_part.yaml", *COARSE, "--json", "-o", folder, "--no-report")
    refused = cutwise("export", folder, *arguments)
    assert refused.code == 2
    assert words in refused.err


def test_a_run_without_such_a_stock_says_so(cutwise, examples, tmp_path):
    cutwise("run", examples / "deburr_rigid_on_machine.yaml", "--json", "-o", tmp_path / "out", "--no-report")
    for what in ("lines", "surface"):
        refused = cutwise("export", tmp_path / "out", what)
        assert refused.code == 2
        assert "stock in 3D" in refused.err


def test_what_is_wrong_is_said_at_once(cutwise, tmp_path):
    (tmp_path / "bad.yaml").write_text(
        "process: mill\nprogram: {file: a.nc, text: G1 X1 F1}\npart: {file: none.step, tolerance: 10}\n"
        "tools:\n  - {number: 1, shape: bull_nose, diameter: 10 mm, flutes: 3, helix: 30 deg}\n"
        "setups: [{program: {file: b.nc, text: G1 X1 F1}, axis: [0, 0, 0]}]\n"
    )
    refused = cutwise("check", tmp_path / "bad.yaml")
    assert refused.code == 2
    for words in (
        "stock: missing",
        "none.step: no such file",
        "has no unit",
        "corner_radius: missing",
        "axis: is zero",
    ):
        assert words in refused.err


def test_faults_of_files_are_told_together_by_check_and_run(cutwise, examples, tmp_path):
    """Files of entries of a list stand beside the scenario too."""
    (tmp_path / "open.stl").write_text(
        "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
    )
    text = (examples / "mill_part.yaml").read_text(encoding="utf-8").replace("mill_part.", f"{examples}/mill_part.")
    text = text.replace("tolerance: 50 um", "tolerance: 50 um, solid: 3") + "fixtures: [{file: open.stl}]\n"
    (tmp_path / "bad.yaml").write_text(text.replace("- number: 1", "- number: 3"))
    for command in (("check", tmp_path / "bad.yaml"), ("run", tmp_path / "bad.yaml", "-o", tmp_path / "out")):
        refused = cutwise(*command)
        assert refused.code == 2
        for words in ("T1, which is not among them", "has no solid 3", "open.stl: is not closed"):
            assert words in refused.err, refused.err
