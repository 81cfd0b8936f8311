"""What every scenario has: a name, a process, requirements, and a record of where each value came from."""

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any, ClassVar, NamedTuple, Self

from pydantic import Field, PrivateAttr, field_serializer, field_validator, model_validator

from cutwise import units
from cutwise.above import above
from cutwise.spec import fields
from cutwise.spec.base import Notice, Spec, Status, contradiction
from cutwise.spec.cell import Slots
from cutwise.spec.comparison import Comparison
from cutwise.spec.correct import Correction
from cutwise.spec.faults import NoSuchName, Path, dotted, split_dotted
from cutwise.spec.filled import slot_faults
from cutwise.spec.needs import Needs, unmet
from cutwise.spec.uncertain import Band, Covariance, Fitted, stem


@dataclass(frozen=True, slots=True)
class Origin:
    """Where an input value came from."""

    status: Status
    source: str = ""
    text: str = field(default="", compare=False)  # as written
    library: str = ""  # the library entry that gave it


@dataclass(frozen=True, slots=True)
class _Read:
    """Files that a scenario was made from; scenarios that say the same are equal, wherever it stood."""

    files: tuple[str, ...] = field(default=(), compare=False)
    folder: str = field(default="", compare=False)


class MeasureSpec(NamedTuple):
    """A measure that a process reports."""

    dimension: str
    description: str


PROBABILITY_ALL = "probability_all"
_OF_BAND = {
    "sd": "standard deviation of {}",
    "low": "{}: 5 % of what the scatter of the inputs makes of it lie below",
    "high": "{}: 5 % of what the scatter of the inputs makes of it lie above",
}
_TOGETHER = MeasureSpec("dimensionless", "probability that all requirements are met, by the scatter of the inputs")


class Known(dict[str, MeasureSpec]):
    """The measures of a process; the ends of their bands are known beside them, and not listed."""

    def __init__(self, own: Mapping[str, MeasureSpec]) -> None:
        super().__init__(own)
        self.own = own  # may know more names than it lists

    def __missing__(self, name: str) -> MeasureSpec:
        found = self._of_band(name)
        return self.own[name] if found is None else found

    def __contains__(self, name: object) -> bool:
        return name in self.own or self._of_band(name) is not None

    def get(self, name: str, default: Any = None) -> Any:
        """As of any mapping."""
        try:
            return self[name]
        except KeyError:
            return default

    def _of_band(self, name: object) -> MeasureSpec | None:
        if name == PROBABILITY_ALL:
            return _TOGETHER
        found = stem(str(name))
        if found is None or found[0] not in self.own:
            return None
        dimension, description = self.own[found[0]]
        return MeasureSpec(dimension, _OF_BAND[found[1]].format(description))


class Limit(Spec):
    """Limits on a measure, in the measure's own unit once read."""

    min: Any = Field(default=None, description="smallest value that passes", examples=["-0.05 mm"])
    max: Any = Field(default=None, description="largest value that passes", examples=["0.05 mm"])
    whole_band: bool = Field(
        default=False,
        description="whether every history of friction and set-up has to pass, not only the one of the run",
        examples=[True],
    )
    probability: float | None = Field(
        default=None,
        description="with which the limits have to be kept, as far as the scatter of the inputs goes",
        examples=[0.95],
    )


class Scenario(Spec):
    """The base of the scenarios of all processes."""

    measures: ClassVar[Mapping[str, MeasureSpec]] = {}
    starts: ClassVar[Mapping[str, str]] = {}
    """Dotted keys that a new scenario says in other words than the example of the field, or that it needs besides the
    required ones."""
    levers: ClassVar[Mapping[str, tuple[str, str]]] = {}
    """What an engineer would turn, as dotted keys, each with the limits within which advice looks."""
    sound: ClassVar[Mapping[str, float]] = {}
    """Measures that must stay above a value [SI] for a run to count as sound: advice leads to no other."""
    needs: ClassVar[Needs] = {}
    """What measures need of the scenario, by pattern of their names."""
    focus: ClassVar[str] = ""
    """The measure that sensitivities are told for."""
    implied: ClassVar[Mapping[str, float]] = {}
    """Measures that have to stay below a value [SI] in every run that has them, whether or not it is written."""

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        super().__pydantic_init_subclass__(**kwargs)
        cls.measures = Known(cls.measures)

    @property
    def set_aside(self) -> frozenset[str]:
        """Codes of the findings that shall not decide; the run has no verdict then, or fails."""
        return frozenset()

    @property
    def asked(self) -> Mapping[str, Limit]:
        """The requirements, and those that follow from other keys, such as a tolerance of the part."""
        return self.requirements

    def lacking(self, measure: str) -> tuple[str, ...]:
        """The keys without which this scenario cannot have a measure; none if it can."""
        banded = stem(measure)
        if banded is None and measure != PROBABILITY_ALL:
            return tuple(unmet(self, self.needs, measure))
        own = tuple(unmet(self, self.needs, banded[0])) if banded else ()
        return (*own, *self.without_band())

    def without_band(self) -> tuple[str, ...]:
        """What a band of the result lacks; nothing if it lacks nothing."""
        if self.band.method == "none":
            return ("band.method linear or sampled",)
        if not self.covariances:
            return ("a value with a standard error, as entries of cutwise calibrate have",)
        return ()

    def unused(self) -> Iterator[Notice]:
        """How a band is made, where nothing has a standard error."""
        yield from super().unused()
        if not self.covariances:
            asked = self.own_scatter() and any(limit.probability is not None for limit in self.requirements.values())
            for key in ("samples", "seed") if asked else ("method", "samples", "seed"):
                yield Notice(("band", key), "no value of the scenario has a standard error")

    def caveat(self, measure: str) -> str:  # noqa: ARG002
        """What has to be said wherever a measure is shown; mostly nothing."""
        return ""

    def own_scatter(self) -> Mapping[str, str]:
        """Measures with a scatter that the process itself knows, each with the measure that is its standard deviation."""
        return {}

    def unobtainable(self) -> Iterator[Notice]:
        """Requirements on measures that no run of this scenario has, each with the key that would provide it."""
        for name in self.requirements:
            lacking = self.lacking(name)
            if lacking:
                yield Notice(
                    ("requirements", name),
                    f"a run of this scenario has no such measure; it needs {' and '.join(lacking)}",
                )
            elif (
                self.requirements[name].probability is not None
                and name not in self.own_scatter()
                and (without := self.without_band())
            ):
                yield Notice(
                    ("requirements", name, "probability"),
                    f"no probability can be told: it needs {' and '.join(without)}",
                )

    @model_validator(mode="after")
    def _holds_together(self) -> Self:
        found = (*self.contradictions(), *self.unobtainable(), *slot_faults(self))
        if found:
            raise contradiction(found)
        return self

    def checks(self) -> Iterator[Iterator[Notice]]:
        """The contradictions between sections, in groups that need no other sections than they look at."""
        yield self.contradictions()

    @classmethod
    def contradictions_among(cls, sections: Mapping[str, Any]) -> Iterator[Notice]:
        """What contradicts itself among the sections that are right by themselves; checks that need others are left out."""
        partial = cls.model_construct(**sections)
        for name in cls.model_fields.keys() - sections.keys():
            partial.__dict__.pop(name, None)
        for check in (*partial.checks(), partial.unobtainable(), slot_faults(partial)):
            with suppress(AttributeError):  # of a section that is not there
                yield from check

    def turned(self) -> Mapping[str, tuple[str, str]]:
        """The levers of this scenario; those of several numbers turn all of them together, by a factor."""
        return self.levers

    def unasked(self) -> int:
        """Further runs that advice on a finished run may make without being asked: fewer where a run takes long.

        A number of the scenario, not of the machine: a report is the same everywhere.
        """
        return 100

    name: str = Field(
        default="unnamed",
        description="name of the scenario",
        examples=["deburr bracket"],
        pattern=r"^[^/\\\n]+$",
    )
    process: str = Field(description="which operation is simulated")
    cell: Slots | None = Field(
        default=None, description="the rows that fill the five slots of the cell, where they are named: held against what the "
        "sections say, and instead of process where they tell it",
    )  # fmt: skip
    requirements: dict[str, Limit] = Field(
        default_factory=dict,
        description="limits on measures: each measure with min, max or both",
        examples=["{surface_error_max: {max: 0.05 mm}}"],
    )
    band: Band = Field(default=Band(), description="how the scatter of measured values is carried to the result")
    covariances: dict[str, Covariance] = Field(
        default_factory=dict,
        description="covariances of values; those of library entries come with them",
        examples=["{cut: {of: [material.K_tc, material.K_te], matrix: [[4e14, -1e9], [-1e9, 1e6]]}}"],
    )
    compare: Comparison | None = Field(
        default=None, description="what cutwise compare holds side by side; a run does not read it"
    )
    correct: Correction | None = Field(
        default=None, description="what cutwise correct may change, and within which limits; a run does not read it"
    )
    measured: dict[str, Fitted] = Field(
        default_factory=dict,
        description="what calibrations say about their entries; comes with them",
        examples=["{robot: {library: my_arm.yaml, residual: 0.22 mm}}"],
    )

    _origins: dict[str, Origin] = PrivateAttr(default_factory=dict)
    _read: _Read = PrivateAttr(default_factory=_Read)

    @field_validator("requirements", mode="before")
    @classmethod
    def _limits_in_the_unit_of_the_measure(cls, given: Any) -> Any:
        """Turn the text of each limit into SI."""
        if not isinstance(given, Mapping):
            return given
        found: list[Notice] = []
        limits = {name: _limit(cls, name, limit, found) for name, limit in given.items()}
        if found:
            raise contradiction(found)
        return limits

    @field_serializer("requirements", when_used="json")
    def _limits_as_text(self, requirements: dict[str, Limit]) -> dict[str, dict[str, Any]]:
        return {
            name: {
                end: units.text(value, self.measures[name].dimension)
                for end, value in (("min", limit.min), ("max", limit.max))
                if value is not None
            }
            | ({"whole_band": True} if limit.whole_band else {})
            | ({"probability": limit.probability} if limit.probability is not None else {})
            for name, limit in requirements.items()
        }

    @property
    def origins(self) -> Mapping[str, Origin]:
        """Dotted key of every given value: where it came from (library entry, or the user)."""
        return self._origins

    @property
    def files(self) -> tuple[str, ...]:
        """Files that were read to make it, besides its own."""
        return self._read.files

    @property
    def folder(self) -> str:
        """Where files that it names are looked for."""
        return self._read.folder

    def with_files(self, files: Iterable[str], folder: str = "") -> Self:
        """The same scenario, knowing which files it was made from, and where others would stand."""
        copy = self.model_copy()
        copy._read = _Read(tuple(dict.fromkeys(files)), folder)
        return copy

    def with_(self, values: Mapping[str, Any]) -> Self:
        """A new scenario with some values replaced, checked as :func:`cutwise.load` checks them.

        Parameters
        ----------
        values : mapping
            Dotted keys with their values as in a file: ``{"spindle.pressure": "4 bar"}``.

        Raises
        ------
        ScenarioFault
            Everything that is wrong, named as ``overrides["spindle.pressure"]``.
        """
        return above("with_values")(self, values)  # type: ignore[no-any-return]

    def __contains__(self, key: object) -> bool:
        """Whether there is a value at a dotted key: ``"spindle.pressure" in scenario``."""
        try:
            self[key]  # type: ignore[index]
        except NoSuchName:
            return False
        return True

    def __setitem__(self, key: str, value: object) -> None:
        """A scenario does not change."""
        raise TypeError(f'a scenario does not change; scenario.with_({{"{key}": ...}}) gives a new one')

    def __getitem__(self, key: str) -> Any:
        """The value of a dotted key in SI: ``scenario["spindle.pressure"]``; None where a key is left open.

        Raises
        ------
        NoSuchName
            This scenario has no such key, or lacks the section that it stands in.
        """
        found: Any = self
        path = split_dotted(str(key))
        for place, step in enumerate(path):
            named = isinstance(found, Spec) and step in type(found).model_fields
            listed = isinstance(found, tuple) and isinstance(step, int) and step < len(found)
            if named:
                found = getattr(found, str(step))
            elif listed or (isinstance(found, Mapping) and step in found):
                found = found[step]
            else:
                raise _not_said(self, key, path[:place], found)
        if not path:
            raise _not_said(self, key, (), self)
        return found

    def __repr__(self) -> str:
        return (
            f"<{type(self).__name__} {self.name!r}: {len(self.origins)} values, {len(self.requirements)} requirements>"
        )

    def _repr_html_(self) -> str:
        return str(above("scenario_html")(self))

    def with_origins(self, origins: Mapping[str, Origin]) -> Self:
        """The same scenario, knowing where its values came from."""
        copy = self.model_copy()
        copy._origins = dict(origins)
        return copy

    def document(self) -> dict[str, Any]:
        """The scenario as plain values that can be read back exactly; each value with its source.

        Values stand as they were written, and in SI to the last bit where that is not known. Library values are
        written out, marked with the entry that gave them, so that the document needs no library.
        """
        plain = self.model_dump(mode="json", exclude_unset=True, exclude_none=True)
        plain = {"name": self.name, "process": self.process, **plain}
        for key, origin in self._origins.items():
            path = split_dotted(key)
            place = _container(plain, path)
            if place is None:
                continue
            value = self._as_written(path, place[path[-1]], origin.text)
            if origin.status == "user" and not origin.source and not origin.library:
                place[path[-1]] = value
                continue
            place[path[-1]] = {"value": value, "status": origin.status, "source": origin.source}
            if origin.library:
                place[path[-1]]["library"] = origin.library
        return plain

    def _as_written(self, path: Path, value: Any, text: str) -> Any:
        """The text that the engineer wrote, as long as it still says the value."""
        info = fields.field_at(type(self), path)
        dimension = fields.dimension(info) if info is not None else None
        if path[0] == "requirements" and len(path) == 3 and path[2] in ("min", "max"):
            dimension = self.measures[str(path[1])].dimension
        if not text or dimension is None or not isinstance(value, str):
            return value
        try:
            same = units.parse(text, dimension) == units.parse(value, dimension)
        except units.UnitFault:
            return value
        return text if same else value


def _not_said(scenario: Scenario, key: str, before: Path, found: Any) -> NoSuchName:
    """Why a dotted key leads nowhere."""
    where = f"scenario[{dotted(before)!r}]" if before else "scenario"
    if found is None:
        return NoSuchName("key", key, scenario.origins, f"{where} is left out")
    if isinstance(found, Spec) and not before:
        return NoSuchName("key", key, [*type(found).model_fields, *scenario.origins], where)
    names = type(found).model_fields if isinstance(found, Spec) else found if isinstance(found, Mapping) else ()
    inside = [dotted((*before, str(name))) for name in names]
    entries = [dotted((*before, i)) for i in range(len(found))] if isinstance(found, tuple) else []
    return NoSuchName("key", key, inside or entries or [dotted(before)], where)


def _container(plain: Any, path: Path) -> Any:
    """The mapping or list that holds the value at a path; None if there is no such value."""
    for step in path[:-1]:
        try:
            plain = plain[step]
        except (KeyError, IndexError, TypeError):
            return None
    return plain if isinstance(plain, dict) and path[-1] in plain else None


def _limit(scenario: type[Scenario], name: str, limit: Any, found: list[Notice]) -> Any:
    """One requirement in SI; what is wrong with it is added to ``found``."""
    path = (name,)
    if name not in scenario.measures:
        near = get_close_matches(name, scenario.measures, n=1)
        hint = f"did you mean {near[0]}?" if near else "known are: " + ", ".join(scenario.measures)
        found.append(Notice(path, f"unknown measure; {hint}"))
        return limit
    if isinstance(limit, Limit):
        more = {"whole_band": True if limit.whole_band else None, "probability": limit.probability}
        limit = {"min": limit.min, "max": limit.max, **more}
    example = limit if isinstance(limit, str) else units.DIMENSIONS[scenario.measures[name].dimension].example
    ends = {end: text for end, text in limit.items() if text is not None} if isinstance(limit, Mapping) else {}
    if not ends.keys() - {"whole_band", "probability"}:
        found.append(Notice(path, f"has no limit; write min, max or both, for example {{max: {example}}}"))
        return limit
    read: dict[str, Any] = {}
    for end, text in ends.items():
        if end == "whole_band":
            read[end] = text
            if not isinstance(text, bool):
                found.append(Notice((*path, end), f"{text} is neither true nor false"))
            continue
        if end == "probability":
            read[end] = _probability((*path, end), text, found)
            continue
        if end not in ("min", "max"):
            found.append(Notice((*path, end), "unknown key; a requirement has min, max, whole_band and probability"))
            continue
        try:
            read[end] = measure_value(scenario, name, text)
        except units.UnitFault as fault:
            found.append(Notice((*path, end), str(fault)))
    if read.get("min", -math.inf) > read.get("max", math.inf):
        found.append(Notice(path, f"min {ends['min']} is above max {ends['max']}"))
    return read


def _probability(path: Path, text: Any, found: list[Notice]) -> float | None:
    """A demanded probability; below a half the limits would be missed more often than kept."""
    try:
        value = units.parse(text, "dimensionless")
    except units.UnitFault as fault:
        found.append(Notice(path, str(fault)))
        return None
    if not 0.5 <= value < 1.0:
        found.append(Notice(path, f"{text} is not between 0.5 and 1 (below it); write for example 0.95"))
        return None
    return value


def measure_value(scenario: type[Scenario], name: str, text: object) -> float:
    """A limit written as text, in the SI unit of the measure it limits."""
    return units.parse(text, scenario.measures[name].dimension)
