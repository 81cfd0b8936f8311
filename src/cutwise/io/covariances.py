"""Covariance blocks of a library entry: what can be wrong with them."""

from collections.abc import Iterator

import numpy as np

from cutwise.io.tree import Node
from cutwise.spec.faults import Fault, Path, split_dotted

_KEYS = ("of", "as", "degrees_of_freedom", "matrix", "unit")
_AS = ("value", "reciprocal", "log")
_ROUNDING = 1e-6


def covariance_faults(node: Node, values: Node) -> Iterator[Fault]:
    """Everything wrong with ``covariances``: names of no value, matrices that are none of covariances."""
    if not isinstance(node.value, dict):
        yield node.fault(
            ("covariances",), "expected a section with a name for each covariance, each {of, as, matrix, ...}"
        )
        return
    for name, block in node.value.items():
        path: Path = ("covariances", name)
        if not isinstance(block.value, dict) or not {"of", "matrix"} <= set(block.value):
            yield block.fault(path, "needs of (the values) and matrix (their covariance)")
            continue
        for key in block.value:
            if key not in _KEYS:
                message = f"unknown key; a covariance has {', '.join(_KEYS)}"
                yield block.value[key].fault((*path, key), message, at_key=True)
        of = block.value["of"].plain()
        names = [str(one) for one in of] if isinstance(of, list) else []
        for one in names:
            if not _there(values, one):
                yield block.value["of"].fault((*path, "of"), f"{one} is no value of this entry")
        kinds = block.value["as"].plain() if "as" in block.value else "value"
        for kind in kinds if isinstance(kinds, list) else [kinds]:
            if kind not in _AS:
                yield block.value["as"].fault((*path, "as"), f'"{kind}" is not one of {", ".join(_AS)}')
        fault = matrix_fault(block.value["matrix"].plain(), len(names))
        if fault:
            yield block.value["matrix"].fault((*path, "matrix"), fault)


def _there(values: Node, name: str) -> bool:
    """Whether a dotted key leads to a value of the entry, wrapped as ``{value, status}`` or not."""
    node: Node | None = values
    for step in split_dotted(name):
        while node is not None and isinstance(node.value, dict) and "value" in node.value and step not in node.value:
            node = node.value["value"]
        node = node.at((step,)) if node is not None else None
    return node is not None


def matrix_fault(given: object, count: int) -> str:
    """Why a matrix is no covariance of so many values; empty if it is one."""
    try:
        matrix = np.array(given, dtype=float)
    except (TypeError, ValueError):
        return "is not a square of numbers"
    if matrix.shape != (count, count) or not np.all(np.isfinite(matrix)):
        return f"is {'x'.join(map(str, matrix.shape))}; {count} values need {count} rows of {count} finite numbers"
    sd = np.sqrt(np.maximum(np.diagonal(matrix), 0.0))
    scale = np.where(sd > 0.0, sd, 1.0)
    scaled = matrix / np.outer(scale, scale)
    if np.any(np.abs(scaled - scaled.T) > _ROUNDING):
        return "is not symmetric; a covariance is"
    if np.any(np.diagonal(matrix) < 0.0) or np.linalg.eigvalsh(scaled).min() < -_ROUNDING * max(count, 1):
        return "is not positive semi-definite: some combination of the values would have a negative variance"
    return ""
