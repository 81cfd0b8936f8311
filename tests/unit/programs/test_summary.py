"""What a program amounts to: lengths, extents, time."""

import math

import pytest

from cutwise.programs.interpreter import reading
from cutwise.programs.moves import moves
from cutwise.programs.rs274 import Rs274
from cutwise.programs.setup import Setup
from cutwise.programs.summary import arc_points, as_json, extremes, shown, summarise

PROGRAM = """(MSG, clamp it)
G21 G90 S6000 M3
T3 M6
G0 Z5
G1 Z-1 F100
F600 X60
G3 X60 Y60 I0 J30
G4 P2
G0 Z10
M0
M2
"""


def summary(text, **setup):
    given = Setup(**setup)
    return summarise(reading(text, "p.nc", given), given)


def test_lengths_times_and_extents():
    found = summary(PROGRAM.replace("M6", "M6 M3"))
    arc = math.pi * 0.03
    assert found.feed_length == pytest.approx(0.006 + 0.06 + arc)
    assert found.rapid_length == pytest.approx(0.005 + 0.011)
    assert found.feed_time == pytest.approx(0.006 / (0.1 / 60) + (0.06 + arc) / 0.01)
    assert found.dwell_time == 2.0
    assert found.cycle_time == found.feed_time + 2.0
    assert found.boxes["feed"].high == pytest.approx((0.09, 0.06, 0.005))
    assert found.boxes["rapid"].high == pytest.approx((0.06, 0.06, 0.01))
    assert found.tools == (3,)
    assert found.feeds == pytest.approx((0.1 / 60, 0.01))
    assert found.spindle_speeds == pytest.approx((6000 * 2 * math.pi / 60,))
    assert found.moves == {"rapid": 2, "feed": 2, "arc": 1, "dwell": 1}
    assert [(said.line, said.text) for said in found.messages] == [(1, "clamp it")]
    assert found.stops == 1


def test_what_was_assumed_is_said():
    assert "the program calls no tool; tool 1 is in the spindle (assumed)" in summary("G0 X1\nM2").notices
    assert any("tool 7 is in the spindle (as given)" in n for n in summary("G0 X1\nM2", default_tool=7).notices)
    assert any("no unit word" in n for n in summary("G0 X1\nM2").notices)
    assert any("no start position" in n for n in summary("G0 X1\nM2").notices)
    assert not any("start" in n for n in summary("G0 X1\nM2", start=(0.0, 0.0, 0.1)).notices)
    assert any("G28 goes to a position that was not given" in n for n in summary("G0 X1\nG28\nM2").notices)


def test_text_and_json_tell_the_same():
    found = summary(PROGRAM)
    told = as_json(found)
    assert told["feed_length"] == found.feed_length
    assert told["boxes"]["feed"]["low"][2] == pytest.approx(-1e-3)
    text = shown("p.nc", found)
    for words in (
        "G-code in mm",
        "T3",
        "length: 160.248 mm feed",
        "message in line 1: clamp it",
        "stops for the operator: 1",
    ):
        assert words in text


@pytest.mark.parametrize("words", ["G2 X0 Y0 I7 J3 Z-4 P2", "G3 X9 Y9 R-7", "G18 G2 X3 Z-4 R9", "G19 G3 Y4 Z9 Y-2 R20"])
def test_arcs_lie_within_their_extremes(words):
    words = words.replace("Y4 Z9 Y-2", "Y4 Z9")
    arc = next(m for m in moves(Rs274("G21 G90 F100 G1 X0\n" + words, "p").commands()) if m.kind == "arc")
    corners = list(extremes(arc))
    for p in arc_points(arc, (arc.sweep * k / 500 for k in range(501))):
        for i in range(3):
            assert min(c[i] for c in corners) - 1e-12 <= p[i] <= max(c[i] for c in corners) + 1e-12
    *_, last = arc_points(arc, (arc.sweep,))
    assert last == pytest.approx(arc.end, abs=1e-12)
