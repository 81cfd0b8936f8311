"""The height map: volumes of the worked examples, whole sums, the same bits for any bands."""

import threading

import numpy as np
import pytest

from cutwise.maths import profiles
from cutwise.maths.envelopes import heights_left, segments
from cutwise.maths.height_map import STOCK, cell_middles, height_map, in_rows, layout, material, volume_of
from cutwise.maths.map_levels import room
from cutwise.maths.map_sweep import cut_by, overlap_by, swept_band
from peers.maps import MM, arc, block, lines, separate, swept, tool

BALL_A = separate(((-40, -0.5, -1), (40, -0.5, -1)), ((40, 0.5, -1), (-40, 0.5, -1)), ((0, -40, -1), (0, 40, -1)))


def test_worked_example_a_volumes_of_three_grooves():
    _, volume = swept(block((-20, 20), (-20, 20), (-10, 0), 0.1), BALL_A, tool(profiles.ball(3 * MM)))
    assert volume == pytest.approx([123.899283, 39.442106, 110.142118], rel=4e-4)
    assert volume.sum() == pytest.approx(273.483508, rel=2e-4)


def test_worked_example_b_volume():
    path = lines((0, 0, 0), (20, 0, -4))
    _, volume = swept(block((-10, 30), (-8, 8), (-10, 0), 0.05), path, tool(profiles.bull_nose(5 * MM, 1.5 * MM)))
    assert volume[0] == pytest.approx(624.922, rel=2e-4)


def test_volumes_of_moves_are_the_map_before_less_after():
    stock = block((-20, 20), (-20, 20), (-10, 0), 0.37)
    whole = material(stock)
    solid, volume = swept(stock, BALL_A, tool(profiles.ball(3 * MM)))
    assert 1e-9 * volume.sum() == pytest.approx(whole - material(solid.map), rel=1e-9)


@pytest.mark.parametrize("name", ["flat", "ball", "bull", "taper", "ball taper"])
def test_heights_are_those_of_the_closed_form_to_a_hundredth_of_a_micrometre(name):
    pieces = {
        "flat": profiles.flat(3 * MM), "ball": profiles.ball(3 * MM), "bull": profiles.bull_nose(3 * MM, 0.8 * MM),
        "taper": profiles.taper(3 * MM, 0.5 * MM, 0.4), "ball taper": profiles.ball_taper(3 * MM, 1 * MM, 0.2),
    }[name]  # fmt: skip
    path = lines((-9, -3, -0.5), (6, 4, -2.3), (6, 4, -4), (-3.1, 7.3, -0.05), (-12, 8.037, -3.01), (5, 8.037, -3.01))
    solid, _ = swept(block((-10, 10), (-10, 10), (-6, 0), 0.213), path, tool(pieces))
    grid = solid.map.layout
    x, y = cell_middles(grid)
    at_x, at_y = np.meshgrid(x[2 : 2 + grid.across], y[2 : 2 + grid.along])
    truth = np.minimum(heights_left(path, solid.tools, at_x.ravel(), at_y.ravel()), 0.0)
    off = np.abs(in_rows(grid, solid.map.height).ravel() - truth)
    assert np.mean(off > 1e-8) < 2e-3  # cells on the very rim of a wall may fall to either side
    assert np.median(off) < 2e-9


def test_gentle_ramps_of_a_bull_nose_converge():
    """Seven steps of Newton's rule in float32 left 3.4 micrometres."""
    path = lines((-15, 0, -0.5), (15, 0.1, -0.501))
    solid, _ = swept(block((-10, 10), (-6, 6), (-6, 0), 0.21), path, tool(profiles.bull_nose(5 * MM, 1.5 * MM)))
    grid = solid.map.layout
    x, y = cell_middles(grid)
    at_x, at_y = np.meshgrid(x[2 : 2 + grid.across], y[2 : 2 + grid.along])
    truth = np.minimum(heights_left(path, solid.tools, at_x.ravel(), at_y.ravel()), 0.0)
    assert np.abs(in_rows(grid, solid.map.height).ravel() - truth).max() < 1e-8


def test_the_same_bits_for_any_bands_and_threads():
    path = segments(
        [
            *lines((-9, -3, -0.5), (6, 4, -2.3), (6, 4, -4), (-3.1, 7.3, -0.05)).row.tolist(),
            arc((1, 2), -1.7, 5, 0.3, 5.0),
        ],
        [1, 1, 1, 1],
    )
    table = tool(profiles.bull_nose(3 * MM, 0.8 * MM))
    one, volume = swept(block((-10, 10), (-10, 10), (-6, 0), 0.1), path, table)
    for bands in (2, 5):
        other, again = swept(block((-10, 10), (-10, 10), (-6, 0), 0.1), path, table, bands)
        assert np.array_equal(one.map.height, other.map.height)
        assert np.array_equal(one.map.cutter, other.map.cutter)
        assert np.array_equal(volume, again)
    stock = block((-10, 10), (-10, 10), (-6, 0), 0.1)
    ends = np.linspace(0, stock.layout.rows, 4).astype(int)
    taken = [np.zeros(4, np.int64) for _ in range(3)]
    threads = [
        threading.Thread(target=swept_band, args=(stock, path, table, (int(a), int(b)), out))
        for a, b, out in zip(ends, ends[1:], taken, strict=False)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert np.array_equal(stock.height, one.map.height)
    assert np.array_equal(1e9 * volume_of(stock, sum(taken)), volume)


def test_a_repeated_move_takes_nothing_and_equal_depth_keeps_the_first_id():
    path = separate(((-15, 0, -1), (15, 0, -1)), ((15, 0, -1), (-15, 0, -1)), ((0, -15, -1), (0, 15, -1)))
    solid, volume = swept(block((-10, 10), (-10, 10), (-6, 0), 0.25), path, tool(profiles.flat(2 * MM)))
    assert volume[1] == 0.0
    cutter = in_rows(solid.map.layout, solid.map.cutter)
    assert not (cutter == 1).any()
    assert cutter[40, 40] == 0  # where the two slots cross
    assert cutter[0, 40] == 2
    assert cutter[0, 0] == STOCK


def test_the_order_of_crossing_moves_changes_no_height():
    ends = (((-15, 0, -1), (15, 0, -1)), ((0, -15, -2), (0, 15, -2)))
    maps = [
        swept(block((-10, 10), (-10, 10), (-6, 0), 0.25), separate(*order), tool(profiles.ball(2 * MM)))[0].map
        for order in (ends, ends[::-1])
    ]
    assert np.array_equal(maps[0].height, maps[1].height)


def test_moves_through_the_bottom_take_no_more_than_there_is():
    _, volume = swept(
        block((-5, 5), (-5, 5), (-2, 0), 0.25), lines((-20, 0, -9), (20, 0, -9)), tool(profiles.flat(20 * MM))
    )
    assert volume[0] == pytest.approx(10 * 10 * 2, rel=1e-6)


def test_a_bar_has_its_round_outline_and_an_odd_size_its_whole_area():
    cells = layout((0.0, 0.0101), (0.0, 0.0077), 0.001)
    assert cells.across * cells.dx == pytest.approx(0.0101)
    assert max(cells.dx, cells.dy) <= 0.001
    stock = height_map(cells, np.full((cells.along, cells.across), 0.25), -0.01, 0.0)
    assert material(stock) == pytest.approx(0.25 * 0.0101 * 0.0077 * 0.01)


def test_an_overlap_takes_nothing():
    """Worked example h: a shank of 4 mm from 6 mm above the tip, in a slot of 3 mm that is 10 mm deep."""
    stock = block((0, 40), (-10, 10), (-20, 0), 0.1)
    path, shank = lines((-10, 0, -10), (50, 0, -10)), tool(profiles.revolved([(6 * MM, 4 * MM)]))
    cut_by(stock, path, tool(profiles.flat(3 * MM)), 0, room(stock.layout))
    kept, found = stock.height.copy(), np.zeros(5)
    overlap_by(stock, path, shank, 0, found, room(stock.layout))
    assert np.array_equal(stock.height, kept)
    assert 1e3 * found[1] == pytest.approx(4.0, abs=1e-6)
    assert 1e9 * found[0] == pytest.approx(8.0 * 40.0, rel=0.03)  # 8 mm^2 a length; its walls fall on cells


def test_a_map_moves_and_grows_with_its_lengths():
    """Moved by whole cells the same bits; everything twice as large, eight times the volume."""
    pieces = profiles.bull_nose(3 * MM, 0.8 * MM)
    points = ((-9, -3, -0.5), (6, 4, -2.3), (6, 4, -4), (-3.1, 7.3, -0.05))
    plain, volume = swept(block((-8, 8), (-8, 8), (-6, 0), 0.25), lines(*points), tool(pieces))
    shifted = tuple((x + 16, y - 8, z) for x, y, z in points)
    moved, same = swept(block((8, 24), (-16, 0), (-6, 0), 0.25), lines(*shifted), tool(pieces))
    assert np.array_equal(plain.map.cutter, moved.map.cutter)
    assert np.abs(plain.map.height - moved.map.height).max() < 1e-9
    assert same == pytest.approx(volume, rel=1e-6)
    twice = tuple((2 * x, 2 * y, 2 * z) for x, y, z in points)
    _, larger = swept(
        block((-16, 16), (-16, 16), (-12, 0), 0.5), lines(*twice), tool(profiles.bull_nose(6 * MM, 1.6 * MM))
    )
    assert larger == pytest.approx(8 * volume, rel=1e-6)
