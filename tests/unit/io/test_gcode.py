"""G-code: what a block means, and that nothing is skipped in silence."""

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cutwise.io.programs.interpreter import interpret
from cutwise.spec.faults import ScenarioFault

HEAD = "G21 G17 G90 S1000 M3 F600\n"


def moves(text):
    return interpret(HEAD + text).moves


def faults(text):
    with pytest.raises(ScenarioFault) as found:
        interpret(text, "p.nc")
    return [str(fault) for fault in found.value.faults]


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


def test_path_modes_comments_and_ends():
    text = "(a comment) G61.1 G1 X1 ; rest\n/N20 G64 P0.05 X2\nG64 X3\nM30\nG99 rubbish\n"
    found = interpret(HEAD + text)
    assert [m.mode for m in found.moves] == ["exact_stop", "blend", "exact_path"]
    assert found.moves[1].tolerance == pytest.approx(0.05e-3)
    assert "G64 without P" in found.notices[0]
    assert interpret("%\n" + HEAD + "T3 M6\nG1 X1\n%").tools == (3,)


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("G1 X1", "p.nc:1:4", "without a feed"),
        ("F1 G1 X1\nG5 X2", "p.nc:2:1", "G5 is unknown"),
        ("F1 G1 X1\nG1 X#3", "p.nc:2:4", "variables"),
        ("F1 G1 X1\n#1=2", "p.nc:2:1", "variables"),
        ("F1 G1 X1\no100 sub", "p.nc:2:1", "subroutines"),
        ("F1 G1 X1\nG1 G2 X2", "p.nc:2:4", "one modal group"),
        ("F1 G1 X1\nX2 X3", "p.nc:2:4", "twice"),
        ("F1 G1 X1\nX2 (open", "p.nc:2:4", "closing bracket"),
        ("F1 G1 X1\nA90", "p.nc:2:1", "rotary"),
        ("F1 G1 X1\nM98 P1", "p.nc:2:1", "M98"),
        ("F1 G1 X1\nG2 X5", "p.nc:2:4", "without a centre"),
        ("F1 G1 X1\nG2 X5 I1 R2", "p.nc:2:10", "both R and a centre"),
        ("F1 G1 X1\nG2 X5 I1", "p.nc:2:4", "not on its circle"),
        ("F1 G1 X1\nG2 X50 R2", "p.nc:2:8", "more than twice the radius"),
        ("F1 G1 X1\nG17 G2 X5 K2 I2", "p.nc:2:11", "not in the plane"),
        ("F1 G1 X1\nG81 X2 Z-1", "p.nc:2:5", "needs Z and R"),
        ("F1 G1 X1\nG83 X2 Z-1 R1", "p.nc:2:5", "peck"),
        ("F1 G1 X1\nG4", "p.nc:2:1", "needs a time"),
        ("F1 G1 X1\nG80 X1", "p.nc:2:5", "cancelled"),
        ("F1 G1 X1\nX-", "p.nc:2:1", "no number"),
        ("F1 G1 X1\nG41 D1", "p.nc:2:1", "G41"),
        ("F1 G1 X1\nX2 R3", "p.nc:2:4", "no meaning"),
        ("F0 G1 X1", "p.nc:1:1", "positive"),
        ("F1 G1 X1\n*", "p.nc:2:1", "not G-code"),
        ("G0 X1", "p.nc", "nothing would be cut"),
    ],
)
def test_faults_name_their_place(text, place, words):
    found = faults(text)
    assert any(line.startswith(place + ":") and words in line for line in found), found


def test_all_faults_at_once():
    assert len(faults("G1 X1\nG5 X1\nX#3\nM99")) == 4


@given(st.text(alphabet="GMXYZIJKRFSTNPQHDOA0123456789.-+ ()/;%#\n", max_size=120))
def test_any_text_is_read_or_refused_in_words(text):
    with contextlib.suppress(ScenarioFault):  # any other exception is a failure
        interpret(text)
