"""What passes between the parts of a correction, and what comes of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cutwise import units
from cutwise.results import Measure, Result
from cutwise.spec.correct import Correction
from cutwise.spec.scenario import Scenario

FloatArray = npt.NDArray[np.float64]
Progress = Callable[[float], None]


class Change(NamedTuple):
    """One thing that was changed: what, from, to, and what it bought, in words."""

    key: str  # a key of the scenario, or a word of the program
    old: str
    new: str
    why: str
    line: int = 0  # of the program before; 0: not one line

    def __str__(self) -> str:
        where = f"line {self.line}: " if self.line else ""
        return f"{where}{self.key} {self.old} → {self.new}: {self.why}"


class Along(NamedTuple):
    """A value along the path before and after, for the report; ``n`` places."""

    at: FloatArray  # [m] of the path, shape (n,)
    before: FloatArray  # SI, shape (n,)
    after: FloatArray
    limit: FloatArray  # what the place allows
    binds: npt.NDArray[np.int64]  # number in ``names`` of what binds, -1: nothing
    names: tuple[str, ...]
    dimension: str  # of the values
    title: str


@dataclass(frozen=True)
class Task:
    """What a correction is asked."""

    scenario: Scenario  # as the corrections before this one have left it
    said: Correction  # the section, options of the command line in it
    before: Result  # the run of the scenario as it was given
    unroll: bool = False  # lines that run several times may be written out
    progress: Progress | None = None


@dataclass(frozen=True)
class Proposal:
    """What a correction proposes: it has not been proved yet, unless ``after`` is given."""

    scenario: Scenario  # with the new program and settings in it
    changes: tuple[Change, ...] = ()
    measures: Mapping[str, tuple[float, str]] = field(
        default_factory=dict
    )  # SI value and dimension, names of spec part 2
    told: tuple[str, ...] = ()  # sentences for the user
    kept: tuple[str, ...] = ()  # why a limit cannot be kept: exit 1
    along: tuple[Along, ...] = ()
    after: Result | None = None  # the simulation of that very scenario, if it was made already
    front: tuple[Mapping[str, float], ...] = ()  # programs of other budgets that were simulated: their measures, SI


@dataclass(frozen=True)
class Corrected:
    """A correction that was read back and simulated."""

    program: str  # text of the new program; empty where there is none
    scenario: Scenario  # with it and with the new settings
    before: Result
    after: Result
    changes: tuple[Change, ...]
    pareto: tuple[Mapping[str, float], ...]  # every proposal that was simulated: its measures, SI
    measures: Mapping[str, Measure]  # those of the correction: X_before, X_after, time_saved, ...
    told: tuple[str, ...]
    reasons: tuple[str, ...]  # why it is not good enough; none: it is
    along: tuple[Along, ...] = ()

    @property
    def good(self) -> bool:
        """Whether the new program meets all limits, and gains something."""
        return not self.reasons

    def as_json(self, files: Mapping[str, str] | None = None) -> dict[str, Any]:
        """One object in SI, as ``run --json`` has it."""
        return {
            "scenario": self.scenario.name,
            "process": "correct",
            "verdict": "pass" if self.good else "fail",
            "reasons": list(self.reasons),
            "measures": {name: {"value": one.value, "unit": one.unit} for name, one in self.measures.items()},
            "changes": [change._asdict() for change in self.changes],
            "pareto": [dict(row) for row in self.pareto],
            "requirements": [check.as_json() for check in self.after.checks],
            "assumed": list(self.after.assumed),
            "warnings": list(self.after.warnings),
            "told": list(self.told),
            "program": self.program,
            "files": dict(files or {}),
        }


def measured(values: Mapping[str, tuple[float, str]]) -> dict[str, Measure]:
    """Values in SI with their dimensions as measures."""
    unknown = [dimension for _, dimension in values.values() if dimension not in units.DIMENSIONS]
    assert not unknown, unknown
    return {name: Measure(value, dimension) for name, (value, dimension) in values.items()}
