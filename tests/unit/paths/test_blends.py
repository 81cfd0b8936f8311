"""Corners rounded by arcs and by clothoids: tolerance, smoothness, and the jerk that the machine then sees."""

import math

import numpy as np
import pytest
from scipy.special import fresnel

from cutwise.maths.linearc import (
    arc,
    block_bend,
    block_point,
    block_tangent,
    clothoid_point,
    curvature_jumps,
    join,
    line,
    sample,
)
from cutwise.paths.blends import blended
from cutwise.physics.engagement.corner import Corner, greatest_immersion, summed
from cutwise.physics.engagement.wall import path_contact
from cutwise.physics.motion.lookahead import plan
from cutwise.physics.motion.profile import Limits
from cutwise.physics.motion.reference import sampled

LIMITS = Limits(0.2, 2.0, 50.0)


def path(turn, length=0.03):
    d = (math.cos(turn), math.sin(turn), 0.0)
    return [line((-length, 0, 0), (0, 0, 0)), line((0, 0, 0), tuple(length * c for c in d))]


def rounded(turn, tolerance, shape, length=0.03):
    found = blended(join(path(turn, length)), np.array([tolerance]), shape)
    return found.curve, found.origin


def test_clothoid_is_the_fresnel_integral():
    """With kappa' = pi the integrals are those of Fresnel; curvature at the start by turning the frame."""
    s, c = fresnel(1.3)
    assert clothoid_point(0.0, math.pi, 1.3) == pytest.approx((c, s), abs=1e-14)
    whole = np.array(clothoid_point(0.0, 2.0, 1.0))
    first, second = np.array(clothoid_point(0.0, 2.0, 0.4)), np.array(clothoid_point(0.8, 2.0, 0.6))
    turn = 0.5 * 2.0 * 0.4**2
    rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    assert first + rotation @ second == pytest.approx(whole, abs=1e-15)


@pytest.mark.parametrize("shape", ["arc", "clothoid"])
@pytest.mark.parametrize("turn", [0.02, 0.6, math.pi / 2, 2.8])
def test_rounding_keeps_its_tolerance_and_joins(shape, turn):
    tolerance = 20e-6
    curve, origin = rounded(turn, tolerance, shape)
    assert curve.count == (3 if shape == "arc" else 4)
    assert origin[0] == 0
    assert origin[-1] == 1
    for i in range(curve.count - 1):
        end, start = block_point(curve, i, curve.length[i]), block_point(curve, i + 1, 0.0)
        assert end == pytest.approx(start, abs=1e-14)
        assert block_tangent(curve, i, curve.length[i]) == pytest.approx(block_tangent(curve, i + 1, 0.0), abs=1e-9)
    s = np.linspace(0.0, curve.knots[-1], 200_001)
    points = sample(curve, curve.knots, s)[0]
    assert np.hypot(points[:, 0], points[:, 1]).min() == pytest.approx(tolerance, rel=1e-4)


def test_only_clothoids_keep_the_curvature_even():
    for turn in (0.3, math.pi / 2):
        assert curvature_jumps(rounded(turn, 20e-6, "arc")[0]).max() > 1e2
        smooth = rounded(turn, 20e-6, "clothoid")[0]
        assert curvature_jumps(smooth).max() < 1e-9 * smooth.curvature.max()


def test_equal_arcs_in_a_row_have_no_jump():
    """The curvature vector turns along an arc: at the joint of two quarters of one circle it is the same."""
    quarters = join([arc((5e-3, 0), (0, 0), math.pi / 2), arc((0, 5e-3), (0, 0), math.pi / 2)])
    assert curvature_jumps(quarters)[0] < 1e-9
    back = join([arc((5e-3, 0), (0, 0), math.pi / 2), arc((0, 5e-3), (0, 10e-3), -math.pi / 2)])
    assert curvature_jumps(back)[0] == pytest.approx(400.0)


def test_bend_is_the_change_of_the_tangent():
    curve = rounded(1.2, 1e-3, "clothoid")[0]
    for i in (1, 2):
        at, h = 0.37 * curve.length[i], 1e-7
        ahead, behind = (np.array(block_tangent(curve, i, at + d)) for d in (h, -h))
        assert (ahead - behind) / (2 * h) == pytest.approx(np.array(block_bend(curve, i, at)), rel=1e-6, abs=1e-5)


def greatest_jerk(shape, turn, tolerance, feed):
    """Length of the third difference of the set points [m/s^3], from samples every 0.1 ms."""
    curve = rounded(turn, tolerance, shape)[0]
    motion = plan(curve, np.full(curve.count, feed), LIMITS)
    step = 1e-4
    points = sampled(curve, [motion.profile], step, 0.0).point
    return np.linalg.norm(np.diff(points, 3, axis=0), axis=1).max() / step**3, motion


@pytest.mark.parametrize("turn", [0.3, math.pi / 2, 2.4])
@pytest.mark.parametrize("feed", [0.02, 0.15])
def test_jerk_limit_holds_everywhere_with_clothoids(turn, feed):
    """Arcs exceed it wherever the normal acceleration jumps; a pair of clothoids nowhere."""
    jerk, motion = greatest_jerk("clothoid", turn, 0.2e-3, feed)
    assert jerk <= LIMITS.jerk * 1.001
    assert motion.curvature_steps.max() < 1e-9
    assert motion.stops == 0
    over, by_arc = greatest_jerk("arc", turn, 0.2e-3, feed)
    assert over > 1.5 * LIMITS.jerk
    assert by_arc.curvature_steps.max() > 0.01


def test_speed_stays_within_a_blend():
    curve = rounded(math.pi / 2, 50e-6, "clothoid", length=2e-3)[0]
    motion = plan(curve, np.full(4, 0.15), LIMITS)
    assert motion.joint_speed[1] > 1e-3
    assert motion.joint_speed[1:4] == pytest.approx(np.full(3, motion.joint_speed[1]), rel=1e-12)
    assert motion.profile.acceleration.max() <= LIMITS.acceleration * (1 + 1e-12)


def immersion_along(curve, count=4001):
    s = np.linspace(1e-6, curve.knots[-1] - 1e-6, count)
    _, _, block = sample(curve, curve.knots, s)
    return summed(path_contact(curve, np.ones(curve.count, bool), block, s, 10e-3, 4e-3))


@pytest.mark.parametrize(("shape", "accuracy"), [("arc", 1e-4), ("clothoid", 1e-2)])
def test_rounded_corner_is_still_a_corner_for_the_cut(shape, accuracy):
    """The fillet that passes the corner at the same distance loads the mill as much."""
    curve = rounded(math.pi / 2, 0.1e-3, shape)[0]
    fillet = 0.1e-3 * math.cos(math.pi / 4) / (1 - math.cos(math.pi / 4))
    expected = greatest_immersion(Corner(10e-3, 4e-3, math.pi / 2, fillet))
    assert immersion_along(curve, 200_001).max() == pytest.approx(expected, rel=accuracy)


def test_a_fillet_split_in_two_is_one_corner():
    whole = [line((-0.03, 0), (-2e-3, 0)), arc((-2e-3, 0), (-2e-3, 2e-3), math.pi / 2), line((0, 2e-3), (0, 0.03))]
    at = (-2e-3 + 2e-3 * math.sin(math.pi / 4), 2e-3 - 2e-3 * math.cos(math.pi / 4))
    split = [whole[0], arc((-2e-3, 0), (-2e-3, 2e-3), math.pi / 4), arc(at, (-2e-3, 2e-3), math.pi / 4), whole[2]]
    one, other = (immersion_along(join(blocks)) for blocks in (whole, split))
    np.testing.assert_allclose(other, one, atol=1e-6)
