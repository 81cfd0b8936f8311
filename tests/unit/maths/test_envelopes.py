"""Closed forms of what a tool leaves along lines, arcs and plunges, held against poses stamped one by one."""

import numpy as np
import pytest

from cutwise.maths import profiles
from cutwise.maths.envelopes import begun_height, heights_left, segments
from cutwise.maths.profiles import cutters, profile_height
from peers.maps import MM, arc, lines, stamped, tool

TOOLS = {
    "flat": profiles.flat(5.0),
    "ball": profiles.ball(5.0),
    "bull_nose": profiles.bull_nose(5.0, 1.5),
    "taper": profiles.taper(5.0, 1.0, 0.3),
    "ball_taper": profiles.ball_taper(5.0, 2.0, 0.2),
    "drill": profiles.taper(5.0, 0.0, 1.03),
}
SMOOTH = {"ball": 5e-3, "bull_nose": 5e-3}  # order 2 in the spacing of the poses; the others touch at corners: order 1


@pytest.mark.parametrize("slope", [0.0, -0.22, 0.49, 3.3])
@pytest.mark.parametrize("name", TOOLS)
def test_no_pose_goes_below_the_closed_form_and_many_come_close(name, slope):
    draw = np.random.default_rng(5)
    x, y = draw.uniform(-5.0, 25.0, 60), draw.uniform(-5.0, 5.0, 60)
    table, end = tool(TOOLS[name]), (20.0, 0.0, 20.0 * slope)
    closed = heights_left(lines((0, 0, 0), tuple(1e3 * v for v in end)), table, x, y)
    poses = stamped(table, (0.0, 0.0, 0.0), end, x, y, 400)
    reached = np.isfinite(poses)
    assert np.isfinite(closed[reached]).all()
    assert (poses[reached] - closed[reached]).min() > -1e-12
    assert (poses[reached] - closed[reached]).mean() < SMOOTH.get(name, 0.1)


def test_worked_example_b_bull_nose_down_a_slope():
    """Heights of the specification, to its nine digits."""
    table = tool(profiles.bull_nose(5 * MM, 1.5 * MM))
    told = {
        (10, 0): -2.729705854, (10, 2): -2.616569868, (10, 4): -2.086316519, (10, 4.9): -1.074865350, (-2, 1): -0.302913058,
        (22, 0): -4.0, (24, 1): -3.864455708, (3, 3): -1.044843759,
    }  # fmt: skip
    at = MM * np.array(list(told), float)
    found = heights_left(lines((0, 0, 0), (20, 0, -4)), table, at[:, 0].copy(), at[:, 1].copy())
    assert 1e3 * found == pytest.approx(list(told.values()), abs=1e-9)


def test_a_level_arc_is_its_nearest_point():
    table = tool(profiles.ball(2.0))
    path = segments([arc((0, 0), 0, 1e4, 0.3, 2.0)], [1])  # of radius 10 m: mm are cancelled by the factor
    draw = np.random.default_rng(3)
    x, y = draw.uniform(-13, 13, 300), draw.uniform(-13, 13, 300)
    angles = np.linspace(0.3, 2.3, 20001)
    away = np.array(
        [np.hypot(a - 10 * np.cos(angles), b - 10 * np.sin(angles)).min() for a, b in zip(x, y, strict=True)]
    )
    found = heights_left(path, table, x, y)
    there = away < 2.0
    assert (np.isfinite(found) == there).mean() > 0.99
    assert found[there] == pytest.approx(2.0 - np.sqrt(4.0 - away[there] ** 2), abs=2e-4)
    half = np.array([begun_height(path, table, 0, 0.5, a, b) for a, b in zip(x, y, strict=True)])
    shorter = heights_left(segments([arc((0, 0), 0, 1e4, 0.3, 1.0)], [1]), table, x, y)
    assert half[np.isfinite(shorter)] == pytest.approx(shorter[np.isfinite(shorter)], abs=1e-12)
    assert (np.isfinite(half) == np.isfinite(shorter)).all()


def test_limits_of_shapes():
    """A bull-nose of full corner is the ball, one of none the flat, a taper of no angle the flat."""
    draw = np.random.default_rng(7)
    x, y = draw.uniform(-5, 25, 400), draw.uniform(-5, 5, 400)
    path = lines((0, 0, 0), (2e4, 0, -4e3))

    def left(pieces):
        return heights_left(path, tool(pieces), x, y)

    assert left(profiles.bull_nose(5.0, 5.0)) == pytest.approx(left(profiles.ball(5.0)), abs=1e-12)
    near = left(profiles.bull_nose(5.0, 1e-9))
    inside = np.isfinite(near)
    assert near[inside] == pytest.approx(left(profiles.flat(5.0))[inside], abs=1e-6)
    thin = left(profiles.taper(5.0, 5.0 - 1e-9, 1e-9))
    assert thin[np.isfinite(thin)] == pytest.approx(left(profiles.flat(5.0))[np.isfinite(thin)], abs=1.1)


def test_up_and_down_a_line_leave_the_same_surface():
    draw = np.random.default_rng(9)
    x, y = draw.uniform(-0.005, 0.025, 300), draw.uniform(-0.005, 0.005, 300)
    for pieces in TOOLS.values():
        table = cutters(
            [[(k, MM * a, MM * b, MM * c, MM * s if k == profiles.TUBE else s) for k, a, b, c, s in pieces]]
        )
        down = heights_left(lines((0, 0, 0), (20, 0, -4)), table, x, y)
        up = heights_left(lines((20, 0, -4), (0, 0, 0)), table, x, y)
        assert np.array_equal(np.isfinite(down), np.isfinite(up))
        assert down[np.isfinite(up)] == pytest.approx(up[np.isfinite(up)], abs=1e-12)


def test_steps_of_a_holder_are_the_least_of_its_pieces():
    outline = profiles.revolved([(45.0, 10.0), (70.0, 20.0), (90.0, 15.0), (100.0, 25.0)])
    table = cutters([outline])
    assert profile_height(table, 0, 5.0) == 45.0
    assert profile_height(table, 0, 15.0) == pytest.approx(57.5)
    assert profile_height(table, 0, 20.0) == 70.0
    assert profile_height(table, 0, 22.5) == pytest.approx(97.5)  # hidden behind the waist: the cone above it
    assert profile_height(table, 0, 25.1) == np.inf


def test_meridian_lengths_and_bottom():
    whole = profiles.meridian(profiles.bull_nose(5.0, 1.5), 0.0, 40)
    assert whole.length.sum() == pytest.approx(3.5 + 0.5 * np.pi * 1.5)
    assert whole.length[whole.sine == 0.0].sum() == pytest.approx(3.5)
    cored = profiles.meridian(profiles.flat(5.0), 2.0, 12)
    assert cored.length.sum() == pytest.approx(3.0)
    assert profiles.meridian(profiles.flat(5.0), 5.0, 12).length.size == 0
    cone = profiles.meridian(profiles.taper(5.0, 1.0, 0.3), 1.0, 10)
    assert cone.sine == pytest.approx(np.full(10, np.cos(0.3)))
    assert profiles.cylinder_foot(profiles.taper(5.0, 1.0, 0.3)) == pytest.approx(4.0 / np.tan(0.3))
