"""``cutwise calibrate``: entry, page, JSON, exit codes."""

import json

import pytest

from cutwise.io import library


@pytest.fixture
def loads(examples):
    return examples / "measured" / "fanuc_r2000ic" / "loads.csv"


ARM = ("--set", "robot.library=fanuc_r2000ic")


def test_an_entry_a_page_and_what_is_weak(cutwise, loads, tmp_path):
    entry, page = tmp_path / "my_arm.yaml", tmp_path / "page.html"
    found = cutwise("calibrate", "robot-stiffness", loads, *ARM, "-o", entry, "--report", page)
    assert found.code == 1
    for words in (
        "860896 ± 3.05e+04",
        "joint_stiffness[5] is weak",
        "line 19 (row 17), 4.114",
        "measure next",
        "19.47%",
    ):
        assert words in found.out
    text = page.read_text()
    for words in ("Not identified", "Correlations", "<svg", "137.52"):
        assert words in text
    assert "http" not in text.replace("http://www.w3.org", "")
    read = library.read_entry(entry, str(entry), "robots")
    origins = {key: origin for key, _, origin in read.origins()}
    assert origins["joint_stiffness"].status == "measured"
    assert origins["joint_stiffness"].source == "loads.csv, 43 rows"
    assert origins["joints[0].origin"].status == "assumed"  # comes from the entry that it completes


def test_the_same_bytes_give_the_same_entry(cutwise, loads, tmp_path):
    one, two = tmp_path / "one" / "arm.yaml", tmp_path / "two" / "arm.yaml"
    for file in (one, two):
        file.parent.mkdir()
        cutwise("calibrate", "robot-stiffness", loads, *ARM, "-o", file)
    assert one.read_bytes() == two.read_bytes()
    assert "date:" not in one.read_text()
    cutwise("calibrate", "robot-stiffness", loads, *ARM, "--set", "measured.date=2026-03-01", "-o", two)
    assert "date: '2026-03-01'" in two.read_text()


def test_an_entry_runs(cutwise, loads, examples, tmp_path):
    """Standard errors and covariance do no harm where they are not used yet; the library's entry is the fitted one."""
    entry = tmp_path / "arm.yaml"
    cutwise("calibrate", "robot-stiffness", loads, *ARM, "-o", entry)
    measured = []
    for name in (entry, "fanuc_r2000ic"):
        told = cutwise("run", examples / "drill_robot.yaml", "--set", f"robot.library={name}", "--json", "--no-report",
                       "--no-advice", "-o", tmp_path / "run")  # fmt: skip
        assert told.code in (0, 1), told.err
        measured.append(json.loads(told.out)["measures"])
    assert measured[0] == measured[1]


def test_json_is_si(cutwise, loads):
    told = json.loads(cutwise("calibrate", "robot-stiffness", loads, *ARM, "--json").out)
    sixth = told["parameters"]["joint_stiffness[5]"]
    assert sixth["value"] == pytest.approx(206019.8, rel=1e-6)
    assert (sixth["unit"], sixth["verdict"]) == ("N*m/rad", "weak")
    assert told["outliers"] == [{"row": 17, "column": "deflection_x", "studentised": pytest.approx(4.114, abs=1e-3)}]
    assert told["next"]["row"] == 9
    assert told["left_out_error"] == pytest.approx(0.1947, abs=1e-4)
    assert told["covariances"]["springs"]["as"] == "reciprocal"
    assert told["ranges"]["joint1"] == pytest.approx([-2.18110306, -0.89966487])


def test_faults_of_settings_and_file_together(cutwise, tmp_path):
    file = tmp_path / "loads.csv"
    file.write_text("joint1 [rad]\n0\n")
    found = cutwise("calibrate", "robot-stiffness", file, *ARM, "--set", "fit.loss=l1", "--set", "fit.hold_out=0.7")
    assert found.code == 2
    for words in ("--set fit.loss", "linear, soft_l1", "--set fit.hold_out", "force_x: missing", "has 1 row"):
        assert words in found.err
    assert "Traceback" not in found.err


def test_no_such_kind_no_data_no_file(cutwise, tmp_path):
    for arguments, said in (
        (("robot-stifness",), "did you mean robot-stiffness"), (("robot-stiffness",), "name the measured data"),
        (("robot-stiffness", tmp_path / "none.csv", *ARM), "no such file"),
    ):  # fmt: skip
        found = cutwise("calibrate", *arguments)
        assert found.code == 2
        assert said in found.err


def test_an_empty_file_to_fill_in(cutwise):
    found = cutwise("calibrate", "robot-stiffness", "--template")
    assert found.code == 0
    assert found.out.splitlines()[-1].startswith("joint1 [rad], joint2 [rad]")


def test_the_data_is_not_overwritten(cutwise, loads):
    found = cutwise("calibrate", "robot-stiffness", loads, *ARM, "-o", loads)
    assert found.code == 2
    assert "would be overwritten" in found.err
