"""The linear error sum against the exact composition: what is left out is of second order."""

import numpy as np

from cutwise.maths import chains, frames


def test_residual_of_the_linear_sum_falls_with_the_square():
    rng = np.random.default_rng(8)
    rotations = frames.exp_twists(rng.normal(size=(6, 6)))[0]
    chain = chains.chain([2, 1, 2, 0, 2, 1], rng.normal(size=(6, 3)), rng.normal(size=(6, 3)), rotations=rotations)
    at = chains.frames(chain, rng.normal(size=6))
    tip, twists = np.array([0.1, 0.0, 0.3]), rng.normal(size=(7, 6)) * 1e-2
    left = []
    for scale in 0.5 ** np.arange(8):
        missed = chains.exact_error(at, scale * twists, tip) - chains.linear_error(at, scale * twists, tip)
        left.append(np.linalg.norm(missed))
    slopes = np.log2(np.array(left[:-1]) / left[1:])
    assert abs(slopes[-1] - 2.0) < 2e-3
    assert abs(slopes.mean() - 2.0) < 2e-2
