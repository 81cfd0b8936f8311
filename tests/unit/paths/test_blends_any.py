"""Roundings between lines, arcs, helices and rapids: within the tolerance, tangent, and none where the path turns back."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cutwise.maths.linearc import arc, at_blocks, block_at, block_point, block_tangent, join, line, sample, turn_angles
from cutwise.paths import blends
from cutwise.paths.blends import blended
from cutwise.physics.motion.lookahead import TANGENT, plan
from cutwise.physics.motion.profile import Limits

LIMITS = Limits(0.2, 2.0, 50.0)


def directed(kind, size, azimuth, height, spin):
    """A block of unit start tangent at the origin: (block, end point)."""
    t = np.array([math.cos(height) * math.cos(azimuth), math.cos(height) * math.sin(azimuth), math.sin(height)])
    if kind == "line":
        return line((0, 0, 0), size * t)
    side = np.cross(t, [0.0, 0.0, 1.0] if abs(t[2]) < 0.9 else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    n = math.cos(spin) * side + math.sin(spin) * np.cross(t, side)
    radius, sweep = size, 1.3
    axis = np.cross(t, n)
    if kind == "arc":
        return arc((0, 0, 0), radius * n, sweep, axis)
    return arc((0, 0, 0), radius * n, sweep, axis, rise=0.4 * radius)


def placed(block, at):
    return block._replace(start=tuple(float(v) for v in at))


def reversed_(block):
    """The same points the other way round, ending at the origin."""
    curve = join([block])
    end, back = np.array(block_point(curve, 0, block.length)), np.array(block_tangent(curve, 0, block.length))
    if block.straight:
        return line(-end, (0, 0, 0))
    phi = block.length * block.share / block.radius
    along = -(math.cos(phi) * np.array(block.along) + math.sin(phi) * np.array(block.inward))
    inward = math.cos(phi) * np.array(block.inward) - math.sin(phi) * np.array(block.along)
    assert back @ np.array(block.along) <= 1.0
    return block._replace(
        start=tuple(end), along=tuple(along), inward=tuple(inward), climb=tuple(-np.array(block.climb))
    )


kinds = st.sampled_from(["line", "arc", "helix"])
angles = st.floats(-math.pi, math.pi)
heights = st.floats(-1.3, 1.3)


@st.composite
def junctions(draw):
    """Two blocks that meet at the origin at a random angle, tangent and reversed ones among them."""
    first = directed(draw(kinds), 10 ** draw(st.floats(-4, -1.5)), draw(angles), draw(heights), draw(angles))
    special = draw(st.sampled_from(["any", "any", "any", "tangent", "reversal", "nearly tangent", "nearly reversal"]))
    before = reversed_(first)
    along = np.array(block_tangent(join([before]), 0, before.length))
    if special == "any":
        azimuth, height = draw(angles), draw(heights)
    else:
        way = along if "tangent" in special else -along
        azimuth, height = math.atan2(way[1], way[0]), math.asin(max(-1.0, min(1.0, way[2])))
        if "nearly" in special:
            azimuth += draw(st.floats(2e-3, 2e-2))
    after = directed(draw(kinds), 10 ** draw(st.floats(-4, -1.5)), azimuth, height, draw(angles))
    return join([before, placed(after, (0, 0, 0))])


def dense(curve, count=400):
    block = np.repeat(np.arange(curve.count), count)
    s = np.concatenate([np.linspace(0.0, length, count) for length in curve.length])
    return at_blocks(curve, block, s)[0]


def farthest(points, curve):
    """Largest distance of points from a curve: for each block from its nearest sample on, by Newton's method."""
    best = np.full(len(points), math.inf)
    for i in range(curve.count):
        s = np.linspace(0.0, curve.length[i], 2001)
        fine = at_blocks(curve, np.full(2001, i), s)[0]
        at = s[np.argmin(((fine[None] - points[:, None]) ** 2).sum(axis=2), axis=1)]
        for _ in range(5):
            near, tangent = at_blocks(curve, np.full(len(points), i), at)
            at = np.clip(at + np.einsum("ij,ij->i", points - near, tangent), 0.0, curve.length[i])
        near = at_blocks(curve, np.full(len(points), i), at)[0]
        best = np.minimum(best, np.linalg.norm(points - near, axis=1))
    return float(best.max())


@settings(max_examples=60, deadline=None, derandomize=True)
@given(junctions(), st.floats(-6, -3.5), st.sampled_from(["arc", "clothoid"]), st.booleans())
def test_a_blend_keeps_its_tolerance_and_is_tangent(curve, exponent, shape, parted):
    tolerance = 10**exponent
    found = blended(curve, np.array([tolerance]), shape, np.array([parted]))
    turn = turn_angles(curve)[0]
    path = found.curve
    if not found.rounded[0]:
        assert turn < TANGENT or turn > math.pi - 1e-3
        assert path is curve
        return
    assert turn >= TANGENT
    assert turn_angles(path).max() < TANGENT / 2
    for i in range(path.count - 1):
        gap = np.subtract(block_point(path, i, path.length[i]), block_point(path, i + 1, 0.0))
        assert np.linalg.norm(gap) < 2e-9
    middle = dense(path)
    assert farthest(middle[:: max(1, len(middle) // 300)], curve) <= tolerance * (1 + 1e-3) + 2e-9
    assert farthest(np.zeros((1, 3)), path) <= tolerance * (1 + 1e-3) + 2e-9, "the corner itself"
    assert set(found.origin) <= {0, 1}
    assert np.all(np.diff(found.origin) >= 0)
    assert block_point(path, 0, 0.0) == pytest.approx(block_point(curve, 0, 0.0), abs=1e-12)
    end = block_point(path, path.count - 1, path.length[-1])
    assert end == pytest.approx(block_point(curve, 1, curve.length[1]), abs=1e-12)
    motion = plan(path, np.full(path.count, 0.05), LIMITS)
    assert motion.stops == 0


@settings(max_examples=25, deadline=None, derandomize=True)
@given(junctions(), st.floats(-5.5, -4))
def test_a_blend_of_a_long_pair_uses_its_tolerance(curve, exponent):
    """Where the blocks leave room the corner is passed at the tolerance, whatever they are."""
    found = blended(curve, np.array([10**exponent]))
    if found.rounded[0] and not found.cut_short:
        near = np.linalg.norm(dense(found.curve, 4000), axis=1).min()
        off = farthest(dense(found.curve)[::10], curve)
        assert max(near, off) >= 0.98 * 10**exponent


def test_nothing_moves_when_the_inner_tolerances_are_halved(monkeypatch):
    curve = join([line((-0.03, 0, 0), (0, 0, 0)), arc((0, 0, 0), (0.03, -0.02, 0), 0.8)])
    feed = np.full(2, 0.05)

    def time():
        path = blended(curve, np.array([50e-6])).curve
        return plan(path, np.full(path.count, feed[0]), LIMITS).profile.duration

    coarse = time()
    monkeypatch.setattr(blends, "_CLOSE", 0.5 * blends._CLOSE)
    monkeypatch.setattr(blends, "_LOOKS", 2 * blends._LOOKS)
    for kernel in (blends._deviation, blends._curved_reach, blends._reaches):
        monkeypatch.setattr(blends, kernel.py_func.__name__, kernel.py_func)
    assert time() == pytest.approx(coarse, rel=1e-5)


def test_halves_of_a_blend_belong_to_their_blocks():
    """A rapid and a cut, or two feeds: each half is run and counted as the block that it replaces."""
    curve = join([line((-0.03, 0), (0, 0)), line((0, 0), (0, 0.03))])
    found = blended(curve, np.array([1e-4]), "arc", np.array([True]))
    assert found.origin.tolist() == [0, 0, 1, 1]
    whole = blended(curve, np.array([1e-4])).curve
    assert found.curve.knots[-1] == pytest.approx(whole.knots[-1], rel=1e-12)
    assert block_at(found.curve, 1).radius == pytest.approx(block_at(whole, 1).radius, rel=1e-9)
    points = sample(whole, whole.knots, np.linspace(0, whole.knots[-1], 1001))[0]
    assert farthest(points[::20], found.curve) < 1e-9
