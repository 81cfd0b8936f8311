"""What Python offers a researcher: scenarios from mappings, changed copies, values by key, tables, answers to wrong names."""

import time
from pathlib import Path

import numpy as np
import pytest

import cutwise
from cutwise.results import NoSuchName
from cutwise.units import UnitFault


@pytest.fixture(scope="module")
def scenario(examples):
    return cutwise.load(examples / "deburr_compliant_spindle.yaml")


@pytest.fixture(scope="module")
def result(scenario):
    return cutwise.simulate(scenario)


def test_a_mapping_is_a_scenario(scenario):
    again = cutwise.load(scenario.document())
    assert again == scenario
    assert again.origins == scenario.origins
    changed = cutwise.load(scenario.document(), {"spindle.pressure": "4 bar"})
    assert changed["spindle.pressure"] == 4e5
    assert cutwise.load(scenario.document(), ["spindle.pressure=4 bar"]) == changed
    assert cutwise.load(scenario.document(), None) == scenario


def test_what_cannot_stand_in_a_scenario_is_a_fault_of_it(scenario):
    bad = {**scenario.document(), "operation": {"feed": object(), 3: {1, 2}}}
    with pytest.raises(cutwise.ScenarioFault) as caught:
        cutwise.load(bad)
    assert [fault.path for fault in caught.value.faults] == [("operation", "feed"), ("operation", "3")]
    assert "(object) cannot stand in a scenario" in str(caught.value)
    endless: dict = {"process": "deburr"}
    endless["part"] = endless
    with pytest.raises(cutwise.ScenarioFault, match="nested too deeply"):
        cutwise.load(endless)
    with pytest.raises(cutwise.ScenarioFault, match="written twice"):
        cutwise.load({"process": "deburr", 1: 2, "1": 3})


def test_numbers_and_paths_of_python_are_taken(examples, scenario):
    number = {**scenario.document(), "numerics": {"time_step": "20 us"}}
    assert cutwise.load(number, {"tool.flutes": np.int64(3)})["tool.flutes"] == 3
    stock = cutwise.load(examples / "mill_pocket.yaml")
    assert stock.with_({"program": Path(examples / "mill_pocket.nc")}).program.text == stock.program.text


@pytest.mark.parametrize("change", [
    {"spindle.pressure": "4 bar"}, {"operation.milling": "up"}, {"spindle.library": "prototype"},
    {"requirements.cutting_power_mean.max": "100 W"},
])  # fmt: skip
def test_with_is_load_with_overrides(examples, scenario, change):
    loaded = cutwise.load(examples / "deburr_compliant_spindle.yaml", change)
    assert scenario.with_(change) == loaded
    assert scenario.with_(change).with_({}) == loaded


def test_with_names_every_fault_as_load_does(examples, scenario):
    bad = {"spindle.pressure": 4, "spindle.presure": "4 bar", "operation.feed": "1 kg"}
    with pytest.raises(cutwise.ScenarioFault) as loaded:
        cutwise.load(examples / "deburr_compliant_spindle.yaml", bad)
    with pytest.raises(cutwise.ScenarioFault) as changed:
        scenario.with_(bad)
    assert str(changed.value) == str(loaded.value)
    assert str(changed.value).count("overrides[") == 3
    with pytest.raises(TypeError, match="expected dotted keys"):
        scenario.with_(["spindle.pressure=4 bar"])


def test_with_finds_files_beside_the_scenario(examples, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scenario = cutwise.load(examples / "mill_pocket.yaml")
    assert scenario.with_({"program": "mill_part.nc"}).program.text != scenario.program.text


def test_with_is_quick(scenario):
    scenario.with_({"spindle.pressure": "4 bar"})
    start = time.process_time()
    for bar in range(20):
        scenario.with_({"spindle.pressure": f"{4 + 0.05 * bar} bar"})
    assert (time.process_time() - start) / 20 < 15e-3  # 5 ms on an idle core


def test_values_by_key_in_si(examples, scenario):
    assert scenario["spindle.pressure"] == 5e5
    assert scenario["requirements.cutting_power_mean.max"] == 340.0
    chain = cutwise.load(examples / "machine_error_budget.yaml")
    assert chain["machine.chain[0].name"] == chain.machine.chain[0].name
    with pytest.raises(KeyError, match=r'no key "spindle.presure"; did you mean spindle.pressure\?'):
        scenario["spindle.presure"]
    with pytest.raises(KeyError, match="is left out"):
        scenario["robot.base"]
    for key in ("", "spindle.", "machine.chain[99]", "spindle.pressure.unit", "spindle[0]"):
        with pytest.raises(NoSuchName):
            (chain if "chain" in key else scenario)[key + ("x" if key.endswith(".") else "")]


def test_simulate_takes_what_load_takes(examples, scenario, result):
    for source in (str(examples / "deburr_compliant_spindle.yaml"), scenario.document()):
        found = cutwise.simulate(source)
        assert {n: m.value for n, m in found.measures.items()} == {n: m.value for n, m in result.measures.items()}


@pytest.mark.parametrize(("ask", "answer"), [
    (lambda r: r.measures["surface_eror_mean"], 'no measure "surface_eror_mean"; did you mean surface_error_mean?'),
    (lambda r: r["cuting"], 'no stage "cuting"; did you mean cutting?'),
    (lambda r: r["cutting"]["burr_forse"], 'no column "burr_forse"; did you mean burr_force?'),
    (lambda r: r["cutting/burr_forse"], 'no column "burr_forse"; did you mean burr_force?'),
    (lambda r: r.to_dataframe("cuting"), 'no stage "cuting"; did you mean cutting?'),
    (lambda r: r.plot("cutting/burr_forse"), 'no column "burr_forse"; did you mean burr_force?'),
    (lambda r: r.plot("burr_force"), 'no single column "burr_force"'),  # two stages have one
])  # fmt: skip
def test_a_wrong_name_is_answered_with_the_nearest(result, ask, answer):
    with pytest.raises(KeyError) as caught:
        ask(result)
    assert str(caught.value).startswith(answer)


def test_a_wrong_attribute_is_answered_too(result):
    with pytest.raises(AttributeError, match="did you mean burr_force"):
        result["cutting"].burr_forse  # noqa: B018
    assert result["cutting/power"].identical(result.stages["cutting"]["power"])
    assert result["cutting"].power.identical(result.stages["cutting"]["power"])


def test_histories_as_a_table(result):
    frame = result.to_dataframe("cutting")
    assert frame.index.name == "time"
    assert frame.attrs["units"] == {**{f"{of}_force_{a}": "N" for of in ("burr", "work") for a in "xyz"}, "power": "W"}
    assert np.array_equal(frame["burr_force_y"], result["cutting"].burr_force.sel(axis="y"))
    assert np.array_equal(frame.index, result["cutting"].time)
    assert result.to_dataframe("surface").attrs["left_out"] == ("error", "burr_height")  # over w, not over time
    assert result.to_dataframe("tooth").index.name == "tooth_time"


def test_measures_as_a_table(result):
    frame = result.measures.to_dataframe()
    assert list(frame.index) == list(result.measures)
    assert frame.loc["cutting_power_mean", "value"] == result.measures["cutting_power_mean"].value
    assert frame.loc["cutting_power_mean", "unit"] == "W"


def test_nothing_says_more_than_three_lines(result, scenario):
    for one in (result, scenario, result.measures, result.measures["surface_error_mean"], result.checks[0]):
        assert len(repr(one).splitlines()) <= 3
        assert len(repr(one)) < 500


def test_a_sweep_can_be_read_between_its_points(scenario):
    table = cutwise.sweep(scenario, {"spindle.pressure": ["4 bar", "5 bar"]}, check=False)
    coordinate = table["spindle.pressure"]
    assert coordinate.values.tolist() == [4e5, 5e5]
    assert (coordinate.attrs["units"], coordinate.attrs["display_unit"]) == ("Pa", "bar")
    assert coordinate.attrs["long_name"]
    power = table.cutting_power_mean
    between = table.interp({"spindle.pressure": 4.5e5}).cutting_power_mean
    assert float(between) == pytest.approx(float(power.mean()))
    assert float(power.sel({"spindle.pressure": 4.9e5}, method="nearest")) == float(power[1])
    assert table._repr_html_()


def test_figures_for_papers(result):
    import matplotlib.pyplot as plt

    drawn = result.plot("cutting/burr_force")
    (axes,) = drawn.axes
    assert drawn.get_size_inches()[0] * 25.4 == pytest.approx(85.0)
    assert axes.xaxis.label.get_size() == 8.0
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time [s]", "burr force [N]")
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["x", "y", "z"]
    assert not plt.get_fignums()
    wide = result.plot("surface/error", unit="um", width=170)
    assert wide.get_size_inches()[0] * 25.4 == pytest.approx(170.0)
    assert wide.axes[0].get_ylabel() == "error [µm]"
    error = wide.axes[0].lines[0]
    assert error.get_ydata()[-1] == pytest.approx(1e6 * float(result["surface"].error[-1]))
    limits = sorted(line.get_ydata()[0] for line in wide.axes[0].lines[1:])
    assert limits == pytest.approx([-50.0, 50.0])  # as the scenario requires
    own = plt.Figure().subplots()
    assert cutwise.plots.history(result, "cutting/power", ax=own) is own.figure
    with pytest.raises(UnitFault):
        result.plot("surface/error", unit="N")
    with pytest.raises(ValueError, match="85 mm"):
        result.plot(width=100)


def test_the_layers_below_do_not_import_the_figures():
    import subprocess
    import sys

    code = "import sys, cutwise.results, cutwise.io.scenario; print([m for m in sys.modules if m.startswith('cutwise.app')])"
    assert (
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip() == "[]"
    )


def test_notebooks_show_a_verdict_and_a_curve(result, scenario, examples):
    page = result._repr_html_()
    assert "PASS" in page
    assert "<svg" in page
    assert "Surface error, max" in page
    assert len(page) <= 60_000
    assert "<script" not in page
    marked = scenario.with_({"name": "<script>alert(1)</script>".replace("/", "|")})
    assert "<script" not in marked._repr_html_()
    assert "spindle.pressure" in marked._repr_html_()
    assert len(cutwise.load(examples / "mill_pocket_stock.yaml")._repr_html_()) <= 60_000
