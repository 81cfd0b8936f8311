"""A sweep is the same as its runs one by one."""

import pytest

from cutwise.io.scenario import load
from cutwise.process.recipes import quick_measures
from cutwise.spec.faults import ScenarioFault
from cutwise.study.sweep import sweep


def test_sweep_over_two_keys(examples):
    scenario = load(examples / "deburr_compliant_spindle.yaml")
    table = sweep(scenario, {"spindle.pressure": ["4 bar", "5 bar"], "operation.feed": ["60 mm/s", "80 mm/s"]})
    assert table.sizes == {"spindle.pressure": 2, "operation.feed": 2}
    here = table.surface_error_mean.sel({"spindle.pressure": "5 bar", "operation.feed": "80 mm/s"})
    assert float(here) == quick_measures(scenario)["surface_error_mean"]
    assert table.surface_error_mean.attrs["units"] == "m"
    assert float(
        table.surface_error_mean.sel({"spindle.pressure": "4 bar", "operation.feed": "80 mm/s"})
    ) == pytest.approx(0.170e-3, rel=0.03)


def test_all_faults_before_anything_runs(examples):
    scenario = load(examples / "deburr_compliant_spindle.yaml")
    with pytest.raises(ScenarioFault) as caught:
        sweep(scenario, {"operation.feed": ["-1 mm/s", "80", "60 mm/s"]})
    assert "impossible" in str(caught.value)
    assert "no unit" in str(caught.value)
