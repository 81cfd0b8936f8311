"""Chords in place of lines and arcs: in the coordinates of the program that they stand in, and what they cannot stand for."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from cutwise.programs.setup import Setup
from cutwise.programs.trace import traced
from cutwise.study.correct.chorded import Stretch, rewritten, writable

MM = 1e-3
HEAD = "G21 G17 G90 G61\nS8000 M3\nG0 X10 Y0 Z5\nG1 Z-5 F300\n"
TAIL = "G0 Z5\nM2\n"
ENDS = np.array([[20.0, 0.0], [25.0, 0.001], [30.0, 0.0], [33.0, 1.17], [34.0, 4.002], [34.0, 20.0]]) * MM
PLAIN = "G1 X30 F2400\nG3 X34 Y4 I0 J4\nG1 Y20\n"


def chorded(text, lines=(5, 5, 5, 6, 6, 7)):
    trace = traced(text, "p.nc", Setup())
    stretch = Stretch(np.array(lines), ENDS, 5e-7)
    path = SimpleNamespace(source=np.array([3, 4, *lines, lines[-1] + 1]))
    kept, faults = writable(trace, path, [stretch])
    return faults or rewritten(trace, path, kept, 4, moded=False)


def read(text):
    """Where each motion in the plane ends [mm], by a reader of its own: G20, G21, G90, G91, G92."""
    unit, steps, at, zero, ends = 1.0, False, np.zeros(2), np.zeros(2), []
    for raw in text.split("\n"):
        words = [
            (letter, float(value)) for letter, value in re.findall(r"([A-Z]) *([-+.0-9]+)", re.sub(r"\(.*?\)", "", raw))
        ]
        codes = [value for letter, value in words if letter == "G"]
        unit = 25.4 if 20.0 in codes else 1.0 if 21.0 in codes else unit
        steps = True if 91.0 in codes else False if 90.0 in codes else steps
        told = {letter: value * unit for letter, value in words if letter in "XY"}
        if 92.0 in codes:
            zero = at - [told["X"], told["Y"]]
        elif told:
            base = at if steps else zero
            at = np.array([base[k] + told[axis] if axis in told else at[k] for k, axis in enumerate("XY")])
            ends.append(at)
    return np.array(ends)


WAYS = {
    "absolute": HEAD + PLAIN + TAIL,
    "increments": HEAD + "G91 G1 X20 F2400\nG3 X4 Y4 I0 J4\nG1 Y16\nG90 " + TAIL,
    "other zero": HEAD.replace("F300", "F300\nG92 X5 Y70\nG1 X6") + "G1 X25 F2400\nG3 X29 Y74 J4\nG1 Y90\n" + TAIL,
    "inches": "G20 G17 G90 G61\nS8000 M3\nG0 X.3937007874 Y0 Z.2\nG1 Z-.2 F12\nG1 X1.1811023622 F94\nG3 X1.3385826772 "
    "Y.1574803150 I0 J.1574803150\nG1 Y.7874015748\nG0 Z.2\nM2\n",
}


@pytest.mark.parametrize("way", WAYS)
def test_chords_stand_where_they_are_meant_in_any_coordinates(way):
    other = way == "other zero"
    text = chorded(WAYS[way], (7, 7, 7, 8, 8, 9) if other else (5, 5, 5, 6, 6, 7))
    found = read(text)[(2 if other else 1) :][: len(ENDS)]
    assert found == pytest.approx(ENDS / MM, abs=1e-4 if way == "inches" else 1e-9)
    assert [line for line in text.split("\n") if line.startswith("G64")] == [
        f"G64 P{'0.000020' if way == 'inches' else '0.0005'}"
    ]


def test_increments_behind_a_stretch_stand_where_they_stood():
    text = WAYS["increments"].replace("G90 G0", "X1\nG90 G0")
    assert read(chorded(text))[-1] == pytest.approx([35.0, 20.0], abs=1e-6)


def test_lines_end_as_they_did_and_other_words_stay():
    text = chorded((HEAD + "N7 G1 X30 F2400 (wall)\nG64 G3 X34 Y4 I0 J4\nG1 Y20\n" + TAIL).replace("\n", "\r\n"))
    assert all(line.endswith("\r") for line in text.split("\n")[:-1])
    lines = text.replace("\r", "").split("\n")
    assert lines[4:6] == ["G64 P0.0005", "N7 G1 X20.0000 Y0.0000 F2400 (wall)"]
    assert "G1 X33.0000 Y1.1700" in lines, "the path mode of the second line does not end that of the chords"
    assert lines[-4:] == ["G64", "G0 Z5", "M2", ""], "the path mode of the program is in force again"


def test_a_path_mode_between_the_lines_of_a_stretch_waits_for_its_end():
    text = chorded(HEAD + "G1 X30 F2400\nG61.1\nG3 X34 Y4 I0 J4\nG1 Y20\n" + TAIL, (5, 5, 5, 7, 7, 8)).split("\n")
    assert text[text.index("G61.1") + 1] == "G64 P0.0005"


def test_a_circle_behind_a_stretch_gets_its_motion():
    text = chorded(HEAD + PLAIN.replace("G1 Y20", "G3 X34 Y20 J8") + "I5 J0\n" + TAIL)
    assert "G3 I5 J0" in text


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("G1 X#1", "expressions"),
        ("G1 X[20+10]", "expressions"),
        ("/G1 X30", "leave out"),
        ("G1 X30 M0", "words besides"),
        ("G93 G1 X30 F240", "inverse time"),
        ("G41.1 D2 G1 X30", "words besides"),
        ("G53 G1 X30", "words besides"),
    ],
)
def test_lines_that_chords_cannot_stand_for_are_named(line, why):
    text = (
        HEAD.replace("S8000", "#1=30\nS8000")
        + f"{line}{'' if 'F' in line else ' F2400'}\n{PLAIN.split(chr(10), 1)[1]}{TAIL}"
    )
    if "G93" in line:
        text = text.replace("J4\n", "J4 F100\n").replace("Y20\n", "Y20 F100\n")
    faults = chorded(text, (6, 6, 6, 7, 7, 8))
    assert not isinstance(faults, str)
    assert why in faults[0].message
    assert faults[0].message.startswith("line 6 of the program")


@pytest.mark.parametrize(
    ("before", "why"),
    [("G41.1 D2 X15", "compensation"), ("G10 L2 P1 R30\nG1 X12 Y0", "turned")],
    ids=["radius", "turned"],
)
def test_coordinates_that_are_not_those_of_the_tool_are_named(before, why):
    first = HEAD.count("\n") + before.count("\n") + 2
    faults = chorded(HEAD + before + "\n" + PLAIN + TAIL, (first, first, first, first + 1, first + 1, first + 2))
    assert why in faults[0].message


def test_lines_of_a_subroutine_are_named():
    text = HEAD + "O1 sub\n" + PLAIN + "O1 endsub\nO1 call\n" + TAIL
    assert "stands in a subroutine" in chorded(text, (6, 6, 6, 7, 7, 8))[0].message


def test_a_line_that_runs_several_times_is_named_once():
    text = HEAD + "o1 sub\nG1 X40 F1200\nG0 X10\no1 endsub\no1 call\no1 call\n" + TAIL
    line = text.split("\n").index("G1 X40 F1200") + 1
    stretch = Stretch(np.array([line]), np.array([[20.0, 0.0], [40.0, 0.0]]) * MM, 5e-7)
    kept, faults = writable(
        traced(text, "p.nc", Setup()), SimpleNamespace(source=np.array([line, line])), [stretch, stretch]
    )
    assert not kept
    assert ["runs 2 times" in fault.message for fault in faults] == [True]
