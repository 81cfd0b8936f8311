"""An edge at rest under a rigid spindle: case 4f of the specification of the cell, laws of its terms, what is refused."""

import numpy as np
import pytest

import cutwise
from cutwise.physics.structure.terms import Compliance, in_series
from cutwise.process import still_deburring, yielding
from cutwise.process.assemble import edge_cut, rigid_wrench
from cutwise.process.loops import EdgeCut, still_edge
from cutwise.process.plateaus import band
from peers.cells import MM, r0

UM = 1e-6
HEIGHT = 0.5 * MM
AT = np.array([0.15])
REST = ["spindle=rigid", "numerics={mode: still}", "operation.preset=0 mm"]


def at_rest(*terms, preset=0.0):
    """Edge error [um] and mean force of the burr off the edge [N] of R0 on some static terms."""
    cell = r0(preset=preset)
    cut = EdgeCut(cell.path, cell.layers, cell.cutter)
    found = still_edge(cut, in_series(list(terms)), AT)
    total = sum(yielding.by_term([(str(k), t) for k, t in enumerate(terms)], found.state, HEIGHT).values())
    return (total[0, 1] - preset) / UM, found.layer[0, 0, 1]


@pytest.fixture(scope="module")
def on_robot(examples):
    return lambda *more: cutwise.load(
        examples / "deburr_on_robot.yaml", [*REST, "requirements=null", "robot.redundancy_angle=0 deg", *more]
    )


@pytest.fixture(scope="module")
def on_machine(examples):
    return lambda *more: cutwise.load(examples / "deburr_rigid_on_machine.yaml", ["tool.stiffness=null", *more])


@pytest.mark.parametrize(("angle", "error", "force"), [(0, 5.770537, 9.280965), (-90, 7.739154, 9.260088)])
def test_edge_on_an_arm(on_robot, angle, error, force):
    done = still_deburring.run(on_robot(f"robot.redundancy_angle={angle} deg"))
    middle = int(np.argmin(np.abs(done.at - 0.15)))
    assert done.error[middle] / UM == pytest.approx(error, rel=1e-6)
    assert done.rest.layer[middle, 0, 1] == pytest.approx(force, rel=1e-6)
    measures = still_deburring.measures(on_robot(), done)
    assert measures["energy_balance"] < 1e-12
    assert measures["share_arm"] == pytest.approx(measures["surface_error_max"], rel=1e-12)


@pytest.mark.parametrize(("stiffness", "error"), [(2e5, 44.363139), (5e4, 154.399973)])
def test_edge_on_a_spring(stiffness, error):
    assert at_rest(yielding.spring({1: stiffness}))[0] == pytest.approx(error, rel=1e-6)


def test_two_springs_in_series_are_one():
    one = at_rest(yielding.spring({1: 5e4}))[0]
    two = at_rest(yielding.spring({1: 8e4}), yielding.spring({1: 1.0 / (1 / 5e4 - 1 / 8e4)}))[0]
    assert two == pytest.approx(one, rel=1e-9)


def test_a_soft_spring_has_its_root_though_the_plain_iteration_alternates():
    """No burr, preset 0.1 mm, 20 um/N: the slope of C F is -1.41."""
    cell = r0(preset=0.1 * MM, burr=0.0)
    cut = EdgeCut(cell.path, cell.layers, cell.cutter)
    found = still_edge(cut, yielding.spring({1: 5e4}), AT)
    assert (found.state[0, 1] - 0.1 * MM) / UM == pytest.approx(-42.98989, abs=1e-5)
    assert found.total[0, :3] == pytest.approx([3.842811, 2.850505, -1.642093], abs=1e-6)


def test_edge_on_the_bodies_of_a_machine(on_machine):
    """At X = 0; the digits of the specification are for forces alone, moments of the force add 0.8 nm."""
    cut = edge_cut(on_machine("numerics.station=100 mm"))
    ((name, term),) = cut.behind
    assert name == "bodies"
    forces = term.matrix.copy()
    forces[:, 3:] = forces[:, :, 3:] = 0.0
    assert at_rest(Compliance(term.at - term.at[1] + AT, forces))[0] == pytest.approx(0.663462, abs=1e-6)
    done = still_deburring.run(on_machine("numerics.station=100 mm"))
    assert done.error[1] / UM == pytest.approx(0.664269, abs=1e-6)
    assert rigid_wrench(cut)[2] < 0.0  # the helix pulls


def test_machine_measures_and_shares(on_machine):
    scenario = on_machine("tool.stiffness=5 N/um", "numerics.station=50 mm")
    found = still_deburring.measures(scenario, still_deburring.run(scenario))
    assert found["share_bodies"] + found["share_tip"] == pytest.approx(found["surface_error_max"], rel=1e-12)
    assert found["deflection_tip_max_y"] == pytest.approx(found["burr_force_mean_y"] / 5e6, rel=1e-3)
    assert found["energy_balance"] < 1e-12


def test_modes_of_the_tip_count_by_their_stiffness(on_machine):
    modes = "tool.modes=[{direction: y, frequency: 1 kHz, damping: 0.03, stiffness: 5 N/um}]"
    ((name, term), _) = edge_cut(on_machine(modes, "numerics.station=200 mm")).behind
    assert name == "tip"
    assert np.diag(term.matrix[0]) == pytest.approx([0.0, 2e-7, 0.0, 0.0, 0.0, 0.0], rel=1e-12)
    with pytest.raises(cutwise.ScenarioFault, match="both say how the tool bends"):
        on_machine(modes, "tool.stiffness=5 N/um")


def test_nothing_that_yields_leaves_the_preset(examples):
    scenario = cutwise.load(
        examples / "deburr_rigid_on_machine.yaml",
        ["machine=null", "path=null", "part.block=null", "tool.stiffness=null", "operation.length=20 mm",
         "operation.preset=0.1 mm", "requirements=null"],
    )  # fmt: skip
    done = still_deburring.run(scenario)
    assert done.error == pytest.approx(np.full(5, -1e-4), abs=1e-15)


def test_bodies_behind_pistons_leave_the_band_alone(examples):
    """Legal in time steps: the spindle on a machine chain. The plateaus do not know what is behind the pistons."""
    compliant = ["spindle={library: berselli2016}", "numerics={mode: step, time_step: 100 us}", "operation.preset=2 mm",
                 "requirements=null", "operation.duration=0.6 s"]  # fmt: skip
    with_bodies = cutwise.load(examples / "deburr_rigid_on_machine.yaml", compliant)
    found = cutwise.simulate(with_bodies).measures
    assert found["surface_error_loaded"].value == pytest.approx(band(r0(), 1 * MM, 1 * MM).loaded.error, abs=2e-9)
    assert found["share_bodies"].value == pytest.approx(0.7e-6, abs=0.1e-6)


REFUSED = {
    "spindle={library: berselli2016}": "pistons remember how they were loaded",
    "robot={library: kr270_r2700}": "the tool has one carrier",
    "part.stiffness=1 N/um": "both say how the part yields",
    "machine=null": "stands on the table of a machine",
    "path=null": "a machine needs to know where the edge is",
    "machine.tip=null": "where the tool point is",
    "tool.runout=5 um": "surface with memory",
    "placement={origin: [0 mm, 0 mm, 0 mm]}": "places a part before a robot",
    "numerics.force=tooth_resolved": "the mean force of the teeth counts",
    "machine.drives={library: fadal2216}": "drives need time stepping",
}


@pytest.mark.parametrize("change", REFUSED)
def test_what_is_refused_and_why(on_machine, change):
    with pytest.raises(cutwise.ScenarioFault, match=REFUSED[change]):
        on_machine(change)


def test_a_place_beyond_the_travel_is_told(on_machine):
    far = "path.line={from: [-100 mm, -40 mm, 295 mm], to: [160 mm, -40 mm, 295 mm]}"
    with pytest.raises(cutwise.ScenarioFault, match="leads axis X to 290 mm, beyond its travel of 0 mm to 260 mm"):
        edge_cut(on_machine(far))


def test_a_tool_that_does_not_stand_as_the_spindle_is_told(on_machine):
    with pytest.raises(cutwise.ScenarioFault, match="the spindle of this machine points along"):
        edge_cut(on_machine("path.tool_axis=[0, 1, 0]"))


def test_what_cannot_be_reached_is_a_verdict_and_no_failure(on_robot):
    far = "path.line={from: [4900 mm, -150 mm, 800 mm], to: [4900 mm, 150 mm, 800 mm]}"
    result = cutwise.simulate(on_robot(far))
    assert result.verdict == "fail"
    assert "the robot cannot follow the path" in result.infeasible[0]
