"""Laws of the cell that hold for every combination: springs add, nothing changes nothing, shares sum, steps converge."""

import math

import numpy as np
import pytest

import cutwise
from cutwise.loop import march
from cutwise.maths.curves import no_cubic
from cutwise.physics.motion.edge import EdgePass
from cutwise.physics.structure.swings import natural_frequencies
from cutwise.physics.structure.terms import displacement, relaxed
from cutwise.process import (
    assemble,
    carried,
    chamfer,
    following,
    machine_assemble,
    machine_pass,
    milling,
    programmed_milling,
)
from cutwise.process import deburring as edge
from cutwise.process.arm_masses import mass_matrices
from cutwise.process.chain_compliance import parts_along
from cutwise.process.loops import run_compliant_edge
from cutwise.process.recipes import quick_outcome
from cutwise.stages import driven, moved

UM = 1e-6
FREE = "requirements={}"
SHORT = ("path.line.from=[1900 mm, -10 mm, 800 mm]", "path.line.to=[1900 mm, 10 mm, 800 mm]", FREE)
LINKS = ("robot.library=kr270_r2700_masses", "robot.dynamics=links")
FED = ("machine={library: demec_mill}", "numerics={mode: still}", FREE)
STEPPED = ("machine={library: demec_mill}", "numerics={force: averaged}", FREE)
DRIVEN = "machine={library: demec_mill, drives: {library: fadal2216, reading: kp_ki_swapped}}"


@pytest.fixture(scope="module")
def loaded(examples):
    return lambda name, *changes: cutwise.load(examples / f"{name}.yaml", list(changes))


def measured(scenario):
    return quick_outcome(scenario, coarse=False).measures


def modes(*stiffness):
    each = ", ".join(f"{{direction: y, frequency: 1 kHz, damping: 0.03, stiffness: {k} N/um}}" for k in stiffness)
    return f"tool.modes=[{each}]"


# --- milling as programmed


def test_each_body_gives_its_part_under_a_mill_that_goes_as_programmed(loaded):
    """Worked example 4d at rest, 75 mm along the wall."""
    done = programmed_milling.run(loaded("mill_on_machine", *FED), limits=False)
    row = int(np.argmin(np.abs(done.at - 75e-3)))
    parts = parts_along(done.carriage.bodies, done.path.at, done.at[row], done.height, done.moved["bodies"][row])
    assert {name: value / UM for name, value in parts.items()} == pytest.approx({
        "clamping": 0.49216, "x guide": 1.79404, "y guide": 3.03896, "column foot": 2.12037, "column beam": 0.38488,
        "z guide": 0.15142, "spindle": 0.88961, "part": 0.38429,
    }, abs=2e-5)  # fmt: skip
    assert done.moved["tip"][row, 1] / UM == pytest.approx(6.53148, abs=2e-5)
    assert done.moved["bodies"][row, 1] == pytest.approx(sum(parts.values()), rel=1e-12)


def test_time_steps_end_where_each_place_is_at_rest(loaded):
    changes = ("path.line.length=10 mm", "path.cut_from=0 mm")
    still = programmed_milling.run(loaded("mill_on_machine", *FED, *changes), limits=False)
    step = programmed_milling.run(loaded("mill_on_machine", *STEPPED, *changes), limits=False)
    at_rest = np.interp(step.at, still.at, still.moved["bodies"][:, 1])
    assert step.moved["bodies"][:, 1] == pytest.approx(at_rest, rel=2e-5)  # stations of 5 mm, straight between them


def test_two_springs_are_one_with_the_sum_of_their_compliances(loaded):
    base = ("mill_on_robot", *SHORT)
    one = measured(loaded(*base, modes(10)))
    two = measured(loaded(*base, modes(20), "part={stiffness: 20 N/um}"))
    assert two["wall_error_min"] == pytest.approx(one["wall_error_min"], rel=1e-9)
    assert two["share_tip"] == pytest.approx(two["share_part_stiffness"], rel=1e-9)
    edges = [("deburr_rigid_on_machine", "path.line.from=[-10 mm, -40 mm, 295 mm]", "path.line.to=[10 mm, -40 mm, 295 mm]",
              FREE, "tool.stiffness=null", "part.block=null", change) for change in (modes(10), modes(20, 20))]  # fmt: skip
    soft, both = (measured(loaded(*one)) for one in edges)
    assert both["surface_error_mean"] == pytest.approx(soft["surface_error_mean"], rel=1e-9)


@pytest.mark.parametrize("how", [FED, STEPPED, (*STEPPED[1:], DRIVEN)], ids=["still", "stepped", "drives"])
def test_shares_sum_to_the_error_of_the_wall(loaded, how):
    found = measured(loaded("mill_on_machine", *how, "path.line.length=10 mm", "path.cut_from=2 mm"))
    shares = sum(value for name, value in found.items() if name.startswith("share_"))
    worst = max(found["wall_error_min"], found["wall_error_max"], key=abs)
    assert -shares == pytest.approx(worst, rel=1e-12)


def test_bodies_that_do_not_yield_change_no_bit_of_a_programmed_wall(loaded):
    changes = ("path.line.length=10 mm", "path.cut_from=0 mm", "part=null", *STEPPED)
    scenario = loaded("mill_on_machine", *changes, modes(20))
    bare = scenario.machine.model_copy(
        update={"chain": tuple(body.model_copy(update={"elements": ()}) for body in scenario.machine.chain)}
    )
    turned = programmed_milling.run(scenario.model_copy(update={"machine": bare}), limits=False)
    nothing = turned.carriage._replace(terms=())
    alone = programmed_milling.carriage.in_series(scenario.tool, nothing)
    assert [name for name, _ in turned.terms] == ["tip", "bodies"]
    path, engaged = turned.path, programmed_milling._cell(scenario, alone[0][1])
    way = EdgePass(0.04, path.at[-1] / 0.04, 0.0, 0.0, 0.0, 4e-3, 0.0, 0.0, no_cubic())
    history = march(engaged._replace(motion=way), relaxed(alone[0][1]), duration=way.duration, time_step=20e-6, seen=3,
                    state=6, layers=1, contacts=1)  # fmt: skip
    np.testing.assert_array_equal(history.table[:, 6:12], turned.state[:, :6])
    np.testing.assert_array_equal(turned.state[:, 6:], 0.0)


def test_pistons_that_mill_converge_as_the_step_is_halved(loaded):
    scenario = loaded(
        "mill_on_robot", *SHORT, "spindle={library: berselli2016}", "numerics={force: averaged, time_step: 80 us}",
        "operation.radial_depth=2 mm", "operation.axial_depth=2 mm", "operation.lead_in_time=0.2 s",
    )  # fmt: skip
    wall = [programmed_milling.run(scenario, limits=False, finer=k).moved["pistons"][-1, 1] for k in (1, 2, 4)]
    assert abs(wall[0]) > 1e-6
    assert abs(wall[2] - wall[1]) < 0.75 * abs(wall[1] - wall[0]) + 1e-9


# --- an arm of links


def test_modes_and_limits_of_an_arm_of_links(loaded):
    """Section 8 and worked example 4b of the specification of the cell, middle of the path."""
    limits = {}
    for name, changes in {"down": (), "slot": ("operation.radial_depth=20 mm",),
                          "up": ("operation.milling=up", "path.work=left")}.items():  # fmt: skip
        scenario = loaded("mill_on_robot", *LINKS, FREE, *changes)
        _, carrying = programmed_milling.prepare(scenario)
        limits[name] = programmed_milling._limit(scenario, carrying, 30, 2.5e-3)
    frequency = natural_frequencies(carried.linked_arm(scenario.robot, carrying.arm))[30]
    assert frequency == pytest.approx([12.43890, 14.06410, 22.94425, 75.78300, 127.78842, 157.72667], abs=1e-5)
    assert {name: 1e3 * one.depth for name, one in limits.items()} == pytest.approx(
        {"down": 5.922477, "slot": 6.041076, "up": 22.87130}, rel=1e-6
    )
    assert [limits[name].frequency for name in ("down", "slot", "up")] == pytest.approx(
        [121.213, 131.802, 23.109], abs=1e-3
    )


def test_an_arm_of_links_comes_to_rest_where_its_joints_do(loaded):
    """Under a constant force and moment behind pistons: the moment is that about the tip, whatever the pivot."""
    scenario = loaded("mill_on_robot", *LINKS, FREE)
    _, carrying = programmed_milling.prepare(scenario)
    term = carried.linked_arm(scenario.robot, carrying.arm)._replace(pivot=0.15)
    state = relaxed(term)
    from cutwise.records import Load, Pose
    from cutwise.stages import stepped

    force, arm_of_force = np.array([30.0, 50.0, -20.0]), 0.15 - 2.5e-3
    total = np.array([*force, 0.0, arm_of_force * force[0], arm_of_force * force[1]])
    quick = term._replace(damper=term.damper * 20.0)
    for _ in range(20000):
        stepped(quick, state, Pose(0.0, 0.15, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), Load(np.zeros((1, 3)), total), 2e-4)
    wrench = np.array([*force, -2.5e-3 * force[1], 2.5e-3 * force[0], 0.0])
    assert state.twist == pytest.approx(carrying.arm.joints[30] @ wrench, rel=1e-6, abs=1e-12)
    assert displacement(term, state.twist[None], 0.0)[0] == pytest.approx(state.twist[:3])


def test_energy_of_an_arm_without_damping_stays(loaded):
    scenario = loaded("mill_on_robot", *LINKS, FREE)
    _, carrying = programmed_milling.prepare(scenario)
    arm = carrying.arm
    mass = mass_matrices(scenario.robot, arm.arm, arm.postures.q[[30]])[0]
    assert mass == pytest.approx(mass.T)
    assert np.linalg.eigvalsh(mass).min() > 0.0
    turn = np.linalg.solve(mass, np.diag(arm.arm.stiffness))
    assert np.sqrt(np.sort(np.linalg.eigvals(turn).real)) / (2 * math.pi) == pytest.approx(
        natural_frequencies(carried.linked_arm(scenario.robot, arm))[30], rel=1e-9
    )


# --- drives under any motion


def test_drives_follow_an_edge_as_they_follow_a_wall(loaded):
    """The drives of a wall and those of any motion are the same, without a force to the last nanometre of a nanometre."""
    scenario = loaded("mill_on_machine", "machine={library: fadal2216, reading: kp_ki_swapped}", "part=null", FREE,
                      "path.line.length=6 mm", "path.cut_from=1 mm", "numerics.force=none", "numerics.settling_time=0 s",
                      "tool.modes=[]")  # fmt: skip
    done = milling.run(scenario, 10)
    start, end = np.array([-0.1, -0.04, 0.0]), np.array([-0.1, -0.04, 0.0])
    end[:2] += 6e-3 * np.array([math.cos(math.pi / 6), math.sin(math.pi / 6)])
    turn = np.array([[math.cos(math.pi / 6), -0.5, 0.0], [0.5, math.cos(math.pi / 6), 0.0], [0.0, 0.0, 1.0]])
    fed = following.along_a_line(scenario.machine, "machine", start, end, 0.04, turn, 10)
    way = EdgePass(0.04, 6e-3 / 0.04, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, no_cubic())
    motion, step = fed.stepped(way, 1.0)
    from cutwise.records import Load

    rest = Load(np.zeros((1, 3)), np.zeros(6))
    for k in range(10 * (len(fed.pace) - 1)):
        driven(motion, moved(motion, k * step), rest, step)
    off = done.history.position - done.reference.point[:, :2]
    mine = (motion.position - motion.point[:, :2])[: len(off) - 1]
    assert np.abs(off).max() > 1e-6
    assert mine == pytest.approx(off[: len(mine)], abs=1e-15 + 1e-9 * np.abs(off).max())


def test_a_rigid_spindle_in_time_steps_leaves_the_edge_of_one_at_rest(loaded):
    base = ("deburr_on_robot", *SHORT, "spindle=rigid", "operation.preset=0.05 mm", "operation.lead_in_time=0.05 s")
    step, still = measured(loaded(*base)), measured(loaded(*base, "numerics={mode: still}"))
    assert step["surface_error_mean"] == pytest.approx(still["surface_error_mean"], abs=0.05 * UM)
    assert "stroke_margin" not in step
    assert "share_pistons" not in step


def test_an_edge_on_drives_converges_as_the_step_is_halved(loaded):
    scenario = loaded(
        "deburr_rigid_on_machine", "path.line.from=[-10 mm, -40 mm, 295 mm]", "path.line.to=[10 mm, -40 mm, 295 mm]",
        "operation.lead_in_time=0.05 s", FREE, "numerics={}", DRIVEN,
    )  # fmt: skip
    cell = assemble.deburring_cell(scenario)
    error = []
    for step in (100e-6, 50e-6, 25e-6):
        done = edge.evaluate(cell, run_compliant_edge(cell, step))
        error.append(done.error_at_tool[np.searchsorted(done.history.motion.time, 0.2)])
    assert abs(error[2] - error[1]) < 0.75 * abs(error[1] - error[0]) + 1e-9
    assert abs(error[2] - error[1]) < 0.1 * UM


# --- round edges


def test_an_arc_at_rest_is_the_same_for_a_tool_that_turns_and_one_that_does_not(loaded):
    """Springs that are alike in all directions of the plane know no attitude."""
    arc = ("deburr_arc", "path.arc.sweep=60 deg", FREE, "spindle=rigid", "operation.preset=0 mm", "numerics={mode: still}",
           "tool.stiffness=2 N/um", "part.stiffness=2 N/um")  # fmt: skip
    turns, stays = (measured(loaded(*arc, f"path.orientation={how}")) for how in ("follow", "fixed"))
    assert turns["surface_error_mean"] > 5 * UM
    assert stays["surface_error_mean"] == pytest.approx(turns["surface_error_mean"], rel=2e-3)  # drag along the edge
    for name in ("share_tip", "share_part_stiffness"):
        assert stays[name] == pytest.approx(turns[name], rel=2e-3)


def test_a_large_arc_on_a_machine_is_a_straight_edge(loaded):
    """Along x at its start: what the bodies give tends to that of the straight edge there."""
    common = (FREE, "tool.stiffness=null", "part.block=null", "numerics={mode: still, station: 5 mm}")
    line = loaded("deburr_rigid_on_machine", "path.line.from=[0 mm, -40 mm, 295 mm]", "path.line.to=[2 mm, -40 mm, 295 mm]",
                  *common)  # fmt: skip
    arc = loaded("deburr_rigid_on_machine", *common, "path={arc: {centre: [0 mm, -100040 mm, 295 mm], radius: 100 m, from: 90 deg, "
                 "sweep: 2e-5 rad}, tool_axis: [0, 0, -1]}")  # fmt: skip
    assert measured(arc)["share_bodies"] == pytest.approx(measured(line)["share_bodies"], rel=1e-4)


# --- a chamfer on springs


def test_a_chamfer_on_two_springs(loaded):
    base = ("chamfer_on_robot", "path.points=48", "robot=null", "placement=null", FREE)
    one, two = (measured(loaded(*base, change)) for change in (modes(5), modes(10, 10)))
    assert two["width_deflected_max"] == pytest.approx(one["width_deflected_max"], rel=1e-12)
    assert two["share_tip"] == pytest.approx(one["share_tip"], rel=1e-9)


def test_a_part_yields_off_its_chamfer_and_nowhere_else(loaded):
    scenario = loaded(
        "chamfer_on_robot", "path.points=48", "robot=null", "placement=null", FREE, "part.stiffness=2 N/um"
    )
    done = chamfer.run(scenario, wanted=frozenset())
    path, moves = done.paths[0], done.deflected[0].moves
    aside = moves.terms[0][1] - np.einsum("ij,ij->i", moves.terms[0][1], path.path.air)[:, None] * path.path.air
    assert np.abs(moves.terms[0][1]).max() > 0.05 * UM
    assert np.abs(aside).max() < 2e-2 * np.abs(moves.terms[0][1]).max()  # straight between stations


# --- a robot instead of a machine


@pytest.fixture(scope="module")
def robot_pass(loaded):
    scenario = loaded(
        "machine_error_budget", "machine=null", "uncertainty=null", "part=null", "load.force=[40 N, 60 N, -20 N]", FREE,
        "load.weights=false", "placement={origin: [1900 mm, 0 mm, 500 mm], rotation: [0 deg, 0 deg, 20 deg]}",
        "robot={library: kr270_r2700, redundancy_angle: 0 deg, base_compliance: [0.01 um/N, 0.02 um/N, 0.03 um/N], sag: ignored}",
        "path.points=[{X: -100 mm, Z: 300 mm}, {X: 100 mm, Y: 30 mm, Z: 300 mm}]",
    )  # fmt: skip
    cell = machine_assemble.machine_cell(scenario)
    return scenario, cell, machine_pass.run_pass(cell)


def test_a_robot_goes_where_the_pass_goes_and_yields_as_its_joints_do(robot_pass):
    _, cell, run = robot_pass
    assert run.ideal == pytest.approx(cell.way.point, abs=1e-12)
    arm, force = cell.arm, np.array([40.0, 60.0, -20.0])
    turn = np.array([[math.cos(a := math.radians(20)), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]])
    axes = turn.T @ arm.path.axes  # process axes in the part
    local = (arm.joints + arm.base)[:, :3, :3] @ np.einsum("mji,j->mi", axes, force)[:, :, None]
    assert run.deviation == pytest.approx((axes @ local)[:, :, 0], rel=1e-9, abs=1e-15)
    assert machine_pass.energy_balance(run) < 1e-12


def test_shares_of_the_joints_sum_to_the_largest_error(robot_pass):
    found = measured(robot_pass[0])
    shares = {name: value for name, value in found.items() if name.startswith("share_")}
    assert set(shares) == {"share_part", "share_base", *(f"share_joint_a{k}" for k in range(1, 7)), "share_spindle"}
    assert sum(shares.values()) == pytest.approx(found["deviation_norm_max"], rel=1e-12)
    assert shares["share_base"] > 0.0


# --- joints that cannot follow the feed

SLOW = "robot.joint_speed=[105 deg/s, 101 deg/s, 107 deg/s, 2 deg/s, 113 deg/s, 175 deg/s]"


@pytest.mark.parametrize("name", ["deburr_on_robot", "mill_on_robot", "chamfer_on_robot"])
def test_a_feed_that_joints_cannot_follow_is_lowered_where_that_is_asked_for(loaded, name):
    short = ("path.points=48", FREE) if name.startswith("chamfer") else SHORT
    fast = quick_outcome(loaded(name, *short, SLOW, *FEEDS.get(name, ())))
    slow = quick_outcome(loaded(name, *short, SLOW, *FEEDS.get(name, ()), "operation.limit_feed=true"))
    assert fast.measures["joint_speed_margin"] < -0.5
    assert fast.infeasible
    assert slow.measures["joint_speed_margin"] == pytest.approx(0.0, abs=1e-9)
    assert not slow.infeasible
    if "cycle_time" in slow.measures:
        assert slow.measures["cycle_time"] > 1.2 * fast.measures["cycle_time"]


FEEDS = {"mill_on_robot": ("operation.feed=80 mm/s",)}


def test_the_feed_changes_no_faster_than_the_joints_let_it(loaded):
    scenario = loaded(
        "mill_on_robot",
        FREE,
        SLOW,
        "operation.feed=80 mm/s",
        "operation.limit_feed=true",
        "robot.joint_acceleration=[9 deg/s^2, 9 deg/s^2, 9 deg/s^2, 2e-3 deg/s^2, 9 deg/s^2, 9 deg/s^2]",
    )
    path, carrying = programmed_milling.prepare(scenario)
    feeds = carried.feeds_along(carrying.arm, scenario.robot, 0.08)
    bare = scenario.robot.model_copy(update={"joint_acceleration": None})
    free = carried.feeds_along(carrying.arm, bare, 0.08)
    assert (feeds <= free * (1 + 1e-12)).all()
    assert (feeds < 0.999 * free).any()
    rates = np.abs(np.diff(carrying.arm.postures.q, axis=0) / np.diff(path.at)[:, None])
    gained = np.abs(np.diff(feeds**2)) / (2.0 * np.diff(path.at))
    assert (gained[:, None] * rates <= np.array(scenario.robot.joint_acceleration) * (1 + 1e-9)).all()
    pace = carried.pace_of(path.at, feeds, 0.08)
    assert np.diff(pace.pace).min() > 0.0
    assert pace.pace[-1] == pytest.approx(path.at[-1] / 0.08)


def test_weights_of_the_links_sag_as_the_specification_says(loaded):
    """Section 2 and 8 of the specification of the cell: middle of the path, y and z of its process axes [um]."""
    scenario = loaded(
        "machine_error_budget", "machine=null", "uncertainty=null", "part=null", "load={weights: true}", FREE,
        "placement={origin: [1900 mm, 0 mm, 800 mm]}", "material=null",
        "robot={library: kr270_r2700_masses, redundancy_angle: 0 deg, joint_angles: [6 deg, -82 deg, 117 deg, 10 deg, -35 deg, "
        "-8 deg]}", "path.points=[{Y: -150 mm}, {Y: 150 mm}]",
    )  # fmt: skip
    run = machine_pass.run_pass(machine_assemble.machine_cell(scenario))
    middle = run.cell.way.marks[1]
    assert run.deviation[middle, [0, 2]] / UM == pytest.approx([-694.593, -1769.550], abs=1e-3)
    assert machine_pass.energy_balance(run) < 1e-12


@pytest.mark.parametrize("carrier", ["machine", "robot"])
def test_a_part_that_yields_off_its_wall_leaves_force_over_stiffness_more(loaded, carrier, robot_pass):
    base = (
        robot_pass[0] if carrier == "robot" else loaded("machine_error_budget", "uncertainty=null", "part=null", FREE)
    )
    from cutwise.io.scenario import revised

    soft = revised(base, ["part={stiffness: 20 N/um}"])
    firm, yielding = (machine_pass.run_pass(machine_assemble.machine_cell(one)) for one in (base, soft))
    force = firm.cell.cut.force[0] @ np.array(base.surface.normal)
    more = np.tile(force / 20e6 * np.array(base.surface.normal), (len(firm.deviation), 1))
    assert yielding.deviation - firm.deviation == pytest.approx(more, rel=1e-9, abs=1e-15)
    assert machine_pass.energy_balance(yielding) < 1e-12
    with pytest.raises(cutwise.ScenarioFault, match=r"part\.stiffness is that off the wall"):
        revised(soft, ["surface=null"])
