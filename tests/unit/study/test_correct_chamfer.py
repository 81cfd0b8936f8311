"""A chamfer under a structure that yields: the path is led as much deeper as the ball is carried off, and no more."""

import re

import numpy as np
import pytest

import cutwise
from cutwise.io.scenario import load
from cutwise.process import chamfer
from cutwise.spec.faults import ScenarioFault
from cutwise.study.correct import formats
from cutwise.study.correct.chamfer import left

SOFT = ["robot=null", "placement=null", "tool.stiffness=0.05 N/um", "path.points=360", "requirements=null"]


@pytest.fixture(scope="module")
def soft(examples):
    return cutwise.correct(load(examples / "chamfer_on_robot.yaml", SOFT), ("offset",))


def test_the_path_is_led_deeper_by_what_the_tool_bends(soft):
    """F/k across the rod, against the width: (F/k . b)/(off . b) with the direction b into the chamfer, F of a rigid tool."""
    before = chamfer.run(soft.before.scenario, wanted=frozenset())
    path, force = before.paths[0], before.forces[0].force
    axes = np.stack([path.local.feed, path.local.off], axis=1)
    bent = np.einsum("ij,ijk->ik", force[:, :2], axes) / 0.05e6
    into = -path.path.air
    expected = np.einsum("ij,ij->i", bent, into) / np.einsum("ij,ij->i", path.local.off, into)
    done = chamfer.run(soft.scenario, wanted=frozenset())
    led = -np.einsum("ij,ij->i", done.programmed[0].path.centre - path.path.centre, path.local.off)
    assert np.abs(expected).max() > 5e-6
    assert led == pytest.approx(expected, rel=0.06)  # what is dragged along the feed counts to the second order


def test_what_is_left_is_measured_on_the_path_that_is_written(soft):
    assert soft.good
    assert soft.measures["residual_ratio"].value < 0.02
    assert left(soft.scenario).worst == soft.measures["residual_max"].value
    assert soft.measures["width_deflected_min_before"].value < 0.295e-3
    assert soft.measures["width_deflected_min_after"].value == pytest.approx(0.3e-3, abs=0.2e-6)
    centre = 1e3 * chamfer.run(soft.scenario, wanted=frozenset()).programmed[0].path.centre
    text = formats.rs274(soft)
    words = [dict(re.findall(r"([XYZ])([-0-9.]+)", line)) for line in text.split("\n") if line.startswith("G1 ")]
    at = np.array([[float(one[axis]) for axis in "XYZ"] for one in words if len(one) == 3])
    at[:, 2] += 2.0  # the tip is a radius below the centre of the ball
    nearest = np.linalg.norm(at[:, None] - centre[None], axis=2).min(axis=0)
    assert nearest.max() < 1.5e-6
    assert formats.apt(soft).startswith("PARTNO/")
    assert formats.poses(soft).startswith("#")


def test_a_program_that_misses_says_so_in_a_comment_of_its_language(soft):
    from dataclasses import replace

    missed = replace(soft, reasons=("too wide",))
    assert "(cutwise: not good enough: too wide)" in formats.rs274(missed).split("\n")[:3]
    assert formats.apt(missed).startswith("$$ cutwise: misses too wide")
    assert formats.poses(missed).startswith("# cutwise: misses too wide")


def test_corrected_twice_nothing_is_off(soft):
    with pytest.raises(ScenarioFault, match="the width is off by"):
        cutwise.correct(soft.scenario, ("offset",))


def test_what_no_offset_corrects_is_refused_in_words(examples):
    with pytest.raises(ScenarioFault, match="gives way at its constant force"):
        cutwise.correct(load(examples / "chamfer_compliant_spindle.yaml", ["path.points=120"]), ("offset",))
    with pytest.raises(ScenarioFault, match="nothing takes the ball off"):
        cutwise.correct(load(examples / "chamfer_pipe_hole.yaml", ["path.points=120"]), ("offset",))


def test_a_table_of_presets_reaches_round_the_edge(examples):
    short = 'operation.preset_profile={columns: {"w [mm]": [0, 5], "preset [mm]": [0, 0.01]}}'
    with pytest.raises(ScenarioFault, match="nothing is extrapolated"):
        left(load(examples / "chamfer_on_robot.yaml", [*SOFT, short]))


def test_a_table_of_one_preset_is_that_preset(examples):
    """To the last bit, in the loop of a structure with memory too."""
    given = ["path.points=120", "requirements=null", "operation.preset=0 mm"]
    table = 'operation.preset_profile={columns: {"w [mm]": [0, 90], "preset [mm]": [0.1, 0.1]}}'
    with_table, plain = (
        chamfer.run(load(examples / "chamfer_compliant_spindle.yaml", one), wanted=frozenset())
        for one in ([*given, table], [*given[:-1], "operation.preset=0.1 mm"])
    )
    assert np.array_equal(with_table.deflected[0].width, plain.deflected[0].width)
    assert np.array_equal(with_table.programmed[0].path.centre, plain.programmed[0].path.centre)
