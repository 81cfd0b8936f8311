"""What a tool meets where it turns follows from what it met at the end of its move before."""

import math

import numpy as np
import pytest

from cutwise.maths import profiles
from cutwise.maths.workpiece import alone
from cutwise.physics.engagement.contact_sums import angle_of_contact, removal
from cutwise.physics.engagement.map_contact import Edge, contact_rows
from cutwise.physics.engagement.map_fan import fan_room
from cutwise.physics.engagement.map_rim import Place
from cutwise.physics.engagement.map_turn import goes_on, turned_rows
from peers.maps import MM, before, block, lines, tool

LITTLE = 1e-6  # [m] along the second move, where the material is asked
SHAPES = {
    "flat": profiles.flat(4 * MM),
    "ball": profiles.ball(4 * MM),
    "bull": profiles.bull_nose(4 * MM, 1.5 * MM),
    "taper": profiles.taper(4 * MM, 1 * MM, math.radians(30)),
}


def edge_of(pieces) -> Edge:
    radius = max(piece[2] for piece in pieces)
    return Edge(profiles.meridian(pieces, 0.0, 12), radius, profiles.cylinder_foot(pieces), math.inf)


def place_on(a, b, share, segment, ahead=0.0) -> Place:
    step = b - a
    flat = math.hypot(step[0], step[1])
    x, y, z = a + share * step + ahead * step / np.linalg.norm(step)
    return Place(x, y, z, step[0] / flat, step[1] / flat, step[2] / flat, segment, segment, share, segment)


def turned(pieces, points):
    """Removal and angle at the start of the last move: from the end of the move before, and of the material just behind it."""
    path, points, edge = lines(*points), MM * np.array(points, float), edge_of(pieces)
    last = len(points) - 2
    rows, other, fan = np.zeros((500, 5)), np.zeros((500, 5)), fan_room()
    raw = block((-20, 20), (-20, 20), (-12, 0), 0.2)
    end = place_on(points[-3], points[-2], 1.0, last - 1)
    count = contact_rows(alone(before(raw, path, tool(pieces), last - 1)), end, edge, fan, rows, True)
    raw = block((-20, 20), (-20, 20), (-12, 0), 0.2)
    left, asked = alone(before(raw, path, tool(pieces), last)), []
    for ahead in (LITTLE, 4 * LITTLE):
        start = place_on(points[-2], points[-1], 0.0, last, ahead)
        n = contact_rows(left, start, edge, fan, other, True)
        depth = other[:n, 4] - other[:n, 3]
        deep = other[:n][(other[:n, 0] >= 0) | (depth > 4 * LITTLE)]  # not a floor that falls behind it
        took = 1e6 * removal(deep, len(deep), edge, start.slope)
        asked.append(np.array([took, angle_of_contact(deep, len(deep), edge)]))
    start = place_on(points[-2], points[-1], 0.0, last)
    assert goes_on(edge, end, start)
    n = turned_rows(rows, count, edge, end, start, other)
    followed = 1e6 * removal(other, n, edge, start.slope), angle_of_contact(other, n, edge)
    return followed, 2 * asked[0] - asked[1]  # a flank that begins to cut does so as the root of the way


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("turn", [-140, -60, 0, 35, 120])
def test_a_turn_gives_what_the_material_gives_at_once_behind_it(shape, turn):
    x, y = 10 * math.cos(math.radians(turn)), 10 * math.sin(math.radians(turn))
    first = ((-15, 3, -3), (15, 3, -3), (15, -3, 9), (-15, -2, -3.5), (0, 0, -4))
    followed, asked = turned(SHAPES[shape], (*first, (x, y, -3.5)))  # the second move rises
    assert asked[0] > 0.3 or abs(turn) == 140
    assert followed[0] == pytest.approx(asked[0], rel=2e-3, abs=0.01)  # mm^2; layers of the flank
    assert followed[1] == pytest.approx(asked[1], abs=math.radians(1))


def test_where_the_tool_went_along_its_own_side_nothing_follows():
    edge = edge_of(SHAPES["flat"])
    down = Place(0.0, 0.0, 0.0, 1.0, 0.0, -math.inf, 0, 0, 1.0, 0)
    level, climbing, falling = (down._replace(slope=slope) for slope in (0.0, 0.2, -0.2))
    assert not goes_on(edge, down, level)
    assert not goes_on(edge, level, down)
    assert not goes_on(edge, level, falling)
    assert goes_on(edge, level, climbing)
    assert goes_on(edge, falling, falling._replace(slope=-0.1))
    assert goes_on(edge_of(SHAPES["ball"]), level, falling)


def test_an_arc_that_is_turned_past_the_back_is_two():
    """All round of a bottom that goes down, and goes on going down to the left."""
    edge, out = edge_of(SHAPES["flat"]), np.zeros((4, 5))
    rows = np.array([[0.0, -math.pi, math.pi, 0.0, 0.0]])
    along = Place(0.0, 0.0, 0.0, 1.0, 0.0, -0.1, 0, 0, 1.0, 0)
    assert turned_rows(rows, 1, edge, along, along._replace(ux=0.0, uy=1.0), out) == 2
    assert (out[:2, 2] - out[:2, 1]).sum() == pytest.approx(2 * math.pi)
