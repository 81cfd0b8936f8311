"""Cutter compensation: the path of the tool centre runs at its radius beside the contour."""

import itertools
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cutwise.programs.interpreter import interpret
from cutwise.programs.summary import arc_points
from cutwise.spec.faults import ScenarioFault

HEAD = "G21 G17 G90 S1000 M3 F600\n"


def path(text):
    return interpret(HEAD + text).moves


def points(move):
    if move.kind == "arc":
        return [(x, y) for x, y, _ in arc_points(move, (move.sweep * k / 40 for k in range(41)))]
    return [tuple(a + (b - a) * k / 40 for a, b in zip(move.start[:2], move.end[:2], strict=True)) for k in range(41)]


def distance(p, contour):
    return min(_from_segment(p, a, b) for a, b in itertools.pairwise(contour))


def _from_segment(p, a, b):
    dx, dy = b[0] - a[0], b[1] - a[1]
    t = max(0.0, min(1.0, ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / (dx * dx + dy * dy)))
    return math.hypot(p[0] - a[0] - t * dx, p[1] - a[1] - t * dy)


@settings(deadline=None)
@given(
    headings=st.lists(st.floats(-1.4, 1.4), min_size=1, max_size=6),
    radius=st.floats(0.1, 1.0),
    word=st.sampled_from(["G41.1", "G42.1"]),
)
def test_the_tool_keeps_its_radius_from_the_contour(headings, radius, word):
    """Edges of 20 mm with any corners between them, all leading to the right: no point of the path comes nearer."""
    at = (0.0, 0.0)
    contour = [at]
    for heading in [0.0, *headings]:
        at = (at[0] + 20.0 * math.cos(heading), at[1] + 20.0 * math.sin(heading))
        contour.append(at)
    rows = [f"G1 X{x:.9f} Y{y:.9f}" for x, y in contour[1:]]
    side = 1.0 if word == "G41.1" else -1.0
    found = path(f"G0 X-20 Y0\n{word} D{2 * radius:.9f}\nG1 X0 Y0\n" + "\n".join(rows) + "\nG40\n")
    contour_m = [(1e-3 * x, 1e-3 * y) for x, y in contour]
    gaps = [distance(p, contour_m) for move in found[2:] for p in points(move)]
    kink = radius * 1e-3 * (1 - math.cos(0.05)) + 1e-9  # corners of less than 0.05 rad are left as they are
    assert min(gaps) > radius * 1e-3 - kink
    assert found[2].start[1] == pytest.approx(side * radius * 1e-3, abs=radius * 2e-3)


def test_convex_corners_are_rounded_and_concave_ones_cut_short():
    entry, edge, corner, last, _ = path("G0 X-10 Y0\nG41.1 D4\nG1 X0\nX20\nY-20\nG40\nG1 X0")[1:]
    assert entry.end[:2] == pytest.approx((0.0, 2e-3))
    assert edge.end[:2] == pytest.approx((20e-3, 2e-3))
    assert (corner.kind, corner.centre[:2]) == ("arc", pytest.approx((20e-3, 0.0)))
    assert corner.sweep == pytest.approx(-math.pi / 2)
    assert last.end[:2] == pytest.approx((22e-3, -20e-3))
    inner = path("G0 X-10 Y0\nG41.1 D4\nG1 X0\nX20\nY20\nG40\nG1 X0")
    assert inner[2].end[:2] == pytest.approx((18e-3, 2e-3))


def test_arcs_grow_outside_and_shrink_inside():
    outside = path("G0 X-10 Y0\nG42.1 D4\nG1 X0\nG3 X10 Y10 I0 J10\nG40\nG1 X0")[2]
    inside = path("G0 X-10 Y0\nG41.1 D4\nG1 X0\nG3 X10 Y10 I0 J10\nG40\nG1 X0")[2]
    assert math.dist(outside.end, outside.centre) == pytest.approx(12e-3)
    assert math.dist(inside.end, inside.centre) == pytest.approx(8e-3)


def test_moves_across_the_plane_follow_the_corner():
    """A plunge before a concave corner happens where the tool stops, not where the edge ends."""
    found = path("G0 X-10 Y0\nG41.1 D4\nG1 X0\nX20\nZ-5\nY20\nG40\nG1 X0")
    plunge = next(move for move in found if move.start[2] != move.end[2])
    assert plunge.end == pytest.approx((18e-3, 2e-3, -5e-3))


def test_tool_diameters_come_from_the_table_and_a_negative_one_changes_sides():
    left = path("G0 X-10 Y0\nG41.1 D4\nG1 X0\nX20\nG40\nG1 X30")
    right = path("G0 X-10 Y0\nG42.1 D-4\nG1 X0\nX20\nG40\nG1 X30")
    assert left == right


def test_a_corner_that_cannot_be_reached_says_which():
    with pytest.raises(ScenarioFault, match=r"p\.nc:5:1: concave corner that a tool of radius 2"):
        interpret(HEAD + "G41.1 D4\nG1 X20\nY1\nX0\nG40", "p.nc")


@pytest.mark.parametrize(
    ("behind", "end"),
    [
        ("G40\nG1 X30", (30, 0, 5)),
        ("G40 G1 X30", (30, 0, 5)),
        ("G40\nZ10", (20, 0, 10)),
        ("G40\nG91 X10", (30, 0, 5)),
        ("G40\nG0 G53 X30", (30, 0, 5)),
        ("G40\nG81 Z-1 X30 R1", (30, 0, 1)),
        ("G40\nG28 Z5", (20, 0, 0)),
    ],
)
def test_after_compensation_axes_that_are_not_named_go_back_to_the_contour(behind, end):
    found = path("G0 X0 Y0 Z5\nG41.1 D4 G1 X10 Y0\nG1 X20\n" + behind)
    assert found[2].end == pytest.approx((20e-3, 2e-3, 5e-3))  # beside it, before
    assert found[-1].end == pytest.approx([1e-3 * value for value in end], abs=1e-12)


def test_in_the_other_plane_too():
    found = interpret("G21 G90 G18 F300\nG0 X0 Y0 Z0\nG42.1 D4 G1 Z10\nZ20\nG40\nG1 Z30").moves
    assert found[-2].end[0] == pytest.approx(2e-3) or found[-2].end[0] == pytest.approx(-2e-3)
    assert found[-1].end == pytest.approx((0.0, 0.0, 30e-3))
