"""Whole programs against their canonical commands.

The lists beside the programs agree with those of LinuxCNC's interpreter (2.9), run on the same programs with the same
tools; only ``tools``, whose variables are in millimetres here and in inches there, and ``plate``, which is APT, do not
come from it.
"""

import re
from pathlib import Path

import pytest

from cutwise.io.program_setup import tool_table
from cutwise.programs import canonical_text
from cutwise.programs.interpreter import reading
from cutwise.programs.rs274 import Rs274
from cutwise.programs.setup import Setup

CASES = Path(__file__).parent / "cases"
PROGRAMS = sorted(path for path in CASES.iterdir() if path.suffix in (".ngc", ".apt"))


def canonical(text, setup=None):
    """Calls of a program, without counter and block number."""
    lines = canonical_text.lines(Rs274(text, "p.ngc", setup or Setup()).commands())
    return [re.sub(r"^ *\d+ N\S* +", "", line) for line in lines]


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_programs(program):
    text = program.read_text()
    tools = tool_table((CASES / "tools.tbl").read_text(), "tools.tbl", text) if program.stem == "tools" else None
    lines = list(canonical_text.lines(reading(text, program.name, Setup(tools=tools)).commands()))
    assert lines == program.with_suffix(".txt").read_text().splitlines()


def test_block_numbers_are_shown_as_written():
    lines = list(canonical_text.lines(Rs274("n7 g0 x1\nn123456x2\nN4.5 x3\n/n8 x4\nx5\nm2", "p").commands()))
    assert [line[6:13] for line in lines[6:11]] == ["N7     ", "N123456", "N4     ", "N8     ", "N..... "]
    assert lines[6].startswith("    7 N7     STRAIGHT_TRAVERSE(1.0000, ")


def test_a_program_without_an_end_says_so_and_one_in_percent_signs_does_not():
    run = Rs274("g0 x1", "p")
    assert [line[13:] for line in canonical_text.lines(run.commands())][-3:] == ["FINISH()", "ON_RESET()", "ON_RESET()"]
    assert "no end" in " ".join(run.notices())
    framed = Rs274("%\ng0 x1\n%\nrubbish", "p")
    assert len(list(framed.commands())) == 1
    assert framed.notices() == ["no G20 or G21: lengths are taken as mm"]


def test_the_order_of_a_block_is_that_of_the_dialect():
    calls = canonical("t1 m6 m3 s500 f30 g1 x1 g90 g21 g17 m8 g64 p.1 m48 (now) m0\nm2")[6:18]
    names = [call.partition("(")[0] for call in calls]
    assert names == [
        "COMMENT", "SET_FEED_RATE", "SET_SPINDLE_SPEED", "SELECT_TOOL", "STOP_SPINDLE_TURNING", "CHANGE_TOOL",
        "START_SPINDLE_CLOCKWISE", "FLOOD_ON", "ENABLE_FEED_OVERRIDE", "ENABLE_SPEED_OVERRIDE", "SELECT_PLANE",
        "USE_LENGTH_UNITS",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("comment", "said"),
    [
        ("(hello)", 'COMMENT("hello")'),
        ("( MSG, mind the clamp)", 'MESSAGE(" mind the clamp")'),
        ("(debug,a #1 b #<none> %d#2 %.2f#2)", 'MESSAGE("a 1.500000 b ###### 3 2.50")'),
        ("(print,x=#1)", "x=1.500000"),
        ("(log,#1)", 'LOG("1.500000")'),
        ("(logopen,file.txt)", 'LOGOPEN("file.txt")'),
        ("; plain", None),
        (";debug,#1", 'MESSAGE("1.500000")'),
        ("(first) (second)", 'COMMENT("second")'),
    ],
)
def test_comments(comment, said):
    calls = canonical(f"#1=1.5 #2=2.5\n{comment}\nm2")[6:-9]
    expected = [] if said is None else [said.replace(" 3 ", " 2 ") if "%d" in comment else said]
    assert calls == expected
