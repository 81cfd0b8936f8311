"""One rule for the depth at which a cut chatters."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from cutwise.process import chatter

MODE = SimpleNamespace(direction="y", frequency=100.0, damping=0.05, stiffness=1e7)


def test_receptances_of_modes_and_of_something_else_add():
    at_rest, shaft = np.zeros(1), 2e-8 * np.ones((1, 3, 3))
    both = chatter.together([MODE], lambda omega: shaft[: len(omega)])
    assert both(at_rest)[0, 1, 1] == pytest.approx(1e-7 + 2e-8)
    assert both(at_rest)[0, 0, 0] == pytest.approx(2e-8)
    assert chatter.together((), None) is None


def test_a_depth_at_its_limit_is_not_sound():
    deep, free = chatter.measures(3e-3, 2e-3), chatter.measures(3e-3, math.inf)
    assert deep == {"depth_margin": pytest.approx(-0.5), "stable_depth_min": 2e-3}
    assert free == {"depth_margin": 1.0}
    (said,) = chatter.findings(deep, "shaft")
    assert (said.code, said.where.name, said.value, said.measure) == ("unstable", "shaft", 1.5, "depth_margin")
    assert not list(chatter.findings(free, "arm"))
    assert not list(chatter.findings({}, "arm"))
