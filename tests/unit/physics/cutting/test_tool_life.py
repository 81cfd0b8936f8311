"""How long a tool lasts, what a part costs, and the feed at which it costs least."""

import math

import pytest

from cutwise.physics.cutting.tool_life import cheapest_feed, life_ratio, part_cost


@pytest.mark.parametrize(("place", "power"), [(0, -1 / 0.25), (1, -0.36), (2, -0.2)])
def test_the_life_goes_with_the_powers_of_taylor(place, power):
    ratios = [[1.0, 1.0, 1.0], [1.0, 1.0, 1.0]]
    ratios[1][place] = 1.7
    lives = [life_ratio(*one, speed_exponent=0.25, feed_exponent=0.36, depth_exponent=0.2) for one in ratios]
    assert lives[0] == 1.0
    assert math.log(lives[1]) / math.log(1.7) == pytest.approx(power)


def test_cost_is_the_sum_of_machine_and_edge():
    assert part_cost(2.0, 3.0) == 6.0
    assert part_cost(2.0, 3.0, 10.0, 4.0, 8.0) == pytest.approx(6.0 + 5.0)
    assert part_cost(2.0, 3.0, 10.0, 4.0) == 6.0  # a tool that lasts for ever


@pytest.mark.parametrize("exponent", [1.2, 1.5, 2.0, 3.0])
def test_the_cheapest_feed_is_a_minimum(exponent):
    rate, price, lasts, length, feed = 1 / 60, 60.0, 900.0, 1.0, 10e-3

    def cost(ratio):
        time = length / (feed * ratio)
        return part_cost(
            rate, time, price, time, lasts * life_ratio(1.0, ratio, speed_exponent=0.25, feed_exponent=exponent)
        )

    best = cheapest_feed(rate, price, lasts, exponent)
    assert cost(best) < min(cost(0.98 * best), cost(1.02 * best))
    slope = (cost(best * (1 + 1e-5)) - cost(best * (1 - 1e-5))) / (2e-5 * cost(best))
    assert slope == pytest.approx(0.0, abs=1e-8)


def test_a_dear_machine_and_a_cheap_tool_want_more_feed():
    best = cheapest_feed(1.0, 1.0, 100.0, 2.0)
    assert cheapest_feed(2.0, 1.0, 100.0, 2.0) == pytest.approx(best * math.sqrt(2.0))
    assert cheapest_feed(1.0, 4.0, 100.0, 2.0) == pytest.approx(0.5 * best)
    assert cheapest_feed(1.0, 1.0, 100.0, 1.0) == cheapest_feed(1.0, 0.0, 100.0, 2.0) == math.inf
