"""Drilling on a machine chain, on a robot with its base, into a part that yields: case 4e, laws of what yields at once."""

import numpy as np
import pytest

import cutwise
from cutwise.process import drilling
from cutwise.process.drilling_at_rest import quasi_static_hole
from cutwise.process.loops_drilling import bodies_at_once, drill_hole, on_part
from cutwise.process.recipes import quick_outcome

UM = 1e-6
THRUST = 163.8943667  # [N] Al, D6, f 0.1
BASE = "robot.base_compliance=[0.01 um/N, 0.01 um/N, 0.01 um/N, 0.02 urad/N/m, 0.02 urad/N/m, 0.02 urad/N/m]"


@pytest.fixture(scope="module")
def on_machine(examples):
    return lambda *more: cutwise.load(examples / "drill_on_machine.yaml", ["requirements=null", *more])


@pytest.fixture(scope="module")
def on_robot(examples):
    return lambda *more: cutwise.load(examples / "drill_robot.yaml", ["requirements=null", *more])


@pytest.fixture(scope="module")
def measures(on_machine):
    return quick_outcome(on_machine("contact.wall_stiffness=0 N/um")).measures


def test_machine_of_the_specification(measures):
    assert measures["compliance_axial"] / UM == pytest.approx(0.0260073, abs=1e-7)
    assert measures["axial_deflection_mean"] / UM == pytest.approx(-4.262453, abs=1e-6)
    assert measures["lateral_deflection_mean"] / UM == pytest.approx(0.958608, abs=1e-6)
    assert measures["skating_ratio"] == pytest.approx(0.085163, abs=1e-6)
    assert measures["thrust_mean"] == pytest.approx(THRUST, rel=1e-9)


def test_shares_are_the_whole(measures):
    assert measures["share_bodies"] == pytest.approx(measures["axial_deflection_mean"], rel=1e-6)
    assert not {"redundancy_angle", "wrist_margin", "joint_limit_margin", "natural_frequency_min"} & set(measures)


def test_robot_with_its_base(on_robot):
    """Without a wall to hold it, the drill goes back by C_zz times thrust; the mass only swings about it."""
    found = quick_outcome(on_robot(BASE, "contact.wall_stiffness=0 N/um")).measures
    assert found["skating_ratio"] == pytest.approx(0.103322, abs=1e-6)
    assert found["compliance_axial"] / UM == pytest.approx(0.852923, abs=1e-6)
    assert -found["compliance_axial"] * THRUST / UM == pytest.approx(-139.7892, abs=2e-4)
    assert found["axial_deflection_mean"] / UM == pytest.approx(-139.7892, rel=5e-4)
    assert found["share_base"] / UM == pytest.approx(-(0.852923 - 0.768923) * THRUST, rel=1e-3)
    total = found["share_arm"] + found["share_base"]
    assert total == pytest.approx(-found["compliance_axial"] * found["thrust_mean"], rel=1e-12)


def test_best_posture_is_sought_with_the_base(on_robot):
    """A base that rocks about x makes other postures skate least."""
    rocking = "robot.base_compliance=[0 um/N, 0 um/N, 0 um/N, 2 urad/N/m, 0 urad/N/m, 0 urad/N/m]"
    found = [
        quick_outcome(on_robot(base, "robot.redundancy_angle=least_skating", "robot.joint_angles=null")).measures
        for base in ("robot.base_compliance=null", rocking)
    ]
    fixed = f"robot.redundancy_angle={np.degrees(found[0]['redundancy_angle']):.6f} deg"
    kept = quick_outcome(on_robot(rocking, fixed)).measures
    assert found[1]["skating_ratio"] < kept["skating_ratio"]


def test_part_that_yields_adds_to_the_compliance(on_robot, on_machine):
    for load in (on_robot, on_machine):
        block = ["part.block=null"] if load is on_machine else []
        rigid, soft = (
            quick_outcome(load("contact.wall_stiffness=0 N/um", *block, *more)).measures
            for more in ([], ["part.stiffness=20 N/um"])
        )
        assert soft["compliance_axial"] - rigid["compliance_axial"] == pytest.approx(5e-8, rel=1e-9)
        assert soft["share_part_stiffness"] == pytest.approx(-5e-8 * soft["thrust_mean"], rel=1e-12)
        change = soft["axial_deflection_mean"] - rigid["axial_deflection_mean"]
        assert change == pytest.approx(-5e-8 * THRUST, rel=2e-2 if load is on_robot else 1e-6)


@pytest.fixture(scope="module")
def machine_cell(on_machine):
    scenario = on_machine()
    cell = drilling.drill_cell(scenario)
    posture, _, _ = drilling.choose(scenario, cell, drilling.targets(scenario.hole)[0])
    return cell, drilling.dynamics(cell, posture)


def test_two_ways_to_the_same_hole(machine_cell):
    """Time stepping with a backward rate, and advance of the tip with a search for the feed."""
    cell, carrier = machine_cell
    outcome, _ = drill_hole(cell.cycle, carrier, cell.profile, step=5e-5)
    entry, leaving = quasi_static_hole(cell.cycle, carrier, cell.profile, advance=2e-6)
    assert outcome.entry / UM == pytest.approx(entry / UM, abs=5e-4)  # either is of first order
    assert outcome.exit / UM == pytest.approx(leaving / UM, abs=5e-4)


def test_a_soft_arm_without_mass_surges_at_breakthrough(machine_cell):
    """As the two ways agree for an arm 30 times as soft, and its feed rises where the thrust falls."""
    cell, carrier = machine_cell
    soft = carrier._replace(soft=carrier.soft._replace(compliance=30.0 * carrier.soft.compliance))
    outcome, _ = drill_hole(cell.cycle, soft, cell.profile, step=5e-5)
    entry, leaving = quasi_static_hole(cell.cycle, soft, cell.profile, advance=2e-6)
    assert outcome.entry / UM == pytest.approx(entry / UM, abs=5e-3)
    assert outcome.exit / UM == pytest.approx(leaving / UM, abs=5e-3)
    assert outcome.feed_max > 1.15 * cell.cycle.feed
    assert outcome.feed_min < 0.86 * cell.cycle.feed


def test_order_one_in_the_time_step(machine_cell):
    cell, carrier = machine_cell
    soft = carrier._replace(soft=carrier.soft._replace(compliance=30.0 * carrier.soft.compliance))
    exits = [np.hypot(*drill_hole(cell.cycle, soft, cell.profile, step=dt)[0].exit) for dt in (4e-4, 2e-4, 1e-4, 5e-5)]
    assert abs(exits[0] - exits[-1]) < 1e-3 * exits[-1]
    assert abs(exits[2] - exits[3]) < abs(exits[0] - exits[1])


def test_the_same_at_once_in_two_terms(machine_cell):
    """Compliance of the part along the drill, told apart or in the sum."""
    cell, carrier = machine_cell
    whole = np.zeros((6, 6))
    whole[:3, :3] = carrier.soft.compliance
    whole[2, 2] += 1.0 / 3e7
    one, _ = drill_hole(cell.cycle, bodies_at_once(whole, with_torque=False), cell.profile)
    two, _ = drill_hole(cell.cycle, on_part(carrier, 3e7), cell.profile)
    assert two.exit == pytest.approx(one.exit, rel=1e-9)
    assert two.axial_mean == pytest.approx(one.axial_mean, rel=1e-12)


REFUSED = {
    "robot={library: kr270_r2700}": "the tool has one carrier",
    "part.stiffness=1 N/um": "both say how the part yields",
    "machine=null": "write robot.library",
    "machine.tip=null": "where the tool point is",
    "part.placement={x: [-10 mm, 10 mm]}": "tries places before a robot",
    "spindle={library: default}": "a spindle tilting on pistons cannot guide a drill",
    "tool.modes=[{direction: x, frequency: 1 kHz, damping: 0.03, stiffness: 5 N/um}]": "once the hole guides it",
    "machine.drives={library: fadal2216}": "drives hold still while a drill feeds along z",
    "requirements={redundancy_angle: {max: 1 deg}}": "it needs robot",
}


@pytest.mark.parametrize("change", REFUSED)
def test_what_is_refused_and_why(on_machine, change):
    with pytest.raises(cutwise.ScenarioFault, match=REFUSED[change]):
        on_machine(change)


@pytest.mark.parametrize(
    ("change", "why"),
    [("hole.position=[400 mm, 0 mm, 295 mm]", "leads axis X to 530 mm"), ("hole.axis=[1, 0, 0]", "points along")],
)
def test_what_the_machine_cannot_reach_is_told(on_machine, change, why):
    with pytest.raises(cutwise.ScenarioFault, match=why):
        quick_outcome(on_machine(change))
