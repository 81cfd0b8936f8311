"""What an optimisation is to make small or large, as written: a measure, a lever, or a cost of both with units."""

import ast
import math
import re
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from typing import Any

from cutwise import units
from cutwise.io.tree import Node
from cutwise.spec import fields
from cutwise.spec.faults import split_dotted
from cutwise.spec.scenario import Scenario
from cutwise.study.many.definition import Aim, Between, Search
from cutwise.study.many.levers import Faults, Levers

_COST = "cost: "
_EXAMPLE = """{cost: "'60 EUR/h' * settling_time + '0.02 EUR' * operation.feed / '80 mm/s'"}"""
_KEY = re.compile(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*|\[\d+\])+")  # a dotted key; measures are plain words
_QUOTED = re.compile(r"'([^']*)'|\"([^\"]*)\"")
_FUNCTIONS: Mapping[str, Callable[..., Any]] = {"abs": abs, "min": min, "max": max}


class Cost:
    """An expression of measures, levers and quantities with units.

    Parameters
    ----------
    text : str
        Sums, products, powers, ``abs``, ``min``, ``max``; quantities in quotes.

    Raises
    ------
    ValueError
        It is no such expression.
    """

    def __init__(self, text: str) -> None:
        self.text = text
        self._quantities: dict[str, Any] = {}
        self.names: dict[str, str] = {}  # words of the expression, and what they stand for
        plain = _QUOTED.sub(self._quantity, text)
        plain = _KEY.sub(self._lever, plain)
        try:
            self._tree = ast.parse(plain.strip(), mode="eval").body
        except SyntaxError:
            raise ValueError(f'"{text}" is no expression, expected for example {_EXAMPLE}') from None
        for one in ast.walk(self._tree):
            if isinstance(one, ast.Name) and one.id not in self._quantities and one.id not in _FUNCTIONS:
                self.names.setdefault(one.id, one.id)

    def _quantity(self, match: re.Match[str]) -> str:
        name = f"quantity_{len(self._quantities)}"
        self._quantities[name] = units.quantity(match.group(1) or match.group(2) or "")
        return f" {name} "

    def _lever(self, match: re.Match[str]) -> str:
        name = f"lever_{len(self.names)}"
        self.names[name] = match.group(0)
        return f" {name} "

    def unit(self, dimensions: Mapping[str, str]) -> str:
        """The SI unit of the expression; raises ValueError where its units do not fit each other."""
        one = units.registry().Quantity
        values = {
            word: one(1.0, units.DIMENSIONS[dimensions[name]].si or "dimensionless").to_base_units()
            for word, name in self.names.items()
        }
        try:
            found = _evaluated(self._tree, {**values, **self._quantities})
            return f"{one(found).to_base_units().units:~}" if hasattr(found, "units") else ""
        except ZeroDivisionError:
            raise ValueError(f'"{self.text}" divides by zero') from None
        except (TypeError, AttributeError) as why:
            raise ValueError(f'"{self.text}": {why}') from None
        except ValueError:
            raise
        except Exception as why:  # of pint: metres and seconds are no sum
            raise ValueError(f'"{self.text}": {why}') from None

    def __call__(self, values: Mapping[str, float]) -> float:
        """The value in SI."""
        bare = {word: values.get(name, math.nan) for word, name in self.names.items()}
        bare |= {word: float(q.magnitude) for word, q in self._quantities.items()}
        try:
            found = _evaluated(self._tree, bare)
        except (ZeroDivisionError, OverflowError):
            return math.nan
        return math.nan if isinstance(found, complex) else float(found)  # a root of what is below 0


def _evaluated(one: ast.expr, values: Mapping[str, Any]) -> Any:
    if isinstance(one, ast.Constant) and isinstance(one.value, int | float) and not isinstance(one.value, bool):
        return float(one.value)
    if isinstance(one, ast.Name):
        return values[one.id]
    if isinstance(one, ast.UnaryOp) and isinstance(one.op, ast.USub | ast.UAdd):
        inner = _evaluated(one.operand, values)
        return -inner if isinstance(one.op, ast.USub) else inner
    if isinstance(one, ast.BinOp) and isinstance(one.op, ast.Add | ast.Sub | ast.Mult | ast.Div | ast.Pow):
        left, right = _evaluated(one.left, values), _evaluated(one.right, values)
        if isinstance(one.op, ast.Add):
            return left + right
        if isinstance(one.op, ast.Sub):
            return left - right
        if isinstance(one.op, ast.Mult):
            return left * right
        return left / right if isinstance(one.op, ast.Div) else left**right
    if isinstance(one, ast.Call) and isinstance(one.func, ast.Name) and one.func.id in _FUNCTIONS and not one.keywords:
        return _FUNCTIONS[one.func.id](*(_evaluated(part, values) for part in one.args))
    raise ValueError(
        "an expression has sums, products, powers, abs, min and max of measures, levers and quantities in quotes"
    )


def value_of(aim: Aim) -> Callable[[Mapping[str, float]], float]:
    """The value of an aim [SI] of the measures and levers of a setting."""
    if aim.text.startswith(_COST):
        return Cost(aim.text.removeprefix(_COST))
    return lambda values: float(values.get(aim.text, math.nan))


def measures_of(aim: Aim, known: Mapping[str, Any]) -> tuple[str, ...]:
    """The measures that an aim needs."""
    names = Cost(aim.text.removeprefix(_COST)).names.values() if aim.text.startswith(_COST) else (aim.text,)
    return tuple(name for name in names if name in known)


def unit_of(aim: Aim, scenario: Scenario) -> tuple[str, str]:
    """Dimension of an aim, and its SI unit; a cost has no dimension that has a name."""
    if aim.text.startswith(_COST):
        cost = Cost(aim.text.removeprefix(_COST))
        return "", cost.unit({name: _dimension(name, scenario) or "dimensionless" for name in cost.names.values()})
    dimension = _dimension(aim.text, scenario) or "dimensionless"
    return dimension, units.DIMENSIONS[dimension].si


def _dimension(name: str, scenario: Scenario) -> str | None:
    known = type(scenario).measures
    if name in known:
        return known[name].dimension
    info = fields.field_at(type(scenario), split_dotted(name))
    return fields.dimension(info) if info is not None else None


def search_of(tree: Node, scenario: Scenario, levers: Levers, runs: int | None, faults: Faults) -> Search:
    """What an optimisation looks for: its levers, aims, and how likely a good part has to be."""
    between = dict(levers.between)
    for key, design in levers.design.items():
        between[key] = Between(0.0, float(len(design.values) - 1), True, design.values)
    if not between:
        example = "operation.feed: {between: [60 mm/s, 120 mm/s]}"
        faults.at(tree, ("vary",), f"nothing can be set: give a lever two ends, for example {example}")
    aims: list[Aim] = []
    for word, sign in (("minimise", 1.0), ("maximise", -1.0)):
        if word in tree.value:
            aims += _aims(tree.value[word], word, sign, scenario, between, faults)
    if not aims and not tree.value.keys() & {"minimise", "maximise"}:
        faults.at(tree, ("method",), "optimise needs minimise or maximise: a measure, a lever, or a cost")
    if len({aim.text for aim in aims}) < len(aims):
        faults.at(tree, ("method",), f"{aims[0].text} is both aims: a front has two that differ")
    probability = _robust(tree, scenario, bool(levers.random), faults)
    if len(aims) + (len(probability) > 1) > 2:
        faults.at(tree, ("method",), "a front has two aims; a list of probabilities is one of them")
    points = _points(tree, len(aims) == 2, faults)
    return Search(between, tuple(aims), probability, runs, points)


def _aims(
    node: Node, word: str, sign: float, scenario: Scenario, between: Mapping[str, Between], faults: Faults
) -> list[Aim]:
    found = []
    for one in node.value if isinstance(node.value, list) else [node]:
        if isinstance(one.value, dict) and one.value.keys() == {"cost"}:
            text = str(one.value["cost"].plain())
            try:
                cost = Cost(text)
                wrong = [name for name in cost.names.values() if not _fits(name, scenario, between)]
                if wrong:
                    raise ValueError(_no_aim(wrong[0], scenario, between))
                if not cost.names:
                    raise ValueError(f'"{text}" is the same for every setting: it has no measure and no lever')
                cost.unit({name: _dimension(name, scenario) or "dimensionless" for name in cost.names.values()})
            except ValueError as why:
                faults.at(one, (word, "cost"), str(why))
                continue
            found.append(Aim(_COST + text, sign))
            continue
        name = str(one.plain())
        if not _fits(name, scenario, between):
            faults.at(one, (word,), _no_aim(name, scenario, between))
            continue
        found.append(Aim(name, sign))
    return found


def _fits(name: str, scenario: Scenario, between: Mapping[str, Between]) -> bool:
    return name in type(scenario).measures or (name in between and not between[name].words)


def _no_aim(name: str, scenario: Scenario, between: Mapping[str, Between]) -> str:
    if name in between:
        return f"{name} takes the values of a list: it is an aim where it has two ends (between)"
    near = get_close_matches(name, [*type(scenario).measures, *between], n=1)
    return f"{name} is no measure and no lever of this optimisation{f'; did you mean {near[0]}?' if near else ''}"


def _robust(tree: Node, scenario: Scenario, scatters: bool, faults: Faults) -> tuple[float, ...]:
    """The shares of good cases that are asked for."""
    node = tree.value.get("robust")
    if node is None:
        if scatters:
            faults.at(
                tree,
                ("robust",),
                "missing: something scatters, so say how likely a good part has to be, for example {probability: 0.99}",
            )
        return ()
    if not scatters:
        faults.at(node, ("robust",), "is not used: nothing scatters (vary)", at_key=True)
        return ()
    if not scenario.asked:
        faults.at(node, ("robust",), "there are no requirements, so no case is good or bad")
    given = node.plain() if isinstance(node.value, dict) else {}
    said = given.get("probability")
    each = said if isinstance(said, list) else [said]
    right = given.keys() == {"probability"} and each
    if not right or not all(isinstance(p, float) and 0.0 < p < 1.0 for p in each):
        faults.at(node, ("robust",), "expected {probability: 0.99}, or a list of such shares for a front over them")
        return ()
    return tuple(sorted(set(each)))


def _points(tree: Node, two: bool, faults: Faults) -> int:
    node = tree.value.get("points")
    if node is None:
        return 9
    if not two:
        faults.at(node, ("points",), "is not used: a front has two aims", at_key=True)
    if isinstance(node.value, bool) or not isinstance(node.value, int) or not 3 <= node.value <= 100:
        faults.at(node, ("points",), "is no whole number from 3 to 100")
        return 9
    return int(node.value)
