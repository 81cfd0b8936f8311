"""A scenario is written to a document and read back exactly."""

import json

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cutwise.io.scenario import parse, read_document, revised
from cutwise.spec.faults import ScenarioFault

SLOW_FIXTURE = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40, deadline=None)


def through_json(scenario):
    return read_document(json.loads(json.dumps(scenario.document())), "document")


def number(low, high, unit):
    """Values that are not out of scale, as text."""
    values = st.floats(low, high, allow_nan=False).filter(lambda value: not 0.0 < abs(value) < 1e-50)
    return values.map(lambda value: f"{value!r} {unit}")


path_errors = st.one_of(
    st.just("none"),
    st.fixed_dictionaries({"amplitude": number(0, 0.5, "mm"), "frequency": number(0.1, 20, "Hz")}),
    st.fixed_dictionaries(
        {"spectrum": st.just([{"amplitude": "0.1 mm", "wavelength": "6 cm"}]), "seed": st.integers(0, 10**18 - 1)}
    ),
    st.just({"columns": {"t [ms]": [0, 700], "error [um]": [3, -4.5]}}),
)
heights = st.one_of(
    number(0, 3, "mm"),
    st.fixed_dictionaries(
        {"mean": number(0, 1, "mm"), "deviation": number(0, 1, "mm"), "correlation_length": number(1, 9, "mm")}
    ),
    st.just({"columns": {"w [mm]": [0, 10, 1000], "height [mm]": [1, 0.5, 0]}, "file": "burr.csv"}),
)


@SLOW_FIXTURE
@given(
    feed=number(1, 50, "mm/s"),
    speed=number(1e3, 6e4, "rpm"),
    path_error=path_errors,
    height=heights,
    limit=number(-1, 1, "mm"),
    helix=number(-60, 60, "deg"),
)
def test_document_and_back(scenario_with, feed, speed, path_error, height, limit, helix):
    document = scenario_with().document()
    document["operation"] |= {"feed": feed, "spindle_speed": speed, "path_error": path_error}
    document["part"]["burr"]["height"] = height
    document["tool"]["helix"] = {"value": helix, "status": "measured", "source": "my own"}
    document["requirements"] = {"surface_error_max": {"max": limit}}
    scenario = read_document(document)
    again = through_json(scenario)
    assert again == scenario
    assert again.origins == scenario.origins
    assert again.document() == scenario.document()


def test_the_document_keeps_the_words_of_the_engineer(scenario_with):
    document = scenario_with("operation.feed={value: 80.0 mm/s, status: measured, source: stopwatch}").document()
    assert document["operation"]["feed"] == {"value": "80.0 mm/s", "status": "measured", "source": "stopwatch"}
    assert document["operation"]["preset"] == "2 mm"


def test_a_changed_copy_is_written_with_its_own_value(scenario_with):
    scenario = scenario_with()
    faster = scenario.operation.model_copy(update={"feed": 0.1})
    copy = scenario.model_copy(update={"operation": faster})
    assert read_document(copy.document()).operation.feed == 0.1


def test_the_document_needs_no_library(scenario_with):
    document = scenario_with().document()
    for section in ("tool", "material", "spindle"):
        document[section]["library"] = "gone"
        for value in document[section].values():
            if isinstance(value, dict):
                value["library"] = "gone"
    again = read_document(document)
    assert again.spindle.piston_force == 7.7
    assert again.spindle.library == "gone"


def test_another_library_entry_replaces_the_values_of_the_first(scenario_with):
    scenario = scenario_with("spindle.stroke=4 mm")
    other = revised(scenario, ["spindle.library=default"])
    assert other.spindle.piston_arm == 0.1
    assert other.spindle.stroke == 0.004  # written in the scenario: stays
    assert other.origins["spindle.piston_arm"].library == "default"


def test_origins_say_where_each_value_is_from(scenario_with):
    origins = scenario_with("operation.feed=60 mm/s").origins
    assert origins["operation.feed"].status == "user"
    assert origins["operation.feed"].text == "60 mm/s"
    assert origins["spindle.piston_force"].status == "paper"
    assert origins["spindle.piston_arm"].status == "assumed"
    assert origins["spindle.piston_arm"].library == "berselli2016"
    assert "name" not in origins
    assert "spindle.library" not in origins


@pytest.mark.parametrize(
    ("requirements", "message"),
    [
        ("{surface_eror_max: {max: 1 mm}}", "unknown measure; did you mean surface_error_max?"),
        ("{cutting_power_mean: {max: 1 mm}}", '"mm" is not a unit of power'),
        ("{cutting_power_mean: {max: 300}}", "300 has no unit"),
        ("{cutting_power_mean: 300 W}", "write min, max or both, for example {max: 300 W}"),
        ("{surface_error_max: {min: 1 mm, max: 0 mm}}", "min 1 mm is above max 0 mm"),
        (
            "{surface_error_max: {mx: 1 mm, max: 0 mm}}",
            "unknown key; a requirement has min, max, whole_band and probability",
        ),
        ("{surface_error_max: {max: 1 mm, whole_band: perhaps}}", "perhaps is neither true nor false"),
        ("{surface_error_max: {whole_band: true}}", "has no limit; write min, max or both"),
        ("[surface_error_max]", "expected a section"),
    ],
)
def test_faults_of_requirements(faults_with, requirements, message):
    assert message in faults_with(f"requirements={requirements}")


def test_limits_are_in_the_unit_of_the_measure(scenario_with):
    requirements = scenario_with(
        "requirements={surface_error_max: {max: 0.05 mm}, fraction_ideal: {min: 90 %}}"
    ).requirements
    assert requirements["surface_error_max"].max == 5e-5
    assert requirements["fraction_ideal"].min == 0.9


def test_scenarios_are_frozen(scenario_with):
    with pytest.raises(ValueError, match="frozen"):
        scenario_with().operation.feed = 3.0


def test_a_process_may_be_left_out_where_the_keys_fit_one():
    text = "operation: {feed: 80, preset: 2 mm}"
    with pytest.raises(ScenarioFault) as caught:
        parse(text)
    assert "process" not in [fault.path[0] for fault in caught.value.faults]
