"""Distributions that corrections and comparisons draw from."""

import pytest

from cutwise.io.scenario import load
from cutwise.spec.faults import ScenarioFault
from cutwise.study.correct.uncertain import random_of

KEY = "shop.machine_rate"


def test_distributions_of_a_comparison_are_read_and_lists_are_refused(examples):
    scenario = load(examples / "compare_slot.yaml")
    assert set(
        random_of(scenario, {KEY: {"normal": {"mean": "84 EUR/h", "deviation": "21 EUR/h"}}}, ("compare", "vary"))
    ) == {KEY}
    with pytest.raises(ScenarioFault, match="list of values"):
        random_of(scenario, {KEY: ["60 EUR/h", "70 EUR/h"]}, ("compare", "vary"))
