"""Where along a path a tool is that runs beside it: exact on lines and arcs, at corners, and beside a later pass."""

import math

import numpy as np
import pytest

from cutwise.maths.linearc import arc, join, line, lines
from cutwise.physics.motion.nearest import nearest_along


@pytest.mark.parametrize("off", [-0.4e-3, 0.0, 0.3e-3])
def test_beside_an_arc_the_angle_is_the_place(off):
    radius = 5e-3
    curve = join([arc((radius, 0.0, 0.0), (0.0, 0.0, 0.0), math.pi)])
    angle = np.linspace(0.0, math.pi, 400)
    points = np.stack([(radius + off) * np.cos(angle), (radius + off) * np.sin(angle), np.zeros_like(angle)], axis=1)
    place, away = nearest_along(curve, points, (radius + off) * angle)
    assert place == pytest.approx(radius * angle, abs=1e-12)
    assert away == pytest.approx(abs(off), abs=1e-12)


def test_a_place_stays_at_a_corner_while_the_tool_passes_round_it():
    curve = lines(np.array([[0.0, 0.0, 0.0], [10e-3, 0.0, 0.0]]), np.array([[10e-3, 0.0, 0.0], [10e-3, 10e-3, 0.0]]))
    angle = np.linspace(-0.5 * math.pi, 0.0, 60)  # a quarter circle of 0.2 mm round the corner, outside of it
    points = np.stack([10e-3 + 0.2e-3 * np.cos(angle), 0.2e-3 * np.sin(angle), np.zeros_like(angle)], axis=1)
    lead = np.stack([np.linspace(0.0, 10e-3, 200), np.full(200, -0.2e-3), np.zeros(200)], axis=1)
    way = np.vstack([lead, points[1:]])
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])
    place, away = nearest_along(curve, way, travelled)
    assert place[200:] == pytest.approx(10e-3, abs=2e-6)
    assert away == pytest.approx(0.2e-3, abs=2e-8)
    assert (np.diff(place) >= 0.0).all()


def test_a_later_pass_close_by_is_not_mistaken():
    """To and fro 0.1 mm apart: a point between them belongs to where the tool is on its way."""
    curve = join(
        [
            line((0.0, 0.0, 0.0), (0.02, 0.0, 0.0)),
            line((0.02, 0.0, 0.0), (0.02, 1e-4, 0.0)),
            line((0.02, 1e-4, 0.0), (0.0, 1e-4, 0.0)),
        ]
    )
    x = np.linspace(0.0, 0.019, 300)
    points = np.stack([x, np.full_like(x, 0.9e-4), np.zeros_like(x)], axis=1)  # nearer to the way back
    place, away = nearest_along(curve, points, x)
    assert place == pytest.approx(x, abs=1e-9)
    assert away == pytest.approx(0.9e-4, abs=1e-12)
