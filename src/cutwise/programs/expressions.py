"""Values in a program: numbers, variables, functions and expressions, read once and computed as often as needed.

Text is *compact* here: lower case, without white space and comments. A value is a float where it is known when read,
else a function of the variables.
"""

import math
import operator
import re
from collections.abc import Callable
from typing import NamedTuple, Protocol

from cutwise.programs.functions import CLOSE, FUNCTIONS, OPERATORS, arc_tangent
from cutwise.programs.scale import MOST, out_of_scale


class Variables(Protocol):
    """What expressions can look up."""

    def number(self, index: int) -> float:
        """A numbered variable, 1 to :data:`LAST_VARIABLE`."""
        ...

    def named(self, name: str) -> float:
        """A named variable; raises KeyError where there is none."""
        ...

    def exists(self, key: int | str) -> bool:
        """Whether there is such a variable."""
        ...


Value = float | Callable[[Variables], float]

LAST_VARIABLE = 5601
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)")
_WORD = re.compile(r"[a-z]+")
_OPERATOR = re.compile("|".join(re.escape(sign) for sign in sorted(OPERATORS, key=len, reverse=True)))


class BlockFault(Exception):
    """Something in a block that cannot be run, and where in its compact text."""

    def __init__(self, message: str, place: int) -> None:
        super().__init__(message)
        self.message = message
        self.place = place


class FlowFault(BlockFault):
    """A fault after which nobody knows where to go on."""


class CommentFault(BlockFault):
    """A comment that cannot be read; its place counts the characters of the line as written."""


class Read(NamedTuple):
    """A value, and where the text goes on behind it."""

    value: Value
    end: int


def computed(value: Value, variables: Variables) -> float:
    """The value as a number."""
    return value if isinstance(value, float) else value(variables)


def whole(value: float, place: int, what: str) -> int:
    """A number that must be whole, within 0.0001."""
    nearest = round(value)
    if abs(value - nearest) > CLOSE:
        raise BlockFault(f"{what} must be a whole number, not {value:g}", place)
    return nearest


def variable_number(value: float, place: int) -> int:
    """The number of a variable, which must be one of those that there are."""
    index = whole(value, place, "the number of a variable")
    if not 1 <= index <= LAST_VARIABLE:
        raise BlockFault(f"there is no variable #{index}; they have numbers from 1 to {LAST_VARIABLE}", place)
    return index


def read_value(text: str, at: int) -> Read:
    """The number, variable, function or bracketed expression at a place of compact text.

    Raises
    ------
    BlockFault
        There is none, it is not closed, or it is known now to have no value (a division by zero).
    """
    match = _NUMBER.match(text, at)
    if match is not None:
        return Read(_finite(float(match.group()), at), match.end())
    letter, following = text[at : at + 1], text[at + 1 : at + 2]
    if letter == "[":
        return _expression(text, at)
    if letter == "#":
        return _variable(text, at)
    if _WORD.match(text, at):
        return _function(text, at)
    if letter in ("+", "-") and following and following not in ".0123456789":
        value, end = read_value(text, at + 1)
        return Read(_of_one(operator.neg, value, at) if letter == "-" else value, end)
    found = f'"{text[at : at + 8]}"' if letter else "the end of the block"
    raise BlockFault(f"expected a number, a variable (#) or an expression [...], found {found}", at)


def read_key(text: str, at: int) -> tuple[Value | str, int]:
    """What stands behind a ``#``: the name of a variable, or the value that is its number."""
    if text[at : at + 1] != "<":
        return read_value(text, at)
    end = text.find(">", at)
    if end < 0:
        raise BlockFault("name of a variable without its closing >", at)
    return text[at + 1 : end], end + 1


def _finite(value: float, place: int) -> float:
    if not math.isfinite(value):
        raise BlockFault("the number is too large to compute with", place)
    return value


def in_scale(value: float, place: int) -> float:
    """A number that a word may have.

    Raises
    ------
    BlockFault
        It is out of scale.
    """
    if not -MOST <= value <= MOST:
        raise BlockFault(out_of_scale(value), place)
    return value


def _variable(text: str, at: int) -> Read:
    key, end = read_key(text, at + 1)
    if isinstance(key, str):
        return Read(_named(key, at), end)
    if isinstance(key, float):
        index = variable_number(key, at)
        return Read(lambda variables: variables.number(index), end)
    return Read(lambda variables: variables.number(variable_number(key(variables), at)), end)


def _named(name: str, at: int) -> Value:
    def look_up(variables: Variables) -> float:
        try:
            return variables.named(name)
        except KeyError:
            raise BlockFault(f"variable #<{name}> has no value; assign one before", at) from None

    return look_up


def _function(text: str, at: int) -> Read:
    match = _WORD.match(text, at)
    assert match is not None
    name = match.group()
    if name == "exists":
        return _exists(text, match.end())
    if name not in FUNCTIONS and name != "atan":
        raise BlockFault(f'"{name}" is not a function; known are {", ".join(FUNCTIONS)}, atan and exists', at)
    value, end = _argument(text, match.end(), name)
    if name != "atan":
        return Read(_of_one(FUNCTIONS[name], value, at), end)
    if text[end : end + 1] != "/":
        raise BlockFault("ATAN needs two arguments: ATAN[y]/[x]", at)
    other, end = _argument(text, end + 1, name)
    return Read(_of_two(arc_tangent, value, other, at), end)


def _argument(text: str, at: int, name: str) -> Read:
    if text[at : at + 1] != "[":
        raise BlockFault(f"{name.upper()} needs its argument in brackets: {name.upper()}[...]", at)
    return _expression(text, at)


def _exists(text: str, at: int) -> Read:
    if text[at : at + 2] != "[#":
        raise BlockFault("EXISTS asks for a variable: EXISTS[#<name>] or EXISTS[#5]", at)
    key, end = read_key(text, at + 2)
    if text[end : end + 1] != "]":
        raise BlockFault("EXISTS asks for one variable and nothing else: ] is missing here", end)

    def look_up(variables: Variables) -> float:
        known = key if isinstance(key, str) else whole(computed(key, variables), at, "the number of a variable")
        return float(variables.exists(known))

    return Read(look_up, end + 1)


def _expression(text: str, at: int) -> Read:
    """An expression from its ``[`` to its ``]``: values and operators, stronger operators first."""
    values: list[Value] = []
    signs: list[tuple[str, int]] = []
    end = at + 1
    while True:
        value, end = read_value(text, end)
        values.append(value)
        closed = text[end : end + 1] == "]"
        match = None if closed else _OPERATOR.match(text, end)
        if not closed and match is None:
            unclosed = "expression without its closing ]" if end >= len(text) else f'"{text[end]}" is not an operator'
            raise BlockFault(unclosed, at if end >= len(text) else end)
        strength = 0 if match is None else OPERATORS[match.group()][0]
        while signs and OPERATORS[signs[-1][0]][0] >= strength:
            sign, place = signs.pop()
            right, left = values.pop(), values.pop()
            values.append(_of_two(OPERATORS[sign][1], left, right, place))
        if match is None:
            return Read(values[0], end + 1)
        signs.append((match.group(), end))
        end = match.end()


def _of_one(function: Callable[[float], float], value: Value, place: int) -> Value:
    """A function of a value: at once if the value is known, else of the variables."""

    def placed(x: float) -> float:
        try:
            return _finite(function(x), place)
        except ValueError as error:
            raise BlockFault(str(error), place) from None

    return placed(value) if isinstance(value, float) else lambda variables: placed(value(variables))


def _of_two(function: Callable[[float, float], float], left: Value, right: Value, place: int) -> Value:
    """A function of two values: at once if both are known, else of the variables."""

    def placed(x: float, y: float) -> float:
        try:
            return _finite(function(x, y), place)
        except ValueError as error:
            raise BlockFault(str(error), place) from None

    if isinstance(left, float) and isinstance(right, float):
        return placed(left, right)
    return lambda variables: placed(computed(left, variables), computed(right, variables))
