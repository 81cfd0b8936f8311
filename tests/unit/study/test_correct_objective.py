"""What a correction makes least: the cost of a part, its error within a time; and what the spindle has over its speed."""

import math

import numpy as np
import pytest

import cutwise
from cutwise.app.correcting import front_of
from cutwise.io.scenario import load
from cutwise.physics.cutting.affine_limits import POWER
from cutwise.process.recipes import RECIPES
from cutwise.results import Infeasible
from cutwise.spec.correct import Correction
from cutwise.spec.faults import ScenarioFault
from cutwise.study.correct.feed import prepared, speeds_of
from cutwise.study.correct.loads import values_at

WEAR = {
    "life": "15 min", "at": {"cutting_speed": "226.1947 m/min", "feed_per_tooth": "0.05 mm"}, "speed_exponent": 0.4,
    "feed_exponent": 2.0,
}  # fmt: skip
DEAR = {
    "shop": {"machine_rate": "60 EUR/h", "tool_price": "60 EUR"}, "wear": WEAR, "correct.objective": "cost",
    "correct.limits": {"force_xy_peak": {"max": "400 N"}, "chip_thickness_max": {"max": "0.15 mm"}},
}  # fmt: skip


def power(*watts):
    return {"machine.spindle_power": {"columns": {"speed [rpm]": [1000, 8000], "power [W]": list(watts)}}}


def test_the_cheapest_feed_is_that_of_the_closed_form(slot):
    """1 EUR/min, 60 EUR an edge of 15 min, q = 2: half of the feed of 10 mm/s, and dearer on both sides of it."""
    found = cutwise.correct(load(slot, DEAR))
    assert found.good, found.reasons
    ready = prepared(found.scenario, Correction())
    assert speeds_of(ready)[ready.cells.cuts].max() == pytest.approx(5e-3, rel=1e-3)  # rounded down to 1 mm/min
    cost = found.measures["cost_per_part_after"].value
    assert cost < 0.85 * found.measures["cost_per_part_before"].value
    text = slot.with_name("side.nc").read_text(encoding="utf-8")
    for other in (250, 360):
        program = found.scenario.program.model_copy(update={"text": text.replace("F600", f"F{other}")})
        run = cutwise.simulate(found.scenario.model_copy(update={"program": program}))
        assert run.measures["cost_per_part"].value > cost


def test_the_cheapest_speed_is_slower_than_the_quickest(slot):
    turned = {
        "correct.change": ["speed", "feed"],
        "correct.ranges": {"operation.spindle_speed": ["3000 rpm", "9000 rpm"]},
    }
    found = cutwise.correct(load(slot, DEAR | turned | {"wear": WEAR | {"speed_exponent": 0.25, "feed_exponent": 0.0}}))
    assert found.good, found.reasons
    speed = float(prepared(found.scenario, Correction()).cutting.spindle[0]) * 30.0 / math.pi
    assert 3000 < speed < 6000
    assert found.measures["cost_per_part_after"].value < found.measures["cost_per_part_before"].value
    assert found.after.measures["tool_life"].value == pytest.approx(900.0 * (speed / 6000.0) ** -4, rel=1e-3)


def test_the_error_is_least_within_the_time_that_there_is(slot):
    """The contour at the start of a line is left by 12 µm; slower there, quicker nowhere, it is a third in 4 s."""
    wanted = {"correct.objective": "error", "requirements.cycle_time": {"max": "4 s"}}
    found = cutwise.correct(load(slot, wanted))
    assert found.good, found.reasons
    assert found.measures["time_after"].value <= 4.0
    assert found.measures["contour_error_max_before"].value == pytest.approx(11.995e-6, abs=5e-9)
    assert found.measures["contour_error_max_after"].value < 4e-6
    assert found.measures["force_xy_peak_after"].value <= found.measures["force_xy_peak_before"].value


def test_less_time_than_before_may_leave_less_error_too(slot):
    """Slower where the contour is left, quicker where force allows."""
    limits = {"correct.limits": {"force_xy_peak": {"max": "400 N"}}, "requirements.cycle_time": {"max": "2.2 s"}}
    found = cutwise.correct(load(slot, limits | {"correct.objective": "error"}))
    assert found.good, found.reasons
    assert found.measures["time_before"].value > 2.3
    assert found.measures["time_after"].value <= 2.2
    assert found.measures["contour_error_max_after"].value < 8e-6


def test_an_error_that_no_time_is_left_for_stays_and_is_said(slot):
    found = cutwise.correct(load(slot, {"correct.objective": "error"}))
    assert not found.good
    assert found.program == slot.with_name("side.nc").read_text(encoding="utf-8")
    assert any("nothing is gained: within these limits no feed makes the error smaller" in one for one in found.reasons)


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ({"correct.objective": "cost"}, "shop: missing"),
        (DEAR | {"correct.change": ["speed"]}, "write change: "),
        ({"correct.objective": "error", "correct.change": ["path"]}, "there is time"),
        ({"machine.spindle_power": {"columns": {"speed [rpm]": [1000, 8000], "power [N]": [1, 1]}}}, "unit of power"),
        (
            {"machine.spindle_torque": {"columns": {"speed [rpm]": [1000, 5000], "torque [N*m]": [1, 1]}}},
            "reaches from 1000 rpm to 5000 rpm; the spindle turns with 6000 rpm",
        ),
    ],
)
def test_what_an_objective_or_a_spindle_lacks_is_named(slot, said, words):
    with pytest.raises(ScenarioFault, match=words):
        cutwise.correct(load(slot, said))


def test_the_power_that_a_spindle_has_is_a_limit(slot):
    """600 W at 8000 rpm, 457 W at 6000: the program as it was takes 589 W, and stalls; the new one does not."""
    scenario = load(slot, power(100, 600) | {"correct.limits": {"force_xy_peak": {"max": "400 N"}}})
    before = cutwise.simulate(scenario)
    assert before.verdict == "fail"
    assert any("takes a power of 589.4 W at line 4" in one and "it stalls" in one for one in before.infeasible)
    found = cutwise.correct(scenario)
    assert found.good, found.reasons
    ready = prepared(found.scenario, Correction())
    most = values_at(ready.cells, ready.cutting, speeds_of(ready))[:, POWER].max()
    assert 0.985 * 457.14 < most <= 457.15
    assert not found.after.infeasible


def test_a_spindle_with_room_changes_nothing(slot):
    assert not cutwise.simulate(load(slot, power(100, 900))).infeasible


def test_a_speed_is_looked_for_where_the_spindle_has_something(slot):
    there = {"machine.spindle_power": {"columns": {"speed [rpm]": [2000, 7000], "power [kW]": [1, 1]}}}
    turned = {
        "correct.change": ["speed", "feed"],
        "correct.ranges": {"operation.spindle_speed": ["5000 rpm", "9000 rpm"]},
    }
    found = cutwise.correct(load(slot, there | turned))
    assert prepared(found.scenario, Correction()).cutting.spindle[0] == pytest.approx(7000 * math.pi / 30.0)
    beyond = {"correct.ranges": {"operation.spindle_speed": ["8000 rpm", "9000 rpm"]}}
    with pytest.raises(Infeasible, match="no speed of the range"):
        cutwise.correct(load(slot, there | turned | beyond))


def test_torques_of_places_are_those_of_the_limits(slot):
    """Two ways to the mean power: the kernel of the run, and that of the limits."""
    from cutwise.physics.cutting.wall import place_torques
    from cutwise.process.edges import edges

    scenario = load(slot)
    ready = prepared(scenario, Correction())
    chips = speeds_of(ready) * ready.cutting.per_speed
    own = place_torques(ready.cells.patches, chips, ready.cutting.teeth.mill, edges(scenario.material, scenario.tool))
    told = values_at(ready.cells, ready.cutting, speeds_of(ready))[:, POWER] / ready.cutting.spindle
    assert own == pytest.approx(np.where(chips > 0.0, told, 0.0), rel=1e-9, abs=1e-12)


def test_a_front_is_a_simulated_program_for_each_budget(slot, corrected):
    limit = ("--set", "correct.limits={force_xy_peak: {max: 240 N}}")
    code, told = corrected(*limit, "--front", "force_xy_peak=150 N,240 N,700 N,900 N", "--dry-run")
    assert code == 0
    rows = told["pareto"][2:]
    assert [row["budget"] for row in rows] == [150.0, 240.0, 700.0, 900.0]
    assert all(row["force_xy_peak"] <= row["budget"] and row["keeps_all"] for row in rows)
    times = [row["cycle_time"] for row in rows]
    assert times[0] > 2 * times[1] > 2 * times[2]
    assert times[3] == times[2]  # the chip binds, not the force
    alone = cutwise.correct(load(slot, {"correct.limits": {"force_xy_peak": {"max": "150 N"}}}))
    assert rows[0]["cycle_time"] == pytest.approx(alone.after.measures["cycle_time"].value, rel=1e-12)


@pytest.mark.parametrize(
    ("front", "words"),
    [
        ({"cycle_time": ["3 s"]}, "write objective: error"),
        ({"force_xy_pek": ["3 N"]}, "did you mean force_xy_peak"),
        ({"force_xy_peak": ["3 s"]}, "force_xy_peak"),
        ({"force_xy_peak": []}, "needs a list of budgets"),
        ({"force_xy_peak": ["3 N"], "cutting_power_max": ["3 W"]}, "one measure at a time"),
    ],
)
def test_a_front_of_nothing_is_refused(slot, front, words):
    with pytest.raises(ScenarioFault, match=words):
        cutwise.correct(load(slot, {"correct.front": front}))


def test_more_time_is_less_error(slot):
    said = {"correct.objective": "error", "correct.front": {"cycle_time": ["2.8 s", "5 s"]}, "correct.change": ["feed"]}
    found = cutwise.correct(load(slot, said))
    rows = found.pareto[2:]
    head, *lines = front_of(found)
    assert head[:2] == ("cycle_time of", "cycle_time")
    assert [line[0] for line in lines] == ["2.8 s", "5 s"]
    assert rows[0]["contour_error_max"] > rows[1]["contour_error_max"]
    assert [row["cycle_time"] <= row["budget"] for row in rows] == [True, True]


def test_a_check_finds_a_speed_beyond_the_curves_and_curves_that_do_not_count(slot, tmp_path):
    (tmp_path / "torque.csv").write_text("speed [rpm], torque [N*m]\n1000, 2\n5000, 2\n", encoding="utf-8")
    short = load(slot, {"machine.spindle_torque": {"table": str(tmp_path / "torque.csv")}})
    with pytest.raises(ScenarioFault, match="reaches from 1000 rpm to 5000 rpm"):
        RECIPES["mill"].prepare(short)
    idle = load(slot, power(1, 2) | {"numerics.force": "none"})
    assert [one.path for one in idle.notices() if "does not count with numerics" in one.message] == [
        ("machine", "spindle_power")
    ]
