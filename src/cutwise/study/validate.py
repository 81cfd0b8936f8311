r"""A scenario held against a measurement, one run for each row; recordings over time: :mod:`cutwise.study.recording`.

Of each measure m, with predictions p and measured values y: rms and mean of :math:`p - y`, their correlation, and the
share of rows with :math:`|p - y| \le t \sqrt{s_b^2 + s_n^2}`, where :math:`s_b` is the standard deviation of the band of
the run and :math:`s_n` the scatter of the measurement.
"""

import logging
import math
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.measurements import WORDS, Channel, Measurement, read_measurement, titles_of
from cutwise.io.revision import Value, revisions
from cutwise.spec import fields
from cutwise.spec.faults import Fault, ScenarioFault, dotted, split_dotted
from cutwise.spec.scenario import Scenario
from cutwise.study import band
from cutwise.study.case import evaluated
from cutwise.study.inputs import FloatArray, scatter_of
from cutwise.study.spread import quantile

GROUP = "group"
_told = logging.getLogger("cutwise.validate")

Progress = Callable[[float], None]


class Figures(NamedTuple):
    """How well a measure is predicted, SI."""

    rms: float
    bias: float  # mean of predicted less measured
    correlation: float | None  # None where one of both does not vary
    inside: float | None  # share of the rows inside the band; None without band and scatter
    rows: int

    def as_json(self) -> dict[str, Any]:
        """The record without what is not known."""
        return {name: value for name, value in self._asdict().items() if value is not None}


class Compared(NamedTuple):
    """Rows of a measure."""

    measured: FloatArray  # SI
    predicted: FloatArray  # NaN where the run has no such measure
    half: FloatArray  # half-width of the 90 % band, widened by the scatter of the measurement; NaN where not known


class Validation(NamedTuple):
    """What came of holding runs against rows."""

    data: Measurement
    scenario: Scenario
    compared: Mapping[str, Compared]  # measure: its rows
    figures: Mapping[str, Figures]
    groups: Mapping[str, Mapping[str, Figures]]
    failed: tuple[str, ...]  # rows that could not be run, with the reason
    warnings: tuple[str, ...]

    def as_json(self, files: Mapping[str, str]) -> dict[str, Any]:
        """In SI, for other programs."""
        return {
            "measures": {name: one.as_json() for name, one in self.figures.items()},
            "groups": {g: {name: one.as_json() for name, one in of.items()} for g, of in self.groups.items()},
            "rows": self.data.rows,
            "not_run": list(self.failed),
            "warnings": list(self.warnings),
            "files": dict(files),
        }


def validated(
    scenario: Scenario, file: Path, noise: str | Mapping[str, str] | None = None, progress: Progress | None = None,
    *, named: str = "{}",
) -> Validation:  # fmt: skip
    """Run every row of a file and hold it against what was measured.

    Parameters
    ----------
    scenario : Scenario
        What stands in no column.
    file : Path
        Columns named as measures, and as keys of the scenario.
    noise : str or mapping, optional
        Scatter of the measurement; left out: what the fits of the entries left, where it has the unit of the measure.
    named : str
        How a message names a setting.

    Raises
    ------
    ScenarioFault
        Everything wrong with file and settings.
    """
    data, measures, keys = _read(scenario, file)
    scatter_of_measure = _noises(scenario, measures, noise, named)
    revised = revisions(scenario)
    scatter = scatter_of(scenario, keys)
    further = 2 * len(scatter.inputs) if scenario.band.method != "none" else 0
    if scenario.band.method == "sampled" and scatter.inputs:
        further = scenario.band.samples
    _told.info("validate: %d rows, %d runs", data.rows, data.rows * (1 + further))
    predicted = {name: np.full(data.rows, math.nan) for name in measures}
    half = {name: np.full(data.rows, math.nan) for name in measures}
    failed, bent = [], set()
    for row in range(data.rows):
        given: dict[str, Value] = {
            key: data.labels[key][row] if key in data.labels else float(data.columns[key][row]) for key in keys
        }
        try:
            one = revised(given) if given else scenario
        except ScenarioFault as why:
            raise ScenarioFault([data.fault(_said(fault), row) for fault in why.faults]) from None
        case = evaluated(one, given, measures)
        if case.failure is not None or case.outcome.infeasible:
            failed.append(f"line {data.lines[row]}: {case.failure or case.outcome.infeasible[0]}".splitlines()[0])
            continue
        found = {name: case.measures[name] for name in measures if name in case.measures}
        spreads = band.spreads(one, found, keys) if further else {}
        for name, value in found.items():
            predicted[name][row] = value
            half[name][row] = _half(spreads.get(name), scatter_of_measure.get(name))
            if further and name not in spreads:
                bent.add(name)
        if progress is not None:
            progress((row + 1) / data.rows)
    compared = {name: Compared(data.columns[name], predicted[name], half[name]) for name in measures}
    figures = {name: figures_of(one) for name, one in compared.items() if np.isfinite(one.predicted).any()}
    return Validation(
        data, scenario, compared, figures, _by_group(data, compared), tuple(failed),
        tuple(_warnings(data, compared, scatter_of_measure, bent, further)),
    )  # fmt: skip


def _half(spread: Any, noise: float | None) -> float:
    """Half-width of the band of a row, widened by the scatter of the measurement."""
    if spread is None and noise is None:
        return math.nan
    sd, reach = (0.0, quantile(band.LEVEL[1])) if spread is None else (spread.sd, _of(spread))
    return reach * math.hypot(sd, noise or 0.0)


def _of(spread: Any) -> float:
    """Half-width over standard deviation of a band."""
    if spread.sd <= 0.0:
        return quantile(band.LEVEL[1])
    return float(0.5 * (spread.high - spread.low) / spread.sd)


def figures_of(one: Compared, rows: Any = slice(None)) -> Figures:
    """Error, correlation and cover over the rows that have a prediction."""
    measured, predicted, half = (part[rows] for part in one)
    there = np.isfinite(predicted)
    y, p, h = measured[there], predicted[there], half[there]
    error = p - y
    varies = len(y) > 1 and np.ptp(y) > 0.0 and np.ptp(p) > 0.0
    known = np.isfinite(h)
    return Figures(
        float(np.sqrt(np.mean(error**2))), float(np.mean(error)), float(np.corrcoef(p, y)[0, 1]) if varies else None,
        float(np.mean(np.abs(error[known]) <= h[known])) if known.any() else None, len(y),
    )  # fmt: skip


def _by_group(data: Measurement, compared: Mapping[str, Compared]) -> dict[str, dict[str, Figures]]:
    labels = data.labels.get(GROUP)
    if labels is None:
        return {}
    found: dict[str, dict[str, Figures]] = {}
    for label in dict.fromkeys(labels):
        rows = np.array([one == label for one in labels])
        found[label] = {
            name: figures_of(one, rows) for name, one in compared.items() if np.isfinite(one.predicted[rows]).any()
        }
    return found


def _read(scenario: Scenario, file: Path) -> tuple[Measurement, tuple[str, ...], tuple[str, ...]]:
    """The file with its columns of measures and of keys."""
    model, measures, keys, channels = type(scenario), [], [], []
    titles = titles_of(file)
    for name, unit in titles:
        info = fields.field_at(model, split_dotted(name)) if name not in model.measures else None
        if name in model.measures:
            measures.append(name)
            channels.append(Channel(name, model.measures[name].dimension))
        elif info is not None and split_dotted(name)[0] not in ("requirements", "band", "covariances", "measured"):
            dimension = fields.dimension(info)
            numbers = dimension is not None and (unit is not None or dimension == "dimensionless")
            keys.append(name)
            channels.append(Channel(name, dimension or WORDS) if numbers or dimension else Channel(name, WORDS))
        elif name == GROUP:
            channels.append(Channel(GROUP, WORDS))
    data = read_measurement(file, channels, 1)
    faults = []
    if not measures:
        near = [hit for name, _ in titles for hit in get_close_matches(name, model.measures, n=1)]
        hint = f"did you mean {', '.join(dict.fromkeys(near))}?" if near else f"for example {scenario.focus}"
        faults.append(data.fault(
            f"has no column that is named as a measure of a {scenario.process} run; {hint} (or begin with time for a recording)"
        ))  # fmt: skip
    if faults:
        raise ScenarioFault(faults)
    return data, tuple(measures), tuple(keys)


def _noises(
    scenario: Scenario, measures: Sequence[str], noise: str | Mapping[str, str] | None, named: str
) -> dict[str, float]:
    """Scatter of the measurement of each measure [SI], where it is known."""
    known = type(scenario).measures
    place = named.format("validate.noise")
    found: dict[str, float] = {}
    if isinstance(noise, Mapping):
        faults = [
            Fault((), f"{name} is no column of measures of the file", file=place)
            for name in noise
            if name not in measures
        ]
        for name in measures:
            if name in noise:
                try:
                    found[name] = units.parse(noise[name], known[name].dimension)
                except units.UnitFault as fault:
                    faults.append(Fault((), f"{name}: {fault}", file=place))
        if faults:
            raise ScenarioFault(faults)
        return found
    texts = [noise] if noise is not None else [said.residual for said in scenario.measured.values()]
    for text in texts:
        for name in measures:
            try:
                found[name] = units.parse(text, known[name].dimension)
            except units.UnitFault:
                continue
    if noise is not None and not found:
        raise ScenarioFault([Fault((), f'"{noise}" has the unit of none of {", ".join(measures)}', file=place)])
    wrong = [value for value in found.values() if value < 0.0]
    if wrong:
        raise ScenarioFault([Fault((), f"{noise} is below zero; a standard deviation is not", file=place)])
    return found


def _said(fault: Fault) -> str:
    """A fault of a value that a row sets: its key, for the place is the row; others with their own place."""
    return str(fault) if fault.line is not None or not fault.path else f"{dotted(fault.path)}: {fault.message}"


def _warnings(
    data: Measurement, compared: Mapping[str, Compared], noise: Mapping[str, float], bent: set[str], further: int
) -> Any:
    if data.unused:
        yield f"columns that are not used: {', '.join(data.unused)}"
    for name, one in compared.items():
        lacking = int(np.sum(~np.isfinite(one.predicted)))
        if lacking:
            yield f"{name}: {lacking} of {data.rows} rows have no such measure in their runs, and do not count"
    if not further:
        yield "no value of the scenario has a standard error: there is no band, but for the scatter of the measurement"
    without = [name for name in compared if name not in noise]
    if without:
        yield (
            f"the scatter of the measurement is not known for {', '.join(without)} (validate.noise): the band holds what the "
            "inputs leave open, alone, and covers too little"
        )
    if bent:
        yield f"rows without a linear band of {', '.join(sorted(bent))}: they bend (band.method: sampled)"
