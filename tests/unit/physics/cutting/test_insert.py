"""Force of a turning insert, and the limit of chatter that its slopes give."""

import math

import numpy as np
import pytest

from cutwise.physics.cutting.flute import EdgeCoefficients
from cutwise.physics.cutting.insert import InsertEdge, chip_slopes
from cutwise.physics.cutting.regeneration import depth_limit
from cutwise.physics.cutting.uneven import Kienzle, even_edges, kienzle_edges
from cutwise.physics.engagement.insert import ELEMENTS, Insert, edge_rows
from cutwise.records import Contact, Load
from cutwise.stages import cut

STEEL = EdgeCoefficients(2000e6, 900e6, 0.0, 30e3, 25e3, 0.0)


def force(edges, feed, depth, nose, lead):
    table, load = np.zeros((ELEMENTS, 12)), Load(np.zeros((1, 3)), np.zeros(6))
    count = edge_rows(table, Insert(nose, math.radians(lead), np.zeros(1)), feed, depth)
    cut(InsertEdge(edges), Contact(table, np.zeros(4)), count, 0.0, 0.0, load)
    assert (load.layer[0] == load.total[:3]).all()
    return load.total[:3], table[:count]


@pytest.mark.parametrize("lead", [45.0, 75.0, 90.0])
def test_a_deep_cut_is_that_of_a_straight_edge(lead):
    """b = a / sin k, h = f sin k: F_c = K_tc a f + K_te b; the rest square to the edge."""
    f, a, k = 0.2e-3, 40e-3, math.radians(lead)
    found, _ = force(even_edges(STEEL), f, a, f, lead)
    width, h = a / math.sin(k), f * math.sin(k)
    across = (STEEL.K_rc * h + STEEL.K_re) * width
    assert found[2] == pytest.approx((STEEL.K_tc * h + STEEL.K_te) * width, rel=0.01)
    assert found[0] == pytest.approx(-across * math.sin(k), rel=0.01)
    assert found[1] == pytest.approx(across * math.cos(k), rel=0.01, abs=0.01 * across)


def test_kienzle_without_exponent_is_linear_without_edge_force():
    same = Kienzle(2000e6, 0.0, 900e6, 0.0, 0.0, 0.0)
    linear = STEEL._replace(K_te=0.0, K_re=0.0)
    one, _ = force(kienzle_edges(same), 0.2e-3, 1e-3, 0.8e-3, 95.0)
    other, _ = force(even_edges(linear), 0.2e-3, 1e-3, 0.8e-3, 95.0)
    assert one == pytest.approx(other, rel=1e-12)


@pytest.mark.parametrize("edges", [even_edges(STEEL), kienzle_edges(Kienzle(1500e6, 0.22, 375e6, 0.3, 0.0, 0.0))])
def test_slopes_are_those_of_the_force(edges):
    """A tool that moves by u thickens the chip by n u at every element."""
    _, table = force(edges, 0.2e-3, 1e-3, 0.8e-3, 75.0)
    found, step = chip_slopes(table, edges), 1e-9

    def moved(u):
        load, thicker = Load(np.zeros((1, 3)), np.zeros(6)), table.copy()
        thicker[:, 5] += thicker[:, 3] * u[0] - thicker[:, 4] * u[1]
        cut(InsertEdge(edges), Contact(thicker, np.zeros(4)), len(thicker), 0.0, 0.0, load)
        return load.total[:3].copy()

    for axis in range(2):
        u = np.eye(2)[axis] * step
        assert (moved(u) - moved(-u)) / (2 * step) == pytest.approx(found[:, axis], rel=1e-4)


def test_orthogonal_limit_of_one_mode():
    """Altintas 2012, ch. 4: least depth 2 k zeta (1 + zeta) / K over all speeds, here along the feed."""
    stiffness, zeta, omega = 2e7, 0.03, 2 * math.pi * 250.0
    row = np.zeros((1, 12))
    row[0, 2:6] = 1.0, 1.0, 0.0, 0.1e-3  # one metre of edge, square to the feed

    def receptance(at):
        total = np.zeros((len(at), 3, 3), complex)
        ratio = at / omega
        total[:, 0, 0] = 1.0 / (stiffness * (1 - ratio**2 + 2j * zeta * ratio))
        return total

    slopes = chip_slopes(row, even_edges(STEEL))
    assert slopes == pytest.approx(np.array([[-STEEL.K_rc, 0], [0, 0], [STEEL.K_tc, 0]]))
    limits = [depth_limit(receptance, slopes, 60.0 / n, 500.0).depth for n in np.linspace(900.0, 1400.0, 26)]
    expected = 2 * stiffness * zeta * (1 + zeta) / STEEL.K_rc
    assert min(limits) == pytest.approx(expected, rel=0.02)
    assert min(limits) >= expected * (1 - 1e-6)
