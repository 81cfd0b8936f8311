"""Scenarios to begin with: wired to a program or a part, with the schema beside; and what the shell offers while typing."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from cutwise.io.scenario import load


@pytest.fixture
def bench(examples, tmp_path, monkeypatch):
    """A folder with programs and parts."""
    for name in ("mill_pocket.nc", "mill_part.nc", "mill_part.step", "bracket.ngc", "bracket.tbl"):
        shutil.copy(examples / name, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(name, body):
    Path(name).write_text(f"%\nG21 G17 G90 G94\n{body}\nM30\n%\n")


@pytest.mark.usefixtures("bench")
def test_a_program_becomes_a_scenario(cutwise):
    assert cutwise("new", "mill", "--program", "mill_pocket.nc", "--tool-diameter", "20 mm").code == 0
    found = load("mill_pocket.yaml")
    # feed moves of the pocket run over x 10..90, y 10..50 down to -5; radius and diameter: 30 mm
    assert [found["stock.x"], found["stock.y"], found["stock.z"]] == [
        pytest.approx((-0.02, 0.12)), pytest.approx((-0.02, 0.08)), pytest.approx((-0.01, 0.0)),
    ]  # fmt: skip
    assert found["operation.spindle_speed"] == pytest.approx(8000 * 2 * 3.141592653589793 / 60)
    assert found["tool.diameter"] == pytest.approx(0.02)
    sources = {key: (one.status, one.source) for key, one in found.origins.items()}
    assert sources["operation.spindle_speed"] == ("user", "S of mill_pocket.nc")
    assert sources["tool.diameter"] == ("user", "--tool-diameter")
    assert sources["tool.flutes"][0] == sources["tool.helix"][0] == "assumed"
    said = cutwise("check", "mill_pocket.yaml")
    assert said.code == 0
    assert "no fault" in said.out


@pytest.mark.usefixtures("bench")
@pytest.mark.parametrize(("body", "diameter"), [
    ("(T1 D=6. CR=0. - flat end mill)\nT1 M6\nS5000 M3\nG1 X10 Y5 Z-1 F300", 0.006),
    ("(DIAMETER 8.5)\nS5000 M3\nG1 X10 Y5 Z-1 F300", 0.0085),
    ("(12 MM END MILL)\nS5000 M3\nG1 X10 Y5 Z-1 F300", 0.012),
    ("(depth 5, 3 passes)\nS5000 M3\nG1 X10 Y5 Z-1 F300", None),
    ("(D=6 or D=8)\nS5000 M3\nG1 X10 Y5 Z-1 F300", None),  # two that differ tell nothing
])  # fmt: skip
def test_a_diameter_comes_from_a_comment_or_is_left_for_check_to_name(cutwise, body, diameter):
    write("one.nc", body)
    assert cutwise("new", "mill", "--program", "one.nc", "--no-schema").code == 0
    if diameter is not None:
        assert load("one.yaml")["tool.diameter"] == pytest.approx(diameter)
        return
    said = cutwise("check", "one.yaml")
    assert said.code == 2
    assert "tool.diameter: missing" in said.err
    assert said.err.count("\n") == 2  # that fault alone


@pytest.mark.usefixtures("bench")
def test_inches_of_a_comment():
    from cutwise.app.starting import milled

    Path("inch.nc").write_text("G20 G90\n(T1 D=0.5)\nT1 M6 S3000 M3\nG1 X1 Z-.1 F10\nM30\n")
    text = milled(Path("inch.nc"), None, Path())
    Path("inch.yaml").write_text(text)
    assert load("inch.yaml")["tool.diameter"] == pytest.approx(0.0127)
    assert load("inch.yaml")["stock.z"] == pytest.approx((-0.00254 - 0.005, 0.0))


@pytest.mark.usefixtures("bench")
def test_the_top_is_the_highest_feed_move_where_all_are_above_zero():
    from cutwise.app.starting import milled

    write("up.nc", "T1 M6 S3000 M3\nG0 Z50\nG1 X10 Z20 F300\nG1 Z12")
    Path("up.yaml").write_text(milled(Path("up.nc"), "10 mm", Path()))
    assert load("up.yaml")["stock.z"] == pytest.approx((0.007, 0.05))  # the feed move begins at 50


@pytest.mark.usefixtures("bench")
def test_a_program_of_several_tools_and_its_table(cutwise):
    assert cutwise("new", "mill", "--program", "mill_part.nc").code == 0
    said = cutwise("check", "mill_part.yaml")
    assert [line.split(": missing")[0][-17:] for line in said.err.splitlines()[:2]] == [
        "tools[0].diameter",
        "tools[1].diameter",
    ]
    assert "their diameters into a tool table, mill_part.tbl" in (
        cutwise("new", "mill", "--program", "mill_part.nc", "--tool-diameter", "5 mm", "-o", "x.yaml").err
    )
    Path("mill_part.tbl").write_text("T1 P1 D10\nT2 P2 D6\n")
    assert cutwise("new", "mill", "--program", "mill_part.nc", "-o", "with.yaml").code == 0
    found = load("with.yaml")
    assert [found[f"tools[{i}].diameter"] for i in (0, 1)] == pytest.approx([0.01, 0.006])
    assert found["stock.x"] == pytest.approx((-0.02498 - 0.015, 0.06498 + 0.015))
    assert cutwise("check", "with.yaml").code == 0


@pytest.mark.usefixtures("bench")
def test_the_program_is_named_from_the_folder_of_the_scenario(cutwise):
    Path("odd name: 1").mkdir()
    assert cutwise("new", "mill", "--program", "mill_pocket.nc", "-o", "odd name: 1/deep.yaml").code == 0
    assert load("odd name: 1/deep.yaml").program.text == Path("mill_pocket.nc").read_text()
    shutil.copy("mill_pocket.nc", "odd name: 1/a # b: c.nc")
    assert cutwise("new", "mill", "--program", "odd name: 1/a # b: c.nc", "-o", "here.yaml").code == 0
    assert load("here.yaml").program.file == "odd name: 1/a # b: c.nc"


@pytest.mark.usefixtures("bench")
@pytest.mark.parametrize(("arguments", "words"), [
    (("deburr", "--program", "mill_pocket.nc"), "--program: goes with mill, not with deburr"),
    (("mill", "--step", "mill_part.step"), "--step: goes with chamfer, not with mill"),
    (("mill", "--tool-diameter", "5 mm"), "--tool-diameter: goes with --program"),
    (("mill", "--program", "none.nc"), "none.nc"),
    (("mill", "--program", "mill_pocket.nc", "--tool-diameter", "5"), "--tool-diameter: 5 has no unit"),
    (("mill", "--program", "mill_pocket.nc", "--tool-diameter", "-5 mm"), "--tool-diameter: must be greater than 0"),
    (("mill", "--program", "empty.nc"), "there is nothing to mill"),
    (("mill", "--program", "wrong.nc"), "wrong.nc:3"),
    (("chamfer", "--step", "none.step"), "none.step"),
    (("mill", "--program", "mill_pocket.nc", "-o", "mill_pocket.nc"), "would be overwritten, and it is read"),
])  # fmt: skip
def test_what_is_refused(cutwise, arguments, words):
    write("empty.nc", "G0 X10")
    write("wrong.nc", "G1 X[1 F300")
    before = sorted(Path().iterdir())
    said = cutwise("new", *arguments)
    assert said.code == 2
    assert words in said.err
    assert "Traceback" not in said.err
    assert sorted(Path().iterdir()) == before


@pytest.mark.usefixtures("bench")
def test_a_part_becomes_a_scenario_with_its_edges_listed(cutwise):
    assert cutwise("new", "chamfer", "--step", "mill_part.step").code == 0
    text = Path("mill_part.yaml").read_text()
    assert "# what cutwise part finds in mill_part.step" in text
    assert "#   edge:1 " in text
    found = load("mill_part.yaml")
    assert found["part.edges"] == "all"
    assert Path(found["part.step"]) == Path("mill_part.step")
    assert text.splitlines()[0] == "# yaml-language-server: $schema=.cutwise/schema/chamfer.json"


def test_the_schema_lies_beside_it(cutwise):
    import jsonschema

    assert cutwise("new", "drill").code == 0
    text = Path("drill.yaml").read_text()
    assert text.startswith("# yaml-language-server: $schema=.cutwise/schema/drill.json\n")
    schema = json.loads(Path(".cutwise/schema/drill.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    assert cutwise("new", "deburr", "--no-schema").code == 0
    assert not Path("deburr.yaml").read_text().startswith("# yaml-language-server")
    assert not Path(".cutwise/schema/deburr.json").exists()


# --- completion -----------------------------------------------------------------------------------------------------------
def offered(line, cwd, report="pass"):
    """What the shell is told behind a line; with the modules that were loaded for it."""
    words = line.split(" ")
    env = {**os.environ, "COMP_WORDS": line, "COMP_CWORD": str(len(words) - 1), "_CUTWISE_COMPLETE": "complete_bash"}
    code = f"import atexit, sys; {report}; from cutwise.app.cli import main; main()"
    done = subprocess.run([sys.executable, "-c", code], cwd=cwd, env=env, capture_output=True, text=True, check=False)
    return done.stdout.split(), done.stderr


@pytest.mark.parametrize(("line", "there", "not_there"), [
    ("cutwise v", "view validate", "run"),
    ("cutwise new ", "deburr mill turn", "cutwise"),
    ("cutwise library ma", "machines materials", "tools"),
    ("cutwise library tools s", "sato2016", "berselli2016"),
    ("cutwise run edge.yaml --set spindle.p", "spindle.pressure= spindle.pistons=", "operation.feed="),
    ("cutwise run edge.yaml --set spindle.library=b", "spindle.library=berselli2016", "spindle.library=default"),
    ("cutwise check edge.yaml --set operation.", "operation.feed= operation.preset=", "operation.axial_depth="),  # of milling
    ("cutwise advise edge.yaml --limit operation.f", "operation.feed=", "operation.preset="),
    ("cutwise sweep none.yaml --over operation.a", "operation.axial_depth=", "spindle.pressure="),  # of any process
])  # fmt: skip
def test_what_the_shell_offers(examples, tmp_path, line, there, not_there):
    shutil.copy(examples / "deburr_compliant_spindle.yaml", tmp_path / "edge.yaml")
    words, errors = offered(line, tmp_path)
    assert set(there.split()) <= set(words)
    assert not_there not in words
    assert errors == ""


def test_completion_loads_no_engine(examples, tmp_path):
    shutil.copy(examples / "deburr_compliant_spindle.yaml", tmp_path / "edge.yaml")
    heavy = "{'numba', 'scipy.optimize', 'xarray.core', 'matplotlib', 'pandas', 'starlette', 'uvicorn', 'OCP'}"
    report = f"atexit.register(lambda: print(sorted({heavy} & set(sys.modules)), file=sys.stderr))"
    for line in ("cutwise run edge.yaml --set spindle.p", "cutwise new d", "cutwise library tools s"):
        words, errors = offered(line, tmp_path, report)
        assert words
        assert errors.strip() == "[]"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "powershell"])
def test_a_script_for_each_shell(cutwise, monkeypatch, shell):
    """Which shell it is, the library asks of the processes above, where a background job has none."""
    monkeypatch.setattr("shellingham.detect_shell", lambda *_: (shell, shell))
    said = cutwise("--show-completion", shell)
    assert said.code == 0
    assert "_CUTWISE_COMPLETE" in said.out
