"""The command line: exit codes, what goes to which stream, and files that are whole or not there."""

import contextlib
import json
import os
import re
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import typer.testing

from cutwise.app import cli
from cutwise.disk import file_name
from cutwise.io.scenario import load
from cutwise.results import Finding, Place, SolverFailure

SOURCES = Path(cli.__file__).parent.parent.parent
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(SOURCES), "COLUMNS": "80"}


def typed(*arguments, cwd, **options):
    """The command line in a process of its own."""
    words = [sys.executable, "-m", "cutwise", *map(str, arguments)]
    return subprocess.run(words, cwd=cwd, env=ENVIRONMENT, capture_output=True, text=True, timeout=120, **options)


@pytest.fixture
def example(examples):
    return examples / "deburr_compliant_spindle.yaml"


@pytest.fixture
def quick(made_up, monkeypatch):
    """Runs that take no time: ``quick(error=...)`` chooses what they give, an exception is raised."""
    chosen = {"outcome": made_up()}

    def simulated(*_):
        if isinstance(chosen["outcome"], BaseException):
            raise chosen["outcome"]
        return chosen["outcome"]

    monkeypatch.setattr(cli, "_simulated", simulated)

    def choose(outcome=None, **parts):
        chosen["outcome"] = outcome if outcome is not None else made_up(**parts)

    return choose


def test_help_names_every_command():
    found = typer.testing.CliRunner().invoke(cli.app, ["--help"])
    assert found.exit_code == 0
    for command in ("new", "check", "run", "report", "library", "schema", "doctor", "selftest", "advise", "sweep"):
        assert re.search(rf"\b{command}\b", found.output), command


def test_help_is_quick(tmp_path):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert typed("--help", cwd=tmp_path).returncode == 0
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 0.5


def test_version(cutwise):
    said = cutwise("--version")
    assert (said.code, said.out) == (0, f"cutwise {cli.cutwise.__version__}\n")


def test_run_that_meets_its_requirements(cutwise, quick, example):
    quick(error=1e-5)
    said = cutwise("run", example)
    assert said.code == 0
    assert "PASS: all 3 requirements are met" in said.out
    assert re.search(r"surface_error_max +0\.0100 +mm +at most 0\.05 mm +pass", said.out)
    assert re.search(r"\d+ of \d+ input values are assumed", said.out)
    folder = Path("cutwise-runs") / "deburr_compliant_spindle"
    assert sorted(file.name for file in folder.iterdir()) == ["report.html", "run.nc"]
    for file in folder.iterdir():
        assert str(file) in said.out


def test_run_that_is_not_sound_fails_with_its_reason_first(cutwise, quick, example):
    stopped = Finding("at_stop", Place(time=0.324), 5e-3, 5e-3, "length")
    quick(error=1e-5, findings=(stopped, Finding("moves", value=1e-6, measure="surface_error_max", dimension="length")))
    said = cutwise("run", example)
    assert said.code == 1
    assert (
        "FAIL: the tool is dragged to the stop of the spindle: a piston used its whole stroke (t = 0.324 s)" in said.out
    )
    assert "warning: surface_error_max moves by 0.001 mm (10 %)" in said.out
    page = (Path("cutwise-runs") / "deburr_compliant_spindle" / "report.html").read_text(encoding="utf-8")
    assert "Not sound:</b> the tool is dragged to the stop" in page
    told = json.loads(cutwise("run", example, "--json", "--no-report").out)
    assert list(told)[2:5] == ["verdict", "certainty", "reasons"]
    assert told["reasons"] == [
        "the tool is dragged to the stop of the spindle: a piston used its whole stroke (t = 0.324 s)"
    ]
    assert told["findings"][0] == {
        "code": "at_stop", "decides": True, "where": {"time": 0.324}, "value": 5e-3, "limit": 5e-3, "unit": "m",
        "dimension": "length",
    }  # fmt: skip


def test_run_that_fails_a_requirement(cutwise, quick, example, tmp_path):
    quick(error=8e-5, warnings=("lower the preset",))
    said = cutwise("run", example, "-o", tmp_path / "here", "--no-report")
    assert said.code == 1
    assert "FAIL by 0.03 mm" in said.out
    assert "FAIL: 1 of 3 requirements not met: surface_error_max" in said.out
    assert "warning: lower the preset" in said.out
    assert [file.name for file in (tmp_path / "here").iterdir()] == ["run.nc"]


def test_infeasible_operation(cutwise, quick, example):
    quick(infeasible=("the tool is 0.2 mm thicker than the hole",))
    said = cutwise("run", example)
    assert said.code == 1
    assert "infeasible: the tool is 0.2 mm thicker than the hole" in said.out


@pytest.mark.parametrize(
    "arguments",
    [
        ("run", "missing.yaml"),
        ("run", "{example}", "--set", "operation.feed=80"),
        ("run", "{example}", "--set", "operation.fed=80 mm/s"),
        ("check", "{example}", "--set", "tool.diameter=-1 mm"),
        ("run", "{example}", "--no-such-option"),
        ("run",),
        ("rnu", "{example}"),
        ("new", "no-such-process"),
        ("schema", "no-such-process"),
        ("library", "no-such-shelf"),
        ("library", "spindles", "no-such-entry"),
        ("report", "{example}"),
        ("report", "missing.nc"),
    ],
    ids=" ".join,
)
def test_bad_input(cutwise, arguments, example):
    said = cutwise(*(argument.format(example=example) for argument in arguments))
    assert said.code == 2
    assert said.out == ""
    assert said.err.strip()
    assert "Traceback" not in said.err
    assert list(Path().iterdir()) == []


def test_all_faults_at_once(cutwise, example):
    said = cutwise("check", example, "--set", "operation.feed=80", "--set", "tool.diametre=8 mm")
    assert "operation.feed" in said.err
    assert "tool.diameter" in said.err
    assert "2 faults, nothing was run" in said.err


def test_output_that_cannot_be_written_is_refused_before_the_run(cutwise, quick, example):
    quick(AssertionError("the run was started"))
    Path("file").write_text("no folder")
    said = cutwise("run", example, "-o", "file/below")
    assert said.code == 2
    assert "is a file, not a folder" in said.err


def test_disk_that_fails_while_writing(cutwise, quick, example, monkeypatch):
    quick()

    def full(*_, **__):
        raise OSError(28, "No space left on device", "run.nc")

    monkeypatch.setattr("xarray.DataTree.to_netcdf", full)
    said = cutwise("run", example, "-o", "out")
    assert said.code == 2
    assert said.err == "run.nc: the disk is full; nothing was written: free some room, or write elsewhere\n"
    assert list(Path().iterdir()) == []


def test_solver_that_fails(cutwise, quick, example):
    quick(SolverFailure("contact at t = 0.1 s; use a smaller numerics.time_step"))
    said = cutwise("run", example)
    assert said.code == 3
    assert said.err == "the solver failed: contact at t = 0.1 s; use a smaller numerics.time_step\n"
    assert list(Path().iterdir()) == []


def test_own_errors_show_a_traceback_only_when_asked(cutwise, quick, example):
    quick(ZeroDivisionError("nothing to divide by"))
    said = cutwise("run", example)
    assert said.code == 3
    assert "ZeroDivisionError" in said.err
    assert "Traceback" not in said.err
    with pytest.raises(ZeroDivisionError):
        cli.main(["run", str(example), "--debug"])


def test_interrupted_run_leaves_nothing(cutwise, quick, example):
    quick(KeyboardInterrupt())
    said = cutwise("run", example)
    assert said.code == 130
    assert list(Path().iterdir()) == []


@pytest.fixture
def heard():
    """Interrupts as in the foreground, even where the tests run in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heard")
@pytest.mark.parametrize("fate", ["swallowed", "turned into an error"])
def test_interrupt_that_a_library_loses(cutwise, quick, example, made_up, monkeypatch, fate):
    """The compiler calls back from C, where an exception goes nowhere, or ends as an error of another kind."""

    def simulated(*_):
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        if fate != "swallowed":
            raise RuntimeError("no compiled object yet")
        return made_up()

    quick()
    monkeypatch.setattr(cli, "_simulated", simulated)
    said = cutwise("run", example)
    assert (said.code, said.out, said.err) == (130, "", "interrupted\n")
    assert list(Path().iterdir()) == []
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.slow
@pytest.mark.usefixtures("heard")
@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT between processes")
@pytest.mark.parametrize("after", [0.05, 0.3, 1.0, 2.0])
def test_ctrl_c_leaves_no_broken_file(example, tmp_path, after):
    """A run of a minute of simulated time, so that it is certainly stopped on its way.

    Python ends itself by the signal where the interrupt met it inside an ``exec``: a shell shows 130 both ways.
    """
    begun = "import cutwise.__main__ as it; print('on', flush=True); it.main()"
    words = [sys.executable, "-c", begun, "run", str(example), "--set", "operation.duration=60 s", "-o", "out"]
    process = subprocess.Popen(
        words, cwd=tmp_path, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "on\n"
    time.sleep(after)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=120)
    assert process.returncode in (130, -signal.SIGINT)
    assert errors == "interrupted\n"
    assert not list(tmp_path.rglob("*"))


@pytest.mark.slow
def test_json_is_one_object_and_nothing_else(example, tmp_path):
    said = typed("run", example, "--json", "-o", "out", cwd=tmp_path)
    assert said.returncode == 0, said.stderr
    assert said.stdout.count("\n") == 1
    told = json.loads(said.stdout, parse_constant=lambda name: pytest.fail(f"{name} in JSON"))
    assert told["verdict"] == "pass"
    assert told["process"] == "deburr"
    assert told["measures"]["surface_error_mean"]["unit"] == "m"
    assert told["measures"]["surface_error_mean"]["value"] == pytest.approx(-9.45e-6, abs=1e-7)
    assert {check["pass"] for check in told["requirements"]} == {True}
    assert set(told["files"]) == {"run", "report"}
    assert all((tmp_path / place).is_file() for place in told["files"].values())


def test_json_of_a_failed_run_is_an_object_too(cutwise, quick, example):
    quick(error=1.0)
    said = cutwise("run", example, "--json", "--no-report")
    assert said.code == 1
    assert json.loads(said.out)["verdict"] == "fail"


def test_run_file_gives_the_report_again(cutwise, quick, example):
    quick()
    cutwise("run", example, "-o", "out", "--no-report")
    said = cutwise("report", "out")
    assert (said.code, said.out) == (0, f"{Path('out/report.html')}\n")
    assert "</html>" in Path("out/report.html").read_text(encoding="utf-8")
    assert cutwise("report", "out/run.nc", "-o", "other.html").code == 0
    assert Path("other.html").is_file()


def test_damaged_run_file(cutwise, quick, example):
    quick()
    cutwise("run", example, "-o", "out", "--no-report")
    whole = Path("out/run.nc").read_bytes()
    Path("out/run.nc").write_bytes(whole[: len(whole) // 2])
    said = cutwise("report", "out")
    assert said.code == 2
    assert "run.nc" in said.err


def test_new_scenario_is_without_fault(cutwise):
    assert cutwise("new", "deburr", "-o", "mine.yaml").code == 0
    said = cutwise("check", "mine.yaml")
    assert said.code == 0
    assert "mine.yaml: no fault" in said.out
    again = cutwise("new", "deburr", "-o", "mine.yaml")
    assert again.code == 2
    assert "is there already" in again.err
    assert cutwise("new", "deburr", "-o", "-").out.startswith("#")


def test_names_that_are_no_folder_names():
    assert file_name("..") == "unnamed"
    assert file_name("a:b*c") == "a_b_c"
    assert file_name("Kante 1") == "Kante 1"


def test_library(cutwise):
    shelves = cutwise("library")
    assert shelves.code == 0
    assert "spindles" in shelves.out
    entry = cutwise("library", "spindles", "berselli2016")
    assert re.search(r"piston_force +7\.70 N +paper +Berselli et al\. 2016, sec\. 4", entry.out)


def test_schema(cutwise):
    assert json.loads(cutwise("schema", "deburr").out)["$schema"]


def test_doctor(cutwise, monkeypatch):
    assert cutwise("doctor").code == 0
    monkeypatch.setattr("cutwise.app.installation._NEEDED", ("no-such-package",))
    said = cutwise("doctor")
    assert said.code == 1
    assert re.search(r"FAIL +no-such-package +not installed +pip install no-such-package", said.out)


def test_selftest(cutwise, monkeypatch):
    from cutwise.process import selfchecks

    good = selfchecks.SelfCheck("a length", "a book", "length", 1e-3, 1e-6, lambda: 1.0005e-3)
    monkeypatch.setattr(selfchecks, "CHECKS", [good])
    said = cutwise("selftest")
    assert said.code == 0
    assert re.search(r"pass +a length +1\.0005 mm +1 mm +0\.0005 mm +0\.001 mm +a book", said.out)
    monkeypatch.setattr(selfchecks, "CHECKS", [good, good._replace(compute=lambda: 1.1e-3)])
    said = cutwise("selftest")
    assert said.code == 1
    assert "1 of 2 checks pass" in said.out


@pytest.mark.slow
def test_selftest_of_this_installation():
    from cutwise.process.selfchecks import CHECKS, outcomes

    for outcome in outcomes(CHECKS):
        assert outcome.passed, outcome


def test_piped_text_is_plain(example, tmp_path):
    said = typed("check", example, cwd=tmp_path)
    assert said.returncode == 0
    assert "\x1b" not in said.stdout + said.stderr


def test_terminal_that_lacks_letters(example, tmp_path):
    """ASCII output gets question marks, not a traceback."""
    words = [sys.executable, "-m", "cutwise", "library", "materials"]
    environment = {**ENVIRONMENT, "PYTHONIOENCODING": "ascii"}
    said = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, timeout=60)
    assert said.returncode == 0, said.stderr
    assert example.exists()


def test_report_is_a_scenario_file(cutwise, quick, example):
    quick()
    cutwise("run", example, "-o", "out")
    assert load("out/report.html") == load(example)
    said = cutwise("check", "out/report.html", "--set", "operation.feed=60 mm/s")
    assert said.code == 0
