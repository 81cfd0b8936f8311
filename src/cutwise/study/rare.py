r"""Rare failures by subset simulation: a small probability as a product of larger ones.

.. math:: P(g > 0) = \prod_i P(g > t_{i+1} \mid g > t_i), \qquad t_0 = -\infty < t_1 < \dots \le 0

in a space of independent standard normal numbers. Each level starts from the worst tenth of the one before; its chains
propose :math:`z' = \sqrt{1 - \sigma^2}\, z + \sigma \xi` and stay where :math:`g(z')` falls below the threshold.

Sources: Au, Beck 2001, Probab. Eng. Mech. 16 (subset simulation, coefficient of variation); Papaioannou et al. 2015,
Probab. Eng. Mech. 41 (conditional sampling with adaptive spread).
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SHARE = 0.1
"""Of the cases of a level, the worst of which the next begins at."""

_SPREAD = 0.6  # of proposals at first, in deviations of the seeds
_ACCEPTED = 0.44  # share of proposals that the spread is led to
_Z = 1.96
_FEWEST = 10  # chains of a level
_LEVELS = 40  # beyond which 1e-40 is not worth the name of a probability


class Level(NamedTuple):
    """One level of subset simulation."""

    threshold: float  # margin that its cases exceed
    share: float  # of them that exceed the next
    cov: float  # coefficient of variation of that share
    accepted: float  # share of proposals; 1 at first


class Rare(NamedTuple):
    """A small probability."""

    probability: float
    cov: float  # coefficient of variation
    levels: tuple[Level, ...]
    runs: int
    z: FloatArray  # of the last level, shape (n, d)
    margin: FloatArray  # shape (n,)

    @property
    def low(self) -> float:
        """Lower end of the interval: it covers about 90 % (the levels are taken as independent)."""
        return self.probability * math.exp(-self._room)

    @property
    def high(self) -> float:
        """Upper end."""
        return min(1.0, self.probability * math.exp(self._room))

    @property
    def _room(self) -> float:
        return _Z * math.sqrt(math.log1p(self.cov**2))


class Flat(Exception):
    """The margin does not rise from level to level: the worst cases are all equally bad, and none of them is bad enough."""


def subset_simulation(
    margins: Callable[[FloatArray], FloatArray], dimensions: int, *, count: int = 2000,
    rng: Callable[[int], np.random.Generator], levels: list[Level] | None = None,
) -> Rare:  # fmt: skip
    """Probability that a margin is above 0.

    Parameters
    ----------
    margins : callable
        From points in standard normal space, shape (m, d), to how far each is beyond its limits, shape (m,).
    dimensions : int
        Number d of inputs.
    count : int
        Cases n of a level, a multiple of ten.
    rng : callable
        Random numbers of a level.
    levels : list, optional
        Filled with the levels as they end, for a caller whose ``margins`` may stop.

    Raises
    ------
    Flat
        The levels lead nowhere.

    Notes
    -----
    Of chains that are correlated, the told coefficient of variation is 10 to 20 % small (levels are taken as
    independent); where failures lie in all directions of many inputs the mean is low, too (a sphere in 20 inputs at
    7e-6, 1000 cases a level: 0.84 of it, covered by 84 %). A second region of failures that few cases of the first
    levels lie near may be missed: more cases of a level find it.
    """
    seeds = begun = round(SHARE * count)
    z = rng(0).standard_normal((count, dimensions))
    g = margins(z)
    levels = [] if levels is None else levels
    probability, threshold, runs, accepted, spread = 1.0, -math.inf, count, 1.0, _SPREAD
    while len(levels) < _LEVELS:
        following = _following(g, seeds)
        last = following >= 0.0 or bool((g > 0.0).sum() >= seeds)
        ends = 0.0 if last else float(following)
        chains = None if not levels else begun
        share = float((g > ends).mean())
        levels.append(Level(threshold, share, _cov(g > ends, chains), accepted))
        probability *= share
        if last:
            return Rare(probability, math.sqrt(sum(one.cov**2 for one in levels)), tuple(levels), runs, z, g)
        if share == 0.0 or not ends > threshold:
            break
        threshold, more = ends, rng(len(levels))
        first = np.argsort(-g, kind="stable")[: (g > threshold).sum()]
        begun = next(size for size in range(min(seeds, first.size), 0, -1) if count % size == 0)
        if begun < _FEWEST:
            break
        if begun < first.size:  # more than begin a chain: any of them, else the level would begin at the worst
            first = more.choice(first, begun, replace=False)
        z, g, accepted, spread = _conditional(margins, z[first], g[first], threshold, count, more, spread)
        runs += count - begun
    raise Flat


def _following(g: FloatArray, seeds: int) -> float:
    """The margin that about so many cases exceed: between two that differ, for a case on a threshold is not beyond it.

    Chains that stay where they are repeat their margins, and some margins are the same for many cases; then a few more
    exceed it, or fewer where that would be most of all.
    """
    falling = np.sort(g)[::-1]
    tie = falling[seeds]
    if falling[seeds - 1] > tie:
        return float(0.5 * (falling[seeds - 1] + tie))
    lower = falling[falling < tie]
    return float(0.5 * (tie + lower[0]) if 2 * lower.size > g.size else tie)


def _conditional(
    margins: Callable[[FloatArray], FloatArray], z: FloatArray, g: FloatArray, threshold: float, count: int,
    rng: np.random.Generator, spread: float,
) -> tuple[FloatArray, FloatArray, float, float]:  # fmt: skip
    """Cases beyond a threshold: one chain from each seed, all of them one step at a time; chains follow one another."""
    chains = len(z)
    deviation = z.std(axis=0, ddof=1)
    all_z, all_g, kept, steps = [z], [g], 0, count // chains - 1
    order = rng.permutation(chains)  # which seed begins which chain does not follow from how bad it is
    z, g = z[order], g[order]
    all_z, all_g = [z], [g]
    for batch in range(1, steps + 1):
        sigma = np.minimum(1.0, spread * deviation)
        proposed = np.sqrt(1.0 - sigma**2) * z + sigma * rng.standard_normal(z.shape)
        found = margins(proposed)
        taken = found > threshold
        z, g = np.where(taken[:, None], proposed, z), np.where(taken, found, g)
        all_z.append(z)
        all_g.append(g)
        kept += int(taken.sum())
        spread *= math.exp((float(taken.mean()) - _ACCEPTED) / math.sqrt(batch))
    return np.concatenate(all_z), np.concatenate(all_g), kept / (steps * chains), spread


def _cov(beyond: NDArray[np.bool_], chains: int | None) -> float:
    """Coefficient of variation of a share; of chains with the correlation along them (Au, Beck 2001, Eqs. 28 to 30)."""
    count, p = beyond.size, float(beyond.mean())
    if p in (0.0, 1.0):
        return 0.0 if p == 1.0 else math.inf
    gamma = 0.0
    if chains is not None:
        steps = beyond.reshape(-1, chains).astype(float)  # a row a step, a column a chain
        for lag in range(1, len(steps)):
            together = float((steps[:-lag] * steps[lag:]).mean()) - p * p
            gamma += 2.0 * (1.0 - lag / len(steps)) * together / (p * (1.0 - p))
    return math.sqrt((1.0 - p) / (p * count) * max(0.0, 1.0 + gamma))
