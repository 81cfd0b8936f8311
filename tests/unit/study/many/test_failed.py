"""What a study says of cases that came to no end: counted, listed, and never taken for good in silence."""

import math

import pytest

from cutwise.app.study_text import said
from cutwise.process.recipes import Outcome
from cutwise.results import SolverFailure, warned
from cutwise.study import case
from cutwise.study.many import engine
from cutwise.study.many import folder as at
from cutwise.study.many.answers import answers, demanded
from cutwise.study.many.reading import read_study

TEXT = """
name: failing
scenario: {examples}/deburr_compliant_spindle.yaml
vary:
  part.burr.height: {{uniform: [0.5 mm, 1.5 mm]}}
  part.burr.width: {{uniform: [0.5 mm, 1.5 mm]}}
{more}
seed: 3
"""


@pytest.fixture
def found(examples, tmp_path, monkeypatch):
    """Answers of a study whose cases fail from some height on, and are bad from some width on."""

    def make(more, fails, bad, cannot=math.inf, why=""):
        def outcome(scenario, *_, **__):
            burr = scenario.part.burr
            if burr.height > fails:
                raise SolverFailure("no equilibrium")
            if burr.height > cannot:
                return Outcome({}, infeasible=(why,))
            error = 1e-3 if burr.width > bad else 0.0
            return Outcome({"surface_error_max": error, "surface_error_min": 0.0, "cutting_power_mean": 1.0})

        monkeypatch.setattr(case, "quick_outcome", outcome)
        file = tmp_path / "study.yaml"
        file.write_text(TEXT.format(examples=examples, more=more), encoding="utf-8")
        planned = read_study(file)
        engine.run_study(planned, tmp_path / "s", chunk=64)
        return answers(planned, tmp_path / "s", at.identity_in(tmp_path / "s")["chunk"])

    return make


def test_a_share_of_those_that_ended_does_not_meet_a_demand(found):
    """A tenth of the cases fails and all others are good: of all cases, 0.95 may or may not be."""
    told = found("cases: 256\nwant: {probability: {min: 0.95}}", fails=1.4e-3, bad=2e-3)
    assert told.shares[0][1].low > 0.95
    reached, words = demanded(told)
    assert not reached
    assert "cases failed, which may be bad" in words
    ((worst, best),) = told.if_failed
    assert worst.value == pytest.approx(0.9, abs=0.01)
    assert best.value == 1.0
    lines = "\n".join(said(told))
    first = told.first["no equilibrium"]
    assert f"failed: no equilibrium; case {first}: cutwise run" in lines
    assert "P(good) is 0.898 if all that failed are bad, 1.000 if all are good" in lines


@pytest.mark.parametrize(
    "why", ["the mill is too short", warned("too_short", "the mill is too short")], ids=["text", "record"]
)
def test_why_a_case_is_infeasible_is_told_in_words(found, why):
    """A row says it as a sentence or as a record: the part of the study holds, and the report tells, its words."""
    told = found("cases: 64", fails=math.inf, bad=2e-3, cannot=1.0e-3, why=why)
    assert told.infeasible == {"the mill is too short": 32}


def test_what_failed_counts_as_a_draw_once_under_indices(found):
    told = found("cases: 64\nmethod: indices", fails=1.4e-3, bad=1.0e-3)
    ((worst, best),) = told.if_failed
    share = told.shares[0][1]
    assert worst.value <= share.value <= best.value
    assert worst.value == pytest.approx(0.45, abs=0.02)  # of rows A and B; those between them are no draws
    assert best.value == pytest.approx(0.55, abs=0.02)
    lines = "\n".join(said(told))
    assert "what decides surface_error_max is not told: there are cases that have no such number" in lines
    assert "of what decides good, cases that failed count as bad" in lines


def test_nothing_is_said_of_failures_where_there_are_none(found):
    told = found("cases: 64\nwant: {probability: {min: 0.3}}", fails=2e-3, bad=1.0e-3)
    assert told.if_failed == ()
    assert demanded(told)[0]
    assert "if all that failed" not in "\n".join(said(told))
