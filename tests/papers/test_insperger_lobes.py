"""Stability of the Insperger one- and two-mode benchmark: 922 Hz, 0.011, 0.03993 kg, two straight teeth, 600/200 N/mm².

Reference limits: Chebyshev collocation in the cut with exact free flight, six digits, computed by an independent
program; published charts carry no readable numbers.
"""

import math

import numpy as np
import pytest

from cutwise.physics.cutting.flute import EdgeCoefficients
from cutwise.physics.cutting.stability import Milling, Tip, _spectral_radius, arc_of, limit_depth, multipliers
from cutwise.physics.structure.modes import free_motion, modes
from cutwise.process.loops_regenerative import SteadyCut, growth_per_tooth, run_regenerative

RPM = math.pi / 30
ONE = modes([922 * 2 * math.pi], [0.011], [1.34005e6], [[1.0, 0.0]])
TWO = modes([922 * 2 * math.pi] * 2, [0.011] * 2, [1.34005e6] * 2, [[1.0, 0.0], [0.0, 1.0]])
METAL = EdgeCoefficients(600e6, 200e6, 0.0, 0.0, 0.0, 0.0)

LIMITS = [  # rpm, immersion, milling, limit depth [mm]
    *((n, 1.0, "up", d) for n, d in ((5000, 0.4086), (6000, 0.3532), (7000, 1.152), (8000, 0.6764), (9000, 3.0092),
                                     (10000, 0.3224), (12000, 2.1493), (14000, 2.140), (18000, 0.6895))),
    *((n, 0.1, "down", d) for n, d in ((5000, 1.2963), (6000, 1.7329), (7000, 2.9878), (8000, 1.2204), (9000, 2.4411),
                                       (10000, 2.5184), (12000, 0.943), (14000, 6.026), (18000, 0.8157))),
    *((n, 0.05, "down", d) for n, d in ((5000, 2.2069), (6000, 3.0713), (7000, 4.8469), (8000, 2.1632), (9000, 4.3165),
                                        (10000, 4.0907), (12000, 1.6805), (14000, 13.000), (18000, 1.2951))),
    *((n, 0.1, "up", d) for n, d in ((5000, 1.0265), (7000, 2.9063), (9000, 6.0737), (12000, 3.1802), (14000, 5.2729),
                                     (18000, 1.8447))),
]  # fmt: skip


def milling(immersion, kind):
    return Milling(2, *arc_of(immersion, kind), METAL.K_tc, METAL.K_rc)


def free(time):
    return free_motion(ONE, time)


@pytest.mark.parametrize(("depth", "mu"), [(0.2e-3, 0.81974), (0.5e-3, 1.07398), (1.0e-3, 1.40647)])
def test_multipliers_of_the_slot_at_5000_rpm(depth, mu):
    found = multipliers(np.array([depth]), 5000 * RPM, milling(1.0, "up"), Tip(*ONE), free)
    assert found[0] == pytest.approx(mu, abs=6e-6)


@pytest.mark.parametrize(("rpm", "immersion", "kind", "depth"), LIMITS)
def test_limit_depths(rpm, immersion, kind, depth):
    deepest = 1.3e-3 * depth
    found = limit_depth(rpm * RPM, milling(immersion, kind), Tip(*ONE), free, deepest)
    assert 1e3 * found == pytest.approx(depth, abs=6e-4 if depth >= 1.0 else 1.1e-4)


@pytest.mark.parametrize(
    ("rpm", "depth"), [(5000, 0.1271), (7000, 0.5665), (9000, 0.9526), (12000, 0.2418), (14000, 1.1657)]
)
def test_two_modes_at_half_immersion(rpm, depth):
    found = limit_depth(rpm * RPM, milling(0.5, "down"), Tip(*TWO), lambda t: free_motion(TWO, t), 1.3e-3 * depth)
    assert 1e3 * found == pytest.approx(depth, abs=1.1e-4)


def test_collocation_converges_beyond_algebraic_order():
    exact = multipliers(np.array([1e-3]), 5000 * RPM, milling(1.0, "up"), Tip(*ONE), free, 60)[0]
    errors = [
        abs(multipliers(np.array([1e-3]), 5000 * RPM, milling(1.0, "up"), Tip(*ONE), free, n)[0] - exact)
        for n in (28, 32, 36, 40)
    ]
    assert errors[-1] < 2e-6
    assert errors[0] / errors[-1] > 1000  # a sixth order would give 8


def test_three_teeth_of_which_one_or_two_cut_agree_with_time_stepping():
    """An arc of 143 degrees under three teeth: two elements a period, modes that are not along the axes."""
    tip = modes([2 * math.pi * 700, 2 * math.pi * 950], [0.03, 0.02], [8e6, 1.1e7], [[1.0, 0.3], [-0.2, 1.0]])
    arc = 2.498
    case = Milling(3, math.pi - arc, math.pi, METAL.K_tc, METAL.K_rc)
    for depth in (1e-3, 4e-3):
        found = multipliers(np.array([depth]), 8000 * RPM, case, Tip(*tip), lambda t: free_motion(tip, t))[0]
        cut = SteadyCut(3, 8000 * RPM, math.pi - arc, math.pi, 1e-4, depth, 0.0, 1, METAL)
        assert growth_per_tooth(cut, tip, 200, 1200) == pytest.approx(found, abs=2e-3)


def test_largest_multiplier_is_that_of_the_whole_matrix():
    matrices = np.random.default_rng(4).standard_normal((5, 90, 90)) / 9.0
    matrices[3] *= 0.0
    matrices[4] = np.diag(np.arange(90.0) % 3)  # a Krylov space of three dimensions

    def apply(x):
        return np.einsum("cij,cj->ci", matrices, x)

    expected = np.abs(np.linalg.eigvals(matrices)).max(axis=1)
    assert _spectral_radius(apply, 5, 90) == pytest.approx(expected, rel=1e-8)


def steady(rpm, immersion, kind, depth, discs=1):
    return SteadyCut(2, rpm * RPM, *arc_of(immersion, kind), 1e-4, depth, 0.0, discs, METAL)


@pytest.mark.parametrize(("rpm", "immersion", "kind", "depth"), LIMITS[::2])
def test_time_stepping_tells_stable_from_unstable(rpm, immersion, kind, depth):
    """4 % on either side of the limit, by growth of small deviations in the loop that also runs the true surface."""
    steps = max(120, round(120 * 922 * 30 / rpm))
    below = growth_per_tooth(steady(rpm, immersion, kind, 0.96e-3 * depth), ONE, 200, steps)
    above = growth_per_tooth(steady(rpm, immersion, kind, 1.04e-3 * depth), ONE, 200, steps)
    assert below < 1.0 < above


def test_growth_converges_to_the_multiplier_with_second_order():
    exact = multipliers(np.array([0.5e-3]), 5000 * RPM, milling(1.0, "up"), Tip(*ONE), free)[0]
    errors = [abs(growth_per_tooth(steady(5000, 1.0, "up", 0.5e-3), ONE, 300, n) - exact) for n in (300, 600, 1200)]
    slope = np.polyfit(np.log([300, 600, 1200]), np.log(errors), 1)[0]
    assert slope < -0.9
    assert errors[-1] < 3e-4


def test_true_surface_bounds_the_vibration_of_an_unstable_cut():
    """Teeth that leave the cut keep chatter finite; a stable cut settles to the same cycle tooth after tooth."""
    wild = run_regenerative(steady(5000, 1.0, "up", 1.0e-3), ONE, 300)
    calm = run_regenerative(steady(5000, 1.0, "up", 0.2e-3), ONE, 300)
    assert not wild.stable
    assert calm.stable
    assert 1e-4 < np.abs(wild.tip[:, 0]).max() < 5e-3
    period = calm.time.size // 300
    last, before = calm.tip[-period:, 0], calm.tip[-2 * period : -period, 0]
    assert np.abs(last - before).max() < 1e-9
    late = wild.tip[-period:, 0] - wild.tip[-2 * period : -period, 0]
    assert np.abs(late).max() > 1e-6


def test_a_stiff_tool_gets_the_force_of_a_rigid_one():
    from cutwise.physics.cutting.discs import discs
    from cutwise.physics.cutting.flute import Mill
    from cutwise.physics.cutting.uneven import even_edges
    from cutwise.physics.cutting.wall import DISCS, tooth_period

    stiff = modes([5e4], [0.5], [1e13], [[1.0, 0.0]])
    mill = Mill(0.01, 3, math.radians(30))
    metal = EdgeCoefficients(767.01e6, 168.8e6, 0.0, 27.7e3, 26.6e3, 0.0)
    cut = SteadyCut(3, 8000 * RPM, math.pi - 2.0, math.pi, 1e-4, 5e-3, math.tan(mill.helix) / mill.radius, 20, metal)
    ours = run_regenerative(cut, stiff, 4, steps=720).force[-720:]
    rigid = tooth_period(
        DISCS, 0.0, 2.0, 1e-4, 5e-3, mill, discs(0.01, mill.helix, 5e-3, 3, 20), even_edges(metal), 720
    )
    assert np.hypot(*ours.T).max() == pytest.approx(np.hypot(rigid[:, 0], rigid[:, 1]).max(), rel=5e-3)
    assert ours.mean(axis=0) == pytest.approx(rigid[:, :2].mean(axis=0), rel=5e-3)


@pytest.mark.parametrize("bad", [(-1.0, 0.1, 1.0), (1.0, 1.0, 1.0), (1.0, 0.1, 0.0)])
def test_impossible_modes_are_refused(bad):
    with pytest.raises(ValueError, match="must be"):
        modes([bad[0]], [bad[1]], [bad[2]], [[1.0, 0.0]])
