"""Advice is a promise about a run: every proposal is run again and must keep it."""

import pytest

from cutwise.io.scenario import load
from cutwise.process.recipes import quick_outcome, simulate
from cutwise.spec.faults import ScenarioFault
from cutwise.study.advice import advise, consult, propose
from cutwise.study.levers import levers_of, read_limits
from cutwise.study.limits import slack
from cutwise.study.review import reviewed
from cutwise.study.sensitivity import assumed_sensitivity, changed
from cutwise.study.trials import Budget, Trials


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
    assert slack(failing, quick_outcome(failing)) < 0
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
    text, nearest = advise(failing, {"operation.feed": ("100 mm/s", "200 mm/s")}, pairs=False)
    assert nearest.startswith("nearest comes operation.feed 120 mm/s -> 100 mm/s")
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
    result = reviewed(simulate(scenario()), runs=0)
    assert result.advice == ()
    assert "cutwise advise" in result.notes["advice"]


def test_a_budget_ends_the_search_and_says_so(scenario):
    failing = scenario("operation.feed=120 mm/s")
    for runs in (3, 8, 30):
        found = consult(failing, budget=Budget(runs))
        assert found.runs <= runs
        assert not found.met
        assert found.sentences
        assert not found.complete
    assert found.sentences[-1].startswith("stopped after ")
    assert any("change operation.feed" in text for text in found.sentences)


def test_whatever_can_be_set_is_a_lever(examples):
    """A program has its feed in its blocks: operation.feed replaces it, and is a lever though it is not written."""
    slow = load(examples / "mill_pocket.yaml", ["requirements.contour_error_max.max=40 um"])
    assert {"operation.feed", "operation.spindle_speed", "operation.axial_depth"} <= {
        lever.key for lever in levers_of(slow)
    }
    limits = read_limits(slow, ["operation.feed=10 mm/s..40 mm/s"])
    (feed,) = levers_of(slow, limits)
    assert feed.now is None
    found = consult(slow, limits, budget=Budget(9))
    assert not found.met
    (proposal,) = found.proposals
    assert simulate(changed(slow, proposal.settings)).verdict == "pass"


def test_a_limit_on_what_is_no_quantity_is_refused_in_python_too(scenario):
    with pytest.raises(ScenarioFault, match=r'limits\["operation.fed"\]: .*did you mean operation.feed\?'):
        advise(scenario(), {"operation.fed": ("1 mm/s", "2 mm/s")})
    with pytest.raises(ScenarioFault, match=r"--limit operation.milling: is not a quantity"):
        read_limits(scenario(), ["operation.milling=1..2"])


def test_the_advice_of_a_run_does_not_depend_on_the_machine(scenario, monkeypatch):
    """Row 44: however long a run takes."""
    failing = simulate(scenario("operation.feed=120 mm/s"))
    usual = reviewed(failing)
    ticks = iter(range(0, 10**9, 1000))
    monkeypatch.setattr("time.process_time", lambda: float(next(ticks)))
    assert reviewed(failing).advice == usual.advice
    assert any("change operation.feed" in text for text in usual.advice)


def test_where_the_coarse_step_misleads_the_step_of_the_run_is_taken(scenario):
    """Row 5: with 100 µs the edge is 208.7 µm off, with the step of the run 57.1 µm."""
    short = scenario("operation.lead_in_time=2 ms", "requirements.surface_error_max.max=60 um")
    trials = Trials(short, (), Budget())
    assert not trials.trusted
    assert trials.start.measures["surface_error_max"] == pytest.approx(57.1e-6, rel=1e-3)
