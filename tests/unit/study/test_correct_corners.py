"""Sharp corners of a shifted path: both sides meet there, and what a drive runs on beyond is taken back where it happens."""

import math

import numpy as np
import pytest

from cutwise import units
from cutwise.io.scenario import load
from cutwise.process import milling
from cutwise.study.correct import corners, path, shift

UM = 1e-6


@pytest.fixture(scope="module")
def plant(examples, tmp_path_factory):
    """Four sides, stops at the corners: turns of 90, 90, -37 and 97 degrees."""
    file = tmp_path_factory.mktemp("corners") / "corners.nc"
    file.write_text(
        "G21 G90 G17 G94 G61.1\nS8000 M3\nG0 Z-5\nG1 X20 Y0 F2400\nG1 Y20\nG1 X0\nG1 X-12 Y29\nG1 X-20 Y15\nM2\n"
    )
    scenario = load(examples / "mill_pocket.yaml", [
        f"program={{file: {file}, start: {{x: 0 mm, y: 0 mm, z: 5 mm}}}}", "requirements=null", "numerics.settling_time=0.1 s",
        "correct={change: [path]}",
    ])  # fmt: skip
    return shift.Plant(scenario, milling.commanded(scenario, scenario.numerics.substeps))


def test_a_corner_is_as_far_from_both_sides_as_they_are_shifted(plant):
    wanted = plant.told.wanted
    joints = corners.sharp_corners(wanted)
    assert len(joints) == 4
    for joint in joints:
        moved = corners.meeting(wanted, int(joint), 3 * UM, -5 * UM)
        normals = [np.array([d[1], -d[0]]) for d in wanted.curve.along[[joint, joint + 1], :2]]
        assert [float(moved @ n) / UM for n in normals] == pytest.approx([3.0, -5.0], abs=1e-9)
    first = corners.meeting(
        wanted, int(joints[0]), 0.0, -10 * UM
    )  # to the left at a right angle: back along the first side
    assert first / UM == pytest.approx([-10.0, 0.0], abs=1e-9)


def test_set_points_and_chords_go_to_the_same_corner(plant):
    told = plant.told
    given = np.where(told.place.block >= corners.sharp_corners(told.wanted)[0] + 1, -10 * UM, 4 * UM)
    led = shift.shifted(told, given)
    end = int(np.searchsorted(told.place.block, corners.sharp_corners(told.wanted)[0], side="right")) - 1
    off = led.point[end, :2] - told.order.point[end, :2]
    assert off / UM == pytest.approx([-10.0, -4.0], abs=0.5)  # the last instant stands a little before the corner
    far = end - 500
    assert (led.point[far, :2] - told.order.point[far, :2]) / UM == pytest.approx([0.0, -4.0], abs=1e-6)
    along, first = np.unique(told.place.travelled, return_index=True)
    found = shift.Learned(along, given[first], (), shift.rule_of(told, 50.0, 0.0, 0.0), whole=True)
    at, point = shift.chords(told.wanted, found, 0.1e-3)
    knot = told.wanted.curve.knots[corners.sharp_corners(told.wanted)[0] + 1]
    vertices = point[at == knot, :2]
    assert len(vertices) == 2
    assert vertices - np.array([20e-3, 0.0]) == pytest.approx(np.array([[-10 * UM, -4 * UM]] * 2), abs=1e-9)


def test_what_is_run_on_beyond_a_corner_is_taken_back_in_the_written_program(plant):
    """30 µm at stops: with a path that began to lead back behind the corner half of it was left, 22 µm in the whole run."""
    told, said = plant.told, plant.scenario.correct
    before = shift.seen([plant], told.order).error[0]
    assert np.abs(before).max() > 25 * UM
    rule = shift.rule_of(told, plant.scenario.drives.limits.jerk, None, None)
    best, _ = path._proved(plant, shift.learn([plant], rule, said.iterations), [plant], said)
    assert best.residual < 0.25 * np.abs(before).max(), units.show(best.residual, "small_length")
    assert np.abs(best.error).max() < 0.6 * np.abs(before).max()  # stops included


def test_a_path_without_sharp_corners_has_none(examples):
    scenario = load(examples / "mill_pocket_corner.yaml", ["path.corner=2 mm", "path.compare=[]"])
    told = milling.commanded(scenario, scenario.numerics.substeps)
    assert corners.sharp_corners(told.wanted).size == 0
    assert math.isclose(corners.OVER, 1e-4)
