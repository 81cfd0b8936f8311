"""The chip of a turning insert: its section, its thickness, the ridges that are left."""

import math

import numpy as np
import pytest

from cutwise.physics.engagement.insert import ELEMENTS, Insert, edge_rows, ridge, thickness


def rows(feed, depth, nose, lead):
    table = np.zeros((ELEMENTS, 12))
    count = edge_rows(table, Insert(nose, math.radians(lead), np.zeros(1)), feed, depth)
    return table[:count]


def section(feed, depth, nose, lead):
    """Between the edge of now and of one revolution before, below the uncut surface, by strips of height."""
    k, y = math.radians(lead), (np.arange(200_000) + 0.5) / 200_000 * depth
    top = nose * (1 - math.cos(k))
    arc = np.sqrt(np.maximum(0.0, 2 * nose * y - y * y))
    ahead = np.where(y < top, arc, nose * math.sin(k) + (y - top) / math.tan(k))
    return np.maximum(0.0, ahead - np.maximum(ahead - feed, -arc)).mean() * depth


CUTS = [(0.2e-3, 2e-3, 0.8e-3, 95), (0.2e-3, 2e-3, 0.8e-3, 45), (0.2e-3, 0.1e-3, 0.8e-3, 95), (0.3e-3, 3e-3, 0.4e-3, 75),
        (0.1e-3, 0.5e-3, 0.4e-3, 60), (0.2e-3, 0.25e-3, 0.8e-3, 45), (0.2e-3, 0.4e-3, 0.8e-3, 118),
        (0.1e-3, 0.01e-3, 0.8e-3, 93)]  # fmt: skip


@pytest.mark.parametrize("cut", CUTS)
def test_the_section_of_the_chip(cut):
    found = rows(*cut)
    assert (found[:, 2] * found[:, 5]).sum() == pytest.approx(section(*cut), rel=1e-3)


def test_thickness_on_nose_and_straight_edge():
    r, f, k = 0.8e-3, 0.2e-3, math.radians(75)
    insert = Insert(r, k, np.zeros(1))
    beta = 0.5
    x, y = r * math.sin(beta), r * (1 - math.cos(beta))
    expected = r + f * math.sin(beta) - math.sqrt(r**2 - (f * math.cos(beta)) ** 2)
    assert thickness(x, y, beta, f, 5e-3, insert) == pytest.approx(expected, rel=1e-12)
    along = 1e-3
    x, y = r * math.sin(k) + along * math.cos(k), r * (1 - math.cos(k)) + along * math.sin(k)
    assert thickness(x, y, k, f, 5e-3, insert) == pytest.approx(f * math.sin(k), rel=1e-9)
    assert thickness(x, y, k, f, y + 1e-6, insert) == pytest.approx(1e-6 / math.cos(k), rel=1e-6)  # to the free surface
    assert thickness(x, y, k, f, y - 1e-6, insert) == 0.0


def test_compiled_and_plain_agree():
    insert = Insert(0.8e-3, 1.6, np.zeros(1))
    for beta in np.linspace(-0.1, 1.5, 7):
        x, y = 0.8e-3 * math.sin(beta), 0.8e-3 * (1 - math.cos(beta))
        assert thickness(x, y, beta, 2e-4, 1e-3, insert) == thickness.py_func(x, y, beta, 2e-4, 1e-3, insert)


def test_colwell_direction():
    """Colwell 1954 lets the chip flow square to the chord of the edge in cut: what even force along the edge gives.

    With the chip thickest at the major edge, the mean direction turns from there towards the feed, here by 3 to 12 degrees.
    """
    for cut in ((0.1e-3, 1.5e-3, 0.8e-3, 90), (0.1e-3, 0.4e-3, 0.8e-3, 90), (0.15e-3, 2e-3, 1.2e-3, 75)):
        found = rows(*cut)
        feed, depth, r, k = cut[0], cut[1], cut[2], math.radians(cut[3])
        top = r * (1 - math.cos(k))
        x = math.sqrt(2 * r * depth - depth**2) if depth < top else r * math.sin(k) + (depth - top) / math.tan(k)
        low = 0.5 * feed / r
        chord = math.atan2(depth - r * (1 - math.cos(math.asin(low))), x + low * r)
        even, thick = (math.atan2((w * found[:, 3]).sum(), (w * found[:, 4]).sum()) for w in (
            found[:, 2], found[:, 2] * found[:, 5]))  # fmt: skip
        assert even == pytest.approx(chord, rel=1e-3)
        assert 3.0 < math.degrees(thick - chord) < 12.5


def test_ridges_of_the_nose():
    """f^2 / 8r, to the next order f^2 / (64 r^2) of itself."""
    for feed in (0.05e-3, 0.1e-3, 0.2e-3):
        exact = feed**2 / (8 * 0.8e-3)
        assert ridge(feed, 0.8e-3, 1.0) == pytest.approx(exact, rel=1.1 * feed**2 / (16 * 0.8e-3**2))
        assert ridge(feed, 0.8e-3, 1.0) >= exact


@pytest.mark.parametrize("trail", [3.0, 5.0, 15.0])
def test_ridges_of_nose_and_minor_edge(trail):
    """The highest point of the lower envelope of the edge at two revolutions."""
    r, t = 0.8e-3, math.radians(trail)
    for feed in (0.05e-3, 0.15e-3, 0.3e-3, 0.6e-3):
        x = np.linspace(0.0, feed, 400_001)

        def edge(x, t=t):
            end = -r * math.sin(t)
            inside = np.maximum(x, end)
            return r - np.sqrt(r * r - inside**2) + (inside - x) * math.tan(t)

        found = np.minimum(edge(x), edge(x - feed)).max()
        assert ridge(feed, r, t) == pytest.approx(found, rel=1e-4)
