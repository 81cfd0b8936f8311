"""The examples load; the reference case of the deburring paper says what the paper says."""

from pathlib import Path

import pytest

from cutwise.io.scenario import load
from cutwise.spec.notices import notices

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.yaml")), ids=lambda path: path.stem)
def test_every_example_loads_and_is_read_back(path):
    from cutwise.io.scenario import read_document

    scenario = load(path)
    assert scenario.name == path.stem
    assert read_document(scenario.document()) == scenario


def test_berselli2016_reference_case():
    scenario = load(EXAMPLES / "deburr_compliant_spindle.yaml")
    assert scenario.operation.feed == 0.08
    assert scenario.operation.spindle_speed == pytest.approx(4188.790204786391)
    assert scenario.operation.run_length == pytest.approx(0.048)
    assert (scenario.part.burr.height, scenario.part.burr.width, scenario.part.contact_length) == (1e-3, 1e-3, 1e-2)
    assert (scenario.material.K_tc, scenario.material.K_rc, scenario.material.K_ac) == (2e9, 1.2e9, 0.8e9)
    assert (scenario.spindle.piston_arm, scenario.spindle.tool_reach) == (0.08, 0.15)
    assert (scenario.spindle.friction, scenario.spindle.gravity) == ("set_valued", "off")
    assert (scenario.tool.flutes, scenario.tool.runout, scenario.part.slices) == (20, 0.0, 1)
    assumed = {key for key, origin in scenario.origins.items() if origin.status == "assumed"}
    assert {"spindle.piston_arm", "spindle.tool_reach", "spindle.inertia", "operation.preset"} <= assumed
    assert "spindle.piston_force" not in assumed


def test_berselli2016_is_told_what_is_unusual():
    told = notices(load(EXAMPLES / "deburr_compliant_spindle.yaml"))
    assert [line.split(":")[0] for line in told] == ["operation.spindle_speed"]
