"""Corrections of a deburring pass, of drilled holes and of a machine's map: digits of the reference, and what is refused."""

import math

import numpy as np
import pytest

import cutwise
from cutwise.io.scenario import load
from cutwise.process import drilling, machine
from cutwise.process.assemble import deburring_cell
from cutwise.process.plateaus import feed_for, plateau_moment
from cutwise.programs.robot_moves import abc_of
from cutwise.spec.faults import ScenarioFault
from cutwise.study.correct import error_map, formats, robot_program

MM, UM = 1e-3, 1e-6
MAP = ["volume.points=5", "volume.diagonal_points=5"]


# feed [mm/s] that holds the spindle with the edge off by 0, -0.02 and -0.05 mm, by an independent program
LAW = {
    0.5: (181.160, 131.264, 92.434),
    0.7: (129.783, 102.366, 77.287),
    1.3: (70.536, 62.009, 52.155),
    1.5: (61.329, 54.901, 47.140),
}


@pytest.mark.parametrize("height", LAW)
def test_feed_of_the_plateau(examples, height):
    cell = deburring_cell(load(examples / "deburr_compliant_spindle.yaml"))
    assert plateau_moment(cell) / 0.15 == pytest.approx(12.478, abs=5e-4)
    found = [1e3 * feed_for(cell, height * MM, MM, e * MM, (1e-3, 1.0)) for e in (0.0, -0.02, -0.05)]
    assert found == pytest.approx(LAW[height], abs=2e-3)


@pytest.fixture(scope="module")
def edge(examples):
    return lambda *given: cutwise.correct(load(examples / "correct_deburr.yaml", list(given)))


# aim: time [s], least error [mm] (the greatest is the same but for the settling)
@pytest.mark.parametrize(
    ("aim", "time", "least"), [(-0.01, 1.479, -0.0072), (-0.02, 1.622, -0.0164), (-0.03, 1.768, -0.0255)]
)
def test_feed_along_the_burred_edge(edge, aim, time, least):
    found = edge(f"correct.aim={aim} mm", "correct.burr_scatter=null").measures
    assert found["time_after"].value == pytest.approx(time, abs=1e-3)
    assert found["edge_error_min_after"].value == pytest.approx(least * MM, abs=UM)
    assert found["edge_ideal_after"].value == pytest.approx(1.0, abs=5e-3)
    assert found["time_before"].value == pytest.approx(1.750, abs=1e-3)
    assert found["edge_error_min_before"].value == pytest.approx(-0.0397 * MM, abs=UM)
    assert found["edge_error_max_before"].value == pytest.approx(0.1625 * MM, abs=UM)
    assert found["edge_ideal_before"].value == pytest.approx(0.213, abs=5e-3)


@pytest.mark.parametrize(("scatter", "most"), [(0.1 / 1.6448536, -0.0093), (0.2 / 1.6448536, 0.0174)])
def test_a_higher_burr_is_told(edge, scatter, most):
    """Reference: aim -0.02 mm, burr times 1.1 and 1.2."""
    found = edge(f"correct.burr_scatter={scatter}").measures
    assert found["edge_error_max_p95"].value == pytest.approx(most * MM, abs=UM)


def test_the_more_a_burr_scatters_the_deeper_is_aimed(edge):
    aims = [
        edge("correct.aim=null", f"correct.burr_scatter={s}").measures["edge_error_aimed"].value
        for s in (0.02, 0.1, 0.13)
    ]
    assert aims == sorted(aims, reverse=True)
    assert aims[0] > aims[-1]


def test_a_pass_that_kept_its_tolerance_in_less_time_is_left_as_it_was(edge):
    """A feed that is corrected once more gains nothing, and says so."""
    again = cutwise.correct(edge().scenario, ("feed",))
    assert again.measures["time_saved"].value == pytest.approx(0.0, abs=1e-4)
    assert not again.good
    assert again.reasons[0].startswith("nothing is gained: the pass as it was keeps the tolerance with the burr")


def test_more_pressure_is_faster(edge):
    found = edge("correct.ranges={spindle.pressure: [5 bar, 6 bar]}")
    assert found.changes[0].key == "spindle.pressure"
    assert found.measures["time_after"].value < 1.5
    assert found.good


def test_the_feed_table_is_what_the_scenario_takes(edge, tmp_path, examples):
    found = edge()
    file = tmp_path / "feed.csv"
    file.write_text(formats.table(found))
    feed = found.scenario.operation.feed
    again = load(
        examples / "correct_deburr.yaml", [f"operation.feed={feed!r} m/s", f"operation.feed_profile={{table: {file}}}"]
    )
    assert again.operation.feed_profile.points() == found.scenario.operation.feed_profile.points()


def test_what_no_feed_corrects_is_refused(examples, edge):
    with pytest.raises(ScenarioFault, match="rigid spindle"):
        cutwise.correct(load(examples / "deburr_rigid_on_machine.yaml"), ("feed",))
    with pytest.raises(ScenarioFault, match="is no lever of change: feed here"):
        edge("correct.ranges={spindle.stroke: [1 mm, 2 mm]}")
    with pytest.raises(ScenarioFault, match="is read by nothing"):
        edge("correct.chord=1 mm")


POSTURES = {  # redundancy angle, joints near, errors before [µm], shift [µm], tilt [mrad]
    "stiffest": ("-138 deg", None, (19.334, 21.784), (-18.448, 5.751), (-0.4972, 0.0481)),
    "least skating": ("26 deg", "[-18 deg, 39 deg, -115 deg, 45 deg, 80 deg, -10 deg]", (1.021, 2.831), (-0.642, -0.795),
                      (-0.2345, -0.2764)),
}  # fmt: skip


@pytest.mark.parametrize("name", POSTURES)
def test_a_hole_is_where_it_is_wanted(examples, name):
    angle, joints, before, shift, tilt = POSTURES[name]
    given = [
        f"robot.redundancy_angle={angle}",
        "correct.vary=null",
        *([f"robot.joint_angles={joints}"] if joints else []),
    ]
    scenario = load(examples / "correct_drill.yaml", given)
    found = cutwise.correct(scenario)
    (led,) = found.scenario.hole.corrections
    for key, error in zip(("entry", "exit"), before, strict=True):
        assert found.before.measures[f"hole_position_error_{key}"].value == pytest.approx(error * UM, rel=1e-3)
        assert found.after.measures[f"hole_position_error_{key}"].value < 0.001 * UM
    assert np.array(led.shift) / UM == pytest.approx(shift, abs=0.003)
    assert np.array(led.tilt) / 1e-3 == pytest.approx(tilt, abs=2e-4)
    assert found.after.measures["perpendicularity_error"].value < 1e-7
    assert found.good


def test_the_pose_of_the_hole_in_krl(examples):
    """Reference: 1900.017558, 299.991930, 800, ABC 138, 0.028485, 179.997247."""
    found = cutwise.correct(load(examples / "correct_drill.yaml", ["correct.vary=null"]))
    program = robot_program.drilling(found.scenario)
    entry = program.moves[1]
    assert entry.pose.origin * 1e3 == pytest.approx([1900.017558, 299.991930, 800.0], abs=5e-6)
    assert abc_of(entry.pose.rotation) == pytest.approx([138.0, 0.028485, 179.997247], abs=2e-5)
    assert all(move.exact for move in program.moves)
    assert "C_DIS" not in formats.krl(found)
    place = drilling.drill_cell(found.scenario).arm
    assert place is not None


def test_draws_of_joints_thrust_and_friction(examples, tmp_path):
    """Reference: p80 of the entry error 22.28 to 4.75 µm."""
    from scipy.special import ndtri

    from unit.study.test_correct_path import radical_inverse

    scenario = load(examples / "correct_drill.yaml", ["correct.vary=null"])
    rows = []
    for n in range(1, 41):
        z = [ndtri(radical_inverse(n, base)) for base in (2, 3, 5, 7, 11, 13, 17, 19)]
        joints = [k * (1.0 + 0.1 * x) for k, x in zip(scenario.robot.joint_stiffness, z, strict=False)]
        rows.append([*joints, 650.0 * (1.0 + 0.15 * z[6]), 0.2 + 0.03 * z[7]])
    titles = [
        *(f"robot.joint_stiffness[{k}] [N m/rad]" for k in range(6)),
        "material.k_c11 [N/mm^2]",
        "contact.friction",
    ]
    file = tmp_path / "draws.csv"
    file.write_text("\n".join([", ".join(titles), *(", ".join(map(repr, map(float, row))) for row in rows), ""]))
    found = cutwise.correct(
        load(examples / "correct_drill.yaml", ["correct.vary=null", f"correct.draws={file}"])
    ).measures
    assert found["error_p80_before"].value == pytest.approx(22.28 * UM, abs=0.03 * UM)
    assert found["residual_p80"].value == pytest.approx(4.75 * UM, abs=0.03 * UM)


def test_corrections_have_to_fit_the_holes(examples):
    with pytest.raises(ScenarioFault, match="are 2 for 1 holes"):
        load(examples / "drill_robot.yaml", ["hole.corrections=[{}, {}]"])
    with pytest.raises(ScenarioFault, match="does not tilt its spindle"):
        load(examples / "drill_on_machine.yaml", ["hole.corrections=[{tilt: [1 mrad, 0 mrad]}]"])


def test_a_hole_is_led_in_the_branch_of_the_arm_that_it_is_drilled_in(examples):
    """A joint at its limit lets the tool be led no further; another branch is no correction."""
    scenario = load(examples / "drill_plate_pattern.yaml")
    first = scenario.model_copy(update={"hole": scenario.hole.model_copy(update={"pattern": None})})
    cell = drilling.drill_cell(first)
    hole = drilling.choose(first, cell, drilling.targets(scenario.hole)[0])[0]
    led = drilling.led(first, cell, drilling.targets(scenario.hole)[0], hole, drilling.Led((0.0, 0.0), (0.0, 1e-4)))
    assert led is None or np.abs(led.q - hole.q).max() < 0.01


def test_another_machine_runs_the_same_posture(examples):
    """A draw of a joint's stiffness makes another posture the best, which no program knows of."""
    from cutwise.study.correct import drill

    scenario = load(
        examples / "correct_drill.yaml", ["correct.vary=null", "robot.joint_angles=null", "robot.redundancy_angle=best"]
    )
    holes = drill.holes_of(scenario)
    draw = {"robot.joint_stiffness[0]": 0.2 * scenario.robot.joint_stiffness[0]}
    error = drill._drawn(scenario, holes, draw)[0]
    stiff = load(examples / "correct_drill.yaml", [
        "correct.vary=null", f"robot.redundancy_angle={holes[0].posture.angle!r} rad",
        f"robot.joint_angles={[f'{q!r} rad' for q in holes[0].posture.q.tolist()]}",
        f"robot.joint_stiffness[0]={draw['robot.joint_stiffness[0]']!r} N m/rad",
    ])  # fmt: skip
    assert error == pytest.approx(drill._errors(drilling.drill_cell(stiff), drill.holes_of(stiff)[0])[0], rel=1e-6)


def test_a_hole_on_a_machine_is_centred_without_a_tilt(examples):
    scenario = load(examples / "drill_on_machine.yaml", ["requirements=null"])
    found = cutwise.correct(scenario, ("offset",))
    (led,) = found.scenario.hole.corrections
    assert led.tilt == (0.0, 0.0)
    worst = max(found.after.measures[f"hole_position_error_{key}"].value for key in ("entry", "exit"))
    assert worst < max(found.before.measures[f"hole_position_error_{key}"].value for key in ("entry", "exit"))


def read_table(text):
    """Commands of the nodes [m], and what the table adds to them [m], shape (n, n, n, 3)."""
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    assert lines[0] == "x [mm], y [mm], z [mm], dx [um], dy [um], dz [um]"
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:] if line])
    assert rows[1, 0] > rows[0, 0], "x goes fastest"
    axes = [np.unique(rows[:, k]) / 1e3 for k in range(3)]
    n = len(axes[0])
    return axes, rows[:, 3:].reshape(n, n, n, 3).transpose(2, 1, 0, 3) * UM


def test_the_table_of_a_machine_takes_its_errors_off(examples):
    """Read from the text and added to the commands of its tables, which move against the tool, it leaves what is told."""
    from scipy.interpolate import RegularGridInterpolator

    scenario = load(examples / "machine_volumetric_map.yaml", [*MAP, "requirements=null"])
    found = cutwise.correct(scenario, ("offset",))
    axes, values = read_table(formats.table(found))
    assert [len(axis) for axis in axes] == [5, 5, 5]
    against = np.array([-1.0, -1.0, 1.0])  # X and Y move the part: where the tool goes in it by a command
    finer = scenario.model_copy(update={"volume": scenario.volume.model_copy(update={"points": 9})})
    whole = machine.evaluate_volume(finer)
    at = np.stack(np.meshgrid(*whole.at, indexing="ij"), axis=-1)
    left = float(np.linalg.norm(whole.error + against * RegularGridInterpolator(axes, values)(at), axis=-1).max())
    assert left == pytest.approx(found.measures["residual_max"].value, abs=2e-8)  # the error there, not where it leads
    nodes = machine.evaluate_volume(scenario)
    assert np.linalg.norm(nodes.error + against * values, axis=-1).max() < 2e-8
    assert any("keep so much room" in text for text in found.told)


def test_the_table_of_axes_that_are_askew(examples):
    """The commands that move the tool back, not its error: at the nodes nothing is left."""
    scenario = load(examples / "machine_five_axis.yaml", ["requirements=null", "volume.points=3"])
    table = scenario.volume.model_copy(update={"table_points": 3})
    found = machine.evaluate_volume(scenario.model_copy(update={"volume": table}))
    assert np.linalg.norm(machine.evaluate_volume(scenario).error, axis=-1).max() > 1e-5
    assert np.linalg.norm(found.error, axis=-1).max() < 1e-9


def test_a_machine_without_a_map_has_no_table(examples):
    with pytest.raises(ScenarioFault, match="covers the working space"):
        cutwise.correct(load(examples / "machine_error_budget.yaml", ["volume=null"]), ("offset",))


def test_languages_that_do_not_go_with_a_process(edge, examples):
    found = edge()
    with pytest.raises(ScenarioFault, match="does not go with process: deburr"):
        formats.krl(found)
    assert math.isfinite(found.measures["time_saved"].value)
    assert error_map.text(load(examples / "machine_volumetric_map.yaml", MAP)).startswith(
        "# cutwise: machine_volumetric_map"
    )
