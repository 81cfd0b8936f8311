"""Programs written out: the same moves without loops, calls and variables, and the least feed of all runs no longer."""

import pytest

import cutwise
from cutwise.io.scenario import load
from cutwise.programs.interpreter import interpret
from cutwise.programs.setup import Setup
from cutwise.programs.unroll import unrolled
from cutwise.spec.faults import ScenarioFault

LOOP = """%
(slot in passes)
G21 G90 G94 S6000 M3
#<deep>=0
G0 X-7 Y0 Z5
O101 WHILE [#<deep> LT 2]
#<deep>=[#<deep>+1]
N10 G1 Z[-1.5*#<deep>] F300
N20 G1 X8 F600 (along)
N30 G1 Y4
N40 G0 Z5
N50 G0 X-7 Y0
O101 ENDWHILE
G0 X0 Y20
M2
%
"""
CALLS = """O0001 (MAIN)
G21 G90 G94 G17
T1 M6
S6000 M3
G0 X-7. Y0. Z5.
M98 P2 L3
G0 Z20.
M30
O0002
G91 G1 Z-1. F300.
G90 X8. F600.
G2 X12. Y4. R4.
G0 Z6.
X-7. Y0.
G91 Z-2.
G90
M99
"""
MACRO = """G21 G90 G94 S6000 M3
G0 X0. Y0.
G65 P9 X5. F100.
G65 P9 X9. F200.
M30
O9
#3=#24*2
G1 X#3 F#9
IF [#3 GT 15] GOTO 5
G1 X0.
N5 G0 Y1.
M99
"""


@pytest.mark.parametrize(("text", "repeated"), [(LOOP, 5), (CALLS, 7), (MACRO, 2)])
def test_the_moves_are_those_of_the_program(text, repeated):
    told = unrolled(text, "a.nc", Setup())
    old, new = interpret(text).moves, interpret(told.text).moves
    assert len(old) == len(new)
    for a, b in zip(old, new, strict=True):
        assert a.kind == b.kind
        assert (*a.end, *a.centre, a.feed, a.spindle) == pytest.approx(
            (*b.end, *b.centre, b.feed, b.spindle), abs=1e-12
        )
    assert told.repeated == repeated
    assert not any(sign in told.text for sign in ("#", "M98", "WHILE", "G65"))
    again = unrolled(told.text, "a.nc", Setup())
    assert (again.text, again.repeated) == (told.text, 0)


def test_lines_that_run_once_keep_their_text():
    text = unrolled(LOOP, "a.nc", Setup()).text.split("\n")
    assert text[:4] == ["%", "(slot in passes)", "G21 G90 G94 S6000 M3", "G0 X-7 Y0 Z5"]
    assert text[4:6] == ["G1 Z-1.5 F300.", "G1 X8 F600 (along)"]  # no N word twice
    assert text[-4:] == ["G0 X0 Y20", "M2", "%", ""]
    assert unrolled(CALLS, "a.nc", Setup()).text.startswith("O0001 (MAIN)\n")


def test_what_cannot_be_written_out_is_refused():
    with pytest.raises(ScenarioFault, match="is APT"):
        unrolled("PARTNO/A\nUNITS/MM\nFROM/0,0,0\nFEDRAT/100,MMPM\nGOTO/1,0,0\nFINI\n", "a.apt", Setup())
    offset = "G21 G90\nO1 REPEAT [2]\n#5241=3\nG55 G1 X1 F60\nG54 G1 X0\nO1 ENDREPEAT\nM2\n"
    with pytest.raises(ScenarioFault, match="moves from line 5 on would not be the same"):
        unrolled(offset, "a.nc", Setup())


SCENARIO = """process: mill
program: passes.nc
stock: {x: [0 mm, 60 mm], y: [-10 mm, 40 mm], z: [-20 mm, 0 mm]}
tool: {diameter: 12 mm, flutes: 2, helix: 0 deg, flute_length: 30 mm}
material: {library: al7075t6}
machine: {library: fadal2216, reading: kp_ki_swapped}
correct: {limits: {force_xy_peak: {max: 240 N}}}
"""
PASSES = """G21 G90 G94 S6000 M3
O100 SUB
G0 X-7 Y#1 Z5
G0 Z-3
G1 X8 F600
G0 Z5
O100 ENDSUB
O100 CALL [0]
O100 CALL [-8]
M2
"""


def test_passes_that_differ_get_feeds_of_their_own(tmp_path):
    """A full slot and a side of it by one subroutine: at one feed the slot holds the other up."""
    (tmp_path / "passes.nc").write_text(PASSES, encoding="utf-8")
    (tmp_path / "passes.yaml").write_text(SCENARIO, encoding="utf-8")
    scenario = load(tmp_path / "passes.yaml")
    at_once, alone = (cutwise.correct(scenario, unroll=unroll) for unroll in (False, True))
    assert alone.good, alone.reasons
    assert alone.measures["time_after"].value < at_once.measures["time_after"].value * 0.99
    assert alone.measures["force_xy_peak_after"].value <= 240.0
    assert any("--unroll: 4 lines that run several times are written out" in one for one in alone.told)
    assert "CALL" not in alone.program
    assert interpret(alone.program).moves[-1].end == pytest.approx(interpret(PASSES).moves[-1].end, abs=1e-9)
