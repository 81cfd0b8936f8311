"""What ``cutwise correct`` may change of a scenario and its program, how far, and for what."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, WithJsonSchema, field_serializer, field_validator

from cutwise import units
from cutwise.spec.base import Count, Length, Notice, Spec, Time, Usual, contradiction

_ALL = frozenset({"objective", "change", "limits"})
_FEED = frozenset({"air_clearance", "station", "split_gain", "blocks_max", "front"})
EDGE = frozenset({"aim", "burr_scatter", "look_ahead", "judge_from"})
"""What a feed along a burred edge reads."""

_PATH = frozenset(
    {"residual", "iterations", "lead", "smoothing", "chord", "decimals", "shift_max", "draws", "vary", "seed"}
)

KEYS: Mapping[str, frozenset[str]] = {
    "feed": _ALL | _FEED | EDGE,
    "speed": _ALL | {"ranges"},
    "path": _ALL | _PATH,
    "offset": _ALL | _PATH | {"ranges"},
    "depth": _ALL | {"ranges"},
    "placement": _ALL | {"ranges"},
}
"""What each change reads of the section; a key that none of the changes asked for reads is told, or refused where its change
is not there (:func:`cutwise.study.correct.entry.refused`)."""

LIMITED: Mapping[str, str] = {
    "force_xy_peak": "force",
    "force_xy_mean_max": "force",
    "cutting_power_max": "power",
    "spindle_torque_max": "moment",
    "chip_thickness_max": "small_length",
    "chip_thickness_min": "small_length",
    "wall_error_min": "small_length",
    "wall_error_max": "small_length",
    "contour_error_max": "small_length",
    "tip_deflection_max": "small_length",
    "removal_rate_max": "removal_rate",
    "plunge_force_max": "force",
    "chatter_growth_corner": "dimensionless",
    "chatter_growth_straight": "dimensionless",
}
"""Measures that a correction can be held to, each with its dimension; of several that bind alike the first is named."""

BUDGETS: Mapping[str, str] = {**LIMITED, "cycle_time": "time"}
"""Measures of which a front may have budgets, each with its dimension."""

_EXAMPLE = "{force_xy_peak: {max: 600 N}, wall_error_min: equal}"


_Written = Annotated[float, WithJsonSchema({"type": ["number", "string"]})]  # with the unit of its measure


class Bound(Spec):
    """Between which values a measure has to stay."""

    min: _Written | None = Field(default=None, description="least value", examples=["-10 um"])
    max: _Written | None = Field(default=None, description="greatest value", examples=["600 N"])


class Correction(Spec):
    """What may be changed, within which limits, and for what."""

    listed: ClassVar[bool] = False
    beside: ClassVar[tuple[str, ...]] = ("draws",)

    objective: Literal["time", "error", "cost"] = Field(
        default="time", description="what is made least", examples=["time"]
    )
    change: tuple[str, ...] = Field(
        default=("feed",), description="what may be changed: feed, speed, path, offset, depth, placement",
        examples=["[feed, speed]"],
    )  # fmt: skip
    limits: dict[str, Bound | Literal["equal"]] = Field(
        default_factory=dict,
        description="limits on measures beside the requirements: min, max or both, or equal: what the run before has",
        examples=[_EXAMPLE],
    )
    front: dict[str, tuple[_Written, ...]] = Field(
        default_factory=dict, description="budgets of one limit (or of cycle_time, with objective error), for each of which a "
        "program is made and simulated: what more of it buys", examples=["{force_xy_peak: [450 N, 500 N, 600 N]}"],
    )  # fmt: skip
    ranges: dict[str, tuple[str, str]] = Field(
        default_factory=dict, description="between which values a setting may be turned",
        examples=["{operation.spindle_speed: [6000 rpm, 12000 rpm]}"],
    )  # fmt: skip
    air_clearance: Annotated[Length, Usual("0.1 mm", "5 mm")] | None = Field(
        default=None,
        description="moves in air go at the machine's feed up to this distance from the stock; left out: they keep their feed",
        examples=["0.5 mm"], gt=0,
    )  # fmt: skip
    station: Annotated[Length, Usual("0.05 mm", "2 mm")] = Field(
        default=0.25e-3, description="length of the cells of a move that are looked at", examples=["0.25 mm"], gt=0
    )
    split_gain: Annotated[Time, Usual("0.1 ms", "20 ms")] = Field(
        default=1e-3, description="time that a further block has to gain", examples=["1 ms"], ge=0
    )
    blocks_max: Count | None = Field(
        default=None, description="most blocks of the new program; left out: as many as gain", examples=[5000], ge=1
    )
    residual: float = Field(
        default=0.1, description="share of the error before that may be left", examples=[0.1], gt=0, lt=1
    )
    iterations: Count = Field(default=8, description="most runs of a compensation", examples=[8], ge=1)
    lead: Time | None = Field(
        default=None, description="how far ahead a shift acts; left out: as converges best", examples=["4 ms"]
    )
    smoothing: Time | None = Field(
        default=None, description="standard deviation of the filter of a shift; left out: as the path allows",
        examples=["2 ms"], ge=0,
    )  # fmt: skip
    chord: Length = Field(
        default=0.1e-3, description="length of the chords of a shifted path", examples=["0.1 mm"], gt=0
    )
    decimals: Count = Field(default=4, description="decimals of shifted coordinates", examples=[4], ge=1, le=9)
    shift_max: Length = Field(default=0.2e-3, description="largest shift of a path", examples=["0.2 mm"], gt=0)
    draws: Count | str = Field(
        default=40,
        description="draws of what is uncertain, or a CSV of given ones, a column for each key",
        examples=[40],
    )
    vary: dict[str, Any] = Field(
        default_factory=dict, description="what is uncertain, as in a study",
        examples=["{material.K_tc: {normal: {deviation: 3 %}}}"],
    )  # fmt: skip
    aim: Length | None = Field(
        default=None, description="edge error of deburring that the feed aims at; left out: as far below zero as the burr scatters",
        examples=["-0.02 mm"],
    )  # fmt: skip
    burr_scatter: Annotated[float, Usual(0.01, 0.5)] | None = Field(
        default=None, description="standard deviation of the burr height over its mean, for the aim", examples=[0.06], ge=0, lt=0.6
    )  # fmt: skip
    look_ahead: Length | None = Field(
        default=None, description="how far ahead of the tool the burr says the feed; left out: to the middle of the arc "
        "of the deflected mill", examples=["2.5 mm"], ge=0,
    )  # fmt: skip
    judge_from: Length | None = Field(
        default=None, description="place from which on an edge is judged; left out: behind the lead-in",
        examples=["30 mm"], ge=0,
    )  # fmt: skip
    seed: Count = Field(default=1, description="seed of the draws", examples=[1], ge=0)

    @field_validator("limits", mode="before")
    @classmethod
    def _in_the_unit_of_the_measure(cls, given: Any) -> Any:
        """Turn the text of each limit into SI."""
        if not isinstance(given, Mapping):
            return given
        found: list[Notice] = []
        read = {name: _bound(str(name), one, found) for name, one in given.items()}
        if found:
            raise contradiction(found)
        return read

    @field_validator("front", mode="before")
    @classmethod
    def _budgets(cls, given: Any) -> Any:
        """Turn the text of each budget into SI."""
        if not isinstance(given, Mapping):
            return given
        found: list[Notice] = []
        read = {str(name): _read_budgets(str(name), budgets, found) for name, budgets in given.items()}
        if len(given) > 1:
            found.append(Notice((), f"is over one measure at a time, not {len(given)}"))
        if found:
            raise contradiction(found)
        return read

    @field_serializer("front", when_used="json")
    def _budgets_as_text(self, front: Mapping[str, tuple[float, ...]]) -> dict[str, Any]:
        return {name: [units.text(value, BUDGETS[name]) for value in values] for name, values in front.items()}

    @field_serializer("limits", when_used="json")
    def _as_text(self, limits: Mapping[str, Bound | str]) -> dict[str, Any]:
        return {
            name: bound if isinstance(bound, str) else {
                end: units.text(value, LIMITED[name]) for end in ("min", "max") if (value := getattr(bound, end)) is not None
            }
            for name, bound in limits.items()
        }  # fmt: skip

    def contradictions(self) -> Iterator[Notice]:
        """Changes that do not exist, or are there twice."""
        if not self.change:
            yield Notice(("change",), f"is empty; write one or more of {', '.join(KEYS)}")
        for place, change in enumerate(self.change):
            if change not in KEYS:
                near = get_close_matches(change, KEYS, n=1)
                hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(KEYS)}"
                yield Notice(("change", place), f"{change} is nothing that can be changed; {hint}")
            if change in self.change[:place]:
                yield Notice(("change", place), f"{change} is there twice")


def _read_budgets(name: str, given: Any, found: list[Notice]) -> tuple[float, ...]:
    """Budgets in SI; what is wrong with them is added to ``found``."""
    if name not in BUDGETS:
        near = get_close_matches(name, BUDGETS, n=1)
        hint = f"did you mean {near[0]}?" if near else f"known are: {', '.join(BUDGETS)}"
        found.append(Notice((name,), f"is no measure that a front has budgets of; {hint}"))
        return ()
    if not isinstance(given, (list, tuple)) or not given:
        example = units.DIMENSIONS[BUDGETS[name]].example
        found.append(Notice((name,), f"needs a list of budgets, for example [{example}]"))
        return ()
    read = []
    for place, text in enumerate(given):
        if isinstance(text, float):
            read.append(text)
            continue
        try:
            read.append(units.parse(text, BUDGETS[name]))
        except units.UnitFault as fault:
            found.append(Notice((name, place), str(fault)))
    return tuple(read)


def _bound(name: str, given: Any, found: list[Notice]) -> Any:
    """One limit in SI; what is wrong with it is added to ``found``."""
    if name not in LIMITED:
        near = get_close_matches(name, LIMITED, n=1)
        hint = f"did you mean {near[0]}?" if near else f"known are: {', '.join(LIMITED)}"
        found.append(Notice((name,), f"is no measure that a correction is held to; {hint}"))
        return {}
    if isinstance(given, Bound) or given == "equal":
        return given
    example = units.DIMENSIONS[LIMITED[name]].example
    written = {end: text for end, text in given.items() if text is not None} if isinstance(given, Mapping) else {}
    if not written:
        found.append(Notice((name,), f"has no limit; write {{max: {example}}}, {{min: {example}}} or equal"))
        return {}
    read: dict[str, float] = {}
    for end, text in written.items():
        if end not in ("min", "max"):
            found.append(Notice((name, str(end)), "unknown key; a limit has min and max, or is the word equal"))
            continue
        try:
            read[end] = units.parse(text, LIMITED[name])
        except units.UnitFault as fault:
            found.append(Notice((name, end), str(fault)))
    if len(read) == 2 and read["min"] > read["max"]:
        found.append(Notice((name,), f"min {written['min']} is above max {written['max']}"))
    return read
