"""The optimiser on problems whose best points are known in closed form, with limits, whole numbers, and two aims."""

import itertools
import math

import numpy as np
import pytest

from cutwise.study.optimum import Range, Seeker, Seen, front, optimise


def test_a_linear_aim_in_an_ellipse():
    """max a x + b y with x²/p² + y²/q² <= 1 is sqrt(a² p² + b² q²)."""
    a, b, p, q = 2.0, 0.7, 1.3, 3.1
    found = optimise(
        lambda s: {"r": (s["x"] / p) ** 2 + (s["y"] / q) ** 2}, {"x": (-2.0, 2.0), "y": (-4.0, 4.0)}, {"r": (None, 1.0)},
        lambda s, _: a * s["x"] + b * s["y"], largest=True,
    )  # fmt: skip
    assert found.met
    assert found.margin <= 0.0
    assert found.value == pytest.approx(math.hypot(a * p, b * q), rel=1e-4)
    assert found.calls == len(found.tried) < 250


def test_the_best_of_several_basins():
    """Six-hump camel: -1.031628 at two of its six minima; a local search alone would stop in any."""
    found = optimise(
        lambda s: {"f": (4 - 2.1 * s["x"] ** 2 + s["x"] ** 4 / 3) * s["x"] ** 2 + s["x"] * s["y"]
                   + 4 * (s["y"] ** 2 - 1) * s["y"] ** 2},
        {"x": (-3.0, 3.0), "y": (-2.0, 2.0)}, {}, "f",
    )  # fmt: skip
    assert found.value == pytest.approx(-1.0316284535, abs=1e-6)


def test_whole_numbers_and_others_together():
    """For n teeth, (n - 3.3)² + (x - n/5)² + |x - 0.5|/10 is least at n = 3, x = 0.55: 0.0975."""
    found = optimise(
        lambda s: {"f": (s["n"] - 3.3) ** 2 + (s["x"] - s["n"] / 5) ** 2 + 0.1 * abs(s["x"] - 0.5)},
        {"n": (0.0, 40.0), "x": (0.0, 2.0)}, {}, "f", whole=["n"],
    )  # fmt: skip
    assert found.settings["n"] == 3.0
    assert found.value == pytest.approx(0.0975, abs=1e-5)


def test_where_nothing_keeps_the_limits_the_nearest_is_told():
    found = optimise(lambda s: {"m": 2.0 + (s["x"] - 0.3) ** 2}, {"x": (0.0, 1.0)}, {"m": (None, 1.0)}, "x")
    assert not found.met
    assert found.settings["x"] == pytest.approx(0.3, abs=0.02)
    assert found.margin == pytest.approx(1.0, abs=1e-3)


def test_points_without_a_number_are_avoided():
    def rooted(s):
        return {"f": math.sqrt(s["x"]) - s["x"]} if s["x"] > 0.0 else {}

    found = optimise(rooted, {"x": (-3.0, 0.9)}, {"f": (None, None)}, "f")
    assert found.value == pytest.approx(math.sqrt(0.9) - 0.9, abs=1e-3)


def test_a_budget_is_kept_and_the_same_seed_gives_the_same_calls():
    def run(**more):
        return optimise(lambda s: {"f": (s["x"] - 0.2) ** 2}, {"x": (0.0, 1.0)}, {}, "f", **more)

    assert run(calls=10).calls == 10
    assert run(seed=3).tried == run(seed=3).tried
    assert run(seed=3).tried != run(seed=4).tried


def test_the_front_of_two_distances():
    """Least squared distances to two points: the front is the segment between them, sqrt f1 + sqrt f2 = their distance."""
    a, b = np.array([0.2, 0.3]), np.array([1.7, 1.1])

    def seen(points):
        return [Seen((float(((x - a) ** 2).sum()), float(((x - b) ** 2).sum())), ()) for x in map(np.array, points)]

    found = front(Seeker(seen, [Range(0.0, 2.0), Range(0.0, 2.0)]), 6)
    assert len(found) == 6
    for one in found:
        assert math.sqrt(one.seen.values[0]) + math.sqrt(one.seen.values[1]) == pytest.approx(math.dist(a, b), rel=2e-3)
    assert all(x.seen.values[0] < y.seen.values[0] for x, y in itertools.pairwise(found))
