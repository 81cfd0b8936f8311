"""Modal state along a program, line by line, against what the words of the program say."""

import doctest

import pytest

from cutwise.programs import modal as module
from cutwise.programs.modal import modal
from cutwise.programs.setup import Setup


def states(*lines, setup=Setup()):  # noqa: B008
    """Words in force behind each line."""
    return {line: told.split() for line, told in modal("\n".join(lines), "a.nc", setup).items()}


def test_examples_of_docstrings():
    assert doctest.testmod(module).failed == 0


def test_every_group_follows_its_words():
    found = states(
        "G21 G90 G40 G61", "T3 M6", "S900 M4 M8", "G18 G0 X1", "X5", "G1 X10 F200", "X20", "X30 F300", "G17 G91 G2 X2 I1",
        "G90 G41 D4 G1 X40 Y9", "G1 X50", "G40 G1 X70 Y30", "G55 G95 G1 X1 F0.2", "M5 M9", "M2",
    )  # fmt: skip
    assert found[2][-3:] == ["M5", "T3", "M9"]
    assert found[3][-4:] == ["S900", "M4", "T3", "M8"]
    assert [found[line][0] for line in (4, 5, 6, 7, 8, 9, 10)] == ["G0", "G0", "G1", "G1", "G1", "G2", "G1"]
    assert [found[line][1] for line in (3, 4, 8, 9)] == ["G17", "G18", "G18", "G17"]
    feeds = ["".join(word for word in found[line] if word[0] == "F") for line in (5, 6, 7, 8, 9)]
    assert feeds == ["", "F200", "F200", "F300", "F300"]
    assert {"G91", "G61", "G94"} <= set(found[9])
    assert ["G41" in found[line] for line in (9, 10, 11, 12)] == [False, True, True, False]
    assert {"G55", "G95", "F0.2", "G40"} <= set(found[13])
    assert found[14][-2:] == ["T3", "M9"]


@pytest.mark.parametrize(
    ("behind", "feed"), [("X1", "F10"), ("G2 X12 I1", "F10"), ("X1 F254", "F254"), ("F254", "F254")]
)
def test_a_feed_stays_as_fast_where_the_unit_changes(behind, feed):
    """254 mm/min are 10 in/min: the number is another, unless F is said again."""
    assert feed in states("G21 G90", "G1 X254 F254", "G20", behind, "M2")[4]


def test_a_line_that_runs_in_several_states_says_so():
    found = modal("#1=100\nO1 repeat [5]\nG91 G1 X1 F#1\n#1=[#1+1]\nO1 endrepeat\nM2", "a.nc", Setup())
    assert found[3].startswith("from run to run: ")
    assert found[3].count(";") == 2
    assert found[3].endswith(" …")


def test_lines_that_do_not_run_and_languages_without_modes():
    found = modal("G21\nO1 if [0]\nG1 X1 F5\nO1 endif\nG1 X2 F7\nM2\nG1 X9", "a.nc", Setup())
    assert 3 not in found
    assert 7 not in found
    assert modal("UNITS/MM\nFEDRAT/100,MMPM\nGOTO/1,2,3\nFINI", "a.apt", Setup()) == {}
