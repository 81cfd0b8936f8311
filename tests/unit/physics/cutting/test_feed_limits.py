"""Limits of the feed of a contact: figures of an independent reference program, and the kernel of the run itself."""

import math

import numpy as np
import pytest

from cutwise.physics.cutting.affine_limits import (
    CHIP,
    MEAN,
    MOST_ERROR,
    PEAK,
    POWER,
    REMOVAL,
    RUBBING,
    TORQUE,
    WALL,
    WALL_FROM,
    Bounds,
)
from cutwise.physics.cutting.discs import discs
from cutwise.physics.cutting.feed_limits import Teeth, feed_intervals
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.uneven import even_edges
from cutwise.physics.cutting.wall import DISCS, FLUTES, tooth_period

K = EdgeCoefficients(767.01e6, 168.8e6, 222e6, 27.7e3, 26.6e3, 0.7e3)
SHEAR, EDGE = (
    even_edges(k) for k in (K._replace(K_te=0.0, K_re=0.0, K_ae=0.0), K._replace(K_tc=0.0, K_rc=0.0, K_ac=0.0))
)
MILL, DEPTH, SPEED = Mill(10e-3, 3, math.radians(30)), 5e-3, 8000 * math.pi / 30
PARTS = discs(10e-3, math.radians(30), DEPTH, 3, 20)
NONE = Bounds(math.inf, math.inf, math.inf, math.inf, math.inf, 0.0, -math.inf, math.inf, math.inf)
SOFT = np.eye(2) / 20e6


def looked_at(angles, feed, bounds=NONE, law=DISCS, walls=(1.0, 0.0), heading=0.0, low=0.0):
    n = len(angles)
    patches = np.array([[[math.radians(low), math.radians(a), 0.0, DEPTH]] for a in angles])
    return feed_intervals(
        patches, np.tile(walls, (n, 1)), np.full(n, heading), np.full(n, feed), np.full(n, SPEED),
        Teeth(law, MILL, PARTS, SHEAR, EDGE), SOFT, bounds,
    )  # fmt: skip


def test_feeds_under_the_force_of_the_slot_are_those_of_the_reference():
    high, _, _ = looked_at([30, 53.1301, 70, 90, 100, 143, 180], 1e-4, NONE._replace(peak=562.174))
    assert 1e3 * high[:, PEAK] == pytest.approx([0.27474, 0.14058, 0.11396, 0.10115, 0.1, 0.1, 0.1], rel=2e-4)


def test_values_of_the_slot_and_of_the_wall_are_those_of_the_reference():
    _, _, value = looked_at([180, 53.1301], 1e-4)
    assert value[0, PEAK] == pytest.approx(562.174, abs=5e-4)
    assert value[0, POWER] == pytest.approx(4808.5, abs=0.1)
    assert value[0, POWER] == pytest.approx(SPEED * value[0, TORQUE])
    assert value[1, WALL] == pytest.approx(-8.2248e-6, abs=1e-10)
    zero, one = (looked_at([53.1301], f)[2][0, WALL] for f in (0.0, 1e-3))
    assert (1e6 * zero, 1e6 * (one - zero)) == pytest.approx((-7.1756, -10.4916), abs=1e-4)


@pytest.mark.parametrize("law", [DISCS, FLUTES])
@pytest.mark.parametrize("column", [PEAK, MEAN, POWER, TORQUE, CHIP, REMOVAL])
def test_a_value_at_its_highest_feed_is_the_limit(law, column):
    names = {PEAK: "peak", MEAN: "mean", POWER: "power", TORQUE: "torque", CHIP: "chip", REMOVAL: "removal"}
    for angle, low in ((37.0, 0.0), (120.0, 20.0), (180.0, 100.0)):
        now = looked_at([angle], 1.3e-4, law=law, low=low)[2][0, column]
        high = looked_at([angle], 1.0, NONE._replace(**{names[column]: now}), law=law, low=low)[0]
        assert high[0, column] == pytest.approx(1.3e-4, rel=1e-9)


def test_walls_bound_the_feed_from_both_sides():
    bounds = NONE._replace(least_error=-9e-6, most_error=-8e-6)
    # every disc has to be within: the last one is not pushed at all, so that nothing satisfies the upper side
    high, low, _ = looked_at([53.1301], 0.0, bounds)
    assert high[0, WALL] == pytest.approx((9e-6 - 7.17560e-6) / 10.4916e-3, rel=1e-4)
    assert low[0, WALL_FROM] > high[0, WALL]
    assert looked_at([53.1301], 0.0, NONE._replace(least_error=-7e-6))[0][0, WALL] < 0.0  # no feed helps


def test_a_chip_that_is_thick_enough_asks_for_a_feed():
    _, low, _ = looked_at([30.0], 0.0, NONE._replace(least_chip=2e-5))
    assert low[0, RUBBING] == pytest.approx(4e-5)


def test_the_peak_is_that_of_the_kernel_of_the_run():
    edges = even_edges(K)
    for angle in (40.0, 95.0):
        tooth = tooth_period(FLUTES, 0.0, math.radians(angle), 8e-5, DEPTH, MILL, PARTS, edges, 120)
        value = looked_at([angle], 8e-5, law=FLUTES)[2]
        assert value[0, PEAK] == pytest.approx(np.hypot(tooth[:, 0], tooth[:, 1]).max(), rel=1e-9)


@pytest.mark.parametrize(
    ("left", "low", "high"), [(False, 0.0, 60.0), (False, 0.0, 140.0), (True, 120.0, 180.0), (True, 40.0, 180.0)]
)
def test_walls_are_those_of_the_discs_one_by_one(left, low, high):
    feed, z = 1e-4, (np.arange(20) + 0.5) * DEPTH / 20
    lag, errors = z * math.tan(MILL.helix) / MILL.radius, []
    wall = math.pi if left else 0.0
    for e in range(20):
        force = 0.0
        for tooth in range(3):
            for d in range(20):
                at = (wall + lag[d] - lag[e] + 2 * math.pi * tooth / 3) % (
                    2 * math.pi
                )  # from the right side of the feed
                if (d == e and tooth == 0) or not math.radians(low) < at < math.radians(high):
                    continue
                tangential, radial = (k1 * feed * math.sin(at) + k2 for k1, k2 in ((K.K_tc, K.K_te), (K.K_rc, K.K_re)))
                # at the right side (at = 0) a tooth goes back, and the work pushes it forward and towards the axis
                off = tangential * math.sin(at) + radial * math.cos(at)
                force += (off if not left else -off) * DEPTH / 20
        errors.append(-force / 20e6)
    _, _, value = looked_at([high], feed, walls=(0.0, 1.0) if left else (1.0, 0.0), low=low)
    assert value[0, WALL] == pytest.approx(min(errors), rel=1e-6)
    assert value[0, MOST_ERROR] == pytest.approx(max(errors), rel=1e-6, abs=1e-15)


def test_directions_turn_with_the_heading_when_the_tip_does_not_yield_alike():
    patches = np.array([[[0.0, 1.0, 0.0, DEPTH]]])
    teeth, walls, one = Teeth(DISCS, MILL, PARTS, SHEAR, EDGE), np.array([[1.0, 0.0]]), np.ones(1)
    soft = np.diag([1 / 18e6, 1 / 20e6])
    errors = [
        feed_intervals(patches, walls, turn * one, 1e-4 * one, SPEED * one, teeth, soft, NONE)[2][0, WALL]
        for turn in (0.0, 0.5 * math.pi, math.pi)
    ]
    assert errors[1] == pytest.approx(errors[0] * 20 / 18)  # along y the wall stands across x
    assert errors[2] == pytest.approx(errors[0])


def test_rescaling_length_and_force():
    _, _, one = looked_at([70.0], 1e-4)
    factor = 2.5
    mill = Mill(factor * MILL.radius, 3, MILL.helix)
    teeth = Teeth(FLUTES, mill, discs(mill.radius, mill.helix, factor * DEPTH, 3, 20), SHEAR, EDGE._replace(
        linear=EDGE.linear._replace(K_te=factor * K.K_te, K_re=factor * K.K_re, K_ae=factor * K.K_ae)))  # fmt: skip
    patches = np.array([[[0.0, math.radians(70.0), 0.0, factor * DEPTH]]])
    _, _, two = feed_intervals(
        patches, np.zeros((1, 2)), np.zeros(1), np.array([factor * 1e-4]), np.array([SPEED]), teeth, SOFT, NONE
    )
    assert two[0, MEAN] == pytest.approx(factor**2 * one[0, MEAN], rel=1e-9)
    assert two[0, TORQUE] == pytest.approx(factor**3 * one[0, TORQUE], rel=1e-9)


def straight_flutes(*arcs, peak=math.inf):
    mill = Mill(6e-3, 2, 0.0)
    teeth = Teeth(FLUTES, mill, discs(6e-3, 0.0, 3e-3, 2, 1), SHEAR, EDGE)
    patches = np.array([[[*(math.radians(a) for a in arc), 0.0, 3e-3] for arc in arcs]])
    high, _, value = feed_intervals(
        patches, np.zeros((1, 2)), np.zeros(1), np.full(1, 5e-5), np.full(1, 600.0), teeth, SOFT, NONE._replace(peak=peak)
    )  # fmt: skip
    return float(value[0, PEAK]), float(high[0, PEAK])


@pytest.mark.parametrize("ends", [(0.0, 14.8351), (0.0, 33.5573), (0.0, 60.0), (147.3, 180.0), (20.0, 71.7)])
def test_the_force_of_a_straight_flute_is_largest_at_the_end_of_its_arc(ends):
    def force(f):
        chip = f * max(math.sin(math.radians(end)) for end in ends)
        return 3e-3 * math.hypot(K.K_tc * chip + K.K_te, K.K_rc * chip + K.K_re)

    peak, feed = straight_flutes(ends, peak=force(8e-5))
    assert peak == pytest.approx(force(5e-5), rel=1e-6)
    assert feed == pytest.approx(8e-5, rel=1e-6)


def test_a_straight_flute_where_two_arcs_meet_is_there_once():
    assert straight_flutes((0.0, 90.0), (90.0, 180.0))[0] == pytest.approx(straight_flutes((0.0, 180.0))[0], rel=1e-4)
