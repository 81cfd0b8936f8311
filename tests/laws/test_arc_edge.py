"""A convex edge that is an arc: worked example 4f of the specification of the cell, and its straight limit."""

import math

import numpy as np
import pytest

from cutwise.paths.carried import arc, line
from cutwise.physics.engagement.arc import immersion_half_angle
from cutwise.physics.engagement.burred_arc import half_angle
from cutwise.process.loops import Arc, axis_over_edge, run_compliant_edge
from peers.cells import MM, r0

UM = 1e-6
RADIUS = 50 * MM


def left(arc_of, time_step=2e-5, duration=None, **changes):
    """Time, edge error [um] and angle [deg] at which the actual axis passes, of R0 along the arc."""
    cell = r0(duration=duration or math.pi * RADIUS / 0.08, **changes)._replace(arc=arc_of)
    history = run_compliant_edge(cell, time_step)
    moved = (0.150 - 0.5 * MM) * history.response.tilt
    along, height = axis_over_edge(cell, history.motion.time, moved[:, 0], moved[:, 1])
    return history.motion.time, height / UM, np.degrees(along / arc_of.radius)


def test_a_tool_that_turns_with_the_edge_leaves_it_even():
    _, error, angle = left(Arc(RADIUS, True))
    assert np.interp([60, 90, 120, 150, 175], angle, error) == pytest.approx(np.full(5, -8.08883), abs=1e-5)
    _, error, angle = left(Arc(RADIUS, True), law=0, duration=1.0)
    assert np.interp([60, 80], angle, error) == pytest.approx(np.full(2, 189.93402), abs=1e-4)


def test_a_tool_that_keeps_its_attitude_jumps_from_piston_to_piston():
    time, error, angle = left(Arc(RADIUS, False))
    found = np.interp([60, 90, 120, 150, 175], angle, error)
    assert found == pytest.approx([366.287, 428.197, 293.255, 435.103, 396.850], abs=2e-3)
    later = error[time > 0.5]
    assert [later.min(), later.max(), later.mean()] == pytest.approx([226.78, 518.13, 372.13], abs=1e-2)
    coarse = np.interp([60, 90], *reversed(left(Arc(RADIUS, False), 4e-5)[1:]))
    assert np.abs(coarse - found[:2]).max() < 1.0, "0.8 um off with twice the step"


def test_straight_limit():
    _, straight, _ = left(Arc(1e5, True), duration=0.6)
    history = run_compliant_edge(r0(), 2e-5)
    expected = (-2 * MM + (0.150 - 0.5 * MM) * history.response.tilt[-1, 1]) / UM
    assert straight[-1] == pytest.approx(expected, abs=1e-4)
    for depth in (0.1, 1.0, 3.9, 7.0):
        assert half_angle(depth * MM, 1e6, 4 * MM) == pytest.approx(immersion_half_angle(depth * MM, 4 * MM), rel=1e-8)


@pytest.mark.parametrize("depth", [1e-6, 0.3e-3, 2e-3, 6e-3, 7.9e-3])
def test_half_angle_is_that_of_two_circles(depth):
    face, mill = 20e-3, 4e-3
    distance = face + mill - depth
    assert math.cos(half_angle(depth, face, mill)) == pytest.approx(
        (distance**2 + mill**2 - face**2) / (2 * distance * mill), abs=1e-12
    )


@pytest.mark.parametrize("on_left", [False, True])
def test_axes_along_an_arc(on_left):
    path = arc([1.0, 2.0, 0.5], 0.1, 0.5 * math.pi, math.pi, [0, 0, -1], 5e-3, work_on_left=on_left)
    outward = (path.point - [1.0, 2.0, 0.5]) / 0.1
    assert path.axes[:, :, 1] == pytest.approx(outward, abs=1e-12), "y points off the work"
    way = np.diff(path.point, axis=0)
    assert (np.einsum("ni,ni->n", way, path.axes[:-1, :, 0]) > 0).all()
    assert np.linalg.det(path.axes) == pytest.approx(np.full(len(path.at), -1.0 if on_left else 1.0))
    straight = line([1.0, 2.1, 0.5], [1.1, 2.1, 0.5], [0, 0, -1], 5e-3)
    if not on_left:
        assert path.axes[0] == pytest.approx(straight.axes[0], abs=1e-12)
