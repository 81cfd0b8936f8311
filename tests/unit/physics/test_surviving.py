"""Whether a wall stays: against every later place of the path, densely sampled."""

import numpy as np
import pytest

from cutwise.maths.linearc import arc, at_blocks, join, line
from cutwise.physics.engagement.path_sweep import swept_path
from cutwise.physics.engagement.surviving import surviving

RADIUS, MARGIN = 5e-3, 1e-6


def rosette():
    rng = np.random.default_rng(3)
    blocks, at = [], np.array([0.0, 0.0, 0.0])
    for k in range(40):
        end = np.array([*rng.uniform(-0.04, 0.04, 2), rng.choice([0.0, 0.0, -1e-3, 1e-3])])
        blocks.append(line(at, end))
        at = end
        if k % 3 == 0:
            centre = at + np.array([*rng.uniform(-0.01, 0.01, 2), 0.0])
            sweep = rng.uniform(-5.0, 5.0)
            blocks.append(arc(at, centre, sweep))
            c, s = np.cos(sweep), np.sin(sweep)
            d = at - centre
            at = centre + np.array([c * d[0] - s * d[1], s * d[0] + c * d[1], 0.0])
    return join(blocks)


def test_as_every_later_place_says():
    curve = rosette()
    swept = swept_path(curve, RADIUS)
    rng = np.random.default_rng(5)
    way = np.sort(rng.uniform(0.0, curve.knots[-1], 300))
    block = np.minimum(np.searchsorted(curve.knots, way, side="right") - 1, curve.count - 1)
    point, direction = at_blocks(curve, block, way - curve.knots[block])
    side = np.column_stack((direction[:, 1], -direction[:, 0])) / np.hypot(direction[:, 0], direction[:, 1])[:, None]
    rim = point.copy()
    rim[:, :2] += RADIUS * side
    rim[:, 2] += 5e-7
    found = surviving(rim, way, swept, MARGIN)
    dense = np.linspace(0.0, curve.knots[-1], 300_001)
    blocks = np.minimum(np.searchsorted(curve.knots, dense, side="right") - 1, curve.count - 1)
    places, _ = at_blocks(curve, blocks, dense - curve.knots[blocks])
    for k in range(len(way)):
        later = (dense > way[k]) & (places[:, 2] <= rim[k, 2])
        near = np.hypot(*(places[later, :2] - rim[k, :2]).T).min(initial=1.0)
        if abs(near - (RADIUS - MARGIN)) > 2e-5:  # the samples are that far apart
            assert found[k] == (near > RADIUS - MARGIN), k
    assert 20 < found.sum() < 280


@pytest.mark.parametrize(("depth", "stays"), [(-2e-3, False), (0.0, False), (1e-3, True)])
def test_a_pass_above_leaves_the_wall_below_it(depth, stays):
    ways = [((0, 0, 0), (0.05, 0, 0)), ((0.05, 0, 0), (0.05, 0, 1)), ((0.05, 0, 1), (0.05, -3e-3, 1)),
            ((0.05, -3e-3, 1), (0.05, -3e-3, depth)), ((0.05, -3e-3, depth), (0.0, -3e-3, depth))]  # fmt: skip
    swept = swept_path(join([line(*ends) for ends in ways]), RADIUS)
    assert surviving(np.array([[0.02, -RADIUS, 1e-6]]), np.array([0.02]), swept, MARGIN).tolist() == [stays]
