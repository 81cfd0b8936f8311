"""Cases side by side: intervals, differences that can be told, and what a part costs in them, against the specification."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import ndtri

from cutwise.io.scenario import load
from cutwise.process.part_cost import Use, costs, life
from cutwise.results import Measure
from cutwise.spec.faults import ScenarioFault
from cutwise.study.comparison import SURE, Case, Compared, cases_of, compare, drawn_cost, shown

CUTS = ((24.478, 21.812, 502.65), (20.920, 18.862, 502.65), (17.817, 15.724, 609.47))  # s, s, m/min
POINTS = 4000


@pytest.fixture(scope="module")
def example(request):
    root = next(p for p in request.path.parents if (p / "examples").is_dir())
    return load(root / "examples" / "compare_slot.yaml")


def draws():
    """Price of an hour and logarithm of a life in quantiles of a rank-one net."""
    k = np.arange(POINTS)
    rate = 1.0 / 60.0 * (1.0 + 0.2 * ndtri((k + 0.5) / POINTS))
    return [
        {"shop.machine_rate": r, "wear.scatter": z}
        for r, z in zip(rate, ndtri((0.5 + k * 0.6180339887498949) % 1.0), strict=True)
    ]


def part(scenario, cut):
    time, cutting, speed = cut
    use = Use(time, cutting, speed / 60.0, 1e-4, 5e-3)
    return use, life(scenario.wear, use)


@pytest.mark.parametrize(
    ("cut", "cost", "low", "high"),
    [(CUTS[0], 0.6503, 0.4700, 0.9149), (CUTS[1], 0.5582, 0.4033, 0.7864), (CUTS[2], 0.5798, 0.4092, 0.8641)],
)
def test_a_part_costs_what_the_specification_says(example, cut, cost, low, high):
    use, lasts = part(example, cut)
    assert costs(example, use)["cost_per_part"] == pytest.approx(cost, abs=6e-5)
    drawn = [drawn_cost(example, use, lasts, one) for one in draws()]
    assert np.quantile(drawn, [0.05, 0.95]) == pytest.approx([low, high], rel=2e-3)


def test_the_fastest_is_dearer_in_four_draws_of_five(example):
    one, two = ([drawn_cost(example, *part(example, cut), draw) for draw in draws()] for cut in (CUTS[1], CUTS[2]))
    assert np.mean(np.array(two) > np.array(one)) == pytest.approx(0.790, abs=0.003)


def test_without_tool_data_the_machine_alone_costs(example):
    use, _ = part(example, CUTS[0])
    bare = example.model_copy(update={"wear": None})
    assert costs(bare, use)["cost_per_part"] == pytest.approx(24.478 / 60.0)
    assert drawn_cost(bare, use, None, {"shop.machine_rate": 2.0 / 60.0}) == pytest.approx(2 * 24.478 / 60.0)


def made(**measures):
    """Cases of given values, with draws where a pair is given."""
    cases = []
    for name in ("a", "b"):
        values = {key: pair[name == "b"] for key, pair in measures.items()}
        result = SimpleNamespace(
            measures={key: Measure(value[0], "time") for key, value in values.items()}, verdict="none", checks=()
        )
        cases.append(Case(name, SimpleNamespace(), result, {key: np.array(value[1]) for key, value in values.items()}))
    return Compared(tuple(cases), tuple(measures), (), 4)


def test_a_difference_is_told_by_the_draws_that_share_its_sign():
    found = made(cycle_time=((2.0, [2.0, 2.1, 1.9, 2.0]), (3.0, [3.0, 1.9, 3.1, 3.2])))
    a, b = found.cases
    assert found.least("cycle_time") is a
    assert found.agreement(a, b, "cycle_time") == 0.75 < SURE
    assert found.interval(a, "cycle_time") == pytest.approx(np.quantile([2.0, 2.1, 1.9, 2.0], [0.05, 0.95]))
    assert any("not distinguishable (75 %)" in line for line in shown(found))
    lost = made(cycle_time=((2.0, [math.nan, 2.1]), (3.0, [3.0, math.nan])))
    assert lost.agreement(*lost.cases, "cycle_time") is None
    assert made(cycle_time=((2.0, [2.0]), (2.0, [2.0]))).agreement(*lost.cases, "mass") is None


def test_nothing_required_is_no_pass():
    found = made(cycle_time=((2.0, [2.0]), (3.0, [3.0])))
    assert found.verdict == "none"
    found.cases[0].result.verdict = "pass"
    assert found.verdict == "pass"
    found.cases[1].result.verdict = "fail"
    assert found.verdict == "fail"


def test_cases_of_a_scenario_are_run_in_the_same_draws(slot):
    said = {
        "shop": {"machine_rate": "60 EUR/h"},
        "compare": {"draws": 2000, "cases": {"plain": {}, "fine": {"tool.diameter": "11.9 mm"}},
                    "vary": {"shop.machine_rate": {"normal": {"mean": "60 EUR/h", "deviation": "6 EUR/h"}}}},
    }  # fmt: skip
    found = compare(cases_of(load(slot, said)), measures=("cycle_time", "cost_per_part"))
    plain, fine = found.cases
    assert found.unequal == ("tool",)
    assert found.measures == ("cycle_time", "cost_per_part")
    low, high = found.interval(plain, "cost_per_part")
    mean = plain.result.measures["cost_per_part"].value
    assert (low / mean, high / mean) == pytest.approx((1 - 0.164485, 1 + 0.164485), rel=1e-2)
    assert plain.draws["cost_per_part"] == pytest.approx(
        fine.draws["cost_per_part"], rel=1e-9
    )  # the same path, the same price
    assert plain.result.measures["cutting_time"].value == pytest.approx(1.8 + 3 * math.sqrt(10.0 / 50000.0), abs=4e-3)


def test_faults_of_cases_are_told_together(slot):
    with pytest.raises(ScenarioFault) as told:
        cases_of(load(slot, {"compare": {"cases": {"a": {"tool.diametre": "1 mm"}, "b": {"tool.flutes": 0}}}}))
    assert len(told.value.faults) == 2
    with pytest.raises(ScenarioFault, match="name cases"):
        cases_of(load(slot))


def test_a_case_may_have_a_section_and_a_list_with_units_as_they_are_written(slot):
    curve = {"columns": {"speed [rpm]": [1000, 9000], "power [kW]": [1, 2]}}
    modes = [{"direction": "x", "frequency": "900 Hz", "damping": 0.03, "stiffness": "20 N/um"}]
    cases = {
        "plain": {},
        "curve": {"machine.spindle_power": curve},
        "swings": {"tool.modes": modes},
        "rigid": {"tool.stiffness": None},
    }
    found = cases_of(load(slot, {"compare": {"cases": cases}}))
    assert found["curve"].machine.spindle_power.points()[1] == (1000.0, 2000.0)
    assert found["swings"].tool.modes[0].stiffness == pytest.approx(20e6)
    assert found["rigid"].tool.stiffness is None
    curve["columns"]["speed [rpm]"][1] = 3000
    with pytest.raises(ScenarioFault, match=r"case curve: machine\.spindle_power: reaches from 1000 rpm to 3000 rpm"):
        compare(cases_of(load(slot, {"compare": {"cases": {"curve": cases["curve"], "plain": {}}}})))
