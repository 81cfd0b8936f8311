"""How fast drives and forces converge with the substeps."""

import numpy as np
import pytest

from peers import corner as peer
from peers.corner import NO_FORCE


@pytest.mark.slow
def test_contour_error_converges_with_first_order_in_the_substeps():
    """Friction is held over a substep: first order; ten substeps are within 0.01 µm of the limit."""
    counts = [2, 4, 8, 16]
    limit = peer.run(2e-3, law=NO_FORCE, substeps=256)["history"].position
    errors = [np.abs(peer.run(2e-3, law=NO_FORCE, substeps=n)["history"].position - limit).max() for n in counts]
    slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert -1.4 < slope < -0.7
    assert abs(peer.run(2e-3, law=NO_FORCE)["max"] - peer.run(2e-3, law=NO_FORCE, substeps=256)["max"]) < 0.01


def test_more_substeps_do_not_move_the_corner():
    assert peer.run(2e-3, substeps=20)["max"] == pytest.approx(peer.run(2e-3)["max"], abs=0.02)
