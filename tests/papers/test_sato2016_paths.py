"""Chamfer paths of constant width on a drilled pipe: identities and numbers of Sato et al. 2016, worked out."""

import math
from itertools import pairwise

import numpy as np
import pytest
import sympy as sp

from cutwise.maths.edges import lengths
from cutwise.paths.chamfer.ball_path import Chamfer, chamfer_path, stand_off, width_slope
from cutwise.paths.feed import chord_error, contact_feeds, points_for
from cutwise.paths.pipe import NoEdgeError, PipeHole, one_turn, pipe_edge
from cutwise.paths.reach import (
    BallCutter,
    contact_angles,
    knife_margin,
    least_tilt,
    rod_wall_clearance,
)
from cutwise.physics.surface.sweep import swept_chamfer

PIPE = PipeHole(0.015, 0.002, 0.004)
BALL = 0.002
OFF_NODE = 2 * np.pi * (np.arange(73) + 0.37) / 73


def edge_curvature(part, theta, *, inner):
    """Eq. (9) written out, of a central, upright hole [1/m]."""
    rho, r = part.surface_radius(inner=inner), part.hole_radius
    c, s = np.cos(theta), np.sin(theta)
    h = np.sqrt(rho**2 - (r * c) ** 2)
    z1 = r**2 * s * c / h
    z2 = r**2 * np.cos(2.0 * theta) / h - (r**2 * s * c) ** 2 / h**3
    return np.sqrt((r**4 + r**2 * (z1**2 + z2**2)) / (r**2 + z1**2) ** 3)


def neck(tool, clearance):
    """Least angle between the contact and the rod [rad]: of the rod with its clearance, or of the knife."""
    return max(math.asin((tool.rod_radius + clearance) / tool.ball_radius), tool.knife_limit)


def planar_tilt(width, tool, clearance):
    """Tilt of an inner edge on a right angle with straight sections [rad]; derived, the section of the paper is lost."""
    return max(0.0, neck(tool, clearance) + math.asin(0.5 * width / tool.ball_radius) - 0.25 * math.pi)


def widest_chamfer(tool, clearance):
    """Widest symmetric chamfer there [m]."""
    return max(0.0, 2.0 * tool.ball_radius * math.sin(0.25 * math.pi - neck(tool, clearance)))


def path_of(inner, *, width=0.3e-3, tier=2, points=2880, part=PIPE, ball=BALL, tilt=0.0, leg=False):
    nodes = pipe_edge(part, one_turn(512), inner=inner)
    frames = pipe_edge(part, one_turn(points), inner=inner)
    return chamfer_path(frames, Chamfer(width, leg, tilt, tier), ball, nodes=nodes)


def widths(path, *, inner, part=PIPE, ball=BALL, shift=(0, 0, 0)):
    at = pipe_edge(part, OFF_NODE, inner=inner)
    return swept_chamfer(at, path.centre + np.array(shift), ball, 2.2 * path.leg.max(), closed=True).width


def test_eq4_curvature_and_wedge_identities():
    theta, radius, hole = sp.symbols("theta R r", positive=True)
    edge = sp.Matrix([hole * sp.cos(theta), hole * sp.sin(theta), sp.sqrt(radius**2 - hole**2 * sp.cos(theta) ** 2)])
    first, second = edge.diff(theta), edge.diff(theta, 2)
    kappa = sp.sqrt(first.cross(second).dot(first.cross(second))) / sp.sqrt(first.dot(first)) ** 3
    for place in (0.0, 0.4, 1.1, np.pi / 2):
        expected = float(kappa.subs({theta: place, radius: 15, hole: 4}))
        assert edge_curvature(PIPE, np.array([place]), inner=False)[0] == pytest.approx(1e3 * expected, rel=1e-12)
    n_pipe = sp.Matrix([edge[0], 0, edge[2]]) / radius
    n_hole = -sp.Matrix([sp.cos(theta), sp.sin(theta), 0])
    assert sp.simplify(-n_pipe.dot(n_hole) - hole / radius * sp.cos(theta) ** 2) == 0
    frames = pipe_edge(PIPE, one_turn(360), inner=False)
    np.testing.assert_allclose(np.cos(frames.wedge), 4 / 15 * np.cos(one_turn(360)) ** 2, atol=1e-14)


@pytest.mark.parametrize(
    ("inner", "at_0", "at_90"),
    [
        (True, (2.4755920, 0, 11.2587496), (0, 2.6958355, 11.6958355)),
        (False, (2.9117241, 0, 15.8849748), (0, 2.6958355, 16.3041645)),
    ],
)
def test_base_case_centres_and_measured_width(inner, at_0, at_90):
    path = path_of(inner)
    np.testing.assert_allclose(1e3 * path.centre[0], at_0, atol=1e-6)
    np.testing.assert_allclose(1e3 * path.centre[720], at_90, atol=1e-6)
    found = widths(path, inner=inner)
    assert abs(1e3 * found - 0.3).max() < 2e-5
    assert (path.tier == 2).all()


@pytest.mark.parametrize(
    ("inner", "tier", "low", "high"),
    [
        (False, 0, 0.297594, 0.299999), (False, 1, 0.299999, 0.300327),
        (True, 0, 0.299998, 0.302071), (True, 1, 0.299998, 0.300338),
    ],
)  # fmt: skip
def test_tier_errors(inner, tier, low, high):
    found = 1e3 * widths(path_of(inner, tier=tier), inner=inner)
    assert found.min() == pytest.approx(low, abs=1.5e-6)
    assert found.max() == pytest.approx(high, abs=1.5e-6)


@pytest.mark.parametrize("inner", [True, False])
def test_order_two_in_the_number_of_points(inner):
    error = [abs(widths(path_of(inner, points=n), inner=inner) - 0.3e-3).max() for n in (90, 360, 1440)]
    slopes = [math.log(a / b) / math.log(4) for a, b in pairwise(error)]
    assert slopes == pytest.approx([2.0, 2.0], abs=0.05)
    assert 1e6 * error[0] == pytest.approx(2.62 if inner else 1.87, abs=0.01)


def shortest(inner, tool, clearance, part, tier, points=2880):
    def margin(cut):
        path = path_of(
            inner, width=cut.width, tier=tier, part=part, ball=tool.ball_radius, tilt=cut.tilt, points=points
        )
        return min(rod_wall_clearance(path, part, tool) - clearance, knife_margin(path, tool, part.drill_axis))

    return margin


@pytest.mark.parametrize(
    ("width", "rod", "beta", "clearance", "degrees"),
    [
        (0.5, 1.25, 38.7, 0.0, 0.8808), (0.5, 1.25, 38.7, 0.1, 4.6349), (0.3, 1.25, 45.0, 0.0, 4.3012),
        (0.3, 1.4, 38.7, 0.0, 3.7282), (0.3, 1.4, 38.7, 0.1, 7.8916), (0.3, 1.8, 38.7, 0.0, 23.459),
    ],
)  # fmt: skip
def test_needed_tilt_closed_form_and_numeric(width, rod, beta, clearance, degrees):
    tool = BallCutter(BALL, rod * 1e-3, max(math.asin(rod / 2), math.radians(beta)))
    closed = planar_tilt(width * 1e-3, tool, clearance * 1e-3)
    cut = Chamfer(width * 1e-3, tier=1)
    wedge = pipe_edge(PIPE, one_turn(512), inner=True).wedge.max()
    found = least_tilt(cut, shortest(True, tool, clearance * 1e-3, PIPE, 1, points=512), wedge)
    assert math.degrees(closed) == pytest.approx(degrees, abs=6e-5 if degrees < 10 else 6e-4)
    assert math.degrees(found) == pytest.approx(math.degrees(closed), abs=1e-9)


@pytest.mark.parametrize(("tier", "degrees"), [(1, 0.4406), (2, 0.4498)])
def test_needed_tilt_of_an_eccentric_hole_depends_on_the_tier(tier, degrees):
    part = PIPE._replace(eccentricity=0.004)
    tool = BallCutter(BALL, 0.00125, math.asin(0.625))
    wedge = pipe_edge(part, one_turn(512), inner=True).wedge.max()
    found = least_tilt(Chamfer(0.3e-3, tier=tier), shortest(True, tool, 0.0, part, tier), wedge)
    assert math.degrees(found) == pytest.approx(degrees, abs=1e-4)


def test_limits_and_failure_cases():
    tool = BallCutter(BALL, 0.00125, math.radians(38.7))
    base = path_of(True)
    assert 1e3 * rod_wall_clearance(base, PIPE, tool) == pytest.approx(0.054164, abs=1e-6)
    assert math.degrees(knife_margin(base, tool, PIPE.drill_axis)) == pytest.approx(1.999, abs=5e-4)
    assert 1e3 * widest_chamfer(tool, 0.0) == pytest.approx(0.4389, abs=1e-4)
    assert 1e3 * widest_chamfer(tool._replace(knife_limit=0.0), 0.0) == pytest.approx(0.4402, abs=1e-4)
    assert 1e3 * rod_wall_clearance(path_of(True, width=0.5e-3), PIPE, tool) == pytest.approx(-0.0237, abs=5e-5)
    oblique = PIPE._replace(inclination=math.radians(30))
    path = path_of(True, part=oblique)
    assert 1e3 * rod_wall_clearance(path, oblique, tool) == pytest.approx(-0.383, abs=1e-3)
    assert math.degrees(contact_angles(path, oblique.drill_axis)[:, 1].min()) == pytest.approx(25.7, abs=0.05)
    with pytest.raises(NoEdgeError, match="no closed edge"):
        pipe_edge(PIPE._replace(eccentricity=0.010), one_turn(8), inner=True)
    pipe_edge(PIPE._replace(eccentricity=0.010), one_turn(8), inner=False)


def test_tilt_keeps_the_width():
    found = 1e3 * widths(path_of(True, width=0.5e-3, tilt=math.radians(8)), inner=True)
    assert abs(found - 0.5).max() < 4e-6


def test_feeds_points_and_lengths():
    for inner, ratios, ratio, counts, time in (
        (True, (1.435, 1.804), 1.546, [39, 54, 86, 121, 171], 7.775),
        (False, (1.340, 1.654), 1.426, [40, 56, 88, 124, 176], 7.793),
    ):
        path = path_of(inner)
        feeds = contact_feeds(path, 0.2 / 60, at_contact=True)
        found = feeds.contact / feeds.centre
        assert (found.min(), found.max()) == pytest.approx(ratios, abs=5e-4)
        edge = lengths(path.frames.point, closed=True).sum() / lengths(path.centre, closed=True).sum()
        assert edge == pytest.approx(ratio, abs=5e-4)
        assert feeds.time == pytest.approx(time, abs=1e-3)
        assert [points_for(path, e * 1e-6) for e in (10, 5, 2, 1, 0.5)] == counts
        assert chord_error(path) * 2880**2 * 1e3 == pytest.approx(14.49 if inner else 15.35, rel=2e-3)


def test_sensitivity_to_depth():
    for inner, expected in ((True, 1.484), (False, -1.315)):
        path = path_of(inner)
        up, down = (widths(path, inner=inner, shift=(0, 0, s * 1e-7)) for s in (1, -1))
        slope = (up - down) / 2e-7
        assert slope[np.argmax(abs(slope))] == pytest.approx(expected, abs=1e-3)
    wedge = np.radians([74.534, 90.0, 107.92])
    np.testing.assert_allclose(width_slope(0.3e-3, BALL, wedge), [-1.44, -1.86, -2.49], atol=5e-3)
    assert stand_off(0.3e-3, BALL, np.array([np.pi / 2]))[0] == pytest.approx(1.844367e-3, abs=1e-9)


def test_mirror_symmetry_and_the_plate_limit():
    path = path_of(True, points=360)
    mirrored = path.centre[(-np.arange(360)) % 360] * np.array([1, -1, 1])
    np.testing.assert_allclose(path.centre, mirrored, atol=1e-15)
    expected = 0.004 - stand_off(0.3e-3, BALL, np.array([np.pi / 2]))[0] / math.sqrt(2)
    away = []
    for radius in (10.0, 100.0):  # the wedge is off by (r/R) cos^2: first order in 1/R, zero at 90 degrees
        flat = path_of(False, part=PipeHole(radius, 0.002, 0.004), points=36).centre
        away.append(np.hypot(flat[:, 0], flat[:, 1]) - expected)
    assert away[1].mean() == pytest.approx(1.5e-8, rel=0.02)
    np.testing.assert_allclose(away[0], 10.0 * away[1], rtol=2e-3, atol=1e-12)


def test_constant_leg_gives_the_tabled_widths():
    for inner, low, high in ((False, 0.2557, 0.3000), (True, 0.3000, 0.3441)):
        path = path_of(inner, width=0.3e-3 / math.sqrt(2), leg=True, tier=1)
        np.testing.assert_allclose(path.leg, 0.3e-3 / math.sqrt(2), rtol=1e-12)
        found = 1e3 * np.linalg.norm(path.contact[:, 0] - path.contact[:, 1], axis=1)
        assert (found.min(), found.max()) == pytest.approx((low, high), abs=6e-5)
