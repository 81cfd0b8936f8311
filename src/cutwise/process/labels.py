"""Arrays with names, units and dimensions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from cutwise.later import later
from cutwise.maths.curves import FloatArray

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")


def labelled(
    coordinate: tuple[str, FloatArray, str, str],
    variables: Mapping[str, tuple[FloatArray, str, str]],
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
