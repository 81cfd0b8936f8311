"""A shaft on supports against the tables of beams, and its modes against those of slender bars."""

import math

import numpy as np
import pytest

from cutwise.physics.structure.shaft import Support, modes, shaft, yields

L, D, E = 0.4, 0.02, 210e9
BENDING = E * math.pi * D**4 / 64.0
PLAIN = -1.0  # Poisson's ratio at which nothing shears
FIXED, PINNED = Support(0.0, math.inf, math.inf), Support(L, math.inf, 0.0)
HINGED = Support(0.0, math.inf, 0.0)


def beam(supports, z, *, diameter=D, poisson=PLAIN, density=0.0):
    return shaft(np.asarray(z), np.full(len(z) - 1, diameter), E, poisson, density, supports)


@pytest.mark.parametrize("a", [0.05, 0.13, 0.2, 0.37])
def test_beam_tables(a):
    """Young and Budynas, Roark's Formulas, 7th ed., table 8.1: cantilever, two hinges, fixed and hinged."""
    b = L - a
    z = [0.0, a, L]
    assert yields(beam((FIXED,), z), a, 0.0)[:, 1, 1].sum() == pytest.approx(a**3 / (3 * BENDING), rel=1e-10)
    hinged = yields(beam((HINGED, PINNED), z), a, 0.0)[:, 1, 1].sum()
    assert hinged == pytest.approx(a**2 * b**2 / (3 * BENDING * L), rel=1e-10)
    propped = yields(beam((FIXED, PINNED), z), a, 0.0)[:, 1, 1].sum()
    assert propped == pytest.approx(a**3 * b**2 * (3 * L + b) / (12 * BENDING * L**3), rel=1e-10)


def test_shear_adds_what_it_adds_to_a_cantilever():
    nu = 0.3
    shear = L / (0.9 * E / (2 * (1 + nu)) * math.pi * D**2 / 4)
    found = yields(beam((FIXED,), [0.0, 0.1, L], poisson=nu), L, 0.0)[0, 1, 1]
    assert found == pytest.approx(L**3 / (3 * BENDING) + shear, rel=1e-12)


def test_a_feed_force_bends_by_its_moment():
    """Moment F r at the free end: displacement F r L^2 / 2EI there, and r L / EI more slope."""
    c = yields(beam((FIXED,), [0.0, L]), L, 0.012)[0]
    assert c[0, 1] == pytest.approx(0.012 * L**2 / (2 * BENDING), rel=1e-12)
    assert c[0, 0] == pytest.approx(0.012**2 * L / BENDING, rel=1e-12)
    assert c[0, 1] == c[1, 0]


def test_a_step_is_exact_where_a_station_is():
    """Integral of x^2 / EI over both diameters."""
    tip, thick = 0.15, 0.03
    found = shaft(np.array([0.0, L - tip, L]), np.array([thick, D]), E, PLAIN, 0.0, (FIXED,))
    stiff = E * math.pi * thick**4 / 64.0
    expected = (L**3 - tip**3) / (3 * stiff) + tip**3 / (3 * BENDING)
    assert yields(found, L, 0.0)[0, 1, 1] == pytest.approx(expected, rel=1e-10)


def test_more_places_change_nothing():
    held = (Support(0.0, 1e8, 1e6), Support(L, 4e7, 0.0), Support(0.25, 3e7, 0.0))
    few = yields(beam(held, [0.0, 0.1, 0.25, L], poisson=0.3), 0.1, 0.01)
    many = yields(beam(held, np.linspace(0.0, L, 81), poisson=0.3), 0.1, 0.01)
    assert few == pytest.approx(many, rel=1e-8, abs=1e-18)


def test_shares_of_supports_that_statics_gives():
    """On two hinged springs the reactions are b/L and a/L: each gives its square over its stiffness."""
    a, k, q = 0.1, 2e8, 5e7
    parts = yields(beam((Support(0.0, k, 0.0), Support(L, q, 0.0)), [0.0, a, L]), a, 0.0)[:, 1, 1]
    assert parts[1] == pytest.approx(((L - a) / L) ** 2 / k, rel=1e-9)
    assert parts[2] == pytest.approx((a / L) ** 2 / q, rel=1e-9)
    assert parts[0] == pytest.approx(a**2 * (L - a) ** 2 / (3 * BENDING * L), rel=1e-9)


def test_stiff_supports_become_rigid_ones():
    rigid = yields(beam((FIXED, PINNED), [0.0, 0.2, L]), 0.2, 0.01)
    stiff = yields(beam((Support(0.0, 1e15, 1e13), Support(L, 1e15, 0.0)), [0.0, 0.2, L]), 0.2, 0.01)
    assert stiff.sum(axis=0) == pytest.approx(rigid.sum(axis=0), rel=1e-6)
    assert (rigid[1:] == 0.0).all()


def test_every_part_is_symmetric_and_stores_energy():
    held = (Support(0.0, 1e8, 1e5), Support(L, 4e7, 0.0), Support(0.25, 3e7, 0.0))
    for z in (0.05, 0.25, 0.4):
        parts = yields(beam(held, np.unique([0.0, z, 0.25, L]), poisson=0.3), z, 0.01)
        for part in parts:
            assert part == pytest.approx(part.T)
            assert np.linalg.eigvalsh(part).min() > -1e-12 * np.abs(parts).max()


def test_frequencies_of_slender_bars():
    """Hinged: (n pi / L)^2 sqrt(EI / rho A); clamped and free: 1.8751^2."""
    rho, z = 7850.0, np.linspace(0.0, L, 41)
    unit = math.sqrt(BENDING / (rho * math.pi * D**2 / 4)) / L**2
    hinged, shape = modes(beam((HINGED, PINNED), z, density=rho), 0.5 * L, 0.0, 3)
    assert hinged == pytest.approx(unit * (np.pi * np.arange(1, 4)) ** 2, rel=1e-5)
    assert shape[0, 1] ** 2 == pytest.approx(2.0 / (rho * math.pi * D**2 / 4 * L), rel=1e-6)  # modal mass: half
    assert shape[1, 1] == pytest.approx(0.0, abs=1e-6)
    free, _ = modes(beam((FIXED,), z, density=rho), L, 0.0, 1)
    assert free[0] == pytest.approx(unit * 1.875104**2, rel=1e-5)


def test_modes_add_up_to_the_compliance():
    held = (Support(0.0, 1e8, 1e6), Support(L, 4e7, 0.0))
    found = beam(held, np.linspace(0.0, L, 41), density=7850.0)
    omega, shape = modes(found, 0.2, 0.0, 60)
    assert (shape[:, 1] ** 2 / omega**2).sum() == pytest.approx(yields(found, 0.2, 0.0)[:, 1, 1].sum(), rel=1e-6)
