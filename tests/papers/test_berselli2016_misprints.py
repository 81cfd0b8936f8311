"""Berselli et al. 2016: the misprints that stand in the text, not in the force integrals (those: see _forces)."""

import math

import numpy as np
import pytest

from cutwise.physics.cutting.flute import EdgeCoefficients, Mill, mean_force, tooth_force
from cutwise.physics.engagement.arc import layer_arcs
from cutwise.physics.engagement.feed import feed_direction
from peers.cells import MM, end_error
from peers.flute import trochoid_forces

PAPER = EdgeCoefficients(2.0e9, 1.2e9, 0.8e9, 0.0, 0.0, 0.0)


def test_eq5_as_printed_has_a_second_dz():
    """Misprint: Eq. (5) integrates dF over dz although dF of Eq. (3) holds dz; so it vanishes with the slices."""
    mill, phi, chip, height = Mill(4 * MM, 1, 0.0), 2.5, 6e-6, 2 * MM
    exact = tooth_force(phi, 2.0, 3.0, chip, 0.0, 0.0, height, mill, PAPER).y

    def element(dz):
        h = chip * math.sin(phi)
        return (PAPER.K_tc * h * math.sin(phi) - PAPER.K_rc * h * math.cos(phi)) * dz

    for slices in (10, 100):
        dz = height / slices
        assert slices * element(dz) == pytest.approx(exact)
        assert slices * element(dz) * dz == pytest.approx(exact * height / slices)  # and a moment, not a force


def test_feed_direction_as_printed_has_the_opposite_sign():
    """Misprint: v_F = v_p - v_A gives theta the sign under which Eqs. (9)-(11) do not hold; the trochoid decides."""
    mill, omega = Mill(4 * MM, 20, math.radians(20.0)), 4188.79
    velocity = np.array([0.08, -0.025])  # of the tool relative to the work: plunging
    v_f = -velocity
    printed = math.atan(v_f[1] / v_f[0])
    theta = feed_direction(*velocity)
    assert printed == pytest.approx(-theta)
    assert theta > 0.0
    exact = trochoid_forces(1 * MM, 0.0, velocity, omega, mill, 1 * MM, PAPER)[0]
    chip = 2 * math.pi * math.hypot(*velocity) / (mill.flutes * omega)

    def off(angle):
        arcs = layer_arcs(1 * MM, 0.0, angle, mill.radius)
        force = np.array(mean_force(arcs.front_lo, arcs.front_hi, chip, angle, 1 * MM, mill.flutes, PAPER)[:3])
        return np.abs(force - exact).max() / np.abs(exact).max()

    assert off(theta) < 0.01
    assert off(printed) > 0.2
    assert feed_direction(-0.08, -0.01) > 0.5 * math.pi  # the quadrant that the printed arctangent loses


def test_no_contact_is_a_fourth_case():
    """Missing case: with p_r <= 0 the printed arccos has no value; nothing cuts, and the whole burr is left."""
    with pytest.raises(ValueError, match=r"domain|range"):
        math.acos(1.0 - 2.0 * (-0.2 * MM) / (8 * MM))
    arcs = layer_arcs(-0.2 * MM, 0.0, 0.0, 4 * MM)
    assert arcs.front_hi == arcs.front_lo
    assert end_error(preset=-1.2 * MM) == pytest.approx(1.0)  # mm: the burr


def test_hn_of_section_4_buries_the_mill():
    """Misprint: with h_n = 5 mm from O the undeflected mill, lowest at -4 mm, would stand deeper than its diameter."""
    nominal, burr, diameter = 5 * MM, 1 * MM, 8 * MM
    lowest = -0.5 * diameter
    depth = nominal + burr - lowest
    assert depth > diameter
    assert 1.0 - 2.0 * depth / diameter < -1.0  # outside arccos
