"""Functions and operators of RS274/NGC expressions; angles in degrees.

A value that does not exist raises ValueError with words for the programmer.
"""

import math
from collections.abc import Callable

CLOSE = 1e-4  # numbers nearer than this are equal (EQ, NE), and whole where they must be whole


def square_root(x: float) -> float:
    if x < 0.0:
        raise ValueError(f"SQRT of {x:g}: a negative number has no square root")
    return math.sqrt(x)


def natural_log(x: float) -> float:
    if x <= 0.0:
        raise ValueError(f"LN of {x:g}: only positive numbers have a logarithm")
    return math.log(x)


def _exp(x: float) -> float:
    try:
        return math.exp(x)
    except OverflowError:
        raise ValueError(f"EXP of {x:g} is too large") from None


def _acos(x: float) -> float:
    return math.degrees(math.acos(_sine(x, "ACOS")))


def _asin(x: float) -> float:
    return math.degrees(math.asin(_sine(x, "ASIN")))


def _sine(x: float, name: str) -> float:
    if abs(x) > 1.0:
        raise ValueError(f"{name} of {x:g}: the number must be between -1 and 1")
    return x


def _round(x: float) -> float:
    return math.copysign(math.floor(abs(x) + 0.5), x)


FUNCTIONS: dict[str, Callable[[float], float]] = {
    "abs": abs,
    "acos": _acos,
    "asin": _asin,
    "cos": lambda x: math.cos(math.radians(x)),
    "exp": _exp,
    "fix": lambda x: float(math.floor(x)),
    "fup": lambda x: float(math.ceil(x)),
    "ln": natural_log,
    "round": _round,
    "sin": lambda x: math.sin(math.radians(x)),
    "sqrt": square_root,
    "tan": lambda x: math.tan(math.radians(x)),
}


def arc_tangent(y: float, x: float) -> float:
    """``ATAN[y]/[x]`` [degree], -180 to 180."""
    return math.degrees(math.atan2(y, x))


def _power(x: float, y: float) -> float:
    if x < 0.0 and y != math.floor(y):
        raise ValueError(f"{x:g} ** {y:g}: a negative number has whole powers only")
    try:
        return float(x**y)
    except (OverflowError, ZeroDivisionError):
        raise ValueError(f"{x:g} ** {y:g} is infinite") from None


def _divided(x: float, y: float) -> float:
    if y == 0.0:
        raise ValueError("division by zero")
    return x / y


def _modulo(x: float, y: float) -> float:
    if y == 0.0:
        raise ValueError("MOD by zero")
    rest = math.fmod(x, y)
    return rest + abs(y) if rest < 0.0 else rest


OPERATORS: dict[str, tuple[int, Callable[[float, float], float]]] = {  # with their precedence; equals bind to the left
    "**": (5, _power),
    "*": (4, lambda x, y: x * y),
    "/": (4, _divided),
    "mod": (4, _modulo),
    "+": (3, lambda x, y: x + y),
    "-": (3, lambda x, y: x - y),
    "eq": (2, lambda x, y: float(abs(x - y) < CLOSE)),
    "ne": (2, lambda x, y: float(abs(x - y) >= CLOSE)),
    "gt": (2, lambda x, y: float(x > y)),
    "ge": (2, lambda x, y: float(x >= y)),
    "lt": (2, lambda x, y: float(x < y)),
    "le": (2, lambda x, y: float(x <= y)),
    "and": (1, lambda x, y: float(x != 0.0 and y != 0.0)),
    "or": (1, lambda x, y: float(x != 0.0 or y != 0.0)),
    "xor": (1, lambda x, y: float((x != 0.0) != (y != 0.0))),
}
