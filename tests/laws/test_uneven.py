"""Run-out and Kienzle's law: limits in which they become the even linear flute, and what run-out cannot change."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cutwise.physics.cutting.flute import EdgeCoefficients, Mill, mean_force, tooth_force
from cutwise.physics.cutting.uneven import (
    KIENZLE,
    LINEAR,
    NO_KIENZLE,
    Edges,
    Kienzle,
    chip_thickness,
    largest_radius,
    turning_mean_force,
    uneven_tooth_force,
)

K = EdgeCoefficients(2.0e9, 1.2e9, 0.8e9, 0.0, 0.0, 0.0)
EDGE = EdgeCoefficients(2.0e9, 1.2e9, 0.8e9, 1e3, 2e3, 5e2)
MILL = Mill(4e-3, 20, math.radians(20.0))
LO, HI = math.pi - math.acos(0.75), math.pi


def edges(k=K, runout=0.0, angle=0.0):
    return Edges(LINEAR, k, NO_KIENZLE, runout, angle)


def once_per_turn(runout, mill=MILL, force=uneven_tooth_force):
    turn = np.arange(2000) * 2 * math.pi / 2000
    f = np.array([force(a, LO, HI, 6e-6, 0.0, 0.0, 1e-3, mill, edges(runout=runout))[:3] for a in turn])
    return f.mean(0), 2 * np.abs(np.exp(1j * turn) @ f) / len(turn), f.max(0)


def averaged(rotation, lo, hi, chip, theta, _z_lo, z_hi, mill, edges_):
    return turning_mean_force(rotation, lo, hi, chip, theta, z_hi, mill, edges_)


@pytest.mark.parametrize("rotation", [0.0, 0.1, 0.25])
@pytest.mark.parametrize("k", [K, EDGE])
def test_without_runout_quadrature_is_the_closed_form(rotation, k):
    even = tooth_force(rotation, LO, HI, 6e-6, 0.1, 0.0, 5e-3, MILL, k)
    assert uneven_tooth_force(rotation, LO, HI, 6e-6, 0.1, 0.0, 5e-3, MILL, edges(k)) == pytest.approx(even, rel=1e-6)
    mean = mean_force(LO, HI, 6e-6, 0.0, 1e-3, 20, k)
    assert turning_mean_force(rotation, LO, HI, 6e-6, 0.0, 1e-3, MILL, edges(k)) == pytest.approx(mean, rel=1e-6)


@pytest.mark.parametrize("force", [uneven_tooth_force, averaged])
@pytest.mark.parametrize(("runout", "amplitude"), [(5e-6, 5.7), (10e-6, 9.8), (20e-6, 13.9)])
def test_once_per_turn_force(runout, amplitude, force):
    assert once_per_turn(runout, force=force)[1][1] == pytest.approx(amplitude, abs=0.06)


@pytest.mark.parametrize(("runout", "peak"), [(0.0, 12.5), (5e-6, 18.8), (10e-6, 24.5), (20e-6, 36.9)])
def test_peak_force(runout, peak):
    assert once_per_turn(runout)[2][1] == pytest.approx(peak, rel=0.01)


def test_runout_moves_material_between_flutes_but_takes_no_more():
    """Without edge terms the mean force is that of the removed volume, whichever flute removes it."""
    even = mean_force(LO, HI, 6e-6, 0.0, 1e-3, 20, K)[:3]
    for runout in (5e-6, 20e-6, 60e-6):
        assert once_per_turn(runout)[0] == pytest.approx(even, rel=2e-3)


def test_half_of_the_flutes_cut_at_twenty_micrometres():
    at = np.arange(20) * 2 * math.pi / 20
    h = np.array([chip_thickness(6e-6, 0.5, a, 20e-6, 20) for a in at])
    assert (h > 0).sum() == 10
    assert h.sum() == pytest.approx(20 * 0.5 * 6e-6, rel=1e-9)


@settings(max_examples=60, deadline=None)
@given(
    flutes=st.integers(1, 24),
    runout=st.floats(0.0, 50e-6, allow_nan=False),
    chip=st.floats(1e-7, 1e-4, allow_nan=False),
    start=st.floats(0.0, 6.28, allow_nan=False),
)
def test_chips_of_a_turn_add_up_to_the_feed_per_turn(flutes, runout, chip, start):
    h = [chip_thickness(chip, 1.0, start + 2 * math.pi * j / flutes, runout, flutes) for j in range(flutes)]
    assert sum(h) == pytest.approx(flutes * chip, rel=1e-9)


def test_surface_is_cut_by_the_outermost_flute():
    assert largest_radius(10e-6, 0.0, 20) == pytest.approx(10e-6)
    assert largest_radius(10e-6, math.pi / 20, 20) == pytest.approx(10e-6 * math.cos(math.pi / 20))


def test_kienzle_with_exponent_zero_is_linear_without_edge():
    k = Kienzle(K.K_tc, 0.0, K.K_rc, 0.0, K.K_ac, 0.0)
    power = Edges(KIENZLE, K, k, 0.0, 0.0)
    even = tooth_force(0.1, LO, HI, 6e-6, 0.0, 0.0, 1e-3, MILL, K)
    assert uneven_tooth_force(0.1, LO, HI, 6e-6, 0.0, 0.0, 1e-3, MILL, power) == pytest.approx(even, rel=1e-6)


def test_kienzle_scales_with_the_chip_as_its_exponent():
    power = Edges(KIENZLE, K, Kienzle(8e8, 0.25, 3e8, 0.25, 2e8, 0.25), 0.0, 0.0)
    a = turning_mean_force(0.0, LO, HI, 50e-6, 0.0, 1e-3, MILL, power).tangential
    b = turning_mean_force(0.0, LO, HI, 100e-6, 0.0, 1e-3, MILL, power).tangential
    assert b / a == pytest.approx(2**0.75, rel=1e-3)


def test_quadrature_converges_on_kienzle():
    """Against a fine midpoint rule: 1e-4 of the force, the root at h = 0 included."""
    power = Edges(KIENZLE, K, Kienzle(8e8, 0.25, 3e8, 0.3, 2e8, 0.2), 0.0, 0.0)
    phi = np.linspace(LO, HI, 400_001)
    phi = 0.5 * (phi[1:] + phi[:-1])
    h = 6e-6 * np.sin(phi)
    ft = 8e8 * (np.maximum(h, 1e-7) * 1e3) ** -0.25 * h
    fine = 20 * 1e-3 / (2 * math.pi) * ft.sum() * (HI - LO) / phi.size
    assert turning_mean_force(0.0, LO, HI, 6e-6, 0.0, 1e-3, MILL, power).tangential == pytest.approx(fine, rel=1e-3)
