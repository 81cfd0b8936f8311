"""Deviation of a machined surface, with its sign, at floors, walls, feet and rims."""

import numpy as np
import pytest

from cutwise.maths import profiles
from cutwise.maths.workpiece import alone
from cutwise.physics.surface.map_deviation import REACH, deviations, fitted, shaped_by
from peers.maps import MM, block, lines, separate, swept, tool


def off(solid, points, normals, tolerance=10e-6):
    points = MM * np.array(points, float)
    out, segment = np.empty(len(points)), np.empty(len(points), np.int64)
    deviations(shaped_by(alone(solid)), points, np.array(normals, float), tolerance, out, segment)
    return 1e3 * out, segment


@pytest.fixture(scope="module")
def slot():
    """A slot 4 mm wide and 1 mm deep along x."""
    return swept(
        block((-10, 10), (-10, 10), (-5, 0), 0.3), lines((-20, 0, -1), (20, 0, -1)), tool(profiles.flat(2 * MM))
    )[0]


UP, LEFT = (0, 0, 1), (0, -1, 0)  # LEFT: out of the wall at y = 2, into the slot


def test_floor(slot):
    value, made = off(slot, [(0, 0, -1), (0, 0, -1.02), (0, 1, -0.97), (0, 5, 0)], [UP] * 4)
    assert value == pytest.approx([0.0, 0.02, -0.03, 0.0], abs=2e-8)
    assert made.tolist() == [0, 0, 0, -1]


def test_wall_foot_and_rim(slot):
    """A nominal wall at y = 1.98 has 0.02 cut into it where it should stand; at 2.02 that much is left."""
    points = [(0, 2.0, -0.5), (0, 1.98, -0.5), (0, 2.02, -0.5), (0, 2.02, -0.995), (0, 1.98, -1.03)]
    value, made = off(slot, points, [LEFT] * 5)
    assert value[:3] == pytest.approx([0.0, -0.02, 0.02], abs=1e-7)
    assert value[3] == pytest.approx(0.02, abs=1e-7)
    assert value[4] == pytest.approx(0.03, abs=1e-7)  # below the floor: the gap along the axis
    assert (made == 0).all()
    rim, _ = off(slot, [(0, 1.99, 0.0), (0, -1.99, 0.0)], [UP] * 2)
    assert rim == pytest.approx([-0.01, -0.01], abs=1e-3)  # sideways to the wall, not a millimetre down to the floor


def test_far_away_is_cut_off_and_behind_is_not_judged(slot):
    value, _ = off(slot, [(0, 5, -3), (0, 0, -3)], [UP, (0, 0, -1)])
    assert value[0] == pytest.approx(1e3 * REACH)
    assert np.isnan(value[1])


def test_a_part_that_is_the_machined_surface_deviates_by_nothing():
    """Ball passes leave cylinders whose points and normals are known."""
    ends = [((-20, 0.4 * k, -1), (20, 0.4 * k, -1)) for k in range(6)]
    solid, _ = swept(block((-5, 5), (0, 2), (-4, 0), 0.15), separate(*ends), tool(profiles.ball(3 * MM)))
    angle = np.linspace(-0.0666, 0.0666, 41)
    points = np.column_stack([np.linspace(-4, 4, 41), 0.8 + 3 * np.sin(angle), 2 - 3 * np.cos(angle)])
    normals = np.column_stack([np.zeros(41), -np.sin(angle), np.cos(angle)])
    value, made = off(solid, points, normals)
    assert np.abs(value).max() < 1e-8
    assert set(made.tolist()) == {2}


def test_on_a_slope_the_distance_is_along_the_normal():
    lean = np.tan(np.radians(20))
    path = lines((-20, 0, -1 + 20 * lean), (20, 0, -1 - 20 * lean))
    solid, _ = swept(block((-8, 8), (-1, 1), (-9, 6), 0.2), path, tool(profiles.ball(3 * MM)))
    normal = (np.sin(np.radians(20)), 0.0, np.cos(np.radians(20)))
    centre = np.array([0.0, 0.0, 2.0])
    on = centre - 3 * np.array(normal)
    value, _ = off(solid, [on, on - 0.01 * np.array(normal), on + 0.01 * np.array(normal)], [normal] * 3)
    assert value == pytest.approx([0.0, 0.01, -0.01], abs=1e-8)


def test_the_fit_finds_a_shift_and_a_turn():
    draw = np.random.default_rng(2)
    normal = draw.normal(size=(500, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    point = draw.uniform(-0.02, 0.02, (500, 3))
    shift, turn = np.array([5e-5, -8e-5, 3e-5]), np.array([0.0, 1e-4, -2e-4])
    centre = point.mean(axis=0)
    value = normal @ shift + np.cross(point - centre, normal) @ turn
    fit = fitted(point, normal, value, np.ones(500))
    assert fit.shift == pytest.approx(shift, abs=1e-12)
    assert fit.turn == pytest.approx(turn, abs=1e-9)
    assert fit.after < 1e-12 < fit.before
