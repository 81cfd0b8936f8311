"""How numbers are shown: in one unit for one quantity, with as many decimals as say something, never another verdict.

With a limit a number has the unit of the limit as it was typed; without, all of one quantity in a group share unit and
decimals. Full precision stands in ``--json``.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

from cutwise import units
from cutwise.spec.scenario import Limit, Scenario

_MOST_DECIMALS = 6
_LENGTHS = ("length", "small_length", "feed_per_revolution")
_ANGLES = ("angle", "small_angle")
_STEPS = {  # unit from which size [SI] on, largest first
    "length": ((1e-4, "mm", 1e-3), (1e-7, "µm", 1e-6), (0.0, "nm", 1e-9)),
    "angle": ((math.radians(0.1), "°", math.pi / 180.0), (1e-4, "mrad", 1e-3), (0.0, "µrad", 1e-6)),
}

GROUPS = ("surface", "force and power", "motion and time", "structure", "checks")
_GROUP_OF = (  # the first pattern that a name matches
    ("checks", r"^probability_all$|margin|clearance|_bound|reach$|memory_index|growth|stable_depth|residual|balance|convexity"
               r"|skating|interpolation|linear_|saturation|voltage|refused|collision|rapids_in_stock|surface_check|probability_within"),
    ("structure", r"deflection|tilt$|drill_tilt|compliance|natural_frequency|redundancy|breakaway|loading_force|stiff"
                  r"|^share_|^sag_|tool_offset"),
    ("force and power", r"force|power|thrust|torque|chip_|removal|removed|engagement_angle"),
    ("motion and time", r"time|^feed_|tool_life|cost|drive_error|deviation_drives|tracking|overshoot|bandwidth|path_length"
                        r"|edge_length|points|stops|position_start|edges_|corners|trimmed|holes_drilled|chord"),
)  # fmt: skip


class Form(NamedTuple):
    """A unit and a number of decimals, shared by numbers that belong together."""

    unit: str
    scale: float  # SI of one unit
    decimals: int

    def number(self, value: float) -> str:
        """A value in SI as a bare number in the unit; what is less than half of the last decimal is 0."""
        number = value / self.scale
        if abs(number) < 0.5 * 10.0**-self.decimals:
            return "0"
        return f"{number:.{self.decimals}f}"

    def text(self, value: float) -> str:
        """A value with its unit."""
        return _joined(self.number(value), self.unit)


def form(dimension: str, values: Iterable[float], unit_and_size: tuple[str, float] | None = None) -> Form:
    """The form of values without a limit: the unit of the largest (or a given one), decimals for four figures of it."""
    largest = max((abs(value) for value in values if math.isfinite(value)), default=0.0)
    unit, scale = unit_and_size or _unit(dimension, largest)
    size = largest / scale
    decimals = 3 - math.floor(math.log10(size)) if size > 0.0 else 0
    return Form(unit, scale, min(_MOST_DECIMALS, max(0, decimals)))


def _unit(dimension: str, largest: float) -> tuple[str, float]:
    kind = "length" if dimension in _LENGTHS else "angle" if dimension in _ANGLES else ""
    for least, unit, scale in _STEPS.get(kind, ()):
        if largest >= least * (1.0 - 1e-12):
            return unit, scale
    number, unit = units.displayed(1.0, dimension)
    return unit, 1.0 / number


class Held(NamedTuple):
    """A number that is held against a limit, as it is shown beside it."""

    number: str
    unit: str
    asked: str  # the limit in the same unit

    @property
    def text(self) -> str:
        """The number with its unit."""
        return _joined(self.number, self.unit)


def held(scenario: Scenario, name: str, value: float | None, limit: Limit) -> Held:
    """A measure with limits: the unit as typed, decimals from the limit, and more while the verdict would be another."""
    dimension = scenario.measures[name].dimension
    unit, scale = _typed(scenario, name, dimension)
    ends = {end: float(f"{bound / scale:.12g}") for end, bound in (("min", limit.min), ("max", limit.max))
            if bound is not None}  # fmt: skip
    asked = _asked({end: _joined(f"{bound:.10g}", unit) for end, bound in ends.items()})
    if value is None:
        return Held("not available", "", asked)
    return Held(_against(value / scale, ends, _meets(value, limit)), unit, asked)


def amount(scenario: Scenario, name: str, value: float, digits: int = 3) -> str:
    """A distance or another value of a measure beside its limit: in the unit as typed, so many figures."""
    unit, scale = _typed(scenario, name, scenario.measures[name].dimension)
    return _joined(_figures(value / scale, digits), unit)


def span(scenario: Scenario, name: str, ends: Sequence[float | None], limit: Limit) -> tuple[str, str]:
    """Ends of a band and the limit, both in the unit as typed: ``-13.8 … 480 µm`` and ``50 µm``.

    Three figures, and more while the shown end would be on another side of the limit. An end that is not known is ``?``.
    """
    unit, scale = _typed(scenario, name, scenario.measures[name].dimension)
    bounds = {end: float(f"{bound / scale:.12g}") for end, bound in (("min", limit.min), ("max", limit.max))
              if bound is not None}  # fmt: skip
    shown = ["?" if end is None else _beside_bounds(end / scale, bounds, _meets(end, limit)) for end in ends]
    return _joined(" … ".join(shown), unit), _joined(" to ".join(f"{bound:.10g}" for bound in bounds.values()), unit)


def _beside_bounds(number: float, bounds: Mapping[str, float], met: bool, least: int = 3) -> str:
    texts = (_figures(number, digits) for digits in range(least, 18))
    return next((text for text in texts if _within(float(text), bounds) == met), f"{number:.17g}")


def typed_unit(scenario: Scenario, names: Iterable[str]) -> tuple[str, float] | None:
    """Unit of the first of these measures that has a limit, as the limit was typed, and its size [SI]; None: none has."""
    name = next((one for one in names if one in scenario.asked), None)
    return None if name is None else _typed(scenario, name, scenario.measures[name].dimension)


def at_a_place(value: float, scale: float, low: float | None, high: float | None) -> str:
    """A value of a history in a unit: four figures, and more while it would be on another side of a limit (all SI).

    Zeros at the end stand, so that values of a list are read as equally exact.

    Examples
    --------
    >>> at_a_place(46.8238e-6, 1e-6, None, 60e-6), at_a_place(60.00004e-6, 1e-6, None, 60e-6)
    ('46.82', '60.00004')
    >>> at_a_place(0.3e-3, 1e-3, 0.299e-3, 0.301e-3)
    '0.3000'
    """
    limit = Limit(min=low, max=high)
    bounds = {end: float(f"{bound / scale:.12g}") for end, bound in (("min", low), ("max", high)) if bound is not None}
    whole = _beside_bounds(value / scale, bounds, _meets(value, limit), 4)
    padded = f"{value / scale:#.4g}".removesuffix(".")
    return padded if "e" not in padded and float(padded) == float(whole) else whole


def _figures(number: float, digits: int) -> str:
    """So many significant figures, without an exponent where people can read it."""
    text = f"{number:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(number) < 1e7 else text


def beside(scenario: Scenario, name: str, ends: Sequence[float], shown: Form | None) -> str:
    """Ends of a band in the unit of the measure, which has the form of its group or, with a limit, that of the limit."""
    dimension = scenario.measures[name].dimension
    shape = form(dimension, ends, _typed(scenario, name, dimension) if shown is None else (shown.unit, shown.scale))
    return " … ".join(shape.number(end) for end in ends)


def _against(number: float, ends: Mapping[str, float], met: bool) -> str:
    size = max(map(abs, ends.values())) or abs(number)
    if size == 0.0:
        return "0"
    decimals = max(0, 2 - math.floor(math.log10(size)))
    if abs(number) < 0.5 * 10.0**-decimals and _within(0.0, ends) == met:
        return "0" if number == 0.0 else f"< {_least(decimals)}"
    for more in range(_MOST_DECIMALS + 1):
        shown = f"{number:.{decimals + more}f}"
        if _within(float(shown), ends) == met:
            return shown
    return f"{number:.17g}"


def _least(decimals: int) -> str:
    """The last decimal: a row of zeros that nobody counts is told by its power of ten."""
    return f"{10.0**-decimals:.{decimals}f}" if decimals <= _MOST_DECIMALS else f"1e-{decimals}"


def _within(number: float, ends: Mapping[str, float]) -> bool:
    return ends.get("min", -math.inf) <= number <= ends.get("max", math.inf)


def _meets(value: float, limit: Limit) -> bool:
    return (limit.min is None or value >= limit.min) and (limit.max is None or value <= limit.max)


def _asked(ends: Mapping[str, str]) -> str:
    if len(ends) == 2:
        return f"{ends['min']} to {ends['max']}"
    return f"at most {ends['max']}" if "max" in ends else f"at least {ends['min']}"


def _typed(scenario: Scenario, name: str, dimension: str) -> tuple[str, float]:
    """Unit of a limit as it was typed, and its size; the usual one where the limit was given in SI."""
    for end in ("max", "min"):
        origin = scenario.origins.get(f"requirements.{name}.{end}")
        match = re.fullmatch(r"\s*[-+\d.eE_\u2212]+\s*([^\d\s].*?)\s*", origin.text) if origin is not None else None
        if match is not None and dimension != "dimensionless":
            try:
                scale = units.factor(match[1], dimension)
            except units.UnitFault:
                continue
            return printed(match[1]), 1.0 / round(1.0 / scale, 9) if scale < 1.0 else scale
    number, unit = units.displayed(1.0, dimension)
    return unit, 1.0 / number


def printed(unit: str) -> str:
    """A unit as it was typed, for print: ``um`` is µm, ``mm^2`` is mm²."""
    text = units.pretty(unit.replace("^", "**"))
    return re.sub(r"\bu(?=[A-Za-z])", "µ", text)


def _joined(number: str, unit: str) -> str:
    return f"{number}{'' if unit == '°' else ' '}{unit}".strip()


def group_of(name: str) -> str:
    """The group that a measure is listed in."""
    return next((group for group, pattern in _GROUP_OF if re.search(pattern, name)), "surface")


def grouped(scenario: Scenario, names: Iterable[str], required: Iterable[str]) -> dict[str, list[str]]:
    """Measures as they are listed: the required ones in their order, the focus, then group by group."""
    names, first = list(names), list(dict.fromkeys(required))
    if scenario.focus in names and scenario.focus not in first:
        first.append(scenario.focus)
    found = {"": first}
    for group in GROUPS:
        members = [name for name in names if name not in first and group_of(name) == group]
        if members:
            found[group] = members
    return found


def forms(
    scenario: Scenario,
    values: Mapping[str, float],
    names: Sequence[str],
    typed: Mapping[str, Held] = MappingProxyType({}),
) -> dict[str, Form]:
    """The form of each measure of a group: one for all that are of the same quantity.

    ``typed``: measures of the group with limits; the others of their quantity take over the unit.
    """
    measures = scenario.measures
    given = {_kind(measures[name].dimension, name): name for name, shown in typed.items() if shown.unit}
    kinds: dict[str, list[str]] = {}
    for name in names:
        if name in values:
            kinds.setdefault(_kind(measures[name].dimension, name), []).append(name)
    found: dict[str, Form] = {}
    for kind, members in kinds.items():
        unit = _typed(scenario, given[kind], measures[given[kind]].dimension) if kind in given else None
        shared = form(measures[members[0]].dimension, [values[other] for other in members], unit)
        found |= dict.fromkeys(members, shared)
    return found


def _kind(dimension: str, name: str) -> str:
    """What shares unit and decimals: numbers of one dimension, those without a unit each alone.

    An error of micrometres and the length of a path are both lengths, but a common number of decimals would show the error
    as 0: small lengths and angles have a form of their own.
    """
    return name if dimension == "dimensionless" else dimension


def titled(name: str) -> str:
    """An identifier in words: ``surface_error_max`` is "Surface error, max"."""
    words = name.split("_")
    tail: list[str] = []
    while len(words) > 1 and words[-1] in ("min", "max", "mean", "rms", "peak", "x", "y", "z", "low", "high"):
        tail.insert(0, words.pop())
    said = " ".join(words)
    return ", ".join([said[:1].upper() + said[1:], *tail])
