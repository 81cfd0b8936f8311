"""What every process reads of a pass in the same way: structure, stop, drift, walls, terms, and the course of a run."""

import numpy as np
import pytest

from cutwise.io.scenario import load
from cutwise.physics.structure.terms import Rigid
from cutwise.process import passes, walls, yielding
from cutwise.process.convergence import divided
from cutwise.process.recipes import EVERYTHING, RECIPES, Method, Wanted, quick_outcome
from cutwise.spec.kinds import HOMES

TIME = np.linspace(0.0, 1.0, 11)


def test_without_terms_a_structure_is_rigid():
    assert isinstance(passes.structure_of(()), Rigid)
    spring = yielding.spring({1: 1e6})
    assert passes.structure_of((("tip", spring),)).matrix[0, 1, 1] == 1e-6


def test_the_stop_is_told_once_at_its_first_instant():
    (said,) = passes.at_stop(TIME, 1e-3 * TIME, 0.8e-3)
    assert (said.code, said.value, said.limit) == ("at_stop", 1e-3, 0.8e-3)
    assert said.where.time == pytest.approx(0.8)
    assert not list(passes.at_stop(TIME, 1e-3 * TIME, 1.1e-3))


def test_a_drift_is_that_of_the_last_third_against_the_first():
    (said,) = passes.drifting(0.25, 90e-6 * TIME[:-1])
    assert said.value == pytest.approx(90e-6 * 0.7)
    assert not list(passes.drifting(0.25, 1e-6 * TIME))
    assert not list(passes.drifting(0.25, np.zeros(0)))


def test_what_a_tool_yields_by_moves_one_wall_of_a_slot_in_and_the_other_out():
    wall, floor = 1e-6 * np.array([5.0, 7.0]), np.array([-1e-6, 2e-6])
    shoulder, slot = walls.measures(wall, floor, slot=False), walls.measures(wall, floor, slot=True, deeper=1e-6)
    assert (shoulder["wall_error_min"], shoulder["wall_error_max"]) == pytest.approx((5e-6, 7e-6))
    assert (slot["wall_error_min"], slot["wall_error_max"]) == pytest.approx((-5e-6, 7e-6))
    assert slot["floor_error_max"] == 2e-6


def test_of_drives_a_deviation_is_told_and_of_pistons_nothing_along_the_axis():
    each = np.array([[1.0, -2.0, 3.0], [1.0, 1.0, 3.0]])
    found = yielding.term_measures({"drives": each, "pistons": each, "tip": each}, slice(None), 0)
    assert found["deviation_drives_max"] == found["share_drives"] == -2.0
    assert not any(name.startswith("deflection_drives") for name in found)
    assert "deflection_pistons_mean_z" not in found
    assert (found["deflection_tip_mean_z"], found["deflection_tip_mean_y"]) == (3.0, -0.5)
    aside = yielding.term_measures({"tip": each}, slice(None), 1, off={"tip": each[:, 2]}, weights=np.array([1.0, 3.0]))
    assert (aside["share_tip"], aside["deflection_tip_mean_y"]) == (3.0, 0.25)
    assert yielding.stiffness_of(np.array([0.0, 1e-6])) == {}


@pytest.mark.parametrize("kind", HOMES)
def test_every_process_is_run_by_methods(kind, examples):
    """The one course of a run asks a process for a method, whatever the process is."""
    first = next(path for path in sorted(examples.glob("*.yaml")) if f"process: {kind}" in path.read_text("utf-8"))
    scenario = load(first)
    assert isinstance(RECIPES[kind].method(RECIPES[kind].read(scenario)), Method)


def test_a_coarse_case_has_no_words(examples):
    scenario = load(examples / "deburr_rigid_on_machine.yaml", ["operation.feed=400 mm/s"])
    fine, coarse = quick_outcome(scenario), quick_outcome(scenario, coarse=True)
    assert fine.warnings
    assert not coarse.warnings
    assert fine.measures == coarse.measures
    assert divided(scenario, "station").numerics.station == 0.5 * scenario.numerics.station


def test_a_whole_run_reads_everything():
    assert EVERYTHING.any(("deviation_p95",))
    assert not Wanted(frozenset(("tilt",)), whole=False).any(("deviation_p95",))
    assert Wanted(frozenset(("tilt",)), whole=False).any(("tilt", "deviation_p95"))
