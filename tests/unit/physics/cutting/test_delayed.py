"""Chips from where the tool really was: the quick laws where those hold, run-out, Kienzle, and a tip that swings."""

import math

import numpy as np
import pytest

from cutwise.physics.cutting.discs import discs
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.cutting.uneven import (
    KIENZLE,
    Edges,
    Kienzle,
    even_edges,
    force_per_length,
    tangent_coefficients,
    uneven_tooth_force,
)
from cutwise.physics.cutting.wall import DELAYED, DISCS, tooth_period
from cutwise.physics.motion.driven import SetPoints
from cutwise.physics.motion.drives import Drive
from cutwise.physics.structure.modes import modes
from cutwise.process.loops_drives import Cut, run_drives, tip_dynamics
from cutwise.process.loops_regenerative import SteadyCut, run_regenerative
from peers import corner as peer
from peers.corner import AL7075, OMEGA, X, Y, laws

MILL = Mill(0.01, 3, math.radians(30))
METAL = even_edges(AL7075)
ALUMINIUM = Kienzle(800e6, 0.25, 240e6, 0.3, 100e6, 0.2)
LAWS = {
    "run-out": METAL._replace(runout=15e-6, runout_angle=0.4),
    "Kienzle": Edges(KIENZLE, AL7075, ALUMINIUM, 0.0, 0.0),
    "both": Edges(KIENZLE, AL7075, ALUMINIUM, 20e-6, -1.0),
}


@pytest.mark.parametrize("arc", [0.6, 2.2])
def test_without_anything_special_it_is_the_sum_over_discs(arc):
    sliced = discs(0.01, MILL.helix, 5e-3, 3, 20)
    periods = [tooth_period(law, 0.0, arc, 1e-4, 5e-3, MILL, sliced, METAL, 90) for law in (DELAYED, DISCS)]
    np.testing.assert_allclose(periods[0], periods[1], atol=1e-9)


@pytest.mark.parametrize("edges", LAWS.values(), ids=LAWS)
def test_many_discs_are_the_flute_by_quadrature(edges):
    """The deburring kernel has the same force law in closed arcs, with the same sense of run-out.

    Where run-out takes an edge out of the cut its edge force jumps, which the quadrature smears over a panel.
    """
    arc, chip, positions = 1.8, 1e-4, 40
    sliced = discs(0.01, MILL.helix, 5e-3, 3, 4000)
    found = tooth_period(DELAYED, 0.0, arc, chip, 5e-3, MILL, sliced, edges, positions)
    assert len(found) == (3 * positions if edges.runout else positions)
    expected = []
    for i in range(len(found)):
        rotation = 0.5 * math.pi + 2.0 * math.pi * i / (3 * positions)
        f = uneven_tooth_force(rotation, math.pi - arc, math.pi, chip, 0.0, 0.0, 5e-3, MILL, edges)
        expected.append((f.x, f.y, -f.z))
    missed = np.abs(found - np.array(expected)) / np.abs(expected).max()
    assert np.sqrt((missed**2).mean()) < 3e-3
    assert np.median(missed) < 2e-4


def test_tangent_coefficients_touch_the_law():
    edges, h = LAWS["Kienzle"], 40e-6
    k = tangent_coefficients(edges, h)
    for place, (slope, edge) in enumerate(zip(k[:3], k[3:], strict=True)):
        at = [force_per_length(edges, h + d)[place] for d in (-1e-9, 0.0, 1e-9)]
        assert slope * h + edge == pytest.approx(at[1], rel=1e-12)
        assert slope == pytest.approx((at[2] - at[0]) / 2e-9, rel=1e-6)
    assert tangent_coefficients(METAL, h) is METAL.linear


def test_rigid_corner_with_true_chips_is_the_corner_with_chips_from_the_speed():
    """A tooth period of 2.5 ms of motion lies between the two chips: they differ while the feed changes, by little."""
    quick, true = peer.run(2e-3, law=DISCS), peer.run(2e-3, law=DELAYED)
    assert true["max"] == pytest.approx(quick["max"], abs=0.02)
    assert true["peak"] == pytest.approx(quick["peak"], rel=0.01)


STIFF = modes([2 * math.pi * 4000] * 2, [0.1] * 2, [1e12] * 2, [[1, 0], [0, 1]])
SOFT = modes([2 * math.pi * 900, 2 * math.pi * 1100], [0.04, 0.05], [2.5e7, 3e7], [[1, 0], [0, 1]])


def test_a_stiff_tip_is_a_rigid_one():
    rigid, stiff = peer.run(2e-3, law=DELAYED), peer.run(2e-3, law=DELAYED, modes=STIFF)
    assert stiff["max"] == pytest.approx(rigid["max"], abs=0.01)
    assert stiff["history"].tip[:, 2].max() < 2e-9


def straight(tip, *, arc=1.2, seconds=0.6, substeps=10, chip_speed=0.04, edges=METAL):
    """A steady cut along +x in the loop: drives without friction that follow a ramp without a lag worth naming."""
    n = round(seconds / 1e-3)
    t = np.arange(n) * 1e-3
    point = np.column_stack([chip_speed * t, np.zeros(n)])
    velocity = np.tile([chip_speed, 0.0], (n, 1))
    patches = np.tile([0.0, arc, 0.0, 5e-3], (n, 1, 1))
    heavy = [p._replace(inertia=1e3 * p.inertia, viscous=0.0) for p in (
        X._replace(stiction_plus=0.0, stiction_minus=0.0, coulomb_plus=0.0, coulomb_minus=0.0),
        Y._replace(stiction_plus=0.0, stiction_minus=0.0, coulomb_plus=0.0, coulomb_minus=0.0),
    )]  # fmt: skip
    x, y = (law._replace(proportional=1e8, integral=0.0, derivative=1e6, saturation=1e9) for law in laws("matched"))
    order = SetPoints(point, velocity, np.zeros((n, 2)), np.zeros(n), np.zeros(n))
    cut = Cut(DELAYED, MILL, discs(0.01, MILL.helix, 5e-3, 3, 20), edges, OMEGA)
    return run_drives(order, patches, (Drive(heavy[0], x), Drive(heavy[1], y)), cut, substeps, modes=tip)


def steady(tip, arc, periods=200):
    case = SteadyCut(3, OMEGA, math.pi - arc, math.pi, 1e-4, 5e-3, math.tan(MILL.helix) / 0.01, 20, AL7075)
    return run_regenerative(case, tip, periods)


def test_a_steady_cut_swings_as_the_loop_with_the_recorded_surface():
    """Two codes for one thing: chips from a ring of positions here, from a surface on angular stations there."""
    ours, peer_tip = straight(SOFT), steady(SOFT, 1.2).tip
    late = peer_tip[-len(peer_tip) // 4 :]
    swing = ours.tip[400:]
    assert swing[:, 2].max() == pytest.approx(np.hypot(*late.T).max(), rel=0.01)
    assert swing[:, :2].mean(axis=0) == pytest.approx(late.mean(axis=0), rel=0.02)


def test_mean_deflection_is_mean_force_over_stiffness():
    ours = straight(SOFT)
    force = ours.force[200:].mean(axis=0)[:2]
    assert ours.tip[200:, :2].mean(axis=0) == pytest.approx(force / np.array([2.5e7, 3e7]), rel=5e-3)


def test_the_wall_is_left_where_a_tooth_passes_it():
    """A straight-fluted mill leaves the wall once a tooth: its displacement then is the one of the recorded surface."""
    arc, mill = 1.2, MILL._replace(helix=0.0)
    case = SteadyCut(3, OMEGA, math.pi - arc, math.pi, 1e-4, 5e-3, 0.0, 20, AL7075)
    recorded = run_regenerative(case, SOFT, 200, steps=2000)
    # flutes stand at multiples of the pitch from +y at the start of each period; the exit at 180 degrees comes midway
    exit_step = 198 * 2000 + round((0.5 % (1 / 3)) * 3 * 2000)
    expected = -recorded.tip[exit_step, 1]
    n = 400
    point = np.column_stack([0.04e-3 * np.arange(n), np.zeros(n)])
    order = SetPoints(point, np.tile([0.04, 0.0], (n, 1)), np.zeros((n, 2)), np.zeros(n), np.zeros(n))
    patches = np.tile([0.0, arc, 0.0, 5e-3], (n, 1, 1))
    plants = [p._replace(inertia=10.0, viscous=0.0, stiction_plus=0.0, stiction_minus=0.0, coulomb_plus=0.0,
                         coulomb_minus=0.0) for p in (X, Y)]  # fmt: skip
    x, y = (law._replace(proportional=1e8, integral=0.0, derivative=1e6, saturation=1e9) for law in laws("matched"))
    cut = Cut(DELAYED, mill, discs(0.01, 0.0, 5e-3, 3, 20), METAL, OMEGA)
    ours = run_drives(order, patches, (Drive(plants[0], x), Drive(plants[1], y)), cut, 40, modes=SOFT)
    assert not np.isfinite(ours.left[:, 2:]).any()  # the arc begins at the wall on the right: none stands on the left
    left = ours.left[200:, :2]
    left = left[np.isfinite(left[:, 0])]
    assert left.mean() == pytest.approx(expected, rel=0.03)
    assert np.ptp(left) < 0.05 * abs(expected)


def test_chatter_grows_in_the_loop_where_the_steady_cut_says_so():
    weak = modes([2 * math.pi * 900], [0.01], [1.2e6], [[0.0, 1.0]])
    assert steady(weak, 1.2).growth > 1.0
    assert steady(SOFT, 1.2).growth < 1.0
    wild, calm = straight(weak).tip[:, 2], straight(SOFT).tip[:, 2]
    assert wild[-100:].max() > 20 * calm[-100:].max()
    assert calm[-100:].max() == pytest.approx(calm[300:400].max(), rel=0.02)


@pytest.mark.slow
def test_tip_converges_with_the_step():
    """Micro steps halve with the substeps; the greatest swing then moves by less than a percent, and by less again."""
    swings = [straight(SOFT, substeps=n).tip[400:, 2].max() for n in (10, 20, 40)]
    assert abs(swings[1] - swings[0]) < 0.01 * swings[0]
    assert abs(swings[2] - swings[1]) < abs(swings[1] - swings[0])


def test_micro_steps_resolve_the_quickest_mode():
    cut = Cut(DELAYED, MILL, discs(0.01, MILL.helix, 5e-3, 3, 20), METAL, OMEGA)
    tip = tip_dynamics(SOFT, cut, 1e-3, 10)
    assert 1e-4 / tip.micro <= 1.0 / (60 * 1100)
    assert tip.delay[0] * 1e-4 / tip.micro == pytest.approx(2 * math.pi / (3 * OMEGA))


def test_modes_need_the_law_that_sees_them():
    with pytest.raises(ValueError, match="DELAYED"):
        peer.run(2e-3, law=DISCS, modes=SOFT)
