"""The loop over stages against the edge loop of version 0.1, written out with all its bits: nothing may move."""

import json
from pathlib import Path

import numpy as np
import pytest

from cutwise.physics.cutting.flute import EdgeCoefficients, mean_force
from cutwise.physics.structure.terms import Compliance
from cutwise.process.loops import run_compliant_edge
from peers.cells import r0

# Another processor may round a sine differently; bits are asked for where these are the same.
_AT = np.linspace(0.01, 3.1, 40)
_PROBE = [
    mean_force(0.5 * x, x, 1e-5, 0.1 * x, 1e-3, 20, EdgeCoefficients(2e9, 1e9, 1e9, 1e3, 1e3, 0.0)).y for x in _AT
]
WRITTEN = json.loads((Path(__file__).parent / "edge_loop_of_0_1.json").read_text())
PROBED = WRITTEN.pop("probe")
NOTHING = Compliance(np.zeros(1), np.zeros((1, 6, 6)))


@pytest.mark.parametrize("behind", [(), (("arm", NOTHING),)], ids=["alone", "with a term of no compliance"])
@pytest.mark.parametrize("name", WRITTEN)
def test_forces_are_those_of_0_1_to_the_last_bit(name, behind):
    case = WRITTEN[name]
    history = run_compliant_edge(r0(duration=0.3, **case["changes"])._replace(behind=behind), 20e-6)
    found = {
        "burr": history.burr_force.mean,
        "work": history.work_force.mean,
        "tilt": history.response.tilt,
        "travel": history.response.travel,
    }
    for kind, values in found.items():
        expected = [[float.fromhex(v) for v in row] for row in case[kind]]
        if [value.hex() for value in _PROBE] == PROBED:
            assert values[case["rows"]].tolist() == expected, kind
        else:
            assert values[case["rows"]] == pytest.approx(np.array(expected), rel=1e-5, abs=1e-6), kind
