r"""The best setting under limits: scattered starts, then a local search that models aim and limits (COBYQA).

.. math:: \min_x f(x) \quad\text{with}\quad g_i(x) \le 0, \qquad x_\mathrm{low} \le x \le x_\mathrm{high}

Starts are Sobol points; the local search goes on from the best few. Levers that are whole numbers or words are looked
through by differential evolution first where there are many of them. Every number follows from the function and the seed.

Sources: Ragonneau 2022, thesis, Hong Kong Polytechnic University (COBYQA); Storn, Price 1997, J. Global Optim. 11
(differential evolution); Deb 2000, Comput. Methods Appl. Mech. Eng. 186 (what misses a limit ranks behind what does not).
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import optimize
from scipy.stats import qmc

FloatArray = NDArray[np.float64]
Point = tuple[float, ...]

_MARGIN_LOST = 1.0  # of a point at which the function says nothing
_FINEST = 1e-5  # of the range of a lever: where a local search ends
_AGAIN = 2e-3  # and how near to the best of all the last one begins
_LOCAL = 150  # calls of a local search
_FEW = 16  # combinations of whole levers that are all started from
_GENERATIONS, _POPULATION = 12, 24


class Seen(NamedTuple):
    """What a function says at a point."""

    values: tuple[float, ...]  # of the aims, each to be made small; NaN where there is none
    margins: tuple[float, ...]  # above 0: a limit is not kept
    more: Any = None  # whatever the caller wants to have back


class Range(NamedTuple):
    """The values of a lever."""

    low: float
    high: float
    whole: bool = False


class Problem(NamedTuple):
    """One view of what is seen: what is to be small, and what must not be above 0."""

    value: Callable[[Seen], float]
    margins: Callable[[Seen], Sequence[float]]


FIRST = Problem(lambda seen: seen.values[0], lambda seen: seen.margins)


class Found(NamedTuple):
    """The best point of a problem."""

    at: Point
    seen: Seen
    value: float
    margin: float  # the largest; 0 or below: all limits are kept

    @property
    def met(self) -> bool:
        """Whether all limits are kept."""
        return self.margin <= 0.0


class Spent(Exception):
    """As many calls as were allowed have been made."""


class Seeker:
    """Looks for best points of one function, whose calls are kept.

    Parameters
    ----------
    function : callable
        From points (n, d) to what is seen at each, in order.
    ranges : sequence of Range
        Of each coordinate.
    starts, best : int
        Scattered points, and how many of them a local search begins at.
    rng : numpy.random.Generator
        Of shifts and of differential evolution.
    calls : int, optional
        The most points the function is asked for.
    """

    def __init__(
        self, function: Callable[[Sequence[Point]], Sequence[Seen]], ranges: Sequence[Range], *, starts: int = 64,
        best: int = 4, rng: np.random.Generator | None = None, calls: int | None = None,
    ) -> None:  # fmt: skip
        self.ranges, self.starts, self.best, self.most = tuple(ranges), starts, best, calls
        self._function, self._rng = function, np.random.default_rng(0) if rng is None else rng
        self.seen: dict[Point, Seen] = {}

    @property
    def calls(self) -> int:
        """Points that were asked for."""
        return len(self.seen)

    def ask(self, points: Iterable[Point]) -> list[Seen]:
        """What is seen at some points; each is asked for once."""
        points = [self._rounded(x) for x in points]
        new = [x for x in dict.fromkeys(points) if x not in self.seen]
        room = len(new) if self.most is None else max(0, self.most - self.calls)
        for x, seen in zip(new[:room], self._function(new[:room]) if new[:room] else (), strict=True):
            self.seen[x] = seen
        if room < len(new):
            raise Spent
        return [self.seen[x] for x in points]

    def solve(self, problem: Problem = FIRST, near: Sequence[Point] = ()) -> Found:
        """The best point; from ``near`` alone where that is given, with what has been seen before.

        Where the calls are spent, the best of those that were made.
        """
        with suppress(Spent):
            starts = [self._rounded(x) for x in near] if near else self._scattered(problem)
            self.ask(starts)  # of whole levers alone, no search asks for them
            for x in starts:
                self._locally(problem, x, 0.05 if near else self._apart())
            if starts:
                self._locally(problem, min((self.judged(problem, x) for x in self.seen), key=_rank).at, _AGAIN)
        if not self.seen:
            raise ValueError("no point was asked for")
        return min((self.judged(problem, x) for x in self.seen), key=_rank)

    def judged(self, problem: Problem, x: Point) -> Found:
        """A point that was seen, as a problem sees it."""
        seen = self.seen[x]
        value = problem.value(seen)
        margin = max(problem.margins(seen), default=-math.inf)
        return Found(x, seen, value, max(margin, _MARGIN_LOST) if math.isnan(value) else float(margin))

    def _rounded(self, x: Sequence[float]) -> Point:
        inside = (min(max(float(v), r.low), r.high) for v, r in zip(x, self.ranges, strict=True))
        return tuple(float(round(v)) if r.whole else v for v, r in zip(inside, self.ranges, strict=True))

    def _apart(self) -> float:
        """Distance of scattered points, in shares of the ranges."""
        smooth = sum(not r.whole for r in self.ranges) or 1
        return float(min(0.25, self.starts ** (-1.0 / smooth)))

    def _scattered(self, problem: Problem) -> list[Point]:
        """Where local searches begin."""
        whole = [i for i, r in enumerate(self.ranges) if r.whole]
        combinations = math.prod(int(self.ranges[i].high - self.ranges[i].low) + 1 for i in whole)
        if combinations > max(_FEW, self.starts if len(whole) == len(self.ranges) else 0):
            self._evolved(problem)
        else:
            spans = (range(int(self.ranges[i].low), int(self.ranges[i].high) + 1) for i in whole)
            each = list(product(*spans))
            points = self._sobol(-(-self.starts // len(each)))
            self.ask([self._filled(x, dict(zip(whole, values, strict=True))) for x in points for values in each])
        if len(whole) == len(self.ranges):
            return []  # all that there is, or what evolution came to
        ranked = sorted((self.judged(problem, x) for x in self.seen), key=_rank)
        return [one.at for one in ranked[: self.best]]

    def _filled(self, x: Sequence[float], fixed: Mapping[int, float]) -> Point:
        return tuple(float(fixed.get(i, v)) for i, v in enumerate(x))

    def _sobol(self, count: int) -> FloatArray:
        """Scattered points, shifted so that none lies at an end."""
        low, high = (np.array([getattr(r, end) for r in self.ranges]) for end in ("low", "high"))
        net = qmc.Sobol(len(self.ranges), scramble=False, bits=30).random_base2(max(0, math.ceil(math.log2(count))))
        return np.asarray(low + (high - low) * ((net[:count] + self._rng.random(len(self.ranges))) % 1.0))

    def _locally(self, problem: Problem, start: Point, radius: float) -> None:
        """Search from a point on, with the whole levers as they are."""
        free = [i for i, r in enumerate(self.ranges) if not r.whole and r.high > r.low]
        if not free:
            return
        low, high = (np.array([getattr(self.ranges[i], end) for i in free]) for end in ("low", "high"))
        values = np.array([value for x in self.seen if math.isfinite(value := problem.value(self.seen[x]))])
        worst = float(values.max()) if values.size else 1.0
        size = float(np.ptp(values)) if values.size and np.ptp(values) > 0.0 else 1.0

        def at(u: FloatArray) -> Found:
            point = list(start)
            for i, v in zip(free, low + (high - low) * np.clip(u, 0.0, 1.0), strict=True):
                point[i] = float(v)
            self.ask([tuple(point)])
            return self.judged(problem, self._rounded(point))

        def objective(u: FloatArray) -> float:
            found = at(u)
            return (found.value if math.isfinite(found.value) else worst) / size

        def limits(u: FloatArray) -> FloatArray:
            found = at(u)
            lost = math.isnan(found.value)
            return np.array([max(m, _MARGIN_LOST) if lost else m for m in problem.margins(found.seen)] or [-1.0])

        u = (np.array([start[i] for i in free]) - low) / (high - low)
        optimize.minimize(
            objective, u, method="COBYQA", bounds=optimize.Bounds(np.zeros(len(free)), np.ones(len(free))),
            constraints=[optimize.NonlinearConstraint(limits, -np.inf, 0.0)],
            options={"initial_tr_radius": radius, "final_tr_radius": _FINEST, "maxfev": _LOCAL, "feasibility_tol": 0.0},
        )  # fmt: skip

    def _evolved(self, problem: Problem) -> None:
        """Look through whole levers and others together."""

        def one(x: FloatArray) -> tuple[float, float]:
            self.ask([tuple(x)])
            found = self.judged(problem, self._rounded(tuple(x)))
            return (found.value if math.isfinite(found.value) else math.inf, max(-1.0, found.margin))

        first = self._sobol(_POPULATION)
        self.ask([tuple(x) for x in first])
        optimize.differential_evolution(
            lambda x: min(one(x)[0], 1e300), [(r.low, r.high) for r in self.ranges],
            integrality=[r.whole for r in self.ranges],
            constraints=(optimize.NonlinearConstraint(lambda x: one(x)[1], -np.inf, 0.0),),
            init=first, maxiter=_GENERATIONS, polish=False, rng=self._rng, tol=1e-6,
        )  # fmt: skip


def _rank(found: Found) -> tuple[float, float]:
    """Points that keep their limits by value, before those that do not by margin."""
    if found.met:
        return (0.0, found.value)
    return (found.margin, found.value if math.isfinite(found.value) else math.inf)


def _second_below(seen: Seen, most: float, size: float) -> tuple[float, ...]:
    """The margins, and that of the second aim below a limit."""
    return (*seen.margins, (seen.values[1] - most) / size)


def front(seeker: Seeker, points: int) -> list[Found]:
    """What can be had of the second aim for how much of the first, best first aim first; none that another one beats.

    The ends are the optima of each aim alone; between them the second aim becomes a limit that is moved in steps, and
    each search begins where the one before ended (epsilon constraints: Haimes et al. 1971).
    """
    second = Problem(lambda seen: seen.values[1], lambda seen: seen.margins)
    ends = [seeker.solve(FIRST), seeker.solve(second)]
    if not ends[0].met:
        return ends[:1]
    found, (low, high) = list(ends), (ends[1].seen.values[1], ends[0].seen.values[1])
    size = abs(high - low) or 1.0
    near = ends[0].at
    for limit in np.linspace(high, low, points)[1:-1]:
        step = Problem(lambda seen: seen.values[0], partial(_second_below, most=float(limit), size=size))
        best = min((seeker.judged(step, x) for x in seeker.seen), key=_rank)
        one = seeker.solve(step, [*dict.fromkeys((near, best.at))])
        if one.met:
            found.append(one)
            near = one.at
    return _not_beaten(found)


def _not_beaten(found: Sequence[Found]) -> list[Found]:
    def beats(a: Found, b: Found) -> bool:
        pairs = list(zip(a.seen.values, b.seen.values, strict=True))
        return all(x <= y for x, y in pairs) and any(x < y for x, y in pairs)

    kept = {one.at: one for one in found if not any(beats(other, one) for other in found)}
    return sorted(kept.values(), key=lambda one: one.seen.values)


class Optimum(NamedTuple):
    """The best setting of a function."""

    settings: Mapping[str, float]
    value: float
    measures: Mapping[str, float]
    met: bool  # whether all requirements are kept; False: this comes nearest
    margin: float  # the largest distance beyond a limit, relative to the limit
    calls: int
    tried: tuple[tuple[Mapping[str, float], Mapping[str, float]], ...]  # every setting with its measures


def optimise(
    function: Callable[[Mapping[str, float]], Mapping[str, float]],
    ranges: Mapping[str, tuple[float, float]],
    requirements: Mapping[str, tuple[float | None, float | None]],
    aim: str | Callable[[Mapping[str, float], Mapping[str, float]], float],
    *,
    largest: bool = False,
    whole: Iterable[str] = (),
    starts: int = 64,
    best: int = 4,
    seed: int = 0,
    calls: int | None = None,
    near: Mapping[str, float] | None = None,
) -> Optimum:
    """The best setting of any function of numbers under limits on what it gives.

    Parameters
    ----------
    function : callable
        From settings by name to measures by name; one that is lacking or NaN misses its limits.
    ranges : mapping
        Lowest and highest value of each setting.
    requirements : mapping
        Least and largest value of measures; None: no limit. A distance is counted in the limit, or in 1 where it is 0.
    aim : str or callable
        The measure or setting that is to be small; or a function of settings and measures.
    largest : bool
        Make the aim large instead.
    whole : iterable of str
        Settings that are whole numbers.
    starts, best, seed, calls
        See :class:`Seeker`.
    near : mapping, optional
        Settings to begin at, instead of scattered ones.

    Examples
    --------
    The largest x + y in a circle of radius 2 is 2 sqrt 2:

    >>> found = optimise(lambda s: {"r": s["x"] ** 2 + s["y"] ** 2}, {"x": (0.0, 3.0), "y": (0.0, 3.0)},
    ...                  {"r": (None, 4.0)}, lambda s, m: s["x"] + s["y"], largest=True)
    >>> round(found.value, 4)
    2.8284
    """
    names, sign = list(ranges), -1.0 if largest else 1.0
    integers = frozenset(whole)

    def seen(x: Point) -> Seen:
        settings = dict(zip(names, x, strict=True))
        measures = function(settings)
        value = aim(settings, measures) if callable(aim) else {**settings, **measures}.get(aim, math.nan)
        margins = [
            _MARGIN_LOST if math.isnan(m := measures.get(name, math.nan)) else way * (m - end) / (abs(end) or 1.0)
            for name, ends in requirements.items()
            for end, way in zip(ends, (-1.0, 1.0), strict=True)
            if end is not None
        ]
        return Seen((sign * value,), tuple(margins), measures)

    seeker = Seeker(
        lambda points: [seen(x) for x in points],
        [Range(float(low), float(high), name in integers) for name, (low, high) in ranges.items()],
        starts=starts, best=best, rng=np.random.default_rng(seed), calls=calls,
    )  # fmt: skip
    begin = [tuple(float(near[name]) for name in names)] if near is not None else []
    found = seeker.solve(FIRST, begin)
    tried = tuple((dict(zip(names, x, strict=True)), one.more) for x, one in seeker.seen.items())
    return Optimum(
        dict(zip(names, found.at, strict=True)), sign * found.value, found.seen.more, found.met, found.margin,
        seeker.calls, tried,
    )  # fmt: skip
