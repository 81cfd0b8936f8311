"""Tables as CSV files: comma separated, decimal points, each column title with its unit (``w [mm], height [mm]``)."""

import math
import re
from collections.abc import Sequence
from pathlib import Path

from cutwise.io.files import as_text, read_bytes
from cutwise.spec import faults as spec_faults
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.tables import Column, example_title, find, table_faults

_MOST_FAULTS = 20
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+")

Cell = tuple[str, int]  # text, and the column of the line where it begins, from 1


def read_table(
    path: Path, shown: str, key: spec_faults.Path, over: Sequence[Column], ordinate: Column
) -> dict[str, list[float]]:
    """The columns of a CSV file that a table of ``ordinate`` over one of ``over`` needs, as written.

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
    found: list[Fault] = []
    if not lines:
        raise ScenarioFault(
            [Fault(key, f"is empty; it needs a title line such as {_example(over, ordinate)}", file=shown)]
        )
    _check_separators(lines, shown, key, over, ordinate)
    header = _cells(lines[0][1])
    titles = [text for text, _ in header]
    for place, title in enumerate(titles):
        if title in titles[:place]:
            found.append(Fault(key, f"column {title} is there twice", lines[0][0], header[place][1], shown))
    wanted = [named[0] for columns in (over, (ordinate,)) if (named := find(titles, columns)) is not None]
    columns: dict[str, list[float]] = {title: [] for title in wanted or titles}
    places: dict[str, list[tuple[int, int]]] = {title: [] for title in columns}
    for number, line in lines[1:]:
        _read_row(_cells(line), titles, columns, places, found, key, number, shown)
    for fault in table_faults(columns if len(wanted) == 2 else dict.fromkeys(titles, ()), over, ordinate):
        line_number, column = lines[0][0], 1
        if fault.column is not None:
            line_number, column = (
                (lines[0][0], header[titles.index(fault.column)][1])
                if fault.row is None
                else places[fault.column][fault.row]
            )
        if fault.column is not None or len(wanted) == 2 or "needs a column" in fault.message:
            found.append(Fault(key, fault.message, line_number, column, shown))
    if found:
        found.sort(key=lambda fault: (fault.line or 0, fault.column or 0))
        more = len(found) - _MOST_FAULTS
        rest = [Fault(key, f"and {more} more faults in this file", file=shown)] if more > 0 else []
        raise ScenarioFault([*found[:_MOST_FAULTS], *rest])
    return columns


def _read_row(
    cells: list[Cell],
    titles: list[str],
    columns: dict[str, list[float]],
    places: dict[str, list[tuple[int, int]]],
    found: list[Fault],
    key: spec_faults.Path,
    number: int,
    shown: str,
) -> None:
    """One row into the columns, if all of it can be read."""
    if len(cells) > len(titles) or (len(cells) < len(titles) and len(cells) < 2):
        hint = "; decimal commas? write decimal points" if len(cells) == 2 * len(titles) else ""
        message = f"{len(cells)} values for {len(titles)} columns{hint}"
        found.append(Fault(key, message, number, 1, shown))
        return
    row: dict[str, tuple[float, int]] = {}
    for place, title in enumerate(titles):
        if title not in columns:
            continue
        text, column = cells[place] if place < len(cells) else ("", cells[-1][1] + len(cells[-1][0]))
        value = _number(text)
        if value is None:
            message = f'"{text}" is not a number' if text else "a hole"
            found.append(Fault(key, f"{message} in column {title}; every row needs a value", number, column, shown))
        else:
            row[title] = (value, column)
    if len(row) == len(columns):
        for title, (value, column) in row.items():
            columns[title].append(value)
            places[title].append((number, column))


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) and "_" not in text else None


def _cells(line: str) -> list[Cell]:
    cells, start = [], 0
    for part in line.split(","):
        text = part.strip()
        cells.append((text.strip('"').strip(), start + len(part) - len(part.lstrip()) + 1))
        start += len(part) + 1
    return cells


def _check_separators(
    lines: list[tuple[int, str]], shown: str, key: spec_faults.Path, over: Sequence[Column], ordinate: Column
) -> None:
    """Semicolons and tabs in place of commas, as spreadsheets of some countries write them."""
    number, title_line = lines[0]
    for separator, name in ((";", "semicolons"), ("\t", "tabs")):
        if separator in title_line:
            decimals = any(
                _DECIMAL_COMMA.fullmatch(cell.strip()) for _, line in lines[1:] for cell in line.split(separator)
            )
            message = f"columns are separated by {name}; separate them by commas"
            message += ", and write decimal points in place of decimal commas" if decimals else ""
            message += f", for example {_example(over, ordinate)}"
            raise ScenarioFault([Fault(key, message, number, title_line.index(separator) + 1, shown)])


def _example(over: Sequence[Column], ordinate: Column) -> str:
    return f'"{example_title(over[0])}, {example_title(ordinate)}"'
