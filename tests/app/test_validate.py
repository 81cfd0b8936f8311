"""``cutwise validate``: rows with their bands and groups, recordings with axes and delay, and what is refused."""

import json

import numpy as np
import pytest

from cutwise.io.scenario import load
from cutwise.process.recipes import quick_outcome, simulate
from cutwise.study.recording import curves_of

ARM = ("--set", "robot.library=fanuc_r2000ic", "--set", "requirements={}")
FEEDS = (0.06, 0.08, 0.1, 0.12)


@pytest.fixture(scope="module")
def truth(examples):
    """Thrust and compliance at some feeds."""
    found = []
    for feed in FEEDS:
        given = {"robot.library": "fanuc_r2000ic", "requirements": "{}", "operation.feed_per_rev": f"{feed} mm"}
        found.append(quick_outcome(load(examples / "drill_robot.yaml", given)).measures)
    return found


@pytest.fixture
def rows(truth, tmp_path):
    """A file of thrust and compliance, off by chosen amounts."""

    def write(thrust=(0.0,) * 4, compliance=(0.0,) * 4, titles=None, groups="aabb"):
        file = tmp_path / "drilled.csv"
        lines = [titles or "operation.feed_per_rev [mm], thrust_max [N], compliance_axial [um/N], group, operator"]
        for k, feed in enumerate(FEEDS):
            t = truth[k]["thrust_max"] + thrust[k]
            c = truth[k]["compliance_axial"] * 1e6 + compliance[k]
            lines.append(f"{feed}, {float(t)!r}, {float(c)!r}, {groups[k]}, me")
        file.write_text("\n".join(lines))
        return file

    return write


def test_a_run_for_each_row(cutwise, rows, examples):
    file = rows(thrust=(3.0, -1.0, 3.0, -1.0), compliance=(0.1, -0.1, 0.5, -0.1))
    found = cutwise("validate", file, examples / "drill_robot.yaml", *ARM, "--json")
    assert found.code == 0, found.err
    told = json.loads(found.out)
    thrust = told["measures"]["thrust_max"]
    assert thrust["rms"] == pytest.approx(np.sqrt(5.0), rel=1e-6)
    assert thrust["bias"] == pytest.approx(-1.0, rel=1e-6)
    assert thrust["rows"] == 4
    assert thrust["correlation"] > 0.99
    compliance = told["measures"]["compliance_axial"]
    assert compliance["inside"] == 0.75  # sd 0.13 um/N: only 0.5 is outside
    assert told["groups"]["a"]["compliance_axial"]["inside"] == 1.0
    assert told["groups"]["b"]["compliance_axial"]["inside"] == 0.5
    assert told["groups"]["b"]["thrust_max"]["bias"] == pytest.approx(-1.0, rel=1e-6)
    assert any("columns that are not used: operator" in text for text in told["warnings"])
    assert any("scatter of the measurement is not known for thrust_max" in text for text in told["warnings"])
    assert "52 runs" not in found.out


def test_scatter_of_the_measurement_widens_the_band(cutwise, rows, examples, tmp_path):
    file = rows(thrust=(3.0, -1.0, 3.0, -1.0), compliance=(0.1, -0.1, 0.5, -0.1))
    page = tmp_path / "page.html"
    noise = "validate.noise={thrust_max: 1 N, compliance_axial: 0.3 um/N}"
    found = cutwise("validate", file, examples / "drill_robot.yaml", *ARM, "--set", noise, "--report", page)
    assert found.code == 0, found.err
    assert "4 rows, 52 runs" in found.err
    lines = {line.split("  ")[0]: line for line in found.out.splitlines()}
    assert "50.0%" in lines["thrust_max"]
    assert "100.0%" in lines["compliance_axial"]
    text = page.read_text()
    assert text.count("<svg") == 2
    assert "http" not in text.replace("http://www.w3.org", "")
    one = cutwise("validate", file, examples / "drill_robot.yaml", *ARM, "--set", "validate.noise=1 N", "--json")
    assert json.loads(one.out)["measures"]["thrust_max"]["inside"] == 0.5


def test_without_standard_errors_the_scatter_of_the_measurement_is_the_band(cutwise, examples, tmp_path):
    file = tmp_path / "drilled.csv"
    file.write_text("operation.feed_per_rev [mm], thrust_max [N]\n0.1, 165\n0.1, 168\n0.1, 180\n")
    found = cutwise("validate", file, examples / "drill_robot.yaml", "--set", "requirements={}", "--set", "validate.noise=3 N",
                    "--json")  # fmt: skip
    told = json.loads(found.out)
    assert told["measures"]["thrust_max"]["inside"] == pytest.approx(2.0 / 3.0)
    assert any("no value of the scenario has a standard error" in text for text in told["warnings"])
    bare = cutwise("validate", file, examples / "drill_robot.yaml", "--set", "requirements={}", "--json")
    assert "inside" not in json.loads(bare.out)["measures"]["thrust_max"]


def test_words_and_elements_of_lists_are_keys(cutwise, examples, tmp_path):
    file = tmp_path / "two.csv"
    file.write_text(
        "material.library, hole.position[2] [mm], compliance_axial [um/N]\nal2024, 800, 3\nti6al4v, 820, 3\n"
    )
    found = cutwise("validate", file, examples / "drill_robot.yaml", *ARM, "--set", "robot.redundancy_angle=26 deg",
                    "--set", "robot.joint_angles=null", "--set", "band.method=none", "--json")  # fmt: skip
    assert found.code == 0, found.err
    assert json.loads(found.out)["measures"]["compliance_axial"]["rows"] == 2


def test_rows_that_cannot_be_run_are_told(cutwise, examples, tmp_path):
    file = tmp_path / "two.csv"
    file.write_text("hole.position[0] [mm], compliance_axial [um/N]\n1900, 3\n9000, 3\n")
    found = cutwise("validate", file, examples / "drill_robot.yaml", *ARM, "--set", "band.method=none")
    assert found.code == 1
    assert "not run: line 3" in found.out


@pytest.mark.parametrize(
    ("text", "more", "said"),
    [
        ("operation.feed_per_rev [mm], thrustmax [N]\n0.1, 3\n", (), "thrust_max? (or begin"),
        ("operation.feed_per_rev [mm], thrust_max\n0.1, 3\n", (), "thrust_max: no unit"),
        ("operation.feed_per_rev [mm], thrust_max [mm]\n0.1, 3\n", (), '"mm" is not a unit of force'),
        ("operation.feed_per_rev [mm], thrust_max [N]\n0.1, x\n", (), '"x" is not a number'),
        ("operation.feed_per_rev [mm], thrust_max [N]\n-0.1, 3\n", (), ":2: operation.feed_per_rev: -0.0001 m is"),
        ("", (), "is empty; it needs a title line\n"),
        ("thrust_max [N]\n3\n", ("--set", "validate.noise=3 bar"), "has the unit of none of thrust_max"),
        ("thrust_max [N]\n3\n", ("--set", "validate.nois=3 bar"), "did you mean"),
        ("thrust_max [N]\n3\n", ("--set", "validate.noise={thrust: 3 N}"), "thrust is no column"),
    ],
)
def test_bad_input(cutwise, examples, tmp_path, text, more, said):
    file = tmp_path / "rows.csv"
    file.write_text(text)
    found = cutwise("validate", file, examples / "drill_robot.yaml", *ARM, *more)
    assert found.code == 2
    assert said in found.err
    assert "Traceback" not in found.err


SHORT = ("--set", "operation.duration=0.12 s", "--set", "operation.lead_in_time=0.05 s", "--set", "requirements={}")


@pytest.fixture(scope="module")
def edge(examples):
    """Forces of a short pass on the work, with waves from the path."""
    given = {"operation.duration": "0.12 s", "operation.lead_in_time": "0.05 s", "requirements": "{}"}
    return curves_of(simulate(load(examples / "deburr_compliant_spindle.yaml", given)))


def recording(edge, file, late=0.0, turned=False, noise=0.0):
    time = np.arange(0.01, 0.11, 2e-4)
    columns = [np.interp(time, edge[f"burr_force_{a}"].time, edge[f"burr_force_{a}"].value) for a in "xyz"]
    columns = [one + noise * np.random.default_rng(3).normal(size=len(one)) for one in columns]
    if turned:  # measured on the work, x of the dynamometer along -y of the process
        columns = [columns[1], -columns[0], -columns[2]]
    lines = ["time [ms], burr_force_x [N], burr_force_y [N], burr_force_z [N]"]
    lines += [", ".join(f"{float(v)!r}" for v in row) for row in zip(1e3 * (time + late), *columns, strict=True)]
    file.write_text("\n".join(lines))
    return file


def test_a_recording_laid_over_a_run(cutwise, edge, examples, tmp_path):
    file = recording(edge, tmp_path / "pass.csv", late=0.013, turned=True)
    page = tmp_path / "page.html"
    found = cutwise("validate", file, examples / "deburr_compliant_spindle.yaml", *SHORT, "--set", "validate.delay=fit",
                    "--set", "data.axes=[y, -x, z]", "--set", "data.forces_on=work", "--json", "--report", page)  # fmt: skip
    assert found.code == 0, found.err
    told = json.loads(found.out)["recording"]
    assert told["delay"] == pytest.approx(0.013, abs=2e-5)
    for axis in "xyz":
        one = told[f"burr_force_{axis}"]
        assert one["mean"] == pytest.approx(one["measured_mean"], rel=1e-3, abs=1e-3)
        assert one["peak_to_peak"] == pytest.approx(one["measured_peak_to_peak"], rel=1e-2, abs=1e-3)
        assert one["rms"] < 0.02 * max(one["peak_to_peak"], 1e-3)
    assert page.read_text().count("<svg") == 3


def test_a_stated_delay_and_noise(cutwise, edge, examples, tmp_path):
    file = recording(edge, tmp_path / "pass.csv", late=0.013, noise=0.2)
    found = cutwise("validate", file, examples / "deburr_compliant_spindle.yaml", *SHORT, "--set", "validate.delay=13 ms",
                    "--json")  # fmt: skip
    told = json.loads(found.out)["recording"]
    assert told["delay"] == 0.013
    assert told["burr_force_y"]["rms"] == pytest.approx(0.2, rel=0.1)
    late = json.loads(cutwise("validate", file, examples / "deburr_compliant_spindle.yaml", *SHORT, "--json").out)
    assert late["recording"]["burr_force_y"]["rms"] > told["burr_force_y"]["rms"]


@pytest.mark.parametrize(
    ("text", "more", "said"),
    [
        ("time [s], burr_forcex [N]\n0, 1\n0.1, 1\n0.2, 1\n", (), "did you mean burr_force_x"),
        ("time [s], burr_force_x [N]\n0, 1\n0.05, 1\n0.04, 1\n", (), ":4: time does not rise"),
        ("time [s], burr_force_x [N]\n10, 1\n11, 2\n12, 1\n", (), "no time together"),
        ("time [s], burr_force_x [N]\n0, 1\n0.05, 1\n0.1, 1\n", ("--set", "validate.delay=fit"), "no column varies"),
        ("time [s], burr_force_x [N]\n0, 1\n0.05, 1\n0.1, 1\n", ("--set", "data.axes=[y, x, z]"), "needs burr_force_y"),
        ("time [s], burr_force_x [N]\n0, 1\n0.05, 1\n0.1, 1\n", ("--set", "validate.delay=soon"), "validate.delay"),
        ("time, burr_force_x [N]\n0, 1\n0.05, 1\n0.1, 1\n", (), "time: no unit"),
    ],
)
def test_bad_recordings(cutwise, examples, tmp_path, text, more, said):
    file = tmp_path / "pass.csv"
    file.write_text(text)
    found = cutwise("validate", file, examples / "deburr_compliant_spindle.yaml", *SHORT, *more)
    assert found.code == 2
    assert said in found.err
    assert "Traceback" not in found.err
