"""Values: precedence, functions, variables, and what exists."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cutwise.programs.expressions import BlockFault, computed, read_value


class Memory:
    def __init__(self, **named):
        self.names = named

    def number(self, index):
        return float(10 * index)

    def named(self, name):
        return self.names[name]

    def exists(self, key):
        return key in self.names or key == 5


def value(text, **named):
    read = read_value(text, 0)
    assert read.end == len(text)
    return computed(read.value, Memory(**named))


@pytest.mark.parametrize(
    ("text", "result"),
    [
        ("[2**3**2]", 64.0),  # all operators bind to the left
        ("[-2**2]", 4.0),
        ("[2+3*4]", 14.0),
        ("[10-4-3]", 3.0),
        ("[8/4/2]", 1.0),
        ("[2+3*4gt13and1]", 1.0),
        ("[1or0and0]", 0.0),  # and, or, xor are equals
        ("[10mod-3]", 1.0),
        ("[-10mod3]", 2.0),
        ("[1eq1.00005]", 1.0),
        ("[1ne1.001]", 1.0),
        ("[1lt1.00005]", 1.0),
        ("[5xor3]", 0.0),
        ("atan[1]/[-1]", 135.0),
        ("-sin[30]", -0.5),
        ("cos[60]", 0.5),
        ("tan[45]", 1.0),
        ("acos[0]", 90.0),
        ("asin[1]", 90.0),
        ("fix[-2.5]", -3.0),
        ("fup[-2.5]", -2.0),
        ("round[-2.5]", -3.0),
        ("round[2.5]", 3.0),
        ("abs[-3]", 3.0),
        ("exp[1]", math.e),
        ("ln[2]", math.log(2)),
        ("sqrt[2]", math.sqrt(2)),
        ("--3", 3.0),
        (".5", 0.5),
        ("+1.", 1.0),
        ("#3", 30.0),
        ("##1", 100.0),
        ("#[1+#1]", 110.0),
        ("-#2", -20.0),
        ("#<a>", 7.0),
        ("[#<a>*2]", 14.0),
        ("exists[#<a>]", 1.0),
        ("exists[#<b>]", 0.0),
        ("exists[#5]", 1.0),
        ("exists[#99999]", 0.0),
    ],
)
def test_values(text, result):
    assert value(text, a=7.0) == pytest.approx(result, abs=1e-12)


def test_what_is_known_is_computed_once():
    assert read_value("[sqrt[16]+2*3]", 0).value == 10.0
    assert callable(read_value("[#1+1]", 0).value)


@given(st.recursive(
    st.integers(-9, 9).map(lambda n: (str(n) if n >= 0 else f"[0-{-n}]", float(n))),
    lambda inner: st.tuples(inner, st.sampled_from("+-*"), inner).map(
        lambda t: (f"[{t[0][0]}{t[1]}{t[2][0]}]", {"+": t[0][1] + t[2][1], "-": t[0][1] - t[2][1], "*": t[0][1] * t[2][1]}[t[1]])
    ),
    max_leaves=12,
))  # fmt: skip
def test_arithmetic(case):
    text, result = case
    assert value(text) == pytest.approx(result)


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6).filter(lambda y: abs(y) > 1e-3))
def test_modulo_is_not_negative(x, y):
    rest = value(f"[{x:.6f}mod{y:.6f}]")
    assert 0.0 <= rest <= abs(y)


@pytest.mark.parametrize(
    "text", ["[", "[]", "[1", "[1+]", "#", "#<a", "foo[1]", "sin30", "atan[1]", "exists[1]", "", "]", "[1 2]"]
)
def test_what_is_no_value(text):
    with pytest.raises(BlockFault):
        value(text, a=1.0)
