"""What a kind of calibration hands to the fit, and what comes back."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
Verdict = Literal["identified", "weak", "not identified"]


class Unknown(NamedTuple):
    """A parameter of a fit."""

    name: str
    dimension: str  # of :data:`cutwise.units.DIMENSIONS`
    start: float = 0.0
    deciding: bool = False  # whether its verdict decides the exit code
    zero_scale: float = 0.0  # stands for |value| where 0 is an ordinary value


@dataclass(frozen=True)
class Posed:
    """A least-squares problem: m equations, p unknowns.

    ``model`` gives the modelled values (m,), ``jacobian`` their derivatives (m, p), both at x (p,). Every equation
    belongs to a row of the data and to one of its columns.
    """

    unknowns: tuple[Unknown, ...]
    measured: FloatArray  # SI, shape (m,)
    row: npt.NDArray[np.int64]  # of each equation, from 0
    column: npt.NDArray[np.int64]  # number of the column of each equation
    columns: tuple[str, ...]
    dimensions: tuple[str, ...]  # of each column
    model: Callable[[FloatArray], FloatArray]
    jacobian: Callable[[FloatArray], FloatArray]
    linear: bool = True
    sigma: Callable[[FloatArray], FloatArray] | None = None  # scatter (m,) that is given, of the model at x
    sigma_by_column: bool = False  # an unknown scatter of each column
    removed: int = 0  # equations that were used up before, by zeros that are not known
    scales: tuple[float, ...] = ()  # of the unknowns, in place of the lengths of the columns
    degrees_of_freedom: int | None = None  # of the intervals; left out: equations less unknowns
    blocks: npt.NDArray[np.int64] | None = None  # of a time series: which turn or stretch each equation belongs to

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        return tuple(unknown.name for unknown in self.unknowns)


class Outlier(NamedTuple):
    """A value that stands out."""

    row: int  # of the data, from 0
    column: str
    studentised: float
    weight: float  # 1 but for soft_l1


class NextTest(NamedTuple):
    """Which row of the data to measure once more."""

    row: int
    gain: float  # rise of log det(J^T J)
    parameter: str  # of the largest relative error
    parameter_row: int
    factor: float  # of its standard error


@dataclass(frozen=True)
class Fit:
    """A finished fit with its statistics; arrays over unknowns (p,) or equations (m,)."""

    posed: Posed
    x: FloatArray
    covariance: FloatArray  # (p, p)
    residual: FloatArray  # measured less modelled, SI
    studentised: FloatArray
    weights: FloatArray  # of the loss
    scatter: FloatArray  # standard deviation of each equation, SI
    scale: float  # s: SI of the columns, or of the residual over the scatter that was given
    degrees_of_freedom: int
    quantile: float  # half-width of an interval over its standard error
    condition: float  # of the scaled Jacobian
    poorly_seen: tuple[tuple[str, float], ...]  # combination, if the condition is above 300
    null: FloatArray  # directions that the data do not determine, (p, n), of the scaled unknowns
    verdicts: tuple[Verdict, ...]
    outliers: tuple[Outlier, ...]
    next: NextTest | None
    left_out: FloatArray  # error of each equation when its row is left out; NaN where it was not
    left_out_cover: float  # share of them inside their interval
    lag_1: float = 0.0  # of a time series: correlation of neighbouring residuals
    prior: tuple[str, ...] = ()  # what was known beforehand, in words

    @property
    def undetermined(self) -> npt.NDArray[np.bool_]:
        """Which unknowns lie in what the data do not determine (p,)."""
        return np.asarray(np.sum(self.null**2, axis=1) > UNDETERMINED)

    @property
    def standard_errors(self) -> FloatArray:
        """Of the unknowns (p,); infinite where the data say nothing."""
        return np.where(self.undetermined, np.inf, np.sqrt(np.diagonal(self.covariance)))

    def correlation(self) -> FloatArray:
        """(p, p); 0 where there is none."""
        sd = np.sqrt(np.diagonal(self.covariance))
        safe = np.where(sd > 0.0, sd, 1.0)
        return np.asarray(self.covariance / np.outer(safe, safe))


UNDETERMINED = 0.1
"""Squares of a parameter's entries in the null vectors above which it is not identified."""


class Value(NamedTuple):
    """A parameter as it is shown and written, SI."""

    name: str
    dimension: str
    value: float
    standard_error: float
    low: float | None  # None: no end
    high: float | None
    verdict: Verdict
    deciding: bool
    note: str = ""


@dataclass(frozen=True)
class Finding:
    """What a calibration found out."""

    model: str
    values: tuple[Value, ...]
    written: dict[str, Any]  # the values block of the entry
    covariances: dict[str, Any]
    residual: float
    residual_dimension: str
    left_out_error: float | None
    left_out_words: str
    left_out_dimension: str = "dimensionless"
    fit: Fit | None = None  # of the model that is written, where its parameters have a covariance
    drawn: tuple[tuple[str, str, FloatArray, FloatArray], ...] = ()  # column, dimension, measured, modelled
    compared: tuple[tuple[str, ...], ...] = ()  # table of the models that were fitted, titles first
    warnings: tuple[str, ...] = ()
    cannot_tell: tuple[str, ...] = ()
    advice: tuple[str, ...] = ()  # what to measure next
    failed: tuple[str, ...] = ()  # why the exit code is 1
    outliers: tuple[Outlier, ...] = ()
    condition: float | None = None
    unknown: tuple[dict[str, float], ...] = ()  # combinations that the data do not determine
    entry: bool = True  # whether it is worth an entry of the library


def combination(names: Sequence[str], vector: FloatArray) -> tuple[tuple[str, float], ...]:
    """The entries above 0.2 of a direction, the largest first and positive."""
    largest = vector[np.argmax(np.abs(vector))]
    turned = vector * np.sign(largest)
    order = np.argsort(-np.abs(turned), kind="stable")
    return tuple((names[k], float(turned[k])) for k in order if abs(turned[k]) > 0.2)
