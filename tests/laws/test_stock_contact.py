"""Contact with the map held against plain angles round the rim, over random moves of every shape of tool."""

import math

import numpy as np
import pytest

from cutwise.maths import profiles
from cutwise.maths.envelopes import Segments, heights_left
from cutwise.maths.workpiece import alone
from cutwise.physics.engagement.map_contact import Edge, contact_rows
from cutwise.physics.engagement.map_fan import fan_room
from cutwise.physics.engagement.map_rim import Place
from peers.maps import MM, before, block, lines, tool

TOOLS = {
    "flat": profiles.flat(3 * MM),
    "ball": profiles.ball(3 * MM),
    "bull_nose": profiles.bull_nose(3 * MM, 1 * MM),
    "taper": profiles.taper(3 * MM, 1 * MM, 0.4),
    "ball_taper": profiles.ball_taper(3 * MM, 1 * MM, 0.3),
}
ANGLES = 2000


def random_case(draw, plunge):
    """A path of six lines through a block, the last of them straight down or not, and a place on the last."""
    points = [(*draw.uniform(-9, 9, 2), draw.uniform(-4, 1)) for _ in range(7)]
    if plunge:
        points[-1] = (*points[-2][:2], points[-2][2] - 1.0)
    start, end = (MM * np.array(p) for p in points[-2:])
    share = draw.uniform(0.02, 0.98)
    tip, step = start + share * (end - start), end - start
    flat = math.hypot(step[0], step[1])
    along = (1.0, 0.0, -math.inf) if plunge else (step[0] / flat, step[1] / flat, step[2] / flat)
    return lines(*points), Place(*tip, *along, 5, 5, share, 5)


@pytest.mark.parametrize("plunge", [False, True])
@pytest.mark.parametrize("name", TOOLS)
def test_arcs_are_where_material_stands_above_the_rim(name, plunge):
    """Also where the rim reaches out of the stock: the rings of cells round it are no material."""
    pieces, draw = TOOLS[name], np.random.default_rng(11)
    edge = Edge(profiles.meridian(pieces, 0.0, 8), 3 * MM, profiles.cylinder_foot(pieces), 1.0)
    psi = (np.arange(ANGLES) + 0.5) / ANGLES * 2 * math.pi - math.pi
    off, rows = [], np.zeros((500, 5))
    for _ in range(6):
        path, place = random_case(draw, plunge)
        solid = before(block((-10, 10), (-10, 10), (-6, 0), 0.15), path, tool(pieces), 5)
        count = contact_rows(alone(solid), place, edge, fan_room(), rows, True)
        earlier = Segments(path.row[:5].copy(), path.first[:6].copy())
        for k in range(edge.meridian.height.size):
            radius, sine, cosine = edge.meridian.radius[k], edge.meridian.sine[k], edge.meridian.cosine[k]
            x = place.x + radius * (place.ux * np.cos(psi) - place.uy * np.sin(psi))
            y = place.y + radius * (place.uy * np.cos(psi) + place.ux * np.sin(psi))
            stands = np.minimum(heights_left(earlier, solid.tools, x, y), 0.0) > place.z + edge.meridian.height[k]
            stands &= (np.abs(x) <= 10 * MM) & (np.abs(y) <= 10 * MM)
            moves_in = np.full(ANGLES, cosine > 1e-9) if plunge else sine * np.cos(psi) - place.slope * cosine > 0.0
            told = sum(rows[i, 2] - rows[i, 1] for i in range(count) if rows[i, 0] == k)
            off.append(abs(2 * math.pi * (stands & moves_in).mean() - told))
    assert np.quantile(off, 0.97) < 4 * math.pi / ANGLES  # of the angles that are counted
    assert max(off) < 2 * math.pi / 64 + 0.05  # a gap narrower than the fan of 64 directions may be missed
