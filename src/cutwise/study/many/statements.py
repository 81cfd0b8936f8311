r"""What many cases say: a share with its interval, and how far each input decides.

Sources: Wilson 1927; Clopper, Pearson 1934; Saltelli et al. 2010, Comput. Phys. Commun. 181 (first-order indices);
Jansen 1999, Comput. Phys. Commun. 117 (total indices); Morris 1991, Technometrics 33.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import special

from cutwise.study.many.draws import BOOTSTRAP, NETS, generator, shuffled

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

_FEW = 10  # good or bad cases below which no interval but the exact one holds
_BOOTSTRAPS = 1000
_GROUPS = 4096  # of rows that are summed; a power of two
_NOTHING = 1e-14  # share of the mean square that is rounding


class Share(NamedTuple):
    """A share of all cases with its interval."""

    value: float
    low: float
    high: float

    @property
    def half_width(self) -> float:
        """Half of the width of the interval."""
        return 0.5 * (self.high - self.low)


def wilson(good: int, count: int, level: float = 0.95) -> Share:
    r"""Interval of a share of independent cases.

    .. math:: \frac{\hat p + z^2/2n \pm z\sqrt{\hat p(1-\hat p)/n + z^2/4n^2}}{1 + z^2/n}

    >>> [round(x, 6) for x in wilson(990, 1000)[1:]]
    [0.981691, 0.994559]
    """
    z, p = float(special.ndtri(0.5 + 0.5 * level)), good / count
    middle, room = p + z * z / (2 * count), z * math.sqrt(p * (1 - p) / count + z * z / (4 * count * count))
    whole = 1 + z * z / count
    return Share(p, max(0.0, (middle - room) / whole), min(1.0, (middle + room) / whole))


def clopper_pearson(good: int, count: int, level: float = 0.95) -> Share:
    """The interval that holds for any share, however few cases there are.

    >>> [round(x, 6) for x in clopper_pearson(0, 1000)]
    [0.0, 0.0, 0.003682]
    """
    tail = 0.5 * (1.0 - level)
    low = float(special.betaincinv(good, count - good + 1, tail)) if good else 0.0
    high = float(special.betaincinv(good + 1, count - good, 1.0 - tail)) if good < count else 1.0
    return Share(good / count, low, high)


def share_of(good: NDArray[np.bool_], *, nets: bool, level: float = 0.95) -> Share:
    """Share of good cases: from the scatter of the eight nets, or as independent cases; exact where there are few."""
    whole = nets and good.size > 0 and good.size % NETS == 0
    each = good.reshape(-1, NETS) if whole else good[:, None]
    return share_of_counts(each.sum(axis=0), np.full(each.shape[1], len(each)), nets=whole, level=level)


def share_of_counts(good: IntArray, ended: IntArray, *, nets: bool, level: float = 0.95) -> Share:
    """The same of the good cases and of all that ended in each net; shapes (nets,)."""
    count, hits = int(ended.sum()), int(good.sum())
    if count == 0:
        return Share(math.nan, 0.0, 1.0)
    if min(hits, count - hits) < _FEW:
        return clopper_pearson(hits, count, level)
    if not nets or len(good) != NETS:
        return wilson(hits, count, level)
    each = good / ended
    room = float(special.stdtrit(NETS - 1, 0.5 + 0.5 * level) * each.std(ddof=1) / math.sqrt(NETS))
    value = float(each.mean())
    return Share(value, max(0.0, value - room), min(1.0, value + room))


class Indices(NamedTuple):
    """Shares of the variance that each of d inputs decides alone and with others, with 95 % half-widths; shapes (d,)."""

    first: FloatArray
    total: FloatArray
    first_width: FloatArray
    total_width: FloatArray


class RowSums:
    r"""Sums over rows of f at A, B and A with column i of B, from which the indices and their scatter follow.

    .. math:: S_i = \overline{f_B (f_{A_i} - f_A)} / V, \qquad T_i = \overline{(f_A - f_{A_i})^2} / 2V

    Up to 4,096 rows each has sums of its own, so that drawing rows again (bootstrap) is drawing sums again; of more rows,
    each goes to one of as many groups, drawn at random: the sums of groups scatter as those of rows do.

    Parameters
    ----------
    rows : int
        All rows that will come.
    inputs : int
        Number d of inputs.
    mean : float
        Of f at A and B, taken off before anything is multiplied.
    """

    def __init__(self, rows: int, inputs: int, mean: float) -> None:
        self._all, self._d, self._mean, self._came = rows, inputs, mean, 0
        self._sums = np.zeros((min(rows, _GROUPS), 3 + 2 * inputs))  # rows, f, f^2 (A and B), first, total
        self._ends = math.inf, -math.inf

    def add(self, rows: FloatArray) -> None:
        """Add the next rows of f; shape (m, d + 2)."""
        few, d = rows - self._mean, self._d
        a, b, mixed = few[:, :1], few[:, 1:2], few[:, 2:]
        both = few[:, :2]
        low, high = self._ends
        self._ends = min(low, float(both.min())), max(high, float(both.max()))
        each = np.concatenate(
            [
                np.ones_like(a),
                both.sum(axis=1)[:, None],
                (both**2).sum(axis=1)[:, None],
                b * (mixed - a),
                (a - mixed) ** 2,
            ],
            axis=1,
        )
        group = np.arange(self._came, self._came + len(few))
        if self._all > len(self._sums):
            group = shuffled(group) % len(self._sums)
        for j in range(3 + 2 * d):
            self._sums[:, j] += np.bincount(group, each[:, j], len(self._sums))
        self._came += len(few)

    def indices(self, seed: int) -> Indices:
        """Indices with the scatter of 1,000 draws of rows."""
        rng, groups = generator(seed, BOOTSTRAP), len(self._sums)
        first, total = self._of(self._sums.sum(axis=0))
        weights = (np.bincount(rng.integers(0, groups, groups), minlength=groups) for _ in range(_BOOTSTRAPS))
        again = np.array([self._of(weight @ self._sums) for weight in weights])
        first_width, total_width = 1.96 * again.std(axis=0, ddof=1)
        return Indices(first, total, first_width, total_width)

    def _of(self, sums: FloatArray) -> FloatArray:
        count, mean, square = sums[0], sums[1] / (2.0 * sums[0]), sums[2] / (2.0 * sums[0])
        variance = square - mean * mean
        if self._ends[0] == self._ends[1] or variance <= _NOTHING * square:  # all alike
            return np.zeros((2, self._d))
        parts = sums[3:].reshape(2, self._d) / count
        return np.asarray(parts * np.array([[1.0], [0.5]]) / variance)


def sobol_indices(rows: FloatArray, seed: int) -> Indices:
    """Indices from n rows of f at A, B and A with column i of B; shape (n, d + 2). See :class:`RowSums`."""
    sums = RowSums(len(rows), rows.shape[1] - 2, float(rows[:, :2].mean()))
    sums.add(rows)
    return sums.indices(seed)


class Effects(NamedTuple):
    """Elementary effects of each of d inputs over a whole range; shapes (d,)."""

    strength: FloatArray  # mean of magnitudes, mu*
    mean: FloatArray
    deviation: FloatArray


def elementary_effects(before: FloatArray, after: FloatArray, step: FloatArray) -> Effects:
    """Of r trajectories and d inputs: f before and after the step of each input, and that step; shapes (r, d)."""
    effect = (after - before) / step
    spread = effect.std(axis=0, ddof=1) if len(effect) > 1 else np.full(effect.shape[1], np.nan)
    return Effects(np.abs(effect).mean(axis=0), effect.mean(axis=0), spread)
