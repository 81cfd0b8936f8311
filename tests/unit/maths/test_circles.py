"""Circles about any axis: ends, tolerance, helices, full turns."""

import itertools
import math

import pytest

from cutwise.maths.circles import Circle, chords, distance_from_axis

UP = Circle((1.0, 2.0, 3.0), (0.0, 0.0, 1.0), 2.0)
TILTED = Circle((0.0, 0.0, 0.0), (math.sqrt(0.5), 0.0, math.sqrt(0.5)), 1.0)


def test_distance_from_axis():
    assert distance_from_axis(UP, (3.0, 2.0, -7.0)) == pytest.approx(2.0)
    assert distance_from_axis(TILTED, (5.0, 0.0, 5.0)) == pytest.approx(0.0, abs=1e-12)


def test_every_chord_ends_on_the_circle_and_stays_within_the_tolerance():
    start, end = (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)
    points = [start, *chords(TILTED, start, end, 1e-3)]
    assert points[-1] == end
    assert all(math.hypot(*p) == pytest.approx(1.0) for p in points)
    middles = [tuple(0.5 * (a + b) for a, b in zip(p, q, strict=True)) for p, q in itertools.pairwise(points)]
    assert max(1.0 - math.hypot(*m) for m in middles) <= 1e-3
    assert all(p[0] <= 1e-12 for p in points)  # counter-clockwise about the axis: through -x first


def test_a_helix_rises_evenly_and_a_start_that_is_the_end_is_a_full_turn():
    start = (3.0, 2.0, 3.0)
    points = list(chords(UP, start, (3.0, 2.0, 4.0), 0.1))
    rises = [b[2] - a[2] for a, b in zip([start, *points], points, strict=False)]
    assert rises == pytest.approx([1.0 / len(points)] * len(points))
    assert len(points) > 4


def test_a_tolerance_of_nothing_still_ends():
    assert len(list(chords(UP, (3.0, 2.0, 3.0), (1.0, 4.0, 3.0), 0.0))) == math.ceil(0.5 * math.pi / 1e-3)
