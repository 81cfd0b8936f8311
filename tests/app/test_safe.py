"""Inputs that outputs would overwrite, texts that steer machines, pipes that close, signals: nothing is lost or made up."""

import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

from cutwise.app import cli
from cutwise.io.scenario import load
from cutwise.study.sweep import save

SOURCES = Path(cli.__file__).parent.parent.parent
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(SOURCES), "COLUMNS": "80"}
WORDS = [sys.executable, "-m", "cutwise"]


@pytest.fixture
def here(cutwise, examples, made_up, monkeypatch, tmp_path):
    """Scenario, program and run file in the working folder; a run that is started fails the test."""

    def started(*_):
        pytest.fail("the run was started")

    monkeypatch.setattr(cli, "_simulated", started)
    monkeypatch.setattr("cutwise.study.case.quick_outcome", started)
    for source, name in (("chamfer_pipe_hole.yaml", "c.yaml"), ("mill_pocket.yaml", "m.yaml"), ("mill_pocket.nc",) * 2,
                         ("bracket.ngc", "p.ngc"), ("deburr_compliant_spindle.yaml", "d.yaml")):  # fmt: skip
        (tmp_path / name).write_text((examples / source).read_text())
    (tmp_path / "b.csv").write_text("w [mm], height [mm]\n0, 0.5\n90, 0.7\n")
    (tmp_path / "R").mkdir()
    made_up().save(tmp_path / "R" / "run.nc")
    (tmp_path / "link.out").symlink_to("c.yaml")
    (tmp_path / "sub").mkdir()
    return cutwise


@pytest.mark.parametrize(
    "words",
    [
        "report R/run.nc -o R/run.nc",
        "report R -o R/../R/run.nc",
        "run R/run.nc -o R",
        "run c.yaml --gcode c.yaml --apt other.apt",
        "run c.yaml --gcode link.out",
        "run c.yaml --gcode sub/../c.yaml",
        "run c.yaml --gcode a.nc --apt a.nc",
        "run c.yaml -o out --poses out/run.nc",
        "run c.yaml -o out --poses out",
        "run m.yaml -o x --gcode mill_pocket.nc",
        "sweep m.yaml --over operation.feed=30mm/s -o mill_pocket.nc",
        "sweep d.yaml --set part.burr.height=b.csv --over operation.feed=30mm/s -o b.csv",
        "sweep d.yaml --over operation.feed=30mm/s -o missing/../d.yaml/x.csv",
        "program p.ngc --svg p.ngc",
        "program p.ngc --svg mill_pocket.nc",
        "program p.ngc --svg sub",
        "spindle d.yaml -o d.yaml",
        "part c.step --svg c.step",
        "export R -o R/run.nc",
    ],
)
def test_outputs_that_would_overwrite_are_refused_before_anything_runs(here, words, tmp_path):
    before = {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()}
    said = here(*words.split())
    assert (said.code, said.out) == (2, "")
    assert any(text in said.err for text in ("would be overwritten", "two outputs", "is a folder", "is a file, not a"))
    assert {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()} == before


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="nothing is read-only to root")
def test_sweep_into_a_read_only_folder_is_refused_before(here, tmp_path):
    (tmp_path / "sub").chmod(0o500)
    said = here("sweep", "d.yaml", "--over", "operation.feed=30 mm/s,40 mm/s", "-o", "sub/s.csv")
    assert said.code == 2
    assert "permission denied" in said.err


@pytest.mark.parametrize("letter", [r"\r", r"\n", r"\0", r"\x1b", r"\x85", r"\u2028", r"\u202e", r"\ud800"])
@pytest.mark.parametrize("key", ["name", "tool.library", "operation.feed", "part.contact_length"])
def test_control_characters_are_refused_in_every_text(here, letter, key):
    value = f'"part7{letter}M3 S20000"'
    if "." in key and key != "tool.library":
        value = f"{{value: 50 mm/s, status: measured, source: {value}}}"
    said = here("check", "d.yaml", "--set", f"{key}={value}")
    assert said.code == 2
    assert "a control character (U+" in said.err or "half of a character (U+" in said.err
    assert "\x1b" not in said.err


def test_a_source_may_have_lines_in_the_file(examples, tmp_path):
    text = (examples / "deburr_compliant_spindle.yaml").read_text()
    lines = [line for line in text.splitlines() if not line.startswith("  preset:")]
    at = lines.index("operation:") + 1
    lines[at:at] = ["  preset:", "    value: 2 mm", "    status: measured", "    source: |", "      one", "      two"]
    (tmp_path / "d.yaml").write_text("\n".join(lines))
    assert load(tmp_path / "d.yaml").origins["operation.preset"].source == "one two"


def test_texts_of_tables_are_no_formulas(tmp_path):
    table = xr.Dataset({"power": ("tool.library", [1.0, -2.0, 3.0])}, {"tool.library": ["=1+1", "-5 deg", "@x"]})
    assert save(table, tmp_path / "s.csv").read_text().splitlines()[1:] == ["'=1+1,1.0", "−5 deg,-2.0", "'@x,3.0"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
@pytest.mark.parametrize(
    "words", ["schema > /dev/full", "library > /dev/full", "new deburr -o /dev/full", "report R -o /dev/full"]
)
def test_a_full_disk(here, words, tmp_path):
    line = f"{' '.join(WORDS)} {words}"
    said = subprocess.run(line, shell=True, cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True, timeout=120)
    assert said.returncode == 2
    assert "the disk is full" in said.stderr
    assert here is not None
    assert not list(tmp_path.rglob("*.part"))
    assert Path("/dev/full").is_char_device()


@pytest.mark.skipif(sys.platform == "win32", reason="no pipes of this kind")
@pytest.mark.parametrize("words", ["schema", "library", "library spindles default", "--help"])
def test_a_reader_that_goes_away(words, tmp_path):
    process = subprocess.Popen([*WORDS, *words.split()], cwd=tmp_path, env=ENVIRONMENT, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE)  # fmt: skip
    process.stdout.close()
    errors = process.stderr.read().decode()
    assert process.wait(timeout=120) in (0, 141)
    assert errors == ""


@pytest.mark.skipif(sys.platform == "win32", reason="streams are closed in another way")
@pytest.mark.parametrize("closed", [">&-", ">&- 2>&-", "<&- >&- 2>&-"])
def test_streams_that_are_closed_from_the_start(closed, tmp_path):
    line = f"{' '.join(WORDS)} new deburr -o d.yaml {closed}"
    said = subprocess.run(
        ["sh", "-c", line], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True, timeout=120
    )
    assert (said.returncode, said.stdout, "Traceback" in said.stderr) == (0, "", False)
    text = (tmp_path / "d.yaml").read_text()
    assert "process: deburr" in text
    assert "next: cutwise" not in text  # what is said does not go into the first file that is opened


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no SIGTERM between processes")
@pytest.mark.parametrize("after", [0.4, 3.0])
def test_termination_is_143_and_leaves_nothing(examples, tmp_path, after):
    words = [*WORDS, "run", examples / "deburr_compliant_spindle.yaml", "--set", "operation.duration=60 s", "-o", "out"]
    process = subprocess.Popen(words, cwd=tmp_path, env=ENVIRONMENT, stderr=subprocess.PIPE, text=True)
    time.sleep(after)
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=120)
    assert process.returncode in (143, -signal.SIGTERM)
    assert errors in ("terminated\n", "")
    assert not list(tmp_path.rglob("*"))


def test_a_report_does_not_outlive_its_run(cutwise, examples, made_up, monkeypatch):
    monkeypatch.setattr(cli, "_simulated", lambda *_: made_up())
    example = examples / "deburr_compliant_spindle.yaml"
    assert cutwise("run", example, "-o", "out").code == 0
    assert cutwise("run", example, "-o", "out", "--no-report").code == 0
    assert [file.name for file in Path("out").iterdir()] == ["run.nc"]


def change(path, **attributes):
    """A run file as another program leaves it: no seal, other attributes."""
    stream = io.BytesIO(path.read_bytes().rpartition(b"\ncutwise run file")[0])
    with h5py.File(stream, "r+") as file:
        for name, value in attributes.items():
            if value is None:
                del file.attrs[name]
            else:
                file.attrs[name] = value(file.attrs[name]) if callable(value) else value
    path.write_bytes(stream.getvalue())


def deep(text):
    data = json.loads(text)
    data["operation"]["feed"] = 0
    return json.dumps(data).replace('"feed": 0', '"feed": ' + "[" * 3000 + "]" * 3000)


CHANGES = {
    "no scenario": {"scenario": None},
    "a number": {"scenario": np.float64(3.0)},
    "deep": {"scenario": deep},
    "400 digits": {"scenario": lambda text: text.replace('"flutes": 20', f'"flutes": {"9" * 400}').replace("7.70 N", "9" * 400)},
    "surrogate": {"scenario": lambda text: text.replace('"source": "', '"source": "\\ud800', 1)},
    "no measures": {"measures": "[]"},
    "a measure": {"measures": '{"surface_error_max": [1e999, "length", "x"]}'},
    "a dimension": {"measures": '{"surface_error_max": [1, "lenght", "x"]}'},
    "verdict": {"summary": lambda text: text.replace('"pass": true', '"pass": "yes"')},
    "no summary": {"summary": "null"},
}  # fmt: skip


@pytest.mark.parametrize("how", CHANGES)
def test_run_files_that_were_tampered_with(here, how, tmp_path):
    change(tmp_path / "R" / "run.nc", **CHANGES[how])
    for words in ("report R -o r.html", "check R/run.nc", "run R/run.nc -o again", "export R"):
        if words.startswith(("run", "check")) and "scenario" not in CHANGES[how]:
            continue  # they read the scenario alone, which is sound
        said = here(*words.split())
        assert said.code == (0 if words.startswith("export") else 2), (words, said)
        assert "Traceback" not in said.err
        assert "error of its own" not in said.err
    assert not (tmp_path / "r.html").exists()


@pytest.mark.parametrize("value", ["9" * 400, "9" * 5000, "1e999", "-" + "9" * 400, "0x" + "f" * 400])
@pytest.mark.parametrize("key", ["tool.flutes", "operation.feed", "spindle.friction_preload_fraction", "path.points"])
def test_numbers_beyond_all_scales(here, key, value):
    said = here("check", "d.yaml", "--set", f"{key}={value}")
    assert said.code == 2
    assert len(said.err) < 2000


@pytest.mark.parametrize("word", ["LOADTL", "FEDRAT", "GOTO", "SPINDL", "DELAY", "CUTTER", "CIRCLE"])
def test_apt_numbers_beyond_all_scales(cutwise, word):
    Path("p.apt").write_text(f"UNITS/MM\nLOADTL/1\nFEDRAT/100,MMPM\nGOTO/0,0,1\n{word}/1e999\nFINI\n")
    assert cutwise("program", "p.apt").code in (0, 2)


def test_new_is_known_to_editors(cutwise):
    assert cutwise("new", "deburr").code == 0
    first, *_ = Path("deburr.yaml").read_text().splitlines()
    assert first == "# yaml-language-server: $schema=.cutwise/schema/deburr.json"
    assert json.loads(Path(first.rpartition("=")[2]).read_text())["$schema"]
    assert cutwise("check", "deburr.yaml").code == 0
    assert cutwise("new", "mill", "--no-schema", "-o", "m.yaml").code == 0
    assert "schema" not in Path("m.yaml").read_text()
    assert not Path(".cutwise/schema/mill.json").exists()
