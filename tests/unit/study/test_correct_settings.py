"""Depth and placement as levers: the deepest cut that keeps its limits, and the posture with the least error."""

import pytest

import cutwise
from cutwise.io.scenario import load
from cutwise.process.recipes import Outcome
from cutwise.spec.faults import ScenarioFault
from cutwise.study.correct import settings
from cutwise.study.correct.outcome import Task

MILL = ["numerics.station=100 mm", "requirements={wall_error_min: {min: -75 um}, depth_margin: {min: 0}}"]
RANGE = "correct.ranges={operation.axial_depth: [1 mm, 20 mm]}"


@pytest.fixture
def few(monkeypatch):
    """A short search is enough to see whether it is one."""
    monkeypatch.setattr(settings, "_STARTS", 8)
    monkeypatch.setattr(settings, "_BEST", 1)
    monkeypatch.setattr(settings, "_CALLS", 50)


@pytest.mark.usefixtures("few")
def test_the_deepest_cut_is_at_the_limit_of_what_it_has_to_keep(examples, monkeypatch):
    """Trials by a straight line, 14.2 um of wall a millimetre; the run after is a run, and keeps the limit."""
    line = lambda one, *_: Outcome({"wall_error_min": -14.2e-3 * one.operation.axial_depth, "depth_margin": 0.1})  # noqa: E731
    monkeypatch.setattr(settings, "quick_outcome", line)
    given = load(examples / "mill_on_robot.yaml", [*MILL, RANGE])
    found = cutwise.correct(given, ("depth",))
    deep = found.scenario.operation.axial_depth
    assert deep == pytest.approx(75e-6 / 14.2e-3, rel=1e-3)
    assert found.good
    assert found.after.measures["wall_error_min"].value >= -75e-6
    assert found.measures["depth_gained"].value == pytest.approx(deep / 5e-3 - 1.0)
    monkeypatch.setattr(settings, "simulate", lambda *_: found.after)
    last = settings.deeper(Task(found.scenario, found.scenario.correct, found.after))
    assert last.kept[0].startswith("nothing is gained")
    assert last.scenario is found.scenario


@pytest.fixture(scope="module")
def hole(examples):
    return lambda *given: load(
        examples / "correct_drill.yaml", ["correct.vary=null", "robot.joint_angles=null", *given]
    )


def test_the_posture_with_the_least_error_is_found(hole):
    """Reference: least skating at 26 degrees, 1.021 and 2.831 um at entry and exit; the stiffest posture has 21.784."""
    found = cutwise.correct(hole("correct.ranges={robot.redundancy_angle: [-180 deg, 180 deg]}"), ("placement",))
    assert found.measures["placement_error_before"].value == pytest.approx(21.784e-6, rel=1e-3)
    assert found.measures["placement_error_after"].value < 2.84e-6
    errors = [found.after.measures[f"hole_position_error_{end}"].value for end in ("entry", "exit")]
    assert max(errors) == pytest.approx(found.measures["placement_error_after"].value, rel=1e-6)


@pytest.mark.usefixtures("few")
def test_one_number_of_a_place_may_be_turned(hole):
    found = cutwise.correct(hole('correct.ranges={"hole.position[1]": [200 mm, 400 mm]}'), ("placement",))
    assert 0.2 <= found.scenario.hole.position[1] <= 0.4
    assert found.scenario.hole.position[0] == 1.9
    assert found.changes == () or found.changes[0].key == "hole.position[1]"


@pytest.mark.parametrize(
    ("change", "ranges", "words"),
    [
        ("placement", "{}", "missing: change: placement turns robot.redundancy_angle"),
        ("placement", "{robot.redundancy_angle: [20 deg, 10 deg]}", "is not below"),
        ("placement", '{robot.reduction: ["1", "2"], robot.redundancy_angle: [0 deg, 10 deg]}', "no change that is asked"),
        ("placement", '{"hole.position[0]": [1 N, 2 N]}', "length"),
    ],
)  # fmt: skip
def test_ranges_that_are_none_are_told(hole, change, ranges, words):
    with pytest.raises(ScenarioFault, match=words):
        cutwise.correct(hole(f"correct.ranges={ranges}"), (change,))


def test_depths_that_a_program_says_are_not_changed(examples):
    with pytest.raises(ScenarioFault, match="says how deep it cuts"):
        cutwise.correct(load(examples / "mill_pocket.yaml", [RANGE]), ("depth",))
