"""Rational B-splines: known curves, and lines that stay near them."""

import itertools
import math

import numpy as np
import pytest
from scipy.interpolate import BSpline

from cutwise.maths.splines import clamped_knots, pieces, point


def test_a_quarter_circle():
    points, weights = [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0)], [1.0, math.sqrt(0.5), 1.0]
    knots = clamped_knots(3, 3)
    for t in np.linspace(0, 1, 21):
        assert math.hypot(*point(points, weights, 3, knots, float(t))) == pytest.approx(1.0, abs=1e-14)
    (arc,) = pieces(points, weights, 3, 1e-6)
    assert arc.centre == pytest.approx((0.0, 0.0), abs=1e-12)
    assert arc.sweep == pytest.approx(math.pi / 2)


def test_against_scipy():
    points = [(0.0, 0.0), (1.0, 2.0), (3.0, -1.0), (4.0, 4.0), (6.0, 0.0), (7.0, 1.0)]
    knots = clamped_knots(6, 4)
    peer = BSpline(np.array(knots), np.array(points), 3)
    for t in np.linspace(knots[0], knots[-1], 40):
        assert point(points, [1.0] * 6, 4, knots, float(t)) == pytest.approx(tuple(peer(t)), abs=1e-12)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
def test_lines_stay_within_the_tolerance_and_are_not_wasted(tolerance):
    points, weights = [(0.0, 0.0), (1.0, 3.0), (2.0, -3.0), (3.0, 0.0), (5.0, 2.0)], [1.0, 2.0, 0.5, 1.0, 1.0]
    ends = [(0.0, 0.0), *(piece.end for piece in pieces(points, weights, 4, tolerance))]
    knots = clamped_knots(5, 4)
    curve = [point(points, weights, 4, knots, float(t)) for t in np.linspace(0, knots[-1], 800)]
    worst = max(min(_off(p, a, b) for a, b in itertools.pairwise(ends)) for p in curve)
    assert worst <= 1.5 * tolerance
    assert len(ends) < 8.0 / math.sqrt(tolerance)
    assert ends[-1] == pytest.approx((5.0, 2.0))


def _off(p, a, b):
    dx, dy = b[0] - a[0], b[1] - a[1]
    t = max(0.0, min(1.0, ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / (dx * dx + dy * dy)))
    return math.hypot(p[0] - a[0] - t * dx, p[1] - a[1] - t * dy)
