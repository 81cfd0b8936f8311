"""The columns of a study, read part by part: no more than one part is in memory, however many cases there are."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import takewhile
from pathlib import Path

import numpy as np

from cutwise.study.many import folder as at
from cutwise.study.many.definition import Study

Table = Mapping[str, np.ndarray]
"""Columns by name, one number a case; of a folder they are read when they are asked for."""


class Columns(Mapping[str, np.ndarray]):
    """Columns of finished parts that follow one another. ``columns[name]`` is a whole one: 8 bytes a case."""

    def __init__(self, folder: Path, parts: Sequence[tuple[int, int]]) -> None:
        self._folder, self._parts = folder, parts
        self._names: list[str] | None = None

    @property
    def count(self) -> int:
        """Number of cases."""
        return sum(count for _, count in self._parts)

    def __iter__(self) -> Iterator[str]:
        if self._names is None:
            self._names = at.columns_of(at.part_file(self._folder, *self._parts[0])) if self._parts else []
        return iter(self._names)

    def __len__(self) -> int:
        return len(list(iter(self)))

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in list(iter(self)):
            raise KeyError(name)
        found: np.ndarray | None = None
        done = 0
        for piece in self.pieces(name):  # joining parts would take the room twice
            values = piece[name]
            if found is None:
                found = np.empty(self.count, values.dtype)
            found[done : done + len(values)] = values
            done += len(values)
        assert found is not None
        return found

    def pieces(self, *names: str) -> Iterator[dict[str, np.ndarray]]:
        """Some columns, part by part; all columns where none is named."""
        for first, count in self._parts:
            yield at.read_part(at.part_file(self._folder, first, count), names or None)

    def row(self, case: int) -> dict[str, np.ndarray]:
        """All columns of the part that holds a case, cut down to that case."""
        for first, count in self._parts:
            if first <= case < first + count:
                part = at.read_part(at.part_file(self._folder, first, count))
                return {name: values[case - first] for name, values in part.items()}
        raise KeyError(case)


def prefix(study: Study, folder: Path, size: int) -> list[tuple[int, int]]:
    """First case and number of cases of the finished parts, up to the first that is missing."""
    there = at.names(folder)
    return list(takewhile(lambda one: at.part_file(folder, *one).name in there, at.chunks(study, size)))


def collected(study: Study, folder: Path, size: int) -> tuple[Columns, int]:
    """The columns of the finished prefix of all cases, and its length."""
    found = Columns(folder, prefix(study, folder, size))
    return found, found.count


def pieces(table: Table, *names: str) -> Iterator[dict[str, np.ndarray]]:
    """Some columns (all, if none is named) part by part; a table that is in memory is one part."""
    if isinstance(table, Columns):
        yield from table.pieces(*names)
    else:
        yield {name: table[name] for name in names or table}


def row(table: Table, case: int) -> dict[str, np.ndarray]:
    """The values of one case."""
    return table.row(case) if isinstance(table, Columns) else {name: values[case] for name, values in table.items()}


def head(table: Table, count: int, *names: str) -> dict[str, np.ndarray]:
    """Some columns of the first cases."""
    found: dict[str, list[np.ndarray]] = {name: [] for name in names}
    done = 0
    for piece in pieces(table, *names):
        for name in names:
            found[name].append(piece[name][: count - done])
        done += len(piece[names[0]])
        if done >= count:
            break
    return {name: np.concatenate(some) for name, some in found.items()}


def aligned(some: Iterator[dict[str, np.ndarray]], each: int) -> Iterator[dict[str, np.ndarray]]:
    """Pieces cut anew, so that each holds whole groups of so many cases; what is left over at the end is no group."""
    rest: dict[str, np.ndarray] = {}
    for piece in some:
        joined = {name: np.concatenate([rest[name], values]) if rest else values for name, values in piece.items()}
        size = len(next(iter(joined.values())))
        whole = size - size % each
        if whole:
            yield {name: values[:whole] for name, values in joined.items()}
        rest = {name: values[whole:] for name, values in joined.items()}
