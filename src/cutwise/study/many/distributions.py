"""How an input scatters: quantiles of distributions, truncated where asked for. Values are in the unit of the key, SI."""

import math
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import special

FloatArray = NDArray[np.float64]

_STEP = 1e-12  # share of all values that are one and the same
_MOST = 1.0 - 2.0**-53  # a share that is rounded to 1 would be at infinity


class Distribution(Protocol):
    """A distribution of a number."""

    def quantile(self, u: FloatArray) -> FloatArray:
        """The values below which shares u of all lie."""

    def share_below(self, x: float) -> float:
        """The share of all values below x."""


class Normal(NamedTuple):
    """Normal scatter about a mean."""

    mean: float
    deviation: float

    def quantile(self, u: FloatArray) -> FloatArray:
        return np.asarray(self.mean + self.deviation * special.ndtri(u))

    def share_below(self, x: float) -> float:
        return _step(x - self.mean) if self.deviation == 0.0 else float(special.ndtr((x - self.mean) / self.deviation))


class LogNormal(NamedTuple):
    """A positive value whose logarithm scatters normally."""

    median: float
    log_deviation: float

    def quantile(self, u: FloatArray) -> FloatArray:
        return np.asarray(self.median * np.exp(self.log_deviation * special.ndtri(u)))

    def share_below(self, x: float) -> float:
        if x <= 0.0:
            return 0.0
        far = math.log(x / self.median)
        return _step(far) if self.log_deviation == 0.0 else float(special.ndtr(far / self.log_deviation))


class Reciprocal(NamedTuple):
    """A positive value whose reciprocal scatters normally; it falls as that rises."""

    mean: float  # of the reciprocal
    deviation: float

    def quantile(self, u: FloatArray) -> FloatArray:
        return np.asarray(1.0 / (self.mean - self.deviation * special.ndtri(u)))

    def share_below(self, x: float) -> float:
        of = Normal(self.mean, self.deviation)
        below = of.share_below(0.0)  # where the value is negative
        if x == 0.0:
            return below
        return below - of.share_below(1.0 / x) if x < 0.0 else below + 1.0 - of.share_below(1.0 / x)


class Uniform(NamedTuple):
    """Any value between two ends, none more likely."""

    low: float
    high: float

    def quantile(self, u: FloatArray) -> FloatArray:
        return np.asarray(self.low + (self.high - self.low) * u)

    def share_below(self, x: float) -> float:
        if self.high == self.low:
            return _step(x - self.low)
        return min(1.0, max(0.0, (x - self.low) / (self.high - self.low)))


class Triangular(NamedTuple):
    """Between two ends, most likely at the mode."""

    low: float
    mode: float
    high: float

    def quantile(self, u: FloatArray) -> FloatArray:
        span, left = self.high - self.low, self.mode - self.low
        if span == 0.0:
            return np.full_like(u, self.low)
        rising = self.low + np.sqrt(u * span * left)
        falling = self.high - np.sqrt((1.0 - u) * span * (span - left))
        return np.asarray(np.where(u < left / span, rising, falling))

    def share_below(self, x: float) -> float:
        if self.high == self.low:
            return _step(x - self.low)
        if x <= self.low or x >= self.high:
            return 0.0 if x <= self.low else 1.0
        span = self.high - self.low
        if x < self.mode:
            return (x - self.low) ** 2 / (span * (self.mode - self.low))
        return 1.0 - (self.high - x) ** 2 / (span * (self.high - self.mode))


class Empirical(NamedTuple):
    """Values that were measured, each as likely as its weight says: the inverse of the step distribution."""

    values: tuple[float, ...]  # rising
    shares: tuple[float, ...]  # of all values up to and with each, the last 1

    def quantile(self, u: FloatArray) -> FloatArray:
        at = np.minimum(np.searchsorted(self.shares, u, side="left"), len(self.values) - 1)
        return np.asarray(self.values, float)[at]

    def share_below(self, x: float) -> float:
        count = int(np.searchsorted(self.values, x, side="left"))
        return self.shares[count - 1] if count else 0.0


class Truncated(NamedTuple):
    """The part of a distribution between two ends; what lies beyond is drawn again, not moved to the ends."""

    whole: Distribution
    low: float
    high: float

    @property
    def ends(self) -> tuple[float, float]:
        """The shares of the whole below its ends; a value on the upper end itself is inside."""
        last, after = self.whole.share_below(self.high), self.whole.share_below(math.nextafter(self.high, math.inf))
        return self.whole.share_below(self.low), after if after - last > _STEP else last

    @property
    def share(self) -> float:
        """The share of the whole that lies between the ends."""
        first, last = self.ends
        return last - first

    def quantile(self, u: FloatArray) -> FloatArray:
        first, last = self.ends
        inside = self.whole.quantile(np.minimum(first + u * (last - first), _MOST))
        return np.asarray(np.clip(inside, self.low, self.high))  # rounding alone leads beyond

    def share_below(self, x: float) -> float:
        first, last = self.ends
        return min(1.0, max(0.0, (self.whole.share_below(x) - first) / (last - first)))


def empirical(values: FloatArray, weights: FloatArray | None = None) -> Empirical:
    """The distribution of measured values."""
    order = np.argsort(values, kind="stable")
    weight = np.ones(len(values)) if weights is None else np.asarray(weights, float)
    shares = np.cumsum(weight[order]) / weight.sum()
    shares[-1] = 1.0
    return Empirical(tuple(np.asarray(values, float)[order].tolist()), tuple(shares.tolist()))


def _step(x: float) -> float:
    return 1.0 if x > 0.0 else 0.0
