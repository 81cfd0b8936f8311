"""No measure differs between a run, a sweep, advice and Python by more than the stated tolerance, for every example."""

import pytest

from cutwise.io.scenario import load
from cutwise.process.recipes import coarser, quick_outcome, simulate
from cutwise.study.case import TOLERANCE, cases, faithful
from cutwise.study.sweep import sweep

EXAMPLES = (
    "chamfer_compliant_spindle", "chamfer_pipe_hole", "deburr_compliant_spindle", "drill_robot", "machine_error_budget",
    "machine_five_axis", "machine_pocket", "machine_volumetric_map", "mill_pocket", "mill_pocket_corner",
    "turn_shaft",
    pytest.param("drill_plate_pattern", marks=pytest.mark.slow),
    pytest.param("mill_pocket_stock", marks=pytest.mark.slow),
    pytest.param("chamfer_step_part", marks=pytest.mark.slow),
)  # fmt: skip


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_same_number_everywhere(examples, run_of, name):
    """A study's case is its run to the last bit; where advice takes a coarser step, within one hundredth of the limit."""
    if name == "chamfer_step_part":
        pytest.importorskip("OCP")
    scenario = load(examples / f"{name}.yaml")
    run = run_of(name)
    case = cases(scenario, list(scenario.measures))({})
    assert case.failure is None
    assert {key: run.measures[key].value for key in case.measures} == dict(case.measures)
    assert case.outcome.infeasible == run.infeasible
    assert set(case.outcome.warnings) <= set(run.warnings)
    advice = quick_outcome(scenario, coarse=True)
    names = [key for key in (*scenario.requirements, scenario.focus) if key in run.measures]
    found = {key: run.measures[key].value for key in run.measures}
    assert faithful(scenario, advice.measures, found, names)
    if not coarser(scenario):
        assert {key: found[key] for key in advice.measures} == dict(advice.measures)
    assert TOLERANCE == 0.01


def test_a_sweep_of_a_program_is_its_runs(examples):
    scenario = load(examples / "mill_pocket_corner.yaml", ["path.compare=[]"])
    table = sweep(scenario, {"operation.feed": ["30 mm/s", "40 mm/s"]})
    for place, feed in enumerate(("30 mm/s", "40 mm/s")):
        run = simulate(load(examples / "mill_pocket_corner.yaml", {"path.compare": [], "operation.feed": feed}))
        for name in set(run.measures) & set(table.data_vars):
            assert float(table[name][place]) == run.measures[name].value, name
        assert set(table.warnings.values[place].splitlines()) == set(run.warnings)
