"""Ball-end forces by discs: the numbers of a 90 degree edge, the power balance, the cylinder limit, and burrs."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq

from cutwise.physics.cutting.ball import disc_coefficients
from cutwise.physics.cutting.flute import EdgeCoefficients
from cutwise.physics.engagement.ball import NO_BURR, Burr, Wedge, burr_bounds, chip_area, pass_frames
from cutwise.process.chamfer_loop import BallEnd, ball_force

K = EdgeCoefficients(2000e6, 1200e6, 800e6, 0.0, 0.0, 0.0)
BALL = BallEnd(0.002, 20, 40000 * 2 * math.pi / 60, K)
FEED = 0.08


def stand_off(width):
    return math.sqrt(0.002**2 - 0.25 * width**2) - 0.5 * width


def edge(side, width=0.3e-3):
    """A 90 degree edge at a hole wall (+y) and a face below (-1) or above (+1)."""
    y = -stand_off(width) / math.sqrt(2)
    return Wedge(y, side * y, 0.0, side, 1.0, 0.0)


def on_wall(height, width, side=-1.0):
    """A burr on the wall, whose material lies above an inner edge (-1) and below an outer one (+1)."""
    return Burr(height, width, 0.0, -side, 1.0, 0.0)


@pytest.mark.parametrize(
    ("side", "force"), [(-1.0, (0.468, 0.602, -0.078)), (1.0, (0.566, 0.273, 0.440))]
)  # fmt: skip
def test_forces_of_a_square_edge(side, force):
    """The reference's own slices err by 0.4 % in power; ours by less than 1e-5, so they agree within that."""
    found, power = ball_force(edge(side), NO_BURR, BALL, FEED, 0.0, 400, 0)
    assert (found.x, found.y, found.z) == pytest.approx(force, rel=0.01)
    area = chip_area(edge(side), NO_BURR, BALL.ball_radius, 4000)
    assert area == pytest.approx(0.02363e-6, rel=5e-4)
    assert power == pytest.approx(K.K_tc * area * FEED, rel=1e-4)


def test_forces_converge_with_the_second_order_of_the_discs():
    """48 discs, as used: power within 1.1e-5 of K_tc A v, which holds for any edge."""
    exact = K.K_tc * chip_area(edge(-1.0), NO_BURR, BALL.ball_radius, 100_000) * FEED
    error = [abs(ball_force(edge(-1.0), NO_BURR, BALL, FEED, 0.0, n, 0)[1] / exact - 1.0) for n in (12, 24, 48)]
    assert [math.log2(a / b) for a, b in pairwise(error)] == pytest.approx([2.0, 2.0], abs=0.05)
    assert error[-1] < 1.1e-5


@pytest.mark.parametrize(("force", "width"), [(1.73, 0.45), (5.59, 0.80), (5.82, 0.81), (12.48, 1.18)])
def test_lateral_force_meets_the_plateaus_at_the_widths_of_the_reference(force, width):
    """Plateaus of the spindle at 2 bar (1.73 to 5.59 N) and 5 bar (5.82 to 12.48 N) over the width of the chamfer."""

    def lateral(w):
        f, _ = ball_force(edge(-1.0, w), NO_BURR, BALL, FEED, 0.0, 200, 0)
        return math.hypot(f.x, f.y)

    assert 1e3 * brentq(lambda w: lateral(w) - force, 0.1e-3, 1.5e-3) == pytest.approx(width, abs=0.01)
    assert lateral(0.3e-3) == pytest.approx(0.76, abs=0.005)


def test_a_disc_at_the_equator_is_a_cylinder():
    assert disc_coefficients(math.pi / 2, K) == pytest.approx(K, rel=1e-12)


def test_a_burr_is_cut_with_the_power_of_its_section():
    """A strip 0.2 mm high and 0.1 mm wide on the wall, all of it inside the ball, adds K_tc v times its 0.02 mm^2."""
    strip = on_wall(0.2e-3, 0.1e-3)
    area = chip_area(edge(-1.0), strip, BALL.ball_radius, 4000) - chip_area(edge(-1.0), NO_BURR, BALL.ball_radius, 4000)
    assert area == pytest.approx(0.02e-6, rel=1e-9)
    _, power = ball_force(edge(-1.0), strip, BALL, FEED, 0.0, 400, 1)
    assert power == pytest.approx(K.K_tc * area * FEED, rel=1e-4)


def test_burr_forces_add_to_those_of_the_work_and_vanish_with_it():
    none, power = ball_force(edge(-1.0), NO_BURR, BALL, FEED, 0.0, 48, 1)
    assert (*none, power) == (0.0, 0.0, 0.0, 0.0, 0.0)
    small, _ = ball_force(edge(-1.0), on_wall(1e-9, 0.1e-3), BALL, FEED, 0.0, 48, 1)
    assert abs(small.x) + abs(small.y) < 1e-5


def test_burr_on_a_leaning_face_is_its_rectangle():
    """Sides at 30 degrees: the cut at the height of the second corner runs through the diagonal's shadow."""
    lean = math.radians(30.0)
    strip = Burr(0.2e-3, 0.4e-3, math.sin(lean), math.cos(lean), math.cos(lean), -math.sin(lean))
    wedge = Wedge(-1e-3, 0.5e-3, 0.0, -1.0, math.cos(lean), -math.sin(lean))
    heights = wedge.z + np.linspace(-0.2e-3 * math.sin(lean), 0.4e-3 * math.cos(lean), 4001)
    middle = 0.5 * (heights[1:] + heights[:-1])
    bounds = np.array([burr_bounds(wedge, strip, z) for z in middle])
    assert (bounds[:, 1] - bounds[:, 0]).sum() * np.diff(heights)[0] == pytest.approx(0.08e-6, rel=1e-6)
    assert burr_bounds(wedge, strip, heights[0] - 1e-9) == (math.inf, -math.inf)


def test_feed_directions_where_the_edge_plunges_are_those_of_their_neighbours():
    tangent = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    found = pass_frames(tangent, np.array([0.0, 0.0, 1.0]))
    assert found.plunge.tolist() == [0.0, 1.0, 0.0]
    assert found.feed[1].tolist() in ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0])
    np.testing.assert_allclose(np.linalg.norm(found.off, axis=1), 1.0)
