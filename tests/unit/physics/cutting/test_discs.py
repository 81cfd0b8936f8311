"""Forces by discs: the summed form is the plain sum, and its limit is the closed form of the flute kernel."""

import math

import numpy as np
import pytest

from cutwise.physics.cutting.discs import disc_forces, discs
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.cutting.uneven import even_edges
from cutwise.physics.cutting.wall import AVERAGED, DISCS, FLUTES, tooth_period, wall_force
from peers.corner import AL7075

MILL = Mill(0.01, 3, math.radians(30))
METAL = even_edges(AL7075)


def disc_forces_plain(angle, wall, arc, feed_x, feed_y, lowest, highest, mill, k):
    """Disc by disc, as Eqs. (3) and (4) of Berselli et al. 2016 read, in machine axes."""
    fx, fy, fz = 0.0, 0.0, 0.0
    for tooth in range(mill.teeth):
        for d in range(lowest, highest):
            theta = angle - 2.0 * math.pi * tooth / mill.teeth + (d + 0.5) * mill.step
            h = feed_x * math.cos(theta) + feed_y * math.sin(theta)
            if (theta - wall) % (2.0 * math.pi) >= arc or h <= 0.0:
                continue
            ft = (k.K_tc * h + k.K_te) * mill.thickness
            fr = (k.K_rc * h + k.K_re) * mill.thickness
            fx -= ft * math.sin(theta) + fr * math.cos(theta)
            fy -= fr * math.sin(theta) - ft * math.cos(theta)
            fz -= (k.K_ac * h + k.K_ae) * mill.thickness
    return fx, fy, fz


def test_summed_discs_are_the_plain_sum():
    rng = np.random.default_rng(1)
    for _ in range(400):
        mill = discs(
            0.01, rng.uniform(0.0, 1.0), rng.uniform(1e-3, 0.03), int(rng.integers(1, 7)), int(rng.integers(1, 40))
        )
        angle, wall, arc = rng.uniform(-20, 20), rng.uniform(-7, 7), rng.uniform(0.0, math.pi)
        feed = rng.normal(0.0, 1e-4, 2)
        ends = sorted(rng.integers(0, mill.count + 1, 2).tolist())
        summed = disc_forces(angle, wall, arc, *feed, *ends, mill, AL7075)
        plain = disc_forces_plain(angle, wall, arc, *feed, *ends, mill, AL7075)
        assert summed == pytest.approx(plain, rel=1e-9, abs=1e-7)


@pytest.mark.parametrize("arc", [0.3, 0.927, 2.2])
def test_many_discs_are_the_closed_form(arc):
    """Midpoint rule with the edges of the arc inside a disc: error of first order, a disc's force at most."""
    closed = tooth_period(FLUTES, 0.0, arc, 1e-4, 5e-3, MILL, discs(0.01, MILL.helix, 5e-3, 3, 1), METAL, 180)
    errors = []
    for count in (100, 1000, 10000):
        found = tooth_period(DISCS, 0.0, arc, 1e-4, 5e-3, MILL, discs(0.01, MILL.helix, 5e-3, 3, count), METAL, 180)
        errors.append(np.sqrt(np.mean((found - closed) ** 2)))
    slope = np.polyfit(np.log([100, 1000, 10000]), np.log(errors), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.15)
    assert errors[-1] < 0.1


@pytest.mark.parametrize("law", [FLUTES, DISCS])
def test_mean_over_a_period_is_the_averaged_force(law):
    mill = discs(0.01, MILL.helix, 5e-3, 3, 20)
    period = tooth_period(law, 0.0, 2.2, 1e-4, 5e-3, MILL, mill, METAL, 20000)
    mean = wall_force(AVERAGED, 0.0, 0.0, 0.0, 2.2, 0.0, 5e-3, 1e-4, 0.0, MILL, mill, METAL)
    assert period.mean(axis=0) == pytest.approx(mean, rel=1e-3)


@pytest.mark.parametrize("law", [AVERAGED, FLUTES, DISCS])
def test_forces_turn_with_the_heading(law):
    mill = discs(0.01, MILL.helix, 5e-3, 3, 20)
    turn = 0.7
    a = wall_force(law, 0.4, 0.0, 0.2, 1.5, 1e-3, 5e-3, 1e-4, 2e-5, MILL, mill, METAL)
    c, s = math.cos(turn), math.sin(turn)
    feed = (c * 1e-4 - s * 2e-5, s * 1e-4 + c * 2e-5)
    b = wall_force(law, 0.4 + turn, turn, 0.2, 1.5, 1e-3, 5e-3, *feed, MILL, mill, METAL)
    assert b == pytest.approx((c * a[0] - s * a[1], s * a[0] + c * a[1], a[2]), rel=1e-9)


def test_reference_figures_of_the_static_cut():
    """Means 152 and 449 N, peaks 450.2 and 562.2 N with many discs (straight 53.13 degrees, corner 143.13)."""
    mill = discs(0.01, MILL.helix, 5e-3, 3, 200)
    for arc, mean, peak in ((0.9272952180016122, 152.0, 450.2), (2.498091544796509, 449.0, 562.2)):
        f = wall_force(AVERAGED, 0.0, 0.0, 0.0, arc, 0.0, 5e-3, 1e-4, 0.0, MILL, mill, METAL)
        assert math.hypot(f[0], f[1]) == pytest.approx(mean, abs=0.5)
        forces = tooth_period(FLUTES, 0.0, arc, 1e-4, 5e-3, MILL, mill, METAL, 3600)
        assert np.hypot(forces[:, 0], forces[:, 1]).max() == pytest.approx(peak, rel=1e-3)
