"""Immersion in corners against counted rim points and against limits that are known in closed form."""

import math

import numpy as np
import pytest

from cutwise.maths.linearc import arc, block_at, join, line, sample
from cutwise.paths.blends import blended
from cutwise.paths.pocket import corner
from cutwise.physics.engagement.corner import (
    Corner,
    arc_immersion,
    greatest_immersion,
    straight_immersion,
    summed,
)
from cutwise.physics.engagement.wall import greatest_contact, path_contact
from peers.corner import corner_immersion, counted_immersion

R, AE = 0.01, 0.004
RIGHT = 0.5 * math.pi


LEAD = 1.0


def immersions(shape, s):
    """Immersion angle, centre and heading at distances [m] from the corner point or from the start of its fillet."""
    curve = join(corner(LEAD, shape.turn, shape.fillet))
    point, direction, block = sample(curve, curve.knots, curve.length[0] + np.asarray(s))
    arcs = path_contact(
        curve, np.ones(curve.count, bool), block, curve.length[0] + np.asarray(s), shape.mill_radius, shape.radial_depth
    )
    return summed(arcs), point, np.arctan2(direction[:, 1], direction[:, 0])


@pytest.mark.parametrize("turn", [RIGHT, math.radians(60), math.radians(120), math.radians(160)])
@pytest.mark.parametrize("fillet", [0.0, 1e-3, 4e-3, 7e-3])
@pytest.mark.parametrize("depth", [1e-3, 8e-3, 14e-3])
def test_immersion_against_counted_points(turn, fillet, depth):
    shape = Corner(R, depth, turn, fillet)
    s = np.concatenate([np.linspace(-0.03, 0.0, 40)[:-1], np.linspace(0.0, turn * fillet, 20)[1:-1]])
    found, point, heading = immersions(shape, s if fillet else s[:39])
    counted = [counted_immersion(*p[:2], h, shape) for p, h in zip(point, heading, strict=True)]
    np.testing.assert_allclose(np.degrees(found), np.degrees(counted), atol=0.03)


@pytest.mark.parametrize("turn", [RIGHT, math.radians(50), math.radians(130)])
@pytest.mark.parametrize("fillet", [0.0, 0.3e-3, 2e-3, 12e-3])
def test_greatest_contact_of_a_path_is_the_closed_form(turn, fillet):
    curve = join(corner(30e-3, turn, fillet))
    expected = greatest_immersion(Corner(R, AE, turn, fillet))
    assert greatest_contact(curve, R, AE) == pytest.approx(expected, abs=1e-11)


def test_sharp_corner_in_closed_form():
    shape = Corner(R, AE, RIGHT, 0.0)
    straight = math.acos(1 - AE / R)
    reach = AE + R * math.sin(straight)
    middle = math.sqrt(R**2 - AE**2) - (R - AE)
    s = np.linspace(middle * 1.01, reach * 0.999, 7)
    expected = RIGHT + np.arctan2(AE, s - AE) - np.arccos(np.hypot(s - AE, AE) / (2 * R))
    np.testing.assert_allclose(immersions(shape, -s)[0], expected, atol=1e-11)
    s = np.linspace(1e-6, middle * 0.99, 5)
    np.testing.assert_allclose(immersions(shape, -s)[0], RIGHT + np.arccos((R - AE + s) / R), atol=1e-11)
    for away in (-reach * 1.01, 1e-6):  # before it, and after the turn
        assert immersions(shape, [away])[0] == pytest.approx(straight, abs=1e-11)
    assert greatest_immersion(shape) == pytest.approx(straight + RIGHT, abs=1e-9)


@pytest.mark.parametrize("turn", [0.4, 1.0, RIGHT])
@pytest.mark.parametrize("fillet", [0.0, 2e-3, 8e-3])
def test_contact_is_the_closed_form_of_obtuse_corners(turn, fillet):
    shape = Corner(R, AE, turn, fillet)
    found, point, heading = immersions(shape, np.linspace(-0.04, 0.04, 301))
    closed = [corner_immersion(*p[:2], h, shape) for p, h in zip(point, heading, strict=True)]
    np.testing.assert_allclose(found, closed, atol=1e-11)


def test_long_fillet_is_a_steady_arc():
    shape = Corner(R, AE, math.radians(150), 20e-3)
    found = immersions(shape, [shape.fillet * math.radians(60)])[0]
    assert found == pytest.approx(arc_immersion(AE, shape.fillet, R), abs=1e-11)


def test_lines_in_many_blocks_are_one_line():
    """A program may cut a wall into short blocks: the corner stays where it is."""
    whole = [line((-0.05, 0), (0, 0)), line((0, 0), (0, 0.05))]
    parts = [*(line((x / 1e3, 0), ((x + 5) / 1e3, 0)) for x in range(-50, 0, 5)),
             *(line((0, y / 1e3), (0, (y + 2) / 1e3)) for y in range(0, 50, 2))]  # fmt: skip
    s = np.linspace(1e-5, 0.1 - 1e-5, 501)
    one, many = (contact_along(blocks, s) for blocks in (whole, parts))
    np.testing.assert_allclose(many, one, atol=1e-9)
    assert one.max() > math.radians(140)


def contact_along(blocks, s):
    curve = join(blocks)
    _, _, block = sample(curve, curve.knots, s)
    return summed(path_contact(curve, np.ones(curve.count, bool), block, s, R, AE))


def test_a_loop_to_the_right_is_no_corner():
    """Three quarters of a turn to the right end in a line that goes left: the wall is outside, and no corner is cut."""
    blocks = [
        line((-0.05, 0), (0, 0)),
        arc((0, 0), (0, -0.012), -1.5 * math.pi),
        line((-0.012, -0.012), (-0.012, 0.03)),
    ]
    s = np.linspace(1e-5, join(blocks).knots[-1] - 1e-5, 400)
    found = contact_along(blocks, s)
    on_arc = (s > 0.05) & (s < 0.05 + 0.012 * 1.5 * math.pi)
    np.testing.assert_allclose(found[on_arc], arc_immersion(AE, -0.012, R), atol=1e-12)
    np.testing.assert_allclose(found[~on_arc], straight_immersion(AE, R), atol=1e-12)


def test_an_arc_that_does_not_touch_its_lines_is_no_fillet():
    blocks = [
        line((-0.05, 0), (0, 0)),
        arc((0, 0), (-0.003, 0.004), RIGHT),
        line((-0.004 - 0.003, 0.004 + 0.003), (-0.007, 0.05)),
    ]
    assert contact_along([blocks[0], blocks[1]], np.array([0.049])) == pytest.approx(straight_immersion(AE, R))


def test_arcs_of_large_radius_are_straight():
    assert arc_immersion(AE, 1e3, R) == pytest.approx(straight_immersion(AE, R), abs=1e-5)
    assert arc_immersion(AE, math.inf, R) == straight_immersion(AE, R)
    assert arc_immersion(AE, -0.05, R) < straight_immersion(AE, R) < arc_immersion(AE, 0.05, R)
    assert straight_immersion(0.0, R) == 0.0
    assert straight_immersion(3 * R, R) == pytest.approx(math.pi)


@pytest.mark.parametrize("fillet", [0.0, 2e-3, 5e-3])
def test_removed_area_is_the_integral_of_the_immersion(fillet):
    """dA/ds = R (1 - cos alpha): summed over the way it is the area between the two passes' walls."""
    curve = join(corner(0.03, RIGHT, fillet))
    s = np.linspace(0.0, float(curve.knots[-1]), 40001)
    middle = 0.5 * (s[1:] + s[:-1])
    _, _, block = sample(curve, curve.knots, middle)
    alpha = summed(path_contact(curve, np.ones(curve.count, bool), block, middle, R, AE))
    cut = float(np.sum(R * (1.0 - np.cos(alpha)))) * (s[1] - s[0])
    assert cut == pytest.approx(_band(fillet), rel=2e-3)


def _band(fillet):
    """Area that this pass clears beyond the previous one, end effects along both lines included, by counting cells."""
    h = 0.02e-3
    x, y = np.meshgrid(np.arange(-0.045, 0.012, h) + h / 2, np.arange(-0.012, 0.045, h) + h / 2)
    now = _swept(fillet, 0.0, x, y)
    before = _swept(max(fillet - AE, 0.0), AE, x, y, extend=0.05)
    start = np.hypot(x + 0.03, y) <= R  # the mill stands in the stock at the start: not cut by moving
    return float((now & ~before & ~start).sum()) * h * h


def _swept(fillet, offset, x, y, extend=0.0):
    cut = fillet
    px, py = x + offset, y - offset  # previous pass is shifted to the left of both lines
    end = 0.03 + extend
    along = np.clip(px, -end - offset, -cut)
    inside = np.hypot(px - along, py) <= R
    up = np.clip(py, cut, end + offset)
    inside |= np.hypot(px, py - up) <= R
    if fillet > 0:
        angle = np.arctan2(py - fillet, px + fillet)
        on = (angle >= -RIGHT) & (angle <= 0)
        inside |= on & (np.abs(np.hypot(px + fillet, py - fillet) - fillet) <= R)
    return inside


def test_blend_radius_at_a_right_angle():
    blocks = join(corner(0.03, RIGHT, 0.0))
    path, origin, _, _ = blended(blocks, np.array([0.1e-3]))
    assert origin.tolist() == [0, 0, 1]
    rounding = block_at(path, 1)
    assert rounding.radius == pytest.approx(0.2414e-3, rel=1e-3)
    middle = np.array(rounding.start) + rounding.radius * np.array(rounding.inward)
    assert math.hypot(middle[0], middle[1]) - rounding.radius == pytest.approx(0.1e-3, rel=1e-9)
    assert blended(blocks, np.array([0.0])).curve is blocks
    short = blended(join(corner(1e-4, RIGHT, 0.0)), np.array([1e-3])).curve
    assert short.length.sum() == pytest.approx(2 * 0.5e-4 + RIGHT * 0.5e-4)
