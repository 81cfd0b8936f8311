"""Orders of convergence of the averaged loop, of the envelope, and of the sliced reference itself."""

import math

import numpy as np

from cutwise.maths.curves import constant
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill, tooth_force
from cutwise.physics.surface.edge import machined_profile
from cutwise.process.deburring import _profile_points
from cutwise.process.loops import run_compliant_edge
from peers.cells import end_error, r0
from peers.flute import sliced_force


def slope(steps, errors):
    return np.polyfit(np.log(steps), np.log(np.abs(errors)), 1)[0]


def test_averaged_loop_is_of_first_order():
    steps = np.array([80e-6, 40e-6, 20e-6, 10e-6])
    errors = np.array([end_error(time_step=dt) for dt in steps]) + 0.009452
    assert 0.9 < slope(steps, errors) < 1.2


def test_default_step_is_within_a_tenth_of_a_micrometre():
    assert abs(end_error(time_step=20e-6) + 0.009452) < 1e-4


def test_sliced_integral_converges_to_the_closed_form():
    """The ends of the slices are cut off inside an element: first order, wavering."""
    mill = Mill(4e-3, 20, math.radians(20.0))
    k = EdgeCoefficients(2.0e9, 1.2e9, 0.8e9, 1e3, 1e3, 1e2)
    args = (0.123, 2.3, 3.3, 6e-6, 0.1, 0.0, 10e-3, mill)
    exact = np.array(tooth_force(*args, k)[:3])
    slices = np.array([200, 800, 3200, 12800, 51200])
    errors = [np.abs(sliced_force(*args, k, n) - exact).max() for n in slices]
    assert slope(1.0 / slices, errors) > 0.8
    assert errors[-1] < 1e-3


def test_sliced_integral_is_of_second_order_where_every_slice_cuts():
    mill = Mill(4e-3, 1, math.radians(20.0))
    k = EdgeCoefficients(2.0e9, 1.2e9, 0.8e9, 1e3, 1e3, 1e2)
    args = (2.9, 2.0, 3.1, 6e-6, 0.1, 0.0, 5e-3, mill)
    exact = np.array(tooth_force(*args, k)[:3])
    slices = np.array([4, 8, 16, 32])
    errors = [np.abs(sliced_force(*args, k, n) - exact).max() for n in slices]
    assert 1.9 < slope(1.0 / slices, errors) < 2.1


def test_envelope_of_a_sine_differs_from_the_lowest_point_as_the_slope_squared():
    """h = y - R theta^2 / 2 at slope theta, to second order in the pitch of the axis."""
    x = np.linspace(0.0, 80e-3, 40_001)
    wave = 0.2e-3 * np.sin(2 * math.pi * x / 40e-3)
    surface = machined_profile(x, wave + 4e-3, 4e-3, constant(1e-3), points=4000)
    inside = (surface.position > 8e-3) & (surface.position < 72e-3)
    lowest = np.interp(surface.position, x, wave)
    steepest = 0.2e-3 * 2 * math.pi / 40e-3
    largest = (lowest - surface.error)[inside].max()
    assert abs(largest - 0.5 * 4e-3 * steepest**2) < 0.05 * largest  # 2 um at 0.2 mm and 2 Hz


def test_profile_points_do_not_matter():
    cell = r0()
    history = run_compliant_edge(cell, 50e-6)
    arm = cell.reach - 0.5e-3
    x = history.motion.position + arm * history.response.tilt[:, 0]
    y = history.motion.height + arm * history.response.tilt[:, 1] + 4e-3
    means = []
    for points in (_profile_points(np.column_stack([x, y])), 20_000):
        s = machined_profile(x, y, 4e-3, cell.layers.burr_height, points=points)
        means.append(s.error[(s.position > x[-3000]) & (s.position < x[-1])].mean())
    assert abs(means[0] - means[1]) < 1e-9
