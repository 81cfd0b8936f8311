"""A robot along a path: the worked example 4a of the specification of the cell, and the laws of terms in series."""

import math

import numpy as np
import pytest

import cutwise
from cutwise.maths.chains import frames
from cutwise.maths.frames import rotation_from_rpy
from cutwise.paths.carried import line, placed
from cutwise.physics.structure.joint_compliance import cartesian_compliance
from cutwise.physics.structure.series_compliance import carried_to, in_axes, joint_element, translation_at
from cutwise.physics.structure.swings import natural_frequencies, swinging
from cutwise.physics.structure.terms import Compliance, displacement
from cutwise.process import assemble
from cutwise.process.carried import arm_along, jacobians_of
from cutwise.process.loops import run_compliant_edge
from cutwise.process.posture import posture_jacobian
from peers.cells import MM, r0

UM = 1e-6
PLACES = np.array([0.050, 0.150, 0.250, 0.299])  # [m] of the path
HEIGHT = 0.5 * MM


@pytest.fixture(scope="module")
def scenario(examples):
    return cutwise.load(examples / "deburr_on_robot.yaml")


def along(scenario, **changes):
    robot = scenario.robot.model_copy(update=changes)
    changed = scenario.model_copy(update={"robot": robot})
    cell = assemble.deburring_cell(changed)
    return cell, cell.carriage.arm


def read(cell, time_step=20e-6):
    """Edge error and share of the arm at the places, and travel of the spindle there [um]."""
    history = run_compliant_edge(cell, time_step)
    rows = np.searchsorted(history.motion.position, PLACES - 1e-9)
    arm = displacement(cell.behind[0][1], history.response.behind, HEIGHT)[rows, 1]
    pistons = (cell.reach - HEIGHT) * history.response.tilt[rows, 1]
    return (-2 * MM + pistons + arm) / UM, arm / UM, pistons / UM


def test_posture_and_compliance_at_start_and_middle(scenario):
    _, arm = along(scenario)
    assert np.degrees(arm.postures.q[0]) == pytest.approx(
        [5.865971, -82.358235, 116.935998, 10.261206, -35.010657, -8.433966], abs=1e-6
    )
    middle, start = arm.joints[30] / UM, arm.joints[0] / UM
    assert np.diag(middle)[:3] == pytest.approx([1.141508, 0.403258, 1.162845], abs=1e-6)
    assert [middle[1, 2], middle[0, 1], middle[0, 2]] == pytest.approx([-0.536318, 0.0, 0.0], abs=1e-6)
    assert [middle[3, 1], middle[3, 2], middle[4, 0], middle[5, 0]] == pytest.approx(
        [0.696043, -1.261535, -0.633581, 0.503258], abs=1e-6
    )
    assert start[np.triu_indices(3)] == pytest.approx(
        [1.150611, -0.076751, 0.008009, 0.404123, -0.531073, 1.160347], abs=1e-6
    )


STATIC = ([-9.5285, -9.2002, -8.8863, -8.7385], [5.9096, 6.2380, 6.5518, 6.6996], 1984.562)
TURNED = ([-9.6187, -9.3509, -9.0637, -8.9160], [8.0803, 8.3481, 8.6353, 8.7831], 1982.301)
MODAL = ([-12.6751, -12.1699, -11.8415, -11.6880], [5.8739, 6.3791, 6.7075, 6.8611], 1981.451)
BOTH = ([-7.9968, -7.5455, -7.2651, -7.1207], [7.7915, 8.2428, 8.5232, 8.6676], 1984.212)


@pytest.mark.parametrize(
    ("changes", "expected", "tolerance"),
    [
        ({}, STATIC, 1e-3),
        ({"redundancy_angle": -0.5 * math.pi}, TURNED, 1e-3),
        ({"dynamics": "modal"}, MODAL, 5e-3),
        ({"redundancy_angle": -0.5 * math.pi, "dynamics": "modal"}, BOTH, 5e-3),
    ],
    ids=["static", "turned", "modal", "turned, modal"],
)
def test_edge_left_and_share_of_the_arm(scenario, changes, expected, tolerance):
    cell, _ = along(scenario, **changes)
    error, arm, pistons = read(cell)
    assert error == pytest.approx(expected[0], abs=tolerance)
    assert arm == pytest.approx(expected[1], abs=tolerance)
    assert pistons == pytest.approx(np.full(4, expected[2]), abs=max(tolerance, 2e-3))


def test_order_one_in_the_time_step(scenario):
    cell, _ = along(scenario)
    short = cell._replace(path=cell.path._replace(duration=0.7))
    errors = []
    for step in (4e-5, 2e-5, 1e-5):
        history = run_compliant_edge(short, step)
        row = int(np.searchsorted(history.motion.position, PLACES[0] - 1e-9))
        arm = displacement(cell.behind[0][1], history.response.behind, HEIGHT)[row, 1]
        errors.append((-2 * MM + (cell.reach - HEIGHT) * history.response.tilt[row, 1] + arm) / UM)
    assert errors == pytest.approx([-9.5446, -9.5285, -9.5205], abs=1e-3)
    assert (errors[0] - errors[1]) / (errors[1] - errors[2]) == pytest.approx(2.0, abs=0.1)


def test_one_mode_near_ten_hertz_and_margins(scenario):
    cell, arm = along(scenario, dynamics="modal")
    lowest = natural_frequencies(cell.behind[0][1])[:, 0]
    assert [lowest.min(), lowest.max()] == pytest.approx([10.8301, 10.8308], abs=1e-4)
    found = cutwise.simulate(
        scenario.model_copy(update={"numerics": scenario.numerics.model_copy(update={"time_step": 1e-4})})
    )
    assert found.measures["wrist_margin"].value == pytest.approx(0.5683, abs=1e-4)
    assert math.degrees(found.measures["joint_limit_margin"].value) == pytest.approx(32.66, abs=0.01)
    assert found.measures["joint_speed_margin"].value == pytest.approx(0.9547, abs=1e-4)
    assert arm.postures.q.shape == (61, 6)


def test_static_spring_in_series_keeps_the_band():
    """R0 on a spring of 2e5 N/m normal to the edge: -10.641 um, the arm 50.24 um; with mass +10.764."""
    matrix = np.zeros((1, 6, 6))
    matrix[0, 1, 1] = 1.0 / 2e5
    for term, error, tolerance in (
        (Compliance(np.zeros(1), matrix), -10.641, 1e-3),
        (swinging(np.zeros(1), np.diag([1e-12, 5e-6, 1e-12])[None], 150.0, 0.05), 10.764, 1e-2),
    ):
        cell = r0()._replace(behind=(("spring", term),))
        history = run_compliant_edge(cell, 20e-6)
        moved = displacement(term, history.response.behind, HEIGHT)[-1, 1]
        found = -2 * MM + (0.150 - HEIGHT) * history.response.tilt[-1, 1] + moved
        assert found / UM == pytest.approx(error, abs=tolerance)
        if tolerance == 1e-3:
            assert moved / UM == pytest.approx(50.24, abs=0.01)


def test_two_springs_are_one():
    generator = np.random.default_rng(2)
    parts = []
    for _ in range(2):
        root = generator.normal(size=(6, 6)) * np.array([1e-4, 1e-4, 1e-4, 1e-3, 1e-3, 1e-3])[:, None]
        parts.append((root @ root.T)[None])
    two = r0(duration=0.3)._replace(behind=tuple(("k", Compliance(np.zeros(1), part)) for part in parts))
    one = r0(duration=0.3)._replace(behind=(("k", Compliance(np.zeros(1), parts[0] + parts[1])),))
    first, second = run_compliant_edge(two, 50e-6), run_compliant_edge(one, 50e-6)
    assert first.burr_force.mean == pytest.approx(second.burr_force.mean, rel=1e-9, abs=1e-9)
    assert first.response.behind[:, :6] + first.response.behind[:, 6:] == pytest.approx(
        second.response.behind, rel=1e-9, abs=1e-15
    )


def test_joints_are_a_sum_of_element_twists(scenario):
    _, arm = along(scenario)
    for q in arm.postures.q[::20]:
        at = frames(arm.arm.chain, q)
        tip = at.origins[-1] + at.rotations[-1] @ arm.arm.tool_tip
        total = sum(
            carried_to(joint_element(at.rotations[k + 1] @ arm.arm.chain.axes[k], stiffness), tip - at.origins[k + 1])
            for k, stiffness in enumerate(arm.arm.stiffness)
        )
        jacobian = posture_jacobian(arm.arm, q)
        assert total == pytest.approx(cartesian_compliance(jacobian, arm.arm.stiffness), rel=1e-12, abs=1e-20)
        assert jacobians_of(arm.arm, q[None])[0] == pytest.approx(jacobian, abs=1e-12)


def test_reciprocity_and_a_mirrored_frame(scenario):
    _, arm = along(scenario, base_compliance=(1e-8, 2e-8, 1e-8, 2e-8, 1e-8, 3e-8))
    for matrix in (*arm.joints[::20], *arm.base[::20]):
        assert matrix == pytest.approx(matrix.T, abs=1e-12 * np.abs(matrix).max())
        assert np.linalg.eigvalsh(matrix).min() > -1e-15
    # up milling: the same tool and feed, work on the other side; forces mirrored give displacements mirrored
    left = in_axes(arm.joints[30], np.diag([1.0, -1.0, 1.0]))
    assert left[0, 0] == arm.joints[30][0, 0]
    assert left[0, 1] == -arm.joints[30][0, 1]
    assert translation_at(left, 3 * MM)[1, 1] == pytest.approx(translation_at(arm.joints[30], 3 * MM)[1, 1], rel=1e-12)


def test_the_whole_cell_turned_about_the_base_changes_nothing(scenario):
    """Path, part and first axis turned together: compliance in process axes stays; only room of the joints changes."""
    _, arm = along(scenario)
    angle = 0.4
    turn = rotation_from_rpy(0.0, 0.0, angle)
    nominal = line([1.9, -0.15, 0.8], [1.9, 0.15, 0.8], [0, 0, -1], 5 * MM)
    wrench = np.array([5.0, 9.0, -3.0, 0.0, 0.0, 0.0])
    start = arm.postures.q[0] - np.array([angle, 0, 0, 0, 0, 0])  # axis 1 of this arm points down, as the tool does
    robot = scenario.robot.model_copy(update={"joint_angles": tuple(start), "redundancy_angle": -angle})
    there = arm_along(robot, placed(nominal, turn, np.zeros(3)), wrench, HEIGHT, 0.08)
    assert there.joints == pytest.approx(arm.joints, rel=1e-9, abs=1e-18)


def test_angle_along_the_path_against_one_angle(scenario):
    """Line of 1 m: 31.612373 um turned on the way, 50.178880 um with the best single angle (35 degrees)."""
    path = line([1.9, -0.5, 0.8], [1.9, 0.5, 0.8], [0, 0, -1], 5 * MM)
    force, z = np.array([77.08466355, 131.10132657, -22.74906641]), 2.5 * MM
    wrench = np.array([*force, -z * force[1], z * force[0], 0.0])
    robot = scenario.robot.model_copy(update={"joint_angles": None, "redundancy_angle": "along_path"})
    found = arm_along(robot, path, wrench, z, 0.04)
    assert [found.turned / UM, found.constant / UM] == pytest.approx([31.612373, 50.178880], abs=1e-6)
    assert np.degrees(found.postures.angle[[0, -1]]) == pytest.approx([-110, -140])
    best = arm_along(robot.model_copy(update={"redundancy_angle": "best_constant"}), path, wrench, z, 0.04)
    assert math.degrees(best.postures.angle[0]) == pytest.approx(35.0)


def test_sag_under_the_tool_and_the_links(scenario):
    """30 kg on the flange: 137.307 um off the work at mid-path, 136.021 at the ends; relative to the start, 1.286."""
    tool = {"tool_mass": 30.0, "tool_centre": (0.1, 0.0, -0.15)}
    _, arm = along(scenario, sag="absolute", **tool)
    assert arm.sag[[0, 30, 60], 1] / UM == pytest.approx([136.021, 137.307, 136.021], abs=1e-3)
    assert arm.sag[[0, 30], 2] / UM == pytest.approx([-304.597, -304.994], abs=1e-3)
    cell, relative = along(scenario, sag="relative", **tool)
    assert relative.sag[30, 1] / UM == pytest.approx(137.307 - 136.021, abs=2e-3)
    height = run_compliant_edge(cell, 1e-4).motion.height
    row = round(0.150 / 0.080 / 1e-4)
    assert (height[row] + 2 * MM) / UM == pytest.approx(1.286, abs=2e-3), "the undeflected mill stands that much higher"
