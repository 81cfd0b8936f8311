"""Jerk-limited profiles and look-ahead."""

import math
from itertools import pairwise

import numpy as np
import pytest

from cutwise.maths.linearc import arc, join, line
from cutwise.physics.motion.lookahead import (
    AxisLimits,
    arc_speed,
    plan,
    time_without_limits,
)
from cutwise.physics.motion.profile import Limits, at, chain, stretch
from cutwise.physics.motion.ramps import tangential_acceleration

PATH = Limits(0.2, 2.0, 50.0)
FREE = Limits(math.inf, math.inf, math.inf)
AXES = AxisLimits(np.full(3, 0.2), np.full(3, 2.0), np.full(3, 50.0))

CASES = [  # length, start, end speed, limits: cruise or not, acceleration held or not
    (30e-3, 0.0, 0.0, Limits(0.1, 2.0, 50.0)),
    (30e-3, 0.0, 0.0, Limits(0.04, 2.0, 50.0)),
    (1e-3, 0.0, 0.0, Limits(0.1, 2.0, 50.0)),
    (300e-3, 0.0, 0.0, Limits(0.5, 2.0, 50.0)),
    (20e-3, 0.05, 0.02, Limits(0.1, 2.0, 50.0)),
    (20e-3, 0.0, 0.08, Limits(0.1, 1.0, 80.0)),
    (8e-3, 0.1, 0.0, Limits(0.1, 2.0, 50.0)),
]


def total(case):
    return sum(duration for duration, _ in stretch(*case))


@pytest.mark.parametrize("case", CASES)
def test_times_agree_with_ruckig(case):
    ruckig = pytest.importorskip("ruckig")
    length, v0, v1, limits = case
    given = ruckig.InputParameter(1)
    given.current_position, given.current_velocity, given.current_acceleration = [0.0], [v0], [0.0]
    given.target_position, given.target_velocity, given.target_acceleration = [length], [v1], [0.0]
    given.max_velocity, given.max_acceleration, given.max_jerk = [limits.speed], [limits.acceleration], [limits.jerk]
    found = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(given, found)
    assert total(case) == pytest.approx(found.duration, abs=1e-9)


@pytest.mark.parametrize("case", CASES)
def test_profile_ends_where_it_should_and_keeps_its_limits(case):
    length, v0, v1, limits = case
    run = chain(stretch(*case), v0)
    assert run.position[-1] == pytest.approx(length, abs=1e-12)
    assert run.speed[-1] == pytest.approx(v1, abs=1e-12)
    assert run.acceleration[-1] == pytest.approx(0.0, abs=1e-9)
    position, speed, acceleration = at(run, np.linspace(0.0, run.duration * (1 - 1e-12), 5000))
    assert speed.max() <= limits.speed * (1 + 1e-9)
    assert np.abs(acceleration).max() <= limits.acceleration * (1 + 1e-9)
    assert np.abs(run.jerk).max() <= limits.jerk
    assert np.all(np.diff(position) >= -1e-15)


def test_a_stretch_too_short_to_stop_is_an_error():
    with pytest.raises(ValueError, match="too short"):
        stretch(1e-3, 0.1, 0.0, Limits(0.1, 2.0, 50.0))


def test_limits_of_zero_are_an_error():
    with pytest.raises(ValueError, match="positive"):
        stretch(1e-3, 0.0, 0.0, Limits(0.1, 0.0, 50.0))
    with pytest.raises(ValueError, match="positive"):
        plan(join([line((0, 0), (1, 0))]), np.array([0.0]), PATH)


@pytest.mark.parametrize("piece", [30e-3, 0.5e-3, 0.04e-3])
def test_cutting_a_line_up_changes_nothing(piece):
    n = round(30e-3 / piece)
    curve = join([line((i * piece, 0.0), ((i + 1) * piece, 0.0)) for i in range(n)])
    assert plan(curve, np.full(n, 0.1), PATH).profile.duration == pytest.approx(0.39, abs=1e-9)


def test_axis_limits_along_a_diagonal():
    """Along 45 degrees each axis may go as fast as alone: the path is quicker by sqrt 2."""
    curve = join([line((0, 0), (0.5, 0.5))])
    found = plan(curve, np.array([np.inf]), FREE, axes=AXES)
    assert found.profile.speed.max() == pytest.approx(0.2 * math.sqrt(2.0))
    assert plan(curve, np.array([np.inf]), PATH).profile.speed.max() == pytest.approx(0.2)


def test_stops_at_corners_and_at_every_end_of_a_block_with_exact_stop():
    blocks = [line((0, 0), (0.03, 0)), line((0.03, 0), (0.06, 0)), line((0.06, 0), (0.06, 0.03))]
    curve, feed = join(blocks), np.full(3, 0.04)
    smooth, stopped = plan(curve, feed, PATH), plan(curve, feed, PATH, np.ones(2, bool))
    assert smooth.stops == 1
    assert stopped.stops == 2
    assert stopped.profile.duration - smooth.profile.duration == pytest.approx(2 * math.sqrt(0.04 / 50.0), abs=1e-9)
    assert time_without_limits(curve, feed) == pytest.approx(0.09 / 0.04)


def test_a_pause_holds_the_axes():
    curve = join([line((0, 0), (0.03, 0)), line((0.03, 0), (0.06, 0))])
    still = plan(curve, np.full(2, 0.04), PATH, None, np.array([0.5, 0.0]))
    moving = plan(curve, np.full(2, 0.04), PATH, np.ones(1, bool))
    assert still.profile.duration == pytest.approx(moving.profile.duration + 0.5)
    halfway = moving.block_time[1] + 0.25
    assert at(still.profile, np.array([halfway]))[0] == pytest.approx([0.03])


def test_arc_speed_is_bound_by_acceleration_then_by_jerk():
    assert arc_speed(1.0, 5e-3, 2.0, 1e9) == pytest.approx(math.sqrt(2.0 * 5e-3))
    assert arc_speed(1.0, 1e-3, 2.0, 50.0) == pytest.approx((50.0 * 1e-6) ** (1 / 3))
    assert arc_speed(0.02, math.inf, 2.0, 50.0) == 0.02


def test_a_circle_from_rest_keeps_the_limits():
    """Vector of the acceleration, and jerk along the path; the turning of the frame comes on top of the latter."""
    curve = join([arc((0.01, 0.0), (0.0, 0.0), 2.0 * math.pi)])
    found = plan(curve, np.array([1.0]), PATH)
    _, speed, along = at(found.profile, np.linspace(0.0, found.profile.duration, 20001))
    assert np.hypot(along, speed**2 / 0.01).max() <= 2.0 * (1 + 1e-9)
    assert np.abs(found.profile.jerk).max() <= 50.0
    assert speed.max() <= arc_speed(1.0, 0.01, 2.0, 50.0)
    loose = plan(curve, np.array([1.0]), PATH, count_normal=False)
    assert loose.profile.duration < found.profile.duration


def rectangle(a, b, radius):
    """Centre path of a pass, half sizes and corner radius in mm, from the end of the lower left fillet round to it."""
    a, b, r = 1e-3 * a, 1e-3 * b, 1e-3 * radius
    if r == 0.0:
        ends = [(-a, -b), (a, -b), (a, b), (-a, b), (-a, -b)]
        return [line(p, q) for p, q in pairwise(ends)]
    quarter = 0.5 * math.pi
    return [
        line((-a + r, -b), (a - r, -b)), arc((a - r, -b), (a - r, -b + r), quarter),
        line((a, -b + r), (a, b - r)), arc((a, b - r), (a - r, b - r), quarter),
        line((a - r, b), (-a + r, b)), arc((-a + r, b), (-a + r, b - r), quarter),
        line((-a, b - r), (-a, -b + r)), arc((-a, -b + r), (-a + r, -b + r), quarter),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("feed", "smooth", "stopped"), [(40, 23.28528, 24.07787), (100, 10.80058, 11.80354), (169, 8.09612, 9.10120)]
)
def test_times_of_the_reference_pocket(feed, smooth, stopped):
    """100 x 60 mm in five passes from the inside out, 890.0128 mm with straight links.

    The reference leaves the normal acceleration out of the limit (F100, F169). Counting it is what its own text asks
    for, a_t <= sqrt(a^2 - (v^2/r)^2), and costs up to half a percent.
    """
    blocks, home = [], None
    for size in ((24, 4, 0), (28, 8, 0), (32, 12, 0), (36, 16, 1), (40, 20, 5)):
        new = rectangle(*size)
        if home is not None:
            blocks.append(line(home, new[0].start))
        blocks += new
        home = new[0].start
    curve = join(blocks)
    assert 1e3 * curve.knots[-1] == pytest.approx(890.0128, abs=1e-4)
    feeds, stops = np.full(curve.count, 1e-3 * feed), np.ones(curve.count - 1, bool)
    assert plan(curve, feeds, PATH, count_normal=False).profile.duration == pytest.approx(smooth, abs=1e-5)
    assert plan(curve, feeds, PATH, stops, count_normal=False).profile.duration == pytest.approx(stopped, abs=1e-5)
    for stop, time in ((None, smooth), (stops, stopped)):
        counted = plan(curve, feeds, PATH, stop).profile.duration
        if feed == 40:
            assert counted == pytest.approx(time, abs=2e-5)
        else:
            assert 1.0005 < counted / time < 1.006


def test_nothing_is_left_for_the_tangent_at_the_highest_arc_speed():
    speed = math.sqrt(2.0 * 0.1)
    assert tangential_acceleration(speed, 0.1, 2.0) == pytest.approx(0.0, abs=1e-6)
    assert tangential_acceleration(0.1, math.inf, 2.0) == 2.0
