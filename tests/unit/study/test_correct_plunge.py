"""The force of a plunge: as the specification of the stock has it, as a limit, and with what it buys above the old feed."""

import pytest

import cutwise
from cutwise.io.scenario import load
from cutwise.process.recipes import quick_outcome
from cutwise.spec.faults import ScenarioFault

TEXT = "G21 G90 G94 S8000 M3\nG0 X20 Y10 Z5\nG1 Z-5 F300\nG1 X40 F1800\nG0 Z5\nM2\n"
SCENARIO = """process: mill
program: down.nc
stock: {x: [0 mm, 60 mm], y: [-10 mm, 40 mm], z: [-20 mm, 0 mm]}
tool: {diameter: 20 mm, flutes: 3, helix: 30 deg, flute_length: 40 mm, end_core: 0 mm}
material: {library: al7075t6}
machine: {library: fadal2216, reading: kp_ki_swapped}
correct: {limits: {force_xy_peak: {max: 900 N}}}
"""


@pytest.fixture(scope="module")
def down(tmp_path_factory):
    folder = tmp_path_factory.mktemp("down")
    (folder / "down.nc").write_text(TEXT, encoding="utf-8")
    (folder / "down.yaml").write_text(SCENARIO, encoding="utf-8")
    return folder / "down.yaml"


@pytest.mark.parametrize(("core", "force"), [("0 mm", 861.30), ("2 mm", 689.04)])
def test_the_force_is_that_of_the_specification(down, core, force):
    """stock.md 5 (e): D 20, three teeth, 5 mm/s at 8000 rpm."""
    run = cutwise.simulate(load(down, {"tool.end_core": core}))
    assert run.measures["plunge_force_max"].value == pytest.approx(force, abs=0.005)
    assert not any("plunges straight into the stock" in text for text in run.warnings)


@pytest.mark.parametrize(("core", "force"), [("0 mm", 861.30), ("2 mm", 689.04)])
def test_a_stock_in_3d_comes_to_the_same_by_its_elements(down, core, force):
    far = {"x": ["100 mm", "110 mm"], "y": ["100 mm", "110 mm"], "z": ["-20 mm", "-10 mm"]}
    scenario = load(
        down, {"tool.end_core": core, "fixtures": [far], "numerics.stock": {"grid": "0.5 mm"}, "correct": None}
    )
    assert scenario.in_3d
    assert quick_outcome(scenario).measures["plunge_force_max"] == pytest.approx(force, abs=0.005)


def test_without_a_bottom_there_is_none(down):
    run = cutwise.simulate(load(down, {"tool.end_core": None}))
    assert "plunge_force_max" not in run.measures
    assert any("plunges straight into the stock" in text for text in run.warnings)


@pytest.mark.parametrize(("limit", "feed"), [(830.0, 151), (900.0, 483)])
def test_a_limit_sets_the_feed_of_the_plunge(down, limit, feed):
    """F = N (K_rc f + K_re) R: 830 N at 151.6 mm/min, 900 N at 483.4, rounded down."""
    bound = {"correct.limits.plunge_force_max": {"max": f"{limit} N"}}
    found = cutwise.correct(load(down, bound))
    assert found.good, found.reasons
    assert f"G1 Z-5 F{feed}\n" in found.program
    assert found.after.measures["plunge_force_max"].value == pytest.approx(limit, rel=1e-3)
    assert found.after.measures["plunge_force_max"].value <= limit


def test_a_plunge_keeps_its_feed_without_a_limit(down):
    assert "G1 Z-5 F300\n" in cutwise.correct(load(down)).program


def test_what_no_feed_helps_and_what_has_no_bottom_is_said(down):
    found = cutwise.correct(load(down, {"correct.limits.plunge_force_max": {"max": "700 N"}}))
    assert any("no feed keeps plunge_force_max 700 N at line 3" in one for one in found.reasons)
    with pytest.raises(ScenarioFault, match=r"write tool\.end_core"):
        cutwise.correct(load(down, {"tool.end_core": None, "correct.limits.plunge_force_max": {"max": "900 N"}}))
    with pytest.raises(ScenarioFault, match="more than half the diameter"):
        load(down, {"tool.end_core": "11 mm"})
