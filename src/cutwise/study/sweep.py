"""Sweeps: the measures of a scenario over values of one or more of its keys."""

import io
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from cutwise import units
from cutwise.disk import write_bytes, write_text
from cutwise.io.cells import harmless
from cutwise.io.revision import Value, revisions
from cutwise.process.recipes import simulate
from cutwise.results import SOUNDNESS, SolverFailure
from cutwise.spec import fields
from cutwise.spec.faults import Fault, ScenarioFault, split_dotted
from cutwise.spec.scenario import Scenario
from cutwise.study.case import Case
from cutwise.study.limits import slack
from cutwise.study.many.definition import GRID, Design, Study, combinations
from cutwise.study.many.pool import held_evaluators, pooled

VALUES = 'values["{}"]'
"""How a message names a value of a sweep in Python; the command line says ``--over``."""
TEXT = "{} as written"
"""Name of the coordinate that holds the values of a key as they were written."""

_BETWEEN = re.compile(r",(?![^\[{]*[\]}])")  # commas that are not inside a list or mapping


def sweep(
    scenario: Scenario,
    values: Mapping[str, Sequence[Value]],
    progress: Callable[[float], None] | None = None,
    wanted: Sequence[str] = (),
    *,
    check: bool = True,
    jobs: int = 1,
    named: str = VALUES,
) -> xr.Dataset:
    """Every measure over all combinations of values, each as its own run gives it to the last bit.

    Parameters
    ----------
    scenario : Scenario
        The scenario that everything else is taken from.
    values : mapping
        Dotted key: values as text with units, for example ``{"spindle.pressure": ["4 bar", "5 bar"]}``, or in SI.
    progress : callable, optional
        Called with the finished share.
    wanted : sequence of str
        Measures that may take long and are computed all the same.
    check : bool
        Run the first, the last and the worst combination in full, with half the step too: what the run has to say about
        its step joins the warnings there, and attribute ``checked`` tells the largest difference from the run.
    jobs : int
        Processes; the numbers do not depend on it.
    named : str
        How messages name a value, with ``{}`` for its key.

    Returns
    -------
    xarray.Dataset
        A variable for each measure [SI] with a dimension for each key, whose coordinates are numbers in SI where the key
        is a quantity (attributes ``units``, ``display_unit``); the values as written stand beside them. NaN where a
        measure does not apply. ``warnings`` and ``infeasible`` hold what each run says, one sentence a line, ``unsound``
        the codes of what leaves nothing to be judged.
        Combinations that cannot be run are NaN throughout and stand in the attribute ``failed``, one a line.

    Raises
    ------
    TypeError
        Values that are no mapping.
    ScenarioFault
        Values that the scenario refuses, or measures that it does not have: all of them, before anything is run; or no
        combination can be run.
    SolverFailure
        No combination comes to an end.
    """
    if not isinstance(values, Mapping):
        raise TypeError('values are lists by their keys, {"spindle.pressure": ["4 bar", "5 bar"]}; this is a '
                        f"{type(values).__name__}")  # fmt: skip
    single = [key for key, some in values.items() if isinstance(some, str) or not isinstance(some, Iterable)]
    if single:  # a text would be swept letter by letter
        raise ScenarioFault([Fault((), "expected a list of values, for example [\"4 bar\", \"5 bar\"]", file=named.format(key))
                             for key in single])  # fmt: skip
    keys = list(values)
    grid = Study(
        scenario.name, scenario, None, {key: Design(tuple(values[key])) for key in keys}, {}, GRID, 1, 0, tuple(wanted), None, None
    )  # fmt: skip
    points = list(combinations(grid))
    scenarios = _checked(scenario, points, wanted, named)
    with pooled(grid, jobs) as pool:
        told = None if progress is None else (lambda done: progress(done / len(points)))
        found: list[Case] = pool.map(_case, [(point,) for point in points], told)
    failed = [case for case in found if case.failure is not None]
    if len(failed) == len(found):
        raise failed[0].failure  # type: ignore[misc]
    said = _in_full(scenarios, found) if check else ""
    return _table(scenario, values, found, failed, said)


def _case(values: Mapping[str, Value]) -> Case:
    """A combination, with the step of the scenario."""
    return held_evaluators()[1](values)


def _checked(
    scenario: Scenario, points: Sequence[Mapping[str, Value]], wanted: Sequence[str], named: str
) -> list[Scenario]:
    """The scenario of every combination."""
    revised = revisions(scenario, named)
    known = type(scenario).measures
    scenarios, faults = [], [_unknown(name, list(known), "wanted") for name in wanted if name not in known]
    for point in points:
        try:
            scenarios.append(revised(point))
        except ScenarioFault as fault:
            faults += fault.faults
    if not points:
        faults.append(Fault((), "a sweep needs at least one value for each key"))
    if faults:
        raise ScenarioFault(list(dict.fromkeys(faults)))
    return scenarios


def _in_full(scenarios: Sequence[Scenario], found: list[Case]) -> str:
    """Run the ends and the worst case as ``run`` does; their warnings join those of the case."""
    ran = [i for i, case in enumerate(found) if case.failure is None]
    rooms = {i: _room(scenarios[i], found[i]) for i in ran}
    difference = 0.0
    at = sorted({ran[0], ran[-1], min(ran, key=rooms.__getitem__)})
    for i in at:
        whole = simulate(scenarios[i])
        outcome = found[i].outcome
        for name, value in outcome.measures.items():
            measure = whole.measures.get(name)
            other = measure.value if measure is not None else np.inf
            difference = max(difference, abs(value - other) / (abs(other) or 1.0))
        warnings = tuple(dict.fromkeys((*outcome.warnings, *whole.warnings)))
        findings = tuple(dict.fromkeys((*outcome.findings, *whole.findings)))
        found[i] = found[i]._replace(outcome=outcome._replace(warnings=warnings, findings=findings))
    return f"first, last and worst combination run in full: the largest relative difference of a measure is {difference:.2g}"


def _room(scenario: Scenario, case: Case) -> float:
    """How far a case is from its limits; without any, from the largest value of what the process is about."""
    if scenario.requirements:
        return slack(scenario, case.outcome)
    return -abs(case.measures.get(scenario.focus, 0.0))


def _table(
    scenario: Scenario, values: Mapping[str, Sequence[Value]], found: Sequence[Case], failed: Sequence[Case], said: str
) -> xr.Dataset:
    keys, shape = list(values), tuple(len(entries) for entries in values.values())
    known = type(scenario).measures
    data: dict[str, Any] = {
        name: (keys, np.array([case.measures.get(name, np.nan) for case in found]).reshape(shape),
               {"units": units.DIMENSIONS[known[name].dimension].si, "long_name": known[name].description})
        for name in dict.fromkeys(name for case in found for name in case.measures)
    }  # fmt: skip
    for what in ("warnings", "infeasible", "unsound"):
        lines = ["\n".join(_said(case, what)) for case in found]
        data[what] = (keys, np.array(lines, dtype=object).reshape(shape))
    coordinates: dict[str, Any] = {}
    for key, entries in values.items():
        coordinates |= _coordinates(scenario, key, entries)
    reasons = [f"{_point(case.values)}: {text}" for case in failed for text in _sentences(case.failure)]
    attributes = {"scenario": scenario.name, "checked": said, "failed": "\n".join(reasons)}
    return xr.Dataset(data, coordinates, {name: text for name, text in attributes.items() if text})


def _coordinates(scenario: Scenario, key: str, entries: Sequence[Value]) -> dict[str, Any]:
    """The values of a key as numbers in SI, with the texts beside them; as texts where they are no quantities."""
    texts = [str(entry) for entry in entries]
    info = fields.field_at(type(scenario), split_dotted(key))
    dimension = fields.dimension(info) if info is not None else None
    if dimension is None:
        if all(re.fullmatch(r"[+-]?\d+", text) for text in texts):  # numbers of things
            return {key: (key, [int(text) for text in texts]), TEXT.format(key): (key, texts)}
        return {key: (key, texts)}
    try:
        numbers = [units.parse(e, dimension) if isinstance(e, str) else float(e) for e in entries]  # type: ignore[arg-type]
    except (units.UnitFault, TypeError):  # a word, a list or a table instead of a quantity
        return {key: (key, texts)}
    unit = units.DIMENSIONS[dimension]
    assert info is not None
    said = {"units": unit.si, "display_unit": units.pretty(unit.display), "long_name": info.description or key}
    return {key: (key, numbers, said), TEXT.format(key): (key, texts)}


def _said(case: Case, what: str) -> Sequence[str]:
    """What a run says: sentences, and codes of what leaves nothing to be judged."""
    if what != "unsound":
        return tuple(getattr(case.outcome, what))
    codes = (finding.code for finding in case.outcome.findings if finding.code in SOUNDNESS)
    return tuple(dict.fromkeys(codes)) if case.failure is None else ("not run",)


def _point(values: Mapping[str, Value]) -> str:
    return ", ".join(f"{key}={value}" for key, value in values.items())


def _sentences(why: ScenarioFault | SolverFailure | None) -> list[str]:
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
        raise ScenarioFault([_unknown(name, list(known), f"--measure {name}") for name in wrong])
    return list(names) or list(scenario.requirements) or [scenario.focus or next(iter(known))]


def _unknown(name: str, known: list[str], place: str) -> Fault:
    near = get_close_matches(name, known, n=1)
    hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}"
    return Fault((), f"{'' if name in place else name + ': '}unknown measure; {hint}", file=place)


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
