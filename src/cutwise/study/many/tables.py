"""Cases of a study as tables: a row a case (pandas), arrays over settings and draws (xarray), files of both."""

import importlib.util
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from cutwise import units
from cutwise.disk import written_whole
from cutwise.io.cells import harmless
from cutwise.study.many.answers import dimension_of
from cutwise.study.many.columns import Table, aligned, pieces
from cutwise.study.many.definition import Study
from cutwise.study.many.statements import Share

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

ENDINGS = (".csv", ".nc", ".parquet")
STATES = ("good", "bad", "infeasible", "failed")


class NoWriter(ValueError):
    """A package that a kind of file needs is not installed, or there is no such kind."""


def units_of(study: Study) -> dict[str, str]:
    """SI units of levers and measures that are quantities."""
    levers = {key: dimension_of(study, key) for key in study.keys}
    dimensions = {**levers, **{name: study.scenario.measures[name].dimension for name in study.measures}}
    return {name: units.DIMENSIONS[one].si for name, one in dimensions.items() if one is not None}


def frame(study: Study, table: Mapping[str, np.ndarray]) -> "pd.DataFrame":
    """A row a case: levers and measures in SI, their units in ``attrs``."""
    import pandas as pd

    found = pd.DataFrame({key: table[f"lever {key}"] for key in study.keys})
    measures = {name: table[f"measure {name}"] for name in study.measures}
    found = found.assign(**measures, state=[STATES[int(i)] for i in table["state"]], said=table["said"])
    found.index = pd.Index(table["case"], name="case")
    found.attrs["units"] = units_of(study)
    return found


def dataset(study: Study, table: Mapping[str, np.ndarray]) -> "xr.Dataset":
    """Arrays over draws and the settings of design levers, with numeric coordinates in SI; whole rows only."""
    import xarray as xr

    each = study.combinations
    rows = len(table["case"]) // each
    si, shape = units_of(study), (rows, *(len(lever.values) for lever in study.design.values()))
    dims = ("draw", *study.design)

    def said(name: str) -> dict[str, str]:
        return {"units": si[name]} if name in si else {}

    def shaped(values: np.ndarray) -> np.ndarray:
        return np.asarray(values[: rows * each]).reshape(shape)

    data: dict[str, Any] = {
        key: ("draw", np.asarray(table[f"lever {key}"])[: rows * each : each], said(key)) for key in study.random
    }
    data |= {
        name: (
            dims,
            shaped(table[f"measure {name}"]),
            said(name) | {"long_name": study.scenario.measures[name].description},
        )
        for name in study.measures
    }
    data["state"] = (
        dims,
        shaped(table["state"]),
        {"values": ", ".join(f"{i} {word}" for i, word in enumerate(STATES))},
    )
    coordinates: dict[str, Any] = {key: (key, list(lever.values), said(key)) for key, lever in study.design.items()}
    return xr.Dataset(data, {"draw": np.arange(rows), **coordinates}, {"study": study.name, "seed": study.seed})


def over_settings(study: Study, shares: Sequence[tuple[Mapping[str, Any], Share]]) -> "xr.DataArray":
    """Shares of good cases over the settings of design levers, with value, low and high along ``end``."""
    import xarray as xr

    si = units_of(study)
    shape = tuple(len(lever.values) for lever in study.design.values())
    values = (
        np.array([tuple(share) for _, share in shares]).reshape(*shape, 3) if shares else np.full((*shape, 3), np.nan)
    )
    coordinates: dict[str, Any] = {
        key: (key, list(lever.values), {"units": si[key]} if key in si else {}) for key, lever in study.design.items()
    }
    return xr.DataArray(values, {**coordinates, "end": list(Share._fields)}, (*study.design, "end"), "probability")


def dataset_in(found: "xr.Dataset", wanted: Mapping[str, str], study: Study) -> "xr.Dataset":
    """The arrays with some of their values in other units.

    Raises
    ------
    ValueError
        A name that is not there or is no quantity, or a unit of another dimension.
    """
    for name, unit in wanted.items():
        dimension = study.scenario.measures[name].dimension if name in study.measures else None
        if dimension is None and name in study.keys:
            dimension = dimension_of(study, name)
        if dimension is None:
            raise ValueError(f"{name} is no quantity of this study")
        factor = 1.0 / units.factor(unit, dimension)
        found = found.assign_coords({name: found[name] * factor}) if name in found.coords else found.assign(
            {name: found[name] * factor}
        )  # fmt: skip
        found[name].attrs["units"] = unit
    return found


def write_table(study: Study, table: Table, target: Path) -> Path:
    """Write the cases as a file of the kind that its ending says, part by part.

    Raises
    ------
    NoWriter
        An ending that says no kind, or one whose package is not installed.
    OSError
        It cannot be written.
    """
    ending = target.suffix.lower()
    if ending not in ENDINGS:
        raise NoWriter(f"its ending says no format; write {', '.join(ENDINGS)}")
    write = {".csv": _csv, ".nc": _netcdf, ".parquet": _parquet}[ending]
    if ending == ".parquet" and importlib.util.find_spec("pyarrow") is None:
        raise NoWriter("Parquet needs pyarrow, which is not installed: pip install 'cutwise[tables]'")
    with written_whole(target) as partial:
        write(study, table, partial)
    return target


def _csv(study: Study, table: Table, file: Path) -> None:
    """One case a line; SI with units in the titles."""
    si = units_of(study)
    with file.open("w", encoding="utf-8", newline="") as stream:
        for k, piece in enumerate(pieces(table)):
            found = frame(study, piece)
            found["said"] = [harmless(str(text)) for text in found["said"]]
            heads = {name: f"{name} [{si[name]}]" for name in found.columns if name in si}
            found = found.rename(columns=heads).reset_index()
            found.to_csv(stream, index=False, header=k == 0, lineterminator="\n")


def _parquet(study: Study, table: Table, file: Path) -> None:
    """A group of rows a part."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    writer = None
    try:
        for piece in pieces(table):
            found = frame(study, piece).reset_index()
            found.attrs = {}
            rows = pa.Table.from_pandas(found, schema=None if writer is None else writer.schema, preserve_index=False)
            if writer is None:
                about = {**(rows.schema.metadata or {}), b"units": json.dumps(units_of(study)).encode()}
                writer = pq.ParquetWriter(file, rows.schema.with_metadata(about))
            writer.write_table(rows.cast(writer.schema))
    finally:
        if writer is not None:
            writer.close()


def _netcdf(study: Study, table: Table, file: Path) -> None:
    """Arrays over draws and the settings of design levers; whole draws only."""
    import h5netcdf

    done = 0
    with h5netcdf.File(file, "w") as opened:
        for piece in aligned(pieces(table), study.combinations):
            part = dataset(study, piece)
            rows = part.sizes["draw"]
            if not done:
                opened.dimensions = {
                    str(name): size if name in study.design else None for name, size in part.sizes.items()
                }
                opened.attrs.update(part.attrs)
                for name, values in part.variables.items():
                    _variable(opened, str(name), values)
            opened.resize_dimension("draw", done + rows)
            for name, values in part.variables.items():
                if "draw" in values.dims:
                    there = np.arange(done, done + rows) if name == "draw" else _plain(values.values)
                    opened.variables[str(name)][done : done + rows] = there
            done += rows


def _variable(opened: Any, name: str, values: Any) -> None:
    """A variable of a file, with what is said of it; those over settings alone are written at once."""
    plain = _plain(values.values)
    over_draws = "draw" in values.dims
    words = plain.dtype.kind == "O"
    made = opened.create_variable(
        name, values.dims, h5py.string_dtype() if words else plain.dtype, None if over_draws else plain
    )
    made.attrs.update(values.attrs)


def _plain(values: np.ndarray) -> np.ndarray:
    """Words as Python has them."""
    return values.astype(object) if values.dtype.kind in "OU" else values
