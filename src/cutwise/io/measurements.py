"""Measured data as CSV: titles with units, every fault with its line, and what identifies the file."""

import hashlib
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise import units
from cutwise.io.files import as_text, read_bytes
from cutwise.io.tables import Cell, cells_of, number_of, wrong_separator
from cutwise.spec.calibration import is_date
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.tables import titled

FloatArray = npt.NDArray[np.float64]
_DATE = re.compile(r"#\s*date\s*:\s*(\S+)\s*", re.IGNORECASE)
_MOST_FAULTS = 20
WORDS = "words"
_LARGEST = {  # SI, by dimension: beyond it no machine of cutwise measures
    "force": (1e6, "is more than a meganewton; is the unit right?"),
    "moment": (1e6, "is more than a meganewton metre; is the unit right?"),
}
ONE = ("-", "1")  # how people write that a number has no unit; or nothing between the brackets


class Channel(NamedTuple):
    """A column of a measurement."""

    name: str
    dimension: str  # "" for a column of numbers without a unit, WORDS for one of words
    needed: bool = True
    largest: float = math.inf  # SI; beyond it the unit is probably wrong
    hint: str = ""  # what to say then
    unit: str = ""  # an example of one; left out: that of the dimension
    other: str = ""  # another dimension that the unit may have; the column is then in `in_other`


@dataclass(frozen=True)
class Measurement:
    """What a file holds."""

    file: str
    sha256: str
    date: str | None
    columns: dict[str, FloatArray]  # SI
    units: dict[str, str]  # as written
    lines: tuple[int, ...]  # line of each row
    unused: tuple[str, ...]  # titles that were passed over
    labels: dict[str, tuple[str, ...]] = field(default_factory=dict)  # columns of words
    in_other: frozenset[str] = frozenset()  # columns whose unit has the other dimension of their channel

    @property
    def rows(self) -> int:
        """How many there are."""
        return len(self.lines)

    def matrix(self, names: Sequence[str]) -> FloatArray:
        """Columns side by side, shape (rows, len(names))."""
        return np.column_stack([self.columns[name] for name in names])

    def fault(self, message: str, row: int | None = None) -> Fault:
        """A fault of the file, or of one of its rows (from 0)."""
        return Fault((), message, None if row is None else self.lines[row], None, self.file)


def read_measurement(
    path: Path, channels: Sequence[Channel], least_rows: int, too_few: Callable[[int], str] | None = None
) -> Measurement:
    """The columns of a CSV file in SI.

    Parameters
    ----------
    path : Path
        The file.
    channels : sequence of Channel
        Columns that are looked for; others are passed over and named.
    least_rows : int
        Fewer rows are a fault.
    too_few : callable, optional
        Says it, given the number of rows.

    Raises
    ------
    ScenarioFault
        Everything wrong: titles, units, texts and empty cells, numbers out of scale, too few rows.
    """
    shown = str(path)
    content = read_bytes(path, shown)
    text = as_text(content, shown)
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and line.lstrip()[0] != "#"]
    example = ", ".join(example_title(channel) for channel in channels if channel.needed)
    if not lines:
        such = f' such as "{example}"' if example else ""
        raise ScenarioFault([Fault((), f"is empty; it needs a title line{such}", file=shown)])
    wrong = wrong_separator(lines, f'"{example}"')
    if wrong is not None:
        raise ScenarioFault([Fault((), wrong, lines[0][0], 1, shown)])
    sheet = _Sheet(shown, lines[0], channels)
    for number, line in lines[1:]:
        sheet.row(number, line)
    date = next((m.group(1) for line in text.splitlines() if (m := _DATE.fullmatch(line.strip()))), None)
    if date is not None and not is_date(date):
        sheet.faults.append(Fault((), f'"{date}" is not a date; write for example # date: 2026-03-01', file=shown))
    if len(lines) - 1 < least_rows:
        said = f"has {len(lines) - 1} rows; at least {least_rows} are needed"
        sheet.faults.append(Fault((), too_few(len(lines) - 1) if too_few is not None else said, file=shown))
    if sheet.faults:
        raise ScenarioFault(_first(sheet.faults, shown))
    columns = {name: np.array(values, dtype=float) for name, values in sheet.values.items()}
    return Measurement(
        shown, hashlib.sha256(content).hexdigest(), date, columns, sheet.units, tuple(sheet.lines), tuple(sheet.unused),
        {name: tuple(words) for name, words in sheet.words.items()}, frozenset(sheet.in_other),
    )  # fmt: skip


def titles_of(path: Path) -> list[tuple[str, str | None]]:
    """Names and units of the columns of a file; none if it is empty."""
    text = as_text(read_bytes(path, str(path)), str(path))
    first = next((line for line in text.splitlines() if line.strip() and line.lstrip()[0] != "#"), "")
    return [titled(cell) for cell, _ in cells_of(first) if cell]


def example_title(channel: Channel) -> str:
    """How a title may be written: ``force_x [N]``."""
    if channel.dimension in ("", WORDS, "dimensionless"):
        return channel.name
    return f"{channel.name} [{_unit(channel)}]"


def _unit(channel: Channel) -> str:
    return channel.unit or units.DIMENSIONS[channel.dimension].example.partition(" ")[2]


def template(channels: Sequence[Channel], describes: str) -> str:
    """An empty file with the titles of a kind."""
    needed = ", ".join(example_title(channel) for channel in channels if channel.needed)
    optional = [example_title(channel) for channel in channels if not channel.needed]
    also = f"# may be added: {', '.join(optional)}\n" if optional else ""
    return (
        f"# {describes}\n# lines with # are passed over; a line '# date: 2026-03-01' dates the entry\n{also}{needed}\n"
    )


def _first(faults: list[Fault], shown: str) -> list[Fault]:
    faults = sorted(faults, key=lambda fault: (fault.line or 0, fault.column or 0))
    more = len(faults) - _MOST_FAULTS
    if more > 0:
        return [*faults[:_MOST_FAULTS], Fault((), f"and {more} more faults in this file", file=shown)]
    return faults


class _Sheet:
    """The wanted columns, row by row, and what is wrong with them."""

    def __init__(self, shown: str, title: tuple[int, str], channels: Sequence[Channel]) -> None:
        self.shown, self.line = shown, title[0]
        self.header = cells_of(title[1])
        self.faults: list[Fault] = []
        self.places: dict[int, tuple[Channel, float]] = {}
        self.units: dict[str, str] = {}
        self.unused: list[str] = []
        self.in_other: set[str] = set()
        self.lines: list[int] = []
        known = {channel.name.casefold(): channel for channel in channels}
        for place, (text, column) in enumerate(self.header):
            name, unit = titled(text)
            channel = known.get(name.casefold())
            if channel is None:
                self.unused.append(text)
            elif any(channel is other for other, _ in self.places.values()):
                self.fault(channel.name, "is there twice", self.line, column)
            else:
                self.places[place] = (channel, self.scale(channel, unit, column))
        there = [channel.name for channel, _ in self.places.values()]
        for channel in channels:
            if channel.needed and channel.name not in there:
                self.fault(channel.name, f"missing; write a column {example_title(channel)}", self.line, 1)
        words = {channel.name for channel, _ in self.places.values() if channel.dimension == WORDS}
        self.values: dict[str, list[float]] = {name: [] for name in there if name not in words}
        self.words: dict[str, list[str]] = {name: [] for name in there if name in words}

    def fault(self, name: str, message: str, line: int, column: int) -> None:
        self.faults.append(Fault((name,) if name else (), message, line, column, self.shown))

    def scale(self, channel: Channel, unit: str | None, column: int) -> float:
        """How many SI units one of the column is."""
        if channel.dimension in ("", WORDS) or (channel.dimension == "dimensionless" and (unit or "-").strip() in ONE):
            return 1.0
        if not unit:
            self.fault(channel.name, f"no unit; write {example_title(channel)}", self.line, column)
            return math.nan
        self.units[channel.name] = unit
        try:
            return units.factor(unit, channel.dimension)
        except units.UnitFault:
            if channel.other and units.fits(unit, channel.other):
                self.in_other.add(channel.name)
                return units.factor(unit, channel.other)
            kind = channel.dimension.replace("_", " ")
            message = f'"{unit}" is not a unit of {kind}; write for example {example_title(channel)}'
            self.fault(channel.name, message, self.line, column)
            return math.nan

    def row(self, number: int, line: str) -> None:
        """One line into the columns."""
        cells = cells_of(line)
        if len(cells) > len(self.header):
            hint = "; decimal commas? write decimal points" if len(cells) == 2 * len(self.header) else ""
            self.fault("", f"{len(cells)} values for {len(self.header)} columns{hint}", number, 1)
            return
        self.lines.append(number)
        for place, (channel, scale) in self.places.items():
            cell = cells[place] if place < len(cells) else ("", len(line.rstrip()) + 1)
            if channel.dimension == WORDS:
                self.words[channel.name].append(cell[0])
                if not cell[0]:
                    self.fault(channel.name, "an empty cell; every row needs a word", number, cell[1])
                continue
            self.values[channel.name].append(self.value(channel, scale, cell, number))

    def value(self, channel: Channel, scale: float, cell: Cell, number: int) -> float:
        """A cell in SI; NaN where it is a fault."""
        found = number_of(cell[0])
        if found is None:
            what = f'"{cell[0]}" is not a number' if cell[0] else "an empty cell"
            self.fault(channel.name, f"{what}; every row needs a number", number, cell[1])
            return math.nan
        found = found * scale if scale >= 1.0 else found / (1.0 / scale)
        largest, hint = min((channel.largest, channel.hint), _LARGEST.get(channel.dimension, (math.inf, "")))
        if abs(found) > largest and channel.name not in self.in_other:
            unit = self.units.get(channel.name, "")
            self.fault(channel.name, f"{cell[0]} {unit} {hint}", number, cell[1])
        return found
