"""Balance and limits of the drilling model."""

import math

import numpy as np
import pytest

from cutwise.maths.chains import frames, jacobian, tool_point
from cutwise.physics.cutting.drill import lip_force, shares, stress_at_feed
from cutwise.physics.cutting.drill_elements import element_edges, elements_force, simple_elements
from cutwise.physics.structure.joint_compliance import (
    cartesian_compliance,
    geometric_stiffness,
    holding_force,
    holding_ratio,
)
from cutwise.process.drill_profile import no_elements, turn_mean
from cutwise.process.drilling_at_rest import quasi_static_hole
from cutwise.process.loops_drilling import HISTORY, arm_dynamics, drill_hole
from cutwise.process.postures import tool_axes
from peers.robots import (
    MATERIALS,
    POINT,
    POSTURES,
    STIFFNESS,
    arm,
    compliance,
    cycle,
    dynamics,
    kuka,
    law,
)


def stress(material: str = "Al"):
    kc11, exponent, friction, feed, _ = MATERIALS[material]
    return stress_at_feed(law(friction), kc11, exponent, POINT, feed)


def test_a_flat_entry_has_no_lateral_force():
    got = turn_mean(POINT, stress(), no_elements(), 0.0, 1e-4, 1e-3, 5e-3, 1e-9, 360)
    assert math.hypot(got.lateral_x, got.lateral_y) < 1e-6 * got.thrust


def test_exit_mirrors_entry():
    """What enters at a depth leaves one thickness later: thrust adds up to the full one, lateral force to nothing."""
    for depth in (0.4e-3, 1.1e-3):
        into = turn_mean(POINT, stress(), no_elements(), 0.0, 1e-4, depth, 5e-3, math.radians(8), 720)
        out = turn_mean(POINT, stress(), no_elements(), 0.0, 1e-4, depth + 5e-3, 5e-3, math.radians(8), 720)
        full = shares(POINT, stress(), 1e-4)
        assert into.thrust + out.thrust == pytest.approx(full[0] + full[1], rel=1e-12)
        assert into.lateral_x == pytest.approx(-out.lateral_x, rel=1e-9)


def test_opposite_slopes_push_opposite_ways():
    up = turn_mean(POINT, stress(), no_elements(), 0.0, 1e-4, 1e-3, 5e-3, math.radians(10), 360)
    down = turn_mean(POINT, stress(), no_elements(), 0.0, 1e-4, 1e-3, 5e-3, math.radians(-10), 360)
    assert (up.lateral_x, up.lateral_y) == pytest.approx((-down.lateral_x, -down.lateral_y), rel=1e-9)
    assert up.thrust == pytest.approx(down.thrust, rel=1e-12)


def test_torque_is_the_power_of_the_tangential_force():
    """M omega = integral of tangential force times speed, summed by hand."""
    radius = np.linspace(0, POINT.radius, 200_001)
    middle = 0.5 * (radius[1:] + radius[:-1])
    q = np.where(middle < POINT.chisel_radius, stress().tangential_chisel, stress().tangential_lip)
    summed = float(np.sum(q * 0.5e-4 * middle * np.diff(radius)))
    assert lip_force(POINT, stress(), 1e-4, 0.0, POINT.radius).torque == pytest.approx(summed, rel=1e-5)


def test_fractional_elements_meet_the_closed_form_at_any_contact():
    edges = element_edges(POINT, 40)
    elements = simple_elements(POINT, law(0.6), stress().specific, np.full(edges.size - 1, math.radians(15)), 40)
    for inner, outer in ((0.0, 0.3e-3), (0.123e-3, 1.777e-3), (0.61e-3, 2.9e-3)):
        got, exact = elements_force(elements, 1e-4, inner, outer), lip_force(POINT, stress(), 1e-4, inner, outer)
        assert got == pytest.approx(exact, rel=1e-12)


def test_forces_scale_with_stress_and_with_the_square_of_length():
    scaled = POINT._replace(radius=6e-3, chisel_radius=1e-3)
    kc11, exponent, friction, feed, _ = MATERIALS["Al"]
    base, twice = shares(POINT, stress(), feed), shares(
        scaled, stress_at_feed(law(friction), 3 * kc11 * 2**exponent, exponent, scaled, 2 * feed), 2 * feed
    )  # fmt: skip
    assert twice[0] / base[0] == pytest.approx(12, rel=1e-12)
    assert twice[2] / base[2] == pytest.approx(24, rel=1e-12)


def test_compliance_stores_the_work_of_the_load():
    """Clapeyron: w C w is the sum over joints of torque squared over stiffness."""
    given, load = arm(), np.array([30.0, -50.0, 160.0, 0.3, -0.2, 0.6])
    j = jacobian(given.chain, POSTURES["stiffest"], given.tool_tip)
    torque = j.T @ load
    assert load @ cartesian_compliance(j, STIFFNESS) @ load == pytest.approx(np.sum(torque**2 / STIFFNESS), rel=1e-12)


def test_geometric_stiffness_is_the_derivative_of_the_joint_torques():
    given, load, q = arm(), np.array([0, 0, 600.0, 0, 0, 1.0]), POSTURES["least skating"]
    got = geometric_stiffness(jacobian(given.chain, q, given.tool_tip), load)
    numeric = np.empty((6, 6))
    for j in range(6):
        step = np.eye(6)[j] * 1e-6
        ahead, behind = (jacobian(given.chain, q + s, given.tool_tip).T @ load for s in (step, -step))
        numeric[:, j] = (ahead - behind) / 2e-6
    assert got == pytest.approx(numeric, abs=1e-6 * np.abs(numeric).max())
    assert not np.allclose(got, got.T, atol=1e-3)  # a moment acts


def test_geometric_stiffness_is_negligible_for_drilling():
    given, load, q = arm(), np.array([0, 0, 600.0, 0, 0, 1.0]), POSTURES["stiffest"]
    j = jacobian(given.chain, q, given.tool_tip)
    softer = j @ np.linalg.inv(np.diag(STIFFNESS) - geometric_stiffness(j, load)) @ j.T
    change = np.linalg.norm(softer - cartesian_compliance(j, STIFFNESS)) / np.linalg.norm(softer)
    assert change < 2e-3


def test_without_a_wall_the_arm_yields_by_its_static_compliance():
    given, profile = cycle("Al", wall=0.0)
    got, _ = drill_hole(given, dynamics("stiffest"), profile, step=5e-5)
    c = compliance("stiffest")
    assert got.axial_mean == pytest.approx(-c[2, 2] * got.thrust_mean, rel=2e-4)
    assert got.lateral_mean == pytest.approx(np.hypot(c[0, 2], c[1, 2]) * got.thrust_mean, rel=1e-3)


def test_the_arm_is_in_balance_at_rest():
    """After the dwell only the wall force is left: K u = F."""
    given, profile = cycle("Al")
    given = given._replace(turns=1.0)  # slow: nothing swings any more in the full cut
    at = dynamics("stiffest")
    _, history = drill_hole(given, at, profile, step=1e-4, every=100)
    last = dict(zip(HISTORY, history[-1], strict=True))
    load = np.array([last["wall_x"], last["wall_y"], -last["thrust"]])
    assert at.stiffness @ [last["x"], last["y"], last["z"]] == pytest.approx(load, abs=1e-3)


@pytest.mark.parametrize("posture", ["stiffest", "least skating"])
def test_the_tip_sticks_up_to_its_skating_ratio(posture):
    """Friction just above the ratio holds the tip at a slow flat entry, friction just below it does not."""
    ratio = float(np.hypot(*holding_ratio(compliance(posture))))
    c, thrust = compliance(posture), 100.0
    assert np.linalg.norm(holding_force(c, thrust, 0.0)) / thrust == pytest.approx(ratio, rel=1e-12)
    given, profile = cycle("Al", wall=5e10)  # a wall so stiff that u = a
    errors = {}
    for factor in (0.9, 1.02):
        entry, _ = quasi_static_hole(given._replace(friction=factor * ratio), dynamics(posture), profile)
        errors[factor] = np.hypot(*entry)
    assert errors[1.02] < 1e-8
    assert errors[0.9] > 1e-7


@pytest.mark.parametrize(("posture", "tolerance"), [("stiffest", 0.002), ("least skating", 0.002), ("worst", 0.004)])
def test_slow_drilling_is_quasi_static(posture, tolerance):
    given, profile = cycle("Al")
    slow, _ = drill_hole(given._replace(turns=5.0), dynamics(posture), profile, step=1e-4)
    entry, leaving = quasi_static_hole(given, dynamics(posture), profile)
    assert np.hypot(*slow.entry) == pytest.approx(np.hypot(*entry), rel=tolerance)
    assert np.hypot(*slow.exit) == pytest.approx(np.hypot(*leaving), rel=tolerance)


def test_a_stiff_arm_drills_where_it_is_told():
    given, profile = cycle("Al")
    stiff = arm_dynamics(compliance("worst") * 1e-4, 150.0, 0.05, with_torque=False)
    got, _ = drill_hole(given, stiff, profile, step=2e-6)
    soft, _ = drill_hole(given, dynamics("worst"), profile)
    assert np.hypot(*got.entry) < 1e-3 * np.hypot(*soft.entry)
    assert got.feed_max == pytest.approx(1e-4, rel=1e-2)


def test_turning_the_slope_with_the_tool_turns_the_error():
    """The same slope seen in axes turned by a quarter: an isotropic arm errs as far, a quarter further on."""
    given, profile = cycle("Al", inclination=math.radians(10))
    isotropic = arm_dynamics(np.eye(6) * 1e-6, 150.0, 0.05, with_torque=False)
    plain, _ = drill_hole(given, isotropic, profile)
    turned, _ = drill_hole(given, isotropic, profile, slope_angle=math.pi / 2)
    assert turned.entry == pytest.approx([-plain.entry[1], plain.entry[0]], rel=1e-9)
    assert np.hypot(*plain.entry) > 1e-6


def test_jacobian_is_the_derivative_of_the_tip():
    given = arm()
    q = POSTURES["worst"]
    j = jacobian(kuka(), q, given.tool_tip)
    for i in range(6):
        step = np.eye(6)[i] * 1e-6
        ahead, behind = (tool_point(frames(kuka(), q + s), given.tool_tip) for s in (step, -step))
        assert (ahead - behind) / 2e-6 == pytest.approx(j[:3, i], abs=2e-9)


def test_tool_axes_are_a_right_handed_frame_round_the_axis():
    poses = tool_axes(np.array([0.3, -0.2, -0.9]), np.linspace(-3, 3, 7))
    assert np.linalg.det(poses) == pytest.approx(np.ones(7))
    assert poses[:, :, 2] == pytest.approx(np.tile(np.array([0.3, -0.2, -0.9]) / math.hypot(0.3, 0.2, 0.9), (7, 1)))
