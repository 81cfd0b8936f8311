"""Walls of a bent mill against the balance solved by hand: force integrated over the arc, root found by another program."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from cutwise.physics.cutting.bent import bent_walls, moved_arcs
from cutwise.physics.cutting.discs import discs
from cutwise.physics.cutting.feed_limits import Teeth
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.uneven import even_edges
from cutwise.physics.cutting.wall import FLUTES

R, N, DEPTH, CHIP = 6e-3, 4, 5e-3, 5e-5
K = EdgeCoefficients(767.01e6, 168.8e6, 0.0, 27.7e3, 26.6e3, 0.0)
UM = 1e-6


def teeth(given=K, helix=0.0, depth=DEPTH):
    shear = even_edges(given._replace(K_te=0.0, K_re=0.0, K_ae=0.0))
    edge = even_edges(EdgeCoefficients(0.0, 0.0, 0.0, given.K_te, given.K_re, given.K_ae))
    return Teeth(FLUTES, Mill(R, N, helix), discs(R, helix, depth, N, 20), shear, edge)


def mean_force(arc, left, given=K, depth=DEPTH):
    """Into the wall, the mean over a turn: N b / 2 pi of the tooth's force over the arc from the wall on [N].

    Climbing (wall on the right) tangential and radial force push off it; up milling (left) the tangential one pulls into it.
    """

    def into(a):
        chip = CHIP * math.sin(a)
        ft, fr = given.K_tc * chip + given.K_te, given.K_rc * chip + given.K_re
        return (ft if left else -ft) * math.sin(a) - fr * math.cos(a)

    return N * depth / (2.0 * math.pi) * quad(into, 0.0, arc)[0]


def arc_of(depth):
    return math.acos(1.0 - depth / R)


def pushed(depth, shift, stiffness, *, left=False, given=K, averaged=True, helix=0.0, axial=DEPTH):
    """Bend to the right of a wall with one radial depth [m]."""
    arc = arc_of(depth)
    patch = np.array([[[math.pi - arc, math.pi, 0.0, axial] if left else [0.0, arc, 0.0, axial]]])
    walls, one = np.array([[0.0, 1.0] if left else [1.0, 0.0]]), np.ones(1)
    found = bent_walls(
        patch, walls, 0.7 * one, CHIP * one, shift * one, teeth(given, helix, axial), np.eye(2) / stiffness, averaged
    )
    return found[0, int(left)]


@pytest.mark.parametrize("left", [False, True])
@pytest.mark.parametrize("stiffness", [3e6, 1e7, 1e8])
@pytest.mark.parametrize("shift", [0.0, 15 * UM, -15 * UM])
def test_a_wall_is_off_by_what_its_own_depth_pushes(left, stiffness, shift):
    """epsilon = delta + F_n(a_e + epsilon)/k, to the right; solved by Brent's method. The secant leaves its second order."""
    depth, side = 0.5e-3, -1.0 if left else 1.0

    def off(x):  # of the place, positive into the wall
        return side * shift + mean_force(arc_of(depth + x), left) / stiffness - x

    into = brentq(off, -0.2e-3, 0.2e-3, xtol=1e-15)
    bend = side * into - shift
    assert pushed(depth, shift, stiffness, left=left) == pytest.approx([bend, bend], rel=2e-4, abs=1e-12)


@pytest.mark.parametrize("left", [False, True])
def test_a_shift_moves_the_wall_by_one_over_one_plus_k_c_over_k(left):
    """The arc follows the tip: not 1 - k_c/k, which is (k_c/k)^2 beside it, and not 1."""
    depth, stiffness, small = 0.5e-3, 8e5 if left else 3e6, 1e-7
    ends = [pushed(depth, d, stiffness, left=left)[0] for d in (-small, small)]
    gain = 1.0 + (ends[1] - ends[0]) / (2.0 * small)
    here = depth + (-1.0 if left else 1.0) * pushed(depth, 0.0, stiffness, left=left)[0]
    step = 1e-7
    k_c = -(mean_force(arc_of(here + step), left) - mean_force(arc_of(here - step), left)) / (2.0 * step)
    assert abs(k_c / stiffness) > 0.015
    assert gain == pytest.approx(1.0 / (1.0 + k_c / stiffness), abs=0.1 * (k_c / stiffness) ** 2)
    assert abs(gain - (1.0 - k_c / stiffness)) > 0.8 * (k_c / stiffness) ** 2


def test_limits_of_a_stiff_tool_and_of_a_force_that_knows_no_depth():
    """k to infinity: nothing; k_c = 0 (radial edge force at half immersion): the shift that takes the error away is the error."""
    assert np.abs(pushed(0.5e-3, 0.0, 1e15)).max() < 1e-12
    radial = EdgeCoefficients(0.0, 0.0, 0.0, 0.0, 26.6e3, 0.0)
    error = pushed(R, 0.0, 1e7, given=radial)[0]
    assert error == pytest.approx(-N * DEPTH * 26.6e3 / (2.0 * math.pi) / 1e7, rel=1e-5)
    assert -error + pushed(R, -error, 1e7, given=radial)[0] == pytest.approx(0.0, abs=1e-3 * UM)


def test_error_scales_with_force_and_compliance():
    more = EdgeCoefficients(*(3.0 * one for one in K))
    assert pushed(0.5e-3, 0.0, 3e7, given=more) == pytest.approx(pushed(0.5e-3, 0.0, 1e7), rel=1e-12)


def test_one_tooth_after_the_other_leaves_a_wall_that_is_off_alike_at_all_heights():
    """An axial depth of one pitch (2 pi R / (N tan helix)): the edge in the arc is the same at all times, its force is the mean."""
    axial = 2.0 * math.pi * R / N
    each = pushed(0.5e-3, 0.0, 1e7, averaged=False, helix=math.radians(45.0), axial=axial)
    assert each[1] - each[0] < 1e-3 * UM
    assert each == pytest.approx(pushed(0.5e-3, 0.0, 1e7, axial=axial), rel=1e-6)
    short = pushed(0.5e-3, 0.0, 1e7, averaged=False, helix=math.radians(45.0), axial=0.25 * axial)
    assert short[1] == pytest.approx(
        0.0, abs=0.06 * abs(short[0])
    )  # the last height (of 20) is left with nothing in the cut
    assert short[0] < -1.0 * UM


def test_arcs_that_end_at_the_tool_s_own_walls_go_with_it():
    patches, out = np.array([[0.0, math.pi, 0.0, 1e-3], [1.0, 1.0, 0.0, 0.0], [0.5, 2.0, 0.0, 1e-3]]), np.zeros((3, 4))
    moved_arcs(patches, 1e-4, R, out)
    assert out[:2].tolist() == patches[:2].tolist()
    assert np.cos(out[2, :2]) == pytest.approx(np.cos(patches[2, :2]) - 1e-4 / R, abs=1e-12)
