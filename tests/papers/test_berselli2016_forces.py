"""Berselli et al. 2016, Eqs. (1)-(11): the force integrals and arcs, printed and corrected."""

import math

import numpy as np
import pytest
import sympy as sp

from cutwise.physics.cutting.flute import EdgeCoefficients, Mill, mean_force, tooth_force
from cutwise.physics.engagement.arc import immersion_half_angle, layer_arcs
from cutwise.physics.engagement.feed import feed_direction
from peers.flute import sliced_force, trochoid_forces

PAPER = EdgeCoefficients(2.0e9, 1.2e9, 0.8e9, 0.0, 0.0, 0.0)
MILL = Mill(4e-3, 20, math.radians(20.0))


def _symbols():
    return sp.symbols("c k K_tc K_rc K_ac K_te K_re K_ae phi theta", real=True)


def _integrand(theta):
    c, _, ktc, krc, kac, kte, kre, kae, phi, _ = _symbols()
    h = c * sp.sin(phi - theta)
    ft, fr, fa = ktc * h + kte, krc * h + kre, kac * h + kae
    return -ft * sp.cos(phi) - fr * sp.sin(phi), ft * sp.sin(phi) - fr * sp.cos(phi), fa


def test_eq6_fx_and_fz_are_antiderivatives():
    c, k, ktc, krc, kac, kte, kre, kae, phi, _ = _symbols()
    fx = c / (4 * k) * (-ktc * sp.cos(2 * phi) + krc * (2 * phi - sp.sin(2 * phi)))
    fx += (kte * sp.sin(phi) - kre * sp.cos(phi)) / k
    fz = (kac * c * sp.cos(phi) - kae * phi) / k
    dx, _, dz = _integrand(0)
    assert sp.simplify(-k * sp.diff(fx, phi) - dx) == 0  # d phi = -k_beta dz, where the paper prints -k_beta z
    assert sp.simplify(-k * sp.diff(fz, phi) - dz) == 0


def test_eq6_fy_as_printed_has_the_wrong_sign_of_k_tc():
    """Misprint: the printed F_y line is off by -2 K_tc c sin^2 phi per unit height; +K_tc(2 phi - sin 2 phi) is right."""
    c, k, ktc, krc, _, kte, kre, _, phi, _ = _symbols()
    edge = (kte * sp.cos(phi) + kre * sp.sin(phi)) / k
    wave = 2 * phi - sp.sin(2 * phi)
    printed = -c / (4 * k) * (-ktc * wave + krc * sp.cos(2 * phi)) + edge
    corrected = -c / (4 * k) * (ktc * wave + krc * sp.cos(2 * phi)) + edge
    dy = _integrand(0)[1]
    assert sp.simplify(-k * sp.diff(printed, phi) - dy + 2 * ktc * c * sp.sin(phi) ** 2) == 0
    assert sp.simplify(-k * sp.diff(corrected, phi) - dy) == 0


def test_eq10_as_printed_repeats_fx_and_drops_the_edge_terms():
    """Misprint: the printed F_y line is the F_x line; the sliced integral of Eqs. (3)-(5), (9) says otherwise."""
    c, k, ktc, krc, _, kte, kre, kae, phi, theta = _symbols()
    dx, dy, _ = _integrand(theta)
    shear_x = ktc * (-phi * sp.sin(theta) / 2 - sp.cos(2 * phi - theta) / 4)
    shear_x += krc * (phi * sp.cos(theta) / 2 - sp.sin(2 * phi - theta) / 4)
    printed_fx = printed_fy = c / k * shear_x
    fy = (
        c
        / k
        * (
            -ktc * (phi * sp.cos(theta) / 2 - sp.sin(2 * phi - theta) / 4)
            - krc * (phi * sp.sin(theta) / 2 + sp.cos(2 * phi - theta) / 4)
        )
    )
    edges = {kte: 0, kre: 0, kae: 0}
    assert sp.simplify(-k * sp.diff(printed_fx, phi) - dx.subs(edges)) == 0
    assert sp.simplify(-k * sp.diff(printed_fx, phi) - dx) != 0  # the edge terms are gone
    assert sp.simplify(-k * sp.diff(printed_fy, phi) - dy.subs(edges)) != 0
    corrected = fy + (kte * sp.cos(phi) + kre * sp.sin(phi)) / k
    assert sp.simplify(-k * sp.diff(corrected, phi) - dy) == 0


@pytest.mark.parametrize("seed", range(12))
def test_closed_form_against_the_sliced_integral(seed):
    """Random mills, arcs of every wrap, feed directions and edge terms; a wave of the midpoint rule is 1e-4 here."""
    rng = np.random.default_rng(seed)
    helix = [0.0, 1e-6, 5.0, 20.0, 45.0, -30.0][seed % 6]
    mill = Mill(rng.uniform(1e-3, 10e-3), int(rng.integers(1, 21)), math.radians(helix))
    k = EdgeCoefficients(*rng.uniform(1e8, 3e9, 3), *rng.uniform(0.0, 5e3, 3))
    theta = rng.uniform(-0.6, 0.6)
    arcs = layer_arcs(rng.uniform(0.01, 2.4) * mill.radius, 0.0, theta, mill.radius)
    width = rng.uniform(0.5e-3, 20e-3)
    args = (rng.uniform(-20.0, 20.0), arcs.front_lo, arcs.front_hi, 6e-6, theta, 1e-3, 1e-3 + width, mill)
    closed = tooth_force(*args, k)
    sliced = sliced_force(*args, k, 40_000)
    scale = max(np.abs(sliced).max(), 1e-3 * k.K_tc * 6e-6 * width)
    assert np.abs(np.array(closed[:3]) - sliced).max() < 1e-3 * scale


def test_boundary_algorithm_as_printed_calls_a_flute_out_of_cut_that_cuts():
    """Misprint: line 3 asks phi_j(a) < phi_ex; it must be phi_st, or a flute inside the arc at both ends is cut short."""
    start, exit_angle, lag = math.radians(100.0), math.radians(190.0), math.tan(MILL.helix) / MILL.radius
    foot = math.radians(150.0)
    height = 2e-3
    top = foot - lag * height
    assert start < top < exit_angle
    printed_z2 = (foot - start) / lag  # line 3 as printed overrides z_2 = a
    assert printed_z2 > height
    one = Mill(MILL.radius, 1, MILL.helix)
    truth = tooth_force(foot, start, exit_angle, 6e-6, 0.0, 0.0, height, one, PAPER)
    wrong = tooth_force(foot, start, exit_angle, 6e-6, 0.0, 0.0, printed_z2, one, PAPER)
    assert wrong.y > 1.5 * truth.y


def _printed_eq11(depth, burr, theta, radius):
    """Arcs exactly as the paper prints them."""
    work = max(0.0, depth - burr)
    entry = math.pi - immersion_half_angle(depth, radius)
    inner = math.pi - immersion_half_angle(work, radius)
    return (entry, inner if depth > burr else math.pi + theta), (inner, math.pi + theta)


def test_eq11_as_printed_holds_only_within_the_work_arc():
    depth, burr = 1.01e-3, 1e-3
    delta_p = immersion_half_angle(depth - burr, MILL.radius)
    assert delta_p == pytest.approx(0.071, abs=5e-4)
    for theta in (-0.9 * delta_p, 0.0, 0.9 * delta_p):
        (_, exit_burr), (_, exit_work) = _printed_eq11(depth, burr, theta, MILL.radius)
        arcs = layer_arcs(depth, depth - burr, theta, MILL.radius)
        assert (arcs.front_hi, arcs.work_hi) == pytest.approx((exit_burr, exit_work))
        assert arcs.back_hi <= arcs.back_lo
    steep = -1.5 * delta_p
    (_, exit_burr), (entry_work, exit_work) = _printed_eq11(depth, burr, steep, MILL.radius)
    arcs = layer_arcs(depth, depth - burr, steep, MILL.radius)
    assert exit_work < entry_work  # a negative arc
    assert arcs.work_hi <= arcs.work_lo
    assert arcs.front_hi == pytest.approx(math.pi + steep)
    assert exit_burr > arcs.front_hi  # burr where the tool has already lifted off


def test_eq11_second_burr_arc_behind_a_plunging_tool():
    arcs = layer_arcs(1.01e-3, 0.01e-3, 0.3, MILL.radius)
    assert arcs.back_lo == pytest.approx(math.pi + immersion_half_angle(0.01e-3, MILL.radius))
    assert arcs.back_hi == pytest.approx(math.pi + 0.3)


@pytest.mark.parametrize(
    ("depth", "work", "theta", "tolerance"),
    [(1e-3, 0.0, 0.0, 0.006), (1e-3, 0.05e-3, 0.0, 0.006), (1e-3, 0.05e-3, 0.3, 0.01), (1e-3, 0.05e-3, -0.3, 0.01),
     (2e-3, 0.3e-3, 0.6, 0.02), (1e-3, 0.0, -0.5, 0.02), (5e-3, 1e-3, 0.2, 0.01)],
)  # fmt: skip
def test_corrected_arcs_against_an_exact_trochoid(depth, work, theta, tolerance):
    """The corrected arcs leave out V/(omega R) only: 0.5 % straight, at most 2 % at 0.6 rad; printed Eq. 11: up to 29 %."""
    omega, speed = 4188.79, 0.08
    velocity = (speed * math.cos(theta), -speed * math.sin(theta))
    assert feed_direction(*velocity) == pytest.approx(theta)
    chip = 2 * math.pi * speed / (MILL.flutes * omega)
    exact = trochoid_forces(depth, work, velocity, omega, MILL, 1e-3, PAPER)
    arcs = layer_arcs(depth, work, theta, MILL.radius)
    pieces = (
        ((arcs.front_lo, arcs.front_hi), (arcs.back_lo, arcs.back_hi)),
        ((arcs.work_lo, arcs.work_hi),),
    )
    for part, (layer, reference) in enumerate(zip(pieces, exact, strict=True)):
        force = sum(np.array(mean_force(lo, hi, chip, theta, 1e-3, MILL.flutes, PAPER)[:3]) for lo, hi in layer)
        assert np.abs(force - reference).max() <= tolerance * np.abs(exact).max(), part


def test_eq8_counts_revolutions_per_second():
    """Misprint: after Eq. (9) the paper writes c = x_F'; it is x_F'/(N n), n in revolutions per second."""
    from cutwise.physics.engagement.feed import feed_per_tooth

    assert feed_per_tooth(0.08, 0.0, 40_000 * 2 * math.pi / 60, 20) == pytest.approx(0.006e-3)
