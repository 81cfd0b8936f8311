"""Forces of the general tool: the worked examples, and equality with the flute and the ball kernel."""

import math

import numpy as np
import pytest

from cutwise.maths import profiles
from cutwise.physics.cutting.ball import disc_force
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill, mean_force
from cutwise.physics.cutting.meridian import CYLINDER, Chip, meridian_force, peak_force, thickest_chip
from cutwise.physics.cutting.uneven import even_edges

MM = 1e-3
K = EdgeCoefficients(767.01e6, 168.8e6, 222e6, 27.7e3, 26.6e3, 0.7e3)
WHEEL = 8000 * 2 * math.pi / 60
NOTHING = profiles.meridian(profiles.flat(10 * MM), 10 * MM, 1)


def side(degrees, depth=5.0):
    return np.array([[CYLINDER, -math.pi / 2, math.radians(degrees) - math.pi / 2, 0.0, depth * MM]])


@pytest.mark.parametrize(
    ("degrees", "force", "torque", "peak"),
    [
        (53.130102, (77.085, 131.101, -22.749), 1.345651, 449.57),
        (61.429940, (82.418, 165.523, -29.445), 1.664412, 485.51),
        (101.536959, (36.827, 341.108, -66.560), 3.369228, 562.17),
        (143.130102, (-101.674, 437.047, -99.572), 4.947943, 562.17),
    ],
)
def test_worked_example_e_along_the_corner(degrees, force, torque, peak):
    rows = side(degrees)
    f = meridian_force(rows, 1, NOTHING, 10 * MM, 3, Chip(0.1 * MM, 0.0), K)
    assert f[:3] == pytest.approx(force, abs=2e-3)
    assert f.torque == pytest.approx(torque, rel=1e-6)
    found = peak_force(rows, 1, NOTHING, Mill(10 * MM, 3, math.radians(30)), Chip(0.1 * MM, 0.0), K)
    assert found == pytest.approx(peak, rel=5e-3)


def bottom(core):
    edge = profiles.meridian(profiles.flat(10 * MM), core * MM, 12)
    n = edge.length.size
    return edge, np.column_stack([np.arange(n), np.full(n, -math.pi), np.full(n, math.pi), np.zeros(n), np.zeros(n)])


@pytest.mark.parametrize(("core", "thrust", "torque"), [(0.0, 861.30, 5.593144), (2.0, 689.04, 5.369418)])
def test_worked_example_e_plunge(core, thrust, torque):
    edge, rows = bottom(core)
    f = meridian_force(rows, len(rows), edge, 10 * MM, 3, Chip(0.0, -0.0125 * MM), K)
    assert f.z == pytest.approx(thrust, rel=1e-9)
    assert f.end == pytest.approx(thrust, rel=1e-9)
    assert f.torque == pytest.approx(torque, rel=1e-6)
    assert f[:2] == pytest.approx((0.0, 0.0), abs=1e-9)


def test_worked_example_e_ramp_and_its_balance():
    """Down 10 degrees, the rim in a full slot: torque times speed is K_tc times what is removed, and the edge part."""
    edge, rows = bottom(0.0)
    rows = np.vstack([rows, [[CYLINDER, -math.pi / 2, math.pi / 2, 0.0, 5 * MM]]])
    a = math.radians(10)
    f = meridian_force(rows, len(rows), edge, 10 * MM, 3, Chip(0.1 * MM * math.cos(a), -0.1 * MM * math.sin(a)), K)
    assert f[:3] == pytest.approx((-189.34, 415.52, 776.30), abs=6e-3)
    assert f.torque == pytest.approx(11.83691, rel=1e-6)
    removed = 40 * MM * (10 * MM * 5 * MM * 2 * math.cos(a) + math.pi * (10 * MM) ** 2 * math.sin(a))
    assert 1e9 * removed == pytest.approx(6121.358, abs=1e-3)
    edges = K.K_te * WHEEL * 3 * (0.5 * (10 * MM) ** 2 + 0.5 * 5 * MM * 10 * MM)
    assert f.torque * WHEEL == pytest.approx(K.K_tc * removed + edges, rel=1e-8)


def test_a_straight_side_is_the_flute_kernel():
    rows = np.array([[CYLINDER, -0.9, 0.4, 1 * MM, 4 * MM]])
    f = meridian_force(rows, 1, NOTHING, 10 * MM, 3, Chip(0.1 * MM, 0.0), K)
    kernel = mean_force(0.5 * math.pi - 0.4, 0.5 * math.pi + 0.9, 0.1 * MM, 0.0, 3 * MM, 3, K)
    assert (f.x, f.y, -f.z, f.torque) == pytest.approx((kernel.x, kernel.y, kernel.z, 10 * MM * kernel.tangential))
    upright = profiles.Meridian(*(np.array([v]) for v in (2 * MM, 10 * MM, 1.0, 0.0, 3 * MM)))
    same = meridian_force(np.array([[0, -0.9, 0.4, 0, 0]]), 1, upright, 10 * MM, 3, Chip(0.1 * MM, 0.0), K)
    assert same[:4] == pytest.approx(f[:4], rel=1e-12, abs=1e-9)


def test_an_element_of_a_ball_is_the_ball_kernel():
    """Across the axis the ball kernel counts axial coefficients with the other sign; the rest is the same."""
    kappa, radius, height = 0.8, 3 * MM, 0.05 * MM
    z = -radius * math.cos(kappa)
    ds = height / math.sin(kappa)
    one = profiles.Meridian(
        *(np.array([v]) for v in (radius + z, radius * math.sin(kappa), math.sin(kappa), math.cos(kappa), ds))
    )
    plain = K._replace(K_ac=0.0, K_ae=0.0)
    f = meridian_force(np.array([[0, -0.9, 0.4, 0, 0]]), 1, one, radius, 2, Chip(0.08 * MM, -0.01 * MM), plain)
    kernel = disc_force(
        0.5 * math.pi - 0.4, 0.5 * math.pi + 0.9, z, height, radius, 0.08 * MM, 0.0, -0.01 * MM, 2, even_edges(plain)
    )
    assert f[:3] == pytest.approx((kernel.x, kernel.y, kernel.z), rel=1e-9)
    assert f.torque == pytest.approx(radius * math.sin(kappa) * kernel.tangential, rel=1e-9)


def test_thickest_chip():
    edge, rows = bottom(0.0)
    assert thickest_chip(rows, len(rows), edge, Chip(0.0, -0.0125 * MM)) == pytest.approx(0.0125 * MM)
    assert thickest_chip(side(53.130102), 1, NOTHING, Chip(0.1 * MM, 0.0)) == pytest.approx(0.08 * MM)
    assert thickest_chip(side(143.13), 1, NOTHING, Chip(0.1 * MM, 0.0)) == pytest.approx(0.1 * MM)
