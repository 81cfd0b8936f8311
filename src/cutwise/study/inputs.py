"""Input values that are known with a scatter, as one list of numbers with a covariance in which their errors are normal."""

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise import units
from cutwise.io.revision import Value
from cutwise.spec import fields
from cutwise.spec.faults import Path, dotted, split_dotted
from cutwise.spec.scenario import Scenario

FloatArray = npt.NDArray[np.float64]


class Input(NamedTuple):
    """A number of the scenario."""

    key: str
    leaf: str  # the key that is written: of the number, or of the list that holds it
    inside: Path  # where in that list
    dimension: str
    kind: str  # in which quantity its errors are normal: value, reciprocal, log
    value: float  # SI

    @property
    def normal(self) -> float:
        """The value in the quantity in which its errors are normal."""
        return {"value": self.value, "reciprocal": 1.0 / self.value if self.value else math.inf}.get(
            self.kind, math.log(self.value) if self.value > 0.0 else math.nan
        )

    def turned(self, normal: float) -> float:
        """The value of a quantity in which the errors are normal; infinite or NaN where there is none."""
        if self.kind == "reciprocal":
            return 1.0 / normal if normal != 0.0 else math.inf
        return math.exp(normal) if self.kind == "log" else normal


class Block(NamedTuple):
    """Inputs that were fitted together."""

    places: tuple[int, ...]  # of its inputs
    covariance: FloatArray
    degrees_of_freedom: float
    alone: bool  # a standard error without a covariance to others


class Scatter(NamedTuple):
    """All inputs with a scatter."""

    inputs: tuple[Input, ...]
    blocks: tuple[Block, ...]
    undetermined: tuple[str, ...]  # keys of values that their data do not tell

    @property
    def standard_errors(self) -> FloatArray:
        """Of the inputs, in the quantity in which they are normal."""
        found = np.zeros(len(self.inputs))
        for block in self.blocks:
            found[list(block.places)] = np.sqrt(np.diagonal(block.covariance))
        return found


def scatter_of(scenario: Scenario, without: Collection[str] = ()) -> Scatter:
    """The inputs of a scenario that have a covariance or a standard error.

    Parameters
    ----------
    without : collection of str
        Keys that have been given other values than those that the covariances speak of.
    """
    leaves = {dotted(path): (info, value) for path, info, value in fields.leaves(scenario)}
    inputs: list[Input] = []
    blocks: list[Block] = []
    unknown: list[str] = []
    for one in scenario.covariances.values():
        kept = []
        for k, (key, kind) in enumerate(zip(one.of, one.kinds, strict=True)):
            found = _input(type(scenario), leaves, key, kind)
            if found is not None and (
                found.leaf in without or key in without or _replaced(scenario, found, one.library)
            ):
                continue
            if key in one.undetermined:
                unknown.append(key)
            elif found is not None and one.matrix[k][k] > 0.0 and all(found.key != other.key for other in inputs):
                kept.append(k)
                inputs.append(found)
        if kept:
            matrix = np.array(one.matrix, dtype=float)[np.ix_(kept, kept)]
            places = tuple(range(len(inputs) - len(kept), len(inputs)))
            blocks.append(Block(places, 0.5 * (matrix + matrix.T), one.degrees_of_freedom or math.inf, one.alone))
    return Scatter(tuple(inputs), tuple(blocks), tuple(unknown))


def _replaced(scenario: Scenario, found: Input, library: str) -> bool:
    """Whether a value no longer comes from the entry whose covariance this is."""
    origin = scenario.origins.get(found.leaf)
    return bool(library) and origin is not None and origin.library != library


def _input(model: type[Scenario], leaves: Mapping[str, tuple[Any, Any]], key: str, kind: str) -> Input | None:
    """The number at a key; None if there is none."""
    path = split_dotted(key)
    for end in range(len(path), 0, -1):
        leaf = dotted(path[:end])
        if leaf in leaves:
            _, value = leaves[leaf]
            break
    else:
        return None
    for step in path[end:]:
        if not isinstance(value, tuple) or not isinstance(step, int) or step >= len(value):
            return None
        value = value[step]
    if isinstance(value, bool) or not isinstance(value, float | int):
        return None
    found = Input(key, leaf, path[end:], fields.dimension_at(model, path) or "dimensionless", kind, float(value))
    return found if math.isfinite(found.normal) else None


def overrides(scenario: Scenario, inputs: Sequence[Input]) -> Callable[[Mapping[int, float]], dict[str, Value]]:
    """A function that gives the overrides with which some of the inputs have other values [SI]."""
    leaves = {dotted(path): value for path, _, value in fields.leaves(scenario)}
    model = type(scenario)

    def given(values: Mapping[int, float]) -> dict[str, Value]:
        changed: dict[str, Any] = {}
        for place, value in values.items():
            one = inputs[place]
            changed[one.leaf] = _with(changed.get(one.leaf, leaves[one.leaf]), one.inside, value)
        return {leaf: _said(model, split_dotted(leaf), value) for leaf, value in changed.items()}

    return given


def _with(whole: Any, inside: Path, value: float) -> Any:
    if not inside:
        return value
    step = inside[0]
    return (*whole[:step], _with(whole[step], inside[1:], value), *whole[step + 1 :])  # type: ignore[operator]


def _said(model: type[Scenario], path: Path, value: Any) -> Value:
    """As an override has it; lists of lists, and of several dimensions, as text."""
    if not isinstance(value, tuple):
        return value
    dimensions = {fields.dimension_at(model, (*path, k)) for k in range(len(value))}
    plain = not any(isinstance(entry, tuple) for entry in value) and len(dimensions) == 1
    return value if plain else _text(model, path, value)


def _text(model: type[Scenario], path: Path, value: Any) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(_text(model, (*path, k), entry) for k, entry in enumerate(value))}]"
    return units.text(value, fields.dimension_at(model, path) or "dimensionless")


def without_scatter(scenario: Scenario, scatter: Scatter) -> Iterator[str]:
    """Keys of quantities that come from the library or are measured, and have no standard error."""
    known = {one.leaf for one in scatter.inputs} | set(scatter.undetermined)
    for path, info, value in fields.leaves(scenario):
        key = dotted(path)
        origin = scenario.origins.get(key)
        if origin is None or key in known or origin.status in ("user", "derived") or not fields.dimension(info):
            continue
        if isinstance(value, float) or (isinstance(value, tuple) and value and isinstance(value[0], float)):
            yield key
