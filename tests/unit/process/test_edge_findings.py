"""A run says what would mislead its reader: each warning in the situation that it is for, and only there."""

import pytest

from cutwise.app import findings
from cutwise.io.scenario import load
from cutwise.process.recipes import simulate


@pytest.fixture
def warnings(examples):
    def run(*overrides):
        result = simulate(load(examples / "deburr_compliant_spindle.yaml", list(overrides)))
        return " | ".join([*result.warnings, *findings.reasons(result), *findings.notices(result)])

    return run


def test_the_reference_case_is_quiet_about_the_run_itself(warnings):
    said = warnings()
    for words in ("latched", "stop", "droop", "return", "break away", "halved", "last quarter", "mN"):
        assert words not in said


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (["operation.lead_in_time=0.05 s"], "overshoot of the lead-in has latched"),
        (["operation.path_error={amplitude: 0.2 mm, frequency: 5 Hz}"], "waves of the path error"),
        (["operation.milling=up"], "dragged to the stop"),
        (["spindle.pressure=1 bar"], "holds the pistons back"),
        (["spindle.gravity=-y", "spindle.pressure=2 bar"], "motor droops"),
        (["operation.preset=0.01 mm"], "does not break away"),
        (["operation.preset=-1.2 mm"], "does not touch the edge"),
        (["spindle.power_rating=100 W"], "cutting takes 175"),
        (["tool.runout=5 um", "numerics.time_step=5 us", "numerics.engagement=arcs"], "older surface"),
        (["numerics.time_step=2 ms"], "halved"),
        (
            ["operation.path_error={amplitude: 0.2 mm, frequency: 0.5 Hz}", "operation.duration=1.6 s"],
            "met in the steady part",
        ),
    ],
)
def test_a_situation_is_named_with_its_remedy(warnings, overrides, words):
    assert words in warnings(*overrides)


def test_which_engagement_was_used_is_said(examples):
    def engagement(*overrides):
        return simulate(load(examples / "deburr_compliant_spindle.yaml", list(overrides))).notes["engagement"]

    assert "arcs" in engagement()
    assert "memory" in engagement("operation.path_error={amplitude: 0.2 mm, frequency: 20 Hz}")
    assert "cut down by" in engagement("numerics.engagement=swept")
