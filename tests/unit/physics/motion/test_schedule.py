"""Feeds over cells: against every combination, and the laws of ramps."""

import itertools
import math

import numpy as np
import pytest

from cutwise.physics.motion.feed_stretches import Pieces, Ramps, anticipated, merged_feeds, stretch_times, time_bound
from cutwise.physics.motion.schedule import Rules, Runs, feed_levels, quickest_levels, ramp_loss, scheduled_feeds

RAMPS = Ramps(2.0, 50.0)
REST = np.zeros(2)


@pytest.mark.parametrize(
    ("length", "feed", "gain"),
    [(1, 80, 0.57), (2, 80, 3.84), (5, 80, 31.7), (10, 80, 96.7), (20, 80, 221.7), (10, 160, 109.2), (20, 160, 300.0)],
)
def test_a_quick_stretch_between_slow_ones_gains_what_the_reference_says(length, feed, gain):
    lengths = np.array([0.1, 1e-3 * length, 0.1])
    speeds = np.array([0.04, 1e-3 * feed, 0.04])
    times, _ = stretch_times(lengths, speeds, np.full(3, 2.0), 50.0, np.array([0.04, 0.04]))
    assert 1e3 * (lengths.sum() / 0.04 - times.sum()) == pytest.approx(gain, abs=0.05 if gain > 5 else 0.005)


@pytest.mark.parametrize("seed", range(6))
def test_the_levels_are_the_best_of_all(seed):
    rng = np.random.default_rng(seed)
    length, cap = rng.uniform(1e-3, 8e-3, 6), rng.uniform(0.03, 0.16, 6)
    levels, gain = np.array([0.03, 0.05, 0.08, 0.13]), 2e-3
    found = quickest_levels(length, cap, REST, levels, gain, RAMPS)

    def cost(chosen):
        speed = levels[list(chosen)]
        if ((speed > cap * (1 + 1e-6)) & (speed > levels[0])).any():
            return math.inf
        changes = sum(ramp_loss(a, b, RAMPS) + gain for a, b in itertools.pairwise(speed) if a != b)
        return (length / speed).sum() + changes + ramp_loss(0.0, speed[0], RAMPS) + ramp_loss(0.0, speed[-1], RAMPS)

    best = min(cost(chosen) for chosen in itertools.product(range(4), repeat=6))
    assert cost(found) == pytest.approx(best, rel=1e-12)


def test_no_feed_is_above_its_cell_and_no_schedule_below_the_bound():
    rng = np.random.default_rng(4)
    cap = 0.03 + 0.1 * np.abs(np.convolve(rng.normal(size=400), np.ones(15) / 15, "same"))
    length = np.full(400, 0.25e-3)
    runs = Runs(np.array([0, 400]), np.zeros((1, 2)), length, cap, np.zeros(400), np.arange(400) // 80)
    feed = scheduled_feeds(runs, feed_levels(0.04, cap.min(), 0.2), Rules(1e-3, 2e-3, 1e-3 / 60, RAMPS))
    assert (feed <= cap * (1 + 1e-6)).all()
    assert feed * 60e3 == pytest.approx((feed * 60e3).round(), abs=1e-6)
    times, _ = stretch_times(length, feed, np.full(400, 2.0), 50.0, REST)
    assert time_bound(length, cap, np.zeros(400), 2.0, REST) < times.sum()
    assert times.sum() < 1.001 * stretch_times(length, np.full(400, feed.min()), np.full(400, 2.0), 50.0, REST)[0].sum()


def test_merging_never_costs_more_than_half_a_gain_a_pair_and_lowers_feeds_alone():
    rng = np.random.default_rng(1)
    feed = rng.uniform(0.03, 0.06, 60)
    pieces = Pieces(np.full(60, 2e-3), np.zeros(60), feed, np.arange(60))
    merged, stretch = merged_feeds(pieces, 1e-3, RAMPS, REST)
    assert (merged <= feed).all()
    before, after = (stretch_times(pieces.length, v, np.full(60, 2.0), 50.0, REST)[0].sum() for v in (feed, merged))
    assert stretch[-1] < 59
    assert after - before <= 0.5e-3 * (59 - stretch[-1]) + 1e-9


def test_short_pieces_of_a_block_are_as_slow_as_their_neighbours():
    cap = np.array([0.04, 0.12, 0.04])
    runs = Runs(
        np.array([0, 3]), np.array([[0.04, 0.04]]), np.array([0.1, 2e-3, 0.1]), cap, np.zeros(3), np.zeros(3, int)
    )
    levels = feed_levels(0.04, 0.04, 0.2)
    quick, slow = (scheduled_feeds(runs, levels, Rules(1e-3, t, 1e-3 / 60, RAMPS)) for t in (1e-3, 30e-3))
    assert quick[1] > 0.1
    assert slow[1] == pytest.approx(0.04, rel=1e-6)


def test_a_control_that_ramps_behind_the_border_begins_earlier():
    cap = np.r_[np.full(40, 0.16), np.full(10, 0.04), np.full(40, 0.16)]
    seen = anticipated(cap, np.full(90, 0.25e-3), RAMPS)
    assert (seen <= cap).all()
    assert seen[38] == pytest.approx(0.04)
    assert (seen[50:] == 0.16).all()  # nothing to be anticipated behind it


def test_scaling_of_length_and_time():
    length, cap = np.full(50, 1e-3), np.linspace(0.03, 0.1, 50)
    one = time_bound(length, cap, np.zeros(50), 2.0, REST)
    two = time_bound(3 * length, 3 * cap / 5, np.zeros(50), 2.0 * 3 / 25, REST)
    assert two == pytest.approx(5 * one, rel=1e-12)


def test_a_slow_move_in_long_cells_takes_no_longer_than_its_bound_says():
    """From rest to rest, 3 mm in 12 cells at 8 mm/s: L/v + v/a, although the ramps are much shorter than a cell."""
    bound = time_bound(np.full(12, 0.25e-3), np.full(12, 8e-3), np.zeros(12), 2.0, REST)
    assert bound == pytest.approx(3e-3 / 8e-3 + 8e-3 / 2.0, rel=1e-9)
    assert time_bound(np.array([1e-3]), np.array([9.0]), np.zeros(1), 2.0, REST) == pytest.approx(
        2 * math.sqrt(1e-3 / 2)
    )
