"""Statistics of a band: variances from covariances, Student's ends and probabilities, draws."""

import math
from typing import TYPE_CHECKING

import numpy as np

from cutwise.later import later
from cutwise.results import Check
from cutwise.study.inputs import FloatArray, Scatter

if TYPE_CHECKING:
    from scipy import stats
else:
    stats = later("scipy.stats")

_RULED_OUT = 0.01  # least over largest eigenvalue of the correlations
_NOTHING = 1e-12  # of the largest: a direction without scatter
_CARRIES = 0.005  # share of the variance that is worth telling


def directions(scatter: Scatter) -> FloatArray:
    """In which the inputs are moved, columns of one standard error each, shape (inputs, d).

    One by one; but along the principal axes of a covariance whose correlations are so close to one that a single value
    off by its standard error is a case that the data rule out.
    """
    found = []
    for block in scatter.blocks:
        sd = np.sqrt(np.diagonal(block.covariance))
        values, vectors = np.linalg.eigh(block.covariance / np.outer(sd, sd))
        apart = np.eye(len(sd))
        if values[0] < _RULED_OUT * values[-1]:
            kept = values > _NOTHING * values[-1]
            apart = vectors[:, kept] * np.sqrt(values[kept])
        for way in (sd[:, None] * apart).T:
            column = np.zeros(len(scatter.inputs))
            column[list(block.places)] = way
            found.append(column)
    return np.stack(found, axis=1)


def variances(scatter: Scatter, gradient: FloatArray) -> list[float]:
    """What each covariance adds to the variance of a measure."""
    found = []
    for block in scatter.blocks:
        own = gradient[list(block.places)]
        found.append(float(own @ block.covariance @ own))
    return found


def satterthwaite(scatter: Scatter, variances: list[float]) -> float:
    """Degrees of freedom of the sum of variances, those beyond the covariances exactly known; infinite if all are."""
    below = sum(v * v / b.degrees_of_freedom for v, b in zip(variances, scatter.blocks, strict=False))
    return sum(variances) ** 2 / below if below > 0.0 else math.inf


def carried(scatter: Scatter, gradient: FloatArray, variance: float) -> dict[str, float]:
    """Share of the variance that each input carries, with its correlations; the largest first."""
    if variance <= 0.0:
        return {}
    shares = {}
    for block in scatter.blocks:
        own = gradient[list(block.places)]
        for place, share in zip(block.places, own * (block.covariance @ own) / variance, strict=True):
            if abs(share) >= _CARRIES:
                shares[scatter.inputs[place].key] = float(share)
    return dict(sorted(shares.items(), key=lambda item: -abs(item[1])))


def quantile(probability: float, freedom: float = math.inf) -> float:
    """Student's quantile; normal without an end of the degrees of freedom."""
    law = stats.norm if math.isinf(freedom) else stats.t(freedom)
    return float(law.ppf(probability))


def probability(check: Check, value: float, sd: float, freedom: float) -> float:
    """That a measure keeps its limits."""
    if sd <= 0.0:
        return 1.0 if check.keeps(value) else 0.0
    law = stats.norm if math.isinf(freedom) else stats.t(freedom)
    above = 1.0 if check.maximum is None else float(law.cdf((check.maximum - value) / sd))
    below = 0.0 if check.minimum is None else float(law.cdf((check.minimum - value) / sd))
    return above - below


def draws(scatter: Scatter, count: int, seed: int) -> FloatArray:
    """Errors of the inputs (count, p) in the quantity in which they are normal, Student's for each covariance."""
    drawn = np.random.default_rng(seed)
    errors = np.zeros((count, len(scatter.inputs)))
    for block in scatter.blocks:
        sd = np.sqrt(np.diagonal(block.covariance))
        values, vectors = np.linalg.eigh(block.covariance / np.outer(sd, sd))
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        own = drawn.normal(size=(count, len(sd))) @ root.T * sd
        if math.isfinite(block.degrees_of_freedom):
            own /= np.sqrt(drawn.chisquare(block.degrees_of_freedom, count) / block.degrees_of_freedom)[:, None]
        errors[:, list(block.places)] = own
    return errors
