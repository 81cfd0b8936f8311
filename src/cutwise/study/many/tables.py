"""Cases of a study as tables: a row a case (pandas), arrays over settings and draws (xarray), files of both."""

import io
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cutwise import units
from cutwise.io.cells import harmless
from cutwise.study.many.answers import dimension_of
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


def csv_of(study: Study, table: Mapping[str, np.ndarray]) -> str:
    """One case a line; SI with units in the titles."""
    found = frame(study, table)
    found["said"] = [harmless(str(text)) for text in found["said"]]
    si = units_of(study)
    heads = {name: f"{name} [{si[name]}]" for name in found.columns if name in si}
    return found.rename(columns=heads).reset_index().to_csv(index=False, lineterminator="\n")


def file_of(study: Study, table: Mapping[str, np.ndarray], ending: str) -> bytes:
    """The cases as the bytes of a file.

    Raises
    ------
    NoWriter
        An ending that says no kind, or one whose package is not installed.
    """
    if ending == ".csv":
        return csv_of(study, table).encode()
    stream = io.BytesIO()
    if ending == ".nc":
        dataset(study, table).to_netcdf(stream, engine="h5netcdf")
        return stream.getvalue()
    if ending != ".parquet":
        raise NoWriter(f"its ending says no format; write {', '.join(ENDINGS)}")
    try:
        import pyarrow  # noqa: F401
    except ImportError:
        raise NoWriter("Parquet needs pyarrow, which is not installed: pip install 'cutwise[tables]'") from None
    frame(study, table).reset_index().to_parquet(stream, engine="pyarrow", index=False)
    return stream.getvalue()
