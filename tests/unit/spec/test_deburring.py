"""What a deburring scenario may say, what cannot be, and what is unusual."""

import pytest

from cutwise.io.scenario import load
from cutwise.spec.faults import ScenarioFault
from cutwise.spec.notices import notices

BOTH = (
    "operation={feed: 80 mm/s, spindle_speed: 20000 rpm, preset: 2 mm, duration: 1 s, length: 80 mm, "
    "lead_in_time: 0.2 s, clearance: 0 mm}"
)


def test_the_usual_scenario_is_not_remarked_upon(scenario_with):
    assert notices(scenario_with()) == ()


def test_values_are_in_si(scenario_with):
    scenario = scenario_with()
    assert scenario.operation.feed == 0.04
    assert scenario.operation.run_length == pytest.approx(0.024)
    assert scenario.material.K_tc == 2585e6
    assert scenario.spindle.pressure == 5e5
    assert scenario.tool.helix == pytest.approx(0.3490658503988659)
    assert scenario.spindle.gravity == "off"


def test_length_takes_the_place_of_duration(scenario_with):
    operation = scenario_with("operation.length=100 mm").operation
    assert operation.duration is None
    assert operation.run_time == pytest.approx(2.5)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        (BOTH, "exactly one of length and duration"),
        ("operation.lead_out_time=0.4 s", "leave nothing of a run of 0.6 s"),
        ("operation.tolerance=0 mm", "0 mm is impossible; it must be above 0 mm"),
        ("tool.helix=90 deg", "90 deg is impossible; it must be below 80°"),
        ("tool.flutes=0", "0 is impossible; it must be at least 1"),
        ("tool.flutes=2.5", "2.5 is not a whole number"),
        ("tool.flutes=true", "true is not a whole number"),
        ("tool.runout=4 mm", "as large as the radius"),
        ("tool.flute_length=5 mm", "the part reaches 10 mm up the mill, the flutes only 5 mm"),
        ("part.burr.axial_start=-1 mm", "-1 mm is impossible; it must be at least 0 mm"),
        ("part.burr.height=-1 mm", "-1 mm is impossible; it must be at least 0 mm"),
        ("part.burr.width=0 mm", "0 mm is impossible; it must be above 0 mm"),
        ("spindle.friction_static=1 N", "is below friction_dynamic"),
        ("spindle.friction=regularised", "missing; regularised friction needs it"),
        ("spindle.inertia=1e-3 kg m^2", "less than mass times centre_of_mass squared (0.00337 kg m^2)"),
        ("spindle.gravity=down", "expected off, an axis of the process frame"),
        ("spindle.gravity=[0, 0, 0]", "expected off, an axis of the process frame"),
        ("spindle.pressure=5 mm", '"mm" is not a unit of pressure'),
        ("operation.path_error={spectrum: [{amplitude: 1 mm}]}", "exactly one of wavelength and frequency"),
        ("material.m_c=0.25", "k_c11: missing"),
    ],
)  # fmt: skip
def test_impossible_values_are_faults(faults_with, override, message):
    assert message in faults_with(override)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("operation.feed=500 mm/s", "operation.feed: 500 mm/s is unusual; usual is 5 mm/s to 300 mm/s"),
        ("operation.spindle_speed=40000 rpm", "is 1005 m/min; usual for burs is up to 900 m/min in group N"),
        ("material.library=deburr_ti6al4v", "usual for burs is up to 350 m/min in group S"),
        ("material.library=al7075t6", "hold for chips of 20 µm to 150 µm, this feed per tooth is 4 µm"),
        ("operation.preset=6 mm", "operation.preset: 6 mm is unusual"),
        ("operation.preset=9.5 mm", "the spindle meets its stop"),
        ("operation.preset=-1.2 mm", "nothing is cut"),
        ("operation.path_error={amplitude: 1.99 mm, frequency: 2 Hz}", "the mill may leave the edge"),
        ("operation.lead_in_time=0.5 s", "reaches into the steady part"),
        ("spindle.piston_arm=150 mm", "is not shorter than tool_reach"),
        ("spindle.pressure=1 bar", "does not re-centre"),
        ("numerics.force=tooth_resolved", None),
        ("numerics={force: tooth_resolved, time_step: 20 us}", "the ripple is not resolved"),
        ("tool.runout=5 um", "5 µs that run-out asks for"),
        ("part.contact_length=0.8 mm", "reaches beyond the part's face"),
        ("part.burr.height={mean: 1 mm, deviation: 0.8 mm, correlation_length: 5 mm}", "cut off at zero"),
    ],
)  # fmt: skip
def test_unusual_values_are_warned_about(scenario_with, override, message):
    told = notices(scenario_with(override))
    if message is None:
        assert told == ()
    else:
        assert any(message in line for line in told), told


def test_the_time_step_follows_the_force(scenario_with):
    assert scenario_with().numerics.time_step == 20e-6
    assert scenario_with("numerics.force=tooth_resolved").numerics.time_step == 2.5e-6


@pytest.mark.parametrize(
    ("text", "direction"),
    [("-y", (0, -1, 0)), ("+x", (1, 0, 0)), ("z", (0, 0, 1)), ("[0, -3, 4]", (0, -0.6, 0.8)), ("off", "off")],
)
def test_gravity_is_a_unit_vector_or_off(scenario_with, text, direction):
    assert scenario_with(f"spindle.gravity={text}").spindle.gravity == direction


def test_kienzle_values_take_the_place_of_library_ones(scenario_with):
    override = "material={library: deburr_1045, k_c11: 1500 N/mm^2, m_c: 0.22, k_r11: 500 N/mm^2, m_r: 0.22}"
    material = scenario_with(override).material
    assert material.law == "kienzle"
    assert material.K_tc is None
    assert material.K_ae is None
    assert material.group == "P"


def test_a_fault_of_the_engineers_mass_stands_at_the_mass(examples, tmp_path):
    """The inertia is that of a library entry, which is sound by itself: not its line is wrong."""
    text = (
        (examples / "deburr_compliant_spindle.yaml").read_text().replace("\nspindle:\n", "\nspindle:\n  mass: 3 kg\n")
    )
    line = text.splitlines().index("  mass: 3 kg") + 1
    (tmp_path / "d.yaml").write_text(text)
    with pytest.raises(ScenarioFault) as found:
        load(tmp_path / "d.yaml")
    assert found.value.faults[0].file == str(tmp_path / "d.yaml")
    assert found.value.faults[0].line == line
    assert "is that of the library entry berselli2016" in str(found.value)
