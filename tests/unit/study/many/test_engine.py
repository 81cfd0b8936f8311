"""A study on disk: the same rows for any chunks, workers and restarts; faults of its file, all at once."""

import json
import os
import platform
import subprocess
import sys
import time

import numpy as np
import pytest

import cutwise
from cutwise.app.cli import main
from cutwise.io.scenario import load
from cutwise.process.recipes import quick_outcome
from cutwise.spec.faults import ScenarioFault
from cutwise.study.many import engine
from cutwise.study.many import folder as at
from cutwise.study.many.answers import answers, command, measures
from cutwise.study.many.cases import GOOD, evaluate, scenario_of
from cutwise.study.many.face import run_study
from cutwise.study.many.packing import pack, unpack
from cutwise.study.many.reading import read_study, told

TEXT = """
name: burrs
scenario: {examples}/deburr_compliant_spindle.yaml
set: {{operation.feed: 80 mm/s}}
vary:
  part.burr.height: {{normal: {{mean: 0.8 mm, deviation: 0.1 mm}}, within: [0 mm, null]}}
  part.burr.width: {{lognormal: {{median: 1 mm, log_deviation: 0.15}}}}
  spindle.pressure: {{uniform: [4.8 bar, 5.2 bar]}}
want: {{measures: [cutting_power_mean]}}
method: {method}
cases: {cases}
seed: 1
"""


@pytest.fixture
def study(examples, tmp_path):
    def make(text=TEXT, method="sobol", cases=32, **more):
        file = tmp_path / "study.yaml"
        file.write_text(text.format(examples=examples, method=method, cases=cases), encoding="utf-8")
        return read_study(file, **more)

    return make


def rows(planned, folder):
    return answers(planned, folder, at.identity_in(folder)["chunk"]).table


def same(a, b):
    return all(np.array_equal(a[name], b[name], equal_nan=a[name].dtype.kind == "f") for name in a)


def test_rows_do_not_depend_on_chunks_or_on_a_restart(study, tmp_path):
    planned = study()
    engine.run_study(planned, tmp_path / "one", chunk=32)
    engine.run_study(planned, tmp_path / "many", chunk=8)
    whole, parts = rows(planned, tmp_path / "one"), rows(planned, tmp_path / "many")
    assert same(whole, parts)
    (at.part_file(tmp_path / "many", 8, 8)).unlink()
    with pytest.raises(ScenarioFault, match="24 of 32 cases are there: add --resume"):
        engine.run_study(planned, tmp_path / "many")
    engine.run_study(planned, tmp_path / "many", resume=True)
    assert same(whole, rows(planned, tmp_path / "many"))


def test_a_longer_study_begins_with_the_shorter_one(study, tmp_path):
    engine.run_study(study(cases=16), tmp_path / "s", chunk=8)
    short = rows(study(cases=16), tmp_path / "s")
    longer = study(cases=32)
    engine.run_study(longer, tmp_path / "s", resume=True)
    table = rows(longer, tmp_path / "s")
    assert len(table["case"]) == 32
    assert same(short, {name: values[:16] for name, values in table.items()})


def test_case_nought_and_the_step_error_of_the_deburring_example(study, tmp_path):
    planned = study()
    engine.run_study(planned, tmp_path / "s", chunk=32)
    table = rows(planned, tmp_path / "s")
    assert 1e3 * table["lever part.burr.height"][0] == pytest.approx(0.7147830, abs=5e-8)
    assert 1e3 * table["lever part.burr.width"][0] == pytest.approx(0.9955176, abs=5e-8)
    assert 1e-5 * table["lever spindle.pressure"][0] == pytest.approx(5.1965863, abs=5e-8)
    assert 1e3 * table["measure surface_error_max"][0] == pytest.approx(-0.04263, abs=5e-6)
    assert at.identity_in(tmp_path / "s")["step_errors"]["surface_error_max"] == pytest.approx(0.346e-6, abs=1e-9)


def test_a_case_is_what_its_own_run_gives(study, examples, tmp_path):
    planned = study(cases=8)
    engine.run_study(planned, tmp_path / "s", chunk=8)
    found = answers(planned, tmp_path / "s", 8)
    words = [one.replace("'", "") for one in command(found, 3).split(" --set ")[1:]]
    alone = quick_outcome(load(examples / "deburr_compliant_spindle.yaml", words), coarse=True).measures
    assert found.table["measure surface_error_max"][3] == pytest.approx(alone["surface_error_max"], rel=1e-5)


def test_numbers_of_a_case_are_those_that_judged_it(study):
    """A borderline case is run with the finer step: its measures keep the limits if it is good, and miss one if it is bad."""
    found = evaluate(study(), 0, 24, {"surface_error_max": 2e-5, "surface_error_min": 2e-5})
    assert found.finer.any()
    assert not found.finer.all()
    beyond = (found.measures["surface_error_max"] > 5e-5) | (found.measures["surface_error_min"] < -5e-5)
    assert ((found.state == GOOD) == ~beyond).all()
    near = int(np.flatnonzero(found.finer)[0])
    values = {key: column[near] for key, column in found.levers.items()}
    exact = quick_outcome(scenario_of(study(), values)).measures
    assert any(found.measures[name][near] == exact[name] for name in ("surface_error_max", "surface_error_min"))
    far = "cutting_power_mean"  # from its limit: of one step in all cases
    assert found.measures[far][near] != exact[far]


def test_design_levers_see_the_same_draws(study, tmp_path):
    planned = study(
        TEXT.replace("  spindle.pressure: {{uniform: [4.8 bar, 5.2 bar]}}", "  spindle.pressure: [4 bar, 5 bar]"),
        cases=8,
    )
    assert planned.cases == 16
    engine.run_study(planned, tmp_path / "s", chunk=16)
    table = rows(planned, tmp_path / "s")
    assert table["lever spindle.pressure"][:4].tolist() == [4e5, 5e5, 4e5, 5e5]
    assert np.array_equal(table["lever part.burr.height"][::2], table["lever part.burr.height"][1::2])
    found = answers(planned, tmp_path / "s", 16)
    assert [values for values, _ in found.shares] == [{"spindle.pressure": 4e5}, {"spindle.pressure": 5e5}]


def test_other_studies_and_versions_are_refused_naming_what_differs(study, tmp_path):
    folder = tmp_path / "s"
    engine.run_study(study(cases=8), folder, chunk=8)
    with pytest.raises(ScenarioFault, match=r"holds another study: seed \(1, now 2\) differs; take another"):
        engine.run_study(study(cases=8, seed=2), folder, resume=True)
    other = TEXT.replace("80 mm/s", "81 mm/s").replace("0.15", "0.16")
    with pytest.raises(ScenarioFault, match=r"scenario \(operation.feed\) and vary \(part.burr.width\) differ"):
        engine.run_study(study(other, cases=8), folder, resume=True)
    file = folder / "identity.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), "version": "0.0"}))
    at.part_file(folder, 0, 8).unlink()
    for go_on in (lambda: engine.run_study(study(cases=8), folder, resume=True), lambda: engine.work(folder)):
        with pytest.raises(ScenarioFault, match=r"was begun with cutwise 0\.0.*--accept-version"):
            go_on()
    assert engine.run_study(study(cases=8), folder, resume=True, accept_version=True).done == 8
    assert at.versions(at.identity_in(folder)) == ["0.0", cutwise.__version__]
    assert engine.work(folder) == 0  # may take part now
    assert engine.run_study(study(cases=8), folder, resume=True).done == 8


def test_indices_may_be_asked_for_beside_the_cases(study, tmp_path):
    """The rows of method indices in a folder of their own: the same indices, and the cases as without them."""
    beside = study(TEXT.replace("want: {{", "want: {{indices: 7, "), cases=8)
    assert (beside.cases, beside.indices) == (8, 8)
    engine.run_study(beside, tmp_path / "s", chunk=8)
    alone = study(method="indices", cases=8)
    engine.run_study(alone, tmp_path / "i", chunk=64)
    found, rows_of = answers(beside, tmp_path / "s", 8), answers(alone, tmp_path / "i", 64)
    assert found.done == 8
    assert {name: one.total.tolist() for name, one in found.indices.items()} == {
        name: one.total.tolist() for name, one in rows_of.indices.items()
    }
    spent = study(TEXT.replace("want: {{", "want: {{indices: 8, ") + "budget: {{cases: 8}}\n", cases=8)
    ran = engine.run_study(spent, tmp_path / "b", chunk=8)
    assert (ran.done, "the budget is spent" in ran.stopped) == (8, True)
    assert not answers(spent, tmp_path / "b", 8).indices
    assert engine.work(tmp_path / "s") == 0


def test_a_study_can_be_handed_over(study):
    planned = study()
    again = unpack(json.loads(json.dumps(pack(planned))))
    assert again.random == dict(planned.random)
    assert pack(again) == pack(planned)


def test_indices_and_effects_are_found(study, tmp_path):
    for method in ("indices", "morris"):
        planned = study(method=method, cases=8)
        engine.run_study(planned, tmp_path / method, chunk=64)
        told = measures(answers(planned, tmp_path / method, 64))
        name = "index_total" if method == "indices" else "effect"
        assert told[f"{name}_surface_error_max_part.burr.width"] > 0.0


def test_effects_are_told_in_shares_of_an_input(study, tmp_path):
    """An input that counts in proportion has the effect of its whole range: here power, nearly so, of the pressure."""
    text = TEXT.split("vary:")[0].replace("set: {{operation.feed: 80 mm/s}}\n", "") + (
        "vary: {{spindle.pressure: {{uniform: [4.99 bar, 5.01 bar]}}}}\nmethod: morris\ncases: 2\n"
        "want: {{measures: [cutting_power_mean]}}\n"
    )
    planned = study(text)
    engine.run_study(planned, tmp_path / "s")
    table = rows(planned, tmp_path / "s")
    slope = np.polyfit(table["lever spindle.pressure"], table["measure cutting_power_mean"], 1)[0]
    found = measures(answers(planned, tmp_path / "s", at.identity_in(tmp_path / "s")["chunk"]))
    assert found["effect_cutting_power_mean_spindle.pressure"] == pytest.approx(abs(slope) * 2000.0, rel=1e-3)


def test_the_stop_rule_looks_at_a_finished_prefix(study, tmp_path):
    planned = study(TEXT + "stop: {{half_width: 0.3, at_least: 8}}\n", cases=64)
    ran = engine.run_study(planned, tmp_path / "s", chunk=8)
    assert ran.stopped
    assert ran.done < 64


@pytest.mark.slow
def test_a_killed_worker_loses_nothing(study, tmp_path):
    planned = study(cases=64)
    engine.run_study(planned, tmp_path / "whole", chunk=8)
    at.started(tmp_path / "s", json.dumps(pack(planned)), at.identity_in(tmp_path / "whole"))
    code = f"from pathlib import Path; from cutwise.study.many.engine import work; work(Path({str(tmp_path / 's')!r}))"
    for _ in range(2):
        worker = subprocess.Popen([sys.executable, "-c", code])
        parts = len(list((tmp_path / "s" / "parts").glob("*.nc")))
        until = time.monotonic() + 60.0
        while len(list((tmp_path / "s" / "parts").glob("*.nc"))) < parts + 2 and time.monotonic() < until:
            time.sleep(0.02)
        worker.kill()
        worker.wait()
    for lease in (tmp_path / "s" / "lease").iterdir():  # as if a minute had passed
        lease.unlink()
    engine.work(tmp_path / "s")
    assert same(rows(planned, tmp_path / "whole"), rows(planned, tmp_path / "s"))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("part.burr.height", "part.burr.hight"), "vary.part.burr.hight: unknown key of the scenario; did you mean"),
        (("method: {method}", "method: rar"), '"rar" is not one of grid, monte_carlo'),
        (("method: {method}", "method: optimise"), "optimise needs minimise or maximise"),
        (("seed: 1", "seed: 1\nmaximise: operation.feed"), "maximise: is not used: only optimise looks for something"),
        (("uniform: [4.8 bar, 5.2 bar]", "between: [4.8 bar, 5.2 bar]"), "between belongs to method: optimise"),
        (("cases: {cases}", "case: 8"), "case: unknown key; did you mean cases"),
        (("cutting_power_mean", "cutting_power"), "unknown measure; did you mean cutting_power_mean"),
        ((", within: [0 mm, null]", ""), ""),
        (("deviation: 0.1 mm", "deviation: 0.5 mm"), ""),
        (
            ("deviation: 0.1 mm}}, within: [0 mm, null]", "deviation: 0.5 mm}}"),
            "% of it lies beyond what part.burr.height may be",
        ),
        (("[4.8 bar, 5.2 bar]", "[5.2 bar, 4.8 bar]"), "the first end must not be above the second"),
        (("uniform: [4.8 bar, 5.2 bar]", "uniform: [4.8 mm, 5.2 bar]"), '"mm" is not a unit of pressure'),
        (("lognormal:", "field:"), "expected mean, deviation, correlation_length"),
        (
            ("seed: 1", "seed: 1\ncorrelated: [{{keys: [part.burr.height, spindle.presure], correlation: 0.5}}]"),
            "spindle.presure does not scatter",
        ),
        (
            ("seed: 1", "seed: 1\ncorrelated: [{{keys: [part.burr.height, part.burr.width], correlation: 1.5}}]"),
            "expected a number between -1 and 1",
        ),
        (
            (
                "seed: 1",
                "seed: 1\ncorrelated: [{{keys: [part.burr.height, part.burr.width, spindle.pressure], correlation: -0.6}}]",
            ),
            "not positive definite, its smallest eigenvalue is -0.2",
        ),
        (("seed: 1", "seed: 1\ncorrelated: [{{entry: material.library}}]"), "material has no values with a covariance"),
        (("seed: 1", "seed: 1\nbudget: {{time: 30 mm}}"), '"mm" is not a unit of time'),
        ((", within: [0 mm, null]", ", offset: 3"), "offset: is true or false"),
        (
            ("uniform: [4.8 bar, 5.2 bar]", "uniform: [4.8 bar, 5.2 bar], weights: [1]"),
            "weights: does not go with uniform",
        ),
        (("log_deviation: 0.15", "log_deviation: 0.15, mean: 2 mm"), "expected median and log_deviation"),
        (("want: {{", "want: {{indices: no, "), "want.indices: no is no whole number from 2 on"),
        (("want: {{", "want: {{indice: 8, "), "want.indice: unknown; did you mean indices"),
        (("seed: 1", "seed: 1\nlevels: 6"), "levels: is not used: only morris has levels"),
        (("seed: 1", "seed: 1\nwant2: 3"), "want2: unknown key; did you mean want"),
        (("80 mm/s", "80 mm"), '"mm" is not a unit of speed'),
        # what would be taken and not used
        (("operation.feed: 80 mm/s", "part.burr.width: 2 mm"), "the value that is set would not be used"),
        (("method: {method}", "coarse: {{operation.feed: 150 mm/s}}"), "coarse.operation.feed: is no numerics"),
        (
            (
                "uniform: [4.8 bar, 5.2 bar]",
                "uniform: [4.8 bar, 5.2 bar]}}\n  requirements.surface_error_max.max: {{choice: [1 mm, 2 mm]",
            ),
            "all cases are judged by the same limits",
        ),
        (
            ("spindle.pressure: {{uniform: [4.8 bar, 5.2 bar]}}", "name: [a, b]"),
            "vary.name: does not vary within a study",
        ),
        (
            ("spindle.pressure: {{uniform: [4.8 bar, 5.2 bar]}}", "process: [mill]"),
            "each process has a study of its own",
        ),
        (
            ("spindle.pressure: {{uniform: [4.8 bar, 5.2 bar]}}", "spindle.pressure: [5 bar, 5.0 bar]"),
            "the same value twice",
        ),
        (("want: {{", "want: {{probability: {{min: 0.9, max: 0.95}}, "), "expected a share between 0 and 1"),
        (("method: {method}", "method: indices\nbudget: {{cases: 9}}\nlevels: 3"), "only morris has levels"),
        (("method: {method}", "method: morris\nlevels: 5"), "5 is odd"),
        (("seed: 1", "seed: 1\nstop: {{half_width: 0.1, at_least: .inf}}"), "expected for example"),
        (
            ("80 mm/s}}", "80 mm/s, requirements: null}}\nstop: {{half_width: 0.1}}"),
            "stop: is not used: there are no requirements",
        ),
        (("name: burrs", "name: ../../burrs"), "expected a name without slashes"),
        (("name: burrs", "name: [burrs]"), "expected a name without slashes"),
        # what would end in a traceback, or in no room
        (
            (
                "lognormal: {{median: 1 mm, log_deviation: 0.15}}",
                "field: {{mean: 1 mm, deviation: 0.1 mm, correlation_length: 1 nm}}",
            ),
            "shorter than any burr changes",
        ),
        (("{{mean: 0.8 mm, deviation: 0.1 mm}}", "[0.8 mm, true]"), "true is no quantity"),
        (("within: [0 mm, null]", "within: [true, null]"), "true is no quantity"),
        (("[cutting_power_mean]", "{{a: b}}"), "unknown measure"),
        (("uniform: [4.8 bar, 5.2 bar]", "choice: [4.8 bar, 5.2 bar], weights: 3"), "expected a number for each value"),
        (
            ("uniform: [4.8 bar, 5.2 bar]", "choice: [4.8 bar, 5.2 bar], weights: [.inf, 1]"),
            "expected a number for each value",
        ),
        (("cases: {cases}", "cases: 100000000000000"), "cases are too many"),
        (
            ("uniform: [4.8 bar, 5.2 bar]", "grid: {{from: 4 bar, to: 5 bar, count: 1000000000}}"),
            "settings are too many",
        ),
        # a word that is seldom drawn
        (
            (
                "spindle.pressure: {{uniform: [4.8 bar, 5.2 bar]}}",
                "operation.milling: {{choice: [down, sideways], weights: [1e6, 1]}}",
            ),
            '"sideways" is not one of down, up',
        ),
    ],
)
def test_faults_are_told_in_words(study, change, words):
    text = TEXT.replace(*change)
    if not words:
        study(text)
        return
    with pytest.raises(ScenarioFault) as found:
        study(text)
    assert words in str(found.value)


def test_a_lever_that_turns_nothing_is_told(study):
    text = TEXT.replace("spindle.pressure: {{uniform: [4.8 bar, 5.2 bar]}}", "numerics.substeps: [2, 4]")
    assert any(
        "numerics.substeps varies, and is not used: there are no feed drives" in line for line in told(study(text))
    )
    assert not any("not used" in line for line in told(study()))


def test_what_decides_is_asked_at_one_setting(study):
    text = TEXT.replace("uniform: [4.8 bar, 5.2 bar]", "grid: {{from: 4 bar, to: 5 bar, count: 2}}")
    for method in ("indices", "morris"):
        with pytest.raises(ScenarioFault, match=r"spindle\.pressure has several values"):
            study(text, method=method)


def test_a_value_that_is_set_may_be_scattered_about(study):
    text = TEXT.replace("operation.feed: 80 mm/s", "spindle.pressure: 5.5 bar").replace(
        "uniform: [4.8 bar, 5.2 bar]", "uniform: [-0.2 bar, 0.2 bar], offset: true"
    )
    assert study(text).random["spindle.pressure"].added == pytest.approx(5.5e5)
    with pytest.raises(ScenarioFault, match=r"--set part\.burr\.width: is set, and varies"):
        study(overrides=["part.burr.width=1.2 mm"])
    with pytest.raises(ScenarioFault, match="a seed has 64 bits"):
        study(seed=2**64)


def test_a_fault_of_the_scenario_hides_none_of_the_study(study):
    text = TEXT.replace("80 mm/s", "80 mm").replace("seed: 1", "seed: x\nstop: 4\nbudget: 5\nwnt: 3")
    with pytest.raises(ScenarioFault) as found:
        study(text, method="nothing")
    for words in ("unit of speed", "seed: x is no", "stop: expected", "budget: expected", "wnt: unknown", "nothing"):
        assert words in str(found.value)


def test_a_requirement_has_no_probability_of_its_own_in_a_study(examples):
    scenario = load(examples / "deburr_compliant_spindle.yaml")
    limit = scenario.requirements["surface_error_max"].model_copy(update={"probability": 0.9})
    asked = scenario.model_copy(update={"requirements": {**scenario.requirements, "surface_error_max": limit}})
    with pytest.raises(ScenarioFault, match="a case keeps a limit or misses it"):
        run_study(asked, {"part.burr.height": {"normal": {"mean": "0.8 mm", "deviation": "0.1 mm"}}}, cases=8)


def test_nothing_is_asked_of_a_study_in_which_nothing_scatters(study):
    text = (
        TEXT.split("vary:")[0]
        + "vary: {{spindle.pressure: [4 bar, 5 bar]}}\ncases: {cases}\nwant: {{probability: {{min: 0.9}}}}\n"
    )
    with pytest.raises(ScenarioFault) as found:
        study(text)
    assert "cases: is not used: nothing scatters" in str(found.value)
    assert "there is no share of anything" in str(found.value)


@pytest.mark.slow
def test_several_processes_give_the_same_rows_and_leave_no_lease(study, tmp_path):
    """A part whose worker was ended is done by the next: a lease that stays would leave it out in silence."""
    planned = study(cases=32)
    engine.run_study(planned, tmp_path / "one", chunk=8)
    ran = engine.run_study(planned, tmp_path / "two", chunk=8, jobs=2)
    assert (ran.done, ran.stopped) == (32, "")
    assert same(rows(planned, tmp_path / "one"), rows(planned, tmp_path / "two"))
    assert not list((tmp_path / "two" / "lease").iterdir())


def test_leases_of_a_process_that_was_ended_are_given_back(tmp_path):
    (tmp_path / "lease").mkdir()
    assert at.take_lease(tmp_path, 0)
    assert not at.take_lease(tmp_path, 0)
    at.give_back_of(tmp_path, os.getpid() + 1)
    assert not at.take_lease(tmp_path, 0)
    at.give_back_of(tmp_path, os.getpid())
    assert at.take_lease(tmp_path, 0)
    old = time.time() - 3600.0
    os.utime(tmp_path / "lease" / "0", (old, old))
    assert at.take_lease(tmp_path, 0)
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    lease = tmp_path / "lease" / "0"
    lease.write_text(f"{platform.node()} {ended.pid}")  # killed a moment ago: nobody has to wait for a minute
    assert at.take_lease(tmp_path, 0)
    lease.write_text(f"elsewhere {ended.pid}")
    assert not at.take_lease(tmp_path, 0)


def test_all_faults_at_once(study):
    text = (
        TEXT.replace("[4.8 bar, 5.2 bar]", "[5.2 bar, 4.8 bar]")
        .replace("median: 1 mm", "median: 1 bar")
        .replace("seed: 1", "seed: -1")
    )
    with pytest.raises(ScenarioFault) as found:
        study(text)
    assert len(found.value.faults) >= 3


def test_from_the_command_line(examples, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.yaml").write_text(TEXT.format(examples=examples, method="sobol", cases=16), encoding="utf-8")

    def call(*words):
        with pytest.raises(SystemExit) as end:
            main(list(map(str, words)))
        return end.value.code, capsys.readouterr()

    assert call("check", "s.yaml")[0] == 0
    code, told = call("study", "s.yaml", "-o", "out", "--json", "--table", "all.csv")
    assert code == 0
    answer = json.loads(told.out)
    assert answer["process"] == "study"
    assert 0.0 <= answer["measures"]["probability_good_low"]["value"] <= answer["measures"]["probability_good"]["value"]
    assert (tmp_path / "all.csv").read_text().splitlines()[0].startswith("case,part.burr.height [m],")
    assert "http" not in (tmp_path / "out" / "report.html").read_text()
    assert call("study", "s.yaml", "-o", "out")[0] == 2
    assert call("worker", "out")[0] == 0
    assert call("worker", "nowhere")[0] == 2
