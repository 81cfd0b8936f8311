"""What a study is: a scenario, what varies in it and how, and which cases follow from that."""

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from cutwise.io.revision import Value
from cutwise.spec.scenario import Scenario
from cutwise.study.many import draws
from cutwise.study.many.distributions import Distribution

FloatArray = NDArray[np.float64]

GRID, MONTE_CARLO, HYPERCUBE, SOBOL, INDICES, MORRIS = (
    "grid", "monte_carlo", "latin_hypercube", "sobol", "indices", "morris",
)  # fmt: skip
METHODS = (GRID, MONTE_CARLO, HYPERCUBE, SOBOL, INDICES, MORRIS)


class Design(NamedTuple):
    """A lever that is set: every combination of such values is studied."""

    values: tuple[Value, ...]  # SI, or words


class Random(NamedTuple):
    """A lever that scatters."""

    distribution: Distribution
    added: float = 0.0  # the lever's own value, where the distribution tells how far off it is [SI]
    words: tuple[Value, ...] = ()  # what the numbers 0, 1, ... of a choice stand for

    def of(self, u: FloatArray) -> list[Value]:
        """Values at shares u of the distribution."""
        numbers = self.distribution.quantile(u) + self.added
        return [self.words[int(x)] for x in numbers] if self.words else numbers.tolist()


class Stop(NamedTuple):
    """When a study is precise enough."""

    half_width: float
    level: float = 0.95
    at_least: int = 1024


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
        more = {INDICES: len(self.random) + 2, MORRIS: len(self.random) + 1}
        return self.draws * more.get(self.method, 1)

    @property
    def cases(self) -> int:
        """All runs."""
        return self.rows * self.combinations


def points(study: Study, first: int, count: int) -> FloatArray:
    """Shares in (0, 1) of every random input in some rows, shape (count, inputs)."""
    inputs, seed = len(study.random), study.seed
    if not inputs:
        return np.zeros((count, 0))
    if study.method == MONTE_CARLO:
        return draws.uniforms(seed, inputs, first, count)
    if study.method in (HYPERCUBE, MORRIS):
        return _whole(study.method, inputs, study.draws, study.levels, seed)[first : first + count]
    if study.method == INDICES:
        low, high = first // (inputs + 2), (first + count - 1) // (inputs + 2) + 1
        both = draws.net_points(seed, 2 * inputs, 0, low, high - low)
        return mixed(both[:, :inputs], both[:, inputs:])[first - low * (inputs + 2) :][:count]
    return draws.shifted_nets(seed, inputs, first, count)


@lru_cache(maxsize=4)
def _whole(method: str, inputs: int, count: int, levels: int, seed: int) -> FloatArray:
    """All points of a plan that is made as a whole."""
    if method == MORRIS:
        return trajectories(inputs, count, levels, draws.generator(seed, draws.MORRIS))[0]
    return np.asarray(qmc.LatinHypercube(inputs, rng=draws.generator(seed, draws.HYPERCUBE)).random(count))


def mixed(a: FloatArray, b: FloatArray) -> FloatArray:
    """Rows A, B, and A with each column of B in turn, one after another for each point; shape (n (d + 2), d)."""
    count, inputs = a.shape
    found = np.repeat(a[:, None, :], inputs + 2, axis=1)
    found[:, 1] = b
    for i in range(inputs):
        found[:, 2 + i, i] = b[:, i]
    return found.reshape(count * (inputs + 2), inputs)


def trajectories(
    inputs: int, count: int, levels: int, rng: np.random.Generator
) -> tuple[FloatArray, NDArray[np.int64], FloatArray]:
    """Morris' walks: points, the input that each step turns, and how far; shapes (r (d + 1), d), (r, d), (r, d).

    The step is levels / (2 (levels - 1)); a start lies where every step stays within the levels.
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
    moved = np.where(np.take_along_axis(up, order, axis=1), step, -step)
    inside = (found * (levels - 1.0) + 0.5) / levels  # the middles of as many equal shares: no end of a distribution
    return inside.reshape(-1, inputs), order, moved


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
            found[key] = random.of(some[:, j])
    return found


def combinations(study: Study) -> Iterator[dict[str, Value]]:
    """Design levers of each combination."""
    for k in range(study.combinations):
        rest, found = k, {}
        for key, lever in reversed(list(study.design.items())):
            found[key] = lever.values[rest % len(lever.values)]
            rest //= len(lever.values)
        yield dict(reversed(found.items()))
