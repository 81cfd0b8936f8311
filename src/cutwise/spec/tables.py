"""Tables in a scenario: columns with units in their names, held by the scenario itself."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import ClassVar, NamedTuple

from pydantic import Field

from cutwise import units
from cutwise.spec.base import Notice, Spec

_HEADER = re.compile(r"\s*([^\[\]]+?(?:(?<=\S)\[\d+\][^\[\]]*?)*)\s*(?:\[\s*([^\[\]]*?)\s*\])?\s*")


class Column(NamedTuple):
    """A column that a table needs or may have."""

    name: str
    dimension: str
    minimum: float = -math.inf


class TableFault(NamedTuple):
    """What is wrong with a table: column title and row (from 0; None: the title, or the table as a whole)."""

    column: str | None
    row: int | None
    message: str


def titled(title: str) -> tuple[str, str | None]:
    """Name and unit of a column title: ``"w [mm]"`` is ``("w", "mm")``; no unit is None."""
    match = _HEADER.fullmatch(title)
    return (match.group(1), match.group(2)) if match else (title.strip(), None)


def find(titles: Sequence[str], wanted: Sequence[Column]) -> tuple[str, Column] | None:
    """The first title that names one of the wanted columns."""
    for title in titles:
        for column in wanted:
            if titled(title)[0].casefold() == column.name.casefold():
                return title, column
    return None


def table_faults(
    columns: Mapping[str, Sequence[float]], over: Sequence[Column], ordinate: Column
) -> Iterator[TableFault]:
    """Everything wrong with the columns of a table of ``ordinate`` over one of ``over``."""
    titles = list(columns)
    found = ", ".join(titles) or "none"
    for wanted in (over, (ordinate,)):
        named = find(titles, wanted)
        if named is None:
            names = " or ".join(f'"{example_title(column)}"' for column in wanted)
            yield TableFault(None, None, f"needs a column {names}; found: {found}")
            continue
        title, column = named
        fault = _unit_fault(title, column)
        if fault:
            yield TableFault(title, None, fault)
        yield from _row_faults(title, columns[title], column, rising=wanted is over, scaled=not fault)


def length_fault(columns: Mapping[str, Sequence[float]]) -> str | None:
    """What is wrong with the number of rows."""
    lengths = sorted({len(rows) for rows in columns.values()})
    if len(lengths) > 1:
        return f"columns have different lengths: {', '.join(map(str, lengths))}"
    if lengths and lengths[0] < 2:
        return f"has {lengths[0]} row{'s' if lengths[0] != 1 else ''}; at least two are needed"
    return None


def _unit_fault(title: str, column: Column) -> str:
    name, unit = titled(title)
    example = f'"{name} [{_unit(column.dimension)}]"'
    if unit is None:
        return f"column {title.strip()} has no unit; write the title with its unit, for example {example}"
    try:
        units.factor(unit, column.dimension)
    except units.UnitFault:
        kind = column.dimension.replace("_", " ")
        return f'column {name}: "{unit}" is not a unit of {kind}; write for example {example}'
    return ""


def _row_faults(
    title: str, rows: Sequence[float], column: Column, *, rising: bool, scaled: bool
) -> Iterator[TableFault]:
    for row, value in enumerate(rows):
        if not math.isfinite(value):
            yield TableFault(title, row, f"{value} is not a finite number")
        elif scaled and value < column.minimum:  # a minimum is 0, whatever the unit
            yield TableFault(title, row, f"{value:g} is impossible; {column.name} must be at least {column.minimum:g}")
        if rising and row and value == rows[row - 1]:
            yield TableFault(title, row, f"{column.name} = {value:g} is repeated; {column.name} must increase")
        elif rising and row and value < rows[row - 1]:
            message = f"{column.name} = {value:g} comes after {rows[row - 1]:g}; sort the rows by {column.name}"
            yield TableFault(title, row, message)


def example_title(column: Column) -> str:
    """How the title of a column may be written: ``w [mm]``."""
    return f"{column.name} [{_unit(column.dimension)}]"


def _unit(dimension: str) -> str:
    return units.DIMENSIONS[dimension].example.partition(" ")[2]


class Table(Spec):
    """A quantity over another, given by points; straight lines between them."""

    over: ClassVar[tuple[Column, ...]]
    ordinate: ClassVar[Column]

    columns: dict[str, tuple[float, ...]] = Field(
        description="columns by their titles with units; a CSV file named by `table` is read into here",
        examples=['{"w [mm]": [0, 50], "height [mm]": [0.8, 1.1]}'],
    )
    file: str | None = Field(
        default=None, description="the file that the columns were read from", examples=["burr.csv"]
    )

    def contradictions(self) -> Iterator[Notice]:
        """Missing columns and units, rows out of order, values out of bounds."""
        for column, row, message in table_faults(self.columns, self.over, self.ordinate):
            path: tuple[str | int, ...] = () if column is None else ("columns", column)
            yield Notice(path if row is None else (*path, row), message)
        wrong = length_fault(self.columns)
        if wrong is not None:
            yield Notice(("columns",), wrong)

    @property
    def variable(self) -> str:
        """Name of the column that the table runs over."""
        return self._column(self.over)[1].name

    def points(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Abscissae and ordinates in SI."""
        return self._si(self.over), self._si((self.ordinate,))

    def _column(self, wanted: Sequence[Column]) -> tuple[str, Column]:
        found = find(list(self.columns), wanted)
        assert found is not None  # checked when the table was made
        return found

    def _si(self, wanted: Sequence[Column]) -> tuple[float, ...]:
        title, column = self._column(wanted)
        unit = titled(title)[1] or ""
        return tuple(units.converted(value, unit, column.dimension) for value in self.columns[title])
