"""Contour errors: how far a point is off a path, however short its blocks are."""

import itertools
import math

import numpy as np
import pytest

from cutwise.maths.linearc import arc, block_point, join, line
from cutwise.paths.blends import blended
from cutwise.paths.pocket import corner
from cutwise.physics.motion.contour import contour_errors


def chopped(length, count):
    """A line along +x in many blocks."""
    at = np.linspace(0.0, length, count + 1)
    return join([line((a, 0.0), (b, 0.0)) for a, b in itertools.pairwise(at)])


@pytest.mark.parametrize("count", [1, 30, 3000])
@pytest.mark.parametrize("lag", [0.0, 40e-6, 2e-3])
def test_a_lag_over_many_blocks_is_no_error(count, lag):
    curve = chopped(30e-3, count)
    block = np.full(1, round(0.7 * (count - 1)))
    x = block / count * 30e-3 - lag
    assert contour_errors(curve, block, np.column_stack([x, np.zeros(1)]), True) == pytest.approx([0.0], abs=1e-15)
    beside = contour_errors(curve, block, np.column_stack([x, np.full(1, -3e-6)]), True)
    assert beside == pytest.approx([3e-6], rel=1e-9)


def test_another_pass_beside_is_not_taken():
    """The tool is nearer to the next pass, 0.2 mm beside and 25 mm further on, than to its own."""
    curve = join([line((0.0, 0.0), (25e-3, 0.0)), line((25e-3, 0.0), (25e-3, 2e-4)), line((25e-3, 2e-4), (0.0, 2e-4)),
                  line((0.0, 2e-4), (0.0, 5e-3)), line((0.0, 5e-3), (9e-3, 5e-3))])  # fmt: skip
    off = contour_errors(curve, np.array([0]), np.array([[1e-3, 1.5e-4]]), True)
    assert off == pytest.approx([-1.5e-4])


def test_distance_to_a_clothoid_is_that_of_its_nearest_point():
    curve = blended(join(corner(30e-3, math.pi / 2, 0.0)), np.array([2e-3]), "clothoid").curve
    clothoids = np.flatnonzero(curve.sharpness)
    random = np.random.default_rng(3)
    for i in clothoids:
        along = np.linspace(0.0, curve.length[i], 20001)
        points = np.array([block_point(curve, i, s) for s in along])[:, :2]
        for _ in range(20):
            p = points[random.integers(4000, 16000)] + random.normal(0.0, 1e-4, 2)
            nearest = np.hypot(*(points - p).T).min()
            assert abs(contour_errors(curve, np.array([i]), p[None], False)[0]) == pytest.approx(nearest, abs=1.5e-7)


def test_an_arc_in_chords_is_as_far_as_the_arc():
    """Chords of 0.02 mm about a radius of 20 mm stand in by no more than 2.5 nm."""
    n = 3142
    turn = np.linspace(0.0, math.pi, n + 1)
    corners = 20e-3 * np.column_stack([np.cos(turn), np.sin(turn)])
    chords = join([line(tuple(a), tuple(b)) for a, b in itertools.pairwise(corners)])
    whole = join([arc((20e-3, 0.0), (0.0, 0.0), math.pi)])
    lagging = 20.01e-3 * np.array([[math.cos(1.0), math.sin(1.0)]])
    block = np.searchsorted(turn, [1.0 + 90e-6 / 20e-3]) - 1
    told = contour_errors(chords, block, lagging, True)
    assert told == pytest.approx(contour_errors(whole, np.array([0]), lagging, True), abs=3e-9)
    assert told == pytest.approx([10e-6], abs=3e-9)


@pytest.mark.parametrize("axis", [(0.3, -0.95, 0.1), (1.0, 0.0, 0.0), (0.5, 0.5, 0.7)])
@pytest.mark.parametrize("sweep", [1.1, 2.9])
def test_arcs_that_leave_the_plane_are_seen_from_above(axis, sweep):
    """0.1.0 took the next block that lies in the plane: 10 mm beside the middle of a half circle over the path."""
    axis = np.array(axis) / np.linalg.norm(axis)
    out = np.cross(axis, (0.2, 0.1, 1.0))
    path = join([arc((0.0, 0.0, 0.0), tuple(10e-3 * out / np.linalg.norm(out)), sweep, tuple(axis))])
    s = np.linspace(0.0, path.length[0], 20001)
    chords = np.array([block_point(path, 0, one) for one in s])[:, :2]
    points = chords[::1999] + np.random.default_rng(3).normal(0.0, 2e-4, (11, 2))
    found = np.abs(contour_errors(path, np.zeros(len(points), np.int64), points, False))
    wanted = [np.linalg.norm(chords - point, axis=1).min() for point in points]
    assert found == pytest.approx(wanted, abs=2e-8)
