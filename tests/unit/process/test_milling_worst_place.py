"""The worst force of a program stands where feed and contact meet, and a block is removed once."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from cutwise.io.scenario import load
from cutwise.process import milling_measures
from cutwise.process.recipes import quick_measures
from cutwise.results import SolverFailure
from cutwise.spec.program import StockBlock

HEAD = """
process: mill
program: part.nc
stock: {x: [0 mm, 60 mm], y: [-20 mm, 20 mm], z: [-10 mm, 0 mm]}
operation: {spindle_speed: 8000 rpm}
tool: {diameter: 10 mm, flutes: 2, helix: 30 deg}
material: {library: al7075t6}
machine: {library: fadal2216, reading: kp_ki_swapped}
numerics: {force: averaged, settling_time: 0.1 s}
"""
START = "G21 G90 S8000 M3\nG0 X-10 Y0 Z5\nZ-3\n"
SLOT, SIDE = "G1 X70 F{slot}\n", "G0 Z5\nX-10 Y-2\nZ-3\nG1 X70 F{side}\n"
AIR = "G0 Z5\nX-10 Y30\nZ-3\nG1 X70 F4800\n"


def measured(folder, text, *changes):
    (folder / "part.nc").write_text(text + "G0 Z5\nM30\n")
    (folder / "part.yaml").write_text(HEAD)
    return quick_measures(load(folder / "part.yaml", changes))


def test_the_slot_at_its_own_feed_and_not_at_the_fastest(tmp_path):
    """A slot at 1200 mm/min, then a quick pass 2 mm wide, then a feed move in air: the slot's force is the slot's alone."""
    alone = measured(tmp_path, START + SLOT.format(slot=1200))
    mixed = measured(tmp_path, START + SLOT.format(slot=1200) + SIDE.format(side=2400) + AIR)
    for name in ("force_xy_mean_corner", "force_xy_peak_corner"):
        assert mixed[name] == pytest.approx(alone[name], rel=1e-9)
    assert mixed["engagement_angle_max"] == pytest.approx(math.pi)


def test_the_lighter_contact_counts_where_its_feed_makes_it_the_heavier(tmp_path):
    """The slot at a crawl: the heaviest place is the quick pass; its force is what it is when the slot is run at its feed."""
    crawl = measured(tmp_path, START + SLOT.format(slot=60) + SIDE.format(side=6000))
    quick = measured(tmp_path, START + SLOT.format(slot=6000) + SIDE.format(side=6000))
    slot = measured(tmp_path, START + SLOT.format(slot=60))
    assert slot["force_xy_mean_corner"] < crawl["force_xy_mean_corner"] < quick["force_xy_mean_corner"]


def test_without_a_stock_too(tmp_path):
    """An inner corner at half the feed of the lines: corner and straight each at the feed of their own place."""
    text = "G21 G90 S8000 M3\nG0 X-60 Y0 Z5\nZ-3\nG1 X-10 F2400\nX0 F{corner}\nY10\nG1 Y60 F2400\n"
    wall = (
        "stock=null",
        "operation={spindle_speed: 8000 rpm, radial_depth: 2 mm, axial_depth: 3 mm}",
        "path_mode=exact_stop",
    )
    slow = measured(tmp_path, text.format(corner=240), *wall)
    even = measured(tmp_path, text.format(corner=2400), *wall)
    assert slow["force_xy_mean_straight"] == pytest.approx(even["force_xy_mean_straight"], rel=1e-9)
    assert slow["force_xy_mean_corner"] < 0.8 * even["force_xy_mean_corner"]


@pytest.mark.parametrize("step", [None, 1.3])
def test_a_raster_removes_the_block_once(tmp_path, step):
    """30 x 30 x 1 mm, as long lines and in short moves: 0.900 cm3."""
    lines, k, y = ["G21 G90 S8000 M3", "G0 X-4 Y-1.5 Z5", "Z-1"], 0, -1.5
    while y < 33.0:
        ends = (-4.0, 34.0) if k % 2 == 0 else (34.0, -4.0)
        count = 1 if step is None else math.ceil(38.0 / step)
        lines += [f"G1 X{ends[0] + (ends[1] - ends[0]) * i / count:.4f} F6000" for i in range(1, count + 1)]
        y, k = y + 1.5, k + 1
        lines.append(f"Y{y:.3f}")
    changes = (
        "stock={x: [0 mm, 30 mm], y: [0 mm, 30 mm], z: [-5 mm, 0 mm]}",
        "tool.diameter=6 mm",
        "numerics.force=none",
    )
    found = measured(tmp_path, "\n".join(lines) + "\n", *changes)
    assert found["removed_volume"] == pytest.approx(0.9e-6, rel=3e-3)


def test_more_than_the_block_is_no_result():
    """Contact that would take a block one and a half times over stops the run."""
    size = {"x": ["0 mm", "30 mm"], "y": ["0 mm", "30 mm"], "z": ["0 mm", "1 mm"]}
    block = SimpleNamespace(stock=StockBlock.model_validate(size))
    way = SimpleNamespace(reference=SimpleNamespace(travelled=np.linspace(0.0, 10.0, 10_001)))
    taken = np.full(10_001, 0.89e-7)
    assert milling_measures._removed(block, way, taken) == pytest.approx(0.89e-6)
    with pytest.raises(SolverFailure, match="takes 1350 mm³ of a block of 900 mm³"):
        milling_measures._removed(block, way, 1.35e-7 * np.ones(10_001))
