"""Arrays of a finished run in forms that other programs read: CSV tables, and VTK grids for ParaView."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from cutwise import units
from cutwise.disk import file_name, write_together
from cutwise.io.cells import cell

if TYPE_CHECKING:
    from collections.abc import Iterator

_VECTOR = "axis"  # dimension of the components x, y, z


def export(stages: xr.DataTree, folder: Path) -> list[Path]:
    """Write :func:`tables` into a folder, all of them or none."""
    return write_together(folder, {name: text.encode() for name, text in tables(stages).items()})


def tables(stages: xr.DataTree) -> dict[str, str]:
    """Every group as CSV tables, one for each set of dimensions, and every map over a grid as a VTK file.

    Returns
    -------
    dict
        Texts by file names, in the order of the groups.
    """
    found: dict[str, str] = {}
    for name, group in stages.children.items():
        data = group.to_dataset()
        for dimensions, names in _by_dimensions(data).items():
            stem = file_name("_".join((name, *(d for d in dimensions if d != _VECTOR))))
            found[f"{stem}.csv"] = csv(data[names], dimensions)
            if len([d for d in dimensions if d != _VECTOR]) == 3 and "position" in names:
                found[f"{file_name(name)}.vtk"] = vtk(data[names], name)
    return found


def _by_dimensions(data: xr.Dataset) -> dict[tuple[str, ...], list[str]]:
    """Variables by the dimensions that they share; vectors among scalars of the same points."""
    found: dict[tuple[str, ...], list[str]] = {}
    for name, array in data.data_vars.items():
        dimensions = tuple(str(d) for d in array.dims if d != _VECTOR) or tuple(str(d) for d in array.dims)
        found.setdefault(dimensions, []).append(str(name))
    return found


def csv(data: xr.Dataset, dimensions: tuple[str, ...]) -> str:
    """A table with one row for each point; units in the titles, vectors as three columns, SI values."""
    columns: list[tuple[str, np.ndarray]] = []
    shape = tuple(data.sizes[d] for d in dimensions)
    for place, name in enumerate(dimensions):
        along = data[name].values if name in data.coords else np.arange(shape[place])
        spread = along.reshape([-1 if k == place else 1 for k in range(len(shape))])
        columns.append((_title(name, data[name]), np.broadcast_to(spread, shape).ravel()))
    for key, array in data.data_vars.items():
        name = str(key)
        for suffix, part in _components(array, dimensions):
            columns.append((_title(f"{name}{suffix}", array), part.transpose(*dimensions).values.ravel()))
    lines = [", ".join(cell(title) for title, _ in columns)]
    for row in zip(*(values for _, values in columns), strict=True):
        lines.append(", ".join(map(cell, row)))
    return "\n".join(lines) + "\n"


def _components(array: xr.DataArray, dimensions: tuple[str, ...]) -> "Iterator[tuple[str, xr.DataArray]]":
    if _VECTOR in array.dims and _VECTOR not in dimensions:
        for label in array[_VECTOR].values:
            yield f"_{label}", array.sel({_VECTOR: label})
    else:
        yield "", array


def _title(name: str, array: xr.DataArray) -> str:
    unit = str(array.attrs.get("units", "")).replace(", ", " | ")
    return f"{name} [{units.pretty(unit)}]" if unit not in ("", "1") else name


def vtk(data: xr.Dataset, title: str) -> str:
    """A structured grid in the legacy VTK format: points at ``position``, everything else as point data, SI."""
    position = data["position"]
    grid = [str(d) for d in position.dims if d != _VECTOR]
    order = grid[::-1]  # the first index runs fastest in VTK
    points = position.transpose(*order, _VECTOR).values.reshape(-1, 3)
    lines = ["# vtk DataFile Version 3.0", f"cutwise {title}", "ASCII", "DATASET STRUCTURED_GRID"]
    lines.append("DIMENSIONS " + " ".join(str(position.sizes[d]) for d in grid))
    lines += [f"POINTS {len(points)} double", *(" ".join(map(repr, row)) for row in points.tolist())]
    lines.append(f"POINT_DATA {len(points)}")
    for name, array in data.data_vars.items():
        if name == "position":
            continue
        if _VECTOR in array.dims:
            values = array.transpose(*order, _VECTOR).values.reshape(-1, 3)
            lines += [f"VECTORS {name} double", *(" ".join(map(repr, row)) for row in values.tolist())]
        else:
            scalars = array.transpose(*order).values.ravel()
            lines += [f"SCALARS {name} double 1", "LOOKUP_TABLE default", *map(repr, scalars.tolist())]
    return "\n".join(lines) + "\n"
