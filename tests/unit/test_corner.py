"""Immersion in corners against counted rim points and against limits that are known in closed form."""

import math

import numpy as np
import pytest

from cutwise.maths.linearc import join, sample
from cutwise.paths.pocket import blend_radius, blended, corner
from cutwise.physics.engagement.corner import (
    Corner,
    arc_immersion,
    corner_immersion,
    greatest_immersion,
    straight_immersion,
)
from cutwise.physics.engagement.wall import path_immersion
from peers.corner import counted_immersion

R, AE = 0.01, 0.004
RIGHT = 0.5 * math.pi


@pytest.mark.parametrize("turn", [RIGHT, math.radians(60), math.radians(120)])
@pytest.mark.parametrize("fillet", [0.0, 1e-3, 2e-3, 4e-3, 7e-3])
@pytest.mark.parametrize("depth", [1e-3, 4e-3, 8e-3])
def test_immersion_against_counted_points(turn, fillet, depth):
    shape = Corner(R, depth, turn, fillet)
    cut = fillet * math.tan(0.5 * turn)
    poses = [(s, 0.0, 0.0) for s in np.linspace(-0.03, -cut, 40)[:-1]]
    poses += [
        (-cut + fillet * math.sin(a), fillet * (1 - math.cos(a)), a) for a in np.linspace(0.0, turn, 20)[1:-1] if fillet
    ]
    for pose in poses:
        counted = math.degrees(counted_immersion(*pose, shape))
        assert math.degrees(corner_immersion(*pose, shape)) == pytest.approx(counted, abs=0.03)


def test_sharp_corner_in_closed_form():
    shape = Corner(R, AE, RIGHT, 0.0)
    straight = math.acos(1 - AE / R)
    reach = AE + R * math.sin(straight)
    middle = math.sqrt(R**2 - AE**2) - (R - AE)
    assert corner_immersion(-reach * 1.01, 0.0, 0.0, shape) == pytest.approx(straight, abs=1e-12)
    for s in np.linspace(middle * 1.01, reach * 0.999, 7):
        distance = math.hypot(s - AE, AE)
        expected = RIGHT + math.atan2(AE, s - AE) - math.acos(distance / (2 * R))
        assert corner_immersion(-s, 0.0, 0.0, shape) == pytest.approx(expected, abs=1e-12)
    for s in np.linspace(0.0, middle * 0.99, 5):
        assert corner_immersion(-s, 0.0, 0.0, shape) == pytest.approx(RIGHT + math.acos((R - AE + s) / R), abs=1e-12)
    assert greatest_immersion(shape) == pytest.approx(straight + RIGHT, abs=1e-9)
    assert corner_immersion(0.0, 0.0, RIGHT, shape) == pytest.approx(straight, abs=1e-12)  # after the turn


def test_long_fillet_is_a_steady_arc():
    shape = Corner(R, AE, math.radians(150), 20e-3)
    start = -shape.fillet * math.tan(0.5 * shape.turn)
    angle = math.radians(60)
    pose = (start + shape.fillet * math.sin(angle), shape.fillet * (1 - math.cos(angle)), angle)
    assert corner_immersion(*pose, shape) == pytest.approx(arc_immersion(AE, shape.fillet, R), abs=1e-12)


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
    point, direction, block = sample(curve, curve.knots, middle)
    alpha = path_immersion(curve, np.ones(curve.count, bool), block, point, direction, R, AE)
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
    assert blend_radius(1.0, RIGHT) == pytest.approx(2.414, abs=1e-3)
    blocks = corner(0.03, RIGHT, 0.0)
    path, origin = blended(blocks, [0.1e-3])
    assert origin == [0, 0, 1]
    assert path[1].radius == pytest.approx(0.2414e-3, rel=1e-3)
    middle = np.array(path[1].start) + path[1].radius * np.array(path[1].inward)
    assert math.hypot(middle[0], middle[1]) - path[1].radius == pytest.approx(0.1e-3, rel=1e-9)
    assert blended(blocks, [0.0])[0] == blocks
    short = blended(corner(1e-4, RIGHT, 0.0), [1e-3])[0]
    assert sum(block.length for block in short) == pytest.approx(2 * 0.5e-4 + RIGHT * 0.5e-4)
