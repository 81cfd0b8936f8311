"""Feeds in the text of a program: the same motion, the feeds that were asked for, and every other byte as it was."""

import math

import numpy as np
import pytest

from cutwise.programs.interpreter import interpret
from cutwise.programs.rewrite import Part, handles, rewritten, with_first_comment, with_speed
from cutwise.programs.setup import Setup, Tool
from cutwise.programs.trace import traced

SETUP = Setup(tools={1: Tool(1, diameter=8e-3)})
HEAD = "G21 G17 G90 G94 G40 G61\nT1 M6\nS8000 M3\nG0 X0 Y0 Z-1\n"


def moves(text, setup=SETUP):
    return interpret(text, "program", setup).moves


def sampled(text, setup=SETUP, step=1e-4):
    """Points along all feed moves, by the way, and the feed there."""
    points, feeds = [], []
    for move in moves(text, setup):
        if move.kind not in ("feed", "arc"):
            continue
        start, end = np.array(move.start), np.array(move.end)
        if move.kind == "arc":
            centre, axis = np.array(move.centre), np.array(move.axis)
            arm = start - centre
            arm = arm - axis * (arm @ axis)
            length = math.hypot(np.linalg.norm(arm) * move.sweep, (end - start) @ axis)
        else:
            length = float(np.linalg.norm(end - start))
        for share in (np.arange(max(2, round(length / step))) + 0.5) / max(2, round(length / step)):
            if move.kind == "arc":
                angle = share * move.sweep
                turned = arm * math.cos(angle) + np.cross(axis, arm) * math.sin(angle)
                points.append(
                    centre + turned + axis * ((end - start) @ axis) * share + axis * ((start - centre) @ axis)
                )
            else:
                points.append(start + share * (end - start))
            feeds.append(move.feed)
    return np.array(points), np.array(feeds)


def corrected(text, wanted, setup=SETUP):
    trace = traced(text, "program", setup)
    return rewritten(trace, wanted, handles(trace))


def line_of(text, part):
    return next(n for n, line in enumerate(text.split("\n"), start=1) if part in line)


CASES = {
    "line": ("F1200\nN10 G1 X10 (along)\nN20 Y5\nM30\n", "X10"),
    "slanting": ("G1 X3.3 Y-7.1 F1200\nX10 Y5\nM30\n", "X3.3"),
    "arc by centre": ("G1 X10 F1200\nG3 X14 Y4 I0 J4 (corner)\nG1 Y10\nM30\n", "G3"),
    "arc by radius": ("G1 X10 F1200\nG2 X14 Y-4 R4\nG1 Y-10\nM30\n", "G2 "),
    "long arc by radius": ("G1 X10 F1200\nG2 X14 Y-4 R-4\nG1 Y-10\nM30\n", "G2 "),
    "full circle": ("G1 X10 F1200\nG3 I-3 J2\nG1 Y-10\nM30\n", "G3"),
    "half named": ("G1 X10 F1200\nG3 Y8 J4\nG1 X0\nM30\n", "G3"),
    "helix": ("G1 X10 F1200\nG3 X14 Y4 Z-3 I0 J4\nG1 Y10\nM30\n", "G3"),
    "other plane": ("G18 G1 X10 F1200\nG2 X14 Z3 I4 K0\nG1 X20\nM30\n", "G2 "),
    "incremental": ("G91 G1 X10 F1200\nG1 X3.3 Y2.2\nG3 X4 Y4 I0 J4\nG1 X-1\nM30\n", "Y2.2"),
    "incremental arc": ("G91 G1 X10 F1200\nG3 X4 Y4 I0 J4\nG1 X-1\nM30\n", "G3"),
    "absolute centre": ("G90.1 G1 X10 F1200\nG3 X14 Y4 I10 J4\nG1 X-1\nM30\n", "G3"),
    "per revolution": ("G95 G1 X10 F0.15\nG1 X20 Y3\nX25\nM30\n", "Y3"),
    "inverse time": ("G93 G1 X10 F60\nG1 X20 Y3 F120\nG3 X24 Y7 I0 J4 F100\nM30\n", "Y3"),
    "inverse time arc": ("G93 G1 X10 F60\nG3 X14 Y4 I0 J4 F100\nG1 X0 F10\nM30\n", "G3"),
    "inch": ("G20 G1 X1 F50\nG1 X2 Y0.3\nX2.5\nM30\n", "Y0.3"),
    "inch arc": ("G20 G1 X1 F50\nG3 X1.2 Y0.2 I0 J0.2\nG1 X0\nM30\n", "G3"),
    "no blanks": ("G1X10F1200\nX20Y3\nY10\nM30\n", "Y3"),
    "decimal points": ("G1 X10. F1200.\nX20. Y3.\nY10.\nM30\n", "Y3."),
    "small letters": ("g1 x10 f1200\nx20 y3\ny10\nm30\n", "y3"),
    "rotated and shifted": ("G10 L2 P2 X5 Y7 Z-1 R30\nG55 G1 X10 F1200\nG1 X20 Y3\nG3 X24 Y7 I0 J4\nM30\n", "Y3"),
    "windows lines": ("G1 X10 F1200\r\nX20 Y3 (a)\r\nY10\r\nM30\r\n", "Y3"),
    "feed on the line": ("G1 X10 F1200\nX20 Y3 F900\nY10\nM30\n", "Y3"),
    "deleted block": ("G1 X10 F1200\nX20 Y3\n/Y5 F700\nY10\nM30\n", "X20"),
}


@pytest.mark.parametrize("name", CASES)
def test_a_split_block_keeps_its_motion_and_its_neighbours_their_feeds(name):
    text, part = HEAD + CASES[name][0], CASES[name][1]
    line = line_of(text, part)
    before = sampled(text)
    of_line = np.concatenate([np.full(k, m.line) for m, k in _counts(text)])
    meant = float(before[1][of_line == line][0])
    new = corrected(text, {line: (Part(0.3, 0.5 * meant), Part(0.7, 0.8 * meant), Part(1.0, 0.4 * meant))})
    points, _ = sampled(new)
    ends, whole = _way(before[0]), _way(points)
    assert whole[-1] == pytest.approx(ends[-1], rel=2e-3)
    for axis in range(3):  # the same place after the same way
        at = np.interp(np.linspace(0, 1, 200), whole / whole[-1], points[:, axis])
        assert at == pytest.approx(np.interp(np.linspace(0, 1, 200), ends / ends[-1], before[0][:, axis]), abs=3e-5)
    assert [m.end for m in moves(text)][-1] == pytest.approx([m.end for m in moves(new)][-1], abs=1e-12)
    other = {round(f, 9) for f in before[1][of_line != line]}
    found = [m.feed for m in moves(new) if m.kind in ("feed", "arc")]
    three = [f for f in found if round(f, 9) not in other]
    unit = 2e-5  # 1 mm/min, or 0.01 in/min
    assert len(three) == 3
    for got, share in zip(three, (0.5, 0.8, 0.4), strict=True):
        assert share * meant - unit <= got <= share * meant * (1 + 1e-5)
    assert {round(f, 9) for f in found} - {round(f, 9) for f in three} == other
    kept = [raw for n, raw in enumerate(text.split("\n"), start=1) if n != line]
    rest = [raw for raw in new.split("\n") if raw in kept]
    assert sum(raw not in rest for raw in kept) <= 1  # the first later block that lived on the feed


def _counts(text):
    for move in moves(text):
        if move.kind in ("feed", "arc"):
            start, end = np.array(move.start), np.array(move.end)
            length = float(np.linalg.norm(end - start))
            if move.kind == "arc":
                axis = np.array(move.axis)
                arm = start - np.array(move.centre)
                arm = arm - axis * (arm @ axis)
                length = math.hypot(np.linalg.norm(arm) * move.sweep, (end - start) @ axis)
            yield move, max(2, round(length / 1e-4))


def _way(points):
    return np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))


def test_split_points_of_a_slanting_line_lie_on_it():
    text = HEAD + "F1200\nG1 X13.37 Y7.77\nM30\n"
    new = corrected(text, {line_of(text, "X13"): tuple(Part((k + 1) / 40, 0.01 + 1e-4 * k) for k in range(40))})
    ends = np.array([m.end for m in moves(new) if m.kind == "feed"])
    off = (ends[:, 0] * 7.77 - ends[:, 1] * 13.37) / math.hypot(7.77, 13.37)
    assert np.abs(off).max() < 1e-9  # [m]: no joint turns so far that a motion would stop


def test_compensated_contours_are_split_on_the_contour():
    text = HEAD + "F1200\nG41 D1 G1 X20 Y10\nG1 X60\nG3 X70 Y20 I0 J10\nG1 Y40\nX20\nY10\nG40 X0 Y0\nM30\n"
    line, arc = line_of(text, "G1 X60"), line_of(text, "G3")
    new = corrected(text, {line: (Part(0.25, 0.01), Part(1.0, 0.02)), arc: (Part(0.5, 0.015), Part(1.0, 0.03))})
    assert "G1 X" in new
    before, after = sampled(text)[0], sampled(new)[0]
    nearest = [np.min(np.linalg.norm(before - p, axis=1)) for p in after[::7]]
    assert max(nearest) < 6e-5  # half the distance of the points
    feeds = [round(m.feed, 9) for m in moves(new) if m.line and m.kind in ("feed", "arc")]
    assert feeds.count(0.01) == 2  # the arc round the corner before it belongs to the first part
    assert feeds.count(0.015) == feeds.count(0.03) == 1
    places = [m.end for m in moves(new) if round(m.feed, 9) == 0.01 and m.kind == "feed"]
    whole = [m for m in moves(text) if m.line == line]
    start, end = np.array(whole[-1].start), np.array(whole[-1].end)
    assert np.array(places[0]) == pytest.approx(start + 0.25 * (end - start), abs=1e-9)


def test_a_modal_feed_stays_what_it_is_behind_a_change_of_units():
    text = HEAD + "F1200\nG1 X10\nG20\nX1\nX2\nM30\n"
    new = corrected(text, {line_of(text, "G1 X10"): (Part(1.0, 0.01),)})
    assert [m.feed for m in moves(new) if m.kind == "feed"] == pytest.approx([0.01, 0.02, 0.02], rel=1e-9)


@pytest.mark.parametrize("mark", ["/", " /"])
@pytest.mark.parametrize("left", ["{}G1 X11", "{}G1 X11 F300", "{0}G1 X11 F300\n{0}X12"])
def test_the_feed_behind_blocks_that_may_be_left_out_is_the_one_it_was_either_way(mark, left):
    text = HEAD + f"F300\nG1 X10\n{left.format(mark)}\nG1 Z-3\nG1 X20 F900\nX30\nM30\n"
    new = corrected(text, {line_of(text, "X10"): (Part(1.0, 0.1),)})
    for one in (new, "\n".join(line for line in new.split("\n") if not line.strip().startswith("/"))):
        down = next(n for n, line in enumerate(one.split("\n"), start=1) if "Z-3" in line)
        assert [m.feed for m in moves(one) if m.line == down] == pytest.approx([0.005], rel=1e-9)


def test_a_feed_of_a_block_that_may_be_left_out_changes_no_line_behind_it():
    text = HEAD + "F300\nG1 X10\n/G1 X11 F200\nX12\nG1 X20 F900\nX30\nM30\n"
    new = corrected(text, {line_of(text, "X30"): (Part(1.0, 0.1),)})
    assert new == text.replace("X30", "X30 F6000")


LOOPS = {
    "repeat": "F1200\nO1 repeat [3]\nG91 G1 X1\nY0.5\nO1 endrepeat\nG90 G1 X30\nM30\n",
    "sub": "O1 sub\nG91 G1 X1\nY0.5\nG90\nO1 endsub\nF1200\nO1 call\nF600\nO1 call\nG1 X30\nM30\n",
    "while": "F1200\n#1=0\nO1 while [#1 LT 3]\nG1 X[#1+1]\nY2\nY0\n#1=[#1+1]\nO1 endwhile\nG1 X30\nM30\n",
}


@pytest.mark.parametrize("name", LOOPS)
def test_lines_that_run_several_times_get_one_feed_and_the_others_keep_theirs(name):
    text = HEAD + LOOPS[name]
    trace = traced(text, "program", SETUP)
    known = handles(trace)
    line = line_of(text, "Y0.5" if name != "while" else "Y2")
    assert known[line].change
    assert not known[line].split
    assert known[line].why.startswith("it runs")
    new = corrected(text, {line: (Part(1.0, 0.005),)})
    old, found = moves(text), moves(new)
    assert len(old) == len(found)
    for a, b in zip(old, found, strict=True):
        assert b.end == pytest.approx(a.end, abs=1e-12)
        if a.kind == "feed":
            assert b.feed == pytest.approx(0.005 if a.line == line else a.feed, rel=1e-9)


def test_a_feed_from_a_variable_becomes_a_number_and_the_original_a_comment():
    text = HEAD + "#100=1200\nG1 X10 F#100\nY10\nM30\n"
    new = corrected(text, {line_of(text, "F#100"): (Part(1.0, 0.01),)})
    assert "G1 X10 F600 (was F#100)" in new
    assert [m.feed for m in moves(new) if m.kind == "feed"] == pytest.approx([0.01, 0.02])


@pytest.mark.parametrize(
    ("block", "why"),
    [
        ("G81 X5 Y5 Z-3 R1", "canned cycle"), ("G38.2 X5", "probing"), ("G33 X5 K1", "thread"),
        ("/G1 X5", "leave out"), ("G1 X[3+2]", "expressions"), ("G1 X5 M8", "besides"), ("G1 X5 A10", "besides"),
    ],
)  # fmt: skip
def test_what_cannot_be_split_says_why(block, why):
    text = HEAD + f"F1200\n{block}\nG80 G1 X30\nM30\n"
    found = handles(traced(text, "program", SETUP))[line_of(text, block)]
    assert why in found.why
    assert not found.split


def test_nothing_asked_for_is_nothing_changed():
    for text in (HEAD + case for case, _ in CASES.values()):
        assert corrected(text, {}) == text


def test_the_speed_is_written_wherever_it_stands():
    text = HEAD.replace("S8000 M3", "S8000. M3 (fast)") + "G1 X10 F1200\n#1=9000\nS#1\nX20\nM30\n"
    new, count = with_speed(traced(text, "program", SETUP), 9700.0)
    assert count == 2
    assert "S9700. M3 (fast)" in new
    assert "S9700 (was S#1)" in new


def test_the_first_comment_stands_behind_the_opening_line_and_has_no_brackets_of_its_own():
    assert with_first_comment("%\nG21\n%\n", "misses 3 (of 4)\n") == "%\n(misses 3 [of 4] )\nG21\n%\n"
