"""Milling on the command line: the example, its report, and bad input in words."""

import json

import pytest


@pytest.fixture
def corner(examples):
    return examples / "mill_pocket_corner.yaml"


def test_the_corner_example_as_json(cutwise, corner, tmp_path):
    found = cutwise("run", corner, "--json", "-o", tmp_path / "out")
    assert found.code == 0, found.err
    said = json.loads(found.out)
    values = {name: measure["value"] for name, measure in said["measures"].items()}
    assert values["contour_error_max"] == pytest.approx(3.578e-6, abs=0.01e-6)
    assert values["cycle_time"] == pytest.approx(1.6131370850, abs=1e-9)
    assert values["cycle_time_ideal"] == pytest.approx(1.5, abs=1e-12)
    assert values["force_xy_peak"] == pytest.approx(562.11, rel=1e-3)
    assert values["engagement_angle_max"] == pytest.approx(2.498091545, abs=1e-8)
    assert "machine.limits.jerk" in said["assumed"]
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for words in (
        "kp_ki_swapped",
        "Where the path is left most",
        "Corner strategies",
        "Frequency response",
        "fillet 5 mm",
    ):
        assert words in page
    again = cutwise("run", tmp_path / "out" / "run.nc", "--json", "--no-advice", "-o", tmp_path / "again")
    assert json.loads(again.out)["measures"] == said["measures"]


def test_a_program_runs_again_from_its_run_file(cutwise, examples, tmp_path):
    bare = ("--json", "--no-advice", "--no-report")
    first = json.loads(cutwise("run", examples / "mill_pocket.yaml", *bare, "-o", tmp_path / "out").out)
    again = json.loads(cutwise("run", tmp_path / "out" / "run.nc", *bare, "-o", tmp_path / "again").out)
    assert again["measures"] == first["measures"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("machine.limits.acceleration=0 mm/s^2", "must be above 0"),
        ("operation.radial_depth=21 mm", "is more than the diameter of the mill (20 mm)"),
        ("machine.x.K_d=0 V s/mm", "position loop of x is unstable"),
        ("path.corner=40 mm", "takes the whole lead"),
        ("machine.reading=printed", "as_printed"),
        ("operation.feed=40", "has no unit"),
    ],
)
def test_bad_input_is_named(cutwise, corner, change, words):
    found = cutwise("run", corner, "--set", change)
    assert found.code == 2
    assert words in " ".join(found.err.split())
    assert "Traceback" not in found.err


def test_a_new_scenario_runs(cutwise):
    assert cutwise("new", "mill").code == 0
    found = cutwise("run", "mill.yaml", "--json", "--no-advice")
    assert json.loads(found.out)["verdict"] == "pass"
