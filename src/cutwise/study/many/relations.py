"""Inputs that scatter together, as written: a correlation of some levers, or the covariance of a measured entry."""

import math
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from cutwise.io.tree import Node
from cutwise.spec.scenario import Scenario
from cutwise.study.inputs import Block, Input, Scatter, scatter_of
from cutwise.study.many.definition import Correlated, Random
from cutwise.study.many.distributions import Distribution, LogNormal, Normal, Reciprocal, Truncated
from cutwise.study.many.levers import At, Faults, Levers, ends_of, share_beyond

_EXAMPLE = "{keys: [part.burr.height, part.burr.width], correlation: 0.5} or {entry: material.library}"
_CUT, _MOST_CUT = 1e-9, 0.05  # share of a measured value beyond what it may be that is drawn again; that is too much
_SMALLEST = 1e-12  # eigenvalue of a correlation


def relations_of(tree: Node, scenario: Scenario, levers: Levers, faults: Faults) -> tuple[Correlated, ...]:
    """Everything under ``correlated``; the values of measured entries join the levers."""
    node = tree.value.get("correlated")
    if node is None:
        return ()
    if not isinstance(node.value, list) or not node.value:
        faults.at(node, ("correlated",), f"expected a list, for example [{_EXAMPLE}]")
        return ()
    found: list[Correlated] = []
    for k, one in enumerate(node.value):
        path: At = ("correlated", k)
        given = one.value if isinstance(one.value, dict) else {}
        if given.keys() == {"entry"}:
            found += _entry(given["entry"], path, scenario, levers, faults)
        elif given.keys() == {"keys", "correlation"}:
            group = _group(given, path, levers, faults)
            found += [] if group is None else [group]
        else:
            faults.at(one, path, f"expected {_EXAMPLE}")
    named = [key for group in found for key in group.keys]
    for key in dict.fromkeys(key for key in named if named.count(key) > 1):
        faults.at(node, ("correlated",), f"{key} stands in two groups; write one with the whole matrix")
    return tuple(found)


def _group(given: dict[str, Node], path: At, levers: Levers, faults: Faults) -> Correlated | None:
    keys = given["keys"].plain()
    if not isinstance(keys, list) or len(keys) < 2 or len(set(map(str, keys))) != len(keys):
        faults.at(given["keys"], (*path, "keys"), "expected two keys or more, each once")
        return None
    for key in keys:
        lever = levers.random.get(str(key))
        if lever is None:
            faults.at(given["keys"], (*path, "keys"), f"{key} does not scatter (vary)")
        elif lever.words or lever.curve:
            what = "is a curve" if lever.curve else "is a choice"
            faults.at(given["keys"], (*path, "keys"), f"{key} {what}, which has no correlation with others")
    matrix = _matrix(given["correlation"].plain(), len(keys))
    if matrix is None:
        faults.at(
            given["correlation"],
            (*path, "correlation"),
            f"expected a number between -1 and 1, or a symmetric matrix of {len(keys)} rows with ones on its diagonal",
        )
        return None
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < _SMALLEST:
        faults.at(
            given["correlation"], (*path, "correlation"),
            f"no inputs can be correlated so: the matrix is not positive definite, its smallest eigenvalue is {least:.3g}",
        )  # fmt: skip
        return None
    return Correlated(tuple(map(str, keys)), tuple(map(tuple, matrix.tolist())))


def _matrix(given: object, count: int) -> NDArray[np.float64] | None:
    """A correlation as a matrix; a number is that of every pair."""
    try:
        read = np.array(given, dtype=float)
    except (TypeError, ValueError):
        return None
    if read.ndim == 0:
        read = np.full((count, count), float(read))
        np.fill_diagonal(read, 1.0)
    fits = read.shape == (count, count) and np.isfinite(read).all() and not isinstance(given, bool)
    if not fits or not np.array_equal(read, read.T) or (np.diagonal(read) != 1.0).any() or (np.abs(read) > 1.0).any():
        return None
    return read


def _entry(node: Node, path: At, scenario: Scenario, levers: Levers, faults: Faults) -> list[Correlated]:
    """The values of a measured entry as levers, and how they go together."""
    said = str(node.plain())
    section, _, last = said.rpartition(".")
    if last != "library" or not section:
        faults.at(node, (*path, "entry"), f"{said} names no entry; write for example material.library")
        return []
    scatter = scatter_of(scenario)
    blocks = [
        block for block in scatter.blocks
        if all(_inside(scatter.inputs[place], section) for place in block.places)
    ]  # fmt: skip
    if not blocks:
        faults.at(
            node, (*path, "entry"),
            f"{section} has no values with a covariance; cutwise calibrate gives entries that have them",
        )  # fmt: skip
        return []
    return [
        group
        for block in blocks
        if (group := _joined(node, path, scenario, scatter, block, levers, faults)) is not None
    ]


def _inside(one: Input, section: str) -> bool:
    return one.key.startswith((f"{section}.", f"{section}["))


def _joined(
    node: Node, path: At, scenario: Scenario, scatter: Scatter, block: Block, levers: Levers, faults: Faults
) -> Correlated | None:  # fmt: skip
    """Put the inputs of one covariance among the levers; None if it is of one value alone."""
    inputs = [scatter.inputs[place] for place in block.places]
    for one in inputs:
        for key in (one.key, one.leaf):
            if key in levers.random or key in levers.design or key in levers.between:
                faults.at(node, (*path, "entry"), f"{key} is moved twice: by vary, and by the covariance of its entry")
                return None
    sd = np.sqrt(np.diagonal(block.covariance))
    for one, deviation in zip(inputs, sd, strict=True):
        lever = Random(_law(one, float(deviation)))
        share = share_beyond(scenario, one.key, lever)
        if share > _MOST_CUT:
            faults.at(
                node, (*path, "entry"),
                f"{100 * share:.2g} % of {one.key} would lie beyond what it may be: the entry says too little of it",
            )  # fmt: skip
        if share > _CUT:
            lever = Random(Truncated(lever.distribution, *ends_of(scenario, one.key)))
        levers.random[one.key] = lever
    if len(inputs) == 1:
        return None
    sign = np.array(
        [-1.0 if one.kind == "reciprocal" else 1.0 for one in inputs]
    )  # a value falls as its reciprocal rises
    matrix = block.covariance / np.outer(sd, sd) * np.outer(sign, sign)
    np.fill_diagonal(matrix, 1.0)
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < _SMALLEST:
        faults.at(
            node, (*path, "entry"),
            f"the covariance of {', '.join(one.key for one in inputs)} is not positive definite: the smallest eigenvalue of "
            f"its correlation is {least:.3g}",
        )  # fmt: skip
        return None
    return Correlated(tuple(one.key for one in inputs), tuple(map(tuple, matrix.tolist())))


def _law(one: Input, deviation: float) -> Distribution:
    """The law of a value whose errors are normal in the quantity that its entry names."""
    if one.kind == "log":
        return LogNormal(one.value, deviation)
    return Reciprocal(1.0 / one.value, deviation) if one.kind == "reciprocal" else Normal(one.value, deviation)


def cut_off(scenario: Scenario, random: Mapping[str, Random]) -> Iterator[str]:
    """Values of measured entries, some of whose scatter lies beyond what they may be."""
    measured = {one.key for one in scatter_of(scenario).inputs}
    for key, lever in random.items():
        if key in measured and isinstance(lever.distribution, Truncated):
            share = share_beyond(scenario, key, Random(lever.distribution.whole))
            yield f"{100 * share:.2g} % of the scatter of {key} lies beyond what it may be, and is drawn again"


def few_degrees(scenario: Scenario, correlated: tuple[Correlated, ...], most: float = 30.0) -> str:
    """That covariances come from fits of few degrees of freedom; empty if not."""
    scatter = scatter_of(scenario)
    keys = {key for group in correlated for key in group.keys}
    few = [
        block.degrees_of_freedom
        for block in scatter.blocks
        if block.degrees_of_freedom < most and any(scatter.inputs[place].key in keys for place in block.places)
    ]
    if not few or math.isinf(min(few)):
        return ""
    return (
        f"values of a measured entry are drawn as normal; their fit has {min(few):g} degrees of freedom, with which larger "
        "errors are likelier than that"
    )
