"""Histories and measures as tables, and stages whose arrays are found by name or answered with the nearest one."""

from collections.abc import Mapping
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

import pandas as pd
import xarray as xr

from cutwise.spec.faults import NoSuchName

if TYPE_CHECKING:
    from cutwise.results import Measure

_MOST_COMPONENTS = 12  # entries of a second dimension that become columns of their own


class Stage(xr.DataTree):
    """A stage of a result; an array that is not there is answered with the nearest one."""

    __slots__ = ()

    @classmethod
    def of(cls, node: xr.DataTree) -> "Stage":
        """The stage of a node of the tree, with the same arrays."""
        return cls(dataset=node.to_dataset(), children=dict(node.children), name=node.name)

    def __getitem__(self, key: Any) -> Any:
        try:
            return super().__getitem__(key)
        except KeyError:
            raise NoSuchName("column", key, map(str, self.variables), f'result["{self.name}"]') from None

    def __getattr__(self, name: str) -> Any:
        try:
            return super().__getattr__(name)  # type: ignore[misc]
        except AttributeError:
            near = get_close_matches(name, [str(one) for one in self.variables], n=1)
            if name.startswith("_") or not near:
                raise
            raise AttributeError(f'no column "{name}"; did you mean {near[0]}? (result["{self.name}"])') from None


def histories(data: xr.Dataset) -> pd.DataFrame:
    """The arrays over time (else over what most of them run over) as columns, a component each.

    Parameters
    ----------
    data : xarray.Dataset
        A stage.

    Returns
    -------
    pandas.DataFrame
        In SI, indexed by time [s]; ``attrs["units"]``: unit of each column; ``attrs["left_out"]``: arrays that run over
        something else, or over more than a few components.
    """
    main = main_dimension(data)
    columns: dict[str, Any] = {}
    units: dict[str, str] = {}
    left_out = []
    for name, array in data.data_vars.items():
        others = [dim for dim in array.dims if dim != main]
        if main not in array.dims or len(others) > 1 or any(array.sizes[dim] > _MOST_COMPONENTS for dim in others):
            left_out.append(str(name))
            continue
        unit = str(array.attrs.get("units", ""))
        for column, part in components(str(name), array, main):
            columns[column], units[column] = part.values, unit
    index = pd.Index(data[main].values, name=main) if main in data.coords else None
    frame = pd.DataFrame(columns, index=index)
    frame.attrs = {"units": units, "index_unit": str(data[main].attrs.get("units", "")) if main in data.coords else ""}
    frame.attrs |= {"left_out": tuple(left_out)} if left_out else {}
    return frame


def main_dimension(data: xr.Dataset) -> str:
    """The dimension that histories run over: time, else the one that most arrays have."""
    if "time" in data.dims:
        return "time"
    counts = {str(dim): sum(dim in array.dims for array in data.data_vars.values()) for dim in data.dims}
    return max(counts, key=lambda dim: (counts[dim], data.sizes[dim]), default="")


def components(name: str, array: xr.DataArray, main: str) -> list[tuple[str, xr.DataArray]]:
    """An array as histories of one number each, named after their places: ``force_x``."""
    others = [str(dim) for dim in array.dims if dim != main]
    if not others:
        return [(name, array)]
    (other,) = others
    names = array[other].values if other in array.coords else range(array.sizes[other])
    return [(f"{name}_{place}", array.isel({other: i})) for i, place in enumerate(names)]


def measures(found: "Mapping[str, Measure]") -> pd.DataFrame:
    """A row a measure: value in SI, unit, description; ends of the band where any measure has one."""
    rows = {
        name: {"value": m.value, "unit": m.unit, "description": m.description}
        | ({"band_sd": m.band.sd, "band_low": m.band.low, "band_high": m.band.high} if m.band is not None else {})
        for name, m in found.items()
    }
    frame = pd.DataFrame.from_dict(rows, orient="index")
    frame.index.name = "measure"
    return frame
