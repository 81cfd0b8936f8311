"""Draws of what is not known: from a table of given ones, or from distributions as a study has them."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cutwise import units
from cutwise.io.files import as_text, read_bytes
from cutwise.io.revision import Value
from cutwise.io.tables import cells_of, number_of, wrong_separator
from cutwise.io.tree import from_data
from cutwise.spec import fields
from cutwise.spec.correct import Correction
from cutwise.spec.faults import Fault, ScenarioFault, dotted, split_dotted
from cutwise.spec.scenario import Scenario
from cutwise.spec.tables import titled
from cutwise.study.many.definition import SOBOL, Random, Study, columns
from cutwise.study.many.draws import NETS, next_size
from cutwise.study.many.levers import Faults, levers_of

FITTED = 9
"""Draws whose mean error a shift is made for; the residual is judged by others."""

_KEY = ("correct", "draws")
_VARY = ("correct", "vary")

Draw = Mapping[str, Value]


def draws_of(scenario: Scenario, said: Correction, fitted: int = FITTED) -> tuple[list[Draw], list[Draw]]:
    """Draws that a correction is made for, and those that it is judged by: no draw is among both.

    Of a table the last ``fitted`` rows are fitted. Without a table and without anything that varies there are none.

    Raises
    ------
    ScenarioFault
        The table or the distributions have faults.
    """
    if isinstance(said.draws, str):
        if said.vary:
            raise ScenarioFault([Fault(_VARY, "is not used: correct.draws names a table of draws")])
        rows = read_draws(scenario, said.draws)
        if len(rows) <= fitted:
            raise ScenarioFault([Fault(_KEY, f"has {len(rows)} rows; the last {fitted} are fitted, the others judge the "
                                       "correction: give more")])  # fmt: skip
        return rows[-fitted:] if fitted else [], rows[: len(rows) - fitted]
    random = random_of(scenario, said.vary, _VARY)
    if not random:
        return [], []
    judging = drawn_of(scenario, random, said.seed, said.draws)
    return (drawn_of(scenario, random, said.seed + 1, fitted) if fitted else []), judging


def random_of(scenario: Scenario, vary: Mapping[str, Any], key: tuple[str, str]) -> dict[str, Random]:
    """What is said to vary, by the key of its section.

    Raises
    ------
    ScenarioFault
        A key or a distribution that is none; a list of values, which are no draws.
    """
    if not vary:
        return {}
    faults = Faults()
    tree = from_data({"vary": dict(vary)}, scenario.name)
    levers = levers_of(tree, scenario, Path(), faults)
    found = [Fault((*key[:-1], *fault.path), fault.message) for fault in faults.found]
    found += [
        Fault((*key, one), "is a list of values; draws need a distribution, for example {normal: [1, 0.1]}")
        for one in levers.design
    ]
    found += [
        Fault((*key, one), "is drawn as a curve or between two others, which corrections and comparisons do not do yet")
        for one in (*levers.between, *levers.curves)
    ]
    if found:
        raise ScenarioFault(found)
    return levers.random


def drawn_of(scenario: Scenario, random: Mapping[str, Random], seed: int, count: int) -> list[Draw]:
    """The first draws of a Sobol study with this seed."""
    study = Study("draws", scenario, None, {}, random, SOBOL, next_size(count, NETS), seed, (), None, None)
    drawn = columns(study, 0, count)
    return [dict(zip(drawn, row, strict=True)) for row in zip(*drawn.values(), strict=True)]


def read_draws(scenario: Scenario, name: str) -> list[Draw]:
    """Rows of a CSV file with a column for each key, its unit in the title: ``machine.x.J [kg m^2]``; in SI.

    Raises
    ------
    ScenarioFault
        Everything that is wrong with the file, at its line.
    """
    lines = [
        (number, line)
        for number, line in enumerate(as_text(read_bytes(Path(name), name), name).splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    example = '"machine.x.J [kg m^2], material.K_tc [N/mm^2]"'
    if not lines:
        raise ScenarioFault([Fault(_KEY, f"is empty; it needs a title line such as {example}", file=name)])
    wrong = wrong_separator(lines, example)
    if wrong is not None:
        raise ScenarioFault([Fault(_KEY, wrong, lines[0][0], 1, name)])
    faults: list[Fault] = []
    titles = [_title(scenario, text, column, lines[0][0], name, faults) for text, column in cells_of(lines[0][1])]
    rows: list[Draw] = []
    for number, line in lines[1:]:
        cells = cells_of(line)
        if len(cells) != len(titles):
            faults.append(Fault(_KEY, f"{len(cells)} values for {len(titles)} columns", number, 1, name))
            continue
        row: dict[str, Value] = {}
        for (text, column), title in zip(cells, titles, strict=True):
            value = number_of(text)
            if value is None:
                faults.append(Fault(_KEY, f'"{text}" is not a number', number, column, name))
            elif title is not None:
                row[title[0]] = units.converted(value, title[1], title[2])
        rows.append(row)
    if faults:
        raise ScenarioFault(faults)
    return rows


def _title(
    scenario: Scenario, text: str, column: int, line: int, name: str, faults: list[Fault]
) -> tuple[str, str, str] | None:
    """Key, unit and dimension of a column."""
    from difflib import get_close_matches

    key, unit = titled(text)
    info = fields.field_at(type(scenario), split_dotted(key))
    dimension = fields.dimension(info) if info is not None else None
    if dimension is None:
        known = [dotted(path) for path, one in fields.keys(type(scenario)) if fields.dimension(one)]
        near = get_close_matches(key, known, n=1)
        hint = f"; did you mean {near[0]}?" if near else ""
        faults.append(Fault(_KEY, f"{key} is no quantity of this scenario{hint}", line, column, name))
        return None
    try:
        units.converted(1.0, unit or "", dimension)
    except units.UnitFault as why:
        faults.append(Fault(_KEY, f"{key}: {why}", line, column, name))
        return None
    return key, unit or "", dimension


def share_80(values: Sequence[float]) -> float:
    """The 80 % quantile of values, linear between them: what four of five stay below.

    >>> share_80([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    5.0
    """
    return float(np.quantile(np.asarray(values), 0.8))
