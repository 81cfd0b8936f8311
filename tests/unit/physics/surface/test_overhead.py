"""Heights above places against every ray met with every triangle at once."""

import numpy as np
import pytest

from cutwise.physics.surface.overhead import height_above

RING = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])


def test_against_all_rays_at_once():
    random = np.random.default_rng(7)
    flat, height = random.uniform(-10.0, 10.0, (60, 3, 2)), random.uniform(-5.0, 5.0, (60, 3))
    place, floor = random.uniform(-8.0, 8.0, (9, 2)), random.uniform(-3.0, 3.0, 9)
    rays = (place[:, None] + RING)[:, :, None, None]
    edges = np.roll(flat, -1, axis=1) - flat
    side = edges[..., 0] * (rays - flat)[..., 1] - edges[..., 1] * (rays - flat)[..., 0]
    hit = (side >= 0.0).all(axis=-1) | (side <= 0.0).all(axis=-1)
    weight = np.roll(side, -1, axis=-1) / side.sum(axis=-1, keepdims=True)
    above = np.where(hit, (weight * height).sum(axis=-1) - floor[:, None, None], 0.0)
    assert height_above(flat, height, place, floor, RING) == pytest.approx(max(above.max(), 0.0), rel=1e-12)


def test_nothing_above():
    flat, upright = np.array([[[5.0, 5.0], [6.0, 5.0], [5.0, 6.0]]]), np.array([[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]])
    here = np.zeros((1, 2)), np.zeros(1)
    assert height_above(flat, np.ones((1, 3)), *here, RING) == 0.0
    assert height_above(upright, np.ones((1, 3)), *here, RING) == 0.0
    assert height_above(flat - 5.0, -np.ones((1, 3)), *here, RING) == 0.0
    assert height_above(flat - 5.0, np.ones((1, 3)), *here, RING) == 1.0
