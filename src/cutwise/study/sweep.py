"""Sweeps: the measures of a scenario over values of one or more of its keys."""

from collections.abc import Callable, Mapping, Sequence
from itertools import product

import numpy as np
import xarray as xr

from cutwise import units
from cutwise.process.recipes import quick_measures
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.scenario import Scenario
from cutwise.study.sensitivity import changed


def sweep(
    scenario: Scenario,
    values: Mapping[str, Sequence[str]],
    progress: Callable[[float], None] | None = None,
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

    Returns
    -------
    xarray.Dataset
        A variable for each measure [SI] with a dimension for each key; NaN where a measure does not apply.

    Raises
    ------
    ScenarioFault
        Values that the scenario refuses: all of them, before anything is run.
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
    rows = []
    for i, one in enumerate(scenarios):
        rows.append(quick_measures(one))
        if progress is not None:
            progress((i + 1) / len(scenarios))
    shape = tuple(len(values[key]) for key in keys)
    known = type(scenario).measures
    data = {
        name: (keys, np.array([row.get(name, np.nan) for row in rows]).reshape(shape),
               {"units": units.DIMENSIONS[known[name].dimension].si, "long_name": known[name].description})
        for name in known
        if any(name in row for row in rows)
    }  # fmt: skip
    return xr.Dataset(data, {key: list(values[key]) for key in keys}, {"scenario": scenario.name})
