"""Studies from Python: a file or a mapping in, shares, tables and the worst cases out."""

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cutwise import units
from cutwise.above import above
from cutwise.io.tree import from_data
from cutwise.results import Result
from cutwise.spec.scenario import Scenario
from cutwise.study.band import simulate
from cutwise.study.many import engine
from cutwise.study.many import folder as at
from cutwise.study.many.answers import Answers, answers, dimension_of, measures, worst
from cutwise.study.many.cases import case_of
from cutwise.study.many.reading import read_study, study_of
from cutwise.study.many.statements import Share

if TYPE_CHECKING:
    import pandas as pd


class StudyResult(NamedTuple):
    """A finished study."""

    answers: Answers
    folder: Path | None  # None: nothing is kept

    @property
    def probability(self) -> Share | list[tuple[dict[str, Any], Share]]:
        """Share of good cases with its interval; over design levers one for each combination."""
        shares = list(self.answers.shares)
        return shares[0][1] if len(shares) == 1 else shares

    @property
    def measures(self) -> dict[str, float]:
        """The numbers of the study by name, SI."""
        return measures(self.answers)

    def to_dataframe(self) -> "pd.DataFrame":
        """A row a case: levers and measures in SI, their units in ``attrs``."""
        import pandas as pd

        study, table = self.answers.study, self.answers.table
        frame = pd.DataFrame({key: table[f"lever {key}"] for key in study.keys})
        frame = frame.assign(**{name: table[f"measure {name}"] for name in study.measures}, state=table["state"])
        frame.index = pd.Index(table["case"], name="case")
        frame.attrs["units"] = {
            **{key: units.DIMENSIONS[d].si for key in study.keys if (d := dimension_of(study, key)) is not None},
            **{name: units.DIMENSIONS[study.scenario.measures[name].dimension].si for name in study.measures},
        }
        return frame

    def case(self, number: int) -> Scenario:
        """The scenario of a case, to be simulated in full."""
        return case_of(self.answers.study, number)

    def worst(self, count: int = 3) -> list[int]:
        """Numbers of the cases that are farthest beyond their limits."""
        return worst(self.answers, count)

    def simulate(self, number: int) -> Result:
        """The run of a case."""
        return simulate(self.case(number))

    def _repr_html_(self) -> str:
        return str(above("study_html")(self))

    def __repr__(self) -> str:
        shares = ", ".join(f"{s.value:.3f} ({s.low:.3f} to {s.high:.3f})" for _, s in self.answers.shares[:3])
        return f"StudyResult({self.answers.done:,} cases, P(good) {shares or 'without requirements'})"


def run_study(
    source: str | Path | Mapping[str, Any], *, folder: str | Path | None = None, jobs: int = 1, resume: bool = False,
    cases: int | None = None, seed: int | None = None,
) -> StudyResult:  # fmt: skip
    """Run a study.

    Parameters
    ----------
    source : str, Path or mapping
        A study file, or a mapping with the keys of one.
    folder : str or Path, optional
        Where its cases are kept, so that it can be gone on with; left out, they are kept in memory alone.
    jobs : int
        Processes.
    resume : bool
        Go on with the cases that are in the folder.
    cases, seed : int, optional
        Instead of those of the source.

    Raises
    ------
    ScenarioFault
        Everything that is wrong with the study.
    """
    study = (
        study_of(from_data(dict(source), "study"), [], Path("study"), cases=cases, seed=seed)
        if isinstance(source, Mapping)
        else read_study(Path(source), cases=cases, seed=seed)
    )
    if folder is not None:
        engine.run_study(study, Path(folder), jobs=jobs, resume=resume)
        return StudyResult(_answers(study, Path(folder)), Path(folder))
    with tempfile.TemporaryDirectory() as temporary:
        engine.run_study(study, Path(temporary), jobs=jobs)
        return StudyResult(_answers(study, Path(temporary)), None)


def _answers(study: Any, folder: Path) -> Answers:
    known = at.identity_in(folder)
    assert known is not None
    found = answers(study, folder, int(known["chunk"]))
    return found._replace(table={name: np.array(values) for name, values in found.table.items()})
