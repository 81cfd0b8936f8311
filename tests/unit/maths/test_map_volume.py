"""What is told of the error of a volume: the true error lies within it, and it falls with the cells."""

import math

import numpy as np
import pytest

from cutwise.maths import profiles
from cutwise.maths.map_index import index_of
from cutwise.maths.map_volume import volume_error
from cutwise.maths.workpiece import alone
from peers.maps import MM, block, lines, separate, swept, tool

BLOCK = (-20, 20), (-20, 20), (-10, 0)
R, LONG, DEEP = 5.0, 16.0, 3.0


def plunge(x, y, _):
    return profiles.flat(R * MM), lines((x, y, 5), (x, y, -6)), math.pi * R**2 * 6


def along(x, y, angle):
    c, s = 0.5 * LONG * math.cos(angle), 0.5 * LONG * math.sin(angle)
    return lines((x - c, y - s, -DEEP), (x + c, y + s, -DEEP))


def slot(*place):
    return profiles.flat(R * MM), along(*place), DEEP * (math.pi * R**2 + 2 * R * LONG)


def groove(*place):
    section = R**2 * math.acos(1 - DEEP / R) - (R - DEEP) * math.sqrt(DEEP * (2 * R - DEEP))
    return profiles.ball(R * MM), along(*place), section * LONG + math.pi * DEEP**2 * (R - DEEP / 3)


@pytest.mark.parametrize("shape", [plunge, slot, groove])
def test_the_true_error_lies_within_what_is_told_and_both_fall(shape):
    """Walls along cells, at 45 degrees (every row of cells misses as much) and askew."""
    draw, told, true = np.random.default_rng(7), {}, {}
    places = [
        (*draw.uniform(-1, 1, 2), angle) for angle in (0.0, math.pi / 4, math.pi / 2, *draw.uniform(0, math.pi, 3))
    ]
    for grid in (1.25, 0.625, 0.3125):
        told[grid], true[grid] = [], []
        for place in places:
            pieces, path, volume = shape(*place)
            solid, found = swept(block(*BLOCK, grid), path, tool(pieces))
            error = volume_error(alone(solid), index_of(solid))
            told[grid].append(1e9 * error.of_all)
            true[grid].append(abs(found.sum() - volume))
            assert true[grid][-1] <= told[grid][-1]
            assert abs(found.sum() + 1e9 * error.whole[0] - volume) <= 3e9 * error.whole[1]  # corrected by the points
    assert np.mean(told[1.25]) < 6 * np.mean(true[1.25]) + 1.0
    assert np.mean(told[0.3125]) < 0.4 * np.mean(told[1.25])


def test_moves_have_errors_of_their_own_and_their_shifts_add_up():
    path = separate(((-9, 0.3, -2), (9, 0.3, -2)), ((0.1, -9, -3), (0.1, 9, -3)), ((-9, 0.3, -2), (9, 0.3, -2)))
    solid, _ = swept(block(*BLOCK, 0.7), path, tool(profiles.flat(2.1 * MM)))
    error = volume_error(alone(solid), index_of(solid))
    assert error.shift.sum() == pytest.approx(error.whole[0], rel=1e-9)
    assert error.of_moves[2] == 0.0  # a repeated move takes nothing
    assert (error.of_moves[:2] > 0.0).all()
    first = 2.0 * (18 * 4.2 + math.pi * 2.1**2)
    _, alone_ = swept(block(*BLOCK, 0.7), separate(((-9, 0.3, -2), (9, 0.3, -2))), tool(profiles.flat(2.1 * MM)))
    assert abs(alone_[0] - first) <= 1e9 * error.of_moves[0]
