r"""Bands of a result: what the scatter of its inputs makes of every measure, and with which probability limits are kept.

With inputs x in the quantity in which their errors are normal (a stiffness: its compliance), their covariance C, and
the gradient g of a measure by central differences of :math:`\pm` half a standard error (:func:`directions`):

.. math:: s^2 = \sum_b g_b^T C_b\, g_b, \qquad \nu = \frac{(\sum_b v_b)^2}{\sum_b v_b^2/\nu_b}, \quad v_b = g_b^T C_b\, g_b

Ends of the band and probabilities are Student's with :math:`\nu` (Welch and Satterthwaite). Where
:math:`|f_+ - 2 f_0 + f_-|` exceeds :math:`s/2` the measure bends, and has no linear band. Sampled: draws of x, those of
each covariance over :math:`\sqrt{\chi^2_\nu/\nu}`, a run each.
"""

import logging
import math
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cutwise.bands import BandNote, Spread
from cutwise.io.revision import Value
from cutwise.io.scenario import load
from cutwise.process import recipes
from cutwise.results import Check, Measure, Result, SolverFailure, in_words, judge, unreached
from cutwise.spec.scenario import PROBABILITY_ALL, Scenario
from cutwise.spec.uncertain import stem
from cutwise.study.batch import batch
from cutwise.study.inputs import FloatArray, Scatter, overrides, scatter_of, without_scatter
from cutwise.study.spread import carried, directions, draws, probability, quantile, satterthwaite, variances

LEVEL = (0.05, 0.95)
_STEP = 0.5  # standard errors
_BENDS = 0.5  # of the standard deviation
_ROUNDING = 1e-6  # of the measure: what bends by less is noise of the computation
_LEAST = 0.05  # of a positive value, below which a draw is no such thing
_TOGETHER = 100_000  # draws of the linearised measures

Progress = Callable[[float], None]
Measures = Mapping[str, float]
_told = logging.getLogger("cutwise.band")


class Moved(NamedTuple):
    """What came of moving the inputs: a band for each measure, and how probable it is that limits are kept."""

    spreads: Mapping[str, Spread]
    kept: Callable[[Check], float | None]  # probability of a requirement; None if it is not known
    together: float | None
    note: BandNote
    warnings: tuple[str, ...]


def simulate(
    scenario: Scenario | str | Path | Mapping[str, Any], progress: Progress | None = None, *, jobs: int = 1
) -> Result:  # fmt: skip
    """Run a scenario, with the bands of its measures where its values have a covariance.

    Parameters
    ----------
    scenario : Scenario, str, Path or mapping
        What to simulate: what :func:`cutwise.load` gives, or what it takes.
    progress : callable, optional
        Called with the finished share, 0 to 1, now and then.
    jobs : int
        Processes for the runs of the bands; no number depends on it.

    Returns
    -------
    Result
        Histories of all stages, measures with their bands, verdict and warnings.
    """
    one = scenario if isinstance(scenario, Scenario) else load(scenario)
    return banded(recipes.simulate(one, progress), progress, jobs)


def banded(result: Result, progress: Progress | None = None, jobs: int = 1) -> Result:
    """The result with a band for each measure, by running again with its uncertain inputs moved."""
    scenario = result.scenario
    if scenario.band.method == "none" or not result.measures:
        return result
    scatter = scatter_of(scenario)
    asked = [name for name, limit in scenario.requirements.items() if limit.probability is not None]
    if not scatter.inputs and any(name in scenario.own_scatter() for name in asked):
        f0 = {name: measure.value for name, measure in result.measures.items()}
        return _judged(result, _of_process(scenario, f0), _unknown(scatter))
    if not scatter.inputs:
        return _judged(result, None, _unknown(scatter)) if scatter.undetermined else result
    f0 = {name: measure.value for name, measure in result.measures.items()}
    sampled = scenario.band.method == "sampled"
    count = scenario.band.samples if sampled else 2 * directions(scatter).shape[1]
    way = "sampled" if sampled else "linear"
    _told.info("band: %d further runs (%s, %d values with a standard error)", count, way, len(scatter.inputs))
    moved = (_sampled if sampled else _linear)(scenario, scatter, f0, progress, jobs)
    return _judged(result, moved, (*moved.warnings, *_unknown(scatter), *_alone(scatter)))


def spreads(scenario: Scenario, f0: Measures, without: Collection[str] = ()) -> Mapping[str, Spread]:
    """Bands of some measures of a case, but for what is not said to be uncertain.

    Parameters
    ----------
    f0 : mapping
        The measures of the case, SI.
    without : collection of str
        Keys that stand fast.
    """
    scatter = scatter_of(scenario, without)
    if not scatter.inputs or not f0:
        return {}
    return (_sampled if scenario.band.method == "sampled" else _linear)(scenario, scatter, f0, None).spreads


def _unknown(scatter: Scatter) -> tuple[str, ...]:
    if not scatter.undetermined:
        return ()
    keys = ", ".join(scatter.undetermined)
    return (f"the band is too narrow: the data of their calibration do not tell {keys}",)


def _alone(scatter: Scatter) -> tuple[str, ...]:
    """Values of one fit whose covariance is not there count as independent, which can be several times too wide."""
    keys = [scatter.inputs[block.places[0]].key for block in scatter.blocks if block.alone]
    if len(keys) < 2:
        return ()
    return (
        f"{', '.join(keys)} have standard errors but no covariance: they count as independent; if one fit gave them, the "
        "band may be several times too wide or too narrow",
    )


def _own_variances(scenario: Scenario, f0: Measures) -> dict[str, float]:
    """Variance of measures by a scatter that the process itself knows: that of the bodies of a machine."""
    return {name: f0[sd] ** 2 for name, sd in scenario.own_scatter().items() if name in f0 and sd in f0}


def _of_process(scenario: Scenario, f0: Measures) -> Moved:
    """Probabilities by the scatter of the process alone."""
    own = _own_variances(scenario, f0)

    def kept(check: Check) -> float | None:
        variance = own.get(check.measure)
        return None if variance is None else probability(check, f0[check.measure], math.sqrt(variance), math.inf)

    note = BandNote("linear", 0, (), residuals=_residuals(scenario))
    return Moved({}, kept, None, note, ())


def _judged(result: Result, moved: Moved | None, warnings: tuple[str, ...]) -> Result:
    """Measures with bands, requirements held against them."""
    measures: dict[str, Measure] = dict(result.measures)
    if moved is not None:
        measures = {name: replace(one, band=moved.spreads.get(name)) for name, one in measures.items()}
        if moved.together is not None:
            known = result.scenario.measures[PROBABILITY_ALL]
            measures[PROBABILITY_ALL] = Measure(moved.together, known.dimension, known.description)
    told = {check.measure: check for check in result.checks}
    checks = []
    for check in judge(result.scenario, measures):
        before = told.get(check.measure)
        if before is not None and (before.value is not None or check.implied):
            band = measures[check.measure].band if check.measure in measures else None
            check = replace(before, band=band)
        checks.append(_probable(check, moved))
    findings = tuple(finding for finding in result.findings if finding.code != "unreached")
    findings = tuple(sorted((*unreached(checks), *findings), key=lambda finding: finding.rank))
    return replace(
        result, measures=measures, checks=tuple(checks), findings=findings,
        warnings=(*result.warnings, *warnings), band=moved.note if moved is not None else None,
    )  # fmt: skip


def _probable(check: Check, moved: Moved | None) -> Check:
    """The check with the probability of its limits; it fails where less is reached than demanded."""
    reached = moved.kept(check) if moved is not None else None
    if check.probability is None:
        return replace(check, probability_reached=reached)
    kept = check.passed if check.whole_band else check.keeps(check.value)
    return replace(
        check, probability_reached=reached, passed=kept and reached is not None and reached >= check.probability
    )


def _linear(
    scenario: Scenario, scatter: Scatter, f0: Measures, progress: Progress | None, jobs: int = 1
) -> Moved:  # fmt: skip
    given, ways = overrides(scenario, scatter.inputs), directions(scatter)
    count, names = ways.shape[1], list(f0)
    both = [(k, sign) for k in range(count) for sign in (1.0, -1.0)]

    def moved(k: int, sign: float) -> Mapping[str, Value]:
        places = np.flatnonzero(ways[:, k]).tolist()
        off = {n: scatter.inputs[n].normal + sign * _STEP * float(ways[n, k]) for n in places}
        return given({n: scatter.inputs[n].turned(value) for n, value in off.items()})

    runs = batch(scenario, [moved(*one) for one in both], tuple(f0), jobs=jobs, progress=progress)
    up, down = (np.full((len(names), count), np.nan) for _ in range(2))
    why: dict[str, str] = {}
    for (k, sign), case in zip(both, runs, strict=True):
        if case.failure is not None or case.outcome.infeasible:
            one = scatter.inputs[int(np.argmax(np.abs(ways[:, k]) / scatter.standard_errors))]
            said = str(case.failure or in_words(case.outcome.infeasible)[0]).splitlines()[0]
            why.setdefault(one.key, f"with {one.key} half a standard error off: {said}")
        (up if sign > 0.0 else down)[:, k] = [case.measures.get(name, math.nan) for name in names]
    start = np.array([f0[name] for name in names])
    gradient = ((up - down) / (2.0 * _STEP)) @ np.linalg.pinv(ways)
    bend = np.abs(up - 2.0 * start[:, None] + down)
    spreads: dict[str, Spread] = {}
    slopes: dict[str, FloatArray] = {}
    own = _own_variances(scenario, f0)
    for n, name in enumerate(names):
        parts = variances(scatter, gradient[n])
        sd = math.sqrt(max(sum(parts), 0.0)) if np.all(np.isfinite(gradient[n])) else math.nan
        rounding = _ROUNDING * max(abs(start[n]), float(np.max(np.abs(up[n]))))
        if not math.isfinite(sd) or np.any(bend[n] > max(_BENDS * sd, 0.0) + rounding):
            continue
        slopes[name], freedom = gradient[n], satterthwaite(scatter, parts)
        low, high = (float(start[n] + sd * quantile(p, freedom)) for p in LEVEL)
        spreads[name] = Spread(sd, low, high, carried(scatter, gradient[n], sum(parts)))

    def kept(check: Check) -> float | None:
        spread, more = spreads.get(check.measure), own.get(check.measure, 0.0)
        if spread is None:
            return None
        parts = [*variances(scatter, slopes[check.measure]), more]
        return probability(check, f0[check.measure], math.sqrt(spread.sd**2 + more), satterthwaite(scatter, parts))

    left_out = tuple(name for name in names if name not in spreads)
    note = BandNote(
        "linear", 2 * count, tuple(one.key for one in scatter.inputs), _together(scenario, scatter, f0, slopes), left_out,
        tuple(without_scatter(scenario, scatter)), _residuals(scenario), seed=scenario.band.seed,
    )  # fmt: skip
    return Moved(spreads, kept, note.probability_all, note, (*_bent(scenario, left_out), *why.values()))


def _bent(scenario: Scenario, left_out: tuple[str, ...]) -> tuple[str, ...]:
    if not left_out:
        return ()
    first = [name for name in left_out if name in (scenario.focus, *scenario.requirements)]
    shown = [*first, *(name for name in left_out if name not in first)]
    more = f" and {len(shown) - 6} more" if len(shown) > 6 else ""
    return (
        f"no linear band for {', '.join(shown[:6])}{more}: within half a standard error they bend or jump by more than half "
        "of the standard deviation; --set band.method=sampled makes one by draws",
    )


def _limits(scenario: Scenario) -> dict[str, tuple[float, float]]:
    """Limits of the requirements on measures."""
    return {
        name: (-math.inf if limit.min is None else limit.min, math.inf if limit.max is None else limit.max)
        for name, limit in scenario.requirements.items() if stem(name) is None and name != PROBABILITY_ALL
    }  # fmt: skip


def _together(scenario: Scenario, scatter: Scatter, f0: Measures, slopes: Mapping[str, FloatArray]) -> float | None:
    """Probability that all requirements are kept, of the linearised measures; None where one has no linear band."""
    limits = _limits(scenario)
    if not limits or any(name not in slopes for name in limits):
        return None
    errors = draws(scatter, _TOGETHER, scenario.band.seed)
    kept = np.ones(_TOGETHER, dtype=bool)
    for name, (low, high) in limits.items():
        values = f0[name] + errors @ slopes[name]
        kept &= (values >= low) & (values <= high)
    return float(kept.mean())


def _residuals(scenario: Scenario) -> dict[str, str]:
    """What the fits of the inputs left, which no band holds."""
    return {name: str(said.residual) for name, said in scenario.measured.items() if said.residual is not None}


def _sampled(
    scenario: Scenario, scatter: Scatter, f0: Measures, progress: Progress | None, jobs: int = 1
) -> Moved:  # fmt: skip
    given = overrides(scenario, scatter.inputs)
    start = np.array([one.normal for one in scatter.inputs])
    count = scenario.band.samples
    normal = start + draws(scatter, count, scenario.band.seed)
    counts = np.array([one.kind != "log" and one.normal > 0.0 for one in scatter.inputs])
    thrown = np.any(normal[:, counts] < _LEAST * start[counts], axis=1)
    used = np.flatnonzero(~thrown)
    names, failed = list(f0), 0
    found = np.full((len(used), len(names)), np.nan)
    values = [given({k: one.turned(float(normal[n, k])) for k, one in enumerate(scatter.inputs)}) for n in used]
    for place, case in enumerate(batch(scenario, values, tuple(f0), jobs=jobs, progress=progress)):
        failed += case.failure is not None or bool(case.outcome.infeasible)
        found[place] = [case.measures.get(name, math.nan) for name in names]
    if len(used) < 2 or failed == len(used):
        raise SolverFailure(
            f"no band: of {count} draws {int(thrown.sum())} were thrown away and {failed} could not be run"
        )
    errors, own = normal[used] - start, _own_variances(scenario, f0)
    spreads = {}
    for k, name in enumerate(names):
        column = found[:, k]
        there = np.isfinite(column)
        if there.sum() >= max(2.0, 0.5 * len(used)):
            low, high = np.quantile(column[there], LEVEL)
            slope = np.linalg.lstsq(np.column_stack([errors[there], np.ones(there.sum())]), column[there], rcond=None)[
                0
            ][:-1]
            variance = float(sum(variances(scatter, slope)))
            spreads[name] = Spread(
                float(column[there].std(ddof=1)), float(low), float(high), carried(scatter, slope, variance)
            )
    left_out = tuple(name for name in names if name not in spreads)

    def inside(name: str, low: float, high: float, extra: FloatArray | float = 0.0) -> FloatArray:
        values = found[:, names.index(name)] + extra
        return np.asarray((values >= low) & (values <= high))  # a measure that is not there keeps nothing

    def kept(check: Check) -> float | None:
        if check.measure not in names:
            return None
        low, high = check.minimum, check.maximum
        more = math.sqrt(own.get(check.measure, 0.0))
        extra = more * np.random.default_rng(scenario.band.seed).normal(size=len(used)) if more > 0.0 else 0.0
        ends = (-math.inf if low is None else low, math.inf if high is None else high)
        return float(inside(check.measure, *ends, extra).mean())

    limits = _limits(scenario)
    together = None
    if limits and all(name in names for name in limits):
        together = float(np.all([inside(name, *ends) for name, ends in limits.items()], axis=0).mean())
    note = BandNote(
        "sampled", len(used), tuple(one.key for one in scatter.inputs), together, left_out,
        tuple(without_scatter(scenario, scatter)), _residuals(scenario), int(thrown.sum()), failed, scenario.band.seed,
    )  # fmt: skip
    return Moved(spreads, kept, together, note, tuple(_of_draws(note, count)))


def _of_draws(note: BandNote, count: int) -> Iterable[str]:
    if note.thrown_away:
        yield (
            f"{note.thrown_away} of {count} draws of the band were thrown away: a value that is above zero came out below 5 % "
            "of itself"
        )
    if note.failed:
        yield f"{note.failed} of {note.runs} draws of the band could not be run; they count as keeping no limit"
    if note.left_out:
        yield f"no band for {', '.join(note.left_out)}: fewer than half of the draws have it"
