"""Inputs that go together: correlations, the covariance of a measured entry, curves along the edge; rare failures of a study."""

import json
import shlex

import numpy as np
import pytest
from scipy import stats

from cutwise.app.cli import main
from cutwise.io.scenario import load
from cutwise.process.recipes import quick_outcome
from cutwise.spec.faults import ScenarioFault
from cutwise.study.many import engine, rarely
from cutwise.study.many import folder as at
from cutwise.study.many.answers import answers, command
from cutwise.study.many.cases import rows, scenario_of
from cutwise.study.many.definition import columns, points
from cutwise.study.many.packing import pack, unpack
from cutwise.study.many.reading import read_study

TEXT = """
name: together
scenario: {examples}/deburr_compliant_spindle.yaml
set: {{operation.feed: 70 mm/s}}
vary:
  part.burr.height: {{normal: {{mean: 0.7 mm, deviation: 0.1 mm}}, within: [0 mm, null]}}
  part.burr.width: {{lognormal: {{median: 1 mm, log_deviation: 0.15}}}}
  spindle.pressure: {{uniform: [4.8 bar, 5.2 bar]}}
correlated: [{{keys: [part.burr.width, spindle.pressure], correlation: {rho}}}]
method: monte_carlo
cases: 4000
seed: 4
"""
CURVES = """
name: curves
scenario: {examples}/deburr_compliant_spindle.yaml
vary:
  part.burr.height: {{field: {{mean: 0.7 mm, deviation: 0.1 mm, correlation_length: 8 mm}}}}
  spindle.pressure: {{uniform: [4.8 bar, 5.2 bar]}}
method: {method}
cases: 8
seed: 6
"""
ENTRY = """
name: measured
describes: coefficients of a test
values:
  K_tc: {value: 2000 N/mm^2, status: measured, source: a test}
  K_rc: {value: 1200 N/mm^2, status: measured, source: a test}
  K_ac: {value: 800 N/mm^2, status: measured, source: a test}
  K_te: {value: 3 N/mm, status: measured, source: a test}
  K_re: {value: 2 N/mm, status: measured, source: a test}
  K_ae: {value: 0 N/mm, status: measured, source: a test}
covariances:
  cut:
    of: [K_tc, K_te]
    matrix: [[4.0e14, -1.2e10], [-1.2e10, 1.0e6]]
    degrees_of_freedom: 12
"""


@pytest.fixture
def study(examples, tmp_path):
    def make(text, **words):
        file = tmp_path / "study.yaml"
        file.write_text(text.format(examples=examples, **words), encoding="utf-8")
        return read_study(file)

    return make


def drawn(planned, count=4000):
    return {key: np.array(values) for key, values in columns(planned, 0, count).items()}


@pytest.mark.parametrize("rho", [-0.8, 0.4, 0.95])
def test_scores_are_correlated_and_margins_stay(study, rho):
    planned = study(TEXT, rho=rho)
    u = points(planned, 0, 4000)
    z = stats.norm.ppf(u)
    assert np.corrcoef(z.T)[1, 2] == pytest.approx(rho, abs=4 * (1 - rho**2) / np.sqrt(4000))
    assert np.corrcoef(z.T)[0, 1] == pytest.approx(0.0, abs=0.07)
    for column in u.T:
        assert stats.kstest(column, "uniform").pvalue > 1e-3
    pressure = drawn(planned)["spindle.pressure"]
    assert pressure.min() >= 4.8e5
    assert pressure.max() <= 5.2e5


def test_no_correlation_is_none_to_the_last_bit(study):
    free = study(TEXT.replace("correlated:", "# correlated:"), rho=0)
    assert np.array_equal(points(study(TEXT, rho=0.0), 0, 64), points(free, 0, 64))


def test_a_part_of_a_study_has_its_correlated_values(study):
    planned = study(TEXT, rho=0.6)
    whole = points(planned, 0, 40)
    assert np.array_equal(points(planned, 17, 5), whole[17:22])
    again = unpack(json.loads(json.dumps(pack(planned))))
    assert np.array_equal(points(again, 0, 40), whole)


def test_correlated_inputs_are_one_factor_of_the_indices(study):
    planned = study(TEXT.replace("monte_carlo", "indices").replace("4000", "8"), rho=0.5)
    assert planned.factor_names == ("part.burr.height", "part.burr.width+spindle.pressure")
    assert planned.cases == 8 * 4
    u = points(planned, 0, 4)  # A, B, A with the height of B, A with both others of B
    assert np.array_equal(u[2], [u[1, 0], u[0, 1], u[0, 2]])
    assert np.array_equal(u[3], [u[0, 0], u[1, 1], u[1, 2]])


def test_a_measured_entry_scatters_as_its_covariance_says(study, tmp_path):
    (tmp_path / "mine.yaml").write_text(ENTRY, encoding="utf-8")
    text = TEXT.replace("set: {{", f"set: {{{{material.library: {tmp_path}/mine.yaml, ").replace(
        "correlated: [{{keys: [part.burr.width, spindle.pressure], correlation: {rho}}}]",
        "correlated: [{{entry: material.library}}]",
    )
    planned = study(text)
    assert list(planned.random)[-2:] == ["material.K_tc", "material.K_te"]
    values = drawn(planned)
    both = np.array([values["material.K_tc"], values["material.K_te"]])
    found = np.cov(both)
    assert both.mean(axis=1) == pytest.approx([2e9, 3e3], rel=0.01)
    assert found[0, 0] == pytest.approx(4e14, rel=0.1)
    assert found[1, 1] == pytest.approx(1e6, rel=0.1)
    assert found[0, 1] == pytest.approx(-1.2e10, rel=0.1)
    one = scenario_of(planned, rows(columns(planned, 3, 1))[0])
    assert one.material.K_tc == values["material.K_tc"][3]
    with pytest.raises(ScenarioFault, match=r"material.K_tc is moved twice"):
        study(text.replace("correlated:", "  material.K_tc: {{uniform: [1 N/mm^2, 2 N/mm^2]}}\ncorrelated:"))


def test_the_springs_of_a_measured_robot(study):
    """Their reciprocals are normal, six together, in a list."""
    text = (
        "name: springs\nscenario: {examples}/drill_robot.yaml\nset: {{robot.library: fanuc_r2000ic}}\n"
        "correlated: [{{entry: robot.library}}]\nmethod: monte_carlo\ncases: 6000\nseed: 1\n"
    )
    planned = study(text)
    keys = [f"robot.joint_stiffness[{i}]" for i in range(6)]
    assert list(planned.random) == keys
    values = drawn(planned, 6000)
    flexibility = 1.0 / np.array([values[key] for key in keys])
    (covariance,) = planned.scenario.covariances.values()
    matrix = np.array(covariance.matrix)
    sd = np.sqrt(np.diagonal(matrix))
    assert flexibility.std(axis=1) == pytest.approx(sd, rel=0.05)
    assert np.corrcoef(flexibility) == pytest.approx(matrix / np.outer(sd, sd), abs=0.06)
    one = scenario_of(planned, rows(columns(planned, 5, 1))[0])
    assert one.robot.joint_stiffness == pytest.approx([values[key][5] for key in keys], rel=1e-12)


def test_a_curve_is_another_in_each_case_and_runs_again(study, examples, tmp_path):
    planned = study(CURVES, method="sobol")
    engine.run_study(planned, tmp_path / "s", chunk=4)
    found = answers(planned, tmp_path / "s", 4)
    error = found.table["measure surface_error_max"]
    assert len(set(error.tolist())) == 8
    words = shlex.split(command(found, 3))[3:][1::2]
    alone = quick_outcome(load(examples / "deburr_compliant_spindle.yaml", words), coarse=True).measures
    assert error[3] == pytest.approx(alone["surface_error_max"], abs=1e-11)  # pressure is shown with 8 digits


def test_curves_under_indices_are_redrawn_where_they_are_the_factor(study):
    planned = study(CURVES, method="indices")
    numbers = drawn(planned, 8)["part.burr.height"].tolist()
    assert numbers == [0, 1, 1, 0, 2, 3, 3, 2]  # A, B, A with the curve of B, A with the pressure of B


RARE = TEXT.replace("monte_carlo", "rare").replace("4000", "100").replace(
    "set: {{", "set: {{requirements: '{{surface_error_max: {{max: 0.15 mm}}}}', "
)  # fmt: skip


def call(capsys, *words):
    with pytest.raises(SystemExit) as end:
        main(list(map(str, words)))
    return end.value.code, capsys.readouterr()


def test_rare_failures_of_a_study_are_the_same_after_a_restart(study, tmp_path, capsys):
    planned = study(RARE, rho=0.3)
    found = rarely.rarely(planned, tmp_path / "s")
    assert 0.0 < found.found.low < found.found.probability < found.found.high < 0.2
    parts = sorted((tmp_path / "s" / "parts").glob("*.nc"))
    for file in parts[len(parts) // 2 :]:
        file.unlink()
    with pytest.raises(ScenarioFault, match="trials are there: add --resume"):
        rarely.rarely(planned, tmp_path / "s")
    assert call(capsys, "report", tmp_path / "s")[0] == 0
    assert "failures are rarer than" in (tmp_path / "s" / "report.html").read_text()
    so_far = rarely.told(planned, tmp_path / "s", at.identity_in(tmp_path / "s"))
    assert so_far.unfinished
    assert "failure_probability" not in so_far.measures
    again = rarely.rarely(planned, tmp_path / "s", resume=True)
    assert again.found.probability == found.found.probability
    assert np.array_equal(again.table["margin"], found.table["margin"])
    code, told = call(capsys, "report", tmp_path / "s", "-o", tmp_path / "page.html")
    assert (code, f"P(fails) = {found.found.probability:.3g}" in told.out) == (0, True)
    assert call(capsys, "export", tmp_path / "s", "-o", tmp_path / "all.csv")[0] == 0
    assert (tmp_path / "all.csv").read_text().count("\n") == found.done + 1


def test_rare_failures_agree_with_many_plain_cases(study, tmp_path):
    """A failure that is not so rare: levels and plain Monte Carlo of 1,000 cases."""
    found = rarely.rarely(study(RARE.replace("cases: 100", "cases: 500"), rho=0.0), tmp_path / "s")
    plain = study(RARE.replace("rare", "monte_carlo").replace("cases: 100", "cases: 1000"), rho=0.0)
    engine.run_study(plain, tmp_path / "p", chunk=500)
    share = 1.0 - answers(plain, tmp_path / "p", 500).shares[0][1].value
    together = np.hypot(found.found.cov * found.found.probability, np.sqrt(share / 1000))
    assert found.found.probability == pytest.approx(share, abs=3.5 * together)


def test_rare_from_the_command_line(examples, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = RARE.format(examples=examples, rho=0.0) + "want: {probability: {min: 0.9999}}\n"
    (tmp_path / "s.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(SystemExit) as end:
        main(["study", "s.yaml", "-o", "out", "--json", "--table", "all.csv"])
    answer = json.loads(capsys.readouterr().out)
    assert end.value.code == 1
    assert answer["verdict"] == "fail"
    assert 0.0 < answer["measures"]["failure_probability"]["value"] < 0.2
    assert "How far the cases of each level" in (tmp_path / "out" / "report.html").read_text()
    assert (tmp_path / "all.csv").read_text().startswith("case,part.burr.height [m]")
