"""What varies in a study, as it is written: values that are set, and distributions of values that scatter."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from cutwise import units
from cutwise.io.files import as_text, read_bytes
from cutwise.io.revision import Value
from cutwise.io.tables import cells_of, number_of
from cutwise.io.tree import Node
from cutwise.spec import fields
from cutwise.spec.faults import Fault, ScenarioFault, dotted, split_dotted
from cutwise.spec.scenario import Scenario
from cutwise.study.many import distributions as scatter
from cutwise.study.many.definition import Design, Random

LATER = ("correlated", "field", "between", "rare", "optimise", "robust", "budget")
"""Words of studies that this version refuses."""

_KINDS = ("normal", "lognormal", "uniform", "triangular", "table", "choice", "grid")

At = tuple[str | int, ...]


class Faults:
    """Faults of a study file as they are found."""

    def __init__(self) -> None:
        self.found: list[Fault] = []

    def at(self, node: Node, path: At, message: str, *, at_key: bool = False) -> None:
        """Note a fault at the place of a node."""
        self.found.append(node.fault(path, message, at_key=at_key))


def levers_of(
    tree: Node, scenario: Scenario, folder: Path, faults: Faults
) -> tuple[dict[str, Design], dict[str, Random]]:  # fmt: skip
    node = tree.value.get("vary")
    if node is None or not isinstance(node.value, dict) or not node.value:
        faults.at(
            node or tree,
            ("vary",),
            "missing; say what varies, for example part.burr.height: {normal: {mean: 0.8 mm, deviation: 0.1 mm}}",
        )
        return {}, {}
    design: dict[str, Design] = {}
    random: dict[str, Random] = {}
    for key, one in node.value.items():
        path = ("vary", key)
        if key in LATER:
            faults.at(one, path, "is not in this version", at_key=True)
            continue
        info = fields.field_at(type(scenario), split_dotted(key))
        if info is None:
            known = [dotted(p) for p, _ in fields.keys(type(scenario))]
            near = get_close_matches(key, known, n=1)
            faults.at(
                one, path, f"unknown key of the scenario{f'; did you mean {near[0]}?' if near else ''}", at_key=True
            )
            continue
        dimension = fields.dimension(info)
        if isinstance(one.value, list):
            design[key] = Design(tuple(_value(entry, dimension, path, faults) for entry in one.value))
        elif isinstance(one.value, dict) and "grid" in one.value:
            design[key] = Design(_grid(one.value["grid"], dimension, path, faults))
        elif isinstance(one.value, dict):
            lever = _random(one, key, scenario, dimension, folder, faults)
            if lever is not None:
                random[key] = lever
        else:
            faults.at(one, path, f"expected a list of values or one of {', '.join(_KINDS)}")
    return design, random


def _value(node: Node, dimension: str | None, path: At, faults: Faults) -> Value:
    """A value in SI, or the word it is."""
    plain = node.plain()
    if dimension is None or isinstance(plain, bool):
        return str(plain).lower() if isinstance(plain, bool) else plain
    try:
        return units.parse(plain, dimension)
    except units.UnitFault as why:
        faults.at(node, path, str(why))
        return math.nan


def _number(given: Mapping[str, Node], name: str, dimension: str | None, node: Node, path: At, faults: Faults) -> float:
    if name not in given:
        faults.at(node, path, f"{name}: missing")
        return math.nan
    value = _value(given[name], dimension or "dimensionless", path, faults)
    return float(value) if isinstance(value, int | float) else math.nan


def _grid(node: Node, dimension: str | None, path: At, faults: Faults) -> tuple[Value, ...]:
    given = node.value if isinstance(node.value, dict) else {}
    low, high = (_number(given, end, dimension, node, path, faults) for end in ("from", "to"))
    count = given["count"].value if "count" in given else None
    spacing = given["spacing"].value if "spacing" in given else "linear"
    if (
        not isinstance(count, int)
        or isinstance(count, bool)
        or count < 1
        or spacing not in ("linear", "log")
        or given.keys() - {"from", "to", "count", "spacing"}
    ):
        faults.at(node, path, "expected for example {from: 3 bar, to: 6 bar, count: 7, spacing: linear}")
        return ()
    if spacing == "log" and not (low > 0.0 and high > 0.0):
        faults.at(node, path, "spacing: log needs ends above zero")
        return ()
    make = np.geomspace if spacing == "log" else np.linspace
    return tuple(make(low, high, count).tolist())


Make = Callable[[Node, str | None, At, Faults], scatter.Distribution | None]


def _ends(node: Node, names: Sequence[str], dimension: str | None, path: At, faults: Faults) -> list[float] | None:
    """Numbers in a list, or by their names."""
    if isinstance(node.value, list) and len(node.value) == len(names):
        values = [_value(one, dimension or "dimensionless", path, faults) for one in node.value]
        return [float(x) for x in values if isinstance(x, int | float)]
    if isinstance(node.value, dict) and not node.value.keys() - set(names):
        return [_number(node.value, name, dimension, node, path, faults) for name in names]
    faults.at(node, path, f"expected {', '.join(names)}")
    return None


def _normal(node: Node, dimension: str | None, path: At, faults: Faults) -> scatter.Distribution | None:
    found = _ends(node, ("mean", "deviation"), dimension, path, faults)
    if found is not None and found[1] < 0.0:
        faults.at(node, path, "deviation: must be 0 or more")
    return None if found is None else scatter.Normal(*found)


def _lognormal(node: Node, dimension: str | None, path: At, faults: Faults) -> scatter.Distribution | None:
    given = node.value if isinstance(node.value, dict) else {}
    if given.keys() - {"median", "log_deviation"}:
        faults.at(node, path, "expected median and log_deviation")
    median = _number(given, "median", dimension, node, path, faults)
    spread = _number(given, "log_deviation", "dimensionless", node, path, faults)
    if median <= 0.0 or spread < 0.0:
        faults.at(node, path, "median must be above 0, log_deviation 0 or more")
    return scatter.LogNormal(median, spread)


def _uniform(node: Node, dimension: str | None, path: At, faults: Faults) -> scatter.Distribution | None:
    found = _ends(node, ("low", "high"), dimension, path, faults)
    if found is not None and found[0] > found[1]:
        faults.at(node, path, "the first end must not be above the second")
    return None if found is None else scatter.Uniform(*found)


def _triangular(node: Node, dimension: str | None, path: At, faults: Faults) -> scatter.Distribution | None:
    found = _ends(node, ("low", "mode", "high"), dimension, path, faults)
    if found is not None and not found[0] <= found[1] <= found[2]:
        faults.at(node, path, "low, mode and high must rise")
    return None if found is None else scatter.Triangular(*found)


_MADE: dict[str, Make] = {"normal": _normal, "lognormal": _lognormal, "uniform": _uniform, "triangular": _triangular}


def _random(
    node: Node, key: str, scenario: Scenario, dimension: str | None, folder: Path, faults: Faults
) -> Random | None:  # fmt: skip
    """A lever that scatters, truncated and put on the lever's own value where that is asked for."""
    path = ("vary", key)
    kinds = [name for name in node.value if name in _KINDS]
    more = [name for name in node.value if name not in (*_KINDS, "within", "offset", "weights")]
    if len(kinds) != 1 or more:
        later = [name for name in more if name in LATER]
        words = f"{later[0]} is not in this version" if later else f"expected one of {', '.join(_KINDS)}"
        faults.at(node, path, words + (f", found {', '.join(node.value)}" if not later else ""))
        return None
    kind = kinds[0]
    goes_with = ("weights",) if kind == "choice" else ("within", "offset")
    for name in node.value:
        if name not in (kind, *goes_with):
            faults.at(node.value[name], (*path, name), f"does not go with {kind}", at_key=True)
    if "offset" in node.value and not isinstance(node.value["offset"].value, bool):
        faults.at(node.value["offset"], (*path, "offset"), "is true or false")
    if kind == "choice":
        return _choice(node, dimension, path, faults)
    if dimension is None:
        faults.at(node, path, "is no quantity: its values can be listed, or drawn by choice")
        return None
    made = (
        _table(node.value[kind], dimension, folder, path, faults)
        if kind == "table"
        else _MADE[kind](node.value[kind], dimension, path, faults)
    )
    if made is None:
        return None
    if "within" in node.value:
        low, high = _within(node.value["within"], dimension, path, faults)
        made = scatter.Truncated(made, low, high)
        if not made.whole.share_below(high) - made.whole.share_below(low) > 1e-12:
            faults.at(node.value["within"], path, "none of the distribution lies within these ends")
            return None
    added = 0.0
    if "offset" in node.value and node.value["offset"].value is True:
        own = next((value for at, _, value in fields.leaves(scenario) if dotted(at) == key), None)
        if not isinstance(own, float):
            faults.at(
                node.value["offset"], path, "the scenario has no value of this key to which the offset could be added"
            )
            return None
        added = own
    return Random(made, added)


def _within(node: Node, dimension: str, path: At, faults: Faults) -> tuple[float, float]:
    ends = node.value if isinstance(node.value, list) else []
    if len(ends) != 2:
        faults.at(node, path, "within: expected two ends, for example [0 mm, null]")
        return -math.inf, math.inf
    low, high = (
        sign * math.inf if one.value is None else _value(one, dimension, path, faults)
        for one, sign in zip(ends, (-1.0, 1.0), strict=True)
    )
    return float(low), float(high)  # type: ignore[arg-type]


def _choice(node: Node, dimension: str | None, path: At, faults: Faults) -> Random | None:
    entries = node.value["choice"].value
    weights = node.value["weights"].plain() if "weights" in node.value else None
    if not isinstance(entries, list) or not entries:
        faults.at(node.value["choice"], path, "expected a list of values")
        return None
    if weights is not None and (
        len(weights) != len(entries)
        or not all(isinstance(w, int | float) and w >= 0 for w in weights)
        or not sum(weights) > 0
    ):
        faults.at(node.value["weights"], path, "expected a number for each value, none below 0")
        return None
    words = tuple(_value(one, dimension, path, faults) for one in entries)
    made = scatter.empirical(np.arange(len(words), dtype=float), None if weights is None else np.array(weights, float))
    return Random(made, 0.0, words)


def _table(node: Node, dimension: str, folder: Path, path: At, faults: Faults) -> scatter.Distribution | None:
    if not isinstance(node.value, str):
        faults.at(node, path, "expected the name of a CSV file with one column and its unit")
        return None
    try:
        lines = as_text(read_bytes(folder / node.value, node.value), node.value).splitlines()
    except ScenarioFault as why:
        faults.found += why.faults
        return None
    rows = [
        [text for text, _ in cells_of(line)] for line in lines if line.strip() and not line.lstrip().startswith("#")
    ]
    values, weights = None, None
    for title, *texts in zip(*rows, strict=False):
        name, unit = re.fullmatch(r"\s*([^\[]*?)\s*(?:\[(.*)\])?\s*", title).groups()  # type: ignore[union-attr]
        numbers = [number_of(text) for text in texts]
        if any(number is None for number in numbers):
            faults.at(node, path, f"{node.value}: {name} has a cell that is no number")
            return None
        if name == "weight":
            weights = np.array(numbers, float)
        elif values is None:
            try:
                values = np.array([units.converted(float(x), unit or "", dimension) for x in numbers])  # type: ignore[arg-type]
            except units.UnitFault as why:
                faults.at(node, path, f"{node.value}: {why}")
                return None
    if values is None or not len(values):
        faults.at(node, path, f"{node.value} has no column of values")
        return None
    return scatter.empirical(values, weights)
