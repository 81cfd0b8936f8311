"""A chamfer carried by a robot: laws that hold for any arm, any part and any spindle."""

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import cutwise
from cutwise.physics.structure.terms import Compliance, Pistons
from cutwise.process import chamfer
from cutwise.process.chamfer_cell import SLICES, Pass, ball_cut, process_axes, yielding_at_rest, yielding_pass
from cutwise.process.chamfer_cut import ball_end, deflected, material_along, mounted, ring_on
from cutwise.spec.faults import ScenarioFault

EXAMPLE = Path(__file__).parents[2] / "examples" / "chamfer_on_robot.yaml"
COARSE = ("path.points=120", "requirements={}")
WIDE = ("chamfer.width=0.9 mm", "part.edges=outer", "operation.preset=0.1 mm", "operation.part_error=0.1 mm")
SOFT = "spindle={library: berselli2016, pressure: 2 bar}"


def planned(*changes):
    scenario = cutwise.load(EXAMPLE, (*COARSE, *changes))
    return scenario, chamfer.run(scenario, wanted=frozenset())


@pytest.fixture(scope="module")
def rigid_spindle():
    return planned()


@pytest.fixture(scope="module")
def soft_spindle():
    return planned(SOFT, *WIDE)


def passed(case, terms, how=yielding_pass, *, step=20e-6, approach=0.0):
    scenario, done = case
    path = done.paths[0]
    n = len(path.path.centre)
    run = Pass(path.feeds.centre, np.full(n, approach), step, np.zeros((n, 3)))
    section = material_along(scenario, path)
    return how(section, path.path, path.local, path.axis, ball_end(scenario), terms, run)


def spring(matrix):
    """A spring that is the same all along, in process axes."""
    return Compliance(np.zeros(1), np.asarray(matrix, float)[None])


def some_compliance(seed=3, size=1e-6):
    """Symmetric, positive, with rotations: any arm."""
    root = np.random.default_rng(seed).standard_normal((6, 6)) * math.sqrt(size)
    scale = np.diag([1.0, 1.0, 1.0, 3.0, 3.0, 3.0])
    return scale @ root @ root.T @ scale / 6.0


def test_a_term_without_compliance_changes_no_bit(soft_spindle):
    scenario, done = soft_spindle
    pistons = ("pistons", Pistons(ring_on(scenario, mounted(done.paths[0], done.paths)), scenario.spindle.tool_reach))
    alone = passed(soft_spindle, (pistons,), approach=0.2e-3)
    behind = passed(soft_spindle, (pistons, ("arm", spring(np.zeros((6, 6))))), approach=0.2e-3)
    np.testing.assert_array_equal(behind.tilt, alone.tilt)
    np.testing.assert_array_equal(behind.force, alone.force)
    assert np.abs(alone.tip).max() > 0.5e-3


def test_at_rest_the_displacement_is_that_of_the_force_at_the_displaced_ball(rigid_spindle):
    """By a plain fixed point on the planes of a rigid tool; what the arm drags along the edge changes the place by 1e-7."""
    scenario, done = rigid_spindle
    path, ball = done.paths[0], ball_end(scenario)
    matrix = some_compliance()
    found = passed(rigid_spindle, (("arm", spring(matrix)),), yielding_at_rest)
    section = material_along(scenario, path)
    radius = ball.ball_radius
    across = np.concatenate([np.eye(3), [[0, radius, 0], [-radius, 0, 0], [0, 0, 0]]], axis=1)
    at_ball = across @ matrix @ across.T
    for i in range(0, 120, 17):
        seen = np.array([path.local.feed[i], path.local.off[i], path.axis])
        led = seen @ process_axes(path.axis)
        u = np.zeros(3)
        for _ in range(30):
            planes = section.wedge[i].copy()
            planes[:, 3] -= planes[:, 1] * u[1] + planes[:, 2] * u[2]
            cut = ball_cut(planes, ball, section.speed[i], 0.0, section.rise[i], SLICES)
            u = led @ at_ball @ led.T @ np.array([cut.force.x, cut.force.y, cut.felt])
        moved = seen @ found.terms[0][1][i]
        assert moved == pytest.approx(u, rel=5e-3, abs=2e-9)


def test_two_springs_are_one_with_the_sum_of_their_compliances(rigid_spindle):
    first, second = some_compliance(1), some_compliance(2)
    two = passed(rigid_spindle, (("arm", spring(first)), ("base", spring(second))), yielding_at_rest)
    one = passed(rigid_spindle, (("arm", spring(first + second)),), yielding_at_rest)
    np.testing.assert_allclose(two.offset, one.offset, rtol=1e-9, atol=1e-13)
    assert sum(np.abs(part).max() for _, part in two.terms) > 1e-7


@pytest.mark.parametrize("edge", ["inner", "outer"])
def test_the_width_changes_with_the_displacement_off_the_chamfer(edge):
    r"""chamfer.md 1.3: the slope of the width over the stand-off d in a planar wedge, times u along the chamfer normal."""
    scenario, done = planned(f"part.edges={edge}", "tool.axis=+z", "path.points=360")
    path, one = done.paths[0], done.deflected[0]
    frames, width, radius = path.path.frames, scenario.chamfer.width, scenario.tool.ball_radius
    off = np.einsum("ij,ij->i", one.moves.offset, path.path.air)
    half = 0.5 * frames.wedge
    d = math.sqrt(radius**2 - 0.25 * width**2) - 0.5 * width / np.tan(half)
    leg = 0.5 * width / np.sin(half)
    slope = -2.0 * np.sin(half) * (d + leg * np.cos(half)) / (leg + d * np.cos(half))
    expected = np.interp(path.at.parameter, frames.parameter, slope * off, period=2.0 * math.pi)
    change = one.width - path.found.width
    assert np.abs(expected).max() > 1e-6
    np.testing.assert_allclose(change, expected, atol=0.03 * np.abs(expected).max())


def test_energy_and_shares_at_rest(rigid_spindle):
    scenario, done = planned("robot.base_compliance=[0.05 um/N, 0.05 um/N, 0.05 um/N]")
    one, path = done.deflected[0], done.paths[0]
    off = [np.einsum("ij,ij->i", part, path.path.air) for _, part in one.moves.terms]
    worst = int(np.argmax(np.abs(sum(off))))
    found = cutwise.simulate(scenario).measures
    assert found["share_arm"].value + found["share_base"].value == pytest.approx(sum(off)[worst], rel=1e-12)
    arm_alone = rigid_spindle[1].deflected[0].moves
    assert np.abs(one.moves.offset).max() > np.abs(arm_alone.offset).max()


def test_a_cell_turned_about_the_base_measures_the_same():
    """Part and angle of the tool turned by 30 degrees about z: only joint 1 sees it."""
    start = "robot.joint_angles=[{} deg, -82 deg, 117 deg, 0 deg, -35 deg, 0 deg]"
    turned = ("placement.rotation=[0 deg, 0 deg, 30 deg]", "robot.redundancy_angle=-30 deg", start.format(30),
              f"placement.origin=[{1900 * math.cos(math.pi / 6)} mm, {1900 * math.sin(math.pi / 6)} mm, 800 mm]")  # fmt: skip
    before, after = (cutwise.simulate(cutwise.load(EXAMPLE, (*COARSE, *changes))).measures for changes in ((), turned))
    for name, measure in before.items():
        if name not in ("joint_limit_margin", "redundancy_angle_min", "redundancy_angle_max"):
            assert after[name].value == pytest.approx(measure.value, rel=1e-6, abs=1e-12), name


def test_sag_is_taught_in_the_axes_of_the_base():
    """Relative to the first place in directions that do not turn with the pass."""
    weight = ("robot.tool_mass=30 kg", "robot.tool_centre=[100 mm, 0 mm, -150 mm]")
    taught, whole = (planned(*weight, f"robot.sag={sag}")[1].carriers[0].sag for sag in ("relative", "absolute"))
    np.testing.assert_allclose(taught, whole - whole[0], atol=1e-15)
    assert 1e-4 < np.abs(whole).max() < 1e-3


def test_order_of_a_swinging_arm_in_the_step():
    scenario, done = planned("robot.dynamics=modal", *WIDE)
    path, ball = done.paths[0], ball_end(scenario)
    offsets = [
        deflected(scenario, path, ball, mounted(path, done.paths), done.carriers[0], time_step=step).moves.offset
        for step in (80e-6, 40e-6, 20e-6)
    ]
    first, second = (np.abs(a - b).max() for a, b in pairwise(offsets))
    assert 1.6 < first / second < 2.5
    assert done.deflected[0].moves.unsolved == 0


def test_pistons_hide_a_constant_force_and_pass_on_a_change(soft_spindle):
    scenario, done = soft_spindle
    found = cutwise.simulate(scenario).measures
    assert found["deflection_pistons_max_y"].value > 0.5e-3
    assert 1e-6 < abs(found["deflection_arm_max_y"].value) < 50e-6
    assert found["width_deflected_max"].value < found["width_max"].value
    assert done.deflected[0].moves.unsolved == 0


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        (("material=null",), "robot", "needs forces to yield to"),
        (("robot=null",), "placement", "has nothing to place"),
        ((SOFT, "robot.redundancy_angle=along_path"), "robot.redundancy_angle", "would turn the pistons"),
    ],
)
def test_what_cannot_be_is_refused(changes, key, words):
    with pytest.raises(ScenarioFault) as caught:
        cutwise.load(EXAMPLE, (*COARSE, *changes))
    assert any(".".join(map(str, fault.path)) == key and words in fault.message for fault in caught.value.faults)


def test_out_of_reach_is_infeasible():
    result = cutwise.simulate(cutwise.load(EXAMPLE, (*COARSE, "placement.origin=[4000 mm, 0 mm, 800 mm]")))
    assert result.verdict == "fail"
    assert "cannot follow the path" in result.infeasible[0]


def test_every_sample_of_a_coarse_path_has_its_balance(rigid_spindle):
    """The force does not jump where the ball passes from one sample to the next: at such a place nothing would balance."""
    found = passed(rigid_spindle, (("arm", spring(2.0 * some_compliance())),), yielding_at_rest)
    assert found.unsolved == 0
    scenario, done = planned("path.points=120")
    assert scenario.robot is not None
    assert all(one.moves.unsolved == 0 for one in done.deflected)  # one of 120 before
