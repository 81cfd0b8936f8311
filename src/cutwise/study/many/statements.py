r"""What many cases say: a share with its interval, and how far each input decides.

Sources: Wilson 1927; Clopper, Pearson 1934; Saltelli et al. 2010, Comput. Phys. Commun. 181 (first-order indices);
Jansen 1999, Comput. Phys. Commun. 117 (total indices); Morris 1991, Technometrics 33.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import special, stats

from cutwise.study.many.draws import BOOTSTRAP, NETS, generator

FloatArray = NDArray[np.float64]

_FEW = 10  # good or bad cases below which no interval but the exact one holds
_BOOTSTRAPS = 1000


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
    count, hits = good.size, int(good.sum())
    if count == 0:
        return Share(math.nan, 0.0, 1.0)
    if min(hits, count - hits) < _FEW:
        return clopper_pearson(hits, count, level)
    if not nets or count % NETS:
        return wilson(hits, count, level)
    each = good.reshape(-1, NETS).mean(axis=0)
    room = float(stats.t.ppf(0.5 + 0.5 * level, NETS - 1) * each.std(ddof=1) / math.sqrt(NETS))
    value = float(each.mean())
    return Share(value, max(0.0, value - room), min(1.0, value + room))


class Indices(NamedTuple):
    """Shares of the variance that each of d inputs decides alone and with others, with 95 % half-widths; shapes (d,)."""

    first: FloatArray
    total: FloatArray
    first_width: FloatArray
    total_width: FloatArray


def sobol_indices(rows: FloatArray, seed: int) -> Indices:
    r"""Indices from n rows of f at A, B and A with column i of B; shape (n, d + 2).

    .. math:: S_i = \overline{f_B (f_{A_i} - f_A)} / V, \qquad T_i = \overline{(f_A - f_{A_i})^2} / 2V
    """
    rows = rows - rows[:, :2].mean()

    def both(some: FloatArray) -> FloatArray:
        a, b, mixed = some[:, :1], some[:, 1:2], some[:, 2:]
        variance = some[:, :2].var()
        if variance == 0.0:
            return np.zeros((2, mixed.shape[1]))
        return np.array([(b * (mixed - a)).mean(axis=0), 0.5 * ((a - mixed) ** 2).mean(axis=0)]) / variance

    rng = generator(seed, BOOTSTRAP)
    again = np.array([both(rows[rng.integers(0, len(rows), len(rows))]) for _ in range(_BOOTSTRAPS)])
    (first, total), (first_width, total_width) = both(rows), 1.96 * again.std(axis=0, ddof=1)
    return Indices(first, total, first_width, total_width)


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
