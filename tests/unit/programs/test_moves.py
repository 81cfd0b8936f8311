"""What a block means for the tool: moves in SI, in one frame."""

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cutwise.maths.splines import clamped_knots, point
from cutwise.programs.interpreter import interpret
from cutwise.programs.moves import SPLINE_TOLERANCE
from cutwise.programs.setup import Setup, Tool, WorkSystem

HEAD = "G21 G17 G90 S1000 M3 F600\n"


def moves(text, setup=None, head=HEAD):
    return interpret(head + text, setup=setup or Setup()).moves


def mm(point):
    return pytest.approx([1e-3 * value for value in point], abs=1e-12)


def test_lines_absolute_and_incremental_in_both_units():
    a, b, c = moves("G1 X10 Y5\nG91 X-1 Z2\nG20 G90 X1 F10")
    assert a.end == mm((10, 5, 0))
    assert a.feed == pytest.approx(0.01)
    assert b.end == mm((9, 5, 2))
    assert c.end == mm((25.4, 5, 2))
    assert c.feed == pytest.approx(0.254 / 60)
    assert a.spindle == pytest.approx(1000 * 2 * math.pi / 60)


def test_arcs_by_centre_and_by_radius():
    a, b = moves("G3 X10 Y10 I0 J10\nG2 X20 Y20 R10")
    assert a.centre == mm((0, 10, 0))
    assert a.sweep == pytest.approx(0.5 * math.pi)
    assert b.sweep == pytest.approx(-0.5 * math.pi)
    assert b.centre == mm((20, 10, 0))
    long = moves("G3 X10 Y10 R-10")[0]
    assert long.sweep == pytest.approx(1.5 * math.pi)
    full = moves("G1 X10\nG2 X10 Y0 I-10")[1]
    assert full.sweep == pytest.approx(-2 * math.pi)
    turns = moves("G1 X10\nG3 X10 Y0 Z-3 I-10 P3")[1]
    assert turns.sweep == pytest.approx(6 * math.pi)
    assert turns.end == mm((10, 0, -3))
    absolute = moves("G90.1\nG3 X10 Y10 I0 J10")[0]
    assert absolute.centre == mm((0, 10, 0))


def test_planes():
    arc = moves("G18 G3 X10 Z10 I10 K0\n")[0]
    assert arc.axis == (0.0, 1.0, 0.0)
    assert arc.sweep == pytest.approx(0.5 * math.pi)
    assert moves("G19 G3 Y10 Z10 J0 K10")[0].axis == (1.0, 0.0, 0.0)


def test_drilling_cycles_and_their_return():
    plain = moves("G0 Z20\nG98 G81 X5 Y5 Z-4 R2\nX10\nG80")
    assert [m.kind for m in plain] == ["rapid", "rapid", "rapid", "feed", "rapid", "rapid", "rapid", "feed", "rapid"]
    assert plain[4].end == mm((5, 5, 20))
    assert plain[-2].end == mm((10, 5, -4))
    peck = moves("G0 Z20\nG99 G83 X5 Y5 Z-4 R2 Q2")
    assert [round(1e3 * m.end[2], 3) for m in peck if m.kind == "feed"] == [0.0, -2.0, -4.0]
    assert peck[-1].end == mm((5, 5, 2))
    assert any(m.kind == "dwell" and m.dwell == 0.5 for m in moves("G82 X1 Y1 Z-1 R1 P0.5"))


def test_tapping_leads_along_the_axis_of_its_plane():
    strokes = [m for m in moves("G18 G84 X1 Z2 Y-5 R1") if m.kind == "feed"]
    assert [m.end for m in strokes] == [mm((1, -5, 2)), mm((1, 1, 2))]


def test_the_operator_draws_the_tool_out_after_g88():
    last = moves("G0 Z5\nG88 X1 Z-3 R2 P1")[-1]
    assert (last.kind, last.end) == ("rapid", mm((1, 0, 2)))


def test_path_modes_comments_and_ends():
    text = "(a comment) G61.1 G1 X1 ; rest\n/N20 G64 P0.05 X2\nG64 X3\nM30\nG99 rubbish\n"
    found = interpret(HEAD + text)
    assert [m.mode for m in found.moves] == ["exact_stop", "blend", "blend"]
    assert found.moves[1].tolerance == pytest.approx(0.05e-3)
    assert math.isinf(found.moves[2].tolerance)
    assert "G64 without P" in found.notices[0]
    assert interpret("%\n" + HEAD + "T3 M6\nG1 X1\n%").tools == (3,)


def test_a_cycle_leaves_the_path_mode_as_it_was():
    assert moves("G61.1 G1 X1\nG81 X2 Z-1 R1\nG1 X3")[-1].mode == "exact_stop"
    assert moves("G1 X1\nG81 X2 Z-1 R1\nG1 X3")[-1].mode == "exact_path"
    assert moves("G64 G1 X1\nG81 X2 Z-1 R1\nG1 X3")[-1].mode == "blend"


def test_feeds_per_revolution_by_inverse_time_and_in_step_with_the_spindle():
    per_turn, inverse, threaded = moves("G95 F0.3 G1 X10\nG93 X30 F6\nG94 F100\nG33 Z-2 K1.5")
    assert per_turn.feed == pytest.approx(0.3e-3 * 1000 / 60)
    assert inverse.feed == pytest.approx(20e-3 * 6 / 60)
    assert threaded.feed == pytest.approx(1.5e-3 * 1000 / 60)
    down, up = moves("G33.1 Z-5 K2")
    assert (down.end, up.end, up.feed) == (mm((0, 0, -5)), mm((0, 0, 0)), pytest.approx(2e-3 * 1000 / 60))


def test_rotary_axes_are_carried():
    both, alone, rapid = moves("G1 X10 A90\nA180 B30\nG0 C45")
    assert both.rotary_end == pytest.approx((math.pi / 2, 0, 0))
    assert both.feed == pytest.approx(0.01)
    assert alone.start == alone.end
    assert alone.rotary_start == both.rotary_end
    assert alone.feed == pytest.approx(math.radians(600) / 60)  # degrees per minute, as no other axis moves
    assert rapid.rotary_end == pytest.approx((math.pi, math.pi / 6, math.pi / 4))
    assert math.isinf(rapid.feed)


def test_tools_and_coolant_are_told():
    a, b, c = moves("G1 X1\nT7 M6 M8\nM3 G1 X2\nM7\nM9\nX3")
    assert (a.tool, b.tool) == (1, 7)
    assert (a.coolant, b.coolant, c.coolant) == ("", "flood", "")
    assert moves("M7\nM8\nG1 X1")[0].coolant == "mist flood"


def test_offsets_that_change_do_not_tear_the_path():
    """The tool is where it was when the coordinates change; all moves stand in the frame of the first one."""
    found = moves(
        "G1 X10 Y0\nG92 X0 Y0\nG1 X5\nG92.1\nG10 L2 P2 X20 Y0 R90\nG55\nG1 X5 Y0\nG2 X5 Y-10 I0 J-5\nG54\nG52 Z3\nG1 Z0"
    )
    for before, after in itertools.pairwise(found):
        assert after.start == pytest.approx(before.end, abs=1e-15)
    assert [m.end for m in found] == [
        mm((10, 0, 0)), mm((15, 0, 0)), mm((20, 5, 0)), mm((30, 5, 0)), mm((30, 5, 3)),
    ]  # fmt: skip
    assert found[3].centre == mm((25, 5, 0))
    assert found[3].sweep == pytest.approx(-math.pi)


def test_moves_are_in_the_coordinates_of_the_first_motion():
    """Where the part is clamped does not show; where a second one is does, and where the tool comes from."""
    setup = Setup(
        systems={1: WorkSystem((0.1, 0.2, -0.3)), 2: WorkSystem((0.15, 0.2, -0.3), math.pi / 2)}, start=(0.0, 0.0, 0.05)
    )
    found = moves("G0 X1 Y2\nG1 Z-1\nG55\nG1 X1 Y0 Z-1\n", setup)
    assert found[0].start == mm((0, 0, 50))
    assert found[1].end == mm((1, 2, -1))
    assert found[2].end == mm((50, 1, -1))
    assert moves("G55 G1 X1 Y2", setup)[0].end == mm((1, 2, 50))


def test_machine_coordinates_and_reference_points():
    setup = Setup(systems={1: WorkSystem((0.0, 0.0, -0.1))})
    found = moves("G0 X1 Y1 Z5\nG53 G0 Z-50\nG28.1\nG1 Z-1\nG91 G28 Z4", setup)
    assert found[0].start == mm((0, 0, 100))
    assert found[1].end == mm((1, 1, 50))
    assert [m.end for m in found[-2:]] == [mm((1, 1, 3)), mm((1, 1, 50))]


def test_a_tool_length_moves_nothing():
    setup = Setup(tools={2: Tool(2, 2, (0.0, 0.0, 0.08, *(0.0,) * 6), 0.01)})
    found = moves("G0 Z50\nT2 M6 G43 H2\nG0 Z20\nM3 G1 Z-1", setup)
    assert [(m.start[2], m.end[2]) for m in found] == [
        (0.0, pytest.approx(0.05)), (pytest.approx(0.05), pytest.approx(0.02)), (pytest.approx(0.02), pytest.approx(-1e-3)),
    ]  # fmt: skip


def test_an_arc_as_a_spline_is_an_arc():
    """A quarter circle as a rational quadratic: control point at the corner, weight cos 45 degrees."""
    text = f"G0 X10 Y0 Z1\nG5.2 P1 L3\nX10 Y10 P{math.sqrt(0.5):.15f}\nX0 Y10 P1\nG5.3"
    arc = moves(text)[-1]
    assert arc.kind == "arc"
    assert arc.centre == mm((0, 0, 1))
    assert arc.sweep == pytest.approx(math.pi / 2)


def test_splines_become_lines_within_a_micrometre():
    found = moves("G0 X0 Y0\nG5 X40 Y0 I10 J30 P-10 Q30")
    control = [(0.0, 0.0), (0.01, 0.03), (0.03, 0.03), (0.04, 0.0)]
    knots = clamped_knots(4, 4)
    ends = [(0.0, 0.0), *[(m.end[0], m.end[1]) for m in found]]
    assert 50 < len(found) < 2000
    for i in range(501):
        p = point(control, [1.0] * 4, 4, knots, i / 500)
        assert min(_distance(p, a, b) for a, b in itertools.pairwise(ends)) < SPLINE_TOLERANCE


def _distance(p, a, b):
    dx, dy = b[0] - a[0], b[1] - a[1]
    t = max(0.0, min(1.0, ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / (dx * dx + dy * dy)))
    return math.hypot(p[0] - a[0] - t * dx, p[1] - a[1] - t * dy)


@given(
    st.lists(st.tuples(*[st.floats(-500, 500).map(lambda v: round(v, 4))] * 3), min_size=1, max_size=30),
    st.sampled_from(["G1 ", "", "N5 G1", "g01"]),
)
def test_plain_lines_and_others_are_read_alike(points, word):
    """The quick way for plain motions and the whole machinery (a comment forces it) give the same moves."""
    rows = [f"{word}X{x} Y{y} Z{z}" for x, y, z in points if (x, y, z) != (0.0, 0.0, 0.0)] or ["G1 X1"]
    head = HEAD + "G1 X0.5\n"
    plain = interpret(head + "\n".join(rows)).moves
    commented = interpret(head + "\n".join(row + " (c)" for row in rows)).moves
    assert plain == commented


def test_a_program_without_a_unit_says_what_was_taken():
    assert "no G20 or G21: lengths are taken as mm" in interpret("F100 G1 X1\nM2").notices
    assert not any("G20" in words for words in interpret("G20 F100 G1 X1\nM2").notices)


@pytest.mark.parametrize("block", ["G0 G91 G28 Z0.", "G91 G0 G28 Z0", "G91 G28 G0 Z0"])
def test_a_reference_point_and_a_motion_word_in_one_block(block):
    found = interpret("G21 G90 F300\nG1 X10 Z-5\n" + block + "\nG90 X3").moves
    assert [m.kind for m in found] == ["feed", "rapid", "rapid"]
    assert found[1].end == pytest.approx((10e-3, 0.0, 0.0))
    offset = interpret("G21 G90 F300\nG1 X10\nG0 G92 X0\nX5").moves
    assert (offset[1].kind, offset[1].end[0]) == ("rapid", pytest.approx(15e-3))
