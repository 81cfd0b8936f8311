"""The example of turning on the command line, in the report and its plots."""

import json

import numpy as np
import pytest

from cutwise.app.findings import reasons
from cutwise.app.plots import PLOTS
from cutwise.app.report import render
from cutwise.io.scenario import load, parse
from cutwise.io.template import template
from cutwise.process.recipes import simulate


@pytest.fixture(scope="module")
def result(examples):
    return simulate(load(examples / "turn_shaft.yaml"))


def test_it_passes_and_says_who_bends(result):
    assert result.verdict == "pass"
    assert "work" in result.notes["worst"]
    assert json.dumps(result.summary())
    assert not [
        name for name, change in result.convergence.items() if abs(change) > 0.01 * abs(result.measures[name].value)
    ]


def test_plots_hold_the_data(result):
    error, parts = (plot.draw(result).axes[0] for plot in PLOTS["turn"])
    assert all(plot.applies(result) for plot in PLOTS["turn"])
    assert error.lines[-1].get_ydata().max() == pytest.approx(1e6 * result.measures["diameter_error_max"].value)
    assert [line.get_label() for line in error.lines] == ["pass 1", "pass 2", "pass 3"]
    highest = sum(np.interp(0.24, result["structure"]["z"], result["structure"][name].values[:, -1])
                  for name in result["structure"].dataset.data_vars)  # fmt: skip
    assert 2e6 * highest == pytest.approx(1e6 * result.measures["diameter_error_max"].value, rel=0.01)
    assert len(parts.lines) == 4


def test_report(result):
    page = render(result)
    assert page.count("<figure>") == 2
    assert "Every place is at rest" in page


def test_chatter_is_told_in_words(examples):
    found = simulate(load(examples / "turn_shaft.yaml", ["tool.nose_radius=0.8 mm"]))
    assert found.verdict == "fail"
    assert any(text.startswith("shaft or tool chatters: the depth of cut is 1.") for text in reasons(found))


def test_a_new_scenario_runs():
    assert simulate(parse(template("turn"))).verdict == "pass"
