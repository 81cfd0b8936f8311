"""A pass of a machine with its tool tip: modes and measured stiffness at rest, in series with the bodies."""

import numpy as np
import pytest

import cutwise
from cutwise.process.recipes import quick_outcome

FORCE = np.array([4000.0, 4000.0, 2000.0])
MODES = (
    "tool.modes=[{direction: x, frequency: 950 Hz, damping: 0.03, stiffness: 18 N/um}, "
    "{direction: y, frequency: 1020 Hz, damping: 0.035, stiffness: 20 N/um}]"
)
FEW = ["path.samples=3", "requirements=null", "uncertainty=null"]


@pytest.fixture(scope="module")
def on_machine(examples):
    return lambda *more: cutwise.load(examples / "machine_error_budget.yaml", [*FEW, *more])


@pytest.fixture(scope="module")
def bare(on_machine):
    return quick_outcome(on_machine()).measures


def added(found, bare, where="middle"):
    return np.array([found[f"deviation_{a}_{where}"] - bare[f"deviation_{a}_{where}"] for a in "xyz"])


def test_modes_yield_by_force_over_stiffness(on_machine, bare):
    found = quick_outcome(on_machine(MODES)).measures
    for where in ("start", "middle", "end"):
        assert added(found, bare, where) == pytest.approx([4000 / 18e6, 4000 / 20e6, 0.0], rel=1e-9, abs=1e-18)
    assert found["energy_balance"] < 1e-12
    assert sum(found[name] for name in found if name.startswith("share_")) == pytest.approx(
        found["deviation_norm_max"], rel=1e-9
    )


def test_modes_of_one_direction_are_in_series(on_machine, bare):
    two = "tool.modes=[{direction: x, frequency: 950 Hz, damping: 0.03, stiffness: 36 N/um}, "
    two += "{direction: x, frequency: 2 kHz, damping: 0.03, stiffness: 36 N/um}]"
    found = quick_outcome(on_machine(two)).measures
    assert added(found, bare) == pytest.approx([4000 / 18e6, 0.0, 0.0], rel=1e-9, abs=1e-18)


def test_measured_stiffness_is_that_across_the_tool(on_machine, bare):
    found = quick_outcome(on_machine("tool.stiffness=20 N/um")).measures
    assert added(found, bare) == pytest.approx([2e-4, 2e-4, 0.0], rel=1e-9, abs=1e-18)
    assert found["share_spindle"] > bare["share_spindle"] + 2e-4


@pytest.mark.parametrize("change", ["tool.stiffness=20 N/um", "tool.flexible=true"])
def test_a_tool_bends_in_one_way(on_machine, change):
    with pytest.raises(cutwise.ScenarioFault, match="both say how the tool bends"):
        on_machine(MODES, change)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ("spindle={library: default}", "pistons remember how they were loaded"),
        ("machine.drives={library: fadal2216}", "drives need time stepping"),
        ("robot={library: kr270_r2700}", "the tool has one carrier: write robot or machine"),
    ],
)
def test_what_has_no_place_at_rest_is_refused_in_words(on_machine, change, why):
    with pytest.raises(cutwise.ScenarioFault, match=why):
        on_machine(change)


@pytest.mark.parametrize(
    ("bends", "told"),
    [
        ("name=rigid", True),
        ("tool.stiffness=18 N/um", False),
        ("tool.modes=[{direction: x, frequency: 950 Hz, damping: 0.03, stiffness: 18 N/um}]", False),
    ],
)
def test_only_a_tool_that_does_not_bend_is_said_not_to(examples, bends, told):
    scenario = cutwise.load(
        examples / "machine_error_budget.yaml", ("uncertainty=null", "path.samples=3", "requirements={}", bends)
    )
    warnings = [str(one) for one in quick_outcome(scenario).warnings]
    assert any("does not bend" in one for one in warnings) is told
