"""Process drill on the command line: exit codes, messages, files, report."""

import json

import pytest

from cutwise.app.cli import main


@pytest.fixture
def command(capsys, tmp_path, monkeypatch):
    """Run a command in an empty folder; exit code, standard output, standard error."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as left:
            main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        return int(left.value.code or 0), out, err

    return run


def test_a_run_prints_measures_as_json(command, examples):
    code, out, _ = command("run", examples / "drill_robot.yaml", "--json", "-o", "out")
    told = json.loads(out)
    assert code == 0
    assert told["process"] == "drill"
    assert told["verdict"] == "pass"
    assert told["measures"]["redundancy_angle"] == {"value": pytest.approx(0.4537856), "unit": "rad"}
    assert told["measures"]["hole_position_error_entry"]["value"] == pytest.approx(1.02e-6, rel=1e-2)
    assert "contact.friction" in told["assumed"]


def test_the_report_holds_every_plot(command, examples, tmp_path):
    command("run", examples / "drill_plate_pattern.yaml", "-o", "out")
    html = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert html.count("<svg") >= 6
    for text in (
        "Holes",
        "Thrust and torque over depth",
        "Compliance and skating",
        "The arm in its posture",
        "not validation",
    ):
        assert text.replace("not validation", "not as validation") in html
    code, _, _ = command("report", "out")
    assert code == 0


def test_out_of_reach_fails_with_the_margin(command, examples, tmp_path):
    code, out, err = command(
        "run", examples / "drill_robot.yaml", "--set", "hole.position=[3900 mm, 300 mm, 800 mm]", "-o", "out"
    )
    assert code == 1
    assert "out of reach" in out + err
    assert "866.5 mm too short" in out + err
    assert "out of reach" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_bad_input_is_named_all_at_once(command, examples):
    code, _, err = command(
        "run", examples / "drill_robot.yaml", "--set", "operation.feed_per_rev=-0.1 mm", "--set",
        "tool.flute_length=0 mm", "--set", "robot.urdf=none.urdf",
    )  # fmt: skip
    assert code == 2
    assert "feed_per_rev: -0.1 mm is impossible" in err
    assert "flute_length" in err
    assert "none.urdf: no such file" in err
    assert "3 faults, nothing was run" in err
    assert "Traceback" not in err


def test_check_warns_of_half_a_point_angle(command, examples):
    code, out, err = command("check", examples / "drill_robot.yaml", "--set", "tool.point_angle=59 deg")
    assert code == 0
    assert "looks like half the angle" in out + err


def test_a_new_scenario_runs(command):
    assert command("new", "drill")[0] == 0
    code, out, _ = command("run", "drill.yaml", "--no-report", "--no-advice", "-o", "out")
    assert code == 0
    assert "PASS" in out


def test_a_misspelt_process_is_named(command, tmp_path, examples):
    text = (examples / "drill_robot.yaml").read_text().replace("process: drill\n", "process: drilling\n")
    (tmp_path / "s.yaml").write_text(text)
    code, _, err = command("check", "s.yaml")
    assert code == 2
    assert "did you mean drill?" in err


def test_the_library_shows_robots_and_where_values_are_from(command):
    code, out, _ = command("library", "robots", "kr240_2")
    assert code == 0
    assert "assumed" in out
    assert "absurd" in out
