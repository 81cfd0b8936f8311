"""Advice is a promise about a run: every proposal is run again and must keep it."""

import pytest

from cutwise.io.scenario import load
from cutwise.process.recipes import quick_measures, simulate
from cutwise.spec.faults import ScenarioFault
from cutwise.study.advice import advise, propose, slack
from cutwise.study.review import reviewed
from cutwise.study.sensitivity import assumed_sensitivity, changed


@pytest.fixture
def scenario(examples):
    def make(*overrides):
        return load(examples / "deburr_compliant_spindle.yaml", list(overrides))

    return make


@pytest.mark.parametrize(
    "fault", ["operation.feed=120 mm/s", "operation.lead_in_time=0.05 s", "spindle.pressure=3 bar"]
)
def test_a_proposal_keeps_its_promise(scenario, fault):
    failing = scenario(fault)
    assert slack(failing, quick_measures(failing)) < 0
    proposals = propose(failing, pairs=False)
    assert proposals
    for proposal in proposals:
        settings = {key: f"{value!r} {'Pa' if 'pressure' in key else 's' if 'time' in key else 'm/s' if 'feed' in key else 'm'}"
                    for key, value in proposal.settings.items()}  # fmt: skip
        if "operation.lead_in_time" in settings:
            longer = proposal.settings["operation.lead_in_time"] - failing.operation.lead_in_time
            settings["operation.duration"] = f"{failing.operation.run_time + longer!r} s"
        result = simulate(changed(failing, settings))
        assert result.verdict == "pass", proposal.text


def test_a_proposal_is_near_the_present_setting(scenario):
    """From 120 mm/s the feed has to fall to 86 mm/s, where the requirement is just met, not to the middle of the limits."""
    (proposal,) = propose(scenario("operation.feed=120 mm/s"), pairs=False)
    assert proposal.settings["operation.feed"] == pytest.approx(0.086, abs=0.001)


def test_limits_given_by_the_user_are_kept(scenario):
    failing = scenario("operation.feed=120 mm/s")
    assert propose(failing, {"operation.feed": ("100 mm/s", "200 mm/s")}, pairs=False) == []
    (text,) = advise(failing, {"operation.feed": ("100 mm/s", "200 mm/s")}, pairs=False)
    assert "no single lever" in text
    assert "100 mm/s to 200 mm/s" in text


def test_room_of_a_passing_run(scenario):
    texts = advise(scenario())
    assert len(texts) == 4
    feed = next(text for text in texts if "operation.feed" in text)
    assert "from 56" in feed
    assert "to 86" in feed
    for end, verdict in ((86, "pass"), (89, "fail")):
        assert simulate(scenario(f"operation.feed={end} mm/s")).verdict == verdict


def test_two_levers_where_one_is_not_enough(scenario):
    failing = scenario("part.burr.height=1.5 mm")
    assert propose(failing, pairs=False) == []
    levers = {"spindle.pressure": ("5 bar", "6.5 bar"), "operation.feed": ("50 mm/s", "80 mm/s")}
    proposals = propose(failing, levers)
    assert len(proposals) == 1
    assert set(proposals[0].settings) == set(levers)


def test_without_requirements_there_is_nothing_to_advise(scenario):
    bare = scenario()
    bare = bare.model_copy(update={"requirements": {}})
    assert advise(bare) == ()


def test_the_lever_ratio_moves_the_result_most(scenario):
    """At R0, 2 % above the knee, a tenth of the piston arm moves the error by about 0.1 mm; inertia by nothing."""
    found = assumed_sensitivity(scenario())
    assert next(iter(found)) == "spindle.piston_arm"
    assert found["spindle.piston_arm"] == pytest.approx(0.09e-3, rel=0.1)
    assert abs(found["spindle.inertia"]) < 1e-6
    assert list(found.values()) == sorted(found.values(), key=abs, reverse=True)


def test_a_change_that_cannot_be_is_refused(scenario):
    with pytest.raises(ScenarioFault):
        changed(scenario(), {"operation.feed": "-1 mm/s"})


def test_slow_scenarios_are_not_reviewed_unasked(scenario):
    result = reviewed(simulate(scenario()), patience=0.0)
    assert result.advice == ()
    assert "cutwise advise" in result.notes["advice"]
