"""The surface between cells: exact at cusps and walls, and checked against all moves."""

import numpy as np
import pytest

from cutwise.maths import profiles
from cutwise.maths.map_index import index_of, least_height, shaped, shaping_index, surface_check
from cutwise.maths.map_surface import surfaces
from cutwise.maths.solid import CIRCLE, Outline
from peers.maps import MM, block, heights, lines, separate, swept, tool

BALL_A = separate(((-40, -0.5, -1), (40, -0.5, -1)), ((40, 0.5, -1), (-40, 0.5, -1)), ((0, -40, -1), (0, 40, -1)))


@pytest.mark.parametrize("grid", [0.4, 0.17])
def test_worked_example_a_ridge_on_a_coarse_grid(grid):
    solid, _ = swept(block((-20, 20), (-20, 20), (-10, 0), grid), BALL_A, tool(profiles.ball(3 * MM)))
    assert heights(solid, (10, 0))[0] == pytest.approx(-0.958039892, abs=1e-9)
    assert surface_check(solid, 2000).largest == 0.0


def test_scallop_of_a_ball():
    for pitch in (0.3, 1.0):
        ends = [((-20, pitch * k, -1), (20, pitch * k, -1)) for k in range(8)]
        solid, _ = swept(block((-5, 5), (0, 3), (-4, 0), 0.2), separate(*ends), tool(profiles.ball(3 * MM)))
        ridge = heights(solid, (0.3, 2.5 * pitch))[0]
        assert ridge + 1.0 == pytest.approx(3.0 - np.sqrt(9.0 - 0.25 * pitch**2), abs=1e-9)


def test_a_wall_stands_where_the_tool_left_it():
    solid, _ = swept(
        block((-5, 5), (-5, 5), (-4, 0), 0.5), lines((-20, 0, -1), (20, 0, -1)), tool(profiles.flat(2 * MM))
    )
    assert heights(solid, (0.1, 1.9999), (0.1, 2.0001)) == pytest.approx([-1.0, 0.0], abs=1e-12)


def test_outside_of_the_stock_there_is_nothing():
    solid, _ = swept(block((-5, 5), (-5, 5), (-4, 0), 0.5), lines((-20, 0, 1), (20, 0, 1)), tool(profiles.flat(2 * MM)))
    assert heights(solid, (5.001, 0), (0, -5.001), (4.999, 4.999)).tolist() == [-np.inf, -np.inf, 0.0]
    round_ = solid._replace(outline=Outline(CIRCLE, 0.0, 0.0, 5 * MM))
    assert heights(round_, (4.999, 0), (3.6, 3.6)).tolist() == [0.0, -np.inf]


def test_the_surface_is_never_below_the_truth_and_a_missed_strip_is_told():
    """Passes closer than the grid leave strips in which none of them owns a cell."""
    ends = [((-20, 0.11 * k, -1 - 0.05 * (k % 3)), (20, 0.11 * k, -1 - 0.05 * (k % 3))) for k in range(30)]
    solid, _ = swept(block((-5, 5), (-5, 5), (-4, 0), 0.4), separate(*ends), tool(profiles.ball(1.5 * MM)))
    index = index_of(solid)
    draw = np.random.default_rng(1)
    x, y = draw.uniform(-0.005, 0.005, 500), draw.uniform(-0.001, 0.004, 500)
    height, owner = np.empty(500), np.empty(500, np.int64)
    surfaces(solid, x, y, height, owner)
    truth = np.array([least_height(solid, index, a, b) for a, b in zip(x, y, strict=True)])
    assert (height - truth).min() >= 0.0
    assert surface_check(solid, 4000).largest > 1e-7
    shaping = shaping_index(solid)
    by_shape = np.array([shaped(solid, shaping, a, b)[0] for a, b in zip(x, y, strict=True)])
    assert by_shape == pytest.approx(truth, abs=1e-15)  # the index of what shaped it misses no strip
    assert shaping.segment.size < 30 * (shaping.first.size - 1)
