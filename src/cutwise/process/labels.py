"""Arrays with names, units and dimensions: what a history holds is said in tables, and read in one place."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise.later import later

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")

Read = Callable[[Any], Any]
"""What takes an array, or labels, from a run; None where the run has none."""


class Column(NamedTuple):
    """A column of a history: over which dimensions (names with spaces between), how it is read, its unit, what it is."""

    over: str
    read: Read
    unit: str
    text: str | Callable[[Any], str]  # where it is something else from run to run


class Coordinate(NamedTuple):
    """The values of a dimension, with their unit."""

    read: Read
    unit: str
    text: str


Over = Mapping[str, "Coordinate | Sequence[Any] | Read"]
"""Coordinates or labels of dimensions, or what takes labels from a run."""


class Group(NamedTuple):
    """A group of a result: its columns, and the coordinates or labels of their dimensions."""

    columns: Mapping[str, Column]
    over: Over
    apply: Callable[[Any], bool] = lambda _: True  # whether a run has it
    attrs: Callable[[Any], Mapping[str, Any]] | None = None  # single numbers that go with it


Groups = Mapping[str, "Group | xr.Dataset"]


def tree(run: Any, stages: Groups | xr.DataTree) -> xr.DataTree:
    """The groups of a result: of a run as tables say it, or made already.

    A column that is None, and a group without any, is left out; so is what does not apply to the run.
    """
    if not isinstance(stages, Mapping) or isinstance(stages, xr.DataTree):
        return stages
    made = {
        name: (table(run, one) if one.apply(run) else None) if isinstance(one, Group) else one
        for name, one in stages.items()
    }
    return xr.DataTree.from_dict({name: one for name, one in made.items() if one is not None})


def table(run: Any, group: Group) -> xr.Dataset | None:
    """The columns of a group that a run has; None where it has none of them."""
    data = {}
    for name, column in group.columns.items():
        values = column.read(run)
        if values is not None:
            text = column.text if isinstance(column.text, str) else column.text(run)
            data[name] = (tuple(column.over.split()), values, {"units": column.unit, "long_name": text})
    used = dict.fromkeys(dim for dims, _, _ in data.values() for dim in dims)
    coords = {dim: _coordinate(run, dim, group.over[dim]) for dim in used if dim in group.over}
    return xr.Dataset(data, coords, group.attrs(run) if group.attrs else None) if data else None


def _coordinate(run: Any, dim: str, said: Coordinate | Sequence[Any] | Read) -> Any:
    if isinstance(said, Coordinate):
        return dim, said.read(run), {"units": said.unit, "long_name": said.text}
    return said(run) if callable(said) else list(said)


def labelled(
    coordinate: tuple[str, Any, str, str],
    variables: Mapping[str, tuple[npt.NDArray[np.number[Any]], str, str]],
    **more: Sequence[Any],
) -> xr.Dataset:
    """A data set over one coordinate (name, values, unit, long name); further dimensions are found by their size."""
    name, values, unit, long_name = coordinate
    coords: dict[str, Any] = {name: (name, values, {"units": unit, "long_name": long_name})}
    data = {}
    used = set()
    for key, (array, array_unit, text) in variables.items():
        dims = [name]
        for size in array.shape[1:]:
            dims.append(next(d for d, labels in more.items() if len(labels) == size))
        used.update(dims)
        data[key] = (dims, array, {"units": array_unit, "long_name": text})
    coords |= {d: (d, list(labels)) for d, labels in more.items() if d in used}
    return xr.Dataset(data, coords)
