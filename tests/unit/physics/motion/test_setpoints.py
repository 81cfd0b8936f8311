"""Commands that bring the tool point to a place, against the forward kinematics of the same chain."""

import numpy as np
import pytest

from cutwise.maths import chains, frames
from cutwise.physics.motion.setpoints import Beyond, DependentAxesError, beyond, setpoints
from cutwise.physics.motion.volumetric import Axes

TIP = np.array([0.02, -0.03, -0.12])


def five_axis(directions=((1, 0, 0), (0.1, 1, 0), (0, 0.2, 1))) -> Axes:
    """C and A in the table, three oblique linear axes, one of them a table with its own sense."""
    rng = np.random.default_rng(3)
    axes = [(0, 0, 1), (1, 0, 0), *directions]
    rotations = frames.exp_twists(rng.normal(size=(5, 6)))[0]
    chain = chains.chain([2, 2, 1, 1, 1], axes, rng.normal(size=(5, 3)), rotations=rotations, sides=[-1, -1, -1, 1, 1])
    ones = np.ones(5)
    return Axes(chain, np.array([-1.0, 1, -1, 1, 1]), np.ones(5, bool), (None,) * 5, -ones, ones)


def test_the_tool_point_arrives_where_it_is_wanted():
    axes, rng = five_axis(), np.random.default_rng(0)
    places, rotary = rng.normal(size=(50, 3)), np.zeros((50, 5))
    rotary[:, :2] = rng.uniform(-3, 3, (50, 2))
    commands = setpoints(axes, TIP, places, rotary)
    reached = chains.tool_point(chains.frames(axes.chain, commands * axes.sense), TIP)
    np.testing.assert_allclose(reached, places, atol=1e-13)
    np.testing.assert_array_equal(commands[:, :2], rotary[:, :2])


def test_parallel_axes_are_refused():
    with pytest.raises(DependentAxesError, match="do not span space"):
        setpoints(five_axis(((1, 0, 0), (1, 0, 0), (0, 0, 1)))._replace(
            chain=chains.chain([2, 2, 1, 1, 1], [(0, 0, 1), (1, 0, 0), (1, 0, 0), (1, 0, 0), (0, 0, 1)], np.zeros((5, 3)))
        ), TIP, np.zeros((1, 3)), np.zeros((1, 5)))  # fmt: skip


def test_the_command_farthest_outside_of_each_axis_is_found():
    commands = np.zeros((3, 5))
    commands[1, 2], commands[2, 2], commands[0, 4] = 1.5, -2.5, 1.0
    assert beyond(five_axis(), commands) == [Beyond(2, 2, -2.5)]
