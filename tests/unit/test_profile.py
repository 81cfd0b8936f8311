"""Jerk-limited profiles and look-ahead."""

import math

import numpy as np
import pytest

from cutwise.maths.linearc import arc, join, line
from cutwise.physics.motion.lookahead import AxisLimits, arc_speed, plan, tangential_limits, time_without_limits
from cutwise.physics.motion.profile import Limits, at, chain, stretch

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
        plan(join([line((0, 0), (1, 0))]), np.array([0.0]), AXES)


@pytest.mark.parametrize("piece", [30e-3, 0.5e-3, 0.04e-3])
def test_cutting_a_line_up_changes_nothing(piece):
    n = round(30e-3 / piece)
    curve = join([line((i * piece, 0.0), ((i + 1) * piece, 0.0)) for i in range(n)])
    assert plan(curve, np.full(n, 0.1), AXES).profile.duration == pytest.approx(0.39, abs=1e-9)


def test_axis_limits_along_a_diagonal():
    """Along 45 degrees each axis may go as fast as alone: the path is quicker by sqrt 2."""
    curve = join([line((0, 0), (0.5, 0.5))])
    found = plan(curve, np.array([np.inf]), AXES)
    assert found.profile.speed.max() == pytest.approx(0.2 * math.sqrt(2.0))


def test_stops_at_corners_and_at_every_end_of_a_block_with_exact_stop():
    blocks = [line((0, 0), (0.03, 0)), line((0.03, 0), (0.06, 0)), line((0.06, 0), (0.06, 0.03))]
    curve, feed = join(blocks), np.full(3, 0.04)
    smooth, stopped = plan(curve, feed, AXES), plan(curve, feed, AXES, np.ones(2, bool))
    assert smooth.stops == 1
    assert stopped.stops == 2
    assert stopped.profile.duration - smooth.profile.duration == pytest.approx(2 * math.sqrt(0.04 / 50.0), abs=1e-9)
    assert time_without_limits(curve, feed) == pytest.approx(0.09 / 0.04)


def test_a_pause_holds_the_axes():
    curve = join([line((0, 0), (0.03, 0)), line((0.03, 0), (0.06, 0))])
    still = plan(curve, np.full(2, 0.04), AXES, None, np.array([0.5, 0.0]))
    moving = plan(curve, np.full(2, 0.04), AXES, np.ones(1, bool))
    assert still.profile.duration == pytest.approx(moving.profile.duration + 0.5)
    halfway = moving.block_time[1] + 0.25
    assert at(still.profile, np.array([halfway]))[0] == pytest.approx([0.03])


def test_arc_speed_is_bound_by_acceleration_then_by_jerk():
    assert arc_speed(1.0, 5e-3, 2.0, 1e9) == pytest.approx(math.sqrt(2.0 * 5e-3))
    assert arc_speed(1.0, 1e-3, 2.0, 50.0) == pytest.approx((50.0 * 1e-6) ** (1 / 3))
    assert arc_speed(0.02, math.inf, 2.0, 50.0) == 0.02


def full_limits_kept(curve, feed):
    """Vector acceleration and jerk between joints, by differences of a dense sampling."""
    from cutwise.physics.motion.reference import sampled

    found = plan(curve, feed, AXES)
    dt = 2e-5
    reference = sampled(curve, [found.profile], dt, 0.0)
    a = np.diff(reference.point, 2, axis=0) / dt**2
    j = np.diff(reference.point, 3, axis=0) / dt**3
    same = reference.block[3:] == reference.block[:-3]
    # differences lag by half a window: leave out the three samples about each change of phase
    edges = np.searchsorted(reference.time, found.profile.time)
    clear = np.ones(j.shape[0], bool)
    for edge in edges:
        clear[max(edge - 4, 0) : edge + 4] = False
    jerk = np.linalg.norm(j, axis=1)[same & clear]
    return np.linalg.norm(a, axis=1)[same[: a.shape[0]] if same.size == a.shape[0] else slice(None)].max(), jerk.max()


def test_a_circle_from_rest_keeps_the_limits_of_the_vector():
    curve = join([arc((0.01, 0.0), (0.0, 0.0), 2.0 * math.pi)])
    acceleration, jerk = full_limits_kept(curve, np.array([1.0]))
    assert acceleration <= 2.0 * 1.001
    assert jerk <= 50.0 * 1.01  # second differences of 20 µs samples: rounding of 1e-16/8e-15


def test_nothing_is_left_for_the_tangent_at_the_highest_arc_speed():
    speed = math.sqrt(2.0 * 0.1)
    assert tangential_limits(speed, 0.1, 2.0, 1e9)[0] == pytest.approx(0.0, abs=1e-6)
    assert tangential_limits(0.1, math.inf, 2.0, 50.0) == (2.0, 50.0)
