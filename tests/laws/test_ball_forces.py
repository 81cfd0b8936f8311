"""Ball-end forces by discs: the numbers of a 90 degree edge, the power balance, and the cylinder limit."""

import math

import pytest

from cutwise.physics.cutting.ball import disc_coefficients
from cutwise.physics.cutting.flute import EdgeCoefficients
from cutwise.physics.engagement.ball import Wedge, chip_area
from cutwise.process.chamfer_loop import BallEnd, ball_force

K = EdgeCoefficients(2000e6, 1200e6, 800e6, 0.0, 0.0, 0.0)
BALL = BallEnd(0.002, 20, 40000 * 2 * math.pi / 60, K)
STAND_OFF = math.sqrt(0.002**2 - 0.00015**2) - 0.00015


def edge(side):
    """A 90 degree edge at a hole wall (+y) and a face below (-1) or above (+1)."""
    y = -STAND_OFF / math.sqrt(2)
    return Wedge(y, side * y, 0.0, side, 1.0, 0.0)


@pytest.mark.parametrize(
    ("side", "force"), [(-1.0, (0.468, 0.602, -0.078)), (1.0, (0.566, 0.273, 0.440))]
)  # fmt: skip
def test_forces_of_a_square_edge(side, force):
    """The reference's own slices err by 0.4 % in power; ours by less than 1e-5, so they agree within that."""
    found, power = ball_force(edge(side), BALL, 0.08, 0.0, 400)
    assert (found.x, found.y, found.z) == pytest.approx(force, rel=0.01)
    area = chip_area(edge(side), BALL.ball_radius, 4000)
    assert area == pytest.approx(0.02363e-6, rel=5e-4)
    assert power == pytest.approx(K.K_tc * area * 0.08, rel=1e-4)


def test_a_disc_at_the_equator_is_a_cylinder():
    assert disc_coefficients(math.pi / 2, K) == pytest.approx(K, rel=1e-12)
