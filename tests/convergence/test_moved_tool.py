"""A tool that is displaced along its path, as lines between its places: the wall converges by the second order."""

import math

import numpy as np
import pytest

from cutwise.maths import profiles
from cutwise.maths.envelopes import heights_left
from peers.maps import MM, lines, tool

RADIUS, SWING, WAVE = 5.0, 0.02, 40.0


def exact_wall(x):
    """Side of a disc whose centre goes along a sine, by the point of it whose normal leads to x [mm]."""
    t = x.copy()
    for _ in range(50):
        slope = SWING * 2 * math.pi / WAVE * np.cos(2 * math.pi * t / WAVE)
        t = x + RADIUS * slope / np.hypot(1.0, slope)
    slope = SWING * 2 * math.pi / WAVE * np.cos(2 * math.pi * t / WAVE)
    return SWING * np.sin(2 * math.pi * t / WAVE) + RADIUS / np.hypot(1.0, slope)


def wall(poses, x):
    """Side of what lines between so many places in a wave leave, by halving [mm]."""
    at = np.arange(-WAVE, 2 * WAVE + 1e-9, WAVE / poses)
    path = lines(*((a, SWING * math.sin(2 * math.pi * a / WAVE), 0.0) for a in at))
    table = tool(profiles.flat(RADIUS * MM))
    low, high = np.full(x.size, RADIUS - 0.1), np.full(x.size, RADIUS + 0.1)
    for _ in range(30):
        middle = 0.5 * (low + high)
        cut = np.isfinite(heights_left(path, table, MM * x, MM * middle))
        low, high = np.where(cut, middle, low), np.where(cut, high, middle)
    return 0.5 * (low + high)


def test_worked_example_f_the_wall_of_a_displaced_tool():
    x = np.linspace(0.0, WAVE, 801)
    told = {10: 9.79e-4, 20: 2.43e-4, 40: 6.15e-5, 80: 1.54e-5}
    errors = [float(np.abs(wall(poses, x) - exact_wall(x)).max()) for poses in told]
    assert errors == pytest.approx(list(told.values()), rel=0.03)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(np.full(3, 2.0), abs=0.1)
