"""Look-ahead over blocks of different feeds: against ruckig, within every limit, and however blocks are cut up."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cutwise.maths.linearc import arc, block_at, block_point, block_turn, join, line, sample
from cutwise.physics.motion import levels
from cutwise.physics.motion.lookahead import plan
from cutwise.physics.motion.profile import Limits, at, stretch

PATH = Limits(0.2, 2.0, 50.0)


def straight(lengths):
    ends = np.concatenate(([0.0], np.cumsum(lengths)))
    return join([line((a, 0.0), (b, 0.0)) for a, b in itertools.pairwise(ends)])


def time(curve, feed, **more):
    return plan(curve, np.asarray(feed, dtype=float), PATH, **more).profile.duration


def ruckig_time(length, v0, v1, top):
    ruckig = pytest.importorskip("ruckig")
    given = ruckig.InputParameter(1)
    given.current_position, given.current_velocity, given.current_acceleration = [0.0], [v0], [0.0]
    given.target_position, given.target_velocity, given.target_acceleration = [length], [v1], [0.0]
    given.max_velocity, given.max_acceleration, given.max_jerk = [top], [PATH.acceleration], [PATH.jerk]
    found = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(given, found)
    return found.duration


@pytest.mark.parametrize("ratio", [0.99, 0.9, 0.83, 0.79, 0.5])
@pytest.mark.parametrize("length", [1e-3, 2e-3, 30e-3])
def test_a_scheduled_program_takes_the_time_of_its_own_feeds(ratio, length):
    """Feeds by turns, as an optimiser writes them: 0.1 joined those within 20 % at the lower one, 1.1 % too slow or more."""
    fast = 0.03
    feed = [fast, ratio * fast] * 6
    rises = [0.0] + [ratio * fast] * 11 + [0.0]
    expected = sum(ruckig_time(length, a, b, f) for (a, b), f in zip(itertools.pairwise(rises), feed, strict=True))
    assert time(straight([length] * 12), feed) == pytest.approx(expected, abs=1e-9)


def test_a_rise_over_short_blocks_of_rising_feeds_is_one_ramp():
    """Stairs that a ramp from rest never touches cost nothing: the time is that of the highest feed alone."""
    lengths = [0.02e-3] * 50 + [40e-3]
    feed = [*list(np.linspace(0.08, 0.1, 50)), 0.1]
    assert time(straight(lengths), feed) == pytest.approx(ruckig_time(41e-3, 0.0, 0.0, 0.1), abs=1e-9)


def pieces(draw, count, curved):
    """Tangent lines and arcs in a plane, with a feed each."""
    point, heading, blocks, feed = np.zeros(3), 0.0, [], []
    base = 10 ** draw(st.floats(-3, -0.8))
    for _ in range(count):
        way = np.array([math.cos(heading), math.sin(heading), 0.0])
        if curved and draw(st.booleans()):
            radius, sweep = 10 ** draw(st.floats(-4.5, -1)), draw(st.sampled_from([-1, 1])) * draw(st.floats(0.02, 3.0))
            centre = point + radius * math.copysign(1.0, sweep) * np.array([-way[1], way[0], 0.0])
            block = arc(point, centre, sweep)
            heading += sweep
        else:
            block = line(point, point + 10 ** draw(st.floats(-5, -1.3)) * way)
        blocks.append(block)
        point = np.array(block_point(join([block]), 0, block.length))
        feed.append(math.inf if draw(st.integers(0, 9)) == 0 else base * draw(st.floats(0.6, 1.6)))
    return join(blocks), np.array(feed)


@st.composite
def paths(draw):
    curve, feed = pieces(draw, draw(st.integers(1, 14)), draw(st.booleans()))
    stops = np.array([draw(st.integers(0, 9)) == 0 for _ in range(curve.count - 1)], dtype=bool)
    return curve, feed, stops


def limit_at(curve, feed, block):
    """Highest speed [m/s] on blocks by feed, acceleration and jerk."""
    bend = curve.curvature[block]
    with np.errstate(divide="ignore"):
        bent = np.minimum(np.sqrt(PATH.acceleration / bend), np.cbrt(PATH.jerk / bend**2))
    return np.minimum(np.minimum(feed[block], PATH.speed), np.where(bend > 0.0, bent, math.inf))


@settings(max_examples=150, deadline=None, derandomize=True)
@given(paths())
def test_no_limit_is_exceeded_and_no_motion_is_quicker_than_its_bounds(case):
    curve, feed, stops = case
    found = plan(curve, feed, PATH, stops)
    run = found.profile
    steps = np.diff(run.time)
    after = run.position[:-1] + steps * (
        run.speed[:-1] + steps * (run.acceleration[:-1] / 2.0 + steps * run.jerk / 6.0)
    )
    np.testing.assert_allclose(after, run.position[1:], atol=1e-12)
    np.testing.assert_allclose(
        run.speed[:-1] + steps * (run.acceleration[:-1] + steps * run.jerk / 2.0), run.speed[1:], atol=1e-10
    )
    np.testing.assert_allclose(run.acceleration[:-1] + steps * run.jerk, run.acceleration[1:], atol=1e-7)
    instants = np.unique(np.concatenate((np.linspace(0.0, run.duration * (1 - 1e-12), 3000), run.time[:-1])))
    place, speed, along = at(run, instants)
    assert np.diff(place).min() >= -1e-14
    inside = np.abs(place[:, None] - curve.knots).min(axis=1) > 1e-8
    block = sample(curve, curve.knots, place)[2][inside]
    limit = limit_at(curve, feed, block)
    assert np.all(speed[inside] <= limit * (1 + 1e-7))
    assert np.hypot(along[inside], speed[inside] ** 2 * curve.curvature[block]).max() <= PATH.acceleration * (1 + 1e-7)
    assert np.abs(run.jerk).max() <= PATH.jerk * (1 + 1e-12)
    least = float((curve.length / limit_at(curve, feed, np.arange(curve.count))).sum())
    assert run.duration >= least
    total = float(curve.knots[-1])
    assert run.duration >= sum(d for d, _ in stretch(total, 0.0, 0.0, PATH)) * (1 - 1e-12)
    assert found.joint_speed[1:-1][stops] == pytest.approx(np.zeros(int(stops.sum())))


def cut_up(curve, feed, parts):
    """Every block in so many pieces."""
    blocks = []
    for i in range(curve.count):
        whole, size = block_at(curve, i), float(curve.length[i]) / parts
        for k in range(parts):
            phi = block_turn(curve, i, k * size)
            t, n = np.array(whole.along), np.array(whole.inward)
            blocks.append(
                whole._replace(
                    start=block_point(curve, i, k * size), length=size,
                    along=tuple(math.cos(phi) * t + math.sin(phi) * n),
                    inward=tuple(math.cos(phi) * n - math.sin(phi) * t),
                )
            )  # fmt: skip
    return join(blocks), np.repeat(feed, parts)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(paths(), st.integers(2, 9))
def test_cutting_blocks_up_changes_nothing_whatever_their_feeds(case, parts):
    curve, feed, _ = case
    assert time(*cut_up(curve, feed, parts)) == pytest.approx(time(curve, feed), rel=1e-7)


def test_nothing_moves_when_levels_are_tried_twice_as_closely(monkeypatch):
    curve = join([
        line((-0.01, 0), (0, 0)), arc((0, 0), (0, 4e-3), 1.0),
    ])  # fmt: skip
    end = block_point(curve, 1, curve.length[1])
    way = (math.cos(1.0), math.sin(1.0))
    curve = join([block_at(curve, 0), block_at(curve, 1), line(end, (end[0] + 0.02 * way[0], end[1] + 0.02 * way[1]))])
    feed = np.array([0.15, 0.12, 0.03])
    coarse = time(curve, feed)
    for name, kernel in list(vars(levels).items()):
        if hasattr(kernel, "py_func"):
            monkeypatch.setattr(levels, name, kernel.py_func)
    monkeypatch.setattr(levels, "_TRIES", 2 * levels._TRIES)
    assert time(curve, feed) == pytest.approx(coarse, rel=1e-6)


def test_what_stops_cost_is_told_by_running_through():
    """Corners are run through, but where the path turns back every motion stops."""
    curve = join([line((0, 0), (0.01, 0)), line((0.01, 0), (0.01, 0.01)), line((0.01, 0.01), (0.01, 0.0))])
    feed = np.full(3, 0.04)
    assert plan(curve, feed, PATH).stops == 2
    through = plan(curve, feed, PATH, stop_at_corners=False)
    assert through.stops == 1
    expected = ruckig_time(20e-3, 0, 0, 0.04) + ruckig_time(10e-3, 0, 0, 0.04)
    assert through.profile.duration == pytest.approx(expected, abs=1e-9)


def test_a_speed_that_nothing_bounds_is_an_error():
    with pytest.raises(ValueError, match="nothing bounds"):
        plan(straight([1.0]), np.array([math.inf]), Limits(math.inf, 2.0, 50.0))
