"""Values that were measured, of a table: how an input scatters, as it was seen to."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cutwise import units
from cutwise.io.files import as_text, read_bytes
from cutwise.io.tables import cells_of, number_of, wrong_separator
from cutwise.study.many.distributions import Empirical, empirical

_TITLE = re.compile(r"([^\[\]]*?)\s*(?:\[([^\[\]]*)\])?")
_WEIGHT = "weight"


class NoTable(ValueError):
    """What is wrong with a table, in words; all of it."""


def observed(file: Path, shown: str, dimension: str) -> Empirical:
    """The distribution of the values in a CSV file: one column with its unit, and a column ``weight`` if some count more.

    Parameters
    ----------
    file : Path
        The table.
    shown : str
        How a message names it.
    dimension : str
        Of the values.

    Raises
    ------
    NoTable
        It is none, with everything that is wrong.
    ScenarioFault
        The file cannot be read.
    """
    lines = [
        (number, line)
        for number, line in enumerate(as_text(read_bytes(file, shown), shown).splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if len(lines) < 2:
        raise NoTable(f"{shown} has no column of values")
    separated = wrong_separator(lines, "height [mm],weight")
    if separated:
        raise NoTable(f"{shown}: {separated}")
    wrong = list(_faults(lines))
    if wrong:
        raise NoTable(f"{shown}: {'; '.join(wrong)}")
    titles, *rows = ([text for text, _ in cells_of(line)] for _, line in lines)
    numbers = np.array([[float(text) for text in row] for row in rows])
    names = [_named(title) for title in titles]
    at = next(i for i, (name, _) in enumerate(names) if name != _WEIGHT)
    try:
        values = np.array([units.converted(float(x), names[at][1], dimension) for x in numbers[:, at]])
    except units.UnitFault as why:
        raise NoTable(f"{shown}: {why}") from None
    return empirical(values, numbers[:, 1 - at] if len(names) == 2 else None)


def _named(title: str) -> tuple[str, str]:
    """Name and unit of a column."""
    found = _TITLE.fullmatch(title.strip())
    return (found[1].strip(), (found[2] or "").strip()) if found else (title.strip(), "")


def _faults(lines: list[tuple[int, str]]) -> Iterator[str]:
    """What is wrong with the columns and cells of a table."""
    titles = [text for text, _ in cells_of(lines[0][1])]
    names = [_named(title)[0] for title in titles]
    weighted = names.count(_WEIGHT)
    if len(titles) - weighted != 1 or weighted > 1:
        others = ", ".join(repr(title) for title in titles)
        yield f"expected one column of values with its unit, and at most one named {_WEIGHT}; found {others}"
        return
    weights = []
    for number, line in lines[1:]:
        cells = [text for text, _ in cells_of(line)]
        if len(cells) != len(titles):
            yield f"line {number} has {len(cells)} cells in place of {len(titles)}"
            continue
        for name, text in zip(names, cells, strict=True):
            value = number_of(text)
            if value is None:
                yield f"line {number}: {name} has a cell that is no number"
            elif name == _WEIGHT:
                weights.append(value)
    if weighted and weights and (min(weights) < 0.0 or sum(weights) <= 0.0):
        yield f"{_WEIGHT}: expected numbers of which none is below 0, not all of them 0"
    units_of = [_named(title)[1] for title in titles if _named(title)[0] == _WEIGHT]
    if any(units_of):
        yield f"{_WEIGHT} has no unit"
