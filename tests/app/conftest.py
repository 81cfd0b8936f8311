"""A small made-up result, the reference run once, and a small pocket."""

from datetime import UTC, datetime

import numpy as np
import pytest
import xarray as xr

from cutwise.app.report import render
from cutwise.io.scenario import load
from cutwise.process.recipes import simulate
from cutwise.results import Measure, Result, judge


@pytest.fixture(scope="session")
def reference(run_of):
    """The reference case, run."""
    return run_of("deburr_compliant_spindle")


@pytest.fixture(scope="session")
def html(reference):
    """Its report."""
    return render(reference, written=datetime(2026, 1, 2, 3, 4, tzinfo=UTC))


SMALL_PROGRAM = """%
(a slot, then back along its wall: </script><b>this</b> is text)
G21 G17 G90 G94 G40
T1 M6
S8000 M3
G0 X-12 Y20 Z5
G0 Z-2
G1 X30 F3000
G1 Y26
G1 X72
G0 Z5
M30
%
"""


@pytest.fixture(scope="session")
def small_pocket(examples, tmp_path_factory):
    """Drives, a tool that swings and a block, as in mill_pocket_stock, along two seconds of a program; run."""
    folder = tmp_path_factory.mktemp("small")
    text = (examples / "mill_pocket_stock.yaml").read_text(encoding="utf-8")
    for old, new in (
        ("program: mill_pocket.nc", "program: small.nc"),
        ("name: mill_pocket_stock", "name: small_pocket"),
        (
            "x: [-30 mm, 130 mm], y: [-30 mm, 90 mm], z: [-20 mm, 0 mm]",
            "x: [0 mm, 60 mm], y: [0 mm, 40 mm], z: [-10 mm, 0 mm]",
        ),
    ):
        assert old in text
        text = text.replace(old, new)
    (folder / "small.nc").write_text(SMALL_PROGRAM, encoding="utf-8")
    (folder / "small.yaml").write_text(text, encoding="utf-8")
    return simulate(load(folder / "small.yaml"))


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
