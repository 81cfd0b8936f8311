"""Units at the door: text with a unit becomes a bare SI number here, and SI numbers become text again here.

All unit factors of the program live in this module. Below the specifications everything is SI and rad/s.
"""

import math
import re
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pint


@dataclass(frozen=True, slots=True)
class Dimension:
    """A kind of quantity, its SI unit, the unit people like to read, and an example of how to write one."""

    name: str
    si: str
    display: str
    example: str
    hint: str = ""


_ALL = (
    Dimension("length", "m", "mm", "2 mm"),
    Dimension("small_length", "m", "µm", "50 µm"),
    Dimension("area", "m**2", "mm**2", "15.4 mm^2"),
    Dimension("volume", "m**3", "mm**3", "120 mm^3"),
    Dimension("removal_rate", "m**3/s", "cm**3/min", "20 cm^3/min"),
    Dimension("speed", "m/s", "mm/s", "80 mm/s"),
    Dimension("acceleration", "m/s**2", "mm/s**2", "2000 mm/s^2"),
    Dimension("jerk", "m/s**3", "mm/s**3", "50000 mm/s^3"),
    Dimension("feed_per_revolution", "m", "mm", "0.1 mm/rev", "a plain length is taken per turn"),
    Dimension("angular_acceleration", "rad/s**2", "deg/s**2", "260 deg/s^2"),
    Dimension("angular_speed", "rad/s", "rpm", "40000 rpm", "write rpm, 1/min or rad/s; Hz is for frequencies"),
    Dimension("angle", "rad", "deg", "20 deg"),
    Dimension("small_angle", "rad", "µrad", "15 urad"),
    Dimension("frequency", "Hz", "Hz", "2 Hz"),
    Dimension("spatial_frequency", "1/m", "1/m", "16 1/m"),
    Dimension("time", "s", "s", "0.2 s"),
    Dimension("mass", "kg", "kg", "0.6 kg"),
    Dimension("density", "kg/m**3", "kg/m**3", "7850 kg/m^3"),
    Dimension("inertia", "kg*m**2", "kg*m**2", "4.1e-3 kg m^2"),
    Dimension("force", "N", "N", "7.7 N"),
    Dimension("force_rate", "N/s", "N/s", "20 N/s"),
    Dimension("moment", "N*m", "N*m", "1.2 N m"),
    Dimension("power", "W", "W", "340 W"),
    Dimension("pressure", "Pa", "bar", "5 bar", "gauge pressure"),
    Dimension("stress", "Pa", "N/mm**2", "2000 N/mm^2"),
    Dimension("edge_force", "N/m", "N/mm", "2.2 N/mm"),
    Dimension("stiffness", "N/m", "N/µm", "200 N/um"),
    Dimension("angular_stiffness", "N*m/rad", "N*m/rad", "3.8e6 N m/rad"),
    Dimension("damping", "N*s/m", "N*s/m", "50 N s/m"),
    Dimension("angular_damping", "N*m*s/rad", "N*m*s/rad", "0.02 N m s/rad"),
    Dimension("voltage", "V", "V", "10 V"),
    Dimension("current", "A", "A", "3 A"),
    Dimension("current_gain", "A/V", "A/V", "6.5 A/V"),
    Dimension("torque_constant", "N*m/A", "N*m/A", "0.48 N m/A"),
    Dimension("transmission", "m/rad", "mm/rad", "1.5915 mm/rad"),
    Dimension("proportional_gain", "V/m", "V/mm", "70 V/mm"),
    Dimension("integral_gain", "V/(m*s)", "V/(mm*s)", "500 V/(mm s)"),
    Dimension("derivative_gain", "V*s/m", "V*s/mm", "0.3 V s/mm"),
    Dimension("acceleration_gain", "V*s**2/m", "V*s**2/mm", "0.0016 V s^2/mm"),
    Dimension("compliance", "m/N", "µm/N", "0.7 um/N"),
    Dimension("accelerance", "m/(s**2*N)", "m/(s**2*N)", "3 m/s^2/N"),
    Dimension("angular_compliance", "rad/(N*m)", "µrad/(N*m)", "0.02 urad/(N m)"),
    Dimension("elasticity", "Pa", "kN/mm**2", "210 kN/mm^2"),
    Dimension("energy", "J", "J", "2.5 J"),
    Dimension("money", "EUR", "EUR", "60 EUR"),
    Dimension("money_rate", "EUR/s", "EUR/h", "60 EUR/h"),
    Dimension("dimensionless", "", "", "0.3"),
)
DIMENSIONS = {dimension.name: dimension for dimension in _ALL}

_LARGEST = 1e60  # SI; squares and products of such values, and of their inverses, are still numbers
_QUANTITY = re.compile(r"\s*([+-]?(?:\d[\d_]*\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL)


class UnitFault(ValueError):
    """A text that is not a quantity of the expected dimension; the message says what would be."""


@lru_cache(maxsize=1)
def registry() -> "pint.UnitRegistry[float]":
    """The one unit registry of the program (built at the first use: it takes a tenth of a second)."""
    import pint

    found: pint.UnitRegistry[float]
    try:
        found = pint.UnitRegistry(cache_folder=":auto:")
    except OSError:  # no folder to write the cache to
        found = pint.UnitRegistry()
    found.define("EUR = [money] = EUR = euro")
    return found


_SPELLINGS = (
    (r"\^", "**"),
    ("·", "*"),
    ("[µμ]", "u"),
    ("°", "deg"),
    ("²", "**2"),
    ("³", "**3"),
    (r"^\s*/", "1/"),
    (r"\bU/min\b", "1/min"),
    (r"\bN(?=m{1,2}\b)", "N*"),  # Nm and Nmm, which pint does not split
    (r"\brev\b", "revolution"),
    (r"(?<=[A-Za-z0-9)])\s+(?=[A-Za-z(])", "*"),
)


def _spelled(unit: str) -> str:
    """Unit text as pint reads it: caret powers, and a blank between units as a product."""
    for pattern, spelling in _SPELLINGS:
        unit = re.sub(pattern, spelling, unit)
    return unit


@lru_cache(maxsize=512)
def factor(unit: str, dimension: str) -> float:
    """How many SI units of a dimension one ``unit`` is.

    Raises
    ------
    UnitFault
        The text is no unit, or one of another dimension.
    """
    wanted = DIMENSIONS[dimension]
    expected = f'for example "{wanted.example}"' + (f" ({wanted.hint})" if wanted.hint else "")
    pint_registry = registry()
    if dimension == "feed_per_revolution":
        unit = re.sub(r"\s*/\s*(rev|revolution|turn)\s*$", "", unit)
    try:
        parsed = pint_registry.parse_units(_spelled(unit))
    except Exception:
        raise UnitFault(f'"{unit}" is not a unit; write it as text with a unit, {expected}') from None
    if dimension == "angular_speed":
        return _angular_speed_factor(parsed, unit, expected)
    angle_free = {"rad", "deg"} & set(re.findall(r"[a-z]+", wanted.si + wanted.display))
    if dimension == "angle" and parsed.dimensionless and not _names_angle(parsed):
        raise UnitFault(f'"{unit}" is not an angle, expected {expected}')
    if dimension != "angle" and _names_angle(parsed) and not angle_free:
        raise UnitFault(f'"{unit}" is not a unit of {wanted.name.replace("_", " ")}, expected {expected}')
    if not parsed.is_compatible_with(wanted.si or "dimensionless"):
        raise UnitFault(f'"{unit}" is not a unit of {wanted.name.replace("_", " ")}, expected {expected}')
    return float(pint_registry.Quantity(1.0, parsed).to(wanted.si or "dimensionless").magnitude)


def fits(unit: str, dimension: str) -> bool:
    """Whether a text is a unit of a dimension."""
    try:
        factor(unit, dimension)
    except UnitFault:
        return False
    return True


def _names_angle(unit: "pint.Unit") -> bool:
    return any(name in ("radian", "degree", "revolution", "turn", "arcminute", "arcsecond", "milliradian",
                        "microradian", "revolutions_per_minute", "revolutions_per_second")
               for name in unit._units)  # fmt: skip


def _angular_speed_factor(parsed: "pint.Unit", unit: str, expected: str) -> float:
    """Spindle speed: 1/min and 1/s count turns here, rad/s stays; hertz is refused, being a frequency."""
    names = set(parsed._units)
    if "hertz" in names or not parsed.is_compatible_with("1/s"):
        raise UnitFault(f'"{unit}" is not a unit of rotational speed, expected {expected}')
    value = float(registry().Quantity(1.0, parsed).to("rad/s").magnitude)
    turns_only = not _names_angle(parsed)
    return value * math.tau if turns_only else value


def parse(text: object, dimension: str) -> float:
    """SI value of a text such as ``"80 mm/s"``.

    Raises
    ------
    UnitFault
        No text, no number, no unit, or a unit of another dimension.
    """
    wanted = DIMENSIONS[dimension]
    if isinstance(text, bool) or not isinstance(text, str | int | float):
        raise UnitFault(f'expected a quantity, for example "{wanted.example}"')
    if dimension == "dimensionless":
        return _plain_number(text)
    if not isinstance(text, str):
        raise UnitFault(f'{text} has no unit; write it as text with a unit, for example "{_with_unit(text, wanted)}"')
    match = _QUANTITY.fullmatch(text.replace("\u2212", "-"))
    if match is None or match.group(2).startswith(","):
        pointed = re.sub(r"(?<=\d),(?=\d)", ".", text)
        if pointed != text and _QUANTITY.fullmatch(pointed):
            raise UnitFault(f'"{text}" has a decimal comma; write it with a decimal point, for example "{pointed}"')
        raise UnitFault(f'"{text}" is not a number with a unit, expected for example "{wanted.example}"')
    number, unit = match.groups()
    if not unit:
        raise UnitFault(f'{text} has no unit; write it as text with a unit, for example "{_with_unit(number, wanted)}"')
    return _in_scale(converted(float(number.replace("_", "")), unit, dimension), text)


def quantity(text: str) -> Any:
    """A text such as ``"60 EUR/h"`` as a quantity of pint in SI base units, whatever it is a quantity of.

    Raises
    ------
    UnitFault
        No number, or no unit.
    """
    match = _QUANTITY.fullmatch(text)
    try:
        assert match is not None
        return (
            registry().Quantity(float(match.group(1)), registry().parse_units(_spelled(match.group(2)))).to_base_units()
        )
    except Exception:
        raise UnitFault(f'"{text}" is not a number with a unit, expected for example "60 EUR/h"') from None


def scatter_factor(unit: str, dimension: str, kind: str) -> float:
    """How many SI units one ``unit`` of a standard error is: of a value, of its reciprocal, or of its logarithm.

    Without a unit it is SI.

    Raises
    ------
    UnitFault
        The text is no unit of that.
    """
    if not unit or kind == "log":
        return 1.0
    if kind == "value":
        return factor(unit, dimension)
    wanted, pint_registry = DIMENSIONS[dimension], registry()
    try:
        parsed = pint_registry.parse_units(_spelled(unit))
        si = 1.0 / pint_registry.Quantity(1.0, pint_registry.parse_units(_spelled(wanted.si) or "dimensionless"))
        return float(pint_registry.Quantity(1.0, parsed).to(si.units).magnitude)
    except Exception:
        expected = f"1/({wanted.si})" if wanted.si else "none"
        raise UnitFault(
            f'"{unit}" is not a unit of 1/{wanted.name.replace("_", " ")}, expected for example {expected}'
        ) from None


def _in_scale(value: float, text: object) -> float:
    if value and not 1.0 / _LARGEST <= abs(value) <= _LARGEST:
        size = "large" if abs(value) > 1.0 else "small"
        raise UnitFault(f"{text} is out of scale: too {size} to be calculated with")
    return value


def converted(value: float, unit: str, dimension: str) -> float:
    """SI value of a number in a unit; raises UnitFault as :func:`factor` does."""
    scale = factor(unit, dimension)
    return value * scale if scale >= 1.0 else value / (1.0 / scale)  # 50 µm is 5e-05 then, not 4.9999999999999996e-05


def _plain_number(text: str | int | float) -> float:
    try:
        value = float(text)
    except ValueError:
        percent = isinstance(text, str) and re.fullmatch(r"\s*([+-]?[\d.]+)\s*%\s*", text)
        if percent:
            return float(percent.group(1)) / 100.0
        raise UnitFault(f'"{text}" is not a plain number; this one has no unit') from None
    if not math.isfinite(value):
        raise UnitFault(f"{text} is not a finite number")
    return _in_scale(value, text)


def _with_unit(number: object, dimension: Dimension) -> str:
    unit = dimension.example.partition(" ")[2]
    return f"{number} {unit}"


def text(value: float, dimension: str) -> str:
    """The value in SI as text that :func:`parse` gives back to the last bit."""
    unit = DIMENSIONS[dimension].si
    return f"{float(value)!r} {unit}".strip()


_LONG = 1e6  # numbers below are written without an exponent


def show(value: float, dimension: str, digits: int = 5) -> str:
    """The value as people read it, in the display unit."""
    number, unit = displayed(value, dimension)
    text = f"{number:.{digits}g}"
    if "e+" in text and abs(number) < _LONG:
        text = f"{float(text):.0f}"
    return f"{text}{'' if unit == '°' else ' '}{unit}".strip()


def displayed(value: float, dimension: str) -> tuple[float, str]:
    """Number and printable unit in the display unit of the dimension."""
    wanted = DIMENSIONS[dimension]
    scale = 1.0 if wanted.display == wanted.si else factor(wanted.display, dimension)
    return value / scale, pretty(wanted.display)


def pretty(unit: str) -> str:
    """Unit text for print: superscripts and middle dots."""
    return (
        unit.replace("**2", "²").replace("**3", "³").replace("*", "·").replace("revolution", "rev").replace("deg", "°")
    )
