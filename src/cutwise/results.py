"""What a run gives back: labelled histories per stage, measures, verdict, and where every input came from."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from cutwise import units
from cutwise.above import above
from cutwise.bands import BandNote, Spread, note_from_json, number, numbers, spread_from_json, texts
from cutwise.disk import write_bytes
from cutwise.later import later
from cutwise.run_file import DamagedRun, sealed, tree_of, written
from cutwise.spec.faults import NoSuchName
from cutwise.spec.scenario import PROBABILITY_ALL, Scenario
from cutwise.spec.uncertain import stem

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from cutwise import tabular
else:
    xr = later("xarray")
    tabular = later("cutwise.tabular")

Certainty = Literal["sure", "not_every_history", "unknown"]

SOUNDNESS: Mapping[str, str] = {
    "unstable": "vibration grows from tooth to tooth",
    "untouched": "the tool meets no material where it should",
    "contact_lost": "the tool leaves the work in the middle of the cut",
    "tip_lost": "the tool is no longer where its contact is taken",
    "at_stop": "the spindle has used its whole stroke",
    "unsettled": "the state that is judged is not reached",
    "unconverged": "the verdict depends on the step of the computation",
    "unsolved": "the step of the computation is too long in places",
    "edge_stands": "the chamfer is not complete",
    "collides": "a rapid move runs through the stock",
    "at_rest": "the spindle does not turn in a move that would cut",
    "rubs": "the rod runs into the part",
    "unreached": "a measure that is required does not exist in this run",
}
"""Codes of findings that leave nothing to be judged: a run with one of them is never a pass."""


class Place(NamedTuple):
    """Where something was found; what is not known is left out."""

    name: str = ""  # a contact, a path, a hole
    time: float | None = None  # [s]
    position: float | None = None  # [m] along the edge or path
    line: int = 0  # of the program, from 1


NOWHERE = Place()


class Remedy(NamedTuple):
    """What to change; ``tried`` when a computation with it is sound."""

    key: str
    value: str
    tried: bool = False


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that a run found out about itself, or why it cannot be; never read back from a text.

    It decides the verdict if its code stands in :data:`SOUNDNESS`, or if the operation cannot be done. A row that says
    something of its own has the words for it; words of what several processes find are made in the app layer.
    """

    code: str
    where: Place = NOWHERE
    value: float | None = None  # SI
    limit: float | None = None
    dimension: str = "dimensionless"
    measure: str = ""  # the measure that it is about
    remedy: Remedy | None = None
    words: str = ""
    cannot: bool = False  # the operation cannot be done

    @property
    def rank(self) -> int:
        """Place in the one order of all reports: what cannot be done, what is not sound, what one should know."""
        return 0 if self.cannot else 1 if self.code in SOUNDNESS else 2

    def as_json(self) -> dict[str, Any]:
        """The record in SI, without what it does not say."""
        told: dict[str, Any] = {"code": self.code, "decides": self.rank < 2}
        where = {name: value for name, value in self.where._asdict().items() if value not in (None, "", 0)}
        told |= {"measure": self.measure} if self.measure else {}
        told |= {"where": where} if where else {}
        told |= {name: value for name in ("value", "limit") if (value := getattr(self, name)) is not None}
        told |= {"unit": units.DIMENSIONS[self.dimension].si, "dimension": self.dimension}
        told |= {"remedy": self.remedy._asdict()} if self.remedy else {}
        told |= {"infeasible": True} if self.cannot else {}
        return told | ({"text": self.words} if self.words else {})

    @classmethod
    def from_json(cls, told: Mapping[str, Any]) -> Finding:
        """A finding as :meth:`as_json` wrote it."""
        remedy = told.get("remedy")
        return cls(
            told["code"], Place(**told.get("where", {})), told.get("value"), told.get("limit"), told["dimension"],
            told.get("measure", ""), Remedy(**remedy) if remedy else None, str(told.get("text", "")),
            bool(told.get("infeasible", False)),
        )  # fmt: skip


def warned(
    code: str, words: str, value: float | None = None, limit: float | None = None, dimension: str = "dimensionless", *,
    where: Place = NOWHERE, remedy: Remedy | None = None,
) -> Finding:  # fmt: skip
    """What a row warns of, in its own words."""
    return Finding(code, where, value, limit, dimension, remedy=remedy, words=words)


def named(found: Finding, which: str, where: Place | None = None) -> Finding:
    """What is said of one of several (a set-up, a hole, an edge): its words begin with which one it is."""
    return replace(found, where=where or found.where, words=f"{which}: {found.words}")


Said = Finding | str
"""What a row says: a record; or, of the values of the scenario, a sentence."""


def in_words(found: Iterable[Said]) -> tuple[str, ...]:
    """The sentences of what rows say."""
    return tuple(one if isinstance(one, str) else one.words for one in found)


class Histories(NamedTuple):
    """Between which values a measure may come out, because of what the run cannot know."""

    low: float | None  # SI; None: no bound is known
    high: float | None
    cause: str  # friction, set-up


PARAMETERS = "parameters"
"""Cause of a band that the scatter of the inputs makes; its ends stand in :class:`Spread`."""


class SolverFailure(Exception):
    """The computation did not come to an end: which solver, where it stopped, and what to change."""


class Infeasible(SolverFailure):
    """The operation cannot be done: what gives way, where, and what helps."""

    def __init__(self, words: str, code: str = "infeasible", where: Place = NOWHERE) -> None:
        super().__init__(words)
        self.finding = Finding(code, where, words=words, cannot=True)


class Measures(dict[str, "Measure"]):
    """The measures of a run by name; a name that is not there is answered with the nearest one."""

    def __missing__(self, name: str) -> Measure:
        found = of_band(self, name) if isinstance(name, str) else None
        if found is not None:
            return found
        raise NoSuchName("measure", name, self, "result.measures")

    def __repr__(self) -> str:
        return f"<Measures: {len(self)}, {', '.join(list(self)[:3])}{', ...' if len(self) > 3 else ''}>"

    def to_dataframe(self) -> pd.DataFrame:
        """A row a measure: value in SI, unit, description; and the ends of its band where there is one."""
        return tabular.measures(self)


@dataclass(frozen=True, slots=True)
class Measure:
    """A named number of the run, in SI."""

    value: float
    dimension: str
    description: str = ""
    band: Spread | None = None

    @property
    def unit(self) -> str:
        """SI unit as text."""
        return units.DIMENSIONS[self.dimension].si

    def __str__(self) -> str:
        return units.show(self.value, self.dimension)


def of_band(measures: Mapping[str, Measure], name: str) -> Measure | None:
    """An end of the band of a measure by its own name, ``NAME_band_high``; None if there is no such band."""
    found = stem(name)
    if found is None or found[0] not in measures:
        return None
    of = measures[found[0]]
    return None if of.band is None else Measure(getattr(of.band, found[1]), of.dimension)


@dataclass(frozen=True, slots=True)
class Check:
    """A requirement of the scenario, or one that every run has, and how the run did against it."""

    measure: str
    value: float
    dimension: str
    minimum: float | None
    maximum: float | None
    passed: bool
    implied: bool = False  # nobody wrote it: it comes with the process
    whole_band: bool = False  # every history has to keep the limits
    histories: Histories | None = None
    band: Spread | None = None
    probability: float | None = None  # that is demanded
    probability_reached: float | None = None
    off: tuple[str, float] | None = None  # an assumed value that, off by a tenth, moves the measure to this one

    def keeps(self, value: float | None) -> bool:
        """Whether a value is within the limits; one that is not known is not."""
        if value is None:
            return False
        return (self.minimum is None or value >= self.minimum) and (self.maximum is None or value <= self.maximum)

    @property
    def certainty(self) -> Certainty:
        """Whether the same verdict holds for every history, all of the band, and with each assumed value off by a tenth.

        A probability that is demanded judges instead of the band.
        """
        if self.value is None or (self.histories is None and self.off is None and self.band is None):
            return "unknown"
        low, high = self.span
        if self.keeps(low) and self.keeps(high):
            return "sure"
        missed = (self.minimum is not None and high < self.minimum) or (self.maximum is not None and low > self.maximum)
        return "sure" if missed else "not_every_history"

    @property
    def span(self) -> tuple[float, float]:
        """Least and greatest value of histories, band, and assumed values off by a tenth; an unknown end is infinite."""
        ends = [(self.value, self.value)]
        if self.histories is not None:
            low, high, _ = self.histories
            ends.append((-math.inf if low is None else low, math.inf if high is None else high))
        if self.off is not None:
            ends.append((self.off[1], self.off[1]))
        if self.band is not None and self.probability is None:
            ends.append((self.band.low, self.band.high))
        return min(low for low, _ in ends), max(high for _, high in ends)

    def as_json(self) -> dict[str, Any]:
        """``{measure, value, min, max, pass, certainty}`` in SI, with the histories where they are known."""
        told: dict[str, Any] = {
            "measure": self.measure,
            "value": self.value,
            "unit": units.DIMENSIONS[self.dimension].si,
            "min": self.minimum,
            "max": self.maximum,
            "pass": self.passed,
            "certainty": self.certainty,
        }
        told |= {"implied": True} if self.implied else {}
        told |= {"whole_band": True} if self.whole_band else {}
        if self.histories is not None:
            told["histories"] = self.histories._asdict()
        elif self.band is not None and self.probability is None:
            told["histories"] = {"low": self.band.low, "high": self.band.high, "cause": PARAMETERS}
        told |= {"off": {"key": self.off[0], "value": self.off[1]}} if self.off else {}
        told |= {"band": self.band.as_json()} if self.band else {}
        both = {"probability": self.probability, "probability_reached": self.probability_reached}
        return told | {name: value for name, value in both.items() if value is not None}


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
    findings: tuple[Finding, ...] = ()  # what the run found out about itself; some decide the verdict
    warnings: tuple[str, ...] = ()
    infeasible: tuple[str, ...] = ()  # violated inequalities of an operation that cannot be done, with margins
    limits: tuple[str, ...] = ()  # what the model leaves out
    convergence: Mapping[str, float] = field(default_factory=dict)  # measure: change when the step is halved, SI
    references: tuple[str, ...] = ()  # keys of cutwise.references that this run used
    notes: Mapping[str, str] = field(default_factory=dict)  # named notices for the report
    advice: tuple[str, ...] = ()  # what to change, or how much room is left, found by running again
    sensitivity: Mapping[str, float] = field(default_factory=dict)  # assumed input: change of the focus measure, SI
    band: BandNote | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "measures", Measures(self.measures))

    def __getitem__(self, stage: str) -> tabular.Stage:
        """A stage, or an array of one: ``result["cutting"]``, ``result["cutting/force"]``."""
        name, _, column = str(stage).partition("/")
        if name not in self.stages.children:
            raise NoSuchName("stage", name, map(str, self.stages.children), "result.stages")
        found = tabular.Stage.of(self.stages.children[name])
        return found[column] if column else found

    def __repr__(self) -> str:
        kept = sum(check.passed for check in self.checks)
        return (
            f"<Result of {self.scenario.name} ({self.scenario.process}): {self.verdict}, {kept} of {len(self.checks)} checks "
            f"passed>\n<{len(self.measures)} measures; stages: {', '.join(map(str, self.stages.children))}>"
        )

    def to_dataframe(self, stage: str) -> pd.DataFrame:
        """The histories of a stage in SI, over time where it has one; ``attrs["units"]`` holds the unit of each column.

        Components are columns of their own (``force_x``); what runs over something else than the index is named in
        ``attrs["left_out"]``.
        """
        return tabular.histories(self[stage].to_dataset())

    def plot(self, name: str | None = None, unit: str | None = None, ax: Any = None, *, width: float = 85.0) -> Any:
        """A figure for a paper: see :func:`cutwise.plots.history`."""
        return above("plot")(self, name, unit, ax, width=width)

    def view(self, height: int = 600) -> Any:
        """The viewer of this run in a notebook, so many pixels high; the cell holds all of it, a megabyte or so."""
        return above("view")(self, height)

    def _repr_html_(self) -> str:
        return str(above("result_html")(self))

    @property
    def verdict(self) -> Literal["pass", "fail", "none"]:
        """``fail`` if a requirement is missed, the operation cannot be done or the run is not sound.

        ``none`` without requirements, and where the scenario sets stability aside.
        """
        if self.infeasible or self.unsound or any(not check.passed for check in self.checks):
            return "fail"
        if self.scenario.set_aside:
            return "none"
        return "pass" if any(not check.implied for check in self.checks) else "none"

    @property
    def unsound(self) -> tuple[Finding, ...]:
        """The findings that leave nothing to be judged, but for those that the scenario sets aside."""
        return tuple(f for f in self.findings if f.code in SOUNDNESS and f.code not in self.scenario.set_aside)

    @property
    def certainty(self) -> Certainty:
        """Whether the verdict holds for every history of friction and set-up, for all of the band of the inputs' scatter,
        and near the assumed values; ``unknown`` where there is no verdict.
        """
        written = [check for check in self.checks if not check.implied]
        told = {check.certainty for check in written}
        missed = any(check.certainty == "sure" and not check.passed for check in written)  # by every history
        if self.verdict == "none":
            return "unknown"
        if self.unsound or self.infeasible or missed or "not_every_history" not in told:
            return "sure" if "sure" in told else "unknown"
        return "not_every_history"

    @property
    def assumed(self) -> tuple[str, ...]:
        """Dotted keys of the input values that nobody has measured or published."""
        return tuple(key for key, origin in self.scenario.origins.items() if origin.status == "assumed")

    @property
    def _focus_unit(self) -> str:
        focus = self.measures.get(self.scenario.focus)
        return focus.unit if focus is not None else ""

    def summary(self, files: Mapping[str, str] | None = None, reasons: Iterable[str] = ()) -> dict[str, Any]:
        """The object that ``run --json`` prints: SI values, no NaN; ``reasons``: why it is not sound, in words."""
        return {
            "scenario": self.scenario.name,
            "process": self.scenario.process,
            "verdict": self.verdict,
            "certainty": self.certainty,
            "reasons": list(reasons),
            "findings": [finding.as_json() for finding in self.findings],
            "measures": {
                name: {"value": m.value, "unit": m.unit} | ({"band": m.band.as_json()} if m.band else {})
                for name, m in self.measures.items()
            },
            "requirements": [check.as_json() for check in self.checks],
            "assumed": list(self.assumed),
            "warnings": list(self.warnings),
            "infeasible": list(self.infeasible),
            "notes": dict(self.notes),
            "convergence": dict(self.convergence),
            "advice": list(self.advice),
            "sensitivity": {"measure": self.scenario.focus, "unit": self._focus_unit, "change": dict(self.sensitivity)},
            "files": dict(files or {}),
        } | ({"band": self.band.as_json(), **self._together} if self.band else {})

    @property
    def _together(self) -> dict[str, float]:
        found = self.band.probability_all if self.band else None
        return {} if found is None else {PROBABILITY_ALL: found}

    def to_bytes(self) -> bytes:
        """A netCDF-4 file with the whole result and the scenario, made in memory: HDF5 does not survive a full disk."""
        tree = self.stages.copy()
        tree.attrs = {
            "title": self.scenario.name,
            "source": "cutwise",
            "scenario": json.dumps(self.scenario.document()),
            "summary": json.dumps(self.summary()),
            "measures": json.dumps(
                {
                    n: [m.value, m.dimension, m.description, *([[*m.band[:3], dict(m.band.carried)]] if m.band else [])]
                    for n, m in self.measures.items()
                }
            ),
            "limits": json.dumps(list(self.limits)),
            "references": json.dumps(list(self.references)),
            "notes": json.dumps(dict(self.notes)),
        }
        return sealed(written(tree))

    def save(self, path: str | Path) -> Path:
        """Write one netCDF-4 file with the whole result and the scenario, whole or not at all."""
        return write_bytes(Path(path), self.to_bytes())

    @classmethod
    def from_file(cls, path: str | Path, scenario: Scenario) -> Result:
        """Read back a file written by :meth:`save`; the scenario comes from ``cutwise.io.scenario``.

        Raises
        ------
        DamagedRun
            It is no run file, or damaged.
        """
        return cls.from_bytes(Path(path).read_bytes(), scenario)

    @classmethod
    def from_bytes(cls, content: bytes, scenario: Scenario) -> Result:
        """As :meth:`from_file`, of what the file holds."""
        tree = tree_of(content)
        try:
            return cls._from_tree(tree, scenario)
        except Exception as error:  # a file that another program has changed may say anything
            raise DamagedRun(
                f"is not a run file of cutwise, or was changed since ({type(error).__name__}: {error})"
            ) from None

    @classmethod
    def _from_tree(cls, tree: xr.DataTree, scenario: Scenario) -> Result:
        summary = json.loads(tree.attrs["summary"])
        measures = {str(n): _measure_from_json(*entry) for n, entry in json.loads(tree.attrs["measures"]).items()}
        return cls(
            scenario=scenario,
            stages=tree,
            measures=measures,
            checks=tuple(_check_from_json(c, measures) for c in summary["requirements"]),
            findings=tuple(Finding.from_json(told) for told in summary.get("findings", ())),
            warnings=texts(summary["warnings"]),
            infeasible=texts(summary["infeasible"]),
            limits=texts(json.loads(tree.attrs["limits"])),
            convergence=numbers(summary["convergence"]),
            advice=texts(summary["advice"]),
            sensitivity=numbers(summary["sensitivity"]["change"]),
            references=texts(json.loads(tree.attrs["references"])),
            notes=json.loads(tree.attrs["notes"]),
            band=note_from_json(summary.get("band")),
        )


def _measure_from_json(value: Any, dimension: str, description: str, band: Any = None) -> Measure:
    if dimension not in units.DIMENSIONS:
        raise ValueError(f"{dimension} is no dimension")
    return Measure(number(value), dimension, str(description), None if band is None else spread_from_json(*band))


def _check_from_json(entry: Mapping[str, Any], measures: Mapping[str, Measure]) -> Check:
    name = entry["measure"]
    dimension = measures[name].dimension if name in measures else "dimensionless"
    value, low, high = (None if entry[key] is None else number(entry[key]) for key in ("value", "min", "max"))
    if not isinstance(entry["pass"], bool):
        raise TypeError(f"pass is {entry['pass']!r:.40}")
    histories, off = entry.get("histories"), entry.get("off")
    return Check(
        str(name), value, dimension, low, high, entry["pass"], entry.get("implied", False),  # type: ignore[arg-type]
        entry.get("whole_band", False), Histories(**histories) if histories and histories["cause"] != PARAMETERS else None,
        measures[name].band if name in measures else None, entry.get("probability"), entry.get("probability_reached"),
        (off["key"], off["value"]) if off else None,
    )  # fmt: skip


def judge(
    scenario: Scenario, measures: Mapping[str, Measure], bands: Mapping[str, Histories] | None = None
) -> Iterator[Check]:
    """Hold the measures against the requirements of the scenario, then against those that every run has.

    A measure that the run lacks fails its limit. ``bands``: between which values measures may come out; a requirement
    on the whole band fails where a part of it is outside, or not known.
    """
    bands = bands or {}
    for name, limit in scenario.asked.items():
        found = measures.get(name) or of_band(measures, name)
        check = Check(
            name, found.value if found else None, scenario.measures[name].dimension, limit.min, limit.max, False,  # type: ignore[arg-type]
            whole_band=bool(limit.whole_band), histories=bands.get(name) if found else None,
            band=found.band if found else None, probability=limit.probability,
        )  # fmt: skip
        histories = check.histories
        whole = histories is not None and check.keeps(histories.low) and check.keeps(histories.high)
        kept = check.keeps(check.value) and (whole or not check.whole_band)
        yield replace(check, passed=kept and check.probability is None)  # until a band tells the probability
    for name, least in scenario.implied.items():
        if name in measures and not _written_as_strictly(scenario, name, least) and not scenario.set_aside:
            value = measures[name].value
            yield Check(name, value, scenario.measures[name].dimension, None, least, value < least, implied=True)


def _written_as_strictly(scenario: Scenario, name: str, most: float) -> bool:
    written = scenario.requirements.get(name)
    return written is not None and written.max is not None and written.max <= most


def unreached(checks: Iterable[Check]) -> Iterator[Finding]:
    """The requirements whose measure does not exist in the run, or whose band or probability is asked for and not known."""
    for check in checks:
        bounds = check.histories[:2] if check.histories else (None, None)
        unsaid = check.probability is not None and check.probability_reached is None
        if check.value is None or (check.whole_band and None in bounds) or unsaid:
            yield Finding("unreached", measure=check.measure, dimension=check.dimension)


def judge_values(scenario: Scenario, values: Mapping[str, float]) -> bool:
    """Whether bare values in SI meet every requirement on them; requirements on other measures do not count."""
    return all(
        (limit.min is None or values[name] >= limit.min) and (limit.max is None or values[name] <= limit.max)
        for name, limit in scenario.asked.items()
        if name in values
    )
