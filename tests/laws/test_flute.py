"""Flute forces: limits, symmetry, the mean over a turn, power, and scaling of units."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cutwise.physics.cutting.flute import EdgeCoefficients, Mill, mean_force, mirrored, tooth_force

K = EdgeCoefficients(2.0e9, 1.2e9, 0.8e9, 1e3, 2e3, 5e2)
FINITE = {"allow_nan": False, "allow_infinity": False}


def turn_mean(mill, lo, hi, chip, theta, width, k, samples=4096):
    angle = (np.arange(samples) + 0.5) * 2 * math.pi / mill.flutes / samples
    return np.mean([tooth_force(a, lo, hi, chip, theta, 0.0, width, mill, k)[:4] for a in angle], axis=0)


@pytest.mark.parametrize("helix", [0.0, 5.0, 20.0, 45.0, -30.0])
@pytest.mark.parametrize("theta", [-0.5, 0.0, 0.4])
def test_mean_over_a_tooth_drops_the_helix(helix, theta):
    mill = Mill(4e-3, 4, math.radians(helix))
    expected = mean_force(2.2, 3.4, 6e-6, theta, 3e-3, 4, K)
    found = turn_mean(mill, 2.2, 3.4, 6e-6, theta, 3e-3, K)
    assert found == pytest.approx(np.array(expected), rel=2e-3, abs=1e-3)


def test_zero_helix_is_the_limit_of_a_small_one():
    for rotation in np.linspace(0.1, 0.4, 7):
        straight = tooth_force(rotation, 2.0, 3.2, 6e-6, 0.1, 0.0, 5e-3, Mill(4e-3, 20, 0.0), K)
        nearly = tooth_force(rotation, 2.0, 3.2, 6e-6, 0.1, 0.0, 5e-3, Mill(4e-3, 20, 1e-9), K)
        assert straight == pytest.approx(nearly, rel=1e-6)


def test_one_pitch_further_is_the_same():
    mill = Mill(4e-3, 7, 0.4)
    a = tooth_force(0.3, 2.0, 3.2, 6e-6, 0.1, 0.0, 5e-3, mill, K)
    b = tooth_force(0.3 + 5 * 2 * math.pi / 7, 2.0, 3.2, 6e-6, 0.1, 0.0, 5e-3, mill, K)
    assert a == pytest.approx(b, rel=1e-9)


def test_two_arcs_and_two_layers_add_up():
    mill = Mill(4e-3, 7, 0.4)
    whole = np.array(tooth_force(0.3, 2.0, 3.2, 6e-6, 0.1, 0.0, 5e-3, mill, K))
    arcs = [tooth_force(0.3, lo, hi, 6e-6, 0.1, 0.0, 5e-3, mill, K) for lo, hi in ((2.0, 2.7), (2.7, 3.2))]
    strips = [tooth_force(0.3, 2.0, 3.2, 6e-6, 0.1, a, b, mill, K) for a, b in ((0.0, 1e-3), (1e-3, 5e-3))]
    assert np.sum(arcs, axis=0) == pytest.approx(whole, rel=1e-9)
    assert np.sum(strips, axis=0) == pytest.approx(whole, rel=1e-9)


def test_full_slot_has_no_net_shearing_along_the_normal_of_the_feed():
    """Tangential shearing of a full slot pushes across the feed, radial shearing along it: closed forms N b c K / 4."""
    k = EdgeCoefficients(2.0e9, 0.0, 0.0, 0.0, 0.0, 0.0)
    f = mean_force(0.0, math.pi, 6e-6, 0.0, 1e-3, 4, k)
    assert f.x == pytest.approx(0.0, abs=1e-9)
    assert f.y == pytest.approx(4 * 1e-3 * 6e-6 * 2.0e9 / 4)


def test_power_is_specific_energy_times_removal_rate():
    """K_tc times the material removal rate: F_t v = K_tc (p_r b v_f) for a chip without edge force."""
    k = EdgeCoefficients(2.0e9, 1.2e9, 0.8e9, 0.0, 0.0, 0.0)
    radius, depth, width, feed, omega, flutes = 4e-3, 1e-3, 1e-3, 0.08, 4188.79, 20
    lo = math.pi - math.acos(1 - depth / radius)
    f = mean_force(lo, math.pi, 2 * math.pi * feed / (flutes * omega), 0.0, width, flutes, k)
    assert f.tangential * radius * omega == pytest.approx(2.0e9 * depth * width * feed, rel=1e-9)
    assert f.tangential * radius * omega == pytest.approx(160.0, rel=1e-6)


def test_burr_force_at_zero_error():
    """R0 at e = 0: (5.758, 9.342, 3.820) N."""
    k = EdgeCoefficients(2.0e9, 1.2e9, 0.8e9, 0.0, 0.0, 0.0)
    f = mean_force(math.pi - math.acos(0.75), math.pi, 6e-6, 0.0, 1e-3, 20, k)
    assert f[:3] == pytest.approx((5.758, 9.342, 3.820), abs=5e-4)
    mill = Mill(4e-3, 20, math.radians(20.0))
    ripple = [tooth_force(a, math.pi - math.acos(0.75), math.pi, 6e-6, 0.0, 0.0, 1e-3, mill, k).y
              for a in np.linspace(0, 2 * math.pi / 20, 2000)]  # fmt: skip
    assert (min(ripple), max(ripple)) == pytest.approx((6.38, 12.52), abs=0.01)


def test_mirror_image_of_up_milling():
    """Up milling under the same arc: radial force off the work as before, tangential force reversed."""
    lo, hi, theta = 2.3, 3.2, 0.1
    for k in (EdgeCoefficients(0.0, 1.2e9, 0.0, 0.0, 0.0, 0.0), EdgeCoefficients(2.0e9, 0.0, 0.0, 0.0, 0.0, 0.0)):
        down = mean_force(lo, hi, 6e-6, theta, 1e-3, 4, k)
        up = mirrored(mean_force(math.pi - hi, math.pi - lo, 6e-6, -theta, 1e-3, 4, k))
        sign = 1.0 if k.K_rc else -1.0
        assert (up.x, up.y) == pytest.approx((sign * down.x, sign * down.y))


@settings(max_examples=60, deadline=None)
@given(
    lengths=st.floats(1e-3, 1e3, **FINITE),
    stresses=st.floats(1e-3, 1e3, **FINITE),
    rotation=st.floats(-10.0, 10.0, **FINITE),
    lo=st.floats(1.6, 3.0, **FINITE),
    span=st.floats(0.05, 1.5, **FINITE),
)
def test_scaling_of_units(lengths, stresses, rotation, lo, span):
    mill = Mill(4e-3, 7, 0.4)
    scaled = Mill(4e-3 * lengths, 7, 0.4)
    k = EdgeCoefficients(*(x * stresses for x in K[:3]), *(x * stresses * lengths for x in K[3:]))
    a = tooth_force(rotation, lo, lo + span, 6e-6, 0.1, 0.0, 5e-3, mill, K)
    b = tooth_force(rotation, lo, lo + span, 6e-6 * lengths, 0.1, 0.0, 5e-3 * lengths, scaled, k)
    assert b == pytest.approx(np.array(a) * stresses * lengths**2, rel=1e-6, abs=1e-9 * stresses * lengths**2)


@pytest.mark.parametrize("flutes", [2, 3, 4])
def test_a_straight_flute_where_two_arcs_meet_is_in_one_of_them(flutes):
    """Exactly at the common end the sum of two arcs is that of the one arc they make, not a flute more."""
    mill = Mill(4e-3, flutes, 0.0)
    for middle in (0.5 * math.pi, 2.0, 0.25):
        whole = tooth_force(middle, 0.0, math.pi, 6e-6, 0.0, 0.0, 5e-3, mill, K)
        parts = [tooth_force(middle, *arc, 6e-6, 0.0, 0.0, 5e-3, mill, K) for arc in ((0.0, middle), (middle, math.pi))]
        assert np.sum(parts, axis=0) == pytest.approx(np.array(whole), rel=1e-12)
