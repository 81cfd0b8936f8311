"""A study that lies open: its cases as points, and how each of them is run again."""

import threading
from pathlib import Path
from typing import Any

import numpy as np

from cutwise import units
from cutwise.app.inputs import as_yaml
from cutwise.app.numbers import titled
from cutwise.app.page.desk import Refused, Target
from cutwise.app.study_text import said
from cutwise.disk import file_name
from cutwise.study.many.answers import Answers, answers, as_written, command, dimension_of, worst
from cutwise.study.many.cases import BAD, FAILED, GOOD, INFEASIBLE
from cutwise.study.many.definition import SEARCHES
from cutwise.study.many.engine import in_folder

STATES = {GOOD: "good", BAD: "bad", INFEASIBLE: "infeasible", FAILED: "failed"}
_POINTS = 3000  # that are drawn; the worst cases are among them always
_WORST = 10


class Studied:
    """The finished cases of a study folder."""

    def __init__(self, found: Answers, report: str, folder: Path) -> None:
        self.found, self.report, self.folder = found, report, folder
        self.lock = threading.Lock()
        self._told: dict[str, Any] | None = None

    @property
    def target(self) -> Target:
        """The scenario that its cases change."""
        study = self.found.study
        source = Path(study.source)
        if not source.is_file():  # named from where the study was begun; looked at from elsewhere
            source = self.folder / f"{file_name(study.scenario.name)}.yaml"
        return Target(source, as_yaml(study.scenario).encode(), kept=True)

    def told(self) -> dict[str, Any]:
        """All that the page shows: what is said, the columns of the points, the worst cases."""
        with self.lock:
            if self._told is None:
                self._told = self._points()
            return self._told

    def case(self, number: int) -> tuple[dict[str, str], str]:
        """Values of a case as a scenario takes them, and the command that runs it again.

        Raises
        ------
        Refused
            There is no such case.
        """
        found = self.found
        if not 0 <= number < found.done:
            raise Refused(404, f"there is no case {number}; finished are 0 to {found.done - 1:,}")
        edits = dict(text.partition("=")[::2] for text in found.study.given)
        edits |= {key: as_written(found.study, key, found.table[f"lever {key}"][number]) for key in found.study.keys}
        return edits, command(found, number)

    def _points(self) -> dict[str, Any]:
        found = self.found
        study, table = found.study, found.table
        bad = worst(found, _WORST) if study.measures else []
        some = np.union1d(np.linspace(0, found.done - 1, min(found.done, _POINTS)).astype(int), np.array(bad, int))
        levers = [self._column(f"lever {key}", key, dimension_of(study, key), some) for key in study.keys]
        measures = [
            self._column(f"measure {name}", titled(name), study.scenario.measures[name].dimension, some)
            | {"name": name, "limits": self._limits(name)}
            for name in study.measures
        ]
        lines = [line for line in said(found) if not line.lstrip().startswith("worst:")]  # they are listed
        return {
            "name": study.name, "lines": lines, "done": found.done, "cases": study.cases,
            "case": some.tolist(), "state": [STATES[int(k)] for k in table["state"][some]],
            "levers": levers, "measures": measures,
            "worst": [{"case": n, "command": command(found, n)} for n in bad],
        }  # fmt: skip

    def _column(self, column: str, title: str, dimension: str | None, some: np.ndarray) -> dict[str, Any]:
        """A column in the unit that people read; words, and what is missing, stand as they are."""
        values = self.found.table[column][some]
        factor, unit = units.displayed(1.0, dimension) if dimension else (1.0, "")
        if values.dtype.kind not in "fiu":
            return {"title": title, "unit": "", "values": [str(one) for one in values]}
        shown = values.astype(float) * factor
        return {
            "title": title, "unit": unit,
            "values": [float(f"{one:.7g}") if np.isfinite(one) else None for one in shown],
        }  # fmt: skip

    def _limits(self, name: str) -> list[float]:
        limit = self.found.study.scenario.asked.get(name)
        factor = units.displayed(1.0, self.found.study.scenario.measures[name].dimension)[0]
        return [] if limit is None else [factor * end for end in (limit.min, limit.max) if end is not None]


def opened(folder: Path, report: str) -> Studied | None:
    """The study of a folder; None where its cases cannot be run one by one from it: a search, or none is finished."""
    study, known = in_folder(folder)
    if study.method in SEARCHES:
        return None
    found = answers(study, folder, int(known["chunk"]))
    return Studied(found, report, folder) if found.done else None
