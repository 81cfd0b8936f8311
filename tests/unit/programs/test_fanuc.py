"""Fanuc macro B: expressions and flow against a small reference in Python, calls, variables, and what is refused."""

import contextlib
import itertools
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cutwise.io.program_setup import subroutine_files
from cutwise.programs.fanuc import macro_sign
from cutwise.programs.interpreter import interpret
from cutwise.programs.macro_values import computed, read_expression
from cutwise.programs.setup import Setup
from cutwise.spec.faults import ScenarioFault

HEAD = "G21 G90 G17 F300\n"
FANUC = Setup(dialect="fanuc")


def ends(text, setup=FANUC, axis=0):
    return [round(1e3 * move.end[axis], 6) for move in interpret(HEAD + text, "p.nc", setup).moves]


def faults(text, setup=FANUC):
    with pytest.raises(ScenarioFault) as found:
        interpret(text, "p.nc", setup)
    return [str(fault) for fault in found.value.faults]


class Locals(dict):
    def number(self, index, place):  # noqa: ARG002
        return self.get(index)


def value(text, **variables):
    known = Locals({int(name[1:]): number for name, number in variables.items()})
    return computed(read_expression(text.replace(" ", "").lower(), 0).value, known)


# A reference of its own: trees with their text, in brackets wherever one could doubt, and their value.


def _leaf(number):
    return f"{number:.3f}", number


def _unary(name, function):
    def made(inner):
        text, x = inner
        return (
            (f"{name}[{text}]", None if x is None else function(x))
            if name
            else (f"-[{text}]", None if x is None else -x)
        )

    return made


def _away(x):
    return float(math.ceil(round(x, 9)) if x > 0 else math.floor(round(x, 9)))


UNARY = [("SIN", lambda x: math.sin(x * math.pi / 180)), ("COS", lambda x: math.cos(x * math.pi / 180)), ("ABS", abs),
         ("FIX", lambda x: float(int(round(x, 9)))), ("FUP", _away), ("", None),
         ("ATAN", lambda x: math.atan(x) * 180 / math.pi)]  # fmt: skip
BINARY = {
    "+": lambda x, y: x + y,
    "-": lambda x, y: x - y,
    "*": lambda x, y: x * y,
    "/": lambda x, y: x / y if y else None,
}
LEAVES = st.integers(-20_000, 20_000).map(lambda n: _leaf(n / 1000))


def _grown(inner):
    binary = st.tuples(inner, st.sampled_from(sorted(BINARY)), inner).map(
        lambda t: (
            f"[{t[0][0]}]{t[1]}[{t[2][0]}]",
            None if None in (t[0][1], t[2][1]) else BINARY[t[1]](t[0][1], t[2][1]),
        )
    )
    return st.one_of(*(inner.map(_unary(*one)) for one in UNARY), binary)


@settings(deadline=None)
@given(st.recursive(LEAVES, _grown, max_leaves=12))
def test_expressions_are_those_of_a_reference(tree):
    text, expected = tree
    if expected is None or abs(expected) > 1e12:
        return
    assert value(text) == pytest.approx(expected, rel=1e-9, abs=1e-6)


@settings(deadline=None)
@given(st.lists(st.tuples(st.sampled_from("+-*/"), st.integers(1, 99)), min_size=1, max_size=8), st.integers(-99, 99))
def test_operators_bind_as_in_arithmetic(rest, first):
    text = str(first) + "".join(f"{sign}{number}" for sign, number in rest)
    assert value(text) == pytest.approx(eval(text), rel=1e-12, abs=1e-12)  # digits and + - * / only


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("FIX[-1.2]", -1), ("FUP[-1.2]", -2), ("FIX[1.2]", 1), ("FUP[1.2]", 2), ("ROUND[-1.5]", -2), ("ROUND[2.5]", 3),
        ("ATAN[1]/[-1]", 135), ("ATAN[-1]/[1]", 315), ("ATAN[1,-1]", 135), ("ATAN[1]", 45), ("ASIN[-0.5]", 330),
        ("ACOS[-0.5]", 120), ("SQRT[9]", 3), ("SQ[9]", 3), ("POW[2,10]", 1024), ("EXP[0]", 1), ("LN[1]", 0),
        ("BIN[18]", 12), ("BCD[12]", 18), ("12 AND 10", 8), ("12 OR 3", 15), ("6 XOR 3", 5), ("17 MOD 5", 2),
        ("1 + 6 AND 3", 3), ("4 OR 1 + 1", 6), ("-2 * 3", -6), ("2 - -3", 5), ("#1 + 1", 3), ("#[#2 + 1]", 7), ("-#1", -2),
    ],
)  # fmt: skip
def test_functions_and_operators(text, expected):
    assert value(text, v1=2.0, v2=4.0, v5=7.0) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("condition", "vacant", "zero"),
    [("EQ #0", True, False), ("NE #0", False, True), ("EQ 0", False, True), ("NE 0", True, False), ("GE 0", True, True),
     ("GT 0", False, False), ("LE #0", True, True), ("LT 0", False, False)],
)  # fmt: skip
def test_vacant_is_not_zero(condition, vacant, zero):
    """The table of the operator's manuals: EQ and NE tell a vacant variable from 0, the others take it as 0."""
    assert bool(value(f"#1 {condition}")) is vacant
    assert bool(value(f"#1 {condition}", v1=0.0)) is zero


def test_vacancy_is_handed_on_and_lost_in_arithmetic():
    assert value("#1") is None
    assert value("-#1") is None
    assert value("#1*5") == 0.0
    assert ends("#2=#1\nG1 X1.\nX#2 Y1.\nX[#2+0]\n") == [1.0, 1.0, 0.0]
    assert ends("#2=5.\n#2=#0\nG1 X1.\nIF[#2EQ#0]GOTO5\nX9.\nN5 X2.") == [1.0, 2.0]


# Flow: structured programs as trees, with their text and what a reference makes of them.

MOVES = st.integers(1, 999).map(lambda n: ("move", n))


def _blocks(inner):
    body = st.lists(inner, max_size=3)
    return st.one_of(
        st.tuples(st.just("loop"), st.integers(0, 3), body),
        st.tuples(st.just("branch"), st.integers(0, 2), body),
        st.tuples(st.just("then"), st.integers(0, 2), st.integers(1, 99)),
    )


PROGRAM = st.lists(st.recursive(MOVES, _blocks, max_leaves=10), min_size=1, max_size=5)


class Reference:
    """Writes a tree as macro B and runs it in Python; loops deeper than three are left out of both."""

    def __init__(self):
        self.rows, self.places, self.next = [], [], 0

    def fresh(self):
        self.next += 1
        return self.next

    def write(self, tree, depth=0):
        for kind, *rest in tree:
            if kind == "move":
                self.rows.append(f"G1 X[{rest[0]}+#100]")
            elif kind == "loop" and depth < 3:
                counter, (times, body) = 100 + self.fresh(), rest
                self.rows += [f"#{counter}=0", f"WHILE[#{counter}LT{times}]DO{depth + 1}", f"#{counter}=#{counter}+1"]
                self.write(body, depth + 1)
                self.rows.append(f"END{depth + 1}")
            elif kind == "branch":
                label = 1000 + self.fresh()
                self.rows.append(f"IF[#100 MOD 3 EQ {rest[0]}]GOTO{label}")
                self.write(rest[1], depth)
                self.rows.append(f"N{label}")
            elif kind == "then":
                self.rows.append(f"IF[#100 MOD 3 EQ {rest[0]}]THEN #100=#100+{rest[1]}")

    def run(self, tree, total=0, depth=0):
        for kind, *rest in tree:
            if kind == "move":
                self.places.append(rest[0] + total)
            elif kind == "loop" and depth < 3:
                for _ in range(rest[0]):
                    total = self.run(rest[1], total, depth + 1)
            elif kind == "branch" and total % 3 != rest[0]:
                total = self.run(rest[1], total, depth)
            elif kind == "then" and total % 3 == rest[0]:
                total += rest[1]
        return total


@settings(deadline=None)
@given(PROGRAM)
def test_flow_is_that_of_a_reference(tree):
    made = Reference()
    made.write(tree)
    made.run(tree)
    steps = [0, *made.places]
    expected = [float(b) for a, b in itertools.pairwise(steps) if a != b]  # no way is no move
    if made.next > 99 or not expected:
        return
    assert ends("#100=0\n" + "\n".join(made.rows) + "\nM30") == expected


def test_macro_calls_take_both_lists_of_arguments():
    """The example of the operator's manual: I and D stand for #7 both, and the later one counts."""
    body = "\nM30\nO9000\nG1 X[#1+#2] Y#4\nX#7\nIF[#3EQ#0]GOTO1\nX99.\nN1 M99"
    assert ends("G65 P9000 A1. B2. I-3. I4. D5." + body) == [3.0, 5.0]
    listed = "G65 P9000 A1. B2. C3. I4. J5. K6. I7. J8. K9. K12.\nM30\nO9000\nG1 X#4\nX#6\nX#7\nX#9\nX#12\nX#3\nM99"
    assert ends(listed) == [4.0, 6.0, 7.0, 9.0, 12.0, 3.0]
    letters = "G65 P1 E8. F9. H11. M13. Q17. R18. S19. T20. U21. V22. W23. X24. Y25. Z26.\nM30\nO1\n"
    letters += "".join(f"G1 X#{n}\n" for n in (8, 9, 11, 13, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26)) + "M99"
    assert ends(letters) == [8.0, 9.0, 11.0, 13.0, 17.0, 18.0, 19.0, 20.0, 21.0, 22.0, 23.0, 24.0, 25.0, 26.0]


def test_local_variables_belong_to_a_level_and_common_ones_to_all():
    text = "#1=1.\n#100=5.\nG65 P10 A7. L2\nG1 X#1\nX#100\nM98 P20\nX#1\nM30\n"
    text += "O10\n#1=#1+1.\nG1 X#1\n#100=#100+1.\nM99\nO20\n#1=30.\nM99"
    assert ends(text) == [8.0, 1.0, 7.0, 30.0]  # 8 twice is one move; the subprogram shares #1


def test_subprograms_repeat_and_return_to_a_block():
    assert ends("G91\nM98 P5 L3\nM30\nO5\nG1 X1.\nM99") == [1.0, 2.0, 3.0]
    assert ends("G91\nM98 P30005\nM30\nO5\nG1 X1.\nM99") == [1.0, 2.0, 3.0]
    assert ends("M98 P5\nG1 X1.\nN7 X2.\nM30\nO5\nG1 X5.\nM99 P7") == [5.0, 2.0]
    assert ends("G1 X1. M98 P5\nM30\nO5\nG1 X5.\nM99") == [1.0, 5.0]  # the motion of the block first
    assert ends("G1 X1.\nM99") == [1.0]


def test_goto_looks_ahead_first():
    assert ends("GOTO5\nN5 G1 X1.\n#1=#1+1\nIF[#1EQ1]GOTO5\nX3.\nN5 X4.") == [1.0, 4.0]
    assert ends("#5=10\nGOTO#5\nG1 X1.\nN10 G1 X2.\nGOTO[#5+5]\nX3.\nN15 X4.") == [2.0, 4.0]


def test_programs_in_files_beside():
    texts = {"o9010": "O9010\nG1 X#1\nM98 P9011\nM99", "9011": "%\nO9011\nG1 X9.\nM99\n%"}
    assert ends("G65 P9010 A4.\nM30", FANUC._replace(library=texts.get)) == [4.0, 9.0]
    assert subroutine_files("G65 P9010 A4.", texts.get) == texts


def test_fanuc_words():
    found = interpret(
        HEAD + "G1 X1.\nG4 P500\nG4 X2.\nG82 X5. Z-1. R1. P250\nX6. K2\nG80\nG5.1 Q1\nG69\nG0 G91 G28 Z0.\nM30",
        "p.nc",
        FANUC,
    )
    assert [m.dwell for m in found.moves if m.kind == "dwell"] == [0.5, 2.0, 0.25, 0.25, 0.25]
    stored = interpret(HEAD + "G1 X1.\nG81 X5. Z-1. R1. K0\nX7.\nM30", "p.nc", FANUC)
    assert [round(1e3 * m.end[0], 6) for m in stored.moves if m.end[2] < 0] == [7.0]
    assert any("no decimal point" in words for words in interpret(HEAD + "G1 X10", "p.nc", FANUC).notices)
    assert not any("no decimal point" in words for words in interpret(HEAD + "G1 X10.", "p.nc", FANUC).notices)


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("F1 G1 X1.\nWHILE[1EQ1]DO1\nX2.", "p.nc:2:1", "without its END1"),
        ("F1 G1 X1.\nEND2", "p.nc:2:1", "without its DO2"),
        ("F1 G1 X1.\nDO1\nDO2\nEND1\nEND2", "p.nc:2:1", "crosses DO2"),
        ("F1 G1 X1.\nDO1\nDO1\nEND1\nEND1", "p.nc:3:1", "still open"),
        ("F1 G1 X1.\nDO4\nEND4", "p.nc:2:1", "DO1 to DO3"),
        ("F1 G1 X1.\nGOTO5\n#1=1\nWHILE[#1LT3]DO1\nN5 #1=#1+1\nEND1", "p.nc:2:1", "into the loop"),
        ("F1 G1 X1.\nGOTO77", "p.nc:2:1", "no block N77"),
        ("F1 G1 X1.\nN1 GOTO1", "p.nc:2:4", "endless"),
        ("F1 G1 X1.\n#1=0\nN1 #1=#1+1\nGOTO1", "p.nc:4:1", "again and again"),
        ("F1 G1 X1.\nG65 P1\nM30\nO1\nG65 P1\nM99", "p.nc:5:1", "for ever"),
        ("F1 G1 X1.\nG65 P99 A1.", "p.nc:2:1", "no program O99"),
        ("F1 G1 X1.\nG65 P5 O1.\nM30\nO5\nM99", "p.nc:2:8", "program number (O)"),
        ("F1 G1 X1.\nG66 P5", "p.nc:2:1", "modal macro calls"),
        ("F1 G1 X1.\nG68 X0 Y0 R30.", "p.nc:2:1", "rotation"),
        ("F1 G1 X1.\nG41.1 D1", "p.nc:2:1", "dialect rs274"),
        ("F1 G1 X1.\nG10 L20 P1 X0", "p.nc:2:1", "only L2"),
        ("F1 G1 X#3012", "p.nc:1:8", "date or the time"),
        ("F1 G1 X#2001", "p.nc:1:8", "tool offset"),
        ("F1 G1 X#5221\n#5221=5", "p.nc:2:1", "write G10 L2"),
        ("F1 G1 X#50", "p.nc:1:8", "no variable #50"),
        ("F1 G1 X1.\n#0=1", "p.nc:2:1", "always vacant"),
        ("F1 G1 X1.\n#3000=21(NO TOOL)", "p.nc:2:1", "alarm 3021: NO TOOL"),
        ("F1 G1 X1.\nIF[#1]GOTO1", "p.nc:2:1", "needs a comparison"),
        ("F1 G1 X1.\n#1=[1LT2]", "p.nc:2:4", "no number"),
        ("F1 G1 X1.\nG1 X2. #1=5", "p.nc:2:8", "blocks of their own"),
        ("F1 G1 X1.\nIF[1EQ1]X5.", "p.nc:2:9", "GOTO n or THEN"),
        ("F1 G1 X[1/0]", "p.nc:1:10", "division by zero"),
        ("F1 G1 X[1.5+", "p.nc:1:12", "expected a number"),
        ("F1 G1 X##1", "p.nc:1:8", "#[#...]"),
        ("F1 G1 X#<a>", "p.nc:1:8", "names"),
        ("F1 G1 X[-1AND2]", "p.nc:1:11", "bits"),
        ("F1 G1 X" + "9" * 20, "p.nc:1:7", "out of scale"),
    ],
)  # fmt: skip
def test_faults_name_their_place(text, place, words):
    found = faults(text, FANUC._replace(step_limit=5000))
    assert any(line.startswith(place + ":") and words in line for line in found), found


@pytest.mark.parametrize(
    ("text", "line"),
    [("G1 X1\n#1=#1+1\nM2", 2), ("N10 IF[#1LT5]GOTO10", 1), ("WHILE [#1 LE 3] DO 1", 1), ("G0\nG65 P1 A2", 2), ("\n\nGOTO 5", 3),
     ("#1=SIN[#2]*3", 1), ("#1=[#2+1]-2.", 1)],
)  # fmt: skip
def test_macro_b_is_recognised(text, line):
    assert macro_sign(text)[0] == line


@pytest.mark.parametrize(
    "text",
    [
        "#1=[#1+1]\no1 if [#1 LT 5]\no1 endif",
        "#1=-2\n#2=ATAN[1]/[2]\n#3=+5 X1",
        "(IF [1] GOTO 5)\nG1 X1",
        "; WHILE[1]DO1",
        "#<a>=1",
    ],
)
def test_rs274_stays_rs274(text):
    assert macro_sign(text) is None


def test_the_dialect_is_chosen_or_recognised():
    text = "F100 G1 X1\n#1=#1+5\nX#1"
    found = interpret(text, "p.nc")
    assert found.moves[-1].end[0] == pytest.approx(5e-3)
    assert any("run in the dialect fanuc" in words for words in found.notices)
    assert faults(text, Setup(dialect="rs274")) == [
        "p.nc:2: arithmetic without brackets (#1=#1+1) is Fanuc macro B, which the dialect rs274 does not know; choose the "
        "dialect fanuc"
    ]


_WORDS = """g1 g0 g2
    g65 g81 g4 m98 m99 m30 p5 p9 l2 k3 x1. x#1 x[#1+1] y-#2 z#[#1] i1. j2. r1. q1. f10 #1=#1+1 #100=[#1*2] #0=1
    if[#1lt3]goto10 goto10 goto#1 while[#1lt3]do1 do2 end1 end2 if[#1eq#0]then#1=0
    n10 n20 o5 o9 #3000=1 [ ] a1 b2 g91 g90 g28 g66"""
LINES = st.lists(st.sampled_from(_WORDS.split()), max_size=4).map(" ".join)


@settings(deadline=None)
@given(st.lists(LINES, max_size=14))
def test_any_program_of_words_is_run_or_refused_in_words(rows):
    with contextlib.suppress(ScenarioFault):
        interpret("g21 f10 s100 m3\n" + "\n".join(rows), "p.nc", FANUC._replace(step_limit=500))
