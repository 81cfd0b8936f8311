r"""A recording over time laid over a run: columns named as those of the history, axes and delay stated.

A recording that lags the run by d is compared as :math:`y(t)` with :math:`p(t - d)`, over the time that both have.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cutwise import units
from cutwise.io.measurements import Channel, Measurement, read_measurement, titles_of
from cutwise.later import later
from cutwise.process import recipes
from cutwise.results import Result
from cutwise.spec.calibration import MINUS, ForceSettings
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.scenario import Scenario
from cutwise.study.inputs import FloatArray

if TYPE_CHECKING:
    from scipy import optimize
else:
    optimize = later("scipy.optimize")

TIME = "time"
_AXES = "xyz"
_LAGS = 2000  # that are tried, before the best is refined
_OVERLAP = 0.5  # of the shorter of both, which a lag has to leave
_SHORT = 3  # samples

Progress = Callable[[float], None]


class Curve(NamedTuple):
    """A column of the history."""

    time: FloatArray  # [s]
    value: FloatArray  # SI
    dimension: str


class Laid(NamedTuple):
    """A recorded column and the run at the same times."""

    dimension: str
    measured: FloatArray  # SI
    predicted: FloatArray

    def as_json(self) -> dict[str, float]:
        """Mean, peak to peak, rms of the difference, correlation; without what is not known."""
        y, p = self.measured, self.predicted
        found = {
            "mean": float(p.mean()), "measured_mean": float(y.mean()), "peak_to_peak": float(np.ptp(p)),
            "measured_peak_to_peak": float(np.ptp(y)), "rms": float(np.sqrt(np.mean((p - y) ** 2))),
        }  # fmt: skip
        if np.ptp(y) > 0.0 and np.ptp(p) > 0.0:
            found["correlation"] = float(np.corrcoef(p, y)[0, 1])
        return found


class Recording(NamedTuple):
    """What came of laying a recording over a run."""

    data: Measurement
    result: Result
    time: FloatArray  # [s] of the recording, where both are
    laid: Mapping[str, Laid]
    delay: float  # [s] by which the recording lags
    fitted: bool
    axes: str  # measured channels that are +x, +y, +z
    warnings: tuple[str, ...]

    def as_json(self, files: Mapping[str, str]) -> dict[str, Any]:
        """In SI, for other programs."""
        return {
            "recording": {**{name: one.as_json() for name, one in self.laid.items()}, "delay": self.delay},
            "axes": self.axes,
            "warnings": list(self.warnings),
            "files": dict(files),
        }


def is_recording(file: Path) -> bool:
    """Whether the first column of a file is time."""
    titles = titles_of(file)
    return bool(titles) and titles[0][0].casefold() == TIME


def recorded(
    scenario: Scenario, file: Path, delay: float | str = 0.0, force: ForceSettings | None = None,
    progress: Progress | None = None,
) -> Recording:  # fmt: skip
    """Run a scenario and lay a recording over it.

    Parameters
    ----------
    scenario : Scenario
        What was recorded.
    file : Path
        A column ``time``, and columns named as those of the history: ``work_force_x``, ``power``.
    delay : float or "fit"
        By how much the recording lags the run [s]; fit: the lag of the largest correlation.
    force : ForceSettings, optional
        Measured channels that are +x, +y, +z, and what the forces act on.
    progress : callable, optional
        Called with the finished share, 0 to 1, now and then.

    Raises
    ------
    ScenarioFault
        Everything wrong with the file; no time that both have.
    """
    force = force or ForceSettings()
    if force.axes == "auto":
        raise ScenarioFault(
            [Fault(("data", "axes"), "auto finds the channels of mean forces in slots alone; name them")]
        )
    result = recipes.simulate(scenario, progress)
    if result.infeasible:
        raise ScenarioFault([Fault((), f"the run cannot be done: {result.infeasible[0]}")])
    curves = curves_of(result)
    data = _read(file, curves)
    time = data.columns[TIME]
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(back):
        raise ScenarioFault([data.fault("time does not rise", int(back[0]) + 1)])
    names = [name for name in data.columns if name != TIME]
    measured = _on_axes({name: data.columns[name] for name in names}, curves, force, data)
    lag = _best_lag(time, measured, curves, data) if delay == "fit" else float(delay)
    shared = _shared(time - lag, curves, names)
    if shared.sum() < _SHORT:
        first, last = (units.show(float(t), "time", 4) for t in (time[0] - lag, time[-1] - lag))
        ends = [units.show(float(t), "time", 4) for t in _span(curves, names)]
        raise ScenarioFault([data.fault(
            f"recording ({first} to {last} of the run) and run ({ends[0]} to {ends[1]}) have no time together; "
            "state validate.delay, or fit it"
        )])  # fmt: skip
    laid = {
        name: Laid(
            curves[name].dimension, measured[name][shared],
            np.interp(time[shared] - lag, curves[name].time, curves[name].value),
        )
        for name in names
    }  # fmt: skip
    axes = f"[{', '.join(force.axes)}]" + (", forces on the work turned" if force.forces_on == "work" else "")
    warnings = tuple(_warnings(data, int(shared.sum()), laid))
    return Recording(data, result, time[shared], laid, lag, delay == "fit", axes, warnings)


def curves_of(result: Result) -> dict[str, Curve]:
    """Every column of the history over time: those with axes as NAME_x ..., with several holes that of the first."""
    found: dict[str, Curve] = {}
    for group in result.stages.children:
        data = result.stages[group].dataset
        if TIME not in data.coords:
            continue
        time = np.asarray(data[TIME].values, dtype=float)
        for name, array in data.data_vars.items():
            if TIME not in array.dims:
                continue
            if "hole" in array.dims:
                array = array.isel(hole=0)
            rest = [dim for dim in array.dims if dim != TIME]
            dimension = _dimension(str(array.attrs.get("units", "")))
            values = np.asarray(array.transpose(TIME, *rest).values, dtype=float)
            kept = np.isfinite(time)
            if not rest:
                found.setdefault(str(name), Curve(time[kept], values[kept], dimension))
            elif len(rest) == 1:
                for k in range(values.shape[1]):
                    end = _AXES[k] if values.shape[1] <= 3 else str(k + 1)
                    found.setdefault(f"{name}_{end}", Curve(time[kept], values[kept, k], dimension))
    return found


def _dimension(unit: str) -> str:
    """A dimension of an SI unit as histories have it."""
    if unit in ("1", ""):
        return "dimensionless"
    return next((name for name, one in units.DIMENSIONS.items() if one.si == unit), "dimensionless")


def _read(file: Path, curves: Mapping[str, Curve]) -> Measurement:
    channels = [Channel(TIME, "time"), *(Channel(name, one.dimension, False) for name, one in curves.items())]
    data = read_measurement(file, channels, _SHORT)
    if len(data.columns) < 2:
        near = [hit for title in data.unused for hit in get_close_matches(title.split("[")[0].strip(), curves, n=1)]
        hint = (
            f"did you mean {', '.join(dict.fromkeys(near))}?" if near else f"there are {', '.join(sorted(curves)[:20])}"
        )
        message = (
            "has no column that is named as one of the history of this run"
            if curves
            else "the run has no history over time"
        )
        raise ScenarioFault([data.fault(f"{message}; {hint}" if curves else message)])
    return data


def _on_axes(
    columns: dict[str, FloatArray], curves: Mapping[str, Curve], force: ForceSettings, data: Measurement
) -> dict[str, FloatArray]:
    """Columns NAME_x, _y, _z in the axes of the run, forces as those on the tool."""
    found = dict(columns)
    stems = dict.fromkeys(name[:-2] for name in columns if name[-2:] in ("_x", "_y", "_z"))
    for stem in stems:
        for k, written in enumerate(force.axes):
            place, sign = MINUS[written]
            target, source = f"{stem}_{_AXES[k]}", f"{stem}_{_AXES[place]}"
            if target not in columns:
                continue
            if source not in columns:
                raise ScenarioFault([data.fault(f"data.axes needs {source} for {target}; it is not among the columns")])
            turn = -1.0 if force.forces_on == "work" and curves[target].dimension == "force" else 1.0
            found[target] = turn * sign * columns[source]
    return found


def _span(curves: Mapping[str, Curve], names: list[str]) -> tuple[float, float]:
    return max(curves[name].time[0] for name in names), min(curves[name].time[-1] for name in names)


def _shared(time: FloatArray, curves: Mapping[str, Curve], names: list[str]) -> Any:
    low, high = _span(curves, names)
    return (time >= low - 1e-12) & (time <= high + 1e-12)


def _best_lag(
    time: FloatArray, measured: Mapping[str, FloatArray], curves: Mapping[str, Curve], data: Measurement
) -> float:
    """The lag at which measured columns and run correlate best, on the average of the columns that vary."""
    names = [name for name in measured if np.ptp(measured[name]) > 0.0 and np.ptp(curves[name].value) > 0.0]
    if not names:
        raise ScenarioFault(
            [data.fault("no column varies in recording and run: validate.delay cannot be fitted; state it")]
        )
    low, high = _span(curves, names)
    least = _OVERLAP * min(high - low, time[-1] - time[0])

    def match(lag: float) -> float:
        at = time - lag
        there = _shared(at, curves, names)
        if there.sum() < _SHORT or np.ptp(at[there]) < least:
            return -math.inf
        total = 0.0
        for name in names:
            y, p = measured[name][there], np.interp(at[there], curves[name].time, curves[name].value)
            total += float(np.corrcoef(y, p)[0, 1]) if np.ptp(y) > 0.0 and np.ptp(p) > 0.0 else 0.0
        return total

    start, end = time[0] - high + least, time[-1] - low - least
    lags = np.linspace(start, end, _LAGS)
    best = float(lags[int(np.argmax([match(lag) for lag in lags]))])
    step = float(lags[1] - lags[0])
    # a curve may swing within one step: look again, ten times finer, before the last digits
    near = best + np.linspace(-step, step, 41)
    best = float(near[int(np.argmax([match(lag) for lag in near]))])
    found = optimize.minimize_scalar(
        lambda lag: -match(float(lag)), bounds=(best - 0.05 * step, best + 0.05 * step), method="bounded",
        options={"xatol": 1e-9 * max(1.0, abs(best))},
    )  # fmt: skip
    return float(found.x) if match(float(found.x)) >= match(best) else best


def _warnings(data: Measurement, shared: int, laid: Mapping[str, Laid]) -> Iterator[str]:
    if data.unused:
        yield f"columns that are not used: {', '.join(data.unused)}"
    if shared < data.rows:
        yield f"{data.rows - shared} of {data.rows} samples lie outside of the time of the run, and do not count"
    for name, one in laid.items():
        if np.ptp(one.measured) == 0.0 or np.ptp(one.predicted) == 0.0:
            yield f"{name} does not vary: no correlation"
