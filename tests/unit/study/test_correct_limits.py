"""Limits that exclude one another, or that nothing keeps: never called good, and found out without further runs."""

import pytest

import cutwise
from cutwise.io.scenario import load
from cutwise.spec.correct import Correction
from cutwise.spec.faults import ScenarioFault
from cutwise.study.correct import prove
from cutwise.study.correct.feed import prepared, speeds_of
from cutwise.study.correct.limits import asked, resolved
from cutwise.study.correct.loads import allowed, largest_sines


def limited(slot, **limits):
    return load(slot, {"correct.limits": limits})


def test_limits_that_exclude_one_another_are_not_kept(slot):
    """10 mm/s make 0.05 mm: 0.049 mm takes 9.8 mm/s, 190 N allow less; the upper limit wins, and it is no good program."""
    found = cutwise.correct(limited(slot, force_xy_peak={"max": "190 N"}, chip_thickness_min={"min": "49 um"}))
    assert not found.good
    assert found.measures["force_xy_peak_after"].value <= 190.0
    said = [one for one in found.reasons if "limits exclude one another" in one]
    assert [one.split(" (")[0] for one in said] == ["line 4 of the program", "line 5 of the program"]
    assert "at least 9.8 mm/s (chip_thickness_min 49 µm) and at most 6.956 mm/s (force_xy_peak)" in said[0]


def test_thin_chips_of_an_entry_are_told_and_no_reason(slot):
    found = cutwise.correct(limited(slot, force_xy_peak={"max": "240 N"}, chip_thickness_min={"min": "30 um"}))
    assert found.good, found.reasons
    ready = prepared(found.scenario, Correction())
    fed = speeds_of(ready) * ready.cutting.per_speed
    thickest = fed * largest_sines(ready.cells.patches)
    steady = largest_sines(ready.cells.patches) > 1.0 - 1e-6
    assert thickest[steady].min() >= 0.99 * 30e-6


def test_a_line_that_keeps_its_feed_below_the_least_chip_is_no_good_program(slot):
    text = (
        slot.with_name("side.nc").read_text(encoding="utf-8").replace("G1 X8 F600", "/G1 X8 F60")
    )  # a block that may be skipped keeps its feed
    other = limited(slot, force_xy_peak={"max": "260 N"}, chip_thickness_min={"min": "30 um"})
    found = cutwise.correct(other.model_copy(update={"program": other.program.model_copy(update={"text": text})}))
    assert any(one.startswith("line 4") and "the line keeps 1 mm/s" in one for one in found.reasons)


def test_a_least_chip_is_nothing_to_be_equal_to(slot):
    with pytest.raises(ScenarioFault, match="at entries any run has chips of no thickness"):
        cutwise.correct(limited(slot, chip_thickness_min="equal"))


def test_a_limit_that_no_feed_keeps_costs_one_run(slot, monkeypatch):
    runs = []
    simulate = prove.simulate
    monkeypatch.setattr(prove, "simulate", lambda *given: runs.append(1) or simulate(*given))
    found = cutwise.correct(limited(slot, force_xy_peak={"max": "20 N"}))
    assert not found.good
    assert any("no feed keeps force_xy_peak 20 N" in one for one in found.reasons)
    assert len(runs) == 1


def test_largest_sines_are_those_of_the_limits(slot):
    """A chip limit over the thickest chip of a cell is its feed per tooth."""
    scenario = limited(slot, chip_thickness_max={"max": "60 um"})
    ready = prepared(scenario, scenario.correct)
    limits = resolved(asked(scenario, scenario.correct, walls=False), {})
    room = allowed(scenario, ready.path, ready.cells, ready.cutting, limits)
    cuts = ready.cells.cuts
    sine = largest_sines(ready.cells.patches)[cuts]
    assert (room.each[cuts, 4] * ready.cutting.per_speed[cuts] * sine) == pytest.approx(60e-6, rel=1e-9)
