"""A machine that mills with drives, bodies and tool tip in one loop: worked example 4d of the specification of the cell."""

import numpy as np
import pytest

import cutwise
from cutwise.io.scenario import revised
from cutwise.loop import Cell
from cutwise.physics.cutting.flute import Mill
from cutwise.physics.cutting.flutes import MeanFlutes
from cutwise.physics.engagement.burred_edge import Round
from cutwise.physics.engagement.shoulder import SEEN, Shoulder
from cutwise.physics.structure.series_compliance import in_axes, translation_at
from cutwise.physics.structure.terms import Compliance, displacement, in_series, relaxed, width
from cutwise.process import milling
from cutwise.process.chain_compliance import parts_along
from cutwise.process.edges import edges
from cutwise.process.milling_measures import measures
from cutwise.process.recipes import prepare
from cutwise.results import SolverFailure
from cutwise.spec.faults import dotted
from cutwise.still import rest

UM = 1e-6
SAMPLES = [828, 1278, 1903, 2403]  # next to 32, 50, 75 and 95 mm of the path
ELEMENTS = {
    "clamping": 0.49216, "x guide": 1.79404, "y guide": 3.03896, "column foot": 2.12037, "column beam": 0.38488,
    "z guide": 0.15142, "spindle": 0.88961, "part": 0.38429,
}  # fmt: skip


@pytest.fixture(scope="module")
def scenario(examples):
    return cutwise.load(examples / "mill_on_machine.yaml")


@pytest.fixture(scope="module")
def done(scenario):
    return milling.run(scenario, 10)


def test_drives_bodies_and_tip_have_the_digits_of_the_specification(done):
    at = done.reference.travelled[SAMPLES]
    assert at[0] == pytest.approx(31.988629e-3, abs=1e-9)
    yields = sum(done.wall.moved.values())[SAMPLES] / UM
    assert done.wall.drives[SAMPLES, 1] / UM == pytest.approx([0.626092, 0.022385, 0.000231, 0.000013], abs=1e-4)
    assert yields[:, 1] == pytest.approx([15.904144, 15.843798, 15.787205, 15.767286], abs=1e-4)
    assert yields[:, 2] == pytest.approx([-1.709780, -1.825296, -1.989305, -2.123785], abs=1e-4)
    assert done.wall.wall[SAMPLES] / UM == pytest.approx([-16.530236, -15.866183, -15.787436, -15.767299], abs=1e-4)


def test_the_wall_is_worst_where_the_drives_brake(scenario, done):
    worst = done.wall.worst
    assert worst == 2543
    assert done.wall.drives[worst, 1] / UM == pytest.approx(10.6148, abs=1e-4)
    found = measures(scenario, done)
    assert found["wall_error_min"] / UM == pytest.approx(-20.3932, abs=1e-3)
    assert found["cycle_time"] == pytest.approx(2.5565685425, abs=1e-10)
    shares = found["share_drives"] + found["share_bodies"] + found["share_tip"]
    assert shares == pytest.approx(-found["wall_error_min"], abs=1e-15)


def test_forty_substeps_move_the_wall_by_two_nanometres(scenario, done):
    finer = milling.run(scenario, 40)
    assert np.abs(finer.wall.wall - done.wall.wall)[SAMPLES].max() < 0.002 * UM


def test_each_body_gives_its_part_at_rest(scenario, done):
    bodies, path = done.wall.bodies, done.wall.path
    total = translation_at(bodies.total, 2.5e-3)[15]  # at 75 mm
    assert total[1, 1] / UM + _tip(path)[0, 1, 1] / UM == pytest.approx(0.124184, abs=1e-6)
    assert total[1, 2] / UM == pytest.approx(-0.008784, abs=1e-6)
    terms = [Compliance(path.at, bodies.total), Compliance(np.zeros(1), _tip(path))]
    structure = in_series(terms)
    speed = scenario.operation.spindle_speed
    mill = Mill(10e-3, 3, scenario.tool.helix)
    flutes = MeanFlutes(mill, edges(scenario.material, scenario.tool), speed, False)
    pose = np.zeros((1, 8))
    pose[0, [1, 3, 5]] = 75e-3, -4e-3, 40e-3
    cell = Cell((), Shoulder(Round(10e-3, 3, speed), 5e-3), (), flutes, structure)
    still = rest(cell, relaxed(structure), pose, seen=SEEN, state=width(structure))
    force = still.total[0, :3]
    each = [float((one @ force)[1]) / UM for one in translation_at(bodies.each[:, 15], 2.5e-3)]
    assert dict(zip(bodies.names, each, strict=True)) == pytest.approx(ELEMENTS, abs=2e-5)
    assert (displacement(terms[1], still.state[:, 6:], 2.5e-3)[0, 1]) / UM == pytest.approx(6.53148, abs=2e-5)
    wall = done.wall
    along = parts_along(wall.bodies, path.at, done.reference.travelled[1903], wall.height, wall.moved["bodies"][1903])
    assert np.array(list(along.values())) / UM == pytest.approx(each, abs=2e-4)  # 11 µm before
    assert sum(along.values()) == pytest.approx(done.wall.moved["bodies"][1903, 1], abs=1e-15)


def _tip(path):
    matrix = np.zeros((6, 6))
    matrix[0, 0], matrix[1, 1] = 1 / 18e6, 1 / 20e6
    return in_axes(matrix, path.axes[:1])


def test_bodies_that_do_not_yield_change_no_bit(scenario):
    bare = scenario.machine.model_copy(
        update={"chain": tuple(body.model_copy(update={"elements": ()}) for body in scenario.machine.chain)}
    )
    rigid = {"part": None, "tool": scenario.tool.model_copy(update={"modes": ()})}
    with_chain = milling.run(scenario.model_copy(update={**rigid, "machine": bare}), 10)
    alone = milling.run(scenario.model_copy(update={**rigid, "machine": scenario.machine.drives}), 10)
    assert alone.wall.bodies is None
    assert np.array_equal(with_chain.history.position, alone.history.position)
    assert np.array_equal(with_chain.wall.wall, alone.wall.wall)


def test_drives_alone_have_the_digits_of_the_specification(scenario):
    rigid = {"part": None, "machine": scenario.machine.drives}
    alone = milling.run(scenario.model_copy(update=rigid), 10)
    off = alone.wall.drives[:, 1] / UM
    assert off[SAMPLES] == pytest.approx([0.628200, 0.022451, 0.000223, 0.000006], abs=1e-6)
    assert np.abs(off[alone.wall.counted]).max() == pytest.approx(10.825868, abs=1e-6)
    assert int(np.argmax(np.where(alone.wall.counted, off, 0.0))) == 2546


def test_an_axis_at_rest_stays_exactly_put_and_a_note_says_so(scenario):
    level = revised(scenario, ["path={line: {from: [-100 mm, -40 mm], to: [0 mm, -40 mm]}, cut_from: 30 mm}"])
    result = cutwise.simulate(level)
    actual = result["motion"]["actual"].values
    assert np.ptp(actual[:, 1]) == 0.0
    assert "turns it with 0.208 N·m, friction holds 2.63 N·m" in result.notes["standing_y"]
    assert "standing_x" not in result.notes


def test_up_milling_has_the_work_on_the_left(scenario):
    """The force is that of the same shoulder milled up by a robot (example 4b), which yields a little more."""
    up = milling.run(revised(scenario, ["operation.milling=up", "path.work=left"]), 10)
    axes, force = up.wall.path.axes[0], up.history.force[SAMPLES[2]]
    assert axes[:, 1] == pytest.approx([0.5, -np.cos(np.pi / 6), 0.0])
    assert force @ axes == pytest.approx([-147.1, -3.9, -22.9], abs=2.5)
    assert up.wall.moved["tip"][SAMPLES[2]] @ [1, 0, 0] < -7 * UM
    assert measures(scenario, up)["engagement_angle_straight"] == pytest.approx(np.arccos(0.6))


def test_a_slot_has_two_walls(scenario):
    run = milling.run(revised(scenario, ["operation.radial_depth=20 mm", "operation.axial_depth=2 mm"]), 10)
    found = measures(scenario, run)
    assert found["wall_error_max"] == -found["wall_error_min"] == np.abs(run.wall.wall[run.wall.counted]).max()
    assert found["wall_error_max"] > 20 * UM


def test_teeth_one_by_one_have_the_mean_of_the_average(scenario, done):
    """Rigid mill, tooth by tooth beside the bodies: the mean over a tooth period is that of the averaged force."""
    teeth = milling.run(revised(scenario, ["numerics.force=tooth_resolved", "tool.modes=[]"]), 40)
    part = slice(1300, 1700)
    assert teeth.history.force[part].mean(axis=0) == pytest.approx(done.history.force[part].mean(axis=0), rel=0.02)
    assert teeth.history.force_peak[part, 3].max() > 2.0 * done.history.force_peak[part, 3].max()


def test_a_machine_too_soft_for_its_cut_is_told(scenario):
    modes = tuple(mode.model_copy(update={"stiffness": 1.0}) for mode in scenario.tool.modes)
    soft = scenario.model_copy(update={"tool": scenario.tool.model_copy(update={"modes": modes})})
    with pytest.raises(SolverFailure, match="too soft for this cut"):
        milling.run(soft, 10)


def test_keys_of_the_drives_may_stand_in_the_machine(examples, scenario):
    short = [
        "machine={library: demec_mill, reading: as_printed, limits: {jerk: 20 m/s^3}, drives: {library: fadal2216}}"
    ]
    found = cutwise.load(examples / "mill_on_machine.yaml", short)
    assert (found.drives.reading, found.drives.limits.jerk) == ("as_printed", 20.0)
    assert found.drives.limits.acceleration == scenario.drives.limits.acceleration
    assert found.origins["machine.drives.limits.jerk"].status == "user"
    twice = ["machine={library: demec_mill, reading: as_printed, drives: {library: fadal2216, reading: matched}}"]
    with pytest.raises(cutwise.ScenarioFault, match=r"is written as drives.reading too"):
        cutwise.load(examples / "mill_on_machine.yaml", twice)


def test_a_run_can_be_read_back(scenario):
    again = revised(scenario, [])
    assert again == scenario
    assert again.origins == scenario.origins


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (["path.work=left"], "path.work: left contradicts operation.milling"),
        (
            ["machine={library: demec_mill}", "numerics={}"],
            "numerics.mode: a machine without drives is computed at rest, or stepped",
        ),
        (["numerics.force=tooth_resolved"], "numerics.force: tooth_resolved steps the modes"),
        (["path.line.length=400 mm"], "path.line: leads axis X to 376.41 mm"),
        (["path.cut_from=100 mm"], "path.cut_from: is not before the end"),
        (["load.weights=true"], "load.weights: true is for process: machine"),
        (["path={corner: sharp}"], "path: bodies of a machine yield along a straight wall"),
        (["path.line.to=[0 mm, 0 mm]"], "path.line.angle: says where the line ends"),
        (
            [
                "machine={library: fadal2216}",
                "part=null",
                "numerics.force=tooth_resolved",
                "operation.milling=up",
                "path.work=left",
            ],
            "operation.milling: up is not covered for a tip that swings",
        ),
        (["path.tool_axis=[0, 0, 1]"], "path.tool_axis: leans"),
        (["machine.tip=null"], "machine.tip: missing"),
        (["robot={library: kr270_r2700}"], "robot: the tool has one carrier"),
        (["machine={library: fadal2216}"], "part: yields with the bodies of a machine"),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else "",
)
def test_what_cannot_be_is_refused_in_words(examples, changes, words):
    with pytest.raises(cutwise.ScenarioFault) as caught:
        prepare(cutwise.load(examples / "mill_on_machine.yaml", changes))
    assert any(f"{dotted(one.path)}: {one.message}".startswith(words) for one in caught.value.faults)
