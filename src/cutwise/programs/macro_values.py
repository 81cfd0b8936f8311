"""Values of Fanuc macro B: numbers, variables that may be vacant, functions, arithmetic and comparisons.

Text is compact: lower case, without white space and comments. A vacant value is None: an address that gets it is left out,
arithmetic takes it as 0, and EQ and NE tell it from 0.
"""

import math
import re
from collections.abc import Callable
from typing import NamedTuple, Protocol

from cutwise.programs.expressions import BlockFault
from cutwise.programs.functions import natural_log, square_root


class MacroVariables(Protocol):
    """What expressions can look up."""

    def number(self, index: int, place: int) -> float | None:
        """A variable; None if it is vacant."""
        ...


Value = float | Callable[[MacroVariables], float | None]


class Read(NamedTuple):
    """A value, where the text goes on behind it, and whether it is a condition."""

    value: Value
    end: int
    condition: bool = False


_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)")
_WORD = re.compile(r"[a-z]+")
_OPERATOR = re.compile(r"and|or|xor|mod|eq|ne|gt|ge|lt|le|[-+*/]")
_SAME = 1e-9  # share, and least difference, of numbers that are equal: a control keeps 9 to 12 digits
_DIGITS = 9  # decimals that FIX and FUP look at
_MOST_BITS = 2**31
_NAMED = re.compile(r"#\[[a-z_$]\w*\]")
_LOGICAL = ("and", "or", "xor")


def computed(value: Value, variables: MacroVariables) -> float | None:
    """The value as a number, None if it is vacant."""
    return value if isinstance(value, float) else value(variables)


def filled(value: Value, variables: MacroVariables) -> float:
    """The value as a number, 0 if it is vacant."""
    number = computed(value, variables)
    return 0.0 if number is None else number


def read_value(text: str, at: int) -> Read:
    """What may stand behind an address: a number, a variable, a function or an expression in brackets, with a sign.

    Raises
    ------
    BlockFault
        There is none, or it cannot be read.
    """
    match = _NUMBER.match(text, at)
    if match is not None:
        return Read(_finite(float(match.group()), at), match.end())
    letter = text[at : at + 1]
    if letter in ("+", "-") and at + 1 < len(text):
        value, end, condition = read_value(text, at + 1)
        _no_condition(condition, at)
        return Read(_signed(value) if letter == "-" else value, end)
    if letter == "#":
        return _variable(text, at)
    if letter == "[":
        inner = read_expression(text, at + 1)
        if text[inner.end : inner.end + 1] != "]":
            raise BlockFault("expression without its closing ]" if inner.end >= len(text) else
                             f'"{text[inner.end]}" is not an operator', at if inner.end >= len(text) else inner.end)  # fmt: skip
        return inner._replace(end=inner.end + 1)
    if _WORD.match(text, at):
        return _function(text, at)
    found = f'"{text[at : at + 8]}"' if letter else "the end of the block"
    raise BlockFault(f"expected a number, a variable (#) or an expression [...], found {found}", at)


def read_expression(text: str, at: int) -> Read:
    """Values and operators, as far as they go: functions first, then * / AND MOD, then + - OR XOR, then comparisons."""
    values: list[Read] = []
    signs: list[tuple[str, int]] = []
    while True:
        values.append(read_value(text, at))
        at = values[-1].end
        match = _OPERATOR.match(text, at)
        strength = 0 if match is None else _STRENGTH[match.group()]
        while signs and _STRENGTH[signs[-1][0]] >= strength:
            sign, place = signs.pop()
            right, left = values.pop(), values.pop()
            values.append(_joined(sign, left, right, place))
        if match is None:
            return values[0]._replace(end=at)
        signs.append((match.group(), at))
        at = match.end()


def _joined(sign: str, left: Read, right: Read, place: int) -> Read:
    if sign in _COMPARISONS:
        _no_condition(left.condition or right.condition, place)
        compare = _COMPARISONS[sign]
        a, b = left.value, right.value
        return Read(lambda v: float(compare(computed(a, v), computed(b, v))), right.end, True)
    if left.condition != right.condition or (left.condition and sign not in _LOGICAL):
        raise BlockFault(f"{sign.upper()} joins two conditions, or two numbers", place)
    return Read(_of_two(_ARITHMETIC[sign], left.value, right.value, place), right.end, left.condition)


def _no_condition(condition: bool, place: int) -> None:
    if condition:
        raise BlockFault("a condition (EQ, NE, GT, GE, LT, LE) is no number; it belongs into IF and WHILE", place)


def _variable(text: str, at: int) -> Read:
    if text[at + 1 : at + 2] == "#":
        raise BlockFault("## is not read; write #[#...] for the variable whose number is in a variable", at)
    if text[at + 1 : at + 2] == "<" or _NAMED.match(text, at):
        raise BlockFault("variables with names are not supported in the dialect fanuc; they have numbers", at)
    if text[at + 1 : at + 2] != "[" and not text[at + 1 : at + 2].isdigit():
        raise BlockFault("# without the number of a variable", at)
    key, end, condition = read_value(text, at + 1)
    _no_condition(condition, at)
    return Read(lambda variables: variables.number(index_of(key, variables, at), at), end)


def index_of(key: Value, variables: MacroVariables, place: int) -> int:
    """The number of a variable, which must be whole."""
    value = filled(key, variables)
    if abs(value - round(value)) > 1e-6 or value < 0.0:
        raise BlockFault(f"the number of a variable must be whole, not {value:g}", place)
    return round(value)


def _function_name(text: str, at: int) -> str | None:
    match = _WORD.match(text, at)
    if match is None or text[match.end() : match.end() + 1] != "[":
        return None
    word = match.group()
    return word if word in _KNOWN else _SHORT.get(word)


def _function(text: str, at: int) -> Read:
    name = _function_name(text, at)
    match = _WORD.match(text, at)
    assert match is not None
    if name is None:
        raise BlockFault(f'"{match.group()}" is not a function; known are {", ".join(sorted(_KNOWN)).upper()}', at)
    first, end, condition = read_expression(text, match.end() + 1)
    _no_condition(condition, at)
    if name == "pow" or (name == "atan" and text[end : end + 1] == ","):
        if text[end : end + 1] != ",":
            raise BlockFault("POW needs two arguments: POW[base,exponent]", at)
        second, end, condition = read_expression(text, end + 1)
        _no_condition(condition, at)
        two = _of_two(_power if name == "pow" else _arc_tangent, first, second, at)
        return Read(two, _closed(text, at, end))
    end = _closed(text, at, end)
    if name == "atan" and text[end : end + 2] == "/[":
        second, end, condition = read_expression(text, end + 2)
        _no_condition(condition, at)
        return Read(_of_two(_arc_tangent, first, second, at), _closed(text, at, end))
    return Read(_of_one(_FUNCTIONS[name], first, at), end)


def _closed(text: str, at: int, end: int) -> int:
    if text[end : end + 1] != "]":
        raise BlockFault("function without its closing ]", at)
    return end + 1


def _finite(value: float, place: int) -> float:
    if not math.isfinite(value):
        raise BlockFault("the number is too large to compute with", place)
    return value


def _signed(value: Value) -> Value:
    if isinstance(value, float):
        return -value

    def negative(variables: MacroVariables) -> float | None:
        number = value(variables)
        return None if number is None else -number

    return negative


def _of_one(function: Callable[[float], float], value: Value, place: int) -> Value:
    def placed(variables: MacroVariables) -> float:
        try:
            return _finite(function(filled(value, variables)), place)
        except (ValueError, OverflowError) as error:
            raise BlockFault(str(error), place) from None

    return placed


def _of_two(function: Callable[[float, float], float], left: Value, right: Value, place: int) -> Value:
    def placed(variables: MacroVariables) -> float:
        try:
            return _finite(function(filled(left, variables), filled(right, variables)), place)
        except (ValueError, OverflowError) as error:
            raise BlockFault(str(error), place) from None

    return placed


def _exp(x: float) -> float:
    if x > 700.0:
        raise ValueError(f"EXP of {x:g} is too large")
    return math.exp(x)


def _within_one(x: float, name: str) -> float:
    if abs(x) > 1.0 + _SAME:
        raise ValueError(f"{name} of {x:g}: the number must be between -1 and 1")
    return max(-1.0, min(1.0, x))


def _asin(x: float) -> float:
    return math.degrees(math.asin(_within_one(x, "ASIN"))) % 360.0


def _acos(x: float) -> float:
    return math.degrees(math.acos(_within_one(x, "ACOS")))


def _tan(x: float) -> float:
    if math.isclose(x % 180.0, 90.0, abs_tol=1e-9):
        raise ValueError(f"TAN of {x:g} is infinite")
    return math.tan(math.radians(x))


def _arc_tangent(y: float, x: float) -> float:
    return math.degrees(math.atan2(y, x)) % 360.0


def _round(x: float) -> float:
    return math.copysign(math.floor(abs(x) + 0.5), x)


def _fix(x: float) -> float:
    return float(math.trunc(round(x, _DIGITS)))


def _fup(x: float) -> float:
    return math.copysign(math.ceil(abs(round(x, _DIGITS))), x)


def _bits(x: float, name: str) -> int:
    if not 0.0 <= x < _MOST_BITS:
        raise ValueError(f"{name} works on the bits of whole numbers from 0 to 2147483647, not on {x:g}")
    return round(x)


def _bin(x: float) -> float:
    digits = f"{_bits(x, 'BIN'):x}"
    if not digits.isdigit():
        raise ValueError(f"BIN of {x:g}: it is not in binary coded decimals")
    return float(int(digits))


def _bcd(x: float) -> float:
    return float(int(str(_bits(x, "BCD")), 16))


def _divided(x: float, y: float) -> float:
    if y == 0.0:
        raise ValueError("division by zero")
    return x / y


def _modulo(x: float, y: float) -> float:
    if round(y) == 0:
        raise ValueError("MOD by zero")
    return math.fmod(round(x), round(y))


def _power(x: float, y: float) -> float:
    if x < 0.0 and y != math.floor(y):
        raise ValueError(f"POW[{x:g},{y:g}]: a negative number has whole powers only")
    try:
        return float(x**y)
    except (OverflowError, ZeroDivisionError):
        raise ValueError(f"POW[{x:g},{y:g}] is infinite") from None


_FUNCTIONS: dict[str, Callable[[float], float]] = {
    "sin": lambda x: math.sin(math.radians(x)), "cos": lambda x: math.cos(math.radians(x)), "tan": _tan, "asin": _asin,
    "acos": _acos, "atan": lambda x: math.degrees(math.atan(x)), "sqrt": square_root, "sqr": square_root, "abs": abs,
    "round": _round, "rnd": _round, "fix": _fix, "fup": _fup,
    "ln": natural_log, "exp": _exp, "bin": _bin, "bcd": _bcd, "adp": lambda x: x,
}  # fmt: skip
_KNOWN = frozenset({*_FUNCTIONS, "pow"})
_SHORT = {
    "si": "sin", "co": "cos", "ta": "tan", "as": "asin", "ac": "acos", "at": "atan", "sq": "sqrt", "ab": "abs",
    "ro": "round", "fi": "fix", "fu": "fup", "ex": "exp", "bi": "bin", "bc": "bcd", "po": "pow",
}  # fmt: skip
"""Controls read functions by their first two letters."""

_STRENGTH = {"*": 3, "/": 3, "and": 3, "mod": 3, "+": 2, "-": 2, "or": 2, "xor": 2,
             "eq": 1, "ne": 1, "gt": 1, "ge": 1, "lt": 1, "le": 1}  # fmt: skip
_ARITHMETIC: dict[str, Callable[[float, float], float]] = {
    "*": lambda x, y: x * y, "/": _divided, "mod": _modulo, "+": lambda x, y: x + y, "-": lambda x, y: x - y,
    "and": lambda x, y: float(_bits(x, "AND") & _bits(y, "AND")), "or": lambda x, y: float(_bits(x, "OR") | _bits(y, "OR")),
    "xor": lambda x, y: float(_bits(x, "XOR") ^ _bits(y, "XOR")),
}  # fmt: skip


def same(x: float | None, y: float | None) -> bool:
    """EQ: vacant equals vacant only; numbers are equal within what a control keeps of them."""
    if x is None or y is None:
        return x is y
    return abs(x - y) <= _SAME * max(1.0, abs(x), abs(y))


def _or_zero(x: float | None) -> float:
    return 0.0 if x is None else x


_COMPARISONS: dict[str, Callable[[float | None, float | None], bool]] = {
    "eq": same,
    "ne": lambda x, y: not same(x, y),
    "gt": lambda x, y: _or_zero(x) > _or_zero(y) and not same(_or_zero(x), _or_zero(y)),
    "ge": lambda x, y: _or_zero(x) >= _or_zero(y) or same(_or_zero(x), _or_zero(y)),
    "lt": lambda x, y: _or_zero(x) < _or_zero(y) and not same(_or_zero(x), _or_zero(y)),
    "le": lambda x, y: _or_zero(x) <= _or_zero(y) or same(_or_zero(x), _or_zero(y)),
}
