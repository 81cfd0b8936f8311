"""Rational B-spline surfaces against SciPy's basis functions, and their feet and sections against what they must be."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from cutwise.maths.nurbs import (
    CHEBYSHEV,
    SplineSurface,
    nearest_parameters,
    section_heights,
    spline_normals,
    spline_point,
    splines,
    workspace,
)

RANDOM = np.random.default_rng(3)
U_KNOTS = np.array([0, 0, 0, 0, 0.2, 0.5, 0.5, 1, 1, 1, 1], float)
V_KNOTS = np.array([0, 0, 0, 0.3, 0.6, 0.6, 1, 1, 1], float)
POLES = RANDOM.normal(size=(7, 6, 3))
WEIGHTS = RANDOM.uniform(0.5, 2.0, size=(7, 6))
TABLE = splines([SplineSurface(U_KNOTS, V_KNOTS, POLES, WEIGHTS, 3, 2)] * 2)  # the second row has its own numbers


def expected(u, v):
    basis = [
        np.array([BSpline(knots, row, degree)(t) for row in np.eye(count)])
        for knots, count, degree, t in ((U_KNOTS, 7, 3, u), (V_KNOTS, 6, 2, v))
    ]
    share = np.outer(*basis) * WEIGHTS
    return np.einsum("ij,ijk->k", share, POLES) / share.sum()


@pytest.mark.parametrize(("u", "v"), [(0.1, 0.2), (0.5, 0.6), (0.83, 0.31), (0.0, 1.0)])
def test_point_and_slopes(u, v):
    found = np.array(spline_point(TABLE, 1, u, v, workspace(TABLE)))
    np.testing.assert_allclose(found[:3], expected(u, v), atol=1e-13)
    h = 1e-6
    inside = 0.01 < u < 0.99 and abs(u - 0.5) > 0.01
    if inside:
        np.testing.assert_allclose(found[3:6], (expected(u + h, v) - expected(u - h, v)) / (2 * h), atol=1e-6)
        np.testing.assert_allclose(found[6:9], (expected(u, v + h) - expected(u, v - h)) / (2 * h), atol=1e-6)


def bowl():
    """z = x^2 / 2 over the unit square of parameters, in m: a parabolic cylinder as one patch of degree 2 by 1."""
    poles = np.array([[[0.0, y, 0.0] for y in (0.0, 1.0)], [[0.5, y, 0.0] for y in (0.0, 1.0)],
                      [[1.0, y, 0.5] for y in (0.0, 1.0)]])  # fmt: skip
    knots = np.array([0, 0, 0, 1, 1, 1], float)
    return splines([SplineSurface(knots, np.array([0, 0, 1, 1], float), poles, np.ones((3, 2)), 2, 1)])


def test_feet_and_normals():
    table = bowl()
    foot = np.array([0.4, 0.7, 0.08])
    normal = np.array([-0.4, 0.0, 1.0]) / np.hypot(0.4, 1.0)
    point = (foot + 1e-5 * normal)[None]
    uv, gap, found = np.array([[0.9, 0.1]]), np.empty(1), np.empty((1, 3))
    spline_normals(table, 0, 1.0, point, uv, gap, found)
    np.testing.assert_allclose(uv[0], [0.4, 0.7], atol=1e-9)
    np.testing.assert_allclose(found[0], normal, atol=1e-9)
    assert gap[0] == pytest.approx(1e-5, rel=1e-6)


def test_a_guess_that_leads_astray_is_mended_from_a_grid():
    u, v = nearest_parameters(TABLE, 0, *expected(0.31, 0.77), 0.95, 0.05, workspace(TABLE))
    np.testing.assert_allclose(
        np.array(spline_point(TABLE, 0, u, v, workspace(TABLE)))[:3], expected(0.31, 0.77), atol=1e-9
    )


def test_section_of_a_parabola_beyond_its_patch():
    """Along x from x = 0.9 over 0.2 m the section is x^2 / 2, also past the end of the patch at x = 1."""
    point = np.array([[0.9, 0.5, 0.405]])
    along = np.array([[1.0, 0.0, 0.9]]) / np.hypot(1.0, 0.9)
    normal = np.array([[-0.9, 0.0, 1.0]]) / np.hypot(1.0, 0.9)
    start = np.array([[0.9, 0.5]])
    height = section_heights(bowl(), 0, start, point, along, normal, 0.2, CHEBYSHEV)[0]
    at = point + 0.2 * CHEBYSHEV[:, None] * along + height[:, None] * normal
    np.testing.assert_allclose(at[:, 2], 0.5 * at[:, 0] ** 2, atol=1e-12)
    assert at[-1, 0] > 1.0
