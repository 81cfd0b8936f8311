"""Contact with a height map: the worked examples of arcs, and the balance of what is taken."""

import math

import numpy as np
import pytest

from cutwise.maths import profiles
from cutwise.maths.envelopes import segments
from cutwise.maths.workpiece import alone
from cutwise.physics.engagement.contact_sums import angle_of_contact, removal
from cutwise.physics.engagement.map_contact import CYLINDER, Edge, contact_rows
from cutwise.physics.engagement.map_fan import fan_room
from cutwise.physics.engagement.map_rim import Place
from peers.maps import MM, arc, before, block, lines, separate, tool

FLAT = profiles.flat(10 * MM)
CORNER = separate(
    ((-70, 4, 9), (-70, 4, -5)), ((-70, 4, -5), (-4, 4, -5)), ((-4, 4, -5), (-4, 70, -5)), ((-70, 0, -5), (0, 0, -5)),
    ((0, 0, -5), (0, 70, -5)),
)  # fmt: skip


def edge_of(pieces, elements=12, end=math.inf, core=0.0) -> Edge:
    radius = max(piece[2] for piece in pieces)
    return Edge(profiles.meridian(pieces, core, elements), radius, profiles.cylinder_foot(pieces), end)


def met(solid, place, edge, refine=True):
    rows = np.zeros((500, 5))
    count = contact_rows(alone(solid), place, edge, fan_room(), rows, refine)
    return rows[:count]


@pytest.mark.parametrize("grid", [0.5, 1.0])
def test_worked_example_c_a_flat_mill_into_a_corner(grid):
    solid = before(block((-50, 30), (-30, 50), (-20, 0), grid), CORNER, tool(FLAT), 3)
    told = {30: 53.130102, 20: 53.130102, 11.9: 53.133710, 8: 61.429940, 4: 101.536959, 3.2: 113.078603, 2: 126.869898,
            1: 135.572996, 0: 143.130102}  # fmt: skip
    for s, degrees in told.items():
        rows = met(solid, Place(-s * MM, 0.0, -5 * MM, 1.0, 0.0, 0.0, 3, 3, (70 - s) / 70, 3), edge_of(FLAT))
        assert len(rows) == 1
        assert math.degrees(rows[0, 1]) == pytest.approx(-90.0, abs=1e-5)
        assert math.degrees(rows[0, 2] - rows[0, 1]) == pytest.approx(degrees, abs=1e-5)
        assert rows[0, 3:] == pytest.approx([0.0, 5 * MM])


def test_coarse_arcs_are_within_a_direction():
    solid = before(block((-50, 30), (-30, 50), (-20, 0), 0.5), CORNER, tool(FLAT), 3)
    place = Place(-4 * MM, 0.0, -5 * MM, 1.0, 0.0, 0.0, 3, 3, 66 / 70, 3)
    rows = met(solid, place, edge_of(FLAT), refine=False)
    assert math.degrees(rows[0, 2] - rows[0, 1]) == pytest.approx(101.537, abs=5.6)


def test_worked_example_b_a_bull_nose_going_down():
    pieces = profiles.bull_nose(5 * MM, 1.5 * MM)
    path = lines((0, 0, 0), (20, 0, -4))
    solid = before(block((-10, 30), (-8, 8), (-10, 0), 0.2), path, tool(pieces), 0)
    place = Place(10 * MM, 0.0, -2 * MM, 1.0, 0.0, -0.2, 0, 0, 0.5, 0)
    for height, degrees in ((0.1, 121.328693), (0.5, 100.304846), (1.0, 94.054807), (1.4, 90.765670)):
        kappa = math.acos(1.0 - height / 1.5)
        one = profiles.Meridian(*(np.array([v]) for v in (height * MM, (3.5 + 1.5 * math.sin(kappa)) * MM, math.sin(kappa),
                                                          math.cos(kappa), 0.1 * MM)))  # fmt: skip
        rows = met(solid, place, Edge(one, 5 * MM, 1.5 * MM, 1.5 * MM))
        assert np.degrees(rows[0, 1:3]) == pytest.approx([-degrees, degrees], abs=1e-5)
    rows = met(solid, place, edge_of(pieces, 200))
    assert 1e6 * removal(rows, len(rows), edge_of(pieces, 200), -0.2) == pytest.approx(31.53849, rel=2e-4)
    bottom = rows[edge_of(pieces, 200).meridian.sine[rows[:, 0].astype(int)] == 0.0]
    assert (bottom[:, 2] - bottom[:, 1]).min() == pytest.approx(2 * math.pi)


def test_worked_example_e2_a_ball_along_a_slope():
    """Arcs of a ball whose level line is half a millimetre under a plane of 30 degrees that rises to its right."""
    tan = math.tan(math.radians(30))
    depth = 0.5 / math.cos(math.radians(30))
    stock = block((-20, 20), (-12, 12), (-20, 0), 0.1)
    x, y = np.meshgrid(np.arange(stock.layout.columns * 16), np.arange(stock.layout.rows * 16))
    del x
    height = -8 * MM - tan * ((y - 1.5) * stock.layout.dy - 12 * MM)
    from cutwise.maths.height_map import in_blocks

    top = np.asarray(in_blocks(height.astype(np.float32)))
    stock = stock._replace(height=top.copy(), top=top, highest=top.reshape(-1, 256).max(axis=1))
    pieces = profiles.ball(3 * MM)
    path = lines((-30, 0, 0), (30, 0, 0))
    solid = before(stock, path, tool(pieces), 0)
    contact = 3 / math.cos(math.radians(30)) - 3  # of the centre over the plane that is touched, less the radius
    z = -8 - depth + contact
    for at, degrees in ((0.3, -14.321239), (0.8, -35.675548), (1.3, -56.260544)):
        kappa = math.acos(1.0 - at / 3.0)
        one = profiles.Meridian(
            *(np.array([v]) for v in (at * MM, 3 * math.sin(kappa) * MM, math.sin(kappa), math.cos(kappa), 0.1 * MM))
        )
        rows = met(solid, Place(0.0, 0.0, z * MM, 1.0, 0.0, 0.0, 0, 0, 0.5, 0), Edge(one, 3 * MM, 3 * MM, 3 * MM))
        assert np.degrees(rows[0, 1:3]) == pytest.approx([-90.0, degrees], abs=2e-3)  # the plane is float32
    edge = edge_of(pieces, 400)
    rows = met(solid, Place(0.0, 0.0, z * MM, 1.0, 0.0, 0.0, 0, 0, 0.5, 0), edge)
    assert 1e6 * removal(rows, len(rows), edge, 0.0) == pytest.approx(1.125389, rel=2e-3)


def test_an_arc_meets_what_it_has_not_swept_itself():
    """Round a full circle in solid material the far side has been cut by the circle's own beginning."""
    pieces = profiles.flat(4 * MM)
    path = segments([arc((0, 0), -2, 3, 0.0, 2 * math.pi)], [1])
    solid = before(block((-20, 20), (-20, 20), (-6, 0), 0.25), path, tool(pieces), 0)
    psi = np.linspace(-math.pi / 2, math.pi / 2, 20001)[1:-1]
    for share in (0.0, 0.1, 0.25, 0.5, 0.9):
        turn = 2 * math.pi * share
        ux, uy = -math.sin(turn), math.cos(turn)
        place = Place(3 * MM * math.cos(turn), 3 * MM * math.sin(turn), -2 * MM, ux, uy, 0.0, 0, 0, share, 0)
        rows = met(solid, place, edge_of(pieces, core=4 * MM))
        x, y = 3 * uy + 4 * (ux * np.cos(psi) - uy * np.sin(psi)), -3 * ux + 4 * (uy * np.cos(psi) + ux * np.sin(psi))
        before_it = np.linspace(0.0, turn, 2000)[:-1] if share else np.zeros(0)
        swept_by = [np.hypot(x - 3 * math.cos(t), y - 3 * math.sin(t)) <= 4 for t in before_it]
        free = ~np.logical_or.reduce(swept_by) if swept_by else np.ones(psi.size, bool)
        angle = angle_of_contact(rows, len(rows), edge_of(pieces, core=4 * MM))
        assert math.degrees(angle) == pytest.approx(180 * free.mean(), abs=0.02)


def test_layers_follow_steps_of_the_material():
    path = separate(((-30, -1, -1), (30, -1, -1)), ((-30, 3, -3), (30, 3, -3)))
    pieces = profiles.flat(3 * MM)
    solid = before(block((-20, 20), (-10, 10), (-6, 0), 0.2), path, tool(pieces), 1)
    rows = met(solid, Place(0.0, 3 * MM, -3 * MM, 1.0, 0.0, 0.0, 1, 1, 0.5, 1), edge_of(pieces, core=3 * MM))
    assert rows[:, 0].tolist() == [CYLINDER] * 2
    assert rows[:, 3:] == pytest.approx(np.array([[0.0, 2 * MM], [2 * MM, 3 * MM]]))
    assert rows[0, 1:3] == pytest.approx([-math.pi / 2, math.pi / 2], abs=1e-6)
    assert rows[1, 1] == pytest.approx(math.asin(-1 / 3), abs=1e-6)  # above 2 mm stands what the first pass left


def test_flutes_end_and_plunges_have_no_side():
    pieces = profiles.flat(3 * MM)
    path = lines((0, 0, 5), (0, 0, -5))
    solid = before(block((-20, 20), (-10, 10), (-9, 0), 0.2), path, tool(pieces), 0)
    down = Place(0.0, 0.0, -5 * MM, 1.0, 0.0, -math.inf, 0, 0, 1.0, 0)
    rows = met(solid, down, edge_of(pieces, 10))
    assert (rows[:, 0] >= 0).all()
    assert 1e6 * removal(rows, len(rows), edge_of(pieces, 10), -math.inf) == pytest.approx(math.pi * 9)
    assert len(met(solid, down._replace(slope=math.inf), edge_of(pieces, 10))) == 0
    along = Place(0.0, 0.0, -5 * MM, 1.0, 0.0, 0.0, 0, 0, 1.0, 0)
    assert met(solid, along, edge_of(pieces, 10, end=4 * MM))[:, 4].max() == pytest.approx(4 * MM)


def test_mirrored_in_x_the_arcs_are_mirrored():
    for sign in (1, -1):
        path = separate(((-30, 2 * sign, -1.5), (30, 2 * sign, -1.5)), ((-30, 0, -2), (30, 0, -2)))
        solid = before(block((-20, 20), (-10, 10), (-6, 0), 0.25), path, tool(profiles.bull_nose(3 * MM, 1 * MM)), 1)
        rows = met(
            solid, Place(0.0, 0.0, -2 * MM, 1.0, 0.0, 0.0, 1, 1, 0.5, 1), edge_of(profiles.bull_nose(3 * MM, 1 * MM))
        )
        arcs = np.array(sorted((int(e), -b, -a) if sign == 1 else (int(e), a, b) for e, a, b in rows[:, :3].tolist()))
        if sign == 1:
            kept = arcs
    assert arcs.shape == kept.shape
    assert arcs == pytest.approx(kept, abs=2e-5)
