import pytest

from cutwise.io.scenario import parse

SCENARIO = """
process: deburr
operation:
  {feed: 40 mm/s, spindle_speed: 30000 rpm, preset: 2 mm, duration: 0.6 s, lead_in_time: 0.2 s, clearance: 0.5 mm}
part: {burr: {height: 1 mm, width: 1 mm}, contact_length: 10 mm}
tool: {library: berselli2016}
material: {library: deburr_aluminium}
spindle: {library: berselli2016}
"""


@pytest.fixture
def scenario_with():
    """A usual deburring scenario with some values replaced."""

    def build(*overrides):
        return parse(SCENARIO, "scenario.yaml", overrides)

    return build


@pytest.fixture
def faults_with(scenario_with):
    """The faults of that scenario with some values replaced, as text."""
    from cutwise.spec.faults import ScenarioFault

    def faults(*overrides):
        with pytest.raises(ScenarioFault) as caught:
            scenario_with(*overrides)
        return str(caught.value)

    return faults
