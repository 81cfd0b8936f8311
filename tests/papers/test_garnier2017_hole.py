"""The worked example behind Garnier et al. 2017: entry and exit, arm, postures, coupled cycle.

The paper's excerpt stops before its results; the numbers are those of two independent reference programs that agree
with each other, with their tolerances. They are computed, not measured.
"""

import math

import numpy as np
import pytest

from cutwise.maths.chains import frames, tool_point
from cutwise.physics.cutting.drill import rotating_force, stress_at_feed
from cutwise.physics.structure.joint_compliance import axis_tilt, holding_ratio
from cutwise.physics.surface.hole import perpendicularity, whirl_amplitudes
from cutwise.process.drill_profile import no_elements, turn_mean
from cutwise.process.loops_drilling import drill_hole, modes
from cutwise.process.posture_search import PoseTarget, axial_compliance, scan, search, skating
from peers.robots import DOWN, HOLE, MATERIALS, MICRO, MPA, POINT, POSTURES, arm, compliance, cycle, dynamics, kuka, law

ENTRY = [  # inclination [deg], depth [mm], thrust [N], torque [N mm], F_x, F_y, ripple [N]
    (0, 0.25, 63.510, 6.639, 0, 0, 0),
    (0, 0.50, 87.956, 41.191, 0, 0, 0),
    (0, 1.00, 117.105, 189.576, 0, 0, 0),
    (0, 1.50, 146.254, 436.883, 0, 0, 0),
    (0, 2.00, 163.894, 634.827, 0, 0, 0),
    (0, 3.00, 163.894, 636.027, 0, 0, 0),
    (0, 5.50, 75.938, 596.999, 0, 0, 0),
    (0, 6.50, 17.640, 201.308, 0, 0, 0),
    (5, 0.50, 88.270, 42.807, 1.296, 8.795, 8.985),
    (5, 1.50, 147.196, 451.424, 3.887, 26.384, 26.956),
    (10, 0.50, 89.299, 48.345, 2.749, 18.657, 19.727),
    (10, 1.00, 119.790, 218.190, 5.498, 37.314, 39.454),
    (10, 1.50, 146.657, 453.828, 6.252, 42.438, 51.582),
    (10, 2.00, 160.103, 591.087, 1.970, 13.373, 17.285),
    (10, 5.50, 74.596, 589.846, -2.749, -18.657, 19.727),
    (10, 6.50, 17.237, 184.362, -6.252, -42.438, 51.582),
    (15, 0.50, 91.374, 60.707, 4.605, 31.254, 35.295),
    (15, 1.00, 123.939, 267.621, 9.208, 62.501, 70.470),
    (15, 1.50, 144.690, 440.246, 7.548, 51.234, 64.273),
    (15, 5.50, 72.521, 577.483, -4.605, -31.254, 35.295),
]


def at_depth(inclination: float, depth: float, azimuths: int):
    kc11, exponent, friction, feed, _ = MATERIALS["Al"]
    stress = stress_at_feed(law(friction), kc11, exponent, POINT, feed)
    slope = math.radians(inclination)
    return turn_mean(POINT, stress, no_elements(), 0.5 * MPA, feed, depth * 1e-3, 5e-3, slope, azimuths)


@pytest.mark.parametrize(("inclination", "depth", "thrust", "torque", "fx", "fy", "ripple"), ENTRY)
def test_entry_and_breakthrough(inclination, depth, thrust, torque, fx, fy, ripple):
    got = at_depth(inclination, depth, 7200)
    assert got.thrust == pytest.approx(thrust, rel=2e-5)
    assert got.torque * 1e3 == pytest.approx(torque, rel=2e-4)  # the table prints three decimals of 6.6
    assert got.lateral_x == pytest.approx(fx, abs=1e-3)
    assert got.lateral_y == pytest.approx(fy, abs=1e-3)
    assert got.ripple == pytest.approx(ripple, abs=2e-3)


@pytest.mark.parametrize(("inclination", "depth", "thrust", "torque", "fx", "fy", "ripple"), ENTRY)
def test_the_azimuths_of_a_run_are_enough(inclination, depth, thrust, torque, fx, fy, ripple):
    got = at_depth(inclination, depth, 360)
    assert (got.thrust, got.torque * 1e3) == pytest.approx((thrust, torque), rel=5e-3)
    assert (got.lateral_x, got.lateral_y) == pytest.approx((fx, fy), abs=5e-3 * max(math.hypot(fx, fy), 1.0))
    assert got.ripple == pytest.approx(ripple, rel=1e-2)


def test_margin_torque_in_full():
    """The worked example says +1.8 N mm in full; its own formula and its table (596.999 at 5.5 mm) give 3.6."""
    assert at_depth(0, 4.9, 2).torque * 1e3 - 634.5905511 == pytest.approx(2 * 0.5 * 0.4 * 3 * 3.0, abs=1e-4)
    assert at_depth(0, 5.5, 2).torque * 1e3 == pytest.approx(596.999, abs=1e-3)


def test_forward_kinematics():
    given = arm()
    at = frames(given.chain, np.radians([10, -60, 80, 20, -50, 30]))
    assert tool_point(at, given.tool_tip) == pytest.approx(
        [2.5102789955774565, -0.5266975754065757, 1.2555494362207147], abs=1e-14
    )
    expected = [
        [0.8828041672744681, -0.2751902661604429, 0.3806929466819389],
        [0.1103822497466204, -0.6662094565316903, -0.737550485708351],
        [0.4565879555832674, 0.693134386276063, -0.5577563638166739],
    ]
    assert at.rotations[-1] @ given.tool_rotation == pytest.approx(np.array(expected), abs=1e-14)
    assert frames(kuka(), np.zeros(6)).origins[-1] == pytest.approx([2.94, 0, 0.634])


BLOCKS = {  # translation block in tool axes [um/N]: xx, xy, yy, xz, yz, zz
    "stiffest": (0.7687361, 0.4759867, 0.7533179, -0.2707685, 0.0050863, 0.7125453),
    "least skating": (0.5537500, 0.3732987, 1.3572386, -0.0769025, -0.1349680, 0.7689228),
}


@pytest.mark.parametrize("posture", BLOCKS)
def test_compliance_block(posture):
    c = compliance(posture) / MICRO
    got = (c[0, 0], c[0, 1], c[1, 1], c[0, 2], c[1, 2], c[2, 2])
    assert got == pytest.approx(BLOCKS[posture], abs=1e-7)


@pytest.mark.parametrize(("posture", "x", "y"), [("stiffest", -0.3731, 0.1008), ("least skating", 0.3013, 1.2655)])
def test_compliance_to_the_drill_torque(posture, x, y):
    assert compliance(posture)[:2, 5] / MICRO == pytest.approx([x, y], abs=6e-5)


def on_grid(step: float):
    angles = np.radians(np.arange(-180, 180 + step, step))
    return angles, scan(arm(), PoseTarget(HOLE, DOWN), angles)


def test_postures_on_the_grid():
    angles, found = on_grid(2.0)
    assert angles.size == 181
    assert found.within.sum() == 532
    wanted = {
        "stiffest": (np.nanargmin(found.compliance), -138, 0.712545, 0.696161),
        "least skating": (np.nanargmin(found.skating), 26, 0.768923, 0.115890),
        "worst": (np.nanargmax(found.compliance), -4, 1.674750, 1.613908),
    }
    for name, (place, angle, axial, ratio) in wanted.items():
        m, branch = divmod(int(place), 8)
        assert np.degrees(angles[m]) == pytest.approx(angle)
        assert found.compliance[m, branch] / MICRO == pytest.approx(axial, abs=1e-6)
        assert found.skating[m, branch] == pytest.approx(ratio, abs=1e-6)
        flips = found.q[m, [branch, branch ^ 1]]
        assert min(np.degrees(np.abs(q - POSTURES[name])).max() for q in flips) < 1e-6


def test_front_branch_on_one_degree():
    _, found = on_grid(1.0)
    front = found.within & (np.abs(found.q[..., 0]) < math.pi / 2)
    assert front.any(axis=1).sum() == 261
    axial, ratio = found.compliance[front] / MICRO, found.skating[front]
    assert (axial.min(), axial.max()) == pytest.approx((0.71205, 1.17555), abs=1e-5)
    assert (ratio.min(), ratio.max()) == pytest.approx((0.11348, 1.33659), abs=1e-5)
    assert np.nanmax(found.compliance) / MICRO == pytest.approx(1.67998, abs=1e-5)


@pytest.mark.parametrize(
    ("score", "angle", "axial", "ratio"),
    [(axial_compliance, -139.425, 0.711852, 0.7246), (skating, 24.594, 0.770486, 0.112498)],
)
def test_continuous_search(score, angle, axial, ratio):
    got = search(arm(), PoseTarget(HOLE, DOWN), score)
    assert np.degrees(got.angle) == pytest.approx(angle, abs=6e-4)
    assert got.compliance[2, 2] / MICRO == pytest.approx(axial, abs=1e-6)
    assert got.skating == pytest.approx(ratio, abs=5e-5)


def test_the_tie_of_the_wrist_flips_is_broken_by_the_smaller_turn():
    got = search(arm(), PoseTarget(HOLE, DOWN), skating)
    assert abs(got.q[3]) + abs(got.q[5]) < math.pi / 2
    assert np.degrees(np.abs(got.q - POSTURES["least skating"])).max() < 2.5


@pytest.mark.parametrize(
    ("posture", "frequencies", "tilt"),
    [("stiffest", (11.3885, 15.2414, 28.6561), 0.0919), ("least skating", (10.4894, 15.1116, 20.4034), 0.1627)],
)
def test_modes_and_drill_tilt(posture, frequencies, tilt):
    assert modes(dynamics(posture)) == pytest.approx(frequencies, abs=1e-4)
    assert axis_tilt(compliance(posture), 163.86) * 1e3 == pytest.approx(tilt, abs=1e-4)


CYCLES = [  # thrust [N], axial, lateral [um], feed min, max [mm], entry, exit [um], perpendicularity [mrad]
    ("Al", "stiffest", 163.843, -108.709, 27.203, 0.08591, 0.12259, 19.333, 21.783, 0.4994),
    ("Al", "least skating", 163.888, -123.787, 4.750, 0.08574, 0.12889, 1.0208, 2.8308, 0.3620),
    ("Al", "worst", 163.704, -257.91, 63.097, 0.06780, 0.14587, 53.903, 54.301, 0.1140),
    ("Ti", "stiffest", 206.757, -137.155, 34.245, 0.05000, 0.07913, 24.297, 27.322, 0.6190),
    ("Ti", "least skating", 206.816, -156.216, 6.036, 0.04896, 0.08458, 1.3442, 3.6043, 0.4521),
    ("Ti", "worst", 206.388, -324.694, 79.261, 0.04230, 0.09982, 67.445, 67.981, 0.1484),
]


@pytest.mark.parametrize(
    ("material", "posture", "thrust", "axial", "lateral", "low", "high", "entry", "leaving", "tilt"), CYCLES
)
def test_coupled_cycle(material, posture, thrust, axial, lateral, low, high, entry, leaving, tilt):
    given, profile = cycle(material)
    got, _ = drill_hole(given, dynamics(posture), profile, step=5e-5)
    assert got.thrust_mean == pytest.approx(thrust, rel=1e-5)
    assert (got.axial_mean / MICRO, got.lateral_mean / MICRO) == pytest.approx((axial, lateral), rel=1e-4)
    assert (got.feed_min * 1e3, got.feed_max * 1e3) == pytest.approx((low, high), rel=1e-3)
    assert np.hypot(*got.entry) / MICRO == pytest.approx(entry, rel=1e-3)
    assert np.hypot(*got.exit) / MICRO == pytest.approx(leaving, rel=1e-3)
    assert perpendicularity(got.entry, got.exit, 5e-3) * 1e3 == pytest.approx(tilt, rel=2e-3)


@pytest.mark.parametrize(
    ("posture", "axial", "lateral", "thrust", "force", "rest"),
    [("stiffest", 109.37, 28.25, 163.90, 41.05, -8.544), ("least skating", 123.86, 6.688, 163.92, 16.66, -0.320)],
)
def test_extremes_of_the_cycle(posture, axial, lateral, thrust, force, rest):
    given, profile = cycle("Al")
    got, _ = drill_hole(given, dynamics(posture), profile, step=2.5e-5)
    assert (got.axial_max / MICRO, got.lateral_max / MICRO) == pytest.approx((axial, lateral), rel=2e-4)
    assert (got.thrust_max, got.lateral_force_max) == pytest.approx((thrust, force), rel=2e-4)
    assert got.rest / MICRO == pytest.approx(rest, rel=3e-3)
    assert got.time == pytest.approx(2.0605, abs=1e-4)


def test_exit_taken_where_the_tip_passes_mixes_two_lengths():
    """An earlier form took the exit at z = thickness and divided by the thickness: 0.657 instead of 0.499 mrad."""
    given, profile = cycle("Al")
    got, _ = drill_hole(given, dynamics("stiffest"), profile, step=2.5e-5)
    assert perpendicularity(got.entry, got.exit_tip, 5e-3) * 1e3 == pytest.approx(0.6573, rel=1e-3)
    assert perpendicularity(got.entry, got.exit, 5e-3) * 1e3 == pytest.approx(0.4994, rel=1e-3)


def test_drill_torque_on_the_arm():
    given, profile = cycle("Al")
    got, _ = drill_hole(given, dynamics("stiffest", with_torque=True), profile, step=2.5e-5)
    assert np.hypot(*got.entry) / MICRO == pytest.approx(19.57, rel=1e-3)


@pytest.mark.parametrize(
    ("material", "posture", "expected"),
    [("Al", "stiffest", 0.33335), ("Ti", "stiffest", 141.780), ("Al", "least skating", 0.20054),
     ("Ti", "least skating", 75.103), ("Al", "worst", 0.35503), ("Ti", "worst", 155.689)],
)  # fmt: skip
def test_circularity_estimate(material, posture, expected):
    kc11, exponent, friction, feed, rpm = MATERIALS[material]
    force = rotating_force(POINT, stress_at_feed(law(friction), kc11, exponent, POINT, feed), 1e-5)
    a1, a2 = whirl_amplitudes(compliance(posture)[:2, :2], force, 150.0, 0.05, rpm * 2 * math.pi / 60)
    assert abs(a1 - a2) / MICRO == pytest.approx(expected, rel=3e-5)


def test_skating_ratio_differs_from_stiffness():
    assert np.hypot(*holding_ratio(compliance("stiffest"))) == pytest.approx(0.696161, abs=1e-6)
    assert np.hypot(*holding_ratio(compliance("least skating"))) == pytest.approx(0.115890, abs=1e-6)
