"""Advice and sweeps from the command line: verdict by the exit code, cost, budget, warnings in the table."""

import pandas as pd
import pytest

ONE_LEVER = ("--limit", "operation.feed=60 mm/s..130 mm/s")


@pytest.fixture
def example(examples):
    return examples / "deburr_compliant_spindle.yaml"


def test_the_exit_code_of_advise_tells_the_verdict(cutwise, example):
    fails = cutwise("advise", example, "--set", "operation.feed=120 mm/s", *ONE_LEVER, "--budget", "40")
    assert fails.code == 1
    assert "advice: change operation.feed 120 mm/s -> 86 mm/s" in fails.out
    assert "FAIL: the requirements are not met as it stands" in fails.out
    passes = cutwise("advise", example, *ONE_LEVER)
    assert passes.code == 0
    assert "room in operation.feed (now 80 mm/s)" in passes.out
    assert "runs, " in passes.out
    assert "up to 78 runs" in passes.err


def test_what_is_wrong_with_a_budget_or_a_limit(cutwise, example):
    said = cutwise("advise", example, "--budget", "soon")
    assert (said.code, said.out) == (2, "")
    assert '--budget: "soon" is neither a number of runs nor a time' in said.err
    said = cutwise("advise", example, "--limit", "operation.fed=1 mm/s..2 mm/s")
    assert said.code == 2
    assert "--limit operation.fed: is not a quantity of this scenario; did you mean operation.feed?" in said.err


def test_the_feed_of_a_program_may_be_limited(cutwise, examples):
    said = cutwise("advise", examples / "mill_pocket.yaml", "--set", "requirements.contour_error_max.max=40 um",
                   "--limit", "operation.feed=15 mm/s..35 mm/s", "--budget", "8")  # fmt: skip
    assert said.code == 1
    assert "advice: change operation.feed as it is -> " in said.out


def test_warnings_stand_in_the_sweep_and_its_file(cutwise, example, tmp_path):
    file = tmp_path / "sweep.csv"
    said = cutwise("sweep", example, "--over", "operation.lead_in_time=2 ms,0.2 s", "-o", file)
    assert said.code == 0
    assert "warning: operation.spindle_speed: the cutting speed is 1005 m/min" in said.out
    assert "not sound: at_stop" in said.out
    frame = pd.read_csv(file)
    assert frame["operation.lead_in_time [s]"].tolist() == [0.002, 0.2]
    assert frame["operation.lead_in_time as written"].tolist() == ["2 ms", "0.2 s"]
    assert "the cutting speed is" in frame["warnings"][0]
    assert "at_stop" in frame["unsound"][0]
    wrong = cutwise("sweep", example, "--over", "operation.feed=80")
    assert wrong.code == 2
    assert wrong.err.startswith("--over operation.feed: 80 has no unit")


def test_check_says_what_a_requirement_needs(cutwise, examples):
    said = cutwise("check", examples / "mill_pocket.yaml", "--set", "requirements.wall_error_max.max=60 um")
    assert said.code == 2
    assert "it needs tool.modes (" in said.err
