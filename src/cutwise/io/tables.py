"""Tables as CSV files: comma separated, decimal points, each column title with its unit (``w [mm], height [mm]``)."""

import math
import re
from collections.abc import Sequence
from pathlib import Path

from cutwise.io.files import as_text, read_bytes
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.faults import Path as Key
from cutwise.spec.tables import Column, example_title, find, length_fault, table_faults

_MOST_FAULTS = 20
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+")

Cell = tuple[str, int]  # text, and the column of the line where it begins, from 1


def read_table(path: Path, shown: str, key: Key, over: Sequence[Column], ordinate: Column) -> dict[str, list[float]]:
    """The columns of a CSV file that a table of ``ordinate`` over one of ``over`` needs, as written.

    Lines that begin with # and empty lines are passed over, other columns too.

    Raises
    ------
    ScenarioFault
        Everything wrong with the file: separators, titles, units, holes, texts, rows out of order.
    """
    lines = [
        (number, line)
        for number, line in enumerate(as_text(read_bytes(path, shown), shown).splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    example = f'"{example_title(over[0])}, {example_title(ordinate)}"'
    if not lines:
        raise ScenarioFault([Fault(key, f"is empty; it needs a title line such as {example}", file=shown)])
    wrong = wrong_separator(lines, example)
    if wrong is not None:
        raise ScenarioFault([Fault(key, wrong, lines[0][0], 1, shown)])
    sheet = _Sheet(shown, key, lines[0], over, ordinate)
    for number, line in lines[1:]:
        sheet.add(number, line)
    faults = sheet.all_faults(over, ordinate)
    if faults:
        more = len(faults) - _MOST_FAULTS
        rest = [Fault(key, f"and {more} more faults in this file", lines[-1][0], 1, shown)] if more > 0 else []
        raise ScenarioFault([*faults[:_MOST_FAULTS], *rest])
    return sheet.columns


class _Sheet:
    """The wanted columns of a CSV file, row by row, and what is wrong with them."""

    def __init__(
        self, shown: str, key: Key, title_line: tuple[int, str], over: Sequence[Column], ordinate: Column
    ) -> None:
        self.shown, self.key, self.title_line = shown, key, title_line[0]
        self.header = cells_of(title_line[1])
        self.titles = [text for text, _ in self.header]
        named = [find(self.titles, wanted) for wanted in (over, (ordinate,))]
        self.complete = None not in named
        self.columns: dict[str, list[float]] = {found[0]: [] for found in named if found is not None}
        self.places: dict[str, list[tuple[int, int]]] = {title: [] for title in self.columns}
        self.faults: list[Fault] = []
        for place, (title, column) in enumerate(self.header):
            if title in self.titles[:place]:
                self._fault(f"column {title} is there twice", self.title_line, column)

    def _fault(self, message: str, line: int, column: int) -> None:
        self.faults.append(Fault(self.key, message, line, column, self.shown))

    def add(self, number: int, line: str) -> None:
        """One row into the columns, if all of it can be read."""
        cells = cells_of(line)
        if len(cells) > len(self.titles):
            hint = "; decimal commas? write decimal points" if len(cells) == 2 * len(self.titles) else ""
            self._fault(f"{len(cells)} values for {len(self.titles)} columns{hint}", number, 1)
            return
        row: dict[str, tuple[float, int]] = {}
        for place, title in enumerate(self.titles):
            if title not in self.columns:
                continue
            text, column = cells[place] if place < len(cells) else ("", len(line.rstrip()) + 1)
            value = number_of(text)
            if value is None:
                what = f'"{text}" is not a number' if text else "a hole"
                self._fault(f"{what} in column {title}; every row needs a value", number, column)
            else:
                row[title] = (value, column)
        if len(row) == len(self.columns):
            for title, (value, column) in row.items():
                self.columns[title].append(value)
                self.places[title].append((number, column))

    def all_faults(self, over: Sequence[Column], ordinate: Column) -> list[Fault]:
        """Those of the cells and those of the table as a whole, in the order of the lines."""
        columns: dict[str, list[float]] = self.columns if self.complete else {title: [] for title in self.titles}
        for title, row, message in table_faults(columns, over, ordinate):
            if title is None:
                self._fault(message, self.title_line, 1)
            elif row is None:
                self._fault(message, self.title_line, self.header[self.titles.index(title)][1])
            else:
                self._fault(message, *self.places[title][row])
        rows = length_fault(self.columns) if not self.faults else None
        if rows is not None:
            self._fault(rows, self.title_line, 1)
        return sorted(self.faults, key=lambda fault: (fault.line or 0, fault.column or 0))


def number_of(text: str) -> float | None:
    """The finite number of a cell."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in text else None


def cells_of(line: str) -> list[Cell]:
    """The cells of a line, each with its place."""
    cells, start = [], 0
    for part in line.split(","):
        text = part.strip()
        cells.append((text.strip('"').strip(), start + len(part) - len(part.lstrip()) + 1))
        start += len(part) + 1
    return cells


def wrong_separator(lines: list[tuple[int, str]], example: str) -> str | None:
    """What to say about semicolons and tabs in place of commas, as spreadsheets of some countries write them."""
    for separator, name in ((";", "semicolons"), ("\t", "tabs")):
        if separator in lines[0][1]:
            cells = [cell.strip() for _, line in lines[1:] for cell in line.split(separator)]
            decimal = any(_DECIMAL_COMMA.fullmatch(cell) for cell in cells)
            also = " and write decimal points in place of decimal commas" if decimal else ""
            return f"columns are separated by {name}; separate them by commas{also}, for example {example}"
    return None
