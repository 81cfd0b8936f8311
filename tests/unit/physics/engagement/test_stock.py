"""Contact with the stock that a path has left: the closed forms of a corner, areas counted on a grid, levels, blocks."""

import math

import numpy as np
import pytest

from cutwise.maths.linearc import arc, join, line, sample
from cutwise.paths.pocket import corner
from cutwise.physics.engagement.corner import Corner, summed
from cutwise.physics.engagement.path_sweep import swept_path
from cutwise.physics.engagement.stock import Stock, block_stock, contact_patches, immersion, removal_area
from cutwise.physics.engagement.wall import path_contact
from peers.corner import corner_immersion

R = 0.01
ENDLESS = Stock(np.zeros((0, 3)), 0.005, -1.0)


def moved(blocks, by):
    return [b._replace(start=tuple(np.array(b.start) + by)) for b in blocks]


def over(start, end, height=0.02):
    """Up, across and down again."""
    lift = np.array([0.0, 0.0, height])
    a, b = np.array(start), np.array(end)
    return [line(a, a + lift), line(a + lift, b + lift), line(b + lift, b)]


def end_of(block):
    return np.array(block.start) + block.length * np.array(block.along)


def contacts(curve, s, stock=ENDLESS, radius=R):
    point, tangent, _ = sample(curve, curve.knots, s)
    heading = np.arctan2(tangent[:, 1], tangent[:, 0])
    return contact_patches(point, heading, s, swept_path(curve, radius), stock), point, tangent


def two_passes(turn, fillet, depth, lead=0.03):
    """The way from the end of the first pass through the second, in a program that runs both, and the second alone."""
    inner = moved(corner(lead, turn, max(fillet - depth, 0.0)), [-depth * math.tan(turn / 2), depth, 0.0])
    outer = corner(lead, turn, fillet)
    curve = join([*inner, *over(end_of(inner[-1]), outer[0].start), *outer])
    return curve, curve.knots[len(inner) + 3], join(outer)


@pytest.mark.parametrize("turn", [1.0, math.pi / 2])
@pytest.mark.parametrize("fillet", [0.0, 2e-3, 8e-3])
@pytest.mark.parametrize("depth", [0.5e-3, 4e-3])
def test_corner_whose_previous_pass_is_really_run(turn, fillet, depth):
    """Two passes of a program, offset by the radial depth: the closed form to rounding."""
    curve, begin, _ = two_passes(turn, fillet, depth)
    s = np.linspace(begin + 0.014, curve.knots[-1] - 0.014, 1501)
    patches, point, tangent = contacts(curve, s)
    heading = np.arctan2(tangent[:, 1], tangent[:, 0])
    shape = Corner(R, depth, turn, fillet)
    expected = [corner_immersion(*p[:2], h, shape) for p, h in zip(point, heading, strict=True)]
    np.testing.assert_allclose(patches[:, 0, 1], expected, atol=1e-12)
    np.testing.assert_allclose(patches[:, 0, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(immersion(patches), expected, atol=1e-12)
    np.testing.assert_allclose(patches[:, 0, 2:], [[0.0, 0.005]] * len(s), atol=1e-15)


@pytest.mark.parametrize("turn", [0.5, math.pi / 2, 2.2, 2.9])
@pytest.mark.parametrize("fillet", [0.0, 2e-3, 15e-3])
@pytest.mark.parametrize("depth", [4e-3, 9.9e-3, 16e-3, 19.9e-3])
def test_wall_is_a_previous_pass(turn, fillet, depth):
    """Acute corners and depths beyond the radius too, where the mill meets stock in two arcs."""
    curve, begin, own = two_passes(turn, fillet, depth, lead=1.2)
    s = np.linspace(0.7, own.knots[-1] - 0.5, 401)
    _, _, block = sample(own, own.knots, s)
    arcs = path_contact(own, np.ones(own.count, bool), block, s, R, depth)
    np.testing.assert_allclose(summed(arcs), immersion(contacts(curve, begin + s)[0]), atol=1e-6)


def zigzag():
    """A slot, an arc back with a step-over less than the radius, a full circle and a line through all of it."""
    return join([
        line((0, 0), (0.03, 0)), arc((0.03, 0), (0.03, 4e-3), math.pi), line((0.03, 8e-3), (0.0, 8e-3)),
        line((0.0, 8e-3), (0.01, 4e-3)), arc((0.01, 4e-3), (0.015, 4e-3), 2 * math.pi), line((0.01, 4e-3), (0.035, 0.02)),
    ])  # fmt: skip


def counted_area(curve, radius, cell):
    """Area within the radius of a finely sampled path, on a grid."""
    s = np.linspace(0.0, curve.knots[-1], 6000)
    point = sample(curve, curve.knots, s)[0][:, :2]
    low, high = point.min(axis=0) - 1.1 * radius, point.max(axis=0) + 1.1 * radius
    x, y = (np.arange(a, b, cell) + 0.5 * cell for a, b in zip(low, high, strict=True))
    from scipy.spatial import KDTree

    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    return float((KDTree(point).query(grid)[0] < radius).sum()) * cell**2


def test_removed_area_is_what_is_gone():
    """The integral of the contact over the way is the area within the radius of the path, less the first disc."""
    curve = zigzag()
    s = np.linspace(1e-7, curve.knots[-1] - 1e-7, 40_001)
    patches, _, _ = contacts(curve, s)
    rate = removal_area(patches, R) / 0.005
    area = float(np.sum(0.5 * (rate[1:] + rate[:-1]) * np.diff(s)))
    gone = counted_area(curve, R, 2e-5) - math.pi * R**2  # the mill stands in the stock at the start
    assert area == pytest.approx(gone, rel=3e-4)


def test_a_hole_ahead_leaves_an_arc_on_either_side():
    """A plunge of the same mill 1.2 radii ahead takes the middle of the arc: within acos 0.6 of the feed nothing is left."""
    hole = [line((0.012, 0, 0.01), (0.012, 0, 0.0)), line((0.012, 0, 0.0), (0.012, 0, 0.02)),
            line((0.012, 0, 0.02), (-0.01, 0, 0.02)), line((-0.01, 0, 0.02), (-0.01, 0, 0.0))]  # fmt: skip
    curve = join([*hole, line((-0.01, 0, 0), (0.02, 0, 0))])
    patches = contacts(curve, np.array([curve.knots[4] + 0.01]))[0][0]
    half = math.acos(0.6)
    assert sorted(patches[:, :2].tolist()) == [
        pytest.approx([0.0, math.pi / 2 - half]), pytest.approx([math.pi / 2 + half, math.pi]),
    ]  # fmt: skip


def test_cutting_blocks_up_changes_nothing():
    curve = zigzag()
    cut = [line((0, 0), (0.013, 0)), line((0.013, 0), (0.03, 0))]
    quarter = [arc((0.03, 0), (0.03, 4e-3), math.pi / 2), arc((0.034, 4e-3), (0.03, 4e-3), math.pi / 2)]
    blocks = [*cut, *quarter, line((0.03, 8e-3), (0.0, 8e-3)), line((0.0, 8e-3), (0.01, 4e-3)),
              arc((0.01, 4e-3), (0.015, 4e-3), 2 * math.pi), line((0.01, 4e-3), (0.035, 0.02))]  # fmt: skip
    s = np.linspace(1e-6, curve.knots[-1] - 1e-6, 3001)
    one, other = (contacts(c, s)[0] for c in (curve, join(blocks)))
    assert removal_area(one, R) == pytest.approx(removal_area(other, R), abs=1e-12)


def test_nothing_depends_on_where_and_how_the_path_lies():
    """Shifted and turned paths have the same contact; a mirrored one leaves it from the other side."""
    curve = zigzag()
    s = np.linspace(1e-6, curve.knots[-1] - 1e-6, 800)
    plain = contacts(curve, s)[0]
    c, t = math.cos(0.7), math.sin(0.7)
    turn = np.array([[c, -t, 0], [t, c, 0], [0, 0, 1]])
    other = curve._replace(start=curve.start @ turn.T + [1.0, -2.0, 0.0], along=curve.along @ turn.T,
                           inward=curve.inward @ turn.T)  # fmt: skip
    np.testing.assert_allclose(contacts(other, s)[0], plain, atol=1e-9)
    flip = np.array([1.0, -1.0, 1.0])
    mirror = curve._replace(start=curve.start * flip, along=curve.along * flip, inward=curve.inward * flip)
    mirrored = contacts(mirror, s)[0]
    assert immersion(mirrored) == pytest.approx(immersion(plain), abs=1e-9)
    single = immersion(plain) > 0.0
    np.testing.assert_allclose(mirrored[single, 0, 0], math.pi - plain[single, 0, 1], atol=1e-9)


def test_first_cut_is_a_full_slot_and_the_edge_of_the_stock_opens_it():
    curve = join([line((-0.02, 0.0), (0.05, 0.0))])
    stock = block_stock((0.0, 0.1), (-0.05, 0.05), 0.003, -0.02)
    s = np.array([0.005, 0.015, 0.02, 0.04, 0.065])
    patches = contacts(curve, s, stock)[0]
    assert immersion(patches) == pytest.approx([0.0, 2 * math.acos(0.5), math.pi, math.pi, math.pi], abs=1e-12)
    assert patches[3, 0, 2:].tolist() == [0.0, 0.003]
    half = contacts(curve, s, block_stock((0.0, 0.1), (-0.05, 0.0), 0.003, -0.02))[0]
    assert half[3, 0, :2] == pytest.approx([0.0, math.pi / 2], abs=1e-12)  # the wall side is the right one


def test_levels_are_cleared_from_the_top():
    """A slot 2 mm deep, then the same 5 mm deep and half a radius to the side: two patches, one beside the other."""
    first, second = [line((0, 0, -2e-3), (0.05, 0, -2e-3))], [line((0, -5e-3, -5e-3), (0.05, -5e-3, -5e-3))]
    curve = join([*first, *over(end_of(first[0]), second[0].start), *second])
    s = np.array([curve.knots[4] + 0.025])
    patches = contacts(curve, s, Stock(np.zeros((0, 3)), 0.0, -0.02))[0][0]
    rows = sorted(tuple(np.round(row, 9)) for row in patches if row[1] > row[0])
    side = math.acos(0.5)  # the wall of the first slot, 5 mm off the middle of the mill
    assert rows == [
        pytest.approx((0.0, math.pi / 2 - math.asin(0.5), 0.0, 5e-3)),
        pytest.approx((math.pi / 2 - math.asin(0.5), math.pi, 0.0, 3e-3)),
    ]  # fmt: skip
    assert side == pytest.approx(math.pi / 2 - math.asin(0.5))
    assert immersion(patches[None])[0] == pytest.approx(math.pi)


def test_a_pass_above_clears_nothing_below():
    high, low = [line((0, 0, 1e-3), (0.05, 0, 1e-3))], [line((0, 0, -1e-3), (0.05, 0, -1e-3))]
    curve = join([*high, *over(end_of(high[0]), low[0].start), *low])
    patches = contacts(curve, np.array([curve.knots[4] + 0.02]), Stock(np.zeros((0, 3)), 2e-3, -0.02))[0][0]
    assert patches[0].tolist() == pytest.approx([0.0, math.pi, 0.0, 2e-3])


def test_ramp_clears_with_its_height():
    """Back along a ramp at its lowest height: where the mill came down, what it left falls away along the rim."""
    ramp = line((0, 0, 0), (0.04, 0, -2e-3))
    back = line((0.04, 0, -2e-3), (0.0, 0, -2e-3))
    curve = join([ramp, back])
    x = np.array([0.039, 0.025, 0.015])
    patches = contacts(curve, curve.knots[1] + 0.04 - x, Stock(np.zeros((0, 3)), 0.0, -0.02))[0]
    # at an angle a off the feed the last disc that came by was R cos a further down the ramp than the mill stands now
    angle = (np.arange(2000) + 0.5) / 2000 * math.pi / 2
    height = [2e-3 - np.minimum(0.05 * place, 2e-3) for place in x]
    assert [removal_area(patches[k : k + 1], R)[0] for k in range(3)] == pytest.approx(
        [2 * R * float((h * np.cos(angle)).mean() * math.pi / 2) for h in height], rel=1e-5
    )


def test_same_way_again_meets_nothing():
    curve = join([line((0, 0), (0.05, 0)), line((0.05, 0), (0, 0))])
    assert not contacts(curve, curve.knots[1] + np.linspace(1e-4, 0.0499, 50))[0].any()


def test_only_the_neighbour_row_counts_in_a_large_program():
    """Rows beyond reach change nothing, however many there are; what the tree costs is in test_stock_dense."""
    lines = []
    for k in range(300):
        a, b = (0.0, 0.2) if k % 2 == 0 else (0.2, 0.0)
        lines += [line((a, 2e-3 * k), (b, 2e-3 * k)), line((b, 2e-3 * k), (b, 2e-3 * (k + 1)))]
    curve = join(lines)
    patches, _, _ = contacts(curve, np.array([curve.knots[301] + 0.1]), radius=3e-3)
    assert immersion(patches)[0] == pytest.approx(math.acos(1 - 2 / 3), abs=1e-12)
