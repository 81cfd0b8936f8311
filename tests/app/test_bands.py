"""Bands on the command line, in the report and in JSON: what an engineer reads about how sure a run is."""

import json

import pytest

ARM = ("--set", "robot.library=fanuc_r2000ic", "--no-advice")


@pytest.fixture
def drill(examples):
    return examples / "drill_robot.yaml"


def test_a_band_across_a_limit_is_a_pass_and_said(cutwise, drill, tmp_path):
    limit = "requirements={compliance_axial: {max: 2.7 um/N}}"
    found = cutwise("run", drill, *ARM, "--set", limit, "-o", tmp_path / "run")
    assert found.code == 0
    assert "band: 12 further runs (linear, 6 values with a standard error)" in found.err
    for words in (
        "2.359 … 2.796", "PASS, but not by every history: parameters leave "
        "2.36 … 2.8 µm/N, limit 2.7 µm/N (compliance_axial; kept with probability 0.822)",
        "most is carried by robot.joint_stiffness[1] 63%", "what the fit behind robot left, 220 µm",
        "not in it, for want of a standard error: 49 values",
    ):  # fmt: skip
        assert words in found.out
    html = (tmp_path / "run" / "report.html").read_text()
    for words in ("How sure this is", "Limit kept with probability", "0.822", "robot.joint_stiffness[1] 63%"):
        assert words in html
    again = cutwise("report", tmp_path / "run", "-o", tmp_path / "again.html")
    assert again.code == 0
    assert "How sure this is" in (tmp_path / "again.html").read_text()


def test_a_demanded_probability_decides(cutwise, drill, tmp_path):
    for probability, code in ((0.8, 0), (0.9, 1)):
        limit = f"requirements={{compliance_axial: {{max: 2.7 um/N, probability: {probability}}}}}"
        found = cutwise("run", drill, *ARM, "--set", limit, "--no-report", "--json", "-o", tmp_path / "run")
        told = json.loads(found.out)
        assert found.code == code
        assert told["verdict"] == ("pass" if code == 0 else "fail")
        check = told["requirements"][0]
        assert (check["probability"], check["pass"]) == (probability, code == 0)
        assert check["probability_reached"] == pytest.approx(0.8223, abs=1e-4)
        assert told["probability_all"] == pytest.approx(0.8223, abs=0.005)
        assert told["measures"]["compliance_axial"]["band"] == check["band"]
        assert told["band"]["residuals"] == {"robot": "0.00022002585155226522 m"}
        assert told["band"]["method"] == "linear"
    shown = cutwise("run", drill, *ARM, "--set", limit, "--no-report", "-o", tmp_path / "run")
    assert "FAIL (kept with probability 0.822, 0.9 is asked for)" in shown.out


def test_draws(cutwise, drill, tmp_path):
    sampled = ("--set", "band.method=sampled", "--set", "band.samples=50", "--set", "requirements={}")
    found = cutwise("run", drill, *ARM, *sampled, "--no-report", "--json", "-o", tmp_path / "run")
    told = json.loads(found.out)["band"]
    assert "band: 50 further runs" in found.err
    assert told["runs"] + told["thrown_away"] == 50
    assert told["seed"] == 1


def test_no_band_is_asked_for(cutwise, drill, tmp_path):
    found = cutwise("run", drill, *ARM, "--set", "band.method=none", "--no-report", "--json", "-o", tmp_path / "run")
    told = json.loads(found.out)
    assert "band" not in told
    assert "band" not in told["measures"]["compliance_axial"]


def test_keys_of_a_band_that_do_not_count_are_told(cutwise, drill):
    found = cutwise("check", drill, "--set", "band.samples=200")
    assert "band.samples: is not used: no value of the scenario has a standard error" in found.out
