"""A sweep is the same as its runs one by one."""

import pytest

from cutwise.io.scenario import load
from cutwise.process.recipes import simulate
from cutwise.spec.faults import ScenarioFault
from cutwise.study.sensitivity import assumed_quantities
from cutwise.study.sweep import parse_values, sweep


def test_sweep_over_two_keys(examples):
    scenario = load(examples / "deburr_compliant_spindle.yaml")
    table = sweep(scenario, {"spindle.pressure": ["4 bar", "5 bar"], "operation.feed": ["60 mm/s", "80 mm/s"]})
    assert table.sizes == {"spindle.pressure": 2, "operation.feed": 2}
    here = table.surface_error_mean.sel({"spindle.pressure": 5e5, "operation.feed": 0.08})
    assert float(here) == simulate(scenario).measures["surface_error_mean"].value
    assert table.surface_error_mean.attrs["units"] == "m"
    assert float(table.surface_error_mean.sel({"spindle.pressure": 4e5, "operation.feed": 0.08})) == pytest.approx(
        0.170e-3, rel=0.03
    )


def test_coordinates_are_numbers_with_the_texts_beside_them(examples):
    scenario = load(examples / "deburr_compliant_spindle.yaml")
    table = sweep(scenario, {"spindle.pressure": ["4 bar", "5 bar"], "operation.milling": ["down"]}, check=False)
    assert table["spindle.pressure"].values.tolist() == pytest.approx([4e5, 5e5])
    assert table["spindle.pressure"].attrs["units"] == "Pa"
    assert table["spindle.pressure"].attrs["display_unit"] == "bar"
    assert table["spindle.pressure as written"].values.tolist() == ["4 bar", "5 bar"]
    assert table["operation.milling"].values.tolist() == ["down"]
    between = table.surface_error_mean.interp({"spindle.pressure": 4.5e5})
    assert float(between.min()) < 0.17e-3


def test_a_sweep_is_its_runs_with_their_warnings(examples):
    """Row 5: a lead-in of 2 ms gave 208.7 µm here and 57.1 µm, with a warning, in the run."""
    scenario = load(examples / "deburr_compliant_spindle.yaml")
    table = sweep(scenario, {"operation.lead_in_time": ["2 ms", "10 ms", "0.2 s"]})
    assert table.surface_error_max.values == pytest.approx([57.108e-6, 338.60e-6, -9.466e-6], rel=1e-4)
    said = table.unsound.values.tolist()
    assert "at_stop" in said[0].splitlines()
    assert "at_stop" in said[1].splitlines()
    assert "unconverged" in said[0].splitlines()  # one end: run in full, with half the step too
    assert said[2] == ""
    assert "the cutting speed is 1005 m/min" in table.warnings.values[2]
    assert table.attrs["checked"].endswith("difference of a measure is 0")
    with pytest.raises(ScenarioFault, match=r'values\["operation.lead_in_time"\]: 2 has no unit'):
        sweep(scenario, {"operation.lead_in_time": ["2"]})
    with pytest.raises(ScenarioFault, match="did you mean surface_error_max"):
        sweep(scenario, {"operation.lead_in_time": ["2 ms"]}, wanted=["surface_eror_max"])


def test_all_faults_before_anything_runs(examples):
    scenario = load(examples / "deburr_compliant_spindle.yaml")
    with pytest.raises(ScenarioFault) as caught:
        sweep(scenario, {"operation.feed": ["-1 mm/s", "80", "60 mm/s"]})
    assert "impossible" in str(caught.value)
    assert "no unit" in str(caught.value)


def test_a_combination_that_cannot_be_run_leaves_the_others(examples):
    scenario = load(examples / "mill_pocket_corner.yaml", ["machine.reading=as_printed", "path.compare=[]"])
    table = sweep(scenario, {"path.corner": ["2 mm", "5 mm"], "machine.control.delay": ["0", "1"]})
    runs = table.contour_error_max.notnull()
    assert runs.sel({"machine.control.delay": 0}).all()
    assert not runs.sel({"machine.control.delay": 1}).any()
    reasons = table.attrs["failed"].splitlines()
    assert all("machine.control.delay=1: machine." in reason and "unstable" in reason for reason in reasons)
    assert {reason.split(",")[0] for reason in reasons} == {"path.corner=2 mm", "path.corner=5 mm"}
    with pytest.raises(ScenarioFault, match="unstable"):
        sweep(scenario, {"machine.control.delay": ["1"]})


def test_values_may_be_lists():
    values = parse_values(["load.force=[1 N, 2 N, 3 N],[4 N, 5 N, 6 N]", "path_mode=exact_stop,{blend: 1 mm}"])
    assert values == {
        "load.force": ["[1 N, 2 N, 3 N]", "[4 N, 5 N, 6 N]"],
        "path_mode": ["exact_stop", "{blend: 1 mm}"],
    }


def test_measures_named_after_bodies_are_in_the_table(examples):
    scenario = load(examples / "machine_error_budget.yaml")
    table = sweep(scenario, {"load.weights": ["true", "false"]}, wanted=["deviation_p95"])
    assert float(table.share_column[0]) == pytest.approx(119.875e-6, abs=1e-9)
    assert table.deviation_p95.notnull().all()


def test_assumed_values_inside_of_lists_are_found(examples):
    """The stiffness of a guide of the library machine is in a list of bodies, and a list of three itself."""
    found = {key: value for key, value, _ in assumed_quantities(load(examples / "machine_error_budget.yaml"))}
    assert found["machine.chain[2].elements[0].pads.stiffness"] == (0.0, 2e8, 3e8)
    assert found["machine.chain[4].elements[1].beam.youngs_modulus"] == 1.2e11


def test_a_sweep_says_which_runs_are_not_sound(examples):
    scenario = load(examples / "deburr_compliant_spindle.yaml")
    table = sweep(scenario, {"operation.milling": ["down", "up"]})
    assert table["unsound"].values.tolist() == ["", "at_stop"]


@pytest.mark.slow
def test_a_sweep_is_the_same_for_any_number_of_processes(examples):
    scenario = load(examples / "deburr_compliant_spindle.yaml")
    values = {"spindle.pressure": ["4 bar", "5 bar"], "operation.milling": ["down", "up"]}
    one, two = (sweep(scenario, values, check=False, jobs=jobs) for jobs in (1, 2))
    assert one.identical(two)
