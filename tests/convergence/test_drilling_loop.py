"""The drilling cycle does not move when its step is halved, and approaches its limit at first order."""

import math

import numpy as np
import pytest

from cutwise.physics.cutting.drill import shares, stress_at_feed
from cutwise.physics.cutting.drill_elements import elements_force, oblique_elements
from cutwise.process.drill_profile import depth_profile, no_elements
from cutwise.process.loops_drilling import drill_hole
from peers.robots import MATERIALS, MPA, POINT, cycle, dynamics, law


def columns(outcome):
    return np.array([
        outcome.thrust_mean, outcome.axial_mean, outcome.lateral_mean, outcome.feed_min, outcome.feed_max,
        np.hypot(*outcome.entry), np.hypot(*outcome.exit), np.hypot(*(outcome.exit - outcome.entry)),
    ])  # fmt: skip


@pytest.mark.parametrize("posture", ["stiffest", "least skating", "worst"])
@pytest.mark.parametrize("material", ["Al", "Ti"])
def test_half_the_step_moves_nothing_by_a_thousandth(material, posture):
    given, profile = cycle(material)
    coarse, fine = (drill_hole(given, dynamics(posture), profile, step=step)[0] for step in (1e-4, 5e-5))
    assert columns(coarse) == pytest.approx(columns(fine), rel=1e-3)
    assert coarse.rest == pytest.approx(fine.rest, rel=5e-3)


def test_at_least_first_order_in_the_step():
    given, profile = cycle("Al")
    steps = np.array([4e-4, 2e-4, 1e-4, 5e-5])
    exact = drill_hole(given, dynamics("stiffest"), profile, step=2.5e-6)[0].entry
    errors = [np.hypot(*(drill_hole(given, dynamics("stiffest"), profile, step=s)[0].entry - exact)) for s in steps]
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope > 0.8


def test_profile_spacing_is_fine_enough():
    kc11, exponent, friction, feed, _ = MATERIALS["Al"]
    stress = stress_at_feed(law(friction), kc11, exponent, POINT, feed)
    coarse, fine = (
        depth_profile(POINT, stress, no_elements(), margin_stress=0.5 * MPA, feed=feed, thickness=5e-3, spacing=s)
        for s in (2e-6, 2.5e-7)
    )
    assert np.interp(fine.depth, coarse.depth, coarse.thrust) == pytest.approx(fine.thrust, abs=0.12)


def test_oblique_elements_converge():
    stress = stress_at_feed(law(0.6), 650 * MPA, 0.25, POINT, 1e-4)

    def thrust(count: int) -> float:
        elements = oblique_elements(POINT, law(0.6), stress.specific, count)
        return 2 * elements_force(elements, 1e-4, 0.0, POINT.radius).thrust

    errors = [abs(thrust(n) - 94.635345) for n in (100, 200, 400)]
    assert errors[0] > 3 * errors[1] > 9 * errors[2]  # midpoint rule
    assert errors[2] < 1e-3 * sum(shares(POINT, stress, 1e-4)[:2])
    assert math.isfinite(errors[2])
