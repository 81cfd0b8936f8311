"""Sweeps: the measures of a scenario over values of one or more of its keys."""

import io
import re
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from itertools import product
from pathlib import Path

import numpy as np
import xarray as xr

from cutwise import units
from cutwise.disk import write_bytes, write_text
from cutwise.io.cells import harmless
from cutwise.process.recipes import quick_outcome
from cutwise.results import SOUNDNESS, SolverFailure
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.scenario import Scenario
from cutwise.study.sensitivity import changed

_BETWEEN = re.compile(r",(?![^\[{]*[\]}])")  # commas that are not inside a list or mapping


def sweep(
    scenario: Scenario,
    values: Mapping[str, Sequence[str]],
    progress: Callable[[float], None] | None = None,
    wanted: Sequence[str] = (),
) -> xr.Dataset:
    """Every measure over all combinations of values.

    Parameters
    ----------
    scenario : Scenario
        The scenario that everything else is taken from.
    values : mapping
        Dotted key: values as text with units, for example ``{"spindle.pressure": ["4 bar", "5 bar"]}``.
    progress : callable, optional
        Called with the finished share.
    wanted : sequence of str
        Measures that may take long and are computed all the same.

    Returns
    -------
    xarray.Dataset
        A variable for each measure [SI] with a dimension for each key; NaN where a measure does not apply. Combinations
        that cannot be run are NaN throughout and stand in the attribute ``failed``, one a line, with the reason. The
        variable ``unsound`` has the codes of what leaves nothing to be judged, empty for a sound run.

    Raises
    ------
    ScenarioFault
        Values that the scenario refuses: all of them, before anything is run; or no combination can be run.
    SolverFailure
        No combination comes to an end.
    """
    keys = list(values)
    points = list(product(*(values[key] for key in keys)))
    scenarios, faults = [], []
    for point in points:
        try:
            scenarios.append(changed(scenario, dict(zip(keys, point, strict=True))))
        except ScenarioFault as fault:
            faults += fault.faults
    if not points:
        faults.append(Fault((), "a sweep needs at least one value for each key"))
    if faults:
        raise ScenarioFault(list(dict.fromkeys(faults)))
    rows: list[Mapping[str, float]] = []
    unsound: list[str] = []
    failed: dict[str, ScenarioFault | SolverFailure] = {}
    for i, (point, one) in enumerate(zip(points, scenarios, strict=True)):
        try:
            outcome = quick_outcome(one, wanted)
            rows.append(outcome.measures)
            unsound.append(", ".join(dict.fromkeys(f.code for f in outcome.findings if f.code in SOUNDNESS)))
        except (ScenarioFault, SolverFailure) as why:
            failed[", ".join(f"{key}={value}" for key, value in zip(keys, point, strict=True))] = why
            rows.append({})
            unsound.append("not run")
        if progress is not None:
            progress((i + 1) / len(scenarios))
    if len(failed) == len(rows):
        raise next(iter(failed.values()))
    shape = tuple(len(values[key]) for key in keys)
    known = type(scenario).measures
    data = {
        name: (keys, np.array([row.get(name, np.nan) for row in rows]).reshape(shape),
               {"units": units.DIMENSIONS[known[name].dimension].si, "long_name": known[name].description})
        for name in dict.fromkeys(name for row in rows for name in row)
    }  # fmt: skip
    data["unsound"] = (
        keys,
        np.array(unsound, dtype=str).reshape(shape),
        {"long_name": "why a run is not sound, by code"},
    )
    reasons = [f"{point}: {said}" for point, why in failed.items() for said in _sentences(why)]
    attributes = {"scenario": scenario.name} | ({"failed": "\n".join(reasons)} if reasons else {})
    return xr.Dataset(data, {key: list(values[key]) for key in keys}, attributes)


def _sentences(why: ScenarioFault | SolverFailure) -> list[str]:
    return [str(fault) for fault in why.faults] if isinstance(why, ScenarioFault) else [str(why)]


def parse_values(texts: Sequence[str]) -> dict[str, list[str]]:
    """``key=value,value,...`` as keys and their values.

    Raises
    ------
    ScenarioFault
        A text of another form, or a key given twice.
    """
    values: dict[str, list[str]] = {}
    faults = []
    for text in texts:
        key, sign, rest = text.partition("=")
        key = key.strip()
        found = [value.strip() for value in _BETWEEN.split(rest) if value.strip()]
        if not sign or not key or not found:
            faults.append(Fault((), "is not of the form dotted.key=value,value,...", file=f"--over {text}"))
        elif key in values:
            faults.append(Fault((), "is given twice; write all values behind one --over", file=f"--over {key}"))
        else:
            values[key] = found
    if faults:
        raise ScenarioFault(faults)
    return values


def shown_measures(scenario: Scenario, names: Sequence[str]) -> list[str]:
    """The measures asked for, or those that the scenario limits, or the one its process is about.

    Raises
    ------
    ScenarioFault
        A name that is no measure of the process.
    """
    known = type(scenario).measures
    wrong = [name for name in names if name not in known]
    if wrong:
        raise ScenarioFault([_unknown(name, list(known)) for name in wrong])
    return list(names) or list(scenario.requirements) or [scenario.focus or next(iter(known))]


def _unknown(name: str, known: list[str]) -> Fault:
    near = get_close_matches(name, known, n=1)
    hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
    return Fault((), f"unknown measure; {hint}", file=f"--measure {name}")


def save(table: xr.Dataset, path: Path) -> Path:
    """Write a sweep as CSV (one row a run, units in the header) or netCDF; whole or not at all."""
    if path.suffix == ".csv":
        frame = table.to_dataframe().reset_index()
        frame.columns = [harmless(_headed(table, str(name))) for name in frame.columns]
        texts = frame.select_dtypes(exclude="number")
        frame[texts.columns] = texts.map(lambda value: harmless(str(value)))
        return write_text(path, frame.to_csv(index=False, lineterminator="\n"))
    stream = io.BytesIO()
    table.to_netcdf(stream, engine="h5netcdf")
    return write_bytes(path, stream.getvalue())


def _headed(table: xr.Dataset, name: str) -> str:
    unit = table[name].attrs.get("units", "")
    return f"{name} [{unit}]" if unit else name
