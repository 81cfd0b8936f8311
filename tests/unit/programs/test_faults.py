"""What cannot be run is named, with file, line and column; nothing is skipped in silence."""

import contextlib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cutwise.io.program_setup import setup_of
from cutwise.programs import canonical_text
from cutwise.programs.interpreter import interpret, reading
from cutwise.programs.rs274 import MOST_FAULTS, Rs274
from cutwise.programs.setup import Setup, Tool
from cutwise.spec.faults import ScenarioFault
from cutwise.spec.program import Program


def faults(text, setup=None):
    with pytest.raises(ScenarioFault) as found:
        interpret(text, "p.nc", setup or Setup())
    return [str(fault) for fault in found.value.faults]


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("G1 X1", "p.nc:1:4", "without a feed"),
        ("F1 G1 X1\nG12 X2", "p.nc:2:1", "G12 is unknown"),
        ("F1 G1 X1\nG76 X2", "p.nc:2:1", "lathes"),
        ("F1 G1 X1\nG7", "p.nc:2:1", "lathes"),
        ("F1 G1 X1\nM77", "p.nc:2:1", "M77 is unknown"),
        ("F1 G1 X1\nM101", "p.nc:2:1", "for the user to define"),
        ("F1 G1 X1\nG1 G2 X2", "p.nc:2:4", "one modal group"),
        ("F1 G1 X1\nM3 M4", "p.nc:2:4", "one modal group"),
        ("F1 G1 X1\nX2 X3", "p.nc:2:4", "twice"),
        ("F1 G1 X1\nX2 (open", "p.nc:2:4", "closing bracket"),
        ("F1 G1 X1\nX2 (a (b) c)", "p.nc:2:7", "comment within a comment"),
        ("F1 G1 X1\nM98 P1", "p.nc:2:1", "no program O1"),
        ("F1 G1 X1\nM98", "p.nc:2:1", "number of a program P"),
        ("F1 G1 X1\nG2 X5", "p.nc:2:4", "without a centre"),
        ("F1 G1 X1\nG2 X5 I1 R2", "p.nc:2:10", "both R and a centre"),
        ("F1 G1 X1\nG2 X5 I1", "p.nc:2:4", "not on its circle"),
        ("F1 G1 X1\nG2 X50 R2", "p.nc:2:8", "more than twice the radius"),
        ("F1 G1 X1\nG17 G2 X5 K2 I2", "p.nc:2:11", "not in the plane"),
        ("F1 G1 X1\nG2 X1 I0", "p.nc:2:7", "without a radius"),
        ("F1 G1 X1\nG2 X5 I2 P0", "p.nc:2:10", "1 or more"),
        ("F1 G1 X1\nG81 X2 Z-1", "p.nc:2:5", "needs Z and R"),
        ("F1 G1 X1\nG83 X2 Z-1 R1", "p.nc:2:5", "peck"),
        ("F1 G1 X1\nG82 X2 Z-1 R1", "p.nc:2:5", "dwell time P"),
        ("F1 G1 X1\nG81 X2 Z3 R1", "p.nc:2:11", "below the bottom"),
        ("F1 G1 X1\nG81 X2 Z-1 R1 L0", "p.nc:2:15", "0 times"),
        ("F1 G1 X1\nG84 X2 Z-1 R1", "p.nc:2:5", "turning by M3"),
        ("F1 G1 X1\nG4", "p.nc:2:1", "needs a time"),
        ("F1 G1 X1\nG80 X1", "p.nc:2:5", "cancelled"),
        ("X1", "p.nc:1:1", "no motion is in force"),
        ("F1 G1 X1\nX-", "p.nc:2:1", "no number"),
        ("F1 G1 X1\nX2 R3", "p.nc:2:4", "no meaning"),
        ("F1 G1 X1\nX2 Q3", "p.nc:2:4", "no meaning"),
        ("F0 G1 X1", "p.nc:1:1", "positive"),
        ("F-1 G1 X1", "p.nc:1:1", "not be negative"),
        ("S-1 F1 G1 X1", "p.nc:1:1", "M4 turns to the left"),
        ("F1 G1 X1\n*", "p.nc:2:1", "not G-code"),
        ("F1 G1 X1\nX2 N5", "p.nc:2:4", "beginning of its line"),
        ("F1 G1 X1\n$1", "p.nc:2:1", "several spindles"),
        ("F1 G1 X1\nG28 G2 X2", "p.nc:2:5", "both want the axis words"),
        ("F1 G1 X1\nG10 L3", "p.nc:2:5", "L1, L2, L10, L11 or L20"),
        ("F1 G1 X1\nG10 L2 P12", "p.nc:2:8", "coordinate system P"),
        ("F1 G1 X1\nG91 G53 G0 X1", "p.nc:2:5", "absolute distances"),
        ("F1 G1 X1\nM72", "p.nc:2:1", "nothing was saved"),
        ("F1 G1 X1\nG33 Z-1 K1", "p.nc:2:1", "turning spindle"),
        ("F1 G1 X1\nG5.3", "p.nc:2:1", "G5.2"),
        ("F1 G1 X1\nG5.2 X2 Y1\nG1 X3", "p.nc:3:1", "not closed"),
        ("F1 G1 X1\nG91 @1 ^0\nG90 @0 ^0\nG91 @1", "p.nc:4:5", "origin"),
        ("F1 G1 X1\nG1 @1 X2", "p.nc:2:7", "mixed with polar"),
        ("G0 X1", "p.nc", "nothing would be cut"),
        ("F1 G1 X1\n(abort,wrong tool)", "p.nc:2:1", "aborts: wrong tool"),
        # values
        ("F1 G1 X#<none>", "p.nc:1:8", "no value"),
        ("F1 G1 X[1/0]", "p.nc:1:10", "division by zero"),
        ("F1 G1 X[1+", "p.nc:1:10", "expected a number"),
        ("F1 G1 X[1+2", "p.nc:1:8", "closing ]"),
        ("F1 G1 XSQRT[-1]", "p.nc:1:8", "square root"),
        ("F1 G1 XLN[0]", "p.nc:1:8", "logarithm"),
        ("F1 G1 XACOS[2]", "p.nc:1:8", "between -1 and 1"),
        ("F1 G1 XATAN[1]", "p.nc:1:8", "two arguments"),
        ("F1 G1 XFOO[1]", "p.nc:1:7", "no number"),
        ("F1 G1 X[[0-8]**0.5]", "p.nc:1:14", "whole powers"),
        ("F1 G1 X1\n#9999=1", "p.nc:2:1", "5601"),
        ("F1 G1 X1\n#5400=1", "p.nc:2:1", "cannot be assigned"),
        ("F1 G1 X1\n#<_x>=1", "p.nc:2:1", "cannot be assigned"),
        ("F1 G1 XEXISTS[1]", "p.nc:1:14", "EXISTS asks"),
        ("F1 G1 X[2**9999]", "p.nc:1:10", "infinite"),
        # flow
        ("F1 G1 X1\no100 sub", "p.nc:2:1", "without its endsub"),
        ("F1 G1 X1\no100 endsub", "p.nc:2:1", "without its sub"),
        ("F1 G1 X1\no100 if [1]", "p.nc:2:1", "without its endif"),
        ("F1 G1 X1\no100 foo", "p.nc:2:6", "unknown flow control"),
        ("F1 G1 X1\no100 call", "p.nc:2:1", "no subroutine 100"),
        ("F1 G1 X1\no100 break", "p.nc:2:1", "outside of a while"),
        ("F1 G1 X1\no1 sub\no2 sub\no2 endsub\no1 endsub", "p.nc:2:1", "another subroutine, in line 3"),
        ("F1 G1 X1\no1 if [1]\no1 endif\no1 repeat [2]\no1 endrepeat", "p.nc:4:1", "in use already, in line 2"),
        ("F1 G1 X1\no1 if [#<none>]\no1 endif", "p.nc:2:8", "no value"),
        ("F1 G1 X1\no1 while [1] [2]\no1 endwhile", "p.nc:2:1", "one value"),
        ("F1 G1 X1\nO1\nG0\nO2 sub\nO2 endsub", "p.nc:4:1", "numbered main program"),
        ("F1 G1 X1\nM98 P1\nM2\nO1 sub\nO1 endsub", "p.nc:2:1", "O1 call"),
        ("F1 G1 X1\nO1 call\nM2\nO1\nM99", "p.nc:2:1", "M98 P1"),
        ("F1 G1 X1\no1 sub\nM99\no1 endsub\no1 call", "p.nc:3:1", "endsub or return"),
        # compensation
        ("F1 G1 X1\nG41.1", "p.nc:2:1", "diameter"),
        ("F1 G19 G41.1 D1 G1 X1", "p.nc:1:8", "XY or XZ"),
        ("F1 G41.1 D1\nG42.1 D1", "p.nc:2:1", "on already"),
        ("F1 G41.1 D4\nG1 X1", "p.nc:2:4", "not longer than the tool radius"),
        ("F1 G41.1 D1\nG1 X5\nG40\nG2 X6 I0.5", "p.nc:4:1", "must be straight"),
        ("F1 G41.1 D1\nG1 X5\nY0.1\nX1\nG40", "p.nc:4:1", "without cutting into the contour"),
        ("F1 G41.1 D4\nG1 X5\nG3 X6 Y1 I0 J1", "p.nc:3:4", "not larger than the tool radius"),
        ("F1 G41.1 D1\nG54\nG55", "p.nc:2:1", "cannot change"),
        ("F1 G41.1 D1\nG81 X1 Z-1 R0", "p.nc:2:5", "G40"),
        ("G21 F1 G41.1 D1\nG20", "p.nc:2:1", "unit cannot change"),
        # work that little text asks for
        ("F1 G1 X1\nG91 G81 X1 Z-1 R1 L1000000000", "p.nc:2:19", "does not come to an end"),
        ("F1 G1 X1\nG83 X1 Z-1 R1 Q0.0000001", "p.nc:2:15", "20000000 pecks"),
        ("F1 G1 X1\nG83 X1 Z-1 R100000000 Q1", "p.nc:2:23", "does not come to an end"),
        ("F1 G1 X1\nG2 X1 I5 P1000000000", "p.nc:2:10", "1000000000 turns"),
        ("F1 G1 X[" + "+".join(["#1"] * 5000) + "]", "p.nc:1", "too many parts"),
        ("F1 G1 X1\no" + "1" * 5000 + " sub", "p.nc:2:1", "without its endsub"),
    ],
)  # fmt: skip
def test_faults_name_their_place(text, place, words):
    found = faults(text)
    assert any(line.startswith(place + ":") and words in line for line in found), found


def test_all_faults_at_once():
    assert len(faults("G1 X1\nG12 X1\nX#3\nM77\nM99")) == 3  # X#3: #3 is 0, and the missing feed is said once
    assert len(faults("F1 G1 X[1/0]\nG12\n*\nX5 R1\nT-1")) == 5


def test_consequences_of_a_fault_are_not_faults():
    """After an arc that is wrong the program stands at its end: the arcs behind it are right again."""
    assert len(faults("F1 G1 X10\nG2 X20 I1\nG2 X30 I5\nG2 X40 I5")) == 1


def test_a_program_of_nothing_but_faults_is_given_up():
    found = faults("\n".join(f"G1 X1 R{i}" for i in range(500)))
    assert len(found) == MOST_FAULTS + 1
    assert "there may be more" in str(found[-1])


def test_faults_within_a_loop_are_said_once():
    assert len(faults("F1\no1 repeat [50]\nG1 X1 R5\no1 endrepeat")) == 1


def test_tools_that_are_not_in_the_table():
    setup = Setup(tools={1: Tool(1), 5: Tool(5)})
    assert "not in the tool table (there: T1, T5)" in faults("F1 T2 M6 G1 X1", setup)[0]
    assert interpret("F1 T2 M6 G1 X1").tools == (2,)


@pytest.mark.parametrize(
    "text",
    [
        "o1 while [1]\nG1 X1\no1 endwhile",
        "#1=0\no1 while [1]\n#1=[#1+1]\no1 endwhile",
        "o1 do\no1 while [1]",
        "o1 sub\no1 call\no1 endsub\no1 call",
        "o1 repeat [1000000000]\nG1 X1\nX2\no1 endrepeat",
    ],
)
def test_endless_programs_end(text):
    found = faults("F1 G1 X1\n" + text, Setup(step_limit=20_000))
    assert any(word in found[0] for word in ("endless", "does not come to an end", "for ever"))


@pytest.mark.parametrize("calls", ["M98 P{} L100\n", "M98 P{}\n" * 60])
def test_subroutines_that_call_one_another_many_times_end(calls):
    """Ten levels of a hundred calls each are no loop, and would not end in a lifetime."""
    deeper = "".join(f"O{i}\n" + calls.format(*[i + 1] * 60) + "M99\n" for i in range(1, 8))
    text = "F1 G1 X1\n" + calls.format(*[1] * 60) + "M2\n" + deeper + "O8\nX1\nX2\nM99"
    assert "does not come to an end" in faults(text, Setup(step_limit=20_000))[0]


@settings(deadline=None)
@given(st.text(alphabet="GMXYZIJKRFSTNPQHDOA0123456789.-+ ()/;%#[]<>=@^\n", max_size=120))
def test_any_text_is_read_or_refused_in_words(text):
    with contextlib.suppress(ScenarioFault):  # any other exception is a failure
        interpret(text)


# One word a blank here, one line a comma: long lists read better so.
_WORDS = """
    g0 g1 g2 g3 g5 g5.2 g5.3 g10 l2 p1 g28 g33 g38.2 g41.1 g42.1 g40 d.5 g54 g55 g73 g81 g83 g84 q1 r2 z-1 x1 y2
    x[#1+1] #1=[#1+1] #<a>=3 x#<a> m98 m99 m70 m72 g92 g91 g90 g20 g21 g18 g17 @1 ^90 a3 u1 i1 j2 k1 m6 t1 g43 g49
    m2 (debug,#1) f10 s100 m3 g95 g93 [1/0] e1 l0 m66 m19 [ ] o1 if sub [1]"""
_FLOW = """o1 sub,o1 endsub,o1 call [1],o2 while [#1 lt 3],o2 endwhile,o3 if [#1 gt 1],o3 else,o3 endif,o4 do,
    o4 while [0],o5 repeat [2],o5 endrepeat,o2 break,o1 return [3],O9,m98 p9,m99"""
WORDS, FLOW = st.sampled_from(_WORDS.split()), st.sampled_from(_FLOW.split(","))
LINES = st.one_of(st.lists(WORDS, max_size=5).map(" ".join), FLOW)


@settings(deadline=None)
@given(st.lists(LINES, max_size=14))
def test_any_program_of_words_is_run_or_refused_in_words(rows):
    text = "g21 f10 s100 m3\n" + "\n".join(rows)
    with contextlib.suppress(ScenarioFault):
        list(canonical_text.lines(Rs274(text, "p", Setup(step_limit=2000)).commands()))
    with contextlib.suppress(ScenarioFault):
        interpret(text, setup=Setup(step_limit=2000))


APT_WORDS = st.sampled_from(["GOTO/1,2,3", "GOTO/1,2,3,0,0,1", "GOTO/1,2", "GOTO/1,2,3,0,0,0", "RAPID", "FEDRAT/10,MMPM",
                             "FEDRAT/0", "CIRCLE/0,0,0,0,0,1,5", "CIRCLE/0,0,0,0,1,1,2", "CYCLE/DRILL,5,MMPM,10,2",
                             "CYCLE/OFF", "CYCLE/NONE", "GODLTA/5", "GODLTA/1,1,1", "SPINDL/100,CLW", "LOADTL/1", "LOADTL/A",
                             "UNITS/INCH", "FINI", "NONSENSE/1", "$$ x", "GOTO/1,$", "PARTNO X", "DELAY/1"])  # fmt: skip


@settings(deadline=None)
@given(st.lists(APT_WORDS, max_size=12))
def test_any_cl_data_is_run_or_refused_in_words(rows):
    with contextlib.suppress(ScenarioFault):
        list(reading("\n".join(rows), "p.cls").commands())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("G21 G90 F100\nG1 X10\nM30\nG1 X20\nG1 Y50\nM2", "2 lines with axis words stand behind the end of the program (line 3)"),
        ("%\nG21 G90 F100\nG1 X10\n%\n(two)\nG1 X20", "1 line with axis words stands behind the % that closes the program"),
        ("G21 G90 F100\nG1 X10\nM98 P5\nM30\nO5\nG1 X20\nM99", ""),  # reached by the call
        ("G21 G90 F100\nG1 X10\nM30\n%", ""),
    ],
)  # fmt: skip
def test_motions_that_no_run_reaches_are_told(text, said):
    behind = [notice for notice in interpret(text, "p.nc").notices if "not run" in notice]
    assert [said in notice for notice in behind] == ([True] if said else [])


@pytest.mark.parametrize(
    "text", ["F1E-18 G1 X1", "G1 X1 F0.0000000001", "F100 G1 X1\nG1 X2 F0.0000000001", "G93 G1 X1 F1E-9"]
)
def test_a_feed_at_which_nothing_ever_ends_is_out_of_scale(text):
    assert any("out of scale: feeds begin at" in fault for fault in faults(text.replace("1E-", "0.00000000000000000")))


def test_the_limit_of_steps_is_said_with_the_key_that_raises_it():
    text = "G21 G90 F100\no1 repeat [600]\nG1 X1\nG1 X0\no1 endrepeat\nM2"
    assert "program.step_limit" in faults(text, Setup(step_limit=1000))[0]
    assert len(interpret(text, "p.nc", Setup(step_limit=5000)).moves) == 1200
    assert setup_of(Program(file="p.nc", step_limit=5000)).step_limit == 5000


@pytest.mark.parametrize(
    ("dialect", "name", "call", "body"),
    [
        ("rs274", "cut", "o<cut> call", "o<cut> sub\n(b)\n(c)\no1 if [1 EQ 1]\nG1 X5 F50\no1 endif\nG2 X7 I1{}\no<cut> endsub"),
        ("fanuc", "o100", "M98 P100", "O100\n(b)\n(c)\n(d)\nG1 X5 F50\n(f)\nG2 X7 I1{}\nM99"),
    ],
)  # fmt: skip
def test_places_in_a_file_that_is_called_are_told_by_the_line_of_the_call(dialect, name, call, body):
    main = f"G21 G90 F100\nG0 X0. Y0. Z5.\n(here)\n{call}\nG1 X1.\nM30"
    setup = Setup(dialect=dialect, library={name: body.format("")}.get)
    assert [move.line for move in interpret(main, "main.nc", setup).moves] == [2, 4, 4, 5]
    with pytest.raises(ScenarioFault) as found:  # but a fault names the file that it stands in
        interpret(main, "main.nc", Setup(dialect=dialect, library={name: body.format(" M77")}.get))
    assert found.value.faults[0].line == 7
    assert name in found.value.faults[0].file
