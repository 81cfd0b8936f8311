"""An elastic robot mills: worked example 4b of the specification of the cell, at rest and at the limit of chatter."""

import math

import numpy as np
import pytest

import cutwise
from cutwise.io.scenario import load
from cutwise.loop import Cell
from cutwise.paths.carried import line
from cutwise.physics.cutting.flute import EdgeCoefficients, Mill
from cutwise.physics.cutting.flutes import MeanFlutes
from cutwise.physics.cutting.regeneration import depth_limit, mean_directions, swinging_receptance
from cutwise.physics.engagement.burred_edge import Round
from cutwise.physics.engagement.shoulder import Shoulder, Slot
from cutwise.physics.structure.series_compliance import translation_at
from cutwise.physics.structure.swings import natural_frequencies, swinging
from cutwise.physics.structure.terms import Compliance, displacement, relaxed
from cutwise.process import programmed_milling
from cutwise.process.carried import arm_along
from cutwise.process.edges import edges
from cutwise.still import rest

MM, UM = 1e-3, 1e-6
UNIT = np.ones(6)
SPEED = 8000 * 2 * math.pi / 60
CASES = {  # engagement, radial and axial depth [mm], up milling
    "slot": (Slot, 20.0, 2.0, False),
    "down": (Shoulder, 4.0, 5.0, False),
    "up": (Shoulder, 4.0, 5.0, True),
}
DISPLACED = {  # [um] at start, middle and end
    "slot": [[-108.37697, 104.43081, -151.96135], [-93.41200, 98.26251, -152.40134], [-79.84716, 91.81156, -150.54952]],
    "down": [[79.41607, 58.93303, -95.52483], [88.96098, 64.84539, -96.79123], [99.87622, 70.73516, -96.54046]],
    "up": [[-169.66937, -25.07722, -30.05635], [-167.45997, -13.80808, -28.78664], [-167.94194, -2.35541, -27.36346]],
}
FORCE = {  # [N] at the middle
    "slot": [-81.92282, 180.75286, -47.88972],
    "down": [78.14832, 131.75859, -22.82527],
    "up": [-147.10625, -3.92325, -22.95654],
}
LIMITS = {  # [mm], [Hz]
    (8000, "slot"): (19.67743, 45.488), (8000, "down"): (5.646769, 12.360), (8000, "up"): (77.87069, 40.614),
    (2000, "slot"): (1.926659, 15.025), (2000, "down"): (1.259552, 12.192), (2000, "up"): (12.398393, 35.323),
}  # fmt: skip


@pytest.fixture(scope="module")
def robot(examples):
    return cutwise.load(examples / "deburr_on_robot.yaml").robot


@pytest.fixture(scope="module")
def law(examples):
    scenario = cutwise.load(examples / "mill_pocket_corner.yaml")
    return Mill(10 * MM, 3, scenario.tool.helix), edges(scenario.material, scenario.tool)


def along(robot, *, up=False, wrench=UNIT, height=0.0, station=5 * MM):
    path = line([1.9, -0.15, 0.8], [1.9, 0.15, 0.8], [0, 0, -1], station, work_on_left=up)
    return arm_along(robot, path, wrench, height, 0.04)


def milled(robot, law, name, scale=1.0, arm=None):
    engagement, radial, depth, up = CASES[name]
    arm = along(robot, up=up) if arm is None else arm
    mill, edge = law
    cell = Cell(
        (), engagement(Round(mill.radius, 3, SPEED), depth * MM), (), MeanFlutes(mill, edge, SPEED, up),
        Compliance(arm.path.at, scale * arm.joints),
    )  # fmt: skip
    poses = np.zeros((len(arm.path.at), 8))
    poses[:, 1], poses[:, 3], poses[:, 5] = arm.path.at, -radial * MM, 0.04
    return cell, arm, rest(cell, relaxed(cell.structure), poses, seen=3, state=6)


@pytest.mark.parametrize("name", CASES)
def test_displacement_and_force_at_rest(robot, law, name):
    cell, _, at_rest = milled(robot, law, name)
    depth = CASES[name][2] * MM
    assert at_rest.found.all()
    moved = displacement(cell.structure, at_rest.state, 0.5 * depth)[[0, 30, 60]] / UM
    assert moved == pytest.approx(np.array(DISPLACED[name]), rel=1e-6, abs=1e-5)
    assert at_rest.total[30, :3] == pytest.approx(FORCE[name], rel=1e-6)


def test_the_whole_twist_of_a_slot_and_its_closed_form(robot, law):
    cell, _, at_rest = milled(robot, law, "slot")
    assert at_rest.state[30, 3:] / UM == pytest.approx([185.879, 51.631, -41.297], abs=1e-3)
    _, _, rigid = milled(robot, law, "slot", scale=0.0)
    free = milled(robot, law, "slot", scale=1e-6)[2].state * 1e6  # C F of the rigid cut
    closed = free[:, 2] / (1.0 + free[:, 2] / (2 * MM))
    assert at_rest.state[:, 2] == pytest.approx(closed, rel=1e-5)
    assert np.all(rigid.state == 0.0)
    assert cell.structure.at.size == 61


@pytest.mark.parametrize(
    ("name", "angle", "worst"), [("slot", 125, 49.847), ("down", -125, 40.217), ("up", -30, 8.203)]
)
def test_best_angle_for_the_wall(robot, law, name, angle, worst):
    """On a grid of 5 degrees, all branches, chosen under the force of the rigid cut; largest yielding at seven stations."""
    _, _, depth, up = CASES[name]
    _, _, rigid = milled(robot, law, name, scale=0.0)
    force, z = rigid.total[0, :3], 0.5 * depth * MM
    free = robot.model_copy(update={"joint_angles": None, "redundancy_angle": "best_constant"})
    wrench = np.array([*force, -z * force[1], z * force[0], 0.0])
    arm = along(free, up=up, wrench=wrench, height=z, station=50 * MM)
    assert math.degrees(arm.postures.angle[0]) == pytest.approx(angle)
    _, _, at_rest = milled(robot, law, name, arm=arm)
    off = displacement(Compliance(arm.path.at, arm.joints), at_rest.state, z)[:, 1]
    assert np.abs(off).max() / UM == pytest.approx(worst, abs=1e-3)


def test_energy_at_rest(robot, law):
    """Twice the elastic energy of all joints is the work of force and moment on the twist."""
    _, arm, at_rest = milled(robot, law, "down")
    k = 30
    force, height = at_rest.total[k, :3], 2.5 * MM
    wrench = np.array([*force, -height * force[1], height * force[0], 0.0])
    turned = np.concatenate([arm.path.axes[k] @ wrench[:3], arm.path.axes[k] @ wrench[3:]])
    from cutwise.process.carried import jacobians_of

    torque = jacobians_of(arm.arm, arm.postures.q[[k]])[0].T @ turned
    assert float(torque @ (torque / arm.arm.stiffness)) == pytest.approx(float(wrench @ at_rest.state[k]), rel=1e-12)


def test_newton_where_the_fixed_point_diverges():
    """Rigid spindle, no burr, preset 0.1 mm on 20 um/N: slope -1.41; -42.98989 um at (3.842811, 2.850505, -1.642093) N."""
    from cutwise.maths.curves import constant
    from cutwise.process.loops import cell_of
    from peers.cells import r0

    matrix = np.zeros((1, 6, 6))
    matrix[0, 1, 1] = 20 * UM
    base = r0(burr=0.0, preset=0.1 * MM)
    cell = cell_of(base._replace(layers=base.layers._replace(burr_height=constant(0.0))))
    cell = cell._replace(structure=Compliance(np.zeros(1), matrix))
    pose = np.array([[0.0, 0.0, 0.0, -0.1 * MM, 0.0, 0.08, 0.0, 0.0]])
    found = rest(cell, relaxed(cell.structure), pose, seen=6, state=6, layers=2, contacts=3)
    assert found.found.all()
    assert (found.state[0, 1] - 0.1 * MM) / UM == pytest.approx(-42.98989, abs=1e-5)
    assert found.total[0, :3] == pytest.approx([3.842811, 2.850505, -1.642093], abs=1e-6)


@pytest.mark.parametrize(("speed", "name"), LIMITS)
def test_depth_at_which_the_arm_chatters(robot, law, speed, name):
    _, _, _, up = CASES[name]
    _, edge = law
    arm = along(robot, up=up)
    swing = swinging(arm.path.at, translation_at(arm.joints, 2.5 * MM), 150.0, 0.05)
    angle = math.acos(1.0 - 0.4)
    lo, hi = {"slot": (0.0, math.pi), "down": (math.pi - angle, math.pi), "up": (0.0, angle)}[name]
    directions = mean_directions(lo, hi, 3, edge.linear, up=up)
    period = 60.0 / (speed * 3)
    found = depth_limit(swinging_receptance(swing.stiffness[30], swing.damping[30], 150.0), directions, period, 800.0)
    depth, frequency = LIMITS[speed, name]
    assert found.depth / MM == pytest.approx(depth, rel=1e-6)
    assert found.frequency == pytest.approx(frequency, abs=1e-3)
    assert natural_frequencies(swing)[30] == pytest.approx([10.84068, 12.17964, 36.65200], abs=1e-5)
    heavier = depth_limit(
        swinging_receptance(swing.stiffness[30], 2.0 * swing.damping[30], 600.0), directions, 2.0 * period, 400.0
    )
    assert heavier.depth == pytest.approx(found.depth, rel=1e-6), "mass times four, time times two: the same depth"


def test_directions_are_the_slope_of_the_mean_force(law):
    """B is what the tool-averaged force of an arc gains for a displacement against the surface of a tooth before."""
    k = EdgeCoefficients(6e8, 1.6e8, 1.2e8, 0.0, 0.0, 0.0)
    lo, hi = 1.1, math.pi
    phi = np.linspace(lo, hi, 20_001)
    weight = np.full(phi.size, phi[1] - phi[0])
    weight[[0, -1]] *= 0.5
    sine, cosine = np.sin(phi), np.cos(phi)
    rows = np.array([-k.K_tc * cosine - k.K_rc * sine, k.K_tc * sine - k.K_rc * cosine, np.full(phi.size, -k.K_ac)])
    expected = 3 / (2 * math.pi) * np.einsum("im,jm,m->ij", rows, np.array([sine, cosine]), weight)
    assert mean_directions(lo, hi, 3, k) == pytest.approx(expected, rel=1e-7)
    assert law[0].flutes == 3


def test_power_is_that_of_the_chips_and_of_what_the_edges_rub(examples):
    short = ["path.line.from=[1900 mm, -5 mm, 800 mm]", "path.line.to=[1900 mm, 5 mm, 800 mm]", "requirements={}"]
    scenario = load(examples / "mill_on_robot.yaml", short)
    done, k = programmed_milling.run(scenario, limits=False), scenario.material
    speed = 0.5 * scenario.tool.diameter * scenario.operation.spindle_speed
    radial, axial, arc = done.seen.T
    chips = k.K_tc * axial * radial * scenario.operation.feed
    rubbed = k.K_te * axial * arc * scenario.tool.flutes / (2.0 * np.pi) * speed
    assert done.tangential * speed == pytest.approx(chips + rubbed, rel=1e-12)
