"""What varies in a study, as it is written: values that are set, and distributions of values that scatter."""

import math
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.revision import Value
from cutwise.io.tree import Node
from cutwise.spec import fields
from cutwise.spec.faults import Fault, ScenarioFault, dotted, split_dotted
from cutwise.spec.part import RandomField
from cutwise.spec.scenario import Scenario
from cutwise.study.many import distributions as scatter
from cutwise.study.many.definition import Between, Design, Random
from cutwise.study.many.observed import NoTable, observed

_KINDS = ("normal", "lognormal", "uniform", "triangular", "table", "choice", "grid", "between", "field")

_MOST_SETTINGS = 10**5  # of one lever
_NOT_VARIED = {
    "name": "it changes no number",
    "process": "each process has a study of its own",
    "requirements": "all cases are judged by the same limits; write them under set, and a study for each",
}

At = tuple[str | int, ...]


class Faults:
    """Faults of a study file as they are found."""

    def __init__(self) -> None:
        self.found: list[Fault] = []

    def at(self, node: Node, path: At, message: str, *, at_key: bool = False) -> None:
        """Note a fault at the place of a node."""
        self.found.append(node.fault(path, message, at_key=at_key))


class Levers(NamedTuple):
    """What varies, by keys."""

    design: dict[str, Design]
    random: dict[str, Random]
    between: dict[str, Between]
    curves: dict[str, str]  # random curves as a scenario writes them, without seed, lever and case


def levers_of(tree: Node, scenario: Scenario, folder: Path, faults: Faults) -> Levers:
    """Everything under ``vary``; measured entries, whose values scatter together, come later."""
    node = tree.value.get("vary")
    found = Levers({}, {}, {}, {})
    if node is None and "correlated" in tree.value:
        return found
    if node is None or not isinstance(node.value, dict) or not node.value:
        faults.at(
            node or tree,
            ("vary",),
            "missing; say what varies, for example part.burr.height: {normal: {mean: 0.8 mm, deviation: 0.1 mm}}",
        )
        return found
    for key, one in node.value.items():
        path = ("vary", key)
        if split_dotted(key)[0] in _NOT_VARIED:
            faults.at(one, path, f"does not vary within a study: {_NOT_VARIED[str(split_dotted(key)[0])]}", at_key=True)
            continue
        info = fields.field_at(type(scenario), split_dotted(key))
        if info is None:
            known = [dotted(p) for p, _ in fields.keys(type(scenario))]
            near = get_close_matches(key, known, n=1)
            faults.at(
                one, path, f"unknown key of the scenario{f'; did you mean {near[0]}?' if near else ''}", at_key=True
            )
            continue
        _lever(one, key, scenario, fields.dimension(info), folder, found, faults)
    return found


def _lever(
    one: Node, key: str, scenario: Scenario, dimension: str | None, folder: Path, found: Levers, faults: Faults
) -> None:
    """Read one lever into where it belongs."""
    path = ("vary", key)
    if isinstance(one.value, list):
        found.design[key] = Design(tuple(_value(entry, dimension, path, faults) for entry in one.value))
        _distinct(found.design[key].values, one, path, faults)
        if not one.value:
            faults.at(one, path, "is an empty list")
        return
    if not isinstance(one.value, dict):
        faults.at(one, path, f"expected a list of values or one of {', '.join(_KINDS)}")
        return
    if "grid" in one.value:
        found.design[key] = Design(_grid(one.value["grid"], dimension, path, faults))
        _distinct(found.design[key].values, one, path, faults)
        for name in one.value.keys() - {"grid"}:
            faults.at(one.value[name], (*path, name), "does not go with grid", at_key=True)
        return
    if "field" in one.value:
        made = _curve(one, key, scenario, faults)
        if made is not None:
            found.random[key], found.curves[key] = made
        return
    rest = {name: node for name, node in one.value.items() if name != "between"}
    if "between" in one.value:
        found.between[key] = _between(one.value["between"], dimension, path, faults)
        if not rest:
            return
        offset = rest.get("offset")
        if offset is None or offset.value is not True:
            faults.at(one, path, "scatter of a lever that is optimised is told as how far off it is: add offset: true")
            return
    lever = _random(one, rest, key, scenario, dimension, folder, faults, added="between" in one.value)
    if lever is not None:
        found.random[key] = lever


def _between(node: Node, dimension: str | None, path: At, faults: Faults) -> Between:
    """The ends of a lever that is optimised."""
    ends = node.value if isinstance(node.value, list) else []
    values = [_value(one, dimension, path, faults) for one in ends]
    numbers = [x for x in values if isinstance(x, int | float) and not isinstance(x, bool)]
    if len(values) != 2 or len(numbers) != 2 or not (numbers[0] < numbers[1] or any(map(math.isnan, numbers))):
        faults.at(node, (*path, "between"), "expected two ends that rise, for example [60 mm/s, 120 mm/s]")
        return Between(0.0, 1.0)
    whole = dimension is None
    if whole and not all(isinstance(x, int) for x in numbers):
        faults.at(node, (*path, "between"), "is a number of things: its ends are whole numbers")
    return Between(float(numbers[0]), float(numbers[1]), whole)


def _curve(one: Node, key: str, scenario: Scenario, faults: Faults) -> tuple[Random, str] | None:
    """A curve along the edge, another in each case."""
    path, said = ("vary", key), one.value["field"]
    for name in one.value.keys() - {"field"}:
        faults.at(one.value[name], (*path, name), "does not go with field", at_key=True)
    info = fields.field_at(type(scenario), split_dotted(key))
    if info is None or RandomField not in fields.inner(info):
        faults.at(one, path, "is no size along an edge; a random curve can be the height or the width of a burr")
        return None
    names = ("mean", "deviation", "correlation_length")
    given = said.value if isinstance(said.value, dict) else {}
    if given.keys() - set(names):
        faults.at(said, (*path, "field"), f"expected {', '.join(names)}")
        return None
    mean, deviation, length = (_number(given, name, "length", said, (*path, "field"), faults) for name in names)
    if mean < 0.0 or deviation < 0.0 or length <= 0.0:
        faults.at(said, (*path, "field"), "mean and deviation must be 0 or more, correlation_length above 0")
        return None
    text = ", ".join(
        f"{name}: {units.text(x, 'length')}" for name, x in zip(names, (mean, deviation, length), strict=True)
    )
    return Random(scatter.Normal(mean, deviation), curve=True), text


def _distinct(values: Sequence[Value], node: Node, path: At, faults: Faults) -> None:
    """Values of a list are those of its settings, each of which is studied once."""
    numbers = [x for x in values if not (isinstance(x, float) and math.isnan(x))]  # those are told already
    if len(set(map(repr, numbers))) < len(numbers):
        faults.at(node, path, "has the same value twice")


def _value(node: Node, dimension: str | None, path: At, faults: Faults) -> Value:
    """A value in SI, or the word it is."""
    plain = node.plain()
    if dimension is None:
        return str(plain).lower() if isinstance(plain, bool) else plain
    if isinstance(plain, bool):
        faults.at(node, path, f"{str(plain).lower()} is no quantity")
        return math.nan
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
    if count > _MOST_SETTINGS:
        faults.at(node, path, f"{count:,} settings are too many: at most {_MOST_SETTINGS:,}")
        return ()
    if spacing == "log" and not (low > 0.0 and high > 0.0):
        faults.at(node, path, "spacing: log needs ends above zero")
        return ()
    make = np.geomspace if spacing == "log" else np.linspace
    return tuple(make(low, high, count).tolist())


def ends_of(scenario: Scenario, key: str) -> tuple[float, float]:
    """Between which values a key may be by itself [SI]."""
    info = fields.field_at(type(scenario), split_dotted(key))
    low, high = -math.inf, math.inf
    for kind, metadata in fields.of_field(info) if info is not None else ():
        for bound in metadata if kind is float else ():
            least = [getattr(bound, name, None) for name in ("gt", "ge")]
            most = [getattr(bound, name, None) for name in ("lt", "le")]
            low = max([low, *(float(end) for end in least if end is not None)])
            high = min([high, *(float(end) for end in most if end is not None)])
    return low, high


def share_beyond(scenario: Scenario, key: str, lever: Random) -> float:
    """Share of a distribution beyond the bounds that its key has by itself."""
    low, high = ends_of(scenario, key)
    below = lever.distribution.share_below(low - lever.added) if math.isfinite(low) else 0.0
    above = 1.0 - lever.distribution.share_below(high - lever.added) if math.isfinite(high) else 0.0
    return below + max(0.0, above)


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
    node: Node, said: Mapping[str, Node], key: str, scenario: Scenario, dimension: str | None, folder: Path,
    faults: Faults, *, added: bool,
) -> Random | None:  # fmt: skip
    """A lever that scatters, truncated and put on the lever's own value where that is asked for.

    ``added``: on the value that an optimisation gives it.
    """
    path = ("vary", key)
    kinds = [name for name in said if name in _KINDS]
    more = [name for name in said if name not in (*_KINDS, "within", "offset", "weights")]
    if len(kinds) != 1 or more:
        faults.at(node, path, f"expected one of {', '.join(_KINDS)}, found {', '.join(said)}")
        return None
    kind = kinds[0]
    goes_with = ("weights",) if kind == "choice" else ("within", "offset")
    for name in said:
        if name not in (kind, *goes_with):
            faults.at(said[name], (*path, name), f"does not go with {kind}", at_key=True)
    if "offset" in said and not isinstance(said["offset"].value, bool):
        faults.at(said["offset"], (*path, "offset"), "is true or false")
    if kind == "choice":
        return _choice(node, dimension, path, faults)
    if dimension is None:
        faults.at(node, path, "is no quantity: its values can be listed, or drawn by choice")
        return None
    made = (
        _table(said[kind], dimension, folder, path, faults)
        if kind == "table"
        else _MADE[kind](said[kind], dimension, path, faults)
    )
    if made is None:
        return None
    if "within" in said:
        low, high = _within(said["within"], dimension, path, faults)
        made = scatter.Truncated(made, low, high)
        if not made.share > 1e-12:
            faults.at(said["within"], path, "none of the distribution lies within these ends")
            return None
    if added or "offset" not in said or said["offset"].value is not True:
        return Random(made)
    own = next((value for at, _, value in fields.leaves(scenario) if dotted(at) == key), None)
    if not isinstance(own, float):
        faults.at(said["offset"], path, "the scenario has no value of this key to which the offset could be added")
        return None
    return Random(made, own)


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
    if weights is not None and not (
        isinstance(weights, list)
        and len(weights) == len(entries)
        and all(isinstance(w, int | float) and not isinstance(w, bool) and 0 <= w < math.inf for w in weights)
        and sum(weights) > 0
    ):
        faults.at(node.value["weights"], path, "expected a number for each value, none below 0, not all of them 0")
        return None
    words = tuple(_value(one, dimension, path, faults) for one in entries)
    made = scatter.empirical(np.arange(len(words), dtype=float), None if weights is None else np.array(weights, float))
    return Random(made, 0.0, words)


def _table(node: Node, dimension: str, folder: Path, path: At, faults: Faults) -> scatter.Distribution | None:
    if not isinstance(node.value, str):
        faults.at(node, path, "expected the name of a CSV file with one column and its unit")
        return None
    try:
        return observed(folder / node.value, node.value, dimension)
    except NoTable as why:
        faults.at(node, path, str(why))
    except ScenarioFault as why:
        faults.found += why.faults
    return None
