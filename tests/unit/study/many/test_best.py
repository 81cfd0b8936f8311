"""Optimisation of a study: against bisection on runs, the same after a restart and with several processes."""

import json
import shutil
import subprocess
import sys
import time
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import optimize

from cutwise.app import optimum_text
from cutwise.app.cli import main
from cutwise.io.scenario import load
from cutwise.process.recipes import quick_outcome
from cutwise.spec.faults import ScenarioFault
from cutwise.study import processes
from cutwise.study.many import best, pool
from cutwise.study.many import folder as at
from cutwise.study.many.aims import Cost
from cutwise.study.many.cases import evaluate
from cutwise.study.many.definition import at_setting
from cutwise.study.many.reading import read_study
from cutwise.study.many.statements import Share
from cutwise.study.many.tried import share_of_cases

TEXT = """
name: fastest
scenario: {examples}/deburr_compliant_spindle.yaml
set:
  part.burr.height: 0.7 mm
  part.burr.width: 1.2 mm
  requirements: {{surface_error_max: {{max: 0.04 mm}}, surface_error_min: {{min: -0.05 mm}}}}
vary:
  operation.feed: {{between: [40 mm/s, 150 mm/s]}}
method: optimise
maximise: operation.feed
"""
ROBUST = (
    TEXT.replace("  part.burr.height: 0.7 mm\n", "").replace(
        "method:",
        "  part.burr.height: {{normal: {{mean: 0.7 mm, deviation: 0.04 mm}}}}\nrobust: {{probability: 0.75}}\nmethod:",
    )
    + "cases: 16\nseed: 5\n"
)


@pytest.fixture
def study(examples, tmp_path):
    def make(text=TEXT):
        file = tmp_path / "study.yaml"
        file.write_text(text.format(examples=examples), encoding="utf-8")
        return read_study(file)

    return make


@pytest.fixture(scope="module")
def searched(examples, tmp_path_factory):
    """A search that came to its end: study, folder, answer."""
    place = tmp_path_factory.mktemp("searched")
    (place / "study.yaml").write_text(TEXT.format(examples=examples), encoding="utf-8")
    planned = read_study(place / "study.yaml")
    return planned, place / "s", best.optimised(planned, place / "s")


def test_the_fastest_feed_is_where_bisection_on_runs_has_it(searched, examples):
    _, _, found = searched
    assert found.proven
    assert found.run.verdict == "pass"

    def beyond(feed):
        one = load(examples / "deburr_compliant_spindle.yaml", [
            f"operation.feed={feed!r} m/s", "part.burr.height=0.7 mm", "part.burr.width=1.2 mm",
        ])  # fmt: skip
        return quick_outcome(one).measures["surface_error_max"] - 0.04e-3

    feed = optimize.brentq(beyond, 0.06, 0.15, xtol=1e-8)
    assert found.optimum.levers["operation.feed"] == pytest.approx(feed, rel=5e-4)
    assert found.optimum.levers["operation.feed"] <= feed * (1 + 1e-9)


def _call(capsys, *words):
    with pytest.raises(SystemExit) as end:
        main(list(map(str, words)))
    return end.value.code, capsys.readouterr()


def test_a_search_goes_on_where_it_was_cut_off(searched, tmp_path, capsys):
    """Cut off in the middle of a line: what is there is told and exported, and going on comes to the same answer."""
    planned, folder, whole = searched
    cut = tmp_path / "s"
    shutil.copytree(folder, cut)
    text = (folder / "trials.jsonl").read_text()
    (cut / "trials.jsonl").write_text(text[: len(text) // 2])
    code, told = _call(capsys, "report", cut)
    assert (code, "the best so far; --resume goes on" in told.out) == (1, True)
    assert _call(capsys, "export", cut, "-o", tmp_path / "t.csv")[0] == 0
    assert len(pd.read_csv(tmp_path / "t.csv")) == text[: len(text) // 2].count("\n")
    with pytest.raises(ScenarioFault, match="trials are there: add --resume"):
        best.optimised(planned, cut)
    again = best.optimised(planned, cut, resume=True)
    assert again.optima == whole.optima
    assert again.tried == whole.tried


def test_a_finished_search_is_told_again_by_its_folder(searched, tmp_path, capsys):
    _, folder, whole = searched
    code, told = _call(capsys, "report", folder, "-o", tmp_path / "page.html")
    assert code == 0
    assert told.out.splitlines()[:-1] == list(optimum_text.said(whole))
    assert "What was tried" in (tmp_path / "page.html").read_text()
    assert _call(capsys, "export", folder, "-o", tmp_path / "t.csv")[0] == 0
    frame = pd.read_csv(tmp_path / "t.csv")
    assert frame["operation.feed [m/s]"].max() >= whole.optimum.levers["operation.feed"]
    assert len(frame) >= whole.done  # those of the coarse step, too
    code, told = _call(capsys, "export", folder, "-o", tmp_path / "t.nc")
    assert (code, "write .csv" in told.err) == (2, True)
    code, told = _call(capsys, "worker", folder)
    assert (code, "its cases follow from one another" in told.err) == (2, True)


def test_a_robust_optimum_is_good_as_often_as_it_has_to_be(study, tmp_path, monkeypatch):
    monkeypatch.setattr(best, "FRESH", 64)
    planned = study(ROBUST)
    found = best.optimised(planned, tmp_path / "s")
    first = found.optima[0]
    assert first.met
    assert first.share.value >= 0.75
    faster = at_setting(planned, {"operation.feed": first.levers["operation.feed"] * 1.01})
    assert (evaluate(faster, 0, planned.draws, {}).margin <= 0.0).mean() < 0.75
    assert len(found.optima) <= 4
    if not found.proven:
        assert found.optimum.fresh.low < 0.75
    lines = list(optimum_text.said(found))
    assert any("fresh cases (seed 6)" in line for line in lines)


def test_trials_of_other_levers_are_not_taken_for_those_of_these(study, tmp_path):
    """A trial is kept by its point: place 0 of [down, up] is another setting than place 0 of [up, down]."""
    text = TEXT.replace("operation.feed: {{between: [40 mm/s, 150 mm/s]}}", "operation.milling: [down, up]")
    text = text.replace("maximise: operation.feed", "maximise: surface_error_min")
    found = best.optimised(study(text), tmp_path / "s")  # words alone, with the coarse step first
    turned = text.replace("[down, up]", "[up, down]")
    with pytest.raises(ScenarioFault, match="holds another study"):
        best.optimised(study(turned), tmp_path / "s", resume=True)
    fresh = best.optimised(study(turned), tmp_path / "t")
    assert fresh.optimum.levers == found.optimum.levers
    assert fresh.optimum.aims == found.optimum.aims
    names = [at.identity_of(study(one), "1", 1, {}, {})["study"] for one in (TEXT, ROBUST, text, turned)]
    assert len(set(names)) == 4


def test_a_front_holds_if_each_of_its_settings_does(study):
    """Fresh cases speak of every setting of a robust front, and full runs of every setting of another."""
    good, bad = Share(0.9, 0.85, 0.95), Share(0.7, 0.65, 0.72)
    one = best.Setting({"operation.feed": 0.1}, (0.1,), -0.1, {}, good, good, 0.75)
    other = one._replace(fresh=bad)
    planned = study(ROBUST)
    assert best.Best(planned, 2, (one,), (one, one), (), None, {}).proven
    assert not best.Best(planned, 2, (one,), (one, other), (), None, {}).proven
    assert not best.Best(planned, 2, (other,), (), (), None, {}).proven
    lines = "\n".join(optimum_text.said(best.Best(planned, 2, (one,), (one, other), (), None, {})))
    assert "P(good) = 0.700 (0.650 to 0.720) of fresh cases" in lines
    assert share_of_cases([1] * 8 + [-1] * 8).value == 0.5  # what failed is not good


@pytest.mark.slow
def test_several_processes_find_the_same(study, tmp_path, monkeypatch):
    monkeypatch.setattr(best, "FRESH", 64)
    one = best.optimised(study(ROBUST), tmp_path / "one")
    two = best.optimised(study(ROBUST), tmp_path / "two", jobs=2)
    assert one.optima == two.optima
    assert one.tried == two.tried


class _Breaks:
    """Processes the second of which is lost."""

    def __init__(self, left):
        self.left = left

    def map(self, function, *each):
        for number, one in enumerate(zip(*each, strict=True)):
            if self.left and number == 2:
                raise BrokenProcessPool
            yield function(*one)

    def shutdown(self, **_):
        self.left -= 1


def test_what_a_lost_process_had_to_do_is_done_by_another(study, monkeypatch):
    for losses, come in ((2, [0, 1, 8, 27, 64, 125, 216]), (9, None)):
        broken = _Breaks(losses)
        monkeypatch.setattr(processes.Processes, "_made", lambda _, one=broken: one)
        with pool.pooled(study(), 2) as workers:
            if come is not None:
                assert workers.map(pow, [(k, 3) for k in range(7)]) == come
                continue
            with pytest.raises(ScenarioFault, match="again and again"):
                workers.map(pow, [(k, 3) for k in range(40)])


@pytest.mark.slow
def test_searches_on_dask_and_after_kills_are_those_of_one_process(study, tmp_path):
    """Killed (-9) amid its trials, with two processes; then dask goes on: the answer of one undisturbed process."""
    pytest.importorskip("distributed")
    planned = study(ROBUST + "budget: {{cases: 320}}\n")
    script = tmp_path / "s.py"
    script.write_text(
        "import sys\nfrom pathlib import Path\nfrom cutwise.study.many import best, reading\n"
        "if __name__ == '__main__':\n"
        "    best.FRESH = 64\n"
        "    best.optimised(reading.read_study(Path(sys.argv[1])), Path(sys.argv[2]), jobs=2, resume=True)\n"
    )
    kept = tmp_path / "killed" / "trials.jsonl"
    process = subprocess.Popen([sys.executable, str(script), str(tmp_path / "study.yaml"), str(kept.parent)])
    until = time.monotonic() + 120.0
    while (not kept.exists() or kept.read_text().count("\n") < 4) and time.monotonic() < until:
        time.sleep(0.02)
    children = subprocess.run(
        ["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True, text=True, check=False
    )
    process.kill()
    process.wait()
    pids = [int(pid) for pid in children.stdout.split()]
    until = time.monotonic() + 60.0
    while any(Path(f"/proc/{pid}").exists() for pid in pids) and time.monotonic() < until:
        time.sleep(0.1)
    assert pids
    assert not any(Path(f"/proc/{pid}").exists() for pid in pids)  # they would wait for work for ever
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(best, "FRESH", 64)
        again = best.optimised(planned, kept.parent, resume=True, executor="dask")
        whole = best.optimised(planned, tmp_path / "whole")
    assert again.optima == whole.optima
    assert again.tried == whole.tried


def test_a_front_over_shares_falls_as_more_is_asked_for(study, tmp_path):
    planned = study(ROBUST.replace("0.75", "[0.5, 0.9]"))
    found = best.optimised(planned, tmp_path / "s")
    low, high = found.front
    assert low.levers["operation.feed"] > high.levers["operation.feed"]
    assert low.share.value >= 0.5
    assert high.share.value >= 0.9


def test_quantiles_of_margins_say_the_same_as_shares():
    rng = np.random.default_rng(3)
    for share in (0.5, 0.9, 0.99):
        margins = np.sort(rng.normal(-2.0, 1.0, 1000)).tolist()
        assert (best.quantile(margins, share) <= 0.0) == (np.mean(np.array(margins) <= 0.0) >= share)


def test_costs_have_units():
    cost = Cost("'60 EUR/h' * t + '2 EUR' * (operation.feed / '80 mm/s')**2")
    assert cost.unit({"t": "time", "operation.feed": "speed"}) == "EUR"
    assert cost({"t": 30.0, "operation.feed": 0.04}) == pytest.approx(0.5 + 0.5)
    with pytest.raises(ValueError, match="convert"):
        Cost("t + operation.feed").unit({"t": "time", "operation.feed": "speed"})
    with pytest.raises(ValueError, match="sums, products"):
        Cost("t.real if t else 0").unit({"t.real": "time", "t": "time"})


def test_a_root_of_less_than_nothing_is_no_cost():
    assert np.isnan(Cost("(t - 2)**0.5")({"t": 1.0}))
    assert Cost("(t - 2)**0.5")({"t": 6.0}) == 2.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("maximise: operation.feed", "maximise: operation.fed"), "is no measure and no lever of this optimisation; did you mean"),
        (("maximise: operation.feed", "maximise: {{cost: operation.feed + cutting_power_mean}}"), "Cannot convert"),
        (("[40 mm/s, 150 mm/s]", "[150 mm/s, 40 mm/s]"), "expected two ends that rise"),
        (("[40 mm/s, 150 mm/s]", "[40 mm, 150 mm/s]"), '"mm" is not a unit of speed'),
        (("method: optimise", "method: optimise\nrobust: {{probability: 0.9}}"), "robust: is not used: nothing scatters"),
        (("method: optimise", "method: optimise\npoints: 5"), "points: is not used: a front has two aims"),
        (("method: optimise", "method: optimise\nstop: {{half_width: 0.1}}"), "stop: is not used"),
        (("method: optimise", "method: optimise\nwant: {{probability: {{min: 0.9}}}}"), "robust: {probability: 0.99}"),
        (("method:", "  spindle.pressure: {{uniform: [4 bar, 5 bar]}}\nmethod:"), "say how likely a good part has to be"),
        (("150 mm/s]}}", "150 mm/s], uniform: [-1 mm/s, 1 mm/s]}}"), "add offset: true"),
        (("[40 mm/s, 150 mm/s]}}", "[0.5 mm/s, 150 mm/s], normal: {{mean: 0 mm/s, deviation: 1 mm/s}}, offset: true}}"
          "\nrobust: {{probability: 0.9}}"),
         "of its scatter lies beyond what operation.feed may be"),
        (("method: optimise", "method: optimise\nbudget: {{time: 3 s}}"), "optimise is limited by cases"),
        (("method: optimise", "method: optimise\nminimise: operation.feed"), "operation.feed is both aims"),
        (("maximise: operation.feed", "maximise: {{cost: \"'3 EUR'\"}}"), "is the same for every setting"),
        (("maximise: operation.feed", "maximise: spindle.pressure"), "is no measure and no lever of this optimisation"),
        (("{{between: [40 mm/s, 150 mm/s]}}", "[40 mm/s, 150 mm/s]"), "it is an aim where it has two ends (between)"),
        (("part.burr.height: 0.7 mm", "operation.feed: 60 mm/s"), "the value that is set would not be used"),
    ],
)  # fmt: skip
def test_faults_are_told_in_words(study, change, words):
    with pytest.raises(ScenarioFault) as found:
        study(TEXT.replace(*change))
    assert words in str(found.value)


def test_from_the_command_line(examples, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.yaml").write_text(TEXT.format(examples=examples), encoding="utf-8")

    def call(*words):
        with pytest.raises(SystemExit) as end:
            main(list(map(str, words)))
        return end.value.code, capsys.readouterr()

    assert "optimisation of operation.feed" in call("check", "s.yaml")[1].out
    code, told = call("study", "s.yaml", "-o", "out", "--json", "--table", "all.csv")
    answer = json.loads(told.out)
    assert (code, answer["verdict"]) == (0, "pass")
    assert answer["measures"]["optimum_operation.feed"]["unit"] == "m/s"
    assert (tmp_path / "all.csv").read_text().startswith("operation.feed [m/s],margin")
    assert "What was tried" in (tmp_path / "out" / "report.html").read_text()
    impossible = TEXT.replace("{{max: 0.04 mm}}", "{{max: -0.051 mm}}").format(examples=examples)
    (tmp_path / "none.yaml").write_text(impossible, encoding="utf-8")
    code, told = call("study", "none.yaml", "-o", "none")
    assert code == 1
    assert "no setting of" in told.out
