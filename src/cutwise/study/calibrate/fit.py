r"""The one fit and the one set of statistics of every kind of calibration.

With the Jacobian :math:`J` of the model over the scatter of each equation, residuals :math:`r` over it, and weights
:math:`w` of the loss (1 for least squares):

.. math:: s^2 = \frac{\sum w r^2}{\sum w - p}, \qquad C = s^2 (J^T W J)^{-1}, \qquad
          t = \frac{|r|}{s\sqrt{1 - h}}, \quad h = \mathrm{diag}\, J (J^T W J)^{-1} J^T W

Of a time series whose neighbouring residuals correlate by more than 0.2, C is the sandwich
:math:`H^{-1}(\sum_g J_g^T r_g r_g^T J_g)H^{-1} G/(G-1)` over G stretches (turns of the spindle), with t(G - 1).
Intervals are Student's with the degrees of freedom. Columns of :math:`J` are scaled to length 1; singular values below
1e-9 of the largest count as 0: their directions are what the data do not determine, and :math:`C` leaves them out.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import optimize, stats

from cutwise import units
from cutwise.results import SolverFailure
from cutwise.spec.faults import Fault, ScenarioFault
from cutwise.study.calibrate.posed import (
    UNDETERMINED,
    Fit,
    FloatArray,
    NextTest,
    Outlier,
    Posed,
    Unknown,
    Verdict,
    combination,
)

STANDS_OUT = 3.5  # studentised residual
DOWN_WEIGHTED = 0.5
POOR_CONDITION = 300.0
_CONTRADICTS = 3.0  # standard deviations of prior and data together
_TURNED_OVER = {"angular_compliance": "angular_stiffness", "compliance": "stiffness"}
CORRELATED = 0.2  # neighbouring residuals, beyond which they are not independent
STRETCHES = 20  # of a time series without turns
_RANK = 1e-9
_EMPTY_COLUMN = 1e-12


class Scaled(NamedTuple):
    """A Jacobian with columns of length 1, taken apart."""

    lengths: FloatArray  # (p,)
    values: FloatArray  # singular values, falling (p,)
    vectors: FloatArray  # right singular vectors as columns (p, p)
    rank: int

    @property
    def inverse(self) -> FloatArray:
        """:math:`(J^T J)^{-1}` of the unscaled unknowns, without what is not determined."""
        seen = self.vectors[:, : self.rank] / self.values[: self.rank]
        return np.asarray((seen @ seen.T) / np.outer(self.lengths, self.lengths))

    @property
    def condition(self) -> float:
        """First over last singular value that is not 0."""
        return float(self.values[0] / self.values[self.rank - 1]) if self.rank else np.inf


def taken_apart(jacobian: FloatArray, dimensions: Sequence[str], scales: Sequence[float] = ()) -> Scaled:
    """Column scaling and singular values; a column below 1e-12 of the largest of its unit counts as 0.

    ``scales`` of the unknowns take the place of the lengths of the columns.
    """
    lengths = np.linalg.norm(jacobian, axis=0)
    same = np.array(dimensions)
    largest = np.array([lengths[same == dimension].max() for dimension in dimensions])
    empty = lengths <= _EMPTY_COLUMN * largest
    lengths = 1.0 / np.array(scales) if len(scales) else np.where(empty, 1.0, lengths)
    scaled = np.where(empty, 0.0, jacobian / lengths)
    _, values, turned = np.linalg.svd(scaled, full_matrices=len(scaled) < scaled.shape[1])
    values = np.concatenate([values, np.zeros(scaled.shape[1] - len(values))])
    rank = int(np.sum(values > _RANK * max(values[0], 1e-300)))
    return Scaled(lengths, values, turned.T, rank)


def fitted(
    posed: Posed, *, loss: str = "linear", level: float = 0.9, folds: Sequence[Sequence[int]] = (), retest: bool = True,
    prior: Mapping[str, tuple[Any, Any]] = MappingProxyType({}),
) -> Fit:  # fmt: skip
    """The fit and all that can be said about it.

    Parameters
    ----------
    posed : Posed
        The problem.
    loss : str
        ``linear`` or ``soft_l1``, whose scale is s of the linear fit.
    level : float
        Probability of the intervals.
    folds : sequence of sequences of int
        Rows of the data that are left out together, for the left-out error.
    retest : bool
        Look for the row to measure again; not for the samples of a time series.
    prior : mapping
        What is known of unknowns beforehand, by name: value and standard deviation. Names of other fits are passed over.

    Raises
    ------
    SolverFailure
        The fit does not converge.
    """
    known = {name: pair for name, pair in prior.items() if name in posed.names}
    if known:
        return _with_prior(posed, known, loss=loss, level=level, folds=folds, retest=retest)
    x = np.array([unknown.start for unknown in posed.unknowns])
    scatter = np.ones(len(posed.measured)) if posed.sigma is None else posed.sigma(posed.model(x))
    x = _solved(posed, x, scatter)
    for _ in range(2 if posed.sigma_by_column or posed.sigma is not None else 0):
        scatter = _scatter_by_column(posed, x) if posed.sigma_by_column else posed.sigma(posed.model(x))  # type: ignore[misc]
        x = _solved(posed, x, scatter)
    if posed.sigma_by_column:
        scatter = _scatter_by_column(posed, x)
    weights = np.ones(len(posed.measured))
    if loss == "soft_l1":
        s = _spread(posed, x, scatter, weights)
        if s > 0.0:
            x = _solved(posed, x, scatter, s)
            weights = 1.0 / np.sqrt(1.0 + (_residual(posed, x) / (scatter * s)) ** 2)
            if posed.sigma_by_column:
                scatter = _scatter_by_column(posed, x, weights)
    return _judged(posed, x, scatter, weights, level, folds, retest=retest)


def _with_prior(posed: Posed, prior: Mapping[str, tuple[Any, Any]], **more: Any) -> Fit:
    """The fit with an equation more for each unknown of which something is known beforehand."""
    without = fitted(posed, **{**more, "folds": (), "retest": False})
    places = [posed.names.index(name) for name in prior]
    pairs = [known_before(posed.unknowns[k], pair) for k, pair in zip(places, prior.values(), strict=True)]
    value, sd = np.array(pairs).T
    count, one_by_one = len(posed.measured), np.eye(len(posed.names))[places]
    own, scale = np.ones(count), max(without.scale, 1e-12 * float(np.max(np.abs(posed.measured), initial=1e-300)))
    if posed.sigma_by_column:
        own, scale = without.scatter, 1.0
    elif posed.sigma is not None:
        own, scale = posed.sigma(posed.model(without.x)), 1.0
    spread = np.concatenate([own, sd / scale])
    augmented = replace(
        posed, measured=np.concatenate([posed.measured, value]), row=np.concatenate([posed.row, np.full(len(places), -1)]),
        column=np.concatenate([posed.column, np.full(len(places), len(posed.columns))]), columns=(*posed.columns, "prior"),
        dimensions=(*posed.dimensions, "dimensionless"), model=lambda x: np.concatenate([posed.model(x), x[places]]),
        jacobian=lambda x: np.concatenate([posed.jacobian(x), one_by_one]), sigma=lambda _: spread, sigma_by_column=False,
        degrees_of_freedom=without.degrees_of_freedom,
        blocks=None if posed.blocks is None else np.concatenate([posed.blocks, np.full(len(places), -1)]),
    )  # fmt: skip
    found = fitted(augmented, **more)
    said = []
    for k, name in enumerate(prior):
        ends = [units.show(float(v), posed.unknowns[places[k]].dimension) for v in (value[k], sd[k])]
        alone = without.standard_errors[places[k]]
        off = abs(without.x[places[k]] - value[k]) / np.hypot(sd[k], alone) if np.isfinite(alone) else 0.0
        against = (
            f"; the data alone are {off:.3g} standard deviations off: they contradict it" if off > _CONTRADICTS else ""
        )
        said.append(f"known beforehand of {name}: {ends[0]} with a standard deviation of {ends[1]}{against}")
    return replace(
        found, posed=posed, residual=found.residual[:count], studentised=found.studentised[:count],
        weights=found.weights[:count], scatter=found.scatter[:count], left_out=found.left_out[:count],
        outliers=tuple(one for one in found.outliers if one.row >= 0), prior=tuple(said),
    )  # fmt: skip


def known_before(unknown: Unknown, pair: tuple[Any, Any]) -> tuple[float, float]:
    """Value and standard deviation of a prior [SI]; a stiffness becomes the compliance that is fitted.

    Raises
    ------
    ScenarioFault
        They are none.
    """
    turned = _TURNED_OVER.get(unknown.dimension)
    try:
        value, sd = (units.parse(end, unknown.dimension) for end in pair)
    except units.UnitFault as fault:
        try:
            if turned is None:
                raise
            stiffness, spread = (units.parse(end, turned) for end in pair)
            value, sd = 1.0 / stiffness, spread / stiffness**2
        except (units.UnitFault, ZeroDivisionError):
            raise ScenarioFault([Fault(("fit", "prior", unknown.name), str(fault))]) from None
    if sd <= 0.0:
        raise ScenarioFault([Fault(("fit", "prior", unknown.name), "the standard deviation is not above zero")])
    return value, sd


def _residual(posed: Posed, x: FloatArray) -> FloatArray:
    return np.asarray(posed.measured - posed.model(x))


def _solved(posed: Posed, x: FloatArray, scatter: FloatArray, robust: float = 0.0) -> FloatArray:
    """The least squares, or soft_l1 of the given scale; a linear problem directly, with the smallest step where it is free."""
    apart = taken_apart(posed.jacobian(x) / scatter[:, None], [u.dimension for u in posed.unknowns], posed.scales)
    if posed.linear and not robust:
        jacobian = posed.jacobian(x) / scatter[:, None]
        return np.asarray(x + apart.inverse @ (jacobian.T @ (_residual(posed, x) / scatter)))
    found = optimize.least_squares(
        lambda y: (posed.model(y / apart.lengths) - posed.measured) / scatter,
        x * apart.lengths,
        jac=lambda y: posed.jacobian(y / apart.lengths) / scatter[:, None] / apart.lengths,
        loss="soft_l1" if robust else "linear",
        f_scale=robust or 1.0,
        xtol=1e-13, ftol=1e-13, gtol=1e-13, max_nfev=300,
    )  # fmt: skip
    if found.status <= 0:
        raise SolverFailure(f"the fit does not converge after {found.nfev} evaluations ({found.message})")
    return np.asarray(found.x / apart.lengths)


def _scatter_by_column(posed: Posed, x: FloatArray, weights: FloatArray | None = None) -> FloatArray:
    """Scatter of each column; each takes its share of the unknowns."""
    residual, share = _residual(posed, x), len(posed.unknowns) / len(posed.columns)
    scatter = np.ones(len(residual))
    for column in range(len(posed.columns)):
        own = posed.column == column
        w = np.ones(int(own.sum())) if weights is None else weights[own]
        free = max(float(w.sum()) - share, 1e-9)
        found = np.sqrt(float(np.sum(w * residual[own] ** 2)) / free)
        scatter[own] = max(found, 1e-12 * float(np.max(np.abs(posed.measured[own]), initial=1e-300)))
    return scatter


def _spread(posed: Posed, x: FloatArray, scatter: FloatArray, weights: FloatArray) -> float:
    free = float(weights.sum()) - posed.removed - len(posed.unknowns)
    return float(np.sqrt(np.sum(weights * (_residual(posed, x) / scatter) ** 2) / free)) if free > 0 else 0.0


def _judged(
    posed: Posed, x: FloatArray, scatter: FloatArray, weights: FloatArray, level: float, folds: Sequence[Sequence[int]],
    *, retest: bool,
) -> Fit:  # fmt: skip
    residual = _residual(posed, x)
    r = residual / scatter
    plain = posed.jacobian(x) / scatter[:, None]
    root = np.sqrt(weights)
    apart = taken_apart(plain * root[:, None], [unknown.dimension for unknown in posed.unknowns], posed.scales)
    inverse = apart.inverse
    free = max(float(weights.sum()) - posed.removed - apart.rank, 1e-9)
    s = 1.0 if posed.sigma_by_column else float(np.sqrt(np.sum(weights * r**2) / free))
    dof = posed.degrees_of_freedom or max(len(r) - posed.removed - apart.rank, 1)
    lag_1 = neighbours(posed, r)
    covariance = s**2 * inverse
    if lag_1 > CORRELATED and posed.blocks is not None:
        covariance, dof = _sandwich(posed.blocks, plain * weights[:, None], r, inverse)
    quantile = float(stats.t.ppf(0.5 + 0.5 * level, dof))
    leverage = np.einsum("ij,jk,ik->i", plain, inverse, plain) * weights
    floor = 1e-9 * max(float(np.max(np.abs(posed.measured / scatter), initial=0.0)), 1e-300)  # noise-free data
    spread = max(s, floor) * np.sqrt(np.maximum(1.0 - leverage, 1e-9))
    studentised = np.where(leverage < 1.0 - 1e-9, np.abs(r) / spread, 0.0)
    null = apart.vectors[:, apart.rank :]
    half = quantile * np.sqrt(np.diagonal(covariance))
    verdicts = tuple(_verdict(posed, k, x[k], half[k], null) for k in range(len(x)))
    left_out, cover = _left_out(posed, plain * root[:, None], r * root, inverse, (s, dof, level), folds)
    worst = [k for k, u in enumerate(posed.unknowns) if u.deciding] or list(range(len(x)))
    return Fit(
        posed, x, covariance, residual, studentised, weights, scatter * s, s, dof, quantile, apart.condition,
        combination(posed.names, apart.vectors[:, apart.rank - 1]) if apart.condition > POOR_CONDITION else (),
        null, verdicts, _outliers(posed, studentised, weights),
        _next_test(posed, plain, inverse, max(worst, key=lambda k: half[k] / max(_size(posed, k, float(x[k])), 1e-300)))
        if retest else None,
        left_out * scatter, cover, lag_1,
    )  # fmt: skip


def neighbours(posed: Posed, r: FloatArray) -> float:
    """Correlation of neighbouring residuals of a time series, that of the column where it is largest; 0 for other data."""
    if posed.blocks is None:
        return 0.0
    found = [0.0]
    for column in range(len(posed.columns)):
        own = r[posed.column == column]
        squares = float(own @ own)
        if squares > 0.0:
            found.append(float(own[1:] @ own[:-1]) / squares)
    return max(found)


def _sandwich(
    blocks: npt.NDArray[np.integer[Any]], jacobian: FloatArray, r: FloatArray, inverse: FloatArray
) -> tuple[FloatArray, int]:  # fmt: skip
    """Covariance that holds for residuals which correlate within stretches, and its degrees of freedom."""
    numbers = np.unique(blocks)
    if len(numbers) < 2:
        blocks = (np.arange(len(r)) * STRETCHES) // len(r)
        numbers = np.unique(blocks)
    middle = np.zeros_like(inverse)
    for number in numbers:
        pushed = jacobian[blocks == number].T @ r[blocks == number]
        middle += np.outer(pushed, pushed)
    count = len(numbers)
    return np.asarray(inverse @ middle @ inverse) * count / (count - 1), count - 1


def _size(posed: Posed, k: int, value: float) -> float:
    return max(abs(float(value)), posed.unknowns[k].zero_scale)


def _verdict(posed: Posed, k: int, value: float, half: float, null: FloatArray) -> Verdict:
    if np.sum(null[k] ** 2) > UNDETERMINED:
        return "not identified"
    ratio = half / max(_size(posed, k, value), 1e-300)
    return "identified" if ratio < 0.5 else "weak" if ratio <= 1.0 else "not identified"


def _outliers(posed: Posed, studentised: FloatArray, weights: FloatArray) -> tuple[Outlier, ...]:
    found = np.flatnonzero((studentised > STANDS_OUT) | (weights < DOWN_WEIGHTED))
    order = found[np.argsort(-studentised[found], kind="stable")]
    return tuple(
        Outlier(int(posed.row[k]), posed.columns[posed.column[k]], float(studentised[k]), float(weights[k]))
        for k in order
    )


def _left_out(
    posed: Posed,
    jacobian: FloatArray,
    r: FloatArray,
    inverse: FloatArray,
    spread: tuple[float, int, float],
    folds: Sequence[Sequence[int]],
) -> tuple[FloatArray, float]:
    r"""Errors of rows that the fit does not know, :math:`(I - H_{kk})^{-1} r_k`, exact for a linear model; and their cover.

    Their covariance is :math:`s_k^2 (I - H_{kk})^{-1}`, that of the prediction and of the measurement, with the scatter
    that the other rows have, :math:`s_k^2 = (r^T r - r_k^T (I - H_{kk})^{-1} r_k)/(\nu - n_k)`.
    """  # fmt: skip
    errors, inside, count = np.full(len(r), np.nan), 0, 0
    s, dof, level = spread
    for fold in folds:
        own = np.flatnonzero(np.isin(posed.row, fold))
        rest = np.eye(len(own)) - jacobian[own] @ inverse @ jacobian[own].T
        if np.linalg.cond(rest) > 1e9:  # without these rows something is not determined
            continue
        turned = np.linalg.inv(rest)
        errors[own] = turned @ r[own]
        free, without = dof, s
        if not posed.sigma_by_column and dof > len(own):
            free = dof - len(own)
            without = np.sqrt(max(s**2 * dof - float(r[own] @ errors[own]), 0.0) / free)
        quantile = float(stats.t.ppf(0.5 + 0.5 * level, free))
        inside += int(np.sum(np.abs(errors[own]) <= quantile * without * np.sqrt(np.diagonal(turned))))
        count += len(own)
    return errors, inside / count if count else float("nan")


def _next_test(posed: Posed, jacobian: FloatArray, inverse: FloatArray, worst: int) -> NextTest | None:
    """Which row, measured again, tells most; and which helps the parameter of the largest relative error."""
    rows = np.unique(posed.row)
    if len(rows) > 5000:
        return None
    gains, factors = np.zeros(len(rows)), np.ones(len(rows))
    for k, row in enumerate(rows):
        own = jacobian[posed.row == row]
        seen = own @ inverse
        inner = np.eye(len(own)) + seen @ own.T
        gains[k] = np.linalg.slogdet(inner)[1]
        less = float(seen[:, worst] @ np.linalg.solve(inner, seen[:, worst]))
        if inverse[worst, worst] > 0.0:
            factors[k] = np.sqrt(max(0.0, 1.0 - less / inverse[worst, worst]))
    best, helps = int(np.argmax(gains)), int(np.argmin(factors))
    return NextTest(int(rows[best]), float(gains[best]), posed.names[worst], int(rows[helps]), float(factors[helps]))
