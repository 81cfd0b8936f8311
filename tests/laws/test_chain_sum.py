"""One sum for everything that yields in a chain: joints of an arm, its base, bodies of a machine, the part."""

import numpy as np
import pytest

import cutwise
from cutwise.maths.chains import frames, tool_point
from cutwise.paths.carried import CarriedPath
from cutwise.physics.structure import bodies
from cutwise.physics.structure.joint_compliance import cartesian_compliance
from cutwise.physics.structure.series_compliance import (
    carried_to,
    chain_compliance,
    in_axes,
    joint_element,
    turning_elements,
)
from cutwise.process import machine_assemble, machine_pass
from cutwise.process.chain_compliance import bodies_along
from cutwise.process.posture import arm_compliance, posture_at, posture_frames, posture_jacobian
from cutwise.process.postures import candidates, tool_axes
from cutwise.process.robot_arms import robot_arm

Q = np.radians([10.0, -60.0, 80.0, 20.0, -50.0, 30.0])
WRENCH = np.array([40.0, -70.0, 25.0, 3.0, -1.0, 2.0])


@pytest.fixture(scope="module")
def arm(examples):
    return robot_arm(cutwise.load(examples / "drill_robot.yaml").robot)[0]


@pytest.fixture(scope="module")
def budget(examples):
    return cutwise.load(examples / "machine_error_budget.yaml")


@pytest.fixture(scope="module")
def machine(budget):
    cell = machine_assemble.machine_cell(budget)
    return cell._replace(weights=())


def test_joints_of_an_arm_are_hinges_at_their_axes(arm):
    at = posture_frames(arm, Q)
    tip = at.origins[-1] + at.rotations[-1] @ arm.tool_tip
    axes = np.einsum("kij,kj->ki", at.rotations[1:], arm.chain.axes)
    hinges = np.array([joint_element(a, k) for a, k in zip(axes, arm.stiffness, strict=True)])
    jacobian = posture_jacobian(arm, Q)
    product = jacobian @ np.diag(1.0 / arm.stiffness) @ jacobian.T
    one = chain_compliance(hinges, tip - at.origins[1:])
    assert one == pytest.approx(product, rel=1e-12, abs=1e-22)
    assert cartesian_compliance(jacobian, arm.stiffness) == pytest.approx(product, rel=1e-12, abs=1e-22)
    twists = turning_elements(jacobian, arm.stiffness) @ WRENCH
    assert product @ WRENCH == pytest.approx(twists.sum(axis=0), rel=1e-12)


def test_base_adds_the_twist_of_its_own_element(arm):
    base = np.diag([1e-8, 2e-8, 3e-8, 2e-8, 1e-8, 4e-8])
    at = posture_frames(arm, Q)
    tip = at.origins[-1] + at.rotations[-1] @ arm.tool_tip
    added = arm_compliance(arm._replace(base=base), Q) - arm_compliance(arm, Q)
    moment = WRENCH[3:] + np.cross(tip, WRENCH[:3])
    at_base = base @ np.concatenate([WRENCH[:3], moment])
    twist = np.concatenate([at_base[:3] + np.cross(at_base[3:], tip), at_base[3:]])
    assert added @ WRENCH == pytest.approx(twist, rel=1e-9)


def test_choice_of_a_posture_knows_the_base(arm):
    """Axial compliance and holding force of all solutions are those of the whole compliance."""
    soft = arm._replace(base=np.diag([1e-7, 1e-7, 3e-7, 2e-8, 2e-8, 2e-8]))
    pose = tool_axes(np.array([0.2, 0.1, -1.0]), np.array([0.4]))
    found = candidates(soft, np.array([[1.9, 0.3, 0.8]]), pose)
    branch = int(np.flatnonzero(found.within[0])[0])
    posture = posture_at(soft, 0.4, found.q[0, branch])
    assert found.compliance[0, branch] == pytest.approx(posture.compliance[2, 2], rel=1e-9)
    assert found.holding[0, branch] == pytest.approx(posture.holding, rel=1e-9)


def test_base_of_the_specification(examples):
    """Case 4e: 1e8 N/m and 5e7 N m/rad under the least skating posture."""
    base = "[0.01 um/N, 0.01 um/N, 0.01 um/N, 0.02 urad/N/m, 0.02 urad/N/m, 0.02 urad/N/m]"
    scenario = cutwise.load(examples / "drill_robot.yaml", [f"robot.base_compliance={base}"])
    arm, _ = robot_arm(scenario.robot)
    q = np.radians([-18.138764, 39.154638, -114.590131, 45.074347, 79.602941, -10.256001])
    posture = posture_at(arm, np.radians(26.0), q)
    c = posture.compliance * 1e6
    found = [c[0, 0], c[0, 1], c[1, 1], c[0, 2], c[1, 2], c[2, 2]]
    assert found == pytest.approx([0.600862, 0.408055, 1.429727, -0.051683, -0.152609, 0.852923], abs=1e-6)
    assert posture.skating == pytest.approx(0.103322, abs=1e-6)
    assert -c[2, 2] * 163.8943667 == pytest.approx(-139.7892, abs=2e-4)


def test_bodies_of_a_machine_are_the_same_sum(machine):
    """The error of the tool against the part under a cutting force is C F, element by element too."""
    at = frames(machine.axes.chain, machine.way.commands[[0, 13]] * machine.axes.sense)
    tool = tool_point(at, machine.tip)
    elements = machine_pass.placed_elements(machine.elements, machine.ground, at)
    each = carried_to(elements.compliance, tool[:, None] - elements.point)
    whole = chain_compliance(elements.compliance, tool[:, None] - elements.point)
    force = machine.cut.force[[0, 13]]
    loads = bodies.Loads(
        np.array([len(machine.names) - 1, 0]), np.stack([force, -force], axis=1), np.stack([tool, tool], axis=1)
    )
    twists = bodies.element_twists(elements, bodies.element_wrenches(elements, loads))
    ours = bodies.contributions(elements, twists, tool)
    assert np.einsum("meij,mj->mei", each[..., :3, :3], force) == pytest.approx(ours, rel=1e-12, abs=1e-20)
    assert np.einsum("mij,mj->mi", whole[..., :3, :3], force) == pytest.approx(ours.sum(axis=1), rel=1e-12)


def whole_of(machine, scenario, rows):
    """Compliance of the tool against the part at some places of the pass, in frame 0."""
    at = frames(machine.axes.chain, machine.way.commands[rows] * machine.axes.sense)
    tool = tool_point(at, machine.tip)
    path = CarriedPath(np.arange(len(tool)), tool, np.tile(np.eye(3), (len(tool), 1, 1)))
    return bodies_along(scenario.machine, scenario.part, machine.tip, path).total


def test_whole_machine_is_reciprocal_and_stores_energy(machine, budget):
    run = machine_pass.run_pass(machine)
    whole = whole_of(machine, budget, slice(None))
    moved = np.einsum("mij,mj->mi", whole[:, :3, :3], machine.cut.force)
    assert moved == pytest.approx(run.deviation, rel=1e-12, abs=1e-18)
    assert whole == pytest.approx(np.swapaxes(whole, -1, -2), rel=1e-12, abs=1e-22)
    assert np.linalg.eigvalsh(whole).min() > 0.0
    stored = np.einsum("mi,mij,mj->m", machine.cut.force, whole[:, :3, :3], machine.cut.force)
    assert stored == pytest.approx(run.internal, rel=1e-12)


def test_machine_of_the_specification(machine, budget):
    """Case 4e at X = 0: the whole compliance along z, and the skating ratio of a drill that goes down."""
    whole = whole_of(machine, budget, [13])[0]
    drilling = in_axes(whole, np.diag([1.0, -1.0, -1.0])) * 1e6
    assert drilling[2, 2] == pytest.approx(0.0260073, abs=1e-7)
    assert drilling[2, 2] * 163.8943667 == pytest.approx(4.262453, abs=1e-6)
    assert abs(drilling[1, 2]) * 163.8943667 == pytest.approx(0.958608, abs=1e-6)
    assert np.hypot(*np.linalg.solve(drilling[:2, :2], drilling[:2, 2])) == pytest.approx(0.085163, abs=1e-6)
