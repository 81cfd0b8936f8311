"""A small made-up result, the reference run once, and the command line called in this process."""

from datetime import UTC, datetime
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from cutwise.app import cli
from cutwise.app.report import render
from cutwise.io.scenario import load
from cutwise.process.recipes import simulate
from cutwise.results import Measure, Result, judge


@pytest.fixture(scope="session")
def reference(examples):
    """The reference case, run."""
    return simulate(load(examples / "deburr_compliant_spindle.yaml"))


@pytest.fixture(scope="session")
def html(reference):
    """Its report."""
    return render(reference, written=datetime(2026, 1, 2, 3, 4, tzinfo=UTC))


@pytest.fixture
def made_up(examples):
    """A result with chosen numbers; keyword arguments replace parts."""
    scenario = load(examples / "deburr_compliant_spindle.yaml")

    def make(error=1e-5, **parts):
        measures = {
            "surface_error_max": Measure(error, "length", "largest edge error"),
            "surface_error_min": Measure(-1e-5, "length", "smallest edge error"),
            "cutting_power_mean": Measure(200.0, "power", "cutting power"),
        }
        time = np.linspace(0.0, 0.6, 50)
        error_at_tool = xr.DataArray(np.zeros(50), {"time": time}, ["time"], attrs={"units": "m"})
        stages = xr.DataTree.from_dict({"surface": xr.Dataset({"error_at_tool": error_at_tool})})
        given = parts.pop("scenario", scenario)
        checks = tuple(judge(given, measures))
        return Result(scenario=given, stages=stages, measures=measures, checks=checks, **parts)

    return make


@pytest.fixture
def cutwise(capsys, tmp_path, monkeypatch):
    """The command line: called with its arguments, gives back the exit code and what it wrote."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        with pytest.raises(SystemExit) as left:
            cli.main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return SimpleNamespace(code=left.value.code, out=captured.out, err=captured.err)

    return call
