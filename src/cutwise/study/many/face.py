"""Studies from Python: a file or a mapping in, shares, tables and the worst cases out."""

import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from cutwise.above import above
from cutwise.io.tree import from_data
from cutwise.results import Result
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.spec.scenario import Scenario
from cutwise.study.band import simulate
from cutwise.study.many import engine, tables
from cutwise.study.many import folder as at
from cutwise.study.many.answers import Answers, answers, measures, worst
from cutwise.study.many.cases import case_of
from cutwise.study.many.definition import OPTIMISE, RARE, Study
from cutwise.study.many.reading import read_study, study_of
from cutwise.study.many.statements import Share

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from cutwise.study.many.best import Best
    from cutwise.study.many.rarely import Rarely


_IN_MEMORY = 100_000  # cases of a study without a folder


class StudyResult(NamedTuple):
    """A finished study."""

    answers: Answers
    folder: Path | None  # None: nothing is kept

    @property
    def probability(self) -> "Share | xr.DataArray":
        """Share of good cases with its interval; over design levers an array, with value, low and high along ``end``."""
        shares = self.answers.shares
        return shares[0][1] if len(shares) == 1 else tables.over_settings(self.answers.study, shares)

    @property
    def measures(self) -> dict[str, float]:
        """The numbers of the study by name, SI."""
        return measures(self.answers)

    def to_dataframe(self) -> "pd.DataFrame":
        """A row a case: levers and measures in SI, their units in ``attrs``."""
        return tables.frame(self.answers.study, self.answers.table)

    @property
    def data(self) -> "xr.Dataset":
        """Measures over draws and the settings of design levers, with numeric coordinates in SI."""
        return tables.dataset(self.answers.study, self.answers.table)

    def data_in(self, wanted: Mapping[str, str]) -> "xr.Dataset":
        """:attr:`data` with some of its values in other units, for example ``{"spindle.pressure": "bar"}``."""
        return tables.dataset_in(self.data, wanted, self.answers.study)

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
    source: str | Path | Mapping[str, Any] | Scenario, vary: Mapping[str, Any] | None = None, *,
    folder: str | Path | None = None, jobs: int = 1, resume: bool = False, cases: int | None = None,
    seed: int | None = None, method: str | None = None, executor: str = engine.LOCAL, address: str | None = None,
    accept_version: bool = False,
) -> "StudyResult | Best | Rarely":  # fmt: skip
    """Run a study.

    Parameters
    ----------
    source : str, Path, mapping or Scenario
        A study file, a mapping with the keys of one, or a scenario.
    vary : mapping, optional
        What varies in a scenario: dotted key, and what a study file has for it; :func:`normal`, :func:`uniform` and
        their like write that.
    folder : str or Path, optional
        Where its cases are kept, so that it can be gone on with; left out, they are kept in memory alone.
    jobs : int
        Processes.
    resume : bool
        Go on with the cases that are in the folder.
    cases, seed : int, optional
        Instead of those of the source.
    method : str, optional
        With a scenario.
    executor, address : str, optional
        ``"dask"`` and its scheduler, where other machines are to work.
    accept_version : bool
        Go on in the folder of another version of cutwise.

    Returns
    -------
    StudyResult, Best or Rarely
        Of an optimisation the best setting with all that were tried, of rare failures their probability.

    Raises
    ------
    ScenarioFault
        Everything that is wrong with the study.
    """
    study = _read(source, vary, method, cases, seed)
    if folder is None and study.cases > _IN_MEMORY:
        words = f"{study.cases:,} cases want a folder, from which they are read part by part; up to {_IN_MEMORY:,} do without"
        raise ScenarioFault([Fault((), words, file="folder")])
    with _kept(folder) as place:
        more: dict[str, Any] = {
            "jobs": jobs, "resume": resume, "executor": executor, "address": address, "accept_version": accept_version,
        }  # fmt: skip
        if study.method == OPTIMISE:
            from cutwise.study.many.best import optimised

            return optimised(study, place, **more)
        if study.method == RARE:
            from cutwise.study.many.rarely import rarely

            found = rarely(study, place, **more)
            return found if folder is not None else found._replace(table=dict(found.table))
        engine.run_study(study, place, **more)
        return StudyResult(_answers(study, place, kept=folder is not None), None if folder is None else place)


def _read(
    source: str | Path | Mapping[str, Any] | Scenario, vary: Mapping[str, Any] | None, method: str | None,
    cases: int | None, seed: int | None,
) -> Study:  # fmt: skip
    if isinstance(source, Scenario):
        said = {"name": source.name, "vary": dict(vary or {}), **({} if method is None else {"method": method})}
        return study_of(from_data(said, "study"), [], Path("study"), cases=cases, seed=seed, of=source)
    if vary is not None or method is not None:
        raise ScenarioFault([Fault((), "vary and method go with a scenario; a study has its own", file="run_study")])
    if isinstance(source, Mapping):
        return study_of(from_data(dict(source), "study"), [], Path("study"), cases=cases, seed=seed)
    return read_study(Path(source), cases=cases, seed=seed)


@contextmanager
def _kept(folder: str | Path | None) -> Iterator[Path]:
    if folder is not None:
        yield Path(folder)
        return
    with tempfile.TemporaryDirectory() as temporary:
        yield Path(temporary)


def grid(start: str | float, end: str | float, count: int, spacing: str = "linear") -> dict[str, Any]:
    """Settings from one value to another, evenly spaced (``linear``) or by equal factors (``log``)."""
    return {"grid": {"from": start, "to": end, "count": count, "spacing": spacing}}


def normal(mean: str, deviation: str) -> dict[str, Any]:
    """Normal scatter about a mean."""
    return {"normal": {"mean": mean, "deviation": deviation}}


def lognormal(median: str, log_deviation: float) -> dict[str, Any]:
    """Scatter of a positive value whose logarithm is normal."""
    return {"lognormal": {"median": median, "log_deviation": log_deviation}}


def uniform(low: str, high: str) -> dict[str, Any]:
    """Any value between two ends, none more likely."""
    return {"uniform": [low, high]}


def _answers(study: Study, folder: Path, *, kept: bool) -> Answers:
    """The answers of a folder; their columns are read when they are asked for, or are in memory if it goes away."""
    known = at.identity_in(folder)
    assert known is not None
    found = answers(study, folder, int(known["chunk"]))
    return found if kept else found._replace(table=dict(found.table))
