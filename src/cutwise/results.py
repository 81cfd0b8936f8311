"""What a run gives back: labelled histories per stage, measures, verdict, and where every input came from."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from cutwise import units
from cutwise.later import later
from cutwise.spec.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr
else:
    xr = later("xarray")


class SolverFailure(Exception):
    """The computation did not come to an end: which solver, where it stopped, and what to change."""


class Infeasible(SolverFailure):
    """The operation cannot be done: what gives way, where, and what helps."""


class NoSuchName(KeyError):
    """A name that is not there, with the one that was probably meant."""

    def __init__(self, kind: str, name: object, known: Iterable[str], where: str) -> None:
        names = [str(one) for one in known]
        near = get_close_matches(str(name), names, n=1)
        hint = (
            f"did you mean {near[0]}?"
            if near
            else f"there are {', '.join(names[:12])}{', ...' if len(names) > 12 else ''}"
        )
        super().__init__(f'no {kind} "{name}"; {hint} ({len(names)}: {where})')

    def __str__(self) -> str:
        return str(self.args[0])


class Measures(dict[str, "Measure"]):
    """The measures of a run by name; a name that is not there is answered with the nearest one."""

    def __missing__(self, name: str) -> Measure:
        raise NoSuchName("measure", name, self, "result.measures")


@dataclass(frozen=True, slots=True)
class Measure:
    """A named number of the run, in SI."""

    value: float
    dimension: str
    description: str = ""

    @property
    def unit(self) -> str:
        """SI unit as text."""
        return units.DIMENSIONS[self.dimension].si

    def __str__(self) -> str:
        return units.show(self.value, self.dimension)


@dataclass(frozen=True, slots=True)
class Check:
    """A requirement of the scenario and how the run did against it."""

    measure: str
    value: float
    dimension: str
    minimum: float | None
    maximum: float | None
    passed: bool

    def as_json(self) -> dict[str, Any]:
        """``{measure, value, min, max, pass}`` in SI."""
        return {
            "measure": self.measure,
            "value": self.value,
            "unit": units.DIMENSIONS[self.dimension].si,
            "min": self.minimum,
            "max": self.maximum,
            "pass": self.passed,
        }


@dataclass(frozen=True)
class Result:
    """A finished run.

    ``stages`` holds one group per stage of the loop (motion, engagement, cutting, structure, surface) as labelled
    arrays in SI with a ``units`` attribute each; ``result["surface"]`` is one of them.
    """

    scenario: Scenario
    stages: xr.DataTree
    measures: Mapping[str, Measure]
    checks: tuple[Check, ...] = ()
    warnings: tuple[str, ...] = ()
    infeasible: tuple[str, ...] = ()  # violated inequalities of an operation that cannot be done, with margins
    limits: tuple[str, ...] = ()  # what the model leaves out
    convergence: Mapping[str, float] = field(default_factory=dict)  # measure: change when the step is halved, SI
    references: tuple[str, ...] = ()  # keys of cutwise.references that this run used
    notes: Mapping[str, str] = field(default_factory=dict)  # named remarks for the report
    advice: tuple[str, ...] = ()  # what to change, or how much room is left, found by running again
    sensitivity: Mapping[str, float] = field(default_factory=dict)  # assumed input: change of the focus measure, SI

    def __post_init__(self) -> None:
        object.__setattr__(self, "measures", Measures(self.measures))

    def __getitem__(self, stage: str) -> xr.DataTree:
        try:
            return self.stages[stage]  # type: ignore[return-value]
        except KeyError:
            raise NoSuchName("stage", stage, map(str, self.stages.children), "result.stages") from None

    @property
    def verdict(self) -> Literal["pass", "fail", "none"]:
        """``fail`` if a requirement is missed or the operation cannot be done; ``none`` without requirements."""
        if self.infeasible or any(not check.passed for check in self.checks):
            return "fail"
        return "pass" if self.checks else "none"

    @property
    def assumed(self) -> tuple[str, ...]:
        """Dotted keys of the input values that nobody has measured or published."""
        return tuple(key for key, origin in self.scenario.origins.items() if origin.status == "assumed")

    @property
    def _focus_unit(self) -> str:
        focus = self.measures.get(self.scenario.focus)
        return focus.unit if focus is not None else ""

    def summary(self, files: Mapping[str, str] | None = None) -> dict[str, Any]:
        """The object that ``run --json`` prints: SI values, no NaN."""
        return {
            "scenario": self.scenario.name,
            "process": self.scenario.process,
            "verdict": self.verdict,
            "measures": {name: {"value": m.value, "unit": m.unit} for name, m in self.measures.items()},
            "requirements": [check.as_json() for check in self.checks],
            "assumed": list(self.assumed),
            "warnings": list(self.warnings),
            "infeasible": list(self.infeasible),
            "notes": dict(self.notes),
            "convergence": dict(self.convergence),
            "advice": list(self.advice),
            "sensitivity": {"measure": self.scenario.focus, "unit": self._focus_unit, "change": dict(self.sensitivity)},
            "files": dict(files or {}),
        }

    def save(self, path: str | Path) -> Path:
        """Write one netCDF-4 file with the whole result and the scenario; nothing is left behind if that fails."""
        path = Path(path)
        partial = path.with_name(path.name + ".part")
        tree = self.stages.copy()
        tree.attrs = {
            "title": self.scenario.name,
            "source": "cutwise",
            "scenario": json.dumps(self.scenario.document()),
            "summary": json.dumps(self.summary()),
            "measures": json.dumps({n: [m.value, m.dimension, m.description] for n, m in self.measures.items()}),
            "limits": json.dumps(list(self.limits)),
            "references": json.dumps(list(self.references)),
            "notes": json.dumps(dict(self.notes)),
        }
        try:
            tree.to_netcdf(partial, engine="h5netcdf")
            partial.replace(path)
        finally:
            partial.unlink(missing_ok=True)
        return path

    @classmethod
    def from_file(cls, path: str | Path, scenario: Scenario) -> Result:
        """Read back a file written by :meth:`save`; the scenario comes from ``cutwise.io.scenario``."""
        tree = xr.open_datatree(Path(path), engine="h5netcdf").load()
        tree.close()
        summary = json.loads(tree.attrs["summary"])
        measures = {n: Measure(v, d, t) for n, (v, d, t) in json.loads(tree.attrs["measures"]).items()}
        return cls(
            scenario=scenario,
            stages=tree,
            measures=measures,
            checks=tuple(_check_from_json(c, measures) for c in summary["requirements"]),
            warnings=tuple(summary["warnings"]),
            infeasible=tuple(summary["infeasible"]),
            limits=tuple(json.loads(tree.attrs["limits"])),
            convergence=summary["convergence"],
            advice=tuple(summary["advice"]),
            sensitivity=summary["sensitivity"]["change"],
            references=tuple(json.loads(tree.attrs["references"])),
            notes=json.loads(tree.attrs["notes"]),
        )


def _check_from_json(entry: Mapping[str, Any], measures: Mapping[str, Measure]) -> Check:
    name = entry["measure"]
    dimension = measures[name].dimension if name in measures else "dimensionless"
    return Check(name, entry["value"], dimension, entry["min"], entry["max"], entry["pass"])


def judge(scenario: Scenario, measures: Mapping[str, Measure]) -> Iterable[Check]:
    """Hold the measures against the requirements of the scenario; a measure that the run lacks fails its limit."""
    for name, limit in scenario.requirements.items():
        measure = measures.get(name)
        dimension = scenario.measures[name].dimension
        if measure is None:
            yield Check(name, None, dimension, limit.min, limit.max, False)  # type: ignore[arg-type]
            continue
        above = limit.min is None or measure.value >= limit.min
        below = limit.max is None or measure.value <= limit.max
        yield Check(name, measure.value, dimension, limit.min, limit.max, above and below)


def judge_values(scenario: Scenario, values: Mapping[str, float]) -> bool:
    """Whether bare values in SI meet every requirement on them; requirements on other measures do not count."""
    return all(
        (limit.min is None or values[name] >= limit.min) and (limit.max is None or values[name] <= limit.max)
        for name, limit in scenario.requirements.items()
        if name in values
    )
