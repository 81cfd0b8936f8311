"""Sato, Sato, Maekawa 2016: edges of a drilled pipe, and a chamfer of constant width along them.

The sections of the paper with numbers are lost; the values are those of an independent program for the same case.
"""

import math

import numpy as np
import pytest
import sympy as sp

from cutwise.io.scenario import load
from cutwise.process.recipes import simulate


@pytest.fixture(scope="module")
def chamfer(examples):
    def run(*overrides):
        return simulate(load(examples / "chamfer_pipe_hole.yaml", list(overrides)))

    return run


def value(result, name):
    return result.measures[name].value


@pytest.fixture(scope="module")
def inner(chamfer):
    return chamfer()


def test_eq12_normal_points_into_the_material():
    """Misprint: N_H = (cos, sin, 0) of the hole points away from its axis, into the pipe wall, not into the air."""
    theta = 0.7
    on_edge = np.array([4.0 * math.cos(theta), 4.0 * math.sin(theta)])
    printed = np.array([math.cos(theta), math.sin(theta)])
    assert np.hypot(*(on_edge + 0.1 * printed)) > 4.0  # outside the hole: in the material
    assert np.hypot(*(on_edge - 0.1 * printed)) < 4.0


def test_wedge_angles_of_the_edges():
    """cos phi = (r/R) cos^2 theta outside, -(r/R_I) cos^2 theta inside, from the normals of the two cylinders."""
    rho, r, theta = sp.symbols("rho r theta", positive=True)
    c, s = sp.cos(theta), sp.sin(theta)
    h = sp.sqrt(rho**2 - r**2 * c**2)
    pipe, hole = sp.Matrix([r * c, 0, h]) / rho, -sp.Matrix([c, s, 0])
    assert sp.simplify(-pipe.dot(hole) - r / rho * c**2) == 0  # wedge angle is 180 degrees minus that of the normals


def test_base_case_inner_edge(inner):
    assert value(inner, "width_min") == pytest.approx(0.3e-3, abs=2e-8)
    assert value(inner, "width_max") == pytest.approx(0.3e-3, abs=2e-8)
    assert value(inner, "rod_clearance_min") == pytest.approx(0.054164e-3, abs=1e-9)
    assert math.degrees(value(inner, "knife_margin_min")) == pytest.approx(1.999, abs=1e-3)
    assert value(inner, "leg_ratio_max") == pytest.approx(1.0100, abs=1e-4)
    assert math.degrees(value(inner, "wedge_angle_max")) == pytest.approx(107.920, abs=1e-3)
    assert value(inner, "setup_sensitivity_z") == pytest.approx(1.484, abs=1e-3)
    assert value(inner, "cycle_time") == pytest.approx(7.78, abs=0.01)
    assert value(inner, "edge_length") / value(inner, "path_length") == pytest.approx(1.546, abs=1e-3)
    assert value(inner, "gouge_max") == 0.0
    assert inner.verdict == "pass"


def test_base_case_outer_edge(chamfer):
    outer = chamfer("part.edges=outer")
    assert value(outer, "width_min") == pytest.approx(0.3e-3, abs=2e-8)
    assert value(outer, "width_max") == pytest.approx(0.3e-3, abs=2e-8)
    assert value(outer, "leg_ratio_max") == pytest.approx(1.0063, abs=1e-4)
    assert math.degrees(value(outer, "wedge_angle_min")) == pytest.approx(74.534, abs=1e-3)
    assert value(outer, "setup_sensitivity_z") == pytest.approx(-1.315, abs=1e-3)
    assert value(outer, "edge_length") / value(outer, "path_length") == pytest.approx(1.426, abs=1e-3)
    assert "rod_clearance_min" not in outer.measures


@pytest.mark.parametrize(
    ("tier", "edge", "low", "high"),
    [("tangent", "outer", 0.297594, 0.299999), ("surface", "outer", 0.299999, 0.300327),
     ("tangent", "inner", 0.299998, 0.302071), ("surface", "inner", 0.299998, 0.300338)],
)  # fmt: skip
def test_tiers(chamfer, tier, edge, low, high):
    result = chamfer(f"chamfer.tier={tier}", f"part.edges={edge}", "setup=null")
    assert value(result, "width_min") == pytest.approx(low * 1e-3, abs=3e-9)
    assert value(result, "width_max") == pytest.approx(high * 1e-3, abs=3e-9)


def test_width_error_is_of_second_order_in_the_points(chamfer):
    errors = []
    for points in (90, 360):
        result = chamfer(f"path.points={points}", "setup=null")
        errors.append(max(abs(value(result, name) - 0.3e-3) for name in ("width_min", "width_max")))
    assert errors == pytest.approx([2.62e-6, 0.163e-6], rel=0.02)
    assert math.log(errors[0] / errors[1]) / math.log(4.0) == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize(
    ("overrides", "reason"),
    [
        (["chamfer.width=0.5 mm", "chamfer.tilt=0 deg"], "rod"),
        (["tool.rod_radius=1.4 mm", "tool.knife_limit_angle=44.5 deg", "chamfer.tilt=0 deg"], "rod"),
        (["tool.knife_limit_angle=45 deg", "chamfer.tilt=0 deg"], "knife"),
        (["tool.ball_radius=4.2 mm", "tool.rod_radius=2 mm"], "hole"),
    ],
)
def test_failure_cases_fail_for_their_reason(chamfer, overrides, reason):
    result = chamfer(*overrides, "setup=null")
    assert result.verdict == "fail"
    assert any(reason in text for text in result.infeasible), result.infeasible


@pytest.mark.parametrize(
    ("overrides", "degrees"), [(["chamfer.width=0.5 mm"], 0.8808), (["tool.knife_limit_angle=45 deg"], 4.3012)]
)
def test_tilt_that_keeps_the_width(chamfer, overrides, degrees):
    result = chamfer(*overrides, "setup=null")
    assert math.degrees(value(result, "tilt")) == pytest.approx(degrees, abs=2e-3)
    assert value(result, "width_max") - value(result, "width_min") < 2e-8


def test_a_plate_gives_a_circle(chamfer):
    """R to infinity: edge angle 90 degrees, all legs alike."""
    plate = chamfer("part.pipe.radius=100 m", "part.edges=outer", "setup=null", "path.points=720")
    assert math.degrees(value(plate, "wedge_angle_min")) == pytest.approx(90.0, abs=0.01)
    assert value(plate, "leg_ratio_max") == pytest.approx(1.0, abs=1e-3)
    legs = 0.3 / math.sqrt(2.0)
    centre = math.sqrt(4.0 - 0.0225) - 0.15
    assert value(plate, "path_length") == pytest.approx(2 * math.pi * (4.0 - centre / math.sqrt(2.0)) * 1e-3, rel=1e-4)
    assert legs < 0.3
