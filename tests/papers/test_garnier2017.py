"""Garnier, Subrin, Waiyagan 2017: the cutting part with its misprints, and worked numbers of the repaired form.

Reference numbers: computed by two independent programs from the corrected equations (lips through the axis, zones
0 and 1), given to the digits below; not measured values.
"""

import math

import numpy as np
import pytest

from cutwise.physics.cutting.drill import DrillPoint, ZoneLaw, lip_force, rotating_force, shares, stress_at_feed
from cutwise.physics.cutting.drill_elements import (
    conventional_rake,
    element_edges,
    elements_force,
    oblique_elements,
    simple_elements,
)
from cutwise.physics.cutting.drill_formulas import half_specific_force, shaw_oxford, tungaloy

MPA = 1e6


def drill(diameter: float) -> DrillPoint:
    scale = diameter / 6e-3
    return DrillPoint(diameter / 2, 0.5e-3 * scale, 0.45e-3 * scale, math.radians(59), math.radians(30), 4e-4, 3e-3)


def law(friction: float, rake: float = 15.0) -> ZoneLaw:
    return ZoneLaw(friction, math.radians(rake), 1.3, 0.3, math.radians(-50), 0.5 * MPA)


MATERIALS = {"Al": (650 * MPA, 0.25, 0.60), "Ti": (1400 * MPA, 0.23, 0.55), "steel": (2000 * MPA, 0.25, 0.60)}
FULL_CONTACT = [  # material, D, f [mm]; k_c [N/mm2], thrust lips, chisel [N], torque lips, chisel [N mm]
    ("Al", 6, 0.1, 1428.57964, 87.5726733, 76.3216934, 625.003593, 9.586958),
    ("Ti", 6, 0.06, 3249.26446, 102.698711, 104.154935, 852.931921, 13.083161),
    ("steel", 10, 0.3, 3339.95628, 1023.70527, 892.183788, 12176.9239, 186.782379),
    ("steel", 10, 0.2, 3696.26923, 755.277406, 658.242445, 8983.98771, 137.805788),
]


@pytest.mark.parametrize(("material", "d", "f", "kc", "t_lip", "t_chisel", "m_lip", "m_chisel"), FULL_CONTACT)
def test_full_contact_table(material, d, f, kc, t_lip, t_chisel, m_lip, m_chisel):
    kc11, exponent, friction = MATERIALS[material]
    point = drill(d * 1e-3)
    stress = stress_at_feed(law(friction), kc11, exponent, point, f * 1e-3)
    got = shares(point, stress, f * 1e-3)
    assert stress.specific / MPA == pytest.approx(kc, rel=1e-8)
    assert got == pytest.approx((t_lip, t_chisel, m_lip * 1e-3, m_chisel * 1e-3), rel=1e-7)


def aluminium(rake: float = 15.0):
    return stress_at_feed(law(0.60, rake), 650 * MPA, 0.25, drill(6e-3), 1e-4)


def test_zone_stresses_of_the_aluminium_case():
    stress = aluminium()
    expected = (1274.132767, 764.479660, 766.956638, 1780.788729, 408.660821)
    got = (stress.normal, stress.friction, stress.tangential_chisel, stress.normal_chisel, stress.normal_lip)
    assert np.array(got) / MPA == pytest.approx(expected, rel=1e-8)
    assert stress.tangential_lip == pytest.approx(stress.specific, rel=1e-12)


def test_one_degree_of_rake_moves_lip_thrust_by_six_percent():
    """At unchanged K_n, K_f: thrust of the lips is a small difference of large terms."""
    point = drill(6e-3)
    edges = element_edges(point, 400)
    elements = simple_elements(point, law(0.60), 1428.57964 * MPA, np.full(edges.size - 1, math.radians(16)), 400)
    assert 2 * elements_force(elements, 1e-4, point.chisel_radius, point.radius).thrust == pytest.approx(
        82.216579, rel=1e-7
    )


def test_eq2_as_printed_is_no_rotation():
    """Misprint: determinant of the printed matrix is cos 2p, and its sign of sin p would push the lips outward."""
    p = math.radians(31)
    printed = np.array([[math.cos(p), 0, math.sin(p)], [0, 1, 0], [math.sin(p), 0, math.cos(p)]])
    assert np.linalg.det(printed) == pytest.approx(math.cos(2 * p))
    assert np.linalg.det(printed) == pytest.approx(0.469, abs=1e-3)
    rotation = printed.copy()
    rotation[2, 0] *= -1
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    stress = aluminium()
    # one element in the frame before Eq. (2): z = feed, x = outward; then Eq. (2) with the corrected matrix
    in_lip_frame = np.array([0.0, -stress.tangential_lip, -stress.normal_lip])
    on_tool = rotation @ in_lip_frame
    assert on_tool[0] < 0.0  # inward
    assert on_tool[2] == pytest.approx(-stress.normal_lip * math.cos(p))  # against the feed
    point = drill(6e-3)
    force = lip_force(point, stress, 1e-4, point.chisel_radius, point.radius)
    assert on_tool[0] / on_tool[2] == pytest.approx(force.inward / force.thrust)


def test_rake_turns_about_the_lip():
    """Misprint: R_3 is said to come from R_2 by a turn about z_2; the matrix printed in Eq. (2) turns about x_2."""
    g = math.radians(15)
    printed = np.array([[1, 0, 0], [0, math.cos(g), math.sin(g)], [0, -math.sin(g), math.cos(g)]])
    assert printed @ [1, 0, 0] == pytest.approx([1, 0, 0])
    stress = aluminium()
    turned = printed @ [0.0, -stress.normal, -stress.friction]
    assert turned == pytest.approx([0.0, -stress.tangential_lip, -stress.normal_lip])
    about_z = np.array([[math.cos(g), -math.sin(g), 0], [math.sin(g), math.cos(g), 0], [0, 0, 1]])
    assert (about_z @ [0.0, -stress.normal, -stress.friction])[2] != pytest.approx(-stress.normal_lip, rel=0.1)


def test_eq5_as_printed_has_a_section_too_large():
    """Misprint: (R - r_a) f_z / cos p; width (R - r_a)/cos p times thickness f_z cos p is (R - r_a) f_z."""
    p, point, stress = math.radians(31), drill(6e-3), aluminium()
    printed = 2 * stress.normal_lip * math.cos(p) * (point.radius - point.chisel_radius) / math.cos(p) * 0.5e-4
    assert shares(point, stress, 1e-4)[0] == pytest.approx(87.57, abs=5e-3)
    assert printed == pytest.approx(102.2, abs=5e-2)
    assert printed / shares(point, stress, 1e-4)[0] == pytest.approx(1.167, abs=5e-4)


def test_eq4_as_printed_lacks_the_second_lip():
    """Misprint: F_a = 2 F_z is printed equal to one F_z."""
    point, stress = drill(6e-3), aluminium()
    one_lip = lip_force(point, stress, 1e-4, point.chisel_radius, point.radius)
    assert shares(point, stress, 1e-4)[0] == pytest.approx(2 * one_lip.thrust)


def test_conventional_rake_along_the_lip():
    got = np.degrees(conventional_rake(drill(6e-3), np.array([0.5e-3, 1e-3, 2e-3, 3e-3])))
    assert got == pytest.approx([-43.806, -2.606, 17.993, 30.620], abs=5e-4)


def test_oblique_element_table():
    point, stress = drill(6e-3), aluminium()
    elements = oblique_elements(point, law(0.60), stress.specific, 20_000)
    lips = elements_force(elements, 1e-4, point.chisel_radius, point.radius)
    whole = elements_force(elements, 1e-4, 0.0, point.radius)
    assert (2 * lips.thrust, 2e3 * lips.torque) == pytest.approx((18.313651, 577.215551), rel=1e-6)
    assert (2 * whole.thrust, 2e3 * whole.torque) == pytest.approx((94.635345, 586.802509), rel=1e-6)


def test_oblique_element_without_web_offset_is_the_simple_one():
    point = drill(6e-3)._replace(web_offset=0.0)
    rake = np.full(element_edges(point, 80).size - 1, math.radians(15))
    oblique = oblique_elements(point, law(0.60), aluminium().specific, 80, rake)
    simple = simple_elements(point, law(0.60), aluminium().specific, rake, 80)
    for name in ("thrust", "tangential", "inward"):
        assert getattr(oblique, name) == pytest.approx(getattr(simple, name), rel=1e-12)


@pytest.mark.parametrize(
    ("kc", "d", "f", "thrust", "torque"),
    [(1428.57964, 6, 0.1, 183.680, 0.642861), (3249.26446, 6, 0.06, 250.665, 0.877301),
     (3339.95628, 10, 0.3, 2147.176, 12.52484)],
)  # fmt: skip
def test_half_specific_force_formula(kc, d, f, thrust, torque):
    got = half_specific_force(kc * MPA, d * 1e-3, f * 1e-3, math.radians(59))
    assert got == pytest.approx((thrust, torque), rel=2e-6)


def test_shaw_oxford_and_its_inch_trap():
    got = shaw_oxford(200.0, 10e-3, 0.3e-3)
    assert got == pytest.approx((3791.83, 14.9916), rel=2e-6)
    in_millimetres = 0.195 * 9.81 * 200 * 0.3**0.8 * 10**0.8  # constants in inches, lengths in mm: 3.65 times too small
    assert got.thrust > 2.5 * in_millimetres


@pytest.mark.parametrize(
    ("factor", "d", "f", "thrust", "torque"),
    [(1.0, 6, 0.1, 483, 0.83), (1.01, 10, 0.2, 1466, 4.04), (2.10, 10, 0.2, 3048, 8.40), (2.10, 10, 0.3, 4302, 11.93)],
)
def test_tungaloy_table(factor, d, f, thrust, torque):
    got = tungaloy(factor, d * 1e-3, f * 1e-3)
    assert got == pytest.approx((thrust, torque), rel=6e-3)  # the table prints three figures


def test_model_lies_between_ten_and_eighteen_percent_below_the_thinned_point_formula():
    for material, d, f, *_ in FULL_CONTACT[:3]:
        kc11, exponent, friction = MATERIALS[material]
        point = drill(d * 1e-3)
        stress = stress_at_feed(law(friction), kc11, exponent, point, f * 1e-3)
        formula = half_specific_force(stress.specific, d * 1e-3, f * 1e-3, point.half_point_angle)
        got = shares(point, stress, f * 1e-3)
        assert 0.10 < 1 - (got[0] + got[1]) / formula.thrust < 0.18
        assert got[2] + got[3] == pytest.approx(formula.torque, rel=0.015)


@pytest.mark.parametrize(("material", "f", "expected"), [("Al", 0.1, 19.69553), ("Ti", 0.06, 41.43007)])
def test_rotating_force_of_a_lip_height_error(material, f, expected):
    kc11, exponent, friction = MATERIALS[material]
    stress = stress_at_feed(law(friction), kc11, exponent, drill(6e-3), f * 1e-3)
    assert rotating_force(drill(6e-3), stress, 1e-5) == pytest.approx(expected, rel=1e-6)
