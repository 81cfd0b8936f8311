"""What decides: indices or effects of each measure, and of being good, of a study that asks for them."""

from collections.abc import Iterator

import numpy as np

from cutwise.study.many.cases import GOOD
from cutwise.study.many.columns import Table, aligned, pieces
from cutwise.study.many.definition import INDICES, MORRIS, Study, trajectories
from cutwise.study.many.draws import MORRIS as MORRIS_DRAWS
from cutwise.study.many.draws import generator
from cutwise.study.many.statements import Effects, Indices, RowSums, elementary_effects

IS_GOOD = "good"
Columns = dict[str, np.ndarray]


def decides(study: Study, table: Table, done: int) -> dict[str, Indices | Effects]:
    """Indices or effects by measure, of the whole rows among the first ``done`` cases."""
    each = len(study.factors) + (2 if study.method == INDICES else 1)
    rows = done // each
    if study.method not in (INDICES, MORRIS) or study.combinations != 1 or rows < 2:
        return {}
    return _indices(study, table, rows) if study.method == INDICES else _effects(study, table, rows)


def _rows(study: Study, table: Table, each: int) -> Iterator[Columns]:
    """Values of each measure, and of being good, in whole rows; shapes (m, each)."""
    measures = {f"measure {name}": name for name in study.measures}
    judged = ["state"] if study.scenario.asked else []
    for piece in aligned(pieces(table, *measures, *judged), each):
        found = {name: piece[column].reshape(-1, each) for column, name in measures.items()}
        if judged:
            found[IS_GOOD] = (piece["state"] == GOOD).astype(float).reshape(-1, each)
        yield found


def _indices(study: Study, table: Table, rows: int) -> dict[str, Indices | Effects]:
    """Indices, in two looks at the cases: for the mean, and for the sums."""
    d = len(study.factors)
    total: dict[str, float] = {}
    for piece in _rows(study, table, d + 2):
        for name, values in piece.items():  # a case has no such number: no index of it
            sums = float(values[:, :2].sum()) if np.isfinite(values).all() else np.nan
            total[name] = total.get(name, 0.0) + sums
    found = {name: RowSums(rows, d, value / (2 * rows)) for name, value in total.items() if np.isfinite(value)}
    for piece in _rows(study, table, d + 2):
        for name, one in found.items():
            one.add(piece[name])
    return {name: one.indices(study.seed) for name, one in found.items()}


def _effects(study: Study, table: Table, rows: int) -> dict[str, Indices | Effects]:
    """Elementary effects; walks are planned as a whole, so their values are read as a whole, too."""
    inputs = len(study.random)
    _, order, moved = trajectories(inputs, study.draws, study.levels, generator(study.seed, MORRIS_DRAWS))
    there = list(_rows(study, table, inputs + 1))
    walk = np.arange(rows)[:, None]
    found: dict[str, Indices | Effects] = {}
    for name in there[0]:
        values = np.concatenate([piece[name] for piece in there])
        if not np.isfinite(values).all():
            continue
        before, after, step = (np.empty((rows, inputs)) for _ in range(3))
        before[walk, order[:rows]], after[walk, order[:rows]] = values[:, :-1], values[:, 1:]
        step[walk, order[:rows]] = moved[:rows]
        found[name] = elementary_effects(before, after, step)
    return found
