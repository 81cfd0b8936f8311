"""What a study is: a scenario, what varies in it and how, and which cases follow from that."""

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import special

from cutwise.io.revision import Value
from cutwise.spec.scenario import Scenario
from cutwise.study.many import draws
from cutwise.study.many.distributions import Distribution

FloatArray = NDArray[np.float64]

GRID, MONTE_CARLO, HYPERCUBE, SOBOL, INDICES, MORRIS, OPTIMISE, RARE = (
    "grid", "monte_carlo", "latin_hypercube", "sobol", "indices", "morris", "optimise", "rare",
)  # fmt: skip
METHODS = (GRID, MONTE_CARLO, HYPERCUBE, SOBOL, INDICES, MORRIS, OPTIMISE, RARE)
SEARCHES = (OPTIMISE, RARE)
"""Methods whose cases follow from those before."""


_LEAST = 2.0**-53


class Design(NamedTuple):
    """A lever that is set: every combination of such values is studied."""

    values: tuple[Value, ...]  # SI, or words


class Random(NamedTuple):
    """A lever that scatters."""

    distribution: Distribution
    added: float = 0.0  # the lever's own value, where the distribution tells how far off it is [SI]
    words: tuple[Value, ...] = ()  # what the numbers 0, 1, ... of a choice stand for
    curve: bool = False  # a curve along the edge, another in each case: its values are numbers of curves

    def of(self, u: FloatArray) -> list[Value]:
        """Values at shares u of the distribution."""
        numbers = self.distribution.quantile(u) + self.added
        return [self.words[int(x)] for x in numbers] if self.words else numbers.tolist()


class Correlated(NamedTuple):
    """Inputs that go together: their normal scores have a correlation."""

    keys: tuple[str, ...]
    correlation: tuple[tuple[float, ...], ...]


class Between(NamedTuple):
    """A lever of an optimisation [SI]: any value, any whole number, or one of some words or numbers."""

    low: float
    high: float
    whole: bool = False
    words: tuple[Value, ...] = ()  # what the whole numbers from 0 on stand for

    def value(self, x: float) -> Value:
        """What a scenario takes."""
        return self.words[round(x)] if self.words else round(x) if self.whole else float(x)


class Aim(NamedTuple):
    """What is to be large or small: a measure, a lever, or a cost of both."""

    text: str
    sign: float  # 1: to be made small, -1: large


class Search(NamedTuple):
    """What an optimisation looks for."""

    between: Mapping[str, Between]
    aims: tuple[Aim, ...]
    probability: tuple[float, ...] = ()  # least shares of good cases, one optimum for each; none: nothing scatters
    runs: int | None = None  # the most settings that may be tried
    points: int = 9  # of a Pareto front


class Stop(NamedTuple):
    """When a study is precise enough."""

    half_width: float
    level: float = 0.95
    at_least: int = 1024


class Budget(NamedTuple):
    """What one call may spend; None: no end."""

    cases: int | None = None
    seconds: float | None = None


class Study(NamedTuple):
    """A study, checked."""

    name: str
    scenario: Scenario
    coarse: Scenario | None  # the same with the larger step of the bulk of the cases; None: as the study step goes
    design: Mapping[str, Design]
    random: Mapping[str, Random]
    method: str
    draws: int  # cases at each combination of design levers
    seed: int
    measures: tuple[str, ...]
    demanded: float | None  # least share of good cases
    stop: Stop | None
    levels: int = 4  # of Morris' grid
    source: str = ""  # file of the scenario
    given: tuple[str, ...] = ()  # values that replace those of the file, as key=value
    correlated: tuple[Correlated, ...] = ()
    search: Search | None = None
    budget: Budget | None = None
    indices: int = 0  # rows of runs that tell what decides, beside the cases

    @property
    def factors(self) -> tuple[tuple[int, ...], ...]:
        """Places of the random inputs that move as one: those that are correlated, and each of the others."""
        keys = list(self.random)
        groups = {key: group for group in self.correlated for key in group.keys}
        found: list[tuple[int, ...]] = []
        for place, key in enumerate(keys):
            one = tuple(keys.index(name) for name in groups[key].keys) if key in groups else (place,)
            if one not in found:
                found.append(one)
        return tuple(found)

    @property
    def factor_names(self) -> tuple[str, ...]:
        """Keys of each factor, joined by a plus."""
        keys = list(self.random)
        return tuple("+".join(keys[place] for place in factor) for factor in self.factors)

    @property
    def keys(self) -> tuple[str, ...]:
        """All levers, in the order of their columns."""
        return (*self.design, *self.random)

    @property
    def combinations(self) -> int:
        """Of design levers."""
        return int(np.prod([len(lever.values) for lever in self.design.values()], dtype=int))

    @property
    def rows(self) -> int:
        """Draws, or runs that belong to them: a row of indices or a trajectory has several."""
        more = {INDICES: len(self.factors) + 2, MORRIS: len(self.random) + 1}
        return self.draws * more.get(self.method, 1)

    @property
    def cases(self) -> int:
        """All runs."""
        return self.rows * self.combinations


def points(study: Study, first: int, count: int) -> FloatArray:
    """Shares in (0, 1) of every random input in some rows, shape (count, inputs); the correlated ones go together."""
    return correlated(study, _apart(study, first, count))


def _apart(study: Study, first: int, count: int) -> FloatArray:
    """Independent shares."""
    inputs, seed = len(study.random), study.seed
    if not inputs:
        return np.zeros((count, 0))
    if study.method == MONTE_CARLO:
        return draws.uniforms(seed, inputs, first, count)
    if study.method in (HYPERCUBE, MORRIS):
        return _whole(study.method, inputs, study.draws, study.levels, seed)[first : first + count]
    if study.method == INDICES:
        each = len(study.factors) + 2
        low, high = first // each, (first + count - 1) // each + 1
        both = draws.net_points(seed, 2 * inputs, 0, low, high - low)
        return mixed(both[:, :inputs], both[:, inputs:], study.factors)[first - low * each :][:count]
    return draws.shifted_nets(seed, inputs, first, count)


def correlated(study: Study, u: FloatArray) -> FloatArray:
    r"""Shares whose normal scores are correlated, of independent ones; shape (count, inputs).

    .. math:: u' = \Phi(L \Phi^{-1}(u)), \qquad L L^T = R

    The margins stay uniform (normal copula). An input that depends on none before it keeps its bits.
    """
    found, keys = u.copy(), list(study.random)
    for group in study.correlated:
        at = [keys.index(key) for key in group.keys]
        root = np.linalg.cholesky(np.array(group.correlation))
        z = special.ndtri(u[:, at])
        for i, place in enumerate(at):
            if root[i, :i].any():
                score = sum(root[i, k] * z[:, k] for k in range(i + 1))  # the same sum for any number of rows
                found[:, place] = np.clip(special.ndtr(score), _LEAST, 1.0 - _LEAST)
    return found


@lru_cache(maxsize=4)
def _whole(method: str, inputs: int, count: int, levels: int, seed: int) -> FloatArray:
    """All points of a plan that is made as a whole."""
    if method == MORRIS:
        return trajectories(inputs, count, levels, draws.generator(seed, draws.MORRIS))[0]
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(inputs, rng=draws.generator(seed, draws.HYPERCUBE)).random(count))


def mixed(a: FloatArray, b: FloatArray, factors: Sequence[Sequence[int]] | None = None) -> FloatArray:
    """Rows A, B, and A with each factor of B in turn, one after another for each point; shape (n (d + 2), inputs).

    A factor is one column, or several that move together.
    """
    count, inputs = a.shape
    each = [(i,) for i in range(inputs)] if factors is None else factors
    found = np.repeat(a[:, None, :], len(each) + 2, axis=1)
    found[:, 1] = b
    for i, columns_of in enumerate(each):
        for j in columns_of:
            found[:, 2 + i, j] = b[:, j]
    return found.reshape(count * (len(each) + 2), inputs)


def trajectories(
    inputs: int, count: int, levels: int, rng: np.random.Generator
) -> tuple[FloatArray, NDArray[np.int64], FloatArray]:
    """Morris' walks: points, the input that each step turns, and how far; shapes (r (d + 1), d), (r, d), (r, d).

    The points are the middles of as many equal shares as there are levels, so that none is the end of a distribution;
    a step leads over half of the levels, which is half of all shares.
    """
    step = levels / (2.0 * (levels - 1.0))
    low = np.arange(levels // 2) / (levels - 1.0)
    start = rng.choice(low, size=(count, inputs))
    up = rng.integers(0, 2, size=(count, inputs)).astype(bool)
    order = np.array([rng.permutation(inputs) for _ in range(count)])
    found = np.repeat(np.where(up, start, start + step)[:, None, :], inputs + 1, axis=1)
    for r in range(count):
        for k, i in enumerate(order[r]):
            found[r, k + 1 :, i] = start[r, i] + (step if up[r, i] else 0.0)
    moved = np.where(np.take_along_axis(up, order, axis=1), 0.5, -0.5)  # in shares, as the points are
    inside = (found * (levels - 1.0) + 0.5) / levels
    return inside.reshape(-1, inputs), order, moved


def at_setting(study: Study, setting: Mapping[str, Value]) -> Study:
    """The study of what scatters about one setting of the levers of an optimisation."""
    random = {
        key: lever._replace(added=float(setting[key])) if key in setting else lever  # type: ignore[arg-type]
        for key, lever in study.random.items()
    }
    design = {key: Design((value,)) for key, value in setting.items() if key not in random}
    return study._replace(design=design, random=random, method=SOBOL if random else GRID, search=None)


def of_indices(study: Study) -> Study:
    """The study of the runs that tell what decides, of one that asks for them beside its cases."""
    return study._replace(method=INDICES, draws=study.indices, stop=None, demanded=None, indices=0)


def in_the_middle(study: Study) -> Study:
    """The study that an optimisation makes at the middle of all of its levers; any other study as it is."""
    if study.search is None:
        return study
    return at_setting(study, {key: one.value(0.5 * (one.low + one.high)) for key, one in study.search.between.items()})


def columns(study: Study, first: int, count: int) -> dict[str, list[Value]]:
    """The levers of some cases, in SI or as words; the last design lever goes fastest, draws slowest."""
    case = np.arange(first, first + count)
    row, combination = case // study.combinations, case % study.combinations
    found: dict[str, list[Value]] = {}
    rest = combination.copy()
    for key, lever in reversed(list(study.design.items())):
        found[key] = [lever.values[i] for i in rest % len(lever.values)]
        rest //= len(lever.values)
    found = dict(reversed(found.items()))
    if study.random:
        some = points(study, int(row[0]), int(row[-1] - row[0]) + 1)[row - row[0]]
        for j, (key, random) in enumerate(study.random.items()):
            found[key] = curves(study, j, row).tolist() if random.curve else random.of(some[:, j])
    return found


def curves(study: Study, place: int, row: NDArray[np.int64]) -> NDArray[np.int64]:
    """Numbers of the curves that an input has in some rows: that of the row; of indices, 2 n in A and 2 n + 1 in B."""
    if study.method != INDICES:
        return row
    each = len(study.factors) + 2
    own = next(i for i, factor in enumerate(study.factors) if place in factor)
    part = row % each
    return 2 * (row // each) + ((part == 1) | (part == own + 2))


def combinations(study: Study) -> Iterator[dict[str, Value]]:
    """Design levers of each combination."""
    for k in range(study.combinations):
        rest, found = k, {}
        for key, lever in reversed(list(study.design.items())):
            found[key] = lever.values[rest % len(lever.values)]
            rest //= len(lever.values)
        yield dict(reversed(found.items()))
