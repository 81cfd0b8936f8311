"""Arcs of a ball's disc between many planes: none is dropped for want of room."""

import math

import numpy as np
import pytest

from cutwise.physics.engagement.ball import arc_room, disc_arcs, leans


def test_twelve_planes_leave_twelve_arcs():
    """A regular polygon whose sides cut the circle: as many arcs as corners (one of them over the angle 0)."""
    n, inside = 12, 0.98
    turn = 2.0 * math.pi * (np.arange(n) + 0.5) / n
    sides = np.column_stack((np.sin(turn), np.cos(turn), np.zeros(n), np.full(n, inside)))
    arcs = np.empty((arc_room(n), 2))
    count = disc_arcs(sides, leans(sides), 1.0, 0.0, arcs)
    assert count in (n, n + 1)
    length = float((arcs[:count, 1] - arcs[:count, 0]).sum())
    assert length == pytest.approx(2.0 * math.pi - n * 2.0 * math.acos(inside), abs=1e-12)
