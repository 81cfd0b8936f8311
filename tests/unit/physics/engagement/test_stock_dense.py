"""Contact in dense programs: closed forms, volumes, and a sampled reference for any path."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cutwise.maths.linearc import LineArc, arc, block_at, join, line, sample
from cutwise.paths.blends import blended
from cutwise.physics.engagement.path_sweep import swept_path
from cutwise.physics.engagement.stock import Stock, block_stock, contact_patches, immersion, removal_area

ENDLESS = Stock(np.zeros((0, 3)), 1e-3, -1.0)


def polyline(points):
    """Lines through points [m], shape (n, 3)."""
    step = np.diff(np.asarray(points, dtype=float), axis=0)
    length = np.linalg.norm(step, axis=1)
    kept, none = length > 0.0, np.zeros((int((length > 0.0).sum()), 3))
    start, length = np.asarray(points)[:-1][kept], length[kept]
    flat = np.ones(len(length))
    return LineArc(
        start, step[kept] / length[:, None], none, none, flat, np.full_like(flat, np.inf), length, 0.0 * flat
    )


def chopped(points, step):
    """The same way in short moves."""
    parts = [np.asarray(points[:1], dtype=float)]
    for a, b in zip(np.asarray(points[:-1]), np.asarray(points[1:]), strict=True):
        count = max(1, math.ceil(np.linalg.norm(b - a) / step - 1e-9))
        parts.append(a + (b - a) * np.linspace(0.0, 1.0, count + 1)[1:, None])
    return np.vstack(parts)


def raster(rows, pitch, low, high):
    """There and back along x, the first row at y = 0."""
    ends = [(x, k * pitch, 0.0) for k in range(rows) for x in ((low, high) if k % 2 == 0 else (high, low))]
    return np.array(ends)


def turned(points, angle):
    c, s = math.cos(angle), math.sin(angle)
    return points @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def met(curve, s, radius, stock=ENDLESS):
    point, tangent, _ = sample(curve, curve.knots, s)
    return contact_patches(point, np.arctan2(tangent[:, 1], tangent[:, 0]), s, swept_path(curve, radius), stock)


@pytest.mark.parametrize(("radius", "degrees"), [(3e-3, 25.8419), (10e-3, 14.0699)])
@pytest.mark.parametrize("angle", [0.0, 0.3])
def test_facing_in_short_moves_is_the_straight_cut(radius, degrees, angle):
    """Moves of 0.5 mm, rows 0.3 mm apart: arccos(1 - 0.3 / R). Version 0.1 found 60.0 and 137.7 degrees."""
    curve = polyline(turned(chopped(raster(40, 0.3e-3, 0.0, 0.06), 0.5e-3), angle))
    at = curve.knots[-1] - 0.03 + np.linspace(-1e-3, 1e-3, 41)  # amid the last row
    assert np.degrees(immersion(met(curve, at, radius))) == pytest.approx(degrees, abs=1e-3)


def test_a_slot_of_many_moves_and_half_of_it_back():
    """10,000 collinear moves, the way back half a diameter beside: 90 degrees. Version 0.1 found 104.3."""
    curve = polyline(
        np.vstack([chopped([(0.0, 0.0, 0.0), (0.5, 0.0, 0.0)], 5e-5), [(0.5, 5e-3, 0.0), (0.0, 5e-3, 0.0)]])
    )
    assert curve.count == 10_002
    at = curve.knots[-1] - np.linspace(0.1, 0.4, 50)
    assert immersion(met(curve, at, 5e-3)) == pytest.approx(math.pi / 2, abs=1e-9)
    assert len(swept_path(curve, 5e-3).length) == 3


BLOCK = block_stock((0.0, 0.03), (0.0, 0.03), 1e-3, -1e-2)


@pytest.mark.parametrize(("rows", "step"), [(86, 1.0), (86, 0.836e-3), (1989, 1.0)])
def test_a_block_is_removed_once(rows, step):
    """30 x 30 x 1 mm in 171 lines, the same in short moves, and in 3,978 lines: 0.900 cm3. Version 0.1: 0.892 and 2.418."""
    points = raster(rows, 0.0336 / (rows - 1), -4e-3, 0.034) - [0.0, 2.5e-3, 0.0]
    curve = polyline(chopped(points, step))
    s = (np.arange(40_000) + 0.5) / 40_000 * curve.knots[-1]
    volume = removal_area(met(curve, s, 3e-3, BLOCK), 3e-3).mean() * curve.knots[-1]
    assert volume == pytest.approx(0.9e-6, rel=2e-3)


def test_levels_without_number():
    """200 passes 5 µm deeper each, then a pass half a radius beside the last: what stands there is whole."""
    levels = [(x, 0.0, -5e-6 * (k // 2)) for k, x in enumerate([0.0, 0.05, 0.05, 0.0] * 100)]
    curve = polyline([*levels, (0.0, 2.5e-3, 5e-3), (0.0, 2.5e-3, -2e-3), (0.05, 2.5e-3, -2e-3)])
    patches = met(curve, np.array([curve.knots[-1] - 0.02]), 5e-3)[0]
    rows = [row for row in patches if row[1] > row[0]]
    assert len(rows) == 2
    edge = 0.5 * math.pi + math.asin(0.5)  # the slot's own side is half a radius to the left of the middle
    assert rows[1] == pytest.approx((edge, math.pi, 0.0, 3e-3), abs=1e-9)
    assert rows[0] == pytest.approx((0.0, edge, 0.0, 2e-3 - 5e-6 * 199), abs=1e-9)


@pytest.mark.parametrize("bend", [0.0, 0.01])
def test_a_ramp_run_again_meets_nothing(bend):
    """Down and back up on the same way, straight or as a helix of three turns."""
    if bend == 0.0:
        down, up = line((0, 0, 0), (0.04, 0, -4e-3)), line((0.04, 0, -4e-3), (0, 0, 0))
    else:
        down = arc((bend, 0, 0), (0, 0), 6.0 * math.pi, rise=-4e-3)
        up = arc((bend, 0, -4e-3), (0, 0), -6.0 * math.pi, rise=4e-3)
    curve = join([down, up])
    s = curve.knots[1] + np.linspace(1e-4, curve.length[1] - 1e-4, 200)
    patches = met(curve, s, 5e-3)
    assert float(removal_area(patches, 5e-3).max()) < 1e-12


def test_a_helix_takes_its_pitch():
    """From the second turn on the mill meets what it left a turn before, and less the longer ago that was.

    On a centre path of radius rho the floor ahead lies a pitch higher, less what the helix fell while the mill was over
    that place: over the leading half this is R / (4 rho) of the pitch (integrated numerically with 20,000 points).
    """
    curve = join([arc((0.01, 0, 0), (0, 0), 8.0 * math.pi, rise=-4e-3)])
    taken = removal_area(met(curve, np.linspace(0.5, 0.95, 50) * curve.knots[-1], 5e-3), 5e-3)
    assert taken == pytest.approx(1e-3 * 10e-3 * (1.0 - 0.5 / 4.0), rel=7e-3)  # steps of height
    assert np.median(taken) == pytest.approx(8.75e-6, rel=1e-5)


# any path, against sets of sampled discs

R = 2e-3
GAP = 8e-6  # [m] between the samples


@st.composite
def ways(draw):
    """Lines, ramps, plunges, arcs and helices in a small place, so that they overlap."""
    number = st.integers(-10, 10)
    at = np.array([0.0, 0.0, 0.0])
    blocks = []
    for _ in range(draw(st.integers(2, 9))):
        kind = draw(st.sampled_from(["line", "ramp", "plunge", "arc", "helix"]))
        rise = 1e-4 * draw(number) if kind in ("ramp", "helix", "plunge") else 0.0
        if kind in ("line", "ramp", "plunge"):
            to = at + (0.0 if kind == "plunge" else 1.0) * np.array([4e-4 * draw(number), 4e-4 * draw(number), 0.0])
            to[2] += rise
            if math.dist(at, to) < 1e-9:
                continue
            blocks.append(line(at, to))
        else:
            centre = at + np.array([3e-4 * draw(number) + 1e-4, 3e-4 * draw(number), 0.0])
            sweep = draw(st.sampled_from([-7.0, -math.pi, -1.0, 0.7, 2.0, 2.0 * math.pi]))
            blocks.append(arc(at, centre, sweep, rise=rise))
            c, s = math.cos(sweep), math.sin(sweep)
            arm = at - centre
            to = centre + np.array([c * arm[0] - s * arm[1], s * arm[0] + c * arm[1], 0.0])
            to[2] = at[2] + rise
        at = np.array(to)
    return blocks or [line((0, 0, 0), (1e-3, 0, 0))]


def sampled_heights(curve, s, point, rim, slack):
    """Lowest tip that has come within the radius (and some slack) of points of the rim until a place [m], shape (k,)."""
    knots = [k for k in curve.knots if k < s]
    at = np.unique(np.concatenate([np.linspace(0.0, s, max(2, math.ceil(s / GAP))), knots, [s]]))
    centre = sample(curve, curve.knots, at)[0]
    reach = np.where(np.hypot(*(centre - point)[:, :2].T) < 0.05 * R, R - 1e-9, R + slack)
    near = np.hypot(centre[:, None, 0] - rim[:, 0], centre[:, None, 1] - rim[:, 1]) < reach[:, None]
    return np.where(near, centre[:, 2:3], np.inf).min(axis=0)


@settings(max_examples=100, deadline=None)
@given(ways(), st.floats(0.05, 0.999))
@example([line((0, 0, 0), (4e-3, 0, -1e-3)), line((4e-3, 0, -1e-3), (0, 0, 0))], 0.7)
@example([arc((3e-3, 0, 0), (0, 0), 7.0, rise=-5e-4)], 0.97)
def test_any_path_against_sampled_discs(blocks, share):
    curve = join(blocks)
    s = share * curve.knots[-1]
    point, tangent, _ = (part[0] for part in sample(curve, curve.knots, np.array([s])))
    heading = math.atan2(tangent[1], tangent[0])
    stock = block_stock((-8e-3, 6e-3), (-6e-3, 8e-3), 1.2e-3, -3e-3)
    rows = met(curve, np.array([s]), R, stock)[0]
    floor = max(point[2], stock.bottom)
    angle = (np.arange(90) + 0.5) / 90 * math.pi
    rim = point[:2] + R * np.column_stack(
        [np.cos(heading - 0.5 * math.pi + angle), np.sin(heading - 0.5 * math.pi + angle)]
    )
    found = np.full(angle.size, floor)
    clear = np.ones(angle.size, bool)  # of the ends of arcs, where one sample says nothing
    for low, high, _, top in rows[rows[:, 1] > rows[:, 0]]:
        found[(angle > low) & (angle < high)] = top + point[2]
        clear &= (np.abs(angle - low) > 0.03) & (np.abs(angle - high) > 0.03)
    inside = (rim @ stock.sides[:, :2].T < stock.sides[:, 2]).all(axis=1)
    clear &= (np.abs(rim @ stock.sides[:, :2].T - stock.sides[:, 2]) > 1e-5).all(axis=1)
    for slack, sign in ((-1e-9, 1.0), (0.5 * GAP, -1.0)):
        most = np.minimum(sampled_heights(curve, s, point, rim, slack), stock.top)
        expected = np.where(inside & (point[2] < stock.top), np.maximum(most, floor), floor)
        off = sign * (found - expected)[clear]
        assert off.max(initial=0.0) < 0.06 * R, (angle[clear][off.argmax()], off.max())


# what it costs


def trochoid(moves):
    turn = 2.0 * math.pi * moves / 400 * np.linspace(0.0, 1.0, moves + 1)
    return np.column_stack((2e-4 * turn / (2.0 * math.pi) + 4e-3 * np.cos(turn), 4e-3 * np.sin(turn), 0.0 * turn))


def rough(moves):
    """A raster at an angle whose places are rounded to a micrometre, so that no two moves are one."""
    rows = math.isqrt(moves)
    points = chopped(raster(rows, 0.04 / rows, 0.0, 0.04), 0.04 / rows * 1.0001)
    return np.round(turned(points, 0.5), 6)


def small_heights(moves):
    """A wavy surface in rows."""
    n = math.isqrt(moves)
    x, y = np.meshgrid(np.linspace(0.0, 0.03, n), np.linspace(0.0, 0.03, n))
    x[1::2] = x[1::2, ::-1].copy()
    return np.column_stack([c.ravel() for c in (x, y, -3e-3 + 2e-3 * np.sin(300 * x) * np.cos(250 * y))])


@pytest.mark.parametrize("points", [trochoid, rough, small_heights])
def test_dense_programs_meet_what_sparser_ones_do(points):
    """The same way in twice as many moves: the same contact. What it costs is told by benchmarks/stock_contact.py."""
    way = points(3_000)
    curve, finer = (
        polyline(way),
        polyline(np.vstack([way[:1], *np.stack([0.5 * (way[1:] + way[:-1]), way[1:]], axis=1)])),
    )
    s = np.linspace(0.3, 0.99, 200) * curve.knots[-1]
    once, twice = immersion(met(curve, s, 3e-3)), immersion(met(finer, s, 3e-3))
    assert twice == pytest.approx(once, abs=1e-6)


@pytest.mark.parametrize("shape", ["arc", "clothoid"])
def test_a_blended_corner_is_met_as_the_sharp_one_but_for_its_blend(shape):
    """On a clothoid the mill stands up to 0.1 µm beside the lines that it is cut into; its own disc there clears nothing."""
    first, second = [line((-0.03, 4e-3), (0, 4e-3)), line((0, 4e-3), (0, 0.03))], [line((-0.03, 0), (4e-3, 0))]
    second.append(line((4e-3, 0), (4e-3, 0.03)))
    rounded = blended(join(second), np.array([0.2e-3]), shape).curve
    own = [block_at(rounded, i) for i in range(rounded.count)]
    prior = [*first, line((0, 0.03, 0), (0, 0.03, 0.02)), line((0, 0.03, 0.02), (-0.03, 0, 0.02)),
             line((-0.03, 0, 0.02), (-0.03, 0, 0))]  # fmt: skip
    curve = join([*prior, *own])
    begin = curve.knots[len(prior)]
    s = begin + np.linspace(0.025, 0.045, 4001)
    turning = np.isin(sample(curve, curve.knots, s)[2], np.arange(len(prior) + 1, curve.count - 1))
    angle = immersion(met(curve, s, 6e-3))
    assert turning.sum() > 100
    assert np.abs(np.diff(angle)).max() < 0.05  # no place falls out of line
    assert angle[turning].min() > math.acos(1.0 - 4.0 / 6.0)
