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


def test_the_solid_of_several_set_ups_is_refused_and_gone_on_from(cutwise, tmp_path):
    (tmp_path / "top.nc").write_text("G21 G90 T1 M6 S8000 M3\nG0 X-10 Y10 Z5\nG1 Z-10 F600\nG1 X30\nG0 Z20\n")
    (tmp_path / "side.nc").write_text("G21 G90 T1 M6 S8000 M3\nG0 X-10 Y8 Z5\nG1 Z-12 F600\nG1 X30\nG0 Z20\n")
    block = "{x: [0 mm, 20 mm], y: [0 mm, 20 mm], z: [-20 mm, 0 mm]}"
    tail = "tools: [{number: 1, shape: flat, diameter: 6 mm, flutes: 2, helix: 30 deg}]\nnumerics: {stock: {grid: 0.5 mm}}\n"
    (tmp_path / "two.yaml").write_text(
        f"process: mill\nstock: {block}\n{tail}setups:\n  - program: top.nc\n"
        "  - {program: side.nc, axis: [0, 1, 0], zero: [0 mm, 20 mm, 0 mm]}\n"
    )
    found = cutwise("run", tmp_path / "two.yaml", "--json", "-o", tmp_path / "out")
    assert found.code == 0, found.err
    assert 1e9 * json.loads(found.out)["measures"]["removed_volume"]["value"] == pytest.approx(2140, rel=1e-6)
    refused = cutwise("export", tmp_path / "out", "surface")
    assert refused.code == 2
    assert "stock: {run: ...}" in refused.err
    assert cutwise("export", tmp_path / "out", "lines").code == 0
    assert "setup" in (tmp_path / "out" / "lines.csv").read_text().splitlines()[0]
    coarse = tail.replace("grid: 0.5 mm", "grid: 1 mm, station: 5 mm, elements: 4, check: 100")  # three maps are slow
    (tmp_path / "next.yaml").write_text(f"process: mill\nstock: {{run: out}}\n{coarse}program: top.nc\n")
    again = json.loads(cutwise("run", tmp_path / "next.yaml", "--json", "-o", tmp_path / "more").out)
    assert again["measures"]["removed_volume"]["value"] == 0.0
    bad = (
        (tmp_path / "two.yaml").read_text().replace("side.nc", "none.nc").replace("axis: [0, 1, 0]", "axis: [0, 0, 0]")
    )
    (tmp_path / "bad.yaml").write_text(bad)
    told = cutwise("check", tmp_path / "bad.yaml")
    assert told.code == 2
    assert "none.nc" in told.err
    assert "axis: is zero" in told.err


def test_the_real_surface_stands_beside_the_ideal_one_in_the_report(cutwise, examples, tmp_path):
    machine = ("--set", "machine={library: fadal2216, reading: kp_ki_swapped}", "--set", "requirements={}")
    coarse = ("--set", "numerics.stock={grid: 1 mm, engagement: none, check: 100}", "--set", "part.samples=2000")
    found = cutwise("run", examples / "mill_part.yaml", *machine, *coarse, "--json", "-o", tmp_path / "out")
    told = json.loads(found.out)
    assert told["measures"]["deviation_min"]["value"] != told["measures"]["deviation_min_ideal"]["value"]
    assert "feed drives" in told["notes"]["real surface"]
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for words in ("Deviation from the part", "Deviation of the planned path", "Tool beside its path"):
        assert words in page
